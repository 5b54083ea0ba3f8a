"""A system with contacts from a Python file, and the state of its page."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from traceback import extract_tb
from types import ModuleType
from typing import Any, ClassVar

import numpy as np

from pwmap import Branch, BranchKind
from pwmap.explore.link import PREFIX, LinkedState, number, numbers, one_of
from woodpecker.base.checks import interval, real_array
from woodpecker.explore.state import ORDERS, STEPS
from woodpecker.systems import SystemMap

VIEWS = ("", "map", "diagram", "motion", "portrait", "word", "graph")


@dataclass(frozen=True, slots=True, eq=False)
class Explored:
    """A system as defined in its file."""

    map_: SystemMap  # the return map, with the parameters that the page begins with
    start: tuple[float, ...]  # (d,) point near a periodic motion
    window: tuple[tuple[float, float], ...]  # (d, 2) interval of each coordinate
    values: Mapping[str, float]  # of all parameters, at first
    ranges: Mapping[str, tuple[float, float]]  # interval of each parameter's slider

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the coordinates of the map."""
        return tuple(map(str, self.map_.section.free))


@lru_cache(maxsize=1)
def explored(path: str) -> Explored:
    """Run a file as a Python module, and read its ``map_``, ``start``, ``window`` and ``ranges``.

    ValueError or TypeError if the file or one of the first three is missing or not of its kind.
    """
    module = _module(path)
    for name in ("map_", "start", "window"):
        if not hasattr(module, name):
            raise ValueError(f"{path} must define {name!r}: it needs map_, start and window")
    map_ = module.map_
    if not isinstance(map_, SystemMap):
        raise TypeError(f"map_ of {path} must be a SystemMap, got {type(map_).__name__}")
    start = tuple(real_array("start", module.start).ravel().tolist())
    if not np.iterable(module.window):
        raise TypeError(f"window of {path} must be a list of two ends each, got {module.window!r}")
    window = tuple(interval("window", each, finite=True) for each in module.window)
    if len(start) != map_.d or len(window) != map_.d:
        raise ValueError(
            f"start and window of {path} must have {map_.d} entries, one of each coordinate of the "
            f"map, got {len(start)} and {len(window)}"
        )
    values = {str(name): float(v) for name, v in map_.system.parameters.items()}
    given = getattr(module, "ranges", {})
    if not isinstance(given, Mapping):
        raise TypeError(f"ranges of {path} must have two ends for each name, got {given!r}")
    if unknown := sorted(map(str, set(map(str, given)) - set(values))):
        raise ValueError(f"ranges of {path} has {unknown[0]!r}, the system has {', '.join(values)}")
    told = {
        str(name): interval(f"the range of {name}", each, finite=True)
        for name, each in given.items()
    }
    ranges = {name: told.get(name, _usual(value)) for name, value in values.items()}
    return Explored(map_, start, window, values, ranges)


def _module(path: str) -> ModuleType:
    """The file as a module; ValueError with the line if it raises an error."""
    spec = spec_from_file_location("explored_system", path)
    if not Path(path).is_file() or spec is None or spec.loader is None:
        raise ValueError(f"there is no Python file {path!r}")
    module = module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        own = [f.lineno for f in extract_tb(error.__traceback__) if f.filename == spec.origin]
        line = error.lineno if isinstance(error, SyntaxError) else own[-1] if own else None
        said = error.msg if isinstance(error, SyntaxError) else error
        where = path if line is None else f"line {line} of {path}"
        raise ValueError(f"{where}: {type(error).__name__}: {said}".rstrip(": ")) from error
    return module


