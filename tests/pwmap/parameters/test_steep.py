"""Maps that contract or expand strongly: nothing hangs on the size of a number.

Slopes reach from 10**-5 to 10**6 and breaks are as close as 10**-18, so that a float could tell
neither the edges nor the points of a diagram apart.
"""

import random
from fractions import Fraction
from functools import cmp_to_key
from itertools import pairwise
from typing import Any

import pytest
import sympy
from comparisons import Case, Report, check_at
from effort import at_most
from families import Family, family
from readings import Place, between, compared, place
from sympy import QQ

from pwmap import PiecewiseLinearMap, bifurcation_diagram
from pwmap.algebra.exact import HIGHEST, LOWEST, to_float
from pwmap.algebra.roots import RealRoot, algebraic, real_roots, simplest_between

GOLDEN = real_roots([QQ(1), QQ(-1), QQ(-1)])[1]
CLOSE = Fraction(1, 10**18)


# --- Random maps ----------------------------------------------------------------------------------


def scaled(rng: random.Random, low: int, high: int) -> Fraction:
    """A random number of either sign whose size is a power of ten, about."""
    return (
        rng.choice([-1, 1]) * Fraction(rng.randint(1, 3)) * Fraction(10) ** rng.randint(low, high)
    )


def steep_case(seed: int) -> Family:
    """Two to four pieces over p with slopes and breaks of very different sizes."""
    rng = random.Random(1000 + seed)
    breaks = [Fraction(rng.randint(-2, 2), rng.randint(1, 3))]
    while len(breaks) < rng.choice([1, 1, 2, 3]):
        breaks.append(breaks[-1] + rng.choice([CLOSE, abs(scaled(rng, -9, 1))]))
    owners = "".join(rng.choice("lrp") for _ in breaks)
    n = len(breaks) + 1 + owners.count("p")
    low, high = rng.choice([(-5, -1), (1, 6), (-5, 6)])
    slopes = [(scaled(rng, low, high),) for _ in range(n)]
    intercepts = [
        (rng.choice([Fraction(0), scaled(rng, -6, 6)]), rng.choice([-1, 0, 1, 1])) for _ in range(n)
    ]
    intercepts[-1] = intercepts[-1][0], 1  # p occurs at least once
    drift = rng.choice([0, 0, 1])
    return family(
        [(b, drift) for b in breaks],
        owners,
        list(zip(slopes, intercepts, strict=True)),
        span=(Fraction(-31, 13), Fraction(37, 14)),
        orders=(1, 2, 3, 4) if len(breaks) == 1 else (1, 2, 3),
    )


def check(
    family_: Family, *, own_span: bool = True, beside: Fraction | None = None, most: int = 99
) -> Case:
    """A diagram against brute force: on its edges, close beside them and between them."""
    case = Case.of(family_, Report(), own_span=own_span)
    edges = sorted(case.formulas(), key=cmp_to_key(compared))
    inner: list[tuple[Place, bool]] = [(p, True) for p in edges[1:-1]]
    others = list[tuple[Place, bool]]()
    for a, b in pairwise(edges):
        middle = between(a, b)
        close = middle
        for _ in range(30):  # halvings
            close = between(a, close)
        others += [(middle, False), (close, False)]
    if beside is not None:
        others = [
            (p + side * beside, p + side * beside in edges)
            for p, _ in inner
            if isinstance(p, Fraction)
            for side in (-1, 1)
        ]
    rng = random.Random(7)
    for places in (inner, others):
        for p, on_edge in places if len(places) <= most else rng.sample(places, most):
            check_at(case, p, on_edge=on_edge)
    assert not case.report.differences
    return case


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(0, 650, 130))
def test_strongly_contracting_or_expanding_maps(seed: int) -> None:
    """Some of 650 maps, all of which were run once."""
    check(steep_case(seed), own_span=seed % 2 == 0, most=12)


# --- Numbers --------------------------------------------------------------------------------------


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


def test_roots_are_told_apart_from_rationals_and_roots_close_by() -> None:
    two = real_roots([QQ(1), QQ(0), QQ(-2)])[1]
    shifted = real_roots([QQ(1), -2 * QQ(1, 10**30), QQ(1, 10**60) - 2])[1]  # sqrt(2) + 1e-30
    below = QQ(int(sympy.floor(sympy.sqrt(2) * 10**60)), 10**60)
    assert below < two < shifted
    assert two < below + QQ(1, 10**60)
    assert not two < two


