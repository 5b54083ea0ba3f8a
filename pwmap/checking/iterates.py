"""Iterates of a map, composed anew from its pieces, and what they have on the diagonal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

from pwmap.checking.polynomials import Place, Poly, Quotient, plus, power, times
from pwmap.checking.refusing import ATOMS, BYTE, OBJECT, Effort, refuse


class IterateValue(NamedTuple):
    """A value of an iterate: a polynomial, divided by a power of the map's denominator."""

    top: Poly
    power: int


class Atom(NamedTuple):
    """An open interval, or a single point, on which all orbits visit the same pieces.

    ``left`` and ``right`` are the limits of the iterate at the ends, None if infinite; at a point
    both are its value. ``cut`` of a point is the break that it reaches and the number of steps.
    """

    word: str
    left: IterateValue | None
    right: IterateValue | None
    cut: tuple[int, int] | None = None


class Map(NamedTuple):
    """A map: affine pieces over one denominator, and the letter of each break and interval."""

    slots: str  # letters of intervals and breaks, in turn from left to right
    slopes: Mapping[str, Poly]
    intercepts: Mapping[str, Poly]
    breaks: tuple[Poly, ...]
    unit: Poly
    work: Effort

    def follow(self, value: IterateValue, word: str) -> IterateValue:
        """The image of a value along a word."""
        top, n = value
        for letter in word:
            shift = self._times(self.intercepts[letter], self._power(n))
            top, n = plus(self.work, self._times(self.slopes[letter], top), shift), n + 1
        return IterateValue(top, n)

    def slope(self, word: str) -> Poly:
        """The slope of a word of n letters, times the n-th power of the denominator."""
        found: Poly = (1,)
        for letter in word:
            found = self._times(found, self.slopes[letter])
        return found

    def offset(self, word: str) -> IterateValue:
        """The value at x = 0 of the affine map of a word."""
        return self.follow(IterateValue((), 1), word)

    def over(self, value: IterateValue, k: int) -> Poly:
        """The numerator of the difference of a value and a break."""
        at = self._times(self.breaks[k], self._power(value.power - 1))
        return plus(self.work, value.top, at, -1)

    def preimage(self, k: int, word: str) -> Quotient:
        """The x that the affine map of a word maps to a break."""
        over = self.over(self.offset(word), k)
        return tuple(-c for c in over), self._times(self.slope(word), self.unit)

    def fixed(self, word: str) -> Quotient:
        """The fixed point of the affine map of a word."""
        return self.offset(word).top, self._times(self.unit, self.excess(word, -1))

    def excess(self, word: str, unit: int) -> Poly:
        """The numerator of 1 + ``unit`` times the slope of a word; the unit is 1 or -1."""
        return plus(self.work, self._power(len(word)), self.slope(word), unit)

    def _times(self, f: Poly, g: Poly) -> Poly:
        return times(self.work, f, g)

    def _power(self, n: int) -> Poly:
        return power(self.work, self.unit, n)

    def ratio(self, value: IterateValue) -> Quotient:
        """A value as a quotient of polynomials."""
        return value.top, self._power(value.power)


class DiagonalObject(NamedTuple):
    """A single fixed point of an iterate, an interval of them, or a jump over the diagonal.

    ``quotients`` are x and slope of a fixed point, the ends of an interval, or x and both limits of
    a jump. A slope is None if the piece is the point alone, an end is None if it is infinite.
    """

    quotients: Mapping[str, Quotient | None]
    stable: bool = False
    at_border: bool = False  # whether a fixed point is a break of the iterate
    closed: tuple[bool, bool] = (False, False)  # whether the ends belong to an interval


