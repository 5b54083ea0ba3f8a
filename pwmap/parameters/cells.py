"""Parameter cells: where along a parameter the same words describe the iterates of a map.

A map is studied at an exact sample. The nearest roots of the polynomials whose signs were used
bound a cell, in which words, fixed points and crossings are the same. The next sample is taken
beyond it. Edges are cells of their own, studied exactly at the root.

Symbolic parameters take the values of a sample. With one of them a place is a root of a polynomial
in two parameters; with several, polynomials must be of degree one in the parameter of the axis. The
order of all roots is recorded: the results hold where it persists.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

import sympy
from sympy import QQ

from pwmap.algebra.arguments import explained, is_several, shortened, shown
from pwmap.algebra.arithmetic import rational
from pwmap.algebra.exact import HIGHEST, LOWEST, Infinite, Number
from pwmap.algebra.terms import checked_parameter, own_name
from pwmap.algebra.texts import printable
from pwmap.diagrams.shown import counted
from pwmap.maps.budget import BUDGET, Budget, BudgetError, Meter, checked_size, metered
from pwmap.maps.cylinders import WHOLE_LINE, Ask, Cylinder, StudiedIterate, iterate_of, refined
from pwmap.maps.decided import shown_values
from pwmap.maps.piecewise_linear import PiecewiseLinearMap, check_map, checked_order
from pwmap.maps.words import SignOracle
from pwmap.parameters.admitted import Admitted, Span, admitted_intervals, samples
from pwmap.parameters.axis import Axis, ResampleError, identical
from pwmap.parameters.persistence import Answers


@printable
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ParameterCell:
    """An open interval of the parameter, or an edge, from :func:`pwmap.parameter_cells`.

    The exact ends ``lower`` and ``upper`` are equal for an edge. For the orders of the cells,
    ``map`` gives ``iterate(j).pieces``, ``fixed_points()`` and ``jump_crossings()`` as formulas in
    the parameters. It gives other answers if they hold throughout the cell, and otherwise raises
    :class:`UndecidedError`.
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
    """Admitted cells from :func:`pwmap.parameter_cells`, from left to right, open ones and edges.

    ``given`` are conditions on the other parameters.
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
        return iter(self.cells)

    def __len__(self) -> int:
        return len(self.cells)

    def __repr__(self) -> str:
        edges = shortened(", ".join(map(str, self.edges)) or "none", 160)
        orders = ", ".join(map(str, self.orders))
        return (
            f"ParameterCells({self.parameter}, orders {orders}: {counted(len(self), 'cell')}, "
            f"edges {edges})"
        )


Result = TypeVar("Result")

# --- The study of one place, and the cells --------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Cell:
    """An open interval of the parameter, or an edge (then both ends are the same)."""

    lower: Any
    upper: Any
    sample: Any  # the place at which it was studied
    oracle: SignOracle  # with the signs decided there
    iterates: dict[int, StudiedIterate] = field(default_factory=dict)
    cylinders: tuple[Cylinder, ...] = WHOLE_LINE  # of the last iterate

    @property
    def is_edge(self) -> bool:
        """Whether it is a single value of the parameter."""
        return self.lower is self.upper

    @property
    def is_excluded(self) -> bool:
        """Whether the assumptions exclude it, so that nothing was studied there."""
        return not self.cylinders


def grown(
    cell: Cell,
    chain: tuple[int, ...],
    order: int,
    *,
    shown: bool,
    meter: Meter,
    ask: Ask,
) -> Cell:
    """The cell with the next order; with fixed points and crossings if the order is shown."""
    current, iterates = cell.cylinders, cell.iterates
    for layout in chain:
        current = refined(current, layout, cell.oracle, meter, ask)
    if shown:
        iterates = {**iterates, order: iterate_of(current, ask)}
    return replace(cell, iterates=iterates, cylinders=current)


# An order, the cells and edges for orders up to it from left to right, the pieces made so far
CellStage = tuple[int, list[Cell], int]


def stages(
    axis: Axis,
    chain: tuple[int, ...],
    orders: Sequence[int],
    cells: list[Cell],
    meter: Meter,
) -> Iterator[CellStage]:
    """Cut cells into cells and edges, order by order.

    Lower orders are the same in all parts of a cell; answers of a new order are kept from one place
    to the next (:mod:`pwmap.parameters.persistence`). BudgetError if there are too many pieces.
    """
    pieces = 0

    def grow(cell: Cell, ask: Ask) -> Cell:
        nonlocal pieces
        more = grown(cell, chain, order, shown=order in orders, meter=meter, ask=ask)
        pieces += len(more.cylinders)
        if pieces > meter.budget.pieces:
            raise BudgetError(
                f"order {order} takes more than {meter.budget.pieces} pieces in all cells"
            )
        return more

    for order in range(1, max(orders) + 1):
        answers = Answers(axis, cells[0].lower, cells[-1].upper)
        cells = [part for cell in cells for part in _parts(axis, cell, answers, grow)]
        yield order, cells, pieces


def _parts(
    axis: Axis, cell: Cell, answers: Answers, grow: Callable[[Cell, Ask], Cell]
) -> list[Cell]:
    """The cells, and edges between them, into which the next order cuts a cell."""
    if cell.is_excluded:
        return [cell]

    def studied(place: Any) -> Cell:
        oracle = cell.oracle if place is cell.sample else axis.oracle(place)
        oracle = SignOracle(oracle.orbits, oracle.sign_of)
        oracle.signs.update(cell.oracle.signs)
        answers.move(place, oracle)
        here = replace(cell, lower=place, upper=place, sample=place, oracle=oracle)
        found = grow(here, answers.ask)
        answers.tell(oracle)
        return found

    def edge_at(place: Any) -> Cell:
        found = studied(place)
        root = _edge_at(axis, place, answers)
        if root is not None and not identical(root, place):
            raise ResampleError
        return found

    if cell.is_edge:
        return [edge_at(cell.sample)]
    opened: list[Cell] = []
    waiting = [(cell.lower, cell.upper)]
    while waiting:
        left, right = waiting.pop()
        sample = cell.sample if left < cell.sample < right else axis.between(left, right)
        found = studied(sample)
        edge = _edge_at(axis, sample, answers)
        if edge is not None:  # the sample lies on an edge: try on both sides of it
            waiting += [(left, edge), (edge, right)]
            continue
        answers.keep()
        start, stop = answers.nearest(left, right)
        opened.append(replace(found, lower=start, upper=stop))
        if start is not left:
            waiting.append((left, start))
        if stop is not right:
            waiting.append((stop, right))
    opened.sort(key=lambda part: part.sample)
    parts = opened[:1]
    for part in opened[1:]:
        parts += [edge_at(part.lower), part]
    return parts


def aside(axis: Axis, cells: Sequence[Cell]) -> tuple[Axis, list[Cell]]:
    """Copies of an axis and its cells; what the copies decide is not recorded in the originals."""
    oracles = (SignOracle(c.oracle.orbits, c.oracle.sign_of, c.oracle.signs) for c in cells)
    return axis.copy(), [
        replace(cell, oracle=oracle) for cell, oracle in zip(cells, oracles, strict=True)
    ]


def studied_at(place: Any, axis: Axis, chain: tuple[int, ...], cell: Cell) -> Cell:
    """An edge at a place in or beside a cell, studied for the same orders."""
    found = _unstudied(axis, place, place, place)
    for order in range(1, max(cell.iterates) + 1):
        shown, ask = order in cell.iterates, found.oracle.ask
        found = grown(found, chain, order, shown=shown, meter=Meter(BUDGET), ask=ask)
    return found


def _edge_at(axis: Axis, place: Any, answers: Answers) -> Any:
    """The root at a place if a new decision vanishes there but not identically; else None."""
    found = None
    for decision in answers.zeros():
        roots = axis.roots(decision)
        if roots is None:
            continue
        hit = next((root for root in roots if root == place), None)
        if hit is None or (found is not None and not identical(found, hit)):
            raise ResampleError
        found = hit
    return found


def merged(cells: Sequence[Cell]) -> list[Cell]:
    """Drop the edges at which nothing changes."""
    kept: list[Cell] = []
    for cell in cells:
        if (
            len(kept) >= 2
            and kept[-1].is_edge
            and kept[-2].iterates == kept[-1].iterates == cell.iterates
        ):
            oracle = _agreed(kept[-2], kept[-1], cell)
            kept[-2:] = [replace(kept[-2], upper=cell.upper, oracle=oracle)]
        else:
            kept.append(cell)
    return kept


def _agreed(first: Cell, *others: Cell) -> SignOracle:
    """An oracle with the signs that some cells have in common."""
    shared = {
        decision: sign
        for decision, sign in first.oracle.signs.items()
        if all(other.oracle.signs.get(decision) == sign for other in others)
    }
    return SignOracle(first.oracle.orbits, first.oracle.sign_of, shared)


# --- What a user sees -----------------------------------------------------------------------------


@explained()
def parameter_cells(
    map_: PiecewiseLinearMap,
    parameter: object,
    orders: Iterable[int] = (1,),
    span: tuple[object, object] | None = None,
    sample: Mapping[Any, object] | None = None,
    *,
    budget: Budget | Meter = BUDGET,
) -> ParameterCells:
    """Cut a parameter into cells on which the iterates keep their words, and their edges.

    Parameters
    ----------
    map_, parameter
        The map and the symbol or name of a parameter; others have values or stay symbolic.
    orders, span
        The iterates, and two rationals, or None for the whole line.
    sample
        Values of symbolic parameters around which the cells hold; by default admitted ones.
    budget
        Limits of the computation.

    Returns
    -------
    ParameterCells
        Edges at which nothing changes are left out.

    Raises
    ------
    ValueError
        If the parameter is unknown, or beside several symbolic parameters a decision is not of
        degree one in it; ``BudgetError`` if it takes more than is allowed.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, parameter_cells
    >>> p1 = PiecewiseLinearMap([("r - 2", "x <= 0"), ("r - a*x", "x > 0")], given=["a > 1"])
    >>> parameter_cells(p1, "r", orders=(1, 2, 3)).edges
    (0, 2, 2*a**2/(a**2 - a + 1), 2*a/(a - 1))
    """
    meter = metered(budget)
    orders = checked_orders(orders, meter.budget)
    return with_stages(
        from_all_orders(lambda axis, cells: shown_cells(map_, orders, axis, cells)),
        map_,
        parameter,
        orders,
        (LOWEST, HIGHEST) if span is None else checked_span(span),
        sample,
        meter=meter,
    )


def shown_cells(
    map_: PiecewiseLinearMap, orders: tuple[int, ...], axis: Axis, cells: Sequence[Cell]
) -> ParameterCells:
    """Cells as a user sees them, without edges at which nothing changes."""
    shown = []
    for cell in merged(cells):
        if cell.is_excluded:
            continue
        lower, upper = axis.to_sympy(cell.lower), axis.to_sympy(cell.upper)
        scope = axis.scope(cell.lower, cell.upper, orders)
        within = PiecewiseLinearMap.of(
            map_.definition,
            map_.chain,
            scope,
            SignOracle(axis.orbits, scope.sign, cell.oracle.signs),
            {map_.chain * order: shown for order, shown in cell.iterates.items()},
        )
        shown.append(ParameterCell(lower=lower, upper=upper, map=within))
    symbol = next(s for s in map_.parameters if str(s) == axis.name)
    return ParameterCells(parameter=symbol, orders=orders, cells=tuple(shown), given=axis.given)


def from_all_orders(
    build: Callable[[Axis, list[Cell]], Result],
) -> Callable[[Axis, Iterator[CellStage]], Result]:
    """Adapt ``build``, which takes the cells for all orders, to :func:`with_stages`."""

    def built(axis: Axis, found: Iterator[CellStage]) -> Result:
        _, cells, _ = deque(found, maxlen=1).pop()
        close(axis, cells)
        return build(axis, cells)

    return built


def with_stages(
    build: Callable[[Axis, Iterator[CellStage]], Result],
    map_: PiecewiseLinearMap,
    parameter: object,
    orders: Sequence[int],
    span: Span,
    sample: Mapping[Any, object] | None,
    *,
    meter: Meter,
    with_ends: bool = False,
) -> Result:
    """Build a result from cells that are cut order by order, at the first generic sample.

    ``with_ends`` makes edges of the ends that belong to admitted intervals. ``build`` must call
    :func:`close`.
    """
    check_map(map_)
    name = checked_parameter(parameter, map_.parameters)
    checked_size(max(orders), len(map_.chain), meter.budget)
    tried: list[Mapping[str, Number]] = []
    for values in samples(map_, name, span, sample):
        tried.append(values)
        axis = Axis(map_.definition, name, values)
        try:
            found = admitted_intervals(axis, span)
            cells = uncut(axis, found, with_ends)
            return build(axis, stages(axis, map_.chain, orders, cells, meter))
        except ResampleError:
            continue
    only = {key: value for key, value in tried[-1].items() if {t[key] for t in tried} == {value}}
    if only and len(tried) > 1:  # no accident: the assumptions leave no other values
        raise ResampleError(
            f"over this span the assumptions leave only {shown_values(only)}, where edges meet: "
            "give that value (.at), or take another span"
        )
    raise ResampleError(
        f"at {shown_values(tried[-1])} edges meet by chance: choose another sample (sample=..., "
        "on the command line --sample)"
    )


def uncut(axis: Axis, admitted: Sequence[Admitted], with_ends: bool) -> list[Cell]:
    """One cell for each part of a span that the assumptions admit, and for the gaps between."""
    cells: list[Cell] = []
    for low, high, low_closed, high_closed in admitted:
        found = [_unstudied(axis, low, high, axis.between(low, high))]
        if with_ends and low_closed:
            found.insert(0, _unstudied(axis, low, low, low))
        if with_ends and high_closed:
            found.append(_unstudied(axis, high, high, high))
        cells += [*(_gap(cells[-1], found[0]) if cells else ()), *found]
    return cells


def _unstudied(axis: Axis, low: Any, high: Any, sample: Any) -> Cell:
    return Cell(low, high, sample, axis.oracle(sample))


def _gap(before: Cell, after: Cell) -> list[Cell]:
    """The excluded cells between two cells: an open one, and edges that these do not have."""
    left, right = before.upper, after.lower
    gap = [(left, left), (left, right), (right, right)]
    gap = gap[before.is_edge : 3 - after.is_edge] if left != right else gap[:1]
    return [Cell(low, high, low, before.oracle, {}, ()) for low, high in gap]


def close(axis: Axis, cells: Sequence[Cell]) -> None:
    """Record in the axis the order of all ends of cells, and what was decided at edges."""
    places = [cells[0].lower, *(c.lower for c in cells if c.is_edge), cells[-1].upper]
    decided = (d for cell in cells if cell.is_edge for d in cell.oracle.signs)
    axis.closing([place for place in places if not isinstance(place, Infinite)], decided)


def checked_orders(orders: Iterable[int], budget: Budget = BUDGET) -> tuple[int, ...]:
    """Orders of iterates, sorted; ValueError if there is none or one is not at least 1."""
    listed: set[int] = set()
    for given in orders if is_several(orders) else (orders,):
        order = checked_order(given)
        listed.add(order)
        checked_size(order, 1, budget)  # at once: the orders may be an endless iterable
    if not listed:
        raise ValueError("orders must name at least one iterate, got none")
    return tuple(sorted(listed))


def with_divisors(orders: Iterable[int]) -> tuple[int, ...]:
    """Orders and their divisors: a jump may end at a cycle of smaller period."""
    return tuple(sorted({d for n in orders for d in range(1, n + 1) if n % d == 0}))


def checked_span(span: tuple[object, object], name: str = "a span") -> tuple[Number, Number]:
    """The ends of a span as rationals; ValueError if they are no interval."""
    if not isinstance(span, Sequence) or not is_several(span) or len(span) != 2:
        raise ValueError(f"{name} must be an interval (low, high), got {shown(span)}")
    if any(end is None or end in (sympy.oo, -sympy.oo) for end in span):
        raise ValueError(f"{name} needs two rational ends, or none at all, got {span}")
    low, high = (rational(end) for end in span)
    if not low < high:
        ends = ", ".join(shown(QQ.to_sympy(end)) for end in (low, high))
        raise ValueError(f"{name} must be an interval (low, high), got ({ends})")
    return low, high


def check_parameters(map_: PiecewiseLinearMap, what: str, *wanted: str) -> None:
    """ValueError unless a map has just the ``wanted`` parameters, named in words by ``what``."""
    names = [str(symbol) for symbol in map_.parameters]
    if {*names} != {*wanted}:
        others = ", ".join(name for name in names if name not in wanted)
        rest = f": {others} must be set to a value" if {*wanted} <= {*names} else ""
        raise ValueError(f"expected a map of {what}, this one has {names or 'no parameters'}{rest}")


def span_of_only(
    map_: PiecewiseLinearMap, parameter: object, span: tuple[object, object]
) -> tuple[Number, Number]:
    """The ends of a span of a map's only parameter; ValueError if it has others, or is an iterate.

    ValueError, too, if the assumptions exclude a part of the span.
    """
    name = str(own_name(parameter, map_.parameters))
    check_parameters(map_, f"{name} alone", name)
    if map_.order > 1:
        raise ValueError(f"expected the map itself, got an iterate of order {map_.order}")
    ends = checked_span(span)
    admitted_intervals(Axis(map_.definition, name, {}), ends)
    return ends
