"""Margins that carry more rounding than their own derivatives say, as those of long motions do."""

from dataclasses import dataclass

import numpy as np
import pytest
import sympy

from pwmap.diagrams.diagram import BranchKind, PointKind
from woodpecker.base.arrays import Floats
from woodpecker.engine.curves import CurveSettings
from woodpecker.engine.formulas import ExpressionMap, ExpressionPiece, expression_map
from woodpecker.engine.maps import SpaceImage
from woodpecker.search.connected import connected

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
    x, p = sympy.symbols("x p")
    inside = p + sympy.sin(p) / 4 - x
    own = expression_map(
        (x,), (p,), {"L": (x / 2 + 1,), "R": (x / 2 - 1,)},
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
