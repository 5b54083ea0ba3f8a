"""A diagram in a few lines, as a table, and as a graph."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence

import networkx as nx
import numpy as np

from pwmap.diagrams.data import Branch, SpecialPoint, share_stable
from pwmap.diagrams.formulas import text_of
from pwmap.diagrams.frames import Column, untaken
from pwmap.diagrams.shown import counted, table, tally

Names = tuple[str, str]  # of the parameter and of x


ASSUMED = "assumed"  # in what made a symbolic diagram: conditions on its other parameters


def in_part(given: Sequence[str], about: Mapping[str, object]) -> str:
    """Where a diagram holds, if that is a part only of what was assumed; else empty."""
    assumed, held = about.get(ASSUMED), [each for each in given if re.search("[<>=]", each)]
    if not isinstance(assumed, list | tuple) or {*assumed} == {*held}:
        return ""
    whole = ", ".join(assumed) or "all values"
    return f"for {', '.join(held)} only, a part of what is assumed ({whole})"


def summary(
    names: Names, branches: Sequence[Branch], points: Sequence[SpecialPoint], part: str = ""
) -> str:
    """A few lines: over which parameter, how many branches of each order, which points."""
    lines = [f"Diagram({_over(names, part)}: {_size(branches, points)}"]
    orders = sorted({branch.order for branch in branches})
    lines += [
        f"order {order}: {tally(b.kind for b in branches if b.order == order)}" for order in orders
    ]
    if points:
        lines.append(f"points: {tally(point.kind for point in points)}")
    return "\n    ".join(lines) + ")"


def _over(names: Names, part: str) -> str:
    return f"{names[1]} over {names[0]}{f', {part}' if part else ''}"


def _size(branches: Sequence[Branch], points: Sequence[SpecialPoint]) -> str:
    ends = [each for branch in branches for each in branch.parameter[[0, -1]].tolist()]
    within = f" in [{min(ends):.6g}, {max(ends):.6g}]" if ends else ""
    return f"{counted(len(branches), 'branch')}{within}, {counted(len(points), 'special point')}"


def html(
    names: Names, branches: Sequence[Branch], points: Sequence[SpecialPoint], part: str = ""
) -> str:
    """The special points as a table of a notebook."""
    rows = [
        (
            *(p.name or p.id, ", ".join(filter(None, (p.kind.label, p.note)))),
            *(p.exact.get("parameter", f"{p.parameter:.10g}"), p.exact.get("x", f"{p.x:.10g}")),
            *(p.order, " ".join(p.branches)),
        )
        for p in points
    ]
    header = ("point", "what", *names, "order", "branches")
    return table(f"{_over(names, part)}: {_size(branches, points)}", header, rows)


def columns_of_points(names: Names, points: Sequence[SpecialPoint]) -> dict[str, Column]:
    """Columns of a table with a row for each special point."""
    ends = np.array([p.interval or (math.nan, math.nan) for p in points]).reshape(-1, 2)
    first: dict[str, Column] = {
        "point": [p.id for p in points],
        "name": [p.name for p in points],
        "kind": [str(p.kind) for p in points],
    }
    columns: dict[str, Column] = {
        "order": np.array([p.order for p in points], dtype=int),
        "note": [p.note for p in points],
        "cause": [p.cause for p in points],
        "status": [str(p.status) for p in points],
        "precision": np.array([p.precision for p in points], dtype=float),
        "interval_min": ends[:, 0],
        "interval_max": ends[:, 1],
        "branches": [" ".join(p.branches) for p in points],
    }
    for name in dict.fromkeys(name for p in points for name in p.exact):
        columns[f"{name}_exact"] = [p.exact.get(name) for p in points]
    parameter, x = untaken(names, (*first, *columns))
    first[parameter] = np.array([p.parameter for p in points], dtype=float)
    first[x] = np.array([p.x for p in points], dtype=float)
    return first | columns


def graph_of(
    attributes: Mapping[str, str | float],
    branches: Sequence[Branch],
    points: Sequence[SpecialPoint],
) -> nx.MultiGraph:
    """Special points as nodes, branches as edges between them, with attributes of the graph."""
    graph = nx.MultiGraph()
    graph.graph.update(attributes)
    for point in points:
        graph.add_node(point.id, **_of_node(point))
    for branch in branches:
        graph.add_edge(*branch.ends, key=branch.id, **_of_edge(branch))
    return graph


def _of_node(point: SpecialPoint) -> dict[str, str | float]:
    return {
        "kind": str(point.kind),
        "parameter": float(point.parameter),
        "x": float(point.x),
        "order": float(point.order),
        "note": point.note,
        "cause": point.cause,
        "status": str(point.status),
        "precision": float(point.precision),
        "name": point.name,
        **_bounds(point),
        **{f"{name}_exact": text_of(value) for name, value in point.exact.items()},
    }


def _bounds(point: SpecialPoint) -> dict[str, float]:
    ends = zip(("interval_min", "interval_max"), point.interval or (), strict=False)
    return {name: float(end) for name, end in ends}


def _of_edge(branch: Branch) -> dict[str, str | float]:
    changes = (f"{branch.parameter[s.first]:.10g}: {s.cause}" for s in branch.changes)
    return {
        "kind": str(branch.kind),
        "order": float(branch.order),
        "word": branch.word,
        "stable": share_stable(branch),
        "parameter_min": float(branch.parameter.min()),
        "parameter_max": float(branch.parameter.max()),
        "x_min": float(branch.x.min()),
        "x_max": float(branch.x.max()),
        "samples": float(len(branch)),
        "words": "; ".join(stretch.word for stretch in branch.words),
        "changes": "; ".join(changes),
        **{f"{name}_exact": _formulas(branch, name) for name in branch.exact},
    }


def _formulas(branch: Branch, name: str) -> str:
    found = (stretch.exact[name] for stretch in branch.words if name in stretch.exact)
    return "; ".join(map(text_of, found))
