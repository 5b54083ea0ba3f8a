"""Calls that do not fit a verb: one sentence with what it takes and what it got."""

import inspect
import pickle
from collections.abc import Callable
from typing import Any

import pytest
import sympy

import woodpecker
from pwmap.algebra.arguments import explained
from woodpecker.systems import Contact, ContactSystem, Section, SystemMap

API: Any = woodpecker  # wrong calls are the point here
X, P, Y, V, G, EPS = sympy.symbols("x p y u_y g eps")
LINES = API.from_sympy(sympy.Piecewise((X / 2 + P, X < 0), (X / 3 + P - 1, True)), X, P)
TOY, SPAN = API.Toy(), (0.4, 0.5)
BALL = SystemMap(
    ContactSystem([Y], [[1]], [-G], [Contact(name="floor", gap=Y, eps_n=EPS)], {G: 10.0, EPS: 0.5}),
    Section(when="floor", free=[V]),
    ["eps"],
)
OWN = r"; a toy has its own values, toy\.replace\(\.\.\.\) others"

MISUSED: dict[str, tuple[Callable[[], object], str]] = {
    "shoot mu": (lambda: API.shoot(LINES, -1.0, mu=0.3),
                 "^shoot takes source, guess, order, and by name p, settings, got mu=0.3" + OWN),
    "shoot of a toy": (lambda: API.shoot(TOY, -0.53, mu_2=0.3), "got mu_2=0.3" + OWN),
    "shoot swapped": (lambda: API.shoot(-0.53, TOY), "^source must be .*Toy or a map .*got -0.53"),
    "shoot by place": (lambda: API.shoot(LINES, -1.0, 1, -0.5),
                       "^shoot takes .*by name p, settings, got -0.5 by place$"),
    "shoot nothing": (lambda: API.shoot(TOY),
                      "^shoot takes source, guess.*: missing a required argument: 'guess'$"),
    "twice": (lambda: API.shoot(TOY, -0.53, guess=-0.5), "multiple values for argument 'guess'$"),
    "map of a system": (lambda: API.shoot(BALL, 1.0, p=0.5),
                        "^source must be a map of the line, got SystemMap of 1 coordinate: "),
    "searched system": (lambda: API.bifurcation_diagram(BALL, "eps", SPAN, window=(0, 2)),
                        "got SystemMap of 1 coordinate: woodpecker.systems has this verb"),
    "returns of a system": (lambda: API.return_map(BALL, [1.0], p=0.5), "got SystemMap of 1 coord"),
    "mapped": (lambda: API.return_map(TOY, phi_s=[-0.5]), r"^return_map takes .*phi_s=\[-0.5\]"),
    "followed swapped": (lambda: API.continuation(-0.5, TOY, "eps_n1", SPAN),
                         r"^orbit must be a periodic solution, found by shoot, .*got Toy\(\)"),
    "followed guess": (lambda: API.continuation(TOY, -0.53, "eps_n1", SPAN), "^orbit .*got -0.53"),
    "followed order": (lambda: API.continuation(TOY, None, order=2),
                       "^continuation takes source, orbit, parameter, span, and .* got order=2; a"),
    "followed value": (lambda: API.continuation(TOY, None, eps_n1=SPAN), r"eps_n1=\(0.4, 0.5\); a"),
    "progress": (lambda: API.bifurcation_diagram(TOY, progress=3), "^progress must be a function,"),
    "executor": (lambda: API.bifurcation_diagram(TOY, "eps_n1", SPAN, executor=2),
                 "^executor must have a method submit, got 2"),
    "searched": (lambda: API.bifurcation_diagram(TOY, mu_2=SPAN), "^bifurcation_diagram takes"),
    "orbits": (lambda: API.orbit_diagram(TOY, [0.5], [-0.5], SPAN, order=2), "got order=2; what"),
    "simulated": (lambda: API.simulate(TOY, -0.5, 0.1, dt=0.001), "got dt=0.001" + OWN),
    "returned": (lambda: API.first_return(TOY, -0.5, mu_2=0.3), "got mu_2=0.3" + OWN),
    "returned swapped": (lambda: API.first_return(-0.5, TOY), "^toy must be .*Toy, got -0.5"),
    "point": (lambda: API.curve_in_two(TOY, "A", ("eps_n1", "mu_2"), (SPAN, SPAN)),
              "^point must be one of a diagram or of a curve, got 'A'"),
    "toy": (lambda: API.Toy(mu=0.3), "^Toy takes by name m_m, .*, expansion_friction, got mu=0.3$"),
    "toy by place": (lambda: API.Toy(0.3), "^Toy takes by name m_m, .*, got 0.3 by place$"),
    "settings": (lambda: API.Settings(steps=1), "^Settings takes by name span, .*, got steps=1$"),
    "state": (lambda: API.State(phi=1), "^State takes by name phi_m, .*, got phi=1$"),
}  # fmt: skip


@pytest.mark.parametrize("name", MISUSED)
def test_a_call_that_does_not_fit_is_explained(name: str) -> None:
    call, sentence = MISUSED[name]
    with pytest.raises(TypeError, match=sentence):
        call()


@explained("as it is")
def _sum(values: list[float]) -> float:
    return float(sum(values))


def test_an_error_from_within_is_left_as_it_is() -> None:
    wrong: Any = 3
    with pytest.raises(TypeError, match=r"^'int' object is not iterable$"):
        _sum(wrong)


def test_verbs_and_data_stay_what_they_are() -> None:
    assert _sum([1.0, 2.0]) == 3.0
    assert list(inspect.signature(API.shoot).parameters)[:3] == ["source", "guess", "order"]
    assert "mu_2" in inspect.signature(API.Toy).parameters
    assert pickle.loads(pickle.dumps(API.shoot)) is API.shoot
    assert pickle.loads(pickle.dumps(TOY.replace(mu_2=0.31))) == API.Toy(mu_2=0.31)
