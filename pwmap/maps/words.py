"""Words, the affine maps they stand for, and the decisions that need a sign.

Let the pieces of a map be A_i(x) = m_i x + c_i and its breaks b_k. A word w = i_1 ... i_n names A_w
= A_{i_n} o ... o A_{i_1}. Every break of an iterate is a preimage of some b_k along the prefix of a
word w = uv, so its image under A_w is A_v(b_k). Hence composition, fixed points and jump crossings
need only the signs of *critical orbits* A_v(b_k) - b_l, of slopes m_i, and of multipliers minus 1
or plus 1, and stay the same wherever these polynomials keep their signs.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from math import prod
from typing import Any, NamedTuple, TypeVar

from sympy.polys.rings import PolyElement

from pwmap.algebra.exact import Fraction_, Infinite, Number, Portable, bits, constant, is_constant
from pwmap.algebra.numbers import Element, Exact
from pwmap.algebra.roots import integers
from pwmap.maps.budget import cost

Word = tuple[int, ...]
Letters = TypeVar("Letters", Word, str)


class Layout(NamedTuple):
    """How one map cuts the line: n breaks make 2 n + 1 slots, of which slot 2 i + 1 is break i."""

    breaks: tuple[int, ...]  # indices into Table.breaks, from left to right
    slots: tuple[int, ...]  # the letter that owns each slot

    @property
    def between(self) -> tuple[int, ...]:
        """The letters of the open intervals, from left to right."""
        return self.slots[::2]

    def word(self, numbers: Iterable[int]) -> Word:
        """The letters of open intervals, given by their numbers from the left."""
        return tuple(self.slots[2 * number] for number in numbers)

    def around(self, number: int) -> tuple[int, ...]:
        """The breaks at the ends of an open interval, one or two."""
        return self.breaks[max(0, number - 1) : number + 1]

    def visits(self, k: int, numbers: Sequence[int]) -> Iterator[CriticalOrbit]:
        """Yield the decisions by which a side of the break k visits open intervals in turn."""
        word = self.word(numbers)
        for n, number in enumerate(numbers[1:], start=1):
            yield from (CriticalOrbit(k, word[:n], other) for other in self.around(number))


@dataclass(frozen=True, slots=True)
class Table(Portable):
    """Coefficients of one or more maps, as numerators over one denominator."""

    slopes: tuple[Number, ...]  # by letter
    intercepts: tuple[Number, ...]  # by letter
    breaks: tuple[Number, ...]
    layouts: tuple[Layout, ...]
    one: Number  # the 1 of the coefficients' ring
    denominator: Number  # positive under the assumptions

    def mapped(self, change: Callable[[Number], Number]) -> Table:
        """The maps with changed coefficients; a denominator made constant is divided out."""
        one, denominator = change(self.one), change(self.denominator)
        if denominator != one and is_constant(denominator):
            scale = constant(denominator)
            return self.over(one, lambda number: change(number) / scale, one)
        return self.over(denominator, change, one)

    def over(self, denominator: Number, change: Callable[[Number], Number], one: Number) -> Table:
        """The same maps with changed numerators over another denominator."""
        slopes, intercepts, breaks = (
            tuple(map(change, group)) for group in (self.slopes, self.intercepts, self.breaks)
        )
        return Table(slopes, intercepts, breaks, self.layouts, one, denominator)

    def image(self, point: Fraction_, letter: int) -> Fraction_:
        """The value of a piece at a point."""
        top, bottom = point
        image = self.slopes[letter] * top + self.intercepts[letter] * bottom
        return image, self.denominator * bottom

    def numbers(self) -> tuple[Number, ...]:
        """All of its numbers: slopes, intercepts, breaks, one and the denominator."""
        return (*self.slopes, *self.intercepts, *self.breaks, self.one, self.denominator)


def in_integers(table: Table) -> Table:
    """The same maps with rational coefficients as integers over one denominator."""
    unit = integers(table.numbers())[-2]  # what ``one`` becomes: the common denominator
    return table.over(unit, lambda number: int(number * unit), 1)


def work_of(x: Exact) -> int:
    """The work of one operation with a number, in the units of :class:`pwmap.Budget`."""
    if isinstance(x, Infinite):
        return 0
    if isinstance(x, Element):
        longest = max(map(bits, x.value), default=0)
        return len(x.root.polynomial) ** 2 * cost(longest + 2 * max(map(bits, x.root.polynomial)))
    return cost(bits(x))


def _bits(number: Number) -> int:
    parts = number.values() if isinstance(number, PolyElement) else (number,)
    return max(map(bits, parts), default=1)


def over_one_denominator(tables: Sequence[Table]) -> list[Table]:
    """The same tables, of one ring, with a common denominator."""
    common = reduce(lambda a, b: a if a == b else a.lcm(b), (t.denominator for t in tables))

    def scaled(table: Table) -> Table:
        scale = table.one if table.denominator == common else common.quo(table.denominator)
        return table.over(common, lambda number: scale * number, table.one)

    return [scaled(table) for table in tables]


class CriticalOrbit(NamedTuple):
    """The critical orbit of break k against a break, or its image: A_word(b_k) - A_start(b_l)."""

    k: int
    word: Word
    l: int  # noqa: E741  the notation of the module
    start: Word = ()


class MultiplierSign(NamedTuple):
    """The slope of a word minus 1, -1 or 0; letters are sorted, as their slopes commute."""

    word: Word
    unit: int


def units_of(word: Word) -> tuple[MultiplierSign, MultiplierSign]:
    """The decisions whether the slope of a word is larger than 1, and than -1."""
    letters = tuple(sorted(word))
    return MultiplierSign(letters, 1), MultiplierSign(letters, -1)


class Offset(NamedTuple):
    """The intercept of a word, which decides about fixed points where its slope is 1."""

    word: Word
    name: str = "offset"


Decision = CriticalOrbit | MultiplierSign | Offset


def first_rotation(word: Letters, step: int = 1) -> Letters:
    """The alphabetically first word of a cycle that begins at a multiple of ``step`` letters."""
    return min(word[i:] + word[:i] for i in range(0, len(word), step))


class Orbits:
    """Affine maps of words and orbits of breaks as numerators, each computed once."""

    def __init__(self, table: Table) -> None:
        self.table = table
        zero = table.one - table.one
        self._plain = table.denominator == table.one
        self._whole = isinstance(table.one, int)
        self._bits = max(map(_bits, table.numbers()))
        self._powers: list[Number] = [table.one]
        # the map of a word of n letters over D**n, the orbit of a break along it over D**(n + 1)
        self._affine: dict[Word, tuple[Number, Number]] = {(): (table.one, zero)}
        self._orbits: dict[tuple[int, Word], Number] = {}
        self._slopes: dict[tuple[tuple[int, int], ...], Number] = {}  # by counts of letters
        self._polynomials: dict[Decision, Number] = {}

    def __reduce__(self) -> tuple[type[Orbits], tuple[Table]]:
        return Orbits, (self.table,)

    def work(self, letters: int) -> int:
        """The work of one operation on the numbers of a word of so many letters."""
        if self._whole:
            return cost(letters * self.table.denominator.bit_length())
        return (1 + letters) * cost(letters * self._bits)

    def power(self, n: int) -> Number:
        """D**n, with D the common denominator."""
        if self._plain:
            return self.table.one
        while len(self._powers) <= n:
            self._powers.append(self._powers[-1] * self.table.denominator)
        return self._powers[n]

    def affine(self, word: Word) -> tuple[Number, Number]:
        """Slope and intercept of A_word, over D**n."""
        found = self._affine.get(word)
        if found is None:
            known = len(word) - 1 if word[:-1] in self._affine else 0
            slope, intercept = self._affine[word[:known]]
            for n, letter in enumerate(word[known:], start=known):
                slope = self.table.slopes[letter] * slope
                intercept = self._image(letter, intercept, n)
            found = self._affine[word] = slope, intercept
        return found

    def orbit(self, k: int, word: Word) -> Number:
        """A_word(b_k), over D**(n + 1)."""
        if not word:
            return self.table.breaks[k]
        found = self._orbits.get((k, word))
        if found is None:
            known = len(word) - 1 if (k, word[:-1]) in self._orbits else 0
            found = self._orbits[k, word[:known]] if known else self.table.breaks[k]
            for n, letter in enumerate(word[known:], start=known + 1):
                found = self._image(letter, found, n)
            self._orbits[k, word] = found
        return found

    def _image(self, letter: int, value: Number, n: int) -> Number:
        """The image of a value; the value is over D**n, the image over D**(n + 1)."""
        return self.table.slopes[letter] * value + self._over(n, self.table.intercepts[letter])

    def _over(self, n: int, number: Number) -> Number:
        """A number times D**n."""
        return number if self._plain else number * self.power(n)

    def slope(self, word: Word) -> Fraction_:
        """The slope of A_word, as numerator and denominator, for any order of the letters."""
        counts = tuple(sorted(Counter(word).items()))
        if counts not in self._slopes:
            powers = (self.table.slopes[letter] ** count for letter, count in counts)
            self._slopes[counts] = prod(powers, start=self.table.one)
        return self._slopes[counts], self.power(len(word))

    def intercept(self, word: Word) -> Fraction_:
        """The intercept of A_word, as numerator and denominator."""
        return self.affine(word)[1], self.power(len(word))

    def value(self, k: int, word: Word) -> Fraction_:
        """A_word(b_k), as numerator and denominator."""
        return self.orbit(k, word), self.power(len(word) + 1)

    def preimage(self, k: int, word: Word) -> Fraction_:
        """The x with A_word(x) = b_k, as numerator and denominator."""
        if not word:
            return self.table.breaks[k], self.table.denominator
        slope, intercept = self.affine(word)
        return self._over(len(word) - 1, self.table.breaks[k]) - intercept, slope

    def fixed_point(self, word: Word) -> Fraction_:
        """The x with A_word(x) = x, as numerator and denominator."""
        slope, intercept = self.affine(word)
        return intercept, self.power(len(word)) - slope

    def meeting(self, k: int, word: Word, cycle: Word) -> Number:
        """The polynomial that vanishes where A_word(b_k) is the fixed point of a cycle's word."""
        (a, b), (c, d) = self.value(k, word), self.fixed_point(cycle)
        return a * d - c * b

    def polynomial(self, decision: Decision) -> Number:
        """The number whose sign makes a decision."""
        if self._whole:  # integers are not kept here: the oracle keeps their signs
            return self._numerator(decision)
        found = self._polynomials.get(decision)
        if found is None:
            found = self._polynomials[decision] = self._polynomial(decision)
        return found

    def _polynomial(self, decision: Decision) -> Number:
        found = self._numerator(decision)
        while found and not self._plain:  # divide by D > 0, which does not change the sign
            quotient, rest = found.div(self.table.denominator)
            if rest:
                break
            found = quotient
        return found

    def _numerator(self, decision: Decision) -> Number:
        match decision:
            case CriticalOrbit(k, word, l, start):
                other = self._over(len(word) - len(start), self.orbit(l, start))
                return self.orbit(k, word) - other
            case MultiplierSign(word, unit):
                slope, power = self.slope(word)
                return slope - unit * power
            case Offset(word):
                return self.affine(word)[1]


