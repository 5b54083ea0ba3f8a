"""Conditions of special points over two parameters, and the test functions along their curves."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pwmap.diagrams.diagram import PointKind
from pwmap.plane.kinds import PlaneKind
from woodpecker.base.arrays import Floats
from woodpecker.base.settings import Settings
from woodpecker.engine.curves import CurveSettings, SolutionCurve, Stop, TestFunction
from woodpecker.engine.ends import rounding_of_multipliers
from woodpecker.engine.line import LineMap
from woodpecker.engine.maps import INFINITE_SLOPE
from woodpecker.engine.newton import MAP_ROUNDING
from woodpecker.engine.orbits import Condition, Multiplier, OnBorder, SpaceOrbit
from woodpecker.maps.pieces import Image
from woodpecker.plane.maps import FamilyPiece, Plane, over_first, pair
from woodpecker.slices.borders import Border, BorderKind, one_sided_limit
from woodpecker.slices.jumps import limit_of
from woodpecker.slices.margins import depth, nearest_code

LONGEST = 2.0**-7  # first step of differences of slopes, as a fraction of the unit of x
LEAST = 2.0**-20  # smallest step of these: MAP_ROUNDING over its square is 4e-3
GROWN = 2.0  # an estimate whose error is this many times the least one is made of rounding
ENOUGH = 2.0**-6  # relative error of a difference that is enough where it does not vanish
HALVINGS = 12  # most halvings of the step: rounding grows with each and soon ends them
# Fraction of the unit of x: where the points that come together as a period halves are closer, the
# second derivative is small like the cube of their distance, and no sign of a cusp.
HALF = 2.0**-10
SHORT = 1e-10  # least step of curves: beside the end of a root shorter ones come no closer to it
# Fraction of the distance from the nearest border that bounds the step of differences: beside that
# border slopes may be those of a root.
APART = 2.0**-5
GRAZED = 2.0**-33  # scaled: distance from a border at which the factor of a square root is measured
NO_ROOT = 2e-7  # a factor that is no larger is that of a smooth piece, or of a cube root of slopes
ROOT_ERROR = 8.0 * GRAZED  # of the factor, from the term h^(3/2)
PARALLEL = 1e-3  # sine of the angle below which two margins belong to the same border


def multiplier_inside(orbit: SpaceOrbit) -> float:
    """The multiplier of a cycle; nan at the end of a root, where it is infinite."""
    steep = any(abs(image.jacobian[0, 0]) >= INFINITE_SLOPE for image in orbit.images)
    return math.nan if steep else float(orbit.monodromy[0, 0])


def multipliers_at_border(orbit: SpaceOrbit, on: OnBorder, border: Border) -> tuple[float, float]:
    """Multipliers of a cycle on a border, with the pieces inside and beyond; infinite at a root."""
    others = (image.jacobian[0, 0] for k, image in enumerate(orbit.images) if k != on.image)
    rest = math.prod(map(float, others))
    return border.inner.slope * rest, border.outer.slope * rest


def finite(value: float) -> float:
    """The same number; nan if it is infinite."""
    return value if math.isfinite(value) else math.nan


def border_of(plane: Plane, orbit: SpaceOrbit, on: OnBorder) -> tuple[Border, float]:
    """The border on which a cycle lies, and the gap of P_n at x_0: its limit beyond less x_0.

    The gap is nan if there is no limit beyond. Results are cached by cycle in ``plane.known``.
    """
    known: dict[tuple[SpaceOrbit, OnBorder], tuple[Border, float]] = plane.known
    if (orbit, on) not in known:
        x, values = orbit.x[on.image], pair(orbit.p)
        image, map_ = over_first(orbit.images[on.image]), plane.family.over(0, values)
        line = LineMap(map_, *plane.scale[:2])
        outer = line.beside(x, orbit.p[:1], -image.gradient(on.code))
        border = border_between(plane, orbit, on, over_first(outer))
        at = border.x, values[0]
        inner = one_sided_limit(border.inner, *at, -border.side, plane.first)
        border = replace(
            border, inner=inner, outer=one_sided_limit(border.outer, *at, border.side, plane.first)
        )
        left = len(orbit.x) - 1 - on.image
        limit = limit_of(map_, border.x, border.outer, left, values[0])
        known[orbit, on] = border, limit.value - float(orbit.x[0, 0])
    return known[orbit, on]


def border_between(plane: Plane, orbit: SpaceOrbit, on: OnBorder, outer: Image) -> Border:
    """The border on which a cycle lies, of the map over the first parameter, with image beyond."""
    x, map_ = orbit.x[on.image], plane.family.over(0, pair(orbit.p))
    inner, outer = (
        each._replace(piece=plane.family.carried(each.piece, map_))
        for each in (over_first(orbit.images[on.image]), outer)
    )
    side = inner.onward(on.code)
    return Border(
        float(x[0]), float(orbit.p[0]), inner, on.code, side, outer, nearest_code(outer, -side)
    )


def condition_of(curve: SolutionCurve) -> Condition:
    """The condition of the cycles along a curve, besides that they close."""
    return curve.problem.conditions[1]


def border_in(curve: SolutionCurve) -> OnBorder | None:
    """The condition of a curve of cycles on a border; None for other curves."""
    condition = condition_of(curve)
    return condition if isinstance(condition, OnBorder) else None


def kind_of(condition: Condition) -> PointKind:
    """The kind of cycles with a condition: LP, PD, BC, or EP at an end of the window."""
    if isinstance(condition, Multiplier):
        return PointKind(condition.kind)
    return PointKind.BC if isinstance(condition, OnBorder) else PointKind.EP


def is_steep(curve: SolutionCurve) -> bool:
    """Whether a curve is one of folds or flips, whose equation changes fast beside a root."""
    return isinstance(condition_of(curve), Multiplier)


def curve_of(plane: Plane, condition: Condition, orbit: SpaceOrbit) -> SolutionCurve:
    """The curve of cycles with a condition over both parameters, with its test functions.

    Margins that vanish all along its border, with parallel gradients there, do not end it.
    """
    one, other = plane.settings
    ignored = frozenset[tuple[int, int]]()
    if isinstance(condition, OnBorder):
        i = condition.image
        image = orbit.images[i]
        unit = units(image.gradients * plane.scale)
        own = unit[image.index_of(condition.code)]
        along = np.linalg.norm(np.cross(unit, own), axis=1) <= PARALLEL
        codes = image.codes[along & image.tied(orbit.x[i], orbit.p)].tolist()
        ignored = frozenset((i, code) for code in (condition.code, *codes))
    shortest = max(one.min_step, SHORT)
    settings = CurveSettings(
        spans=(one.span, other.span), window=(one.window,), min_step=shortest,
        step=max(shortest, one.step), max_step=max(shortest, one.max_step),
        max_turn=one.max_turn, max_samples=one.max_samples,
    )  # fmt: skip
    problem = plane.cycles(0, 1).with_(condition)
    own_tests = tests_of(plane, condition, len(orbit.x))
    return SolutionCurve(plane, problem, settings, ignored, tests=(), own=own_tests)


def units(rows: Floats) -> Floats:
    """Rows (m, 3) divided by their lengths; rows of zeros remain."""
    size = np.linalg.norm(rows, axis=1, keepdims=True)
    return np.asarray(rows / np.where(size > 0.0, size, 1.0))


def tests_of(plane: Plane, condition: Condition, n: int) -> tuple[TestFunction, ...]:
    """The test functions for points of codimension two along a curve of cycles of n points."""
    if isinstance(condition, OnBorder):
        return _tests_on_border(plane, condition)
    settings = plane.first
    kind, found = kind_of(condition), list[TestFunction]()
    if kind is PointKind.PD:
        found.append(_test(PlaneKind.GENERALISED_FLIP, lambda orbit: cubic(orbit, settings).value))
    if kind is PointKind.LP and n % 2:
        found.append(_test(PlaneKind.CUSP, lambda orbit: second_derivative(orbit, settings).value))
    elif kind is PointKind.LP:  # of even period: points come together in pairs where it halves
        least = HALF * settings.x_scale

        def bent(orbit: SpaceOrbit) -> float:
            return (
                second_derivative(orbit, settings).value
                if abs(distance_of_halves(orbit)) > least
                else math.nan
            )

        found += [
            _test(PlaneKind.CUSP, bent),
            _test(PlaneKind.GENERALISED_FLIP, distance_of_halves),
        ]
    return tuple(found)


def _tests_on_border(plane: Plane, condition: OnBorder) -> tuple[TestFunction, ...]:
    settings = plane.first

    def kinked(orbit: SpaceOrbit) -> float:
        border, _ = border_of(plane, orbit, condition)
        kinks = border.kind(settings) is BorderKind.KINK
        return multipliers_at_border(orbit, condition, border)[1] if kinks else math.nan

    def own(orbit: SpaceOrbit) -> float:
        return finite(
            multipliers_at_border(orbit, condition, border_of(plane, orbit, condition)[0])[0]
        )

    def blurred(orbit: SpaceOrbit) -> float:
        outer = abs(border_of(plane, orbit, condition)[0].outer.slope)
        return max(1.0, outer) * rounding_of_multipliers(orbit)

    def inside(orbit: SpaceOrbit) -> float:
        border, _ = border_of(plane, orbit, condition)
        return root_factor(plane, border, border.inner, border.code)

    def beyond(orbit: SpaceOrbit) -> float:
        border, _ = border_of(plane, orbit, condition)
        return root_factor(plane, border, border.outer, border.outer_code)

    def no_root(factor: Callable[[SpaceOrbit], float]) -> Callable[[SpaceOrbit], float]:
        return lambda orbit: 0.0 if abs(factor(orbit)) > NO_ROOT else math.inf

    rounded = rounding_of_multipliers
    return (
        # slopes that merge like a cube root leap by rounding
        _test(PlaneKind.FOLD_BORDER, lambda orbit: own(orbit) - 1.0, rounded, leaps=True),
        _test(PlaneKind.FLIP_BORDER, lambda orbit: own(orbit) + 1.0, rounded, leaps=True),
        _test(PlaneKind.FOLD_BORDER, lambda orbit: kinked(orbit) - 1.0, blurred, leaps=True),
        _test(PlaneKind.FLIP_BORDER, lambda orbit: kinked(orbit) + 1.0, blurred, leaps=True),
        _test(
            PlaneKind.JUMP_CLOSES,
            lambda orbit: border_of(plane, orbit, condition)[1],
            lambda _: settings.jump * settings.x_scale,
            leaps=True,  # it jumps where the orbit of the limit beyond meets another jump
        ),
        _test(PlaneKind.DEGENERATE_GRAZING, inside, no_root(inside)),
        _test(PlaneKind.DEGENERATE_GRAZING, beyond, no_root(beyond), leaps=True),
    )


def _test(
    kind: PlaneKind, value: Callable[[SpaceOrbit], float],
    noise: Callable[[SpaceOrbit], float] = lambda _: 0.0, *, leaps: bool = False,
) -> TestFunction:  # fmt: skip
    return TestFunction(
        Stop.SPECIAL, lambda sample: value(sample.orbit), name=kind, noise=noise, leaps=leaps
    )


def distance_of_halves(orbit: SpaceOrbit) -> float:
    """The distance of the two points of a cycle that come together where its period halves."""
    return float(orbit.x[len(orbit.x) // 2, 0] - orbit.x[0, 0])


class Estimate(NamedTuple):
    """A number, with a bound of its error."""

    value: float
    error: float


def second_derivative(orbit: SpaceOrbit, settings: Settings) -> Estimate:
    """The second derivative of P_n at the first point of a cycle, which vanishes at a cusp."""

    def difference(h: float) -> float:
        return (_slope_from(orbit, h) - _slope_from(orbit, -h)) / (2.0 * h)

    return _limit(difference, 1, orbit, settings)


def cubic(orbit: SpaceOrbit, settings: Settings) -> Estimate:
    """The cubic coefficient f''^2/2 + f'''/3 of a flip; positive if the doubled cycle attracts."""
    here = _slope_from(orbit, 0.0)

    def difference(h: float) -> float:
        low, high = _slope_from(orbit, -h), _slope_from(orbit, h)
        second, third = (high - low) / (2.0 * h), (high - 2.0 * here + low) / (h * h)
        return 0.5 * second * second + third / 3.0

    return _limit(difference, 2, orbit, settings)


def error_of_test(plane: Plane, kind: PlaneKind, curve: SolutionCurve, orbit: SpaceOrbit) -> float:
    """The error of the test function that vanishes at a special point of a kind."""
    if kind is PlaneKind.CUSP:
        return second_derivative(orbit, plane.first).error
    if kind is PlaneKind.GENERALISED_FLIP:
        return cubic(orbit, plane.first).error
    if kind is PlaneKind.JUMP_CLOSES:
        return MAP_ROUNDING * plane.first.x_scale
    if kind is PlaneKind.DEGENERATE_GRAZING:
        return ROOT_ERROR
    on = border_in(curve)
    if on is None:
        return MAP_ROUNDING
    value = 1.0 if kind is PlaneKind.FOLD_BORDER else -1.0
    return _error_of_multiplier(plane, orbit, border_of(plane, orbit, on)[0], on, value)


def _error_of_multiplier(
    plane: Plane, orbit: SpaceOrbit, border: Border, on: OnBorder, value: float
) -> float:
    """The error of the multiplier, on one side of a border, that is close to a value."""
    # Slopes that go like a root are known as well as they are the same right beside the border.
    settings = plane.first
    sides = (border.inner, -border.side), (border.outer, border.side)
    multiplier, (image, way) = min(
        zip(multipliers_at_border(orbit, on, border), sides, strict=True),
        key=lambda each: abs(each[0] - value),
    )
    beside = image.piece.at(border.x + way * settings.nearest * settings.x_scale, border.p)
    return max(MAP_ROUNDING, abs(multiplier) * abs(beside.slope / image.slope - 1.0))


def root_factor(plane: Plane, border: Border, image: Image, code: int) -> float:
    """The factor c of slopes c / (2 sqrt(h)) at a distance h from the border of a piece, scaled."""
    # Away from the border there is also something smooth: they change by c / (4 sqrt(h)) to 4 h.
    if code < 0:
        return math.nan
    lengths = np.array(plane.scale[:2])
    way = image.gradient(code) * lengths
    way *= lengths / np.linalg.norm(way)
    here = np.array([border.x, border.p])
    near, far = (
        image.piece.at(*(here + part * GRAZED * way).tolist()).slope for part in (1.0, 4.0)
    )
    return 4.0 * math.sqrt(GRAZED) * (near - far)


def _limit(
    difference: Callable[[float], float], power: int, orbit: SpaceOrbit, settings: Settings
) -> Estimate:
    """The limit of differences of slopes as their step h goes to 0, by Richardson extrapolation."""
    # They are even in h, with rounding MAP_ROUNDING / h^power. The step is halved until the error
    # grows, or is a small fraction of the value. It starts smaller beside a border; the limit is
    # nan if that is so close that only rounding would be left.
    away = min((depth(over_first(image)) for image in orbit.images), default=math.inf)
    h, row = min(LONGEST * settings.x_scale, away * APART), list[float]()
    best = Estimate(math.nan, math.inf)
    for _ in range(HALVINGS):
        if h < LEAST * settings.x_scale:
            break
        before, row = row, [difference(h)]
        for k, coarse in enumerate(before, start=1):
            row.append(row[-1] + (row[-1] - coarse) / (4.0**k - 1.0))
        if before:
            error = max(abs(row[-1] - row[-2]), abs(row[-1] - before[-1])) + MAP_ROUNDING / h**power
            if error > GROWN * best.error:
                break
            best = min(best, Estimate(row[-1], error), key=lambda each: each.error)
            if error < ENOUGH * abs(row[-1]):
                break
        h *= 0.5
    return best


def _slope_from(orbit: SpaceOrbit, shift: float) -> float:
    """The slope of P_n on the pieces of a cycle, at a distance from its first point."""
    x, slope, values = float(orbit.x[0, 0]) + shift, 1.0, pair(orbit.p)
    for image in orbit.images:
        assert isinstance(image.piece, FamilyPiece)
        there = image.piece.over_first(x, values)
        x, slope = there.value, slope * there.slope
    return slope


def kind_and_note(plane: Plane, curve: SolutionCurve, orbit: SpaceOrbit) -> tuple[PointKind, str]:
    """The code and the note of a cycle of a curve as a special point over one parameter.

    At a jump branches fold if the fixed point and the crossing exist on the same side of the
    parameter. Where the map is continuous they fold if +1 lies between the two multipliers.
    """
    on = border_in(curve)
    if on is None:
        return kind_of(condition_of(curve)), ""
    border, gap = border_of(plane, orbit, on)
    kind, (own, other) = border.kind(plane.first), multipliers_at_border(orbit, on, border)
    if kind is BorderKind.LOST or (kind is BorderKind.JUMP and math.isnan(gap)):
        return PointKind.BC, ""
    if kind is BorderKind.JUMP:
        # Let the limit inside of P_n at x_0 lie mu above the diagonal. Then the fixed point exists
        # if side (1 - own) mu < 0, and the crossing if gap mu < 0.
        way_there = math.prod(float(each.jacobian[0, 0]) for each in orbit.images[: on.image])
        side = math.copysign(1.0, way_there) * border.side
        # Behind a flat piece P_n has no jump at x_0: the fixed point ends alone.
        fold = way_there == 0.0 or math.copysign(1.0, 1.0 - own) * side * gap > 0.0
    elif kind is BorderKind.SMOOTH or math.isnan(other):
        return PointKind.BC, "word change"
    else:
        fold = (1.0 - own) * (1.0 - other) < 0.0
    folds_flip = kind is BorderKind.JUMP and fold and abs(own) > 1.0
    return PointKind.FF if folds_flip else PointKind.BC, "fold" if fold else "persistence"
