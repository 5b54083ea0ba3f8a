"""Bifurcation curves of two parameters, against diagrams over one and against closed forms."""

from pathlib import Path

import pytest
import sympy
from effort import at_most
from sympy import Rational, sqrt

import pwmap
from pwmap import PiecewiseLinearMap, PointKind, bifurcation_diagram, parameter_plane
from pwmap.plane import ParameterPlane, PlaneKind, load_raster, plane_raster, with_crises

SKEW = PiecewiseLinearMap([("a*x + 1", "x <= 0"), ("b*x + 1", "x > 0")])
P1L = PiecewiseLinearMap([("r - 2", "x <= 0"), ("r - a*x", "x > 0")])
JUMP = PiecewiseLinearMap([("x/2 + r", "x < 1"), ("-x/3 + q", "x >= 1")])
A, B, R = sympy.symbols("a b r")

SCENES = {
    "skew": (SKEW, "a", "b", ("1/4", "3/2"), (-5, "-1/2"), (1, 2, 3)),
    "skew turned": (SKEW, "b", "a", (-5, "-1/2"), ("1/4", "3/2"), (1, 2, 3)),
    "P1L": (P1L, "a", "r", ("1/3", 3), (-1, 13), (1, 2, 3)),
    "P1L turned": (P1L, "r", "a", (-1, 13), ("1/3", 3), (1, 2, 3)),
    "jump": (JUMP, "r", "q", (0, 1), (1, 2), (1, 2, 3)),
}


@pytest.fixture(scope="module", params=SCENES)
def scene(request: pytest.FixtureRequest) -> tuple[ParameterPlane, tuple[object, ...]]:
    chosen = SCENES[request.param]
    return parameter_plane(*chosen), chosen


@pytest.mark.nightly
def test_curves_pass_through_the_special_points_of_diagrams(
    scene: tuple[ParameterPlane, tuple[object, ...]],
) -> None:
    """At rational values of one parameter those of the other: all of them, and no more."""
    plane, (map_, across, along, (low, high), span, orders) = scene
    for n in range(1, 16):
        value = (
            Rational(low) + (Rational(high) - Rational(low)) * Rational(n, 16) + Rational(1, 991)
        )
        diagram = bifurcation_diagram(map_.at({across: value}), along, span, orders)
        expected = {
            (point.kind, sympy.N(point.exact["parameter"], 40))
            for point in diagram.points
            if point.kind is not PointKind.EP and not _is_of_a_band(diagram, point)
        }
        found = {(curve.kind, sympy.N(x, 40)) for curve in plane.curves for x in curve.along(value)}
        # at a fold-flip or collision the points of a cycle may meet the border in several ways
        assert {p for _, p in found} == {p for _, p in expected}
        assert found <= expected


