"""Branches as they are put together: legs from special point to special point, and words."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np

from pwmap.diagrams.diagram import BranchKind, PointKind, PointStatus, Stretch
from woodpecker.base.arrays import Floats
from woodpecker.engine.arrivals import Arrival
from woodpecker.engine.curves import Sample, SolutionCurve
from woodpecker.engine.germs import Beginning, beginnings, judged, shared
from woodpecker.engine.maps import first_link, length_of
from woodpecker.engine.newton import STEEP, Problem
from woodpecker.engine.orbits import Chained, OnBorder, SpaceOrbit
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
    x: Floats  # (n, d) points, of minimal period
    # code and note at each point: the jump of P_n may lie on other sides at the next
    kinds: tuple[tuple[PointKind, str], ...]
    cause: str  # a sentence on what happens there
    precision: float  # of the parameter

    def kind_at(self, x: Floats) -> tuple[PointKind, str]:
        """Code and note at the point nearest to a place (d,)."""
        return self.kinds[int(np.abs(self.x - x).max(axis=1).argmin())]

    def end_at(self, x: Floats, cycle: SpaceOrbit | None = None) -> End:
        """The end, or the beginning, of a branch of orbits with points (n, d) there."""
        kind, note = self.kind_at(x[0])
        return End(
            kind=kind, p=self.p, x=x, note=note, cause=self.cause, precision=self.precision,
            collision=self, cycle=cycle,
        )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class End:
    """What ends a branch."""

    kind: PointKind  # code of the special point
    p: float
    x: Floats  # (n, d) of the orbit; of a jump the first one only counts
    note: str = ""  # what it leaves open
    cause: str = ""  # a sentence on what happens there
    precision: float = 0.0  # of the parameter; 0 at an end of the span
    status: PointStatus = PointStatus.LOCATED  # located, or the branch was given up here
    collision: Collision | None = None  # the cycle that meets a jump, if one does
    # the orbit there, with the pieces of the branch; not kept in a file
    cycle: SpaceOrbit | None = field(default=None, compare=False)

    def at(self, x: Floats) -> End:
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
    points: tuple[Floats, ...]  # m times (n, d) of a cycle, or up to the border of a jump
    multiplier: Floats  # (m,) the largest, of a complex pair the modulus; of a jump nan
    words: tuple[Word, ...]
    marks: tuple[Change, ...]  # the changes between the words
    ends: tuple[End, End]  # why it begins and ends

    @property
    def x(self) -> Floats:
        """(m, n, d) points of cycles; of jumps n = 1, as those up to the border vary in number."""
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


# --- From the engine ------------------------------------------------------------------------------


def curve_of(
    begin: Beginning, samples: Sequence[Sample], changes: Sequence[Change], ends: tuple[End, End]
) -> BranchCurve:
    """A branch as it is kept."""
    # A point beside which the first sample was looked for has the pieces of what led there.
    own, words = samples[begin.before is not None :] or samples, list[Word]()
    for k, sample in enumerate(own, start=len(samples) - len(own)):
        keys = keys_of(sample.orbit, begin.curve.problem)
        if not words or keys != words[-1].keys:
            words.append(Word(k if words else 0, text_of(sample.orbit), keys))
    column = begin.curve.problem.free[0]
    return BranchCurve(
        kind=begin.kind, order=begin.order,
        parameter=np.array([float(s.orbit.p[column]) for s in samples]),
        points=tuple(s.orbit.x for s in samples),
        multiplier=np.array([multiplier_of(s.orbit) for s in samples]),
        words=tuple(words), marks=tuple(changes), ends=ends,
    )  # fmt: skip


def multiplier_of(orbit: SpaceOrbit) -> float:
    """The largest multiplier of a cycle, of a complex pair the modulus; nan of a crossing."""
    if orbit.outer is not None:
        return math.nan
    if orbit.x.shape[1] == 1:
        return float(orbit.monodromy[0, 0])
    largest = orbit.multipliers()[0]
    return float(abs(largest) if largest.imag else largest.real)


def located(curve: SolutionCurve, orbit: SpaceOrbit) -> tuple[SpaceOrbit, Problem]:
    """An orbit of a curve and its equations; of a crossing in R^1 its points up to the border."""
    if orbit.outer is None or orbit.x.shape[1] > 1:
        return orbit, curve.problem
    border, last = curve.problem.conditions[-1], orbit.images[-1]
    assert isinstance(border, OnBorder)
    images = *orbit.images[:-1], first_link(last).at(orbit.x[-1], orbit.p)
    head = SpaceOrbit(orbit.x, orbit.p, 0.0, images)
    return head, up_to_border(curve.problem, len(head.x), border.code // length_of(last))


def up_to_border(base: Problem, n: int, code: int) -> Problem:
    """The equations of n points that follow each other to where a margin vanishes at the last."""
    return replace(base, conditions=(Chained(), OnBorder(n - 1, code)))


def keys_of(orbit: SpaceOrbit, problem: Problem) -> Keys:
    """The pieces of an orbit, see :class:`Word`."""
    if orbit.outer is None:
        return orbit.keys
    x, p, sides = orbit.x[-1], orbit.p, set[object]()
    is_line = orbit.x.shape[1] == 1
    border = shared(orbit.images[-1], orbit.outer, x, p, problem.lengths) or ([], [])
    for image, codes in zip((orbit.images[-1], orbit.outer), border, strict=True):
        length, key = length_of(image), first_link(image).key if is_line else image.piece.key
        sides |= {(key, code // length) for code in codes if code % length == 0} or {(key, -1)}
    # On the line the border alone says where a jump is. In R^d both limits do, by all their pieces.
    both = frozenset(sides) if is_line else frozenset([frozenset(sides)])
    return *(image.piece.key for image in orbit.images[:-1]), both


def text_of(orbit: SpaceOrbit) -> str:
    """The words of a cycle; of a crossing in R^1 those of its limits, from left to right."""
    if orbit.outer is None or orbit.x.shape[1] > 1:
        return orbit.word
    head = [image.piece.word for image in orbit.images[:-1]]
    inner, outer = (
        " | ".join([*head, side.piece.word]) for side in (orbit.images[-1], orbit.outer)
    )
    return f"{outer} / {inner}" if _inner_side(orbit) > 0 else f"{inner} / {outer}"


def _inner_side(orbit: SpaceOrbit) -> int:
    """On which side of the first point the inner limit is."""
    last = orbit.images[-1]
    zero = np.flatnonzero(last.tied(orbit.x[-1], orbit.p))
    side = math.copysign(1.0, float(last.gradients[zero[0], 0])) if len(zero) else 1.0
    for image in orbit.images[:-1]:
        side = math.copysign(1.0, side * float(image.jacobian[0, 0]))
    return int(side)


def end_of(arrival: Arrival, base: SolutionCurve, orbit: SpaceOrbit) -> End:
    """What a branch comes to, seen from the first point of its last orbit."""
    cycle, x = arrival.orbit, orbit.x
    if arrival.kind is PointKind.PD:  # one that is half as long, where a doubled cycle ends
        x = np.tile(cycle.x, (len(x) // len(cycle.x), 1))
    if arrival.collides:
        collision, smoothest = collision_of(arrival, base)
        return collision.end_at(x, smoothest)
    return End(
        kind=arrival.kind, p=float(cycle.p[base.problem.free[0]]), x=x, note=arrival.note,
        cause=arrival.cause, precision=arrival.precision, status=arrival.status, cycle=cycle,
    )  # fmt: skip


def collision_of(arrival: Arrival, base: SolutionCurve) -> tuple[Collision, SpaceOrbit]:
    """A cycle that meets a border, from its least point on; and as that of its smoothest pieces."""
    cycle = arrival.orbit
    n = len(cycle.x)
    cycle = cycle.rotated(int(np.argmin(cycle.x[:, 0])))
    starts = list(beginnings(base, cycle.x, cycle.p, (n, 2 * n)))
    kinds = [judged(starts, cycle.x, i, base.problem) for i in range(n)]
    kinds = [(kind, note or arrival.note) for kind, note in kinds]
    found = Collision(
        p=float(cycle.p[base.problem.free[0]]), x=cycle.x, kinds=tuple(kinds),
        cause=arrival.cause, precision=arrival.precision,
    )  # fmt: skip
    return found, _smoothest(arrival.orbit, starts, base.problem)


def _smoothest(cycle: SpaceOrbit, starts: Sequence[Beginning], problem: Problem) -> SpaceOrbit:
    """A cycle, or if it ends in a root that of smooth pieces, if one starts there."""

    def steepest(orbit: SpaceOrbit) -> float:
        return max(map(problem.steepest, orbit.images))

    if not steepest(cycle) > STEEP:
        return cycle
    others = [
        begin.sample.orbit
        for begin in starts
        if begin.order == len(cycle.x) and not begin.is_crossing
    ]
    return min([cycle, *others], key=steepest)
