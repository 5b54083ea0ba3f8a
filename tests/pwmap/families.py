"""Random families of maps over one parameter, with polynomials of it as coefficients and breaks."""

import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import brute
from independent import Number, Part, Parts, Poly, plus, product, trimmed, value

from pwmap import PiecewiseLinearMap

ONE = Fraction(1)
LIGHT = 9  # words there can be in a light family


@dataclass(frozen=True, kw_only=True)
class Family:
    """A map whose coefficients are polynomials in p.

    Attributes
    ----------
    formulas
        Slope and intercept of each letter.
    slots
        The letter of each interval and of each break between two of them, from left to right.
    """

    formulas: tuple[tuple[Poly, Poly], ...]
    breaks: tuple[Poly, ...]
    slots: tuple[int, ...]
    span: tuple[Fraction, Fraction]
    orders: tuple[int, ...]
    assumes: bool

    def __post_init__(self) -> None:
        assert len(self.slots) == 2 * len(self.breaks) + 1

    @property
    def letters(self) -> str:
        """The names of the pieces from left to right."""
        return "ABCDEFGHI"[: len(self.formulas)]

    def pieces(self) -> list[tuple[str, str]]:
        """Formulas and conditions as text."""
        return brute.texts(self._parts(text))

    def map(self) -> PiecewiseLinearMap:
        """The map as the package reads it."""
        given = [f"p >= {self.span[0]}", f"p <= {self.span[1]}"] if self.assumes else []
        return PiecewiseLinearMap(self.pieces(), given=given, letters=list(self.letters))

    def at(self, p: Number) -> Parts:
        """The map at one parameter."""
        return self._parts(lambda poly: value(poly, p))

    def _parts(self, shown: Callable[[Poly], Any]) -> Parts:
        """The pieces, with what is shown of each polynomial: its value or its text."""
        breaks = list(map(shown, self.breaks))
        parts = []
        for letter, (slope, intercept) in enumerate(self.formulas):
            owned = [slot for slot, owner in enumerate(self.slots) if owner == letter]
            low, high = owned[0], owned[-1]
            parts.append(
                Part(
                    None if low == 0 else breaks[(low - 1) // 2],
                    low % 2 == 1,
                    None if high == len(self.slots) - 1 else breaks[high // 2],
                    high % 2 == 1,
                    shown(slope),
                    shown(intercept),
                    self.letters[letter],
                )
            )
        return tuple(parts)

    def __str__(self) -> str:
        return (
            f"PiecewiseLinearMap({self.pieces()}, letters={list(self.letters)}), 'p', "
            f"({self.span[0]}, {self.span[1]}), {self.orders}"
            + (", given p in the closed span" if self.assumes else "")
        )


def family(
    breaks: Sequence[Sequence[Fraction | int]],
    owners: str,
    formulas: Sequence[tuple[Sequence[Fraction | int], Sequence[Fraction | int]]],
    *,
    span: tuple[Fraction | int, Fraction | int],
    orders: Sequence[int],
    assumes: bool = False,
) -> Family:
    """A family from coefficients, constant terms first.

    A break belongs to the piece on its left (``l``) or right (``r``), or is one (``p``).
    """
    slots = [0]
    for owner in owners:
        last = slots[-1]
        slots += {"l": [last, last + 1], "r": [last + 1] * 2, "p": [last + 1, last + 2]}[owner]

    def poly(coefficients: Sequence[Fraction | int]) -> Poly:
        return trimmed([Fraction(c) for c in coefficients])

    return Family(
        formulas=tuple((poly(slope), poly(intercept)) for slope, intercept in formulas),
        breaks=tuple(map(poly, breaks)),
        slots=tuple(slots),
        span=(Fraction(span[0]), Fraction(span[1])),
        orders=tuple(orders),
        assumes=assumes,
    )


def text(poly: Poly) -> str:
    """A polynomial in p."""
    terms = [f"({c})*p**{n}" if n else f"({c})" for n, c in enumerate(poly) if c]
    return " + ".join(terms) or "0"


class Draw:
    """Random families, the same for the same seed."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)

    def number(self, size: int = 3) -> Fraction:
        """A small rational."""
        return Fraction(self.random.randint(-size, size), self.random.choice([1, 1, 2, 3]))

    def poly(self, degree: int) -> Poly:
        """A polynomial with small coefficients."""
        return trimmed([self.number() for _ in range(degree + 1)])

    def slope(self) -> Poly:
        """A slope: often one of 0, 1, -1, or one that is them somewhere."""
        kind = self.random.randrange(8)
        if kind < 2:
            return trimmed([Fraction(self.random.choice([0, 1, -1]))])
        if kind == 2:
            return trimmed([self.random.choice([ONE / 2, -ONE / 2, 2 * ONE, -2 * ONE])])
        return self.poly(self.random.choice([0, 0, 1, 1, 2, 3]))

    def family(self, *, light: bool = False) -> Family:
        """A family that does depend on the parameter; a light one takes no time."""
        while True:
            found = self.any_family()
            size = len(found.formulas) ** max(found.orders)
            changes = any(len(c) > 1 for c in (*found.breaks, *sum(found.formulas, ())))
            if changes and not (light and size > LIGHT):
                return found

    def any_family(self) -> Family:
        """Two to four intervals, with ends that belong to either side or to neither."""
        intervals = self.random.choice([2, 2, 2, 3, 3, 4])
        span = (
            Fraction(self.random.choice([-4, -3, -2, -1]), self.random.choice([1, 2])),
            Fraction(self.random.choice([1, 2, 3, 4]), self.random.choice([1, 2])),
        )
        breaks, assumes = self.breaks(intervals - 1)
        slots, formulas = [0], [(self.slope(), self.poly(self.random.choice([0, 1, 1, 2, 3])))]
        for b in breaks:
            owner = self.random.randrange(5)  # left, right, or a point of its own
            if owner == 4:
                formulas.append(self.point(b))
                slots.append(len(formulas) - 1)
            elif owner < 2:
                slots.append(slots[-1])
            formulas.append(self.formula(b, formulas[slots[-1]]))
            if owner in (2, 3):
                slots.append(len(formulas) - 1)
            slots.append(len(formulas) - 1)
        orders = self.random.choice(
            [(1,), (1, 2), (1, 2), (1, 2, 3), (1, 2, 3), (2,), (3,), (1, 3)]
        )
        return Family(
            formulas=tuple(formulas),
            breaks=tuple(breaks),
            slots=tuple(slots),
            span=span,
            orders=orders,
            assumes=assumes,
        )

    def breaks(self, count: int) -> tuple[list[Poly], bool]:
        """Breaks in order, and whether that needs the parameter to be bounded."""
        kind = self.random.randrange(4)
        start = self.poly(0 if kind < 2 else self.random.choice([1, 1, 2, 3]))
        found, assumes = [start], self.random.random() < 0.3
        for _ in range(count - 1):
            gap = (abs(self.number()) + ONE / 2,)
            if kind == 3:  # bounded below by 1/2 on every span that is drawn
                gap, assumes = (gap[0] + 4, self.random.choice([ONE, -ONE])), True
            found.append(plus(found[-1], gap))
        return found, assumes

    def point(self, b: Poly) -> tuple[Poly, Poly]:
        """A piece that is the break alone: anywhere, or fixed."""
        return (), b if self.random.random() < 0.4 else self.poly(self.random.choice([0, 1, 2]))

    def formula(self, b: Poly, before: tuple[Poly, Poly]) -> tuple[Poly, Poly]:
        """A piece right of a break: any, or continuous there, or with the break fixed."""
        slope, kind = self.slope(), self.random.randrange(10)
        if kind < 3:  # continuous
            at_break = plus(product(before[0], b), before[1])
        elif kind == 3:  # the break stays a fixed point
            at_break = b
        else:
            return slope, self.poly(self.random.choice([0, 0, 1, 1, 2, 3]))
        intercept = plus(at_break, product(slope, b), -ONE)
        if len(intercept) > 4:
            return self.formula(b, before)
        return slope, intercept
