"""Orbit diagrams: the attractors on which orbits from many starts settle, found by iteration alone.

Lyapunov exponents come from exact slopes. An orbit diagram checks a bifurcation diagram: whatever
attracts must lie on a stable branch, or be chaotic with a positive exponent.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from pwmap.diagrams.diagram import Branch, BranchKind, Diagram, Hit
from pwmap.diagrams.shown import counted
from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.checks import instance, interval, real_array, whole
from woodpecker.base.settings import Settings
from woodpecker.base.shown import shown
from woodpecker.engine.newton import leads
from woodpecker.maps.pieces import PiecewiseMap, map_of_pieces
from woodpecker.maps.sweeps import one_by_one
from woodpecker.slices.orbits import CYCLE, Orbit, at_parameter, problem_of, to_engine

REPEATS = 1e-6  # fraction of the window: a settled orbit that repeats this closely is periodic
LONGEST = 64  # longest period sought in a settled orbit
SHOWN = 8  # most periods that the repr of a diagram lists, to stay on one line


class Swept(Protocol):
    """Images and slopes of many points, such as a :class:`woodpecker.maps.Sweep`.

    Two arrays of one shape, nan where there is no image.
    """

    @property
    def value(self) -> Floats:
        """The images."""

    @property
    def slope(self) -> Floats:
        """The slopes there."""


@runtime_checkable
class SweptMap(Protocol):
    """A map that evaluates many points in one call, faster than one by one.

    Examples
    --------
    >>> import numpy as np
    >>> from woodpecker import orbit_diagram
    >>> from woodpecker.maps import Sweep
    >>> from woodpecker.slices import SweptMap
    >>> class Tent:
    ...     def sweep(self, x, p):
    ...         return Sweep(p * np.minimum(x, 1 - x), np.where(x < 0.5, p, -p))
    >>> isinstance(Tent(), SweptMap)
    True
    >>> orbit, = orbit_diagram(Tent(), [1.5], [0.3], (0, 1), transient=100, keep=50).orbits
    >>> round(orbit.exponent, 12)  # log 1.5
    0.405465108108
    """

    def sweep(self, x: Floats, p: Floats) -> Swept:
        """Images and slopes (n,) at points ``x`` (n,), each with its own parameter ``p`` (n,)."""


def swept(map_: PiecewiseMap | SweptMap, x: Floats, p: Floats) -> Swept:
    """Images and slopes at points (n,) with parameters (n,), in one call if the map can sweep."""
    if isinstance(map_, SweptMap):
        return map_.sweep(x, p)
    return one_by_one(map_of_pieces(map_).at, x, p)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SettledOrbit:
    """The last points of one orbit at one parameter, after its transient.

    Attributes
    ----------
    p, start
        Parameter and first point.
    x
        (keep,) the last points, in order.
    exponent
        Lyapunov exponent: mean of log(abs(slope)) over ``x``; -inf for a superstable orbit.
    period
        Smallest shift, at most 64, under which ``x`` repeats; 0 if there is none.

    Examples
    --------
    >>> from woodpecker import orbit_diagram
    >>> from woodpecker.examples import two_lines
    >>> orbit, = orbit_diagram(two_lines(), [-0.5], [0.3], (-3, 3), transient=100, keep=8).orbits
    >>> orbit.period, round(float(orbit.x[-1]), 12), round(orbit.exponent, 6)
    (1, -1.0, -0.693147)
    """

    p: float
    start: float
    x: Floats
    exponent: float
    period: int

    def __repr__(self) -> str:
        period = f"period={self.period}" if self.period else "no period"
        return (
            f"SettledOrbit(p={self.p:.6g}, start={self.start:.6g}, {period}, "
            f"exponent={self.exponent:.4g}, {counted(len(self.x), 'point')})"
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class OrbitDiagram:
    """Settled orbits over a parameter; see :func:`woodpecker.orbit_diagram`.

    Attributes
    ----------
    orbits
        One for each parameter and start whose images stayed in the window.
    lost
        The number of other orbits, which left the window or had no image.
    parameter_name, x_name
        What the parameter and the coordinate are called.
    """

    orbits: tuple[SettledOrbit, ...]
    lost: int
    parameter_name: str = "p"
    x_name: str = "x"

    def __repr__(self) -> str:
        return f"OrbitDiagram({self.summary()})"

    def summary(self) -> str:
        """The counts of orbits, with the span of the parameter and the periods."""
        values = {orbit.p for orbit in self.orbits}
        ends = f"{min(values):.6g} to {max(values):.6g}" if values else ""
        over = f"{self.parameter_name} from {ends}, " if ends else ""
        held = sorted({orbit.period for orbit in self.orbits} - {0})
        periods = ", ".join(map(str, held[:SHOWN])) + (", ..." if len(held) > SHOWN else "")
        periods = f"period{'s' * (len(held) > 1)} {periods}" if held else "no period"
        count = counted(len(self.orbits), "orbit")
        return f"{count}, {over}{periods}, {self.lost} lost"

    def points(self) -> tuple[Floats, Floats]:
        """Parameters and positions of all points, two arrays of one shape (n,)."""
        p = [np.full(len(orbit.x), orbit.p) for orbit in self.orbits]
        x = [orbit.x for orbit in self.orbits]
        return np.concatenate([*p, []]), np.concatenate([*x, []])


def orbit_diagram(
    map_: PiecewiseMap | SweptMap,
    parameters: npt.ArrayLike,
    starts: npt.ArrayLike,
    window: tuple[float, float],
    *,
    transient: int = 300,
    keep: int = 128,
    settings: Settings | None = None,
) -> OrbitDiagram:
    """The orbit diagram of a map over its own parameter, as :func:`woodpecker.orbit_diagram`."""
    chosen = Settings() if settings is None else settings
    instance("settings", chosen, Settings)
    keep, transient = whole("keep", keep), whole("transient", transient, least=0)
    window = interval("window", window)
    first = np.atleast_1d(real_array("starts", starts))
    values = np.atleast_1d(real_array("parameters", parameters))
    for name, each in (("parameters", values), ("starts", first)):
        if not np.isfinite(each).all():
            raise ValueError(f"{name} must be finite, got {shown(each.tolist())}")
    p, x = (each.ravel() for each in np.broadcast_arrays(values[:, None], first))
    stayed, kept, stretch = _settled(map_, p, x, window, transient, keep)
    periods = periods_of(kept / chosen.x_scale)
    rows = zip(p[stayed].tolist(), x[stayed].tolist(), kept, stretch / keep, periods, strict=True)
    return OrbitDiagram(
        orbits=tuple(
            SettledOrbit(p=p, start=start, x=points, exponent=float(exponent), period=int(period))
            for p, start, points, exponent, period in rows
        ),
        lost=len(p) - len(stayed),
    )


def _settled(
    map_: PiecewiseMap | SweptMap, p: Floats, x: Floats, window: tuple[float, float],
    transient: int, keep: int,
) -> tuple[Ints, Floats, Floats]:  # fmt: skip
    """Indices of the orbits that stay in the window, their last points, sums of log(abs(slope))."""
    alive, kept, stretch = np.arange(len(p)), np.empty((len(p), keep)), np.zeros(len(p))
    for n in range(transient + keep):
        if not len(alive):
            break
        here = swept(map_, x, p)
        if n >= transient:
            kept[alive, n - transient] = x
            with np.errstate(divide="ignore", invalid="ignore"):
                stretch[alive] += np.log(np.abs(here.slope))
        stays = (window[0] <= here.value) & (here.value <= window[1])  # false for nan
        alive, x, p = alive[stays], here.value[stays], p[stays]
    return alive, kept[alive], stretch[alive]


def periods_of(x: Floats) -> Ints:
    """The periods (n,), at most LONGEST, of orbits of m scaled points each; 0 for no period."""
    periods, left = np.zeros(len(x), int), np.arange(len(x))
    for shift in range(1, min(LONGEST, x.shape[1] // 2) + 1):
        away = np.abs(x[left, shift:] - x[left, :-shift])
        repeats = away.max(axis=tuple(range(1, x.ndim)), initial=0.0) <= REPEATS
        periods[left[repeats]] = shift
        left = left[~repeats]
    return periods


def unexplained(
    orbits: OrbitDiagram, diagram: Diagram, map_: PiecewiseMap, distance: float | None = None,
    settings: Settings | None = None,
) -> list[SettledOrbit]:  # fmt: skip
    """Orbits that settle on a cycle through which no stable branch of the diagram passes.

    Each cycle is solved for. A branch passes through it if one Newton step leads there from the
    branch, interpolated between two samples. Chaotic orbits (positive exponent, no period) and
    periods of which the diagram has no branch are not compared.

    Parameters
    ----------
    orbits, diagram, map_
        An orbit diagram and a bifurcation diagram over the same parameter, and their map.
    distance
        Largest distance in x of a cycle from the interpolated branch; by default the distance of
        the two samples, and the Newton step decides.
    settings
        Tolerances.

    Returns
    -------
    list of SettledOrbit
        Empty if stable branches explain all periodic orbits.

    Examples
    --------
    >>> from woodpecker import Settings, continuation, orbit_diagram, shoot
    >>> from woodpecker.examples import two_lines
    >>> from woodpecker.slices import unexplained
    >>> lines = two_lines()
    >>> orbits = orbit_diagram(lines, [-0.5, 1.5], [0.3], (-3, 3), transient=100, keep=8)
    >>> settings = Settings(span=(-1, 0), window=(-3, 3))  # all branches end at p = 0
    >>> left = continuation(lines, shoot(lines, -1.0, p=-0.5), settings=settings)
    >>> [(orbit.p, orbit.period) for orbit in unexplained(orbits, left, lines)]
    [(1.5, 1)]
    """
    chosen = Settings() if settings is None else settings
    for name, value, kind in (("orbits", orbits, OrbitDiagram), ("settings", chosen, Settings)):
        instance(name, value, kind)
    held = {branch.order for branch in diagram.branches}

    @cache
    def stable(p: float, order: int) -> list[Hit]:
        return [
            hit
            for hit in diagram.at(p)
            if (hit.branch.kind, hit.branch.order) == (BranchKind.FIXED_POINT, order)
            and abs(hit.multiplier) <= 1.0
        ]

    left = []
    for orbit in orbits.orbits:
        if orbit.period not in held or (orbit.exponent > 0.0 and math.isfinite(orbit.exponent)):
            continue
        hits, cycle = stable(orbit.p, orbit.period), _cycle(map_, orbit, chosen)
        if not hits or cycle is None or not _passes(hits, orbit.p, cycle, distance, chosen):
            left.append(orbit)
    return left


def _apart(branch: Branch, p: float) -> float:
    """The distance in x of the two samples of a branch that enclose a parameter."""
    low, high = np.sort([branch.parameter[:-1], branch.parameter[1:]], axis=0)
    around = (low <= p) & (p <= high)
    return float(np.abs(np.diff(branch.x))[around].max(initial=0.0))


def _cycle(map_: PiecewiseMap, orbit: SettledOrbit, settings: Settings) -> Orbit | None:
    """The cycle on which an orbit has settled; None if Newton's method does not converge to one."""
    x = orbit.x[-orbit.period :]
    images = tuple(map_.at(each, orbit.p) for each in x.tolist())
    return at_parameter(Orbit(x, orbit.p, images), settings)


def _passes(
    hits: list[Hit], p: float, cycle: Orbit, distance: float | None, settings: Settings
) -> bool:
    """Whether branches pass through a cycle at p: one Newton step leads from them to the cycle."""
    nearest = [min(hits, key=lambda hit: abs(hit.x - x)) for x in cycle.x.tolist()]
    points = np.array([hit.x for hit in nearest])
    if distance is None:
        same = settings.same * settings.x_scale
        distance = max(same, *(_apart(hit.branch, p) for hit in nearest))
    before = float(np.abs(points - cycle.x).max())
    problem = problem_of(settings, *CYCLE)
    return before <= distance and leads(problem, points[:, None], to_engine(cycle), settings.same)
