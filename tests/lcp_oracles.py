"""All solutions of small complementarity problems, by enumerating bases; laws as projections.

They check the solutions of :mod:`woodpecker.mechanics.lcp`; :func:`contact_residual` does so from
the contact laws alone, without any complementarity problem.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
import numpy.typing as npt

from woodpecker.mechanics.lcp import (
    _ZERO,
    ContactLcp,
    FloatArray,
    LcpStatus,
    _checked,
    _contacts,
    _equilibrate,
    _Equilibrated,
    _natural,
    _read,
    contact_lcp,
)

BoolArray = npt.NDArray[np.bool_]

_RANK = 1e-11  # singular values of a complementary basis below this are rounded zeros
_FEASIBLE = 1e-9  # relative violation allowed to an enumerated solution: _ZERO and a margin
_SAME = 1e-7  # enumerated solutions closer than this are one: _FEASIBLE over condition 1e2


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Random body with n contacts: G = W^T M^-1 W and the velocities W^T u before impact."""

    delassus: FloatArray
    free: FloatArray
    mu: FloatArray


def scene(rng: np.random.Generator, n: int, freedoms: int) -> Scene:
    """Masses between 1e-3 and 1e3, arbitrary directions; freedoms < 2n makes G singular."""
    w = rng.normal(size=(freedoms, 2 * n))
    root = rng.normal(size=(freedoms, freedoms))
    mass: FloatArray = 10.0 ** rng.uniform(-3, 3) * (root @ root.T + 0.1 * np.eye(freedoms))
    delassus = w.T @ np.linalg.solve(mass, w)
    free = w.T @ rng.normal(size=freedoms)
    return Scene(
        delassus=0.5 * (delassus + delassus.T), free=free, mu=rng.uniform(0.0, 1.5, size=n)
    )


def matrices(
    delassus: npt.ArrayLike,
    free: npt.ArrayLike,
    mu: npt.ArrayLike,
    floor: npt.ArrayLike = 0.0,
    sliding: npt.ArrayLike = 0,
) -> tuple[FloatArray, FloatArray]:
    """A and b of a contact problem in its own units."""
    return contact_lcp(_contacts(delassus, free, mu, floor, sliding))


def enumerate_lcp(a: npt.ArrayLike, b: npt.ArrayLike) -> list[FloatArray]:
    """All solutions x of y = A x + b, x >= 0, y >= 0, x.y = 0, by trying the 2^n bases.

    A singular basis is skipped if inconsistent; otherwise its solution of least norm (of the
    scaled unknowns) stands for the whole continuum, and counts if it is feasible.
    """
    problem = _equilibrate(*_checked(a, b))
    n = problem.b.size
    found: list[FloatArray] = []
    for support in sorted(product((False, True), repeat=n), key=sum):
        x = _complementary_point(problem, np.array(support, dtype=bool))
        if _solves(problem, x) and all(_differ(x, other) for other in found):
            found.append(np.maximum(x, 0.0))
    return [problem.size * problem.column * x for x in found]


def enumerate_contacts(
    delassus: npt.ArrayLike,
    free: npt.ArrayLike,
    mu: npt.ArrayLike,
    floor: npt.ArrayLike = 0.0,
    sliding: npt.ArrayLike = 0,
) -> list[ContactLcp]:
    """All solutions of the problem of :func:`solve_contact_lcp`, which see for the arguments.

    Brute force over :func:`enumerate_lcp`, at most four contacts that do not slide; solutions
    with the same impulses count once.
    """
    problem = _natural(_contacts(delassus, free, mu, floor, sliding))
    a, b = contact_lcp(problem)
    found: list[ContactLcp] = []
    seen: list[FloatArray] = []
    for x in enumerate_lcp(a, b):
        y = np.where(x > 0.0, 0.0, np.maximum(a @ x + b, 0.0))
        candidate = _read(problem, x, y, LcpStatus.SOLVED)
        impulse = np.append(candidate.impulse_n, candidate.impulse_t) / problem.impulse
        if all(_differ(impulse, other) for other in seen):
            found.append(candidate)
            seen.append(impulse)
    return found


def contact_residual(
    solution: ContactLcp,
    delassus: npt.ArrayLike,
    free: npt.ArrayLike,
    mu: npt.ArrayLike,
    floor: npt.ArrayLike = 0.0,
    sliding: npt.ArrayLike = 0,
) -> float:
    """Largest violation [-] of the contact laws of :func:`solve_contact_lcp` by ``solution``.

    Independent of the LCP: the laws are read as projections. Velocities are measured in
    v sqrt(G_ii) and impulses in v / sqrt(G_ii), where v makes the largest of all free
    velocities and floors 1, so that the number has no unit. NaN if not SOLVED.
    """
    problem = _natural(_contacts(delassus, free, mu, floor, sliding))
    n = problem.floor.size
    impulse = np.append(solution.impulse_n, solution.impulse_t) / problem.impulse
    gamma = np.append(solution.gamma_n, solution.gamma_t) / problem.velocity
    dynamics = problem.delassus @ impulse + problem.free - gamma
    normal = np.minimum(impulse[:n] - problem.floor, gamma[:n])
    bound = problem.friction @ np.abs(impulse[:n])  # negative Lambda_N show in the normal law
    nearest = np.clip(impulse[n:] - gamma[n:], -bound, bound)
    friction = np.where(problem.sliding == 0, nearest, -problem.sliding * bound)
    violations = np.concatenate([dynamics, normal, impulse[n:] - friction])
    return float(np.abs(violations).max(initial=0.0))


def _complementary_point(problem: _Equilibrated, support: BoolArray) -> FloatArray:
    """Least-norm x with x = 0 off ``support`` and y = 0 on it (as nearly as possible)."""
    x = np.zeros(support.size)
    block = problem.a[np.ix_(support, support)]
    cutoff = _RANK / max(float(np.linalg.norm(block)), _RANK)  # relative to the largest
    x[support] = np.linalg.lstsq(block, -problem.b[support], rcond=cutoff)[0]
    x[np.abs(x) <= _ZERO] = 0.0
    return x


def _solves(problem: _Equilibrated, x: FloatArray) -> bool:
    """Whether x satisfies the equilibrated problem up to rounding."""
    y = problem.a @ x + problem.b
    tolerance = _FEASIBLE * max(1.0, float(np.abs(x).max(initial=0.0)))
    return bool(np.abs(np.minimum(x, y)).max(initial=0.0) <= tolerance)


def _differ(x: FloatArray, other: FloatArray) -> bool:
    tolerance = _SAME * max(1.0, float(np.abs(x).max(initial=0.0)))
    return bool(np.abs(x - other).max(initial=0.0) > tolerance)
