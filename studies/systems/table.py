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

from pwmap import PointKind
from studies.common.record import Results, command
from studies.common.style import GREY, RED, WIDTH, grid, keep
from woodpecker.base.arrays import Floats
from woodpecker.engine.network import Connected
from woodpecker.systems import Contact, ContactSystem, Section, SystemMap, continuation, shoot

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


def followed(eps: float) -> Connected:
    """The orbit of one period over Gamma, with its fold and flip."""
    low, high = limits(eps)
    map_ = map_of("Gamma").holding(eps=eps)
    gamma = 0.5 * (low + high)
    cycle = shoot(map_, orbit(gamma, eps), p=[gamma])
    window = [(1.0, 6.0), (math.pi, 3.0 * math.pi)]
    return continuation(map_, cycle, (0.8 * low, 1.05 * high), window, orders=(1,))


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Limits of existence and stability, by continuation and in closed form.

    Parameters
    ----------
    fast
        One restitution.
    out
        Folder for ``system_table.png``.

    Returns
    -------
    dict
        ``fold`` and ``flip``: largest differences from the closed form.
    """
    worst = {"fold": 0.0, "flip": 0.0}
    found = {eps: followed(eps) for eps in ((0.5,) if fast else (0.2, 0.5, 0.8))}
    for eps, each in found.items():
        for kind, name, exact in zip((PointKind.LP, PointKind.PD), worst, limits(eps), strict=True):
            places = [q.parameter for q in each.diagram.points if q.kind is kind]
            worst[name] = max(worst[name], min(abs(p - exact) for p in places))
    if out is not None:
        keep(draw(found), out / "system_table.png")
    return dict(worst)


def draw(found: dict[float, Connected]) -> Figure:
    """Phases over Gamma."""
    figure, ax = plt.subplots(figsize=(WIDTH, 4.0), layout="constrained")
    for each in found.values():
        for branch in each.diagram.branches:
            phase = branch.columns["t"]
            ax.plot(branch.parameter, phase, color=GREY, linewidth=1.0)
            stable = np.where(np.abs(branch.multiplier) < 1.0, phase, np.nan)
            ax.plot(branch.parameter, stable, color=RED, linewidth=2.0)
    ax.set(xlabel=r"$\Gamma$", ylabel="phase of the impact [rad]")
    grid(ax)
    return figure


if __name__ == "__main__":
    command(main, "system_table")
