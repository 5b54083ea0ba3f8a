"""Stumpff's functions s_k(t) = t^k c_k(kappa t^2), c_k(x) = 1/k! + x/(k+2)! + ..., in balls.

Their Taylor models follow from the derivatives d s_k / dt = s_(k-1), d s_0 / dt = kappa s_1, and
d c_k / dx = (c_(k+1) - k c_(k+2)) / 2 [Stiefel1971, sec. 11].
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import accumulate, repeat
from math import factorial
from operator import mul
from typing import Any

from flint import arb

from woodpecker.enclosures.balls import ZERO
from woodpecker.enclosures.forms import VALUE, Form, chained
from woodpecker.enclosures.taylor import Taylor, composed

LARGEST = 64  # |x| up to which the series of c_k is summed: its terms soon decrease

Table = Callable[[int, int], Any]  # of (k, d): the d-th derivative of the k-th function


def applied(f: Form, at: Callable[[Any], Table], count: int) -> list[Form]:
    """The forms g_0(f) .. g_(count-1)(f); ``at`` gives all g_k and their derivatives at a ball."""
    curve = _models(f.parts[VALUE], at)
    if f.flat:
        return [Form(f.frame, [curve(k, 0), *f.parts[1:]]) for k in range(count)]
    near = _models(f.near[VALUE], at)
    return [
        chained(f, curve(k, 0), near(k, 1), lambda k=k: near(k, 2))  # type: ignore[misc]
        for k in range(count)
    ]


def _models(f: Taylor, at: Callable[[Any], Table]) -> Table:
    n = f.frame.terms
    thin, wide, head = (at(x) for x in (f.poly[0], f.box, f.head))

    def model(k: int, d: int) -> Taylor:
        taylor = [thin(k, d + j) / factorial(j) for j in range(n)]
        return composed(f, taylor, wide(k, d + 1), head(k, d + n) / factorial(n))

    return model


def stumpff(kappa: Any, t: Any) -> list[Any]:
    """Return s_0 .. s_4 at a time, as balls or forms as the time is."""
    if not isinstance(t, Form):
        return stumpff_balls(kappa, t, 4)
    lowest = -2 - t.frame.terms

    def at(t: Any) -> Table:
        s = dict(enumerate(stumpff_balls(kappa, t, 4)))
        for k in range(-1, lowest - 1, -1):
            s[k] = kappa * s[k + 2]  # continues s_k' = s_(k-1) below k = 0
        return lambda k, d: s[k - d]

    return list(applied(t, at, 5))


def shapes(x: Any, last: int) -> list[Any]:
    """Return c_0 .. c_last, as balls or forms as x is."""
    if not isinstance(x, Form):
        return shape_balls(x, last)
    orders = x.frame.terms + 3

    def at(x: Any) -> Table:
        rows = [shape_balls(x, last + 2 * orders)]
        for _ in range(orders - 1):
            c = rows[-1]
            rows.append([(c[k + 1] - k * c[k + 2]) / 2 for k in range(len(c) - 2)])
        return lambda k, d: rows[d][k]

    return list(applied(x, at, last + 1))


def stumpff_balls(kappa: Any, t: Any, last: int) -> list[Any]:
    """Return s_0 .. s_last as balls; a wide time is met with the mean value form at its centre."""
    if abs(kappa * t * t) < 1:
        powers = accumulate(repeat(t, last), mul, initial=arb(1))
        return list(map(mul, powers, shape_balls(kappa * t * t, last)))
    found = _closed(kappa, t, last)
    if t.is_exact():
        return found
    middle, step = _closed(kappa, t.mid(), last), t - t.mid()
    for n in range(1, last + 1):
        found[n] = found[n].intersection(middle[n] + found[n - 1] * step)
    return found


def shape_balls(x: Any, last: int) -> list[Any]:
    """Return c_0 .. c_last as balls, with c_n = 1F2(1; (n + 1)/2, (n + 2)/2; x/4) / n!."""
    if not abs(x) < LARGEST:
        return _closed(x, arb(1), last)
    found = [ZERO] * (last + 1)
    for n in range(max(last - 1, 0), last + 1):
        series = (x / 4).hypgeom([arb(1)], [arb(n + 1) / 2, arb(n + 2) / 2])
        found[n] = series / factorial(n)
    for n in range(last - 2, -1, -1):
        found[n] = arb(1) / factorial(n) + x * found[n + 2]
    return found


def _closed(kappa: Any, t: Any, last: int) -> list[Any]:
    """Return s_0 .. s_last by s_(k+2) = (s_k - t^k / k!) / kappa, for |kappa| t^2 not small."""
    if kappa < 0:
        omega = (-kappa).sqrt()
        s, c = (omega * t).sin_cos()
    elif kappa > 0:
        omega = kappa.sqrt()
        s, c = (omega * t).sinh_cosh()
    else:
        return [arb.nan()] * (last + 1)
    found = [c, s / omega]
    power = arb(1)
    for n in range(2, last + 1):
        found.append((found[n - 2] - power) / kappa)
        power = power * t / (n - 1)
    return found
