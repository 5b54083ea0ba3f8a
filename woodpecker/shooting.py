"""Periodic solutions of the toy: fixed points of P_j by single and multiple shooting."""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum
from functools import partial

import numpy as np

from woodpecker import kernel
from woodpecker.arrays import Codes, Floats
from woodpecker.compiled import announce
from woodpecker.edges import nearest_edge
from woodpecker.labelled import Cycle, Evaluation, LabelledMap, correct, evaluate
def _undefined(reason: str) -> Evaluation:
    return Evaluation(math.nan, math.nan, math.nan, reason, False)


def _restitution_map(toy: Toy, index: int) -> LabelledMap:
    """P_1 over one restitution coefficient: one mode table and one set of buffers for all calls."""
    numbers = model(toy)
    seed = np.eye(3)[index : index + 1]
    start, out = np.empty(1), np.empty((1, 5))
    codes, lengths = np.empty(1, dtype=np.int64), np.empty(1, dtype=np.int64)
    words = np.empty((1, EVENT_LIMIT), dtype=np.int16)
    texts: dict[bytes, str] = {}
    announce(kernel.sweep)

    def value(phi_s: float, p: float) -> Evaluation:
        if not 0.0 <= p <= 1.0:
            return _undefined(f"{RESTITUTIONS[index]} must lie in [0, 1], got {p}")
        if not phi_s < toy.phi_s_max:
            return _undefined("the beak touches the pole")
        numbers[CONTACT + index, EPS], start[0] = p, phi_s
        kernel.sweep(numbers, FIXED, start, 1, seed, out, codes, lengths, words)
        if codes[0] != kernel.RETURNED:
            return _undefined(status(int(codes[0])).value)
        key = words[0, : lengths[0]].tobytes()
        if key not in texts:
            texts[key] = word(words[0, : lengths[0]].tolist())
        image, _, _, slope, rate = out[0].tolist()
        if p == 0.0 and math.isnan(rate):
            rate = forward(phi_s, image)
        return Evaluation(image, slope, rate, texts[key])

    def forward(phi_s: float, image: float) -> float:
        """One-sided difference at zero restitution, of second order."""
        near, far = (value(phi_s, k * RELATIVE_STEP).value for k in (1, 2))
        return (-3.0 * image + 4.0 * near - far) / (2.0 * RELATIVE_STEP)

    return value


def shoot(
    toy: Toy, guess: float, order: int = 1, *, tolerances: Tolerances = DEFAULT
) -> PeriodicOrbit:
    """Find a periodic solution with ``order`` returns near ``guess`` [rad].

    Newton's method on all returns together (multiple shooting): products of steep slopes never
    appear. The multiplier is the product of the exact slopes.

    Returns
    -------
    PeriodicOrbit
        ``status`` says whether it is one, and why not.

    Raises
    ------
    ValueError
        If the guess or the order is out of range.
    """
    start = first_return(toy, guess, order)
    labelled_map = toy_map(toy)
    points = [float(guess)]
    for _ in range(order - 1):
        points.append(labelled_map(points[-1], toy.eps_n1).value)
    if not start.status.success:
        cycle = Cycle(np.array(points[:1]), toy.eps_n1, (labelled_map(guess, toy.eps_n1),))
        return _orbit(toy, order, cycle, ShootingStatus.LOST, start.status.value)
    cycle, good, _ = correct(labelled_map, np.array(points), toy.eps_n1, None, tolerances)
    if good:
        return _orbit(toy, order, cycle, ShootingStatus.CONVERGED)
    near = nearest_edge(labelled_map, guess, toy.eps_n1, start.word) if order == 1 else None
    if near is not None and near[0].crosses:
        at_jump = evaluate(labelled_map, np.array([near[0].x]), toy.eps_n1)
        return _orbit(toy, order, at_jump, ShootingStatus.AT_JUMP, f"at {near[0].x:.9g}")
    lost = [lap.word for lap in cycle.laps if not lap.defined]
    if lost:
        return _orbit(toy, order, cycle, ShootingStatus.LOST, lost[0])
    return _orbit(toy, order, cycle, ShootingStatus.NOT_CONVERGED)


def _orbit(
    toy: Toy, order: int, cycle: Cycle, reason: ShootingStatus, detail: str = ""
) -> PeriodicOrbit:
    returns = [first_return(toy, float(x)) for x in cycle.x if x < toy.phi_s_max]
    return PeriodicOrbit(
        toy=toy,
        order=order,
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
    """Turn an orbit into a cycle of a labelled map at parameter p."""
    x = np.array(orbit.points)
    return Cycle(x, p, tuple(labelled_map(float(value), p) for value in x))
