"""Branches: from arc to arc through changes of word, to a special point, and what starts there."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from pwmap.diagrams.diagram import PointKind, PointStatus
from woodpecker.base.arrays import Floats
from woodpecker.engine.curves import Sample, SolutionCurve, Stop
from woodpecker.engine.following import Arc, Halt, agrees, follow
from woodpecker.engine.germs import (
    SAME,
    SLOW,
    Beginning,
    across,
    beginnings,
    crossings_at,
    cycle_at_limit,
    cycle_through,
    is_inside,
    joined,
    lost_beyond,
    once,
)
from woodpecker.engine.maps import ACCUMULATE, Image, PiecewiseMap, links
from woodpecker.engine.needles import rounded
from woodpecker.engine.newton import STEEP, Problem, solve, uncertainty
from woodpecker.engine.orbits import Chained, Closed, Held, Multiplier, OnBorder, Orbit, placed

DOUBLED = 1e-7  # scaled: points that merge at a flip are known to the root of their rounding
ONE = 1e-12  # the same but for rounding
KINK = 1e-5  # slopes of a map that differ by more are those of a kink
ROOTED = 10.0  # times the slopes beyond a border those at the end of a root are larger
ASIDE = 1e-6  # scaled: an end that the piece beyond locates farther off is another one
NEUTRAL = 1e-6  # a multiplier that is closer to 1 or -1 may be on either side
TORN = 1e-3  # multipliers beyond a border that differ by a larger part are not those of one piece
BESIDE = tuple(2.0**-n for n in (20, 24, 28, 34, 40, 46))  # scaled: where a start is looked for
APART = tuple(2.0**-n for n in range(8, 33, 3))  # the same where curves cross, which part slowly
PASSED = tuple(10.0**-n for n in range(11, 1, -1))  # scaled: how far places are passed over
CORNER = tuple(10.0**-n for n in range(8, 1, -1))  # scaled: how far from a corner a jump is sought
LED = 64  # samples before a corner at most beside which a jump is sought
FASTEST = 10.0  # abs(dx/dp), scaled, of a branch beyond such a place at most
NEAR = 1e-9  # scaled: a border closer than this to where steps become too short ends them
FARTHEST = 2.0**-10  # scaled: how far from where it meets a border a branch may leave it at most
AGAIN = 4.0  # times the last step before a border: the first step beyond
DENSE = 1e-4  # scaled: arcs shorter than that, some in a row, are those where borders are dense
MANY_SHORT = 4  # of them
MOST_ARCS = 2000  # of one branch
LIMIT_LOST = "a limit of the jump is lost"


@dataclass(frozen=True, slots=True, eq=False)
class Arrival:
    """What a branch comes to.

    Attributes
    ----------
    kind, note, cause, precision, status
        As :class:`pwmap.diagrams.diagram.SpecialPoint` has them.
    orbit
        The orbit there; of a collision the cycle, run through once.
    collides
        Whether a cycle meets a border there, so that others start.
    onward
        Where the branch goes on; None if it does not.
    """

    kind: PointKind
    orbit: Orbit
    note: str = ""
    cause: str = ""
    precision: float = 0.0
    status: PointStatus = PointStatus.LOCATED
    collides: bool = False
    onward: Beginning | None = None


class Change(NamedTuple):
    """A change of word on a branch that is no special point.

    Attributes
    ----------
    sample
        The word changes after this one, as an index; it or the next lies at the border.
    cause
        A sentence on what happens there.
    smooth
        Whether the derivatives of the map are the same on both sides.
    """

    sample: int
    cause: str
    smooth: bool


Onward = tuple[Beginning, str, bool]
"""Where a branch goes on, why its word changes, and whether smoothly."""


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """A branch from its beginning to a special point.

    Attributes
    ----------
    begin
        Where it begins.
    samples
        All of its samples; one at a border has the pieces before it.
    changes
        Where its word changes.
    arrival
        The special point.
    stop
        What ended it.
    arrived
        Its last part, as something that starts at its end.
    """

    begin: Beginning
    samples: tuple[Sample, ...]
    changes: tuple[Change, ...]
    arrival: Arrival
    stop: Stop
    arrived: Beginning

    @property
    def curve(self) -> SolutionCurve:
        """What the last part of it is a curve of."""
        return self.arrived.curve


def trace(begin: Beginning, orders: Sequence[int], halt: Halt | None = None) -> Trace:
    """Follow a curve to a special point, through borders where only its word changes.

    Parameters
    ----------
    begin
        Where it begins.
    orders
        Periods of the cycles that are wanted: a jump crossing ends where one of them meets its
        border, and passes by others.
    halt
        What else ends it.
    """
    samples = [] if begin.before is None else [begin.before]
    samples.append(begin.sample)
    changes, at, step, short = list[Change](), begin, math.inf, 0
    for _ in range(MOST_ARCS):
        arc = follow(at.curve, at.sample, step, halt)
        is_stuck = arc.stop in (Stop.SHORT, Stop.BORDER) and len(arc.samples) == 1
        if is_stuck and at.before is None:
            at = beside(at)
            if at.before is not None:  # it starts with a root
                samples.append(at.sample)
                arc = follow(at.curve, at.sample, step, halt)
        if arc.stop in (Stop.SPAN, Stop.WINDOW) and len(arc.samples) == 1 and not changes:
            samples = [begin.sample]  # none of it is inside
        is_bend = arc.stop is Stop.SHORT and _at_flip(at, arc) is None
        bend = rounded(arc) if is_bend else None
        if bend is not None and bend.stop is Stop.SHORT:
            samples += bend.samples[1:]
            at, step = replace(at, sample=bend.samples[-1], before=None), math.inf
            continue
        arc = _at_nearest(bend or arc)
        step = AGAIN * arc.step
        arc, outer = _settled(arc)
        samples += arc.samples[1:]
        short = short + 1 if _length(arc) < DENSE else 0
        passed = _met(at, arc, outer, orders, dense=short >= MANY_SHORT)
        if isinstance(passed, Arrival):
            break
        at, cause, smooth = passed
        changes.append(Change(len(samples) - 1, cause, smooth))
        if at.before is not None:
            samples.append(at.sample)
    else:
        arc = replace(arc, stop=Stop.MANY, condition=None)
        passed = _given_up(at, arc)
    arrived = replace(at, sample=samples[-1], before=None)
    return Trace(begin, tuple(samples), tuple(changes), passed, arc.stop, arrived)


def _length(arc: Arc) -> float:
    """How far apart its ends are, scaled."""
    one, other = arc.samples[0].orbit, arc.samples[-1].orbit
    return float(np.linalg.norm(arc.curve.problem.step_between(one, other)))


def _met(
    begin: Beginning, arc: Arc, outer: Image | None, orders: Sequence[int], *, dense: bool
) -> Arrival | Onward:
    """What an arc comes to; or where it goes on, and why its word changes, if that is all."""
    flip = _at_flip(begin, arc)
    if flip is not None:
        return flip
    if arc.stop in (Stop.LP, Stop.PD, Stop.BP, Stop.NS):
        return _at_multiplier(begin, arc)
    if outer is not None:
        return _at_border(begin, arc, outer)
    if arc.stop in (Stop.BORDER, Stop.SHARE):
        return _at_crossing(begin, arc, orders, dense=dense)
    if arc.stop in (Stop.SHORT, Stop.OTHER_PIECE):
        return _passed_over(begin, arc, ACCUMULATE) or _given_up(begin, arc)
    return _given_up(begin, arc)


def _given_up(begin: Beginning, arc: Arc, note: str = "", cause: str = "") -> Arrival:
    is_open = arc.stop.is_open or bool(note)
    return Arrival(
        PointKind.EP, arc.samples[-1].orbit, note or arc.stop.value, cause or arc.stop.value,
        arc.precision, PointStatus.OPEN if is_open else PointStatus.LOCATED,
    )  # fmt: skip


def _at_multiplier(begin: Beginning, arc: Arc) -> Arrival:
    """A fold, a flip, a branch point: the curve goes on there."""
    sample, onward = arc.samples[-1], None
    if arc.beyond is not None:
        onward = Beginning(begin.order, begin.curve, arc.beyond, sample)
    kind, cause = PointKind[arc.stop.name], arc.stop.value
    return Arrival(kind, sample.orbit, "", cause, arc.precision, onward=onward)


def _at_flip(begin: Beginning, arc: Arc) -> Arrival | None:
    """Where a doubled cycle ends as its halves come together: the single one flips; None if not.

    The single one is found to rounding, its double to the root of that.
    """
    orbit, problem = arc.samples[-1].orbit, arc.curve.problem
    n = len(orbit.x) // 2
    stops = arc.stop in (Stop.LP, Stop.BP, Stop.SHORT, Stop.OTHER_PIECE)
    if not stops or begin.is_crossing or len(orbit.x) % 2:
        return None
    if arc.stop in (Stop.LP, Stop.BP) and not problem.same(orbit.x[:n], orbit.x[n:], DOUBLED):
        return None
    if all(problem.same(each.orbit.x[:n], each.orbit.x[n:], ONE) for each in arc.samples):
        return None  # it is the single one all along, passed twice
    mean = np.concatenate((0.5 * (orbit.x[:n] + orbit.x[n:]).ravel(), orbit.p, (0.0,)))
    guess = placed(replace(orbit, x=orbit.x[:n], images=orbit.images[:n]), mean)
    flip = problem.with_(Multiplier("PD"))
    found = solve(flip, guess)
    away = np.abs(problem.step_between(guess, found.orbit)).max()
    if not found.converged or away > ASIDE:
        return None
    known = uncertainty(flip, found.orbit)
    return Arrival(PointKind.PD, found.orbit, "", Stop.PD.value, known)


# --- Cycles at borders ----------------------------------------------------------------------------


def _settled(arc: Arc) -> tuple[Arc, Image | None]:
    """An arc with its end as both sides of the border say, and what lies beyond it.

    There is something beyond just where cycles meet a border.
    """
    if arc.stop is not Stop.BORDER or arc.samples[-1].orbit.outer is not None:
        return arc, None
    assert arc.border is not None
    i, code = arc.border
    orbit = arc.samples[-1].orbit
    image = orbit.images[i]
    gradient = image.gradients[image.place(code)]
    outer = arc.curve.map.beside(orbit.x[i], orbit.p, -gradient)
    arc = _sharpened(arc, i, gradient)
    if not outer.reason and _is_steep(arc.samples[-1].orbit.images[i], outer):
        return _moved_to(arc, i, outer)
    return arc, outer


def _at_border(begin: Beginning, arc: Arc, outer: Image) -> Arrival | Onward:
    """What cycles come to at a border, with what the map takes beyond it."""
    orbit, curve = arc.samples[-1].orbit, begin.curve
    cause = _cause(arc)
    cycle = once(orbit, curve.problem)
    if len(cycle.x) < len(once(arc.samples[0].orbit, curve.problem).x):  # it was born there
        return Arrival(PointKind.BC, cycle, "", cause, arc.precision, collides=True)
    assert arc.border is not None
    image = orbit.images[arc.border[0]]
    if outer.reason:
        beyond = _passed_over(begin, arc, cause)
        if beyond is not None:
            return beyond
        if outer.reason != ACCUMULATE:
            return Arrival(PointKind.FALL, orbit, outer.reason, cause, arc.precision)
        return _given_up(begin, arc, ACCUMULATE, cause)
    collision = Arrival(PointKind.BC, cycle, "", cause, arc.precision, collides=True)
    smooth = bool(np.abs(outer.jacobian - image.jacobian).max() <= KINK)
    ahead, doubles = _straight_on(begin, arc, outer, smooth=smooth), False
    if ahead is not None and smooth:
        return ahead, cause, True
    there = ahead if ahead is not None and is_inside(curve, ahead.sample) else None
    in_line = orbit.x.shape[1] == 1  # there cycles double just where the others change stability
    if there is None or not in_line:
        arrived = replace(begin, sample=arc.samples[-1]).key
        wanted = [begin.order] if in_line else [begin.order, 2 * begin.order]
        starts = list(beginnings(curve, orbit.x, orbit.p, wanted))
        doubles = any(each.order > begin.order for each in starts)
        others = [each for each in starts if each.order == begin.order and each.key != arrived]
        if len(others) > 1 or (others and others[0].is_crossing):
            return collision
        there = others[0] if others else _hugging(begin, arc, outer) or ahead
    if there is None:
        return _passed_over(begin, arc, cause, outer) or collision
    folds = there.ahead * arc.samples[-1].tangent[orbit.x.size] < 0.0
    before, after = (each.orbit.monodromy for each in (arc.samples[-1], there.sample))
    if folds or doubles or _changes_stability(before, after):
        return replace(
            collision,
            note="fold" if folds else "persistence",
            onward=there,
        )
    return there, cause, smooth


def _straight_on(begin: Beginning, arc: Arc, outer: Image, *, smooth: bool) -> Beginning | None:
    """The cycles of the piece beyond a border across which the map is continuous; None if none.

    They lead to where the margin on this side is negative; where slopes are the same on both sides,
    on as they came.
    """
    assert arc.border is not None
    (i, code), orbit, curve = arc.border, arc.samples[-1].orbit, begin.curve
    if not curve.problem.same(orbit.images[i].value, outer.value, SAME):
        return None
    along = arc.samples[-1].tangent if smooth else None
    images = (*orbit.images[:i], outer, *orbit.images[i + 1 :])
    sample = curve.start(replace(orbit, images=images), along)
    if not np.isfinite(sample.tangent).all():
        return None
    inner = orbit.images[i]
    out = -float(inner.gradients[inner.place(code)] @ curve.motion(sample, i))
    if not smooth and abs(out) <= SLOW:
        return None
    return Beginning(begin.order, curve, sample if smooth or out > 0.0 else sample.turned)


def _hugging(begin: Beginning, arc: Arc, outer: Image) -> Beginning | None:
    """The cycles beyond a border, from right beside it on; None if none are found there.

    Where the piece beyond begins with a root they hug the border, and only its margin tells how far
    they have come.
    """
    assert arc.border is not None
    (i, _), at, curve = arc.border, arc.samples[-1].orbit, begin.curve
    codes = outer.codes[outer.tied(at.x[i], at.p)].tolist()
    if not codes:
        return None
    start = replace(at, images=(*at.images[:i], outer, *at.images[i + 1 :]))
    for distance in BESIDE:
        found = _off_border(curve, start, i, codes[0], distance)
        if found is not None:
            return Beginning(begin.order, curve, found, arc.samples[-1])
    return None


def _off_border(
    curve: SolutionCurve, at: Orbit, i: int, code: int, distance: float
) -> Sample | None:
    """The cycle beside one at a border that has come as far from it as a point at a distance.

    The distance is scaled. None if there is no such cycle.
    """
    problem, d = curve.problem, at.x.shape[1]
    inward = at.images[i].gradients[at.images[i].place(code), :d]
    x = at.x.copy()
    x[i] += distance * np.sign(inward) * problem.x_scale
    guess = placed(at, np.concatenate((x.ravel(), at.p, (0.0,))))
    place = guess.images[i].place(code)
    if not guess.is_defined or place < 0:
        return None
    margin = OnBorder(i, code, float(guess.images[i].margins[place]))
    found = solve(problem.with_(margin), guess)
    if not found.converged or not agrees(curve, found.orbit):
        return None
    way = problem.step_between(at, found.orbit)
    sample = curve.start(found.orbit, way)
    is_near = float(np.abs(way).max()) <= FARTHEST
    return sample if is_near and np.isfinite(sample.tangent).all() else None


def _sharpened(arc: Arc, i: int, inward: Floats) -> Arc:
    """An arc of cycles that ends at a border, with the derivatives right inside it at its end.

    Where a time goes like a root of the distance those at the border are made of rounding.
    """
    if len(arc.samples) < 2:
        return arc
    (before, end), orbit = arc.samples[-2:], arc.samples[-1].orbit
    steady = end.tangent @ before.tangent > math.cos(arc.curve.settings.max_turn)
    slopes = [float(np.abs(each.orbit.images[i].jacobian).max()) for each in (before, end)]
    if steady and not slopes[0] < STEEP < slopes[1]:
        return arc
    own = arc.curve.map.beside(orbit.x[i], orbit.p, inward)
    if own.reason or own.piece.key != orbit.images[i].piece.key:
        return arc
    if steady and _is_steep(own, before.orbit.images[i]):
        return arc  # a root that comes to its end
    images = (*orbit.images[:i], own, *orbit.images[i + 1 :])
    last = arc.curve.start(replace(orbit, images=images), before.tangent)
    return replace(arc, samples=(*arc.samples[:-1], last))


def _is_steep(inner: Image, outer: Image) -> bool:
    """Whether a piece has the slopes of a root's end, and another image has not."""
    d = len(inner.value)
    one, other = (float(np.abs(each.jacobian[:, :d]).max()) for each in (inner, outer))
    return one > ROOTED * max(1.0, other)


