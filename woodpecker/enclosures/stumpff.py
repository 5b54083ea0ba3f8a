"""Stumpff's functions s_k(t) = t^k c_k(kappa t^2), c_k(x) = 1/k! + x/(k+2)! + ..., in balls.

d s_k / dt = s_(k-1), d s_0 / dt = kappa s_1, and d c_k / dx = (c_(k+1) - k c_(k+2)) / 2
[Stiefel1971, sec. 11]. Their Taylor models follow from these.
"""

from __future__ import annotations

from math import factorial
from typing import Any

from flint import arb, ctx

from woodpecker.enclosures.balls import ZERO
from woodpecker.enclosures.taylor import Taylor, composed

LARGEST = 64  # of |x|, where the terms of a series soon fall


def stumpff_models(kappa: Any, t: Taylor, first: int, last: int) -> list[Taylor]:
    """s_first .. s_last of a time, for a ball kappa; s_(-1) = kappa s_1, s_(-2) = kappa s_0."""
    n = t.frame.terms
    thin, wide, head = (_table(kappa, at, n, last) for at in (t.poly[0], t.box, t.head))
    found = []
    for k in range(first, last + 1):
        coefficients = [thin[k - j] / factorial(j) for j in range(n)]
        found.append(composed(t, coefficients, wide[k - 1], head[k - n] / factorial(n)))
    return found


def _table(kappa: Any, t: Any, n: int, last: int) -> dict[int, Any]:
    """s_k for k from -2 - n, by s_(k-2) = kappa s_k for k < 2."""
    table = dict(enumerate(stumpff_balls(kappa, t, last)))
    for k in range(-1, -3 - n - 1, -1):
        table[k] = kappa * table[k + 2]
    return table


def shape_models(x: Taylor, last: int) -> list[list[Taylor]]:
    """c_0 .. c_last of a Taylor model, and their first two derivatives."""
    n = x.frame.terms
    thin, wide, head = (_derivatives(at, n + 3, last) for at in (x.poly[0], x.box, x.head))
    return [
        [
            composed(
                x,
                [thin[d + j][k] / factorial(j) for j in range(n)],
                wide[d + 1][k],
                head[d + n][k] / factorial(n),
            )
            for k in range(last + 1)
        ]
        for d in range(3)
    ]


def _derivatives(x: Any, orders: int, last: int) -> list[list[Any]]:
    """c_0 .. c_last of a ball and their derivatives, so many orders."""
    rows = [shape_balls(x, last + 2 * orders)]
    for _ in range(orders - 1):
        c = rows[-1]
        rows.append([(c[k + 1] - k * c[k + 2]) / 2 for k in range(len(c) - 2)])
    return rows


def stumpff_balls(kappa: Any, t: Any, last: int) -> list[Any]:
    """s_0 .. s_last of balls; where the time is wide, from its centre."""
    if abs(kappa * t * t) < 1:
        return _powers(t, shape_balls(kappa * t * t, last))
    found = _closed(kappa, t, last)
    if t.is_exact():
        return found
    middle, step = _closed(kappa, t.mid(), last), t - t.mid()
    for n in range(1, last + 1):
        found[n] = found[n].intersection(middle[n] + found[n - 1] * step)
    return found


def _powers(t: Any, c: list[Any]) -> list[Any]:
    power, found = arb(1), []
    for each in c:
        found.append(power * each)
        power = power * t
    return found


def shape_balls(x: Any, last: int) -> list[Any]:
    """c_0 .. c_last of a ball."""
    if abs(x) < LARGEST:
        return _shape_series(x, last)
    return _closed(x, arb(1), last)


def _shape_series(x: Any, last: int) -> list[Any]:
    """The same by series; the tail of each is smaller than a geometric one."""
    found = [ZERO] * (last + 1)
    size = abs(x).upper()
    for n in range(max(last - 1, 0), last + 1):
        total, term, k = ZERO, arb(1) / factorial(n), n
        small = abs(term).upper() * arb(2) ** (-ctx.prec - 8)
        # Terms fall faster than any geometric series, also if x is wide: they end.
        while not (abs(term).upper() <= small and size < (k + 1) * (k + 2) / 2):
            total = total + term
            term = term * x / ((k + 1) * (k + 2))
            k += 2
        tail = (abs(term).upper() / (1 - size / ((k + 1) * (k + 2)))).upper()
        found[n] = total + arb(0, tail)
    for n in range(last - 2, -1, -1):
        found[n] = arb(1) / factorial(n) + x * found[n + 2]
    return found


def _closed(kappa: Any, t: Any, last: int) -> list[Any]:
    """s_0 .. s_last where |kappa| t^2 is not small: s_(k+2) = (s_k - t^k / k!) / kappa."""
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
