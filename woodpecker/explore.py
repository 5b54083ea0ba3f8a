"""Exploring: follow branches, and whatever hangs on their ends, over one or more iterates.

Fixed-point branches are followed by :mod:`woodpecker.follow`, jump branches by
:mod:`woodpecker.jumps`; where one ends in a border collision the other begins. Branches are cut at
special points, so that each has one word, and each is one edge of the graph. Points at one place
are one, whichever iterate they were reached in.
"""

from __future__ import annotations

import logging
import math
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pwmap.diagram import Branch, BranchKind, PointKind, SpecialPoint
from woodpecker.edges import Edge, edges_between, is_continuous, nearest_edge
from woodpecker.follow import CLOSED, PathPoint, Settings, classify, follow_from, start_beside
from woodpecker.jumps import JUMP_ENDS, JumpPoint, follow_jump
from woodpecker.labelled import Cycle, LabelledMap, iterate

SAME_POINT = 1e-7  # border collisions closer than this are one, reached from two branches
SAME_CYCLE = 1e-9  # points of a cycle closer than this are one: its minimal period is shorter
SAME_FLIP = 1e-3  # in x: near a flip the branch of twice the period leaves like a square root
SAME_CHANGE = 1e-9  # changes of word, folds and flips closer than this are one, met twice
ON_BRANCH = 0.05  # of a chord: how far a smooth branch strays from it, at most
MOST_BRANCHES = 20000
FASTEST = 100.0  # largest speed dx/dp of an edge that is expected next to a border collision
COLLISIONS = (PointKind.BC, PointKind.FF)
PASSED = (PointKind.WC, PointKind.LP, PointKind.PD)  # by branches of fixed points
Progress = Callable[[float], None]


@dataclass
class _Node:
    """A special point under construction."""

    id: str
    kind: PointKind
    p: float
    x: float
    note: str
    order: int
    branches: list[str] = field(default_factory=list)


@dataclass
class _Collision:
    """A border collision in one iterate, and what of it was followed."""

    node: _Node
    order: int
    edge: Edge
    inner: int
    followed: set[BranchKind] = field(default_factory=set)


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


