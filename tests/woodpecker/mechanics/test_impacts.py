"""The direct contact solvers against enumeration, closed forms, linear programs and differences."""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
import pytest
from impacts import (
    UNITS,
    approach,
    case_table,
    coupling_of,
    directions,
    frictions,
    laws,
    make_pair,
    random_toy,
    restitutions,
    scenes,
    strike,
)
from lcp_oracles import contact_residual, enumerate_contacts, scene
from scipy.optimize import linprog

from woodpecker import ExpansionFriction, Toy
from woodpecker.base.compiled import COMPILED, jit
from woodpecker.mechanics import equations as mechanics
from woodpecker.mechanics.cases import impulse_of
from woodpecker.mechanics.contact_problems import (
    AMBIGUOUS,
    INDETERMINATE,
    NO_SOLUTION,
    SOLVED,
    one_contact,
    rest_is_possible,
    two_contacts,
)
from woodpecker.mechanics.lcp import ContactLcp, LcpStatus
from woodpecker.mechanics.modes import model

# thousands of calls from here:
one_contact, two_contacts = jit(one_contact), jit(two_contacts)

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

MANY = 2000 if COMPILED else 60  # plain Python is a hundred times slower

# Elimination with condition below 1e4 or so: four digits less than doubles have.
SOLVES = 1e-11
# Lemke breaks ties of 1e-11, hence its residual; see test_lcp.
RESIDUAL = 1e-10
# Closed forms with condition near 1: some roundings of 1e-16.
EXACT = 1e-14

ORDER = {2: [0, 1], 4: [0, 2, 1, 3]}  # (N, T) of each contact in turn <-> normals first


