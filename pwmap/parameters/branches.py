"""Fixed points and jump crossings, followed through the cells of a parameter, and as arrays.

The key of a fixed point is its word, that of a crossing its cut and the words on both sides. A
segment ends where nothing has its key any more, or where its multiplier is +1 or -1. Ends at one
place meet in a junction.

Arrays of floats are for drawing only. Along a curved branch x and multiplier are computed in floats
with a bound of rounding errors, or from exact numbers where that is too large (near a pole, or
where large terms cancel).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property, cmp_to_key, partial, wraps
from itertools import pairwise
from math import inf, nan
from typing import Any, Concatenate, ParamSpec, TypeVar

import numpy as np
from sympy import QQ

from pwmap.algebra.exact import Fraction_, Infinite, Number, cancelled, is_constant, to_float
from pwmap.diagrams.data import BranchKind, FloatArray
from pwmap.maps.cylinders import Cut, Cylinder, Inclusion, StudiedIterate, minimal_period
from pwmap.maps.piecewise_linear import PiecewiseLinearMap
from pwmap.maps.words import Orbits, SignOracle
from pwmap.parameters.axis import INFINITE, Axis
from pwmap.parameters.cells import Cell
from pwmap.parameters.segments import (
    ALONG,
    LEFT,
    RIGHT,
    BranchKey,
    Junction,
    Known,
    Location,
    Position,
    Segment,
    SegmentCurve,
    SegmentEnd,
)

EndValues = dict[Any, dict[int, set[Any]]]  # by place and word length

P = ParamSpec("P")
R = TypeVar("R")


def remembered(
    find: Callable[Concatenate[Continuation, P], R],
) -> Callable[Concatenate[Continuation, P], R]:
    """Cache a function of a continuation by its other arguments, in ``continuation.known``."""

    @wraps(find)
    def found(continuation: Continuation, /, *about: P.args, **named: P.kwargs) -> R:
        values: dict[object, R] = continuation.known[find]
        if about not in values:
            values[about] = find(continuation, *about, **named)
        return values[about]

    return found


@dataclass(frozen=True, eq=False)
class Continuation:
    """Fixed points and crossings, followed through the cells of a parameter from left to right."""

    map: PiecewiseLinearMap
    axis: Axis
    cells: Sequence[Cell]
    span: tuple[Any, Any]  # first and last value, as far as the assumptions reach
    known: Known = field(default_factory=lambda: defaultdict(dict), repr=False)  # for this axis

    @property
    def length(self) -> int:
        """The length of the words of order 1: how many maps are composed."""
        return len(self.map.chain)

    @property
    def orbits(self) -> Orbits:
        """Affine forms of words in the parameters."""
        return self.axis.orbits

    @cached_property
    def present(self) -> list[dict[BranchKey, Location | None]]:
        """The keys in each cell: those of fixed points with their location, and of jumps."""
        found = [dict(self._keys(cell)) for cell in self.cells]
        for i, keys in enumerate(found):
            # at an edge the cylinder of a fixed point may be that point alone, without slope: then
            # it takes the key of the branch beside it
            beside = [*found[i - 1 : i], *found[i + 1 : i + 2]] if self.cells[i].is_edge else []
            for key in [key for key, location in keys.items() if location and location.is_isolated]:
                plain = self._same(BranchKey(key.kind, key.words))
                if any(plain in others for others in beside):
                    keys[plain] = keys.pop(key)
        return found

    def _keys(self, cell: Cell) -> Iterator[tuple[BranchKey, Location | None]]:
        known = self.known["iterates"]  # by id, which stays valid as the iterate is kept too
        for order, iterate in cell.iterates.items():
            if id(iterate) not in known:  # cells share the iterates of lower orders
                found = [*self._of_iterate(order, iterate, cell.oracle)]
                known[id(iterate)] = iterate, found
            yield from known[id(iterate)][1]

    @remembered
    def _same(self, key: BranchKey) -> BranchKey:
        """One object for equal keys, so that dictionaries compare them by identity."""
        return key

    def _of_iterate(
        self, order: int, iterate: StudiedIterate, oracle: SignOracle
    ) -> Iterator[tuple[BranchKey, Location | None]]:
        for cylinder, inclusion, stable in zip(
            iterate.cylinders, iterate.inclusion, iterate.stable, strict=True
        ):
            is_there = inclusion is not Inclusion.VIRTUAL
            if is_there and self._is_own(cylinder, inclusion, order, oracle):
                for cut in _cuts(cylinder, inclusion):
                    key = BranchKey(BranchKind.FIXED_POINT, (cylinder.word,), cut)
                    yield self._same(key), Location(inclusion, stable)
        for cut, *words in iterate.crossings:
            yield self._same(BranchKey(BranchKind.JUMP, tuple(words), cut)), None

    def _is_own(
        self, cylinder: Cylinder, inclusion: Inclusion, order: int, oracle: SignOracle
    ) -> bool:
        """Whether the fixed points of a cylinder have the order as their minimal period."""
        period = minimal_period(cylinder.word, self.length)
        if inclusion is Inclusion.BAND and order == 2 * period:
            return oracle.slope(cylinder.word[: len(cylinder.word) // 2]) < 0
        return period == order

    @cached_property
    def stops(self) -> tuple[Any, ...]:
        """Places at which all branches end: ends of the span and of the admitted intervals."""
        excluded = [end for c in self.cells if c.is_excluded for end in (c.lower, c.upper)]
        return (self.cells[0].lower, self.cells[-1].upper, *excluded)

    # --- Segments -------------------------------------------------------------------------------

    def segments(self) -> list[Segment]:
        """All segments: first those over the parameter, then bands along one value of it."""
        found = [
            self._segment(key, part)
            for key, stretch in self._stretches
            for part in self._cut(key, stretch)
        ]
        junctions = self.junctions(found) if self._bands else []
        return found + [part for band in self._bands for part in self._parted(*band, junctions)]

    @cached_property
    def _stretches(self) -> list[tuple[BranchKey, list[int]]]:
        """Maximal stretches of cells with one key, parted where it :meth:`_changes` stability."""
        found: list[tuple[BranchKey, list[int]]] = []
        where: dict[BranchKey, list[int]] = defaultdict(list)
        for i, keys in enumerate(self.present):
            for key in keys:
                where[key].append(i)
        for key, indices in where.items():
            stretch: list[int] = []
            for i, following in pairwise([*indices, -1]):
                stretch.append(i)
                goes_on = following == i + 1
                parted = len(stretch) > 1 and self.cells[i].is_edge and goes_on
                if not goes_on or (parted and self._changes(key, i)):
                    if len(stretch) > 1 or not (self._is_edge_of_band(key, i) or self._at_end(i)):
                        found.append((key, stretch))
                    stretch = [i] if goes_on else []
        return found

    @cached_property
    def _borders(self) -> set[tuple[int, int]]:
        """Edge and word length of fixed points on which others may end."""
        return {
            (i, len(key.word))
            for key, s in self._stretches
            if key.kind is BranchKind.FIXED_POINT
            for i in s
            if self.cells[i].is_edge and (len(s) == 1 or self._is_on_border(key, i))
        }

    def _changes(self, key: BranchKey, i: int) -> bool:
        """Whether a fixed point changes its stability at an edge through which it passes."""
        if key.kind is BranchKind.JUMP:
            return False
        stable = {location.stable for k in (i - 1, i, i + 1) if (location := self.present[k][key])}
        if len(stable) > 1 or key.cut is not None:
            return len(stable) > 1
        oracle = self.cells[i].oracle
        hits = any(oracle.multiplier(key.word, unit) == 0 for unit in (1, -1))
        return hits and self.unit_multiplier(key, self.cells[i].lower) != 0

    @cached_property
    def _end_values(self) -> EndValues:
        """The x of ends of segments, by word length, at each place where one may end on another."""
        passed = {self.cells[i].lower for key, s in self._stretches for i in self._exposed(key, s)}
        found: EndValues = {place: defaultdict(set) for place in passed}
        for key, stretch in self._stretches if passed else ():
            segment = self._segment(key, stretch)
            for k, place in enumerate(segment.places):
                value = self._value(segment, k) if place in passed else None
                if value is not None and not isinstance(value, Infinite):
                    found[place][len(key.word)].add(value)
        for cylinder, place in self._bands:
            for cut in (cylinder.lower, cylinder.upper):
                if cut is not None and place in passed:
                    x = self.orbits.preimage(cut.k, cylinder.word[: cut.steps])
                    found[place][len(cylinder.word)].add(self.axis.value(x, place))
        return found

    def _exposed(self, key: BranchKey, stretch: Sequence[int]) -> Iterator[int]:
        """Edges that a segment passes and at which others of its order can end on it."""
        order = len(key.word)
        for i in stretch[1:-1]:
            # others end on a fixed point only where it lies on a border, on a jump only where a
            # fixed point of its order does
            if self.cells[i].is_edge and (
                (i, order) in self._borders or self._is_on_border(key, i)
            ):
                yield i

    def _is_on_border(self, key: BranchKey, i: int) -> bool:
        """Whether a fixed point lies at an end of its cylinder, or is one."""
        location = self.present[i][key]
        return location is not None and not location.is_inside

    def _cut(self, key: BranchKey, stretch: Sequence[int]) -> Iterator[Sequence[int]]:
        """Cut a stretch where other segments end on it; for a jump, those of its order only."""
        start = 0
        for i in self._exposed(key, stretch):
            place = self.cells[i].lower
            ends = self._end_values[place]
            own = [ends[len(key.word)]] if key.kind is BranchKind.JUMP else ends.values()
            if any(self._at(key, place) in values for values in own):
                stop = stretch.index(i)
                yield stretch[start : stop + 1]
                start = stop
        yield stretch[start:]

    def _segment(self, key: BranchKey, stretch: Sequence[int]) -> Segment:
        first, last = self.cells[stretch[0]], self.cells[stretch[-1]]
        return self._kept(
            key,
            (first.lower, last.upper),
            (first.is_edge, last.is_edge),
            next((self.present[i][key] for i in stretch if not self.cells[i].is_edge), None)
            or self.present[stretch[0]][key],
        )

    @remembered
    def _kept(self, *held: Any) -> Segment:
        """The segment with these fields: the same object for equal ones."""
        return Segment(*held)

    def _at_end(self, i: int) -> bool:
        """Whether a cell is one of the :attr:`stops`; what exists only there is left out."""
        return self.cells[i].is_edge and self.cells[i].lower in self.stops

    def _is_edge_of_band(self, key: BranchKey, i: int) -> bool:
        """Whether a key at an edge is that of an end of a band along that edge."""
        location = self.present[i][key]
        in_band = location is not None and location.inclusion is Inclusion.BAND
        return in_band and self.cells[i].is_edge

    @cached_property
    def _bands(self) -> list[tuple[Cylinder, Any]]:
        """Pieces that are the identity at one value of the parameter only, and that value."""
        found: list[tuple[Cylinder, Any]] = []
        for i, cell in enumerate(self.cells):
            if not cell.is_edge or self._at_end(i):
                continue
            beside = {c.word for k in (i - 1, i + 1) for _, c in _identities(self.cells[k])}
            found += [
                (cylinder, cell.lower)
                for order, cylinder in _identities(cell)
                if cylinder.word not in beside
                and self._is_own(cylinder, Inclusion.BAND, order, cell.oracle)
            ]
        return found

    @property
    def filled(self) -> list[int]:
        """The orders whose periodic points fill intervals, not at one value of the parameter only.

        Of such an interval only the ends that belong to it are branches.
        """
        return sorted({
            order
            for cell in self.cells
            if not cell.is_edge
            for order, cylinder in _identities(cell)
            if self._is_own(cylinder, Inclusion.BAND, order, cell.oracle)
        })  # fmt: skip

    def _parted(
        self, cylinder: Cylinder, place: Any, junctions: Sequence[Junction]
    ) -> Iterator[Segment]:
        """The segments of a band, cut at the special points inside it."""
        word, compare = cylinder.word, self.axis.compare
        low, high = (
            None if cut is None else self.orbits.preimage(cut.k, word[: cut.steps])
            for cut in (cylinder.lower, cylinder.upper)
        )
        inner = {
            junction.value: x
            for junction in junctions
            if junction.place == place
            and (x := junction.ends[0].x) is not None
            and not isinstance(junction.value, Infinite)
            and (low is None or compare(low, x, place) < 0)
            and (high is None or compare(x, high, place) < 0)
        }
        by_size = cmp_to_key(partial(compare, place=place))
        stops: list[Position] = [low, *sorted(inner.values(), key=by_size), high]
        for j, band in enumerate(pairwise(stops)):
            closed = (
                cylinder.lower_closed or j > 0,
                cylinder.upper_closed or j < len(stops) - 2,
            )
            yield self._kept(
                BranchKey(BranchKind.FIXED_POINT, (word,)), (place, place), closed, None, band
            )

    # --- Junctions ------------------------------------------------------------------------------

    def junctions(self, segments: Sequence[Segment]) -> list[Junction]:
        """Ends of segments that lie at the same place, from left to right and bottom to top."""
        groups: dict[tuple[Any, Hashable], list[SegmentEnd]] = defaultdict(list)
        for segment in segments:
            for end in self.ends(segment):
                groups[end.place, end.value].append(end)
        found = [
            Junction(place, value, tuple(ends), self._attracts(place, ends))
            for (place, value), ends in groups.items()
        ]
        return sorted(found, key=lambda each: (each.place, each.value))

    def _attracts(self, place: Any, ends: Sequence[SegmentEnd]) -> int:
        """+1 if a fixed point attracts here but not on its branches, -1 if the reverse, else 0."""
        i = self._edges.get(place)
        beside: dict[BranchKey, set[bool]] = defaultdict(set)
        for end in ends:
            if end.segment.location is not None and end.segment.places[0] != end.segment.places[1]:
                beside[end.segment.key].add(end.segment.location.stable)
        for key, stable in beside.items():
            here = None if i is None else self.present[i].get(key)
            if here is not None and stable == {not here.stable}:
                return 1 if here.stable else -1
        return 0

    @cached_property
    def _edges(self) -> dict[Any, int]:
        return {cell.lower: i for i, cell in enumerate(self.cells) if cell.is_edge}

    @remembered
    def ends(self, segment: Segment) -> tuple[SegmentEnd, SegmentEnd]:
        """Both ends of a segment."""
        along = segment.places[0] == segment.places[1]
        is_steep = self._is_steep(segment)
        first, last = (
            SegmentEnd(
                segment,
                which,
                ALONG if along else side,
                0 if segment.band else self.unit_multiplier(segment.key, segment.places[which]),
                is_steep,
                self._x(segment, which),
                self._value(segment, which),
            )
            for which, side in ((0, RIGHT), (1, LEFT))
        )
        return first, last

    @remembered
    def position(self, key: BranchKey) -> Fraction_:
        """The x of a fixed point or jump by its key, as a quotient in lowest terms."""
        if key.cut is None:
            return cancelled(self.orbits.fixed_point(key.word))
        return cancelled(self.orbits.preimage(key.cut.k, key.word[: key.cut.steps]))

    @remembered
    def _at(self, key: BranchKey, place: Any) -> Any:
        """The :meth:`position` of a key at a place, in canonical form."""
        return self.axis.value(self.position(key), place)

    def _x(self, segment: Segment, which: int) -> Position:
        return self.position(segment.key) if segment.band is None else segment.band[which]

    def _value(self, segment: Segment, which: int) -> Any:
        """The x of an end in canonical form; an infinite one with its side."""
        x, place = self._x(segment, which), segment.places[which]
        if x is None:
            return Infinite(2 * which - 1)
        value = self._at(segment.key, place) if segment.band is None else self.axis.value(x, place)
        if value != INFINITE:
            return value
        one = self.orbits.table.one
        inside = self.axis.between(*segment.places)  # the denominator has no zero there
        top, bottom = (
            self.axis.compare((number, one), (one - one, one), where)
            for number, where in zip(x, (place, inside), strict=True)
        )
        return Infinite(top * bottom)

    def unit_multiplier(self, key: BranchKey, place: Any) -> int:
        """+1 or -1 where the multiplier of a fixed point passes through that value, else 0."""
        slope = self.orbits.slope(key.word)
        if key.kind is BranchKind.JUMP or key.cut is not None or all(map(is_constant, slope)):
            return 0
        return self._unit(slope, place) if self.is_finite(slope, place) else 0

    @remembered
    def _unit(self, slope: Fraction_, place: Any) -> int:
        compare, one = self.axis.compare, self.orbits.table.one
        return next((u for u in (1, -1) if compare(slope, (u * one, one), place) == 0), 0)

    def is_finite(self, fraction: Fraction_, place: Any) -> bool:
        """Whether a quotient has a value; a denominator may vanish at an open end of the span."""
        return is_constant(fraction[1]) or self.axis.value(fraction, place) != INFINITE

    def _is_steep(self, segment: Segment) -> bool:
        if segment.key.kind is BranchKind.JUMP or segment.is_isolated:
            return False
        place = segment.places[0]
        if place != segment.places[1]:  # at an end the multiplier may have modulus 1
            place = self.axis.between(*segment.places)
        (top, bottom), one = self.orbits.slope(segment.key.word), self.orbits.table.one
        return self.axis.compare((top * top, bottom * bottom), (one, one), place) > 0

    def number(self, end: SegmentEnd) -> tuple[float, float]:
        """Parameter and x of an end as floats; the x may be infinite."""
        parameter = self.axis.number(self.axis.identity, end.place)
        if isinstance(end.value, Infinite):
            return parameter, end.value.side * inf
        assert end.x is not None
        return parameter, self.axis.number(end.x, end.place)


def _identities(cell: Cell) -> Iterator[tuple[int, Cylinder]]:
    """Orders, and cylinders of their iterates on which these are the identity."""
    for order, iterate in cell.iterates.items():
        for cylinder, inclusion in zip(iterate.cylinders, iterate.inclusion, strict=True):
            if inclusion is Inclusion.BAND:
                yield order, cylinder


def _cuts(cylinder: Cylinder, inclusion: Inclusion) -> list[Cut | None]:
    """The cuts in the keys of a cylinder's fixed points: the point, or ends that a band owns."""
    if inclusion is Inclusion.BAND:
        lower = cylinder.lower, cylinder.lower_closed
        upper = cylinder.upper, cylinder.upper_closed
        return [cut for cut, is_closed in (lower, upper) if is_closed]
    return [cylinder.lower if inclusion is Inclusion.POINT else None]