class Explorer:
    """Breadth-first search over border collisions.

    Parameters
    ----------
    labelled_map
        The map; iterates of it are made as they are needed.
    settings
        Span, window, steps and tolerances.
    progress
        Called with the parameter now and then.
    orders
        Iterates that are explored: a cycle of P_j that is one of a lower order among these is not
        followed again.
    """

    def __init__(
        self,
        labelled_map: LabelledMap,
        settings: Settings,
        progress: Progress | None = None,
        orders: Sequence[int] = (),
    ) -> None:
        self.map, self.settings, self.orders = labelled_map, settings, orders
        self.progress = progress or (lambda _: None)
        self.nodes: list[_Node] = []
        self.branches: list[Branch] = []
        self._collisions: list[_Collision] = []
        self._queue: deque[_Collision] = deque()
        self._iterates: dict[int, LabelledMap] = {}
        self._counts: dict[str, int] = {}

    def iterate(self, order: int) -> LabelledMap:
        """P_order."""
        if order not in self._iterates:
            self._iterates[order] = iterate(self.map, order)
        return self._iterates[order]

    def explore_cycle(self, start: Cycle) -> None:
        """Follow the branch through a cycle both ways, then whatever hangs on its ends."""
        order = len(start.x)
        along = np.zeros(order + 1)
        along[-1] = 1.0
        ahead = self._fixed(follow_from(self.map, start, along, self.settings), order)
        if ahead[-1].note == CLOSED:  # an island: cut where it closes
            ahead[0] = ahead[-1] = replace(ahead[-1], p=ahead[0].p, x=ahead[0].x)
            behind = []
        else:
            behind = self._fixed(follow_from(self.map, start, -along, self.settings), order)
        self._add([*reversed(behind[1:]), *ahead], BranchKind.FIXED_POINT, order)
        self._go_on()

    def explore_jump(self, edge: Edge, order: int) -> None:
        """Follow a jump of P_order that crosses the diagonal both ways, then what hangs on it."""
        whole = self.iterate(order)
        ahead, behind = (
            self._jumps(follow_jump(whole, edge, self.settings, direction)) for direction in (1, -1)
        )
        word = f"{edge.left.word} / {edge.right.word}"
        first = _Sample(edge.p, edge.x, math.nan, word, None, "", edge)
        self._add([*reversed(behind), first, *ahead], BranchKind.JUMP, order)
        self._go_on()

    def is_known(self, cycle: Cycle) -> bool:
        """Whether a cycle goes round one of a lower order that is explored as well."""
        period = minimal_period(cycle)
        return period < len(cycle.x) and period in self.orders

    def special_points(self) -> tuple[SpecialPoint, ...]:
        """The finished special points."""
        return tuple(
            SpecialPoint(
                id=node.id, kind=node.kind, parameter=node.p, x=node.x,
                branches=tuple(dict.fromkeys(node.branches)), order=node.order, note=node.note,
            )
            for node in self.nodes
        )  # fmt: skip

    def _go_on(self) -> None:
        """Follow what hangs on the border collisions that were met."""
        while self._queue and len(self.branches) < MOST_BRANCHES:
            collision = self._queue.popleft()
            if BranchKind.JUMP not in collision.followed:
                self._jump_from(collision)
            if BranchKind.FIXED_POINT not in collision.followed:
                self._fixed_from(collision)
        if self._queue:
            logging.getLogger("woodpecker").warning(
                "stopped after %d branches: %d ends were not followed",
                MOST_BRANCHES,
                len(self._queue),
            )

    def _fixed(self, path: Iterable[PathPoint], order: int) -> list[_Sample]:
        samples = []
        for point in path:
            self.progress(point.p)
            kind, note, edge, inner = point.kind, point.note, point.edge, -point.side
            x = float(point.cycle.x[0])
            if kind in COLLISIONS and order > 1:  # the jump of P_order next to the first point
                whole = self.iterate(order)
                met = nearest_edge(whole, x, point.p, whole(x, point.p).word)
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

    def _jump_from(self, collision: _Collision) -> None:
        """Follow the jump branch that starts at a border collision, if it crosses on one side."""
        collision.followed.add(BranchKind.JUMP)
        whole, node, x = self.iterate(collision.order), collision.node, collision.edge.x
        for direction in (1, -1):
            p = node.p + direction * self.settings.tolerances.landing
            if not self.settings.span[0] <= p <= self.settings.span[1]:
                continue
            reach = FASTEST * self.settings.tolerances.landing
            for edge in edges_between(whole, p, x - reach, x + reach):
                if not edge.crosses or is_continuous(edge, self.settings.tolerances):
                    continue
                path = self._jumps(follow_jump(whole, edge, self.settings, direction))
                word = f"{edge.left.word} / {edge.right.word}"
                first = _Sample(
                    node.p, x, math.nan, word, node.kind, node.note, collision.edge, collision.inner
                )
                self._add([first, *path], BranchKind.JUMP, collision.order)
                return

    def _fixed_from(self, collision: _Collision) -> None:
        """Follow the fixed-point branch that starts at a border collision."""
        collision.followed.add(BranchKind.FIXED_POINT)
        node, inner, order = collision.node, collision.inner, collision.order
        point = start_beside(self.map, collision.edge, inner, order, self.settings)
        if point is None or self.is_known(point.cycle):
            return
        path = self._fixed(follow_from(self.map, point.cycle, point.tangent, self.settings), order)
        side = collision.edge.right if inner > 0 else collision.edge.left
        first = _Sample(
            node.p, node.x, side.slope, path[0].word, node.kind, node.note, collision.edge, inner
        )
        self._add([first, *path], BranchKind.FIXED_POINT, order)

    def _add(self, samples: Sequence[_Sample], kind: BranchKind, order: int) -> None:
        """Cut a run of samples at its special points and keep the pieces as branches."""
        first, start = 0, self._node(samples[0], kind, order)
        for k in range(1, len(samples)):
            if samples[k].kind is not None:
                end = self._node(samples[k], kind, order)
                self._add_branch(samples[first : k + 1], kind, order, start, end)
                first, start = k, end

    def _add_branch(
        self, piece: Sequence[_Sample], kind: BranchKind, order: int, start: _Node, end: _Node
    ) -> None:
        p, x = np.array([sample.p for sample in piece]), np.array([sample.x for sample in piece])
        if start is end and max(np.ptp(p), np.ptp(x)) < SAME_POINT:
            return  # it was met on its very end
        middle = piece[len(piece) // 2]
        if any(
            (b.kind, b.order, b.word) == (kind, order, (piece[1:-1] or piece[-1:])[0].word)
            and set(b.ends) == {start.id, end.id}
            and passes(b, middle.p, middle.x)
            for b in self.branches
        ):
            return  # a path came along a known branch
        inner = piece[1:-1] or piece[-1:]
        multipliers = [sample.multiplier for sample in piece]
        if piece[0].word != inner[0].word:  # the special point carries the slope before it
            multipliers[0] = inner[0].multiplier
        if piece[-1].word != inner[-1].word:
            multipliers[-1] = inner[-1].multiplier
        branch = Branch(
            id=self._name("F" if kind is BranchKind.FIXED_POINT else "J"),
            kind=kind,
            order=order,
            word=inner[0].word,
            parameter=p,
            x=x,
            multiplier=np.array(multipliers),
            ends=(start.id, end.id),
        )
        start.branches.append(branch.id)
        end.branches.append(branch.id)
        self.branches.append(branch)

    def _node(self, sample: _Sample, kind: BranchKind, order: int) -> _Node:
        """The special point of a sample; one that was met before is found again."""
        if sample.note == JUMP_ENDS:
            sample = replace(sample, kind=PointKind.WC)
        assert sample.kind is not None
        x = sample.x if sample.edge is None else sample.edge.x
        node = next((node for node in self.nodes if _is_same(node, sample, x, order)), None)
        if node is None:
            node = _Node(
                self._name(sample.kind.value), sample.kind, sample.p, x, sample.note, order
            )
            self.nodes.append(node)
        elif order < node.order or (node.kind is PointKind.WC and sample.kind in COLLISIONS):
            node.kind, node.note, node.order = sample.kind, sample.note, order
        if sample.kind in COLLISIONS and sample.edge is not None:
            self._collision(node, sample, order).followed.add(kind)
        return node

    def _collision(self, node: _Node, sample: _Sample, order: int) -> _Collision:
        for collision in self._collisions:
            if collision.node is node and collision.order == order:
                return collision
        assert sample.edge is not None
        collision = _Collision(node, order, sample.edge, sample.inner)
        self._collisions.append(collision)
        self._queue.append(collision)
        return collision

    def _name(self, prefix: str) -> str:
        self._counts[prefix] = self._counts.get(prefix, 0) + 1
        return f"{prefix}{self._counts[prefix]}"


def passes(branch: Branch, p: float, x: float) -> bool:
    """Whether a branch passes through (p, x), as far as its samples tell."""
    p0, p1 = branch.parameter[:-1], branch.parameter[1:]
    x0, x1 = branch.x[:-1], branch.x[1:]
    run = np.where(p1 == p0, 1.0, p1 - p0)
    along = np.clip((p - p0) / run, 0.0, 1.0)
    off = np.hypot(p0 + along * (p1 - p0) - p, x0 + along * (x1 - x0) - x)
    return bool((off <= ON_BRANCH * np.hypot(p1 - p0, x1 - x0) + SAME_POINT).any())


def minimal_period(cycle: Cycle) -> int:
    """The smallest shift that maps a cycle to itself."""
    n = len(cycle.x)
    divisors = (d for d in range(1, n + 1) if n % d == 0)
    return next(d for d in divisors if np.abs(np.roll(cycle.x, -d) - cycle.x).max() < SAME_CYCLE)


def _is_same(node: _Node, sample: _Sample, x: float, order: int) -> bool:
    """Whether a sample lies at a special point that is known already."""
    if abs(node.p - sample.p) >= SAME_POINT:
        return False
    if (
        sample.kind is node.kind in PASSED
        and order == node.order
        and not math.isnan(sample.multiplier)
    ):
        return math.hypot(node.p - sample.p, node.x - x) < SAME_CHANGE
    both = (sample.kind, node.kind)
    if PointKind.PD in both and PointKind.LP in both and order != node.order:
        return abs(node.x - x) < SAME_FLIP  # a cycle of twice the period turns round at a flip
    jumps_end = sample.note == JUMP_ENDS and (node.note == JUMP_ENDS or node.kind in COLLISIONS)
    collide = sample.kind in COLLISIONS and (node.kind in COLLISIONS or node.note == JUMP_ENDS)
    closes = sample.note == node.note == CLOSED or sample.kind is node.kind is PointKind.FALL
    return abs(node.x - x) < SAME_POINT and (collide or closes or jumps_end)
