"""Stumpff's functions and first roots of guards against mpmath and dense sampling."""

import math

import mpmath
import numpy as np
import numpy.typing as npt
import pytest
from mpmath import mpf

from woodpecker.base.compiled import COMPILED
from woodpecker.motion.guards import EPSILON, first_root, stumpff, value

FloatArray = npt.NDArray[np.float64]
Jet = tuple[float, float, float, float]

DIGITS = 50
MANY = 1000 if COMPILED else 50  # plain Python is a hundred times slower
REGIMES = {"trigonometric": -1.0, "hyperbolic": 1.0, "polynomial": 0.0}
regimes = pytest.mark.parametrize("sign", REGIMES.values(), ids=REGIMES)

# A root's residual in units of EPSILON times the largest term of f, itself good to (1 + omega t)
# EPSILON: five functions with a few roundings each.
RESIDUAL = 16.0


def close(expected: float, rel: float) -> object:
    """``expected`` up to a relative error, however small it is."""
    return pytest.approx(expected, rel=rel, abs=0.0)


def root(jet: Jet, kappa: float, horizon: float = math.inf) -> float:
    return first_root(*jet, kappa, math.sqrt(abs(kappa)), horizon)


# --- The same functions to fifty digits -----------------------------------------------------------


def exact_stumpff(kappa: float, t: mpf | float) -> list[mpf]:
    """c0, t c1, ... t^4 c4 in closed form."""
    k, t = mpf(kappa), mpf(t)
    if k == 0:
        return [t**n / mpmath.factorial(n) for n in range(5)]
    w = mpmath.sqrt(abs(k))
    cosine, sine = (mpmath.cos, mpmath.sin) if k < 0 else (mpmath.cosh, mpmath.sinh)
    c0, s1 = cosine(w * t), sine(w * t) / w
    s2 = (c0 - 1) / k
    return [c0, s1, s2, (s1 - t) / k, (s2 - t**2 / 2) / k]


def terms(jet: Jet, kappa: float, t: mpf | float) -> list[mpf]:
    """The terms of f."""
    _, _, s2, s3, _ = exact_stumpff(kappa, t)
    return [f * s for f, s in zip(jet, (1, mpf(t), s2, s3), strict=True)]


def exact(jet: Jet, kappa: float, t: mpf | float) -> mpf:
    return mpmath.fsum(terms(jet, kappa, t))


def exact_slope(jet: Jet, kappa: float, t: mpf | float) -> mpf:
    _, s1, s2, _, _ = exact_stumpff(kappa, t)
    return jet[1] + jet[2] * s1 + jet[3] * s2


def exact_root(jet: Jet, kappa: float, near: float) -> mpf:
    """Newton's method from a root that is good to some digits."""
    t = mpf(near)
    for _ in range(8):  # from 10 digits to all fifty in three steps
        t -= exact(jet, kappa, t) / exact_slope(jet, kappa, t)
    return t


def assert_is_root(jet: Jet, kappa: float, t: float) -> None:
    """F vanishes there as well as the rounding of its terms and of its argument allows."""
    with mpmath.workdps(DIGITS):
        phase = math.sqrt(abs(kappa)) * t
        size = max(abs(x) for x in terms(jet, kappa, t)) + abs(exact_slope(jet, kappa, t)) * t
        residual = abs(exact(jet, kappa, t))
        assert residual <= RESIDUAL * EPSILON * (1.0 + phase) * size


def sampled(jet: Jet, kappa: float, t: FloatArray) -> FloatArray:
    """F in units of the sum of its terms, from numpy's functions; good to 1e-11 or so."""
    w = math.sqrt(abs(kappa))
    s2, s3 = t**2 / 2.0, t**3 / 6.0
    if w > 0.0:
        sine = np.sin if kappa < 0.0 else np.sinh
        s2 = 2.0 * (sine(0.5 * w * t) / w) ** 2
        series = t**3 / 6.0 * (1.0 + kappa * t**2 / 20.0)  # next term below 1e-11 at w t = 0.01
        s3 = np.where(w * t < 0.01, series, (sine(w * t) / w - t) / kappa)
    parts = np.array([np.full_like(t, jet[0]), jet[1] * t, jet[2] * s2, jet[3] * s3])
    return np.asarray(parts.sum(axis=0) / np.abs(parts).sum(axis=0))


