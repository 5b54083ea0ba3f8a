"""Periodic solutions of the toy: fixed points of P_j by single and multiple shooting."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np

from woodpecker.base.checks import whole
from woodpecker.mechanics.toy import Toy
from woodpecker.piecewise.borders import nearest_edge
from woodpecker.piecewise.maps import (
    Cycle,
    LabelledMap,
    correct,
    evaluate,
    minimal_period,
)
from woodpecker.piecewise.tolerances import DEFAULT, Tolerances
from woodpecker.simulation.returns import first_return
from woodpecker.toymaps import toy_map


class ShootingStatus(Enum):
    """How shooting ended; the value is the sentence for a user."""

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


def shoot(
    toy: Toy, guess: float, order: int = 1, *, tolerances: Tolerances = DEFAULT
) -> PeriodicOrbit:
    """Find a periodic solution with ``order`` returns near ``guess`` [rad].

    Newton's method on all returns together (multiple shooting): products of steep slopes never
    appear. The multiplier is the product of the exact slopes.

    Returns
    -------
    PeriodicOrbit
        ``status`` says whether it is one, and why not. One of a smaller period than ``order``
        counts: ``minimal_period`` and ``message`` say so.

    Raises
    ------
    ValueError
        If the guess or the order is out of range.
    """
    start, order = first_return(toy, guess, order), whole("order", order)
    labelled_map = toy_map(toy)
    points = [float(guess)]
    for _ in range(order - 1):
        points.append(labelled_map(points[-1], toy.eps_n1).value)
    if not start.status.success:
        cycle = Cycle(np.array(points[:1]), toy.eps_n1, (labelled_map(guess, toy.eps_n1),))
        return _orbit(toy, order, cycle, ShootingStatus.LOST, start.status.value)
    cycle, good, _ = correct(labelled_map, np.array(points), toy.eps_n1, None, tolerances)
    if good:
        return _closed(toy, cycle)
    near = nearest_edge(labelled_map, guess, toy.eps_n1, start.word) if order == 1 else None
    if near is not None and near[0].crosses:
        at_jump = evaluate(labelled_map, np.array([near[0].x]), toy.eps_n1)
        return _orbit(toy, order, at_jump, ShootingStatus.AT_JUMP, f"at {near[0].x:.9g}")
    lost = [lap.word for lap in cycle.laps if not lap.defined]
    if lost:
        return _orbit(toy, order, cycle, ShootingStatus.LOST, lost[0])
    return _orbit(toy, order, cycle, ShootingStatus.NOT_CONVERGED)


def _closed(toy: Toy, cycle: Cycle) -> PeriodicOrbit:
    """What a cycle is whose returns close: a periodic solution, a centre, or one without slope."""
    order, period = len(cycle.x), minimal_period(cycle)
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
    cycle: Cycle,
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
        period=sum(lap.period for lap in returns),
        drop=sum(lap.drop for lap in returns),
        multiplier=cycle.multiplier,
        word=cycle.word,
        residual=cycle.residual,
        points=tuple(cycle.x.tolist()),
        status=reason,
        message=f"{reason.value}: {detail}" if detail else reason.value,
    )


def cycle_of(orbit: PeriodicOrbit, labelled_map: LabelledMap, p: float) -> Cycle:
    """Turn an orbit into a cycle of a labelled map at parameter p, with its minimal period.

    Passed several times over it would hide its flips, and meet the same borders again and again.
    """
    x = np.array(orbit.points[: orbit.minimal_period])
    return Cycle(x, p, tuple(labelled_map(float(value), p) for value in x))
