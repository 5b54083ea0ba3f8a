"""Cycles of maps of the plane: folds, flips, pairs on the unit circle, and their curves."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import sympy

from pwmap.diagrams.diagram import Diagram, PointKind
from woodpecker.base.progress import Stage
from woodpecker.engine import tracing
from woodpecker.engine.curves import CurveSettings, Stop
from woodpecker.engine.formulas import expression_map
from woodpecker.engine.orbits import orbit_of
from woodpecker.engine.two_parameters import special_curve
from woodpecker.maps.pieces import map_of_pieces
from woodpecker.search import BranchState
from woodpecker.search.connected import Connected, connected
from woodpecker.shooting import shoot

x, y, a, b = sympy.symbols("x y a b")
HENON = expression_map((x, y), (a, b), {"H": (1 - a * x**2 + y, b * x)})
DELAYED = expression_map((x, y), (a, b), {"D": (a * x * (1 - y) + b, x)})  # delayed logistic map
WINDOW = ((-4.0, 4.0), (-4.0, 4.0))
TOLERANCE = 1e-12  # Newton's method leaves some 2**-44 times the condition of the equations


def over(*spans: tuple[float, float]) -> CurveSettings:
    return CurveSettings(spans=spans, window=WINDOW)


@pytest.fixture(scope="module")
def henon() -> Connected:
    return connected(HENON, [0.6, 0.2], [0.1, 0.3], over((-1.0, 1.2)), orders=(1, 2, 4))


def places(found: Connected, kind: PointKind, order: int) -> list[float]:
    points = found.diagram.points
    return sorted(q.parameter for q in points if q.kind is kind and q.order == order)


def test_henon_fold_and_flips(henon: Connected) -> None:
    c = 1.0 - 0.3
    assert places(henon, PointKind.LP, 1) == pytest.approx([-(c**2) / 4], abs=TOLERANCE)
    assert places(henon, PointKind.PD, 1) == pytest.approx([3 * c**2 / 4], abs=TOLERANCE)
    # the trace of the two-cycle is 4 a^2 x0 x1 + 2 b and its points multiply to (c^2 - a) / a^2
    second = c**2 + (1 + 0.3**2 + 2 * 0.3) / 4
    assert places(henon, PointKind.PD, 2) == pytest.approx([second] * 2, abs=TOLERANCE)


def test_a_start_at_a_flip_finds_what_one_beside_it_does(henon: Connected) -> None:
    """The fixed point c / (2 a) flips at a = 3 c^2 / 4."""
    c, settings = 0.7, over((-1.0, 1.2))
    a0 = 3.0 * c**2 / 4.0
    at = [c / (2.0 * a0), 0.3 * c / (2.0 * a0)]
    found = connected(HENON, at, [a0, 0.3], settings, orders=(1, 2, 4))
    for kind in (PointKind.LP, PointKind.PD):
        for order in (1, 2, 4):
            expected = places(henon, kind, order)
            assert places(found, kind, order) == pytest.approx(expected, abs=TOLERANCE)
    assert len(found.diagram.branches) == len(henon.diagram.branches)


def test_nothing_is_left_where_there_are_as_many_branches_as_allowed() -> None:
    found = connected(HENON, [0.8, 0.2], [0.25, 0.3], over((0.2, 0.3)), orders=(1,), max_branches=1)
    assert (len(found.diagram.branches), found.left) == (1, "")


def test_a_branch_ends_after_as_many_evaluations_as_allowed() -> None:
    settings, few = over((0.2, 0.3)), 30
    found = connected(HENON, [0.8, 0.2], [0.25, 0.3], settings, orders=(1,), max_evaluations=few)
    assert {point.note for point in found.diagram.points} == {"as many evaluations as allowed"}


def test_flips_of_long_cycles_are_no_rounding() -> None:
    """By Newton's method in forty digits: their derivatives are small, their factors are not."""
    orders = 1, 2, 4, 8, 16, 32
    found = connected(HENON, [0.9, 0.3], [0.32, 0.3], over((0.3, 1.0578)), orders=orders)
    flips = places(found, PointKind.PD, 32)
    assert flips == pytest.approx([1.05773083959402268] * 32, abs=1e-14)


