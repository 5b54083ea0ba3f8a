"""Attractors over one parameter: cells in which they do not change, and crises between these.

Bands end in images of breaks and change where one meets a repelling cycle [Grebogi1982]: they
merge, become larger at once, or are lost. Images and cycles have words, so these places are roots
of polynomials. The parameter is cut where images up to some order meet a break, or a cycle that may
end bands, and each part has a rational sample. Between samples that differ, the place where a cycle
or a band of one of them ends is searched with words as long as theirs.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import sympy
from sympy import QQ

from pwmap.algebra.arguments import explained, shortened
from pwmap.algebra.exact import Number, quotient_to_sympy
from pwmap.algebra.numbers import to_double
from pwmap.algebra.roots import Real, bounds, real_to_sympy, simplest_between
from pwmap.diagrams.data import PointKind
from pwmap.diagrams.shown import counted
from pwmap.longrun.crises.changes import Changes, Onset, kind_of
from pwmap.longrun.crises.cuts import cuts_between
from pwmap.longrun.crises.meetings import Meeting
from pwmap.longrun.crises.samples import Attracted, Ends, Glimpses, Samples
from pwmap.longrun.dynamics import Dynamics
from pwmap.longrun.line import MapLine
from pwmap.maps.budget import BUDGET, Budget, BudgetError, Meter, checked_size, metered
from pwmap.maps.piecewise_linear import PiecewiseLinearMap, check_map, checked_order
from pwmap.maps.words import first_turn
from pwmap.parameters.cells import span_of_only

PARTS = 16  # of an interval, which are finished in turn


@dataclass(frozen=True, eq=False)
class AttractorCell:
    """A cell of :func:`pwmap.attractor_diagram`: the same words describe all attractors in it.

    The exact ends ``lower`` and ``upper`` do not belong to it. ``cycles`` has words of attracting
    cycles of any length, ``neutral`` of neutral intervals (all points periodic), ``bands`` the
    bands of each chaotic attractor at the ``sample``: formulas for both ends, which hold nearby as
    long as the same images of breaks are the outermost. ``line`` is the map at the sample. If
    ``is_open``, attractors are not known everywhere: there may be any number of changes.
    """

    lower: sympy.Expr
    upper: sympy.Expr
    sample: sympy.Rational
    cycles: tuple[str, ...]
    bands: tuple[tuple[tuple[sympy.Expr, sympy.Expr], ...], ...]
    line: MapLine
    neutral: tuple[str, ...] = ()
    is_open: bool = False

    @cached_property
    def dynamics(self) -> Dynamics:
        """The long run at the sample."""
        return Dynamics(self.line)


@dataclass(frozen=True, slots=True, kw_only=True)
class Crisis:
    """A value of a parameter at which attractors change, of :func:`pwmap.attractor_diagram`.

    ``parameter`` is exact and ``width`` 0, or they are the middle and the width of an interval that
    contains it. The ``kind`` is MC: bands merge; XC: bands become larger at once; FC: bands are
    lost; BC or PD: bands give way to a cycle that meets a break, or has the multiplier -1 there.
    ``bands`` are their numbers on the left and on the right, ``meetings`` the images of breaks that
    meet repelling cycles there.
    """

    parameter: sympy.Expr
    kind: PointKind
    bands: tuple[int, int]
    meetings: tuple[Meeting, ...]
    width: float = 0.0

    @property
    def cycles(self) -> tuple[str, ...]:
        """Words of the cycles that are met, each from its first letter in the alphabet on."""
        return _by_length(first_turn(each.cycle) for each in self.meetings)

    @property
    def images(self) -> tuple[str, ...]:
        """Words from breaks to the images that meet them."""
        return _by_length(each.image for each in self.meetings)


def _by_length(words: Iterable[str]) -> tuple[str, ...]:
    return tuple(sorted(set(words), key=lambda word: (len(word), word)))


@dataclass(frozen=True, kw_only=True, eq=False)
class AttractorDiagram:
    """Attractors over an interval of a parameter, of :func:`pwmap.attractor_diagram`.

    ``cells`` and ``crises`` are from left to right. Images of breaks up to ``order`` were compared
    with breaks and cycles everywhere. ``left_out`` is a sentence on parts that were not finished;
    empty if all were. For bifurcations of attracting cycles, which separate cells too, see
    :func:`pwmap.bifurcation_diagram`.
    """

    map: PiecewiseLinearMap
    parameter: sympy.Symbol
    order: int
    cells: tuple[AttractorCell, ...]
    crises: tuple[Crisis, ...]
    left_out: str = ""

    @property
    def open(self) -> tuple[AttractorCell, ...]:
        """The cells whose attractors are not known everywhere."""
        return tuple(cell for cell in self.cells if cell.is_open)

    def __repr__(self) -> str:
        low, high = self.cells[0].lower, self.cells[-1].upper
        crises = shortened(", ".join(f"{c.kind} {c.parameter}" for c in self.crises) or "none", 160)
        rest = f"; {self.left_out}" if self.left_out else ""
        return (
            f"AttractorDiagram({self.parameter} in [{low}, {high}], {self.summary}, "
            f"crises: {crises}{rest})"
        )

    @property
    def summary(self) -> str:
        """The number of cells, and how many of them are open, in words."""
        cells = counted(len(self.cells), "cell")
        if not self.open:
            return cells
        width = sum(float(cell.upper - cell.lower) for cell in self.open)
        share = width / float(self.cells[-1].upper - self.cells[0].lower)
        return f"{cells}, {len(self.open)} of them open: {100.0 * share:.2g} % of the interval"


@explained()
def attractor_diagram(
    map_: PiecewiseLinearMap,
    parameter: object,
    span: tuple[object, object],
    order: int = 5,
    *,
    budget: Budget | Meter = BUDGET,
) -> AttractorDiagram:
    """Attracting cycles and bands over an interval of a parameter, with their crises, exactly.

    Parameters
    ----------
    map_, parameter, span
        A map whose other parameters have values, the symbol or name of this one, and two rationals.
    order
        Up to which images of breaks are compared with breaks, and with repelling cycles up to that
        period. All changes by such words are found; those by longer ones unless they undo each
        other between two of these places. Where many longer cycles attract in turn, some have
        cells, and the intervals between them are open.
    budget
        At its end, or at an interrupt, the parts that are finished, from the left, are kept; the
        rest is one open cell.

    Returns
    -------
    AttractorDiagram
        Cells of the parameter with their attractors, and the crises between them.

    Raises
    ------
    ValueError
        If the map has other parameters or is an iterate, or the span is no interval.
    BudgetError
        If not even the first sixteenth of the interval is finished within the budget.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, attractor_diagram
    >>> tent = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
    >>> found = attractor_diagram(tent, "a", ("4/3", "3/2"), 1)
    >>> [(str(cell.lower), str(cell.upper), len(cell.bands[0])) for cell in found.cells]
    [('4/3', 'sqrt(2)', 2), ('sqrt(2)', '3/2', 1)]
    >>> crisis, = found.crises
    >>> print(crisis.kind, crisis.parameter, crisis.bands)  # two bands become one
    MC sqrt(2) (2, 1)
    """
    check_map(map_)
    meter, order = metered(budget), checked_order(order)
    checked_size(order, 1, meter.budget)
    low, high = span_of_only(map_, parameter, span)
    sweep = _Sweep(Samples(map_, order, meter), low, high)
    ends = [low + (high - low) * QQ(k, PARTS) for k in range(PARTS + 1)]
    with meter.keeping(sweep.finished):
        for end in meter.each(ends[1:], "parts of the interval"):
            sweep.advance(end)
    sweep.close()
    return AttractorDiagram(
        map=map_,
        parameter=map_.parameters[0],
        order=order,
        cells=tuple(sweep.cells),
        crises=tuple(sweep.crises),
        left_out=meter.left_out,
    )


class _Sweep:
    """Goes over an interval from left to right, and collects cells and crises."""

    def __init__(self, samples: Samples, low: Real, high: Real) -> None:
        self.samples, self.changes = samples, Changes(samples)
        self.glimpses = Glimpses(samples, low, high)
        self.cells, self.crises = list[AttractorCell](), list[Crisis]()
        self._low = low  # start of the cell that has no end yet
        self._opened = low  # and of the last open cell
        self.finished = list[Real]()  # ends of the finished parts of the interval
        self._ends = low, high
        self._inside = list[Attracted]()  # samples of the cell that has no end yet

    def advance(self, end: Real) -> None:
        start = self.finished[-1] if self.finished else self._ends[0]
        cuts = cuts_between(self.samples, start, end)
        found = list[tuple[Real, Real, Attracted]]()
        for low, high in pairwise([start, *cuts, end]):
            middle = self.samples.between(low, high)
            beside = [self.samples.beside(x, middle.place) for x in (low, high) if cuts.get(x)]
            looks = map(self.samples.at, self.glimpses.between(low, high, middle.place))
            every = [middle, *(each for each in (*beside, *looks) if not each.is_open)]
            every.sort(key=lambda each: each.place)
            found += [(low, high, sample) for sample in every]
        first, last = found[0][2], found[-1][2]
        if not self.finished and not first.is_open:
            found.insert(0, (start, first.place, self.samples.beside(start, first.place)))
        if end == self._ends[1] and not last.is_open:
            found.append((last.place, end, self.samples.beside(end, last.place)))
        events = list(self._events(found))  # all of them before any is kept: the budget may end
        for event in events:
            self._keep(event)
        self.finished.append(end)

    @property
    def _last(self) -> Attracted | None:
        return self._inside[-1] if self._inside else None

    def _events(
        self, found: list[tuple[Real, Real, Attracted]]
    ) -> Iterator[Onset | Attracted | tuple[Real, Real]]:
        """Samples, changes between them, and open intervals, from left to right."""
        before = self._last
        hidden: tuple[Real, Real] | None = None
        for low, high, sample in found:
            if sample.is_open:
                hidden = (hidden[0] if hidden else low), high
                continue
            if before is not None:
                changes = list(self.changes.between(before, sample))
                if hidden and not changes:
                    yield hidden
                yield from changes
            else:
                start = hidden[1] if hidden else self._low
                begin = self.changes.reach(sample, start, sample.place, -1)
                if hidden or begin is not None:
                    yield hidden[0] if hidden else start, start if begin is None else begin
            yield sample
            before, hidden = sample, None
        if hidden:
            yield hidden

    def _keep(self, event: Onset | Attracted | tuple[Real, Real]) -> None:
        match event:
            case Attracted():
                self._inside.append(event)
            case Onset():
                self._inside.append(event.before)
                self._cell(event.low)
                self._open(event.low, event.high)
                kind = None if event.is_open else kind_of(self.samples, event)
                if kind is not None:
                    self.crises.append(_crisis(event, kind))
                self._inside = [event.after]
            case low, high:
                self._known_up_to(low)
                self._open(low, high)

    def close(self) -> None:
        """End the last cell; the rest that is not finished is open."""
        end, last = self.finished[-1], self._last
        if last is not None and last.counts and end < self._ends[1]:
            # bands may change before the next sample, which was not compared
            end = last.place
            self._cell(end)
        else:
            try:
                self._known_up_to(end)
            except BudgetError:  # the end of the last cell cannot be computed
                end = self._inside[-1].place
                self._cell(end)
        self._open(end, self._ends[1])

    def _known_up_to(self, high: Real) -> None:
        """End a cell at the start of an open interval, or where its first cycle may end before."""
        last = self._last
        end = None if last is None else self.changes.reach(last, last.place, high, 0)
        self._cell(high if end is None else end)
        if end is not None:
            self._open(end, high)

    def _cell(self, high: Real) -> None:
        """End a cell, if it has samples inside: with the attractors at the simplest of these."""
        inside = [each for each in self._inside if self._low < each.place < high]
        if inside:
            sample = min(inside, key=lambda each: QQ.denom(each.place))
            self._add(
                high, sample.place, cycles=sample.cycles, neutral=sample.neutral,
                bands=tuple(map(self._formulas, sample.ends)),
            )  # fmt: skip

    def _open(self, low: Real, high: Real) -> None:
        """Add an open cell, joined with an open one before it."""
        low = min(low, self._low)
        if low < high:
            if self.cells and self.cells[-1].is_open:
                self.cells.pop()
                low = self._opened
            self._low = self._opened = low
            self._add(high, simplest_between(low, high), cycles=(), bands=(), is_open=True)

    def _add(self, high: Real, place: Number, **found: Any) -> None:
        lower, upper = real_to_sympy(self._low), real_to_sympy(high)
        sample, line = QQ.to_sympy(place), self.samples.line(place)
        self.cells.append(
            AttractorCell(lower=lower, upper=upper, sample=sample, line=line, **found)
        )
        self._low, self._inside = high, []

    def _formulas(self, bands: tuple[Ends, ...]) -> tuple[tuple[sympy.Expr, sympy.Expr], ...]:
        value = self.samples.orbits.value
        return tuple(
            (quotient_to_sympy(value(*low)), quotient_to_sympy(value(*high))) for low, high in bands
        )


def _crisis(change: Onset, kind: PointKind) -> Crisis:
    width = to_double(bounds(change.high)[1]) - to_double(bounds(change.low)[0])
    return Crisis(
        parameter=real_to_sympy(change.place),
        kind=kind,
        bands=(sum(change.before.counts), sum(change.after.counts)),
        meetings=change.met,
        width=0.0 if change.is_exact else width,
    )
