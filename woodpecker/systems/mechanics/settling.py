"""The contact problem on acceleration level: which mode follows an event, or whether all rests."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import product

import numpy as np
from scipy.optimize import linprog

from woodpecker.base.arrays import Floats
from woodpecker.mechanics.lcp import solve_contact_lcp
from woodpecker.systems.mechanics.equations import Equations, Terms
from woodpecker.systems.mechanics.impacts import is_implied, total
from woodpecker.systems.mechanics.index_sets import (
    CONE_DOWN,
    CONE_UP,
    EDGE_DOWN,
    EDGE_UP,
    GAP,
    KNOWN,
    NORMAL,
    OPEN,
    REDUNDANT,
    SLIDE_DOWN,
    SLIDE_UP,
    SLIP,
    STICK,
    ContactState,
    IndexSets,
    Mode,
    watched,
)
from woodpecker.systems.mechanics.modes import Local
from woodpecker.systems.mechanics.status import MotionStatus, StoppedError

MOST_MODES = 256  # combinations that are tried on acceleration level
NO_GUARD = -1  # the guard that fails if a mode has no motion
SAME = 1e-9  # relative: motions whose accelerations are closer are one


def settle(
    eq: Equations, z: Floats, p: Floats, touch: ContactState, *, checks: bool = True
) -> Mode:
    """Find the mode after an event by trying all combinations of states of the closed contacts.

    If there are too many, only some are, by a search. A mode is admissible if all guards of these
    contacts are positive right after the event, judged by the first derivative that it has not made
    zero. StoppedError if none is, or if two with different motions are; without ``checks`` the mode
    is then that of open contacts, or the first one.
    """
    if not touch.closed:
        return (OPEN,) * eq.m
    terms = eq.terms(z, p)
    # what slides keeps its direction, whatever rounding has made of a slip near zero
    slides = [SLIDE_UP if slip > 0.0 else SLIDE_DOWN for slip in terms.slip.tolist()]
    for i, state in enumerate(touch.before):
        slides[i] = state if state in (SLIDE_UP, SLIDE_DOWN) else slides[i]
    still = sticking(eq, touch, slides)
    modes = _combinations(still, eq.slips)
    if modes is None:
        kept = _search_mode(eq, z, p, touch, still)
    else:
        tried = [Local(eq, mode, z, p) for mode in _all_resolved(eq, terms, modes, still)]
        kept = [each for each in tried if next(_failing(each, touch), None) is None]
    if not checks:
        return kept[0].mode if kept else (OPEN,) * eq.m
    if not kept:
        if not np.isfinite(terms.force).all():
            raise StoppedError(MotionStatus.NO_FORCE)
        raise StoppedError(MotionStatus.NOT_FOUND if modes is None else MotionStatus.NO_SOLUTION)
    first = kept[0].balance.a
    apart = max(float(np.abs(each.balance.a - first).max()) for each in kept)
    if apart > 0.0:
        free = np.linalg.solve(terms.mass, terms.force)  # accelerations without contact forces
        if apart > SAME * (np.abs(first).max() + np.abs(free).max()):
            raise StoppedError(MotionStatus.AMBIGUOUS)
    return kept[0].mode


def sticking(eq: Equations, touch: ContactState, slides: Sequence[int] = ()) -> Mode:
    """The mode in which all closed contacts stay closed, and all that can stick do.

    The others slide as ``slides`` says, by default SLIDE_UP.
    """
    return tuple(
        OPEN if i not in touch.closed
        else SLIDE_UP if not eq.friction[i]
        else STICK if i in touch.held
        else slides[i] if slides else SLIDE_UP
        for i in range(eq.m)
    )  # fmt: skip


def resting_mode(eq: Equations, z: Floats, p: Floats, touch: ContactState) -> Mode | None:
    """The mode of a system at rest with more constraints than coordinates; else None.

    Its contact forces are not unique, so that guards decide nothing: it rests if any forces inside
    all cones balance the applied ones, which is a linear program.
    """
    if touch.leaving or len(touch.closed) + len(touch.held) <= eq.n:
        return None
    still = sticking(eq, touch)
    closed, held = sorted(touch.closed), sorted(eq.sets(still).held)
    slides = any(eq.friction[i] and still[i] != STICK for i in closed)
    terms = terms_at_rest(eq, z, p, closed, held)
    if slides or terms is None or len(closed) + len(held) == eq.n:
        return None
    rows = np.vstack([terms.w_n[closed], terms.w_t[held]])
    cones = np.zeros((2 * len(held), len(rows)))
    for k, i in enumerate(held):
        cones[2 * k : 2 * k + 2, closed.index(i)] = -terms.mu[i]
        cones[2 * k : 2 * k + 2, len(closed) + k] = 1.0, -1.0
    # each balance in a unit of its own, so that the sizes of forces and moments do not matter; no
    # arm is zero, as contacts hold all directions (held_by)
    arms = np.abs(rows).max(axis=0)
    loads = terms.force / arms
    loads /= np.abs(loads).max() or 1.0
    found = linprog(
        np.zeros(len(rows)), cones, np.zeros(len(cones)), (rows / arms).T, -loads,
        [(0.0, None)] * len(closed) + [(None, None)] * len(held),
    )  # fmt: skip
    return still if found.success else None


def project_to_rest(
    eq: Equations, z: Floats, p: Floats, tangents: Floats, closed: Sequence[int],
    held: Sequence[int],
) -> tuple[Floats, Floats]:  # fmt: skip
    """Remove what is left of gaps, gap rates and slips at rest from a state and its derivatives.

    They are removed along the contact forces, as these would do in no time.
    """
    z, tangents, n = z.copy(), tangents.copy(), eq.n
    for part, stuck in ((slice(n), ()), (slice(n, 2 * n), held)):
        terms, (gaps, rates, slips) = eq.terms(z, p), eq.kinematic_changes(z, p)
        normal, turn = (terms.gap_rate, rates) if part.start else (terms.gap, gaps)
        rows = np.vstack([terms.w_n[closed], terms.w_t[[*stuck]]])
        response = np.linalg.solve(terms.mass, rows.T)
        back = response @ np.linalg.pinv(rows @ response, hermitian=True)
        z[part] -= back @ np.concatenate([normal[closed], terms.slip[[*stuck]]])
        change = np.vstack([turn[closed], slips[[*stuck]]])
        tangents[part] -= back @ total(eq, change, tangents)
    return z, tangents


def terms_at_rest(
    eq: Equations, z: Floats, p: Floats, closed: Sequence[int], stuck: Sequence[int]
) -> Terms | None:
    """The terms, at velocity zero, of a system that contacts hold at rest for ever; or None.

    Where a belt or a support moves, gap rates or slips are not zero then, and it is None.
    """
    if not eq.is_autonomous or len(closed) + len(stuck) < eq.n:
        return None
    still = z.copy()
    still[eq.n : 2 * eq.n] = 0.0
    terms = eq.terms(still, p)
    moved = terms.gap_rate[closed].any() or terms.slip[stuck].any()
    rank = np.linalg.matrix_rank(np.vstack([terms.w_n[closed], terms.w_t[stuck]]))
    return None if moved or rank < eq.n else terms


def _search_mode(
    eq: Equations, z: Floats, p: Floats, touch: ContactState, still: Mode
) -> list[Local]:
    """Search for an admissible mode, from the mode that has ended and that of Lemke's path."""
    # If guards of a mode fail, the search goes to the states beyond all of them, then beyond each.
    terms, seen = eq.terms(z, p), set[Mode]()
    waiting = [still, *_proposed(eq, terms, still)]
    if touch.before:  # the mode that has ended, beyond the guards that ended it
        own = {REDUNDANT: OPEN, EDGE_UP: SLIDE_UP, EDGE_DOWN: SLIDE_DOWN}
        ended = tuple(own.get(state, state) for state in touch.before)
        waiting.append(_neighbour_mode(eq, ended, still, sorted(touch.fired)))
    while waiting and len(seen) < MOST_MODES:
        mode = waiting.pop()
        if mode in seen:
            continue
        seen.add(mode)
        for resolved in _all_resolved(eq, terms, [mode], still):
            here = Local(eq, resolved, z, p)
            failing = [*_failing(here, touch)]
            if not failing:
                return [here]
            if NO_GUARD in failing:
                continue
            waiting += [_neighbour_mode(eq, mode, still, [guard]) for guard in failing[::-1]]
            waiting.append(_neighbour_mode(eq, mode, still, failing))
    return []