@pytest.fixture(scope="module")
def delayed() -> Connected:
    return connected(DELAYED, [0.3, 0.3], [1.5, 0.0], over((0.5, 2.3)), orders=(1,))


def test_neimark_sacker_of_the_delayed_logistic_map(delayed: Connected) -> None:
    """Its fixed point 1 - 1/a has multipliers of product a x = a - 1: on the circle at a = 2."""
    assert places(delayed, PointKind.NS, 1) == pytest.approx([2.0], abs=TOLERANCE)
    assert places(delayed, PointKind.BP, 1) == pytest.approx([1.0], abs=1e-7)  # transcritical
    at_one = next(q for q in delayed.diagram.points if q.kind is PointKind.BP)
    assert len(at_one.branches) == 4


def test_a_closed_curve_of_fixed_points_has_two_folds() -> None:
    """A circle: each half comes to the fold from which the other half has started."""
    pieces = {"C": (x + (1 - a**2 - x**2) / 4 + y, y / 2)}
    found = connected(
        expression_map((x, y), (a,), pieces), [0.8, 0.0], [0.6], over((-2.0, 2.0)), orders=(1,)
    )
    folds, branches = found.diagram.points, found.diagram.branches
    assert {point.kind for point in folds} == {PointKind.LP}
    assert [point.parameter for point in folds] == pytest.approx([-1.0, 1.0], abs=TOLERANCE)
    assert [set(branch.ends) for branch in branches] == 2 * [{"LP1", "LP2"}]
    for branch in branches:
        assert branch.parameter**2 + branch.x**2 == pytest.approx(1.0, abs=TOLERANCE)


def test_a_neutral_saddle_is_no_neimark_sacker_point() -> None:
    """At b = -1 the determinant is 1; where the trace -2 a x is large, multipliers are real."""
    settings = over((-1.5, -0.5))
    saddle = connected(HENON, [-1.25, 0.88], [2.0, -0.7], settings, orders=(1,), free=1)
    assert not [q for q in saddle.diagram.points if q.kind is PointKind.NS]
    focus = connected(HENON, [0.4, -0.28], [2.0, -0.7], settings, orders=(1,), free=1)
    assert places(focus, PointKind.NS, 1) == pytest.approx([-1.0], abs=TOLERANCE)


def test_a_map_that_preserves_areas_has_no_neimark_sacker_points() -> None:
    """Its determinant is 1 for every a: rounding alone gives it a sign."""
    bent = y - a * x**2
    pieces = {"T": (0.6 * x - 0.8 * bent + a / 10, 0.8 * x + 0.6 * bent)}
    turned = expression_map((x, y), (a,), pieces)
    found = connected(turned, [0.0, 0.0], [0.1], over((-1, 1)), orders=(1,))
    assert {point.kind for point in found.diagram.points} == {PointKind.EP}


@pytest.mark.parametrize(("kind", "factor"), [(PointKind.LP, -0.25), (PointKind.PD, 0.75)])
def test_curves_of_fold_and_flip(henon: Connected, kind: PointKind, factor: float) -> None:
    """They lie at a = -(1 - b)^2 / 4 and at a = 3 (1 - b)^2 / 4."""
    both, at = over((-1.0, 1.5), (-0.4, 0.4)), henon.orbits[f"{kind.value}1"]
    curve = special_curve(HENON, at, kind, (0, 1), both)
    assert set(curve.stops) == {Stop.SPAN}
    assert curve.p[:, 0] == pytest.approx(factor * (1 - curve.p[:, 1]) ** 2, abs=TOLERANCE)
    assert sorted(curve.p[[0, -1], 1]) == pytest.approx([-0.4, 0.4], abs=0.0)


