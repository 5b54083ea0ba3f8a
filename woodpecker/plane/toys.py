"""The family of P_1 of the toy over two of its parameters."""

from __future__ import annotations

from dataclasses import dataclass, field

from woodpecker.maps.pieces import Piece, PiecewiseMap
from woodpecker.mechanics.toy import INFINITESIMAL, RESTITUTIONS, Toy
from woodpecker.plane.families import Family, Pair, checked_pair, held_value
from woodpecker.toy_map import ToyPiece, ToyPieces


@dataclass(frozen=True, slots=True)
class ToyFamily(Family):
    """P_1 of the toy over two of its parameters.

    Parameters
    ----------
    toy
        The toy; its own values of both parameters do not matter.
    names
        The two parameters.

    Raises
    ------
    TypeError
        If a parameter is unknown.
    ValueError
        If there are not two, or they are the same.

    Examples
    --------
    >>> from woodpecker import Toy
    >>> from woodpecker.plane import ToyFamily
    >>> family = ToyFamily(Toy(), ("eps_n1", "mu_2"))
    >>> over_mu_2 = family.over(1, (0.4, 0.3))  # with eps_n1 = 0.4
    >>> round(over_mu_2.at(-0.53, 0.3).value, 9)
    -0.563805677
    """

    toy: Toy
    names: tuple[str, str] = field()  # a field in place of the property of a family
    _maps: tuple[ToyPieces, ToyPieces] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        first, second = checked_pair(self.names)
        if first == second:
            raise ValueError(f"expected two different parameters of the toy, got {self.names!r}")
        object.__setattr__(self, "names", (first, second))
        object.__setattr__(self, "_maps", (ToyPieces(self.toy, first), ToyPieces(self.toy, second)))

    def over(self, axis: int, values: Pair) -> PiecewiseMap:
        value, other = held_value(self.names, axis, values), self.names[1 - axis]
        if value == 0.0 and other in RESTITUTIONS:
            value = INFINITESIMAL
        return self._maps[axis].holding(**{other: value})

    def carried(self, piece: Piece, map_: PiecewiseMap) -> Piece:
        assert isinstance(piece, ToyPiece)
        assert isinstance(map_, ToyPieces)
        return piece._replace(whole=map_)
