"""A system of contacts from a Python file, and the state of its page."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import lru_cache
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from traceback import extract_tb
from types import ModuleType
from typing import Any
from urllib.parse import parse_qsl, urlencode

from woodpecker.base.checks import interval
from woodpecker.explore.state import ORDERS, QUERY_MOST, STEPS, number, one_of
from woodpecker.systems import SystemMap

NUMBERS_MOST = 64  # parameters or coordinates of a state
VIEWS = ("", "map", "diagram", "motion", "portrait", "word", "graph")


@dataclass(frozen=True, slots=True, eq=False)
class Explored:
    """A system as its file gives it."""

    path: str
    map_: SystemMap  # the return map; its system has the values that the page begins with
    start: tuple[float, ...]  # (d,) numbers near a periodic motion
    window: tuple[tuple[float, float], ...]  # (d, 2) ends of its coordinates
    ranges: Mapping[str, tuple[float, float]]  # ends of the slider of each parameter

    @property
    def values(self) -> dict[str, float]:
        """Values of all parameters, by name."""
        return {str(name): float(v) for name, v in self.map_.system.parameters.items()}

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the coordinates of the map."""
        return tuple(map(str, self.map_.section.free))

    def at(self, state: SystemState) -> SystemMap:
        """The return map with the parameters of a state."""
        return self.map_.holding(**dict(state.values))


@lru_cache(maxsize=1)
def explored(path: str) -> Explored:
    """Run a file as a Python module, and read its ``map_``, ``start``, ``window`` and ``ranges``.

    ValueError if the file or one of the first three is missing, or shapes do not fit; TypeError
    if ``map_`` is no :class:`SystemMap`.
    """
    module = _module(path)
    for name in ("map_", "start", "window"):
        if not hasattr(module, name):
            raise ValueError(f"{path} must define {name!r}: it needs map_, start and window")
    map_ = module.map_
    if not isinstance(map_, SystemMap):
        raise TypeError(f"map_ of {path} must be a SystemMap, got {type(map_).__name__}")
    start = tuple(float(each) for each in module.start)
    window = tuple(interval("window", each) for each in module.window)
    if len(start) != map_.d or len(window) != map_.d:
        raise ValueError(
            f"start and window of {path} must have {map_.d} entries, one of each coordinate of the "
            f"map, got {len(start)} and {len(window)}"
        )
    values = {str(name): float(v) for name, v in map_.system.parameters.items()}
    given = dict(getattr(module, "ranges", {}))
    if unknown := sorted(map(str, set(map(str, given)) - set(values))):
        raise ValueError(f"ranges of {path} has {unknown[0]!r}, the system has {', '.join(values)}")
    told = {str(name): interval(f"the range of {name}", each) for name, each in given.items()}
    ranges = {name: told.get(name, _usual(value)) for name, value in values.items()}
    return Explored(path, map_, start, window, ranges)


def _module(path: str) -> ModuleType:
    """The file as a module; ValueError with the line if it raises an error."""
    spec = spec_from_file_location("explored_system", path)
    if not Path(path).is_file() or spec is None or spec.loader is None:
        raise ValueError(f"there is no Python file {path}")
    module = module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        own = [f.lineno for f in extract_tb(error.__traceback__) if f.filename == spec.origin]
        line = error.lineno if isinstance(error, SyntaxError) else own[-1] if own else None
        said = error.msg if isinstance(error, SyntaxError) else error
        raise ValueError(f"line {line} of {path}: {type(error).__name__}: {said}") from error
    return module


