"""Curves of folds and flips of smooth maps, with their points of codimension two."""

from typing import Any

import numpy as np
import pytest
import sympy
from planes import SETTINGS, SPANS, P, Q, X, along, broken, smooth, special, through

from pwmap import PointKind
from woodpecker import Settings, curve_in_two
from woodpecker.plane import PlaneKind, family_from_sympy, graph_of_curves

LP, PD, BC = PointKind.LP, PointKind.PD, PointKind.BC

CUSP = X + P + Q * X - X**3
CIRCLE = X + X**2 + P**2 + Q**2 - 1
PARABOLA = smooth(X**2 + P - Q * X)


@pytest.mark.slow
def test_cusp() -> None:
    """x + p + q x - x^3 folds where q = 3 x^2 and p = -2 x^3, so 27 p^2 = 4 q^3: a cusp at zero."""
    found = through(smooth(CUSP), 1.0, kind=LP)
    p, q = found.values.T
    x = found.x[:, 0]
    assert np.abs(q - 3.0 * x**2).max() < 1e-10  # the multiplier is 1 to some 1e-15 times 1/(6 x)
    assert np.abs(p + 2.0 * x**3).max() < 1e-10
    assert np.ptp(x) > 1.5
    (cusp,) = [point for point in found.points if point.kind is PlaneKind.CUSP]
    assert cusp.values == pytest.approx((0.0, 0.0), abs=1e-12)
    assert cusp.x[0] == pytest.approx(0.0, abs=1e-9)  # slopes are compared over 1e-5, exactly here
    assert found.point(cusp.id) is cusp
    with pytest.raises(KeyError, match=rf"no point 'A' on this curve, it has \['EP1', '{cusp.id}'"):
        found.point("A")
    assert found._repr_html_().count("<tr>") == 1 + len(found.points)
    assert found.word_at(0) == "A"
    with pytest.raises(IndexError, match=rf"sample must lie in \[0, {len(found) - 1}\], got -1"):
        found.word_at(-1)


@pytest.mark.slow
@pytest.mark.parametrize("wide", [2.0, 100.0])
def test_a_generalised_flip_is_known_as_well_as_it_says(wide: float) -> None:
    """-(1 + p) sin x + x^2 + q x^3 flips at p = 0; 2 + (1 + 6 q)/3 vanishes at q = -7/6.

    A third derivative by differences over a fixed part of the window is off by more the wider it
    is: here 1e-6 to 1e-3, which a precision of 1e-13 did not say.
    """
    family = smooth(-(1 + P) * sympy.sin(X) + X**2 + Q * X**3)
    found = through(family, 0.0, settings=Settings(window=(-wide, wide)), kind=PD)
    assert np.abs(found.values[:, 0]).max() < 1e-12
    assert np.abs(found.multipliers[:, 0] + 1.0).max() < 1e-12
    (flip,) = [each for each in found.points if each.kind is PlaneKind.GENERALISED_FLIP]
    off = abs(flip.values[1] + 7.0 / 6.0)
    assert off < flip.precision[1] < 1e-9


@pytest.mark.slow
def test_a_closed_curve_says_so() -> None:
    """x + x^2 + p^2 + q^2 - 1 folds at x = 0 on the unit circle.

    It begins at q = 1/2, where p = -sqrt(3/4) and sqrt(3/4): a beginning is one crossing.
    """
    found = through(smooth(CIRCLE), 0.5, kind=LP)
    assert found.closed
    assert found.ends[1].cause == "the curve closes"
    assert np.abs(np.hypot(*found.values.T) - 1.0).max() < 1e-12
    assert list(graph_of_curves([found]).edges) == [("EP1", "EP1", "C1.1")]
    angles = np.unwrap(np.arctan2(found.values[:, 1], found.values[:, 0]))
    assert abs(angles[-1] - angles[0]) == pytest.approx(2.0 * np.pi, abs=1e-9)
    p, q = np.array(found.crossings(1, 0.5)).T
    assert np.array_equal(q, [0.5, 0.5])
    assert sorted(p) == pytest.approx([-(0.75**0.5), 0.75**0.5], abs=1e-3)  # by straight lines
    with pytest.raises(ValueError, match="axis must be 0 or 1, got 'q'"):
        found.crossings("q", 0.5)  # type: ignore[arg-type]


