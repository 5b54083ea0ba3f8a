"""Random maps that pwmap solves exactly, to compare a computed diagram with the proved one.

Slopes are numbers, offsets and breaks affine in p. So every branch is a straight line over p, and
one value between its ends distinguishes it from all others.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product
from random import Random

import numpy as np
from families import family

from pwmap import BranchKind, Diagram, PiecewiseLinearMap, PointKind, SpecialPoint
from pwmap import bifurcation_diagram as exact_diagram
from woodpecker.base.arrays import Floats

SPAN = (-1, 1)  # of p; breaks keep their order for twice that
FARTHEST = 20.0  # no branch of a case lies farther away
AGREES = 1e-9  # relative to 1 or a larger value: special points are located far better
SLOPES = sorted({Fraction(n, d) for d in (3, 4, 5, 7) for n in range(1 - 3 * d, 3 * d)})


# --- Random maps ----------------------------------------------------------------------------------


def random_map(rng: Random) -> PiecewiseLinearMap:
    """A map with one parameter p: two or three pieces; a third of them continuous.

    No cycle of up to four points has a multiplier of 1 or -1, for those would not be isolated.
    Offsets and breaks are (constant, rate): affine in p.
    """
    slopes = _slopes(rng, rng.choice([2, 2, 3]))
    breaks = [(_number(rng, 1), rng.choice([Fraction(0), _number(rng, 1)]))]
    for _ in slopes[2:]:
        gap, rate = Fraction(rng.randint(50, 150), 100), Fraction(rng.choice([0, 0, 1, -1]), 8)
        breaks.append((breaks[-1][0] + gap, breaks[-1][1] + rate))
    offsets = [(_number(rng, 2), rng.choice([Fraction(1), _number(rng, 2)]))]
    continuous = rng.random() < 1.0 / 3.0
    for at, left, right in zip(breaks, slopes[:-1], slopes[1:], strict=True):
        offsets.append(
            tuple(offset + (left - right) * b for offset, b in zip(offsets[-1], at, strict=True))
            if continuous
            else (_number(rng, 2), rng.choice([offsets[-1][1], _number(rng, 2)]))
        )
    owners = "".join(rng.choice("lr") for _ in breaks)
    formulas = [((slope,), offset) for slope, offset in zip(slopes, offsets, strict=True)]
    return family(breaks, owners, formulas, span=(-2, 2), orders=(), assumes=True).map()


def _number(rng: Random, size: int) -> Fraction:
    """A rational that is rarely special."""
    return Fraction(rng.randint(-100 * size, 100 * size), 100) + Fraction(rng.randint(1, 6), 700)


def _slopes(rng: Random, n: int) -> list[Fraction]:
    while True:
        found = [rng.choice(SLOPES) for _ in range(n)]
        multipliers = (math.prod(word) for k in range(1, 5) for word in product(found, repeat=k))
        if all(found) and not any(abs(multiplier) == 1 for multiplier in multipliers):
            return found


def random_case(rng: Random, orders: Sequence[int]) -> tuple[PiecewiseLinearMap, Diagram]:
    """A random map and its exact diagram over ``SPAN``.

    Something happens inside the span, and no branch goes far away.
    """
    while True:
        map_ = random_map(rng)
        diagram = exact_diagram(map_, "p", SPAN, orders=orders)
        far = max((np.abs(branch.x).max() for branch in diagram.branches), default=0.0)
        if far <= FARTHEST and any(point.kind is not PointKind.EP for point in diagram.points):
            return map_, diagram


# --- Graphs ---------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Edge:
    """A branch between two nodes, as a line of one or more straight parts.

    Attributes
    ----------
    name
        Ids of the branches it is made of.
    kind, order
        Those of the branches.
    ends
        Ids of the special points.
    p, x
        Samples; for exact branches the ends of the straight parts.
    stable
        Whether its first and last part attract.
    """

    name: str
    kind: BranchKind
    order: int
    ends: tuple[str, str]
    p: Floats
    x: Floats
    stable: tuple[bool, bool]

    def reversed(self) -> Edge:
        """The same from the other end."""
        return replace(
            self, ends=self.ends[::-1], p=self.p[::-1], x=self.x[::-1], stable=self.stable[::-1]
        )

    def joined(self, other: Edge) -> Edge:
        """Followed by one that starts where it ends."""
        return replace(
            self,
            name=f"{self.name}+{other.name}",
            ends=(self.ends[0], other.ends[1]),
            p=np.append(self.p, other.p[1:]),
            x=np.append(self.x, other.x[1:]),
            stable=(self.stable[0], other.stable[1]),
        )

    def distance(self, p: float, x: float) -> float:
        """Smallest distance in x from a point to the line between its samples; inf if none."""
        away = math.inf
        for a, b in zip(range(len(self.p) - 1), range(1, len(self.p)), strict=True):
            low, high = sorted((self.p[a], self.p[b]))
            if low <= p <= high:
                part = (p - self.p[a]) / (self.p[b] - self.p[a]) if low < high else 0.0
                away = min(away, abs(self.x[a] + part * (self.x[b] - self.x[a]) - x))
        return away

    @property
    def way(self) -> float:
        """How far the parameter goes along it, back and forth."""
        return float(np.abs(np.diff(self.p)).sum())

    def __str__(self) -> str:
        ends = " to ".join(f"(p={p:.9g}, x={x:.9g})" for p, x in zip(
            self.p[[0, -1]].tolist(), self.x[[0, -1]].tolist(), strict=True))  # fmt: skip
        return f"{self.kind} branch {self.name} of P_{self.order} from {ends}"


@dataclass(frozen=True, slots=True, eq=False)
class Graph:
    """Nodes by their id, and edges."""

    nodes: dict[str, SpecialPoint]
    edges: list[Edge]


def graph_of(diagram: Diagram) -> Graph:
    """All points and branches of a diagram."""
    edges = []
    for branch in diagram.branches:
        attracts = bool(branch.stable[len(branch) // 2])
        edge = Edge(
            branch.id, branch.kind, branch.order, branch.ends, branch.parameter, branch.x,
            (attracts, attracts),
        )  # fmt: skip
        edges.append(edge)
    return Graph({point.id: point for point in diagram.points}, edges)


def essential(exact: Diagram) -> Graph:
    """An exact diagram without the kinks at which nothing happens to fixed points.

    There just two branches of one order meet (BC, persistence) that both attract, or neither.
    """
    graph = graph_of(exact)
    for name, point in list(graph.nodes.items()):
        meeting = [edge for edge in graph.edges for end in edge.ends if end == name]
        if _passes(point, meeting):
            one, other = meeting
            one = one if one.ends[1] == name else one.reversed()
            other = other if other.ends[0] == name else other.reversed()
            rest = [edge for edge in graph.edges if edge not in meeting]
            graph = Graph(graph.nodes, [*rest, one.joined(other)])
        if not any(name in edge.ends for edge in graph.edges):
            del graph.nodes[name]
    return graph


def _passes(point: SpecialPoint, meeting: Sequence[Edge]) -> bool:
    """Whether two branches meet that are one but for their words."""
    if point.kind is not PointKind.BC or point.note != "persistence" or len(meeting) != 2:
        return False
    one, other = meeting
    fixed = one.kind is other.kind is BranchKind.FIXED_POINT and one.order == other.order
    same = _stable_at(one, point.id) == _stable_at(other, point.id)
    return fixed and same and one is not other


def _stable_at(edge: Edge, name: str) -> bool:
    return edge.stable[0] if edge.ends[0] == name else edge.stable[1]


# --- Comparison -----------------------------------------------------------------------------------


def same_graph(numeric: Diagram, exact: Diagram, tolerance: float = AGREES) -> list[str]:
    """What differs between a computed diagram and the essential part of the exact one.

    Special points are matched by their places and must be of one kind; branches by the points they
    end in, their kind, order and course. Nothing may be left over on either side.

    Returns
    -------
    Sentences; none if the graphs are the same.
    """
    proved, computed = essential(exact), graph_of(numeric)
    names, said = _matched_nodes(computed, proved, tolerance)
    return said + list(_unmatched_edges(computed.edges, proved.edges, names, tolerance))


def _matched_nodes(
    computed: Graph, proved: Graph, tolerance: float
) -> tuple[dict[str, str], list[str]]:
    """The proved node of each computed one, by id, and what does not match."""
    names: dict[str, str] = {}
    said = []
    free = dict(proved.nodes)
    for name, node in computed.nodes.items():
        near = min(free.values(), key=lambda other: _apart(node, other), default=None)
        if near is None or not _apart(node, near) <= tolerance:
            taken = [p for p in proved.nodes.values() if _apart(node, p) <= tolerance]
            why = "drawn twice" if taken else _missed_by(node, near)
            said.append(f"{_shown(node)} is computed only: {why}")
            continue
        del free[near.id]
        names[name] = near.id
        if node.kind is not near.kind:
            said.append(f"{_shown(node)} is computed where {_shown(near)} is proved")
    said += [f"{_shown(node)} is proved only" for node in free.values()]
    return names, said


def _missed_by(node: SpecialPoint, near: SpecialPoint | None) -> str:
    if near is None:
        return "no point is left"
    return f"the nearest is {_shown(near)}, {_apart(node, near):.1e} away"


def _apart(one: SpecialPoint, other: SpecialPoint) -> float:
    """Distance of two points, relative to 1 or their own size."""
    pairs = ((one.parameter, other.parameter), (one.x, other.x))
    return max(abs(a - b) / max(1.0, abs(b)) for a, b in pairs)


def _shown(node: SpecialPoint) -> str:
    note = f" ({node.note})" if node.note else ""
    return f"{node.kind} {node.id}{note} at p={node.parameter:.12g}, x={node.x:.12g}"


def _unmatched_edges(
    computed: Sequence[Edge], proved: Sequence[Edge], names: dict[str, str], tolerance: float
) -> Iterator[str]:
    free = list(proved)
    for edge in computed:
        ends = tuple(names.get(end, "") for end in edge.ends)
        found = next((other for other in free if _same(edge, ends, other, tolerance)), None)
        if found is not None:
            free.remove(found)
            continue
        again = any(_same(edge, ends, other, tolerance) for other in proved)
        yield f"{edge} is computed only{': drawn twice' if again else ''}"
    yield from (f"{edge} is proved only" for edge in free)


def _same(edge: Edge, ends: tuple[str, ...], other: Edge, tolerance: float) -> bool:
    """Whether a computed edge, whose ends are nodes of the proved graph, is a proved one."""
    if (edge.kind, edge.order) != (other.kind, other.order):
        return False
    if sorted(ends) != sorted(other.ends) or abs(edge.way - other.way) > tolerance * len(edge.p):
        return False
    middles = (0.5 * (values[1:] + values[:-1]) for values in (other.p, other.x))
    return all(
        edge.distance(p, x) <= tolerance * max(1.0, abs(x))
        for p, x in zip(*(values.tolist() for values in middles), strict=True)
    )