def _usual(value: float) -> tuple[float, float]:
    """Half of a value to half more; (0, 1) for zero."""
    low, high = sorted((0.5 * value, 1.5 * value))
    return (low, high) if low < high else (0.0, 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class SystemState:
    """The state that all views of a system share."""

    values: tuple[tuple[str, float], ...]  # of all parameters, by name
    x: tuple[float, ...]  # (d,) the start on the section
    window: tuple[tuple[float, float], ...]  # (d, 2) ends of its coordinates
    parameter: str  # over which the diagram is drawn
    span: tuple[float, float]
    periodic: bool = True  # the start follows a periodic motion when parameters change
    order: int = 1  # returns of the map and of the motion
    steps: int = 20  # of the cobweb
    coordinate: int = 0  # number of the one whose history and portrait are shown
    focus: str = ""  # the view that is shown large, none if empty
    names: tuple[str, ...] = field(default=())

    def __post_init__(self) -> None:
        known = dict(self.values)
        if self.parameter not in known:
            raise ValueError(f"over must be one of {', '.join(known)}, got {self.parameter[:40]!r}")
        one_of("order", self.order, ORDERS)
        one_of("focus", self.focus[:40], VIEWS)
        if not STEPS[0] <= self.steps <= STEPS[1]:
            raise ValueError(f"steps must lie in {STEPS}, got {self.steps}")
        if not all(map(math.isfinite, (*known.values(), *self.x, *self.span))):
            raise ValueError(f"values, start and span must be finite, got {self.x}, {self.span}")
        if not self.span[0] < self.span[1]:
            raise ValueError(f"span must ascend, got {self.span}")
        if not 0 <= self.coordinate < max(1, len(self.names)):
            raise ValueError(f"coordinate must lie below {len(self.names)}, got {self.coordinate}")

    @property
    def value(self) -> float:
        """The value of the diagram's parameter."""
        return dict(self.values)[self.parameter]

    def at(self, values: Mapping[str, float]) -> SystemState:
        """The same with other values of parameters."""
        known = dict(self.values)
        for name in values:
            if name not in known:
                raise ValueError(f"unknown parameter {name[:40]!r}, known are {', '.join(known)}")
        return replace(self, values=tuple({**known, **values}.items()))


def first_state(given: Explored) -> SystemState:
    """The state of an empty link."""
    parameter = (given.map_.parameters or tuple(given.values))[0]
    return SystemState(
        values=tuple(given.values.items()), x=given.start, window=given.window, parameter=parameter,
        span=given.ranges[parameter], names=tuple(map(str, given.map_.system.q)),
    )  # fmt: skip


def over(given: Explored, state: SystemState, parameter: str) -> SystemState:
    """The same with the diagram over another parameter; ValueError if it is unknown."""
    if parameter not in given.ranges:
        raise ValueError(f"unknown parameter {parameter[:40]!r}")
    return replace(state, parameter=parameter, span=given.ranges[parameter])


# --- Links ----------------------------------------------------------------------------------------

_PLAIN = ("periodic", "order", "steps", "coordinate", "focus")


def to_query(given: Explored, state: SystemState) -> str:
    """What differs from the state of an empty link; every number to its last bit."""
    first = first_state(given)
    known = dict(first.values)
    found = [(f"at_{name}", repr(v)) for name, v in state.values if v != known[name]]
    if state.x != first.x:
        found.append(("x", ",".join(map(repr, state.x))))
    if state.parameter != first.parameter:
        found.append(("over", state.parameter))
    for each in fields(SystemState):
        value = getattr(state, each.name)
        if each.name in _PLAIN and value != getattr(first, each.name):
            found.append((each.name, value if isinstance(value, str) else str(int(value))))
    return urlencode(found, safe=",")


def from_query(given: Explored, query: str) -> SystemState:
    """The state of a link; ValueError names what is wrong with it."""
    if len(query) > QUERY_MOST:
        raise ValueError(f"a link has at most {QUERY_MOST} characters, got {len(query)}")
    state, own, values = first_state(given), dict[str, Any](), dict[str, float]()
    for key, text in parse_qsl(query, keep_blank_values=True, max_num_fields=NUMBERS_MOST):
        if key.startswith("at_"):
            values[key[3:]] = number(key, text)
        elif key == "x":
            own["x"] = point(text, len(state.x))
        elif key == "over":
            state = over(given, state, text)
        elif key == "focus":
            own["focus"] = text
        elif key in _PLAIN and text.isdigit() and len(text) < 4:
            own[key] = bool(int(text)) if key == "periodic" else int(text)
        else:
            raise ValueError(f"unknown name or value in the link: {key[:40]!r}")
    return replace(state.at(values), **own)


def point(text: str, d: int) -> tuple[float, ...]:
    """A point of d numbers from text such as ``0.1, -2``; ValueError if it is none."""
    found = tuple(number("start", part) for part in str(text).split(","))
    if len(found) != d:
        raise ValueError(f"a start has {d} numbers, got {str(text)[:40]!r}")
    return found


def python_of(given: Explored, state: SystemState) -> str:
    """The lines of Python that make the same."""
    first = dict(first_state(given).values)
    changed = ", ".join(f"{n}={v!r}" for n, v in state.values if v != first[n])
    return "\n".join([
        "import runpy", "",
        "from woodpecker.systems import SystemMap, continuation, shoot", "",
        f"map_ = runpy.run_path({given.path!r})['map_']",
        f"system = map_.system.replace({changed})",
        f"map_ = SystemMap(system, map_.section, [{state.parameter!r}])",
        f"cycle = shoot(map_, {list(state.x)!r}, order={state.order})",
        "print(cycle.message, cycle.x, cycle.multipliers, cycle.word)",
        f"found = continuation(map_, cycle, {state.span!r}, {state.window!r})",
        "print(found.diagram)", "",
    ])  # fmt: skip
