"""Piecewise-smooth maps written by hand: functions of (x, p), and margins with sentences."""

from __future__ import annotations

import inspect
import math
import numbers
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from pwmap.diagrams.shown import counted, table
from woodpecker.base.arrays import STEP, Bools, Floats, Ints
from woodpecker.base.checks import number, real_array
from woodpecker.maps.pieces import Image, Piece, no_image
from woodpecker.maps.sweeps import Sweep, one_by_one

Formula = Callable[[float, float], float]

NOWHERE = "no piece of the map holds this point"
NOT_REAL = (ValueError, ZeroDivisionError, OverflowError)  # raised by math if no value is real


@dataclass(frozen=True, slots=True)
class Smooth:
    """A smooth function of (x, p) with its derivatives, by default from finite differences.

    Differences have about ten correct digits where the function is smooth on the scale of 1, but
    fewer next to a square root.

    Parameters
    ----------
    value
        The function. Where it has no real value it may raise ValueError, ZeroDivisionError or
        OverflowError, as functions of :mod:`math` do, or return nan or a complex number.
    dx, dp
        Its derivatives.

    Raises
    ------
    TypeError
        If one of them is not a function of two arguments; on evaluation if it returns no number.

    Examples
    --------
    >>> from math import sqrt
    >>> from woodpecker import Smooth
    >>> root = Smooth(lambda x, p: sqrt(x - p), dx=lambda x, p: 0.5 / sqrt(x - p))
    >>> value, dx, dp = root.at(4.0, 0.0)  # dp by differences
    >>> value, dx, round(dp, 9)
    (2.0, 0.25, -0.25)
    """

    value: Formula
    dx: Formula | None = None
    dp: Formula | None = None

    def __post_init__(self) -> None:
        for name in ("value", "dx", "dp"):
            given = getattr(self, name)
            if not (_takes_two(given) or (given is None and name != "value")):
                raise TypeError(f"{name} must be a function of x and p, got {given!r}")

    def at(self, x: float, p: float) -> tuple[float, float, float]:
        """Value and derivatives in x and p, three floats; nan where there is no real value."""
        if self.dx is not None and self.dp is not None:
            try:
                return float(self.value(x, p)), float(self.dx(x, p)), float(self.dp(x, p))
            except (*NOT_REAL, TypeError):
                pass  # the others may have a value all the same
        value = real(self.value, x, p)
        if self.dx is None:
            dx = difference(lambda s: real(self.value, s, p), x, value)
        else:
            dx = real(self.dx, x, p)
        if self.dp is None:
            dp = difference(lambda s: real(self.value, x, s), p, value)
        else:
            dp = real(self.dp, x, p)
        return value, dx, dp


def _takes_two(formula: object) -> bool:
    """Whether an object can be called with x and p, as far as its signature tells."""
    if not callable(formula):
        return False
    try:
        inspect.signature(formula).bind(0.0, 0.0)
    except TypeError:
        return False
    except ValueError:  # some functions written in C have no signature
        return True
    return True


def real(formula: Formula, x: float, p: float) -> float:
    """The value of a formula, nan if it is not real; TypeError if it is not a number."""
    try:
        value = formula(x, p)
    except NOT_REAL:
        return math.nan
    if isinstance(value, float):
        return value
    if isinstance(value, complex):  # such as the square root of a negative number
        return math.nan
    if not isinstance(value, numbers.Real) or isinstance(value, bool):
        raise TypeError(f"a formula must return one real number, got {value!r} at x={x}, p={p}")
    try:
        return float(value)
    except OverflowError:  # a whole number or fraction that no double holds
        return math.nan


def difference(function: Callable[[float], float], at: float, value: float) -> float:
    """A central difference, or at the end of the function's domain a one-sided one of order h^2."""
    h = STEP * max(1.0, abs(at))
    above, below = function(at + h), function(at - h)
    if not (math.isnan(above) or math.isnan(below)):
        return (above - below) / ((at + h) - (at - h))
    h = h if math.isnan(below) else -h
    return (4.0 * function(at + h) - 3.0 * value - function(at + 2.0 * h)) / (2.0 * h)


