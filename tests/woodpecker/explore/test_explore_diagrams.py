"""Diagrams as arrays, in another process, and where names stand; no browser."""

import time
from typing import Any

import numpy as np
import pytest

from pwmap import PiecewiseLinearMap, bifurcation_diagram
from woodpecker import Toy

pytest.importorskip("bokeh")
from bokeh.models import Range1d

from pwmap.explore import diagram_views
from pwmap.explore.diagram_views import diagram_figure, fit, graph_figure, place
from pwmap.explore.diagrams import nearest_line, nearest_sample, shown, style_of
from pwmap.explore.figures import DASHES, keep_in, patch, tables_of
from pwmap.explore.jobs import Job, nothing
from pwmap.plot.drawn import stairs
from pwmap.plot.palette import PERIODS
from woodpecker.explore.branches import diagram, key_of
from woodpecker.explore.state import PageState


def lines() -> Any:
    map_ = PiecewiseLinearMap.from_sympy("Piecewise((p + x/2, x <= 0), (p - 1 + x/3, True))")
    return bifurcation_diagram(map_, "p", (-1, 2), orders=(1,))


def test_a_diagram_becomes_lines_samples_points_and_a_graph() -> None:
    found = shown(lines()).tables
    assert found["lines"]["branch"] == ["F1", "J1", "F2"]
    assert found["lines"]["dash"] == [[], [2, 3], []]
    assert found["points"]["kind"][1] == "border collision, persistence"
    assert found["points"]["where"][1] == "0"  # exact
    assert found["samples"]["multiplier"][0] == "0.5"
    assert len(found["edges"]["xs"]) == 3
    places = found["nodes"]["x"]
    assert places == sorted(places)  # left is left, as in the diagram
    assert places[0] >= 0.0


