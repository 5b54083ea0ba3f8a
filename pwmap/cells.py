"""Parameter cells: where along a parameter the same words describe the iterates of a map.

A map is studied at an exact sample; every sign that was asked for is remembered with the
polynomial behind it. The nearest roots of these polynomials bound the cell of the sample: inside
it no answer changes, so all words, fixed points and crossings are the same. The next sample is
taken beyond. Edges are cells of their own, studied exactly at the root.

With other parameters symbolic the same is done at a sample of these; every polynomial must then be
of degree one in the parameter of the axis, so that its root is a quotient of polynomials in the
others. The order of all roots is recorded too: where it persists, the whole picture holds.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import total_ordering
from itertools import islice
from typing import Any

import sympy
from sympy import QQ
from sympy.polys.rings import PolyElement

from pwmap.assumptions import Constraint
from pwmap.cylinders import (
    WHOLE_LINE,
    Crossing,
    Cylinder,
    Place,
    crossings,
    is_stable,
    place_of_fixed_point,
    refined,
)
from pwmap.exact import (
    Fraction_,
    Number,
    evaluate,
    is_constant,
    polynomial_ring,
    rational,
    sign,
    to_sympy,
)
from pwmap.itineraries import Judge, Orbits, Question
from pwmap.maps import PiecewiseLinearMap
from pwmap.reading import Model
from pwmap.roots import Dense, RealRoot, real_roots, sign_at, simplest_between, trimmed

INFINITE = "infinite"


@total_ordering
@dataclass(frozen=True, slots=True, eq=False)
class Threshold:
    """A value of the parameter that depends on other, symbolic parameters.

    Attributes
    ----------
    value
        Its value at the sample of the other parameters.
    expr
        The quotient of polynomials in the others.
    """

    value: Number
    expr: Any

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Threshold) and self.value == other.value

    def __hash__(self) -> int:
        return hash(self.value)

    def __lt__(self, other: Threshold) -> bool:
        return bool(self.value < other.value)


class ResampleError(Exception):
    """The sample of the symbolic parameters is not generic."""


class Axis(ABC):
    """One parameter of a map, along which the signs of polynomials are followed."""

    model: Model
    name: str
    orbits: Orbits  # of the map, in all its parameters
    given: tuple[sympy.Basic, ...]

    @abstractmethod
    def place(self, value: Number) -> Any:
        """A rational value as a place on the axis."""

    @abstractmethod
    def between(self, low: Any, high: Any) -> Any:
        """A place strictly between two others; None is an infinite end."""

    @abstractmethod
    def judge(self, place: Any) -> Judge:
        """Who decides all signs at a place."""

    @abstractmethod
    def roots(self, question: Question) -> tuple[Any, ...] | None:
        """Places where the answer to a question is zero; None if it is zero everywhere."""

    @abstractmethod
    def value(self, fraction: Fraction_, place: Any) -> Hashable:
        """A quotient at a place, in a canonical form, or INFINITE."""

    @abstractmethod
    def order(self, first: Fraction_, second: Fraction_, place: Any) -> int:
        """Sign of the difference of two finite quotients at a place."""

    @abstractmethod
    def to_sympy(self, place: Any) -> sympy.Expr:
        """A place as an expression."""

    @abstractmethod
    def number(self, fraction: Fraction_, place: Any) -> float:
        """A finite quotient at a place as a float."""

    @abstractmethod
    def value_to_sympy(self, value: Any, place: Any) -> sympy.Expr:
        """What :meth:`value` returned for a place, as an expression."""

    @abstractmethod
    def spread(self, low: Any, high: Any, n: int) -> list[Any]:
        """Places that part an interval, up to rounding, in n + 1 equal parts."""

    @property
    def identity(self) -> Fraction_:
        """The parameter itself, as a quotient."""
        ring = self.model.ring
        names = [str(symbol) for symbol in ring.symbols]
        return ring.gens[names.index(self.name)], ring.one

    def degree(self, number: Number) -> int:
        """Degree of a polynomial in the parameter of the axis; 0 for zero."""
        index = [str(symbol) for symbol in self.model.ring.symbols].index(self.name)
        return max(0, int(number.degree(index))) if number else 0

    @abstractmethod
    def closing(self, places: Sequence[Any]) -> tuple[sympy.Basic, ...]:
        """Conditions on the other parameters under which all that was found holds."""


class RationalAxis(Axis):
    """The only parameter of a map."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.orbits = Orbits(model.table)
        self.name = str(model.ring.symbols[0])
        self.given = ()
        self._roots: dict[Question, tuple[Any, ...] | None] = {}

    def place(self, value: Number) -> Number:
        return value

    def between(self, low: Any, high: Any) -> Number:
        return simplest_between(low, high)

    def judge(self, place: Any) -> Judge:
        if isinstance(place, RealRoot):
            return Judge(self.orbits, lambda number: place.sign_of(_dense(number)))
        table = self.model.table.mapped(lambda number: _at(number, place))
        return Judge(Orbits(table), sign)

    def roots(self, question: Question) -> tuple[Any, ...] | None:
        if question not in self._roots:
            polynomial = _dense(self.orbits.polynomial(question))
            self._roots[question] = real_roots(polynomial) if polynomial else None
        return self._roots[question]

    def value(self, fraction: Fraction_, place: Any) -> Hashable:
        top, bottom = (_dense(number) for number in fraction)
        if sign_at(bottom, place) == 0:
            return INFINITE
        if isinstance(place, RealRoot):
            return place.quotient(top, bottom)
        return _at(fraction[0], place) / _at(fraction[1], place)

    def order(self, first: Fraction_, second: Fraction_, place: Any) -> int:
        (a, b), (c, d) = first, second
        bottom = sign_at(_dense(b), place) * sign_at(_dense(d), place)
        return sign_at(_dense(a * d - c * b), place) * bottom

    def to_sympy(self, place: Any) -> sympy.Expr:
        return place.to_sympy() if isinstance(place, RealRoot) else QQ.to_sympy(place)

    def number(self, fraction: Fraction_, place: Any) -> float:
        if isinstance(place, RealRoot):
            place = place.refined_to(QQ(1, 2**80))
        top, bottom = (_at(number, place) for number in fraction)
        return float(top / bottom)

    def value_to_sympy(self, value: Any, place: Any) -> sympy.Expr:
        if not isinstance(place, RealRoot):
            return QQ.to_sympy(value)
        root = place.to_sympy()
        powers = enumerate(reversed(value))
        return sympy.radsimp(sympy.expand(sum(QQ.to_sympy(c) * root**i for i, c in powers)))

    def spread(self, low: Any, high: Any, n: int) -> list[Number]:
        fine = QQ(1, 2**60)
        first, last = (x.refined_to(fine) if isinstance(x, RealRoot) else x for x in (low, high))
        return [first + (last - first) * QQ(i, n + 1) for i in range(1, n + 1)]

    def closing(self, places: Sequence[Any]) -> tuple[sympy.Basic, ...]:
        return ()


