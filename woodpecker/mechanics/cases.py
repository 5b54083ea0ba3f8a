"""Index combinations of two contacts, and the impulses in each of them.

At each contact the gap rate is zero or the normal impulse is at its floor, and the tangential
velocity is zero, positive or negative: six combinations for one contact, 36 for two. In each of
them the impulses are linear in ``free``, the velocities without impulses, and in the floors,

    Lambda = table[c_1 + 6 c_2] (free, floor),

with coefficients of masses, geometry and friction only, found once by elimination. Friction obeys
|Lambda_T| <= F Lambda_N, with equality where a contact slides: F = diag(mu) is Coulomb's law,
F = mu (1, 1) the paper's in expansion (:class:`woodpecker.mechanics.toy.ExpansionFriction`).
"""

from __future__ import annotations

import math
from typing import Any

from woodpecker.base.arrays import Floats
from woodpecker.base.compiled import part

# The index combination of one contact is 3 * normal + tangential.
REST, FREE = 0, 1  # gap rate stays zero / Lambda_N stays at its floor
HOLD, FORWARD, BACKWARD = 0, 1, 2  # tangential velocity zero / positive / negative

SLACK = 1e-11  # relative: what rounding may violate an inequality by, on its boundary
EXACT = 2.0**-47  # relative: the rounding of a few operations
SAME = 1e-8  # relative: solutions closer than this are one

SINGULAR = 1e-11  # pivot over row norm below which a combination is rank-deficient: the rounding of
# G is near 1e-15, and what is rank-deficient is exactly so (four directions in R^3)


@part
def fill_cases(delassus: Floats, friction: Floats, table: Floats, system: Floats) -> None:
    """Write the coefficients of all index combinations of two contacts into a table (36, 24).

    Row c_1 + 6 c_2 holds the (4, 6) coefficients in row-major order, nan if rank-deficient.
    ``delassus`` (4, 4) has (N, T) of each contact in turn, ``friction`` (2, 2) is F, ``system``
    (4, 10) is scratch space.
    """
    for index in range(36):
        write_case(index, delassus, friction, system)
        regular = _eliminate(system)
        for i in range(4):
            for j in range(6):
                table[index, 6 * i + j] = system[i, 4 + j] if regular else math.nan


@part
def write_case(index: int, delassus: Any, friction: Any, system: Any) -> None:
    """Write the equations of an index combination, with (free, floor) on the right-hand side."""
    system[:, :] = 0
    for k in range(2):
        case = index // 6 if k else index % 6
        row_n, row_t = 2 * k, 2 * k + 1
        if case // 3 == REST:
            for j in range(4):
                system[row_n, j] = delassus[row_n, j]
            system[row_n, 4 + row_n] = -1
        else:
            system[row_n, row_n] = 1
            system[row_n, 8 + k] = 1
        if case % 3 == HOLD:
            for j in range(4):
                system[row_t, j] = delassus[row_t, j]
            system[row_t, 4 + row_t] = -1
        else:
            system[row_t, row_t] = 1
            for j in range(2):
                bound = friction[k, j]
                system[row_t, 2 * j] = bound if case % 3 == FORWARD else -bound


@part
def _eliminate(system: Floats) -> bool:
    """Reduce the first 4 columns to the identity (scaled partial pivoting); False if singular."""
    for i in range(4):
        norm = 0.0
        for j in range(4):
            norm = max(norm, abs(system[i, j]))
        for j in range(10):
            system[i, j] /= norm
    for i in range(4):
        pivot = i
        for j in range(i + 1, 4):
            if abs(system[j, i]) > abs(system[pivot, i]):
                pivot = j
        if abs(system[pivot, i]) < SINGULAR:
            return False
        if pivot != i:
            for j in range(10):
                system[i, j], system[pivot, j] = system[pivot, j], system[i, j]
        for k in range(i + 1, 4):
            factor = system[k, i] / system[i, i]
            for j in range(i, 10):
                system[k, j] -= factor * system[i, j]
    for i in range(3, -1, -1):
        for j in range(4, 10):
            for k in range(i + 1, 4):
                system[i, j] -= system[i, k] * system[k, j]
            system[i, j] /= system[i, i]
    return True


@part
def impulse_of(table: Floats, row: int, free: Floats, floor: Floats, impulse: Floats) -> None:
    """Impulses (4,) of the index combination in a row of a table."""
    for i in range(4):
        total = 0.0
        for j in range(4):
            total += table[row, 6 * i + j] * free[j]
        for k in range(2):
            total += table[row, 6 * i + 4 + k] * floor[k]
        impulse[i] = total
