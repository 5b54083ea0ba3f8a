"""Files of the page of a piecewise-linear map, the same as the page's lines of Python make."""

from __future__ import annotations

from collections.abc import Iterator

from pwmap import PiecewiseLinearMap, dynamics
from pwmap.diagrams.files import table_as_text
from pwmap.explore.exports import Files, made, of_all_pages, pictures
from pwmap.explore.map_data import (
    BUDGET,
    cells,
    cycles_here,
    held,
    orbit,
    plane,
    points_of,
    whole_diagram,
)
from pwmap.explore.map_state import MapState, from_query
from pwmap.plot import plot_cobweb, plot_density, plot_plane


def _iterate(state: MapState) -> PiecewiseLinearMap:
    return held(state).iterate(state.order)


def _pieces_table(state: MapState) -> str:
    rows = [
        (p.word, p.lower, int(p.lower_closed), p.upper, int(p.upper_closed), p.slope, p.intercept)
        for p in _iterate(state).pieces
    ]
    header = ("word", "lower", "lower_closed", "upper", "upper_closed", "slope", "intercept")
    return table_as_text(header, rows)


def _cycles_table(state: MapState) -> str:
    found = cycles_here(held(state))
    if found.left_out:
        raise ValueError(f"the cycles are not complete: {found.left_out}")
    rows = [
        (c.word, len(c.points), c.multiplier, c.stable, "; ".join(map(str, c.points)))
        for c in found
    ]
    return table_as_text(("word", "period", "multiplier", "stable", "points"), rows)


def _orbit_table(state: MapState) -> str:
    return table_as_text(("step", "x"), list(enumerate(orbit(_iterate(state), state))))


def _cells_table(state: MapState) -> str:
    rows = [
        (cell.lower, cell.upper, point.period, point.word, point.x)
        for cell in cells(state) for point in points_of(cell, state)
    ]  # fmt: skip
    return table_as_text(("lower", "upper", "period", "word", "x"), rows)


FILES: Files = {
    **pictures("map", lambda state: plot_cobweb(_iterate(state), state.start, state.steps)),
    **pictures("plane", lambda state: plot_plane(plane(state))),
    **pictures("density", lambda state: plot_density(dynamics(held(state), budget=BUDGET))),
    "pieces.csv": ("pieces of the iterate (CSV)", _pieces_table),
    "cycles.csv": ("cycles (CSV)", _cycles_table),
    "orbit.csv": ("the orbit (CSV)", _orbit_table),
    "cells.csv": ("cells of the parameter (CSV)", _cells_table),
    **of_all_pages(whole_diagram),
}


def export(name: str, query: str) -> Iterator[tuple[str, bytes]]:
    """A job that makes a file of :data:`FILES` from a state; ValueError for another name."""
    yield from made(name, from_query(query), FILES)
