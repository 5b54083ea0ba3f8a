"""The complete diagram of the toy where the paper looks closest: A, B, C and the top of island I1.

Reference values are those of the stated model, located by sign changes of a one-sided limit with
the 30-digit reference where the README says so.
"""

from __future__ import annotations

import networkx as nx
import numpy as np
import pytest

from pwmap import BranchKind, Diagram, PointKind
from woodpecker import Search, Toy, bifurcation_diagram, first_return
from woodpecker.compiled import COMPILED

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not COMPILED, reason="takes minutes without numba"),
]
SEARCH = Search(slices=16)
A, B, C = 0.0421643309, 0.3210361465, 0.1851269510
UPPER, LOWER = -0.7577872573, -0.8847733440  # the jumps of P_1
EXACT = 1e-8  # in eps_N1; what is located is good to 1e-10


@pytest.fixture(scope="module")
def near_a() -> Diagram:
    return bifurcation_diagram(Toy(), "eps_n1", (0.03, 0.2), (1,), (-1.2, -0.45), search=SEARCH)


@pytest.fixture(scope="module")
def island() -> Diagram:
    return bifurcation_diagram(Toy(), "eps_n1", (0.3, 0.4), (1,), (-1.6, -0.45), search=SEARCH)


def collisions(diagram: Diagram) -> list[tuple[str, str, float, float]]:
    return sorted(
        (
            (str(p.kind), p.note, p.parameter, p.x)
            for p in diagram.points
            if p.kind in (PointKind.BC, PointKind.FF)
        ),
        key=lambda found: found[2],
    )


def test_a_and_c_and_the_branch_between_them(near_a: Diagram) -> None:
    found = collisions(near_a)
    assert [c[:2] for c in found] == [
        ("FF", "fold"),
        ("BC", "persistence"),
        ("BC", "persistence"),
    ]
    assert [c[2] for c in found] == pytest.approx([A, 0.0698178, C], abs=5e-8)
    assert [c[3] for c in found] == pytest.approx([LOWER, UPPER, UPPER], abs=1e-9)
    assert found[0][2] == pytest.approx(A, abs=EXACT)
    assert found[2][2] == pytest.approx(C, abs=EXACT)


def test_b_and_the_top_of_the_island(island: Diagram) -> None:
    found = collisions(island)
    assert [c[:2] for c in found] == [("BC", "fold"), ("BC", "persistence"), ("FF", "fold")]
    assert found[0][2] == pytest.approx(B, abs=EXACT)
    assert [c[2] for c in found[1:]] == pytest.approx([0.341923454, 0.388349589], abs=EXACT)
    assert [c[3] for c in found] == pytest.approx([LOWER] * 3, abs=1e-9)
    b, start, stop = (c[2] for c in found)
    jumps = [branch for branch in island.branches if branch.kind is BranchKind.JUMP]
    for p, crosses in ((0.5 * (b + start), False), (0.5 * (start + stop), True)):
        here = [j for j in jumps if j.parameter.min() < p < j.parameter.max()]
        assert bool(here) is crosses  # the island's top is a jump crossing of its own


def test_collisions_are_where_the_map_says(near_a: Diagram, island: Diagram) -> None:
    """Simulated again on both sides of jump and parameter: one limit passes the diagonal."""
    for diagram in (near_a, island):
        for _, _, p, x in collisions(diagram):
            signs = set()
            for side in (-1e-9, 1e-9):
                gaps = [
                    first_return(Toy(eps_n1=p + dp), x + side).phi_s - x for dp in (-1e-6, 1e-6)
                ]
                signs.add(gaps[0] * gaps[1] < 0.0)
            assert signs == {True, False}  # just one of the two limits


def test_fixed_points_are_fixed(near_a: Diagram, island: Diagram) -> None:
    for diagram in (near_a, island):
        for branch in diagram.branches:
            if branch.kind is BranchKind.FIXED_POINT and len(branch) > 2:
                for p, x in zip(branch.parameter[1:-1:7], branch.x[1:-1:7], strict=True):
                    again = first_return(Toy(eps_n1=float(p)), float(x))
                    spacing = 4.0 * np.spacing(1.0) * abs(again.slope)  # of images of doubles
                    assert abs(again.phi_s - x) <= max(1e-11, spacing)


def test_queries_of_the_diagram(near_a: Diagram) -> None:
    hits = near_a.at(0.06)
    kinds = [(hit.branch.kind, round(hit.x, 4)) for hit in hits]
    assert (BranchKind.JUMP, -0.8848) in kinds
    (a,) = (p.id for p in near_a.points if p.kind is PointKind.FF)
    whole = near_a.component_of(a)
    assert nx.is_connected(whole.graph())
    assert {p.id for p in near_a.points if p.kind is PointKind.BC} <= {p.id for p in whole.points}
