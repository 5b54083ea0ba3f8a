"""Runs of samples: what following a branch from a start yields, for either kind of branch.

Nothing here remembers anything: a run depends on its start alone, whoever follows it, and when.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from pwmap.diagrams.diagram import PointKind
from woodpecker.base.arrays import Floats
from woodpecker.piecewise.borders import (
    Edge,
    edge_of_iterate,
    edges_between,
    is_continuous,
    nearest_edge,
)
from woodpecker.piecewise.conditioning import checked, gentle
from woodpecker.piecewise.jumps import Jump, JumpPoint, follow_jump
from woodpecker.piecewise.maps import SEPARATOR, Cycle, LabelledMap, iterate, minimal_period
from woodpecker.piecewise.network import COLLISIONS, Departure, Sample
from woodpecker.piecewise.restart import beside, orbit_beside
from woodpecker.piecewise.settings import Settings
from woodpecker.piecewise.stepping import CLOSED, PathPoint, classify, follow_from

FASTEST = 100.0  # largest speed dx/dp of an edge that is expected next to a border collision

Runs = list[list[Sample]]


class Paths:
    """Follows branches of a map and its iterates.

    Parameters
    ----------
    labelled_map
        P_1.
    settings
        Span, window, steps and tolerances.
    orders
        Iterates that are explored: a cycle of P_j that goes round one of a lower order among these
        is not followed again.
    """

    def __init__(
        self, labelled_map: LabelledMap, settings: Settings, orders: Iterable[int] = ()
    ) -> None:
        self.map, self.settings, self.orders = labelled_map, settings, tuple(orders)

    def is_known(self, cycle: Cycle) -> bool:
        """Whether a cycle goes round one of a lower order that is explored as well."""
        period = minimal_period(cycle)
        return period < len(cycle.x) and period in self.orders

    def cycle(self, start: Cycle) -> Runs:
        """The branch through a cycle, both ways: one run for each of its points."""
        order = len(start.x)
        along = np.zeros(order + 1)
        along[-1] = 1.0
        ahead = self._path(start, along)
        if not ahead:
            return []
        closes = ahead[-1].note == CLOSED  # an island
        behind = [] if closes else self._path(start, -along)
        runs = []
        for first in range(order):
            run = list(self._samples(ahead, first))
            if closes:  # cut where it does
                run[0] = run[-1] = replace(run[-1], p=run[0].p, x=run[0].x)
            runs.append([*self._samples(behind[:0:-1], first), *run])
        return runs

    def jump(self, start: Edge | Jump, order: int) -> Runs:
        """The branch of a jump of P_order that crosses the diagonal, both ways."""
        ahead, behind = (
            self._jumps(follow_jump(self.map, start, self.settings, direction, order))
            for direction in (1, -1)
        )
        edge = start.whole if isinstance(start, Jump) else start
        first = Sample(edge.p, edge.x, math.nan, _sides(edge), None, "", edge)
        return [[*reversed(behind), first, *ahead]]

    def jump_from(self, start: Departure) -> Runs:
        """The jump branch that starts at a border collision, if it crosses on one side."""
        whole = iterate(self.map, start.order)
        for direction in (1, -1):
            p = start.p + direction * self.settings.tolerances.landing
            if not self.settings.span[0] <= p <= self.settings.span[1]:
                continue
            reach = FASTEST * self.settings.tolerances.landing
            for edge in edges_between(whole, p, start.edge.x - reach, start.edge.x + reach):
                if not edge.crosses or is_continuous(edge, self.settings.tolerances):
                    continue
                if not self._inside(np.array([edge.x])):
                    continue
                path = follow_jump(self.map, edge, self.settings, direction, start.order)
                return [[_first(start, _sides(edge), math.nan), *self._jumps(path)]]
        return []

    def cycle_from(self, start: Departure) -> Runs:
        """The fixed-point branch that starts at a border collision: one run for each point."""
        landed = beside(self.map, start.edge, start.inner, start.order, self.settings)
        if landed is None or self.is_known(landed.cycle) or not self._inside(landed.cycle.x):
            return []
        path = self._path(landed.cycle, landed.tangent)
        if not path:
            return []
        side = start.edge.right if start.inner > 0 else start.edge.left
        first = _first(start, path[0].cycle.word, side.slope)
        runs = [[first, *self._samples(path, 0)]]
        met = self._met(start) if start.order > 1 else None
        if met is not None:
            runs += [list(self._samples((met, *path), k)) for k in range(1, start.order)]
        return runs

    def _inside(self, x: Floats) -> bool:
        """Whether points lie in the window."""
        low, high = self.settings.window
        return bool(low <= x.min() and x.max() <= high)

    def _path(self, start: Cycle, along: Floats) -> list[PathPoint]:
        """The branch through a cycle, one way; nothing if it is too steep there."""
        path = follow_from(self.map, start, along, self.settings)
        return list(gentle(path, self.map, self.settings))

    def _met(self, start: Departure) -> PathPoint | None:
        """The cycle of P_j at a collision, with the edge of P_1 that one of its laps meets."""
        edge = start.edge
        cycle = orbit_beside(self.map, edge, start.inner, start.order)
        if cycle is None:
            return None
        words = zip(*(side.word.split(SEPARATOR) for side in (edge.left, edge.right)), strict=False)
        lap = next((k for k, (left, right) in enumerate(words) if left != right), 0)
        met = nearest_edge(self.map, float(cycle.x[lap]), edge.p, cycle.words[lap])
        if met is None:
            return None
        return PathPoint(
            cycle=cycle, tangent=np.zeros(start.order + 1), kind=PointKind.BC, edge=met[0],
            side=met[1], lap=lap,
        )  # fmt: skip

    def _samples(self, path: Iterable[PathPoint], first: int) -> Iterator[Sample]:
        """A path as seen from one of the points of its cycles; what cannot be checked is left out.

        On an edge P_j has two values or an infinite slope: there is nothing to be checked.
        """
        for point in path:
            sample = self._fixed(point, first)
            if point.edge is None:
                x = checked(self.map, point.cycle, first, self.settings.tolerances.closing)
                if x is not None:
                    sample = replace(sample, x=x)
                elif point.kind is None:
                    continue
            yield sample

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

    def _jumps(self, path: Iterable[JumpPoint]) -> list[Sample]:
        samples = []
        for point in path:
            edge, note, kind = point.edge, point.note, point.kind
            if kind is PointKind.BC:
                m = (edge.left if point.side < 0 else edge.right).slope
                kind, note = classify(edge, point.side, m)
            samples.append(
                Sample(edge.p, edge.x, math.nan, _sides(edge), kind, note, edge, point.side)
            )
        return samples


def _first(start: Departure, word: str, multiplier: float) -> Sample:
    """The sample at a border collision; what kind of one, its node knows."""
    return Sample(start.p, start.x, multiplier, word, PointKind.BC, "", start.edge, start.inner)


def _sides(edge: Edge) -> str:
    """The word of a jump branch."""
    return f"{edge.left.word} / {edge.right.word}"