POINTS = 65  # samples of a curved branch: smooth to the eye across the width of a page
ROUNDING = 2.0**-53  # relative rounding error of one operation
MAX_DRAWN_ERROR = 2.0**-40  # largest relative error of a drawn value; a picture resolves 2**-12
# Least width of an interval, relative to its ends, that floats subdivide.
MIN_FLOAT_WIDTH = 2.0**-30


def curve_arrays(continuation: Continuation, curve: SegmentCurve) -> tuple[FloatArray, list[int]]:
    """Parameter, x and multiplier of a branch, (3, n), and the first sample of each segment."""
    parts = []
    for segment, entered in curve:
        found = segment_arrays(continuation, segment)[:, :: -1 if entered else 1]
        # a sample that two segments share is that of the later one
        parts.append(found if segment is curve[-1][0] else found[:, : max(1, len(found[0]) - 1)])
    starts = np.cumsum([0, *(len(part[0]) for part in parts[:-1])])
    return np.hstack(parts), starts.tolist()


@remembered
def segment_arrays(continuation: Continuation, segment: Segment) -> FloatArray:
    """Parameter, x and multiplier along a segment, (3, n); at its ends only if it is straight."""
    axis, slope = continuation.axis, continuation.orbits.slope(segment.key.word)
    ends = [continuation.number(end) for end in continuation.ends(segment)]
    smooth = segment.key.kind is BranchKind.FIXED_POINT and not segment.is_isolated
    multipliers = (
        axis.number(slope, place) if smooth and continuation.is_finite(slope, place) else nan
        for place in segment.places
    )
    outer = np.array([(*end, m) for end, m in zip(ends, multipliers, strict=True)]).T
    if segment.band is not None:
        return outer
    if segment.places[0] == segment.places[1]:
        return outer[:, :1]
    position = continuation.position(segment.key)
    degrees = [axis.degree(number) for number in (*position, *slope)]
    if degrees[0] <= 1 and not any(degrees[1:]):
        return outer
    places, parameter = _spread(axis, segment, *(p for p, _ in ends))
    x = values(axis, position, places, parameter)
    multiplier = values(axis, slope, places, parameter) if smooth else np.full(len(x), nan)
    return np.hstack([outer[:, :1], [parameter, x, multiplier], outer[:, 1:]])


