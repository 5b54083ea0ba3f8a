"""The exact bifurcation diagram of a piecewise-linear map over one parameter.

Fixed points and jump crossings are followed from cell to cell by what names them: a fixed point by
its word, a crossing by its cut and the words on both sides. A branch lasts while its name does; it
ends where the name does, or where its multiplier is +1 or -1. Ends that lie at one place form a
special point, and what it is follows from which branches meet there, and on which side.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cmp_to_key
from itertools import pairwise
from math import inf, nan
from typing import Any

import sympy
from sympy import QQ

from pwmap.cells import INFINITE, Axis, Cell, checked_orders, checked_span, cut_up
from pwmap.cylinders import Cut, Place, minimal_period
from pwmap.diagram import Branch, BranchKind, Diagram, PointKind, SpecialPoint
from pwmap.exact import Fraction_, Number, cancelled, fraction_to_sympy, is_constant, to_sympy
from pwmap.itineraries import Orbits, Word
from pwmap.maps import PiecewiseLinearMap
from pwmap.roots import bounds

SAMPLES = 65  # along a branch that is curved
LEFT, ALONG, RIGHT = -1, 0, 1  # of an end: the branch lies at smaller, equal, larger parameters


def bifurcation_diagram(
    map_: PiecewiseLinearMap,
    parameter: object,
    span: tuple[object, object] | None = None,
    orders: Iterable[int] = (1, 2),
    sample: Mapping[object, object] | None = None,
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
        to about one above the last.
    orders
        The iterates j. A periodic point is listed with its minimal period only, a jump crossing
        with every order it occurs in.
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
        low, high = checked_span(map_, parameter, span)
    axis, cells = cut_up(map_, parameter, orders, low, high, sample)
    return _Builder(axis, map_, cells, (axis.place(low), axis.place(high))).diagram()


def _whole_span(
    map_: PiecewiseLinearMap,
    parameter: object,
    orders: Sequence[int],
    sample: Mapping[object, object] | None,
) -> tuple[Number, Number]:
    _, cells = cut_up(map_, parameter, orders, None, None, sample)
    edges = [getattr(cell.lower, "value", cell.lower) for cell in cells if cell.is_edge]
    if not edges:
        return QQ(-1), QQ(1)
    low, high = bounds(edges[0])[0], bounds(edges[-1])[1]
    return QQ(low.numerator // low.denominator - 1), QQ(-(-high.numerator // high.denominator) + 1)


# --- Branches in the making -----------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Name:
    """What identifies a branch from cell to cell.

    Attributes
    ----------
    kind
        What it is a branch of.
    words
        The word of a fixed point, or the words on both sides of a jump.
    cut
        Where the jump is, or the end of a piece that is the identity; None for other fixed points.
    """

    kind: BranchKind
    words: tuple[Word, ...]
    cut: Cut | None = None

    def x(self, orbits: Orbits) -> Fraction_:
        """Its position as a quotient."""
        word = self.words[0]
        if self.cut is None:
            return cancelled(orbits.fixed_point(word))
        return cancelled(orbits.preimage(self.cut.k, word[: self.cut.steps]))


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """A name, from one place of the axis to another.

    Attributes
    ----------
    closed
        Whether it exists at its ends too.
    isolated
        Whether it is a fixed point whose cylinder is that point alone: then it has no slope.
    x
        Position at both ends, for a run along one value of the parameter only.
    """

    name: Name
    places: tuple[Any, Any]
    closed: tuple[bool, bool] = (True, True)
    isolated: bool = False
    x: tuple[Fraction_, Fraction_] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class End:
    """One end of a run, as a special point sees it."""

    run: Run
    which: int  # 0 or 1
    side: int  # LEFT, ALONG or RIGHT
    unit: int  # +1 or -1 if that is the multiplier there, otherwise 0

    @property
    def is_fixed(self) -> bool:
        """Whether it is the end of a branch of fixed points."""
        return self.run.name.kind is BranchKind.FIXED_POINT

    @property
    def steps(self) -> int:
        """Length of the words."""
        return len(self.run.name.words[0])


@dataclass(frozen=True, slots=True, eq=False)
class Meeting:
    """A special point: the ends of runs that lie there."""

    place: Any
    value: Hashable  # of x, canonical, or (INFINITE, sign)
    ends: tuple[End, ...]

    @property
    def x_sign(self) -> int:
        """Sign of an infinite x, or 0."""
        return (
            self.value[1] if isinstance(self.value, tuple) and self.value[:1] == (INFINITE,) else 0
        )


class _Builder:
    """Follows names through the cells and joins the ends of runs in special points."""

    def __init__(
        self,
        axis: Axis,
        map_: PiecewiseLinearMap,
        cells: Sequence[Cell],
        span: tuple[Any, Any],
    ) -> None:
        self.axis, self.map, self.cells, self.span = axis, map_, cells, span
        self.orbits = axis.orbits
        self.present = [self._names(cell) for cell in cells]

    def diagram(self) -> Diagram:
        """Runs, then points, then vertical runs between points, then all of it as a diagram."""
        runs = list(self._runs())
        runs += self._vertical_runs(self._meetings(runs))
        meetings = self._meetings(runs)
        counts: dict[str, int] = defaultdict(int)
        branch_ids: dict[Run, str] = {}
        for run in runs:
            letter = "F" if run.name.kind is BranchKind.FIXED_POINT else "J"
            counts[letter] += 1
            branch_ids[run] = f"{letter}{counts[letter]}"
        points, ends = [], {}
        for meeting in meetings:
            kind, note = classify(meeting, meeting.place in self.span)
            counts[kind] += 1
            point_id = f"{kind}{counts[kind]}"
            points.append(self._point(point_id, kind, note, meeting, branch_ids))
            ends.update({(end.run, end.which): point_id for end in meeting.ends})
        branches = [
            self._branch(branch_ids[run], run, (ends[run, 0], ends[run, 1])) for run in runs
        ]
        return Diagram(
            parameter_name=self.axis.name,
            x_name=str(self.map.x),
            branches=tuple(branches),
            points=tuple(points),
            given=tuple(str(relation) for relation in self.axis.given),
        )

    # --- Runs -----------------------------------------------------------------------------------

    def _names(self, cell: Cell) -> dict[Name, bool]:
        """What lies on the diagonal in a cell; the value says whether it is an isolated point."""
        found: dict[Name, bool] = {}
        for order, iterate in cell.study.iterates.items():
            for cylinder, place in zip(iterate.cylinders, iterate.places, strict=True):
                word = cylinder.word
                if place in (Place.VIRTUAL, Place.NONE) or self._period(word, place) != order:
                    continue
                if place is Place.BAND:
                    cuts = [cut for cut in (cylinder.lower, cylinder.upper) if cut is not None]
                elif cell.study.judge.multiplier(word, 1) == 0:  # a point piece of slope 1
                    cuts = [cylinder.lower]
                else:
                    cuts = [None]
                for cut in cuts:
                    name = Name(BranchKind.FIXED_POINT, (word,), cut)
                    found[name] = place is Place.POINT
            for crossing in iterate.crossings:
                name = Name(BranchKind.JUMP, (crossing.left, crossing.right), crossing.cut)
                found[name] = False
        return found

    def _period(self, word: Word, place: Place) -> int:
        """Minimal period of a fixed point, or of almost all points of a band."""
        period = minimal_period(word, len(self.map.chain))
        if place is Place.BAND and 2 * period * len(self.map.chain) == len(word):
            return 2 * period  # the half word has slope -1, or it were a band of its own
        return period

    def _runs(self) -> Iterator[Run]:
        """Maximal stretches of cells with one name; a multiplier of +1 or -1 parts them too."""
        where: dict[Name, list[int]] = defaultdict(list)
        for i, names in enumerate(self.present):
            for name in names:
                where[name].append(i)
        for name, indices in where.items():
            stretch: list[int] = []
            for i, following in pairwise([*indices, -1]):
                stretch.append(i)
                inner_edge = self.cells[i].is_edge and following == i + 1
                if following != i + 1 or (
                    inner_edge and len(stretch) > 1 and self._unit(name, self.cells[i].lower)
                ):
                    run = self._run(name, stretch)
                    if run is not None:
                        yield run
                    stretch = [i] if following == i + 1 else []

    def _run(self, name: Name, stretch: Sequence[int]) -> Run | None:
        first, last = self.cells[stretch[0]], self.cells[stretch[-1]]
        if first is last and first.is_edge and self._is_band(name, first):
            return None  # drawn along the edge
        low = self.span[0] if first.lower is None else first.lower
        high = self.span[1] if last.upper is None else last.upper
        closed = first.is_edge or low == self.span[0], last.is_edge or high == self.span[1]
        return Run(name, (low, high), closed, all(self.present[i][name] for i in stretch))

    def _is_band(self, name: Name, cell: Cell) -> bool:
        return (
            name.kind is BranchKind.FIXED_POINT
            and name.cut is not None
            and not (self.present[self.cells.index(cell)][name])
        )

    def _unit(self, name: Name, place: Any) -> int:
        """+1 or -1 where the multiplier of a fixed point passes through that value."""
        if name.kind is BranchKind.JUMP or name.cut is not None:
            return 0
        one = self.orbits.table.one
        slope = self.orbits.affine(name.words[0])[0]
        if is_constant(slope):
            return 0
        units = (u for u in (1, -1) if self.axis.order((slope, one), (u * one, one), place) == 0)
        return next(units, 0)

    def _vertical_runs(self, meetings: Sequence[Meeting]) -> Iterator[Run]:
        """Bands of fixed points that exist at one value of the parameter only.

        A band is parted at the special points inside it.
        """
        for i, cell in enumerate(self.cells):
            if not cell.is_edge:
                continue
            beside = {n.words for j in (i - 1, i + 1) for n in self.present[j] if n.cut is not None}
            for order, iterate in cell.study.iterates.items():
                for cylinder, place in zip(iterate.cylinders, iterate.places, strict=True):
                    if (
                        place is not Place.BAND
                        or (cylinder.word,) in beside
                        or self._period(cylinder.word, place) != order
                    ):
                        continue
                    name = Name(BranchKind.FIXED_POINT, (cylinder.word,))
                    ends = [
                        self.orbits.preimage(cut.k, cylinder.word[: cut.steps]) if cut else None
                        for cut in (cylinder.lower, cylinder.upper)
                    ]
                    stops = self._parted(ends, cell.lower, meetings)
                    for j, (low, high) in enumerate(pairwise(stops)):
                        closed = (
                            cylinder.lower_closed or j > 0,
                            cylinder.upper_closed or j < len(stops) - 2,
                        )
                        yield Run(name, (cell.lower, cell.lower), closed, x=(low, high))

    def _parted(
        self, ends: list[Fraction_ | None], place: Any, meetings: Sequence[Meeting]
    ) -> list[Fraction_ | None]:
        """Both ends of a band (None if infinite) and the special points between them."""
        inner: dict[Hashable, Fraction_] = {}
        for meeting in meetings:
            if meeting.place == place and not meeting.x_sign:
                x = self._x_of(meeting.ends[0])
                below = ends[0] is None or self.axis.order(ends[0], x, place) < 0
                above = ends[1] is None or self.axis.order(x, ends[1], place) < 0
                if below and above:
                    inner[meeting.value] = x
        by_size = cmp_to_key(lambda first, second: self.axis.order(first, second, place))
        return [ends[0], *sorted(inner.values(), key=by_size), ends[1]]

    # --- Points ---------------------------------------------------------------------------------

    def _meetings(self, runs: Sequence[Run]) -> list[Meeting]:
        """Ends of runs that lie at the same place, from left to right and bottom to top."""
        groups: dict[tuple[Any, Hashable], list[End]] = defaultdict(list)
        for run in runs:
            vertical = run.places[0] == run.places[1]
            for which, side in ((0, RIGHT), (1, LEFT)):
                unit = self._unit(run.name, run.places[which]) if run.x is None else 0
                end = End(run, which, ALONG if vertical else side, unit)
                groups[run.places[which], self._value(end)].append(end)
        meetings = [Meeting(place, value, tuple(ends)) for (place, value), ends in groups.items()]
        return sorted(meetings, key=lambda m: (m.place, self._x_float(m)))

    def _x_of(self, end: End) -> Fraction_ | None:
        run = end.run
        return run.name.x(self.orbits) if run.x is None else run.x[end.which]

    def _value(self, end: End) -> Hashable:
        """The x of an end in canonical form; an infinite one with its sign."""
        x, place = self._x_of(end), end.run.places[end.which]
        if x is None:  # a band without end
            return INFINITE, 2 * end.which - 1
        value = self.axis.value(x, place)
        if value != INFINITE:
            return value
        zero, one = self.orbits.table.one - self.orbits.table.one, self.orbits.table.one
        inner = self.axis.between(*end.run.places)
        signs = [self.axis.order((number, one), (zero, one), at)
                 for number, at in zip(x, (place, inner), strict=True)]  # fmt: skip
        return INFINITE, signs[0] * signs[1]

    def _x_float(self, meeting: Meeting) -> float:
        if meeting.x_sign:
            return meeting.x_sign * inf
        return self.axis.number(self._x_of(meeting.ends[0]), meeting.place)

    def _order(self, steps: int) -> int:
        return steps // len(self.map.chain)

    def _point(
        self,
        point_id: str,
        kind: PointKind,
        note: str,
        meeting: Meeting,
        branch_ids: Mapping[Run, str],
    ) -> SpecialPoint:
        x = (
            meeting.x_sign * sympy.oo
            if meeting.x_sign
            else self.axis.value_to_sympy(meeting.value, meeting.place)
        )
        return SpecialPoint(
            id=point_id,
            kind=kind,
            parameter=self.axis.number(self.axis.identity, meeting.place),
            x=self._x_float(meeting),
            branches=tuple(dict.fromkeys(branch_ids[end.run] for end in meeting.ends)),
            order=self._order(_lowest(meeting.ends)),
            note=note,
            exact={"parameter": self.axis.to_sympy(meeting.place), "x": x},
        )

    # --- Branches -------------------------------------------------------------------------------

    def _branch(self, branch_id: str, run: Run, ends: tuple[str, str]) -> Branch:
        name, axis, orbits = run.name, self.axis, self.orbits
        word = name.words[0]
        x = name.x(orbits) if run.x is None else None
        slope = orbits.affine(word)[0]
        low, high = (axis.to_sympy(place) for place in run.places)
        exact: dict[str, sympy.Basic] = {
            "interval": sympy.Interval(low, high, not run.closed[0], not run.closed[1])
        }
        if x is not None:
            exact["x"] = fraction_to_sympy(x)
        if name.kind is BranchKind.JUMP:
            assert name.cut is not None
            for side, w in zip(("left", "right"), name.words, strict=True):
                exact[side] = to_sympy(orbits.orbit(name.cut.k, w[name.cut.steps :]))
        else:
            exact["multiplier"] = sympy.nan if run.isolated else to_sympy(slope)
        parameter, positions, multipliers = self._samples(run, x, slope)
        return Branch(
            id=branch_id,
            kind=name.kind,
            order=self._order(len(word)),
            word="|".join(self.map.spelled(w) for w in name.words),
            parameter=parameter,
            x=positions,
            multiplier=multipliers,
            ends=ends,
            exact=exact,
        )

    def _samples(
        self, run: Run, x: Fraction_ | None, slope: Number
    ) -> tuple[list[float], list[float], list[float]]:
        """Floats along a run: two samples if it is straight and its multiplier constant."""
        axis, one = self.axis, self.orbits.table.one
        start, stop = run.places
        first, last = (axis.number(axis.identity, place) for place in run.places)
        positions = [self._x_float(Meeting(p, self._value(e), (e,)))
                     for p, e in zip(run.places, (End(run, 0, 0, 0), End(run, 1, 0, 0)), strict=True)]  # fmt: skip
        jump = run.name.kind is BranchKind.JUMP or run.isolated
        if x is None:
            return [first, last], positions, [1.0, 1.0]
        if start == stop:
            m = nan if jump else axis.number((slope, one), start)
            return [first], positions[:1], [m]
        degrees = [axis.degree(number) for number in (*x, slope)]
        straight = degrees[0] <= 1 and degrees[1:] == [0, 0]
        inner = [] if straight else axis.spread(start, stop, SAMPLES - 2)
        parameter = [first, *(axis.number(axis.identity, place) for place in inner), last]
        positions = [positions[0], *(axis.number(x, place) for place in inner), positions[1]]
        places = [start, *inner, stop]
        multipliers = [nan if jump else axis.number((slope, one), place) for place in places]
        return parameter, positions, multipliers


# --- What kind of point -----------------------------------------------------------------------------


def _lowest(ends: Sequence[End]) -> int:
    """Word length of the fixed points that meet, or of the jumps if only jumps do."""
    return min((end.steps for end in ends if end.is_fixed), default=min(e.steps for e in ends))


def classify(meeting: Meeting, at_span_end: bool) -> tuple[PointKind, str]:
    """Kind of a special point, and a note, from the branches that meet there.

    With n the lowest order of the fixed points that meet, look at all branches of that order. They
    lie on both sides of the parameter (persistence) or on one (fold). A fold of one branch of
    fixed points into a jump branch is a fold-flip (FF) if on its side a jump branch of order 2n
    starts that follows another curve: the preimage of the jump, which crosses the diagonal just
    when the fixed point's multiplier is below -1 or above +1.
    """
    ends = meeting.ends
    if at_span_end:
        return PointKind.EP, "end of the span"
    units = {end.unit for end in ends}
    if meeting.x_sign:
        kind = PointKind.LP if 1 in units else PointKind.EP
        return kind, "x grows without bound"
    steps = _lowest(ends)
    own = [end for end in ends if end.steps == steps]
    fixed = [end for end in own if end.is_fixed]
    if not fixed:
        return PointKind.WC, "jumps only"
    if -1 in units:
        vertical = any(end.side == ALONG for end in ends)
        note = "degenerate: all points nearby have twice the period" if vertical else ""
        return PointKind.PD, note
    if 1 in units or all(end.side == ALONG and end.run.x is not None for end in fixed):
        return PointKind.LP, "degenerate: an interval of fixed points"
    sides = {end.side for end in own} - {ALONG}
    if len(sides) != 1:
        return PointKind.BC, "persistence" if sides else "isolated"
    jumps = [end for end in own if not end.is_fixed]
    curves = {_curve(end) for end in jumps}
    doubled = [end for end in ends if not end.is_fixed and end.steps == 2 * steps]
    if (
        len(fixed) == 1
        and jumps
        and any(end.side in sides and _curve(end) not in curves for end in doubled)
    ):
        return PointKind.FF, "fold"
    return PointKind.BC, "fold"


def _curve(end: End) -> tuple[int, Word]:
    """What determines the position of a jump: the break and the word that leads to it."""
    name = end.run.name
    assert name.cut is not None
    return name.cut.k, name.words[0][: name.cut.steps]
