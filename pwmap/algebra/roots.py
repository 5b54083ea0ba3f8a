"""Real algebraic numbers, such as the ends of parameter intervals.

A number is an element of ``QQ`` or a :class:`RealRoot`: an irreducible polynomial with an interval
around one of its roots, which comparisons refine as needed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import cache, lru_cache, total_ordering
from itertools import pairwise
from math import lcm
from typing import Any

import sympy
from sympy import QQ, ZZ
from sympy.polys.densearith import dup_mul, dup_rem
from sympy.polys.densebasic import dup_strip
from sympy.polys.densetools import dup_eval, dup_scale, dup_shift, dup_sign_variations
from sympy.polys.euclidtools import dup_invert

from pwmap.algebra.arguments import explained, shown
from pwmap.algebra.exact import (
    HIGHEST,
    LOWEST,
    Infinite,
    Number,
    Portable,
    floor,
    pair,
    portable,
    sign,
    to_float,
)

Dense = tuple[Number, ...]  # coefficients in QQ, highest power first, no leading zero
_T = sympy.Symbol("t")
_BITS = 64  # after the binary point, to which a root is isolated at first: most signs need no more


def trimmed(coefficients: Iterable[Number]) -> Dense:
    """Coefficients without leading zeros, highest power first."""
    return tuple(dup_strip(list(coefficients)))


def integers(numbers: Iterable[Number]) -> tuple[int, ...]:
    """Rationals times their least common denominator, such as coefficients of a polynomial."""
    pairs = [pair(number) for number in numbers]
    common = lcm(*(bottom for _, bottom in pairs))
    return tuple(top * (common // bottom) for top, bottom in pairs)


def _scaled(coefficients: Sequence[int], top: int, bottom: int) -> int:
    """The value of an integer polynomial of degree d at top/bottom, times bottom^d."""
    value, power = 0, 1
    for coefficient in coefficients:
        value = value * top + coefficient * power
        power *= bottom
    return value


@total_ordering
class RealRoot(Portable):
    """A real root of an irreducible polynomial of degree two or more.

    Parameters
    ----------
    polynomial
        Coefficients from the highest degree on; monic and irreducible over the rationals.
    index
        Which of its real roots, counted from the left from 0.
    low, high
        Rationals that isolate it.

    Raises
    ------
    ValueError
        If the polynomial is reducible, of degree below two, or has the same sign at both ends.

    Examples
    --------
    >>> from sympy import QQ
    >>> from pwmap import RealRoot
    >>> root = RealRoot((QQ(1), QQ(0), QQ(-2)), 1, QQ(1), QQ(2))  # of x**2 - 2, between 1 and 2
    >>> root.index, root > QQ(7, 5), root < QQ(10, 7)
    (1, True, True)
    """

    __slots__ = ("_bits", "_coefficients", "_floor", "_hash", "_rises", "index", "polynomial")

    @explained()
    def __init__(self, polynomial: Dense, index: int, low: Number, high: Number) -> None:
        if not isinstance(polynomial, tuple):
            raise TypeError(f"a polynomial must be a tuple of numbers, got {shown(polynomial)}")
        if len(polynomial) < 3 or not _poly(polynomial).is_irreducible:
            raise ValueError(
                "expected an irreducible polynomial of degree two or more, got "
                f"{_poly(polynomial).as_expr()}"
            )
        if sign(value_at(polynomial, low)) * sign(value_at(polynomial, high)) >= 0:
            raise ValueError(
                f"expected ends on both sides of one root of {_poly(polynomial).as_expr()}, got "
                f"{low} and {high}"
            )
        self._set(polynomial, index, low, high)

    @classmethod
    def of_factor(cls, polynomial: Dense, index: int, low: Number, high: Number) -> RealRoot:
        """Make a root without checking ``polynomial``, ``index``, ``low`` and ``high``."""
        root = cls.__new__(cls)
        root._set(polynomial, index, low, high)
        return root

    def _set(self, polynomial: Dense, index: int, low: Number, high: Number) -> None:
        self.polynomial = polynomial
        self.index = index
        self._coefficients = integers(polynomial)
        self._hash = hash((self._coefficients, index))
        self._rises = _scaled(self._coefficients, *pair(high)) > 0
        self._bits = _BITS
        while not self._isolate(low, high):  # ends, as low and high are not the root
            self._bits *= 2

    def __reduce__(self) -> tuple[Any, ...]:
        return self.of_factor, portable((self.polynomial, self.index, self.low, self.high))

    def _isolate(self, low: Number, high: Number) -> bool:
        """Find the step of size 2**-bits that holds the root; False if it exceeds the ends."""
        ends = floor(low * 2**self._bits), -floor(-high * 2**self._bits)
        self._floor = self._bisected(*ends, self._bits)
        return bool(low <= self.low and self.high <= high)

    def _bisected(self, first: int, last: int, bits: int) -> int:
        """The step of size 2**-bits that holds the root, between two others, by its number."""
        while last - first > 1:
            middle = (first + last) // 2
            first, last = (middle, last) if self._above(middle, bits) else (first, middle)
        return first

    def _above(self, n: int, bits: int) -> bool:
        """Whether the root is larger than n / 2**bits, which must lie in its isolating interval."""
        return bool((_scaled(self._coefficients, n, 1 << bits) > 0) != self._rises)

    @property
    def low(self) -> Number:
        """A rational below the root."""
        return QQ(self._floor, 1 << self._bits)

    @property
    def high(self) -> Number:
        """A rational above the root."""
        return QQ(self._floor + 1, 1 << self._bits)

    def floor(self) -> int:
        """The largest integer below the root."""
        return self._floor >> self._bits

    def refine(self) -> None:
        """Increase the bits by half: by a Newton step if that succeeds, otherwise by bisection."""
        more = self._bits // 2
        bits, n, unit = self._bits + more, 2 * self._floor + 1, 2 << self._bits
        degree = len(self._coefficients) - 1
        rates = [c * (degree - i) for i, c in enumerate(self._coefficients[:-1])]
        value, rate = _scaled(self._coefficients, n, unit), _scaled(rates, n, unit)
        guess = ((n * rate - value) << more) // (2 * rate) if rate else n << (more - 1)
        first, last = self._floor << more, (self._floor + 1) << more
        if first <= guess < last and self._above(guess, bits) and not self._above(guess + 1, bits):
            first = guess
        else:
            first = self._bisected(first, last, bits)
        # assigned together: an interrupt in between would leave a wrong number
        self._floor, self._bits = first, bits

    def sign_of(self, polynomial: tuple[int, ...]) -> int:
        """The sign at this root of another polynomial, given by its integer coefficients."""
        found, bits = (None if polynomial else 0), _BITS
        while found is None and bits < self._bits:  # fewer bits than are known may do, for less
            found, bits = self._sure_sign(polynomial, bits), 4 * bits
        if found is None:
            found = self._sure_sign(polynomial, self._bits)
        if found is None:
            rest = self.reduced(tuple(map(QQ, polynomial)))
            # the remainder, of lower degree than the minimal polynomial, is 0 or has no zero here
            while (found := self._sure_sign(integers(rest), self._bits) if rest else 0) is None:
                self.refine()
        return found

    def _sure_sign(self, coefficients: tuple[int, ...], bits: int) -> int | None:
        """The sign of an integer polynomial within ``bits`` of the root; None if it may change."""
        value, change = self.value_near(coefficients, bits)
        if abs(value) > change:
            return 1 if value > 0 else -1
        return None

    def value_near(self, coefficients: tuple[int, ...], bits: int) -> tuple[int, int]:
        """A polynomial with integer ``coefficients`` near the root, and a bound of the error.

        Both are times ``2**((bits + 1) * d)``, for the degree d; ``bits`` after the point of the
        root are used.
        """
        while self._bits < bits:
            self.refine()
        # It is computed at the middle of the step; the error is at most half a step times a bound
        # of its derivative.
        n, unit = 2 * (self._floor >> self._bits - bits) + 1, 2 << bits
        largest = abs(n) + 1
        value = size = change = 0
        power = 1
        for coefficient in coefficients:
            value = value * n + coefficient * power
            change = change * largest + size
            size = size * largest + abs(coefficient) * power
            power *= unit
        return value, change

    def to_float(self, top: Dense, bottom: Dense) -> float:
        """The quotient ``top``/``bottom`` at this root, to the last bit but one, or infinite."""
        if not top:
            return 0.0
        numbers, is_zero = (integers(top), integers(bottom)), None
        while True:  # unless the top is zero, refining brings the root close enough
            (above, loose), (below, slack) = (self.value_near(c, self._bits) for c in numbers)
            if abs(above) > loose << 60 and abs(below) > slack << 60:
                break
            is_zero = not self.reduced(top) if is_zero is None else is_zero
            if is_zero:
                return 0.0
            self.refine()
        shift = (self._bits + 1) * (len(top) - len(bottom))
        scale = QQ(numbers[1][0]) * top[0] / (bottom[0] * numbers[0][0])
        return to_float(QQ(above << max(0, -shift), below << max(0, shift)) * scale)

    def reduced(self, polynomial: Dense) -> Dense:
        """The canonical form of a ``polynomial`` at this root: its remainder by the minimal one."""
        return tuple(dup_rem(list(trimmed(polynomial)), list(self.polynomial), QQ))

    def quotient(self, top: Dense, bottom: Dense) -> Dense:
        """The canonical form of ``top``/``bottom`` at this root, where the bottom is not zero."""
        modulus = list(self.polynomial)
        inverse = dup_invert(list(self.reduced(bottom)), modulus, QQ)
        return tuple(dup_rem(dup_mul(list(self.reduced(top)), inverse, QQ), modulus, QQ))

    def to_sympy(self) -> sympy.Expr:
        """The root in radicals if that is short, otherwise as a ``CRootOf``."""
        return _root_to_sympy(self.polynomial, self.index)

    def element_to_sympy(self, value: Dense) -> sympy.Expr:
        """A number of the root's field, in the form of :meth:`reduced`, as a sympy expression."""
        root = self.to_sympy()
        found = sum(QQ.to_sympy(c) * root**i for i, c in enumerate(reversed(value)))
        if root.has(sympy.CRootOf) or len(value) <= 1:  # there are no radicals
            return sympy.sympify(found)
        found = sympy.expand(found)
        return found if len(self.polynomial) == 3 else sympy.radsimp(found)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, RealRoot):
            return False
        return self._coefficients == other._coefficients and self.index == other.index

    def __hash__(self) -> int:
        return self._hash

    def __lt__(self, other: Real) -> bool:
        if isinstance(other, Infinite):
            return NotImplemented
        if not isinstance(other, RealRoot):
            top, bottom = pair(other)
            scaled = top << self._bits
            if scaled <= self._floor * bottom:
                return False
            if scaled >= (self._floor + 1) * bottom:
                return True
            return (_scaled(self._coefficients, top, bottom) > 0) == self._rises
        if self == other:
            return False
        while not (self._ends_below(other) or other._ends_below(self)):
            self.refine()
            other.refine()
        return self._ends_below(other)

    def _ends_below(self, other: RealRoot) -> bool:
        """Whether the step of this root lies below that of another one; both may touch."""
        return self._floor + 1 << other._bits <= other._floor << self._bits

    def __float__(self) -> float:
        return self.to_float((QQ.one, QQ.zero), (QQ.one,))

    def __repr__(self) -> str:
        return f"RealRoot({self.to_sympy()})"


