"""Iterates, cells and diagrams against brute force that follows single points in fractions."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache, total_ordering
from itertools import pairwise
from math import gcd
from typing import Any

import brute
import mpmath
import pytest
import sympy
from brute import map_of, spelled
from independent import Part, Parts

from pwmap import (
    Branch,
    BranchKind,
    Diagram,
    ParameterCell,
    PiecewiseLinearMap,
    PointKind,
    SpecialPoint,
    UndecidedError,
    bifurcation_diagram,
    parameter_cells,
)
from pwmap.diagrams import Stretch

Record = tuple[Any, ...]

A, R, S, X = sympy.symbols("a r s x")
PAPER = PiecewiseLinearMap([("r - 2", "x <= 0"), ("r - a*x", "x > 0")], given=["a > 1"])
MANY = mpmath.MPContext()
MANY.dps = 80  # digits of the numbers that stand for algebraic values of a parameter
NEAR = MANY.mpf(10) ** -40  # differences of two such numbers that mean equality


@total_ordering
class Near:
    """A number with many digits; two that agree in half of them are equal."""

    mpf: Any

    def __init__(self, number: object) -> None:
        if isinstance(number, Near):
            self.mpf = number.mpf
        elif isinstance(number, Fraction):
            self.mpf = MANY.mpf(number.numerator) / number.denominator
        else:
            self.mpf = MANY.mpf(number)

    def __add__(self, other: object) -> Near:
        return Near(self.mpf + Near(other).mpf)

    def __sub__(self, other: object) -> Near:
        return Near(self.mpf - Near(other).mpf)

    def __mul__(self, other: object) -> Near:
        return Near(self.mpf * Near(other).mpf)

    def __truediv__(self, other: object) -> Near:
        return Near(self.mpf / Near(other).mpf)

    def __rsub__(self, other: object) -> Near:
        return Near(other) - self

    def __neg__(self) -> Near:
        return Near(0) - self

    def __rtruediv__(self, other: object) -> Near:
        return Near(other) / self

    __radd__, __rmul__ = __add__, __mul__

    def __eq__(self, other: object) -> bool:
        return other is not None and bool(abs(self.mpf - Near(other).mpf) < NEAR)

    def __lt__(self, other: object) -> bool:
        return bool(self.mpf - Near(other).mpf <= -NEAR)

    def __hash__(self) -> int:
        return 0  # equality is not exact

    def __repr__(self) -> str:
        return f"{mpmath.nstr(self.mpf, 12)}..."


# --- Formulas of pwmap as numbers -----------------------------------------------------------------


@cache
def coefficients(expr: sympy.Expr) -> tuple[list[Fraction], list[Fraction]]:
    """Numerator and denominator of a quotient of polynomials in at most one symbol."""
    symbol = next(iter(expr.free_symbols), X)
    return tuple(  # type: ignore[return-value]
        [fraction(c) for c in sympy.Poly(part, symbol).all_coeffs()]
        for part in sympy.fraction(sympy.together(expr))
    )


def fraction(number: sympy.Rational) -> Fraction:
    return Fraction(int(number.p), int(number.q))


def evaluated(expr: sympy.Expr, at: Any = None) -> Any:
    """An expression at a value of its one parameter; None for nan and infinity."""
    if expr in (sympy.nan, sympy.oo, -sympy.oo):
        return None
    parts = []
    for polynomial in coefficients(expr):
        total = 0 * (Fraction(1) if at is None else at)
        for coefficient in polynomial:
            total = total * (Fraction(0) if at is None else at) + coefficient
        parts.append(total)
    return parts[0] / parts[1]


def number(expr: sympy.Expr) -> Any:
    """A constant: rationals as they are, algebraic numbers with many digits."""
    return fraction(expr) if expr.is_Rational else Near(sympy.N(expr, MANY.dps)._mpf_)


# --- Comparing one iterate ------------------------------------------------------------------------


def check_diagonal(map_: PiecewiseLinearMap, f: Parts, j: int, at: Any = None) -> None:
    """Fixed points, bands of them and jump crossings of one iterate."""
    iterate = map_.iterate(j)
    j *= map_.order  # a map may be an iterate itself
    found: list[Record] = [
        (evaluated(p.x, at), p.word, evaluated(p.multiplier, at), p.period, p.stable, p.at_border)
        for p in iterate.fixed_points()
    ]
    expected: list[Record] = [
        (p.x, spelled(map_.letters, p.word), p.multiplier, p.period, p.stable, p.at_border)
        for p in brute.fixed_points(f, j)
    ]
    assert found == expected
    found = [
        (*ends_of(band.interval, at), band.word, band.period) for band in iterate.fixed_intervals()
    ]
    expected = [
        (part.lo, part.lo_in, part.hi, part.hi_in, spelled(map_.letters, part.word), period)
        for part, period in brute.bands(f, j)
    ]
    assert found == expected
    found = [
        (*(evaluated(v, at) for v in (c.x, c.left, c.right)), f"{c.left_word}|{c.right_word}")
        for c in iterate.jump_crossings()
    ]
    expected = [
        (c.x, c.left, c.right, spelled(map_.letters, c.words)) for c in brute.crossings(f, j)
    ]
    assert found == expected


def ends_of(interval: sympy.Interval, at: Any = None) -> Record:
    lo, hi = (evaluated(end, at) for end in (interval.start, interval.end))
    return (
        lo,
        lo is not None and not interval.left_open,
        hi,
        hi is not None and not interval.right_open,
    )


def check_pieces(map_: PiecewiseLinearMap, f: Parts, j: int, at: Any = None) -> None:
    """Breaks, who owns them, slopes, values and words of one iterate."""
    found: list[Record] = []
    for p in map_.iterate(j).pieces:
        lo, hi = evaluated(p.lower, at), evaluated(p.upper, at)
        slope, intercept = evaluated(p.slope, at), evaluated(p.intercept, at)
        if lo is not None and lo == hi:
            slope, intercept = 0, slope * lo + intercept  # of a point only the value counts
        found.append((lo, p.lower_closed, hi, p.upper_closed, slope, intercept, p.word))
    assert found == brute.rows(f, j * map_.order, map_.letters)


# --- The maps -------------------------------------------------------------------------------------


def numbers(part: Part) -> dict[str, Fraction]:
    """What is a number of a piece."""
    values = {name: getattr(part, name) for name in ("lo", "hi", "slope", "intercept")}
    return {name: value for name, value in values.items() if value is not None}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Case:
    """A map over one parameter, and the same map for brute force."""

    map: PiecewiseLinearMap
    parts: Callable[[Any], Parts]
    span: tuple[Fraction, Fraction]
    orders: tuple[int, ...]
    samples: int = 120  # of the parameter, where the search for missed edges looks

    @property
    def name(self) -> str:
        return str(self.map.parameters[0])

    def at(self, value: Any) -> Parts:
        """The map for brute force at a value of the parameter."""
        parts = self.parts(value)
        if isinstance(value, Fraction):
            return parts
        return tuple(replace(p, **{n: Near(v) for n, v in numbers(p).items()}) for p in parts)


def paper(a: Fraction) -> Case:
    """P1^L of the paper: r - 2 for x <= 0, r - a x for x > 0."""
    return Case(
        map=PAPER.at({"a": a}),
        parts=lambda r: map_of([Fraction(0)], ["left"], [(Fraction(0), r - 2), (-a, r)]),
        span=(Fraction(-1), 4 / (a - 1) + 3),
        orders=(1, 2, 3, 4, 5),
        samples=300,
    )


def three() -> Case:
    """x/2 + 1 left of -s, 1 - s x up to 1, s x/2 - 2 right of 1, for s > 0."""
    one, half = Fraction(1), Fraction(1, 2)
    return Case(
        map=PiecewiseLinearMap(
            [
                ("x/2 + 1", "x < -s"),
                ("1 - s*x", "(-s <= x) & (x <= 1)"),
                ("s*x/2 - 2", "x > 1"),
            ],
            given=["s > 0"],
        ),
        parts=lambda s: map_of(
            [-s, one], ["right", "left"], [(half, one), (-s, one), (s / 2, Fraction(-2))]
        ),
        span=(Fraction(1, 10), Fraction(3)),
        orders=(1, 2, 3, 4),
    )


def point() -> Case:
    """1 - x left of 0, r at 0, x/2 - r right of it."""
    return Case(
        map=PiecewiseLinearMap.from_sympy(
            "Piecewise((1 - x, x < 0), (r, Eq(x, 0)), (x/2 - r, True))"
        ),
        parts=lambda r: map_of(
            [Fraction(0)],
            ["point"],
            [(Fraction(-1), Fraction(1)), (Fraction(0), r), (Fraction(1, 2), -r)],
        ),
        span=(Fraction(-4), Fraction(4)),
        orders=(1, 2, 3, 4, 5),
    )  # fmt: skip


def moving() -> Case:
    """1/2 - x left of r, a point of slope 2 at r, 2 r - 2 x right of it up to 2, 1 beyond."""
    return Case(
        map=PiecewiseLinearMap(
            [
                ("1/2 - x", "x < r"),
                ("2*x - 1", "Eq(x, r)"),
                ("2*r - 2*x", "(r < x) & (x < 2)"),
                ("1", "x >= 2"),
            ],
            given=["r < 2"],
        ),
        parts=lambda r: map_of(
            [r, Fraction(2)],
            ["point", "right"],
            [
                (Fraction(-1), Fraction(1, 2)),
                (Fraction(0), 2 * r - 1),
                (Fraction(-2), 2 * r),
                (Fraction(0), Fraction(1)),
            ],
        ),
        span=(Fraction(-3), Fraction(19, 10)),
        orders=(1, 2, 3, 4),
    )


def tent() -> Case:
    """Continuous: x/2 + r left of 0, r - 3 x right of it."""
    return Case(
        map=PiecewiseLinearMap([("x/2 + r", "x < 0"), ("r - 3*x", "x >= 0")]),
        parts=lambda r: map_of([Fraction(0)], ["right"], [(Fraction(1, 2), r), (Fraction(-3), r)]),
        span=(Fraction(-2), Fraction(2)),
        orders=(1, 2, 3, 4, 5),
    )


def roof() -> Case:
    """Continuous with a moving break: 2 x + 1 up to r, 4 r + 1 - 2 x beyond."""
    return Case(
        map=PiecewiseLinearMap([("2*x + 1", "x <= r"), ("4*r + 1 - 2*x", "x > r")]),
        parts=lambda r: map_of(
            [r], ["left"], [(Fraction(2), Fraction(1)), (Fraction(-2), 4 * r + 1)]
        ),
        span=(Fraction(-3), Fraction(3)),
        orders=(1, 2, 3, 4),
    )


def mirror() -> Case:
    """r - x up to 0, a band of period two for r < 0; x/2 - 1 beyond."""
    return Case(
        map=PiecewiseLinearMap([("r - x", "x <= 0"), ("x/2 - 1", "x > 0")]),
        parts=lambda r: map_of(
            [Fraction(0)], ["left"], [(Fraction(-1), r), (Fraction(1, 2), Fraction(-1))]
        ),
        span=(Fraction(-3), Fraction(5)),
        orders=(1, 2, 3, 4),
    )


def random_case(seed: int) -> Case:
    """Up to four pieces and points with small coefficients, some of which hold the parameter r."""
    rng = random.Random(seed)
    small = sorted({Fraction(n, d) for n in range(-3, 4) for d in (1, 2)})
    breaks = sorted(rng.sample(small, rng.randint(1, 2)))
    owners = [rng.choice(["left", "right", "point"]) for _ in breaks]
    n = len(breaks) + 1 + owners.count("point")
    drift = Fraction(rng.choice([0, 0, 1]))  # all breaks move with the parameter, or none
    slopes = [(rng.choice(small), Fraction(0)) for _ in range(n)]
    if rng.random() < 0.4:
        slopes[rng.randrange(n)] = (rng.choice(small), Fraction(1))
    intercepts = [(rng.choice(small), Fraction(rng.choice([-1, 0, 1, 2]))) for _ in range(n)]

    def parts(r: Any) -> Parts:
        def at(pair: tuple[Fraction, Fraction]) -> Any:
            return pair[0] + pair[1] * r

        formulas = [(at(m), at(c)) for m, c in zip(slopes, intercepts, strict=True)]
        return map_of([b + drift * r for b in breaks], owners, formulas)

    return Case(
        map=PiecewiseLinearMap([written(part) for part in parts(R)]),
        parts=parts,
        span=(Fraction(-31, 13), Fraction(37, 14)),
        orders=(1, 2, 3),
    )


def written(part: Part) -> tuple[sympy.Expr, sympy.Basic]:
    """Formula and condition of a piece whose numbers are sympy expressions."""
    bounds: list[sympy.Basic] = []
    if part.lo is not None:
        bounds.append(part.lo <= X if part.lo_in else part.lo < X)
    if part.hi is not None:
        bounds.append(part.hi >= X if part.hi_in else part.hi > X)
    return part.slope * X + part.intercept, sympy.And(*bounds)


CASES = {
    "paper-5/4": paper(Fraction(5, 4)),
    "paper-7/5": paper(Fraction(7, 5)),
    "paper-2": paper(Fraction(2)),
    "paper-19/6": paper(Fraction(19, 6)),
    "three": three(),
    "point": point(),
    "moving": moving(),
    "tent": tent(),
    "roof": roof(),
    "mirror": mirror(),
    "second-iterate": replace(
        paper(Fraction(5, 4)), map=PAPER.at({"a": "5/4"}).iterate(2), orders=(1, 2, 3)
    ),
    "second-iterate-of-mirror": replace(mirror(), map=mirror().map.iterate(2), orders=(1, 2)),
    **{f"random-{seed}": random_case(seed) for seed in range(8)},
}
every_case = pytest.mark.parametrize("case", CASES.values(), ids=CASES.keys())


def between(rng: random.Random, lo: Any, hi: Any) -> Fraction:
    """A random rational strictly between two numbers."""
    while True:
        low, high = (Fraction(str(end.mpf)) if isinstance(end, Near) else end for end in (lo, hi))
        found = low + (high - low) * Fraction(rng.randint(1, 9999), 10000)
        found = found.limit_denominator(10**6)
        if lo < found < hi:
            return found


def samples(case: Case, n: int) -> list[Fraction]:
    """Parameters that part the span in equal steps, each moved a little."""
    rng = random.Random(20010101)
    low, high = case.span
    step = (high - low) / n
    return [low + step * (i + Fraction(rng.randint(1, 999), 1000)) for i in range(n)]


# --- Iterates -------------------------------------------------------------------------------------


@pytest.mark.slow
def test_iterates_of_the_paper_at_random_parameters() -> None:
    rng = random.Random(14)
    for _ in range(150):
        q = rng.randint(1, 60)
        a = Fraction(rng.randint(q + 1, 4 * q), q) if q > 1 else Fraction(rng.choice([2, 3]))
        r = Fraction(rng.randint(-1000, 15000), 1000)
        case = paper(a)
        map_, f = case.map.at({"r": r}), case.at(r)
        for j in range(1, 7):
            check_diagonal(map_, f, j)
            check_pieces(map_, f, j)


@pytest.mark.slow
@pytest.mark.parametrize("a", ["5/4", "3/2", "8/5", "2", "7/3", "3", "15/4"])
def test_iterates_of_the_paper_exactly_on_edges(a: str) -> None:
    case = paper(Fraction(a))
    edges = parameter_cells(case.map, "r", orders=case.orders).edges
    assert len(edges) >= 6
    for edge in edges:
        r = fraction(edge)
        for j in range(1, 7):
            check_diagonal(case.map.at({"r": r}), case.at(r), j)
            check_pieces(case.map.at({"r": r}), case.at(r), j)


@pytest.mark.slow
@every_case
def test_iterates_at_rational_edges_and_samples(case: Case) -> None:
    edges = parameter_cells(case.map, case.name, orders=case.orders, span=case.span).edges
    values = [fraction(edge) for edge in edges if edge.is_Rational]
    for value in [*values, *samples(case, 12)]:
        for j in case.orders:
            check_diagonal(case.map.at({case.name: value}), case.at(value), j)
            check_pieces(case.map.at({case.name: value}), case.at(value), j)


# --- Cells ----------------------------------------------------------------------------------------


@pytest.mark.slow
@every_case
def test_formulas_of_a_cell_hold_inside_it(case: Case) -> None:
    rng = random.Random(15)
    cells = parameter_cells(case.map, case.name, orders=case.orders, span=case.span)
    for cell in cells:
        lo, hi = number(cell.lower), number(cell.upper)
        values = [lo] if cell.is_edge else [between(rng, lo, hi) for _ in range(3)]
        for value in values:
            for j in case.orders:
                check_diagonal(cell.map, case.at(value), j, value)
                check_pieces(cell.map, case.at(value), j, value)


@pytest.mark.slow
@every_case
def test_a_cell_answers_for_other_orders_what_holds_throughout(case: Case) -> None:
    """Cut for one order only; of the others, what is not refused is true all over the cell."""
    rng = random.Random(16)
    cells = parameter_cells(case.map, case.name, orders=(2,), span=case.span)
    refused = set()
    for i, cell in enumerate(cells):
        lo, hi = number(cell.lower), number(cell.upper)
        values = [lo] if cell.is_edge else [between(rng, lo, hi) for _ in range(5)]
        for j in case.orders:
            try:
                _ = cell.map.iterate(j).fixed_points(), cell.map.iterate(j).jump_crossings()
            except UndecidedError:
                refused.add((i, j))
                continue
            for value in values:
                check_diagonal(cell.map, case.at(value), j, value)
                check_pieces(cell.map, case.at(value), j, value)
    assert not {(i, j) for i, j in refused if j == 2 or cells.cells[i].is_edge}
    assert len(refused) < len(cells) * len(case.orders)


def structure(f: Parts, map_: PiecewiseLinearMap, j: int) -> Record:
    """Words of one iterate's fixed points and crossings, by brute force."""
    j *= map_.order
    letters = map_.letters
    points = [(spelled(letters, p.word), p.stable, p.at_border) for p in brute.fixed_points(f, j)]
    return points, [spelled(letters, c.words) for c in brute.crossings(f, j)]