def test_a_period_has_its_colour_and_stability_its_dashes() -> None:
    """As in pictures of plot_diagram: here is the map of the README, with jump crossings of P_2."""
    map_ = PiecewiseLinearMap.from_sympy("Piecewise((r - 2, x <= 0), (r - 5*x/4, True))")
    made = shown(bifurcation_diagram(map_, "r", (-1, 4), orders=(1, 2)))
    orders = [branch.order for branch in made.diagram.branches]
    assert {*orders} == {1, 2}
    for name in ("lines", "edges"):
        table = made.tables[name]
        drawn = [made.diagram.branch(each) for each in table["branch"]]
        assert table["color"] == [PERIODS[branch.order - 1] for branch in drawn]
        dashes = [DASHES[style_of(branch, len(branch) // 2)] for branch in drawn]
        assert table["dash"] == dashes
        assert len({*map(str, dashes)}) == 3  # solid, dashed and dotted


@pytest.mark.slow
def test_a_branch_may_go_to_infinity() -> None:
    """The fixed point a/(a + 1) of the tent map at a = -1."""
    tent = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
    found = shown(bifurcation_diagram(tent, "a", (-2, 2), orders=(1,))).tables
    assert not np.isfinite(found["points"]["y"]).all()
    assert np.isfinite(found["nodes"]["y"]).all()
    figure = diagram_figure("x")
    fit(figure, found["samples"])
    assert np.isfinite([figure.y_range.start, figure.y_range.end]).all()


def test_the_nearest_branch_and_its_sample() -> None:
    found = shown(lines())
    name, away = nearest_line(found.tables["lines"], -0.5, -0.98, (100.0, 100.0))
    assert name == "F1"  # x = 2 p there
    assert away == pytest.approx(2.0 / np.sqrt(5.0), abs=1e-9)  # px, from a line of slope 2
    branch = found.diagram.branch("F1")
    k = nearest_sample(branch, -1.0, -2.0, (1.0, 1.0))
    assert branch.parameter[k] == -1.0


def test_names_cover_neither_names_nor_the_frame() -> None:
    rng = np.random.default_rng(3)
    points = rng.uniform(0.0, 300.0, (40, 2))
    texts = [f"BC{k}" for k in range(40)]
    found = place(texts, points, (300.0, 300.0), [k < 2 for k in range(40)])
    rows, dx, dy = map(list, zip(*found, strict=True))
    assert {0, 1} <= set(rows)
    middles = points[rows] + np.column_stack([dx, dy])
    half = np.array([[3.5 * len(texts[k]), 6.5] for k in rows])
    for i in range(len(middles)):
        for j in range(i):
            assert (np.abs(middles[i] - middles[j]) >= half[i] + half[j] - 1e-9).any()


def test_a_cobweb_goes_to_the_map_and_to_the_diagonal() -> None:
    x, y = stairs([1.0, 3.0, 2.0])
    assert x.tolist() == [1.0, 1.0, 3.0, 3.0, 2.0]
    assert y.tolist() == [1.0, 3.0, 3.0, 2.0, 2.0]


def test_a_diagram_does_not_depend_on_where_its_parameter_is() -> None:
    a, b = PageState(toy=Toy(eps_n1=0.3)), PageState(toy=Toy(eps_n1=0.4))
    assert key_of(a) == key_of(b)
    assert key_of(a) != key_of(PageState(toy=Toy(mu_2=0.31)))


@pytest.mark.slow
def test_branches_are_told_as_they_are_found() -> None:
    stages = list(diagram(PageState(span=(0.1, 0.7))))
    assert all(each.message for each in stages[:-1])
    assert not stages[-1].message
    counts = [len(each.diagram.branches) for each in stages]
    assert counts == sorted(counts)
    assert counts[-1] == 6
    names = [point.name for point in stages[-1].diagram.points if point.name]
    assert sorted(names) == ["A", "B", "C"]


def fails(sentence: str) -> Any:
    yield 1
    raise ValueError(sentence)


def sleeps() -> Any:
    yield 1
    time.sleep(100)


def results(job: Job) -> tuple[list[Any], str]:
    found = []
    while not job.is_over:
        found += job.results()
        time.sleep(0.01)
    return found, job.sentence


@pytest.mark.slow
def test_jobs_end_with_their_error_or_their_time() -> None:
    assert results(Job(fails, "no such map")) == ([1], "no such map")
    assert results(Job(sleeps, seconds=2.0))[1] == "given up after 2 s, as long as allowed"
    job = Job(sleeps)
    job.stop()
    job.stop()
    assert job.results() == []
    assert results(Job(nothing)) == ([None], "")


def test_names_are_placed_anew_when_a_view_is_resized(monkeypatch: pytest.MonkeyPatch) -> None:
    """In a small picture there is no room for all of them."""
    figure = graph_figure()
    tables = tables_of([figure])
    for name in ("edges", "nodes"):
        patch(tables[name], **shown(lines()).tables[name])
    assert set(tables["tags"].data["text"]) == {"F1", "J1", "F2"}
    monkeypatch.setattr(diagram_views, "_size", lambda _: (30.0, 25.0))
    figure.trigger("inner_width", 520, 30)  # as when the page has told it
    assert len(tables["tags"].data["text"]) < 3


def test_an_axis_has_room_while_a_slider_moves() -> None:
    """It is moved once for several steps; at rest it fits."""
    axis = Range1d(0.0, 1.0)
    ends = []
    for high in (1.02, 1.05, 1.1, 0.9):
        keep_in(axis, 0.0, high, moving=True)
        ends.append((axis.start, axis.end))
    assert ends == [(0.0, pytest.approx(1.02 * 1.15))] * 4
    keep_in(axis, 0.0, 0.4, moving=True)  # less than 0.6 of it
    assert (axis.start, axis.end) == (0.0, 0.4)
    keep_in(axis, 0.1, 0.4, moving=False)
    assert (axis.start, axis.end) == (0.1, 0.4)
