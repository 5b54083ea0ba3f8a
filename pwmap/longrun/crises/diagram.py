"""Attractors over one parameter: cells in which they do not change, and the crises between these.

Bands end in images of breaks. Where such an image meets a repelling cycle [Grebogi1982] bands
merge, grow suddenly, or are destroyed. Images and cycles have words, so that these places are roots
of polynomials. The parameter is cut where images up to some order meet a break or a repelling
cycle, and each part gets a rational sample. Between samples that differ, the place at which a cycle
or a band of one of them ends is located with words as long as theirs.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, pairwise

import sympy
from sympy import QQ

from pwmap.algebra.arguments import explained, shortened, shown
from pwmap.algebra.numbers import to_double
from pwmap.algebra.roots import Real, bounds, real_to_sympy, simplest_between
from pwmap.algebra.texts import printable
from pwmap.diagrams.data import PointKind
from pwmap.diagrams.shown import counted
from pwmap.longrun.crises.changes import Onset, changes_between, kind_of, open_around, reach
from pwmap.longrun.crises.cuts import cuts_between
from pwmap.longrun.crises.meetings import Meeting
from pwmap.longrun.crises.samples import Attracted, Samples, glimpsed
from pwmap.longrun.dynamics import Dynamics
from pwmap.longrun.line import MapLine
from pwmap.maps.budget import BUDGET, Budget, Meter, checked_size, metered
from pwmap.maps.piecewise_linear import PiecewiseLinearMap, check_map, checked_order
from pwmap.maps.words import first_rotation
from pwmap.parameters.cells import span_of_only

PARTS = 16  # of an interval, finished in turn: if the budget ends, the first ones are kept


@printable
@dataclass(frozen=True, eq=False)
class AttractorCell:
    """A cell of :func:`pwmap.attractor_diagram`: the same words describe its attractors throughout.

    The exact ends ``lower`` and ``upper`` do not belong to it. ``cycles`` has the words of
    attracting cycles of any length, ``neutral`` those of neutral intervals (all points periodic).
    ``bands`` has, for each chaotic attractor, formulas of both ends of its bands at the ``sample``;
    they hold as long as the same images of breaks are outermost. ``line`` is the map at the sample.
    If the cell ``is_open``, attractors may change in it any number of times. If not, cycles and
    neutral intervals are proved close to its ends at open cells, and bands are sampled there; what
    begins and ends again inside may be missing, as for ``order``.
    """

    lower: sympy.Expr
    upper: sympy.Expr
    sample: sympy.Rational
    line: MapLine
    cycles: tuple[str, ...] = ()
    bands: tuple[tuple[tuple[sympy.Expr, sympy.Expr], ...], ...] = ()
    neutral: tuple[str, ...] = ()
    is_open: bool = False

    @cached_property
    def dynamics(self) -> Dynamics:
        """The long-run dynamics at the sample."""
        return Dynamics(self.line)


@printable
@dataclass(frozen=True, slots=True, kw_only=True)
class Crisis:
    """A value of a parameter at which attractors change, of :func:`pwmap.attractor_diagram`.

    ``parameter`` is exact and ``width`` 0, or they are the midpoint and the width of an interval
    that contains the value. The ``kind`` is MC: bands merge; XC: bands grow suddenly; FC: bands are
    destroyed; BC or PD: bands give way to a cycle that meets a break, or has multiplier -1 there.
    ``bands`` are the numbers of bands on the left and on the right, ``meetings`` the images of
    breaks that meet repelling cycles there.
    """

    parameter: sympy.Expr
    kind: PointKind
    bands: tuple[int, int]
    meetings: tuple[Meeting, ...]
    width: float = 0.0

    @property
    def cycles(self) -> tuple[str, ...]:
        """The words of the cycles that are met, each turned to come first in the alphabet."""
        return _by_length(first_rotation(each.cycle) for each in self.meetings)

    @property
    def images(self) -> tuple[str, ...]:
        """The words from breaks to the images that meet the cycles."""
        return _by_length(each.image for each in self.meetings)


def _by_length(words: Iterable[str]) -> tuple[str, ...]:
    return tuple(sorted(set(words), key=lambda word: (len(word), word)))


@dataclass(frozen=True, kw_only=True, eq=False)
class AttractorDiagram:
    """Attractors over an interval of a parameter, of :func:`pwmap.attractor_diagram`.

    ``cells`` and ``crises`` run from left to right. Images of breaks up to ``order`` were compared
    with breaks and cycles everywhere. ``left_out`` says which parts were not finished, and is empty
    if all were. Bifurcations of attracting cycles, which separate cells too, are in
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
        """The cells in which attractors are not known everywhere."""
        return tuple(cell for cell in self.cells if cell.is_open)

    def __repr__(self) -> str:
        low, high = shown(self.cells[0].lower), shown(self.cells[-1].upper)
        crises = shortened(", ".join(f"{c.kind} {c.parameter}" for c in self.crises) or "none", 160)
        rest = f"; {self.left_out}" if self.left_out else ""
        return (
            f"AttractorDiagram({self.parameter} in [{low}, {high}], {self.summary}, "
            f"crises: {crises}{rest})"
        )

    @property
    def summary(self) -> str:
        """The number of cells, and how many of them are open, as a phrase."""
        cells = counted(len(self.cells), "cell")
        if not self.open:
            return cells
        whole = self.cells[-1].upper - self.cells[0].lower  # as a double it may be zero
        share = sum(float((cell.upper - cell.lower) / whole) for cell in self.open)
        return f"{cells}, {len(self.open)} of them open: {100.0 * share:.3g} % of the interval"


