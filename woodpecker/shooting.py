"""Periodic solutions of the toy: fixed points of P_j by single and multiple shooting."""

from __future__ import annotations

import math
import threading
from dataclasses import dataclass
from enum import Enum
from functools import partial

import numpy as np

from woodpecker import kernel
from woodpecker.arrays import Floats
from woodpecker.checks import whole
from woodpecker.compiled import announce
from woodpecker.edges import nearest_edge
from woodpecker.labelled import (
    Cycle,
    Evaluation,
    LabelledMap,
    correct,
    evaluate,
    minimal_period,
)
from woodpecker.modes import CONTACT, EPS, model
from woodpecker.pieces import SampledMap, Samples, WordBook
from woodpecker.returns import EVENT_LIMIT, RESTITUTIONS, first_return
from woodpecker.status import status
from woodpecker.tolerances import DEFAULT, Tolerances
from woodpecker.toy import Toy, known_parameter
from woodpecker.words import word

RELATIVE_STEP = 1e-6  # of central differences in parameters the variational flow does not carry:
# the cube root of the kernel's rounding


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


def toy_map(toy: Toy, parameter: str = "eps_n1") -> LabelledMap:
    """P_1 of the toy as a labelled map of (phi_S, parameter).

    The derivative in a restitution coefficient is exact, except where the coefficient is zero and
    a larger one would make a resting contact bounce: there it is a forward difference. In any other
    parameter it is a central difference, or one-sided next to a change of word.

    Raises
    ------
    TypeError
        If the parameter is unknown.
    """
    if known_parameter(parameter) in RESTITUTIONS:
        return _restitution_map(toy, RESTITUTIONS.index(parameter))

    def value(phi_s: float, p: float) -> Evaluation:
        try:
            changed = toy.replace(**{parameter: p})
        except ValueError as error:
            return _undefined(str(error))
        return _restitution_map(changed, 0)(phi_s, changed.eps_n1)

    def with_difference(phi_s: float, p: float) -> Evaluation:
        here = value(phi_s, p)
        step = RELATIVE_STEP * max(abs(p), RELATIVE_STEP)
        sides = [
            (side.value, p + sign * step)
            for sign in (1.0, -1.0)
            if (side := value(phi_s, p + sign * step)).word == here.word
        ]
        sides.append((here.value, p))
        if len(sides) == 1:
            return here._replace(rate=np.nan)
        first, second = sides[0], sides[1]
        return here._replace(rate=(first[0] - second[0]) / (first[1] - second[1]))

    return with_difference


def toy_samples(toy: Toy, parameter: str = "eps_n1") -> SampledMap:
    """P_1 of the toy as a map that takes many points at once; see :func:`toy_map`.

    Parameters other than a restitution coefficient have no derivative here: ``rate`` is nan.
    """
    exact = known_parameter(parameter) in RESTITUTIONS
    seed = np.eye(3)[[RESTITUTIONS.index(parameter)]] if exact else np.zeros((1, 3))
    book, local = WordBook(), threading.local()
    announce(kernel.sweep)

    def sweep(x: Floats, p: float) -> Samples:
        n = len(x)
        if getattr(local, "p", math.nan) != p:  # each thread keeps the table of its last parameter
            local.p, local.table = p, model(toy.replace(**{parameter: p}))
        out, texts = np.empty((n, 5)), np.empty((n, EVENT_LIMIT), dtype=np.int16)
        codes, lengths = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
        kernel.sweep(local.table, x, 1, seed, out, codes, lengths, texts)
        defined = codes == kernel.RETURNED
        out[~defined] = np.nan
        index = np.empty(n, dtype=np.int64)
        for i in range(n):
            if defined[i]:
                codes_of_word = texts[i, : lengths[i]]
                index[i] = book.index(
                    codes_of_word.tobytes(), partial(word, codes_of_word.tolist())
                )
            else:
                reason = status(int(codes[i])).value
                index[i] = book.index(reason, reason.__str__)
        rate = out[:, 4] if exact else np.full(n, np.nan)
        return Samples(x, out[:, 0], out[:, 3], rate, index, defined)

    return SampledMap(sweep, book.texts)


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
        kernel.sweep(numbers, start, 1, seed, out, codes, lengths, words)
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
