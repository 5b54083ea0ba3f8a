"""How a branch is followed: where it begins and ends, and what it passes on its way."""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest
import sympy
from needs import NEEDS_NUMBA, SLOW_TOY
from sympy import Piecewise, Rational, sqrt, symbols

from pwmap.diagrams.diagram import BranchKind, Diagram, PointKind, PointStatus
from woodpecker import PeriodicOrbit, Settings, ToyPieces, continuation, from_sympy, shoot
from woodpecker.base.arrays import Floats
from woodpecker.engine import curves
from woodpecker.engine.arrivals import _other_piece
from woodpecker.engine.curves import Arc, CurveSettings, Sample, SolutionCurve, Stop
from woodpecker.engine.ends import LeapError, ends_between
from woodpecker.engine.following import follow
from woodpecker.engine.formulas import ExpressionMap, ExpressionPiece, expression_map
from woodpecker.engine.germs import lost_beyond
from woodpecker.engine.line import LineMap
from woodpecker.engine.maps import ACCUMULATE, SpaceImage, image_at, taken
from woodpecker.engine.newton import cycles
from woodpecker.engine.orbits import OnBorder, orbit_of
from woodpecker.engine.sharp_folds import extended_round_bend
from woodpecker.examples import two_lines
from woodpecker.maps import Image, PiecewiseMap
from woodpecker.maps.formulas import FormulaMap
from woodpecker.mechanics.toy import Toy
from woodpecker.search.connected import connected

SETTINGS = Settings(span=(-1.0, 1.0), window=(-3.0, 3.0))


class Strip(NamedTuple):
    """x/2 + (p + away)/2 where 2**-(n + 1) < p < 2**-n; up to p = 0 all is one strip, n = -1.

    It has no value beyond, as pieces of the toy have none where an event does not happen.
    """

    n: int
    away: float

    @property
    def key(self) -> Hashable:
        return self.n

    @property
    def word(self) -> str:
        return f"strip {self.n}"

    def at(self, x: float, p: float) -> Image:
        ends = [(-p, -1.0)]
        if self.n >= 0:
            ends = [(p - 2.0 ** -(self.n + 1), 1.0), (2.0**-self.n - p, -1.0)]
        return Image(
            0.5 * (x + p + (self.away if self.n >= 0 else 0.0)), 0.5, 0.5,
            np.array([end for end, _ in ends]), np.array([[0.0, rate] for _, rate in ends]),
            np.arange(len(ends)), self, "no event" if self.n < 0 < p else "",
        )  # fmt: skip

    def cause(self, code: int) -> str:
        return "a strip ends"


class Strips(NamedTuple):
    """Ever thinner strips come to p = 0; beyond it fixed points lie ``away`` from those before."""

    away: float

    def at(self, x: float, p: float) -> Image:
        n = -1 if p <= 0.0 else max(0, math.floor(-math.log2(p)))
        return Strip(n, self.away).at(x, p)


def up_to_zero(map_: PiecewiseMap) -> Diagram:
    """Followed from x = p = -1/2."""
    return continuation(map_, shoot(map_, -0.5, p=-0.5), settings=SETTINGS)


@pytest.mark.slow
def test_a_branch_goes_on_beyond_infinitely_many_strips() -> None:
    """x = p on both sides of p = 0."""
    found = up_to_zero(Strips(0.0))
    (branch,) = [each for each in found.branches if each.kind is BranchKind.FIXED_POINT]
    assert (branch.parameter.min(), branch.parameter.max()) == (-1.0, 1.0)
    assert branch.x == pytest.approx(branch.parameter, abs=1e-14)
    assert branch.words


@NEEDS_NUMBA
@pytest.mark.parametrize(("x", "p"), [(-0.53, 0.5), (-1.7, 0.2), (-0.3, 0.9)])
def test_the_word_is_that_of_the_image(x: float, p: float) -> None:
    """Whether a map says so by itself or is asked for the whole image; values to rounding."""
    toy = ToyPieces(Toy())
    for own in (toy, Strips(0.5)):
        image = LineMap(own).at(np.array([x]), np.array([p]))
        key, value = taken(LineMap(own), np.array([x]), np.array([p]))
        assert key == image.piece.key
        assert value == pytest.approx(image.value, rel=1e-13)


