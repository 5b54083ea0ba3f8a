"""The refusal that ends a failed check, and limits on the size and work of certificates."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NoReturn

BYTES = 4_000_000  # of a file
DIGITS = 400  # characters of a number as text
SHOWN = 100  # characters of a number or polynomial in a refusal
TERMS = 20  # of a polynomial in a map
LETTERS = 60  # breaks of a map
ORDER = 32  # of an iterate
ROWS = 1_000  # of a list
ATOMS = 20_000  # pieces of an iterate
MAX_COEFFICIENTS, BITS = 200, 20_000  # coefficients, and bits of each, of a polynomial that arises
WORK = 15_000_000_000  # of one check: roughly nanoseconds on a processor of 2025, and rather more
BYTE = 100  # work charged for each byte that is kept, so that WORK bounds memory, too, by 150 MB
STEP = 1_000  # least work of any step, however small its numbers


class Refused(ValueError):  # noqa: N818  it is no error of the program
    """A certificate does not prove what it states; one sentence says why."""


class Effort:
    """The work left for checking one certificate, and results kept for reuse (``known``)."""

    def __init__(self, work: int = WORK) -> None:
        # work depends on the lengths of integers and the sizes of kept results alone, so that every
        # machine refuses the same files; it is the only bound of time and memory
        self.left = work
        self.known: dict[object, Any] = {}

    def spend(self, work: int) -> None:
        """Subtract work before it is done, and refuse if too little is left."""
        self.left -= work
        if self.left < 0:
            refuse("this takes more work than a check may")

    def keep(self, *rows: Sequence[int] | str) -> None:
        """Charge for the memory of polynomials or texts that are kept."""
        size = sum(len(row) if isinstance(row, str) else _bytes(row) for row in rows)
        self.spend(BYTE * (OBJECT + size))


OBJECT = 200  # bytes of the containers around kept values


def _bytes(poly: Sequence[int]) -> int:
    return sum(40 + c.bit_length() // 7 for c in poly)


def digits(number: int | Fraction) -> str:
    """A number as text; refused if it has more digits than Python converts."""
    try:
        return str(number)
    except ValueError:
        refuse("a number has too many digits to be written")


def brief(text: str, most: int = SHOWN) -> str:
    """A text, cut after its beginning if it is long."""
    return text if len(text) <= most else text[: most - 4] + " ..."


def refuse(reason: str) -> NoReturn:
    """Raise :class:`Refused` with a reason."""
    raise Refused(reason)