def structure_of(cell: ParameterCell, j: int) -> Record:
    iterate = cell.map.iterate(j)
    return (
        [(p.word, p.stable, p.at_border) for p in iterate.fixed_points()],
        [f"{c.left_word}|{c.right_word}" for c in iterate.jump_crossings()],
    )


@pytest.mark.slow
@every_case
def test_no_edge_is_missed(case: Case) -> None:
    cells = parameter_cells(case.map, case.name, orders=case.orders, span=case.span)
    ends = [(number(cell.lower), number(cell.upper)) for cell in cells]
    assert [ends[0][0], ends[-1][1]] == [*case.span]
    assert all(left[1] == right[0] for left, right in pairwise(ends))
    known = {(i, j): structure_of(cell, j) for i, cell in enumerate(cells) for j in case.orders}
    for value in samples(case, case.samples):
        here = [i for i, (lo, hi) in enumerate(ends) if lo < value < hi or lo == value == hi]
        assert len(here) == 1
        for j in case.orders:
            assert structure(case.at(value), case.map, j) == known[here[0], j], (value, j)


@every_case
def test_every_edge_is_needed(case: Case) -> None:
    cells = parameter_cells(case.map, case.name, orders=case.orders, span=case.span)
    shown = [
        [
            (
                [p.word for p in cell.map.iterate(j).pieces],
                structure_of(cell, j),
                cell.map.iterate(j).fixed_intervals() != (),
                [(p.lower_closed, p.upper_closed) for p in cell.map.iterate(j).pieces],
            )
            for j in case.orders
        ]
        for cell in cells
    ]
    edges = [i for i, cell in enumerate(cells) if cell.is_edge]
    assert edges == list(range(1, len(cells) - 1, 2))
    for i in edges:
        assert not shown[i - 1] == shown[i] == shown[i + 1], cells.cells[i].lower


