"""Returns along a prescribed path: the kernel's own values, beyond their borders too."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from scenes import change
from toy_points import UPPER

from woodpecker import ExpansionFriction, Toy, first_return
from woodpecker.mechanics.modes import FIXED, model
from woodpecker.mechanics.toy import RESTITUTIONS
from woodpecker.simulation.paths import Along, Follower, Path, cause_of

LAWS = tuple(ExpansionFriction)


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
        status, path, _ = many.trace(x)
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
    _, path, _ = once.trace(x)
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
    for start, end in ((UPPER + 1e-3, UPPER - 1e-3), (UPPER - 1e-3, UPPER + 1e-3)):
        _, path, _ = toy.trace(start)
        for code in beyond(path, toy.follow(path, end)):

            def watched(x: float, path: Path = path, code: int = code) -> float:
                return margin(toy.follow(path, x), code)

            x, evaluations = secant(watched, start, end)
            found.append(x)
            assert evaluations <= 9
            assert cause_of(path, code) == "the beak and the upper sleeve strike at once"
    assert len(found) == 2  # one margin on each side
    assert max(abs(x - UPPER) for x in found) <= 2e-15


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


PARAMETERS = ("eps_n1", "eps_n2", "mu_2", "m_s", "l_s")


def following(toy: Toy, parameter: str) -> Follower:
    seed = np.zeros((1, 3))
    if parameter in RESTITUTIONS:
        seed[0, RESTITUTIONS.index(parameter)] = 1.0
        return Follower(model(toy), FIXED, seed)
    return Follower(model(toy), change(toy, parameter), seed)


def table(found: Along) -> dict[int, float]:
    return dict(zip(found.causes.tolist(), found.margins.tolist(), strict=True))


def fourth_order(v: list[float], h: float) -> float:
    return (8.0 * (v[2] - v[1]) - (v[3] - v[0])) / (12.0 * h)


@pytest.mark.nightly
@pytest.mark.parametrize("parameter", PARAMETERS)
def test_gradients_of_margins(parameter: str) -> None:
    """Every margin's derivatives against differences of order four, in random toys and starts.

    Their error is below twice the change between two steps, and their rounding, which the return
    has spread, below 1e-12 of the margin over the step. Both are below 1e-5 of the margin and its
    derivative in most places; the others are steep.
    """
    rng = np.random.default_rng(PARAMETERS.index(parameter))
    sharp = checked = 0
    for _ in range(60):
        eps_n2 = float(rng.uniform(0.05, 0.4)) if parameter == "eps_n2" else 0.0
        toy = Toy(eps_n1=float(rng.uniform(0.05, 0.9)), eps_n2=eps_n2)
        x, p = float(rng.uniform(-2.45, -0.25)), float(getattr(toy, parameter))
        many = following(toy, parameter)
        status, path, _ = many.trace(x)
        here = many.follow(path, x) if status.success else None
        if here is None:
            continue
        for column, h in ((0, 4e-6), (1, 4e-6 * p)):
            steps = (-2.0, -1.0, 1.0, 2.0, -4.0, 4.0)
            near = [
                many.follow(path, x + k * h)
                if column == 0
                else following(toy.replace(**{parameter: p + k * h}), parameter).follow(path, x)
                for k in steps
            ]
            tables = [table(found) for found in near if found is not None]
            if len(tables) < len(steps):
                continue  # a grazing is that near
            for code, m, exact in zip(
                here.causes.tolist(), here.margins, here.gradients[:, column], strict=True
            ):
                if not all(code in t for t in tables):
                    continue
                a, b, c, d, e, f = (t[code] for t in tables)
                fine, coarse = fourth_order([a, b, c, d], h), fourth_order([e, a, d, f], 2.0 * h)
                size = abs(m) + max(map(abs, (a, b, c, d, e, f)))
                bound = 2.0 * abs(fine - coarse) + 1e-12 * size / h + 1e-9 * abs(exact)
                assert abs(fine - exact) <= bound, cause_of(path, code)
                checked += 1
                sharp += bound <= 1e-5 * (abs(exact) + size)
    assert sharp > 0.8 * checked > 3000


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


@pytest.mark.nightly
def test_margins_are_positive_where_the_kernel_takes_the_path() -> None:
    """In random toys, with all restitutions and frictions; no border is met to 1e-9 by chance."""
    rng = np.random.default_rng(3)
    for _ in range(30):
        eps = {name: float(rng.uniform(0.0, 0.9)) for name in RESTITUTIONS}
        mu = {"mu_1": rng.uniform(0.05, 0.6), "mu_2": rng.uniform(0.3, 0.6), "mu_3": 0.3}
        toy = Toy(**eps, **mu, expansion_friction=LAWS[int(rng.integers(2))])
        many = Follower(model(toy))
        for x in rng.uniform(-2.5, -0.24, 100):
            status, path, _ = many.trace(x)
            if not status.success:
                continue
            found = many.follow(path, x)
            assert found is not None
            worst = int(found.margins.argmin())
            assert found.margins[worst] > 0.0, (toy, x, cause_of(path, int(found.causes[worst])))
            assert np.isfinite(found.gradients).all()
