"""Branches of orbits with fixed pieces: predictor, corrector, step control, and one locator.

A *stretch* is a part of a branch along which no piece changes. It ends where a condition holds: a
margin vanishes, an orbit leaves the window, the branch turns round. Each such end is an orbit that
obeys that condition, found by Newton's method, not the last of some halvings.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from pwmap.diagrams.diagram import BranchKind
from woodpecker.base.arrays import Floats
from woodpecker.piecewise.branch_points import closes, directions, saddle
from woodpecker.piecewise.jumps import Jump, carried_over, jump_of
from woodpecker.piecewise.margins import depth, lowest_dip
from woodpecker.piecewise.orbits import (
    SPACING,
    Closed,
    Condition,
    Coordinate,
    Distance,
    Margin,
    Orbit,
    Solution,
    between,
    orbit_of,
    scales,
    solve,
    tangent,
)
from woodpecker.piecewise.pieces import Image, Piece, PiecewiseMap
from woodpecker.piecewise.settings import Settings


class Stop(Enum):
    """Why a stretch ends."""

    BORDER = "a margin vanishes"
    FOLD = "the branch turns round"
    FLIP = "the multiplier is -1"
    BRANCHING = "another branch crosses"
    LIMIT = "a limit of the jump meets the diagonal"
    TAIL = "a limit of the jump meets a border"
    SPAN = "end of the parameter span"
    WINDOW = "end of the window"
    CLOSED = "the branch closes"
    OTHER_PIECE = "the map takes another piece"
    SHORT = "steps become too short"
    MANY = "as many samples as allowed"
    ASKED = "stopped as asked"


class BranchState(NamedTuple):
    """What a rule to stop sees of a place on a branch.

    Attributes
    ----------
    kind, order
        Cycles of P_order, or jumps of it.
    parameter
        The parameter.
    points
        (n,) points of the cycle, or those up to the border of a jump.
    multiplier
        Of the cycle; nan for a jump.
    word
        The words of the pieces.
    """

    kind: BranchKind
    order: int
    parameter: float
    points: Floats
    multiplier: float
    word: str

    @property
    def x(self) -> float:
        """The first point."""
        return float(self.points[0])


StopRule = Callable[[BranchState], bool]
"""Whether a branch is to end at a place."""


@dataclass(frozen=True, slots=True, eq=False)
class Sample:
    """An orbit of a branch, and the way it goes.

    Attributes
    ----------
    orbit
        The orbit.
    tangent
        (n + 1,) in scaled unknowns, forward.
    forward
        Whether this is the sign of :func:`woodpecker.piecewise.orbits.tangent`; it changes at
        branch points.
    jump
        The jump at the end of a border orbit, if one is followed.
    """

    orbit: Orbit
    tangent: Floats
    forward: bool = True
    jump: Jump | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """Orbits of a branch whose pieces do not change.

    Attributes
    ----------
    samples
        From the start to the end, at least one.
    stop
        Why it ends.
    margins
        Which margins vanish at the end.
    inner, meeting
        Of a jump: which of its limits meets the diagonal or a border there, and the orbit up to
        that place.
    step
        The last step: the next stretch may begin with it.
    """

    samples: tuple[Sample, ...]
    stop: Stop
    margins: tuple[Margin, ...] = ()
    inner: bool = True
    meeting: Orbit | None = None
    step: float = math.inf

    @property
    def end(self) -> Orbit:
        """The last orbit."""
        return self.samples[-1].orbit


@dataclass(frozen=True, slots=True, eq=False)
class Test:
    """A function of samples whose change of sign ends a stretch."""

    stop: Stop
    value: Callable[[Sample], float]


@dataclass(frozen=True, slots=True, eq=False)
class _Event:
    """An end that lies between two samples."""

    stop: Stop
    sample: Sample
    distance: float
    margins: tuple[Margin, ...] = ()
    inner: bool = True
    meeting: Orbit | None = None


class _LostError(Exception):
    """A branch cannot be followed where it was followed before."""


class Stepper:
    """Follows branches of one kind.

    Parameters
    ----------
    map_
        The map; it has the last word on which piece is taken.
    closing
        The condition that makes orbits a branch: a cycle closes, a border orbit ends at a border.
    settings
        Steps and tolerances.
    tests
        Functions whose changes of sign end a stretch.
    order
        Of the jumps; 0 for cycles.
    stop
        Whether to end somewhere, if anybody asks for it.
    """

    def __init__(
        self, map_: PiecewiseMap, closing: Condition, settings: Settings,
        tests: Sequence[Test] = (), order: int = 0, stop: StopRule | None = None,
    ) -> None:  # fmt: skip
        self.map, self.closing, self.settings, self.tests = map_, closing, settings, tuple(tests)
        self.order, self.stop = order, stop

    def sample(self, orbit: Orbit, along: Floats) -> Sample:
        """An orbit with its tangent, which points like another one.

        At a border beside a cube root it may have none: then the other one is taken for it.
        """
        direction = tangent(orbit, self.closing, self.settings)
        if not np.isfinite(direction).all():
            return self._complete(Sample(orbit, along))
        forward = bool(direction @ along >= 0.0)
        return self._complete(Sample(orbit, direction if forward else -direction, forward))

    def _complete(self, sample: Sample) -> Sample:
        """A sample with its jump, if jumps are followed."""
        if not (self.order and isinstance(self.closing, Margin)):
            return sample
        jump = jump_of(self.map, sample.orbit, self.closing, self.order, self.settings)
        return replace(sample, jump=jump)

    def follow(
        self, start: Sample, ignored: Stop | None = None, origin: Sample | None = None,
        first: float = math.inf,
    ) -> Stretch:  # fmt: skip
        """Follow a branch from a sample to its end.

        Parameters
        ----------
        start
            A sample; it may lie on the end of another stretch.
        ignored
            What ended that one: it is not looked for in the first step.
        origin
            A sample at which the branch has come round.
        first
            The first step, if it is shorter than the usual one.
        """
        stop = self._leaves(start) or (Stop.ASKED if self._asked(start) else None)
        if stop is not None:
            return Stretch((start,), stop)
        samples, step, grows = [start], min(first, self.settings.step), True
        retry = self.settings.numerics.retry
        while len(samples) < self.settings.max_samples:
            if step < self.settings.min_step:
                return Stretch(tuple(samples), Stop.SHORT)
            last = samples[-1]
            before = samples[-2] if len(samples) > 1 else None
            found = self._to_end(last, step) or self.advance(last, step, before)
            if isinstance(found, float):
                step, grows = found, False
                continue
            skipped = ignored if len(samples) == 1 else None
            events = self._events(last, found, step, skipped, origin)
            event = self._first(events) if events else None
            if events is None or (event is not None and not self._is_first(event)):
                step, grows = 0.5 * step, False
                continue
            if event is not None:
                return Stretch(
                    (*samples, event.sample), event.stop, event.margins, event.inner,
                    event.meeting, step,
                )  # fmt: skip
            if not self.agrees(found.orbit):
                if retry * step < self.settings.min_step:
                    return Stretch(tuple(samples), Stop.OTHER_PIECE)
                step, grows = retry * step, False
                continue
            samples.append(found)
            turned = _angle(last.tangent, found.tangent) / self._turn(step)
            growth, wanted = 2.0 if grows else 1.0, self.settings.numerics.kept_turn
            growth = wanted / turned if growth * turned > wanted else growth
            step, grows = min(self.settings.max_step, step * growth), True
        return Stretch(tuple(samples), Stop.MANY)

    def _leaves(self, start: Sample) -> Stop | None:
        """Whether a sample lies at an end of span or window, and the branch leaves it there."""
        orbit, along = start.orbit, start.tangent
        for stop, index, (low, high) in self._limits(orbit):
            value = orbit.point[index]
            if (value <= low and along[index] < 0.0) or (value >= high and along[index] > 0.0):
                return stop
        return None

    def _asked(self, sample: Sample) -> bool:
        """Whether a branch is to end here."""
        if self.stop is None:
            return False
        orbit, jump = sample.orbit, sample.jump
        if jump is None:
            kind, order, multiplier = BranchKind.FIXED_POINT, len(orbit), orbit.multiplier
        else:
            kind, order, multiplier = BranchKind.JUMP, jump.order, math.nan
        word = " | ".join(orbit.words) if jump is None else jump.word
        return bool(self.stop(BranchState(kind, order, orbit.p, orbit.x.copy(), multiplier, word)))

    def _at_stop(self, a: Sample, b: Sample, step: float) -> list[_Event] | None:
        """Where a branch is to end between two samples; None if it is lost on the way."""
        if not self._asked(b):
            return []
        scale = scales(len(a.orbit), self.settings)
        length = float(a.tangent @ ((b.orbit.point - a.orbit.point) / scale))
        low, high, found = 0.0, length, b
        while high - low > SPACING * step:
            middle = 0.5 * (low + high)
            sample = self.advance(a, middle)
            if isinstance(sample, float):
                return None
            if not low < middle < high:
                break
            if self._asked(sample):
                high, found = middle, sample
            else:
                low = middle
        return [_Event(Stop.ASKED, found, high)]

    def _limits(self, orbit: Orbit) -> Iterator[tuple[Stop, int, tuple[float, float]]]:
        yield Stop.SPAN, -1, self.settings.span
        for i in range(len(orbit)):
            yield Stop.WINDOW, i, self.settings.window

    def _first(self, events: list[_Event]) -> _Event:
        """The event that comes first; at the end of the span or of the window nothing else does.

        Of margins that vanish at once it is the one that belongs to the earliest of what happens,
        not the one that rounding puts first.
        """
        first = min(event.distance for event in events)
        near = [event for event in events if event.distance <= first + self.settings.same]
        ends = [event for event in near if event.stop in (Stop.SPAN, Stop.WINDOW)]
        if ends:
            return ends[0]
        at_once = [event for event in near if event.distance <= first + self.settings.nearest]
        if all(event.margins and event.stop is at_once[0].stop for event in at_once):
            return min(at_once, key=lambda event: (event.margins[0].index, event.margins[0].code))
        return min(near, key=lambda event: event.distance)

    def _is_first(self, event: _Event) -> bool:
        """Whether no margin but those of an event has vanished before it.

        One that the far end of the step does not have is not seen to change its sign on the way.
        """
        least = self.settings.thinnest
        own = {(margin.index, margin.code) for margin in event.margins}
        for i, image in enumerate(event.sample.orbit.images):
            if self._on_border(i):
                continue
            (code,) = [c for k, c in own if k == i] or [-1]
            if depth(image, code) < -least:
                return False
        return True

    def advance(self, last: Sample, step: float, before: Sample | None = None) -> Sample | float:
        """The sample one step ahead, or a shorter step to try.

        It is predicted along the tangent, or along the cubic through the sample before too: where
        orbits are steep Newton's method needs to start close by.
        """
        scale = scales(len(last.orbit), self.settings)
        predicted = self._predicted(last, step, scale, before)
        if not predicted.defined:
            predicted = pulled_inside(predicted, last.orbit)
        if not predicted.defined:
            return 0.5 * step
        distance = Distance(last.orbit.point, last.tangent, step, scale)
        solution = solve(predicted, (self.closing, distance), self.settings, contracts=True)
        if solution.converged and not self._is_met(solution.orbit):  # steep: rounding of a step was
            solution = solve(solution.orbit, (self.closing, distance), self.settings)  # too much
        if not solution.converged or not self._is_met(solution.orbit):
            return 0.5 * step
        found = tangent(solution.orbit, self.closing, self.settings)
        if not np.isfinite(found).all():
            return 0.5 * step
        forward = bool(found @ last.tangent >= 0.0)
        found = found if forward else -found
        if _angle(last.tangent, found) > self._turn(step):
            return 0.5 * step
        return self._complete(Sample(solution.orbit, found, forward))

    def _turn(self, step: float) -> float:
        """The largest angle between tangents of samples at a distance: hairpins may be coarse."""
        own = self.settings.max_turn
        return min(
            max(own, self.settings.numerics.sharpest), max(own, own * self.settings.hairpin / step)
        )

    def _is_met(self, orbit: Orbit) -> bool:
        """Whether each image meets the next point, or would within rounding of its own point.

        Where a piece ends in a square root Newton's steps become short also if there is no orbit.
        """
        away = self.settings.converged * self.settings.x_scale
        for image, x, to in zip(orbit.images, orbit.x.tolist(), self._targets(orbit), strict=True):
            off = image.value - to
            if abs(off) <= self.settings.same * self.settings.x_scale:
                continue
            beside = [nearest_value(image, x, x + side * away, orbit.p) for side in (-1.0, 1.0)]
            if not any(off * (value - to) <= 0.0 for value in beside):
                return False
        return True

    def _targets(self, orbit: Orbit) -> list[float]:
        """Where the points of an orbit are to go; the last of a border orbit may go anywhere."""
        if isinstance(self.closing, Margin):
            return [*orbit.x[1:].tolist(), orbit.images[-1].value]
        return [*orbit.x[1:].tolist(), float(orbit.x[0])]

    def ahead(self, last: Sample, step: float) -> Orbit:
        """Where the tangent leads, under the pieces of a sample; no orbit yet."""
        return self._predicted(last, step, scales(len(last.orbit), self.settings))

    def _to_end(self, last: Sample, step: float) -> Sample | None:
        """The sample at the end of the span if a step leads there: beyond, there may be no map."""
        scale = scales(len(last.orbit), self.settings)
        p, along = last.orbit.p, float(last.tangent[-1] * scale[-1])
        low, high = self.settings.span
        end = high if along > 0.0 else low
        if not (along != 0.0 and abs(end - p) < step * abs(along) and p != end):
            return None
        predicted = self._predicted(last, (end - p) / along, scale)
        if not predicted.defined:
            return None
        solution = solve(predicted, (self.closing, Coordinate(-1, end)), self.settings)
        direction = tangent(solution.orbit, self.closing, self.settings)
        if not solution.converged or not np.isfinite(direction).all():
            return None
        if _angle(last.tangent, direction) > 0.5 * math.pi:
            direction = -direction
        if _angle(last.tangent, direction) > self.settings.max_turn:
            return None
        found = Orbit(solution.orbit.x, end, solution.orbit.images)
        return self.sample(found, last.tangent)

    @staticmethod
    def _predicted(last: Sample, step: float, scale: Floats, before: Sample | None = None) -> Orbit:
        move = step * last.tangent * scale
        if before is not None:
            chord = (last.orbit.point - before.orbit.point) / scale
            length = float(np.linalg.norm(chord))
            if length > 0.0:
                mean, part = chord / length, step / length
                cubic = last.tangent + before.tangent - 2.0 * mean
                square = 2.0 * last.tangent + before.tangent - 3.0 * mean
                move = move + step * part * (square + part * cubic) * scale
        x, p = last.orbit.x + move[:-1], last.orbit.p + float(move[-1])
        images = tuple(
            image.piece.at(float(value), p)
            for image, value in zip(last.orbit.images, x, strict=True)
        )
        return Orbit(x, p, images)

    def agrees(self, orbit: Orbit) -> bool:
        """Whether the map takes the pieces of an orbit, except at the end of a border orbit."""
        points = zip(orbit.x.tolist(), orbit.images, strict=True)
        return all(
            self._is_taken(x, orbit.p, image)
            for i, (x, image) in enumerate(points)
            if not self._on_border(i)
        )

    def _is_taken(self, x: float, p: float, image: Image) -> bool:
        """Whether the map takes the piece of an image, and the same of its solutions."""
        there = self.map.at(x, p)
        slack = self.settings.same * self.settings.x_scale * max(1.0, abs(image.slope))
        return there.piece.key == image.piece.key and not abs(there.value - image.value) > slack

    def _on_border(self, i: int) -> bool:
        return isinstance(self.closing, Margin) and self.closing.index == i

    # --- What lies between two samples ------------------------------------------------------------

    def _events(
        self, a: Sample, b: Sample, step: float, skipped: Stop | None, start: Sample | None
    ) -> list[_Event] | None:
        """Ends between two samples; None if a shorter step is needed to tell."""
        found: list[_Event] = []
        crossed = self._crossed(a, b)
        if crossed is None:
            return None
        if crossed:
            event = self._at_border(a, b, step, *min(crossed, key=lambda each: each[1]))
            if event is None:
                return None
            found.append(event)
        until, way, own = b, step, tuple[Margin, ...]()
        if found:
            event = self._first(found)
            until, way, own = event.sample, event.distance, event.margins
        if way > 0.0 and self._dips(a, until, way, own):
            return None
        ends = self._at_ends(a, b, step)
        if ends is None:
            return None
        found += ends
        crosses = a.forward != b.forward and not self.order
        for test in (FOLD, *self.tests):
            if test.stop is skipped or (crosses and test.stop is Stop.FOLD):
                continue
            before, after = test.value(a), test.value(b)
            if before * after < 0.0 or (after == 0.0 and before != 0.0):
                events = self._located(a, step, test, SPACING)
                if events is None:
                    return None
                found += events
        if crosses and skipped is not Stop.BRANCHING:
            events = self._at_branch_point(a, b, step)
            if events is None and not found:
                return None
            found += events or []
        tails = self._at_tails(a, b, step)
        if tails is None:
            return None
        found += tails
        until = self._first(found).sample if found else b
        limits = self._at_diagonal(a, until, step) if skipped is not Stop.LIMIT else []
        if limits is None:
            return None
        found += limits
        if found and self.order and not self._still_crosses(a, self._first(found)):
            return None
        asked = self._at_stop(a, self._first(found).sample if found else b, step)
        if asked is None:
            return None
        found += asked
        if start is not None:
            found += self._closing_up(a, b, start)
        return found

    def _crossed(self, a: Sample, b: Sample) -> list[tuple[Margin, float]] | None:
        """Margins that are positive at a and negative at b, and where they vanish in between.

        As a part of the way, by cubics. None if one of them was not there at a.
        """
        found = []
        scale = scales(len(a.orbit), self.settings)
        length = float(np.linalg.norm((b.orbit.point - a.orbit.point) / scale))
        rates = a.tangent * scale * length, b.tangent * scale * length
        for i, (one, other) in enumerate(zip(a.orbit.images, b.orbit.images, strict=True)):
            for code in other.causes[other.margins < 0.0].tolist():
                if self._on_border(i) and self.closing.code == code:  # type: ignore[attr-defined]
                    continue
                before, after = one.margin(code), other.margin(code)
                if not before > 0.0:
                    return None
                slopes = (
                    float(image.gradient(code) @ rate[[i, -1]])
                    for image, rate in zip((one, other), rates, strict=True)
                )
                found.append((Margin(i, code), _root(before, after, *slopes)))
        return found

    def _dips(self, a: Sample, b: Sample, step: float, own: tuple[Margin, ...]) -> bool:
        """Whether a margin, but those that vanish at the second, may vanish between two samples."""
        scale, numerics = scales(len(a.orbit), self.settings), self.settings.numerics
        ends, trusted = (a.tangent * scale, b.tangent * scale), step <= numerics.blurred
        if self.order and trusted:
            return False  # where a jump is does not depend on how often its piece changes
        for i, (one, other) in enumerate(zip(a.orbit.images, b.orbit.images, strict=True)):
            along, there = (np.array([end[i], end[-1]]) for end in ends)
            vanishing = (*own, self.closing) if isinstance(self.closing, Margin) else own
            for code in (margin.code for margin in vanishing if margin.index == i):
                one, other = one.without(code), other.without(code)
            if lowest_dip(one, other, step, along, there, numerics, trusted) is not None:
                return True
        return False

    def _at_border(
        self, a: Sample, b: Sample, step: float, margin: Margin, part: float
    ) -> _Event | None:
        """Where a margin vanishes, about a part of the way from one sample to another.

        None if another one does so before.
        """
        guess = self._on_cubic(a, b, part)
        solution = solve(guess, (self.closing, margin), self.settings)
        if solution.converged and not self._joins(a, solution.orbit, margin):
            inside = self._just_inside(a, margin)
            solution = solve(a.orbit, (self.closing, inside), self.settings)
            if not self._joins(a, solution.orbit, margin):
                return None
        if not solution.converged:
            return None
        softened = self._softened(solution.orbit, margin)
        event = self._event(a, step, Stop.BORDER, softened, (margin,))
        if event is not None and step > self.settings.again and self._rises(event.sample, margin):
            return None  # it has vanished before, and is back: the branch comes from beyond
        return event

    def _rises(self, sample: Sample, margin: Margin) -> bool:
        """Whether a margin grows along a branch."""
        along = sample.tangent * scales(len(sample.orbit), self.settings)
        return float(margin.row(sample.orbit) @ along) > 0.0

    def _joins(self, a: Sample, orbit: Orbit, margin: Margin) -> bool:
        """Whether a piece has the same value at a border as right inside of it.

        Where two of its solutions meet at the border, as at a square root, rounding may lead to the
        other one there.
        """
        image = orbit.images[margin.index]
        there = self._inside(orbit, margin, a.orbit.images[margin.index].piece)
        steepest = max(abs(there.slope), abs(image.slope))
        rise = 2.0 * self.settings.numerics.strays * self.settings.resolved * steepest
        slack = rise + self.settings.same * self.settings.x_scale
        return bool(there.reason) or not abs(there.value - image.value) > slack

    def _just_inside(self, a: Sample, margin: Margin) -> Margin:
        """A margin that is positive, by more than its rounding."""
        gradient = np.abs(a.orbit.images[margin.index].gradient(margin.code))
        size = gradient @ [self.settings.x_scale, self.settings.p_scale]
        return replace(margin, value=self.settings.numerics.noise * SPACING * float(size))

    def _softened(self, orbit: Orbit, margin: Margin) -> Orbit:
        """An orbit at a border, with the slopes right beside it if those at it are others.

        Where a time goes like a root of the distance the slope at the border is made of rounding,
        even where the map is smooth.
        """
        i, image = margin.index, orbit.images[margin.index]
        there = self._inside(orbit, margin, image.piece)
        size = self.settings.kink * max(1.0, abs(image.slope), abs(there.slope))
        if there.reason or abs(there.slope - image.slope) <= size:
            return orbit
        image = image._replace(slope=there.slope, d_parameter=there.d_parameter)
        return Orbit(orbit.x, orbit.p, (*orbit.images[:i], image, *orbit.images[i + 1 :]))

    def _inside(self, orbit: Orbit, margin: Margin, piece: Piece) -> Image:
        """The image right inside of a border that an orbit meets."""
        away = orbit.images[margin.index].onward(margin.code) * self.settings.resolved
        return piece.at(float(orbit.x[margin.index]) - away, orbit.p)

    def _event(
        self, a: Sample, step: float, stop: Stop, orbit: Orbit, margins: tuple[Margin, ...] = ()
    ) -> _Event | None:
        scale, slack = scales(len(orbit), self.settings), self.settings.numerics.slack
        distance = float(a.tangent @ ((orbit.point - a.orbit.point) / scale))
        if not -self.settings.same <= distance <= step * (1.0 + slack) + self.settings.same:
            return None
        return _Event(stop, self.sample(orbit, a.tangent), distance, margins)

    def _on_cubic(self, a: Sample, b: Sample, part: float) -> Orbit:
        """The orbit at a part of the way from one sample to another, on the cubic through both."""
        scale = scales(len(a.orbit), self.settings)
        chord = (b.orbit.point - a.orbit.point) / scale
        length = float(np.linalg.norm(chord))
        first, last = length * a.tangent, length * b.tangent
        cubic, square = first + last - 2.0 * chord, 3.0 * chord - 2.0 * first - last
        move = part * (first + part * (square + part * cubic)) * scale
        x, p = a.orbit.x + move[:-1], a.orbit.p + float(move[-1])
        images = tuple(
            image.piece.at(float(value), p) for image, value in zip(a.orbit.images, x, strict=True)
        )
        return Orbit(x, p, images)

    def _at_ends(self, a: Sample, b: Sample, step: float) -> list[_Event] | None:
        """Ends of the span and of the window; None if one was passed and is not found."""
        found = []
        for stop, index, (low, high) in self._limits(a.orbit):
            one, other = float(a.orbit.point[index]), float(b.orbit.point[index])
            for end, outward in ((low, -1.0), (high, 1.0)):
                if outward * (other - end) >= 0.0 > outward * (one - end):
                    guess = self._on_cubic(a, b, (end - one) / (other - one))
                    condition = Coordinate(index, end)
                    solution = solve(guess, (self.closing, condition), self.settings)
                    event = self._event(a, step, stop, solution.orbit)
                    if not solution.converged or event is None:
                        return None
                    found.append(event)
        return found

    def _located(self, a: Sample, step: float, test: Test, finest: float) -> list[_Event] | None:
        """Where a test function vanishes; None if the branch is lost on the way.

        Beside a square root a multiplier changes its sign through infinity: that is no event.
        """
        found: dict[float, Sample] = {}

        def value(distance: float) -> float:
            sample = a if distance == 0.0 else self.advance(a, distance)
            if isinstance(sample, float):
                raise _LostError
            found[distance] = sample
            return test.value(sample)

        try:
            root = float(brentq(value, 0.0, step, xtol=max(finest * step, SPACING)))
        except (_LostError, ValueError):
            return None
        nearest = min(found, key=lambda distance: abs(distance - root))
        values = [abs(test.value(found[distance])) for distance in (0.0, nearest, step)]
        if 2.0 * values[1] > min(values[::2]):
            return []
        there = found[nearest]
        if a.jump is not None and test.stop is Stop.FOLD:
            there = replace(there, jump=carried_over(self.map, a.jump, there.orbit))
        return [_Event(test.stop, there, nearest)]

    def _at_branch_point(self, a: Sample, b: Sample, step: float) -> list[_Event] | None:
        """Where another branch crosses; None if it is not found, none if none crosses after all."""
        orbit = saddle(self._on_cubic(a, b, 0.5), self.settings)
        ways = () if orbit is None else directions(orbit, self.settings)
        if orbit is None or not ways:
            folds = a.tangent[-1] * b.tangent[-1] < 0.0
            return self._located(
                a, step, TURNING if folds else BRANCHING, self.settings.numerics.crossing
            )
        away = (orbit.point - a.orbit.point) / scales(len(orbit), self.settings)
        distance, same = float(a.tangent @ away), self.settings.same
        longest = step * (1.0 + self.settings.max_turn) + same
        if not (
            distance >= -same
            and float(np.linalg.norm(away)) <= longest
            and closes(orbit, self.settings)
        ):
            return None  # it has led to another branch
        along = max(ways, key=lambda way: abs(float(way @ a.tangent)))
        along = along if along @ a.tangent >= 0.0 else -along
        return [_Event(Stop.BRANCHING, Sample(orbit, along, b.forward), distance)]

    def _at_diagonal(self, a: Sample, b: Sample, step: float) -> list[_Event] | None:
        """Where a limit of a jump meets the diagonal: there the orbit of the jump closes."""
        if a.jump is None:
            return []
        found = []
        for inner, before in zip((True, False), a.jump.offsets, strict=True):
            one = a.jump.cycle(inner)
            other = continued(one, b.orbit)
            after = other.images[-1].value - float(other.x[0])
            if not before * after < 0.0:
                continue
            guess = between(one, other, before / (before - after))
            margin = Margin(len(a.orbit) - 1, a.jump.code(inner))
            border = a.jump.at_border(inner, self.settings)
            solution = solve(guess, (Closed(), border), self.settings)
            event = self._at_head(a, step, Stop.LIMIT, solution, inner, (margin,))
            if event is None:
                return None
            found.append(event)
        return found

    def _still_crosses(self, a: Sample, event: _Event) -> bool:
        """Whether a jump crosses the diagonal until right before an event.

        Where borders follow each other closely a limit may have met the diagonal unseen.
        """
        before = event.distance * (1.0 - self.settings.numerics.right_before)
        if event.stop is Stop.LIMIT or before < self.settings.min_step:
            return True
        sample = self.advance(a, before)
        return isinstance(sample, Sample) and sample.jump is not None and sample.jump.crosses

    def _at_tails(self, a: Sample, b: Sample, step: float) -> list[_Event] | None:
        """Where the orbit of a limit meets a border."""
        if a.jump is None or b.jump is None:
            return []
        found = []
        for inner in (True, False):
            one, other = (j.inner if inner else j.outer for j in (a.jump, b.jump))
            if one.keys == other.keys:
                continue
            event = self._at_tail(a, b, step, inner)
            if event is not None:
                found.append(event)
            elif step > self.settings.numerics.blurred or not b.jump.crosses:
                return None
        return found

    def _at_tail(self, a: Sample, b: Sample, step: float, inner: bool) -> _Event | None:
        """Where the orbit of a limit meets a border."""
        assert a.jump is not None
        k, there = len(a.orbit), a.jump.cycle(inner)
        far = continued(there, b.orbit)
        found = None
        for i in range(k - 1, len(far)):
            own = a.jump.code(inner) if i == k - 1 else -1
            one, other = there.images[i], far.images[i]
            fallen = [c for c in other.causes[other.margins < 0.0].tolist() if c != own]
            fallen = [c for c in fallen if one.margin(c) > 0.0]
            if fallen:
                found = Margin(i, fallen[0])
                break
        if found is None:
            return None
        n, before, after = (
            found.index + 1,
            there.images[found.index].margin(found.code),
            far.images[found.index].margin(found.code),
        )
        guess = between(there.head(n), far.head(n), before / (before - after))
        border = a.jump.at_border(inner, self.settings)
        solution = solve(guess, (border, found), self.settings)
        return self._at_head(a, step, Stop.TAIL, solution, inner, (found,))

    def _holds(self, orbit: Orbit, border: int, margin: Margin) -> bool:
        """Whether the orbit of a limit lies inside of its pieces, but where it meets borders."""
        least = self.settings.thinnest
        for i, image in enumerate(orbit.images):
            if i == border:  # two margins may vanish there: the nearest is that of the border
                away = image.margins + least * np.abs(image.gradients[:, 0])
                if (away < 0.0).any():
                    return False
            elif depth(image, margin.code if i == margin.index else -1) < -least:
                return False
        return True

    def _at_head(
        self, a: Sample, step: float, stop: Stop, solution: Solution, inner: bool,
        margins: tuple[Margin, ...],
    ) -> _Event | None:  # fmt: skip
        """An event of a limit as one of the border orbit; None if a piece has ended before."""
        if not solution.converged or not self._holds(solution.orbit, len(a.orbit) - 1, margins[-1]):
            return None
        orbit, k = solution.orbit, len(a.orbit)
        head = orbit_of(a.orbit.pieces, orbit.x[:k], orbit.p)
        event = self._event(a, step, stop, head, margins)
        return None if event is None else replace(event, inner=inner, meeting=orbit)

    def _closing_up(self, a: Sample, b: Sample, start: Sample) -> list[_Event]:
        """Whether the branch passes through its own start."""
        if b.orbit.keys != start.orbit.keys:
            return []
        scale = scales(len(start.orbit), self.settings)
        one, other = ((s.orbit.point - start.orbit.point) / scale for s in (a, b))
        length = float(np.linalg.norm(other - one))
        before, after = float(start.tangent @ one), float(start.tangent @ other)
        if not (before < 0.0 <= after and np.linalg.norm(one) <= 2.0 * length):
            return []
        off = one + (other - one) * (before / (before - after))
        if np.linalg.norm(off) > self.settings.max_turn * length:
            return []
        return [_Event(Stop.CLOSED, Sample(start.orbit, start.tangent), -float(a.tangent @ one))]


def pulled_inside(predicted: Orbit, last: Orbit) -> Orbit:
    """A guess whose points have been moved, where pieces have no value, to margins as they were.

    Right beside a square root a branch follows the end of its piece: a guess that misses it by less
    than its own error lies beyond.
    """
    x, images = predicted.x.copy(), list(predicted.images)
    for i, (image, before) in enumerate(zip(predicted.images, last.images, strict=True)):
        for code in image.causes[image.margins < 0.0].tolist() if image.reason else ():
            rate = float(image.gradient(code)[0])
            if rate != 0.0 and images[i].reason:
                x[i] += (before.margin(code) - images[i].margin(code)) / rate
                images[i] = image.piece.at(float(x[i]), predicted.p)
    return Orbit(x, predicted.p, tuple(images))


def nearest_value(image: Image, x: float, to: float, p: float) -> float:
    """The value of a piece at a place, or the last that it has on the way there."""
    found = image.piece.at(to, p)
    inside, outside = x, to
    while found.reason:
        middle = 0.5 * (inside + outside)
        if middle in (inside, outside):
            return image.piece.at(inside, p).value
        if image.piece.at(middle, p).reason:
            outside = middle
        else:
            inside = middle
    return found.value


def continued(cycle: Orbit, head: Orbit) -> Orbit:
    """The orbit that starts like ``head`` and goes on with the pieces of a longer one.

    It ends where a piece has no value.
    """
    x, images = list(head.x.tolist()), list(head.images[:-1])
    for piece in cycle.pieces[len(head) - 1 :]:
        images.append(piece.at(x[-1], head.p))
        if images[-1].reason or len(images) == len(cycle):
            break
        x.append(images[-1].value)
    return Orbit(np.array(x), head.p, tuple(images))


def _root(before: float, after: float, rise: float, rise_there: float) -> float:
    """Where the cubic with these values and slopes, of different signs at 0 and 1, vanishes."""
    change = after - before
    cubic, square = rise + rise_there - 2.0 * change, 3.0 * change - 2.0 * rise - rise_there
    if not math.isfinite(cubic):
        return before / (before - after)
    return float(brentq(lambda s: before + s * (rise + s * (square + s * cubic)), 0.0, 1.0))


def _angle(one: Floats, other: Floats) -> float:
    return math.acos(min(1.0, max(-1.0, float(one @ other))))


FOLD = Test(Stop.FOLD, lambda sample: float(sample.tangent[-1]))
BRANCHING = Test(Stop.BRANCHING, lambda sample: sample.orbit.multiplier - 1.0)
TURNING = Test(Stop.BRANCHING, FOLD.value)
FLIP = Test(Stop.FLIP, lambda sample: sample.orbit.multiplier + 1.0)
