"""Piecewise-smooth maps of the line: smooth pieces, each with the margins that bound it.

A piece is a smooth map P(x, p), defined also beyond the set where the map takes it. Its margins
h_k(x, p) are positive inside this set, and at a border one of them vanishes.
"""

from __future__ import annotations

import math
from collections.abc import Hashable
from typing import NamedTuple, Protocol

import numpy as np

from pwmap.diagrams.shown import brief
from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.shown import shown


class Image(NamedTuple):
    """The image of a point under a piece, with derivatives and margins.

    Attributes
    ----------
    value, slope, d_parameter
        P(x, p), nan where the piece has no value; dP/dx and dP/dp.
    margins, gradients
        (m,) h_k(x, p), positive where the map takes this piece; (m, 2) derivatives in x and p.
    causes
        (m,) ascending codes of the margins; a piece may have others at other points.
    piece
        The piece, ready to be continued from this point.
    reason
        Why there is no value; empty if there is one.

    Examples
    --------
    >>> from woodpecker.examples import two_lines
    >>> image = two_lines().at(-1.0, 0.25)
    >>> image.value, image.slope, image.d_parameter, image.piece.word
    (-0.25, 0.5, 1.0, 'L')
    """

    value: float
    slope: float
    d_parameter: float
    margins: Floats
    gradients: Floats
    causes: Ints
    piece: Piece
    reason: str = ""

    def __repr__(self) -> str:
        if self.reason:
            return f"Image({self.reason!r})"
        least = f", least margin {self.margins.min():.6g}" if self.margins.size else ""
        return (
            f"Image({self.value:.10g}, slope={self.slope:.6g}, "
            f"d_parameter={self.d_parameter:.6g}{least}, {brief(self.piece.word)!r})"
        )

    def margin(self, code: int) -> float:
        """The margin of a code, positive where the map takes the piece; nan if there is none."""
        k = self._place(code)
        return math.nan if k < 0 else float(self.margins[k])

    def gradient(self, code: int) -> Floats:
        """Derivatives (2,) of the margin of a code in x and p; nan if there is none here."""
        k = self._place(code)
        return np.full(2, math.nan) if k < 0 else self.gradients[k]

    def onward(self, code: int) -> int:
        """The side on which a margin falls, where its border lies: 1 if at larger x, else -1."""
        return -1 if self.gradient(code)[0] > 0.0 else 1

    def _place(self, code: int) -> int:
        k = int(self.causes.searchsorted(code))
        return k if k < len(self.causes) and self.causes[k] == code else -1


def no_image(piece: Piece, reason: str) -> Image:
    """An image without value and margins, for a reason."""
    nothing, codes = np.empty(0), np.empty(0, dtype=np.int64)
    return Image(math.nan, math.nan, math.nan, nothing, nothing.reshape(0, 2), codes, piece, reason)


class Piece(Protocol):
    """A smooth map with margins, such as :class:`woodpecker.FormulaPiece`.

    The piece of an image may remember its point, to be continued from there.
    """

    @property
    def key(self) -> Hashable:
        """The identity of the piece: keys are equal if and only if the pieces are the same."""

    @property
    def word(self) -> str:
        """The name of the piece for readers, such as a sequence of events."""

    def at(self, x: float, p: float) -> Image:
        """The image of a point, also outside; without a value it carries the reason."""

    def cause(self, code: int) -> str:
        """A sentence on what happens where the margin of a code vanishes."""


class PiecewiseMap(Protocol):
    """A map of the line, made of pieces, such as :class:`woodpecker.FormulaMap`.

    Along a branch it is asked at each sample which pieces it takes, unless its attribute
    ``margins_decide`` is true: then it takes a piece exactly where all margins are positive.
    """

    def at(self, x: float, p: float) -> Image:
        """The image of a point under the piece that the map takes, or the reason why none."""


def map_of_pieces(map_: PiecewiseMap) -> PiecewiseMap:
    """The map itself; TypeError unless it is a map of the line that has pieces."""
    if hasattr(map_, "d"):
        raise TypeError(f"a map of the line is needed, such as LineOfSystem(map_), got {map_!r}")
    if hasattr(map_, "beside"):
        raise TypeError(
            "a map of the line is needed; woodpecker.search.connected.connected follows one of "
            f"several dimensions, got {shown(map_)}"
        )
    if not callable(getattr(map_, "at", None)):
        raise TypeError(
            "a map must be one of pieces, such as ToyPieces(toy) or FormulaMap([...]), "
            f"got {map_!r}"
        )
    return map_
