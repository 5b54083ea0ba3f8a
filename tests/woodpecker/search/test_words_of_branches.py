"""The words of a branch: those of its own pieces, from its first sample on."""

import numpy as np

from pwmap.diagrams.diagram import PointKind
from woodpecker import Settings
from woodpecker.engine.germs import Beginning
from woodpecker.engine.orbits import orbit_of
from woodpecker.examples import two_lines
from woodpecker.search.curves import End, curve_of
from woodpecker.search.tasks import base_of


def test_a_branch_that_begins_beside_a_point_has_its_own_word_there() -> None:
    """The point x = p = 0 has the piece L of the branch that led to it; beyond lies R."""
    curve = base_of(two_lines(), Settings(span=(-1.0, 2.0), window=(-3.0, 3.0)))
    ahead = np.array([0.0, 1.0])
    point, *beyond = (
        curve.start(orbit_of([curve.map.at(np.array([x]), np.array([p])).piece], [[x]], [p]), ahead)
        for x, p in ((-1e-9, 0.0), (0.5, 1.0), (0.6, 1.1))
    )
    end = End(kind=PointKind.BC, p=0.0, x=np.zeros((1, 1)))
    begin = Beginning(1, curve, beyond[0], before=point)
    found = curve_of(begin, (point, *beyond), (), (end, end))
    assert [(word.first, word.text) for word in found.words] == [(0, "R")]
    assert point.orbit.word == "L"
    assert len(found.parameter) == 3
