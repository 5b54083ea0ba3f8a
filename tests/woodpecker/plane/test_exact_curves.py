"""Curves over two parameters of piecewise-linear maps, whose formulas are known."""

from fractions import Fraction
from functools import partial

import numpy as np
import planes
import pytest
import sympy
from planes import P, Q, X, along, broken, special

from pwmap import PiecewiseLinearMap, PointKind
from woodpecker import Settings, curve_in_two
from woodpecker.plane import PlaneKind, family_from_pwmap, family_from_sympy, graph_of_curves
from woodpecker.slices import BorderKind

ROUNDED = 1e-12  # values are of size ten, equations are solved to some spacings of doubles
A, R = sympy.symbols("a r")
SETTINGS = Settings(window=(-20.0, 20.0))
through = partial(planes.through, settings=SETTINGS)
PAPER = sympy.Piecewise((-2 + R, X < 0), (-A * X + R, True))


class TestPaper:
    """P1^L [Leine2001, Eq. 14] over r and a."""

    family = family_from_sympy(PAPER, X, (R, A))
    span = ((-1.0, 11.0), (0.5, 3.0))

    @pytest.mark.slow
    def test_a_is_at_zero_and_a_fold_flip_where_its_slope_is_minus_one(self) -> None:
        curve = through(self.family, 1.25, self.span, near=0.0)
        assert np.abs(curve.values[:, 0]).max() == 0.0
        assert np.ptp(curve.values[:, 1]) == 2.5
        assert [point.cause for point in curve.ends] == ["end of the span of a"] * 2
        (flip,) = [point for point in curve.points if point.kind is PlaneKind.FLIP_BORDER]
        assert flip.values == pytest.approx((0.0, 1.0), abs=ROUNDED)
        assert [(code, note) for code, note, _, _ in curve.stretches()] in (
            [("BC", "fold"), ("FF", "fold")],
            [("FF", "fold"), ("BC", "fold")],
        )
        for k, code in enumerate(curve.codes):
            if abs(curve.values[k, 1] - 1.0) > ROUNDED:
                assert (code == "FF") == (curve.values[k, 1] > 1.0)
        assert np.abs(curve.multipliers[:, 0] + curve.values[:, 1]).max() < ROUNDED
        assert np.abs(curve.gaps + 2.0).max() < ROUNDED

    @pytest.mark.slow
    def test_b_is_at_two(self) -> None:
        exact = PiecewiseLinearMap.from_sympy(PAPER, X, given=[A > 1])
        same = family_from_pwmap(exact, ("r", "a")), ((-1.0, 11.0), (1.05, 3.0))
        for family, span in ((self.family, self.span), same):
            curve = through(family, 1.25, span, near=2.0)
            assert np.abs(curve.values[:, 0] - 2.0).max() < ROUNDED
            assert set(curve.codes) == {"BC"}
            assert set(curve.notes) == {"fold"}

    @pytest.mark.slow
    def test_a_cycle_that_ends_behind_a_flat_piece_folds_as_in_diagrams(self) -> None:
        """The image of L meets the border at r = 2: P_3 has no jump at 2 and -1/2.

        Both lie before L in the cycle LRR, which is flat there and exists for r > 2 alone.
        """
        points = special(self.family, 1.25, self.span, SETTINGS, (3,), order=3)
        ends = [point for point in points if point.kind is PointKind.BC]
        assert {round(point.x, 9) for point in ends if abs(point.parameter - 2) < 1e-9} >= {2, -0.5}
        for point in ends:
            curve = along(self.family, point, 1.25, self.span, SETTINGS)
            assert {*zip(curve.codes, curve.notes, strict=True)} == {(point.kind, point.note)}

    @pytest.mark.nightly
    @pytest.mark.parametrize("right", [1, 2, 3])
    def test_higher_thresholds(self, right: int) -> None:
        """The cycle A B^k meets the jump where B^k (r - 2) = 0.

        B^k y = r (1 - (-a)^k)/(1 + a) + (-a)^k y: for k = 1, 2 that is r = 2 a/(a - 1) and
        r = 2 a^2/(a^2 - a + 1).
        """

        def threshold(a: float) -> float:
            power = (-a) ** right
            return 2.0 * power / (power + (1.0 - power) / (1.0 + a))

        start, span = float(threshold(1.25)), ((-1.0, 11.0), (1.05, 3.0))
        orders = tuple(range(1, right + 2))
        curve = through(self.family, 1.25, span, orders=orders, near=start, order=right + 1)
        expected = np.array([threshold(a) for a in curve.values[:, 1]])
        assert np.abs(curve.values[:, 0] - expected).max() < ROUNDED * np.abs(expected).max()
        assert np.ptp(curve.values[:, 1]) > 1.5
        assert set(curve.codes) == {"BC"}


