"""Smallest changes: known limits, stationarity, and nothing nearer in random directions."""

import pickle
import re
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from needs import NEEDS_NUMBA, NIGHTLY_TOY, SLOW_TOY

from woodpecker import Toy, first_return, shoot
from woodpecker.robustness import Effect, Robustness, SmallestChange, meeting, smallest_changes
from woodpecker.robustness.changes import space_of
from woodpecker.robustness.meeting import met_along
from woodpecker.robustness.nearest import first_guesses
from woodpecker.robustness.smallest import STEPPING
from woodpecker.toy_map import ToyPieces, line_of_toys

GUESS = -0.53  # rad, near the stable cycle
NAMES = ("r_m", "l_s", "mu_2", "eps_n1", "eps_n2")


@cache
def of_some() -> Robustness:
    """Over some parameters, one at zero among them."""
    toy = Toy()
    return smallest_changes(toy, shoot(toy, GUESS), NAMES)


@pytest.mark.nightly
def test_nearest_is_a_flip_and_nearer_than_single_changes() -> None:
    nearest = of_some().nearest
    assert nearest is not None
    assert nearest.effect is Effect.DESTABILISED
    assert nearest.kind == "PD"
    # derivatives of the multiplier are differences, good to some 1e-7; what it costs is the square
    assert nearest.angle < 1e-6
    assert nearest.confirmed, nearest.evidence
    orbit = shoot(nearest.toy, nearest.phi_s)
    assert orbit.multiplier == pytest.approx(-1.0, abs=1e-8)  # 1e-11 of change times slope of 500
    singles = [abs(each.percent) for each in of_some().limits]
    assert 100.0 * nearest.size < np.nanmin(singles)
    total = np.linalg.norm(list(nearest.changes.values()))
    assert total == pytest.approx(100.0 * nearest.size, rel=1e-12)


@pytest.mark.nightly
def test_nothing_is_nearer_in_random_directions() -> None:
    toy, nearest = Toy(), of_some().nearest
    assert nearest is not None
    rng = np.random.default_rng(15)
    sizes = np.array([getattr(toy, name) or 1.0 for name in NAMES])
    for _ in range(100):
        u = rng.normal(size=len(NAMES))
        u[-1] = abs(u[-1])  # a restitution that is zero goes upwards only
        u *= nearest.size / np.linalg.norm(u)
        x = shoot(toy, GUESS).phi_s
        for part in (0.25, 0.5, 0.75, 0.999):
            changed = {
                name: getattr(toy, name) + part * by
                for name, by in zip(NAMES, (sizes * u).tolist(), strict=True)
            }
            orbit = shoot(toy.replace(**changed), x)
            assert orbit.success, changed
            assert orbit.stable, changed
            assert abs(orbit.phi_s - x) < 0.02  # the same motion: a quarter of so small a change
            x = orbit.phi_s


@SLOW_TOY
def test_a_limit_is_where_shooting_first_finds_an_unstable_motion() -> None:
    """Between two flips three samples lie, of which two are flips: no spike of instability."""
    toy = Toy()
    orbit = shoot(toy, GUESS)
    space = space_of(orbit, ("j_s",), STEPPING)
    (lost,) = met_along(space, np.array([-1.0]), past=False)
    at = space.toy_at(lost.u).j_s
    x, stable = orbit.phi_s, list[float]()
    for j_s in np.linspace(toy.j_s, 4.5e-7, 251).tolist():
        found = shoot(toy.replace(j_s=j_s), x)
        assert found.success, j_s
        if not found.stable:
            break
        x = found.phi_s
        stable.append(j_s)
    assert j_s < at < stable[-1]
    assert shoot(toy.replace(j_s=at), x).multiplier == pytest.approx(-1.0, abs=1e-9)
    assert lost.effect is Effect.DESTABILISED


@NEEDS_NUMBA
def test_a_branch_of_two_samples_is_judged_by_a_cycle_between_them() -> None:
    toy = Toy()
    line = line_of_toys(toy, {"j_s": -toy.j_s})
    for at, stable in (((0.1, 0.2), True), ((0.2072, 0.2402), False)):  # flips: 0.20717, 0.24030
        ends = [shoot(toy.replace(j_s=toy.j_s * (1.0 - p)), GUESS) for p in at]
        curve = SimpleNamespace(
            parameter=np.array(at), points=[np.array([[each.phi_s]]) for each in ends],
            multiplier=np.array([-1.0, -1.0]),
        )  # fmt: skip
        assert meeting._is_stable(line, curve, STEPPING) is stable  # type: ignore[arg-type]


