"""Real algebraic numbers, as far as the ends of parameter intervals need them.

A number is an element of ``QQ`` or a :class:`RealRoot`: an irreducible polynomial with an interval
that isolates one of its roots, refined only as far as a comparison asks for.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache, total_ordering
from itertools import pairwise
from math import floor

import sympy
from sympy import QQ

from pwmap.exact import Number, sign

Dense = tuple[Number, ...]  # coefficients in QQ, highest power first, no leading zero
_T = sympy.Symbol("t")


def trimmed(coefficients: Iterable[Number]) -> Dense:
    """Drop leading zeros."""
    result = list(coefficients)
    while result and not result[0]:
        del result[0]
    return tuple(result)


def horner(polynomial: Dense, x: Number) -> Number:
    """Value of a polynomial."""
    value = QQ.zero
    for coefficient in polynomial:
        value = value * x + coefficient
    return value


@total_ordering
class RealRoot:
    """A real root of an irreducible polynomial of degree two or more.

    Parameters
    ----------
    polynomial
        Monic and irreducible over the rationals.
    index
        Which of its real roots, counted from the left.
    low, high
        Rationals that isolate it.
    """

    __slots__ = ("_rises", "high", "index", "low", "polynomial")

    def __init__(self, polynomial: Dense, index: int, low: Number, high: Number) -> None:
        self.polynomial = polynomial
        self.index = index
        self.low, self.high = low, high
        self._rises = sign(horner(polynomial, high)) > 0

    def refine(self) -> None:
        """Halve the isolating interval."""
        middle = (self.low + self.high) / 2
        if (horner(self.polynomial, middle) > 0) == self._rises:
            self.high = middle
        else:
            self.low = middle

    def refined_to(self, width: Number) -> Number:
        """A rational within ``width`` of the root."""
        while self.high - self.low > width:
            self.refine()
        return (self.low + self.high) / 2

    def sign_of(self, polynomial: Dense) -> int:
        """Sign of another polynomial at this root."""
        rest = self.reduced(polynomial)
        if not rest:
            return 0
        while True:
            low, high = _range(rest, self.low, self.high)
            if low > 0 or high < 0:
                return sign(low)
            self.refine()

    def reduced(self, polynomial: Dense) -> Dense:
        """Remainder modulo the root's polynomial: the canonical form of a number of its field."""
        rest, degree = list(trimmed(polynomial)), len(self.polynomial) - 1
        while len(rest) > degree:
            factor = rest[0]
            for i in range(1, degree + 1):
                rest[i] -= factor * self.polynomial[i]
            del rest[0]
        return trimmed(rest)

    def quotient(self, top: Dense, bottom: Dense) -> Dense:
        """Canonical form of top/bottom at this root, where the bottom is not zero."""
        inverse = sympy.invert(_poly(self.reduced(bottom)), _poly(self.polynomial))
        product = _poly(self.reduced(top)) * inverse
        return self.reduced(tuple(QQ.from_sympy(c) for c in product.all_coeffs()))

    def to_sympy(self) -> sympy.Expr:
        """The root as radicals where that is short, otherwise as a ``CRootOf``."""
        return sympy.rootof(_poly(self.polynomial).as_expr(), _T, self.index)

    def __float__(self) -> float:
        """The nearest float, but for the last bit."""
        scale = max(abs(self.low), abs(self.high), QQ(1, 2**40))
        return float(self.refined_to(scale / 2**60))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, RealRoot):
            return False
        return self.polynomial == other.polynomial and self.index == other.index

    def __hash__(self) -> int:
        return hash((self.polynomial, self.index))

    def __lt__(self, other: Real) -> bool:
        if self == other:
            return False
        while True:
            low, high = bounds(other)
            if self.high <= low:
                return True
            if self.low >= high:
                return False
            self.refine()
            if isinstance(other, RealRoot):
                other.refine()

    def __repr__(self) -> str:
        return f"RealRoot({float(self):.6g})"


Real = Number | RealRoot


def bounds(x: Real) -> tuple[Number, Number]:
    """Rationals on both sides of a number, or twice the number itself."""
    return (x.low, x.high) if isinstance(x, RealRoot) else (x, x)


def real_roots(polynomial: Iterable[Number]) -> tuple[Real, ...]:
    """The distinct real roots of a polynomial that is not zero, from left to right."""
    dense = trimmed(polynomial)
    if len(dense) <= 1:
        return ()
    if len(dense) == 2:
        return (-dense[1] / dense[0],)
    return _real_roots(tuple(c / dense[0] for c in dense))


@cache
def _real_roots(dense: Dense) -> tuple[Real, ...]:
    found: list[Real] = []
    for factor, _ in _poly(dense).factor_list()[1]:
        monic = tuple(QQ.from_sympy(c) for c in factor.monic().all_coeffs())
        if len(monic) == 2:
            found.append(-monic[1])
            continue
        for index, ((low, high), _) in enumerate(factor.intervals()):
            found.append(RealRoot(monic, index, QQ.from_sympy(low), QQ.from_sympy(high)))
    return tuple(sorted(found))


def _poly(dense: Sequence[Number]) -> sympy.Poly:
    return sympy.Poly.from_list([QQ.to_sympy(c) for c in dense] or [0], _T, domain="QQ")


def _range(polynomial: Dense, low: Number, high: Number) -> tuple[Number, Number]:
    """Interval arithmetic by Horner's rule."""
    bottom = top = QQ.zero
    for coefficient in polynomial:
        corners = [bottom * low, bottom * high, top * low, top * high]
        bottom, top = min(corners) + coefficient, max(corners) + coefficient
    return bottom, top


def sign_at(polynomial: Dense, x: Real) -> int:
    """Sign of a polynomial at a rational or algebraic number."""
    return x.sign_of(polynomial) if isinstance(x, RealRoot) else sign(horner(polynomial, x))


def simplest_between(low: Real | None, high: Real | None) -> Number:
    """The rational of smallest denominator, then of smallest size, strictly between two numbers.

    None stands for an infinite end.
    """
    if low is None and high is None:
        return QQ.zero
    if low is None:
        return QQ(min(0, -floor(-bounds(high)[0]) - 1))
    if high is None:
        return QQ(max(0, floor(bounds(low)[1]) + 1))
    while bounds(low)[1] >= bounds(high)[0]:
        for end in (low, high):
            if isinstance(end, RealRoot):
                end.refine()
    return _simplest(bounds(low)[1], bounds(high)[0])


def _simplest(low: Number, high: Number) -> Number:
    if low < 0 < high:
        return QQ.zero
    if high <= 0:
        return -_simplest(-high, -low)
    whole = floor(low)
    if whole + 1 < high:
        return QQ(whole + 1)
    # low and high have the same integer part, or high is the next integer: look at reciprocals
    rest = low - whole
    if rest == 0:
        return whole + QQ(1, floor(1 / (high - whole)) + 1)
    return whole + 1 / _simplest(1 / (high - whole), 1 / rest)


def gaps_and_roots(roots: Sequence[Real]) -> list[tuple[Real | None, Real | None]]:
    """The line cut at sorted roots: open gaps and, between them, the roots as (root, root)."""
    ends: list[Real | None] = [None, *roots, None]
    pieces: list[tuple[Real | None, Real | None]] = []
    for low, high in pairwise(ends):
        if low is not None:
            pieces.append((low, low))
        pieces.append((low, high))
    return pieces


def inside(piece: tuple[Real | None, Real | None]) -> Real:
    """The root of a piece that is one, or a rational inside a gap."""
    low, high = piece
    return low if low is not None and low is high else simplest_between(low, high)
