"""Claims on branches over a parameter, verified at every place of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from pwmap.checking.iterates import Study
from pwmap.checking.lists import period
from pwmap.checking.places import Number, Place
from pwmap.checking.polynomials import Poly, Quotient, plus, power, sign_near, times
from pwmap.checking.reading import fields, listed, number, pair, quotient, read_map, shown, whole
from pwmap.checking.refusing import ORDER, ROWS, Work, refuse


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


class End(NamedTuple):
    """One end of a stretch, and on which side of it the stretch lies, 0 if along one value."""

    stretch: Stretch
    side: int

    @property
    def is_fixed(self) -> bool:
        """Whether fixed points end."""
        return self.stretch.kind == "fixed points"

    @property
    def is_jump(self) -> bool:
        """Whether a jump ends."""
        return self.stretch.kind == "crossings"

    @property
    def is_band(self) -> bool:
        """Whether it is an interval of fixed points at one value of the parameter."""
        return self.stretch.kind == "intervals"

    @property
    def name(self) -> tuple[int, str, int]:
        """What tells it from all others of fixed points at one edge."""
        return self.stretch.order, self.stretch.word, self.side


KINDS = {"fixed points": ("x", "slope"), "intervals": (), "crossings": ("x", "left", "right")}


def read_stretches(
    certificate: Mapping[str, Any], orders: Sequence[int], last: int
) -> list[Stretch]:
    """All claims of a diagram that something exists."""
    found = []
    for kind, names in KINDS.items():
        more = ("stable",) if kind == "fixed points" else ()
        for row in listed(certificate[kind], ROWS):
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
        self.work = work = Work()
        self.map, self.name, self.map_text = read_map(certificate["map"], parametric=True)
        self.orders = [whole(n, 1, ORDER) for n in listed(certificate["orders"], ORDER)]
        if not self.orders or self.orders != sorted({d for n in self.orders for d in divisors(n)}):
            refuse(f"orders must ascend, with all divisors, got {shown(self.orders)}")
        self.edges = [number(each, work) for each in listed(certificate["edges"], ROWS)]
        if len(self.edges) < 2:
            refuse("at least two edges were expected")
        self.last = 2 * len(self.edges) - 2
        self.places = [
            Place(self.edges[i // 2], self.edges[(i + 1) // 2], work) for i in range(self.last + 1)
        ]
        self.stretches = read_stretches(certificate, self.orders, self.last)
        self._studies: dict[tuple[int, int], Study] = {}

    def study(self, place: int, order: int) -> Study:
        """An iterate at a place."""
        if (place, order) not in self._studies:
            self._studies[place, order] = Study(self.map, self.places[place], order)
        return self._studies[place, order]

    def verify(self) -> None:
        """Whether everything claimed exists and, but for the first and last edge, nothing else."""
        for n in self.orders:
            stretches = [s for s in self.stretches if s.order == n]
            for i in range(self.last + 1):
                own = [s for s in stretches if s.at(i)]
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
        """What there is of a kind and of an order at a place."""
        return own_parts(self.study(i, n))[kind]

    def ends(self, edge: int) -> Iterator[End]:
        """What ends at an edge, or exists nowhere else."""
        for s in self.stretches:
            if s.first == s.last == 2 * edge:
                yield End(s, 0)
            elif s.kind != "intervals":
                if s.first in (2 * edge, 2 * edge + 1):
                    yield End(s, 1)
                if s.last in (2 * edge, 2 * edge - 1):
                    yield End(s, -1)

    def is_at(self, end: End, edge: int, x: Number | int) -> bool:
        """Whether an end, or part of an interval, is at a number, or at infinity: -1 or 1."""
        if end.is_band:
            band = self.study(2 * edge, end.stretch.order).bands[end.stretch.word]
            left, right = band.ends
            if not isinstance(x, Number):
                return (left if x < 0 else right) is None
            return (left is None or self.compare(left, edge, x) <= 0) and (
                right is None or self.compare(right, edge, x) >= 0
            )
        quotient = end.stretch.quotients["x"]
        assert quotient is not None
        top, bottom = quotient
        sign = self.places[2 * edge].sign
        if sign(bottom):
            return isinstance(x, Number) and self.compare(quotient, edge, x) == 0
        side = sign(top) * self.places[2 * edge + end.side].sign(bottom)
        return side == x or (not side and refuse("a quotient is not in lowest terms"))

    def compare(self, quotient: Quotient, edge: int, x: Number) -> int:
        """The sign of a finite quotient at an edge minus a number."""
        (top, bottom), sign = quotient, self.places[2 * edge].sign
        low, high = (
            sign(bottom)
            * sign(plus(times((end.denominator,), top), times((end.numerator,), bottom), -1))
            for end in (x.low, x.high)
        )
        if x.low == x.high or low <= 0 or high >= 0:
            return low if x.low == x.high else -1 if low <= 0 else 1
        value: Poly = ()
        degree = len(x.poly) - 1
        for i, c in enumerate(x.poly):
            value = plus(value, times((c,), times(power(top, i), power(bottom, degree - i))))
        unit = sign(bottom) if degree % 2 else 1
        return sign(value) * unit * sign_near(x.poly, x.high)

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
