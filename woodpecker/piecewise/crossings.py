"""What lies where an orbit meets a border."""

from __future__ import annotations

import numpy as np

from woodpecker.piecewise.borders import Border, beyond
from woodpecker.piecewise.orbits import Condition, Margin, Orbit
from woodpecker.piecewise.pieces import Image, PiecewiseMap
from woodpecker.piecewise.settings import Settings


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


def is_inside(orbit: Orbit, closing: Condition) -> bool:
    """Whether all margins are positive, but for the one at the end of a border orbit."""
    for i, image in enumerate(orbit.images):
        own = closing.code if isinstance(closing, Margin) and closing.index == i else -1
        if ((image.margins < 0.0) & (image.causes != own)).any():
            return False
    return True
