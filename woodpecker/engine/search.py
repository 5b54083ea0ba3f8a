"""Everything that is connected, and everything there is.

Branches are followed with all that hangs on their ends. A slice lists all cycles and jumps at one
parameter; what lies on no branch known so far is followed too. First slices fill the span evenly;
where one of them shows something new two more are taken, halfway to its neighbours, until nothing
is new or the gaps are as small as was asked: how thin an island can be and stay unseen is known.
"""

from __future__ import annotations

from bisect import bisect_left, insort
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

from pwmap.diagrams.diagram import BranchKind
from woodpecker.base.executors import Pending, Scheduler
from woodpecker.engine.branches import Collision, Curve, keys_of
from woodpecker.engine.known import Known
from woodpecker.engine.network import Network
from woodpecker.engine.orbits import Closed
from woodpecker.engine.settings import Settings
from woodpecker.engine.slices import Slice
from woodpecker.engine.tasks import Tasks


@dataclass(frozen=True, slots=True, kw_only=True)
class Search:
    """How to look for what is not connected.

    Parameters
    ----------
    slices
        How many slices are taken first.
    finest
        Smallest gap between slices, as a part of the span.
    """

    slices: int = 63
    finest: float = 5e-4

    def __post_init__(self) -> None:
        if self.slices < 1:
            raise ValueError(f"slices must be at least 1, got {self.slices}")
        if not 0.0 < self.finest < 1.0:
            raise ValueError(f"finest must lie in (0, 1), got {self.finest}")


class Stage(NamedTuple):
    """How far a search has come."""

    parameter: float
    order: int
    slices: int
    branches: int


class Recorder(Protocol):
    """Keeps what is finished."""

    def followed(self, curves: Sequence[Curve]) -> None:
        """Keep the curves that a task has come to."""

    def done(self, met: Collision) -> None:
        """Keep that all that starts at the next collision was followed."""


class Explorer:
    """Follows branches, and what starts at their ends.

    Parameters
    ----------
    scheduler
        Where tasks are carried out.
    settings
        Scales.
    orders
        Iterates whose branches are kept.
    progress
        Called with every branch.
    recorder
        Keeps what is finished, if anybody does.
    """

    def __init__(
        self, scheduler: Scheduler, settings: Settings, orders: Sequence[int],
        progress: Callable[[Stage], None] = lambda _: None, recorder: Recorder | None = None,
    ) -> None:  # fmt: skip
        self.scheduler, self.orders, self.progress = scheduler, tuple(orders), progress
        self.recorder = recorder
        self.network, self.slices, self.evaluations = Network(settings), 0, 0
        self._known = {
            (kind, order): Known(self.network, kind, order)
            for kind in BranchKind
            for order in self.orders
        }

    def follow(self, task: Callable[..., Any], *arguments: object) -> None:
        """Carry out a task that yields branches, and go on from where they end."""
        self._keep(self.scheduler.submit(task, *arguments))
        self.go_on()

    def go_on(self) -> None:
        """Follow what starts at the collisions that were met."""
        while self.network.waiting:
            met = self.network.waiting.popleft()
            for start in self._done(self.scheduler.submit(Tasks.starts, met, self.orders)):
                known = self._known[start.kind, start.order]
                last = start.samples[-1]
                low, high = self.network.settings.span
                if not low <= last.orbit.p <= high:
                    continue
                if not known.explains(last.orbit, start.closing, keys_of(last.orbit, last.jump)):
                    self._keep(self.scheduler.submit(Tasks.ahead, start))
            if self.recorder is not None:
                self.recorder.done(met)

    def see(self, found: Slice) -> bool:
        """Follow what a slice shows and no branch explains; whether there was something."""
        before = len(self.network.curves)
        cycles, jumps = (self._known[kind, found.order] for kind in BranchKind)
        for orbit in found.cycles:
            if not cycles.explains(orbit, Closed(), orbit.keys):
                self.follow(Tasks.cycle, orbit)
        for jump in found.jumps:
            if not jumps.explains(jump.head, jump.closing, keys_of(jump.head, jump)):
                self.follow(Tasks.jump, jump)
        return len(self.network.curves) > before

    def _done(self, pending: Pending) -> Any:
        done = pending.result()
        self.evaluations += done.evaluations
        return done.value

    def _keep(self, pending: Pending) -> None:
        curves = [curve for curve in self._done(pending) if curve.order in self.orders]
        if self.recorder is not None:
            self.recorder.followed(curves)
        for curve in curves:
            self.network.add(curve)
            stage = Stage(curve.ends[1].p, curve.order, self.slices, len(self.network.branches))
            self.progress(stage)


def complete(explorer: Explorer, settings: Settings, search: Search) -> list[Slice]:
    """Take slices until they show nothing new; follow what they show.

    Returns
    -------
    The slices.
    """
    low, high = settings.span
    taken: list[Slice] = []
    places = first_places(search)
    arranged = sorted([0.0, *places, 1.0])
    k = 0
    while k < len(places):
        place = places[k]
        p = low + (high - low) * place
        explorer.slices = k + 1
        new = False
        for found in explorer.scheduler.submit(Tasks.slice, p, explorer.orders).result().value:
            taken.append(found)
            new |= explorer.see(found)
        k += 1
        if new and k > search.slices // 4:
            i = bisect_left(arranged, place)
            for other in (arranged[i - 1], arranged[i + 1]):
                if abs(other - place) >= 2.0 * search.finest:
                    insort(arranged, 0.5 * (place + other))
                    places.append(0.5 * (place + other))
    return taken


def first_places(search: Search) -> list[float]:
    """Where slices are taken first, as parts of the span: near both ends, then evenly.

    Multiples of the golden ratio fill (0, 1) evenly, and fall on no value that a map may have in
    its formulas.
    """
    near = 0.5 * search.finest
    return [near, 1.0 - near, *((k * GOLDEN) % 1.0 for k in range(1, search.slices + 1))]


GOLDEN = 0.5 * (5.0**0.5 - 1.0)
