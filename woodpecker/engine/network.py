"""Branches and the points where they meet: from one cycle to all that is connected with it.

No branch is met in its middle, as there are no slices: what starts at a special point is known if a
branch has arrived along it, which its pieces tell, or at a fold or flip its direction.
"""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from pwmap.diagrams.diagram import (
    Branch,
    BranchKind,
    Diagram,
    PointKind,
    PointStatus,
    SpecialPoint,
    Stretch,
)
from pwmap.diagrams.shown import counted
from woodpecker.base.arrays import Floats, norm
from woodpecker.base.checks import function, iterates, real_array, whole
from woodpecker.base.progress import Progress, Stage
from woodpecker.base.shown import shown
from woodpecker.engine.arrivals import Arrival
from woodpecker.engine.curves import CurveSettings, Sample, SolutionCurve
from woodpecker.engine.germs import Beginning, beginnings, judged, once
from woodpecker.engine.maps import SpaceMap
from woodpecker.engine.newton import STEEP, Problem, solve
from woodpecker.engine.orbits import Held, SpaceOrbit, orbit_of
from woodpecker.engine.tracing import Trace, switched, trace

MULTIPLIERS = (PointKind.LP, PointKind.PD, PointKind.NS, PointKind.BP)
NODE = 1e-7  # scaled: special points closer than this are one
LETTERS = {BranchKind.FIXED_POINT: "F", BranchKind.JUMP: "J"}  # of names of branches
DEPENDENT = 2.0**-40  # of the largest singular value: a smaller one is zero but for rounding
ALL_SAMPLES = 20  # times those of an arc: so many of all branches together
ALONG = 0.9  # cosine of the angle within which two curves leave a point the same way


@dataclass(frozen=True, slots=True, eq=False)
class Connected:
    """All branches that are connected with a cycle.

    Attributes
    ----------
    diagram
        A branch of cycles, and a special point, stands once for each point of the cycle.
    orbits
        By the id of a special point, the orbit there: a curve in two parameters starts from it.
    """

    diagram: Diagram
    orbits: Mapping[str, SpaceOrbit]

    def __repr__(self) -> str:
        return f"Connected({self.diagram!r})"


def connected(
    map_: SpaceMap, x: npt.ArrayLike, p: npt.ArrayLike, settings: CurveSettings, *,
    orders: Sequence[int] = (1, 2), free: int = 0, x_scale: Sequence[float] | None = None,
    p_scale: Sequence[float] | None = None, names: Sequence[str] = ("p", "x"),
    max_branches: int = 500, progress: Progress | None = None,
    on_interrupt: Callable[[], None] | None = None,
) -> Connected:  # fmt: skip
    """The branch through a cycle, and all branches that are connected with it.

    Cycles and jump crossings start where a cycle meets a border, cycles of twice the period at
    flips, others at branch points.

    Parameters
    ----------
    map_
        A map of R^d.
    x, p
        A guess of a cycle's points, (n, d), or (d,) for a fixed point; and the parameters (k,). It
        is followed with its minimal period.
    settings
        Span, window, steps.
    orders
        Iterates whose cycles and jump crossings are followed.
    free
        Which parameter varies, from 0 on.
    x_scale, p_scale
        d and k lengths that count as 1; by default those of the window and the span.
    names
        Of the parameter and the coordinates, at least the first; that is the diagram's x, the
        others are columns of its branches.
    max_branches
        So many are followed at most; ``diagram.given`` says how many more begin.
    progress
        Called before the first branch, and with each finished one.
    on_interrupt
        Called at Ctrl-C; what is finished is then returned. By default ``KeyboardInterrupt`` is
        raised.

    Returns
    -------
    Connected
        The multiplier of a branch is its largest one, of a complex pair the modulus.

    Raises
    ------
    ValueError
        If an argument does not fit the map, Newton's method finds no cycle of it near the guess, or
        that lies outside.
    TypeError
        If ``progress`` or ``on_interrupt`` cannot be called.

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
    points, values = np.atleast_2d(real_array("x", x)), np.atleast_1d(real_array("p", p))
    if points.ndim != 2 or values.ndim != 1 or not points.size:
        raise ValueError(
            f"x must have shape (n, d) and p (k,), got {points.shape} and {values.shape}"
        )
    d, k = points.shape[1], len(values)
    wanted = iterates(orders)
    if whole("free", free, 0) >= k:
        raise ValueError(f"free must name one of {k} parameters, from 0 on, got {free}")
    named = not isinstance(names, str) and all(isinstance(each, str) for each in names)
    if not named or not 2 <= len(names) <= d + 1:
        raise ValueError(
            f"names must be 2 to {d + 1} names, of the parameter and the coordinates, got "
            f"{shown(names)}"
        )
    most = whole("max_branches", max_branches)
    function("progress", progress)
    function("on_interrupt", on_interrupt)
    if len(settings.window) != d or len(settings.spans) != 1:
        raise ValueError(
            f"expected a window of {d} intervals and one span, got {len(settings.window)} and "
            f"{len(settings.spans)}"
        )
    problem = settings.cycles((free,), k, x_scale, p_scale)
    own, columns = map_.at(points[0], values).piece.at(points[0], values).jacobian.shape
    if (own, columns) != (d, d + k):
        raise ValueError(
            f"the map has {counted(own, 'coordinate')} and {counted(columns - own, 'parameter')}, "
            f"got points of {d} and {k} values"
        )
    start = once(cycle_near(map_, points, values, problem), problem)
    settings.check_holds(values[free : free + 1], start.x)
    component = _Component(SolutionCurve(map_, problem, settings), wanted, most, progress)
    try:
        component.explore(start)
    except KeyboardInterrupt:
        if on_interrupt is None or not component.branches:
            raise
        on_interrupt()
    return component.result(names)


def cycle_near(map_: SpaceMap, x: Floats, p: Floats, problem: Problem) -> SpaceOrbit:
    """The cycle near a guess (n, d), by Newton's method; ValueError if none, or of other pieces."""
    guess = orbit_of([map_.at(point, p).piece for point in x], x, p)
    held = [Held(x.size + k, float(p[k])) for k in problem.free]
    solution = solve(problem.with_(*held), guess)
    orbit = solution.orbit
    if guess.is_defined and _are_dependent(problem, orbit):
        raise ValueError(
            f"no single branch leads through the cycle near {x.tolist()} at p = {p}: cycles fill a "
            "line or more there at one value of the parameter, or branches cross"
        )
    if not solution.converged:
        raise ValueError(f"no cycle of {len(x)} points was found near {x.tolist()} at p = {p}")
    if [map_.at(point, p).piece.key for point in orbit.x] != list(orbit.keys):
        raise ValueError(f"the cycle near {x.tolist()} is virtual: a point lies in another piece")
    return orbit


