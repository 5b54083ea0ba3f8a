"""Files of the page of a piecewise-linear map, the same as the page's lines of Python make."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from pwmap import PiecewiseLinearMap, dynamics
from pwmap.diagrams.diagram import Diagram
from pwmap.diagrams.files import table_as_text
from pwmap.explore.exports import OF_DIAGRAM, OF_STATE, made
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
from pwmap.plot import Drawn, plot_cobweb, plot_density, plot_plane

FILES = {
    "map.png": "picture of the map (PNG)", "map.svg": "picture of the map (SVG)",
    "plane.png": "picture of the plane (PNG)", "plane.svg": "picture of the plane (SVG)",
    "density.png": "picture of the density (PNG)", "density.svg": "picture of the density (SVG)",
    "pieces.csv": "pieces of the iterate (CSV)", "cycles.csv": "cycles (CSV)",
    "orbit.csv": "the orbit (CSV)", "cells.csv": "cells of the parameter (CSV)",
    **OF_DIAGRAM, **OF_STATE,
}  # fmt: skip


def export(name: str, query: str) -> Iterator[tuple[str, bytes]]:
    """A job that makes a file of :data:`FILES` from a state; ValueError for another name."""
    yield from made(name, from_query(query), FILES, _diagram, _DRAWINGS, _TEXTS)


def _check_axis(state: MapState) -> None:
    if not state.axis:
        raise ValueError("the map has no parameter, so there is no diagram of it")


def _diagram(state: MapState) -> Diagram:
    _check_axis(state)
    return whole_diagram(state)


# --- Pictures -------------------------------------------------------------------------------------


def _plane(state: MapState) -> Drawn:
    if not state.plane_names:
        raise ValueError("a plane needs a map with two parameters")
    return plot_plane(plane(state))


_DRAWINGS: dict[str, Callable[[MapState], Drawn]] = {
    "map": lambda state: plot_cobweb(_iterate(state), state.start, state.steps),
    "plane": _plane,
    "density": lambda state: plot_density(dynamics(held(state), budget=BUDGET)),
}


# --- Tables and texts -----------------------------------------------------------------------------


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
    _check_axis(state)
    rows = [
        (cell.lower, cell.upper, point.period, point.word, point.x)
        for cell in cells(state) for point in points_of(cell, state)
    ]  # fmt: skip
    return table_as_text(("lower", "upper", "period", "word", "x"), rows)


_TEXTS: dict[str, Callable[[MapState], str]] = {
    "pieces": _pieces_table,
    "cycles": _cycles_table,
    "orbit": _orbit_table,
    "cells": _cells_table,
}