def _neighbour_mode(eq: Equations, mode: Mode, still: Mode, guards: Sequence[int]) -> Mode:
    """The mode beyond some guards of a mode; contacts with the same slip change together."""
    found = list(mode)
    for guard in guards:
        kind, i = divmod(guard, eq.m)
        to = {GAP: still[i], NORMAL: OPEN, CONE_UP: SLIDE_DOWN, CONE_DOWN: SLIDE_UP, SLIP: STICK}
        team = [i]
        if kind in (CONE_UP, CONE_DOWN, SLIP):
            team = [k for k in range(eq.m) if found[k] != OPEN and eq.slips[k] == eq.slips[i]]
        for k in team:
            found[k] = to[kind]
    return tuple(found)


def _all_resolved(
    eq: Equations, terms: Terms, modes: Sequence[Mode], still: Mode
) -> Sequence[Mode]:
    """The modes to be tried, in order, with redundant contacts resolved."""
    # If there are any, modes with most closed contacts come first, whatever the order of contacts.
    rows = _rows(eq.sets(still), terms)
    if len(rows) < 2 or np.linalg.matrix_rank(rows) == len(rows):
        return modes
    resolved = (_resolved(eq, terms, mode, still) for mode in modes)
    found = dict.fromkeys(mode for mode in resolved if mode is not None)
    return sorted(found, key=lambda mode: mode.count(OPEN))


