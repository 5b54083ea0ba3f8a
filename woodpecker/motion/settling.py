"""The contact problem on acceleration level, which decides the next mode."""

from __future__ import annotations

from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.compiled import part
from woodpecker.mechanics.contact_problems import AMBIGUOUS, NO_SOLUTION, SOLVED, rest_is_possible
from woodpecker.mechanics.modes import (
    LAMBDA,
    NORMAL,
    OPEN,
    SLIP,
    SLIP_NEGATIVE,
    SLIP_POSITIVE,
    STICK,
    A,
    B,
    mode_of,
)
from woodpecker.motion.codes import typed
from woodpecker.motion.events import guards_at_entry, starting_jet


@part
def settle(
    model: Floats, z: Floats, gaps: Floats, closed: Ints, slips: Ints, fired: int, states: Ints,
    trial: Ints,
) -> int:  # fmt: skip
    """Solve the contact problem on acceleration level for the ``states`` (3,) of the next mode.

    All combinations of states of the closed contacts are tried. One is admissible if each of their
    guards is positive right after the event, judged by its first nonzero derivative; derivatives
    that the event makes zero count as exactly zero.

    ``closed`` (3,) is nonzero for contacts with zero gap and gap rate; ``slips`` (3,) has the signs
    of their tangential velocities, 0 where exactly zero; ``fired`` is the guard of the event (-1:
    none that leaves a zero on acceleration level).
    """
    sleeve = 1 if closed[1] else (2 if closed[2] else -1)
    states[0] = states[1] = states[2] = OPEN
    if not closed[0] and sleeve < 0:
        return SOLVED
    beak_choices, sleeve_choices = 4 if closed[0] else 1, 4 if sleeve >= 0 else 1
    trial[0] = trial[1] = trial[2] = OPEN
    for strict in (True, False):  # if none is admissible, forces below rounding count as zero
        chosen = typed(-1)
        for index in range(beak_choices * sleeve_choices):
            # Sticking (1) is tried first, opening (0) last.
            if closed[0]:
                trial[0] = (index % 4 + 1) % 4
            if sleeve >= 0:
                trial[sleeve] = (index // beak_choices + 1) % 4
            if not _matches(trial, slips) or not _admissible(
                model, z, gaps, closed, slips, fired, trial, sleeve, strict
            ):
                continue
            mode = mode_of(trial)
            if chosen < 0:
                chosen = mode
                for i in range(3):
                    states[i] = trial[i]
            elif not _same_motion(model, chosen, mode, z):
                return AMBIGUOUS
        if chosen >= 0:
            return SOLVED
    return NO_SOLUTION


@part
def _matches(trial: Ints, slips: Ints) -> bool:
    """Whether contacts that slide keep their direction, and two closed ones have one state."""
    together = OPEN
    for i in range(3):
        if trial[i] == OPEN:
            continue
        if slips[i] > 0 and trial[i] != SLIP_POSITIVE:
            return False
        if slips[i] < 0 and trial[i] != SLIP_NEGATIVE:
            return False
        if together not in (OPEN, trial[i]):
            return False
        together = trial[i]
    return True


@part
def _admissible(
    model: Floats, z: Floats, gaps: Floats, closed: Ints, slips: Ints, fired: int, trial: Ints,
    sleeve: int, strict: bool,
) -> bool:  # fmt: skip
    mode = mode_of(trial)
    if sleeve >= 0 and trial[0] == STICK and trial[sleeve] == STICK:
        return rest_is_possible(model, sleeve, z[2] - z[1])
    for i in range(3):
        if not closed[i]:
            continue
        for guard in guards_at_entry(i, trial[i], slips[i] == 0):
            if guard >= 0:
                f0, f1, f2, f3 = starting_jet(model, mode, guard, z, gaps, trial, fired)
                if guard >= SLIP:
                    f0 = 0.0  # the slip is asked for only where it is exactly zero
                weight = 0.0 if guard < NORMAL or guard >= SLIP else _weight(model, mode, i, z)
                if not _positive(f0, f1, f2, f3, weight, strict):
                    return False
    return True


@part
def _weight(model: Floats, mode: int, i: int, z: Floats) -> float:
    """Size of the terms of a contact force, to which its rounding error is relative."""
    column = LAMBDA + 4 * i
    return float(abs(model[mode, column]) + abs(model[mode, column + 1] * (z[2] - z[1])))


@part
def _positive(f0: float, f1: float, f2: float, f3: float, weight: float, strict: bool) -> bool:
    """Whether a jet is positive right after 0; unless strict a value below rounding is zero."""
    if f0 != 0.0 and (strict or abs(f0) > 1e-12 * weight):
        return f0 > 0.0
    if f1 != 0.0:
        return f1 > 0.0
    if f2 != 0.0:
        return f2 > 0.0
    return f3 >= 0.0


@part
def _same_motion(model: Floats, one: int, other: int, z: Floats) -> bool:
    """Whether two modes begin with the same accelerations, and the same rates of these."""
    d0, d1 = z[2] - z[1], z[5] - z[4]
    a, b = model[one], model[other]
    for j in range(3):
        first, second = a[A + j] + a[B + j] * d0, b[A + j] + b[B + j] * d0
        size = abs(a[A + j]) + abs(a[B + j] * d0)
        if abs(first - second) > 1e-9 * size:
            return False
        first, second = a[B + j] * d1, b[B + j] * d1
        if abs(first - second) > 1e-9 * (abs(first) + abs(second)):
            return False
    return True
