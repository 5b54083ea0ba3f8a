"""Segments that go on in each other: where only jumps meet a branch passes, and its word changes.

A jump crosses the diagonal with limits on both sides of it, so that nothing is born or lost where
the orbit of a limit meets another break: one jump ends there and another one of the same iterate
begins, on the other side of the parameter, or on the same side where it turns round. That is a mark
on a branch. Where more than two jumps of one iterate meet, or one ends alone, branches end.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from pwmap.algebra.exact import Infinite
from pwmap.parameters.segments import ALONG, Junction, Segment, SegmentEnd

Tip = tuple[Segment, int]  # one end of a segment: 0 or 1, the first or the last


@dataclass(frozen=True, slots=True, eq=False)
class SegmentCurve:
    """Segments one after the other, from one special point to another.

    Attributes
    ----------
    segments
        One or more, each continued by the next.
    turned
        For each of them whether it is passed from its last end to its first.
    """

    segments: tuple[Segment, ...]
    turned: tuple[bool, ...]

    @property
    def tips(self) -> tuple[Tip, Tip]:
        """Where it starts and where it ends."""
        return (self.segments[0], int(self.turned[0])), (self.segments[-1], 1 - self.turned[-1])

    @property
    def length(self) -> int:
        """Of the words."""
        return len(self.segments[0].key.word)

    def reversed(self) -> SegmentCurve:
        """The same from its other end."""
        return SegmentCurve(self.segments[::-1], tuple(not turned for turned in self.turned[::-1]))


def connected(
    segments: Sequence[Segment], junctions: Sequence[Junction], stops: Sequence[Any]
) -> tuple[list[SegmentCurve], list[Junction]]:
    """The curves that segments make, and the junctions that are left, in which curves end.

    Parameters
    ----------
    segments, junctions
        As :class:`pwmap.parameters.branches.Continuation` has them.
    stops
        Places at which every branch ends.

    Returns
    -------
    Curves start at the one of their ends that comes first; junctions have the ends of curves only.
    """
    following = {
        tip: other
        for junction in junctions
        if junction.place not in stops and not isinstance(junction.value, Infinite)
        for pair in _passing(junction)
        for tip, other in (pair, pair[::-1])
    }
    found = list(_traced(segments, following))
    tips = {tip for curve in found for tip in curve.tips}
    left = [
        replace(junction, ends=ends)
        for junction in junctions
        if (ends := tuple(end for end in junction.ends if _tip(end) in tips))
    ]
    rank = {_tip(end): i for i, junction in enumerate(left) for end in junction.ends}
    return [
        curve if rank[curve.tips[0]] <= rank[curve.tips[1]] else curve.reversed() for curve in found
    ], left


def _tip(end: SegmentEnd) -> Tip:
    return end.segment, end.which


def _passing(junction: Junction) -> Iterator[tuple[Tip, Tip]]:
    """Pairs of ends that go on in each other, where only jumps meet.

    With those of one iterate on both sides of the meeting there may be one more, right at it.
    """
    if any(end.is_fixed for end in junction.ends):
        return
    own: dict[int, list[SegmentEnd]] = defaultdict(list)
    for end in junction.ends:
        own[end.length].append(end)
    for ends in own.values():
        beside = [_tip(end) for end in ends if end.side != ALONG]
        here = [_tip(end) for end in ends if end.side == ALONG]
        if len(beside) == 2 and len(here) in (0, 2):
            line = [beside[0], *here, beside[1]]
            yield from zip(line[::2], line[1::2], strict=True)


def _traced(segments: Iterable[Segment], following: dict[Tip, Tip]) -> Iterator[SegmentCurve]:
    """Curves through all segments; one that closes is opened at the start of its first segment."""
    passed: set[Segment] = set()
    for segment in segments:
        if segment in passed:
            continue
        start = (segment, 0)
        while start in following:
            before, which = following[start]
            start = (before, 1 - which)
            if start == (segment, 0):
                del following[following.pop(start)]
        line = [start]
        while (tip := (line[-1][0], 1 - line[-1][1])) in following:
            line.append(following[tip])
        passed.update(each for each, _ in line)
        yield SegmentCurve(tuple(each for each, _ in line), tuple(which == 1 for _, which in line))
