"""The pieces of a map, with exact values and as text."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import sympy

from pwmap.algebra.exact import quotient_to_sympy
from pwmap.algebra.texts import text
from pwmap.diagrams.frames import Column
from pwmap.maps.cylinders import Cylinder
from pwmap.maps.decided import Decided


@dataclass(frozen=True, slots=True, eq=False)
class LinearPiece:
    """An affine piece of a :class:`PiecewiseLinearMap`: ``slope x + intercept`` on its interval."""

    cylinder: Cylinder
    owner: Decided = field(repr=False)

    @property
    def word(self) -> str:
        """The pieces of the original map that its points visit, in order."""
        return self.owner.spelled(self.cylinder.word)

    @property
    def slope(self) -> sympy.Expr:
        """Slope of the piece."""
        return self.owner.slope(self.cylinder.word)

    @property
    def intercept(self) -> sympy.Expr:
        """Value of the piece's formula at x = 0."""
        return quotient_to_sympy(self.owner.orbits.intercept(self.cylinder.word))

    @property
    def expression(self) -> sympy.Expr:
        """The formula ``slope x + intercept``."""
        return self.slope * self.owner.definition.x + self.intercept

    @property
    def lower(self) -> sympy.Expr:
        """Left end, or ``-oo``."""
        cut = self.cylinder.lower
        return -sympy.oo if cut is None else self.owner.cut_to_sympy(self.cylinder.word, cut)

    @property
    def upper(self) -> sympy.Expr:
        """Right end, or ``oo``."""
        cut = self.cylinder.upper
        return sympy.oo if cut is None else self.owner.cut_to_sympy(self.cylinder.word, cut)

    @property
    def lower_closed(self) -> bool:
        """Whether the left end belongs to the piece."""
        return self.cylinder.lower_closed

    @property
    def upper_closed(self) -> bool:
        """Whether the right end belongs to the piece."""
        return self.cylinder.upper_closed

    @property
    def interval(self) -> sympy.Set:
        """The piece's domain as a sympy set."""
        if self.cylinder.is_point:
            return sympy.FiniteSet(self.lower)
        return sympy.Interval(self.lower, self.upper, not self.lower_closed, not self.upper_closed)

    @property
    def relation(self) -> sympy.Basic:
        """The domain as a condition on the variable."""
        x = self.owner.definition.x
        if self.cylinder.is_point:
            return sympy.Eq(x, self.lower)
        bounds = []
        if self.cylinder.lower is not None:
            bounds.append(x >= self.lower if self.lower_closed else x > self.lower)
        if self.cylinder.upper is not None:
            bounds.append(x <= self.upper if self.upper_closed else x < self.upper)
        return sympy.And(*bounds)

    def condition(self) -> str:
        """The domain as text, such as ``0 < x <= r/a``."""
        x = str(self.owner.definition.x)
        if self.cylinder.is_point:
            return f"{x} = {text(self.lower)}"
        low, high = _less(self.lower_closed), _less(self.upper_closed)
        left = "" if self.cylinder.lower is None else f"{text(self.lower)} {low} "
        right = "" if self.cylinder.upper is None else f" {high} {text(self.upper)}"
        return left + x + right if left or right else f"all {x}"

    def __str__(self) -> str:
        return f"{self.word}: {text(self.expression)} for {self.condition()}"

    def __repr__(self) -> str:
        return f"<LinearPiece {self}>"


def _less(closed: bool) -> str:
    return "<=" if closed else "<"


def columns_of(pieces: Sequence[LinearPiece]) -> dict[str, Column]:
    """Columns of a table with a row for each piece."""
    names = ("word", "slope", "intercept", "lower", "upper", "lower_closed", "upper_closed")
    return {name: [getattr(piece, name) for piece in pieces] for name in names}


def lines_of(pieces: Sequence[LinearPiece]) -> str:
    """One line for each piece: its word, formula and domain."""
    rows = [(p.word, text(p.expression), p.condition()) for p in pieces]
    widths = [max(len(row[i]) for row in rows) for i in range(2)]
    return "\n".join(
        f"{word:<{widths[0]}}  {formula:<{widths[1]}}  for {condition}"
        for word, formula, condition in rows
    )


def latex_of(pieces: Sequence[LinearPiece], order: int) -> str:
    """The pieces of the iterate of an order as a LaTeX formula."""
    rows = (
        rf"{sympy.latex(p.expression)} & {sympy.latex(p.relation)} & \text{{{p.word}}}"
        for p in pieces
    )
    body = r" \\ ".join(rows)
    head = f"P_{{{order}}}({sympy.latex(pieces[0].owner.definition.x)})"
    return rf"$\displaystyle {head} = \left\{{\begin{{array}}{{lll}} {body} \end{{array}}\right.$"