# --- Stumpff's functions --------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    ("phases", "errors"),
    [
        ((-8.0, 0.0), (4.0, 4.0, 4.0, 4.0, 4.0)),  # series: some roundings
        # Below omega t = 3, s1 - t and s2 - t^2/2 cancel to a sixth and a twelfth.
        ((0.0, 0.5), (4.0, 4.0, 4.0, 24.0, 96.0)),
        ((0.5, 2.3), (4.0, 4.0, 4.0, 4.0, 4.0)),  # closed forms: rounding of the argument
        ((2.3, 8.0), (4.0, 4.0, 4.0, 4.0, 4.0)),
    ],
    ids=["series", "beyond the series", "swings", "many swings"],
)
@regimes
def test_stumpff(sign: float, phases: tuple[float, float], errors: tuple[float, ...]) -> None:
    if sign > 0.0 and phases[1] > 2.5:
        return  # cosh overflows
    rng = np.random.default_rng(1)
    with mpmath.workdps(DIGITS):
        for _ in range(MANY):
            omega, phase = 10.0 ** rng.uniform((-3.0, phases[0]), (3.0, phases[1]))
            kappa, t = sign * omega**2, phase / omega
            expected = exact_stumpff(kappa, t)
            size = [abs(x) for x in expected]
            if sign < 0.0 and phase >= 1.0:  # sine and cosine may be near a zero
                size = [1.0, 1.0 / omega, omega**-2, t * omega**-2, t * t * omega**-2]
            found = stumpff(kappa, math.sqrt(abs(kappa)), t)
            for n in range(5):
                allowed = errors[n] * EPSILON * (1.0 + phase) * size[n]
                assert abs(found[n] - expected[n]) <= allowed


@pytest.mark.slow
@regimes
def test_value_is_the_closed_form(sign: float) -> None:
    rng = np.random.default_rng(2)
    with mpmath.workdps(DIGITS):
        for _ in range(MANY):
            omega, phase = 10.0 ** rng.uniform((-2.0, -4.0), (3.0, 1.5))
            kappa, t = sign * omega**2, phase / omega
            jet: Jet = tuple((rng.normal(size=4) * omega ** np.arange(4.0)).tolist())
            f, slope = value(*jet, kappa, math.sqrt(abs(kappa)), t)
            # Coefficients up to 4 times omega^n; s1, s2, s3 up to cosh(phase) / omega^n.
            allowed = RESIDUAL * EPSILON * (1.0 + phase) ** 3
            allowed *= math.cosh(phase) if sign > 0.0 else 1.0
            assert abs(f - exact(jet, kappa, t)) <= allowed
            assert abs(slope - exact_slope(jet, kappa, t)) <= allowed * omega


# --- First roots of random guards -----------------------------------------------------------------


def random_guard(rng: np.random.Generator, sign: float) -> tuple[Jet, float, float]:
    """Jet, kappa and horizon; up to three leading zeros, then positive, sizes over six decades."""
    omega = 10.0 ** rng.uniform(-2.0, 3.0)
    unit = omega ** np.arange(4.0)
    jet = rng.normal(size=4) * 10.0 ** rng.uniform(-3.0, 3.0, size=4) * unit
    zeros = rng.integers(4)
    jet[:zeros] = 0.0
    jet[zeros] = abs(jet[zeros])
    horizon = 10.0 ** rng.uniform(-1.0, 2.0 if sign < 0.0 else 1.5) / omega
    f0, f1, f2, f3 = jet.tolist()
    return (f0, f1, f2, f3), sign * omega**2, horizon


@pytest.mark.slow
@regimes
def test_first_root_of_random_guards(sign: float) -> None:
    """It is a root, f falls there, and f is positive at 2000 samples before it."""
    rng, found = np.random.default_rng(3), 0
    for _ in range(3 * MANY):
        jet, kappa, horizon = random_guard(rng, sign)
        t = root(jet, kappa, horizon)
        end = min(t, horizon)
        before = np.linspace(0.0, end, 2001)[1:-1]
        assert sampled(jet, kappa, before).min() > -1e-10  # the samples are good to 1e-11
        if t <= horizon:
            found += 1
            assert_is_root(jet, kappa, t)
            assert value(*jet, kappa, math.sqrt(abs(kappa)), t)[1] <= 0.0
    assert found > 0.5 * MANY


