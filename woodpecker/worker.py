"""What a search asks for: to follow branches and to take slices. Evaluations are counted."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from woodpecker.crew import Done
from woodpecker.labelled import Evaluation, LabelledMap
from woodpecker.paths import Paths
from woodpecker.pieces import Resolution, SampledMap
from woodpecker.settings import Settings
from woodpecker.slices import Slicer


class Worker:
    """Does the tasks of a search.

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

    def __init__(
        self, labelled_map: LabelledMap, settings: Settings, orders: Iterable[int] = (),
        samples: SampledMap | None = None, resolution: Resolution | None = None,
    ) -> None:  # fmt: skip
        self._calls = 0

        def counted(x: float, p: float) -> Evaluation:
            self._calls += 1
            return labelled_map(x, p)

        paths = Paths(counted, settings, orders)
        self._tasks: dict[str, Callable[..., Any]] = {
            "cycle": paths.cycle, "jump": paths.jump,
            "cycle_from": paths.cycle_from, "jump_from": paths.jump_from,
        }  # fmt: skip
        self._slicer: Slicer | None = None
        if samples is not None:
            self._slicer = Slicer(counted, samples, settings, resolution or Resolution())
            self._tasks["take"] = self._slicer.take

    def __call__(self, task: str, *arguments: Any) -> Done:
        """Do a task by its name."""
        before = self._evaluations()
        value = self._tasks[task](*arguments)
        return Done(value, self._evaluations() - before)

    def _evaluations(self) -> int:
        return self._calls + (self._slicer.evaluations if self._slicer is not None else 0)
