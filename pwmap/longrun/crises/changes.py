"""Changes of the attractors between two samples of a parameter.

A cycle ends where one of its points meets a break or its multiplier is 1 or -1; bands end or change
where an end of one meets a break or a point of a repelling cycle. If two samples differ, further
ones are taken between neighbouring places of this kind, and close to each of them. A change is
assigned to such a place if it accounts for all differences between the samples on its two sides.
Intervals without such a place are divided; what is not settled in the end is open.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise, product

from pwmap.algebra.exact import Number, dense
from pwmap.algebra.numbers import to_double
from pwmap.algebra.roots import Real, bounds, sign_at
from pwmap.diagrams.data import PointKind
from pwmap.longrun.crises.meetings import Meeting, earliest
from pwmap.longrun.crises.proved import settled
from pwmap.longrun.crises.samples import CLOSER, Attracted, BreakImage, Samples
from pwmap.longrun.line import difference, union
from pwmap.maps.budget import Meter
from pwmap.maps.piecewise_linear import PiecewiseLinearMap
from pwmap.maps.words import CriticalOrbit, units_of

EFFORT = 24  # divisions of an interval in which samples differ, at most
CLOSING = -1  # beside an interval that is open: only places that explain a change count
PLACE = 3  # divisions charged for a place at which samples differ,
LONG = 24  # and for one beside a cycle longer than the order, where changes may accumulate
PERIOD = 8  # up to which repelling cycles are compared with ends of bands, at least
SAME = 1e-4  # of their total width, by which bands that count as the same may differ


@dataclass(frozen=True, slots=True, eq=False)
class Onset:
    """A place at which attractors change, or an interval that contains such places."""

    low: Real  # equal to high if the place is known exactly
    high: Real
    beside: tuple[Attracted, ...] = ()  # samples on both sides, whose attractors persist up to it
    met: tuple[Meeting, ...] = ()  # ends of bands, and the repelling cycles that they meet
    is_open: bool = False  # the interval may contain any number of changes

    @property
    def is_exact(self) -> bool:
        """Whether the place is known exactly."""
        return bool(self.low == self.high)

    @property
    def place(self) -> Real:
        """The place, or the midpoint of the interval."""
        if self.is_exact:
            return self.low
        return (bounds(self.low)[0] + bounds(self.high)[1]) / 2


def changes_between(
    samples: Samples, left: Attracted, right: Attracted, effort: int = EFFORT
) -> Iterator[Onset]:
    """Yield the changes between two samples that are not open, from left to right."""
    if same(samples, left, right):
        return
    if _are_long(samples, left, right) and _is_gap(samples, left, right):
        yield from _open(samples, left, right, effort)
        return
    met = sorted(_places(samples, left, right))
    row = [left, *(samples.between(a, b) for a, b in pairwise(met)), right]
    if met and not any(each.is_open for each in row):
        for place, (x, y) in zip(met, pairwise(row), strict=True):
            yield from _at(samples, place, x, y, effort)
    elif effort > 0:
        third = (right.place - left.place) / 3
        middle = samples.between(left.place + third, right.place - third)
        if middle.is_open:
            yield from _open(samples, left, right, effort)
            return
        yield from changes_between(samples, left, middle, effort - 1)
        yield from changes_between(samples, middle, right, effort - 1)
    elif met or _are_long(samples, left, right):
        yield from _open(samples, left, right, effort)
    else:
        yield Onset(left.place, right.place, (left, right))


def _at(samples: Samples, place: Real, x: Attracted, y: Attracted, effort: int) -> Iterator[Onset]:
    """Yield the changes between samples on both sides of a place at which there may be one."""
    if same(samples, x, y):
        return
    near = _beside(samples, place, x), _beside(samples, place, y)
    if any(each.is_open for each in near):
        yield from _open(samples, x, y, effort)
        return
    used = LONG if _are_long(samples, x, y) else PLACE
    less = min(effort, max(0, effort - used))
    yield from _further(samples, x, near[0], less)
    if _explains(samples, place, *near):
        yield from _exactly(samples, place, *near, less)
    else:
        yield from _further(samples, *near, less)
    yield from _further(samples, near[1], y, less)


def _exactly(
    samples: Samples, place: Real, x: Attracted, y: Attracted, effort: int
) -> Iterator[Onset]:
    """Yield a change at a place that explains it, and those between it and the samples beside."""
    if same(samples, x, y):
        return
    # where a cycle begins or ends, mergings of bands or longer cycles may accumulate
    begins, long = x.words != y.words, _are_long(samples, x, y)
    close = [
        samples.beside(place, each.place, CLOSER) if begins and (long or each.counts) else each
        for each in (x, y)
    ]
    pairs = [*zip(close, (x, y), strict=True)]
    left, right = (far if near.is_open else near for near, far in pairs)
    yield from _further(samples, x, left, effort)
    if all(not near.is_open and same(samples, near, far) for near, far in pairs):
        yield Onset(place, place, (left, right), _places(samples, left, right).get(place, ()))
    else:
        yield from _open(samples, left, right, effort)
    yield from _further(samples, right, y, effort)


def _further(samples: Samples, left: Attracted, right: Attracted, effort: int) -> Iterator[Onset]:
    """Yield the changes between two samples; an open interval if no effort is left."""
    if effort > 0 or same(samples, left, right):
        yield from changes_between(samples, left, right, effort)
    else:
        yield from _open(samples, left, right, effort)


def _beside(samples: Samples, place: Real, sample: Attracted) -> Attracted:
    """A sample close to a place, or the given one if only cycles attract, which last up to it."""
    known = sample.words and not sample.counts
    return sample if known else samples.beside(place, sample.place)


def _explains(samples: Samples, place: Real, left: Attracted, right: Attracted) -> bool:
    """Whether all differences between the samples on both sides of a place may arise there."""
    words = (*left.words, *right.words)
    ends = (samples.ends_of(w, left.place, right.place) for w in words if words.count(w) == 1)
    return (
        # else a cycle ends on the way, and what it gives way to is not known
        all(reach(samples, each, place) == place for each in (left, right))
        and all(place in each for each in ends)
        and place in _places(samples, left, right)
    )


def _is_gap(samples: Samples, left: Attracted, right: Attracted) -> bool:
    """Whether the cycles of the left sample end before those of the right one begin."""
    if left.counts or right.counts:
        return False
    return bool(reach(samples, left, right.place) < reach(samples, right, left.place))


def _are_long(samples: Samples, *both: Attracted) -> bool:
    return any(len(word) > samples.order for each in both for word, _ in each.words)


def _open(samples: Samples, left: Attracted, right: Attracted, effort: int) -> Iterator[Onset]:
    """The open interval between two samples, without the parts in which their cycles persist."""
    low, high = left.place, right.place
    first, last = reach(samples, left, high), reach(samples, right, low)
    # cycles that last up to the other sample do not tell where something changes
    first, last = low if first == high else first, high if last == low else last
    hidden = (first, last) if first < last else (low, high)
    yield from open_around(samples, left, hidden, right, effort)


def open_around(
    samples: Samples,
    left: Attracted | None,
    hidden: tuple[Real, Real],
    right: Attracted | None,
    effort: int = EFFORT,
) -> Iterator[Onset]:
    """An open interval around a hidden one, as large as its ends need, and changes beside it."""
    # its ends are right: up to them attractors are those of the samples beside, if there are any
    before, first = _settled(samples, left, hidden[0], effort)
    after, last = _settled(samples, right, hidden[1], effort)
    if left and before:
        yield from changes_between(samples, left, before, CLOSING)
    yield Onset(first, last, (before, after) if before and after else (), is_open=True)
    if right and after:
        yield from changes_between(samples, after, right, CLOSING)


def _settled(
    samples: Samples, sample: Attracted | None, end: Real, effort: int
) -> tuple[Attracted | None, Real]:
    """A sample that is right up to an end, or to its own place; the same if no effort is left."""
    if sample is None:
        return None, end
    closer, proved = settled(samples, sample, end)
    if effort <= CLOSING and not same(samples, *sorted((closer, sample), key=lambda x: x.place)):
        return sample, sample.place
    return closer, proved


def reach(samples: Samples, sample: Attracted, end: Real) -> Real:
    """The first place from a sample towards an end where a cycle of it may end; or that end."""
    low, high = sorted((sample.place, end))
    ends = (place for word in sample.words for place in samples.ends_of(word, low, high))
    return (min if sample.place < end else max)(ends, default=end)


# --- Whether something differs ------------------------------------------------------------


def same(samples: Samples, left: Attracted, right: Attracted) -> bool:
    """Whether attractors agree at two places and, as far as their words show, between them."""
    if left is right:
        return True
    if (left.counts, left.words) != (right.counts, right.words):
        return False
    if any(samples.ends_of(word, left.place, right.place) for word in left.words):
        return False
    return left.ends == right.ends or _exchanged(samples, left, right)


def _exchanged(samples: Samples, left: Attracted, right: Attracted) -> bool:
    """Whether ends of bands differ only because images of breaks pass one another in between."""
    for one, other in zip(_ends(left), _ends(right), strict=True):
        a, b = (samples.orbits.value(*each) for each in (one, other))
        order = dense(a[0] * b[1] - b[0] * a[1]) if one != other else ()
        # the two images must have opposite orders at the two places, or coincide throughout
        if order and sign_at(order, left.place) * sign_at(order, right.place) > 0:
            return False
    return True


# --- Where something may end --------------------------------------------------------------


def _places(samples: Samples, left: Attracted, right: Attracted) -> dict[Real, tuple[Meeting, ...]]:
    """The places between two samples at which an attractor of either may end, with meetings."""
    low, high = left.place, right.place
    found = dict[Real, tuple[Meeting, ...]]()
    for word in (*left.words, *right.words):
        found |= dict.fromkeys(samples.ends_of(word, low, high), ())
    for sample in (left, right):
        for place, met in _ends_of_bands(samples, sample, low, high):
            found[place] = tuple(dict.fromkeys((*found.get(place, ()), *met)))
    return found


def _ends_of_bands(
    samples: Samples, sample: Attracted, low: Number, high: Number
) -> Iterator[tuple[Real, tuple[Meeting, ...]]]:
    """Yield the places where an end of a band crosses a break or a point of a repelling cycle."""
    ends, breaks = list(dict.fromkeys(_ends(sample))), samples.layout.breaks
    if not ends:
        return
    for end in ends:
        for other in breaks:
            polynomial = samples.orbits.polynomial(CriticalOrbit(*end, other))
            yield from ((root, ()) for root in _crossings(samples, polynomial, low, high))
    for word in samples.repelling(sample.place, max(PERIOD, samples.order)):
        for i, end in product(range(len(word)), ends):
            image, cycle = earliest(end.word, word[i:] + word[:i])
            polynomial = samples.orbits.meeting(end.k, image, cycle)
            number, spelled = breaks.index(end.k), samples.map.spelled
            meeting = Meeting(number, spelled(image), spelled(cycle))
            for root in _crossings(samples, polynomial, low, high):
                yield root, (meeting,)


def _crossings(samples: Samples, polynomial: Number, low: Number, high: Number) -> tuple[Real, ...]:
    """The roots of a polynomial between two places, if it has opposite signs at these."""
    if sign_at(dense(polynomial), low) * sign_at(dense(polynomial), high) < 0:
        return samples.roots(polynomial, low, high)
    samples.meter.spend(1 + len(polynomial))  # the work of both signs
    return ()


def _ends(sample: Attracted) -> Iterator[BreakImage]:
    """Yield the ends of all bands at a sample, as images of breaks."""
    return (end for bands in sample.ends for pair in bands for end in pair)


# --- What happens to bands: they merge, grow, are lost, or a cycle begins -------------------------


def kind_at(
    map_: PiecewiseLinearMap, order: int, place: Real, width: Number, meter: Meter
) -> PointKind | None:
    """The kind of crisis at a place, from samples up to ``width`` on both sides; None if none."""
    low, high = bounds(place)
    samples = Samples(map_, order, meter, (low - width, high + width))
    left = samples.between(low - width, low - width / 2)
    right = samples.between(high + width / 2, high + width)
    if left.is_open or right.is_open or same(samples, left, right):
        return None
    return kind_of(samples, Onset(place, place, (left, right)))


def kind_of(samples: Samples, change: Onset) -> PointKind | None:
    """The kind of a crisis; None if there are no bands, or the same on both sides."""
    left, right = change.beside
    if not left.counts and not right.counts:
        return None
    if not (left.counts and right.counts):
        chaotic, other = (left, right) if left.counts else (right, left)
        new = [word for word in other.cycles if word not in chaotic.cycles]
        for word in new if change.is_exact else ():
            _, flip = units_of(samples.map.numbered(word))
            if sign_at(dense(samples.orbits.polynomial(flip)), change.low) == 0:
                return PointKind.PD
        return PointKind.BC if new else PointKind.FC
    if change.is_exact:
        ours, theirs = (
            union((samples.value(a, change.low), samples.value(b, change.low))
                   for bands in sample.ends for a, b in bands)
            for sample in (left, right)
        )  # fmt: skip
        same = ours == theirs
    else:
        same = _close(left, right)
    if not same:
        return PointKind.XC
    return None if left.counts == right.counts else PointKind.MC


def _close(left: Attracted, right: Attracted) -> bool:
    """Whether the bands at two places cover nearly the same set."""
    one, other = (
        union(
            (to_double(a), to_double(b)) for bands in each.found.bands for a, b in bands.intervals
        )
        for each in (left, right)
    )
    little = SAME * (one[-1][1] - one[0][0])
    return all(b - a <= little for a, b in (*difference(one, other), *difference(other, one)))
