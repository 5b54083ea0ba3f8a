"""Fixed points, bands and jump crossings of a diagram at one parameter, against brute force."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache, cached_property
from itertools import pairwise
from math import inf
from typing import Any

import sympy
from families import ONE, Family
from independent import Number, Part, Parts, band_period, crossings, fixed_points, iterated, value
from readings import (
    DIGITS,
    Curve,
    Place,
    evaluated,
    near,
    number_of,
    place,
    rational,
)

from pwmap import Diagram, bifurcation_diagram
from pwmap.diagrams.diagram import Hit


@dataclass
class Report:
    """What was compared, and what differed."""

    compared: Counter[str] = field(default_factory=Counter)
    differences: list[tuple[str, str]] = field(default_factory=list)

    def check(self, subject: str, good: bool, say: Callable[[], str]) -> None:
        """Count a comparison, and keep what differs."""
        self.compared[subject] += 1
        if not good:
            self.differences.append((subject, say()))


@dataclass(frozen=True, eq=False)
class Case:
    """A family with its diagram."""

    family: Family
    diagram: Diagram
    curves: tuple[Curve, ...]
    report: Report

    @classmethod
    def of(cls, family: Family, report: Report, *, own_span: bool = True) -> Case:
        span = family.span if own_span else None
        diagram = bifurcation_diagram(family.map(), "p", span, family.orders)
        curves = tuple(curve for branch in diagram.branches for curve in Curve.of(branch))
        return cls(family, diagram, curves, report)

    def of_branches(self) -> Iterator[list[Curve]]:
        """The curves of each branch, one after the other."""
        for branch in self.diagram.branches:
            yield [curve for curve in self.curves if curve.branch is branch]

    @cached_property
    def whole(self) -> Diagram:
        """The diagram with the cycles of all periods that divide an order."""
        orders = {d for n in self.family.orders for d in range(1, n + 1) if n % d == 0}
        if orders == set(self.family.orders):
            return self.diagram
        return bifurcation_diagram(self.family.map(), "p", self.family.span, orders)

    def formulas(self) -> dict[Place, Any]:
        """The values of the parameter at which special points lie, as the diagram writes them."""
        found = [point.exact["parameter"] for point in self.diagram.points]
        return {place(formula): formula for formula in found}


def check_at(case: Case, p: Place, *, on_edge: bool) -> None:
    """Fixed points and crossings at one parameter, by branches and by ``at``."""
    at, orders, span = number_of(p), case.family.orders, case.family.span
    base = case.family.at(at)
    iterates = iterated(base, max(orders))
    here = [curve for curve in case.curves if curve.holds(p)]
    for order in orders:
        parts = iterates[order - 1]
        own = [c for c in here if c.branch.order == order]
        where = f"order {order} at p = {p if isinstance(p, Fraction) else at!r}"
        at_end = p in span
        _check_fixed(case, base, parts, own, p, where, on_edge=on_edge, at_end=at_end)
        _check_jumps(case, parts, own, p, where, at_end=at_end)
    _check_hits(case, here, p)


def _check_fixed(
    case: Case,
    base: Parts,
    parts: Parts,
    own: Sequence[Curve],
    p: Place,
    where: str,
    *,
    on_edge: bool,
    at_end: bool,
) -> None:
    at = number_of(p)
    order = own[0].branch.order if own else _order(parts)
    truth = {(f.x, f.word): f for f in fixed_points(base, parts, order) if f.period == order}
    bands = [q for q in parts if q.is_identity and band_period(base, q, order) == order]
    shown = {(c.x(at), c.word): c for c in own if c.is_fixed and not c.is_upright}
    ends = {
        (end, band.word)
        for band in bands
        if not on_edge or _is_lasting(case.family, band.word)
        for end, closed in ((band.lo, band.lo_in), (band.hi, band.hi_in))
        if closed
    }
    report = case.report
    surplus = shown.keys() - truth.keys() - ends
    missing = (truth.keys() | ends) - shown.keys()
    if at_end:  # what exists there only is left out
        missing = {(x, word) for x, word in missing if _goes_on(case, p, order, word, x)}
    report.check(
        "fixed points" + (" on edges" if on_edge else ""),
        not surplus and not missing,
        lambda: f"{where}: fixed points missing {missing}, too many {surplus}",
    )
    for key in truth.keys() & shown.keys():
        fixed, curve = truth[key], shown[key]
        m = curve.multiplier(at)
        good = m is None if fixed.multiplier is None else (m is not None and m == fixed.multiplier)
        if on_edge and fixed.multiplier is None and m is not None:
            good = bool(m == fixed.product)
        report.check("multipliers", good, lambda f=fixed, m=m: f"{where}: multiplier {m}, but {f}")
        if curve.passes(p):  # where it ends it meets others, and its points can repel
            report.check(
                "stability",
                curve.stable(at) == fixed.stable,
                lambda f=fixed, c=curve: f"{where}: {c.branch.id} stable {c.stable(at)}, but {f}",
            )
    if on_edge and not at_end:
        _check_upright(case, [c for c in own if c.is_upright], bands, where)


def _goes_on(case: Case, p: Place, order: int, word: str, x: Number) -> bool:
    """Whether a branch of a word ends at an end of the span, at a position."""
    curves = [c for c in case.curves if c.key == (order, word) and not c.is_upright]
    ends = [(c, i) for c in curves for i, end in enumerate((c.lo, c.hi)) if end is p or end == p]
    return any(bool(c.limit(i) == x) for c, i in ends)


def _order(parts: Parts) -> int:
    return len(parts[0].word)


def _check_upright(case: Case, own: Sequence[Curve], bands: Sequence[Part], where: str) -> None:
    """Branches along one value of the parameter lie in bands."""
    for curve in own:
        ends = [case.diagram.point(name).exact["x"] for name in curve.branch.ends]
        holding = [b for b in bands if b.word == curve.word]
        good = len(holding) == 1 and all(
            near(bound, end)
            or (bound is None and end in (sympy.oo, -sympy.oo))
            or _inside(holding[0], end)
            for bound, end in zip((holding[0].lo, holding[0].hi), ends, strict=True)
        )
        case.report.check("bands", good, lambda c=curve: f"{where}: no band for {c.branch.id}")
    words = {c.word for c in own}
    for band in bands:
        lasting = _is_lasting(case.family, band.word)
        case.report.check(
            "bands",
            lasting or band.word in words,
            lambda b=band: f"{where}: no branch for the band {b}",
        )


@cache
def _is_lasting(family: Family, word: str) -> bool:
    """Whether a word is the identity for all parameters."""
    for p in (Fraction(n, 31) for n in range(40)):  # more than its degree
        slope, intercept = ONE, ONE * 0
        for letter in word:
            s, t = (value(c, p) for c in family.formulas[family.letters.index(letter)])
            slope, intercept = s * slope, s * intercept + t
        if (slope, intercept) != (1, 0):
            return False
    return True


def _inside(band: Part, end: Any) -> bool:
    x = rational(sympy.N(end, DIGITS)) if end.is_finite else None
    return x is not None and (band.lo is None or band.lo < x) and (band.hi is None or x < band.hi)


def _check_jumps(
    case: Case, parts: Parts, own: Sequence[Curve], p: Place, where: str, *, at_end: bool
) -> None:
    at = number_of(p)
    truth = {(c.x, c.left, c.right, c.words) for c in crossings(parts)}
    shown = set()
    for c in own:
        if not c.is_fixed:
            limits = (evaluated(c.stretch.exact[side], at) for side in ("left", "right"))
            shown.add((c.x(at), *limits, c.word))
    missing = truth - shown
    if at_end:  # what exists there only is left out
        missing = {c for c in missing if _goes_on(case, p, _order(parts), c[3], c[0])}
    case.report.check(
        "crossings",
        not (shown - truth) and not missing,
        lambda: f"{where}: crossings missing {missing}, too many {shown - truth}",
    )


def _check_hits(case: Case, here: Sequence[Curve], p: Place) -> None:
    """``Diagram.at`` against the branches that exist there."""
    at, asked = number_of(p), p if isinstance(p, Fraction) else case.formulas()[p]
    hits = case.diagram.at(asked)
    expected = sorted(c.branch.id for c in here for _ in range(1 + c.is_upright))
    good = expected == sorted(hit.branch.id for hit in hits) and all(
        any(_is_hit(case, c, hit, at) for c in here if c.branch is hit.branch) for hit in hits
    )
    positions = [hit.exact["x"] for hit in hits]
    if isinstance(p, Fraction):
        good = good and all(x <= y for x, y in pairwise(positions))
    told = [(hit.branch.id, dict(hit.exact)) for hit in hits]
    case.report.check("at", good, lambda: f"at({asked}): {told}, but {expected}")


def _is_hit(case: Case, curve: Curve, hit: Hit, at: Number) -> bool:
    """Whether the values of a hit are those of its branch."""
    names = hit.exact.keys() - {"x"}
    same = all(_is_value(evaluated(curve.stretch.exact[n], at), hit.exact[n]) for n in names)
    number, exact = float(sympy.N(hit.exact["x"], 20)), abs(hit.x) != inf
    if exact and abs(hit.x - number) > 1e-15 * abs(number):  # some units in the last place
        return False
    if curve.is_upright:
        ends = [case.diagram.point(name).exact["x"] for name in curve.branch.ends]
        return same and hit.exact["x"] in ends
    return same and near(curve.x(at), hit.exact["x"])


def _is_value(number: Number, expr: Any) -> bool:
    return expr is sympy.nan if number is None else near(number, expr)
