"""Periodic solutions of the toy: fixed points of P_j by single and multiple shooting."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np

from pwmap.diagrams.shown import brief, table
from woodpecker.base.checks import instance, whole
from woodpecker.base.settings import Settings
from woodpecker.engine.newton import STEPS
from woodpecker.engine.orbits import Closed
from woodpecker.mechanics.toy import Toy
from woodpecker.simulation.returns import first_return
from woodpecker.slices.extents import reach_of
from woodpecker.slices.jumps import Jump, jump_of
from woodpecker.slices.orbits import (
    Orbit,
    at_parameter,
    minimal_period,
    orbit_of,
    stepped,
    to_engine,
)
from woodpecker.toy_map import ToyPieces

DEFAULT = Settings()
LOOKED = 0.01  # in x, a part of the window: how far from a guess without a cycle a jump is sought
ORDER_MOST = 1000  # returns of an orbit: its equations are solved together


class ShootingStatus(Enum):
    """How shooting ended; the value is the sentence for a user.

    Examples
    --------
    >>> from woodpecker import Toy, ShootingStatus, shoot
    >>> shoot(Toy(), -0.53).status is ShootingStatus.CONVERGED
    True
    >>> ShootingStatus.AT_JUMP.value
    'the return map jumps across the diagonal here: there is no periodic solution'
    """

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
    """A periodic solution of the reduced toy.

    Parameters
    ----------
    order
        Number of returns j, as asked for.
    minimal_period
        Number of returns after which the solution repeats, a divisor of the order; the order itself
        if no solution was found.
    phi_s
        Its point on the section [rad]; for order > 1 the first of ``points``.
    period, drop
        Duration [s] and distance fallen [m] of the whole orbit.
    multiplier
        d P_j / d phi_S [-]; stable if below 1 in modulus.
    word
        Sequence of events, returns separated by ``|``.
    residual
        Largest gap between a return and the next point [rad].
    points
        The orbit on the section [rad].
    status, success, message
        How shooting ended, whether it found a solution that can be followed, and the sentence that
        says it: why not, or how often a solution of a smaller period is passed.

    Examples
    --------
    >>> from woodpecker import Toy, shoot
    >>> orbit = shoot(Toy(), -0.53)
    >>> orbit.success, orbit.stable, orbit.word
    (True, True, 'S2 D2 I3 D3 I1 I3 D3 I2 D2 I2 J2')
    >>> round(orbit.phi_s, 9), round(orbit.period, 9), round(orbit.multiplier, 6)
    (-0.529471967, 0.145976065, -0.839156)
    """

    toy: Toy
    order: int
    minimal_period: int
    phi_s: float
    period: float
    drop: float
    multiplier: float
    word: str
    residual: float
    points: tuple[float, ...]
    status: ShootingStatus
    message: str

    @property
    def success(self) -> bool:
        """Whether a periodic solution was found that can be followed."""
        return self.status is ShootingStatus.CONVERGED

    @property
    def stable(self) -> bool:
        """Whether the multiplier is below 1 in modulus."""
        return abs(self.multiplier) < 1.0

    def __repr__(self) -> str:
        """Its numbers, and the sentence of its status if it is none."""
        found = f"word={brief(self.word)!r}" if self.success else f"message={self.message!r}"
        return (
            f"PeriodicOrbit(order={self.order}, phi_s={self.phi_s:.10g}, "
            f"period={self.period:.8g}, drop={self.drop:.8g}, "
            f"multiplier={self.multiplier:.6g}, {found})"
        )

    def _repr_html_(self) -> str:
        rows = [
            ("points on the section [rad]", ", ".join(f"{x:.10g}" for x in self.points)),
            ("period [s]", f"{self.period:.10g}"),
            ("drop [mm]", f"{1e3 * self.drop:.8g}"),
            ("multiplier", f"{self.multiplier:.8g}, {'stable' if self.stable else 'unstable'}"),
            ("word", self.word),
            ("residual [rad]", f"{self.residual:.1g}"),
        ]
        return table(self.message, ("periodic motion", f"of {self.order} returns"), rows)


def shoot(toy: Toy, guess: float, order: int = 1, *, settings: Settings = DEFAULT) -> PeriodicOrbit:
    """Find a periodic solution with ``order`` returns near ``guess`` [rad].

    Newton's method on all returns together (multiple shooting): products of steep slopes never
    appear. The multiplier is the product of the exact slopes.

    Parameters
    ----------
    toy
        The toy.
    guess
        phi_S on the section [rad].
    order
        Number of returns.
    settings
        Tolerances and the number of Newton steps.

    Returns
    -------
    PeriodicOrbit
        ``status`` says whether it is one, and why not. One of a smaller period than ``order``
        counts: ``minimal_period`` and ``message`` say so.

    Raises
    ------
    TypeError
        If the toy or the settings are none.
    ValueError
        If the guess or the order is out of range, or doubles cannot hold the equations of motion.

    Examples
    --------
    >>> from woodpecker import Toy, shoot
    >>> orbit = shoot(Toy(), -0.53)
    >>> print(f"{orbit.phi_s:.10f} rad, {orbit.period:.10f} s, {orbit.multiplier:.6f}")
    -0.5294719671 rad, 0.1459760651 s, -0.839156
    >>> print(shoot(Toy(), -0.2235).message)
    the sleeve stays jammed: the toy rests, or swings without falling, in one of a band of centres,
    none of which can be followed
    """
    instance("settings", settings, Settings)
    start, order = first_return(toy, guess, order), whole("order", order, most=ORDER_MOST)
    map_, p = ToyPieces(toy), toy.eps_n1
    first = _taken(map_, np.array([float(guess)]), p)
    if not start.status.success:
        return _orbit(toy, order, first, ShootingStatus.LOST, start.status.value)
    points = [float(guess)]
    for _ in range(order - 1):
        points.append(map_.at(points[-1], p).value)
    found, closes = _corrected(map_, _taken(map_, np.array(points), p), settings)
    if closes:
        return periodic_orbit(toy, found, settings)
    jump = _jump_near(map_, first, settings) if order == 1 else None
    if jump is not None and jump.crosses:
        return _orbit(toy, order, jump.head, ShootingStatus.AT_JUMP, f"at {jump.x:.9g}")
    lost = [image.reason for image in found.images if image.reason]
    if lost:
        return _orbit(toy, order, found, ShootingStatus.LOST, lost[0])
    return _orbit(toy, order, found, ShootingStatus.NOT_CONVERGED)


def _taken(map_: ToyPieces, x: np.ndarray, p: float) -> Orbit:
    """Points with the pieces that the map takes there."""
    return Orbit(x, p, tuple(map_.at(float(value), p) for value in x))


def _corrected(map_: ToyPieces, start: Orbit, settings: Settings) -> tuple[Orbit, bool]:
    """Newton's method for a cycle, and whether one was found.

    With the pieces of the last iterate, if the map takes them at what they lead to; otherwise by
    one step, after which the map is asked for its pieces again.
    """
    orbit = start
    for _ in range(STEPS):
        if not orbit.defined:
            return orbit, False
        found = at_parameter(orbit, settings)
        if found is not None and _taken(map_, found.x, start.p).keys == found.keys:
            return found, True
        points = stepped(orbit, settings)
        if not np.isfinite(points).all():
            return orbit, _gap(orbit) <= settings.nearest * settings.x_scale
        orbit = _taken(map_, points, start.p)
    return orbit, False


def _gap(cycle: Orbit) -> float:
    """Largest gap between a return and the next point."""
    return float(np.abs(Closed().residual(to_engine(cycle))).max())


def _jump_near(map_: ToyPieces, first: Orbit, settings: Settings) -> Jump | None:
    """The jump of P_1 at the nearer end of the piece that a point lies in; None if it has none."""
    x, p = float(first.x[0]), first.p
    far = LOOKED * settings.x_scale
    ends = [reach_of(first.images[0], x, p, side, x + side * far, settings) for side in (-1, 1)]
    borders = sorted((e for e in ends if e.code >= 0), key=lambda e: abs(e.end - x))
    if not borders:
        return None
    nearest = borders[0]
    head = orbit_of([nearest.images[-1].piece], np.array([nearest.end]), p)
    return jump_of(map_, head, nearest.code, 1, settings)


def periodic_orbit(toy: Toy, cycle: Orbit, settings: Settings) -> PeriodicOrbit:
    """What a cycle is whose returns close: a periodic solution, a centre, or one without slope."""
    order, period = len(cycle), minimal_period(cycle, settings)
    if not any(cycle.words):  # no event: the sleeve stays jammed
        return _orbit(toy, order, cycle, ShootingStatus.CENTRE, period=period)
    if not math.isfinite(cycle.multiplier):
        reason = ShootingStatus.NO_SLOPE
        return _orbit(toy, order, cycle, reason, str(cycle.multiplier), period)
    detail = f"one of period {period}, {order // period} times over" if period < order else ""
    return _orbit(toy, order, cycle, ShootingStatus.CONVERGED, detail, period)


def _orbit(
    toy: Toy,
    order: int,
    cycle: Orbit,
    reason: ShootingStatus,
    detail: str = "",
    period: int | None = None,
) -> PeriodicOrbit:
    returns = [first_return(toy, float(x)) for x in cycle.x if x < toy.phi_s_max]
    return PeriodicOrbit(
        toy=toy,
        order=order,
        minimal_period=order if period is None else period,
        phi_s=float(cycle.x[0]),
        period=sum(each.period for each in returns),
        drop=sum(each.drop for each in returns),
        multiplier=cycle.multiplier,
        word=" | ".join(cycle.words),
        residual=_gap(cycle),
        points=tuple(cycle.x.tolist()),
        status=reason,
        message=f"{reason.value}: {detail}" if detail else reason.value,
    )
