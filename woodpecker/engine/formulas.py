"""Piecewise-smooth maps of R^d given by formulas, with exact derivatives."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
import sympy

from woodpecker.base.arrays import Floats
from woodpecker.base.counting import Counter
from woodpecker.base.shown import shown
from woodpecker.base.slopes import derivative
from woodpecker.engine.maps import SpaceImage, proposed

NOT_REAL = (ValueError, ZeroDivisionError, OverflowError)  # raised by math where no value is real
NOWHERE = "no piece of the map holds this point"


@dataclass(frozen=True, slots=True, eq=False)
class ExpressionPiece:
    """A smooth piece given by sympy expressions, compiled once with all derivatives."""

    word: str  # its name
    x: tuple[sympy.Symbol, ...]  # d variables
    p: tuple[sympy.Symbol, ...]  # k parameters
    values: tuple[sympy.Expr, ...]  # d components of the image
    # expressions that are positive inside, keyed by a sentence on what happens where they vanish
    margins: Mapping[str, sympy.Expr] = field(default_factory=dict)
    _function: Callable[..., Any] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        symbols = (*self.x, *self.p)
        expressions = (*self.values, *self.margins.values())
        for each in expressions:
            unknown = sorted(map(str, each.free_symbols - set(symbols)))
            if unknown:
                raise ValueError(f"{self.word}: {unknown[0]} is no variable and no parameter")
        object.__setattr__(self, "margins", dict(self.margins))
        object.__setattr__(self, "_function", _compiled(symbols, expressions))

    def __reduce__(self) -> tuple[Any, ...]:
        return ExpressionPiece, (self.word, self.x, self.p, self.values, self.margins)

    @property
    def key(self) -> str:
        """Its name."""
        return self.word

    def at(self, x: Floats, p: Floats) -> SpaceImage:
        """The image of a point, also outside the piece."""
        d, n = len(self.x), len(self.x) + len(self.p)
        m = len(self.margins)
        try:
            numbers = np.array(self._function(*x.tolist(), *p.tolist()), dtype=float)
        except (*NOT_REAL, TypeError):  # TypeError: the value is complex
            numbers = np.full((d + m) * (n + 1), math.nan)
        rows = numbers.reshape(d + m, n + 1)
        reason = "" if np.isfinite(rows[:d]).all() else f"{self.word} has no value at x = {x}"
        return SpaceImage(
            rows[:d, 0], rows[:d, 1:], rows[d:, 0], rows[d:, 1:], np.arange(m), self, reason
        )

    def cause(self, code: int) -> str:
        """The sentence that is the key of the margin."""
        return list(self.margins)[code]


@lru_cache(maxsize=256)
def _compiled(
    symbols: tuple[sympy.Symbol, ...], expressions: tuple[sympy.Expr, ...]
) -> Callable[..., Any]:
    """A function of all symbols that returns each expression, followed by its derivatives."""
    rows = [[each, *(derivative(each, symbol) for symbol in symbols)] for each in expressions]
    for each, *slopes in rows:
        if any(slope.has(sympy.Derivative, sympy.Subs) for slope in slopes):
            raise ValueError(f"a piece must be smooth, sympy has no formula for a slope of {each}")
    flat = [number for row in rows for number in row]
    function: Callable[..., Any] = sympy.lambdify(symbols, flat, modules="math", cse=True)
    return function


@dataclass(frozen=True, slots=True, eq=False)
class ExpressionMap:
    """A map of R^d with given pieces; where several hold a point, the first one is taken."""

    pieces: tuple[ExpressionPiece, ...]  # at least one, with the same variables and parameters
    _counter: Counter = field(init=False, repr=False, default_factory=Counter)

    def __post_init__(self) -> None:
        if not self.pieces:
            raise ValueError("a map needs at least one piece, got none")

    @property
    def evaluations(self) -> int:
        """How often this thread has evaluated the map; those of its pieces are not counted."""
        return self._counter.evaluations

    def at(self, x: Floats, p: Floats) -> SpaceImage:
        """The image of a point under the first piece that holds it."""
        self._counter.evaluations += 1
        for piece in self.pieces:
            image = piece.at(x, p)
            if not (image.margins < 0.0).any() and not np.isnan(image.margins).any():
                return image
        return self._nowhere(x, p)

    def beside(self, x: Floats, p: Floats, direction: Floats) -> SpaceImage:
        """The image under the piece that holds all points infinitesimally beside a point."""
        images = [piece.at(x, p) for piece in self.pieces]
        # At a root singularity slopes are rounding errors, and no germ follows from them.
        if not all(image.has_small_slopes for image in images):
            return proposed(self, x, p, direction, (1.0,) * len(direction))
        holding = (image for image in images if image.begins_along(x, p, direction))
        return next(holding, None) or self._nowhere(x, p)

    def _nowhere(self, x: Floats, p: Floats) -> SpaceImage:
        d, k = len(x), len(p)
        none, gradients = np.empty(0), np.empty((0, d + k))
        return SpaceImage(
            np.full(d, math.nan), np.full((d, d + k), math.nan), none, gradients,
            np.arange(0), self.pieces[0], NOWHERE,
        )  # fmt: skip


def expression_map(
    x: Sequence[sympy.Symbol],
    p: Sequence[sympy.Symbol],
    pieces: Mapping[str, Sequence[object]],
    margins: Mapping[str, Mapping[str, object]] | None = None,
) -> ExpressionMap:
    """A piecewise-smooth map of R^d from expressions.

    Parameters
    ----------
    x, p
        The d variables and the k parameters.
    pieces
        The d components of the image, for the name of each piece.
    margins
        For the name of each piece, the expressions that are positive inside it, each with a
        sentence as its key that says what happens where the expression vanishes.

    Raises
    ------
    TypeError
        If a variable or a parameter is not a symbol.
    ValueError
        If a symbol occurs twice, a piece does not have d components or has no formula for a slope,
        an expression has other symbols, or margins are given for a piece that does not exist.

    Examples
    --------
    >>> from sympy import symbols
    >>> from woodpecker.engine.formulas import expression_map
    >>> x, y, mu = symbols("x y mu")
    >>> kinked = expression_map(
    ...     (x, y), (mu,),
    ...     {"L": (x/2 + y + mu, -x/3), "R": (-x + y + mu, x/4)},
    ...     {"L": {"x = 0": -x}, "R": {"x = 0": x}},
    ... )
    >>> kinked.at(np.array([-1.0, 0.0]), np.array([0.5])).value.tolist()
    [0.0, 0.3333333333333333]
    >>> kinked.beside(np.zeros(2), np.zeros(1), np.array([1.0, 0.0, 0.0])).piece.word
    'R'
    """
    margins = margins or {}
    for each in (*x, *p):
        if not isinstance(each, sympy.Symbol):
            raise TypeError(f"variables and parameters must be symbols, got {shown(each)}")
        if (*x, *p).count(each) > 1:
            raise ValueError(f"{each} is used twice among variables and parameters")
    for word in margins:
        if word not in pieces:
            raise ValueError(f"margins are given of {word!r}, the pieces are {list(pieces)}")
    made = []
    for word, values in pieces.items():
        if len(values) != len(x):
            raise ValueError(f"{word} must have {len(x)} components, got {len(values)}")
        made.append(
            ExpressionPiece(
                word, tuple(x), tuple(p), tuple(map(sympy.sympify, values)),
                {cause: sympy.sympify(h) for cause, h in margins.get(word, {}).items()},
            )
        )  # fmt: skip
    return ExpressionMap(tuple(made))
