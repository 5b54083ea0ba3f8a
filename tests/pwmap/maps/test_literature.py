"""Exact results of pwmap against closed forms of piecewise-linear maps from the literature.

Every closed form is derived in the docstring of its test.
"""

from fractions import Fraction
from functools import cache
from math import gcd

import pytest
import sympy
from sympy import FiniteSet, Interval, Rational, oo, sqrt

from pwmap import (
    Branch,
    BranchKind,
    Diagram,
    ParameterCells,
    PiecewiseLinearMap,
    PointKind,
    SpecialPoint,
    bifurcation_diagram,
    parameter_cells,
)

A, B, D, M, R, S = sympy.symbols("a b d m r s")
GOLDEN = (1 + sqrt(5)) / 2

# --- Reading maps and diagrams --------------------------------------------------------------------


def points_of(map_: PiecewiseLinearMap, period: int) -> dict[str, tuple[sympy.Expr, ...]]:
    """All cycles of a minimal period, by their words."""
    return {cycle.word: cycle.points for cycle in map_.cycles(period)}


def existence(diagram: Diagram) -> dict[str, sympy.Set]:
    """For each cycle, by its first word, the values of the parameter at which it exists."""
    found: dict[str, sympy.Set] = {}
    for branch in diagram.branches:
        word = branch.word
        first = min(word[i:] + word[:i] for i in range(len(word)))
        if branch.kind is BranchKind.FIXED_POINT and word == first:
            interval = interval_of(branch)
            found[word] = sympy.Union(found.get(word, sympy.EmptySet), interval)
    return found


def interval_of(branch: Branch) -> sympy.Set:
    """The exact values of the parameter at which a branch exists."""
    interval = branch.exact["interval"]
    assert isinstance(interval, sympy.Set)
    return interval


def point_at(diagram: Diagram, parameter: object, x: object) -> SpecialPoint:
    """The one special point at an exact place."""
    (found,) = (p for p in diagram.points if p.exact == {"parameter": parameter, "x": x})
    return found


def code(point: SpecialPoint) -> tuple[PointKind, str, int]:
    """Kind, note and order."""
    return point.kind, point.note, point.order


def equal(first: object, second: object) -> bool:
    """Whether two expressions are the same rational function."""
    return bool(sympy.cancel(sympy.sympify(first) - sympy.sympify(second)) == 0)


def words_at(diagram: Diagram, parameter: object, *, stable: bool | None = None) -> set[str]:
    """Words of the branches of fixed points that exist at a value of the parameter."""
    return {
        branch.word
        for branch in diagram.branches
        if branch.kind is BranchKind.FIXED_POINT
        and parameter in interval_of(branch)
        and (stable is None or bool(branch.stable.all()) is stable)
    }


def fixed_branches(diagram: Diagram) -> dict[str, tuple[object, object, sympy.Set, bool]]:
    """Place, multiplier, interval and stability of all branches of fixed points, by their words."""
    found = {}
    for branch in diagram.branches:
        if branch.kind is BranchKind.FIXED_POINT:
            (stable,) = set(branch.stable.tolist())
            formulas = (sympy.factor(branch.exact[name]) for name in ("x", "multiplier"))
            found[branch.word] = (*formulas, interval_of(branch), stable)
    return found


# --- 1. The skew tent map -------------------------------------------------------------------------

SKEW = PiecewiseLinearMap([("a*x + m", "x <= 0"), ("b*x + m", "x > 0")])
SLOPES = [Rational(1, 4), Rational(1, 3), Rational(1, 2), Rational(3, 4)]


def geometric(a: sympy.Expr, n: int) -> sympy.Expr:
    """1 + a + ... + a^(n-1)."""
    return sympy.Add(*(a**i for i in range(n)))


@cache
def skew_tent_over_b(a: sympy.Rational) -> Diagram:
    map_ = SKEW.at({"a": a, "m": 1})
    return bifurcation_diagram(map_, "b", (-300, -Rational(1, 2)), orders=range(1, 6))


@pytest.mark.nightly
@pytest.mark.parametrize("n", [2, 3, 4, 5])
@pytest.mark.parametrize("a", SLOPES)
def test_existence_and_stability_of_the_skew_tent_cycles(a: sympy.Rational, n: int) -> None:
    """Cycles R L^(n-1) of a x + 1 | b x + 1, 0 < a < 1, b < -1 [Maistrenko1993, NusseYorke1995].

    With S_k = 1 + a + ... + a^(k-1) the point x_0 > 0 returns after one step on the right and n - 1
    on the left as a^(n-1) (b x_0 + 1) + S_(n-1), hence x_0 = S_n/(1 - a^(n-1) b) > 0. On the left
    the orbit grows, so only its last point (x_0 - 1)/a must still be <= 0: S_n <= 1 - a^(n-1) b.
    As S_n - 1 = a S_(n-1), the cycle exists for b <= -S_(n-1)/a^(n-2); this is -1 for n = 2.
    Its multiplier a^(n-1) b passes -1 at b = -a^(1-n). The flip lies in the interval just if
    a S_(n-1) < 1. Where the cycle begins, its last point on the left meets that of R R L^(n-2).
    """
    diagram = skew_tent_over_b(a)
    word = "L" * (n - 1) + "R"
    border = -geometric(a, n - 1) / a ** (n - 2)
    assert existence(diagram)[word] == Interval(-300, border)
    for branch in diagram.branches:
        if branch.word == "R" + "L" * (n - 1):
            assert equal(branch.exact["multiplier"], a ** (n - 1) * B)
            assert equal(branch.exact["x"], geometric(a, n) / (1 - a ** (n - 1) * B))

    flip = -(a ** (1 - n))
    flips = {
        p.exact["parameter"]
        for p in diagram.points
        if p.kind is PointKind.PD and word in {diagram.branch(b).word for b in p.branches}
    }
    assert flips == ({flip} if flip < border else set())
    stable = {interval_of(b) for b in diagram.branches if b.word == word and b.stable[1]}
    assert stable == ({Interval(flip, border)} if flip < border else set())
    born = point_at(diagram, border, 0)
    assert code(born) == (PointKind.BC, "fold", n)
    partner = "RR" + "L" * (n - 2)
    assert {diagram.branch(b).word for b in born.branches} == {"LR" + "L" * (n - 2), partner}

    for b in (border - Rational(1, 7), border, border + Rational(1, 7)):
        assert (word in points_of(SKEW.at({"a": a, "m": 1, "b": b}), n)) == (b <= border)


