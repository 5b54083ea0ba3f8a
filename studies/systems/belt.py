"""A stick-slip oscillator on a belt of speed v, with friction that falls with the sliding speed.

    python -m studies.systems.belt [--fast] [--out DIR]

x'' + x = friction + d (x' - v): Coulomb friction of at most f, and another part that falls with the
sliding speed, so that steady sliding is unstable and the mass comes to stick. It begins to slip at
x = f with the speed of the belt, on a spiral y'' - d y' + y = 0 about x = f - d v, until it has
that speed again: its least x is f - d v + v Y, where Y depends on the spiral alone. All motions
that stick leave at the same x, so the multiplier is 0.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import sympy
from matplotlib.figure import Figure

from studies.common.record import Results, command
from studies.common.style import RED, STABLE, canvas, keep
from woodpecker.plot.systems import plot_system_portrait
from woodpecker.systems import Contact, ContactSystem, Section, SystemMap, return_map, simulate

X, Y, V_X, BELT, FRICTION, D = sympy.symbols("x y u_x v f d")
VALUES = {BELT: 0.5, FRICTION: 1.0, D: 0.2}


def system() -> ContactSystem:
    """The oscillator; its weight is 1, and y the gap to the belt."""
    belt = Contact(name="the belt", gap=Y, slip=V_X - BELT, mu=FRICTION)
    force = [-X + D * (V_X - BELT), -1]
    return ContactSystem([X, Y], [[1, 0], [0, 1]], force, [belt], VALUES)


def map_of(*parameters: str, backend: str | None = None) -> SystemMap:
    """From one least x to the next."""
    section = Section(when=V_X, free=[X], horizon=100.0)
    return SystemMap(system(), section, parameters, backend=backend)


def lowest(v: float, f: float, d: float) -> float:
    """The least x of the motion that sticks, in closed form; the spiral starts at (d v, v)."""
    turn = math.sqrt(1.0 - 0.25 * d * d)
    a, b = d, (1.0 - 0.5 * d * d) / turn  # y = v exp(d t/2) (a cos + b sin)(turn t)
    c, s = 0.5 * d * a + turn * b, 0.5 * d * b - turn * a  # y' likewise
    at = math.atan2(-c, s) % math.pi + math.pi  # it turns back first at its largest x
    return f - d * v + v * math.exp(0.5 * d * at / turn) * (a * math.cos(at) + b * math.sin(at))


def main(fast: bool = False, out: Path | None = None) -> Results:
    """The motion and how it changes with the speed of the belt.

    Parameters
    ----------
    fast
        Nothing is left out.
    out
        Folder for ``system_belt.png``.

    Returns
    -------
    dict
        ``lowest``, ``multiplier``, ``by_speed``: largest differences of the least x, of the
        multiplier and of the derivative in the belt's speed from the closed form.
    """
    map_, off = map_of("v"), np.zeros(3)
    for d in (0.1, 0.2, 0.4):
        for v in (0.2, 0.5, 1.0):
            exact, slope = lowest(v, 1.0, d), lowest(1.0, 0.0, d)
            image = map_.holding(d=d).at(np.array([exact]), np.array([v]))
            found = [image.value[0] - exact, image.jacobian[0, 0], image.jacobian[0, 1] - slope]
            off = np.maximum(off, np.abs(found))
    if out is not None:
        keep(draw(map_), out / "system_belt.png")
    return dict(zip(("lowest", "multiplier", "by_speed"), off.tolist(), strict=True))


def draw(map_: SystemMap) -> Figure:
    """The motion, and the least x from other ones."""
    figure, (left, right) = canvas(3.6, columns=2)
    motion = simulate(system(), {"x": 0.95, "u_x": 0.1}, 45.0, samples=4001)
    plot_system_portrait(system(), motion, "x", "u_x", left)
    x = np.linspace(0.05, 0.899, 120)
    right.plot(x, return_map(map_, x).images[:, 0], color=STABLE, label="return map")
    right.plot(x, x, color="#969696", linewidth=0.8)
    exact = lowest(VALUES[BELT], VALUES[FRICTION], VALUES[D])
    right.plot(exact, exact, "o", color=RED, mfc="none", label="closed form")
    right.set(xlabel="least $x$", ylabel="the next one")
    right.legend()
    return figure


if __name__ == "__main__":
    command(main, "system_belt")
