"""Border collisions and jump crossings of maps of the plane, against closed forms."""

from collections.abc import Sequence
from itertools import product

import numpy as np
import numpy.typing as npt
import pytest
import sympy

from pwmap.diagrams.diagram import BranchKind, Diagram, PointKind
from woodpecker.base.arrays import Floats
from woodpecker.engine import germs
from woodpecker.engine.curves import CurveSettings, SolutionCurve, Stop
from woodpecker.engine.formulas import ExpressionMap, expression_map
from woodpecker.engine.germs import beginnings, cycle_at_limit
from woodpecker.engine.maps import SpaceImage, SpaceMap
from woodpecker.engine.newton import cycles
from woodpecker.engine.orbits import Multiplier, orbit_of
from woodpecker.engine.two_parameters import special_curve
from woodpecker.search.connected import connected

x, y, mu, p = sympy.symbols("x y mu p")
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
def test_cycles_on_both_sides_of_a_border_in_space_are_not_taken_for_one_branch() -> None:
    """L L R exists for mu < 0 alone and L R R for mu > 0, by linear equations for their points."""
    xs = sympy.symbols("x y z")
    slopes = {"L": (-1.424, 0.697, 1.525), "R": (2.318, -1.747, -0.089)}
    pieces = {k: (a * xs[0] + xs[1] + mu, b * xs[0] + xs[2], c * xs[0])
              for k, (a, b, c) in slopes.items()}  # fmt: skip
    map_ = expression_map(xs, (mu,), pieces, SIDES)
    fixed = np.linalg.solve(
        np.eye(3) - [[2.318, 1, 0], [-1.747, 0, 1], [-0.089, 0, 0]], [0.01, 0, 0]
    )
    settings = CurveSettings(spans=((-0.02, 0.02),), window=((-50.0, 50.0),) * 3)
    units = {"x_scale": [1.0] * 3, "p_scale": [1.0]}  # the parameter hardly moves along a cycle
    found = connected(map_, fixed, [0.01], settings, orders=(1, 3), **units).diagram
    at = {each: sorted(hit.branch.word for hit in found.at(each)) for each in (-0.01, 0.01)}
    assert at == {-0.01: ["L", *3 * ["L | L | R"]], 0.01: [*3 * ["L | R | R"], "R"]}


@pytest.mark.slow
def test_cycles_with_impacts_in_a_row_are_born_at_a_grazing() -> None:
    """Nordmark's map: all seven words of up to four points with R are born, L to its other side.

    Words by Newton's method from many starts at mu = 0.002, independently of the engine.
    """
    for a, c, r in ((0.5, 0.05, 1.0), (0.6, 0.05, 0.5)):
        pieces = {"L": (a * x + y + mu, -c * x), "R": (y + mu - sympy.sqrt(x), -c * r**2 * x)}
        map_ = expression_map((x, y), (mu,), pieces, SIDES)
        start = np.linalg.solve([[1.0 - a, -1.0], [c, 1.0]], [-0.05, 0.0])
        settings = CurveSettings(spans=((-0.1, 0.1),), window=((-2.0, 2.0),) * 2)
        found = connected(map_, start, [-0.05], settings, orders=(1, 2, 3, 4)).diagram
        words = [hit.branch.word.replace(" | ", "") for hit in found.at(0.002)]
        each = ("R", "LR", "LLR", "LRR", "LLLR", "LLRR", "LRRR")
        assert sorted(words) == sorted(word for word in each for _ in word)


def test_test_functions_beyond_a_root_have_no_value_and_give_no_warning() -> None:
    """At x = -1 sqrt(x) has no slope: determinants of nan would warn."""
    map_ = expression_map((x, y), (mu,), {"R": (y + mu - sympy.sqrt(x), -x / 2)})
    orbit = orbit_of(map_.pieces, np.array([[-1.0, 0.0]]), np.zeros(1))
    assert np.isnan([Multiplier(kind).value(orbit) for kind in ("LP", "PD", "NS")]).all()


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


# --- What starts at border collisions of random maps of the plane, against all cycles nearby ------

