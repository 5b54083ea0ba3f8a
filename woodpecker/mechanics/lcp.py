"""Linear complementarity problems, and contact problems written as such.

Lemke's method solves y = A x + b, x, y >= 0, x.y = 0 [Leine2001, Eqs. 4-5] for any number of
unknowns. Impacts and accelerations have one form, :func:`contact_lcp` [Pfeiffer1996, chs. 6-8].
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int_]

# These apply to an equilibrated problem, with matrix entries and right-hand side up to 1.
_ZERO = 1e-11  # ratios closer than this tie: rounding of 1e-16, times 1e5, a condition of the basis
_PIVOT = 1e-10  # smaller pivots are zeros but for rounding: the same with a margin of 10
_SWEEPS = 8  # of equilibration; each halves the exponents' distance from their limit


class LcpStatus(Enum):
    """How Lemke's path ended."""

    SOLVED = "the problem is solved"
    RAY = "Lemke's path ends in a ray: no solution found"
    PIVOT_LIMIT = "the pivot limit is reached: no solution found"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LcpResult:
    """End of Lemke's path for y = A x + b; NaN in x and y unless SOLVED."""

    x: FloatArray  # shape (n,), >= 0
    y: FloatArray  # shape (n,), >= 0, zero wherever x is not
    pivots: int
    status: LcpStatus

    def __post_init__(self) -> None:
        _freeze(self, "x", "y")

    @property
    def success(self) -> bool:
        """Whether x and y solve the problem."""
        return self.status is LcpStatus.SOLVED


def lemke(
    a: npt.ArrayLike,
    b: npt.ArrayLike,
    *,
    cover: npt.ArrayLike | None = None,
    max_pivots: int = 1000,
) -> LcpResult:
    """Solve y = A x + b, x >= 0, y >= 0, x.y = 0 by Lemke's method [Leine2001, Eqs. 4-5].

    The problem is relaxed to y = A x + z d + b with a covering variable z >= 0. The path starts at
    x = 0 with the smallest feasible z and exchanges complementary variables until z leaves the
    basis. The leaving row is the lexicographic minimum of B^-1 [b, I] over the entering column, so
    that no basis recurs. Rows and columns are first scaled by powers of two, so that units do not
    matter. A ray proves that there is no solution if A is positive semidefinite, but not otherwise.

    ``cover`` is d >= 0 (n,) in units of b, positive wherever b is negative; by default ones in the
    scaled problem. The longest paths grow like 2^n pivots. ValueError for other shapes than (n, n)
    and (n,), or entries that are not finite.
    """
    problem = _equilibrate(*_checked(a, b))
    n = problem.b.size
    covering = _covering(problem, cover)
    if problem.b.min(initial=0.0) >= 0.0:
        return _solution(problem, np.arange(n), problem.b, 0)
    z = 2 * n  # columns: y_1..y_n, x_1..x_n, z
    columns = np.column_stack([np.eye(n), -problem.a, -covering])
    start = np.column_stack([problem.b, np.eye(n)])
    basis = np.arange(n)
    covered = np.flatnonzero(covering)
    first = _lexicographic_minimum(start[covered] / covering[covered, None])
    entering, row = z, int(covered[first])
    for pivots in range(1, max_pivots + 1):
        leaving, basis[row] = int(basis[row]), entering
        entering = (leaving + n) % z
        right = np.column_stack([start, columns[:, entering]])
        table = np.linalg.solve(columns[:, basis], right)  # solved afresh: no error accumulates
        if table[basis == z, 0].sum() <= _ZERO:  # z has left the basis, or is zero in it
            return _solution(problem, basis, table[:, 0], pivots)
        candidates = np.flatnonzero(table[:, -1] > _PIVOT)
        if not candidates.size:
            return _failure(n, pivots, LcpStatus.RAY)
        ratios = table[candidates, :-1] / table[candidates, -1:]
        row = int(candidates[_lexicographic_minimum(ratios)])
    return _failure(n, max_pivots, LcpStatus.PIVOT_LIMIT)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ContactLcp:
    """Impulses and velocities (or forces and accelerations) of n contacts; NaN unless SOLVED.

    gamma_N is exactly zero where Lambda_N > floor, gamma_T where a contact sticks.
    """

    impulse_n: FloatArray  # Lambda_N, shape (n,), N s (or N), Lambda_N >= floor
    impulse_t: FloatArray  # Lambda_T, shape (n,), N s (or N)
    gamma_n: FloatArray  # normal relative velocity, shape (n,), m/s (or m/s^2), >= 0
    gamma_t: FloatArray  # tangential relative velocity, shape (n,), m/s (or m/s^2)
    status: LcpStatus

    def __post_init__(self) -> None:
        _freeze(self, "impulse_n", "impulse_t", "gamma_n", "gamma_t")

    @property
    def success(self) -> bool:
        """Whether the contact problem is solved."""
        return self.status is LcpStatus.SOLVED


