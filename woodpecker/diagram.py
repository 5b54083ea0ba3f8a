"""The branches that hang together with one periodic solution, as a :class:`pwmap.diagram.Diagram`.

Fixed-point branches are followed by :mod:`woodpecker.follow`, jump branches by
:mod:`woodpecker.jumps`; where one ends in a border collision the other begins. Branches are cut at
special points, so that each has one word, and each is one edge of the graph.
"""

from __future__ import annotations

import logging
import math
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pwmap.diagram import Branch, BranchKind, Diagram, PointKind, SpecialPoint
from woodpecker.edges import Edge, edges_between, is_continuous, nearest_edge
from woodpecker.follow import CLOSED, PathPoint, Settings, classify, follow_from, start_beside
from woodpecker.jumps import JumpPoint, follow_jump
from woodpecker.labelled import Cycle, LabelledMap, correct, iterate
from woodpecker.returns import RESTITUTIONS
from woodpecker.shooting import PeriodicOrbit, cycle_of, toy_map
from woodpecker.toy import Toy

SAME_POINT = 1e-7  # border collisions closer than this are one, reached from two branches
WINDOW = (-2.5, -0.24)  # left of the band of centres [rad]
MOST_BRANCHES = 2000
SMALLEST = 1e-9  # where a branch starts that would start at zero restitution
FASTEST = 100.0  # largest speed dx/dp of an edge that is expected next to a border collision
COLLISIONS = (PointKind.BC, PointKind.FF)
Progress = Callable[[float], None]


def continuation(
    toy: Toy,
    orbit: PeriodicOrbit,
    parameter: str = "eps_n1",
    span: tuple[float, float] = (0.0, 1.0),
    *,
    settings: Settings | None = None,
    progress: Progress | None = None,
) -> Diagram:
    """Follow a periodic solution both ways, and every branch that is connected to it.

    Parameters
    ----------
    toy
        The toy; its value of ``parameter`` is where the orbit lives.
    orbit
        A periodic solution of it, from :func:`woodpecker.shoot`.
    parameter, span
        Parameter of the toy and its interval.
    settings
        Steps, window and tolerances; the span is taken from ``span``. By default the window is
        (-2.5, -0.24) rad.
    progress
        Called with the parameter now and then.

    Returns
    -------
    Diagram
        Fixed-point and jump branches of P_order with their special points.

    Raises
    ------
    ValueError
        If the orbit did not converge or the span does not hold the toy's parameter.
    """
    if not orbit.success:
        raise ValueError(f"continuation needs a periodic solution, got one with: {orbit.message}")
    if orbit.toy != toy:
        raise ValueError("continuation needs an orbit of this toy, got one of another toy")
    chosen = settings if settings is not None else Settings(window=WINDOW)
    chosen = replace(chosen, span=(float(span[0]), float(span[1])))
    labelled_map = toy_map(toy, parameter)
    p = float(getattr(toy, parameter))
    if not span[0] <= p <= span[1]:
        raise ValueError(f"span must hold {parameter} = {p} of the toy, got {span}")
    start = cycle_of(orbit, labelled_map, p)
    if p == 0.0 and parameter in RESTITUTIONS:  # contacts that rest at zero bounce beyond it
        start, _, _ = correct(labelled_map, start.x, SMALLEST)
    return connected(
        labelled_map, start, chosen, parameter_name=parameter, x_name="phi_s", progress=progress
    )


def connected(
    labelled_map: LabelledMap,
    start: Cycle,
    settings: Settings,
    *,
    parameter_name: str = "p",
    x_name: str = "x",
    progress: Progress | None = None,
) -> Diagram:
    """All branches of a labelled map that are connected with the cycle ``start``."""
    explorer = _Explorer(labelled_map, len(start.x), settings, progress)
    explorer.explore(start)
    return Diagram(
        parameter_name=parameter_name,
        x_name=x_name,
        branches=tuple(explorer.branches),
        points=explorer.special_points(),
    )


