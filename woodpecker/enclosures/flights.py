"""Flights that begin at rest: f(t) = t^2 h(t), h(t) = f_2 c_2 + f_3 t c_3.

A contact that is left at rest with a small acceleration f_2 lands after a time of its size. Where
f_2 passes zero the flight, and the speed and force of the landing, vanish; h falls with a rate near
f_3 / 6, so everything is decided by quotients. At the landing h = 0,

    f' = t^2 h',    f'' = t (4 h' + t h'').
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from flint import arb

from woodpecker.enclosures.forms import Form, box, sign
from woodpecker.enclosures.not_proved import NotProved
from woodpecker.enclosures.oscillator import Derivatives, Guard, ZeroCrossing, shapes, zero
from woodpecker.enclosures.stumpff import shape_balls

LONGEST = 10.0  # of |kappa| t^2: half a swing; h need not fall beyond
PARTS = 16  # of a flight, over each of which the slope of h is enclosed


def landing(guard: Guard, guess: float) -> ZeroCrossing | None:
    """When a gap closes that has opened at rest; None if this is no short flight."""
    # Around the result h falls from h(0) >= 0 through zero once: the gap is positive before, and
    # speed and acceleration of the landing vanish with the time only.
    f3, kappa = guard.jet[3], guard.kappa
    if not abs(kappa) * arb(guess) ** 2 < LONGEST or sign(f3) != -1:
        return None

    def at(t: Any) -> Derivatives:
        return height(guard.jet, kappa, t)

    def over(t: Any, derivative: int = 0) -> Any:
        return height([box(f) for f in guard.jet], kappa, t)(derivative)

    try:
        time, bracket = zero(at, over, guess, -1)
    except NotProved:
        return None
    if sign(4 * over(bracket, 1) + bracket * over(bracket, 2)) != -1:
        return None
    end = abs(bracket).upper()
    ends = [(end * k / PARTS).mid() for k in range(PARTS + 1)]
    parts = [low.union(high) for low, high in pairwise(ends)]
    if any(sign(over(part, 1)) != -1 for part in (bracket, *parts)):
        return None
    return ZeroCrossing(guard.code, time, bracket, lands=True)


def height(jet: Any, kappa: Any, t: Any) -> Derivatives:
    """The function h and its derivatives; d c_k / dt = kappa t (c_(k+1) - k c_(k+2))."""
    _, _, f2, f3 = jet
    x = kappa * (t * t)
    c = shapes(x, 7) if isinstance(x, Form) else shape_balls(x, 7)
    turn_2, turn_3 = c[3] - c[4] * 2, c[4] - c[5] * 3

    def value(derivative: int) -> Any:
        match derivative:
            case 0:
                return f2 * c[2] + f3 * (c[3] * t)
            case 1:
                return f2 * (turn_2 * t * kappa) + f3 * (c[3] + turn_3 * x)
            case _:
                bend_2 = turn_3 - (c[5] - c[6] * 4) * 2
                bend_3 = (c[5] - c[6] * 4) - (c[6] - c[7] * 5) * 3
                return f2 * ((turn_2 + bend_2 * x) * kappa) + f3 * (
                    (turn_3 * 3 + bend_3 * x) * t * kappa
                )

    return value
