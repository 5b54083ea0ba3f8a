"""A piecewise-linear map of the line at one place of its parameters, in exact numbers.

A *germ* is a point with a side: the orbits of all points close to it on that side, as long as no
break cuts them. It maps to a germ, by the piece on its side, or to a point if that piece is flat.
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
from pwmap.algebra.roots import Real, RealRoot, algebraic, real_to_sympy, value_at
from pwmap.algebra.terms import own_name
from pwmap.longrun.numbers import Element, Exact
from pwmap.maps.piecewise_linear import PiecewiseLinearMap, check_map

IDENTITY = Affine(QQ.one, QQ.zero)
Interval = tuple[Exact, Exact]  # closed; both ends may be the same


class Germ(NamedTuple):
    """A point with a side: -1 left of it, +1 right of it, 0 the point itself."""

    x: Exact
    side: int


class AffinePiece(NamedTuple):
    """One affine piece on an open interval: slope x + intercept between two ends."""

    slope: Exact
    intercept: Exact
    lower: Exact
    upper: Exact
    letter: str

    def __call__(self, x: Exact) -> Exact:
        """The value of its formula at a point."""
        return self.slope * x + self.intercept

    def after(self, first: Affine) -> Affine:
        """Its formula after another map."""
        return Affine(*self[:2]).after(first)

    def over(self, interval: Interval) -> Interval:
        """The image of an interval within its ends."""
        first, last = self(interval[0]), self(interval[1])
        return (first, last) if first <= last else (last, first)


class Owner(NamedTuple):
    """The piece that a break belongs to, and its slope; None if it is a piece of its own."""

    letter: str
    slope: Exact | None


@dataclass(frozen=True, eq=False)
class MapLine:
    """A map at one place of its parameters."""

    branches: tuple[AffinePiece, ...]  # on open intervals, from left to right
    values: tuple[Exact, ...]  # at each break between two of them
    owners: tuple[Owner, ...]  # of each break

    @cached_property
    def breaks(self) -> tuple[Exact, ...]:
        """Ends of branches, from left to right."""
        return tuple(branch.upper for branch in self.branches[:-1])

    @cached_property
    def germs(self) -> tuple[Germ, ...]:
        """Both sides of all breaks."""
        return tuple(Germ(x, side) for x in self.breaks for side in (-1, 1))

    def number(self, germ: Germ) -> int:
        """The number of the branch on the side of a germ; for a point within a branch of that."""
        return (bisect_left if germ.side < 0 else bisect_right)(self.breaks, germ.x)

    def beside(self, germ: Germ) -> AffinePiece:
        """The branch on the side of a germ; for a point within a branch that branch."""
        return self.branches[self.number(germ)]

    def image(self, germ: Germ) -> Germ:
        """Where a germ maps to."""
        return self.step(germ)[1]

    def step(self, germ: Germ) -> tuple[str, Germ]:
        """The letter of the piece that a germ is mapped by, and where it maps to."""
        if not germ.side:
            return self.letter(germ), Germ(self(germ.x), 0)
        branch = self.beside(germ)
        return branch.letter, Germ(branch(germ.x), germ.side * sign(branch.slope))

    def __call__(self, x: Exact) -> Exact:
        """The value at a point."""
        k = bisect_left(self.breaks, x)
        if k < len(self.breaks) and self.breaks[k] == x:
            return self.values[k]
        return self.branches[k](x)

    def piece(self, x: Exact) -> Owner:
        """The piece in which a point lies."""
        k = bisect_left(self.breaks, x)
        if k < len(self.breaks) and self.breaks[k] == x:
            return self.owners[k]
        return Owner(self.branches[k].letter, self.branches[k].slope)

    def letter(self, germ: Germ) -> str:
        """The letter of the piece that a germ is mapped by; at a break itself that of its value."""
        return self.beside(germ).letter if germ.side else self.piece(germ.x).letter

    def parts(self, interval: Interval) -> Iterator[tuple[AffinePiece, Interval]]:
        """An interval, longer than a point, cut at the breaks inside it."""
        for k, part in cut_at(self.breaks, interval):
            yield self.branches[k], part

    def images(self, intervals: Iterable[Interval]) -> list[Interval]:
        """The closures of the images of intervals, joined; a point maps to its value."""
        found = list[Interval]()
        for low, high in intervals:
            if low == high:
                value = self(low)
                found.append((value, value))
                continue
            found += [branch.over(part) for branch, part in self.parts((low, high))]
        return joined(found)


def cut_at(breaks: Sequence[Exact], interval: Interval) -> Iterator[tuple[int, Interval]]:
    """The parts of an interval between breaks, with the numbers of their pieces."""
    low, high = interval
    first, last = bisect_right(breaks, low), bisect_left(breaks, high)
    return enumerate(pairwise((low, *breaks[first:last], high)), start=first)


def joined(intervals: Iterable[Interval]) -> list[Interval]:
    """The same set as intervals that do not touch, from left to right."""
    found = list[Interval]()
    for low, high in sorted(intervals, key=lambda each: each[0]):
        if found and low <= found[-1][1]:
            if high > found[-1][1]:
                found[-1] = found[-1][0], high
        else:
            found.append((low, high))
    return found


def add(known: list[Interval], new: Iterable[Interval]) -> None:
    """Put more intervals to some that are sorted and do not touch; they stay so."""
    for low, high in new:
        first = last = bisect_left(known, low, key=lambda each: each[1])
        while last < len(known) and known[last][0] <= high:
            last += 1
        if first < last:
            low, high = min(low, known[first][0]), max(high, known[last - 1][1])
        known[first:last] = [(low, high)]


def outside(intervals: Iterable[Interval], known: Sequence[Interval]) -> list[Interval]:
    """Closures of the parts of intervals that known ones, sorted and apart, do not cover."""
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
    ValueError if one is missing, several are algebraic, or of an iterate; TypeError if it is no
    map, or a value is a float.
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
        return _of_pieces(map_)
    if len(roots) > 1:
        raise ValueError(f"one parameter may have an algebraic value, got {', '.join(roots)}")
    if map_.order > 1:
        raise ValueError(f"an algebraic value needs the map itself, got an iterate of {map_.order}")
    return line_at(map_, next(iter(roots.values())))


def _of_pieces(map_: PiecewiseLinearMap) -> MapLine:
    """A map, or an iterate, whose parameters have rational values."""
    orbits, branches = map_.orbits, list[AffinePiece]()
    values, owners = list[Exact](), list[Owner]()

    def quotient(fraction: tuple[Any, Any]) -> Exact:
        return fraction[0] / fraction[1]

    last: Exact = LOWEST
    for cylinder in map_.cylinders:
        slope, intercept = (
            quotient(orbits.slope(cylinder.word)),
            quotient(orbits.intercept(cylinder.word)),
        )
        upper = cylinder.upper
        end = (
            HIGHEST
            if upper is None
            else quotient(orbits.preimage(upper.k, cylinder.word[: upper.steps]))
        )
        letter = map_.spelled(cylinder.word)
        if cylinder.is_point or (last != LOWEST and cylinder.lower_closed):
            values.append(slope * last + intercept)
            owners.append(Owner(letter, None if cylinder.is_point else slope))
        if cylinder.is_point:
            continue
        branches.append(AffinePiece(slope, intercept, last, end, letter))
        if cylinder.upper_closed:
            values.append(slope * end + intercept)
            owners.append(Owner(letter, slope))
        last = end
    return MapLine(tuple(branches), tuple(values), tuple(owners))


def line_at(map_: PiecewiseLinearMap, place: Real) -> MapLine:
    """A map at a rational or algebraic value of its parameter; ValueError if that is excluded."""
    table, ring = map_.definition.table, map_.definition.ring

    def element(polynomial: Any) -> Exact:
        coefficients = dense(polynomial)
        if isinstance(place, RealRoot):
            return Element(place, place.reduced(coefficients))
        return value_at(coefficients, place)

    broken = map_.definition.region.broken(lambda polynomial: sign(element(polynomial)))
    if broken is not None:
        value = f"{ring.symbols[0]} = {real_to_sympy(place)}"
        raise ValueError(f"{value} contradicts the assumption {broken}")
    bottom = element(table.denominator)
    slopes, intercepts, breaks = (
        [element(each) / bottom for each in group]
        for group in (table.slopes, table.intercepts, table.breaks)
    )
    layout = table.layouts[map_.chain[0]]
    cuts = [LOWEST, *(breaks[k] for k in layout.breaks), HIGHEST]
    branches = tuple(
        AffinePiece(slopes[letter], intercepts[letter], cuts[i], cuts[i + 1], map_.letters[letter])
        for i, letter in enumerate(layout.slots[::2])
    )
    values = tuple(
        slopes[letter] * x + intercepts[letter]
        for letter, x in zip(layout.slots[1::2], cuts[1:-1], strict=True)
    )
    owners = tuple(
        Owner(map_.letters[here], slopes[here] if here in (left, right) else None)
        for left, here, right in zip(
            layout.slots[:-1:2], layout.slots[1::2], layout.slots[2::2], strict=True
        )
    )
    return MapLine(branches, values, owners)
