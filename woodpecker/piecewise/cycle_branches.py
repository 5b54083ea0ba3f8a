"""Branches of cycles, followed from piece to piece.

Where a cycle meets a border at which the map is continuous it goes on with the piece beyond. At a
jump it ends, in a border collision.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from pwmap.diagrams.diagram import BranchKind, PointKind, PointStatus
from woodpecker.piecewise.borders import Border, BorderKind
from woodpecker.piecewise.branch_points import conditions, directions
from woodpecker.piecewise.corrector import Corrector
from woodpecker.piecewise.counting import Allowance, as_counting
from woodpecker.piecewise.crossings import Restart, border_at, is_inside, replaced, restart
from woodpecker.piecewise.curves import (
    Beginning,
    Followed,
    Leg,
    Mark,
    both_ways,
    one_way,
)
from woodpecker.piecewise.ends import End, end_at, end_of, folded, given_up_or_left, located_to
from woodpecker.piecewise.jump_branches import collision
from woodpecker.piecewise.margins import depth
from woodpecker.piecewise.orbits import (
    Closed,
    Coordinate,
    Margin,
    Orbit,
    minimal_period,
    moved,
    newton_step,
    residuals,
    scales,
    solve,
)
from woodpecker.piecewise.pieces import PiecewiseMap
from woodpecker.piecewise.samples import Arc, Sample, Stop, StopRule
from woodpecker.piecewise.settings import Settings
from woodpecker.piecewise.stepping import Stepper
from woodpecker.piecewise.stops import FLIP

NOTHING_BEYOND = "no branch beyond a border"
PASSED_OVER = "borders accumulate"
SETTLING = 200  # steps of Newton's method beside a root, each of which halves what is left
ON_LOWER = "a cycle of a multiple period ends on one of smaller period"


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
        self.map, self.settings = as_counting(map_), settings
        self.corrector = Corrector(self.map, Closed(), settings)
        self.stepper = Stepper(self.corrector, [FLIP], stop)

    def through(self, orbit: Orbit) -> Followed:
        """The branch through a cycle, both ways to the next special points."""
        start = self.corrector.sample(orbit, np.eye(len(orbit) + 1)[-1])
        kind = BranchKind.FIXED_POINT
        return both_ways(start, lambda sample: self._leg((sample,), start), kind, len(orbit))

    def ahead(self, begin: Beginning) -> Followed:
        """The branch from a special point on, to the next."""
        samples = begin.samples
        return one_way(begin, self._leg(samples, samples[-1], begin.passed, begin.step))

    def _leg(
        self, first: tuple[Sample, ...], origin: Sample, ignored: Stop | None = None,
        step: float = math.inf,
    ) -> Leg:  # fmt: skip
        samples, marks = list(first), list[Mark]()
        allowed = Allowance(self.map, self.settings.of_branch(len(origin.orbit)))
        while True:  # until the stepper has spent what is allowed, if nothing else ends it
            arc = self.stepper.follow(samples[-1], ignored, origin, step, allowed)
            ignored, step = None, max(arc.step, self.settings.again)
            arc = self._sharpened(_at_nearest(arc, self.settings))
            samples += arc.samples[1:]
            if arc.stop in (Stop.SHORT, Stop.OTHER_PIECE):
                there = self._passed_over(arc)
                if there is not None:
                    marks.append(Mark(len(samples) - 1, PASSED_OVER, BorderKind.SMOOTH))
                    samples.append(there.sample)
                    continue
            if arc.stop is not Stop.BORDER:
                passes = arc.stop in (Stop.FOLD, Stop.FLIP, Stop.BRANCHING)
                passes &= not self._halves(arc)
                here, on = self._end(arc), (samples[-1],) if passes else ()
                if passes and arc.beyond is not None:
                    on = (*on, arc.beyond)
                return _ended(samples, marks, here, arc.stop, on, arc.step)
            mark, end, there = self._meet(arc)
            if end is not None and end.status is PointStatus.OPEN:
                there = self._passed_over(arc)
                if there is not None:
                    mark = replace(mark, cause=f"{mark.cause}: {PASSED_OVER}")
                    before, after = samples[-1].orbit.multiplier, there.multiplier
                    changes = _changes_stability(before, mark.kind, after, self.settings)
                    persists = end_at(PointKind.BC, arc.end, "persistence", mark.cause)
                    end = persists if changes else None
                else:
                    end = self._lost(arc, mark.cause) or end
            if end is not None:
                begin = self._across(arc) if end.kind is PointKind.BC else samples[-1]
                following = () if there is None else (begin, there.sample)
                step = step if there is None else min(step, there.step)
                return _ended(samples, marks, end, arc.stop, following, step)
            assert there is not None
            marks.append(replace(mark, sample=len(samples) - 1))
            samples.append(there.sample)
            step = min(step, there.step)

    def _meet(self, arc: Arc) -> tuple[Mark, End | None, Restart | None]:
        """What happens to a branch at a border, whether that is special, and where it goes on."""
        orbit, margin, last = arc.end, arc.margins[0], arc.samples[-1]
        border = border_at(self.map, orbit, margin, self.settings)
        kind = border.kind(self.settings)
        mark = Mark(sample=0, cause=border.cause, kind=kind)
        if self._halves(arc):
            return mark, end_at(PointKind.BC, orbit, ON_LOWER, border.cause), None
        if kind is BorderKind.LOST:
            lost = end_at(PointKind.FALL, orbit, border.outer.reason, border.cause)
            return mark, lost, None
        if kind is BorderKind.JUMP:
            met = collision(self.map, orbit, margin, border, self.settings)
            return mark, end_of(met, orbit), None
        there = restart(orbit, Closed(), border, margin.index, self.settings)
        before = self._period(arc.samples[0].orbit)
        if there is not None and self._period(there.sample.orbit) < before:
            return mark, end_at(PointKind.BC, orbit, ON_LOWER, border.cause), None
        if there is None:
            met = collision(self.map, orbit, margin, border, self.settings)
            if any(note for _, note in met.kinds):  # the jump vanishes just where a cycle meets it
                return mark, end_of(met, orbit), None
            note = NOTHING_BEYOND if border.outer_code >= 0 else PASSED_OVER
            lost = end_at(PointKind.EP, orbit, note, border.cause, PointStatus.OPEN)
            return mark, lost, None
        note = "fold" if last.tangent[-1] * there.sample.tangent[-1] < 0.0 else "persistence"
        inside, after = _inside(arc, self.settings), there.multiplier
        if note == "fold" or _changes_stability(inside, kind, after, self.settings):
            end = end_at(PointKind.BC, orbit, note, border.cause)
            return mark, replace(end, precision=self._blur(orbit, border, margin)), there
        return mark, None, there

    def _across(self, arc: Arc) -> Sample:
        """The sample at the end as the branch beyond begins with it: with the piece beyond."""
        margin, last = arc.margins[0], arc.samples[-1]
        border = border_at(self.map, last.orbit, margin, self.settings)
        if border.outer_code < 0 or border.outer.reason:
            return last
        images = replaced(last.orbit.images, margin.index, border.outer)
        return replace(last, orbit=Orbit(last.orbit.x, last.orbit.p, images))

    def _blur(self, orbit: Orbit, border: Border, margin: Margin) -> float:
        """How well a border is located, by the piece on that side on which it is less steep."""
        i = margin.index
        outer = Orbit(orbit.x, orbit.p, replaced(orbit.images, i, border.outer))
        if abs(border.outer.slope) < abs(orbit.images[i].slope):
            orbit, margin = outer, Margin(i, border.outer_code)
        return located_to(orbit, (Closed(), margin), self.settings)

    def _sharpened(self, arc: Arc) -> Arc:
        """An arc that ends at a square root, with its end as the piece beyond locates it.

        The map is continuous there, and the piece beyond is not steep: it is not rounding of the
        root that decides. That may even look like a jump; at one the piece beyond would meet the
        border elsewhere.
        """
        orbit = arc.end
        if arc.stop is not Stop.BORDER:
            return arc
        margin = arc.margins[0]
        i, image = margin.index, orbit.images[margin.index]
        rooted = self.settings.numerics.rooted
        steep = max(abs(s.orbit.images[i].slope) for s in arc.samples[-2:])
        if steep <= rooted:
            return arc
        border = border_at(self.map, orbit, margin, self.settings)
        kind = border.kind(self.settings)
        if kind is BorderKind.LOST or border.outer_code < 0:
            return arc
        jumps = kind is BorderKind.JUMP
        if steep <= rooted * max(1.0, abs(border.outer.slope)) and not jumps:
            return arc
        settled = replace(arc.samples[-1], orbit=_settled(orbit, margin, self.settings))
        arc = replace(arc, samples=(*arc.samples[:-1], settled))
        beyond_it = Orbit(orbit.x, orbit.p, replaced(orbit.images, i, border.outer))
        root = solve(beyond_it, (Closed(), Margin(i, border.outer_code)), self.settings)
        away = np.abs((root.orbit.point - orbit.point) / scales(len(orbit), self.settings)).max()
        if not (root.converged and away <= (self.settings.same if jumps else self.settings.beside)):
            return arc
        inner = image._replace(value=root.orbit.images[i].value)
        end = Orbit(root.orbit.x, root.orbit.p, replaced(root.orbit.images, i, inner))
        last = replace(arc.samples[-1], orbit=end)
        return replace(arc, samples=(*arc.samples[:-1], last))

    def _passed_over(self, arc: Arc) -> Restart | None:
        """The branch beyond a place where borders accumulate, the nearest there is.

        It is looked for along the tangent, with the pieces that the map takes there.
        """
        end = arc.samples[-1]
        x_scale, p_scale = self.settings.x_scale, self.settings.p_scale
        sign, (low, high) = (1.0 if end.tangent[-1] > 0.0 else -1.0), self.settings.span
        away, limit = self.settings.same, high if sign > 0.0 else low
        if self._jumps_unseen(end):
            return None
        fastest = self.settings.numerics.fastest
        p, slope = end.orbit.p, end.tangent[:-1] * x_scale / (end.tangent[-1] * p_scale)
        while away <= self.settings.max_step and p != limit:  # ten times farther each time
            p = min(max(end.orbit.p + sign * away * p_scale, low), high)
            x = end.orbit.x + (p - end.orbit.p) * slope
            start = Orbit(x, p, tuple(self.map.at(float(each), p) for each in x))
            away *= self.settings.numerics.farther
            if not start.defined:
                continue
            solution = solve(start, (Closed(), Coordinate(-1, p)), self.settings)
            found = solution.orbit
            aside = float(np.abs(found.x - end.orbit.x).max()) / x_scale
            if solution.converged and is_inside(found, Closed()) and aside <= fastest * away:
                return Restart(self.corrector.sample(found, sign * np.eye(len(found) + 1)[-1]))
        return None

    def _lost(self, arc: Arc, cause: str) -> End | None:
        """Where the map has no value right ahead; None if it has one.

        A motion that passes by the section ever more closely returns once rounding leads it there:
        at the border itself it seems to have a value.
        """
        end = arc.samples[-1]
        if end.tangent[-1] == 0.0:
            return None
        ahead = self.settings.same / abs(float(end.tangent[-1]))
        moved_to = end.orbit.point + ahead * end.tangent * scales(len(end.orbit), self.settings)
        images = [self.map.at(float(x), float(moved_to[-1])) for x in moved_to[:-1]]
        reason = next((image.reason for image in images if image.reason), "")
        return end_at(PointKind.FALL, arc.end, reason, cause) if reason else None

    def _jumps_unseen(self, end: Sample) -> bool:
        """Whether the map jumps beyond a sample, though the margins of its pieces are positive."""
        there = self.corrector.ahead(end, self.settings.same)
        for x, image in zip(there.x.tolist(), there.images, strict=True):
            other = self.map.at(x, there.p)
            if image.reason or other.reason or other.piece.key == image.piece.key:
                continue
            steepest = max(abs(image.slope), abs(other.slope))
            same = max(self.settings.jump, self.settings.nearest * steepest)
            jumps = abs(other.value - image.value) > same * self.settings.x_scale
            if jumps and depth(image) > self.settings.beside * self.settings.x_scale:
                return True
        return False

    def _halves(self, arc: Arc) -> bool:
        """Whether the cycle at the end, and none before it, goes round one of smaller period."""
        ends = arc.stop in (Stop.BRANCHING, Stop.BORDER)
        return ends and self._period(arc.end) < self._period(arc.samples[0].orbit)

    def _period(self, orbit: Orbit) -> int:
        """The minimal period, of points that are one to rounding."""
        return minimal_period(orbit, self.settings, self.settings.same)

    def _end(self, arc: Arc) -> End:
        kinds = {
            Stop.FOLD: PointKind.LP, Stop.FLIP: PointKind.PD, Stop.BRANCHING: PointKind.BP,
        }  # fmt: skip
        kind = kinds.get(arc.stop, PointKind.EP)
        if kind is PointKind.EP:
            return given_up_or_left(arc, self.settings)
        cause = arc.stop.value
        if self._halves(arc):  # a branch of doubled period folds where it began
            kind, cause = PointKind.PD, Stop.FLIP.value
        end = end_at(kind, arc.end, cause=cause)
        if kind is PointKind.LP:
            return folded(end, arc.end, Closed(), self.settings)
        if arc.stop is Stop.BRANCHING and directions(arc.end, self.settings):
            at = located_to(arc.end, conditions(self.settings), self.settings)
            return replace(end, precision=at)
        return end


def _ended(
    samples: list[Sample], marks: list[Mark], end: End, stop: Stop, following: tuple[Sample, ...],
    step: float,
) -> Leg:  # fmt: skip
    """A leg that goes on with some samples beyond its end, if there are any."""
    onward = None
    if following:
        onward = Beginning(
            kind=BranchKind.FIXED_POINT, order=len(following[0].orbit), samples=following,
            closing=Closed(), end=end, passed=stop, step=step,
        )  # fmt: skip
    return Leg(tuple(samples), tuple(marks), end, stop, onward)


def _settled(orbit: Orbit, margin: Margin, settings: Settings) -> Orbit:
    """A cycle as close to a border at which its piece ends in a root as it is, to rounding.

    Newton's method expects of each step how short the next one is, which at a root is not so.
    """
    held = replace(margin, value=orbit.images[margin.index].margin(margin.code))
    left = np.abs(residuals(orbit, (Closed(),))).max()
    for _ in range(SETTLING):
        closer = moved(orbit, newton_step(orbit, (Closed(), held), settings))
        now = np.abs(residuals(closer, (Closed(),))).max() if closer.defined else math.inf
        if not now < left:
            return orbit
        orbit, left = closer, now
    return orbit


def _at_nearest(arc: Arc, settings: Settings) -> Arc:
    """An arc whose steps have become too short beside a border, as one that ends there."""
    if arc.stop not in (Stop.SHORT, Stop.OTHER_PIECE):
        return arc
    found = list[tuple[float, Margin]]()
    for i, image in enumerate(arc.end.images):
        with np.errstate(divide="ignore", invalid="ignore"):
            away = image.margins / np.abs(image.gradients[:, 0])
        found += [
            (abs(d), Margin(i, code))
            for d, code in zip(away.tolist(), image.causes.tolist(), strict=True)
        ]
    least, margin = min(found, key=lambda each: each[0], default=(math.inf, None))
    if margin is None or not least <= settings.same * settings.x_scale:
        return arc
    return replace(arc, stop=Stop.BORDER, margins=(margin,))


def _inside(arc: Arc, settings: Settings) -> float:
    """The multiplier on the way to the end of an arc: at a square root it may be rounding.

    No fold or flip lies between the last two samples, so both are stable or neither is.
    """
    before = arc.samples[-2:][0].orbit.multiplier
    return arc.end.multiplier if abs(abs(before) - 1.0) <= settings.numerics.torn else before


def _changes_stability(before: float, kind: BorderKind, after: float, settings: Settings) -> bool:
    """Whether a branch is stable on one side of a border only; not where it is smooth there.

    Multipliers that differ by far say that the border is not smooth.
    """
    least = settings.numerics.torn * max(1.0, abs(before))
    torn = kind is not BorderKind.SMOOTH or abs(after - before) > least
    return torn and (abs(before) < 1.0) != (abs(after) < 1.0)
