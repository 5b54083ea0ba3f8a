"""Guards in closed form, and their first roots.

Every guard f (a gap, a normal force, a friction bound, a slip velocity) obeys f'''' = kappa f''
in a mode, because it is affine in d, or a single or double integral of d without a constant
torque. So its jet (f, f', f'', f''') at the start determines it,

    f(t) = f0 + f1 t + f2 t^2 c2(kappa t^2) + f3 t^3 c3(kappa t^2),

with Stumpff's functions c_k(x) = 1/k! + x/(k+2)! + x^2/(k+4)! + ... [Stiefel1971, sec. 11].
The roots of f' are known in closed form, and between them f is monotone: so the first root of f is
bracketed without sampling, cannot be missed, and is refined to the last bit.
"""

from __future__ import annotations

import math

import numpy as np

from woodpecker.base.compiled import part

TWO_PI = 2.0 * math.pi
EPSILON = 2.220446049250313e-16  # spacing of doubles at 1
CLOCK = 0.01  # of a swing: a coarser resolution of time, reached after 1e11 s, decides no event
PASSES = 8  # passes over the swings, after which each passes twice as many as the one before
TERMS = 9  # of a series: the first one left out is below 1e-20
SERIES_3 = tuple(1.0 / math.factorial(2 * n + 3) for n in reversed(range(TERMS)))
SERIES_4 = tuple(1.0 / math.factorial(2 * n + 4) for n in reversed(range(TERMS)))
SERIES_5 = tuple(1.0 / math.factorial(2 * n + 5) for n in reversed(range(TERMS)))
SERIES_6 = tuple(1.0 / math.factorial(2 * n + 6) for n in reversed(range(TERMS)))


@part
def stumpff(kappa: float, omega: float, t: float) -> tuple[float, float, float, float, float]:
    """c0, t c1, t^2 c2, t^3 c3, t^4 c4 at kappa t^2, each the integral of the one before."""
    # The series serves |kappa| t^2 < 1, where terms of the closed forms cancel.
    x = kappa * t * t
    if abs(x) < 1.0:
        c3, c4 = SERIES_3[0], SERIES_4[0]
        for n in range(1, TERMS):
            c3 = SERIES_3[n] + c3 * x
            c4 = SERIES_4[n] + c4 * x
        c2, c1 = 0.5 + x * c4, 1.0 + x * c3
        return 1.0 + x * c2, t * c1, t * t * c2, t * t * t * c3, t * t * t * t * c4
    half = 0.5 * omega * t
    if kappa < 0.0:
        s, c = math.sin(half), math.cos(half)
        c0 = 1.0 - 2.0 * s * s
    else:
        s, c = np.sinh(half), np.cosh(half)  # these overflow to inf, where those of math raise
        c0 = 1.0 + 2.0 * s * s
    s1 = 2.0 * s * c / omega
    s2 = 2.0 * (s / omega) * (s / omega)
    return c0, s1, s2, (s1 - t) / kappa, (s2 - 0.5 * t * t) / kappa


@part
def stumpff_rates(
    kappa: float, t: float, s1: float, s2: float, s3: float, s4: float
) -> tuple[float, float, float]:
    """Derivatives of t^2 c2, t^3 c3, t^4 c4 in kappa, from s_k = t^k c_k."""
    # d s_k / d kappa = (t s_(k-1) - k s_k) / (2 kappa) = (t s_(k+1) - k s_(k+2)) / 2, by
    # 2 x c_k'(x) = c_(k-1) - k c_k and c_k = 1/k! + x c_(k+2); the second where the first cancels.
    x = kappa * t * t
    if abs(x) < 1.0:
        c5, c6 = SERIES_5[0], SERIES_6[0]
        for n in range(1, TERMS):
            c5 = SERIES_5[n] + c5 * x
            c6 = SERIES_6[n] + c6 * x
        s5, s6 = t**5 * c5, t**6 * c6
        return 0.5 * (t * s3 - 2.0 * s4), 0.5 * (t * s4 - 3.0 * s5), 0.5 * (t * s5 - 4.0 * s6)
    half = 0.5 / kappa
    return half * (t * s1 - 2.0 * s2), half * (t * s2 - 3.0 * s3), half * (t * s3 - 4.0 * s4)


@part
def value(
    f0: float, f1: float, f2: float, f3: float, kappa: float, omega: float, t: float
) -> tuple[float, float]:
    """f(t) and f'(t) from the jet of f at 0."""
    _, s1, s2, s3, _ = stumpff(kappa, omega, t)
    return f0 + f1 * t + f2 * s2 + f3 * s3, f1 + f2 * s1 + f3 * s2