def _moved_to(arc: Arc, i: int, outer: Image) -> tuple[Arc, Image]:
    """An arc that ends at a root, with its end as the piece beyond locates it, and that one.

    It is not as steep. The map is continuous there: it is not rounding of the root that decides.
    """
    end, problem = arc.samples[-1], arc.curve.problem
    orbit = end.orbit
    codes = outer.codes[outer.tied(orbit.x[i], orbit.p)].tolist()
    if not codes:
        return arc, outer
    beyond = replace(orbit, images=(*orbit.images[:i], outer, *orbit.images[i + 1 :]))
    found = solve(problem.with_(OnBorder(i, codes[0])), beyond)
    away = np.abs(problem.step_between(orbit, found.orbit)).max()
    if not found.converged or away > ASIDE:
        return arc, outer
    value = found.orbit.images[i].value
    inner, outer = replace(orbit.images[i], value=value), replace(outer, value=value)
    images = (*found.orbit.images[:i], inner, *found.orbit.images[i + 1 :])
    last = Sample(replace(found.orbit, images=images), end.tangent)
    return replace(arc, samples=(*arc.samples[:-1], last)), outer


def _changes_stability(before: Floats, after: Floats) -> bool:
    one, other = (float(np.abs(np.linalg.eigvals(each)).max()) for each in (before, after))
    return abs(other - one) > TORN * max(1.0, one) and (one < 1.0) != (other < 1.0)


