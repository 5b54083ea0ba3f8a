"""A section that counts only while a contact sticks, reached just as it begins to."""

import math

import numpy as np
import pytest
import sympy
from scipy.optimize import brentq

from woodpecker.systems import Contact, ContactSystem, Section, SystemMap

X, Y, Z, T, V, W, U, F = sympy.symbols("x y z t v w u F")
START, MU = 2.5, 0.5  # phase of the section; friction over weight


def map_of() -> SystemMap:
    """A block that a force F sin t lets slip twice in a period; beside it y = -cos(t - 2.5)."""
    floor = Contact(name="the floor", gap=Z, slip=V, mu=MU)
    force = [F * sympy.sin(T), -Y, -1]
    system = ContactSystem([X, Y, Z], sympy.eye(3), force, [floor], {F: 0.6}, u=[V, W, U])
    section = Section(when=W, free=[Y], at={T: START}, sticking=["the floor"], horizon=50.0)
    return SystemMap(system, section, ["F"], backend="scipy")


def stops(force: float) -> float:
    """When the second slip of a period ends, less 2 pi: F (cos a - cos t) = mu (t - a)."""
    a = math.asin(MU / force)
    moved = lambda t: force * (math.cos(a) - math.cos(t)) - MU * (t - a)  # noqa: E731
    return float(brentq(moved, math.pi - a, 2.0 * math.pi, xtol=1e-15))


def test_the_border_is_where_the_block_stops_on_the_section() -> None:
    map_ = map_of()
    border = brentq(lambda force: stops(force) - START, 0.51, 0.8, xtol=1e-15)
    y, near = np.array([-1.0]), 1e-7
    image = map_.at(y, np.array([border - near]))
    assert image.piece.word == "S1 J1 S1 J1"
    code = int(image.codes[image.margins.argmin()])
    assert image.piece.cause(code) == "the section is reached before phase 4 begins"
    for force in (border - near, border + near):  # on both sides the margin is the duration
        there = image.piece.at(y, np.array([force]))
        margin = there.margins[there.place(code)]
        # a slip that starts at the edge of its cone is known to the root of rounding
        assert margin == pytest.approx(START - stops(force), abs=1e-10)
        rate = -(stops(force + 1e-4) - stops(force - 1e-4)) / 2e-4
        assert there.gradients[there.place(code)][1] == pytest.approx(rate, rel=1e-6)
    assert map_.at(y, np.array([border + near])).piece.word != image.piece.word
