"""The spring oscillator over forms: its closed form, and guards that obey f'''' = kappa f''.

With Stumpff's functions s_k(t) = t^k c_k(kappa t^2), where c_k(x) = 1/k! + x/(k+2)! + ...,

    f(t) = f_0 + f_1 t + f_2 s_2 + f_3 s_3,    d s_k / dt = s_(k-1),    d s_0 / dt = kappa s_1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

from flint import arb, ctx

from woodpecker.proofs.forms import Form, Undecided, box, centre, implicit, of_two, sign

ZERO = arb(0)
HALVINGS = 40  # of a phase in which a guard is shown to be positive: a millionth of a millionth


def stumpff(kappa: Any, t: Any) -> list[Any]:
    """s_0 .. s_4 of balls or forms.

    d s_k / d kappa = (t s_(k+1) - k s_(k+2)) / 2.
    """
    if not isinstance(kappa, Form) and not isinstance(t, Form):
        return _balls(kappa, t, 4)
    mids = _balls(centre(kappa), centre(t), 4)
    k, time = box(kappa), box(t)
    if not isinstance(kappa, Form):
        over = _balls(k, time, 4)
        return [
            t.through(
                (mids[n], mids[n - 1] if n > 0 else k * mids[1]),
                over[n],
                over[n - 1] if n > 0 else k * over[1],
                over[n - 2] if n > 1 else k * over[n],
            )
            for n in range(5)
        ]
    over, mids = _balls(k, time, 8), _balls(centre(kappa), centre(t), 6)
    still = kappa * ZERO + t if not isinstance(t, Form) else t
    found = []
    for n in range(5):
        ahead = over[n - 1] if n > 0 else k * over[1]
        before = over[n - 2] if n > 1 else k * over[n]
        turn = [_turn(over, time, m) for m in (n, n + 1, n + 2)]
        mixed = (over[n + 1] + time * over[n] - n * over[n + 1]) / 2
        middle = mids[n - 1] if n > 0 else centre(kappa) * mids[1]
        found.append(
            of_two(
                kappa,
                still,
                (mids[n], _turn(mids, centre(t), n), middle),
                over[n],
                (turn[0], ahead),
                ((time * turn[1] - n * turn[2]) / 2, mixed, before),
            )
        )
    return found


def _turn(s: list[Any], t: Any, n: int) -> Any:
    """The derivative of s_n in kappa."""
    return (t * s[n + 1] - n * s[n + 2]) / 2


def shapes(kappa: Any, t: Any) -> list[Any]:
    """c_0 .. c_7 at kappa t^2, for |kappa| t^2 < 1; forms where kappa is one."""
    if not isinstance(kappa, Form):
        return _series(kappa * t * t, 7)
    x = kappa * (t * t)
    mids, over = _series(centre(x), 9), _series(x.box, 11)
    found = []
    for k in range(8):
        slope, bend = _shape_slope(over, k), (_shape_slope(over, k + 1) - k * _shape_slope(over, k + 2)) / 2
        found.append(x.through((mids[k], _shape_slope(mids, k)), over[k], slope, bend))
    return found


def _shape_slope(c: list[Any], k: int) -> Any:
    """d c_k / dx = (c_(k+1) - k c_(k+2)) / 2."""
    return (c[k + 1] - k * c[k + 2]) / 2


def _balls(kappa: Any, t: Any, last: int) -> list[Any]:
    """s_0 .. s_last of balls."""
    x = kappa * t * t
    if abs(x) < 1:
        shapes = _series(x, last)
        power, found = arb(1), []
        for n in range(last + 1):
            found.append(power * shapes[n])
            power = power * t
        return found
    found = _closed(kappa, t, last)
    if t.is_exact():
        return found
    middle, step = _closed(kappa, t.mid(), last), t - t.mid()
    for n in range(1, last + 1):
        found[n] = found[n].intersection(middle[n] + found[n - 1] * step)
    return found


def _series(x: Any, last: int) -> list[Any]:
    """c_0 .. c_last of a ball |x| < 1; the tail of each sum is a geometric series."""
    found = [arb(0)] * (last + 1)
    size = abs(x).upper()
    for n in (last, last - 1):
        total, term, k = arb(0), arb(1) / math.factorial(n), n
        while not abs(term).upper() < arb(2) ** (-ctx.prec - 8):
            total = total + term
            term = term * x / ((k + 1) * (k + 2))
            k += 2
        tail = (abs(term).upper() / (1 - size / ((k + 1) * (k + 2)))).upper()
        found[n] = total + arb(0, tail)
    for n in range(last - 2, -1, -1):
        found[n] = arb(1) / math.factorial(n) + x * found[n + 2]
    return found


def _closed(kappa: Any, t: Any, last: int) -> list[Any]:
    if kappa < 0:
        omega = (-kappa).sqrt()
        s, c = (omega * t).sin_cos()
    elif kappa > 0:
        omega = kappa.sqrt()
        s, c = (omega * t).sinh_cosh()
    else:
        raise Undecided("the sign of an oscillator's stiffness is open")
    found = [c, s / omega]
    power = arb(1)  # t^n / n!
    for n in range(2, last + 1):
        found.append((found[n - 2] - power) / kappa)
        power = power * t / (n - 1)
    return found


@dataclass(frozen=True, slots=True)
class Guard:
    """A guard of a phase: positive in it, zero where it fires.

    Attributes
    ----------
    code
        As in :mod:`woodpecker.mechanics.modes`.
    jet
        Its value and three derivatives where the phase begins; exact zeros are exact.
    order
        How many of these are exactly zero.
    kappa
        Of the phase.
    assumed
        Whether the first one that is not exactly zero is known to be at least zero, though its
        range does not say so.
    """

    code: int
    jet: tuple[Any, Any, Any, Any]
    order: int
    kappa: Any
    assumed: bool = False

    def at(self, t: Any, derivative: int = 0) -> Any:
        """The guard, or a derivative of it, at a time; forms where anything is one."""
        f0, f1, f2, f3 = self.jet
        s = stumpff(self.kappa, t)
        return _value(f0, f1, f2, f3, self.kappa, s, t, derivative)

    def over(self, t: Any, derivative: int = 0) -> Any:
        """Range of the same over a ball of times and the whole box."""
        f0, f1, f2, f3 = (box(f) for f in self.jet)
        k = box(self.kappa)
        return _value(f0, f1, f2, f3, k, _balls(k, t, 4), t, derivative)

    def lasts(self, end: Any) -> bool:
        """Whether it is proved positive on (0, end], for an exact end > 0."""
        low = self._grows(end)
        if low is None:
            return False
        parts = [(low, end, 0)]
        while parts:
            a, b, depth = parts.pop()
            if not b > a or self._positive(a, b):
                continue
            middle = ((a + b) / 2).mid()
            if depth >= HALVINGS or sign(self.at(middle)) == -1:
                return False
            parts += [(middle, b, depth + 1), (a, middle, depth + 1)]
        return True

    def _positive(self, a: Any, b: Any) -> bool:
        """Whether it is positive on [a, b]: by its range, or by its end where it is monotone."""
        t = a.union(b)
        if self.over(t) > 0:
            return True
        slope = sign(self.over(t, 1))
        if not slope:
            return False
        lower = a if slope == 1 else b
        return bool(self.over(lower) > 0) or sign(self.at(lower)) == 1

    def _grows(self, end: Any) -> Any | None:
        """A time > 0 until which it is positive because it grows from its zero; 0: no zero."""
        leading = box(self.jet[self.order])
        if self.order == 0 and leading > 0:
            return arb(0)
        n = self.order
        if not leading > 0:
            if not self.assumed:
                return None
            n += 1  # it is at least zero, and the next derivative takes it on
        low = end
        for _ in range(HALVINGS):
            if self.over(arb(0).union(low), n) > 0:
                return low
            low = (low / 2).mid()
        return None


def _value(
    f0: Any, f1: Any, f2: Any, f3: Any, kappa: Any, s: list[Any], t: Any, derivative: int
) -> Any:
    match derivative:
        case 0:
            return f0 + f1 * t + f2 * s[2] + f3 * s[3]
        case 1:
            return f1 + f2 * s[1] + f3 * s[2]
        case 2:
            return f2 * s[0] + f3 * s[1]
        case 3:
            return f3 * s[0] + kappa * f2 * s[1]
        case _:
            return kappa * (f2 * s[0] + f3 * s[1])


class Crossing(NamedTuple):
    """When a guard crosses zero.

    Attributes
    ----------
    time
        As a form.
    bracket
        A ball of times in which the guard crosses once from every start of the box: its derivative
        has one sign there, and its values at both ends differ in sign.
    lands
        Whether it is the end of a flight that began at rest.
    """

    time: Any
    bracket: Any
    lands: bool = False


def crossing(guard: Guard, guess: float, falls: int = -1) -> Crossing:
    """When a guard crosses zero near a guess, with a derivative of the sign ``falls``.

    Raises
    ------
    Undecided
        If this could not be shown.
    """
    mid = _refined(guard, guess)
    slope = centre(guard.at(mid, 1))
    if sign(slope) != falls:
        raise Undecided("a guard turns where it fires")
    value = guard.at(mid)
    if not isinstance(value, Form):
        return Crossing(mid, mid)
    frame = value.frame
    reach = abs((value.d[0] * frame.s + value.d[1] * frame.p) / slope).upper()
    reach = (reach * arb(1.05) + arb(2) ** (20 - ctx.prec)).upper()
    for _ in range(6):
        low, high = (mid - reach).lower(), (mid + reach).upper()
        time = low.union(high)
        speed = guard.over(time, 1)
        if sign(speed) != falls:
            raise Undecided("a guard may turn where it fires")
        ends = sign(guard.at(low)), sign(guard.at(high))
        if ends == (-falls, falls):
            over, along = guard.at(time), guard.at(time, 1)
            bend = guard.over(time, 2)
            return Crossing(implicit(mid, time, value, slope, over, along, bend), time)
        reach = (reach * 2).upper()
    raise Undecided("the time of an event has no enclosure")


def _refined(guard: Guard, guess: float) -> Any:
    """The zero near a guess at the centre of the box, as a ball that contains it."""
    f0, f1, f2, f3 = (centre(f) for f in guard.jet)
    k, t = centre(guard.kappa), arb(guess)
    for _ in range(60):
        s = _balls(k, t, 3)
        value = _value(f0, f1, f2, f3, k, s, t, 0)
        slope = _value(f0, f1, f2, f3, k, s, t, 1)
        step = value / slope
        if not step.is_finite():
            raise Undecided("the time of an event has no enclosure")
        t = (t - step).mid()
        if abs(step.mid()) < arb(2) ** (12 - ctx.prec):
            break
    for widen in range(4, 64, 6):
        ball = t + arb(0, arb(2) ** (widen - ctx.prec))
        slope = _value(f0, f1, f2, f3, k, _balls(k, ball, 3), ball, 1)
        value = _value(f0, f1, f2, f3, k, _balls(k, t, 3), t, 0)
        if not sign(slope):
            break
        newton = t - value / slope
        if ball.contains_interior(newton):
            return newton.intersection(ball)
    raise Undecided("the time of an event has no enclosure")
