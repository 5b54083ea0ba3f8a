"""The toy as an instance of a general system, from Eq. (6)-(11) as the paper prints them.

    python -m studies.systems.toy [--fast] [--out DIR]

Two misprints are corrected (J_M in entry (2, 2) of the mass matrix, g in the first row of h), and
c_phi is that of the printed equilibrium. Nothing here is shared with :mod:`woodpecker.mechanics`:
the general method must reproduce the results of the closed-form kernel, and both are timed.
"""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from sympy import Matrix, symbols

from studies.common.clocks import clocked, race, repeated
from studies.common.record import Results, command
from studies.common.style import GREY, RED, WIDTH, grid, keep
from woodpecker import Toy
from woodpecker import return_map as kernel_map
from woodpecker.base.arrays import Floats
from woodpecker.systems import Contact, ContactSystem, Section, SystemMap, return_map

NAMES = "beak", "lower edge", "upper edge"
HORIZON = 20.0  # s of one return
ROUNDS = 5


def system_of(toy: Toy) -> tuple[ContactSystem, Section]:
    """A toy and its section [Leine2001, Eqs. 6-12]."""
    values = {
        name: value
        for name, value in asdict(toy).items()
        if isinstance(value, float) and name != "pole"
    }
    known = {name: symbols(name) for name in values}
    m_m, j_m, m_s, j_s, g, r_0, r_m, h_m, l_m, l_g, h_s, l_s, c = (
        known[name]
        for name in (
            *("m_m", "j_m", "m_s", "j_s", "g", "r_0", "r_m"),
            *("h_m", "l_m", "l_g", "h_s", "l_s", "c_phi"),
        )
    )
    q = _, phi_m, phi_s = symbols("y phi_m phi_s")
    u = symbols("dy dphi_m dphi_s")
    mass = [
        [m_s + m_m, m_s * l_m, m_s * l_g],
        [m_s * l_m, j_m + m_s * l_m**2, m_s * l_m * l_g],
        [m_s * l_g, m_s * l_m * l_g, j_s + m_s * l_g**2],
    ]
    force = [
        -g * (m_s + m_m),
        -c * (phi_m - phi_s) - g * m_s * l_m,
        -c * (phi_s - phi_m) - g * m_s * l_g,
    ]
    gaps = (
        (l_m + l_g - l_s - r_0) - h_s * phi_s,
        (r_m - r_0) + h_m * phi_m,
        (r_m - r_0) - h_m * phi_m,
    )
    directions = (1, l_m, l_g - l_s), (1, r_m, 0), (1, r_m, 0)
    contacts = [
        Contact(
            name=name, gap=gap, slip=Matrix(along).dot(Matrix(u)), mu=known[f"mu_{i}"],
            eps_n=known[f"eps_n{i}"],
        )
        for i, name, gap, along in zip((1, 2, 3), NAMES, gaps, directions, strict=True)
    ]  # fmt: skip
    system = ContactSystem(
        q, mass, force, contacts, {known[name]: values[name] for name in known}, u=u,
        expansion_friction=str(toy.expansion_friction),
    )  # fmt: skip
    section = Section(
        when=u[2], free=[phi_s], at={phi_m: -(r_m - r_0) / h_m}, sticking=["lower edge"],
        horizon=HORIZON,
    )  # fmt: skip
    return system, section


def map_of(toy: Toy, *parameters: str, backend: str | None = None) -> SystemMap:
    """P_1 of a toy by the general method."""
    system, section = system_of(toy)
    return SystemMap(system, section, parameters, backend=backend, x_scale=(2.26,))


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Compare returns of the paper's toy by the general method with those of the kernel.

    Parameters
    ----------
    fast
        Fewer returns.
    out
        Folder for ``system_toy.png``.

    Returns
    -------
    dict
        ``returns``, ``same_words``, ``largest_difference`` [rad] over 1 + the slope, and ``ratio``
        of the CPU times of one return, the least of some rounds: others use the machine, too.
    """
    count = 60 if fast else 1000
    toy = Toy(eps_n1=0.5)
    x = np.linspace(-2.5, -0.24, count + 1)[:-1] + 0.00113
    map_ = map_of(toy)
    kernel, general = kernel_map(toy, x), return_map(map_, x)  # compile both
    times = race(
        {
            "kernel": repeated(lambda: kernel_map(toy, x)),
            "general": clocked(lambda: return_map(map_, x)),
        },
        rounds=ROUNDS,
    )
    same = [one == other for one, other in zip(kernel.words, general.words, strict=True)]
    away = np.abs(kernel.phi_s - general.images[:, 0]) / (1.0 + np.abs(kernel.slope))
    if out is not None:
        keep(draw(x, kernel.phi_s, general.images[:, 0]), out / "system_toy.png")
    return {
        "returns": count,
        "same_words": int(sum(same)),
        "largest_difference": float(np.nanmax(away)),
        "ratio": times["general"]["cpu_minimum"] / times["kernel"]["cpu_minimum"],
    }


def draw(x: Floats, kernel: Floats, general: Floats) -> Figure:
    """The return map by both, and how much they differ."""
    figure, (above, below) = plt.subplots(
        2, 1, figsize=(WIDTH, 5.0), sharex=True, layout="constrained"
    )
    above.plot(x, kernel, ".", color=GREY, markersize=3, label="closed-form kernel")
    above.plot(x, general, "o", color=RED, markersize=4, fillstyle="none", label="general method")
    above.set_ylabel(r"$P_1(\varphi_S)$ [rad]")
    above.legend()
    below.semilogy(x, np.abs(kernel - general) + 1e-17, ".", color=GREY, markersize=3)
    below.set_xlabel(r"$\varphi_S$ [rad]")
    below.set_ylabel("difference [rad]")
    for ax in (above, below):
        grid(ax)
    return figure


if __name__ == "__main__":
    command(main, "system_toy")
