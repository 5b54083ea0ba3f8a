"""How a curve goes on where one of its arcs ends, as where a cycle meets one more border."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from pwmap.diagrams.diagram import PointKind
from pwmap.plane.kinds import PlaneKind
from woodpecker.base.arrays import Floats
from woodpecker.engine.curves import Arc, Sample, SolutionCurve, Stop, TestFunction
from woodpecker.engine.ends import LOCATED
from woodpecker.engine.following import to_end
from woodpecker.engine.germs import SAME, is_inside
from woodpecker.engine.maps import ACCUMULATE, SpaceImage
from woodpecker.engine.newton import MERGED, Problem, Solution, across, solve, tangent
from woodpecker.engine.orbits import Condition, Multiplier, OnBorder, SpaceOrbit, placed_at
from woodpecker.plane.maps import Plane, over_first, pair
from woodpecker.plane.nodes import (
    PARALLEL,
    border_between,
    border_in,
    condition_of,
    curve_of,
    is_steep,
    kind_of,
    units,
)
from woodpecker.slices.borders import BorderKind

BESIDE = 2.0**-24  # scaled: distance from a border at which a curve goes on
CONTACT = 1e-6  # scaled: farthest border at which steps of folds and flips become too short
# Scaled: farthest that the end of folds or flips may lie from a special point that they end in.
NEAR = 1e-2
LEAST_DISTANCE = 1e-11  # scaled: closer to a border slopes are made of rounding
STUCK = Stop.SHORT, Stop.OTHER_PIECE, Stop.MANY  # at a contact: rounding decides which
NO_CURVE, SHORTER = "no curve beyond", "beyond, it goes round a shorter cycle"
SPAN, CLOSED = "end of the span", "the curve closes"
MEETINGS = {
    PointKind.LP: PlaneKind.FOLD_BORDER, PointKind.PD: PlaneKind.FLIP_BORDER,
    PointKind.BC: PlaneKind.TWO_BORDERS, PointKind.EP: PlaneKind.END,
}  # fmt: skip
# The special point, of a curve of half the period, in which folds and cycles on a border end.
HALVING = {PointKind.LP: PlaneKind.GENERALISED_FLIP, PointKind.BC: PlaneKind.FLIP_BORDER}
Along = tuple[SolutionCurve, Sample]
Passed = tuple[PlaneKind | None, str, Along | None]
"""The kind of the end of an arc, None if only words change; why; and where the curve goes on."""


def end_of_arc(plane: Plane, arc: Arc) -> Passed:
    """The kind of the end of an arc, its cause, and where its curve goes on; None if it ends."""
    if arc.test is not None and arc.stop is Stop.SPECIAL:
        special = PlaneKind(arc.test.name)
        ends = ends_at_special(arc) or arc.beyond is None
        return special, "", None if ends or arc.beyond is None else (arc.curve, arc.beyond)
    mirrored = _beyond_contact(plane, arc) if arc.stop in STUCK else None
    if mirrored is not None:
        return mirrored
    if arc.border is None:
        return PlaneKind.END, _why(plane, arc), None
    i, code = arc.border
    cause, own = arc.samples[-1].orbit.images[i].piece.cause(code), border_in(arc.curve)
    round_corner = own is not None and own.image == i
    kind, why, on = (_round_corner if round_corner else _through)(plane, arc, i, code)
    return kind, f"{cause}: {why}" if on is None and why else cause, on


def _why(plane: Plane, arc: Arc) -> str:
    """Why a curve ends without meeting a border, or is given up."""
    if arc.stop is Stop.SPAN:
        values, ways = pair(arc.samples[-1].orbit.p), arc.samples[-1].tangent[-2:].tolist()
        every = zip(plane.family.names, values, ways, plane.settings, strict=True)
        outward = {  # the curve may also run along an end of the other parameter's span
            name: way if value == each.span[1] else -way
            for name, value, way, each in every
            if value in each.span
        }
        return f"{SPAN} of {max(outward, key=outward.__getitem__)}"
    if arc.stop not in (Stop.SHORT, Stop.OTHER_PIECE):
        return CLOSED if arc.stop is Stop.CLOSED else str(arc.stop.value)
    orbit = arc.samples[-1].orbit
    away, i, code = _nearest(arc.curve.problem, orbit)
    beside = f" where {orbit.images[i].piece.cause(code)}" if away <= CONTACT else ""
    return f"{Stop.SHORT.value}{beside}"


def _through(plane: Plane, arc: Arc, i: int, code: int) -> Passed:
    """How a curve goes on where a margin vanishes at a point that lies on no border so far."""
    # It ends at a jump; folds and flips also end where slopes differ.
    curve, end = arc.curve, arc.samples[-1]
    meeting = MEETINGS[kind_of(condition_of(curve))]
    outer = _beyond(plane, end.orbit, i, code)
    if outer.reason:
        return _lost(outer, meeting)
    kind = border_between(plane, end.orbit, OnBorder(i, code), over_first(outer)).kind(plane.first)
    if kind is BorderKind.JUMP or (is_steep(curve) and kind is not BorderKind.SMOOTH):
        return meeting, kind.value, None
    smooth = kind is BorderKind.SMOOTH or border_in(curve) is None
    codes = outer.codes[outer.tied(end.orbit.x[i], end.orbit.p)].tolist()
    there = end.orbit.with_image(i, outer)
    return _onward(curve, there, arc, i, codes, None if smooth else meeting)


def _round_corner(plane: Plane, arc: Arc, i: int, code: int) -> Passed:
    """How a curve on a border goes on where the point on it meets a second border."""
    # The piece beyond the second border lies where the first margin is positive and the second one
    # negative; the curve goes on along a border of that piece.
    orbit, own, meeting = arc.samples[-1].orbit, border_in(arc.curve), PlaneKind.TWO_BORDERS
    assert own is not None
    inner, x, p = orbit.images[i], orbit.x[i], orbit.p
    first, second = (_normal(plane, inner, each) for each in (own.code, code))
    way = np.linalg.pinv(np.array([first, second])) @ np.array([1.0, -1.0])
    outer = plane.beside(x, p, way * plane.scale)
    if outer.reason:
        return _lost(outer, meeting)
    if not arc.curve.problem.same(inner.value, outer.value, SAME):
        return meeting, BorderKind.JUMP.value, None
    ahead = {each: _normal(plane, outer, each) for each in outer.codes[outer.tied(x, p)].tolist()}
    shared = min(ahead, key=lambda each: float(ahead[each] @ second), default=-1)
    rest = [each for each in ahead if each != shared]
    following = max(rest, key=lambda each: float(ahead[each] @ first), default=-1)
    if following < 0:
        return meeting, "the border ends", None
    there = orbit.with_image(i, outer)
    curve = curve_of(plane, OnBorder(i, following), there)
    parallel = float(np.linalg.norm(np.cross(ahead[following], first))) <= PARALLEL
    between = border_between(plane, orbit, own, over_first(outer))
    smooth = parallel and between.kind(plane.first) is BorderKind.SMOOTH
    return _onward(curve, there, arc, i, [shared], None if smooth else meeting)


def _beyond(plane: Plane, orbit: SpaceOrbit, i: int, code: int) -> SpaceImage:
    """The image of point i of a cycle under the piece beyond the border of a margin."""
    image = orbit.images[i]
    return plane.beside(orbit.x[i], orbit.p, -image.gradients[image.index_of(code)])


def _normal(plane: Plane, image: SpaceImage, code: int) -> Floats:
    """The unit vector, in scaled unknowns, along which a margin grows fastest."""
    return np.asarray(units(image.gradients[[image.index_of(code)]] * plane.scale)[0])


def _lost(outer: SpaceImage, meeting: PlaneKind) -> Passed:
    """The end of a curve beyond which the map has no image, or its borders accumulate."""
    return meeting if outer.reason == ACCUMULATE else PlaneKind.DOMAIN, outer.reason, None


# --- Where folds and flips end in a special point of another curve --------------------------------


def moved_to_special(plane: Plane, arc: Arc) -> Arc:
    """The arc; with its end moved to a special point that its own equations do not locate."""
    found = located_elsewhere(plane, arc)
    if found is None:
        return _at_border(arc) if ends_at_special(arc) else arc
    samples, end, orbit = reliable_samples(arc), arc.samples[-1], found.samples[-1].orbit
    there = placed_at(end.orbit, np.resize(orbit.x, end.orbit.x.shape), orbit.p)
    every = orbit.images * (len(there.x) // len(orbit.x))
    if [each.piece.key for each in every] == [each.piece.key for each in there.images]:
        there = replace(there, images=every)  # limits, where its own piece may have no value
    if not arc.curve.problem.same(there.x, end.orbit.x, NEAR):
        return arc
    return replace(
        arc, samples=(*samples[:-1], replace(end, orbit=there)), stop=Stop.SPECIAL,
        test=found.test, border=None,
    )  # fmt: skip


def _at_border(arc: Arc) -> Arc:
    """An arc that ends on a border, if it does, and not in a special point of another curve."""
    # Where two points of a cycle merge right at a kink, a fold meets the border and no flip.
    end = arc.samples[-1].orbit
    for i, image in enumerate(end.images):
        for code in image.codes[image.tied(end.x[i], end.p)].tolist():
            return replace(arc, stop=Stop.BORDER, border=(i, code), test=None)
    return arc


def _merging(arc: Arc) -> bool:
    """Whether an arc of folds or of cycles on a border ends where their period halves."""
    # Close to such an end the equations are nearly singular, and steps may become too short.
    x, problem = arc.samples[-1].orbit.x, arc.curve.problem
    if len(x) % 2 or kind_of(condition_of(arc.curve)) not in HALVING:
        return False
    half = len(x) // 2
    return problem.same(x[:half], x[half:], NEAR if arc.stop in STUCK else MERGED)


def ends_at_special(arc: Arc) -> bool:
    """Whether an arc ends in a special point of another curve."""
    name, kind = "" if arc.test is None else arc.test.name, kind_of(condition_of(arc.curve))
    touches = is_steep(arc.curve) and name in (PlaneKind.DEGENERATE_GRAZING, MEETINGS[kind])
    return touches or (name == HALVING.get(kind) and _merging(arc))


def located_elsewhere(plane: Plane, arc: Arc) -> Arc | None:
    """An arc of another curve, up to the special point in which an arc ends; or None."""
    # Where their period halves folds end on the curve of flips, and cycles on a border on that of
    # the border, with half the period; folds and flips end on the curve of a border that they
    # touch, at a degenerate grazing or, where slopes change like a root, with their multiplier.
    orbit = arc.samples[-1].orbit
    if _merging(arc):
        half, own = len(orbit.x) // 2, border_in(arc.curve)
        condition: Condition = Multiplier(PointKind.PD.value, plane.scale)
        first = 0
        if own is not None:
            first, i = divmod(own.image, half)
            condition = OnBorder(i, own.code)
        part = slice(first * half, (first + 1) * half)
        shorter = replace(orbit, x=orbit.x[part], images=orbit.images[part])
        kind = HALVING[kind_of(condition_of(arc.curve))]
        found = _special_near(plane, condition, shorter, kind)
        if found is not None:
            return found
    if not is_steep(arc.curve) or not (arc.stop in STUCK or ends_at_special(arc)):
        return None
    away, i, code = _nearest(arc.curve.problem, orbit)
    if away > CONTACT:
        return None
    outer = _beyond(plane, orbit, i, code)  # beyond the border slopes may be finite
    inside, grazing = (OnBorder(i, code), orbit), PlaneKind.DEGENERATE_GRAZING
    wanted = [((OnBorder(i, each), orbit.with_image(i, outer)), grazing)
              for each in outer.codes[outer.tied(orbit.x[i], orbit.p)].tolist()[:1]]  # fmt: skip
    wanted.append((inside, grazing))
    between = border_between(plane, orbit, inside[0], over_first(outer))
    if outer.reason or between.kind(plane.first) is not BorderKind.SMOOTH:
        wanted.append((inside, MEETINGS[kind_of(condition_of(arc.curve))]))
    every = (_special_near(plane, *cycle, kind) for cycle, kind in wanted)
    return next((found for found in every if found is not None), None)


def _special_near(
    plane: Plane, condition: Condition, orbit: SpaceOrbit, kind: PlaneKind
) -> Arc | None:
    """An arc of the cycles with a condition, up to a special point near an orbit; None without."""
    curve = curve_of(plane, condition, orbit)
    ahead = across(curve.problem, orbit, curve.start(orbit).tangent, 0.0)
    found = solve(curve.problem.with_(ahead), orbit)
    start = curve.start(found.orbit)
    if not (found.converged and np.isfinite(start.tangent).all()):
        return None

    def at(distance: float) -> Sample | None:
        way = start if distance > 0.0 else start.turned
        return curve.advance(way, abs(distance)) if abs(distance) > LOCATED else start

    def value(distance: float, test: TestFunction) -> float:
        sample = at(distance)
        return math.nan if sample is None else test.value(sample)

    sides = [sample for sample in (at(-NEAR), at(NEAR)) if sample is not None]
    for test in curve.own if len(sides) == 2 else ():
        noise = max(test.noise(sample.orbit) for sample in sides)
        ends = [test.value(sample) for sample in sides]
        if test.name == kind and ends[0] * ends[1] < 0.0 and max(map(abs, ends)) > noise:
            with suppress(ValueError):  # a value between is nan
                sample = at(brentq(value, -NEAR, NEAR, (test,), xtol=LOCATED))
                return Arc((sample or start,), Stop.SPECIAL, curve, test=test)
    return None


# --- Beside a contact -----------------------------------------------------------------------------


def reliable_samples(arc: Arc) -> Sequence[Sample]:
    """The samples of an arc, without last ones so close to a border that they are rounding."""
    count = len(arc.samples)
    if is_steep(arc.curve) and arc.stop in STUCK:
        while (
            count > 1
            and _nearest(arc.curve.problem, arc.samples[count - 1].orbit)[0] < LEAST_DISTANCE
        ):
            count -= 1
    return arc.samples[:count]


def _beyond_contact(plane: Plane, arc: Arc) -> Passed | None:
    """How a curve of folds or flips goes on that is stuck beside a border; None if it does not."""
    # Where slopes change like the cube root of the distance from a border, the curve touches it
    # with a contact of third order, and leaves it likewise on the piece beyond. There it is sought
    # at the distances from the contact of the samples on this side, the nearest first.
    curve, last = arc.curve, arc.samples[-1]
    away, i, code = _nearest(curve.problem, last.orbit)
    if not is_steep(curve) or away > CONTACT:
        return None
    own, problem = last.orbit.images[i].piece, plane.cycles(0, 1).with_(OnBorder(i, code))
    there = solve(problem.with_(across(problem, last.orbit, last.tangent, 0.0)), last.orbit)
    if not there.converged:
        return None
    touching = there.orbit
    outer = _beyond(plane, touching, i, code)
    tied = [] if outer.reason else outer.codes[outer.tied(touching.x[i], touching.p)].tolist()
    between = border_between(plane, touching, OnBorder(i, code), over_first(outer))
    if not tied or between.kind(plane.first) is BorderKind.JUMP:
        return None
    beyond, border = touching.with_image(i, outer), OnBorder(i, tied[0])
    problem = plane.cycles(0, 1).with_(border)
    at = Sample(beyond, *tangent(problem, beyond, last.tangent))  # of the border and of the curve
    for sample in arc.samples[-2::-1]:
        image = sample.orbit.images[i]
        if image.index_of(code) < 0:
            break
        way = curve.problem.step_between(sample.orbit, touching)
        margin = replace(border, value=abs(float(image.margins[image.index_of(code)])))
        on = _sample_beyond_contact(curve, at, float(way @ at.tangent), margin)
        if on is not None:
            return None, own.cause(code), (curve, on)
    return None


def _distances(problem: Problem, image: SpaceImage) -> Floats:
    """The distances of the borders of a piece, to first order, in scaled unknowns."""
    size = np.linalg.norm(image.gradients * problem.lengths, axis=1)
    away: Floats = np.full(len(size), math.inf)
    np.divide(np.abs(image.margins), size, out=away, where=size > 0.0)
    return away


def _nearest(problem: Problem, orbit: SpaceOrbit) -> tuple[float, int, int]:
    """The nearest border of a cycle: its distance, the number of the image, and its code."""
    every = ((i, image, _distances(problem, image)) for i, image in enumerate(orbit.images))
    return min(
        ((away, i, code) for i, image, far in every
         for away, code in zip(far.tolist(), image.codes.tolist(), strict=True)),
        default=(math.inf, 0, 0),
    )  # fmt: skip


def _sample_beyond_contact(
    curve: SolutionCurve, at: Sample, length: float, margin: OnBorder
) -> Sample | None:
    """The sample of a curve at a distance beyond a contact with a border; None if there is none."""
    # There the multiplier is linear in the cube root of the margin. Its values where the margin is
    # that on this side, and an eighth of that, give the guess for Newton's method.
    problem, ahead = curve.problem, across(curve.problem, at.orbit, at.tangent, length)
    closes, multiplier = problem.conditions

    def held(root: float, near: SpaceOrbit) -> Solution:
        on = replace(margin, value=root**3 * margin.value)
        return solve(replace(problem, conditions=(closes, on, ahead)), near)

    full = held(1.0, problem.moved(at.orbit, length * at.tangent))
    half = held(0.5, full.orbit)
    one, other = (float(multiplier.residual(each.orbit)[0]) for each in (full, half))
    root = (2.0 * other - one) / (2.0 * (other - one)) if one != other else 0.0
    if not (full.converged and half.converged and root > 0.0):
        return None
    found = solve(problem.with_(ahead), held(root, half.orbit).orbit)
    image = found.orbit.images[margin.image]
    k = image.index_of(margin.code)
    if not found.converged or k < 0 or not _distances(problem, image)[k] >= LEAST_DISTANCE:
        return None
    sample = curve.start(found.orbit, at.tangent)
    turned = float(sample.tangent @ at.tangent) < math.cos(curve.settings.max_turn)
    return sample if not turned and _is_within(curve, sample) else None


# --- Where a curve goes on ------------------------------------------------------------------------


def _onward(
    curve: SolutionCurve,
    there: SpaceOrbit,
    arc: Arc,
    i: int,
    codes: list[int],
    kind: PlaneKind | None,
) -> Passed:
    """How a curve goes on from an orbit on a border that has the piece beyond it."""
    # Margins ``codes`` of image i vanish there, and become positive; ``kind`` is that of the point
    # if the curve goes on. Right at a border slopes may be those of a root: folds and flips go on
    # beside it.
    if _goes_round(curve.problem, there):
        return MEETINGS[kind_of(condition_of(curve))], SHORTER, None
    start = curve.start(there, arc.samples[-1].tangent)
    ways = (start, start.turned) if np.isfinite(start.tangent).all() else ()
    rising = [code for code in codes if (i, code) not in curve.ignored]
    for each in ways:
        if not all(curve.rate(each, i, code) > 0.0 for code in rising):
            continue
        if not is_steep(curve) and is_inside(curve, each):
            return kind, "", (curve, each)
        found = to_end(curve, each, BESIDE) or curve.advance(each, BESIDE)
        if found is not None and _is_within(curve, found):
            return kind, "", (curve, found)
    return MEETINGS[kind_of(condition_of(curve))], NO_CURVE, None


def _goes_round(problem: Problem, orbit: SpaceOrbit) -> bool:
    """Whether a cycle is a shorter one, run through several times."""
    # On a border pieces may differ that have the same values.
    return problem.period(orbit.x, MERGED) < len(orbit.x)


def _is_within(curve: SolutionCurve, sample: Sample) -> bool:
    """Whether no margin is negative, except for those that vanish all along a curve."""
    orbit = sample.orbit
    return not any(
        (i, code) not in curve.ignored
        for i, image in enumerate(orbit.images)
        for code in image.codes[(image.margins < 0.0) & ~image.tied(orbit.x[i], orbit.p)].tolist()
    )
