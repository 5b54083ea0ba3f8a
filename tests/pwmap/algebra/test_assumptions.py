"""What follows from assumptions: linear programs, signs, samples, and the cells they admit."""

import random
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import combinations, islice, pairwise, permutations, product

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from sympy import QQ, Rational
from thoroughness import thorough

from pwmap import (
    Diagram,
    PiecewiseLinearMap,
    PointKind,
    UndecidedError,
    bifurcation_diagram,
    parameter_cells,
)
from pwmap.algebra.arithmetic import fraction_of
from pwmap.algebra.assumptions import AssumedRegion, read_constraints
from pwmap.algebra.exact import polynomial_ring
from pwmap.algebra.inequalities import Constraint, value_at
from pwmap.algebra.linear import combination
from pwmap.algebra.parsing import term_of
from pwmap.algebra.signs import possible_signs

TWO = polynomial_ring(sympy.symbols("a b"))
A, B, MU, X = sympy.symbols("a b mu x")


def region(assumed: Sequence[str], names: str) -> AssumedRegion:
    ring = polynomial_ring(sympy.symbols(names, seq=True))
    return AssumedRegion(
        ring, read_constraints([term_of(text, ring.symbols) for text in assumed], ring)
    )


def sign_of(assumed: Sequence[str], names: str, polynomial: str) -> int:
    within = region(assumed, names)
    return within.sign(fraction_of(polynomial, within.ring, "it")[0])


def relations(assumed: Sequence[str]) -> list[sympy.Basic]:
    return [sympy.sympify(text) for text in assumed]


# --- Linear programs ------------------------------------------------------------------------------


@st.composite
def systems(draw: st.DrawFn) -> tuple[list[list[int]], list[int]]:
    size = draw(st.integers(1, 4))
    vectors = st.lists(st.integers(-4, 4), min_size=size, max_size=size)
    return draw(st.lists(vectors, max_size=7)), draw(vectors)


@pytest.mark.nightly
@given(system=systems())
@thorough(200)
def test_weights_combine_the_columns_or_a_vector_separates_them(
    system: tuple[list[list[int]], list[int]],
) -> None:
    columns, target = system
    match combination(columns, target):
        case True, weights:
            assert all(weight >= 0 for weight in weights)
            total = [
                sum((w * c[i] for w, c in zip(weights, columns, strict=True)), Fraction(0))
                for i in range(len(target))
            ]
            assert total == target
        case False, vector:
            for column in columns:
                assert sum(y * c for y, c in zip(vector, column, strict=True)) <= 0
            assert sum(y * t for y, t in zip(vector, target, strict=True)) > 0


Line = tuple[int, int, int]  # of the inequality p a + q b + s >= 0
BOX: list[Line] = [(1, 0, 4), (-1, 0, 4), (0, 1, 4), (0, -1, 4)]


def corners(lines: Sequence[Line]) -> list[tuple[Fraction, Fraction]]:
    """Corners of a bounded polygon, by solving all pairs of its lines."""
    found = set()
    for (p, q, s), (t, u, v) in combinations(lines, 2):
        area = p * u - q * t
        if area:
            point = Fraction(q * v - s * u, area), Fraction(s * t - p * v, area)
            if all(x * point[0] + y * point[1] + z >= 0 for x, y, z in lines):
                found.add(point)
    return sorted(found)


def line(numbers: Line) -> object:
    a, b = TWO.gens
    return numbers[0] * a + numbers[1] * b + numbers[2]


@pytest.mark.nightly
def test_signs_of_linear_polynomials_against_the_corners_of_polygons() -> None:
    """Over a closed polygon a linear polynomial takes all values between those at its corners."""
    rng = random.Random(5)
    empty = seen = 0
    for _ in range(150):
        lines = BOX + [tuple(rng.randint(-3, 3) for _ in range(3)) for _ in range(3)]
        lines = [numbers for numbers in lines if any(numbers[:2])]
        constraints = tuple(Constraint(line(numbers), False) for numbers in lines)
        points, asked = corners(lines), (rng.randint(1, 3), rng.randint(-3, 3), rng.randint(-9, 9))
        if not points:
            empty += 1
            with pytest.raises(ValueError, match="there are no values of the parameters with"):
                _ = AssumedRegion(TWO, constraints).sample
            continue
        values = [asked[0] * x + asked[1] * y + asked[2] for x, y in points]
        expected = {s for s, ok in ((1, max(values) > 0), (-1, min(values) < 0)) if ok}
        expected |= {0} if min(values) <= 0 <= max(values) else set()
        assert possible_signs(line(asked), constraints) == expected
        seen += 1
    assert empty > 10
    assert seen > 50