# Brute force: every word up to a length names an affine map, its fixed point is a cycle if the
# points lie on the sides that the word says. Such cycles within a short distance of a collision, at
# parameters on both sides of it, must be those that the germ says start there, no more, no fewer.
ORDERS = (1, 2, 3, 4)
BESIDE = 1e-5  # of the parameter: cycles that start at a collision lie at some 1e-5 times a rate
NEAR = 1e-2  # of it: rates up to a thousand; other cycles are farther away
SETTINGS = CurveSettings(spans=((-1.5, 1.5),), window=((-50.0, 50.0), (-50.0, 50.0)))


class Affine:
    """x -> A x + b + c p on each side of x = 0."""

    def __init__(self, rng: np.random.Generator, jumps: bool) -> None:
        self.matrices = {side: rng.uniform(-1.4, 1.4, (2, 2)) for side in "LR"}
        offset, rate = rng.uniform(-0.5, 0.5, 2), rng.uniform(-1.0, 1.0, 2)
        self.offsets = {"L": offset, "R": offset + (rng.uniform(-0.5, 0.5, 2) if jumps else 0.0)}
        self.rates = dict.fromkeys("LR", rate)
        if not jumps:  # continuous: both matrices agree along the border
            self.matrices["R"][:, 1] = self.matrices["L"][:, 1]

    def expressions(self) -> ExpressionMap:
        pieces = {
            side: [
                a[i, 0] * x + a[i, 1] * y + self.offsets[side][i] + self.rates[side][i] * p
                for i in range(2)
            ]
            for side, a in self.matrices.items()
        }
        return expression_map((x, y), (p,), pieces, {"L": {"x = 0": -x}, "R": {"x = 0": x}})

    def cycle(self, word: str, at: float) -> np.ndarray | None:
        """Its points (n, 2), if they lie on their sides."""
        matrix, shift = np.eye(2), np.zeros(2)
        for side in word:
            a = self.matrices[side]
            matrix, shift = a @ matrix, a @ shift + self.offsets[side] + self.rates[side] * at
        points = [np.linalg.solve(np.eye(2) - matrix, shift)]
        for side in word[:-1]:
            points.append(
                self.matrices[side] @ points[-1] + self.offsets[side] + self.rates[side] * at
            )
        sides = [
            (-1.0 if side == "L" else 1.0) * q[0] for side, q in zip(word, points, strict=True)
        ]
        return np.array(points) if min(sides) > 0.0 else None


def least_turn(word: str) -> str:
    return min(word[i:] + word[:i] for i in range(len(word)))


def words() -> list[str]:
    """One of each class of rotated words, none of them a power."""
    found = []
    for order in ORDERS:
        for letters in product("LR", repeat=order):
            word = "".join(letters)
            turns = {word[i:] + word[:i] for i in range(order)}
            if word == min(turns) and len(turns) == order:
                found.append(word)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("jumps", [False, True])
def test_cycles_that_start_at_collisions(jumps: bool) -> None:
    rng = np.random.default_rng(3)
    collisions = births = 0
    for _ in range(20):
        affine = Affine(rng, jumps)
        start = affine.cycle("L", 0.7)
        if start is None or np.abs(start).max() > 40.0:
            continue
        map_ = affine.expressions()
        found = connected(map_, start, [0.7], SETTINGS, orders=ORDERS[:2])
        base = SolutionCurve(map_, cycles((0,), (1.0, 1.0), (1.0,)), SETTINGS)
        for point in found.diagram.points:
            if point.kind not in (PointKind.BC, PointKind.FF) or abs(point.parameter) > 1.4:
                continue
            orbit = found.orbits[point.id]
            starts = list(beginnings(base, orbit.x, orbit.p, ORDERS))
            said = {
                (least_turn(each.sample.orbit.word.replace(" | ", "")), each.sample.rate > 0.0)
                for each in starts
                if not each.is_crossing
            }
            shown = set()
            for sign in (-1.0, 1.0):
                at = point.parameter + sign * BESIDE
                for word in words():
                    points = affine.cycle(word, at)
                    if points is not None and _is_near(points, orbit.x):
                        shown.add((word, sign > 0.0))
            assert said == shown, (point.parameter, affine.matrices)
            collisions += 1
            births += len(said) > 2
    assert collisions >= 2
    assert births > 0 or jumps