@dataclass(frozen=True, slots=True, eq=False)
class FormulaPiece:
    """A smooth piece of a map, written by hand.

    Parameters
    ----------
    word
        Its name, which identifies it.
    map
        Its values.
    margins
        Functions that are positive inside, each keyed by the sentence that says what happens where
        it vanishes; empty if the piece holds every point.

    Raises
    ------
    ValueError, TypeError
        If the name is empty or not text, or a function is not :class:`Smooth`.

    Examples
    --------
    >>> from woodpecker import FormulaPiece, Smooth
    >>> left = FormulaPiece("L", Smooth(lambda x, p: p + x/2), {"x = 0": Smooth(lambda x, p: -x)})
    >>> left.at(-1.0, 0.25).value, left.holds(1.0, 0.25)
    (-0.25, False)
    """

    word: str
    map: Smooth
    margins: Mapping[str, Smooth] = field(default_factory=dict)
    _causes: Ints = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if not isinstance(self.word, str):
            raise TypeError(f"the name of a piece must be text, got {self.word!r}")
        if not self.word:
            raise ValueError("the name of a piece must not be empty")
        if not isinstance(self.margins, Mapping):
            raise TypeError(
                f"the margins of {self.word} must be a dict of sentences and Smooth(h), "
                f"got {self.margins!r}"
            )
        named = {f"the map of {self.word}": self.map}
        named |= {f"the margin {cause!r} of {self.word}": h for cause, h in self.margins.items()}
        for name, given in named.items():
            if not isinstance(given, Smooth):
                raise TypeError(f"{name} must be Smooth(f), f a function of x and p, got {given!r}")
        object.__setattr__(self, "margins", dict(self.margins))
        object.__setattr__(self, "_causes", codes(len(self.margins)))

    @property
    def key(self) -> str:
        """Its name."""
        return self.word

    def at(self, x: float, p: float) -> Image:
        """The image of a point, also outside; without a value it carries the reason."""
        x, p = float(x), float(p)  # numpy's numbers would warn where Python's raise
        value, slope, d_parameter = self.map.at(x, p)
        flat = [number for margin in self.margins.values() for number in margin.at(x, p)]
        rows = np.array(flat).reshape(-1, 3)
        return Image(
            value, slope, d_parameter, rows[:, 0], rows[:, 1:], self._causes, self,
            "" if math.isfinite(value) else no_value(self.word, x, p),
        )  # fmt: skip

    def holds(self, x: float, p: float) -> bool:
        """Whether no margin is negative at a point."""
        point = float(x), float(p)
        return all(real(margin.value, *point) >= 0.0 for margin in self.margins.values())

    def values(self, x: Floats, p: float) -> Floats:
        """The images of many points, of any shape, also outside; nan where there is none."""
        flat = [real(self.map.value, each, p) for each in x.ravel().tolist()]
        return np.array(flat, dtype=float).reshape(x.shape)

    def holding(self, x: Floats, p: float) -> Bools:
        """A mask of those of many points, of any shape, that the piece holds."""
        flat = [self.holds(each, p) for each in x.ravel().tolist()]
        return np.array(flat, dtype=bool).reshape(x.shape)

    def cause(self, code: int) -> str:
        """The sentence of the margin with a code, which is its number, from 0 on."""
        return list(self.margins)[code]

    def __repr__(self) -> str:
        return f"FormulaPiece({self.word!r}, borders: {', '.join(self.margins) or 'none'})"


def codes(n: int) -> Ints:
    """The codes 0 .. n - 1 of the margins of a piece, as a read-only array."""
    found = np.arange(n)
    found.setflags(write=False)
    return found


def no_value(word: str, x: float, p: float) -> str:
    """A sentence that a piece has no value at a point."""
    return f"{word} has no value at x = {x}, p = {p}"


@runtime_checkable
class SweptPiece(Protocol):
    """A piece that evaluates many points at once, each with its own parameter."""

    def holding(self, x: Floats, p: Floats) -> Bools:
        """A mask (n,) of the points that the piece holds."""

    def sweep(self, x: Floats, p: Floats) -> Sweep:
        """Images and slopes at points (n,), also outside; nan where there is no value."""


class BoundedPiece(Piece, Protocol):
    """A piece that says which points it holds, such as :class:`woodpecker.FormulaPiece`."""

    def holds(self, x: float, p: float) -> bool:
        """Whether the map takes this piece at a point, unless an earlier piece holds it, too."""

    def values(self, x: Floats, p: float) -> Floats:
        """The images of many points, of any shape, also outside; nan where there is none."""

    def holding(self, x: Floats, p: float) -> Bools:
        """A mask of those of many points, of any shape, that the piece holds."""


