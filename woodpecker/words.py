"""Events and words: the sequence of events names a piece of the return map.

A symbol is a kind and its contacts: ``I3`` an impact, ``I1+3`` one in which contacts 1 and 3 take
part, ``D3`` a detachment, ``S2`` slip starts, ``J2`` sticking or jamming starts, ``R2`` slip
reverses, ``C1`` impacts accumulated until contact 1 closed. ``I~1+3`` is an impact whose impulses
the contact laws do not fix (:mod:`woodpecker.contact`). ``|`` separates the returns of P_j.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import Enum

from woodpecker import kernel

SEPARATOR = "|"


class EventKind(Enum):
    """What happens at an event; the value is the letter of its symbol."""

    IMPACT = "I"
    DETACH = "D"
    SLIP = "S"
    STICK = "J"
    REVERSAL = "R"
    CHATTER = "C"
    INDETERMINATE_IMPACT = "I~"


_KINDS = {
    kernel.IMPACT: EventKind.IMPACT,
    kernel.DETACH: EventKind.DETACH,
    kernel.SLIP_START: EventKind.SLIP,
    kernel.STICK_START: EventKind.STICK,
    kernel.REVERSAL: EventKind.REVERSAL,
    kernel.CHATTER_END: EventKind.CHATTER,
    kernel.INDETERMINATE_IMPACT: EventKind.INDETERMINATE_IMPACT,
}


def decode(code: int) -> tuple[EventKind, tuple[int, ...]]:
    """Kind and contacts (1-based, ascending) of an event code of the kernel."""
    return _KINDS[code // 8], tuple(i + 1 for i in range(3) if code % 8 >> i & 1)


def symbol(code: int) -> str:
    """Symbol of an event code, e.g. ``"I1+3"``; code 0 separates returns."""
    if code == 0:
        return SEPARATOR
    kind, contacts = decode(code)
    return kind.value + "+".join(map(str, contacts))


_SYMBOLS = {code: symbol(code) for code in range(8 * len(_KINDS)) if code == 0 or code % 8}


def word(codes: Iterable[int]) -> str:
    """Word of a sequence of event codes: symbols joined by blanks."""
    return " ".join([_SYMBOLS[code] for code in codes])
