"""Patterns of words with one exponent n, such as ``R L^n`` or ``(RL)^n R L^(n+1)``.

    pattern:  item item ...       (blanks are ignored)
    item:     letter or (pattern), with or without ^exponent
    exponent: an integer, n, or a sum in parentheses such as (n+1), (n-2)

Only a plain word may have a power of n.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

from pwmap.algebra.arguments import shortened
from pwmap.maps.words import Word

MAX_LETTERS = 1000  # of a pattern, without powers of n
LONGEST = 20  # characters of an exponent


class WordRun(NamedTuple):
    """A word that is repeated: ``shift`` times, or n + ``shift`` times if it ``grows``."""

    word: Word
    grows: bool
    shift: int

    def count(self, n: int) -> int:
        """The number of repetitions for a value of n."""
        return self.shift + (n if self.grows else 0)


def read_pattern(text: str, letters: Sequence[str], n: str = "n") -> tuple[WordRun, ...]:
    """The runs of a pattern; ValueError if it cannot be read or has no exponent n."""
    if not isinstance(text, str):
        raise ValueError(f"a pattern must be text such as 'R L^n', got {shortened(repr(text))}")
    exponent = r"\^(n|\(n([+-]\d+)?\)|\d+|\(\d+\))".replace("n", re.escape(n))
    rest, runs = re.sub(r"\s", "", text), list[WordRun]()
    outer = list[list[WordRun]]()  # what stands before each open parenthesis

    def wrong(why: str) -> ValueError:
        return ValueError(f"the pattern {shortened(repr(text))} cannot be read: {why}")

    while rest:
        first, rest = rest[0], rest[1:]
        if first == "(":
            outer.append(runs)
            runs = []
            continue
        if first == ")":
            if not outer:
                raise wrong("a parenthesis is closed that was not opened")
            if not runs:
                raise wrong("a parenthesis is empty")
            item, runs = runs, outer.pop()
        elif first in letters:
            item = [WordRun((letters.index(first),), False, 1)]
        else:
            raise wrong(f"{first!r} is no piece of this map, it has {tuple(letters)}")
        if rest.startswith("^"):
            found = re.match(exponent, rest)
            if not found or len(found.group()) > LONGEST:
                raise wrong(f"an exponent must be an integer, {n} or such as ({n}+1)")
            rest, power = rest[found.end() :], found.group()[1:].strip("()")
            grows, shift = power.startswith(n), int(power.removeprefix(n) or 0)
            if grows and any(run.grows for run in item):
                raise wrong(f"a power of {n} stands in a power of {n}")
            if grows:
                item = [WordRun(tuple(k for run in item for k in run.word), True, shift)]
            elif 1 <= shift * len(item) <= MAX_LETTERS:
                item = item * shift
            else:
                raise wrong(f"an exponent must lie in 1 to {MAX_LETTERS}, {shift} does not")
        runs += item
        if len(runs) > MAX_LETTERS:
            raise wrong(f"it has more than {MAX_LETTERS} letters")
    if outer:
        raise wrong("a parenthesis is not closed")
    if not any(run.grows for run in runs):
        raise ValueError(f"a pattern must have an exponent {n}, got {shortened(repr(text))}")
    return tuple(runs)
