"""Flights that begin at rest: f(t) = t^2 h(t), h(t) = f_2 c_2 + f_3 t c_3.

A contact that is left at rest with a small acceleration f_2 lands after a time of its size. Where
f_2 passes zero the flight vanishes, and with it the speed and the force of the landing; h does not:
it falls with a rate near f_3 / 6, so everything is decided by quotients. At the landing h = 0,

    f' = t^2 h',    f'' = t (4 h' + t h'').
"""

from __future__ import annotations

from typing import Any

from flint import arb, ctx

from woodpecker.proofs.forms import Form, Undecided, box, centre, implicit, sign
from woodpecker.proofs.oscillator import Crossing, Guard, shapes

ZERO = arb(0)


def landing(guard: Guard, guess: float) -> Crossing | None:
    """When a gap closes that has opened at rest; None if this is no short flight.

    In the range of the result h falls from h(0) >= 0 through zero once, so the gap is positive
    before, and it closes with a speed and an acceleration that do not vanish but with the time.
    """
    _, _, f2, f3 = guard.jet
    if not abs(box(guard.kappa)) * arb(2.0 * guess + 1e-9) ** 2 < 1 or sign(f3) != -1:
        return None
    mid = _refined(guard, guess)
    if mid is None:
        return None
    value = _height(guard, mid)
    slope = centre(_height(guard, mid, 1))
    if not isinstance(value, Form) or sign(slope) != -1:
        return None
    frame = value.frame
    reach = abs((value.d[0] * frame.s + value.d[1] * frame.p) / slope).upper()
    reach = (reach * arb(1.05) + arb(2) ** (20 - ctx.prec)).upper()
    for _ in range(6):
        low, high = (mid - reach).lower(), (mid + reach).upper()
        time = low.union(high)
        whole = time.union(ZERO)
        if not abs(box(guard.kappa)) * whole * whole < 1:
            return None
        turn = box(_height(guard, whole, 1))
        speeds = 4 * turn + whole * box(_height(guard, whole, 2))
        if sign(turn) != -1 or sign(speeds) != -1:
            return None
        ends = sign(_height(guard, low)), sign(_height(guard, high))
        if ends == (1, -1):
            over, along = _height(guard, time), _height(guard, time, 1)
            bend = box(_height(guard, time, 2))
            return Crossing(implicit(mid, time, value, slope, over, along, bend), time, True)
        reach = (reach * 2).upper()
    raise Undecided("the time of a landing has no enclosure")


def _height(guard: Guard, t: Any, derivative: int = 0) -> Any:
    """The function h or a derivative of it, at a ball of times with |kappa| t^2 < 1."""
    _, _, f2, f3 = guard.jet
    k = guard.kappa
    c = shapes(k, t)
    match derivative:
        case 0:
            return f2 * c[2] + f3 * (c[3] * t)
        case 1:
            turn_2, turn_3 = c[3] - 2 * c[4], c[4] - 3 * c[5]
            return f2 * (k * turn_2 * t) + f3 * (c[3] + k * turn_3 * (t * t))
        case _:
            turn_2, turn_3 = c[3] - 2 * c[4], c[4] - 3 * c[5]
            bend_2, bend_3 = turn_3 - 2 * (c[5] - 4 * c[6]), (c[5] - 4 * c[6]) - 3 * (c[6] - 5 * c[7])
            square = t * t
            return f2 * (k * (turn_2 + k * bend_2 * square)) + f3 * (
                k * (3 * turn_3 + k * bend_3 * square) * t
            )


def _refined(guard: Guard, guess: float) -> Any | None:
    """The zero of h near a guess at the centre of the box, as a ball; None if there is none."""
    t = arb(guess)
    for _ in range(60):
        step = centre(_height(guard, t)) / centre(_height(guard, t, 1))
        if not step.is_finite() or not abs(centre(guard.kappa)) * (t - step) ** 2 < 1:
            return None
        t = (t - step).mid()
        if abs(step.mid()) < arb(2) ** (12 - ctx.prec):
            break
    for widen in range(4, 64, 6):
        ball = t + arb(0, arb(2) ** (widen - ctx.prec))
        slope = centre(_height(guard, ball, 1))
        if sign(slope) != -1:
            return None
        newton = t - centre(_height(guard, t)) / slope
        if ball.contains_interior(newton):
            return newton.intersection(ball)
    return None
