"""Conditions of a sympy Piecewise as margins: each relation a function that is positive inside."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import sympy


class Bound(NamedTuple):
    """A relation as a margin."""

    margin: sympy.Expr  # positive where the relation holds
    closed: bool  # it also holds where the margin vanishes
    cause: str  # a sentence on what happens there

    def complement(self) -> Bound:
        """The bound of all other points."""
        return Bound(-self.margin, not self.closed, self.cause)

    @property
    def relation(self) -> sympy.Basic:
        """What holds inside."""
        sense = sympy.GreaterThan if self.closed else sympy.StrictGreaterThan
        return sense(self.margin, 0, evaluate=False)

    def __str__(self) -> str:
        return str(self.relation)


def bounds_of_pieces(conditions: Sequence[sympy.Basic]) -> list[tuple[Bound, ...] | None]:
    """The margins of the pieces of a Piecewise, with complements of earlier ones; None if empty.

    ValueError for other conditions than relations joined by And, and for an overlap with an earlier
    condition of several relations, whose complement is no such condition.
    """
    found: list[tuple[Bound, ...] | None] = []
    earlier: list[tuple[Bound, ...]] = []
    for condition in conditions:
        own = bounds_of(condition)
        rest = None if own is None else _without(own, earlier, condition)
        found.append(rest)
        if own is not None:
            earlier.append(own)
    return found


def bounds_of(condition: sympy.Basic) -> tuple[Bound, ...] | None:
    """The relations of a condition, none twice; None if it is false. ValueError for others."""
    if condition is sympy.false:
        return None
    bounds: list[Bound] = []
    for relation in condition.args if isinstance(condition, sympy.And) else (condition,):
        if relation is not sympy.true:
            _add(bounds, _bound(relation, condition))
    return None if _contradict(bounds) else tuple(bounds)


def _bound(relation: sympy.Basic, condition: sympy.Basic) -> Bound:
    if not isinstance(relation, sympy.StrictGreaterThan | sympy.GreaterThan | sympy.StrictLessThan
                      | sympy.LessThan):  # fmt: skip
        raise ValueError(
            f"a condition must be a relation <, <=, > or >=, or several joined by And, "
            f"got {condition}"
        )
    closed = isinstance(relation, sympy.GreaterThan | sympy.LessThan)
    return Bound(relation.gts - relation.lts, closed, f"{relation.lhs} = {relation.rhs}")


def _without(
    own: tuple[Bound, ...], earlier: Iterable[tuple[Bound, ...]], condition: sympy.Basic
) -> tuple[Bound, ...] | None:
    """Bounds of the points of a condition that none of the earlier ones holds; None if none."""
    bounds, pending = list(own), list(earlier)
    while pending:  # fewer each time
        later = []
        for other in pending:
            if _contradict([*bounds, *other]):
                continue
            open_ = [b for b in other if not any(_implies(own, b) for own in bounds)]
            if not open_:
                return None
            if len(open_) == 1:
                _add(bounds, open_[0].complement())
            else:
                later.append(other)
        if len(later) == len(pending):
            raise ValueError(
                f"the condition {condition} overlaps with the earlier one "
                f"{' & '.join(map(str, later[0]))}, whose complement is no single relation: "
                "write out where this piece holds"
            )
        pending = later
    return None if _contradict(bounds) else tuple(bounds)


def _add(bounds: list[Bound], new: Bound) -> None:
    """Add a bound, unless others imply it; drop those that it implies."""
    if any(_implies(bound, new) for bound in bounds):
        return
    bounds[:] = [bound for bound in bounds if not _implies(new, bound)]
    bounds.append(new)


def _implies(one: Bound, other: Bound) -> bool:
    """Whether all points of one bound obey another, as far as a constant difference tells."""
    excess = _constant(_normal(other.margin) - _normal(one.margin))
    if excess is None:
        return False
    return bool(excess > 0) or (bool(excess == 0) and (other.closed or not one.closed))


def _contradict(bounds: Sequence[Bound]) -> bool:
    """Whether two bounds exclude each other, as far as a constant sum tells."""
    for k, one in enumerate(bounds):
        for other in bounds[:k]:
            total = _constant(_normal(one.margin) + _normal(other.margin))
            if total is not None and (
                total < 0 or (total == 0 and not (one.closed and other.closed))
            ):
                return True
    return False


def _constant(expression: sympy.Expr) -> sympy.Expr | None:
    """The rational number that an expression is; None if it is no such number."""
    value = sympy.expand(expression)
    return value if value.is_Rational else None


def _normal(margin: sympy.Expr) -> sympy.Expr:
    """The same up to a positive factor for relations that say the same."""
    expanded = sympy.expand(margin)
    content = expanded.as_content_primitive()[0]
    return expanded / abs(content) if content.is_nonzero else expanded
