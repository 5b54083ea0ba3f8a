"""The state of a page, to and from the link in the address bar."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from urllib.parse import parse_qsl, urlencode

from woodpecker import Toy, parameters
from woodpecker.mechanics.toy import LAW, known_parameter

GUESS = -0.53  # rad: near the stable motion of the paper's data
WINDOW = (-2.5, 0.11)  # rad, of the map [Leine2001, Fig. 8]
ORDERS = (1, 2, 3, 4)
STEPS = (1, 200)  # of a cobweb
PORTRAITS = {"phi_s": "dphi_s", "phi_m": "dphi_m", "fall": "dy"}  # [Leine2001, Figs. 5, 6]
RESTITUTIONS = ("eps_n1", "eps_n2", "eps_n3")
VIEWS = ("", "map", "diagram", "motion", "portrait", "toy", "word", "graph")
TOUR_STEPS = 10
QUERY_MOST = 4000  # characters of a link
TOY = Toy()


@dataclass(frozen=True, slots=True, kw_only=True)
class PageState:
    """The state that all views of a page share."""

    toy: Toy = TOY  # all of its parameters in SI units
    phi_s: float = GUESS  # start on the section [rad]: a point of a periodic motion, or any
    periodic: bool = True  # the start follows a periodic motion when parameters change
    order: int = 1  # returns j of the map P_j and of the motion
    steps: int = 20  # of the cobweb
    window: tuple[float, float] = WINDOW  # of phi_S of the map [rad]
    parameter: str = "eps_n1"  # over which the diagram is drawn
    span: tuple[float, float] = (0.0, 1.0)
    every: tuple[int, ...] = ()  # iterates with all branches; by default those of the motion
    orbits: bool = False  # the diagram has the orbit diagram under it
    portrait: str = "phi_s"  # ``phi_s``, ``phi_m`` or ``fall``
    tour: int = 0  # step of the guided tour, 0 for none
    focus: str = ""  # the view that is shown large, none if empty

    def __post_init__(self) -> None:
        known_parameter(self.parameter)
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
        """The toy's own value of the parameter of the diagram."""
        found: float = getattr(self.toy, self.parameter)
        return found

    def with_values(self, values: Mapping[str, float]) -> PageState:
        """The same with other parameters of the toy; a pole of 0 means an infinite one."""
        changes = {name: math.inf if name == "pole" and not v else v for name, v in values.items()}
        return replace(self, toy=self.toy.replace(**changes))

    def over(self, parameter: str) -> PageState:
        """The same with the diagram over another parameter."""
        return replace(self, parameter=parameter, span=usual_span(self.toy, parameter))


def home(state: PageState) -> Toy:
    """The toy with the paper's value of the diagram's parameter, if it goes with the others."""
    # A diagram begins there, so that it does not depend on its slider.
    try:
        return state.toy.replace(**{state.parameter: getattr(TOY, state.parameter)})
    except ValueError:
        return state.toy


def usual_span(toy: Toy, parameter: str) -> tuple[float, float]:
    """(0, 1) for a restitution or a value of 0; otherwise half of the value to half more."""
    known_parameter(parameter)
    value: float = getattr(toy, parameter)
    if parameter in RESTITUTIONS or not 0.0 < value < math.inf:
        return 0.0, 1.0
    return 0.5 * value, 1.5 * value


def one_of(name: str, value: object, known: Sequence[object]) -> None:
    """ValueError unless a value is among the known ones."""
    if value not in known:
        raise ValueError(f"{name} must be one of {known}, got {value!r}")


# --- Links ----------------------------------------------------------------------------------------

_SHORT = {"order": "j", "parameter": "over"}  # other fields have their names
_LAW = "law"


def to_query(state: PageState) -> str:
    """What differs from the state of an empty link; every number to its last bit."""
    default = PageState()
    found = [
        (name, repr(getattr(state.toy, name)))
        for name in parameters()
        if getattr(state.toy, name) != getattr(TOY, name)
    ]
    if state.toy.expansion_friction != TOY.expansion_friction:
        found.append((_LAW, str(state.toy.expansion_friction)))
    for each in fields(PageState):
        value = getattr(state, each.name)
        if each.name != "toy" and value != getattr(default, each.name):
            found.append((_SHORT.get(each.name, each.name), _text(value)))
    return urlencode(found, safe=",")


