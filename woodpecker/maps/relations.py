"""The conditions of a sympy Piecewise as margins: functions that are positive where they hold."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from itertools import chain, combinations, product
from typing import NamedTuple

import sympy

CORNERS = (sympy.Piecewise, sympy.Abs, sympy.Max, sympy.Min)
MOST_REGIONS = 64  # most regions of a piece, or cases of all corners: a handful is usual


class Bound(NamedTuple):
    """A relation as a margin."""

    margin: sympy.Expr  # positive where the relation holds
    closed: bool  # whether the relation also holds where the margin vanishes
    cause: str  # a sentence on what happens there

    def complement(self) -> Bound:
        """The bound that holds at all points where this one does not."""
        return Bound(-self.margin, not self.closed, self.cause)

    @property
    def relation(self) -> sympy.Basic:
        """The relation itself."""
        sense = sympy.GreaterThan if self.closed else sympy.StrictGreaterThan
        return sense(self.margin, 0, evaluate=False)

    def __str__(self) -> str:
        return str(self.relation)


def cases_of(expression: sympy.Expr) -> list[tuple[sympy.Expr, sympy.Basic]]:
    """The smooth formulas of an expression with their conditions; the first that holds counts.

    Each corner (Piecewise, Abs, Max, Min) is written as its cases; ValueError if several of them
    have more than ``MOST_REGIONS`` combinations.
    """
    subs = sympy.postorder_traversal(expression)
    corner = next((each for each in subs if isinstance(each, CORNERS)), None)
    if corner is None:
        return [(expression, sympy.true)]
    found = list[tuple[sympy.Expr, sympy.Basic]]()
    for value, condition in _cases(corner):  # each case has one corner fewer
        inner = cases_of(expression.xreplace({corner: value}))
        both = [(formula, sympy.And(condition, others)) for formula, others in inner]
        found += both if len(inner) == 1 else [each for each in both if regions_of(each[1])]
        if len(found) > MOST_REGIONS and len(inner) > 1:
            raise ValueError(
                f"corners must make at most {MOST_REGIONS} cases, got more in {expression}"
            )
    return found


def _cases(corner: sympy.Expr) -> Sequence[tuple[sympy.Expr, sympy.Basic]]:
    """The formulas of one corner, and their conditions."""
    values = corner.args
    match corner:
        case sympy.Piecewise():
            return [tuple(each) for each in values]
        case sympy.Abs():
            return [(-values[0], values[0] < 0), (values[0], values[0] >= 0)]
    first, later = (sympy.Gt, sympy.Ge) if isinstance(corner, sympy.Max) else (sympy.Lt, sympy.Le)
    return [
        (value, sympy.And(*(first(value, each) for each in values[:k]),
                          *(later(value, each) for each in values[k + 1 :])))
        for k, value in enumerate(values)
    ]  # fmt: skip


Region = tuple[Bound, ...]
"""A set of points: those where all of some relations hold."""


def regions_of_pieces(holding: Sequence[Sequence[Region]]) -> list[list[Region]]:
    """For each condition of a Piecewise disjoint regions where it is the first that holds.

    ``holding`` has regions where each one holds; ValueError for gaps, or over ``MOST_REGIONS``.
    """
    found, earlier = list[list[Region]](), list[Region]()
    for regions in holding:
        own = list[Region]()
        for region in regions:
            own += _without(region, earlier)
            earlier.append(region)
        found.append(own)
    _check_seams([*chain(*found)])
    return found


def _check_seams(regions: Sequence[Region]) -> None:
    """ValueError if two regions end at one border, and no region has the points of the border."""
    for one, other in combinations(regions, 2):
        for bound, beyond in product(one, other):
            if bound.closed or beyond.closed or _total(bound.margin, beyond.margin) != 0:
                continue
            border = bound._replace(closed=True), beyond._replace(closed=True)
            seam = (*border, *(each for each in (*one, *other) if each not in (bound, beyond)))
            if not _contradict(seam) and _without(seam, regions):
                raise ValueError(
                    f"there is a gap: no piece covers {bound.cause}, write <= or >= on one side"
                )


def regions_of(condition: sympy.Basic) -> list[Region]:
    """Regions, perhaps overlapping, where a condition holds; ValueError unless of relations."""
    if condition is sympy.false:
        return []
    whole, found = sympy.to_dnf(condition), list[Region]()
    for each in whole.args if isinstance(whole, sympy.Or) else (whole,):
        bounds: list[Bound] = []
        for relation in each.args if isinstance(each, sympy.And) else (each,):
            if relation is not sympy.true:
                _add(bounds, _bound(relation, condition))
        if not _contradict(bounds):
            found.append(tuple(bounds))
    return found


def _bound(relation: sympy.Basic, condition: sympy.Basic) -> Bound:
    if not isinstance(relation, sympy.StrictGreaterThan | sympy.GreaterThan | sympy.StrictLessThan
                      | sympy.LessThan):  # fmt: skip
        raise ValueError(
            f"a condition must be a relation <, <=, > or >=, or several joined by And or Or, "
            f"got {condition}"
        )
    closed = isinstance(relation, sympy.GreaterThan | sympy.LessThan)
    return Bound(relation.gts - relation.lts, closed, f"{relation.lhs} = {relation.rhs}")


def _without(region: Region, earlier: Iterable[Region]) -> list[Region]:
    """Disjoint parts of a region that lie in none of the earlier ones."""
    parts = [region]
    for other in earlier:
        parts = [each for part in parts for each in _outside(part, other)]
        if len(parts) > MOST_REGIONS:
            raise ValueError(
                f"a piece must hold in at most {MOST_REGIONS} regions, got more where "
                f"{' & '.join(map(str, region))}: write the map in fewer cases"
            )
    return parts


def _outside(part: Region, other: Region) -> list[Region]:
    """The part of a region outside of another, divided by the first of its bounds that fails."""
    if _contradict([*part, *other]):
        return [part]
    found, inside = list[Region](), list(part)
    for bound in other:
        beyond = list(inside)
        _add(beyond, bound.complement())
        if not _contradict(beyond):
            found.append(tuple(beyond))
        _add(inside, bound)
    return found


def _add(bounds: list[Bound], new: Bound) -> None:
    """Add a bound unless others imply it, and drop those that it implies."""
    if any(_implies(bound, new) for bound in bounds):
        return
    bounds[:] = [bound for bound in bounds if not _implies(new, bound)]
    bounds.append(new)


def _implies(one: Bound, other: Bound) -> bool:
    """Whether one bound implies another, which is seen if their margins differ by a constant."""
    excess = _total(other.margin, -one.margin)
    if excess is None:
        return False
    return bool(excess > 0) or (bool(excess == 0) and (other.closed or not one.closed))


def _contradict(bounds: Sequence[Bound]) -> bool:
    """Whether two bounds exclude each other, which is seen if their margins add to a constant."""
    for one, other in combinations(bounds, 2):
        total = _total(one.margin, other.margin)
        if total is not None and (total < 0 or (total == 0 and not (one.closed and other.closed))):
            return True
    return False


@lru_cache(maxsize=4096)
def _total(one: sympy.Expr, other: sympy.Expr) -> sympy.Expr | None:
    """The sum of two normalised margins; None unless it is a rational number."""
    value = sympy.expand(_normal(one) + _normal(other))
    return value if value.is_Rational else None


@lru_cache(maxsize=4096)
def _normal(margin: sympy.Expr) -> sympy.Expr:
    """A margin divided by a positive factor, so that equivalent relations have one margin."""
    expanded = sympy.expand(margin)
    content = expanded.as_content_primitive()[0]
    return expanded / abs(content) if content.is_nonzero else expanded
