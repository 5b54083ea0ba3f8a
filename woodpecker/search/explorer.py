"""The loop of a search: branches are followed, then all branches that start at their ends.

A place is an orbit that a branch may pass through: a slice shows it, or it lies beside a special
point. If no branch explains it (:class:`Duplicates`), a task follows the branch there, and then
those that continue it (:class:`Tasks`). The network stores them (:class:`Network`); their ends wait
for their turn, collisions first, then flips and branch points.

The scheduler may begin likely tasks early, but branches are followed in turn, so that the result
does not depend on the number of workers.
"""

from __future__ import annotations

import math
import os
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pwmap.diagrams.diagram import BranchKind, Diagram
from pwmap.diagrams.record import LEFT_OUT_KEY
from pwmap.diagrams.shown import counted
from woodpecker.base.executors import Call, Scheduler
from woodpecker.base.progress import Report
from woodpecker.base.progress import Stage as Stage
from woodpecker.engine.newton import Problem
from woodpecker.engine.orbits import SpaceOrbit
from woodpecker.search.checkpoint import Finished, Kept, Record, Seen, Step, restore
from woodpecker.search.curves import (
    BranchCurve,
    End,
    Followed,
    Keys,
    Start,
    keys_of,
    keys_of_jump,
    orbit_and_problem,
    up_to_border,
)
from woodpecker.search.duplicates import Duplicates
from woodpecker.search.network import Network
from woodpecker.search.tasks import Tasks
from woodpecker.slices.jumps import Jump
from woodpecker.slices.orbits import Orbit, to_engine
from woodpecker.slices.slices import Slice

ON_EDGE = 2.0**-44  # scaled: rounding may put a point at an end of the window so far outside
BOUNDS = (  # what a search counts, and which setting bounds it
    ("evaluation", "max_evaluations"),
    ("branch", "max_branches"),
    ("sample", "20 times max_samples"),
)


@dataclass(slots=True, eq=False)
class _Place:
    """An orbit that a branch may pass through, and the task that follows this branch."""

    kind: BranchKind
    order: int
    orbit: SpaceOrbit
    problem: Problem  # the equations of the orbit
    keys: Keys
    call: Call
    unexplained_by: int = -1  # so many of the first branches do not pass through it
    is_explained: bool = False


