"""Piecewise-linear maps of the line, with or without jumps, exact and symbolic."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import sympy
from sympy import QQ

from pwmap.algebra.arithmetic import fraction_of, rational
from pwmap.algebra.assumptions import Region, UndecidedError
from pwmap.algebra.exact import (
    Fraction_,
    Number,
    evaluate,
    fraction_to_sympy,
    is_constant,
    polynomial_ring,
    quotient_to_sympy,
    sign,
    to_ring,
)
from pwmap.algebra.inequalities import Constraint
from pwmap.algebra.terms import own_name, shortened
from pwmap.diagrams.frames import DataFrame, dataframe
from pwmap.maps import cylinders as cyl
from pwmap.maps.budget import BUDGET, Meter, checked_size
from pwmap.maps.cylinders import Crossing, Cut, Cylinder, Inclusion, Iterate, minimal_period
from pwmap.maps.reading import Definition, read, read_formula
from pwmap.maps.scopes import Edge, Scope, SymbolicEdge
from pwmap.maps.words import (
    Layout,
    Offset,
    Orbits,
    SignOracle,
    Table,
    Word,
    over_one_denominator,
)

Chain = tuple[int, ...]  # the maps (layouts) that are applied one after the other


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """One affine piece of a map: ``slope x + intercept`` on an interval or at a point.

    The exact values are computed when they are asked for.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap
    >>> p1 = PiecewiseLinearMap.from_sympy("Piecewise((-1, x <= 0), (1 - 5*x/4, True))")
    >>> left, right = p1.pieces
    >>> right.word, right.expression, right.interval
    ('R', 1 - 5*x/4, Interval.open(0, oo))
    >>> right.slope, right.lower_closed
    (-5/4, False)
    """

    cylinder: Cylinder
    owner: PiecewiseLinearMap = field(repr=False)

    @property
    def word(self) -> str:
        """The pieces of the original map that its points visit, in order."""
        return self.owner.spelled(self.cylinder.word)

    @property
    def slope(self) -> sympy.Expr:
        """Slope of the piece."""
        return quotient_to_sympy(self.owner.orbits.slope(self.cylinder.word))

    @property
    def intercept(self) -> sympy.Expr:
        """Value of the piece's formula at x = 0."""
        return quotient_to_sympy(self.owner.orbits.intercept(self.cylinder.word))

    @property
    def expression(self) -> sympy.Expr:
        """The formula ``slope x + intercept``."""
        return self.slope * self.owner.x + self.intercept

    @property
    def lower(self) -> sympy.Expr:
        """Left end, or ``-oo``."""
        cut = self.cylinder.lower
        return -sympy.oo if cut is None else self.owner.cut_to_sympy(self.cylinder.word, cut)

    @property
    def upper(self) -> sympy.Expr:
        """Right end, or ``oo``."""
        cut = self.cylinder.upper
        return sympy.oo if cut is None else self.owner.cut_to_sympy(self.cylinder.word, cut)

    @property
    def lower_closed(self) -> bool:
        """Whether the left end belongs to the piece."""
        return self.cylinder.lower_closed

    @property
    def upper_closed(self) -> bool:
        """Whether the right end belongs to the piece."""
        return self.cylinder.upper_closed

    @property
    def interval(self) -> sympy.Set:
        """The piece's domain as a sympy set."""
        if self.cylinder.is_point:
            return sympy.FiniteSet(self.lower)
        return sympy.Interval(self.lower, self.upper, not self.lower_closed, not self.upper_closed)

    @property
    def relation(self) -> sympy.Basic:
        """The domain as a condition on the variable."""
        x = self.owner.x
        if self.cylinder.is_point:
            return sympy.Eq(x, self.lower)
        bounds = []
        if self.cylinder.lower is not None:
            bounds.append(x >= self.lower if self.lower_closed else x > self.lower)
        if self.cylinder.upper is not None:
            bounds.append(x <= self.upper if self.upper_closed else x < self.upper)
        return sympy.And(*bounds)

    def condition(self) -> str:
        """The domain as text, such as ``0 < x <= r/a``."""
        x = str(self.owner.x)
        if self.cylinder.is_point:
            return f"{x} = {self.lower}"
        left = "" if self.cylinder.lower is None else f"{self.lower} {_less(self.lower_closed)} "
        right = "" if self.cylinder.upper is None else f" {_less(self.upper_closed)} {self.upper}"
        return left + x + right if left or right else f"all {x}"

    def __str__(self) -> str:
        """Word, formula and domain."""
        return f"{self.word}: {self.expression} for {self.condition()}"

    def __repr__(self) -> str:
        """The same in brackets."""
        return f"<Piece {self}>"


