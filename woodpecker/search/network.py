"""The network of a search: branches, the special points they end in, and what is left to follow."""

from __future__ import annotations

import math
from collections import Counter, defaultdict, deque
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from pwmap.diagrams.diagram import (
    Branch,
    BranchKind,
    Diagram,
    PointKind,
    PointStatus,
    SpecialPoint,
)
from pwmap.diagrams.record import plain, program
from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.settings import Settings, differing
from woodpecker.engine.newton import Problem
from woodpecker.engine.orbits import SpaceOrbit
from woodpecker.search.accumulations import ENDLESS, LINKED, limit_of
from woodpecker.search.curves import (
    BranchCurve,
    Collision,
    End,
    agree,
    from_point,
    stretches,
    words_between,
)
from woodpecker.search.nearby import Nearby
from woodpecker.slices.orbits import problem_of

SAME_NODE = 1e-7  # scaled: the same end of two branches that are one differs by no more
LETTERS = {BranchKind.FIXED_POINT: "F", BranchKind.JUMP: "J"}  # first letter of a branch's id
TINY = 1e-300  # least squared length of a chord, for a quotient 0/0 to be 0
# In x, a fraction of the window: a flip and the fold of the doubled cycle are one point if they are
# this close, and their parameters as close as its square. Ten times ``ONE_POINT``, below which
# points of a cycle are one.
AT_FLIP = 1e-4
# Fraction of the extent of a branch by which its ends may differ from those of a duplicate, if that
# is less than SAME_NODE: short branches that follow each other are not one.
SHORT_BRANCH = 0.01
# Places at which two branches with the same ends are compared: at some of them one may have passed
# over a thin piece that the other has.
COMPARISONS = 7
# Scaled: chords shorter than this may turn by a larger angle, inversely to their length. The curve
# drawn is as good, and half as many samples tell what lies between them.
SHARP_FOLD = 1e-6
COLLISIONS = (PointKind.BC, PointKind.FF)
SWITCHES = (PointKind.PD, PointKind.BP)


@dataclass(eq=False)
class Node:
    """A special point under construction; ``flips`` if a flip lies there, whatever it is called."""

    id: str
    end: End
    x: Floats  # (d,)
    order: int
    flips: bool

    def take(self, end: End, x: Floats, order: int) -> None:
        """Take in another end at the same point, which names the point if it says more."""
        # A collision says more than any other kind, a branch point more than the end of the span; a
        # cycle more than the same cycle run through twice, which sees the flip as a fold; a fold
        # more than a flip at the same place.
        self.flips = self.flips or end.kind is PointKind.PD
        collides = end.kind in COLLISIONS and self.end.kind not in COLLISIONS
        branches = (end.kind, self.end.kind) == (PointKind.BP, PointKind.EP)
        folds = order == self.order and (end.kind, self.end.kind) == (PointKind.LP, PointKind.PD)
        if order < self.order or collides or branches or folds:
            self.end, self.x, self.order = end, x, min(order, self.order)

    def as_point(self) -> SpecialPoint:
        """The special point of a diagram, without the branches that end there."""
        end = self.end
        return SpecialPoint(
            id=self.id, kind=end.kind, parameter=end.p, x=float(self.x[0]), order=self.order,
            note=end.note, cause=end.cause, precision=end.precision, status=end.status,
        )  # fmt: skip


class _Drawn(NamedTuple):
    """A branch of a diagram: the curve of one point of its cycle."""

    curve: BranchCurve
    column: int  # the number of the point
    ends: tuple[str, str]  # ids of nodes


