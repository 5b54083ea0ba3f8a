"""Branches of jumps, followed from piece to piece, and the collisions in which they begin.

Where an orbit of a jump meets another border the branch goes on with the jump beyond, round a
corner if need be. It ends where a limit meets the diagonal: there a cycle meets the jump, and the
points of the cycle up to the border are the border orbit with which branches of jumps begin.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from pwmap.diagrams.diagram import BranchKind, PointKind, PointStatus
from woodpecker.base.arrays import Floats
from woodpecker.piecewise.borders import Border, BorderKind
from woodpecker.piecewise.corners import leaving
from woodpecker.piecewise.corrector import Corrector
from woodpecker.piecewise.counting import Allowance, as_counting
from woodpecker.piecewise.crossings import border_at, differentiable, is_inside, restart
from woodpecker.piecewise.curves import (
    Beginning,
    Followed,
    Leg,
    Mark,
    both_ways,
    one_way,
    turned,
)
from woodpecker.piecewise.ends import (
    GIVEN_UP,
    Collision,
    End,
    end_at,
    end_of,
    folded,
    given_up_or_left,
    located_to,
)
from woodpecker.piecewise.limit_stops import continued
from woodpecker.piecewise.margins import depth
from woodpecker.piecewise.orbits import Closed, Margin, Orbit, minimal_period, scales, tangent
from woodpecker.piecewise.pieces import PiecewiseMap
from woodpecker.piecewise.samples import Arc, Sample, Stop, StopRule
from woodpecker.piecewise.settings import Settings
from woodpecker.piecewise.stepping import Stepper

MEET = "borders meet, closer than can be resolved"
LIMIT_LOST = "a limit of the jump is lost"


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
        self.map, self.order, self.settings, self.stop = as_counting(map_), order, settings, stop

    def through(self, head: Orbit, closing: Margin) -> Followed:
        """The branch of jumps through a border orbit, both ways to the next special points."""
        start = self._sample(head, closing)
        kind = BranchKind.JUMP
        return both_ways(start, lambda sample: self._leg((sample,), start), kind, self.order)

    def starts(self, cycle: Orbit, margin: Margin, shift: int) -> list[tuple[Sample, Sample]]:
        """Branches that start where a cycle meets a jump, seen from one of its points.

        The orbit may have gone round some times before it meets the border, where a margin
        vanishes.

        Returns
        -------
        For each the sample at the collision, and the next one.
        """
        n, found = len(cycle), []
        orbit = cycle.rotated(shift)
        to_border = (margin.index - shift) % n
        for length in range(to_border + 1, self.order + 1, n):
            rounds = -(-length // n)
            x, images = np.tile(orbit.x, rounds)[:length], (orbit.images * rounds)[:length]
            head = Orbit(x, orbit.p, images)
            start = self._sample(head, Margin(length - 1, margin.code))
            sides = [(sign, self._beside(start, sign)) for sign in (1.0, -1.0)]
            begin = [(sign, there) for sign, there in sides if there is not None]
            if len(begin) == 1:  # one that goes on to both sides only passes
                sign, there = begin[0]
                found.append((start if sign > 0.0 else turned(start), there))
        return found

    def ahead(self, begin: Beginning) -> Followed:
        """The branch from a special point on, to the next."""
        samples = begin.samples
        return one_way(begin, self._leg(samples, samples[-1], begin.passed, begin.step))

    def _leg(
        self, first: tuple[Sample, ...], origin: Sample, ignored: Stop | None = None,
        step: float = math.inf,
    ) -> Leg:  # fmt: skip
        samples, marks = list(first), list[Mark]()
        allowed = Allowance(self.map, self.settings.of_branch(self.order))
        while True:  # until the stepper has spent what is allowed, if nothing else ends it
            last = samples[-1]
            assert last.jump is not None
            arc = self._stepper(last.jump.closing).follow(last, ignored, origin, step, allowed)
            ignored, step = None, math.inf
            samples += arc.samples[1:]
            if arc.stop in (Stop.SHORT, Stop.OTHER_PIECE):
                there = self._passed_over(samples[-1], narrow=True)
                if there is not None:
                    marks.append(Mark(len(samples) - 1, MEET, BorderKind.SMOOTH))
                    samples.append(there)
                    continue
            if arc.stop not in (Stop.BORDER, Stop.TAIL):
                end, onward = self._end(arc), None
                if arc.stop is Stop.FOLD:
                    onward = Beginning(
                        kind=BranchKind.JUMP, order=self.order, samples=(samples[-1],),
                        closing=self._closing_of(arc), end=end, passed=arc.stop, step=arc.step,
                    )  # fmt: skip
                return Leg(tuple(samples), tuple(marks), end, arc.stop, onward)
            early = self._closed_early(arc)
            if early is not None and self._passes(early, arc.end):
                met = self._collision(early)
                return Leg(tuple(samples), tuple(marks), end_of(met, arc.end), arc.stop)
            mark, there = self._beyond(arc, early)
            if there is None:
                end = self._lost(arc) or end_at(
                    PointKind.EP, arc.end, "the jump ends", mark.cause, PointStatus.OPEN
                )
                return Leg(tuple(samples), tuple(marks), end, arc.stop)
            marks.append(replace(mark, sample=len(samples) - 1))
            samples.append(there)

    def _corrector(self, closing: Margin) -> Corrector:
        return Corrector(self.map, closing, self.settings, self.order)

    def _stepper(self, closing: Margin) -> Stepper:
        return Stepper(self._corrector(closing), stop=self.stop)

    def _sample(self, head: Orbit, closing: Margin, along: Floats | None = None) -> Sample:
        forward = np.eye(len(head) + 1)[-1] if along is None else along
        return self._corrector(closing).sample(head, forward)

    def _beside(self, start: Sample, sign: float = 1.0) -> Sample | None:
        """The next sample of a jump branch, right beside one where it changes; None if it ends.

        It is admissible, and crosses the diagonal.
        """
        base = start if sign > 0.0 else turned(start)
        away = self.settings.beside
        while away >= self.settings.min_step:  # a hundred times closer each time
            found = self._at(base, away)
            if found is not None:
                return found if self._is_good(found) else None
            away *= self.settings.numerics.restart
        return None

    def _next(self, end: Sample) -> Sample | None:
        """The sample beyond a border that a limit meets, with the pieces that begin there.

        The usual distance may lead past another border. Too close to the first one the map is not
        asked for the piece right beside the jump: the distance is halved, in its logarithm.
        """
        low, high = self.settings.nearest, self.settings.beside
        found = self._beside(end)
        there, away = found, high
        for _ in range(self.settings.numerics.bisections):
            if there is None:
                break
            begins = self._begins(there, end, away)
            if begins == 0:
                return there
            low, high = (away, high) if begins < 0 else (low, away)
            away = math.sqrt(low * high)
            there = self._at(end, away)
        return found

    def _begins(self, there: Sample, end: Sample, away: float) -> int:
        """0 if the pieces of the limits of a jump begin at a border, and none lies in between.

        Otherwise 1 if the sample lies too far from that border, -1 if it lies too close.
        """
        assert there.jump is not None
        least = (
            max(self.settings.nearest, self.settings.numerics.thin * away) * self.settings.x_scale
        )
        k, far = there.jump.closing.index, False
        for inner in (True, False):
            limit = there.jump.cycle(inner)
            back = continued(limit, end.orbit)
            for i in range(k, len(back)):
                own = there.jump.code(inner) if i == k else -1
                inside = depth(limit.images[i], own)
                on_border = self.settings.rounded_x(float(limit.x[i]))
                if inside < -on_border:
                    return -1
                far |= inside <= on_border or depth(back.images[i], own) < -least
        return int(far)

    def _at(self, base: Sample, away: float) -> Sample | None:
        """The sample at a distance along a jump branch; None if there is none."""
        assert base.jump is not None
        if any(image.slope == 0.0 for image in base.orbit.images[:-1]):
            return None  # where the orbit starts does not change where it ends: P_order has no jump
        found = self._corrector(base.jump.closing).advance(base, away)
        return found if isinstance(found, Sample) and found.jump is not None else None

    def _is_good(self, sample: Sample) -> bool:
        """Whether a sample is admissible, and its jump crosses the diagonal."""
        jump = sample.jump
        return jump is not None and jump.crosses and is_inside(sample.orbit, jump.closing)

    def _end(self, arc: Arc) -> End:
        if arc.stop is not Stop.LIMIT:
            if arc.stop is Stop.FOLD:
                end = end_at(PointKind.LP, arc.end, cause=arc.stop.value)
                closing = self._closing_of(arc)
                return folded(end, arc.end, closing, self.settings)
            lost = self._lost(arc) if arc.stop in GIVEN_UP else None
            return lost or given_up_or_left(arc, self.settings)
        assert arc.meeting is not None
        margin = arc.margins[0]
        border = border_at(self.map, arc.meeting, margin, self.settings)
        met = collision(self.map, arc.meeting, margin, border, self.settings)
        return end_of(met, arc.end)

    def _lost(self, arc: Arc) -> End | None:
        """Where a limit of a jump has no value any more; None if it has one.

        Its orbit goes through more and more pieces before, so that no border is the last: the place
        is known as well as the nearest orbit beyond that is lost.
        """
        end, away = arc.samples[-1], self.settings.same
        while away <= self.settings.beside:  # ten times farther each time
            found = self._at(end, away)
            reason = "" if found is None or found.jump is None else found.jump.lost
            if found is not None and reason:
                lost = end_at(PointKind.FALL, arc.end, reason, LIMIT_LOST)
                return replace(lost, precision=abs(found.orbit.p - lost.p))
            away *= self.settings.numerics.farther
        return None

    @staticmethod
    def _closing_of(arc: Arc) -> Margin:
        jump = arc.samples[-1].jump
        assert jump is not None
        return jump.closing

    def _closed_early(self, arc: Arc) -> _Return | None:
        """Where the orbit of a jump comes back to its own border; None if it does not."""
        last = arc.samples[-1].jump
        assert last is not None
        meeting, margin = arc.meeting or arc.end, arc.margins[0]
        own = Margin(last.closing.index, last.code(arc.inner))
        first, second = sorted((own, margin), key=lambda each: each.index)
        i, k = first.index, second.index
        if i == k or abs(meeting.x[k] - meeting.x[i]) > self.settings.same * self.settings.x_scale:
            return None
        return _Return(
            meeting.head(i),
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

    def _beyond(self, arc: Arc, early: _Return | None) -> tuple[Mark, Sample | None]:
        """Where a jump branch goes on when one of its orbits meets another border."""
        end, margin = arc.samples[-1], arc.margins[0]
        meeting = arc.meeting or arc.end
        assert end.jump is not None
        border = border_at(self.map, meeting, margin, self.settings)
        kind = border.kind(self.settings)
        mark = Mark(sample=0, cause=border.cause, kind=kind)
        there = None
        if early is not None:
            return mark, self._round_cycle(end, early)
        if arc.stop is Stop.TAIL:
            there = self._next(end)
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
        there = self._sample(found.sample.orbit, closing, found.sample.tangent)
        return there if there.jump is not None and there.jump.crosses else None

    def _passed_over(self, end: Sample, narrow: bool = False) -> Sample | None:
        """The jump beyond a place where one of its pieces ends, the nearest there is.

        The piece on the other side of the border still defines the same jump there, or another jump
        leaves the corner. Infinitely many borders can accumulate at such a place, so the distance
        grows.
        """
        numerics = self.settings.numerics
        away, bases = numerics.restart * self.settings.beside, self._bases(end)
        while away <= self.settings.max_step:  # ten times farther each time
            found = self._from_corner(end, away, narrow) if away <= numerics.blurred else None
            if found is not None:
                return found
            for base in bases if away >= self.settings.beside else ():
                found = self._at(base, away)
                if found is None or found.jump is None:
                    continue
                closing = found.jump.closing
                agrees = self._corrector(closing).agrees(found.orbit)
                if agrees and is_inside(found.orbit, closing):
                    if found.jump.crosses:
                        return found
                    bases = []  # it ends here
                    break
            away *= numerics.farther
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
        same_way = self.settings.numerics.same_way
        if len(found) < 2 or float(found[0].direction @ back) < same_way:
            return None
        other = found[1]
        if len(found) > 2 and not (narrow and float(other.direction @ back) >= same_way):
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
            start = self._sample(meeting.head(margin.index + 1), margin)
        found = [s for sign in (1.0, -1.0) if (s := self._beside(start, sign)) is not None]
        return found[0] if len(found) == 1 else None


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
    orbit = differentiable(orbit, margin, settings)
    n = minimal_period(orbit, settings)
    first = int(np.argmin(orbit.x[:n]))
    small = orbit.head(n).rotated(first)
    index = (margin.index - first) % n
    margin, image = Margin(index, margin.code), small.images[index]
    met = Collision(
        p=small.p, x=small.x, margin=margin, side=-image.onward(margin.code), key=small.keys[index],
        kinds=((PointKind.BC, ""),) * n, cause=border.cause,
        precision=located_to(small, (Closed(), margin), settings),
    )  # fmt: skip
    inside = cycle_from(small, margin, settings)
    if not inside:
        return met
    jumps, steep = Jumps(map_, n, settings), abs(small.multiplier) > 1.0
    kinds = []
    for shift in range(n):
        corner = at_corner(small, margin, settings)
        starts = [begin for own in corner for begin in jumps.starts(small, own, shift)]
        sides = {
            bool(sample.tangent[-1] > 0.0) for sample in (inside[-1], *(s[1] for s in starts[:1]))
        }
        fold = PointKind.FF if steep else PointKind.BC
        found = (fold, "fold") if len(sides) == 1 else (PointKind.BC, "persistence")
        kinds.append(found if starts else (PointKind.BC, ""))
    return replace(met, kinds=tuple(kinds))


def at_corner(orbit: Orbit, margin: Margin, settings: Settings) -> list[Margin]:
    """All margins that vanish where an orbit meets a jump: where borders cross, several.

    Margins that vanish along one border are those of the same jump.
    """
    i, image = margin.index, orbit.images[margin.index]
    rows = image.gradients * [settings.x_scale, settings.p_scale]
    length = np.linalg.norm(rows, axis=1)
    a, b = image.gradient(margin.code) * [settings.x_scale, settings.p_scale]
    apart = np.abs(rows @ [-b, a]) > settings.kink * length * math.hypot(a, b)
    vanish = np.abs(image.margins) <= settings.same * length
    others = image.causes[apart & vanish].tolist()
    return [margin, *(Margin(i, code) for code in others)]


def cycle_from(orbit: Orbit, margin: Margin, settings: Settings) -> tuple[Sample, ...]:
    """The first samples of the branch of cycles that starts at a border, into the piece inside.

    Where that piece begins with a square root its slope at the border is infinite, and the second
    sample lies right beside it.
    """
    orbit = differentiable(orbit, margin, settings)
    direction = tangent(orbit, Closed(), settings)
    if not np.isfinite(direction).all():
        return ()
    scale, i = scales(len(orbit), settings), margin.index
    image = orbit.images[i]
    gradient = image.gradient(margin.code)
    forward = float(gradient @ (direction * scale)[[i, -1]]) > 0.0
    first = Sample(orbit, direction if forward else -direction, forward)
    if abs(image.slope) < settings.numerics.steep:
        return (first,)
    code, side = margin.code, -image.onward(margin.code)
    border = Border(float(orbit.x[i]), orbit.p, image, code, side, image, code)
    there = restart(orbit, Closed(), border, i, settings)
    return (first,) if there is None else (first, there.sample)
