"""The state of the page of a piecewise-linear map: a frozen value, to and from a link."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from fractions import Fraction
from functools import lru_cache
from urllib.parse import parse_qsl, urlencode

from pwmap.algebra.parsing import term_of

P1L = "Piecewise((r - 2, x <= 0), (r - a*x, True))"  # [Leine2001, Eq. 14]
LONGEST = 600  # characters of a formula
PARAMETERS = 6  # at most
QUERY_MOST = 4000  # characters of a link
ORDERS = (1, 8)
STEPS = (1, 200)
DIGITS = 12  # of a numerator or denominator
RATIONAL = re.compile(r"[+-]?\d+(/\d+|\.\d+)?")
PLANE_ORDERS = (1, 2, 3)  # of the plane of two parameters


@dataclass(frozen=True, slots=True, kw_only=True)
class MapState:
    """The state that all views of a page share; every number is a rational, as text."""

    map: str = P1L  # a formula in x
    given: str = "a > 1"  # its assumptions, separated by ;
    values: tuple[tuple[str, str], ...] = (("a", "5/4"),)  # others have 1
    order: int = 1  # of the iterate
    steps: int = 20  # of the cobweb
    start: str = "3/10"
    over: str = "r"  # the parameter of the diagram; the first one if empty
    span: tuple[str, str] = ("-1", "4")
    orders: int = 2
    across: tuple[str, str] = ("1", "3")
    along: tuple[str, str] = ("-1", "4")
    plane: tuple[str, ...] = ("a", "r")  # two parameters; none if empty
    focus: str = ""

    def __post_init__(self) -> None:
        if len(self.map) > LONGEST or len(self.given) > LONGEST:
            raise ValueError(f"a formula has at most {LONGEST} characters")
        for name, most in (("order", ORDERS[1]), ("steps", STEPS[1]), ("orders", ORDERS[1])):
            if not 1 <= getattr(self, name) <= most:
                raise ValueError(f"{name} must lie in [1, {most}]")
        for text in (
            self.start,
            *self.span,
            *self.across,
            *self.along,
            *dict(self.values).values(),
        ):
            rational(text)
        for name in ("span", "across", "along"):
            low, high = map(rational, getattr(self, name))
            if not low < high:
                raise ValueError(f"{name} must ascend, got {low}, {high}")
        if self.focus not in ("", "map", "diagram", "graph", "plane", "density", "exact"):
            raise ValueError(f"unknown view {self.focus[:40]!r}")

    @property
    def parameters(self) -> tuple[str, ...]:
        """The names of parameters in the formula; none if it cannot be read."""
        return _parameters(self.map)[:PARAMETERS]

    @property
    def place(self) -> dict[str, str]:
        """A value for each parameter."""
        known = dict(self.values)
        return {name: known.get(name, "1") for name in self.parameters}

    @property
    def all_orders(self) -> tuple[int, ...]:
        """Orders of the diagram, from 1 on."""
        return tuple(range(1, self.orders + 1))

    @property
    def plane_names(self) -> tuple[str, ...]:
        """The two parameters of the plane; none if the map has fewer."""
        names = self.parameters
        found = self.plane if set(self.plane) <= set(names) else names
        return tuple(found[:2]) if len(found) > 1 else ()

    @property
    def axis(self) -> str:
        """The parameter of the diagram; empty if the map has none."""
        names = self.parameters
        return self.over if self.over in names else (names[0] if names else "")

    @property
    def value(self) -> float:
        """The value of the diagram's parameter; nan if the map has none."""
        return float(rational(self.place[self.axis])) if self.axis else math.nan

    def with_axis(self, name: str) -> MapState:
        """The same with the diagram over another parameter, about its value."""
        if name not in self.parameters:
            raise ValueError(f"unknown parameter {name[:40]!r}")
        return replace(self, over=name, span=_about(self.place[name]))

    def at(self, **values: str) -> MapState:
        """The same with other values of parameters."""
        for name, text in values.items():
            if name not in self.parameters:
                raise ValueError(f"unknown parameter {name[:40]!r}")
            rational(text)
        kept = {**dict(self.values), **values}
        return replace(self, values=tuple(sorted(kept.items())))


@lru_cache(maxsize=64)
def _parameters(formula: str) -> tuple[str, ...]:
    try:
        names = term_of(formula).names()
    except (TypeError, ValueError):
        return ()
    return tuple(sorted(names.keys() - {"x"}))


def rational(text: object) -> Fraction:
    """A rational from text such as 5/4 or 1.25; ValueError if it is none, or too long."""
    told = str(text).strip()
    if not RATIONAL.fullmatch(told) or max(map(len, re.findall(r"\d+", told))) > DIGITS:
        raise ValueError(f"expected a rational such as 5/4, got {told[:40]!r}")
    try:
        return Fraction(told)
    except ZeroDivisionError:
        raise ValueError(f"expected a rational such as 5/4, got {told[:40]!r}") from None


