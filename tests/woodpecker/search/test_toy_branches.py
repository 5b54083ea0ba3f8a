"""What hangs on the toy's stable cycle: the published points, each with its cause."""

import numpy as np
import pytest
from needs import NEEDS_NUMBA

from pwmap.diagrams.diagram import BranchKind, Diagram, PointKind
from woodpecker.base.executors import Serial
from woodpecker.base.settings import Settings
from woodpecker.mechanics.toy import Toy
from woodpecker.search.diagrams import cycle_near
from woodpecker.search.explorer import Explorer
from woodpecker.search.network import Network
from woodpecker.search.tasks import Tasks, Worker
from woodpecker.simulation.returns import first_return
from woodpecker.slices.borders import BorderKind
from woodpecker.slices.orbits import at_parameter, orbit_of
from woodpecker.slices.partition import partition
from woodpecker.toy_map import ToyPieces

SETTINGS = Settings(span=(0.0, 1.0), window=(-2.5, -0.24))
AT_ONCE = "the beak and the upper sleeve strike at once"
# Points are found by two independent engines, from words and from halvings, within 1e-13; published
# facts have ten digits [Leine2001 with the summed law].
DIGITS = 1e-10


@pytest.fixture(scope="module")
def network() -> Network:
    map_ = ToyPieces(Toy())
    start = orbit_of([map_.at(-0.53, 0.5).piece], np.array([-0.53]), 0.5)
    stable = at_parameter(start, SETTINGS)
    assert stable is not None
    assert stable.x[0] == pytest.approx(-0.52947197, abs=1e-8)
    explorer = Explorer(map_, Serial(Worker(map_, SETTINGS)), SETTINGS, (1,))
    explorer.follow(stable)
    return explorer.network


@pytest.fixture(scope="module")
def diagram(network: Network) -> Diagram:
    return network.diagram("eps_n1", "phi_s")


@NEEDS_NUMBA
@pytest.mark.slow
def test_points_of_the_paper(network: Network, diagram: Diagram) -> None:
    """A, B, C, the end of A's branch, the flip and where jumps begin and end."""
    expected = [
        (PointKind.FF, 0.1119709145, "fold"),  # A
        (PointKind.BC, 0.2915217119, "fold"),  # B
        (PointKind.BC, 0.1851269509, "fold"),  # C
        (PointKind.FF, 0.1881586209, "fold"),
        (PointKind.BC, 0.0453257415, "persistence"),
        (PointKind.BC, 0.7911249391, "persistence"),
        (PointKind.BC, 0.0123065177, "persistence"),
        (PointKind.PD, 0.6485492002, ""),
    ]
    for kind, p, note in expected:
        (k,) = [k for k, point in enumerate(diagram.points) if abs(point.parameter - p) < DIGITS]
        assert (diagram.points[k].kind, diagram.points[k].note) == (kind, note)
        if kind is not PointKind.PD:
            assert network.nodes[k].end.cause == AT_ONCE


@NEEDS_NUMBA
@pytest.mark.slow
def test_a_person_can_read_the_graph(diagram: Diagram) -> None:
    assert len(diagram.branches) <= 20
    kinds = {branch.kind for branch in diagram.branches}
    assert kinds == {BranchKind.FIXED_POINT, BranchKind.JUMP}


@NEEDS_NUMBA
@pytest.mark.slow
def test_samples_are_cycles_of_the_toy(network: Network) -> None:
    """The searching kernel takes every cycle to itself, with the same multiplier.

    Samples at borders and next to them are left out: there a time can be a cube root of rounding.
    """
    rng = np.random.default_rng(3)
    for curve in network.curves:
        if curve.kind is BranchKind.FIXED_POINT:
            borders = {mark.sample + k for mark in curve.marks for k in (-1, 0, 1)}
            borders |= {k % len(curve.parameter) for k in (-2, -1, 0, 1)}
            inner = [k for k in range(len(curve.parameter)) if k not in borders]
            for k in rng.choice(inner, min(5, len(inner)), replace=False):
                x, p = float(curve.points[k][0]), float(curve.parameter[k])
                found = first_return(Toy(eps_n1=p), x)
                # rounding of a return of slope m is some 20 spacings of doubles times m
                assert found.phi_s == pytest.approx(x, abs=1e-14 * (1.0 + abs(found.slope)))
                # beside a square root a slope differs between neighbouring doubles
                beside = [first_return(Toy(eps_n1=p), x + way * 4e-16).slope for way in (-1, 1)]
                spread = abs(beside[1] - beside[0])
                assert found.slope == pytest.approx(
                    curve.multiplier[k], rel=1e-6, abs=1e-8 + spread
                )


@NEEDS_NUMBA
def test_pieces_beside_the_jump() -> None:
    """Two pieces at eps_N1 = 0.02 next to phi_S = -0.8848, and one jump at the published place."""
    x = -0.8847733440
    found = partition(ToyPieces(Toy()), 0.02, (x - 2e-4, x + 2e-4), SETTINGS)
    assert len(found.cylinders) == 2
    assert found.unresolved == 0.0
    (border,) = found.borders(SETTINGS)
    assert border.x == pytest.approx(x, abs=1e-10)
    assert border.kind(SETTINGS) is BorderKind.JUMP
    assert border.cause == AT_ONCE


@NEEDS_NUMBA
@pytest.mark.slow
@pytest.mark.parametrize(
    ("p", "x"), [(0.14, -2.42089938), (0.165, -1.89591451), (0.3, -1.11014887)]
)
def test_a_margin_that_dips_below_zero_does_not_turn_a_branch_round(p: float, x: float) -> None:
    """The upper arm of the island, from the window's end to its collision, wherever it is entered.

    Within a step the beak's margins vanish, come back and vanish again: the branch was turned round
    where one came back (0.14553785, 0.14830486, 0.15757030, depending on where steps fell).
    """
    settings = Settings(span=(0.012, 1.0), window=(-2.5, -0.24))
    map_ = ToyPieces(Toy())
    curve = Tasks(map_, settings).cycle(cycle_near(map_, [x], p, settings)).curve
    ends = sorted((end.p, float(end.x[0]), end.kind) for end in curve.ends)
    assert [kind for *_, kind in ends] == [PointKind.EP, PointKind.FF]
    assert [(p, x) for p, x, _ in ends] == [
        pytest.approx((0.1376285067, -2.5), abs=DIGITS),
        pytest.approx((0.3883495889, -0.8847733440), abs=DIGITS),
    ]
    way = np.sign(curve.parameter[-1] - curve.parameter[0])
    # where two borders lie closer than orbits are told apart a sample may lie a little behind
    assert (way * np.diff(curve.parameter)).min() > -settings.same * settings.p_scale
