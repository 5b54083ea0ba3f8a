"""A ball on a vibrating table: period-one orbits, where they exist and where they are stable.

    python -m studies.systems.table [--fast] [--out DIR]

The table moves as a cos(t), and Gamma = a/g. A ball with restitution eps that strikes once in n
periods does so at a phase with sin(t) = -pi n (1 - eps)/((1 + eps) Gamma). Such orbits exist from a
fold at Gamma = pi n (1 - eps)/(1 + eps) on, and are stable up to a flip at Gamma**2 =
(pi n (1 - eps)/(1 + eps))**2 + (2 (1 + eps**2)/(1 + eps)**2)**2 [Luo1996]. Both are exact: high
bounces are not assumed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import sympy
from matplotlib.figure import Figure

from pwmap import Diagram, PointKind
from studies.common.record import Results, command
from studies.common.style import PALE, RED, STABLE, canvas, keep
from woodpecker.base.arrays import Floats
from woodpecker.systems import Contact, ContactSystem, Section, SystemMap, continuation, shoot

HORIZON = 20.0 * math.pi  # of one bounce: ten periods of the table
Y, V, T, GAMMA, EPS = sympy.symbols("y u_y t Gamma eps")


def system() -> ContactSystem:
    """The ball; g is 1."""
    table = Contact(name="the table", gap=Y - GAMMA * sympy.cos(T), eps_n=EPS)
    return ContactSystem([Y], [[1]], [-1], [table], {GAMMA: 1.0, EPS: 0.5})


def map_of(*parameters: str, backend: str | None = None) -> SystemMap:
    """From impact to impact: speed after it, and phase."""
    section = Section(
        when="the table", free=[V, T], at={Y: GAMMA * sympy.cos(T)}, period=2 * sympy.pi,
        first=math.pi, horizon=HORIZON,
    )  # fmt: skip
    return SystemMap(system(), section, parameters, backend=backend)


def inelastic(*parameters: str, backend: str | None = None) -> SystemMap:
    """The same without restitution: the ball has the table's speed, only the phase is free."""
    section = Section(
        when="the table", free=[T], at={Y: GAMMA * sympy.cos(T), V: -GAMMA * sympy.sin(T)},
        period=2 * sympy.pi, first=math.pi, horizon=HORIZON,
    )  # fmt: skip
    return SystemMap(system().replace(eps=0.0), section, parameters, backend=backend)


def followed(eps: float) -> Diagram:
    """The orbit of one bounce in each period over Gamma, for any eps."""
    low, high = limits(eps)
    gamma, phases = 0.1 * low + 0.9 * high, (math.pi, 3.0 * math.pi)
    if eps == 0.0:
        map_, guess, window, span = inelastic("Gamma"), [orbit(gamma, eps)[1]], [phases], low + 0.2
    else:
        map_, guess = map_of("Gamma").holding(eps=eps), orbit(gamma, eps).tolist()
        window, span = [(0.0, 12.0), phases], 0.8 * low
    cycle = shoot(map_, guess, p=[gamma])
    return continuation(map_, cycle, (span, 1.1 * high), window, orders=(1,)).diagram


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
    """The orbit between fold and flip in closed form, and both by continuation over Gamma.

    Parameters
    ----------
    fast
        Without the continuation of elastic balls.
    out
        Folder for ``system_table.png``.

    Returns
    -------
    dict
        ``closes``: how far returns are from the orbits in closed form; ``flip``, ``fold``: how far
        Gamma is from them, by continuation; ``inelastic``: how far the flip of the completely
        inelastic ball is from sqrt(4 + pi**2).
    """
    map_, closes = map_of("Gamma"), 0.0
    for eps in (0.2, 0.5, 0.8):
        low, high = limits(eps)
        for gamma in (0.5 * (low + high), high):
            x = orbit(gamma, eps)
            image = map_.holding(eps=eps).at(x, np.array([gamma]))
            closes = max(closes, float(np.abs(image.value - x).max()))
    off = {PointKind.LP: 0.0, PointKind.PD: 0.0}
    points = list[tuple[float, float]]()
    for eps in () if fast else (0.5, 0.65, 0.8):
        places = {q.kind: q.parameter for q in followed(eps).points}
        for kind, exact in zip(off, limits(eps), strict=True):
            off[kind] = max(off[kind], abs(places[kind] - exact))
            points.append((eps, places[kind]))
    (flip,) = (q.parameter for q in followed(0.0).points if q.kind is PointKind.PD)
    if out is not None:
        keep(draw([*points, (0.0, flip)]), out / "system_table.png")
    return {
        "closes": closes, "flip": off[PointKind.PD], "fold": off[PointKind.LP],
        "inelastic": abs(flip - math.sqrt(4.0 + math.pi**2)),
    }  # fmt: skip


def draw(points: Sequence[tuple[float, float]]) -> Figure:
    """Where orbits of one period exist, and where they are stable; what continuation has found."""
    figure, (ax,) = canvas(4.0)
    eps = np.linspace(0.0, 1.0, 101)
    low, high = np.array([limits(each) for each in eps]).T
    ax.fill_between(eps, low, high, color=PALE, alpha=0.4, label="one stable bounce in a period")
    ax.plot(eps, low, color=STABLE, label="fold")
    ax.plot(eps, high, "--", color=STABLE, label="flip")
    ax.plot(*np.array(points).T, "o", color=RED, mfc="none", label="continuation")
    ax.set(xlabel="restitution", ylabel=r"$\Gamma$", xlim=(-0.02, 1.0), ylim=(0.0, None))
    ax.legend()
    return figure


if __name__ == "__main__":
    command(main, "system_table")
