"""Complete diagrams: slices of the parameter until none shows anything that no branch explains.

A slice lists all fixed points and jump crossings at one parameter. What lies on no branch known so
far is followed, with everything that hangs on it; so islands are found by the first slice through
them. First slices fill the span evenly. Where one of them, the first quarter apart, shows something
new, two more are taken, halfway to its neighbours, and so on until nothing is new or the gaps are
as small as was asked. How thin an island can be and stay unseen is therefore known.
"""

from __future__ import annotations

from bisect import bisect_left, insort
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from pwmap.diagrams.diagram import Branch, BranchKind
from woodpecker.base.arrays import Floats
from woodpecker.base.checkpoint import Entry
from woodpecker.base.executors import Pending, Scheduler
from woodpecker.piecewise.checkpoint import SLICE
from woodpecker.piecewise.explore import Explorer, Start
from woodpecker.piecewise.jumps import Jump
from woodpecker.piecewise.maps import minimal_period
from woodpecker.piecewise.network import ON_BRANCH, Atlas
from woodpecker.piecewise.partition import Resolution
from woodpecker.piecewise.settings import Settings
from woodpecker.piecewise.slices import Found
from woodpecker.piecewise.tasks import Task

AT_END = 1e-9  # in the parameter: a slice can fall on the very end of a branch
AT_JUMP = 1e-3  # of a chord: how far a jump of other words strays from it, at most


