"""Functions of a start and a parameter over a box |s| <= radius, |tau| <= half, with derivatives.

They are Taylor models on s = 0, and of derivatives for all s: along s, and where wanted along tau
and of second order.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import cached_property

from woodpecker.checking import intervals
from woodpecker.checking.intervals import Extent, I, T, inverse, inverse_factorial, through, wave

ORDERS: list[tuple[int, int]] = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)]
"""Derivatives (in s, in tau), in the order in which a form lists them."""


class Box:
    """|s| <= radius and a span of tau; how many of the derivatives are carried."""

    def __init__(self, radius: I, span: Extent, depth: int) -> None:
        self.s, self.span, self.depth = radius.ball, span, depth


class F:
    """A function over a box."""

    def __init__(self, box: Box, parts: Sequence[T]) -> None:
        self.box, self.parts = box, list(parts)

    @cached_property
    def value(self) -> I:
        """Its range."""
        return self.parts[0].range + self.parts[1].range * self.box.s

    @cached_property
    def all(self) -> list[T]:
        """The parts, the first one for all s."""
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
    """The first derivatives that a second one is made of."""
    return {3: (1, 1), 4: (1, 2), 5: (2, 2)}[n]


def constant(box: Box, x: I) -> F:
    """A number as a function."""
    zero = T(box.span, [0])
    return F(box, [zero.plus(x), *[zero] * (box.depth - 1)])


def chain(f: F, on_curve: T, slope: T, bend: Callable[[], T]) -> F:
    """g(f) from g on the curve, and g' and g'' over the box."""
    found = [on_curve]
    for n in range(1, f.box.depth):
        part = slope * f.parts[n]
        if n > 2:
            i, j = halves(n)
            part = part + bend() * f.parts[i] * f.parts[j]
        found.append(part)
    return F(f.box, found)


def over(f: F) -> F:
    """1 / f."""
    whole = inverse(f.all[0])
    square = whole * whole
    return chain(f, inverse(f.parts[0]), -square, lambda: (square * whole).scaled(I.of(2)))


def waves(kappa: I, t: F | I, box: Box) -> list[F | I]:
    """s_0 .. s_4 at a time."""
    if isinstance(t, I):
        return list(wave(kappa, t)[:5])
    curve, whole = _wave_models(kappa, t.parts[0]), _wave_models(kappa, t.all[0])
    return [
        chain(t, curve[k], whole[k - 1], lambda k=k: whole[k - 2])  # type: ignore[misc]
        for k in range(5)
    ]


def _wave_models(kappa: I, t: T) -> dict[int, T]:
    """s_(-2) .. s_4, with s_(k-2) = kappa s_k for k < 2."""
    n = t.span.terms
    tables = []
    for at in (t.first, t.range, t.poly):
        s = dict(enumerate(wave(kappa, at)))
        for k in range(-1, -4 - n, -1):
            s[k] = kappa * s[k + 2]
        tables.append(s)
    thin, whole, head = tables
    return {
        k: through(
            t,
            [thin[k - j] * inverse_factorial(j) for j in range(n)],
            whole[k - 1],
            head[k - n] * inverse_factorial(n),
        )
        for k in range(-2, 5)
    }


def shapes(x: F | I, last: int) -> list[F | I]:
    """c_0 .. c_last of x, c_k' = (c_(k+1) - k c_(k+2)) / 2."""
    if isinstance(x, I):
        return list(intervals.shapes(x, last))
    n = x.box.span.terms
    found: list[F | I] = []
    curve, whole = x.parts[0], x.all[0]
    on_curve = [_slopes(at, n + 1, last) for at in (curve.first, curve.range, curve.poly)]
    over_box = [_slopes(at, n + 3, last) for at in (whole.first, whole.range, whole.poly)]
    for k in range(last + 1):
        models = [_shape_model(whole, over_box, k, d) for d in (1, 2)]
        first = _shape_model(curve, on_curve, k, 0)
        found.append(chain(x, first, models[0], lambda m=models[1]: m))  # type: ignore[misc]
    return found


def _slopes(x: I, orders: int, last: int) -> list[list[I]]:
    """c_k of an interval and so many derivatives."""
    half = I.of(Fraction(1, 2))
    rows = [intervals.shapes(x, last + 2 * orders)]
    for _ in range(orders):
        c = rows[-1]
        rows.append([(c[k + 1] - I.of(k) * c[k + 2]) * half for k in range(len(c) - 2)])
    return rows


def _shape_model(x: T, tables: list[list[list[I]]], k: int, d: int) -> T:
    """The d-th derivative of c_k of a Taylor model."""
    n = x.span.terms
    thin, whole, head = tables
    taylor = [thin[d + j][k] * inverse_factorial(j) for j in range(n)]
    return through(x, taylor, whole[d + 1][k], head[d + n][k] * inverse_factorial(n))
