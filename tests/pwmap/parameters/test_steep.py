"""Maps that contract or expand strongly: nothing hangs on the size of a number.

Slopes reach from 10**-5 to 10**6 and breaks are as close as 10**-18, so that a float could tell
neither the edges nor the points of a diagram apart.
"""

from __future__ import annotations

import pickle
import random
from fractions import Fraction
from itertools import pairwise
from typing import Any

import pytest
import sympy
from brute import map_of
from independent import Parts
from sympy import QQ, Rational
from test_brute_force import Case, R, check_diagram, curves, number, written

from pwmap import PiecewiseLinearMap, bifurcation_diagram
from pwmap.algebra.exact import HIGHEST, LOWEST, floor, to_float
from pwmap.algebra.roots import RealRoot, ceiling, real_roots, simplest_between, whole_part

GOLDEN = real_roots([QQ(1), QQ(-1), QQ(-1)])[1]
CLOSE = Fraction(1, 10**18)


# --- Random maps ----------------------------------------------------------------------------------


def scaled(rng: random.Random, low: int, high: int) -> Fraction:
    """A random number of either sign whose size is a power of ten, about."""
    return (
        rng.choice([-1, 1]) * Fraction(rng.randint(1, 3)) * Fraction(10) ** rng.randint(low, high)
    )


def steep_case(seed: int) -> Case:
    """Two to four pieces over r with slopes and breaks of very different sizes."""
    rng = random.Random(1000 + seed)
    breaks = [Fraction(rng.randint(-2, 2), rng.randint(1, 3))]
    while len(breaks) < rng.choice([1, 1, 2, 3]):
        breaks.append(breaks[-1] + rng.choice([CLOSE, abs(scaled(rng, -9, 1))]))
    owners = [rng.choice(["left", "right", "point"]) for _ in breaks]
    n = len(breaks) + 1 + owners.count("point")
    low, high = rng.choice([(-5, -1), (1, 6), (-5, 6)])
    slopes = [scaled(rng, low, high) for _ in range(n)]
    intercepts = [
        (rng.choice([Fraction(0), scaled(rng, -6, 6)]), Fraction(rng.choice([-1, 0, 1, 1])))
        for _ in range(n)
    ]
    intercepts[-1] = intercepts[-1][0], Fraction(1)  # r occurs at least once
    drift = rng.choice([0, 0, 1])

    def parts(r: Any) -> Parts:
        formulas = [(m, c + e * r) for m, (c, e) in zip(slopes, intercepts, strict=True)]
        return map_of([b + drift * r for b in breaks], owners, formulas)

    return Case(
        map=PiecewiseLinearMap([written(part) for part in parts(R)]),
        parts=parts,
        span=(Fraction(-31, 13), Fraction(37, 14)),
        orders=(1, 2, 3, 4) if len(breaks) == 1 else (1, 2, 3),
    )


def check(case: Case, own_span: bool) -> None:
    """A diagram against brute force: on its edges, close beside them and between them."""
    span = case.span if own_span else None
    diagram = bifurcation_diagram(case.map, case.name, span, case.orders)
    edges = sorted({number(p.exact["parameter"]) for p in diagram.points})  # type: ignore[arg-type]
    inner = edges[1:-1]
    beside = [x for a, b in pairwise(edges) for x in ((a + b) / 2, a + (b - a) / 10**9)]
    rng = random.Random(7)
    branches = curves(diagram)
    for values in (inner, beside):
        for value in values if len(values) <= 12 else rng.sample(values, 12):
            check_diagram(branches, case, value)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(0, 650, 130))
def test_strongly_contracting_or_expanding_maps(seed: int) -> None:
    """Some of 650 maps, all of which were run once."""
    check(steep_case(seed), own_span=seed % 2 == 0)


# --- Numbers --------------------------------------------------------------------------------------