def _usual(value: float) -> tuple[float, float]:
    low, high = sorted((0.5 * value, 1.5 * value))
    return (low, high) if low < high else (0.0, 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class SystemState(LinkedState):
    """The state of a page of a system with contacts."""

    BESIDE: ClassVar[tuple[str, ...]] = ("path", "values")

    path: str  # of the file
    values: tuple[tuple[str, float], ...]  # of all parameters, with their names
    x: tuple[float, ...]  # (d,) the start on the section
    over: str  # parameter of the diagram
    periodic: bool = True  # the start follows a periodic motion when parameters change
    order: int = 1  # number of returns of the map and of the motion
    steps: int = 20  # of the cobweb
    coordinate: int = 0  # index of the coordinate whose history and portrait are shown
    focus: str = ""  # the view that is shown large, none if empty

    def __post_init__(self) -> None:
        known, coordinates = dict(self.values), len(self.given.map_.system.q)
        if self.over not in known:
            raise ValueError(f"over must be one of {', '.join(known)}, got {self.over[:40]!r}")
        if len(self.x) != len(self.given.start):
            raise ValueError(f"a start has {len(self.given.start)} numbers, got {self.x}")
        one_of("order", self.order, ORDERS)
        one_of("focus", self.focus[:40], VIEWS)
        if not STEPS[0] <= self.steps <= STEPS[1]:
            raise ValueError(f"steps must lie in {STEPS}, got {self.steps}")
        if not all(map(math.isfinite, (*known.values(), *self.x))):
            raise ValueError(f"values and start must be finite, got {known}, {self.x}")
        if not 0 <= self.coordinate < coordinates:
            raise ValueError(f"coordinate must lie below {coordinates}, got {self.coordinate}")

    @property
    def given(self) -> Explored:
        return explored(self.path)

    @property
    def map_(self) -> SystemMap:
        """The return map with the parameters of this state."""
        return self.given.map_.holding(**self.place)

    @property
    def span(self) -> tuple[float, float]:
        """The interval of the diagram's parameter."""
        return self.given.ranges[self.over]

    @property
    def place(self) -> dict[str, float]:
        return dict(self.values)

    @property
    def value(self) -> float:
        return self.place[self.over]

    def at(self, values: Mapping[str, Any]) -> SystemState:
        known = self.place
        return replace(self, values=tuple({**known, **numbers(values, tuple(known))}.items()))

    def at_sample(self, branch: Branch, sample: int) -> SystemState:
        there = self.at({self.over: float(branch.parameter[sample])})
        others = (float(branch.columns[name][sample]) for name in self.given.names[1:])
        return replace(
            there, x=(float(branch.x[sample]), *others),
            order=branch.order if branch.order in ORDERS else self.order,
            periodic=branch.kind is BranchKind.FIXED_POINT,
        )  # fmt: skip

    def with_axis(self, name: str) -> SystemState:
        return replace(self, over=name)

    def query(self) -> str:
        first = first_state(self.path)
        changed = set(self.values) - set(first.values)
        values = [(PREFIX + name, repr(v)) for name, v in self.values if (name, v) in changed]
        return self.link_from(first, values)

    def python(self) -> str:
        first = first_state(self.path).place
        changed = ", ".join(f"{n}={v!r}" for n, v in self.values if v != first[n])
        return "\n".join([
            "import runpy", "",
            "from woodpecker.systems import SystemMap, continuation, shoot", "",
            f"map_ = runpy.run_path({self.path!r})['map_']",
            f"system = map_.system.replace({changed})",
            f"map_ = SystemMap(system, map_.section, [{self.over!r}])",
            f"cycle = shoot(map_, {list(self.x)!r}, order={self.order})",
            "print(cycle.message, cycle.x, cycle.multipliers, cycle.word)",
            f"found = continuation(map_, cycle, {self.span!r}, {self.given.window!r})",
            "print(found.diagram)", "",
        ])  # fmt: skip


def first_state(path: str) -> SystemState:
    """The state of an empty link."""
    given = explored(path)
    over = (given.map_.parameters or tuple(given.values))[0]
    return SystemState(path=path, values=tuple(given.values.items()), x=given.start, over=over)


def from_query(path: str, query: str) -> SystemState:
    """The state of a link; ValueError names what is wrong with it."""
    texts, own = SystemState.parts_of(query)
    values = {name: number(PREFIX + name, text) for name, text in texts.items()}
    return replace(first_state(path).at(values), **own)
