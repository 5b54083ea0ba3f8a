"""Attractors over one parameter: cells in which they do not change, and crises between these.

Bands end in images of breaks, and they change where such an image meets a point of a repelling
cycle [Grebogi1982]: then two bands merge, an attractor becomes larger at once, or it is lost.
Images and cycles are named by words, so these places are roots of polynomials. An interval of the
parameter is cut wherever an image up to some order meets a break or a cycle, and what attracts is
asked once in each part, at a rational place. Where that differs between two parts, and no word up
to that order says why, the interval between them is halved until longer words do.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import pairwise, starmap
from typing import Any, NamedTuple

import sympy
from sympy import QQ

from pwmap.algebra.exact import (
    Fraction_,
    Number,
    dense,
    quotient_to_sympy,
    to_sympy,
)
from pwmap.algebra.exact import fraction_to_sympy as shown_fraction
from pwmap.algebra.roots import (
    Dense,
    Real,
    RealRoot,
    bounds,
    may_vanish,
    real_roots,
    real_to_sympy,
    sign_at,
    simplest_between,
)
from pwmap.algebra.terms import own_name, shortened
from pwmap.diagrams.diagram import PointKind
from pwmap.longrun.attractors import Attractors, attractors_of
from pwmap.longrun.cycles import repelling_words
from pwmap.longrun.dynamics import Dynamics
from pwmap.longrun.line import Germ, Interval, Line, joined, line_of
from pwmap.longrun.numbers import Element, Exact, to_double
from pwmap.maps.piecewise_linear import PiecewiseLinearMap, checked_order
from pwmap.maps.words import CriticalOrbit, Multiplier, Slope, Word
from pwmap.parameters.admitted import admitted_intervals
from pwmap.parameters.axes import axis_of
from pwmap.parameters.axis import Axis
from pwmap.parameters.cells import checked_span

LONGEST = (8, 16, 32, 64)  # orders of images of breaks that are compared where attractors differ:
# the shortest that meet a cycle there are taken
PARTS = 16  # into which an interval is cut, whatever happens in it
TRIED = 4  # halvings after which longer words are tried again
MANY = 12  # places that they may name: more are looked at in a shorter interval
BESIDE = (2**8, 2**5, 2**2)  # parts of a distance: so close to a place lies what is beside it
HALVINGS = 24  # of an interval in which they do, at most
PERIOD = 8  # of cycles that are compared there, at least
SAME = 1e-4  # of their length: so little may bands differ that are the same, with other names


@dataclass(frozen=True, eq=False)
class AttractorCell:
    """An interval of a parameter in which the same words describe all attractors.

    Attributes
    ----------
    lower, upper
        Exact ends; they do not belong to it.
    sample
        A rational value inside.
    cycles
        Words of the attracting cycles.
    bands
        For each chaotic attractor its bands at the sample, from left to right: formulas for both
        ends, which hold beside it as long as the same images of breaks are the outermost.
    line
        The map at the sample.
    is_open
        Whether something is not known there; then crises may have been missed in the cell.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, attractor_diagram
    >>> tent = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
    >>> found = attractor_diagram(tent, "a", ("4/3", "3/2"), 1)
    >>> [(str(cell.lower), str(cell.upper), len(cell.bands[0])) for cell in found.cells]
    [('4/3', 'sqrt(2)', 2), ('sqrt(2)', '3/2', 1)]
    """

    lower: sympy.Expr
    upper: sympy.Expr
    sample: sympy.Rational
    cycles: tuple[str, ...]
    bands: tuple[tuple[tuple[sympy.Expr, sympy.Expr], ...], ...]
    line: Line
    is_open: bool = False

    @cached_property
    def dynamics(self) -> Dynamics:
        """The long run at the sample."""
        return Dynamics(self.line)


class Meeting(NamedTuple):
    """A break's image that is a point of a cycle, as :func:`meeting_curve` takes it.

    Attributes
    ----------
    number
        Which break, counted from the left.
    image
        The word along which it goes.
    cycle
        The word of the cycle from that point on.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, attractor_diagram, meeting_curve
    >>> tent = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
    >>> crisis, = attractor_diagram(tent, "a", ("4/3", "3/2"), 1).crises
    >>> meeting = crisis.meetings[0]
    >>> meeting.image, meeting.cycle
    ('LRLRRRRR', 'R')
    """

    number: int
    image: str
    cycle: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Crisis:
    """A value of a parameter at which attractors change.

    Attributes
    ----------
    parameter
        Exact; if it is open, in the middle of where it lies.
    kind
        MC: bands merge; XC: bands become larger at once; FC: bands are lost; BC and PD: bands give
        way to a cycle that meets a break, or has the multiplier -1 there.
    bands
        How many there are on the left and on the right.
    meetings
        Images of breaks that meet repelling cycles there.
    width
        Of the interval in which it lies; zero if it is exact.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, attractor_diagram
    >>> tent = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
    >>> merging, = attractor_diagram(tent, "a", ("4/3", "3/2"), 1).crises
    >>> print(merging.kind, merging.parameter, merging.bands)  # two bands become one
    MC sqrt(2) (2, 1)
    """

    parameter: sympy.Expr
    kind: PointKind
    bands: tuple[int, int]
    meetings: tuple[Meeting, ...]
    width: float = 0.0

    @property
    def cycles(self) -> tuple[str, ...]:
        """Words of the cycles that are met, each from its first letter in the alphabet on."""
        return tuple(sorted({_first_turn(each.cycle) for each in self.meetings}, key=_by_length))

    @property
    def images(self) -> tuple[str, ...]:
        """Words along which breaks go to these."""
        return tuple(sorted({each.image for each in self.meetings}, key=_by_length))


@dataclass(frozen=True, kw_only=True, eq=False)
class AttractorDiagram:
    """Attractors over an interval of a parameter.

    Attributes
    ----------
    map
        The map.
    parameter
        The symbol.
    order
        Up to which images of breaks are compared with breaks and cycles everywhere.
    cells
        From left to right.
    crises
        Of chaotic attractors, from left to right. Other bifurcations of attracting cycles separate
        cells, too; they are in :func:`pwmap.bifurcation_diagram`.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, attractor_diagram
    >>> tent = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
    >>> found = attractor_diagram(tent, "a", ("4/3", "3/2"), 1)
    >>> [(str(crisis.kind), crisis.parameter) for crisis in found.crises]
    [('MC', sqrt(2))]
    >>> [(str(cell.lower), str(cell.upper)) for cell in found.cells]
    [('4/3', 'sqrt(2)'), ('sqrt(2)', '3/2')]
    """

    map: PiecewiseLinearMap
    parameter: sympy.Symbol
    order: int
    cells: tuple[AttractorCell, ...]
    crises: tuple[Crisis, ...]

    def __repr__(self) -> str:
        """The interval, and the crises in it."""
        low, high = self.cells[0].lower, self.cells[-1].upper
        crises = shortened(", ".join(f"{c.kind} {c.parameter}" for c in self.crises) or "none", 160)
        return (
            f"AttractorDiagram({self.parameter} in [{low}, {high}], {len(self.cells)} cells, "
            f"crises: {crises})"
        )


@dataclass(frozen=True, slots=True)
class _Image:
    """An image of a break: its number, and the word along which it went."""

    k: int
    word: Word


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """A part of the axis in which the words of images are constant."""

    low: Real
    high: Real
    words: tuple[Word, ...]  # of each germ, as far as it was followed


@dataclass(frozen=True, slots=True, eq=False)
class _Seen:
    """What attracts at a place."""

    place: Number
    line: Line
    found: Attractors
    ends: tuple[tuple[tuple[_Image, _Image], ...], ...]
    cycles: tuple[str, ...]

    @property
    def counts(self) -> tuple[int, ...]:
        """How many bands each chaotic attractor has."""
        return tuple(sorted(map(len, self.found.bands)))


@dataclass(frozen=True, slots=True, eq=False)
class _Change:
    """A place at which what attracts changes, or an interval around it, and what meets there.

    Attributes
    ----------
    is_open
        Whether it is not known in the interval what attracts: then there may be several changes.
    """

    low: Real
    high: Real
    met: tuple[tuple[_Image, Word], ...] = ()
    is_open: bool = False

    @property
    def place(self) -> Real:
        """The place, or the middle."""
        return self.low if self.low == self.high else simplest_between(self.low, self.high)


def attractor_diagram(
    map_: PiecewiseLinearMap,
    parameter: object,
    span: tuple[object, object],
    order: int = 5,
) -> AttractorDiagram:
    """Attracting cycles and bands over an interval of a parameter, with their crises, exactly.

    Parameters
    ----------
    map_
        A map whose other parameters have values.
    parameter
        Symbol or name.
    span
        Two rationals.
    order
        Up to which images of breaks are compared with breaks, and with repelling cycles of periods
        up to that, everywhere. All changes by such words are found; of changes by longer ones those
        which do not undo each other between two of these places.

    Returns
    -------
    AttractorDiagram
        Cells of the parameter from left to right, each with what attracts there, and the crises
        between them.

    Raises
    ------
    ValueError
        If the map has other parameters, or is an iterate, or the span is no interval.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, attractor_diagram
    >>> tent = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
    >>> for crisis in attractor_diagram(tent, "a", ("4/3", "3/2"), 1).crises:
    ...     print(crisis.kind, crisis.parameter, crisis.bands)
    MC sqrt(2) (2, 1)
    """
    order = checked_order(order)
    name = str(own_name(parameter, map_.parameters))
    names = [str(symbol) for symbol in map_.parameters]
    if names != [name]:
        raise ValueError(f"expected a map of {name} alone, this one has {names or 'no parameters'}")
    if map_.order > 1:
        raise ValueError(f"expected the map itself, got an iterate of order {map_.order}")
    ends = checked_span(span)
    axis = axis_of(map_.definition, name, {})
    admitted_intervals(axis, ends)
    cells, crises = Study(map_, name, axis, order).cells(*ends)
    return AttractorDiagram(
        map=map_, parameter=map_.parameters[0], order=order, cells=cells, crises=crises
    )


def meeting_curve(map_: PiecewiseLinearMap, image: str, cycle: str, number: int = 0) -> sympy.Expr:
    """The polynomial in a map's parameters that is zero where a break's image meets a cycle.

    Where a crisis is known at one value, this is its curve in more parameters.

    Parameters
    ----------
    map_
        The map; all of its parameters may be free.
    image
        The word along which the break goes, as :attr:`Crisis.images` has it.
    cycle
        A word of the cycle, whose point it is at which the word starts.
    number
        Which break, counted from the left.

    Returns
    -------
    sympy.Expr
        With integer factors left out, factored.

    Raises
    ------
    ValueError
        If a word is empty or has an unknown letter, or there is no such break.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, meeting_curve
    >>> skew = PiecewiseLinearMap.from_sympy("Piecewise((a*x + 1, x <= 0), (b*x + 1, True))")
    >>> meeting_curve(skew, "LRL", "R")
    a*b**2 - a + b
    """
    polynomial = meeting_polynomial(map_, Meeting(number, image, cycle))
    _, factors = sympy.factor_list(to_sympy(polynomial))
    return sympy.Mul(*(factor for factor, _ in factors)) if factors else sympy.Integer(0)


def meeting_polynomial(map_: PiecewiseLinearMap, meeting: Meeting) -> Number:
    """A polynomial in a map's parameters that is zero where a break's image meets a cycle."""
    breaks = map_.definition.table.layouts[map_.chain[0]].breaks
    number = meeting.number
    if not 0 <= number < len(breaks):
        raise ValueError(f"number must name one of {len(breaks)} breaks, from 0 on, got {number}")
    along, around = (tuple(_numbers(map_, word)) for word in (meeting.image, meeting.cycle))
    value = map_.orbits.value(breaks[number], along)
    fixed = map_.orbits.fixed_point(around)
    return value[0] * fixed[1] - fixed[0] * value[1]


def meeting_x(map_: PiecewiseLinearMap, meeting: Meeting) -> sympy.Expr:
    """Where an image of a break meets a cycle: the point of the cycle as a formula."""
    return shown_fraction(map_.orbits.fixed_point(tuple(_numbers(map_, meeting.cycle))))


def _numbers(map_: PiecewiseLinearMap, word: str) -> Iterator[int]:
    """The letters of a word as numbers."""
    if not word:
        raise ValueError("a word must have at least one letter")
    for letter in word:
        if letter not in map_.letters:
            raise ValueError(f"{letter!r} is no piece of this map, it has {map_.letters}")
        yield map_.letters.index(letter)


class Study:
    """A map over one parameter, with what attracts at places of it.

    Parameters
    ----------
    map_, name, axis
        The map, its parameter, and that as an axis.
    order
        Up to which images of breaks are compared everywhere.
    """

    def __init__(self, map_: PiecewiseLinearMap, name: str, axis: Axis, order: int) -> None:
        self.map, self.name, self.axis, self.order = map_, name, axis, order
        self.orbits = axis.orbits
        self.layout = map_.definition.table.layouts[map_.chain[0]]
        self.letters = self.layout.slots[::2]
        self.germs = [(k, side) for k in self.layout.breaks for side in (-1, 1)]

    # --- Cutting ------------------------------------------------------------------------------

    def cells(
        self, low: Number, high: Number
    ) -> tuple[tuple[AttractorCell, ...], tuple[Crisis, ...]]:
        """Parts of an interval in which nothing changes, and what happens between them."""
        cuts: set[Real] = {low + (high - low) * QQ(k, PARTS) for k in range(PARTS + 1)}
        met = dict[Real, list[tuple[_Image, Word]]]()
        for part in self._followed(low, high):
            cuts |= {part.low, part.high}
            sample = self.axis.between(part.low, part.high)
            images = {
                _Image(k, word[:n])
                for (k, _), word in zip(self.germs, part.words, strict=True)
                for n in range(1, len(word) + 1)
            }
            for image, cycle, roots in self._meetings(
                part.low, part.high, sample, images, self.order
            ):
                for root in roots:
                    if part.low <= root <= part.high:
                        cuts.add(root)
                        met.setdefault(root, []).append((image, cycle))
        places = sorted(cuts)
        seen = [self._sampled(a, b) for a, b in pairwise(places)]
        ends = self._beside(low, seen[0].place), self._beside(high, seen[-1].place)
        row = [(ends[0], None), *zip(seen, (None, *places[1:-1]), strict=True), (ends[1], None)]
        known = [number for number, (here, _) in enumerate(row) if not here.found.open]
        if not known:
            return (self._open_cell(low, high),), ()
        first, last = (row[number][0] for number in (known[0], known[-1]))
        shown, crises = list[AttractorCell](), list[Crisis]()
        start = low
        if known[0] > 0:
            shown.append(self._open_cell(low, first.place))
            start = first.place
        for one, other in pairwise(known):
            left, (right, root) = row[one][0], row[other]
            changes = (
                self._changes(left, right, _Change(root, root, tuple(met.get(root, ()))))
                if root is not None and other == one + 1
                else self._halved(left, right, HALVINGS)
            )
            for change, before, after in changes:
                kind = None if change.is_open else self._kind(before, after, change)
                if kind is None and before.cycles == after.cycles and not change.is_open:
                    continue
                if change.is_open:
                    shown += [
                        self._cell(start, change.low, before),
                        self._open_cell(change.low, change.high),
                    ]
                    start = change.high
                    continue
                shown.append(self._cell(start, change.place, before))
                start = change.place
                if kind is not None:
                    crises.append(self._crisis(before, after, kind, change))
        if known[-1] == len(row) - 1:
            shown.append(self._cell(start, high, last))
        else:
            shown += [self._cell(start, last.place, last), self._open_cell(last.place, high)]
        return tuple(shown), tuple(crises)

    def _sampled(self, low: Real, high: Real) -> _Seen:
        """What attracts at a simple place of an interval; at another one if it is open there.

        The simplest places are just those at which cycles flip or collide.
        """
        first, last = bounds(low)[1], bounds(high)[0]
        third = (last - first) / 3
        for part in ((low, high), (low, first + third), (last - third, high)):
            found = self.seen(simplest_between(*part))
            if not found.found.open:
                break
        return found

    def _changes(
        self, left: _Seen, right: _Seen, known: _Change
    ) -> Iterator[tuple[_Change, _Seen, _Seen]]:
        """Where what attracts changes between two places; the place known between them is tried.

        If it does not explain the change, the intervals on both sides of it are halved.
        """
        if self._same(left, right):
            return
        near = [self._beside(known.place, left.place), self._beside(known.place, right.place)]
        if any(each.found.open for each in near):
            yield from self._halved(left, right, HALVINGS)
            return
        yield from self._halved(left, near[0], HALVINGS)
        if not self._same(*near):
            yield known, near[0], near[1]
        yield from self._halved(near[1], right, HALVINGS)

    def _beside(self, place: Real, other: Number) -> _Seen:
        """What attracts right beside a place, on the side of another one; farther if it is open."""
        end = bounds(place)[0 if other < place else 1]
        for part in BESIDE:
            near = end + (other - end) * QQ(1, part)
            found = self.seen(simplest_between(*sorted((place, near))))
            if not found.found.open:
                break
        return found

    def _halved(
        self, left: _Seen, right: _Seen, times: int
    ) -> Iterator[tuple[_Change, _Seen, _Seen]]:
        """Where what attracts changes between two places, by halving the interval."""
        if self._same(left, right):
            return
        found = [] if times % TRIED else self._ended(left, right) or self._located(left, right)
        if found:
            yield from found
        elif times:
            third = (right.place - left.place) / 3
            middle = self._sampled(left.place + third, right.place - third)
            if not middle.found.open:
                yield from self._halved(left, middle, times - 1)
                yield from self._halved(middle, right, times - 1)
                return
            found = self._ended(left, right) or self._located(left, right)
            yield from found or [(_Change(left.place, right.place, is_open=True), left, right)]
        else:
            yield _Change(left.place, right.place), left, right

    def _ended(self, left: _Seen, right: _Seen) -> list[tuple[_Change, _Seen, _Seen]]:
        """The place between two others at which a cycle ceases to attract, if nothing else is."""
        for place in dict.fromkeys(self._ends_of_cycles(left, right)):
            near = self._beside(place, left.place), self._beside(place, right.place)
            if self._same(left, near[0]) and self._same(near[1], right) and not self._same(*near):
                return [(_Change(place, place), *near)]
        return []

    def _located(self, left: _Seen, right: _Seen) -> list[tuple[_Change, _Seen, _Seen]]:
        """The places between two others at which longer words say that attractors change, if any.

        They must explain all that changes: between two of them nothing may.
        """
        roots = dict[Real, list[tuple[_Image, Word]]]()
        for longest in LONGEST:
            for image, cycle, zeros in self._between(left, right, longest):
                for root in zeros:
                    if left.place < root < right.place:
                        roots.setdefault(root, []).append((image, cycle))
            if roots:
                break
        if not 0 < len(roots) <= MANY:
            return []
        places = sorted(roots)
        outer = [left.place, *starmap(simplest_between, pairwise(places)), right.place]
        near = [
            (self._beside(place, low), self._beside(place, high))
            for place, (low, high) in zip(places, pairwise(outer), strict=True)
        ]
        apart = [left, *(each for both in near for each in both), right]
        if not all(map(self._same, apart[::2], apart[1::2])):  # more happens between them
            return []
        return [
            (_Change(place, place, tuple(roots[place])), before, after)
            for place, (before, after) in zip(places, near, strict=True)
            if not self._same(before, after)
        ]

    def _between(
        self, left: _Seen, right: _Seen, longest: int
    ) -> Iterator[tuple[_Image, Word, tuple[Real, ...]]]:
        """Images up to an order and cycles that meet where what attracts changes."""
        low, high = left.place, right.place
        for seen in (left, right):
            images = set[_Image]()
            for orbit, (k, _) in zip(seen.found.orbits, self.germs, strict=True):
                word = self._word(seen.line, orbit.germs[:longest])
                images |= {_Image(k, word[:n]) for n in range(1, len(word) + 1)}
            yield from self._meetings(low, high, seen.place, images, max(PERIOD, self.order), True)

    def _same(self, left: _Seen, right: _Seen) -> bool:
        """Whether the same attracts at two places, up to which images are the outermost."""
        if (left.counts, left.cycles) != (right.counts, right.cycles):
            return False
        return left.ends == right.ends or not left.counts or self._close(left, right)

    def _close(self, left: _Seen, right: _Seen) -> bool:
        """Whether bands with other names at two places may be the same by what they are there."""
        one, other = (
            [to_double(x) for bands in each.found.bands for pair in bands.intervals for x in pair]
            for each in (left, right)
        )
        scale = max(one) - min(one)
        return max(abs(a - b) for a, b in zip(one, other, strict=True)) <= SAME * scale

    def _followed(self, low: Real, high: Real) -> list[_Part]:
        """Parts of an interval in each of which germs keep their words."""
        cuts = {low, high}
        for letter in set(self.letters):
            cuts |= self._roots(self.axis.roots(Slope(letter)), low, high)
            for unit in (1, -1):
                cuts |= self._roots(self.axis.roots(Multiplier((letter,), unit)), low, high)
        parts = [_Part(a, b, tuple(() for _ in self.germs)) for a, b in pairwise(sorted(cuts))]
        for length in range(self.order):
            parts = [new for part in parts for new in self._longer(part, length)]
        return parts

    @staticmethod
    def _roots(roots: tuple[Any, ...] | None, low: Real, high: Real) -> set[Real]:
        return {root for root in roots or () if low < root < high}

    def _longer(self, part: _Part, length: int) -> Iterator[_Part]:
        """A part cut where an image meets a break, with words one letter longer."""
        cuts = {part.low, part.high}
        for (k, _), word in zip(self.germs, part.words, strict=True):
            if len(word) == length and word:
                for other in self.layout.breaks:
                    decision = CriticalOrbit(k, word, other)
                    cuts |= self._roots(self.axis.roots(decision), part.low, part.high)
        for low, high in pairwise(sorted(cuts)):
            place = self.axis.between(low, high)
            words = tuple(
                self._with_letter(k, side, word, place) if len(word) == length else word
                for (k, side), word in zip(self.germs, part.words, strict=True)
            )
            yield _Part(low, high, words)

    def _with_letter(self, k: int, side: int, word: Word, place: Real) -> Word:
        """The word of a germ with the letter of its piece; as it is after a flat one."""
        sign = self.axis.sign
        for letter in word:
            side *= sign(self.orbits.polynomial(Slope(letter)), place)
        if not side:
            return word
        slot = 0
        for other in self.layout.breaks:
            beyond = sign(self.orbits.polynomial(CriticalOrbit(k, word, other)), place)
            if beyond > 0 or (beyond == 0 and side > 0):
                slot += 1
        return (*word, self.letters[slot])

    def _meetings(
        self, low: Any, high: Any, sample: Number, images: Iterable[_Image], order: int,
        crossing: bool = False,
    ) -> Iterator[tuple[_Image, Word, tuple[Real, ...]]]:  # fmt: skip
        """Images and points of repelling cycles that meet within an interval.

        With ``crossing`` only where they change sides, between two rationals.
        """
        ends = [to_double(_number(end)) for end in (low, high)]
        values = [(image, self.orbits.value(image.k, image.word)) for image in images]
        for numbers in repelling_words(self.seen(sample).line, order):
            word = tuple(self.letters[k] for k in numbers)
            fixed = self.orbits.fixed_point(word)
            for image, value in values:
                difference = dense(value[0] * fixed[1] - fixed[0] * value[1])
                if not may_vanish(difference, *ends):
                    continue
                if crossing and sign_at(difference, low) * sign_at(difference, high) >= 0:
                    continue
                yield image, word, self._zeros(difference)

    def _zeros(self, polynomial: Dense) -> tuple[Real, ...]:
        return real_roots(polynomial)

    # --- What attracts ------------------------------------------------------------------------

    @cache  # noqa: B019  as long as the study lives
    def seen(self, place: Number) -> _Seen:
        """What attracts at a rational place."""
        line = line_of(self.map, {self.name: QQ.to_sympy(place)})
        found = attractors_of(line)
        names = dict[Exact, _Image]()
        if found.bands:
            for orbit, (k, _) in zip(found.orbits, self.germs, strict=True):
                word = self._word(line, orbit.germs)
                for n, germ in enumerate(orbit.germs):
                    names.setdefault(germ.x, _Image(k, word[:n]))
        ends = tuple(
            tuple((names[a], names[b]) for a, b in bands.intervals if a in names and b in names)
            for bands in found.bands
        )
        words = [_first_turn(cycle.word) for cycle in found.cycles]
        cycles = tuple(sorted(w if len(w) <= self.order else "..." for w in words))
        return _Seen(place, line, found, ends, cycles)

    def _word(self, line: Line, germs: Sequence[Germ]) -> Word:
        """The letters of pieces that germs are mapped by."""
        numbers = {id(branch): k for k, branch in enumerate(line.branches)}
        return tuple(self.letters[numbers[id(line.beside(germ))]] for germ in germs)

    def _set_at(self, seen: _Seen, place: Real) -> list[Interval]:
        """All bands with their ends at another place, joined."""
        return joined(
            (self._value(a, place), self._value(b, place)) for bands in seen.ends for a, b in bands
        )

    def _value(self, image: _Image, place: Real) -> Exact:
        fraction = self.orbits.value(image.k, image.word)
        if isinstance(place, RealRoot):
            top, bottom = (Element(place, place.reduced(dense(part))) for part in fraction)
            return top / bottom
        return self.axis.value(fraction, place)

    # --- Changes ------------------------------------------------------------------------------

    def kind_at(self, place: Real, width: Number) -> PointKind | None:
        """What happens to bands at a place; what attracts is asked about a width beside it."""
        low, high = bounds(place)
        left = self.seen(simplest_between(low - width, low - width / 2))
        right = self.seen(simplest_between(high + width / 2, high + width))
        return None if self._same(left, right) else self._kind(left, right, _Change(place, place))

    def _kind(self, left: _Seen, right: _Seen, change: _Change) -> PointKind | None:
        """What happens to bands between two places; None if nothing does."""
        if not left.counts and not right.counts:
            return None
        if not (left.counts and right.counts):
            return self._end(*((left, right) if left.counts else (right, left)), change)
        if change.low == change.high:
            same = self._set_at(left, change.place) == self._set_at(right, change.place)
        else:
            same = left.counts == right.counts and self._close(left, right)
        if not same:
            return PointKind.XC
        return None if left.counts == right.counts else PointKind.MC

    def _end(self, chaotic: _Seen, other: _Seen, change: _Change) -> PointKind:
        """How bands end beyond which there are none."""
        new = self._new_words(chaotic, other)
        if not new:
            return PointKind.FC
        if change.low < change.high:
            return PointKind.BC
        flips = (self.orbits.polynomial(Multiplier(tuple(sorted(word)), -1)) for word in new)
        at_one = any(self.axis.sign(each, change.place) == 0 for each in flips)
        return PointKind.PD if at_one else PointKind.BC

    def _new_words(self, one: _Seen, other: _Seen) -> list[Word]:
        """Words of attracting cycles that are at the other place only."""
        known = {_first_turn(cycle.word) for cycle in one.found.cycles}
        return [
            tuple(_numbers(self.map, cycle.word))
            for cycle in other.found.cycles
            if _first_turn(cycle.word) not in known
        ]

    def _ends_of_cycles(self, left: _Seen, right: _Seen) -> Iterator[Real]:
        """Where a cycle that attracts at one of two places only meets a break, or has +1 or -1."""
        low, high = left.place, right.place
        for word in (*self._new_words(left, right), *self._new_words(right, left)):
            numbers = [self.orbits.polynomial(Multiplier(tuple(sorted(word)), u)) for u in (1, -1)]
            for k in range(len(word)):
                fixed = self.orbits.fixed_point(word[k:] + word[:k])
                breaks = (self.orbits.value(other, ()) for other in self.layout.breaks)
                numbers += [fixed[0] * b[1] - b[0] * fixed[1] for b in breaks]
            for number in numbers:
                yield from (root for root in self._zeros(dense(number)) if low < root < high)

    def _crisis(self, left: _Seen, right: _Seen, kind: PointKind, change: _Change) -> Crisis:
        spelled = self.map.spelled
        width = to_double(_number(change.high)) - to_double(_number(change.low))
        return Crisis(
            parameter=real_to_sympy(change.place),
            kind=kind,
            bands=(sum(left.counts), sum(right.counts)),
            meetings=tuple(
                Meeting(self.layout.breaks.index(image.k), spelled(image.word), spelled(cycle))
                for image, cycle in dict.fromkeys(change.met)
            ),
            width=width,
        )

    def _open_cell(self, low: Real, high: Real) -> AttractorCell:
        """A cell of which nothing is claimed."""
        cell = self._cell(low, high, self._sampled(low, high))
        return replace(cell, cycles=(), bands=(), is_open=True)

    def _cell(self, low: Real, high: Real, seen: _Seen) -> AttractorCell:
        value = self.orbits.value
        return AttractorCell(
            lower=real_to_sympy(low),
            upper=real_to_sympy(high),
            sample=QQ.to_sympy(seen.place),
            cycles=seen.cycles,
            bands=tuple(
                tuple(
                    (_expression(value(a.k, a.word)), _expression(value(b.k, b.word)))
                    for a, b in bands
                )
                for bands in seen.ends
            ),
            line=seen.line,
        )


def _number(place: Real) -> Exact:
    """A place as a number of its own field."""
    return Element(place, (QQ.one, QQ.zero)) if isinstance(place, RealRoot) else place


def _expression(fraction: Fraction_) -> sympy.Expr:
    return quotient_to_sympy(fraction) if fraction[1] == 1 else shown_fraction(fraction)


def _by_length(word: str) -> tuple[int, str]:
    return len(word), word


def _first_turn(word: str) -> str:
    """The first of the words of a cycle in the alphabet."""
    return min(word[i:] + word[:i] for i in range(len(word)))
