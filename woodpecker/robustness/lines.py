"""P_1 of the toy along a straight line in the space of its parameters.

A complex step along the line gives derivatives at the cost of a single parameter.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from woodpecker.maps.pieces import Piece
from woodpecker.mechanics.toy import Toy, known_parameter
from woodpecker.toy_map import PerThread, ToyMap, ToyPiece, Values


@dataclass(frozen=True, slots=True)
class ToyLine(ToyMap):
    """P_1 of the toys on a line, as a piecewise-smooth map of (phi_S, distance from the toy).

    Parameters change at ``rates``. TypeError for unknown ones, ValueError for the pole's length.
    """

    toy: Toy
    rates: Mapping[str, float] = field()  # and not the property of a map
    _cache: PerThread = field(default_factory=PerThread, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        for name in self.rates:
            if known_parameter(name) == "pole":
                raise ValueError("a line must leave the pole as it is, got a rate of its length")

    def _values(self, p: float) -> Values:
        return tuple((name, getattr(self.toy, name) + p * by) for name, by in self.rates.items())

    def carried(self, piece: Piece) -> ToyPiece:
        """Returns of these toys along the path of a piece of others."""
        assert isinstance(piece, ToyPiece)
        return ToyPiece(self, piece.path)
