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
)
from woodpecker.base.arrays import Floats
from woodpecker.engine.following import Arc, Curve, Following, Sample, Stop
from woodpecker.engine.germs import (
    Beginning,
    Meeting,
    beginnings,
    cycle_at_limit,
    meeting_of,
)
from woodpecker.engine.maps import PiecewiseMap
from woodpecker.engine.newton import Problem, cycles, null_directions, solve
from woodpecker.engine.orbits import Held, Orbit, orbit_of

NODE = 1e-7  # scaled: special points closer than this are one
AWAY = 2.0**-10  # scaled: so far from a branch point the first orbit of another branch is looked for
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
    met: Meeting | None = None


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
        self.branches: list[tuple[Beginning, tuple[Sample, ...], Node, Node]] = []
        self.todo: deque[tuple[Node, Beginning, Stop | None]] = deque()

    def explore(self, start: Orbit) -> None:
        """Follow the branch through a cycle both ways, and what starts at its ends."""
        curve, order = Curve(self.problem, self.settings), len(start.x)
        sample = curve.start(start)
        behind = Sample(start, -sample.tangent)
        one, other = curve.follow(sample), curve.follow(behind)
        begin = Beginning(order, curve, sample)
        first = self._arrive(replace_order(begin, other.samples[0]), other)
        last = first if one.stop is Stop.CLOSED else self._arrive(begin, one)
        samples = one.samples if one.stop is Stop.CLOSED else (*other.samples[:0:-1], *one.samples)
        self.branches.append((begin, samples, first, last))
        while self.todo and len(self.branches) < self.max_branches:
            node, begin, passed = self.todo.popleft()
            if begin not in node.waiting:
                continue  # a branch has arrived along it
            node.waiting.remove(begin)
            arc = begin.curve.follow(begin.sample, passed)
            end = self._arrive(begin, arc)
            self.branches.append((begin, arc.samples, node, end))

    # --- Ends of branches -------------------------------------------------------------------------

    def _arrive(self, begin: Beginning, arc: Arc) -> Node:
        """The point where an arc ends; what else starts there is left to follow."""
        last, crossing = arc.samples[-1], begin.is_crossing
        if arc.stop is Stop.BORDER and arc.border is not None:
            if crossing:
                return self._corner(begin, arc)
            image, code = arc.border
            met = meeting_of(self.map, last.orbit, image, code, begin.curve)
            return self._at_border(begin, arc, met)
        if arc.stop is Stop.SHARE:
            return self._at_border(begin, arc, self._met_by(begin, last.orbit))
        if arc.stop in MULTIPLIERS:
            return self._at_multiplier(begin, arc)
        status = PointStatus.OPEN if arc.stop.is_open else PointStatus.LOCATED
        node = Node(PointKind.EP, last.orbit, begin.order, arc.stop.value, status=status)
        self.nodes.append(node)
        return node

    def _met_by(self, begin: Beginning, crossing: Orbit) -> Meeting:
        """The cycle that meets the border where a crossing ends."""
        cycle, image = cycle_at_limit(crossing)
        at = cycle.images[image]
        code = int(at.codes[np.argmin(np.abs(at.margins))])
        return meeting_of(self.map, cycle, image, code, begin.curve)

    def _at_border(self, begin: Beginning, arc: Arc, met: Meeting) -> Node:
        """The border collision where an arc ends."""
        node = self._known(met.cycle)
        if node is None:
            found = tuple(
                beginnings(self.map, met, self.orders, self.settings, self.problem)
            )
            cause = met.cycle.images[-1].piece.cause(met.code)
            node = Node(
                PointKind.BC, met.cycle, len(met.cycle.x), cause=cause, waiting=list(found),
                starts=found, met=met,
            )  # fmt: skip
            self.nodes.append(node)
            self.todo += [(node, each, None) for each in found]
        arrived = _key(begin)
        node.waiting = [each for each in node.waiting if _key(each) != arrived]
        return node

    def _corner(self, begin: Beginning, arc: Arc) -> Node:
        """Where an orbit of a jump crossing meets a second border: it goes on if that is no jump."""
        assert arc.border is not None
        image, code = arc.border
        sample = arc.samples[-1]
        orbit = sample.orbit
        cause = orbit.taken[image].piece.cause(code)
        node = Node(
            PointKind.EP, orbit, begin.order, "two borders at once", cause, PointStatus.OPEN
        )
        self.nodes.append(node)
        return node

    def _at_multiplier(self, begin: Beginning, arc: Arc) -> Node:
        """A fold, a flip, a pair on the unit circle, a branch point: the curve goes on there."""
        sample, curve = arc.samples[-1], begin.curve
        node = Node(PointKind[arc.stop.name], sample.orbit, begin.order)
        self.nodes.append(node)
        starts = [(Beginning(begin.order, curve, sample), arc.stop)]
        if arc.stop is Stop.PD and 2 * begin.order in self.orders and not begin.is_crossing:
            starts += [(each, None) for each in self._doubled(begin, sample)]
        node.waiting = [each for each, _ in starts]
        self.todo += [(node, each, passed) for each, passed in starts]
        return node

    def _doubled(self, begin: Beginning, sample: Sample) -> list[Beginning]:
        """The branch of cycles of twice the period that starts at a flip."""
        orbit, curve = sample.orbit, begin.curve
        twice = orbit_of(
            [image.piece for image in orbit.images] * 2, np.tile(orbit.x, (2, 1)), orbit.p
        )
        problem = curve.problem
        first, second = null_directions(problem, twice, 2)
        plain = np.append(np.tile(sample.tangent[:-1], 2), sample.tangent[-1])
        across = first - (first @ plain) / (plain @ plain) * plain
        if np.linalg.norm(across) < 0.5:
            across = second - (second @ plain) / (plain @ plain) * plain
        across /= np.linalg.norm(across)
        start = Sample(twice, across)
        found = curve.advance(start, AWAY)
        if found is None:
            return []
        return [Beginning(2 * begin.order, curve, found)]

    def _known(self, cycle: Orbit) -> Node | None:
        """The border collision that lies at a cycle, if there is one."""
        for node in self.nodes:
            if node.met is not None and len(node.orbit.x) == len(cycle.x):
                scale = self.problem.scale(cycle)[: -1]
                for first in range(len(cycle.x)):
                    other = cycle.rotated(first)
                    away = (other.unknowns - node.orbit.unknowns)[:-1] / scale
                    if np.abs(away).max() <= NODE:
                        return node
        return None

    # --- The result -------------------------------------------------------------------------------

    def diagram(self, names: Sequence[str]) -> Diagram:
        """All that was found: a branch, and an end of it, for each point of a cycle."""
        places: list[_Place] = []
        branches: list[Branch] = []
        letters: Counter[str] = Counter()
        for begin, samples, first, last in self.branches:
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
                branches.append(self._branch(name, begin, samples, ids, column, names))
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
        if node.met is not None:
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
        self, name: str, begin: Beginning, samples: Sequence[Sample], ends: tuple[str, str],
        column: int, names: Sequence[str],
    ) -> Branch:  # fmt: skip
        orbits = [sample.orbit for sample in samples]
        at = np.array([orbit.x[column] for orbit in orbits])
        multiplier = np.full(len(orbits), np.nan)
        if not begin.is_crossing:
            largest = [orbit.multipliers()[0] for orbit in orbits]
            multiplier = np.array([abs(m) if m.imag else m.real for m in largest])
        return Branch(
            id=name, kind=BranchKind.JUMP if begin.is_crossing else BranchKind.FIXED_POINT,
            order=begin.order, word=orbits[len(orbits) // 2].word, multiplier=multiplier,
            parameter=np.array([orbit.p[self.problem.free[0]] for orbit in orbits]),
            x=at[:, 0], ends=ends,
            columns={name: at[:, j] for j, name in enumerate(names[2:], 1)},
        )  # fmt: skip


def judged(node: Node, x: Floats, scale: Floats) -> tuple[PointKind, str]:
    """What a border collision is at one point of its cycle, from the curves that start there.

    Of the curves of the cycle's own order there are two: on both sides of the parameter
    (persistence), or on one (fold). At a jump that folds, and starts crossings of twice the order,
    it is a fold-flip.
    """
    own, twice = [], False
    for begin in node.starts:
        points = begin.sample.orbit.x[: 1 if begin.is_crossing else None]
        count = int((np.abs((points - x) / scale).max(axis=1) <= NODE).sum())
        if begin.order == node.order:
            own += count * [begin.ahead > 0.0]
        twice |= begin.is_crossing and begin.order == 2 * node.order and count > 0
    if len(own) != 2:
        return PointKind.BC, f"{len(own)} of two branches are known"
    note = "fold" if own[0] == own[1] else "persistence"
    jumps = node.met is not None and node.met.jumps
    return (PointKind.FF if jumps and note == "fold" and twice else PointKind.BC), note


def _key(begin: Beginning) -> tuple[Hashable, ...]:
    """What tells the curves that start at one point apart: their pieces, from the least on."""
    keys = begin.sample.orbit.keys
    if begin.is_crossing:
        return (begin.order, True, *keys)
    turns = [keys[i:] + keys[:i] for i in range(len(keys))]
    return (begin.order, False, *min(turns, key=str))


def replace_order(begin: Beginning, sample: Sample) -> Beginning:
    """The same curve from a sample."""
    return replace(begin, sample=sample)
