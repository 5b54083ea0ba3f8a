"""Accumulating impacts: the state in which they end, once flights are short.

In a short flight gaps are cubics of time. Gaps and gap rates are followed from impact to impact as
small numbers of their own, so that the rounding of coordinates does not decide the order of impacts
at several contacts. Where laps of impacts shrink by a constant ratio, the rest is a geometric
series; a bouncing contact has laps of one impact. In a flight slips may reverse or stop.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from copy import copy
from dataclasses import replace

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.systems.mechanics.equations import Equations
from woodpecker.systems.mechanics.impacts import (
    Impact,
    carry_out,
    decide,
    is_implied,
    total,
)
from woodpecker.systems.mechanics.index_sets import GAP, OPEN, SLIDE_UP, SLIP, ContactState, Mode
from woodpecker.systems.mechanics.modes import Local
from woodpecker.systems.mechanics.settling import project_to_rest, settle
from woodpecker.systems.mechanics.status import MotionStatus, StoppedError
from woodpecker.systems.simulation.flows import Step, along

SHORT = 2.0**-17  # of the time scale of a motion: what a gap's cubic leaves out is below rounding
VANISHED = 2.0**-52  # relative: smaller speeds count as zero
PRECISE = VANISHED / SHORT  # of the first short flight: rounding is that of longer ones before
TOGETHER = 2.0**-44  # of a phase: gaps that close within this time close at once
IMPACTS_MOST = 3000  # from short flights to none a ratio of 0.99 needs so many
LAP_MOST = 8  # impacts of a lap
TURNS_MOST = 8  # times that slips vanish in one flight
LASTS = SHORT  # part of its speeds that a lap must lose: with less IMPACTS_MOST impacts would lose
# hardly any of them
SOLVED = 4  # Newton steps to the root of a cubic, from that of its quadratic part


def accumulated_by(
    eq: Equations, z: Floats, p: Floats, tangents: Floats, impact: Impact, longest: float,
    section: int = -1,
) -> Accumulation | None:  # fmt: skip
    """Follow short flights and impacts, from an impact on, until they have closed contacts.

    None if flights are not short (none may be longer than the longest phase so far), lead away, or
    end at the contact of the section, or if impacts lose hardly any speed; StoppedError if they
    lose none and take no time.
    """
    tail, found = Accumulation(eq, z, p, tangents, impact), None
    for _ in range(IMPACTS_MOST):
        try:
            # without forces the time scale of a motion is infinite, and any flight is short
            if not tail.flies() or section in tail.striking or tail.span > longest:
                break
            tail.strikes()
        except StoppedError:  # the contact laws give no motion
            break
        closed = tail.vanished() or tail.series()
        if closed:
            tail.close(closed)
            # what follows may close more contacts, but what takes longer is no part of it
            found, longest = copy(tail), min(longest, tail.age)
        elif tail.lasts():
            break
    return found


class Accumulation:
    """Short flights and impacts in turns, as far as they have been followed.

    They have reached the state ``z`` (N,) with derivatives ``tangents`` (N, columns); ``touch`` is
    what touches there. It ``is_open`` if impulses of an impact were not unique. ``flights`` are
    steps for samples, with their starts; copies share them.
    """

    def __init__(
        self, eq: Equations, z: Floats, p: Floats, tangents: Floats, impact: Impact
    ) -> None:
        self._eq, self._p, self.z, self.tangents, self.is_open = eq, p, z, tangents, False
        self.touch, self.flights = after(eq, z, p, impact), list[tuple[float, Step]]()
        touch = self.touch
        self._before = touch.closed
        terms = eq.terms(z, p)
        self._gap, self._rate = terms.gap.copy(), terms.gap_rate.copy()
        self._turn = self._along(0)
        self._rest(touch)
        self._fastest: dict[Mode, float] = {}
        self._first = float(np.abs(self._rate[list(touch.leaving)]).max(initial=0.0))
        self._held = {i: i in impact.held for i in impact.contacts}  # of those that have struck
        self._flight = 0.0  # duration of the first flight
        # copies after each impact, and after each closing of contacts; time since the last of these
        self._marks, self.span = list[Accumulation](), math.inf
        self._mark(impact)
        self.striking = frozenset[int]()
        self._slips = frozenset[int]()

    @property
    def group(self) -> tuple[int, ...]:
        """The contacts that have closed since, ascending."""
        return tuple(sorted(self.touch.closed - self._before))

    @property
    def age(self) -> float:
        """Time since the impact from which it has been followed."""
        return sum(each.span for each in self._marks[1:])

    @property
    def passed(self) -> frozenset[int]:
        """Guards that fired: gaps of contacts that took part in an impact, slips that vanished."""
        m = self._eq.m
        return frozenset(GAP * m + i for i in self._held) | {SLIP * m + i for i in self._slips}

    def _along(self, kind: int) -> Floats:
        """Derivatives (m, columns) of gaps (0), gap rates (1) or slips (2) along the tangents."""
        return total(self._eq, self._eq.kinematic_changes(self.z, self._p)[kind], self.tangents)

    def _rest(self, touch: ContactState) -> None:
        """Set gaps and gap rates to exactly zero where contacts touch."""
        touching = sorted(touch.closed | touch.leaving)
        self._gap[touching], self._turn[touching] = 0.0, 0.0
        self._rate[sorted(touch.closed)] = 0.0

    # --- Flights ----------------------------------------------------------------------------------

    def flies(self) -> bool:
        """Move to the next impact, past slips that vanish before; False if there is none soon."""
        self.striking = frozenset()
        for _ in range(TURNS_MOST):
            if self.striking or not self._flies():
                break
        return bool(self.striking)

    def _flies(self) -> bool:
        """Move on until gaps close or a slip vanishes; False if that is not soon."""
        eq, size = self._eq, self._eq.size
        mode = settle(eq, self.z, self._p, self.touch)
        here, free = Local(eq, mode, self.z, self._p), [i for i in range(eq.m) if mode[i] == OPEN]
        flow, second = here.flow, here.terms.w_n @ here.balance.a + here.terms.bar_n
        changes, third = np.zeros((eq.m, eq.columns)), np.zeros(eq.m)
        for i in free:
            changes[i] = here.gradient(GAP * eq.m + i, 2)
            third[i] = changes[i, :size] @ flow
        cubics = np.stack([self._gap, self._rate, second, third], axis=1)
        times = [_root(*cubics[i].tolist()) if i in free else math.inf for i in range(eq.m)]
        t, (early, slip, bent) = min(times), self._first_slip(here)
        if early < t:
            t, steady = early, bent <= SHORT and early * self._fastest_in(here) <= SHORT
        else:
            slip = -1
            steady = t < math.inf and self._is_short(here, t, cubics[times.index(t)])
        if not steady:
            return False
        near = max(TOGETHER * t, PRECISE * (self._flight or t))
        if slip < 0:
            self.striking = frozenset(i for i in free if times[i] <= t + near)
        turn = self._along(1) * t + 0.5 * t * t * total(eq, changes, self.tangents)
        self._gap = self._gap + t * (self._rate + t * (second / 2.0 + t * third / 6.0))
        self._rate = self._rate + t * (second + t * third / 2.0)
        self._move(here, t, times.index(min(times)), turn, slip)
        self._gap[sorted(self.striking)] = 0.0
        self._leave(mode, slip)
        return True

    def _first_slip(self, here: Local) -> tuple[float, int, float]:
        """When a slip first vanishes in a flight, at which contact, and how its rate changes."""
        # Infinite and -1 if none does; the change is relative.
        eq, found = self._eq, (math.inf, -1, 0.0)
        for guard in here.sets.places:
            kind, i = divmod(guard, eq.m)
            if kind == SLIP:
                value, rate, bend = here.jet(guard)
                t = _root(0.0 if i in self.touch.held else value, rate, bend, 0.0)
                if t < found[0]:
                    found = t, i, abs(bend) * t / abs(rate) if rate else math.inf
        return found

    def _leave(self, mode: Mode, slip: int) -> None:
        """Find what touches at the end of a flight, where a slip (-1: none) may have vanished."""
        sets = self._eq.sets(mode)
        closed, held = sets.touching, sets.held
        fired = frozenset[int]()
        if slip >= 0:
            held, fired = held | {slip}, frozenset({SLIP * sets.m + slip})
            slips = self._eq.slips
            self._slips |= {i for i in closed if slips[i] == slips[slip]}
        touch = ContactState(closed, held, frozenset(), fired, mode)
        self.touch = implied(self._eq, self.z, self._p, touch)

    def _move(self, here: Local, t: float, i: int, turn: Floats, slip: int) -> None:
        """Move the state and its derivatives to the end of a flight."""
        # It ends where the slip of contact ``slip`` vanishes or, if that is -1, gap i closes.
        eq, jacobian = self._eq, here.jacobian
        bends = jacobian[:, : eq.size] @ here.flow
        twists = jacobian[:, : eq.size] @ bends
        flight = along(t, self.z, here.flow, bends / 2.0, twists / 6.0)
        self.flights.append((float(self.z[-1]), flight))
        self.z = self.z + t * (here.flow + t * (bends / 2.0 + t * twists / 6.0))
        self.span += t
        self._flight = self._flight or t
        if not self.tangents.shape[1]:
            return
        turn = self._turn + turn
        moved = total(eq, jacobian, self.tangents)
        curved = jacobian[:, : eq.size] @ moved
        self.tangents = self.tangents + t * (moved + t * curved / 2.0)
        if slip < 0:
            delay = -turn[i] / self._rate[i]
        else:
            _, rate, bend = here.jet(SLIP * eq.m + slip)
            sign = 1.0 if here.mode[slip] == SLIDE_UP else -1.0
            delay = -sign * self._along(2)[slip] / (rate + t * bend)
        end = here.flow + t * (bends + t * twists / 2.0)
        self.tangents = self.tangents + np.outer(end, delay)
        self._turn = turn + np.outer(self._rate, delay)

    def _is_short(self, here: Local, t: float, cubic: Floats) -> bool:
        _, rate, second, third = np.abs(cubic).tolist()
        steady = third * t * t <= SHORT * (2.0 * rate + second * t)
        return steady and t * self._fastest_in(here) <= SHORT

    def _fastest_in(self, here: Local) -> float:
        """Largest modulus of the eigenvalues of the motion in a mode [1/s]."""
        if here.mode not in self._fastest:
            whole = here.jacobian[:, : self._eq.size]
            self._fastest[here.mode] = float(np.abs(np.linalg.eigvals(whole)).max())
        return self._fastest[here.mode]

    # --- Impacts ----------------------------------------------------------------------------------

    def strikes(self) -> None:
        """Carry out the impact at the end of a flight."""
        eq, z = self._eq, self.z
        terms = eq.terms(z, self._p)._replace(gap_rate=self._rate)
        contacts = self.striking | self.touch.closed
        impact, self.z, impulses = decide(eq, terms, contacts, z, self.touch)
        self.is_open |= impact.is_open
        if self.tangents.shape[1]:
            self.tangents = carry_out(eq, impact, z, self._p, self.tangents)[1]
        given = impulses.sum(axis=0)
        kick = np.linalg.solve(terms.mass, given[0] @ terms.w_n + given[1] @ terms.w_t[: eq.m])
        self._rate = self._rate + terms.w_n @ kick
        self._held = self._held | {i: i in impact.held for i in impact.contacts}
        self.touch = after(eq, self.z, self._p, impact)
        self._rest(self.touch)
        self._mark(impact)

    def _mark(self, what: Impact | frozenset[int]) -> None:
        self._what = what  # the last impact, or the contacts that have closed
        self._marks.append(copy(self))
        self.span = 0.0

    # --- The end ----------------------------------------------------------------------------------

    def vanished(self) -> frozenset[int]:
        """Contacts that have struck and are not closed, if all of their speeds have vanished."""
        moving = frozenset(self._held) - self.touch.closed
        if np.abs(self._rate[sorted(moving)]).max(initial=0.0) > VANISHED * self._first:
            return frozenset()
        return moving

    def series(self) -> frozenset[int]:
        """Contacts whose laps of impacts shrink by a constant ratio; the rest has been summed."""
        for lap, group in self._laps():
            ratio = self._ratio(lap, sorted(group))
            if 0.0 <= ratio < 1.0 and self._sum(lap, ratio, group):
                return group
        return frozenset()

    def lasts(self) -> bool:
        """Whether laps lose hardly any speed and lead nowhere; StoppedError: none, in no time."""
        for lap, group in self._laps():
            new, old = self._marks[-1], self._marks[-1 - lap]
            struck, others = sorted(group), sorted(set(range(self._eq.m)) - group)
            speed = np.abs(old._rate[struck]).max(initial=0.0)
            lost = np.abs(new._rate - old._rate)[struck].max(initial=0.0)
            nears = new._gap + IMPACTS_MOST * np.minimum(new._gap - old._gap, 0.0)
            if lost >= LASTS * speed or (nears[others] < 0.0).any():
                continue
            if new.z[-1] == old.z[-1] and lost <= PRECISE * speed:
                raise StoppedError(MotionStatus.ENDLESS)
            return True
        return False

    def _laps(self) -> Iterator[tuple[int, frozenset[int]]]:
        """Lengths of laps that the last impacts have repeated, and the contacts that they close."""
        for lap in range(1, LAP_MOST + 1):
            if len(self._marks) < 2 * lap + 1:
                break
            last = self._marks[-1 - 2 * lap :]
            same = (last[k]._what == last[k + lap]._what for k in range(lap + 1))
            if all(same):
                what = (each._what for each in last)
                left = (w.leaving if isinstance(w, Impact) else w for w in what)
                yield lap, frozenset[int]().union(*left)

    def _ratio(self, lap: int, group: list[int]) -> float:
        """The ratio of the speeds of successive laps; 1 unless the last two laps agree on it."""
        new, old, oldest = (self._marks[-1 - k * lap]._rate[group] for k in range(3))
        spans = [sum(each.span for each in self._marks[-lap:])]
        spans.append(sum(each.span for each in self._marks[-2 * lap : -lap]))
        ratio = float(np.abs(new).max() / np.abs(old).max())
        if not ratio < 1.0:
            return 1.0
        off = max(np.abs(new - ratio * old).max(), np.abs(old - ratio * oldest).max())
        late = abs(spans[0] - ratio * spans[1])
        most = PRECISE * (1.0 - ratio)  # the sum multiplies errors by 1 / (1 - ratio)
        return ratio if off <= most * self._first and late <= most * self._flight else 1.0

    def _sum(self, lap: int, ratio: float, group: frozenset[int]) -> bool:
        """Add the rest of the series of laps; False if another contact strikes before its end."""
        new, old, n = self._marks[-1], self._marks[-1 - lap], self._eq.n
        rest, span = ratio / (1.0 - ratio), sum(each.span for each in self._marks[-lap:])

        def moved(late: Floats, early: Floats, rate: Floats) -> Floats:
            """The sum of a part at the final rate and of one that goes like the square of a lap."""
            bent = late - early - rate * span
            return late + rate * span * rest + bent * ratio**2 / (1.0 - ratio**2)

        rate = new._rate + (new._rate - old._rate) * rest
        gap = moved(new._gap, old._gap, rate)
        others = sorted(set(range(self._eq.m)) - group - self.touch.closed)
        if (gap[others] <= 0.0).any():
            return False
        away = new.z - old.z
        if self.tangents.shape[1]:
            k = max(group, key=lambda i: abs(float(new._rate[i])))
            turned = self._along(1)[k] - ratio * old._along(1)[k]
            change = turned / float(old._rate[k]) / (1.0 - ratio) ** 2
            self.tangents = (
                new.tangents + (new.tangents - old.tangents) * rest + np.outer(away, change)
            )
        self.z = new.z + away * rest
        self.z[:n] = moved(new.z[:n], old.z[:n], self.z[n : 2 * n])
        if span * rest > 0.0:  # the ratio is constant only where the motion hardly turns
            line = along(span * rest, new.z, (self.z - new.z) / (span * rest))
            self.flights.append((float(new.z[-1]), line))
        self._gap, self._rate, self.span = gap, rate, span * rest
        while len(self._marks) > lap and self._marks[-1]._what == self._marks[-1 - lap]._what:
            self.span += self._marks.pop().span
        return True

    def close(self, group: frozenset[int]) -> None:
        """Close contacts, which rest from now on."""
        eq, touch, stops = self._eq, self.touch, {i for i in group if self._held[i]}
        touch = ContactState(touch.closed | group, touch.held | stops, touch.leaving - group)
        self.touch = implied(eq, self.z, self._p, touch, frozenset(stops))
        closed, held = sorted(self.touch.closed), sorted(self.touch.held)
        self.z, self.tangents = project_to_rest(eq, self.z, self._p, self.tangents, closed, held)
        self._turn = self._along(0)
        self._rest(self.touch)
        self._mark(group)


def _root(gap: float, rate: float, second: float, third: float) -> float:
    """The root >= 0 of a cubic, by derivatives, near that of its quadratic part; inf if none."""
    within = rate * rate - 2.0 * second * gap
    if within < 0.0 or (rate >= 0.0 and second >= 0.0):
        return math.inf
    if rate < 0.0:
        t = 2.0 * gap / (math.sqrt(within) - rate)
    else:
        t = (math.sqrt(within) + rate) / -second
    for _ in range(SOLVED):
        slope = rate + t * (second + t * third / 2.0)
        if not slope < 0.0:
            return math.inf
        t -= (gap + t * (rate + t * (second / 2.0 + t * third / 6.0))) / slope
    return t if t >= 0.0 else math.inf


# --- What touches after an impact -----------------------------------------------------------------


def after(eq: Equations, z: Floats, p: Floats, impact: Impact) -> ContactState:
    """What touches after an impact."""
    touch = ContactState(impact.resting, impact.held & impact.resting, impact.leaving)
    return implied(eq, z, p, touch, impact.held, impact.given)


def implied(
    eq: Equations, z: Floats, p: Floats, touch: ContactState,
    stopped: frozenset[int] = frozenset(), given: frozenset[int] = frozenset(),
) -> ContactState:  # fmt: skip
    """Add to what touches the contacts that must rest or stick because others do.

    An impact has made the slips of ``stopped`` zero, and gives gap rates, even to some that leave.
    """
    closed, held = set(touch.closed), set(touch.held)
    if len(closed | touch.leaving) < 2:
        return touch
    terms = eq.terms(z, p)
    u, normal, along = z[eq.n : 2 * eq.n], sorted(closed | given), sorted(held | stopped)
    rows = np.vstack([terms.w_n[normal], terms.w_t[along]])
    rates = np.concatenate([terms.gap_rate[normal], terms.slip[along]])
    # those that have not left are at rest
    leave = np.array([i in given - closed for i in normal] + [False] * len(along), dtype=float)

    def vanishes(row: Floats, rate: float) -> bool:
        size = float(np.abs(row) @ np.abs(u))
        return is_implied(row, rate, rows, rates, size) and (
            not leave.any() or is_implied(row, 0.0, rows, leave * rates, size)
        )

    closed |= {i for i in touch.leaving - given if vanishes(terms.w_n[i], terms.gap_rate[i])}
    stuck = {eq.slips[i] for i in closed & held}  # slips that are equal need no comparison
    held |= {
        i for i in closed - held
        if eq.slips[i] in stuck or vanishes(terms.w_t[i], terms.slip[i])
    }  # fmt: skip
    return replace(
        touch, closed=frozenset(closed), held=frozenset(held), leaving=touch.leaving - closed
    )
