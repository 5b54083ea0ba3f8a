"""Piecewise-linear maps of the line, with or without jumps, exact and symbolic."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from typing import Any

import sympy

from pwmap.algebra.arguments import explained, positive_integer, shown
from pwmap.algebra.exact import fraction_to_sympy
from pwmap.diagrams.frames import DataFrame, dataframe
from pwmap.maps import diagonal
from pwmap.maps.budget import checked_size
from pwmap.maps.decided import Decided, composed, with_values
from pwmap.maps.diagonal import (
    Cycle,
    Discontinuity,
    FixedInterval,
    FixedPoint,
    JumpCrossing,
    cycle_of,
)
from pwmap.maps.pieces import LinearPiece, columns_of, latex_of, lines_of
from pwmap.maps.reading import read, read_formula
from pwmap.maps.words import first_rotation


class PiecewiseLinearMap(Decided):
    """A piecewise-linear map of the line with finitely many pieces.

    Coefficients are quotients of polynomials in parameters over the rationals, with denominators of
    one sign under the assumptions. Each break belongs to one piece; a single point can be a piece.

    Parameters
    ----------
    pieces
        Pairs (formula, condition), sympy expressions or text, such as ``("r - a*x", "x > 0")``.
        Every point must satisfy exactly one condition.
    x
        The variable.
    given
        Assumptions on the parameters: inequalities such as ``a > 1``.
    letters
        One letter for each piece from left to right; by default L R, L M R, or A B C ...

    Raises
    ------
    ValueError, TypeError
        For gaps, overlaps, pieces that are not affine, floats, unknown symbols, or breaks whose
        order the assumptions leave open.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap
    >>> p1 = PiecewiseLinearMap.from_sympy(
    ...     "Piecewise((r - 2, x <= 0), (r - a*x, True))", given=["a > 1", "r > 0", "r < 2"]
    ... )
    >>> [(point.x, point.word, point.multiplier, point.stable) for point in p1.fixed_points()]
    [(r - 2, 'L', 0, True), (r/(a + 1), 'R', -a, False)]
    >>> print(p1.at({"a": "5/4", "r": 1}).iterate(2))
    LL  -1             for x <= 0
    RR  25*x/16 - 1/4  for 0 < x < 4/5
    RL  -1             for 4/5 <= x
    """

    @explained()
    def __init__(
        self,
        pieces: Sequence[tuple[object, object]],
        x: object = "x",
        given: Iterable[object] = (),
        letters: Sequence[str] | None = None,
    ) -> None:
        super().__init__(read(pieces, x, given, letters))

    @classmethod
    @explained()
    def from_sympy(
        cls,
        piecewise: object,
        x: object = "x",
        given: Iterable[object] = (),
        letters: Sequence[str] | None = None,
    ) -> PiecewiseLinearMap:
        """A map from a ``sympy.Piecewise`` of affine formulas, one formula, or the text of either.

        The first condition of ``piecewise`` that holds counts; for ``x``, ``given``, ``letters``
        and errors see the class.
        """
        return cls.of(read_formula(piecewise, x, given, letters))

    # --- What it is -----------------------------------------------------------------------------

    @property
    def x(self) -> sympy.Symbol:
        """The variable."""
        return self.definition.x

    @property
    def parameters(self) -> tuple[sympy.Symbol, ...]:
        """The parameters that have no value yet."""
        return self.definition.parameters

    @property
    def given(self) -> tuple[sympy.Basic, ...]:
        """The assumptions on the parameters."""
        return self.definition.region.relations()

    @property
    def letters(self) -> tuple[str, ...]:
        """The names of the original pieces."""
        return self.definition.letters

    @property
    def order(self) -> int:
        """How many maps are composed: j for the j-th iterate."""
        return len(self.chain)

    @cached_property
    def pieces(self) -> tuple[LinearPiece, ...]:
        """The affine pieces from left to right; they partition the line."""
        return tuple(LinearPiece(cylinder, self) for cylinder in self.cylinders)

    # --- New maps -------------------------------------------------------------------------------

    @explained("values are one mapping, such as .at({'a': '5/4'})")
    def at(self, values: Mapping[Any, object]) -> PiecewiseLinearMap:
        """The map with rational values for parameters, such as ``{a: Rational(5, 4), "r": "0.5"}``.

        The others stay symbols. ValueError if a name is not a parameter, or a value contradicts the
        assumptions or lies outside of the map's cell; TypeError if it is a float.
        """
        return with_values(self, values)

    def iterate(self, j: int) -> PiecewiseLinearMap:
        """The j-th iterate, j >= 1; its pieces are computed on first use.

        ValueError unless j is an integer of at least 1, BudgetError if its words are too long. On
        first use: BudgetError if there are too many pieces, UndecidedError if the assumptions leave
        them open.
        """
        order = checked_order(j)
        checked_size(order, len(self.chain))
        return self.with_chain(self.chain * order)

    def compose(self, inner: PiecewiseLinearMap) -> PiecewiseLinearMap:
        """The map x -> self(inner(x)); words hold the letters of ``inner``, then of ``self``.

        Two maps of one cell give a map of that cell; if the maps are different and both have
        parameters, cells are dropped. ValueError if cells or variables differ.
        """
        check_map(inner)
        return composed(self, inner)

    def __matmul__(self, inner: PiecewiseLinearMap) -> PiecewiseLinearMap:
        """``self @ inner`` is the composition self(inner(x))."""
        return self.compose(inner)

    # --- Values ---------------------------------------------------------------------------------

    def __call__(self, x: object) -> sympy.Expr:
        """The exact value at a point, a rational or an expression in the parameters.

        TypeError if it is a float; UndecidedError if the assumptions leave its piece open.
        """
        return fraction_to_sympy(diagonal.followed(self, x)[1])

    def word_of(self, x: object) -> str:
        """The word of an exact point: the pieces it visits, at a break the one that owns it."""
        return self.spelled(diagonal.followed(self, x)[0])

    @explained()
    def limit(self, x: object, side: str) -> sympy.Expr:
        """The exact limit at ``x`` on a ``side``: ``"-"`` (left) or ``"+"``; else ValueError."""
        if side not in ("-", "+"):
            raise ValueError(f"the side must be '-' or '+', got {side!r}")
        _, value = diagonal.followed(self, x, 1 if side == "+" else -1)
        return fraction_to_sympy(value)

    def jumps(self) -> tuple[Discontinuity, ...]:
        """All discontinuities, from left to right; at single parameter values limits may agree."""
        return tuple(diagonal.jumps(self))

    # --- The diagonal ---------------------------------------------------------------------------

    @explained()
    def fixed_points(self, *, virtual: bool = False) -> tuple[FixedPoint, ...]:
        """All isolated fixed points in the order of their pieces; virtual ones only if asked for.

        UndecidedError if the assumptions leave open whether one exists.
        """
        return tuple(diagonal.fixed_points(self, virtual))

    def fixed_intervals(self) -> tuple[FixedInterval, ...]:
        """All pieces on which the map is the identity."""
        found = ((self.pieces[i], period) for i, period in diagonal.bands(self))
        return tuple(
            FixedInterval(interval=each.interval, word=each.word, order=self.order, period=period)
            for each, period in found
        )

    def jump_crossings(self) -> tuple[JumpCrossing, ...]:
        """All discontinuities that cross the diagonal strictly, from left to right."""
        return tuple(diagonal.jump_crossings(self))

    # --- Cycles ---------------------------------------------------------------------------------

    def cycles(self, period: int) -> tuple[Cycle, ...]:
        """All isolated cycles of a minimal period, each with its alphabetically first word."""
        found = self.iterate(period).fixed_points()
        words = [p.word for p in found if p.period // math.gcd(p.period, self.order) == period]
        return tuple(map(self.cycle, sorted({first_rotation(w, self.order) for w in words})))

    def cycle(self, word: str) -> Cycle:
        """The cycle of a word such as ``"RLL"``, with its conditions; it need not be admissible.

        In a composition letters are those of the inner and the outer map in turn. ValueError if a
        letter is unknown, or the slope is 1 and there is a band (:meth:`fixed_intervals`) or no
        cycle; UndecidedError if the assumptions leave that open.
        """
        return cycle_of(self, word)

    # --- As text --------------------------------------------------------------------------------

    def to_sympy(self) -> sympy.Piecewise:
        """The map as a ``sympy.Piecewise`` in its variable."""
        return sympy.Piecewise(*((p.expression, p.relation) for p in self.pieces))

    def to_dataframe(self) -> DataFrame:
        """The pieces from left to right as a pandas DataFrame; ImportError without pandas.

        Its columns are ``word``, ``slope``, ``intercept``, ``lower``, ``upper`` (expressions of
        sympy), ``lower_closed`` and ``upper_closed``.
        """
        return dataframe(columns_of(self.pieces))

    def __str__(self) -> str:
        return lines_of(self.pieces)

    def __repr__(self) -> str:
        given = f", given {self.definition.region}" if self.given else ""
        names = ", ".join(map(str, self.parameters)) or "none"
        return (
            f"<PiecewiseLinearMap of {self.x}, order {self.order}, "
            f"letters {''.join(self.letters)}, parameters {names}{given}>"
        )

    def _repr_latex_(self) -> str:
        return latex_of(self.pieces, self.order)


def checked_order(j: object) -> int:
    """The order of an iterate; ValueError unless it is an integer of at least 1."""
    order = positive_integer(j)
    if not order:
        raise ValueError(f"the order of an iterate must be an integer j >= 1, got {shown(j)}")
    return order


def check_map(map_: object) -> None:
    """TypeError unless it is a map."""
    if not isinstance(map_, PiecewiseLinearMap):
        raise TypeError(f"expected a PiecewiseLinearMap (see its from_sympy), got {shown(map_)}")


def check_values(map_: object) -> None:
    """TypeError unless it is a map, ValueError if it has parameters without values."""
    check_map(map_)
    assert isinstance(map_, PiecewiseLinearMap)
    if map_.parameters:
        names = ", ".join(map(str, map_.parameters))
        raise ValueError(f"every parameter must have a value (.at), the map still has {names}")