# --- Samples --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("assumed", "names"),
    [
        (["b > 1", "a < -b"], "a b"),
        (["b > 5", "a > 2*b"], "a b"),
        (["l > 2", "a + l < 0"], "a l"),
        (["b > 0", "b < 1/10", "a*b > 1"], "a b"),
        (["a >= 1", "a <= 1"], "a b"),
        (["a + b >= 1", "a + b <= 1", "a > b"], "a b"),
        (["a**2 + b**2 < 1", "a + b > 7/5"], "a b"),
        (["a**2 <= 4", "a**2 >= 4"], "a"),
        (["a*b >= 1", "a*b <= 1", "b > 3"], "a b"),
        (["a**2 + b**2 <= 0"], "a b"),
        (["a*b*c > 1", "a*c < 0", "a + b + c > 5"], "a b c"),
        (["a**2 + b**2 + c**2 < 1", "a*b*c > 1/10"], "a b c"),
        (["a**3 > b**2", "b > 10"], "a b"),
    ],
)
def test_what_can_be_satisfied_is_not_refused(assumed: list[str], names: str) -> None:
    for values in islice(region(assumed, names).samples(), 20):
        shown = {name: QQ.to_sympy(value) for name, value in values.items()}
        assert all(relation.subs(shown) == sympy.true for relation in relations(assumed))


