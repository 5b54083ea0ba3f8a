"""A ball that does not rebound, on a vibrating table: a map with a plateau.

    python -m studies.maps.bouncing [--fast] [--out DIR]

A ball on a table that moves as A sin(phi), phi = omega t, loses all its relative velocity when it
lands [Mehta1990, Gilet2009]. With G = A omega^2/g > 1 the table leaves the ball behind where
G sin(phi) exceeds 1, between phi_0 = asin(1/G) and pi - phi_0. A flight from phi lasts the time t
(in units of phase) with h(t) = 0,

    h/t^2 = sin(phi) (1 - cos t)/t^2 + cos(phi) (t - sin t)/t^2 - 1/(2 G).

The state is the phase x at which the ball lands, counted from the period in which it does:

    L   x < phi_0          it waits until phi_0:       P = phi_0 + t(phi_0) - 2 pi    (a plateau)
    M   phi_0 < x < pi - phi_0      it leaves at once: P = x + t(x) - 2 pi
    W   x > pi - phi_0     it waits until phi_0 + 2 pi: the value of L.

In closed form: where h = 0, dh/dphi = cos(phi) - t sin(phi) - cos(phi + t) and
dh/dt = cos(phi) - t/G - cos(phi + t). At x = phi_0 both are equal, so M begins with slope 0, as
the plateau has: value and slope agree at the border of L and M. A flight of one period, t = 2 pi,
starts where G cos(phi) = pi; it has dt/dphi = -G sin(phi), so its multiplier is
1 - G sin(phi) = 1 - sqrt(G^2 - pi^2). Hence

    G < sqrt(1 + pi^2) = 3.29691...   the ball waits in every period (superstable),
    G = sqrt(1 + pi^2)                it no longer waits: a change of word, no bifurcation,
    G = sqrt(4 + pi^2) = 3.72419...   flip.

The flip is that of the bouncing ball of restitution e, G^2 = pi^2 ((1 - e)/(1 + e))^2
+ 4 ((1 + e^2)/(1 + e)^2)^2 [Luo1996], for e = 0. Beyond G = 4.6033 a flight from phi_0 passes over
the table's next crest; the study stays below.

Beyond the flip the lower point of the 2-cycle decreases until the ball waits there: the cycle is
superstable again, and remains so up to G = 4.5, without a special point.

Measured here: these two values; where the 2-cycle begins to wait, against the 30-digit root of its
equation; fixed points of the iterates against changes of sign on a grid; and that each attractor of
the plain map lies on a stable branch.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import mpmath
import numpy as np
from mpmath import mpf

from pwmap import Diagram, PointKind
from studies.common.record import Results, command
from studies.maps.following import changes, miscounted, searched
from woodpecker.base.arrays import Floats
from woodpecker.base.settings import Settings
from woodpecker.maps.derivatives import check_derivatives
from woodpecker.maps.formulas import FormulaMap, FormulaPiece, Smooth
from woodpecker.search.search import Search

TURN = 2.0 * math.pi
SETTINGS = Settings(span=(1.2, 4.5), window=(-4.5, 3.0))
GRID = np.linspace(-4.5, 2.6, 3_001)
NEWTON = 30  # steps for a flight; five are usual
DIGITS = 30  # of the root that the waiting of the 2-cycle is compared with
SMALL = 0.5  # below it, power series lose less than differences
LEAVES = "the ball lands as the table begins to leave it"
REJOINS = "the ball lands as the table ceases to leave it"

# --- Flights --------------------------------------------------------------------------------------


def series(t: float, first: int, power: int) -> float:
    """Sum over k of (-1)^k t^(2 k + power)/(2 k + first)!."""
    return sum((-1.0) ** k * t ** (2 * k + power) / math.factorial(2 * k + first) for k in range(9))


def rise(t: float) -> tuple[float, float]:
    """(1 - cos t)/t^2 and its derivative."""
    if abs(t) < SMALL:
        slope = sum(
            (-1.0) ** k * 2 * k * t ** (2 * k - 1) / math.factorial(2 * k + 2) for k in range(1, 9)
        )
        return series(t, 2, 0), slope
    value = (1.0 - math.cos(t)) / t**2
    return value, math.sin(t) / t**2 - 2.0 * value / t


def lag(t: float) -> tuple[float, float]:
    """(t - sin t)/t^2 and its derivative."""
    if abs(t) < SMALL:
        slope = sum(
            (-1.0) ** k * (2 * k + 1) * t ** (2 * k) / math.factorial(2 * k + 3) for k in range(9)
        )
        return series(t, 3, 1), slope
    value = (t - math.sin(t)) / t**2
    return value, (1.0 - math.cos(t)) / t**2 - 2.0 * value / t


def flight(phi: float, g: float) -> tuple[float, float, float]:
    """Duration of a flight and its derivatives in phi and G; ValueError if there is none.

    h/t^2 is positive at first; the flight ends at its first zero. Beyond the phases at which the
    table leaves the ball that zero goes on to t < 0, and the map smoothly with it.
    """
    t = _first_zero(phi, g)
    for _ in range(NEWTON):
        (a, da), (b, db) = rise(t), lag(t)
        rate = math.sin(phi) * da + math.cos(phi) * db
        move = -(math.sin(phi) * a + math.cos(phi) * b - 0.5 / g) / rate
        t += move
        if abs(move) <= 1e-15 * max(1.0, abs(t)):
            break
    else:
        if not abs(move) < 1e-12:
            raise ValueError("the flight does not end")
    (a, da), (b, db) = rise(t), lag(t)
    rate = math.sin(phi) * da + math.cos(phi) * db
    return t, -(math.cos(phi) * a - math.sin(phi) * b) / rate, -0.5 / (g * g * rate)


def _first_zero(phi: float, g: float) -> float:
    """A start for Newton's method: the first change of sign on a grid, or 0."""
    height = math.sin(phi) * RISES + math.cos(phi) * LAGS - 0.5 / g
    ends = np.flatnonzero((height[:-1] > 0.0) & (height[1:] <= 0.0))
    if not len(ends):
        return 0.0
    k = int(ends[0])
    return float(TIMES[k] + height[k] / (height[k] - height[k + 1]) * (TIMES[k + 1] - TIMES[k]))