@pytest.mark.slow
def test_it_ends_at_the_window() -> None:
    """x^2 + p - q x: its folds lie at x = (1 + q)/2, which leaves a window."""
    met = through(PARABOLA, 0.0, settings=Settings(window=(-0.25, 0.75)), kind=LP)
    assert sorted(float(each.x[0]) for each in met.ends) == pytest.approx([-0.25, 0.75], abs=1e-12)
    assert {each.cause for each in met.ends} == {"end of the window"}


@pytest.mark.slow
def test_a_point_outside_of_the_window_does_not_leave_it() -> None:
    """p + 2 below 0, p - 1 - (1/2 + q) x beyond: the cycle of 0 and p + 2 needs p = 4 (1+q)/(1-2q).

    P_2 has a jump at 0 in the window, while p + 2 is 6.
    """
    spans, settings = ((2.0, 5.0), (-1.0, 1.0)), Settings(window=(-3.0, 3.0))
    family = broken(P + 2, P - 1 - (sympy.Rational(1, 2) + Q) * X)
    curve = through(family, 0.0, spans, settings, (1, 2), kind=PointKind.BC)
    p, q = curve.values.T
    assert np.abs(p * (1 - 2 * q) - 4 * (1 + q)).max() < 1e-12
    assert sorted(p[[0, -1]]) == [2.0, 5.0]
    assert [end.cause for end in curve.ends] == ["end of the span of p"] * 2


@pytest.mark.parametrize(
    ("kind", "change", "sentence"),
    [
        ("EP", {}, "or at an end of the window, got EP"),
        ("LP", {"value": 1.0}, r"there is no LP near p = 0\.25, x = 0\.5 at q = 1"),
        ("LP", {"span": (SPANS[0], (1.0, 2.0))}, r"span must hold q = 0\.0, got \(1.0, 2.0\)"),
        ("LP", {"value": None}, "needs value, the one of q"),
        ("LP", {"value": "0.3"}, "value must be one real number"),
        ("LP", {"value": True}, "value must be one real number"),
        ("LP", {"value": np.nan}, "value must be finite, got nan"),
        ("LP", {"kind": "PD"}, "kind is for points of codimension two, got 'PD' at LP"),
        ("LP", {"over": None}, "expected two parameters, got"),
        ("LP", {"over": "pq"}, "expected two parameters, got"),
        ("LP", {"over": ("p", "q", "r")}, "expected two parameters, got"),
    ],
)
def test_what_has_no_curve(kind: str, change: dict[str, Any], sentence: str) -> None:
    (point, *_) = special(PARABOLA, 0.0, kind=PointKind(kind))
    usual = {"over": ("p", "q"), "span": SPANS, "value": 0.0, "settings": SETTINGS}
    over, span, *options = (usual | change).items()
    with pytest.raises(ValueError, match=sentence):
        curve_in_two(PARABOLA, point, over[1], span[1], **dict(options))


@pytest.mark.slow
def test_folds_of_a_doubled_cycle_end_at_the_generalised_flip() -> None:
    """-(1 + p) x + q x^3 + x^5: cycles x, -x obey p = q x^2 + x^4, and fold at x^2 = -q/2.

    For q -> 0 the fold comes to the flip at p = q = 0, where its equations are singular.
    """
    family = smooth(-(1 + P) * X + Q * X**3 + X**5)
    settings, spans = Settings(window=(-1.5, 1.5)), ((-0.5, 0.5), (-1.0, 1.0))
    curves = [
        through(family, -0.5, spans, settings, (1, 2), kind=kind, order=order)
        for kind, order in ((LP, 2), (PD, 1))
    ]
    p, q = curves[0].values.T
    assert np.abs(p + q * q / 4.0).max() < 1e-12
    for found in curves:
        (flip,) = [each for each in found.points if each.kind not in ("EP",)]
        assert flip.kind is PlaneKind.GENERALISED_FLIP
        assert np.all(np.abs(flip.values) < flip.precision)
        assert max(flip.precision) < 1e-9
    graph = graph_of_curves(curves)
    assert sorted(kind for _, kind in graph.nodes(data="kind")) == ["EP", "EP", "EP", "GPD"]


