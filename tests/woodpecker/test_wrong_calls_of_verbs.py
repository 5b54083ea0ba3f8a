"""Verbs that are called wrongly: one sentence that names the value and what was expected."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
import sympy
from maps import fold

import pwmap.plot
import woodpecker
import woodpecker.plot.orbits
import woodpecker.systems
from pwmap import Diagram
from woodpecker import PeriodicOrbit, Settings, Toy, ToyPieces, continuation, from_sympy, shoot
from woodpecker.systems import Contact, ContactSystem, Section, SystemMap

X, P, Y, V, G, EPS = sympy.symbols("x p y u_y g eps")
LINES = from_sympy(sympy.Piecewise((X / 2 + P, X < 0), (X / 3 + P - 1, True)), X, P)
FOLD = fold()
TOY, SPAN, PAIR = Toy(), (0.4, 0.5), (0, 1)
TWO = np.array([-0.5, -0.6])
HUGE = 10**400  # more than a double holds
LONG = "a" * 500
BALL = SystemMap(
    ContactSystem([Y], [[1]], [-G], [Contact(name="floor", gap=Y, eps_n=EPS)], {G: 10.0, EPS: 0.5}),
    Section(when="floor", free=[V]),
    ["eps"],
)
README = Path(__file__).parents[2] / "README.md"


@cache
def motion() -> PeriodicOrbit:
    """The stable one of the toy."""
    return shoot(TOY, -0.53)


@cache
def cycle() -> PeriodicOrbit:
    """That of the two lines at p = -1/2."""
    return shoot(LINES, -1.0, p=-0.5)


@cache
def found() -> Diagram:
    return continuation(LINES, cycle(), settings=Settings(span=(-1, 0), window=(-3, 3)))


ROOMS = (
    woodpecker, woodpecker.maps, woodpecker.mechanics, woodpecker.simulation, woodpecker.slices,
    woodpecker.robustness, pwmap.plot,
)  # fmt: skip
NAMES = {name: getattr(room, name) for room in ROOMS for name in room.__all__}
NAMES |= {"plot_orbits": woodpecker.plot.orbits.plot_orbits} | globals()

NO_TOYS = ("None", "'toy'", "0.5", "[TOY]", "Toy", "np.zeros(3)", "HUGE")
OF_A_TOY = (
    "equilibrium({})", "jam_limit({})", "free_frequency({})", "ToyPieces({})",
    "first_return({}, -0.5)", "simulate({}, -0.5, 0.1)", "energy({}, np.zeros(3), np.zeros(3))",
    "State.on_section({}, -0.5)",
)  # fmt: skip
OF_A_TOY_OR_MAP = (
    "return_map({}, [-0.5])", "shoot({}, -0.5)", "orbit_diagram({}, [0.5], [-0.5], (-1.0, 0.0))",
    "continuation({}, motion())", "bifurcation_diagram({}, 'eps_n1', SPAN)",
)  # fmt: skip

OF_SETTINGS = (
    "shoot(TOY, -0.5, settings={})", "continuation(TOY, motion(), settings={})",
    "continuation(LINES, cycle(), settings={})", "bifurcation_diagram(LINES, settings={})",
    "orbit_diagram(LINES, [0.5], [0.2], (-3, 3), settings={})", "slices_at(LINES, 0.5, (1,), {})",
    "borders_in(LINES, 0.5, (-1, 1), {})", "local_model(LINES, 0.0, 0.0, settings={})",
    "smallest_changes(TOY, cycle(), settings={})",
)  # fmt: skip
OF_AN_ORDER = (
    "first_return(TOY, -0.5, {})", "return_map(TOY, [-0.5], {})", "shoot(TOY, -0.53, {})",
    "Iterate(ToyPieces(TOY), {})",
)  # fmt: skip

WRONG_KIND = {
    "shoot(TOY, -0.5, settings=None)": "settings must be woodpecker.Settings, got None",
    "shoot(LINES, -1.0, mu=0.3)": "shoot takes source, guess, order, and by name p, settings, got",
    "shoot(TOY, -0.53, mu_2=0.3)": "got mu_2=0.3; a toy has its own values, toy.replace(...) other",
    "shoot(LINES, -1.0, 1, -0.5)": "by name p, settings, got -0.5 by place",
    "shoot(TOY)": "missing a required argument: 'guess'",
    "shoot(TOY, -0.53, guess=-0.5)": "multiple values for argument 'guess'",
    "shoot(BALL, 1.0, p=0.5)": "source must be a map of the line, got SystemMap of 1 coordinate: ",
    "bifurcation_diagram(BALL, 'eps', SPAN, window=(0, 2))": "woodpecker.systems has this verb",
    "return_map(BALL, [1.0], p=0.5)": "got SystemMap of 1 coordinate",
    "return_map(TOY, phi_s=[-0.5])": "got phi_s=[-0.5]",
    "return_map(TOY, [-0.5], executor=3)": "executor must have a method map, got 3",
    "continuation(-0.5, TOY, 'eps_n1', SPAN)": "orbit must be a periodic solution, found by shoot,",
    "continuation(TOY, -0.53, 'eps_n1', SPAN)": "orbit must be a periodic solution, found by shoot",
    "continuation(TOY, None, order=2)": "continuation takes source, orbit, parameter, span, and",
    "continuation(TOY, None, eps_n1=SPAN)": "got eps_n1=(0.4, 0.5); a parameter is named and span ",
    "continuation(TOY, motion(), 'eps_n4')": "unknown parameter 'eps_n4'",
    "continuation(TOY, motion(), stop=3)": "stop must be a function of a state on a branch, got 3",
    "continuation(TOY, 'PD1', ('eps_n1', 'mu_2'), (PAIR, PAIR))": "found by diagram.point('PD1')",
    "bifurcation_diagram(TOY, progress=3)": "progress must be a function, got 3",
    "bifurcation_diagram(TOY, 'eps_n1', SPAN, executor=2)": "executor must have a method submit, g",
    "bifurcation_diagram(TOY, mu_2=SPAN)": "bifurcation_diagram takes",
    "bifurcation_diagram(TOY, 'eps_n1', SPAN, search=3)": "search must be woodpecker.Search, got 3",
    "bifurcation_diagram(LINES, PAIR)": "parameter must be what its axis is called, got (0, 1)",
    "orbit_diagram(TOY, [0.5], [-0.5], SPAN, order=2)": "got order=2; what",
    "simulate(TOY, -0.5, 0.1, dt=0.001)": "got dt=0.001; a toy has its own values",
    "first_return(TOY, -0.5, mu_2=0.3)": "got mu_2=0.3; a toy has its own values",
    "curve_in_two(TOY, 'A', ('eps_n1', 'mu_2'), (SPAN, SPAN))": "point must be one of a diagram or",
    "curve_in_two(LINES, 'LP1', ('a', 'b'), (PAIR, PAIR))": "expected a toy, an exact map of two p",
    "Toy(mu=0.3)": "Toy takes by name m_m, ",
    "Toy(0.3)": "got 0.3 by place",
    "TOY.replace(mass=1.0)": "unknown parameter 'mass', expected one of m_m",
    "ToyPieces(TOY, [1])": "unknown parameter [1], expected one of",
    "Settings(steps=1)": "Settings takes by name span, ",
    "State(phi=1)": "State takes by name phi_m, ",
    "unexplained(1, 2, LINES)": "orbits must be woodpecker",
    "smallest_changes(TOY, 'x')": "orbit must be woodpecker.PeriodicOrbit",
    "smallest_changes('x', cycle())": "toy must be woodpecker",
    "smallest_changes(TOY, motion(), 'mu_2')": "names must be a list of parameters, got 'mu_2'",
    "plot_orbits('x')": "found must be woodpecker.OrbitDiagram, got 'x'",
    "ToyPieces(TOY, 'eps')": "unknown parameter 'eps', expected one of m_m, j_m",
    "energy_balance(TOY)": "trajectory must be woodpecker.Trajectory, got",
    "solutions(TOY, 3, 0.5)": "diagram must be pwmap.Diagram, got 3",
    **{call.format(value): "toy must be woodpecker.Toy, got "
       for call in OF_A_TOY for value in NO_TOYS},
    **{call.format(value): "source must be woodpecker.Toy or a map of pieces"
       for call in OF_A_TOY_OR_MAP for value in NO_TOYS},
    **{call.format(value): "settings must be woodpecker.Settings, got "
       for call in OF_SETTINGS for value in ("PAIR", "Search()")},
}  # fmt: skip
WRONG_VALUE = {
    "first_return(TOY, TWO)": "phi_s must be one real number, got array",
    "first_return(TOY, -0.5 + 0j)": "phi_s must be one real number, got",
    "first_return(TOY, 'far')": "phi_s must be one real number, got 'far'",
    "first_return(TOY, HUGE)": "phi_s must be below 1.8e308, got about 1e+400",
    "first_return(TOY, np.nan)": "phi_s must be finite and below 0.12",
    "first_return(TOY, 0.12 + 1e-15)": "phi_s must be finite and below 0.12",
    "return_map(TOY, np.inf)": "phi_s must be finite and below 0.12",
    "return_map(TOY, [-0.5, 0.12 + 1e-15])": "phi_s must be finite and below 0.12",
    "return_map(TOY, TWO + 0j)": "phi_s must be real numbers, got array",
    "return_map(TOY, ['-0.5'])": "phi_s must be real numbers, got",
    "first_return(TOY, -0.5, 10**9)": "most 100000, got 1000000000",
    "first_return(TOY, -0.5, HUGE)": "about 1e+400",
    "return_map(LINES, [-0.5])": "p is needed",
    "shoot(TOY, TWO + 0j)": "guess must be real numbers, got array",
    "shoot(TOY, TWO, 3)": "guess must have one point or 3, as order says, got array",
    "shoot(TOY, -0.5, 10**4)": "most 1000, got",
    "shoot(TOY, np.nan)": "phi_s must be finite and below 0.12",
    "shoot(TOY, 0.2)": "where the beak touches the pole, got 0.2",
    "shoot(TOY, -0.5, p=0.5)": "a toy has its own values: toy.replace(eps_n1=0.5)",
    "shoot(LINES, -0.5)": "p is needed: a map has no value of its parameter",
    "shoot(LINES, np.nan, p=0.5)": "guess must be finite, got nan",
    "shoot(LINES, -0.5, p=np.inf)": "p must be finite, got inf",
    "simulate(TOY, TWO, 0.1)": "phi_s must be one real number, got array",
    "simulate(TOY, State(phi_m=0.0, phi_s=np.nan), 1.0)": "a state must be finite",
    "simulate(TOY, -0.5, 0.0)": "t_end must be positive and finite, got 0.0",
    "simulate(TOY, -0.5, np.inf)": "t_end must be positive and finite, got inf",
    "simulate(TOY, -0.5, 0.1j)": "t_end must be one real number, got 0.1j",
    "simulate(TOY, -0.5, 0.1, samples=-5)": "samples must be a whole number of at least 2",
    "simulate(TOY, -0.5, 0.1, samples=1.5)": "samples must be a whole number of at least 2",
    "simulate(TOY, -0.5, 0.1, samples=10**9)": "most 1000000",
    "simulate(TOY, -0.5, 0.1, max_events=0)": "max_events must be a whole number",
    "simulate(TOY, -0.5, 0.1, max_events=10**9)": "most 1000000",
    "simulate(TOY, -0.5, 0.1).at(0.05 + 0j)": "t must be real numbers",
    "simulate(TOY, -0.5, 0.1).at(-1e-9)": "t must lie in [0, 0.1]",
    "simulate(TOY, -0.5, 0.1).at(0.1 + 1e-9)": "t must lie in [0, 0.1]",
    "simulate(TOY, -0.5, 0.1).at(np.nan)": "t must lie in [0, 0.1]",
    "continuation(TOY, motion(), span=(0.6, 1.0))": "span must hold eps_n1 = 0.5 of the toy, got",
    "continuation(TOY, motion(), span=(0.0, 0.4))": "span must hold eps_n1 = 0.5 of the toy, got",
    "continuation(TOY, motion(), span=(1.0, 0.0))": "span must ascend, got (1.0, 0.0)",
    "continuation(TOY, motion(), span=(0.0, np.inf))": "span must be finite, got (0.0, inf)",
    "continuation(TOY, motion(), span=(0.4, 0.5, 0.6))": "span must be two real numbers, got (0.4,",
    "continuation(TOY, motion(), settings=Settings(window=(-1.0, -0.8)))": "window must hold the o",
    "continuation(TOY, motion(), resume=True)": "resuming needs the file of a run",
    "continuation(TOY, shoot(TOY, -0.05))": "needs a periodic solution, got one with: a start on",
    "continuation(TOY, shoot(TOY, -0.23))": "needs a periodic solution",
    "continuation(Toy(eps_n1=0.6), motion(), span=(0.58, 0.62))": "got one of another toy",
    "continuation(FOLD, shoot(FOLD, 0.5, p=-0.1))": "continuation needs a periodic solution",
    "continuation(FOLD, cycle(), span=(-1, 1))": "needs an orbit of this map, got one of another",
    "continuation(LINES, cycle(), span=(0, 1))": "span must hold p = -0.5, got",
    "bifurcation_diagram(LINES)": "needs a finite window",
    "orbit_diagram(LINES, [0.5, np.nan], [0.2], (-3, 3))": "parameters must be finite, got ",
    "orbit_diagram(LINES, [0.5], [np.inf], (-3, 3))": "starts must be finite, got [inf]",
    "bifurcation_diagram(TOY, 'eps_n1', SPAN, 3)": "orders must be whole numbers such as (1, 2), g",
    "bifurcation_diagram(TOY, 'eps_n1', SPAN, bytearray(b'1'))": "orders must be whole numbers",
    "local_model(LINES, 0.0, 0.0, orders=b'1')": "must be an integer j >= 1, got b'1'",
    "bifurcation_diagram(TOY, 'eps_n1', (0.4, 0.5, 0.6))": "span must be two real numbers, got (0.",
    "bifurcation_diagram(TOY, 'eps_n1', SPAN, window=(-1, -0.9, -0.8))": "window must be two real ",
    "Toy(m_s=HUGE)": "m_s must be below 1.8e308, got about 1e+400",
    "Toy(expansion_friction=LONG)": "expansion_friction must be",
    "State(phi_m='a', phi_s=0.0)": "phi_m must be one real number, got 'a'",
    "energy(TOY, [0.0, 1.0], [0.0])": "q must be three finite numbers",
    "Search(slices=10**9)": "at most 10000000, got",
    "Search(crowded=1.5)": "at least 1, got 1.5",
    "ToyPieces(TOY).at('a', 0.5)": "x must be one real number, got 'a'",
    "ToyPieces(TOY).at(-0.5, None)": "p must be one real number, got None",
    "ToyPieces(TOY).sweep('a', 0.5)": "x must be real numbers, got 'a'",
    "slices_at(ToyPieces(TOY), 0.5, (0,), Settings(span=(0, 1), window=(-1, -0.24)))": "got 0",
    "slices_at(LINES, np.nan, (1,), Settings(window=(-3, 3)))": "p must be finite, got nan",
    "slices_at(LINES, '0', (1,), Settings(window=(-3, 3)))": "p must be one real number, got '0'",
    "from_sympy(P - X, X, P, words=3)": "words must be 1 names, one for each piece, got 3",
    "observables(TOY, found(), 'height')": "an observable must be one of period, drop, got 'height",
    **{call.format(value): "order must be a whole number of at least 1, got "
       for call in OF_AN_ORDER for value in ("0", "-2", "1.5", "True", "np.True_", "'2'")},
    "check_certificate(README)": "this is no JSON: Expecting value",
}  # fmt: skip
CASES = [
    *((call, TypeError, sentence) for call, sentence in WRONG_KIND.items()),
    *((call, ValueError, sentence) for call, sentence in WRONG_VALUE.items()),
]


@pytest.mark.parametrize(("call", "kind", "sentence"), CASES, ids=[call for call, *_ in CASES])
def test_a_wrong_call_is_answered_in_a_sentence(call: str, kind: type, sentence: str) -> None:
    with pytest.raises(kind) as error:
        eval(call, dict(NAMES))
    assert sentence in str(error.value)
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 500


def test_settings_are_taken_where_they_are_settings() -> None:
    settings = Settings(span=(-1, 0), window=(-3, 3))
    assert len(continuation(LINES, cycle(), settings=settings).branches) == 1
    assert woodpecker.slices.borders_in(ToyPieces(TOY), 0.5, (-0.9, -0.8)) is not None
