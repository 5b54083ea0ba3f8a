"""Words of cycles: rotational words, and patterns with one exponent n.

A rotational word lists the arcs of a circle that a rotation by p/q visits [Berstel2008, Ch. 1]. The
points of the cycle are numbered 0 ... q - 1 from left to right, and point j goes to j + p modulo q.
The letter is L for the q - p points on the left, which move up, and R for the p on the right.

A pattern is a text such as ``R L^n`` or ``(RL)^n R L^(n+1)``::

    pattern:  item item ...       (blanks are ignored)
    item:     letter or (pattern), with or without ^exponent
    exponent: an integer, n, or a sum in parentheses such as (n+1), (n-2)

A power of n must not contain another one.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import sympy

from pwmap.algebra.arguments import check_text, checked_count, explained, shortened, shown
from pwmap.maps.budget import BUDGET, Budget, Meter, check_work, metered
from pwmap.maps.words import Word

STEP = 8  # work of one fraction, or of one letter


@explained()
def farey(q_max: int, *, budget: Budget | Meter = BUDGET) -> tuple[Fraction, ...]:
    """The Farey sequence: all reduced fractions in [0, 1] of denominators up to ``q_max``.

    Parameters
    ----------
    q_max, budget
        The largest denominator, and the work that is allowed.

    Returns
    -------
    tuple of Fraction
        In ascending order, with 0 and 1.

    Raises
    ------
    ValueError
        Unless ``q_max`` is an integer of at least 1; a ``BudgetError`` if there are too many.

    Examples
    --------
    >>> from pwmap.rotations import farey
    >>> print(*farey(4))
    0 1/4 1/3 1/2 2/3 3/4 1
    """
    last = checked_count(q_max, "the largest denominator")
    work = STEP * last**2 // 3  # there are about 3/pi**2 q_max**2 fractions
    check_work(f"the fractions with denominators up to {shown(last)}", work, metered(budget))
    found = [Fraction(0)]
    (a, b), (c, d) = (0, 1), (1, last)
    while c <= d:  # the next neighbour follows from the last two
        found.append(Fraction(c, d))
        steps = (last + b) // d
        (a, b), (c, d) = (c, d), (steps * c - a, steps * d - b)
    return tuple(found)


@explained()
def rotational_word(rotation: object, letters: str = "LR") -> str:
    """The word of a rotation by p/q: p letters R out of q, spread as evenly as possible.

    This is the lower Christoffel word of slope p/(q - p), which starts at the leftmost point of the
    cycle: letter k = 0 ... q - 1 is R if floor((k + 1) p/q) is larger than floor(k p/q)
    [Berstel2008, Ch. 1].

    Parameters
    ----------
    rotation, letters
        A rational from 0 to 1 (an integer, a ``Fraction`` or a ``sympy.Rational``), and the names
        of the left and the right piece.

    Returns
    -------
    str
        One letter for each unit of the reduced denominator q.

    Raises
    ------
    TypeError, ValueError
        If the rotation is no rational from 0 to 1, or there are not two different letters; a
        ``BudgetError`` if the denominator exceeds some millions.

    Examples
    --------
    >>> from fractions import Fraction
    >>> from pwmap.rotations import rotational_word
    >>> rotational_word(Fraction(2, 5)), rotational_word(Fraction(1, 3), letters="ab")
    ('LLRLR', 'aab')
    """
    left, right = _two(letters)
    p, q = checked_rotation(rotation).as_integer_ratio()
    check_work(f"the letters of {shown(rotation)}", STEP * q, Meter(BUDGET))
    return "".join(right if (k + 1) * p // q > k * p // q else left for k in range(q))


@explained()
def rotation_number(word: str, letters: str = "LR") -> Fraction:
    """The rotation number of a cycle, in turns per step: the share of R among its letters.

    Parameters
    ----------
    word, letters
        Any word of a cycle, such as ``"LLR"``, and the letters of the left and the right piece.

    Returns
    -------
    Fraction
        From 0 to 1.

    Raises
    ------
    ValueError
        If the word is empty or has other letters, or there are not two different letters.

    Examples
    --------
    >>> from pwmap.rotations import rotation_number
    >>> rotation_number("LLRLR")
    Fraction(2, 5)
    """
    left, right = _two(letters)
    check_text("a word", word)
    if not word or set(word) - {left, right}:
        raise ValueError(f"a word must consist of the letters {left} and {right}, got {word!r}")
    return Fraction(word.count(right), len(word))


def checked_rotation(rotation: object) -> Fraction:
    """A rotation number as a fraction; errors as of :func:`rotational_word`."""
    if isinstance(rotation, bool) or not isinstance(rotation, int | Fraction | sympy.Rational):
        raise TypeError(f"a rotation number must be a rational, got {shown(rotation)}")
    found = Fraction(*map(int, (rotation.numerator, rotation.denominator)))
    if not 0 <= found <= 1:
        raise ValueError(f"a rotation number must lie in [0, 1], got {found}")
    return found


def _two(letters: str) -> tuple[str, str]:
    check_text("letters", letters)
    if len(letters) != 2 or letters[0] == letters[1]:
        raise ValueError(f"the pieces need two different letters, got {letters!r}")
    return letters[0], letters[1]


MAX_LETTERS = 64  # of a pattern, and the largest shift of n: effort grows as its cube
LONGEST = 20  # characters of an exponent, at most


class WordRun(NamedTuple):
    """A word repeated ``shift`` times or, if it ``grows``, n + ``shift`` times."""

    word: Word
    grows: bool
    shift: int

    def count(self, n: int) -> int:
        """The number of repetitions for a value of n."""
        return self.shift + (n if self.grows else 0)


def read_pattern(text: str, letters: Sequence[str], n: str = "n") -> tuple[WordRun, ...]:
    """The runs of a pattern; ValueError if it cannot be read, or has no exponent n."""
    if not isinstance(text, str):
        raise ValueError(f"a pattern must be text such as 'R L^n', got {shortened(repr(text))}")
    exponent = r"\^(n|\(n([+-]\d+)?\)|\d+|\(\d+\))".replace("n", re.escape(n))
    rest, runs = re.sub(r"\s", "", text), list[WordRun]()
    outer = list[list[WordRun]]()  # the runs before each parenthesis that is still open

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
            if grows and abs(shift) > MAX_LETTERS:
                raise wrong(f"{shift:+d} is beyond {MAX_LETTERS}: {n} itself may be large instead")
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
