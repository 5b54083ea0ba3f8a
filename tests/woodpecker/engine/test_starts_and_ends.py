"""What a curve does where it begins, how well its end is known, and which solution it keeps."""

import math
from dataclasses import replace

import numpy as np
import pytest
from sympy import Rational, sqrt, symbols

from woodpecker.engine.curves import CurveSettings, SolutionCurve, Stop
from woodpecker.engine.following import follow
from woodpecker.engine.formulas import ExpressionMap, expression_map
from woodpecker.engine.newton import cycles
from woodpecker.engine.orbits import OnBorder, orbit_of

X, P = symbols("x p")
SETTINGS = CurveSettings(spans=((-4.0, 4.0),), window=((-4.0, 4.0),))


def curve_of(map_: ExpressionMap) -> SolutionCurve:
    return SolutionCurve(map_, cycles((0,), (1.0,), (1.0,)), SETTINGS)


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
    settings = replace(SETTINGS, spans=((end, 4.0) if p > 0.0 else (-4.0, end),))
    map_ = expression_map((X,), (P,), {"A": (formula,)})
    curve = SolutionCurve(map_, cycles((0,), (1.0,), (1.0,)), settings)
    at = curve.start(orbit_of(map_.pieces, np.array([[x]]), np.array([p])))
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