@pytest.mark.slow
@pytest.mark.parametrize("a", SLOPES)
def test_degenerate_flip_of_the_skew_tent(a: sympy.Rational) -> None:
    """At b = -1 the right piece is x -> 1 - x: all points of [0, 1] but 1/2 have period two.

    P maps (0, 1] to [0, 1) and 0, which the left piece owns, to 1; so P_2 is the identity on
    [0, 1]. In the diagram this is a vertical branch of order 2, parted at the fixed point
    1/2 = 1/(1 - b), whose multiplier b is -1 there. For 1/2 < -b < 1 nothing else is periodic
    [NusseYorke1995, Avrutin2019].
    """
    diagram = skew_tent_over_b(a)
    flip = point_at(diagram, -1, Rational(1, 2))
    assert code(flip) == (PointKind.PD, "degenerate: points nearby have twice the period", 1)
    branches = [diagram.branch(b) for b in flip.branches]
    fixed = [b for b in branches if b.order == 1]
    assert [interval_of(b) for b in fixed] == [
        Interval(-300, -1),
        Interval(-1, -Rational(1, 2)),
    ]
    assert all(equal(b.exact["x"], 1 / (1 - B)) for b in fixed)
    assert all(sympy.sympify(b.exact["multiplier"]).subs(B, -1) == -1 for b in fixed)
    assert [bool(b.stable[1]) for b in fixed] == [False, True]

    vertical = [b for b in branches if b.order == 2]
    assert [b.word for b in vertical] == ["RR", "RR"]
    assert all(interval_of(b) == FiniteSet(-1) for b in vertical)
    ends = {frozenset(diagram.point(e).exact["x"] for e in b.ends) for b in vertical}
    assert ends == {frozenset({0, Rational(1, 2)}), frozenset({Rational(1, 2), 1})}
    for x in (0, 1):
        assert {diagram.branch(b).order for b in point_at(diagram, -1, x).branches} == {2}
    beside = -Rational(3, 4)
    assert words_at(diagram, beside) == {"R"}
    at_flip = SKEW.at({"a": a, "m": 1, "b": -1}).iterate(2)
    assert [i.period for i in at_flip.fixed_intervals()] == [2]
    assert [at_flip(x) for x in (0, Rational(1, 3), 1)] == [0, Rational(1, 3), 1]


@pytest.mark.parametrize("a", SLOPES)
def test_only_the_left_fixed_point_when_the_shift_is_negative(a: sympy.Rational) -> None:
    """For m = -1 all x go left and stay: only x = -1/(1 - a), for all b < 0 [NusseYorke1995].

    The right piece maps x > 0 to b x - 1 < 0, the left one x <= 0 to a x - 1 < 0.
    """
    diagram = bifurcation_diagram(SKEW.at({"a": a, "m": -1}), "b", (-9, 0), orders=range(1, 5))
    assert fixed_branches(diagram) == {"L": (-1 / (1 - a), a, Interval(-9, 0), True)}
    assert {p.kind for p in diagram.points} == {PointKind.EP}


PERSISTENCE, FOLD = (PointKind.BC, "persistence", 1), (PointKind.BC, "fold", 1)


@pytest.mark.parametrize(
    ("a", "b", "kind", "left", "right"),
    [
        # slopes, point at m = 0, cycles for m < 0 and for m > 0; a star marks those that attract
        ("1/2", "1/3", PERSISTENCE, {"L*"}, {"R*"}),
        ("1/2", "-1/2", PERSISTENCE, {"L*"}, {"R*"}),
        ("1/2", "-3/2", PERSISTENCE, {"L*"}, {"R", "LR*"}),
        ("1/2", "-5/2", PERSISTENCE, {"L*"}, {"R", "LR"}),
        ("1/2", "-7/2", PERSISTENCE, {"L*"}, {"R", "LR", "LLR*", "LRR"}),
        ("1/2", "-5", PERSISTENCE, {"L*"}, {"R", "LR", "LLR", "LRR"}),
        ("-1/2", "-1/2", PERSISTENCE, {"L*"}, {"R*"}),
        ("-2", "-1/3", PERSISTENCE, {"L", "LR*"}, {"R*"}),
        ("-3", "-1/2", PERSISTENCE, {"L"}, {"R*", "LR"}),
        ("-2", "-2", PERSISTENCE, {"L"}, {"R"}),
        ("2", "1/2", FOLD, set(), {"L", "R*"}),
        ("2", "-1/2", FOLD, set(), {"L", "R*"}),
        ("2", "-5/4", FOLD, set(), {"L", "R", "LR"}),
        ("1/2", "2", FOLD, {"L*", "R"}, set()),
        ("-1/2", "2", FOLD, {"L*", "R"}, set()),
        ("2", "3", PERSISTENCE, {"R"}, {"L"}),
    ],
)
def test_border_collision_of_the_skew_tent(
    a: str,
    b: str,
    kind: tuple[PointKind, str, int],
    left: set[str],
    right: set[str],
) -> None:
    """Border collision at m = 0 [NusseYorke1992, NusseYorke1995].

    The map is homogeneous, P(c x; c m) = c P(x; m) for c > 0, so each cycle of m = 1 or m = -1 is
    a ray from (0, 0). m/(1 - a) is <= 0 for m (1 - a) < 0 only and m/(1 - b) is > 0 for
    m (1 - b) > 0 only. So the fixed points lie on the same side of m (a fold) just if one of a
    and b is above 1, and on different sides (persistence) otherwise; with both above 1 they change
    sides. The points m (1 + b)/(1 - a b) and m (1 + a)/(1 - a b) of the cycle L R have different
    signs, the first not positive, for m (1 + b)/(1 - a b) < 0 < m (1 + a)/(1 - a b). It attracts
    for |a b| < 1; R L^2 begins at b = -(1 + a)/a and attracts for |a^2 b| < 1.
    """
    map_ = SKEW.at({"a": Rational(a), "b": Rational(b)})
    diagram = bifurcation_diagram(map_, "m", (-1, 1), orders=(1, 2, 3))
    meeting = point_at(diagram, 0, 0)
    assert code(meeting) == kind
    assert [p.kind for p in diagram.points if p is not meeting] == [PointKind.EP] * (
        len(diagram.points) - 1
    )
    assert set(meeting.branches) == {branch.id for branch in diagram.branches}
    assert parameter_cells(map_, "m", (1, 2, 3)).edges == (0,)
    for m, expected in ((-1, left), (1, right)):
        shown = {
            word + "*" * (word in words_at(diagram, m, stable=True))
            for word in words_at(diagram, m) & existence(diagram).keys()
        }
        assert shown == expected