class Explorer:
    """Follows branches, and those that start at their ends, by tasks of a scheduler."""

    def __init__(
        self, tasks: Tasks, orders: Sequence[int], progress: Report | None = None,
        record: Record | None = None, *, scheduler: Scheduler | None = None,
        max_branches: float = math.inf, max_samples: float = math.inf,
    ) -> None:  # fmt: skip
        self.base, self.orders = tasks.base, tuple(orders)
        self.scheduler = scheduler or Scheduler(tasks)
        self.progress, self.record, self.seen = progress, record, list[Seen]()
        self.network, self.slices = Network(tasks.settings, self.base.problem), 0
        self.evaluations, self.spent = 0, 0  # of this run; of this and earlier ones
        self.untaken = 0  # planned slices that were not taken
        self._most = tasks.settings.of_search(self.orders), max_branches, max_samples
        self.coming: Sequence[float] = ()  # where the next slices will be taken
        self._known = {
            (kind, order): Duplicates(self.network, kind, order, self.base)
            for kind in (BranchKind.FIXED_POINT, BranchKind.JUMP)
            for order in self.orders
        }
        self._legs = deque[Call]()  # tasks left of the branch that is being followed
        self._starting: dict[int, _Place] = {}  # places of branches that start at waiting points
        self._turns = list[deque[_Place]]()  # places whose turn comes next, innermost list last
        self._met: End | None = None  # the special point whose turn it is
        self._switches = False  # whether flips and branch points are followed by now
        self._past = deque[Step | Seen]()  # records of an interrupted run to be taken over
        if record is not None:
            self.resume(record.entries, record.path)

    def resume(self, past: Sequence[Step | Seen], path: str | os.PathLike[str]) -> None:
        """Resume an interrupted run; ValueError if its records do not follow from one another."""
        # Records after its last slice are taken over in their turn: the search makes the same
        # decisions in the same order, with the same branches known.
        until = max((n for n, each in enumerate(past, 1) if isinstance(each, Seen)), default=0)
        restore(self.network, past[:until], path)
        self.seen += [each for each in past if isinstance(each, Seen)]
        self.spent = sum(each.evaluations for each in past[:until])
        self._past.extend(past[until:])

    @property
    def is_spent(self) -> bool:
        """Whether the search has reached one of its bounds."""
        return any(n >= most for n, most in zip(self._done, self._most, strict=True))

    @property
    def _done(self) -> tuple[int, int, int]:
        """The numbers of evaluations, branches and samples so far, as in ``BOUNDS``."""
        return self.spent, len(self.network.curves), self.network.samples

    @property
    def left(self) -> str:
        """A sentence on what was left at a bound of the search or an interruption; else empty."""
        points, legs = len(self.network.waiting) + len(self.network.switches), len(self._legs)
        reached = [
            f"given up after {counted(int(most), what)}, as many as allowed ({name})"
            for n, most, (what, name) in zip(self._done, self._most, BOUNDS, strict=True)
            if n >= most
        ]
        if not (points or legs or (reached and self.slices)):
            return ""
        parts = [f"{counted(points, 'special point')} not followed further"]
        parts += [f"{counted(legs, 'branch')} not followed to the end"] if legs else []
        parts += [f"{counted(self.untaken, 'slice')} not taken"] if self.slices else []
        return f"{(*reached, 'interrupted')[0]}: {', '.join(parts)}"

    def diagram(self, parameter_name: str, *x_names: str) -> Diagram:
        """The diagram of everything found so far; its ``about`` says what was left."""
        found = self.network.diagram(parameter_name, x_names)
        if not self.left:
            return found
        return replace(found, about={**found.about, LEFT_OUT_KEY: self.left})

    def follow(self, orbit: SpaceOrbit) -> None:
        """Follow the branch through a cycle, and all branches that start at its ends, in turn."""
        self.branch(orbit)
        self.finish()

    def branch(self, orbit: SpaceOrbit) -> None:
        """Follow the branch through a cycle, and those that continue it beyond its ends."""
        self._report(float(orbit.p[self.base.problem.free[0]]), len(orbit.x))
        self._follow_and_store(Tasks.cycle, orbit)

    def follow_collisions(self) -> None:
        """Follow all branches that start at border collisions met so far."""
        waiting = self.network.waiting
        while waiting and not self.is_spent:
            self._finish_one(waiting)

    def finish(self) -> None:
        """Follow all branches that start at collisions, then at flips and branch points."""
        self.follow_collisions()
        switches, self._switches = self.network.switches, True
        while switches and not self.is_spent:
            self._finish_one(switches)
            self.follow_collisions()
        self._switches = False

    def take_slice(self, p: float) -> Seen:
        """Take slices of all orders at a parameter, and follow what no branch explains."""
        self.slices = len(self.seen) + 1
        self._report(p, max(self.orders))
        self.scheduler.expect(self._likely())
        done = self.scheduler.result(Tasks.slice, p, self.orders)
        new, left = list[int](), list[tuple[int, float]]()
        known = len(self.network.curves)
        for place in self._in_turn(place for each in done.value for place in self._shown(each)):
            if self.is_spent:
                if self._is_new(place):
                    left.append((place.order, float(place.orbit.x[0, 0])))
                continue
            if not self._follow(place):
                continue
            self.follow_collisions()
            grown = self.network.curves[known:]
            known += len(grown)
            new += [curve.order for curve in grown]
            if grown and self._is_new(place):  # a branch was followed, but misses the place
                left.append((place.order, float(place.orbit.x[0, 0])))
        unresolved = max(each.unresolved for each in done.value)
        return Seen(p, tuple(sorted(set(new))), unresolved, tuple(left), done.evaluations)

    def store_slice(self, found: Seen) -> None:
        """Store a slice from which everything was followed."""
        self.seen.append(found)
        self.evaluations += found.evaluations
        self.spent += found.evaluations
        if self.record is not None:
            self.record.seen(found)

    # --- In turn ----------------------------------------------------------------------------------

    def _follow_all(self, met: End) -> tuple[int, int]:
        """Follow what starts at a special point; how many branches, and the cost to find them."""
        before = self.spent
        starts = self._value(Tasks.starts, met, self.orders)
        cost, places = self.spent - before, list(self._inside(starts))
        for place in self._in_turn(places):
            if self.is_spent:
                break
            self._follow(place)
        return len(places), cost

    def _in_turn(self, places: Iterable[_Place]) -> Iterator[_Place]:
        """Yield places in turn; meanwhile the scheduler may begin tasks of those that are left."""
        left = deque(places)
        self._turns.append(left)
        while left:
            yield left.popleft()
        self._turns.remove(left)

    def _finish_one(self, queue: deque[End]) -> None:
        """Follow what starts at the first point of a queue, which stays there if a bound is met."""
        self._met = met = queue[0]
        if not self._take_over_point(met):
            starts, cost = (0, 0) if self.network.is_switched(met) else self._follow_all(met)
            if self.is_spent:
                return
            if self.record is not None:
                self.record.done(met, starts, cost)
        queue.popleft()
        self._starting = {}

    def _take_over_point(self, met: End) -> bool:
        """Take over all that starts at a special point if the interrupted run has finished it."""
        if not any(isinstance(step, Finished) for step in self._past):
            return False
        while not isinstance(self._past[0], Finished):
            self._take_over_curves()
        finished = self._past.popleft()
        assert isinstance(finished, Finished)
        if finished.p != met.p:
            raise ValueError(f"expected a run that goes on at {met.p}, got one with {finished}")
        self.spent += finished.evaluations
        return True

    def _take_over_curves(self) -> bool:
        """Take over the next curves of an interrupted run; False if none are left."""
        if not self._past:
            return False
        kept = self._past.popleft()
        if not isinstance(kept, Kept):
            raise ValueError(f"expected a run with one branch more, got one with {kept}")
        self.spent += kept.evaluations
        for curve in kept.curves:
            self.network.add(curve)
        return True

    def _follow(self, place: _Place) -> bool:
        """Follow the branch through a place unless one explains it; whether that was done."""
        if not self._is_new(place):
            return False
        self._follow_and_store(*place.call)
        return True

    def _follow_and_store(self, *call: Any) -> None:
        """Follow and store a branch and those that continue it, until one is known already."""
        if self._take_over_curves():
            return
        # Each is followed to its end before it is compared: right beyond a sharp fold it looks like
        # the branch that led there.
        kept, points, before = list[BranchCurve](), list[BranchCurve](), self.spent
        todo = self._legs = deque[Call]([call])
        while todo and not self.is_spent:  # it ends, as each leg counts towards the bounds
            found: Followed | None = self._value(*todo[0], beside=[*todo][1:])
            todo.popleft()
            if found is None or self._is_dropped(found.curve, points):
                continue
            curve = found.curve
            kept.append(curve)
            self.network.add(curve)
            if self.network.is_a_point(curve):
                points.append(curve)
            else:
                self._report(curve.ends[1].p, curve.order)
            todo += _onward(found)
        if self.record is not None:
            self.record.followed(kept, self.spent - before)

    def _value(self, *call: Any, beside: Iterable[Call] = ()) -> Any:
        """The result of a task, with its evaluations counted; likely tasks may begin meanwhile."""
        self.scheduler.expect(self._likely(beside))
        done = self.scheduler.result(*call)
        self.evaluations += done.evaluations
        self.spent += done.evaluations
        return done.value

    def _report(self, p: float, order: int) -> None:
        if self.progress is not None:
            self.progress(Stage(p, order, self.slices, len(self.network.drawn)))

    def _is_dropped(self, curve: BranchCurve, points: Sequence[BranchCurve] = ()) -> bool:
        """Whether a branch is a duplicate, not of the wanted orders, or not inside the window."""
        return (
            curve.order not in self.orders
            or self.network.is_outside(curve)
            or self.network.has(curve, points)
        )

    def _is_new(self, place: _Place) -> bool:
        """Whether no branch found so far passes through a place."""
        curves = len(self.network.curves)
        if not place.is_explained and place.unexplained_by < curves:
            known = self._known[place.kind, place.order]
            place.is_explained = known.explains(place.orbit, place.problem, place.keys)
            place.unexplained_by = curves
        return not place.is_explained

    def _inside(self, starts: Iterable[Start]) -> Iterator[_Place]:
        """The places of branches that start within the span, with all points in the window."""
        (low, high), column = self.base.settings.spans[0], self.base.problem.free[0]
        bottom, top = np.array(self.base.settings.window).T
        slack = ON_EDGE * self.network.x_scale
        for start in starts:
            orbit = start[0].sample.orbit
            is_seen = (bottom - slack <= orbit.x).all() and (orbit.x <= top + slack).all()
            if is_seen and low <= orbit.p[column] <= high:
                if id(start) not in self._starting:
                    self._starting[id(start)] = self._of_start(start)
                yield self._starting[id(start)]

    # --- Places -----------------------------------------------------------------------------------

    def _shown(self, by: Slice) -> Iterator[_Place]:
        yield from map(self._of_cycle, by.cycles)
        yield from map(self._of_jump, by.jumps)

    def _of_cycle(self, found: Orbit) -> _Place:
        orbit, n = to_engine(found), len(found)
        call = Tasks.cycle, orbit
        return _Place(BranchKind.FIXED_POINT, n, orbit, self.base.problem, orbit.keys, call)

    def _of_jump(self, jump: Jump) -> _Place:
        problem = up_to_border(self.base.problem, len(jump.head), jump.code)
        head, keys = to_engine(jump.head), keys_of_jump(jump)
        return _Place(BranchKind.JUMP, jump.order, head, problem, keys, (Tasks.jump, jump))

    def _of_start(self, start: Start) -> _Place:
        begin, _ = start
        orbit, problem = orbit_and_problem(begin.curve, begin.sample.orbit)
        keys = keys_of(begin.sample.orbit, begin.curve.problem)
        return _Place(begin.kind, begin.order, orbit, problem, keys, (Tasks.ahead, start))

    # --- Ahead ------------------------------------------------------------------------------------

    def _likely(self, legs: Iterable[Call] = ()) -> Iterator[Call]:
        """Tasks that are likely to be needed soon, the likeliest first."""
        for p in self.coming:
            yield Tasks.slice, p, self.orders
        for leg in legs:
            yield from self._beyond(leg)
        for left in reversed(self._turns):
            yield from self._new(left)
        for met in self._later():
            call = Tasks.starts, met, self.orders
            found = self.scheduler.peek(*call)
            if found is None:
                yield call
            else:
                yield from self._new(self._inside(found.value))

    def _new(self, places: Iterable[_Place]) -> Iterator[Call]:
        """Tasks of the branches through places that no branch explains so far."""
        # Jumps of a slice are left out: most lie on crossings that start where cycles end, which
        # are followed before.
        for each in places:
            if each.call[0] is not Tasks.jump and self._is_new(each):
                yield from self._beyond(each.call)

    def _beyond(self, leg: Call) -> Iterator[Call]:
        """A leg that is not followed yet; else those that continue it, unless it is a duplicate."""
        found = self.scheduler.peek(*leg)
        if found is None:
            yield leg
        elif not self._is_dropped(found.value.curve):
            for each in _onward(found.value):
                yield from self._beyond(each)

    def _later(self) -> Iterator[End]:
        """The special points whose turn comes later, in order."""
        for queue in (self.network.waiting, self.network.switches if self._switches else ()):
            for met in queue:
                if met is not self._met and not self.network.is_switched(met):
                    yield met


def _onward(found: Followed) -> Iterator[Call]:
    """The tasks that continue a branch beyond its ends."""
    return ((Tasks.ahead, start) for start in found.onward)
