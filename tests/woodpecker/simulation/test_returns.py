"""The return map: the numbers of the stated model, derivatives by differences, executors."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from scenes import plain
from toy_points import EVERY, POINTS

from woodpecker import Return, ReturnMap, Status, Toy, equilibrium, first_return, return_map
from woodpecker.base.compiled import COMPILED
from woodpecker.simulation.returns import CHUNK

TOY = Toy()
MANY = 40 if COMPILED else 3  # random states; plain Python is a hundred times slower
ROUNDING = 1e-14  # of an image of order 1 after a dozen events


def image(phi_s: float, eps_n1: float = 0.5, *, law: str = "summed") -> float:
    return first_return(TOY.replace(eps_n1=eps_n1, expansion_friction=law), phi_s).phi_s


# --- Jumps, dips, band ----------------------------------------------------------------------------


def word_change(low: float, high: float, eps_n1: float = 0.5) -> tuple[float, float]:
    """Neighbouring doubles between which the order of the first impacts changes."""
    toy = TOY.replace(eps_n1=eps_n1)
    left, right = (plain(first_return(toy, x).word) for x in (low, high))
    assert left != right
    while low < (middle := 0.5 * (low + high)) < high:
        if plain(first_return(toy, middle).word) == left:
            low = middle
        else:
            high = middle
    return low, high


# Law, place, width of the bracket, values on the left and on the right at eps_N1 = 0.5.
JUMPS = [
    ("summed", -0.757787, 1e-4, -0.511825, -0.375656),
    ("summed", -2.35, 1e-3, -0.511825, -0.375656),
    ("separate", -0.757787, 1e-4, -0.351002, -0.375656),
    ("separate", -2.35, 1e-3, -0.351002, -0.375656),
]


@pytest.mark.parametrize(("law", "place", "width", "left", "right"), JUMPS)
def test_jumps_of_the_map(law: str, place: float, width: float, left: float, right: float) -> None:
    """Where the order of a beak and an upper sleeve impact changes. Paper: -0.76 and -2.35."""
    low, high = word_change(place - width, place + width)
    assert low == pytest.approx(place, abs=5e-7 if width < 1e-3 else 1e-3)  # printed digits
    # A distance of 1e-10 keeps clear of the one double at which both strike together.
    assert image(low - 1e-10, law=law) == pytest.approx(left, abs=5e-7)
    assert image(high + 1e-10, law=law) == pytest.approx(right, abs=5e-7)


@pytest.mark.parametrize("place", [-1.225, -0.266])
def test_dips_of_the_map(place: float) -> None:
    """Paper: -1.23 and -0.27. The farther the toy falls, the farther it swings back."""
    starts = np.linspace(place - 0.01, place + 0.01, 2001)
    result = return_map(TOY, starts)
    assert starts[np.nanargmin(result.phi_s)] == pytest.approx(place, abs=5e-4)  # printed digits
    assert np.nanmin(result.phi_s) < -20.0
    assert np.nanmax(result.drop[np.isfinite(result.drop)]) > 100.0
    assert result.phi_s[0] > -6.0
    assert result.phi_s[-1] > -6.0
    # its flanks are crossed in one step: falls of seconds cost no more events than short ones
    assert result.period.max() > 1.0
    assert max(len(word.split()) for word in result.words) < 40


def test_the_band_of_centres() -> None:
    """From a minimum inside the friction cone the bird swings back to where it was: P_1 = 1."""
    result = return_map(TOY, np.linspace(-0.2382, -0.2217, 100))
    np.testing.assert_allclose(result.phi_s, result.start, rtol=ROUNDING)
    np.testing.assert_allclose(result.slope, 1.0, rtol=1e-12)
    assert set(result.words) == {""}
    assert (result.drop == 0.0).all()
    # Half a turn is enough from a maximum above the equilibrium: P_1(x) = 2 x_0 - x.
    above, centre = return_map(TOY, np.linspace(-0.2216, -0.2052, 100)), equilibrium(TOY).phi_s
    np.testing.assert_allclose(above.phi_s, 2.0 * centre - above.start, rtol=ROUNDING)
    np.testing.assert_allclose(above.slope, -1.0, rtol=1e-12)
    np.testing.assert_allclose(above.period, result.period[0] / 2.0, rtol=1e-12)


def test_ends_of_the_band() -> None:
    """The friction cone ends at -0.205135, and at its mirror image about the equilibrium."""
    low, high = word_change(-0.206, -0.204)
    assert low == pytest.approx(-0.205135, abs=5e-7)  # printed digits
    mirror = 2.0 * equilibrium(TOY).phi_s - low
    assert word_change(-0.239, -0.238)[0] == pytest.approx(mirror, rel=1e-12)
    assert first_return(TOY, high).word.startswith("S2")  # it slips at once


def test_the_return_at_the_equilibrium() -> None:
    phi_s = equilibrium(TOY).phi_s
    result = first_return(TOY, phi_s)
    assert (result.phi_s, result.word, result.status) == (phi_s, "", Status.RETURNED)


@pytest.mark.parametrize(("law", "name"), EVERY)
def test_fixed_points_on_the_edge_of_a_jump(law: str, name: str) -> None:
    """Of the limits of P_1 on both sides of a jump just one passes it within 1e-9 of eps_N1."""
    _, _, eps_n1, place = POINTS[law][name]
    passed = []
    for side in (-1e-10, 1e-10):  # where a limit is read; it moves by 1 rad per unit or faster
        below, beyond = (image(place + side, eps_n1 + d, law=law) - place for d in (-1e-9, 1e-9))
        passed.append(below * beyond < 0.0)
    assert sorted(passed) == [False, True]


# --- Derivatives ----------------------------------------------------------------------------------


def derivative(f: Callable[[float], float]) -> float:
    """Five-point central difference at 0.

    A step of 1e-5 leaves 1e-15 / 1e-5 of rounding. At 1e-3 from a square root the fifth
    derivative is 1e14 at most, times step^4 / 30 is 3e-8: together well below 1e-6.
    """
    h = 1e-5
    return (f(-2.0 * h) - 8.0 * f(-h) + 8.0 * f(h) - f(2.0 * h)) / (12.0 * h)


def states_away_from_word_changes(count: int) -> list[tuple[float, float, Return]]:
    """Random (phi_S, eps_N1) whose word is the same at a distance of 1e-3 in both."""
    rng, found = np.random.default_rng(1), []
    while len(found) < count:
        phi_s, eps_n1 = float(rng.uniform(-2.4, -0.25)), float(rng.uniform(0.02, 0.98))
        middle = first_return(TOY.replace(eps_n1=eps_n1), phi_s)
        around = [
            first_return(TOY.replace(eps_n1=eps_n1 + b), phi_s + a).word
            for a, b in ((-1e-3, 0.0), (1e-3, 0.0), (0.0, -1e-3), (0.0, 1e-3))
        ]
        if middle.status is Status.RETURNED and set(around) == {middle.word}:
            found.append((phi_s, eps_n1, middle))
    return found


def test_derivatives_against_central_differences() -> None:
    for phi_s, eps_n1, middle in states_away_from_word_changes(MANY):
        slope = derivative(lambda h, x=phi_s, eps=eps_n1: image(x + h, eps))
        rate = derivative(lambda h, x=phi_s, eps=eps_n1: image(x, eps + h))
        assert middle.slope == pytest.approx(slope, rel=1e-6, abs=1e-6)
        assert middle.d_eps_n1 == pytest.approx(rate, rel=1e-6, abs=1e-6)


def test_derivatives_without_restitution_are_one_sided() -> None:
    """At eps_N1 = 0 the beak rests, but at any larger restitution it bounces."""
    for phi_s in (-0.45, -0.53, -0.61, -0.8, -0.95, -1.45):
        at_zero, step = first_return(TOY.replace(eps_n1=0.0), phi_s), 1e-7
        one_sided = (image(phi_s, step) - at_zero.phi_s) / step
        # Rounding 1e-15 over the step; curvature of order 1 times the step.
        assert at_zero.d_eps_n1 == pytest.approx(one_sided, abs=1e-6)


@pytest.mark.parametrize("order", [2, 3])
def test_iterates_are_nested_returns(order: int) -> None:
    """P_j by re-simulation: P_1 of P_1, slopes multiply, times and drops add."""
    rng, compared = np.random.default_rng(2), 0
    while compared < MANY // 2:
        toy, phi_s = (
            TOY.replace(eps_n1=float(rng.uniform(0.02, 0.98))),
            float(rng.uniform(-2, -0.3)),
        )
        laps, x = [], phi_s
        for _ in range(order):
            laps.append(first_return(toy, x))
            x = laps[-1].phi_s
            if not laps[-1].status.success:
                break
        result = first_return(toy, phi_s, order)
        if laps[-1].status is not Status.RETURNED:
            assert result.status is laps[-1].status
            continue
        compared += 1
        slope, rate = 1.0, 0.0
        for lap in laps:
            slope, rate = slope * lap.slope, lap.slope * rate + lap.d_eps_n1
        # The displacement goes on where nested returns begin at y = 0: rounding of y, amplified.
        tolerance = 1e-13 * (1.0 + abs(slope))
        assert result.phi_s == pytest.approx(x, rel=0.0, abs=tolerance)
        assert result.word == " | ".join(lap.word for lap in laps)
        assert result.slope == pytest.approx(slope, rel=1e-9, abs=1e-12)
        assert result.d_eps_n1 == pytest.approx(rate, rel=1e-9, abs=1e-9 * abs(slope) + 1e-12)
        period, drop = sum(lap.period for lap in laps), sum(lap.drop for lap in laps)
        assert result.period == pytest.approx(period, rel=1e-12, abs=tolerance)
        assert result.drop == pytest.approx(drop, rel=1e-12, abs=tolerance)


def test_an_iterate_that_does_not_return() -> None:
    """Each return of the cycle takes 19.4 mm of a pole of 30 mm; the word keeps what happened."""
    lost = first_return(TOY.replace(pole=0.03), -0.52947197, 3)
    assert (lost.status, lost.drop) == (Status.POLE_END, 0.03)
    assert np.isnan([lost.phi_s, lost.period, lost.slope, lost.d_eps_n1]).all()
    assert lost.word.count("|") == 1
    assert first_return(TOY, -0.05, 2).status is Status.FREE_FALL


# --- Many starts ----------------------------------------------------------------------------------

STARTS = np.linspace(-2.4, 0.1, 3 * CHUNK + 7 if COMPILED else 25)
COLUMNS = ("phi_s", "period", "drop", "slope", "d_eps_n1")


def assert_same(one: ReturnMap, other: ReturnMap) -> None:
    np.testing.assert_array_equal(one.start, other.start)
    for name in COLUMNS:
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert one.words == other.words
    assert one.status == other.status


@pytest.mark.parametrize("order", [1, 2])
def test_the_map_of_many_is_many_returns(order: int) -> None:
    many = return_map(TOY, STARTS, order)
    assert len(many.words) == len(many.status) == len(STARTS)
    for k, phi_s in enumerate(STARTS.tolist()):
        if k % 13:
            continue
        single = first_return(TOY, phi_s, order)
        for name in COLUMNS:
            np.testing.assert_array_equal(getattr(many, name)[k], getattr(single, name))
        assert (many.words[k], many.status[k]) == (single.word, single.status)
    assert {Status.RETURNED, Status.FREE_FALL} <= set(many.status)


def test_threads_give_the_same_map() -> None:
    with ThreadPoolExecutor(3) as pool:
        assert_same(return_map(TOY, STARTS, executor=pool), return_map(TOY, STARTS))


def test_any_shape_of_starts_and_none() -> None:
    grid = STARTS[:12].reshape(3, 4)
    assert_same(return_map(TOY, grid), return_map(TOY, STARTS[:12]))
    assert_same(return_map(TOY, grid.tolist()), return_map(TOY, STARTS[:12]))
    empty = return_map(TOY, [])
    assert (empty.phi_s.shape, empty.words, empty.status) == ((0,), (), ())


# --- Statuses and wrong input ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("law", "low", "high"),
    [("summed", -0.746, -0.740), ("separate", -0.683448, -0.677943)],
)
def test_an_impact_that_the_laws_leave_open(law: str, low: float, high: float) -> None:
    """The image of the middle of the segment lies between those of its ends."""
    toy = TOY.replace(eps_n1=0.34069658639339057, expansion_friction=law)
    result = first_return(toy, -1.7557529808118213)
    assert result.status is Status.RETURNED_INDETERMINATE
    assert result.status.success
    assert "I~1+3" in plain(result.word)
    assert low < result.phi_s < high
