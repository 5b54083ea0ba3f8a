"""Branches and the points where they meet: from one cycle to all that is connected with it."""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain, pairwise

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
from woodpecker.engine.curves import MULTIPLIERS, Arc, Curve, CurveSettings, Sample, Stop
from woodpecker.engine.germs import (
    Beginning,
    beginnings,
    cycle_at_limit,
    cycle_through,
    judged,
    once,
)
from woodpecker.engine.maps import PiecewiseMap
from woodpecker.engine.newton import Problem, cycles, other_direction, solve
from woodpecker.engine.orbits import Held, Orbit, orbit_of

NODE = 1e-7  # scaled: special points closer than this are one
AWAY = 2.0**-10  # scaled: so far from a branch point another branch is looked for
ALONG = 0.9  # cosine of the angle within which two curves leave a point the same way
MOST_ARCS = 1000  # of one branch


@dataclass(frozen=True, slots=True, eq=False)
class Connected:
    """What is connected with a cycle.

    Attributes
    ----------
    diagram
        Branches and special points: of a cycle one branch, and one point, for each of its points.
    orbits
        By the id of a special point, the orbit there: from it a curve in two parameters starts.
    """

    diagram: Diagram
    orbits: Mapping[str, Orbit]


def connected(
    map_: PiecewiseMap, x: object, p: object, settings: CurveSettings, *,
    orders: Sequence[int] = (1, 2), free: int = 0, x_scale: Sequence[float] | None = None,
    p_scale: Sequence[float] | None = None, names: Sequence[str] = ("p", "x"),
    max_branches: int = 500,
) -> Connected:  # fmt: skip
    """The branch through a cycle, and all branches that are connected with it.

    Cycles and jump crossings start where a cycle meets a border, and go on from there; cycles of
    twice the period start at flips, others at branch points.

    Parameters
    ----------
    map_
        A map of R^d.
    x, p
        A guess of a cycle's points, (n, d), or (d,) for a fixed point; and the parameters (k,).
    settings
        Span, window, steps.
    orders
        Iterates whose cycles and jump crossings are followed.
    free
        Which parameter varies, from 0 on.
    x_scale, p_scale
        d and k lengths that count as 1; by default all are 1.
    names
        Of the parameter and the coordinates; the first coordinate is the diagram's x, the others
        are columns of its branches.
    max_branches
        So many are followed at most.

    Returns
    -------
    Connected
        Diagram and orbits. The multiplier of a branch is its largest one, of a complex pair the
        modulus.

    Raises
    ------
    ValueError
        If Newton's method finds no cycle of the map near the guess, or it lies outside.

    Examples
    --------
    >>> from sympy import symbols
    >>> from woodpecker.engine.curves import CurveSettings
    >>> from woodpecker.engine.formulas import expression_map
    >>> from woodpecker.engine.network import connected
    >>> x, y, a, b = symbols("x y a b")
    >>> henon = expression_map((x, y), (a, b), {"H": (1 - a * x**2 + y, b * x)})
    >>> settings = CurveSettings(spans=((-1, 1),), window=((-4, 4), (-4, 4)))
    >>> found = connected(henon, [0.6, 0.2], [0.1, 0.3], settings, orders=(1,))
    >>> for point in found.diagram.points:  # exact: -(1 - b)^2/4 and 3 (1 - b)^2/4
    ...     if point.kind.value != "EP":
    ...         print(point.kind, round(point.parameter, 12))
    PD 0.3675
    LP -0.1225
    """
    points = np.atleast_2d(np.asarray(x, dtype=float))
    values = np.atleast_1d(np.asarray(p, dtype=float))
    d, k = points.shape[1], len(values)
    if len(settings.window) != d or len(settings.spans) != 1:
        raise ValueError(
            f"expected a window of {d} intervals and one span, got {len(settings.window)} and "
            f"{len(settings.spans)}"
        )
    if not 0 <= free < k:
        raise ValueError(f"free must name one of {k} parameters, from 0 on, got {free}")
    problem = cycles((free,), x_scale or (1.0,) * d, p_scale or (1.0,) * k)
    start = cycle_near(map_, points, values, problem)
    for name, at, (low, high) in (
        ("the parameter", values[free : free + 1], settings.spans[0]),
        *(("a coordinate", start.x[:, j], settings.window[j]) for j in range(d)),
    ):
        if at.min() < low or at.max() > high:
            raise ValueError(f"{name} of the cycle must lie in [{low}, {high}], got {at.tolist()}")
    network = Network(Curve(map_, problem, settings), tuple(orders), max_branches)
    network.explore(start)
    return network.result(names)