@pytest.mark.slow
def test_skew_tent_folds_and_flips_at_its_border() -> None:
    """Slopes 1/2 and b: a BC at p = 0 that persists for b < 1 and folds for b > 1.

    At b = -1 the fixed point beyond flips, at b = 1/2 there is no border [NusseYorke1992].
    """
    curve = through(broken(X / 2 + P, Q * X + P), -2.0, ((-1.0, 1.0), (-3.0, 3.0)), near=0.0)
    assert np.abs(curve.values[:, 0]).max() < ROUNDED
    found = {(point.kind, round(point.values[1], 9)) for point in curve.points}
    assert {(PlaneKind.FLIP_BORDER, -1.0), (PlaneKind.FOLD_BORDER, 1.0)} <= found
    for k, (_, b) in enumerate(curve.values):
        if min(abs(b - 1.0), abs(b - 0.5)) > 1e-5:  # a kink is one from 1e-6 on
            assert curve.notes[k] == ("fold" if b > 1.0 else "persistence")
            assert curve.borders[k] is BorderKind.KINK


@pytest.mark.slow
def test_a_kink_whose_limits_differ_by_rounding_only() -> None:
    """At x = q/7 both pieces are p, but for rounding; the right one has the slope -4 q/3 + q/35."""
    away = X - Q / 7
    left, right = P + Q * away / 3, P - 4 * Q * away / 3 + X * away / 5
    curve = through(broken(left, right, away), 0.9, ((-1.0, 1.0), (0.3, 2.0)), near=0.9 / 7)
    assert [point.kind for point in curve.points] == ["EP", "PDB", "EP"]
    assert curve.points[1].values == pytest.approx((15 / 137, 105 / 137), abs=ROUNDED)


@pytest.mark.slow
def test_a_slope_of_minus_one_is_passed_where_the_kink_vanishes() -> None:
    """p - x below 0, p + q x beyond: at p = 0 there is no kink where q = -1, and then one again."""
    curve = through(broken(P - X, P + Q * X), 0.5, ((-1.0, 1.0), (-2.0, 2.0)), near=0.0)
    assert [point.kind for point in curve.points] == ["EP", "PDB", "LPB", "EP"]
    assert [point.values[1] for point in curve.points] == pytest.approx([-2, -1, 1, 2], abs=1e-12)


@pytest.mark.slow
def test_a_limit_that_leaps_over_the_diagonal_ends_no_curve() -> None:
    """p + x/4 below 0, q - 2 x up to 1, x/4 + 1/2 beyond: the cycle of 0 and p needs q = 2 p.

    Beyond the border it goes to q, and then to -q for q < 1 but to q/4 + 1/2 for q > 1, where a
    jump lies: its second limit leaps over the diagonal there, and it folds from there on.
    """
    half = sympy.Rational(1, 2)
    map_ = sympy.Piecewise((P + X / 4, X < 0), (Q - 2 * X, X < 1), (X / 4 + half, True))
    span = (-1.0, 2.0), (0.5, 1.5)
    curve = through(planes.smooth(map_), 0.75, span, orders=(1, 2), near=0.375, order=2)
    assert [point.kind for point in curve.points] == ["EP", "EP"]
    p, q = curve.values.T
    assert sorted(q[[0, -1]]) == [0.5, 1.5]
    assert np.abs(q - 2.0 * p).max() < ROUNDED
    assert list(curve.notes) == ["fold" if each > 1.0 else "persistence" for each in q]


@pytest.mark.slow
def test_a_cycle_whose_points_meet_at_a_border_ends_there() -> None:
    """A cycle of -1/2 and a point beyond it, which comes to -1/2, too: there both pieces are -1/2.

    p + q/7 + 3/7 - 5/7 = -1/2 and p/2 + 9 q/7 - 1/7 - 4/7 = -1/2 at p = -30/119, q = 9/34. Beyond,
    the equations of the cycle are those of a fixed point, gone round twice.
    """
    left, right = P + (Q - 6 * X - 5) / 7, P / 2 + (9 * Q + 2 * X - 4) / 7
    away = X + sympy.Rational(1, 2)
    family, span = broken(left, right, away), ((-2.0, 2.0), (-0.5, 0.5))
    curve = through(family, 0.1, span, orders=(1, 2), kind=PointKind.BC, order=2)
    met = next(end for end in curve.ends if end.kind is PlaneKind.TWO_BORDERS)
    assert met.values == pytest.approx((-30 / 119, 9 / 34), abs=ROUNDED)
    assert met.cause == "x = -1/2: beyond, it goes round a shorter cycle"


