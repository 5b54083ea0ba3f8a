"""What starts at border collisions of random maps of the plane, against all cycles nearby.

Brute force: every word up to a length names an affine map, its fixed point is a cycle if the points
lie on the sides that the word says. Such cycles within a short distance of a collision, at
parameters on both sides of it, must be those that the germ says start there, no more and no fewer.
"""

from itertools import product

import numpy as np
import pytest
import sympy

from pwmap.diagrams.diagram import PointKind
from woodpecker.engine import germs
from woodpecker.engine.curves import CurveSettings, SolutionCurve
from woodpecker.engine.formulas import ExpressionMap, expression_map
from woodpecker.engine.germs import beginnings, cycle_at_limit
from woodpecker.engine.maps import SpaceImage, SpaceMap
from woodpecker.engine.newton import cycles
from woodpecker.engine.orbits import orbit_of
from woodpecker.search.connected import connected

x, y, p = sympy.symbols("x y p")
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
