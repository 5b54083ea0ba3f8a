"""Slices: every cycle and every jump crossing of some iterates at one parameter."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from woodpecker.piecewise.borders import Edge, edge_at
from woodpecker.piecewise.jumps import Jump, jump_through
from woodpecker.piecewise.maps import SAME_CYCLE, Cycle, LabelledMap, correct, evaluate
from woodpecker.piecewise.partition import Resolution, SampledMap, iterated, partition, slice_of
from woodpecker.piecewise.pullback import Backward, Itineraries
from woodpecker.piecewise.settings import Settings

# What iterates ask of the pieces of P_1: guesses only, for Newton's method.
BEND, EDGE, CLOSE = 1e-4, 1e-6, 1e-3
WIDEST_FLICKER = 1e-11  # rad: as far rounding may blur where the words of an edge change
MUCH = 100.0  # a guess this many times too steep is not looked at more closely


class Found(NamedTuple):
    """What a slice shows of one iterate.

    Attributes
    ----------
    cycles, jumps
        In order of their first points, and of their places.
    failed
        (parameter, x) of what could not be located on the map itself.
    steep
        How many cycles are left out that are steeper than ``Settings.steepest``.
    unresolved
        Total length of intervals in which there are more pieces than were looked for.
    """

    p: float
    order: int
    cycles: tuple[Cycle, ...]
    jumps: tuple[Jump, ...]
    failed: tuple[tuple[float, float], ...]
    steep: int
    unresolved: float


class Slicer:
    """Takes slices of a map and its iterates.

    Parameters
    ----------
    labelled_map, samples
        P_1, and P_1 for many points at once.
    settings
        Window and tolerances.
    resolution
        How closely P_1 is looked at.
    """

    def __init__(
        self, labelled_map: LabelledMap, samples: SampledMap, settings: Settings,
        resolution: Resolution,
    ) -> None:  # fmt: skip
        self.map, self.settings, self.resolution = labelled_map, settings, resolution
        self.coarse = replace(resolution, bend=max(resolution.bend, BEND), edge=EDGE, close=CLOSE)
        self.samples = iterated(samples, 1, settings.window)
        self.evaluations = 0  # of the map for many points

    def take(self, p: float, orders: Sequence[int]) -> list[Found]:
        """What some iterates show at a parameter."""
        if tuple(orders) == (1,):
            return [self._first(p)]
        pieces = partition(self.samples, p, self.settings.window, self.coarse)
        orbits = Itineraries(self.samples, pieces)
        found = [
            self._located(p, order, orbits, pieces.unresolved_length) for order in sorted(orders)
        ]
        self.evaluations += pieces.evaluations + orbits.evaluations
        return found

    def _first(self, p: float) -> Found:
        """P_1 alone, where only what lies on the diagonal matters."""
        tolerances = self.settings.tolerances
        found = slice_of(self.samples, p, self.settings.window, self.resolution, tolerances)
        self.evaluations += found.partition.evaluations
        failed: list[tuple[float, float]] = []
        cycles: list[Cycle] = []
        jumps = []
        for x, _ in found.fixed_points:
            cycle, good, _ = correct(self.map, x, p, None, tolerances)
            if good:
                cycles.append(cycle)
            else:
                failed.append((p, x))
        cycles, steep = self._gentle(cycles)
        for edge in found.crossings:
            jump = jump_through(self.map, self._labelled(edge), (), 1)
            if jump is not None and jump.whole.crosses:
                jumps.append(jump)
            else:
                failed.append((p, edge.x))
        unresolved = found.partition.unresolved_length
        return Found(p, 1, tuple(cycles), tuple(jumps), tuple(failed), steep, unresolved)

    def _located(self, p: float, order: int, orbits: Itineraries, unresolved: float) -> Found:
        """Newton's method on everything that the pieces of P_1 promise."""
        failed: list[tuple[float, float]] = []
        cycles, steep = self._cycles(p, orbits, order, failed)
        jumps = list(self._jumps(p, orbits.jumps_of(order), order, failed))
        return Found(
            p, order, tuple(cycles), tuple(sorted(jumps, key=lambda jump: jump.x)), tuple(failed),
            steep, unresolved,
        )  # fmt: skip

    def _gentle(self, cycles: Sequence[Cycle]) -> tuple[list[Cycle], int]:
        """Those that are not too steep, and the number of the others."""
        kept = [cycle for cycle in cycles if cycle.steepness <= self.settings.steepest]
        return kept, len(cycles) - len(kept)

    def _cycles(
        self, p: float, orbits: Itineraries, order: int, failed: list[tuple[float, float]]
    ) -> tuple[list[Cycle], int]:
        cycles, steep = [], 0
        sure = orbits.cycles(order)
        for k, points in enumerate([*sure, *orbits.perhaps(order)]):
            if evaluate(self.map, points, p).steepness > MUCH * self.settings.steepest:
                steep += k < len(sure)
                continue
            cycle, good, _ = correct(self.map, points, p, None, self.settings.tolerances)
            if good:
                cycles.append(cycle)
            elif k < len(sure):
                failed.append((p, float(points[0])))
        low, high = self.settings.window
        cycles = [cycle for cycle in cycles if low <= cycle.x.min() and cycle.x.max() <= high]
        kept, more = self._gentle(list(_distinct(cycles)))
        return kept, steep + more

    def _jumps(
        self, p: float, found: Sequence[Backward], order: int, failed: list[tuple[float, float]]
    ) -> Iterator[Jump]:
        edges: dict[float, Edge] = {}
        for points, rough in found:
            if rough.x not in edges:
                edges[rough.x] = self._labelled(rough)
            jump = jump_through(self.map, edges[rough.x], points, order)
            if jump is None:
                failed.append((p, points[0] if points else rough.x))
            elif jump.whole.crosses and self._clear(jump.whole):
                yield jump

    def _clear(self, edge: Edge) -> bool:
        """Whether both limits are off the diagonal by more than rounding."""
        off = min(abs(edge.left_limit - edge.x), abs(edge.right_limit - edge.x))
        return off > self.settings.tolerances.residual

    def _labelled(self, edge: Edge) -> Edge:
        """The same edge with the words of the labelled map on both sides."""
        return edge_at(self.map, edge.x, edge.p, WIDEST_FLICKER)


def _distinct(cycles: Iterable[Cycle]) -> Iterator[Cycle]:
    """Cycles in order of their first points, what was found twice only once."""
    last: Cycle | None = None
    for cycle in sorted(cycles, key=lambda cycle: float(cycle.x[0])):
        if last is None or np.abs(cycle.x - last.x).max() > SAME_CYCLE:
            yield cycle
        last = cycle
