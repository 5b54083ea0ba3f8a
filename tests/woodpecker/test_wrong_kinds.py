"""What is of another kind than a function takes: a sentence, no AttributeError from within."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import sympy

import pwmap
import woodpecker
from pwmap.plot import plot_cobweb, plot_diagram, plot_map
from woodpecker import Settings, Toy, ToyPieces, from_sympy, shoot
from woodpecker.plot.orbits import plot_orbits

EXACT: Any = pwmap  # wrong types are the point here
API: Any = woodpecker
DRAW: Any = (plot_diagram, plot_map, plot_cobweb, plot_orbits)
X, P = sympy.symbols("x p")
LINES = from_sympy(sympy.Piecewise((X / 2 + P, X < 0), (X / 3 + P - 1, True)), X, P)
ORBIT = shoot(LINES, -1.0, p=-0.5)
TOY, PAIR = Toy(), (0, 1)
README = Path(__file__).parents[2] / "README.md"

KINDS: dict[str, tuple[Callable[[], object], str]] = {
    "name": (lambda: API.continuation(TOY, "PD1", ("eps_n1", "mu_2"), (PAIR, PAIR)),
             r"the point itself, found by diagram\.point\('PD1'\)"),
    "followed": (lambda: API.continuation(LINES, ORBIT, settings=PAIR), "settings must be"),
    "whole": (lambda: API.bifurcation_diagram(LINES, settings=PAIR), "settings must be"),
    "span as a name": (lambda: API.bifurcation_diagram(LINES, PAIR),
                       r"parameter must be what its axis is called, got \(0, 1\)"),
    "shot": (lambda: API.shoot(lambda x, p: x, 0.0, p=0.0), "source must be"),
    "curve": (lambda: API.curve_in_two(LINES, "LP1", ("a", "b"), (PAIR, PAIR)),
              "expected a toy, an exact map of two parameters or a family"),
    "slices": (lambda: API.slices_at(LINES, 0.5, (1,), PAIR), "settings must be"),
    "borders": (lambda: API.slices.borders_in(LINES, 0.5, (-1, 1), PAIR), "settings must be"),
    "local": (lambda: API.local_model(LINES, 0.0, 0.0, settings=PAIR), "settings must be"),
    "orbits": (lambda: API.orbit_diagram(LINES, [0.5], [0.2], (-3, 3), settings=PAIR),
               "settings must be"),
    "unexplained": (lambda: API.slices.unexplained(1, 2, LINES), "orbits must be woodpecker"),
    "robustness": (lambda: API.robustness.smallest_changes(TOY, "x"),
                   "orbit must be woodpecker.PeriodicOrbit"),
    "robust toy": (lambda: API.robustness.smallest_changes("x", ORBIT), "toy must be woodpecker"),
    "robust names": (lambda: API.robustness.smallest_changes(TOY, shoot(TOY, -0.53), "mu_2"),
                     "names must be a list of parameters, got 'mu_2'"),
    "robust settings": (lambda: API.robustness.smallest_changes(TOY, ORBIT, settings=PAIR),
                        "settings must be woodpecker.Settings"),
    "drawn orbits": (lambda: DRAW[3]("x"), "found must be woodpecker.OrbitDiagram, got 'x'"),
    "drawn diagram": (lambda: DRAW[0]("x"), r"diagram must be pwmap\.Diagram, got 'x'"),
    "drawn map": (lambda: DRAW[1]("x"), "expected a PiecewiseLinearMap"),
    "raster": (
        lambda: EXACT.plane.plane_raster("x"),
        r"plane must be pwmap\.plane\.ParameterPlane, got 'x'",
    ),
    "plane": (lambda: EXACT.parameter_plane("x", "a", "b", PAIR, PAIR), "a PiecewiseLinearMap"),
    "dynamics": (lambda: EXACT.dynamics("x"), "expected a PiecewiseLinearMap"),
    "attractors": (lambda: EXACT.attractor_diagram("x", "a", PAIR), "a PiecewiseLinearMap"),
    "entropy": (lambda: EXACT.constant_entropy("x", "a", PAIR), "a PiecewiseLinearMap"),
    "branches": (lambda: EXACT.bifurcation_diagram("x", "a"), "expected a PiecewiseLinearMap"),
}  # fmt: skip


@pytest.mark.parametrize("name", KINDS)
def test_what_is_of_another_kind_is_named(name: str) -> None:
    call, sentence = KINDS[name]
    with pytest.raises(TypeError, match=sentence):
        call()


def test_settings_are_taken_where_they_are_settings() -> None:
    settings = Settings(span=(-1, 0), window=(-3, 3))
    assert len(API.continuation(LINES, ORBIT, settings=settings).branches) == 1
    assert API.slices.borders_in(ToyPieces(TOY), 0.5, (-0.9, -0.8)) is not None


@pytest.mark.parametrize("api", [EXACT, API], ids=["pwmap", "woodpecker"])
def test_a_page_is_no_certificate(api: Any) -> None:
    with pytest.raises(ValueError, match=r"this is no (certificate: it holds characters|JSON)"):
        api.check_certificate(README)
