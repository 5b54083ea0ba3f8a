"""Maps of the line as maps of R^1 with one parameter, and what they take beside a border.

A map of the line need not know its germs. What it takes beside a point is *proposed* by its images
at small distances, and *accepted* by the signs of margins and their derivatives at the point
itself, so that it does not depend on the distances.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from woodpecker.base.arrays import Floats, Ints
from woodpecker.engine.maps import ACCUMULATE, Image, limit

DISTANCES = tuple(2.0**-n for n in (22, 28, 34, 40, 46, 16, 10))  # scaled, of proposals
NEAREST = min(DISTANCES)


class Imaged(Protocol):
    """What a piece of a map of the line makes of a point, see :class:`woodpecker.maps.Image`."""

    @property
    def value(self) -> float:
        """P(x, p)."""

    @property
    def slope(self) -> float:
        """dP/dx."""

    @property
    def d_parameter(self) -> float:
        """dP/dp."""

    @property
    def margins(self) -> Floats:
        """(m,) positive where the map takes the piece."""

    @property
    def gradients(self) -> Floats:
        """(m, 2) their derivatives in x and p."""

    @property
    def causes(self) -> Ints:
        """(m,) ascending codes that tell the margins apart."""

    @property
    def piece(self) -> PieceOfLine:
        """The piece."""

    @property
    def reason(self) -> str:
        """Why there is no value; empty if there is one."""


class OfLine(Protocol):
    """A map of the line with one parameter, see :class:`woodpecker.PiecewiseMap`."""

    def at(self, x: float, p: float) -> Imaged:
        """The image of a point under the piece that the map takes there."""


class PieceOfLine(OfLine, Protocol):
    """A piece of a map of the line, see :class:`woodpecker.maps.Piece`."""

    @property
    def key(self) -> Hashable:
        """Equal for two pieces just if they are one."""

    @property
    def word(self) -> str:
        """Its name, as people read it."""

    def cause(self, code: int) -> str:
        """A sentence on what happens where a margin vanishes."""


class LinePiece(NamedTuple):
    """A piece of a map of the line as one of R^1."""

    own: PieceOfLine

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

    own: OfLine
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


class Evaluated(Protocol):
    """A map that is known by its images only."""

    def at(self, x: Floats, p: Floats) -> Image:
        """The image of a point under the piece that the map takes there."""


def proposed(
    map_: Evaluated, x: Floats, p: Floats, direction: Floats, scale: Sequence[float]
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


def image_of(own: Imaged) -> Image:
    """An image of a map of the line as one of R^1."""
    return Image(
        np.array([own.value]), np.array([[own.slope, own.d_parameter]]), own.margins,
        own.gradients, own.causes, LinePiece(own.piece), own.reason,
    )  # fmt: skip