class Rounded(NamedTuple):
    """The strips with a value at every point, though rounding loses the paths of the thin ones."""

    falls: bool  # whether the map has none there either

    def at(self, x: float, p: float) -> Image:
        image = Strips(0.0).at(x, p)
        return image._replace(reason="the path is lost") if 0.0 < p < 2.0**-8 else image

    def taken(self, x: float, p: float) -> tuple[Hashable, float]:
        image = self.at(x, p)
        return image.piece.key, math.nan if image.reason and self.falls else image.value


@pytest.mark.parametrize(("falls", "reason"), [(True, "the path is lost"), (False, ACCUMULATE)])
def test_what_rounding_loses_is_no_fall(falls: bool, reason: str) -> None:
    """A piece that cannot be followed to its end says nothing of a map that returns."""
    map_ = LineMap(Rounded(falls))
    x, p, onward = np.array([0.0]), np.array([0.0]), np.array([0.0, 1.0])
    assert image_at(map_, x, p + 2.0**-9).reason == reason
    assert map_.beside(x, p, onward).reason == reason
    assert lost_beyond(map_, x, p, 1) == ("the path is lost" if falls else "")


@pytest.mark.parametrize(
    "map_", [*map(Strips, (2e-3, -2e-3, 0.02)), *map(Rounded, (True, False))], ids=str
)
def test_a_branch_that_begins_beside_or_farther_off_is_another_one(map_: PiecewiseMap) -> None:
    """x = p before p = 0, and beyond x = p + away, which is near enough to be met by a look ahead.

    Or x = p again from p = 2**-8 on: where no path is known in between, none connects the two.
    """
    found = up_to_zero(map_)
    (end,) = [point for point in found.points if point.parameter > -0.5]
    assert end.status is PointStatus.OPEN
    assert end.parameter == pytest.approx(0.0, abs=1e-12)  # the shortest step is 1e-13 of 2
    (branch,) = found.branches
    assert float(branch.parameter.max()) == end.parameter <= 0.0


# --- A test function that changes its sign without being zero: where a step is to end -------------

STEP = 0.01
PLACE = 0.3  # part of the step at which it leaps


def leaping(size: float) -> tuple[SolutionCurve, Sample, Sample, list[float]]:
    """Cycles of x/2 + p, x = 2 p, two of them, and a function that leaps between these.

    It falls from 1 to ``size`` and goes on from there to -1 with the opposite sign.
    """
    map_, asked = LineMap(two_lines()), list[float]()
    problem = cycles((0,), (1.0,), (1.0,))
    settings = CurveSettings(spans=((-2.0, 2.0),), window=((-5.0, 5.0),))
    piece = map_.at(np.array([-1.0]), np.array([-0.5])).piece
    p = -0.5, -0.5 + STEP / math.sqrt(5.0)  # it leads along (2, 1)
    at = [orbit_of((piece,), np.array([[2.0 * each]]), np.array([each])) for each in p]

    def value(sample: Sample) -> float:
        part = (float(sample.orbit.p[0]) - p[0]) / (p[1] - p[0])
        asked.append(part)
        if part < PLACE:
            return 1.0 - (1.0 - size) * part / PLACE
        return -size - (1.0 - size) * (part - PLACE) / (1.0 - PLACE)

    own = curves.TestFunction(Stop.SPECIAL, value)
    curve = SolutionCurve(map_, problem, settings, tests=(), own=(own,))
    first, last = (curve.start(orbit, np.array([2.0, 1.0])) for orbit in at)
    return curve, first, last, asked


@pytest.mark.parametrize("size", [0.5, 0.05, 2.0**-8])
def test_a_step_ends_right_before_a_leap(size: float) -> None:
    """Where it leaps is known to 2^-10 of the step, and the next step leads half the way."""
    curve, first, last, asked = leaping(size)
    with pytest.raises(LeapError) as found:
        ends_between(curve, first, last, STEP, starts=False)
    assert found.value.part == pytest.approx(0.5 * PLACE, abs=2.0**-10)
    assert len(asked) <= {0.5: 16, 0.05: 24, 2.0**-8: 40}[size]  # down to doubles it takes 55


# --- What a curve does where it begins, how well its end is known, and which solution it keeps ----


X, P = symbols("x p")
WIDE = CurveSettings(spans=((-4.0, 4.0),), window=((-4.0, 4.0),))


def curve_of(map_: ExpressionMap, settings: CurveSettings = WIDE) -> SolutionCurve:
    return SolutionCurve(map_, cycles((0,), (1.0,), (1.0,)), settings)


