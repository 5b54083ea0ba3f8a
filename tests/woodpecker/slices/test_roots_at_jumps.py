"""Pieces that end in a root right at a jump: the map is steep there, and jumps all the same."""

import pytest
from maps import continued
from sympy import Expr, Piecewise, Rational, cbrt, sqrt, symbols

from woodpecker import Settings, from_sympy

x, p = symbols("x p")
SETTINGS = Settings(span=(-2, 3), window=(-3, 3))
LEFT, RIGHT = p + x / 2, p - 1 + x / 3
MOVES = p / 10 + Rational(1, 7)  # a border that moves: x = MOVES where p = 10/63

CASES = [
    # pieces, border, where a branch starts, where both fixed points meet the border
    (p + sqrt(-x) / 2, RIGHT, 0, (-1.0, -1.5), (0.0, 1.0)),
    (p + sqrt(-x) / 2, RIGHT, 0, (1.5, 2.0), (0.0, 1.0)),
    (LEFT, p - 1 - sqrt(x), 0, (-1.0, -0.5), (0.0, 1.0)),
    (LEFT, p - 1 - sqrt(x), 0, (1.0, 3.0), (0.0, 1.0)),
    (LEFT, p - 1 - cbrt(x), 0, (-1.0, -0.5), (0.0, 1.0)),
    (LEFT, p - 1 - cbrt(x), 0, (1.0, 3.0), (0.0, 1.0)),
    (p + sqrt(MOVES - x) / 2, RIGHT, MOVES, (-1.0, -1.5), (10 / 63, 115 / 98)),
]


@pytest.mark.parametrize(("left", "right", "border", "start", "where"), CASES)
def test_branches_meet_the_jump_between_them(
    left: Expr, right: Expr, border: Expr, start: tuple[float, float], where: tuple[float, float]
) -> None:
    map_ = from_sympy(Piecewise((left, x < border), (right, True)), x, p)
    diagram = continued(map_, *start, SETTINGS)
    jumps = [branch for branch in diagram.branches if branch.kind.value == "jump"]
    assert len(jumps) == 1
    ends = sorted((diagram.point(end) for end in jumps[0].ends), key=lambda end: end.parameter)
    for end, exact in zip(ends, where, strict=True):
        assert (str(end.kind), end.note, str(end.status)) == ("BC", "persistence", "located")
        # as close as it says; it may lose the root of the spacing of doubles
        assert abs(end.parameter - exact) <= max(end.precision, 1e-13)
        assert end.precision < 1e-6
    cycles = [branch for branch in diagram.branches if branch.kind.value == "fixed-point"]
    for branch in cycles:  # none goes where the jump crosses, but by what the root leaves of it
        inside = (branch.parameter > where[0] + 1e-8) & (branch.parameter < where[1] - 1e-8)
        assert not inside.any()
    assert min(branch.parameter.min() for branch in cycles) < where[0]
    assert max(branch.parameter.max() for branch in cycles) == 3.0
