"""Cut a rectangle of two parameters into faces along curves.

Places are given in the unit square: each parameter as a fraction of its span.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby, pairwise

import networkx as nx
import numpy as np
import shapely
from shapely import LineString, MultiLineString, Polygon, STRtree
from shapely.ops import polygonize

from woodpecker.base.arrays import Floats
from woodpecker.plane.curve import Curve
from woodpecker.plane.families import Pair, Spans

GRID = 1e-10  # points this close coincide: curves meet up to rounding only
SQUARE = shapely.box(0.0, 0.0, 1.0, 1.0)
OFF = 0.1 / math.sqrt(2.0), 0.1 / math.sqrt(3.0)  # from the centre of a circle, as parts of its
# radius: borders of words, on which cycles are not counted, often pass through the very centre
NOTHING_HAPPENS = "word change"  # note of a border at which neither cycles nor stability change


def scaled(values: Floats, spans: Spans) -> Floats:
    """Convert parameters (..., 2) to fractions of their spans."""
    low, high = np.array(spans).T
    found: Floats = (np.asarray(values) - low) / (high - low)
    return found


def unscaled(parts: Sequence[float] | Floats, spans: Spans) -> Pair:
    """Convert fractions of the spans to parameters."""
    (a, b), (c, d) = spans
    return a + float(parts[0]) * (b - a), c + float(parts[1]) * (d - c)


def lines_of(curves: Iterable[Curve], spans: Spans, near: float) -> MultiLineString:
    """Lines along those parts of curves at which cycles or their stability change.

    Curves are known by samples only: an end within ``near`` of another line is joined to it.
    """
    lines = list[LineString]()
    for curve in curves:
        points, quiet = scaled(curve.values, spans), np.array(curve.notes) == NOTHING_HAPPENS
        # at a point of codimension two, where a jump closes, the note is that of the point alone
        happens = ~(quiet[:-1] & quiet[1:])
        for drawn, run in groupby(range(len(happens)), happens.__getitem__):
            first, *rest = run
            if drawn:
                lines.append(LineString(points[first : first + len(rest) + 2]))
    return MultiLineString([*lines, *_links(lines, near)])


def _links(lines: Sequence[LineString], near: float) -> Iterator[LineString]:
    """Segments from each end of a line to the nearest other line or side, if that is close."""
    for k, line in enumerate(lines):
        others = MultiLineString([*lines[:k], *lines[k + 1 :], SQUARE.exterior])
        for end in (line.coords[0], line.coords[-1]):
            link = shapely.shortest_line(shapely.Point(end), others)
            if 0.0 < link.length <= near:
                yield LineString(link)


def faces_of(lines: MultiLineString) -> list[Polygon]:
    """The faces into which lines cut the square, all of it, the largest first."""
    within = shapely.intersection(lines, SQUARE)
    every = shapely.union_all([within, SQUARE.boundary], grid_size=GRID)
    return sorted(polygonize(every), key=lambda face: -face.area)


def inner_place(face: Polygon) -> tuple[Pair, float]:
    """A place beside the centre of a nearly largest circle inside a face, and its radius."""
    circle = shapely.maximum_inscribed_circle(face, tolerance=0.01 * np.sqrt(face.area))
    (x, y), radius = circle.coords[0], float(circle.length)
    return (float(x) + OFF[0] * radius, float(y) + OFF[1] * radius), radius


def faces_of_places(places: Sequence[Pair], faces: Sequence[Polygon]) -> list[int]:
    """The index of the face that holds each place; -1 on a border."""
    found = [-1] * len(places)
    points = shapely.points(np.reshape(places, (-1, 2)))
    own, face = STRtree(faces).query(points, predicate="within").tolist()
    for k, number in zip(own, face, strict=True):
        found[k] = number
    return found


def way_between(face: Polygon, lines: MultiLineString, a: Pair, b: Pair, near: float) -> list[Pair]:
    """A way within a face that avoids all lines, also those that end inside; empty without one.

    Unless it is straight it passes the midpoints of the sides of a triangulation.
    """
    straight = LineString([a, b])
    if face.contains(straight) and not straight.intersects(lines):
        return [a, b]
    free = face.difference(lines.buffer(near))
    triangles = [
        triangle
        for part in shapely.get_parts(free)
        for triangle in shapely.constrained_delaunay_triangles(part).geoms
    ]
    ends = [next((k for k, each in enumerate(triangles) if each.covers(shapely.Point(place))), -1)
            for place in (a, b)]  # fmt: skip
    if -1 in ends:
        return []
    sides = nx.Graph()
    owners = dict[frozenset[Pair], int]()
    for k, triangle in enumerate(triangles):
        for one, other in pairwise(triangle.exterior.coords):
            neighbour = owners.setdefault(frozenset((one, other)), k)
            if neighbour != k:
                middle = 0.5 * (one[0] + other[0]), 0.5 * (one[1] + other[1])
                away = math.dist(*(triangles[i].centroid.coords[0] for i in (k, neighbour)))
                sides.add_edge(k, neighbour, weight=away, middle=middle)
    sides.add_nodes_from(ends)
    try:
        passed = nx.shortest_path(sides, *ends, weight="weight")
    except nx.NetworkXNoPath:
        return []
    return [a, *(sides.edges[each]["middle"] for each in pairwise(passed)), b]
