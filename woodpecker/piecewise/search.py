"""Everything that is connected, and everything there is.

Branches are followed with all that hangs on their ends. A slice lists all cycles and jumps at one
parameter; what lies on no branch known so far is followed too. First slices fill the span evenly;
where one of them shows something new two more are taken, halfway to its neighbours, until nothing
is new or the gaps are as small as was asked: how thin an island can be and stay unseen is known. At
last branches are switched to at flips and branch points: what slices were too coarse to show.

Tasks are submitted some time before they are needed, and what was found meanwhile decides whether
they still are: so the result does not depend on who carries them out, or on how many do.
"""

from __future__ import annotations

from bisect import bisect_left, insort
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

from pwmap.diagrams.diagram import BranchKind
from woodpecker.base.executors import Pending, Scheduler
from woodpecker.piecewise.curves import Beginning, Curve, keys_of
from woodpecker.piecewise.ends import Collision, End
from woodpecker.piecewise.jumps import Jump
from woodpecker.piecewise.known import Known
from woodpecker.piecewise.network import Network
from woodpecker.piecewise.orbits import Closed, Condition, Orbit
from woodpecker.piecewise.pieces import PiecewiseMap
from woodpecker.piecewise.settings import Settings
from woodpecker.piecewise.slices import Slice
from woodpecker.piecewise.tasks import Tasks


@dataclass(frozen=True, slots=True, kw_only=True)
class Search:
    """How to look for what is not connected.

    Parameters
    ----------
    slices
        How many slices are taken first.
    finest
        Smallest gap between slices, as a part of the span.

    Raises
    ------
    ValueError
        If there is no slice, or the gap is no part of the span.
    """

    slices: int = 63
    finest: float = 5e-4

    def __post_init__(self) -> None:
        if self.slices < 1:
            raise ValueError(f"slices must be at least 1, got {self.slices}")
        if not 0.0 < self.finest < 1.0:
            raise ValueError(f"finest must lie in (0, 1), got {self.finest}")


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
    """

    parameter: float
    order: int
    slices: int
    branches: int


Progress = Callable[[Stage], None]


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
    """

    p: float
    new: tuple[int, ...]
    unresolved: float
    left: tuple[tuple[int, float], ...]
    evaluations: int


class Past(NamedTuple):
    """What an interrupted run had come to.

    Attributes
    ----------
    slices
        Those that were finished.
    since
        Orders of branches that were found after the last of them: the next slice showed these.
    """

    slices: tuple[Seen, ...] = ()
    since: tuple[int, ...] = ()


class Recorder(Protocol):
    """Keeps what is finished."""

    def followed(self, curves: Sequence[Curve]) -> None:
        """Keep the curves that a task has come to."""

    def done(self, met: Collision | End) -> None:
        """Keep that all that starts at the next special point was followed."""

    def seen(self, found: Seen) -> None:
        """Keep that all that a slice shows was followed."""


class _Place(NamedTuple):
    """An orbit that a branch may go through, and the task that follows it."""

    kind: BranchKind
    order: int
    orbit: Orbit
    closing: Condition
    keys: tuple[object, ...]
    task: Callable[..., Any]
    argument: object


def _of_cycle(orbit: Orbit) -> _Place:
    return _Place(
        BranchKind.FIXED_POINT, len(orbit), orbit, Closed(), orbit.keys, Tasks.cycle, orbit
    )


def _of_jump(jump: Jump) -> _Place:
    keys = keys_of(jump.head, jump)
    return _Place(BranchKind.JUMP, jump.order, jump.head, jump.closing, keys, Tasks.jump, jump)


def _of_beginning(begin: Beginning) -> _Place:
    last = begin.samples[-1]
    return _Place(
        begin.kind, begin.order, last.orbit, begin.closing, keys_of(last.orbit, last.jump),
        Tasks.ahead, begin,
    )  # fmt: skip


