"""Maps of the line as maps of R^1 with one parameter, and what they take beside a border.

A map of the line need not know its germs. What it takes beside a point is *proposed* by its images
at small distances, and *accepted* by the signs of margins and their derivatives at the point
itself, so that it does not depend on the distances.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import NamedTuple

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.engine.maps import ACCUMULATE, Image, PiecewiseMap, limit
from woodpecker.maps import pieces

DISTANCES = tuple(2.0**-n for n in (22, 28, 34, 40, 46, 16, 10))  # scaled, of proposals
NEAREST = min(DISTANCES)


class LinePiece(NamedTuple):
    """A piece of a map of the line as one of R^1."""

    own: pieces.Piece

    @property
    def key(self) -> Hashable:
        """Of the piece."""
        return self.own.key

    @property
    def word(self) -> str:
        """Of the piece."""
        return self.own.word

    def at(self, x: Floats, p: Floats) -> Image:
        """Its image of a point, also where the map takes another piece."""
        return image_of(self.own.at(float(x[0]), float(p[0])))

    def cause(self, code: int) -> str:
        """A sentence on what happens where a margin vanishes."""
        return self.own.cause(code)


class LineMap(NamedTuple):
    """A map of the line as one of R^1.

    Parameters
    ----------
    own
        The map.
    x_scale, p_scale
        Lengths that count as 1.
    """

    own: pieces.PiecewiseMap
    x_scale: float = 1.0
    p_scale: float = 1.0

    def at(self, x: Floats, p: Floats) -> Image:
        """The image of a point under the piece that the map takes there."""
        return image_of(self.own.at(float(x[0]), float(p[0])))

    @property
    def margins_decide(self) -> bool:
        """Whether the margins of its pieces say where it takes them."""
        return getattr(self.own, "margins_decide", False)

    def taken(self, x: Floats, p: Floats) -> tuple[Hashable, Floats]:
        """The key of the piece at a point, and the value (1,) there; nan if there is none."""
        taken, at = getattr(self.own, "taken", None), (float(x[0]), float(p[0]))
        if taken is None:
            image = self.own.at(*at)
            return image.piece.key, np.array([image.value])
        key, value = taken(*at)
        return key, np.array([value])

    def beside(self, x: Floats, p: Floats, direction: Floats) -> Image:
        """The image of a point under the piece that the map takes infinitesimally beside it."""
        return proposed(self, x, p, direction, (self.x_scale, self.p_scale))


def proposed(
    map_: PiecewiseMap, x: Floats, p: Floats, direction: Floats, scale: Sequence[float]
) -> Image:
    """The image of a point (1,) under the piece infinitesimally beside it, or a reason why none.

    The map has no value right beside the point, or its pieces accumulate there. ``scale`` holds the
    lengths of x and of the k parameters.
    """
    length = float(np.abs(direction / np.array(scale)).max())
    if length == 0.0:
        return map_.at(x, p)._replace(reason=ACCUMULATE)
    unit, seen = direction / length, set[Hashable]()
    lost, around = "", None
    for distance in DISTANCES:
        proposal = map_.at(x + distance * unit[:1], p + distance * unit[1:])
        if distance == NEAREST:
            lost = proposal.reason
        if proposal.reason or proposal.piece.key in seen:
            continue
        seen.add(proposal.piece.key)
        image = limit(proposal, x, p, unit)
        if image.reason or not image.begins_along(x, p, unit):
            continue
        if image.tied(x, p).any():
            return image
        around = around or image  # its border is elsewhere: a thinner piece may begin here
    return around or map_.at(x, p)._replace(reason=lost or ACCUMULATE)


def image_of(own: pieces.Image) -> Image:
    """An image of a map of the line as one of R^1."""
    return Image(
        np.array([own.value]), np.array([[own.slope, own.d_parameter]]), own.margins,
        own.gradients, own.causes, LinePiece(own.piece), own.reason,
    )  # fmt: skip