def _rows(sets: IndexSets, terms: Terms) -> Floats:
    """The directions (..., n) of normal forces, and of friction where contacts stick."""
    return np.vstack([terms.w_n[sets.closed], terms.w_t[sets.stuck]])


def _resolved(eq: Equations, terms: Terms, mode: Mode, still: Mode) -> Mode | None:
    """A mode with its redundant contacts REDUNDANT or EDGE; None if its forces are not unique."""
    sets = eq.sets(mode)
    rows = _rows(sets, terms)
    if np.linalg.matrix_rank(rows) < len(rows):
        return None
    bars = np.concatenate([terms.bar_n[sets.closed], terms.bar_t[sets.stuck]])
    # bars alone may be squares of what rounding has left of velocities
    free = np.abs(np.linalg.solve(terms.mass, terms.force))

    def follows(row: Floats, bar: float) -> bool:
        return is_implied(row, bar, rows, bars, float(np.abs(row) @ free))

    found = list(mode)
    for i in eq.sets(still).touching:
        slides = mode[i] in (SLIDE_UP, SLIDE_DOWN) and still[i] == STICK
        if mode[i] == OPEN and follows(terms.w_n[i], terms.bar_n[i]):
            found[i] = REDUNDANT
        elif slides and follows(terms.w_t[i], terms.bar_t[i]):
            found[i] = EDGE_UP if mode[i] == SLIDE_UP else EDGE_DOWN
    return tuple(found)


@lru_cache(maxsize=1024)
def _combinations(still: Mode, slips: tuple[int, ...]) -> list[Mode] | None:
    """All combinations of states, equal for closed contacts with one slip; None if too many."""
    states = {OPEN: (OPEN,), STICK: (STICK, SLIDE_UP, SLIDE_DOWN, OPEN)}
    choices = [states.get(state, (state, OPEN)) for state in still]
    if math.prod(map(len, choices)) > MOST_MODES:
        return None
    teams = [[i for i, slip in enumerate(slips) if slip == first] for first in set(slips)]
    return [
        mode for mode in product(*choices)
        if all(len({mode[i] for i in team} - {OPEN}) < 2 for team in teams)
    ]  # fmt: skip


def _proposed(eq: Equations, terms: Terms, still: Mode) -> list[Mode]:
    """The mode of the solution to which Lemke's path leads, if it finds one."""
    sets = eq.sets(still)
    c = sets.closed
    w = np.vstack([terms.w_n[c], terms.w_t[c]])
    response = np.linalg.solve(terms.mass, np.column_stack([w.T, terms.force]))
    free = w @ response[:, -1] + np.concatenate([terms.bar_n[c], terms.bar_t[c]])
    slides = -sets.sign[c] * np.array(eq.friction)[c]
    found = solve_contact_lcp(w @ response[:, :-1], free, terms.mu[c], 0.0, slides)
    if not found.success:
        return []
    mode = [OPEN] * eq.m
    for k, i in enumerate(c):
        if found.impulse_n[k] > 0.0:
            slip = slides[k] or found.gamma_t[k] if eq.friction[i] else 1.0
            mode[i] = STICK if slip == 0.0 else SLIDE_DOWN if slip < 0.0 else SLIDE_UP
    return [tuple(mode)]


def _failing(here: Local, touch: ContactState) -> Iterator[int]:
    """Guards of closed contacts that are negative right after the event; NO_GUARD: no motion."""
    # A guard has the sign of its first derivative that the event has not made zero; one whose known
    # derivatives all vanish counts as positive.
    if here.numbers is None and not math.isfinite(here.balance.a.sum()):
        yield NO_GUARD
        return
    for guard, first in watched(here.sets, touch):
        for k in range(first, KNOWN[guard // here.sets.m] + 1):
            value = here.derivative(guard, k)
            if value != 0.0:
                if not value > 0.0:
                    yield guard
                break