class SignOracle:
    """The signs of decisions, each computed once."""

    def __init__(
        self,
        orbits: Orbits,
        sign_of: Callable[[Number], int],
        recorded: Mapping[Decision, int] | None = None,
    ) -> None:
        self.orbits = orbits
        self.signs: dict[Decision, int] = dict(recorded or {})
        self._keeps = recorded is not None  # in a pickle: ``sign_of`` alone may not prove them
        self.sign_of = sign_of
        self._slopes: dict[Word, int] = {(): 1}

    def __reduce__(self) -> tuple[type[SignOracle], tuple[object, ...]]:
        return SignOracle, (self.orbits, self.sign_of, self.signs if self._keeps else None)

    def ask(self, question: Callable[..., Any], *about: Hashable) -> Any:
        """Return ``question(*about, self)``."""
        return question(*about, self)

    def sign(self, decision: Decision) -> int:
        """The sign of the polynomial of a decision."""
        found = self.signs.get(decision)
        if found is None:
            found = self.signs[decision] = self.sign_of(self.orbits.polynomial(decision))
        return found

    def slope(self, word: Word) -> int:
        """Sign of the slope of a word."""
        product = self._slopes.get(word)
        if product is None:
            product = 1
            for letter in word:
                product *= self.sign(MultiplierSign((letter,), 0))
                if not product:
                    break
            self._slopes[word] = product
        return product

    def multiplier(self, word: Word, unit: int) -> int:
        """Sign of the slope of a word minus a unit, +1 or -1."""
        return self.sign(MultiplierSign(tuple(sorted(word)), unit))

    def slot(self, layout: int, k: int, word: Word) -> int:
        """The slot of a map in which A_word(b_k) lies."""
        breaks = self.orbits.table.layouts[layout].breaks
        low, high = 0, len(breaks)
        while low < high:
            middle = (low + high) // 2
            side = self.sign(CriticalOrbit(k, word, breaks[middle]))
            if side == 0:
                return 2 * middle + 1
            if side < 0:
                high = middle
            else:
                low = middle + 1
        return 2 * low