@pytest.mark.parametrize(
    ("assumed", "message"),
    [
        (["a > 1", "a < 1"], "there are no values of the parameters with a > 1, a < 1"),
        (["a > b", "b > a"], "there are no values of the parameters with a - b > 0, a - b < 0"),
        (["a < 0", "b > 0", "a*b > 1"], "there are no values of the parameters with"),
        (["a**2 + b**2 < 1", "a + b > 3/2"], "there are no values of the parameters with"),
        (["a >= 1", "a <= 1", "b > a", "b < 1"], "there are no values of the parameters with"),
        (["a**2 <= 2", "a**2 >= 2"], "no rational values of the parameters were found with"),
    ],
)
def test_what_cannot_be_satisfied_is_refused(assumed: list[str], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        _ = region(assumed, "a b").sample


def polynomials(rng: random.Random, count: int) -> Iterator[object]:
    """Random polynomials in a and b of degree two at most."""
    a, b = TWO.gens
    for _ in range(count):
        terms = rng.sample([a, b, a * b, a**2, b**2, TWO.one], rng.randint(2, 4))
        yield sum((rng.choice([-3, -2, -1, 1, 2, 3]) * term for term in terms), TWO.zero)


GRID = [[QQ(x, 2), QQ(y, 2)] for x, y in product(range(-6, 7), repeat=2)]


@pytest.mark.nightly
def test_regions_and_signs_against_a_grid() -> None:
    """A point of the grid that is admitted shows that none may refuse, and which signs occur."""
    rng = random.Random(8)
    proved = undecided = empty = 0
    for _ in range(50):
        limits = [p for p in polynomials(rng, rng.randint(1, 3)) if not p.is_ground]
        constraints = tuple(Constraint(p, rng.random() < 0.7) for p in limits)
        within = AssumedRegion(TWO, constraints)
        admitted = [
            point
            for point in GRID
            if all(c.holds(_sign(value_at(c.polynomial, point))) for c in constraints)
        ]
        try:
            drawn = [list(values.values()) for values in islice(within.samples(), 5)]
        except ValueError:
            assert not admitted
            empty += 1
            continue
        for values in islice(within.samples(), 5):
            assert within.contains(values) is None
        for polynomial in polynomials(rng, 3):
            if polynomial.is_ground:
                continue
            seen = {_sign(value_at(polynomial, point)) for point in (*drawn, *admitted)}
            try:
                assert seen == {within.sign(polynomial)}
                proved += 1
            except UndecidedError:
                undecided += 1
    assert proved > 8
    assert undecided > 20
    assert empty > 2


def _sign(number: object) -> int:
    return int(number > 0) - int(number < 0)  # type: ignore[operator]


@pytest.mark.parametrize(
    ("assumed", "polynomial", "sign"),
    [
        (["b > 0", "b < 1/10", "a*b > 1"], "a", 1),
        (["b > 0", "b < 1/10", "a*b > 1"], "a - 10", 1),
        (["a > 1", "b > 1"], "a*b - 1", 1),
        (["a > 0", "a*b > 1"], "b", 1),
        (["a > b", "b > 1"], "a**3 - b**2", 1),
        (["a**2 + b**2 < 1"], "a + b - 2", -1),
        (["a**2 + b**2 < 1"], "2*a*b - 3", -1),
        ([], "a**2 + a*b + b**2 + 1", 1),
        (["a >= 1", "a <= 1"], "a - 1", 0),
        (["a >= 1", "a <= 1", "b > a"], "a*b - 1", 1),
        # the products of so high a degree are too many: only the bounds of b decide
        (["a > 1", "b > 1"], "a**20*b - 1", 1),
    ],
)
def test_signs_that_follow(assumed: list[str], polynomial: str, sign: int) -> None:
    assert sign_of(assumed, "a b", polynomial) == sign
    assert sign_of(assumed[::-1], "b a", polynomial) == sign


def test_inequalities_of_other_parameters_take_no_room_in_a_refutation() -> None:
    """With them its products would be too many."""
    others = [f"{name} > {k}" for k, name in enumerate("cdefgh")]
    assert sign_of(["a > b", "b > 1", *others], "a b c d e f g h", "a**3 - b**2") == 1


def test_signs_between_two_thresholds_beyond_those_of_the_paper() -> None:
    """P_5 of P1^L from its threshold of order 1 to one of order 3, for all a > 2 at once.

    Its decisions are of degree one in r: between the bounds of r they follow from the values there.
    """
    bounds = ["a > 2", "r > 2", "r < 2*a**2/(a**2 - a + 1)"]
    p1 = PiecewiseLinearMap.from_sympy("Piecewise((r - 2, x <= 0), (r - a*x, True))", given=bounds)
    a, r = sympy.symbols("a r")
    expected = [0, r * (a - 1) * (a**2 + 1) / a**4, r * (a**2 - a + 1) / a**3, r / a]
    found = [jump.x for jump in p1.iterate(5).jump_crossings()]
    assert [sympy.cancel(x - y) for x, y in zip(found, expected, strict=True)] == [0] * 4


@pytest.mark.parametrize(
    ("assumed", "polynomial"),
    [(["a > 1"], "a*b - 1"), (["b > a", "a > 1"], "b**2 - 2"), (["a >= 0"], "a"), ([], "a*b")],
)
def test_signs_that_do_not_follow(assumed: list[str], polynomial: str) -> None:
    with pytest.raises(UndecidedError, match="does not follow"):
        sign_of(assumed, "a b", polynomial)


# --- Names ----------------------------------------------------------------------------------------


def test_eleven_ordered_breaks() -> None:
    """k x + b_k left of the k-th break, and 0 right of the last."""
    names = "fakcgbhdjei"
    pairs = [(k * X + sympy.Symbol(b), sympy.Lt(X, sympy.Symbol(b))) for k, b in enumerate(names)]
    formula = sympy.Piecewise(*pairs, (0, True), evaluate=False)
    given = [f"{low} < {high}" for low, high in pairwise(names)]
    map_ = PiecewiseLinearMap.from_sympy(formula, X, given=given)
    assert len(map_.pieces) == 12
    ring = map_.definition.ring
    generators = {str(symbol): gen for symbol, gen in zip(ring.symbols, ring.gens, strict=True)}
    for low, high in combinations(names, 2):
        assert map_.definition.region.sign(generators[high] - generators[low]) == 1


@pytest.mark.slow
def test_cells_do_not_depend_on_names() -> None:
    """Two slopes and an offset: the sample, and with it the cells, are the same up to names."""
    found = set()
    for slope, other, offset in permutations(["a", "b", "c"]):
        assumed = [f"{slope} < 1", f"{other} < -1", f"{slope} > 0", f"{offset} > {slope}"]
        pieces = [
            (f"{slope}*x + {offset} - mu", "x <= 0"), (f"{other}*x + mu", "x > 0")
        ]  # fmt: skip
        cells = parameter_cells(PiecewiseLinearMap(pieces, given=assumed), "mu", (1, 2))
        own = dict(zip(sympy.symbols([slope, other, offset]), sympy.symbols("s t u"), strict=True))
        edges = tuple(sympy.factor(edge.subs(own)) for edge in cells.edges)
        limits = [sympy.expand(relation.gts - relation.lts) for relation in cells.given]
        found.add((edges, frozenset(limit.subs(own) for limit in limits)))
    assert len(found) == 1


# --- What is admitted of a parameter --------------------------------------------------------------

RISING = [("x/2 + r", "x <= 0"), ("r - x/3 - 1", "x > 0")]


def intervals(diagram: Diagram) -> dict[str, list[sympy.Set]]:
    found: dict[str, list[sympy.Set]] = {}
    for branch in diagram.branches:
        found.setdefault(branch.word, []).append(branch.exact["interval"])
    return found


def test_an_assumption_with_two_components_keeps_both() -> None:
    """Without the assumption L lives for r <= 0, R for r >= 1 (L R up to 3/2)."""
    map_ = PiecewiseLinearMap(RISING, given=["r**2 > 1"])
    diagram = bifurcation_diagram(map_, "r")
    found = intervals(diagram)
    assert found["L"] == [sympy.Interval(-2, -1, False, True)]
    assert found["R"] == [sympy.Interval(1, 3, True, False)]
    assert found["LR"] == [sympy.Interval(1, Rational(3, 2), True, False)]
    ends = {p.exact["parameter"]: p.note for p in diagram.points if p.kind is PointKind.EP}
    assert ends == {
        -2: "end of the parameter span", -1: "end of what is assumed",
        1: "end of what is assumed", 3: "end of the parameter span",
    }  # fmt: skip
    cells = parameter_cells(map_, "r", (1, 2))
    three_halves = Rational(3, 2)
    assert [(c.lower, c.upper) for c in cells] == [
        (-sympy.oo, -1), (1, three_halves), (three_halves, three_halves), (three_halves, sympy.oo)
    ]  # fmt: skip
    assert cells.edges == (three_halves,)


def test_closed_assumptions_admit_their_ends() -> None:
    found = intervals(bifurcation_diagram(PiecewiseLinearMap(RISING, given=["r**2 >= 1"]), "r"))
    assert found["L"] == [sympy.Interval(-2, -1)]
    assert found["LR"] == [sympy.Interval(1, Rational(3, 2))]
    assert found["R"] == [sympy.Interval(1, 3, True, False)]  # at 1 it is 0, which belongs to L


@pytest.mark.parametrize("span", [None, (-2, 2)])
def test_a_single_value_that_is_excluded_parts_branches(span: tuple[int, int] | None) -> None:
    """2 (r - 3) is fixed for r <= 3: it passes r = 1 if nothing is assumed."""
    pieces = [("x/2 + r - 3", "x <= 0"), ("r - x/3", "x > 0")]
    whole = bifurcation_diagram(PiecewiseLinearMap(pieces), "r", (-2, 2), orders=(1,))
    parted = PiecewiseLinearMap(pieces, given=["(r - 1)**2 > 0"])
    found = intervals(bifurcation_diagram(parted, "r", span, orders=(1,)))
    assert intervals(whole)["L"] == [sympy.Interval(-2, 2)]
    assert len(found["L"]) == 2
    assert found["L"][0].end == found["L"][1].start == 1
    assert found["L"][0].right_open
    assert found["L"][1].left_open
    cells = parameter_cells(parted, "r", span=span)
    assert 1 not in cells.edges
    assert not any(c.lower < 1 < c.upper for c in cells)


@pytest.mark.parametrize("assumed", ["r**2*(r - 3)**2 <= 0", "r*(r - 3)**2 <= 0"])
def test_a_value_that_is_admitted_alone_is_refused(assumed: str) -> None:
    map_ = PiecewiseLinearMap(RISING, given=[assumed])
    with pytest.raises(ValueError, match=r"r = [03] is admitted, but no value beside it"):
        bifurcation_diagram(map_, "r")
    with pytest.raises(ValueError, match=r"r = [03] is admitted, but no value beside it"):
        parameter_cells(map_, "r")


def test_a_span_that_is_not_admitted_is_refused() -> None:
    for assumed, span in (("r**2 > 1", (-2, 2)), ("r > 1", (0, 2))):
        map_ = PiecewiseLinearMap(RISING, given=[assumed])
        with pytest.raises(ValueError, match=r"r = .* in the span contradicts the assumption"):
            bifurcation_diagram(map_, "r", span)


FALLING = [("x/2 + mu", "x <= 0"), ("mu + b - a*x - 1", "x > 0")]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("assumed", "first", "last"),
    [
        (["mu > a"], A, sympy.oo),
        (["mu > a", "mu < b", "a < b"], A, B),
        (["a*mu > 1", "a > 0"], 1 / A, sympy.oo),
        (["mu > 2*a - b", "a > 0"], 2 * A - B, sympy.oo),
    ],
)
def test_assumptions_that_relate_the_parameter_to_others(
    assumed: list[str], first: sympy.Expr, last: sympy.Expr
) -> None:
    """The cells reach as far as is assumed, and hold where their conditions do."""
    map_ = PiecewiseLinearMap(FALLING, given=assumed)
    cells = parameter_cells(map_, MU)
    assert sympy.cancel(cells.cells[0].lower - first) == 0
    assert cells.cells[-1].upper == last
    rng, tested = random.Random(10), 0
    while tested < 3:
        values = {A: Rational(rng.randint(-40, 40), 9), B: Rational(rng.randint(-40, 40), 9)}
        if all(relation.subs(values) == sympy.true for relation in cells.given):
            own = parameter_cells(map_.at(values), MU)
            shown = [(c.lower.subs(values), c.upper.subs(values)) for c in cells]
            assert shown == [(c.lower, c.upper) for c in own]
            tested += 1
    diagram = bifurcation_diagram(map_, MU)
    assert diagram.branches