@pytest.mark.parametrize("bits", range(-3, 4))
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_flip_does_not_end_what_begins_at_it(bits: int, way: float) -> None:
    """Fixed points 1 - 1/p of p x (1 - x) flip at p = 3: rounding puts a start on either side."""
    curve = curve_of(expression_map((X,), (P,), {"A": (P * X * (1 - X),)}))
    at = 2 / 3 + bits * 2.0**-53
    start = orbit_of(curve.map.pieces, np.array([[at]]), np.array([1.0 / (1.0 - at)]))
    arc = follow(curve, curve.start(start, np.array([0.0, way])))
    assert len(arc.samples) > 10
    assert arc.stop is Stop.SPAN if way > 0.0 else Stop.BP


@pytest.mark.parametrize("away", [1e-9, 1e-12, 1e-15])
def test_an_end_near_a_root_is_known_to_the_root_of_its_distance(away: float) -> None:
    """On p + 2 (1/3 - x)^(1/2) = x a point that far from the border has p = 1/3 - 2 h^(1/2) - h."""
    left = {"L": (P + 2 * sqrt(Rational(1, 3) - X),), "R": (P + X - Rational(1, 3),)}
    sides = {"L": {"b": Rational(1, 3) - X}, "R": {"b": X - Rational(1, 3)}}
    curve = curve_of(expression_map((X,), (P,), left, sides))

    def at(distance: float) -> tuple[float, float]:
        return 1 / 3 - distance, 1 / 3 - distance - 2.0 * math.sqrt(distance)

    x, p = at(0.04)
    start = orbit_of(curve.map.pieces[:1], np.array([[x]]), np.array([p]))
    arc = follow(curve, curve.start(start, np.array([1.0, 0.0])))
    assert (arc.stop, arc.border) == (Stop.BORDER, (0, 0))
    x, p = at(away)
    near = curve.start(orbit_of(curve.map.pieces[:1], np.array([[x]]), np.array([p])))
    short = replace(arc, samples=(*arc.samples[:-1], near), condition=OnBorder(0, 0))
    error = 1 / 3 - p
    assert error <= short.precision <= 3.0 * error


@pytest.mark.parametrize(
    ("formula", "start", "stop"),
    [
        (2 * X + X**2 - P, (1.0, 2.0), Stop.LP),  # p = x (1 + x), with its fold at x = -1/2
        (X + P - X**3, (-0.5, -0.125), Stop.SPAN),  # p = x^3, with an inflection at x = 0
        (X / 2 + sqrt(-P), (2.0, -1.0), Stop.SHORT),  # x = 2 (-p)^(1/2), with no value at p > 0
    ],
)  # fmt: skip
def test_a_halt_of_the_parameter_is_a_fold_if_it_turns_back(
    formula: object, start: tuple[float, float], stop: Stop
) -> None:
    """All three halt at a sample: at the end of the span, or where the root has no slope."""
    x, p = start
    end = -0.25 if stop is Stop.LP else 0.0
    settings = replace(WIDE, spans=((end, 4.0) if p > 0.0 else (-4.0, end),))
    curve = curve_of(expression_map((X,), (P,), {"A": (formula,)}), settings)
    at = curve.start(orbit_of(curve.map.pieces, np.array([[x]]), np.array([p])))
    arc = follow(curve, at if at.rate * (end - p) > 0.0 else at.turned)
    assert arc.stop is stop
    last = arc.samples[-1].orbit
    assert abs(last.x[0, 0] - (-0.5 if stop is Stop.LP else 0.0)) < 1e-6
    assert last.p[0] == pytest.approx(end, abs=1e-12)  # the square of that


class Unsure:
    """A map that is asked for its value, as its margins do not decide."""

    def __init__(self, own: ExpressionMap) -> None:
        self.own, self.at, self.beside = own, own.at, own.beside


def test_a_piece_at_another_solution_is_not_the_one_the_map_takes() -> None:
    """The value counts, not the piece alone: 1e-9 of it, times slopes, is left to rounding."""
    own = curve_of(expression_map((X,), (P,), {"A": (P * X * (1 - X),)}))
    curve = replace(own, map=Unsure(own.map))  # type: ignore[arg-type]
    x, p = np.array([0.3]), np.array([2.0])
    image = curve.map.at(x, p)
    for off, same in ((1e-10, True), (1e-8, False)):
        assert curve.takes(x, p, image._replace(value=image.value + off)) is same


# --- Folds whose tip is shorter than the smallest step --------------------------------------------

