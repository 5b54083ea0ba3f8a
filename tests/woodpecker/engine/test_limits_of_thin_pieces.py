"""Jump crossings at borders beside which ever thinner pieces have one limit, as bounces do."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from needs import NEEDS_NUMBA

from pwmap.diagrams.diagram import BranchKind, PointKind, PointStatus
from studies.common.random_toys import random_toy
from woodpecker import (
    Search,
    Settings,
    ToyPieces,
    bifurcation_diagram,
    continuation,
    shoot,
    slices_at,
)
from woodpecker.engine.line import LineMap
from woodpecker.engine.maps import ACCUMULATE, accumulated
from woodpecker.maps import Image

RATIO = 0.4  # of the widths of neighbouring pieces
STEEP = 3.0  # slope of each of them
# Slopes of the margins that bound them: where the end with the second one is a tie, both are.
GENTLE, SHARP = 1e2, 1e4
SETTINGS = Settings(span=(-2.0, 2.0), window=(-3.0, 3.0))
AT, UNITS = np.array([0.25]), np.array([1.0, 1.0])


class Bounces(NamedTuple):
    """(p + 1)/2 up to x = p (n = -1); beyond, a saw whose teeth have the widths RATIO**n.

    Its limit at x = p is (p - 1)/2, or that and ``apart`` more for every other tooth.
    Teeth are parabolas with ``bend`` as half of their second derivative.
    """

    n: int
    apart: float
    bend: float

    @property
    def key(self) -> int:
        return self.n

    @property
    def word(self) -> str:
        return "rests" if self.n < 0 else f"bounces {self.n} times"

    def at(self, x: float, p: float) -> Image:
        u, n = x - p, self.n
        if n < 0:
            value, slope, margins, rates = 0.5 * (p + 1.0), 0.0, [-GENTLE * u], [-GENTLE]
        else:
            value = 0.5 * (p - 1.0) + STEEP * (u - RATIO**n) + n % 2 * self.apart
            value += self.bend * u * u
            margins = [GENTLE * (RATIO**n - u), SHARP * (u - RATIO ** (n + 1))]
            slope, rates = STEEP + 2.0 * self.bend * u, [-GENTLE, SHARP]
        gradients = np.array([[rate, -rate] for rate in rates])
        codes = np.arange(max(n, 0), max(n, 0) + len(margins))
        return Image(value, slope, 0.5 - slope, np.array(margins), gradients, codes, self)

    def cause(self, code: int) -> str:
        return f"bounce {code} only just happens"


class Bouncing(NamedTuple):
    """Bounces become ever more towards x = p from above, where they have come to an end."""

    apart: float = 0.0
    bend: float = 0.0

    def at(self, x: float, p: float) -> Image:
        n = -1 if x <= p else max(0, math.floor(math.log(x - p) / math.log(RATIO)))
        return Bounces(n, self.apart, self.bend).at(x, p)


def test_the_limit_of_thin_pieces_is_a_side_of_a_jump() -> None:
    """Both limits are known, (p + 1)/2 and (p - 1)/2: x = p lies between them for -1 < p < 1."""
    (found,) = slices_at(Bouncing(), 0.25, (1,), SETTINGS)
    (jump,) = found.jumps
    assert jump.x == pytest.approx(0.25, abs=1e-15)
    assert sorted(jump.offsets) == pytest.approx([-0.375 - 0.25, 0.625 - 0.25], abs=1e-12)


def test_without_a_common_limit_there_is_none() -> None:
    """Every other tooth is higher by 0.1."""
    right = np.array([1.0, 0.0])
    for apart, has_limit in ((0.0, True), (0.1, False)):
        line = LineMap(Bouncing(apart))
        assert line.beside(AT, AT, right).reason == ACCUMULATE
        assert (accumulated(line, AT, AT, right, UNITS) is not None) is has_limit
        assert accumulated(line, AT, AT, -right, UNITS) is None  # there is one piece


@pytest.mark.parametrize(
    "searched", [pytest.param(True, marks=pytest.mark.slow), False], ids=["search", "continuation"]
)
def test_a_cycle_ends_in_such_a_crossing(searched: bool) -> None:
    """The fixed point (p + 1)/2 of what rests ends at p = 1 in the crossing, x = p."""
    map_ = Bouncing()
    if searched:
        found = bifurcation_diagram(map_, "p", (-0.9, 2.0), (1,), (-3.0, 3.0))
    else:
        found = continuation(map_, shoot(map_, 1.4, p=1.8), settings=SETTINGS)
    (jump,) = [each for each in found.branches if each.kind is BranchKind.JUMP]
    (fixed,) = [each for each in found.branches if each.kind is BranchKind.FIXED_POINT]
    assert jump.x == pytest.approx(jump.parameter, abs=1e-12)
    assert fixed.x == pytest.approx(0.5 * (fixed.parameter + 1.0), abs=1e-12)
    (shared,) = [point for point in found.points if len(point.branches) == 2]
    assert {*shared.branches} == {jump.id, fixed.id}
    assert (shared.parameter, shared.x) == pytest.approx((1.0, 1.0), abs=1e-12)
    assert shared.kind in (PointKind.BC, PointKind.FF)
    assert shared.status is PointStatus.LOCATED
    if searched:
        assert (jump.parameter.min(), fixed.parameter.max()) == (-0.9, 2.0)
        assert all(point.status is PointStatus.LOCATED for point in found.points)


@pytest.mark.slow
def test_chains_of_fold_flips_end_where_it_begins() -> None:
    """At p = -1 the lower limit is on the diagonal: tooth by tooth cycles and jumps come there."""
    found = bifurcation_diagram(Bouncing(), "p", (-1.5, 0.0), (1,), (-3.0, 3.0))
    (limit,) = [point for point in found.points if point.kind is PointKind.BC]
    assert abs(limit.parameter + 1.0) <= limit.precision < 1e-12
    kinds = sorted(str(found.branch(each).kind) for each in limit.branches)
    assert kinds.count("jump") >= 2
    (crossing,) = [each for each in found.branches if each.parameter.max() == 0.0]
    assert crossing.id in limit.branches
    assert sum(point.kind is PointKind.FF for point in found.points) > 10


@pytest.mark.slow
def test_the_limit_of_a_chain_is_where_the_crossing_ends() -> None:
    """Links of bent teeth shrink by 0.4 in the limit only: where the chain ends is a guess.

    The end of the crossing, p = -1, is known, and lies within what that guess may be off.
    """
    found = bifurcation_diagram(Bouncing(bend=0.02), "p", (-1.5, 0.0), (1,), (-3.0, 3.0))
    (crossing,) = [each for each in found.branches if each.parameter.max() == 0.0]
    (limit,) = [p for p in found.points if crossing.id in p.branches and p.kind is PointKind.BC]
    assert limit.parameter == pytest.approx(-1.0, abs=1e-12)
    assert len(limit.branches) >= 2
    assert all(point.status is PointStatus.LOCATED for point in found.points)


def test_slices_beside_a_dead_end_show_a_chain() -> None:
    """The crossing ends at p = -1, where teeth accumulate: no curve joins it with their cycles.

    Tooth n has a fixed point for -4.4 * 0.4**n <= p + 1 <= -2 * 0.4**n, all of them within 4.4 of
    that end. Two slices are taken first, and none there.
    """
    search, span = Search(slices=1), (-800.0, 700.0)
    found = bifurcation_diagram(Bouncing(), "p", span, (1,), (-2000.0, 2000.0), search=search)
    cycles = {
        each.word: sorted((each.parameter[[0, -1]] + 1.0).tolist())
        for each in found.branches
        if each.kind is BranchKind.FIXED_POINT
    }
    for n in range(1, 5):
        ends = [-4.4 * RATIO**n, -2.0 * RATIO**n]
        assert cycles[f"bounces {n} times"] == pytest.approx(ends, abs=1e-9)


@NEEDS_NUMBA
def test_a_sleeve_that_has_come_to_rest_meets_one_that_bounces_ever_more() -> None:
    """Beside a thin piece of P_1 the upper sleeve bounces ever more before the beak strikes.

    Plain bisection of P_1(x) - x between neighbouring doubles shows both jumps at its ends.
    """
    drawn = random_toy(91)
    settings = Settings(span=drawn.span, window=drawn.window)
    (found,) = slices_at(ToyPieces(drawn.toy, "eps_n1"), 0.24354604478067698, (1,), settings)
    places = [jump.x for jump in found.jumps]
    for x in (-1.4621027333737533, -1.462021092970536):
        assert min(abs(place - x) for place in places) < 1e-12