class SymbolicAxis(Axis):
    """One parameter of a map that has others, which stay symbolic.

    Parameters
    ----------
    model
        The map.
    name
        The parameter of the axis.
    sample
        Values of the other parameters at which the picture is drawn.
    """

    def __init__(self, model: Model, name: str, sample: dict[str, Number]) -> None:
        self.model, self.name, self.sample = model, name, sample
        self.orbits = Orbits(model.table)
        names = [str(s) for s in model.ring.symbols]
        self._index = names.index(name)
        self._others = polynomial_ring([s for s in model.ring.symbols if str(s) != name])
        self._field = self._others.to_field()
        self._roots: dict[Question, tuple[Any, ...] | None] = {}
        self._conditions: dict[PolyElement, None] = {}
        self.given = ()

    def place(self, value: Number) -> Threshold:
        return Threshold(value, self._field.ground_new(value))

    def between(self, low: Any, high: Any) -> Threshold:
        ends = (end.value if end is not None else None for end in (low, high))
        return self.place(simplest_between(*ends))

    def judge(self, place: Threshold) -> Judge:
        values = {**self.sample, self.name: place.value}
        return Judge(Orbits(self.model.table.mapped(lambda n: evaluate(n, values, None))), sign)

    def roots(self, question: Question) -> tuple[Any, ...] | None:
        if question not in self._roots:
            self._roots[question] = self._solved(self.orbits.polynomial(question), question)
        return self._roots[question]

    def _solved(self, polynomial: PolyElement, question: Question) -> tuple[Any, ...] | None:
        if not polynomial:
            return None
        degree = polynomial.degree(self._index)
        if degree > 1:
            raise ValueError(
                f"a decision has degree {degree} in {self.name}: "
                f"{sympy.factor(to_sympy(polynomial))}; give the other parameters values (.at)"
            )
        slope, rest = self._coefficients(polynomial)
        if not slope:
            self._keep_sign(rest)
            return ()
        self._keep_sign(slope)
        expr = -self._field.field_new(rest) / self._field.field_new(slope)
        return (Threshold(self._at_sample(expr), expr),)

    def _coefficients(self, polynomial: PolyElement) -> tuple[PolyElement, PolyElement]:
        """Slope and rest of a polynomial of degree at most one in the axis' parameter."""
        parts = [self._others.zero, self._others.zero]
        for exponents, coefficient in polynomial.terms():
            others = exponents[: self._index] + exponents[self._index + 1 :]
            parts[exponents[self._index]] += self._others.from_dict({others: coefficient})
        return parts[1], parts[0]

    def _keep_sign(self, polynomial: PolyElement) -> None:
        """Record that a polynomial in the other parameters must keep the sign of the sample."""
        if is_constant(polynomial):
            return
        if not evaluate(polynomial, self.sample, None):
            raise ResampleError
        self._conditions[polynomial.primitive()[1]] = None

    def _at_sample(self, expr: Any) -> Number:
        return evaluate(expr.numer, self.sample, None) / evaluate(expr.denom, self.sample, None)

    def _substituted(self, polynomial: PolyElement, place: Threshold) -> Any:
        """A polynomial at a place, as an element of the field of the other parameters."""
        powers = [self._others.zero] * (self.degree(polynomial) + 1)
        for exponents, coefficient in polynomial.terms():
            others = exponents[: self._index] + exponents[self._index + 1 :]
            powers[exponents[self._index]] += self._others.from_dict({others: coefficient})
        value = self._field.zero
        for power in reversed(powers):  # Horner's rule
            value = value * place.expr + self._field.field_new(power)
        return value

    def value(self, fraction: Fraction_, place: Threshold) -> Hashable:
        top, bottom = (self._substituted(number, place) for number in fraction)
        return INFINITE if not bottom else top / bottom

    def order(self, first: Fraction_, second: Fraction_, place: Threshold) -> int:
        values = [self._at_sample(self.value(f, place)) for f in (first, second)]
        return sign(values[0] - values[1])

    def to_sympy(self, place: Threshold) -> sympy.Expr:
        return sympy.factor(place.expr.as_expr())

    def number(self, fraction: Fraction_, place: Threshold) -> float:
        values = {**self.sample, self.name: place.value}
        top, bottom = (evaluate(number, values, None) for number in fraction)
        return float(top / bottom)

    def value_to_sympy(self, value: Any, place: Any) -> sympy.Expr:
        return sympy.factor(value.as_expr())

    def spread(self, low: Any, high: Any, n: int) -> list[Threshold]:
        step = (high.value - low.value) / (n + 1)
        return [self.place(low.value + step * i) for i in range(1, n + 1)]

    def closing(self, places: Sequence[Threshold]) -> tuple[sympy.Basic, ...]:
        """Where the order of the given places, from left to right, persists."""
        thresholds = {p for roots in self._roots.values() for p in roots or ()}
        low, high = places[0], places[-1]
        inner = sorted({*places, *(p for p in thresholds if low < p < high)})
        pairs = [*zip(inner, inner[1:], strict=False)]
        pairs += [(p, low) for p in thresholds if p < low] + [
            (high, p) for p in thresholds if high < p
        ]
        for left, right in pairs:
            difference = right.expr - left.expr
            self._keep_sign(difference.numer)
            self._keep_sign(difference.denom)
        return _simplified(tuple(self._conditions), self.model, self.name, self.sample)


