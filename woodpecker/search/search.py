"""Everything there is: slices show what no branch explains, until nothing is new.

A slice lists all cycles and jumps at one parameter; what lies on no branch known so far is followed
too. First slices fill the span evenly; where one of them shows something new two more are taken,
halfway to its neighbours, and one in each gap with many special points, for islands begin and end
in such: until nothing is new or the gaps are as small as was asked. How thin an island can be and
stay unseen is known. At last branches are switched to at flips and branch points: what slices were
too coarse to show.
"""

from __future__ import annotations

from bisect import bisect_left, insort
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from woodpecker.base.arguments import explained_fields
from woodpecker.base.checks import number, whole
from woodpecker.base.settings import Settings
from woodpecker.search.explorer import Explorer, Seen, Step

GOLDEN = 0.5 * (5.0**0.5 - 1.0)  # the golden section: parts of multiples of it lie evenly


@explained_fields
@dataclass(frozen=True, slots=True, kw_only=True)
class Search:
    """How to look for what is not connected.

    Parameters
    ----------
    slices
        How many slices are taken first.
    finest
        Smallest gap between slices, as a part of the span.
    crowded
        A gap that holds more special points than this is looked into.

    Raises
    ------
    ValueError
        If there is no slice, the gap is no part of the span, or no special point may lie in one.

    Examples
    --------
    >>> from sympy import Piecewise, symbols
    >>> from woodpecker import Search, Settings, bifurcation_diagram, from_sympy
    >>> x, p = symbols("x p")
    >>> formula = Piecewise((x/2 + p, x < 0), (x/3 + p - 1, True))
    >>> lines = from_sympy(formula, x, p, words=["L", "R"])
    >>> settings = Settings(span=(-1, 2), window=(-3, 3))
    >>> diagram = bifurcation_diagram(lines, settings=settings, search=Search(slices=4))
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


class Past(NamedTuple):
    """What an interrupted run had come to.

    Attributes
    ----------
    slices
        Those that were finished.
    since
        What was followed after the last of them, up to where the run was interrupted.
    evaluations
        How often the map was evaluated up to the last of them.
    """

    slices: tuple[Seen, ...] = ()
    since: tuple[Step, ...] = ()
    evaluations: int = 0


def complete(
    explorer: Explorer, settings: Settings, search: Search, past: Past | None = None
) -> list[Seen]:
    """Take slices until they show nothing new; follow what they show.

    Parameters
    ----------
    explorer
        Follows and keeps branches; the scheduler it has takes the slices.
    settings
        Span of the parameter.
    search
        How long to look.
    past
        What an interrupted run had come to; the network of the explorer is where it was after the
        last of its slices.

    Returns
    -------
    All slices.
    """
    past = past or Past()
    plan, seen = _Plan(search, settings.span), list(past.slices)
    for each in seen:
        plan.took()
        plan.add(each.then)
    explorer.take_over(past.since)
    while plan.done < len(plan.places) and not explorer.is_spent:
        explorer.slices = plan.done + 1
        explorer.coming = plan.places[plan.done + 1 :]
        found = explorer.see(plan.places[plan.done])
        place = plan.took()
        then = plan.beside(place) if found.new else []
        plan.add(then)
        if plan.done == len(plan.places):
            crowded = plan.crowded([node.end.p for node in explorer.network.nodes])
            plan.add(crowded)
            then += crowded
        seen.append(explorer.has_seen(found._replace(then=tuple(then))))
    explorer.coming = ()
    explorer.untaken = len(plan.places) - plan.done
    explorer.finish()
    return seen


class _Plan:
    """Where slices are taken; it grows where they show something new, and where much begins."""

    def __init__(self, search: Search, span: tuple[float, float]) -> None:
        low, high = span
        self.search, self.done = search, 0
        self.places = [low + (high - low) * part for part in first_places(search)]
        self._sorted = sorted([low, *self.places, high])
        self._least = 2.0 * search.finest * (high - low)

    def took(self) -> float:
        """The next slice was taken; where."""
        self.done += 1
        return self.places[self.done - 1]

    def add(self, places: Sequence[float]) -> None:
        """Slices to be taken after those that are planned."""
        for place in places:
            insort(self._sorted, place)
            self.places.append(place)

    def beside(self, place: float) -> list[float]:
        """Halfway from a slice that shows something new to its neighbours, but for the first ones.

        Of these nearly all do.
        """
        if self.done <= self.search.slices // 4:
            return []
        i = bisect_left(self._sorted, place)
        gaps = ((other, place) for other in (self._sorted[i - 1], self._sorted[i + 1]))
        return [0.5 * (a + b) for a, b in gaps if abs(a - b) >= self._least]

    def crowded(self, points: Sequence[float]) -> list[float]:
        """The middles of gaps with many special points, of which the parameters are given."""
        ends = np.array(self._sorted)
        counts = np.diff(np.searchsorted(np.sort(points), ends))
        wide = (counts > self.search.crowded) & (np.diff(ends) >= self._least)
        middles: list[float] = (0.5 * (ends[1:] + ends[:-1]))[wide].tolist()
        return middles


def first_places(search: Search) -> list[float]:
    """Where slices are taken first, as parts of the span: near both ends, then evenly.

    Multiples of the golden ratio fill (0, 1) evenly, and fall on no value that a map may have in
    its formulas.
    """
    near = 0.5 * search.finest
    return [near, 1.0 - near, *((k * GOLDEN) % 1.0 for k in range(1, search.slices + 1))]
