"""What is followed through the cells of a parameter: keys, segments, and where their ends meet."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from sympy import Basic

from pwmap.algebra.exact import Fraction_, cancelled
from pwmap.diagrams.data import BranchKind, FloatArray
from pwmap.maps.cylinders import Cut, Inclusion, StudiedIterate
from pwmap.maps.words import Orbits, Word

Position = Fraction_ | None  # an x as a quotient; None is infinite
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

    def x(self, orbits: Orbits) -> Fraction_:
        """Its position as a quotient in lowest terms; see :meth:`Continuation.position`."""
        if self.cut is None:
            return cancelled(orbits.fixed_point(self.word))
        return cancelled(orbits.preimage(self.cut.k, self.word[: self.cut.steps]))


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


@dataclass(frozen=True, slots=True, eq=False)
class KnownValues:
    """What was computed of keys and segments, which no cut of cells changes."""

    keys: dict[BranchKey, BranchKey] = field(default_factory=dict)  # one object for each
    present: dict[int, tuple[StudiedIterate, Present]] = field(default_factory=dict)  # by id
    positions: dict[BranchKey, Fraction_] = field(default_factory=dict)
    numbers: dict[tuple[BranchKey, Any], float] = field(default_factory=dict)
    values: dict[tuple[BranchKey, Any], Any] = field(default_factory=dict)
    units: dict[tuple[Any, Any], int] = field(default_factory=dict)
    segments: dict[Hashable, Segment] = field(default_factory=dict)  # by all that they hold
    ends: dict[Segment, tuple[SegmentEnd, SegmentEnd]] = field(default_factory=dict)
    formulas: dict[Segment, dict[str, Basic]] = field(default_factory=dict)
    arrays: dict[Segment, FloatArray] = field(default_factory=dict)


Present = list[tuple[BranchKey, Location | None]]  # what of an iterate lies on the diagonal
