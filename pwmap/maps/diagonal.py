"""Fixed points, jumps and cycles of a map, and the images of points."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import accumulate, pairwise

import sympy

from pwmap.algebra.arguments import check_text
from pwmap.algebra.arithmetic import fraction_of
from pwmap.algebra.exact import Fraction_, fraction_to_sympy, quotient_to_sympy
from pwmap.algebra.texts import printable
from pwmap.maps import cylinders as cyl
from pwmap.maps.cylinders import Cut, Inclusion
from pwmap.maps.decided import Decided, Scope
from pwmap.maps.words import Layout, Offset, Word


@printable
@dataclass(frozen=True, slots=True, kw_only=True)
class FixedPoint:
    """An exact fixed point of an iterate, from :meth:`PiecewiseLinearMap.fixed_points`.

    Attributes
    ----------
    multiplier
        Slope of the piece that owns the point; ``nan`` if that piece is the point alone.
    word
        The pieces visited, starting at x.
    order, period
        The iterate it was found in, and the minimal period of the point.
    admissible
        False for a virtual fixed point: one of a piece's formula that lies outside the piece.
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
    """A piece that is the identity, from :meth:`PiecewiseLinearMap.fixed_intervals`."""

    interval: sympy.Set
    word: str
    order: int
    period: int  # minimal, of all points but the centre of a reflection, which has half of it


@printable
@dataclass(frozen=True, slots=True, kw_only=True)
class Discontinuity:
    """A discontinuity with one-sided limits and value, from :meth:`PiecewiseLinearMap.jumps`."""

    x: sympy.Expr
    left: sympy.Expr
    value: sympy.Expr
    right: sympy.Expr


@printable
@dataclass(frozen=True, slots=True, kw_only=True)
class JumpCrossing:
    """A discontinuity that crosses the diagonal, from :meth:`PiecewiseLinearMap.jump_crossings`."""

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
        if slot % 2 and direction:  # on a break the limit takes the piece of the images' side
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
        if left.is_point:  # the pair before had this cut, too
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
    """All isolated fixed points in the order of their pieces, with or without virtual ones."""
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
    if map_.studied is not None:
        return map_.studied.stable[i]
    return cyl.is_stable(*cyl.words_beside(map_.cylinders, i, inclusion), map_.oracle)


def bands(map_: Decided) -> Iterator[tuple[int, int]]:
    """Index and minimal period of each piece on which the map is the identity."""
    for i, cylinder in enumerate(map_.cylinders):
        if _inclusion(map_, i) is Inclusion.BAND:
            period = map_.period(cylinder.word)
            # a word of slope -1 reflects points in its fixed point: they return after two turns
            yield i, period if map_.oracle.slope(cylinder.word[:period]) > 0 else 2 * period


@printable
@dataclass(frozen=True, slots=True, kw_only=True)
class Cycle:
    """A cycle from :meth:`PiecewiseLinearMap.cycle`, with its points in the order of the word.

    ``multiplier`` is the product of the slopes, ``nan`` if one of the pieces is a single point. The
    cycle exists if all ``conditions`` hold: each point lies in its piece.
    """

    word: str
    points: tuple[sympy.Expr, ...]
    multiplier: sympy.Expr
    conditions: tuple[sympy.Basic, ...]
    _signs: tuple[tuple[Fraction_, bool], ...] = field(repr=False)  # margins, and if 0 is allowed
    _scope: Scope = field(repr=False)

    @property
    def admissible(self) -> bool:
        """Whether all conditions hold; UndecidedError if the assumptions leave that open."""
        decide = self._scope.sign
        return all(
            decide(top) * decide(bottom) >= (0 if closed else 1)
            for (top, bottom), closed in self._signs
        )


def cycle_of(map_: Decided, word: str) -> Cycle:
    """The cycle that visits the pieces a word names."""
    indices = _read_word(map_, word)
    points, images, multiplier = _cycle_points(map_, indices)
    conditions: list[sympy.Basic] = []
    signs: list[tuple[Fraction_, bool]] = []
    for point, layout, index in zip(images, map_.layouts(len(word)), indices, strict=True):
        for relation, margin, closed in conditions_on(map_, point, layout, index):
            if margin[0] or not closed:  # otherwise the point is this break for all parameters
                signs.append((margin, closed))
                conditions.append(relation)
    return Cycle(
        word=word,
        points=tuple(fraction_to_sympy(point) for point in points),
        multiplier=multiplier,
        conditions=tuple(c for c in dict.fromkeys(conditions) if c != sympy.true),
        _signs=tuple(signs),
        _scope=map_.scope,
    )


