"""Derivatives of chains, pieces beside a border, branch points, and crossings that pass corners."""

import math
from itertools import pairwise

import numpy as np
import pytest
import sympy

from pwmap.diagrams.diagram import BranchKind, PointStatus
from woodpecker.engine import tracing
from woodpecker.engine.curves import CurveSettings, SolutionCurve
from woodpecker.engine.formulas import expression_map
from woodpecker.engine.germs import Beginning, beginnings, rotated_to_nearest
from woodpecker.engine.maps import LIMIT_DISTANCE, Chain
from woodpecker.engine.newton import cycles, solve
from woodpecker.engine.orbits import Closed, Multiplier, OnBorder, orbit_of, with_unknowns
from woodpecker.search.connected import connected

x, y, z, p = sympy.symbols("x y z p")
LINES = expression_map(
    (x,), (p,), {"L": (x / 2 + p,), "R": (x / 3 + p - 1,)}, {"L": {"x = 0": -x}, "R": {"x = 0": x}}
)
CURVED = expression_map(
    (x, y), (p,),
    {"L": (sympy.sin(x) + y * p, x * y), "R": (x**2 - y, p + sympy.cos(y))},
    {"L": {"left": p - x * y}, "R": {"right": x * y - p}},
)  # fmt: skip


def differences(function: object, at: np.ndarray) -> np.ndarray:
    """Central differences of order four, columns (..., m): good to some 1e-11 at steps of 1e-3."""
    assert callable(function)
    h, columns = 1e-3, []
    for k in range(len(at)):
        step = h * np.eye(len(at))[k]
        near, far = (
            np.asarray(function(at + n * step)) - np.asarray(function(at - n * step))
            for n in (1, 2)
        )
        columns.append((8.0 * near - far) / (12.0 * h))
    return np.stack(columns, axis=-1)


def test_derivatives_of_chains() -> None:
    both = Chain((CURVED.pieces[0], CURVED.pieces[1], CURVED.pieces[0]))
    at = np.array([0.3, -0.4, 0.7])
    image = both.at(at[:2], at[2:])
    for name, found in (("value", image.jacobian), ("margins", image.gradients)):
        expected = differences(lambda u, n=name: getattr(both.at(u[:2], u[2:]), n), at)
        assert found == pytest.approx(expected, abs=1e-10)
    assert [both.cause(code) for code in image.codes.tolist()] == ["left", "right", "left"]


@pytest.mark.parametrize(
    "condition", [Closed(), OnBorder(2, 0), Multiplier("LP"), Multiplier("NS")]
)
def test_rows_of_conditions(condition: Closed) -> None:
    """A crossing of P_2 with tails, moved in every unknown; Multiplier takes differences itself."""
    left, right = CURVED.pieces
    points = np.array([[0.3, -0.4], [0.5, 0.2]])
    tails = Chain((left, right)), Chain((right, right))
    orbit = orbit_of([right, tails[0]], points, np.array([0.7]), 0.35, tails[1])
    at = orbit.unknowns

    def residual(u: np.ndarray) -> np.ndarray:
        return condition.residual(with_unknowns(orbit, u))

    tolerance = 1e-8 if isinstance(condition, Multiplier) else 1e-9
    assert condition.rows(orbit) == pytest.approx(differences(residual, at), abs=tolerance)


def test_a_margin_that_overflows_shows_no_way_inside() -> None:
    """Far out on a path of the toy a margin was infinite where it counts as zero: 1e215 beside."""
    orbit = orbit_of([LINES.pieces[0]], np.zeros((1, 1)), np.zeros(1))
    steep = orbit.images[0]._replace(gradients=np.array([[-np.inf, np.inf]]))
    beside = orbit.with_image(0, steep)
    found = with_unknowns(beside, orbit.unknowns, (0,), along=True)
    assert found.images[0].value.tolist() == [0.0]
    problem = cycles((0,), (1.0,), (1.0,)).with_(OnBorder(0, 0))
    assert not solve(problem, beside).converged


