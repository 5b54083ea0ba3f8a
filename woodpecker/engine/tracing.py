"""Branches: from arc to arc through changes of word, to a special point and what starts there."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from pwmap.diagrams.data import DOUBLED
from pwmap.diagrams.diagram import PointKind
from woodpecker.base.arrays import Floats, norm
from woodpecker.engine.arrivals import (
    BESIDE,
    Arrival,
    Continuation,
    along_tangent,
    cause_of,
    causes_of,
    crossing_beyond,
    given_up,
    leads_back,
    of_cycles,
    over_accumulation,
    round_corner,
)
from woodpecker.engine.curves import SAME_END, Arc, Sample, SolutionCurve, Stop, nearest_border
from woodpecker.engine.following import KEPT_TURN, StopRequests, angle, follow, leaves
from woodpecker.engine.germs import (
    SAME,
    Beginning,
    beginnings,
    cycle_at_limit,
    cycle_through,
    direction_across,
    image_beside,
    is_inside,
    is_level,
    is_neutral,
    joined,
    least_period,
    rotated_to_nearest,
    slow_rate,
)
from woodpecker.engine.maps import (
    ACCUMULATE,
    LIMIT_DISTANCE,
    SpaceImage,
    images_of_chain,
    on_section,
)
from woodpecker.engine.newton import directions, other_direction, solve, uncertainty
from woodpecker.engine.orbits import Multiplier, OnBorder, SpaceOrbit, with_unknowns
from woodpecker.engine.rooted import refined_end
from woodpecker.engine.sharp_folds import extended_round_bend

MERGED_AT_FLIP = 1e-7  # scaled: at a flip points of the double cycle merge to the root of rounding
MERGED_TO_ROUNDING = 1e-12  # scaled: points that merge to rounding
KINK = 1e-5  # slopes of two pieces that differ by more make their border a kink
NEUTRAL = 1e-6  # a multiplier closer to 1 or -1 may lie on either side of it
# Relative: multipliers that differ by more on both sides of a border jump there.
DISCONTINUOUS = 1e-3
APART = tuple(2.0**-n for n in range(8, 33, 3))  # as BESIDE, at crossings: curves part slowly
NEAR = 1e-9  # scaled: a border closer than this is what makes steps too short
FARTHEST = 2.0**-7  # scaled: how far a branch may hug its border: a weak root holds it so close
MORE_SOLVES = 3  # further calls of Newton's method beside a border
FIRST_STEP_BEYOND = 4.0  # times the last step before a border: the first step beyond it
DENSE = 1e-4  # scaled: several arcs in a row that are shorter mean that borders are dense
# Scaled: how far crossings leap over dense borders; ever less as they come near their end.
LEAPS = tuple(DENSE * 4.0**-n for n in range(10))
MANY_SHORT = 4  # arcs in a row that make borders dense
MOST_ARCS = 2000  # on one branch


class Change(NamedTuple):
    """A change of word on a branch that is not a special point."""

    sample: int  # index of the sample at the border: the word changes there or with the next one
    cause: str  # a sentence on what happens there
    smooth: bool  # whether the derivatives of the map agree on both sides


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """A branch from its start to a special point."""

    begin: Beginning
    samples: tuple[Sample, ...]  # one at a border still has the pieces from before it
    changes: tuple[Change, ...]  # of the word
    arrival: Arrival  # the special point
    stop: Stop
    arrived: Beginning  # its last part, as a curve that starts at the special point

    @property
    def curve(self) -> SolutionCurve:
        """The curve of its last part."""
        return self.arrived.curve


def trace(begin: Beginning, orders: Sequence[int], halt: StopRequests | None = None) -> Trace:
    """Follow a curve through borders at which only its word changes, to a special point.

    A jump crossing ends where a cycle of one of the ``orders`` meets its border, not at others.
    """
    samples = [] if begin.before is None else [begin.before]
    samples.append(begin.sample)
    changes, at, step, short = list[Change](), begin, _first_step(begin), 0
    for _ in range(MOST_ARCS):
        arc = follow(at.curve, at.sample, step, halt, _home(begin, at))
        if _is_stuck(arc) and at.before is None:
            at = beside(at)
            if at.before is not None:  # the curve starts with a root singularity
                samples.append(at.sample)
                arc = follow(at.curve, at.sample, step, halt)
        is_out = arc.stop in (Stop.SPAN, Stop.WINDOW) and len(arc.samples) == 1 and not changes
        if is_out and (begin.before is None or leaves(begin.curve, begin.before) is not None):
            samples = [begin.sample]  # it leaves the span or window at once
        is_bend = arc.stop is Stop.SHORT and _at_flip(at, arc) is None
        bend = extended_round_bend(arc) if is_bend else None
        if bend is not None and bend.stop is Stop.SHORT:
            samples += bend.samples[1:]
            at, step = replace(at, sample=bend.samples[-1], before=None), math.inf
            continue
        arc = _at_nearest(bend or arc)
        step = FIRST_STEP_BEYOND * arc.step
        arc, outer = refined_end(arc)
        samples += arc.samples[1:]
        short = short + 1 if _length(arc) < DENSE else 0
        passed = _arrival_of(at, arc, samples, outer, orders, dense=short >= MANY_SHORT)
        if isinstance(passed, Arrival):
            break
        at, cause, smooth = passed
        changes.append(Change(len(samples) - 1, cause, smooth))
        if at.before is not None:
            samples.append(at.sample)
    else:
        arc = replace(arc, stop=Stop.MANY, condition=None)
        passed = given_up(arc)
    arrived = replace(at, sample=samples[-1], before=None)
    return Trace(begin, tuple(samples), tuple(changes), passed, arc.stop, arrived)


def _home(begin: Beginning, at: Beginning) -> Sample | None:
    """The start of a branch if it is back on the pieces of its start and may close; else None."""
    one, other = begin.sample.orbit, at.sample.orbit
    is_back = at is not begin and one.keys == other.keys and one.x.shape == other.x.shape
    return begin.sample if is_back else None


def _first_step(begin: Beginning) -> float:
    """The first step that the turn between a point and the sample beside it suggests."""
    point, first = begin.before, begin.sample
    if point is None or point.tangent.shape != first.tangent.shape:
        return math.inf
    turn = angle(point, first)
    length = norm(begin.curve.problem.step_between(point.orbit, first.orbit))
    return KEPT_TURN * begin.curve.settings.max_turn * length / turn if turn > 0.0 else math.inf


def _is_stuck(arc: Arc) -> bool:
    """Whether an arc cannot leave its start."""
    return arc.stop in (Stop.SHORT, Stop.BORDER) and len(arc.samples) == 1


def _length(arc: Arc) -> float:
    one, other = arc.samples[0].orbit, arc.samples[-1].orbit
    return norm(arc.curve.problem.step_between(one, other))


def _arrival_of(
    begin: Beginning, arc: Arc, way: Sequence[Sample], outer: SpaceImage | None,
    orders: Sequence[int], *, dense: bool,
) -> Arrival | Continuation:  # fmt: skip
    """What an arc ends at: a special point, or a change of word with what goes on there."""
    # ``way`` has all samples of the branch up to there.
    flip = _at_flip(begin, arc)
    if flip is not None:
        return flip
    if arc.stop in (Stop.LP, Stop.PD, Stop.BP, Stop.NS):
        return _at_multiplier(begin, arc)
    if outer is not None:
        return _at_border(begin, arc, way, outer, orders)
    if arc.stop in (Stop.BORDER, Stop.SHARE):
        return _at_crossing(begin, arc, way, orders, dense=dense)
    if arc.stop in (Stop.SHORT, Stop.OTHER_PIECE):
        return over_accumulation(begin, arc, way, ACCUMULATE) or given_up(arc)
    return given_up(arc)


def _at_multiplier(begin: Beginning, arc: Arc) -> Arrival:
    """A fold, flip, branch point or Neimark-Sacker point; the same curve goes on beyond it."""
    sample, onward = arc.samples[-1], None
    if arc.beyond is not None:
        before = None if arc.beyond is sample else sample  # the step may end right at the point
        onward = Beginning(begin.order, begin.curve, arc.beyond, before)
    kind, cause = PointKind[arc.stop.name], arc.stop.value
    note = _note_of_flip(begin.curve, sample.orbit) if kind is PointKind.PD else ""
    return Arrival(kind, sample.orbit, note, cause, arc.precision, onward=onward)


def _note_of_flip(curve: SolutionCurve, flip: SpaceOrbit) -> str:
    """That a flip is degenerate, as where a slope is -1 on a piece; else empty."""
    double = switched(curve, flip, PointKind.PD, len(flip.x))
    return DOUBLED if any(is_neutral(each.sample.orbit, curve.problem) for each in double) else ""


def _at_flip(begin: Beginning, arc: Arc) -> Arrival | None:
    """The flip at which both halves of a double cycle merge to the single one; None if none."""
    # Condition PD locates the single cycle to rounding, a fold the double to the root of that.
    orbit, problem = arc.samples[-1].orbit, arc.curve.problem
    n = len(orbit.x) // 2
    stops = arc.stop in (Stop.LP, Stop.BP, Stop.SHORT, Stop.OTHER_PIECE)
    if not stops or begin.is_crossing or len(orbit.x) % 2:
        return None
    near = (
        MERGED_AT_FLIP if arc.stop in (Stop.LP, Stop.BP) else SAME_END
    )  # given up close to the flip
    if not problem.same(orbit.x[:n], orbit.x[n:], near):
        return None
    if all(
        problem.same(each.orbit.x[:n], each.orbit.x[n:], MERGED_TO_ROUNDING) for each in arc.samples
    ):
        return None  # the single cycle all along, run through twice
    mean = np.concatenate((0.5 * (orbit.x[:n] + orbit.x[n:]).ravel(), orbit.p, (0.0,)))
    guess = with_unknowns(replace(orbit, x=orbit.x[:n], images=orbit.images[:n]), mean)
    flip = problem.with_(Multiplier("PD"))
    found = solve(flip, guess)
    away = np.abs(problem.step_between(guess, found.orbit)).max()
    if not found.converged or away > SAME_END:
        return None
    known, note = uncertainty(flip, found.orbit), _note_of_flip(arc.curve, found.orbit)
    return Arrival(PointKind.PD, found.orbit, note, Stop.PD.value, known)


# --- Cycles at borders ----------------------------------------------------------------------------


def _at_border(
    begin: Beginning, arc: Arc, way: Sequence[Sample], outer: SpaceImage, orders: Sequence[int]
) -> Arrival | Continuation:
    """What cycles meet at a border; ``outer`` is the image under the piece beyond it."""
    orbit, curve = arc.samples[-1].orbit, begin.curve
    cause = cause_of(arc)
    cycle = least_period(orbit, curve.problem)
    collision = Arrival(PointKind.BC, cycle, "", causes_of(arc), arc.precision)
    if len(cycle.x) < len(
        least_period(arc.samples[0].orbit, curve.problem).x
    ):  # born from a shorter cycle
        return collision
    assert arc.border is not None
    image = orbit.images[arc.border[0]]
    if outer.reason == ACCUMULATE and _jumps_to_limit(arc, image):
        return collision
    across = None if outer.reason else _across_section(begin, arc, outer)
    if across is not None:
        return across, cause, True
    if outer.reason:
        beyond = over_accumulation(begin, arc, way, cause)
        if beyond is not None:
            return beyond
        if outer.reason != ACCUMULATE:
            return Arrival(PointKind.FALL, orbit, outer.reason, cause, arc.precision)
        return given_up(arc, ACCUMULATE, cause)
    smooth = _is_smooth(curve, image, outer)
    if smooth:
        outer = _along(arc, image) or outer
    ahead, others_start = _cycles_beyond(begin, arc, outer, smooth=smooth), False
    if ahead is not None and smooth:
        return ahead, cause, True
    there = ahead if ahead is not None and is_inside(curve, ahead.sample) else None
    in_line = orbit.x.shape[1] == 1  # in R^1 other curves start only where stability changes
    if there is None or not in_line:
        arrived = replace(begin, sample=arc.samples[-1]).key
        wanted = {begin.order} if in_line else {*orders, begin.order, 2 * begin.order}
        starts = list(beginnings(curve, orbit.x, orbit.p, sorted(wanted)))
        others_start = any(each.order != begin.order for each in starts)
        others = [each for each in starts if each.order == begin.order and each.key != arrived]
        if len(others) > 1 or (others and others[0].is_crossing):
            return collision
        found = rotated_to_nearest(others[0], orbit.x[0]) if others else None
        there = found or _from_beside(begin, arc, outer) or ahead
    if there is None:
        return over_accumulation(begin, arc, way, cause, outer) or collision
    ends = arc.samples[-1], there.sample
    folds = ends[0].rate * ends[1].rate < 0.0  # the parameter turns back
    folds |= any(is_level(each, curve.problem) for each in ends)
    if folds or others_start or _changes_stability(arc, there.sample.orbit):
        return replace(collision, note="fold" if folds else "persistence", onward=there)
    return there, cause, smooth


def _across_section(begin: Beginning, arc: Arc, outer: SpaceImage) -> Beginning | None:
    """The cycles of the same motions beyond a jump where an event falls on a section; or None."""
    # The event is passed from one return to the next: the point right before it becomes that right
    # after it. The piece beyond the border maps the motion extended to there into the motion ahead.
    assert arc.border is not None
    (i, code), end, curve = arc.border, arc.samples[-1], begin.curve
    orbit, problem = end.orbit, curve.problem
    (n, d), p = orbit.x.shape, orbit.p
    k = (i + 1) % n
    if not on_section(orbit.images[i], code) or problem.same(outer.value, orbit.x[k], SAME):
        return None
    way, x, along = curve.motion(end, i), orbit.x.copy(), end.tangent.copy()
    x[k], ahead = outer.value, outer.jacobian @ way
    along[k * d : (k + 1) * d] = ahead / problem.x_scale
    there = curve.map.beside(x[k], p, np.append(ahead, way[d:]))
    passed = replace(orbit.with_image(i, outer).with_image(k, there), x=x)
    if there.reason or not problem.same(there.value, x[(k + 1) % n], SAME):
        return None
    sample = curve.start(passed, along)
    return Beginning(begin.order, curve, sample, end) if is_inside(curve, sample) else None


def _jumps_to_limit(arc: Arc, image: SpaceImage) -> bool:
    """Whether the limit of the pieces that accumulate beyond a border makes it a jump."""
    assert arc.border is not None
    (i, code), orbit, problem = arc.border, arc.samples[-1].orbit, arc.curve.problem
    beyond = -image.gradients[image.index_of(code)]
    limit = image_beside(arc.curve.map, orbit.x[i], orbit.p, beyond, problem.lengths)
    return not limit.reason and not problem.same(image.value, limit.value, SAME)


def _is_smooth(curve: SolutionCurve, inner: SpaceImage, outer: SpaceImage) -> bool:
    change = outer._replace(jacobian=outer.jacobian - inner.jacobian)
    return curve.problem.steepest(change) <= KINK


def _along(arc: Arc, image: SpaceImage) -> SpaceImage | None:
    """Where borders meet in R^d, the piece ahead along the branch, if the map is smooth there."""
    assert arc.border is not None
    i, end = arc.border[0], arc.samples[-1]
    x, p = end.orbit.x[i], end.orbit.p
    if len(x) == 1 or np.count_nonzero(image.tied(x, p)) < 2:  # no corner
        return None
    found = arc.curve.map.beside(x, p, arc.curve.motion(end, i))
    return None if found.reason or not _is_smooth(arc.curve, image, found) else found


def _cycles_beyond(
    begin: Beginning, arc: Arc, outer: SpaceImage, *, smooth: bool
) -> Beginning | None:
    """The cycles beyond a border if the map is continuous there; None if they do not leave it."""
    # Beyond means that the margin on this side is negative; where the slopes of both sides agree,
    # the curve simply keeps its tangent.
    assert arc.border is not None
    (i, code), orbit, curve = arc.border, arc.samples[-1].orbit, begin.curve
    if not curve.problem.same(orbit.images[i].value, outer.value, SAME):
        return None
    along = arc.samples[-1].tangent if smooth else None
    sample = curve.start(orbit.with_image(i, outer), along)
    if not np.isfinite(sample.tangent).all():
        return None
    inner = orbit.images[i]
    k = inner.index_of(code)
    out = -float(inner.gradients[k] @ curve.motion(sample, i))
    if not smooth and abs(out) <= slow_rate(curve.problem, inner, k):
        return None
    return Beginning(begin.order, curve, sample if smooth or out > 0.0 else sample.turned)


def _from_beside(begin: Beginning, arc: Arc, outer: SpaceImage) -> Beginning | None:
    """The cycles found right beside a border, on its far side; None if there are none."""
    # A root singularity keeps them so close to the border that only the margin tells how close.
    assert arc.border is not None
    (i, _), at, curve = arc.border, arc.samples[-1].orbit, begin.curve
    codes = outer.codes[outer.tied(at.x[i], at.p)].tolist()
    if not codes:
        return None
    for distance in BESIDE:
        found = _off_border(curve, at.with_image(i, outer), i, codes[0], distance)
        if found is not None:
            return Beginning(begin.order, curve, found, arc.samples[-1])
    return None


def _steepest_border(orbit: SpaceOrbit) -> tuple[int, int] | None:
    """Image and code of a vanishing margin of an orbit, that of the steepest image, or None."""
    tied = [
        (float(np.abs(image.jacobian).max()), -i, int(code))
        for i, (x, image) in enumerate(zip(orbit.x, orbit.images, strict=True))
        for code in image.codes[image.tied(x, orbit.p)][:1]
    ]
    if not tied:
        return None
    _, i, code = max(tied)
    return -i, code


def _off_border(
    curve: SolutionCurve, at: SpaceOrbit, i: int, code: int, distance: float
) -> Sample | None:
    """The cycle whose margin is that at a scaled distance inside the border, or None."""
    # Points at other roots begin at this distance, too: right at a root no slope tells the way.
    problem, d, x = curve.problem, at.x.shape[1], at.x.copy()
    for k, image in enumerate(at.images):
        steep = () if image.has_small_slopes else image.codes[image.tied(at.x[k], at.p)][:1]
        for each in (code,) if k == i else steep:
            inward = image.gradients[image.index_of(each), :d]
            x[k] += distance * np.sign(inward) * problem.x_scale
    guess = with_unknowns(at, np.concatenate((x.ravel(), at.p, (0.0,))))
    place = guess.images[i].index_of(code)
    if not guess.is_defined or place < 0:
        return None
    margin = OnBorder(i, code, float(guess.images[i].margins[place]))
    found = solve(problem.with_(margin), guess)
    for _ in range(MORE_SOLVES):  # where a border is curved shortened steps converge slowly
        if not found.converged and found.orbit.is_defined:
            found = solve(problem.with_(margin), found.orbit)
    if not found.converged or not curve.agrees(found.orbit):
        return None
    way = problem.step_between(at, found.orbit)
    sample = curve.start(found.orbit, way)
    is_near = float(np.abs(way).max()) <= FARTHEST
    return sample if is_near and np.isfinite(sample.tangent).all() else None


def _changes_stability(arc: Arc, beyond: SpaceOrbit) -> bool:
    """Whether the cycle is stable on one side of the border only."""
    assert arc.border is not None
    (i, code), before = arc.border, arc.samples[-1].orbit
    inward = before.images[i].gradients[before.images[i].index_of(code)]
    way = LIMIT_DISTANCE * inward / np.abs(inward / arc.curve.problem.lengths).max()
    one, other = _largest_multiplier(before, i, way), _largest_multiplier(beyond, i, -way)
    return abs(other - one) > DISCONTINUOUS * max(1.0, one) and (one < 1.0) != (other < 1.0)


def _largest_multiplier(orbit: SpaceOrbit, i: int, way: Floats) -> float:
    """The largest modulus of a multiplier, with the i-th point moved a little into its piece."""
    # At a root singularity slopes are unbounded: at the border itself rounding decides.
    image, d = orbit.images[i], orbit.x.shape[1]
    near = image.piece.at(orbit.x[i] + way[:d], orbit.p + way[d:])
    moved = orbit if near.reason else orbit.with_image(i, near)
    return float(np.abs(moved.multipliers()).max())


def beside(begin: Beginning, distances: Sequence[float] = BESIDE) -> Beginning:
    """Start a curve beside its point, along the tangent or inside of a border, if possible."""
    best, curve, orbit = begin, begin.curve, begin.sample.orbit
    margin = None if begin.is_crossing else _steepest_border(orbit)
    for distance in distances:
        ways = list[Sample | None]()
        if margin is None or orbit.images[margin[0]].has_small_slopes:
            ways.append(curve.advance(begin.sample, distance))  # at a root it would follow rounding
        if margin is not None:
            ways.append(_off_border(curve, orbit, *margin, distance))
        for found in ways:
            if found is None or not is_inside(curve, found):
                continue
            there = replace(begin, sample=found, before=begin.sample)
            if begin.is_crossing or _on_same_sides(begin.sample, found):
                return there
            best = there if best is begin else best
    return best


def switched(
    curve: SolutionCurve, point: SpaceOrbit, kind: PointKind, order: int
) -> list[Beginning]:
    """Curves that cross a curve of P_order at a flip or a branch point, each from beside it.

    A flip is given as the single cycle: its double crosses it, or its two halves cross the double.
    At a branch point all four halves are given: it is not known which of them led there.
    """
    ways, problem = list[Floats](), curve.problem
    if kind is PointKind.BP:
        ways = [sign * way for way in directions(problem, point) for sign in (1.0, -1.0)]
    elif kind is PointKind.PD:
        along = curve.start(point).tangent
        doubles, order = order == len(point.x), len(point.x)
        if doubles:
            order = 2 * order
            point = replace(point, x=np.tile(point.x, (2, 1)), images=point.images * 2)
            twice = np.append(np.tile(along[:-1], 2), along[-1:])
            direction_across = other_direction(problem, point, twice)
            ways = [] if direction_across is None else [direction_across]
        else:
            ways = [along, -along]
    begins = (beside(Beginning(order, curve, Sample(point, way)), APART) for way in ways)
    return [each for each in begins if each.before is not None]


def _on_same_sides(one: Sample, other: Sample) -> bool:
    """Whether two samples of a curve have neither a fold nor a flip between them."""
    for multiplier in (Multiplier("LP"), Multiplier("PD")):
        before, after = multiplier.value(one.orbit), multiplier.value(other.orbit)
        if before * after < 0.0 and abs(before) > NEUTRAL:
            return False
    return True


def _at_nearest(arc: Arc) -> Arc:
    """End an arc whose steps became too short beside a border on that border."""
    if arc.stop not in (Stop.SHORT, Stop.OTHER_PIECE):
        return arc
    orbit, problem = arc.samples[-1].orbit, arc.curve.problem
    away, *border = nearest_border(arc.curve, orbit)
    if away > NEAR or arc.curve.rate(arc.samples[-1], *border) > 0.0:
        return arc  # there is none, or the curve leads away
    on = OnBorder(*border)
    found = solve(problem.with_(on), orbit)
    samples = arc.samples
    if found.converged and np.abs(problem.step_between(orbit, found.orbit)).max() <= SAME_END:
        end = arc.curve.start(found.orbit, samples[-1].tangent)
        if not arc.curve.rate(end, *border) > 0.0:  # else another event time
            samples = (*samples, end)
    return replace(arc, samples=samples, stop=Stop.BORDER, border=(on.image, on.code), condition=on)


# --- Crossings ------------------------------------------------------------------------------------


def _at_crossing(
    begin: Beginning, arc: Arc, way: Sequence[Sample], orders: Sequence[int], *, dense: bool
) -> Arrival | Continuation:
    """What a jump crossing meets: a cycle at one limit, or a border at another of its points."""
    # Dense borders are leapt over: they do not change the border along which the crossing leads.
    orbit, curve, cause = arc.samples[-1].orbit, begin.curve, cause_of(arc)
    if arc.stop is Stop.SHARE:
        cycle = cycle_at_limit(orbit, curve.problem)
        return Arrival(PointKind.BC, cycle, "", cause, arc.precision)
    for away in LEAPS if dense else ():
        over = crossing_beyond(begin, arc, cause, (away,))
        if isinstance(over, tuple):
            return over
    beyond = _with_other_limit(begin, arc)
    if beyond is not None:
        return beyond, cause, True
    through = cycle_through(curve.map, orbit.x[0], orbit.p, orders, curve.problem)
    if through is not None:
        return Arrival(PointKind.BC, through, "", cause, arc.precision)
    starts = beginnings(of_cycles(curve), orbit.x[:1], orbit.p, (begin.order,))
    arrived = replace(begin, sample=arc.samples[-1]).key
    others = [
        each
        for each in starts
        if each.is_crossing and each.key != arrived and not leads_back(way, each)
    ]
    if len(others) == 1:
        is_long = beside(others[0], BESIDE[:1]).before is not None
        tangent = None if is_long else along_tangent(begin, arc, way, cause, others[0])
        return tangent or (others[0], cause, True)
    return (
        crossing_beyond(begin, arc, cause)
        or round_corner(begin, arc, way, cause)
        or given_up(arc, "the jump ends", cause)
    )


def _with_other_limit(begin: Beginning, arc: Arc) -> Beginning | None:
    """The crossing beyond a border of one limit alone, if that is continuous there; else None."""
    sample, curve = arc.samples[-1], begin.curve
    orbit, (i, code) = sample.orbit, arc.border or (-1, 0)
    last = len(orbit.x) - 1
    if i < last:
        return None
    x, p = orbit.x[last], orbit.p
    limits = [list(images_of_chain(image, x, p)) for image in orbit.all_images[last:]]
    own = limits[i - last]
    at = code % len(own)
    point, way = _arriving(curve, sample, own[:at])
    if at == 0:  # a second border passes through the border point itself
        if own[0].index_of(code // len(own)) < 0:
            return None  # its event ends here, with a root
        way = direction_across(own[0], code // len(own), x, p, curve.problem.lengths)
    other = image_beside(curve.map, point, p, way, curve.problem.lengths)
    if other.reason or not curve.problem.same(other.value, own[at].value, SAME):
        return None
    own[at] = other
    there = joined(
        of_cycles(curve), orbit.images[:last], (limits[0], limits[1]), orbit.x, p, orbit.share
    )
    if there is None:
        return None
    start = there.curve.start(there.sample.orbit, sample.tangent)
    if not np.isfinite(start.tangent).all() or not is_inside(there.curve, start):
        return None
    return replace(there, sample=start)


def _arriving(
    curve: SolutionCurve, sample: Sample, before: Sequence[SpaceImage]
) -> tuple[Floats, Floats]:
    """The point at which a limit arrives after some images, and its motion along the curve."""
    orbit = sample.orbit
    point, d = orbit.x[-1], orbit.x.shape[1]
    way = curve.motion(sample, len(orbit.x) - 1)
    for image in before:
        way = np.append(image.jacobian @ way, way[d:])
        point = image.value
    return point, way
