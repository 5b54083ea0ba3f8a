"""Everything there is: slices show what no branch explains, until nothing is new.

A slice lists all cycles and jumps at one parameter; what lies on no branch known so far is followed
too. First slices fill the span evenly; where one of them shows something new two more are taken,
halfway to its neighbours, until nothing is new or the gaps are as small as was asked: how thin an
island can be and stay unseen is known. At last branches are switched to at flips and branch points:
what slices were too coarse to show.
"""

from __future__ import annotations

from bisect import bisect_left, insort
from dataclasses import dataclass
from typing import NamedTuple

from woodpecker.piecewise.explorer import Explorer, Seen
from woodpecker.piecewise.settings import Settings


@dataclass(frozen=True, slots=True, kw_only=True)
class Search:
    """How to look for what is not connected.

    Parameters
    ----------
    slices
        How many slices are taken first.
    finest
        Smallest gap between slices, as a part of the span.

    Raises
    ------
    ValueError
        If there is no slice, or the gap is no part of the span.
    """

    slices: int = 63
    finest: float = 5e-4

    def __post_init__(self) -> None:
        if self.slices < 1:
            raise ValueError(f"slices must be at least 1, got {self.slices}")
        if not 0.0 < self.finest < 1.0:
            raise ValueError(f"finest must lie in (0, 1), got {self.finest}")


class Past(NamedTuple):
    """What an interrupted run had come to.

    Attributes
    ----------
    slices
        Those that were finished.
    since
        Orders of branches that were found after the last of them: the next slice showed these.
    """

    slices: tuple[Seen, ...] = ()
    since: tuple[int, ...] = ()


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
        What an interrupted run had come to.

    Returns
    -------
    All slices.
    """
    past = past or Past()
    plan, seen, since = _Plan(search), list(past.slices), past.since
    for each in seen:
        plan.took(bool(each.new))
    known = len(explorer.network.curves)
    explorer.go_on()
    since += tuple(curve.order for curve in explorer.network.curves[known:])
    low, high = settings.span
    while plan.done < len(plan.places):
        ready = plan.done + len(explorer.coming)
        for place in plan.places[ready : plan.done + explorer.scheduler.spare]:
            explorer.look(low + (high - low) * place)
        explorer.slices = plan.done + 1
        seen.append(explorer.see(since))
        plan.took(bool(seen[-1].new))
        since = ()
    explorer.finish()
    return seen


class _Plan:
    """Where slices are taken, as parts of the span; it grows where they show something new."""

    def __init__(self, search: Search) -> None:
        self.search, self.done = search, 0
        self.places = first_places(search)
        self._sorted = sorted([0.0, *self.places, 1.0])

    def took(self, new: bool) -> None:
        """The next slice was taken; whether it showed something new."""
        place = self.places[self.done]
        self.done += 1
        if not new or self.done <= self.search.slices // 4:
            return
        i = bisect_left(self._sorted, place)
        for other in (self._sorted[i - 1], self._sorted[i + 1]):
            if abs(other - place) >= 2.0 * self.search.finest:
                middle = 0.5 * (place + other)
                insort(self._sorted, middle)
                self.places.append(middle)


def first_places(search: Search) -> list[float]:
    """Where slices are taken first, as parts of the span: near both ends, then evenly.

    Multiples of the golden ratio fill (0, 1) evenly, and fall on no value that a map may have in
    its formulas.
    """
    near = 0.5 * search.finest
    return [near, 1.0 - near, *((k * GOLDEN) % 1.0 for k in range(1, search.slices + 1))]


GOLDEN = 0.5 * (5.0**0.5 - 1.0)
