"""Fixed points and jumps of a map, and the images of points."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import sympy

from pwmap.algebra.arithmetic import fraction_of
from pwmap.algebra.assumptions import UndecidedError
from pwmap.algebra.exact import Fraction_, fraction_to_sympy, quotient_to_sympy
from pwmap.maps import cylinders as cyl
from pwmap.maps.cylinders import Inclusion
from pwmap.maps.decided import Decided
from pwmap.maps.words import Layout, Word


@dataclass(frozen=True, slots=True, kw_only=True)
class FixedPoint:
    """A fixed point of an iterate, of :meth:`PiecewiseLinearMap.fixed_points`, exact.

    Attributes
    ----------
    multiplier
        At the end of a piece the slope of the piece that owns the point; ``nan`` if that is the
        point alone.
    word
        The pieces visited, starting at x.
    order, period
        The iterate it was found in, and the minimal period of the point.
    admissible
        False for a virtual fixed point: that of a formula, outside the formula's piece.
    stable
        Whether all nearby orbits, on both sides, stay near and converge to it; None if the
        assumptions leave it open.
    at_border
        Whether it lies at an end of a piece.
    """

    x: sympy.Expr
    multiplier: sympy.Expr
    word: str
    order: int
    period: int
    admissible: bool
    stable: bool | None
    at_border: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class FixedInterval:
    """A piece that is the identity, of :meth:`PiecewiseLinearMap.fixed_intervals`."""

    interval: sympy.Set
    word: str
    order: int
    period: int  # minimal period of its points, but for one of half that if the slope was -1


@dataclass(frozen=True, slots=True, kw_only=True)
class Discontinuity:
    """A discontinuity: the one-sided limits and the value, of :meth:`PiecewiseLinearMap.jumps`."""

    x: sympy.Expr
    left: sympy.Expr
    value: sympy.Expr
    right: sympy.Expr


@dataclass(frozen=True, slots=True, kw_only=True)
class JumpCrossing:
    """A discontinuity that crosses the diagonal, of :meth:`PiecewiseLinearMap.jump_crossings`."""

    x: sympy.Expr
    left: sympy.Expr
    right: sympy.Expr
    left_word: str
    right_word: str
    order: int


# --- Points ---------------------------------------------------------------------------------------


def followed(map_: Decided, x: object, direction: int = 0) -> tuple[Word, Fraction_]:
    """Word and value of a point (direction 0), or their limits from the left (-1) or right (1)."""
    table, decide = map_.definition.table, map_.scope.sign
    point = fraction_of(x, map_.definition.ring, "a point")
    word: list[int] = []
    for layout_index in map_.chain:
        layout = table.layouts[layout_index]
        slot = _slot(map_, layout, point)
        if slot % 2 and direction:  # only here it matters on which side the points are
            slot += direction * math.prod(decide(table.slopes[letter]) for letter in word)
        word.append(layout.slots[slot])
        point = table.image(point, word[-1])
    return tuple(word), point


def _slot(map_: Decided, layout: Layout, point: Fraction_) -> int:
    (top, bottom), table, decide = point, map_.definition.table, map_.scope.sign
    side = decide(bottom)
    for i, k in enumerate(layout.breaks):
        order = side * decide(table.denominator * top - table.breaks[k] * bottom)
        if order <= 0:
            return 2 * i + (order == 0)
    return 2 * len(layout.breaks)


# --- Jumps ----------------------------------------------------------------------------------------


def jumps(map_: Decided) -> Iterator[Discontinuity]:
    """All discontinuities, from left to right."""
    value = map_.orbits.value
    cylinders = map_.cylinders
    for i, (left, right) in enumerate(pairwise(cylinders)):
        if left.is_point:  # the cut came as the lower end of this point
            continue
        cut = right.lower
        assert cut is not None
        owner, after = left if left.upper_closed else right, cylinders[i + 1 + right.is_point]
        limits = [value(cut.k, c.word[cut.steps :]) for c in (left, owner, after)]
        if not all(map_.is_zero(a * d - c * b) for (a, b), (c, d) in pairwise(limits)):
            values = [quotient_to_sympy(limit) for limit in limits]
            x = map_.cut_to_sympy(right.word, cut)
            yield Discontinuity(x=x, left=values[0], value=values[1], right=values[2])


def jump_crossings(map_: Decided) -> Iterator[JumpCrossing]:
    """All discontinuities that cross the diagonal strictly, from left to right."""
    if map_.studied is not None:
        found = iter(map_.studied.crossings)
    else:
        cylinders, oracle = map_.cylinders, map_.oracle
        sides = (None if c.is_point else cyl.sides_of(c, oracle) for c in cylinders)
        found = cyl.crossings(cylinders, sides)
    for cut, left, right in found:
        limits = (map_.orbits.value(cut.k, word[cut.steps :]) for word in (left, right))
        below, above = map(quotient_to_sympy, limits)
        yield JumpCrossing(
            x=map_.cut_to_sympy(left, cut),
            left=below,
            right=above,
            left_word=map_.spelled(left),
            right_word=map_.spelled(right),
            order=len(map_.chain),
        )


# --- Fixed points ---------------------------------------------------------------------------------


def fixed_points(map_: Decided, virtual: bool) -> Iterator[FixedPoint]:
    """All isolated fixed points, from left to right, with the virtual ones or without."""
    for i, cylinder in enumerate(map_.cylinders):
        inclusion = _inclusion(map_, i)
        if inclusion is Inclusion.VIRTUAL:
            shown = virtual and map_.oracle.multiplier(cylinder.word, 1) != 0
        else:
            shown = inclusion is not Inclusion.BAND
        if shown:
            yield _fixed_point(map_, i, inclusion)


def _inclusion(map_: Decided, i: int) -> Inclusion:
    if map_.studied is not None:
        return map_.studied.inclusion[i]
    return cyl.inclusion_of(map_.cylinders[i], None, map_.oracle)


def _fixed_point(map_: Decided, i: int, inclusion: Inclusion) -> FixedPoint:
    cylinder = map_.cylinders[i]
    word = cylinder.word
    if inclusion is Inclusion.POINT:
        assert cylinder.lower is not None
        x = map_.cut_to_sympy(word, cylinder.lower)
    else:
        x = fraction_to_sympy(map_.orbits.fixed_point(word))
    return FixedPoint(
        x=x,
        multiplier=sympy.nan if inclusion is Inclusion.POINT else map_.slope(word),
        word=map_.spelled(word),
        order=len(map_.chain),
        period=map_.period(word),
        admissible=inclusion is not Inclusion.VIRTUAL,
        stable=_is_stable(map_, i, inclusion),
        at_border=inclusion in (Inclusion.LOWER, Inclusion.UPPER, Inclusion.POINT),
    )


def _is_stable(map_: Decided, i: int, inclusion: Inclusion) -> bool | None:
    """Whether a fixed point attracts; None if a condition is open and none is false."""
    if map_.studied is not None:
        return map_.studied.stable[i]
    open_ = False
    cut, words = cyl.words_beside(map_.cylinders, i, inclusion)
    for test in cyl.stability_tests(cut, words, map_.oracle):
        try:
            if not test():
                return False
        except UndecidedError:
            open_ = True
    return None if open_ else True


def bands(map_: Decided) -> Iterator[tuple[int, int]]:
    """The pieces on which the map is the identity, by their numbers, with minimal periods."""
    for i, cylinder in enumerate(map_.cylinders):
        if _inclusion(map_, i) is Inclusion.BAND:
            period = map_.period(cylinder.word)
            # a word of slope -1 turns points about its fixed point
            yield i, period if map_.oracle.slope(cylinder.word[:period]) > 0 else 2 * period