# --- Diagrams -------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """A branch in numbers, as far as its formulas hold."""

    branch: str
    kind: BranchKind
    order: int
    word: str
    interval: Record
    x: sympy.Expr | None
    sides: tuple[sympy.Expr, ...]

    def holds(self, value: Any) -> bool:
        lo, lo_closed, hi, hi_closed = self.interval
        return (lo < value or (lo_closed and lo == value)) and (
            value < hi or (hi_closed and hi == value)
        )


def curves(diagram: Diagram) -> list[Curve]:
    """The branches of a diagram over one parameter; those along one value of it have no x."""
    return [curve_of(b, stretch) for b in diagram.branches for stretch in b.words]


def curve_of(branch: Branch, stretch: Stretch) -> Curve:
    """A branch as far as its formulas hold."""
    exact: Any = stretch.exact
    interval = exact["interval"]
    if isinstance(interval, sympy.FiniteSet):
        (only,) = interval
        ends: Record = (number(only), True, number(only), True)
    else:
        ends = (
            number(interval.start), not interval.left_open,
            number(interval.end), not interval.right_open,
        )  # fmt: skip
    sides = (exact["left"], exact["right"]) if branch.kind is BranchKind.JUMP else ()
    return Curve(branch.id, branch.kind, branch.order, stretch.word, ends, exact.get("x"), sides)


