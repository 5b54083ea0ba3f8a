"""Corners: places where borders of a map meet, and the jumps that leave them.

Around a corner lie sectors, one for each piece of P_N, and jumps cross the diagonal where two
neighbouring sectors lie on different sides of it. All there are show on a small circle, which is
gone round from border to border.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.piecewise.margins import depth
from woodpecker.piecewise.orbits import Distance, Margin, Orbit, scales, solve
from woodpecker.piecewise.pieces import PiecewiseMap
from woodpecker.piecewise.settings import Settings

ALMOST = 1.0 + 1e-9  # an angle is rounded


@dataclass(frozen=True, slots=True, eq=False)
class _Spoke:
    """An orbit of P_N from a point of the circle.

    Attributes
    ----------
    angle
        Of the point [rad]; x points to 0, the parameter to pi/2.
    orbit
        Its points, fewer than N if the orbit is lost.
    offset
        P_N(x) - x; nan if it is lost.
    """

    angle: float
    orbit: Orbit
    offset: float


@dataclass(frozen=True, slots=True, eq=False)
class Leaving:
    """A jump that leaves a corner.

    Attributes
    ----------
    head, closing
        The border orbit on the circle, and the margin that vanishes in its last point.
    direction
        (2,) from the corner to it in scaled x and parameter, of length 1.
    """

    head: Orbit
    closing: Margin
    direction: Floats


def leaving(
    map_: PiecewiseMap, corner: tuple[float, float], order: int, known: Floats, radius: float,
    settings: Settings,
) -> list[Leaving]:  # fmt: skip
    """The jumps of P_order that leave a corner, in ascending order of their angles.

    Parameters
    ----------
    corner
        x and parameter.
    known
        (2,) direction of a jump that is known, in scaled x and parameter.
    radius
        Of the circle, in the scaled unknowns.
    """
    circle = _Circle(map_, corner, order, radius, settings)
    found = []
    for one, other in pairwise(circle.spokes(math.atan2(known[1], known[0]))):
        if one.offset * other.offset < 0.0:
            met = circle.between(one, other)
            if met is not None:
                found.append(met)
    return found


class _Circle:
    """A small circle about a corner.

    On it margins are linear in both unknowns, so that they say where the next sector begins.
    """

    def __init__(
        self, map_: PiecewiseMap, corner: tuple[float, float], order: int, radius: float,
        settings: Settings,
    ) -> None:  # fmt: skip
        self.map, self.corner, self.order, self.radius = map_, corner, order, radius
        self.settings, self.numerics = settings, settings.numerics

    def spokes(self, first: float) -> list[_Spoke]:
        """One in each sector at least, once round from an angle; none if there are too many."""
        narrow = self.numerics.narrow
        begin = first + 0.5 * narrow
        found, end = [self._spoke(begin)], begin + 2.0 * math.pi - narrow
        while found[-1].angle < end and len(found) < self.numerics.most_sectors:
            found.append(self._spoke(min(self._beyond(found[-1]), end)))
        if found[-1].angle < end:
            return []
        return [*found, replace(found[0], angle=begin + 2.0 * math.pi)]

    def between(self, low: _Spoke, high: _Spoke) -> Leaving | None:
        """The jump between two spokes, as the pieces of the first meet it; None if none is clear.

        It is closed in on from right before the place where the pieces of the first seem to end.
        """
        narrow = self.numerics.narrow
        trial = self._borders(low)[0] - 0.5 * narrow
        while high.angle - low.angle > ALMOST * narrow:  # halved, after the first trial
            inside = low.angle < trial < high.angle
            middle = self._spoke(trial if inside else 0.5 * (low.angle + high.angle))
            trial = math.inf
            if low.offset * middle.offset < 0.0:
                high = middle
            else:
                low = middle
        return self._jump(low, high)

    def _spoke(self, angle: float) -> _Spoke:
        """The orbit from an angle, turned aside if it meets a border."""
        found = self._straight(angle)
        points = zip(found.orbit.x.tolist(), found.orbit.images, strict=True)
        if any(abs(depth(image)) <= self.settings.rounded_x(x) for x, image in points):
            aside = self._straight(angle + self.numerics.aside * self.numerics.narrow)
            return replace(aside, angle=angle)
        return found

    def _straight(self, angle: float) -> _Spoke:
        """The orbit from just this angle."""
        x = [self.corner[0] + self.radius * self.settings.x_scale * math.cos(angle)]
        p = self.corner[1] + self.radius * self.settings.p_scale * math.sin(angle)
        images = [self.map.at(x[0], p)]
        while len(images) < self.order and not images[-1].reason:
            x.append(images[-1].value)
            images.append(self.map.at(x[-1], p))
        offset = math.nan if images[-1].reason else images[-1].value - x[0]
        return _Spoke(angle, Orbit(np.array(x), p, tuple(images)), offset)

    def _beyond(self, spoke: _Spoke) -> float:
        """An angle beyond the next border, and before the one after it."""
        first, second = self._borders(spoke)
        if not first < spoke.angle + self.numerics.sector:
            return spoke.angle + self.numerics.sector
        return first + 0.5 * min(self.numerics.narrow, second - first)

    def _borders(self, spoke: _Spoke) -> tuple[float, float]:
        """The next two angles at which margins of an orbit vanish; infinite if none does.

        A margin m with the gradient (a, b) vanishes where a cos + b sin has become less by m.
        Margins that vanish so close together that rounding tells their order do so at once.
        """
        found, (rate, along) = [], (1.0, 0.0)  # of x_i, in x_0 and p
        units = self.radius * np.array([self.settings.x_scale, self.settings.p_scale])
        for image in spoke.orbit.images:
            inside = image.margins > 0.0
            gradients = image.gradients[inside]
            a = gradients[:, 0] * rate * units[0]
            b = (gradients[:, 0] * along + gradients[:, 1]) * units[1]
            steepest = np.hypot(a, b)
            level = a * math.cos(spoke.angle) + b * math.sin(spoke.angle) - image.margins[inside]
            with np.errstate(divide="ignore", invalid="ignore"):
                angles = np.arctan2(b, a) + np.arccos(level / steepest)
            ahead = (angles - spoke.angle) % (2.0 * math.pi)
            found.append(ahead[np.isfinite(ahead)])
            rate, along = image.slope * rate, image.slope * along + image.d_parameter
        ahead = np.concatenate(found)
        first = float(ahead.min(initial=math.inf))
        second = float(ahead[ahead > first + self.numerics.narrow**2].min(initial=math.inf))
        return spoke.angle + first, spoke.angle + second

    def _jump(self, one: _Spoke, other: _Spoke) -> Leaving | None:
        """The jump between two spokes right beside each other; None if there is none."""
        keys = zip(one.orbit.keys, other.orbit.keys, strict=False)
        index = next((i for i, (a, b) in enumerate(keys) if a != b), -1)
        if index < 0:
            return None  # a fixed point passes
        image = one.orbit.images[index]
        way = np.array([other.orbit.x[index] - one.orbit.x[index], other.orbit.p - one.orbit.p])
        rate = image.gradients @ way
        with np.errstate(divide="ignore", invalid="ignore"):
            away = np.where(rate < 0.0, -image.margins / rate, np.inf)
        if not len(away) or not np.isfinite(away.min()):
            return None
        closing = Margin(index, int(image.causes[int(np.argmin(away))]))
        n = index + 1
        head = one.orbit.head(n)
        base, direction = np.zeros(n + 1), np.zeros(n + 1)
        base[[0, -1]] = self.corner
        direction[[0, -1]] = math.cos(one.angle), math.sin(one.angle)
        on_circle = Distance(base, direction, self.radius, scales(n, self.settings))
        root = solve(head, (closing, on_circle), self.settings)
        off = np.abs((root.orbit.point - head.point) / scales(n, self.settings))[[0, -1]].max()
        near = root.converged and off <= self.numerics.held * self.radius
        return Leaving(root.orbit, closing, direction[[0, -1]]) if near else None
