"""Words, the affine maps they stand for, and the only questions that ever need a sign.

Let the pieces of a map be A_i(x) = m_i x + c_i and its breaks b_k. A word w = i_1 ... i_n names
the affine map A_w = A_{i_n} o ... o A_{i_1}. Every break of an iterate is a preimage of some b_k
along the prefix of a word, and following it onward gives A_v(b_k): so each comparison that
composition, fixed points and jump crossings need is the sign of a *critical orbit*

    A_v(b_k) - b_l,

of a slope m_i, or of a multiplier minus 1 or plus 1. The words are the symbols: what holds for
one value of the parameters is a table of such signs, and it holds wherever these polynomials
keep their signs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from pwmap.exact import (
    Fraction_,
    Number,
    Packed,
    constant,
    is_constant,
    packed,
    ring_of,
    unpacked,
)

Word = tuple[int, ...]


class Layout(NamedTuple):
    """How one map cuts the line.

    With n breaks there are 2 n + 1 slots from left to right: the open interval left of the first
    break, that break, the next open interval, and so on. Break i is slot 2 i + 1.
    """

    breaks: tuple[int, ...]  # indices into Table.breaks, from left to right
    slots: tuple[int, ...]  # the letter that owns each slot


@dataclass(frozen=True, slots=True)
class Table:
    """Coefficients of one or more maps: slope and intercept by letter, breaks by index.

    All of them are numerators over one ``denominator``, which is positive under the assumptions.
    """

    slopes: tuple[Number, ...]
    intercepts: tuple[Number, ...]
    breaks: tuple[Number, ...]
    layouts: tuple[Layout, ...]
    one: Number  # of the ring the coefficients live in
    denominator: Number

    def mapped(self, change: Callable[[Number], Number]) -> Table:
        """The same maps with every coefficient changed, for instance evaluated.

        A denominator that becomes a constant is divided out.
        """
        one, denominator = change(self.one), change(self.denominator)
        if denominator != one and is_constant(denominator):
            scale, numerator, denominator = constant(denominator), change, one

            def change(number: Number) -> Number:
                return numerator(number) / scale

        return Table(
            tuple(map(change, self.slopes)),
            tuple(map(change, self.intercepts)),
            tuple(map(change, self.breaks)),
            self.layouts,
            one,
            denominator,
        )

    def __reduce__(self) -> tuple[Callable[..., Table], tuple[object, ...]]:
        numbers = (*self.slopes, *self.intercepts, *self.breaks, self.one, self.denominator)
        return _table, (packed(ring_of(self.one), numbers), len(self.slopes), self.layouts)


def over_one_denominator(tables: Sequence[Table]) -> list[Table]:
    """The same tables, of one ring, with a common denominator."""
    common = tables[0].denominator
    for table in tables:
        if table.denominator != common:
            common = common.lcm(table.denominator)
    scaled = []
    for table in tables:
        scale = table.one if table.denominator == common else common.quo(table.denominator)
        numbers = (table.slopes, table.intercepts, table.breaks)
        slopes, intercepts, breaks = (tuple(scale * n for n in group) for group in numbers)
        scaled.append(Table(slopes, intercepts, breaks, table.layouts, table.one, common))
    return scaled


def _table(kept: Packed, letters: int, layouts: tuple[Layout, ...]) -> Table:
    numbers = unpacked(kept)[1]
    slopes, intercepts = numbers[:letters], numbers[letters : 2 * letters]
    return Table(slopes, intercepts, numbers[2 * letters : -2], layouts, *numbers[-2:])


class Order(NamedTuple):
    """Where the critical orbit of break k is after a word: A_word(b_k) - b_l."""

    k: int
    word: Word
    l: int  # noqa: E741  the notation of the module


class Slope(NamedTuple):
    """The slope of one letter."""

    letter: int


class Multiplier(NamedTuple):
    """The slope of a word minus a unit, +1 or -1; the letters are sorted, they commute."""

    word: Word
    unit: int


class Offset(NamedTuple):
    """The intercept of a word, asked where its slope is 1."""

    word: Word
    name: str = "offset"


Question = Order | Slope | Multiplier | Offset


class Orbits:
    """Affine forms of words and orbits of breaks, each computed once.

    With D the denominator of the table, the affine form of a word of n letters is kept over D**n,
    and the orbit of a break along it over D**(n + 1): all signs are those of numerators.

    Parameters
    ----------
    table
        The coefficients, all in one ring.
    """

    def __init__(self, table: Table) -> None:
        self.table = table
        zero = table.one - table.one
        self._plain = table.denominator == table.one
        self._powers: list[Number] = [table.one]
        self._affine: dict[Word, tuple[Number, Number]] = {(): (table.one, zero)}
        self._orbits: dict[tuple[int, Word], Number] = {}

    def __reduce__(self) -> tuple[type[Orbits], tuple[Table]]:
        return Orbits, (self.table,)

    def power(self, n: int) -> Number:
        """D**n."""
        if self._plain:
            return self.table.one
        while len(self._powers) <= n:
            self._powers.append(self._powers[-1] * self.table.denominator)
        return self._powers[n]

    def affine(self, word: Word) -> tuple[Number, Number]:
        """Slope and intercept of A_word, over D**n."""
        found = self._affine.get(word)
        if found is None:
            slope, intercept = self.affine(word[:-1])
            m, c = self.table.slopes[word[-1]], self.table.intercepts[word[-1]]
            c = c if self._plain else c * self.power(len(word) - 1)
            found = self._affine[word] = (m * slope, m * intercept + c)
        return found

    def orbit(self, k: int, word: Word) -> Number:
        """A_word(b_k), over D**(n + 1)."""
        if not word:
            return self.table.breaks[k]
        found = self._orbits.get((k, word))
        if found is None:
            before = self.orbit(k, word[:-1])
            m, c = self.table.slopes[word[-1]], self.table.intercepts[word[-1]]
            c = c if self._plain else c * self.power(len(word))
            found = self._orbits[k, word] = m * before + c
        return found

    def slope(self, word: Word) -> Fraction_:
        """The slope of A_word, as numerator and denominator."""
        return self.affine(word)[0], self.power(len(word))

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
        b = self.table.breaks[k]
        return (b if self._plain else b * self.power(len(word) - 1)) - intercept, slope

    def fixed_point(self, word: Word) -> Fraction_:
        """The x with A_word(x) = x, as numerator and denominator."""
        slope, intercept = self.affine(word)
        return intercept, self.power(len(word)) - slope

    def polynomial(self, question: Question) -> Number:
        """The number whose sign answers a question."""
        found = self._numerator(question)
        while found and not self._plain:  # a factor that is positive answers nothing
            quotient, rest = found.div(self.table.denominator)
            if rest:
                break
            found = quotient
        return found

    def _numerator(self, question: Question) -> Number:
        match question:
            case Order(k, word, l):
                b = self.table.breaks[l]
                return self.orbit(k, word) - (b if self._plain else b * self.power(len(word)))
            case Slope(letter):
                return self.table.slopes[letter]
            case Multiplier(word, unit):
                return self.affine(word)[0] - unit * self.power(len(word))
            case Offset(word):
                return self.affine(word)[1]


class Judge:
    """Answers questions, and remembers all it was asked.

    Parameters
    ----------
    orbits
        Where the polynomials come from.
    sign
        The sign of such a polynomial: -1, 0 or +1.
    """

    def __init__(self, orbits: Orbits, sign: Callable[[Number], int]) -> None:
        self.orbits = orbits
        self.answers: dict[Question, int] = {}
        self._sign = sign
        self._slots: dict[tuple[int, int, Word], int] = {}

    def __reduce__(self) -> tuple[type[Judge], tuple[Orbits, Callable[[Number], int]]]:
        return Judge, (self.orbits, self._sign)

    def ask(self, question: Question) -> int:
        """The sign of the polynomial of a question."""
        answer = self.answers.get(question)
        if answer is None:
            answer = self.answers[question] = self._sign(self.orbits.polynomial(question))
        return answer

    def slope(self, word: Word) -> int:
        """Sign of the slope of a word."""
        product = 1
        for letter in word:
            product *= self.ask(Slope(letter))
            if not product:
                return 0
        return product

    def multiplier(self, word: Word, unit: int) -> int:
        """Sign of the slope of a word minus a unit, +1 or -1."""
        return self.ask(Multiplier(tuple(sorted(word)), unit))

    def slot(self, layout: int, k: int, word: Word) -> int:
        """The slot of a map in which A_word(b_k) lies."""
        key = layout, k, word
        found = self._slots.get(key)
        if found is None:
            found = self._slots[key] = self._search(layout, k, word)
        return found

    def _search(self, layout: int, k: int, word: Word) -> int:
        breaks = self.orbits.table.layouts[layout].breaks
        low, high = 0, len(breaks)
        while low < high:
            middle = (low + high) // 2
            side = self.ask(Order(k, word, breaks[middle]))
            if side == 0:
                return 2 * middle + 1
            if side < 0:
                high = middle
            else:
                low = middle + 1
        return 2 * low
