"""Branches as they are put together: legs from special point to special point, and words."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from pwmap.diagrams.diagram import BranchKind
from woodpecker.base.arrays import Floats
from woodpecker.piecewise.borders import BorderKind
from woodpecker.piecewise.ends import End
from woodpecker.piecewise.jumps import Jump
from woodpecker.piecewise.orbits import Orbit, scales
from woodpecker.piecewise.samples import Sample, Stop
from woodpecker.piecewise.settings import Settings


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


@dataclass(frozen=True, slots=True, eq=False)
class Leg:
    """A branch from a sample on, one way, to a special point.

    Attributes
    ----------
    samples, marks
        Samples, the special point included, and changes of word.
    end
        The special point.
    following
        The first samples of the branch that continues it; empty if none does.
    stop
        What ended it.
    step
        The last step: the next leg begins with it.
    """

    samples: tuple[Sample, ...]
    marks: tuple[Mark, ...]
    end: End
    following: tuple[Sample, ...]
    stop: Stop
    step: float = math.inf


def follow_legs(
    follow: Callable[[tuple[Sample, ...], Sample, Stop | None, float], Leg],
    first: tuple[Sample, ...], origin: Sample, ignored: Stop | None, settings: Settings,
) -> list[Leg]:  # fmt: skip
    """Legs one after the other, each from the end of the one before, until none continues it.

    A branch can come to run round without passing its origin: it is followed once round.
    """
    found = [follow(first, origin, ignored, math.inf)]
    while found[-1].following:
        last = found[-1]
        if any(_repeats(last, other, settings) for other in found[:-1]):
            found[-1] = replace(last, following=())
            break
        found.append(follow(last.following, origin, last.stop, last.step))
    return found


def _repeats(leg: Leg, other: Leg, settings: Settings) -> bool:
    """Whether a leg ends where another one did, and goes on like it."""
    one, two = leg.following[-1], other.following[-1]
    scale = scales(len(one.orbit), settings)
    return (
        leg.stop is other.stop
        and one.orbit.keys == two.orbit.keys
        and float(np.abs((one.orbit.point - two.orbit.point) / scale).max()) <= settings.same
        and float(one.tangent @ two.tangent) > 0.0
    )


def curves_of(ahead: list[Leg], behind: list[Leg], kind: BranchKind, order: int) -> list[Curve]:
    """Curves from the legs both ways from one sample, or all round."""
    if not behind and len(ahead) == 1:
        end = ahead[0].end
        return [_curve(ahead[0].samples, ahead[0].marks, (end, end), kind, order)]
    if not behind:
        last, ahead = ahead[-1], ahead[:-1]
        first = [_joined(last, ahead[0], (ahead[-1].end, ahead[0].end), kind, order)]
        return first + _rest(ahead, kind, order)
    back = _reversed(behind[0])
    middle = _joined(back, ahead[0], (behind[0].end, ahead[0].end), kind, order)
    return [middle, *_rest(ahead, kind, order), *_rest(behind, kind, order)]


def curves_from(end: End, legs: list[Leg], kind: BranchKind, order: int) -> list[Curve]:
    """Curves from the legs that start at a special point."""
    first = _curve(legs[0].samples, legs[0].marks, (end, legs[0].end), kind, order)
    return [first, *_rest(legs, kind, order)]


def _rest(legs: list[Leg], kind: BranchKind, order: int) -> list[Curve]:
    return [
        _curve(leg.samples, leg.marks, (before.end, leg.end), kind, order)
        for before, leg in pairwise(legs)
    ]


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
