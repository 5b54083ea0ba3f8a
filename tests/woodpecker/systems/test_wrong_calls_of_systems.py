"""Calls of the verbs of systems that do not fit: a sentence that names the value."""

import math
from collections.abc import Callable

import pytest
from sympy import symbols

from woodpecker import Search, Settings, slices_at
from woodpecker.slices import nearest_border
from woodpecker.systems import (
    Contact,
    ContactSystem,
    Section,
    SystemMap,
    continuation,
    orbit_diagram,
    return_map,
    shoot,
    simulate,
)

Y, G = symbols("y g")
BALL = ContactSystem([Y], [[1]], [-G], [Contact(name="floor", gap=Y, eps_n=0.5)], {G: 10.0})


@pytest.fixture(scope="module")
def bounces() -> SystemMap:
    """From one impact of a ball to the next, over the weight."""
    return SystemMap(BALL, Section(when="floor", free=["u_y"]), ("g",))


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda map_: shoot(map_, [math.nan]), r"guess must be finite, got \[nan\]"),
        (
            lambda map_: orbit_diagram(map_, [10.0], [[1.0]], 3),
            r"window must have shape \(1, 2\), two ends of each coordinate, got 3",
        ),
        (
            lambda map_: continuation(map_, shoot(map_, [0.0]), (5, 20), [(0, 1)], orders=1),
            r"orders must be whole numbers such as \(1, 2\), got 1",
        ),
    ],
)
def test_a_call_that_does_not_fit(
    bounces: SystemMap, call: Callable[[SystemMap], object], sentence: str
) -> None:
    with pytest.raises(ValueError, match=sentence):
        call(bounces)


HELD = r"map_.holding\(...\) has other values of parameters"
OF_A_LINE = "a map of the line is needed, such as .*got SystemMap"


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (
            lambda map_: shoot(map_, [1.0], F=7),
            f"shoot takes map_, guess, and by name order, p, got F=7; {HELD}",
        ),
        (lambda map_: return_map(map_, [1.0], 2), "by name order, p, got 2 by place"),
        (lambda map_: SystemMap(BALL, map_.section, order=2), "SystemMap takes .*got order=2"),
        (
            lambda _: simulate(BALL, {"y": 1.0}, 1.0, g=5.0),
            r"simulate takes .*got g=5.0; system.replace\(...\) has other values",
        ),
        (lambda _: Search(foo=1), "Search takes by name slices, .*got foo=1"),  # type: ignore[call-arg]
        (lambda map_: slices_at(map_, 5.0, (1,), Settings(window=(0, 1))), OF_A_LINE),
        (lambda map_: nearest_border(map_, 1.0, 5.0, 0.1), OF_A_LINE),
    ],
)
def test_a_call_with_what_a_verb_does_not_take(
    bounces: SystemMap, call: Callable[[SystemMap], object], sentence: str
) -> None:
    with pytest.raises(TypeError, match=sentence):
        call(bounces)


def test_a_map_needs_a_section() -> None:
    with pytest.raises(TypeError, match="section must be"):
        SystemMap(BALL, None)  # type: ignore[arg-type]