@pytest.mark.parametrize("b0", [0.1, 0.3])
@pytest.mark.parametrize("ends", [(0.0, 1.5), (-1.5, 0.0)])
def test_a_span_may_end_at_the_special_point(b0: float, ends: tuple[float, float]) -> None:
    """Folds lie at a = -(1 - b)^2 / 4: that is -0.2025 and -0.1225, up to rounding."""
    settings, a0 = over((-1.0, 1.2)), -((1.0 - b0) ** 2) / 4.0
    fold = connected(HENON, [0.6, 0.6 * b0], [0.1, b0], settings, orders=(1,)).orbits["LP1"]
    for exact in (round(a0, 4), *np.nextafter(fold.p[0], [-1.0, 1.0])):
        spans = ((exact + ends[0], exact + ends[1]), (-0.5, 0.5))
        curve = special_curve(HENON, fold, PointKind.LP, (0, 1), over(*spans))
        a, b = curve.p.T
        assert exact in a[[0, -1]]
        assert spans[0][0] <= a.min() <= a.max() <= spans[0][1]
        assert a == pytest.approx(-((1.0 - b) ** 2) / 4.0, abs=TOLERANCE)


def test_curve_of_neimark_sacker(delayed: Connected) -> None:
    """With an offset b the fixed point satisfies x = a x (1 - x) + b, and a x = 1 on the circle."""
    both = over((1.2, 2.6), (-0.5, 0.5))
    curve = special_curve(DELAYED, delayed.orbits["NS1"], PointKind.NS, (0, 1), both)
    at = 1.0 / curve.p[:, 0]
    assert curve.p[:, 1] == pytest.approx(2.0 * at - 1.0, abs=TOLERANCE)
    assert curve.x[:, 0, 0] == pytest.approx(at, abs=TOLERANCE)


@pytest.mark.nightly
@pytest.mark.parametrize("a0", [-0.9, 0.0, 2.0, 2.9])
def test_a_curve_of_neimark_sacker_ends_at_resonances(a0: float) -> None:
    """At b = -1 the trace is t = -2 a x with a x^2 + 2 x = 1, so that a = t^2 / 4 - t.

    It is 2 at a = -1 and -2 at a = 3. Beyond, multipliers t / 2 +- sqrt(t^2 / 4 - 1) are real.
    """
    x0 = 1.0 / (1.0 + np.sqrt(1.0 + a0))
    found = connected(
        HENON, [x0, -x0], [a0, -1.0 + 1e-4], over((-1.01, -0.99)), orders=(1,), free=1
    )
    both = over((-4.0, 8.0), (-2.0, 2.0))
    curve = special_curve(HENON, found.orbits["NS1"], PointKind.NS, (0, 1), both)
    ends = dict(zip(curve.causes, curve.p[[0, -1]], strict=True))
    one, two = (ends[f"resonance 1:{k}, two multipliers are {s}1"] for k, s in ((1, ""), (2, "-")))
    assert one == pytest.approx([-1.0, -1.0], abs=TOLERANCE)
    assert two == pytest.approx([3.0, -1.0], abs=TOLERANCE)
    trace = -2.0 * curve.p[:, 0] * curve.x[:, 0, 0]
    assert np.abs(trace).max() <= 2.0 + TOLERANCE
    assert curve.p[:, 0] == pytest.approx(trace**2 / 4.0 - trace, abs=TOLERANCE)


def test_no_curve_of_neimark_sacker_begins_at_a_neutral_saddle() -> None:
    """At a = 2, b = -1 the other fixed point has the trace 2 + sqrt(12)."""
    x0 = (-1.0 - np.sqrt(3.0)) / 2.0
    piece, p = HENON.at(np.array([x0, -x0]), np.array([2.0, -1.0])).piece, [2.0, -1.0]
    saddle = orbit_of([piece], np.array([[x0, -x0]]), np.array(p))
    both = over((-4.0, 8.0), (-2.0, 2.0))
    with pytest.raises(ValueError, match=r"neutral saddle with the multipliers 5\.27451, 0\.18959"):
        special_curve(HENON, saddle, PointKind.NS, (0, 1), both)


