"""Exploring: follow branches, and whatever hangs on their ends, over one or more iterates.

Fixed-point branches are followed by :mod:`woodpecker.follow`, jump branches by
:mod:`woodpecker.jumps`; where one ends in a border collision the other begins. What is found is
kept in an :class:`woodpecker.atlas.Atlas`, and written down in a journal if there is one.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pwmap.diagram import BranchKind, PointKind
from woodpecker.atlas import COLLISIONS, Atlas, Collision, Sample
from woodpecker.edges import Edge, edge_of_iterate, edges_between, is_continuous, nearest_edge
from woodpecker.follow import CLOSED, PathPoint, classify, follow_from
from woodpecker.journal import DONE, PATH, Entry, Journal, of_samples, to_samples
from woodpecker.jumps import JumpPoint, follow_jump
from woodpecker.labelled import SEPARATOR, Cycle, LabelledMap, iterate
from woodpecker.landing import beside, orbit_beside
from woodpecker.settings import Settings

SAME_CYCLE = 1e-9  # points of a cycle closer than this are one: its minimal period is shorter
SAME_PLACE = 1e-6  # an edge of P_j further off is not the one that a cycle has met
MOST_BRANCHES = 100_000
FASTEST = 100.0  # largest speed dx/dp of an edge that is expected next to a border collision


class Stage(NamedTuple):
    """How far a search has come."""

    parameter: float  # where a branch is being followed
    order: int
    slices: int  # taken of this order; 0 if none are taken
    branches: int  # of all orders


Progress = Callable[[Stage], None]


class Explorer:
    """Breadth-first search over border collisions.

    Parameters
    ----------
    labelled_map
        The map; iterates of it are made as they are needed.
    settings
        Span, window, steps and tolerances.
    progress
        Called now and then.
    orders
        Iterates that are explored: a cycle of P_j that is one of a lower order among these is not
        followed again.
    journal
        Where paths are written down; what it holds already is taken over.
    """

    def __init__(
        self,
        labelled_map: LabelledMap,
        settings: Settings,
        progress: Progress | None = None,
        orders: Sequence[int] = (),
        journal: Journal | None = None,
    ) -> None:
        self.map, self.settings, self.orders, self.journal = labelled_map, settings, orders, journal
        self.atlas, self.slices = Atlas(), 0
        self._progress = progress or (lambda _: None)
        self._iterates: dict[int, LabelledMap] = {}
        if journal is not None:
            restore(self.atlas, journal.entries)

    def iterate(self, order: int) -> LabelledMap:
        """P_order."""
        if order not in self._iterates:
            self._iterates[order] = iterate(self.map, order)
        return self._iterates[order]

    def explore_cycle(self, start: Cycle) -> None:
        """Follow the branch through a cycle both ways, then whatever hangs on its ends."""
        order = len(start.x)
        along = np.zeros(order + 1)
        along[-1] = 1.0
        ahead = self._points(follow_from(self.map, start, along, self.settings))
        closes = ahead[-1].note == CLOSED  # an island
        behind = [] if closes else self._points(follow_from(self.map, start, -along, self.settings))
        for first in range(order):
            samples = [self._fixed(point, first) for point in ahead]
            if closes:  # cut where it does
                samples[0] = samples[-1] = replace(samples[-1], p=samples[0].p, x=samples[0].x)
            rest = [self._fixed(point, first) for point in behind[1:]]
            self._add([*reversed(rest), *samples], BranchKind.FIXED_POINT, order)
        self.go_on()

    def explore_jump(self, edge: Edge, order: int) -> None:
        """Follow a jump of P_order that crosses the diagonal both ways, then what hangs on it."""
        ahead, behind = (
            self._jumps(follow_jump(self.map, edge, self.settings, direction, order), order)
            for direction in (1, -1)
        )
        word = f"{edge.left.word} / {edge.right.word}"
        first = Sample(edge.p, edge.x, math.nan, word, None, "", edge)
        self._add([*reversed(behind), first, *ahead], BranchKind.JUMP, order)
        self.go_on()

    def is_known(self, cycle: Cycle) -> bool:
        """Whether a cycle goes round one of a lower order that is explored as well."""
        period = minimal_period(cycle)
        return period < len(cycle.x) and period in self.orders

    def go_on(self) -> None:
        """Follow what hangs on the border collisions that were met."""
        waiting = self.atlas.waiting
        while waiting and len(self.atlas.branches) < MOST_BRANCHES:
            collision = waiting[0]
            if BranchKind.JUMP not in collision.followed:
                self._jump_from(collision)
            if BranchKind.FIXED_POINT not in collision.followed:
                self._fixed_from(collision)
            self._write({DONE: collision.node.id, "order": collision.order})
            waiting.popleft()
        if waiting:
            logging.getLogger("woodpecker").warning(
                "stopped after %d branches: %d ends were not followed",
                MOST_BRANCHES,
                len(waiting),
            )

    def _add(self, samples: Sequence[Sample], kind: BranchKind, order: int) -> None:
        self._write(of_samples(samples, kind, order))
        self.atlas.add(samples, kind, order)

    def _write(self, entry: Entry) -> None:
        if self.journal is not None:
            self.journal.write(entry)

    def _tell(self, p: float, order: int) -> None:
        self._progress(Stage(p, order, self.slices, len(self.atlas.branches)))

    def _points(self, path: Iterable[PathPoint]) -> list[PathPoint]:
        points = []
        for point in path:
            self._tell(point.p, len(point.cycle.x))
            points.append(point)
        return points

    def _fixed(self, point: PathPoint, first: int) -> Sample:
        """A cycle as a fixed point of P_j: one of its points, and the edge of P_j that it meets."""
        cycle, kind, note = point.cycle, point.kind, point.note
        edge, inner = point.edge, -point.side
        if edge is not None and len(cycle.x) > 1:
            whole, side = edge_of_iterate(self.map, cycle, point.lap, edge, point.side, first)
            edge, inner = (whole if kind in COLLISIONS else None), -side
        if edge is not None and kind in COLLISIONS:
            kind, note = classify(edge, inner, cycle.multiplier)
        words = SEPARATOR.join((*cycle.words[first:], *cycle.words[:first]))
        x = float(cycle.x[first])
        return Sample(float(point.p), x, cycle.multiplier, words, kind, note, edge, inner)

    def _jumps(self, path: Iterable[JumpPoint], order: int) -> list[Sample]:
        samples = []
        for point in path:
            self._tell(point.p, order)
            edge, note, kind = point.edge, point.note, point.kind
            word = f"{edge.left.word} / {edge.right.word}"
            if kind is PointKind.BC:
                m = (edge.left if point.side < 0 else edge.right).slope
                kind, note = classify(edge, point.side, m)
            samples.append(Sample(edge.p, edge.x, math.nan, word, kind, note, edge, point.side))
        return samples

    def _jump_from(self, collision: Collision) -> None:
        """Follow the jump branch that starts at a border collision, if it crosses on one side."""
        whole, node, x = self.iterate(collision.order), collision.node, collision.edge.x
        for direction in (1, -1):
            p = node.p + direction * self.settings.tolerances.landing
            if not self.settings.span[0] <= p <= self.settings.span[1]:
                continue
            reach = FASTEST * self.settings.tolerances.landing
            for edge in edges_between(whole, p, x - reach, x + reach):
                if not edge.crosses or is_continuous(edge, self.settings.tolerances):
                    continue
                path = self._jumps(
                    follow_jump(self.map, edge, self.settings, direction, collision.order),
                    collision.order,
                )
                word = f"{edge.left.word} / {edge.right.word}"
                first = Sample(
                    node.p, x, math.nan, word, node.kind, node.note, collision.edge, collision.inner
                )
                self._add([first, *path], BranchKind.JUMP, collision.order)
                return

    def _fixed_from(self, collision: Collision) -> None:
        """Follow the fixed-point branch that starts at a border collision."""
        node, inner, order = collision.node, collision.inner, collision.order
        landed = beside(self.map, collision.edge, inner, order, self.settings)
        if landed is None or self.is_known(landed.cycle):
            return
        path = self._points(follow_from(self.map, landed.cycle, landed.tangent, self.settings))
        side = collision.edge.right if inner > 0 else collision.edge.left
        start = Sample(
            node.p, node.x, side.slope, path[0].cycle.word, node.kind, node.note, collision.edge,
            inner,
        )  # fmt: skip
        self._add(
            [start, *(self._fixed(point, 0) for point in path)], BranchKind.FIXED_POINT, order
        )
        met = self._met(collision) if order > 1 else None
        for first in range(1, order) if met is not None else ():
            assert met is not None
            samples = [self._fixed(point, first) for point in (met, *path)]
            self._add(samples, BranchKind.FIXED_POINT, order)

    def _met(self, collision: Collision) -> PathPoint | None:
        """The cycle of P_j at a collision, with the edge of P_1 that one of its laps meets."""
        edge, inner = collision.edge, collision.inner
        cycle = orbit_beside(self.map, edge, inner, collision.order)
        if cycle is None:
            return None
        words = zip(*(side.word.split(SEPARATOR) for side in (edge.left, edge.right)), strict=False)
        lap = next((k for k, (left, right) in enumerate(words) if left != right), 0)
        met = nearest_edge(self.map, float(cycle.x[lap]), edge.p, cycle.words[lap])
        if met is None:
            return None
        return PathPoint(
            cycle=cycle, tangent=np.zeros(collision.order + 1), kind=collision.node.kind,
            note=collision.node.note, edge=met[0], side=met[1], lap=lap,
        )  # fmt: skip


def minimal_period(cycle: Cycle) -> int:
    """The smallest shift that maps a cycle to itself."""
    n = len(cycle.x)
    divisors = (d for d in range(1, n + 1) if n % d == 0)
    return next(d for d in divisors if np.abs(np.roll(cycle.x, -d) - cycle.x).max() < SAME_CYCLE)


def restore(atlas: Atlas, entries: Iterable[Entry]) -> None:
    """Put an atlas back to where a journal says it was."""
    for entry in entries:
        if PATH in entry:
            atlas.add(*to_samples(entry))
        elif DONE in entry:
            atlas.finish(entry[DONE], entry["order"])
