"""One step along a branch of orbits with fixed pieces: predictor and corrector."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.piecewise.jumps import jump_of
from woodpecker.piecewise.orbits import (
    Condition,
    Coordinate,
    Distance,
    Margin,
    Orbit,
    scales,
    solve,
    tangent,
)
from woodpecker.piecewise.pieces import Image, PiecewiseMap, judge
from woodpecker.piecewise.samples import Sample, angle
from woodpecker.piecewise.settings import Settings


class Corrector:
    """Finds neighbouring orbits of one kind.

    Parameters
    ----------
    map_
        The map; it has the last word on which piece is taken.
    closing
        The condition that makes orbits a branch: a cycle closes, a border orbit ends at a border.
    settings
        Steps and tolerances.
    order
        Of the jumps; 0 for cycles.
    """

    def __init__(
        self, map_: PiecewiseMap, closing: Condition, settings: Settings, order: int = 0
    ) -> None:
        self.map, self.closing, self.settings, self.order = map_, closing, settings, order
        self._taken = judge(map_)

    def sample(self, orbit: Orbit, along: Floats) -> Sample:
        """An orbit with its tangent, which points like another one.

        At a border beside a cube root it may have none: then the other one is taken for it.
        """
        direction = tangent(orbit, self.closing, self.settings)
        if not np.isfinite(direction).all():
            return self.completed(Sample(orbit, along))
        forward = bool(direction @ along >= 0.0)
        return self.completed(Sample(orbit, direction if forward else -direction, forward))

    def completed(self, sample: Sample) -> Sample:
        """A sample with its jump, if jumps are followed."""
        if not (self.order and isinstance(self.closing, Margin)):
            return sample
        jump = jump_of(self.map, sample.orbit, self.closing, self.order, self.settings)
        return replace(sample, jump=jump)

    def advance(self, last: Sample, step: float, before: Sample | None = None) -> Sample | float:
        """The sample one step ahead, or a shorter step to try.

        It is predicted along the tangent, or along the cubic through the sample before too: where
        orbits are steep Newton's method needs to start close by.
        """
        scale, numerics = scales(len(last.orbit), self.settings), self.settings.numerics
        predicted = self._predicted(last, step, scale, before)
        if not predicted.defined:
            predicted = pulled_inside(predicted, last.orbit)
        if not predicted.defined:
            return 0.5 * step
        distance = Distance(last.orbit.point, last.tangent, step, scale)
        solution = solve(predicted, (self.closing, distance), self.settings, contracts=True)
        if solution.converged and not self.is_met(solution.orbit):  # steep: rounding of a step was
            solution = solve(solution.orbit, (self.closing, distance), self.settings)  # too much
        if not solution.converged or not self.is_met(solution.orbit):
            return 0.5 * step
        found = tangent(solution.orbit, self.closing, self.settings)
        if not np.isfinite(found).all():
            return 0.5 * step
        forward = bool(found @ last.tangent >= 0.0)
        found = found if forward else -found
        turned, most = angle(last.tangent, found), self.turn(step)
        if turned > most:
            return max(numerics.retry, numerics.kept_turn * most / turned) * step
        return self.completed(Sample(solution.orbit, found, forward))

    def to_end(self, last: Sample, step: float) -> Sample | None:
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
        if angle(last.tangent, direction) > 0.5 * math.pi:
            direction = -direction
        if angle(last.tangent, direction) > self.settings.max_turn:
            return None
        found = Orbit(solution.orbit.x, end, solution.orbit.images)
        return self.sample(found, last.tangent)

    def ahead(self, last: Sample, step: float) -> Orbit:
        """Where the tangent leads, under the pieces of a sample; no orbit yet."""
        return self._predicted(last, step, scales(len(last.orbit), self.settings))

    def between(self, a: Sample, b: Sample, part: float) -> Orbit:
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

    def agrees(self, orbit: Orbit) -> bool:
        """Whether the map takes the pieces of an orbit, except at the end of a border orbit."""
        points = zip(orbit.x.tolist(), orbit.images, strict=True)
        return all(
            self._is_taken(x, orbit.p, image)
            for i, (x, image) in enumerate(points)
            if not self.on_border(i)
        )

    def on_border(self, i: int) -> bool:
        """Whether a point of an orbit is the one at which a border orbit ends."""
        return isinstance(self.closing, Margin) and self.closing.index == i

    def turn(self, step: float) -> float:
        """The largest angle between tangents of samples at a distance: hairpins may be coarse."""
        own = self.settings.max_turn
        return min(
            max(own, self.settings.numerics.sharpest), max(own, own * self.settings.hairpin / step)
        )

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

    def is_met(self, orbit: Orbit) -> bool:
        """Whether each image meets the next point, or would within rounding of x and p.

        Where a piece ends in a square root, or right beyond a sharp fold, Newton's steps become
        short also if there is no orbit: what is left of the equations tells.
        """
        settings, aside = self.settings, self.settings.rounded_p(orbit.p)
        for image, x, to in zip(orbit.images, orbit.x.tolist(), self._targets(orbit), strict=True):
            off, away = image.value - to, settings.rounded_x(x)
            rounding = max(settings.rounded_x(to), away * abs(image.slope))
            rounding += aside * abs(image.d_parameter)
            if abs(off) > rounding:
                return False
            if abs(off) <= settings.same * settings.x_scale:
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

    def _is_taken(self, x: float, p: float, image: Image) -> bool:
        """Whether the map takes the piece of an image, and the same of its solutions."""
        key, value = self._taken(x, p)
        slack = self.settings.same * self.settings.x_scale * max(1.0, abs(image.slope))
        return key == image.piece.key and not abs(value - image.value) > slack


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
    while found.reason:  # halved to the last bit
        middle = 0.5 * (inside + outside)
        if middle in (inside, outside):
            return image.piece.at(inside, p).value
        if image.piece.at(middle, p).reason:
            outside = middle
        else:
            inside = middle
    return found.value