class Network:
    """Branches and special points found so far, and the queues of points left to follow.

    Units are those of the ``problem`` of cycles, by default that of a map of the line.
    """

    def __init__(self, settings: Settings, problem: Problem | None = None) -> None:
        problem = problem or problem_of(settings)
        self.settings, self.x_scale = settings, np.array(problem.x_scale)
        self.p_scale = problem.p_scale[problem.free[0]]
        self._units = np.array([self.p_scale, *self.x_scale])
        self.curves: list[BranchCurve] = []
        self.samples = 0  # of all curves together
        self.drawn: list[_Drawn] = []
        self.nodes: list[Node] = []
        self.waiting: deque[End] = deque()  # border collisions left to follow
        self.switches: deque[End] = deque()  # flips and branch points left to follow
        widest = 2.0 * max(settings.same, SAME_NODE, AT_FLIP**2) * self.p_scale
        self._by_low_end = Nearby[BranchCurve](widest)
        self._ends = Nearby[tuple[End, int]](widest)
        self._reached = Nearby[tuple[End, End]](widest)
        self._places = Nearby[Node](widest)
        self._collisions = Nearby[Collision](widest)
        self._switches = Nearby[End](widest)

    def diagram(self, parameter_name: str, x_names: Sequence[str]) -> Diagram:
        """The diagram of everything found so far, without branches that are parts of others.

        The x of a branch is its first coordinate; others that have names are its columns.
        """
        drawn, nodes = self._shown()
        made = {"span": self.settings.span, "settings": differing(self.settings, Settings())}
        return _diagram_of(
            [_branch(each, x_names) for each in drawn], [node.as_point() for node in nodes],
            parameter_name=parameter_name, x_name=x_names[0],
            about={"program": program(), **plain(made)},
        )  # fmt: skip

    def dead_ends(self) -> list[float]:
        """Parameters of collisions and open ends at which a single branch ends."""
        count = Counter(end for each in self.drawn for end in each.ends)
        return [
            node.end.p
            for node in self.nodes
            if count[node.id] == 1
            and (node.end.kind in COLLISIONS or node.end.status is PointStatus.OPEN)
        ]

    def cycles(self) -> list[SpaceOrbit | None]:
        """The orbit at each special point of the diagram; None at one that an earlier run found."""
        return [node.end.cycle for node in self._shown()[1]]

    def _shown(self) -> tuple[list[_Drawn], list[Node]]:
        """The branches and nodes of the diagram."""
        parts = self._passed_along()
        parts |= {id(curve) for curve in self.curves if self._is_superseded(curve)}
        drawn = [each for each in self.drawn if id(each.curve) not in parts]
        ends = {end for each in drawn for end in each.ends}
        return drawn, [node for node in self.nodes if node.id in ends]

    def has(self, curve: BranchCurve, points: Sequence[BranchCurve] = ()) -> bool:
        """Whether a branch is one that is stored, or one of ``points``, or of a smaller period."""
        return (
            self._has_smaller_period(curve)
            or any(
                self._is_duplicate_of(known, curve)
                for known in self._by_low_end.near(_low_end(curve))
            )
            or any(self._joins_the_same(known, curve) for known in points)
        )

    @staticmethod
    def is_outside(curve: BranchCurve) -> bool:
        """Whether a branch leaves the span or the window where it begins: none of it is inside."""
        return len(curve.parameter) == 1 and curve.ends[1].status is PointStatus.LOCATED

    def is_a_point(self, curve: BranchCurve) -> bool:
        """Whether a branch is so short that its ends are one special point, and none is open."""
        if any(end.collision is not None or end.status is PointStatus.OPEN for end in curve.ends):
            return False
        same = self.settings.same
        return bool(
            np.ptp(curve.parameter) <= same * self.p_scale
            and (np.ptp(curve.x, axis=0) <= same * self.x_scale).all()
        )

    def add(self, curve: BranchCurve) -> None:
        """Store a branch, draw it for each point of its cycle, and queue its new special points."""
        # A branch that is a point only joins its ends. An endless chain of fold-flip points is cut
        # off at its limit; such chains are known of P_1 only.
        if self.is_a_point(curve):
            self._pass_over(curve)
            return
        limit = limit_of(self._chain(curve), self._units) if curve.order == 1 else None
        curve = curve if limit is None else replace(curve, ends=(curve.ends[0], limit))
        self.curves.append(curve)
        self.samples += len(curve.parameter)
        self._by_low_end.add(_low_end(curve), curve)
        self._reached.add(curve.ends[1].p, curve.ends)
        for end in curve.ends:
            self._ends.add(end.p, (end, curve.order))
            if end.collision is not None and not self._is_known(end.collision):
                self._collisions.add(end.collision.p, end.collision)
                self.waiting.append(end)
            known = self._switches.near(end.p)
            if end.kind in SWITCHES and not any(self._is_at(k, end) for k in known):
                self._switches.add(end.p, end)
                self.switches.append(end)
        for column in range(curve.x.shape[1]):
            first, last = curve.x[[0, -1], column]
            last = last if limit is None else limit.x[0]
            one, other = (
                self._node(end.at(place), _place_at(end, place), curve.order)
                for end, place in zip(curve.ends, (first, last), strict=True)
            )
            self.drawn.append(_Drawn(curve, column, (one.id, other.id)))

    def _passed_along(self) -> set[int]:
        """The ids of branches along all of which a longer one passes."""
        # A branch is given up, or ends at a border, where another may pass over borders that
        # accumulate. If further branches start at such an end, the part stays.
        nodes = defaultdict[int, set[str]](set)
        for each in self.drawn:
            nodes[id(each.curve)].update(each.ends)
        places = [self._places_of(each.curve, each.column) for each in self.drawn]
        boxes = np.array([self._box(each) for each in places])
        inner = dict[int, set[str]]()  # the nodes of a part that lie inside of the longer branch
        for curve in self.curves:
            for k in self._around(boxes, curve):
                if self._passes_along(self.drawn[k], places[k], curve):
                    inner[id(curve)] = nodes[id(curve)] - nodes[id(self.drawn[k].curve)]
                    break
        while True:  # it ends, as each pass finds fewer parts
            kept = {end for key, ends in nodes.items() if key not in inner for end in ends}
            parts = {key: ends for key, ends in inner.items() if not ends & kept}
            if len(parts) == len(inner):
                return set(parts)
            inner = parts

    def _is_superseded(self, curve: BranchCurve) -> bool:
        """Whether a branch was given up at one end, and another from its other end goes farther."""
        # At an end of the span or the window, and at a cycle on a border, there is only one curve
        # with these pieces; at folds, flips and branch points there are two.
        opens = [end.status is PointStatus.OPEN for end in curve.ends]
        if not any(opens) or all(opens):
            return False
        first = opens.index(False)
        end, keys = curve.ends[first], curve.words[-first].keys  # of the first word, or the last
        if end.kind not in (PointKind.EP, *COLLISIONS):
            return False
        return any(
            other is not curve
            and (other.kind, other.order) == (curve.kind, curve.order)
            and other.ends[k].status is PointStatus.LOCATED
            and self._is_same_orbit(end, other.ends[k], SAME_NODE)
            and agree(keys, other.words[-k].keys)
            and (
                other.ends[1 - k].status is PointStatus.LOCATED
                or self._length(other) > self._length(curve)
            )
            for other in self.curves
            for k in (0, 1)
        )

    def _around(self, boxes: Floats, curve: BranchCurve) -> list[int]:
        """The numbers of the boxes (m, 2, 1 + d) in which both ends of a branch lie."""
        ends = np.array([self._place(curve, k) for k in (0, -1)])
        found: list[int] = np.flatnonzero(
            (boxes[:, 0] <= ends.min(axis=0)).all(axis=1)
            & (ends.max(axis=0) <= boxes[:, 1]).all(axis=1)
        ).tolist()
        return found

    def _box(self, samples: Floats) -> Floats:
        """Bounds (2, 1 + d) of scaled samples, and of what lies off their chords."""
        low, high = samples.min(axis=0), samples.max(axis=0)
        off = self.settings.max_turn * float(np.linalg.norm(high - low)) + self.settings.same
        return np.array([low - off, high + off])

    def _passes_along(self, drawn: _Drawn, samples: Floats, curve: BranchCurve) -> bool:
        """Whether a longer branch passes both ends of another, and takes its pieces between."""
        known, shift, last = drawn.curve, drawn.column, len(curve.parameter) - 1
        ends = min(1, last), last
        return (
            known is not curve
            and (known.kind, known.order) == (curve.kind, curve.order)
            and all(len(self._chords_near(samples, curve, k)) for k in ends)
            and all(self._passes(known, shift, samples, curve, k) for k in _compared(curve))
            and self._length(known) > self._length(curve)
        )

    def _length(self, curve: BranchCurve) -> float:
        """The length of a branch over all points of its cycle, scaled."""
        points = (curve.x / self.x_scale).reshape(len(curve.parameter), -1)
        samples = np.column_stack([curve.parameter / self.p_scale, points])
        return float(np.linalg.norm(np.diff(samples, axis=0), axis=1).sum())

    def _pass_over(self, curve: BranchCurve) -> None:
        """Merge both ends of a branch that is a point into the special point found there before."""
        columns = curve.x.shape[1]
        for end in curve.ends:
            for x in end.x[:columns]:
                node = self._found(end, x, curve.order)
                if node is not None:
                    node.take(end.at(x), x, curve.order)

    def _chain(self, curve: BranchCurve) -> list[End]:
        """Fold-flip points from the end of a branch back along the branches that led to it."""
        chain = list(reversed(curve.ends))
        while len(chain) < LINKED and all(end.kind is PointKind.FF for end in chain):
            near = self._reached.near(chain[-1].p)
            before = [ends for ends in near if self._is_one(ends[1], chain[-1])]
            if len(before) != 1:
                break
            chain.append(before[0][0])
        return chain

    def _is_one(self, end: End, other: End) -> bool:
        """Whether two ends are one special point, by their first points."""
        return self._are_near(end.p - other.p, end.x[0] - other.x[0], self.settings.same)

    def _are_near(self, off: float, x_off: Floats, within: float) -> bool:
        """Whether differences of parameters and points (..., d) are at most ``within``, scaled."""
        return bool(
            abs(off) <= within * self.p_scale and (np.abs(x_off) <= within * self.x_scale).all()
        )

    def _joins_the_same(self, known: BranchCurve, curve: BranchCurve) -> bool:
        """Whether two branches that are points have the same ends, in the same direction."""
        return all(
            one.kind is other.kind and self._is_same_orbit(one, other, self.settings.nearest)
            for one, other in zip(known.ends, curve.ends, strict=True)
        )

    def _is_same_orbit(self, one: End | Collision, other: End | Collision, within: float) -> bool:
        """Whether two orbits are one, point by point, to ``within``, scaled."""
        return len(one.x) == len(other.x) and self._are_near(
            one.p - other.p, one.x - other.x, within
        )

    def _places_of(self, curve: BranchCurve, shift: int) -> Floats:
        """The parameter and point number ``shift`` of all samples, (m, 1 + d), scaled."""
        places: Floats = np.column_stack([curve.parameter, curve.x[:, shift]]) / self._units
        return places

    def _place(self, curve: BranchCurve, k: int) -> Floats:
        """The parameter and the first point of a sample, (1 + d,), scaled."""
        place: Floats = np.array([curve.parameter[k], *curve.points[k][0]]) / self._units
        return place

    def _has_smaller_period(self, curve: BranchCurve) -> bool:
        """Whether cycles of a branch are those of a smaller period, run through several times."""
        # Then their points coincide, to rounding, between the ends; those of a doubled cycle part
        # along the branch. At the ends rounding may part points that coincide, or the first step
        # has come from another branch.
        if curve.kind is BranchKind.JUMP or curve.order == 1:
            return False
        points, length = curve.x / self.x_scale, self._length(curve)
        same = self.settings.same
        for n in (n for n in range(1, curve.order) if curve.order % n == 0):
            off = np.abs(np.roll(points, n, axis=1) - points).max(axis=(1, 2))
            inner = off[1:-1].max(initial=0.0)
            one = len(off) > 2 and inner <= min(same, self.settings.kink * length)
            if one or off.max() <= same:
                return True
        return False

    def _is_duplicate_of(self, known: BranchCurve, curve: BranchCurve) -> bool:
        """Whether a branch has the ends of a known one and lies on it, with the same pieces."""
        # Its cycle may start from another point. If one of the two has passed over thin pieces
        # their words differ there, but they agree somewhere if the branches are one.
        if (known.kind, known.order) != (curve.kind, curve.order):
            return False
        p, q = (sorted(each.parameter[[0, -1]].tolist()) for each in (known, curve))
        far = self._apart(curve) * self.p_scale
        if max(abs(a - b) for a, b in zip(p, q, strict=True)) > far:
            return False
        shifts = range(known.x.shape[1])
        return any(self._is_duplicate_from(known, shift, curve) for shift in shifts)

    def _apart(self, curve: BranchCurve) -> float:
        """The largest distance of the ends of a branch from those of a duplicate, scaled."""
        extent = max(
            float(np.ptp(curve.parameter)) / self.p_scale,
            float((np.ptp(curve.x[:, 0], axis=0) / self.x_scale).max()),
        )
        return min(SAME_NODE, SHORT_BRANCH * extent)

    def _is_duplicate_from(self, known: BranchCurve, shift: int, curve: BranchCurve) -> bool:
        """The same, with cycles of the known branch starting from point ``shift``."""
        samples = self._places_of(known, shift)
        ends, there = np.array([self._place(curve, k) for k in (0, -1)]), samples[[0, -1]]
        off = min(np.abs(ends - there).max(), np.abs(ends - there[::-1]).max())
        if off > self._apart(curve):
            return False
        if len(samples) == 1 or len(curve.parameter) == 1:  # given up where it begins
            return agree(from_point(known.words[0].keys, shift), curve.words[0].keys)
        return any(self._passes(known, shift, samples, curve, k) for k in _compared(curve))

    def _passes(
        self, known: BranchCurve, shift: int, samples: Floats, curve: BranchCurve, k: int
    ) -> bool:
        """Whether a known branch passes through the middle of samples k - 1 and k of another."""
        # ``samples`` are those of the known branch, scaled, of point ``shift`` of its cycle.
        near = self._chords_near(samples, curve, k)
        if curve.kind is BranchKind.FIXED_POINT:
            steep, here = known.multiplier, sorted(curve.multiplier[max(0, k - 1) : k + 1])
            slopes = (
                np.minimum(steep[near], steep[near + 1]),
                np.maximum(steep[near], steep[near + 1]),
            )
            near = near[(slopes[0] <= here[-1]) & (here[0] <= slopes[1])]
        own_keys = [word.keys for word in words_between(curve, k - 1)]
        return any(
            agree(from_point(word.keys, shift), keys)
            for j in near.tolist()
            for word in words_between(known, j)
            for keys in own_keys
        )

    def _chords_near(self, samples: Floats, curve: BranchCurve, k: int) -> Ints:
        """The chords between scaled samples that pass the middle of samples k - 1 and k."""
        one, other = self._place(curve, k - 1), self._place(curve, k)
        middle = 0.5 * (one + other)
        run = np.diff(samples, axis=0)
        length = np.linalg.norm(run, axis=1)
        part = np.einsum("ij,ij->i", middle - samples[:-1], run) / np.maximum(length**2, TINY)
        foot = samples[:-1] + np.clip(part, 0.0, 1.0)[:, None] * run
        off = np.linalg.norm(middle - foot, axis=1)
        own = float(np.linalg.norm(other - one))
        longest = np.maximum(np.maximum(length, own), SHARP_FOLD)
        # Between two samples a curve leaves its chord by less than its turn times its length.
        return np.flatnonzero(off <= self.settings.max_turn * longest + self.settings.same)

    def _is_known(self, met: Collision) -> bool:
        """Whether a collision of the same cycle was met before."""
        near = self._collisions.near(met.p)
        return any(self._is_same_orbit(known, met, self.settings.same) for known in near)

    def is_switched(self, end: End) -> bool:
        """Whether both branches that meet in a flip are known, so that no more start there."""
        at_flip = (order for e, order in self._ends.near(end.p) if self._is_at(end, e))
        return end.kind is PointKind.PD and len(set(at_flip)) > 1

    def _is_at(self, one: End, other: End) -> bool:
        """Whether two ends are the same flip or branch point, seen from whichever branch."""
        away = (np.abs(one.x - other.x[0]) / self.x_scale).max(axis=1)
        return (
            one.kind is other.kind
            and abs(one.p - other.p) <= AT_FLIP**2 * self.p_scale
            and float(away.min()) <= AT_FLIP
        )

    def _node(self, end: End, x: Floats, order: int) -> Node:
        """The special point at a place: the one found there before, else a new one."""
        node = self._found(end, x, order)
        if node is None:
            node = Node(f"node {len(self.nodes)}", end, x, order, end.kind is PointKind.PD)
            self.nodes.append(node)
            self._places.add(end.p, node)
        else:
            node.take(end, x, order)
        return node

    def _found(self, end: End, x: Floats, order: int) -> Node | None:
        """The special point that was found at a place before; None if there is none."""
        near = self._places.near(end.p)
        met = next((node for node in near if self._meets(node, end, x, order)), None)
        if met is None and (end.note == ENDLESS or _is_lone(end)):
            return next((node for node in self.nodes if self._is_limit(node, end, x)), None)
        return met

    def _is_limit(self, node: Node, end: End, x: Floats) -> bool:
        """Whether a node and an end are the limit of a chain and a collision that lies there."""
        # The limit is estimated; the collision, where a crossing ends at thin pieces, is located.
        limits = [each for each in (node.end, end) if each.note == ENDLESS]
        if len(limits) != 1 or not (_is_lone(node.end) or _is_lone(end)):
            return False
        known = limits[0].precision / self.p_scale
        return self._are_near(node.end.p - end.p, node.x - x, known)

    def _meets(self, node: Node, end: End, x: Floats, order: int) -> bool:
        kinds = {node.end.kind, end.kind}
        turns = kinds <= {PointKind.PD, PointKind.LP}
        flips = turns and order != node.order and (node.flips or end.kind is PointKind.PD)
        near, wide = (AT_FLIP, AT_FLIP**2) if flips else (self.settings.same, self.settings.same)
        if (np.abs(node.x - x) > near * self.x_scale).any():
            return False
        if abs(node.end.p - end.p) > wide * self.p_scale:
            return False
        return len(kinds) == 1 or turns or bool(kinds & {*COLLISIONS, PointKind.BP})