def _are_dependent(problem: Problem, cycle: SpaceOrbit) -> bool:
    """Whether the equations of a cycle are linearly dependent, with the parameter free, too."""
    rows = problem.matrix(cycle) / np.tile(problem.x_scale, len(cycle.x))[:, None]
    sizes = np.linalg.svd(rows, compute_uv=False)
    return bool(sizes[-1] <= DEPENDENT * max(1.0, sizes[0]))


@dataclass(eq=False)
class _Vertex:
    """What branches have come to, all points of a cycle together."""

    arrival: Arrival
    order: int
    starts: tuple[Beginning, ...]  # at a border: all curves that start there
    waiting: list[Beginning]  # those that are still to be followed
    # of the diagram, one for each point of the cycle that branches end in
    points: list[tuple[Floats, SpecialPoint]] = field(default_factory=list)

    @property
    def orbit(self) -> SpaceOrbit:
        """The cycle, run through once."""
        return self.arrival.orbit


class _Component:
    """What has been found: special points, branches, and what is left to follow."""

    def __init__(
        self, base: SolutionCurve, orders: tuple[int, ...], max_branches: int,
        progress: Progress | None,
    ) -> None:  # fmt: skip
        self.base, self.map, self.problem, self.orders = base, base.map, base.problem, orders
        self.max_branches, self.progress = max_branches, progress
        self.nodes: list[_Vertex] = []
        self.branches: list[tuple[Trace, _Vertex, _Vertex]] = []  # where they begin and end, too
        self.todo: deque[tuple[_Vertex, Beginning]] = deque()

    def explore(self, start: SpaceOrbit) -> None:
        """Follow the branch through a cycle to a special point, then what starts at its ends."""
        self._tell(start, len(start.x))
        first = self.base.start(start)
        ahead = trace(Beginning(len(start.x), self.base, first), self.orders)
        end = self._arrive(ahead)
        # What led there began in the middle of the branch, which is followed from this end instead.
        back = Beginning(len(start.x), ahead.curve, ahead.samples[-1].turned)
        end.waiting.insert(0, back)
        self.todo.appendleft((end, back))
        while self.todo and len(self.branches) < self.max_branches and not self.is_spent:
            node, begin = self.todo.popleft()
            if begin in node.waiting:  # else a branch has arrived along it
                node.waiting.remove(begin)
                try:
                    found = trace(begin, self.orders)
                    self.branches.append((found, node, self._arrive(found)))
                except KeyboardInterrupt:
                    node.waiting.append(begin)
                    self.todo.appendleft((node, begin))
                    raise
                self._tell(found.samples[-1].orbit, begin.order)

    @property
    def is_spent(self) -> bool:
        """Whether there are as many samples as allowed; each takes some five evaluations."""
        count = sum(len(found.samples) for found, *_ in self.branches)
        return count >= ALL_SAMPLES * self.base.settings.max_samples

    def _tell(self, orbit: SpaceOrbit, order: int) -> None:
        if self.progress is not None:
            p = float(orbit.p[self.problem.free[0]])
            self.progress(Stage(p, order, 0, len(self.branches)))

    # --- Ends of branches -------------------------------------------------------------------------

    def _arrive(self, found: Trace) -> _Vertex:
        """The point where a branch ends; what else starts there is left to follow."""
        arrival = found.arrival
        if arrival.collides:
            return self._at_border(found, arrival)
        if arrival.kind in MULTIPLIERS:
            return self._at_multiplier(found, arrival)
        return self._new(arrival, found.begin.order)

    def _at_border(self, found: Trace, arrival: Arrival) -> _Vertex:
        """The border collision of a cycle, where a branch ends."""
        cycle = arrival.orbit
        node, order = self._known(cycle, PointKind.BC), len(cycle.x)
        if node is None:
            wanted = sorted({*self.orders, order, 2 * order})
            starts = tuple(beginnings(self.base, cycle.x, cycle.p, wanted))
            node = self._new(arrival, order, self._wanted(starts), starts)
        arrived = found.arrived.key
        node.waiting = [each for each in node.waiting if each.key != arrived]
        return node

    def _at_multiplier(self, found: Trace, arrival: Arrival) -> _Vertex:
        """A fold, a flip, a pair on the unit circle, a branch point: the curve goes on there."""
        begin, last = found.begin, found.samples[-1]
        single = arrival.orbit
        halved = len(single.x) < len(last.orbit.x)
        node = self._known(single, arrival.kind)
        if node is not None:
            node.waiting = [each for each in node.waiting if not _is_back(each, last)]
            return node
        others = switched(found.curve, single, arrival.kind, begin.order)
        if arrival.kind is PointKind.BP:  # two of the four are this branch
            others = _most_across(others, last)
        onward = [] if arrival.onward is None else [arrival.onward]
        order = len(single.x) if halved else begin.order
        return self._new(arrival, order, [*onward, *self._wanted(others)])

    def _wanted(self, begins: Sequence[Beginning]) -> list[Beginning]:
        return [each for each in begins if each.order in self.orders]

    def _new(
        self, arrival: Arrival, order: int, waiting: Sequence[Beginning] = (),
        starts: Sequence[Beginning] = (),
    ) -> _Vertex:  # fmt: skip
        """A special point that was not met before."""
        node = _Vertex(arrival, order, tuple(starts), list(waiting))
        self.nodes.append(node)
        self.todo += [(node, each) for each in waiting]
        return node

    def _known(self, cycle: SpaceOrbit, kind: PointKind) -> _Vertex | None:
        scale = self.problem.scale(cycle)
        for node in self.nodes:
            if node.arrival.kind is kind and node.orbit.unknowns.shape == cycle.unknowns.shape:
                turns = (cycle.rotated(first).unknowns for first in range(len(cycle.x)))
                if any(np.abs((t - node.orbit.unknowns) / scale).max() <= NODE for t in turns):
                    return node
        return None

    # --- The result -------------------------------------------------------------------------------

    def result(self, names: Sequence[str]) -> Connected:
        """All that was found: a branch, and an end of it, for each point of a cycle."""
        points, orbits, branches = list[SpecialPoint](), dict[str, SpaceOrbit](), list[Branch]()
        for found, *nodes in self.branches:
            for column in range(1 if found.begin.is_crossing else found.begin.order):
                ends = list[str]()
                for node, sample in zip(nodes, (found.samples[0], found.samples[-1]), strict=True):
                    point = self._point(node, sample.orbit.x[column], points)
                    orbits[point.id] = self._smoothest(node)
                    ends.append(point.id)
                branches.append(self._branch(found, (ends[0], ends[1]), column, names))
        diagram = diagram_of(
            branches, points, parameter_name=names[0], x_name=names[1], given=self._left()
        )
        ids = (point.id for point in diagram.points)
        return Connected(diagram, dict(zip(ids, orbits.values(), strict=True)))

    def _smoothest(self, node: _Vertex) -> SpaceOrbit:
        """The cycle at a point; where it ends in a root, as that of smooth pieces, if it is one."""

        def steepest(orbit: SpaceOrbit) -> float:
            return max(map(self.problem.steepest, orbit.images))

        if not steepest(node.orbit) > STEEP:
            return node.orbit
        starts = [each for each in node.starts if each.before is None and not each.is_crossing]
        others = [each.sample.orbit for each in starts if each.order == len(node.orbit.x)]
        return min([node.orbit, *others], key=steepest)

    def _left(self) -> tuple[str, ...]:
        """A sentence on what was not followed, if anything was not."""
        left = sum(begin in node.waiting for node, begin in self.todo)
        done = len(self.branches)
        most = " with as many samples as allowed" if self.is_spent else ""
        text = f"stopped after {counted(done, 'branch')}{most}: {left} more begin"
        return (text,) if left else ()

    def _point(self, node: _Vertex, x: Floats, points: list[SpecialPoint]) -> SpecialPoint:
        """The point of a node at some x; a new one is put to the others."""
        for at, point in node.points:
            if self.problem.same(at, x, NODE):
                return point
        arrival = node.arrival
        kind, note = arrival.kind, arrival.note
        if arrival.collides:
            nearest = int(np.abs((node.orbit.x - x) / self.problem.x_scale).max(axis=1).argmin())
            kind, note = judged(node.starts, node.orbit.x, nearest, self.problem)
        given_up = node.waiting and arrival.status is PointStatus.LOCATED
        points.append(SpecialPoint(
            id=f"point {len(points)}", kind=kind, order=node.order, x=float(x[0]),
            parameter=float(node.orbit.p[self.problem.free[0]]),
            note=note + (", branches are left to follow" if given_up else ""),
            cause=arrival.cause, precision=arrival.precision, status=arrival.status,
        ))  # fmt: skip
        node.points.append((x, points[-1]))
        return points[-1]

    def _branch(
        self, found: Trace, ends: tuple[str, str], column: int, names: Sequence[str]
    ) -> Branch:
        begin, orbits = found.begin, [sample.orbit for sample in found.samples]
        at = np.array([orbit.x[column] for orbit in orbits])
        multiplier = np.full(len(orbits), np.nan)
        if not begin.is_crossing:
            largest = [orbit.multipliers()[0] for orbit in orbits]
            multiplier = np.array([abs(m) if m.imag else m.real for m in largest])
        words = _words(found)
        return Branch(
            id=begin.kind.value, kind=begin.kind, order=begin.order,
            word=words[0].word, words=tuple(words),
            parameter=np.array([orbit.p[self.problem.free[0]] for orbit in orbits]),
            x=at[:, 0], multiplier=multiplier, ends=ends,
            columns={name: at[:, j] for j, name in enumerate(names[2:], 1)},
        )  # fmt: skip