def test_of_two_bounds_that_are_assumed_the_larger_counts() -> None:
    """Where a and b - 1 change places, the cells begin elsewhere: their conditions say so."""
    map_ = PiecewiseLinearMap(FALLING, given=["mu > a", "mu > b - 1"])
    cells = parameter_cells(map_, MU)
    first, tested = cells.cells[0].lower, 0
    for a, b in product(range(-9, 10), repeat=2):
        values = {A: Rational(2 * a + 1, 3), B: Rational(b, 2)}
        if all(relation.subs(values) == sympy.true for relation in cells.given):
            assert first.subs(values) == max(values[A], values[B] - 1)
            tested += 1
    assert tested > 10


def test_a_span_holds_for_all_samples_that_are_tried() -> None:
    """mu > a over (0, 1) holds for a <= 0; which a are meant is among the conditions."""
    cells = parameter_cells(PiecewiseLinearMap(FALLING, given=["mu > a"]), MU, span=(0, 1))
    assert (cells.cells[0].lower, cells.cells[-1].upper) == (0, 1)
    assert any(relation.subs(A, 1) == sympy.false for relation in cells.given)
    shifted = PiecewiseLinearMap(FALLING, given=["mu > a + 3", "mu < b - 3"])
    cells = parameter_cells(shifted, MU, span=(0, 1))
    assert (cells.cells[0].lower, cells.cells[-1].upper) == (0, 1)
    for values in ({A: -2, B: 5}, {A: -4, B: 3}):
        assert any(relation.subs(values) == sympy.false for relation in cells.given)
    with pytest.raises(ValueError, match=r"mu = .* in the span contradicts the assumption a - mu"):
        parameter_cells(PiecewiseLinearMap(FALLING, given=["mu > a", "a > 1"]), MU, span=(0, 1))


