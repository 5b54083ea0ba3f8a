"""Lemke against brute force and closed forms; contact laws of one to three contacts."""

import math
from collections.abc import Callable, Iterator

import hypothesis.strategies as st
import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from lcp_oracles import contact_residual, enumerate_contacts, enumerate_lcp, matrices, scene
from thoroughness import thorough

from woodpecker.mechanics.lcp import ContactLcp, LcpStatus, lemke, solve_contact_lcp

FloatArray = npt.NDArray[np.float64]

# Ties closer than 1e-11 are broken as if exact, so a solution may miss by that; a margin of 10.
RESIDUAL = 1e-10
# Unique solutions of problems with condition below 1e4, each found with RESIDUAL or better.
SAME = 1e-6
# Closed forms with condition near 1: some roundings of 1e-16.
EXACT = 1e-13


def violation(a: FloatArray, b: FloatArray, x: FloatArray) -> float:
    """|min(x, A x + b)|, which is 0 at solutions only, relative to the terms it is made of."""
    scale = max(1.0, float(np.abs(b).max()), float((np.abs(a) @ np.abs(x)).max()))
    return float(np.abs(np.minimum(x, a @ x + b)).max()) / scale


# --- Lemke against enumeration -------------------------------------------------------------------


def p_matrix(rng: np.random.Generator, n: int) -> FloatArray:
    """Positive definite with a skew part: all principal minors are positive."""
    root, skew = rng.normal(size=(2, n, n))
    return np.asarray(root @ root.T + 0.1 * np.eye(n) + skew - skew.T)


def semidefinite(rng: np.random.Generator, n: int) -> FloatArray:
    """Integer Gram matrix, rank-deficient, so that singular bases are exactly singular."""
    root = rng.integers(-2, 3, size=(n, max(1, n - 1))).astype(float)
    return np.asarray(root @ root.T)


def copositive(rng: np.random.Generator, n: int) -> FloatArray:
    """Nonnegative plus skew: x.A x >= 0 for x >= 0, with a positive diagonal."""
    skew = rng.integers(-2, 3, size=(n, n))
    return (rng.integers(0, 3, size=(n, n)) + np.eye(n) + skew - skew.T).astype(float)


def anything(rng: np.random.Generator, n: int) -> FloatArray:
    return rng.integers(-2, 3, size=(n, n)).astype(float)


def smooth(rng: np.random.Generator, n: int) -> FloatArray:
    return rng.normal(size=n)


def zeros_and_ties(rng: np.random.Generator, n: int) -> FloatArray:
    return rng.integers(-1, 2, size=n).astype(float)


Make = Callable[[np.random.Generator, int], FloatArray]


@pytest.mark.slow
@pytest.mark.parametrize("right", [smooth, zeros_and_ties])
@pytest.mark.parametrize("matrix", [p_matrix, semidefinite, copositive, anything])
def test_lemke_agrees_with_enumeration(matrix: Make, right: Make) -> None:
    """A result satisfies the problem, and there is one where there is a solution.

    Not so for the last matrices: P-matrices have just one solution, a ray proves that a
    semidefinite problem has none, and strictly copositive ones always have one.
    """
    rng = np.random.default_rng(2)
    statuses = []
    for _ in range(400):
        n = int(rng.integers(1, 6))
        a, b = matrix(rng, n), right(rng, n)
        result, solutions = lemke(a, b), enumerate_lcp(a, b)
        statuses.append(result.status)
        for x in solutions:
            # 1e-9 is what the enumeration itself allows, in scaled units; a margin of 10.
            assert violation(a, b, x) < 1e-8
        if result.success:
            assert violation(a, b, result.x) < RESIDUAL
            assert (np.minimum(result.x, result.y) == 0.0).all()  # complementary without rounding
        assert result.success == bool(solutions) or (matrix is anything and solutions)
        assert matrix is not p_matrix or len(solutions) == 1
    assert statuses.count(LcpStatus.SOLVED) > 100  # the sample is not vacuous
    assert (statuses.count(LcpStatus.RAY) > 20) == (matrix in (semidefinite, anything))
    assert LcpStatus.PIVOT_LIMIT not in statuses