def diagram_of(branches: Sequence[Branch], points: Sequence[SpecialPoint], **about: Any) -> Diagram:
    """A diagram of branches and points, which are numbered by their kinds in turn.

    Until then branches end in points by provisional ids. Points have their branches from these, and
    an interval from their precision.
    """
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


def _words(found: Trace) -> list[Stretch]:
    """Where the words of a branch begin, at a border, with what happens there."""
    stretches = [Stretch(0, found.begin.sample.orbit.word)]
    for change in found.changes:
        first, beyond = max(change.sample, 1), change.sample + 1
        if beyond < len(found.samples):
            if stretches[-1].first == first:  # two changes within a step: it has the last word
                stretches.pop()
            stretches.append(Stretch(first, found.samples[beyond].orbit.word, change.cause))
    return stretches


def _most_across(begins: Sequence[Beginning], last: Sample) -> list[Beginning]:
    """Those of some curves through a branch point that another curve does not lead along."""
    ways = [(each.before or each.sample).tangent for each in begins]
    along = [abs(float(way @ last.tangent)) for way in ways]
    return [each for each, cosine in zip(begins, along, strict=True) if cosine == min(along)]


def _is_back(begin: Beginning, last: Sample) -> bool:
    """Whether a curve that starts at a point is the one that a branch has come along."""
    if begin.before is None or begin.sample.orbit.x.shape != last.orbit.x.shape:
        return False
    away = begin.curve.problem.step_between(begin.before.orbit, begin.sample.orbit)
    return float(away @ last.tangent) < -ALONG * norm(away)
