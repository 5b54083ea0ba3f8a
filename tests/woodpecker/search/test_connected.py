"""What hangs together with one cycle, on maps that are solved by hand."""

import math

import networkx as nx
import numpy as np
import numpy.typing as npt
import pytest
import sympy
from diagrams import (
    FIXED,
    JUMP,
    LOCATED,
    assert_curve,
    assert_graph,
    assert_places,
    assert_sound,
    chain,
    notes,
    of_kind,
    places,
    points_of,
)
from maps import (
    BORDER,
    A,
    Line,
    continued,
    everything,
    fold,
    grazing,
    island,
    lines,
    logistic,
    logistic_pair,
    lost_beyond,
    moving_border,
    paper,
    renamed_logistic,
    skew_tent,
    staircase,
    two_cycle,
    two_lines,
)
from sympy import Piecewise, symbols

from pwmap.diagrams.diagram import Diagram, PointStatus
from woodpecker import (
    FormulaMap,
    FormulaPiece,
    PiecewiseMap,
    Search,
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


def test_map_of_the_paper() -> None:
    """[Leine2001, Fig. 12]: fixed points r/(1 + a) and r - 2, joined by the jump from A to B."""
    diagram = explored(paper(), 1.0 / (1.0 + A), 1.0, (-1.0, 3.0))
    assert_graph(diagram, chain("EP F FF J BC F EP"))
    assert_places(
        diagram,
        {"FF": [(0.0, 0.0)], "BC": [(2.0, 0.0)], "EP": [(-1.0, -3.0), (3.0, 3.0 / (1.0 + A))]},
    )
    right, left = of_kind(diagram, FIXED)
    (jump,) = of_kind(diagram, JUMP)
    assert (right.word, left.word, jump.word) == ("R", "L", "L / R")
    assert_curve(right, lambda r: r / (1.0 + A))
    assert_curve(left, lambda r: r - 2.0)
    assert_curve(jump, lambda _: 0.0)
    assert set(right.multiplier.tolist()) == {-A}
    assert set(left.multiplier.tolist()) == {0.0}
    assert np.isnan(jump.multiplier).all()
    for branch, low, high in ((right, 0.0, 3.0), (left, -1.0, 2.0), (jump, 0.0, 2.0)):
        assert (branch.parameter.min(), branch.parameter.max()) == pytest.approx((low, high))
        assert branch.order == 1
        assert not branch.changes
    assert (diagram.parameter_name, diagram.x_name) == ("p", "x")
    assert {point.note for point in diagram.points} == {"fold", "end of the parameter span"}
    for point in diagram.points:
        assert point.status is PointStatus.LOCATED
        assert point.precision <= LOCATED
        assert point.cause == ("" if point.kind.value == "EP" else BORDER)  # else the note says it


@pytest.mark.parametrize(("x", "p"), [(-1.0, 1.0), (-2.5, -0.5), (0.1 / (1.0 + A), 0.1)])
def test_where_one_starts_does_not_matter(x: float, p: float) -> None:
    diagram = explored(paper(), x, p, (-1.0, 3.0))
    assert_graph(diagram, chain("EP F FF J BC F EP"))
    assert places(diagram)["FF"][0] == pytest.approx((0.0, 0.0), abs=LOCATED)


@pytest.mark.parametrize(("a", "code"), [(A, "FF"), (1.01, "FF"), (3.0, "FF"), (0.5, "BC"),
                                         (0.99, "BC")])  # fmt: skip
def test_a_flip_comes_with_point_a_just_for_steep_slopes(a: float, code: str) -> None:
    """The fixed point r/(1 + a) folds into the jump at r = 0; P_2 gets a jump there if a > 1."""
    diagram = explored(paper(a), 1.0 / (1.0 + a), 1.0, (-1.0, 3.0))
    assert_graph(diagram, chain(f"EP F {code} J BC F EP"))
    assert {point.note for point in diagram.points} == {"fold", "end of the parameter span"}
    found = {place for code in ("FF", "BC") for place in places(diagram).get(code, [])}
    assert np.array(sorted(found)) == pytest.approx(np.array([[0, 0], [2, 0]]), abs=LOCATED)


def test_two_lines() -> None:
    diagram = explored(two_lines(), -1.0, -0.5, (-2.0, 2.0))
    assert_graph(diagram, chain("EP F BC J BC F EP"))
    assert_places(diagram, {"BC": [(-1.0, 0.0), (0.0, 0.0)], "EP": [(-2.0, -4.0), (2.0, 2.0)]})
    left, right = of_kind(diagram, FIXED)
    assert_curve(left, lambda p: 2.0 * p)
    assert_curve(right, lambda p: 2.0 * (p + 1.0) / 3.0)
    assert notes(diagram, "BC") == ["fold", "fold"]


def test_staircase() -> None:
    """Persistence at both ends of the jump: the parameter ascends all the way."""
    diagram = explored(staircase(), -1.0, -0.5, (-2.0, 2.0))
    assert_graph(diagram, chain("EP F BC J BC F EP"))
    assert_places(diagram, {"BC": [(0.0, 0.0), (1.0, 0.0)], "EP": [(-2.0, -4.0), (2.0, 2.0)]})
    assert notes(diagram, "BC") == ["persistence", "persistence"]


@pytest.mark.slow
def test_a_border_that_moves() -> None:
    diagram = explored(moving_border(), -2.0, 0.0, (-2.0, 2.0))
    assert_graph(diagram, chain("EP F BC J BC F EP"))
    assert_places(diagram, {"BC": [(-1.0, -0.5), (1.0, 0.5)], "EP": [(-2.0, -7.0), (2.0, 3.0)]})
    assert_curve(of_kind(diagram, JUMP)[0], lambda p: 0.5 * p)


def test_a_jump_cut_by_the_span() -> None:
    diagram = explored(two_lines(), -0.5, -0.25, (-0.5, 2.0))
    assert_graph(diagram, chain("EP F BC J EP"))
    assert_places(diagram, {"BC": [(0.0, 0.0)], "EP": [(-0.5, -1.0), (-0.5, 0.0)]})


def test_a_multiplier_that_is_minus_one_all_along_has_no_flips() -> None:
    """The slopes p and -1/p of a cycle of two points have the product -1 for every p."""
    x, p = symbols("x p")
    map_ = from_sympy(Piecewise((p * x + 1, x <= 0), (1 - x / p, True)), x, p)
    found = continuation(map_, shoot(map_, -0.45, p=0.5, order=2), "p", (0.2, 0.9))
    assert {str(point.kind) for point in found.points} == {"EP"}


@pytest.mark.slow
@pytest.mark.parametrize("jump", [1e-5, 1e-3, 1.0, -1e-5, -1e-3, -1.0])
@pytest.mark.parametrize("max_step", [0.02, 0.5])
def test_a_branch_never_hops_over_a_jump(jump: float, max_step: float) -> None:
    """Fixed points 2 p and, on the other side of a small jump, 2 (p + jump) await the hop."""
    settings = Settings(span=(-2.0, 2.0), max_step=max_step)
    diagram = continued(lines(Line(0.5, 1.0), Line(0.5, 1.0, jump)), -2.0, -1.0, settings)
    assert_graph(diagram, chain("EP F BC J BC F EP"))
    assert_places(
        diagram,
        {"BC": [(0.0, 0.0), (-jump, 0.0)], "EP": [(-2.0, -4.0), (2.0, 2.0 * (2.0 + jump))]},
    )
    assert set(notes(diagram, "BC")) == {"fold" if jump > 0.0 else "persistence"}
    for branch in of_kind(diagram, FIXED):
        assert len({stretch.word for stretch in branch.words}) == 1


# --- Continuous borders ---------------------------------------------------------------------------


@pytest.mark.parametrize("x", [-0.2, 0.04])
def test_a_corner_where_stability_changes_is_a_point(x: float) -> None:
    """0.5 x + p | -1.5 x + p: from 2 p to 2 p/5, and what was stable is not beyond."""
    diagram = explored(skew_tent(0.5, -1.5), x, -0.1 if x < 0.0 else 0.1, (-1.0, 1.0))
    assert_graph(diagram, chain("EP F BC F EP"))
    assert_places(diagram, {"BC": [(0.0, 0.0)], "EP": [(-1.0, -2.0), (1.0, 0.4)]})
    assert notes(diagram, "BC") == ["persistence"]
    left, right = sorted(diagram.branches, key=lambda branch: branch.word)
    assert (left.word, right.word) == ("L", "R")
    assert_curve(left, lambda p: 2.0 * p)
    assert_curve(right, lambda p: 0.4 * p)
    # the corner itself has the slope of the piece from which it was met
    assert set(left.multiplier[1:-1].tolist()) == {0.5}
    assert set(right.multiplier[1:-1].tolist()) == {-1.5}


@pytest.mark.parametrize("x", [-0.2, 0.4])
def test_a_corner_that_folds_is_a_point(x: float) -> None:
    """0.5 x + p | 1.5 x + p: both fixed points live at p < 0 and meet in the corner."""
    diagram = explored(skew_tent(0.5, 1.5), x, -0.1 if x < 0.0 else -0.2, (-1.0, 1.0))
    assert_graph(diagram, chain("EP F BC F EP"))
    assert_places(diagram, {"BC": [(0.0, 0.0)], "EP": [(-1.0, -2.0), (-1.0, 2.0)]})
    assert notes(diagram, "BC") == ["fold"]


@pytest.mark.parametrize("x", [-0.2, 0.1])
def test_a_corner_without_effect_is_a_mark(x: float) -> None:
    """0.5 x + p | -0.5 x + p: stable on both sides; the word changes, and nothing else."""
    diagram = explored(skew_tent(0.5, -0.5), x, -0.1 if x < 0.0 else 0.15, (-1.0, 1.0))
    assert_graph(diagram, chain("EP F EP"))
    (branch,) = diagram.branches
    (change,) = branch.changes
    assert sorted(stretch.word for stretch in branch.words) == ["L", "R"]
    assert change.cause == BORDER
    assert abs(branch.parameter[change.first]) <= LOCATED
    assert_curve(branch, lambda p: min(2.0 * p, 2.0 * p / 3.0))


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


def test_a_grazing_towards_its_root() -> None:
    """x/2 + p - sqrt(x): s = -1 + sqrt(1 + 2 p), x = s^2; it flips at s = 1/3."""
    diagram = explored(grazing(-1.0), -0.5, -0.25, (-1.0, 1.0))
    assert_graph(diagram, chain("EP F BC F PD F EP"))
    end = (math.sqrt(3.0) - 1.0) ** 2
    assert_places(
        diagram,
        {"BC": [(0.0, 0.0)], "PD": [(7 / 18, 1 / 9)], "EP": [(-1.0, -2.0), (1.0, end)]},
    )
    assert notes(diagram, "BC") == ["persistence"]
    (flip,) = points_of(diagram, "PD")
    for branch in diagram.branches:
        p = float(branch.parameter[len(branch) // 2])
        assert bool(branch.stable[len(branch) // 2]) == (p < 0.0 or p > flip.parameter)


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


def test_a_grazing_that_folds() -> None:
    """x/2 + p + sqrt(x): back to p < 0 with slope +inf, round the fold at (-1/2, 1), and on."""
    diagram = explored(grazing(1.0), -0.5, -0.25, (-1.0, 1.0))
    assert_graph(diagram, chain("EP F BC F LP F EP"))
    end = (1.0 + math.sqrt(3.0)) ** 2
    assert_places(
        diagram, {"BC": [(0.0, 0.0)], "LP": [(-0.5, 1.0)], "EP": [(-1.0, -2.0), (1.0, end)]}
    )
    assert notes(diagram, "BC") == ["fold"]


def test_a_fall_ends_a_branch() -> None:
    diagram = explored(lost_beyond(1.0), 0.0, 0.0, (-1.0, 1.0))
    assert_graph(diagram, chain("EP F FALL"))
    assert_places(diagram, {"EP": [(-1.0, -2.0)], "FALL": [(0.5, 1.0)]})
    assert notes(diagram, "FALL") == [NOWHERE]


# --- Smooth maps ----------------------------------------------------------------------------------


def test_a_flip_cuts_both_branches_of_period_two() -> None:
    """A cycle is followed once; each of its points has a branch."""
    diagram = explored(logistic(), list(logistic_pair(3.2)), 3.2, (3.1, 3.6))
    once = chain("EP F PD F EP")
    assert_graph(diagram, nx.disjoint_union(once, once))
    assert {branch.order for branch in diagram.branches} == {2}
    for parameter, _ in places(diagram)["PD"]:
        assert parameter == pytest.approx(1.0 + math.sqrt(6.0), abs=LOCATED)
    for branch in diagram.branches:
        upper = branch.x[0] > 0.6
        assert_curve(branch, lambda p, k=int(upper): logistic_pair(p)[k])  # type: ignore[misc]
        expected = 4.0 + 2.0 * branch.parameter - branch.parameter**2
        # d multiplier/d x = 2 p^2 < 30, times the error in x
        assert branch.multiplier == pytest.approx(expected, abs=30.0 * LOCATED)


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


# --- Iterates -------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_jump_of_the_second_iterate_starts_at_point_a() -> None:
    """P2^L jumps at r/a, beside the fixed point r/(1 + a) of slope a^2 [Leine2001, Eq. 15]."""
    settings = Settings(span=(-1.0, 3.0), window=(-20.0, 20.0))
    diagram = everything(paper(), settings, (1, 2), Search(slices=7)).diagram
    assert_sound(diagram, settings)
    (a,) = points_of(diagram, "FF")
    (jump,) = [b for b in map(diagram.branch, a.branches) if b.order == 2]
    assert jump.kind is JUMP
    assert (jump.parameter.min(), jump.parameter.max()) == (0.0, 3.0)
    assert_curve(jump, lambda r: r / A)
    assert jump.word == "R | R / R | L"


@pytest.mark.slow
def test_a_cycle_of_period_two_and_its_jumps() -> None:
    """Both points of the cycle, joined and continued by jumps of the second iterate.

    The jumps are -2 (p < -1), 0 (-1 < p < 1/2) and 2 - 2 p (1/2 < p < 1), see maps.two_cycle.
    """
    for x in ([-2 / 3, 2 / 3], [2 / 3, -2 / 3]):
        diagram = explored(two_cycle(), x, 0.0, (-2.0, 0.9))
        assert_graph(diagram, chain("EP J BC F BC J BC F BC J EP"))
        assert_places(
            diagram,
            {
                "EP": [(-2.0, -2.0), (0.9, 0.2)],
                "BC": [(-1.0, -2.0), (0.5, 0.0), (-1.0, 0.0), (0.5, 1.0)],
            },
        )
        for branch in of_kind(diagram, FIXED):
            assert set(branch.multiplier.tolist()) == {0.25}
            low = branch.x.max() <= 0.0
            assert_curve(
                branch,
                lambda p, low=low: 4 / 3 * (p - 0.5) if low else 1.0 + 2 / 3 * (p - 0.5),  # type: ignore[misc]
            )


def test_two_jumps_that_merge_give_birth_to_a_fixed_point() -> None:
    """Further on, 2 - 2 p meets 0 at p = 1, where the fixed point 2 (p - 1) begins."""
    settings = Settings(span=(-2.0, 2.0), window=(-6.0, 6.0))
    found = everything(two_cycle(), settings, (1, 2), Search(slices=15)).diagram
    (birth,) = [p for p in points_of(found, "BC") if abs(p.parameter - 1.0) < 1e-6]
    assert (birth.parameter, birth.x) == pytest.approx((1.0, 0.0), abs=LOCATED)
    meeting = [found.branch(name) for name in birth.branches]
    assert sorted((str(b.kind), b.order) for b in meeting) == [
        ("fixed-point", 1), ("jump", 1), ("jump", 2)
    ]  # fmt: skip


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


def test_a_map_must_have_pieces() -> None:
    with pytest.raises(TypeError, match=r"source must be woodpecker\.Toy or a map of pieces"):
        continued(lambda x, p: x, 0.0, 0.0, Settings())  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="source must be"):
        everything(None, Settings(window=(0.0, 1.0)))  # type: ignore[arg-type]


@pytest.mark.slow
def test_maps_may_have_margins_in_any_order() -> None:
    """The same map whatever the order of its pieces, but for the point on the border itself."""
    first, second = two_lines().pieces
    assert isinstance(first, FormulaPiece)
    one, other = (
        explored(FormulaMap(pieces), -1.0, -0.5, (-2.0, 2.0))
        for pieces in ([first, second], [second, first])
    )
    assert places(one) == places(other)


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
