"""Itineraries of germs, each up to the step after which all of it is known.

That is where the orbit has come back, follows a word that attracts it, or moves outward on the
outer pieces.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pwmap.algebra.exact import Affine, sign
from pwmap.algebra.numbers import Exact
from pwmap.longrun.fates import Fate
from pwmap.longrun.line import IDENTITY, Germ, MapLine
from pwmap.maps.budget import Meter
from pwmap.maps.words import work_of

WORK = 10  # operations of a step for each step before it: an attracting word may begin at any
STEPS = 64  # of an itinerary, at most


@dataclass(frozen=True, slots=True)
class Itinerary:
    """The pieces that a germ visits."""

    pieces: tuple[int, ...]  # their numbers; those from start on repeat
    start: int
    ending: Fate | None  # None if it ends where the orbits of both sides of a break match

    @property
    def word(self) -> tuple[int, ...]:
        """The pieces that repeat."""
        return self.pieces[self.start :]


def itinerary_of(line: MapLine, germ: Germ, steps: int, meter: Meter) -> Itinerary:
    """The itinerary of a germ, up to the first step after which it is known; else OPEN."""
    seen, pieces, places = dict[Germ, int](), list[int](), list[Exact]()
    for step in range(steps):
        if germ in seen:
            return Itinerary(tuple(pieces), seen[germ], Fate.FINITE)
        meter.spend(WORK * (step + 1) + 3 * work_of(germ.x))
        seen[germ] = step
        pieces.append(line.number(germ))
        places.append(germ.x)
        if not line.branches[pieces[-1]].slope:
            return Itinerary(tuple(pieces), step, Fate.FLAT)
        germ = line.image(germ)
        start = _drawn_from(line, pieces)
        if start is not None:
            return Itinerary(tuple(pieces), start, Fate.DRAWN)
        start = _outward_from(line, pieces, [*places[-2:], germ.x])
        if start is not None:
            return Itinerary(tuple(pieces), start, Fate.LOST)
    return Itinerary(tuple(pieces), 0, Fate.OPEN)


def _drawn_from(line: MapLine, pieces: Sequence[int]) -> int | None:
    """The first step of a word at the end that attracts the orbits which follow it; or None."""
    whole = IDENTITY
    for start in range(len(pieces) - 1, -1, -1):
        whole = whole.after(Affine(*line.branches[pieces[start]][:2]))
        slope, word = whole.slope, pieces[start:]
        # an orbit approaches the fixed point from one side; if the fixed point follows the word,
        # too, so do all points between, for ever
        if 0 < slope < 1 and line.follows(whole.fixed_point, word):
            return start
        # the first point and that after one round lie on both sides of the fixed point, and the
        # interval between them is mapped into itself
        before = start - len(word)
        if -1 < slope < 0 and before >= 0 and pieces[before:start] == word:
            return start
    return None


def _outward_from(line: MapLine, pieces: Sequence[int], places: Sequence[Exact]) -> int | None:
    """The step from which on an orbit moves outward for ever; None if it does not."""
    first, last = 0, len(line.branches) - 1
    for word in ((first,), (last,), (first, last), (last, first)):
        if tuple(pieces[-len(word) :]) != word:
            continue
        falls = [line.branches[k].slope < 0 for k in word]
        # on one rising outer piece, or through two falling ones, the slope of the word is positive:
        # a point always moves the same way
        way = sign(places[-1] - places[-1 - len(word)])
        if all(falls) == any(falls) == (len(word) == 2) and way == (1 if word[0] == last else -1):
            return len(pieces) - len(word)
    return None
