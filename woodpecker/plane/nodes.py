"""Samples of curves, and the functions that vanish at their special points."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pwmap.diagrams.diagram import PointKind
from pwmap.plane.kinds import PlaneKind
from woodpecker.base.arrays import Floats
from woodpecker.piecewise.borders import Border, BorderKind
from woodpecker.piecewise.branch_points import Multiplier, ways
from woodpecker.piecewise.crossings import border_at
from woodpecker.piecewise.jumps import limit_of
from woodpecker.piecewise.margins import depth
from woodpecker.piecewise.orbits import Margin, Orbit
from woodpecker.piecewise.settings import Settings
from woodpecker.plane.places import Locus, Place, Plane, Unknown

THIRD = 2.0**-10  # part of the unit of x over which a second difference of slopes is taken: its
# error is the square, and rounding over the square is 1e-10
STEEP = 1e10  # a slope above this is that of a root right at its border, as it is rounded
APART = 2.0**-5  # and part of the distance from the nearest border at most, where slopes may be
# those of a root


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """A place on a curve, and the way it goes.

    Attributes
    ----------
    place
        The orbit.
    tangent
        (n + 2,) in scaled unknowns, forward.
    border
        The border that is met, if one is.
    gap
        There: the limit of P_n beyond it, less that inside; nan if it has none.
    along
        Whether it goes the way of the oriented tangent of the equations; None if that is not known.
    """

    place: Place
    tangent: Floats
    border: Border | None = None
    gap: float = 0.0
    along: bool | None = None

    @property
    def orbit(self) -> Orbit:
        """As seen along the first parameter."""
        return self.place.orbit

    @property
    def inside(self) -> float:
        """Multiplier of the cycle; nan where it ends in a root, and is infinite."""
        steep = any(abs(image.slope) >= STEEP for image in self.orbit.images)
        return math.nan if steep else self.orbit.multiplier

    def beyond(self, index: int) -> float:
        """The same with the piece beyond the border at one of its points; nan if none is met."""
        if self.border is None:
            return math.nan
        product = self.border.outer.slope
        for i, image in enumerate(self.orbit.images):
            if i != index:
                product *= image.slope
        return product

    def kind(self, settings: Settings) -> BorderKind | None:
        """What the map does at the border."""
        return None if self.border is None else self.border.kind(settings)


def node_at(plane: Plane, locus: Locus, place: Place, along: Floats) -> Node:
    """A place as a sample."""
    if locus.border is None:
        return Node(place, along)
    map_ = plane.map(place.values)
    border = border_at(map_, place.orbit, locus.border, plane.first)
    limit = limit_of(map_, border.outer, len(place) - 1, place.values[0])
    return Node(place, along, border, limit.value - float(place.orbit.x[locus.border.index]))


@dataclass(frozen=True, slots=True, eq=False)
class Test:
    """A function of nodes whose change of sign is a special point through which a curve passes."""

    kind: PlaneKind
    value: Callable[[Node], float]
    ends: bool = False


def tests_of(plane: Plane, locus: Locus, n: int) -> tuple[Test, ...]:
    """What may happen along a curve of cycles of n points."""
    margin = locus.border
    if margin is not None:
        index = margin.index
        return (
            Test(PlaneKind.FOLD_BORDER, lambda node: node.inside - 1.0),
            Test(PlaneKind.FLIP_BORDER, lambda node: node.inside + 1.0),
            Test(PlaneKind.FOLD_BORDER, lambda node: _kinked(plane, node, index) - 1.0),
            Test(PlaneKind.FLIP_BORDER, lambda node: _kinked(plane, node, index) + 1.0),
            Test(PlaneKind.JUMP_CLOSES, lambda node: node.gap),
        )
    if isinstance(locus.held, Unknown):
        return ()
    if locus.held == 1.0:
        found = [Test(PlaneKind.CUSP, lambda node: bend(node.orbit, plane.first))]
        if n % 2 == 0:
            found.append(Test(PlaneKind.GENERALISED_FLIP, _halves, ends=True))
        return tuple(found)
    return (Test(PlaneKind.GENERALISED_FLIP, lambda node: cubic(node.orbit, plane.first)),)


def _kinked(plane: Plane, node: Node, index: int) -> float:
    """The multiplier beyond a border at which the map is continuous; nan at others."""
    return node.beyond(index) if node.kind(plane.first) is BorderKind.KINK else math.nan


def _halves(node: Node) -> float:
    """Distance of two points of a cycle that come together where its period halves."""
    x = node.orbit.x
    return float(x[len(x) // 2] - x[0])


def bend(orbit: Orbit, settings: Settings) -> float:
    """Second derivative of the iterate in the first point of a cycle.

    A central difference of exact slopes: its relative error is the square of
    ``Numerics.difference``, some 1e-10.
    """
    row = Multiplier(1.0, settings).row(orbit)[:-1]
    return float(row @ ways(orbit)[:-1, 0])


def cubic(orbit: Orbit, settings: Settings) -> float:
    """The cubic coefficient of a flip: f''^2/2 + f'''/3; positive if the doubled cycle attracts."""
    away = min((depth(image) for image in orbit.images), default=math.inf)
    h = max(THIRD * min(settings.x_scale, max(away, 0.0) * APART / THIRD), settings.nearest)
    low, here, high = (_slope_from(orbit, shift) for shift in (-h, 0.0, h))
    second, third = (high - low) / (2.0 * h), (high - 2.0 * here + low) / (h * h)
    return 0.5 * second * second + third / 3.0


def _slope_from(orbit: Orbit, shift: float) -> float:
    """Slope of the iterate, under the pieces of a cycle, at a distance from its first point."""
    x, slope = float(orbit.x[0]) + shift, 1.0
    for image in orbit.images:
        there = image.piece.at(x, orbit.p)
        x, slope = there.value, slope * there.slope
    return slope


def code_of(plane: Plane, locus: Locus, node: Node) -> tuple[PointKind, str]:
    """The code of a place over one parameter, and what it leaves open; see `collision`.

    A fixed point inside a border lives where the limit there lies on one side of the diagonal, and
    a jump where the limits lie on different sides: if that is on one side of the parameter,
    branches fold. Where the map is continuous they do if the multiplier passes through +1.
    """
    if isinstance(locus.held, Unknown):
        return PointKind.EP, ""
    if locus.border is None or node.border is None:
        return (PointKind.LP if locus.held == 1.0 else PointKind.PD), ""
    inside, kind = node.inside, node.kind(plane.first)
    if kind is BorderKind.LOST:
        return PointKind.BC, ""
    if kind is BorderKind.JUMP:
        if math.isnan(node.gap):
            return PointKind.BC, ""
        fold = math.copysign(1.0, 1.0 - inside) * node.border.side * node.gap > 0.0
        code = PointKind.FF if fold and abs(inside) > 1.0 else PointKind.BC
        return code, "fold" if fold else "persistence"
    beyond = node.beyond(locus.border.index)
    if kind is BorderKind.SMOOTH or math.isnan(beyond):
        return PointKind.BC, "word change"
    fold = (1.0 - inside) * (1.0 - beyond) < 0.0
    return PointKind.BC, "fold" if fold else "persistence"


def margins_along(plane: Plane, node: Node, index: int) -> tuple[Floats, Floats]:
    """Margins (m,) of a point, and their rates along the curve per unit of its scaled length."""
    scale = plane.scales(len(node.place))
    move = (node.tangent * scale)[[index, -2, -1]]
    return node.orbit.images[index].margins, node.place.gradients(index) @ move


def is_tiny(plane: Plane, place: Place, index: int, code: int) -> bool:
    """Whether a margin vanishes up to rounding."""
    gradient = place.gradient(index, code) * plane.scales(1)
    size = float(np.linalg.norm(gradient))
    return abs(place.orbit.images[index].margin(code)) <= plane.first.same * size


def is_inside(plane: Plane, locus: Locus, place: Place, ignored: Margin | None = None) -> bool:
    """Whether no margin is negative but those that vanish along the curve or are ignored."""
    return not any(
        value < 0.0
        and Margin(i, code) not in (locus.border, ignored)
        and not is_tiny(plane, place, i, code)
        for i, image in enumerate(place.orbit.images)
        for value, code in zip(image.margins.tolist(), image.causes.tolist(), strict=True)
    )
