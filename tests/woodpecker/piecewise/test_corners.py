"""Corners, where borders of a map meet: the jumps that leave them."""

from __future__ import annotations

import numpy as np
import pytest
from maps import BORDER, Line

from woodpecker.piecewise.corners import leaving
from woodpecker.piecewise.formulas import FormulaMap, FormulaPiece
from woodpecker.piecewise.settings import Settings


def at_once(x_at: float) -> FormulaMap:
    """A jump at x_at that p does not move; right of it another border at p = 0, and on it a third.

    What the third piece says holds where x is just x_at: there both borders are one event.
    """
    right, here = Line(1.0, 0.0, -x_at), Line(-1.0, 0.0, x_at)
    return FormulaMap(
        [
            FormulaPiece(
                "T", Line(0.0, 0.0, 0.9).smooth(), {BORDER: right.smooth(), "on": here.smooth()}
            ),
            FormulaPiece("L", Line(0.0, 0.0, 0.2).smooth(), {BORDER: here.smooth()}),
            FormulaPiece(
                "R-",
                Line(0.0, 0.1, 0.8).smooth(),
                {BORDER: right.smooth(), "p": Line(0.0, -1.0).smooth()},
            ),
            FormulaPiece(
                "R+",
                Line(0.0, 0.2, 0.8).smooth(),
                {BORDER: right.smooth(), "p": Line(0.0, 1.0).smooth()},
            ),
        ]
    )


@pytest.mark.parametrize("x", [0.5, 0.3, 0.7])
@pytest.mark.parametrize("radius", [1e-8, 1e-6, 1e-4])
def test_what_holds_just_on_a_border_is_no_sector(x: float, radius: float) -> None:
    """The jump leaves straight on, whether or not rounding puts a spoke on the border."""
    map_ = at_once(x)
    assert map_.at(x, 0.1).piece.word == "T"
    settings = Settings(span=(-1.0, 1.0), window=(-2.0, 2.0))
    found = leaving(map_, (x, 0.0), 1, np.array([0.0, -1.0]), radius, settings)
    ahead = [each for each in found if each.direction[1] > 0.0]
    assert len(found) == 2
    assert len(ahead) == 1
    for each in found:
        assert each.head.words[0] in ("L", "R-", "R+")
        assert each.head.x[0] == pytest.approx(x, abs=1e-15)
        assert abs(each.head.p) == pytest.approx(radius * settings.p_scale, rel=1e-4)
