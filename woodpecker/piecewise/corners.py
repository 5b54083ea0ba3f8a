"""Corners: places where borders of a map meet, and the jumps that leave them.

Around a corner lie sectors, one for each piece of P_N, and jumps cross the diagonal where two
neighbouring sectors lie on different sides of it. All there are show on a small circle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.piecewise.margins import depth
from woodpecker.piecewise.orbits import Distance, Margin, Orbit, scales, solve
from woodpecker.piecewise.pieces import PiecewiseMap
from woodpecker.piecewise.settings import Settings


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
    numerics, way = settings.numerics, math.atan2(known[1], known[0])
    even = np.linspace(0.0, 2.0 * math.pi, numerics.spokes, endpoint=False)[1:]
    beside = np.array(numerics.wedges)
    angles = way + np.sort([*-beside, *beside, *even])
    angles = np.append(angles, angles[0] + 2.0 * math.pi)
    spokes = [_spoke(map_, corner, order, radius, a, settings) for a in angles[:-1].tolist()]
    around = [*spokes, spokes[0]]
    found = []
    for k, (one, other) in enumerate(pairwise(around)):
        if not one.offset * other.offset < 0.0:
            continue
        low, high, to = one, other, float(angles[k + 1])
        while to - low.angle > numerics.narrow:
            middle = _spoke(map_, corner, order, radius, 0.5 * (low.angle + to), settings)
            if low.offset * middle.offset < 0.0:
                high, to = middle, middle.angle
            else:
                low = middle
        met = _between(low, high, corner, radius, settings)
        if met is not None:
            found.append(met)
    return found


def _spoke(
    map_: PiecewiseMap, corner: tuple[float, float], order: int, radius: float, angle: float,
    settings: Settings,
) -> _Spoke:  # fmt: skip
    found = _straight(map_, corner, order, radius, angle, settings)
    least = settings.converged * settings.x_scale
    if any(abs(depth(image)) <= least for image in found.orbit.images):
        aside = angle + settings.numerics.aside * settings.numerics.narrow
        return _straight(map_, corner, order, radius, aside, settings)
    return found


def _straight(
    map_: PiecewiseMap, corner: tuple[float, float], order: int, radius: float, angle: float,
    settings: Settings,
) -> _Spoke:  # fmt: skip
    """The spoke at just this angle."""
    x = [corner[0] + radius * settings.x_scale * math.cos(angle)]
    p = corner[1] + radius * settings.p_scale * math.sin(angle)
    images = [map_.at(x[0], p)]
    while len(images) < order and not images[-1].reason:
        x.append(images[-1].value)
        images.append(map_.at(x[-1], p))
    offset = math.nan if images[-1].reason else images[-1].value - x[0]
    return _Spoke(angle, Orbit(np.array(x), p, tuple(images)), offset)


def _between(
    one: _Spoke, other: _Spoke, corner: tuple[float, float], radius: float, settings: Settings
) -> Leaving | None:
    """The jump between two spokes, as the pieces of the first meet it; None if there is none."""
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
    base[[0, -1]] = corner
    direction[[0, -1]] = math.cos(one.angle), math.sin(one.angle)
    on_circle = Distance(base, direction, radius, scales(n, settings))
    root = solve(head, (closing, on_circle), settings)
    off = np.abs((root.orbit.point - head.point) / scales(n, settings))[[0, -1]].max()
    near = root.converged and off <= settings.numerics.held * radius
    return Leaving(root.orbit, closing, direction[[0, -1]]) if near else None
