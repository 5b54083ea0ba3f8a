"""Functions of a start and a parameter over a box |s| <= radius, |tau| <= half, with derivatives.

A function consists of Taylor models of its value on s = 0, and of its derivatives for all s: in s,
and on request in tau and of second order.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import cached_property
from typing import Any

from woodpecker.checking import intervals
from woodpecker.checking.intervals import Box, I, T, inverse, inverse_factorial, through, wave

ORDERS = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)]  # of the parts: derivatives in s, in tau


class F:
    """A function over a box."""

    def __init__(self, box: Box, parts: Sequence[T]) -> None:
        self.box, self.parts = box, list(parts)

    @cached_property
    def value(self) -> I:
        """Range of the function."""
        return self.parts[0].range + self.parts[1].range * self.box.s

    @cached_property
    def all(self) -> list[T]:
        """The parts, with the value widened so that it holds for all s."""
        return [self.parts[0].wider(self.parts[1].range * self.box.s), *self.parts[1:]]

    def part(self, order: tuple[int, int]) -> I:
        """Range of a derivative."""
        return self.parts[ORDERS.index(order)].range

    def __add__(self, other: F | I) -> F:
        if isinstance(other, I):
            return F(self.box, [self.parts[0].plus(other), *self.parts[1:]])
        return F(self.box, [a + b for a, b in zip(self.parts, other.parts, strict=True)])

    __radd__ = __add__

    def __neg__(self) -> F:
        return F(self.box, [-a for a in self.parts])

    def __sub__(self, other: F | I) -> F:
        return self + (-other)

    def __mul__(self, other: F | I) -> F:
        if isinstance(other, I):
            return F(self.box, [a.scaled(other) for a in self.parts])
        a, b = self.all, other.all
        found = [self.parts[0] * other.parts[0]]
        for n in range(1, self.box.depth):
            total = a[n] * b[0] + a[0] * b[n]
            if n > 2:
                i, j = halves(n)
                total = total + a[i] * b[j] + a[j] * b[i]
            found.append(total)
        return F(self.box, found)

    __rmul__ = __mul__


def halves(n: int) -> tuple[int, int]:
    """The parts of the two first derivatives that belong to part n, a second derivative."""
    return {3: (1, 1), 4: (1, 2), 5: (2, 2)}[n]


def constant(box: Box, x: I) -> F:
    """A constant function."""
    zero = T(box, [0])
    return F(box, [zero.plus(x), *[zero] * (box.depth - 1)])


def chain(f: F, on_curve: T, slope: T, bend: Callable[[], T]) -> F:
    """The function g(f), from g on the curve s = 0, and g' and g'' over the box."""
    found = [on_curve, *(slope * part for part in f.parts[1:])]
    bent = bend() if len(found) > 3 else slope
    for n in range(3, len(found)):
        i, j = halves(n)
        found[n] = found[n] + bent * f.parts[i] * f.parts[j]
    return F(f.box, found)


def over(f: F) -> F:
    """The function 1 / f."""
    whole = inverse(f.all[0])
    square = whole * whole
    return chain(f, inverse(f.parts[0]), -square, lambda: (square * whole).scaled(I.of(2)))


Table = Callable[[int, int], Any]  # of (k, d): the d-th derivative of the k-th function


def applied(f: F, at: Callable[[I], Table], count: int) -> list[F]:
    """g_0(f) .. g_(count-1)(f); ``at`` gives all g_k and their derivatives on an interval."""
    curve, whole = _models(f.parts[0], at), _models(f.all[0], at)
    return [
        chain(f, curve(k, 0), whole(k, 1), lambda k=k: whole(k, 2))  # type: ignore[misc]
        for k in range(count)
    ]


def _models(f: T, at: Callable[[I], Table]) -> Table:
    n = f.box.terms
    thin, whole, head = (at(x) for x in (f.first, f.range, f.poly))

    def model(k: int, d: int) -> T:
        taylor = [thin(k, d + j) * inverse_factorial(j) for j in range(n)]
        return through(f, taylor, whole(k, d + 1), head(k, d + n) * inverse_factorial(n))

    return model


def waves(kappa: I, t: F | I) -> list[F | I]:
    """Stumpff's functions s_0 .. s_4 at a time."""
    if isinstance(t, I):
        return list(wave(kappa, t)[:5])
    last = t.box.terms + 2

    def at(x: I) -> Table:
        """Derivatives of s_k are s_(k-1), and s_(k-2) = kappa s_k for k < 2."""
        s = dict(enumerate(wave(kappa, x)))
        for k in range(-1, -last - 1, -1):
            s[k] = kappa * s[k + 2]
        return lambda k, d: s[k - d]

    return list(applied(t, at, 5))


def shapes(x: F | I, last: int) -> list[F | I]:
    """Stumpff's functions c_0 .. c_last of x, c_k' = (c_(k+1) - k c_(k+2)) / 2."""
    if isinstance(x, I):
        return list(intervals.shapes(x, last))
    orders, half = x.box.terms + 3, I.of(Fraction(1, 2))

    def at(x: I) -> Table:
        rows = [intervals.shapes(x, last + 2 * orders)]
        for _ in range(orders):
            c = rows[-1]
            rows.append([(c[k + 1] - I.of(k) * c[k + 2]) * half for k in range(len(c) - 2)])
        return lambda k, d: rows[d][k]

    return list(applied(x, at, last + 1))