def test_an_assumption_of_higher_degree_in_the_parameter() -> None:
    map_ = PiecewiseLinearMap(FALLING, given=["mu**2 > a"])
    with pytest.raises(ValueError, match=r"assumption a - mu\*\*2 < 0 is not of degree one in mu"):
        parameter_cells(map_, MU)
    factored = PiecewiseLinearMap(FALLING, given=["mu**2 > a**2"])
    cells = parameter_cells(factored, MU)
    assert {c.upper for c in cells} & {A, -A}
    assert {c.lower for c in cells} & {A, -A}


# --- Random families ------------------------------------------------------------------------------


def family(rng: random.Random) -> tuple[list[tuple[str, str]], list[str]]:
    """A map of mu and one to three symbolic parameters, and assumptions."""
    names = rng.sample(["a", "b", "l", "s"], rng.choice([1, 2, 2, 3]))

    def formula() -> str:
        slope = rng.choice([f"{rng.choice([-2, -1, 1, 2])}*{rng.choice(names)}", "1/2", "-2", "0"])
        own = "".join(f" + {rng.choice([-3, -2, 1, 2])}*{name}" for name in names)
        return f"({slope})*x + {rng.choice([-1, 1, 2])}*mu{own} + {rng.randint(-3, 3)}"

    bend = rng.choice(names)
    breaks = rng.choice([["0"], [bend], [f"{bend}/2"], ["0", bend], [f"-{bend}", bend]])
    assumed = [f"{bend} > 0"] + [f"{n} > {rng.randint(-2, 2)}" for n in names if rng.random() < 0.5]
    if len(names) > 1 and rng.random() < 0.5:
        assumed.append(rng.choice(["{0} > 2*{1}", "{0} + {1} > 3", "{0}*{1} > 1"]).format(*names))
    if rng.random() < 0.3:
        assumed.append(rng.choice(["mu > {0}", "{0}*mu > 1", "mu < {0}"]).format(*names))
    conditions = [f"x < {breaks[0]}"]
    conditions += [f"(x >= {low}) & (x < {high})" for low, high in pairwise(breaks)]
    conditions.append(f"x >= {breaks[-1]}")
    return [(formula(), condition) for condition in conditions], assumed


