"""Maps of two pieces that meet at one break."""

from __future__ import annotations

from typing import NamedTuple

from pwmap.algebra.exact import Fraction_, quotient_to_sympy
from pwmap.maps.piecewise_linear import PiecewiseLinearMap, check_map
from pwmap.maps.words import Layout, Word

LEFT, RIGHT = 0, 1  # the letters of the two pieces, as indices


class TwoPieces(NamedTuple):
    """A map of two pieces, its one break, and the piece that owns it."""

    map_: PiecewiseLinearMap
    at: Fraction_
    owner: int

    def read(self, word: str) -> Word:
        """A word as indices."""
        return tuple(map(self.map_.letters.index, word))

    def margin(self, word: Word) -> tuple[Fraction_, bool]:
        """The distance of a cycle's first point inside of its piece, and whether 0 is allowed."""
        (top, bottom), (a, b) = self.map_.orbits.fixed_point(word), self.at
        side = 1 if word[0] == RIGHT else -1
        return (side * (b * top - a * bottom), b * bottom), self.owner == word[0]


def two_pieces(map_: PiecewiseLinearMap) -> TwoPieces:
    """The two pieces of a map with one break; TypeError or ValueError if it is no such map."""
    layout = checked_map(map_)
    if map_.scope != map_.definition.region:
        raise ValueError(f"expected a map for all values assumed, got one of the cell {map_.scope}")
    owners = dict.fromkeys(layout.slots)
    if len(layout.breaks) != 1 or len(owners) != 2:
        raise ValueError(
            "expected a map of two pieces that meet at one break, "
            f"got {len(owners)} pieces and {len(layout.breaks)} breaks"
        )
    return TwoPieces(map_, map_.orbits.preimage(layout.breaks[0], ()), layout.slots[1])


def increasing_pieces(map_: PiecewiseLinearMap) -> TwoPieces:
    """The two pieces of a map, if both increase; errors as :func:`two_pieces`."""
    pieces = two_pieces(map_)
    for letter in (LEFT, RIGHT):
        if map_.oracle.slope((letter,)) <= 0:
            slope = quotient_to_sympy(map_.orbits.slope((letter,)))
            raise ValueError(
                f"expected two pieces that increase, got the slope {slope} "
                f"for {map_.letters[letter]}"
            )
    return pieces


def checked_map(map_: PiecewiseLinearMap) -> Layout:
    """The layout of a map's pieces; TypeError if it is no map, ValueError if it is an iterate."""
    check_map(map_)
    if map_.order != 1:
        raise ValueError(f"expected a map that is no iterate, got one of order {map_.order}")
    return map_.definition.table.layouts[map_.chain[0]]
