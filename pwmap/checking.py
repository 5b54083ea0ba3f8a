"""Check certificates of piecewise-linear maps: all of it, from integers and fractions alone.

Nothing but the standard library is used, and nothing else of the package: a reader can follow every
step. A map is given by affine pieces whose coefficients are polynomials in one parameter, or
numbers. Its iterates are composed anew; whatever that takes is the sign of a polynomial in the
parameter, at a number or on an open interval where it has no root, which Sturm's theorem shows
[BasuPollackRoy2006, Theorem 2.73]. So a list that is found at one value holds on the interval.

The file is a program, too: ``python checking.py certificate.json``.
"""

from __future__ import annotations

import hashlib
import json
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cached_property, lru_cache
from itertools import groupby, pairwise, zip_longest
from math import gcd, lcm
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

FORMAT = "certificate of a piecewise-linear map"
FIXED_POINTS, DIAGRAM = "fixed points", "diagram"
BYTES, DIGITS, TERMS, LETTERS, ORDER, ATOMS, EDGES = 4_000_000, 400, 20, 60, 32, 20_000, 1_000
DEGREE, BITS = 200, 20_000  # of polynomials that arise

Poly = tuple[int, ...]  # integer coefficients, lowest degree first, the last one is not zero
Quotient = tuple[Poly, Poly]


class Refused(ValueError):  # noqa: N818  it is no error of the program
    """What a certificate says is not proved by it; one sentence says why."""


def refuse(reason: str) -> NoReturn:
    """Raise a refusal."""
    raise Refused(reason)


# --- Polynomials ----------------------------------------------------------------------------------


def trimmed(coefficients: Sequence[int]) -> Poly:
    """Drop leading zeros; refuse what is too large to work with."""
    size = len(coefficients)
    while size and not coefficients[size - 1]:
        size -= 1
    if size > DEGREE or any(c.bit_length() > BITS for c in coefficients):
        refuse("the polynomials that decide become too large to be checked")
    return tuple(coefficients[:size])


def plus(f: Poly, g: Poly, sign: int = 1) -> Poly:
    """The sum, or the difference, of two polynomials."""
    return trimmed([a + sign * b for a, b in zip_longest(f, g, fillvalue=0)])


def times(f: Poly, g: Poly) -> Poly:
    """The product of two polynomials."""
    found = [0] * (len(f) + len(g))
    for i, a in enumerate(f):
        for k, b in enumerate(g):
            found[i + k] += a * b
    return trimmed(found)


@lru_cache(maxsize=4096)
def power(f: Poly, n: int) -> Poly:
    """The n-th power."""
    return times(power(f, n - 1), f) if n else (1,)


def derivative(f: Poly) -> Poly:
    """The derivative."""
    return tuple(n * c for n, c in enumerate(f))[1:]