def test_no_curve_in_two_parameters_begins_at_the_fold_of_a_jump_crossing() -> None:
    """Between its limits (1 + y, y + a - y^2) and (-1, y + a - y^2) it is where y^2 = a."""
    second = y + a + b - y**2
    pieces = {"L": (x / 2 + y + 1, second), "R": (-1, second)}
    map_ = expression_map((x, y), (a, b), pieces, {"L": {"x = 0": -x}, "R": {"x = 0": x}})
    found = connected(map_, [-0.4, -1.2], [1.44, 0.0], over((-1.0, 2.0)), orders=(1,))
    assert [branch.kind.value for branch in found.diagram.branches][-1] == "jump"
    (fold,) = places(found, PointKind.LP, 1)
    assert fold == pytest.approx(0.0, abs=TOLERANCE)
    both = over((-1.0, 2.0), (-1.0, 1.0))
    with pytest.raises(ValueError, match="a special point of cycles, got one of jumps: L / R"):
        special_curve(map_, found.orbits["LP1"], PointKind.LP, (0, 1), both)


def test_a_start_that_is_no_cycle_is_refused() -> None:
    with pytest.raises(ValueError, match=r"a guess near a cycle of the map at -0\.9, 0\.3, got"):
        connected(HENON, [0.6, 0.2], [-0.9, 0.3], over((-1.0, 1.2)))
    with pytest.raises(
        ValueError, match=r"the parameter of the cycle must lie in \[0.5, 1.0\], got \[0.1\]"
    ):
        connected(HENON, [0.6, 0.2], [0.1, 0.3], over((0.5, 1.0)))
    with pytest.raises(ValueError, match="a window of 2 intervals"):
        connected(HENON, [0.6, 0.2], [0.1, 0.3], CurveSettings(spans=((0, 1),), window=((-4, 4),)))


def test_virtual_cycles_are_refused() -> None:
    pieces = {"L": (x / 2 + a,), "R": (x / 3 + a - 1,)}
    lines = expression_map((x,), (a,), pieces, {"L": {"x = 0": -x}, "R": {"x = 0": x}})
    settings = CurveSettings(spans=((-1.0, 1.0),), window=((-9.0, 9.0),))
    with pytest.raises(ValueError, match="a virtual one is found, at "):
        connected(lines, [-1.0], [0.5], settings)


ARGUMENTS: list[tuple[dict[str, Any], str]] = [
    ({"x_scale": (1.0,)}, r"x_scale must be 2 positive numbers, got \(1.0,\)"),
    ({"x_scale": (0.0, 1.0)}, "x_scale must be positive and finite, got 0.0"),
    ({"p_scale": np.ones(3)}, "p_scale must be 2 positive numbers, got array"),
    ({"orders": (0,)}, "orders must be a whole number of at least 1, got 0"),
    ({"orders": ()}, r"orders must name at least one iterate, got \(\)"),
    ({"orders": 1}, r"orders must be whole numbers such as \(1, 2\), got 1"),
    ({"free": 0.5}, "free must be a whole number of at least 0, got 0.5"),
    ({"free": True}, "free must be a whole number of at least 0, got True"),
    ({"free": 2}, "free must name one of 2 parameters, from 0 on, got 2"),
    ({"names": ("a",)}, r"names must be 2 to 3 names, .* got \('a',\)"),
    ({"names": "ax"}, "names must be 2 to 3 names, .* got 'ax'"),
    ({"max_branches": 0}, "max_branches must be a whole number of at least 1, got 0"),
    ({"max_evaluations": 0}, "max_evaluations must be a whole number of at least 1, got 0"),
    ({"x": "here"}, "x must be real numbers, got 'here'"),
    ({"x": [[[0.6, 0.2]]]}, r"x must have shape \(n, d\) and p \(k,\), got \(1, 1, 2\) and \(2,\)"),
    ({"p": [0.1]}, "the map has 2 coordinates and 2 parameters, got points of 2 and 1 values"),
]


