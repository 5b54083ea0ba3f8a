"""Scaled changes of the parameters of a toy, and straight lines of toys."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.base.settings import Settings
from woodpecker.engine.line import first_piece
from woodpecker.engine.maps import SpaceImage
from woodpecker.mechanics.toy import Domain, Toy, description
from woodpecker.shooting import PeriodicOrbit
from woodpecker.toy_map import ToyPiece, ToyPieces, line_of_toys

FARTHEST = 1.0  # length of the longest line: a parameter changes by its own value
FLOOR = 1e-9  # stands for a restitution of zero, from which contacts start to bounce and the
# motion is not differentiable; results change by less, and are computed again with zero
LEAST = 1e-3  # part of its value that a parameter keeps


@dataclass(frozen=True, slots=True, eq=False)
class Space:
    """The changes u of a toy, in units of its parameters, within their limits."""

    toy: Toy  # with FLOOR in place of a restitution of zero
    points: Floats  # (n,) of its periodic motion [rad]
    names: tuple[str, ...]  # of the k parameters
    sizes: Floats  # (k,) their values, which are the units of u; 1 for a value of zero
    low: Floats  # (k,) limits of u
    high: Floats
    settings: Settings

    def toy_at(self, u: Floats) -> Toy:
        """The toy changed by u."""
        values = zip(self.names, (self.sizes * u).tolist(), strict=True)
        return self.toy.replace(**{name: getattr(self.toy, name) + by for name, by in values})

    def line(self, u: Floats, direction: Floats) -> ToyPieces:
        """The toys on a line from the toy changed by u, as a map with the distance as parameter."""
        rates = zip(self.names, (self.sizes * direction).tolist(), strict=True)
        return line_of_toys(self.toy_at(u) if u.any() else self.toy, dict(rates))

    def projected(self, gradient: Floats, value: float) -> Floats:
        """The shortest change u with gradient . u = value, within the limits."""
        free = np.ones(len(gradient), dtype=bool)
        u = np.zeros(len(gradient))
        for _ in range(len(gradient)):
            square = float(gradient[free] @ gradient[free])
            rest = value - float(gradient[~free] @ u[~free])
            u[free] = gradient[free] * (rest / square) if square > 0.0 else 0.0
            outside = free & ((u < self.low) | (u > self.high))
            if not outside.any():
                break
            u[outside] = np.clip(u, self.low, self.high)[outside]
            free &= ~outside
        return u

    def reach(self, direction: Floats) -> float:
        """The length of a line from the toy to the limits of a parameter, at most ``FARTHEST``."""
        with np.errstate(divide="ignore", invalid="ignore"):
            away = np.where(direction > 0.0, self.high, self.low) / direction
        away = away[direction != 0.0]
        return min(FARTHEST, float(away.min())) if len(away) else 0.0


def space_of(orbit: PeriodicOrbit, names: Sequence[str], settings: Settings) -> Space:
    """The space of changes of some parameters of the toy of an orbit."""
    toy = orbit.toy
    zero = [name for name in names if getattr(toy, name) == 0.0]
    at_floor = toy.replace(**dict.fromkeys(zero, FLOOR))
    sizes = np.array([abs(getattr(toy, name)) or 1.0 for name in names])
    high = np.full(len(names), math.inf)
    for k, name in enumerate(names):
        if description(name).domain is Domain.RESTITUTION:
            high[k] = (1.0 - getattr(at_floor, name)) / sizes[k]
    low = np.array([0.0 if name in zero else LEAST - 1.0 for name in names])
    points = np.array(orbit.points[: orbit.minimal_period])
    return Space(at_floor, points, tuple(names), sizes, low, high, settings)


def on_line(line: ToyPieces, image: SpaceImage) -> ToyPiece:
    """The piece of an image of another toy, as a piece of the map of a line of toys."""
    piece = first_piece(image)
    assert isinstance(piece, ToyPiece)
    return piece._replace(whole=line)
