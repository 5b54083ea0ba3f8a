"""A piecewise-linear map of the line at fixed parameter values, and exact subsets of the line.

A *germ* is a point with a side: it stands for all points close enough to it on that side. The piece
on that side maps it to another germ or, if that piece is flat, to a point.

A set is a finite union of intervals and points, with or without their endpoints. Each of its ends
is a *cut*, just below (-1) or just above (+1) a number: [a, b) runs from the cut just below a to
the cut just below b, and the point a from the cut just below a to the one just above it. Intervals
and points are thus of one kind, and cuts compare as pairs.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from operator import itemgetter
from typing import Any, NamedTuple

import sympy
from sympy import QQ

from pwmap.algebra.arguments import check_mapping
from pwmap.algebra.exact import HIGHEST, LOWEST, Affine, dense, sign
from pwmap.algebra.numbers import Exact, quotient_of, to_double
from pwmap.algebra.roots import Real, RealRoot, algebraic, real_to_sympy, sign_at
from pwmap.algebra.terms import own_name
from pwmap.maps.piecewise_linear import PiecewiseLinearMap, check_map

IDENTITY = Affine(QQ.one, QQ.zero)
Interval = tuple[Exact, Exact]  # closed; both ends may be the same


class Germ(NamedTuple):
    """A point with a side: -1 is left of it, +1 right of it, 0 the point itself."""

    x: Exact
    side: int


class AffinePiece(NamedTuple):
    """An affine piece, slope x + intercept, on an open interval or at a single point."""

    slope: Exact
    intercept: Exact
    lower: Exact
    upper: Exact
    letter: str

    def __call__(self, x: Exact) -> Exact:
        """The value of the formula at x, which may lie outside of the domain."""
        return self.slope * x + self.intercept

    def image(self, germ: Germ) -> Germ:
        """The image of a germ; a negative slope exchanges the sides, a flat piece gives side 0."""
        return Germ(self(germ.x), germ.side * sign(self.slope))

    def after(self, first: Affine) -> Affine:
        """The composition: this formula applied after ``first``."""
        return Affine(*self[:2]).after(first)

    @property
    def is_point(self) -> bool:
        """Whether the domain is a single point."""
        return bool(self.lower == self.upper)

    def over(self, interval: Interval) -> Interval:
        """The image of a closed interval inside the domain, lower end first."""
        first, last = self(interval[0]), self(interval[1])
        return (first, last) if first <= last else (last, first)


@dataclass(frozen=True, eq=False)
class MapLine:
    """A map at fixed parameter values."""

    branches: tuple[AffinePiece, ...]  # on open intervals, from left to right
    owners: tuple[AffinePiece, ...]  # of the breaks: an adjacent branch, or a one-point piece

    @cached_property
    def breaks(self) -> tuple[Exact, ...]:
        """The points where two branches meet, from left to right."""
        return tuple(branch.upper for branch in self.branches[:-1])

    @cached_property
    def germs(self) -> tuple[Germ, ...]:
        """The germs on both sides of each break, from left to right."""
        return tuple(Germ(x, side) for x in self.breaks for side in (-1, 1))

    def number(self, germ: Germ) -> int:
        """The index of the branch on a germ's side; at a break (side 0) that of the left branch."""
        return (bisect_left if germ.side <= 0 else bisect_right)(self.breaks, germ.x)

    def piece(self, germ: Germ) -> AffinePiece:
        """The branch on a germ's side; for side 0 the piece that owns the point."""
        k = self.number(germ)
        at_break = not germ.side and k < len(self.breaks) and self.breaks[k] == germ.x
        return self.owners[k] if at_break else self.branches[k]

    def image(self, germ: Germ) -> Germ:
        """The image of a germ."""
        return self.piece(germ).image(germ)

    def __call__(self, x: Exact) -> Exact:
        """The value at a point."""
        return self.piece(Germ(x, 0))(x)

    def orbit(self, germ: Germ) -> Iterator[Germ]:
        """Yield a germ and all of its images, without end."""
        while True:
            yield germ
            germ = self.image(germ)

    def along(self, word: Iterable[int]) -> Affine:
        """The affine composition along a word, given as branch indices."""
        whole = IDENTITY
        for k in word:
            whole = self.branches[k].after(whole)
        return whole

    def follows(self, x: Exact, word: Iterable[int]) -> bool:
        """Whether the orbit of x visits the closed domains of the branches of a word in turn."""
        for k in word:
            branch = self.branches[k]
            if not branch.lower <= x <= branch.upper:
                return False
            x = branch(x)
        return True

    @cached_property
    def doubles(self) -> MapLine:
        """The same map with its numbers rounded to doubles."""
        branches, owners = (
            tuple(AffinePiece._make((*map(to_double, piece[:4]), piece.letter)) for piece in pieces)
            for pieces in (self.branches, self.owners)
        )
        return MapLine(branches, owners)

    def owns(self, germs: Iterable[Germ]) -> bool:
        """Whether the points of germs belong to the branches on the sides of the germs."""
        pairs = ((self.piece(Germ(germ.x, 0)), self.piece(germ)) for germ in germs)
        return all(own.letter == beside.letter and not own.is_point for own, beside in pairs)

    def parts(self, interval: Interval) -> Iterator[tuple[AffinePiece, Interval]]:
        """Yield the parts into which breaks cut a nondegenerate interval, with their branches."""
        for k, part in cut_at(self.breaks, interval):
            yield self.branches[k], part

    def images(self, intervals: Iterable[Interval]) -> list[Interval]:
        """The union of the closures of the intervals' images; a point maps to its value."""
        found = list[Interval]()
        for low, high in intervals:
            if low == high:
                found.append((self(low),) * 2)
            else:
                found += [branch.over(part) for branch, part in self.parts((low, high))]
        return union(found)