def _is_lone(end: End) -> bool:
    """Whether an end is a collision at which no other curve starts."""
    return end.kind is PointKind.BC and not end.note


def _compared(curve: BranchCurve) -> list[int]:
    """Some samples of a branch, at which it is compared with another."""
    last = len(curve.parameter) - 1
    parts = (math.ceil(last * k / (COMPARISONS + 1)) for k in range(1, COMPARISONS + 1))
    return sorted(set(parts))


def _low_end(curve: BranchCurve) -> float:
    return float(min(curve.parameter[0], curve.parameter[-1]))


def _branch(drawn: _Drawn, x_names: Sequence[str]) -> Branch:
    curve, column, ends = drawn
    words, x = stretches(curve), curve.x[:, column].T.copy()
    return Branch(
        id=curve.kind.value, kind=curve.kind, order=curve.order, word=words[0].word, words=words,
        parameter=curve.parameter, x=x[0], multiplier=curve.multiplier, ends=ends,
        columns=dict(zip(x_names[1:], x[1:], strict=False)),
    )  # fmt: skip


def _diagram_of(
    branches: Sequence[Branch], points: Sequence[SpecialPoint], **about: Any
) -> Diagram:
    """The diagram of branches and points, which get their ids by kind, in order."""
    # Branches refer to their ends by provisional ids. Points get their branches, and their
    # intervals.
    counts, ending, found = Counter[str](), dict[str, dict[str, None]](), list[SpecialPoint]()

    def name(letters: str) -> str:
        counts[letters] += 1
        return f"{letters}{counts[letters]}"

    ids, named = {point.id: name(point.kind.value) for point in points}, list[Branch]()
    for each in branches:
        first, last = (ids[end] for end in each.ends)
        named.append(replace(each, id=name(LETTERS[each.kind]), ends=(first, last)))
        for end in (first, last):
            ending.setdefault(end, {})[named[-1].id] = None
    for point in points:
        p, away = point.parameter, point.precision
        interval = (p - away, p + away) if math.isfinite(away) else None
        own = ids[point.id]
        found.append(replace(point, id=own, branches=tuple(ending[own]), interval=interval))
    return Diagram(branches=tuple(named), points=tuple(found), **about)


def _place_at(end: End, x: Floats) -> Floats:
    """The point (d,) of a special point that is the nearest to the last one of a branch."""
    # A doubled cycle is known near its flip to the root of rounding, the single one to rounding.
    if end.kind is not PointKind.PD:
        return x
    return np.asarray(end.x[np.abs(end.x - x).max(axis=1).argmin()])
