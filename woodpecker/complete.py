"""Complete diagrams: slices of the parameter until none shows anything that no branch explains.

A slice lists all fixed points and jump crossings at one parameter. What lies on no branch known so
far is followed, with everything that hangs on it; so islands are found by the first slice through
them. Slices fill the span ever more densely. How thin an island can be and stay unseen is therefore
known: thinner than the largest gap between slices, or narrower in x than the slices resolve.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import dataclass, field
from itertools import count

import numpy as np

from pwmap.diagram import Branch, BranchKind
from woodpecker.atlas import ON_BRANCH, Atlas
from woodpecker.edges import NEAR, Edge, edge_between
from woodpecker.explore import Explorer
from woodpecker.journal import SLICE, Entry
from woodpecker.labelled import LabelledMap, correct
from woodpecker.pieces import Resolution, SampledMap, Slice, iterated, slice_of
from woodpecker.settings import Settings

AT_END = 1e-9  # in the parameter: a slice can fall on the very end of a branch
AHEAD = 4  # slices that are prepared while branches are followed


@dataclass(frozen=True, slots=True, kw_only=True)
class Search:
    """How to look for what is not connected.

    Parameters
    ----------
    slices
        At least so many slices are taken, for each order.
    quiet
        So many in a row must show nothing new.
    resolution
        How closely a slice looks at the map.
    """

    slices: int = 48
    quiet: int = 16
    resolution: Resolution = field(
        default_factory=lambda: Resolution(spacing=2e-3, smallest=1e-6, bend=1e-5)
    )

    def __post_init__(self) -> None:
        for name in ("slices", "quiet"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} must be at least 1, got {getattr(self, name)}")


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
    not_followed
        (parameter, x) that a slice shows and that could not be followed.
    """

    order: int
    slices: tuple[float, ...]
    found_at: tuple[float, ...]
    evaluations: int
    unresolved: float
    not_followed: tuple[tuple[float, float], ...]


def complete(
    explorer: Explorer,
    map_: SampledMap,
    orders: Sequence[int],
    search: Search,
    executor: Executor | None = None,
) -> list[Report]:
    """Take slices until they show nothing new; follow what they show.

    Parameters
    ----------
    explorer
        Follows and keeps branches; its settings say in which span and window.
    map_
        P_1 of the explorer's map, for many points at once.
    orders
        Iterates, in ascending order.
    search
        How long to look and how closely.
    executor
        Where slices are computed; one thread for each core by default. The result does not depend
        on it.
    """
    explorer.go_on()  # what an interrupted run has left
    with _executor(executor) as pool:
        return [_complete(explorer, map_, order, search, pool) for order in orders]


class _executor:  # noqa: N801
    """A given executor, left open, or one of threads."""

    def __init__(self, given: Executor | None) -> None:
        self.given, self.own = given, None if given is not None else ThreadPoolExecutor()

    def __enter__(self) -> Executor:
        chosen = self.given or self.own
        assert chosen is not None
        return chosen

    def __exit__(self, *_: object) -> None:
        if self.own is not None:
            self.own.shutdown(cancel_futures=True)


def _complete(
    explorer: Explorer, map_: SampledMap, order: int, search: Search, pool: Executor
) -> Report:
    known = _Known(explorer.atlas, order)
    taken = [] if explorer.journal is None else _taken(explorer.journal.entries, order)
    for found in _slices(map_, order, taken, explorer.settings, search, pool):
        explorer.slices = len(taken) + 1
        before = len(explorer.atlas.branches)
        failed = list(_follow_slice(explorer, known, found, order))
        entry = {
            SLICE: found.partition.p,
            "order": order,
            "new": len(explorer.atlas.branches) > before,
            "evaluations": order * found.partition.evaluations,
            "unresolved": found.partition.unresolved_length,
            "failed": failed,
        }
        taken.append(entry)
        if explorer.journal is not None:
            explorer.journal.write(entry)
    return Report(
        order=order,
        slices=tuple(t[SLICE] for t in taken),
        found_at=tuple(t[SLICE] for t in taken if t["new"]),
        evaluations=sum(t["evaluations"] for t in taken),
        unresolved=max(t["unresolved"] for t in taken),
        not_followed=tuple((p, x) for t in taken for p, x in t["failed"]),
    )


def _taken(entries: Sequence[Entry], order: int) -> list[Entry]:
    """Slices of an order that a journal holds."""
    return [entry for entry in entries if SLICE in entry and entry["order"] == order]