@pytest.mark.slow
@thorough(200)
@given(st.integers(0, 2**32 - 1), st.integers(1, 5))
def test_units_do_not_matter(seed: int, n: int) -> None:
    """Rows in other units, columns in other units, and b a thousand times larger."""
    rng = np.random.default_rng(seed)
    a, b = p_matrix(rng, n), smooth(rng, n)
    row, column = 10.0 ** rng.uniform(-6, 6, size=(2, n))
    expected = lemke(a, b)
    result = lemke(row[:, None] * a * column, 1e3 * row * b)
    assert result.success
    scale = np.abs(expected.x).max(initial=1.0)
    np.testing.assert_allclose(result.x * column / 1e3, expected.x, atol=SAME * scale)
    np.testing.assert_allclose(result.y / row / 1e3, expected.y, atol=SAME * scale)


def test_small_units_are_not_zeros() -> None:
    np.testing.assert_allclose(lemke([[1e-14]], [-1e-14]).x, 1.0, rtol=EXACT)
    np.testing.assert_allclose(lemke([[1e14]], [-1e-14]).x, 1e-28, rtol=EXACT)


# --- Classical problems --------------------------------------------------------------------------


KOSTREVA = np.array([[1.0, 2.0, 0.0], [0.0, 1.0, 2.0], [2.0, 0.0, 1.0]])


@pytest.mark.parametrize("a", [KOSTREVA, KOSTREVA.T], ids=["a", "transposed"])
def test_no_basis_recurs_where_all_ratios_are_tied(a: FloatArray) -> None:
    """Kostreva's matrix: to take the first of ties goes round, or, of the transposed, the last."""
    result = lemke(a, -np.ones(3))
    assert result.pivots <= 8  # there are only 8 complementary bases
    np.testing.assert_allclose(result.x, 1.0 / 3.0, rtol=EXACT)


@pytest.mark.parametrize("n", [1, 4, 10])
def test_murty_problem_of_exponential_length(n: int) -> None:
    """Unit triangular with twos below and b = -1: x = (1, 0, ..., 0) after 2^n pivots."""
    a, b = np.eye(n) + 2.0 * np.tril(np.ones((n, n)), -1), -np.ones(n)
    result = lemke(a, b, max_pivots=2**n)
    assert result.success
    assert result.pivots == 2**n
    np.testing.assert_allclose(result.x, np.eye(n)[0], atol=EXACT)
    stopped = lemke(a, b, max_pivots=2**n - 1)
    assert (stopped.status, stopped.pivots) == (LcpStatus.PIVOT_LIMIT, 2**n - 1)
    assert np.isnan(stopped.x).all()


@pytest.mark.parametrize(
    ("a", "b"),
    [
        ([[0.0]], [-1.0]),
        ([[-1.0]], [-1.0]),
        ([[1.0, -1.0], [-1.0, 1.0]], [-1.0, 0.0]),  # two masses pushed by one force
        ([[0.0, 1.0], [-1.0, 0.0]], [1.0, -1.0]),  # F x <= h without a point
    ],
)
def test_infeasible_problems_end_in_a_ray(a: list[list[float]], b: list[float]) -> None:
    result = lemke(a, b)
    assert result.status is LcpStatus.RAY
    assert not result.success
    assert np.isnan(result.x).all()
    assert np.isnan(result.y).all()
    assert enumerate_lcp(a, b) == []


def test_a_ray_is_no_proof_in_general() -> None:
    """Here x = (1, 1) solves, but the path escapes: A is not copositive plus."""
    a, b = np.array([[0.0, 1.0], [1.0, 0.0]]), -np.ones(2)
    assert lemke(a, b).status is LcpStatus.RAY
    (only,) = enumerate_lcp(a, b)
    np.testing.assert_allclose(only, [1.0, 1.0], atol=EXACT)


def test_the_empty_problem_is_solved() -> None:
    assert lemke(np.zeros((0, 0)), []).success
    assert len(enumerate_lcp(np.zeros((0, 0)), [])) == 1
    assert solve_contact_lcp(np.zeros((0, 0)), [], 0.3).success


# --- Contact problems ----------------------------------------------------------------------------


