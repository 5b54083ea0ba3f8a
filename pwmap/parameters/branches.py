"""What is followed through the cells of a parameter, and where the ends of it meet.

Fixed points and jump crossings are followed from cell to cell by what names them: a fixed point by
its word, a crossing by its cut and the words on both sides. A run lasts while its name does; it
ends where the name does, or where its multiplier is +1 or -1. Ends that lie at one place meet.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, cmp_to_key
from itertools import pairwise
from math import inf
from typing import Any, NamedTuple

from pwmap.algebra.exact import Fraction_, cancelled, is_constant
from pwmap.diagrams.diagram import BranchKind
from pwmap.maps.cylinders import Cut, Cylinder, Place, minimal_period
from pwmap.maps.words import Orbits, SignOracle, Word
from pwmap.parameters.axis import INFINITE, Axis
from pwmap.parameters.cells import Cell

Borders = set[tuple[int, int]]  # edge and word length of fixed points that others may end on
Met = dict[Any, dict[Any, float]]  # for each place exact values, and their floats
EPSILON = 2.0**-52  # spacing of doubles at 1
Position = Fraction_ | None  # an x as a quotient; None is infinite
LEFT, ALONG, RIGHT = -1, 0, 1  # of an end: the branch lies at smaller, equal, larger parameters


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

    @property
    def word(self) -> Word:
        """The word of a fixed point, or the left one of a jump."""
        return self.words[0]

    def x(self, orbits: Orbits) -> Fraction_:
        """Its position as a quotient in lowest terms; see :meth:`Sweep.position`."""
        if self.cut is None:
            return cancelled(orbits.fixed_point(self.word))
        return cancelled(orbits.preimage(self.cut.k, self.word[: self.cut.steps]))


@dataclass(frozen=True, slots=True)
class Infinite:
    """An x that grows without bound, to the side -1 or +1."""

    side: int


class Shows(NamedTuple):
    """What a cell shows of a fixed point."""

    place: Place
    stable: bool

    @property
    def isolated(self) -> bool:
        """Whether its cylinder is that point alone: then it has no slope."""
        return self.place is Place.POINT


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """A name, from one place of the axis to another.

    Attributes
    ----------
    closed
        Whether it exists at its ends too.
    shows
        How its fixed points lie in their cylinders, and whether they attract.
    band
        For a run of fixed points along one value of the parameter, the x of its ends.
    """

    name: Name
    places: tuple[Any, Any]
    closed: tuple[bool, bool] = (True, True)
    shows: Shows | None = None
    band: tuple[Position, Position] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class End:
    """One end of a run.

    Attributes
    ----------
    which
        0 or 1: the first or the last.
    side
        LEFT, ALONG or RIGHT, as seen from the end.
    unit
        +1 or -1 if that is the multiplier there and not elsewhere, otherwise 0.
    is_steep
        Whether the multiplier near it is larger than 1 in size.
    x
        Its position as a quotient.
    value
        The same in canonical form, or :class:`Infinite`.
    """

    run: Run
    which: int
    side: int
    unit: int
    is_steep: bool
    x: Position
    value: Any

    @property
    def is_fixed(self) -> bool:
        """Whether it is the end of a branch of fixed points."""
        return self.run.name.kind is BranchKind.FIXED_POINT

    @property
    def steps(self) -> int:
        """Length of the words."""
        return len(self.run.name.word)

    @property
    def place(self) -> Any:
        """Where on the axis it lies."""
        return self.run.places[self.which]


@dataclass(frozen=True, slots=True, eq=False)
class Meeting:
    """The ends of runs that lie at one place.

    Attributes
    ----------
    value
        The common x in canonical form, or :class:`Infinite`.
    x
        The same as a float, for drawing; it is infinite too where the x is too large for one.
    attracts
        +1 if a fixed point attracts here although none of its branches does, -1 if it does not
        although its branches do, otherwise 0.
    """

    place: Any
    value: Any
    x: float
    ends: tuple[End, ...]
    attracts: int


@dataclass(frozen=True, eq=False)
class Sweep:
    """The cells of a parameter, from left to right, and the names that live in them.

    Attributes
    ----------
    unit
        How many maps make one step of order 1.
    span
        Places of the first and the last value of the parameter, as far as the assumptions reach.
    """

    axis: Axis
    cells: Sequence[Cell]
    unit: int
    span: tuple[Any, Any]
    _positions: dict[Name, Fraction_] = field(default_factory=dict, init=False, repr=False)
    _values: dict[tuple[Name, Any], Any] = field(default_factory=dict, init=False, repr=False)
    _ends: dict[Run, tuple[End, End]] = field(default_factory=dict, init=False, repr=False)
    _units: dict[tuple[Any, Any], int] = field(default_factory=dict, init=False, repr=False)

    @property
    def orbits(self) -> Orbits:
        """Affine forms of words in the parameters."""
        return self.axis.orbits

    @cached_property
    def present(self) -> list[dict[Name, Shows | None]]:
        """For each cell what lies on the diagonal: fixed points with what they show, and jumps.

        A fixed point that is a cylinder of its own has no slope, and is named by its cut too. But
        at an edge, where it belongs to a branch of the cells beside, it has that branch's name.
        """
        found = [dict(self._names(cell)) for cell in self.cells]
        for i, names in enumerate(found):
            beside = [*found[i - 1 : i], *found[i + 1 : i + 2]] if self.cells[i].is_edge else []
            for name in [name for name, shows in names.items() if shows and shows.isolated]:
                plain = Name(name.kind, name.words)
                if any(plain in others for others in beside):
                    names[plain] = names.pop(name)
        return found

    def _names(self, cell: Cell) -> Iterator[tuple[Name, Shows | None]]:
        oracle = cell.study.oracle
        for order, iterate in cell.study.iterates.items():
            for cylinder, place, stable in zip(
                iterate.cylinders, iterate.places, iterate.stable, strict=True
            ):
                if self._is_own(cylinder, place, order, oracle):
                    for cut in _cuts(cylinder, place):
                        name = Name(BranchKind.FIXED_POINT, (cylinder.word,), cut)
                        yield name, Shows(place, stable)
            for crossing in iterate.crossings:
                words = crossing.left, crossing.right
                yield Name(BranchKind.JUMP, words, crossing.cut), None

    def _is_own(self, cylinder: Cylinder, place: Place, order: int, oracle: SignOracle) -> bool:
        """Whether there are fixed points whose minimal period is the order."""
        if place in (Place.VIRTUAL, Place.NONE):
            return False
        period = minimal_period(cylinder.word, self.unit)
        if place is Place.BAND and order == 2 * period:
            return oracle.slope(cylinder.word[: len(cylinder.word) // 2]) < 0
        return period == order

    @cached_property
    def stops(self) -> tuple[Any, ...]:
        """Places where cells begin and stop: ends of the span, and of what is assumed."""
        excluded = [end for c in self.cells if c.is_excluded for end in (c.lower, c.upper)]
        return (self.cells[0].lower, self.cells[-1].upper, *excluded)

    # --- Runs -----------------------------------------------------------------------------------

    def runs(self) -> list[Run]:
        """All runs: first those over the parameter, then bands along one value of it."""
        stretches = list(self._stretches())
        bands = list(self._bands())
        borders = {
            (i, len(name.word))
            for name, s in stretches
            if name.kind is BranchKind.FIXED_POINT
            for i in s
            if self.cells[i].is_edge and (len(s) == 1 or self._is_on_border(name, i))
        }
        met = self._met(stretches, bands, borders)
        found = [
            self._run(name, part)
            for name, stretch in stretches
            for part in self._cut(name, stretch, borders, met)
        ]
        meetings = self.meetings(found) if bands else []
        return found + [run for band in bands for run in self._parted(*band, meetings)]

    def _stretches(self) -> Iterator[tuple[Name, list[int]]]:
        """Maximal stretches of cells with one name; a multiplier of +1 or -1 parts them too."""
        where: dict[Name, list[int]] = defaultdict(list)
        for i, names in enumerate(self.present):
            for name in names:
                where[name].append(i)
        for name, indices in where.items():
            stretch: list[int] = []
            for i, following in pairwise([*indices, -1]):
                stretch.append(i)
                goes_on = following == i + 1
                parted = len(stretch) > 1 and self.cells[i].is_edge and goes_on
                if not goes_on or (parted and self._changes(name, i)):
                    if len(stretch) > 1 or not (self._is_edge_of_band(name, i) or self._at_end(i)):
                        yield name, stretch
                    stretch = [i] if goes_on else []

    def _changes(self, name: Name, i: int) -> bool:
        """Whether a fixed point changes its stability at an edge through which it passes."""
        stable = {shows.stable for k in (i - 1, i, i + 1) if (shows := self.present[k][name])}
        if len(stable) > 1 or name.kind is BranchKind.JUMP or name.cut is not None:
            return len(stable) > 1
        oracle = self.cells[i].study.oracle
        hits = any(oracle.multiplier(name.word, unit) == 0 for unit in (1, -1))
        return hits and self.unit_multiplier(name, self.cells[i].lower) != 0

    def _met(
        self,
        stretches: Sequence[tuple[Name, list[int]]],
        bands: Sequence[tuple[Cylinder, Any]],
        borders: Borders,
    ) -> Met:
        """For each place the x of all ends at which a run may be met that passes there."""
        passed = {
            self.cells[i].lower for name, s in stretches for i in self._exposed(name, s, borders)
        }
        met: Met = {place: {} for place in passed}
        for name, stretch in stretches if passed else ():
            run = self._run(name, stretch)
            for k, place in enumerate(run.places):
                value = self._value(run, k) if place in passed else None
                if value is not None and not isinstance(value, Infinite):
                    met[place][value] = self.axis.number(self.position(name), place)
        for cylinder, place in bands:
            for cut in (cylinder.lower, cylinder.upper):
                if cut is not None and place in passed:
                    x = self.orbits.preimage(cut.k, cylinder.word[: cut.steps])
                    met[place][self.axis.value(x, place)] = self.axis.number(x, place)
        return met

    def _exposed(self, name: Name, stretch: Sequence[int], borders: Borders) -> Iterator[int]:
        """Edges that a run passes and at which others of its order can end on it.

        A fixed point inside its cylinder has none near; it must lie on a border. A jump that
        crosses the diagonal has none beside, but its break can be a fixed point.
        """
        for i in stretch[1:-1]:
            met = self._is_on_border(name, i) or (i, len(name.word)) in borders
            if self.cells[i].is_edge and met:
                yield i

    def _is_on_border(self, name: Name, i: int) -> bool:
        """Whether a fixed point lies at an end of its cylinder, or is one."""
        shows = self.present[i][name]
        return shows is not None and shows.place is not Place.INSIDE

    def _cut(
        self, name: Name, stretch: Sequence[int], borders: Borders, met: Met
    ) -> Iterator[Sequence[int]]:
        """The parts of a stretch between the places where other runs end on it."""
        start = 0
        for i in self._exposed(name, stretch, borders):
            place = self.cells[i].lower
            if self._is_among(name, place, met[place]):
                stop = stretch.index(i)
                yield stretch[start : stop + 1]
                start = stop
        yield stretch[start:]

    def _is_among(self, name: Name, place: Any, values: Mapping[Any, float]) -> bool:
        """Whether the x of what has a name, where it is finite, is one of some values.

        Their floats, right but for the last bit, tell most of them apart; only where they do not,
        the exact value is taken.
        """
        x = self.axis.number(self.position(name), place)
        near = any(
            not abs(x - other) > 4.0 * EPSILON * max(abs(x), abs(other))  # also if they overflow
            for other in values.values()
        )
        return near and self._at(name, place) in values

    def _run(self, name: Name, stretch: Sequence[int]) -> Run:
        first, last = self.cells[stretch[0]], self.cells[stretch[-1]]
        return Run(
            name,
            (first.lower, last.upper),
            (first.is_edge, last.is_edge),
            next((self.present[i][name] for i in stretch if not self.cells[i].is_edge), None)
            or self.present[stretch[0]][name],
        )

    def _at_end(self, i: int) -> bool:
        """Whether the cells end at a cell: what exists there only is left out."""
        return self.cells[i].is_edge and self.cells[i].lower in self.stops

    def _is_edge_of_band(self, name: Name, i: int) -> bool:
        """Whether a name at an edge only is an end of a band along that edge."""
        shows = self.present[i][name]
        return self.cells[i].is_edge and shows is not None and shows.place is Place.BAND

    def _bands(self) -> Iterator[tuple[Cylinder, Any]]:
        """Pieces that are the identity at one value of the parameter only, and that value."""
        for i, cell in enumerate(self.cells):
            if not cell.is_edge or self._at_end(i):
                continue
            beside = self._bands_beside(i)
            for order, iterate in cell.study.iterates.items():
                for cylinder, place in zip(iterate.cylinders, iterate.places, strict=True):
                    if (
                        place is Place.BAND
                        and cylinder.word not in beside
                        and self._is_own(cylinder, place, order, cell.study.oracle)
                    ):
                        yield cylinder, cell.lower

    def _bands_beside(self, i: int) -> set[Word]:
        """Words that are the identity in a cell next to an edge."""
        return {
            cylinder.word
            for cell in (self.cells[i - 1], self.cells[i + 1])
            for iterate in cell.study.iterates.values()
            for cylinder, place in zip(iterate.cylinders, iterate.places, strict=True)
            if place is Place.BAND
        }

    def _parted(self, cylinder: Cylinder, place: Any, meetings: Sequence[Meeting]) -> Iterator[Run]:
        """The runs of such a piece, which special points inside it part."""
        word, order = cylinder.word, self.axis.order
        low, high = (
            None if cut is None else self.orbits.preimage(cut.k, word[: cut.steps])
            for cut in (cylinder.lower, cylinder.upper)
        )
        inner = {
            meeting.value: x
            for meeting in meetings
            if meeting.place == place
            and (x := meeting.ends[0].x) is not None
            and not isinstance(meeting.value, Infinite)
            and (low is None or order(low, x, place) < 0)
            and (high is None or order(x, high, place) < 0)
        }

        def by_size(first: Fraction_, second: Fraction_) -> int:
            return order(first, second, place)

        stops: list[Position] = [low, *sorted(inner.values(), key=cmp_to_key(by_size)), high]
        for j, band in enumerate(pairwise(stops)):
            closed = (
                cylinder.lower_closed or j > 0,
                cylinder.upper_closed or j < len(stops) - 2,
            )
            yield Run(Name(BranchKind.FIXED_POINT, (word,)), (place, place), closed, band=band)

    # --- Where they meet ------------------------------------------------------------------------

    def meetings(self, runs: Sequence[Run]) -> list[Meeting]:
        """Ends of runs that lie at the same place, from left to right and bottom to top."""
        groups: dict[tuple[Any, Hashable], list[End]] = defaultdict(list)
        for run in runs:
            for end in self.ends(run):
                groups[end.place, end.value].append(end)
        found = [
            Meeting(place, value, self._number(ends[0]), tuple(ends), self._attracts(place, ends))
            for (place, value), ends in groups.items()
        ]
        return sorted(found, key=cmp_to_key(self._compared))

    def _attracts(self, place: Any, ends: Sequence[End]) -> int:
        """How the stability of a fixed point differs from that of its branches, as a sign."""
        i = self._edges.get(place)
        beside: dict[Name, set[bool]] = defaultdict(set)
        for end in ends:
            if end.run.shows is not None and end.run.places[0] != end.run.places[1]:
                beside[end.run.name].add(end.run.shows.stable)
        for name, stable in beside.items():
            here = None if i is None else self.present[i].get(name)
            if here is not None and stable == {not here.stable}:
                return 1 if here.stable else -1
        return 0

    @cached_property
    def _edges(self) -> dict[Any, int]:
        """Which cell an edge is."""
        return {cell.lower: i for i, cell in enumerate(self.cells) if cell.is_edge}

    def _compared(self, first: Meeting, second: Meeting) -> int:
        """-1, 0 or 1: the order of two meetings, by place and then by x."""
        place = first.place
        if place != second.place:
            return -1 if place < second.place else 1
        values = first.value, second.value
        sides = [value.side if isinstance(value, Infinite) else 0 for value in values]
        return sides[0] - sides[1] if any(sides) else self.axis.compare(*values, place)

    def ends(self, run: Run) -> tuple[End, End]:
        """Both ends of a run."""
        if run not in self._ends:
            along = run.places[0] == run.places[1]
            is_steep = self._is_steep(run)
            first, last = (
                End(
                    run,
                    which,
                    ALONG if along else side,
                    self._unit_at_end(run, which),
                    is_steep,
                    self._x(run, which),
                    self._value(run, which),
                )
                for which, side in ((0, RIGHT), (1, LEFT))
            )
            self._ends[run] = first, last
        return self._ends[run]

    def position(self, name: Name) -> Fraction_:
        """The x of what has a name, as a quotient in lowest terms."""
        if name not in self._positions:
            self._positions[name] = name.x(self.orbits)
        return self._positions[name]

    def _at(self, name: Name, place: Any) -> Any:
        """The x of what has a name at a place, in canonical form."""
        if (name, place) not in self._values:
            self._values[name, place] = self.axis.value(self.position(name), place)
        return self._values[name, place]

    def _x(self, run: Run, which: int) -> Position:
        """The x of an end as a quotient."""
        return self.position(run.name) if run.band is None else run.band[which]

    def _value(self, run: Run, which: int) -> Any:
        """The x of an end in canonical form; an infinite one with its side."""
        x, place = self._x(run, which), run.places[which]
        if x is None:
            return Infinite(2 * which - 1)
        value = self._at(run.name, place) if run.band is None else self.axis.value(x, place)
        if value != INFINITE:
            return value
        one = self.orbits.table.one
        inside = self.axis.between(*run.places)  # the denominator has no zero there
        top, bottom = (
            self.axis.order((number, one), (one - one, one), where)
            for number, where in zip(x, (place, inside), strict=True)
        )
        return Infinite(top * bottom)

    def _unit_at_end(self, run: Run, which: int) -> int:
        return 0 if run.band is not None else self.unit_multiplier(run.name, run.places[which])

    def unit_multiplier(self, name: Name, place: Any) -> int:
        """+1 or -1 where the multiplier of a fixed point passes through that value, else 0."""
        slope, one = self.orbits.slope(name.word), self.orbits.table.one
        if name.kind is BranchKind.JUMP or name.cut is not None or all(map(is_constant, slope)):
            return 0
        if not self.is_finite(slope, place):
            return 0
        if (slope, place) not in self._units:
            order = self.axis.order
            units = (u for u in (1, -1) if order(slope, (u * one, one), place) == 0)
            self._units[slope, place] = next(units, 0)
        return self._units[slope, place]

    def is_finite(self, fraction: Fraction_, place: Any) -> bool:
        """Whether a quotient has a value; a denominator may vanish at an open end of the span."""
        return is_constant(fraction[1]) or self.axis.value(fraction, place) != INFINITE

    def _is_steep(self, run: Run) -> bool:
        if run.name.kind is BranchKind.JUMP or (run.shows is not None and run.shows.isolated):
            return False
        place = run.places[0]
        if place != run.places[1]:  # at its end the multiplier may be 1 in size
            place = self.axis.between(*run.places)
        (top, bottom), one = self.orbits.slope(run.name.word), self.orbits.table.one
        return self.axis.order((top * top, bottom * bottom), (one, one), place) > 0

    def _number(self, end: End) -> float:
        """The x of an end as a float, which may be infinite."""
        if isinstance(end.value, Infinite):
            return end.value.side * inf
        assert end.x is not None
        return self.axis.number(end.x, end.place)


def _cuts(cylinder: Cylinder, place: Place) -> list[Cut | None]:
    """What, besides the word, names the fixed points of a cylinder.

    A point, or those ends of a band that belong to it; nothing for others.
    """
    if place is Place.BAND:
        lower = [cylinder.lower] if cylinder.lower_closed else []
        return [*lower, *([cylinder.upper] if cylinder.upper_closed else [])]
    return [cylinder.lower if place is Place.POINT else None]