def _simplified(
    polynomials: Sequence[PolyElement], model: Model, axis: str, sample: dict[str, Number]
) -> tuple[sympy.Basic, ...]:
    """Conditions on the other parameters, as inequalities around their sample."""
    others = {str(s): s for s in model.ring.symbols if str(s) != axis}
    own = [c for c in model.region.constraints if axis not in map(str, _used(c.polynomial))]
    if len(others) == 1:
        ((name, symbol),) = others.items()
        roots = {
            x
            for p in [*(_only(c.polynomial, name) for c in own), *(_dense(p) for p in polynomials)]
            for x in real_roots(p)
        }
        below = max((x for x in roots if x < sample[name]), default=None)
        above = min((x for x in roots if x > sample[name]), default=None)
        bounds = [] if below is None else [symbol > _root_to_sympy(below)]
        return (*bounds, *([] if above is None else [symbol < _root_to_sympy(above)]))
    signed = []
    for polynomial in polynomials:
        for factor, _ in polynomial.factor_list()[1]:
            positive = evaluate(factor, sample, None) > 0
            signed.append(Constraint(factor if positive else -factor, True))
    relations = [c.relation() for c in [*own, *signed]]
    return tuple(dict.fromkeys(relations))


def _root_to_sympy(root: Any) -> sympy.Expr:
    return root.to_sympy() if isinstance(root, RealRoot) else QQ.to_sympy(root)


