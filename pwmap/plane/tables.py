"""The curves and points of a plane of two parameters as columns, for files and dataframes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import sympy

from pwmap.algebra.exact import to_float
from pwmap.algebra.roots import bounds
from pwmap.plane.network import CodimensionTwo, PlaneCurve

Columns = Mapping[str, Sequence[object]]


def curve_columns(curves: Iterable[PlaneCurve]) -> Columns:
    """One row for each curve; words are parted by blanks."""
    rows = list(curves)
    return {
        "id": [curve.id for curve in rows],
        "kind": [curve.kind.value for curve in rows],
        "note": [curve.note for curve in rows],
        "words": [" ".join(curve.words) for curve in rows],
        "polynomial": [curve.polynomial for curve in rows],
        "from": [curve.ends[0] for curve in rows],
        "to": [curve.ends[1] for curve in rows],
    }


def point_columns(points: Iterable[CodimensionTwo], symbols: Sequence[sympy.Symbol]) -> Columns:
    """One row for each point: both parameters as doubles, then exactly; names parted by blanks."""
    rows = list(points)
    names = [str(symbol) for symbol in symbols]
    return (
        {"id": [point.id for point in rows], "kind": [point.kind.value for point in rows]}
        | {name: [doubles(point)[k] for point in rows] for k, name in enumerate(names)}
        | {f"{name}_exact": [point.values[k] for point in rows] for k, name in enumerate(names)}
        | {"curves": [" ".join(point.curves) for point in rows]}
    )


def doubles(point: CodimensionTwo) -> tuple[float, float]:
    """Both parameters at a point, as doubles."""
    across, along = (to_float(bounds(value)[0]) for value in point.node)
    return across, along