def test_derivatives_of_multipliers_beside_a_root() -> None:
    """(x - p^2 - q)^(4/3): its slope changes by 4/9 h^(-2/3) (1, -2 p, -1), along the border by 0.

    Rounding leaves 1e-5 of the distance h, and 1e-2 of differences over a thousandth of it; along
    the border they are taken over its root, where that is 1e-8 of the whole.
    """
    q = sympy.symbols("q")
    h = x - p**2 - q
    map_ = expression_map((x,), (p, q), {"R": (h ** sympy.Rational(4, 3),)}, {"R": {"h = 0": h}})
    place, values = 0.7**2 + 0.3 + 1e-11, np.array([0.7, 0.3])
    orbit = orbit_of(map_.pieces, np.array([[place]]), values)
    row, away = Multiplier("PD").rows(orbit)[0, :3], float(orbit.images[0].margins[0])
    exact = 4.0 / 9.0 * away ** (-2.0 / 3.0) * np.array([1.0, -1.4, -1.0])
    assert row == pytest.approx(exact, rel=0.05)
    along = np.array([[1.4, 1.0, 0.0], [1.0, 0.0, 1.0]])
    assert along @ row / exact[0] == pytest.approx(0.0, abs=1e-7)


@pytest.mark.parametrize("rounded", [-0.95, 0.0, 1e8])
def test_at_the_end_of_a_root_the_multiplier_is_that_beside_it(rounded: float) -> None:
    """x/2 + p - c sqrt(x), c = 1e-3: 1/2 - c/2 h^(-1/2) at a distance h, whatever at x = 0."""
    map_ = expression_map((x,), (p,), {"R": (x / 2 + p - sympy.sqrt(x) / 1000,)}, {"R": {"b": x}})
    piece = map_.pieces[0]
    orbit = orbit_of([piece], np.array([[1e-30]]), np.zeros(1))
    image = orbit.images[0]._replace(jacobian=np.array([[rounded, 1.0]]))
    found = tracing._largest_multiplier(
        orbit.with_image(0, image), 0, np.array([LIMIT_DISTANCE, 0.0])
    )
    assert found == pytest.approx(5e-4 / math.sqrt(LIMIT_DISTANCE) - 0.5, rel=1e-12)


def test_products_of_multipliers_in_three_dimensions() -> None:
    """det of the second compound less 1 is the product of mu_i mu_j - 1."""
    matrix = np.array([[0.4, 1.1, -0.3], [-0.7, 0.5, 0.9], [0.2, -0.6, 1.3]])
    image = [sum(matrix[i, j] * v for j, v in enumerate((x, y, z))) + p for i in range(3)]
    map_ = expression_map((x, y, z), (p,), {"A": image})
    orbit = orbit_of(map_.pieces, np.zeros((1, 3)), np.zeros(1))
    mu = np.linalg.eigvals(matrix)
    product = np.prod([mu[i] * mu[j] - 1.0 for i in range(3) for j in range(i)])
    assert Multiplier("NS").value(orbit) == pytest.approx(product.real, abs=1e-13)
    assert Multiplier("PD").value(orbit) == pytest.approx(np.prod(mu + 1.0).real, abs=1e-13)


def test_pieces_beside_a_border() -> None:
    at = np.zeros(1), np.zeros(1)
    assert LINES.beside(*at, np.array([1.0, 0.0])).piece.word == "R"
    assert LINES.beside(*at, np.array([-1.0, 5.0])).piece.word == "L"
    assert LINES.beside(np.array([-1.0]), np.zeros(1), np.array([1.0, 0.0])).piece.word == "L"
    along = LINES.beside(*at, np.array([0.0, 1.0]))  # the border itself: neither side
    assert along.reason == "no piece of the map holds this point"


def test_what_starts_at_a_collision() -> None:
    """At p = 0 the fixed point of L meets the border: it, and one crossing of each order."""
    settings = CurveSettings(spans=((-1.0, 2.0),), window=((-9.0, 9.0),))
    base = cycles((0,), (1.0,), (1.0,))
    found = list(
        beginnings(SolutionCurve(LINES, base, settings), np.zeros((1, 1)), np.zeros(1), (1, 2, 3))
    )
    assert [(each.order, each.is_crossing, each.sample.rate > 0.0) for each in found] == [
        (1, False, False), (1, True, True), (2, True, True), (3, True, True),
    ]  # fmt: skip
    words = [each.sample.orbit.word for each in found]
    assert words == ["L", "L / R", "L | L / R", "L | L | L / R"]
    slopes = [each.sample.tangent[:1] / each.sample.rate for each in found]  # of the first point
    assert np.concatenate(slopes) == pytest.approx([2.0, 0.0, -2.0, -6.0], abs=1e-13)