def solve_contact_lcp(
    delassus: npt.ArrayLike,
    free: npt.ArrayLike,
    mu: npt.ArrayLike,
    floor: npt.ArrayLike = 0.0,
    sliding: npt.ArrayLike = 0,
) -> ContactLcp:
    """Impulses (or forces) of n contacts by Lemke's path on :func:`contact_lcp`.

    Solves gamma = G Lambda + free with, per contact and with the bound B = F Lambda_N on friction,

    - 0 <= Lambda_N - floor  perp  gamma_N >= 0,
    - |Lambda_T| <= B; gamma_T > 0 => Lambda_T = -B and gamma_T < 0 => Lambda_T = +B; if it
      slides already: Lambda_T = -s B.

    Compression: free = velocities before the impact, floor 0. Expansion: free = velocities after
    compression, floor = eps_N Lambda_NC. Acceleration level: free = accelerations without contact
    forces, floor 0, s = sign of the sliding velocity [Pfeiffer1996, chs. 6-8].

    ``delassus`` is G = [[G_NN, G_NT], [G_TN, G_TT]] = W^T M^-1 W (2n, 2n), normals first [1/kg];
    ``free`` (2n,) are relative velocities [m/s] (or accelerations [m/s^2]) at Lambda = 0, exact
    zeros for a body at rest, as they are scaled by the largest of free and floor; ``mu`` >= 0 is F
    (n, n), its diagonal (n,) or a scalar; ``floor`` >= 0 [N s] and ``sliding`` s (+1, -1, or 0
    where the law decides) are (n,) or scalars. ValueError for other shapes or values.

    Without sliding directions, and with free = W^T u of a motion, there is a solution for any F,
    and the path leads to one. There may be several, also with different velocities, if friction
    couples normal and tangential directions strongly; the order of the contacts matters only
    between contacts with the same data. With given directions there may be none (Painleve), which
    a ray does not prove.
    """
    given = _natural(_contacts(delassus, free, mu, floor, sliding))
    order = _order(given)
    problem = _permuted(given, order)
    result = lemke(*contact_lcp(problem), cover=_contact_cover(problem))
    found, back = _read(problem, result.x, result.y, result.status), np.argsort(order)
    names = ("impulse_n", "impulse_t", "gamma_n", "gamma_t")
    return replace(found, **{name: getattr(found, name)[back] for name in names})


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Equilibrated:
    """y = A x + b in units x = size column x', y = size y' / row, entries up to about 1."""

    a: FloatArray
    b: FloatArray
    row: FloatArray
    column: FloatArray
    size: float