def beside(begin: Beginning, distances: Sequence[float] = BESIDE) -> Beginning:
    """A beginning with its first sample beside the point where it starts, if there is one.

    It lies at a distance along the curve, or of a cycle at a border from that: where a piece
    begins with a root only that leads off.
    """
    best, curve, orbit = begin, begin.curve, begin.sample.orbit
    tied = list[tuple[int, int]]()
    if not begin.is_crossing:
        for i, (x, image) in enumerate(zip(orbit.x, orbit.images, strict=True)):
            tied += [(i, code) for code in image.codes[image.tied(x, orbit.p)].tolist()]
    for distance in distances:
        ways = [curve.advance(begin.sample, distance)]
        ways += [_off_border(curve, orbit, *margin, distance) for margin in tied[:1]]
        for found in ways:
            if found is None or not is_inside(curve, found):
                continue
            there = replace(begin, sample=found, before=begin.sample)
            if begin.is_crossing or _on_same_sides(begin.sample, found):
                return there
            best = there if best is begin else best
    return best


def _on_same_sides(one: Sample, other: Sample) -> bool:
    """Whether neither a fold nor a flip lies between: beyond one the branch is another one."""
    for multiplier in (Multiplier("LP"), Multiplier("PD")):
        before, after = multiplier.value(one.orbit), multiplier.value(other.orbit)
        if before * after < 0.0 and abs(before) > NEUTRAL:
            return False
    return True


