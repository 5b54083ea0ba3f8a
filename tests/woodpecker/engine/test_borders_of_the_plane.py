"""Border collisions and jump crossings of maps of the plane, against closed forms."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pytest
import sympy

from pwmap.diagrams.diagram import BranchKind, Diagram, PointKind
from woodpecker.base.arrays import Floats
from woodpecker.engine.curves import CurveSettings, Stop
from woodpecker.engine.formulas import ExpressionMap, expression_map
from woodpecker.engine.two_parameters import special_curve
from woodpecker.search.connected import connected

x, y, mu = sympy.symbols("x y mu")
SLOPES = sympy.symbols("t_l d_l t_r d_r")
SIDES = {"L": {"x = 0": -x}, "R": {"x = 0": x}}
LARGE = ((-1e3, 1e3), (-1e3, 1e3))


@pytest.fixture(scope="module")
def normal_form() -> ExpressionMap:
    """The border-collision normal form: trace and determinant on both sides."""
    t_l, d_l, t_r, d_r = SLOPES
    pieces = {"L": (t_l * x + y + mu, -d_l * x), "R": (t_r * x + y + mu, -d_r * x)}
    return expression_map((x, y), (mu, *SLOPES), pieces, SIDES)


def test_curves_of_border_collisions_are_those_of_linear_equations() -> None:
    """Of cycles, and of the ends of jumps, of a map that jumps at x = q: lines through the origin.

    There both points of a cycle of two lie on the border, so that its curves end.
    """
    p, q = sympy.symbols("p q")
    sides = {"L": ((0.4, 1.0), (-0.3, 0.0)), "R": ((-1.4, 1.0), (-0.5, 0.0))}
    pieces = {k: (a * x + b * y + p, c * x + d * y) for k, ((a, b), (c, d)) in sides.items()}
    map_ = expression_map((x, y), (p, q), pieces, {"L": {"x = q": q - x}, "R": {"x = q": x - q}})
    window = ((-50.0, 50.0), (-50.0, 50.0))
    one = CurveSettings(spans=((-2.0, 2.0),), window=window)
    found = connected(map_, [-1.0 / 0.9, 0.3 / 0.9], [-1.0, 0.2], one, orders=(1, 2))
    both = CurveSettings(spans=((-2.0, 2.0), (-1.0, 1.0)), window=window)
    # The cycle of a word is a multiple of p; its point on the border is that with x = q.
    exact = {word: 1.0 / _cycle_of([sides[each] for each in word])[0] for word in ("L", "R", "RL")}
    seen = set()
    for point in found.diagram.points:
        if point.kind is PointKind.EP:
            continue
        curve = special_curve(map_, found.orbits[point.id], point.kind, (0, 1), both)
        word = min(exact, key=lambda word: abs(0.2 * exact[word] - point.parameter))
        assert curve.p[:, 0] == pytest.approx(exact[word] * curve.p[:, 1], abs=1e-13)
        ends = {Stop.SPAN} if point.order == 1 else {Stop.SPAN, Stop.BORDER}
        assert set(curve.stops) == ends
        seen.add((point.kind, word))
    assert seen == {
        (PointKind.BC, "L"), (PointKind.BC, "R"), (PointKind.BC, "RL"), (PointKind.FF, "RL"),
    }  # fmt: skip


def _cycle_of(matrices: Sequence[npt.ArrayLike]) -> Floats:
    """The first point of a cycle of x -> A x + (1, 0), A from a list in turn."""
    product, shift = np.eye(2), np.zeros(2)
    for each in map(np.asarray, matrices):
        product, shift = each @ product, each @ shift + [1.0, 0.0]
    return np.linalg.solve(np.eye(2) - product, shift)


def test_cycles_of_every_order_start_at_a_border_that_is_passed(
    normal_form: ExpressionMap,
) -> None:
    """A stable fixed point stays one while two cycles of three points are born."""
    # By hand: with slopes (t_l, d_l, t_r, d_r) only L L R and L R R have points on their sides.
    values = (-1.76, 1.6, 0.92, 1.44)
    settings = CurveSettings(spans=((-1, 1),), window=LARGE)
    right = 1.0 / (1.0 - values[2] + values[3])
    start = [right, -values[3] * right]
    found = connected(normal_form, start, [1.0, *values], settings, orders=(1, 2, 3))
    words = sorted(branch.word for branch in found.diagram.branches)
    assert words == ["L", *3 * ["L | L | R"], *3 * ["L | R | R"], "R"]
    (met,) = [point for point in found.diagram.points if point.kind is PointKind.BC]
    assert abs(met.parameter) < 1e-15
    assert len(met.branches) == 8


def ends_of_cycles(diagram: Diagram) -> set[str]:
    return {end for b in diagram.branches if b.kind is BranchKind.FIXED_POINT for end in b.ends}


@pytest.mark.slow
def test_crossings_of_the_plane_between_two_matrices() -> None:
    """Every sample is a mixture of both limits at a point of the border; its ends are cycles."""
    left = np.array([[0.4, 0.3], [-0.2, 0.5]])
    right = np.array([[-0.6, 0.2], [0.3, -0.4]])
    shift = np.array([-1.0, 0.4])
    pieces = {
        "L": (0.4 * x + 0.3 * y + mu, -0.2 * x + 0.5 * y),
        "R": (-0.6 * x + 0.2 * y + mu - 1.0, 0.3 * x - 0.4 * y + 0.4),
    }
    map_ = expression_map((x, y), (mu,), pieces, SIDES)
    settings = CurveSettings(spans=((-2.0, 3.0),), window=LARGE)
    guess = np.linalg.solve(np.eye(2) - left, np.array([-0.5, 0.0]))
    found = connected(map_, guess, [-0.5], settings, orders=(1, 2), names=("mu", "x", "y"))
    crossings = [b for b in found.diagram.branches if b.kind is BranchKind.JUMP and b.order == 1]
    assert len(crossings) == 1
    crossing = crossings[0]
    for p, at in zip(crossing.parameter, crossing.columns["y"], strict=True):
        point = np.array([0.0, at])
        one = left @ point + np.array([p, 0.0])
        other = right @ point + np.array([p, 0.0]) + shift
        across = other - one
        share = float((point - one) @ across / (across @ across))
        assert one + share * across == pytest.approx(point, abs=1e-12)
        assert -1e-12 <= share <= 1.0 + 1e-12
    assert ends_of_cycles(found.diagram) >= set(crossing.ends)
    left_open = [q.note for q in found.diagram.points if q.status.value == "open"]
    assert set(left_open) <= {"the jump ends"}  # such a crossing of P_2 has no germ in R^2


@pytest.mark.nightly
@pytest.mark.parametrize(("root", "place"), [(2, 0.0), (3, np.sqrt(2) / 3), (5, 0.0)])
def test_a_root_of_any_power_begins_beyond_a_border(root: int, place: float) -> None:
    """X -> p + c + (X - c)/2 up to c, p + c - (X - c)^s beyond, and Y -> Y/2, in skew coordinates.

    The fixed point is followed over p through c, where p = 0, and flips where s h^(s - 1) = 1,
    p = h + h^s. The cycle that starts there meets the border at p = 1, in c and c + 1. One of c + h
    and c + p - h^s, h = p + (p - h^s)/2, comes there from p = 0, and flips where s h^(s - 1) = 2.
    """
    s, c, p = sympy.Rational(1, root), sympy.Float(place), sympy.Symbol("p")
    skew = sympy.Matrix([[1, sympy.Rational(1, 3)], [sympy.Rational(1, 7), 1]])
    first, second = skew.inv() * sympy.Matrix([x, y])
    left, right = (
        tuple(skew * sympy.Matrix([p + c + each, second / 2]))
        for each in ((first - c) / 2, -((first - c) ** s))
    )
    map_ = expression_map(
        (x, y), (p,), {"L": left, "R": right}, {"L": {"c": c - first}, "R": {"c": first - c}}
    )
    settings = CurveSettings(spans=((-0.5, 1.5),), window=((-5.0, 5.0), (-5.0, 5.0)))
    start = np.array(skew, dtype=float) @ [place - 0.4, 0.0]
    found = connected(map_, start, [-0.2], settings).diagram
    power = 1.0 / root
    flip, doubled = ((factor * power) ** (1.0 / (1.0 - power)) for factor in (1.0, 0.5))
    wanted = {
        PointKind.EP: {-0.5, 1.5},
        PointKind.BC: {0.0, 1.0},
        PointKind.PD: {flip + flip**power, (2.0 * doubled + doubled**power) / 3.0},
    }
    for kind, places in wanted.items():
        met = sorted({round(each.parameter, 5) for each in found.points if each.kind is kind})
        assert met == pytest.approx(sorted(places), abs=1e-5)
    assert all(each.note for each in found.points if each.kind is PointKind.BC)


@pytest.mark.parametrize(("start", "at"), [((-0.2, -0.8), -0.2), ((0.05, 0.2), 0.05)])
def test_a_branch_passes_two_borders_at_once_where_the_map_is_smooth(
    start: tuple[float, float], at: float
) -> None:
    """At (mu, 4 mu) up to mu = 0: across either border alone the map takes a piece of no cycle."""
    one, other = x, y - 2 * x
    pieces, margins = {}, {}
    for word in ("--", "-+", "+-", "++"):
        first, second = (int(sign == "+") for sign in word)
        pieces[word] = (x / 2 + mu / 2 + second * other**2 / 4, y / 2 + 2 * mu + first * one**2 / 4)
        signs = (2 * first - 1, 2 * second - 1)
        margins[word] = {"x = 0": signs[0] * one, "y = 2x": signs[1] * other}
    map_ = expression_map((x, y), (mu,), pieces, margins)
    settings = CurveSettings(spans=((-0.5, 0.1),), window=((-5.0, 5.0), (-5.0, 5.0)))
    (branch,) = connected(map_, start, [at], settings, orders=(1,)).diagram.branches
    assert sorted(branch.parameter[[0, -1]]) == [-0.5, 0.1]
    assert [each.word for each in branch.words] in (["--", "++"], ["++", "--"])
