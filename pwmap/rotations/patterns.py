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
    reader = _PatternReader(text, tuple(letters), n)
    runs = reader.pattern()
    if reader.rest:
        raise reader.wrong("a parenthesis is closed that was not opened")
    if not any(run.grows for run in runs):
        raise ValueError(f"a pattern must have an exponent {n}, got {shortened(repr(text))}")
    return runs


class _PatternReader:
    def __init__(self, text: str, letters: tuple[str, ...], n: str) -> None:
        self._text, self._letters, self._n = text, letters, n
        self.rest = re.sub(r"\s", "", text)

    def pattern(self) -> tuple[WordRun, ...]:
        runs: list[WordRun] = []
        while self.rest and self.rest[0] != ")":
            runs += self._item()
            if len(runs) > MAX_LETTERS:
                raise self.wrong(f"it has more than {MAX_LETTERS} letters")
        return tuple(runs)

    def _item(self) -> Sequence[WordRun]:
        first, self.rest = self.rest[0], self.rest[1:]
        if first == "(":
            inner = self.pattern()
            if not self._taken(")"):
                raise self.wrong("a parenthesis is not closed")
            if not inner:
                raise self.wrong("a parenthesis is empty")
        elif first in self._letters:
            inner = (WordRun((self._letters.index(first),), False, 1),)
        else:
            raise self.wrong(f"{first!r} is no piece of this map, it has {self._letters}")
        return self._raised(inner) if self._taken("^") else inner

    def _raised(self, inner: tuple[WordRun, ...]) -> Sequence[WordRun]:
        grows, shift = self._exponent()
        if not grows:
            if not 1 <= shift * len(inner) <= MAX_LETTERS:
                raise self.wrong(f"an exponent must lie in 1 to {MAX_LETTERS}, {shift} does not")
            return inner * shift
        if any(run.grows for run in inner):
            raise self.wrong(f"a power of {self._n} stands in a power of {self._n}")
        return (WordRun(tuple(letter for run in inner for letter in run.word), True, shift),)

    def _exponent(self) -> tuple[bool, int]:
        n = re.escape(self._n)
        for form in (rf"(?P<n>{n})", rf"\((?P<n>{n})(?P<k>[+-]\d+)?\)", r"(?P<k>\d+)",
                     r"\((?P<k>\d+)\)"):  # fmt: skip
            found = re.match(form, self.rest)
            if found and len(found.group()) < 20:
                self.rest = self.rest[found.end() :]
                parts = found.groupdict()
                return parts.get("n") is not None, int(parts.get("k") or 0)
        raise self.wrong(f"an exponent must be an integer, {self._n} or such as ({self._n}+1)")

    def _taken(self, sign: str) -> bool:
        found = self.rest.startswith(sign)
        self.rest = self.rest[found:]
        return found

    def wrong(self, why: str) -> ValueError:
        return ValueError(f"the pattern {shortened(repr(self._text))} cannot be read: {why}")