@dataclass(frozen=True, slots=True, kw_only=True)
class FixedPoint:
    """A fixed point of an iterate.

    Attributes
    ----------
    x, multiplier
        Exact values. At the end of a piece the multiplier is the slope of the piece that owns
        the point; it is ``nan`` where that piece is the point alone.
    word
        The pieces visited, starting at x.
    order, period
        The iterate it was found in, and the minimal period of the point.
    admissible
        False for a virtual fixed point: that of a formula, outside the formula's piece.
    stable
        Whether all orbits from nearby, on both sides, stay near and converge to it. None if that
        does not follow from the assumptions on the parameters.
    at_border
        Whether it lies at an end of a piece.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap
    >>> p1 = PiecewiseLinearMap.from_sympy("Piecewise((-1, x <= 0), (1 - 5*x/4, True))")
    >>> for point in p1.fixed_points():
    ...     print(point.x, point.word, point.multiplier, point.stable)
    -1 L 0 True
    4/9 R -5/4 False
    """

    x: sympy.Expr
    multiplier: sympy.Expr
    word: str
    order: int
    period: int
    admissible: bool
    stable: bool | None
    at_border: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class FixedInterval:
    """A piece of an iterate that is the identity: every point of it is fixed.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap
    >>> mirror = PiecewiseLinearMap.from_sympy("Piecewise((-x, x <= 1), (x - 2, True))")
    >>> band, *_ = mirror.iterate(2).fixed_intervals()
    >>> band.interval, band.word, band.period
    (Interval(-1, 1), 'LL', 2)
    """

    interval: sympy.Set
    word: str
    order: int
    period: int  # minimal period of its points, but for one of half that if the slope was -1


@dataclass(frozen=True, slots=True, kw_only=True)
class Jump:
    """A discontinuity: the one-sided limits, and the value at the point itself.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap
    >>> p1 = PiecewiseLinearMap.from_sympy("Piecewise((-1, x <= 0), (1 - 5*x/4, True))")
    >>> jump, = p1.jumps()
    >>> jump
    Jump(x=0, left=-1, value=-1, right=1)
    """

    x: sympy.Expr
    left: sympy.Expr
    value: sympy.Expr
    right: sympy.Expr


@dataclass(frozen=True, slots=True, kw_only=True)
class JumpCrossing:
    """A discontinuity whose one-sided limits lie strictly on opposite sides of the diagonal.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap
    >>> p1 = PiecewiseLinearMap.from_sympy("Piecewise((-1, x <= 0), (1 - 5*x/4, True))")
    >>> crossing, = p1.iterate(2).jump_crossings()
    >>> crossing.x, crossing.left, crossing.right, crossing.left_word, crossing.right_word
    (4/5, 1, -1, 'RR', 'RL')
    """

    x: sympy.Expr
    left: sympy.Expr
    right: sympy.Expr
    left_word: str
    right_word: str
    order: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Cycle:
    """A cycle given by its word.

    Attributes
    ----------
    word
        The pieces visited.
    points
        The points, in the order of the word.
    multiplier
        Product of the slopes of the pieces visited; ``nan`` if one of them is a single point.
    conditions
        What must hold for the cycle to exist: each point in its piece.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap
    >>> p1 = PiecewiseLinearMap.from_sympy(
    ...     "Piecewise((r - 2, x <= 0), (r - a*x, True))", given=["a > 1"]
    ... )
    >>> cycle = p1.cycle("RL")
    >>> cycle.points, cycle.multiplier
    ((r - 2, -a*r + 2*a + r), 0)
    >>> cycle.conditions
    (r - 2 > 0, -a*r + 2*a + r <= 0)
    """

    word: str
    points: tuple[sympy.Expr, ...]
    multiplier: sympy.Expr
    conditions: tuple[sympy.Basic, ...]
    _signs: tuple[tuple[Fraction_, bool], ...] = field(repr=False)  # positive, or also zero
    _scope: Scope = field(repr=False)

    @property
    def admissible(self) -> bool:
        """Whether all conditions hold.

        Raises
        ------
        UndecidedError
            If that does not follow from what is assumed of the parameters.
        """
        decide = self._scope.sign
        return all(
            decide(top) * decide(bottom) >= (0 if closed else 1)
            for (top, bottom), closed in self._signs
        )


class Decided(NamedTuple):
    """Where the decisions of a map hold, what makes them, and what is known already."""

    scope: Scope
    orbits: Orbits  # affine forms in the ring of the parameters
    oracle: SignOracle
    iterates: Mapping[Chain, Iterate]  # those that the cell of the map was cut for