def check_diagram(branches: Sequence[Curve], case: Case, value: Any) -> None:
    """What a diagram shows at one value of the parameter."""
    f, unit = case.at(value), case.map.order
    here = [curve for curve in branches if curve.holds(value)]
    for j in case.orders:
        own = [c for c in here if c.order == j]
        fixed = [c for c in own if c.kind is BranchKind.FIXED_POINT]
        check_fixed_points(fixed, case.map, f, j * unit, value)
        jumps = {
            (*(evaluated(v, value) for v in (c.x, *c.sides)), c.word)
            for c in own
            if c.kind is BranchKind.JUMP
        }
        expected = {
            (c.x, c.left, c.right, spelled(case.map.letters, c.words))
            for c in brute.crossings(f, j * unit)
        }
        assert jumps == expected, (value, j)


@pytest.mark.slow
@every_case
def test_slices_show_what_the_formulas_hold(case: Case) -> None:
    """At every edge, algebraic ones too, and between them; sorted, with floats of exact values."""
    diagram = bifurcation_diagram(case.map, case.name, case.span, case.orders)
    drawn = curves(diagram)
    edges = {p.exact["parameter"] for p in diagram.points}
    for value in [*edges, *samples(case, 25)]:
        at = number(value) if isinstance(value, sympy.Expr) else value
        hits = [hit for hit in diagram.at(value) if "x" in hit.branch.exact]
        expected = [
            (curve.branch, evaluated(curve.x, at))
            for curve in drawn
            if curve.holds(at) and curve.x is not None
        ]
        found = [(hit.branch.id, number(hit.exact["x"])) for hit in hits]
        assert sorted(found) == sorted(expected)
        assert not any(after < before for (_, before), (_, after) in pairwise(found))
        assert [hit.x for hit in hits] == pytest.approx([float(hit.exact["x"]) for hit in hits])