@explained()
def attractor_diagram(
    map_: PiecewiseLinearMap,
    parameter: object,
    span: tuple[object, object],
    order: int = 5,
    *,
    budget: Budget | Meter = BUDGET,
) -> AttractorDiagram:
    """Attracting cycles and bands over an interval of a parameter, and their crises, exactly.

    Parameters
    ----------
    map_, parameter, span
        A map whose other parameters have values, the symbol or name of this one, and two rationals.
    order
        The length up to which images of breaks are compared with breaks, and with repelling cycles
        up to this period. All changes due to such words are found, and those due to longer words
        unless they cancel between two of these places. Where many longer cycles attract in turn,
        some have cells, and the intervals between them are open.
    budget
        If it ends, or at Ctrl-C, finished parts are kept, and the rest is one open cell.

    Returns
    -------
    AttractorDiagram
        Cells of the parameter with their attractors, and the crises between them.

    Raises
    ------
    ValueError
        If the map has other parameters or is an iterate, or the span is no interval.
    BudgetError
        If the budget ends before the first sixteenth of the interval is finished.

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
    samples, parts = Samples(map_, order, meter, (low, high)), list[list[Event]]()
    ends = [low + (high - low) * QQ(k, PARTS) for k in range(PARTS + 1)]
    with meter.keeping(parts):
        for start, end in meter.each([*pairwise(ends)], "parts of the interval"):
            parts.append([*_events(samples, start, end, _last(parts))])
    events = [*chain.from_iterable(parts)]
    if len(parts) < PARTS:  # changes since the last sample may be in parts that are not finished
        last = _last(parts)
        events.append(Onset(last.place if last else ends[len(parts)], high, is_open=True))
    cells, crises = _assembled(samples, events, low)
    return AttractorDiagram(
        map=map_,
        parameter=map_.parameters[0],
        order=order,
        cells=tuple(cells),
        crises=tuple(crises),
        left_out=meter.left_out,
    )


Event = Attracted | Onset  # samples, and changes or open intervals between them, from left to right
Taken = tuple[Real, Real, Attracted]  # an interval without cuts, and a sample in it


def _taken(samples: Samples, start: Real, end: Real) -> Iterator[Taken]:
    """Yield samples of a part from left to right, with extra ones beside the ends of the span."""
    cuts = cuts_between(samples, start, end)
    found = list[Taken]()
    for low, high in pairwise([start, *cuts, end]):
        middle = samples.between(low, high)
        beside = [samples.beside(x, middle.place) for x in (low, high) if cuts.get(x)]
        beside += map(samples.at, glimpsed(samples, low, high, middle.place))
        every = [middle, *(each for each in beside if not each.is_open)]
        found += [(low, high, each) for each in sorted(every, key=lambda each: each.place)]
    first, last = found[0][2], found[-1][2]
    if start == samples.span[0] and not first.is_open:
        yield start, first.place, samples.beside(start, first.place)
    yield from found
    if end == samples.span[1] and not last.is_open:
        yield last.place, end, samples.beside(end, last.place)


def _last(parts: Sequence[Sequence[Event]]) -> Attracted | None:
    """The last sample; None if there is none, or an open interval follows it."""
    last = parts[-1][-1] if parts else None
    return last if isinstance(last, Attracted) else None


def _events(samples: Samples, start: Real, end: Real, before: Attracted | None) -> Iterator[Event]:
    """Yield the samples of a part that are not open, and the changes and open intervals between."""
    # the interval of open samples since the last known one; a place if there is none before it
    hidden = None if before else (start, start)
    for low, high, sample in list(_taken(samples, start, end)):
        if sample.is_open:  # another sample of the same interval may be known
            low = max(low, before.place) if before else low
            hidden = (hidden[0] if hidden else low), high
            continue
        changes = list(changes_between(samples, before, sample)) if before else []
        if hidden and not changes:
            hidden = hidden[0], min(hidden[1], sample.place)
            yield from _open_part(samples, before, hidden, sample)
        yield from changes
        yield sample
        before, hidden = sample, None
    if end == samples.span[1]:
        hidden = hidden or (end, end)
    if hidden:
        yield from _open_part(samples, before, hidden, None)


def _open_part(
    samples: Samples, before: Attracted | None, hidden: tuple[Real, Real], after: Attracted | None
) -> Iterator[Onset]:
    """The open interval around a hidden one, between places where cycles beside it may end."""
    first, last = (
        end if sample is None else reach(samples, sample, end)
        for sample, end in zip((before, after), hidden, strict=True)
    )
    if first == last and first in samples.span:  # cycles persist up to an end of the interval
        yield Onset(first, last, is_open=True)
    else:
        yield from open_around(samples, before, (first, last), after)


def _assembled(
    samples: Samples, events: Sequence[Event], low: Real
) -> tuple[list[AttractorCell], list[Crisis]]:
    """Assemble cells and crises from the events to the right of a place."""
    rows, crises = list[tuple[Real, Real, Attracted | None]](), list[Crisis]()
    onsets = [event for event in events if isinstance(event, Onset)]
    seen = [x for event in events for x in (event.beside if isinstance(event, Onset) else (event,))]
    for event in onsets:
        known = [each for each in seen if low < each.place < event.low]
        if known:  # the sample with the smallest denominator stands for the cell
            rows.append((low, event.low, min(known, key=lambda each: QQ.denom(each.place))))
            low = event.low
        if low < event.high:
            if rows and rows[-1][2] is None:  # then both are joined
                low = rows.pop()[0]
            rows.append((low, event.high, None))
            low = event.high
        kind = None if event.is_open else kind_of(samples, event)
        if kind is not None:
            crises.append(_crisis(event, kind))
    return [_cell(samples, *row) for row in rows], crises


def _cell(samples: Samples, low: Real, high: Real, sample: Attracted | None) -> AttractorCell:
    """The cell between two places with a sample; without one it is open."""
    place = simplest_between(low, high) if sample is None else sample.place
    return AttractorCell(
        lower=real_to_sympy(low),
        upper=real_to_sympy(high),
        sample=QQ.to_sympy(place),
        line=samples.line(place),
        cycles=sample.cycles if sample else (),
        bands=tuple(map(samples.formulas, sample.ends)) if sample else (),
        neutral=sample.neutral if sample else (),
        is_open=sample is None,
    )


def _crisis(change: Onset, kind: PointKind) -> Crisis:
    width = to_double(bounds(change.high)[1]) - to_double(bounds(change.low)[0])
    before, after = change.beside
    return Crisis(
        parameter=real_to_sympy(change.place),
        kind=kind,
        bands=(sum(before.counts), sum(after.counts)),
        meetings=change.met,
        width=0.0 if change.is_exact else width,
    )