def hard_scenes() -> Iterator[tuple[FloatArray, FloatArray, FloatArray]]:
    """Scenes that end in a ray, or leave the basis otherwise, with a simpler covering vector."""
    for seed in (359, 363, 1240, 5974):  # mu up to 7.5: covered with c mu > 1, each is a ray
        s = scene(np.random.default_rng(seed), 2, 5)
        yield s.delassus, s.free, 5.0 * s.mu
    # G of rank 2 or 4 of 6: the covering variable reaches zero without leaving the basis
    for seed, freedoms in ((369, 2), (608, 4), (687, 2), (3465, 2)):
        s = scene(np.random.default_rng(seed), 3, freedoms)
        yield s.delassus, s.free, s.mu
    # F up to 40 off the diagonal: covered with c_i F_ii < 1 alone, each is a ray
    for seed in (4, 57, 186, 199, 279, 339, 413, 469):
        rng = np.random.default_rng(seed)
        s = scene(rng, 2, int(rng.integers(2, 6)))
        size = np.array([[8.0, 40.0], [40.0, 8.0]])
        yield s.delassus, s.free, size * rng.uniform(size=(2, 2)) * (rng.random((2, 2)) < 0.7)
    # Opposite normals, one mass: any preload solves; the path finds one without a fault.
    w = np.array([[1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1.0]])
    yield w.T @ w, w.T @ np.array([0.0, -1.0]), np.array([0.5, 0.5])


@pytest.mark.parametrize(("g", "free", "friction"), list(hard_scenes()))
def test_hard_scenes_do_not_end_in_a_ray(
    g: FloatArray, free: FloatArray, friction: FloatArray
) -> None:
    result = solve_contact_lcp(g, free, friction)
    assert contact_residual(result, g, free, friction) < RESIDUAL


# --- A full friction matrix: the bound F Lambda_N ------------------------------------------------


FRICTION: dict[str, Callable[[np.random.Generator, FloatArray], FloatArray]] = {
    "separate": lambda rng, mu: mu,
    "summed": lambda rng, mu: np.outer(mu, np.ones(len(mu))),
    "any": lambda rng, mu: rng.uniform(-0.5, 3.0, (len(mu), len(mu))).clip(0.0),
}


@pytest.mark.slow
@thorough(200)
@given(
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(1, 3),
    freedoms=st.integers(2, 7),
    eps_n=st.floats(0.01, 1.0),  # at 0 all may be at rest, and free is nothing but rounding
    law=st.sampled_from(sorted(FRICTION)),
)
def test_compression_and_expansion_satisfy_the_laws(
    seed: int, n: int, freedoms: int, eps_n: float, law: str
) -> None:
    """Both phases always have a solution, G singular or not, and the path leads to one."""
    rng = np.random.default_rng(seed)
    s = scene(rng, n, freedoms)
    friction = FRICTION[law](rng, s.mu)
    pressed = solve_contact_lcp(s.delassus, s.free, friction)
    assert pressed.status is LcpStatus.SOLVED
    assert contact_residual(pressed, s.delassus, s.free, friction) < RESIDUAL
    between = np.append(pressed.gamma_n, pressed.gamma_t)
    floor = eps_n * pressed.impulse_n
    released = solve_contact_lcp(s.delassus, between, friction, floor)
    assert released.status is LcpStatus.SOLVED
    assert contact_residual(released, s.delassus, between, friction, floor) < RESIDUAL


@pytest.mark.parametrize("sliding", [0, 1])
def test_a_vector_of_friction_is_a_diagonal_matrix(sliding: int) -> None:
    """To the last bit, in all that takes friction."""
    s = scene(np.random.default_rng(45), 3, 7)
    both = [(s.delassus, s.free, mu, 0.1, sliding) for mu in (s.mu, np.diag(s.mu))]
    for one, other in zip(*(matrices(*arguments) for arguments in both), strict=True):
        assert (one == other).all()
    one, other = (solve_contact_lcp(*arguments) for arguments in both)
    assert (one.impulse_n == other.impulse_n).all()
    assert (one.impulse_t == other.impulse_t).all()
    assert contact_residual(one, *both[0]) == contact_residual(one, *both[1]) < RESIDUAL


# --- Painleve: no solution, several solutions ----------------------------------------------------