def test_line_agrees_with_single_parameter() -> None:
    toy = Toy().replace(eps_n2=0.1)
    for name in NAMES:
        one = line_of_toys(toy, {name: 1.0}).at(GUESS, 0.0)
        other = ToyPieces(toy, name).at(GUESS, getattr(toy, name))
        assert one.value == other.value
        assert one.d_parameter == pytest.approx(other.d_parameter, rel=1e-13)
        assert np.array_equal(one.margins, other.margins)


def test_a_copy_of_a_line_is_the_same_line() -> None:
    line = line_of_toys(Toy(eps_n2=0.1), {"r_m": 3e-4, "mu_2": -0.2})
    copy = pickle.loads(pickle.dumps(line))
    assert copy == line != ToyPieces(line.toy)
    there, again = line.at(GUESS, 0.1), copy.at(GUESS, 0.1)
    assert (again.value, again.d_parameter) == (there.value, there.d_parameter)
    changed = line.toy.replace(r_m=line.toy.r_m + 0.1 * 3e-4, mu_2=line.toy.mu_2 - 0.1 * 0.2)
    key, value = copy.taken(GUESS, 0.1)
    assert key == there.piece.key
    for each in (value, first_return(changed, GUESS).phi_s):
        assert each == pytest.approx(there.value, abs=1e-11)  # rounding of a return, some 1e-12
    with pytest.raises(ValueError, match="leave the pole as it is"):
        line_of_toys(line.toy, {"pole": 1.0})


def test_line_derivative_is_the_sum_of_single_ones() -> None:
    toy = Toy(eps_n2=0.1)
    rates = {"r_m": 3e-4, "mu_2": -0.2, "eps_n1": 0.3}
    whole = line_of_toys(toy, rates).at(GUESS, 0.0)
    each = [
        rate * line_of_toys(toy, {name: 1.0}).at(GUESS, 0.0).d_parameter
        for name, rate in rates.items()
    ]
    assert whole.d_parameter == pytest.approx(sum(each), rel=1e-12)  # rounding of three terms


def test_each_way_of_one_parameter_is_followed_once() -> None:
    orbit = shoot(Toy(), GUESS)
    ways = [np.sign(u) for u in first_guesses(space_of(orbit, ("mu_2",), STEPPING))]
    assert len(ways) == len(np.unique(ways)) == 2


def test_what_is_no_stable_motion_is_refused() -> None:
    toy = Toy()
    orbit = shoot(toy, GUESS)
    with pytest.raises(ValueError, match="another toy"):
        smallest_changes(toy.replace(mu_2=0.31), orbit)
    with pytest.raises(ValueError, match="other than the pole"):
        smallest_changes(toy, orbit, ["pole"])
    unstable = shoot(toy.replace(eps_n1=0.7), orbit.phi_s)
    with pytest.raises(ValueError, match="stable motion"):
        smallest_changes(unstable.toy, unstable)
    lost = shoot(toy, -0.1)
    with pytest.raises(ValueError, match="needs a periodic motion"):
        smallest_changes(toy, lost)


# --- Spikes ---------------------------------------------------------------------------------------


@NIGHTLY_TOY
def test_a_spike_at_a_grazing_is_no_end() -> None:
    """Right before a grazing the multiplier, -0.87 on both sides, has no bound.

    The ordinary flip lies twice as far. Some spikes are thinner than doubles tell: one machine sees
    a spike there, another a kink.
    """
    toy = Toy(m_s=0.006, h_s=0.021, mu_1=0.35, mu_2=0.29, mu_3=0.28)
    found = smallest_changes(toy, shoot(toy, GUESS))
    nearest = found.nearest
    assert nearest is not None
    assert (nearest.effect, nearest.kind) == (Effect.DESTABILISED, "PD")
    assert nearest.confirmed, nearest.evidence
    assert nearest.size == pytest.approx(0.006176, abs=1e-6)  # as many digits as are written here
    flip = shoot(nearest.toy, nearest.phi_s)
    assert flip.multiplier == pytest.approx(-1.0, abs=1e-6)
    confirmed = [row.confirmed for row in found.critical]
    assert confirmed == sorted(confirmed, reverse=True)
    grazing = [row for row in found.harmless if "grazes the pole" in row.cause]
    assert 0.0029 < min(row.size for row in grazing) < 0.003
    assert Effect.SPIKED in {row.effect for row in grazing}
    for row in grazing:
        assert row.confirmed, row.evidence
        before, beyond = map(float, re.findall(r"multiplier (-0\.8\d*)", row.evidence))
        assert before == pytest.approx(beyond, abs=1e-3)  # the change is longer than one of words