def test_border_collision_with_symbolic_slopes() -> None:
    """From a fixed point to a 2-cycle, for all 0 < a < 1, b < -1 with a b > -1 [NusseYorke1995].

    All decisions are of degree one in m. The branches are those of the test above: m/(1 - a),
    m/(1 - b) and the cycle m (1 + b)/(1 - a b), m (1 + a)/(1 - a b) with multiplier a b.
    """
    map_ = PiecewiseLinearMap(
        [("a*x + m", "x <= 0"), ("b*x + m", "x > 0")], given=["a > 0", "a < 1", "b < -1"]
    )
    sample = {"a": Rational(1, 2), "b": -Rational(3, 2)}
    diagram = bifurcation_diagram(map_, "m", (-1, 1), sample=sample)
    assert code(point_at(diagram, 0, 0)) == PERSISTENCE
    below, above = Interval(-1, 0), Interval.Lopen(0, 1)
    assert fixed_branches(diagram) == {
        "L": (sympy.factor(M / (1 - A)), A, below, True),
        "R": (sympy.factor(M / (1 - B)), B, above, False),
        "LR": (sympy.factor(M * (1 + B) / (1 - A * B)), A * B, above, True),
        "RL": (sympy.factor(M * (1 + A) / (1 - A * B)), A * B, above, True),
    }
    given = [sympy.sympify(text) for text in diagram.given]
    assert all(relation.subs(sample) == sympy.true for relation in given)
    assert any(relation.subs({"a": Rational(1, 2), "b": -3}) == sympy.false for relation in given)


def test_a_slope_is_decided_with_the_other_one_symbolic() -> None:
    """Over b the words R L^n have their borders at b = -(1 + a + ... + a^(n-1))/a^(n-1) and flip at
    b = -1/a^n [NusseYorke1995]; over a these are roots of polynomials of a higher degree.
    """
    pieces = [("a*x + 1", "x <= 0"), ("b*x + 1", "x > 0")]
    map_ = PiecewiseLinearMap(pieces, given=["a > 0", "a < 1"])
    cells = parameter_cells(map_, "b", orders=(1, 2, 3), span=(-9, 0), sample={"a": HALF})
    assert str(cells.edges) == "(-1/a**2, -(a + 1)/a, -1/a, -1)"
    assert str(cells.given) == "(a > 1/3, a < -1/2 + sqrt(5)/2)"

    other = PiecewiseLinearMap(pieces, given=["b < -1", "a > 0"])
    cells = parameter_cells(other, "a", orders=(1, 2, 3), span=(0, 1), sample={"b": -3})
    assert str(cells.edges) == "(-1/b, -1/(b + 1), -sqrt(-b)/b)"
    assert str(cells.given) == "(b < -3/2 - sqrt(5)/2,)"


# --- 2. Contracted rotations: period adding -------------------------------------------------------

ROTATION = PiecewiseLinearMap([("x/2 + d", "x < 2 - 2*d"), ("x/2 + d - 1", "x >= 2 - 2*d")])
HALF = Rational(1, 2)


