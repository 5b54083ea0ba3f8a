"""A diagram as arrays that a page can draw: lines, samples, points, and its graph laid out."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from pwmap.diagrams.data import Branch, BranchKind, PointKind, PointStatus, SpecialPoint
from pwmap.diagrams.diagram import Diagram
from pwmap.diagrams.record import LEFT_OUT_KEY
from pwmap.diagrams.shown import brief, counted
from pwmap.explore.figures import DASHES, EMPTY, MARKS, Shown, Table
from pwmap.plot import GREY, MARKERS
from pwmap.plot.diagrams import ranks_of, stretches, width_of
from pwmap.plot.palette import of_period

Floats = npt.NDArray[np.float64]

LINES = ("xs", "ys", "color", "dash", "width", "branch")
SAMPLES = ("x", "y", "branch", "kind", "word", "multiplier")
EDGES = (*LINES, "x", "y", "label", "must", "tip")
POINTS = (
    "x", "y", "id", "label", "kind", "cause", "where", "marker", "color", "size", "angle", "must",
)  # fmt: skip
WIDTH = {"stable": 2.0, "unstable": 1.6, "jump crossing": 1.9}  # px: line widths of P_1
EXACT_LENGTH = 60  # characters of an exact value in a hint
BEND = 0.16  # of further edges between the same two nodes, relative to their length
MOST_LABELS = 30  # most edges that are labelled; a view has at most twice as many labels
RANK_WEIGHT = 0.9  # weight of ranks in the places of the graph; the rest is that of values


def shown(diagram: Diagram, stage: str = "") -> Shown:
    """Lines, samples, points and graph of a diagram; ``stage`` says how far its search is."""
    points = _points(diagram)
    nodes, edges = _graph(diagram, points)
    tables = {
        "lines": _lines(diagram), "samples": _samples(diagram), "points": points, "edges": edges,
        "nodes": nodes,
    }  # fmt: skip
    return Shown(name="diagram", tables=tables, diagram=diagram, message=stage)


def summary(diagram: Diagram) -> str:
    """A sentence on how much was found, and on what was left out."""
    left = [text for text in diagram.given if text.startswith("stopped")]
    if LEFT_OUT_KEY in diagram.about:
        left.append(str(diagram.about[LEFT_OUT_KEY]))
    given_up = sum(point.status is PointStatus.OPEN for point in diagram.points)
    if given_up:
        ends = "end was given up" if given_up == 1 else "ends were given up"
        left.append(f"{given_up} {ends}")
    counts = f"{counted(len(diagram.branches), 'branch')}, {counted(len(diagram.points), 'point')}"
    return "; ".join([counts, *left])


def style_of(branch: Branch, sample: int) -> str:
    """The style of a branch at a sample: stable, unstable or jump crossing."""
    if branch.kind is BranchKind.JUMP:
        return "jump crossing"
    return "stable" if branch.stable[sample] else "unstable"


def table(names: Sequence[str], rows: Iterable[Sequence[Any]]) -> Table:
    """Rows as columns by their names."""
    listed = list(rows)
    return {name: [row[k] for row in listed] for k, name in enumerate(names)}


def _lines(diagram: Diagram) -> Table:
    ranks = ranks_of(diagram)
    thin = {order: width_of(k) if len(ranks) > 1 else 1.0 for order, k in ranks.items()}
    rows = [
        (
            *(np.array(branch.parameter[part]), np.array(branch.x[part])),
            *(of_period(branch.order), DASHES[style], WIDTH[style] * thin[branch.order], branch.id),
        )
        for branch in diagram.branches if branch.kind is not BranchKind.BAND
        for style, part in stretches(branch)
    ]  # fmt: skip
    return table(LINES, rows)


def _samples(diagram: Diagram) -> Table:
    rows = [
        (p, x, branch.id, f"{style_of(branch, k)}, P_{branch.order}", brief(branch.word_at(k)),
         _multiplier(m))
        for branch in diagram.branches
        for k, (p, x, m) in enumerate(
            zip(branch.parameter, branch.x, branch.multiplier.tolist(), strict=True)
        )
    ]  # fmt: skip
    found = table(SAMPLES, rows)
    return found | {name: np.array(found[name], dtype=float) for name in SAMPLES[:2]}


def _multiplier(value: float) -> str:
    return "none: a jump" if np.isnan(value) else f"{value:.6g}"


def _points(diagram: Diagram) -> Table:
    rows = []
    for point in diagram.points:
        mark, color = MARKERS.get(point.kind, (".", GREY))
        end = point.kind is PointKind.EP
        cause = point.cause or ("" if end and point.note else point.kind.meaning)
        rows.append((
            point.parameter, point.x, point.id,
            point.name or ("" if end else str(point.kind)),
            f"{point.kind.label}{', ' + point.note if point.note else ''}",
            cause, _where(point), MARKS.get(mark, "circle"), color,
            14 if mark == "*" else 10 if mark == "D" else 8, np.pi / 2 if end else 0.0,
            bool(point.name),
        ))  # fmt: skip
    return table(POINTS, rows)


def _where(point: SpecialPoint) -> str:
    exact = point.exact.get("parameter")
    if exact is not None:
        return str(exact)[:EXACT_LENGTH]
    return f"{point.parameter:.10g} ± {point.precision:.0e} ({point.status})"


# --- The graph ------------------------------------------------------------------------------------


def _graph(diagram: Diagram, points: Table) -> tuple[Table, Table]:
    places = _layout(points)
    nodes = {**points, "x": places[:, 0].tolist(), "y": places[:, 1].tolist()}
    where = dict(zip(points["id"], places, strict=True))
    rows = []
    seen: dict[frozenset[str], int] = {}
    for branch in diagram.branches:
        pair = frozenset(branch.ends)
        k = seen[pair] = seen.get(pair, -1) + 1
        way = _curve(where[branch.ends[0]], where[branch.ends[1]], k)
        style = style_of(branch, len(branch) // 2)
        middle = way[len(way) // 2]
        tip = f"{style}, P_{branch.order}: {brief(branch.word)}"
        rows.append((
            way[:, 0], way[:, 1], of_period(branch.order), DASHES[style], WIDTH[style], branch.id,
            float(middle[0]), float(middle[1]),
            branch.id if len(diagram.branches) <= MOST_LABELS else "", False, tip,
        ))  # fmt: skip
    return nodes, table(EDGES, rows)


def _layout(points: Table) -> Floats:
    """Places (n, 2) in the unit square: the order of the diagram, with more even distances."""
    places = np.column_stack([points["x"], points["y"]]).astype(float).reshape(-1, 2)
    return np.column_stack([_evened(column) for column in places.T]).reshape(-1, 2)


def _evened(values: Floats) -> Floats:
    """Values in [0, 1] by rank and, a little, by size; infinite ones at the ends."""
    finite = values[np.isfinite(values)]
    if len(finite):
        values = np.clip(values, finite.min(), finite.max())
    size = float(np.ptp(values)) if len(values) else 0.0
    if not size > 0.0:
        return np.full(len(values), 0.5)
    known, rank = np.unique(np.round(values / size, 6), return_inverse=True)
    order = rank / max(1, len(known) - 1)
    evened: Floats = RANK_WEIGHT * order + (1.0 - RANK_WEIGHT) * (values - values.min()) / size
    return evened


def _curve(a: Floats, b: Floats, k: int) -> Floats:
    """The k-th edge between two nodes, (n, 2): straight, then bent to both sides in turn."""
    s = np.linspace(0.0, 1.0, 13)[:, None]
    if np.allclose(a, b):  # a loop
        turn = 2.0 * np.pi * s
        size = 0.05 * (k + 1)
        loop: Floats = a + size * np.hstack([np.sin(turn), 1.0 - np.cos(turn)])
        return loop
    side = np.array([a[1] - b[1], b[0] - a[0]]) * BEND * ((k + 1) // 2) * (1 if k % 2 else -1)
    bent: Floats = a + s * (b - a) + 4.0 * s * (1.0 - s) * side
    return bent


NOTHING = shown(EMPTY)  # where no diagram is known


# --- What lies near a place -----------------------------------------------------------------------


def nearest_line(table: Table, x: float, y: float, scale: tuple[float, float]) -> tuple[str, float]:
    """The branch with the nearest line, and its distance [px]; scale in pixels per unit."""
    best, least = "", np.inf
    for xs, ys, branch in zip(table["xs"], table["ys"], table["branch"], strict=True):
        away = _distance(np.column_stack([xs, ys]) * scale, np.array([x, y]) * scale)
        if away < least:
            best, least = branch, away
    return best, float(least)


def _distance(way: Floats, place: Floats) -> float:
    if len(way) < 2:
        return float(np.hypot(*(way - place).T).min(initial=np.inf))
    start, along = way[:-1], np.diff(way, axis=0)
    length = np.maximum((along**2).sum(axis=1), 1e-300)
    part = np.clip(((place - start) * along).sum(axis=1) / length, 0.0, 1.0)
    return float(np.hypot(*(start + part[:, None] * along - place).T).min())


def nearest_sample(branch: Branch, p: float, x: float, scale: tuple[float, float]) -> int:
    """The sample of a branch nearest to a place, in pixels."""
    return int(np.argmin(np.hypot((branch.parameter - p) * scale[0], (branch.x - x) * scale[1])))