@cache
def _root_to_sympy(polynomial: Dense, index: int) -> sympy.Expr:
    try:
        return sympy.rootof(_poly(polynomial).as_expr(), _T, index)
    except ValueError:  # of sympy 1.14, which tries to factor a number below a root, and fails
        # of a power of t and a number alone, CRootOf takes the same root: it is moved by 1 then
        moved = QQ.zero if polynomial[1] else QQ.one
        shifted = _poly(dup_shift(list(polynomial), moved, QQ)).as_expr()
        return QQ.to_sympy(moved) + sympy.CRootOf(shifted, _T, index)


Real = Number | RealRoot


def real_to_sympy(x: Any) -> sympy.Expr:
    """A rational, algebraic or infinite number, or an element of a field, as an expression."""
    return x.to_sympy() if hasattr(x, "to_sympy") else QQ.to_sympy(x)


@lru_cache(maxsize=4096)
def algebraic(expression: sympy.Expr) -> Real:
    """The real algebraic number of an expression like ``(1 + sqrt(5))/2``; ValueError if none."""
    if isinstance(expression, sympy.Rational):
        return QQ.from_sympy(expression)
    if isinstance(expression, sympy.CRootOf):  # sympy counts real roots first
        among = real_roots(dense_of(expression.poly))
        if expression.index < len(among):
            return among[expression.index]
        raise ValueError(f"expected a real algebraic number, got {expression}")
    try:
        polynomial = sympy.minimal_polynomial(expression, _T, polys=True)
    except (NotImplementedError, sympy.polys.polyerrors.BasePolynomialError):
        raise ValueError(f"expected a real algebraic number, got {expression}") from None
    if not expression.is_real:
        raise ValueError(f"expected a real algebraic number, got {expression}")
    roots, digits = real_roots(dense_of(polynomial)), 20
    while True:  # with enough digits only one of the distinct roots is near
        value = QQ.from_sympy(sympy.Rational(str(sympy.N(expression, digits))))
        off = QQ(1, 10 ** (digits - 4)) * (1 + abs(value))
        near = [root for root in roots if value - off < root < value + off]
        if len(near) == 1:
            return near[0]
        digits *= 2


