"""The smallest change of parameters at which a condition holds.

A straight line of changes locates the condition to rounding. The gradient of the condition there
gives a direction in which it is closer; at the smallest change u the gradient is parallel to u.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import Bounds, minimize

from woodpecker.base.arrays import Floats
from woodpecker.engine.line import LinePiece
from woodpecker.engine.orbits import Closed, Condition, Multiplier, OnBorder, SpaceOrbit, orbit_of
from woodpecker.robustness.changes import FARTHEST, Space, on_line
from woodpecker.robustness.meeting import SPIKE, Key, LineEvent, cycle_on, met_along
from woodpecker.slices.orbits import to_engine

SEEDS = 16  # start conditions, the closest to first order
STEPS = 40  # iterations of the search for the smallest change; about ten are usual
PARTS = (2.0, 1.0, 0.5)  # of a turn towards the first-order minimum that are tried
NEARLY = 0.05  # sine of the angle between u and gradient below which pieces are kept fixed
FLAT = 1e-18  # relative decrease of u^2 at which to stop: the square of an angle of 1e-9
SHORTEST = 2.0**-8  # shortest part of a turn that is tried, if all lead to larger changes
BEYOND_SPIKE = 4.0  # times the longest spike: how far a line goes on beyond the condition
LEVEL = 1e-10  # relative: sizes that differ by less are equal up to rounding


def _gradient(space: Space, u: Floats, orbit: SpaceOrbit, condition: Condition) -> Floats:
    """The direction of the gradient of a condition, along the cycles at which it is tested."""
    # Cycle and condition are n + 1 equations F = 0 for n points and the parameters. Weights w with
    # w F_x = 0 leave w . F, whose gradient in the parameters is regular at a fold, too.
    rows = [_jacobian(each, condition) for each in _along_axes(space, u, orbit.x, orbit)]
    if not np.isfinite(rows).all():  # at a root singularity
        return np.full(len(u), math.nan)
    weights = np.linalg.svd(rows[0][:, :-1])[0][:, -1]
    gradient: Floats = np.array([float(weights @ row[:, -1]) for row in rows])
    return gradient


def nearest(space: Space, seed: LineEvent, seen: dict[Key, LineEvent]) -> tuple[LineEvent, float]:
    """The smallest change at which a condition holds, and the sine of its angle to the gradient.

    ``seen`` is updated with other conditions on the way that are met at smaller changes.
    """
    here = seed
    for _ in range(STEPS):
        angle, target = _angle(space, here)
        if not angle > NEARLY:
            break
        closer = _smaller_change(space, here, target, seen)
        if closer is None or not closer.size < here.size:
            break
        here = closer
    exact = _polished(space, here) if len(here.u) > 1 else None  # one parameter: one line
    if exact is not None:
        there = _same(space, here, exact, seen)
        if there is not None:
            here = there
    return here, _angle(space, here)[0]


def _angle(space: Space, here: LineEvent) -> tuple[float, Floats]:
    """Sine of the angle between u and gradient, and the smallest change to first order."""
    if here.condition is None:
        return math.nan, here.u
    target = _target(space, here)
    return float(np.linalg.norm(target - here.u)) / here.size, target


def _polished(space: Space, here: LineEvent) -> Floats | None:
    """The smallest change with the given pieces and condition, by SLSQP, or None."""
    if here.condition is None:
        return None
    n, size, condition = len(here.orbit.x), here.size, here.condition
    start = np.append(here.orbit.x, here.u)
    low, high = (space.low - here.u) / size, (space.high - here.u) / size

    def equations(z: Floats) -> Floats:
        at = start + size * z
        orbit = next(_along_axes(space, at[n:], at[:n], here.orbit))
        return np.append(Closed().residual(orbit), condition.residual(orbit)) / size

    def derivatives(z: Floats) -> Floats:
        at = start + size * z
        every = [_jacobian(e, condition) for e in _along_axes(space, at[n:], at[:n], here.orbit)]
        return np.column_stack([every[0][:, :n], *(each[:, n] for each in every)])

    try:
        found = minimize(
            lambda z: 0.5 * float(np.sum((here.u / size + z[n:]) ** 2)), np.zeros(len(start)),
            jac=lambda z: np.append(np.zeros(n), here.u / size + z[n:]), method="SLSQP",
            bounds=Bounds([-1.0] * n + low.tolist(), [1.0] * n + high.tolist()),
            constraints={"type": "eq", "fun": equations, "jac": derivatives},
            options={"ftol": FLAT, "maxiter": STEPS},
        )  # fmt: skip
    except ValueError:  # a step led to an impossible toy, such as one with its beak in the pole
        return None
    u: Floats = here.u + size * found.x[n:]
    return u if np.isfinite(u).all() and u.any() else None


def _along_axes(space: Space, u: Floats, x: Floats, like: SpaceOrbit) -> Iterator[SpaceOrbit]:
    """The orbit of the pieces of a cycle at a change, on a line along each parameter in turn."""
    for axis in np.eye(len(u)):
        line = space.line(u, axis)
        pieces = [LinePiece(on_line(line, image)) for image in like.images]
        yield orbit_of(pieces, x.reshape(-1, 1), np.zeros(1))


def _jacobian(orbit: SpaceOrbit, *conditions: Condition) -> Floats:
    """Derivatives (n + m, n + 1) of cycle equations and m conditions in points and p."""
    rows: Floats = np.concatenate([each.rows(orbit) for each in (Closed(), *conditions)])
    return rows[:, :-1]


def _target(space: Space, here: LineEvent) -> Floats:
    """The smallest change at which a condition holds to first order; nan without a gradient."""
    assert here.condition is not None
    gradient = _gradient(space, here.u, here.orbit, here.condition)
    if not (np.isfinite(gradient).all() and gradient.any()):
        return np.full(len(gradient), math.nan)
    return space.projected(gradient, float(gradient @ here.u))


def _smaller_change(
    space: Space, here: LineEvent, target: Floats, seen: dict[Key, LineEvent]
) -> LineEvent | None:
    """The condition met at a smaller change, in a direction turned towards the target, or None."""
    # The target is first order only: where the condition curves, twice or half of it may be better.
    tried = [_same(space, here, here.u + part * (target - here.u), seen) for part in PARTS]
    found = [each for each in tried if each is not None]
    part = PARTS[-1]
    while not found and part > SHORTEST:
        part *= 0.5
        there = _same(space, here, here.u + part * (target - here.u), seen)
        found = [there] if there is not None else []
    return min(found, key=lambda each: each.size, default=None)


def _same(
    space: Space, here: LineEvent, way: Floats, seen: dict[Key, LineEvent]
) -> LineEvent | None:
    """The same condition in another direction, if it is met there at a change no larger."""
    # The line is a little longer, to tell a spike from a lasting loss of stability.
    most = here.size * (1.0 + LEVEL)
    found = met_along(
        space, np.clip(way, space.low, space.high), most * (1.0 + BEYOND_SPIKE * SPIKE)
    )
    keep_smallest(found, seen)
    return next((each for each in found if each.key == here.key and each.size <= most), None)


def keep_smallest(found: Sequence[LineEvent], seen: dict[Key, LineEvent]) -> None:
    """Keep the smallest change of each condition in ``seen``."""
    for each in found:
        if each.key not in seen or each.size < seen[each.key].size:
            seen[each.key] = each


def first_guesses(space: Space) -> list[Floats]:
    """The changes at which conditions hold to first order, the smallest first."""
    none = np.zeros(len(space.names))
    line = space.line(none, np.eye(len(none))[0])
    cycle = cycle_on(line, space.points, replace(space.settings, span=(0.0, 1.0)))
    if cycle is None:
        return []
    orbit, scale = to_engine(cycle), (space.settings.x_scale, 1.0)
    conditions: list[Condition] = [Multiplier(kind, scale) for kind in ("LP", "PD")]
    for i, image in enumerate(orbit.images):
        conditions += [OnBorder(i, code) for code in image.codes.tolist()]
    rows = _rows(space, none, orbit, conditions)
    found = []
    for condition, row in zip(conditions, rows, strict=True):
        u = space.projected(row, -float(condition.residual(orbit)[0]))
        if np.isfinite(u).all() and 0.0 < np.linalg.norm(u) < FARTHEST:
            found.append(u)
    chosen = sorted(found, key=lambda u: float(np.linalg.norm(u)))[:SEEDS]
    if len(none) > 1:
        return chosen
    ways = {float(np.sign(u[0])): u for u in chosen}  # the longest line each way passes the others
    return list(ways.values())


def _rows(space: Space, u: Floats, orbit: SpaceOrbit, conditions: Sequence[Condition]) -> Floats:
    """Gradients (m, k) of m conditions in the parameters, along the smooth branch of cycles."""
    n, columns = len(orbit.x), []
    for there in _along_axes(space, u, orbit.x, orbit):
        matrix = _jacobian(there, *conditions)
        along = np.linalg.solve(matrix[:n, :n], -matrix[:n, n])
        columns.append(matrix[n:, n] + matrix[n:, :n] @ along)
    return np.array(columns).T
