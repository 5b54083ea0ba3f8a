"""Itineraries of germs that are known to the end, and the growth of laps that follows from them.

An orbit is known for all times once it has come back, follows a word that draws it in, or moves
outward on outer pieces. If all germs at breaks are, so is the graph of laps: a germ and a number of
steps name an end of a node, and the image of a node is cut at the breaks between the letters of the
images of its ends. Points are not compared with each other.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from pwmap.algebra.exact import Affine, sign
from pwmap.algebra.roots import Real
from pwmap.longrun.entropy.entropies import growth_of
from pwmap.longrun.fates import Fate
from pwmap.longrun.line import IDENTITY, Germ, MapLine
from pwmap.longrun.numbers import Exact, work_of
from pwmap.maps.budget import Meter

WORK = 10  # operations of one step for each step before it, which may begin a word that draws in
STEPS = 64  # of an itinerary until it is known to the end


@dataclass(frozen=True, slots=True)
class Itinerary:
    """The pieces that a germ visits."""

    pieces: tuple[int, ...]  # their numbers; those from start on come again and again
    start: int
    ending: Fate | None  # None for one side of a break up to where it matches the other one

    @property
    def word(self) -> tuple[int, ...]:
        """What comes again and again."""
        return self.pieces[self.start :]

    def after(self, step: int) -> int:
        """The step that is followed by the same letters as the next one."""
        return step + 1 if step + 1 < len(self.pieces) else self.start


def itinerary_of(line: MapLine, germ: Germ, steps: int, meter: Meter) -> Itinerary:
    """The itinerary of a germ, up to the first step after which it is known to the end."""
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
    """The step from which on the last letters are a word that draws in what follows it; or None."""
    whole = IDENTITY
    for start in range(len(pieces) - 1, -1, -1):
        whole = whole.after(Affine(*line.branches[pieces[start]][:2]))
        slope, word = whole.slope, pieces[start:]
        # an orbit comes closer to the fixed point on the same side; if that follows the word too,
        # so does all between them, for ever
        if 0 < slope < 1 and _follows(line, whole.fixed_point, word):
            return start
        # the first point and that after one round lie on two sides of the fixed point, and what is
        # between them is mapped into itself
        before = start - len(word)
        if -1 < slope < 0 and before >= 0 and pieces[before:start] == word:
            return start
    return None


def drawn_to(line: MapLine, word: Sequence[int]) -> Exact:
    """The fixed point of a word that draws in."""
    whole = IDENTITY
    for k in word:
        whole = line.branches[k].after(whole)
    return whole.fixed_point


def _follows(line: MapLine, x: Exact, word: Sequence[int]) -> bool:
    """Whether a point follows a word in the closures of its pieces."""
    for k in word:
        branch = line.branches[k]
        if not branch.lower <= x <= branch.upper:
            return False
        x = branch(x)
    return True


def _outward_from(line: MapLine, pieces: Sequence[int], places: Sequence[Exact]) -> int | None:
    """The step from which on an orbit moves outward for ever; None if it does not."""
    first, last = 0, len(line.branches) - 1
    for word in ((first,), (last,), (first, last), (last, first)):
        if tuple(pieces[-len(word) :]) != word:
            continue
        falls = [line.branches[k].slope < 0 for k in word]
        # in one rising outer piece, or round two falling ones, the slope of the word is positive: a
        # point always moves the same way
        way = sign(places[-1] - places[-1 - len(word)])
        if all(falls) == any(falls) == (len(word) == 2) and way == (1 if word[0] == last else -1):
            return len(pieces) - len(word)
    return None


def growth_at(line: MapLine, itineraries: Sequence[Itinerary]) -> Real | None:
    """The growth of laps, at least 1, from known itineraries; None if the graph is too large."""
    return growth_of(_merged(_ways(line, itineraries)))


End = tuple[int, int] | None  # of a node: the number of a germ and a step of it; None is infinite
_Node = tuple[int, End, End]  # the number of a piece, and both ends of a part of it


def _ways(line: MapLine, itineraries: Sequence[Itinerary]) -> list[list[int]]:
    slopes = [sign(branch.slope) for branch in line.branches]
    last = len(slopes) - 1

    def image(end: End) -> End:
        """An end one step later; what is infinite stays so, on the side that its place says."""
        return None if end is None else (end[0], itineraries[end[0]].after(end[1]))

    def cut(low: End, high: End) -> Iterator[_Node]:
        """Parts between two ends: germ 2 k is the left side of break k, germ 2 k + 1 the right."""
        i = 0 if low is None else itineraries[low[0]].pieces[low[1]]
        j = last if high is None else itineraries[high[0]].pieces[high[1]]
        for k in range(i, j + 1):
            yield k, low if k == i else (2 * k - 1, 0), high if k == j else (2 * k, 0)

    nodes: dict[_Node, int] = {node: k for k, node in enumerate(cut(None, None))}
    ways, waiting = list[list[int]](), list(nodes)
    for node in waiting:
        k, low, high = node
        ends = [image(end) for end in (low, high)][:: slopes[k] or 1]
        onward = list(cut(*ends)) if slopes[k] else []
        for other in onward:
            if other not in nodes:
                nodes[other] = len(nodes)
                waiting.append(other)
        ways.append([nodes[other] for other in onward])
    return ways


def _merged(ways: Sequence[Sequence[int]]) -> list[list[int]]:
    """A smaller graph with as many paths: nodes from which as many lead on, always, are one."""
    kinds = [0] * len(ways)
    while True:
        names = dict[tuple[int, ...], int]()
        finer = [
            names.setdefault(tuple(sorted(kinds[other] for other in others)), len(names))
            for others in ways
        ]
        if len(names) == len(set(kinds)):
            break
        kinds = finer
    found = dict[int, list[int]]()
    for kind, others in zip(finer, ways, strict=True):
        found.setdefault(kind, sorted(finer[other] for other in others))
    return [found[kind] for kind in range(len(found))]