def check_fixed_points(
    branches: Sequence[Curve], map_: PiecewiseLinearMap, f: Parts, n: int, value: Any
) -> None:
    """Isolated ones, each once, and bands: their closed ends, or all of one at this value only."""
    drawn = [(evaluated(c.x, value), c.word) for c in branches if c.x is not None]
    along = {c.word for c in branches if c.x is None}
    isolated = {
        (p.x, spelled(map_.letters, p.word))
        for p in brute.fixed_points(f, n)
        if is_new(p.period, map_, n)
    }
    bands = {
        spelled(map_.letters, part.word): {
            x
            for x, closed in ((part.lo, part.lo_in), (part.hi, part.hi_in))
            if x is not None and closed
        }
        for part, period in brute.bands(f, n)
        if is_new(period, map_, n)
    }
    ends = {(x, word) for word, xs in bands.items() for x in xs if word not in along}
    assert set(drawn) == isolated | ends, (value, n)
    assert along <= set(bands), (value, n)
    inner = [
        (evaluated(c.x, value), c.word)
        for c in branches
        if c.x is not None and value not in (c.interval[0], c.interval[2])
    ]
    assert len(set(inner)) == len(inner), (value, n)


def is_new(period: int, map_: PiecewiseLinearMap, n: int) -> bool:
    """Whether points of a period of the original map have the minimal period of n of its steps."""
    return period // gcd(period, map_.order) * map_.order == n