def _used(polynomial: PolyElement) -> set[sympy.Symbol]:
    return {s for s, d in zip(polynomial.ring.symbols, polynomial.degrees(), strict=True) if d > 0}


def _only(polynomial: PolyElement, name: str) -> Dense:
    values = {str(s): QQ.zero for s in polynomial.ring.symbols if str(s) != name}
    symbol = next(s for s in polynomial.ring.symbols if str(s) == name)
    return _dense(evaluate(polynomial, values, polynomial_ring([symbol])))


def _dense(number: Number) -> Dense:
    """Coefficients of a polynomial in one parameter, highest power first."""
    if not isinstance(number, PolyElement):
        return trimmed((number,))
    terms = dict(number.terms())
    degree = max((exponent for (exponent,) in terms), default=-1)
    return tuple(terms.get((i,), QQ.zero) for i in range(degree, -1, -1))


def _at(number: PolyElement, value: Number) -> Number:
    """A polynomial in one parameter at a rational value."""
    total = QQ.zero
    for (exponent,), coefficient in number.items():
        total += coefficient * value**exponent
    return total


# --- The study of one place, and the cells --------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Iterate:
    """What one iterate shows at a place: its cylinders and what lies on the diagonal."""

    cylinders: tuple[Cylinder, ...]
    places: tuple[Place, ...]  # of the fixed point of each cylinder
    crossings: tuple[Crossing, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Study:
    """All iterates at one place, and the judge who decided them."""

    judge: Judge
    iterates: dict[int, Iterate]


@dataclass(frozen=True, slots=True, eq=False)
class Cell:
    """An open interval of the parameter, or an edge (then both ends are the same)."""

    lower: Any
    upper: Any
    study: Study

    @property
    def is_edge(self) -> bool:
        """Whether it is a single value of the parameter."""
        return self.lower is not None and self.lower is self.upper


def studied(judge: Judge, chain: tuple[int, ...], orders: Iterable[int]) -> Study:
    """Iterates of the given orders, with every sign that their fixed points depend on."""
    wanted = set(orders)
    current, iterates = WHOLE_LINE, {}
    for order in range(1, max(wanted) + 1):
        for layout in chain:
            current = refined(current, layout, judge)
        if order in wanted:
            places = tuple(place_of_fixed_point(cylinder, judge) for cylinder in current)
            for i, place in enumerate(places):
                is_stable(current, i, place, judge)
            iterates[order] = Iterate(current, places, tuple(crossings(current, judge)))
    return Study(judge, iterates)


def decomposed(
    axis: Axis, chain: tuple[int, ...], orders: Sequence[int], low: Any, high: Any
) -> list[Cell]:
    """Cells and edges of an open interval of the axis, from left to right.

    Parameters
    ----------
    low, high
        Places on the axis, or None for an infinite end; the ends themselves are not studied.
    """
    open_cells: list[Cell] = []
    waiting = [(low, high)]
    while waiting:
        left, right = waiting.pop()
        sample = axis.between(left, right)
        study = studied(axis.judge(sample), chain, orders)
        edge = _edge_at(axis, study.judge, sample)
        if edge is not None:  # the sample is no inner point of a cell
            waiting += [(left, edge), (edge, right)]
            continue
        roots = {root for question in study.judge.answers for root in axis.roots(question) or ()}
        start = max((x for x in roots if x < sample and (left is None or left < x)), default=left)
        stop = min((x for x in roots if sample < x and (right is None or x < right)), default=right)
        open_cells.append(Cell(start, stop, study))
        if start is not left:
            waiting.append((left, start))
        if stop is not right:
            waiting.append((stop, right))
    open_cells.sort(key=lambda cell: axis.between(cell.lower, cell.upper))
    cells: list[Cell] = []
    for cell in open_cells:
        if cells:
            edge = cells[-1].upper
            cells.append(Cell(edge, edge, _studied_edge(axis, edge, chain, orders)))
        cells.append(cell)
    return cells


def _studied_edge(axis: Axis, edge: Any, chain: tuple[int, ...], orders: Sequence[int]) -> Study:
    study = studied(axis.judge(edge), chain, orders)
    found = _edge_at(axis, study.judge, edge)
    if found is not None and not _identical(found, edge):
        raise ResampleError
    return study


def _edge_at(axis: Axis, judge: Judge, place: Any) -> Any:
    """The root that a place hits, if an answer is zero there but not everywhere."""
    found = None
    for question, answer in judge.answers.items():
        roots = axis.roots(question) if answer == 0 else None
        if roots is None:
            continue
        hit = next((root for root in roots if root == place), None)
        if hit is None or (found is not None and not _identical(found, hit)):
            raise ResampleError
        found = hit
    return found


def _identical(first: Any, second: Any) -> bool:
    """Whether two equal places stay equal for other values of the symbolic parameters."""
    return not isinstance(first, Threshold) or bool(first.expr == second.expr)


def merged(cells: Sequence[Cell]) -> list[Cell]:
    """Drop the edges at which nothing changes."""
    kept: list[Cell] = []
    for cell in cells:
        if (
            len(kept) >= 2
            and kept[-1].is_edge
            and kept[-2].study.iterates == kept[-1].study.iterates == cell.study.iterates
        ):
            kept[-2:] = [Cell(kept[-2].lower, cell.upper, kept[-2].study)]
        else:
            kept.append(cell)
    return kept


def axis_of(model: Model, name: str, sample: dict[str, Number] | None = None) -> Axis:
    """The axis of a parameter; the others, if any, stay symbolic."""
    if len(model.ring.symbols) == 1:
        return RationalAxis(model)
    return SymbolicAxis(model, name, sample)


# --- What a user sees -----------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ParameterCell:
    """An interval of the parameter, or an edge, on which the same words describe the map.

    Attributes
    ----------
    lower, upper
        Exact ends, equal for an edge; they do not belong to an open cell.
    map
        The map with its decisions made for this cell: its ``iterate(j).pieces``,
        ``fixed_points()`` and ``jump_crossings()`` are formulas in the parameters.
    """

    lower: sympy.Expr
    upper: sympy.Expr
    map: PiecewiseLinearMap

    @property
    def is_edge(self) -> bool:
        """Whether it is a single value of the parameter."""
        return bool(self.lower == self.upper)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ParameterCells:
    """All cells of an interval of one parameter, from left to right, open cells and edges in turn.

    Attributes
    ----------
    given
        Under which conditions on the other parameters this list holds.
    """

    parameter: sympy.Symbol
    orders: tuple[int, ...]
    cells: tuple[ParameterCell, ...]
    given: tuple[sympy.Basic, ...]

    @property
    def edges(self) -> tuple[sympy.Expr, ...]:
        """The exact values of the parameter at which something changes."""
        return tuple(cell.lower for cell in self.cells if cell.is_edge)

    def __iter__(self) -> Iterator[ParameterCell]:
        """The cells from left to right."""
        return iter(self.cells)

    def __len__(self) -> int:
        return len(self.cells)


def parameter_cells(
    map_: PiecewiseLinearMap,
    parameter: object,
    orders: Iterable[int] = (1,),
    span: tuple[object, object] | None = None,
    sample: Mapping[object, object] | None = None,
) -> ParameterCells:
    """Cut a parameter into cells on which the iterates keep their words, and their edges.

    Parameters
    ----------
    map_
        The map; its other parameters have values or stay symbolic.
    parameter
        Symbol or name.
    orders
        The iterates to look at.
    span
        Two rationals, or None for the whole line.
    sample
        Values of the symbolic parameters around which the list is to hold; by default one that
        the map's assumptions admit.

    Returns
    -------
    ParameterCells
        Edges at which nothing changes are left out.

    Raises
    ------
    ValueError
        If the parameter is unknown, or with other parameters symbolic a decision is not of degree
        one in it.
    """
    orders = checked_orders(orders)
    low, high = (None, None) if span is None else checked_span(map_, parameter, span)
    axis, cells = cut_up(map_, parameter, orders, low, high, sample)
    symbol = next(s for s in map_.parameters if str(s) == axis.name)
    orbits = axis.orbits
    shown = []
    for cell in merged(cells):
        lower = -sympy.oo if cell.lower is None else axis.to_sympy(cell.lower)
        upper = sympy.oo if cell.upper is None else axis.to_sympy(cell.upper)
        decided = PiecewiseLinearMap.decided(map_, cell.study.judge, orbits)
        shown.append(ParameterCell(lower=lower, upper=upper, map=decided))
    return ParameterCells(parameter=symbol, orders=orders, cells=tuple(shown), given=axis.given)


def cut_up(
    map_: PiecewiseLinearMap,
    parameter: object,
    orders: Sequence[int],
    low: Number | None,
    high: Number | None,
    sample: Mapping[object, object] | None,
) -> tuple[Axis, list[Cell]]:
    """The axis of a parameter and its cells, at the first sample that is generic."""
    name = str(parameter)
    names = [str(s) for s in map_.parameters]
    if name not in names:
        raise ValueError(f"{name} is no parameter of this map, it has {names or 'none'}")
    for values in _samples(map_, name, sample):
        axis = axis_of(map_.model, name, values)
        ends = [None if end is None else axis.place(end) for end in (low, high)]
        try:
            cells = decomposed(axis, map_.chain, orders, *ends)
            places = [*ends[:1], *(c.lower for c in cells if c.is_edge), *ends[1:]]
            axis.given = axis.closing([place for place in places if place is not None])
        except ResampleError:
            continue
        return axis, cells
    raise ValueError(f"no generic sample of {names} was found under {map_.given or 'nothing'}")


def _samples(
    map_: PiecewiseLinearMap, name: str, sample: Mapping[object, object] | None
) -> Iterator[dict[str, Number]]:
    """Values for the parameters besides one, a few, to be tried in turn."""
    others = {str(s) for s in map_.parameters} - {name}
    if sample is not None:
        values = {str(key): rational(value) for key, value in sample.items()}
        if set(values) != others:
            raise ValueError(f"a sample must give values to {sorted(others)}, got {sorted(values)}")
        broken = map_.model.region.contains(values)
        if broken is not None:
            raise ValueError(f"the sample {dict(sample)} contradicts the assumption {broken}")
        yield values
        return
    seen: list[dict[str, Number]] = []
    for values in islice(map_.model.region.samples(), 200):
        values.pop(name)
        if values not in seen:
            seen.append(values)
            yield values


def checked_orders(orders: Iterable[int]) -> tuple[int, ...]:
    """Orders of iterates, sorted; ValueError if there is none or one is not at least 1."""
    wanted = tuple(sorted(set(orders)))
    if not wanted or not all(isinstance(order, int) and order >= 1 for order in wanted):
        raise ValueError(f"orders must be integers j >= 1, got {wanted}")
    return wanted


def checked_span(
    map_: PiecewiseLinearMap, parameter: object, span: tuple[object, object]
) -> tuple[Number, Number]:
    """The ends of a span as rationals; ValueError if they are no interval, or contradict."""
    low, high = (rational(end) for end in span)
    if not low < high:
        raise ValueError(f"a span must be an interval (low, high), got ({span[0]}, {span[1]})")
    middle = {str(parameter): (low + high) / 2}
    for value in ({str(parameter): low}, {str(parameter): high}, middle):
        broken = map_.model.region.contains(value)
        if broken is not None and not (
            value != middle and broken.strict and not _at_value(broken.polynomial, value)
        ):
            shown = QQ.to_sympy(value[str(parameter)])
            raise ValueError(f"{parameter} = {shown} in the span contradicts {broken}")
    return low, high


def _at_value(polynomial: PolyElement, value: dict[str, Number]) -> Number:
    return evaluate(polynomial, value, None)
