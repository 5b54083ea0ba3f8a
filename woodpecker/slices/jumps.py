"""Jumps of iterates that cross the diagonal: border orbits with the limits on both sides.

P_N jumps at x_0 if the last point of an orbit x_0, x_1, .. x_k is a jump of P_1. Following both
one-sided values there for the rest of the N returns gives the two limits of P_N. The jump crosses
the diagonal if they lie on different sides of x_0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from woodpecker.base.settings import Settings
from woodpecker.maps.pieces import Image, PiecewiseMap
from woodpecker.slices.borders import beyond
from woodpecker.slices.orbits import Orbit


@dataclass(frozen=True, slots=True, eq=False)
class Jump:
    """A jump of P_order.

    Attributes
    ----------
    head
        The border orbit x_0 .. x_k, whose last point lies on the border of its piece.
    code, outer_code
        Codes of the margins that vanish there, of that piece and of the one beyond.
    order
        The iterate.
    inner, outer
        The orbits that continue from the border under these two pieces; they end in the limits.

    Examples
    --------
    >>> from woodpecker import Settings, slices_at
    >>> from woodpecker.examples import two_lines
    >>> one, = slices_at(two_lines(), 0.5, (1,), Settings(span=(-1, 2), window=(-3, 3)))
    >>> jump, = one.jumps
    >>> jump.x, jump.inner.value, jump.outer.value, jump.word
    (0.0, 0.5, -0.5, 'L / R')
    """

    head: Orbit
    code: int
    order: int
    inner: Orbit
    outer: Orbit
    outer_code: int

    @property
    def x(self) -> float:
        """Its place x_0."""
        return float(self.head.x[0])

    @property
    def p(self) -> float:
        """The parameter."""
        return self.head.p

    @property
    def offsets(self) -> tuple[float, float]:
        """The inner and the outer limit, each minus x_0."""
        return self.inner.value - self.x, self.outer.value - self.x

    @property
    def crosses(self) -> bool:
        """Whether the limits lie on different sides of the diagonal."""
        one, other = self.offsets
        return one * other < 0.0

    @property
    def inner_side(self) -> int:
        """The side of x_0 on which P_order has the inner limit: 1 if at larger x, else -1."""
        # The inner piece lies where its margin grows; each falling return before turns the side.
        side = math.copysign(1.0, self.head.images[-1].gradient(self.code)[0])
        for image in self.head.images[:-1]:
            side = math.copysign(1.0, side * image.slope)
        return int(side)

    @property
    def word(self) -> str:
        """The words of both limits, that from the left first."""
        before = self.head.words[:-1]
        inner, outer = (" | ".join((*before, *side.words)) for side in (self.inner, self.outer))
        return f"{outer} / {inner}" if self.inner_side > 0 else f"{inner} / {outer}"


def limit_of(map_: PiecewiseMap, x: float, first: Image, returns: int, p: float) -> Orbit:
    """The orbit of a border point x with the image ``first``, continued for ``returns`` more."""
    points, images = [x], [first]
    for _ in range(returns):
        if images[-1].reason:
            break
        points.append(images[-1].value)
        images.append(map_.at(points[-1], p))
    return Orbit(np.array(points), p, tuple(images))


def jump_of(map_: PiecewiseMap, head: Orbit, code: int, order: int, settings: Settings) -> Jump:
    """The jump of P_order at the first point of a border orbit ``head``, with both limits."""
    inner, returns, x = head.images[-1], order - len(head), float(head.x[-1])
    outer, outer_code = beyond(map_, x, head.p, inner.onward(code), settings)
    one, other = (limit_of(map_, x, image, returns, head.p) for image in (inner, outer))
    return Jump(head, code, order, one, other, outer_code)
