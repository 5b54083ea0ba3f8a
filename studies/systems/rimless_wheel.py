"""A rimless wheel that walks down a slope.

    python -m studies.systems.rimless_wheel [--fast] [--out DIR]

Spokes of length 1 in angles 2 alpha, mass 1 at the hub with inertia j, gravity 1, slope gamma
[McGeer1990, Sec. 3]. At each step the next foot strikes without restitution and sticks, while the
stance foot lifts off: an impact at two contacts of a free body, which no formula here prescribes.
It multiplies the speed omega by eta = (j + cos(2 alpha))/(j + 1), so that omega**2 = 4 eta**2
sin(gamma) sin(alpha)/((1 + j)(1 - eta**2)), with the multiplier eta**2: cos(2 alpha)**2 for j = 0.
On a steep slope the stance foot slips before the next one strikes, and the gait is another one.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from sympy import Expr, cos, sin, symbols

from pwmap import Diagram
from studies.common.record import Results, command
from studies.common.style import GREY, RED, STABLE, canvas, keep
from woodpecker.systems import Contact, ContactSystem, Section, SystemMap, continuation, shoot

X, Y, PHI, V_X, V_Y, OMEGA = symbols("x y phi u_x u_y omega")  # of the hub; of the stance spoke
GAMMA, ALPHA, J, MU = symbols("gamma alpha j mu")
VALUES = {GAMMA: 0.1, ALPHA: math.pi / 8, J: 0.25, MU: 1.0}


def map_of(*parameters: str, backend: str | None = None) -> SystemMap:
    """From step to step: the speed with which the stance foot begins."""
    force, mass = [sin(GAMMA), -cos(GAMMA), 0], [[1, 0, 0], [0, 1, 0], [0, 0, J]]
    feet = [foot("the stance foot", PHI), foot("the next foot", PHI - 2 * ALPHA)]
    wheel = ContactSystem([X, Y, PHI], mass, force, feet, VALUES, u=[V_X, V_Y, OMEGA])
    start = {PHI: -ALPHA, Y: cos(ALPHA), V_X: cos(ALPHA) * OMEGA, V_Y: sin(ALPHA) * OMEGA}
    section = Section(when="the next foot", free=[OMEGA], at=start, horizon=50.0)
    return SystemMap(wheel, section, parameters, backend=backend)


def foot(name: str, angle: Expr) -> Contact:
    """The foot of a spoke in some angle from the normal of the slope."""
    return Contact(name=name, gap=Y - cos(angle), slip=V_X - cos(angle) * OMEGA, mu=MU)


def walking(gamma: float, alpha: float, j: float) -> tuple[float, float]:
    """The speed after each step, and the multiplier."""
    eta = (j + math.cos(2 * alpha)) / (j + 1)
    gain = 4 * math.sin(gamma) * math.sin(alpha) / (1 + j)
    return eta * math.sqrt(gain / (1 - eta**2)), eta**2


def followed() -> Diagram:
    """The walk over the slope."""
    map_ = map_of("gamma")
    return continuation(map_, shoot(map_, [0.4]), (0.06, 0.38), [(0, 2)], orders=(1,)).diagram


def main(fast: bool = False, out: Path | None = None) -> Results:
    """The walk in closed form, and where it begins to slip.

    Parameters
    ----------
    fast
        Nothing is left out.
    out
        Folder for ``system_rimless_wheel.png``.

    Returns
    -------
    dict
        ``speed``, ``multiplier``: largest differences from the closed form; ``slips_from``: the
        slope from which on the stance foot slips.
    """
    (walk,) = (branch for branch in followed().branches if branch.order == 1)
    first = walk.words[1].first
    known = np.array([walking(gamma, VALUES[ALPHA], VALUES[J]) for gamma in walk.parameter[:first]])
    found = np.column_stack([walk.x, walk.multiplier])[:first]
    off = np.abs(found - known).max(axis=0).tolist()
    if out is not None:
        figure, (ax,) = canvas(4.0)
        ax.plot(walk.parameter, walk.x, color=STABLE, label="continuation")
        ax.plot(
            walk.parameter[:first], known[:, 0], "o", color=RED, mfc="none", label="closed form"
        )
        ax.axvline(walk.parameter[first], color=GREY, label="the foot slips from here on")
        ax.set(xlabel=r"slope $\gamma$", ylabel=r"speed $\omega$ after a step")
        ax.legend()
        keep(figure, out / "system_rimless_wheel.png")
    return {"speed": off[0], "multiplier": off[1], "slips_from": float(walk.parameter[first])}


if __name__ == "__main__":
    command(main, "system_rimless_wheel")
