"""Random piecewise-linear maps of the line: what the engine finds is what `pwmap` proves."""

import random
from dataclasses import replace

import networkx as nx
import pytest
import sympy
from exact import same_graph

from pwmap import PiecewiseLinearMap, bifurcation_diagram
from pwmap.diagrams.diagram import Branch, BranchKind, Diagram, PointKind
from woodpecker.engine.curves import CurveSettings
from woodpecker.engine.formulas import ExpressionMap, expression_map
from woodpecker.search.connected import connected

x, p = sympy.symbols("x p")
ORDERS = (1, 2, 3)
SPAN = (-1, 1)


def random_map(rng: random.Random) -> tuple[list[sympy.Expr], list[sympy.Rational]]:
    """Pieces and breaks; no slope is 0, 1 or -1, so that all points are generic."""
    count = rng.choice([2, 2, 3])
    breaks = [sympy.Rational(b, 8) for b in sorted(rng.sample(range(-12, 13), count - 1))]
    pieces = []
    for _ in range(count):
        slope = sympy.Rational(rng.choice([n for n in range(-22, 23) if n not in (-11, 0, 11)]), 11)
        offset, rate = sympy.Rational(rng.randint(-26, 26), 13), rng.choice([1, 1, 1, 2, -1])
        pieces.append(slope * x + offset + rate * p)
    return pieces, breaks


def both(
    pieces: list[sympy.Expr], breaks: list[sympy.Rational]
) -> tuple[PiecewiseLinearMap, ExpressionMap]:
    """The same map for both packages."""
    conditions = [(piece, x <= b) for piece, b in zip(pieces, breaks, strict=False)]
    exact = PiecewiseLinearMap.from_sympy(str(sympy.Piecewise(*conditions, (pieces[-1], True))), x)
    margins = {}
    for i in range(len(pieces)):
        margins["ABC"[i]] = {f"x = {b}": x - b for b in breaks[:i][-1:]}
        margins["ABC"[i]] |= {f"x = {b}": b - x for b in breaks[i : i + 1]}
    named = {"ABC"[i]: (piece,) for i, piece in enumerate(pieces)}
    return exact, expression_map((x,), (p,), named, margins)


def component(diagram: Diagram, first: Branch) -> set[str]:
    """Branches and points that are connected: at special points, or as points of one cycle."""
    graph = nx.Graph()
    for branch in diagram.branches:
        graph.add_node(branch.id)
        ends = (diagram.point(end) for end in branch.ends)
        graph.add_edges_from((branch.id, q.id) for q in ends if q.kind is not PointKind.EP)
    cycles = [b for b in diagram.branches if b.kind is BranchKind.FIXED_POINT]
    for one in cycles:
        for other in cycles:
            turns = {one.word[i:] + one.word[:i] for i in range(len(one.word))}
            if other.word in turns and one.exact["interval"] == other.exact["interval"]:
                graph.add_edge(one.id, other.id)
    found: set[str] = nx.node_connected_component(graph, first.id)
    return found


@pytest.mark.parametrize("count", [6, pytest.param(150, marks=pytest.mark.nightly)])
def test_random_maps(count: int) -> None:
    rng = random.Random(11)
    assert sum(is_compared(*random_map(rng)) for _ in range(count)) > 0.7 * count


def test_limits_that_pass_the_diagonal_within_a_step_end_a_crossing_one_by_one() -> None:
    """That of A | A / B ends where one of them does; 0.0041 on, at -229/1144, the jump closes."""
    pieces = p - 6 * x / 11 + sympy.Rational(20, 13), -p - 12 * x / 11 + sympy.Rational(21, 13)
    assert is_compared(list(pieces), [sympy.Rational(7, 8)])


def is_compared(pieces: list[sympy.Expr], breaks: list[sympy.Rational]) -> bool:
    """Whether a map has a fixed point to begin with; then what is followed is what is proved."""
    exact, map_ = both(pieces, breaks)
    diagram = bifurcation_diagram(exact, "p", SPAN, orders=ORDERS)
    first = next((b for b in diagram.branches if is_start(b)), None)
    if first is None:
        return False
    at_p, at_x = (0.37 * v[0] + 0.63 * v[-1] for v in (first.parameter, first.x))
    settings = CurveSettings(spans=(SPAN,), window=((-60.0, 60.0),))
    found = connected(map_, [at_x], [at_p], settings, orders=ORDERS)
    ids = component(diagram, first)
    part = replace(diagram, branches=tuple(b for b in diagram.branches if b.id in ids))
    assert same_graph(found.diagram, part) == [], pieces
    return True


def is_start(branch: Branch) -> bool:
    return branch.kind is BranchKind.FIXED_POINT and branch.order == 1 and len(branch) > 1
