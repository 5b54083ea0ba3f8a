"""Sections: where a return map starts and ends, and the d symbols of the state free there."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import sympy

from pwmap.algebra.arguments import explained_fields
from pwmap.diagrams.shown import listed
from woodpecker.base.arrays import Floats
from woodpecker.base.checks import number, positive
from woodpecker.base.counting import Counter
from woodpecker.base.shown import shown
from woodpecker.systems.mechanics.equations import Equations, Terms, compiled
from woodpecker.systems.mechanics.expressions import check_known, smooth, vanishes
from woodpecker.systems.mechanics.index_sets import SECTION, ContactState, Mode
from woodpecker.systems.mechanics.model import ContactSystem, names, namesake, no_inertia
from woodpecker.systems.mechanics.modes import Local
from woodpecker.systems.mechanics.settling import project_to_rest, settle
from woodpecker.systems.mechanics.status import MotionStatus, StoppedError

ROUNDING = 1e-12  # smaller gaps and rates [m, m/s] of a start count as zero
UNMOVED = 2.0**-48  # of the terms of an event: what rounding may leave of zero
HORIZON = 1e4  # longest time of a return [s] unless a section says otherwise


@explained_fields
@dataclass(frozen=True, kw_only=True, eq=False)
class Section:
    """An event, and the symbols of the state that are free there.

    Parameters
    ----------
    when
        The event: the name of a contact, for its impacts (the state after one counts); or an
        expression of state and parameters that rises through zero, such as ``sin(w*t)`` for a
        phase, or a velocity for a minimum.
    free
        The d symbols of the state that are free on the section: the coordinates of the map.
    at
        Values of other symbols of the state there, as expressions of free ones and of parameters;
        those that are not named are zero.
    sticking
        Names of contacts that must stick when the event counts.
    period
        Period of time, if time is free: it is taken modulo this, from ``first`` on.
    first
        The least value of time [s] on the section.
    horizon
        Longest time of one return [s].

    Raises
    ------
    ValueError, TypeError
        If an argument is of a wrong type or value.

    Examples
    --------
    >>> from sympy import symbols
    >>> from woodpecker.systems import Section
    >>> Section(when="floor", free=["u_y"]).free
    (u_y,)
    """

    when: Any
    free: Sequence[Any]
    at: Mapping[Any, Any] = field(default_factory=dict)
    sticking: Sequence[str] = ()
    period: Any = None
    first: float = 0.0
    horizon: float = HORIZON

    def __post_init__(self) -> None:
        put = object.__setattr__
        if not isinstance(self.when, str):
            put(self, "when", _event("when", self.when))
        put(self, "free", names("free", self.free))
        if not isinstance(self.at, Mapping):
            raise TypeError(f"at must be a mapping of symbols to expressions, got {shown(self.at)}")
        made = {names("at", [key])[0]: _event(f"at {key}", each) for key, each in self.at.items()}
        put(self, "at", made)
        if isinstance(self.sticking, str):
            raise TypeError(f"sticking must be a list of names, got {self.sticking!r}")
        put(self, "sticking", tuple(self.sticking))
        if self.period is not None:
            put(self, "period", _event("period", self.period))
        put(self, "first", number("first", self.first))
        put(self, "horizon", positive("horizon", self.horizon))

    def check_on(self, system: ContactSystem) -> None:
        """Raise ValueError unless it is a section of a system."""
        known, parameters, free = set(system.state), set(system.parameters), set(self.free)
        _check_symbols("free", self.free, known, f"no symbol of the state {system.state}")
        for each, value in self.at.items():
            _check_symbols("at", [each], known - free, "free or no symbol of the state")
            own = sorted(value.free_symbols, key=str)
            _check_symbols(f"at {each}", own, parameters | free, "neither free nor a parameter")
        names, event = [each.name for each in system.contacts], self.when
        for name in (*self.sticking, *[event] * isinstance(event, str)):
            if name not in names:
                raise ValueError(f"{name!r} is no contact, the system has {names}")
        if not isinstance(event, str):
            for other in sorted(event.free_symbols - parameters - known, key=str):
                raise ValueError(
                    f"when has the unknown symbol {other}{namesake(other, parameters | known)}"
                )
            if not event.free_symbols & known:
                raise ValueError(f"when must have symbols of the state, got {event}")
        if (self.period is not None) != (system.time in free):
            raise ValueError(
                "a period is needed just if time is free on the section, such as period=2*pi/w of "
                f"a force of frequency w, got free={shown(list(self.free))} and "
                f"period={shown(self.period)}"
            )
        if self.period is not None:
            own = sorted(self.period.free_symbols, key=str)
            _check_symbols("period", own, parameters, "no parameter")

    @property
    def missed(self) -> str:
        """A sentence on what does not happen where a motion does not return."""
        event = f"{self.when!r} is not struck"
        if not isinstance(self.when, str):
            event = f"{self.when} does not rise through zero"
            if self.sticking:
                sticks = "sticks" if len(self.sticking) == 1 else "stick"
                event += f" while {listed(map(repr, self.sticking))} {sticks}"
        return f"{event} within {self.horizon:g} s, the longest time of the section"


def _check_symbols(
    what: str, found: Iterable[sympy.Symbol], known: set[sympy.Symbol], unknown: str
) -> None:
    """ValueError if a symbol is not among the known ones; ``unknown`` says what it is then."""
    for each in found:
        if each not in known:
            raise ValueError(f"{what} has {each}, which is {unknown}{namesake(each, known)}")


def _event(name: str, value: Any) -> sympy.Expr:
    """A smooth expression of plain symbols."""
    found = smooth(name, value)
    check_known(name, found)
    return found


class Embedding:
    """A section of a system in numbers: its points as states, and states as points.

    Parameters
    ----------
    eq
        The equations, with the free parameters of the map.
    section
        The section.

    Attributes
    ----------
    d
        The number of free coordinates.
    own
        Values of all parameters; those that are free in the map do not matter.
    touch
        Which contacts touch on the section.
    contact
        The contact whose impacts it is; -1 for an expression.
    state(x, p)
        The state (N,) of a point, and its derivatives (N, d + k).
    """

    def __init__(self, eq: Equations, section: Section) -> None:
        self.eq, self.section, self.own = eq, section, eq.p
        self.counter = Counter()  # of returns, by search or along a path
        system = eq.system
        self.names = [each.name for each in eq.contacts]
        self.d = len(section.free)
        self.contact = self.names.index(section.when) if isinstance(section.when, str) else -1
        self.places = [system.state.index(each) for each in section.free]
        zero = sympy.Integer(0)
        whole = [s if s in section.free else section.at.get(s, zero) for s in system.state]
        self._at = dict(zip(system.state, whole, strict=True))
        period = [section.period if s == system.time else zero for s in section.free]
        along, parameters = (*section.free, *eq.along[eq.size :]), tuple(system.parameters)
        self.state, self._period = (
            compiled(symbols, [rows, sympy.Matrix(rows).jacobian(along)])
            for symbols, rows in (((*section.free, *parameters), whole), (parameters, period))
        )  # fmt: skip
        self._check_event()
        self.touch = self._touching()

    def __reduce__(self) -> tuple[Any, ...]:
        return Embedding, (self.eq, self.section), {"own": self.own}

    def _check_event(self) -> None:
        """ValueError if the section is not at its event because ``at`` omits one of its symbols."""
        # symbols that are named may place it at another event, which a symmetry makes the same
        section, system = self.section, self.eq.system
        event: sympy.Expr = section.when
        if self.contact >= 0:
            event = self.eq.expressions.gap[self.contact]
        zeros = event.free_symbols & {*system.state} - {*section.free, *section.at}
        if zeros and not vanishes(there := event.subs(self._at)):
            what = f"the gap of {section.when!r}" if self.contact >= 0 else str(event)
            names = listed(sorted(map(str, zeros)))
            raise ValueError(
                f"{what} must be zero on the section, and is {there}: give {names} in at, zero "
                "otherwise"
            )

    def _touching(self) -> ContactState:
        """What touches at every point of the section."""
        closed, held, leaving = set[int](), set[int](), set[int]()
        terms = self.eq.expressions
        for i in range(self.eq.m):
            if not vanishes(terms.gap[i].subs(self._at)):
                continue
            if not vanishes(terms.gap_rate[i].subs(self._at)):
                leaving.add(i)
                continue
            closed.add(i)
            if self.eq.friction[i] and vanishes(terms.slip[i].subs(self._at)):
                held.add(i)
        return ContactState(frozenset(closed), frozenset(held), frozenset(leaving))

    def values(self, p: Floats) -> Floats:
        """Values of all parameters, with those of the map in their places."""
        found = self.own.copy()
        found[self.eq.places] = p
        return found

    def obstacle(self, x: Floats, p: Floats) -> str:
        """Why masses, friction or restitution are out of range at a point (d,); empty if not."""
        values = self.values(p)
        terms = self.eq.terms(self.state(x, values)[0], values)
        for name, mu, eps in zip(self.names, terms.mu.tolist(), terms.eps.tolist(), strict=True):
            if mu < 0.0:
                return f"mu of {name!r} must be >= 0, got {mu:.12g}"
            if eps < 0.0 or eps > 1.0:
                return f"eps_n of {name!r} must be in [0, 1], got {eps:.12g}"
        return no_inertia(terms.mass)

    def begin(self, z: Floats, p: Floats) -> tuple[Floats, ContactState, list[int]]:
        """The state, what touches, and what strikes at the start of a motion; or StoppedError.

        Contacts may touch, or stick, here that do not at every point of the section.
        """
        terms, known = self.eq.terms(z, p), self.touch
        slow = np.abs(terms.gap_rate) <= ROUNDING
        # a gap that opens here, and is negative by rounding, has the path of those beside it
        near = ROUNDING * _size(terms, z)
        least = np.where(slow, near, np.where(terms.gap_rate > 0.0, -near, 0.0))
        clear = (terms.gap > least) | ((terms.gap == 0.0) & ~slow)
        clear[list(known.leaving)] = terms.gap_rate[list(known.leaving)] > 0.0
        slides = ~np.array(self.eq.friction) | (np.abs(terms.slip[: self.eq.m]) > ROUNDING)
        clear[list(known.closed)] = slides[list(known.closed)]
        clear[list(known.held)] = True
        if clear.all():
            return z, known, []
        touch, striking = touching(self.eq, z, p)
        for i in known.leaving & {*striking}:
            raise StoppedError(
                MotionStatus.INSIDE,
                f"the start moves into {self.names[i]!r}, which it has just left: the rate of its "
                f"gap is {terms.gap_rate[i]:.3g}",
            )
        closed, held = touch.closed | known.closed, touch.held | known.held
        found = ContactState(closed, held, touch.leaving)
        if not striking:  # a slip of zero that starts at once counts as sliding
            mode = settle(self.eq, z, p, found, checks=False)
            slips = {self.eq.slips[i] for i in self.eq.sets(mode).stuck}
            turning = {i for i in known.closed - known.held if self.eq.slips[i] not in slips}
            if held & turning:
                found = ContactState(closed, held - turning, touch.leaving)
                mode = settle(self.eq, z, p, found, checks=False)
            z, _ = self.resting(z, p, np.zeros((self.eq.size, 0)), found, mode)
        return z, found, striking

    def resting(
        self, z: Floats, p: Floats, tangents: Floats, touch: ContactState, mode: Mode
    ) -> tuple[Floats, Floats]:
        """A state of the section, and derivatives, if contacts rest that do not at every point.

        Their gaps and slips are held at zero: a small gap would close at once, a small slip stop.
        """
        if touch.closed <= self.touch.closed and touch.held <= self.touch.held:
            return z, tangents
        sets = self.eq.sets(mode)
        return project_to_rest(self.eq, z, p, tangents, sets.closed.tolist(), sets.stuck.tolist())

    def is_on(self, here: Local, elapsed: float) -> bool:
        """Whether a motion is still on the section, up to rounding, after a time [s]."""
        if not here.sets.counts:
            return elapsed == 0.0
        guard = SECTION * self.eq.m
        size = np.abs(here.gradient(guard)[: self.eq.size]) @ np.maximum(np.abs(here.z), 1.0)
        value, rate = here.jet(guard, 1)
        return bool(max(abs(value), elapsed * abs(rate)) <= UNMOVED * size)

    def point(self, z: Floats, p: Floats, turns: int) -> Floats:
        """The coordinates (d,) of a state on the section, with time reduced by periods."""
        return z[self.places] - turns * self._period(p)[0] if turns else z[self.places]

    def changes(self, tangents: Floats, p: Floats, turns: int) -> Floats:
        """Derivatives (d, d + k) of those coordinates."""
        found = tangents[self.places]
        return found - turns * self._period(p)[1] if turns else found

    def turns(self, z: Floats, p: Floats) -> int:
        """By how many periods time has advanced."""
        if self.section.period is None:
            return 0
        period = float(self._period(p)[0][self.of_time])
        return int(np.floor((z[-1] - self.section.first) / period)) if period > 0.0 else 0

    def phase_margins(
        self, x: Floats, jacobian: Floats, p: Floats
    ) -> tuple[tuple[float, Floats], tuple[float, Floats]]:
        """Distances of time at a point from both ends of a period, with derivatives (d + k,)."""
        k = self.of_time
        (period, longer), t = (each[k] for each in self._period(p)), float(x[k])
        t -= self.section.first
        return (t, jacobian[k]), (float(period) - t, longer - jacobian[k])

    @property
    def of_time(self) -> int:
        """Which coordinate is time."""
        return self.section.free.index(self.eq.system.time)


def touching(eq: Equations, z: Floats, p: Floats) -> tuple[ContactState, list[int]]:
    """The contacts that touch at a state: those that stay or leave, and those that strike.

    Raises
    ------
    StoppedError
        If a contact is penetrated.
    """
    terms = eq.terms(z, p)
    size = _size(terms, z)
    closed, held, leaving, striking = set[int](), set[int](), set[int](), list[int]()
    for i, each in enumerate(eq.contacts):
        gap, rate, slip = terms.gap[i], terms.gap_rate[i], terms.slip[i]
        if gap < -ROUNDING * size[i]:
            sentence = f"the start penetrates {each.name!r}: its gap is {gap:.3g}"
            raise StoppedError(MotionStatus.INSIDE, sentence)
        if gap > ROUNDING * size[i]:
            continue
        if rate < -ROUNDING:
            striking.append(i)
        elif rate > ROUNDING:
            leaving.add(i)
        else:
            closed.add(i)
            if abs(slip) <= ROUNDING:
                held.add(i)
    return ContactState(frozenset(closed), frozenset(held), frozenset(leaving)), striking


def _size(terms: Terms, z: Floats) -> Floats:
    """Sizes (m,) of the terms of which gaps are differences."""
    return np.asarray(1.0 + np.abs(terms.w_n) @ np.abs(z[: terms.w_n.shape[1]]))
