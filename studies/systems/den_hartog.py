"""Den Hartog's oscillator with dry friction: response without stops, and where stops begin.

    python -m studies.systems.den_hartog [--fast] [--out DIR]

x'' + x + f sign(x') = cos(w t), with friction as a contact that a weight of 1 keeps closed
[DenHartog1931]. Without stops the amplitude is sqrt(V**2 - (f H)**2) with V = 1/(1 - w**2) and
H = sin(pi/w)/(w (1 + cos(pi/w))); they begin at f = |V|/sqrt(H**2 + w**-4).
"""

from __future__ import annotations

import math
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import sympy

from studies.common.record import Results, command
from studies.common.style import GREY, RED, WIDTH, grid, keep
from woodpecker.systems import Contact, ContactSystem, Section, SystemMap, shoot, simulate

X, Y, V, T, W, FRICTION = sympy.symbols("x y u_x t w f")


def system() -> ContactSystem:
    """The oscillator; its normal force is 1."""
    ground = Contact(name="the ground", gap=Y, slip=V, mu=FRICTION)
    return ContactSystem(
        [X, Y], [[1, 0], [0, 1]], [sympy.cos(W * T) - X, -1], [ground], {W: 0.6, FRICTION: 0.2}
    )


def map_of(*parameters: str, backend: str | None = None) -> SystemMap:
    """Once in each period of the force."""
    section = Section(when=sympy.sin(W * T), free=[X, V], at={T: 0})
    return SystemMap(system(), section, parameters, backend=backend)


def numbers(w: float) -> tuple[float, float]:
    """V and H."""
    turn = math.pi / w
    return 1.0 / (1.0 - w * w), math.sin(turn) / (w * (1.0 + math.cos(turn)))


def exact_amplitude(w: float, f: float) -> float:
    """Without stops."""
    v, h = numbers(w)
    return math.sqrt(v * v - (f * h) ** 2)


def stops_from(w: float) -> float:
    """The friction from which on the motion stops twice in a period."""
    v, h = numbers(w)
    return abs(v) / math.hypot(h, w**-2)


def amplitude(w: float, f: float, *, backend: str | None = None) -> float:
    """Of the periodic motion: where it turns back."""
    map_ = map_of("f", backend=backend).holding(w=w, f=f)
    v, _ = numbers(w)
    cycle = shoot(map_, [v, -0.1])
    if not cycle.success:
        raise ValueError(f"no periodic motion was found at w = {w}, f = {f}: {cycle.status.value}")
    start = {"x": cycle.x[0, 0], "u_x": cycle.x[0, 1]}
    motion = simulate(map_.system, start, 2.0 * math.pi / w, backend=backend)
    turns = [event.time for event in motion.events if event.symbol[0] in "RJ"]
    return float(max(np.abs(motion.q[np.isin(motion.t, turns), 0])))


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Amplitudes over frequency.

    Parameters
    ----------
    fast
        Fewer frequencies.
    out
        Folder for ``system_den_hartog.png``.

    Returns
    -------
    dict
        ``frequencies`` and ``largest_difference`` from the closed form.
    """
    count, f = 5 if fast else 40, 0.2
    w = np.linspace(0.55, 2.4, count) + 0.013
    w = w[[stops_from(each) > f for each in w]]
    found = np.array([amplitude(each, f) for each in w])
    exact = np.array([exact_amplitude(each, f) for each in w])
    if out is not None:
        figure, ax = plt.subplots(figsize=(WIDTH, 4.0), layout="constrained")
        ax.plot(w, exact, color=GREY, label="Den Hartog")
        ax.plot(w, found, "o", color=RED, fillstyle="none", label="shooting")
        ax.set(xlabel="$w$", ylabel="amplitude", yscale="log")
        ax.legend()
        grid(ax)
        keep(figure, out / "system_den_hartog.png")
    return {"frequencies": len(w), "largest_difference": float(np.abs(found - exact).max())}


if __name__ == "__main__":
    command(main, "system_den_hartog")