SHARP = 1e14


@pytest.fixture(scope="module")
def given_up() -> Arc:
    """Fixed points x - p = SHARP (x + p)^2, followed from one half down to the tip at zero."""
    map_ = expression_map((X,), (P,), {"A": (X - (X - P - SHARP * (X + P) ** 2) / 1000,)})
    curve = curve_of(map_, CurveSettings(spans=((-1, 1),), window=((-1, 1),), min_step=1e-13))
    along, across = 0.5, (0.5 / SHARP) ** 0.5
    at, value = np.array([[(across + along) / 2]]), np.array([(across - along) / 2])
    return follow(curve, curve.start(orbit_of(map_.pieces, at, value), np.array([-1.0, 1.0])))


@pytest.mark.parametrize("still", [0, 1, 3])
def test_a_fold_is_seen_however_short_the_last_steps_were(given_up: Arc, still: int) -> None:
    """The least parameter is 1/(8 SHARP), at x = 3/(8 SHARP): slopes 1e-3 tell x to 1e-13 / 1e-3.

    Rounding decides how often a step is shortened before it is given up: the last may not turn.
    """
    assert given_up.stop is Stop.SHORT
    last = given_up.samples[-1]
    found = extended_round_bend(replace(given_up, samples=(*given_up.samples, *(last,) * still)))
    assert found is not None
    assert found.stop is Stop.LP
    tip = found.samples[-1].orbit
    assert float(tip.p[0]) == pytest.approx(1.0 / (8.0 * SHARP), abs=1e-15)
    assert float(tip.x[0, 0]) == pytest.approx(3.0 / (8.0 * SHARP), abs=1e-15)


# --- Branches that hug a border where a root begins, and borders that bounces accumulate at -------

# With a root of height K a cycle is closer to the border than doubles tell long before it meets
# it: by its margin alone the place would be known to some 1e-8 K of the parameter.

MEETS = -1.0 / 15.0 / 0.23  # 4/3 + 2 (p - 1/3) = 1.77 p + 0.6
ROUNDING = 1e-12  # of that: some spacings over the rate 0.23 at which the two sides part

# eps_N2 and eps_N3 larger than the paper's: the upper sleeve bounces, ever less
BOUNCY = Toy(
    m_m=0.0003089935146186515, j_m=5.811579672302826e-09, m_s=0.0046604888781226934,
    j_s=6.173659452492943e-07, g=11.619210436550645, r_0=0.002498618809570294,
    r_m=0.003071933048033796, h_m=0.005845298578684144, l_m=0.010100319153696104,
    l_g=0.015028977919363636, h_s=0.019733376647646884, l_s=0.02012042727010024,
    c_phi=0.006222874739310294, mu_1=0.30907416670316323, mu_2=0.3251268075394606,
    mu_3=0.29577010702913137, eps_n2=0.2257006006641285, eps_n3=0.1736377845163849,
)  # fmt: skip
SPAN = 0.42400660662503104, 0.724006606625031


def hugged(height: int) -> FormulaMap:
    """A line, and the same with a root that pulls down beyond x = 1.77 p + 0.6."""
    x, p = symbols("x p", real=True)
    margin = x - Rational(177, 100) * p - Rational(3, 5)
    line = (x - Rational(4, 3)) / 2 + p + 1
    return from_sympy(
        Piecewise((line, margin < 0), (line - height * sqrt(margin), True)), x, p, words=["L", "R"]
    )


@pytest.mark.parametrize("height", [5, 50, 488, 5000])
@pytest.mark.parametrize("start", [(1.0, 0.8), (-1.3, -0.95)])
def test_the_piece_beyond_says_where_a_branch_meets_its_border(
    height: int, start: tuple[float, float]
) -> None:
    map_ = hugged(height)
    diagram = continuation(
        map_, shoot(map_, start[0], p=start[1]), "p", (-1.0, 1.0), settings=Settings(window=(-5, 5))
    )
    (met,) = [each for each in diagram.points if each.kind.value == "BC"]
    assert abs(met.parameter - MEETS) <= ROUNDING
    assert sorted(branch.word for branch in diagram.branches) == ["L", "R"]


def drawn(x: float, p: float) -> tuple[PeriodicOrbit, Diagram]:
    toy = BOUNCY.replace(eps_n1=p)
    orbit = shoot(toy, x)
    settings = Settings(window=(-2.5, -0.2738), max_evaluations=60_000)
    return orbit, continuation(toy, orbit, "eps_n1", SPAN, settings=settings)