def rod(tangent: float) -> FloatArray:
    """G of the tip of a homogeneous rod of unit mass, inclined by ``tangent`` = tan(theta)."""
    sin, cos = math.sin(math.atan(tangent)), math.cos(math.atan(tangent))
    coupling = -3.0 * sin * cos
    return np.array([[1.0 + 3.0 * cos * cos, coupling], [coupling, 1.0 + 3.0 * sin * sin]])


PAINLEVE = {  # G, free, direction of sliding, at mu = 2; (Lambda_N, Lambda_T) of all lawful answers
    # tan(theta) = 2, G_NN + mu G_NT = -0.8: pressed and sliding into the ground
    "none": (rod(2.0), [-9.81, 0.0], -1, []),
    # pulled upward it may separate, or press with 9.81 / 0.8
    "two": (rod(2.0), [9.81, 0.0], -1, [(0.0, 0.0), (9.81 / 0.8, 9.81 / 0.4)]),
    # Separation, slip backward: Lambda_N = 1 / 0.8. Stick: -G^-1 (1, -8), and 2.9 < 2 * 1.55.
    "three": (rod(2.0), [1.0, -8.0], 0, [(0.0, 0.0), (1.25, 2.5), (1.55, 2.9)]),
    # G_NN + mu G_NT = 0: no force can stop it, and a weightless contact leaves it open
    "border": (np.array([[1.0, -0.5], [-0.5, 1.0]]), [-1.0, 0.0], -1, []),
    "weightless": (np.array([[1.0, -0.5], [-0.5, 1.0]]), [0.0, 0.0], -1, [(0.0, 0.0)]),
}


@pytest.mark.parametrize(("g", "free", "sliding", "lawful"), PAINLEVE.values(), ids=PAINLEVE)
def test_answers_beyond_the_critical_friction(
    g: FloatArray, free: list[float], sliding: int, lawful: list[tuple[float, float]]
) -> None:
    found = enumerate_contacts(g, free, 2.0, sliding=sliding)
    impulses = sorted((float(each.impulse_n[0]), float(each.impulse_t[0])) for each in found)
    assert len(impulses) == len(lawful)
    np.testing.assert_allclose(impulses, lawful, rtol=1e-12)  # 0.8 = difference of 1.6
    result = solve_contact_lcp(g, free, 2.0, sliding=sliding)
    if lawful:
        found.append(result)
    else:
        assert result.status is LcpStatus.RAY
        assert not result.success
        assert np.isnan(result.impulse_n).all()
        assert math.isnan(contact_residual(result, g, free, 2.0, sliding=sliding))
    for each in found:
        assert contact_residual(each, g, free, 2.0, sliding=sliding) < RESIDUAL


# --- Degenerate contact problems -----------------------------------------------------------------

ONE = np.array([[2.0, 0.5], [0.5, 1.0]])  # G of one contact, coupled, 1/kg


def test_the_order_of_contacts_does_not_choose_among_solutions() -> None:
    """Five contacts with directions of whole numbers tie: by their order some moved otherwise."""
    rng, n = np.random.default_rng(0), 5
    for _ in range(200):
        w = rng.integers(-1, 2, size=(2 * n, dof := int(rng.integers(3, 9)))).astype(float)
        w[np.arange(2 * n), rng.integers(0, dof, 2 * n)] = 1.0
        g, free, mu = w @ w.T, w @ rng.integers(-2, 3, size=dof), float(rng.choice([0.5, 1.0, 2.0]))
        found = solve_contact_lcp(g, free, mu)
        for _ in range(3):
            order = rng.permutation(n)
            both = np.append(order, order + n)
            other = solve_contact_lcp(g[np.ix_(both, both)], free[both], mu)
            assert other.gamma_n == pytest.approx(found.gamma_n[order], abs=SAME)
            assert other.gamma_t == pytest.approx(found.gamma_t[order], abs=SAME)


def test_zero_approach_velocity_needs_no_impulse() -> None:
    for free in ([0.0, 1.0], [0.0, -1.0], [0.0, 0.0]):
        result = solve_contact_lcp(ONE, free, 0.3)
        assert (result.impulse_n[0], result.impulse_t[0], result.gamma_n[0]) == (0.0, 0.0, 0.0)
        assert result.gamma_t[0] == free[1]