class PiecewiseLinearMap:
    """A piecewise-linear map of the line with finitely many pieces.

    Coefficients are quotients of polynomials in parameters over the rationals, whose denominators
    have a sign under what is assumed of the parameters. Each break belongs to the piece
    that says so; a single point can be a piece of its own. Nothing is ever decided by a float.

    Parameters
    ----------
    pieces
        Pairs (formula, condition), sympy expressions or text, such as ``("r - a*x", "x > 0")``.
        Every point must satisfy exactly one condition.
    x
        The variable.
    given
        What is assumed of the parameters: inequalities such as ``a > 1``.
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
    >>> p1 = PiecewiseLinearMap.from_sympy("Piecewise((-1, x <= 0), (1 - 5*x/4, True))")
    >>> print(p1.iterate(2))
    LL  -1             for x <= 0
    RR  25*x/16 - 1/4  for 0 < x < 4/5
    RL  -1             for 4/5 <= x
    >>> [point.x for point in p1.fixed_points()]
    [-1, 4/9]
    >>> [jump.x for jump in p1.iterate(2).jump_crossings()]
    [4/5]

    Parameters may stay symbols, if what is assumed of them decides every sign:

    >>> p1 = PiecewiseLinearMap.from_sympy(
    ...     "Piecewise((r - 2, x <= 0), (r - a*x, True))", given=["a > 1", "r > 0", "r < 2"]
    ... )
    >>> [point.x for point in p1.fixed_points()]
    [r - 2, r/(a + 1)]
    >>> p1.at({"a": 2, "r": 1}).iterate(3).jump_crossings()[0].x
    1/4
    """

    def __init__(
        self,
        pieces: Sequence[tuple[object, object]],
        x: object = "x",
        given: Iterable[object] = (),
        letters: Sequence[str] | None = None,
    ) -> None:
        self._set(read(pieces, x, given, letters, first_wins=False), (0,))

    @classmethod
    def from_sympy(
        cls,
        piecewise: object,
        x: object = "x",
        given: Iterable[object] = (),
        letters: Sequence[str] | None = None,
    ) -> PiecewiseLinearMap:
        """Build a map from a ``sympy.Piecewise`` or its text.

        The first condition that holds counts. Errors are those of the class.

        Parameters
        ----------
        piecewise
            A ``sympy.Piecewise`` of affine formulas, one such formula, or the text of either.
        x, given, letters
            As for the class.

        Returns
        -------
        PiecewiseLinearMap
            The map, its pieces in the order of the line.
        """
        self = cls.__new__(cls)
        self._set(read_formula(piecewise, x, given, letters), (0,))
        return self

    def _set(
        self,
        definition: Definition,
        chain: Chain,
        decided: Decided | None = None,
        known: dict[Chain, tuple[Cylinder, ...]] | None = None,
    ) -> None:
        self._definition = definition
        self._chain = chain
        if decided is None:
            orbits = Orbits(definition.table)
            decide = sign if definition.ring is None else definition.region.sign
            decided = Decided(definition.region, orbits, SignOracle(orbits, decide), {})
        self._decided = decided
        self._known: dict[Chain, tuple[Cylinder, ...]] = (
            {(): cyl.WHOLE_LINE, **{c: it.cylinders for c, it in decided.iterates.items()}}
            if known is None
            else known
        )

    @classmethod
    def decided(
        cls,
        map_: PiecewiseLinearMap,
        scope: Scope,
        orbits: Orbits,
        oracle: SignOracle,
        iterates: Mapping[Chain, Iterate],
    ) -> PiecewiseLinearMap:
        """A map whose decisions are made for one cell of a parameter.

        Parameters
        ----------
        map_
            The map, with what it assumes.
        scope
            The cell.
        orbits, oracle
            Affine forms in the ring of all parameters, and their signs there.
        iterates
            What iterates show there.

        Returns
        -------
        PiecewiseLinearMap
            The same map, for which all signs of the cell are known.
        """
        self = cls.__new__(cls)
        self._set(map_._definition, map_._chain, Decided(scope, orbits, oracle, iterates))
        return self

    def __reduce__(self) -> tuple[Callable[..., PiecewiseLinearMap], tuple[object, ...]]:
        return _restored, (self._definition, self._chain, self._decided)

    def _with_chain(self, chain: Chain) -> PiecewiseLinearMap:
        other = PiecewiseLinearMap.__new__(PiecewiseLinearMap)
        other._set(self._definition, chain, self._decided, self._known)
        return other

    @property
    def scope(self) -> Scope:
        """For which values of the parameters all answers hold: the assumptions, or a cell."""
        return self._decided.scope

    @property
    def oracle(self) -> SignOracle:
        """The signs that hold for all these values."""
        return self._decided.oracle

    @property
    def orbits(self) -> Orbits:
        """Affine forms of words in the ring of the parameters."""
        return self._decided.orbits

    # --- What it is -----------------------------------------------------------------------------

    @property
    def x(self) -> sympy.Symbol:
        """The variable."""
        return self._definition.x

    @property
    def parameters(self) -> tuple[sympy.Symbol, ...]:
        """The parameters that have no value yet."""
        return tuple(self._definition.ring.symbols) if self._definition.ring is not None else ()

    @property
    def given(self) -> tuple[sympy.Basic, ...]:
        """What is assumed of the parameters."""
        return self._definition.region.relations()

    @property
    def letters(self) -> tuple[str, ...]:
        """The names of the original pieces."""
        return self._definition.letters

    @property
    def order(self) -> int:
        """How many maps are composed: j for the j-th iterate."""
        return len(self._chain)

    @property
    def definition(self) -> Definition:
        """Coefficients and assumptions."""
        return self._definition

    @property
    def chain(self) -> Chain:
        """Which maps are applied one after the other."""
        return self._chain

    @cached_property
    def cylinders(self) -> tuple[Cylinder, ...]:
        """The pieces in combinatorial form, from left to right."""
        chain, known = self._chain, self._known
        start = next(n for n in range(len(chain), -1, -1) if chain[:n] in known)
        meter = Meter(BUDGET)
        for n in range(start, len(chain)):
            known[chain[: n + 1]] = cyl.refined(known[chain[:n]], chain[n], self.oracle, meter)
        return known[chain]

    @cached_property
    def pieces(self) -> tuple[Piece, ...]:
        """The affine pieces from left to right; they partition the line."""
        return tuple(Piece(cylinder, self) for cylinder in self.cylinders)

    def spelled(self, word: Word) -> str:
        """A word in letters.

        Parameters
        ----------
        word
            Numbers of pieces.

        Returns
        -------
        str
            Its letters, in the order in which pieces are visited.
        """
        return "".join(self.letters[letter] for letter in word)

    def cut_to_sympy(self, word: Word, cut: Cut) -> sympy.Expr:
        """The exact value of an end of a piece.

        Parameters
        ----------
        word
            Word of a piece, as numbers.
        cut
            An end of it.

        Returns
        -------
        sympy.Expr
            A formula in the parameters, or infinity.
        """
        return fraction_to_sympy(self.orbits.preimage(cut.k, word[: cut.steps]))

    # --- New maps -------------------------------------------------------------------------------

    def at(self, values: Mapping[Any, object]) -> PiecewiseLinearMap:
        """Give some or all parameters rational values.

        Parameters
        ----------
        values
            By symbol or by name, for instance ``{a: Rational(5, 4), "r": 1}``.

        Returns
        -------
        PiecewiseLinearMap
            A new map; parameters that got no value stay symbols.

        Raises
        ------
        ValueError
            If a name is no parameter of the map, or a value contradicts the assumptions or, for
            the map of a cell, lies outside.
        TypeError
            If a value is a float.
        """
        definition = self._definition
        numbers = {
            own_name(name, self.parameters): rational(value) for name, value in values.items()
        }
        names = [str(symbol) for symbol in self.parameters]
        for name in numbers:
            if name not in names:
                raise ValueError(f"{name} is no parameter of this map, it has {names or 'none'}")
        if not numbers:
            return self
        given = shortened(", ".join(f"{n} = {QQ.to_sympy(v)}" for n, v in numbers.items()))
        broken = definition.region.contains(numbers)
        if broken is not None:
            raise ValueError(f"{given} contradicts the assumption {broken}")
        cell = self.scope.contains(numbers)
        if cell is not None:
            raise ValueError(f"{given} lies outside of the cell {cell}, for which this map holds")
        ring = polynomial_ring([s for s in self.parameters if str(s) not in numbers])
        constraints = [
            Constraint(evaluate(c.polynomial, numbers, ring), c.strict)
            for c in dict.fromkeys((*definition.region.constraints, *self.scope.constraints))
        ]
        region = Region(ring, tuple(c for c in constraints if not is_constant(c.polynomial)))
        _ = region.sample  # complains if the values leave nothing
        table = definition.table.mapped(lambda number: evaluate(number, numbers, ring))
        other = PiecewiseLinearMap.__new__(PiecewiseLinearMap)
        other._set(Definition(definition.x, ring, region, table, definition.letters), self._chain)
        return other

    def iterate(self, j: int) -> PiecewiseLinearMap:
        """The j-th iterate, j >= 1, with the words of its pieces.

        Parameters
        ----------
        j
            The order, at least 1.

        Returns
        -------
        PiecewiseLinearMap
            The iterate, whose pieces are computed when they are asked for.

        Raises
        ------
        BudgetError
            If its words would be too long, or when its pieces are asked for and are too many.
        UndecidedError
            When its pieces are asked for, if they differ within what is assumed of the parameters.
        ValueError
            If j is no integer of at least 1.
        """
        order = checked_order(j)
        checked_size(order, len(self._chain))
        return self._with_chain(self._chain * order)

    def compose(self, inner: PiecewiseLinearMap) -> PiecewiseLinearMap:
        """The map x -> self(inner(x)); words hold the letters of ``inner``, then of ``self``.

        Maps of one cell make a map of this cell. If two different maps both have parameters,
        only their assumptions are kept.

        Parameters
        ----------
        inner
            The map that is applied first.

        Returns
        -------
        PiecewiseLinearMap
            The composition.

        Raises
        ------
        ValueError
            If the maps belong to different cells, or have different variables.
        """
        if inner._definition == self._definition:
            wide = self.scope == self._definition.region  # a cell is the narrower one
            if not wide and inner.scope not in (self.scope, inner._definition.region):
                cells = f"{self.scope} and {inner.scope}"
                raise ValueError(f"the maps hold in different cells, {cells}")
            return (inner if wide else self)._with_chain(inner._chain + self._chain)
        definition, shift = _joined(inner._definition, self._definition)
        other = PiecewiseLinearMap.__new__(PiecewiseLinearMap)
        chain = inner._chain + tuple(i + shift for i in self._chain)
        cell = next((m.scope for m in (self, inner) if m.scope != m._definition.region), None)
        if cell is None or (self.parameters and inner.parameters):
            other._set(definition, chain)
        else:
            orbits = Orbits(definition.table)
            other._set(definition, chain, Decided(cell, orbits, SignOracle(orbits, cell.sign), {}))
        return other

    def __matmul__(self, inner: PiecewiseLinearMap) -> PiecewiseLinearMap:
        """``self @ inner`` is the composition self(inner(x))."""
        return self.compose(inner)

    # --- Values ---------------------------------------------------------------------------------

    def __call__(self, x: object) -> sympy.Expr:
        """The exact value at a point, a rational or an expression in the parameters.

        Raises
        ------
        TypeError
            If the point is a float.
        UndecidedError
            If the assumptions do not say in which piece it lies.
        """
        return fraction_to_sympy(self._follow(x, 0)[1])

    def word_of(self, x: object) -> str:
        """The pieces of the original map that a point visits.

        Parameters
        ----------
        x
            An exact number; parameters may occur in it.

        Returns
        -------
        str
            Its letters. At a break it is the piece that owns the break.
        """
        return self.spelled(self._follow(x, 0)[0])

    def limit(self, x: object, side: str) -> sympy.Expr:
        """The one-sided limit at a point, from the side ``"-"`` (left) or ``"+"`` (right).

        Parameters
        ----------
        x
            An exact number; parameters may occur in it.
        side
            ``"-"`` or ``"+"``.

        Returns
        -------
        sympy.Expr
            The exact limit, whoever owns the value at the point itself.

        Raises
        ------
        ValueError
            If the side is neither.
        """
        if side not in ("-", "+"):
            raise ValueError(f"the side must be '-' or '+', got {side!r}")
        return fraction_to_sympy(self._follow(x, 1 if side == "+" else -1)[1])

    def _follow(self, x: object, direction: int) -> tuple[Word, Fraction_]:
        """Word and value of a point (direction 0) or of points just beside it (-1, +1)."""
        table, decide = self._definition.table, self.scope.sign
        top, bottom = self._fraction(x)
        word: list[int] = []
        slopes: list[Number] = []
        for layout_index in self._chain:
            layout = table.layouts[layout_index]
            slot = self._slot(layout, (top, bottom))
            if slot % 2 and direction:  # only here it matters on which side the points are
                slot += direction * math.prod(decide(slope) for slope in slopes)
            letter = layout.slots[slot]
            word.append(letter)
            slope = table.slopes[letter]
            top = slope * top + table.intercepts[letter] * bottom
            bottom = table.denominator * bottom
            slopes.append(slope)
        return tuple(word), (top, bottom)

    def _slot(self, layout: Layout, point: Fraction_) -> int:
        top, bottom = point
        decide = self.scope.sign
        side = decide(bottom)
        for i, k in enumerate(layout.breaks):
            table = self._definition.table
            order = side * decide(table.denominator * top - table.breaks[k] * bottom)
            if order <= 0:
                return 2 * i + (order == 0)
        return 2 * len(layout.breaks)

    def _fraction(self, x: object) -> Fraction_:
        return fraction_of(x, self._definition.ring, "a point")

    def jumps(self) -> tuple[Jump, ...]:
        """All discontinuities, from left to right: where the limits differ as formulas.

        These may still agree for single values of the parameters.
        """
        return tuple(self._jumps())

    def _jumps(self) -> Iterator[Jump]:
        value = self.orbits.value
        for before, left, right, after in _neighbours(self.cylinders):
            cut = right.lower
            assert cut is not None
            owner = left if left.upper_closed else right
            limits = [value(cut.k, c.word[cut.steps :]) for c in (before, owner, after)]
            if self._differ(limits):
                values = [quotient_to_sympy(limit) for limit in limits]
                x = self.cut_to_sympy(right.word, cut)
                yield Jump(x=x, left=values[0], value=values[1], right=values[2])

    def _differ(self, limits: Sequence[Fraction_]) -> bool:
        """Whether the numbers at a break differ as formulas; at an edge, whether they differ."""
        return not all(self._is_zero(a * d - c * b) for (a, b), (c, d) in pairwise(limits))

    def _is_zero(self, number: Number) -> bool:
        """Whether a number is zero for all parameters, or at the edge of the map."""
        at_edge = isinstance(self.scope, Edge | SymbolicEdge)
        return not number or (at_edge and self.scope.sign(number) == 0)

    # --- The diagonal ---------------------------------------------------------------------------

    def _inclusion(self, i: int) -> Inclusion:
        """Whether the fixed point of a cylinder lies in it, and where."""
        iterate = self._decided.iterates.get(self._chain)
        if iterate is not None:
            return iterate.inclusion[i]
        return cyl.inclusion_of(self.cylinders[i], None, self.oracle)

    def fixed_points(self, *, virtual: bool = False) -> tuple[FixedPoint, ...]:
        """All isolated fixed points, from left to right.

        Parameters
        ----------
        virtual
            Whether to add the virtual ones, in the order of their formulas' pieces.

        Returns
        -------
        tuple of FixedPoint
            Each with its exact x, multiplier and stability.

        Raises
        ------
        UndecidedError
            If the assumptions on the parameters leave open whether one exists.
        """
        found = []
        for i, cylinder in enumerate(self.cylinders):
            inclusion = self._inclusion(i)
            if inclusion in (Inclusion.NONE, Inclusion.BAND):
                continue
            is_virtual = inclusion is Inclusion.VIRTUAL
            if is_virtual and (not virtual or self.oracle.multiplier(cylinder.word, 1) == 0):
                continue
            found.append(self._fixed_point(i, inclusion))
        return tuple(found)

    def _fixed_point(self, i: int, inclusion: Inclusion) -> FixedPoint:
        cylinder = self.cylinders[i]
        word = cylinder.word
        if inclusion is Inclusion.POINT:
            assert cylinder.lower is not None
            x = self.cut_to_sympy(word, cylinder.lower)
        else:
            x = fraction_to_sympy(self.orbits.fixed_point(word))
        multiplier = quotient_to_sympy(self.orbits.slope(word))
        return FixedPoint(
            x=x,
            multiplier=sympy.nan if inclusion is Inclusion.POINT else multiplier,
            word=self.spelled(word),
            order=self.order,
            period=self._period(word),
            admissible=inclusion is not Inclusion.VIRTUAL,
            stable=self._is_stable(i, inclusion),
            at_border=inclusion in (Inclusion.LOWER, Inclusion.UPPER, Inclusion.POINT),
        )

    def _is_stable(self, i: int, inclusion: Inclusion) -> bool | None:
        """Whether a fixed point attracts; None if that is open, as what would refuse it is."""
        iterate = self._decided.iterates.get(self._chain)
        if iterate is not None:
            return iterate.stable[i]
        open_ = False
        cut, words = cyl.words_beside(self.cylinders, i, inclusion)
        for test in cyl.stability_tests(cut, words, self.oracle):
            try:
                if not test():
                    return False
            except UndecidedError:
                open_ = True
        return None if open_ else True

    def _period(self, word: Word) -> int:
        """Minimal period of a point with a word, counted in single maps."""
        unit = minimal_period(self._chain)  # an iterate of p @ q repeats every two maps
        return minimal_period(word, unit) * unit

    def fixed_intervals(self) -> tuple[FixedInterval, ...]:
        """All pieces on which the map is the identity."""
        return tuple(
            FixedInterval(
                interval=piece.interval,
                word=piece.word,
                order=self.order,
                period=self._band_period(piece.cylinder.word),
            )
            for i, piece in enumerate(self.pieces)
            if self._inclusion(i) is Inclusion.BAND
        )

    def _band_period(self, word: Word) -> int:
        """Where a word's own slope is -1, points beside its fixed point have twice its period."""
        period = self._period(word)
        return period if self.oracle.slope(word[:period]) > 0 else 2 * period

    def jump_crossings(self) -> tuple[JumpCrossing, ...]:
        """All discontinuities that cross the diagonal strictly, from left to right."""
        iterate = self._decided.iterates.get(self._chain)
        if iterate is not None:
            return tuple(map(self._jump_crossing, iterate.crossings))
        sides = (None if c.is_point else cyl.sides_of(c, self.oracle) for c in self.cylinders)
        return tuple(map(self._jump_crossing, cyl.crossings(self.cylinders, sides)))

    def _jump_crossing(self, crossing: Crossing) -> JumpCrossing:
        cut = crossing.cut
        value = self.orbits.value
        return JumpCrossing(
            x=self.cut_to_sympy(crossing.left, cut),
            left=quotient_to_sympy(value(cut.k, crossing.left[cut.steps :])),
            right=quotient_to_sympy(value(cut.k, crossing.right[cut.steps :])),
            left_word=self.spelled(crossing.left),
            right_word=self.spelled(crossing.right),
            order=self.order,
        )

    # --- Cycles ---------------------------------------------------------------------------------

    def cycles(self, period: int) -> tuple[Cycle, ...]:
        """All isolated cycles of a minimal period, each once.

        Each starts at its point with the alphabetically first word.

        Parameters
        ----------
        period
            The least period.

        Returns
        -------
        tuple of Cycle
            In the alphabetical order of their words.
        """
        found = self.iterate(period).fixed_points()
        words = [p.word for p in found if p.period // math.gcd(p.period, self.order) == period]
        step = self.order
        first = {min(w[i:] + w[:i] for i in range(0, len(w), step)) for w in words}
        return tuple(self.cycle(word) for word in sorted(first))

    def cycle(self, word: str) -> Cycle:
        """The cycle that visits the pieces a word names, with its conditions of existence.

        Parameters
        ----------
        word
            Letters of :attr:`letters`, for instance ``"RLL"``; each names a piece of the map that
            acts at its position, in a composition those of the inner map and the outer in turn.

        Returns
        -------
        Cycle
            Its exact points and multiplier; it need not be admissible.

        Raises
        ------
        ValueError
            If a letter is unknown, or the word's slope is 1 and its points form a band, which is
            listed by :meth:`fixed_intervals`, or no cycle at all.
        UndecidedError
            If the word's slope is 1, and the assumptions leave open which of these it is.
        """
        indices = self._read_word(word)
        points, multiplier = self._cycle_points(indices)
        conditions: list[sympy.Basic] = []
        signs: list[tuple[Fraction_, bool]] = []
        for (top, bottom), layout, index in zip(
            points, self._layouts(len(word)), indices, strict=True
        ):
            for k, side, closed in letter_bounds(layout, index):
                value = self.orbits.preimage(k, ())
                over = side * (value[1] * top - value[0] * bottom)
                if closed and not over:  # the point is this break
                    continue
                signs.append(((over, bottom), closed))
                relations = (sympy.Ge, sympy.Gt) if side > 0 else (sympy.Le, sympy.Lt)
                relation = relations[0 if closed else 1]
                conditions.append(
                    relation(fraction_to_sympy((top, bottom)), quotient_to_sympy(value))
                )
        return Cycle(
            word=word,
            points=tuple(fraction_to_sympy(point) for point in points),
            multiplier=multiplier,
            conditions=tuple(c for c in dict.fromkeys(conditions) if c != sympy.true),
            _signs=tuple(signs),
            _scope=self.scope,
        )

    def _layouts(self, n: int) -> list[Layout]:
        """The layouts of n maps in a row, the chain repeated."""
        return [self._definition.table.layouts[self._chain[i % self.order]] for i in range(n)]

    def _read_word(self, word: str) -> Word:
        """The pieces that the letters of a word name; two maps may use the same letter."""
        indices = []
        for letter, layout in zip(word, self._layouts(len(word)), strict=True):
            own = {self.letters[i]: i for i in dict.fromkeys(layout.slots)}
            if letter not in own:
                raise ValueError(f"{letter!r} is no piece of this map, it has {tuple(own)}")
            indices.append(own[letter])
        if not word:
            raise ValueError("the word of a cycle must have at least one letter")
        if len(word) % self.order:
            raise ValueError(f"the length of a word must be a multiple of {self.order}: {word!r}")
        return tuple(indices)

    def _cycle_points(self, word: Word) -> tuple[list[Fraction_], sympy.Expr]:
        """Points and multiplier of a cycle."""
        root = word[: self._period(word)]  # what is repeated has the same points
        slope = self.orbits.slope(word)
        at = self._point_piece(root)
        multiplier = quotient_to_sympy(slope) if at is None else sympy.nan
        if at is None and self._is_zero(slope[0] - slope[1]):
            root, at = word, self._only_point(word)
        if at is None:
            points = self._orbit(self.orbits.fixed_point(root), root)
        else:
            turned = root[at.steps :] + root[: at.steps]
            points = self._orbit(self.orbits.preimage(at.k, ()), turned)
            points = points[len(root) - at.steps :] + points[: len(root) - at.steps]
        return points * (len(word) // len(root)), multiplier

    def _orbit(self, start: Fraction_, word: Word) -> list[Fraction_]:
        """A point and its images along a word, but for the last one."""
        table, (top, bottom) = self.orbits.table, start
        points = []
        for letter in word:
            points.append((top, bottom))
            top = table.slopes[letter] * top + table.intercepts[letter] * bottom
            bottom = table.denominator * bottom
        return points

    def _point_piece(self, word: Word) -> Cut | None:
        """Where a cycle passes through a piece that is a point."""
        for i, (layout, letter) in enumerate(zip(self._layouts(len(word)), word, strict=True)):
            if layout.slots.count(letter) == 1 and layout.slots.index(letter) % 2:
                return Cut(layout.breaks[layout.slots.index(letter) // 2], i)
        return None

    def _only_point(self, word: Word) -> Cut:
        """Where a cycle passes whose word has slope 1.

        All points of such a word are fixed, or none. The cycle is isolated where the word has one
        point only: its neighbours, on both sides, visit other pieces.
        """
        if self.oracle.sign(Offset(word)) == 0:
            chain = self._chain * (len(word) // self.order)
            cylinder = cyl.cylinder_of(word, chain, self.oracle)
            if cylinder is not None and cylinder.is_point:
                assert cylinder.lower is not None
                return cylinder.lower
        raise ValueError(f"the slope of {self.spelled(word)} is 1: it has no isolated cycle")

    # --- As text --------------------------------------------------------------------------------

    def to_sympy(self) -> sympy.Piecewise:
        """The map as a ``sympy.Piecewise`` in its variable."""
        return sympy.Piecewise(*((p.expression, p.relation) for p in self.pieces))

    def to_dataframe(self) -> DataFrame:
        """The pieces from left to right, one in each row.

        Returns
        -------
        pandas.DataFrame
            With the columns ``word``, ``slope``, ``intercept``, ``lower``, ``upper`` (exact, as
            expressions of sympy), ``lower_closed`` and ``upper_closed``.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        pieces = self.pieces
        names = ("word", "slope", "intercept", "lower", "upper", "lower_closed", "upper_closed")
        return dataframe({name: [getattr(piece, name) for piece in pieces] for name in names})

    def __str__(self) -> str:
        """One line for each piece: its word, formula and domain."""
        rows = [(p.word, str(p.expression), p.condition()) for p in self.pieces]
        widths = [max(len(row[i]) for row in rows) for i in range(2)]
        return "\n".join(
            f"{word:<{widths[0]}}  {formula:<{widths[1]}}  for {condition}"
            for word, formula, condition in rows
        )

    def __repr__(self) -> str:
        """Variable, order, letters, parameters and assumptions."""
        given = f", given {self._definition.region}" if self.given else ""
        names = ", ".join(map(str, self.parameters)) or "none"
        return (
            f"<PiecewiseLinearMap of {self.x}, order {self.order}, "
            f"letters {''.join(self.letters)}, parameters {names}{given}>"
        )

    def _repr_latex_(self) -> str:
        rows = []
        for piece in self.pieces:
            domain = sympy.latex(piece.relation)
            rows.append(rf"{sympy.latex(piece.expression)} & {domain} & \text{{{piece.word}}}")
        body = r" \\ ".join(rows)
        head = f"P_{{{self.order}}}({sympy.latex(self.x)})"
        return (
            rf"$\displaystyle {head} = \left\{{\begin{{array}}{{lll}} {body} \end{{array}}\right.$"
        )


def _restored(definition: Definition, chain: Chain, decided: Decided) -> PiecewiseLinearMap:
    """A map as it was before it was copied or pickled; its pieces are made anew."""
    map_ = PiecewiseLinearMap.__new__(PiecewiseLinearMap)
    map_._set(definition, chain, decided)
    return map_


def checked_order(j: object) -> int:
    """The order of an iterate; ValueError unless it is an integer of at least 1."""
    try:
        order = operator.index(j)  # type: ignore[arg-type]
    except TypeError:
        order = 0
    if order < 1 or isinstance(j, bool):
        raise ValueError(f"the order of an iterate must be an integer j >= 1, got {j}")
    return order


def _less(closed: bool) -> str:
    return "<=" if closed else "<"


def letter_bounds(layout: Layout, letter: int) -> Iterator[tuple[int, int, bool]]:
    """Breaks that bound a letter, the side of each it lies on, and whether it owns them."""
    owned = [slot for slot, owner in enumerate(layout.slots) if owner == letter]
    low, high = min(owned), max(owned)
    if low > 0:
        yield layout.breaks[(low - 1) // 2], 1, bool(low % 2)
    if high < len(layout.slots) - 1:
        yield layout.breaks[high // 2], -1, bool(high % 2)


def _neighbours(
    cylinders: Sequence[Cylinder],
) -> Iterator[tuple[Cylinder, Cylinder, Cylinder, Cylinder]]:
    """For each cut: the interval before it, the pieces that meet there, the interval after it.

    A piece that is a single point lies between two cuts at the same place; that cut comes once.
    """
    for i, (left, right) in enumerate(pairwise(cylinders)):
        if left.is_point:
            continue
        after = cylinders[i + 2] if right.is_point else right
        yield left, left, right, after


def _joined(first: Definition, second: Definition) -> tuple[Definition, int]:
    """Two maps in one table, and by how much the layouts of the second were shifted."""
    if first.x != second.x:
        raise ValueError(f"the maps have different variables, {first.x} and {second.x}")
    symbols = {
        str(s): s for ring in (first.ring, second.ring) if ring is not None for s in ring.symbols
    }
    ring = polynomial_ring([symbols[name] for name in sorted(symbols)])
    tables = over_one_denominator(
        [m.table.mapped(lambda number: to_ring(number, ring)) for m in (first, second)]
    )
    letters, breaks = len(first.letters), len(first.table.breaks)
    shifted = [
        Layout(tuple(k + breaks for k in lay.breaks), tuple(s + letters for s in lay.slots))
        for lay in second.table.layouts
    ]
    constraints = [
        Constraint(to_ring(c.polynomial, ring), c.strict)
        for m in (first, second)
        for c in m.region.constraints
    ]
    region = Region(ring, tuple(dict.fromkeys(constraints)))
    _ = region.sample
    table = Table(
        tables[0].slopes + tables[1].slopes,
        tables[0].intercepts + tables[1].intercepts,
        tables[0].breaks + tables[1].breaks,
        (*first.table.layouts, *shifted),
        tables[0].one,
        tables[0].denominator,
    )
    definition = Definition(first.x, ring, region, table, first.letters + second.letters)
    return definition, len(first.table.layouts)