def test_floor_of_a_number_just_below_an_integer() -> None:
    assert floor(QQ(3 * 10**20 - 1, 10**20)) == 2
    assert floor(QQ(-(10**40) - 1, 10**40)) == -2
    assert [whole_part(QQ(7)), ceiling(QQ(7)), ceiling(QQ(6 * 10**30 + 1, 10**30))] == [7, 7, 7]
    assert [whole_part(GOLDEN), ceiling(GOLDEN)] == [1, 2]
    assert type(floor(QQ(7, 2))) is int


@pytest.mark.parametrize(
    ("low", "high", "simplest"),
    [
        (QQ(3 * 10**20 - 1, 10**20), QQ(3), QQ(3 * (10**20 + 1) - 1, 10**20 + 1)),
        (QQ(3), QQ(3) + QQ(1, 10**18), QQ(3) + QQ(1, 10**18 + 1)),
        (QQ(-1, 10**9), QQ(1, 10**30), QQ(0)),
        (QQ(-7, 2), QQ(-10, 3), QQ(-17, 5)),
        (QQ(-(10**20)), HIGHEST, QQ(0)),
        (QQ(10**20) + QQ(1, 2), HIGHEST, QQ(10**20 + 1)),
        (LOWEST, QQ(-(10**20)), QQ(-(10**20) - 1)),
    ],
)
def test_simplest_rational_between_two(low: Any, high: Any, simplest: Any) -> None:
    assert simplest_between(low, high) == simplest


def test_simplest_rational_beside_a_root_does_not_depend_on_how_well_it_is_known() -> None:
    fresh, known = (RealRoot(GOLDEN.polynomial, 1, QQ(1), QQ(2)) for _ in range(2))
    for _ in range(3):
        known.refine()
    near = QQ(10946, 6765)  # a convergent, 1e-8 above it: the next but one is the answer
    assert simplest_between(fresh, near) == simplest_between(known, near) == QQ(28657, 17711)


def test_continued_fractions_of_thousands_of_terms() -> None:
    """Neighbouring quotients of Fibonacci numbers need as many steps as there are numbers."""
    a, b = 0, 1
    for _ in range(3000):
        a, b = b, a + b
    low, high = sorted([QQ(a, b), QQ(b, a + b)])
    assert simplest_between(low, high) == QQ(a + b, a + 2 * b)


def test_roots_are_told_apart_from_rationals_and_roots_close_by() -> None:
    two = real_roots([QQ(1), QQ(0), QQ(-2)])[1]
    shifted = real_roots([QQ(1), -2 * QQ(1, 10**30), QQ(1, 10**60) - 2])[1]  # sqrt(2) + 1e-30
    below = QQ(int(sympy.floor(sympy.sqrt(2) * 10**60)), 10**60)
    assert below < two < shifted
    assert two < below + QQ(1, 10**60)
    assert not two < two
    again = pickle.loads(pickle.dumps(two))
    assert (again, hash(again), again < shifted) == (two, hash(two), True)


def test_floats_of_what_is_too_large_are_infinite() -> None:
    assert to_float(QQ(10**400, 3)) == float("inf")
    assert to_float(QQ(-(10**400))) == float("-inf")
    assert to_float(QQ(10**400, 10**400 + 1)) == 1.0
    one = (QQ(1),)
    assert GOLDEN.to_float((QQ(1), QQ(0)), one) == (1 + 5**0.5) / 2
    assert GOLDEN.to_float((QQ(1), QQ(-1), QQ(-1)), one) == 0.0  # and no dust of rounding
    near = QQ(10946, 6765)
    assert GOLDEN.to_float((QQ(1), -near), one) == pytest.approx(-9.7719e-9, rel=1e-4)
    assert GOLDEN.to_float((QQ(10**400), QQ(1)), one) == float("inf")