@pytest.mark.parametrize("shift", [-1e-16, 0.0, 1e-16])
def test_friction_exactly_on_the_cone(shift: float) -> None:
    """The sticking impulse (4, -2) needs mu = 1/2 exactly: stick and slip coincide."""
    result = solve_contact_lcp(ONE, [-7.0, 0.0], 0.5 + shift)
    np.testing.assert_allclose([*result.impulse_n, *result.impulse_t], [4.0, -2.0], rtol=1e-12)
    np.testing.assert_allclose(result.gamma_t, 0.0, atol=10.0 * RESIDUAL)  # a tie up to 1e-11
    assert len(enumerate_contacts(ONE, [-7.0, 0.0], 0.5)) == 1


# --- The residual and the arguments --------------------------------------------------------------

LAWFUL = [4.0, -2.0], [0.0, 0.0]  # impulses and velocities (N, T) of ONE and free (-7, 0), mu 0.6


@pytest.mark.parametrize(
    ("impulse", "gamma", "change"),
    [
        ([-1.0, 0.0], [-2.0, -0.5], {}),  # Lambda_N < 0
        ([0.0, 0.0], [-7.0, 0.0], {}),  # gamma_N < 0
        ([5.0, -2.5], [1.75, 0.0], {}),  # Lambda_N gamma_N > 0
        ([3.5, 0.0], [0.0, 1.75], {}),  # sliding without friction
        ([4.0, -2.0], [0.0, 1.0], {}),  # velocities of another motion
        (*LAWFUL, {"mu": 0.4}),
        (*LAWFUL, {"floor": 5.0}),
        (*LAWFUL, {"sliding": -1}),
    ],
)
def test_the_residual_sees_each_violation(
    impulse: list[float], gamma: list[float], change: dict[str, float]
) -> None:
    def off(impulse: list[float], gamma: list[float], **change: float) -> float:
        parts = (np.array([each]) for each in (*impulse, *gamma))
        names = "impulse_n", "impulse_t", "gamma_n", "gamma_t"
        found = ContactLcp(status=LcpStatus.SOLVED, **dict(zip(names, parts, strict=True)))
        return contact_residual(found, ONE, [-7.0, 0.0], **({"mu": 0.6} | change))  # type: ignore[arg-type]

    assert off(*LAWFUL) < RESIDUAL
    assert off(impulse, gamma, **change) > 0.05


USUAL = {"delassus": ONE, "free": [-1.0, 0.0], "mu": 0.3}
WRONG: list[tuple[Callable[..., object], dict[str, object], str]] = [
    *((solver, data, message)
      for solver in (lemke, enumerate_lcp)
      for data, message in (
          ({"a": [[1.0, 2.0]], "b": [1.0]}, r"\(1, 2\) and \(1,\)"),
          ({"a": [[math.nan]], "b": [1.0]}, "finite"),
          ({"a": [[1.0]], "b": [math.inf]}, "finite"),
      )),
    *((lemke, {"a": np.eye(2), "b": [-1.0, 1.0], "cover": cover}, "cover must be")
      for cover in ([0.0, 1.0], [-1.0, 1.0], [1.0])),
    *((solve_contact_lcp, USUAL | changes, message)
      for changes, message in (
          ({"mu": -0.1}, "mu must be"),
          ({"floor": math.nan}, "floor must be"),
          ({"sliding": 2}, "sliding must be -1, 0 or"),
          ({"mu": [0.1, 0.2]}, "broadcast|shape"),
          ({"mu": [[-0.1]]}, "mu must be"),
          ({"mu": [[0.1, 0.2]]}, r"mu must have shape \(\), \(1,\) or \(1, 1\), got \(1, 2\)"),
          ({"mu": [[0.1]], "delassus": np.eye(4), "free": np.ones(4)}, r"or \(2, 2\), got \(1, 1"),
          ({"delassus": np.eye(3), "free": np.ones(3)}, "normal and a tangential entry"),
          ({"free": np.ones(3)}, "expected shapes"),
      )),
]  # fmt: skip


@pytest.mark.parametrize(("solver", "data", "message"), WRONG)
def test_wrong_data_raise(
    solver: Callable[..., object], data: dict[str, object], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        solver(**data)