Bound = tuple[int, int, bool]  # a break, the letter's side of it, whether the letter owns it
# a relation, and its margin, positive inside up to a positive factor, and whether 0 is allowed
PieceCondition = tuple[sympy.Basic, Fraction_, bool]


def conditions_on(
    map_: Decided, point: Fraction_, layout: Layout, letter: int
) -> Iterator[PieceCondition]:
    """Yield the conditions under which a point lies in the piece of a letter, at most two."""
    top, bottom = point
    for bound in letter_bounds(layout, letter):
        k, side, closed = bound
        a, b = map_.orbits.preimage(k, ())
        relation = relation_of(map_, fraction_to_sympy(point), bound)
        yield relation, (side * (b * top - a * bottom), bottom), closed


def relation_of(map_: Decided, point: sympy.Expr, bound: Bound) -> sympy.Basic:
    """The condition that a point satisfies a bound: it lies on the letter's side of the break."""
    k, side, closed = bound
    relations = (sympy.Ge, sympy.Gt) if side > 0 else (sympy.Le, sympy.Lt)
    return relations[0 if closed else 1](point, quotient_to_sympy(map_.orbits.preimage(k, ())))


def letter_bounds(layout: Layout, letter: int) -> Iterator[Bound]:
    """The breaks that bound the piece of a letter, at most two."""
    owned = [slot for slot, owner in enumerate(layout.slots) if owner == letter]
    low, high = min(owned), max(owned)
    if low > 0:
        yield layout.breaks[(low - 1) // 2], 1, bool(low % 2)
    if high < len(layout.slots) - 1:
        yield layout.breaks[high // 2], -1, bool(high % 2)


def _read_word(map_: Decided, word: str) -> Word:
    """The pieces that the letters of a word name; two maps may use the same letter."""
    check_text("the word of a cycle", word)
    indices = []
    for letter, layout in zip(word, map_.layouts(len(word)), strict=True):
        own = {map_.definition.letters[i]: i for i in dict.fromkeys(layout.slots)}
        if letter not in own:
            raise ValueError(f"{letter!r} is no piece of this map, it has {tuple(own)}")
        indices.append(own[letter])
    if not word:
        raise ValueError("the word of a cycle must have at least one letter")
    if len(word) % len(map_.chain):
        raise ValueError(f"the length of a word must be a multiple of {len(map_.chain)}: {word!r}")
    return tuple(indices)


def _cycle_points(map_: Decided, word: Word) -> tuple[list[Fraction_], list[Fraction_], sympy.Expr]:
    """The points of a cycle, each as the image of the one before, which it must be; its slope."""
    root = word[: map_.period(word)]  # a power of a word has the points of that word
    slope = map_.orbits.slope(word)
    at = _point_piece(map_, root)
    multiplier = quotient_to_sympy(slope) if at is None else sympy.nan
    if at is None and map_.is_zero(slope[0] - slope[1]):
        root, at = word, _isolated_cut(map_, word)
    orbits, table = map_.orbits, map_.orbits.table
    first, start = (
        (0, orbits.fixed_point(root)) if at is None else (at.steps, orbits.preimage(at.k, ()))
    )
    orbit = [*accumulate(root[first:] + root[:first], table.image, initial=start)]
    last = len(root) - first  # the place of the first letter in it
    points = orbit[last:-1] + orbit[:last]
    images = points if at is None else orbit[last:] + orbit[1:last]
    turns = len(word) // len(root)
    return points * turns, images * turns, multiplier


def _point_piece(map_: Decided, word: Word) -> Cut | None:
    """The cut at which a cycle passes through a piece that is a single point, or None."""
    for i, (layout, letter) in enumerate(zip(map_.layouts(len(word)), word, strict=True)):
        if layout.slots.count(letter) == 1 and layout.slots.index(letter) % 2:
            return Cut(layout.breaks[layout.slots.index(letter) // 2], i)
    return None


def _isolated_cut(map_: Decided, word: Word) -> Cut:
    """The cut of a cycle of slope 1; ValueError unless its cylinder is a single point."""
    if map_.oracle.sign(Offset(word)) == 0:
        chain = map_.chain * (len(word) // len(map_.chain))
        cylinder = cyl.cylinder_of(word, chain, map_.oracle)
        if cylinder is not None and cylinder.is_point:
            assert cylinder.lower is not None
            return cylinder.lower
    raise ValueError(f"the slope of {map_.spelled(word)} is 1: it has no isolated cycle")
