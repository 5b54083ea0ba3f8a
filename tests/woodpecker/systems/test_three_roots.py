"""Where three roots of a gap meet, a contact strikes without speed: it stays, or leaves from rest.

Numbers of the toy are those of the closed-form kernel, which has a margin of its own for this.
"""

import numpy as np
import pytest
from needs import NEEDS_HEYOKA

from pwmap import PointKind
from studies.systems.toy import map_of
from woodpecker import Toy
from woodpecker.systems import SystemMap, continuation, shoot

pytestmark = [NEEDS_HEYOKA, pytest.mark.slow]

LEAVES, STAYS = "I2 D2 I2 J2", "I2 J2"  # how the words end
BESIDE_THE_JUMP = np.array([-0.7577872574 + 1e-7])
BORDER = 0.12588819497828593  # eps_N1 where three roots meet for this start, by bisection of words
WINDOW = [(-1.6, -0.45)]


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
    assert beyond.margins[beyond.place(code)] < 0.0
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