def shown_by(cell: object, values: Mapping[sympy.Symbol, Rational]) -> tuple[object, ...]:
    """Ends of a cell, and its fixed points, at values of the symbolic parameters."""
    points = cell.map.fixed_points()  # type: ignore[attr-defined]
    ends = cell.lower.subs(values), cell.upper.subs(values)  # type: ignore[attr-defined]
    return (*ends, *((p.word, p.stable) for p in points))


@pytest.mark.nightly
@pytest.mark.parametrize("seed", range(3))
def test_random_families_are_answered(seed: int) -> None:
    """No sample is refused by chance, and at other values the cells are the same."""
    rng, compared = random.Random(seed), 0
    for _ in range(31):
        pieces, assumed = family(rng)
        map_ = PiecewiseLinearMap(pieces, given=assumed)
        cells = parameter_cells(map_, MU)
        others = [symbol for symbol in map_.parameters if symbol != MU]
        for _ in range(40):
            values = {symbol: Rational(rng.randint(-600, 600), 101) for symbol in others}
            if all(relation.subs(values) == sympy.true for relation in cells.given):
                own = parameter_cells(map_.at(values), MU)
                assert [shown_by(c, values) for c in cells] == [shown_by(c, {}) for c in own]
                compared += 1
                break
    assert compared > 10


@pytest.mark.parametrize(("typed", "shown"), [
    ("a < 1/2", "a < 1/2"), ("a/2 > 3", "a > 6"), ("-2*a <= 3", "a >= -3/2"),
    ("2*a*b < 1/3", "6*a*b < 1"), ("a + b < 1/2", "2*a + 2*b < 1"),
])  # fmt: skip
def test_assumptions_are_shown_without_needless_factors(typed: str, shown: str) -> None:
    map_ = PiecewiseLinearMap.from_sympy("a*x + b", given=[typed])
    assert [*map(str, map_.given)] == [shown]