def test_isolating_roots_takes_steps_for_bits_not_for_quotients() -> None:
    # without t^9 and two small terms this is 10^30 (t^8 - 3 t^7 + t^5 - 2 t^3 - 1/3), which has two
    # roots; the third is where t^9 + 10^30 t^8 vanishes
    big = QQ(10**30)
    polynomial = (QQ(1), big, -3 * big, QQ(0), big, QQ(0), -2 * big, QQ(1), QQ(7), -big / 3)
    with at_most(100_000):  # 5 million calls by continued fractions, whose quotients are as large
        roots = real_roots(polynomial)
    # those of degree eight as numpy.roots has them, to some 1e-15
    assert [float(root) for root in roots] == pytest.approx(
        [-1e30, -0.5484724203113454, 2.909988518072986], rel=1e-14
    )
    of = sympy.Symbol("t")
    whole = sympy.Poly([QQ.to_sympy(c) for c in polynomial], of)
    assert len(roots) == whole.count_roots()  # by Sturm's chain
    assert [algebraic(sympy.CRootOf(whole, k)) for k in range(3)] == [*roots]


def test_a_root_that_is_not_real_is_refused_by_its_place_among_the_roots() -> None:
    of = sympy.Symbol("t")
    whole = of**5 - of + 1  # one real root
    assert float(algebraic(sympy.CRootOf(whole, 0))) == pytest.approx(-1.1673039782614187)
    with pytest.raises(ValueError, match="expected a real algebraic number, got CRootOf"):
        algebraic(sympy.CRootOf(whole, 1))


def test_floats_of_what_is_too_large_are_infinite() -> None:
    assert to_float(QQ(10**400, 3)) == float("inf")
    assert to_float(QQ(-(10**400))) == float("-inf")
    assert to_float(QQ(10**400, 10**400 + 1)) == 1.0
    one = (QQ(1),)
    assert GOLDEN.to_float((QQ(1), QQ(0)), one) == float(GOLDEN) == (1 + 5**0.5) / 2
    assert GOLDEN.to_float((QQ(1), QQ(-1), QQ(-1)), one) == 0.0  # and no dust of rounding
    near = QQ(10946, 6765)
    assert GOLDEN.to_float((QQ(1), -near), one) == pytest.approx(-9.7719e-9, rel=1e-4)
    assert GOLDEN.to_float((QQ(10**400), QQ(1)), one) == float("inf")


# --- Maps that once hung or crashed ---------------------------------------------------------------


@pytest.mark.nightly
@pytest.mark.parametrize("a", [Fraction(1, 10**4), Fraction(1, 10**5)])
def test_strong_contraction_with_a_jump(a: Fraction) -> None:
    rows = [((a,), (0, 1)), ((a,), (-1, 1))]
    case = check(family([()], "l", rows, span=(-1, 2), orders=range(1, 6)))
    assert (len(case.diagram.branches), len(case.diagram.points)) == (97, 76)
    floats = {p.parameter for p in case.diagram.points}
    assert len(floats) < len(case.formulas())  # some edges are the same float, still told apart


def test_expansion_by_a_million() -> None:
    rows = [((), (-2, 1)), ((-(10**6),), (0, 1))]
    steep = family([()], "l", rows, span=(-1, 3), orders=range(1, 5))
    case = check(steep, own_span=False, beside=CLOSE)
    assert (len(case.diagram.branches), len(case.diagram.points)) == (21, 21)


def test_edges_closer_than_floats() -> None:
    third = Fraction(1, 3)
    rows = [((), (-third, 1)), ((Fraction(-1, 2),), (-third - CLOSE, 1))]
    close = family([()], "l", rows, span=(-1, 2), orders=(1, 2, 3))
    case = check(close, own_span=False, beside=CLOSE / 2)
    inner = [p for p in case.diagram.points if p.kind != "EP"]
    edges = {place(p.exact["parameter"]) for p in inner}  # type: ignore[arg-type]
    assert edges == {third, third + CLOSE, third + 2 * CLOSE}
    assert len({p.parameter for p in inner}) == 1


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
