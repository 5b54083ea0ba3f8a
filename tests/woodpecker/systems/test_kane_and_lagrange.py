"""Systems of ``sympy.physics.mechanics`` are read, and say what the same system by hand says."""

import pytest
import sympy
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

from woodpecker.systems import Contact, ContactSystem, from_kane, simulate


@pytest.mark.slow
def test_lagrange() -> None:
    """A pendulum that strikes a wall, from its Lagrangian and by hand."""
    phi, (g, eps) = dynamicsymbols("phi"), sympy.symbols("g eps")
    method = LagrangesMethod(phi.diff() ** 2 / 2 + g * sympy.cos(phi), [phi])
    method.form_lagranges_equations()
    wall = Contact(name="wall", gap=sympy.sin(phi) + sympy.Rational(1, 2), eps_n=eps)
    values = {g: 9.81, eps: 0.7}
    read = from_kane(method, [wall], values)
    angle = sympy.Symbol("phi")
    same = Contact(name="wall", gap=sympy.sin(angle) + sympy.Rational(1, 2), eps_n=eps)
    by_hand = ContactSystem([angle], [[1]], [-g * sympy.sin(angle)], [same], values)
    motions = [
        simulate(system, {str(system.q[0]): 1.2}, 4.0, backend="scipy")
        for system in (read, by_hand)
    ]
    assert motions[0].word == motions[1].word
    assert motions[0].word.startswith("I1")
    times = [[event.time for event in motion.events] for motion in motions]
    assert times[0] == pytest.approx(times[1], abs=1e-12)
