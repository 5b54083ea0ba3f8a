"""Where three roots of a gap meet, a contact strikes without speed: it stays, or leaves from rest.

Numbers of the toy are those of the closed-form kernel, which has a margin of its own for this.
"""

from __future__ import annotations

import numpy as np
import pytest
from needs import NEEDS_HEYOKA

from pwmap import PointKind
from studies.systems.toy import map_of
from woodpecker import Toy
from woodpecker.systems import continuation, shoot

pytestmark = [NEEDS_HEYOKA, pytest.mark.slow]

LEAVES, STAYS = "I2 D2 I2 J2", "I2 J2"  # how the words end
BESIDE_THE_JUMP = np.array([-0.7577872574 + 1e-7])
BORDER = 0.12588819497828593  # eps_N1 where three roots meet for this start, by bisection of words
WINDOW = [(-1.6, -0.45)]


@pytest.mark.parametrize(("side", "ending"), [(-1.0, LEAVES), (1.0, STAYS)])
@pytest.mark.parametrize("distance", [1e-6, 1e-8, 1e-10])
def test_the_margin_is_smooth_there(side: float, ending: str, distance: float) -> None:
    """It says how far away the border is; that of acceleration alone would say three times that."""
    map_, p = map_of(Toy(eps_n1=BORDER), "eps_n1"), np.array([BORDER + side * distance])
    image = map_.at(BESIDE_THE_JUMP, p)
    assert image.piece.word.endswith(ending)
    assert image.margins.min() > 0.0
    falls = side * image.gradients[:, 1]  # how fast margins fall on the way to the border
    ways = image.margins[falls > 0.0] / falls[falls > 0.0]
    code = int(image.codes[falls > 0.0][ways.argmin()])
    assert "where phase 8 begins" in image.piece.cause(code)
    # the cubic root of the distance is what the next power of the time adds
    assert ways.min() == pytest.approx(distance, rel=3.0 * distance ** (1.0 / 3.0), abs=1e-13)
    beyond = image.piece.at(BESIDE_THE_JUMP, np.array([BORDER - side * distance]))
    assert beyond.margins[beyond.place(code)] < 0.0
    # so does the slope change, which has a limit there: by 12 % at the largest distance
    moved = image.jacobian[0, 1] * -side * 2.0 * distance
    assert beyond.value[0] - image.value[0] == pytest.approx(moved, rel=0.15, abs=1e-12)


def test_a_branch_passes_it() -> None:
    """Both words have one value there, and the same multiplier: no point of the graph."""
    map_ = map_of(Toy(eps_n1=0.28627), "eps_n1")
    span = 0.28624, 0.28628
    found = continuation(map_, shoot(map_, [-0.8938]), span, WINDOW, orders=(1,)).diagram
    assert {q.kind for q in found.points} == {PointKind.EP}
    assert sorted(q.parameter for q in found.points) == list(span)


def test_the_branch_from_b_begins_at_b() -> None:
    """The parameter of B and its slope, as the table of the toy has them."""
    map_ = map_of(Toy(eps_n1=0.2905), "eps_n1")
    cycle = shoot(map_, [-0.886])
    found = continuation(map_, cycle, (0.29, 0.2917), WINDOW, orders=(1,), max_branches=1).diagram
    (b,) = (q for q in found.points if q.kind is PointKind.BC)
    assert b.parameter == pytest.approx(0.2915217118850475, abs=1e-9)
    branch = next(each for each in found.branches if each.id in b.branches)
    k = int(np.abs(np.asarray(branch.parameter) - b.parameter).argmin())
    assert np.real(branch.multiplier[k]) == pytest.approx(-0.17666, abs=1e-4)
