"""A return along a prescribed path: a smooth map with derivatives, also beyond its borders.

With the word prescribed (which guard ends each phase, which cases each impact has) a return is a
composition of flows, whose durations follow by Newton's method from those of a neighbour, and of
impacts. Margins say where it is admissible.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.counting import weight
from woodpecker.engine.maps import SpaceImage
from woodpecker.systems.mechanics.impacts import ALONG, Impact, carry_out, is_implied, total
from woodpecker.systems.mechanics.index_sets import GAP, KNOWN, NORMAL, SECTION, SLIP, watched
from woodpecker.systems.mechanics.modes import Local
from woodpecker.systems.mechanics.status import MotionStatus, StoppedError
from woodpecker.systems.simulation.accumulation import accumulated_by
from woodpecker.systems.simulation.causes import (
    BOUNCES,
    DIP,
    EARLY,
    ITEMS,
    KINDS,
    MEETING,
    PHASE,
    SETTLES,
    SLACK,
    SPEED,
    START,
    cause_of,
    is_on_section,
)
from woodpecker.systems.simulation.flows import KeptSteps, Step
from woodpecker.systems.simulation.guards import GuardStart, beginning, extremes, first_of
from woodpecker.systems.simulation.motion import LATE, PathPhase
from woodpecker.systems.simulation.sections import Embedding

TOO_FAR = "the path does not reach so far"  # a guard of the path has no root
NEWTON_MOST = 12  # iterations for an event time: if they are not enough, no root is nearby
SETTLED = 2.0**-50  # relative: an event time that moves by less has converged
BOUNCES_MOST = 1000  # laps of impacts that accumulate: a ratio of 0.98 needs so many
# A gap f hardly falls where f''^2 < 4 f' f'''; where three roots meet it is 2 f' f'''.
NEAR_INFLECTION = 4.0
FURTHER = 4.0  # times the neighbour's duration: farther away no first root is looked for

NEARBY = 0.125  # of a neighbour's duration: a root that is farther may be another one
# Relative: a minimum whose time is known so well has its value to rounding.
TANGENCY_TIME = 2.0**-30
# Of the terms of a guard: what rounding may have left of zero at its minimum.
TANGENCY_NOISE = 2.0**-46
# Of a step: a guard that by its first derivatives is back at zero so soon does fall.
SHORT_RETURN = 1e-3
DIFFERENCE = 1e-5  # relative step of central differences of rates of forces
# Of the largest of its kind in a return: a margin that is smaller, with all derivatives, is zero.
NOTHING = 1e-14


@dataclass(frozen=True, slots=True)
class SystemPiece:
    """A piece of the return map: the returns along one path, which identifies it."""

    # the phases, with the events that begin them; of impacts that accumulate only one lap
    legs: tuple[PathPhase, ...]
    last: Impact | None  # the impact with which it ends, on a section of impacts
    turns: int  # by how many periods time has advanced
    word: str = field(compare=False)  # the sequence of events; without phases, why there is none
    embedding: Embedding = field(compare=False, repr=False)
    times: Floats = field(compare=False, repr=False)  # durations of phases at the last point

    @property
    def key(self) -> Hashable:
        """Equal for two pieces if and only if they are one."""
        return self

    def at(self, x: Floats, p: Floats) -> SpaceImage:
        """The return along this path, also where the system takes another one."""
        reason = self.embedding.obstacle(x, p) if self.legs else self.word
        if not reason:
            following = Following(self, p)
            try:
                found = following.follow(np.asarray(x, dtype=float))
                if np.isfinite(found.jacobian).all():
                    return found
            except StoppedError as stop:
                reason = str(stop)
            except np.linalg.LinAlgError:
                pass
            finally:
                self.embedding.counter.evaluations += weight(len(following.marks))
        d, columns = self.embedding.d, self.embedding.d + len(p)
        return SpaceImage(
            np.full(d, np.nan), np.full((d, columns), np.nan), np.zeros(0), np.zeros((0, columns)),
            np.zeros(0, dtype=np.int64), self, reason or TOO_FAR,
        )  # fmt: skip

    def cause(self, code: int) -> str:
        """A sentence on what happens where a margin vanishes."""
        return cause_of(self.legs, code, self.embedding.names)

    def on_section(self, code: int) -> bool:
        """Whether a margin vanishes as an event falls on a section that is no impact."""
        return is_on_section(self.legs, code)


class Following:
    """A return along a path from one point, as it is followed."""

    def __init__(self, path: SystemPiece, p: Floats) -> None:
        self.embedding, self.eq, self.path = path.embedding, path.embedding.eq, path
        self.p = path.embedding.values(p)
        self.notes: dict[int, tuple[float, Floats]] = {}
        self._fired = 0  # the contact of the guard that ended the last phase
        self._flight: tuple[float, Floats] | None = None  # its duration, if it began at rest
        self._slow: tuple[float, Floats] | None = None  # rate of the gap at its end, if it is slow
        self.marks = list[tuple[Floats, Floats]]()  # states and tangents where phases begin

    def follow(self, x: Floats) -> SpaceImage:
        """The return; StoppedError if the path does not reach so far."""
        times = self.path.times
        z, tangents = self.embedding.state(x, self.p)
        first = self.path.legs[0]
        if first.impact is None:
            z, tangents = self.embedding.resting(z, self.p, tangents, first.touch, first.mode)
        else:  # it starts with an impact
            rates = self.eq.terms(z, self.p).gap_rate
            self._fired = min(first.impact.contacts, key=lambda i: float(rates[i]))
        self._z, self._tangents, found = z, tangents, times.copy()
        self._start, self._begins_on = float(z[-1]), True
        k = laps = 0
        begun = False
        while k < len(self.path.legs):
            self._k, self._leg = k, self.path.legs[k]
            begun = begun or self._begin()
            self.marks.append((self._z, self._tangents))
            if not begun:  # one more lap of impacts, the first of which has been carried out
                k, laps, begun = k - self._leg.lap, laps + 1, True
                if laps > BOUNCES_MOST:
                    raise StoppedError(MotionStatus.HORIZON, TOO_FAR)
                continue
            here, begun = self._local(self._z), False
            self._start_margins(here)
            t = self._phase(here, None if laps else float(times[k]))
            self._longest = max(self._longest, t)
            if not laps:
                found[k] = t
            k += 1
        self._k = k
        if self.path.last is not None:
            self._impact(self.path.last)
        return self._result(replace(self.path, times=found))

    def _result(self, piece: SystemPiece) -> SpaceImage:
        """The image, with all margins in ascending order of their codes."""
        embedding, turns, p = self.embedding, self.path.turns, self.p
        value = embedding.point(self._z, p, turns)
        jacobian = embedding.changes(self._tangents, p, turns)
        if embedding.section.period is not None:
            ends = embedding.phase_margins(value, jacobian, p)
            for item, (margin, gradient) in enumerate(ends):
                self._note(PHASE, item, margin, gradient)
        codes = self._codes()
        rows = np.array([self.notes[c][1] for c in codes]).reshape(len(codes), jacobian.shape[1])
        margins = np.array([self.notes[c][0] for c in codes])
        return SpaceImage(value, jacobian, margins, rows, np.array(codes, dtype=np.int64), piece)

    def _codes(self) -> list[int]:
        """Codes of margins that are not identically zero, ascending."""
        kinds, largest = dict[int, tuple[int, int]](), dict[tuple[int, int], Floats]()
        sizes = {c: np.abs([margin, *change]) for c, (margin, change) in self.notes.items()}
        for code, size in sizes.items():
            rest, item = divmod(code, ITEMS)
            kind = rest % KINDS
            kinds[code] = kind, item % 4 if kind == SLACK else item // self.eq.m
            largest[kinds[code]] = np.maximum(size, largest.get(kinds[code], 0.0))
        return [c for c in sorted(sizes) if (sizes[c] > NOTHING * largest[kinds[c]]).any()]

    def _note(self, kind: int, item: int, margin: float, gradient: Floats) -> None:
        """Enter a margin; if laps repeat, the least one of each code counts."""
        code = (KINDS * self._k + kind) * ITEMS + item
        if code not in self.notes or margin < self.notes[code][0]:
            self.notes[code] = margin, gradient

    # --- Events -----------------------------------------------------------------------------------

    def _begin(self) -> bool:
        """Carry out the event that begins a phase; False if laps of impacts must repeat first."""
        impact = self._leg.impact
        if impact is None:
            return True
        self._impact(impact)
        return not self._leg.closes or self._tail(impact)

    def _impact(self, impact: Impact) -> None:
        z, tangents, slacks = carry_out(self.eq, impact, self._z, self.p, self._tangents)
        rate, turn = self._gap_rate(self._fired, self._z, self._tangents)
        for item, slack, gradient in slacks:
            if item % 4 != ALONG:  # it is proportional to the speed at which the gap closes
                slack, gradient = _series_quotient(slack, gradient, -rate, -turn)
            self._note(SLACK, item, slack, gradient)
        self._z, self._tangents = z, tangents

    def _tail(self, impact: Impact) -> bool:
        """Go to the end of impacts that accumulate; False if flights are not short enough yet."""
        leg = self._leg
        tail = accumulated_by(self.eq, self._z, self.p, self._tangents, impact, self._longest)
        if tail is None or tail.group != leg.closes:
            if not leg.lap:
                raise StoppedError(MotionStatus.HORIZON, TOO_FAR)
            return False
        if leg.lap:
            i = self._fired
            speed = self._gap_rate(i, self._z, self._tangents)
            ratio, change = _series_quotient(*speed, *self._gap_rate(i, *self.marks[-leg.lap]))
            self._note(BOUNCES, i, 1.0 - ratio, -change)
        self._z, self._tangents = tail.z, tail.tangents
        return True

    def _gap_rate(self, i: int, z: Floats, tangents: Floats) -> tuple[float, Floats]:
        gradient = self.eq.kinematic_changes(z, self.p)[1][i]
        return float(self.eq.terms(z, self.p).gap_rate[i]), total(self.eq, gradient, tangents)

    # --- Phases -----------------------------------------------------------------------------------

    _longest = 0.0  # longest duration of a phase so far
    _k: int  # number of the phase
    _start: float  # the time at which the return starts
    _begins_on: bool  # whether it has not left the section yet
    _leg: PathPhase
    _steps: KeptSteps
    _length: float  # time scale of the motion in a phase, and of its guards
    # how the guards of a phase begin; powers of time by which they are divided; which fire at once
    _starts: dict[int, GuardStart]
    _orders: Ints
    _fires: Floats

    def _phase(self, here: Local, near: float | None) -> float:
        """Follow the motion to the event that ends a phase; returns its duration."""
        eq, leg = self.eq, self._leg
        if self._begins_on and self._k:
            self._begins_on = self.embedding.is_on(here, float(here.z[-1]) - self._start)
        section = SECTION * eq.m
        self._orders, self._fires = beginning(here.sets, leg.touch, self._begins_on)
        starts = self._starts = {
            guard: GuardStart(order, here.jet(guard, 1 if guard == section else 3) if order else ())
            for guard, order in zip(here.sets.places, self._orders.tolist(), strict=True)
        }
        steps = self.eq.flow(leg.mode, varies=True)
        self._steps = KeptSteps(steps, here.z, self.p, self.embedding.section.horizon)
        self._length = self._first_length()
        start, (t, left) = starts[leg.guard], self._root(near)
        z, changes = self._steps.exact(t)
        there, tangents = self._local(z), total(eq, changes, self._tangents)
        delay = self._fired_margins(there, t, tangents, left)
        for guard in starts:
            if guard != leg.guard:
                self._meeting(there, guard, t, tangents, delay)
        self._dips(t)
        self._z, self._tangents = z, tangents + np.outer(there.flow, delay)
        self._fired = leg.guard % eq.m
        rested = leg.guard // eq.m == GAP and start.order == 2
        self._flight = (t, delay) if rested else None
        return t

    def _first_length(self) -> float:
        """Length of the first step, or, if that is all (at rest), of the first one with guards."""
        length = self._steps.length
        if length < self.embedding.section.horizon:
            return length
        return next(self._guard_steps()).length

    def _local(self, z: Floats) -> Local:
        return Local(self.eq, self._leg.mode, z, self.p)

    def _root(self, near: float | None) -> tuple[float, float]:
        """Time at which the guard fires, and its value then; StoppedError if it does not soon."""
        if near is not None:
            t = self._root_near(near)
            if abs(t - near) <= NEARBY * abs(near):
                return t, 0.0
            touches = self._touches(near)
            if touches is not None:
                return touches
            if math.isfinite(t):
                return t, 0.0
        return self._first_root(near), 0.0

    def _touches(self, near: float) -> tuple[float, float] | None:
        """Where the guard that fires just touches zero near a neighbour's time, if it does."""
        # Right at the border where two roots of the guard meet, rounding decides whether there are
        # two or none. The guard is taken to fire before its minimum, by as much as rounding tells
        # times apart. That is right for forces and slips: the motion is the same before and after,
        # and so is the slope of the image. Gaps and sections have a square-root singularity.
        guard, steps = self._leg.guard, self._steps
        if guard // self.eq.m in (GAP, SECTION):
            return None
        t, step = near, math.inf
        for _ in range(NEWTON_MOST):
            z, _ = steps.exact(t)
            here = self._local(z)
            value, rate = here.jet(guard, 1)
            bends = self._second_rate(here, guard)
            step = -rate / bends if bends > 0.0 else math.inf
            if not abs(t + step - near) <= NEARBY * abs(near):
                return None
            if abs(step) <= TANGENCY_TIME * abs(near):
                break
            t += step
        terms = np.abs(here.gradient(guard)[: self.eq.size]) @ np.maximum(np.abs(z), 1.0)
        least = TANGENCY_NOISE * float(terms)
        if not abs(value) <= least:
            return None
        return t - math.sqrt(2.0 * least / bends), value + least

    def _root_near(self, near: float) -> float:
        """The root of the guard that fires, by Newton's method from a neighbour's; nan if none."""
        # If the guard falls from the start, the phase is beyond the border at which it has no
        # duration, and the root may be negative.
        guard, steps = self._leg.guard, self._steps
        start = self._starts[guard]
        t, order = near, start.order
        early = guard != SECTION * self.eq.m and bool(order) and start.jet[order] < 0.0
        for _ in range(NEWTON_MOST):
            if abs(t - near) > FURTHER * abs(near) + self._length or (
                order and not (t > 0.0 or (t < 0.0 and early))
            ):
                return math.nan
            z, _ = steps.exact(t)
            value, rate = self._local(z).jet(guard, 1)
            if order:
                value -= start.noise(t)
                rate -= order * value / t
            step = -value / rate if rate != 0.0 else math.nan
            t += step
            if not math.isfinite(t):
                return math.nan
            if abs(step) <= SETTLED * max(abs(t), abs(near)) or step == 0.0:
                return t if rate < 0.0 else math.nan
        # a phase between two events in one instant is as short as rounding of time
        near_enough = max(1e-9 * abs(t), LATE * math.ulp(float(steps.start[0][-1])))
        return t if abs(step) <= near_enough and rate < 0.0 else math.nan

    def _first_root(self, near: float | None) -> float:
        """The first root of the guard that fires; StoppedError if there is none soon."""
        most = math.inf if near is None else FURTHER * abs(near) + self._length
        others = np.array([int(guard != self._leg.guard) for guard in self._starts])
        k, begin, time, _ = first_of(self._guard_steps(), self._orders, self._fires, others, most)
        if k < 0:
            raise StoppedError(MotionStatus.HORIZON, TOO_FAR)
        t = begin + time
        better = self._root_near(t) if t > 0.0 else t
        return better if math.isfinite(better) else t

    def _guard_steps(self) -> Iterator[Step]:
        return self.eq.flow(self._leg.mode)(*self._steps.start)

    # --- Margins ----------------------------------------------------------------------------------

    def _start_margins(self, here: Local) -> None:
        """Enter the margins that keep each closed contact in its state where a phase begins."""
        # The acceleration of a gap that opens as its force vanishes, or of a slip that starts at an
        # edge of its cone, is proportional to the speed at which that bound was reached: it is no
        # margin by itself. Where three roots of a gap meet, the contact strikes without speed and
        # acceleration; on one side it stays, on the other it leaves from rest. The acceleration
        # goes like the power 1/3 of the distance from there, the speed like 2/3: only their product
        # is smooth.
        leg = self._leg
        for guard, order in watched(here.sets, leg.touch):
            kind, i = divmod(guard, self.eq.m)
            if order == KNOWN[kind]:
                continue
            margin = float(here.jet(guard, order)[order])
            gradient = total(self.eq, here.gradient(guard, order), self._tangents)
            if self._flight is not None and guard == NORMAL * self.eq.m + self._fired:
                # the force is proportional to the duration of a flight from rest
                margin, gradient = _series_quotient(margin, gradient, *self._flight)
            if self._slow is not None and leg.impact is not None and i == self._fired:
                rate, turn = self._slow
                self._note(SETTLES, guard, -rate * margin, -rate * gradient - margin * turn)
            else:
                self._note(START, guard, margin, gradient)

    def _gradients(self, here: Local, guard: int, tangents: Floats) -> tuple[Floats, Floats]:
        """Derivatives of a guard and of its rate along the tangents, at a fixed time."""
        value = total(self.eq, here.gradient(guard), tangents)
        if guard // self.eq.m in (GAP, SLIP, SECTION):
            return value, total(self.eq, here.gradient(guard, 1), tangents)
        places = [-1] * (tangents.shape[1] - len(self.eq.free)) + self.eq.places
        along = zip(tangents.T, places, strict=True)
        rates = [self._rate_by_differences(here, guard, way, place) for way, place in along]
        return value, np.array(rates)

    def _rate_by_differences(self, here: Local, guard: int, way: Floats, place: int = -1) -> float:
        """Derivative of a force's rate, by differences, as it has second derivatives of M and h."""
        # It is along a way (N,) of the state, and of the parameter at ``place``, if that is >= 0.
        length = float(np.abs(way).max())
        if not math.isfinite(length):  # at a square-root singularity of the path
            return math.nan
        h = DIFFERENCE / length if length > 0.0 else DIFFERENCE
        sides = []
        for sign in (1.0, -1.0):
            p = self.p.copy()
            if place >= 0:
                p[place] += sign * h
            near = Local(self.eq, here.mode, here.z + sign * h * way, p)
            sides.append(near.derivative(guard, 1))
        return (sides[0] - sides[1]) / (2.0 * h)

    def _fired_margins(self, there: Local, t: float, tangents: Floats, left: float) -> Floats:
        """Enter the margin that the firing guard falls; the derivatives (d + k,) of its time."""
        # At the root f'^2 = -2 f f'' of the minimum nearby. Where the guard only touches zero what
        # is left of f is taken off, so that the margin has the sign of that minimum.
        leg, length = self._leg, self._length
        start, rate = self._starts[leg.guard], there.derivative(leg.guard, 1)
        value_turn, rate_turn = self._gradients(there, leg.guard, tangents)
        if rate == 0.0 or not math.isfinite(rate):
            raise StoppedError(MotionStatus.HORIZON, TOO_FAR)
        delay = -value_turn / rate
        bends = self._second_rate(there, leg.guard)
        order = start.order if t != 0.0 else 0
        scale, change = _power(t, order, delay)
        slope, turn = _series_quotient(rate, rate_turn + bends * delay, scale, change)
        self._slow = (rate, rate_turn + bends * delay) if self._is_slow(there) else None
        # The start of the guard may say that it falls.
        certain = start.order and abs(start.root()) < SHORT_RETURN * length
        if not certain and self._slow is None:
            square = -slope * abs(slope) - 2.0 * bends * left / scale**2
            self._note(SPEED, leg.guard, square, -2.0 * abs(slope) * turn)
        if leg.guard == SECTION * self.eq.m and start.order == 0 and t < SHORT_RETURN * length:
            self._note(EARLY, leg.guard, t, delay)  # a section that may not have counted before
        return delay

    def _is_slow(self, there: Local) -> bool:
        """Whether a gap closes slowly because an inflection is near, not because it grazes."""
        leg = self._leg
        kind, i = divmod(leg.guard, self.eq.m)
        if kind != GAP or i in leg.touch.closed | leg.touch.leaving:
            return False
        _, rate, second, third = there.jet(leg.guard)
        return second * second < NEAR_INFLECTION * rate * third

    def _second_rate(self, here: Local, guard: int) -> float:
        """The second time derivative of a guard."""
        known = here.jet(guard, 2)
        if len(known) > 2:
            return known[2]
        return self._rate_by_differences(here, guard, here.flow)

    def _meeting(self, there: Local, guard: int, t: float, tangents: Floats, delay: Floats) -> None:
        """Enter the margin that another guard has not fired before, or at the same time."""
        # In a short phase a guard that begins at zero has the sign of its first derivative, which
        # is a margin of the start of the phase.
        start, length = self._starts[guard], self._length
        if start.order and t < SHORT_RETURN * length and not 0.0 < start.root() <= 4.0 * t:
            return
        value, rate = there.jet(guard, 1)
        if guard == SECTION * self.eq.m and (value <= 0.0 or rate >= 0.0):
            return  # it does not fall through zero
        if self._stops_with_it(there, guard):
            return
        turn = total(self.eq, there.gradient(guard), tangents) + rate * delay
        if start.order and t > 0.0:
            value -= start.noise(t)
            value, turn = _series_quotient(value, turn, *_power(t, start.order, delay))
        self._note(MEETING, guard, float(value), turn)

    def _stops_with_it(self, there: Local, guard: int) -> bool:
        """Whether a slip vanishes whenever that slip does whose guard has fired."""
        eq, slips = self.eq, (SLIP, SECTION)
        if guard // eq.m not in slips or self._leg.guard // eq.m not in slips:
            return False
        (_, i, _), (_, fired, _) = map(there.sets.kinematic, (guard, self._leg.guard))
        z, closed = there.z.copy(), there.sets.closed
        z[eq.n : 2 * eq.n] = 0.0  # what is left of the rates is what moves under the contacts
        rest = eq.terms(z, self.p)
        rows = np.vstack([rest.w_n[closed], rest.w_t[fired]])
        rates = np.append(rest.gap_rate[closed], rest.slip[fired])
        return is_implied(rest.w_t[i], float(rest.slip[i]), rows, rates, 0.0)

    def _dips(self, t: float) -> None:
        """Enter the least minimum of each guard within a phase, however far from zero."""
        guards, fired, section = list(self._starts), self._leg.guard, SECTION * self.eq.m
        least = dict[tuple[int, float], tuple[float, float]]()
        begin, orders = 0.0, self._orders
        for step in self._guard_steps():
            if begin >= t:
                break
            for k, sign, value, time in extremes(step, orders, begin, t):
                at = guards[k], sign
                if sign > 0.0 or guards[k] == section != fired:
                    least[at] = min((value, time), least.get(at, (math.inf, math.inf)))
            begin, orders = begin + step.length, 0 * orders
        for (guard, sign), (value, time) in least.items():
            if guard != section or value > 0.0:  # else it does not fall
                z, changes = self._steps.exact(time)
                here = self._local(z)
                tangents = total(self.eq, changes, self._tangents)
                gradient = total(self.eq, here.gradient(guard), tangents)
                margin = sign * here.derivative(guard, 0)
                self._note(DIP, guard + (sign < 0.0), margin, sign * gradient)


def _series_quotient(value: float, change: Floats, by: float, turn: Floats) -> tuple[float, Floats]:
    """The quotient of two numbers, with derivatives; StoppedError if the second one is zero."""
    if by == 0.0:
        raise StoppedError(MotionStatus.HORIZON, TOO_FAR)
    found = value / by
    return found, (change - found * turn) / by


def _power(t: float, order: int, change: Floats) -> tuple[float, Floats]:
    return t**order, order * t ** (order - 1) * change if order else 0.0 * change
