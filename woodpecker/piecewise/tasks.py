"""What a search asks for: to follow branches and to take slices."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from pwmap.diagrams.diagram import BranchKind
from woodpecker.base.executors import Done
from woodpecker.piecewise.counting import as_counting
from woodpecker.piecewise.crossings import cycle_at_border
from woodpecker.piecewise.curves import Beginning, Followed
from woodpecker.piecewise.cycle_branches import Cycles
from woodpecker.piecewise.ends import Collision, End, end_of
from woodpecker.piecewise.jump_branches import Jumps, at_corner, cycle_from
from woodpecker.piecewise.jumps import Jump
from woodpecker.piecewise.orbits import Closed, Margin, Orbit
from woodpecker.piecewise.pieces import PiecewiseMap
from woodpecker.piecewise.samples import Sample, Stop, StopRule
from woodpecker.piecewise.settings import Settings
from woodpecker.piecewise.slices import Slice, slices_at
from woodpecker.piecewise.switching import switched


@dataclass(frozen=True, slots=True)
class Worker:
    """Carries out the tasks of a search. It remembers nothing, and pickles if its map does."""

    map: PiecewiseMap
    settings: Settings
    stop: StopRule | None = None

    def __post_init__(self) -> None:
        if self.stop is not None and not callable(self.stop):
            raise TypeError(f"stop must be a function of a state on a branch, got {self.stop!r}")

    def __call__(self, task: Callable[..., Any], *arguments: Any) -> Done:
        """Carry out a task, a method of :class:`Tasks`."""
        map_ = as_counting(self.map)
        before = map_.evaluations
        value = task(Tasks(map_, self.settings, self.stop), *arguments)
        return Done(value, map_.evaluations - before)


class Tasks:
    """The tasks."""

    def __init__(
        self, map_: PiecewiseMap, settings: Settings, stop: StopRule | None = None
    ) -> None:
        self.map, self.settings, self.stop = map_, settings, stop

    def cycle(self, orbit: Orbit) -> Followed:
        """The branch through a cycle."""
        return Cycles(self.map, self.settings, self.stop).through(orbit)

    def jump(self, jump: Jump) -> Followed:
        """The branch of a jump."""
        return Jumps(self.map, jump.order, self.settings, self.stop).through(
            jump.head, jump.closing
        )

    def starts(self, met: Collision, orders: Sequence[int]) -> list[Beginning]:
        """Branches that start where a cycle meets a jump.

        None does if the map does not show the piece inside the border any more.
        """
        found = list[Beginning]()
        cycle = cycle_at_border(
            self.map, met.x, met.p, met.margin, met.side, met.key, self.settings
        )
        if cycle is None:
            return found
        n, first = len(cycle), cycle_from(cycle, met.margin, self.settings)
        if n in orders and first:
            found.append(_of_cycles(first, end_of(met, cycle)))
        for order in orders:
            for shift in range(n) if order >= n else ():
                end = end_of(met, cycle.rotated(shift))
                jumps = Jumps(self.map, order, self.settings)
                for own in at_corner(cycle, met.margin, self.settings):
                    for samples in jumps.starts(cycle, own, shift):
                        closing = Margin(len(samples[0].orbit) - 1, own.code)
                        begin = Beginning(
                            kind=BranchKind.JUMP, order=order, samples=samples, closing=closing,
                            end=end,
                        )  # fmt: skip
                        found.append(begin)
        return found

    def switches(self, end: End, orders: Sequence[int]) -> list[Beginning]:
        """Branches that start at a flip or a branch point."""
        found = switched(self.map, end, orders, self.settings)
        return [_of_cycles(samples, end) for samples in found]

    def ahead(self, begin: Beginning) -> Followed:
        """The branch that begins, or goes on, at a special point."""
        if begin.kind is BranchKind.JUMP:
            return Jumps(self.map, begin.order, self.settings, self.stop).ahead(begin)
        return Cycles(self.map, self.settings, self.stop).ahead(begin)

    def slice(self, p: float, orders: Sequence[int]) -> list[Slice]:
        """All cycles and jumps at one parameter."""
        return slices_at(self.map, p, orders, self.settings)


def _of_cycles(samples: tuple[Sample, ...], end: End) -> Beginning:
    """Where a branch of cycles begins."""
    return Beginning(
        kind=BranchKind.FIXED_POINT, order=len(samples[0].orbit), samples=samples, closing=Closed(),
        end=end, passed=Stop.BORDER,
    )  # fmt: skip
