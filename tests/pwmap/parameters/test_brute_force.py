"""Diagrams and cells of certain families against brute force, and with symbolic parameters."""

import random
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import pytest
import sympy
from cell_formulas import check_formulas
from compare_families import compare
from comparisons import Report
from families import Draw, Family, family
from readings import between, place

from pwmap import (
    BranchKind,
    Diagram,
    PiecewiseLinearMap,
    PointKind,
    UndecidedError,
    bifurcation_diagram,
    parameter_cells,
)

Record = tuple[Any, ...]

A = sympy.Symbol("a")
PAPER = PiecewiseLinearMap([("r - 2", "x <= 0"), ("r - a*x", "x > 0")], given=["a > 1"])
HALF = Fraction(1, 2)

# --- The families ---------------------------------------------------------------------------------


def paper(a: Fraction) -> Family:
    """P1^L of the paper: p - 2 for x <= 0, p - a x for x > 0."""
    return family(
        [()], "l", [((), (-2, 1)), ((-a,), (0, 1))], span=(-1, 4 / (a - 1) + 3), orders=range(1, 6)
    )


MIRROR = family(  # p - x up to 0, a band of period two for p < 0; x/2 - 1 beyond
    [()], "l", [((-1,), (0, 1)), ((HALF,), (-1,))], span=(-3, 5), orders=range(1, 5)
)


def kept_on_borders(seed: int) -> Family:
    """One or two breaks, and formulas that often fix one of them, or jump there by p or 2 p."""
    rng = random.Random(seed)
    slopes = [Fraction(n, 2) for n in range(-6, 7)]
    breaks = sorted(rng.sample([Fraction(-1), Fraction(0), Fraction(1)], rng.randint(1, 2)))
    owners = "".join(rng.choice("lr") for _ in breaks)
    slots = [*breaks, breaks[-1]]
    rows = [
        (rng.choice(slopes), rng.choice(slots), rng.choice([0, 0, 1, -1, 2]))
        for _ in range(len(breaks) + 1)
    ]
    return family(
        [(b,) for b in breaks], owners, [((m,), (b - m * b, c)) for m, b, c in rows],
        span=(Fraction(-31, 13), Fraction(37, 14)), orders=(1, 2),
    )  # fmt: skip


CASES = {
    **{f"paper-{a}": paper(Fraction(a)) for a in ("5/4", "7/5", "2", "19/6")},
    # x/2 + 1 left of -p, 1 - p x up to 1, p x/2 - 2 right of 1, for p > 0
    "three": family(
        [(0, -1), (1,)], "rl", [((HALF,), (1,)), ((0, -1), (1,)), ((0, HALF), (-2,))],
        span=(Fraction(1, 10), 3), orders=range(1, 5), assumes=True,
    ),
    # 1 - x left of 0, p at 0, x/2 - p right of it
    "point": family(
        [()], "p", [((-1,), (1,)), ((), (0, 1)), ((HALF,), (0, -1))],
        span=(-4, 4), orders=range(1, 6),
    ),
    # 1/2 - x left of p, 2 p - 1 at p, 2 p - 2 x right of it up to 2, 1 beyond
    "moving": family(
        [(0, 1), (2,)], "pr",
        [((-1,), (HALF,)), ((), (-1, 2)), ((-2,), (0, 2)), ((), (1,))],
        span=(-3, Fraction(19, 10)), orders=range(1, 5), assumes=True,
    ),
    # continuous, with a break that rests, and with one that moves
    "tent": family(
        [()], "r", [((HALF,), (0, 1)), ((-3,), (0, 1))], span=(-2, 2), orders=range(1, 6)
    ),
    "roof": family(
        [(0, 1)], "l", [((2,), (1,)), ((-2,), (1, 4))], span=(-3, 3), orders=range(1, 5)
    ),
    "mirror": MIRROR,
    **{f"random-{seed}": Draw(seed).family(light=True) for seed in range(8)},
    **{
        f"on-borders-{seed}": kept_on_borders(seed)
        for seed in (5, 11, 12, 16, 22, 25, 29, 43, 64, 68, 77, 81, 85, 88)
    },
}  # fmt: skip
every_case = pytest.mark.parametrize("case", CASES.values(), ids=CASES)


@pytest.mark.nightly
@every_case
def test_cells_and_diagrams_are_those_of_brute_force(case: Family) -> None:
    """On every edge, beside it and elsewhere; of all that cells, branches and points say."""
    report = Report()
    compare(case, 40, 1, report)
    assert not report.differences


@pytest.mark.nightly
@every_case
def test_a_cell_answers_for_other_orders_what_holds_throughout(case: Family) -> None:
    """Cut for one order only; of the others, what is not refused is true all over the cell."""
    report = Report()
    cells = parameter_cells(case.map(), "p", orders=(2,), span=case.span)
    refused = set()
    for i, cell in enumerate(cells):
        lo, hi = place(cell.lower), place(cell.upper)
        middle = lo if cell.is_edge else between(lo, hi)
        beside = [] if cell.is_edge else [between(lo, middle), between(middle, hi)]
        for j in case.orders:
            try:
                for p in (middle, *beside):
                    check_formulas(case, cell.map, p, (j,), report)
            except UndecidedError:
                refused.add((i, j))
    assert not report.differences
    assert not {(i, j) for i, j in refused if j == 2 or cells.cells[i].is_edge}
    assert len(refused) < len(cells) * len(case.orders)