def _is_near(points: np.ndarray, orbit: np.ndarray) -> bool:
    """Whether all points lie near points of an orbit, and go round all of it."""
    away = np.abs(points[:, None] - orbit[None]).max(axis=2)
    return bool(away.min(axis=1).max() < NEAR and len(points) % len(orbit) == 0)


def test_crossings_of_one_border_whose_limits_take_other_pieces_later_are_two() -> None:
    """Of P_2 two end where a cycle of two points meets the border, one for each point there.

    That from (0, y) has its limits L(L(0, y)) and L(R(0, y)); another one of P_2, from R, has
    limits by R(L) and R(R) at the same border and parameter. As all is affine one Newton step leads
    from each to the other.
    """
    left = (0.32 * x + 0.26 * y - 0.74 * p - 0.71, 0.07 * x - 1.14 * y - 0.49 * p - 0.45)
    right = (1.38 * x + 0.41 * y - 0.74 * p - 0.91, 0.65 * x + 0.63 * y - 0.49 * p - 0.06)
    map_ = expression_map(
        (x, y), (p,), {"L": left, "R": right}, {"L": {"x = 0": -x}, "R": {"x = 0": x}}
    )
    settings = CurveSettings(spans=((-1.5, 1.5),), window=((-3.0, 3.0), (-3.0, 3.0)))
    found = connected(
        map_, [0.22, 0.99], [-0.57], settings, orders=(1, 2), names=("p", "x", "y")
    ).diagram
    ends = {point.id: point for point in found.points}
    lost = [
        branch
        for branch in found.branches
        if branch.word == "L | L / R | L" and ends[branch.ends[0]].kind is PointKind.BC
    ]
    assert len(lost) == 1
    one, other = map_.pieces
    for at, second in zip(lost[0].parameter, lost[0].columns["y"], strict=True):
        start, value = np.array([0.0, second]), np.array([at])
        inner, outer = (one.at(each.at(start, value).value, value).value for each in (one, other))
        way, to = outer - inner, start - inner
        share = float(way @ to) / float(way @ way)
        assert -1e-9 <= share <= 1.0 + 1e-9  # Newton's method leaves some 1e-13
        assert to == pytest.approx(share * way, abs=1e-9)


def test_a_crossing_that_closes_as_a_shorter_cycle_leaves_its_point_on_the_border() -> None:
    """Of a head that runs twice through a fixed point (0, c) rounding has moved the first point."""
    pieces = {"L": (x / 2 + y - p, y / 2 + p / 2), "R": (x / 2 + y, y)}
    map_ = expression_map((x, y), (p,), pieces, {"L": {"x = 0": -x}, "R": {"x = 0": x}})
    left, right = map_.pieces
    head, at = np.array([[-3e-11, 5e5], [0.0, 5e5]]), np.array([5e5])
    orbit = orbit_of([left, left], head, at, 0.0, right)
    problem = CurveSettings(spans=((-1e6, 1e6),), window=((-1e6, 1e6),) * 2).cycles(
        (0,), 1, None, None
    )
    assert cycle_at_limit(orbit, problem).x.tolist() == [[0.0, 5e5]]


def test_sides_of_a_point_are_asked_for_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Paths of all orders from all points of a cycle go through the same points."""
    asked: list[bytes] = []
    sides = germs.sides

    def counted(map_: SpaceMap, at: np.ndarray, *others: np.ndarray) -> list[SpaceImage]:
        asked.append(at.tobytes())
        return sides(map_, at, *others)

    monkeypatch.setattr(germs, "sides", counted)
    pieces = {"L": (y, p - x / 2), "R": (y, p - 2 * x)}
    map_ = expression_map((x, y), (p,), pieces, {"L": {"x = 0": -x}, "R": {"x = 0": x}})
    problem = SETTINGS.cycles((0,), 1, None, None)
    base = SolutionCurve(map_, problem, SETTINGS)
    cycle = np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.5]])
    tuple(beginnings(base, cycle, np.array([1.0]), (1, 2, 3, 4)))
    assert len(asked) == len(set(asked)) > len(cycle)
