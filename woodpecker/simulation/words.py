"""Events and words: the sequence of events names a piece of the return map.

A symbol is a kind and its contacts: ``I3`` an impact, ``I1+3`` one at contacts 1 and 3, ``D3`` a
detachment, ``S2`` slip starts, ``J2`` sticking or jamming starts, ``R2`` slip reverses, ``C1``
impacts accumulate until contact 1 closes. ``I~1+3`` is an impact whose impulses the contact laws
leave open. ``|`` separates the returns of P_j. In an impact a contact slides through compression
and expansion unless letters behind its number say otherwise: ``s`` sticks, ``f`` separates; after
``-`` the same for the expansion (``I1-s``), where ``r`` is a contact that stays although it has
stored impulse, or leaves although it has stored none. With these letters a return map is smooth
wherever its word is constant.

Where impulses are open, as in ``I~1e6+3e3``, letters name both ends of the segment of solutions: at
6 = 0 + 3 * 2 the first contact sticks (0) and the second slides backward (2), at 3 = 0 + 3 * 1 the
second slides forward (1).
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import Enum
from functools import lru_cache

import numpy as np

from woodpecker.mechanics.impacts import MARKS, letters_of

SEPARATOR = "|"
WORDS = 4096  # that are cached


class EventKind(Enum):
    """The kind of an event; the value is the letter of its symbol.

    Examples
    --------
    >>> from woodpecker import Toy, EventKind, simulate
    >>> motion = simulate(Toy(), -0.53, t_end=0.15)
    >>> [event.symbol for event in motion.events if event.kind is EventKind.IMPACT]
    ['I3', 'I1', 'I3', 'I2', 'I2']
    >>> EventKind.STICK.value
    'J'
    """

    IMPACT = "I"
    DETACH = "D"
    SLIP = "S"
    STICK = "J"
    REVERSAL = "R"
    CHATTER = "C"
    INDETERMINATE_IMPACT = "I~"


IMPACTS = (EventKind.IMPACT, EventKind.INDETERMINATE_IMPACT)
_KINDS = tuple(EventKind)  # in the order of the codes in :mod:`woodpecker.motion.codes`


def decode(code: int) -> tuple[EventKind, tuple[int, ...]]:
    """Kind and contacts (1-based, ascending) of an event code of the kernel."""
    return _KINDS[code % 64 // 8], tuple(i + 1 for i in range(3) if code % 8 >> i & 1)


def symbol(code: int) -> str:
    """Symbol of an event code, e.g. ``"I1+3"``; code 0 separates returns."""
    if code == 0:
        return SEPARATOR
    kind, contacts = decode(code)
    marks = divmod(code // 64, MARKS)[::-1]
    if kind is EventKind.INDETERMINATE_IMPACT:  # the two ends of the segment of solutions
        letters = [f"e{mark}" for mark in marks]
    else:
        letters = [letters_of(mark) for mark in marks]
    pairs = zip(contacts, [*letters, ""], strict=False)
    return kind.value + "+".join(f"{contact}{text}" for contact, text in pairs)


def word(codes: Iterable[int]) -> str:
    """Word of a sequence of event codes: symbols joined by blanks."""
    return " ".join([_SYMBOLS[code] if code in _SYMBOLS else symbol(code) for code in codes])


_SYMBOLS = {code: symbol(code) for code in range(8 * len(_KINDS)) if code == 0 or code % 8}


@lru_cache(maxsize=WORDS)
def word_of(codes: bytes) -> str:
    """Word of event codes of the kernel, as bytes; cached, as few words occur again and again."""
    return word(np.frombuffer(codes, dtype=np.int16).tolist())
