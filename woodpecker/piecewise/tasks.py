"""What a search asks for: to follow branches and to take slices. Evaluations are counted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from woodpecker.base.executors import Done
from woodpecker.piecewise.maps import Evaluation, LabelledMap
from woodpecker.piecewise.partition import Resolution, SampledMap
from woodpecker.piecewise.paths import Paths
from woodpecker.piecewise.settings import Settings
from woodpecker.piecewise.slices import Slicer


class Task(Enum):
    """What can be asked for: a method of :class:`Paths`, or of :class:`Slicer`."""

    CYCLE = "follow the branch through a cycle"
    JUMP = "follow the branch of a jump"
    CYCLE_FROM = "follow the branch of cycles that starts at a border collision"
    JUMP_FROM = "follow the jump branch that starts at a border collision"
    SLICE = "find all cycles and jumps at one parameter"


@dataclass(frozen=True, slots=True, kw_only=True)
class Worker:
    """Carries out the tasks of a search. It remembers nothing, and pickles if its maps do.

    Parameters
    ----------
    labelled_map, samples
        P_1, and P_1 for many points at once if slices are wanted.
    settings
        Span, window, steps and tolerances.
    orders
        Iterates that are explored.
    resolution
        How closely slices look at P_1.
    """

    labelled_map: LabelledMap
    settings: Settings
    orders: tuple[int, ...] = ()
    samples: SampledMap | None = None
    resolution: Resolution = field(default_factory=Resolution)

    def __call__(self, task: Task, *arguments: Any) -> Done:
        """Carry out a task."""
        counted = _Counted(self.labelled_map)
        if task is Task.SLICE:
            if self.samples is None:
                raise ValueError("slices need a map for many points at once")
            slicer = Slicer(counted, self.samples, self.settings, self.resolution)
            return Done(slicer.take(*arguments), counted.calls + slicer.evaluations)
        paths = Paths(counted, self.settings, self.orders)
        methods: dict[Task, Callable[..., Any]] = {
            Task.CYCLE: paths.cycle, Task.JUMP: paths.jump,
            Task.CYCLE_FROM: paths.cycle_from, Task.JUMP_FROM: paths.jump_from,
        }  # fmt: skip
        return Done(methods[task](*arguments), counted.calls)


class _Counted:
    """A labelled map that counts its calls, for the time of one task."""

    def __init__(self, labelled_map: LabelledMap) -> None:
        self._map, self.calls = labelled_map, 0

    def __call__(self, x: float, p: float) -> Evaluation:
        self.calls += 1
        return self._map(x, p)