@pytest.mark.parametrize(("wrong", "sentence"), ARGUMENTS, ids=[each for _, each in ARGUMENTS])
def test_arguments_that_do_not_fit_a_map(wrong: dict[str, Any], sentence: str) -> None:
    good: dict[str, Any] = {"x": [0.6, 0.2], "p": [0.1, 0.3], "orders": (1,)} | wrong
    with pytest.raises(ValueError, match=f"^{sentence}"):
        connected(HENON, good.pop("x"), good.pop("p"), over((-1.0, 1.2)), **good)


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"spans": (0.1, 2.0)}, r"spans must be pairs of two ends each, got \(0.1, 2.0\)"),
        ({"spans": 2.0}, "spans must be pairs of two ends each, got 2.0"),
        ({"window": ((-1.0, 1.0), (2.0,))}, r"window must be two real numbers, got \(2.0,\)"),
        ({"window": ((1.0, -1.0),)}, r"window must ascend, got \(1.0, -1.0\)"),
    ],
)
def test_settings_have_pairs_of_ends(wrong: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ValueError, match=f"^{sentence}$"):
        CurveSettings(**{"spans": ((0.0, 1.0),), "window": WINDOW, **wrong})


def test_a_map_of_the_plane_is_told_where_it_is_followed() -> None:
    sentence = (
        "a map of the line, got ExpressionMap: woodpecker.from_sympy .* woodpecker.search.con"
    )
    with pytest.raises(TypeError, match=sentence):
        shoot(HENON, 0.6, p=0.1)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"^a map of the line is needed; woodpecker\.search"):
        map_of_pieces(HENON)  # type: ignore[arg-type]


def test_scales_may_be_arrays(henon: Connected) -> None:
    short, scales = over((0.1, 0.2)), {"x_scale": np.ones(2), "p_scale": [1, 1]}
    found = connected(HENON, [0.6, 0.2], [0.1, 0.3], short, orders=(1,), **scales)
    assert len(found.diagram.branches) == 1
    both = over((-1.0, 1.5), (-0.4, 0.4))
    at = henon.orbits["PD1"]
    curve = special_curve(HENON, at, PointKind.PD, (0, 1), both, x_scale=np.ones(2))
    assert set(curve.stops) == {Stop.SPAN}
    for free in ((0, 0), (0,), (0, 2), 1):
        with pytest.raises(ValueError, match="free must name two of 2 parameters"):
            special_curve(HENON, at, PointKind.PD, free, both)  # type: ignore[arg-type]
    for outside in (
        {"spans": ((0.5, 1.5), (-0.4, 0.4))},
        {"spans": ((-1.0, 1.5), (0.31, 0.4))},
        {"window": ((-4.0, 0.0), WINDOW[1])},
    ):
        with pytest.raises(ValueError, match=r"a (parameter|coordinate) of the cycle must lie in"):
            special_curve(HENON, at, PointKind.PD, (0, 1), replace(both, **outside))
    with pytest.raises(ValueError, match="p_scale must be 2 positive numbers, got 3"):
        special_curve(HENON, at, PointKind.PD, (0, 1), both, p_scale=3)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"kind must be pwmap.PointKind, got 'PD'"):
        special_curve(HENON, at, "PD", (0, 1), both)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("image", "start"),
    [((x, y), 0.1), ((x, y / 2 + a), 0.1), ((x, y / 2), 0.1), ((a * x, y / 2), 0.0)],
    ids=["all rests", "a line for each a", "a line", "a line across a branch"],
)
def test_no_branch_is_told_among_cycles_that_fill_a_line(
    image: tuple[sympy.Expr, ...], start: float
) -> None:
    map_ = expression_map((x, y), (a, b), {"I": image})
    with pytest.raises(ValueError, match="no single branch leads through it"):
        connected(map_, [start, 0.2], [1.0, 0.3], over((-1.0, 2.0)))


