"""What ends a check that fails, and how large a certificate may be."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NoReturn

BYTES = 4_000_000  # of a file
DIGITS = 400  # of a number as text
SHOWN = 100  # characters of a number or of a polynomial in a refusal
TERMS = 20  # of a polynomial in a map
LETTERS = 60  # breaks of a map
ORDER = 32  # of an iterate
ROWS = 1_000  # of a list
ATOMS = 20_000  # pieces of an iterate
DEGREE, BITS = 200, 20_000  # of a polynomial that arises
WORK = 15_000_000_000  # of one check: nanoseconds of a processor of 2025, roughly, and rather more
BYTE = 100  # work that a byte costs which is kept: so time bounds memory, too, at 150 MB
STEP = 1_000  # work of any step, whatever it computes with


class Refused(ValueError):  # noqa: N818  it is no error of the program
    """A certificate does not prove what it says; one sentence says why."""


class Effort:
    """The work left for one certificate, and results that are asked for again (``known``)."""

    def __init__(self, work: int = WORK) -> None:
        # counts of operations by the length of integers, kept results by their size: every machine
        # refuses the same files, and neither time nor memory has another bound
        self.left = work
        self.known: dict[object, Any] = {}

    def spend(self, work: int) -> None:
        """Refuse to do more than is left."""
        self.left -= work
        if self.left < 0:
            refuse("this takes more work than a check may")

    def keep(self, *rows: Sequence[int] | str) -> None:
        """Pay for polynomials or texts that are kept."""
        size = sum(len(row) if isinstance(row, str) else _bytes(row) for row in rows)
        self.spend(BYTE * (OBJECT + size))


OBJECT = 200  # bytes of what holds them


def _bytes(poly: Sequence[int]) -> int:
    return sum(40 + c.bit_length() // 7 for c in poly)


def digits(number: int | Fraction) -> str:
    """A number as text; Python bounds the digits of the integers that it converts."""
    try:
        return str(number)
    except ValueError:
        refuse("a number has too many digits to be written")


def brief(text: str, most: int = SHOWN) -> str:
    """A text, or the beginning of one that is long."""
    return text if len(text) <= most else text[: most - 4] + " ..."


def refuse(reason: str) -> NoReturn:
    """Raise a refusal."""
    raise Refused(reason)
