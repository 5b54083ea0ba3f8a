"""Claims on branches over a parameter, verified at all its places: edges and gaps between."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cache
from itertools import pairwise
from typing import Any, NamedTuple

from pwmap.checking.iterates import CheckedIterate, DiagonalObject
from pwmap.checking.lists import period
from pwmap.checking.polynomials import Number, Place, Poly, Quotient, plus, sign_near, times
from pwmap.checking.reading import fields, listed, number, pair, quotient, read_map, shown, whole
from pwmap.checking.refusing import ORDER, ROWS, STEP, Effort, refuse


class ClaimedStretch(NamedTuple):
    """A claim that something exists between two places: edge i is 2 i, the gap after it 2 i + 1."""

    kind: str
    order: int
    word: str
    first: int
    last: int
    quotients: Mapping[str, Quotient | None]
    stable: bool

    @property
    def thing(self) -> tuple[str, int, str]:
        """What is claimed to exist: kind, order and word."""
        return self[:3]

    def at(self, place: int) -> bool:
        """Whether it is claimed to exist at a place."""
        return self.first <= place <= self.last

    def goes_on_as(self, other: ClaimedStretch) -> bool:
        """Whether a following stretch claims the same, so that both must be one."""
        slopes = [each.quotients.get("slope") is None for each in (self, other)]
        return self.stable is other.stable and slopes[0] is slopes[1]


class ClaimedEnd(NamedTuple):
    """A stretch that ends at an edge, and on which side it lies: 0 if it exists at the edge alone.

    A fixed point that ``passes`` exists on both sides and at the edge, with the same stability.
    """

    stretch: ClaimedStretch
    side: int
    passes: bool = False

    @property
    def kind(self) -> str:
        """The kind of the stretch."""
        return self.stretch.kind

    @property
    def name(self) -> tuple[int, str, int]:
        """Order, word and side, which identify an end of fixed points at an edge."""
        return self.stretch.order, self.stretch.word, self.side


FIXED, BANDS, JUMPS = "fixed points", "intervals", "crossings"
KINDS = {FIXED: ("x", "slope"), BANDS: (), JUMPS: ("x", "left", "right")}


def read_stretches(
    certificate: Mapping[str, Any], orders: Sequence[int], last: int, work: Effort
) -> list[ClaimedStretch]:
    """All stretches that a diagram claims."""
    found = []
    for kind, names in KINDS.items():
        more = ("stable",) if kind == FIXED else ()
        for row in listed(certificate[kind], ROWS):
            order, word, places, *rest = fields(row, "order", "word", "places", *names, *more)
            first, stop = (whole(each, 0, last) for each in pair(places))
            if whole(order, 1, ORDER) not in orders or not isinstance(word, str) or first > stop:
                refuse(f"one of the orders, a word and two places were expected, got {shown(row)}")
            values = {
                name: None if name == "slope" and value is None else quotient(value, work)
                for name, value in zip(names, rest, strict=False)
            }
            if more and type(rest[-1]) is not bool:
                refuse(f"true or false was expected, got {shown(rest[-1])}")
            found.append(
                ClaimedStretch(kind, order, word, first, stop, values, rest[-1:] == [True])
            )
    return found


class ClaimedDiagram:
    """The claims of a diagram, the places that they are about, and the iterates there."""

    def __init__(self, certificate: Mapping[str, Any]) -> None:
        self.work = work = Effort()
        self.map, self.name, self.map_text = read_map(certificate["map"], work, parametric=True)
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
        self.stretches = read_stretches(certificate, self.orders, self.last, work)
        self._things: dict[tuple[str, int, str], list[ClaimedStretch]] = {}
        for stretch in self.stretches:
            self._things.setdefault(stretch.thing, []).append(stretch)
        self.study = cache(lambda i, n: CheckedIterate(self.map, self.places[i], n))
        self.ends = cache(self._all_ends)
        # what is on the diagonal at a place, and of an order: by kind, then by word
        self.found = cache(lambda i, n: objects_of_least_order(self.study(i, n)))

    def verify(self) -> None:
        """Refuse unless all that is claimed exists and, strictly inside the span, nothing else."""
        for same in self._things.values():
            for one, other in pairwise(sorted(same, key=lambda s: s.first)):
                if other.first <= one.last:
                    refuse(f"two stretches of {one.word} overlap {self.where(other.first)}")
                # a stretch ends only where its object changes, so that the list is unique
                if other.first == one.last + 1 and one.goes_on_as(other):
                    where = self.where(other.first)
                    refuse(f"two stretches of {one.word} must be one, nothing changes {where}")
        for n in self.orders:
            stretches = [s for s in self.stretches if s.order == n]
            for i in range(self.last + 1):
                self.work.spend(STEP * (1 + len(stretches)))
                own = [s for s in stretches if s.at(i)]
                if own or 0 < i < self.last:
                    self._verify_at(i, n, own)

    def _verify_at(self, i: int, n: int, own: Sequence[ClaimedStretch]) -> None:
        found = self.found(i, n)
        for kind, items in found.items():
            words = [s.word for s in own if s.kind == kind]
            lacking, excess = set(items) - set(words), set(words) - set(items)
            if excess or (lacking and 0 < i < self.last):
                true, listed_ = shown(sorted(items)), shown(sorted(words))
                refuse(f"P_{n} has the {kind} {true} {self.where(i)}, not {listed_}")
        for s in own:
            self._verify_values(s, i, found[s.kind][s.word])

    def _verify_values(self, s: ClaimedStretch, i: int, found: DiagonalObject) -> None:
        for name, value in s.quotients.items():
            if not self.equal(value, found.quotients[name], i):
                refuse(f"{name} of {s.word} is another one {self.where(i)}")
        if s.kind == FIXED and s.stable is not found.stable:
            refuse(f"{s.word} is {'not ' * s.stable}attracting {self.where(i)}")

    def equal(self, one: Quotient | None, other: Quotient | None, i: int) -> bool:
        """Whether two quotients have the same finite value at a place, or are both None."""
        if one is None or other is None:
            return one is other
        sign = self.places[i].sign
        work = self.work
        products = times(work, one[0], other[1]), times(work, other[0], one[1])
        difference = plus(work, *products, -1)
        return sign(difference) == 0 and sign(one[1]) != 0 and sign(other[1]) != 0

    def _all_ends(self, edge: int) -> list[ClaimedEnd]:
        """All ends at an edge, with passing fixed points on which others may end."""
        self.work.spend(5 * STEP * len(self.stretches))
        ends = [end for same in self._things.values() for end in ends_of(same, edge)]
        return [end for end in ends if not end.passes or self._is_bent(end, edge)]

    def _is_bent(self, end: ClaimedEnd, edge: int) -> bool:
        """Whether a passing fixed point is at a border or has slope -1, so that others may end."""
        _, order, word = end.stretch.thing
        there = self.found(2 * edge, order)[FIXED].get(word)
        return there is None or there.at_border or self.study(2 * edge, order).excess(word, 1) == 0

    def is_at(self, end: ClaimedEnd, edge: int, x: Number | int) -> bool:
        """Whether an end, or a point of an interval, lies at a number or at infinity (-1 or 1)."""
        if end.kind == BANDS:
            band = self.study(2 * edge, end.stretch.order).bands[end.stretch.word]
            left, right = band.quotients.values()
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
        (top, bottom), sign, work = quotient, self.places[2 * edge].sign, self.work

        def above(x: Fraction) -> int:
            """The sign of the quotient minus a rational number."""
            over = times(work, (x.denominator,), top), times(work, (x.numerator,), bottom)
            return sign(bottom) * sign(plus(work, *over, -1))

        low, high = above(x.low), above(x.high)
        if not x.is_root or low <= 0 or high >= 0:
            return low if not x.is_root else -1 if low <= 0 else 1
        value: Poly = ()  # of the polynomial at the quotient, by Horner's rule
        scale: Poly = (1,)
        for c in reversed(x.poly):
            value = plus(work, times(work, value, top), times(work, (c,), scale))
            scale = times(work, scale, bottom)
        unit = sign(bottom) if len(x.poly) % 2 == 0 else 1
        return sign(value) * unit * sign_near(work, x.poly, x.high)

    def where(self, i: int) -> str:
        """A place in words, for messages."""
        low, high = self.edges[i // 2].brief, self.edges[(i + 1) // 2].brief
        if i % 2:
            return f"for {self.name} between {low} and {high}"
        return f"at {self.name} = {low}"


def ends_of(same: Sequence[ClaimedStretch], edge: int) -> Iterator[ClaimedEnd]:
    """Yield the ends at an edge of the stretches of one object."""
    before, here, after = (next((s for s in same if s.at(2 * edge + k)), None) for k in (-1, 0, 1))
    beside = [(s, side) for s, side in ((before, -1), (after, 1)) if s is not None]
    goes_on = here is not None and len(beside) == 2
    if here is not None and not beside:
        yield ClaimedEnd(here, 0)
    elif same[0].kind == FIXED or (same[0].kind == JUMPS and not goes_on):
        stable = {s.stable for s in (before, here, after) if s is not None}
        yield from (ClaimedEnd(s, side, goes_on and len(stable) == 1) for s, side in beside)


def divisors(n: int) -> list[int]:
    """All divisors of a number."""
    return [d for d in range(1, n + 1) if n % d == 0]


def objects_of_least_order(study: CheckedIterate) -> dict[str, dict[str, DiagonalObject]]:
    """All on the diagonal that belongs to no smaller iterate; of jumps, all."""
    n = study.order

    def is_own(word: str) -> bool:
        half = study.sense(word[: n // 2]) < 0 and 2 * period(word) == n
        return period(word) == n or (half and word in study.bands)

    return {
        FIXED: {word: each for word, each in study.fixed.items() if is_own(word)},
        BANDS: {word: each for word, each in study.bands.items() if is_own(word)},
        JUMPS: dict(study.crossings),
    }
