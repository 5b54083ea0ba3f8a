"""Periodic solutions of the toy or any map: fixed points of P_j by multiple shooting."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, cast

import numpy as np
import numpy.typing as npt

from pwmap.algebra.arguments import explained
from pwmap.diagrams.data import UNDECIDED, attracting, is_neutral
from pwmap.diagrams.shown import brief, table
from woodpecker.base.arrays import Floats
from woodpecker.base.checks import instance, number, real_array, whole
from woodpecker.base.settings import Settings
from woodpecker.engine.curves import SAME_VALUE
from woodpecker.engine.newton import STEPS
from woodpecker.engine.orbits import Closed
from woodpecker.maps.pieces import PiecewiseMap
from woodpecker.mechanics.toy import Toy
from woodpecker.simulation.returns import checked_starts, first_return
from woodpecker.slices.extents import samples_to_border
from woodpecker.slices.jumps import Jump, jump_of
from woodpecker.slices.margins import depth
from woodpecker.slices.orbits import (
    Orbit,
    at_parameter,
    minimal_period,
    orbit_of,
    stepped,
    to_engine,
)
from woodpecker.toy_map import OWN_VALUES, Mapped, durations, mapped_at

if TYPE_CHECKING:
    from pwmap import PiecewiseLinearMap

DEFAULT = Settings()
LOOKED = 0.01  # fraction of the window: a jump is sought within this distance of a guess
ORDER_MOST = 1000  # most returns of an orbit, as their equations are solved together


class ShootingStatus(Enum):
    """How shooting ended; the value is a sentence for users."""

    CONVERGED = "a periodic solution was found"
    CENTRE = (
        "the sleeve stays jammed: the toy rests, or swings without falling, in one of a band of "
        "centres, none of which can be followed"
    )
    NO_SLOPE = "the returns close, but the return map has no finite slope here"
    AT_JUMP = "the return map jumps across the diagonal here: there is no periodic solution"
    NOT_CONVERGED = "no periodic solution was found from this guess"
    LOST = "a start on the way does not return to the section"


@dataclass(frozen=True, slots=True, kw_only=True)
class PeriodicOrbit:
    """A periodic solution of the toy, or a cycle of a map.

    Parameters
    ----------
    source
        The toy or map, as it was given.
    p
        The parameter of the map; eps_n1 of a toy.
    order, minimal_period
        Number of returns j that was asked for, and its divisor after which the solution repeats; j
        itself if no solution was found.
    points
        The points of the orbit, of the toy on the section [rad].
    period, drop
        Duration [s] of, and distance [m] fallen in, the whole orbit; nan for a map.
    multiplier
        d P_j / d phi_S [-], of a map d P_j / dx; the orbit is stable if it is below 1 in modulus.
    word
        Sequence of events, or names of pieces; returns are separated by ``|``.
    residual
        Largest gap between a return and the next point.
    status, message
        How shooting ended; and a sentence that also says why there is no solution, of which smaller
        period it is, or why its stability is not decided.

    Examples
    --------
    >>> from woodpecker import Toy, shoot
    >>> orbit = shoot(Toy(), -0.53)
    >>> orbit.success, orbit.stable, orbit.word
    (True, True, 'S2 D2 I3 D3 I1 I3 D3 I2 D2 I2 J2')
    >>> round(orbit.phi_s, 9), round(orbit.period, 9), round(orbit.multiplier, 6)
    (-0.529471967, 0.145976065, -0.839156)
    """

    source: Toy | PiecewiseMap | PiecewiseLinearMap
    p: float
    order: int
    minimal_period: int
    points: tuple[float, ...]
    period: float
    drop: float
    multiplier: float
    word: str
    residual: float
    status: ShootingStatus
    message: str

    @property
    def x(self) -> float:
        """The first of the points."""
        return self.points[0]

    @property
    def phi_s(self) -> float:
        """The first of the points, for the toy [rad]."""
        return self.points[0]

    @property
    def toy(self) -> Toy:
        """The source if it is a toy; else a TypeError."""
        instance("the source of the orbit", self.source, Toy)
        return cast("Toy", self.source)

    @property
    def success(self) -> bool:
        """Whether a periodic solution was found that can be followed."""
        return self.status is ShootingStatus.CONVERGED

    @property
    def stable(self) -> bool:
        """Whether the multiplier is below 1 in modulus, by more than rounding."""
        return bool(attracting(self.multiplier))

    def __repr__(self) -> str:
        found = f"word={brief(self.word)!r}" if self.success else f"message={self.message!r}"
        where = f"x={self.x:.10g}, p={self.p:.10g}, "
        if isinstance(self.source, Toy):
            where = f"phi_s={self.x:.10g}, period={self.period:.8g}, drop={self.drop:.8g}, "
        return (
            f"PeriodicOrbit(order={self.order}, {where}multiplier={self.multiplier:.6g}, {found})"
        )

    def _repr_html_(self) -> str:
        rows = [
            ("points", ", ".join(f"{x:.10g}" for x in self.points)),
            ("multiplier", f"{self.multiplier:.8g}, {'stable' if self.stable else 'unstable'}"),
            ("word", self.word),
            ("residual", f"{self.residual:.1g}"),
        ]
        if isinstance(self.source, Toy):
            rows[0] = ("points on the section [rad]", rows[0][1])
            rows[-1] = ("residual [rad]", rows[-1][1])
            rows[1:1] = [
                ("period [s]", f"{self.period:.10g}"), ("drop [mm]", f"{1e3 * self.drop:.8g}")
            ]  # fmt: skip
        return table(self.message, ("periodic motion", f"of {self.order} returns"), rows)


@explained(OWN_VALUES)
def shoot(
    source: Toy | PiecewiseMap | PiecewiseLinearMap,
    guess: npt.ArrayLike,
    order: int = 1,
    *,
    p: float | None = None,
    settings: Settings = DEFAULT,
) -> PeriodicOrbit:
    """Find a periodic solution with ``order`` returns near ``guess``.

    Newton's method is applied to all returns together (multiple shooting), so that errors are not
    multiplied by the product of steep slopes. The multiplier is that product, from exact slopes.

    Parameters
    ----------
    source
        The toy, or any piecewise-smooth map of the line with one parameter, also an exact one of
        :mod:`pwmap`.
    guess
        phi_S on the section [rad], or x; or all ``order`` points of the orbit.
    order
        Number of returns.
    p
        The parameter of a map; a toy has its own values.
    settings
        Tolerances; their window is the unit of x.

    Returns
    -------
    PeriodicOrbit
        Its ``status`` says whether a solution was found, and if not, why. One of a smaller period
        counts, see ``minimal_period`` and ``message``.

    Raises
    ------
    TypeError, ValueError
        If the source is neither a toy nor a map, the settings are none, the guess or the order is
        out of range, a map has no ``p`` or a toy has one, or doubles cannot hold the equations of
        motion.

    Examples
    --------
    >>> from woodpecker import Toy, shoot
    >>> orbit = shoot(Toy(), -0.53)
    >>> print(f"{orbit.phi_s:.10f} rad, {orbit.period:.10f} s, {orbit.multiplier:.6f}")
    -0.5294719671 rad, 0.1459760651 s, -0.839156
    >>> from woodpecker.examples import two_lines  # a map of one's own
    >>> shoot(two_lines(), -0.9, p=-0.5)
    PeriodicOrbit(order=1, x=-1, p=-0.5, multiplier=0.5, word='L')
    """
    instance("settings", settings, Settings)
    mapped = mapped_at(source, p)
    points, order = _guesses(source, guess, whole("order", order, most=ORDER_MOST))
    first, lost = _taken(mapped, points[:1]), ""
    if isinstance(source, Toy):
        start = first_return(source, float(points[0]), order)
        lost = "" if start.status.success else start.status.value
    while len(points) < order and not lost:
        image = mapped.at(float(points[-1]))
        points, lost = np.append(points, image.value), image.reason
    lost = lost or first.images[0].reason
    if lost:
        return _orbit(mapped, order, first, ShootingStatus.LOST, lost)
    found, closes = _corrected(mapped, _taken(mapped, points), settings)
    if closes:
        return periodic_orbit(mapped, found, settings)
    jump = _jump_near(mapped.map_, first, settings) if order == 1 else None
    if jump is not None and jump.crosses:
        return _orbit(mapped, order, jump.head, ShootingStatus.AT_JUMP, f"at {jump.x:.9g}")
    reasons = [image.reason for image in found.images if image.reason]
    if reasons:
        return _orbit(mapped, order, found, ShootingStatus.LOST, reasons[0])
    return _orbit(mapped, order, found, ShootingStatus.NOT_CONVERGED)


def _guesses(source: object, guess: npt.ArrayLike, order: int) -> tuple[Floats, int]:
    """The points of a guess, one or all, and the order, by default their number."""
    if np.ndim(guess) == 0:
        points = np.array([number("guess", guess)])
    else:
        points = real_array("guess", guess).ravel()
        if len(points) > 1 and order == 1:
            order = len(points)
        if len(points) not in (1, order):
            raise ValueError(f"guess must have one point or {order}, as order says, got {guess!r}")
    if isinstance(source, Toy):
        checked_starts(source, points)
    elif not np.isfinite(points).all():
        raise ValueError(f"guess must be finite, got {guess!r}")
    return points, order


def _taken(mapped: Mapped, x: Floats) -> Orbit:
    """The orbit of points on the pieces that the map takes there."""
    return Orbit(x, mapped.p, tuple(mapped.at(float(value)) for value in x))


def _corrected(mapped: Mapped, start: Orbit, settings: Settings) -> tuple[Orbit, bool]:
    """The result of Newton's method for a cycle, and whether it is one."""
    # Solve with fixed pieces. If the map does not take these at the solution, make one step only,
    # and ask the map for its pieces again.
    orbit = start
    for _ in range(STEPS):
        if not orbit.defined:
            return orbit, False
        found = at_parameter(orbit, settings)
        if found is not None and is_taken(mapped, found, settings):
            return found, True
        points = stepped(orbit, settings)
        if not np.isfinite(points).all():
            return orbit, _gap(orbit) <= settings.nearest * settings.x_scale
        orbit = _taken(mapped, points)
    return orbit, False