def cycle_near(map_: PiecewiseMap, x: Floats, p: Floats, problem: Problem) -> Orbit:
    """The cycle near a guess (n, d) of its points, under the pieces that the map takes there.

    Raises
    ------
    ValueError
        If Newton's method finds none, or one of its points lies in another piece.
    """
    guess = orbit_of([map_.at(point, p).piece for point in x], x, p)
    held = [Held(x.size + k, float(p[k])) for k in problem.free]
    solution = solve(problem.with_(*held), guess)
    orbit = solution.orbit
    if not solution.converged:
        raise ValueError(f"no cycle of {len(x)} points was found near {x.tolist()} at p = {p}")
    if [map_.at(point, p).piece.key for point in orbit.x] != list(orbit.keys):
        raise ValueError(f"the cycle near {x.tolist()} is virtual: a point lies in another piece")
    return orbit


@dataclass(eq=False)
class Node:
    """A special point under construction.

    Attributes
    ----------
    kind, orbit, order, note, cause, precision, status
        As :class:`pwmap.diagrams.diagram.SpecialPoint` has them.
    starts
        At a border: all curves that start there.
    waiting
        Those that are still to be followed.
    """

    kind: PointKind
    orbit: Orbit
    order: int
    note: str = ""
    cause: str = ""
    precision: float = math.inf
    status: PointStatus = PointStatus.LOCATED
    starts: tuple[Beginning, ...] = ()
    waiting: list[Beginning] = field(default_factory=list)


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """A branch from its beginning to a special point.

    Attributes
    ----------
    begin
        What it is a curve of.
    arcs
        Its arcs; all but the last end at borders where only the word changes.
    end
        The special point.
    """

    begin: Beginning
    arcs: tuple[Arc, ...]
    end: Node

    @property
    def samples(self) -> list[Sample]:
        """Those of all arcs; one at a border has the pieces before it."""
        before = () if self.begin.before is None else (self.begin.before,)
        later = (arc.samples[1:] for arc in self.arcs[1:])
        return [*before, *self.arcs[0].samples, *chain.from_iterable(later)]

    @property
    def words(self) -> list[Stretch]:
        """Where its words begin, with what happens there."""
        found = [Stretch(0, self.begin.sample.orbit.word)]
        first = len(self.arcs[0].samples) + (self.begin.before is not None)
        for before, arc in pairwise(self.arcs):
            found.append(Stretch(first, arc.samples[0].orbit.word, _cause(before)))
            first += len(arc.samples) - 1
        return found