@dataclass(frozen=True, slots=True, kw_only=True)
class Search:
    """How to look for what is not connected.

    Parameters
    ----------
    slices
        How many slices are taken first.
    finest
        Smallest gap between slices, as a part of the span.
    resolution
        How closely a slice looks at the map.
    """

    slices: int = 191
    finest: float = 5e-4
    resolution: Resolution = field(
        default_factory=lambda: Resolution(spacing=2e-3, smallest=1e-6, bend=1e-5)
    )

    def __post_init__(self) -> None:
        if self.slices < 1:
            raise ValueError(f"slices must be at least 1, got {self.slices}")
        if not 0.0 < self.finest < 1.0:
            raise ValueError(f"finest must lie in (0, 1), got {self.finest}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """What a search did for one order.

    Attributes
    ----------
    slices
        Parameters of all slices, in the order they were taken.
    found_at
        Those that showed something new.
    evaluations
        How often P_1 was evaluated by slices, at least.
    unresolved
        Largest total length of unresolved intervals of one slice.
    steep
        Largest number of cycles of one slice that are steeper than ``Settings.steepest``.
    not_followed
        (parameter, x) that a slice shows and that could not be followed.
    """

    order: int
    slices: tuple[float, ...]
    found_at: tuple[float, ...]
    evaluations: int
    unresolved: float
    steep: int
    not_followed: tuple[tuple[float, float], ...]


def complete(
    explorer: Explorer,
    scheduler: Scheduler,
    settings: Settings,
    orders: Sequence[int],
    search: Search,
) -> list[Report]:
    """Take slices until they show nothing new; follow what they show.

    Parameters
    ----------
    explorer
        Follows and keeps branches.
    scheduler
        Where slices are taken.
    settings
        Span of the parameter.
    orders
        Iterates, in ascending order. P_1 comes first; the others share their slices.
    search
        How long to look.
    """
    explorer.go_on()  # what an interrupted run has left
    groups = [group for group in ([1], [order for order in orders if order > 1]) if group]
    return [
        report
        for group in groups
        if set(group) <= set(orders)
        for report in _complete(explorer, scheduler, settings, tuple(group), orders, search)
    ]


def _complete(
    explorer: Explorer, scheduler: Scheduler, settings: Settings, group: tuple[int, ...],
    orders: Sequence[int], search: Search,
) -> list[Report]:  # fmt: skip
    entries = [] if explorer.journal is None else explorer.journal.entries
    taken = {order: _taken(entries, order) for order in group}
    shortest = min(map(len, taken.values()))  # a slice that was interrupted is taken again
    taken = {order: rows[:shortest] for order, rows in taken.items()}
    known = {order: _Known(explorer.atlas, order) for order in group}
    plan = _Plan(search)
    for each in zip(*taken.values(), strict=True):
        plan.took(any(entry["new"] for entry in each))
    for slice_, evaluations in _slices(scheduler, group, plan, settings):
        explorer.slices = plan.done + 1
        for found in slice_:
            before = len(explorer.atlas.branches)
            explorer.explore(_starts(found, orders), known[found.order].explains)
            entry = {
                SLICE: found.p,
                "order": found.order,
                "new": len(explorer.atlas.branches) > before,
                "evaluations": evaluations if found.order == group[0] else 0,
                "unresolved": found.unresolved,
                "steep": found.steep,
                "failed": [list(place) for place in found.failed],
            }
            taken[found.order].append(entry)
            explorer.write(entry)
        plan.took(any(rows[-1]["new"] for rows in taken.values()))
    return [_report(order, rows) for order, rows in taken.items()]


def _report(order: int, taken: Sequence[Entry]) -> Report:
    return Report(
        order=order,
        slices=tuple(t[SLICE] for t in taken),
        found_at=tuple(t[SLICE] for t in taken if t["new"]),
        evaluations=sum(t["evaluations"] for t in taken),
        unresolved=max(t["unresolved"] for t in taken),
        steep=max(t["steep"] for t in taken),
        not_followed=tuple((p, x) for t in taken for p, x in t["failed"]),
    )


def _taken(entries: Sequence[Entry], order: int) -> list[Entry]:
    """Slices of an order that a journal holds."""
    return [entry for entry in entries if SLICE in entry and entry["order"] == order]


class _Plan:
    """Where slices are taken, as parts of the span; it grows where they show something new."""

    def __init__(self, search: Search) -> None:
        self.search = search
        self.places = [van_der_corput(k) for k in range(1, search.slices + 1)]
        self.done = 0
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


def _slices(
    scheduler: Scheduler, group: tuple[int, ...], plan: _Plan, settings: Settings
) -> Iterator[tuple[list[Found], int]]:
    """Slices as they are planned, submitted ahead."""
    low, high = settings.span
    ahead: deque[Pending] = deque()
    try:
        while plan.done < len(plan.places):
            last = min(plan.done + scheduler.ahead, len(plan.places))
            for k in range(plan.done + len(ahead), last):
                p = low + (high - low) * plan.places[k]
                ahead.append(scheduler.submit(Task.SLICE, p, group))
            done = ahead.popleft().result()
            yield done.value, done.evaluations
    finally:
        for waiting in ahead:
            waiting.cancel()


def van_der_corput(k: int) -> float:
    """The k-th of 1/2, 1/4, 3/4, 1/8, ...: numbers that fill (0, 1) evenly."""
    value, half = 0.0, 0.5
    while k:
        value, half, k = value + half * (k & 1), 0.5 * half, k >> 1
    return value


def _starts(found: Found, orders: Sequence[int]) -> list[Start]:
    """Where branches can be picked up; cycles of lower orders that are explored are left out."""
    cycles = [
        Start(BranchKind.FIXED_POINT, found.order, cycle)
        for cycle in found.cycles
        if (period := minimal_period(cycle)) == found.order or period not in orders
    ]
    return [*cycles, *(Start(BranchKind.JUMP, found.order, jump) for jump in found.jumps)]


class _Known:
    """Which places of the diagram branches of one order explain."""

    def __init__(self, atlas: Atlas, order: int) -> None:
        self.atlas, self.order = atlas, order
        self.seen = 0
        self.chords = {kind: np.empty((0, 5)) for kind in BranchKind}
        self.words: dict[str, int] = {}

    def explains(self, start: Start) -> bool:
        """Whether a branch passes through a start, as far as its samples tell.

        Fixed points need to have the same word; there is only one jump at a place.
        """
        self._update()
        if isinstance(start.at, Jump):
            whole = start.at.whole
            p, x, word = start.at.p, start.at.x, f"{whole.left.word} / {whole.right.word}"
        else:
            p, x, word = start.at.p, float(start.at.x[0]), start.at.word
        p0, x0, p1, x1, words = self.chords[start.kind].T
        inside = (np.minimum(p0, p1) - AT_END <= p) & (p <= np.maximum(p0, p1) + AT_END)
        if start.kind is BranchKind.FIXED_POINT:
            inside &= words == self.words.get(word, -1)
        if not inside.any():
            return False
        p0, x0, p1, x1, words = self.chords[start.kind][inside].T
        run = np.where(p1 == p0, 1.0, p1 - p0)
        on_chord = x0 + (x1 - x0) * np.clip((p - p0) / run, 0.0, 1.0)
        # Pieces beside a jump can be so thin that rounding decides whether a word is seen.
        part = np.where(words == self.words.get(word, -1), ON_BRANCH, AT_JUMP)
        return bool((np.abs(x - on_chord) <= part * np.hypot(p1 - p0, x1 - x0) + 1e-7).any())

    def _update(self) -> None:
        fresh = [b for b in self.atlas.branches[self.seen :] if b.order == self.order]
        self.seen = len(self.atlas.branches)
        for kind in BranchKind:
            rows = [self._chords(branch) for branch in fresh if branch.kind is kind]
            self.chords[kind] = np.concatenate([self.chords[kind], *rows])

    def _chords(self, branch: Branch) -> Floats:
        """Neighbouring samples as rows p0, x0, p1, x1, with the number of the word."""
        number = self.words.setdefault(branch.word, len(self.words))
        points = np.column_stack([branch.parameter, branch.x])
        words = np.full((len(points) - 1, 1), float(number))
        rows: Floats = np.hstack([points[:-1], points[1:], words])
        return rows