def test_all_samples_together_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    """Branches of 32, 14 and more samples, of which 40 are allowed: the next is not begun."""
    monkeypatch.setattr("woodpecker.search.connected.ALL_SAMPLES", 1)
    settings = CurveSettings(spans=((-0.5, 0.6),), window=WINDOW, max_samples=40)
    found = connected(HENON, [0.6, 0.2], [0.1, 0.3], settings).diagram
    assert len(found.branches[0]) < 40 <= sum(map(len, found.branches[:2]))
    assert len(found.branches) == 2
    sentence = "given up after 40 samples, as many as allowed (20 times max_samples): "
    assert found.about["left"].startswith(sentence)


@pytest.mark.parametrize(("u", "v"), [(1e-9, 1e-9), (1e3, 1e3), (1e9, 1e9), (1e-3, 1e6)])
def test_the_unit_of_the_coordinates_does_not_matter(u: float, v: float, henon: Connected) -> None:
    """A window says what is long; points are as exact as those of the map of size 1."""
    large = expression_map((x, y), (a, b), {"H": (u - a * x**2 / u + y * u / v, b * x * v / u)})
    window = ((-4.0 * u, 4.0 * u), (-4.0 * v, 4.0 * v))
    settings = CurveSettings(spans=((-1.0, 1.2),), window=window)
    found = connected(large, [0.6 * u, 0.2 * v], [0.1, 0.3], settings, orders=(1, 2, 4))
    own, others = (
        sorted((q.kind.value, q.order, round(q.parameter, 9), q.x / unit) for q in each.points)
        for each, unit in ((found.diagram, u), (henon.diagram, 1.0))
    )
    assert [each[:3] for each in own] == [each[:3] for each in others]
    assert [each[3] for each in own] == pytest.approx([each[3] for each in others], abs=1e-9)


@pytest.mark.parametrize(
    ("u", "v", "size"),
    [(1.0, 1.0, 1.0), (2.0**-20, 2.0**20, 1.0), (1e-9, 1e-3, 1e6), (1.0, 1.0, 1e-12)],
)
def test_a_jump_crossing_does_not_depend_on_units(u: float, v: float, size: float) -> None:
    """From the fixed point of one side, which ends at a = 0, to that of the other."""
    left = (0.4 * x + 0.3 * y * u / v + a * u, -0.2 * x * v / u + 0.5 * y)
    right = (-0.6 * x + 0.2 * y * u / v + (a - 1) * u, 0.3 * x * v / u - 0.4 * y + 0.4 * v)
    margins = {"L": {"x = 0": -size * x / u}, "R": {"x = 0": size * x / u}}
    map_ = expression_map((x, y), (a,), {"L": left, "R": right}, margins)
    window = ((-5.0 * u, 5.0 * u), (-5.0 * v, 5.0 * v))
    settings = CurveSettings(spans=((-1.0, 2.0),), window=window)
    found = connected(map_, [-0.7 * u, 0.3 * v], [-0.5], settings, orders=(1,)).diagram
    assert [set(branch.word) - set(" /") for branch in found.branches] == [{"L"}, {*"LR"}, {"R"}]
    borders = [q.parameter for q in found.points if q.kind is PointKind.BC]
    assert borders == pytest.approx([0.0, 33 / 35], abs=TOLERANCE)  # 1 - 0.2 y, y = 0.4 / 1.4


def test_a_cycle_that_ends_where_a_piece_has_no_value_has_no_multipliers() -> None:
    """A branch may have its last sample there."""
    map_ = expression_map((x, y), (a,), {"R": (sympy.sqrt(x) + a, y / 2)})
    beyond = orbit_of(map_.pieces, np.array([[-1.0, 0.0]]), np.array([0.0]))
    assert np.isnan(beyond.multipliers()).tolist() == [True, True]


# --- Progress and interrupts ----------------------------------------------------------------------

SHORT = over((0.0, 0.6))


