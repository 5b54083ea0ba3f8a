"""A piecewise-linear map of the line at one place of its parameters, and sets of exact numbers.

A *germ* is a point with a side. It stands for all points close enough to it on that side, and is
mapped by the piece on that side to a germ, or to a point if the piece is flat.

A set is a finite union of intervals and points, with or without their ends. An end is a *cut*: just
below (-1) or just above (+1) a number. An interval [a, b) lies between the cuts just below a and
just below b, a point between the two cuts beside it. So all parts are of one kind, and cuts are
compared as pairs.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
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
    """An affine piece on an open interval or at a point: slope x + intercept between its ends."""

    slope: Exact
    intercept: Exact
    lower: Exact
    upper: Exact
    letter: str

    def __call__(self, x: Exact) -> Exact:
        """The value of its formula at a point."""
        return self.slope * x + self.intercept

    def image(self, germ: Germ) -> Germ:
        """The image of a germ by its formula."""
        return Germ(self(germ.x), germ.side * sign(self.slope))

    def after(self, first: Affine) -> Affine:
        """Its formula after another map."""
        return Affine(*self[:2]).after(first)

    @property
    def is_point(self) -> bool:
        """Whether its domain is one point."""
        return bool(self.lower == self.upper)

    def over(self, interval: Interval) -> Interval:
        """The image of an interval within its ends."""
        first, last = self(interval[0]), self(interval[1])
        return (first, last) if first <= last else (last, first)


@dataclass(frozen=True, eq=False)
class MapLine:
    """A map at one place of its parameters."""

    branches: tuple[AffinePiece, ...]  # on open intervals, from left to right
    owners: tuple[AffinePiece, ...]  # of the breaks: a branch beside each, or a piece of one point

    @cached_property
    def breaks(self) -> tuple[Exact, ...]:
        """The ends of branches, from left to right."""
        return tuple(branch.upper for branch in self.branches[:-1])

    @cached_property
    def germs(self) -> tuple[Germ, ...]:
        """Both sides of all breaks, from left to right."""
        return tuple(Germ(x, side) for x in self.breaks for side in (-1, 1))

    def number(self, germ: Germ) -> int:
        """The number of the branch on the side of a germ; of a break itself that on the left."""
        return (bisect_left if germ.side <= 0 else bisect_right)(self.breaks, germ.x)

    def piece(self, germ: Germ) -> AffinePiece:
        """The branch on the side of a germ, or the piece that contains a point."""
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
        """A germ and its images, without end."""
        while True:
            yield germ
            germ = self.image(germ)

    def along(self, word: Iterable[int]) -> Affine:
        """The map along the branches that a word names by their numbers."""
        first, *others = word
        whole = Affine(*self.branches[first][:2])
        for k in others:
            whole = self.branches[k].after(whole)
        return whole

    def follows(self, x: Exact, word: Iterable[int]) -> bool:
        """Whether a point and its images lie in the closures of the branches of a word."""
        for k in word:
            branch = self.branches[k]
            if not branch.lower <= x <= branch.upper:
                return False
            x = branch(x)
        return True

    @cached_property
    def doubles(self) -> MapLine:
        """The same map, in doubles."""
        branches, owners = (
            tuple(AffinePiece._make((*map(to_double, piece[:4]), piece.letter)) for piece in pieces)
            for pieces in (self.branches, self.owners)
        )
        return MapLine(branches, owners)

    def parts(self, interval: Interval) -> Iterator[tuple[AffinePiece, Interval]]:
        """The parts of an interval, longer than a point, between breaks, with their branches."""
        for k, part in cut_at(self.breaks, interval):
            yield self.branches[k], part

    def images(self, intervals: Iterable[Interval]) -> list[Interval]:
        """The closures of the images of intervals, joined; a point maps to its value."""
        found = list[Interval]()
        for low, high in intervals:
            if low == high:
                found.append((self(low),) * 2)
            else:
                found += [branch.over(part) for branch, part in self.parts((low, high))]
        return joined(found)


def cut_at(breaks: Sequence[Exact], interval: Interval) -> Iterator[tuple[int, Interval]]:
    """The parts of an interval between breaks, with the numbers of their pieces."""
    low, high = interval
    first, last = bisect_right(breaks, low), bisect_left(breaks, high)
    return enumerate(pairwise((low, *breaks[first:last], high)), start=first)


def joined(intervals: Iterable[Interval]) -> list[Interval]:
    """The union of intervals as ones that do not touch, from left to right.

    Ends may be of any kind that can be compared.
    """
    found = list[Interval]()
    for low, high in sorted(intervals, key=lambda each: each[0]):
        if found and low <= found[-1][1]:
            if high > found[-1][1]:
                found[-1] = found[-1][0], high
        else:
            found.append((low, high))
    return found


def outside(intervals: Iterable[Interval], known: Sequence[Interval]) -> list[Interval]:
    """The closures of the parts of intervals that known ones, sorted and apart, do not cover."""
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
    """A map at one place of its parameters.

    Values are rationals by symbol or name, and one may be algebraic, such as ``(1 + sqrt(5))/2``.
    ValueError if a value is missing, several are algebraic, or one is so for an iterate; TypeError
    if it is no map, or a value is a float.
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
    """A map at a rational or algebraic value of its parameter; an iterate must have none.

    ValueError if the value is excluded, unless it need not be ``admitted``.
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
Part = tuple[Cut, Cut]  # from a cut to a higher one


@dataclass(frozen=True, eq=False)
class PointSet:
    """A set of numbers."""

    parts: tuple[Part, ...] = ()  # apart, from left to right; two never have a cut in common

    def __contains__(self, x: Exact) -> bool:
        return self.covers(((x, -1), (x, 1)))

    def covers(self, part: Part) -> bool:
        """Whether it contains an interval or a point."""
        return any(low <= part[0] and part[1] <= high for low, high in self.parts)

    def surrounds(self, x: Exact) -> bool:
        """Whether it contains all points close enough to a number, on both sides."""
        cuts = ((x, -1), (x, 1))
        return all(any(low < cut < high for low, high in self.parts) for cut in cuts)

    def has(self, other: PointSet) -> bool:
        """Whether it contains another set."""
        return all(map(self.covers, other.parts))

    def __or__(self, other: PointSet) -> PointSet:
        return point_set((*self.parts, *other.parts))

    @property
    def closure(self) -> PointSet:
        """The set with all ends."""
        return closed_intervals((low[0], high[0]) for low, high in self.parts)

    @property
    def interior(self) -> tuple[Interval, ...]:
        """The ends of its intervals, without its single points."""
        return tuple((low[0], high[0]) for low, high in self.parts if low[0] != high[0])

    def to_sympy(self) -> tuple[sympy.Set, ...]:
        """Its parts as intervals and points of sympy."""
        return tuple(map(part_to_sympy, self.parts))


def point_set(parts: Iterable[Part]) -> PointSet:
    """The union of intervals and points in any order."""
    return PointSet(tuple(joined(parts)))


def open_intervals(intervals: Iterable[Interval]) -> PointSet:
    """The union of open intervals."""
    return point_set(((low, 1), (high, -1)) for low, high in intervals)


def closed_intervals(intervals: Iterable[Interval]) -> PointSet:
    """The union of closed intervals; both ends may be the same."""
    return point_set(((low, -1), (high, 1)) for low, high in intervals)


def preimage(line: MapLine, target: PointSet, breaks: Iterable[Exact]) -> PointSet:
    """All numbers that a map takes into a set; of the breaks, only the given ones are tried."""
    found = [part for branch in line.branches for part in drawn_back(branch, target)]
    found += [((x, -1), (x, 1)) for x in breaks if line(x) in target]
    return point_set(found)


def drawn_back(branch: AffinePiece, target: PointSet) -> Iterator[Part]:
    """The parts of a piece's open interval that it takes into a set."""
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
    """An interval or a point of sympy."""
    (low, after), (high, before) = part
    ends = real_to_sympy(low), real_to_sympy(high)
    return sympy.Interval(*ends, left_open=after > 0, right_open=before < 0)
