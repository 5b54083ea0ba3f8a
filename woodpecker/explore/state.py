"""The state of a page of the toy, and its link in the address bar."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from pwmap import Branch, BranchKind
from pwmap.explore.link import LinkedState, as_text, number, numbers, one_of
from woodpecker import Toy, parameters
from woodpecker.mechanics.toy import LAW, RESTITUTIONS, known_parameter
from woodpecker.plot.motions import PORTRAITS

GUESS = -0.53  # rad: near the stable motion of the paper's data
WINDOW = (-2.5, 0.11)  # rad, of the map [Leine2001, Fig. 8]
ORDERS = (1, 2, 3, 4)
STEPS = (1, 200)  # of a cobweb
VIEWS = ("", "map", "diagram", "motion", "portrait", "toy", "word", "graph")
TOUR_STEPS = 10
TOY = Toy()


@dataclass(frozen=True, slots=True, kw_only=True)
class PageState(LinkedState):
    """The state of a page of the toy."""

    SHORT: ClassVar[Mapping[str, str]] = {"order": "j"}
    BESIDE: ClassVar[tuple[str, ...]] = ("toy",)

    toy: Toy = TOY  # all of its parameters in SI units
    phi_s: float = GUESS  # start on the section [rad], on a periodic motion or anywhere
    periodic: bool = True  # the start follows a periodic motion when parameters change
    order: int = 1  # number of returns j of the map P_j and of the motion
    steps: int = 20  # of the cobweb
    window: tuple[float, float] = WINDOW  # interval of phi_S of the map [rad]
    over: str = "eps_n1"  # parameter of the diagram
    span: tuple[float, float] = (0.0, 1.0)
    every: tuple[int, ...] = ()  # iterates to find all branches of; if empty the motion is followed
    orbits: bool = False  # whether an orbit diagram lies under the diagram
    portrait: str = "phi_s"  # ``phi_s``, ``phi_m`` or ``fall``
    tour: int = 0  # step of the guided tour, 0 for none
    focus: str = ""  # the view that is shown large, none if empty

    def __post_init__(self) -> None:
        known_parameter(self.over)
        one_of("order", self.order, ORDERS)
        one_of("portrait", self.portrait, tuple(PORTRAITS))
        one_of("focus", self.focus, VIEWS)
        if not 0 <= self.tour <= TOUR_STEPS:
            raise ValueError(f"the tour has steps 1 to {TOUR_STEPS}, got {self.tour}")
        if not set(self.every) <= {1, 2}:
            raise ValueError(f"every branch is looked for of P_1 and P_2, got {self.every}")
        if not STEPS[0] <= self.steps <= STEPS[1]:
            raise ValueError(f"steps must lie in {STEPS}, got {self.steps}")
        for name in ("window", "span"):
            low, high = getattr(self, name)
            if not -math.inf < low < high < math.inf:
                raise ValueError(f"{name} must be finite and ascend, got ({low}, {high})")
        if not math.isfinite(self.phi_s):
            raise ValueError(f"phi_s must be finite, got {self.phi_s}")

    @property
    def value(self) -> float:
        found: float = getattr(self.toy, self.over)
        return found

    def starts(self, count: int) -> npt.NDArray[np.float64]:
        """Evenly spaced starts of the map in its window, [rad]."""
        low, high = self.window
        return np.linspace(low, min(high, self.toy.phi_s_max - 1e-6), count)

    @property
    def place(self) -> dict[str, float]:
        """Values of the toy's parameters; 0 stands for an infinite pole."""
        values = {name: getattr(self.toy, name) for name in parameters()}
        return {name: value if math.isfinite(value) else 0.0 for name, value in values.items()}

    def at(self, values: Mapping[str, Any]) -> PageState:
        """The state with other parameters of the toy; a pole of 0 means an infinite one."""
        changes = numbers(values, parameters())
        if changes.get("pole") == 0.0:
            changes["pole"] = math.inf
        return replace(self, toy=self.toy.replace(**changes))

    def at_sample(self, branch: Branch, sample: int) -> PageState:
        value, x = float(branch.parameter[sample]), float(branch.x[sample])
        return replace(
            self, toy=self.toy.replace(**{self.over: value}), phi_s=x,
            order=branch.order if branch.order in ORDERS else self.order,
            periodic=branch.kind is BranchKind.FIXED_POINT,
        )  # fmt: skip

    def with_axis(self, name: str) -> PageState:
        return replace(self, over=name, span=usual_span(self.toy, name))

    @classmethod
    def is_parameter(cls, key: str) -> bool:
        return key in (*parameters(), "law")

    def query(self) -> str:
        values = {name: getattr(self.toy, name) for name in (*parameters(), LAW)}
        changed = {name: v for name, v in values.items() if v != getattr(TOY, name)}
        told = [("law" if name == LAW else name, as_text(v)) for name, v in changed.items()]
        return self.link_from(PageState(), told)

    def python(self) -> str:
        toy, low, high = repr(self.toy), *self.window
        begin, guess = ("toy", self.phi_s) if self.order > 1 else (repr(home(self)), GUESS)
        run = "" if self.order == 1 else f", {self.order}"
        motion = [f"start = {self.phi_s!r}  # rad, at rest on the section"]
        if self.periodic:
            motion = [
                f"orbit = shoot(toy, {self.phi_s!r}{run})",
                "start = orbit.phi_s  # rad, on the section",
            ]
        motion += [
            f"once = first_return(toy, start{run})",
            "motion = simulate(toy, start, once.period if once.status.success else 1.0)",
        ]
        curve = [
            f"returns = return_map(toy, np.linspace({low!r}, {high!r}, 1000){run})",
            f"plot_return_map(toy, returns, order={self.order}, depth={low!r})",
        ]
        if self.every:
            diagram = (
                f"diagram = bifurcation_diagram(toy, {self.over!r}, {self.span!r}, {self.every!r})"
            )
            search = "bifurcation_diagram"
        else:
            diagram = (
                f"orbit = shoot({begin}, {guess!r}{run})\n"
                f"diagram = continuation(orbit.toy, orbit, {self.over!r}, {self.span!r})"
            )
            search = "continuation"
        names = {"Toy", "first_return", "return_map", "simulate", "shoot", search}
        if self.every and not self.periodic:
            names -= {"shoot"}
        body = [f"toy = {toy}", *motion, *curve, diagram, "plot_diagram(diagram)"]
        return "\n".join([
            "import numpy as np", "from pwmap.plot import plot_diagram",
            "from woodpecker.plot.figures import plot_return_map",
            f"from woodpecker import {', '.join(sorted(names))}", "", *body, "",
        ])  # fmt: skip


def home(state: PageState) -> Toy:
    """The toy with the paper's value of the diagram's parameter, if that fits the others."""
    # The diagram begins there, so that it does not depend on the slider of its parameter.
    try:
        return state.toy.replace(**{state.over: getattr(TOY, state.over)})
    except ValueError:
        return state.toy


def usual_span(toy: Toy, parameter: str) -> tuple[float, float]:
    """Default interval of a parameter: (0, 1) for restitutions and 0, else 50 % below and above."""
    known_parameter(parameter)
    value: float = getattr(toy, parameter)
    if parameter in RESTITUTIONS or not 0.0 < value < math.inf:
        return 0.0, 1.0
    return 0.5 * value, 1.5 * value


def from_query(query: str) -> PageState:
    """The state that a link encodes; ValueError names an unknown name or an impossible value."""
    values, own = PageState.parts_of(query)
    law = {LAW: values.pop("law")} if "law" in values else {}
    made = TOY.replace(**law, **{name: number(name, text) for name, text in values.items()})
    if "over" in own:
        own.setdefault("span", usual_span(made, own["over"]))
    return PageState(toy=made, **own)