@pytest.mark.slow
def test_folds_of_an_unsymmetric_cycle_end_at_the_generalised_flip() -> None:
    """-(1 + p) x + x^2 + q x^3 flips at p = 0, with the cubic coefficient 2 + 2 q.

    Where its two points merge their equations are nearly singular: steps become too short.
    """
    family, spans = smooth(-(1 + P) * X + X**2 + Q * X**3), ((-0.5, 0.5), (-1.5, -0.5))
    settings = Settings(window=(-1.5, 1.5))
    folds = special(family, -0.8, spans, settings, (1, 2), kind=LP, order=2)
    assert folds
    curves = [along(family, fold, -0.8, spans, settings) for fold in folds]
    for found in curves:
        (flip,) = [each for each in found.points if each.kind is PlaneKind.GENERALISED_FLIP]
        assert flip in found.ends
        assert flip.values == pytest.approx((0.0, -1.0), abs=1e-9)
        assert np.all(np.abs(np.subtract(flip.values, (0.0, -1.0))) < flip.precision)


@pytest.mark.slow
@pytest.mark.parametrize("right", [P - 3 * X, P - X / 2 - 1], ids=["kink", "jump"])
def test_a_cycle_on_a_border_ends_where_its_period_halves(right: sympy.Expr) -> None:
    """p + q x + x^2 below 0: the cycle of 0 and p has p = -1 - q, and merges at the slope -1."""
    family = broken(P + Q * X + X**2, right)
    starts = special(family, -0.5, orders=(1, 2), kind=BC, order=2, near=-0.5)
    assert starts
    for start in starts:
        found = along(family, start, -0.5)
        assert np.abs(found.values.sum(axis=1) + 1.0).max() < 1e-12
        assert found.values[:, 0].max() < 1e-12
        (flip,) = [each for each in found.ends if each.cause[:3] != "end"]
        assert flip.kind is PlaneKind.FLIP_BORDER
        assert flip.values == pytest.approx((0.0, -1.0), abs=1e-12)
        assert max(flip.precision) < 1e-9


@pytest.mark.slow
def test_folds_of_a_cycle_that_merges_at_a_kink_end_at_the_border() -> None:
    """q x + x^2 + p below 0, p - 2 x beyond: 2 x^2 + (1 + 2 q) x + p = 0 for the cycle of order 2.

    It folds at p = (1 + 2 q)^2 / 8, up to x = 0, where the slopes q and -2 have the product 1.
    """
    formula = sympy.Piecewise((P + Q * X + X**2, X < 0), (P - 2 * X, True))
    for names, second in (((P, Q), 0.1), ((Q, P), 0.18), ((P, Q), 0.25), ((Q, P), 0.02)):
        family = family_from_sympy(formula, X, names)
        starts = special(family, second, orders=(1, 2), kind=LP, order=2)
        assert len(starts) == 2
        for start in starts:
            found = along(family, start, second)
            p, q = found.values.T if names == (P, Q) else found.values.T[::-1]
            assert np.abs(p - (1.0 + 2.0 * q) ** 2 / 8.0).max() < 1e-12
            (merged,) = [end for end in found.ends if end.kind is not PlaneKind.END]
            assert merged.kind is PlaneKind.FOLD_BORDER
            exact = (0.0, -0.5) if names == (P, Q) else (-0.5, 0.0)
            off = np.abs(np.subtract(merged.values, exact))
            assert np.all(off <= merged.precision)
            assert max(merged.precision) < 1e-9


