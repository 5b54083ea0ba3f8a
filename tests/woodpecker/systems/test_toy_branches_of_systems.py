"""The toy as a system, followed across its jumps: where its special points are.

They are those of the closed-form kernel (which has A at 0.11197091 and C at 0.18512695, see the
README), with which the general method shares no code. Both know a special point to 1e-13; the paper
gives three digits.
"""

import numpy as np
import pytest
from needs import NEEDS_HEYOKA
from toy_points import POINTS

from pwmap import Diagram, PointKind
from pwmap.diagrams.diagram import BranchKind
from studies.systems.toy import map_of
from woodpecker import Toy
from woodpecker.systems import SystemMap, continuation, shoot

pytestmark = [NEEDS_HEYOKA, pytest.mark.slow]

A, B, C, LEFT, RIGHT, BACK = (
    POINTS["summed"][name].eps_n1
    for name in ("A", "B", "C", "I1 left", "I1 right", "end of the branch from A")
)
WINDOW = [(-2.5, -0.24)]


def followed(eps: float, guess: float, span: tuple[float, float], most: int) -> Diagram:
    """The branches of first order that are connected with the cycle near a guess."""
    map_ = map_of(Toy(eps_n1=eps), "eps_n1")
    cycle = shoot(map_, [guess])
    assert cycle.success
    return continuation(map_, cycle, span, WINDOW, orders=(1,), max_branches=most).diagram


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("eps", "guess", "span", "point", "kind", "note"),
    [
        (0.113, -0.8823, (0.11, 0.1158), A, PointKind.FF, "fold"),
        (0.2905, -0.886, (0.286, 0.292), B, PointKind.BC, "fold"),
        (0.385, -0.888, (0.383, 0.39), RIGHT, PointKind.FF, "fold"),
        (0.3415, -0.8865, (0.341, 0.344), LEFT, PointKind.BC, "persistence"),
    ],
)
def test_a_point_and_the_crossing_that_starts_there(
    eps: float, guess: float, span: tuple[float, float], point: float, kind: PointKind, note: str
) -> None:
    """The crossing goes on, through changes of word on both of its sides, to the span's end."""
    diagram = followed(eps, guess, span, 2)
    (found,) = (q for q in diagram.points if q.kind is not PointKind.EP)
    assert (found.kind, found.note) == (kind, note)
    assert found.parameter == pytest.approx(point, abs=1e-12)
    (crossing,) = (each for each in diagram.branches if each.kind is BranchKind.JUMP)
    ends = {q.id: q.parameter for q in diagram.points}
    assert {ends[end] for end in crossing.ends} & set(span)
    assert len(crossing.words) >= 3
    if point == B:  # the fixed point begins just there, with the slope of the kernel's table
        (branch,) = (each for each in diagram.branches if each is not crossing)
        k = 0 if branch.ends[0] == found.id else -1
        assert branch.parameter[k] == found.parameter
        assert np.real(branch.multiplier[k]) == pytest.approx(-0.17666, abs=5e-6)


@pytest.mark.nightly
def test_c_is_joined_with_the_branch_below() -> None:
    """The stable branch ends at C, and a short crossing leads to the unstable branch."""
    diagram = followed(0.187, -0.75, (0.184, 0.1885), 3)
    found = sorted((q.kind, q.parameter) for q in diagram.points if q.kind is not PointKind.EP)
    assert [kind for kind, _ in found] == [PointKind.BC, PointKind.FF]
    assert [p for _, p in found] == pytest.approx([C, BACK], abs=1e-12)
    kinds = [each.kind for each in diagram.branches]
    assert kinds.count(BranchKind.JUMP) == 1
    assert kinds.count(BranchKind.FIXED_POINT) == 2


# --- Where three roots of a gap meet a contact strikes without speed: it stays, or leaves from rest

LEAVES, STAYS = "I2 D2 I2 J2", "I2 J2"  # how the words end
BESIDE_THE_JUMP = np.array([-0.7577872574 + 1e-7])
BORDER = 0.12588819497828593  # eps_N1 where three roots meet for this start, by bisection of words


@pytest.mark.nightly
@pytest.mark.parametrize(("side", "ending"), [(-1.0, LEAVES), (1.0, STAYS)])
def test_the_margin_is_smooth_there(side: float, ending: str) -> None:
    """It says how far away the border is; that of acceleration alone would say three times that.

    The duration tau of the last flight goes like the cubic root of the distance, and everything is
    smooth in tau. The margin is a tau^3 (1 + b tau + c tau^2 ...) where the distance is tau^3 (1 +
    b' tau + ...): in margin over derivative b and b' cancel, so that its error goes like tau^2. The
    change of the value across the border, over what its derivative on one side says, has the first
    power of tau. As tau is halved each time the orders follow from neighbours; the next power of
    tau changes them by what that first power itself is, and that must be small enough to tell the
    orders apart from zero.
    """
    map_ = map_of(Toy(eps_n1=BORDER), "eps_n1")
    distances = 1e-6 * 8.0 ** -np.arange(4)
    off = np.array([_errors(map_, side, ending, distance) for distance in distances])
    orders = np.log2(off[:-1] / off[1:]) / 3.0  # in the distance
    first_power = off[:-1, 1]
    assert first_power.max() < 1 / 6
    assert (np.abs(orders[:, 0] - 2 / 3) < first_power).all()
    assert (np.abs(orders[:, 1] - 1 / 3) < first_power).all()


def _errors(map_: SystemMap, side: float, ending: str, distance: float) -> tuple[float, float]:
    """Of the distance from the border, and of the value beyond it; both relative."""
    image = map_.at(BESIDE_THE_JUMP, np.array([BORDER + side * distance]))
    assert image.piece.word.endswith(ending)
    assert image.margins.min() > 0.0
    falls = side * image.gradients[:, 1]  # how fast margins fall on the way to the border
    ways = image.margins[falls > 0.0] / falls[falls > 0.0]
    code = int(image.codes[falls > 0.0][ways.argmin()])
    assert "where phase 8 begins" in image.piece.cause(code)
    beyond = image.piece.at(BESIDE_THE_JUMP, np.array([BORDER - side * distance]))
    assert beyond.margins[beyond.index_of(code)] < 0.0
    moved = -2.0 * side * distance * image.jacobian[0, 1]
    change = beyond.value[0] - image.value[0]
    return abs(ways.min() / distance - 1.0), abs(change / moved - 1.0)


@pytest.mark.nightly
def test_a_branch_passes_it() -> None:
    """Both words have one value there, and the same multiplier: no point of the graph."""
    map_ = map_of(Toy(eps_n1=0.28627), "eps_n1")
    span = 0.28624, 0.28628
    found = continuation(map_, shoot(map_, [-0.8938]), span, WINDOW, orders=(1,)).diagram
    assert {q.kind for q in found.points} == {PointKind.EP}
    assert sorted(q.parameter for q in found.points) == list(span)