class Explorer:
    """Follows branches, and what starts at their ends.

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
        Called with every branch.
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
        self._known = {
            (kind, order): Known(self.network, kind, order, map_)
            for kind in BranchKind
            for order in self.orders
        }

    def follow(self, orbit: Orbit) -> None:
        """Follow the branch through a cycle, and all that hangs on its ends."""
        self.branch(orbit)
        self.finish()

    def branch(self, orbit: Orbit) -> None:
        """Follow the branch through a cycle, and those that continue it beyond its ends."""
        self._keep(self.scheduler.submit(Tasks.cycle, orbit))

    def go_on(self) -> None:
        """Follow what starts at the collisions that were met."""
        waiting = self.network.waiting
        while waiting:
            met = list(waiting)
            asked = [self.scheduler.submit(Tasks.starts, each, self.orders) for each in met]
            places = [self._places(pending) for pending in asked]
            following = self._followed(
                [place for own in places for place in own], self.scheduler.ahead
            )
            for each, own in zip(met, places, strict=True):
                for _ in own:
                    next(following)
                waiting.popleft()
                if self.recorder is not None:
                    self.recorder.done(each)

    def finish(self) -> None:
        """Follow what starts at collisions, and at flips and branch points after these."""
        self.go_on()
        switches = self.network.switches
        while switches:
            if not self.network.is_switched(switches[0]):
                asked = self.scheduler.submit(Tasks.switches, switches[0], self.orders)
                for _ in self._followed(self._places(asked)):
                    pass
            met = switches.popleft()
            if self.recorder is not None:
                self.recorder.done(met)
            self.go_on()

    def _places(self, asked: Pending) -> list[_Place]:
        """Where branches start at a special point, as far as they lie in the span."""
        low, high = self.network.settings.span
        return [
            _of_beginning(begin)
            for begin in self._done(asked)
            if low <= begin.samples[-1].orbit.p <= high
        ]

    def see(self, found: Sequence[Slice], evaluations: int, before: Sequence[int] = ()) -> Seen:
        """Follow what the slices of all orders at one parameter show and no branch explains.

        What was followed ``before`` the slice was taken again, orders of branches, counts as new.
        """
        new, left = list(before), list[tuple[int, float]]()
        for each in found:
            places = [*map(_of_cycle, each.cycles), *map(_of_jump, each.jumps)]
            known = len(self.network.curves)
            for place, was_followed in self._followed(places):
                if not was_followed:
                    continue
                self.go_on()
                new += [curve.order for curve in self.network.curves[known:]]
                known = len(self.network.curves)
                if not self._is_explained(place):
                    left.append((place.order, float(place.orbit.x[0])))
        unresolved = max(each.unresolved for each in found)
        seen = Seen(found[0].p, tuple(sorted(set(new))), unresolved, tuple(left), evaluations)
        if self.recorder is not None:
            self.recorder.seen(seen)
        return seen

    def _followed(self, places: Sequence[_Place], most: int = 1) -> Iterator[tuple[_Place, bool]]:
        """Follow what no branch explains when its turn comes; each place, and whether it was.

        What is submitted ahead, at ``most`` so many, is looked at once more if branches were found
        since. Those that start at different special points seldom turn out to be one; the cycles of
        a slice often do.
        """
        ahead: deque[tuple[Pending | None, int]] = deque()
        for k, place in enumerate(places):
            while len(ahead) < min(most, len(places) - k):
                later, curves = places[k + len(ahead)], len(self.network.curves)
                known = self._is_explained(later)
                task = None if known else self.scheduler.submit(later.task, later.argument)
                ahead.append((task, curves))
            pending, curves = ahead.popleft()
            grown = curves < len(self.network.curves)
            if pending is not None and grown and self._is_explained(place):
                pending.cancel()
                pending = None
            if pending is not None:
                self._keep(pending)
            yield place, pending is not None

    def _is_explained(self, place: _Place) -> bool:
        known = self._known[place.kind, place.order]
        return known.explains(place.orbit, place.closing, place.keys)

    def _done(self, pending: Pending) -> Any:
        done = pending.result()
        self.evaluations += done.evaluations
        return done.value

    def _keep(self, pending: Pending) -> None:
        """Keep a branch and those that continue it beyond its ends, until one is known already.

        One that is known is followed to its end before that is seen: right beyond a sharp fold it
        cannot be told from the branch that led there.
        """
        kept, points, todo = list[Curve](), list[Curve](), deque([pending])
        while todo:
            found = self._done(todo.popleft())
            curve = found.curve
            if curve.order not in self.orders or self.network.has(curve, points):
                continue
            if self.network.is_a_point(curve):
                points.append(curve)
            else:
                self.network.add(curve)
                kept.append(curve)
                end, count = curve.ends[1], len(self.network.branches)
                self.progress(Stage(end.p, curve.order, self.slices, count))
            todo += [self.scheduler.submit(Tasks.ahead, begin) for begin in found.onward]
        if self.recorder is not None:
            self.recorder.followed(kept)


def complete(
    explorer: Explorer, settings: Settings, search: Search, past: Past | None = None
) -> list[Seen]:
    """Take slices until they show nothing new; follow what they show.

    Parameters
    ----------
    explorer
        Follows and keeps branches; the scheduler it has takes the slices.
    settings
        Span of the parameter.
    search
        How long to look.
    past
        What an interrupted run had come to.

    Returns
    -------
    All slices.
    """
    past = past or Past()
    plan, seen, since = _Plan(search), list(past.slices), past.since
    for each in seen:
        plan.took(bool(each.new))
    known = len(explorer.network.curves)
    explorer.go_on()
    since += tuple(curve.order for curve in explorer.network.curves[known:])
    for found, evaluations in _slices(explorer, plan, settings):
        explorer.slices = plan.done + 1
        seen.append(explorer.see(found, evaluations, since))
        plan.took(bool(seen[-1].new))
        since = ()
    explorer.finish()
    return seen


def _slices(
    explorer: Explorer, plan: _Plan, settings: Settings
) -> Iterator[tuple[list[Slice], int]]:
    """Slices of all orders as they are planned, submitted ahead; and evaluations."""
    low, high = settings.span
    scheduler = explorer.scheduler
    ahead: deque[Pending] = deque()
    try:
        while plan.done < len(plan.places):
            last = min(plan.done + scheduler.spare, len(plan.places))
            for k in range(plan.done + len(ahead), last):
                p = low + (high - low) * plan.places[k]
                ahead.append(scheduler.later(Tasks.slice, p, explorer.orders))
            done = ahead.popleft().result()
            yield done.value, done.evaluations
    finally:
        for waiting in ahead:
            waiting.cancel()


class _Plan:
    """Where slices are taken, as parts of the span; it grows where they show something new."""

    def __init__(self, search: Search) -> None:
        self.search, self.done = search, 0
        self.places = first_places(search)
        self._sorted = sorted([0.0, *self.places, 1.0])

    def took(self, new: bool) -> None:
        """The next slice was taken; whether it showed something new."""
        place = self.places[self.done]
        self.done += 1
        if not new or self.done <= self.search.slices // 4:
            return
        i = bisect_left(self._sorted, place)
        for other in (self._sorted[i - 1], self._sorted[i + 1]):
            if abs(other - place) >= 2.0 * self.search.finest:
                middle = 0.5 * (place + other)
                insort(self._sorted, middle)
                self.places.append(middle)


def first_places(search: Search) -> list[float]:
    """Where slices are taken first, as parts of the span: near both ends, then evenly.

    Multiples of the golden ratio fill (0, 1) evenly, and fall on no value that a map may have in
    its formulas.
    """
    near = 0.5 * search.finest
    return [near, 1.0 - near, *((k * GOLDEN) % 1.0 for k in range(1, search.slices + 1))]


GOLDEN = 0.5 * (5.0**0.5 - 1.0)