@dataclass
class _Node:
    """A special point under construction."""

    id: str
    kind: PointKind
    p: float
    x: float
    note: str
    edge: Edge | None = None
    inner: int = 0
    has_fixed: bool = False
    has_jump: bool = False
    branches: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class _Sample:
    """One sample of either kind of branch."""

    p: float
    x: float
    multiplier: float
    word: str
    kind: PointKind | None
    note: str
    edge: Edge | None
    inner: int = 0  # at a border collision: side of the edge on which the fixed point lives


class _Explorer:
    """Breadth-first search over border collisions."""

    def __init__(
        self, labelled_map: LabelledMap, order: int, settings: Settings, progress: Progress | None
    ) -> None:
        self.map, self.order, self.settings = labelled_map, order, settings
        self.whole = iterate(labelled_map, order)
        self.progress = progress or (lambda _: None)
        self.nodes: list[_Node] = []
        self.branches: list[Branch] = []
        self.queue: deque[_Node] = deque()
        self.counts: dict[str, int] = {}

    def explore(self, start: Cycle) -> None:
        """Follow the branch through the start, then whatever hangs on its ends."""
        along = np.zeros(self.order + 1)
        along[-1] = 1.0
        ahead = self._fixed(follow_from(self.map, start, along, self.settings))
        if ahead[-1].note == CLOSED:  # an island: cut where it closes
            ahead[0] = ahead[-1] = replace(ahead[-1], p=ahead[0].p, x=ahead[0].x)
            behind = []
        else:
            behind = self._fixed(follow_from(self.map, start, -along, self.settings))
        self._add([*reversed(behind[1:]), *ahead], BranchKind.FIXED_POINT)
        while self.queue and len(self.branches) < MOST_BRANCHES:
            node = self.queue.popleft()
            if not node.has_jump:
                self._jump_from(node)
            if not node.has_fixed:
                self._fixed_from(node)
        if self.queue:
            logging.getLogger("woodpecker").warning(
                "stopped after %d branches: %d ends were not followed",
                MOST_BRANCHES,
                len(self.queue),
            )

    def special_points(self) -> tuple[SpecialPoint, ...]:
        """The finished special points."""
        return tuple(
            SpecialPoint(
                id=node.id, kind=node.kind, parameter=node.p, x=node.x,
                branches=tuple(dict.fromkeys(node.branches)), order=self.order, note=node.note,
            )
            for node in self.nodes
        )  # fmt: skip

    def _fixed(self, path: Iterable[PathPoint]) -> list[_Sample]:
        samples = []
        for point in path:
            self.progress(point.p)
            kind, note, edge, inner = point.kind, point.note, point.edge, -point.side
            x = float(point.cycle.x[0])
            if kind in COLLISIONS and self.order > 1:  # the jump of P_order next to the first point
                met = nearest_edge(self.whole, x, point.p, self.whole(x, point.p).word)
                if met is not None:
                    edge, inner = met[0], -met[1]
                    kind, note = classify(edge, inner, point.cycle.multiplier)
            samples.append(
                _Sample(
                    float(point.p), x, point.cycle.multiplier, point.cycle.word, kind, note, edge,
                    inner,
                )
            )  # fmt: skip
        return samples

    def _jumps(self, path: Iterable[JumpPoint]) -> list[_Sample]:
        samples = []
        for point in path:
            self.progress(point.p)
            edge, note, kind = point.edge, point.note, point.kind
            word = f"{edge.left.word} / {edge.right.word}"
            if kind is PointKind.BC:
                m = (edge.left if point.side < 0 else edge.right).slope
                kind, note = classify(edge, point.side, m)
            samples.append(_Sample(edge.p, edge.x, math.nan, word, kind, note, edge, point.side))
        return samples

    def _jump_from(self, node: _Node) -> None:
        """Follow the jump branch that starts at a border collision, if it crosses on one side."""
        node.has_jump = True
        assert node.edge is not None
        for direction in (1, -1):
            p = node.p + direction * self.settings.tolerances.landing
            if not self.settings.span[0] <= p <= self.settings.span[1]:
                continue
            reach = FASTEST * self.settings.tolerances.landing
            x = node.edge.x
            for edge in edges_between(self.whole, p, x - reach, x + reach):
                if not edge.crosses or is_continuous(edge, self.settings.tolerances):
                    continue
                path = self._jumps(follow_jump(self.whole, edge, self.settings, direction))
                word = f"{edge.left.word} / {edge.right.word}"
                first = _Sample(
                    node.p, x, math.nan, word, node.kind, node.note, node.edge, node.inner
                )
                self._add([first, *path], BranchKind.JUMP)
                return

    def _fixed_from(self, node: _Node) -> None:
        """Follow the fixed-point branch that starts at a border collision."""
        node.has_fixed = True
        assert node.edge is not None
        inner = node.inner
        point = start_beside(self.map, node.edge, inner, self.order, self.settings)
        if point is None:
            return
        path = self._fixed(follow_from(self.map, point.cycle, point.tangent, self.settings))
        first = _Sample(
            node.p, node.x, (node.edge.right if inner > 0 else node.edge.left).slope,
            path[0].word, node.kind, node.note, node.edge, inner,
        )  # fmt: skip
        self._add([first, *path], BranchKind.FIXED_POINT)

    def _add(self, samples: Sequence[_Sample], kind: BranchKind) -> None:
        """Cut a run of samples at its special points and keep the pieces as branches."""
        first, start = 0, self._node(samples[0], kind)
        for k in range(1, len(samples)):
            if samples[k].kind is not None:
                end = self._node(samples[k], kind)
                self._add_branch(samples[first : k + 1], kind, start, end)
                first, start = k, end

    def _add_branch(
        self, piece: Sequence[_Sample], kind: BranchKind, start: _Node, end: _Node
    ) -> None:
        inner = piece[1:-1] or piece[-1:]
        multipliers = [sample.multiplier for sample in piece]
        if piece[0].word != inner[0].word:  # the special point carries the slope before it
            multipliers[0] = inner[0].multiplier
        if piece[-1].word != inner[-1].word:
            multipliers[-1] = inner[-1].multiplier
        branch = Branch(
            id=self._name("F" if kind is BranchKind.FIXED_POINT else "J"),
            kind=kind,
            order=self.order,
            word=inner[0].word,
            parameter=np.array([sample.p for sample in piece]),
            x=np.array([sample.x for sample in piece]),
            multiplier=np.array(multipliers),
            ends=(start.id, end.id),
        )
        start.branches.append(branch.id)
        end.branches.append(branch.id)
        self.branches.append(branch)

    def _node(self, sample: _Sample, kind: BranchKind) -> _Node:
        """The special point of a sample; border collisions are found again."""
        assert sample.kind is not None
        x = sample.x if sample.edge is None else sample.edge.x
        for node in self.nodes:
            collide = sample.kind in COLLISIONS and node.kind in COLLISIONS
            closes = sample.note == node.note == CLOSED
            near = abs(node.p - sample.p) < SAME_POINT and abs(node.x - x) < SAME_POINT
            if near and (collide or closes):
                break
        else:
            node = _Node(
                self._name(sample.kind.value), sample.kind, sample.p, x, sample.note,
                sample.edge, sample.inner,
            )  # fmt: skip
            self.nodes.append(node)
            if sample.kind in COLLISIONS:
                self.queue.append(node)
        if kind is BranchKind.FIXED_POINT:
            node.has_fixed = True
        else:
            node.has_jump = True
        return node

    def _name(self, prefix: str) -> str:
        self.counts[prefix] = self.counts.get(prefix, 0) + 1
        return f"{prefix}{self.counts[prefix]}"