def taken_into(whole: Affine, points: Interval, target: Interval) -> Interval | None:
    """The points of an open interval that an affine map takes into another; None if none."""
    slope, intercept = whole
    if not slope:
        return points if target[0] < intercept < target[1] else None
    low, high = ((end - intercept) / slope for end in target[:: sign(slope)])
    low, high = max(points[0], low), min(points[1], high)
    return (low, high) if low < high else None


def iterates(branches: Iterable[AffinePiece]) -> Iterator[AffinePiece]:
    """Yield the affine pieces of the iterates along the prefixes of a word."""
    whole, points = IDENTITY, (LOWEST, HIGHEST)
    for branch in branches:
        found = taken_into(whole, points, branch[2:4])
        if found is None:
            return
        whole, points = branch.after(whole), found
        yield AffinePiece(*whole, *points, "")


def cut_at(breaks: Sequence[Exact], interval: Interval) -> Iterator[tuple[int, Interval]]:
    """The parts into which breaks cut an interval, each after the index of its branch."""
    low, high = interval
    first, last = bisect_right(breaks, low), bisect_left(breaks, high)
    return enumerate(pairwise((low, *breaks[first:last], high)), start=first)


def union(intervals: Iterable[Interval]) -> list[Interval]:
    """The union of closed intervals as disjoint ones, from left to right.

    Ends may be of any comparable kind: numbers, cuts or doubles.
    """
    found = list[Interval]()
    for low, high in sorted(intervals, key=itemgetter(0)):
        if found and low <= found[-1][1]:
            if high > found[-1][1]:
                found[-1] = found[-1][0], high
        else:
            found.append((low, high))
    return found


def join(known: list[Interval], intervals: Iterable[Interval]) -> None:
    """Add closed intervals to the union of others, which are disjoint and sorted."""
    for low, high in intervals:
        first = bisect_left(known, low, key=itemgetter(1))
        last = bisect_right(known, high, first, key=itemgetter(0))
        if first < last:
            low, high = min(low, known[first][0]), max(high, known[last - 1][1])
        known[first:last] = [(low, high)]


def difference(intervals: Iterable[Interval], known: Sequence[Interval]) -> list[Interval]:
    """The closures of what ``known`` intervals, disjoint and sorted, leave of other intervals."""
    found = list[Interval]()
    for low, high in intervals:
        k = bisect_left(known, low, key=lambda each: each[1])
        start, ends = low, False
        while k < len(known) and known[k][0] <= high:
            if known[k][0] > start:
                found.append((start, known[k][0]))
            start, ends = known[k][1], True
            k += 1
        if start < high or (start == high and not ends):
            found.append((start, high))
    return found


def length(intervals: Iterable[Interval]) -> Exact:
    """The total length of intervals that do not overlap."""
    return sum((high - low for low, high in intervals), start=QQ.zero)


def line_of(map_: PiecewiseLinearMap, values: Mapping[Any, object] | None = None) -> MapLine:
    """The map at given values of all its parameters.

    Values are rationals by symbol or name; one may be algebraic, such as ``(1 + sqrt(5))/2``.
    ValueError if a value is missing, or several are algebraic, or one is and the map is an iterate;
    TypeError if ``map_`` is no map or a value is a float.
    """
    check_map(map_)
    values = {} if values is None else values
    check_mapping("values", values)
    rationals, roots = dict[str, object](), dict[str, RealRoot]()
    for name, value in values.items():
        own = str(own_name(name, map_.parameters))
        found = algebraic(value) if isinstance(value, sympy.Expr) else value
        if isinstance(found, RealRoot):
            roots[own] = found
        else:
            rationals[own] = QQ.to_sympy(found) if isinstance(value, sympy.Expr) else value
    map_ = map_.at(rationals) if rationals else map_
    missing = [str(each) for each in map_.parameters if str(each) not in roots]
    if missing:
        raise ValueError(f"every parameter needs a value, got none for {', '.join(missing)}")
    if not roots:
        return line_at(map_, QQ.zero)
    if len(roots) > 1:
        raise ValueError(f"one parameter may have an algebraic value, got {', '.join(roots)}")
    if map_.order > 1:
        raise ValueError(f"an algebraic value needs the map itself, got an iterate of {map_.order}")
    return line_at(map_, next(iter(roots.values())))


