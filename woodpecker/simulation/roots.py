"""The root of a guard near a known one, smooth where a phase becomes infinitely short.

A guard that an event has just made exactly zero, f(t) = f_m t^m c_m + ..., has its next root at a
time that passes through zero with f_m, where m + 1 roots of f meet. The *deflated* guard

    g(t) = f(t) / t^m,    m the number of leading derivatives that are exactly zero,

has that root only, with g' != 0, so that Newton's method follows it through t = 0. By ds_k/dt =
s_(k-1), s_k = t^k c_k, and c_k = 1/k! + x c_(k+2), x = kappa t^2, all derivatives of g are sums of
Stumpff's functions, without a division by t.
"""

from __future__ import annotations

import math

from woodpecker.base.compiled import part
from woodpecker.motion.guards import CLOCK, EPSILON, SERIES_4, SERIES_5, TERMS, stumpff

NEWTON = 40  # steps from a neighbour's event time; three are the rule
FARTHEST = 700.0  # omega t beyond which cosh overflows
NEAR = 0.3  # phase [rad] around an inflection in which a guard is close to its cubic there
ROUNDING = 16.0 * EPSILON  # of a guard's value, relative to the sum of its terms' moduli

Ratios = tuple[float, float, float, float, float, float]


@part
def ratios(kappa: float, omega: float, t: float) -> Ratios:
    """c_0, ..., c_5 at kappa t^2; omega = sqrt(|kappa|)."""
    x = kappa * t * t
    if abs(x) < 1.0:
        c4, c5 = SERIES_4[0], SERIES_5[0]
        for n in range(1, TERMS):
            c4 = SERIES_4[n] + c4 * x
            c5 = SERIES_5[n] + c5 * x
        c2, c3 = 0.5 + x * c4, 1.0 / 6.0 + x * c5
        return 1.0 + x * c2, 1.0 + x * c3, c2, c3, c4, c5
    c0, s1, s2, s3, s4 = stumpff(kappa, omega, t)
    c3 = s3 / (t * t * t)
    return c0, s1 / t, s2 / (t * t), c3, s4 / (t * t * t * t), (c3 - 1.0 / 6.0) / x


@part
def deflated(
    order: int, f0: float, f1: float, f2: float, f3: float, kappa: float, t: float, c: Ratios
) -> tuple[float, float, float]:
    """g, g' and g'' at t from the jet of f at 0, whose first ``order`` entries are 0."""
    if order == 0:
        return (
            f0 + t * (f1 + t * (f2 * c[2] + f3 * t * c[3])),
            f1 + t * (f2 * c[1] + f3 * t * c[2]),
            f2 * c[0] + f3 * t * c[1],
        )
    if order == 1:
        return (
            f1 + t * (f2 * c[2] + f3 * t * c[3]),
            f2 * (c[1] - c[2]) + f3 * t * (c[2] - c[3]),
            f2 * kappa * t * (c[2] - 2.0 * c[3] + 2.0 * c[4])
            + f3 * (c[1] - 2.0 * c[2] + 2.0 * c[3]),
        )
    if order == 2:
        return (
            f2 * c[2] + f3 * t * c[3],
            f2 * kappa * t * (c[3] - 2.0 * c[4]) + f3 * (c[2] - 2.0 * c[3]),
            kappa * (f2 * (c[2] - 4.0 * c[3] + 6.0 * c[4]))
            + kappa * t * f3 * (c[3] - 4.0 * c[4] + 6.0 * c[5]),
        )
    return (
        f3 * c[3],
        f3 * kappa * t * (c[4] - 3.0 * c[5]),
        f3 * kappa * (c[3] - 6.0 * c[4] + 12.0 * c[5]),
    )


@part
def deflated_change(order: int, f2: float, f3: float, t: float, c: Ratios) -> tuple[float, float]:
    """Derivatives of g and g' in kappa; see :func:`woodpecker.motion.guards.stumpff_rates`."""
    k2, k3 = c[3] - 2.0 * c[4], c[4] - 3.0 * c[5]
    once = f2 * (c[2] - c[3] - order * k2) + f3 * t * (c[3] - 2.0 * c[4] - order * k3)
    power = 0.5
    for _ in range(order, 3):
        power *= t
    return power * t * (f2 * k2 + f3 * t * k3), power * once