@pytest.mark.slow
@every_case
def test_diagram_shows_what_brute_force_finds(case: Case) -> None:
    diagram = bifurcation_diagram(case.map, case.name, span=case.span, orders=case.orders)
    branches = curves(diagram)
    exact: list[Any] = [p.exact["parameter"] for p in diagram.points]
    for value in [*samples(case, 60), *dict.fromkeys(number(p) for p in exact)]:
        check_diagram(branches, case, value)


@pytest.mark.slow
@pytest.mark.parametrize("a", ["6/5", "5/4", "7/4", "11/3"])
def test_diagram_of_the_paper_on_its_default_span(a: str) -> None:
    case = paper(Fraction(a))
    diagram = bifurcation_diagram(case.map, "r", orders=case.orders)
    exact: list[Any] = [p.exact["parameter"] for p in diagram.points]
    wide = replace(case, span=(fraction(min(exact)), fraction(max(exact))))
    branches = curves(diagram)
    for value in [*samples(wide, 80), *dict.fromkeys(fraction(p) for p in exact)]:
        check_diagram(branches, wide, value)


def test_branches_end_open_where_nothing_is_left_at_an_end_of_the_span() -> None:
    """r/(a + 1) is a fixed point for r > 0 only; that the span starts at 0 changes nothing."""
    for span in ((-1, 1), (0, 1)):
        diagram = bifurcation_diagram(PAPER.at({"a": 2}), "r", span, orders=(1,))
        (branch,) = [b for b in diagram.branches if b.word == "R"]
        assert branch.exact["x"] == sympy.Symbol("r") / 3
        assert branch.exact["interval"] == sympy.Interval.Lopen(0, 1)
        jumps = [b.exact["interval"] for b in diagram.branches if b.kind is BranchKind.JUMP]
        assert jumps == [sympy.Interval.Lopen(0, 1)]


def place_of(point_: SpecialPoint) -> tuple[Any, Any]:
    """Parameter and x; an infinite x as None."""
    p, x = point_.exact["parameter"], point_.exact["x"]
    return number(p), None if x in (sympy.oo, -sympy.oo) else number(x)


def value_at(x: sympy.Expr, p: Any) -> tuple[Any, Any]:
    """Parameter and x of a formula; at a pole None."""
    try:
        return p, evaluated(x, p)
    except ZeroDivisionError:
        return p, None


def is_at(one: tuple[Any, Any], other: tuple[Any, Any]) -> bool:
    """Whether two places are one; an infinite x is not compared."""
    return one[0] == other[0] and (None in (one[1], other[1]) or one[1] == other[1])


@every_case
def test_points_lie_on_the_branches_that_end_there(case: Case) -> None:
    """A branch leads from point to point; where its word changes its stretches meet."""
    diagram = bifurcation_diagram(case.map, case.name, span=case.span, orders=case.orders)
    for branch in diagram.branches:
        if "x" not in branch.exact:
            continue
        first, last = (diagram.point(end) for end in branch.ends)
        at = place_of(first)
        for stretch in branch.words:
            x, interval = stretch.exact["x"], stretch.exact["interval"]
            assert isinstance(interval, sympy.Set)
            ends = [value_at(x, number(p)) for p in (interval.inf, interval.sup)]
            (at,) = dict.fromkeys(b for a, b in (ends, ends[::-1]) if is_at(a, at))
        assert is_at(at, place_of(last))
        for point_ in (first, last):
            assert branch.id in point_.branches
            if point_.exact["x"] not in (sympy.oo, -sympy.oo):
                assert point_.x == pytest.approx(float(sympy.N(point_.exact["x"])), abs=1e-14)


def test_composition_with_a_line_is_the_map_on_other_coordinates() -> None:
    """(r - 2, r - a x) after 2 x + 1 is r - 2 up to -1/2 and r - a - 2 a x beyond."""
    line = PiecewiseLinearMap.from_sympy("Piecewise((2*x + 1, True))")
    both = PAPER.at({"a": "5/4"}) @ line
    plain = PiecewiseLinearMap([("r - 2", "x <= -1/2"), ("r - 5/4*(2*x + 1)", "x > -1/2")])
    names = ("x", "interval", "multiplier", "left", "right")
    diagrams = [bifurcation_diagram(m, "r", (-3, 8), orders=(1, 2, 3)) for m in (both, plain)]
    branches, points = (
        [
            sorted(
                (
                    str(b.kind),
                    b.order,
                    *(str(sympy.factor(b.exact[n])) for n in names if n in b.exact),
                )
                for b in diagram.branches
            )
            for diagram in diagrams
        ],
        [
            sorted((str(p.kind), p.order, *map(str, p.exact.values())) for p in diagram.points)
            for diagram in diagrams
        ],
    )
    assert branches[0] == branches[1]
    assert points[0] == points[1]


