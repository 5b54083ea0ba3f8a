"""The graph of curves over two parameters: nodes are points of codimension two, edges curves."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise

import networkx as nx
import numpy as np

from pwmap.diagrams.frames import unique_names
from woodpecker.base.arrays import Floats
from woodpecker.base.checks import instance
from woodpecker.base.shown import shown
from woodpecker.plane.curve import Curve, PlanePoint

SAME = 1e-8  # fraction of the extent of all curves: points this close are one, as each of two
# curves that meet in a point locates it to rounding


def graph_of_curves(curves: Sequence[Curve]) -> nx.MultiGraph:
    """The graph of curves, each cut at its special points.

    Parameters
    ----------
    curves
        Curves over the same two parameters.

    Returns
    -------
    networkx.MultiGraph
        Nodes have ``kind``, ``cause``, ``status``, ``x`` (of the first point), and both parameters
        by name, with an underscore if another attribute has that name. Edges, keyed by the numbers
        of the curve and of the part, have ``kind`` (the codes along the part), ``note``, ``curve``,
        ``samples``, and ``word`` and ``beyond`` in the middle of the part. It can be written by
        :func:`pwmap.write_graph`.

    Raises
    ------
    ValueError, TypeError
        If curves are over different parameters, or one is none.

    Examples
    --------
    >>> from woodpecker.examples import border_curve
    >>> from woodpecker.plane import graph_of_curves
    >>> curve = border_curve()
    >>> graph = graph_of_curves([curve])
    >>> graph.number_of_nodes(), graph.number_of_edges()
    (2, 1)
    """
    if not isinstance(curves, Iterable):
        raise TypeError(f"curves must be a list of them, got {shown(curves)}")
    curves = list(curves)
    for curve in curves:
        instance("curve", curve, Curve)
    names = {curve.names for curve in curves}
    if len(names) > 1:
        raise ValueError(f"expected curves over the same parameters, got {sorted(names)}")
    graph = nx.MultiGraph()
    units = _units(curves)
    places = list[tuple[str, PlanePoint]]()
    for number, curve in enumerate(curves, start=1):
        nodes = [_node(graph, curve, point, places, units) for point in curve.points]
        for part, ((a, one), (b, other)) in enumerate(
            pairwise(zip(nodes, curve.points, strict=True)), start=1
        ):
            graph.add_edge(a, b, key=f"C{number}.{part}", **_edge(curve, number, one, other))
    return graph


def _units(curves: Sequence[Curve]) -> Floats:
    """The extents (3,) of all curves in x and in both parameters, as units."""
    if not curves:
        return np.ones(3)
    x = np.concatenate([curve.x.ravel() for curve in curves])
    values = np.concatenate([curve.values for curve in curves])
    size = np.append(np.ptp(x), np.ptp(values, axis=0))
    return np.where(size > 0.0, size, 1.0)


def _node(
    graph: nx.MultiGraph, curve: Curve, point: PlanePoint, places: list[tuple[str, PlanePoint]],
    units: Floats,
) -> str:  # fmt: skip
    """The name of a point's node, which is new unless an earlier point is the same."""
    for name, other in places:
        if point.kind is other.kind and _is_same(point, other, units):
            return name
    count = sum(other.kind is point.kind for _, other in places) + 1
    name = f"{point.kind}{count}"
    places.append((name, point))
    about = {
        "kind": str(point.kind), "cause": point.cause, "status": str(point.status),
        "x": point.x[0],
    }  # fmt: skip
    names = unique_names(curve.names, about)
    graph.add_node(name)
    graph.nodes[name].update(about, **dict(zip(names, point.values, strict=True)))
    return name


def _is_same(one: PlanePoint, other: PlanePoint, units: Floats) -> bool:
    """Whether two points are one to within their precision."""
    known = np.add(one.precision, other.precision)
    off = np.abs(np.subtract(one.values, other.values))
    near = off <= SAME * units[1:] + np.where(np.isfinite(known), known, 0.0)
    return bool(near.all()) and any(abs(one.x[0] - x) <= SAME * units[0] for x in other.x)


def _edge(curve: Curve, number: int, one: PlanePoint, other: PlanePoint) -> dict[str, object]:
    middle = (one.sample + other.sample) // 2
    stretch = [each for each in curve.words if each.first <= middle][-1]
    codes = dict.fromkeys(map(str, curve.codes[one.sample : other.sample + 1]))  # each once
    return {
        "curve": f"C{number}",
        "kind": " ".join(codes),
        "note": curve.notes[middle],
        "samples": other.sample - one.sample + 1,
        "word": stretch.word,
        "beyond": stretch.beyond,
    }
