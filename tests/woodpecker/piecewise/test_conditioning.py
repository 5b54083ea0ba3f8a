"""Branches that become too steep, and samples that can be checked, on maps of known slope."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pwmap.diagrams.diagram import PointKind
from woodpecker.diagram import connected
from woodpecker.piecewise.conditioning import FINE, TOO_STEEP, TRANSIT, checked, gentle
from woodpecker.piecewise.maps import Cycle, Evaluation, LabelledMap, correct, evaluate
from woodpecker.piecewise.paths import Paths
from woodpecker.piecewise.settings import Settings
from woodpecker.piecewise.stepping import PathPoint, follow_from

STEEPEST = 50.0
PEAK = 1000.0


def hill(width: float) -> LabelledMap:
    """Fixed point x = p of slope -PEAK exp(-(p/width)^2) - 2: too steep for |p| < limit(width)."""

    def value(x: float, p: float) -> Evaluation:
        above = -PEAK * math.exp(-((p / width) ** 2))
        slope, change = above - 2.0, -2.0 * p / width**2 * above
        return Evaluation(p + slope * (x - p), slope, 1.0 - slope + change * (x - p), "A")

    return value


def limit(width: float) -> float:
    return width * math.sqrt(math.log(PEAK / (STEEPEST - 2.0)))


def along(
    labelled: LabelledMap, p: float, direction: float, steps: float = 0.02
) -> list[PathPoint]:
    """The gentle part of the branch through (p, p)."""
    start, good, _ = correct(labelled, [p], p)
    assert good
    reach = 1.1 * abs(p)
    settings = Settings(span=(-reach, reach), steepest=STEEPEST, step=steps, max_step=steps)
    path = follow_from(labelled, start, np.array([0.0, direction]), settings)
    return list(gentle(path, labelled, settings))


@pytest.mark.parametrize("direction", [1.0, -1.0])
@pytest.mark.parametrize("steps", [0.02, 0.013])
def test_a_branch_ends_where_it_is_as_steep_as_it_may_be(direction: float, steps: float) -> None:
    path = along(hill(0.2), -direction, direction, steps)
    assert (path[-1].kind, path[-1].note) == (PointKind.EP, TOO_STEEP)
    # located to FINE; the rounding of exp is far below
    assert path[-1].p == pytest.approx(-direction * limit(0.2), abs=2.0 * FINE)
    assert all(point.cycle.steepness <= STEEPEST for point in path)


@pytest.mark.parametrize("direction", [1.0, -1.0])
@pytest.mark.parametrize(("part", "passes"), [(0.98, True), (1.02, False)])
def test_a_short_steep_stretch_is_passed(direction: float, part: float, passes: bool) -> None:
    """The stretch between the two limits has a length of TRANSIT times ``part``.

    Whether it is met does not depend on where the steps fall.
    """
    width = part * TRANSIT / math.sqrt(2.0) / (2.0 * limit(1.0))
    for start in (-0.1, -0.1003, -0.1007):
        path = along(hill(width), direction * start, direction, 2e-4)
        assert all(point.cycle.steepness <= STEEPEST for point in path)
        if passes:
            assert path[-1].note == "end of the parameter span"
        else:
            assert path[-1].p == pytest.approx(-direction * limit(width), abs=2.0 * FINE)


def test_nothing_comes_of_a_steep_start() -> None:
    assert along(hill(0.2), 0.01, 1.0) == []
    start, _, _ = correct(hill(0.2), [0.01], 0.01)
    assert Paths(hill(0.2), Settings(steepest=STEEPEST)).cycle(start) == []


def test_a_steep_start_is_refused() -> None:
    start, _, _ = correct(hill(0.2), [0.0], 0.0)
    with pytest.raises(ValueError, match=r"50 at most \(steepest\), got 1002"):
        connected(hill(0.2), start, Settings(steepest=STEEPEST))


def test_a_change_of_word_may_lie_on_a_short_steep_stretch() -> None:
    """Word B for x > 0, from the top of the hill on: the change is kept, what is steep is not."""
    whole = hill(0.3 * TRANSIT / limit(1.0))

    def changing(x: float, p: float) -> Evaluation:
        return whole(x, p)._replace(word="A" if x < 0.0 else "B")

    path = along(changing, -0.1, 1.0, 2e-4)
    assert path[-1].note == "end of the parameter span"
    (change,) = [point for point in path if point.kind is PointKind.WC]
    assert change.p == pytest.approx(0.0, abs=1e-9)
    others = [point for point in path if point is not change]
    assert all(point.cycle.steepness <= STEEPEST for point in others)


@pytest.mark.parametrize(
    ("slopes", "steepness"),
    [([3.0], 3.0), ([2.0, -100.0, 0.01], 200.0), ([0.1, 10.0, 10.0], 100.0), ([0.1, 0.2], 0.2)],
)
def test_steepness_is_the_largest_product_in_a_row(slopes: list[float], steepness: float) -> None:
    laps = tuple(Evaluation(0.0, slope, 0.0, "A") for slope in slopes)
    for k in range(len(laps)):
        cycle = Cycle(np.zeros(len(laps)), 0.0, (*laps[k:], *laps[:k]))
        assert cycle.steepness == pytest.approx(steepness, rel=1e-15)


def test_what_has_no_slope_is_too_steep() -> None:
    laps = (Evaluation(0.0, math.nan, 0.0, "A"), Evaluation(0.0, 1.0, 0.0, "A"))
    assert Cycle(np.zeros(2), 0.0, laps).steepness == math.inf


# --- Samples --------------------------------------------------------------------------------------

ROUGH = 3e-11  # rounding of a steep map


def rounded(x: float) -> bool:
    """Whether a double is one of those at which the map rounds badly: nine of ten."""
    return round(x / math.ulp(0.3)) % 10 != 0


def rough(x: float, p: float) -> Evaluation:
    """5000 (x - 0.3) + 0.3, with an error of ROUGH at most doubles."""
    return Evaluation(0.3 + 5e3 * (x - 0.3) + ROUGH * rounded(x), 5e3, 0.0, "A")


def test_the_nearest_double_that_returns_is_taken() -> None:
    x = checked(rough, evaluate(rough, np.array([0.3]), 0.0), 0, 1e-11)
    assert x is not None
    assert abs(rough(x, 0.0).value - x) <= 1e-11
    assert abs(x - 0.3) <= ROUGH / 5e3 + 10.0 * math.ulp(0.3)


def test_there_may_be_none() -> None:
    def always(x: float, p: float) -> Evaluation:
        side = math.copysign(ROUGH, x - 0.3)  # a gap that no double closes
        return Evaluation(x + side, 5e3, 0.0, "A")

    assert checked(always, evaluate(always, np.array([0.3]), 0.0), 0, 1e-11) is None


def test_a_gentle_point_is_left_as_it_is() -> None:
    """Its laps close; P_j is not asked again."""
    calls = 0

    def counted(x: float, p: float) -> Evaluation:
        nonlocal calls
        calls += 1
        return Evaluation(-0.5 * x, -0.5, 0.0, "A")

    cycle = evaluate(counted, np.array([0.0]), 0.0)
    assert checked(counted, cycle, 0, 1e-11) == 0.0
    assert calls == 1