def _at_nearest(arc: Arc) -> Arc:
    """An arc whose steps have become too short beside a border, as one that ends there."""
    if arc.stop not in (Stop.SHORT, Stop.OTHER_PIECE):
        return arc
    orbit, scale = arc.samples[-1].orbit, np.array(arc.curve.problem.x_scale)
    d, best = len(scale), (math.inf, (0, 0))
    for i, image in enumerate(orbit.taken):
        slopes = np.linalg.norm(image.gradients[:, :d] * scale, axis=1)
        for margin, slope, code in zip(image.margins, slopes, image.codes.tolist(), strict=True):
            if (i, code) not in arc.curve.ignored and slope > 0.0:
                best = min(best, (abs(float(margin / slope)), (i, code)))
    if best[0] > NEAR:
        return arc
    on, problem = OnBorder(*best[1]), arc.curve.problem
    found = solve(problem.with_(on), orbit)
    samples = arc.samples
    if found.converged and np.abs(problem.step_between(orbit, found.orbit)).max() <= ASIDE:
        samples = (*samples, arc.curve.start(found.orbit, samples[-1].tangent))
    return replace(arc, samples=samples, stop=Stop.BORDER, border=best[1], condition=on)


def _passed_over(
    begin: Beginning, arc: Arc, cause: str, outer: Image | None = None
) -> Arrival | Onward | None:
    """The branch beyond a place where borders accumulate, the nearest there is.

    It is looked for along the tangent, ever farther, with the pieces that the map takes there.
    """
    end, curve = arc.samples[-1], begin.curve
    if begin.is_crossing:
        return _crossing_beyond(begin, arc, cause)
    (column,), problem = curve.problem.free, curve.problem
    size = end.orbit.x.size
    rate = end.tangent[size]
    low, high = curve.settings.spans[0]
    if rate == 0.0:
        return None
    for away in PASSED:
        p = end.orbit.p.copy()
        p[column] = min(
            max(p[column] + math.copysign(away, rate) * problem.p_scale[column], low), high
        )
        if p[column] == end.orbit.p[column]:
            return None
        along = (p[column] - end.orbit.p[column]) / problem.p_scale[column] / rate
        x = end.orbit.x + (along * end.tangent[:size]).reshape(end.orbit.x.shape) * problem.x_scale
        images = [curve.map.at(point, p) for point in x]
        if outer is not None and arc.border is not None:
            images[arc.border[0]] = outer.piece.at(x[arc.border[0]], p)
        if any(image.reason for image in images):
            continue
        if away == PASSED[0] and _jumps_unseen(end.orbit, x, p, images, problem):
            return None
        held = problem.with_(Held(size + column, float(p[column])))
        found = solve(held, Orbit(x, p, 0.0, tuple(images)))
        if not found.converged or not problem.same(found.orbit.x, end.orbit.x, FASTEST * away):
            continue
        sample = curve.start(found.orbit, np.eye(size + 1)[-1] * rate)
        if all(
            curve.map.at(point, p).piece.key == image.piece.key
            for point, image in zip(found.orbit.x, found.orbit.images, strict=True)
        ):
            return Beginning(begin.order, curve, sample, end), _passed(cause), True
    return None


