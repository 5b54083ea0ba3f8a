"""Branches of cycles: steps, folds, flips, ends, and what a collision with a jump is."""

import math
from itertools import pairwise

import numpy as np
import pytest
from diagrams import (
    LOCATED,
    assert_curve,
    assert_graph,
    assert_places,
    assert_sound,
    chain,
    notes,
    points_of,
)
from maps import (
    BORDER,
    Line,
    continued,
    fold,
    island,
    logistic,
    logistic_pair,
    one_piece,
)

from pwmap.diagrams.diagram import Diagram, PointKind, PointStatus
from woodpecker import FormulaMap, FormulaPiece, PiecewiseMap, Smooth
from woodpecker.base.settings import Settings


def followed(map_: PiecewiseMap, x: float | list[float], p: float, settings: Settings) -> Diagram:
    """The diagram, which is sound whatever it shows."""
    found = continued(map_, x, p, settings)
    assert_sound(found, settings)
    return found


# --- Folds and flips ------------------------------------------------------------------------------


@pytest.mark.parametrize("x", [0.5, -0.5, 1e-5, -1e-5, 0.0])
def test_a_fold_is_located_and_passed(x: float) -> None:
    """x = +-sqrt(p), multiplier 1 - 2 x: round the fold to the other root, from it, too."""
    diagram = followed(fold(), x, x * x, Settings(span=(-1.0, 0.5)))
    assert_graph(diagram, chain("EP F LP F EP"))
    root = math.sqrt(0.5)
    assert_places(diagram, {"LP": [(0.0, 0.0)], "EP": [(0.5, -root), (0.5, root)]})
    (point,) = points_of(diagram, "LP")
    assert point.cause == "the branch turns round"
    assert point.interval is not None
    assert point.interval[0] <= 0.0 <= point.interval[1]
    for branch in diagram.branches:
        assert branch.x**2 == pytest.approx(branch.parameter, abs=LOCATED)
        assert branch.multiplier == pytest.approx(1.0 - 2.0 * branch.x, abs=LOCATED)


def test_a_cycle_of_period_two_ends_in_the_flip_it_comes_from() -> None:
    """Down to p = 3 its two points meet, where the fixed point has the multiplier -1.

    Found alone, without the fixed point: p = 3 to the precision that it states.
    """
    settings = Settings(span=(2.5, 3.4))
    diagram = followed(logistic(), list(logistic_pair(3.2)), 3.2, settings)
    (birth,) = points_of(diagram, "PD")
    assert (birth.parameter, birth.x) == pytest.approx((3.0, 2.0 / 3.0), abs=LOCATED)
    assert birth.precision < 1e-12
    assert abs(birth.parameter - 3.0) <= birth.precision
    assert len(birth.branches) == 2
    assert {diagram.branch(name).order for name in birth.branches} == {2}


@pytest.mark.parametrize("peak", [1e3, 1e8])
@pytest.mark.parametrize("width", [0.2, 1e-3])
def test_a_steep_branch_is_followed(peak: float, width: float) -> None:
    """The fixed point x = p of slope -peak exp(-(p/width)^2) - 2."""

    def slope(_x: float, p: float) -> float:
        return -peak * math.exp(-((p / width) ** 2)) - 2.0

    def value(x: float, p: float) -> float:
        return p + slope(x, p) * (x - p)

    def by_p(x: float, p: float) -> float:
        change = -2.0 * p / width**2 * (slope(x, p) + 2.0)
        return 1.0 - slope(x, p) + change * (x - p)

    settings = Settings(span=(-1.0, 1.0))
    diagram = followed(one_piece(Smooth(value, slope, by_p)), 0.7, 0.7, settings)
    assert_graph(diagram, chain("EP F EP"))
    assert {point.status for point in diagram.points} == {PointStatus.LOCATED}
    assert_curve(diagram.branches[0], lambda p: p)


