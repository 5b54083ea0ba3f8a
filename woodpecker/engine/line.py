"""Maps of the line as maps of R^1 with one parameter, and what they take beside a border.

A map of the line need not know its germs. What it takes beside a point is *proposed* by its images
at small distances, and *accepted* by the signs of margins and their derivatives at the point
itself: which distance it was proposed at does not matter then.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import replace
from typing import NamedTuple, Protocol

import numpy as np

from woodpecker.base.arrays import Floats, Ints
from woodpecker.engine.maps import ACCUMULATE, Image

DISTANCES = tuple(2.0**-n for n in (22, 28, 34, 40, 46, 16, 10))  # scaled, of proposals
CLOSER = 2.0**-33  # scaled: where slopes still have some digits left, and next to no curvature
SMOOTH = 2.0**-18  # of slopes: those of a smooth piece differ by less at the distances above
ROOT = 4.0  # times steeper at that distance, or times as high as that slope says: a root
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
    """A piece of one, see :class:`woodpecker.maps.Piece`."""

    @property
    def key(self) -> Hashable:
        """The same for two pieces just if they are one."""

    @property
    def word(self) -> str:
        """Its name for people."""

    def cause(self, code: int) -> str:
        """A sentence on what happens where a margin vanishes."""


class LinePiece(NamedTuple):
    """A piece of a map of the line as one of R^1."""

    own: PieceOfLine

    @property
    def key(self) -> Hashable:
        """That of the piece."""
        return self.own.key

    @property
    def word(self) -> str:
        """That of the piece."""
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
    """The image of a point (1,) under the piece that a map takes infinitesimally beside it.

    If no proposal is accepted the image has a reason: the map has no value right beside the point,
    or its pieces accumulate there.

    Parameters
    ----------
    map_, x, p, direction
        As :meth:`woodpecker.engine.maps.PiecewiseMap.beside` has them.
    scale
        Lengths of x and of the k parameters that count as 1.
    """
    length = float(np.abs(direction / np.array(scale)).max())
    if length == 0.0:
        return replace(map_.at(x, p), reason=ACCUMULATE)
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
    return around or replace(map_.at(x, p), reason=lost or ACCUMULATE)


def limit(near: Image, x: Floats, p: Floats, unit: Floats) -> Image:
    """The one-sided limit at (x, p) of the piece of an image that lies a little away.

    Where a time goes like a root of the distance the piece may have no value right at the point, or
    derivatives there are made of rounding: they are those beside it then. If those grow without
    bound, as the inverse of the root, the image has a square root there: its derivatives are those
    beside it, and it says so by its size.
    """
    there = near.piece.at(x, p)
    if not there.reason and _alike(there.jacobian, near.jacobian, SMOOTH):
        return there
    away = CLOSER * unit
    closer = near.piece.at(x + away[:1], p + away[1:])
    if closer.reason:
        return closer
    if not there.reason and _comes_to(near.jacobian, closer.jacobian, there.jacobian):
        return there
    rooted = float(np.abs(closer.jacobian).max()) > ROOT * max(
        1.0, float(np.abs(near.jacobian).max())
    )
    along = closer.jacobian @ away
    value = closer.value - (2.0 * along if rooted else along)
    if not there.reason and np.abs(there.value - value).max() <= ROOT * np.abs(along).max():
        value = there.value  # where two solutions of an event meet it may be that of the other one
    return replace(closer, value=value, margins=closer.margins - closer.gradients @ away)


def _comes_to(one: Floats, closer: Floats, there: Floats) -> bool:
    """Whether derivatives at a point are what those ever closer to it come to."""
    return bool(np.abs(closer - there).max() <= 0.5 * np.abs(one - there).max())


def _alike(one: Floats, other: Floats, within: float) -> bool:
    size = max(1.0, float(np.abs(one).max()), float(np.abs(other).max()))
    return bool(np.abs(one - other).max() <= within * size)


def image_of(own: Imaged) -> Image:
    """An image of a map of the line as one of R^1."""
    return Image(
        np.array([own.value]), np.array([[own.slope, own.d_parameter]]), own.margins,
        own.gradients, own.causes, LinePiece(own.piece), own.reason,
    )  # fmt: skip