@part
def bracketed(
    f0: float, f1: float, f2: float, f3: float, kappa: float, omega: float, low: float, high: float
) -> float:
    """Root of f in (low, high], f > 0 right of low, f <= 0 at high: Newton with bisection."""
    # A zero at low itself is no root: there the guard has just fired.
    t, previous = 0.5 * (low + high), 0.0
    for _ in range(200):
        f, slope = value(f0, f1, f2, f3, kappa, omega, t)
        if f > 0.0:
            low = t
        else:
            high = t
        trial = t - f / slope if slope < 0.0 else low
        newton = low < trial < high
        if not newton:
            trial = 0.5 * (low + high)
        step, t = trial - t, trial
        # Newton converges quadratically: the next step is about step (step / previous)^2.
        shrink = step / previous if newton and previous != 0.0 else 1.0
        if abs(step) * min(1.0, shrink * shrink) <= 0.25 * EPSILON * t or t in (low, high):
            break
        previous = step if newton else 0.0
    return t


@part
def first_root(
    f0: float, f1: float, f2: float, f3: float, kappa: float, omega: float, horizon: float
) -> float:
    """First t in (0, horizon] where f falls through zero; inf if there is none.

    f must be positive right after 0, though it may vanish there with its first derivatives. A root
    slightly beyond the horizon may be returned; callers take the minimum.
    """
    if kappa < 0.0:
        return _first_root_trigonometric(f0, f1, f2, f3, kappa, omega, horizon)
    return _first_root_monotone_pieces(f0, f1, f2, f3, kappa, omega, horizon)


@part
def _first_root_trigonometric(
    f0: float, f1: float, f2: float, f3: float, kappa: float, omega: float, horizon: float
) -> float:
    """First root of f = mean + drift t - a cos(omega t) - b sin(omega t), kappa < 0."""
    # From swing to swing its minima move by the drift: the first one below zero is known at once.
    a, b = -f2 / kappa, -f3 / (kappa * omega)
    mean, drift, radius = f0 + a, f1 - f3 / kappa, math.hypot(a, b)
    if abs(drift) <= 4.0 * EPSILON * (abs(f1) + abs(f3 / kappa)):
        drift = 0.0  # two equal numbers were subtracted: nothing but rounding is left
    if mean - radius + min(0.0, drift * horizon if drift != 0.0 else 0.0) > 0.0:
        return math.inf
    if drift >= 0.0 and mean - radius >= 0.0:
        return math.inf
    fastest = radius * omega
    if abs(drift) >= fastest:
        if drift >= 0.0:
            return math.inf
        return _root_or_later(f0, f1, f2, f3, kappa, omega, 0.0, -(mean + radius) / drift, horizon)
    # f' = drift + fastest sin(omega t - psi) vanishes at minima omega t = psi - beta + 2 pi k and
    # at the maxima (pi - 2 beta) before them.
    beta = math.asin(drift / fastest)
    theta = (math.atan2(b, a) - beta) % TWO_PI
    period, fall = TWO_PI / omega, (math.pi - 2.0 * beta) / omega
    low = theta / omega
    lowest = value(f0, f1, f2, f3, kappa, omega, low)[0]
    if lowest >= 0.0:
        if drift >= 0.0:
            return math.inf
        swings, least = 0.0, 2.0**-PASSES
        while lowest >= 0.0:  # each pass goes as far as the drift asks for; by rounding it takes a
            least *= 2.0  # few, and after PASSES of them the swings passed at once double
            needed = -lowest / (drift * period)
            if not EPSILON * needed < CLOCK:
                return math.inf
            swings += max(1.0, math.floor(least), math.floor(needed))
            low = theta / omega + swings * period
            if low - fall > horizon or EPSILON * low > CLOCK * period:
                return math.inf
            lowest = value(f0, f1, f2, f3, kappa, omega, low)[0]
    return _root_or_later(f0, f1, f2, f3, kappa, omega, max(0.0, low - fall), low, horizon)