@pytest.mark.slow
def test_a_curve_is_joined_to_the_point_that_it_starts_from() -> None:
    """p + q x + x^2 below 0, p - 3 x beyond: p = 0 is a border, where it flips at q = -1.

    Flips have 2 x = -1 - q, and begin there; the border leads on both ways.
    """
    family = broken(P + Q * X + X**2, P - 3 * X)
    flips = through(family, -0.5, kind=PD)
    (flip,) = [end for end in flips.ends if end.kind is PlaneKind.FLIP_BORDER]
    assert flip.starts == (BC,)
    border = curve_in_two(family, flip, ("p", "q"), SPANS, settings=SETTINGS)
    assert np.abs(border.values[:, 0]).max() < 1e-12
    assert [str(point.kind) for point in border.points] == ["EP", "PDB", "LPB", "EP"]
    assert [point.values[1] for point in border.points] == pytest.approx([-2, -1, 1, 2], abs=1e-12)
    folds = curve_in_two(family, border.point("LPB1"), ("p", "q"), SPANS, settings=SETTINGS)
    assert [str(end.kind) for end in folds.ends] == ["LPB", "EP"]
    assert folds.ends[0].cause == border.point("LPB1").cause
    graph = graph_of_curves([flips, border, folds])
    kinds = sorted(kind for _, kind in graph.nodes(data="kind"))
    assert kinds == ["EP", "EP", "EP", "EP", "LPB", "PDB"]
    assert (graph.degree["PDB1"], graph.degree["LPB1"]) == (3, 3)


@pytest.mark.slow
def test_where_a_function_vanishes_flatly_its_zero_is_not_well_known() -> None:
    """Limits of x/3 + p - q^3 and x/2 + p differ by q^3 at x = 0: by rounding up to q = 1e-5."""
    family = broken(X / 2 + P, X / 3 + P - Q**3)
    curves = [along(family, each, 0.3) for each in special(family, 0.3, kind=BC)]
    assert len(curves) == 2
    for met in curves:
        (closes,) = [each for each in met.points if each.kind is PlaneKind.JUMP_CLOSES]
        assert abs(closes.values[1]) < closes.precision[1]
        assert 1e-6 < closes.precision[1] < 1e-3
    kinds = [kind for _, kind in graph_of_curves(curves).nodes(data="kind")]
    assert kinds.count("JC") == 1


def test_a_jump_closes_where_the_piece_beyond_it_ends() -> None:
    """x/2 + p below 0, x/3 + p + q up to q, then -x/2 + p: at x = 0 it jumps by q, if q > 0."""
    pieces = (X / 2 + P, X < 0), (X / 3 + P + Q, X < Q), (P - X / 2, True)
    family = smooth(sympy.Piecewise(*pieces))
    found = through(family, 0.5, kind=BC, near=0.0)
    (closes,) = [each for each in found.points if each.kind is PlaneKind.JUMP_CLOSES]
    assert abs(closes.values[0]) < 1e-12
    assert abs(closes.values[1]) < closes.precision[1] < 1e-6


@pytest.mark.slow
def test_a_span_may_end_at_the_point_itself() -> None:
    """Found anew it may lie beyond by rounding."""
    family = smooth(X**3 / 5 + X**2 + P - Q * X)
    for second in (0.5, 0.6, 0.7):
        ends = [each for each in special(family, second) if each.kind in (LP, PD)]
        assert len(ends) == 2
        for point in ends:
            for first in ((point.parameter, 2.5), (-2.5, point.parameter)):
                p, q = along(family, point, second, (first, SPANS[1])).values.T
                assert first[0] <= p.min() <= p.max() <= first[1]
                assert point.parameter in p
                assert np.abs(q[p == point.parameter] - second).min() < 1e-12


