"""What is connected with one cycle, on maps that are solved by hand."""

import math

import networkx as nx
import numpy as np
import numpy.typing as npt
import pytest
import sympy
from diagrams import (
    FIXED,
    LOCATED,
    assert_graph,
    assert_places,
    assert_sound,
    chain,
    notes,
    points_of,
)
from maps import (
    continued,
    fold,
    grazing,
    island,
    logistic_pair,
    lost_beyond,
    renamed_logistic,
    two_lines,
)
from sympy import Piecewise, symbols

import woodpecker.search.tasks as tasks
from pwmap.diagrams.diagram import Diagram
from woodpecker import (
    PiecewiseMap,
    continuation,
    from_sympy,
    shoot,
)
from woodpecker.base.settings import Settings
from woodpecker.maps.formulas import NOWHERE
from woodpecker.search import Stage
from woodpecker.search.diagrams import cycle_near


def explored(map_: PiecewiseMap, x: npt.ArrayLike, p: float, span: tuple[float, float]) -> Diagram:
    """The diagram, which is sound whatever it shows."""
    settings = Settings(span=span)
    found = continued(map_, x, p, settings)
    assert_sound(found, settings)
    return found


# --- Jumps between fixed points -------------------------------------------------------------------


def test_a_multiplier_that_is_minus_one_all_along_has_no_flips() -> None:
    """The slopes p and -1/p of a cycle of two points have the product -1 for every p."""
    x, p = symbols("x p")
    map_ = from_sympy(Piecewise((p * x + 1, x <= 0), (1 - x / p, True)), x, p)
    found = continuation(map_, shoot(map_, -0.45, p=0.5, order=2), "p", (0.2, 0.9))
    assert {str(point.kind) for point in found.points} == {"EP"}


# --- Continuous borders ---------------------------------------------------------------------------


def test_a_change_of_name_alone_is_a_mark() -> None:
    """The logistic map's pair passes the border at 1/2 at p = 1 + sqrt(5), in its lower point."""
    for first in (0, 1):
        x = np.roll(logistic_pair(3.1), -first)
        diagram = explored(renamed_logistic(0.5), x, 3.1, (3.05, 3.4))
        assert_graph(diagram, nx.disjoint_union(chain("EP F EP"), chain("EP F EP")))
        for branch in diagram.branches:
            (change,) = branch.changes
            assert branch.parameter[change.first] == pytest.approx(
                1.0 + math.sqrt(5.0), abs=LOCATED
            )
            other = "L | R" if first == 0 else "R | L"
            assert [stretch.word for stretch in branch.words] == ["R | R", other]


