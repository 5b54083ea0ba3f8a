"""Piecewise-smooth maps from sympy and pwmap: exact derivatives, compiled to functions once."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from string import ascii_uppercase
from typing import Any, NamedTuple

import numpy as np
import sympy

from pwmap import LinearPiece, PiecewiseLinearMap
from pwmap.algebra.arithmetic import rational
from woodpecker.base.arrays import Bools, Floats, Ints
from woodpecker.base.shown import shown
from woodpecker.base.slopes import derivative
from woodpecker.maps.formulas import NOT_REAL, FormulaMap, codes, no_value, real
from woodpecker.maps.pieces import Image
from woodpecker.maps.relations import Bound, Region, cases_of, regions_of, regions_of_pieces
from woodpecker.maps.sweeps import Sweep

Compiled = Callable[..., Any]

SMOOTH = (
    sympy.exp, sympy.log, sympy.sin, sympy.cos, sympy.tan, sympy.asin, sympy.acos, sympy.atan,
    sympy.sinh, sympy.cosh, sympy.tanh, sympy.asinh, sympy.acosh, sympy.atanh,
)  # fmt: skip
ARITHMETIC = (sympy.Add, sympy.Mul, sympy.Pow)


Symbols = tuple[sympy.Symbol, sympy.Symbol]
"""The variable and the parameter of a map."""


@dataclass(frozen=True, slots=True, eq=False)
class SymbolicPiece:
    """A smooth piece of a map given by expressions of sympy, all compiled into one function."""

    word: str  # its name
    symbols: Symbols  # the variable and the parameter
    value: sympy.Expr  # its formula
    bounds: tuple[Bound, ...] = ()  # the relations that bound it, whose margins are its margins
    held: tuple[tuple[sympy.Symbol, float], ...] = ()  # other symbols, with their constant values
    _functions: _Functions = field(init=False, repr=False)
    _values: tuple[float, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        others = tuple(symbol for symbol, _ in self.held)
        functions = _functions(self.symbols, others, self.value, self.bounds)
        object.__setattr__(self, "_functions", functions)
        object.__setattr__(self, "_values", tuple(value for _, value in self.held))

    def __reduce__(self) -> tuple[Any, ...]:
        return SymbolicPiece, (self.word, self.symbols, self.value, self.bounds, self.held)

    @property
    def key(self) -> str:
        """Its name."""
        return self.word

    def at(self, x: float, p: float) -> Image:
        """The image of a point, also outside."""
        x, p = float(x), float(p)  # numpy's numbers would warn where Python's raise
        try:
            value, slope, d_parameter, *rest = self._functions.everything(x, p, *self._values)
            value, slope, d_parameter = float(value), float(slope), float(d_parameter)
            bounds = np.array(rest, dtype=float)
        except (*NOT_REAL, TypeError):  # one of the expressions has no real value
            value, slope, d_parameter, *rest = self._one_by_one(x, p)
            bounds = np.array(rest)
        causes = self._functions.causes
        n = len(causes)
        return Image(
            value, slope, d_parameter, bounds[:n], bounds[n:].reshape(n, 2), causes, self,
            "" if math.isfinite(value) else no_value(self.word, x, p),
        )  # fmt: skip

    def _one_by_one(self, x: float, p: float) -> list[float]:
        arguments = self._functions.arguments
        singly = (compiled(arguments, (each,)) for each in self._functions.expressions)
        return [real(lambda x, p, f=f: f(x, p, *self._values)[0], x, p) for f in singly]  # type: ignore[misc]

    def holds(self, x: float, p: float) -> bool:
        """Whether all relations hold at a point; False where a margin has no real value."""
        try:
            return bool(self._functions.inside(float(x), float(p), *self._values))
        except (*NOT_REAL, TypeError):
            return False

    def values(self, x: Floats, p: float) -> Floats:
        """The images of many points, also outside."""
        return self._on_array(self.value, x, p)

    def holding(self, x: Floats, p: float | Floats) -> Bools:
        """A mask of the points that the piece holds, with one common parameter or one each."""
        held = np.ones(x.shape, dtype=bool)
        for bound in self.bounds:
            margin = self._on_array(bound.margin, x, p)
            held &= margin >= 0.0 if bound.closed else margin > 0.0
        return held

    def sweep(self, x: Floats, p: Floats) -> Sweep:
        """Images and slopes at points (n,), each with its parameter, also outside."""
        value, slope, _ = self._functions.expressions[:3]
        return Sweep(*self._on_arrays((value, slope), x, p))

    def _on_array(self, expression: sympy.Expr, x: Floats, p: float | Floats) -> Floats:
        (found,) = self._on_arrays((expression,), x, p)
        return found

    def _on_arrays(
        self, expressions: tuple[sympy.Expr, ...], x: Floats, p: float | Floats
    ) -> list[Floats]:
        function = compiled(self._functions.arguments, expressions, "numpy")
        with np.errstate(all="ignore"):
            found = function(x, np.asarray(p, dtype=float), *self._values)
        return [np.broadcast_to(np.asarray(each, dtype=float), x.shape).copy() for each in found]

    def cause(self, code: int) -> str:
        """A sentence on what happens where a margin vanishes."""
        return self.bounds[code].cause


class _Functions(NamedTuple):
    """The compiled functions of a piece."""

    arguments: tuple[sympy.Symbol, ...]  # of all functions: x, p, and the symbols in ``held``
    # The value and its derivatives; the margins; their derivatives in x and p.
    expressions: tuple[sympy.Expr, ...]
    everything: Compiled  # returns the values of all expressions
    inside: Compiled  # returns whether all relations hold
    causes: Ints  # the codes of the margins


@lru_cache(maxsize=1024)
def _functions(
    symbols: Symbols, others: tuple[sympy.Symbol, ...], value: sympy.Expr, bounds: tuple[Bound, ...]
) -> _Functions:
    margins = [bound.margin for bound in bounds]
    gradients = (derivative(margin, s) for margin in margins for s in symbols)
    slopes = (derivative(value, s) for s in symbols)
    expressions, arguments = (value, *slopes, *margins, *gradients), (*symbols, *others)
    relations = sympy.And(*(bound.relation for bound in bounds), evaluate=False)
    return _Functions(
        arguments, expressions, compiled(arguments, expressions), compiled(arguments, relations),
        codes(len(bounds)),
    )  # fmt: skip


@lru_cache(maxsize=1024)
def compiled(
    arguments: tuple[sympy.Symbol, ...], expressions: tuple[sympy.Expr, ...] | sympy.And,
    module: str = "math",
) -> Compiled:  # fmt: skip
    """A compiled function that returns the values of expressions, or whether relations hold."""
    function: Compiled = sympy.lambdify(list(arguments), expressions, module, cse=True)
    return function


# --- From sympy -----------------------------------------------------------------------------------


def from_sympy(
    piecewise: sympy.Expr,
    x: sympy.Symbol,
    p: sympy.Symbol,
    values: Mapping[sympy.Symbol, Any] | None = None,
    words: Sequence[str] | None = None,
) -> FormulaMap:
    """Make a map from a ``sympy.Piecewise``, or from one smooth expression.

    A condition is a relation (<, <=, >, >=), or several joined by And, Or, Not; each relation
    becomes a margin. The first condition that holds counts: a formula is also bounded by the
    complements of earlier conditions, and becomes several pieces, C1 and C2, if it lies on several
    sides of them. Abs, Min, Max and an inner Piecewise are written as their cases; other functions
    must be smooth. A root has no value beyond its end.

    Parameters
    ----------
    piecewise
        The map.
    x, p
        The variable and the parameter.
    values
        Numbers for all other symbols: a float for the binary number that it holds, or exact text.
    words
        Names, one for each formula; by default A, B, C, ...

    Returns
    -------
    FormulaMap
        Pieces with values, derivatives and margins.

    Raises
    ------
    ValueError, TypeError
        For text, unknown symbols, functions that are not smooth such as sign or floor, conditions
        with == or !=, borders that no piece has, and more than 64 cases.

    Examples
    --------
    >>> from sympy import Piecewise, symbols
    >>> from woodpecker import from_sympy
    >>> x, p = symbols("x p")
    >>> formula = Piecewise((x/2 + p, x < 0), (x/3 + p - 1, True))
    >>> image = from_sympy(formula, x, p, words=["L", "R"]).at(-1.0, 0.25)
    >>> image.value, image.slope, image.piece.word
    (-0.25, 0.5, 'L')
    """
    symbols = known_symbols(x=x, p=p)
    pieces = pieces_from_sympy(piecewise, symbols, (x, p), values or {}, words)
    return FormulaMap(pieces, (str(x), str(p)))


def pieces_from_sympy(
    piecewise: sympy.Expr, symbols: tuple[sympy.Symbol, ...], first: Symbols,
    values: Mapping[sympy.Symbol, Any], words: Sequence[str] | None,
) -> list[SymbolicPiece]:  # fmt: skip
    """The pieces of a formula in the two symbols ``first``; other ``symbols`` are held, at 0."""
    if not isinstance(piecewise, sympy.Expr):
        raise TypeError(f"a map must be an expression of sympy, got {piecewise!r}")
    given, held = _numbers(values, symbols), tuple((s, 0.0) for s in symbols if s not in first)
    parts = cases_of(_of_reals(_exact(piecewise)))
    formulas = [formula.xreplace(given) for formula, _ in parts]
    holding = list[list[Region]]()
    for _, condition in parts:
        holding.append(regions_of(condition.xreplace(given)))
        for region in holding[-1]:
            for bound in region:
                _check(bound.margin, symbols)
    names, regions_of_each = _names(words, len(parts)), regions_of_pieces(holding)
    found = []
    for name, formula, regions in zip(names, formulas, regions_of_each, strict=True):
        for k, bounds in enumerate(regions, 1):
            _check(formula, symbols)
            word = name if len(regions) == 1 else f"{name}{k}"
            found.append(SymbolicPiece(word, first, formula, bounds, held))
    return found


def known_symbols(**named: object) -> tuple[sympy.Symbol, ...]:
    """The variable and the parameters; TypeError or ValueError unless they are distinct symbols."""
    for name, symbol in named.items():
        if not isinstance(symbol, sympy.Symbol):
            raise TypeError(f"{name} must be a symbol of sympy, got {symbol!r}")
    symbols = tuple(named.values())
    twice = next((symbol for symbol in symbols if symbols.count(symbol) > 1), None)
    if twice is not None:
        raise ValueError(f"the variable and the parameters must differ, got {twice} twice")
    return symbols


def _numbers(
    values: Mapping[Any, Any], symbols: tuple[sympy.Symbol, ...]
) -> dict[sympy.Symbol, sympy.Expr]:
    """Exact values of other symbols; ValueError or TypeError unless they are finite and real."""
    if not isinstance(values, Mapping):
        raise TypeError(f"values must be a dict of symbols and numbers, got {shown(values)}")
    found = {}
    for symbol, value in values.items():
        if not isinstance(symbol, sympy.Symbol) or symbol in symbols:
            raise ValueError(f"values are for symbols other than {symbols}, got one for {symbol!r}")
        try:
            number = _number(value)
        except (TypeError, ValueError):
            raise TypeError(f"the value of {symbol} must be a number, got {value!r}") from None
        if not (number.is_number and number.is_extended_real and number.is_finite):
            raise ValueError(f"the value of {symbol} must be a finite real number, got {value!r}")
        found[symbol] = number
    return found


def _number(value: Any) -> sympy.Basic:
    """A value of sympy, a number, or text such as ``"5/4"`` or ``"1.25"``, exactly."""
    if isinstance(value, str):
        found = rational(value)
        return sympy.Rational(int(found.numerator), int(found.denominator))
    if value is None or isinstance(value, bool):
        raise TypeError
    return _exact(sympy.sympify(value, strict=True))


def _exact(expression: sympy.Basic) -> sympy.Basic:
    """The same expression with floats as exact rational numbers."""
    return expression.xreplace({f: sympy.Rational(f) for f in expression.atoms(sympy.Float)})


def _of_reals(expression: sympy.Expr) -> sympy.Expr:
    """The same expression, simplified as its symbols stand for real numbers."""
    # The corner of sqrt(x**2) is seen as that of Abs(x).
    real = {symbol: sympy.Dummy(symbol.name, real=True) for symbol in expression.free_symbols}
    return expression.xreplace(real).xreplace({dummy: symbol for symbol, dummy in real.items()})


def _check(expression: sympy.Expr, symbols: tuple[sympy.Symbol, ...]) -> None:
    """ValueError if an expression has unknown symbols, or functions not known to be smooth."""
    unknown = sorted(expression.free_symbols - set(symbols), key=str)
    for symbol in unknown:
        if symbol.name in [known.name for known in symbols]:
            raise ValueError(
                f"{symbol} in {expression} and the {symbol} given are two symbols, of different "
                "assumptions"
            )
    if unknown:
        raise ValueError(f"no value is given for {', '.join(map(str, unknown))} in {expression}")
    for part in sympy.preorder_traversal(expression):
        known = part.is_Symbol or (part.is_number and part.is_finite and not part.args)
        if known and part is not sympy.I:
            continue
        if not isinstance(part, (*ARITHMETIC, *SMOOTH)):
            raise ValueError(
                f"{part} in {expression} is not among the smooth functions known here: write its "
                "cases as pieces of the map"
            )


def _names(words: Sequence[str] | None, n: int) -> tuple[str, ...]:
    if words is None:
        return tuple(
            ascii_uppercase[:n] if n <= len(ascii_uppercase) else (f"A{k + 1}" for k in range(n))
        )
    given = [] if isinstance(words, str) or not isinstance(words, Sequence) else list(words)
    named = all(isinstance(word, str) and word for word in given)
    if len(given) != n or not named or len(set(given)) < n:
        raise ValueError(f"words must be {n} names, one for each piece, got {shown(words)}")
    return tuple(given)


# --- From pwmap -----------------------------------------------------------------------------------


def from_pwmap(map_: PiecewiseLinearMap, parameter: sympy.Symbol | str) -> FormulaMap:
    """Make a map from an exact piecewise-linear one with a single symbolic parameter.

    Pieces keep their names; their margins are the distances from the breaks. Pieces of a single
    point are left out. The map is valid where the assumptions of the exact one hold, as these fix
    the order of the breaks.

    Parameters
    ----------
    map_
        The map; :meth:`pwmap.PiecewiseLinearMap.at` gives other parameters values.
    parameter
        Symbol or name of the parameter.

    Returns
    -------
    FormulaMap
        Pieces with values, derivatives and margins.

    Raises
    ------
    ValueError, TypeError
        If the map has other parameters than this one, or is not a map of pwmap.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap
    >>> from woodpecker import from_pwmap
    >>> exact = PiecewiseLinearMap.from_sympy("Piecewise((p + x/2, x <= 0), (p - 1 + x/3, True))")
    >>> image = from_pwmap(exact, "p").at(-1.0, 0.25)
    >>> image.value, image.slope, image.piece.word
    (-0.25, 0.5, 'L')
    """
    return FormulaMap(pieces_from_pwmap(map_, (str(parameter),)), (str(map_.x), str(parameter)))


def pieces_from_pwmap(map_: PiecewiseLinearMap, parameters: tuple[str, ...]) -> list[SymbolicPiece]:
    """The pieces of a piecewise-linear map in x and its first parameter; others are held, at 0."""
    if not isinstance(map_, PiecewiseLinearMap):
        raise TypeError(f"the map must be a pwmap.PiecewiseLinearMap, got {map_!r}")
    named = {str(symbol): symbol for symbol in map_.parameters}
    if sorted(named) != sorted(parameters):
        wanted, listed = " and ".join(parameters), ", ".join(named) or "none"
        alone = " alone" if len(parameters) == 1 else ""
        raise ValueError(f"the parameters of the map must be {wanted}{alone}, got {listed}")
    first, *others = (named[name] for name in parameters)
    symbols, held = (map_.x, first), tuple((symbol, 0.0) for symbol in others)
    return [
        SymbolicPiece(piece.word, symbols, piece.expression, _ends(piece), held)
        for piece in map_.pieces
        if not piece.cylinder.is_point
    ]


def _ends(piece: LinearPiece) -> tuple[Bound, ...]:
    x, bounds = piece.owner.definition.x, []
    if piece.cylinder.lower is not None:
        bounds.append(Bound(x - piece.lower, piece.lower_closed, f"{x} = {piece.lower}"))
    if piece.cylinder.upper is not None:
        bounds.append(Bound(piece.upper - x, piece.upper_closed, f"{x} = {piece.upper}"))
    return tuple(bounds)