def dense_of(polynomial: sympy.Poly) -> Dense:
    """The coefficients of a univariate sympy polynomial, highest power first."""
    return trimmed(QQ(int(c.p), int(c.q)) for c in polynomial.all_coeffs())


def bounds(x: Real) -> tuple[Number, Number]:
    """Rationals below and above a root; twice the number itself if it is rational or infinite."""
    return (x.low, x.high) if isinstance(x, RealRoot) else (x, x)


def real_roots(polynomial: Iterable[Number]) -> tuple[Real, ...]:
    """The distinct real roots of a polynomial, from left to right; none of a constant."""
    dense = trimmed(polynomial)
    if len(dense) <= 1:
        return ()
    if len(dense) == 2:
        return (-dense[1] / dense[0],)
    return _real_roots(tuple(c / dense[0] for c in dense))


def most_roots(polynomial: Dense, low: Number, high: Number) -> int:
    """An upper bound of the number of roots between two rationals, by Descartes' rule of signs."""
    (a, b), (c, d) = pair(low), pair(high)
    unit = lcm(b, d)
    start, length = a * (unit // b), c * (unit // d) - a * (unit // b)
    rest = [ZZ(c * unit**k) for k, c in enumerate(integers(polynomial))]  # in units of 1/unit
    rest = dup_scale(dup_shift(rest, ZZ(start), ZZ), ZZ(length), ZZ)  # from 0 to 1
    # x/(1 + x) maps the positive half-line to (0, 1)
    return int(dup_sign_variations(dup_shift(rest[::-1], ZZ.one, ZZ), ZZ))


def roots_between(polynomial: Dense, low: Real, high: Real) -> tuple[Real, ...]:
    """The distinct roots of a polynomial strictly between two numbers, from left to right."""
    first, last = bounds(low)[0], bounds(high)[1]
    if first > LOWEST and last < HIGHEST:
        ends = to_float(first), to_float(last)
        if not may_vanish(polynomial, *ends) or not most_roots(polynomial, first, last):
            return ()
    return tuple(root for root in real_roots(polynomial) if low < root < high)


@cache
def _real_roots(dense: Dense) -> tuple[Real, ...]:
    found: list[Real] = []
    for factor, _ in _poly(dense).factor_list()[1]:
        monic = tuple(QQ.from_sympy(c) for c in factor.monic().all_coeffs())
        if len(monic) == 2:
            found.append(-monic[1])
            continue
        for index, ends in enumerate(_isolated(monic)):
            found.append(RealRoot.of_factor(monic, index, *ends))
    return tuple(sorted(found))


def _isolated(polynomial: Dense) -> Iterator[tuple[Number, Number]]:
    """Intervals around the roots of a monic irreducible polynomial, from left to right."""
    # They are halved until Descartes' rule says that there is one root or none. Unlike continued
    # fractions, halving takes as many steps as numbers have bits, however far or close roots are.
    # Beyond the sum of the sizes of all coefficients, the first of which is 1, the highest power is
    # larger than all the other terms together.
    far = QQ(1 << ceiling(sum(map(abs, polynomial))).bit_length())
    left = [(-far, far)]
    while left:
        low, high = left.pop()
        most = most_roots(polynomial, low, high)
        if most == 1:
            yield low, high
        elif most:
            middle = (low + high) / 2  # which is no root: those are irrational
            left += [(middle, high), (low, middle)]


def _poly(dense: Sequence[Number]) -> sympy.Poly:
    return sympy.Poly.from_list([QQ.to_sympy(c) for c in dense] or [0], _T, domain="QQ")


def sign_at(polynomial: Dense, x: Real) -> int:
    """The sign of a polynomial at a rational or algebraic number."""
    if isinstance(x, RealRoot):
        return x.sign_of(integers(polynomial))
    return sign(value_at(polynomial, x))


def value_at(polynomial: Dense, x: Number) -> Number:
    """The value of a polynomial at a rational number."""
    return dup_eval(polynomial, x, QQ)


def simplest_between(low: Real, high: Real) -> Number:
    """The rational of least denominator, then of least size, strictly between two ends."""
    if isinstance(low, Infinite) and isinstance(high, Infinite):
        return QQ.zero
    if isinstance(low, Infinite):
        return QQ(min(0, ceiling(high) - 1))
    if isinstance(high, Infinite):
        return QQ(max(0, whole_part(low) + 1))
    while True:  # ends, as the bounds of two distinct numbers separate
        found = _simplest(bounds(low)[0], bounds(high)[1])
        if low < found < high:
            return found
        for end in (low, high):  # the rational lies between a root and its bound
            if isinstance(end, RealRoot):
                end.refine()


def whole_part(x: Real) -> int:
    """The largest integer not above a number."""
    return x.floor() if isinstance(x, RealRoot) else floor(x)


def ceiling(x: Real) -> int:
    """The smallest integer not below a number."""
    return x.floor() + 1 if isinstance(x, RealRoot) else -floor(-x)


def _simplest(low: Number, high: Number) -> Number:
    """The simplest rational strictly between two others, by their continued fractions."""
    if low < 0 < high:
        return QQ.zero
    side = 1 if low >= 0 else -1
    if side < 0:
        low, high = -high, -low
    terms = []
    while (whole := floor(low)) + 1 >= high:  # ends: rationals have finite continued fractions
        # both have the same integer part, or high is the next integer: go on with reciprocals
        terms.append(whole)
        if low == whole:
            last = floor(1 / (high - whole)) + 1
            break
        low, high = 1 / (high - whole), 1 / (low - whole)
    else:
        last = whole + 1
    found = QQ(last)
    for term in reversed(terms):
        found = term + 1 / found
    return side * found


def equally_spaced(low: Real, high: Real, n: int) -> list[Number]:
    """The n rationals that divide the interval between two numbers into equal steps."""
    first, last = bounds(low)[1], bounds(high)[0]
    return [first + (last - first) * QQ(i, n + 1) for i in range(1, n + 1)]


def may_vanish(polynomial: Sequence[Number], low: float, high: float) -> bool:
    """False only if the mean value form excludes a zero of a polynomial between two doubles."""
    if not polynomial:
        return False
    coefficients = [to_float(c) for c in polynomial]
    middle, half = 0.5 * (low + high), 0.5 * (high - low) * (1.0 + 1e-9) + 1e-15 * abs(high)
    largest = max(abs(low), abs(high))
    value = size = change = 0.0
    for c in coefficients:
        change = change * largest + size
        value = value * middle + c
        size = size * largest + abs(c)
    noise = 1e-12 * size  # far above the rounding errors of Horner's rule
    return not abs(value) > half * change * (1.0 + 1e-9) + noise


def gap_around(
    value: Number, polynomials: Iterable[Dense], low: Real = LOWEST, high: Real = HIGHEST
) -> tuple[Real, Real]:
    """The largest open interval around a rational, within two ends, that holds no other root."""
    for polynomial in sorted(polynomials, key=len):
        roots = roots_between(polynomial, low, high)
        low = max([low, *(root for root in roots if root < value)])
        high = min([high, *(root for root in roots if root > value)])
    return low, high


def gaps_and_roots(roots: Sequence[Real]) -> list[tuple[Real, Real]]:
    """The line cut at sorted roots: open gaps and, between these, the roots as (root, root)."""
    gaps = list(pairwise((LOWEST, *roots, HIGHEST)))
    return [gaps[0], *(piece for gap in gaps[1:] for piece in ((gap[0], gap[0]), gap))]


def inside(piece: tuple[Real, Real]) -> Real:
    """A number in a piece of the line: the root itself, or the simplest rational in a gap."""
    low, high = piece
    return low if low is high else simplest_between(low, high)