def row(size: float, *, confirmed: bool) -> SmallestChange:
    return SmallestChange(
        effect=Effect.DESTROYED, kind="BC", cause="", size=size, changes={}, toy=Toy(), phi_s=0.0,
        word="", stable=True, angle=0.0, confirmed=confirmed, evidence="",
    )  # fmt: skip


def test_what_is_nearest_is_confirmed() -> None:
    orbit = shoot(Toy(), GUESS)
    for rows, size in (((row(0.2, confirmed=True), row(0.1, confirmed=False)), 0.2), ((), None)):
        found = Robustness(orbit=orbit, critical=rows, harmless=(), limits=())
        assert (found.nearest.size if found.nearest else None) == size
    only = Robustness(orbit=orbit, critical=(row(0.1, confirmed=False),), harmless=(), limits=())
    assert only.nearest is None
    assert repr(only).startswith("Robustness(nothing confirmed; 1 critical change")


@pytest.mark.nightly
def test_a_step_of_the_search_to_no_toy_leaves_what_was_found(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With all twenty parameters a step of SLSQP had its beak inside the pole."""

    def too_far(_: object, start: np.ndarray, *, constraints: dict[str, Any], **__: object) -> Any:
        return constraints["fun"](start + 1e6)  # l_s is some kilometres there

    monkeypatch.setattr("woodpecker.robustness.nearest.minimize", too_far)
    toy = Toy()
    found = smallest_changes(toy, shoot(toy, GUESS), ("l_s", "l_g")).nearest
    assert found is not None
    assert found.kind == "PD"
    monkeypatch.undo()
    exact = smallest_changes(toy, shoot(toy, GUESS), ("l_s", "l_g")).nearest
    assert exact is not None
    # before the search the sine of the angle to the nearest is 0.05 or less; half of its square
    assert found.size == pytest.approx(exact.size, rel=1.3e-3)


# --- What is nearest ------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_nearest_end_of_one_parameter_is_the_smaller_of_its_limits() -> None:
    """Of a cycle of two points, which ends at a border downwards and at a fold upwards."""
    toy = Toy(eps_n1=0.67)
    found = smallest_changes(toy, shoot(toy, -0.5, 2), ["eps_n1"])
    down, up = found.limits
    assert (down.kind, up.kind) == ("BC", "LP")
    assert found.nearest is not None
    assert found.nearest.size == pytest.approx(-0.01 * down.percent, rel=1e-9)
    assert -down.percent < up.percent
    before = shoot(toy.replace(eps_n1=down.value * (1.0 + 1e-6)), [-0.51269, -0.52684])
    assert before.stable
    assert before.points[0] == pytest.approx(found.nearest.phi_s, abs=1e-4)


@pytest.mark.parametrize("most", [0.33541645426420436, 0.05])
def test_a_flip_before_a_root_is_met_in_steps_of_any_length(most: float) -> None:
    """The border at the root, with the slope -6e15, hid a flip and a collision before it."""
    toy = Toy()
    space = space_of(shoot(toy, GUESS), ("mu_2", "eps_n1"), STEPPING)
    flip, collision = met_along(space, np.array([-0.16718318, -0.01326018]), most)
    assert (flip.kind, collision.kind) == ("PD", "BC")
    assert flip.size < collision.size
    motions = [
        shoot(space.toy_at(part * flip.u), float(flip.orbit.x[0, 0])) for part in (0.999, 1.001)
    ]
    assert motions[0].multiplier > -1.0 > motions[1].multiplier