@pytest.mark.parametrize("arm", [1.0, -1.0])
@pytest.mark.parametrize(
    ("bend", "names"), [(1e6, ["LP", "PD"]), (1e8, ["LP", "PD"]), (1e10, ["LP"])]
)
def test_a_flip_beside_a_fold_is_a_point_unless_it_cannot_be_told(
    bend: float, names: list[str], arm: float
) -> None:
    """p - k x^2: the fold at x = -1/2k, the flip 1/k beside it and 1/k above, resolved to 1e-9.

    What they are called does not depend on the arm from which they are met.
    """
    map_ = one_piece(
        Smooth(lambda x, p: p - bend * x * x, lambda x, _: -2.0 * bend * x, lambda _x, _p: 1.0)
    )
    x = 0.5 * (-1.0 + 3.0 * arm) / bend
    diagram = continued(map_, [x], 2.0 / bend, Settings(span=(-1.0, 1.0), window=(-1.0, 1.0)))
    met = sorted((q for q in diagram.points if q.kind.value != "EP"), key=lambda q: q.kind.value)
    assert [q.kind.value for q in met] == names
    places = {"LP": (-0.25 / bend, -0.5 / bend), "PD": (0.75 / bend, 0.5 / bend)}
    for q in met:
        assert (q.parameter, q.x) == pytest.approx(places[q.kind.value], abs=LOCATED)
        assert len(q.branches) == 2


# --- Ends -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("span", [(1.3, 2.7), (1.5, 2.0)])  # also where it starts at an end
def test_ends_of_the_span_are_met_exactly(span: tuple[float, float]) -> None:
    diagram = followed(logistic(), 0.5, 2.0, Settings(span=span))
    assert_graph(diagram, chain("EP F EP"))
    assert [point.parameter for point in points_of(diagram, "EP")] == list(span)
    assert notes(diagram, "EP") == ["end of the parameter span"] * 2
    (branch,) = diagram.branches
    assert sorted(branch.parameter[[0, -1]].tolist()) == list(span)
    assert_curve(branch, lambda p: 1.0 - 1.0 / p)


def test_the_window_ends_a_branch() -> None:
    """x = 1 - 1/p leaves (0.4, 0.6) at p = 5/3 and 5/2; nothing lies beyond."""
    diagram = followed(logistic(), 0.5, 2.0, Settings(span=(1.0, 4.0), window=(0.4, 0.6)))
    assert_places(diagram, {"EP": [(5.0 / 3.0, 0.4), (2.5, 0.6)]})
    assert notes(diagram, "EP") == ["end of the window"] * 2
    for branch in diagram.branches:
        assert 0.4 - LOCATED <= branch.x.min() <= branch.x.max() <= 0.6 + LOCATED


def test_the_number_of_samples_is_limited() -> None:
    """To each side of the start seven, which is one of them; the ends say that they are open."""
    diagram = followed(logistic(), 0.5, 2.0, Settings(span=(1.0, 4.0), max_samples=7))
    (branch,) = diagram.branches
    assert len(branch) == 13
    assert notes(diagram, "EP") == ["as many samples as allowed"] * 2
    assert {point.status for point in diagram.points} == {PointStatus.OPEN}
    assert {point.precision for point in diagram.points} == {math.inf}


# --- Steps ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("max_step", [0.005, 0.1])
def test_steps_keep_to_the_settings(max_step: float) -> None:
    settings = Settings(
        span=(1.0, 4.0), window=(0.0, 1.0), step=0.001, max_step=max_step, max_turn=0.1
    )
    diagram = followed(logistic(), 0.3, 1.0 / 0.7, settings)
    for branch in diagram.branches:
        p, x = branch.parameter / settings.p_scale, branch.x / settings.x_scale
        lengths = np.hypot(np.diff(p), np.diff(x))
        # the corrector leaves the chord by max_turn^2/2 = 0.5 % at most
        assert lengths.max() <= 1.005 * max_step
        # dx/dp = 1/p^2: these are directions of the branch itself
        angles = np.arctan(settings.p_scale / settings.x_scale / branch.parameter**2)
        assert max(abs(b - a) for a, b in pairwise(angles.tolist())) <= 1.01 * settings.max_turn
    longest = max(float(np.hypot(np.diff(b.parameter) / 3.0, np.diff(b.x)).max())
                  for b in diagram.branches)  # fmt: skip
    assert longest >= 0.99 * min(max_step, 0.05)


