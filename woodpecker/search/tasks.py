"""The tasks of a search: to follow branches, to find what starts at their ends, to take slices."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from pwmap.diagrams.diagram import BranchKind, PointKind
from woodpecker.base.arrays import Floats, norm
from woodpecker.base.executors import Done
from woodpecker.base.settings import Settings
from woodpecker.engine.arrivals import Arrival
from woodpecker.engine.curves import CurveSettings, Sample, SolutionCurve, Stop
from woodpecker.engine.ends import begins_at_special
from woodpecker.engine.following import StopRequests
from woodpecker.engine.germs import SAME, Beginning, beginnings, crossings_at, meets_border
from woodpecker.engine.line import LineMap
from woodpecker.engine.orbits import SpaceOrbit
from woodpecker.engine.tracing import Trace, beside, switched, trace
from woodpecker.maps.counting import Allowance, as_counting
from woodpecker.maps.pieces import PiecewiseMap
from woodpecker.search.curves import (
    Collision,
    End,
    Followed,
    Start,
    agree,
    curve_of,
    end_of,
    keys_of,
    keys_of_jump,
    multiplier_of,
    text_of,
)
from woodpecker.slices.jumps import Jump
from woodpecker.slices.orbits import CYCLE, problem_of
from woodpecker.slices.slices import Slice, slices_at

# Most times that a start is moved to the next sample as a test function vanishes at it: cycles have
# so many test functions.
MOST_SHIFTS = 4


class BranchState(NamedTuple):
    """A sample of a branch, as a stop rule receives it.

    Attributes
    ----------
    kind, order, parameter
        Whether it is a cycle or a jump of P_order, and at which parameter.
    points
        (n,) points of the cycle, or those of a jump up to its border; (n, d) in R^d.
    multiplier
        Of the cycle, in R^d the largest one, the modulus of a complex pair; nan for a jump.
    word
        The words of the pieces.

    Examples
    --------
    >>> from woodpecker import Toy, continuation, shoot
    >>> flips = lambda state: state.multiplier < -0.9  # state is a BranchState
    >>> toy = Toy()
    >>> diagram = continuation(toy, shoot(toy, -0.53), span=(0.48, 0.7), stop=flips)
    >>> [(round(point.parameter, 9), point.note) for point in diagram.points]
    [(0.48, 'end of the parameter span'), (0.636607185, 'stopped as asked')]
    """

    kind: BranchKind
    order: int
    parameter: float
    points: Floats
    multiplier: float
    word: str

    @property
    def x(self) -> float:
        """The first point, in R^d its first coordinate."""
        return float(self.points.flat[0])


StopRule = Callable[[BranchState], bool]
"""Whether a branch is to end at a sample."""


def base_of(map_: PiecewiseMap, settings: Settings) -> SolutionCurve:
    """The problem of branches of cycles of a map of the line, with the steps of settings."""
    problem = problem_of(settings, *CYCLE)
    followed = CurveSettings(
        spans=(settings.span,), window=(settings.window,), step=settings.step,
        min_step=settings.min_step, max_step=settings.max_step, max_turn=settings.max_turn,
        max_samples=settings.max_samples,
    )  # fmt: skip
    return SolutionCurve(LineMap(map_, settings.x_scale, settings.p_scale), problem, followed)


@dataclass(frozen=True, slots=True)
class Tasks:
    """The tasks of a search, one method each; without state, and picklable if the map is."""

    base: SolutionCurve  # curves of cycles of the map, which counts its evaluations
    settings: Settings
    stop: StopRule | None = None  # a rule of the user where branches end
    whole: bool = False  # all branches of a window are sought, not those connected with one cycle
    parameters: tuple[float, ...] = (0.0,)  # values (k,) of all parameters; one of them varies
    orders: tuple[int, ...] = ()  # in R^d: a branch ends at a border where branches of these start

    def __post_init__(self) -> None:
        if self.stop is not None and not callable(self.stop):
            raise TypeError(f"stop must be a function of a state on a branch, got {self.stop!r}")

    @classmethod
    def of_line(
        cls, map_: PiecewiseMap, settings: Settings, stop: StopRule | None = None, *,
        whole: bool = False,
    ) -> Tasks:  # fmt: skip
        """The tasks of a search for the branches of a map of the line."""
        return cls(base_of(as_counting(map_), settings), settings, stop, whole)

    @property
    def evaluations(self) -> int:
        """How often the map was evaluated, if it counts that; else 0."""
        return getattr(self.base.map, "evaluations", 0)

    @property
    def line(self) -> PiecewiseMap:
        """The map of the line, of which slices can be taken."""
        assert isinstance(self.base.map, LineMap)
        return self.base.map.own

    def __call__(self, task: Callable[..., Any], *arguments: Any) -> Done:
        """The result of a task, a method of this class, and the evaluations that it took."""
        before = self.evaluations
        value = task(self, *arguments)
        return Done(value, self.evaluations - before)

    def cycle(self, orbit: SpaceOrbit) -> Followed:
        """The branch through a cycle; of those that meet at a border one of cycles, if any."""
        if meets_border(orbit):
            order = len(orbit.x)
            beside_border = beginnings(self.base, orbit.x, orbit.p, (order,))
            begin = min(beside_border, key=lambda each: each.is_crossing, default=None)
            if begin is not None:
                return self._both_ways(beside(begin))
        start = self.base.start(orbit, self._ahead(orbit))
        if not np.isfinite(start.tangent).all():  # at a fold no tangent leads ahead in p
            start = self.base.start(orbit)
        return self._both_ways(Beginning(len(orbit.x), self.base, start))

    def jump(self, jump: Jump) -> Followed | None:
        """The branch of crossings through a jump; None if the map has none with these pieces."""
        found = crossings_at(self.base, jump.head.x[:, None], np.array([jump.p]), jump.order)
        wanted = keys_of_jump(jump)
        for begin in found:
            orbit = begin.sample.orbit
            if agree(keys_of(orbit, self.base.problem), wanted):
                start = begin.curve.start(orbit, self._ahead(orbit))
                return self._both_ways(replace(begin, sample=start))
        return None

    def starts(self, met: End, orders: Sequence[int]) -> list[Start]:
        """The branches that start at a border collision, a flip, or a branch point."""
        collision = met.collision
        if collision is None:
            return self._switches(met, orders)
        found = beginnings(self.base, collision.x, self._parameters(met), orders)
        return [(beside(each), self._start_at(each, met, collision)) for each in found]

    def ahead(self, start: Start) -> Followed:
        """The branch that begins, or goes on, at a special point, followed to the next one."""
        begin, first = start
        found, last = self._leg(begin)
        curve = curve_of(begin, found.samples, found.changes, (first, last))
        return Followed(curve, self._onward((found, last)))

    def slice(self, p: float, orders: Sequence[int]) -> list[Slice]:
        """All cycles and jump crossings of some iterates at one parameter."""
        return slices_at(self.line, p, orders, self.settings)

    # --- Parts ------------------------------------------------------------------------------------

    def _start_at(self, begin: Beginning, met: End, collision: Collision) -> End:
        """The end of a branch at a border collision at which it starts."""
        orbit, problem = begin.sample.orbit, self.base.problem
        # behind a flat piece the image of a border is none of the points that collide
        if begin.is_crossing or all(
            any(problem.same(x, each, SAME) for each in collision.x) for x in orbit.x
        ):
            return collision.end_at(orbit.x, met.cycle)
        own = Arrival(PointKind.BC, orbit, "", met.cause, met.precision)
        return end_of(own, self.base, orbit)

    def _ahead(self, orbit: SpaceOrbit) -> Floats:
        """The direction (in scaled unknowns) of the parameter alone, growing."""
        columns, _ = self.base.problem.free_columns(orbit)
        ahead = np.zeros(len(orbit.unknowns[columns]))
        ahead[orbit.x.size] = 1.0
        return ahead

    def _parameters(self, end: End) -> Floats:
        """The values (k,) of all parameters at an end."""
        p = np.array(self.parameters)
        p[self.base.problem.free[0]] = end.p
        return p

    def _switches(self, end: End, orders: Sequence[int]) -> list[Start]:
        """The branches that start at a flip or a branch point."""
        n = len(end.x)
        halves = end.kind is PointKind.PD and np.array_equal(end.x[: n // 2], end.x[n // 2 :])
        x, p = end.x[: n // 2] if halves else end.x, self._parameters(end)  # where a double ends
        images = tuple(self.base.map.at(each, p) for each in x)
        cycle = SpaceOrbit(x, p, 0.0, images)
        found = switched(self.base, cycle, end.kind, n) if cycle.is_defined else []
        return [(each, end) for each in found if each.order in orders]

    def _both_ways(self, begin: Beginning) -> Followed:
        """The branch through a sample, from special point to special point, or closed."""
        for moved in range(MOST_SHIFTS + 1):
            ahead, end = self._leg(begin)
            if ahead.stop is Stop.CLOSED:
                return Followed(curve_of(begin, ahead.samples, ahead.changes, (end, end)), ())
            if moved == MOST_SHIFTS or len(ahead.samples) == 1:
                break
            is_on_border = meets_border(ahead.samples[0].orbit, begin.curve.ignored)
            if not (is_on_border or begins_at_special(begin.curve, *ahead.samples[:2])):
                break
            begin = replace(begin, sample=_next(begin.curve, ahead.samples), before=None)
        behind, first = self._leg(replace(begin, sample=begin.sample.turned))
        n = len(behind.samples) - 1
        changes = [each._replace(sample=n - each.sample) for each in reversed(behind.changes)]
        changes += [each._replace(sample=each.sample + n) for each in ahead.changes]
        samples = (*reversed(behind.samples), *ahead.samples[1:])
        curve = curve_of(begin, samples, changes, (first, end))
        return Followed(curve, self._onward((ahead, end), (behind, first)))

    def _leg(self, begin: Beginning) -> tuple[Trace, End]:
        """The trace of a branch from its beginning to a special point, and that end."""
        most = self.settings.of_branch(begin.order, one_of_many=self.whole)
        allowed = Allowance(self, most)
        # A crossing may end at a cycle with any number of points up to its own order.
        orders = {*range(1, begin.order + 1), *self.orders}
        found = trace(
            begin, sorted(orders), StopRequests(lambda: allowed.spent, self._asked(begin))
        )
        return found, end_of(found.arrival, self.base, found.samples[-1].orbit)

    def _asked(self, begin: Beginning) -> Callable[[Sample], bool] | None:
        rule = self.stop
        if rule is None:
            return None

        def asked(sample: Sample) -> bool:
            orbit = sample.orbit
            points = orbit.x[:, 0] if orbit.x.shape[1] == 1 else orbit.x
            state = BranchState(
                begin.kind, begin.order, float(orbit.p[self.base.problem.free[0]]), points.copy(),
                multiplier_of(orbit), text_of(orbit),
            )  # fmt: skip
            return bool(rule(state))

        return asked

    @staticmethod
    def _onward(*traces: tuple[Trace, End]) -> tuple[Start, ...]:
        found = ((each.arrival.onward, end) for each, end in traces)
        return tuple((onward, end) for onward, end in found if onward is not None)


def _next(curve: SolutionCurve, samples: Sequence[Sample]) -> Sample:
    """The sample of a branch after its first; if it ends there one halfway, if that is found."""
    first, other = samples[:2]
    if len(samples) > 2:
        return other
    distance = 0.5 * norm(curve.problem.step_between(first.orbit, other.orbit))
    return curve.advance(first, distance) or other
