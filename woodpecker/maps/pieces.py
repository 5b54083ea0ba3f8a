"""A piecewise-smooth map of the line: smooth pieces, each with the margins that bound it.

A piece is a smooth map P(x, p) that exists beyond the set where the map takes it. Where it does is
decided by margins h_k(x, p): all are positive inside, and one of them vanishes at a border. Nothing
in this folder knows more of a map than this.
"""

from __future__ import annotations

import math
from collections.abc import Hashable
from typing import NamedTuple, Protocol

import numpy as np

from pwmap.diagrams.shown import brief
from woodpecker.base.arrays import Floats, Ints


class Image(NamedTuple):
    """What a piece makes of a point.

    Attributes
    ----------
    value
        P(x, p); nan where the piece has no value.
    slope, d_parameter
        dP/dx and dP/dp.
    margins
        (m,) numbers h_k(x, p), positive where the map takes this piece.
    gradients
        (m, 2), their derivatives in x and p.
    causes
        (m,) ascending codes that tell the margins apart; a piece need not have the same ones at two
        points.
    piece
        The piece, ready to be continued from this point.
    reason
        Why there is no value; empty if there is one.

    Examples
    --------
    >>> from sympy import Piecewise, symbols
    >>> from woodpecker import from_sympy
    >>> x, p = symbols("x p")
    >>> formula = Piecewise((x/2 + p, x < 0), (x/3 + p - 1, True))
    >>> lines = from_sympy(formula, x, p, words=["L", "R"])
    >>> image = lines.at(-1.0, 0.25)
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
        """The value with its derivatives, and how far the piece reaches."""
        if self.reason:
            return f"Image({self.reason!r})"
        least = f", least margin {self.margins.min():.6g}" if self.margins.size else ""
        return (
            f"Image({self.value:.10g}, slope={self.slope:.6g}, "
            f"d_parameter={self.d_parameter:.6g}{least}, {brief(self.piece.word)!r})"
        )

    def margin(self, code: int) -> float:
        """The margin of a code; nan if there is none here.

        Parameters
        ----------
        code
            The code of the margin, one of ``causes``.

        Returns
        -------
        float
            Positive where the map takes the piece.
        """
        k = self._place(code)
        return math.nan if k < 0 else float(self.margins[k])

    def gradient(self, code: int) -> Floats:
        """Derivatives (2,) of a margin; nan if there is none here.

        Parameters
        ----------
        code
            The code of the margin, one of ``causes``.

        Returns
        -------
        array of shape (2,)
            In x and in p.
        """
        k = self._place(code)
        return np.full(2, math.nan) if k < 0 else self.gradients[k]

    def onward(self, code: int) -> int:
        """To which side of a point the border lies where a margin vanishes: -1 or 1.

        Parameters
        ----------
        code
            The code of the margin, one of ``causes``.

        Returns
        -------
        int
            1 if the border lies at larger x.
        """
        return -1 if self.gradient(code)[0] > 0.0 else 1

    def _place(self, code: int) -> int:
        k = int(np.searchsorted(self.causes, code))
        return k if k < len(self.causes) and self.causes[k] == code else -1


class Piece(Protocol):
    """A smooth map with margins. It may remember where it was met last, to start from there.

    Examples
    --------
    >>> from sympy import Piecewise, symbols
    >>> from woodpecker import from_sympy
    >>> from woodpecker.maps import Piece
    >>> x, p = symbols("x p")
    >>> formula = Piecewise((x/2 + p, x < 0), (x/3 + p - 1, True))
    >>> lines = from_sympy(formula, x, p, words=["L", "R"])
    >>> def described(piece: Piece) -> str:  # whatever has these methods will do
    ...     return f"{piece.word}: {piece.at(2.0, 0.5).value:g} at 2; {piece.cause(0)}"
    >>> described(lines.pieces[0])  # also where the map takes another piece
    'L: 1.5 at 2; x = 0'
    """

    @property
    def key(self) -> Hashable:
        """The same for two pieces just if they are one."""

    @property
    def word(self) -> str:
        """Its name for people, such as a sequence of events."""

    def at(self, x: float, p: float) -> Image:
        """Its image of a point, also where the map takes another piece.

        Parameters
        ----------
        x, p
            The point and the parameter.

        Returns
        -------
        Image
            Value, derivatives and margins; without a value it carries the reason.
        """

    def cause(self, code: int) -> str:
        """A sentence on what happens where a margin vanishes.

        Parameters
        ----------
        code
            The code of the margin, one of ``causes``.

        Returns
        -------
        str
            The sentence.
        """


class PiecewiseMap(Protocol):
    """A map of the line, made of pieces.

    At each sample of a branch it is asked whether it takes the pieces that were followed. One with
    an attribute ``margins_decide`` that is true is not: it takes a piece just where all margins are
    positive.

    Examples
    --------
    >>> from sympy import Piecewise, symbols
    >>> from woodpecker import PiecewiseMap, from_sympy
    >>> x, p = symbols("x p")
    >>> formula = Piecewise((x/2 + p, x < 0), (x/3 + p - 1, True))
    >>> lines = from_sympy(formula, x, p, words=["L", "R"])
    >>> def value(map_: PiecewiseMap, x: float, p: float) -> float:
    ...     # whatever has a method at(x, p) with images will do
    ...     return map_.at(x, p).value
    >>> value(lines, -1.0, 0.25)
    -0.25
    """

    def at(self, x: float, p: float) -> Image:
        """The image of a point under the piece that the map takes there.

        Parameters
        ----------
        x, p
            The point and the parameter.

        Returns
        -------
        Image
            Value, derivatives and margins; without a value it carries the reason.
        """


def map_of_pieces(map_: PiecewiseMap) -> PiecewiseMap:
    """A map that a user has given.

    Raises
    ------
    TypeError
        If it has no pieces, or is no map of the line.
    """
    if hasattr(map_, "d"):
        raise TypeError(f"a map of the line is needed, such as LineOfSystem(map_), got {map_!r}")
    if not callable(getattr(map_, "at", None)):
        raise TypeError(
            "a map must be one of pieces, such as ToyPieces(toy) or FormulaMap([...]), "
            f"got {map_!r}"
        )
    return map_