def test_steps_are_parts_of_the_scales() -> None:
    """In other units of x and p the same samples, in these units."""
    one = continued(island(0.0, 0.0, 1.2), 1.2, 0.0, Settings(span=(-2.0, 2.0), window=(-3.0, 3.0)))
    unit = 2.0**20

    def value(x: float, p: float) -> float:
        return x - unit * ((x / unit) ** 2 + (p / unit) ** 2 - 1.44)

    scaled = Smooth(value, lambda x, _: 1.0 - 2.0 * x / unit, lambda _, p: -2.0 * p / unit)
    wide = Settings(span=(-2.0 * unit, 2.0 * unit), window=(-3.0 * unit, 3.0 * unit))
    other = continued(one_piece(scaled), 1.2 * unit, 0.0, wide)
    assert [len(b) for b in one.branches] == [len(b) for b in other.branches]
    for a, b in zip(one.points, other.points, strict=True):
        assert a.kind is b.kind
        assert (b.parameter / unit, b.x / unit) == pytest.approx((a.parameter, a.x), abs=LOCATED)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"span": (1.0, 0.0)}, r"span must ascend, got \(1.0, 0.0\)"),
        ({"span": (0.01, math.inf)}, r"span must be finite, got \(0.01, inf\)"),
        ({"span": (-math.inf, 0.0)}, r"span must be finite, got \(-inf, 0.0\)"),
        ({"span": (0.0, 0.5, 1.0)}, r"span must be two real numbers, got \(0.0, 0.5, 1.0\)"),
        ({"window": (-0.24, -2.5)}, r"window must ascend, got \(-0.24, -2.5\)"),
        ({"window": (0.0, 1.0j)}, r"window must be two real numbers, got \(0.0, 1j\)"),
        ({"step": 0.03}, r"step must lie in \[1e-13, 0.02\], got 0.03"),
        ({"step": 1e-14}, r"step must lie in \[1e-13, 0.02\], got 1e-14"),
        ({"max_samples": 0}, "max_samples must be a whole number of at least 1, got 0"),
        ({"max_pieces": True}, "max_pieces must be a whole number of at least 1, got True"),
    ],
)
def test_settings_refuse(options: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Settings(**options)  # type: ignore[arg-type]


# --- Borders that no margin expresses -------------------------------------------------------------


@pytest.mark.parametrize("speed", [0.0, 0.1])
@pytest.mark.parametrize("slope", [0.5, -0.5])
def test_a_jump_that_no_margin_expresses_ends_a_branch(speed: float, slope: float) -> None:
    """A holds x > 0.3 + speed p, where B, which holds everything, comes too late."""
    edge = {BORDER: Line(1.0, -speed, -0.3).smooth()}
    map_ = FormulaMap(
        [
            FormulaPiece("A", Line(slope, 1.0, 0.2).smooth(), edge),
            FormulaPiece("B", Line(slope, 1.0).smooth()),
        ]
    )
    diagram = followed(map_, -1.0, -1.0 + slope, Settings(span=(-2.0, 2.0), window=(-5.0, 5.0)))
    (end,) = [point for point in diagram.points if point.status is PointStatus.OPEN]
    assert (end.kind, end.note) == (PointKind.EP, "the map takes another piece")
    assert end.cause == "the map takes A in place of B, though no margin of it vanishes"
    met = 0.3 * (1.0 - slope) / (1.0 - speed * (1.0 - slope))  # x = p/(1 - slope) = 0.3 + speed p
    # steps end at 1e-13 of the span and of the window
    assert (end.parameter, end.x) == pytest.approx((met, met / (1.0 - slope)), abs=1e-11)
    for branch in diagram.branches:
        assert_curve(branch, lambda p: p / (1.0 - slope))


def test_a_kink_that_no_margin_expresses_is_passed() -> None:
    """The same where both pieces have one value: the branch goes on in A."""
    edge = {BORDER: Line(1.0, 0.0, -0.3).smooth()}
    map_ = FormulaMap(
        [
            FormulaPiece("A", Line(0.25, 1.0, 0.075).smooth(), edge),
            FormulaPiece("B", Line(0.5, 1.0).smooth()),
        ]
    )
    diagram = followed(map_, -1.0, -0.5, Settings(span=(-2.0, 2.0), window=(-9.0, 9.0)))
    assert_graph(diagram, chain("EP F EP"))
    assert_curve(diagram.branches[0], lambda p: 2.0 * p if p < 0.15 else (p + 0.075) / 0.75)