TIMES = np.linspace(0.0, 9.0, 181)
RISES, LAGS = (np.array([part(t)[0] for t in TIMES.tolist()]) for part in (rise, lag))

# --- The map --------------------------------------------------------------------------------------


def begin(g: float) -> float:
    """phi_0, the phase at which the table begins to leave the ball."""
    return math.asin(1.0 / g)


def begin_dg(g: float) -> float:
    """Its derivative."""
    return -1.0 / (g * math.sqrt(g * g - 1.0))


def at_once(x: float, g: float) -> float:
    """P where the ball leaves at once."""
    return x + flight(x, g)[0] - TURN


def at_once_dx(x: float, g: float) -> float:
    """Its derivative in x."""
    return 1.0 + flight(x, g)[1]


def at_once_dg(x: float, g: float) -> float:
    """Its derivative in G."""
    return flight(x, g)[2]


def waiting(x: float, g: float) -> float:
    """P where it waits."""
    return at_once(begin(g), g)


def waiting_dg(x: float, g: float) -> float:
    """Its derivative in G."""
    _, by_phi, by_g = flight(begin(g), g)
    return (1.0 + by_phi) * begin_dg(g) + by_g


def constant(x: float, g: float, value: float) -> float:
    """A number."""
    return value


def beyond(x: float, g: float, sign: float, end: float) -> float:
    """Distance of x from phi_0 (end = 0) or pi - phi_0 (end = 1), with a sign."""
    return sign * (x - (end * math.pi + (1.0 - 2.0 * end) * begin(g)))


def beyond_dg(x: float, g: float, sign: float, end: float) -> float:
    """Its derivative in G."""
    return -sign * (1.0 - 2.0 * end) * begin_dg(g)


def margin(sign: float, end: float) -> Smooth:
    """A margin in x."""
    return Smooth(
        partial(beyond, sign=sign, end=end),
        partial(constant, value=sign),
        partial(beyond_dg, sign=sign, end=end),
    )


def bouncing_map() -> FormulaMap:
    """The map, of parameter G."""
    plateau = Smooth(waiting, partial(constant, value=0.0), waiting_dg)
    leaving = Smooth(at_once, at_once_dx, at_once_dg)
    return FormulaMap(
        (
            FormulaPiece("L", plateau, {LEAVES: margin(-1.0, 0.0)}),
            FormulaPiece("M", leaving, {LEAVES: margin(1.0, 0.0), REJOINS: margin(-1.0, 1.0)}),
            FormulaPiece("W", plateau, {REJOINS: margin(1.0, 1.0)}),
        )
    )


