"""A ball on a vibrating table: period-one orbits, where they exist and where they are stable.

    python -m studies.systems.table [--fast] [--out DIR]

The table moves as a cos(t), and Gamma = a/g. A ball with restitution eps that strikes once in n
periods does so at a phase with sin(t) = -pi n (1 - eps)/((1 + eps) Gamma). Such orbits exist from
Gamma = pi n (1 - eps)/(1 + eps) on, where they fold, and are stable up to a flip with Gamma**2 =
(pi n (1 - eps)/(1 + eps))**2 + (2 (1 + eps**2)/(1 + eps)**2)**2 [Luo1996]. Both are exact, without
the approximation of high bounces.
"""

from __future__ import annotations

import math
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import sympy
from matplotlib.figure import Figure

from studies.common.record import Results, command
from studies.common.style import GREY, RED, WIDTH, grid, keep
from woodpecker.base.arrays import Floats
from woodpecker.systems import Contact, ContactSystem, Section, SystemMap

Y, V, T, GAMMA, EPS = sympy.symbols("y u_y t Gamma eps")


def system() -> ContactSystem:
    """The ball; g is 1."""
    table = Contact(name="the table", gap=Y - GAMMA * sympy.cos(T), eps_n=EPS)
    return ContactSystem([Y], [[1]], [-1], [table], {GAMMA: 1.0, EPS: 0.5})


def map_of(*parameters: str, backend: str | None = None) -> SystemMap:
    """From impact to impact: speed after it, and phase."""
    section = Section(
        when="the table", free=[V, T], at={Y: GAMMA * sympy.cos(T)}, period=2 * sympy.pi,
        first=math.pi,
    )  # fmt: skip
    return SystemMap(system(), section, parameters, backend=backend)


def limits(eps: float, n: int = 1) -> tuple[float, float]:
    """Gamma where orbits of n periods begin (fold), and where they flip."""
    low = math.pi * n * (1.0 - eps) / (1.0 + eps)
    return low, math.hypot(low, 2.0 * (1.0 + eps**2) / (1.0 + eps) ** 2)


def orbit(gamma: float, eps: float, n: int = 1) -> Floats:
    """Speed after the impact and phase (2,) of the orbit of n periods that may be stable."""
    sine = -limits(eps, n)[0] / gamma
    phase = 2.0 * math.pi + math.asin(sine)  # where the table is high
    return np.array([math.pi * n, phase])


def main(fast: bool = False, out: Path | None = None) -> Results:
    """The orbit between fold and flip, and the multiplier -1 at the flip.

    Parameters
    ----------
    fast
        Nothing is left out.
    out
        Folder for ``system_table.png``.

    Returns
    -------
    dict
        ``closes``: how far returns are from the orbits in closed form; ``flip``: the largest
        1 + trace + determinant at the flip.
    """
    map_, closes, flip = map_of("Gamma"), 0.0, 0.0
    for eps in (0.2, 0.5, 0.8):
        low, high = limits(eps)
        for gamma in (0.5 * (low + high), high):
            x = orbit(gamma, eps)
            image = map_.holding(eps=eps).at(x, np.array([gamma]))
            closes = max(closes, float(np.abs(image.value - x).max()))
        jacobian = image.jacobian[:, :2]
        flip = max(flip, abs(1.0 + float(np.trace(jacobian) + np.linalg.det(jacobian))))
    if out is not None:
        keep(draw(), out / "system_table.png")
    return {"closes": closes, "flip": flip}


def draw() -> Figure:
    """Where orbits of one period exist, and where they are stable."""
    figure, ax = plt.subplots(figsize=(WIDTH, 4.0), layout="constrained")
    eps = np.linspace(0.0, 1.0, 101)
    low, high = np.array([limits(each) for each in eps]).T
    ax.plot(eps, low, color=GREY, label="fold")
    ax.plot(eps, high, color=RED, label="flip")
    ax.set(xlabel="restitution", ylabel=r"$\Gamma$")
    ax.legend()
    grid(ax)
    return figure


if __name__ == "__main__":
    command(main, "system_table")
