"""What special points obey over two parameters, and what is looked at along their curves."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pwmap.diagrams.diagram import PointKind
from pwmap.plane.kinds import PlaneKind
from woodpecker.base.arrays import Floats
from woodpecker.base.settings import Settings
from woodpecker.engine.curves import Sample, SolutionCurve, Stop, TestFunction
from woodpecker.engine.line import LineMap
from woodpecker.engine.orbits import Condition, Held, Multiplier, OnBorder, Orbit
from woodpecker.maps.pieces import Image
from woodpecker.plane.maps import FamilyPiece, Plane, over_first, pair
from woodpecker.slices.borders import Border, BorderKind
from woodpecker.slices.jumps import limit_of
from woodpecker.slices.margins import depth, nearest_code

THIRD = 2.0**-10  # part of the unit of x over which a second difference of slopes is taken: its
# error is the square, and rounding over the square is 1e-10
SECOND = 2.0**-17  # the same of a first difference: its error is the square, rounding over it 1e-11
LEAST = 2.0**-20  # differences over less are made of rounding: over its square that is 1e-3
SHORT = 1e-10  # of steps: where a piece ends in a root shorter ones come no closer to its end
STEEP_SHORT = 1e-8  # of steps of folds and flips: beside a border rounding decides on shorter ones
STEEP = 1e10  # a slope above this is that of a root right at its border, as it is rounded
APART = 2.0**-5  # and part of the distance from the nearest border at most, where slopes may be
# those of a root
ROOTED = 1e3  # slopes beyond a border that are larger may be those of a root
PARALLEL = 1e-3  # sine of an angle between gradients of margins of one border


def inside(orbit: Orbit) -> float:
    """The multiplier of a cycle; nan where it ends in a root, and is infinite."""
    steep = any(abs(image.jacobian[0, 0]) >= STEEP for image in orbit.images)
    return math.nan if steep else float(orbit.monodromy[0, 0])


@dataclass(frozen=True, slots=True, eq=False)
class BorderMet:
    """The border on which a cycle lies.

    Attributes
    ----------
    border
        Over the first parameter.
    kind
        What the map does there.
    gap
        The limit of P_n beyond it, less that inside; nan if it has none.
    beyond
        The multiplier with the piece beyond in place of the one inside.
    """

    border: Border
    kind: BorderKind
    gap: float
    beyond: float


def border_of(plane: Plane, orbit: Orbit, on: OnBorder) -> BorderMet:
    """What lies where a point of a cycle is on a border; looked at once for each cycle."""
    known: dict[tuple[Orbit, OnBorder], BorderMet] = plane.known
    if (orbit, on) not in known:
        known[orbit, on] = _border_of(plane, orbit, on)
    return known[orbit, on]


def _border_of(plane: Plane, orbit: Orbit, on: OnBorder) -> BorderMet:
    i, values = on.image, pair(orbit.p)
    image, x, map_ = over_first(orbit.images[i]), orbit.x[i], plane.over(values)
    side = image.onward(on.code)
    line = LineMap(map_, *plane.scale[:2])
    outer = _rooted(over_first(line.beside(x, orbit.p[:1], -image.gradient(on.code))), x, orbit)
    border = Border(float(x[0]), values[0], image, on.code, side, outer, nearest_code(outer, -side))
    limit = limit_of(map_, border.x, outer, len(orbit.x) - 1, values[0])
    rest = [float(each.jacobian[0, 0]) for k, each in enumerate(orbit.images) if k != i]
    return BorderMet(
        border, border.kind(plane.first), limit.value - float(x[0]), outer.slope * math.prod(rest)
    )


def _rooted(outer: Image, x: Floats, orbit: Orbit) -> Image:
    """An image beyond a border, with an infinite slope if its piece ends in a root there."""
    if not abs(outer.slope) > ROOTED:
        return outer
    there = outer.piece.at(float(x[0]), float(orbit.p[0]))
    slope = math.copysign(math.inf, outer.slope) if there.reason else there.slope
    return outer._replace(slope=slope)


def border_in(curve: SolutionCurve) -> OnBorder | None:
    """The border along which a curve leads, if it does."""
    condition = curve.problem.conditions[1]
    return condition if isinstance(condition, OnBorder) else None


def is_steep(curve: SolutionCurve) -> bool:
    """Whether it is one of folds or flips: beside a root their equation changes fast."""
    return isinstance(curve.problem.conditions[1], Multiplier)


def curve_of(plane: Plane, condition: Condition, orbit: Orbit) -> SolutionCurve:
    """The curve of cycles that obey a condition, with what is looked at along it.

    Along a border margins vanish that say the same: their gradients are parallel there.
    """
    curve = plane.curve(condition)
    ignored = frozenset[tuple[int, int]]()
    if isinstance(condition, OnBorder):
        i = condition.image
        image = orbit.images[i]
        unit = units(image.gradients * plane.scale)
        own = unit[image.place(condition.code)]
        along = np.linalg.norm(np.cross(unit, own), axis=1) <= PARALLEL
        codes = image.codes[along & image.tied(orbit.x[i], orbit.p)].tolist()
        ignored = frozenset((i, code) for code in (condition.code, *codes))
    steep = isinstance(condition, Multiplier)
    shortest = max(curve.settings.min_step, STEEP_SHORT if steep else SHORT)
    settings = replace(
        curve.settings, min_step=shortest, step=max(shortest, curve.settings.step),
        max_step=max(shortest, curve.settings.max_step),
    )  # fmt: skip
    return replace(
        curve, ignored=ignored, own=tests_of(plane, condition, len(orbit.x)),
        settings=settings,
    )  # fmt: skip


def units(rows: Floats) -> Floats:
    """Vectors (m, 3) of length 1."""
    size = np.linalg.norm(rows, axis=1, keepdims=True)
    return np.asarray(rows / np.where(size > 0.0, size, 1.0))


def tests_of(plane: Plane, condition: Condition, n: int) -> tuple[TestFunction, ...]:
    """What may happen along a curve of cycles of n points."""
    settings = plane.first

    def test(kind: PlaneKind, value: Callable[[Orbit], float], noise: float = 0.0) -> TestFunction:
        def of_sample(sample: Sample) -> float:
            return value(sample.orbit)

        return TestFunction(Stop.SPECIAL, of_sample, name=kind, noise=noise)

    if isinstance(condition, OnBorder):

        def kinked(orbit: Orbit) -> float:
            met = border_of(plane, orbit, condition)
            return met.beyond if met.kind is BorderKind.KINK else math.nan

        def gap(orbit: Orbit) -> float:
            return border_of(plane, orbit, condition).gap

        return (
            test(PlaneKind.FOLD_BORDER, lambda orbit: inside(orbit) - 1.0),
            test(PlaneKind.FLIP_BORDER, lambda orbit: inside(orbit) + 1.0),
            test(PlaneKind.FOLD_BORDER, lambda orbit: kinked(orbit) - 1.0),
            test(PlaneKind.FLIP_BORDER, lambda orbit: kinked(orbit) + 1.0),
            test(PlaneKind.JUMP_CLOSES, gap, settings.jump * settings.x_scale),
        )
    if isinstance(condition, Held):
        return ()
    assert isinstance(condition, Multiplier)
    if condition.kind == PointKind.PD:
        return (test(PlaneKind.GENERALISED_FLIP, lambda orbit: cubic(orbit, settings)),)
    found = [test(PlaneKind.CUSP, lambda orbit: bend(orbit, settings))]
    if n % 2 == 0:
        found.append(test(PlaneKind.GENERALISED_FLIP, _halves))
    return tuple(found)


def _halves(orbit: Orbit) -> float:
    """Distance of two points of a cycle that come together where its period halves."""
    x = orbit.x[:, 0]
    return float(x[len(x) // 2] - x[0])


def bend(orbit: Orbit, settings: Settings) -> float:
    """Second derivative of the iterate in the first point of a cycle.

    A central difference of exact slopes: its relative error is the square of ``SECOND``.
    """
    h = _distance(orbit, SECOND, settings)
    return (_slope_from(orbit, h) - _slope_from(orbit, -h)) / (2.0 * h)


def cubic(orbit: Orbit, settings: Settings) -> float:
    """The cubic coefficient of a flip: f''^2/2 + f'''/3; positive if the doubled cycle attracts."""
    h = _distance(orbit, THIRD, settings)
    low, here, high = (_slope_from(orbit, shift) for shift in (-h, 0.0, h))
    second, third = (high - low) / (2.0 * h), (high - 2.0 * here + low) / (h * h)
    return 0.5 * second * second + third / 3.0


def _distance(orbit: Orbit, part: float, settings: Settings) -> float:
    """Over which slopes are compared: a part of the unit of x, less beside a border.

    It is nan where that is so near that rounding decides.
    """
    away = min((depth(over_first(image)) for image in orbit.images), default=math.inf)
    h = min(part * settings.x_scale, away * APART)
    return h if h >= LEAST * settings.x_scale else math.nan


def _slope_from(orbit: Orbit, shift: float) -> float:
    """Slope of the iterate, under the pieces of a cycle, at a distance from its first point."""
    x, slope, values = float(orbit.x[0, 0]) + shift, 1.0, pair(orbit.p)
    for image in orbit.images:
        assert isinstance(image.piece, FamilyPiece)
        there = image.piece.over_first(x, values)
        x, slope = there.value, slope * there.slope
    return slope


def code_of(plane: Plane, curve: SolutionCurve, orbit: Orbit) -> tuple[PointKind, str]:
    """The code of a cycle over one parameter, and what it leaves open; see `collision`.

    A fixed point inside a border lives where the limit there lies on one side of the diagonal, and
    a jump where the limits lie on different sides: if that is on one side of the parameter,
    branches fold. Where the map is continuous they do if the multiplier passes through +1.
    """
    condition = curve.problem.conditions[1]
    if isinstance(condition, Multiplier):
        return PointKind(condition.kind), ""
    if not isinstance(condition, OnBorder):
        return PointKind.EP, ""
    own, met = inside(orbit), border_of(plane, orbit, condition)
    if met.kind is BorderKind.LOST:
        return PointKind.BC, ""
    if met.kind is BorderKind.JUMP:
        if math.isnan(met.gap):
            return PointKind.BC, ""
        fold = math.copysign(1.0, 1.0 - own) * met.border.side * met.gap > 0.0
        code = PointKind.FF if fold and abs(own) > 1.0 else PointKind.BC
        return code, "fold" if fold else "persistence"
    if met.kind is BorderKind.SMOOTH or math.isnan(met.beyond):
        return PointKind.BC, "word change"
    fold = (1.0 - own) * (1.0 - met.beyond) < 0.0
    return PointKind.BC, "fold" if fold else "persistence"
