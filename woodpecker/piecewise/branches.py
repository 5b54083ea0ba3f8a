"""Branches from special point to special point: orbits followed from piece to piece.

Where a cycle meets a border at which the map is continuous it goes on with the piece beyond. At a
jump it ends, in a border collision; its points up to the border are the border orbit with which
branches of jumps begin, and the other way round, so nothing is searched for there.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from pwmap.diagrams.diagram import BranchKind, PointKind, PointStatus
from woodpecker.base.arrays import Floats
from woodpecker.piecewise.borders import STEEP, Border, BorderKind, beyond
from woodpecker.piecewise.corners import leaving
from woodpecker.piecewise.jumps import Jump
from woodpecker.piecewise.orbits import (
    Closed,
    Condition,
    Coordinate,
    Margin,
    Orbit,
    blurred,
    minimal_period,
    scales,
    solve,
    tangent,
)
from woodpecker.piecewise.pieces import Image, Piece, PiecewiseMap
from woodpecker.piecewise.settings import Settings
from woodpecker.piecewise.stepping import (
    BLURRED,
    FLIP,
    RESOLVED,
    Sample,
    Stepper,
    Stop,
    StopRule,
    Stretch,
)

TORN = 0.01  # part by which a multiplier changes beyond a border only if slopes differ: over the
# distance of a restart it changes by some 1e-4
SHRINK = 0.01  # of a distance from a border, if there is no orbit of the piece beyond at it
NOTHING_BEYOND = "no branch beyond a border"
PASSED_OVER = "borders accumulate"
MEET = "borders meet, closer than can be resolved"
FASTEST = 10.0  # |dx/dp|, scaled, of a branch beyond a place where borders accumulate, at most
GROW = 10.0  # of a distance from a place where borders accumulate
TIGHT = 0.01  # of the distance from a border at which a piece is asked for: a corner's first circle
SAME_WAY = 0.9  # cosine of the angle within which a jump at a corner is the one that led there
HELD = 0.1  # part of a distance from a border by which an orbit moves at most when it is corrected
ROOTED = 10.0  # times the slope beyond a border, that of a square root next to it is larger
GIVEN_UP = frozenset({Stop.SHORT, Stop.OTHER_PIECE, Stop.MANY})
LIMIT_LOST = "a limit of the jump is lost"
ON_LOWER = "a cycle of a multiple period ends on one of smaller period"


@dataclass(frozen=True, slots=True)
class Mark:
    """A change of word on a branch that is no special point.

    Attributes
    ----------
    sample
        Index of the sample at the border; the word changes after it.
    cause
        A sentence on what happens there.
    kind
        What the map does at the border.
    """

    sample: int
    cause: str
    kind: BorderKind


@dataclass(frozen=True, slots=True, eq=False)
class Word:
    """A stretch of a branch along which no piece changes.

    Attributes
    ----------
    first
        Its first sample; a sample at a border has the pieces before it.
    text
        The words of its pieces.
    keys
        The keys of the pieces of a cycle; of a jump those of the points before the border, and a
        set of those on its two sides with the margins that vanish, for a piece has two ends.
    pieces
        The pieces of a cycle, or of the points up to the border of a jump.
    """

    first: int
    text: str
    keys: tuple[object, ...]
    pieces: tuple[Piece, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Collision:
    """A cycle that meets a jump.

    Attributes
    ----------
    orbit
        The cycle, of minimal period, under the piece inside.
    margin
        Which of its points lies on the border, and which margin of its piece vanishes there.
    kinds
        For each point of the orbit the code of the special point, and whether branches fold or
        persist: the jump of P_n at one point can lie on the other side than that at the next.
    cause
        A sentence on what happens there.
    """

    orbit: Orbit
    margin: Margin
    kinds: tuple[tuple[PointKind, str], ...]
    cause: str

    def kind_at(self, x: float) -> tuple[PointKind, str]:
        """Code and note at the point nearest to a place."""
        return self.kinds[int(np.argmin(np.abs(self.orbit.x - x)))]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class End:
    """What ends a branch.

    Attributes
    ----------
    kind, note, cause
        The code of the special point, what it leaves open, and a sentence on what happens there.
    p, x
        Parameter, and the points (n,) of the orbit; of a jump the first one only counts.
    precision
        How well the parameter is located, if that is known already; else 0.
    status
        Whether it is located, or the branch was given up here.
    collision
        The cycle that meets a jump, if one does.
    """

    kind: PointKind
    p: float
    x: Floats
    note: str = ""
    cause: str = ""
    precision: float = 0.0
    status: PointStatus = PointStatus.LOCATED
    collision: Collision | None = None

    def at(self, x: float) -> End:
        """The same as one of the points of its orbit sees it."""
        if self.collision is None:
            return self
        kind, note = self.collision.kind_at(x)
        return replace(self, kind=kind, note=note)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Curve:
    """A branch between two special points.

    Attributes
    ----------
    kind, order
        Cycles of P_order, or jumps of it.
    parameter, multiplier
        Samples (m,), the ends included; the multiplier of a jump is nan.
    points
        m times the points (n,) of a cycle, or those up to the border of a jump.
    words
        Stretches between changes of word, in this order.
    marks
        These changes, one less.
    ends
        Why it begins and ends.
    """

    kind: BranchKind
    order: int
    parameter: Floats
    points: tuple[Floats, ...]
    multiplier: Floats
    words: tuple[Word, ...]
    marks: tuple[Mark, ...]
    ends: tuple[End, End]


@dataclass(frozen=True, slots=True, eq=False)
class Leg:
    """A branch from a sample on, one way, to a special point.

    Attributes
    ----------
    samples, marks
        Samples, the special point included, and changes of word.
    end
        The special point.
    following
        The first samples of the branch that continues it; empty if none does.
    stop
        What ended it.
    """

    samples: tuple[Sample, ...]
    marks: tuple[Mark, ...]
    end: End
    following: tuple[Sample, ...]
    stop: Stop


def _legs(
    follow: Callable[[tuple[Sample, ...], Sample, Stop | None], Leg],
    first: tuple[Sample, ...], origin: Sample, ignored: Stop | None, settings: Settings,
) -> list[Leg]:  # fmt: skip
    """Legs one after the other, each from the end of the one before, until none continues it.

    A branch can come to run round without passing its origin: it is followed once round.
    """
    found = [follow(first, origin, ignored)]
    while found[-1].following:
        last = found[-1]
        if any(_repeats(last, other, settings) for other in found[:-1]):
            found[-1] = replace(last, following=())
            break
        found.append(follow(last.following, origin, last.stop))
    return found


def _repeats(leg: Leg, other: Leg, settings: Settings) -> bool:
    """Whether a leg ends where another one did, and goes on like it."""
    one, two = leg.following[-1], other.following[-1]
    scale = scales(len(one.orbit), settings)
    return (
        leg.stop is other.stop
        and one.orbit.keys == two.orbit.keys
        and float(np.abs((one.orbit.point - two.orbit.point) / scale).max()) <= settings.same
        and float(one.tangent @ two.tangent) > 0.0
    )


# --- Cycles ---------------------------------------------------------------------------------------


class Cycles:
    """Follows branches of cycles.

    Parameters
    ----------
    map_, settings
        The map, and how to follow it.
    stop
        Whether to end somewhere, if anybody asks for it.
    """

    def __init__(
        self, map_: PiecewiseMap, settings: Settings, stop: StopRule | None = None
    ) -> None:
        self.map, self.settings = map_, settings
        self.stepper = Stepper(map_, Closed(), settings, [FLIP], stop=stop)

    def through(self, orbit: Orbit) -> list[Curve]:
        """The branch through a cycle, both ways, with those that continue it."""
        start = self.stepper.sample(orbit, np.eye(len(orbit) + 1)[-1])
        ahead = self.legs((start,), start)
        closes = ahead[-1].stop is Stop.CLOSED
        behind = [] if closes else self.legs((turned(start),), start)
        return curves_of(ahead, behind, BranchKind.FIXED_POINT, len(orbit))

    def ahead(self, start: tuple[Sample, ...], end: End) -> list[Curve]:
        """The branch from a special point on, with those that continue it."""
        legs = self.legs(start, start[-1], Stop.BORDER)
        return curves_from(end, legs, BranchKind.FIXED_POINT, len(start[0].orbit))

    def legs(
        self, first: tuple[Sample, ...], origin: Sample, ignored: Stop | None = None
    ) -> list[Leg]:
        """Follow a branch one way, across special points that it passes."""
        return _legs(self._leg, first, origin, ignored, self.settings)

    def _leg(self, first: tuple[Sample, ...], origin: Sample, ignored: Stop | None) -> Leg:
        samples, marks, step = list(first), list[Mark](), math.inf
        while True:
            stretch = self.stepper.follow(samples[-1], ignored, origin, step)
            ignored, step = None, max(stretch.step, self.settings.again)
            stretch = self._sharpened(_at_nearest(stretch, self.settings))
            samples += stretch.samples[1:]
            if stretch.stop in (Stop.SHORT, Stop.OTHER_PIECE):
                there = self._passed_over(stretch)
                if there is not None:
                    marks.append(Mark(len(samples) - 1, PASSED_OVER, BorderKind.SMOOTH))
                    samples.append(there)
                    continue
            if stretch.stop is not Stop.BORDER:
                passes = stretch.stop in (Stop.FOLD, Stop.FLIP, Stop.BRANCHING)
                passes &= not self._halves(stretch)
                here, on = self._end(stretch), (samples[-1],) if passes else ()
                return Leg(tuple(samples), tuple(marks), here, on, stretch.stop)
            mark, end, there = self._meet(stretch)
            if end is not None and end.status is PointStatus.OPEN:
                there = self._passed_over(stretch)
                if there is not None:
                    mark = replace(mark, cause=f"{mark.cause}: {PASSED_OVER}")
                    before, after = samples[-1].orbit.multiplier, there.orbit.multiplier
                    changes = _changes_stability(before, mark.kind, after)
                    persists = end_at(PointKind.BC, stretch.end, "persistence", mark.cause)
                    end = persists if changes else None
            if end is not None:
                begin = self._across(stretch) if end.kind is PointKind.BC else samples[-1]
                following = () if there is None else (begin, there)
                return Leg(tuple(samples), tuple(marks), end, following, stretch.stop)
            assert there is not None
            marks.append(replace(mark, sample=len(samples) - 1))
            samples.append(there)

    def _meet(self, stretch: Stretch) -> tuple[Mark, End | None, Sample | None]:
        """What happens to a branch at a border, whether that is special, and where it goes on."""
        orbit, margin, last = stretch.end, stretch.margins[0], stretch.samples[-1]
        border = border_at(self.map, orbit, margin, self.settings)
        kind = border.kind(self.settings)
        mark = Mark(sample=0, cause=border.cause, kind=kind)
        if self._halves(stretch):
            return mark, end_at(PointKind.BC, orbit, ON_LOWER, border.cause), None
        if kind is BorderKind.LOST:
            lost = end_at(PointKind.FALL, orbit, border.outer.reason, border.cause)
            return mark, lost, None
        if kind is BorderKind.JUMP:
            met = collision(self.map, orbit, margin, border, self.settings)
            return mark, end_of(met, orbit), None
        there = restart(orbit, Closed(), border, margin.index, self.settings)
        if there is None:
            met = collision(self.map, orbit, margin, border, self.settings)
            if any(note for _, note in met.kinds):  # the jump vanishes just where a cycle meets it
                return mark, end_of(met, orbit), None
            note = NOTHING_BEYOND if border.outer_code >= 0 else PASSED_OVER
            lost = end_at(PointKind.EP, orbit, note, border.cause, PointStatus.OPEN)
            return mark, lost, None
        note = "fold" if last.tangent[-1] * there.tangent[-1] < 0.0 else "persistence"
        if note == "fold" or _changes_stability(_inside(stretch), kind, there.orbit.multiplier):
            end = end_at(PointKind.BC, orbit, note, border.cause)
            return mark, replace(end, precision=self._blur(orbit, border, margin)), there
        return mark, None, there

    def _across(self, stretch: Stretch) -> Sample:
        """The sample at the end as the branch beyond begins with it: with the piece beyond."""
        margin, last = stretch.margins[0], stretch.samples[-1]
        border = border_at(self.map, last.orbit, margin, self.settings)
        if border.outer_code < 0 or border.outer.reason:
            return last
        images = _replaced(last.orbit.images, margin.index, border.outer)
        return replace(last, orbit=Orbit(last.orbit.x, last.orbit.p, images))

    def _blur(self, orbit: Orbit, border: Border, margin: Margin) -> float:
        """How well a border is located, by the piece on that side on which it is less steep."""
        i = margin.index
        outer = Orbit(orbit.x, orbit.p, _replaced(orbit.images, i, border.outer))
        if abs(border.outer.slope) < abs(orbit.images[i].slope):
            orbit, margin = outer, Margin(i, border.outer_code)
        return located_to(orbit, (Closed(), margin), self.settings)

    def _sharpened(self, stretch: Stretch) -> Stretch:
        """A stretch that ends at a square root, with its end as the piece beyond locates it.

        The map is continuous there, and the piece beyond is not steep: it is not rounding of the
        root that decides.
        """
        orbit = stretch.end
        if stretch.stop is not Stop.BORDER:
            return stretch
        margin = stretch.margins[0]
        i, image = margin.index, orbit.images[margin.index]
        if abs(image.slope) <= ROOTED:
            return stretch
        border = border_at(self.map, orbit, margin, self.settings)
        kind = border.kind(self.settings)
        if kind in (BorderKind.JUMP, BorderKind.LOST) or border.outer_code < 0:
            return stretch
        if abs(image.slope) <= ROOTED * max(1.0, abs(border.outer.slope)):
            return stretch
        beyond_it = Orbit(orbit.x, orbit.p, _replaced(orbit.images, i, border.outer))
        root = solve(beyond_it, (Closed(), Margin(i, border.outer_code)), self.settings)
        away = np.abs((root.orbit.point - orbit.point) / scales(len(orbit), self.settings)).max()
        if not (root.converged and away <= self.settings.beside):
            return stretch
        inner = image._replace(value=root.orbit.images[i].value)
        end = Orbit(root.orbit.x, root.orbit.p, _replaced(root.orbit.images, i, inner))
        last = replace(stretch.samples[-1], orbit=end)
        return replace(stretch, samples=(*stretch.samples[:-1], last))

    def _passed_over(self, stretch: Stretch) -> Sample | None:
        """The branch beyond a place where borders accumulate, the nearest there is.

        It is looked for along the tangent, with the pieces that the map takes there.
        """
        end = stretch.samples[-1]
        x_scale, p_scale = self.settings.x_scale, self.settings.p_scale
        sign, (low, high) = (1.0 if end.tangent[-1] > 0.0 else -1.0), self.settings.span
        away, limit = self.settings.same, high if sign > 0.0 else low
        p, slope = end.orbit.p, end.tangent[:-1] * x_scale / (end.tangent[-1] * p_scale)
        while away <= self.settings.max_step and p != limit:
            p = min(max(end.orbit.p + sign * away * p_scale, low), high)
            x = end.orbit.x + (p - end.orbit.p) * slope
            start = Orbit(x, p, tuple(self.map.at(float(each), p) for each in x))
            away *= GROW
            if not start.defined:
                continue
            solution = solve(start, (Closed(), Coordinate(-1, p)), self.settings)
            found = solution.orbit
            aside = float(np.abs(found.x - end.orbit.x).max()) / x_scale
            if solution.converged and is_inside(found, Closed()) and aside <= FASTEST * away:
                return self.stepper.sample(found, sign * np.eye(len(found) + 1)[-1])
        return None

    def _halves(self, stretch: Stretch) -> bool:
        """Whether the cycle at the end, and none before it, goes round one of smaller period."""
        first, last = (
            minimal_period(s.orbit, self.settings)
            for s in (stretch.samples[0], stretch.samples[-1])
        )
        return last < first

    def _end(self, stretch: Stretch) -> End:
        kinds = {
            Stop.FOLD: PointKind.LP, Stop.FLIP: PointKind.PD, Stop.BRANCHING: PointKind.BP,
        }  # fmt: skip
        kind = kinds.get(stretch.stop, PointKind.EP)
        if kind is PointKind.EP:
            return given_up_or_left(stretch, self.settings)
        cause = stretch.stop.value
        if self._halves(stretch):  # a branch of doubled period folds where it began
            kind, cause = PointKind.PD, Stop.FLIP.value
        end = end_at(kind, stretch.end, cause=cause)
        return folded(end, stretch.end, Closed(), self.settings) if kind is PointKind.LP else end


def _replaced(images: tuple[Image, ...], i: int, image: Image) -> tuple[Image, ...]:
    return (*images[:i], image, *images[i + 1 :])


def _at_nearest(stretch: Stretch, settings: Settings) -> Stretch:
    """A stretch whose steps have become too short beside a border, as one that ends there."""
    if stretch.stop not in (Stop.SHORT, Stop.OTHER_PIECE):
        return stretch
    found = list[tuple[float, Margin]]()
    for i, image in enumerate(stretch.end.images):
        with np.errstate(divide="ignore", invalid="ignore"):
            away = image.margins / np.abs(image.gradients[:, 0])
        found += [
            (abs(d), Margin(i, code))
            for d, code in zip(away.tolist(), image.causes.tolist(), strict=True)
        ]
    least, margin = min(found, key=lambda each: each[0], default=(math.inf, None))
    if margin is None or not least <= settings.same * settings.x_scale:
        return stretch
    return replace(stretch, stop=Stop.BORDER, margins=(margin,))


def _inside(stretch: Stretch) -> float:
    """The multiplier on the way to the end of a stretch: at a square root it may be rounding.

    No fold or flip lies between the last two samples, so both are stable or neither is.
    """
    before = stretch.samples[-2:][0].orbit.multiplier
    return stretch.end.multiplier if abs(abs(before) - 1.0) <= TORN else before


def _changes_stability(before: float, kind: BorderKind, after: float) -> bool:
    """Whether a branch is stable on one side of a border only; not where it is smooth there.

    Multipliers that differ by far say that the border is not smooth.
    """
    torn = kind is not BorderKind.SMOOTH or abs(after - before) > TORN * max(1.0, abs(before))
    return torn and (abs(before) < 1.0) != (abs(after) < 1.0)


def cycle_from(met: Collision, settings: Settings) -> tuple[Sample, ...]:
    """The first samples of the branch of cycles that starts at a border, into the piece inside.

    Where that piece begins with a square root its slope at the border is infinite, and the second
    sample lies right beside it.
    """
    direction = tangent(met.orbit, Closed(), settings)
    if not np.isfinite(direction).all():
        return ()
    scale, i = scales(len(met.orbit), settings), met.margin.index
    image = met.orbit.images[i]
    gradient = image.gradient(met.margin.code)
    forward = float(gradient @ (direction * scale)[[i, -1]]) > 0.0
    first = Sample(met.orbit, direction if forward else -direction, forward)
    if abs(image.slope) < STEEP:
        return (first,)
    code, side = met.margin.code, 1 if gradient[0] > 0.0 else -1
    border = Border(float(met.orbit.x[i]), met.orbit.p, image, code, side, image, code)
    there = restart(met.orbit, Closed(), border, i, settings)
    return (first,) if there is None else (first, there)


@dataclass(frozen=True, slots=True, eq=False)
class _Return:
    """An orbit that leads to a border, and from there back to it.

    Attributes
    ----------
    before
        The points before the border; there may be none.
    cycle, code
        The cycle from the border on, and the margin that vanishes at its first point.
    """

    before: Orbit
    cycle: Orbit
    code: int


# --- Jumps ----------------------------------------------------------------------------------------


class Jumps:
    """Follows branches of jumps of P_order that cross the diagonal.

    Parameters
    ----------
    map_, order, settings
        The map, the iterate, and how to follow them.
    stop
        Whether to end somewhere, if anybody asks for it.
    """

    def __init__(
        self, map_: PiecewiseMap, order: int, settings: Settings, stop: StopRule | None = None
    ) -> None:
        self.map, self.order, self.settings, self.stop = map_, order, settings, stop

    def through(self, head: Orbit, closing: Margin) -> list[Curve]:
        """The branch of jumps through a border orbit, both ways, with those that continue it."""
        start = self._sample(head, closing)
        ahead = self.legs((start,), start)
        behind = [] if ahead[-1].stop is Stop.CLOSED else self.legs((turned(start),), start)
        return curves_of(ahead, behind, BranchKind.JUMP, self.order)

    def starts(self, met: Collision, shift: int) -> list[tuple[Sample, Sample]]:
        """Branches that start where a cycle meets a jump, seen from one of its points.

        The orbit may have gone round some times before it meets the border.

        Returns
        -------
        For each the sample at the collision, and the next one.
        """
        n, found = len(met.orbit), []
        orbit = met.orbit.rotated(shift)
        to_border = (met.margin.index - shift) % n
        for length in range(to_border + 1, self.order + 1, n):
            rounds = -(-length // n)
            x, images = np.tile(orbit.x, rounds)[:length], (orbit.images * rounds)[:length]
            head = Orbit(x, orbit.p, images)
            start = self._sample(head, Margin(length - 1, met.margin.code))
            sides = [(sign, self._beside(start, sign)) for sign in (1.0, -1.0)]
            begin = [(sign, there) for sign, there in sides if there is not None]
            if len(begin) == 1:  # one that goes on to both sides only passes
                sign, there = begin[0]
                found.append((start if sign > 0.0 else turned(start), there))
        return found

    def ahead(self, start: tuple[Sample, ...], end: End) -> list[Curve]:
        """The branch from a special point on, with those that continue it."""
        return curves_from(end, self.legs(start, start[-1]), BranchKind.JUMP, self.order)

    def legs(self, first: tuple[Sample, ...], origin: Sample) -> list[Leg]:
        """Follow a branch one way, across folds."""
        return _legs(self._leg, first, origin, None, self.settings)

    def _leg(self, first: tuple[Sample, ...], origin: Sample, ignored: Stop | None) -> Leg:
        samples, marks = list(first), list[Mark]()
        while True:
            last = samples[-1]
            assert last.jump is not None
            stretch = self._stepper(last.jump.closing).follow(last, ignored, origin)
            ignored = None
            samples += stretch.samples[1:]
            if stretch.stop in (Stop.SHORT, Stop.OTHER_PIECE):
                there = self._passed_over(samples[-1], narrow=True)
                if there is not None:
                    marks.append(Mark(len(samples) - 1, MEET, BorderKind.SMOOTH))
                    samples.append(there)
                    continue
            if stretch.stop not in (Stop.BORDER, Stop.TAIL):
                following = (samples[-1],) if stretch.stop is Stop.FOLD else ()
                end = self._end(stretch)
                return Leg(tuple(samples), tuple(marks), end, following, stretch.stop)
            early = self._closed_early(stretch)
            if early is not None and self._passes(early, stretch.end):
                met = self._collision(early)
                return Leg(tuple(samples), tuple(marks), end_of(met, stretch.end), (), stretch.stop)
            mark, there = self._beyond(stretch, early)
            if there is None:
                end = self._lost(stretch) or end_at(
                    PointKind.EP, stretch.end, "the jump ends", mark.cause, PointStatus.OPEN
                )
                return Leg(tuple(samples), tuple(marks), end, (), stretch.stop)
            marks.append(replace(mark, sample=len(samples) - 1))
            samples.append(there)

    def _stepper(self, closing: Margin) -> Stepper:
        return Stepper(self.map, closing, self.settings, order=self.order, stop=self.stop)

    def _sample(self, head: Orbit, closing: Margin, along: Floats | None = None) -> Sample:
        forward = np.eye(len(head) + 1)[-1] if along is None else along
        return self._stepper(closing).sample(head, forward)

    def _beside(self, start: Sample, sign: float = 1.0) -> Sample | None:
        """The next sample of a jump branch, right beside one where it changes; None if it ends.

        It is admissible, and crosses the diagonal.
        """
        base = start if sign > 0.0 else turned(start)
        away = self.settings.beside
        while away >= self.settings.min_step:
            found = self._at(base, away)
            if found is not None:
                return found if self._is_good(found) else None
            away *= SHRINK
        return None

    def _at(self, base: Sample, away: float) -> Sample | None:
        """The sample at a distance along a jump branch; None if there is none."""
        assert base.jump is not None
        if any(image.slope == 0.0 for image in base.orbit.images[:-1]):
            return None  # where the orbit starts does not change where it ends: P_order has no jump
        found = self._stepper(base.jump.closing).advance(base, away)
        return found if isinstance(found, Sample) and found.jump is not None else None

    def _is_good(self, sample: Sample) -> bool:
        """Whether a sample is admissible, and its jump crosses the diagonal."""
        jump = sample.jump
        return jump is not None and jump.crosses and is_inside(sample.orbit, jump.closing)

    def _end(self, stretch: Stretch) -> End:
        if stretch.stop is not Stop.LIMIT:
            if stretch.stop is Stop.FOLD:
                end = end_at(PointKind.LP, stretch.end, cause=stretch.stop.value)
                closing = self._closing_of(stretch)
                return folded(end, stretch.end, closing, self.settings)
            lost = self._lost(stretch) if stretch.stop in GIVEN_UP else None
            return lost or given_up_or_left(stretch, self.settings)
        assert stretch.meeting is not None
        margin = stretch.margins[0]
        border = border_at(self.map, stretch.meeting, margin, self.settings)
        met = collision(self.map, stretch.meeting, margin, border, self.settings)
        return end_of(met, stretch.end)

    def _lost(self, stretch: Stretch) -> End | None:
        """Where a limit of a jump has no value any more; None if it has one.

        Its orbit goes through more and more pieces before, so that no border is the last: the place
        is known as well as the nearest orbit beyond that is lost.
        """
        end, away = stretch.samples[-1], self.settings.same
        while away <= self.settings.beside:
            found = self._at(end, away)
            reason = "" if found is None or found.jump is None else found.jump.lost
            if found is not None and reason:
                lost = end_at(PointKind.FALL, stretch.end, reason, LIMIT_LOST)
                return replace(lost, precision=abs(found.orbit.p - lost.p))
            away *= GROW
        return None

    @staticmethod
    def _closing_of(stretch: Stretch) -> Margin:
        jump = stretch.samples[-1].jump
        assert jump is not None
        return jump.closing

    def _closed_early(self, stretch: Stretch) -> _Return | None:
        """Where the orbit of a jump comes back to its own border; None if it does not."""
        last = stretch.samples[-1].jump
        assert last is not None
        meeting, margin = stretch.meeting or stretch.end, stretch.margins[0]
        own = Margin(last.closing.index, last.code(stretch.inner))
        first, second = sorted((own, margin), key=lambda each: each.index)
        i, k = first.index, second.index
        if i == k or abs(meeting.x[k] - meeting.x[i]) > self.settings.same * self.settings.x_scale:
            return None
        return _Return(
            Orbit(meeting.x[:i], meeting.p, meeting.images[:i]),
            Orbit(meeting.x[i:k], meeting.p, meeting.images[i:k]), first.code,
        )  # fmt: skip

    def _passes(self, early: _Return, head: Orbit) -> bool:
        """Whether an orbit begins on the cycle that it comes round."""
        away = float(np.abs(early.cycle.x - head.x[0]).min())
        return away <= self.settings.same * self.settings.x_scale

    def _collision(self, early: _Return) -> Collision:
        margin = Margin(0, early.code)
        border = border_at(self.map, early.cycle, margin, self.settings)
        return collision(self.map, early.cycle, margin, border, self.settings)

    def _beyond(self, stretch: Stretch, early: _Return | None) -> tuple[Mark, Sample | None]:
        """Where a jump branch goes on when one of its orbits meets another border."""
        end, margin = stretch.samples[-1], stretch.margins[0]
        meeting = stretch.meeting or stretch.end
        assert end.jump is not None
        border = border_at(self.map, meeting, margin, self.settings)
        kind = border.kind(self.settings)
        mark = Mark(sample=0, cause=border.cause, kind=kind)
        there = None
        if early is not None:
            return mark, self._round_cycle(end, early)
        if stretch.stop is Stop.TAIL:
            there = self._beside(end)
        elif margin.index < end.jump.closing.index and kind is not BorderKind.JUMP:
            there = self._restarted(end, border, margin.index)
        if there is None:
            there = self._round_corner(end, meeting, margin)
        return mark, there or self._passed_over(end)

    def _restarted(self, end: Sample, border: Border, index: int) -> Sample | None:
        """Beyond a border at which the map is continuous, met by a point before the jump."""
        assert end.jump is not None
        closing = end.jump.closing
        found = restart(end.orbit, closing, border, index, self.settings)
        if found is None:
            return None
        there = self._sample(found.orbit, closing, found.tangent)
        return there if there.jump is not None and there.jump.crosses else None

    def _passed_over(self, end: Sample, narrow: bool = False) -> Sample | None:
        """The jump beyond a place where one of its pieces ends, the nearest there is.

        The piece on the other side of the border still defines the same jump there, or another jump
        leaves the corner. Infinitely many borders can accumulate at such a place, so the distance
        grows.
        """
        away, bases = TIGHT * self.settings.beside, self._bases(end)
        while away <= self.settings.max_step:
            found = self._from_corner(end, away, narrow) if away <= BLURRED else None
            if found is not None:
                return found
            for base in bases if away >= self.settings.beside else ():
                found = self._at(base, away)
                if found is None or found.jump is None:
                    continue
                if is_inside(found.orbit, found.jump.closing):
                    if found.jump.crosses:
                        return found
                    bases = []  # it ends here
                    break
            away *= GROW
        return None

    def _bases(self, end: Sample) -> list[Sample]:
        """A jump as the pieces on both of its sides define it, that beyond its border first."""
        assert end.jump is not None
        jump, k = end.jump, end.jump.closing.index
        if jump.outer_code < 0:
            return [end]
        images = (*end.orbit.images[:-1], jump.outer.images[0])
        head = Orbit(end.orbit.x, end.orbit.p, images)
        return [self._sample(head, Margin(k, jump.outer_code), end.tangent), end]

    def _from_corner(self, end: Sample, away: float, narrow: bool) -> Sample | None:
        """The jump that leaves a corner where one has come in; None if that is not clear.

        Where just two meet that cross the diagonal it is the other one. Where the piece between two
        becomes so narrow that they are no longer told apart, it is the neighbour, which goes back.
        """
        back = -end.tangent[[0, -1]] / float(np.linalg.norm(end.tangent[[0, -1]]))
        corner = float(end.orbit.x[0]), end.orbit.p
        found = leaving(self.map, corner, self.order, back, away, self.settings)
        found.sort(key=lambda each: float(each.direction @ back), reverse=True)
        if len(found) < 2 or float(found[0].direction @ back) < SAME_WAY:
            return None
        other = found[1]
        if len(found) > 2 and not (narrow and float(other.direction @ back) >= SAME_WAY):
            return None
        along = np.zeros(len(other.head) + 1)
        along[[0, -1]] = other.direction
        there = self._sample(other.head, other.closing, along)
        return there if self._is_good(there) else None

    def _round_cycle(self, end: Sample, early: _Return) -> Sample | None:
        """Where jumps meet whose orbits lead to a cycle on a border: the one that goes on.

        They differ in how often the orbit goes round before it meets the border.
        """
        before, cycle = early.before, early.cycle
        for length in range(len(before) + 1, self.order + 1, len(cycle)):
            rounds = -(-(length - len(before)) // len(cycle))
            x = np.append(before.x, np.tile(cycle.x, rounds))[:length]
            images = (*before.images, *cycle.images * rounds)[:length]
            start = self._sample(Orbit(x, cycle.p, images), Margin(length - 1, early.code))
            for sign in (1.0, -1.0):
                there = self._beside(start, sign)
                back = length == len(end.orbit) and sign * start.tangent @ end.tangent < 0.0
                if there is not None and not back:
                    return there
        return None

    def _round_corner(self, end: Sample, meeting: Orbit, margin: Margin) -> Sample | None:
        """Where two jumps meet: the other one that crosses the diagonal there.

        One of the two borders is met by the orbit of a limit of the other. There is another jump of
        P_order beside the first on one side of the meeting; of the three jumps that meet there an
        even number cross the diagonal.
        """
        assert end.jump is not None
        own = end.jump.closing
        if own.index < margin.index:
            start = self._sample(meeting, margin)
        else:
            n = margin.index + 1
            start = self._sample(Orbit(meeting.x[:n], meeting.p, meeting.images[:n]), margin)
        found = [s for sign in (1.0, -1.0) if (s := self._beside(start, sign)) is not None]
        return found[0] if len(found) == 1 else None


# --- Borders and collisions -----------------------------------------------------------------------


def border_at(map_: PiecewiseMap, orbit: Orbit, margin: Margin, settings: Settings) -> Border:
    """The border that a point of an orbit meets."""
    i = margin.index
    image, x = orbit.images[i], float(orbit.x[i])
    side = -1 if image.gradient(margin.code)[0] > 0.0 else 1
    outer, code = beyond(map_, x, orbit.p, side, settings)
    with np.errstate(divide="ignore", invalid="ignore"):
        away = abs(outer.margin(code) / outer.gradient(code)[0])
    if away > settings.same * settings.x_scale:
        code = -1  # the piece that was found beyond does not begin here: there are others between
    return Border(x, orbit.p, image, margin.code, side, outer, code)


def collision(
    map_: PiecewiseMap, orbit: Orbit, margin: Margin, border: Border, settings: Settings
) -> Collision:
    """The border collision of a cycle with a jump: its minimal orbit, and what kind it is.

    With F the distance of the inner limit from the diagonal at the border and D that of the outer
    one, the jump of P_n crosses the diagonal where they differ in sign, and the fixed point lives
    where F has one sign. If that is on one side of the parameter, branches fold. A branch of
    jumps of P_2n then starts at the preimage of the border just if the multiplier exceeds 1. The
    other points of the cycle see the same F, but a D of their own.
    """
    n = minimal_period(orbit, settings)
    first = int(np.argmin(orbit.x[:n]))
    small = Orbit(orbit.x[:n], orbit.p, orbit.images[:n]).rotated(first)
    index = (margin.index - first) % n
    met = Collision(
        orbit=small, margin=Margin(index, margin.code), kinds=((PointKind.BC, ""),) * n,
        cause=border.cause,
    )  # fmt: skip
    inside = cycle_from(met, settings)
    if not inside:
        return met
    jumps, steep = Jumps(map_, n, settings), abs(small.multiplier) > 1.0
    kinds = []
    for shift in range(n):
        starts = jumps.starts(met, shift)
        sides = {
            bool(sample.tangent[-1] > 0.0) for sample in (inside[-1], *(s[1] for s in starts[:1]))
        }
        fold = PointKind.FF if steep else PointKind.BC
        found = (fold, "fold") if len(sides) == 1 else (PointKind.BC, "persistence")
        kinds.append(found if starts else (PointKind.BC, ""))
    return replace(met, kinds=tuple(kinds))


def end_at(
    kind: PointKind, orbit: Orbit, note: str = "", cause: str = "",
    status: PointStatus = PointStatus.LOCATED,
) -> End:  # fmt: skip
    """A special point that is no collision with a jump."""
    return End(kind=kind, p=orbit.p, x=orbit.x, note=note, cause=cause, status=status)


def located_to(orbit: Orbit, conditions: tuple[Condition, Condition], settings: Settings) -> float:
    """How well the parameter of an orbit is known that obeys two conditions."""
    return max(blurred(orbit, conditions, settings), settings.converged * settings.p_scale)


def folded(end: End, orbit: Orbit, closing: Condition, settings: Settings) -> End:
    """A fold with its precision: an error of x changes its parameter by the square only."""
    held = Coordinate(0, float(orbit.x[0]))
    return replace(end, precision=located_to(orbit, (closing, held), settings))


def given_up_or_left(stretch: Stretch, settings: Settings) -> End:
    """Where a branch leaves the span or the window, closes, or was given up."""
    status = PointStatus.OPEN if stretch.stop in GIVEN_UP else PointStatus.LOCATED
    stop, orbit, jump = stretch.stop.value, stretch.end, stretch.samples[-1].jump
    end = end_at(PointKind.EP, orbit, stop, stop, status)
    if stretch.stop is not Stop.WINDOW:
        return end
    closing = Closed() if jump is None else jump.closing
    i = int(np.argmin(np.min([np.abs(orbit.x - limit) for limit in settings.window], axis=0)))
    conditions = (closing, Coordinate(i, float(orbit.x[i])))
    return replace(end, precision=located_to(orbit, conditions, settings))


def end_of(met: Collision, orbit: Orbit) -> End:
    """A collision with a jump, as an orbit meets it."""
    kind, note = met.kind_at(float(orbit.x[0]))
    return End(kind=kind, p=orbit.p, x=orbit.x, note=note, cause=met.cause, collision=met)


def restart(
    orbit: Orbit, closing: Condition, border: Border, index: int, settings: Settings
) -> Sample | None:
    """The orbit beyond a border, whose margin there is small and positive; None if there is none.

    That is well posed also where the piece beyond begins with a square root. It lies so close to
    the border that no fold or flip is passed that is not one point with the border.
    """
    tiny = border.side * RESOLVED * settings.nearest * settings.x_scale
    right_beside = border.outer.piece.at(border.x + tiny, border.p)  # at a root only there is one
    outer = border.outer if right_beside.reason else right_beside  # slope that rounding leaves
    at_border = Orbit(orbit.x, orbit.p, _replaced(orbit.images, index, outer)).multiplier
    found: Sample | None = None
    away, same = settings.beside * settings.x_scale, settings.same * settings.x_scale
    while away >= settings.nearest * settings.x_scale and (found is None or away >= same):
        there = _restarted(orbit, closing, border, index, away, settings)
        if there is not None:  # from here the piece is followed back: at a root it may start badly
            found, border = there, replace(border, outer=_led_back(there, border, index))
        if there is not None and _sides(there.orbit.multiplier) == _sides(at_border):
            return there
        away *= SHRINK
    return found


def _led_back(there: Sample, border: Border, index: int) -> Image:
    """The image of a border beyond, whose piece continues from an orbit that was found there."""
    return border.outer._replace(piece=there.orbit.images[index].piece)


def _sides(multiplier: float) -> tuple[bool, bool]:
    """On which sides of a fold and a flip a multiplier lies."""
    return multiplier > 1.0, multiplier > -1.0


def _restarted(
    orbit: Orbit, closing: Condition, border: Border, index: int, away: float, settings: Settings
) -> Sample | None:
    """The orbit about a distance beyond a border; None if there is none that is admissible."""
    x, images = orbit.x.copy(), list(orbit.images)
    x[index] += border.side * away
    images[index] = border.outer.piece.at(float(x[index]), orbit.p)
    value = images[index].margin(border.outer_code)
    if not value > 0.0:
        return None
    margin = Margin(index, border.outer_code, value)
    solution = solve(Orbit(x, orbit.p, tuple(images)), (closing, margin), settings)
    found = solution.orbit
    held = solve(found, (closing, Coordinate(-1, found.p)), settings)
    moves = np.abs(held.orbit.x - found.x).max()
    if held.converged and moves <= HELD * away:  # beside a square root a margin cannot be held to
        found = held.orbit  # the last bit, the parameter can, unless the branch turns round there
    direction = tangent(found, closing, settings)
    if not (solution.converged and np.isfinite(direction).all() and is_inside(found, closing)):
        return None
    forward = float(direction @ ((found.point - orbit.point) / scales(len(orbit), settings))) > 0.0
    return Sample(found, direction if forward else -direction, forward)


def is_inside(orbit: Orbit, closing: Condition) -> bool:
    """Whether all margins are positive, but for the one at the end of a border orbit."""
    for i, image in enumerate(orbit.images):
        own = closing.code if isinstance(closing, Margin) and closing.index == i else -1
        if ((image.margins < 0.0) & (image.causes != own)).any():
            return False
    return True


def turned(sample: Sample) -> Sample:
    """The same sample on the way back."""
    return replace(sample, tangent=-sample.tangent, forward=not sample.forward)


def word_of(orbit: Orbit) -> str:
    """The words of all pieces."""
    return " | ".join(orbit.words)


# --- Curves ---------------------------------------------------------------------------------------


def curves_of(ahead: list[Leg], behind: list[Leg], kind: BranchKind, order: int) -> list[Curve]:
    """Curves from the legs both ways from one sample, or all round."""
    if not behind and len(ahead) == 1:
        end = ahead[0].end
        return [_curve(ahead[0].samples, ahead[0].marks, (end, end), kind, order)]
    if not behind:
        last, ahead = ahead[-1], ahead[:-1]
        first = [_joined(last, ahead[0], (ahead[-1].end, ahead[0].end), kind, order)]
        return first + _rest(ahead, kind, order)
    back = _reversed(behind[0])
    middle = _joined(back, ahead[0], (behind[0].end, ahead[0].end), kind, order)
    return [middle, *_rest(ahead, kind, order), *_rest(behind, kind, order)]


def curves_from(end: End, legs: list[Leg], kind: BranchKind, order: int) -> list[Curve]:
    """Curves from the legs that start at a special point."""
    first = _curve(legs[0].samples, legs[0].marks, (end, legs[0].end), kind, order)
    return [first, *_rest(legs, kind, order)]


def _rest(legs: list[Leg], kind: BranchKind, order: int) -> list[Curve]:
    return [
        _curve(leg.samples, leg.marks, (before.end, leg.end), kind, order)
        for before, leg in pairwise(legs)
    ]


def _reversed(leg: Leg) -> Leg:
    n = len(leg.samples)
    marks = tuple(replace(mark, sample=n - 2 - mark.sample) for mark in reversed(leg.marks))
    return replace(leg, samples=leg.samples[::-1], marks=marks)


def _joined(one: Leg, other: Leg, ends: tuple[End, End], kind: BranchKind, order: int) -> Curve:
    n = len(one.samples) - 1
    marks = (*one.marks, *(replace(mark, sample=mark.sample + n) for mark in other.marks))
    return _curve((*one.samples, *other.samples[1:]), marks, ends, kind, order)


def _curve(
    samples: tuple[Sample, ...], marks: tuple[Mark, ...], ends: tuple[End, End], kind: BranchKind,
    order: int,
) -> Curve:  # fmt: skip
    jumps = kind is BranchKind.JUMP
    words = list[Word]()
    for k, sample in enumerate(samples):
        keys = keys_of(sample.orbit, sample.jump)
        if not words or keys != words[-1].keys:
            text = word_of(sample.orbit) if sample.jump is None else sample.jump.word
            words.append(Word(k, text, keys, sample.orbit.pieces))
    return Curve(
        kind=kind, order=order, parameter=np.array([s.orbit.p for s in samples]),
        points=tuple(s.orbit.x for s in samples),
        multiplier=np.array([np.nan if jumps else s.orbit.multiplier for s in samples]),
        words=tuple(words), marks=marks, ends=ends,
    )  # fmt: skip


def keys_of(orbit: Orbit, jump: Jump | None = None) -> tuple[object, ...]:
    """The pieces of an orbit, see :class:`Word`."""
    if jump is None:
        return orbit.keys
    sides = {(jump.inner.keys[0], jump.closing.code)}
    if jump.outer_code >= 0:
        sides.add((jump.outer.keys[0], jump.outer_code))
    return *orbit.keys[:-1], frozenset(sides)
