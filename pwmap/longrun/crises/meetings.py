"""Meetings of images of breaks with cycles: two words make a polynomial in all parameters."""

from __future__ import annotations

from typing import NamedTuple

import sympy

from pwmap.algebra.arguments import check_text, explained, shown
from pwmap.algebra.exact import Number, to_sympy
from pwmap.algebra.exact import fraction_to_sympy as shown_fraction
from pwmap.diagrams.shown import counted
from pwmap.maps.piecewise_linear import PiecewiseLinearMap, check_map
from pwmap.maps.words import Word


class Meeting(NamedTuple):
    """An image of a break that lies on a cycle; its fields are arguments of :func:`meeting_curve`.

    ``number`` counts the breaks from the left, from 0; ``image`` is the word from the break to the
    image, ``cycle`` the word of the cycle, starting at that point.
    """

    number: int
    image: str
    cycle: str


@explained()
def meeting_curve(map_: PiecewiseLinearMap, image: str, cycle: str, number: int = 0) -> sympy.Expr:
    """The polynomial in a map's parameters that vanishes where an image of a break meets a cycle.

    It continues a crisis that is known at one value as a curve in several parameters.

    Parameters
    ----------
    map_, image, cycle, number
        A map, and the fields of a :class:`Meeting` of :attr:`Crisis.meetings`.

    Returns
    -------
    sympy.Expr
        The product of the irreducible factors, each once, without integer factors.

    Raises
    ------
    ValueError
        If a word is empty or has an unknown letter, or there is no such break.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap
    >>> from pwmap.longrun import meeting_curve
    >>> skew = PiecewiseLinearMap.from_sympy("Piecewise((a*x + 1, x <= 0), (b*x + 1, True))")
    >>> meeting_curve(skew, "LRL", "R")
    a*b**2 - a + b
    """
    check_map(map_)
    polynomial = meeting_polynomial(map_, Meeting(number, image, cycle))
    _, factors = sympy.factor_list(to_sympy(polynomial))
    return sympy.Mul(*(factor for factor, _ in factors)) if factors else sympy.Integer(0)


def meeting_polynomial(map_: PiecewiseLinearMap, meeting: Meeting) -> Number:
    """The polynomial of :func:`meeting_curve` with all its factors, in the map's ring."""
    breaks = map_.layout.breaks
    number = meeting.number
    if not isinstance(number, int) or not 0 <= number < len(breaks):
        what = f"number must name one of {counted(len(breaks), 'break')}, from 0 on"
        raise ValueError(f"{what}, got {shown(number)}")
    along, around = (numbers_of(map_, word) for word in (meeting.image, meeting.cycle))
    return map_.orbits.meeting(breaks[number], along, around)


def meeting_x(map_: PiecewiseLinearMap, meeting: Meeting) -> sympy.Expr:
    """The formula of the cycle's point that an image of a break meets."""
    return shown_fraction(map_.orbits.fixed_point(numbers_of(map_, meeting.cycle)))


def numbers_of(map_: PiecewiseLinearMap, word: str) -> Word:
    """The letters of a word as indices; ValueError if it is empty or has an unknown letter."""
    check_text("a word", word)
    if not word:
        raise ValueError("a word must have at least one letter")
    for letter in word:
        if letter not in map_.letters:
            raise ValueError(f"{letter!r} is no piece of this map, it has {map_.letters}")
    return map_.numbered(word)


def earliest(image: Word, cycle: Word) -> tuple[Word, Word]:
    """The words of the first image of a break on a cycle, given those of a later one."""
    # if both words end in the same letter, the preceding image is on the cycle, too; one letter is
    # kept, as the break itself is no image
    while len(image) > 1 and image[-1] == cycle[-1]:
        image, cycle = image[:-1], cycle[-1:] + cycle[:-1]
    return image, cycle
