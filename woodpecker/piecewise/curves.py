"""Branches as they are put together: legs from special point to special point, and words."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from pwmap.diagrams.diagram import BranchKind
from woodpecker.base.arrays import Floats
from woodpecker.piecewise.borders import BorderKind
from woodpecker.piecewise.ends import End
from woodpecker.piecewise.jumps import Jump
from woodpecker.piecewise.orbits import Condition, Orbit
from woodpecker.piecewise.samples import Sample, Stop

Keys = tuple[object, ...]
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Mark:
    """A change of word on a branch that is no special point.

    Attributes
    ----------
    sample
        Index of the sample at the border; the word changes after it.
    cause
        A sentence on what happens there.
    kind
        What the map does at the border.
    """

    sample: int
    cause: str
    kind: BorderKind


@dataclass(frozen=True, slots=True, eq=False)
class Word:
    """A stretch of a branch along which no piece changes.

    Attributes
    ----------
    first
        Its first sample; a sample at a border has the pieces before it.
    text
        The words of its pieces.
    keys
        The keys of the pieces of a cycle; of a jump those of the points before the border, and a
        set of those on its two sides with the margins that vanish, for a piece has two ends.
    """

    first: int
    text: str
    keys: tuple[object, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Curve:
    """A branch between two special points.

    Attributes
    ----------
    kind, order
        Cycles of P_order, or jumps of it.
    parameter, multiplier
        Samples (m,), the ends included; the multiplier of a jump is nan.
    points
        m times the points (n,) of a cycle, or those up to the border of a jump.
    words
        Stretches between changes of word, in this order.
    marks
        These changes, one less.
    ends
        Why it begins and ends.
    """

    kind: BranchKind
    order: int
    parameter: Floats
    points: tuple[Floats, ...]
    multiplier: Floats
    words: tuple[Word, ...]
    marks: tuple[Mark, ...]
    ends: tuple[End, End]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Beginning:
    """Where a branch begins, or goes on: at a special point.

    Attributes
    ----------
    kind, order
        Cycles of P_order, or jumps of it.
    samples
        Its first samples: that at the special point, and as a rule one beyond it.
    closing
        The condition that its orbits obey.
    end
        The special point.
    passed
        What ended the branch that led there: it is not looked for in the first step.
    step
        The first step at most.
    """

    kind: BranchKind
    order: int
    samples: tuple[Sample, ...]
    closing: Condition
    end: End
    passed: Stop | None = None
    step: float = math.inf


@dataclass(frozen=True, slots=True, eq=False)
class Leg:
    """A branch from a sample on, one way, to a special point.

    Attributes
    ----------
    samples, marks
        Samples, the special point included, and changes of word.
    end
        The special point.
    stop
        What ended it.
    onward
        Where it goes on; None if it does not.
    """

    samples: tuple[Sample, ...]
    marks: tuple[Mark, ...]
    end: End
    stop: Stop
    onward: Beginning | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Followed:
    """A branch, and where it goes on beyond its ends."""

    curve: Curve
    onward: tuple[Beginning, ...]


def both_ways(
    start: Sample, follow: Callable[[Sample], Leg], kind: BranchKind, order: int
) -> Followed:
    """The branch through a sample, from one special point to the other, or all round."""
    ahead = follow(start)
    if ahead.stop is Stop.CLOSED:
        return Followed(_curve(ahead.samples, ahead.marks, (ahead.end,) * 2, kind, order), ())
    behind = follow(turned(start))
    curve = _joined(_reversed(behind), ahead, (behind.end, ahead.end), kind, order)
    return Followed(curve, tuple(leg.onward for leg in (ahead, behind) if leg.onward is not None))


def one_way(begin: Beginning, leg: Leg) -> Followed:
    """The branch from one special point to the next."""
    ends = begin.end, leg.end
    curve = _curve(leg.samples, leg.marks, ends, begin.kind, begin.order)
    return Followed(curve, () if leg.onward is None else (leg.onward,))


def _reversed(leg: Leg) -> Leg:
    n = len(leg.samples)
    marks = tuple(replace(mark, sample=n - 2 - mark.sample) for mark in reversed(leg.marks))
    return replace(leg, samples=leg.samples[::-1], marks=marks)


def _joined(one: Leg, other: Leg, ends: tuple[End, End], kind: BranchKind, order: int) -> Curve:
    n = len(one.samples) - 1
    marks = (*one.marks, *(replace(mark, sample=mark.sample + n) for mark in other.marks))
    return _curve((*one.samples, *other.samples[1:]), marks, ends, kind, order)


def _curve(
    samples: tuple[Sample, ...], marks: tuple[Mark, ...], ends: tuple[End, End], kind: BranchKind,
    order: int,
) -> Curve:  # fmt: skip
    jumps = kind is BranchKind.JUMP
    words = list[Word]()
    for k, sample in enumerate(samples):
        keys = keys_of(sample.orbit, sample.jump)
        if not words or keys != words[-1].keys:
            words.append(Word(k, _text(sample), keys))
        elif k == 1:  # where a branch of jumps begins by turning round its pieces have no sides
            words[0] = Word(0, _text(sample), keys)
    return Curve(
        kind=kind, order=order, parameter=np.array([s.orbit.p for s in samples]),
        points=tuple(s.orbit.x for s in samples),
        multiplier=np.array([np.nan if jumps else s.orbit.multiplier for s in samples]),
        words=tuple(words), marks=marks, ends=ends,
    )  # fmt: skip


def _text(sample: Sample) -> str:
    return word_of(sample.orbit) if sample.jump is None else sample.jump.word


def keys_of(orbit: Orbit, jump: Jump | None = None) -> tuple[object, ...]:
    """The pieces of an orbit, see :class:`Word`."""
    if jump is None:
        return orbit.keys
    sides = {(jump.inner.keys[0], jump.closing.code)}
    if jump.outer_code >= 0:
        sides.add((jump.outer.keys[0], jump.outer_code))
    return *orbit.keys[:-1], frozenset(sides)


def word_of(orbit: Orbit) -> str:
    """The words of all pieces."""
    return " | ".join(orbit.words)


def turned(sample: Sample) -> Sample:
    """The same sample on the way back."""
    return replace(sample, tangent=-sample.tangent, forward=not sample.forward)


def word_at(curve: Curve, k: int) -> Word:
    """Which pieces a branch takes at a sample."""
    return curve.words[bisect_right(curve.words, k, key=lambda word: word.first) - 1]


def words_between(curve: Curve, k: int) -> list[Word]:
    """Which pieces a branch takes at a sample and at the next."""
    one, other = word_at(curve, k), word_at(curve, k + 1)
    return [one] if one is other else [one, other]


def from_point(values: tuple[T, ...], shift: int) -> tuple[T, ...]:
    """The same from another point of a cycle."""
    return (*values[shift:], *values[:shift])


def agree(one: Keys, other: Keys) -> bool:
    """Whether two orbits take the same pieces; at a border one side is enough.

    What is on the other side of a jump may be a piece so thin that rounding decides whether it is
    seen.
    """
    return len(one) == len(other) and all(
        not a.isdisjoint(b) if isinstance(a, frozenset) and isinstance(b, frozenset) else a == b
        for a, b in zip(one, other, strict=True)
    )
