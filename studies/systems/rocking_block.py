"""Hogan's rocking block: the symmetric motion of period one, its fold and its pitchfork.

    python -m studies.systems.rocking_block [--fast] [--out DIR]

x'' = x - sign(x) - beta cos(w t) for the angle x of a slender block over that of its diagonal; when
it rocks from one corner to the other its speed is multiplied by r [Hogan1989]. Here the block is a
body with two corners, of which one strikes without restitution while the other lifts off: with
inertia (1 + r)/2, mass (1 - r)/2 and half width 1 the impact law alone yields the factor r.

Symmetric motions, whose halves are mirror images of each other, satisfy linear equations in the
speed v after an impact, and beta follows from it. They fold where a multiplier of the half motion
with its reflection is 1, and lose their symmetry where it is -1. Both speeds have a closed form.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
import sympy
from matplotlib.figure import Figure

from pwmap import PointKind
from pwmap.plot import plot_diagram
from studies.common.record import Results, command
from studies.common.style import RED, canvas, keep
from woodpecker.base.arrays import Floats
from woodpecker.search.connected import Connected
from woodpecker.systems import Contact, ContactSystem, Section, SystemMap, continuation, shoot

X, Y, V_X, V_Y, T = sympy.symbols("x y u_x u_y t")
BETA, W, R = sympy.symbols("beta w r")
FIRST = -1.0  # the least time of impacts: none of the branches crosses it
VALUES = {BETA: 3.0, W: 3.0, R: 0.925}


def system() -> ContactSystem:
    """The block on its two corners."""
    corners = [Contact(name="left corner", gap=Y - X), Contact(name="right corner", gap=Y + X)]
    mass = [[(1 + R) / 2, 0], [0, (1 - R) / 2]]
    return ContactSystem([X, Y], mass, [X - BETA * sympy.cos(W * T), -1], corners, VALUES)


def map_of(*parameters: str, backend: str | None = None) -> SystemMap:
    """From impact to impact of the right corner: speed after it, and time modulo the period."""
    period = 2 * sympy.pi / W
    section = Section(
        when="right corner",
        free=[V_X, T],
        at={V_Y: -V_X},
        period=period,
        first=FIRST,
        horizon=100.0,
    )
    return SystemMap(system(), section, parameters, backend=backend)


class Symmetric(NamedTuple):
    """Symmetric motions of one period for given w and r; any beta."""

    w: float
    r: float

    @property
    def numbers(self) -> tuple[float, float, float]:
        """(1 + 1/r)/2, (1/r - 1)/2 and tanh(pi/(2 w))."""
        return 0.5 * (1 + 1 / self.r), 0.5 * (1 / self.r - 1), math.tanh(0.5 * math.pi / self.w)

    def beta(self, v: float) -> float:
        """Amplitude of the force of the motion with some speed after its impacts."""
        cosine, sine = self._turned(v)
        return (1 + self.w**2) * math.hypot(cosine, sine)

    def _turned(self, v: float) -> tuple[float, float]:
        """beta/(1 + w**2) times the cosine and the sine of the phase of the impact from x < 0."""
        p, q, tanh = self.numbers
        return -q * v * tanh, (tanh - p * v) / self.w

    def point(self, v: float) -> Floats:
        """Speed and time (2,) after the impact of the right corner, half a period later."""
        cosine, sine = self._turned(v)
        t, period = (math.atan2(sine, cosine) + math.pi) / self.w, 2 * math.pi / self.w
        return np.array([-v, FIRST + (t - FIRST) % period])

    def half(self, v: float) -> tuple[float, float]:
        """Trace and determinant of the half motion with its reflection."""
        (_, q, tanh), h, r = self.numbers, math.pi / self.w, self.r
        pull = (1 + r) / v - (1 - r) * (1 + self.w**2) * q * tanh
        return r * (math.sinh(h) * pull - 2 * math.cosh(h)), r**2

    def fold(self) -> float:
        """The speed at which beta is least."""
        p, q, tanh = self.numbers
        return p * tanh / ((q * tanh * self.w) ** 2 + p**2)

    def pitchfork(self) -> float:
        """The speed at which the motion loses its symmetry."""
        (_, q, tanh), h, r = self.numbers, math.pi / self.w, self.r
        below = 2 * r * math.cosh(h) - 1 - r**2
        below += r * (1 - r) * (1 + self.w**2) * q * tanh * math.sinh(h)
        return r * (1 + r) * math.sinh(h) / below


def followed(w: float = VALUES[W], r: float = VALUES[R]) -> Connected:
    """The symmetric motion over beta, and those that are born where it loses its symmetry."""
    exact = Symmetric(w, r)
    fold, fork = exact.beta(exact.fold()), exact.beta(exact.pitchfork())
    map_ = map_of("beta").holding(w=w, r=r)
    v = 0.5 * (exact.fold() + exact.pitchfork())
    cycle = shoot(map_, exact.point(v), p=[exact.beta(v)])
    window = [(-4.0 * exact.pitchfork(), 0.0), (FIRST, FIRST + 2 * math.pi / w)]
    return continuation(map_, cycle, (0.8 * fold, 1.2 * fork), window, orders=(1,))


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Follow the symmetric motion, and compare its special points.

    Parameters
    ----------
    fast
        Nothing is left out.
    out
        Folder for ``system_rocking_block.png``.

    Returns
    -------
    dict
        ``fold``, ``pitchfork``: how far they are from the closed form; ``closes``: how far the
        returns of the closed form are from closing.
    """
    exact, map_ = Symmetric(VALUES[W], VALUES[R]), map_of("beta")
    found, off = followed(), {}
    for name, kind, v in (
        ("fold", PointKind.LP, exact.fold()), ("pitchfork", PointKind.BP, exact.pitchfork()),
    ):  # fmt: skip
        places = [q.parameter for q in found.diagram.points if q.kind is kind]
        off[name] = min(abs(beta - exact.beta(v)) for beta in places)
    speeds = np.linspace(exact.fold(), exact.pitchfork(), 5)
    away = [
        np.abs(map_.at(exact.point(v), np.array([exact.beta(v)])).value - exact.point(v)).max()
        for v in speeds
    ]
    if out is not None:
        keep(draw(found, exact), out / "system_rocking_block.png")
    return {**off, "closes": float(max(away))}


def draw(found: Connected, exact: Symmetric) -> Figure:
    """Branches over beta, and the closed form."""
    figure, (ax,) = canvas(4.2)
    plot_diagram(found.diagram, ax)
    v = np.linspace(0.5 * exact.fold(), 1.15 * exact.pitchfork(), 40)
    ax.plot(
        [exact.beta(each) for each in v], -v, "o", color=RED, markersize=3, mfc="none",
        label="closed form, symmetric",
    )  # fmt: skip
    ax.legend(loc="lower left")
    ax.set(xlabel=r"amplitude $\beta$ of the force", ylabel="speed after an impact")
    return figure


if __name__ == "__main__":
    command(main, "system_rocking_block")