def is_taken(mapped: Mapped, found: Orbit, settings: Settings) -> bool:
    """Whether the map takes the pieces of a cycle at its points, which may lie on their borders."""
    # The same events may also occur at other times: then the map has another value.
    there = _taken(mapped, found.x)
    if there.keys == found.keys:
        return all(
            abs(own.value - image.value) <= SAME_VALUE * max(settings.x_scale, abs(own.slope))
            for own, image in zip(found.images, there.images, strict=True)
        )
    least = -settings.converged * max(settings.x_scale, float(np.abs(found.x).max()))
    return all(depth(image) >= least for image in found.images)


def _gap(cycle: Orbit) -> float:
    """The largest gap between a return and the next point."""
    return float(np.abs(Closed().residual(to_engine(cycle))).max())


def _jump_near(map_: PiecewiseMap, first: Orbit, settings: Settings) -> Jump | None:
    """The jump of P_1 at the nearer end of the piece at a point; None if no border is nearby."""
    x, p = float(first.x[0]), first.p
    far = LOOKED * settings.x_scale
    ends = [
        samples_to_border(first.images[0], x, p, side, x + side * far, settings) for side in (-1, 1)
    ]
    borders = sorted((e[-1] for e in ends if e[-1].code >= 0), key=lambda e: abs(e.x - x))
    if not borders:
        return None
    nearest = borders[0]
    head = orbit_of([nearest.image.piece], np.array([nearest.x]), p)
    return jump_of(map_, head, nearest.code, 1, settings)


