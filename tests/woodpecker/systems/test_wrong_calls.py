"""Calls of the verbs of systems that do not fit: a sentence that names the value."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from sympy import symbols

from woodpecker.systems import Contact, ContactSystem, Section, SystemMap, continuation, shoot
from woodpecker.systems.diagrams import orbit_diagram

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


def test_a_map_needs_a_section() -> None:
    with pytest.raises(TypeError, match="section must be"):
        SystemMap(BALL, None)  # type: ignore[arg-type]