def test_a_crossing_goes_on_through_corners() -> None:
    """P_3's crossing from 3/10 to 7/9 changes its word where its first point meets the border.

    There it is the cycle of two points that meets it, which ends the crossing unless only other
    cycles are followed.
    """
    settings = CurveSettings(spans=((-1.0, 2.0),), window=((-3.0, 3.0),))
    found = connected(LINES, [-0.9], [-0.45], settings, orders=(1, 3))
    crossings = [
        sorted(branch.parameter[[0, -1]].tolist())
        for branch in found.diagram.branches
        if branch.kind is BranchKind.JUMP and branch.parameter.min() >= 0.3 - 1e-14
    ]
    corners = [0.3, 1 / 3, 3 / 4, 7 / 9]
    for ends in pairwise(corners):
        assert sum(each == pytest.approx(ends, abs=1e-14) for each in crossings) == 1
    base = SolutionCurve(LINES, cycles((0,), (1.0,), (1.0,)), settings)
    (met,) = (
        found.orbits[point.id] for point in found.diagram.points
        if abs(point.parameter - 0.3) < 1e-9 and point.note == "persistence"
    )  # fmt: skip
    (begin,) = (
        each for each in beginnings(base, met.x, met.p, (3,))
        if each.is_crossing and each.sample.rate > 0.0
    )  # fmt: skip
    through = tracing.trace(begin, (1, 3))
    assert through.samples[-1].orbit.p == pytest.approx(7 / 9, abs=1e-14)
    changes = [float(through.samples[change.sample].orbit.p[0]) for change in through.changes]
    assert changes == pytest.approx([1 / 3, 3 / 4], abs=1e-14)
    assert {change.cause for change in through.changes} == {"x = 0"}


def test_a_branch_of_too_many_words_is_open(monkeypatch: pytest.MonkeyPatch) -> None:
    """After as many changes of word as are allowed a branch says that it was given up."""
    monkeypatch.setattr(tracing, "MOST_ARCS", 1)
    smooth = {"L": (x / 2 + p,), "R": (x / 2 + p,)}
    named = expression_map((x,), (p,), smooth, {"L": {"x = 0": -x}, "R": {"x = 0": x}})
    settings = CurveSettings(spans=((-1.0, 1.0),), window=((-3.0, 3.0),))
    diagram = connected(named, [-1.0], [-0.5], settings, orders=(1,)).diagram
    left = [q for q in diagram.points if q.status is PointStatus.OPEN]
    assert [q.note for q in left] == ["as many samples as allowed"]
    assert left[0].parameter == pytest.approx(0.0, abs=1e-14)


@pytest.mark.parametrize("first", [0, 1, 2])
def test_cycles_are_followed_from_the_same_point(first: int) -> None:
    """The tangent of an orbit that is seen from another of its points, against one solved anew."""
    piece = CURVED.pieces[0]
    points = np.array([[0.3, -0.4], [0.5, 0.2], [-0.1, 0.6]])
    settings = CurveSettings(spans=((0.0, 1.0),), window=((-1.0, 1.0), (-1.0, 1.0)))
    curve = SolutionCurve(CURVED, cycles((0,), (1.0, 2.0), (1.0,)), settings)
    orbit = orbit_of([piece] * 3, points, np.array([0.7]))
    begin = rotated_to_nearest(Beginning(3, curve, curve.start(orbit)), points[first] + 1e-3)
    assert begin.sample.orbit.x[0] == pytest.approx(points[first], abs=0.0)
    anew = curve.start(orbit.rotated(first), begin.sample.tangent)
    assert begin.sample.tangent == pytest.approx(anew.tangent, abs=1e-14)
    assert begin.sample.bordered == pytest.approx(anew.bordered, rel=1e-13)
