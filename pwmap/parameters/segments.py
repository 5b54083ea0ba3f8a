"""Keys of what is followed through the cells of a parameter, segments, and junctions of ends."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from typing import Any, NamedTuple

from pwmap.algebra.exact import Fraction_
from pwmap.diagrams.data import BranchKind
from pwmap.maps.cylinders import Cut, Inclusion
from pwmap.maps.words import Word

Position = Fraction_ | None  # an x as a quotient; None is infinite
# what functions returned for keys and segments, by function; no cut of cells changes it
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
    """What has one key, from one place of the axis to another."""

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
        """Of the words."""
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
    x: float  # the same as a float, infinite also where it is too large for one
    ends: tuple[SegmentEnd, ...]
    attracts: int  # +1: a fixed point attracts here and none of its branches; -1: the reverse