def _jumps_unseen(
    orbit: Orbit, x: Floats, p: Floats, images: list[Image], problem: Problem
) -> bool:
    """Whether a map jumps right ahead of an orbit, though no margin of its pieces vanishes."""
    for i, image in enumerate(images):
        own = orbit.images[i].piece.at(x[i], p)
        if own.reason or own.piece.key == image.piece.key or own.tied(x[i], p).any():
            continue
        steepest = max(1.0, float(np.abs(own.jacobian).max()), float(np.abs(image.jacobian).max()))
        if not problem.same(own.value, image.value, ASIDE * steepest):
            return True
    return False


def _passed(cause: str) -> str:
    return cause if cause == ACCUMULATE else f"{cause}: {ACCUMULATE}"


def _crossing_beyond(
    begin: Beginning, arc: Arc, cause: str, distances: Sequence[float] = PASSED
) -> Arrival | Onward | None:
    """The jump crossing beyond such a place: on the same border, between the limits there."""
    end, curve = arc.samples[-1], begin.curve
    problem, size = curve.problem, end.orbit.x.size
    (column,), rate = problem.free, end.tangent[size]
    if rate == 0.0 or end.orbit.x.shape[1] > 1:  # only in R^1 does the border alone say where it is
        return None
    head = replace(end.orbit, outer=None, share=0.0)
    base = _of_cycles(curve)
    low, high = curve.settings.spans[0]
    for away in distances:
        to = float(end.orbit.p[column]) + math.copysign(away, rate) * problem.p_scale[column]
        if min(max(to, low), high) == end.orbit.p[column]:
            return None
        held = Held(size + column, min(max(to, low), high))
        border = replace(problem, conditions=(Chained(), *problem.conditions[1:], held))
        found = solve(border, head)
        if not found.converged:
            continue
        there = found.orbit
        for each in crossings_at(base, there.x, there.p, begin.order):
            sample = each.curve.start(each.sample.orbit, np.eye(size + 1)[size] * rate)
            if len(each.sample.orbit.x) == len(end.orbit.x):
                return replace(each, sample=sample, before=end), _passed(cause), True
        reason = lost_beyond(base.map, there.x[-1], there.p, begin.order - len(there.x))
        if reason:
            p = float(there.p[column])
            return Arrival(
                PointKind.FALL, end.orbit, reason, LIMIT_LOST,
                abs(p - float(end.orbit.p[column])),
            )  # fmt: skip
    return None