# --- Zeros at the start ---------------------------------------------------------------------------

# f is at zero where a guard has just fired, and the first non-zero derivative is positive.
TINY = [10.0**-n for n in range(1, 19)]
KAPPAS = {
    "slow": -1.0, "free flight": -2.0984e5, "slow and hyperbolic": 1.0,
    "upper sleeve contact": 532.49, "polynomial": 0.0,
}  # fmt: skip
kappas = pytest.mark.parametrize("kappa", KAPPAS.values(), ids=KAPPAS)


@kappas
@pytest.mark.parametrize("size", [1.0, 3.7e5, 1.3e-9])
def test_roots_close_to_zero(kappa: float, size: float) -> None:
    """Down to 1e-18 of the swing: f = t0 - t, t (2 t0 - t) / 2, t^2 (3 t0 - t) / 6 to first order.

    The next order, kappa t^2 / 20 at most, is below 1e-3 for omega t0 <= 0.1.
    """
    unit = 1.0 / math.sqrt(abs(kappa)) if kappa != 0.0 else 1.0
    for t0 in [unit * t for t in TINY]:
        for jet, expected in (
            ((size * t0, -size, 0.0, 0.0), t0),
            ((0.0, size * t0, -size, 0.0), 2.0 * t0),
            ((0.0, 0.0, size * t0, -size), 3.0 * t0),
        ):
            found = root(jet, kappa)
            assert found == close(expected, rel=5e-3)
            assert_is_root(jet, kappa, found)


@kappas
def test_a_short_dip_right_after_the_start(kappa: float) -> None:
    """f = (t - t0)^2 / 2 - t0^2 / 4 is below zero from (1 - 1/sqrt(2)) t0 on."""
    unit = 1.0 / math.sqrt(abs(kappa)) if kappa != 0.0 else 1.0
    for t0 in [unit * t for t in TINY[1:-4]]:
        found = root((0.25 * t0**2, -t0, 1.0, 0.0), kappa)
        # 1e-3 for kappa t^2 / 12; below omega t0 = 1e-14 rounding of the phase hides the dip.
        assert found == close((1.0 - math.sqrt(0.5)) * t0, rel=2e-3)


# --- Roots in closed form -------------------------------------------------------------------------

CLOSED: list[tuple[Jet, float, float]] = [
    # Two zeros and a positive derivative: it rises, or it grazes for ever and is never less.
    *(((0.0, *rises), kappa, math.inf)
      for kappa in KAPPAS.values()
      for rises in ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0))),
    *(((3.0, drift, -1.0, 0.0), -1.0, math.inf)  # 2 + drift t + cos t
      for drift in (0.0, 1e-9, 1.0, 3.0)),
    # A double root is none; all numbers are exact here, so f touches zero exactly.
    ((2.0, 0.0, -1.0, 0.0), -1.0, math.inf),  # 1 + cos t
    ((2.0, 0.0, 1.0, 0.0), -1.0, math.inf),  # 3 - cos t
    ((1.0, -2.0, 2.0, 0.0), 0.0, math.inf),  # (t - 1)^2
    ((3.0, -7.0, 10.0, -6.0), 0.0, 3.0),  # (t - 1)^2 (3 - t)
    ((4.0, -9.0, 12.0, -6.0), 0.0, 4.0),  # (t - 1)^2 (4 - t)
    # Far away; beyond omega t = 512 nothing is sought: 1 - a (cosh t - 1).
    *(((1.0, 0.0, -a, 0.0), 1.0, float(mpmath.acosh(1 + 1 / mpf(a))))
      for a in (1.0, 1e-10, 1e-100, 1e-200)),
    ((1.0, 0.0, 0.0, 0.0), 0.0, math.inf),
    *((jet, 0.0, far)
      for far in (1e3, 1e12, 1e29)
      for jet in ((far, -1.0, 0.0, 0.0), (1.0, 0.0, -2.0 / far**2, 0.0),
                  (1.0, 0.0, 0.0, -6.0 / far**3))),
]  # fmt: skip