@pytest.mark.parametrize(("x", "p"), [(-0.5, -0.25), ((math.sqrt(2.0) - 1.0) ** 2, 0.5)])
def test_a_grazing_towards_its_root_and_from_it(x: float, p: float) -> None:
    """x/2 + p - sqrt(x): s = -1 + sqrt(1 + 2 p), x = s^2; it flips at s = 1/3."""
    diagram = explored(grazing(-1.0), x, p, (-1.0, 1.0))
    assert_graph(diagram, chain("EP F BC F PD F EP"))
    end = (math.sqrt(3.0) - 1.0) ** 2
    assert_places(
        diagram,
        {"BC": [(0.0, 0.0)], "PD": [(7 / 18, 1 / 9)], "EP": [(-1.0, -2.0), (1.0, end)]},
    )
    assert notes(diagram, "BC") == ["persistence"]
    (flip,) = points_of(diagram, "PD")
    for branch in diagram.branches:
        middle = float(branch.parameter[len(branch) // 2])
        assert bool(branch.stable[len(branch) // 2]) == (middle < 0.0 or middle > flip.parameter)
        for at, found in zip(branch.parameter.tolist(), branch.x.tolist(), strict=True):
            exact = (math.sqrt(1.0 + 2.0 * at) - 1.0) ** 2 if at >= 0.0 else 2.0 * at
            assert found == pytest.approx(exact, abs=1e-8)


def test_a_branch_goes_on_past_a_spike_of_rounding() -> None:
    """-0.87 x + p - 1e-6 sqrt(x): it flips at sqrt(x) = 1e-6/0.26, at a distance of 1e-11."""
    x, p = symbols("x p")
    line = -0.87 * x + p
    map_ = from_sympy(Piecewise((line - 1e-6 * sympy.sqrt(x), x > 0), (line, True)), x, p)
    diagram = continued(map_, 0.3, 0.561, Settings(span=(-1.0, 1.0), window=(-1.0, 1.0)))
    (flip,) = points_of(diagram, "PD")
    s = 1e-6 / 0.26
    assert flip.parameter == pytest.approx(1.87 * s**2 + 1e-6 * s, abs=1e-15)
    assert len(flip.branches) == 2
    assert sorted(point.parameter for point in points_of(diagram, "EP")) == [-1.0, 1.0]


@pytest.mark.parametrize("x", [-0.5, (1.0 + math.sqrt(0.5)) ** 2])
def test_a_grazing_that_folds(x: float) -> None:
    """x/2 + p + sqrt(x): back to p < 0 with slope +inf, round the fold at (-1/2, 1), and on."""
    diagram = explored(grazing(1.0), x, -0.25, (-1.0, 1.0))
    assert_graph(diagram, chain("EP F BC F LP F EP"))
    end = (1.0 + math.sqrt(3.0)) ** 2
    assert_places(
        diagram, {"BC": [(0.0, 0.0)], "LP": [(-0.5, 1.0)], "EP": [(-1.0, -2.0), (1.0, end)]}
    )
    assert notes(diagram, "BC") == ["fold"]


@pytest.mark.parametrize(("alpha", "m"), [(0.2, 6), (0.5, 10)])
def test_a_cycle_grazes_at_a_root_that_holds_it_close_to_the_border(alpha: float, m: int) -> None:
    """With one impact in m steps, s^2 + alpha^(m-1) s = c p, until it grazes where s^2 = p.

    The cycle with two impacts that goes back from there is as far from the border as 1e-9 times the
    square of the distance in p, both in units of the window.
    """
    x, p = symbols("x p")
    grazes = Piecewise((alpha * x + p, x <= 0), (p - sympy.sqrt(x), True))
    map_ = from_sympy(grazes, x, p, words=("L", "R"))
    a, c = alpha ** (m - 1), (1.0 - alpha**m) / (1.0 - alpha)
    border = (alpha ** (m - 2) * (1.0 - alpha) / (1.0 - a)) ** 2
    at, size = 0.5 * border, 4.0 * math.sqrt(1.5 * border)
    points = [(0.5 * (math.sqrt(a * a + 4.0 * c * at) - a)) ** 2]
    while len(points) < m:
        points.append(map_.at(points[-1], at).value)
    settings = Settings(span=(0.4 * border, 1.5 * border), window=(-size, size))  # no flip
    diagram = continued(map_, points, at, settings)
    grazings = points_of(diagram, "BC")
    assert [point.parameter for point in grazings] == pytest.approx(m * [border], rel=1e-12)
    assert notes(diagram, "BC") == m * ["fold"]
    impacts = [branch.word.count("R") for branch in diagram.branches]
    assert sorted(impacts) == m * [1] + m * [2]


def test_a_fall_ends_a_branch() -> None:
    diagram = explored(lost_beyond(1.0), 0.0, 0.0, (-1.0, 1.0))
    assert_graph(diagram, chain("EP F FALL"))
    assert_places(diagram, {"EP": [(-1.0, -2.0)], "FALL": [(0.5, 1.0)]})
    assert notes(diagram, "FALL") == [NOWHERE]


# --- Smooth maps ----------------------------------------------------------------------------------


@pytest.mark.parametrize("radius", [0.05, 0.3])
def test_an_island_is_drawn_once(radius: float) -> None:
    """Two folds, and the circle covered once, wherever it is cut besides."""
    diagram = explored(island(-0.5, 0.5, radius), -0.5 + radius, 0.5, (-2.0, 2.0))
    folds = points_of(diagram, "LP")
    expected = [0.5 - radius, 0.5 + radius]
    assert [point.parameter for point in folds] == pytest.approx(expected, abs=LOCATED)
    assert all(len(point.branches) == 2 for point in folds)
    length = 0.0
    for branch in diagram.branches:
        away = np.hypot(branch.x + 0.5, branch.parameter - 0.5)
        assert away == pytest.approx(radius, abs=LOCATED / radius)
        length += float(np.hypot(np.diff(branch.parameter), np.diff(branch.x)).sum())
    # neighbouring tangents differ by 0.1 at most in scaled units, a quarter of p and x itself: by
    # some 0.4 here; chords of such arcs are short by 0.4^2/24
    assert length == pytest.approx(2.0 * math.pi * radius, rel=0.01)


def test_flips_of_an_island() -> None:
    """With radius 1.2 the multiplier is -1 at x - x_0 = 1, p - p_0 = +-sqrt(0.44)."""
    diagram = explored(island(0.0, 0.0, 1.2), 1.2, 0.0, (-2.0, 2.0))
    side = math.sqrt(0.44)
    assert_places(diagram, {"PD": [(-side, 1.0), (side, 1.0)], "LP": [(-1.2, 0.0), (1.2, 0.0)]})
    ring = chain("PD F LP F LP F PD")
    ring.add_edge(0, 3, kind=str(FIXED))
    assert_graph(diagram, ring)


# --- Names and arguments --------------------------------------------------------------------------


def test_names_and_progress_are_passed_on() -> None:
    seen: list[Stage] = []
    diagram = continued(
        two_lines(), -1.0, -0.5, Settings(span=(-2.0, 2.0)), parameter="mu", progress=seen.append
    )
    assert (diagram.parameter_name, diagram.x_name) == ("mu", "x")
    assert [stage.branches for stage in seen] == [0, 1, 2, 3]  # before the first, and with each
    assert {stage.order for stage in seen} == {1}


def test_a_guess_must_lead_to_a_cycle() -> None:
    """x + p - x^2 has no fixed point at p < 0."""
    with pytest.raises(ValueError, match=r"a guess near a cycle of the map at -0.1, got 0.5"):
        cycle_near(fold(), 0.5, -0.1, Settings())


@pytest.mark.parametrize("span", [(0.0, 0.5), (0.5, 1.0)])
def test_a_branch_ends_with_its_span_where_a_border_lies_right_there(
    span: tuple[float, float],
) -> None:
    """x/2 + p for p < 1/2 and x/3 + p beyond: at p = 1/2 the map takes the second piece."""
    x, p = sympy.symbols("x p")
    map_ = from_sympy(sympy.Piecewise((x / 2 + p, p < 0.5), (x / 3 + p, True)), x, p)
    settings, start = Settings(span=span, window=(-4.0, 4.0)), sum(span) / 2.0
    found = continuation(map_, shoot(map_, 0.5, p=start), settings=settings).points
    assert [(point.kind, point.parameter) for point in found] == [("EP", each) for each in span]
    assert {point.note for point in found} == {"end of the parameter span"}


@pytest.mark.parametrize("p0", [2.9, 3.0])
def test_a_start_at_a_flip_hides_neither_the_flip_nor_what_starts_there(p0: float) -> None:
    """The logistic map's fixed point 1 - 1/p flips at p = 3."""
    x, p = symbols("x p")
    map_ = from_sympy(p * x * (1 - x), x, p)
    found = continued(map_, 1.0 - 1.0 / p0, p0, Settings(span=(2.5, 3.3)), orders=(1, 2))
    (flip,) = points_of(found, "PD")
    assert (flip.parameter, flip.x) == pytest.approx((3.0, 2 / 3), abs=LOCATED)
    assert len(flip.branches) == 4
    assert sorted(branch.order for branch in found.branches) == [1, 1, 2, 2]


def test_a_branch_begins_anew_a_few_times_at_most(monkeypatch: pytest.MonkeyPatch) -> None:
    """Were every sample of it special, it would still be followed both ways from one of them."""
    asked = list[object]()
    monkeypatch.setattr(tasks, "begins_at_special", lambda *samples: asked.append(samples) or True)
    found = continued(fold(), -0.3, 0.09, Settings(span=(-1.0, 0.25), window=(-2.0, 2.0)))
    assert_places(found, {"LP": [(0.0, 0.0)], "EP": [(0.25, -0.5), (0.25, 0.5)]})
    assert len(asked) == tasks.MOST_SHIFTS
