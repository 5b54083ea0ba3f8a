"""Arguments that make no sense: one sentence that names the value and what was expected."""

from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from sympy import symbols

import woodpecker
from woodpecker import Search, State, Toy

API: Any = woodpecker  # wrong types are the point here
TOY = Toy()
HUGE = 10**400  # more than a double holds
NO_TOYS: tuple[Any, ...] = (None, "toy", 0.5, [TOY], Toy, np.zeros(3), HUGE)
OF_A_TOY: tuple[Callable[[Any], object], ...] = (
    API.equilibrium,
    API.jam_limit,
    API.mechanics.free_frequency,
    API.ToyPieces,
    lambda toy: API.first_return(toy, -0.5),
    lambda toy: API.simulate(toy, -0.5, 0.1),
    lambda toy: API.mechanics.energy(toy, np.zeros(3), np.zeros(3)),
    lambda toy: State.on_section(toy, -0.5),
)
OF_A_TOY_OR_MAP: tuple[Callable[[Any], object], ...] = (
    lambda source: API.return_map(source, [-0.5]),
    lambda source: API.shoot(source, -0.5),
    lambda source: API.orbit_diagram(source, [0.5], [-0.5], (-1.0, 0.0)),
    lambda source: API.continuation(source, API.shoot(TOY, -0.53)),
    lambda source: API.bifurcation_diagram(source, "eps_n1", (0.4, 0.5)),
)


@pytest.mark.parametrize("call", OF_A_TOY)
def test_what_is_no_toy_is_named(call: Callable[[Any], object]) -> None:
    for value in NO_TOYS:
        with pytest.raises(TypeError, match=r"^toy must be woodpecker\.Toy, got "):
            call(value)


@pytest.mark.parametrize("call", OF_A_TOY_OR_MAP)
def test_what_is_neither_a_toy_nor_a_map_is_named(call: Callable[[Any], object]) -> None:
    for value in NO_TOYS:
        with pytest.raises(TypeError, match=r"^source must be woodpecker\.Toy or a map of pieces"):
            call(value)


SPAN = ("eps_n1", (0.4, 0.5))
NAMED: dict[str, Callable[[], object]] = {
    "m_s must be below 1.8e308, got a whole number of 401 digits": lambda: API.Toy(m_s=HUGE),
    "expansion_friction must be": lambda: API.Toy(expansion_friction="a" * 500),
    "unknown parameter 'mass', expected one of m_m": lambda: TOY.replace(mass=1.0),
    r"unknown parameter \[1\], expected one of": lambda: API.ToyPieces(TOY, [1]),
    "phi_s must be below 1.8e308, got a whole": lambda: API.first_return(TOY, HUGE),
    "order must be .* most 100000, got 1000000000": lambda: API.first_return(TOY, -0.5, 10**9),
    "order must be .* whole number of 401 digits": lambda: API.first_return(TOY, -0.5, HUGE),
    "executor must have .* map, got 3": lambda: API.return_map(TOY, [-0.5], executor=3),
    "order must be .* most 1000, got": lambda: API.shoot(TOY, -0.5, 10**4),
    r"settings must be .*\.Settings, got": lambda: API.shoot(TOY, -0.5, settings=None),
    "samples must be .* most 1000000": lambda: API.simulate(TOY, -0.5, 0.1, samples=10**9),
    "max_events must be .* most 1000000": lambda: API.simulate(TOY, -0.5, 0.1, max_events=10**9),
    "phi_m must be one real number, got 'a'": lambda: API.State(phi_m="a", phi_s=0.0),
    "q must be three finite numbers": lambda: API.mechanics.energy(TOY, [0.0, 1.0], [0.0]),
    r"trajectory must be woodpecker\.Trajectory, got": lambda: API.simulation.energy_balance(TOY),
    "slices must be .* at most 10000000, got": lambda: Search(slices=10**9),
    "crowded must be .* at least 1, got 1.5": lambda: API.Search(crowded=1.5),
    "x must be one real number, got 'a'": lambda: API.ToyPieces(TOY).at("a", 0.5),
    "p must be one real number, got None": lambda: API.ToyPieces(TOY).at(-0.5, None),
    "x must be real numbers, got 'a'": lambda: API.ToyPieces(TOY).sweep("a", 0.5),
    r"diagram must be pwmap\.Diagram, got 3": lambda: API.solutions(TOY, 3, 0.5),
    "orders must be whole .* got 3": lambda: API.bifurcation_diagram(TOY, *SPAN, 3),
    "search must be .* got 3": lambda: API.bifurcation_diagram(TOY, *SPAN, search=3),
}


@pytest.mark.parametrize("sentence", NAMED)
def test_what_is_out_of_reach_is_named(sentence: str) -> None:
    with pytest.raises((ValueError, TypeError), match=sentence) as error:
        NAMED[sentence]()
    assert len(str(error.value)) < 300


def test_numbers_of_any_kind_are_numbers() -> None:
    """The kernel is compiled for floats alone, and sees no other."""
    expected = API.first_return(TOY, -0.5).phi_s
    for start in (np.float64(-0.5), np.array(-0.5), Fraction(-1, 2), Decimal("-0.5")):
        assert API.first_return(TOY, start).phi_s == expected
        # found once more along its path
        assert API.ToyPieces(TOY).at(start, Fraction(1, 2)).value == pytest.approx(
            expected, rel=1e-14
        )


def test_slices_need_iterates() -> None:
    settings = API.Settings(span=(0, 1), window=(-1, -0.24))
    with pytest.raises(ValueError, match="orders must be a whole number of at least 1, got 0"):
        API.slices_at(API.ToyPieces(TOY), 0.5, (0,), settings)


def test_words_are_names() -> None:
    x, p = symbols("x p")
    with pytest.raises(ValueError, match="words must be 1 names, one for each piece, got 3"):
        API.from_sympy(p - x, x, p, words=3)
