"""Iterates of a piecewise-linear map by following intervals, in rationals or at a real root.

Nothing here knows the package: it is what the package is compared with. A number is a ``Fraction``
or an ``Algebraic``, an element of the field that one real root generates.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import total_ordering
from itertools import pairwise, zip_longest
from typing import Any

Poly = tuple[Fraction, ...]  # from the constant term up
Number = Any  # Fraction or Algebraic
LEFT, EXACT, RIGHT = -1, 0, 1  # where the followed numbers lie, seen from the number itself

# --- Polynomials ----------------------------------------------------------------------------------


def trimmed(poly: Sequence[Fraction]) -> Poly:
    """Without zeros at the top."""
    size = len(poly)
    while size and not poly[size - 1]:
        size -= 1
    return tuple(poly[:size])


def plus(a: Poly, b: Poly, times: Fraction = Fraction(1)) -> Poly:
    """a + times b."""
    return trimmed([x + times * y for x, y in zip_longest(a, b, fillvalue=Fraction(0))])


def product(a: Poly, b: Poly) -> Poly:
    """A b."""
    total = [Fraction(0)] * max(0, len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            total[i + j] += x * y
    return trimmed(total)


def divided(a: Poly, b: Poly) -> tuple[Poly, Poly]:
    """Quotient and remainder."""
    rest, quotient = list(a), [Fraction(0)] * max(0, len(a) - len(b) + 1)
    for i in reversed(range(len(quotient))):
        factor = rest[i + len(b) - 1] / b[-1]
        quotient[i] = factor
        for j, y in enumerate(b):
            rest[i + j] -= factor * y
    return trimmed(quotient), trimmed(rest)


def value(poly: Sequence[Any], at: Number) -> Number:
    """The polynomial at a number."""
    total = at * 0
    for coefficient in reversed(poly):
        total = total * at + coefficient
    return total


# --- Real roots, and the fields they generate -----------------------------------------------------


class Root:
    """A real root of an irreducible polynomial, the only one between two rationals."""

    def __init__(self, poly: Poly, low: Fraction, high: Fraction) -> None:
        self.poly = trimmed([c / poly[-1] for c in poly])
        self.low, self.high = low, high
        assert value(poly, low) * value(poly, high) < 0

    def refine(self) -> None:
        """Halve the interval."""
        middle = (self.low + self.high) / 2
        if value(self.poly, middle) * value(self.poly, self.low) > 0:
            self.low = middle
        else:
            self.high = middle

    def compared(self, other: Root | Fraction) -> int:
        """-1, 0 or 1: whether the root lies below, at or above another place."""
        if other is self:
            return 0
        while True:
            low, high = (other.low, other.high) if isinstance(other, Root) else (other, other)
            if self.high < low:
                return -1
            if high < self.low:
                return 1
            self.refine()
            if isinstance(other, Root):
                other.refine()

    @property
    def number(self) -> Algebraic:
        """The root in its field."""
        return Algebraic(self, (Fraction(0), Fraction(1)))


@total_ordering
class Algebraic:
    """A polynomial in a root, reduced by the polynomial of the root."""

    __slots__ = ("coefficients", "root")

    def __init__(self, root: Root, coefficients: Poly) -> None:
        self.root = root
        if len(coefficients) >= len(root.poly):
            coefficients = divided(coefficients, root.poly)[1]
        self.coefficients = coefficients

    def _of(self, other: object) -> Poly:
        if isinstance(other, Algebraic):
            assert other.root is self.root
            return other.coefficients
        return trimmed([Fraction(other)])  # type: ignore[arg-type]

    def __add__(self, other: object) -> Algebraic:
        return Algebraic(self.root, plus(self.coefficients, self._of(other)))

    def __sub__(self, other: object) -> Algebraic:
        return Algebraic(self.root, plus(self.coefficients, self._of(other), Fraction(-1)))

    def __mul__(self, other: object) -> Algebraic:
        return Algebraic(self.root, product(self.coefficients, self._of(other)))

    def __truediv__(self, other: object) -> Algebraic:
        return self * self._inverse(self._of(other))

    def __rtruediv__(self, other: object) -> Algebraic:
        return self._inverse(self.coefficients) * other

    def __neg__(self) -> Algebraic:
        return self * -1

    def __rsub__(self, other: object) -> Algebraic:
        return -self + other

    __radd__, __rmul__ = __add__, __mul__

    def _inverse(self, poly: Poly) -> Algebraic:
        """By the algorithm of Euclid, with the polynomial of the root."""
        before, rest = self.root.poly, poly
        times_before: Poly = ()
        times: Poly = (Fraction(1),)
        while len(rest) > 1:
            quotient, left = divided(before, rest)
            before, rest = rest, left
            times_before, times = (
                times,
                plus(times_before, product(quotient, times), Fraction(-1)),
            )
        return Algebraic(self.root, product(times, (1 / rest[0],)))  # IndexError if it is zero

    def sign(self) -> int:
        """-1, 0 or 1."""
        while self.coefficients:
            low, high = self.bounds()
            if low > 0 or high < 0:
                return 1 if low > 0 else -1
            self.root.refine()
        return 0

    def bounds(self) -> tuple[Fraction, Fraction]:
        """Two rationals around it."""
        low = high = Fraction(0)
        for c in reversed(self.coefficients):
            ends = [a * b for a in (low, high) for b in (self.root.low, self.root.high)]
            low, high = min(ends) + c, max(ends) + c
        return low, high

    def __eq__(self, other: object) -> bool:
        return self.coefficients == self._of(other)

    def __lt__(self, other: object) -> bool:
        return (self - other).sign() < 0

    def __hash__(self) -> int:
        few = len(self.coefficients) < 2
        return hash(sum(self.coefficients) if few else self.coefficients)

    def __repr__(self) -> str:
        return f"~{float(sum(self.bounds()) / 2):.12g}"


# --- Maps -----------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Part:
    """One affine piece; an end that is None is infinite."""

    lo: Number
    lo_in: bool
    hi: Number
    hi_in: bool
    slope: Number
    intercept: Number
    word: str

    @property
    def is_point(self) -> bool:
        """Whether its domain is one number."""
        return self.lo is not None and self.hi is not None and bool(self.lo == self.hi)

    @property
    def is_identity(self) -> bool:
        """Whether all of its points are fixed, and there are many."""
        return not self.is_point and self.slope == 1 and self.intercept == 0

    def holds(self, x: Number, side: int = EXACT) -> bool:
        """Whether a number, or all just beside it, lie in its domain."""
        lo_in, hi_in = (self.lo_in, self.hi_in) if side == EXACT else (side == RIGHT, side == LEFT)
        above = self.lo is None or self.lo < x or (lo_in and self.lo == x)
        return above and (self.hi is None or x < self.hi or (hi_in and self.hi == x))

    def __call__(self, x: Number) -> Number:
        return self.slope * x + self.intercept


Parts = tuple[Part, ...]


def refined(parts: Parts, base: Parts) -> Parts:
    """One more application of the map ``base``."""
    found: list[Part] = []
    for part in parts:
        pieces = base if part.slope >= 0 else base[::-1]
        found += [new for piece in pieces if (new := _followed(part, piece)) is not None]
    return tuple(found)


def _followed(part: Part, piece: Part) -> Part | None:
    """What of a part goes on in a piece of the map."""
    lo, lo_in, hi, hi_in = part.lo, part.lo_in, part.hi, part.hi_in
    if part.slope == 0:
        if not piece.holds(part.intercept):
            return None
    else:
        ends = [
            (None if end is None else (end - part.intercept) / part.slope, closed)
            for end, closed in ((piece.lo, piece.lo_in), (piece.hi, piece.hi_in))
        ]
        (low, low_in), (high, high_in) = ends if part.slope > 0 else ends[::-1]
        if low is not None and (lo is None or lo <= low):
            lo, lo_in = low, low_in and (lo is None or lo < low or lo_in)
        if high is not None and (hi is None or high <= hi):
            hi, hi_in = high, high_in and (hi is None or high < hi or hi_in)
        if lo is not None and hi is not None and not (lo < hi or (lo == hi and lo_in and hi_in)):
            return None
    slope = piece.slope * part.slope
    intercept = piece.slope * part.intercept + piece.intercept
    return Part(lo, lo_in, hi, hi_in, slope, intercept, part.word + piece.word)


def iterated(base: Parts, order: int) -> list[Parts]:
    """The iterates 1 .. order."""
    found = [base]
    while len(found) < order:
        found.append(refined(found[-1], base))
    return found


def part_at(base: Parts, x: Number, side: int = EXACT) -> Part:
    """The one piece of a map that holds a number, or those just beside it."""
    (part,) = [part for part in base if part.holds(x, side)]
    return part


def nested(base: Parts, x: Number, order: int, side: int = EXACT) -> tuple[Number, str]:
    """Value and word of an iterate by applying the map again and again; beside x the limit."""
    word = ""
    for _ in range(order):
        part = part_at(base, x, side)
        x, word = part(x), word + part.word
        side = side if part.slope > 0 else -side if part.slope < 0 else EXACT
    return x, word


# --- What lies on the diagonal --------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Fixed:
    """A fixed point of an iterate; the multiplier of a point piece is None."""

    x: Number
    word: str
    multiplier: Number
    stable: bool
    period: int
    at_border: bool
    product: Number  # of the slopes on the way, also where the piece is a point


@dataclass(frozen=True, slots=True)
class Crossing:
    """A jump across the diagonal."""

    x: Number
    left: Number
    right: Number
    words: str


def beside(parts: Parts, i: int, x: Number) -> tuple[Part, Part]:
    """The parts just left and just right of a number in part i."""
    part = parts[i]
    left = part if part.lo is None or part.lo < x else parts[i - 1]
    if left.is_point:
        left = parts[i - 2]
    right = part if part.hi is None or x < part.hi else parts[i + 1]
    if right.is_point:
        right = parts[i + 2]
    return left, right


def attracts(left: Part, right: Part, x: Number) -> bool:
    """Whether nearby points on both sides converge to a fixed point, without going far away."""
    if left(x) != x or right(x) != x:
        return False
    if left.slope < 0 and right.slope < 0:
        return bool(left.slope * right.slope < 1)
    return all(side.slope < 1 for side in (left, right) if side.slope >= 0)


def period_of(base: Parts, x: Number, order: int) -> int:
    """Minimal period of a fixed point of an iterate."""
    y = x
    for n in range(1, order + 1):
        y = part_at(base, y)(y)
        if y == x:
            return n
    raise AssertionError(f"{x} is no fixed point of order {order}")


def fixed_points(base: Parts, parts: Parts, order: int) -> Iterator[Fixed]:
    """All fixed points of an iterate besides those in pieces that are the identity."""
    for i, part in enumerate(parts):
        if part.is_point:
            x = part.lo
            if part(x) != x:
                continue
        elif part.slope == 1:
            continue
        else:
            x = part.intercept / (1 - part.slope)
            if not part.holds(x):
                continue
        left, right = beside(parts, i, x)
        yield Fixed(
            x=x,
            word=part.word,
            multiplier=None if part.is_point else part.slope,
            stable=attracts(left, right, x),
            period=period_of(base, x, order),
            at_border=any(end is not None and end == x for end in (part.lo, part.hi)),
            product=part.slope,
        )


def band_period(base: Parts, band: Part, order: int) -> int:
    """Minimal period of all points of a band but at most one."""
    lo = band.lo if band.lo is not None else (0 if band.hi is None else band.hi - 3)
    hi = band.hi if band.hi is not None else lo + 3
    return max(period_of(base, lo + (hi - lo) * Fraction(n, 7), order) for n in (1, 2))


def crossings(parts: Parts) -> Iterator[Crossing]:
    """Breaks of an iterate whose one-sided limits lie strictly on both sides of the diagonal."""
    for left, right in pairwise(part for part in parts if not part.is_point):
        x = left.hi
        limits = left(x), right(x)
        if limits[0] < x < limits[1] or limits[1] < x < limits[0]:
            yield Crossing(x, *limits, f"{left.word}|{right.word}")