# --- Other parameters symbolic --------------------------------------------------------------------


def substituted(
    diagram: Diagram, values: dict[sympy.Symbol, sympy.Rational]
) -> tuple[Record, Record]:
    """Branches and points of a diagram with values put for its symbols, in a fixed order."""

    def shown(expr: Any) -> str:
        return str(sympy.factor(expr.subs(values)))

    kinds = {p.id: p for p in diagram.points}
    branches = []
    for branch in diagram.branches:
        exact: Any = branch.exact
        ends = [
            (str(kinds[e].kind), *(shown(v) for v in kinds[e].exact.values())) for e in branch.ends
        ]
        names = [name for name in ("x", "multiplier", "left", "right") if name in exact]
        interval = exact["interval"].subs(values)
        branches.append(
            (
                str(branch.kind),
                branch.order,
                branch.word,
                *(shown(exact[name]) for name in names),
                str(interval),
                *ends,
            )
        )
    points = [
        (str(p.kind), p.order, p.note, *(shown(v) for v in p.exact.values()), len(p.branches))
        for p in diagram.points
    ]
    return tuple(sorted(branches)), tuple(sorted(points))


def admitted(given: Sequence[str], values: dict[sympy.Symbol, sympy.Rational]) -> bool:
    return all(sympy.sympify(text).subs(values) == sympy.true for text in given)


@pytest.mark.slow
@pytest.mark.parametrize("sample", [None, "5/4", "2", "7/2", "8"])
def test_symbolic_diagram_of_the_paper(sample: str | None) -> None:
    rng = random.Random(16)
    at = None if sample is None else {"a": sample}
    span = (-1, 3)
    diagram = bifurcation_diagram(PAPER, "r", span, orders=(1, 2, 3), sample=at)
    assert diagram.given
    tested = 0
    while tested < 12:
        value = sympy.Rational(rng.randint(1001, 12000), 1000)
        if not admitted(diagram.given, {A: value}):
            continue
        tested += 1
        own = bifurcation_diagram(PAPER.at({"a": value}), "r", span, orders=(1, 2, 3))
        assert substituted(diagram, {A: value}) == substituted(own, {}), value


@pytest.mark.slow
def test_symbolic_diagram_with_two_other_parameters() -> None:
    h = sympy.Symbol("h")
    map_ = PiecewiseLinearMap([("r - h", "x <= 0"), ("r - a*x", "x > 0")], given=["a > 1", "h > 0"])
    diagram = bifurcation_diagram(map_, "r", (-1, 3), orders=(1, 2, 3))
    rng = random.Random(17)
    tested = 0
    for _ in range(2000):
        values = {
            A: sympy.Rational(rng.randint(1001, 5000), 1000),
            h: sympy.Rational(rng.randint(1, 4000), 1000),
        }
        if tested < 12 and admitted(diagram.given, values):
            tested += 1
            own = bifurcation_diagram(map_.at(values), "r", (-1, 3), orders=(1, 2, 3))
            assert substituted(diagram, values) == substituted(own, {}), values
    assert tested == 12


@pytest.mark.slow
def test_symbolic_cells_of_the_paper() -> None:
    """Formulas of each cell in a and r, at random values of both that lie in it."""
    rng = random.Random(18)
    orders = (1, 2, 3, 4)
    cells = parameter_cells(PAPER, "r", orders=orders)
    tested = 0
    while tested < 10:
        a = sympy.Rational(rng.randint(1001, 4000), 1000)
        if not all(relation.subs(A, a) == sympy.true for relation in cells.given):
            continue
        tested += 1
        own = parameter_cells(PAPER.at({"a": a}), "r", orders=orders)
        assert [sympy.nsimplify(e.subs(A, a)) for e in cells.edges] == list(own.edges)
        for cell, plain in zip(cells, own, strict=True):
            for j in orders:
                assert structure_of(cell, j) == structure_of(plain, j)
                points = [p.x.subs(A, a) for p in cell.map.iterate(j).fixed_points()]
                assert [sympy.factor(x) for x in points] == [
                    sympy.factor(p.x) for p in plain.map.iterate(j).fixed_points()
                ]


@pytest.mark.parametrize("slope", [3, 4])
def test_given_holds_where_edges_outside_the_span_meet_at_the_sample(slope: int) -> None:
    """r - 4 a right of 0 is a fixed point for r > 4 a, which may be inside the span or beyond it.

    At a = 1/2 that edge meets the other one, r = 2, and both are outside the span.
    """
    map_ = PiecewiseLinearMap(
        [("r - 2", "x <= 0"), (f"r - {slope}*a", "x > 0")], given=["a > 0", "a < 1"]
    )
    diagram = bifurcation_diagram(map_, "r", (-1, 1), orders=(1,))
    for value in (sympy.Rational(n, 16) for n in range(1, 16)):
        if admitted(diagram.given, {A: value}):
            own = bifurcation_diagram(map_.at({"a": value}), "r", (-1, 1), orders=(1,))
            assert substituted(diagram, {A: value}) == substituted(own, {}), value


