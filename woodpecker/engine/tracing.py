"""Branches: from arc to arc through changes of word, to a special point, and what starts there."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from pwmap.diagrams.diagram import PointKind, PointStatus
from woodpecker.base.arrays import Floats
from woodpecker.engine.curves import Arc, Curve, Halt, Sample, Stop
from woodpecker.engine.germs import (
    SAME,
    TILT,
    Beginning,
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
from woodpecker.engine.newton import Problem, solve
from woodpecker.engine.orbits import Chained, Closed, Held, Multiplier, OnBorder, Orbit, placed

KINK = 1e-5  # slopes of a map that differ by more are those of a kink
ROOTED = 10.0  # times the slopes beyond a border those at the end of a root are larger
ASIDE = 1e-6  # scaled: an end that the piece beyond locates farther off is another one
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
        Index of the sample at the border; the word changes after it.
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
    def curve(self) -> Curve:
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
        arc = at.curve.follow(at.sample, step, halt)
        if arc.stop is Stop.SHORT and len(arc.samples) == 1 and at.before is None:
            at = beside(at)
            if at.before is not None:  # it starts with a root
                samples.append(at.sample)
                arc = at.curve.follow(at.sample, step, halt)
        if arc.stop in (Stop.SPAN, Stop.WINDOW) and len(arc.samples) == 1 and not changes:
            samples = [begin.sample]  # none of it is inside
        arc = _at_nearest(arc)
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
    sample, problem = arc.samples[-1], begin.curve.problem
    single = sample.orbit if begin.is_crossing else once(sample.orbit, problem)
    start = arc.samples[0].orbit
    before = len(start.x) if begin.is_crossing else len(once(start, problem).x)
    halved = len(single.x) < before  # cycles of twice the period come to its flip
    kind = PointKind.PD if halved else PointKind[arc.stop.name]
    onward = None
    if not halved and arc.beyond is not None:
        onward = Beginning(begin.order, begin.curve, arc.beyond, sample)
    cause = Stop.PD.value if halved else arc.stop.value
    return Arrival(kind, sample.orbit, "", cause, arc.precision, onward=onward)


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
        arc = _moved_to(arc, i, outer)
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
    there, doubles = _straight_on(begin, arc, outer), False
    if there is not None and smooth and there.sample.tangent @ arc.samples[-1].tangent > 0.0:
        return there, cause, True
    in_line = orbit.x.shape[1] == 1  # there cycles double just where the others change stability
    if there is None or not in_line:
        arrived = replace(begin, sample=arc.samples[-1]).key
        wanted = [begin.order] if in_line else [begin.order, 2 * begin.order]
        starts = list(beginnings(curve, orbit.x, orbit.p, wanted))
        doubles = any(each.order > begin.order for each in starts)
        others = [each for each in starts if each.order == begin.order and each.key != arrived]
        if len(others) > 1 or (others and others[0].is_crossing):
            return collision
        there = others[0] if others else _hugging(begin, arc, outer)
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


def _straight_on(begin: Beginning, arc: Arc, outer: Image) -> Beginning | None:
    """The cycles of the piece beyond a border across which the map is continuous; None if none."""
    assert arc.border is not None
    i, orbit, curve = arc.border[0], arc.samples[-1].orbit, begin.curve
    if not curve.problem.same(orbit.images[i].value, outer.value, SAME):
        return None
    sample = curve.start(replace(orbit, images=(*orbit.images[:i], outer, *orbit.images[i + 1 :])))
    if not np.isfinite(sample.tangent).all():
        return None
    ways = [each for each in (sample, sample.turned) if is_inside(curve, each)]
    return Beginning(begin.order, curve, ways[0]) if len(ways) == 1 else None


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
    d, problem = at.x.shape[1], curve.problem
    inward = outer.gradients[outer.place(codes[0]), :d]
    images = (*at.images[:i], outer, *at.images[i + 1 :])
    for distance in BESIDE:
        x = at.x.copy()
        x[i] += distance * np.sign(inward) * problem.x_scale
        guess = placed(replace(at, images=images), np.concatenate((x.ravel(), at.p, (0.0,))))
        place = guess.images[i].place(codes[0])
        if not guess.is_defined or place < 0:
            continue
        margin = OnBorder(i, codes[0], float(guess.images[i].margins[place]))
        found = solve(problem.with_(margin), guess)
        if found.converged and curve.agrees(found.orbit):
            way = problem.step_between(at, found.orbit)
            sample = curve.start(found.orbit, way)
            if float(np.abs(way).max()) <= FARTHEST and np.isfinite(sample.tangent).all():
                return Beginning(begin.order, curve, sample, arc.samples[-1])
    return None


def _sharpened(arc: Arc, i: int, inward: Floats) -> Arc:
    """An arc of cycles that ends at a border, with the derivatives right inside it at its end.

    Where a time goes like a root of the distance those at the border are made of rounding.
    """
    if len(arc.samples) < 2:
        return arc
    before, end = arc.samples[-2:]
    if end.tangent @ before.tangent > math.cos(arc.curve.settings.max_turn):
        return arc
    orbit = end.orbit
    own = arc.curve.map.beside(orbit.x[i], orbit.p, inward)
    if own.reason or own.piece.key != orbit.images[i].piece.key:
        return arc
    images = (*orbit.images[:i], own, *orbit.images[i + 1 :])
    last = arc.curve.start(replace(orbit, images=images), before.tangent)
    return replace(arc, samples=(*arc.samples[:-1], last))


def _is_steep(inner: Image, outer: Image) -> bool:
    """Whether a piece ends in a root, and the one beyond does not."""
    one, other = (float(np.abs(each.jacobian).max()) for each in (inner, outer))
    return one > ROOTED * max(1.0, other)


def _moved_to(arc: Arc, i: int, outer: Image) -> Arc:
    """An arc that ends at a root, with its end as the piece beyond locates it, which is not steep.

    The map is continuous there: it is not rounding of the root that decides.
    """
    end, problem = arc.samples[-1], arc.curve.problem
    orbit = end.orbit
    codes = outer.codes[outer.tied(orbit.x[i], orbit.p)].tolist()
    if not codes:
        return arc
    beyond = replace(orbit, images=(*orbit.images[:i], outer, *orbit.images[i + 1 :]))
    found = solve(problem.with_(OnBorder(i, codes[0])), beyond)
    away = np.abs(problem.step_between(orbit, found.orbit)).max()
    if not found.converged or away > ASIDE:
        return arc
    inner = replace(orbit.images[i], value=found.orbit.images[i].value)
    images = (*found.orbit.images[:i], inner, *found.orbit.images[i + 1 :])
    last = Sample(replace(found.orbit, images=images), end.tangent)
    return replace(arc, samples=(*arc.samples[:-1], last))


def _changes_stability(before: Floats, after: Floats) -> bool:
    one, other = (float(np.abs(np.linalg.eigvals(each)).max()) for each in (before, after))
    return abs(other - one) > TORN * max(1.0, one) and (one < 1.0) != (other < 1.0)


def beside(begin: Beginning, distances: Sequence[float] = BESIDE) -> Beginning:
    """A beginning with its first sample beside the point where it starts, if there is one."""
    best = begin
    for distance in distances:
        found = begin.curve.advance(begin.sample, distance)
        if found is None or not is_inside(begin.curve, found):
            continue
        there = replace(begin, sample=found, before=begin.sample)
        if begin.is_crossing or _sides(found) == _sides(begin.sample):
            return there
        best = there if best is begin else best
    return best


def _sides(sample: Sample) -> tuple[bool, bool]:
    """On which sides of a fold and a flip a cycle lies: beyond one the branch is another one."""
    return Multiplier("LP").value(sample.orbit) > 0.0, Multiplier("PD").value(sample.orbit) > 0.0


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


def _of_cycles(curve: Curve) -> Curve:
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
        inward = own[0].gradients[own[0].place(_border_code(curve, i, len(own)))]
        way = way / np.linalg.norm(way) + TILT * inward / np.linalg.norm(inward)
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


def _arriving(curve: Curve, sample: Sample, before: Sequence[Image]) -> tuple[Floats, Floats]:
    """Where the orbit of a limit comes to after some images, and how that moves (d + k,)."""
    orbit = sample.orbit
    point, d = orbit.x[-1], orbit.x.shape[1]
    way = curve.motion(sample, len(orbit.x) - 1)
    for image in before:
        way = np.append(image.jacobian @ way, way[d:])
        point = image.value
    return point, way


def _border_code(curve: Curve, image: int, rounds: int) -> int:
    """Which margin of the piece on one side of a jump vanishes along its crossing."""
    return min(code for i, code in curve.ignored if i == image) // rounds


def _cause(arc: Arc) -> str:
    """What happens where an arc ends at a border."""
    image, code = arc.border or min(arc.curve.ignored)
    return arc.samples[-1].orbit.taken[image].piece.cause(code)
