"""Attractors over a parameter, and their crises."""

import pytest
import sympy
from sympy import QQ, Rational, root, sqrt

from pwmap import Budget, PiecewiseLinearMap, PointKind, attractor_diagram, dynamics
from pwmap.algebra.roots import algebraic
from pwmap.longrun import meeting_curve
from pwmap.longrun.crises.changes import kind_at
from pwmap.maps import Meter

TENT = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
PAPER = PiecewiseLinearMap.from_sympy("Piecewise((r - 2 + b*x, x <= 0), (r - a*x, True))")
SKEW = PiecewiseLinearMap.from_sympy("Piecewise((a*x + 1, x <= 0), (b*x + 1, True))")


NIGHT = (pytest.mark.nightly, pytest.mark.slow)
MC, XC, FC, BC, PD = (PointKind[name] for name in ("MC", "XC", "FC", "BC", "PD"))
B, HALF = sympy.Symbol("b"), SKEW.at({"a": "1/2"})


@pytest.mark.parametrize(
    ("map_", "name", "span", "order", "crises"),
    [
        # an image meets the cycle between two bands; orbits escape at 2
        pytest.param(TENT, "a", ("11/10", "9/4"), 3,
                     [(root(2, 4), MC, (4, 2)), (sqrt(2), MC, (2, 1)), (2, FC, (1, 0))],
                     marks=pytest.mark.slow),
        # the first sample has 16 bands and the next one 4, and no words up to order 5 say so
        pytest.param(TENT, "a", ("26/25", "6/5"), 5,
                     [(root(2, n), MC, (n, n // 2)) for n in (16, 8, 4)], marks=NIGHT),
        # before -7/204 and after 7/246 one band attracts, in between three: by words of two
        # letters, which undo each other between two places by words of one; orbits in doubles at
        # 256 values give this interval a sample
        pytest.param("Piecewise((5*x/4 + 1/4 - p, x < 0), (5*x/4 - 1/4 + p/2, True))", "p",
                     (-1, 1), 1,
                     [("-7/204", XC, (1, 3)), ("7/246", XC, (3, 1)), ("3/14", FC, (1, 0))],
                     marks=pytest.mark.slow),
        # ends are images of one break or of another in turn; where two of them pass each other
        # there is no crisis
        pytest.param("Piecewise((3*x/2 + p/2 + 1, x < -3/4), (p - x/2 - 1/4, True))", "p",
                     (-1, 1), 3,
                     [("-775/788", MC, (5, 8)), ("-203/208", MC, (8, 4)), ("-31/32", BC, (4, 0))],
                     marks=pytest.mark.slow),
        # -7, where LLLR ends, is the simplest number near
        pytest.param(HALF, "b", ("-15/2", "-13/2"), 4, [(-7, BC, None)], marks=NIGHT),
        # b^3/8 - 8 b + 4 = 0: the image LRLLLRLLR of the break meets the cycle RLLL; at -8, where
        # LLLR flips, bands end
        pytest.param(HALF, "b", ("-83/10", "-79/10"), 4,
                     [(2 * sympy.CRootOf(B**3 - 16 * B + 4, 0), MC, (4, 8)), (-8, PD, (8, 0))],
                     marks=NIGHT),
        pytest.param(PAPER.at({"a": "5/4", "b": "-9/10"}), "r", (1, 5), 3,
                     [(2, BC, (0, 2)), ("720/281", MC, (2, 1)), ("18/5", MC, (1, 2))], marks=NIGHT),
    ],
)  # fmt: skip
def test_crises_are_where_words_say(
    map_: PiecewiseLinearMap | str, name: str, span: tuple[object, object], order: int, crises: list
) -> None:
    """All of them, exactly: the place, the kind, and the numbers of bands on both sides.

    At each an image of a break is a point of a cycle that repels.
    """
    map_ = PiecewiseLinearMap.from_sympy(map_) if isinstance(map_, str) else map_
    found = attractor_diagram(map_, name, span, order)
    assert [(c.kind, c.width) for c in found.crises] == [(kind, 0.0) for _, kind, _ in crises]
    for crisis, (place, _, bands) in zip(found.crises, crises, strict=True):
        assert sympy.simplify(crisis.parameter - sympy.sympify(place, rational=True)) == 0
        assert bands in (None, crisis.bands)
        for number, image, cycle in crisis.meetings:
            curve = meeting_curve(map_, image, cycle, number)
            assert sympy.simplify(curve.subs(found.parameter, crisis.parameter)) == 0
    assert found.open == ()


@pytest.mark.parametrize(
    ("map_", "place", "kind"),
    [
        (TENT, sqrt(2), MC),
        (TENT, 2, FC),
        ("Piecewise((5*x/4 + 1/4 - p, x < 0), (5*x/4 - 1/4 + p/2, True))", Rational(7, 246), XC),
        (HALF, -8, PD),
        (PAPER.at({"a": "5/4", "b": "-9/10"}), 2, BC),
        # a cycle changes its word, without bands and beside bands that stay
        ("Piecewise((x/2 + p, x < 0), (x/4 + p, True))", 0, None),
        ("Piecewise((3*x/2, x < 1/2), (3*(1 - x)/2, x < 1), (x/2 + p, x < 4), (x/4 + 3*p/2, True))",
         2, None),
    ],
)  # fmt: skip
def test_kinds_of_crises(
    map_: PiecewiseLinearMap | str, place: sympy.Expr | int, kind: PointKind | None
) -> None:
    map_ = PiecewiseLinearMap.from_sympy(map_) if isinstance(map_, str) else map_
    assert kind_at(map_, 4, algebraic(sympy.sympify(place)), QQ(1, 1000), Meter(Budget())) is kind


@pytest.mark.slow
def test_cells_and_crises_name_their_words() -> None:
    found = attractor_diagram(TENT, "a", ("11/10", "9/4"), 3)
    assert [c.cycles[0] for c in found.crises] == ["LR", "R", "L"]
    assert [[len(bands) for bands in cell.bands] for cell in found.cells] == [[4], [2], [1], []]


@pytest.mark.nightly
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
def test_in_each_cell_the_same_attracts_everywhere() -> None:
    """At five rational values of each cell as many bands, and the same cycles, as at its sample."""
    map_ = PAPER.at({"a": "5/4", "b": "-9/10"})
    found = attractor_diagram(map_, "r", (1, 5), 3)
    for cell in found.cells:
        low, high = cell.lower, cell.upper
        for part in (Rational(k, 100) for k in (2, 30, 55, 71, 98)):
            seen = dynamics(map_, {"r": low + (high - low) * part}).attractors
            assert [len(each.bands) for each in seen if each.is_chaotic] == list(
                map(len, cell.bands)
            )
            assert [each.word for each in seen if not each.is_chaotic] == list(cell.cycles)
