"""Margins of a path by their codes, and what happens where one vanishes, in words."""

from __future__ import annotations

from collections.abc import Sequence

from woodpecker.systems.mechanics.impacts import ALONG, NORMAL_SIDE
from woodpecker.systems.mechanics.index_sets import CONE_UP, GAP, NORMAL, SECTION, SLIP
from woodpecker.systems.simulation.motion import Leg

# Kinds of margins, in the order in which a phase meets them.
SLACK, BOUNCES, START, EARLY, SPEED, MEETING, DIP, PHASE, SETTLES = range(9)
# SLACK: an inequality of an impact; BOUNCES: 1 - ratio of bounces that accumulate; START: a guard
# of a contact at rest where the phase begins; EARLY: the duration of a phase that ends on the
# section; SPEED: the rate of the guard that fires, times its modulus; MEETING: another guard then;
# DIP: the least value of a guard at a minimum in the phase; PHASE: time from the ends of a period;
# SETTLES: START times the speed of the impact before, where that has been slow
KINDS, ITEMS = 10, 512  # codes are (KINDS * phase + kind) * ITEMS + item

_GUARDS = {
    GAP: "{} touches", NORMAL: "the normal force of {} vanishes",
    CONE_UP: "{} reaches the edge of its friction cone",
    CONE_UP + 1: "{} reaches the edge of its friction cone", SLIP: "{} stops sliding",
}  # fmt: skip


def cause_of(legs: Sequence[Leg], code: int, names: Sequence[str]) -> str:
    """A sentence on what happens where a margin of a path vanishes."""
    event = _event_of(legs, code, names)
    rest, item = divmod(code, ITEMS)
    k, kind = divmod(rest, KINDS)
    if not _is_of_section(legs, k, kind, item // len(names)):
        return event
    rubs = item // len(names) in (CONE_UP, CONE_UP + 1, SLIP)
    sticks = ", and a return from where a contact sticks has fewer dimensions" * rubs
    return f"{event}: an event falls on the section{sticks}; choose a section away from it"


def _is_of_section(legs: Sequence[Leg], k: int, kind: int, guard: int) -> bool:
    """Whether a margin of phase k vanishes as an event falls on a section that is no impact."""
    m = len(legs[0].mode)
    if legs[-1].guard // m != SECTION:
        return False
    if kind in (START, SETTLES):
        return k == 0
    ends = k == len(legs) - 1
    return (kind == EARLY and ends) or (kind == MEETING and (ends or guard == SECTION))


def _event_of(legs: Sequence[Leg], code: int, names: Sequence[str]) -> str:
    m = len(names)
    rest, item = divmod(code, ITEMS)
    k, kind = divmod(rest, KINDS)
    if kind == PHASE:
        return "the return falls on the end of a period"
    if kind == SLACK:
        return _slack(item, k, names)
    if kind == BOUNCES:
        return f"bounces at {names[item]} cease to accumulate"
    fired = _guard(legs[k].guard, names)
    if kind == SPEED:
        grazes = legs[k].guard < m
        return (
            f"{names[legs[k].guard]} grazes in phase {k}"
            if grazes
            else f"{fired} for an instant only in phase {k}"
        )
    if kind == EARLY:
        return f"{fired} before phase {k} begins"
    if kind == MEETING:
        return f"{_guard(item, names)} in the instant in which {fired} at the end of phase {k}"
    if kind in (START, SETTLES):
        return f"{_guard(item, names)} where phase {k} begins"
    if item // m == GAP:
        return f"{names[item]} grazes in phase {k}"
    return f"{_guard(min(item, SECTION * m), names)} for an instant in phase {k}"


def _guard(guard: int, names: Sequence[str]) -> str:
    kind, i = divmod(guard, len(names))
    return _GUARDS[kind].format(names[i]) if kind in _GUARDS else "the section is reached"


def _slack(item: int, k: int, names: Sequence[str]) -> str:
    side, rest = divmod(item, 4 * len(names))
    i, which = divmod(rest, 4)
    phase = "expansion" if side == 2 else "compression"
    if which == NORMAL_SIDE:
        return f"{names[i]} just leaves in the {phase} at the start of phase {k}"
    if which == ALONG:
        return f"{names[i]} just stops sliding in the {phase} at the start of phase {k}"
    return f"{names[i]} just sticks in the {phase} at the start of phase {k}"