def _spread(axis: Axis, segment: Segment, low: float, high: float) -> tuple[list[Any], FloatArray]:
    """Places inside a segment, in equal steps, and the same as floats."""
    steps = np.arange(1, POINTS - 1) / (POINTS - 1)
    parameter = low + (high - low) * steps
    if MIN_FLOAT_WIDTH * max(abs(low), abs(high)) < high - low < inf:
        return [axis.place(QQ(*p.as_integer_ratio())) for p in parameter.tolist()], parameter
    places = axis.equally_spaced(*segment.places, POINTS - 2)
    return places, np.array([axis.number(axis.identity, place) for place in places])


def values(axis: Axis, fraction: Fraction_, places: list[Any], parameter: FloatArray) -> FloatArray:
    """A quotient at some places, which are also given as floats."""
    with np.errstate(all="ignore"):
        (top, loose), (bottom, slack) = (_horner(axis, number, parameter) for number in fraction)
        found = top / bottom
        trusted = (loose <= MAX_DRAWN_ERROR * np.abs(top)) & (
            slack <= MAX_DRAWN_ERROR * np.abs(bottom)
        )
    for i in np.flatnonzero(~(trusted & np.isfinite(found))):
        found[i] = axis.number(fraction, places[i])
    return found


def _horner(axis: Axis, number: Number, parameter: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A polynomial in floats by Horner's rule, and its error bound 2 n u sum |c_k x^k|."""
    coefficients = np.array([to_float(c) for c in axis.coefficients(number)], dtype=float)
    size = np.polyval(np.abs(coefficients), np.abs(parameter))
    return np.polyval(coefficients, parameter), 2 * len(coefficients) * ROUNDING * size
