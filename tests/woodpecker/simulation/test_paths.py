"""Returns along a prescribed path: the kernel's own values, beyond their borders too."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from woodpecker import Toy, first_return
from woodpecker.mechanics.modes import FIXED, change, model
from woodpecker.mechanics.toy import ExpansionFriction
from woodpecker.simulation.paths import Along, Follower, Path, Watch, cause_of

LAWS = tuple(ExpansionFriction)
C_JUMP = -0.7577872573415617  # rad; the jump of P_1 at C, in README's table of facts


def follower(eps_n1: float, law: ExpansionFriction = ExpansionFriction.SUMMED) -> Follower:
    return Follower(model(Toy(eps_n1=eps_n1, expansion_friction=law)))


def secant(f: Callable[[float], float], a: float, b: float) -> tuple[float, int]:
    """Root of f and how often it was evaluated."""
    f_a, f_b, n = f(a), f(b), 2
    while f_b != 0.0 and f_b != f_a and abs(b - a) > 1e-16:
        a, b, f_a = b, b - f_b * (b - a) / (f_b - f_a), f_b
        f_b, n = f(b), n + 1
    return b, n


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("eps_n1", [0.05, 0.34, 0.8])
def test_the_kernel_returns_along_the_path_it_found(eps_n1: float, law: ExpansionFriction) -> None:
    """Value, period, drop and derivatives, in random starts; all margins are positive there.

    Steep returns spread the last bit of an event time: 1e-11 relative to the slope.
    """
    toy = Toy(eps_n1=eps_n1, expansion_friction=law)
    many = follower(eps_n1, law)
    rng = np.random.default_rng(1)
    followed = 0
    for x in rng.uniform(-2.45, -0.25, 60):
        status, path = many.trace(x)
        if not status.success:
            continue
        once, again = first_return(toy, x), many.follow(path, x)
        assert again is not None
        assert path.word == once.word
        assert again.phi_s == pytest.approx(once.phi_s, abs=1e-13 + 1e-14 * abs(once.slope))
        assert again.period == pytest.approx(once.period, abs=1e-13)
        assert again.drop == pytest.approx(once.drop, abs=1e-13)
        assert again.slope == pytest.approx(once.slope, rel=1e-9, abs=1e-9)
        if math.isfinite(once.d_eps_n1):
            assert again.d_parameter == pytest.approx(once.d_eps_n1, rel=1e-9, abs=1e-9)
        assert again.margins.min() > 0.0, cause_of(path, int(again.causes[again.margins.argmin()]))
        followed += 1
    assert followed > 50


@pytest.mark.parametrize("parameter", ["mu_1", "c_phi", "l_s"])
def test_derivatives_in_other_parameters(parameter: str) -> None:
    """Against a difference of order four of the path itself; its error is near 1e-9 here."""
    toy, x = Toy(), -0.6
    value = float(getattr(toy, parameter))
    once = Follower(model(toy), change(toy, parameter), np.zeros((1, 3)))
    _, path = once.trace(x)
    here = once.follow(path, x)

    def image(relative: float) -> float:
        other = Follower(model(toy.replace(**{parameter: value * (1.0 + relative)})))
        found = other.follow(path, x)
        assert found is not None
        return found.phi_s

    h = 1e-4
    difference = (8.0 * (image(h) - image(-h)) - image(2 * h) + image(-2 * h)) / (12.0 * h * value)
    assert here is not None
    assert here.d_parameter == pytest.approx(difference, rel=1e-7)


def margin(found: Along | None, code: int) -> float:
    assert found is not None
    return float(found.margins[found.causes.tolist().index(code)])


def beyond(path: Path, there: Along | None) -> list[int]:
    """Codes of the margins that are negative."""
    assert there is not None
    return [int(code) for m, code in zip(there.margins, there.causes, strict=True) if m < 0.0]


def test_the_jump_at_c_is_one_root_from_both_sides() -> None:
    """The words on both sides run on beyond it; their margins vanish at the same double, nearly."""
    toy = follower(0.185)
    found = []
    for start, end in ((C_JUMP + 1e-3, C_JUMP - 1e-3), (C_JUMP - 1e-3, C_JUMP + 1e-3)):
        _, path = toy.trace(start)
        for code in beyond(path, toy.follow(path, end)):

            def watched(x: float, path: Path = path, code: int = code) -> float:
                return margin(toy.follow(path, x), code)

            x, evaluations = secant(watched, start, end)
            found.append(x)
            assert evaluations <= 9
            assert cause_of(path, code).sentence == "the beak and the upper sleeve strike at once"
    assert len(found) == 3
    assert max(abs(x - C_JUMP) for x in found) <= 2e-15


def test_a_path_runs_on_smoothly_beyond_its_border() -> None:
    """One polynomial fits its values on both sides, as only a smooth map's do."""
    toy = follower(0.185)
    _, path = toy.trace(C_JUMP + 1e-3)
    x = C_JUMP + np.linspace(-2e-3, 2e-3, 41)
    y = np.array([found.phi_s for s in x if (found := toy.follow(path, s)) is not None])
    assert len(y) == 41
    fit = np.polynomial.Polynomial.fit(x, y, 8)
    assert np.abs(fit(x) - y).max() < 1e-11
    assert first_return(Toy(eps_n1=0.185), x[0]).phi_s != pytest.approx(y[0], abs=1e-3)


def test_margins_vanish_wherever_the_word_changes() -> None:
    """Between neighbouring starts with different words some margin of each word changes sign."""
    toy = follower(0.5)
    x = np.linspace(-2.2, -0.3, 400)
    paths = [toy.trace(s)[1] for s in x]
    changes = [k for k in range(len(x) - 1) if paths[k].word != paths[k + 1].word]
    assert len(changes) > 15
    for k in changes:
        for path, there in ((paths[k], x[k + 1]), (paths[k + 1], x[k])):
            found = toy.follow(path, float(there))
            assert found is None or found.margins.min() < 0.0, (path.word, there)


def test_every_cause_has_a_sentence() -> None:
    toy = follower(0.5)
    for s in np.linspace(-2.2, -0.3, 40):
        _, path = toy.trace(float(s))
        found = toy.follow(path, float(s))
        assert found is not None
        for code in found.causes:
            cause = cause_of(path, int(code))
            assert isinstance(cause.watch, Watch)
            assert cause.sentence[0].islower()
            assert "None" not in cause.sentence
    assert FIXED.shape[0] == 0
