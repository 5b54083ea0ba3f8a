"""Piecewise-smooth maps that are given by formulas: by hand, from sympy, or from pwmap."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.engine.pieces import Image

Formula = Callable[[float, float], float]

DIFFERENCE = 2.0**-17  # relative step of a central difference: near the cube root of the rounding
NOWHERE = "no piece of the map holds this point"


@dataclass(frozen=True, slots=True)
class Smooth:
    """A smooth function of (x, p) with its derivatives; central differences if none are given.

    Parameters
    ----------
    value
        The function.
    dx, dp
        Its derivatives.
    """

    value: Formula
    dx: Formula | None = None
    dp: Formula | None = None

    def at(self, x: float, p: float) -> tuple[float, float, float]:
        """Value and derivatives in x and p; nan where the function has no real value."""
        value = _real(self.value, x, p)
        if self.dx is None:
            h = DIFFERENCE * max(1.0, abs(x))
            dx = (_real(self.value, x + h, p) - _real(self.value, x - h, p)) / (2.0 * h)
        else:
            dx = _real(self.dx, x, p)
        if self.dp is None:
            h = DIFFERENCE * max(1.0, abs(p))
            dp = (_real(self.value, x, p + h) - _real(self.value, x, p - h)) / (2.0 * h)
        else:
            dp = _real(self.dp, x, p)
        return value, dx, dp


def _real(formula: Formula, x: float, p: float) -> float:
    try:
        return float(formula(x, p))
    except (ValueError, ZeroDivisionError, OverflowError):  # math's words for no real value
        return math.nan


@dataclass(frozen=True, slots=True)
class FormulaPiece:
    """A smooth piece of a map.

    Parameters
    ----------
    word
        Its name; pieces of one name are one piece.
    map
        Its values.
    margins
        Functions that are positive inside, by the sentence that says what happens where they
        vanish.
    """

    word: str
    map: Smooth
    margins: Mapping[str, Smooth] = field(default_factory=dict)

    @property
    def key(self) -> str:
        """Its name."""
        return self.word

    def at(self, x: float, p: float) -> Image:
        """The image of a point, also outside."""
        value, slope, d_parameter = self.map.at(x, p)
        rows = np.array([margin.at(x, p) for margin in self.margins.values()]).reshape(-1, 3)
        reason = "" if math.isfinite(value) else f"{self.word} has no value there"
        return Image(
            value, slope, d_parameter, rows[:, 0], rows[:, 1:], np.arange(len(rows)), self, reason
        )

    def holds(self, x: float, p: float) -> bool:
        """Whether no margin is negative."""
        return all(_real(margin.value, x, p) >= 0.0 for margin in self.margins.values())

    def cause(self, code: int) -> str:
        """What happens where a margin vanishes."""
        return list(self.margins)[code]


@dataclass(frozen=True, slots=True)
class FormulaMap:
    """A piecewise-smooth map of given pieces; where several hold a point, the first counts.

    Parameters
    ----------
    pieces
        At least one.

    Raises
    ------
    ValueError
        If there is no piece, or two of one name.
    """

    pieces: Sequence[FormulaPiece]

    def __post_init__(self) -> None:
        words = [piece.word for piece in self.pieces]
        if not words:
            raise ValueError("a map needs at least one piece, got none")
        twice = next((word for word in words if words.count(word) > 1), None)
        if twice is not None:
            raise ValueError(f"pieces need names of their own, got {twice!r} twice")
        object.__setattr__(self, "pieces", tuple(self.pieces))

    def at(self, x: float, p: float) -> Image:
        """The image of a point under the piece that holds it."""
        for piece in self.pieces:
            if piece.holds(x, p):
                return piece.at(x, p)
        nothing: Floats = np.empty(0)
        return Image(
            math.nan, math.nan, math.nan, nothing, nothing.reshape(0, 2),
            nothing.astype(np.int64), self.pieces[0], NOWHERE,
        )  # fmt: skip