def _round_corner(begin: Beginning, arc: Arc, cause: str) -> Onward | None:
    """The jump crossing on another border that leaves the place where its own one ends.

    Many margins may vanish there, and steep ones: it is looked for at a distance, ahead, and beside
    the samples that led there, where the piece between two jumps has come to its end.
    """
    end, problem = arc.samples[-1], begin.curve.problem
    (n, d), (column,) = end.orbit.x.shape, problem.free
    if d > 1 or end.tangent[n] == 0.0:
        return None
    p, x = float(end.orbit.p[column]), float(end.orbit.x[-1, 0])
    places = list[tuple[float, float, float]]()  # parameter, and an interval of the border point
    for away in CORNER:
        step, width = math.copysign(away, end.tangent[n]), FASTEST * away * problem.x_scale[0]
        places.append((p + step * problem.p_scale[column], x - width, x + width))
    for sample in arc.samples[-2 : -2 - LED : -1]:
        back, at = float(sample.orbit.p[column]), float(sample.orbit.x[-1, 0])
        close = BESIDE[-1] * problem.x_scale[0]
        for width in (each * problem.x_scale[0] for each in CORNER):
            places += [(back, at + close, at + width), (back, at - width, at - close)]
    for to, low, high in places:
        found = _passing(begin, end, to, low, high)
        if found is not None:
            sample = found.curve.start(found.sample.orbit, np.eye(n + 1)[-1] * (to - p))
            return replace(found, sample=sample, before=end), cause, False
    return None


