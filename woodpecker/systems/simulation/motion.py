"""From event to event: the loop of Figure 1 for any system [Leine2001].

Given index sets, the equations of motion are integrated until an event; at an impact the contact
problems of compression and expansion are solved; then the one on acceleration level sets up the new
index sets. What happens is recorded as a path, along which derivatives are taken.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence, Set
from dataclasses import dataclass
from enum import Enum
from functools import cache, partial
from importlib.util import find_spec

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.base.compiled import announce
from woodpecker.base.shown import choice
from woodpecker.mechanics.impact_terms import stated
from woodpecker.systems.mechanics.equations import Equations
from woodpecker.systems.mechanics.impacts import Impact, decide
from woodpecker.systems.mechanics.index_sets import (
    CONE_DOWN,
    CONE_UP,
    EDGE_DOWN,
    EDGE_UP,
    GAP,
    NORMAL,
    OPEN,
    REDUNDANT,
    SECTION,
    SLIDE_UP,
    SLIP,
    STICK,
    ContactState,
    Mode,
)
from woodpecker.systems.mechanics.model import ContactSystem
from woodpecker.systems.mechanics.modes import Local
from woodpecker.systems.mechanics.settling import resting_mode, settle, sticking, terms_at_rest
from woodpecker.systems.mechanics.status import MotionStatus, StoppedError
from woodpecker.systems.simulation.accumulation import (
    TOGETHER,
    Accumulation,
    accumulated_by,
    after,
    implied,
)
from woodpecker.systems.simulation.flows import Step, dop853
from woodpecker.systems.simulation.guards import beginning, first_of
from woodpecker.systems.simulation.sections import Embedding, Section

EVENTS_MOST = 2000  # of one return, unless a caller says otherwise
PENETRATED = 1e-7  # relative: far more than rounding leaves of a gap
BRIEF = 2.0**-10  # of the longest phase: impacts accumulate only after a flight shorter than this
SHORT = 1e-3  # of a step: derivatives at its start place a root so early to 1e-12 of it
POLISHED = 1e-4  # of a step: a Newton step from a root of an interpolant is shorter, or not taken
TIME = -2  # stands for the guard of a phase that lasts to the final time
ROUNDED = 2.0**-48  # of the terms of a gap: if it is smaller it may be zero
LATE = 4.0  # units in the last place of time by which rounding parts simultaneous events
NO_IMPULSES: Floats = np.zeros((0, 2, 0))  # of an event that is no impact


class Backend(Enum):
    """The integrator of the motion within a mode."""

    TAYLOR = "heyoka"
    RUNGE = "scipy"


@dataclass(frozen=True, slots=True)
class PathPhase:
    """One phase of a path, and the event that begins it."""

    impact: Impact | None  # the impact with which it begins, if any
    # the contacts at which impacts have accumulated then; how many of the phases before, a lap,
    # are repeated until they do
    closes: tuple[int, ...]
    lap: int
    touch: ContactState  # what touches where it begins
    # the states of the contacts, and which guard ends it
    mode: Mode
    guard: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MotionEvent:
    """One event of a motion.

    Attributes
    ----------
    symbol
        Kind and contacts, such as ``I1+3``: see :mod:`woodpecker.simulation.words`.
    time
        Its time [s].
    before, after
        (n,) velocities.
    impulses
        (2, 2, m) normal and tangential impulses [N s] of compression and expansion; or empty.
    """

    symbol: str
    time: float
    before: Floats
    after: Floats
    impulses: Floats


def assembled(
    system: ContactSystem, free: Sequence[str] = (), backend: Backend | str | None = None,
    section: Section | None = None,
) -> Equations:  # fmt: skip
    """The equations of a system with their integrator, by default heyoka if it is installed.

    Derivatives are taken in the parameters named ``free``.
    """
    announce(stated)
    if backend is None:
        backend = Backend.TAYLOR if find_spec("heyoka") else Backend.RUNGE
    chosen, when, sticking = choice("backend", backend, Backend), None, list[int]()
    if section is not None:
        section.check_on(system)
        if not isinstance(section.when, str):
            names = [each.name for each in system.contacts]
            when, sticking = section.when, [names.index(each) for each in section.sticking]
    eq, integrated = Equations(system, free, when, sticking), dop853
    if chosen is Backend.TAYLOR:
        from woodpecker.systems.simulation.taylor import jets, taylor

        eq.jets, integrated = cache(partial(jets, eq)), taylor
    eq.flow = cache(partial(integrated, eq))
    eq.again = partial(assembled, system, free, chosen, section)
    return eq


class Run:
    """A motion from a state until its return, or until a time, as far as it has been followed.

    The state ``z`` moves on. Without the ``embedding`` of a section the motion ends at ``t_end``.
    It ``keeps`` steps, with their starts, for samples.
    """

    def __init__(
        self, eq: Equations, z: Floats, p: Floats, embedding: Embedding | None = None, *,
        t_end: float = math.inf, events_most: int = EVENTS_MOST, keeps: bool = False,
    ) -> None:  # fmt: skip
        self.eq, self.z, self.p, self.embedding = eq, z, p, embedding
        self.t_end, self.events_most, self.keeps = t_end, events_most, keeps
        self.status, self.message = MotionStatus.EVENT_LIMIT, MotionStatus.EVENT_LIMIT.value
        self.legs, self.durations, self.last = list[PathPhase](), list[float](), None
        self.symbols, self.events = list[str](), list[MotionEvent]()
        self.steps = list[tuple[float, Step]]()

    last: Impact | None

    @property
    def point(self) -> Floats:
        """The point (d,) of the section at which it has returned; nan if it has not."""
        assert self.embedding is not None
        if not self.status.success:
            return np.full(self.embedding.d, np.nan)
        return self.embedding.point(self.z, self.p, self.turns)

    @property
    def turns(self) -> int:
        """By how many periods time has advanced."""
        return 0 if self.embedding is None else self.embedding.turns(self.z, self.p)

    def stop(self, why: StoppedError) -> Run:
        """End the motion."""
        self.status, self.message = why.status, str(why)
        return self

    def follow(self, touch: ContactState, striking: Sequence[int] = ()) -> Run:
        """Run the loop of Figure 1 [Leine2001], from what touches and what strikes at the start."""
        self._begins = [0]  # number of symbols where each leg begins
        self._open = False  # whether impulses of an impact were not unique
        self._start, self._begins_on = float(self.z[-1]), self.embedding is not None
        if self.embedding is not None:
            self.t_end = self._start + self.embedding.section.horizon
        before = sticking(self.eq, touch)  # states from which the first transitions are named
        try:
            impact: Impact | None = None
            if striking:
                impact, touch = self._strike({*striking, *touch.closed}, touch)
            for _ in range(self.events_most):
                resting = resting_mode(self.eq, self.z, self.p, touch)
                mode = resting or settle(self.eq, self.z, self.p, touch)
                before, sets = self._name_transitions(before, mode, touch), self.eq.sets(mode)
                held = sets.closed.tolist(), sets.stuck.tolist()
                if resting or terms_at_rest(self.eq, self.z, self.p, *held):
                    raise StoppedError(MotionStatus.AT_REST)
                guard = self._flow(mode, touch)  # integrate until an event
                self.legs.append(PathPhase(impact, self._closes, self._lap, touch, mode, guard))
                self._begins.append(len(self.symbols))
                impact, touch = self._event(mode, guard)
                if impact is not None:
                    before = _after_impact(before, touch)
        except StoppedError as stop:
            if stop.status is MotionStatus.RETURNED and self._open:
                stop = StoppedError(MotionStatus.RETURNED_INDETERMINATE)
            self.stop(stop)
        return self

    _start: float  # the time at which it starts
    _begins_on: bool  # whether it has not left the section yet
    _longest = 0.0  # longest duration of a phase so far
    _flown: Floats | float = 0.0  # largest change of the gaps in a phase so far
    _closes: tuple[int, ...] = ()
    _lap = 0

    # --- Phases -----------------------------------------------------------------------------------

    def _flow(self, mode: Mode, touch: ContactState) -> int:
        """Integrate the equations of motion for given index sets until an event; its guard."""
        if self._begins_on and self.legs:
            assert self.embedding is not None
            here = Local(self.eq, mode, self.z, self.p)
            self._begins_on = self.embedding.is_on(here, float(self.z[-1]) - self._start)
        guard, t, z = self.first_event(
            mode, self.z, touch, self.t_end - self.z[-1], on_section=self._begins_on
        )
        self.durations.append(t)
        self._longest = max(self._longest, t)
        self.z = z
        self._check_gaps(mode)
        if guard != TIME and t > 0.0 and self._is_reached(mode):
            return SECTION * self.eq.m
        if guard == TIME:
            self.legs.append(PathPhase(None, (), 0, touch, mode, TIME))
            if self.embedding is None:
                raise StoppedError(MotionStatus.TIME_REACHED)
            raise StoppedError(MotionStatus.HORIZON, self.embedding.section.missed)
        return guard

    def _is_reached(self, mode: Mode) -> bool:
        """Whether the section was reached in the instant in which another guard has fired."""
        # By rounding it lies behind that event, or at the start of the next phase: it would be
        # passed over.
        if self.embedding is None or not self.eq.sets(mode).counts:
            return False
        here, now = Local(self.eq, mode, self.z, self.p), float(self.z[-1])
        value, rate = here.jet(SECTION * self.eq.m, 1)
        return (
            rate * self._near() <= value <= -rate * LATE * math.ulp(now)
            and rate < 0.0
            and not self.embedding.is_on(here, now - self._start)
        )

    def _check_gaps(self, mode: Mode) -> None:
        """Stop where an open contact is penetrated by more than rounding explains."""
        z, eq = self.z, self.eq
        terms = eq.terms(z, self.p)
        flown = np.abs(terms.gap_rate) * self.durations[-1]
        self._flown = np.maximum(self._flown, flown)
        if min(terms.gap.tolist()) >= -PENETRATED:
            return
        size = 1.0 + np.abs(terms.w_n) @ np.abs(z[: eq.n]) + flown
        if (terms.gap < -PENETRATED * size)[np.array(mode) == OPEN].any():
            raise StoppedError(MotionStatus.PASSED)

    def first_event(
        self, mode: Mode, z: Floats, touch: ContactState, most: float, *, on_section: bool = False,
        ignored: Set[int] = frozenset(),
    ) -> tuple[int, float, Floats]:  # fmt: skip
        """The guard that fires first in a phase, when, and the state there; TIME if none does."""
        if most <= 0.0:
            return TIME, 0.0, z
        eq = self.eq
        sets = eq.sets(mode)
        guards, (orders, fires) = tuple(sets.places), beginning(sets, touch, on_section)
        skipped, steps = 0 * orders, eq.flow(mode)(z, self.p, most)
        if ignored:
            skipped = np.array([int(guard in ignored) for guard in guards])
        elif self.keeps:
            steps = self._noted(steps)
        k, begin, time, step = first_of(steps, orders, fires, skipped)
        assert step is not None
        if k >= 0 and eq.jets is None and (begin or time > SHORT * step.length):
            # the root is that of an interpolant, not of the derivatives at the start of the phase
            here, zeros = Local(eq, mode, step.exact(time)[0], self.p), 0 if begin else orders[k]
            time += _correction(here, guards[k], step, step.guards[k, :zeros], time)
        return guards[k] if k >= 0 else TIME, begin + time, step.exact(time)[0]

    def _noted(self, steps: Iterable[Step]) -> Iterator[Step]:
        """Keep steps, with their starts, as they pass; if they stop, the state is at their end."""
        t, step = float(self.z[-1]), None
        try:
            for step in steps:
                self.steps.append((t, step))
                t += step.length
                yield step
        except StoppedError:
            if step is not None:
                self.z = step.exact(step.length)[0]
            raise

    # --- Events -----------------------------------------------------------------------------------

    def _event(self, mode: Mode, guard: int) -> tuple[Impact | None, ContactState]:
        """Carry out the event of a guard: the return, an impact, or only new index sets."""
        m = self.eq.m
        self._closes, self._lap = (), 0
        if guard == SECTION * m:
            raise StoppedError(MotionStatus.RETURNED)
        kind, i = divmod(guard, m)
        near = self._near()
        # what was exactly zero at the start of a phase of no duration is so still
        at_once = self.durations[-1] <= near
        last = self.legs[-1].touch if at_once else ContactState(frozenset())
        sets = self.eq.sets(mode)
        closed, held = last.closed | sets.touching, last.held | sets.held
        if kind == GAP:
            terms = self.eq.terms(self.z, self.p)
            if terms.gap_rate[i] >= 0.0:  # it grazes, but for rounding
                return None, ContactState(closed | {i}, held, before=mode)
            rate = terms.gap_rate
            away = self._flown + np.abs(terms.w_n) @ np.abs(self.z[: self.eq.n])
            room = np.maximum(-rate * near, ROUNDED * away)
            more = {
                k for k in range(m)
                if mode[k] == OPEN and k != i and rate[k] < 0.0 and terms.gap[k] <= room[k]
            }  # fmt: skip
            impact, touch = self._strike(closed | more | {i}, ContactState(closed, held))
            if self.embedding is not None and self.embedding.contact in ({i} | more):
                self.last = impact
                raise StoppedError(MotionStatus.RETURNED)
            return self._accumulated(impact, touch)
        fired = frozenset({guard})
        if kind == SLIP:
            held |= {i}
        elif all(each < SLIP * m for each in last.fired):
            # forces have not jumped since; those of some states are zero, or at their bound
            zero = {REDUNDANT: NORMAL, EDGE_UP: CONE_DOWN, EDGE_DOWN: CONE_UP}
            fired |= last.fired | {zero[mode[k]] * m + k for k in range(m) if mode[k] in zero}
        touch = ContactState(closed, held, frozenset(), fired, mode)
        return None, implied(self.eq, self.z, self.p, touch)

    def _near(self) -> float:
        """Time within which events are simultaneous, as rounding does not tell them apart."""
        return max(TOGETHER * self._longest, LATE * math.ulp(float(self.z[-1])))

    def _strike(self, contacts: Set[int], touch: ContactState) -> tuple[Impact, ContactState]:
        """Solve the contact problems of compression and expansion; the impact, and what touches."""
        terms, before = self.eq.terms(self.z, self.p), self.z
        impact, self.z, impulses = decide(self.eq, terms, contacts, before, touch)
        self._open |= impact.is_open
        self._note(impact.symbol, before, impulses)
        return impact, after(self.eq, self.z, self.p, impact)

    def _note(
        self, symbol: str, before: Floats | None = None, impulses: Floats = NO_IMPULSES
    ) -> None:
        u = slice(self.eq.n, 2 * self.eq.n)
        before = self.z if before is None else before
        self.symbols.append(symbol)
        self.events.append(
            MotionEvent(
                symbol=symbol, time=float(self.z[-1]), before=before[u], after=self.z[u],
                impulses=impulses,
            )
        )  # fmt: skip

    def _name_transitions(self, before: Mode, mode: Mode, touch: ContactState) -> Mode:
        """Note contacts that opened, stuck, began to slip or reversed; the states as named."""
        m = self.eq.m
        mode = _shown(before, mode, self.eq.slips)
        for i, (old, new) in enumerate(zip(before, mode, strict=True)):
            if not self.eq.friction[i] and new != OPEN:
                continue
            letter = ""
            if new == OPEN:
                letter = "D" if old != OPEN else ""
            elif new == STICK:
                letter = "J" if old != STICK else ""
            elif old == STICK:
                letter = "S"
            elif max(touch.fired, default=-1) >= SLIP * m and new != old:
                letter = "R"
            if letter:
                self._note(f"{letter}{i + 1}")
        return mode

    # --- Accumulation -----------------------------------------------------------------------------

    def _accumulated(self, impact: Impact, touch: ContactState) -> tuple[Impact, ContactState]:
        """Go to the end of impacts if they accumulate; the impact of the leg, and what touches."""
        # They do only after a short flight; else both are as given. The impact is that which begins
        # the first lap.
        eq, flight = self.eq, 0.0  # since the last impact
        for leg, duration in zip(self.legs[::-1], self.durations[::-1], strict=True):
            flight += duration
            if leg.impact is not None:
                break
        else:
            return impact, touch
        if not touch.leaving or flight > BRIEF * self._longest:
            return impact, touch
        none = np.zeros((eq.size, 0))
        section = -1 if self.embedding is None else self.embedding.contact
        tail = accumulated_by(eq, self.z, self.p, none, impact, self._longest, section)
        if tail is None or tail.z[-1] > self.t_end or self._is_disturbed(tail, touch):
            return impact, touch
        if self.keeps:
            self.steps += [each for each in tail.flights if each[0] < tail.z[-1]]
        self.z = tail.z
        self._open |= tail.is_open
        self._closes = tail.group
        first = self._fold(impact)
        self._note("C" + "+".join(str(i + 1) for i in tail.group))
        return first, tail.touch

    def _is_disturbed(self, tail: Accumulation, touch: ContactState) -> bool:
        """Whether another event comes within twice the time of an accumulation."""
        try:
            mode = settle(self.eq, self.z, self.p, touch)
        except StoppedError:
            return True
        soon = 2.0 * float(tail.z[-1] - self.z[-1])
        guard, _, _ = self.first_event(mode, self.z, touch, soon, ignored=tail.passed)
        return guard != TIME

    def _fold(self, impact: Impact) -> Impact:
        """Keep only the first of laps that repeat up to an impact; the impact it begins with."""
        first, self._lap = laps(self.legs, impact)
        if not self._lap:
            return impact
        end = first + self._lap
        cut, symbols = self._begins[first], self.symbols
        long = self._begins[end] - cut
        while long and cut > 0 and symbols[cut - 1] == symbols[cut - 1 + long]:
            cut -= 1
        del symbols[cut:], self.legs[end:], self.durations[end:]
        self._begins = [min(each, cut) for each in self._begins[: end + 1]]
        return self.legs[first].impact or impact


def laps(legs: Sequence[PathPhase], impact: Impact) -> tuple[int, int]:
    """The first leg of the laps that repeat up to an impact, and how many legs a lap has (0: none).

    It is the shortest lap that has been repeated; else the shortest that begins with this impact.
    """
    whole = len(legs)
    starts = [k for k in range(1, whole + 1) if legs[-k].impact == impact]
    for k in starts:
        if 2 * k <= whole and legs[-k:] == legs[-2 * k : -k]:
            break
    else:
        k = starts[0] if starts else 0
    first = whole - k
    while k and first > 0 and legs[first - 1] == legs[first - 1 + k]:
        first -= 1
    while k and legs[first].impact is None:
        first += 1
    return first, k


def _correction(here: Local, guard: int, step: Step, zero: Floats, t: float) -> float:
    """A Newton step to the root of a guard, whose coefficients ``zero`` are rounding."""
    value, rate = here.jet(guard, 1)
    value -= float(zero @ t ** np.arange(len(zero)))
    return -value / rate if rate < 0.0 and abs(value) < POLISHED * step.length * -rate else 0.0


def _shown(before: Mode, mode: Mode, slips: tuple[int, ...]) -> Mode:
    """States for a word: an idle contact is like those with its slip, or as it was before."""
    states = [STICK if state in (EDGE_UP, EDGE_DOWN) else state for state in mode]
    moves = {slips[i]: state for i, state in enumerate(states) if state not in (OPEN, REDUNDANT)}
    return tuple(
        moves.get(slips[i], before[i] or SLIDE_UP) if state == REDUNDANT else state
        for i, state in enumerate(states)
    )


def _after_impact(before: Mode, touch: ContactState) -> Mode:
    """States from which transitions are named: a contact that an impact has closed slides."""
    return tuple(
        SLIDE_UP if state == OPEN and i in touch.closed else state for i, state in enumerate(before)
    )
