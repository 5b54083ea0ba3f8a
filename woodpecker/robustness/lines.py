"""P_1 of the toy along a straight line through the space of all its parameters.

The kernel's numbers depend on the parameters analytically: a complex step in the direction of the
line gives their derivatives along it, whatever its direction is. So a return along a line costs no
more than one over a single parameter, and what follows branches over a parameter follows them over
any change of the toy.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.maps.pieces import Image, Piece
from woodpecker.mechanics.equations import unsound
from woodpecker.mechanics.modes import (
    CHANGE,
    CONTACT,
    EPS,
    EPSILONS,
    FORCE,
    LIMIT,
    SOUND,
    STEP,
    Numbers,
    model,
    parameters_of,
    refill,
)
from woodpecker.mechanics.toy import Toy, known_parameter
from woodpecker.simulation.paths import Follower
from woodpecker.toy_map import ToyPiece, image_taken


class _Room:
    """Numbers along a line and their derivatives, and a follower."""

    def __init__(self, line: ToyLine) -> None:
        self._line, self._s, self._reason = line, math.nan, ""
        self._numbers: Floats = model(line.toy)
        self._rates: Floats = np.zeros(CHANGE)
        seed = np.array([[line.rates.get(name, 0.0) for name in EPSILONS]])
        self.follower = Follower(self._numbers, self._rates, seed)

    def obstacle(self, x: float, s: float) -> str:
        """Take the numbers of a toy on the line; why it cannot start from there, or nothing."""
        if s != self._s:
            self._take(s)
        if self._reason:
            return self._reason
        if not math.isfinite(x):
            return f"phi_s must be finite, got {x}"
        return "" if x < self._numbers[CONTACT, LIMIT] else "the beak touches the pole"

    def _take(self, s: float) -> None:
        self._s, self._reason = s, ""
        try:
            toy = self._line.toy_at(s)
        except ValueError as error:
            self._reason = str(error)
            return
        steps = np.array([self._line.rates.get(name, 0.0) for name in Numbers._fields]) * STEP
        for k, name in enumerate(EPSILONS):
            self._numbers[CONTACT + k, EPS] = getattr(toy, name)
        refill(parameters_of(toy) + 1j * steps, self._numbers, self._rates)
        if not self._numbers[FORCE, SOUND]:
            self._reason = str(unsound(toy))


class _Cache:
    """What a line keeps between calls."""

    room: _Room | None = None


@dataclass(frozen=True, slots=True)
class ToyLine:
    """P_1 of the toys on a line, as a piecewise-smooth map of (phi_S, distance along the line).

    Parameters
    ----------
    toy
        The toy at distance 0.
    rates
        By how much parameters change per unit of distance; none of the others changes. The length
        of the pole is none of them.

    Raises
    ------
    TypeError
        If a parameter is unknown.
    ValueError
        If the length of the pole is among them.
    """

    toy: Toy
    rates: Mapping[str, float]
    _cache: _Cache = field(default_factory=_Cache, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        for name in self.rates:
            if known_parameter(name) == "pole":
                raise ValueError("a line must leave the pole as it is, got a rate of its length")

    def toy_at(self, s: float) -> Toy:
        """The toy at a distance; ValueError says why there is none."""
        rates = self.rates.items()
        return self.toy.replace(**{name: getattr(self.toy, name) + s * r for name, r in rates})

    def at(self, x: float, p: float) -> Image:
        """The return from phi_S = x [rad] along the path that the toy at distance p takes there."""
        return image_taken(self, x, p)

    def ready(self, x: float, p: float) -> tuple[Follower, str]:
        """The follower, with the numbers of p; why the toy cannot start from there, or nothing."""
        room = self._cache.room
        if room is None:
            room = self._cache.room = _Room(self)
        return room.follower, room.obstacle(x, p)

    @property
    def evaluations(self) -> int:
        """How many returns have been computed, found or followed."""
        return 0 if self._cache.room is None else self._cache.room.follower.evaluations

    def carried(self, piece: Piece) -> ToyPiece:
        """Returns of these toys along the path of a piece of others."""
        assert isinstance(piece, ToyPiece)
        return ToyPiece(self, piece.path)
