"""The data of branches between special points: samples, the words along them, and their ends."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np

from pwmap.diagrams.data import INTERVAL, BranchKind, PointKind, PointStatus, Stretch
from woodpecker.base.arrays import Floats
from woodpecker.engine.arrivals import Arrival
from woodpecker.engine.curves import Sample, SolutionCurve
from woodpecker.engine.germs import (
    Beginning,
    beginnings,
    collision_kind,
    is_neutral,
    shared,
)
from woodpecker.engine.maps import first_piece_of, length_of
from woodpecker.engine.newton import STEEP, Problem
from woodpecker.engine.orbits import Chained, OnBorder, SpaceOrbit
from woodpecker.engine.tracing import Change
from woodpecker.slices.jumps import Jump

Keys = tuple[Hashable, ...]
T = TypeVar("T")
OF_A_LIMIT = "the orbit of a limit of the jump meets a border"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Collision:
    """A border collision: a cycle that meets a border.

    It does not hold the pieces of the cycle: the map is asked for them, so that what starts there
    depends neither on the branch that led there nor on an interruption.
    """

    p: float
    x: Floats  # (n, d) points, of minimal period
    # Code and note at each point, which may differ: at the next point the limits of the jump of P_n
    # may lie on other sides of the diagonal.
    kinds: tuple[tuple[PointKind, str], ...]
    cause: str  # a sentence on what happens there
    precision: float  # of the parameter

    def kind_at(self, x: Floats) -> tuple[PointKind, str]:
        """The code and note at that point of the cycle which is nearest to x (d,)."""
        return self.kinds[int(np.abs(self.x - x).max(axis=1).argmin())]

    def end_at(self, x: Floats, cycle: SpaceOrbit | None = None) -> End:
        """The end, or the beginning, of a branch whose orbit there has the points x (n, d)."""
        kind, note = self.kind_at(x[0])
        return End(
            kind=kind, p=self.p, x=x, note=note, cause=self.cause, precision=self.precision,
            collision=self, cycle=cycle,
        )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class End:
    """The special point in which a branch ends or begins, as the branch sees it."""

    kind: PointKind  # code of the special point
    p: float
    x: Floats  # (n, d) points of the orbit; of a jump only the first one counts
    note: str = ""  # what the code does not say, such as "fold", or why the branch ends
    cause: str = ""  # a sentence on what happens there
    precision: float = 0.0  # of the parameter; 0 at an end of the span
    status: PointStatus = PointStatus.LOCATED  # located, or the branch was given up here
    collision: Collision | None = None  # the border collision, if it is one
    # The orbit there, on the pieces of the branch; it is not stored in files.
    cycle: SpaceOrbit | None = field(default=None, compare=False)

    def at(self, x: Floats) -> End:
        """The end as seen from the point x of its cycle, where its kind may be another one."""
        if self.collision is None:
            return self
        kind, note = self.collision.kind_at(x)
        return replace(self, kind=kind, note=note)


@dataclass(frozen=True, slots=True, eq=False)
class Word:
    """A stretch of a branch along which no piece changes."""

    first: int  # its first sample; a sample at a border has the pieces before it
    text: str  # the words of its pieces
    # Keys of the pieces of a cycle; of a jump those before the border, then the set of both sides,
    # each a piece, the margin that vanishes and, on the line, the side of x_0 where it is taken:
    # a thin piece may have the same neighbour on both sides.
    keys: tuple[Hashable, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BranchCurve:
    """A branch between two special points."""

    kind: BranchKind
    order: int  # cycles of P_order, or jumps of it
    parameter: Floats  # (m,) samples, the ends included
    points: tuple[Floats, ...]  # m times (n, d) of a cycle, or up to the border of a jump
    multiplier: Floats  # (m,) the largest one, the modulus of a complex pair; nan for a jump
    words: tuple[Word, ...]
    marks: tuple[Change, ...]  # the changes of word
    ends: tuple[End, End]  # the special points where it begins and ends

    @property
    def x(self) -> Floats:
        """Points (m, n, d) of cycles; of jumps only the first, n = 1, as their number varies."""
        count = 1 if self.kind is BranchKind.JUMP else self.order
        return np.array([points[:count] for points in self.points])


Start = tuple[Beginning, End]
"""The first sample of a branch that begins or goes on, and the special point there."""


@dataclass(frozen=True, slots=True, eq=False)
class Followed:
    """A branch that was followed, and the branches that continue it beyond its ends."""

    curve: BranchCurve
    onward: tuple[Start, ...]


def keys_of_jump(jump: Jump) -> Keys:
    """The keys of the pieces of a jump, see :class:`Word`."""
    sides = {(jump.inner.keys[0], jump.code, jump.inner_side)}
    if jump.outer_code >= 0:
        sides.add((jump.outer.keys[0], jump.outer_code, -jump.inner_side))
    return *jump.head.keys[:-1], frozenset(sides)


def stretches(curve: BranchCurve) -> tuple[Stretch, ...]:
    """The stretches of a branch with one word each, with the cause of the change before them."""
    # A stretch begins at the sample on the border, even though that sample has the pieces before
    # it. A change without a mark is that of a limit of a jump where borders accumulate.
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
    """The word of a branch at a sample."""
    return curve.words[bisect_right(curve.words, k, key=lambda word: word.first) - 1]


def words_between(curve: BranchCurve, k: int) -> list[Word]:
    """The words, one or two, of a branch at a sample and at the next."""
    one, other = word_at(curve, k), word_at(curve, k + 1)
    return [one] if one is other else [one, other]


def from_point(values: tuple[T, ...], shift: int) -> tuple[T, ...]:
    """Values along a cycle, starting from its point number ``shift``."""
    return (*values[shift:], *values[:shift])


def agree(one: Keys, other: Keys) -> bool:
    """Whether two orbits take the same pieces; of a jump one common side is enough."""
    # The piece on its other side may be so thin that rounding decides whether it is found.
    return len(one) == len(other) and all(
        not a.isdisjoint(b) if isinstance(a, frozenset) and isinstance(b, frozenset) else a == b
        for a, b in zip(one, other, strict=True)
    )


# --- From the engine ------------------------------------------------------------------------------


def curve_of(
    begin: Beginning, samples: Sequence[Sample], changes: Sequence[Change], ends: tuple[End, End]
) -> BranchCurve:
    """The branch with given samples, changes of word, and ends."""
    # If the branch was started beside its special point, the sample at that point itself has the
    # pieces of the branch that led there: it takes no part in the words.
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
    """The largest multiplier of a cycle, the modulus of a complex pair; nan for a crossing."""
    if orbit.outer is not None:
        return math.nan
    if orbit.x.shape[1] == 1:
        return float(orbit.monodromy[0, 0])
    largest = orbit.multipliers()[0]
    return float(abs(largest) if largest.imag else largest.real)


def orbit_and_problem(curve: SolutionCurve, orbit: SpaceOrbit) -> tuple[SpaceOrbit, Problem]:
    """An orbit of a curve, and its equations; a crossing in R^1 becomes its border orbit."""
    if orbit.outer is None or orbit.x.shape[1] > 1:
        return orbit, curve.problem
    border, last = curve.problem.conditions[-1], orbit.images[-1]
    assert isinstance(border, OnBorder)
    images = *orbit.images[:-1], first_piece_of(last).at(orbit.x[-1], orbit.p)
    head = SpaceOrbit(orbit.x, orbit.p, 0.0, images)
    return head, up_to_border(curve.problem, len(head.x), border.code // length_of(last))


def up_to_border(base: Problem, n: int, code: int) -> Problem:
    """The problem of border orbits of n points, at the last of which a margin vanishes."""
    return replace(base, conditions=(Chained(), OnBorder(n - 1, code)))


def keys_of(orbit: SpaceOrbit, problem: Problem) -> Keys:
    """The keys of the pieces of an orbit, see :class:`Word`."""
    if orbit.outer is None:
        return orbit.keys
    x, p, sides = orbit.x[-1], orbit.p, set[object]()
    is_line = orbit.x.shape[1] == 1
    slopes = (float(image.jacobian[0, 0]) for image in orbit.images[:-1])
    turns = math.prod(map(np.sign, slopes)) if is_line else 0.0  # falling returns turn the sides
    border = shared(orbit.images[-1], orbit.outer, x, p, problem.lengths) or ([], [])
    for image, codes in zip((orbit.images[-1], orbit.outer), border, strict=True):
        length, key = length_of(image), first_piece_of(image).key if is_line else image.piece.key
        side = turns * np.sign(image.gradients[:, 0])
        zero = [code for code in codes if code % length == 0]
        found = {(key, code // length, side[image.index_of(code)]) for code in zero}
        sides |= found or {(key, -1, 0.0)}
    # On the line the border alone determines the place of a jump; in R^d all pieces of both limits.
    last = frozenset(sides) if is_line else frozenset([frozenset(sides)])
    return *(image.piece.key for image in orbit.images[:-1]), last


def text_of(orbit: SpaceOrbit) -> str:
    """The words of a cycle; of a crossing in R^1 those of its limits, that from the left first."""
    if orbit.outer is None or orbit.x.shape[1] > 1:
        return orbit.word
    head = [image.piece.word for image in orbit.images[:-1]]
    inner, outer = (
        " | ".join([*head, side.piece.word]) for side in (orbit.images[-1], orbit.outer)
    )
    return f"{outer} / {inner}" if _inner_side(orbit) > 0 else f"{inner} / {outer}"


def _inner_side(orbit: SpaceOrbit) -> int:
    """The side of x_0 on which a crossing in R^1 has its inner limit: 1 if at larger x, else -1."""
    last = orbit.images[-1]
    zero = np.flatnonzero(last.tied(orbit.x[-1], orbit.p))
    # The inner piece lies where its margin grows; each falling return before turns the side.
    side = math.copysign(1.0, float(last.gradients[zero[0], 0])) if len(zero) else 1.0
    for image in orbit.images[:-1]:
        side = math.copysign(1.0, side * float(image.jacobian[0, 0]))
    return int(side)


def end_of(arrival: Arrival, base: SolutionCurve, orbit: SpaceOrbit) -> End:
    """The end of a branch: its arrival, as seen from the first point of its last orbit."""
    cycle, x = arrival.orbit, orbit.x
    if arrival.kind is PointKind.PD:  # a doubled cycle ends in one that is half as long
        x = np.tile(cycle.x, (len(x) // len(cycle.x), 1))
    if arrival.collides:
        collision, smoothest = collision_of(arrival, base)
        return collision.end_at(x, smoothest)
    return End(
        kind=arrival.kind, p=float(cycle.p[base.problem.free[0]]), x=x, note=arrival.note,
        cause=arrival.cause, precision=arrival.precision, status=arrival.status, cycle=cycle,
    )  # fmt: skip


def collision_of(arrival: Arrival, base: SolutionCurve) -> tuple[Collision, SpaceOrbit]:
    """The border collision of an arrival, from its least point on; its cycle on smooth pieces."""
    cycle = arrival.orbit
    n = len(cycle.x)
    cycle = cycle.rotated(int(np.argmin(cycle.x[:, 0])))
    orders = (n,) if cycle.x.shape[1] == 1 else (n, 2 * n)  # what `collision_kind` asks for
    starts = list(beginnings(base, cycle.x, cycle.p, orders))
    kinds = [collision_kind(starts, cycle.x, i, base.problem) for i in range(n)]
    known = arrival.note or (INTERVAL if is_neutral(cycle, base.problem) else "")
    kinds = [(kind, note or known) for kind, note in kinds]
    found = Collision(
        p=float(cycle.p[base.problem.free[0]]), x=cycle.x, kinds=tuple(kinds),
        cause=arrival.cause, precision=arrival.precision,
    )  # fmt: skip
    return found, _least_steep(arrival.orbit, starts, base.problem)


def _least_steep(cycle: SpaceOrbit, starts: Sequence[Beginning], problem: Problem) -> SpaceOrbit:
    """The cycle itself, or if it ends in a root the least steep one that starts there."""

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