@pytest.mark.nightly
@pytest.mark.parametrize("map_", [PAPER.at({"a": "5/4"}), MIRROR.map()], ids=["paper", "mirror"])
def test_an_iterate_has_the_cells_of_its_map(map_: PiecewiseLinearMap) -> None:
    """Order j of P_2 is order 2 j of P."""
    (name,), span, orders = map(str, map_.parameters), (-3, 19), (1, 2, 3)
    second = map_.iterate(2)
    both = [
        parameter_cells(second, name, orders, span),
        parameter_cells(map_, name, (2, 4, 6), span),
    ]
    assert both[0].edges == both[1].edges
    for one, other in zip(*both, strict=True):
        for j in orders:
            here, there = one.map.iterate(j), other.map.iterate(2 * j)
            assert str(here) == str(there)
            assert here.fixed_points() == there.fixed_points()
            assert here.jump_crossings() == there.jump_crossings()
            assert here.fixed_intervals() == there.fixed_intervals()


def test_branches_end_open_where_nothing_is_left_at_an_end_of_the_span() -> None:
    """r/(a + 1) is a fixed point for r > 0 only; that the span starts at 0 changes nothing."""
    for span in ((-1, 1), (0, 1)):
        diagram = bifurcation_diagram(PAPER.at({"a": 2}), "r", span, orders=(1,))
        (branch,) = [b for b in diagram.branches if b.word == "R"]
        assert branch.exact["x"] == sympy.Symbol("r") / 3
        assert branch.exact["interval"] == sympy.Interval.Lopen(0, 1)
        jumps = [b.exact["interval"] for b in diagram.branches if b.kind is BranchKind.JUMP]
        assert jumps == [sympy.Interval.Lopen(0, 1)]


def test_composition_with_a_line_is_the_map_on_other_coordinates() -> None:
    """(r - 2, r - a x) after 2 x + 1 is r - 2 up to -1/2 and r - a - 2 a x beyond."""
    line = PiecewiseLinearMap.from_sympy("Piecewise((2*x + 1, True))")
    both = PAPER.at({"a": "5/4"}) @ line
    plain = PiecewiseLinearMap([("r - 2", "x <= -1/2"), ("r - 5/4*(2*x + 1)", "x > -1/2")])
    names = ("x", "interval", "multiplier", "left", "right")
    diagrams = [bifurcation_diagram(m, "r", (-3, 8), orders=(1, 2, 3)) for m in (both, plain)]
    shown = []
    for diagram in diagrams:
        branches = []
        for b in diagram.branches:
            formulas = [str(sympy.factor(b.exact[n])) for n in names if n in b.exact]
            branches.append((str(b.kind), b.order, *formulas))
        points = [(str(p.kind), p.order, *map(str, p.exact.values())) for p in diagram.points]
        shown.append((sorted(branches), sorted(points)))
    assert shown[0] == shown[1]


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
        formulas = [*(shown(exact[name]) for name in names), str(exact["interval"].subs(values))]
        branches.append((str(branch.kind), branch.order, branch.word, *formulas, *ends))
    points = [
        (str(p.kind), p.order, p.note, *(shown(v) for v in p.exact.values()), len(p.branches))
        for p in diagram.points
    ]
    return tuple(sorted(branches)), tuple(sorted(points))


def admitted(given: Sequence[str], values: dict[sympy.Symbol, sympy.Rational]) -> bool:
    return all(sympy.sympify(text).subs(values) == sympy.true for text in given)


@pytest.mark.slow
@pytest.mark.parametrize("a", ["6/5", "5/4", "7/4", "11/3"])
def test_the_default_span_changes_nothing_inside(a: str) -> None:
    """It reaches beyond all special points; given as a span it shows the same."""
    orders = (1, 2, 3, 4, 5)
    own = bifurcation_diagram(PAPER.at({"a": a}), "r", orders=orders)
    ends = [p.exact["parameter"] for p in own.points]
    given = bifurcation_diagram(PAPER.at({"a": a}), "r", (min(ends), max(ends)), orders)
    assert substituted(own, {}) == substituted(given, {})


OF_A = {"a": (1001, 12000)}  # thousandths from which values are drawn
TWO = PiecewiseLinearMap([("r - h", "x <= 0"), ("r - a*x", "x > 0")], given=["a > 1", "h > 0"])


def outside(slope: int) -> PiecewiseLinearMap:
    """r - 4 a right of 0 is a fixed point for r > 4 a, inside the span or beyond it.

    At a = 1/2 that edge meets the other one, r = 2, and both are outside the span.
    """
    pieces = [("r - 2", "x <= 0"), (f"r - {slope}*a", "x > 0")]
    return PiecewiseLinearMap(pieces, given=["a > 0", "a < 1"])


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("map_", "orders", "high", "sample", "drawn"),
    [
        *((PAPER, (1, 2, 3), 3, sample, OF_A) for sample in (None, "5/4", "2", "7/2", "8")),
        (TWO, (1, 2, 3), 3, None, {"a": (1001, 5000), "h": (1, 4000)}),
        *((outside(slope), (1,), 1, None, {"a": (1, 999)}) for slope in (3, 4)),
    ],
)
def test_symbolic_diagrams_hold_where_their_conditions_do(
    map_: PiecewiseLinearMap,
    orders: tuple[int, ...],
    high: int,
    sample: str | None,
    drawn: dict[str, tuple[int, int]],
) -> None:
    rng, span = random.Random(16), (-1, high)
    diagram = bifurcation_diagram(map_, "r", span, orders, {"a": sample} if sample else None)
    assert diagram.given
    tested = 0
    while tested < 12:
        values = {sympy.Symbol(n): sympy.Rational(rng.randint(*d), 1000) for n, d in drawn.items()}
        if admitted(diagram.given, values):
            tested += 1
            own = bifurcation_diagram(map_.at(values), "r", span, orders)
            assert substituted(diagram, values) == substituted(own, {}), values


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