@dataclass(frozen=True, kw_only=True)
class Problem:
    """Data in the order of this module, (N, T) of each contact in turn."""

    delassus: FloatArray
    free: FloatArray
    mu: FloatArray
    floor: FloatArray
    coupling: float = 0.0  # 1: the bound of friction is the sum of both normal impulses

    @property
    def friction(self) -> FloatArray:
        """The matrix F of the bound F Lambda_N."""
        return self.mu[:, None] * np.where(np.eye(len(self.mu)) == 1.0, 1.0, self.coupling)

    @property
    def lcp(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """The same data, normals first."""
        order = ORDER[len(self.free)]
        return self.delassus[np.ix_(order, order)], self.free[order], self.friction, self.floor


@dataclass(frozen=True, kw_only=True)
class Answer:
    outcome: int
    cases: IntArray
    impulse: FloatArray


def solve(problem: Problem) -> Answer:
    n, g = len(problem.mu), problem.delassus
    cases, impulse = np.full((2, n), -1), np.full(2 * n, np.nan)
    if n == 1:
        outcome, cases[:], impulse[0], impulse[1] = one_contact(
            g[0, 0], g[0, 1], g[1, 1], *problem.free, problem.mu[0], problem.floor[0]
        )
        return Answer(outcome=outcome, cases=cases, impulse=impulse)
    feeds, table = np.ones(n, dtype=np.int64), case_table(g, problem.friction)
    outcome = two_contacts(
        table, 0, g, problem.free, problem.mu, problem.coupling, problem.floor, feeds, cases,
        impulse, make_pair(),
    )  # fmt: skip
    return Answer(outcome=outcome, cases=cases, impulse=impulse)


def residual(problem: Problem, impulse: FloatArray) -> float:
    """Violation of the contact laws, read as projections by :mod:`lcp_oracles`."""
    order, n = ORDER[len(problem.free)], len(problem.mu)
    gamma = (problem.delassus @ impulse + problem.free)[order]
    solution = ContactLcp(
        impulse_n=impulse[order][:n],
        impulse_t=impulse[order][n:],
        gamma_n=gamma[:n],
        gamma_t=gamma[n:],
        status=LcpStatus.SOLVED,
    )
    return contact_residual(solution, *problem.lcp)


def distinct(points: list[FloatArray]) -> int:
    kept: list[FloatArray] = []
    for point in points:
        # Enumerated solutions are good to 1e-9; different ones differ by whole numbers' ratios.
        if all(np.abs(point - other).max() > 1e-6 for other in kept):
            kept.append(point)
    return len(kept)


def expected_outcome(problem: Problem) -> int:
    """From all solutions that brute force finds: do velocities, do normal impulses differ?"""
    every = enumerate_contacts(*problem.lcp)
    if not every:
        return NO_SOLUTION
    if distinct([np.append(each.gamma_n, each.gamma_t) for each in every]) > 1:
        return AMBIGUOUS
    return SOLVED if distinct([each.impulse_n for each in every]) == 1 else INDETERMINATE


def random_problem(rng: np.random.Generator, n: int, coupling: float = 0.0) -> Problem:
    """A body with n contacts, in compression or expansion."""
    s, order = scene(rng, n, 2 * n + 1), ORDER[2 * n]
    delassus, free = s.delassus[np.ix_(order, order)], s.free[order]
    floor = rng.uniform(0.0, 2.0, size=n) * np.abs(free / np.diag(delassus))[::2]
    floor *= rng.random() < 0.5
    return Problem(delassus=delassus, free=free, mu=s.mu, floor=floor, coupling=coupling)


def integer_problem(
    rng: np.random.Generator, n: int, freedoms: int, coupling: float = 0.0
) -> Problem:
    """Small integers: velocities that are zero, forces on the cone, singular combinations."""
    while True:
        w = rng.integers(-2, 3, size=(freedoms, 2 * n)).astype(float)
        delassus = w.T @ w
        pairs = [delassus[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] for k in range(n)]
        if all(np.linalg.det(pair) > 0.5 for pair in pairs):
            break
    return Problem(
        delassus=delassus,
        free=w.T @ rng.integers(-1, 2, size=freedoms),
        mu=rng.choice([0.0, 0.5, 1.0], size=n),
        floor=rng.choice([0.0, 0.0, 1.0], size=n),
        coupling=coupling,
    )


# --- Against enumeration --------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("coupling", [0.0, 1.0])
@pytest.mark.parametrize(("n", "freedoms"), [(1, 0), (2, 0), (1, 2), (2, 3), (2, 4), (2, 5)])
def test_random_problems_have_the_outcome_of_brute_force(
    n: int, freedoms: int, coupling: float
) -> None:
    """Of bodies (0 freedoms), where there is always a solution, and of small integers.

    The toy has 4 impulses for 3 freedoms: its indeterminate problems are among the integers.
    """
    rng, outcomes = np.random.default_rng(10 * n + freedoms), []
    for _ in range(MANY // 5):
        problem = (
            integer_problem(rng, n, freedoms, coupling)
            if freedoms
            else random_problem(rng, n, coupling)
        )
        answer = solve(problem)
        outcomes.append(answer.outcome)
        assert answer.outcome == expected_outcome(problem)
        if answer.outcome in (SOLVED, INDETERMINATE):
            assert residual(problem, answer.impulse) < SOLVES
    if not freedoms:
        assert outcomes.count(SOLVED) > 0.9 * len(outcomes)
        assert NO_SOLUTION not in outcomes
    if COMPILED:  # otherwise the sample is small
        assert (INDETERMINATE in outcomes) == (0 < freedoms < 5 and n == 2)


# --- Impacts of the toy ---------------------------------------------------------------------------


def compression(toy: Toy, contacts: tuple[int, ...], u: npt.ArrayLike) -> Problem:
    """The first phase of an impact of the toy."""
    w, mu = directions(toy, contacts), frictions(toy, contacts)
    delassus = w.T @ np.linalg.solve(mechanics.mass_matrix(toy), w)
    return Problem(delassus=delassus, free=w.T @ u, mu=mu, floor=0.0 * mu)


@pytest.mark.parametrize(
    ("contacts", "u"),
    [((0,), [-0.1, 14.5, 0.0]), ((0, 1), [-0.1, -1.9, 11.2]), ((0, 2), [0.4, 5.7, 8.1])],
)
def test_an_impact_with_much_friction_is_ambiguous(
    contacts: tuple[int, ...], u: list[float]
) -> None:
    """mu = 3: compression has several answers, and brute force sees them, too."""
    toy = Toy(mu_1=3.0, mu_2=3.0, mu_3=3.0)
    assert expected_outcome(compression(toy, contacts, u)) == AMBIGUOUS
    assert strike(toy, contacts, u).outcome == AMBIGUOUS


@pytest.mark.slow
@laws
@scenes
def test_both_phases_satisfy_the_contact_laws(
    contacts: tuple[int, ...], law: ExpansionFriction
) -> None:
    """Compression with floor 0, expansion with floor eps_N Lambda_NC; read as projections."""
    rng = np.random.default_rng(21)
    for _ in range(MANY // 10):
        toy, u = random_toy(rng, 0.4, law), approach(rng, contacts)
        blow, first = strike(toy, contacts, u), compression(toy, contacts, u)
        assert blow.outcome in (SOLVED, INDETERMINATE)
        pressed, released = blow.impulses[:, : len(first.free)]
        assert residual(first, pressed) < SOLVES
        between = first.delassus @ pressed + first.free
        # Velocities that the compression made zero are so up to rounding of the largest one.
        between[np.abs(between) < SOLVES * np.abs(first.free).max()] = 0.0
        floor = restitutions(toy, contacts) * pressed[::2]
        expansion = replace(
            first, free=between, floor=floor, coupling=coupling_of(toy, contacts)
        )  # fmt: skip
        assert residual(expansion, released) < RESIDUAL


@pytest.mark.parametrize("i", [0, 1, 2])
@pytest.mark.parametrize("eps", [0.0, 0.3, 1.0])
def test_one_contact_without_friction_reflects(i: int, eps: float) -> None:
    """g_N' after = -eps_N g_N' before, and the energy lost is (1 - eps^2) g_N'^2 / (2 G_NN)."""
    rng = np.random.default_rng(22)
    toy = Toy(mu_1=0, mu_2=0, mu_3=0, eps_n1=eps, eps_n2=eps, eps_n3=eps)
    mass, w = np.array(mechanics.mass_matrix(toy)), directions(toy, (i,))[:, 0]
    g_nn = w @ np.linalg.solve(mass, w)
    for _ in range(50):
        u = approach(rng, (i,))
        after = strike(toy, (i,), u).u
        np.testing.assert_allclose(w @ after, -eps * (w @ u), rtol=SOLVES)
        before, left = 0.5 * u @ mass @ u, 0.5 * after @ mass @ after
        lost = (1.0 - eps**2) * (w @ u) ** 2 / (2.0 * g_nn)
        np.testing.assert_allclose(before - left, lost, rtol=0.0, atol=SOLVES * before)


# --- Indeterminate impulses -----------------------------------------------------------------------


def lawful_forces(
    toy: Toy, pair: tuple[int, ...], load: FloatArray, cost: npt.ArrayLike = (0, 0, 0, 0)
) -> FloatArray | None:
    """Linear program: W lambda = load with lambda in both cones, and cost . lambda the least."""
    units, mu = np.array([1.0, toy.h_m, toy.h_s]), frictions(toy, pair)  # rows in N or N s
    scale = np.abs(load / units).max()
    cones = [[-mu[0], s, 0, 0] for s in (1, -1)] + [[0, 0, -mu[1], s] for s in (1, -1)]
    result = linprog(
        cost, A_ub=cones, b_ub=np.zeros(4), A_eq=directions(toy, pair) / units[:, None],
        b_eq=load / units / scale, bounds=(None, None),
    )  # fmt: skip
    return np.asarray(result.x * scale) if result.success else None


# The upper edge of the sleeve rests on the pole while the beak strikes; all comes to rest.
ALL_AT_REST = np.array([-0.1727, 0.0, 16.4])
BOTH = (0, 2)


def wedge(toy: Toy) -> Problem:
    """Compression at beak and upper sleeve contact from ALL_AT_REST."""
    return compression(toy, BOTH, ALL_AT_REST)


@pytest.mark.slow
def test_the_segment_of_indeterminate_impulses() -> None:
    """Its ends are those of a linear program; the middle is taken; all of it is lawful."""
    toy = Toy(eps_n1=0.79)
    problem = wedge(toy)
    answer = solve(problem)
    assert answer.outcome == INDETERMINATE
    ends = np.zeros((2, 4))
    table = case_table(problem.delassus, problem.friction)
    for case, end in zip(answer.cases, ends, strict=True):
        impulse_of(table, case[0] + 6 * case[1], problem.free, problem.floor, end)
    ends = ends[np.argsort(ends[:, 0])]
    load = -np.array(mechanics.mass_matrix(toy)) @ ALL_AT_REST
    expected = [lawful_forces(toy, BOTH, load, (cost, 0, 0, 0)) for cost in (1.0, -1.0)]
    # linprog's own feasibility is 1e-7, in units of the load.
    np.testing.assert_allclose(ends, expected, rtol=0.0, atol=1e-6 * np.abs(ends).max())
    assert ends[1, 0] > 1.005 * ends[0, 0]  # a segment, not a point
    np.testing.assert_allclose(answer.impulse, ends.mean(axis=0), rtol=EXACT)
    for part in (0.0, 0.3, 0.5, 1.0):
        assert residual(problem, (1.0 - part) * ends[0] + part * ends[1]) < SOLVES


@laws
def test_an_indeterminate_impact_goes_on_from_the_middle(law: ExpansionFriction) -> None:
    """The expansion from that middle has one solution, under both laws."""
    toy = Toy(eps_n1=0.79, expansion_friction=law)
    blow = strike(toy, BOTH, ALL_AT_REST)
    assert blow.outcome == INDETERMINATE
    middle = solve(wedge(toy)).impulse
    # The table of the modes and numpy round G differently, amplified by its condition.
    np.testing.assert_allclose(blow.impulses[0], middle, rtol=SOLVES)
    # The beak expands with eps_N1 of the middle; the sleeve has eps_N3 = 0.
    assert blow.impulses[1, 0] == pytest.approx(0.79 * blow.impulses[0, 0], rel=EXACT)
    mass, w = np.array(mechanics.mass_matrix(toy)), directions(toy, BOTH)
    floor = np.array([0.79, 0.0]) * middle[::2]
    expansion = replace(
        wedge(toy), free=np.zeros(4), floor=floor, coupling=coupling_of(toy, BOTH)
    )  # fmt: skip
    assert expected_outcome(expansion) == SOLVED
    assert residual(expansion, blow.impulses[1]) < RESIDUAL
    balance = mass @ (blow.u - ALL_AT_REST) - w @ blow.impulses.sum(axis=0)
    assert (np.abs(balance) <= SOLVES * np.abs(mass) @ np.abs(ALL_AT_REST)).all()


def test_without_expansion_the_impulses_do_not_matter() -> None:
    blow = strike(Toy(eps_n1=0.0), BOTH, ALL_AT_REST)
    assert blow.outcome == SOLVED
    assert blow.u.tolist() == [0.0, 0.0, 0.0]


@laws
def test_derivative_of_an_indeterminate_impact(law: ExpansionFriction) -> None:
    """The middle moves with half of each end, linearly in u, and eps_N1 scales the expansion."""
    step, toy = 1e-4, Toy(eps_n1=0.79, expansion_friction=law)
    for du, seed in ((UNITS * [1.0, 0.0, 1.0], np.zeros(3)), (np.zeros(3), np.eye(3)[0])):
        blow = strike(toy, BOTH, ALL_AT_REST, du, seed)
        sides = [
            strike(toy.replace(eps_n1=0.79 + s * seed[0]), BOTH, ALL_AT_REST + s * du)
            for s in (step, -step)
        ]
        slope = (sides[0].u - sides[1].u) / (2.0 * step)
        # Rounding of u over the step.
        np.testing.assert_allclose(blow.tangents[0] / UNITS, slope / UNITS, atol=1e-9)


# --- Rest on two contacts -------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    ("k", "mu_max", "stretch", "share"),
    [(1, 1.0, (-1.5, 1.5), 0.3), (2, 2.0, (-10.0, 0.0), 0.05)],  # contact 3 needs huge friction
)
def test_rest_is_possible_as_a_linear_program_says(
    k: int, mu_max: float, stretch: tuple[float, float], share: float
) -> None:
    """Random stretches and frictions; nothing within 1e-7, linprog's tolerance, of a boundary."""
    rng, verdicts = np.random.default_rng(30 + k), []
    for _ in range(300):
        mu = 10.0 ** rng.uniform(-1.5, mu_max, size=3)
        toy, d = Toy(mu_1=mu[0], mu_2=mu[1], mu_3=mu[2]), rng.uniform(*stretch)
        verdicts.append(rest_is_possible(model(toy), k, d))
        h_0, h_1 = mechanics.force_at_rest(toy), mechanics.force_per_stretch(toy)
        load = -np.array(h_0) - np.array(h_1) * d
        assert verdicts[-1] == (lawful_forces(toy, (0, k), load) is not None)
    assert share < np.mean(verdicts) < 1.0 - share


def test_rest_without_friction_is_impossible() -> None:
    """Nothing carries the weight, whatever the spring does."""
    numbers = model(Toy(mu_1=0.0, mu_2=0.0, mu_3=0.0))
    assert not any(rest_is_possible(numbers, k, d) for k in (1, 2) for d in (-0.3, 0.0, 0.1, 0.5))