def _enough(taken: Sequence[Entry], search: Search) -> bool:
    return len(taken) >= search.slices and not any(t["new"] for t in taken[-search.quiet :])


def _slices(
    map_: SampledMap, order: int, taken: Sequence[Entry], settings: Settings, search: Search,
    pool: Executor,
) -> Iterator[Slice]:  # fmt: skip
    """Slices ever denser in the span, computed ahead, until those taken are enough."""
    low, high = settings.span
    whole = iterated(map_, order, settings.window)

    def take(p: float) -> Slice:
        return slice_of(whole, p, settings.window, search.resolution, settings.tolerances)

    ahead: deque[Future[Slice]] = deque()
    try:
        numbers = count(len(taken) + 1)
        while not _enough(taken, search):
            while len(ahead) <= AHEAD:
                p = low + (high - low) * van_der_corput(next(numbers))
                ahead.append(pool.submit(take, p))
            yield ahead.popleft().result()
    finally:
        for waiting in ahead:
            waiting.cancel()


def van_der_corput(k: int) -> float:
    """The k-th of 1/2, 1/4, 3/4, 1/8, ...: numbers that fill (0, 1) evenly."""
    value, half = 0.0, 0.5
    while k:
        value, half, k = value + half * (k & 1), 0.5 * half, k >> 1
    return value


def _follow_slice(
    explorer: Explorer, known: _Known, found: Slice, order: int
) -> Iterator[tuple[float, float]]:
    """Follow what lies on no known branch; yield what cannot be followed."""
    p = found.partition.p
    for x, _ in found.fixed_points:
        if known.explains(BranchKind.FIXED_POINT, p, x):
            continue
        orbit = orbit_from(explorer.map, x, p, order)
        cycle, good, _ = correct(explorer.map, orbit, p, None, explorer.settings.tolerances)
        if not good:
            yield p, x
        elif not explorer.is_known(cycle):
            explorer.explore_cycle(cycle)
    for edge in found.crossings:
        if known.explains(BranchKind.JUMP, p, edge.x):
            continue
        sharp = labelled_edge(explorer.iterate(order), edge)
        if sharp.crosses:
            explorer.explore_jump(sharp, order)
        else:
            yield p, edge.x


def orbit_from(labelled_map: LabelledMap, x: float, p: float, order: int) -> list[float]:
    """The first ``order`` points of an orbit."""
    points = [x]
    while len(points) < order:
        points.append(labelled_map(points[-1], p).value)
    return points


def labelled_edge(labelled_map: LabelledMap, edge: Edge) -> Edge:
    """The same edge with the words of a labelled map on both sides."""
    near = NEAR * np.spacing(abs(edge.x))
    return edge_between(labelled_map, edge.p, edge.x - float(near), edge.x + float(near))


class _Known:
    """Which places of the diagram branches of one order explain."""

    def __init__(self, atlas: Atlas, order: int) -> None:
        self.atlas, self.order = atlas, order
        self.seen = 0
        self.chords = {kind: np.empty((0, 4)) for kind in BranchKind}

    def explains(self, kind: BranchKind, p: float, x: float) -> bool:
        """Whether a branch passes through (p, x), as far as its samples tell."""
        self._update()
        p0, x0, p1, x1 = self.chords[kind].T
        inside = (np.minimum(p0, p1) - AT_END <= p) & (p <= np.maximum(p0, p1) + AT_END)
        if not inside.any():
            return False
        p0, x0, p1, x1 = self.chords[kind][inside].T
        run = np.where(p1 == p0, 1.0, p1 - p0)
        on_chord = x0 + (x1 - x0) * np.clip((p - p0) / run, 0.0, 1.0)
        allowed = ON_BRANCH * np.hypot(p1 - p0, x1 - x0) + 1e-7
        return bool((np.abs(x - on_chord) <= allowed).any())

    def _update(self) -> None:
        fresh = [b for b in self.atlas.branches[self.seen :] if b.order == self.order]
        self.seen = len(self.atlas.branches)
        for kind in BranchKind:
            rows = [_chords(branch) for branch in fresh if branch.kind is kind]
            self.chords[kind] = np.concatenate([self.chords[kind], *rows])


def _chords(branch: Branch) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Neighbouring samples as rows p0, x0, p1, x1."""
    points = np.column_stack([branch.parameter, branch.x])
    rows: np.ndarray[tuple[int, int], np.dtype[np.float64]] = np.hstack([points[:-1], points[1:]])
    return rows
