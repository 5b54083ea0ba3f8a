"""Families of maps: a piecewise-smooth map with two parameters, as maps over each of them.

All that exists for maps with one parameter is used unchanged: a family gives the map over one
parameter with the other one held, and tells which pieces of two such maps correspond.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol, runtime_checkable

import numpy as np
import sympy

from pwmap import PiecewiseLinearMap
from woodpecker.base.checks import number
from woodpecker.base.shown import shown
from woodpecker.maps.formulas import FormulaMap
from woodpecker.maps.pieces import Piece, PiecewiseMap
from woodpecker.maps.symbolic import (
    SymbolicPiece,
    known_symbols,
    pieces_from_pwmap,
    pieces_from_sympy,
)

Pair = tuple[float, float]
"""The values of two parameters."""
Spans = tuple[Pair, Pair]
"""An interval of each of two parameters."""


@runtime_checkable
class Family(Protocol):
    """A piecewise-smooth map of the line with two parameters.

    Examples
    --------
    >>> from sympy import Piecewise, symbols
    >>> from woodpecker.plane import Family, family_from_sympy
    >>> x, a, r = symbols("x a r")
    >>> p1 = Piecewise((r - 2, x <= 0), (r - a*x, True))
    >>> family = family_from_sympy(p1, x, (r, a), words=["L", "R"])
    >>> family.names
    ('r', 'a')
    >>> family.over(0, (0.0, 1.25)).at(0.4, 1.0).value  # the map over r, with a = 1.25
    0.5
    """

    @property
    def names(self) -> tuple[str, str]:
        """The names of both parameters."""

    def over(self, axis: int, values: Pair) -> PiecewiseMap:
        """The map over the parameter of an axis, 0 or 1, with the other one held at its value.

        If the family has no map with these values, the result has no images.

        Parameters
        ----------
        axis
            Number of the parameter that varies, 0 or 1.
        values
            Values of both; that of the axis does not matter.

        Returns
        -------
        PiecewiseMap
            A map of one parameter.

        Raises
        ------
        ValueError
            If the axis is neither, or ``values`` are not two, of which the other one is a number.
        """

    def carried(self, piece: Piece, map_: PiecewiseMap) -> Piece:
        """The piece of one map of the family that corresponds to a piece of another.

        Parameters
        ----------
        piece
            A piece of the other map.
        map_
            The map whose piece is wanted.

        Returns
        -------
        Piece
            A piece of ``map_``.
        """


@dataclass(frozen=True, slots=True, eq=False)
class SymbolicFamily(Family):
    """A family whose pieces are formulas; made by :func:`family_from_sympy` or ``_from_pwmap``.

    Attributes
    ----------
    pieces
        The pieces over the first parameter.
    symbols
        The variable and both parameters.

    Examples
    --------
    >>> from sympy import Piecewise, symbols
    >>> from woodpecker.plane import family_from_sympy
    >>> x, p, q = symbols("x p q")
    >>> formula = Piecewise((x/2 + p, x < 0), (x/3 + p - q, True))
    >>> family = family_from_sympy(formula, x, (p, q))
    >>> type(family).__name__, family.names
    ('SymbolicFamily', ('p', 'q'))
    >>> family.over(0, (0.0, 1.0)).at(2.0, 0.5).value  # over p, with q = 1
    0.16666666666666663
    """

    pieces: tuple[SymbolicPiece, ...]
    symbols: tuple[sympy.Symbol, sympy.Symbol, sympy.Symbol]

    @property
    def names(self) -> tuple[str, str]:
        """The names of both parameters."""
        return str(self.symbols[1]), str(self.symbols[2])

    def over(self, axis: int, values: Pair) -> FormulaMap:
        value = held_value(self.names, axis, values)
        x, *parameters = self.symbols
        first, held = (x, parameters[axis]), ((parameters[1 - axis], value),)
        return FormulaMap([replace(piece, symbols=first, held=held) for piece in self.pieces])

    def carried(self, piece: Piece, map_: PiecewiseMap) -> Piece:
        assert isinstance(map_, FormulaMap)
        return map_.piece(piece.word)


def family_from_sympy(
    piecewise: sympy.Expr,
    x: sympy.Symbol,
    parameters: tuple[sympy.Symbol, sympy.Symbol],
    values: Mapping[sympy.Symbol, Any] | None = None,
    words: Sequence[str] | None = None,
) -> SymbolicFamily:
    """Make a family from a ``sympy.Piecewise``, or from one smooth expression.

    Parameters
    ----------
    piecewise, x, values, words
        As :func:`woodpecker.from_sympy` takes them.
    parameters
        The two symbols that vary.

    Returns
    -------
    SymbolicFamily
        The family, with the parameters in the given order.

    Raises
    ------
    ValueError, TypeError
        As :func:`woodpecker.from_sympy` does; ValueError unless there are two parameters.

    Examples
    --------
    >>> from sympy import Piecewise, symbols
    >>> from woodpecker.plane import family_from_sympy
    >>> x, a, r = symbols("x a r")
    >>> p1 = Piecewise((r - 2, x <= 0), (r - a*x, True))
    >>> family = family_from_sympy(p1, x, (r, a), words=["L", "R"])
    >>> family.names, family.over(1, (1.0, 1.25)).at(0.4, 1.25).value  # over a, with r = 1
    (('r', 'a'), 0.5)
    """
    p, q = checked_pair(parameters)
    symbols = known_symbols(x=x, p=p, q=q)
    pieces = pieces_from_sympy(piecewise, symbols, (x, p), values or {}, words)
    return SymbolicFamily(tuple(pieces), (x, p, q))


def family_from_pwmap(
    map_: PiecewiseLinearMap, parameters: tuple[sympy.Symbol | str, sympy.Symbol | str]
) -> SymbolicFamily:
    """Make a family from an exact piecewise-linear map with two symbolic parameters.

    The family is valid where the assumptions of the map hold, as these fix the order of the breaks;
    see :func:`woodpecker.from_pwmap`.

    Parameters
    ----------
    map_
        The map.
    parameters
        Its parameters in the wanted order, symbols or names.

    Returns
    -------
    SymbolicFamily
        The family, with the parameters in the given order.

    Raises
    ------
    ValueError
        If these are not the parameters of the map.
    TypeError
        If it is not a map of pwmap.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap
    >>> from woodpecker.plane import family_from_pwmap
    >>> p1 = PiecewiseLinearMap.from_sympy(
    ...     "Piecewise((r - 2, x <= 0), (r - a*x, True))", given=["a > 1"]
    ... )
    >>> family = family_from_pwmap(p1, ("r", "a"))
    >>> family.names, family.over(0, (0.0, 1.25)).at(0.4, 1.0).value
    (('r', 'a'), 0.5)
    """
    wanted = tuple(str(each) for each in checked_pair(parameters))
    pieces = pieces_from_pwmap(map_, wanted)
    named = {str(symbol): symbol for symbol in map_.parameters}
    return SymbolicFamily(tuple(pieces), (map_.x, named[wanted[0]], named[wanted[1]]))


def held_value(names: tuple[str, str], axis: int, values: Pair) -> float:
    """The value of the parameter that an axis leaves, of two values of parameters with names."""
    check_axis(axis)
    try:
        first, second = values
    except (TypeError, ValueError):
        said = f"values must be two numbers, of {names[0]} and of {names[1]}"
        raise ValueError(f"{said}, got {shown(values)}") from None
    return number(names[1 - axis], (second, first)[axis])


def check_axis(axis: Any) -> None:
    """ValueError unless an axis is that of the first parameter, 0, or of the second one, 1."""
    if isinstance(axis, bool | float) or axis not in (0, 1):
        raise ValueError(f"axis must be 0 or 1, got {shown(axis)}")


def checked_pair(parameters: Any) -> tuple[Any, Any]:
    """The two parameters given; ValueError unless there are two."""
    given = tuple(parameters) if np.ndim(parameters) == 1 else ()
    if len(given) != 2:
        raise ValueError(f"expected two parameters, got {shown(parameters)}")
    return given
