"""Branches and the points where they meet: from one cycle to all that is connected with it."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pwmap.diagrams.diagram import (
    Branch,
    BranchKind,
    Diagram,
    PointKind,
    PointStatus,
    SpecialPoint,
    Stretch,
)
from woodpecker.base.arrays import Floats
from woodpecker.engine.following import Arc, Curve, Following, Sample, Stop
from woodpecker.engine.germs import Beginning, beginnings, cycle_at_limit, cycle_through, once
from woodpecker.engine.maps import PiecewiseMap
from woodpecker.engine.newton import Problem, cycles, other_direction, solve
from woodpecker.engine.orbits import Held, Orbit, orbit_of

NODE = 1e-7  # scaled: special points closer than this are one
AWAY = 2.0**-10  # scaled: so far from a branch point the first orbit of another branch is looked for
ALONG = 0.9  # cosine of the angle within which two curves leave a point the same way
MOST_ARCS = 1000  # of one branch
MULTIPLIERS = (Stop.LP, Stop.PD, Stop.NS, Stop.BP)


@dataclass(eq=False)
class Node:
    """A special point under construction, with the curves that start there and are not followed."""

    kind: PointKind
    orbit: Orbit
    order: int
    note: str = ""
    cause: str = ""
    status: PointStatus = PointStatus.LOCATED
    waiting: list[Beginning] = field(default_factory=list)
    starts: tuple[Beginning, ...] = ()
    meets: bool = False  # a border


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """A branch from its beginning to a special point.

    Attributes
    ----------
    begin
        What it is a curve of.
    samples
        Those of its arcs.
    words
        (first sample, word, cause) of each arc.
    end
        The special point.
    is_closed
        Whether it has come back to its first sample.
    """

    begin: Beginning
    samples: tuple[Sample, ...]
    words: tuple[tuple[int, str, str], ...]
    end: Node
    is_closed: bool = False

    def then(self, other: Trace) -> Trace:
        """This one backwards, and another that starts at the same sample."""
        count = len(self.samples) - 1
        starts = [first for first, _, _ in self.words[1:]] + [count]
        words = [(count - start, word, cause) for (_, word, cause), start in zip(self.words, starts, strict=True)]
        words = [*words[:0:-1], *words[:1]] if len(words) > 1 else words
        merged = [(0, *words[0][1:]), *words[1:]]
        merged += [(first + count, word, cause) for first, word, cause in other.words[1:]]
        return Trace(other.begin, (*self.samples[:0:-1], *other.samples), tuple(merged), other.end)


@dataclass(eq=False)
class _Place:
    """A point of the diagram under construction."""

    node: Node
    x: Floats
    kind: PointKind
    note: str
    id: str
    branches: list[str] = field(default_factory=list)


def connected(
    map_: PiecewiseMap,
    x: Floats,
    p: Floats,
    settings: Following,
    *,
    orders: Sequence[int] = (1, 2),
    free: int = 0,
    x_scale: Floats | None = None,
    p_scale: Floats | None = None,
    names: Sequence[str] = ("p", "x"),
    max_branches: int = 500,
) -> Diagram:
    """The branch through a cycle, and all branches that are connected with it.

    Parameters
    ----------
    map_
        A map of R^d.
    x, p
        A guess of a cycle's points, (n, d) or (d,), and the parameters (k,).
    settings
        Span, window, steps.
    orders
        Iterates whose cycles and jump crossings are followed.
    free
        Which parameter varies.
    x_scale, p_scale
        (d,) and (k,) lengths that count as 1; by default all ones.
    names
        Of the parameter and the coordinates; the first coordinate is the diagram's x, the others
        are columns of its branches.
    max_branches
        So many are followed at most; then points with more to follow are ``open``.

    Returns
    -------
    Diagram
        One branch for each point of a cycle.

    Raises
    ------
    ValueError
        If Newton's method finds no cycle of the map near the guess.
    """
    points = np.atleast_2d(np.asarray(x, dtype=float))
    p = np.asarray(p, dtype=float)
    ones = np.ones(points.shape[1]), np.ones(len(p))
    problem = cycles(
        (free,), ones[0] if x_scale is None else x_scale, ones[1] if p_scale is None else p_scale
    )
    start = cycle_near(map_, points, p, problem)
    network = Network(map_, settings, problem, tuple(orders), max_branches)
    network.explore(start)
    return network.diagram(names)


def cycle_near(map_: PiecewiseMap, x: Floats, p: Floats, problem: Problem) -> Orbit:
    """The cycle near a guess (n, d) of its points, under the pieces that the map takes there.

    Raises
    ------
    ValueError
        If Newton's method finds none, or its points belong to other pieces.
    """
    guess = orbit_of([map_.at(point, p).piece for point in x], x, p)
    held = [Held(x.size + k, float(p[k])) for k in problem.free]
    solution = solve(problem.with_(*held), guess)
    orbit = solution.orbit
    if not solution.converged:
        raise ValueError(f"no cycle of {len(x)} points was found near {x.tolist()} at p = {p}")
    taken = [map_.at(point, p).piece.key for point in orbit.x]
    if taken != list(orbit.keys):
        raise ValueError(f"the cycle near {x.tolist()} is virtual: a point lies in another piece")
    return orbit


class Network:
    """What has been found: special points, branches, and what is left to follow."""

    def __init__(
        self, map_: PiecewiseMap, settings: Following, problem: Problem, orders: tuple[int, ...],
        max_branches: int,
    ) -> None:  # fmt: skip
        self.map, self.settings, self.problem, self.orders = map_, settings, problem, orders
        self.max_branches = max_branches
        self.nodes: list[Node] = []
        self.branches: list[tuple[Trace, Node, Node]] = []
        self.todo: deque[tuple[Node, Beginning]] = deque()

    def explore(self, start: Orbit) -> None:
        """Follow the branch through a cycle both ways, and what starts at its ends."""
        curve, order = Curve(self.problem, self.settings), len(start.x)
        sample = curve.start(start)
        ahead = self._trace(Beginning(order, curve, sample))
        if ahead.is_closed:
            self.branches.append((ahead, ahead.end, ahead.end))
        else:
            behind = self._trace(Beginning(order, curve, Sample(start, -sample.tangent)))
            self.branches.append((behind.then(ahead), behind.end, ahead.end))
        while self.todo and len(self.branches) < self.max_branches:
            node, begin = self.todo.popleft()
            if begin in node.waiting:  # else a branch has arrived along it
                node.waiting.remove(begin)
                trace = self._trace(begin)
                self.branches.append((trace, node, trace.end))

    def _trace(self, begin: Beginning) -> Trace:
        """Follow a curve to a special point, through borders where only its word changes."""
        samples = [] if begin.before is None else [begin.before]
        words: list[tuple[int, str, str]] = []
        first, cause = begin, ""
        for _ in range(MOST_ARCS):
            words.append((len(samples) if words else 0, begin.sample.orbit.word, cause))
            arc = begin.curve.follow(begin.sample)
            samples += arc.samples[1 if samples else 0 :]
            onward = self._onward(begin, arc)
            if onward is None:
                break
            begin, cause = onward, _cause(arc)
        end = self._arrive(begin, arc)
        return Trace(first, tuple(samples), tuple(words), end, arc.stop is Stop.CLOSED)

    # --- Ends of branches -------------------------------------------------------------------------

    def _onward(self, begin: Beginning, arc: Arc) -> Beginning | None:
        """How a crossing goes on where another point of its orbit meets a border.

        It does if just one crossing of its order starts there besides that which has arrived, and
        no cycle goes through that point.
        """
        if arc.stop is not Stop.BORDER or not begin.is_crossing or self._cycle(arc) is not None:
            return None
        orbit = arc.samples[-1].orbit
        starts = beginnings(
            self.map, orbit.x[:1], orbit.p, (begin.order,), self.settings, self.problem
        )
        arrived = replace(begin, sample=arc.samples[-1]).key
        others = [each for each in starts if each.key != arrived]
        return others[0] if len(others) == 1 else None

    def _cycle(self, arc: Arc) -> Orbit | None:
        """The cycle that meets a border where an arc ends."""
        orbit = arc.samples[-1].orbit
        if orbit.outer is None:
            return once(orbit, self.problem)
        if arc.stop is Stop.SHARE:
            return cycle_at_limit(orbit, self.problem)
        return cycle_through(self.map, orbit.x[0], orbit.p, self.orders, self.problem)

    def _arrive(self, begin: Beginning, arc: Arc) -> Node:
        """The point where an arc ends; what else starts there is left to follow."""
        orbit = arc.samples[-1].orbit
        if arc.stop in MULTIPLIERS:
            return self._at_multiplier(begin, arc)
        cycle = self._cycle(arc) if arc.stop in (Stop.SHARE, Stop.BORDER) else None
        if cycle is not None:
            return self._at_border(begin, arc, cycle)
        status = PointStatus.OPEN if arc.stop.is_open else PointStatus.LOCATED
        note = arc.stop.value
        if arc.stop is Stop.BORDER:
            status, note = PointStatus.OPEN, "two borders at once"
        node = Node(PointKind.EP, orbit, begin.order, note, status=status)
        self.nodes.append(node)
        return node

    def _at_border(self, begin: Beginning, arc: Arc, cycle: Orbit) -> Node:
        """The border collision of a cycle, where an arc ends."""
        node = self._known(cycle)
        if node is None:
            order = len(cycle.x)
            found = tuple(
                beginnings(
                    self.map, cycle.x, cycle.p, sorted({*self.orders, order, 2 * order}),
                    self.settings, self.problem,
                )
            )  # fmt: skip
            node = Node(
                PointKind.BC, cycle, order, cause=_cause(arc), starts=found, meets=True,
                waiting=[each for each in found if each.order in self.orders],
            )  # fmt: skip
            self.nodes.append(node)
            self.todo += [(node, each) for each in node.waiting]
        arrived = replace(begin, sample=arc.samples[-1]).key
        node.waiting = [each for each in node.waiting if each.key != arrived]
        return node

    def _at_multiplier(self, begin: Beginning, arc: Arc) -> Node:
        """A fold, a flip, a pair on the unit circle, a branch point: the curve goes on there."""
        sample, curve, order = arc.samples[-1], begin.curve, begin.order
        single = sample.orbit if begin.is_crossing else once(sample.orbit, self.problem)
        kind = PointKind[arc.stop.name] if len(single.x) == len(sample.orbit.x) else PointKind.PD
        node = self._known(single, kind)
        if node is not None:
            node.waiting = [each for each in node.waiting if not _is_back(each, arc)]
            return node
        node = Node(kind, single, order if kind.value == arc.stop.name else len(single.x))
        self.nodes.append(node)
        others: list[tuple[int, Sample]] = []
        if len(single.x) < len(sample.orbit.x):  # a branch of twice the period has come to its flip
            start = curve.start(single)
            others += [(len(single.x), start), (len(single.x), Sample(single, -start.tangent))]
        else:
            starts = curve.start(sample.orbit, sample.tangent)
            if arc.beyond is not None:
                node.waiting.append(Beginning(order, curve, arc.beyond, starts))
            if arc.stop is Stop.PD:
                others += [(2 * order, self._doubled(curve, sample))]
            if arc.stop is Stop.BP:
                across = other_direction(curve.problem, sample.orbit, sample.tangent)
                others += [(order, Sample(sample.orbit, sign * across)) for sign in (1.0, -1.0)]
        for wanted, start in others:
            found = curve.advance(start, AWAY) if wanted in self.orders else None
            if found is not None:
                node.waiting.append(Beginning(wanted, curve, found, start))
        self.todo += [(node, each) for each in node.waiting]
        return node

    @staticmethod
    def _doubled(curve: Curve, sample: Sample) -> Sample:
        """A cycle at its flip, run through twice, with the direction of those of twice its period."""
        orbit = sample.orbit
        pieces = [image.piece for image in orbit.images] * 2
        twice = orbit_of(pieces, np.tile(orbit.x, (2, 1)), orbit.p)
        along = np.append(np.tile(sample.tangent[: orbit.x.size], 2), sample.tangent[orbit.x.size :])
        return Sample(twice, other_direction(curve.problem, twice, along))

    def _known(self, cycle: Orbit, kind: PointKind = PointKind.BC) -> Node | None:
        """The special point of a kind that lies at a cycle, if there is one."""
        scale = self.problem.scale(cycle)
        for node in self.nodes:
            if node.kind is kind and len(node.orbit.x) == len(cycle.x):
                turns = (cycle.rotated(first).unknowns for first in range(len(cycle.x)))
                if any(np.abs((t - node.orbit.unknowns) / scale).max() <= NODE for t in turns):
                    return node
        return None

    # --- The result -------------------------------------------------------------------------------

    def diagram(self, names: Sequence[str]) -> Diagram:
        """All that was found: a branch, and an end of it, for each point of a cycle."""
        places: list[_Place] = []
        branches: list[Branch] = []
        letters: Counter[str] = Counter()
        for trace, first, last in self.branches:
            begin, samples = trace.begin, trace.samples
            for column in range(1 if begin.is_crossing else begin.order):
                letter = "J" if begin.is_crossing else "F"
                letters[letter] += 1
                name = f"{letter}{letters[letter]}"
                ends = [
                    self._place(places, node, sample.orbit.x[column])
                    for node, sample in ((first, samples[0]), (last, samples[-1]))
                ]
                for end in ends:
                    end.branches.append(name)
                ids = ends[0].id, ends[1].id
                branches.append(self._branch(name, trace, ids, column, names))
        return Diagram(
            parameter_name=names[0], x_name=names[1], branches=tuple(branches),
            points=tuple(self._point(place) for place in places),
        )  # fmt: skip

    def _place(self, places: list[_Place], node: Node, x: Floats) -> _Place:
        """The point of a node at some x: that of a cycle has one for each of its points."""
        for each in places:
            if each.node is node and np.abs((each.x - x) / self.problem.x_scale).max() <= NODE:
                return each
        kind, note = node.kind, node.note
        if node.meets:
            kind, note = judged(node, x, self.problem.x_scale)
        count = sum(each.kind is kind for each in places) + 1
        places.append(_Place(node, x, kind, note, f"{kind.value}{count}"))
        return places[-1]

    def _point(self, place: _Place) -> SpecialPoint:
        node = place.node
        return SpecialPoint(
            id=place.id, kind=place.kind, parameter=float(node.orbit.p[self.problem.free[0]]),
            x=float(place.x[0]), branches=tuple(dict.fromkeys(place.branches)), order=node.order,
            note=place.note, cause=node.cause, status=node.status,
        )  # fmt: skip

    def _branch(
        self, name: str, trace: Trace, ends: tuple[str, str], column: int, names: Sequence[str]
    ) -> Branch:
        begin, orbits = trace.begin, [sample.orbit for sample in trace.samples]
        at = np.array([orbit.x[column] for orbit in orbits])
        multiplier = np.full(len(orbits), np.nan)
        if not begin.is_crossing:
            largest = [orbit.multipliers()[0] for orbit in orbits]
            multiplier = np.array([abs(m) if m.imag else m.real for m in largest])
        return Branch(
            id=name, kind=BranchKind.JUMP if begin.is_crossing else BranchKind.FIXED_POINT,
            order=begin.order, word=trace.words[0][1], multiplier=multiplier,
            words=tuple(Stretch(*each) for each in trace.words),
            parameter=np.array([orbit.p[self.problem.free[0]] for orbit in orbits]),
            x=at[:, 0], ends=ends,
            columns={name: at[:, j] for j, name in enumerate(names[2:], 1)},
        )  # fmt: skip


def judged(node: Node, x: Floats, scale: Floats) -> tuple[PointKind, str]:
    """What a border collision is at one point of its cycle, from the curves that start there.

    Those of the cycle's own order lie on both sides of the parameter (persistence), or on one
    (fold). Where a cycle folds into a jump crossing, and a crossing of twice the order starts at
    the preimage of the jump, it is a fold-flip.
    """
    own: list[Beginning] = []
    twice = False
    for begin in node.starts:
        orbit = begin.sample.orbit
        points = orbit.x[: 1 if begin.is_crossing else None]
        count = int((np.abs((points - x) / scale).max(axis=1) <= NODE).sum())
        if begin.order == node.order:
            own += count * [begin]
        at_preimage = begin.is_crossing and begin.order == 2 * node.order < 2 * len(orbit.x)
        twice |= at_preimage and count > 0
    sides = {begin.ahead > 0.0 for begin in own}
    if len(own) < 2:
        return PointKind.BC, f"{len(own)} of two branches are known"
    note = "fold" if len(sides) == 1 else "persistence"
    crossings = sum(begin.is_crossing for begin in own)
    flips = twice and note == "fold" and 0 < crossings == len(own) - 1
    return (PointKind.FF if flips else PointKind.BC), note


def _cause(arc: Arc) -> str:
    """What happens where an arc ends at a border."""
    orbit = arc.samples[-1].orbit
    image, code = arc.border or min(arc.curve.ignored)
    return orbit.taken[image].piece.cause(code)


def _is_back(begin: Beginning, arc: Arc) -> bool:
    """Whether a curve that starts at a point is the one that an arc has come along."""
    if begin.before is None or begin.sample.orbit.x.shape != arc.samples[-1].orbit.x.shape:
        return False
    away = begin.curve.problem.step_between(begin.before.orbit, begin.sample.orbit)
    return float(away @ arc.samples[-1].tangent) < -ALONG * float(np.linalg.norm(away))
