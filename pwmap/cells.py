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

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import sympy

from pwmap.admitted import Span, samples, shown_sample, stretches
from pwmap.axis import Axis, ResampleError, axis_of, identical
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
from pwmap.exact import Number, rational
from pwmap.itineraries import Judge
from pwmap.maps import PiecewiseLinearMap, checked_order

Result = TypeVar("Result")

# --- The study of one place, and the cells --------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Iterate:
    """What one iterate shows at a place: its cylinders and what lies on the diagonal."""

    cylinders: tuple[Cylinder, ...]
    places: tuple[Place, ...]  # of the fixed point of each cylinder
    stable: tuple[bool, ...]  # whether it attracts
    crossings: tuple[Crossing, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Study:
    """All iterates at one place, and the judge who decided them."""

    judge: Judge
    iterates: dict[int, Iterate]

    def shown(self) -> list[Iterate]:
        """The iterates, without telling apart fixed points that are virtual or missing."""
        return [
            replace(it, places=tuple(Place.VIRTUAL if p is Place.NONE else p for p in it.places))
            for it in self.iterates.values()
        ]


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

    @property
    def is_excluded(self) -> bool:
        """Whether the assumptions exclude it, so that nothing was studied there."""
        return not self.study.iterates


def studied(judge: Judge, chain: tuple[int, ...], orders: Iterable[int]) -> Study:
    """Iterates of the given orders, with every sign that their fixed points depend on."""
    wanted = set(orders)
    current, iterates = WHOLE_LINE, {}
    for order in range(1, max(wanted) + 1):
        for layout in chain:
            current = refined(current, layout, judge)
        if order in wanted:
            places = tuple(place_of_fixed_point(cylinder, judge) for cylinder in current)
            stable = tuple(is_stable(current, i, place, judge) for i, place in enumerate(places))
            iterates[order] = Iterate(current, places, stable, tuple(crossings(current, judge)))
    return Study(judge, iterates)


def decomposed(
    axis: Axis,
    chain: tuple[int, ...],
    orders: Sequence[int],
    low: Any,
    high: Any,
    ends: Sequence[Any] = (),
) -> list[Cell]:
    """Cells and edges of an open interval of the axis, from left to right.

    Parameters
    ----------
    low, high
        Places on the axis, or None for an infinite end.
    ends
        The ends to study as edges too, of ``low`` and ``high``.
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
        if cells or cell.lower in ends:
            cells.append(edge_cell(axis, cell.lower, chain, orders))
        cells.append(cell)
    if cells[-1].upper in ends:
        cells.append(edge_cell(axis, cells[-1].upper, chain, orders))
    return cells


def edge_cell(axis: Axis, place: Any, chain: tuple[int, ...], orders: Sequence[int]) -> Cell:
    """A single value of the parameter as a cell."""
    study = studied(axis.judge(place), chain, orders)
    found = _edge_at(axis, study.judge, place)
    if found is not None and not identical(found, place):
        raise ResampleError
    return Cell(place, place, study)


def _edge_at(axis: Axis, judge: Judge, place: Any) -> Any:
    """The root that a place hits, if an answer is zero there but not everywhere."""
    found = None
    for question, answer in judge.answers.items():
        roots = axis.roots(question) if answer == 0 else None
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
            and kept[-2].study.shown() == kept[-1].study.shown() == cell.study.shown()
        ):
            kept[-2:] = [Cell(kept[-2].lower, cell.upper, kept[-2].study)]
        else:
            kept.append(cell)
    return kept


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

    What the assumptions exclude, inside the interval too, is left out.

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
    sample: Mapping[Any, object] | None = None,
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
    return with_cells(
        lambda axis, cells: shown_cells(map_, orders, axis, cells),
        map_,
        parameter,
        orders,
        (None, None) if span is None else checked_span(span),
        sample,
    )


def shown_cells(
    map_: PiecewiseLinearMap, orders: tuple[int, ...], axis: Axis, cells: Sequence[Cell]
) -> ParameterCells:
    """Cells as a user sees them, without edges at which nothing changes."""
    shown = []
    for cell in merged(cells):
        if cell.is_excluded:
            continue
        lower = -sympy.oo if cell.lower is None else axis.to_sympy(cell.lower)
        upper = sympy.oo if cell.upper is None else axis.to_sympy(cell.upper)
        decided = PiecewiseLinearMap.decided(map_, cell.study.judge, axis.orbits)
        shown.append(ParameterCell(lower=lower, upper=upper, map=decided))
    symbol = next(s for s in map_.parameters if str(s) == axis.name)
    return ParameterCells(parameter=symbol, orders=orders, cells=tuple(shown), given=axis.given)


def with_cells(
    build: Callable[[Axis, list[Cell]], Result],
    map_: PiecewiseLinearMap,
    parameter: object,
    orders: Sequence[int],
    span: Span,
    sample: Mapping[Any, object] | None,
    *,
    with_ends: bool = False,
) -> Result:
    """Build something from the cells of a parameter, at the first sample that is generic.

    With ``with_ends`` the ends of the span, and of what the assumptions admit of it, are edges too
    if they are admitted.
    """
    if not isinstance(map_, PiecewiseLinearMap):
        raise TypeError(f"expected a PiecewiseLinearMap (see its from_sympy), got {map_!r}")
    name = str(parameter)
    names = [str(s) for s in map_.parameters]
    if name not in names:
        raise ValueError(f"{name} is no parameter of this map, it has {names or 'none'}")
    values: Mapping[str, Number] = {}
    for values in samples(map_, name, span, sample):
        axis = axis_of(map_.model, name, values)
        try:
            cells = admitted_cells(axis, map_.chain, orders, span, with_ends=with_ends)
            close(axis, cells)
            return build(axis, cells)
        except ResampleError:
            continue
    raise ResampleError(f"at {shown_sample(values)} edges meet by chance: choose another sample")


def admitted_cells(
    axis: Axis,
    chain: tuple[int, ...],
    orders: Sequence[int],
    span: Span,
    *,
    with_ends: bool = False,
) -> list[Cell]:
    """The cells of all parts of a span that the assumptions admit, and the gaps between them."""
    cells: list[Cell] = []
    for stretch in stretches(axis, span):
        ends = stretch.closed_ends if with_ends else ()
        found = decomposed(axis, chain, orders, stretch.low, stretch.high, ends)
        if cells:
            cells += _gap(cells[-1], found[0])
        cells += found
    return cells


def _gap(before: Cell, after: Cell) -> list[Cell]:
    """Cells without a study, edges and an open cell in turn, between two cells."""
    nothing = Study(before.study.judge, {})
    left, right = before.upper, after.lower
    if left == right:
        return [Cell(left, left, nothing)]
    gap = [Cell(left, right, nothing)]
    first = [] if before.is_edge else [Cell(left, left, nothing)]
    return first + gap + ([] if after.is_edge else [Cell(right, right, nothing)])


def close(axis: Axis, cells: Sequence[Cell]) -> None:
    """Have the axis record the order of all ends of cells."""
    places = [cells[0].lower, *(c.lower for c in cells if c.is_edge), cells[-1].upper]
    axis.closing([place for place in places if place is not None])


def checked_orders(orders: Iterable[int]) -> tuple[int, ...]:
    """Orders of iterates, sorted; ValueError if there is none or one is not at least 1."""
    listed = tuple(orders) if isinstance(orders, Iterable) else (orders,)
    if not listed:
        raise ValueError("orders must name at least one iterate, got none")
    return tuple(sorted({checked_order(order) for order in listed}))


def checked_span(span: tuple[object, object]) -> tuple[Number, Number]:
    """The ends of a span as rationals; ValueError if they are no interval."""
    if not isinstance(span, Sequence) or isinstance(span, str) or len(span) != 2:
        raise ValueError(f"a span must be an interval (low, high), got {span!r}")
    if any(end is None or end in (sympy.oo, -sympy.oo) for end in span):
        raise ValueError(f"a span needs two rational ends, or none at all, got {span}")
    low, high = (rational(end) for end in span)
    if not low < high:
        raise ValueError(f"a span must be an interval (low, high), got ({span[0]}, {span[1]})")
    return low, high
