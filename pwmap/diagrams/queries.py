"""Queries of a diagram: branches at a parameter, beside a point, on a path, stable intervals."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import networkx as nx
import numpy as np

from pwmap.algebra.exact import Infinite, to_float
from pwmap.algebra.numbers import Exact
from pwmap.algebra.roots import Real, RealRoot, real_to_sympy
from pwmap.diagrams.data import (
    Branch,
    BranchKind,
    Hit,
    PointKind,
    SpecialPoint,
    StableInterval,
    Stretch,
    runs_of,
    stable_inside,
)
from pwmap.diagrams.slices import ExactSlice, exact_number
from pwmap.diagrams.slices import end_of as end_of

Place = tuple[str, int]  # an id of a branch with 0, of a point with 1: ids of both may be the same


def hits(
    branches: Sequence[Branch], name: str, parameter: object, sample: Mapping[str, Any]
) -> tuple[Hit, ...]:
    """Where branches are at a value of the parameter, in order of x."""
    exact = exact_number(parameter)
    if any("interval" in branch.exact for branch in branches):
        return _exact_hits(branches, ExactSlice(name, exact, sample))
    found = [hit for branch in branches for hit in _between_samples(branch, _double(exact))]
    return tuple(sorted(found, key=lambda hit: hit.x))


def exists_within(
    branch: Branch, low: Real, high: Real, name: str, sample: Mapping[str, Any]
) -> bool:
    """Whether a branch exists somewhere between two values of the parameter, or at one."""
    if "interval" not in branch.exact:
        ends = branch.parameter.min(), branch.parameter.max()
        return bool(ends[0] <= _double(high) and _double(low) <= ends[1])
    here = ExactSlice(name, low, sample)
    intervals = (s.exact["interval"] for s in branch.words if "interval" in s.exact)
    return any(here.overlaps(interval, high) for interval in intervals)


def _double(x: Real) -> float:
    return float(real_to_sympy(x)) if isinstance(x, RealRoot | Infinite) else to_float(x)


def _exact_hits(branches: Sequence[Branch], here: ExactSlice) -> tuple[Hit, ...]:
    found: list[tuple[Exact, Hit]] = []
    for branch in branches:
        for formulas in (stretch.exact for stretch in branch.words):
            if "interval" in formulas and here.overlaps(formulas["interval"], here.at):
                found += _hits_of(branch, formulas, here)
    return tuple(hit for _, hit in sorted(found, key=lambda each: each[0]))


def _hits_of(
    branch: Branch, formulas: Mapping[str, object], here: ExactSlice
) -> Iterator[tuple[Exact, Hit]]:
    """Where a branch with some formulas is at a parameter; a band is at both of its ends."""
    names = [n for n in formulas if n not in ("interval", "lower", "upper", "x")]
    values = {name: here.value(formulas[name]) for name in names}
    exact = {name: value.formula for name, value in values.items()}
    multiplier = values["multiplier"].number if "multiplier" in values else math.nan
    for name in ("lower", "upper") if "x" not in formulas else ("x",):
        x = here.value(formulas[name])
        yield x.exact, Hit(branch, x.number, multiplier, {"x": x.formula, **exact})


def _between_samples(branch: Branch, at: float) -> Iterator[Hit]:
    """Where the straight lines between the samples of a branch meet a parameter."""
    p = branch.parameter
    for run in runs_of(p == at):
        # of several samples in a row at this value, the first and the last
        for i in sorted(set(run)):
            yield Hit(branch, float(branch.x[i]), float(branch.multiplier[i]))
    sides = np.sign(p - at)
    for i in np.flatnonzero(sides[:-1] * sides[1:] < 0.0).tolist():
        s = (at - p[i]) / (p[i + 1] - p[i])
        x, m = (
            float((1.0 - s) * values[i] + s * values[i + 1])
            for values in (branch.x, branch.multiplier)
        )
        yield Hit(branch, x, m)


def sides_of(
    point: SpecialPoint, incident: Iterable[Branch]
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Ids of the branches that end at a point, at smaller and at larger parameters."""
    found: dict[int, list[str]] = {-1: [], 0: [], 1: []}
    for branch in incident:
        for end, side in zip(branch.ends, _sides_of_ends(branch, point), strict=True):
            if end == point.id:
                found[side].append(branch.id)
    return tuple(found[-1]), tuple(found[1])


def _sides_of_ends(branch: Branch, point: SpecialPoint) -> tuple[int, int]:
    """For each end at a point, whether the branch lies at smaller (-1) or larger (1) parameters."""
    if "interval" in branch.exact:
        return _side(branch.words[0], point), _side(branch.words[-1], point)
    beside = branch.parameter[[min(1, len(branch) - 1), max(-2, -len(branch))]]
    first, last = (int(p > point.parameter) - int(p < point.parameter) for p in beside.tolist())
    return first, last


def _side(stretch: Stretch, point: SpecialPoint) -> int:
    """Whether an exact stretch lies at smaller (-1) or larger (1) parameters than an end of it."""
    interval: Any = stretch.exact["interval"]
    if not hasattr(interval, "left_open"):  # a set of one value
        return 0
    return 1 if interval.start == point.exact["parameter"] else -1


def collision_near(
    place: tuple[float, float],
    within: float,
    branches: Sequence[Branch],
    points: Sequence[SpecialPoint],
) -> SpecialPoint | None:
    """The nearest border collision of the lowest order; distances are parts of the extent."""
    ends = ([branch.parameter for branch in branches], [branch.x for branch in branches])
    sizes = [float(np.ptp(np.concatenate(values))) or 1.0 for values in ends if values]

    def away(point: SpecialPoint) -> float:
        gaps = (point.parameter - place[0], point.x - place[1])
        return max(abs(gap) / size for gap, size in zip(gaps, sizes, strict=True))

    kinds = (PointKind.BC, PointKind.FF)
    near = [point for point in points if point.kind in kinds and away(point) <= within]
    return min(near, key=lambda point: (point.order, away(point)), default=None)


def path_between(
    branches: Iterable[Branch], points: Iterable[SpecialPoint], first: Place, last: Place
) -> tuple[str, ...]:
    """A shortest way from one place to another: ids of branches and points in turn."""
    graph = nx.Graph()
    graph.add_nodes_from((branch.id, 0) for branch in branches)
    graph.add_nodes_from((point.id, 1) for point in points)
    graph.add_edges_from(((b.id, 0), (end, 1)) for b in branches for end in b.ends)
    if not nx.has_path(graph, first, last):
        return ()
    return tuple(name for name, _ in nx.shortest_path(graph, first, last))


def stable_intervals(branches: Iterable[Branch], order: int | None) -> Iterator[StableInterval]:
    """Intervals of the parameter in which fixed points attract, of one iterate or of all."""
    for branch in branches:
        if branch.kind is BranchKind.FIXED_POINT and order in (None, branch.order):
            for first, last in runs_of(stable_inside(branch)):
                p = branch.parameter[first : last + 1]
                yield StableInterval(branch, float(p.min()), float(p.max()))