# --- In many digits -------------------------------------------------------------------------------


def step(x: mpf, g: mpf) -> mpf:
    """The map in many digits, from h itself; the flight is found near that of the numeric map."""
    phi = max(x, mpmath.asin(1 / g))
    near = flight(float(phi), float(g))[0]

    def height(t: mpf) -> mpf:
        return mpmath.sin(phi) + t * mpmath.cos(phi) - t**2 / (2 * g) - mpmath.sin(phi + t)

    return phi + mpmath.findroot(height, near) - 2 * mpmath.pi


def around(x: mpf, g: mpf, order: int) -> mpf:
    """An iterate in many digits."""
    for _ in range(order):
        x = step(x, g)
    return x


def begins_to_wait(g: float) -> float:
    """G near a guess at which a 2-cycle lands at phi_0: its other point is the plateau's value."""

    def residual(g: mpf) -> mpf:
        return around(mpmath.asin(1 / g), g, 2) - mpmath.asin(1 / g)

    with mpmath.workdps(DIGITS):
        return float(mpmath.findroot(residual, (g, g + 1e-6)))


# --- Comparison -----------------------------------------------------------------------------------


def attractor(map_: FormulaMap, g: float, order: int) -> Floats | None:
    """The cycle of at most some points that an orbit from the plateau ends on, or None."""
    x = 0.0
    for _ in range(600):
        x = map_.at(x, g).value
    orbit = [x]
    for n in range(1, order + 1):
        orbit.append(map_.at(orbit[-1], g).value)
        if abs(orbit[-1] - x) < 1e-9:
            return np.array(orbit[:n])
    return None


CHORD = SETTINGS.max_turn * SETTINGS.max_step * SETTINGS.x_scale / 8.0  # height of an arc over one


def unexplained(map_: FormulaMap, diagram: Diagram, gs: Sequence[float], order: int) -> list[int]:
    """How many cycles attract, and how many of them lie on no stable branch.

    Between two of its samples a branch is known as a chord.
    """
    count, missing = 0, 0
    for g in gs:
        cycle = attractor(map_, g, order)
        if cycle is not None:
            count += 1
            on = [hit.x for hit in diagram.at(g) if abs(hit.multiplier) < 1.0]
            missing += any(all(abs(x - y) > CHORD for y in on) for x in cycle.tolist())
    return [count, missing]


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Compare, and give the headline numbers.

    Parameters
    ----------
    fast
        Orders 1 and 2, and few values of G.
    out
        Not used: there are no pictures.

    Returns
    -------
    dict
        ``stops_waiting``, ``pair_waits``: G, and the ``_error`` of the place where the branch
        changes its word; ``flip``, ``flip_error``; ``borders_are_smooth``; ``others``: special
        points of iterates, but for ends; ``miscounted``: slices of iterates in which changes of
        sign say something else; ``attractors_and_missing``: how many, and on no stable branch.
    """
    orders = (1, 2) if fast else (1, 2, 3, 4)
    map_ = bouncing_map()
    check_derivatives(map_, [(x, g) for g in (1.5, 3.5, 4.4) for x in (-1.0, 0.9, 1.6, 3.0)])
    network = searched(map_, SETTINGS, orders, Search(slices=15, finest=5e-3))
    diagram = network.diagram("G", "x")
    flips = [p for p in diagram.points if p.kind is PointKind.PD and p.order == 1]
    others = [p for p in diagram.points if p.kind is not PointKind.EP and p.order > 1]
    (once, smooth), (twice, smooth_2) = changes(network, 1)[0], changes(network, 2)[0]
    waits = begins_to_wait(min(twice))
    gs = np.linspace(1.25, 4.45, 9 if fast else 33).tolist()
    return {
        "stops_waiting": math.hypot(1.0, math.pi),
        "stops_waiting_error": min(abs(each - math.hypot(1.0, math.pi)) for each in once),
        "flip": math.hypot(2.0, math.pi),
        "flip_error": max(abs(p.parameter - math.hypot(2.0, math.pi)) for p in flips),
        "pair_waits": waits,
        "pair_waits_error": min(abs(each - waits) for each in twice),
        "borders_are_smooth": smooth and smooth_2,
        "others": len(others),
        "miscounted": miscounted(map_, diagram, orders, gs[::4], GRID),
        "attractors_and_missing": unexplained(map_, diagram, gs, orders[-1]),
    }


if __name__ == "__main__":
    command(main, "map_bouncing")
