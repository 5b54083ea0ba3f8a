"""What a search has found: branches, the special points they end in, and what is left to follow."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pwmap.diagrams.diagram import (
    Branch,
    BranchKind,
    Diagram,
    PointKind,
    PointStatus,
    SpecialPoint,
)
from pwmap.diagrams.record import PROGRAM, plain
from woodpecker.base.arrays import Floats
from woodpecker.base.settings import Settings, differing
from woodpecker.engine.network import NODE, diagram_of
from woodpecker.search.accumulations import LINKED, limit_of
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

TINY = 1e-300  # in place of a length that is zero: there is nothing to divide
# In x, a part of the window: a flip and the fold of the doubled cycle this close are one point, if
# their parameters are as close as its square. As far again above what makes points of a cycle one.
AT_FLIP = 1e-4
# Part of a branch: ends of the same branch are closer, too, for short ones that follow each other
# are not one.
SHORT_BRANCH = 0.01
# Places at which two branches with the same ends are compared: one may have passed over a piece
# that the other has at some of them.
COMPARED = 7
# Scaled: where a branch turns within less, the angle between its samples may be larger, as its
# inverse: what is drawn is as good, and half as many samples tell what lies between them.
SHARP_FOLD = 1e-6
COLLISIONS = (PointKind.BC, PointKind.FF)
SWITCHES = (PointKind.PD, PointKind.BP)


@dataclass(eq=False)
class Node:
    """A special point under construction; ``flips`` if a flip lies there, whatever it is called."""

    id: str
    end: End
    x: float
    order: int
    flips: bool

    def take(self, end: End, x: float, order: int) -> None:
        """Take in another end that lies there: it names the point if it says more."""
        # A collision says more than others; a cycle more than the same cycle passed twice, to which
        # its flip is a fold; a fold more than a flip that cannot be told from it.
        self.flips = self.flips or end.kind is PointKind.PD
        collides = end.kind in COLLISIONS and self.end.kind not in COLLISIONS
        folds = order == self.order and (end.kind, self.end.kind) == (PointKind.LP, PointKind.PD)
        if order < self.order or collides or folds:
            self.end, self.x, self.order = end, x, min(order, self.order)

    def as_point(self) -> SpecialPoint:
        """The special point of a diagram, without the branches that end there."""
        end = self.end
        return SpecialPoint(
            id=self.id, kind=end.kind, parameter=end.p, x=self.x, order=self.order,
            note=end.note, cause=end.cause, precision=end.precision, status=end.status,
        )  # fmt: skip


class Network:
    """Branches, special points (one within the scales), and where something is left to follow."""

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.curves: list[BranchCurve] = []
        self.branches: list[Branch] = []
        self._drawn: list[BranchCurve] = []  # the curve of each of these branches
        self.nodes: list[Node] = []
        self.waiting: deque[End] = deque()  # of collisions
        self.switches: deque[End] = deque()  # flips and branch points
        widest = 2.0 * max(settings.same, NODE, AT_FLIP**2) * settings.p_scale
        self._by_low_end = Nearby[BranchCurve](widest)
        self._ends = Nearby[tuple[End, int]](widest)
        self._reached = Nearby[tuple[End, End]](widest)
        self._places = Nearby[Node](widest)
        self._collisions = Nearby[Collision](widest)
        self._switches = Nearby[End](widest)

    def diagram(self, parameter_name: str, x_name: str) -> Diagram:
        """Everything found so far, but for branches that another one runs along and beyond."""
        parts = {id(curve) for curve in self.curves if self._is_part(curve)}
        kept = zip(self.branches, self._drawn, strict=True)
        branches = [branch for branch, curve in kept if id(curve) not in parts]
        ends = {end for branch in branches for end in branch.ends}
        made = {"span": self.settings.span, "settings": differing(self.settings, Settings())}
        return diagram_of(
            branches, [node.as_point() for node in self.nodes if node.id in ends],
            parameter_name=parameter_name, x_name=x_name, about={"program": PROGRAM, **plain(made)},
        )  # fmt: skip

    def has(self, curve: BranchCurve, points: Sequence[BranchCurve] = ()) -> bool:
        """Whether a branch was kept before, goes round smaller cycles, or is one of some points."""
        return (
            self._goes_round(curve)
            or any(self._draws(known, curve) for known in self._by_low_end.near(_low_end(curve)))
            or any(self._joins_the_same(known, curve) for known in points)
        )

    @staticmethod
    def leaves_at_once(curve: BranchCurve) -> bool:
        """Whether a branch leaves the span or the window where it begins: none of it is inside."""
        return len(curve.parameter) == 1 and curve.ends[1].status is PointStatus.LOCATED

    def is_a_point(self, curve: BranchCurve) -> bool:
        """Whether a branch is so short that its ends are one special point, and none is open."""
        if any(end.collision is not None or end.status is PointStatus.OPEN for end in curve.ends):
            return False
        same = self.settings.same
        return bool(
            np.ptp(curve.parameter) <= same * self.settings.p_scale
            and np.ptp(curve.x, axis=0).max() <= same * self.settings.x_scale
        )

    def add(self, curve: BranchCurve) -> None:
        """Keep a branch, once for each point of its cycle, unless it is a point."""
        # A chain of fold-flip points without end, seen at P_1 only, ends in its limit.
        if self.is_a_point(curve):
            self._pass_over(curve)
            return
        limit = limit_of(self._chain(curve), self.settings) if curve.order == 1 else None
        curve = curve if limit is None else replace(curve, ends=(curve.ends[0], limit))
        self.curves.append(curve)
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
        words = stretches(curve)
        for x in curve.x.T.copy():
            places = [float(x[0]), float(x[-1] if limit is None else limit.x[0])]
            ends = tuple(
                self._node(end.at(place), place, curve.order)
                for end, place in zip(curve.ends, places, strict=True)
            )
            self._drawn.append(curve)
            self.branches.append(
                Branch(
                    id=curve.kind.value, kind=curve.kind, order=curve.order,
                    word=words[0].word, words=words,
                    parameter=curve.parameter, x=x, multiplier=curve.multiplier,
                    ends=(ends[0].id, ends[1].id),
                )
            )  # fmt: skip

    def _is_part(self, curve: BranchCurve) -> bool:
        """Whether a branch was given up where another one, with the same other end, goes on."""
        # A single curve with these pieces comes to an end of the span, of the window, or to a cycle
        # at a border; where branches turn round or cross there are two.
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
            and self._is_same_orbit(end, other.ends[k], NODE)
            and agree(keys, other.words[-k].keys)
            and (
                other.ends[1 - k].status is PointStatus.LOCATED
                or self._length(other) > self._length(curve)
            )
            for other in self.curves
            for k in (0, 1)
        )

    def _length(self, curve: BranchCurve) -> float:
        """The length of a branch, scaled."""
        points = np.column_stack(
            [curve.parameter / self.settings.p_scale, curve.x / self.settings.x_scale]
        )
        return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())

    def _pass_over(self, curve: BranchCurve) -> None:
        """Make the ends of a branch that is a point one special point, whichever was met first."""
        columns = curve.x.shape[1]
        for end in curve.ends:
            for x in end.x[:columns].tolist():
                node = self._found(end, x, curve.order)
                if node is not None:
                    node.take(end.at(x), x, curve.order)

    def _chain(self, curve: BranchCurve) -> list[End]:
        """Special points from the end of a branch back, along those that each began at the next."""
        chain = list(reversed(curve.ends))
        while len(chain) < LINKED and all(end.kind is PointKind.FF for end in chain):
            near = self._reached.near(chain[-1].p)
            before = [ends for ends in near if self._is_one(ends[1], chain[-1])]
            if len(before) != 1:
                break
            chain.append(before[0][0])
        return chain

    def _is_one(self, end: End, other: End) -> bool:
        """Whether two ends are one special point."""
        same = self.settings.same
        return (
            abs(end.p - other.p) <= same * self.settings.p_scale
            and abs(float(end.x[0] - other.x[0])) <= same * self.settings.x_scale
        )

    def _joins_the_same(self, known: BranchCurve, curve: BranchCurve) -> bool:
        """Whether two branches that are points lead from the same special point to the same."""
        return all(
            one.kind is other.kind and self._is_same_orbit(one, other, self.settings.nearest)
            for one, other in zip(known.ends, curve.ends, strict=True)
        )

    def _is_same_orbit(self, one: End | Collision, other: End | Collision, within: float) -> bool:
        """Whether two orbits are one, point by point, within a part of the scales."""
        return (
            abs(one.p - other.p) <= within * self.settings.p_scale
            and len(one.x) == len(other.x)
            and float(np.abs(one.x - other.x).max()) <= within * self.settings.x_scale
        )

    def _goes_round(self, curve: BranchCurve) -> bool:
        """Whether the cycles of a branch go round others of smaller period."""
        # Between the ends their points are one to rounding: where a branch doubles they part as it
        # goes on. At the ends rounding may part points that are one, or a step has come from
        # another branch.
        if curve.kind is BranchKind.JUMP or curve.order == 1:
            return False
        points, length = curve.x / self.settings.x_scale, self._length(curve)
        same = self.settings.same
        for d in (d for d in range(1, curve.order) if curve.order % d == 0):
            off = np.abs(np.roll(points, d, axis=1) - points).max(axis=1)
            inner = off[1:-1].max(initial=0.0)
            one = len(off) > 2 and inner <= min(same, self.settings.kink * length)
            if one or off.max() <= same:
                return True
        return False

    def _draws(self, known: BranchCurve, curve: BranchCurve) -> bool:
        """Whether a branch has the ends of another and lies on it, with the same pieces."""
        # The cycle may be followed from another of its points. Where one of the two has passed over
        # thin pieces their words differ, but somewhere they agree if they are one.
        if (known.kind, known.order) != (curve.kind, curve.order):
            return False
        p, q = (sorted(each.parameter[[0, -1]].tolist()) for each in (known, curve))
        far = self._apart(curve) * self.settings.p_scale
        if max(abs(a - b) for a, b in zip(p, q, strict=True)) > far:
            return False
        shifts = range(known.x.shape[1])
        return any(self._draws_from(known, shift, curve) for shift in shifts)

    def _apart(self, curve: BranchCurve) -> float:
        """How far the ends of a branch may be from those of one that is the same, scaled."""
        extent = max(
            float(np.ptp(curve.parameter)) / self.settings.p_scale,
            float(np.ptp(curve.x[:, 0])) / self.settings.x_scale,
        )
        return min(NODE, SHORT_BRANCH * extent)

    def _draws_from(self, known: BranchCurve, shift: int, curve: BranchCurve) -> bool:
        """The same if a cycle of the known branch is seen from one of its points."""
        units = np.array([self.settings.p_scale, self.settings.x_scale])
        samples = np.column_stack([known.parameter, known.x[:, shift]]) / units
        ends, there = np.array([_place(curve, k) / units for k in (0, -1)]), samples[[0, -1]]
        off = min(np.abs(ends - there).max(), np.abs(ends - there[::-1]).max())
        if off > self._apart(curve):
            return False
        if len(samples) == 1 or len(curve.parameter) == 1:  # given up where it begins
            return agree(from_point(known.words[0].keys, shift), curve.words[0].keys)
        length = len(curve.parameter)
        places = {max(1, length * k // (COMPARED + 1)) for k in range(1, COMPARED + 1)}
        return any(self._passes(known, shift, samples, curve, k) for k in sorted(places))

    def _passes(
        self, known: BranchCurve, shift: int, samples: Floats, curve: BranchCurve, k: int
    ) -> bool:
        """Whether a branch of given scaled samples goes through another before sample k."""
        # The samples are those of the known branch as the chosen point of its cycle sees them.
        units = np.array([self.settings.p_scale, self.settings.x_scale])
        middle = 0.5 * (_place(curve, k - 1) + _place(curve, k)) / units
        run = np.diff(samples, axis=0)
        length = np.linalg.norm(run, axis=1)
        part = np.einsum("ij,ij->i", middle - samples[:-1], run) / np.maximum(length**2, TINY)
        foot = samples[:-1] + np.clip(part, 0.0, 1.0)[:, None] * run
        off = np.linalg.norm(middle - foot, axis=1)
        own = float(np.linalg.norm((_place(curve, k) - _place(curve, k - 1)) / units))
        longest = np.maximum(np.maximum(length, own), SHARP_FOLD)
        near = off <= self.settings.max_turn * longest + self.settings.same
        steep = known.multiplier
        slopes = np.minimum(steep[:-1], steep[1:]), np.maximum(steep[:-1], steep[1:])
        here = sorted(curve.multiplier[k - 1 : k + 1])
        if curve.kind is BranchKind.FIXED_POINT:
            near &= (slopes[0] <= here[1]) & (here[0] <= slopes[1])
        own_keys = [word.keys for word in words_between(curve, k - 1)]
        return any(
            agree(from_point(word.keys, shift), keys)
            for j in np.flatnonzero(near).tolist()
            for word in words_between(known, j)
            for keys in own_keys
        )

    def _is_known(self, met: Collision) -> bool:
        """Whether a collision was met before, of the same cycle by the same piece."""
        near = self._collisions.near(met.p)
        return any(self._is_same_orbit(known, met, self.settings.same) for known in near)

    def is_switched(self, end: End) -> bool:
        """Whether both branches that meet in a flip are known: there are no more."""
        at_flip = (order for e, order in self._ends.near(end.p) if self._is_at(end, e))
        return end.kind is PointKind.PD and len(set(at_flip)) > 1

    def _is_at(self, one: End, other: End) -> bool:
        """Whether two ends are one flip or one branch point, on whichever of its branches."""
        wide, near = AT_FLIP**2 * self.settings.p_scale, AT_FLIP * self.settings.x_scale
        return (
            one.kind is other.kind
            and abs(one.p - other.p) <= wide
            and float(np.abs(one.x - other.x[0]).min()) <= near
        )

    def _node(self, end: End, x: float, order: int) -> Node:
        """The special point at a place; one that was met before is found again."""
        node = self._found(end, x, order)
        if node is None:
            node = Node(f"node {len(self.nodes)}", end, x, order, end.kind is PointKind.PD)
            self.nodes.append(node)
            self._places.add(end.p, node)
        else:
            node.take(end, x, order)
        return node

    def _found(self, end: End, x: float, order: int) -> Node | None:
        """The special point at a place that was met before."""
        near = self._places.near(end.p)
        return next((node for node in near if self._meets(node, end, x, order)), None)

    def _meets(self, node: Node, end: End, x: float, order: int) -> bool:
        kinds = {node.end.kind, end.kind}
        turns = kinds <= {PointKind.PD, PointKind.LP}
        flips = turns and order != node.order and (node.flips or end.kind is PointKind.PD)
        near, wide = (AT_FLIP, AT_FLIP**2) if flips else (self.settings.same, self.settings.same)
        if abs(node.x - x) > near * self.settings.x_scale:
            return False
        if abs(node.end.p - end.p) > wide * self.settings.p_scale:
            return False
        return len(kinds) == 1 or turns or bool(kinds & set(COLLISIONS))


def _low_end(curve: BranchCurve) -> float:
    """The parameter of that end where it is smaller."""
    return float(min(curve.parameter[0], curve.parameter[-1]))


def _place(curve: BranchCurve, k: int) -> Floats:
    return np.array([curve.parameter[k], curve.points[k][0]])
