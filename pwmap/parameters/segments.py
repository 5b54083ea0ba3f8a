"""What is followed through the cells of a parameter: segments, their ends, curves of segments.

Where the orbit of a limit of a crossing jump meets another break, one jump ends and another one of
the same iterate begins. Their segments continue each other: the branch goes on with another word.
Where more than two jumps of an iterate meet, or one ends alone, branches end.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeVar

from pwmap.algebra.exact import Fraction_, Infinite
from pwmap.diagrams.data import BranchKind
from pwmap.maps.cylinders import Cut, Inclusion
from pwmap.maps.words import Word

Position = Fraction_ | None  # an x as a quotient; None is infinite
# results for keys and segments, by function; they stay valid when cells are cut further
Known = defaultdict[object, dict[Any, Any]]
LEFT, ALONG, RIGHT = -1, 0, 1  # of an end: the branch lies at smaller, equal, larger parameters


@dataclass(frozen=True, slots=True)
class BranchKey:
    """What identifies a branch from cell to cell."""

    kind: BranchKind
    words: tuple[Word, ...]  # of a fixed point, or of both sides of a jump
    cut: Cut | None = None  # of the jump, or the end of a piece that is the identity

    @property
    def word(self) -> Word:
        """The word of a fixed point, or the left one of a jump."""
        return self.words[0]


class Location(NamedTuple):
    """How a fixed point lies in its cylinder, and whether it attracts there."""

    inclusion: Inclusion
    stable: bool

    @property
    def is_isolated(self) -> bool:
        """Whether its cylinder is that point alone: then it has no slope."""
        return self.inclusion is Inclusion.POINT

    @property
    def is_inside(self) -> bool:
        """Whether it lies on no border."""
        return self.inclusion is Inclusion.INSIDE


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """A fixed point or jump with one key, from one place of the axis to another."""

    key: BranchKey
    places: tuple[Any, Any]
    closed: tuple[bool, bool] = (True, True)  # whether it exists at its ends too
    location: Location | None = None  # how its fixed points lie in their cylinders
    band: tuple[Position, Position] | None = None  # along one value: the x of its ends

    @property
    def is_isolated(self) -> bool:
        """Whether its cylinders are single points: then it has no slope."""
        return self.location is not None and self.location.is_isolated


@dataclass(frozen=True, slots=True, eq=False)
class SegmentEnd:
    """One end of a segment."""

    segment: Segment
    which: int  # 0 or 1: the first or the last
    side: int  # LEFT, ALONG or RIGHT, as seen from the end
    unit: int  # +1 or -1 if that is the multiplier there and not elsewhere, otherwise 0
    is_steep: bool  # whether the multiplier near it is larger than 1 in size
    x: Position  # as a quotient
    value: Any  # the same in canonical form, or Infinite

    @property
    def is_fixed(self) -> bool:
        """Whether it is the end of a branch of fixed points."""
        return self.segment.key.kind is BranchKind.FIXED_POINT

    @property
    def length(self) -> int:
        """The length of the words."""
        return len(self.segment.key.word)

    @property
    def place(self) -> Any:
        """Where on the axis it lies."""
        return self.segment.places[self.which]


@dataclass(frozen=True, slots=True, eq=False)
class Junction:
    """The ends of segments that lie at one place."""

    place: Any
    value: Any  # the common x in canonical form, or Infinite
    ends: tuple[SegmentEnd, ...]
    attracts: int  # +1: a fixed point attracts here and none of its branches; -1: the reverse


Thing = TypeVar("Thing", bound=Hashable)
Tip = tuple[Segment, int]  # one end of a segment: 0 or 1, the first or the last
SegmentCurve = list[Tip]  # segments one after the other, each with the end at which it is entered


def ends_of_line(line: Sequence[tuple[Thing, int]]) -> tuple[tuple[Thing, int], tuple[Thing, int]]:
    """Where a line of :func:`traced` starts and where it ends."""
    last, entered = line[-1]
    return line[0], (last, 1 - entered)


def connected(
    segments: Sequence[Segment], junctions: Sequence[Junction], stops: Sequence[Any]
) -> tuple[list[SegmentCurve], list[Junction]]:
    """Join segments; returns curves, each from its first junction on, and their junctions."""
    following = {
        tip: other
        for junction in junctions
        # every branch ends at a stop
        if junction.place not in stops and not isinstance(junction.value, Infinite)
        for pair in _passing(junction)
        for tip, other in (pair, pair[::-1])
    }
    found = list(traced(segments, following))
    tips = {tip for curve in found for tip in ends_of_line(curve)}
    left = [
        replace(junction, ends=ends)
        for junction in junctions
        if (ends := tuple(end for end in junction.ends if _tip(end) in tips))
    ]
    rank = {_tip(end): i for i, junction in enumerate(left) for end in junction.ends}
    return [curve if rank[curve[0]] <= rank[ends_of_line(curve)[1]] else _turned(curve)
            for curve in found], left  # fmt: skip


def _turned(curve: SegmentCurve) -> SegmentCurve:
    return [(segment, 1 - entered) for segment, entered in reversed(curve)]


def _tip(end: SegmentEnd) -> Tip:
    return end.segment, end.which


def _passing(junction: Junction) -> Iterator[tuple[Tip, Tip]]:
    """Pairs of ends that continue each other, where only jumps meet."""
    if any(end.is_fixed for end in junction.ends):
        return
    own: dict[int, list[SegmentEnd]] = defaultdict(list)
    for end in junction.ends:
        own[end.length].append(end)
    for ends in own.values():
        beside = [_tip(end) for end in ends if end.side != ALONG]
        here = [_tip(end) for end in ends if end.side == ALONG]
        if len(beside) == 2 and len(here) in (0, 2):
            # between the two a jump along this one value of the parameter may lie
            line = [beside[0], *here, beside[1]]
            yield from zip(line[::2], line[1::2], strict=True)


def traced(
    things: Iterable[Thing], following: Mapping[tuple[Thing, int], tuple[Thing, int]]
) -> Iterator[list[tuple[Thing, int]]]:
    """Join things with two ends, 0 and 1, to lines: each with the end at which it is entered."""
    passed = set[Thing]()
    for thing in things:
        if thing in passed:
            continue
        # back to an end, or once round: a closed line begins at its first thing
        first = start = thing, 0
        while start in following:
            before, met = following[start]
            start = before, 1 - met
            if start == first:
                break
        line = [start]
        while (onward := following.get((line[-1][0], 1 - line[-1][1]))) not in (None, start):
            assert onward is not None
            line.append(onward)
        passed.update(each for each, _ in line)
        yield line
