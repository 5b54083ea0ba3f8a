"""What a search has found: branches cut at special points, and where they hang together.

Paths come in as runs of samples. They are cut at special points, so that each branch has one word
and is one edge of the graph. Points at one place are one, whichever iterate they were reached in;
a path that comes along a known branch adds nothing. At a border collision something is left to
follow; these collisions wait in line.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from pwmap.diagrams.diagram import Branch, BranchKind, Diagram, PointKind, SpecialPoint
from woodpecker.piecewise.borders import Edge
from woodpecker.piecewise.jumps import JUMP_ENDS
from woodpecker.piecewise.stepping import CLOSED, DIVIDES

SAME_POINT = 1e-7  # border collisions closer than this are one, reached from two branches
SAME_FLIP = 1e-3  # in x: near a flip the branch of twice the period leaves like a square root
SAME_CHANGE = 1e-6  # in p and x: changes between the same words, folds and flips closer are one
TWICE = 1e-9  # the same along one path, which may change its word and change it back
ON_BRANCH = 0.15  # of a chord: how far a smooth branch strays from it, at most
COLLISIONS = (PointKind.BC, PointKind.FF)
PASSED = (PointKind.WC, PointKind.LP, PointKind.PD)  # by branches of fixed points


@dataclass(eq=False)
class Node:
    """A special point under construction."""

    id: str
    kind: PointKind
    p: float
    x: float
    note: str
    order: int
    words: frozenset[str]  # on its sides, along the path that met it
    branches: list[str] = field(default_factory=list)


@dataclass(eq=False)
class Collision:
    """A border collision in one iterate, and what of it was followed."""

    node: Node
    departure: Departure
    followed: set[BranchKind] = field(default_factory=set)


class Departure(NamedTuple):
    """Where branches start at a border collision: the edge of P_order, and the place of its node.

    The fixed point lives at side ``inner`` of the edge.
    """

    p: float
    x: float
    order: int
    edge: Edge
    inner: int


@dataclass(frozen=True, slots=True)
class Sample:
    """One sample of either kind of branch.

    At a border collision ``inner`` is the side of the edge on which the fixed point lives.
    """

    p: float
    x: float
    multiplier: float
    word: str
    kind: PointKind | None
    note: str
    edge: Edge | None
    inner: int = 0


class Atlas:
    """Branches, special points, and border collisions at which something is left to follow."""

    def __init__(self) -> None:
        self.branches: list[Branch] = []
        self.nodes: list[Node] = []
        self.waiting: deque[Collision] = deque()
        self._collisions: dict[tuple[str, int], Collision] = {}
        self._near: dict[int, list[Node]] = {}  # nodes by their parameter, in steps of SAME_CHANGE
        self._named: dict[str, Branch] = {}
        self._counts: dict[str, int] = {}
        self._fresh: list[Node] = []  # made by the run that is being added

    def diagram(self, parameter_name: str, x_name: str) -> Diagram:
        """Everything found so far."""
        points = tuple(
            SpecialPoint(
                id=node.id, kind=node.kind, parameter=node.p, x=node.x,
                branches=tuple(dict.fromkeys(node.branches)), order=node.order, note=node.note,
            )
            for node in self.nodes
        )  # fmt: skip
        return Diagram(
            parameter_name=parameter_name,
            x_name=x_name,
            branches=tuple(self.branches),
            points=points,
        )

    def finish(self, node: str, order: int) -> None:
        """Nothing is left to follow at a collision."""
        self.waiting.remove(self._collisions[node, order])

    def add(self, samples: Sequence[Sample], kind: BranchKind, order: int) -> None:
        """Cut a run of samples at its special points and keep the pieces as branches."""
        samples = list(_calmed(samples))
        self._fresh = []
        first, start = 0, self._node(samples, 0, kind, order)
        for k in range(1, len(samples)):
            if samples[k].kind is not None:
                end = self._node(samples, k, kind, order)
                self._add_branch(samples[first : k + 1], kind, order, start, end)
                first, start = k, end

    def _add_branch(
        self, piece: Sequence[Sample], kind: BranchKind, order: int, start: Node, end: Node
    ) -> None:
        p, x = np.array([sample.p for sample in piece]), np.array([sample.x for sample in piece])
        if start is end and max(np.ptp(p), np.ptp(x)) < SAME_CHANGE:
            return  # it was met on its very end, or is too short to be told from a change of word
        inner = piece[1:-1] or piece[-1:]
        if any(
            (b.kind, b.order, b.word) == (kind, order, inner[0].word)
            and set(b.ends) == {start.id, end.id}
            and sum(passes(b, sample.p, sample.x) for sample in inner) >= 0.5 * len(inner)
            for b in map(self._named.__getitem__, start.branches)
        ):
            return  # a path came along a known branch
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
        self._named[branch.id] = branch

    def _node(self, samples: Sequence[Sample], k: int, kind: BranchKind, order: int) -> Node:
        """The special point of a sample; one that was met before is found again."""
        sample = samples[k]
        words = frozenset(each.word for each in samples[max(0, k - 1) : k + 2])
        if sample.note == JUMP_ENDS:
            sample = replace(sample, kind=PointKind.WC)
        assert sample.kind is not None
        x = sample.x if sample.edge is None else sample.edge.x
        same = [n for n in self._beside(sample.p) if self._is_same(n, sample, x, order, words)]
        node = min(
            same, default=None,
            key=lambda n: (n.words != words, math.hypot(n.p - sample.p, n.x - x)),
        )  # fmt: skip
        if node is None:
            node = Node(
                self._name(sample.kind.value), sample.kind, sample.p, x, sample.note, order, words
            )
            self.nodes.append(node)
            self._fresh.append(node)
            self._near.setdefault(math.floor(node.p / SAME_CHANGE), []).append(node)
        elif order < node.order or (node.kind is PointKind.WC and sample.kind in COLLISIONS):
            node.kind, node.note, node.order = sample.kind, sample.note, order
        elif node.note == JUMP_ENDS:
            node.note = sample.note  # from the other side it goes on
        if sample.kind in COLLISIONS and sample.edge is not None:
            self._collision(node, sample, order).followed.add(kind)
        return node

    def _collision(self, node: Node, sample: Sample, order: int) -> Collision:
        key = node.id, order
        if key not in self._collisions:
            assert sample.edge is not None
            self._collisions[key] = Collision(
                node, Departure(node.p, node.x, order, sample.edge, sample.inner)
            )
            self.waiting.append(self._collisions[key])
        return self._collisions[key]

    def _is_same(
        self, node: Node, sample: Sample, x: float, order: int, words: frozenset[str]
    ) -> bool:
        """Whether a sample lies at a special point that is known already."""
        if sample.kind is node.kind in PASSED and not (sample.note == node.note == JUMP_ENDS):
            off = max(abs(node.p - sample.p), abs(node.x - x))
            near = order == node.order and off < SAME_CHANGE
            if node in self._fresh:  # one path makes two changes where it makes two
                near &= math.hypot(node.p - sample.p, node.x - x) < TWICE
                return near and words == node.words
            # Thin pieces next to a change can hide the words beyond it from one of two paths.
            return near and bool(words & node.words)
        if abs(node.p - sample.p) >= SAME_POINT:
            return False
        if DIVIDES in (sample.note, node.note):  # branches of a period and of a multiple of it meet
            return abs(node.x - x) < SAME_POINT
        both = (sample.kind, node.kind)
        if PointKind.PD in both and PointKind.LP in both and order != node.order:
            return abs(node.x - x) < SAME_FLIP  # a cycle of twice the period turns round at a flip
        jumps_end = sample.note == JUMP_ENDS and (node.note == JUMP_ENDS or node.kind in COLLISIONS)
        collide = sample.kind in COLLISIONS and (node.kind in COLLISIONS or node.note == JUMP_ENDS)
        closes = sample.note == node.note == CLOSED or sample.kind is node.kind is PointKind.FALL
        if sample.kind is node.kind is PointKind.EP and order == node.order:  # one end, met twice
            return sample.note == node.note and abs(node.x - x) < SAME_POINT
        return abs(node.x - x) < SAME_POINT and (collide or closes or jumps_end)

    def _beside(self, p: float) -> Iterator[Node]:
        """Nodes whose parameter may be the same."""
        cell = math.floor(p / SAME_CHANGE)
        for neighbour in (cell - 1, cell, cell + 1):
            yield from self._near.get(neighbour, ())

    def _name(self, prefix: str) -> str:
        self._counts[prefix] = self._counts.get(prefix, 0) + 1
        return f"{prefix}{self._counts[prefix]}"


def _calmed(samples: Sequence[Sample]) -> Iterator[Sample]:
    """A run without pairs of changes, to a word and right back, that rounding makes."""
    marks = [k for k, sample in enumerate(samples) if sample.kind is PointKind.WC]
    skipped: set[int] = set()
    for a, b in pairwise(marks):
        near = math.hypot(samples[a].p - samples[b].p, samples[a].x - samples[b].x) < TWICE
        inner = a > 0 and b < len(samples) - 1 and a not in skipped
        if near and inner and samples[a - 1].word == samples[b + 1].word:
            skipped.update(range(a, b + 1))
    yield from (sample for k, sample in enumerate(samples) if k not in skipped)


def passes(branch: Branch, p: float, x: float) -> bool:
    """Whether a branch passes through (p, x), as far as its samples tell."""
    p0, p1 = branch.parameter[:-1], branch.parameter[1:]
    x0, x1 = branch.x[:-1], branch.x[1:]
    run = np.where(p1 == p0, 1.0, p1 - p0)
    along = np.clip((p - p0) / run, 0.0, 1.0)
    off = np.hypot(p0 + along * (p1 - p0) - p, x0 + along * (x1 - x0) - x)
    return bool((off <= ON_BRANCH * np.hypot(p1 - p0, x1 - x0) + SAME_POINT).any())
