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
from functools import partial
from itertools import islice, pairwise
from typing import Any, TypeVar

import sympy
from sympy import QQ

from pwmap.axis import Axis, ResampleError, axis_of, identical
from pwmap.cylinders import (
    WHOLE_LINE,
    Cylinder,
    Iterate,
    Place,
    crossings,
    is_stable,
    place_of_fixed_point,
    refined,
)
from pwmap.exact import Number, rational
from pwmap.itineraries import Judge, Mark
from pwmap.maps import PiecewiseLinearMap, checked_order

Result = TypeVar("Result")

# --- The study of one place, and the cells --------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Study:
    """All iterates at one place, and the judge who decided them.

    Attributes
    ----------
    cylinders
        Of the last iterate that was composed.
    """

    judge: Judge
    iterates: dict[int, Iterate]
    cylinders: tuple[Cylinder, ...] = WHOLE_LINE

    def shown(self) -> dict[int, Iterate]:
        """The iterates, without telling apart fixed points that are virtual or missing."""
        return {
            order: replace(
                it, places=tuple(Place.VIRTUAL if p is Place.NONE else p for p in it.places)
            )
            for order, it in self.iterates.items()
        }

    def agreed(self, *others: Study) -> Study:
        """What this study and others that show the same have in common."""
        shared = set(self.judge.answers.items())
        for other in others:
            shared &= set(other.judge.answers.items())
        judge = Judge(self.judge.orbits, self.judge.sign, dict(shared))
        return Study(judge, self.shown())


@dataclass(frozen=True, slots=True, eq=False)
class Cell:
    """An open interval of the parameter, or an edge (then both ends are the same)."""

    lower: Any
    upper: Any
    study: Study
    sample: Any  # the place of the study

    @property
    def is_edge(self) -> bool:
        """Whether it is a single value of the parameter."""
        return self.lower is not None and self.lower is self.upper


def grown(study: Study, chain: tuple[int, ...], order: int, *, shown: bool) -> Study:
    """A study of one order more, with every sign that its fixed points depend on if it is shown."""
    judge, current, iterates = study.judge, study.cylinders, study.iterates
    for layout in chain:
        current = refined(current, layout, judge)
    if shown:
        places = tuple(place_of_fixed_point(cylinder, judge) for cylinder in current)
        stable = tuple(is_stable(current, i, place, judge) for i, place in enumerate(places))
        found = Iterate(current, places, stable, tuple(crossings(current, judge)))
        iterates = {**iterates, order: found}
    return Study(judge, iterates, current)


def decomposed(
    axis: Axis,
    chain: tuple[int, ...],
    orders: Sequence[int],
    low: Any,
    high: Any,
    ends: Sequence[Any] = (),
) -> list[Cell]:
    """Cells and edges of an open interval of the axis, from left to right.

    They are refined order by order. What a cell knows of lower orders holds in all its parts and
    on the edges between them, so that only the questions of the new order are asked there.

    Parameters
    ----------
    low, high
        Places on the axis, or None for an infinite end.
    ends
        The ends to study as edges too, of ``low`` and ``high``.
    """
    sample = axis.between(low, high)
    cells = [Cell(low, high, Study(axis.judge(sample), {}), sample)]
    for end, i in ((low, 0), (high, 2)):
        if end in ends:
            cells.insert(i, Cell(end, end, Study(axis.judge(end), {}), end))
    for order in range(1, max(orders) + 1):
        grow = partial(grown, chain=chain, order=order, shown=order in orders)
        cells = [part for cell in cells for part in _parts(axis, cell, grow)]
    return cells


def _parts(axis: Axis, cell: Cell, grow: Callable[[Study], Study]) -> list[Cell]:
    """A cell, or what an order more cuts it into: cells and the edges between them."""
    mark = cell.study.judge.mark()
    if cell.is_edge:
        return [_edge(axis, cell.sample, grow(cell.study), mark)]

    def study_at(place: Any) -> Study:
        judge = axis.judge(place)
        judge.learn(cell.study.judge, mark)
        return grow(replace(cell.study, judge=judge))

    opened: list[Cell] = []
    waiting = [(cell.lower, cell.upper)]
    while waiting:
        left, right = waiting.pop()
        old = (left is None or left < cell.sample) and (right is None or cell.sample < right)
        sample = cell.sample if old else axis.between(left, right)
        study = grow(cell.study) if old else study_at(sample)
        new = islice(study.judge.answers.items(), mark.answers, None)
        edge = _edge_at(axis, study.judge, sample, mark)
        if edge is not None:  # the sample is no inner point of a cell
            waiting += [(left, edge), (edge, right)]
            continue
        roots = {root for question, _ in new for root in axis.roots(question) or ()}
        start = max((x for x in roots if x < sample and (left is None or left < x)), default=left)
        stop = min((x for x in roots if sample < x and (right is None or x < right)), default=right)
        opened.append(Cell(start, stop, study, sample))
        if start is not left:
            waiting.append((left, start))
        if stop is not right:
            waiting.append((stop, right))
    opened.sort(key=lambda part: part.sample)
    parts = opened[:1]
    for part in opened[1:]:
        parts += [_edge(axis, part.lower, study_at(part.lower), mark), part]
    return parts