def primitive(f: Sequence[int]) -> Poly:
    """A polynomial divided by the greatest common divisor of its coefficients."""
    common = gcd(*f) or 1
    return trimmed([c // common for c in f])


def divided(f: Poly, g: Poly) -> tuple[Poly, Poly]:
    """Positive multiples of the quotient and of the remainder of f by g."""
    rest, quotient = list(f), [0] * len(f)
    lead, scale = (1 if g[-1] > 0 else -1), abs(g[-1])
    while len(rest) >= len(g):
        factor, shift = lead * rest[-1], len(rest) - len(g)
        rest, quotient = [scale * c for c in rest], [scale * c for c in quotient]
        quotient[shift] += factor
        for i, c in enumerate(g):
            rest[shift + i] -= factor * c
        rest = list(trimmed(rest))
    return primitive(quotient), primitive(rest)


def sign_of(number: Fraction | int) -> int:
    """-1, 0 or 1."""
    return (number > 0) - (number < 0)


def sign_near(f: Poly, x: Fraction) -> int:
    """The sign of a polynomial at a rational number."""
    value, scale = 0, 1
    for c in reversed(f):
        value = value * x.numerator + c * scale
        scale *= x.denominator
    return sign_of(value)


@lru_cache(maxsize=4096)
def chain(f: Poly, g: Poly) -> tuple[Poly, ...]:
    """The sequence of signed remainders of two polynomials, up to positive factors."""
    found = [f, g]
    while found[-1]:
        rest = divided(found[-2], found[-1])[1]
        found.append(tuple(-c for c in rest))
    return tuple(found[:-1])


@lru_cache(maxsize=4096)
def sturm(f: Poly) -> tuple[Poly, ...]:
    """Sturm's sequence of the polynomial that has each root of another one once."""
    simple = divided(f, chain(f, derivative(f))[-1])[0]
    return chain(simple, derivative(simple))


def changes(signs: Iterator[int]) -> int:
    """How often the sign changes along a sequence, zeros left out."""
    return sum(one != other for one, other in pairwise(filter(None, signs)))


def query(f: Poly, g: Poly, low: Fraction, high: Fraction) -> int:
    """The sum of the signs of g at the roots of f between two numbers that are no roots of f."""
    sequence = chain(f, times(derivative(f), g))
    ends = [changes(sign_near(h, x) for h in sequence) for x in (low, high)]
    return ends[0] - ends[1]


# --- Numbers, and where signs are taken -----------------------------------------------------------


class Number(NamedTuple):
    """A rational number, or the only root of a polynomial in an open interval."""

    poly: Poly
    low: Fraction
    high: Fraction

    def sign(self, f: Poly) -> int:
        """The sign of a polynomial at the number."""
        if self.low == self.high or len(f) < 2:
            return sign_near(f, self.low)
        return query(self.poly, f, self.low, self.high)

    def __str__(self) -> str:
        if self.low == self.high:
            return str(self.low)
        return f"the root of {text(self.poly, 't')} between {self.low} and {self.high}"


class Place:
    """Values of the parameter for which every polynomial that is asked has one sign."""

    def __init__(self, low: Number, high: Number) -> None:
        self.low, self.high = low, high
        self.is_edge = low == high
        self.sample = (low.high + high.low) / 2
        self._known: dict[Poly, int] = {}

    def sign(self, f: Poly) -> int:
        """The sign of a polynomial: at the edge, or all over the open interval."""
        if f not in self._known:
            self._known[f] = self._sign(primitive(f))
        return self._known[f]

    def _sign(self, f: Poly) -> int:
        if self.is_edge or len(f) < 2:
            return self.low.sign(f)
        if self._roots(f):
            refuse(f"{text(f, 'p')} has a root between {self.low} and {self.high}: an edge lacks")
        return sign_near(f, self.sample)

    def _roots(self, f: Poly) -> int:
        """How many roots a polynomial has in the open interval; 0 is sure."""
        sequence, (low, high) = sturm(f), (self.low, self.high)
        outer = [changes(sign_near(h, x) for h in sequence) for x in (low.low, high.high)]
        if outer[0] == outer[1]:
            return 0
        ends = [changes(end.sign(h) for h in sequence) for end in (low, high)]
        return ends[0] - ends[1] - (high.sign(f) == 0)


# --- The map and its iterates ---------------------------------------------------------------------


class Value(NamedTuple):
    """A value of an iterate: a polynomial over a power of the map's denominator."""

    top: Poly
    power: int


class Atom(NamedTuple):
    """An open interval, or a point, whose points visit the same pieces.

    ``left`` and ``right`` are the limits of the iterate at its ends, None where these are infinite,
    or twice the value at the point. A point is the preimage of a break along the first letters of
    its word: ``cut`` holds the index of the break and the number of letters.
    """

    word: str
    left: Value | None
    right: Value | None
    cut: tuple[int, int] | None = None


class Map(NamedTuple):
    """Affine pieces, and which of them each break and each open interval between breaks belongs to.

    Slopes, intercepts and breaks are numerators over one denominator.
    """

    slots: str  # a letter for each interval and each break from left to right, in turn
    slopes: Mapping[str, Poly]
    intercepts: Mapping[str, Poly]
    breaks: tuple[Poly, ...]
    unit: Poly

    def follow(self, value: Value, word: str) -> Value:
        """A value after some more letters."""
        top, n = value
        for letter in word:
            shift = times(self.intercepts[letter], power(self.unit, n))
            top, n = plus(times(self.slopes[letter], top), shift), n + 1
        return Value(top, n)

    def slope(self, word: str) -> Poly:
        """The slope of a word of n letters, over the n-th power of the denominator."""
        found: Poly = (1,)
        for letter in word:
            found = times(found, self.slopes[letter])
        return found

    def offset(self, word: str) -> Value:
        """The value of the affine map of a word at x = 0."""
        return self.follow(Value((), 1), word)

    def over(self, value: Value, k: int) -> Poly:
        """The numerator of a value minus a break."""
        return plus(value.top, times(self.breaks[k], power(self.unit, value.power - 1)), -1)

    def preimage(self, k: int, word: str) -> Quotient:
        """The x that the affine map of a word takes to a break."""
        over = self.over(self.offset(word), k)
        return tuple(-c for c in over), times(self.slope(word), self.unit)

    def fixed(self, word: str) -> Quotient:
        """The x that the affine map of a word takes to itself."""
        return self.offset(word).top, times(self.unit, self.excess(word, -1))

    def excess(self, word: str, unit: int) -> Poly:
        """The numerator of 1 plus a unit, 1 or -1, times the slope of a word."""
        return plus(power(self.unit, len(word)), self.slope(word), unit)

    def ratio(self, value: Value) -> Quotient:
        """A value as a quotient."""
        return value.top, power(self.unit, value.power)


class Fixed(NamedTuple):
    """A fixed point of an iterate that lies in no interval of fixed points."""

    x: Quotient
    slope: Quotient | None  # None where the piece is the point alone
    stable: bool


class Crossing(NamedTuple):
    """A jump with limits strictly on both sides of the diagonal."""

    x: Quotient
    left: Quotient
    right: Quotient


class Band(NamedTuple):
    """An interval of fixed points; an end that is None is infinite."""

    ends: tuple[Quotient | None, Quotient | None]
    closed: tuple[bool, bool]


class Study:
    """An iterate at a place, composed from the map alone, and all that lies on its diagonal."""

    def __init__(self, map_: Map, place: Place, order: int) -> None:
        self.map, self.place, self.order = map_, place, order
        if place.sign(map_.unit) <= 0 or any(
            place.sign(plus(b, a, -1)) <= 0 for a, b in pairwise(map_.breaks)
        ):
            refuse("the denominator of the map must be positive and its breaks ascend")
        self.atoms = [Atom("", None, None)]
        for _ in range(order):
            self.atoms = [new for atom in self.atoms for new in self._split(atom)]
            if len(self.atoms) > ATOMS:
                refuse(f"an iterate has more than {ATOMS} pieces, too many to be checked")

    def sense(self, word: str) -> int:
        """The sign of the slope of a word."""
        found = 1
        for letter in word:
            found *= self.place.sign(self.map.slopes[letter])
        return found

    def _slot(self, value: Value) -> int:
        """The slot that holds a value: 2 k + 1 for break k, even numbers for what lies between."""
        for k in range(len(self.map.breaks)):
            side = self.place.sign(self.map.over(value, k))
            if side <= 0:
                return 2 * k + 1 + side
        return 2 * len(self.map.breaks)

    def _beside(self, value: Value | None, side: int) -> int:
        """The open slot that holds what lies beside a value; None is infinite."""
        if value is None:
            return 0 if side > 0 else 2 * len(self.map.breaks)
        slot = self._slot(value)
        return slot + side * (slot % 2)

    def _split(self, atom: Atom) -> Iterator[Atom]:
        """An atom of the next iterate or, where its image holds breaks, several."""
        map_, word, sense = self.map, atom.word, self.sense(atom.word)

        def new(slot: int, left: Value | None, right: Value | None, cut: Any = None) -> Atom:
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
            right = Value(map_.breaks[(slot + sense) // 2], 1)
            yield new(slot, left, right)
            yield new(slot + sense, right, right, ((slot + sense) // 2, len(word)))
            left = right
        yield new(last, left, atom.right)

    # A piece of the iterate is an interval with those of its ends that have its word.

    def above(self, point: Atom, value: Value) -> Poly:
        """A polynomial with the sign of a value minus the x of a point, but for that of sense."""
        k, steps = point.cut or (0, 0)
        return self.map.over(self.map.follow(value, point.word[:steps]), k)

    def side(self, point: Atom | None, value: Value | None) -> int:
        """The sign of a value minus the x of a point, 0 if there is none."""
        if point is None or value is None:
            return 0
        start = point.word[: (point.cut or (0, 0))[1]]
        return self.sense(start) * self.place.sign(self.above(point, value))

    def x(self, point: Atom) -> Quotient:
        """Where a point is."""
        k, steps = point.cut or (0, 0)
        return self.map.preimage(k, point.word[:steps])

    def slope(self, word: str) -> Quotient:
        """The slope of a word."""
        return self.map.slope(word), power(self.map.unit, len(word))

    def excess(self, word: str, unit: int) -> int:
        """The sign of 1 minus (unit = -1) or plus (unit = 1) the slope of a word."""
        return self.place.sign(self.map.excess(word, unit))

    @cached_property
    def beside(self) -> list[tuple[Atom | None, Atom, Atom | None]]:
        """Each atom with its neighbours."""
        line = [None, *self.atoms, None]
        return [(line[i - 1], a, line[i + 1]) for i, a in enumerate(self.atoms, start=1)]

    @cached_property
    def bands(self) -> dict[str, Band]:
        """All intervals of fixed points, by word."""
        found = {}
        for low, atom, high in self.beside:
            flat = atom.cut is None and not self.excess(atom.word, -1)
            if flat and not self.place.sign(self.map.offset(atom.word).top):
                left, right = (end and self.x(end) for end in (low, high))
                closed = (end is not None and end.word == atom.word for end in (low, high))
                found[atom.word] = Band((left, right), (next(closed), next(closed)))
        return found

    @cached_property
    def fixed(self) -> dict[str, Fixed]:
        """All other fixed points, by word."""
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
                    found[word] = Fixed(self.map.fixed(word), self.slope(word), stable)
        return found

    def _at_point(self, low: Atom | None, atom: Atom, high: Atom | None) -> Fixed:
        """A fixed point with an interval on either side.

        It attracts if the iterate is continuous there, with slopes m and n on both sides such that
        m < 1, n < 1 and m n < 1: a positive slope keeps its side, two negative ones take turns.
        """
        assert low is not None
        assert high is not None
        owned = atom.word in (low.word, high.word)
        stable = not self.side(atom, low.right) and not self.side(atom, high.left)
        slopes = (low.word, high.word, low.word + high.word)
        stable = stable and all(self.excess(word, -1) > 0 for word in slopes)
        return Fixed(self.x(atom), self.slope(atom.word) if owned else None, stable)

    @cached_property
    def crossings(self) -> dict[str, Crossing]:
        """All jumps over the diagonal, by the words on both sides."""
        found = {}
        for low, atom, high in self.beside:
            left, right = low and low.right, high and high.left
            if atom.cut is None or low is None or high is None or left is None or right is None:
                continue
            if self.side(atom, left) * self.side(atom, right) < 0:
                limits = self.map.ratio(left), self.map.ratio(right)
                found[f"{low.word}|{high.word}"] = Crossing(self.x(atom), *limits)
        return found


# --- Reading --------------------------------------------------------------------------------------


def fields(value: object, *names: str) -> list[Any]:
    """The values of an object that has just some names."""
    if not isinstance(value, dict) or set(value) != set(names):
        refuse(f"an object with the names {', '.join(names)} was expected, got {shown(value)}")
    return [value[name] for name in names]


def shown(value: object) -> str:
    """A value in a sentence, not too long."""
    found = canonical(value)
    return found if len(found) < DIGITS else found[: DIGITS - 4] + " ..."


def canonical(value: object) -> str:
    """JSON without a choice."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=True)


def listed(value: object, most: int) -> list[Any]:
    """A list that is not too long."""
    if not isinstance(value, list) or len(value) > most:
        refuse(f"a list of at most {most} entries was expected, got {shown(value)}")
    return value


def whole(value: object, low: int, high: int) -> int:
    """An integer between two others."""
    if type(value) is not int or not low <= value <= high:
        refuse(f"an integer from {low} to {high} was expected, got {shown(value)}")
    return value


def rational(value: object) -> Fraction:
    """A rational number as text, in lowest terms."""
    if not isinstance(value, str) or len(value) > DIGITS:
        refuse(f"a number of at most {DIGITS} characters was expected, got {shown(value)}")
    if not re.fullmatch("-?[0-9]+(/[1-9][0-9]*)?", value) or str(Fraction(value)) != value:
        refuse(f"a rational number in lowest terms was expected, got {shown(value)}")
    return Fraction(value)


def coefficients(value: object, most: int = TERMS) -> list[Fraction]:
    """The coefficients of a polynomial, lowest degree first, the last one not zero."""
    found = [rational(each) for each in listed(value, most)]
    if found and not found[-1]:
        refuse(f"the last coefficient of a polynomial must not be zero, got {shown(value)}")
    return found


def over_one(parts: Sequence[Sequence[Fraction]]) -> tuple[list[Poly], int]:
    """Polynomials times their common denominator, and this."""
    unit = lcm(*(c.denominator for part in parts for c in part))
    return [trimmed([int(c * unit) for c in part]) for part in parts], unit


def quotient(value: object) -> Quotient:
    """A quotient of two polynomials."""
    top, bottom = over_one([coefficients(part, DEGREE) for part in pair(value)])[0]
    if not bottom:
        refuse("the denominator of a quotient must not be zero")
    return top, bottom


def pair(value: object) -> list[Any]:
    """A list of two entries."""
    found = listed(value, 2)
    if len(found) != 2:
        refuse(f"two entries were expected, got {shown(value)}")
    return found


def number(value: object) -> Number:
    """A rational number, or the only root of a polynomial in an open interval."""
    if isinstance(value, str):
        x = rational(value)
        return Number((), x, x)
    polynomial, interval = fields(value, "polynomial", "interval")
    (poly,), unit = over_one([coefficients(polynomial, DEGREE)])
    low, high = map(rational, pair(interval))
    if unit != 1 or len(poly) < 2 or not low < high:
        refuse(f"an integer polynomial and an interval were expected, got {shown(value)}")
    if not sign_near(poly, low) or not sign_near(poly, high) or query(poly, (1,), low, high) != 1:
        refuse(f"{text(poly, 't')} has not just one root between {low} and {high}")
    return Number(poly, low, high)


def text(poly: Sequence[Fraction | int], symbol: str) -> str:
    """A polynomial as text."""
    terms = []
    for n, c in enumerate(poly):
        factors = [str(abs(c))] * (abs(c) != 1 or n == 0)
        factors += [symbol if n == 1 else f"{symbol}^{n}"] * (n > 0)
        terms += [("- " if c < 0 else "+ ") + " ".join(factors)] * (c != 0)
    found = " ".join(terms)
    return found[2:] if found.startswith("+") else found.replace("- ", "-", 1) or "0"


NAME = re.compile(r"[^\W\d]\w{0,39}")


def read_map(value: object, *, parametric: bool) -> tuple[Map, str, str]:
    """A map, the name of its parameter, and the map as text."""
    names = ("variable", "parameter", "slots", "pieces", "breaks", "denominator")
    x, p, slots, pieces, breaks, unit = fields(value, *names)
    for name in (x, p)[: 1 + parametric]:
        if not isinstance(name, str) or not NAME.fullmatch(name):
            refuse(f"the name of a variable was expected, got {shown(name)}")
    if (p is not None) is not parametric or x == p:
        refuse(f"a map {'with a' if parametric else 'without a'} parameter was expected")
    letters = read_slots(slots, len(listed(breaks, LETTERS)))
    lines = [fields(each, "slope", "intercept") for each in fields(pieces, *letters)]
    numbers = [*(each for line in lines for each in line), *breaks, unit]
    parts = [coefficients(each if parametric else [each] * (each != "0")) for each in numbers]
    if not parts[-1]:
        refuse("the denominator of a map must not be zero")
    tops, n = over_one(parts)[0], 2 * len(letters)
    slopes, intercepts = (dict(zip(letters, tops[i:n:2], strict=True)) for i in (0, 1))
    map_ = Map(slots, slopes, intercepts, tuple(tops[n:-1]), tops[-1])
    return map_, p or "", map_text(map_, parts, x, p or "")


def read_slots(slots: object, breaks: int) -> str:
    """The letters of the slots, each once and from left to right."""
    if not isinstance(slots, str) or len(slots) != 2 * breaks + 1:
        refuse(f"one letter for each break and each interval was expected, got {shown(slots)}")
    letters = "".join(letter for letter, _ in groupby(slots))
    if len(set(letters)) < len(letters) or not letters.isprintable() or set(letters) & set(" |"):
        refuse(f"each letter must name one piece of the line, got {shown(slots)}")
    if any(len(set(slots[2 * k : 2 * k + 3])) == 1 for k in range(breaks)):
        refuse(f"pieces must change at each break, got {shown(slots)}")
    return letters


def map_text(map_: Map, parts: Sequence[Sequence[Fraction]], x: str, p: str) -> str:
    """A map as text."""
    below = "" if list(parts[-1]) == [1] else f" / ({text(parts[-1], p)})"
    texts = [f"({t})" if " " in t[1:] else t for t in (text(part, p) for part in parts)]
    breaks = [b + below for b in texts[2 * len(map_.slopes) : -1]]
    pieces = []
    for i, letter in enumerate(map_.slopes):
        first, last = map_.slots.index(letter), map_.slots.rindex(letter)
        lower = f"{breaks[(first - 1) // 2]} {'<=' if first % 2 else '<'} " if first else ""
        inner = last + 1 < len(map_.slots)
        upper = f" {'<=' if last % 2 else '<'} {breaks[last // 2]}" if inner else ""
        is_point = first == last and first % 2
        where = f"{x} = {breaks[first // 2]}" if is_point else lower + x + upper
        terms = [f"{texts[2 * i]} {x}"] * (texts[2 * i] != "0") + [texts[2 * i + 1]]
        line = " + ".join(terms[: 1 if terms[-1] == "0" else 2])
        pieces.append(f"{letter}: {f'({line}){below}' if below else line} for {where}")
    return "the map with the pieces " + "; ".join(pieces)


# --- Statements: all fixed points and jumps over the diagonal of an iterate -----------------------


def count(n: int, what: str) -> str:
    """A number of things in words; the first noun takes the plural."""
    plural = re.sub("(interval|point|jump|stretch)", r"\1s", what, count=1)
    return f"{n or 'no'} {what if n == 1 else plural}".replace("stretchs", "stretches")


def rational_text(value: Quotient | None) -> str | None:
    """A quotient of constants as text, None if it is None."""
    if value is None:
        return None
    top, bottom = value
    return str(Fraction(*(part[0] if part else 0 for part in (top, bottom))))


def period(word: str) -> int:
    """How many letters the shortest word has of which this one is a power."""
    n = len(word)
    return next(d for d in range(1, n + 1) if n % d == 0 and word[:d] * (n // d) == word)


def claims_of(study: Study) -> dict[str, list[dict[str, Any]]]:
    """All that lies on the diagonal of an iterate of a map without a parameter."""
    fixed = [
        {"word": word, "x": rational_text(each.x), "slope": rational_text(each.slope),
         "period": period(word), "stable": each.stable}
        for word, each in study.fixed.items()
    ]  # fmt: skip
    bands = [
        {"word": word, "ends": list(map(rational_text, each.ends)), "closed": list(each.closed)}
        for word, each in study.bands.items()
    ]
    crossings = [
        {"word": word, "x": rational_text(each.x), "left": rational_text(each.left),
         "right": rational_text(each.right)}
        for word, each in study.crossings.items()
    ]  # fmt: skip
    return {"fixed points": fixed, "intervals": bands, "crossings": crossings}


def fixed_points_statement(certificate: Mapping[str, Any]) -> str:
    """Verify that lists are those of an iterate; the sentence that says so."""
    map_, _, name = read_map(certificate["map"], parametric=False)
    order = whole(certificate["order"], 1, ORDER)
    zero = Number((), Fraction(0), Fraction(0))
    found = claims_of(Study(map_, Place(zero, zero), order))
    for key, rows in found.items():
        if canonical(certificate[key]) != canonical(rows):
            refuse(f"the {key} of P_{order} are {shown(rows)}, not {shown(certificate[key])}")
    fixed, bands, crossings = found.values()
    points = [
        f"{row['x']} (word {row['word']}, slope {row['slope'] or 'none'}, "
        f"{'' if row['stable'] else 'not '}attracting)" for row in fixed
    ]  # fmt: skip
    jumps = [
        f"{row['x']} (from {row['left']} to {row['right']}, words {row['word']})"
        for row in crossings
    ]
    spans = [
        f"{'(['[row['closed'][0]]}{row['ends'][0] or '-oo'}, {row['ends'][1] or 'oo'}"
        f"{')]'[row['closed'][1]]} (word {row['word']})" for row in bands
    ]  # fmt: skip
    parts = {
        "interval of fixed points": spans,
        "fixed point in no such interval": points,
        "jump whose limits lie strictly on both sides of the diagonal": jumps,
    }
    lists = "; ".join(
        ": ".join(filter(None, (count(len(rows), what), ", ".join(rows))))
        for what, rows in parts.items()
    )
    return f"For {name}, the iterate P_{order} has exactly {lists}."


# --- Statements: branches and special points over a parameter -------------------------------------


class Stretch(NamedTuple):
    """A claim that something exists from one place to another.

    Place 2 i is the i-th edge, place 2 i + 1 the open interval from it to the next.
    """

    kind: str
    order: int
    word: str
    first: int
    last: int
    quotients: Mapping[str, Quotient | None]
    stable: bool

    def at(self, place: int) -> bool:
        """Whether it exists at a place."""
        return self.first <= place <= self.last

    def is_inner(self, place: int) -> bool:
        """Whether a place that it has is no end of it, or all of it."""
        return place % 2 == 1 or self.first == self.last or self.first < place < self.last


KINDS = {"fixed points": ("x", "slope"), "intervals": (), "crossings": ("x", "left", "right")}


def read_stretches(
    certificate: Mapping[str, Any], orders: Sequence[int], last: int
) -> list[Stretch]:
    """All claims of a diagram that something exists."""
    found = []
    for kind, names in KINDS.items():
        more = ("stable",) if kind == "fixed points" else ()
        for row in listed(certificate[kind], EDGES):
            order, word, places, *rest = fields(row, "order", "word", "places", *names, *more)
            first, stop = (whole(each, 0, last) for each in pair(places))
            if whole(order, 1, ORDER) not in orders or not isinstance(word, str) or first > stop:
                refuse(f"one of the orders, a word and two places were expected, got {shown(row)}")
            values = {
                name: None if name == "slope" and value is None else quotient(value)
                for name, value in zip(names, rest, strict=False)
            }
            if more and type(rest[-1]) is not bool:
                refuse(f"true or false was expected, got {shown(rest[-1])}")
            found.append(Stretch(kind, order, word, first, stop, values, rest[-1:] == [True]))
    if len({stretch[:5] for stretch in found}) < len(found):
        refuse("a stretch is listed twice")
    return found


class Diagram:
    """The claims of a diagram, the places they speak of, and the iterates there."""

    def __init__(self, certificate: Mapping[str, Any]) -> None:
        self.map, self.name, self.map_text = read_map(certificate["map"], parametric=True)
        self.orders = [whole(n, 1, ORDER) for n in listed(certificate["orders"], ORDER)]
        if not self.orders or self.orders != sorted({d for n in self.orders for d in divisors(n)}):
            refuse(f"orders must ascend, with all divisors, got {shown(self.orders)}")
        self.edges = [number(each) for each in listed(certificate["edges"], EDGES)]
        if len(self.edges) < 2:
            refuse("at least two edges were expected")
        for low, high in pairwise(self.edges):
            if not (low.high <= high.low and (low.high, low.low) != (high.low, high.high)):
                refuse(f"edges must ascend and have disjoint intervals, got {low} and {high}")
        self.last = 2 * len(self.edges) - 2
        self.stretches = read_stretches(certificate, self.orders, self.last)
        self.places = [
            Place(self.edges[i // 2], self.edges[(i + 1) // 2]) for i in range(self.last + 1)
        ]
        self._studies: dict[tuple[int, int], Study] = {}

    def study(self, place: int, order: int) -> Study:
        """An iterate at a place."""
        if (place, order) not in self._studies:
            self._studies[place, order] = Study(self.map, self.places[place], order)
        return self._studies[place, order]

    def verify(self) -> None:
        """Whether everything claimed exists and, but for the first and last edge, nothing else."""
        for i in range(self.last + 1):
            for n in self.orders:
                own = [s for s in self.stretches if s.order == n and s.at(i)]
                if own or 0 < i < self.last:
                    self._verify_at(i, n, own)

    def _verify_at(self, i: int, n: int, own: Sequence[Stretch]) -> None:
        found = own_parts(self.study(i, n))
        for kind, items in found.items():
            words = [s.word for s in own if s.kind == kind]
            lacking, excess = set(items) - set(words), set(words) - set(items)
            if excess or (lacking and 0 < i < self.last) or (i % 2 and len(words) > len(items)):
                refuse(f"P_{n} has the {kind} {sorted(items)} {self.where(i)}, not {sorted(words)}")
        for s in own:
            self._verify_values(s, i, found[s.kind][s.word])

    def _verify_values(self, s: Stretch, i: int, found: Any) -> None:
        for name, value in s.quotients.items():
            true = getattr(found, name)
            counts = name != "slope" or i % 2 or s.first == s.last
            if counts and not self.equal(value, true, i):
                refuse(f"{name} of {s.word} is another one {self.where(i)}")
        if s.kind == "fixed points" and s.is_inner(i) and s.stable is not found.stable:
            refuse(f"{s.word} is {'not ' * s.stable}attracting {self.where(i)}")

    def equal(self, one: Quotient | None, other: Quotient | None, i: int) -> bool:
        """Whether two quotients have the same finite value at a place."""
        if one is None or other is None:
            return one is other
        sign = self.places[i].sign
        difference = plus(times(one[0], other[1]), times(other[0], one[1]), -1)
        return sign(difference) == 0 and sign(one[1]) != 0 and sign(other[1]) != 0

    def found(self, i: int, n: int, kind: str) -> dict[str, Any]:
        """What there is of a kind and of an order at a place; nothing for orders not looked at."""
        return own_parts(self.study(i, n))[kind] if n in self.orders else {}

    def ends(self, edge: int) -> Iterator[End]:
        """The ends of fixed points and jumps at an edge."""
        for s in self.stretches:
            if s.kind != "intervals" and s.first == s.last == 2 * edge:
                yield End(s, 0)
            elif s.kind != "intervals":
                if s.first in (2 * edge, 2 * edge + 1):
                    yield End(s, 1)
                if s.last in (2 * edge, 2 * edge - 1):
                    yield End(s, -1)

    def is_at(self, end: End, edge: int, x: Number | int) -> bool:
        """Whether the x of a stretch tends to a number, or to infinity on a side -1 or 1."""
        top, bottom = end.stretch.quotients["x"] or ((), ())
        sign = self.places[2 * edge].sign
        if not sign(bottom):
            side = sign(top) * self.places[2 * edge + end.side].sign(bottom)
            return side == x or (not side and refuse("a quotient is not in lowest terms"))
        if isinstance(x, int):
            return False
        sides = [
            sign(bottom)
            * sign(plus(times((bound.denominator,), top), times((bound.numerator,), bottom), -1))
            for bound in (x.low, x.high)
        ]
        if x.low == x.high:
            return sides == [0, 0]
        value: Poly = ()
        degree = len(x.poly) - 1
        for i, c in enumerate(x.poly):
            value = plus(value, times((c,), times(power(top, i), power(bottom, degree - i))))
        return sides == [1, -1] and sign(value) == 0

    def where(self, i: int) -> str:
        """A place in words."""
        low, high = self.edges[i // 2], self.edges[(i + 1) // 2]
        if i % 2:
            return f"for {self.name} between {low} and {high}"
        return f"at {self.name} = {low}"


def divisors(n: int) -> list[int]:
    """All divisors of a number."""
    return [d for d in range(1, n + 1) if n % d == 0]


def own_parts(study: Study) -> dict[str, dict[str, Any]]:
    """What lies on the diagonal and belongs to no smaller iterate; all jumps."""
    n = study.order

    def is_own(word: str) -> bool:
        half = study.sense(word[: n // 2]) < 0 and 2 * period(word) == n
        return period(word) == n or (half and word in study.bands)

    return {
        "fixed points": {word: each for word, each in study.fixed.items() if is_own(word)},
        "intervals": {word: each for word, each in study.bands.items() if is_own(word)},
        "crossings": dict(study.crossings),
    }


class End(NamedTuple):
    """One end of a stretch, and on which side of it the stretch lies, 0 if along one value."""

    stretch: Stretch
    side: int

    @property
    def is_fixed(self) -> bool:
        """Whether fixed points end."""
        return self.stretch.kind == "fixed points"

    @property
    def name(self) -> tuple[int, str, int]:
        """What tells it from all others of fixed points at one edge."""
        return self.stretch.order, self.stretch.word, self.side


class Point:
    """All that ends at one edge and one x, and what kind of special point that is.

    With n the least order of the fixed points that end there, only ends of that order count.
    """

    def __init__(self, diagram: Diagram, edge: int, ends: Sequence[End], *, infinite: bool) -> None:
        self.diagram, self.edge, self.infinite = diagram, edge, infinite
        self.place = diagram.places[2 * edge]
        self.order = min(end.stretch.order for end in ends if end.is_fixed)
        self.own = [end for end in ends if end.stretch.order == self.order]
        self.fixed = [end for end in self.own if end.is_fixed]
        self.beside = [end for end in self.own if end.side]

    def claims(self) -> dict[str, Any]:
        """Kind, note, the conditions that vanish, and the signs that make a fold."""
        code, note = self._kind()
        conditions = [self._condition(end, code) for end in self.fixed if end.side]
        signs = self._signs() if code in ("BC", "FF") else None
        if signs is not None and (note == "fold") is not (signs[0] * signs[1] == -signs[2]):
            refuse(f"the signs {signs} do not make a {note} {self.diagram.where(2 * self.edge)}")
        return {"code": code, "note": note, "conditions": conditions, "signs": signs}

    def _unit(self, word: str) -> int:
        """1 or -1 where the slope of a word, which is not constant, has that value, otherwise 0."""
        map_ = self.diagram.map
        for unit in (1, -1):
            excess = map_.excess(word, -unit)
            if excess and self.place.sign(excess) == 0:
                return unit
        return 0

    def _kind(self) -> tuple[str, str]:
        units = {self._unit(end.stretch.word) for end in self.fixed}
        if self.infinite:
            if units != {1}:
                refuse(f"x has no bound without a slope 1 {self.diagram.where(2 * self.edge)}")
            return "LP", "x grows without bound"
        left, right = ({e.stretch.word for e in self.fixed if e.side == s} for s in (-1, 1))
        passing = left & right
        units = {self._unit(word) for word in passing}
        if -1 in units:
            words = self.diagram.found(2 * self.edge, 2 * self.order, "intervals")
            doubled = any(2 * word in words for word in passing)
            return "PD", "degenerate: points nearby have twice the period" * doubled
        if 1 in units:
            return "LP", "degenerate: an interval of fixed points"
        if any(e.stretch.word in passing and e.stretch.at(2 * self.edge) for e in self.fixed):
            refuse(f"a branch passes a border {self.diagram.where(2 * self.edge)}: not certified")
        if len({end.side for end in self.beside}) != 1:
            alone = all(not end.side for end in self.fixed)
            return "BC", "isolated" if alone else "persistence"
        folding = [end for end in self.fixed if end.side]
        jumps = any(not end.is_fixed for end in self.own)
        steep = len(folding) == 1 and jumps and self._is_steep(folding[0])
        return ("FF" if steep else "BC"), "fold"

    def _study(self, end: End) -> Study:
        """The iterate in the interval on which an end lies."""
        return self.diagram.study(2 * self.edge + end.side, self.order)

    def _is_steep(self, end: End) -> bool:
        """Whether the slope is larger than 1 in size, in the interval on which an end lies."""
        study, word = self._study(end), end.stretch.word
        slope = end.stretch.quotients["slope"]
        return slope is not None and study.excess(word, 1) * study.excess(word, -1) < 0

    def _condition(self, end: End, code: str) -> dict[str, Any]:
        """What vanishes where a stretch of fixed points ends, and whether its zero is simple."""
        word = end.stretch.word
        if code in ("LP", "PD"):
            polynomials = [self.diagram.map.excess(word, 1 if code == "PD" else -1)]
        else:
            study = self._study(end)
            rows = [row for row in study.beside if row[1].word == word and row[1].cut is None]
            polynomials = [
                study.above(border, value)
                for low, atom, high in rows
                for border, value in ((low, atom.left), (high, atom.right))
                if border is not None and value is not None
            ]
        sign = self.place.sign
        vanishing = [primitive(f) for f in polynomials if f and sign(f) == 0]
        simple = [sign(derivative(f)) != 0 for f in vanishing]
        vanishing_text = [[str(c) for c in f] for f in vanishing]
        return {"word": word, "side": end.side, "vanishing": vanishing_text, "simple": simple}

    def _signs(self) -> list[int] | None:
        """Of a branch x and a jump of its iterate that end together: the signs of fold-or-not.

        These are the side of the border on which the branch lies, 1 minus its slope, and the other
        limit minus x. None if other branches end there too, or a sign is zero.
        """
        kinds = [end.is_fixed for end in self.beside]
        if sorted(kinds) != [False, True] or len(self.own) > 2:
            return None
        stretch = self.beside[kinds.index(True)].stretch
        words = self.beside[kinds.index(False)].stretch.word
        study = self.diagram.study(2 * self.edge, self.order)
        for low, atom, high in study.beside:
            if atom.cut is None or low is None or high is None:
                continue
            if f"{low.word}|{high.word}" == words and stretch.word in words.split("|"):
                side = 1 if high.word == stretch.word else -1
                jump = study.side(atom, low.right if side > 0 else high.left)
                signs = [side, study.excess(stretch.word, -1), jump]
                return signs if all(signs) else None
        return None


def verified_points(diagram: Diagram, rows: Sequence[object]) -> list[str]:
    """Verify the special points; texts that name them.

    Every end of fixed points inside must be that of one of them.
    """
    inner = range(1, len(diagram.edges) - 1)
    left = {(i, end.name) for i in inner for end in diagram.ends(i) if end.is_fixed}
    texts = []
    for row in rows:
        names = ("edge", "x", "code", "note", "conditions", "signs")
        edge, at, *claims = fields(row, *names)
        i = whole(edge, 1, len(diagram.edges) - 2)
        side = {"oo": 1, "-oo": -1}.get(at) if isinstance(at, str) else None
        x = side or number(at)
        ends = [end for end in diagram.ends(i) if diagram.is_at(end, i, x)]
        fixed = {(i, end.name) for end in ends if end.is_fixed}
        where = f"{diagram.where(2 * i)} and x = {at if side else x}"
        if not fixed or not fixed <= left:
            refuse(f"no fixed points end {where}, or they are listed twice")
        left -= fixed
        true = Point(diagram, i, ends, infinite=side is not None).claims()
        if canonical(true) != canonical(dict(zip(names[2:], claims, strict=True))):
            refuse(f"the special point {where} is {shown(true)}, not {shown(row)}")
        simple = all(all(condition["simple"]) for condition in true["conditions"])
        words = f"{true['code']}, {true['note']}," if true["note"] else true["code"]
        texts.append(f"{words} {where}{'' if simple else ' (a zero that is not simple)'}")
    if left:
        i, name = min(left)
        refuse(f"fixed points {name[1]} end {diagram.where(2 * i)}, but no point is listed there")
    return texts


def diagram_statement(certificate: Mapping[str, Any]) -> str:
    """Verify branches and special points over a parameter; the sentence that says so."""
    diagram = Diagram(certificate)
    diagram.verify()
    texts = verified_points(diagram, listed(certificate["points"], EDGES))
    rows = {
        kind: count(sum(s.kind == kind for s in diagram.stretches), "stretch") for kind in KINDS
    }
    orders = ", ".join(map(str, diagram.orders))
    points = f"only at {count(len(texts), 'special point')}: {'; '.join(texts)}"
    return (
        f"For {diagram.map_text} and every {diagram.name} strictly between {diagram.edges[0]} and "
        f"{diagram.edges[-1]}, what the iterates P_j with j = {orders} have on the diagonal is "
        f"just what is listed: on {rows['fixed points']} fixed points of least period j, with "
        f"their x, slope and stability, on {rows['intervals']} intervals of such points, and on "
        f"{rows['crossings']} jumps whose limits lie strictly on both sides of the diagonal, with "
        f"both limits; inside, fixed points begin and end {points if texts else 'nowhere'}."
    )


# --- Certificates ---------------------------------------------------------------------------------

HEAD = ("format", "version", "kind", "statement", "seal", "map")
STATEMENTS: Mapping[str, tuple[Callable[[Mapping[str, Any]], str], tuple[str, ...]]] = {
    FIXED_POINTS: (fixed_points_statement, ("order", *KINDS)),
    DIAGRAM: (diagram_statement, ("orders", "edges", *KINDS, "points")),
}


def seal_of(certificate: Mapping[str, Any]) -> str:
    """The digest of all but the seal."""
    rest = {name: value for name, value in certificate.items() if name != "seal"}
    return hashlib.sha256(canonical(rest).encode("ascii")).hexdigest()


def statement_of(certificate: object) -> str:
    """What a certificate proves, in one sentence; its own sentence and seal are not looked at.

    Raises
    ------
    Refused
        If it proves nothing.
    """
    if not isinstance(certificate, dict) or certificate.get("format") != FORMAT:
        refuse(f"this is no {FORMAT}")
    kind = certificate.get("kind")
    if type(certificate.get("version")) is not int or certificate["version"] != 1:
        refuse(f"version 1 was expected, got {shown(certificate.get('version'))}")
    if not isinstance(kind, str) or kind not in STATEMENTS:
        refuse(f"the kind must be one of {', '.join(STATEMENTS)}, got {shown(kind)}")
    verify, names = STATEMENTS[kind]
    fields(certificate, *HEAD, *names)
    return verify(certificate)


def check(certificate: object) -> str:
    """Verify a certificate; the same as :func:`check_certificate`, of what the file holds."""
    if not isinstance(certificate, dict) or certificate.get("seal") != seal_of(certificate):
        refuse("the seal is not that of the content")
    statement = statement_of(certificate)
    if certificate["statement"] != statement:
        refuse(f"the statement must be: {statement}")
    return statement


def read(path: str | Path) -> object:
    """What a file of JSON holds; no name twice, no numbers but integers."""

    def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        if len(dict(pairs)) < len(pairs):
            refuse("a name occurs twice")
        return dict(pairs)

    def none(found: str) -> NoReturn:
        refuse(f"numbers must be integers or text, got {found[:DIGITS]}")

    try:
        with Path(path).open("rb") as file:
            data = file.read(BYTES + 1)
    except (OSError, ValueError) as error:
        refuse(f"cannot read the file: {error}")
    if len(data) > BYTES:
        refuse(f"a certificate of at most {BYTES} bytes was expected")
    try:
        return json.loads(
            data.decode("utf-8"), object_pairs_hook=unique, parse_float=none, parse_constant=none
        )
    except (ValueError, RecursionError) as error:
        if isinstance(error, Refused):
            raise
        refuse(f"this is no JSON: {error}")


def check_certificate(path: str | Path) -> str:
    """Verify a certificate from nothing but its file, and state what it proves.

    Parameters
    ----------
    path
        A file that :func:`pwmap.prove` wrote.

    Returns
    -------
    The verified statement, one sentence, composed from what was verified.

    Raises
    ------
    Refused
        If anything in the file is not as it must be; one sentence says what.

    Examples
    --------
    >>> check_certificate("certificate.json")  # doctest: +SKIP
    'For the map with the pieces L: ...'
    """
    return check(read(path))


if __name__ == "__main__":
    try:
        for name in sys.argv[1:]:
            sys.stdout.write(f"{name}: {check_certificate(name)}\n")
    except Refused as refusal:
        sys.exit(f"refused: {refusal}")
