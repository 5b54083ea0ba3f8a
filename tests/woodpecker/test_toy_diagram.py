"""The complete diagram of the toy where the paper looks closest, about A and C.

Both laws of friction in the expansion at two contacts; the digits are those that simulating again
on both sides of jump and parameter gives (test_returns).
"""

import pytest
from needs import NEEDS_NUMBA
from toy_points import LOWER, POINTS, UPPER

from pwmap import BranchKind, PointKind
from woodpecker import ExpansionFriction, Search, Toy, bifurcation_diagram, first_return, shoot

pytestmark = [pytest.mark.slow, NEEDS_NUMBA]
SEARCH = Search(slices=16)
EXACT = 1e-8  # in eps_N1; what is located is good to 1e-10

STEEP = -1.2  # below it there are branches of slopes of thousands, with collisions of their own


@pytest.mark.parametrize("law", list(ExpansionFriction))
def test_a_and_c_and_the_branches_between_them(law: ExpansionFriction) -> None:
    """All collisions are those of the table within the span."""
    diagram = bifurcation_diagram(
        Toy(expansion_friction=law), "eps_n1", (0.03, 0.2), (1,), (STEEP, -0.45), search=SEARCH
    )
    found = sorted(
        (point.parameter, point.x, str(point.kind), point.note)
        for point in diagram.points
        if point.kind in (PointKind.BC, PointKind.FF) and point.x > STEEP
    )
    expected = sorted(
        (place.eps_n1, place.phi_s, place.code, place.note)
        for place in POINTS[law.value].values()
        if 0.03 < place.eps_n1 < 0.2
    )
    assert len(found) == (4 if law is ExpansionFriction.SUMMED else 3)
    assert [each[2:] for each in found] == [each[2:] for each in expected]
    assert [each[0] for each in found] == pytest.approx([each[0] for each in expected], abs=EXACT)
    assert [each[1] for each in found] == pytest.approx([each[1] for each in expected], abs=1e-9)


# --- P_2 between A and C --------------------------------------------------------------------------


def test_the_jump_branch_of_p2_from_a_leads_to_c() -> None:
    """A jump, a real 2-cycle between 0.17506 and 0.18346, and again a jump, which ends at C.

    Where the upper point of the cycle begins its lower one does at the jump of P_1, and with it a
    jump of P_2, one of whose limits comes from an orbit that leaves this window.
    """
    diagram = bifurcation_diagram(
        Toy(), "eps_n1", (0.105, 0.195), (1, 2), (-0.9, -0.6), search=SEARCH
    )

    def special(p: float, x: float) -> set[tuple[BranchKind, int]]:
        (point,) = (
            q for q in diagram.points if abs(q.parameter - p) < EXACT and abs(q.x - x) < 1e-7
        )
        return {(diagram.branch(b).kind, diagram.branch(b).order) for b in point.branches}

    fixed, jump = BranchKind.FIXED_POINT, BranchKind.JUMP
    assert (jump, 2) in special(POINTS["summed"]["A"].eps_n1, LOWER)  # A
    assert special(0.1750575969, -0.6679264641) == {(jump, 2), (fixed, 2)}
    assert special(0.1834584111, UPPER) == {(fixed, 2), (jump, 2)}
    assert special(POINTS["summed"]["C"].eps_n1, UPPER) == {(jump, 1), (fixed, 1), (jump, 2)}  # C
    inside = [hit for hit in diagram.at(0.179) if hit.branch.order == 2]
    low, high = sorted(hit.x for hit in inside if hit.branch.kind is fixed)
    (other,) = (hit.x for hit in inside if hit.branch.kind is jump)
    assert other == pytest.approx(LOWER, abs=1e-9)
    cycle = shoot(Toy(eps_n1=0.179), low, 2)
    assert cycle.success
    # The diagram interpolates between samples; the cycle itself is exact.
    assert sorted(cycle.points) == pytest.approx([low, high], abs=1e-4)
    jumps = [b for b in diagram.branches if (b.kind, b.order) == (jump, 2) and len(b) > 4]
    assert min(b.parameter.min() for b in jumps) < 0.113
    for branch in jumps:
        p, x = (float(values[len(branch) // 2]) for values in (branch.parameter, branch.x))
        sides = [first_return(Toy(eps_n1=p), x + side, 2).phi_s - x for side in (-1e-9, 1e-9)]
        assert sides[0] * sides[1] < 0.0
