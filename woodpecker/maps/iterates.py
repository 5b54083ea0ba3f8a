"""Iterates of a piecewise-smooth map, which are piecewise-smooth maps themselves.

A piece of P_n is a sequence of n pieces of P_1. Its margins are the margins of these, as functions
of the first point.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable
from dataclasses import dataclass

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.base.checks import whole
from woodpecker.maps.pieces import Image, Piece, PiecewiseMap, map_of_pieces

RETURN = 2**32  # added to the codes of margins with each return; those of P_1 are smaller


@dataclass(frozen=True, slots=True)
class Iterate:
    """The iterate P_order of a map; it can be pickled if the map can.

    Where P_1 is steep its iterates have very thin pieces. To find all cycles in a window use
    :func:`woodpecker.slices_at`, which pulls the pieces of P_1 back.

    Parameters
    ----------
    map, order
        P_1, and how often it is applied.

    Raises
    ------
    ValueError, TypeError
        If the order is not a whole number of at least 1, or the map has no pieces.

    Examples
    --------
    >>> from woodpecker.examples import two_lines
    >>> from woodpecker.maps import Iterate
    >>> Iterate(two_lines(), 2).at(-1.0, 0.25).value
    0.125
    """

    map: PiecewiseMap
    order: int

    def __post_init__(self) -> None:
        map_of_pieces(self.map)
        object.__setattr__(self, "order", whole("order", self.order))

    def at(self, x: float, p: float) -> Image:
        """The image of a point, with derivatives by the chain rule; none if a return has none."""
        return _composed([lambda x: self.map.at(x, p)] * self.order, x)


@dataclass(frozen=True, slots=True, eq=False)
class IteratedPiece:
    """A piece of P_n: a sequence of pieces of P_1, shorter where a return has no value."""

    pieces: tuple[Piece, ...]

    @property
    def key(self) -> Hashable:
        """The keys of the pieces."""
        return tuple(piece.key for piece in self.pieces)

    @property
    def word(self) -> str:
        """The words of the pieces, separated by bars."""
        return " | ".join(piece.word for piece in self.pieces)

    def at(self, x: float, p: float) -> Image:
        """The image of a point under these pieces, also outside."""
        return _composed([lambda x, piece=piece: piece.at(x, p) for piece in self.pieces], x)  # type: ignore[misc]

    def cause(self, code: int) -> str:
        """A sentence on what happens where a margin vanishes, and in which return."""
        k, own = divmod(code, RETURN)
        return f"{self.pieces[k].cause(own)}, in return {k + 1}"


def _composed(returns: list[Callable[[float], Image]], x: float) -> Image:
    """The image of a point under maps applied in turn, with margins in terms of the first point."""
    slope, d_parameter = 1.0, 0.0
    images, gradients = list[Image](), list[Floats]()
    for each in returns:
        image = each(x)
        images.append(image)
        by_x = image.gradients[:, 0]
        gradients.append(
            np.column_stack([by_x * slope, by_x * d_parameter + image.gradients[:, 1]])
        )
        if image.reason:
            break
        x, d_parameter = image.value, image.slope * d_parameter + image.d_parameter
        slope *= image.slope
    if reason := images[-1].reason:
        x = slope = d_parameter = math.nan
    return Image(
        x,
        slope,
        d_parameter,
        np.concatenate([image.margins for image in images]),
        np.concatenate(gradients),
        np.concatenate([image.causes + k * RETURN for k, image in enumerate(images)]),
        IteratedPiece(tuple(image.piece for image in images)),
        reason,
    )