# --- Points that are pieces of their own ----------------------------------------------------------


def test_the_formula_of_a_point_piece_has_no_slope() -> None:
    """At 0 only the value of r x counts: nothing happens at r = 1 or -1."""
    map_ = PiecewiseLinearMap([("3", "x < 0"), ("r*x", "Eq(x, 0)"), ("5", "x > 0")])
    diagram = bifurcation_diagram(map_, "r", (-3, 3), orders=(1, 2))
    assert [(b.word, b.exact["interval"]) for b in diagram.branches] == [
        ("M", sympy.Interval(-3, 3)),
        ("R", sympy.Interval(-3, 3)),
    ]
    assert {p.kind for p in diagram.points} == {PointKind.EP}


def test_a_point_piece_is_no_flip_whatever_the_sample_of_its_slope() -> None:
    """0 is fixed at r = 0 only; r - 2 a x has the slope -1 at a = 1/2, but no interval there."""
    map_ = PiecewiseLinearMap(
        [("3", "x < 0"), ("r - 2*a*x", "Eq(x, 0)"), ("5", "x > 0")], given=["a > 0", "a < 1"]
    )
    diagram = bifurcation_diagram(map_, "r", (-1, 1), orders=(1,))
    inner = [(p.kind, p.exact["parameter"], p.exact["x"]) for p in diagram.points if p.x == 0]
    assert inner == [(PointKind.BC, 0, 0)]


# --- Incidence ------------------------------------------------------------------------------------


def kept_on_borders(seed: int) -> Case:
    """One or two breaks, and formulas that often fix one of them, or jump there by r or 2 r."""
    rng = random.Random(seed)
    slopes = [Fraction(n, 2) for n in range(-6, 7)]
    breaks = sorted(rng.sample([Fraction(-1), Fraction(0), Fraction(1)], rng.randint(1, 2)))
    owners = [rng.choice(["left", "right"]) for _ in breaks]
    slots = [*breaks, breaks[-1]]
    rows = [
        (rng.choice(slopes), rng.choice(slots), Fraction(rng.choice([0, 0, 1, -1, 2])))
        for _ in range(len(breaks) + 1)
    ]

    def parts(r: Any) -> Parts:
        return map_of(breaks, owners, [(m, b - m * b + c * r) for m, b, c in rows])

    return Case(
        map=PiecewiseLinearMap([written(part) for part in parts(R)]),
        parts=parts,
        span=(Fraction(-31, 13), Fraction(37, 14)),
        orders=(1, 2),
    )


def has_in_closure(curve: Curve, at: Any, x: Any) -> bool:
    """Whether a point of the plane is on a branch or at its end."""
    lo, _, hi, _ = curve.interval
    if curve.x is None or not (lo < at < hi or at in (lo, hi)):
        return False
    try:
        return bool(evaluated(curve.x, at) == x)
    except ZeroDivisionError:  # the branch goes to infinity here
        return False


@pytest.mark.slow
@pytest.mark.parametrize("seed", [5, 11, 12, 16, 22, 25, 29, 43, 64, 68, 77, 81, 85, 88])
def test_points_know_all_branches_in_whose_closure_they_lie(seed: int) -> None:
    """But for jumps of other orders that go through, which do not change there.

    Where a branch stays on a border, its stability there is that of the branch, or in the note.
    """
    case = kept_on_borders(seed)
    diagram = bifurcation_diagram(case.map, case.name, case.span, case.orders)
    drawn = curves(diagram)
    for point in diagram.points:
        if point.kind == "EP" or point.exact["x"] in (sympy.oo, -sympy.oo):
            continue
        at, x = (number(point.exact[name]) for name in ("parameter", "x"))
        near = {
            curve.branch
            for curve in drawn
            if has_in_closure(curve, at, x)
            and (curve.kind is BranchKind.FIXED_POINT or curve.order == point.order)
        }
        ending = [c for c in drawn if c.branch in point.branches and c.x is not None]
        own = {curve.branch for curve in ending}
        assert near <= own, point
        assert own == {curve.branch for curve in ending if has_in_closure(curve, at, x)}, point
        if "branch on the border" in point.note or "stability changes" in point.note:
            shown = [diagram.branch(curve.branch) for curve in ending if curve.holds(at)]
            told = {b.stable.any() for b in shown if b.order == point.order and b.kind != "jump"}
            here = [p.stable for p in brute.fixed_points(case.at(at), point.order) if p.x == x]
            flip = "at this value" in point.note
            assert any(here) == (any(told) != flip), point