def periodic_orbit(mapped: Mapped, cycle: Orbit, settings: Settings) -> PeriodicOrbit:
    """The periodic solution of a closed cycle; a centre, or one without a slope, is no success."""
    order, period = len(cycle), minimal_period(cycle, settings)
    if isinstance(mapped.source, Toy) and not any(cycle.words):  # no event: the sleeve stays jammed
        return _orbit(mapped, order, cycle, ShootingStatus.CENTRE, period=period)
    if not math.isfinite(cycle.multiplier):
        reason = ShootingStatus.NO_SLOPE
        return _orbit(mapped, order, cycle, reason, str(cycle.multiplier), period)
    detail = f"one of period {period}, {order // period} times over" if period < order else ""
    detail = "; ".join(filter(None, [detail, UNDECIDED if is_neutral(cycle.multiplier) else ""]))
    return _orbit(mapped, order, cycle, ShootingStatus.CONVERGED, detail, period)


def _orbit(
    mapped: Mapped,
    order: int,
    cycle: Orbit,
    reason: ShootingStatus,
    detail: str = "",
    period: int | None = None,
) -> PeriodicOrbit:
    duration, drop = math.nan, math.nan
    if isinstance(mapped.source, Toy):
        duration, drop = durations(cycle.images, cycle.x, cycle.p)
    return PeriodicOrbit(
        source=mapped.source,
        p=mapped.p,
        order=order,
        minimal_period=order if period is None else period,
        points=tuple(cycle.x.tolist()),
        period=duration,
        drop=drop,
        multiplier=cycle.multiplier,
        word=" | ".join(cycle.words),
        residual=_gap(cycle),
        status=reason,
        message=f"{reason.value}: {detail}" if detail else reason.value,
    )