def of_map(map_: str, given: str, values: Mapping[str, str]) -> MapState:
    """The state of a map that was typed, with intervals around the values of its parameters."""
    state = MapState(map=map_, given=given, values=tuple(sorted(values.items())))
    if not state.axis:
        return state
    place, names = state.place, state.plane_names or (state.axis, state.axis)
    across, along = (_about(place[name]) for name in names)
    return replace(
        state, over=state.axis, span=_about(place[state.axis]), plane=state.plane_names,
        across=across, along=along,
    )  # fmt: skip


def _about(text: str) -> tuple[str, str]:
    """Whole numbers about a value: from two below to two above, or more."""
    value = rational(text)
    return str(math.floor(value) - 2), str(math.ceil(value) + 2)


def to_query(state: MapState) -> str:
    """The fields that differ from the state of an empty link, as a query."""
    first = typed = MapState()
    if state.map != P1L:
        first = MapState(given="", values=())
        typed = of_map(state.map, state.given, dict(state.values))
    found = [("map", state.map)] if state.map != P1L else []
    for each in fields(MapState)[1:]:
        value = getattr(state, each.name)
        if value == getattr(first if each.name in ("given", "values") else typed, each.name):
            continue
        if each.name == "values":
            found += [(f"at_{name}", text) for name, text in value or state.place.items()]
        else:
            text = ",".join(value) if isinstance(value, tuple) else str(value)
            found.append((each.name, text))
    return urlencode(found, safe=",/")


def from_query(query: str) -> MapState:
    """The state of a link; ValueError names what is wrong with it."""
    if len(query) > QUERY_MOST:
        raise ValueError(f"a link has at most {QUERY_MOST} characters, got {len(query)}")
    own: dict[str, object] = {}
    values: dict[str, str] = {}
    default = MapState()
    names = {each.name for each in fields(MapState)} - {"values"}
    for key, text in parse_qsl(query, keep_blank_values=True, max_num_fields=40):
        if key.startswith("at_"):
            values[key[3:]] = text
        elif key not in names:
            raise ValueError(f"unknown name in the link: {key[:40]!r}")
        elif isinstance(getattr(default, key), tuple):
            own[key] = tuple(part for part in text.split(",") if part)
        elif isinstance(getattr(default, key), int):
            if not text.isdigit():
                raise ValueError(f"{key} must be a whole number, got {text[:40]!r}")
            own[key] = int(text)
        else:
            own[key] = text
    for key in ("span", "across", "along"):
        if key in own and len(own[key]) != 2:  # type: ignore[arg-type]
            raise ValueError(f"{key} must be two rationals")
    if "map" in own:
        own.setdefault("given", "")
    if values or "map" in own:
        own["values"] = tuple(sorted(values.items()))
    begin = MapState()
    if own.get("map", P1L) != P1L:
        begin = of_map(str(own["map"]), str(own["given"]), values)
    return replace(begin, **own)  # type: ignore[arg-type]


def python_of(state: MapState) -> str:
    """The lines of Python that compute and draw the same."""
    given = [part.strip() for part in state.given.split(";") if part.strip()]
    place, axis = state.place, state.axis
    names = ["PiecewiseLinearMap", "dynamics"]
    plots = ["from pwmap.plot import plot_cobweb"]
    lines = [
        f"family = PiecewiseLinearMap.from_sympy({state.map!r}, 'x', {given!r})",
        f"here = family.at({place!r})" if place else "here = family",
        f"iterate = here.iterate({state.order})",
        "print(iterate, iterate.fixed_points(), iterate.jump_crossings(), sep='\\n')",
        f"plot_cobweb(iterate, {state.start!r}, {state.steps})",
    ]
    if axis:
        names += ["bifurcation_diagram", "parameter_cells"]
        plots[0] += ", plot_diagram"
        lines += [
            _held("line", {n: v for n, v in place.items() if n != axis}),
            f"cells = parameter_cells(line, {axis!r}, {state.all_orders!r}, span={state.span!r})",
            f"diagram = bifurcation_diagram(line, {axis!r}, {state.span!r}, {state.all_orders!r})",
            "plot_diagram(diagram)",
        ]
    if pair := state.plane_names:
        names.append("parameter_plane")
        plots.append("from pwmap.plot import plot_plane")
        where = f"{pair[0]!r}, {pair[1]!r}, {state.across!r}, {state.along!r}"
        lines += [
            _held("flat", {n: v for n, v in place.items() if n not in pair}),
            f"plot_plane(parameter_plane(flat, {where}, {PLANE_ORDERS!r}))",
        ]
    lines += ["found = dynamics(here)", "print(found.attractors, found.entropy)", ""]
    return "\n".join([f"from pwmap import {', '.join(sorted(names))}", *plots, "", *lines])


def _held(name: str, values: Mapping[str, str]) -> str:
    return f"{name} = family.at({dict(values)!r})" if values else f"{name} = family"
