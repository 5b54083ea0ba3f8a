"""The search for all branches: slices are taken until they show nothing that no branch explains.

The first slices fill the span evenly. Where one shows something new two more are taken, halfway to
its neighbours, and one in each gap with many special points, where islands begin and end. Slices on
both sides of a dead end, where a single branch ends, show what no curve joins with it: the cycles
of ever thinner pieces that accumulate where a jump crossing ends. Other islands between two slices
stay unseen. Finally branches are switched at flips and branch points, for those that slices were
too coarse to show.
"""

from __future__ import annotations

from bisect import bisect_left, insort
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pwmap.algebra.arguments import explained_fields
from woodpecker.base.checks import number, whole
from woodpecker.search.explorer import Explorer

GOLDEN = 0.5 * (5.0**0.5 - 1.0)  # golden ratio: fractional parts of its multiples lie evenly


@explained_fields
@dataclass(frozen=True, slots=True, kw_only=True)
class Search:
    """How slices search a span for branches that are not connected with known ones.

    Parameters
    ----------
    slices
        Number of slices that are taken first.
    finest
        Smallest gap between slices, as a fraction of the span.
    crowded
        A gap between slices with more special points than this is halved.

    Raises
    ------
    ValueError
        If there is no slice, the gap is no part of the span, or no special point may lie in one.

    Examples
    --------
    >>> from woodpecker import Search, bifurcation_diagram
    >>> from woodpecker.examples import two_lines
    >>> few = Search(slices=4)
    >>> diagram = bifurcation_diagram(two_lines(), "p", (-1, 2), window=(-3, 3), search=few)
    >>> [str(branch.kind) for branch in diagram.branches]
    ['fixed-point', 'jump', 'fixed-point']
    """

    slices: int = 63
    finest: float = 5e-4
    crowded: int = 64

    def __post_init__(self) -> None:
        object.__setattr__(self, "slices", whole("slices", self.slices))
        object.__setattr__(self, "crowded", whole("crowded", self.crowded))
        object.__setattr__(self, "finest", number("finest", self.finest))
        if not 0.0 < self.finest < 1.0:
            raise ValueError(f"finest must lie in (0, 1), got {self.finest}")


def complete(explorer: Explorer, search: Search) -> None:
    """Take slices, following what they show, until they show nothing new."""
    plan = _Plan(search, explorer.network.settings.span)
    for each in explorer.seen:  # by a run that was interrupted
        plan.took()
        plan.add(each.then)
    while plan.done < len(plan.places) and not explorer.is_spent:
        explorer.coming = plan.places[plan.done + 1 :]
        found = explorer.take_slice(plan.places[plan.done])
        place = plan.took()
        then = plan.beside(place) if found.new else []
        plan.add(then)
        if plan.done == len(plan.places):
            crowded = plan.crowded([node.end.p for node in explorer.network.nodes])
            plan.add(crowded)
            at_ends = plan.at_ends(explorer.network.dead_ends())
            plan.add(at_ends)
            then += crowded + at_ends
        explorer.store_slice(found._replace(then=tuple(then)))
    explorer.coming = ()
    explorer.untaken = len(plan.places) - plan.done
    explorer.finish()


class _Plan:
    """Where slices are taken: places are added where slices show something new."""

    def __init__(self, search: Search, span: tuple[float, float]) -> None:
        low, high = span
        self.search, self.done = search, 0
        self.places = [low + (high - low) * part for part in first_places(search)]
        self._sorted = sorted([low, *self.places, high])
        self._least = 2.0 * search.finest * (high - low)

    def took(self) -> float:
        """Count the next slice as taken, and return its place."""
        self.done += 1
        return self.places[self.done - 1]

    def add(self, places: Sequence[float]) -> None:
        """Plan slices, to be taken after those already planned."""
        for place in places:
            insort(self._sorted, place)
            self.places.append(place)

    def beside(self, place: float) -> list[float]:
        """Halfway to both neighbours of a slice; none for the first quarter of the first slices."""
        if self.done <= self.search.slices // 4:
            return []
        i = bisect_left(self._sorted, place)
        gaps = ((other, place) for other in (self._sorted[i - 1], self._sorted[i + 1]))
        return [0.5 * (a + b) for a, b in gaps if abs(a - b) >= self._least]

    def at_ends(self, points: Sequence[float]) -> list[float]:
        """Both sides of dead ends, at the smallest gap from them, unless slices are nearer."""
        (low, *_, high), gap, found = self._sorted, 0.5 * self._least, list[float]()
        for place in (p + side * gap for p in sorted(points) for side in (-1.0, 1.0)):
            away = min(abs(place - other) for other in (*self._sorted, *found))
            if low < place < high and away >= gap:
                found.append(place)
        return found

    def crowded(self, points: Sequence[float]) -> list[float]:
        """The middles of gaps that hold many special points, given the parameters of these."""
        ends = np.array(self._sorted)
        counts = np.diff(np.searchsorted(np.sort(points), ends))
        wide = (counts > self.search.crowded) & (np.diff(ends) >= self._least)
        middles: list[float] = (0.5 * (ends[1:] + ends[:-1]))[wide].tolist()
        return middles


def first_places(search: Search) -> list[float]:
    """Where the first slices are taken, as fractions of the span: near both ends, then evenly."""
    # Multiples of the golden ratio fill (0, 1) evenly, and hit no special value of a formula.
    near = 0.5 * search.finest
    return [near, 1.0 - near, *((k * GOLDEN) % 1.0 for k in range(1, search.slices + 1))]
