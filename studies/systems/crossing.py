"""A jump crossing in two dimensions: an impact and a lift-off that change their order.

    python -m studies.systems.crossing [--fast] [--out DIR]

Two coordinates are coupled by inertia: x swings and strikes a wall, y is lifted off a floor once in
a period and comes back to rest there. Sampled once in a period, while y rests, the return map has
the two coordinates x and x'. If y still rests on the floor when x strikes the wall, the impact is
at two contacts, otherwise at one, so the map jumps: the branch of cycles ends at the jump, and one
of jump crossings, x_b = s P_+(x_b) + (1 - s) P_-(x_b), continues from there.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import sympy

from pwmap import PointKind
from pwmap.diagrams.diagram import BranchKind
from pwmap.plot import plot_diagram
from studies.common.record import Results, command
from studies.common.style import WIDTH, grid, keep
from woodpecker.search.connected import Connected
from woodpecker.systems import Contact, ContactSystem, Section, SystemMap, continuation, shoot

X, Y, V, T = sympy.symbols("x y u_x t")
W, F, A, C, S, EPS, ZETA = sympy.symbols("w F a c s eps zeta")
VALUES = {W: 1.52, F: 1.39, A: 2.16, C: -0.17, S: 0.46, EPS: 0.76, ZETA: 0.37}
SPAN = 0.28, 0.5  # of s
SHORTEST = 1e-5  # step


def map_of(backend: str | None = None) -> SystemMap:
    """Once in each period, over the place s of the wall."""
    wall = Contact(name="the wall", gap=S - X, eps_n=EPS)
    floor = Contact(name="the floor", gap=Y)
    force = [F * sympy.cos(W * T) - X - 2 * ZETA * V, A * sympy.cos(W * T - 2) - 1]
    system = ContactSystem([X, Y], [[1, C], [C, 1]], force, [wall, floor], VALUES)
    section = Section(when=sympy.sin(W * T), free=[X, V], at={T: 0}, horizon=50.0)
    return SystemMap(system, section, ["s"], backend=backend)


def followed() -> Connected:
    """The stable cycle over s, and what is connected with it."""
    map_ = map_of()
    window = [(-8, 8), (-9, 9)]
    cycle = shoot(map_, [-0.888, 1.621])
    return continuation(map_, cycle, SPAN, window, orders=(1,), min_step=SHORTEST, max_branches=2)


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Follow the cycle to its jump, and the crossing from there.

    Parameters
    ----------
    fast
        Nothing is left out.
    out
        Folder for ``system_crossing.png``.

    Returns
    -------
    dict
        ``collision``: s where the cycle meets the jump; ``kinds`` of the branches that meet there;
        ``causes``: what happens there.
    """
    diagram = followed().diagram
    cycles = {each.id for each in diagram.branches if each.kind is BranchKind.FIXED_POINT}
    (border,) = (q for q in diagram.points if q.kind is PointKind.BC and cycles & {*q.branches})
    kinds = [str(branch.kind.value) for branch in diagram.branches if branch.id in border.branches]
    if out is not None:
        figure, ax = plt.subplots(figsize=(WIDTH, 4.0), layout="constrained")
        plot_diagram(diagram, ax)
        ax.set(xlabel="place $s$ of the wall", ylabel="$x$ once in each period")
        grid(ax)
        keep(figure, out / "system_crossing.png")
    return {"collision": border.parameter, "kinds": sorted(kinds), "cause": border.cause}


if __name__ == "__main__":
    command(main, "system_crossing")
