"""The state of the page of a piecewise-linear map: a frozen value, to and from a link."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pwmap.algebra.parsing import term_of
from pwmap.explore.link import PREFIX, LinkedState

if TYPE_CHECKING:
    from pwmap.diagrams.data import Branch

P1L = "Piecewise((r - 2, x <= 0), (r - a*x, True))"  # [Leine2001, Eq. 14]
LONGEST = 600  # characters of a formula
PARAMETERS = 6  # most parameters of a map
FINEST = 500  # largest denominator of a place on a branch, or of one that is clicked on
ORDERS = (1, 8)
STEPS = (1, 200)
DIGITS = 12  # of a numerator or denominator
RATIONAL = re.compile(r"[+-]?\d+(/\d+|\.\d+)?")
PLANE_ORDERS = (1, 2, 3)  # of the plane of two parameters


def rational(text: object) -> Fraction:
    """A rational from text such as 5/4 or 1.25; ValueError if it is none, or too long."""
    told = str(text).strip()
    if not RATIONAL.fullmatch(told) or max(map(len, re.findall(r"\d+", told))) > DIGITS:
        raise ValueError(f"expected a rational such as 5/4, got {told[:40]!r}")
    try:
        return Fraction(told)
    except ZeroDivisionError:
        raise ValueError(f"expected a rational such as 5/4, got {told[:40]!r}") from None


Exact = Annotated[str, lambda text: str(rational(text))]
Interval = tuple[Exact, Exact]


@dataclass(frozen=True, slots=True, kw_only=True)
class MapState(LinkedState):
    """The state of a page of a map; every number is a rational, as text."""

    BESIDE: ClassVar[tuple[str, ...]] = ("values",)

    map: str = P1L  # a formula in x
    given: str = "a > 1"  # its assumptions, separated by ;
    values: tuple[tuple[str, str], ...] = (("a", "5/4"),)  # all other parameters are 1
    order: int = 1  # of the iterate
    steps: int = 20  # of the cobweb
    start: Exact = "3/10"
    over: str = "r"  # the parameter of the diagram; the first one if empty
    span: Interval = ("-1", "4")
    orders: int = 2
    across: Interval = ("1", "3")
    along: Interval = ("-1", "4")
    plane: tuple[str, ...] = ("a", "r")  # two parameters; none if empty
    focus: str = ""

    def __post_init__(self) -> None:
        if len(self.map) > LONGEST or len(self.given) > LONGEST:
            raise ValueError(f"a formula has at most {LONGEST} characters")
        for name, most in (("order", ORDERS[1]), ("steps", STEPS[1]), ("orders", ORDERS[1])):
            if not 1 <= getattr(self, name) <= most:
                raise ValueError(f"{name} must lie in [1, {most}]")
        for text in (self.start, *dict(self.values).values()):
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
        """A rational for each parameter."""
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
        return float(rational(self.place[self.axis])) if self.axis else math.nan

    def with_axis(self, name: str) -> MapState:
        if name not in self.parameters:
            raise ValueError(f"unknown parameter {name[:40]!r}")
        return replace(self, over=name, span=_about(self.place[name]))

    def at(self, values: Mapping[str, Any]) -> MapState:
        """The same with other values of parameters: rationals as text, or numbers of sliders."""
        for name in values:
            if name not in self.parameters:
                raise ValueError(f"unknown parameter {name[:40]!r}")
        kept = {**dict(self.values), **{name: str(_exact(v)) for name, v in dict(values).items()}}
        return replace(self, values=tuple(sorted(kept.items())))

    def at_sample(self, branch: Branch, sample: int) -> MapState:
        value, start = (
            Fraction(float(column[sample])).limit_denominator(FINEST)
            for column in (branch.parameter, branch.x)
        )
        there = replace(self, order=branch.order, start=str(start))
        return there.at({self.axis: str(value)})

    def query(self) -> str:
        first = MapState()
        if self.map != P1L:
            typed = of_map(self.map, self.given, dict(self.values))
            first = replace(typed, map=P1L, given="", values=())
        same = self.values == first.values
        values = () if same else self.values or self.place.items()
        return self.link_from(first, [(PREFIX + name, text) for name, text in values])

    def python(self) -> str:
        given = [part.strip() for part in self.given.split(";") if part.strip()]
        place, axis = self.place, self.axis
        names = ["PiecewiseLinearMap", "dynamics"]
        plots = ["from pwmap.plot import plot_cobweb"]
        lines = [
            f"family = PiecewiseLinearMap.from_sympy({self.map!r}, 'x', {given!r})",
            f"here = family.at({place!r})" if place else "here = family",
            f"iterate = here.iterate({self.order})",
            "print(iterate, iterate.fixed_points(), iterate.jump_crossings(), sep='\\n')",
            f"plot_cobweb(iterate, {self.start!r}, {self.steps})",
        ]
        if axis:
            names += ["bifurcation_diagram", "parameter_cells"]
            plots[0] += ", plot_diagram"
            where = f"line, {axis!r}, {self.span!r}, {self.all_orders!r}"
            lines += [
                _held("line", {n: v for n, v in place.items() if n != axis}),
                f"cells = parameter_cells(line, {axis!r}, {self.all_orders!r}, span={self.span!r})",
                f"diagram = bifurcation_diagram({where})",
                "plot_diagram(diagram)",
            ]
        if pair := self.plane_names:
            names.append("parameter_plane")
            plots.append("from pwmap.plot import plot_plane")
            where = f"{pair[0]!r}, {pair[1]!r}, {self.across!r}, {self.along!r}"
            lines += [
                _held("flat", {n: v for n, v in place.items() if n not in pair}),
                f"plot_plane(parameter_plane(flat, {where}, {PLANE_ORDERS!r}))",
            ]
        lines += ["found = dynamics(here)", "print(found.attractors, found.entropy)", ""]
        return "\n".join([f"from pwmap import {', '.join(sorted(names))}", *plots, "", *lines])


@lru_cache(maxsize=64)
def _parameters(formula: str) -> tuple[str, ...]:
    try:
        names = term_of(formula).names()
    except (TypeError, ValueError):
        return ()
    return tuple(sorted(names.keys() - {"x"}))


def _exact(value: object) -> Fraction:
    """A rational from a field, or from a slider, whose number is rounded to thousandths."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        if not math.isfinite(value) or abs(value) > 1e9:
            raise ValueError(f"expected a rational, got {value!r}")
        return Fraction(round(1000 * value), 1000)
    return rational(value)


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
    """An interval of whole numbers that extends at least two to both sides of a value."""
    value = rational(text)
    return str(math.floor(value) - 2), str(math.ceil(value) + 2)


def from_query(query: str) -> MapState:
    """The state of a link; ValueError names what is wrong with it."""
    values, own = MapState.parts_of(query)
    begin = MapState()
    if "map" in own:
        own.setdefault("given", "")
        if own["map"] != P1L:
            begin = of_map(own["map"], own["given"], values)
    if values or "map" in own:
        own["values"] = tuple(sorted(values.items()))
    return replace(begin, **own)


def _held(name: str, values: Mapping[str, str]) -> str:
    return f"{name} = family.at({dict(values)!r})" if values else f"{name} = family"