def test_a_curve_that_is_one_point_has_no_special_points_between_its_ends() -> None:
    """x^2 + p - q x folds at p = (1 + q)^2/4, which only grows: it only touches a corner."""
    (point,) = special(PARABOLA, 0.0, kind=LP)
    found = along(PARABOLA, point, 0.0, ((0.25, 2.0), (-2.0, 0.0)))
    assert len(found) == len(found.points) == 1
    assert "from EP1 to EP1, 0 special points" in repr(found)


@pytest.mark.nightly
def test_the_graph_tells_points_apart_on_any_scale() -> None:
    """(1 + q) x - (1 + p) x^3 flips at q = 1 at both roots of (1 + p) x^2 = 1; x is in 1e-9."""
    tiny = sympy.Rational(1, 10**9)
    family = family_from_sympy((1 + Q) * X - (1 + P) * X**3 / tiny**2, X, (Q, P))
    spans, settings = ((0.5, 1.5), (-0.5, 2.0)), Settings(window=(-2e-9, 2e-9))
    flips = special(family, 0.0, spans, settings, kind=PD)
    assert len(flips) == 2
    curves = [along(family, each, 0.0, spans, settings) for each in flips]
    assert graph_of_curves(curves).number_of_nodes() == 4


@pytest.mark.slow
def test_where_a_root_has_hardly_any_factor_its_slope_is_not_known() -> None:
    """x/2 + p up to x = 0 and q sqrt(x) + p beyond: the slope there is infinite, but for q = 0.

    It is told from 0 from some q on only, where multipliers +1 and -1 are reported; both are at 0.
    """
    family = smooth(sympy.Piecewise((X / 2 + P, X <= 0), (Q * sympy.sqrt(X) + P, True)))
    spans = (-1.0, 1.0), (-2.0, 2.0)
    found = through(family, -0.7, spans, Settings(window=(-4.0, 4.0)), kind=BC)
    assert np.abs(found.values[:, 0]).max() < 1e-12
    for each in found.points[1:-1]:
        assert each.kind in (PlaneKind.FOLD_BORDER, PlaneKind.FLIP_BORDER)
        assert abs(each.values[1]) < each.precision[1] < 0.01


@pytest.mark.slow
def test_no_multiplier_is_told_where_a_root_begins_beyond_a_border() -> None:
    """x/2 + p below 0, p - q x^(9/10) beyond: slopes there are infinite for all q > 0."""
    family = broken(X / 2 + P, P - Q * X ** sympy.Rational(9, 10))
    found = through(family, 1.0, ((-1.0, 1.0), (0.1, 2.0)), kind=BC)
    assert [point.kind for point in found.points] == [PlaneKind.END] * 2
    assert np.isnan(found.multipliers[:, 1]).all()


@pytest.mark.slow
def test_a_flip_in_a_diagram_of_the_iterate_alone_is_one_of_the_shorter_cycle() -> None:
    """p - q x^2 flips at p = 3/(4 q), where cycles of P_2 alone have an end that is a flip, too."""
    family = smooth(P - Q * X**2)
    (start,) = special(family, 1.5, orders=(2,), near=0.5)
    assert (start.kind, start.order) == (PD, 2)
    found = along(family, start, 1.5)
    assert found.order == 1
    p, q = found.values.T
    assert np.abs(4.0 * p * q - 3.0).max() < 1e-12


@pytest.mark.nightly
def test_parameters_with_names_of_columns_keep_columns_of_their_own() -> None:
    """y + y^2 + x - gap folds at y = 0, x = gap."""
    y, x, gap = sympy.symbols("y x gap")
    family = family_from_sympy(y + y**2 + x - gap, y, (x, gap))
    found = through(family, 0.25, ((-1.0, 1.0), (0.0, 0.5)), kind=LP)
    table = found.to_dataframe()
    assert table["x"].to_numpy() == pytest.approx(table["gap_"].to_numpy(), abs=1e-12)
    assert set(table["gap"]) == {0.0}
    node = graph_of_curves([found]).nodes["EP1"]
    assert (node["x_"], node["gap"]) == found.points[0].values
    assert node["x"] == found.points[0].x[0]