def from_query(query: str) -> PageState:
    """The state of a link; ValueError names an unknown name or an impossible value."""
    if len(query) > QUERY_MOST:
        raise ValueError(f"a link has at most {QUERY_MOST} characters, got {len(query)}")
    toy: dict[str, object] = {}
    own: dict[str, object] = {}
    names = {_SHORT.get(each.name, each.name): each.name for each in fields(PageState)}
    for key, text in parse_qsl(query, keep_blank_values=True, max_num_fields=64):
        if key == _LAW:
            toy[LAW] = text
        elif key in parameters():
            toy[key] = number(key, text)
        elif key in names and key != "toy":
            own[names[key]] = _value(names[key], text)
        else:
            raise ValueError(f"unknown name in the link: {key[:40]!r}")
    made = TOY.replace(**toy)
    if "span" not in own and "parameter" in own:
        own["span"] = usual_span(made, str(own["parameter"]))
    return PageState(toy=made, **own)  # type: ignore[arg-type]


def _text(value: object) -> str:
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, tuple):
        return ",".join(map(repr, value))
    return value if isinstance(value, str) else repr(value)


def number(name: str, text: str) -> float:
    """A number from text; ValueError if it is none."""
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"{name[:40]} must be a number, got {text[:40]!r}") from None


def _value(name: str, text: str) -> object:
    default = getattr(PageState(), name)
    if isinstance(default, str):
        return text
    if isinstance(default, tuple):
        numbers = tuple(number(name, part) for part in text.split(",") if part)
        if name == "every":
            return tuple(map(int, numbers))
        if len(numbers) != 2:
            raise ValueError(f"{name} must be two numbers, got {text[:40]!r}")
        return numbers
    value = number(name, text)
    if isinstance(default, float):
        return value
    if value != int(value if math.isfinite(value) else 0.5):
        raise ValueError(f"{name} must be a whole number, got {text[:40]!r}")
    return bool(value) if isinstance(default, bool) else int(value)


# --- The same in Python ---------------------------------------------------------------------------


def python_of(state: PageState) -> str:
    """The lines that make the map, the motion and the diagram of a state."""
    toy, low, high = repr(state.toy), *state.window
    begin, guess = ("toy", state.phi_s) if state.order > 1 else (repr(home(state)), GUESS)
    run = "" if state.order == 1 else f", {state.order}"
    motion = [f"start = {state.phi_s!r}  # rad, at rest on the section"]
    if state.periodic:
        motion = [
            f"orbit = shoot(toy, {state.phi_s!r}{run})",
            "start = orbit.phi_s  # rad, on the section",
        ]
    motion += [
        f"once = first_return(toy, start{run})",
        "motion = simulate(toy, start, once.period if once.status.success else 1.0)",
    ]
    curve = [
        f"returns = return_map(toy, np.linspace({low!r}, {high!r}, 1000){run})",
        f"plot_return_map(toy, returns, order={state.order}, depth={low!r})",
    ]
    if state.every:
        diagram = (
            f"diagram = bifurcation_diagram(toy, {state.parameter!r}, {state.span!r}, "
            f"{state.every!r})"
        )
        search = "bifurcation_diagram"
    else:
        diagram = (
            f"orbit = shoot({begin}, {guess!r}{run})\n"
            f"diagram = continuation(orbit.toy, orbit, {state.parameter!r}, {state.span!r})"
        )
        search = "continuation"
    names = {"Toy", "first_return", "return_map", "simulate", "shoot", search}
    if state.every and not state.periodic:
        names -= {"shoot"}
    body = [f"toy = {toy}", *motion, *curve, diagram, "plot_diagram(diagram)"]
    return "\n".join([
        "import numpy as np", "from pwmap.plot import plot_diagram",
        "from woodpecker.plot.figures import plot_return_map",
        f"from woodpecker import {', '.join(sorted(names))}", "", *body, "",
    ])  # fmt: skip