@dataclass(frozen=True, slots=True, eq=False)
class FormulaMap:
    """A piecewise-smooth map of given pieces, which takes the first piece that holds a point.

    Borders lie where margins vanish, so a piece also needs a margin where an earlier piece begins
    within it. Slices find no other borders, and a branch ends at a jump that no margin of its
    pieces expresses (EP, open, "the map takes another piece"). The map can be pickled if its
    functions can: those written by hand must be defined at the top level of a module.

    Parameters
    ----------
    pieces
        At least one.
    names
        Names of the coordinate and the parameter; maps of :func:`woodpecker.from_sympy` have those
        of their symbols. Without names the axes of a diagram may be called anything.

    Raises
    ------
    ValueError, TypeError
        If there is no piece, two have the same name, or an argument is of another type.

    Examples
    --------
    >>> from woodpecker import FormulaMap, FormulaPiece, Smooth
    >>> low, high = Smooth(lambda x, p: p + x/2), Smooth(lambda x, p: p - 1 + x/3)
    >>> left = FormulaPiece("L", low, {"x = 0": Smooth(lambda x, p: -x)})
    >>> right = FormulaPiece("R", high, {"x = 0": Smooth(lambda x, p: x)})
    >>> lines = FormulaMap([left, right])
    >>> lines.at(-1.0, 0.25).value, lines.at(3.0, 0.25).piece.word
    (-0.25, 'R')
    """

    pieces: Sequence[BoundedPiece]
    names: tuple[str, str] | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.pieces, Sequence):
            raise TypeError(f"a map needs a list of pieces, got {self.pieces!r}")
        for piece in self.pieces:
            if not callable(getattr(piece, "holds", None)):
                raise TypeError(f"a piece must be a FormulaPiece or alike, got {piece!r}")
        if self.names is not None and not (
            isinstance(self.names, tuple)
            and len(self.names) == 2
            and all(isinstance(each, str) for each in self.names)
        ):
            raise TypeError(
                f"names must be those of the coordinate and the parameter, got {self.names!r}"
            )
        words = [piece.word for piece in self.pieces]
        if not words:
            raise ValueError("a map needs at least one piece, got none")
        twice = next((word for word in words if words.count(word) > 1), None)
        if twice is not None:
            raise ValueError(f"pieces need names of their own, got {twice!r} twice")
        object.__setattr__(self, "pieces", tuple(self.pieces))

    def at(self, x: float, p: float) -> Image:
        """The image of a point under the first piece that holds it, or the reason why none."""
        for piece in self.pieces:
            if piece.holds(x, p):
                return piece.at(x, p)
        return no_image(self.pieces[0], NOWHERE)

    def __repr__(self) -> str:
        return f"FormulaMap({', '.join(repr(piece.word) for piece in self.pieces)})"

    def _repr_html_(self) -> str:
        rows = [
            (piece.word, "; ".join(getattr(piece, "margins", {})) or "none")
            for piece in self.pieces
        ]
        return table(f"Map of {counted(len(rows), 'piece')}", ("piece", "its borders"), rows)

    def piece(self, word: str) -> BoundedPiece:
        """The piece with a name; KeyError if there is none."""
        for piece in self.pieces:
            if piece.word == word:
                return piece
        raise KeyError(f"no piece {word!r} in this map")

    def values(self, x: npt.ArrayLike, p: float) -> Floats:
        """The images of many points, of any shape; nan where there is none.

        Pieces from sympy are evaluated by numpy: the last bit may differ from :meth:`at`, which
        uses :mod:`math`. ValueError if the arguments are not real numbers.
        """
        points, p = real_array("x", x), number("p", p)
        images = np.full(points.shape, math.nan)
        left = np.ones(points.shape, dtype=bool)
        for piece in self.pieces:
            held = left.copy()
            held[left] = piece.holding(points[left], p)
            images[held] = piece.values(points[held], p)
            left &= ~held
        return images

    def sweep(self, x: npt.ArrayLike, p: npt.ArrayLike) -> Sweep:
        """Images and slopes (n,) of many points, with one common parameter or one each.

        They are nan where there is no image. If all pieces come from sympy or pwmap they are
        evaluated by numpy, else point by point. ValueError if arguments are not real numbers.
        """
        points = real_array("x", x).ravel()
        values = np.broadcast_to(real_array("p", p), points.shape)
        if not all(isinstance(piece, SweptPiece) for piece in self.pieces):
            return one_by_one(self.at, points, values)
        found, left = np.full((2, len(points)), math.nan), np.arange(len(points))
        for piece in self.pieces:
            assert isinstance(piece, SweptPiece)
            held = piece.holding(points[left], values[left])
            there = left[held]
            found[:, there] = piece.sweep(points[there], values[there])
            left = left[~held]
        return Sweep(*found)
