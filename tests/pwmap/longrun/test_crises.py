"""Attractors over a parameter, and their crises."""

import pytest
import sympy
from sympy import Rational, root, sqrt

from pwmap import PiecewiseLinearMap, PointKind, attractor_diagram, dynamics
from pwmap.longrun import meeting_curve

TENT = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
PAPER = PiecewiseLinearMap.from_sympy("Piecewise((r - 2 + b*x, x <= 0), (r - a*x, True))")
SKEW = PiecewiseLinearMap.from_sympy("Piecewise((a*x + 1, x <= 0), (b*x + 1, True))")


@pytest.mark.slow
def test_band_mergings_and_the_final_crisis_of_the_tent_map() -> None:
    """At a = 2^(1/4), 2^(1/2) an image meets the cycle between bands; it escapes at 2."""
    found = attractor_diagram(TENT, "a", ("11/10", "9/4"), 3)
    assert [(c.parameter, c.kind, c.bands) for c in found.crises] == [
        (root(2, 4), PointKind.MC, (4, 2)),
        (sqrt(2), PointKind.MC, (2, 1)),
        (2, PointKind.FC, (1, 0)),
    ]
    assert [c.cycles[0] for c in found.crises] == ["LR", "R", "L"]
    assert [[len(bands) for bands in cell.bands] for cell in found.cells] == [[4], [2], [1], []]


@pytest.mark.nightly
@pytest.mark.slow
def test_bands_that_merge_at_a_place_that_stays_open_do_not_expand() -> None:
    """Slopes 1 and -a: 2, 4, 8, 16, 32 bands merge at a^n = a + 1, n = 2, 3, 6, 11, 22."""
    boost = PiecewiseLinearMap.from_sympy("Piecewise((x + 1, x <= 0), (1 - a*x, True))")
    found = attractor_diagram(boost, "a", ("10325/10000", "10330/10000"), 1)
    (crisis,) = found.crises
    a = sympy.Symbol("a", positive=True)
    exact = float(sympy.nsolve(a**22 - a - 1, 1.033))
    assert (crisis.kind, crisis.bands) == (PointKind.MC, (32, 16))
    assert 0.0 < crisis.width < 1e-9
    assert float(crisis.parameter) == pytest.approx(exact, abs=crisis.width)


@pytest.mark.nightly
@pytest.mark.slow
@pytest.mark.parametrize("a", [Rational(3, 4), Rational(5, 4)])
def test_bands_of_the_skew_tent_map_merge_where_the_literature_says(a: Rational) -> None:
    """Two bands become one where a b^2 - a + b = 0 [MilnorThurston1988; NusseYorke1995]."""
    span = (Rational(-3), Rational(-101, 100))
    found = attractor_diagram(SKEW.at({"a": a}), "b", span, 3)
    b = sympy.Symbol("b")
    merging = [r for r in sympy.solve(a * b**2 + b - a, b) if span[0] < r < span[1]]
    crises = [c for c in found.crises if c.kind is PointKind.MC and sorted(c.bands) == [1, 2]]
    assert [c.parameter for c in crises] == merging


def test_band_merging_curves_of_the_skew_tent_map_are_polynomials_in_both_slopes() -> None:
    """2 into 1 and 4 into 2 [Maistrenko1993]; for b = -a these are a^2 = 2 and a^4 = 2."""
    a, b = SKEW.parameters
    assert meeting_curve(SKEW, "LRL", "R") == a * b**2 + b - a
    four = meeting_curve(SKEW, "LRLRR", "RL")
    assert sympy.rem(four, a**2 * b**3 + a - b, b) == 0
    assert sympy.simplify((a**2 * b**3 + a - b).subs(b, -a) + a * (a**4 - 2)) == 0


@pytest.mark.nightly
@pytest.mark.slow
def test_in_each_cell_the_same_attracts_everywhere() -> None:
    """At five rational values of each cell as many bands, and the same cycles, as at its sample."""
    map_ = PAPER.at({"a": "5/4", "b": "-9/10"})
    found = attractor_diagram(map_, "r", (1, 5), 3)
    assert [c.kind for c in found.crises] == [PointKind.BC, PointKind.MC, PointKind.MC]
    assert [c.parameter for c in found.crises] == [2, Rational(720, 281), Rational(18, 5)]
    for cell in found.cells:
        low, high = cell.lower, cell.upper
        for part in (Rational(k, 100) for k in (2, 30, 55, 71, 98)):
            seen = dynamics(map_, {"r": low + (high - low) * part}).attractors
            assert [len(each.bands) for each in seen if each.is_chaotic] == list(
                map(len, cell.bands)
            )
            assert [each.word for each in seen if not each.is_chaotic] == list(cell.cycles)


@pytest.mark.nightly
@pytest.mark.slow
def test_two_mergings_between_two_samples_are_told_apart() -> None:
    """From 26/25 on the first sample has 16 bands and the next one 4: the tent map's merge at
    2^(1/16) and 2^(1/8), and no words up to order 5 say so."""
    found = attractor_diagram(TENT, "a", ("26/25", "6/5"), 5)
    assert [(c.kind, c.bands) for c in found.crises] == [
        ("MC", (16, 8)), ("MC", (8, 4)), ("MC", (4, 2)),
    ]  # fmt: skip
    assert [c.parameter**k for c, k in zip(found.crises, (16, 8, 4), strict=True)] == [2, 2, 2]
