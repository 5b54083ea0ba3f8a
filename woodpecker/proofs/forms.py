"""Quantities over a box of starts and parameters, in ball arithmetic: mean value forms.

A *form* is a smooth function over the box |s| <= radius, |p - centre| <= half width: its value at
the centre, enclosures of its first (and, where asked for, second) derivatives over the whole box,
and its range, which is the plain enclosure intersected with the mean value form

    f(s, p) in f(0, centre) + f_s s + f_p (p - centre).

So ranges are too wide by the square of the box only, however long the computation
[Moore2009, ch. 6]. Numbers that do not vary are plain balls of Arb [Johansson2017].
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

from flint import arb, ctx, fmpq

ZERO = arb(0)
Balls = tuple[Any, ...]


class Undecided(Exception):  # noqa: N818  (no error: an answer)
    """What ball arithmetic could not decide over a box; the text says what."""


class Frame(NamedTuple):
    """The box of a form.

    Attributes
    ----------
    s, p
        Balls about zero: how far the start and the parameter are from the centre.
    second
        Whether forms carry second derivatives.
    """

    s: Any
    p: Any
    second: bool = False


@contextmanager
def precision(bits: int) -> Iterator[None]:
    """Balls with midpoints of so many bits, inside a ``with`` statement."""
    before = ctx.prec
    ctx.prec = bits
    try:
        yield
    finally:
        ctx.prec = before


class Form:
    """A smooth function over a box.

    Attributes
    ----------
    frame
        The box.
    mid
        Balls: at the centre the value and, in a frame of second order, the derivatives in s and p.
    d
        Range of the derivatives in s and p.
    h
        Range of the second derivatives ss, sp, pp; empty in a frame of first order.
    box
        Range of the value.
    """

    __slots__ = ("box", "d", "frame", "h", "mid")

    def __init__(self, frame: Frame, mid: Balls, value: Any, d: Balls, h: Balls) -> None:
        s, p = frame.s, frame.p
        self.frame, self.mid, self.h = frame, mid, h
        if h:
            ss, sp, pp = h
            d = (
                d[0].intersection(mid[1] + ss * s + sp * p),
                d[1].intersection(mid[2] + sp * s + pp * p),
            )
        self.d = d
        self.box = value.intersection(mid[0] + d[0] * s + d[1] * p)

    def __neg__(self) -> Form:
        mid, d, h = (tuple([-x for x in part]) for part in (self.mid, self.d, self.h))
        return Form(self.frame, mid, -self.box, d, h)

    def __add__(self, other: Any) -> Form:
        if not isinstance(other, Form):
            mid = (self.mid[0] + other, *self.mid[1:])
            return Form(self.frame, mid, self.box + other, self.d, self.h)
        parts = (self.mid, other.mid), (self.d, other.d), (self.h, other.h)
        mid, d, h = (tuple([x + y for x, y in zip(a, b, strict=True)]) for a, b in parts)
        return Form(self.frame, mid, self.box + other.box, d, h)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Form:
        return self + (-other)

    def __rsub__(self, other: Any) -> Form:
        return (-self) + other

    def __mul__(self, other: Any) -> Form:
        if not isinstance(other, Form):
            parts = self.mid, self.d, self.h
            mid, d, h = (tuple([x * other for x in part]) for part in parts)
            return Form(self.frame, mid, self.box * other, d, h)
        x, (a, b), m = self.box, self.d, self.mid
        y, (c, e), n = other.box, other.d, other.mid
        d = (a * y + x * c, b * y + x * e)
        if not self.h:
            return Form(self.frame, (m[0] * n[0],), x * y, d, ())
        (ss, sp, pp), (tt, tp, qq) = self.h, other.h
        h = (
            ss * y + 2 * a * c + x * tt,
            sp * y + a * e + b * c + x * tp,
            pp * y + 2 * b * e + x * qq,
        )
        mid = (m[0] * n[0], m[1] * n[0] + m[0] * n[1], m[2] * n[0] + m[0] * n[2])
        return Form(self.frame, mid, x * y, d, h)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Form:
        return self * reciprocal(other)

    def __rtruediv__(self, other: Any) -> Form:
        return reciprocal(self) * other

    def through(self, mid: Balls, value: Any, slope: Any, bend: Any) -> Form:
        """The form g(f) of a function g.

        Parameters
        ----------
        mid
            g and g' at the centre.
        value, slope, bend
            Ranges of g, g', g''.
        """
        a, b = self.d
        d = slope * a, slope * b
        if not self.h:
            return Form(self.frame, mid[:1], value, d, ())
        ss, sp, pp = self.h
        h = (slope * ss + bend * a * a, slope * sp + bend * a * b, slope * pp + bend * b * b)
        return Form(
            self.frame, (mid[0], mid[1] * self.mid[1], mid[1] * self.mid[2]), value, d, h
        )


def start(frame: Frame, value: Any, tilt: Any) -> Form:
    """The start value + tilt (p - centre) + s."""
    one = arb(1)
    mid, h = ((value, one, tilt), (ZERO,) * 3) if frame.second else ((value,), ())
    return Form(frame, mid, value + tilt * frame.p + frame.s, (one, tilt), h)


def parameter(frame: Frame, value: Any) -> Form:
    """The parameter."""
    one = arb(1)
    mid, h = ((value, ZERO, one), (ZERO,) * 3) if frame.second else ((value,), ())
    return Form(frame, mid, value + frame.p, (ZERO, one), h)


def reciprocal(x: Any) -> Any:
    """1 / x of a form or a ball; Undecided where x may vanish."""
    x = exact(x)
    ball = box(x)
    if ball.contains(0):
        raise Undecided("a divisor may vanish")
    if not isinstance(x, Form):
        return 1 / x
    over, centre_ = 1 / ball, 1 / x.mid[0]
    square = over * over
    return x.through((centre_, -centre_ * centre_), over, -square, 2 * square * over)


def of_two(
    x: Form, y: Form, mid: Balls, value: Any, slopes: Balls, bends: Balls
) -> Form:
    """The form g(x, y) of a function g of two.

    Parameters
    ----------
    mid
        g, g_x, g_y at the centre.
    value, slopes, bends
        Ranges of g, of g_x, g_y, and of g_xx, g_xy, g_yy.
    """
    g_x, g_y = slopes
    d = tuple([g_x * a + g_y * b for a, b in zip(x.d, y.d, strict=True)])
    if not x.h:
        return Form(x.frame, mid[:1], value, d, ())
    g_xx, g_xy, g_yy = bends
    h = tuple(
        [
            g_x * x.h[k] + g_y * y.h[k] + g_xx * x.d[i] * x.d[j] + g_yy * y.d[i] * y.d[j]
            + g_xy * (x.d[i] * y.d[j] + x.d[j] * y.d[i])
            for k, (i, j) in enumerate(((0, 0), (0, 1), (1, 1)))
        ]
    )  # fmt: skip
    middle = [mid[1] * a + mid[2] * b for a, b in zip(x.mid[1:], y.mid[1:], strict=True)]
    return Form(x.frame, (mid[0], *middle), value, d, h)


def implicit(mid: Any, ball: Any, there: Form, speed: Any, over: Form, slope: Form, bend: Any) -> Form:
    """The zero t(s, p) of f(t, s, p) as a form.

    Parameters
    ----------
    mid, ball
        Its value at the centre, and its range.
    there, speed
        f at the value at the centre, a form of s and p, and f_t at the centre.
    over, slope, bend
        f and f_t at a t that is fixed anywhere in the range, and the range of f_tt.
    """
    factor = -1 / slope.box
    a, b = over.d[0] * factor, over.d[1] * factor
    if not over.h:
        return Form(over.frame, (mid,), ball, (a, b), ())
    (ss, sp, pp), (turn_s, turn_p) = over.h, slope.d
    h = (
        (ss + 2 * turn_s * a + bend * a * a) * factor,
        (sp + turn_s * b + turn_p * a + bend * a * b) * factor,
        (pp + 2 * turn_p * b + bend * b * b) * factor,
    )
    return Form(over.frame, (mid, -there.mid[1] / speed, -there.mid[2] / speed), ball, (a, b), h)


def box(x: Any) -> Any:
    """The range of a form, or a ball itself."""
    return x.box if isinstance(x, Form) else x


def centre(x: Any) -> Any:
    """The value of a form at the centre of its box, or a ball itself."""
    return x.mid[0] if isinstance(x, Form) else x


def sign(x: Any) -> int | None:
    """-1, 1, 0 if it is exactly zero, None if the range does not decide."""
    ball = box(x)
    if ball > 0:
        return 1
    if ball < 0:
        return -1
    return 0 if ball.is_zero() else None


def exact(value: Any) -> Any:
    """The ball of a rational number."""
    return arb(value) if isinstance(value, fmpq | int) else value


def between(low: Any, high: Any) -> Any:
    """The smallest ball known of an interval."""
    return low.union(high)