def _passing(begin: Beginning, end: Sample, to: float, low: float, high: float) -> Beginning | None:
    """The jump crossing at a parameter whose border point lies in an interval."""
    problem, n = begin.curve.problem, len(end.orbit.x)
    (column,), base, p = problem.free, _of_cycles(begin.curve), end.orbit.p.copy()
    p[column] = to
    x = _halved(base.map, end.orbit, p, begin.order, low, high)
    if x is None:
        return None
    held = Held(n - 1, x), Held(n + column, to)
    start = replace(end.orbit, outer=None, share=0.0)
    head = solve(replace(problem, conditions=(Chained(), *held)), start)
    found = crossings_at(base, head.orbit.x, p, begin.order) if head.converged else []
    return next((each for each in found if len(each.sample.orbit.x) == n), None)


def _halved(
    map_: PiecewiseMap, orbit: Orbit, p: Floats, order: int, low: float, high: float
) -> float | None:
    """Where the last image of a border point passes by the first point; None if nowhere.

    Halved down to neighbouring doubles.
    """
    n = len(orbit.x)

    def side(at: float) -> float:
        point = np.array([at])
        for _ in range(order - n + 1):
            image = map_.at(point, p)
            if image.reason:
                return math.nan
            point = image.value
        return float(point[0]) - (at if n == 1 else float(orbit.x[0, 0]))

    below = side(low)
    if not below * side(high) < 0.0:
        return None
    while low < (middle := 0.5 * (low + high)) < high:
        value = side(middle)
        if math.isnan(value):
            return None
        if below * value > 0.0:
            low = middle
        else:
            high = middle
    return middle


