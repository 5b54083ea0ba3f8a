"""The exact bifurcation diagram of a piecewise-linear map over one parameter.

Runs become branches, and where their ends meet there is a special point. What kind it is follows
from which branches meet there, and on which side.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from math import inf, nan
from typing import Any

import numpy as np
import sympy
from sympy import QQ

from pwmap.axis import Axis
from pwmap.cells import Cell, checked_orders, checked_span, with_cells
from pwmap.diagram import Branch, BranchKind, Diagram, PointKind, SpecialPoint
from pwmap.exact import Number, fraction_to_sympy, quotient_to_sympy
from pwmap.maps import PiecewiseLinearMap
from pwmap.roots import bounds
from pwmap.runs import ALONG, LEFT, RIGHT, End, Meeting, Run, Sweep

SAMPLES = 65  # along a branch that is curved


def bifurcation_diagram(
    map_: PiecewiseLinearMap,
    parameter: object,
    span: tuple[object, object] | None = None,
    orders: Iterable[int] = (1, 2),
    sample: Mapping[Any, object] | None = None,
) -> Diagram:
    """All branches and special points of some iterates over a parameter, exactly.

    Parameters
    ----------
    map_
        The map; its other parameters have values, or stay symbolic.
    parameter
        Symbol or name of the parameter.
    span
        Two rationals; by default from about one below the first value at which something happens
        to about one above the last. What exists at an end of the span only is left out.
    orders
        The iterates j. A periodic point is listed with its minimal period only, a jump crossing
        with every order it occurs in. Where an iterate is the identity over an interval of the
        parameter, those ends of the band that belong to it are listed.
    sample
        Values for symbolic parameters, at which the floats of the diagram are taken and around
        which its formulas hold; by default values that the map's assumptions admit.

    Returns
    -------
    Diagram
        The exact values are sympy objects: ``exact`` of a branch holds ``x``, ``multiplier`` (or
        the limits ``left`` and ``right`` of a jump) and ``interval``, the values of the parameter
        at which it exists; that of a point holds ``parameter`` and ``x``. ``given`` says for which
        values of symbolic parameters all of it holds.

    Raises
    ------
    ValueError, TypeError
        As :func:`pwmap.parameter_cells`.
    """
    orders = checked_orders(orders)
    if span is None:
        low, high = _whole_span(map_, parameter, orders, sample)
    else:
        low, high = checked_span(span)
    unit = len(map_.chain)
    return with_cells(
        lambda axis, cells: _assembled(
            map_, Sweep(axis, cells, unit, (cells[0].lower, cells[-1].upper))
        ),
        map_,
        parameter,
        orders,
        (low, high),
        sample,
        with_ends=True,
    )


def _whole_span(
    map_: PiecewiseLinearMap,
    parameter: object,
    orders: Sequence[int],
    sample: Mapping[Any, object] | None,
) -> tuple[Number, Number]:
    return with_cells(_outermost, map_, parameter, orders, (None, None), sample)


def _outermost(axis: Axis, cells: Sequence[Cell]) -> tuple[Number, Number]:
    edges = [cell.lower for cell in cells if cell.is_edge]
    edges = edges or [axis.between(cells[0].lower, cells[0].upper)]
    below, above = bounds(_number(edges[0]))[0], bounds(_number(edges[-1]))[1]
    low, high = QQ(math.floor(below) - 1), QQ(math.ceil(above) + 1)
    first, last = cells[0].lower, cells[-1].upper  # as far as the assumptions reach
    if first is not None and axis.place(low) < first:
        low = _number(axis.between(first, edges[0]))
    if last is not None and axis.place(high) > last:
        high = _number(axis.between(edges[-1], last))
    return low, high


def _number(place: Any) -> Any:
    """A place at the sample of symbolic parameters."""
    return getattr(place, "value", place)


def _assembled(map_: PiecewiseLinearMap, sweep: Sweep) -> Diagram:
    """Name runs and meetings, and tell them of each other."""
    runs = sweep.runs()
    counts: dict[str, int] = defaultdict(int)
    branch_ids: dict[Run, str] = {}
    for run in runs:
        letter = "F" if run.name.kind is BranchKind.FIXED_POINT else "J"
        counts[letter] += 1
        branch_ids[run] = f"{letter}{counts[letter]}"
    points: list[SpecialPoint] = []
    ends: dict[tuple[Run, int], str] = {}
    for meeting in sweep.meetings(runs):
        kind, note = classify(meeting, at_span_end=meeting.place in sweep.span)
        counts[kind] += 1
        point = _point(sweep, meeting, f"{kind}{counts[kind]}", kind, note, branch_ids)
        points.append(point)
        ends.update({(end.run, end.which): point.id for end in meeting.ends})
    branches = [
        _branch(map_, sweep, run, branch_ids[run], (ends[run, 0], ends[run, 1])) for run in runs
    ]
    return Diagram(
        parameter_name=sweep.axis.name,
        x_name=str(map_.x),
        branches=tuple(branches),
        points=tuple(points),
        given=tuple(str(relation) for relation in sweep.axis.given),
    )


def _point(
    sweep: Sweep,
    meeting: Meeting,
    point_id: str,
    kind: PointKind,
    note: str,
    branch_ids: Mapping[Run, str],
) -> SpecialPoint:
    axis, place = sweep.axis, meeting.place
    infinite = abs(meeting.x) == inf
    x = sympy.oo * meeting.x if infinite else axis.value_to_sympy(meeting.value, place)
    return SpecialPoint(
        id=point_id,
        kind=kind,
        parameter=axis.number(axis.identity, place),
        x=meeting.x,
        branches=tuple(dict.fromkeys(branch_ids[end.run] for end in meeting.ends)),
        order=lowest(meeting.ends) // sweep.unit,
        note=note,
        exact={"parameter": axis.to_sympy(place), "x": x},
    )


def _branch(
    map_: PiecewiseLinearMap, sweep: Sweep, run: Run, branch_id: str, ends: tuple[str, str]
) -> Branch:
    name, axis, orbits = run.name, sweep.axis, sweep.orbits
    low, high = (axis.to_sympy(place) for place in run.places)
    exact: dict[str, sympy.Basic] = {
        "interval": sympy.Interval(low, high, not run.closed[0], not run.closed[1])
    }
    if run.band is None:
        exact["x"] = fraction_to_sympy(name.x(orbits))
    else:
        exact["interval"] = sympy.FiniteSet(low)
    if name.kind is BranchKind.JUMP and name.cut is not None:
        for side, word in zip(("left", "right"), name.words, strict=True):
            exact[side] = quotient_to_sympy(orbits.value(name.cut.k, word[name.cut.steps :]))
    else:
        slope = quotient_to_sympy(orbits.slope(name.word))
        exact["multiplier"] = sympy.nan if _isolated(run) else slope
    parameter, x, multiplier = zip(*_samples(sweep, run), strict=True)
    return Branch(
        id=branch_id,
        kind=name.kind,
        order=len(name.word) // sweep.unit,
        word="|".join(map_.spelled(word) for word in name.words),
        parameter=np.array(parameter),
        x=np.array(x),
        multiplier=np.array(multiplier),
        ends=ends,
        exact=exact,
        attracts=None if run.shows is None else run.shows.stable,
    )


def _isolated(run: Run) -> bool:
    return run.shows is not None and run.shows.isolated


def _samples(sweep: Sweep, run: Run) -> list[tuple[float, float, float]]:
    """Parameter, x and multiplier along a run; few samples where that is enough."""
    axis, slope = sweep.axis, sweep.orbits.slope(run.name.word)
    smooth = run.name.kind is BranchKind.FIXED_POINT and not _isolated(run)

    def sample(place: Any, x: float) -> tuple[float, float, float]:
        multiplier = axis.number(slope, place) if smooth and sweep.is_finite(slope, place) else nan
        return axis.number(axis.identity, place), x, multiplier

    first, last = (sample(end.place, sweep.x(end)) for end in sweep.ends(run))
    if run.band is not None:
        return [first, last]
    if run.places[0] == run.places[1]:
        return [first]
    position = run.name.x(sweep.orbits)
    degrees = [axis.degree(number) for number in (*position, *slope)]
    if degrees[0] <= 1 and not any(degrees[1:]):
        return [first, last]
    inner = axis.spread(*run.places, SAMPLES - 2)
    return [first, *(sample(place, axis.number(position, place)) for place in inner), last]


# --- What kind of point ---------------------------------------------------------------------------


def lowest(ends: Sequence[End]) -> int:
    """Word length of the fixed points that meet, or of the jumps if only jumps do."""
    fixed = [end.steps for end in ends if end.is_fixed]
    return min(fixed or [end.steps for end in ends])


def classify(meeting: Meeting, *, at_span_end: bool) -> tuple[PointKind, str]:
    """Kind of a special point, and a note, from the branches that meet there.

    With n the lowest order of the fixed points that meet, look at all branches of that order. If
    one passes with the same word on both sides, its multiplier is +1 (LP) or -1 (PD), or the other
    side of the border it lies on changes. Otherwise fixed points meet a border (BC): the branches
    lie on both sides of the parameter (persistence) or on one (fold).

    A fold of one branch of fixed points into a jump branch starts a jump branch of order 2n too,
    and then is a fold-flip (FF), just if the multiplier m has |m| > 1: let F be the distance of the
    limit on the fixed point's side from the diagonal and D that on the other side, of opposite sign
    where the jump crosses. The preimage of the jump lies at -F/m from it, there P_2n jumps between
    F and D, and F - (-F/m) = F (1 + 1/m) has the sign of F.
    """
    ends = meeting.ends
    if at_span_end:
        return PointKind.EP, "end of the span"
    if abs(meeting.x) == inf:
        escapes = any(end.unit == 1 for end in ends)
        return PointKind.LP if escapes else PointKind.EP, "x grows without bound"
    own = [end for end in ends if end.steps == lowest(ends)]
    fixed = [end for end in own if end.is_fixed and end.run.band is None]
    bands = [end for end in ends if end.run.band is not None]
    if not any(end.is_fixed for end in own):
        return PointKind.WC, "jumps only"
    passing = {e.run.name for e in fixed if e.side == LEFT} & {
        e.run.name for e in fixed if e.side == RIGHT
    }
    units = {end.unit for end in fixed if end.run.name in passing}
    if -1 in units:
        doubled = any(band.steps == 2 * own[0].steps for band in bands)
        return PointKind.PD, "degenerate: points nearby have twice the period" if doubled else ""
    if 1 in units or not fixed:
        return PointKind.LP, "degenerate: an interval of fixed points"
    sides = {end.side for end in own} - {ALONG}
    if len(sides) != 1:
        note = "stability changes at the border" if passing else "persistence"
        return PointKind.BC, note if sides else "isolated"
    flips = len(fixed) == 1 and any(not end.is_fixed for end in own) and fixed[0].is_steep
    return (PointKind.FF if flips else PointKind.BC), "fold"
