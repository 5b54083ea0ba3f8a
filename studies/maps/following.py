"""Common to the studies of maps: branches from a guess or a search, and checks of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from pwmap import Diagram, PointKind
from woodpecker.base.arrays import Floats
from woodpecker.base.settings import Settings
from woodpecker.maps.formulas import FormulaMap
from woodpecker.maps.pieces import PiecewiseMap
from woodpecker.search.curves import BranchCurve, End
from woodpecker.search.diagrams import cycle_near
from woodpecker.search.explorer import Explorer
from woodpecker.search.network import Network
from woodpecker.search.search import Search, complete
from woodpecker.search.tasks import Tasks
from woodpecker.slices.orbits import to_engine


def branch_near(
    map_: PiecewiseMap, x: Sequence[float], p: float, settings: Settings
) -> list[BranchCurve]:
    """The branch through that cycle, with those that continue it."""
    explorer = Explorer(Tasks.of_line(map_, settings), (len(x),))
    explorer.branch(to_engine(cycle_near(map_, x, p, settings)))
    return explorer.network.curves


def ends_of(curves: Iterable[BranchCurve], kind: PointKind, note: str = "") -> list[End]:
    """Special points of one kind, each once, in the order of the parameter."""
    found: dict[float, End] = {}
    for curve in curves:
        for end in curve.ends:
            if end.kind is kind and end.note == note:
                found.setdefault(round(end.p, 12), end)
    return [found[p] for p in sorted(found)]


def stable_part(curves: Iterable[BranchCurve]) -> float:
    """Length of the parameter along branches on which their cycles attract, by samples."""
    total = 0.0
    for curve in curves:
        stable = np.abs(curve.multiplier) < 1.0
        total += float(np.abs(np.diff(curve.parameter))[stable[1:] & stable[:-1]].sum())
    return total


def searched(
    map_: PiecewiseMap, settings: Settings, orders: Sequence[int], search: Search
) -> Network:
    """All branches of some iterates that a search finds."""
    explorer = Explorer(Tasks.of_line(map_, settings), orders)
    complete(explorer, search)
    return explorer.network


def signs(map_: FormulaMap, diagram: Diagram, order: int, p: float, x: Floats) -> tuple[int, int]:
    """Fixed points of P_order of a continuous map at a parameter, counted in two ways.

    Returns
    -------
    The changes of sign of P_order(x) - x on a grid, and the points of the diagram's branches of all
    orders that divide this one.
    """
    images = x
    for _ in range(order):
        images = map_.values(images, p)
    above = images > x
    divisors = [n for n in range(1, order + 1) if order % n == 0]
    hits = [hit for hit in diagram.at(p) if hit.branch.order in divisors]
    return int((above[1:] != above[:-1]).sum()), len(hits)


def miscounted(
    map_: FormulaMap, diagram: Diagram, orders: Sequence[int], at: Sequence[float], x: Floats
) -> int:
    """For how many of some orders and parameters the two counts of :func:`signs` differ."""
    counts = (signs(map_, diagram, order, p, x) for order in orders for p in at)
    return sum(one != other for one, other in counts)


def changes(network: Network, order: int) -> list[tuple[list[float], bool]]:
    """Between which parameters cycles change their word, and whether the map is smooth there.

    One of the two is the place.
    """
    return [
        (curve.parameter[mark.sample : mark.sample + 2].tolist(), mark.smooth)
        for curve in network.curves
        for mark in curve.marks
        if curve.order == order
    ]
