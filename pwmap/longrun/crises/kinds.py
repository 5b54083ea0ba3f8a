"""What happens to bands where they change: they merge, grow, are lost, or a cycle begins."""

from __future__ import annotations

from pwmap.algebra.exact import Number
from pwmap.algebra.roots import Real, bounds
from pwmap.diagrams.data import PointKind
from pwmap.longrun.crises.changes import Changes, Onset
from pwmap.longrun.crises.samples import Attracted, Samples
from pwmap.longrun.line import Interval, joined
from pwmap.longrun.numbers import to_double
from pwmap.maps.budget import Meter
from pwmap.maps.piecewise_linear import PiecewiseLinearMap
from pwmap.maps.words import MultiplierSign, Word
from pwmap.parameters.recorded import axis_of

SAME = 1e-4  # of their length: so little may bands differ that are the same, in a short interval


def kind_at(
    map_: PiecewiseLinearMap, name: str, order: int, place: Real, width: Number,
    meter: Meter,
) -> PointKind | None:  # fmt: skip
    """What happens to bands at a place, from what attracts a half and one width beside it."""
    samples = Samples(map_, axis_of(map_.definition, name, {}), meter)
    low, high = bounds(place)
    left = samples.between(low - width, low - width / 2)
    right = samples.between(high + width / 2, high + width)
    if left.is_open or right.is_open or Changes(samples, order).same(left, right):
        return None
    return kind_of(samples, Onset(place, place, left, right))


def kind_of(samples: Samples, change: Onset) -> PointKind | None:
    """What happens to bands at a change; None if nothing does."""
    left, right = change.before, change.after
    if not left.counts and not right.counts:
        return None
    if not (left.counts and right.counts):
        chaotic, other = (left, right) if left.counts else (right, left)
        return _end(samples, chaotic, other, change)
    if change.is_exact:
        same = _set_at(samples, left, change.low) == _set_at(samples, right, change.low)
    else:
        same = left.counts == right.counts and _close(left, right)
    if not same:
        return PointKind.XC
    return None if left.counts == right.counts else PointKind.MC


def _end(samples: Samples, chaotic: Attracted, other: Attracted, change: Onset) -> PointKind:
    """How bands end beyond which there are none."""
    new = [word for word in other.cycles if word not in chaotic.cycles]
    if not new:
        return PointKind.FC
    flips = (_flip(samples, word) for word in new)
    if change.is_exact and any(samples.axis.sign(flip, change.low) == 0 for flip in flips):
        return PointKind.PD
    return PointKind.BC


def _flip(samples: Samples, word: str) -> Number:
    """A polynomial that is zero where a cycle has the multiplier -1."""
    letters: Word = tuple(sorted(map(samples.map.letters.index, word)))
    return samples.axis.orbits.polynomial(MultiplierSign(letters, -1))


def _set_at(samples: Samples, sample: Attracted, place: Real) -> list[Interval]:
    """All bands with their ends at another place, joined."""
    return joined(
        (samples.value(a, place), samples.value(b, place))
        for bands in sample.ends
        for a, b in bands
    )


def _close(left: Attracted, right: Attracted) -> bool:
    """Whether bands at two places may be the same by what they are there."""
    one, other = (
        [to_double(x) for bands in each.found.bands for pair in bands.intervals for x in pair]
        for each in (left, right)
    )
    scale = max(one) - min(one)
    return max(abs(a - b) for a, b in zip(one, other, strict=True)) <= SAME * scale
