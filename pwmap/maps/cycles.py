"""Cycles of a map by their words, with conditions for their existence."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import accumulate

import sympy

from pwmap.algebra.arguments import check_text
from pwmap.algebra.exact import Fraction_, fraction_to_sympy, quotient_to_sympy
from pwmap.maps import cylinders as cyl
from pwmap.maps.cylinders import Cut
from pwmap.maps.decided import Decided
from pwmap.maps.scopes import Scope
from pwmap.maps.words import Layout, Offset, Word


@dataclass(frozen=True, slots=True, kw_only=True)
class Cycle:
    """A cycle of :meth:`PiecewiseLinearMap.cycle`, with its points in the order of the word.

    ``multiplier`` is the product of the slopes, ``nan`` if one of the pieces is a single point. The
    cycle exists if all ``conditions`` hold: each point lies in its piece.
    """

    word: str
    points: tuple[sympy.Expr, ...]
    multiplier: sympy.Expr
    conditions: tuple[sympy.Basic, ...]
    _signs: tuple[tuple[Fraction_, bool], ...] = field(repr=False)  # positive, or also zero
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
    points, multiplier = _cycle_points(map_, indices)
    conditions: list[sympy.Basic] = []
    signs: list[tuple[Fraction_, bool]] = []
    for (top, bottom), layout, index in zip(points, map_.layouts(len(word)), indices, strict=True):
        for k, side, closed in letter_bounds(layout, index):
            value = map_.orbits.preimage(k, ())
            over = side * (value[1] * top - value[0] * bottom)
            if closed and not over:  # the point is this break
                continue
            signs.append(((over, bottom), closed))
            point, at = fraction_to_sympy((top, bottom)), quotient_to_sympy(value)
            conditions.append(beyond(point, at, side, closed))
    return Cycle(
        word=word,
        points=tuple(fraction_to_sympy(point) for point in points),
        multiplier=multiplier,
        conditions=tuple(c for c in dict.fromkeys(conditions) if c != sympy.true),
        _signs=tuple(signs),
        _scope=map_.scope,
    )


def beyond(point: sympy.Expr, at: sympy.Expr, side: int, closed: bool) -> sympy.Basic:
    """The condition that a point lies to the right (side 1) or left (-1) of another, or is it."""
    relations = (sympy.Ge, sympy.Gt) if side > 0 else (sympy.Le, sympy.Lt)
    return relations[0 if closed else 1](point, at)


def letter_bounds(layout: Layout, letter: int) -> Iterator[tuple[int, int, bool]]:
    """Breaks that bound a letter, the side of each it lies on, and whether it owns them."""
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


def _cycle_points(map_: Decided, word: Word) -> tuple[list[Fraction_], sympy.Expr]:
    root = word[: map_.period(word)]  # what is repeated has the same points
    slope = map_.orbits.slope(word)
    at = _point_piece(map_, root)
    multiplier = quotient_to_sympy(slope) if at is None else sympy.nan
    if at is None and map_.is_zero(slope[0] - slope[1]):
        root, at = word, _only_point(map_, word)
    if at is None:
        points = _orbit(map_, map_.orbits.fixed_point(root), root)
    else:
        turned = root[at.steps :] + root[: at.steps]
        points = _orbit(map_, map_.orbits.preimage(at.k, ()), turned)
        points = points[len(root) - at.steps :] + points[: len(root) - at.steps]
    return points * (len(word) // len(root)), multiplier


def _orbit(map_: Decided, start: Fraction_, word: Word) -> list[Fraction_]:
    """A point and its images along a word, but for the last one."""
    return [*accumulate(word[:-1], map_.orbits.table.image, initial=start)]


def _point_piece(map_: Decided, word: Word) -> Cut | None:
    """Where a cycle passes through a piece that is a point."""
    for i, (layout, letter) in enumerate(zip(map_.layouts(len(word)), word, strict=True)):
        if layout.slots.count(letter) == 1 and layout.slots.index(letter) % 2:
            return Cut(layout.breaks[layout.slots.index(letter) // 2], i)
    return None


def _only_point(map_: Decided, word: Word) -> Cut:
    """Where a cycle of slope 1 passes, which is isolated only if its word has a single point."""
    if map_.oracle.sign(Offset(word)) == 0:
        chain = map_.chain * (len(word) // len(map_.chain))
        cylinder = cyl.cylinder_of(word, chain, map_.oracle)
        if cylinder is not None and cylinder.is_point:
            assert cylinder.lower is not None
            return cylinder.lower
    raise ValueError(f"the slope of {map_.spelled(word)} is 1: it has no isolated cycle")
