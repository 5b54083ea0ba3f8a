"""Returns along a prescribed path: the kernel's own values, beyond their borders too."""

from collections.abc import Callable

import numpy as np
import pytest
from toy_points import UPPER

from woodpecker import ExpansionFriction, Toy, first_return
from woodpecker.mechanics.modes import model
from woodpecker.simulation.paths import Follower, Path, PathReturn, cause_of


def follower(eps_n1: float, law: ExpansionFriction = ExpansionFriction.SUMMED) -> Follower:
    return Follower(model(Toy(eps_n1=eps_n1, expansion_friction=law)))


def secant(f: Callable[[float], float], a: float, b: float) -> tuple[float, int]:
    """Root of f and how often it was evaluated."""
    f_a, f_b, n = f(a), f(b), 2
    while f_b != 0.0 and f_b != f_a and abs(b - a) > 1e-16:
        a, b, f_a = b, b - f_b * (b - a) / (f_b - f_a), f_b
        f_b, n = f(b), n + 1
    return b, n


def margin(found: PathReturn | None, code: int) -> float:
    assert found is not None
    return float(found.margins[found.causes.tolist().index(code)])


def beyond(path: Path, there: PathReturn | None) -> list[int]:
    """Codes of the margins that are negative."""
    assert there is not None
    return [int(code) for m, code in zip(there.margins, there.causes, strict=True) if m < 0.0]


def test_a_path_runs_on_smoothly_beyond_its_border() -> None:
    """One polynomial fits its values on both sides, as only a smooth map's do."""
    toy = follower(0.185)
    _, path, _ = toy.trace(UPPER + 1e-3)
    x = UPPER + np.linspace(-2e-3, 2e-3, 41)
    y = np.array([found.phi_s for s in x if (found := toy.follow(path, s)) is not None])
    assert len(y) == 41
    fit = np.polynomial.Polynomial.fit(x, y, 8)
    assert np.abs(fit(x) - y).max() < 1e-11
    assert first_return(Toy(eps_n1=0.185), x[0]).phi_s != pytest.approx(y[0], abs=1e-3)


def test_every_cause_has_a_sentence_and_a_place() -> None:
    toy = follower(0.5)
    for s in np.linspace(-2.2, -0.3, 40):
        _, path, _ = toy.trace(float(s))
        found = toy.follow(path, float(s))
        assert found is not None
        assert np.all(np.diff(found.causes) > 0)
        for code in found.causes:
            cause = cause_of(path, int(code))
            assert cause[0].islower()
            assert "None" not in cause


def test_a_flight_becomes_infinitely_short() -> None:
    """At a border where the sleeve's impact only just throws it off, one margin changes sign.

    The flight's duration goes through zero there, smoothly: the map on the side where there is a
    flight runs on beyond the border, and nothing else vanishes.
    """
    toy = follower(0.5)
    _, path, _ = toy.trace(-0.552)
    (code,) = beyond(path, toy.follow(path, -0.5521))
    assert cause_of(path, code) == "the lower sleeve only just leaves the pole"
    border, evaluations = secant(lambda x: margin(toy.follow(path, x), code), -0.552, -0.5521)
    assert evaluations <= 8
    here, there = toy.follow(path, border), toy.follow(path, border - 1e-5)
    assert here is not None
    assert there is not None
    assert abs(margin(here, code)) < 1e-15  # rad, of terms near 0.01
    assert abs(here.times).min() < 1e-15
    assert there.times.min() < -1e-6
    others = here.margins[here.causes != code]
    assert others.min() > 1e-4
    x = border + np.linspace(-1e-4, 1e-4, 21)
    y = np.array([found.phi_s for s in x if (found := toy.follow(path, s)) is not None])
    assert len(y) == 21
    fit = np.polynomial.Polynomial.fit(x, y, 5)
    assert np.abs(fit(x) - y).max() < 1e-12