# --- Crossings ------------------------------------------------------------------------------------


def _at_crossing(
    begin: Beginning, arc: Arc, orders: Sequence[int], *, dense: bool
) -> Arrival | Onward:
    """Where a jump crossing closes as a cycle, or another of its points meets a border.

    Where its limits change their words again and again within a short way some are passed over:
    where the border is does not depend on them.
    """
    orbit, curve, cause = arc.samples[-1].orbit, begin.curve, _cause(arc)
    if arc.stop is Stop.SHARE:
        cycle = cycle_at_limit(orbit, curve.problem)
        return Arrival(PointKind.BC, cycle, "", cause, arc.precision, collides=True)
    over = _crossing_beyond(begin, arc, cause, (DENSE,)) if dense else None
    if isinstance(over, tuple):
        return over
    beyond = _one_side_beyond(begin, arc)
    if beyond is not None:
        return beyond, cause, True
    through = cycle_through(curve.map, orbit.x[0], orbit.p, orders, curve.problem)
    if through is not None:
        return Arrival(PointKind.BC, through, "", cause, arc.precision, collides=True)
    starts = beginnings(_of_cycles(curve), orbit.x[:1], orbit.p, (begin.order,))
    arrived = replace(begin, sample=arc.samples[-1]).key
    others = [each for each in starts if each.is_crossing and each.key != arrived]
    if len(others) == 1:
        return others[0], cause, True
    return (
        _crossing_beyond(begin, arc, cause)
        or _round_corner(begin, arc, cause)
        or _given_up(begin, arc, "the jump ends", cause)
    )


def _of_cycles(curve: SolutionCurve) -> SolutionCurve:
    """Curves of cycles, of the map whose jump crossings a curve is of."""
    problem = replace(curve.problem, conditions=(Closed(),))
    return replace(curve, problem=problem, ignored=frozenset())


def _one_side_beyond(begin: Beginning, arc: Arc) -> Beginning | None:
    """The crossing beyond a border at which one of its two limits only changes its word.

    None unless the limit is continuous there, and the crossing goes on.
    """
    sample, curve = arc.samples[-1], begin.curve
    orbit, (i, code) = sample.orbit, arc.border or (-1, 0)
    last = len(orbit.x) - 1
    if i < last:
        return None
    x, p = orbit.x[last], orbit.p
    limits = [list(links(image, x, p)) for image in orbit.taken[last:]]
    own = limits[i - last]
    at = code % len(own)
    point, way = _arriving(curve, sample, own[:at])
    if at == 0:  # on this side of the jump
        if own[0].place(code // len(own)) < 0:
            return None  # a root has come to its end
        way = across(own[0], code // len(own), x, p, curve.problem.lengths)
    other = curve.map.beside(point, p, way)
    if other.reason or not curve.problem.same(other.value, own[at].value, SAME):
        return None
    own[at] = other
    there = joined(
        _of_cycles(curve), orbit.images[:last], (limits[0], limits[1]), orbit.x, p, orbit.share
    )
    if there is None:
        return None
    start = there.curve.start(there.sample.orbit, sample.tangent)
    if not np.isfinite(start.tangent).all() or not is_inside(there.curve, start):
        return None
    return replace(there, sample=start)


def _arriving(
    curve: SolutionCurve, sample: Sample, before: Sequence[Image]
) -> tuple[Floats, Floats]:
    """Where the orbit of a limit comes to after some images, and how that moves (d + k,)."""
    orbit = sample.orbit
    point, d = orbit.x[-1], orbit.x.shape[1]
    way = curve.motion(sample, len(orbit.x) - 1)
    for image in before:
        way = np.append(image.jacobian @ way, way[d:])
        point = image.value
    return point, way


def _cause(arc: Arc) -> str:
    """What happens where an arc ends at a border."""
    image, code = arc.border or min(arc.curve.ignored)
    return arc.samples[-1].orbit.taken[image].piece.cause(code)
