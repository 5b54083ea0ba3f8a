"""What a branch ends at, and how it passes places where borders accumulate.

There the map has no germ: the continuation is sought at growing distances beyond the place.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pwmap.diagrams.diagram import PointKind, PointStatus
from woodpecker.base.arrays import Floats
from woodpecker.engine.curves import Arc, Sample, SolutionCurve, Stop
from woodpecker.engine.germs import Beginning, crossings_at, is_inside, lost_beyond
from woodpecker.engine.maps import ACCUMULATE, SpaceImage, SpaceMap
from woodpecker.engine.newton import Problem, Solution, solve
from woodpecker.engine.orbits import Chained, Closed, Held, SpaceOrbit, with_unknowns

MISSED = "what starts there may be missed"
APART = 1e-3  # one minus the cosine of the angle of normals, above which borders are two
BESIDE = tuple(2.0**-n for n in (20, 24, 28, 34, 40, 46))  # scaled: where first samples lie
# Scaled: how far branches are continued over a place. Pieces that accumulate there are as thin as
# they are near it: a branch that begins only farther off is another one.
PASSED = tuple(10.0**-n for n in range(11, 4, -1))
# The same for crossings, whose own border does not depend on the pieces that accumulate.
PASSED_ALONG = tuple(10.0**-n for n in range(11, 1, -1))
CORNER = tuple(10.0**-n for n in range(8, 1, -1))  # scaled: how far from a corner a jump is sought
# Scaled: how far along the border of a crossing that ends at once another one is sought.
ALONG = tuple(2.0**-n for n in range(32, 15, -1))
JUST_AHEAD = 2.0**-20  # scaled: curves that are given up are closer than this to the end of a piece
# Scaled: of the borders that accumulate at a corner some stay this close to each other. The gap to
# others closes: extrapolated by tangents to the corner, at most this part of it is left; negative
# if it closes like a higher power.
ADJACENT, CLOSES = 1e-8, 0.5
# Scaled: a border is that by which a crossing came to a corner if both agree to the first number at
# the last sample that is farther from it than the second. Others part there, if only by the square
# of the distance.
ROUNDED, AT_CORNER = 1e-12, 1e-4
SAMPLES_BEFORE_CORNER = 64  # samples before a corner beside which a jump is sought, at most
FASTEST = 10.0  # scaled |dx/dp| of a branch across such a place, at most
LIMIT_LOST = "a limit of the jump is lost"


@dataclass(frozen=True, slots=True, eq=False)
class Arrival:
    """What a branch ends at, with the fields of :class:`pwmap.diagrams.diagram.SpecialPoint`."""

    kind: PointKind
    orbit: SpaceOrbit  # at the point; at a collision the cycle in its least period
    note: str = ""
    cause: str = ""
    precision: float = 0.0
    status: PointStatus = PointStatus.LOCATED
    onward: Beginning | None = None  # continuation of the branch, if it is known

    @property
    def collides(self) -> bool:
        """Whether a cycle meets a border there, at which other curves start."""
        return self.kind is PointKind.BC


Continuation = tuple[Beginning, str, bool]
"""Where a branch goes on, why its word changes, and whether smoothly."""


def given_up(arc: Arc, note: str = "", cause: str = "") -> Arrival:
    """The end point at the end of an arc, and why the branch ends if nothing goes on there."""
    is_open = arc.stop.is_open or bool(note)
    return Arrival(
        PointKind.EP, arc.samples[-1].orbit, note or arc.stop.value, cause or _obstacle(arc),
        arc.precision, PointStatus.OPEN if is_open else PointStatus.LOCATED,
    )  # fmt: skip


def _obstacle(arc: Arc) -> str:
    """Why pieces end, or are no longer those of the map, just ahead of the end of an arc."""
    end, curve = arc.samples[-1], arc.curve
    if arc.stop not in (Stop.SHORT, Stop.OTHER_PIECE) or not np.isfinite(end.tangent).all():
        return ""
    ahead = with_unknowns(end.orbit, curve.problem.stepped(end.orbit, JUST_AHEAD * end.tangent))
    reason = next((image.reason for image in ahead.all_images if image.reason), "")
    return reason or (_other_piece(curve, ahead) if arc.stop is Stop.OTHER_PIECE else "")


def _other_piece(curve: SolutionCurve, orbit: SpaceOrbit) -> str:
    """Which piece the map takes in place of one of an orbit; empty if it takes all of them."""
    at_border = {orbit.point_of(i) for i, _ in curve.ignored}
    for i, (x, own) in enumerate(zip(orbit.x, orbit.images, strict=True)):
        if i in at_border or curve.takes(x, orbit.p, own):
            continue
        there = curve.map.at(x, orbit.p)
        if there.reason:
            return there.reason
        if there.piece.key == own.piece.key:
            return f"the map takes another solution of the events {own.piece.word}"
        beyond = own.codes[own.margins <= 0.0].tolist()
        why = own.piece.cause(beyond[0]) if beyond else "though no margin of it vanishes"
        taken = "another piece" if there.piece.word == own.piece.word else there.piece.word
        return f"the map takes {taken} in place of {own.piece.word}, {why}"
    return ""


def cause_of(arc: Arc) -> str:
    """A sentence on what happens at the border at which an arc ends."""
    image, code = arc.border or min(arc.curve.ignored)
    return arc.samples[-1].orbit.all_images[image].piece.cause(code)


def causes_of(arc: Arc) -> str:
    """The same where a branch ends, with what happens at other borders there."""
    # Beyond two roots, as where a symmetric motion grazes two walls, no piece has a limit.
    assert arc.border is not None
    i, code = arc.border
    orbit, lengths = arc.samples[-1].orbit, arc.curve.problem.lengths
    image = orbit.images[i]
    tied = image.tied(orbit.x[i], orbit.p)
    normals, own = image.gradients[tied] * lengths, image.gradients[image.index_of(code)] * lengths
    sizes = np.linalg.norm(normals, axis=1) * np.linalg.norm(own)
    apart = np.abs(normals @ own) < (1.0 - APART) * sizes
    codes = sorted({code, *image.codes[tied][apart].tolist()})  # whichever rounding puts first
    causes = list(dict.fromkeys(map(image.piece.cause, codes)))
    return causes[0] if len(causes) == 1 else f"{' and '.join(causes)}: {MISSED}"


def of_cycles(curve: SolutionCurve) -> SolutionCurve:
    """The curve with the equations of cycles in place of its own."""
    problem = replace(curve.problem, conditions=(Closed(),))
    return replace(curve, problem=problem, ignored=frozenset())


def over_accumulation(
    begin: Beginning, arc: Arc, way: Sequence[Sample], cause: str, outer: SpaceImage | None = None
) -> Arrival | Continuation | None:
    """The nearest continuation of a branch beyond borders that accumulate; None if none is near."""
    # It is sought ahead at growing distances, with the pieces that the map takes there. The first
    # cycle found decides: if it lies too far aside it belongs to another branch.
    end, curve = arc.samples[-1], begin.curve
    if begin.is_crossing:
        return crossing_beyond(begin, arc, cause)
    (column,), problem = curve.problem.free, curve.problem
    size, rate = end.orbit.x.size, end.rate
    low, high = curve.settings.spans[0]
    if rate == 0.0:
        return None
    for away, slope in _directions(end, way, problem):
        p = end.orbit.p.copy()
        p[column] = min(
            max(p[column] + math.copysign(away, rate) * problem.p_scale[column], low), high
        )
        if p[column] == end.orbit.p[column]:
            return None
        x = end.orbit.x + (p[column] - end.orbit.p[column]) * slope
        images = [curve.map.at(point, p) for point in x]
        if outer is not None and arc.border is not None:
            images[arc.border[0]] = outer.piece.at(x[arc.border[0]], p)
        if any(image.reason for image in images):
            continue
        held = problem.with_(Held(size + column, float(p[column])))
        found = solve(held, SpaceOrbit(x, p, 0.0, tuple(images)))
        if found.converged and curve.agrees(found.orbit):
            if not problem.same(found.orbit.x, end.orbit.x, FASTEST * away):
                return None
            sample = curve.start(found.orbit, np.eye(size + 1)[-1] * rate)
            if not np.isfinite(sample.tangent).all():
                return None  # a continuum of cycles
            if is_inside(curve, sample):  # beside a grazing the curve may end again at once
                return Beginning(begin.order, curve, sample, end), _passed(cause), True
    return None


def _directions(
    end: Sample, way: Sequence[Sample], problem: Problem
) -> Iterator[tuple[float, Floats]]:
    """Scaled distances ahead, each with a dx/dp (n, d) that may lead there from an end of a way."""
    (column,) = problem.free
    turned = end.tangent[: end.orbit.x.size].reshape(end.orbit.x.shape) * problem.x_scale
    for away in PASSED:
        yield away, turned / (end.rate * problem.p_scale[column])
    # Close to accumulating borders a tangent may tell the direction between two of them only: then
    # take that from a sample as far back.
    back = [end]
    for sample in way[-2::-1]:
        if sample.orbit.x.shape != end.orbit.x.shape:
            break
        back.append(sample)
    p = np.array([sample.orbit.p[column] for sample in back])
    for away in PASSED:
        far = np.flatnonzero(np.abs(p - p[0]) >= away * problem.p_scale[column])
        if len(far):
            k = int(far[0])
            yield away, (back[k].orbit.x - end.orbit.x) / (p[k] - p[0])


def _passed(cause: str) -> str:
    return cause if cause == ACCUMULATE else f"{cause}: {ACCUMULATE}"


def crossing_beyond(
    begin: Beginning, arc: Arc, cause: str, distances: Sequence[float] = PASSED_ALONG
) -> Arrival | Continuation | None:
    """The crossing on the same border beyond borders that accumulate, between its limits there."""
    end, curve = arc.samples[-1], begin.curve
    problem, size = curve.problem, end.orbit.x.size
    (column,), rate = problem.free, end.rate
    if rate == 0.0 or end.orbit.x.shape[1] > 1:  # only in R^1 does the border alone locate it
        return None
    base, arrived = of_cycles(curve), replace(begin, sample=end)
    low, high = curve.settings.spans[0]
    for away in distances:
        to = float(end.orbit.p[column]) + math.copysign(away, rate) * problem.p_scale[column]
        to = min(max(to, low), high)
        if to == end.orbit.p[column]:
            return None
        found = _border_at(arrived, to)
        if not found.converged:
            continue
        there = found.orbit
        for each in crossings_at(base, there.x, there.p, begin.order):
            sample = each.curve.start(each.sample.orbit, np.eye(size + 1)[size] * rate)
            if not _has_ended(arc, sample) and is_inside(each.curve, sample):
                return replace(each, sample=sample, before=end), _passed(cause), True
        reason = lost_beyond(base.map, there.x[-1], there.p, begin.order - len(there.x))
        if reason:
            p = float(there.p[column])
            return Arrival(
                PointKind.FALL, end.orbit, reason, LIMIT_LOST,
                abs(p - float(end.orbit.p[column])),
            )  # fmt: skip
    return None


def _border_at(crossing: Beginning, p: float) -> Solution:
    """The orbit, up to the border of a crossing, at another value of the parameter."""
    problem, orbit = crossing.curve.problem, crossing.sample.orbit
    held = Held(orbit.x.size + problem.free[0], p)
    border = replace(problem, conditions=(Chained(), *problem.conditions[1:], held))
    return solve(border, replace(orbit, outer=None, share=0.0))


def leads_back(way: Sequence[Sample], crossing: Beginning) -> bool:
    """Whether a crossing in R^1 leads back along the samples (n,) that led to its start."""
    # The map may take other pieces there, so that they do not tell.
    end, problem = way[-1].orbit, crossing.curve.problem
    (column,), d = problem.free, end.x.shape[1]
    for sample in way[-2::-1] if d == 1 else ():
        there = sample.orbit
        back = float(there.p[column] - end.p[column]) / problem.p_scale[column]
        length = max(abs(back), problem.apart(there.x[0], end.x[0]))
        if length > AT_CORNER:  # some are closer: the corner itself may have been met before
            if not back * crossing.sample.rate > 0.0:
                return False
            found = _border_at(crossing, float(there.p[column]))
            return found.converged and problem.same(found.orbit.x[0], there.x[0], ROUNDED)
    return False


def _has_ended(arc: Arc, sample: Sample) -> bool:
    """Whether a crossing is the one that ended at a border, found again and leading out there."""
    # It may be found: beside a root the place of the border is known to the root of rounding only.
    if arc.border is None or sample.orbit.keys != arc.samples[-1].orbit.keys:
        return False
    return arc.curve.rate(sample, *arc.border) < 0.0


def round_corner(
    begin: Beginning, arc: Arc, way: Sequence[Sample], cause: str,
    widths: Sequence[float] = CORNER,
) -> Continuation | None:  # fmt: skip
    """The jump crossing on another border that leaves the corner at which its own border ends."""
    # Many steep margins may vanish at the corner. So the jump is sought at a distance, both ahead
    # and beside the last samples: there the piece between the two borders becomes ever thinner.
    end, problem = arc.samples[-1], begin.curve.problem
    d, (column,) = end.orbit.x.shape[1], problem.free
    if d > 1 or end.rate == 0.0:
        return None
    p, x = float(end.orbit.p[column]), float(end.orbit.x[0, 0])
    # the sample beside which the jump is sought, or None; a parameter; an interval of x_0
    places = list[tuple[Sample | None, float, float, float]]()
    for away in CORNER:
        step, width = math.copysign(away, end.rate), FASTEST * away * problem.x_scale[0]
        places.append((None, p + step * problem.p_scale[column], x - width, x + width))
    for sample in arc.samples[-2 : -2 - SAMPLES_BEFORE_CORNER : -1]:
        back, at = float(sample.orbit.p[column]), float(sample.orbit.x[0, 0])
        if back == p:
            continue  # at the corner's parameter there is no direction to leave it
        close = BESIDE[-1] * problem.x_scale[0]
        for width in (each * problem.x_scale[0] for each in widths):
            places += [(sample, back, at + close, at + width)]
            places += [(sample, back, at - width, at - close)]
    last_choice: Continuation | None = None
    for own, to, low, high in places:
        found = _passing(begin, end, to, low, high)
        if found is None:
            continue
        size = found.sample.orbit.x.size
        sample = found.curve.start(found.sample.orbit, np.eye(size + 1)[-1] * (to - p))
        if not _has_ended(arc, sample) and _closes_in(problem, sample, own, end):
            leaving = replace(found, sample=sample)
            rounded = replace(leaving, before=end), cause, False
            if not leads_back(way, leaving):
                return rounded
            last_choice = last_choice or rounded
    return last_choice  # beside a thin piece its two borders may not be told apart


def along_tangent(
    begin: Beginning, arc: Arc, way: Sequence[Sample], cause: str, other: Beginning
) -> Continuation | None:
    """The crossing that leaves a corner tangentially to another one, which ends there at once."""
    # Beyond a border with a root a jump parts from it like a square. The thin piece between both
    # does not show in the germ of the corner: those on either side seem to meet along the border.
    ahead = (other.curve.advance(other.sample, away) for away in ALONG)
    samples = *(sample for sample in ahead if sample is not None), arc.samples[-1]
    found = round_corner(begin, replace(arc, samples=samples), way, cause, PASSED)
    return None if found is None or leads_back(way, found[0]) else found


def _closes_in(problem: Problem, found: Sample, own: Sample | None, corner: Sample) -> bool:
    """Whether a crossing in R^1 leads to the corner at which another one ended, by its tangent."""
    # Then its gap to the sample beside it, or to the corner, shrinks towards the corner.
    if found.rate == 0.0 or (own is not None and own.rate == 0.0):
        return False
    (column,), beside = problem.free, own or corner
    gap = float(found.orbit.x[0, 0] - beside.orbit.x[0, 0]) / problem.x_scale[0]
    way = float(corner.orbit.p[column] - found.orbit.p[column]) / problem.p_scale[column]
    slope = found.tangent[0] / found.rate
    if own is not None:
        slope -= own.tangent[0] / own.rate
    return bool(abs(gap) <= ADJACENT or (gap + slope * way) * gap <= CLOSES * gap * gap)


def _passing(begin: Beginning, end: Sample, to: float, low: float, high: float) -> Beginning | None:
    """The jump crossing at a parameter with its first point in an interval, or None."""
    (column,), base, p = begin.curve.problem.free, of_cycles(begin.curve), end.orbit.p.copy()
    p[column] = to
    head = _border_by_bisection(base.map, p, begin.order, low, high)
    if head is None:
        return None
    return next(iter(crossings_at(base, head, p, begin.order)), None)


def _border_by_bisection(
    map_: SpaceMap, p: Floats, order: int, low: float, high: float
) -> Floats | None:
    """The orbit (n, 1), up to the border, of the point where P_order jumps past it, or None."""
    # Bisection down to neighbouring doubles: at the border their orbits part.

    def off(at: float) -> float:
        point = np.array([at])
        for _ in range(order):
            image = map_.at(point, p)
            if image.reason:
                return math.nan
            point = image.value
        return float(point[0]) - at

    below = off(low)
    if not below * off(high) < 0.0:
        return None
    while low < (middle := 0.5 * (low + high)) < high:
        value = off(middle)
        if math.isnan(value):
            return None
        if below * value > 0.0:
            low = middle
        else:
            high = middle
    one, other, head = np.array([low]), np.array([high]), list[Floats]()
    for _ in range(order):
        head.append(one)
        images = map_.at(one, p), map_.at(other, p)
        if images[0].piece.key != images[1].piece.key:
            return np.array(head)
        one, other = images[0].value, images[1].value
    return None
