"""Forms: smooth functions over a box of starts and parameters, |s| <= radius, |p| <= half width.

s is the distance of the start from a curve over p; the toy's parameter is a polynomial in p. A
*form* f(s, p) consists of Taylor models of f on the curve s = 0, and of its derivatives for all s.
Its range is that on the curve plus f_s s, so it overestimates by O(s^2) and a power of p only,
however long the computation. Constants are balls of Arb [Johansson2017].
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from flint import arb_poly, ctx

from woodpecker.enclosures.balls import ZERO, ball
from woodpecker.enclosures.not_proved import NotProved
from woodpecker.enclosures.taylor import Frame, Taylor, constant, cut, inverse

VALUE, S, P, SS, SP, PP = range(6)  # parts of a form: its value, and derivatives in s and p
HALVES = {SS: (S, S), SP: (S, P), PP: (P, P)}  # a second derivative by its two variables


@contextmanager
def precision(bits: int) -> Iterator[None]:
    """Set the precision of balls in bits, inside a ``with`` statement."""
    before = ctx.prec
    ctx.prec = bits
    try:
        yield
    finally:
        ctx.prec = before


class Form:
    """A smooth function over a box.

    Its parts are Taylor models of the value on the curve s = 0, and of derivatives in all the box.
    """

    __slots__ = ("box", "frame", "parts")

    def __init__(self, frame: Frame, parts: Sequence[Taylor]) -> None:
        self.frame, self.parts = frame, tuple(parts)
        self.box = parts[VALUE].box + parts[S].box * frame.s

    @property
    def mid(self) -> Any:
        """Ball that holds the value at the centre, s = p = 0."""
        value = self.parts[VALUE]
        return value.poly[0] + value.rest

    @property
    def near(self) -> list[Taylor]:
        """The parts, with the value widened by f_s s so that it holds for all s."""
        value, *others = self.parts
        return [value.widened(others[0].box * self.frame.s), *others]

    @property
    def flat(self) -> bool:
        """Whether all derivatives are exactly zero."""
        return all(part.box.is_zero() for part in self.parts[1:])

    def __neg__(self) -> Form:
        return Form(self.frame, [-part for part in self.parts])

    def __add__(self, other: Any) -> Form:
        if not isinstance(other, Form):
            value, *others = self.parts
            return Form(self.frame, [value + constant(value.frame, other), *others])
        return Form(self.frame, [a + b for a, b in zip(self.parts, other.parts, strict=True)])

    __radd__ = __add__

    def __sub__(self, other: Any) -> Form:
        return self.__add__(-other)

    def __rsub__(self, other: Any) -> Form:
        return self.__neg__().__add__(other)

    def __mul__(self, other: Any) -> Form:
        if not isinstance(other, Form):
            return Form(self.frame, [part * other for part in self.parts])
        a, b = self.near, other.near
        found = [self.parts[VALUE] * other.parts[VALUE]]
        for n in range(S, len(a)):
            total = a[n] * b[VALUE] + a[VALUE] * b[n]
            if n in HALVES:
                i, j = HALVES[n]
                total = total + a[i] * b[j] + a[j] * b[i]
            found.append(total)
        return Form(self.frame, found)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Form:
        return self.__mul__(reciprocal(other))

    def __rtruediv__(self, other: Any) -> Form:
        over: Form = reciprocal(self)
        return over.__mul__(other)


def chained(f: Form, value: Taylor, slope: Taylor, bend: Callable[[], Taylor]) -> Form:
    """The form g(f), from Taylor models of g on the curve, and of g' and g'' in all the box."""
    found = [value, *(slope * part for part in f.parts[S:])]
    bent = bend() if len(found) > SS else slope
    for n in range(SS, len(found)):
        i, j = HALVES[n]
        found[n] = found[n] + bent * f.parts[i] * f.parts[j]
    return Form(f.frame, found)


def start(frame: Frame, curve: Sequence[Any]) -> Form:
    """The form of the start, curve(p) + s, from the coefficients of the curve."""
    return _polynomial(frame, curve, arb_poly([1]))


def varying(frame: Frame, line: Sequence[Any]) -> Form:
    """The form of the toy's parameter, from its coefficients of powers of p."""
    return _polynomial(frame, line, arb_poly([]))


def _polynomial(frame: Frame, coefficients: Sequence[Any], along_s: Any) -> Form:
    poly, none = arb_poly(list(coefficients)), arb_poly([])
    rate = poly.derivative()
    parts = [poly, along_s, rate, none, none, rate.derivative()]
    return Form(frame, [cut(frame, part, ZERO) for part in parts[: frame.depth]])


def reciprocal(x: Any) -> Any:
    """Return 1 / x for a form or a ball; NotProved where x may vanish."""
    x = ball(x)
    if box(x).contains(0):
        raise NotProved("a divisor may vanish")
    if not isinstance(x, Form):
        return 1 / x
    over = inverse(x.near[VALUE])
    square = over * over
    return chained(x, inverse(x.parts[VALUE]), -square, lambda: 2 * (square * over))


def box(x: Any) -> Any:
    """The range of a form, or a ball itself."""
    return x.box if isinstance(x, Form) else x


def centre(x: Any) -> Any:
    """The value of a form at the centre of its box, or a ball itself."""
    return x.mid if isinstance(x, Form) else x


def sign(x: Any) -> int | None:
    """Return the sign: -1 or 1, 0 if x is exactly zero, None if its range does not decide."""
    whole = box(x)
    if whole > 0:
        return 1
    if whole < 0:
        return -1
    return 0 if whole.is_zero() else None