# --- Maps that once hung or crashed ---------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("A", [Rational(1, 10**4), Rational(1, 10**5)])
def test_strong_contraction_with_a_jump(A: sympy.Rational) -> None:  # noqa: N803
    case = Case(
        map=PiecewiseLinearMap([("x*A + r", "x <= 0"), ("x*A + r - 1", "x > 0")]).at({"A": A}),
        parts=lambda r: map_of(
            [Fraction(0)], ["left"], [(Fraction(int(A.p), int(A.q)), r + e) for e in (0, -1)]
        ),
        span=(Fraction(-1), Fraction(2)),
        orders=(1, 2, 3, 4, 5),
    )
    diagram = bifurcation_diagram(case.map, "r", case.span, case.orders)
    assert (len(diagram.branches), len(diagram.points)) == (97, 76)
    exact = sorted({number(p.exact["parameter"]) for p in diagram.points})  # type: ignore[arg-type]
    floats = {p.parameter for p in diagram.points}
    assert len(floats) < len(exact)  # some edges are the same float, and still told apart
    branches = curves(diagram)
    for value in exact[1:-1]:
        check_diagram(branches, case, value)


def test_expansion_by_a_million() -> None:
    a = Fraction(10**6)
    case = Case(
        map=PiecewiseLinearMap([("r - 2", "x <= 0"), ("r - a*x", "x > 0")]).at({"a": 10**6}),
        parts=lambda r: map_of([Fraction(0)], ["left"], [(Fraction(0), r - 2), (-a, r)]),
        span=(Fraction(-1), Fraction(3)),
        orders=(1, 2, 3, 4),
    )
    diagram = bifurcation_diagram(case.map, "r", orders=case.orders)
    assert (len(diagram.branches), len(diagram.points)) == (21, 21)
    branches = curves(diagram)
    exact = sorted({number(p.exact["parameter"]) for p in diagram.points})  # type: ignore[arg-type]
    for value in exact[1:-1]:
        for near in (value - CLOSE, value, value + CLOSE):
            check_diagram(branches, case, near)


def test_edges_closer_than_floats() -> None:
    third = Fraction(1, 3)
    case = Case(
        map=PiecewiseLinearMap([("r - 1/3", "x <= 0"), ("r - x/2 - 1/3 - 1/10**18", "x > 0")]),
        parts=lambda r: map_of(
            [Fraction(0)],
            ["left"],
            [(Fraction(0), r - third), (Fraction(-1, 2), r - third - CLOSE)],
        ),
        span=(Fraction(-1), Fraction(2)),
        orders=(1, 2, 3),
    )
    diagram = bifurcation_diagram(case.map, "r", orders=case.orders)
    inner = [p for p in diagram.points if p.kind != "EP"]
    edges = sorted({number(p.exact["parameter"]) for p in inner})  # type: ignore[arg-type]
    assert edges == [third, third + CLOSE, third + 2 * CLOSE]
    assert len({p.parameter for p in inner}) == 1
    branches = curves(diagram)
    for value in edges:
        for near in (value - CLOSE / 2, value, value + CLOSE / 2):
            check_diagram(branches, case, near)


def test_points_of_one_float_are_in_order() -> None:
    """Fixed points of three pieces within 10**-18 of each other."""
    map_ = PiecewiseLinearMap(
        [("r + 2 - x", "x < 1"), ("3/2*x - 1/2", "(x >= 1) & (x <= 1 + 1/10**18)"),
         ("r + 2 + 4/10**18 - x", "x > 1 + 1/10**18")]
    )  # fmt: skip
    diagram = bifurcation_diagram(map_, "r", (-1, 1), (1,))
    positions = [(p.exact["parameter"], p.exact["x"]) for p in diagram.points]
    assert positions == sorted(positions)  # type: ignore[type-var]
    assert len({p.x for p in diagram.points}) < len({p.exact["x"] for p in diagram.points})


def test_words_of_thousands_of_letters() -> None:
    map_ = PiecewiseLinearMap([("r - 2", "x <= 0"), ("r - x*5/4", "x > 0")]).at({"r": 4})
    n = 3000
    slope, intercept = map_.orbits.affine((1,) * n)
    assert slope == QQ(5, 4) ** n
    assert map_.orbits.orbit(0, (1,) * n) == intercept == 4 * (1 - slope) / QQ(9, 4)
    assert map_.orbits.slope((1, 0, 1))[0] == 0
