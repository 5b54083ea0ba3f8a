"""The exact bifurcation diagram of a piecewise-linear map over one parameter.

Curves of segments become branches. The junctions of their ends become special points, whose kind
follows from the branches that meet there and the sides on which they lie.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import count, islice, pairwise
from typing import Any

import sympy
from sympy import QQ

from pwmap.algebra.arguments import check_functions, explained
from pwmap.algebra.assumptions import UndecidedError
from pwmap.algebra.exact import HIGHEST, LOWEST, Infinite, fraction_to_sympy, quotient_to_sympy
from pwmap.algebra.roots import ceiling, whole_part
from pwmap.diagrams.data import (
    DOUBLED,
    INTERVAL,
    Branch,
    BranchKind,
    PointKind,
    SpecialPoint,
    Stretch,
)
from pwmap.diagrams.diagram import ASSUMED, FILLED, Diagram
from pwmap.diagrams.record import program
from pwmap.diagrams.shown import listed
from pwmap.maps.budget import BUDGET, INTERRUPTED, Budget, Meter, Progress, Report, metered
from pwmap.maps.piecewise_linear import PiecewiseLinearMap
from pwmap.maps.words import Word
from pwmap.parameters.admitted import Span
from pwmap.parameters.axis import Axis, ResampleError
from pwmap.parameters.branches import Continuation, curve_arrays, remembered
from pwmap.parameters.cells import (
    Cell,
    CellStage,
    aside,
    checked_orders,
    checked_span,
    close,
    studied_at,
    with_divisors,
    with_stages,
)
from pwmap.parameters.segments import (
    ALONG,
    LEFT,
    RIGHT,
    BranchKey,
    Junction,
    Known,
    Segment,
    SegmentCurve,
    SegmentEnd,
    Tip,
    connected,
    ends_of_line,
)


@explained()
def bifurcation_diagram(
    map_: PiecewiseLinearMap,
    parameter: object,
    span: tuple[object, object] | None = None,
    orders: Iterable[int] = (1, 2),
    sample: Mapping[Any, object] | None = None,
    *,
    budget: Budget | Meter = BUDGET,
    progress: Report | None = None,
    on_interrupt: Callable[[], None] | None = None,
    finished: Callable[[Diagram], None] | None = None,
) -> Diagram:
    """All branches and special points of some iterates over a parameter, exactly.

    Parameters
    ----------
    map_, parameter
        The map and the symbol or name of a parameter; others have values or stay symbolic.
    span
        Two rationals; by default all values at which something happens, and about one more on each
        side. Branches that exist at an end of the span only are left out.
    orders
        The iterates. A periodic point is listed with its minimal period only, a jump crossing with
        every order, a band (where an iterate is the identity) by the ends that belong to it, and
        its order in :attr:`Diagram.filled`.
    sample
        Values of symbolic parameters, at which floats are taken and around which the formulas
        hold; by default values that the assumptions admit.
    budget
        Limits; orders beyond them are left out, and ``given`` says so.
    progress, finished
        Called with every completed order, and with the diagram up to it.
    on_interrupt
        Called at Ctrl-C; the completed orders are then returned.

    Returns
    -------
    Diagram
        ``exact`` of a branch holds sympy expressions: ``x``, ``multiplier`` (of a jump its limits
        ``left`` and ``right``) and ``interval``, the values of the parameter at which it exists. A
        jump that changes its word has them for each stretch of ``words``; a band along one value
        has ``lower`` and ``upper`` instead of ``x``. ``exact`` of a point holds ``parameter`` and
        ``x``. ``given`` says for which values of symbolic parameters the diagram holds.

    Raises
    ------
    ValueError, TypeError
        As :func:`pwmap.parameter_cells`; ``BudgetError`` if no order was completed.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, bifurcation_diagram
    >>> lines = PiecewiseLinearMap.from_sympy("Piecewise((p + x/2, x <= 0), (p - 1 + x/3, True))")
    >>> for branch in bifurcation_diagram(lines, "p", (-1, 2), orders=(1,)).branches:
    ...     print(branch.id, branch.kind, branch.exact["x"], branch.exact["interval"])
    F1 fixed-point 2*p Interval(-1, 0)
    J1 jump 0 Interval.open(0, 1)
    F2 fixed-point 3*p/2 - 3/2 Interval.Lopen(1, 2)
    """
    meter = metered(budget, on_interrupt)
    check_functions(progress=progress, finished=finished)
    orders = checked_orders(orders, meter.budget)
    limits = (LOWEST, HIGHEST) if span is None else checked_span(span)
    is_asked = finished is not None or meter.budget.on_interrupt is not None
    finished = finished or (lambda _: None)

    def upto(order: int, axis: Axis, cells: list[Cell], known: Known) -> Diagram | None:
        """The diagram up to an order; None if it is not the last and nobody waits for it."""
        if order == orders[-1]:
            diagram = _built(map_, orders, limits, axis, cells, known)
            finished(diagram)
            return diagram
        if not is_asked:
            return None
        try:
            diagram = _built(map_, orders, limits, *aside(axis, cells), known)
        except ResampleError:  # the next order may still be built at this sample
            return None
        finished(_said(diagram, [n for n in orders if n <= order], INTERRUPTED))
        return diagram

    def growing(axis: Axis, found: Iterator[CellStage]) -> Diagram:
        """The diagram of all orders, or of those that were completed."""
        known, cells = Known(dict), list[Cell]()
        done: dict[int, Diagram | None] = {}  # the diagram up to each order asked for
        with meter.keeping(done):
            meter.advance("orders", 0, len(orders))
            for order, cells, pieces in found:
                if order in orders:
                    done[order] = upto(order, axis, cells, known)
                meter.advance("orders", len(done), len(orders))
                if progress is not None:
                    progress(Progress(order, len(cells), pieces))
        diagram = done[max(done)] or _built(map_, orders, limits, axis, cells, known)
        return diagram if len(done) == len(orders) else _said(diagram, done, meter.stopped)

    wanted = with_divisors(orders)
    return with_stages(
        growing, map_, parameter, wanted, limits, sample, with_ends=True, meter=meter
    )


def _built(
    map_: PiecewiseLinearMap,
    orders: tuple[int, ...],
    limits: Span,
    axis: Axis,
    cells: list[Cell],
    known: Known,
) -> Diagram:
    """The diagram from cells; conditions on other parameters are recorded in the axis."""
    close(axis, cells)
    low, high = limits
    if isinstance(low, Infinite):
        ends = _outermost(axis, cells)
        cells = _cut_off(axis, map_.chain, cells, ends)
        close(axis, cells)
    else:
        ends = axis.place(low), axis.place(high)
    known = known if not axis.sample else Known(dict)
    return _assembled(Continuation(map_, axis, cells, ends, known), orders)


def _said(diagram: Diagram, done: Iterable[int], reason: str) -> Diagram:
    """A diagram with a sentence on the orders that it has, and why it stopped there."""
    sentence = f"stopped after orders {_listed([*done])}: {reason}"
    return replace(diagram, given=(*diagram.given, sentence))


def _listed(orders: Sequence[int]) -> str:
    """Orders as text, such as 1..7 or 2, 4, 8."""
    if len(orders) > 1 and orders[-1] - orders[0] == len(orders) - 1:
        return f"{orders[0]}..{orders[-1]}"
    return ", ".join(map(str, orders))


def _outermost(axis: Axis, cells: Sequence[Cell]) -> tuple[Any, Any]:
    """Places about one below the first edge and one above the last."""
    edges = [cell.lower for cell in cells if cell.is_edge]
    edges = edges or [axis.between(cells[0].lower, cells[-1].upper)]
    low, high = whole_part(axis.real(edges[0])) - 1, ceiling(axis.real(edges[-1])) + 1
    return axis.place(QQ(low)), axis.place(QQ(high))


def _cut_off(
    axis: Axis, chain: tuple[int, ...], cells: Sequence[Cell], span: tuple[Any, Any]
) -> list[Cell]:
    """Cut the outer cells at the ends of a span, unless the assumptions end before."""
    (low, high), kept = span, list(cells)
    if kept[0].lower < low:
        kept[:1] = [studied_at(low, axis, chain, kept[0]), replace(kept[0], lower=low)]
    if high < kept[-1].upper:
        kept[-1:] = [replace(kept[-1], upper=high), studied_at(high, axis, chain, kept[-1])]
    return kept


def _assembled(continuation: Continuation, orders: Sequence[int]) -> Diagram:
    """Assemble a diagram of some orders: name its branches and classify its special points."""
    map_ = continuation.map
    segments = continuation.segments()
    curves, junctions = connected(segments, continuation.junctions(segments), continuation.stops)
    counts = defaultdict[str, Iterator[int]](lambda: count(1))  # F1, F2, ..., J1, ..., BC1, ...
    branch_ids: dict[Tip, str] = {}  # by both tips of each branch
    shown = [curve for curve in curves if _length(curve) // continuation.length in orders]
    for curve in shown:
        letter = "F" if curve[0][0].key.kind is BranchKind.FIXED_POINT else "J"
        branch_ids.update(dict.fromkeys(ends_of_line(curve), f"{letter}{next(counts[letter])}"))
    points: dict[Tip, SpecialPoint] = {}
    for junction in junctions:
        tips = [tip for end in junction.ends if (tip := (end.segment, end.which)) in branch_ids]
        if not tips:
            continue
        kind, note = classify(junction, at_span_end=junction.place in continuation.stops)
        if junction.place in continuation.stops and junction.place not in continuation.span:
            note = "end of what is assumed"
        names = tuple(dict.fromkeys(branch_ids[tip] for tip in tips))
        point = _point(continuation, junction, f"{kind}{next(counts[kind])}", kind, note, names)
        points.update(dict.fromkeys(tips, point))
    axis, filled = continuation.axis, [n for n in continuation.filled if n in orders]
    return Diagram(
        parameter_name=axis.name,
        x_name=str(map_.x),
        branches=tuple(_branch(continuation, curve, branch_ids, points) for curve in shown),
        points=tuple({point.id: point for point in points.values()}.values()),
        given=tuple(str(relation) for relation in axis.given),
        sample={name: QQ.to_sympy(value) for name, value in axis.sample.items()},
        about={
            "program": program(),
            "map": _text(map_),
            "orders": [*orders],
            **_assumed(map_, axis),
            **({FILLED: filled} if filled else {}),
        },
    )


def _assumed(map_: PiecewiseLinearMap, axis: Axis) -> dict[str, list[str]]:
    """The assumptions on symbolic parameters as an entry of ``about``, if there are any."""
    # If the diagram holds for all that is assumed, its own conditions state the same.
    if not axis.sample:
        return {}
    own = [each for each in map_.given if axis.name not in map(str, each.free_symbols)]
    return {ASSUMED: [*map(str, axis.given if axis.is_everywhere else own)]}


def _text(map_: PiecewiseLinearMap) -> list[str]:
    """A map, a line for each piece; in one line if the assumptions leave the pieces open."""
    try:
        return str(map_).splitlines() if map_.order == 1 else [repr(map_)]
    except UndecidedError:
        return [repr(map_)]


def _length(curve: SegmentCurve) -> int:
    return len(curve[0][0].key.word)


def _point(
    continuation: Continuation,
    junction: Junction,
    point_id: str,
    kind: PointKind,
    note: str,
    branches: tuple[str, ...],
) -> SpecialPoint:
    axis, place, value = continuation.axis, junction.place, junction.value
    infinite = isinstance(value, Infinite)
    exact_x = value.to_sympy() if infinite else axis.value_to_sympy(value, place)
    parameter, x = continuation.number(junction.ends[0])
    return SpecialPoint(
        id=point_id,
        kind=kind,
        parameter=parameter,
        x=x,
        branches=branches,
        order=lowest(junction.ends) // continuation.length,
        note=note,
        exact={"parameter": axis.to_sympy(place), "x": exact_x},
        cause=_cause(continuation, junction, kind),
    )


def _cause(continuation: Continuation, junction: Junction, kind: PointKind) -> str:
    """A sentence on what happens at a special point; empty if kind and note say it."""
    if kind in (PointKind.LP, PointKind.PD):
        return "" if isinstance(junction.value, Infinite) else kind.meaning.split(": ")[1]
    if kind not in (PointKind.BC, PointKind.FF):
        return ""
    cuts = (end.segment.key.cut for end in junction.ends)
    met = {cut.k for cut in cuts if cut is not None}
    if len(continuation.orbits.table.breaks) == 1:
        met = {0}
    what = "fixed point" if lowest(junction.ends) == continuation.length else "point of a cycle"
    return f"a {what} meets {_borders(continuation, met)}"


def _branch(
    continuation: Continuation,
    curve: SegmentCurve,
    branch_ids: Mapping[Tip, str],
    points: Mapping[Tip, SpecialPoint],
) -> Branch:
    segments = [segment for segment, _ in curve]
    first, (start, end) = segments[0], ends_of_line(curve)
    (parameter, x, multiplier), starts = curve_arrays(continuation, curve)
    pairs = pairwise(segment.key for segment in segments)
    causes = ["", *(_cause_of_change(continuation, *pair) for pair in pairs)]
    # the word of a fixed point, or those on both sides of a jump
    spelled = ["|".join(map(continuation.map.spelled, segment.key.words)) for segment in segments]
    formulas = [_formulas(continuation, segment) for segment in segments]
    words = [*map(Stretch, starts, spelled, causes, formulas)]
    location = first.location
    return Branch(
        id=branch_ids[start],
        kind=first.key.kind,
        order=_length(curve) // continuation.length,
        word=words[0].word,
        parameter=parameter,
        x=x,
        multiplier=multiplier,
        ends=(points[start].id, points[end].id),
        exact=words[0].exact,
        attracts=None if location is None or location.is_inside else location.stable,
        words=tuple(words),
    )


@remembered
def _formulas(continuation: Continuation, segment: Segment) -> dict[str, sympy.Basic]:
    key, axis, orbits = segment.key, continuation.axis, continuation.orbits
    low, high = (axis.to_sympy(place) for place in segment.places)
    exact: dict[str, sympy.Basic] = {"interval": _interval(segment, low, high)}
    if segment.band is None:
        exact["x"] = fraction_to_sympy(continuation.position(key))
    else:
        exact["interval"] = sympy.FiniteSet(low)
        lower, upper = segment.band
        exact["lower"] = -sympy.oo if lower is None else fraction_to_sympy(lower)
        exact["upper"] = sympy.oo if upper is None else fraction_to_sympy(upper)
    if key.kind is BranchKind.JUMP and key.cut is not None:
        for side, word in zip(("left", "right"), key.words, strict=True):
            exact[side] = quotient_to_sympy(orbits.value(key.cut.k, word[key.cut.steps :]))
    else:
        slope = quotient_to_sympy(orbits.slope(key.word))
        exact["multiplier"] = sympy.nan if segment.is_isolated else slope
    return exact


def _cause_of_change(continuation: Continuation, before: BranchKey, after: BranchKey) -> str:
    """A sentence on what happens where a jump changes its word."""
    assert before.cut is not None
    assert after.cut is not None
    if before.words == after.words:
        return "a limit of the jump touches the diagonal"
    if before.cut.steps != after.cut.steps:  # the break that is met has the later preimage
        met = {max(before.cut, after.cut, key=lambda cut: cut.steps).k}
    else:
        met = {
            k
            for words in zip(before.words, after.words, strict=True)
            for k in islice(_between(continuation, *words), 1)
        }
    return f"an orbit of the jump meets {_borders(continuation, met)}"


def _between(continuation: Continuation, one: Word, other: Word) -> Iterator[int]:
    """The breaks between the letters in which two words differ."""
    table, chain = continuation.orbits.table, continuation.map.chain
    for i, letters in enumerate(zip(one, other, strict=True)):
        layout = table.layouts[chain[i % len(chain)]]
        for k, *sides in zip(layout.breaks, layout.slots[:-1:2], layout.slots[2::2], strict=True):
            if letters[0] != letters[1] and {*sides} == {*letters}:
                yield k


def _borders(continuation: Continuation, met: Iterable[int]) -> str:
    values = [quotient_to_sympy(continuation.orbits.value(k, ())) for k in sorted(met)]
    which = listed(f"{continuation.map.x} = {value}" for value in values) if values else ""
    return f"the border{'s' * (len(values) > 1)} {which}" if which else "a border"


def _interval(segment: Segment, low: sympy.Expr, high: sympy.Expr) -> sympy.Set:
    if segment.places[0] == segment.places[1]:
        return sympy.FiniteSet(low) if all(segment.closed) else sympy.EmptySet
    left, right = (sympy.false if closed else sympy.true for closed in segment.closed)
    # sympy.Interval would compare the ends by their digits; they are known to ascend
    return sympy.Basic.__new__(sympy.Interval, low, high, left, right)


# --- What kind of point ---------------------------------------------------------------------------


def lowest(ends: Sequence[SegmentEnd]) -> int:
    """Word length of the fixed points that meet, or of the jumps if only jumps do."""
    fixed = [end.length for end in ends if end.is_fixed]
    return min(fixed or [end.length for end in ends])


def classify(junction: Junction, *, at_span_end: bool) -> tuple[PointKind, str]:
    """Kind of a special point, and a note, from the branches that meet there.

    Let n be the lowest order of the fixed points that meet; branches of that order decide. If one
    passes with the same word on both sides, its multiplier is +1 (LP) or -1 (PD), or it lies on a
    border (BC), where its stability changes or other branches end on it; where the map is
    continuous at this parameter only, it can attract here and on neither side. Otherwise fixed
    points meet a border (BC). Their branches lie on both sides of the parameter (persistence) or on
    one (fold).

    A fold of one branch of fixed points, with multiplier m, into a jump branch is a fold-flip (FF)
    if and only if |m| > 1: then a jump branch of order 2n starts at the preimage of the jump. Let F
    be the distance of the limit on the fixed point's side from the diagonal and D that on the other
    side, of opposite sign where the jump crosses. The preimage lies at -F/m from the jump; there
    P_2n jumps between F and D, and F - (-F/m) = F (1 + 1/m) has the sign of F if and only if
    |m| > 1. A jump branch of order 2n can also start at the jump itself, which is no fold-flip
    (``docs/theory/fold_flip.md``).

    Jumps that meet no fixed point end there (EP), unless they continue each other
    (:mod:`pwmap.parameters.segments`).
    """
    ends = junction.ends
    if at_span_end:
        return PointKind.EP, "end of the parameter span"
    if isinstance(junction.value, Infinite):
        escapes = any(end.unit == 1 for end in ends)
        return PointKind.LP if escapes else PointKind.EP, "x grows without bound"
    own = [end for end in ends if end.length == lowest(ends)]
    fixed = [end for end in own if end.is_fixed and end.segment.band is None]
    bands = [end for end in ends if end.segment.band is not None]
    if not any(end.is_fixed for end in own):
        return PointKind.EP, _of_jumps(ends)
    passing = {e.segment.key for e in fixed if e.side == LEFT} & {
        e.segment.key for e in fixed if e.side == RIGHT
    }
    units = {end.unit for end in fixed if end.segment.key in passing}
    if -1 in units:
        doubled = any(band.length == 2 * own[0].length for band in bands)
        return PointKind.PD, DOUBLED if doubled else ""
    if 1 in units or not fixed:
        return PointKind.LP, INTERVAL
    staying = {end.segment.key for end in fixed if end.segment.closed[end.which]} & passing
    if staying:
        return PointKind.BC, _staying_note(junction, own, staying)
    sides = {end.side for end in own} - {ALONG}
    if len(sides) != 1:
        alone = all(end.side == ALONG for end in fixed)  # on a jump that passes, or by itself
        return PointKind.BC, "isolated" if alone else "persistence"
    folding = [end for end in fixed if end.side != ALONG]  # not a point piece that is met
    flips = len(folding) == 1 and any(not end.is_fixed for end in own) and folding[0].is_steep
    return (PointKind.FF if flips else PointKind.BC), "fold"


def _of_jumps(ends: Sequence[SegmentEnd]) -> str:
    """What happens where only jumps end; a single one ends where a piece is flat."""
    beside = Counter(end.length for end in ends if end.side != ALONG)
    if max(beside.values(), default=0) > 2:
        return "jumps meet"
    return "the branch closes" if 2 in beside.values() else "the jump ends"


def _staying_note(junction: Junction, own: Sequence[SegmentEnd], staying: set[BranchKey]) -> str:
    """What happens to a branch that stays on a border, and what ends on it."""
    stayed = [end.segment for end in own if end.segment.key in staying]
    stable = {segment.location.stable for segment in stayed if segment.location}
    sides = {end.side for end in own if end.segment.key not in staying} - {ALONG}
    notes = ["stability changes at the border"] if len(stable) > 1 else []
    if sides:
        notes.append(f"{'fold' if len(sides) == 1 else 'persistence'} at a branch on the border")
    elif not notes and any(end.segment.band is not None for end in own):
        notes.append("an interval of fixed points ends at a branch on the border")
    elif len(own) < len(junction.ends):
        notes.append("higher orders end at a branch on the border")
    if junction.attracts:
        does = "attracts" if junction.attracts > 0 else "does not attract"
        notes.append(f"{does} at this value{' only' * (junction.attracts > 0)}")
    return ", ".join(notes)