def _checked(a: npt.ArrayLike, b: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
    a, b = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    if b.ndim != 1 or a.shape != (b.size, b.size):
        raise ValueError(f"expected shapes (n, n) and (n,), got {a.shape} and {b.shape}")
    if not (np.isfinite(a).all() and np.isfinite(b).all()):
        raise ValueError("expected finite entries, got NaN or infinity")
    return a, b


def _equilibrate(a: FloatArray, b: FloatArray) -> _Equilibrated:
    """Scale all rows and columns to a largest entry of about 1, by powers of two (no rounding)."""
    # Each sweep divides rows and columns by the root of their largest entry (Ruiz).
    row, column = np.ones(b.size), np.ones(b.size)
    for _ in range(_SWEEPS):
        size = row[:, None] * np.abs(a) * column
        row = row / np.sqrt(_positive(size.max(axis=1, initial=0.0)))
        column = column / np.sqrt(_positive(size.max(axis=0, initial=0.0)))
    row, column = _power_of_two(row), _power_of_two(column)
    size_b = float(_power_of_two(_positive(np.abs(row * b).max(initial=0.0))))
    return _Equilibrated(
        a=row[:, None] * a * column, b=row * b / size_b, row=row, column=column, size=size_b
    )


def _covering(problem: _Equilibrated, cover: npt.ArrayLike | None) -> FloatArray:
    if cover is None:
        return np.ones(problem.b.size)
    d = np.asarray(cover, dtype=np.float64)
    if d.shape != problem.b.shape or not ((d > 0.0) | (d == 0.0) & (problem.b >= 0.0)).all():
        raise ValueError(f"cover must be >= 0, and > 0 wherever b < 0, got {cover}")
    d = problem.row * d
    return d / _positive(d.max(initial=0.0))


def _positive(size: npt.ArrayLike) -> FloatArray:
    """Sizes that may be divided by: 0 is replaced by 1."""
    return np.where(np.asarray(size) > 0.0, size, 1.0)


def _power_of_two(value: npt.ArrayLike) -> FloatArray:
    nearest: FloatArray = np.exp2(np.round(np.log2(value)))
    return nearest


def _solution(
    problem: _Equilibrated, basis: IntArray, values: FloatArray, pivots: int
) -> LcpResult:
    n = problem.b.size
    every = np.zeros(2 * n + 1)
    every[basis] = np.maximum(values, 0.0)  # rounding may leave -1e-17
    y = problem.size / problem.row * every[:n]
    x = problem.size * problem.column * every[n : 2 * n]
    return LcpResult(x=x, y=y, pivots=pivots, status=LcpStatus.SOLVED)


def _failure(n: int, pivots: int, status: LcpStatus) -> LcpResult:
    return LcpResult(x=np.full(n, np.nan), y=np.full(n, np.nan), pivots=pivots, status=status)


def _lexicographic_minimum(rows: FloatArray) -> int:
    """Index of the lexicographically smallest row, up to rounding."""
    tied = np.arange(len(rows))
    for column in rows.T:
        values = column[tied]
        tied = tied[values <= values.min() + _ZERO]
        if tied.size == 1:
            break
    return int(tied[0])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Contacts:
    """The checked data of a contact problem, and the units in which they are given."""

    delassus: FloatArray  # (2n, 2n)
    free: FloatArray  # (2n,)
    friction: FloatArray  # (n, n), the matrix F
    floor: FloatArray  # (n,)
    sliding: IntArray  # (n,)
    velocity: FloatArray  # unit of gamma and free, (2n,)
    impulse: FloatArray  # unit of Lambda and floor, (2n,)


def _contacts(
    delassus: npt.ArrayLike,
    free: npt.ArrayLike,
    mu: npt.ArrayLike,
    floor: npt.ArrayLike,
    sliding: npt.ArrayLike,
) -> _Contacts:
    g, free = _checked(delassus, free)
    n, odd = divmod(free.size, 2)
    if odd:
        raise ValueError(
            f"expected a normal and a tangential entry per contact, got {2 * n + 1} in all"
        )
    friction = _friction_matrix(np.asarray(mu, dtype=np.float64), n)
    floor, s = (np.broadcast_to(np.asarray(v, dtype=np.float64), n) for v in (floor, sliding))
    for name, value in (("mu", friction), ("floor", floor)):
        if not (np.isfinite(value) & (value >= 0.0)).all():
            raise ValueError(f"{name} must be finite and >= 0, got {value}")
    if not np.isin(s, (-1.0, 0.0, 1.0)).all():
        raise ValueError(f"sliding must be -1, 0 or +1, got {s}")
    one = np.ones(2 * n)
    return _Contacts(
        delassus=g,
        free=free,
        friction=friction,
        floor=floor,
        sliding=s.astype(int),
        velocity=one,
        impulse=one,
    )


def _friction_matrix(mu: FloatArray, n: int) -> FloatArray:
    if mu.shape not in ((), (1,), (n,), (n, n)):
        raise ValueError(f"mu must have shape (), ({n},) or ({n}, {n}), got {mu.shape}")
    return mu if mu.ndim == 2 else np.diag(np.broadcast_to(mu, n))


def _natural(problem: _Contacts) -> _Contacts:
    """Rescale the problem to diag(G) = 1 and the largest of free and floor equal to 1."""
    # Units: v sqrt(G_ii) of gamma_i, v / sqrt(G_ii) of Lambda_i, where v^2 is an energy.
    n = problem.floor.size
    root = np.sqrt(_positive(np.diag(problem.delassus)))
    sizes = np.append(np.abs(problem.free) / root, problem.floor * root[:n])
    v = float(_positive(sizes.max(initial=0.0)))
    return _Contacts(
        delassus=problem.delassus / np.outer(root, root),
        free=problem.free / (v * root),
        friction=problem.friction * np.divide.outer(root[n:], root[:n]),
        floor=problem.floor * root[:n] / v,
        sliding=problem.sliding,
        velocity=v * root,
        impulse=v / root,
    )


def _order(problem: _Contacts) -> IntArray:
    """Order of the contacts by the speed at which they close, then by all their other data."""
    # Where several solutions tie, as those of a symmetric body may, Lemke's rule goes by the rows:
    # without this order the order in which contacts are listed would decide.
    n = problem.floor.size
    coupled = np.abs(problem.delassus).sum(axis=1)
    friction = problem.friction.sum(axis=1)
    known = (
        coupled[n:], coupled[:n], problem.sliding, friction, problem.floor,
        problem.free[n:], problem.free[:n],
    )  # fmt: skip
    order: IntArray = np.lexsort([np.round(each / _ZERO) for each in known])
    return order


def _permuted(problem: _Contacts, order: IntArray) -> _Contacts:
    both = np.append(order, order + order.size)
    return _Contacts(
        delassus=problem.delassus[np.ix_(both, both)],
        free=problem.free[both],
        friction=problem.friction[np.ix_(order, order)],
        floor=problem.floor[order],
        sliding=problem.sliding[order],
        velocity=problem.velocity[both],
        impulse=problem.impulse[both],
    )


def contact_lcp(problem: _Contacts) -> tuple[FloatArray, FloatArray]:
    """Matrix A and vector b of the contact problem as an LCP [Leine2001, Eqs. 4-5].

    There are 3 unknowns for a contact without a given sliding direction, 1 for one that slides; E
    selects the former (columns of I), F >= 0 is the friction matrix, S = diag(s) with s = 1 where
    no direction is given. The derivation follows [Pfeiffer1996, chs. 6-8], where F = diag(mu):

    Normal: P = Lambda_N - floor >= 0 is complementary to gamma_N >= 0.

    Tangential: the law is a step from +F Lambda_N to -F Lambda_N, row by row. It splits into two
    unilateral laws: the friction reserves and the two halves of the velocity,

        Lambda_TR = E^T (F Lambda_N + Lambda_T) >= 0   perp   gamma_T^+ >= 0,
        Lambda_TL = E^T (F Lambda_N - Lambda_T) >= 0   perp   gamma_T^- >= 0,
        E^T gamma_T = gamma_T^+ - gamma_T^-.

    Elimination: Lambda_T = E Lambda_TR - S F Lambda_N holds for both kinds of contact, so

        Lambda = N (P + floor) + T Lambda_TR,   N = [I; -S F],   T = [0; E],

    and Lambda_TL = 2 E^T F (P + floor) - Lambda_TR. With G_N, G_T the upper and lower n rows of
    G, inserting Lambda in gamma = G Lambda + free leaves y = A x + b for

        [gamma_N  ]   [G_N N      G_N T      0] [P        ]   [G_N N floor + free_N        ]
        [gamma_T^+] = [E^T G_T N  E^T G_T T  I] [Lambda_TR] + [E^T (G_T N floor + free_T)  ]
        [Lambda_TL]   [2 E^T F    -I         0] [gamma_T^-]   [2 E^T F floor               ].
    """
    g, friction, n = problem.delassus, problem.friction, problem.floor.size
    undecided = np.flatnonzero(problem.sliding == 0)
    k = undecided.size
    rows = np.append(np.arange(n), n + undecided)  # of G: gamma_N and E^T gamma_T
    to_impulse = np.zeros((2 * n, n + k))  # [N T]
    to_impulse[:n, :n] = np.eye(n)
    to_impulse[n:, :n] = -_signs(problem)[:, None] * friction
    to_impulse[n + undecided, n + np.arange(k)] = 1.0
    reserve = 2.0 * friction[undecided]  # 2 E^T F
    a = np.zeros((n + 2 * k, n + 2 * k))
    a[: n + k, : n + k] = (g @ to_impulse)[rows]
    a[n : n + k, n + k :] = np.eye(k)
    a[n + k :, :n], a[n + k :, n : n + k] = reserve, -np.eye(k)
    start = g @ to_impulse[:, :n] @ problem.floor + problem.free
    return a, np.append(start[rows], reserve @ problem.floor)


def _contact_cover(problem: _Contacts) -> FloatArray:
    """Covering vector d with which the path never ends in a ray if no contact slides already."""
    # Let all s = 0 and d = (1, c, 0) with c > 0 and F^T c < 1: z adds an opening velocity, tilted
    # less than the cones are wide. Let dx, dz >= 0 be the direction of a ray, dLambda its impulses:
    # dLambda_N >= 0 and |dLambda_T| <= F dLambda_N, because z does not enter the reserves, so
    #     sum(dLambda_N + c dLambda_T) >= (1 - F^T c) . dLambda_N >= 0, = 0 only if dLambda = 0.
    # Complementary products vanish along a ray, those of dx with dy and with y. What is left of the
    # friction reserves is dLambda . dgamma = -F dLambda_N . (dgamma_T^+ + dgamma_T^-) <= 0, and
    # dgamma = G dLambda + dz (1, c), so
    #     dLambda . G dLambda + dz sum(dLambda_N + c dLambda_T) <= 0:
    # both terms vanish. If dLambda = 0, gamma_T^+ and gamma_T^- of one contact do not grow together
    # (its reserves sum to a row of 2 F Lambda_N, which the lexicographic order keeps above zero),
    # so z alone grows: the ray on which the path starts. Otherwise dz = 0 and W dLambda = 0; then
    # dLambda . gamma = -F dLambda_N . (gamma_T^+ + gamma_T^-) <= 0 with gamma = G Lambda + W^T u +
    # z (1, c) leaves z sum(dLambda_N + c dLambda_T) <= 0, so z = 0 and the problem is solved. Hence
    # there is a solution for every F >= 0: for Coulomb's law contact by contact and for the sum.
    undecided = problem.sliding == 0
    friction = problem.friction[undecided]
    # c_i = 1 / (1 + the largest column sum that row i takes part in): sum_i c_i F_ij < 1
    largest = np.where(friction > 0.0, friction.sum(axis=0), 0.0).max(axis=1, initial=0.0)
    ahead = 1.0 / (1.0 + largest)
    return np.concatenate([np.ones(problem.floor.size), ahead, np.zeros(ahead.size)])


def _signs(problem: _Contacts) -> FloatArray:
    """Diagonal of S: Lambda_T = Lambda_TR - s F Lambda_N, s = 1 where none is given."""
    return np.where(problem.sliding == 0, 1.0, problem.sliding)


def _read(problem: _Contacts, x: FloatArray, y: FloatArray, status: LcpStatus) -> ContactLcp:
    """Impulses and velocities in SI units from x and y of :func:`contact_lcp`."""
    n = problem.floor.size
    undecided = problem.sliding == 0
    k = int(undecided.sum())
    impulse_n = x[:n] + problem.floor
    impulse_t = -_signs(problem) * (problem.friction @ impulse_n)
    impulse_t[undecided] += x[n : n + k]
    gamma_t = problem.delassus[n:] @ np.append(impulse_n, impulse_t) + problem.free[n:]
    gamma_t[undecided] = y[n : n + k] - x[n + k :]
    return ContactLcp(
        impulse_n=impulse_n * problem.impulse[:n],
        impulse_t=impulse_t * problem.impulse[n:],
        gamma_n=y[:n] * problem.velocity[:n],
        gamma_t=gamma_t * problem.velocity[n:],
        status=status,
    )


def _freeze(result: object, *names: str) -> None:
    """Replace arrays of a frozen dataclass by locked copies."""
    for name in names:
        array = np.array(getattr(result, name), dtype=np.float64)
        array.setflags(write=False)
        object.__setattr__(result, name, array)
