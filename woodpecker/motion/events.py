"""Guards of a mode, and which of them fires first."""

from __future__ import annotations

import math

from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.compiled import part
from woodpecker.mechanics.modes import (
    ALPHA,
    ANGLE,
    CONE_NEGATIVE,
    CONE_POSITIVE,
    CONTACT,
    GAP,
    GUARDS,
    JAMMED,
    KAPPA,
    LAMBDA,
    MU,
    NORMAL,
    OMEGA,
    OPEN,
    SECTION,
    SIGN,
    SLIP,
    SLIP_NEGATIVE,
    SLIP_POSITIVE,
    STICK,
    TANGENT,
    A,
    B,
)
from woodpecker.motion.flow import spring
from woodpecker.motion.guards import first_root


@part
def jet(
    model: Floats, mode: int, guard: int, z: Floats, gaps: Floats, states: Ints
) -> tuple[float, float, float, float]:
    """Value and first three derivatives of a guard at the start of a phase."""
    kind, i = (guard // 3) * 3, guard % 3
    d0, d1, d2 = spring(model, mode, z)
    kappa = model[mode, KAPPA]
    if kind == GAP:
        j, sign = ANGLE[i], SIGN[i]
        return (
            gaps[i],
            sign * z[3 + j],
            sign * (model[mode, A + j] + model[mode, B + j] * d0),
            sign * model[mode, B + j] * d1,
        )
    if kind == SLIP:
        sign = 1.0 if states[i] == SLIP_POSITIVE else -1.0
        velocity = along = steady = 0.0
        for k in range(3):
            w = model[CONTACT + i, TANGENT + k]
            velocity += w * z[3 + k]
            along += w * model[mode, B + k]
            steady += w * model[mode, A + k]
        return (
            sign * velocity,
            sign * (steady + along * d0),
            sign * along * d1,
            sign * along * d2,
        )
    p, r = force_guard(model, mode, guard)
    return p + r * d0, r * d1, r * d2, r * kappa * d1


@part
def starting_jet(
    model: Floats, mode: int, guard: int, z: Floats, gaps: Floats, states: Ints, fired: int
) -> tuple[float, float, float, float]:
    """Jet of a guard right after the event ``fired``, with the derivatives that this makes zero."""
    # At a detachment the gap has no acceleration yet; at a slip start the slip has none, because
    # lambda_T = +mu lambda_N at the edge of the cone is just the force of negative slip.
    f0, f1, f2, f3 = jet(model, mode, guard, z, gaps, states)
    if guard == fired:
        return 0.0, f1, f2, f3
    i = guard % 3
    if guard < NORMAL and fired == NORMAL + i:
        return 0.0, 0.0, 0.0, f3
    if guard >= SLIP:
        edge = CONE_POSITIVE if states[i] == SLIP_NEGATIVE else CONE_NEGATIVE
        if fired == edge + i:
            return 0.0, 0.0, f2, f3
    return f0, f1, f2, f3


@part
def force_guard(model: Floats, mode: int, guard: int) -> tuple[float, float]:
    """Coefficients p and r of a force guard p + r d: lambda_N, or mu lambda_N -+ lambda_T."""
    kind, i = (guard // 3) * 3, guard % 3
    column = LAMBDA + 4 * i
    if kind == NORMAL:
        return model[mode, column], model[mode, column + 1]
    sign = 1.0 if kind == CONE_POSITIVE else -1.0
    return (
        model[CONTACT + i, MU] * model[mode, column] - sign * model[mode, column + 2],
        model[CONTACT + i, MU] * model[mode, column + 1] - sign * model[mode, column + 3],
    )


@part
def guards_at_entry(i: int, state: int, still: bool) -> tuple[int, int]:
    """Guards (-1: none) that a state of contact i needs positive at once; ``still``: no slip."""
    if state == OPEN:
        return GAP + i, -1
    if state == STICK:
        return CONE_POSITIVE + i, CONE_NEGATIVE + i
    return NORMAL + i, (SLIP + i if still else -1)


@part
def time_to_minimum(model: Floats, mode: int, z: Floats) -> float:
    """Time > 0 to the next minimum of phi_S, which swings on the jammed sleeve."""
    omega = model[mode, OMEGA]
    _, d1, d2 = spring(model, mode, z)
    angle = math.atan2(-d1, d2 / omega)
    return float((angle if angle > 0.0 else angle + 2.0 * math.pi) / omega)


@part
def never_jams(model: Floats) -> bool:
    """Whether the sleeve can jam at no angle at which the woodpecker turns round."""
    # A return ends at a minimum of phi_S, where d lies below its equilibrium -alpha / kappa on the
    # jammed sleeve. There mu_2 lambda_N2 - lambda_T2 = p + r d must not be negative.
    p, r = force_guard(model, JAMMED, CONE_POSITIVE + 1)
    return bool(r >= 0.0 and p - r * model[JAMMED, ALPHA] / model[JAMMED, KAPPA] < 0.0)


@part
def next_event(
    model: Floats, mode: int, z: Floats, gaps: Floats, states: Ints, to_section: bool,
    horizon: float, before: int, ignored: int,
) -> tuple[float, int]:  # fmt: skip
    """Time to the first guard that fires before the horizon, and that guard (-1: none).

    ``before`` is the guard that began the phase; ``ignored`` is not watched. As the mode is
    admissible, a guard is negative at the start by rounding only, and counts as zero.
    """
    fired = -1
    kappa, omega = model[mode, KAPPA], model[mode, OMEGA]
    for column in range(GUARDS, GUARDS + 5):
        guard = int(model[mode, column])
        if guard < 0:
            break
        if guard == ignored:
            continue
        if guard == SECTION:
            t = time_to_minimum(model, mode, z) if to_section else math.inf
        else:
            f0, f1, f2, f3 = starting_jet(model, mode, guard, z, gaps, states, before)
            t = first_root(max(0.0, f0), f1, f2, f3, kappa, omega, horizon)
        if t < horizon or t != t:  # nan: the motion overflows, and the state will show it
            horizon, fired = t, guard
    return horizon, fired
