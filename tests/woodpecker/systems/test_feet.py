"""A body on two feet: they have one slip, stick and slide together, and it may tip."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
import sympy
from needs import NEEDS_HEYOKA

from woodpecker.systems import Contact, ContactSystem, MotionStatus, Section, SystemMap, simulate

BACKENDS = [pytest.param("heyoka", marks=NEEDS_HEYOKA), "scipy"]
X, Y, TURN, V, W_TURN, T = sympy.symbols("x y turn u_x u_turn t")
G = 9.81
Values = Mapping[sympy.Symbol, float]
NONE: Values = {}


def body(
    force: sympy.Expr, height: Any, mu: Any, values: Values = NONE, other_height: Any = None
) -> ContactSystem:
    """One of mass 1 and inertia 0.3 on feet 1 to both sides, its centre at a height above them.

    The height may be written in another way at the front foot.
    """
    heights = height, height if other_height is None else other_height
    feet = [
        Contact(name=name, gap=Y + side * TURN, slip=V + each * W_TURN, mu=mu)
        for name, side, each in zip(("rear foot", "front foot"), (-1, 1), heights, strict=True)
    ]
    return ContactSystem([X, Y, TURN], sympy.diag(1, 1, 0.3), [force, -G, 0], feet, values)


def block(force: sympy.Expr, mu: Any, values: Values = NONE) -> ContactSystem:
    """The same without rotation, on the ground."""
    ground = Contact(name="ground", gap=Y, slip=V, mu=mu)
    return ContactSystem([X, Y], sympy.eye(2), [force, -G], [ground], values)


@pytest.mark.parametrize("backend", BACKENDS)
def test_feet_slide_as_one_contact(backend: str) -> None:
    """They slip where the push is mu g, the friction of both, and move as a block does."""
    push = 5 * sympy.sin(3 * T)
    motion = simulate(body(push, 0.5, 0.3), {}, 6.0, backend=backend)
    other = simulate(block(push, 0.3), {}, 6.0, backend=backend)
    assert motion.status is MotionStatus.TIME_REACHED
    assert motion.word.replace(" ", "") == "".join(
        each + each.replace("1", "2") for each in other.word.split()
    )
    slips = [event.time for event in motion.events if event.symbol == "S1"]
    assert slips[0] == pytest.approx(math.asin(0.3 * G / 5) / 3, abs=1e-14)
    assert motion.z[[0, 3]] == pytest.approx(other.z[[0, 2]], abs=1e-12)


@pytest.mark.parametrize(
    ("height", "other"),
    [(0.3, 3 * sympy.Float(0.1)), (1 + sympy.sqrt(2), sympy.sqrt(3 + 2 * sympy.sqrt(2)))],
)
def test_feet_slide_as_one_contact_however_their_slips_are_written(height: Any, other: Any) -> None:
    push = 5 * sympy.sin(3 * T)
    systems = body(push, height, 0.3), body(push, height, 0.3, other_height=other)
    assert systems[1].contacts[0].slip != systems[1].contacts[1].slip
    motions = [simulate(each, {}, 1.0, backend="scipy") for each in systems]
    assert motions[1].status is MotionStatus.TIME_REACHED
    assert motions[0].word == motions[1].word == "S1 S2"
    assert motions[0].z == pytest.approx(motions[1].z, abs=1e-13)


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_high_body_tips_while_its_feet_stick(backend: str) -> None:
    """A push R t at a height of 2 lifts the rear foot where its moment is that of the weight."""
    rate = 4.0
    motion = simulate(body(rate * T, 2.0, 0.6), {}, 1.5, backend=backend)
    assert motion.word.split()[0] == "D1"
    assert motion.events[0].time == pytest.approx(G / (2.0 * rate), abs=1e-14)


@pytest.mark.slow
def test_feet_have_derivatives() -> None:
    """The return of the body is that of the block, with its first variations."""
    force, mu = sympy.symbols("force mu")
    images, push, values = [], force * sympy.sin(3 * T), {force: 5.0, mu: 0.3}
    for system in (body(push, 0.5, mu, values), block(push, mu, values)):
        section = Section(when=sympy.sin(3 * T), free=[V], at={T: 0})
        map_ = SystemMap(system, section, ["force", "mu"])
        images.append(map_.at(np.array([0.4]), map_.p))
    assert images[0].value == pytest.approx(images[1].value, abs=1e-12)
    assert images[0].jacobian == pytest.approx(images[1].jacobian, abs=1e-10)