class CheckedIterate:
    """An iterate at a place, composed from the map alone, and all that it has on the diagonal."""

    def __init__(self, map_: Map, place: Place, order: int) -> None:
        self.map, self.place, self.order, self.work = map_, place, order, place.work
        if place.sign(map_.unit) <= 0 or any(
            place.sign(plus(self.work, b, a, -1)) <= 0 for a, b in pairwise(map_.breaks)
        ):
            refuse("the denominator of the map must be positive and its breaks ascend")
        self.atoms = [Atom("", None, None)]
        for _ in range(order):
            self.atoms = list(self._refined())

    def _refined(self) -> Iterator[Atom]:
        size = 0
        for atom in self.atoms:
            for new in self._split(atom):
                size += 1
                self.work.keep(new.word, *(value.top for value in new[1:3] if value is not None))
                if size > ATOMS:
                    refuse(f"an iterate has more than {ATOMS} pieces, too many to be checked")
                yield new

    def sense(self, word: str) -> int:
        """The sign of the slope of a word."""
        found = 1
        for letter in word:
            found *= self.place.sign(self.map.slopes[letter])
        return found

    def _slot(self, value: IterateValue) -> int:
        """The slot that holds a value: 2 k + 1 for break k, even numbers for open intervals."""
        for k in range(len(self.map.breaks)):
            side = self.place.sign(self.map.over(value, k))
            if side <= 0:
                return 2 * k + 1 + side
        return 2 * len(self.map.breaks)

    def _beside(self, value: IterateValue | None, side: int) -> int:
        """The slot of the open interval on a side of a value, which is infinite if None."""
        if value is None:
            return 0 if side > 0 else 2 * len(self.map.breaks)
        slot = self._slot(value)
        return slot + side * (slot % 2)

    def _split(self, atom: Atom) -> Iterator[Atom]:
        """Yield the atoms of the next iterate: several if the image of an atom holds breaks."""
        map_, word, sense = self.map, atom.word, self.sense(atom.word)

        def new(
            slot: int, left: IterateValue | None, right: IterateValue | None, cut: Any = None
        ) -> Atom:
            letter = map_.slots[slot]
            first, last = (None if v is None else map_.follow(v, letter) for v in (left, right))
            return Atom(word + letter, first, last, cut)

        if atom.cut is not None or sense == 0:
            slot = self._slot(atom.left or atom.right or map_.offset(word))
            yield new(slot, atom.left, atom.right, atom.cut)
            return
        first, last = self._beside(atom.left, sense), self._beside(atom.right, -sense)
        left = atom.left
        for slot in range(first, last, 2 * sense):
            right = IterateValue(map_.breaks[(slot + sense) // 2], 1)
            yield new(slot, left, right)
            yield new(slot + sense, right, right, ((slot + sense) // 2, len(word)))
            left = right
        yield new(last, left, atom.right)

    # A piece of the iterate is an open atom with those of its ends that have the same word.

    def above(self, point: Atom, value: IterateValue) -> Poly:
        """A polynomial whose sign, times the sense of a point's start, is that of value minus x."""
        k, steps = point.cut or (0, 0)
        return self.map.over(self.map.follow(value, point.word[:steps]), k)

    def side(self, point: Atom | None, value: IterateValue | None) -> int:
        """The sign of a value minus the x of a point; 0 if either is None."""
        if point is None or value is None:
            return 0
        start = point.word[: (point.cut or (0, 0))[1]]
        return self.sense(start) * self.place.sign(self.above(point, value))

    def x(self, point: Atom) -> Quotient:
        """The x of a point."""
        k, steps = point.cut or (0, 0)
        return self.map.preimage(k, point.word[:steps])

    def slope(self, word: str) -> Quotient:
        """The slope of a word as a quotient."""
        return self.map.slope(word), power(self.work, self.map.unit, len(word))

    def excess(self, word: str, unit: int) -> int:
        """The sign of 1 + ``unit`` times the slope of a word; the unit is 1 or -1."""
        return self.place.sign(self.map.excess(word, unit))

    @cached_property
    def beside(self) -> list[tuple[Atom | None, Atom, Atom | None]]:
        """Each atom with its neighbours; None beyond the outer ones."""
        self.work.spend(BYTE * OBJECT * len(self.atoms))
        line = [None, *self.atoms, None]
        return [(line[i - 1], a, line[i + 1]) for i, a in enumerate(self.atoms, start=1)]

    @cached_property
    def bands(self) -> dict[str, DiagonalObject]:
        """All intervals of fixed points, by word."""
        found = {}
        for low, atom, high in self.beside:
            flat = atom.cut is None and not self.excess(atom.word, -1)
            if flat and not self.place.sign(self.map.offset(atom.word).top):
                left, right = (end and self.x(end) for end in (low, high))
                closed = (end is not None and end.word == atom.word for end in (low, high))
                ends = self._kept(left=left, right=right)
                found[atom.word] = DiagonalObject(ends, closed=(next(closed), next(closed)))
        return found

    @cached_property
    def fixed(self) -> dict[str, DiagonalObject]:
        """All fixed points outside of such intervals, by word."""
        found = {}
        for low, atom, high in self.beside:
            word = atom.word
            if word in self.bands:
                continue
            if atom.cut is not None:
                if self.side(atom, atom.left) == 0:
                    found[word] = self._at_point(low, atom, high)
            elif steepness := self.excess(word, -1):
                left, right = self.side(low, atom.left), self.side(high, atom.right)
                if (
                    steepness * left >= (low is not None)
                    and (high is not None) <= -steepness * right
                ):
                    stable = steepness > 0 and self.excess(word, 1) > 0
                    known = self._kept(x=self.map.fixed(word), slope=self.slope(word))
                    found[word] = DiagonalObject(known, stable)
        return found

    def _kept(self, **quotients: Quotient | None) -> dict[str, Quotient | None]:
        """The quotients by their names, after charging for their memory."""
        self.work.keep(*(part for each in quotients.values() if each is not None for part in each))
        return quotients

    def _at_point(self, low: Atom | None, atom: Atom, high: Atom | None) -> DiagonalObject:
        """A fixed point at a break of the iterate, between two open atoms."""
        assert low is not None
        assert high is not None
        owned = atom.word in (low.word, high.word)
        # it attracts if the iterate is continuous and the slopes m, n beside it satisfy m < 1,
        # n < 1 and m n < 1: a positive slope keeps the side, two negative ones alternate
        stable = not self.side(atom, low.right) and not self.side(atom, high.left)
        slopes = (low.word, high.word, low.word + high.word)
        stable = stable and all(self.excess(word, -1) > 0 for word in slopes)
        slope = self.slope(atom.word) if owned else None
        return DiagonalObject(self._kept(x=self.x(atom), slope=slope), stable, at_border=True)

    @cached_property
    def crossings(self) -> dict[str, DiagonalObject]:
        """All jumps over the diagonal, by the words on their two sides."""
        found = {}
        for low, atom, high in self.beside:
            left, right = low and low.right, high and high.left
            if atom.cut is None or low is None or high is None or left is None or right is None:
                continue
            if self.side(atom, left) * self.side(atom, right) < 0:
                limits = {"left": self.map.ratio(left), "right": self.map.ratio(right)}
                known = self._kept(x=self.x(atom), **limits)
                found[f"{low.word}|{high.word}"] = DiagonalObject(known)
        return found