class Network:
    """What has been found: special points, branches, and what is left to follow."""

    def __init__(self, base: Curve, orders: tuple[int, ...], max_branches: int) -> None:
        self.base, self.map, self.problem, self.orders = base, base.map, base.problem, orders
        self.max_branches = max_branches
        self.nodes: list[Node] = []
        self.branches: list[tuple[Trace, Node]] = []  # each with the point where it begins
        self.todo: deque[tuple[Node, Beginning]] = deque()

    def explore(self, start: Orbit) -> None:
        """Follow the branch through a cycle, and what starts at its ends.

        It is followed one way to a special point, and from there as any other.
        """
        first = self.base.start(start)
        ahead = self._trace(Beginning(len(start.x), self.base, first))
        if ahead.arcs[-1].stop is Stop.CLOSED:
            self.branches.append((ahead, ahead.end))
            return
        last = ahead.arcs[-1].samples[-1]  # from there it is followed the whole way back
        back = Beginning(len(start.x), self.base, Sample(last.orbit, -last.tangent))
        ahead.end.waiting.insert(0, back)
        self.todo.appendleft((ahead.end, back))
        while self.todo and len(self.branches) < self.max_branches:
            node, begin = self.todo.popleft()
            if begin in node.waiting:  # else a branch has arrived along it
                node.waiting.remove(begin)
                self.branches.append((self._trace(begin), node))

    def _trace(self, begin: Beginning) -> Trace:
        """Follow a curve to a special point, through borders where only its word changes."""
        arcs, at = list[Arc](), begin
        for _ in range(MOST_ARCS):
            arcs.append(at.curve.follow(at.sample))
            onward = self._onward(at, arcs[-1])
            if onward is None:
                break
            at = onward
        return Trace(begin, tuple(arcs), self._arrive(at, arcs[-1]))

    # --- Ends of branches -------------------------------------------------------------------------

    def _onward(self, begin: Beginning, arc: Arc) -> Beginning | None:
        """How a crossing goes on where another point of its orbit meets a border.

        It does if just one crossing of its order starts there besides that which has arrived, and
        no cycle goes through that point.
        """
        if arc.stop is not Stop.BORDER or not begin.is_crossing or self._cycle(arc) is not None:
            return None
        orbit = arc.samples[-1].orbit
        starts = beginnings(self.base, orbit.x[:1], orbit.p, (begin.order,))
        others = [each for each in starts if each.key != _key_at_end(begin, arc)]
        return others[0] if len(others) == 1 else None

    def _cycle(self, arc: Arc) -> Orbit | None:
        """The cycle that meets a border where an arc ends, run through once."""
        orbit = arc.samples[-1].orbit
        if orbit.outer is None:
            return once(orbit, self.problem)
        if arc.stop is Stop.SHARE:
            return cycle_at_limit(orbit, self.problem)
        return cycle_through(self.map, orbit.x[0], orbit.p, self.orders, self.problem)

    def _arrive(self, begin: Beginning, arc: Arc) -> Node:
        """The point where an arc ends; what else starts there is left to follow."""
        if arc.stop in MULTIPLIERS:
            return self._at_multiplier(begin, arc)
        cycle = self._cycle(arc) if arc.stop in (Stop.SHARE, Stop.BORDER) else None
        if cycle is not None:
            return self._at_border(begin, arc, cycle)
        note, is_open = arc.stop.value, arc.stop.is_open
        if arc.stop is Stop.BORDER:
            note, is_open = "two borders at once", True
        node = Node(
            PointKind.EP, arc.samples[-1].orbit, begin.order, note, _cause(arc), arc.precision,
            PointStatus.OPEN if is_open else PointStatus.LOCATED,
        )  # fmt: skip
        self.nodes.append(node)
        return node

    def _at_border(self, begin: Beginning, arc: Arc, cycle: Orbit) -> Node:
        """The border collision of a cycle, where an arc ends."""
        node, order = self._known(cycle, PointKind.BC), len(cycle.x)
        if node is None:
            wanted = sorted({*self.orders, order, 2 * order})
            starts = beginnings(self.base, cycle.x, cycle.p, wanted)
            node = Node(
                PointKind.BC, cycle, order, cause=_cause(arc), precision=arc.precision,
                starts=tuple(starts),
            )  # fmt: skip
            node.waiting = [each for each in node.starts if each.order in self.orders]
            self.nodes.append(node)
            self.todo += [(node, each) for each in node.waiting]
        arrived = _key_at_end(begin, arc)
        node.waiting = [each for each in node.waiting if each.key != arrived]
        return node

    def _at_multiplier(self, begin: Beginning, arc: Arc) -> Node:
        """A fold, a flip, a pair on the unit circle, a branch point: the curve goes on there."""
        sample, curve, order = arc.samples[-1], begin.curve, begin.order
        single = sample.orbit if begin.is_crossing else once(sample.orbit, self.problem)
        halved = len(single.x) < len(sample.orbit.x)  # cycles of twice the period come to its flip
        kind = PointKind.PD if halved else PointKind[arc.stop.name]
        node = self._known(single, kind)
        if node is not None:
            node.waiting = [each for each in node.waiting if not _is_back(each, arc)]
            return node
        node = Node(kind, single, len(single.x) if halved else order, precision=arc.precision)
        self.nodes.append(node)
        if not halved and arc.beyond is not None:
            node.waiting.append(Beginning(order, curve, arc.beyond, sample))
        for wanted, start in self._others(begin, arc, single, halved):
            found = curve.advance(start, AWAY) if wanted in self.orders else None
            if found is not None:
                node.waiting.append(Beginning(wanted, curve, found, start))
        self.todo += [(node, each) for each in node.waiting]
        return node

    @staticmethod
    def _others(
        begin: Beginning, arc: Arc, single: Orbit, halved: bool
    ) -> list[tuple[int, Sample]]:
        """Other curves through a point where a multiplier is 1 or -1: orders, and which way."""
        sample, curve = arc.samples[-1], begin.curve
        orbit, order, size = sample.orbit, begin.order, sample.orbit.x.size
        if halved:
            along = curve.start(single).tangent
            return [(len(single.x), Sample(single, sign * along)) for sign in (1.0, -1.0)]
        if arc.stop is Stop.PD and not begin.is_crossing:
            pieces = [image.piece for image in orbit.images] * 2
            twice = orbit_of(pieces, np.tile(orbit.x, (2, 1)), orbit.p)
            along = np.append(np.tile(sample.tangent[:size], 2), sample.tangent[size:])
            return [(2 * order, Sample(twice, other_direction(curve.problem, twice, along)))]
        if arc.stop is Stop.BP:
            across = other_direction(curve.problem, orbit, sample.tangent)
            return [(order, Sample(orbit, sign * across)) for sign in (1.0, -1.0)]
        return []

    def _known(self, cycle: Orbit, kind: PointKind) -> Node | None:
        """The special point of a kind that lies at a cycle, if there is one."""
        scale = self.problem.scale(cycle)
        for node in self.nodes:
            if node.kind is kind and node.orbit.unknowns.shape == cycle.unknowns.shape:
                turns = (cycle.rotated(first).unknowns for first in range(len(cycle.x)))
                if any(np.abs((t - node.orbit.unknowns) / scale).max() <= NODE for t in turns):
                    return node
        return None

    # --- The result -------------------------------------------------------------------------------

    def result(self, names: Sequence[str]) -> Connected:
        """All that was found: a branch, and an end of it, for each point of a cycle."""
        places: list[_Place] = []
        branches: list[Branch] = []
        letters: Counter[str] = Counter()
        for trace, first in self.branches:
            samples = trace.samples
            for column in range(1 if trace.begin.is_crossing else trace.begin.order):
                letter = "J" if trace.begin.is_crossing else "F"
                letters[letter] += 1
                name = f"{letter}{letters[letter]}"
                ends = [
                    self._place(places, node, sample.orbit.x[column])
                    for node, sample in ((first, samples[0]), (trace.end, samples[-1]))
                ]
                for end in ends:
                    end.branches.append(name)
                ids = ends[0].id, ends[1].id
                branches.append(self._branch(name, trace, ids, column, names))
        diagram = Diagram(
            parameter_name=names[0], x_name=names[1], branches=tuple(branches),
            points=tuple(self._point(place) for place in places),
        )  # fmt: skip
        return Connected(diagram, {place.id: place.node.orbit for place in places})

    def _place(self, places: list[_Place], node: Node, x: Floats) -> _Place:
        """The point of a node at some x: that of a cycle has one for each of its points."""
        for each in places:
            if each.node is node and self.problem.same(each.x, x, NODE):
                return each
        kind, note = (node.kind, node.note) if not node.starts else judged(node.starts, node.order, x, self.problem)
        count = sum(each.kind is kind for each in places) + 1
        places.append(_Place(node, x, kind, note, f"{kind.value}{count}"))
        return places[-1]

    def _point(self, place: _Place) -> SpecialPoint:
        node = place.node
        p = float(node.orbit.p[self.problem.free[0]])
        away = node.precision
        given_up = node.waiting and node.status is PointStatus.LOCATED
        return SpecialPoint(
            id=place.id, kind=place.kind, parameter=p, x=float(place.x[0]),
            branches=tuple(dict.fromkeys(place.branches)), order=node.order,
            note=place.note + (", branches are left to follow" if given_up else ""),
            cause=node.cause, precision=away, status=node.status,
            interval=(p - away, p + away) if math.isfinite(away) else None,
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
        words = trace.words
        return Branch(
            id=name, kind=BranchKind.JUMP if begin.is_crossing else BranchKind.FIXED_POINT,
            order=begin.order, word=words[0].word, words=tuple(words), multiplier=multiplier,
            parameter=np.array([orbit.p[self.problem.free[0]] for orbit in orbits]),
            x=at[:, 0], ends=ends,
            columns={name: at[:, j] for j, name in enumerate(names[2:], 1)},
        )  # fmt: skip


@dataclass(eq=False)
class _Place:
    """A point of the diagram under construction."""

    node: Node
    x: Floats
    kind: PointKind
    note: str
    id: str
    branches: list[str] = field(default_factory=list)


def _key_at_end(begin: Beginning, arc: Arc) -> object:
    """What tells a curve that has come to a point from others that start there."""
    return replace(begin, sample=arc.samples[-1]).key


def _cause(arc: Arc) -> str:
    """What happens where an arc ends at a border; empty if it ends elsewhere."""
    if arc.stop not in (Stop.BORDER, Stop.SHARE):
        return ""
    image, code = arc.border or min(arc.curve.ignored)
    return arc.samples[-1].orbit.taken[image].piece.cause(code)


def _is_back(begin: Beginning, arc: Arc) -> bool:
    """Whether a curve that starts at a point is the one that an arc has come along."""
    if begin.before is None or begin.sample.orbit.x.shape != arc.samples[-1].orbit.x.shape:
        return False
    away = begin.curve.problem.step_between(begin.before.orbit, begin.sample.orbit)
    return float(away @ arc.samples[-1].tangent) < -ALONG * float(np.linalg.norm(away))