def floors(p: int, q: int) -> list[int]:
    """Differences of floor(n p/q), n = 0..q."""
    return [(n + 1) * p // q - n * p // q for n in range(q)]


def christoffel(p: int, q: int) -> str:
    """The lower Christoffel word with p letters R among q."""
    return "".join("LR"[step] for step in floors(p, q))


def locked(p: int, q: int) -> sympy.Interval:
    """The values of d with rotation number p/q, by the closed form."""
    rises = list(reversed(floors(p, q)))  # differences of the ceilings
    low, high = (
        Rational(sum(step * 2 ** (q - k) for k, step in enumerate(steps, 1)), 2**q - 1)
        for steps in (rises, floors(p, q))
    )
    return Interval.Ropen(low, HALF + high)


def fractions_up_to(q_max: int) -> list[tuple[int, int]]:
    """All 0 < p/q < 1 in lowest terms with q <= q_max, in order."""
    pairs = [(p, q) for q in range(2, q_max + 1) for p in range(1, q) if gcd(p, q) == 1]
    return sorted(pairs, key=lambda pair: Fraction(*pair))


@cache
def rotation_diagram() -> Diagram:
    return bifurcation_diagram(ROTATION, "d", (HALF, 1), orders=range(1, 9))


LOW_INTERVALS = {  # 1/2: 2/3 = 2/(4-1), 5/6; 2/5: ceilings 1 0 1 0 0 make 20/31, floors 5/31
    (1, 2): ("2/3", "5/6"), (1, 3): ("4/7", "9/14"), (2, 3): ("6/7", "13/14"),
    (2, 5): ("20/31", "41/62"),
}  # fmt: skip


@pytest.mark.nightly
def test_locking_intervals_of_contracted_rotations() -> None:
    """x/2 + d mod 1, 1/2 < d < 1 [Keener1980, DingHemmer1987, Bugeaud1993, Laurent2018].

    With e_n = 1 where the orbit is on the right and 0 on the left, x_n = x_(n-1)/2 + d - e_(n-1),
    so on a cycle x_n = 2 d - 2 sum_(k>=1) 2^-k e_(n-k). The map keeps the cyclic order of [0, 1),
    so the steps of rotation number p/q are those of floor(n p/q + c). The cycle exists as long as
    its least point is >= 0 and its greatest < 1. The past of the least point is the
    lexicographically greatest, e_(-k) = ceil(k p/q) - ceil((k-1) p/q), hence
        d >= sum_k 2^-k (ceil(k p/q) - ceil((k-1) p/q)),
    that of the greatest point has floors for ceilings, hence
        d < 1/2 + sum_k 2^-k (floor(k p/q) - floor((k-1) p/q)).
    Both sums have period q: they are one period's digits over 2^q - 1. The two periods are 1 w 0
    and 0 w 1, so they differ by 2^(q-1) - 1 and the interval has length 1/(2 (2^q - 1)).
    """
    found = existence(rotation_diagram())
    rationals = fractions_up_to(8)
    assert len(rationals) == 21
    assert found == {christoffel(p, q): locked(p, q) for p, q in rationals}
    for (p, q), ends in LOW_INTERVALS.items():
        assert locked(p, q) == Interval.Ropen(*map(Rational, ends))
    for p, q in rationals:
        interval = locked(p, q)
        assert interval.measure == Rational(1, 2 * (2**q - 1))


@pytest.mark.slow
def test_cycles_of_contracted_rotations_and_their_ends() -> None:
    """Each cycle of period q has multiplier 2^-q, and no two exist at once [Keener1980].

    The points 2 d - 4/3, 2 d - 2/3 of L R are 0 and 2/3 = 2 - 2 d at d = 2/3, where it begins. At
    d = 5/6 they have come to 1/3 = 2 - 2 d, which the right piece owns, and 1 [Granados2017].
    """
    diagram = rotation_diagram()
    fixed = [b for b in diagram.branches if b.kind is BranchKind.FIXED_POINT]
    assert all(b.exact["multiplier"] == Rational(1, 2**b.order) and b.stable.all() for b in fixed)
    assert len(fixed) == sum(q for _, q in fractions_up_to(8))
    assert {p.kind for p in diagram.points} <= {PointKind.BC, PointKind.EP}
    cycle = {b.word: b.exact["x"] for b in fixed}
    assert equal(cycle["LR"], 2 * D - Rational(4, 3))
    assert equal(cycle["RL"], 2 * D - Rational(2, 3))
    for d, x in (("2/3", "0"), ("2/3", "2/3"), ("5/6", "1/3"), ("5/6", "1")):
        assert point_at(diagram, Rational(d), Rational(x)).kind is PointKind.BC


# --- 3. Period incrementing with coexistence ------------------------------------------------------

INCREMENTING = PiecewiseLinearMap([("x/2 + m", "x < 0"), ("-x/2 + m - 1", "x >= 0")])


def increments(n: int) -> sympy.Interval:
    """The values of m at which the cycle R L^n exists, n >= 1, by the closed form."""
    return Interval.Ropen(Rational(1, 2 ** (n + 1) - 1), Rational(2, 2 ** (n + 1) - 3))


@cache
def incrementing_diagram() -> Diagram:
    return bifurcation_diagram(INCREMENTING, "m", (-HALF, 3), orders=range(1, 8))


@pytest.mark.slow
def test_period_incrementing_intervals() -> None:
    """x/2 + m | -x/2 + m - 1: cycles R L^n [AvrutinSchanz2006, Avrutin2010, Granados2017].

    From x_0 >= 0 the first point on the left is m - 1 - x_0/2; n - 1 more halvings and the step
    back give x_0 = 2^-n (m - 1 - x_0/2) + 2 (1 - 2^-n) m, hence
        x_0 = ((2^(n+2) - 2) m - 2)/(2^(n+1) + 1) >= 0  for  m >= 1/(2^(n+1) - 1).
    On the left the orbit grows, its last point 2 (x_0 - m) is < 0 for m < 2/(2^(n+1) - 3). For
    n = 0 the fixed point R remains for all m >= 1. The multiplier is -2^-(n+1). That there are no
    other words is a theorem of [Granados2017].
    """
    diagram = incrementing_diagram()
    expected = {"L" * n + "R": increments(n) for n in range(1, 7)}
    expected |= {"L": Interval.Ropen(-HALF, 0), "R": Interval(1, 3)}
    assert existence(diagram) == expected
    for branch in diagram.branches:
        n = branch.order - 1
        if branch.word == "R" + "L" * n:
            assert branch.exact["multiplier"] == -Rational(1, 2 ** (n + 1))
            closed = ((2 ** (n + 2) - 2) * M - 2) / (2 ** (n + 1) + 1)
            assert equal(branch.exact["x"], closed)
            assert branch.stable.all()
            assert diagram.point(branch.ends[0]).kind is PointKind.BC


# --- 4. The tent map ------------------------------------------------------------------------------

TENT = PiecewiseLinearMap([("2*x", "x <= 1/2"), ("2 - 2*x", "x > 1/2")])
MOEBIUS = {1: 1, 2: -1, 3: -1, 4: 0, 5: -1, 6: 1, 7: -1, 8: 0}


DOUBLING = PiecewiseLinearMap([("2*x + 1", "x < 0"), ("2*x - 1", "x >= 0")])


@pytest.mark.parametrize("j", range(1, 9))
@pytest.mark.parametrize("map_", [TENT, DOUBLING], ids=["tent", "doubling"])
def test_cycles_of_maps_with_full_pieces(map_: PiecewiseLinearMap, j: int) -> None:
    """P_j maps each of 2^j pieces onto all of the interval: 2^j fixed points, none attracts.

    Of the tent map a rising piece is 2^j x - 2 i, a falling one 2 i - 2^j x: fixed points
    2 i/(2^j - 1), 0 <= i < 2^(j-1), and 2 i/(2^j + 1), 0 < i <= 2^(j-1). The doubling map is, with
    y = (x + 1)/2, 2 y mod 1 on [-1, 1], so y = i/(2^j - 1). None is at a border: the orbits of the
    breaks end in 0, and in -1 and 1 [Guckenheimer1979]. Moebius inversion leaves
    (1/j) sum_(d|j) mu(d) 2^(j/d) cycles of minimal period j [MilnorThurston1988, Avrutin2019].
    """
    fixed = map_.iterate(j).fixed_points()
    half = 2 ** (j - 1)
    closed = {Rational(2 * i, 2**j - 1) for i in range(half)}
    closed |= {Rational(2 * i, 2**j + 1) for i in range(1, half + 1)}
    if map_ is DOUBLING:
        closed = {-1 + Rational(2 * i, 2**j - 1) for i in range(2**j)}
    assert [f.x for f in fixed] == sorted(closed)
    assert {f.multiplier for f in fixed} == {2**j, 2**j if map_ is DOUBLING else -(2**j)}
    assert not any(f.stable or f.at_border for f in fixed)
    count = sum(MOEBIUS[d] * 2 ** (j // d) for d in range(1, j + 1) if j % d == 0) // j
    assert count == [2, 1, 2, 3, 6, 9, 18, 30][j - 1]
    cycles = map_.cycles(j)
    assert len(cycles) == count
    assert all(abs(c.multiplier) == 2**j and c.admissible for c in cycles)


SLOPE = PiecewiseLinearMap([("s*x + 2*s", "x < -1"), ("-s*x", "x >= -1")])  # turns at -1


def roots_in(polynomial: sympy.Expr) -> tuple[sympy.Expr, ...]:
    """Real roots between 1 and 2, ends excluded, in order."""
    roots = dict.fromkeys(sympy.Poly(polynomial, S).real_roots())
    return tuple(root for root in roots if 1 < root < 2)


def first_with_period(cells: ParameterCells, j: int) -> sympy.Expr:
    """The least slope at which there are points of minimal period j; it must be an edge."""
    for cell in cells:
        if any(f.period == j for f in cell.map.iterate(j).fixed_points()):
            assert cell.is_edge
            return cell.lower
    raise AssertionError


@pytest.mark.parametrize(
    ("j", "polynomial"),
    [
        pytest.param(5, S**5 - 2 * S**3 - 1, marks=pytest.mark.nightly),
        pytest.param(7, S**7 - 2 * S**5 - 1, marks=pytest.mark.nightly),
        (6, S**4 - S**2 - 1),
    ],
)
def test_first_cycles_of_a_period_of_the_tent_map(j: int, polynomial: sympy.Expr) -> None:
    """s x + 2 s | -s x: the odd period j first appears at the great root of s^j - 2 s^(j-2) - 1.

    The turning point -1 goes to s, -s^2 and s (2 - s^2), then its distance from the fixed point 0
    grows by -s in each step: after j steps it is at (-1)^(j-3) s^(j-2) (2 - s^2), back at -1 for
    s^j - 2 s^(j-2) = 1 if j is odd [Block1980]. The roots fall towards sqrt(2), where two bands
    merge. Below sqrt(2), P_2 on a band is a tent of slope s^2: period 6 begins at sqrt((1 + sqrt
    5)/2) [MilnorThurston1988].
    """
    cells = parameter_cells(SLOPE, "s", orders=(j,), span=(1, 2))
    (root,) = roots_in(polynomial)
    assert first_with_period(cells, j) == root
    assert (root > sqrt(2)) == (j % 2 == 1)
    assert root < GOLDEN


def test_superstable_three_cycle_of_the_tent_map() -> None:
    """At the golden mean s the orbit -1, s, -s^2 closes: s (2 - s^2) = -1 [MilnorThurston1988].

    s^3 - 2 s - 1 is (s + 1)(s^2 - s - 1), so that this is the only edge.

    It passes the corner, where P_3 has slopes s^3 and -s^3: it does not attract. Below there is no
    cycle of period three, above there are two, L R R and L L R.
    """
    cells = parameter_cells(SLOPE, "s", orders=(3,), span=(1, 2))
    assert cells.edges == (GOLDEN,)
    below, at, above = cells
    edge = {f.word: f for f in at.map.iterate(3).fixed_points() if f.period == 3}
    values = {word: sympy.radsimp(f.x.subs(S, GOLDEN)) for word, f in edge.items()}
    golden = {"RRL": -1, "RLR": GOLDEN, "LRR": -(GOLDEN**2)}
    assert values.keys() == golden.keys()
    assert all(sympy.expand(values[word] - golden[word]) == 0 for word in golden)
    assert all(f.at_border and not f.stable for f in edge.values())
    assert not any(f.period == 3 for f in below.map.iterate(3).fixed_points())
    words = {f.word for f in above.map.iterate(3).fixed_points() if f.period == 3}
    assert words == {"LLR", "LRL", "RLL", "LRR", "RLR", "RRL"}


@pytest.mark.slow
def test_band_merging_of_the_tent_map() -> None:
    """Two bands merge at s = sqrt(2), where the corner reaches the fixed point in three steps.

    -1 -> s -> -s^2 -> s (2 - s^2) = 0. No word in L and R of finite length changes there, as the
    corner does not return. With the fixed point 0 as one more break, M and R the two sides of it,
    the corner's fourth letter does change [MilnorThurston1988].
    """
    halved = PiecewiseLinearMap(
        [("s*x + 2*s", "x < -1"), ("-s*x", "(x >= -1) & (x < 0)"), ("-s*x", "x >= 0")]
    )
    assert sqrt(2) not in parameter_cells(SLOPE, "s", orders=range(1, 7), span=(1, 2)).edges
    edges = parameter_cells(halved, "s", orders=(4,), span=(1, 2)).edges
    assert edges[:2] == (sqrt(2), GOLDEN)
    below, above = (halved.at({"s": Rational(s)}).word_of(-1) for s in ("7/5", "3/2"))
    assert (below, above) == ("M", "M")
    words = [halved.at({"s": Rational(s)}).iterate(4).word_of(-1) for s in ("7/5", "3/2")]
    assert words == ["MRLR", "MRLM"]


# --- 5. Expanding Lorenz maps ---------------------------------------------------------------------

LORENZ = PiecewiseLinearMap([("3*x/2 + 1", "x < 0"), ("3*x/2 - m", "x >= 0")])
SYMMETRIC = PiecewiseLinearMap([("b*x + 1", "x < 0"), ("b*x - 1", "x >= 0")])


def test_no_attractor_of_an_expanding_lorenz_map() -> None:
    """With all slopes 3/2 no cycle attracts, and the 2-cycle exists for 2/3 <= m < 3/2.

    L R: x = (3 x/2 + 1) 3/2 - m has x = (4 m - 6)/5 < 0 for m < 3/2, and 3 x/2 + 1 = (6 m - 4)/5
    is >= 0 for m >= 2/3 [Guckenheimer1979]. L R R: x = 3 (3 (3 x/2 + 1)/2 - m)/2 - m, so
    19 x = 20 m - 18 < 0 for m < 9/10; the least of the others, 3 x/2 + 1 = (30 m - 8)/19 and
    (26 m - 12)/19, is >= 0 for m >= 6/13. With x -> -m x, m -> 1/m the letters change place, so
    L L R exists from 10/9 on, up to 13/6.
    """
    diagram = bifurcation_diagram(LORENZ, "m", (0, 3), orders=range(1, 5))
    fixed = [b for b in diagram.branches if b.kind is BranchKind.FIXED_POINT]
    assert {b.exact["multiplier"] for b in fixed} == {Rational(3, 2) ** j for j in range(1, 5)}
    assert not any(b.stable.any() for b in diagram.branches)
    found = existence(diagram)
    assert found["LR"] == Interval.Ropen(Rational(2, 3), Rational(3, 2))
    assert found["LRR"] == Interval.Ropen(Rational(6, 13), Rational(9, 10))
    assert found["LLR"] == Interval.Ropen(Rational(10, 9), Rational(13, 6))
    for word, interval in found.items():
        for m in (interval.start, (interval.start + interval.end) / 2, interval.end):
            if 0 < m < 3:
                assert (word in points_of(LORENZ.at({"m": m}), len(word))) == (m in interval)
    assert not {p.kind for p in diagram.points} & {PointKind.PD, PointKind.LP}


def test_three_cycles_of_the_symmetric_lorenz_map() -> None:
    """b x + 1 | b x - 1: both cycles of period three begin at the golden mean [Guckenheimer1979].

    L L R: the points times b^3 - 1 are -(b^2 + b - 1), -(b^2 - b + 1) and b^2 - b - 1. The last is
    >= 0 from the golden mean on, where it lies at 0, which the right piece owns. The mirror image
    R R L must have -(b^2 - b - 1) < 0, so it does not exist at the golden mean itself.
    """
    low = Rational(9, 8)
    diagram = bifurcation_diagram(SYMMETRIC, "b", (low, 2), orders=(1, 2, 3))
    found = existence(diagram)
    assert found == {
        "L": Interval(low, 2),
        "R": Interval(low, 2),
        "LR": Interval(low, 2),
        "LLR": Interval(GOLDEN, 2),
        "LRR": Interval.Lopen(GOLDEN, 2),
    }
    closed = {"LLR": 1 - B - B**2, "LRL": B - 1 - B**2, "RLL": B**2 - B - 1}
    for branch in diagram.branches:
        if branch.word in closed:
            assert equal(branch.exact["x"], closed[branch.word] / (B**3 - 1))
        assert not branch.stable.any()
    assert parameter_cells(SYMMETRIC, "b", orders=(3,), span=(1, 2)).edges == (GOLDEN,)
    kind, note, order = code(point_at(diagram, GOLDEN, 0))
    assert (kind, note, order) == (PointKind.BC, "persistence", 3)
    golden_orbit = (-1, (1 - sqrt(5)) / 2, 0, (sqrt(5) - 1) / 2, 1)
    assert {p.exact["x"] for p in diagram.points if p.exact["parameter"] == GOLDEN} == set(
        golden_orbit
    )


def test_existence_at_the_ends_of_the_span() -> None:
    """The span's ends are values of the parameter like others: b = 1 has no fixed point.

    b x + 1 | b x - 1: the fixed points -1/(b - 1) and 1/(b - 1) go to infinity there. At the upper
    end 5/6 of the interval of L R the contracted rotation has lost that cycle, at the lower end
    2/3 it has it [Guckenheimer1979, Bugeaud1993]; see the tests above.
    """
    assert SYMMETRIC.at({"b": 1}).fixed_points() == ()
    diagram = bifurcation_diagram(SYMMETRIC, "b", (1, 2), orders=(1,))
    assert existence(diagram) == {"L": Interval.Lopen(1, 2), "R": Interval.Lopen(1, 2)}
    ends = Rational(2, 3), Rational(5, 6)
    rotation = bifurcation_diagram(ROTATION, "d", ends, orders=(1, 2))
    assert existence(rotation) == {"LR": Interval.Ropen(*ends)}


# --- 6. Three pieces ------------------------------------------------------------------------------


def test_hysteresis_of_a_continuous_map_of_three_pieces() -> None:
    """-x/2 - 5/2 + m | 2 x + m | -x/2 + 5/2 + m, breaks -1 and 1: two folds make a hysteresis.

    Fixed points (2 m - 5)/3 < -1 for m < 1, -m in [-1, 1] for |m| <= 1, (2 m + 5)/3 > 1 for
    m > -1: at (m, x) = (1, -1) the left and the middle one meet, at (-1, 1) the right and the
    middle one: nonsmooth folds [NusseYorke1995]. There is no 2-cycle: L M needs m >= 1 for
    its point (m - 5)/4 >= -1 and m < 1 for (3 m - 5)/2 < -1; M R mirrors that; L R needs
    5 + 2 m/3 < -1 and -5 + 2 m/3 > 1.
    """
    map_ = PiecewiseLinearMap(
        [
            ("-x/2 - 5/2 + m", "x < -1"),
            ("2*x + m", "(x >= -1) & (x <= 1)"),
            ("-x/2 + 5/2 + m", "x > 1"),
        ]
    )
    assert map_.at({"m": 0}).jumps() == ()
    diagram = bifurcation_diagram(map_, "m", (-2, 2), orders=(1, 2))
    assert fixed_branches(diagram) == {
        "L": (sympy.factor((2 * M - 5) / 3), -HALF, Interval.Ropen(-2, 1), True),
        "M": (-M, 2, Interval(-1, 1), False),
        "R": (sympy.factor((2 * M + 5) / 3), -HALF, Interval.Lopen(-1, 2), True),
    }
    folds = {"LM": point_at(diagram, 1, -1), "MR": point_at(diagram, -1, 1)}
    for words, fold in folds.items():
        assert code(fold) == FOLD
        assert "".join(diagram.branch(b).word for b in fold.branches) == words
    assert diagram.sides(folds["LM"].id) == (("F1", "F2"), ())
    assert diagram.sides(folds["MR"].id) == ((), ("F2", "F3"))


def test_a_relay_with_a_point_of_its_own() -> None:
    """x/2 + 1 + m | m at 0 | x/2 - 1 + m: L R exists for |m| < 1/3, and M at m = 0 only.

    L R: x = (x/2 + 1 + m)/2 - 1 + m has x = 2 m - 2/3 < 0 and the other point is 2 m + 2/3 > 0. The
    fixed points 2 (m + 1) and 2 (m - 1) exist for m < -1 and m > 1. The point 0 goes to m: fixed at
    m = 0, and for m < 0 back to 0 if 3 m/2 + 1 = 0, likewise at m = 2/3. These are isolated points
    without a multiplier, and 0 repels as both sides jump. Switched linear systems of this kind:
    [Avrutin2019].
    """
    map_ = PiecewiseLinearMap(
        [("x/2 + 1 + m", "x < 0"), ("m", "Eq(x, 0)"), ("x/2 - 1 + m", "x > 0")]
    )
    diagram = bifurcation_diagram(map_, "m", (-2, 2), orders=(1, 2))
    third = Rational(1, 3)
    assert existence(diagram) == {
        "L": Interval.Ropen(-2, -1),
        "M": FiniteSet(0),
        "R": Interval.Lopen(1, 2),
        "LM": FiniteSet(-2 * third),
        "LR": Interval.open(-third, third),
        "MR": FiniteSet(2 * third),
    }
    for word, values in existence(diagram).items():
        conditions = sympy.And(*map_.cycle(word).conditions).as_set()
        assert conditions & Interval(-2, 2) == values
    exact = {b.word: b.exact for b in diagram.branches if b.kind is BranchKind.FIXED_POINT}
    assert equal(exact["LR"]["x"], 2 * M - 2 * third)
    assert equal(exact["RL"]["x"], 2 * M + 2 * third)
    assert exact["LR"]["multiplier"] == Rational(1, 4)
    assert exact["M"]["multiplier"] is sympy.nan
    assert code(point_at(diagram, 0, 0)) == (PointKind.BC, "isolated", 1)
    (crossing,) = map_.at({"m": 0}).jump_crossings()
    assert (crossing.x, crossing.left, crossing.right) == (0, 1, -1)
    (fixed,) = map_.at({"m": 0}).fixed_points()
    assert (fixed.x, fixed.word, fixed.at_border, fixed.stable) == (0, "M", True, False)


# --- 7. The map of the Woodpecker paper -----------------------------------------------------------

PAPER = PiecewiseLinearMap([("r - 2", "x <= 0"), ("r - a*x", "x > 0")], given=["a > 1"])
STEEPNESS = [A, Rational(5, 4)]


def paper(a: sympy.Expr) -> PiecewiseLinearMap:
    """The map with the slope symbolic or a number."""
    return PAPER if a == A else PAPER.at({"a": a})


@pytest.mark.parametrize("a", STEEPNESS)
def test_second_iterate_of_the_paper(a: sympy.Expr) -> None:
    """For 0 < r < 2 all x <= 0 go to r - 2 < 0, and so do in two steps all x >= r/a.

    On 0 < x < r/a, P_2 = r - a (r - a x) = a^2 x + (1 - a) r [Leine2001, Eq. 15]. Its one jump
    crossing is at r/a, from r to r - 2.
    """
    given = ["r > 0", "r < 2", *(["a > 1"] if a == A else [])]
    map_ = PiecewiseLinearMap(
        [(R - 2, "x <= 0"), (R - a * sympy.Symbol("x"), "x > 0")], given=given
    )
    pieces = map_.iterate(2).pieces
    assert [p.word for p in pieces] == ["LL", "RR", "RL"]
    closed = [(-oo, 0, 0, R - 2), (0, R / a, a**2, (1 - a) * R), (R / a, oo, 0, R - 2)]
    for piece, (lower, upper, slope, intercept) in zip(pieces, closed, strict=True):
        assert equal(piece.slope, slope)
        assert equal(piece.intercept, intercept)
        assert piece.lower == lower if lower in (-oo, 0) else equal(piece.lower, lower)
        assert piece.upper == upper if upper in (0, oo) else equal(piece.upper, upper)
    assert [(p.lower_closed, p.upper_closed) for p in pieces] == [
        (False, True),
        (False, False),
        (True, False),
    ]
    (crossing,) = map_.iterate(2).jump_crossings()
    assert equal(crossing.x, R / a)
    assert (crossing.left, crossing.right) == (R, R - 2)
    assert {j.x for j in map_.iterate(2).jumps()} == {0, crossing.x}


@pytest.mark.parametrize("a", STEEPNESS)
def test_points_a_and_b_of_the_paper(a: sympy.Expr) -> None:
    """Fixed points r/(1 + a) for r > 0 and r - 2 for r <= 2 [Leine2001, Eq. 14, Fig. 12].

    The jump at 0, from r - 2 to r, crosses the diagonal for 0 < r < 2. At A = (0, 0) it ends in the
    first fixed point, whose multiplier is -a < -1, and the jump r/a of P_2 starts: a fold-flip. At
    B = (2, 0) it ends in the second one, with multiplier 0: a fold. P_2 has no crossing at 0 before
    r = 2, as both its limits r - 2 and (1 - a) r lie below 0.
    """
    diagram = bifurcation_diagram(paper(a), "r", (-1, Rational(9, 4)), orders=(1, 2))
    branches = {b.word: b for b in diagram.branches}
    left, right, jump, jump_2 = (branches[w] for w in ("L", "R", "L|R", "RR|RL"))
    assert fixed_branches(diagram.of_order(1)) == {
        "R": (R / (1 + a), -a, Interval.Lopen(0, Rational(9, 4)), False),
        "L": (R - 2, 0, Interval(-1, 2), True),
    }
    assert (jump.exact["x"], jump.exact["left"], jump.exact["right"]) == (0, R - 2, R)
    assert interval_of(jump) == Interval.open(0, 2)
    assert equal(jump_2.exact["x"], R / a)

    point_a, point_b = point_at(diagram, 0, 0), point_at(diagram, 2, 0)
    assert code(point_a) == (PointKind.FF, "fold", 1)
    assert code(point_b) == (PointKind.BC, "fold", 1)
    assert set(point_a.branches) == {right.id, jump.id, jump_2.id}
    assert {left.id, jump.id} <= set(point_b.branches)
    assert jump.ends == (point_a.id, point_b.id)
    assert jump_2.ends[0] == right.ends[0] == point_a.id
    at_zero = [b for b in diagram.branches if b.order == 2 and b.exact.get("x") == 0]
    assert all(interval_of(b).start == 2 for b in at_zero)


@pytest.mark.parametrize("a", STEEPNESS)
def test_jump_crossings_of_all_iterates_of_the_paper(a: sympy.Expr) -> None:
    """Each P_j has one jump crossing for 0 < r < 2, at x* (1 - (-a)^(1-j)), x* = r/(1 + a).

    The jump of P_j is the preimage of 0 under j - 1 steps on the right: the distance from x*
    shrinks by -1/a in each, from -x* on. All of them start at A, as the
    paper says after Eq. 15 without a formula [Leine2001, Results].
    """
    diagram = bifurcation_diagram(paper(a), "r", (-1, 2), orders=range(1, 7))
    origin = point_at(diagram, 0, 0)
    assert code(origin) == (PointKind.FF, "fold", 1)
    jumps = [b for b in diagram.branches if b.kind is BranchKind.JUMP]
    assert [b.order for b in jumps] == [1, 2, 3, 4, 5, 6]
    for branch in jumps:
        assert equal(branch.exact["x"], R / (1 + a) * (1 - (-a) ** (1 - branch.order)))
        assert (interval_of(branch).start, interval_of(branch).end) == (0, 2)
        assert branch.ends[0] == origin.id
    assert set(origin.branches) == {b.id for b in jumps} | {"F2"}
    assert {b.word for b in diagram.branches if b.kind is BranchKind.FIXED_POINT} == {"L", "R"}
    if a == A:
        assert [sympy.sympify(text) for text in diagram.given] == [A > 1]


def test_cycles_of_the_paper_beyond_point_b() -> None:
    """For r > 2: L R from r = 2 a/(a - 1) on, and L R R up to 2 a^2/(a^2 - a + 1), for all a > 1.

    All of x <= 0 goes to r - 2 > 0, then to r - a (r - 2), which is <= 0 for r >= 2 a/(a - 1): a
    superstable cycle L R. Otherwise the third point is r - a r + a^2 (r - 2), which is <= 0 for
    r <= 2 a^2/(a^2 - a + 1), less than 2 a/(a - 1): a cycle L R R. The map is that of
    [Leine2001, Eq. 14].
    """
    cells = parameter_cells(PAPER, "r", orders=(1, 2, 3))
    two, three = 2 * A / (A - 1), 2 * A**2 / (A**2 - A + 1)
    assert [equal(*pair) for pair in zip(cells.edges, (0, 2, three, two), strict=True)] == [
        True
    ] * 4
    assert set(cells.given) == {A > 1}
    shown = [
        {
            (f.word, f.multiplier, f.stable)
            for f in cell.map.iterate(j).fixed_points()
            if f.period > 1
        }
        for cell in cells
        for j in (2, 3)
    ]
    lr, lrr, none = ["LR", "RL"], ["LRR", "RLR", "RRL"], list[str]()
    # periods 2 and 3 for r < 0, = 0, ... in turn; at the edges points beside the cycle leave first
    words = [none] * 8 + [none, lrr, none, lrr, none, none, lr, none, lr, none]
    attracting = [True] * 10 + [True, False, True, True, False, True, True, True]
    for found_here, expected, stable in zip(shown, words, attracting, strict=True):
        assert found_here == {(word, 0, stable) for word in expected}

    found = existence(bifurcation_diagram(paper(Rational(5, 4)), "r", (-1, 20), orders=(1, 2, 3)))
    assert found["LR"] == Interval(10, 20)
    assert found["LRR"] == Interval.Lopen(2, Rational(50, 21))
