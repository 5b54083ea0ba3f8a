"""Brute force beside the branches: what orbits from many starts settle on.

An orbit diagram knows nothing of branches. It shows attractors, periodic or chaotic, and their
Lyapunov exponents from the exact slopes; what it shows must be explained by stable branches or by a
positive exponent.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pwmap.diagrams.diagram import BranchKind, Diagram
from woodpecker.base.arrays import Floats
from woodpecker.base.checks import interval, real_array, whole
from woodpecker.piecewise.partition import SampledMap

SAME = 1e-6  # distance [rad] within which an orbit that has settled repeats itself
LONGEST = 64  # period that is looked for


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Orbit:
    """The end of one orbit at one parameter.

    Attributes
    ----------
    p, start
        Parameter and first point.
    x
        The points that were kept, in order.
    exponent
        Lyapunov exponent: mean of log |slope| over these; -inf for a superstable orbit.
    period
        Smallest shift that repeats the kept points to 1e-6, or 0 if there is none up to 64.
    """

    p: float
    start: float
    x: Floats
    exponent: float
    period: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class OrbitDiagram:
    """Where orbits end, over a parameter.

    Attributes
    ----------
    orbits
        One for each parameter and start that stayed in the window.
    lost
        How many did not: they fell, or left the window.
    """

    orbits: tuple[Orbit, ...]
    lost: int

    def points(self) -> tuple[Floats, Floats]:
        """Parameters and positions of all kept points, for a scatter plot."""
        p = [np.full(len(orbit.x), orbit.p) for orbit in self.orbits]
        x = [orbit.x for orbit in self.orbits]
        return np.concatenate([*p, []]), np.concatenate([*x, []])


def orbit_diagram(
    map_: SampledMap,
    parameters: npt.ArrayLike,
    starts: npt.ArrayLike,
    window: tuple[float, float],
    *,
    transient: int = 300,
    keep: int = 128,
) -> OrbitDiagram:
    """Follow orbits from many starts at many parameters.

    Parameters
    ----------
    map_
        For instance :func:`woodpecker.toy_samples`.
    parameters, starts
        Shapes (n,) and (m,).
    window
        Interval of x; an orbit that leaves it is lost.
    transient, keep
        How many iterates are cut, and how many are kept after that.

    Raises
    ------
    ValueError
        If nothing is to be kept, the window is no two ascending numbers, or parameters or starts
        are no real numbers.
    """
    keep, transient = whole("keep", keep), whole("transient", transient, least=0)
    window = interval("window", window)
    first = np.atleast_1d(real_array("starts", starts))
    found: list[Orbit] = []
    values = np.atleast_1d(real_array("parameters", parameters)).tolist()
    for p in values:
        found += _settled(map_, p, first, window, transient, keep)
    return OrbitDiagram(orbits=tuple(found), lost=len(values) * len(first) - len(found))


def _settled(
    map_: SampledMap,
    p: float,
    starts: Floats,
    window: tuple[float, float],
    transient: int,
    keep: int,
) -> list[Orbit]:
    """The orbits at one parameter that stay in the window."""
    alive, x = np.arange(len(starts)), starts.copy()
    kept, stretch = np.empty((len(starts), keep)), np.zeros(len(starts))
    for n in range(transient + keep):
        here = map_.sweep(x, p)
        if n >= transient:
            kept[alive, n - transient] = x
            with np.errstate(divide="ignore", invalid="ignore"):
                stretch[alive] += np.log(np.abs(here.slope))
        stays = here.defined & (window[0] <= here.value) & (here.value <= window[1])
        alive, x = alive[stays], here.value[stays]
        if not len(alive):
            break
    return [
        Orbit(
            p=p, start=float(starts[i]), x=kept[i], exponent=float(stretch[i]) / keep,
            period=period_of(kept[i]),
        )
        for i in alive.tolist()
    ]  # fmt: skip


def period_of(x: Floats) -> int:
    """Smallest shift up to LONGEST that repeats a sequence, or 0."""
    for shift in range(1, min(LONGEST, len(x) // 2) + 1):
        if np.abs(x[shift:] - x[:-shift]).max() <= SAME:
            return shift
    return 0


def unexplained(orbits: OrbitDiagram, diagram: Diagram, distance: float = 1e-3) -> list[Orbit]:
    """Orbits that end on a cycle of which the diagram has no stable branch.

    Chaotic orbits (positive exponent, no period) and cycles of a period the diagram does not hold
    explain themselves.

    Parameters
    ----------
    orbits, diagram
        Of the same map and parameter.
    distance
        How far a branch may be: the diagram is asked between its samples.
    """
    held = {branch.order for branch in diagram.branches}
    slices: dict[float, list[tuple[int, float]]] = {}
    left = []
    for orbit in orbits.orbits:
        if orbit.period not in held or (orbit.exponent > 0.0 and math.isfinite(orbit.exponent)):
            continue
        if orbit.p not in slices:
            slices[orbit.p] = [
                (hit.branch.order, hit.x)
                for hit in diagram.at(orbit.p)
                if hit.branch.kind is BranchKind.FIXED_POINT and abs(hit.multiplier) <= 1.0
            ]
        stable = [x for order, x in slices[orbit.p] if order == orbit.period]
        points = orbit.x[: orbit.period].tolist()
        if not all(any(abs(x - point) <= distance for x in stable) for point in points):
            left.append(orbit)
    return left