@part
def root_near(
    order: int, f0: float, f1: float, f2: float, f3: float, kappa: float, omega: float, t: float
) -> float:
    """Root of a deflated guard near a time, by Newton's method; nan if that finds none."""
    # The root is negative where two events have changed places.
    previous = 0.0
    for _ in range(NEWTON):
        if omega * abs(t) > (FARTHEST if kappa > 0.0 else CLOCK / EPSILON):
            return math.nan  # doubles do not resolve it; deflated guards vanish at infinity
        c = ratios(kappa, omega, t)
        g, slope, _ = deflated(order, f0, f1, f2, f3, kappa, t, c)
        if slope == 0.0 or not math.isfinite(g):
            return math.nan
        step = -g / slope
        stalled = previous != 0.0 and abs(step) >= 0.5 * abs(previous)
        if stalled and abs(g) <= rounding_at(order, f0, f1, f2, f3, t, c):
            return t
        # Newton converges quadratically: the next step is about step (step / previous)^2.
        shrink = min(1.0, abs(step / previous)) if previous != 0.0 else 1.0
        t += step
        if abs(step) * shrink * shrink <= 0.25 * EPSILON * abs(t):
            return t
        previous = step
    return math.nan


@part
def inflection(f2: float, f3: float, omega: float, t: float) -> float:
    """Zero of f'' = f_2 cos(omega t) + f_3 sin(omega t) / omega nearest to t."""
    angle = math.atan2(f2, f3 / omega)  # f'' is in proportion to sin(omega t + angle)
    return float((math.pi * math.floor((omega * t + angle) / math.pi + 0.5) - angle) / omega)


@part
def root_at_inflection(
    f0: float, f1: float, f2: float, f3: float, kappa: float, omega: float, t: float
) -> float:
    """Root of a swinging guard near an inflection where it hardly falls; nan if there is none."""
    # Where both the guard and its slope vanish at the inflection three roots meet, and Newton's
    # method stalls. In the time s from the inflection f = F_0 + F_1 s + F_3 s^3 c_3. If F_1 and F_3
    # have the same sign it converges monotonically from the root without F_1, or without F_3.
    at = inflection(f2, f3, omega, t)
    if omega * abs(t - at) > NEAR:
        return math.nan
    c = ratios(kappa, omega, at)
    gap = f0 + at * (f1 + at * (f2 * c[2] + f3 * at * c[3]))
    slope = f1 + at * (f2 * c[1] + f3 * at * c[2])
    third = kappa * f2 * at * c[1] + f3 * c[0]
    if third == 0.0 or slope * third < -ROUNDING * (third * at) * (third * at):
        return math.nan
    if slope * third < 0.0:  # by rounding
        slope = 0.0
    s = math.copysign(abs(6.0 * gap / third) ** (1.0 / 3.0), -gap * third)
    if abs(slope * s) > abs(gap):
        s = -gap / slope
    if omega * abs(s) > 1.0:
        return math.nan
    for _ in range(NEWTON):
        if s == 0.0:
            break
        c = ratios(kappa, omega, s)
        step = -(gap + s * (slope + third * s * s * c[3])) / (slope + third * s * s * c[2])
        s += step
        if abs(step) <= EPSILON * abs(s):
            break
    return float(at + s)


@part
def rounding_at(
    order: int, f0: float, f1: float, f2: float, f3: float, t: float, c: Ratios
) -> float:
    """The rounding error of a deflated guard at a time."""
    third = abs(f2 * c[2]) + abs(f3 * t * c[3])
    if order == 0:
        return ROUNDING * (abs(f0) + abs(t) * (abs(f1) + abs(t) * third))
    return ROUNDING * (abs(f1) + abs(t) * third if order == 1 else third)