def line_at(map_: PiecewiseLinearMap, place: Real, *, admitted: bool = True) -> MapLine:
    """The map at a rational or algebraic value of its only parameter; an iterate must have none.

    ValueError if the value breaks an assumption, unless it need not be ``admitted``.
    """
    region = map_.definition.region
    broken = admitted and region.broken(lambda polynomial: sign_at(dense(polynomial), place))
    if broken:
        given = f"{map_.parameters[0]} = {real_to_sympy(place)}"
        raise ValueError(f"{given} contradicts the assumption {broken}")
    orbits = map_.orbits
    branches, owners = list[AffinePiece](), list[AffinePiece]()
    last: Exact = LOWEST
    for cylinder in map_.cylinders:
        word, upper = cylinder.word, cylinder.upper
        end: Exact = HIGHEST
        if upper is not None:
            end = quotient_of(orbits.preimage(upper.k, word[: upper.steps]), place)
        slope = quotient_of(orbits.slope(word), place)
        intercept = quotient_of(orbits.intercept(word), place)
        piece = AffinePiece(slope, intercept, last, end, map_.spelled(word))
        if cylinder.is_point:
            owners.append(piece._replace(upper=last))
            continue
        if last != LOWEST and cylinder.lower_closed:
            owners.append(piece)
        branches.append(piece)
        if cylinder.upper_closed:
            owners.append(piece)
        last = end
    return MapLine(tuple(branches), tuple(owners))


Cut = tuple[Exact, int]  # a number, and -1 just below it or +1 just above it
Part = tuple[Cut, Cut]  # an interval or a point: from a cut to a higher one


@dataclass(frozen=True, eq=False)
class PointSet:
    """A finite union of intervals and points of the line."""

    parts: tuple[Part, ...] = ()  # disjoint, from left to right; no two share a cut

    def __contains__(self, x: Exact) -> bool:
        return self.covers(((x, -1), (x, 1)))

    def covers(self, part: Part) -> bool:
        """Whether the set contains an interval or a point."""
        return any(low <= part[0] and part[1] <= high for low, high in self.parts)

    def surrounds(self, x: Exact) -> bool:
        """Whether x is an interior point of the set."""
        cuts = ((x, -1), (x, 1))
        return all(any(low < cut < high for low, high in self.parts) for cut in cuts)

    def has(self, other: PointSet) -> bool:
        """Whether the set contains another one."""
        return all(map(self.covers, other.parts))

    def __or__(self, other: PointSet) -> PointSet:
        return point_set((*self.parts, *other.parts))

    @property
    def closure(self) -> PointSet:
        """The closure of the set."""
        return closed_intervals((low[0], high[0]) for low, high in self.parts)

    @property
    def interior(self) -> tuple[Interval, ...]:
        """The endpoints of the intervals of the set; single points are left out."""
        return tuple((low[0], high[0]) for low, high in self.parts if low[0] != high[0])

    def to_sympy(self) -> tuple[sympy.Set, ...]:
        """The parts as sympy intervals and one-point sets."""
        return tuple(map(part_to_sympy, self.parts))


def point_set(parts: Iterable[Part]) -> PointSet:
    """The union of intervals and points, given in any order."""
    return PointSet(tuple(union(parts)))


def open_intervals(intervals: Iterable[Interval]) -> PointSet:
    """The union of open intervals."""
    return point_set(((low, 1), (high, -1)) for low, high in intervals)


def closed_intervals(intervals: Iterable[Interval]) -> PointSet:
    """The union of closed intervals, which may be single points."""
    return point_set(((low, -1), (high, 1)) for low, high in intervals)


def preimage(line: MapLine, target: PointSet, breaks: Iterable[Exact]) -> PointSet:
    """The preimage of a set; of the breaks, only the given ones are considered."""
    found = [part for branch in line.branches for part in drawn_back(branch, target)]
    found += [((x, -1), (x, 1)) for x in breaks if line(x) in target]
    return point_set(found)


def drawn_back(branch: AffinePiece, target: PointSet) -> Iterator[Part]:
    """Yield the parts of a branch's open domain that are mapped into a set."""
    whole: Part = ((branch.lower, 1), (branch.upper, -1))
    if not branch.slope:
        if branch.intercept in target:
            yield whole
        return
    way = sign(branch.slope)
    for part in target.parts:
        low, high = (((x - branch.intercept) / branch.slope, way * side) for x, side in part[::way])
        low, high = max(low, whole[0]), min(high, whole[1])
        if low < high:
            yield low, high


def part_to_sympy(part: Part) -> sympy.Set:
    """A part as a sympy interval, or one-point set."""
    (low, after), (high, before) = part
    ends = real_to_sympy(low), real_to_sympy(high)
    return sympy.Interval(*ends, left_open=after > 0, right_open=before < 0)
