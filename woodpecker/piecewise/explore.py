"""Exploring: follow branches, and whatever hangs on their ends, over one or more iterates.

Where a branch of one kind ends in a border collision one of the other kind begins. What is found is
kept in an :class:`woodpecker.piecewise.network.Atlas`, and written down in a journal if there is
one. Branches are submitted some time before they are needed; one that turns out not to be is
dropped.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

from pwmap.diagrams.diagram import BranchKind
from woodpecker.base.checkpoint import Entry
from woodpecker.base.executors import Done, Pending, Scheduler
from woodpecker.piecewise.checkpoint import DONE, PATH, Journal, of_runs, to_runs
from woodpecker.piecewise.jumps import Jump
from woodpecker.piecewise.maps import Cycle
from woodpecker.piecewise.network import Atlas
from woodpecker.piecewise.tasks import Task

MOST_BRANCHES = 100_000


class Stage(NamedTuple):
    """How far a search has come."""

    parameter: float  # where a branch was followed
    order: int
    slices: int  # taken of this order; 0 if none are taken
    branches: int  # of all orders


Progress = Callable[[Stage], None]


class Start(NamedTuple):
    """Where a branch of an iterate can be picked up."""

    kind: BranchKind
    order: int
    at: Cycle | Jump


class Explorer:
    """Breadth-first search over border collisions.

    Parameters
    ----------
    scheduler
        Where tasks are carried out that follow branches.
    progress
        Called now and then.
    journal
        Where paths are written down; what it holds already is taken over.
    """

    def __init__(
        self,
        scheduler: Scheduler,
        progress: Progress | None = None,
        journal: Journal | None = None,
    ) -> None:
        self.scheduler, self.journal = scheduler, journal
        self.atlas, self.slices, self.evaluations = Atlas(), 0, 0
        self._progress = progress or (lambda _: None)
        if journal is not None:
            restore(self.atlas, journal.entries, journal.path)

    def explore(
        self, starts: Sequence[Start], known: Callable[[Start], bool] = lambda _: False
    ) -> None:
        """Follow the branches through some starts both ways, then whatever hangs on their ends.

        A start that is known when its turn comes is passed over.
        """
        pending: dict[int, Pending] = {}
        passed: set[int] = set()
        for k, start in enumerate(starts):
            for later in range(k, min(k + self.scheduler.ahead, len(starts))):
                if later in pending or later in passed:
                    continue
                if known(starts[later]):
                    passed.add(later)
                else:
                    pending[later] = self.scheduler.submit(*_task(starts[later]))
            if k in passed:
                continue
            here = pending.pop(k)
            if known(start):
                here.cancel()
            else:
                self._keep(here.result(), start.kind, start.order)
                self.go_on()

    def go_on(self) -> None:
        """Follow what hangs on the border collisions that were met."""
        waiting = self.atlas.waiting
        pending: dict[tuple[str, int, BranchKind], Pending] = {}
        while waiting and len(self.atlas.branches) < MOST_BRANCHES:
            for soon in islice(waiting, self.scheduler.ahead):
                for kind, follow in _FROM.items():
                    key = soon.node.id, soon.departure.order, kind
                    if kind not in soon.followed and key not in pending:
                        pending[key] = self.scheduler.submit(follow, soon.departure)
            collision = waiting[0]
            node, order = collision.node, collision.departure.order
            for kind in _FROM:
                task = pending.pop((node.id, order, kind), None)
                if task is None:
                    continue
                if kind in collision.followed:
                    task.cancel()
                    continue
                done = task.result()
                for run in done.value[:1]:
                    run[0] = replace(run[0], kind=node.kind, note=node.note)
                self._keep(done, kind, order)
            self.write({DONE: node.id, "order": order})
            waiting.popleft()
        if waiting:
            logging.getLogger("woodpecker").warning(
                "stopped after %d branches: %d ends were not followed", MOST_BRANCHES, len(waiting)
            )

    def _keep(self, done: Done, kind: BranchKind, order: int) -> None:
        self.evaluations += done.evaluations
        if not done.value:
            return
        self.write(of_runs(done.value, kind, order))
        for run in done.value:
            self.atlas.add(run, kind, order)
            for end in (run[0], run[-1]):
                stage = Stage(float(end.p), order, self.slices, len(self.atlas.branches))
                self._progress(stage)

    def write(self, entry: Entry) -> None:
        """Write down what was found, if there is a journal."""
        if self.journal is not None:
            self.journal.write(entry)


_FROM = {BranchKind.JUMP: Task.JUMP_FROM, BranchKind.FIXED_POINT: Task.CYCLE_FROM}


def _task(start: Start) -> tuple[Any, ...]:
    if start.kind is BranchKind.JUMP:
        return Task.JUMP, start.at, start.order
    return Task.CYCLE, start.at


def restore(atlas: Atlas, entries: Iterable[Entry], path: Path) -> None:
    """Put an atlas back to where a journal says it was.

    Raises
    ------
    ValueError
        If an entry does not follow from those before it.
    """
    for line, entry in enumerate(entries, 2):
        if PATH in entry:
            runs, kind, order = to_runs(entry)
            for run in runs:
                atlas.add(run, kind, order)
        elif DONE in entry:
            try:
                atlas.finish(entry[DONE], entry["order"])
            except (KeyError, ValueError):
                raise ValueError(
                    f"{path}, line {line}: nothing is left to follow at {entry[DONE]}"
                ) from None