def studied_at(place: Any, axis: Axis, chain: tuple[int, ...], cell: Cell) -> Cell:
    """An edge at some place in or beside a cell, with the same iterates."""
    study = Study(axis.judge(place), {})
    for order in range(1, max(cell.study.iterates) + 1):
        study = grown(study, chain, order, shown=order in cell.study.iterates)
    return Cell(place, place, study, place)


def _edge(axis: Axis, place: Any, study: Study, mark: Mark) -> Cell:
    found = _edge_at(axis, study.judge, place, mark)
    if found is not None and not identical(found, place):
        raise ResampleError
    return Cell(place, place, study, place)


def _edge_at(axis: Axis, judge: Judge, place: Any, mark: Mark) -> Any:
    """The root that a place hits, if a new answer is zero there but not everywhere."""
    found = None
    for question, answer in islice(judge.answers.items(), mark.answers, None):
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
            study = kept[-2].study.agreed(kept[-1].study, cell.study)
            kept[-2:] = [replace(kept[-2], upper=cell.upper, study=study)]
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
        ``fixed_points()`` and ``jump_crossings()`` are formulas in the parameters, for the orders
        the cells were cut for. What else is asked of it is answered if that holds throughout the
        cell; if it does not, or that is not proved, :class:`UndecidedError` names the orders.
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
        lower = -sympy.oo if cell.lower is None else axis.to_sympy(cell.lower)
        upper = sympy.oo if cell.upper is None else axis.to_sympy(cell.upper)
        scope = axis.scope(cell.lower, cell.upper, orders)
        decided = PiecewiseLinearMap.decided(
            map_,
            scope,
            axis.orbits,
            Judge(axis.orbits, scope.sign, cell.study.judge.answers),
            {map_.chain * order: shown for order, shown in cell.study.iterates.items()},
        )
        shown.append(ParameterCell(lower=lower, upper=upper, map=decided))
    symbol = next(s for s in map_.parameters if str(s) == axis.name)
    return ParameterCells(parameter=symbol, orders=orders, cells=tuple(shown), given=axis.given)


def with_cells(
    build: Callable[[Axis, list[Cell]], Result],
    map_: PiecewiseLinearMap,
    parameter: object,
    orders: Sequence[int],
    span: tuple[Number | None, Number | None],
    sample: Mapping[Any, object] | None,
    *,
    with_ends: bool = False,
) -> Result:
    """Build something from the cells of a parameter, at the first sample that is generic.

    With ``with_ends`` the ends of the span are edges too, if the assumptions admit them.
    """
    if not isinstance(map_, PiecewiseLinearMap):
        raise TypeError(f"expected a PiecewiseLinearMap (see its from_sympy), got {map_!r}")
    name = str(parameter)
    names = [str(s) for s in map_.parameters]
    if name not in names:
        raise ValueError(f"{name} is no parameter of this map, it has {names or 'none'}")
    for values in _samples(map_, name, sample):
        start = values.pop(name)
        axis = axis_of(map_.model, name, values)
        try:
            ends = _limited(axis, *span, start)
            studied_ends = [end for end in ends if with_ends and admitted(axis, end)]
            cells = decomposed(axis, map_.chain, orders, *ends, studied_ends)
            places = [ends[0], *(c.lower for c in cells if c.is_edge), ends[1]]
            axis.closing([place for place in places if place is not None])
            return build(axis, cells)
        except ResampleError:
            continue
    others = ", ".join(f"{key} = {QQ.to_sympy(value)}" for key, value in axis.sample.items())
    raise ResampleError(f"at {others} edges meet by chance: choose another sample")


def admitted(axis: Axis, place: Any) -> bool:
    """Whether the assumptions hold at an end of a span."""
    return place is not None and all(
        constraint.holds(axis.sign(constraint.polynomial, place))
        for constraint in axis.model.region.constraints
    )


def _limited(axis: Axis, low: Number | None, high: Number | None, start: Number) -> tuple[Any, Any]:
    """The ends of a span as places; where there is none, as far as the assumptions reach.

    Raises
    ------
    ValueError
        If a part of the span contradicts an assumption.
    """
    ends = [None if end is None else axis.place(end) for end in (low, high)]
    inner = axis.place(start)
    for constraint in axis.model.region.constraints:
        if not axis.degree(constraint.polynomial):
            continue
        zeros = sorted(axis.zeros(constraint.polynomial) or ())
        if ends[0] is None or ends[1] is None:
            below = [x for x in (*zeros, ends[0]) if x is not None and x < inner]
            above = [x for x in (*zeros, ends[1]) if x is not None and x > inner]
            ends = [max(below, default=None), min(above, default=None)]
            continue
        stops = [ends[0], *(x for x in zeros if ends[0] < x < ends[1]), ends[1]]
        for left, right in pairwise(stops):
            witness = axis.between(left, right)
            if not constraint.holds(axis.sign(constraint.polynomial, witness)):
                shown = f"{axis.name} = {axis.to_sympy(witness)}"
                raise ValueError(f"{shown} in the span contradicts the assumption {constraint}")
    return ends[0], ends[1]


def _samples(
    map_: PiecewiseLinearMap, name: str, sample: Mapping[Any, object] | None
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
        yield from (
            {**found, **values} for found in islice(map_.at(values).model.region.samples(), 1)
        )
        return
    seen: list[dict[str, Number]] = []
    for values in islice(map_.model.region.samples(), 200):
        rest = {key: value for key, value in values.items() if key != name}
        if rest not in seen:
            seen.append(rest)
            yield values


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
