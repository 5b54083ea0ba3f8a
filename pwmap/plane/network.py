"""Two parameters cut into strips, with the curves and points that follow from these.

In a strip every mark is an arc from one end to the other, the root of a polynomial. Arcs meet at
the ends of strips; upright arcs lie at a single value of the parameter across. Where exactly two
arcs of one polynomial and event meet they are one curve; other nodes are of codimension two.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise

from sympy import QQ
from sympy.polys.rings import PolyElement

from pwmap.algebra.arguments import explained
from pwmap.algebra.rootfunctions import minimal_polynomial
from pwmap.algebra.roots import Real, RealRoot, integers, real_to_sympy, sign_at, simplest_between
from pwmap.diagrams.data import PointKind
from pwmap.maps.budget import BUDGET, INTERRUPTED, Budget, BudgetError, Meter, metered
from pwmap.maps.piecewise_linear import PiecewiseLinearMap, check_map
from pwmap.parameters.axis import Axis, ResampleError
from pwmap.parameters.cells import (
    Cell,
    checked_orders,
    checked_span,
    from_all_orders,
    merged,
    shown_cells,
    with_divisors,
    with_stages,
)
from pwmap.parameters.segments import ends_of_line, traced
from pwmap.plane.curves import CodimensionTwo, Node, PlaneArc, PlaneCurve, curve_of
from pwmap.plane.kinds import PlaneKind
from pwmap.plane.plane import ParameterPlane, checked_axes
from pwmap.plane.strips import PlaneEvent, Strip, marks


@explained()
def parameter_plane(
    map_: PiecewiseLinearMap,
    across: object,
    along: object,
    across_span: tuple[object, object],
    along_span: tuple[object, object],
    orders: Iterable[int] = (1, 2),
    *,
    budget: Budget | Meter = BUDGET,
) -> ParameterPlane:
    """Cut a rectangle of two parameters into cells, exactly, and name the curves between them.

    Parameters
    ----------
    map_, across, along, across_span, along_span
        A map with just two parameters, their symbols or names, and two rationals for each.
    orders
        The iterates to study, to which those of all divisors are added.
    budget
        Limits of the pieces of one strip, and of the work of all. The rectangle is cut off at the
        first strip that is not finished.

    Returns
    -------
    ParameterPlane
        Strips of cells, the curves on which cycles bifurcate, and the points in which curves meet.

    Raises
    ------
    ValueError
        If the map has other parameters. A ``BudgetError`` if the leftmost strip is not finished.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, parameter_plane
    >>> skew = PiecewiseLinearMap.from_sympy("Piecewise((a*x + 1, x <= 0), (b*x + 1, True))")
    >>> plane = parameter_plane(skew, "a", "b", ("1/4", "3/4"), (-5, "-1/2"))
    >>> [(curve.id, curve.words, str(curve.polynomial)) for curve in plane.curves]
    [('PD1', ('LR',), 'a*b + 1'), ('PD2', ('R',), 'b + 1')]
    >>> region, = plane.regions(period=2)
    >>> region.across, region.along
    ((1/4, 3/4), (-1/a, -1))
    >>> print(*plane.at("1/2", "-3/2").attractors)
    cycle LR through -2/7
    """
    check_map(map_)
    axes, meter = checked_axes(map_, across, along), metered(budget)
    orders = with_divisors(checked_orders(orders, meter.budget))
    plane = ParameterPlane(
        map=map_,
        across=axes[0],
        along=axes[1],
        across_span=checked_span(across_span),
        along_span=checked_span(along_span),
        strips=(),
        curves=(),
        points=(),
    )
    strips = _strips(plane, orders, meter)
    if meter.left_out:
        if not strips:
            raise KeyboardInterrupt if meter.stopped == INTERRUPTED else BudgetError(meter.stopped)
        end = strips[-1].column.high
        left_out = f"stopped at {plane.across} = {real_to_sympy(end)}: {meter.stopped}"
        plane = replace(plane, across_span=(plane.across_span[0], end), left_out=left_out)
    plane = replace(plane, strips=tuple(strips))
    curves, points = network(plane)
    return replace(plane, curves=curves, points=points)


# --- Strips ---------------------------------------------------------------------------------------


def _strips(plane: ParameterPlane, orders: tuple[int, ...], meter: Meter) -> list[Strip]:
    """The strips from left to right, up to the first one that the budget does not reach."""
    found, across = list[Strip](), str(plane.across)
    waiting: list[tuple[Real, Real]] = [plane.across_span]
    built = from_all_orders(partial(_built, plane.map, orders))
    with meter.keeping(waiting):
        while waiting:
            meter.advance("strips", len(found))
            left, right = waiting[-1]
            sample = simplest_between(left, right)
            broken = plane.map.definition.region.contains({across: sample})
            if broken is not None:
                value = f"{across} = {real_to_sympy(sample)}"
                raise ValueError(f"{value} in the span contradicts the assumption {broken}")
            try:
                strip = with_stages(
                    built, plane.map, plane.along, orders, plane.along_span, {across: sample},
                    with_ends=True, meter=meter,
                )  # fmt: skip
            except ResampleError:  # edges meet at the sample: it lies between two strips
                waiting[-1:] = [(sample, right), (left, sample)]
                continue
            start, stop = max(left, strip.column.low), min(right, strip.column.high)
            found.append(replace(strip, column=replace(strip.column, low=start, high=stop)))
            waiting[-1:] = [(a, b) for a, b in ((stop, right), (left, start)) if a is not b]
    if waiting:
        end = waiting[-1][0]
        found = [strip for strip in found if not end < strip.column.high]
    found.sort(key=lambda strip: strip.column.sample)
    if found and isinstance(found[-1].column.high, RealRoot):  # a rectangle has rational ends
        column = found[-1].column
        end = simplest_between(column.sample, column.high)
        found[-1] = replace(found[-1], column=replace(column, high=end))
    return found


def _built(
    map_: PiecewiseLinearMap, orders: tuple[int, ...], axis: Axis, cells: list[Cell]
) -> Strip:
    inner = cells[1 if cells[0].is_edge else 0 : -1 if cells[-1].is_edge else None]
    kept = merged(inner)
    return Strip(
        cells=shown_cells(map_, orders, axis, kept),
        column=axis.column,
        borders=(kept[0].lower, *(cell.upper for cell in kept if not cell.is_edge)),
        marks=tuple(marks(map_, axis, cells)),
        upright=tuple(map(integers, axis.upright)),
    )


# --- Curves and points ----------------------------------------------------------------------------

Tip = tuple[PlaneArc, int]  # one end of an arc: 0 or 1
NodeTips = dict[tuple[PlaneEvent, PolyElement], list[Tip]]  # at a node, by their curves


def network(plane: ParameterPlane) -> tuple[tuple[PlaneCurve, ...], tuple[CodimensionTwo, ...]]:
    """The curves of the strips of a plane, and the points in which they meet."""
    arcs = list(_arcs(plane))
    nodes: dict[Node, NodeTips] = defaultdict(lambda: defaultdict(list))
    for arc in arcs:
        for which, node in enumerate(arc.ends):
            nodes[node][arc.event, arc.polynomial].append((arc, which))
    following: dict[Tip, Tip] = {}
    for met in nodes.values():
        for tips in met.values():
            if len(tips) == 2:
                following.update(zip(tips, tips[::-1], strict=True))
    lines = list(traced(arcs, following))
    names = dict[PlaneArc, str]()
    counts = Counter[str]()
    for line in lines:
        kind = line[0][0].event.kind
        counts[kind] += 1
        names.update((arc, f"{kind}{counts[kind]}") for arc, _ in line)
    points = tuple(_points(plane, nodes, names))
    at = {point.node: point.id for point in points}
    curves = tuple(
        curve_of(names[line[0][0]], [arc for arc, _ in line], _ends(line, following, at))
        for line in lines
    )
    return curves, points


def _arcs(plane: ParameterPlane) -> Iterator[PlaneArc]:
    """All arcs: those of strips from left to right, then upright ones."""
    heights: dict[Real, set[Real]] = defaultdict(lambda: {*plane.along_span})
    for strip in plane.strips:
        column = strip.column
        for root, event in strip.marks:
            ends = [(end, column.limit(root, end)) for end in (column.low, column.high)]
            for across, along in ends:
                heights[across].add(along)
            yield PlaneArc(event, root.factor, (ends[0], ends[1]), column, root)
    for left, right in pairwise(plane.strips):
        end = left.column.high
        if any(not sign_at(tuple(map(QQ, p)), end) for p in (*left.upright, *right.upright)):
            beside = left.column.sample, right.column.sample
            yield from _upright(plane, end, sorted(heights[end]), beside)


def _upright(
    plane: ParameterPlane, across: Real, heights: Sequence[Real], beside: tuple[Real, Real]
) -> Iterator[PlaneArc]:
    """The arcs along one value of the parameter across, between the ends of other arcs."""
    index, orders = plane.map.parameters.index(plane.across), plane.strips[0].cells.orders
    polynomial = minimal_polynomial(plane.map.definition.ring, index, across)
    span = simplest_between(beside[0], across), simplest_between(across, beside[1])
    for low, high in pairwise(heights):
        map_ = plane.map.at({plane.along: QQ.to_sympy(simplest_between(low, high))})
        found = with_stages(
            from_all_orders(partial(marks, map_)), map_, plane.across, orders, span, None,
            with_ends=True, meter=Meter(BUDGET),
        )  # fmt: skip
        for place, event in found:
            if place == across:
                yield PlaneArc(event, polynomial, ((across, low), (across, high)))


def _points(
    plane: ParameterPlane, nodes: Mapping[Node, NodeTips], names: Mapping[PlaneArc, str]
) -> Iterator[CodimensionTwo]:
    """The nodes inside the rectangle in which several curves meet, or one ends."""
    counts = Counter[str]()
    for node in sorted(nodes):
        met = nodes[node]
        inside = node[0] not in plane.across_span and node[1] not in plane.along_span
        passes = all(len(tips) == 2 for tips in met.values())
        if not inside or (passes and len({polynomial for _, polynomial in met}) == 1):
            continue
        kind = _kind(met, passes)
        counts[kind] += 1
        yield CodimensionTwo(
            id=f"{kind}{counts[kind]}",
            kind=kind,
            node=node,
            curves=tuple(dict.fromkeys(names[arc] for tips in met.values() for arc, _ in tips)),
        )


def _kind(met: NodeTips, passes: bool) -> PlaneKind:
    words = [word for event, _ in met for word in event.words]
    kinds = {event.kind for event, _ in met}
    if passes and len(set(words)) == len(words):
        return PlaneKind.CROSSING
    if PointKind.PD in kinds:
        return PlaneKind.FLIP_BORDER
    return PlaneKind.FOLD_BORDER if PointKind.LP in kinds else PlaneKind.TWO_BORDERS


def _ends(
    line: Sequence[Tip], following: Mapping[Tip, Tip], at: Mapping[Node, str]
) -> tuple[str, str]:
    first, last = (
        "" if (arc, which) in following else at.get(arc.ends[which], "")
        for arc, which in ends_of_line(line)
    )
    return first, last