def followed(progress: Callable[[Stage], None], *, keeps: bool = True) -> Diagram:
    kept = {"on_interrupt": lambda: None} if keeps else {}
    return connected(HENON, [0.6, 0.2], [0.1, 0.3], SHORT, progress=progress, **kept).diagram


def test_each_finished_branch_is_told() -> None:
    told = list[Stage]()
    diagram = followed(told.append)
    assert [stage.branches for stage in told] == [0, 1, 2, 4]  # both points of the two-cycle
    assert [stage.order for stage in told] == [1, 1, 1, 2]  # to the flip, beyond, the two-cycle
    assert {stage.slices for stage in told} == {0}
    assert told[0].parameter == 0.1
    assert {stage.parameter for stage in told[1:]} <= {q.parameter for q in diagram.points}
    assert "left" not in diagram.about


@pytest.mark.parametrize("after", [1, 2])
def test_an_interrupt_keeps_the_finished_branches(after: int) -> None:
    def stop(stage: Stage) -> None:
        if stage.branches == after:
            raise KeyboardInterrupt

    whole, part = followed(lambda _: None), followed(stop)
    assert len(part.branches) == after
    for one, other in zip(part.branches, whole.branches, strict=False):
        assert one.x.tolist() == other.x.tolist()
    assert part.about["left"] == "interrupted: 1 special point not followed further"
    with pytest.raises(KeyboardInterrupt):
        followed(stop, keeps=False)


def test_a_branch_that_is_interrupted_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is one of those that begin; before the first one is finished nothing is kept."""
    traced = tracing.trace
    for allowed in (3, 1):
        calls = iter(range(allowed))

        def trace(*arguments: Any, calls: Iterator[int] = calls) -> Any:
            if next(calls, None) is None:
                raise KeyboardInterrupt
            return traced(*arguments)

        monkeypatch.setattr("woodpecker.search.tasks.trace", trace)
        if allowed == 1:  # it leads to where the first branch begins
            with pytest.raises(KeyboardInterrupt):
                followed(lambda _: None)
        else:
            left = followed(lambda _: None).about["left"]
            assert left == (
                "interrupted: 1 special point not followed further, "
                "1 branch not followed to the end"
            )


def test_a_rule_ends_branches_where_it_becomes_true() -> None:
    """Fixed points have y = 0.3 x and 1 - a x^2 + 0.3 x = x; x falls as a grows."""

    def small(state: BranchState) -> bool:
        assert state.points.shape == (state.order, 2)
        return state.x < 0.9

    found = connected(HENON, [0.95, 0.28], [0.35, 0.3], SHORT, orders=(1,), stop=small).diagram
    (end,) = [point for point in found.points if point.note == "stopped as asked"]
    assert end.x == pytest.approx(0.9, abs=1e-9)
    assert 1.0 - end.parameter * 0.81 + 0.27 == pytest.approx(0.9, abs=1e-9)
    with pytest.raises(TypeError, match="stop must be a function of a state on a branch, got 3"):
        connected(HENON, [0.6, 0.2], [0.1, 0.3], SHORT, stop=3)  # type: ignore[arg-type]


def test_who_is_told_can_be_called() -> None:
    with pytest.raises(TypeError, match="progress must be a function, got 3"):
        followed(3)  # type: ignore[arg-type]


# --- Formulas -------------------------------------------------------------------------------------


def test_formulas_that_are_no_map() -> None:
    with pytest.raises(ValueError, match="x is used twice among variables and parameters"):
        expression_map((x, x), (a,), {"H": (x, x)})
    with pytest.raises(TypeError, match="variables and parameters must be symbols, got 'x'"):
        expression_map(("x",), (a,), {"H": (1,)})  # type: ignore[arg-type]
    with pytest.raises(
        ValueError, match=r"smooth, sympy has no formula for a slope of a\*Abs\(x\)"
    ):
        expression_map((x,), (a,), {"H": (a * sympy.Abs(x),)})
