"""Adapters between maps of the line and maps of R^1 with one parameter."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.engine.maps import PieceView, SpaceImage, first_piece_of, proposed
from woodpecker.maps import pieces


@dataclass(frozen=True, slots=True)
class LinePiece(PieceView):
    """A piece of a map of the line as a piece in R^1."""

    own: pieces.Piece

    def at(self, x: Floats, p: Floats) -> SpaceImage:
        """The image of a point, also where the map takes another piece."""
        return image_of(self.own.at(float(x[0]), float(p[0])))


class LineMap(NamedTuple):
    """A map of the line as a map of R^1; the scales are lengths that count as 1."""

    own: pieces.PiecewiseMap
    x_scale: float = 1.0
    p_scale: float = 1.0

    def at(self, x: Floats, p: Floats) -> SpaceImage:
        """The image of a point under the piece that the map takes there."""
        return image_of(self.own.at(float(x[0]), float(p[0])))

    @property
    def evaluations(self) -> int:
        """How often the map was evaluated; 0 if it does not count that."""
        return getattr(self.own, "evaluations", 0)

    @property
    def margins_decide(self) -> bool:
        """Whether the margins alone decide where the map takes a piece."""
        return getattr(self.own, "margins_decide", False)

    def taken(self, x: Floats, p: Floats) -> tuple[Hashable, Floats]:
        """The key of the piece at a point, and the value (1,) there; nan if there is none."""
        taken, at = getattr(self.own, "taken", None), (float(x[0]), float(p[0]))
        if taken is None:
            image = self.own.at(*at)
            return image.piece.key, np.array([image.value])
        key, value = taken(*at)
        return key, np.array([value])

    def beside(self, x: Floats, p: Floats, direction: Floats) -> SpaceImage:
        """The image of a point under the piece that the map takes infinitesimally beside it."""
        return proposed(self, x, p, direction, (self.x_scale, self.p_scale))


def image_of(own: pieces.Image) -> SpaceImage:
    """Convert an image of a map of the line to one of R^1."""
    return SpaceImage(
        np.array([own.value]), np.array([[own.slope, own.d_parameter]]), own.margins,
        own.gradients, own.causes, LinePiece(own.piece), own.reason,
    )  # fmt: skip


def image_on_line(image: SpaceImage) -> pieces.Image:
    """Convert an image in R^1 to one of the line; a chain is represented by its first piece."""
    slope, rate = image.jacobian[0].tolist()
    return pieces.Image(
        float(image.value[0]), slope, rate, image.margins, image.gradients, image.codes,
        first_piece(image), image.reason,
    )  # fmt: skip


def first_piece(image: SpaceImage) -> pieces.Piece:
    """The piece of an image, as one of the line; of a chain the first."""
    piece = first_piece_of(image)
    assert isinstance(piece, LinePiece)
    return piece.own
