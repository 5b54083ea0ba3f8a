"""A rectangle of two parameters, cut into faces by curves.

Everything is in the unit square: parameters in parts of their spans.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import shapely
from shapely import LineString, MultiLineString, Polygon
from shapely.ops import polygonize, unary_union

from woodpecker.base.arrays import Floats
from woodpecker.plane.curve import Curve
from woodpecker.plane.families import Pair

GRID = 1e-10  # points this close are one: curves meet to rounding, not exactly
SQUARE = shapely.box(0.0, 0.0, 1.0, 1.0)
NOTHING_HAPPENS = "word change"  # at such a border neither cycles nor their stability change

Spans = tuple[Pair, Pair]


def scaled(values: Floats, spans: Spans) -> Floats:
    """Parameters (..., 2) in parts of their spans."""
    low, high = np.array(spans).T
    found: Floats = (np.asarray(values) - low) / (high - low)
    return found


def unscaled(parts: Sequence[float] | Floats, spans: Spans) -> Pair:
    """The parameters of parts of their spans."""
    (a, b), (c, d) = spans
    return a + float(parts[0]) * (b - a), c + float(parts[1]) * (d - c)


def lines_of(curves: Iterable[Curve], spans: Spans) -> MultiLineString:
    """The parts of curves at which something changes, within the square."""
    lines = []
    for curve in curves:
        points = scaled(curve.values, spans)
        for _, note, first, last in curve.stretches():
            part = points[first : last + 2]
            if note != NOTHING_HAPPENS and len(part) > 1:
                lines.append(LineString(part))
    return MultiLineString(lines)


def faces_of(lines: MultiLineString) -> list[Polygon]:
    """The faces into which lines cut the square; they cover it."""
    within = shapely.intersection(lines, SQUARE)
    every = shapely.set_precision(unary_union([within, SQUARE.boundary]), GRID)
    return sorted(polygonize(every), key=lambda face: -face.area)


def inner_place(face: Polygon) -> tuple[Pair, float]:
    """The place of a face that is farthest from its border, about, and how far it is."""
    circle = shapely.maximum_inscribed_circle(face, tolerance=0.01 * np.sqrt(face.area))
    x, y = circle.coords[0]
    return (float(x), float(y)), float(circle.length)


def face_of(place: Pair, faces: Sequence[Polygon]) -> int:
    """Which face a place lies in; -1 if in none, on a border."""
    point = shapely.Point(place)
    return next((k for k, face in enumerate(faces) if face.contains(point)), -1)
