"""A family of maps of the line as one map of R^1 with two parameters."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.base.settings import Settings
from woodpecker.engine.line import LinePiece
from woodpecker.engine.maps import Lengths, PieceView, SpaceImage, proposed
from woodpecker.engine.newton import Problem, cycles
from woodpecker.maps import pieces
from woodpecker.plane.families import Family, Pair

TURN = 1e-3  # scaled: by this a direction turns inside a span; it still crosses its border


@dataclass(frozen=True, slots=True)
class FamilyPiece(PieceView):
    """A piece of a family, as one of R^1 with two parameters."""

    own: pieces.Piece
    family: Family
    lengths: Lengths  # of x and both parameters that count as 1

    def at(self, x: Floats, p: Floats) -> SpaceImage:
        """Its image of a point, also where the map takes another piece."""
        first = self.over_first(float(x[0]), pair(p))
        return _both(self.family, first, float(x[0]), pair(p), self.lengths)

    def slopes(self, x: Floats, p: Floats) -> Floats:
        """(1, 1) its slope, by the map over the first parameter alone; nan if it has no value."""
        first = self.over_first(float(x[0]), pair(p))
        return np.array([[np.nan if first.reason else first.slope]])

    def over_first(self, x: float, values: Pair) -> pieces.Image:
        """Its image of x as a piece of the map over the first parameter."""
        return self.family.carried(self.own, self.family.over(0, values)).at(x, values[0])


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """The maps of a family as one of R^1 with two parameters, with settings over each of these."""

    family: Family
    settings: tuple[Settings, Settings]
    known: dict[Any, Any] = field(default_factory=dict, repr=False)  # borders on which cycles lie

    @property
    def first(self) -> Settings:
        """The settings over the first parameter; window and tolerances of both are the same."""
        return self.settings[0]

    @property
    def scale(self) -> tuple[float, float, float]:
        """The lengths of x and of both parameters that count as 1."""
        one, other = self.settings
        return one.x_scale, one.p_scale, other.p_scale

    def at(self, x: Floats, p: Floats) -> SpaceImage:
        """The image of a point under the piece that the map takes there."""
        values = pair(p)
        first = self.family.over(0, values).at(float(x[0]), values[0])
        return _both(self.family, first, float(x[0]), values, self.scale)

    def beside(self, x: Floats, p: Floats, direction: Floats) -> SpaceImage:
        """The image of a point under the piece that the map takes infinitesimally beside it."""
        # right at an end of a span the direction turns a little inside, if it finds none without
        image, inside = proposed(self, x, p, direction, self.scale), self._inside(p, direction)
        if not image.reason or inside is direction:
            return image
        return proposed(self, x, p, inside, self.scale)

    def _inside(self, p: Floats, direction: Floats) -> Floats:
        """A direction, turned inside where it leads out of a span or along its end."""
        lows, highs = np.array([each.span for each in self.settings]).T
        inward = np.sign((p <= lows) * 1.0 - (p >= highs))
        scaled = direction / np.array(self.scale)
        leaves = (inward != 0.0) & (scaled[1:] * inward <= 0.0)
        scaled[1:][leaves] = 0.0
        scaled[1:][leaves] = TURN * float(np.abs(scaled).max()) * inward[leaves]
        return scaled * np.array(self.scale) if leaves.any() and scaled.any() else direction

    def cycles(self, *axes: int) -> Problem:
        """The problem of cycles with the parameters of some axes free."""
        return cycles(axes, self.scale[:1], self.scale[1:])


def pair(p: Floats) -> Pair:
    """Two parameters as numbers."""
    first, second = p.tolist()
    return first, second


def _both(
    family: Family, first: pieces.Image, x: float, values: Pair, lengths: Lengths
) -> SpaceImage:
    """An image of the map over the first parameter, with derivatives in the second one added."""
    # Rounding decides whether a margin that begins right at x is there: if only the map over the
    # first parameter has it, its derivative in the second one is nan.
    second = first
    if len(first.causes) or not first.reason:  # beyond its end a piece may still have margins
        second = family.carried(first.piece, family.over(1, values)).at(x, values[1])
    rates = second.gradients[:, 1]
    if not np.array_equal(first.causes, second.causes):
        rates = np.array([second.gradient(code)[1] for code in first.causes.tolist()])
    slopes, reason = [first.slope, first.d_parameter, second.d_parameter], second.reason
    return SpaceImage(
        np.array([math.nan if reason else first.value]),
        np.full((1, 3), math.nan) if reason else np.array([slopes]), first.margins,
        np.column_stack([first.gradients, rates]), first.causes,
        FamilyPiece(second.piece, family, lengths), reason, lengths,
    )  # fmt: skip


def over_first(image: SpaceImage) -> pieces.Image:
    """An image as one of the map of the line over the first parameter; nan if it has no value."""
    piece = image.piece
    assert isinstance(piece, FamilyPiece | LinePiece)
    value, (slope, rate) = float(image.value[0]), image.jacobian[0, :2].tolist()
    if image.reason:
        value = slope = rate = np.nan
    return pieces.Image(
        value, slope, rate, image.margins, image.gradients[:, :2], image.codes,
        piece.own, image.reason,
    )  # fmt: skip
