"""Where a branch meets a border: what is there, and the orbit beyond it."""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import dataclass, replace

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.piecewise.borders import Border, beyond
from woodpecker.piecewise.orbits import (
    Closed,
    Condition,
    Coordinate,
    Distance,
    Margin,
    Orbit,
    minimal_period,
    moved,
    orbit_of,
    residuals,
    scales,
    solve,
    tangent,
)
from woodpecker.piecewise.pieces import Image, PiecewiseMap
from woodpecker.piecewise.samples import Sample
from woodpecker.piecewise.settings import Numerics, Settings


def border_at(map_: PiecewiseMap, orbit: Orbit, margin: Margin, settings: Settings) -> Border:
    """The border that a point of an orbit meets."""
    i = margin.index
    image, x = orbit.images[i], float(orbit.x[i])
    side = image.onward(margin.code)
    outer, code = beyond(map_, x, orbit.p, side, settings)
    if _may_be_none(outer.value - image.value, (image, outer), settings):
        outer, code = beyond(map_, x, orbit.p, side, settings, settings.resolved)
    with np.errstate(divide="ignore", invalid="ignore"):
        away = abs(outer.margin(code) / outer.gradient(code)[0])
    if away > settings.same * settings.x_scale:
        code = -1  # the piece that was found beyond does not begin here: there are others between
    return Border(x, orbit.p, image, margin.code, side, outer, code)


def _may_be_none(jump: float, images: tuple[Image, Image], settings: Settings) -> bool:
    """Whether a jump is so small that another solution of a piece beside the border explains it.

    At a grazing two of them meet, and from a distance the wrong one may be followed back.
    """
    steepest = max(abs(image.slope) for image in images)
    most = settings.numerics.strays * settings.beside * steepest
    return settings.jump * settings.x_scale < abs(jump) <= most * settings.x_scale


def cycle_at_border(
    map_: PiecewiseMap, x: Floats, p: float, margin: Margin, side: int, key: Hashable,
    settings: Settings,
) -> Orbit | None:  # fmt: skip
    """A cycle by its places, with the pieces that the map takes there.

    One of its points lies on a border of the piece of a key, which is met right inside of it. Where
    borders meet that piece may be a wedge that is seen at other parameters only. None if the map
    has no such border.
    """
    pieces = [map_.at(float(each), p).piece for each in x]
    on, closer = margin.index, list[float]()
    away = settings.beside
    while away >= settings.nearest:  # ten times closer each time
        closer.append(away)
        away *= settings.numerics.nearer
    for angle in _angles(settings.numerics):
        dx, dp = side * math.cos(angle) * settings.x_scale, math.sin(angle) * settings.p_scale
        for away in closer:
            pieces[on] = map_.at(float(x[on]) + away * dx, p + away * dp).piece
            orbit = differentiable(orbit_of(pieces, x, p), margin, settings)
            if pieces[on].key == key and _is_at_border(orbit, margin, settings):
                return orbit
    return None


def _angles(numerics: Numerics) -> list[float]:
    """Angles [rad], from the way into a piece, at which a wedge of it is looked for."""
    apart, most = 2.0 * math.pi / numerics.fan, (numerics.fan - 1) // 4
    return [0.0, *(sign * k * apart for k in range(1, most + 1) for sign in (1.0, -1.0))]


def _is_at_border(orbit: Orbit, margin: Margin, settings: Settings) -> bool:
    """Whether an orbit is a cycle, and a margin vanishes there."""
    if not orbit.defined:
        return False
    image = orbit.images[margin.index]
    away = settings.same * settings.x_scale * abs(image.gradient(margin.code)[0])
    off = float(np.abs(residuals(orbit, (Closed(),))).max())
    same = max(settings.jump, settings.nearest * max(abs(i.slope) for i in orbit.images))
    return abs(image.margin(margin.code)) <= away and not off > same * settings.x_scale


@dataclass(frozen=True, slots=True, eq=False)
class Restart:
    """Where a branch goes on beyond a border.

    Attributes
    ----------
    sample
        The first one beyond.
    step
        The first step from there: a short one if a fold or a flip is known to lie ahead.
    """

    sample: Sample
    step: float = math.inf

    @property
    def multiplier(self) -> float:
        """Beyond the border."""
        return self.sample.orbit.multiplier


