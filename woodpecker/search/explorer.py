"""Everything that is connected: branches are followed with all that hangs on their ends.

Tasks are submitted some time before they are needed, and what was found meanwhile decides whether
they still are: so the result does not depend on who carries them out, or on how many do.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any, NamedTuple, Protocol

from pwmap.diagrams.diagram import BranchKind, Diagram
from pwmap.diagrams.shown import counted
from woodpecker.base.executors import Pending, Scheduler
from woodpecker.base.settings import Settings
from woodpecker.engine.orbits import Condition
from woodpecker.maps.pieces import PiecewiseMap
from woodpecker.search.curves import Curve, Followed, Start, keys_of
from woodpecker.search.duplicates import Known
from woodpecker.search.ends import Collision, End
from woodpecker.search.lines import closing_of
from woodpecker.search.lines import keys_of as keys_of_engine
from woodpecker.search.network import Network
from woodpecker.search.tasks import Tasks
from woodpecker.slices.jumps import Jump
from woodpecker.slices.orbits import CYCLE, Orbit, ending_at, of_engine
from woodpecker.slices.slices import Slice


class Stage(NamedTuple):
    """How far a search has come.

    Attributes
    ----------
    parameter, order
        Where a branch of P_order was followed to.
    slices
        How many were taken; 0 if none are.
    branches
        How many are known.

    Examples
    --------
    >>> from sympy import Piecewise, symbols
    >>> from woodpecker import Search, Settings, Stage, whole_diagram, from_sympy
    >>> x, p = symbols("x p")
    >>> formula = Piecewise((x/2 + p, x < 0), (x/3 + p - 1, True))
    >>> lines = from_sympy(formula, x, p, words=["L", "R"])
    >>> seen = []
    >>> settings = Settings(span=(-1, 2), window=(-3, 3))
    >>> found = whole_diagram(lines, settings, search=Search(slices=4), progress=seen.append)
    >>> seen[-1].branches, isinstance(seen[-1], Stage)
    (3, True)
    """

    parameter: float
    order: int
    slices: int
    branches: int


Progress = Callable[[Stage], None]
LEFT = "left"  # what a diagram says it was too costly for, by this name


class Seen(NamedTuple):
    """What a slice came to.

    Attributes
    ----------
    p
        Where it was taken.
    new
        Orders of the branches that were found from it.
    unresolved
        Total length of intervals in which there are more pieces than were looked for.
    left
        (order, x) of what it shows and no branch goes through, though one was followed from there.
    evaluations
        How often the map was evaluated for it.
    then
        Where more slices were called for after it.

    Examples
    --------
    >>> from sympy import Piecewise, symbols
    >>> from woodpecker import Search, Settings, whole_diagram, from_sympy
    >>> x, p = symbols("x p")
    >>> formula = Piecewise((x/2 + p, x < 0), (x/3 + p - 1, True))
    >>> lines = from_sympy(formula, x, p, words=["L", "R"])
    >>> settings = Settings(span=(-1, 2), window=(-3, 3))
    >>> found = whole_diagram(lines, settings, search=Search(slices=4))
    >>> [(seen.p, seen.new, seen.unresolved) for seen in found.slices][:2]
    [(-0.99925, (1,), 0), (1.99925, (), 0)]
    """

    p: float
    new: tuple[int, ...]
    unresolved: float
    left: tuple[tuple[int, float], ...]
    evaluations: int
    then: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Kept:
    """The curves that a task has come to, and how often it evaluated the map."""

    curves: tuple[Curve, ...]
    evaluations: int


@dataclass(frozen=True, slots=True)
class Finished:
    """All that starts at a special point was followed.

    Attributes
    ----------
    p
        Its parameter.
    evaluations
        How often the map was evaluated to know what starts there.
    """

    p: float
    evaluations: int


Step = Kept | Finished
"""What a run keeps between two slices."""


class Recorder(Protocol):
    """Keeps what is finished."""

    def followed(self, curves: Sequence[Curve], evaluations: int) -> None:
        """Keep the curves that a task has come to, and how often it evaluated the map."""

    def done(self, met: Collision | End, starts: int, evaluations: int) -> None:
        """Keep that all that starts at the next special point was followed, and how much does.

        And how often the map was evaluated to know that.
        """

    def seen(self, found: Seen) -> None:
        """Keep that all that a slice shows was followed."""


class _Place(NamedTuple):
    """An orbit that a branch may go through, and the task that follows it."""

    kind: BranchKind
    order: int
    orbit: Orbit
    closing: tuple[Condition, ...]
    keys: tuple[object, ...]
    task: Callable[..., Any]
    argument: object


def _of_cycle(orbit: Orbit) -> _Place:
    return _Place(BranchKind.FIXED_POINT, len(orbit), orbit, CYCLE, orbit.keys, Tasks.cycle, orbit)


def _of_jump(jump: Jump) -> _Place:
    keys = keys_of(jump)
    closing = ending_at(len(jump.head), jump.code)
    return _Place(BranchKind.JUMP, jump.order, jump.head, closing, keys, Tasks.jump, jump)


def _of_start(start: Start) -> _Place:
    begin = start.begin
    orbit = begin.sample.orbit
    kind = BranchKind.JUMP if begin.is_crossing else BranchKind.FIXED_POINT
    return _Place(
        kind, begin.order, of_engine(orbit), closing_of(begin.curve, orbit),
        keys_of_engine(orbit, begin.curve.problem), Tasks.ahead, start,
    )  # fmt: skip


def _shown(by: Slice) -> Iterator[_Place]:
    """What a slice shows."""
    yield from map(_of_cycle, by.cycles)
    yield from map(_of_jump, by.jumps)


class _Leg:
    """A part of a branch that is being followed, and those that continue it, once submitted."""

    def __init__(self, pending: Pending) -> None:
        self.pending = pending
        self.onward: list[_Leg] | None = None

    def cancel(self) -> None:
        """Give up the leg and all that continues it."""
        self.pending.cancel()
        self.give_up()

    def give_up(self) -> None:
        """Give up what continues the leg."""
        for each in self.onward or ():
            each.cancel()


class _Candidate:
    """A place, its first leg if that was submitted, and how many branches did not explain it."""

    def __init__(self, place: _Place) -> None:
        self.place = place
        self.leg: _Leg | None = None
        self.unexplained_by = -1


class _Start:
    """What starts at a special point: asked for, and then known."""

    def __init__(self, pending: Pending) -> None:
        self.pending = pending
        self.candidates: list[_Candidate] | None = None


class Explorer:
    """Follows branches, and what starts at their ends.

    Each is followed when its turn comes, one after the other. While a result is waited for, those
    whose turn comes later are submitted too, as long as somebody would have nothing to do.

    Parameters
    ----------
    map_
        The map.
    scheduler
        Where tasks are carried out.
    settings
        Scales.
    orders
        Iterates whose branches are kept.
    progress
        Called with every branch, and before every slice.
    recorder
        Keeps what is finished, if anybody does.
    """

    def __init__(
        self, map_: PiecewiseMap, scheduler: Scheduler, settings: Settings, orders: Sequence[int],
        progress: Progress = lambda _: None, recorder: Recorder | None = None,
    ) -> None:  # fmt: skip
        self.scheduler, self.orders, self.progress = scheduler, tuple(orders), progress
        self.recorder = recorder
        self.network, self.slices, self.evaluations = Network(settings), 0, 0
        self.spent, self.untaken = 0, 0  # evaluations, also of earlier runs; slices that were left
        self._allowed = settings.of_search(self.orders)
        self.coming = deque[Pending]()
        self._known = {
            (kind, order): Known(self.network, kind, order, map_)
            for kind in (BranchKind.FIXED_POINT, BranchKind.JUMP)
            for order in self.orders
        }
        self._starts: dict[int, _Start] = {}
        self._switches = False  # whether those are followed by now
        self._past = deque[Step]()

    def take_over(self, past: Iterable[Step]) -> None:
        """What an interrupted run has followed already is taken over when its turn comes.

        The search makes the same decisions in the same order as that run, with the same branches
        known at each, and so comes to the same.

        Parameters
        ----------
        past
            What the run has kept since the last slice that was finished.
        """
        self._past.extend(past)

    @property
    def is_spent(self) -> bool:
        """Whether the map was evaluated as often as allowed."""
        return self.spent >= self._allowed

    @property
    def left(self) -> str:
        """What was left because the map was evaluated as often as allowed, as a sentence."""
        if not self.is_spent:
            return ""
        points = len(self.network.waiting) + len(self.network.switches)
        return (
            f"given up after {self._allowed} evaluations, as many as allowed "
            f"(Settings.max_evaluations): {counted(points, 'special point')} not followed further, "
            f"{counted(self.untaken, 'slice')} not taken"
        )

    def diagram(self, parameter_name: str, x_name: str) -> Diagram:
        """Everything found so far; it says what was left."""
        found = self.network.diagram(parameter_name, x_name)
        return replace(found, about={**found.about, LEFT: self.left}) if self.left else found

    def follow(self, orbit: Orbit) -> None:
        """Follow the branch through a cycle, and all that hangs on its ends."""
        self.branch(orbit)
        self.finish()

    def branch(self, orbit: Orbit) -> None:
        """Follow the branch through a cycle, and those that continue it beyond its ends."""
        self._tell(orbit.p, len(orbit))
        if not self._is_taken_over():
            self._keep(self._leg(Tasks.cycle, orbit))

    def go_on(self) -> None:
        """Follow what starts at the collisions that were met."""
        waiting = self.network.waiting
        while waiting and not self.is_spent:
            self._finish_one(waiting)

    def finish(self) -> None:
        """Follow what starts at collisions, and at flips and branch points after these."""
        self.go_on()
        switches, self._switches = self.network.switches, True
        while switches and not self.is_spent:
            self._finish_one(switches)
            self.go_on()
        self._switches = False

    def look(self, p: float) -> None:
        """Take slices of all orders at a parameter, to be seen after those that were taken before.

        They give way to what is needed now.
        """
        self._tell(p, max(self.orders))
        self.coming.append(self.scheduler.later(Tasks.slice, p, self.orders))

    def see(self) -> Seen:
        """Follow what the slices at the next parameter show and no branch explains."""
        done = self.coming.popleft().result()
        new, left = list[int](), list[tuple[int, float]]()
        known = len(self.network.curves)
        for place in (place for each in done.value for place in _shown(each)):
            if self.is_spent:
                if not self._is_explained(place):
                    left.append((place.order, float(place.orbit.x[0])))
                continue
            if not self._follow(_Candidate(place)):
                continue
            self.go_on()
            grown = self.network.curves[known:]
            known += len(grown)
            new += [curve.order for curve in grown]
            if grown and not self._is_explained(place):  # else the branch through it is known
                left.append((place.order, float(place.orbit.x[0])))
        unresolved = max(each.unresolved for each in done.value)
        p = done.value[0].p
        return Seen(p, tuple(sorted(set(new))), unresolved, tuple(left), done.evaluations)

    def has_seen(self, found: Seen) -> Seen:
        """Keep what a slice came to."""
        self.spent += found.evaluations
        if self.recorder is not None:
            self.recorder.seen(found)
        return found

    # --- In turn ----------------------------------------------------------------------------------

    def _follow_all(self, met: Collision | End) -> tuple[int, int]:
        """Follow what starts at a special point; how many branches do.

        Returns
        -------
        starts, evaluations
            And how often the map was evaluated to know that.
        """
        start, before = self._start(met), self.spent
        self._wait(start.pending)
        self._done(start.pending)
        cost, candidates = self.spent - before, self._candidates(start)
        for candidate in candidates:
            if self.is_spent:
                break
            self._follow(candidate)
        return len(candidates), cost

    def _finish_one(self, queue: deque[Any]) -> None:
        """Follow what starts at the first special point of a queue, and take it from there.

        It stays there if that takes more evaluations than are allowed.
        """
        met: Collision | End = queue[0]
        if not self._is_finished(met):
            ends_here = isinstance(met, End) and self.network.is_switched(met)
            starts, cost = (0, 0) if ends_here else self._follow_all(met)
            if self.is_spent:
                return
            if self.recorder is not None:
                self.recorder.done(met, starts, cost)
        self._starts.pop(id(queue.popleft()), None)

    def _is_finished(self, met: Collision | End) -> bool:
        """Take over all that starts at a special point, if an interrupted run has finished it."""
        if not any(isinstance(step, Finished) for step in self._past):
            return False
        while not isinstance(self._past[0], Finished):
            self._is_taken_over()
        finished = self._past.popleft()
        assert isinstance(finished, Finished)
        if finished.p != met.p:
            raise ValueError(f"expected a run that goes on at {met.p}, got one with {finished}")
        self.spent += finished.evaluations
        return True

    def _is_taken_over(self) -> bool:
        """Take over what an interrupted run came to where a branch is to be followed, if it did."""
        if not self._past:
            return False
        kept = self._past.popleft()
        if isinstance(kept, Finished):
            raise ValueError(f"expected a run with one branch more, got one with {kept}")
        self.spent += kept.evaluations
        for curve in kept.curves:
            self.network.add(curve)
        return True

    def _follow(self, candidate: _Candidate) -> bool:
        """Follow what goes through a place, unless a branch explains it; whether that was done."""
        if self._is_new(candidate):
            if not self._is_taken_over():
                place = candidate.place
                self._keep(candidate.leg or self._leg(place.task, place.argument))
            return True
        if candidate.leg is not None:
            candidate.leg.cancel()
        return False

    def _keep(self, first: _Leg) -> None:
        """Keep a branch and those that continue it beyond its ends, until one is known already.

        One that is known is followed to its end before that is seen: right beyond a sharp fold it
        cannot be told from the branch that led there.
        """
        kept, points, todo, before = list[Curve](), list[Curve](), deque([first]), self.spent
        while todo and not self.is_spent:  # each leg is followed, and that is counted
            leg = todo.popleft()
            self._wait(leg.pending, todo)
            found = self._done(leg.pending)
            if found is None:
                continue
            curve = found.curve
            if self._is_dropped(curve, points):
                leg.give_up()
                continue
            kept.append(curve)
            self.network.add(curve)
            if self.network.is_a_point(curve):
                points.append(curve)
            else:
                self._tell(curve.ends[1].p, curve.order)
            todo += self._onward(leg, found)
        for leg in todo:
            leg.cancel()
        if self.recorder is not None:
            self.recorder.followed(kept, self.spent - before)

    def _done(self, pending: Pending) -> Any:
        done = pending.result()
        self.evaluations += done.evaluations
        self.spent += done.evaluations
        return done.value

    def _tell(self, p: float, order: int) -> None:
        self.progress(Stage(p, order, self.slices, len(self.network.branches)))

    def _is_dropped(self, curve: Curve, points: Sequence[Curve] = ()) -> bool:
        """Whether a branch is known, or not wanted."""
        return (
            curve.order not in self.orders
            or self.network.leaves_at_once(curve)
            or self.network.has(curve, points)
        )

    def _is_new(self, candidate: _Candidate) -> bool:
        """Whether no branch explains a place."""
        curves = len(self.network.curves)
        if candidate.unexplained_by < curves and not self._is_explained(candidate.place):
            candidate.unexplained_by = curves
        return candidate.unexplained_by == curves

    def _is_explained(self, place: _Place) -> bool:
        known = self._known[place.kind, place.order]
        return known.explains(place.orbit, place.closing, place.keys)

    # --- Submitted, in turn or ahead --------------------------------------------------------------

    def _leg(self, task: Callable[..., Any], argument: object) -> _Leg:
        return _Leg(self.scheduler.submit(task, argument))

    def _onward(self, leg: _Leg, found: Followed) -> list[_Leg]:
        """The legs that continue one."""
        if leg.onward is None:
            leg.onward = [self._leg(Tasks.ahead, start) for start in found.onward]
        return leg.onward

    def _start(self, met: Collision | End) -> _Start:
        """What starts at a special point that waits."""
        if id(met) not in self._starts:
            task = Tasks.starts if isinstance(met, Collision) else Tasks.switches
            self._starts[id(met)] = _Start(self.scheduler.submit(task, met, self.orders))
        return self._starts[id(met)]

    def _candidates(self, start: _Start) -> list[_Candidate]:
        """Where branches start at a special point, as far as they lie in the span."""
        if start.candidates is None:
            low, high = self.network.settings.span
            start.candidates = [
                _Candidate(_of_start(each))
                for each in start.pending.result().value
                if low <= each.begin.sample.orbit.p[0] <= high
            ]
        return start.candidates

    def _wait(self, pending: Pending, todo: Iterable[_Leg] = ()) -> None:
        """Wait for a task, and submit what is likely to be needed later."""
        self._submit_ahead(todo)
        while not self.scheduler.waited(pending):
            self._submit_ahead(todo)

    def _submit_ahead(self, todo: Iterable[_Leg]) -> None:
        """Submit what is likely to be needed later, the likeliest first."""
        for leg in todo:
            self._go_ahead(leg)
        for met in islice(self._later(), self.scheduler.ahead):
            if not self.scheduler.is_idle:
                return
            self._look_ahead(self._start(met))

    def _later(self) -> Iterator[Collision | End]:
        """Special points whose turn comes next."""
        yield from self.network.waiting
        if self._switches:
            yield from (end for end in self.network.switches if not self.network.is_switched(end))

    def _look_ahead(self, start: _Start) -> None:
        """Follow what starts at a special point before its turn has come."""
        if start.candidates is None and not start.pending.done():
            return
        with suppress(Exception):  # it is raised when its turn comes, if it comes
            for candidate in self._candidates(start):
                if candidate.leg is not None:
                    self._go_ahead(candidate.leg)
                elif self.scheduler.is_idle and self._is_new(candidate):
                    candidate.leg = self._leg(candidate.place.task, candidate.place.argument)

    def _go_ahead(self, leg: _Leg) -> None:
        """Continue a leg whose turn has not come, as far as it is not known by now."""
        if leg.onward is None and leg.pending.done():
            with suppress(Exception):
                found = leg.pending.result().value
                leg.onward = [] if self._is_dropped(found.curve) else self._onward(leg, found)
        for each in leg.onward or ():
            self._go_ahead(each)
