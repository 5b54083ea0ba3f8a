"""Branches as they are put together: legs from special point to special point, and words."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Hashable
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from pwmap.diagrams.diagram import BranchKind, PointKind, PointStatus, Stretch
from woodpecker.base.arrays import Floats
from woodpecker.engine.germs import Beginning
from woodpecker.engine.tracing import Change
from woodpecker.slices.jumps import Jump

Keys = tuple[Hashable, ...]
T = TypeVar("T")
OF_A_LIMIT = "the orbit of a limit of the jump meets a border"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Collision:
    """A cycle that meets a border.

    Its pieces are no part of it: the map is asked for them, so that what starts there does not
    depend on how the collision was met, or on an interruption.
    """

    p: float
    x: Floats  # (n,) points, of minimal period
    # code and note at each point: the jump of P_n may lie on other sides at the next
    kinds: tuple[tuple[PointKind, str], ...]
    cause: str  # a sentence on what happens there
    precision: float  # of the parameter

    def kind_at(self, x: float) -> tuple[PointKind, str]:
        """Code and note at the point nearest to a place."""
        return self.kinds[int(np.argmin(np.abs(self.x - x)))]

    def end_at(self, x: Floats) -> End:
        """The end, or the beginning, of a branch of orbits with points (n,) there."""
        kind, note = self.kind_at(float(x[0]))
        return End(
            kind=kind, p=self.p, x=x, note=note, cause=self.cause, precision=self.precision,
            collision=self,
        )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class End:
    """What ends a branch."""

    kind: PointKind  # code of the special point
    p: float
    x: Floats  # (n,) of the orbit; of a jump the first one only counts
    note: str = ""  # what it leaves open
    cause: str = ""  # a sentence on what happens there
    precision: float = 0.0  # of the parameter; 0 at an end of the span
    status: PointStatus = PointStatus.LOCATED  # located, or the branch was given up here
    collision: Collision | None = None  # the cycle that meets a jump, if one does

    def at(self, x: float) -> End:
        """The end as one of the points of its orbit sees it: there the kind may be another one."""
        if self.collision is None:
            return self
        kind, note = self.collision.kind_at(x)
        return replace(self, kind=kind, note=note)


@dataclass(frozen=True, slots=True, eq=False)
class Word:
    """A stretch of a branch along which no piece changes."""

    first: int  # sample; one at a border has the pieces before it
    text: str  # the words of its pieces
    # of a cycle; of a jump those before the border, and a set of both sides with their margins
    keys: tuple[Hashable, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BranchCurve:
    """A branch between two special points."""

    kind: BranchKind
    order: int  # cycles of P_order, or jumps of it
    parameter: Floats  # (m,) samples, the ends included
    points: tuple[Floats, ...]  # m times (n,) of a cycle, or up to the border of a jump
    multiplier: Floats  # (m,), of a jump nan
    words: tuple[Word, ...]
    marks: tuple[Change, ...]  # the changes between the words
    ends: tuple[End, End]  # why it begins and ends

    @property
    def x(self) -> Floats:
        """(m, n) points of cycles; of jumps (m, 1), for points up to the border vary in number."""
        count = 1 if self.kind is BranchKind.JUMP else self.order
        return np.array([points[:count] for points in self.points])


Start = tuple[Beginning, End]
"""Where a branch begins, or goes on, and the special point there."""


@dataclass(frozen=True, slots=True, eq=False)
class Followed:
    """A branch, and where it goes on beyond its ends."""

    curve: BranchCurve
    onward: tuple[Start, ...]


def keys_of_jump(jump: Jump) -> Keys:
    """The pieces of a jump, see :class:`Word`."""
    sides = {(jump.inner.keys[0], jump.code)}
    if jump.outer_code >= 0:
        sides.add((jump.outer.keys[0], jump.outer_code))
    return *jump.head.keys[:-1], frozenset(sides)


def stretches(curve: BranchCurve) -> tuple[Stretch, ...]:
    """Stretches of a branch with one word, each with the cause of the change that begins it."""
    # One begins with the sample at the border, also if that has the pieces before it. What has no
    # mark is the orbit of a limit of a jump that meets a border where borders accumulate.
    causes = {mark.sample: mark.cause for mark in curve.marks}
    unmarked = OF_A_LIMIT if curve.kind is BranchKind.JUMP else ""
    first, *others = curve.words
    found = [Stretch(0, first.text, "")]
    for word in others:
        if word.text != found[-1].word:
            border = word.first - (word.first - 1 in causes)
            cause = causes.pop(border, "") or unmarked
            found.append(Stretch(max(border, found[-1].first + 1), word.text, cause))
    return tuple(found)


def word_at(curve: BranchCurve, k: int) -> Word:
    """Which pieces a branch takes at a sample."""
    return curve.words[bisect_right(curve.words, k, key=lambda word: word.first) - 1]


def words_between(curve: BranchCurve, k: int) -> list[Word]:
    """Which pieces a branch takes at a sample and at the next."""
    one, other = word_at(curve, k), word_at(curve, k + 1)
    return [one] if one is other else [one, other]


def from_point(values: tuple[T, ...], shift: int) -> tuple[T, ...]:
    """Values along a cycle from another of its points on."""
    return (*values[shift:], *values[:shift])


def agree(one: Keys, other: Keys) -> bool:
    """Whether two orbits take the same pieces; at a border one side is enough."""
    # The piece on the other side of a jump may be so thin that rounding decides whether it is seen.
    return len(one) == len(other) and all(
        not a.isdisjoint(b) if isinstance(a, frozenset) and isinstance(b, frozenset) else a == b
        for a, b in zip(one, other, strict=True)
    )
