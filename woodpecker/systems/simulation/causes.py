"""Codes of the margins of a path, and sentences on what happens where one vanishes."""

from __future__ import annotations

from collections.abc import Sequence

from woodpecker.systems.mechanics.impacts import (
    ALONG,
    CONE_MINUS,
    CONE_PLUS,
    EXPANSION,
    NORMAL_SIDE,
)
from woodpecker.systems.mechanics.index_sets import CONE_DOWN, CONE_UP, GAP, NORMAL, SECTION, SLIP
from woodpecker.systems.simulation.motion import PathPhase

# Kinds of margins, in the order in which a phase meets them.
SLACK, BOUNCES, START, EARLY, SPEED, MEETING, DIP, PHASE, SETTLES = range(9)
# SLACK: an inequality of an impact; BOUNCES: 1 - ratio of bounces that accumulate; START: a guard
# of a closed contact where the phase begins; EARLY: the duration of a phase that ends on the
# section; SPEED: -f' |f'| of the guard f that fires; MEETING: another guard then; DIP: the least
# minimum of a guard in the phase; PHASE: time to the ends of a period; SETTLES: START times the
# speed of the impact before it, if that was slow
KINDS, ITEMS = 10, 2**18  # codes are (KINDS * phase + kind) * ITEMS + item

_GUARDS = {
    GAP: "{} touches", NORMAL: "the normal force of {} vanishes",
    CONE_UP: "{} reaches the edge of its friction cone",
    CONE_DOWN: "{} reaches the edge of its friction cone", SLIP: "{} stops sliding",
    SECTION: "the section is reached",
}  # fmt: skip
_EVENTS = {
    BOUNCES: "bounces at {name} cease to accumulate",
    START: "{guard} where phase {k} begins",
    EARLY: "{fired} before phase {k} begins",
    SPEED: "{fired} for an instant only in phase {k}",
    MEETING: "{guard} in the instant in which {fired} at the end of phase {k}",
    DIP: "{guard} for an instant in phase {k}",
    PHASE: "the return falls on the end of a period",
    SETTLES: "{guard} where phase {k} begins",
}
_SLACKS = {NORMAL_SIDE: "leaves", ALONG: "stops sliding", CONE_PLUS: "sticks", CONE_MINUS: "sticks"}


def cause_of(legs: Sequence[PathPhase], code: int, names: Sequence[str]) -> str:
    """A sentence on what happens where a margin of a path vanishes."""
    m = len(names)
    rest, item = divmod(code, ITEMS)
    k, kind = divmod(rest, KINDS)
    if kind == SLACK:
        side, of = divmod(item, 4 * m)
        phase = "expansion" if side == EXPANSION else "compression"
        event = f"{names[of // 4]} just {_SLACKS[of % 4]}"
        return f"{event} in the {phase} at the start of phase {k}"
    guard, fired = min(item, SECTION * m), legs[min(k, len(legs) - 1)].guard
    grazes = {SPEED: fired, DIP: guard}.get(kind, m)
    if grazes < m:
        return f"{names[grazes]} grazes in phase {k}"
    event = _EVENTS[kind].format(
        name=names[guard % m], guard=_guard(guard, names), fired=_guard(fired, names), k=k
    )
    if not is_on_section(legs, code):
        return event
    rubs = guard // m in (CONE_UP, CONE_DOWN, SLIP)
    sticks = ", and a return from where a contact sticks has fewer dimensions" * rubs
    return f"{event}: an event falls on the section{sticks}; choose a section away from it"


def _guard(guard: int, names: Sequence[str]) -> str:
    kind, i = divmod(guard, len(names))
    return _GUARDS[kind].format(names[i])


def is_on_section(legs: Sequence[PathPhase], code: int) -> bool:
    """Whether a margin of a path vanishes as an event falls on a section that is no impact."""
    rest, item = divmod(code, ITEMS)
    (k, kind), m = divmod(rest, KINDS), len(legs[0].mode)
    if legs[-1].guard // m != SECTION:
        return False
    if kind in (START, SETTLES):
        return k == 0
    ends = k == len(legs) - 1
    return (kind == EARLY and ends) or (kind == MEETING and (ends or item // m == SECTION))
