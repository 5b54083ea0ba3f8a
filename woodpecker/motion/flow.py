"""The motion in closed form between events; z = (y, phi_M, phi_S, dy, dphi_M, dphi_S, t)."""

from __future__ import annotations

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.base.compiled import jit, part
from woodpecker.mechanics.modes import (
    ALPHA,
    ANGLE,
    CONTACT,
    KAPPA,
    LARGEST,
    LIMIT,
    OMEGA,
    SECULAR,
    SIGN,
    A,
    B,
)
from woodpecker.motion.guards import stumpff


@part
def spring(model: Floats, mode: int, z: Floats) -> tuple[float, float, float]:
    """Stretch d of the spring, its rate, and its acceleration in a mode."""
    d = z[2] - z[1]
    return d, z[5] - z[4], model[mode, ALPHA] + model[mode, KAPPA] * d


@part
def flow(model: Floats, mode: int, z: Floats, t: float, out: Floats) -> None:
    """State after a time t in a mode."""
    _, s1, s2, s3, s4 = stumpff(model[mode, KAPPA], model[mode, OMEGA], t)
    displace(model, mode, z, t, s1, s2, s3, s4, out)
    for j in range(3):
        out[j] += z[j]


@part
def displace(
    model: Floats, mode: int, z: Floats, t: float, s1: float, s2: float, s3: float, s4: float,
    out: Floats,
) -> None:  # fmt: skip
    """Displacements, velocities and clock after a time t in a mode, from s_k = t^k c_k."""
    kappa = model[mode, KAPPA]
    d0, d1, d2 = spring(model, mode, z)
    swinging = abs(kappa) * t * t >= 1.0
    for j in range(3):
        if swinging:  # swing about the secular motion: no large terms cancel
            drift, rate, shift = model[mode, SECULAR + j], s1 * d2 / kappa, s2 * d2 / kappa
        else:
            drift, rate, shift = model[mode, A + j] + model[mode, B + j] * d0, s3 * d2, s4 * d2
        velocity = z[3 + j]
        out[j] = velocity * t + 0.5 * drift * t * t + model[mode, B + j] * (s3 * d1 + shift)
        out[3 + j] = velocity + drift * t + model[mode, B + j] * (s2 * d1 + rate)
    out[6] = z[6] + t


@part
def measure(model: Floats, z: Floats, gaps: Floats) -> None:
    """Write the gaps (3,), over their lever arms [rad], of a state."""
    for i in range(3):
        gaps[i] = model[CONTACT + i, LIMIT] + SIGN[i] * z[ANGLE[i]]


@part
def advance(model: Floats, mode: int, t: float, z: Floats, gaps: Floats, work: Floats) -> None:
    """Move the state by a time t; gaps by displacements, free of the rounding of large angles."""
    _, s1, s2, s3, s4 = stumpff(model[mode, KAPPA], model[mode, OMEGA], t)
    displace(model, mode, z, t, s1, s2, s3, s4, work)
    for i in range(3):
        gaps[i] += SIGN[i] * work[ANGLE[i]]
    for j in range(3):
        work[j] += z[j]
    copy(work, z)


@part
def copy(source: Floats, target: Floats) -> None:
    """Copy the seven entries of a state; loops compile much faster than slices."""
    for k in range(7):
        target[k] = source[k]


@part
def representable(z: Floats) -> bool:
    """Whether a state has no nan, and is small enough for computations not to overflow."""
    size = 0.0
    for k in range(7):
        size += abs(z[k])
    return size < LARGEST


@part
def touch(model: Floats, i: int, z: Floats, gaps: Floats) -> None:
    """Set the gap of contact i exactly to zero."""
    z[ANGLE[i]], gaps[i] = -SIGN[i] * model[CONTACT + i, LIMIT], 0.0


@part
def put_on_section(model: Floats, z: Floats) -> None:
    """Set the sleeve exactly to its lower contact, and all velocities to zero."""
    z[1] = -model[CONTACT + 1, LIMIT]
    z[3] = z[4] = z[5] = 0.0


@part
def shut(model: Floats, mask: int, z: Floats, gaps: Floats) -> None:
    """Set gaps and gap rates of the contacts of a mask exactly to zero."""
    for k in range(3):
        if mask >> k & 1:
            touch(model, k, z, gaps)
            z[3 + ANGLE[k]] = 0.0


@jit
def sample(model: Floats, phases: Floats, times: Floats, left: bool, out: Floats) -> None:
    """Write the states (n, 7) at given times; at an event those after it, or before if ``left``."""
    starts = phases[:, 6]
    for n in range(len(times)):
        if left:
            k = max(0, np.searchsorted(starts, times[n], side="left") - 1)
        else:
            k = max(0, np.searchsorted(starts, times[n], side="right") - 1)
        flow(model, int(phases[k, 7]), phases[k, :7], times[n] - starts[k], out[n])
