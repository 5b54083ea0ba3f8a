"""Checks for maps of two pieces that meet at one break."""

from __future__ import annotations

from pwmap.algebra.exact import quotient_to_sympy
from pwmap.maps.piecewise_linear import PiecewiseLinearMap, check_map
from pwmap.maps.words import Layout

LEFT, RIGHT = 0, 1  # the letters of the two pieces, as indices


def two_pieces(map_: PiecewiseLinearMap) -> Layout:
    """The layout of a map of two pieces and one break; TypeError or ValueError if it is none."""
    layout = checked_map(map_)
    if map_.scope != map_.definition.region:
        raise ValueError(f"expected a map for all values assumed, got one of the cell {map_.scope}")
    owners = dict.fromkeys(layout.slots)
    if len(layout.breaks) != 1 or len(owners) != 2:
        raise ValueError(
            "expected a map of two pieces that meet at one break, "
            f"the numbers of its pieces and breaks are {len(owners)} and {len(layout.breaks)}"
        )
    return layout


def increasing_pieces(map_: PiecewiseLinearMap) -> Layout:
    """The layout of a map of two increasing pieces; errors as of :func:`two_pieces`."""
    layout = two_pieces(map_)
    for letter in (LEFT, RIGHT):
        if map_.oracle.slope((letter,)) <= 0:
            slope = quotient_to_sympy(map_.orbits.slope((letter,)))
            raise ValueError(
                f"expected two pieces that increase, got the slope {slope} "
                f"for {map_.letters[letter]}"
            )
    return layout


def checked_map(map_: PiecewiseLinearMap) -> Layout:
    """The layout of a map's pieces; TypeError if it is no map, ValueError if it is an iterate."""
    check_map(map_)
    if map_.order != 1:
        raise ValueError(f"expected a map that is no iterate, got one of order {map_.order}")
    return map_.layout
