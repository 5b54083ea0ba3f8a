"""Regions of a plane in which cycles of the same periods attract, with borders as expressions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

import sympy

from pwmap.maps.words import first_turn
from pwmap.parameters.results import ParameterCell
from pwmap.plane.strips import Strip


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaneRegion:
    """A part of a :func:`pwmap.parameter_plane` in which cycles of the same periods attract.

    ``across`` has the exact ends of the first parameter, ``along`` the borders of the second as
    expressions in the first, which do not belong to it. ``periods`` are those of attracting cycles,
    among the orders of the plane; their ``words`` are each the first turn in the alphabet.
    """

    across: tuple[sympy.Expr, sympy.Expr]
    along: tuple[sympy.Expr, sympy.Expr]
    periods: tuple[int, ...]
    words: tuple[str, ...]


def regions_of(strips: Sequence[Strip]) -> Iterator[PlaneRegion]:
    """All regions, from left to right and upwards; equal ones of neighbouring strips are joined."""
    growing: list[PlaneRegion] = []
    for strip in strips:
        beside, growing = growing, []
        for region in _of_strip(strip):
            same = [
                each
                for each in beside
                if each.across[1] == region.across[0]
                and replace(each, across=region.across) == region
            ]
            growing += [replace(each, across=(each.across[0], region.across[1])) for each in same]
            growing += [] if same else [region]
            beside = [each for each in beside if each not in same]
        yield from beside
    yield from growing


def attracting(cell: ParameterCell, orders: Sequence[int]) -> dict[str, int]:
    """The words of the cycles of some orders that attract in a cell, with their periods."""
    points = (p for order in orders for p in cell.map.iterate(order).fixed_points() if p.stable)
    found = {first_turn(point.word[: point.period]): point.period for point in points}
    return dict(sorted(found.items()))


def _of_strip(strip: Strip) -> Iterator[PlaneRegion]:
    """The regions of a strip upwards; cells between which nothing changes are joined."""
    rows = [(cell, attracting(cell, strip.cells.orders)) for cell in strip.cells]
    for periods, group in groupby(rows, key=lambda row: tuple(sorted({*row[1].values()}))):
        opened = [(cell, words) for cell, words in group if not cell.is_edge]
        if opened:
            yield PlaneRegion(
                across=(strip.lower, strip.upper),
                along=(opened[0][0].lower, opened[-1][0].upper),
                periods=periods,
                words=tuple(sorted({word for _, words in opened for word in words})),
            )