@pytest.mark.slow
def test_of_points_that_coincide_the_same_one_is_named() -> None:
    """a x + p below 0, b x + p - c beyond: the cycle of 0 and p has p (1 + b) = c.

    For a b = 1 its multiplier is 1, and as the map is linear its limits meet there, too.
    """
    a, b, c = (157 - 84 * Q) / 100, (88 - 36 * Q) / 100, (71 + 52 * Q) / 100
    formula = sympy.Piecewise((a * X + P, X < 0), (b * X + P - c, True))
    q = next(float(each) for each in sympy.Poly(a * b - 1, Q).nroots() if each < 1)
    first, exact = ([each, float((c / (1 + b)).subs(Q, each))] for each in (0.23, q))
    family, spans = family_from_sympy(formula, X, (P, Q)), ((-1.5, 1.5), (-1.0, 1.0))
    starts = planes.special(family, first[0], spans, orders=(1, 2), near=first[1], order=2)
    assert len(starts) == 2
    for start in starts:
        curve = along(family, start, first[0], spans)
        assert [str(point.kind) for point in curve.points] == ["EP", "LPB", "EP"]
        assert curve.points[1].values == pytest.approx(exact[::-1], abs=ROUNDED)


@pytest.mark.slow
def test_big_bang() -> None:
    """x/2 + p for x < 0, q - x/2 beyond: at p = q = 0 both collisions meet, and the jump closes."""
    map_, span = sympy.Piecewise((X / 2 + P, X < 0), (Q - X / 2, True)), ((-1.0, 1.0), (-1.0, 1.0))
    left = through(planes.smooth(map_), 0.5, span, near=0.0)
    right = through(family_from_sympy(map_, X, (Q, P)), -0.5, span, near=0.0)
    for curve in (left, right):
        (met,) = [point for point in curve.points if point.kind is PlaneKind.JUMP_CLOSES]
        assert met.values == pytest.approx((0.0, 0.0), abs=ROUNDED)
    graph = graph_of_curves([left, left])
    assert sorted(kind for _, kind in graph.nodes(data="kind")) == ["EP", "EP", "JC"]
    assert graph.number_of_edges() == 4
    with pytest.raises(ValueError, match="expected curves over the same parameters"):
        graph_of_curves([left, right])


@pytest.mark.slow
def test_a_cycle_on_the_edge_of_the_window_is_followed_through_all_words() -> None:
    """x -> r - a x + c_1 (a - b_1 x)+ + .. has the fixed point 1 for r = 1 + a - c_1 (a - b_1)+ ..

    Its words change at a = b_1, .. . What holds it at 1 is an equation, so no rounding of how x
    changes along the curve ends it at the edge, where an arc begins.
    """
    kinks = [(13, 37), (17, -61), (21, 83), (26, -45), (33, 29)]  # 10 b and 100 c
    exact = [(Fraction(b, 10), Fraction(c, 100)) for b, c in kinks]
    formulas = [R - A * X]
    for b, c in exact:
        formulas.append(formulas[-1] + sympy.Rational(c) * (A - sympy.Rational(b) * X))
    sides = [sympy.Rational(b) * X > A for b, _ in exact]
    family = family_from_sympy(
        sympy.Piecewise(*zip(formulas, [*sides, True], strict=True)), X, (R, A)
    )
    settings, span, at = Settings(window=(-3.0, 1.0)), ((-10.0, 10.0), (1.0, 4.0)), 2.3
    (edge, *_) = (end for end in planes.special(family, at, span, settings) if end.x == 1.0)
    assert edge.kind is PointKind.EP
    curve = along(family, edge, at, span, settings)
    r, a = curve.values.T
    assert [end.values[1] for end in curve.ends] == [1.0, 4.0]
    assert len(curve.words) == len(formulas)
    bends = sum(float(c) * np.maximum(a - float(b), 0.0) for b, c in exact)
    assert np.abs(r - (1.0 + a - bends)).max() < ROUNDED
    assert np.abs(curve.x - 1.0).max() < ROUNDED


@pytest.mark.slow
def test_a_point_of_a_curve_is_of_its_map_and_within_the_spans() -> None:
    """P1^L flips at its border at (r, a) = (0, 1), x -> r - 2 a x does not."""
    family, spans = family_from_sympy(PAPER, X, (R, A)), ((-1.0, 11.0), (0.5, 3.0))
    curve = through(family, 1.25, spans, near=0.0)
    (flip,) = [point for point in curve.points if point.kind is PlaneKind.FLIP_BORDER]
    names, anew = family.names, family_from_sympy(PAPER, X, (R, A))
    flips = curve_in_two(anew, flip, names, spans, settings=SETTINGS)
    assert np.abs(flips.values[:, 1] - 1.0).max() < ROUNDED
    other = family_from_sympy(PAPER.subs(A, 2 * A), X, (R, A))
    with pytest.raises(ValueError, match="PDB1 is of a curve of another map"):
        curve_in_two(other, flip, names, spans, settings=SETTINGS)
    with pytest.raises(ValueError, match=r"has both parameters, got value = 1\.25"):
        curve_in_two(family, flip, names, spans, value=1.25, settings=SETTINGS)
    for span, said in (((spans[0], (1.5, 3.0)), "a = 1"), (((1.0, 11.0), spans[1]), "r = 0")):
        with pytest.raises(ValueError, match=f"span must hold {said}"):
            curve_in_two(family, flip, names, span, settings=SETTINGS)