@pytest.mark.parametrize(("jet", "kappa", "expected"), CLOSED)
def test_roots_in_closed_form(jet: Jet, kappa: float, expected: float) -> None:
    assert root(jet, kappa) == close(expected, rel=4.0 * EPSILON)


@pytest.mark.parametrize("depth", [1e-15, 1e-12, 1e-6])
def test_a_shallow_dip_is_seen(depth: float) -> None:
    """1 + cos t - depth is negative near pi: its first root is pi - sqrt(2 depth)."""
    found = root((2.0 - depth, 0.0, -1.0, 0.0), -1.0)
    # The depth itself is rounded to EPSILON, a fifth of the smallest; hence a tenth of the root.
    assert math.pi - found == close(math.sqrt(2.0 * depth), rel=0.2 * 1e-15 / depth + 1e-6)
    assert root((2.0 + depth, 0.0, -1.0, 0.0), -1.0) == math.inf
    dip = (1.0 - depth, -2.0, 2.0, 0.0)  # (t - 1)^2 - depth
    assert 1.0 - root(dip, 0.0) == close(math.sqrt(depth), rel=0.2 * 1e-15 / depth + 1e-6)


# --- Drift ----------------------------------------------------------------------------------------


def drifting(turns: float, radius: float, phase: float) -> Jet:
    """f = 1 + drift t - radius cos(t - phase), kappa = -1: its minima reach 0 after ``turns``."""
    drift = -(1.0 - radius) / (2.0 * math.pi * turns)
    cosine, sine = radius * math.cos(phase), radius * math.sin(phase)
    return 1.0 - cosine, drift - sine, cosine, sine


@pytest.mark.slow
@pytest.mark.parametrize("turns", [3.3, 1e3, 1e6])
def test_the_swing_that_reaches_zero(turns: float) -> None:
    """The minimum one swing earlier is still positive, so this root is the first."""
    rng = np.random.default_rng(5)
    for _ in range(MANY // 20):
        jet = drifting(turns * rng.uniform(1.0, 2.0), rng.uniform(0.2, 0.9), rng.uniform(0.5, 6.0))
        found = root(jet, -1.0)
        assert_is_root(jet, -1.0, found)
        with mpmath.workdps(DIGITS):
            first = exact_root(jet, -1.0, found)
            # One rounding of the drift, 1e-16 of f1, moves f by 1e-16 t; f' at the root is about
            # sqrt(2 radius times a random part of what f falls in one swing, 1 / turns).
            assert abs(found - first) <= 1e-15 * first * (1.0 + math.sqrt(turns)) * 100.0
            minimum = first - 2.0 * mpmath.pi
            for _ in range(20):  # Newton's method for f' = 0; f'' > 0 near a minimum
                c0, s1, _, _, _ = exact_stumpff(-1.0, minimum)
                minimum -= exact_slope(jet, -1.0, minimum) / (jet[2] * c0 + jet[3] * s1)
            assert exact(jet, -1.0, minimum) > 0.0


def test_equal_numbers_leave_no_drift() -> None:
    """sin t of a fast swing: f1 - f3 / kappa is rounding, and the zero at pi is exact."""
    for omega in np.random.default_rng(6).uniform(0.1, 1e3, size=MANY):
        jet: Jet = (0.0, omega, 0.0, -(omega**3))
        assert root(jet, -(omega**2)) * omega == close(math.pi, rel=4.0 * EPSILON)
        above: Jet = (1.0 + 1e-9, 1e-16 * omega - omega, 0.0, omega**3)  # 1 + 1e-9 - sin t
        assert root(above, -(omega**2)) == math.inf


HOPELESS = {
    # The last swings of a toy that cannot jam need 1.7e14 s, where one period is below rounding.
    "late": (0.01655172413793099, -8.585061843513723e-16, 2.49020607285044e-12,
             1.5989450675713026e-10),
    # A minimum at zero up to rounding, and a drift that needs 1e37 swings to exceed it.
    "grazing": (0.0, -0.0, 297.00125506467447, -8.93743273920714e-34),
}  # fmt: skip


@pytest.mark.parametrize("jet", HOPELESS.values(), ids=HOPELESS)
def test_a_drift_too_slow_for_the_clock_ends_all_the_same(jet: Jet) -> None:
    """At infinity, or where no digit of the drift but the sign is left."""
    assert root(jet, -209853.41532325107) > 1e10