@SLOW_TOY
def test_a_branch_leaves_where_bounces_accumulate_for_ever_fewer() -> None:
    """From ever more bounces, summed, to n of them: borders at distances like 0.187^n."""
    orbit, diagram = drawn(-0.615118904, 0.42408161)
    assert orbit.word == "S2 D2 I3 I1 C3 D3 C2 J2"
    (branch,) = diagram.branches
    assert (branch.parameter[0], branch.parameter[-1]) == SPAN
    words = [change.word for change in branch.changes]
    for bounces in range(2, 12):
        assert f"S2 D2 I3 I1 {bounces * 'I3 '}C2 J2" in words


@NEEDS_NUMBA
def test_a_grazing_with_one_word_on_both_sides_is_passed() -> None:
    """The event is the same one at another time: its piece goes on, but with a root."""
    orbit, diagram = drawn(-1.332277000907486, 0.424081606625031)
    assert orbit.word == "S2 D2 I1 I3 C2 R2 J2"
    (branch,) = diagram.branches
    assert (branch.parameter[0], branch.parameter[-1]) == SPAN


# --- Margins that carry more rounding than their own derivatives say, as of long motions ----------

NOISE = 1e-12  # some 2**12 spacings; margins of a system's motion of nine phases carry 2**8


@dataclass(frozen=True)
class Blurred:
    """A piece with noise on its margins, drawn from the last digits of the point."""

    own: ExpressionPiece

    @property
    def key(self) -> str:
        return self.own.key

    word = key

    def at(self, x: Floats, p: Floats) -> SpaceImage:
        return blurred(self.own.at(x, p), x, p)

    def cause(self, code: int) -> str:
        return self.own.cause(code)


def blurred(image: SpaceImage, x: Floats, p: Floats) -> SpaceImage:
    assert isinstance(image.piece, ExpressionPiece)
    noise = NOISE * np.sin(1e17 * (x[0] + 3.0 * p[0]))
    return image._replace(margins=image.margins + noise, piece=Blurred(image.piece))


@dataclass(frozen=True)
class BlurredMap:
    own: ExpressionMap

    def at(self, x: Floats, p: Floats) -> SpaceImage:
        return blurred(self.own.at(x, p), x, p)

    def beside(self, x: Floats, p: Floats, direction: Floats) -> SpaceImage:
        return blurred(self.own.beside(x, p, direction), x, p)


def test_a_crossing_is_followed_along_such_a_border() -> None:
    """It crosses x = p + sin(p)/4 from x = 2 to x = -2, where the cycles of both sides end."""
    inside = P + sympy.sin(P) / 4 - X
    own = expression_map(
        (X,), (P,), {"L": (X / 2 + 1,), "R": (X / 2 - 1,)},
        {"L": {"the border": inside}, "R": {"the border": -inside}},
    )  # fmt: skip
    settings = CurveSettings(spans=((-2.5, 2.5),), window=((-4.0, 4.0),))
    diagram = connected(BlurredMap(own), [2.0], [2.2], settings, orders=(1,)).diagram
    (crossing,) = (each for each in diagram.branches if each.kind is BranchKind.JUMP)
    ends = sorted(q.parameter for q in diagram.points if q.kind is PointKind.BC)
    border = np.array([q + np.sin(q) / 4 for q in ends])
    assert border == pytest.approx([-2.0, 2.0], abs=10.0 * NOISE)
    border = crossing.parameter + np.sin(crossing.parameter) / 4
    assert crossing.x == pytest.approx(border, abs=10.0 * NOISE)


def test_a_piece_with_the_word_of_the_other_is_told_without_it() -> None:
    """Words of systems leave out what rounding decides, so that two pieces may share one."""
    own, there = (
        SimpleNamespace(
            reason="", codes=np.array([0]), margins=np.array([1.0]),
            piece=SimpleNamespace(word="J1 S1", key=key),
        )
        for key in range(2)
    )  # fmt: skip
    orbit = SimpleNamespace(x=[0.5], p=None, images=[own], point_of=None)
    curve = SimpleNamespace(
        ignored=(), takes=lambda *_: False, map=SimpleNamespace(at=lambda *_: there)
    )
    told = _other_piece(curve, orbit)  # type: ignore[arg-type]
    assert told == "the map takes another piece in place of J1 S1, though no margin of it vanishes"