def restart(
    orbit: Orbit, closing: Condition, border: Border, index: int, settings: Settings
) -> Restart | None:
    """The orbit beyond a border, whose margin there is small and positive; None if there is none.

    That is well posed also where the piece beyond begins with a square root. A branch through a
    border of a continuous map goes on with the multiplier that the piece beyond has there. An orbit
    on the other side of a fold or a flip lies beyond that point, or on another sheet of the branch:
    it is taken only if none is found closer to the border, as where they are one point with it.
    """
    tiny = border.side * settings.resolved
    right_beside = border.outer.piece.at(border.x + tiny, border.p)  # at a root only there is one
    outer = border.outer if right_beside.reason else right_beside  # slope that rounding leaves
    at_border = Orbit(orbit.x, orbit.p, replaced(orbit.images, index, outer)).multiplier
    found: Sample | None = None
    away, same = settings.beside * settings.x_scale, settings.same * settings.x_scale
    while away >= settings.nearest * settings.x_scale:  # a hundred times closer each time
        there = _restarted(orbit, closing, border, index, away, settings)
        if there is not None and _period(there.orbit, settings) < _period(orbit, settings):
            there = None  # a flip that ends the branch lies closer
        if there is not None and _sides(there.orbit.multiplier) == _sides(at_border):
            step = math.inf if found is None else _distance(orbit, there, settings)
            return Restart(there, step)
        if there is not None and (found is None or away >= same):
            # from here the piece is followed back: at a root it may start badly
            found, border = there, replace(border, outer=_led_back(there, border, index))
        away *= settings.numerics.restart
    found = found or _ahead(orbit, closing, border, index, settings)
    return None if found is None else Restart(found)


def _period(orbit: Orbit, settings: Settings) -> int:
    """The minimal period, of points that are one to rounding."""
    return minimal_period(orbit, settings, settings.same)


def _distance(orbit: Orbit, there: Sample, settings: Settings) -> float:
    """How far a sample lies from an orbit, scaled, or the shortest step if they are the same."""
    way = (there.orbit.point - orbit.point) / scales(len(orbit), settings)
    return max(float(np.linalg.norm(way)), settings.min_step)


def _ahead(
    orbit: Orbit, closing: Condition, border: Border, index: int, settings: Settings
) -> Sample | None:
    """The orbit a distance along the branch beyond a border; None if there is none.

    Where the piece beyond is steep its orbits stay close to the border as it moves: no margin can
    be given in advance that such an orbit has.
    """
    if border.outer_code < 0 or border.outer.reason:
        return None
    start = Orbit(orbit.x, orbit.p, replaced(orbit.images, index, border.outer))
    along, scale = tangent(start, closing, settings), scales(len(orbit), settings)
    inward = float(border.outer.gradient(border.outer_code) @ (along * scale)[[index, -1]])
    along = along if inward > 0.0 else -along
    away = settings.beside
    while np.isfinite(along).all() and away >= settings.nearest:
        distance = Distance(start.point, along, away, scale)
        solution = solve(moved(start, away * along * scale), (closing, distance), settings)
        found, direction = solution.orbit, tangent(solution.orbit, closing, settings)
        if solution.converged and np.isfinite(direction).all() and is_inside(found, closing):
            forward = float(direction @ along) > 0.0
            return Sample(found, direction if forward else -direction, forward)
        away *= settings.numerics.restart
    return None


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
    # Beside a square root a margin cannot be held to the last bit; the parameter can, unless the
    # branch turns round there.
    moves = np.abs(held.orbit.x - found.x).max()
    if held.converged and moves <= settings.numerics.held * away:
        found = held.orbit
    direction = tangent(found, closing, settings)
    if not (solution.converged and np.isfinite(direction).all() and is_inside(found, closing)):
        return None
    forward = float(direction @ ((found.point - orbit.point) / scales(len(orbit), settings))) > 0.0
    return Sample(found, direction if forward else -direction, forward)


def replaced(images: tuple[Image, ...], i: int, image: Image) -> tuple[Image, ...]:
    """Images with another one in the place of one of them."""
    return (*images[:i], image, *images[i + 1 :])


def differentiable(orbit: Orbit, margin: Margin, settings: Settings) -> Orbit:
    """An orbit at a border; where a root begins right there with the derivatives beside it."""
    i, image = margin.index, orbit.images[margin.index]
    if math.isfinite(image.slope):
        return orbit
    x = float(orbit.x[i])
    away = image.onward(margin.code) * settings.rounded_x(x)
    there = image.piece.at(x - away, orbit.p)
    image = image._replace(slope=there.slope, d_parameter=there.d_parameter)
    return Orbit(orbit.x, orbit.p, replaced(orbit.images, i, image))


def is_inside(orbit: Orbit, closing: Condition) -> bool:
    """Whether all margins are positive, but for the one at the end of a border orbit."""
    for i, image in enumerate(orbit.images):
        own = closing.code if isinstance(closing, Margin) and closing.index == i else -1
        if ((image.margins < 0.0) & (image.causes != own)).any():
            return False
    return True