def _is_of_a_band(diagram: object, point: object) -> bool:
    """Whether only intervals of points of twice a period end there."""
    if point.kind is PointKind.PD:
        return False
    words = {w for name in point.branches if (w := diagram.branch(name).word) and name[0] == "F"}
    return any(len(w) % 2 == 0 and w[: len(w) // 2] * 2 == w for w in words)


@pytest.mark.nightly
def test_both_ways_across_give_the_same_curves_and_points() -> None:
    for name in ("skew", "P1L"):
        plane, turned = (parameter_plane(*SCENES[key]) for key in (name, f"{name} turned"))
        for one, other in ((plane, turned), (turned, plane)):
            shown = {(c.kind, c.words, c.polynomial) for c in one.curves}
            assert shown == {(c.kind, c.words, c.polynomial) for c in other.curves}
        assert {p.values for p in plane.points} == {p.values[::-1] for p in turned.points}


@pytest.mark.slow
def test_the_skew_tent_map() -> None:
    """R flips at b = -1 and L R at a b = -1; R L^2 collides at a b + a + 1 = 0 and flips at
    a^2 b = -1, which begins where both hold: a^2 + a = 1, b = -1/a^2 [NusseYorke1995]."""
    plane = parameter_plane(*SCENES["skew"][:3], ("1/4", "3/4"), *SCENES["skew"][4:])
    shown = {(c.kind, c.words): c for c in plane.curves}
    assert shown["PD", ("R",)].polynomial == B + 1
    assert shown["PD", ("LR",)].polynomial == A * B + 1
    assert shown["PD", ("LLR",)].polynomial == A**2 * B + 1
    assert shown["BC", ("LLR", "LRR")].polynomial == A * B + A + 1
    (point,) = plane.points
    golden = (sqrt(5) - 1) / 2
    assert point.kind is PlaneKind.FLIP_BORDER
    assert [sympy.simplify(x) for x in point.values] == [golden, sympy.simplify(-1 / golden**2)]
    assert point.id in shown["PD", ("LLR",)].ends
    assert set(point.curves) == {shown["PD", ("LLR",)].id, shown["BC", ("LLR", "LRR")].id}


def test_the_map_of_the_paper() -> None:
    """r = 0 is a fold-flip for a > 1 and a plain collision below: they meet where a = 1, where R
    flips all along. From (1, 2) the borders of L R^2 begin."""
    plane = parameter_plane(*SCENES["P1L"])
    (fold_flip,) = (c for c in plane.curves if c.kind == "FF")
    assert (fold_flip.polynomial, fold_flip.words) == (R, ("R",))
    assert fold_flip.along(2) == (0,)
    assert fold_flip.along(Rational(1, 2)) == ()
    values = {p.values: p for p in plane.points}
    assert set(values) == {(1, 0), (1, 2)}
    assert fold_flip.id in values[1, 0].curves
    (upright,) = (c for c in plane.curves if c.kind == "PD")
    assert upright.polynomial == A - 1
    assert upright.along(2) == ()
    assert {c.polynomial for c in plane.curves if c.words == ("LRR",)} == {
        R - 2,
        sympy.expand(R * (A**2 - A + 1) - 2 * A**2),
    }


@pytest.mark.nightly
def test_an_organising_centre_is_where_its_families_begin() -> None:
    """Both limits lie on the break at (1/2, 4/3); all borders of L^n R end there."""
    plane = parameter_plane(JUMP, "r", "q", (0, 1), (1, 2), (1, 2, 3, 4))
    (centre,) = plane.points
    assert centre.kind is PlaneKind.TWO_BORDERS
    assert centre.values == (Rational(1, 2), Rational(4, 3))
    assert {w for c in plane.curves for w in c.words} == {"L", "R", "LR", "LLR", "LLLR"}
    assert set(centre.curves) == {c.id for c in plane.curves}


def test_a_point_of_the_plane_is_answered_exactly() -> None:
    plane = parameter_plane(SKEW, "a", "b", ("1/4", "3/4"), (-5, "-1/2"))
    (attractor,) = plane.at(Rational(1, 2), Rational(-5, 4)).attractors
    assert (attractor.word, attractor.multiplier) == ("LR", Rational(-5, 8))
    with pytest.raises(KeyError, match="no curve 'PD9'"):
        plane.curve("PD9")


# --- What attracts, and crises --------------------------------------------------------------------


@pytest.mark.slow
def test_a_raster_says_what_attracts_at_each_point() -> None:
    """R attracts for b > -1, L R for a b > -1 below; beyond a b = -1 there are bands."""
    plane = parameter_plane(SKEW, "a", "b", ("1/4", "3/4"), ("-7/2", "-1/2"), (1, 2))
    done: list[int] = []
    raster = plane_raster(plane, 6, 5, progress=done.append)
    assert done == [1, 2, 3, 4, 5, 6]
    assert not raster.open.any()
    for i, p in enumerate(raster.across):
        for j, q in enumerate(raster.along):
            found = plane.at(Rational(str(p)), Rational(str(q)))
            chaotic = sum(len(each.bands) for each in found.attractors)
            assert raster.bands[j, i] == chaotic
            assert found.entropy.low - 0.02 <= raster.entropy[j, i] <= found.entropy.high
            if q > -1:
                assert raster.periods[j, i] == 1
            elif p * q > -1:
                assert raster.periods[j, i] == 2
            elif p * q + p + 1 > 0:
                assert (raster.periods[j, i], chaotic > 0) == (0, True)


@pytest.mark.slow
def test_crises_of_the_skew_tent_map_over_both_slopes() -> None:
    """Two bands merge where a b^2 + b = a, where the image L R L of the break meets R; and four
    where a^2 b^3 + a = b [Avrutin2011]."""
    plane = parameter_plane(SKEW, "a", "b", ("4/5", 1), ("-9/4", "-11/10"), (1, 2))
    both = with_crises(plane, 2, 2)
    assert both.curves[: len(plane.curves)] == plane.curves
    merging = {c.polynomial: c for c in both.curves if c.kind is PointKind.MC}
    two, four = A * B**2 - A + B, A**2 * B**3 + A - B
    assert {two, four} <= set(merging)
    assert merging[two].words == ("R",)
    assert merging[four].words == ("LR",)
    for polynomial in (two, four):
        (arc,) = merging[polynomial].arcs
        assert [node[0] for node in arc.ends] == [Rational(4, 5), 1]
        for value in (Rational(5, 6), Rational(9, 10)):
            (x,) = merging[polynomial].along(value)
            near = round(1000 * float(x))
            beside = [plane.at(value, Rational(near + side, 1000)) for side in (-2, 2)]
            counts = [len(found.attractors[0].bands) for found in beside]
            assert counts in ([1, 2], [2, 4])


def test_a_cycle_that_meets_an_interval_which_persists_has_its_curve() -> None:
    """R has slope -1 everywhere: all its points have period two. L R maps x < -1 to p + 1 - a.

    So that cycle exists where p + 1 - a < -1, and is born at a = p + 2, at the end -1 of the
    interval of R R.
    """
    p, a = sympy.symbols("p a")
    map_ = PiecewiseLinearMap([("a - 1", "x < -1"), ("p - x", "x >= -1")])
    for axes, spans in (
        ((p, a), ((-2, 2), ("1/4", "7/4"))),
        ((a, p), (("1/4", "7/4"), (-2, 2))),
    ):
        plane = parameter_plane(map_, *axes, *spans, (1, 2))
        found = {(c.kind, c.words): c.polynomial for c in plane.curves}
        birth = found[PointKind.BC, ("LR",)]
        assert sympy.expand(birth - (a - p - 2)) == 0
        (curve,) = (c for c in plane.curves if c.words == ("LR",))
        assert curve.note == "fold at a branch on the border"


def test_an_interval_at_one_place_is_told_by_the_cycle_it_doubles() -> None:
    """At b = -1 the points of period two round R are an interval, and L R is born at its end."""
    spans = ("1/4", "3/4"), (-5, "-1/2")
    plane = parameter_plane(SKEW, "a", "b", *spans, (1, 2))
    assert [(c.kind, c.words) for c in plane.curves] == [
        (PointKind.PD, ("LR",)), (PointKind.PD, ("R",)),
    ]  # fmt: skip


def test_curves_of_an_iterate_are_those_of_its_own_cycles() -> None:
    """For the second iterate R R and L R are words of fixed points, and no doubled ones."""
    spans = ("1/4", "3/4"), (-5, "-1/2")
    plane = parameter_plane(SKEW.iterate(2), "a", "b", *spans, (1,))
    flips = {c.words: c.polynomial for c in plane.curves if c.kind is PointKind.PD}
    assert flips == {("LR",): A * B + 1, ("RL",): A * B + 1}
    assert {c.words for c in plane.curves if c.kind is PointKind.LP} == {("RR",)}


def test_a_saved_raster_is_the_same(tmp_path: Path) -> None:
    raster = plane_raster(parameter_plane(SKEW, "a", "b", ("1/4", "3/4"), (-5, -1)), 3, 2)
    path = raster.save(tmp_path / "raster.json.gz")
    found = load_raster(path)
    assert (found.across, found.along, found.left_out) == (raster.across, raster.along, "")
    for name in ("periods", "bands", "entropy", "open"):
        one, other = getattr(found, name), getattr(raster, name)
        assert one.dtype == other.dtype
        assert one.tolist() == other.tolist()
    raster.save(changed := tmp_path / "changed.json")
    changed.write_text(changed.read_text("utf-8").replace("false", "0", 1), "utf-8")
    with pytest.raises(ValueError, match="its content was changed after it was saved"):
        load_raster(changed)
    with pytest.raises(ValueError, match="is no saved raster: it does not begin with the format"):
        load_raster(parameter_plane(SKEW, "a", "b", (0, 1), (-2, -1)).save(tmp_path / "plane.json"))


def test_a_raster_near_slope_one_takes_time_in_proportion_to_periods() -> None:
    """P1^L falls from r - 2 by -a x + r once round its fixed point: one superstable cycle.

    Its period is counted here from the closed form x* + (r - 2 - x*) (-a)^n; one point of period
    376 took seconds.
    """
    map_ = P1L.at({"a": Rational(241, 240)})
    for r in (Rational(106, 50), Rational(253, 50)):
        found = pwmap.dynamics(map_, {"r": r})
        (cycle,) = found.attractors
        a, fixed, n, x = Rational(241, 240), r / Rational(481, 240), 1, r - 2
        while x > 0:
            x, n = fixed + (x - fixed) * -a, n + 1
        assert (cycle.period, cycle.multiplier) == (n, 0)
    plane = parameter_plane(P1L, "a", "r", (1, "121/120"), (5, "128/25"), (1,))
    with at_most(400_000):
        raster = plane_raster(plane, 1, 1)  # in the middle, at the second of these points
    assert (raster.periods.item(), raster.open.item()) == (n, False)


def test_parameters_with_names_of_columns_keep_columns_of_their_own() -> None:
    """Slopes kind = 1 and id = -1 make the cycle of both pieces, and R, neutral."""
    map_ = PiecewiseLinearMap.from_sympy("Piecewise((kind*x + 1, x <= 0), (id*x + 1, True))")
    plane = parameter_plane(map_, "kind", "id", ("1/2", 2), (-3, "-1/2"), orders=(1, 2))
    table = plane.points_to_dataframe()
    assert table["id"].tolist() == ["PDB1"]
    assert table["kind"].tolist() == ["PDB"]
    assert (table["kind_"].tolist(), table["id_"].tolist()) == ([1.0], [-1.0])
