"""What ends a check that fails, and how large a certificate may be."""

from __future__ import annotations

from fractions import Fraction
from typing import NoReturn

BYTES = 4_000_000  # of a file
DIGITS = 400  # of a number as text
SHOWN = 100  # characters of a number or of a polynomial in a refusal
TERMS = 20  # of a polynomial in a map
LETTERS = 60  # breaks of a map
ORDER = 32  # of an iterate
ROWS = 1_000  # of a list
ATOMS = 20_000  # pieces of an iterate
WORK_ATOM = 200  # steps for each, and for each letter
WORK = 2_000_000_000  # steps, roughly
DEGREE, BITS = 200, 20_000  # of a polynomial that arises


class Refused(ValueError):  # noqa: N818  it is no error of the program
    """What a certificate says is not proved by it; one sentence says why.

    Examples
    --------
    >>> import json, pathlib
    >>> from pwmap import PiecewiseLinearMap, Refused, check_certificate, prove
    >>> p1 = PiecewiseLinearMap.from_sympy("Piecewise((-1, x <= 0), (1 - 5*x/4, True))")
    >>> path = pathlib.Path(prove(p1).save("certificate.json"))
    >>> changed = path.write_text(path.read_text().replace("5/4", "3/4"))
    >>> try:
    ...     check_certificate(path)
    ... except Refused as error:
    ...     print(error)
    the seal is not that of the content
    """


class Work:
    """How much may still be done for one certificate, in rough numbers of small steps."""

    def __init__(self, steps: int = WORK) -> None:
        self.left = steps

    def spend(self, steps: int) -> None:
        """Refuse to do more than is left."""
        self.left -= steps
        if self.left < 0:
            refuse("this takes more work than a check may")


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