@part
def _first_root_monotone_pieces(
    f0: float, f1: float, f2: float, f3: float, kappa: float, omega: float, horizon: float
) -> float:
    """First root for kappa >= 0: f is monotone between its critical points, at most two."""
    first, second = _critical_points(f1, f2, f3, kappa, omega)
    low = 0.0
    for t in (first, second):
        if t < math.inf:
            if low > horizon:
                return math.inf
            if value(f0, f1, f2, f3, kappa, omega, t)[0] < 0.0:
                return _root_or_later(f0, f1, f2, f3, kappa, omega, low, t, horizon)
            low = t
    # Beyond the last critical point f is monotone; double the step until it is negative.
    step = low if low > 0.0 else (1.0 / omega if omega > 0.0 else 1.0)
    if value(f0, f1, f2, f3, kappa, omega, low + step)[1] >= 0.0:
        return math.inf
    high = low + step
    while low <= horizon and omega * high < 700.0 and high < 1e30:  # cosh overflows at 710
        if value(f0, f1, f2, f3, kappa, omega, high)[0] <= 0.0:
            return _root_or_later(f0, f1, f2, f3, kappa, omega, low, high, horizon)
        low, high = high, 2.0 * high
    return math.inf


@part
def _critical_points(
    f1: float, f2: float, f3: float, kappa: float, omega: float
) -> tuple[float, float]:
    """Positive roots of f' in ascending order, inf where there are fewer than two."""
    # With s = (2/omega) tanh(omega t/2), or s = t for kappa = 0, they are roots of a quadratic.
    a, root_1, root_2 = 0.5 * f3 - 0.25 * kappa * f1, math.inf, math.inf
    discriminant = f2 * f2 - 4.0 * a * f1
    if a == 0.0:
        if f2 != 0.0:
            root_1 = -f1 / f2
    elif discriminant >= 0.0:
        half = -0.5 * (f2 + math.copysign(math.sqrt(discriminant), f2))
        root_1 = half / a
        root_2 = f1 / half if half != 0.0 else root_1
    reach = 2.0 / omega if omega > 0.0 else math.inf
    root_1 = root_1 if 0.0 < root_1 < reach else math.inf
    root_2 = root_2 if 0.0 < root_2 < reach else math.inf
    if omega > 0.0:
        root_1 = 2.0 * np.arctanh(root_1 / reach) / omega if root_1 < math.inf else math.inf
        root_2 = 2.0 * np.arctanh(root_2 / reach) / omega if root_2 < math.inf else math.inf
    return min(root_1, root_2), max(root_1, root_2)


@part
def _root_or_later(
    f0: float, f1: float, f2: float, f3: float, kappa: float, omega: float,
    low: float, high: float, horizon: float,
) -> float:  # fmt: skip
    """Root in (low, high], or inf when it cannot come before the horizon."""
    if low > horizon:
        return math.inf
    if low > 0.0 and value(f0, f1, f2, f3, kappa, omega, low)[0] <= 0.0:
        low, high = 0.0, low  # rounding hides the maximum at low: the root lies left of it
    if high > horizon:
        if value(f0, f1, f2, f3, kappa, omega, horizon)[0] > 0.0:
            return math.inf
        high = horizon
    return bracketed(f0, f1, f2, f3, kappa, omega, low, high)


@part
def time_of_lowest(
    f0: float, f1: float, f2: float, f3: float, kappa: float, omega: float, end: float
) -> float:
    """Time of the lowest minimum of f strictly between 0 and ``end``; inf if there is none."""
    if kappa < 0.0:
        return _time_of_lowest_trigonometric(f1, f2, f3, kappa, omega, end)
    for t in _critical_points(f1, f2, f3, kappa, omega):
        if t < end:
            c0, s1, _, _, _ = stumpff(kappa, omega, t)
            if f2 * c0 + f3 * s1 > 0.0:  # f'' at t: the other critical point is a maximum
                return t
    return math.inf


@part
def _time_of_lowest_trigonometric(
    f1: float, f2: float, f3: float, kappa: float, omega: float, end: float
) -> float:
    """The same for kappa < 0: minima drift, so that the first or the last one is the lowest."""
    # A guard that begins with a zero derivative has a minimum there, which does not count.
    a, b = -f2 / kappa, -f3 / (kappa * omega)
    drift, fastest = f1 - f3 / kappa, omega * math.hypot(a, b)
    if end <= 0.0 or abs(drift) >= fastest * (1.0 - 8.0 * EPSILON):
        return math.inf
    beta = math.asin(drift / fastest)
    theta = (math.atan2(b, a) - beta) % TWO_PI
    if f1 == 0.0 and theta < 1.0:
        theta += TWO_PI
    first = theta / omega
    if first >= end:
        return math.inf
    last = first + math.floor((end - first) * omega / TWO_PI) * TWO_PI / omega
    t = first if drift >= 0.0 else last
    return t if t < end else math.inf
