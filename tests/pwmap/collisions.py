"""Special points of a diagram: ends, incidence, sides and kinds, by brute force beside them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any

import sympy
from comparisons import Case
from families import Family
from independent import Number, Root, crossings, fixed_points, iterated
from readings import (
    DIGITS,
    Curve,
    Place,
    compared,
    near,
    number_of,
    place,
    quotient,
    rational,
    rational_near,
)

from pwmap import PointKind, SpecialPoint


@dataclass(frozen=True, eq=False)
class Tip:
    """An end of a branch: on which side of it the branch lies, and where it ends."""

    curve: Curve
    end: int
    p: Place
    x: Number

    @property
    def side(self) -> int:
        """-1 or 1 for a branch at smaller or larger parameters, 0 for one value of it."""
        if compared(self.curve.lo, self.curve.hi) == 0:
            return 0
        return 1 if self.end == 0 else -1


def check_points(case: Case) -> None:
    """Ends, incidence, sides and kinds; and where jumps go on with another word."""
    report, diagram = case.report, case.diagram
    at_point: dict[str, list[Tip]] = {point.id: [] for point in diagram.points}
    inner: list[tuple[Tip, Tip]] = []
    for curves in case.of_branches():
        outer, within = _joined(curves)
        inner += within
        for tip, name in zip(outer, curves[0].branch.ends, strict=bool(outer)):
            at_point[name].append(tip)
            point = diagram.point(name)
            good = compared(tip.p, place(point.exact["parameter"])) == 0 and near(
                tip.x, point.exact["x"]
            )
            report.check(
                "ends",
                good,
                lambda t=tip, q=point: f"{t.curve.branch.id} ends at {t.x}, not at {q}",
            )
    for point in diagram.points:
        _check_point(case, point, at_point[point.id])
    points = [(place(point.exact["parameter"]), point) for point in diagram.points]
    for (p, first), (q, second) in pairwise(points):
        same = compared(p, q) == 0 and first.exact["x"] == second.exact["x"]
        report.check("incidence", not same, lambda a=first, b=second: f"{a.id} and {b.id} are one")
    _check_marks(case, [*inner, *((tip,) for tips in at_point.values() for tip in tips)])


def _joined(curves: Sequence[Curve]) -> tuple[list[Tip], list[tuple[Tip, Tip]]]:
    """Both ends of a branch, if it is not upright, and the pairs of ends at which its word changes.

    Each curve begins where the one before ends.
    """
    if curves[0].is_upright:
        return [], []
    tips = [[Tip(c, end, (c.lo, c.hi)[end], c.limit(end)) for end in (0, 1)] for c in curves]
    for i, (before, after) in enumerate(pairwise(tips)):
        free = before if i == 0 else before[1:]
        meeting = [(a, b) for a in free for b in after if compared(a.p, b.p) == 0 and a.x == b.x]
        assert meeting, f"{before[0].curve} is not continued by {after[0].curve}"
        if before[1] is not meeting[0][0]:
            before.reverse()
        if after[0] is not meeting[0][1]:
            after.reverse()
    return [tips[0][0], tips[-1][1]], [(a[1], b[0]) for a, b in pairwise(tips)]


def _check_marks(case: Case, met: Sequence[tuple[Tip, ...]]) -> None:
    """Where a word changes only jumps meet, just two of one order beside each other."""
    for group in met:
        if len(group) < 2:
            continue
        mark = group[0]
        there = [
            tip
            for tip in (tip for others in met for tip in others)
            if compared(tip.p, mark.p) == 0 and tip.x == mark.x
        ]
        own = [t for t in there if t.side and t.curve.branch.order == mark.curve.branch.order]
        good = len(own) == 2 and not any(tip.curve.is_fixed for tip in there)
        case.report.check("marks", good, lambda m=mark, t=there: f"{m.curve} goes on at {_told(t)}")


def _check_point(case: Case, point: SpecialPoint, tips: Sequence[Tip]) -> None:
    report, name = case.report, point.id
    p = place(point.exact["parameter"])  # type: ignore[arg-type]
    sides = tuple(sorted(t.curve.branch.id for t in tips if t.side == side) for side in (-1, 1))
    found = tuple(sorted(ids) for ids in case.diagram.sides(name))
    report.check("sides", found == sides, lambda: f"sides({name}) = {found}, but {sides}")
    upright = {c.branch.id for c in case.curves if c.is_upright and name in c.branch.ends}
    ids = {t.curve.branch.id for t in tips} | upright
    report.check("incidence", ids == set(point.branches), lambda: f"{point} has the branches {ids}")
    if not point.exact["x"].is_finite:  # type: ignore[attr-defined]
        return
    x = float(sympy.N(point.exact["x"], 20))
    report.check("floats", abs(point.x - x) <= 1e-14 * max(1.0, abs(x)), lambda: f"{point}")
    orders = {case.diagram.branch(name).order for name in ids}
    complete = True
    for curve in case.curves:  # a jump of another order crosses the diagonal, it does not meet it
        if curve.is_upright or not (curve.is_fixed or curve.branch.order in orders):
            continue
        missed = curve.passes(p) and near(curve.x(number_of(p)), point.exact["x"])
        report.check("passing", not missed, lambda c=curve: f"{c} passes {_brief(point)}")
        complete = complete and not missed
    if complete:  # otherwise the kind is that of other branches
        _check_kind(case, point, p, tips, [c for c in case.curves if c.branch.id in upright])


def _check_kind(
    case: Case, point: SpecialPoint, p: Place, tips: Sequence[Tip], upright: Sequence[Curve]
) -> None:
    """The code and the note, by what brute force sees just beside."""
    family, found = case.family, (point.kind, point.note)
    expected: tuple[Any, ...]
    if p in family.span:
        expected = (PointKind.EP,)
    elif case.whole is not case.diagram:  # what a jump ends in may be a cycle that is not shown
        (same,) = (q for q in case.whole.points if q.exact == point.exact)
        expected = (same.kind, same.note)
    else:
        expected = _kind_inside(case, point, p, tips, upright)
    good = found[: len(expected)] == expected
    case.report.check("kinds", good, lambda: f"{point}: expected {expected}, tips {_told(tips)}")


def _brief(point: SpecialPoint) -> str:
    return f"{point.id} {point.note} at {point.exact['parameter']}, x = {point.exact['x']}"


def _told(tips: Sequence[Tip]) -> list[tuple[Any, ...]]:
    return [(t.curve.branch.kind.value, t.curve.branch.order, t.curve.word, t.side) for t in tips]


def _kind_inside(
    case: Case, point: SpecialPoint, p: Place, tips: Sequence[Tip], upright: Sequence[Curve]
) -> tuple[Any, ...]:
    fixed = [t for t in tips if t.curve.is_fixed]
    if not fixed and not upright:
        orders = Counter(t.curve.branch.order for t in tips if t.side)
        assert 2 not in orders.values(), f"{_brief(point)} is no point: {_told(tips)}"
        return PointKind.EP, "jumps meet" if max(orders.values()) > 2 else "the jump ends"
    order = min(c.branch.order for c in (*(t.curve for t in fixed), *upright))
    own = [t for t in fixed if t.curve.branch.order == order]
    if not own:
        return (PointKind.LP,)
    at = number_of(p)
    passing = {t.curve.key for t in own if t.side < 0} & {t.curve.key for t in own if t.side > 0}
    multipliers = [t.curve.multiplier(at) for t in own if t.curve.key in passing and _varies(t)]
    for unit, kind in ((-1, PointKind.PD), (1, PointKind.LP)):
        if any(m == unit for m in multipliers):
            return (kind,)
    left, right = (_seen(case.family, order, p, side, point.exact["x"]) for side in (-1, 1))
    if passing:
        staying = {word for _, word in passing}
        bands = any(curve.branch.order == order for curve in upright)
        sides, count = (left, right), len(tips) + len(upright)
        return PointKind.BC, _staying(case.family, order, at, staying, sides, count, bands)
    if left.any == right.any:
        alone = all(t.side == 0 for t in own)  # at this value only, on a jump that passes or not
        return PointKind.BC, "isolated" if alone else "persistence"
    beside = left if left.any else right
    isolated = all(
        t.curve.multiplier(at) is None or t.curve.multiplier(at) != 1 for t in own
    )  # no end of a band
    flips = len(beside.fixed) == 1 and isolated and beside.jumps and beside.doubled
    return PointKind.FF if flips else PointKind.BC, "fold"


def _staying(
    family: Family,
    order: int,
    at: Number,
    words: set[str],
    seen: tuple[Seen, Seen],
    branches: int,
    bands: bool,
) -> str:
    """The note where fixed points stay on a border."""
    base = family.at(at)
    parts = iterated(base, order)[-1]
    here = {f.stable for f in fixed_points(base, parts, order) if f.word in words}
    beside = [{stable for word, stable in side.fixed if word in words} for side in seen]
    others = [[word for word, _ in side.fixed if word not in words] for side in seen]
    ending = [bool(other or side.jumps) for other, side in zip(others, seen, strict=True)]
    notes = ["stability changes at the border"] if beside[0] != beside[1] else []
    if any(ending):
        notes.append(f"{'persistence' if all(ending) else 'fold'} at a branch on the border")
    elif bands and not notes:
        notes.append("an interval of fixed points ends at a branch on the border")
    elif branches > 2 * len(words):
        notes.append("higher orders end at a branch on the border")
    if here and beside[0] == beside[1] != here:  # the ends of bands are not among them
        notes.append("attracts at this value only" if True in here else "")
        notes[-1] = notes[-1] or "does not attract at this value"
    return ", ".join(notes)


def _varies(tip: Tip) -> bool:
    """Whether the multiplier depends on the parameter."""
    multiplier = quotient(tip.curve.stretch.exact["multiplier"])  # type: ignore[arg-type]
    return multiplier is not None and max(map(len, multiplier)) > 1


@dataclass(frozen=True)
class Seen:
    """What brute force finds near a point.

    Attributes
    ----------
    fixed
        Words of the fixed points, and whether they attract.
    jumps
        How many jumps cross the diagonal.
    doubled
        How many of twice the order do that where the map leads to one of these.
    """

    fixed: tuple[tuple[str, bool], ...]
    jumps: int
    doubled: int

    @property
    def any(self) -> bool:
        """Whether there is something of the order itself."""
        return bool(self.fixed or self.jumps)


def _seen(family: Family, order: int, p: Place, side: int, position: Any) -> Seen:
    """At a parameter just beside; far closer where both numbers are rational."""
    digits = 300 if isinstance(p, Fraction) and position.is_Rational else 16
    x = rational(sympy.N(position, DIGITS) if digits == 16 else position)
    size, step = Fraction(1, 10**digits), Fraction(side, 10 ** (2 * digits))
    at = (rational_near(p) if isinstance(p, Root) else p) + step
    iterates = iterated(family.at(at), 2 * order)
    parts, doubled = iterates[order - 1], iterates[2 * order - 1]
    fixed = [
        (f.x, f.word, f.stable)
        for f in fixed_points(iterates[0], parts, order)
        if f.period == order
    ]
    for band in (part for part in parts if part.is_identity):  # its ends, if they belong to it
        fixed += [(band.lo, band.word, False)] * band.lo_in
        fixed += [(band.hi, band.word, False)] * band.hi_in
    jumps = [c.x for c in crossings(parts) if abs(c.x - x) < size]
    others = [
        c.x
        for c in crossings(doubled)
        if abs(c.x - x) < size and any(q.holds(c.x) and q(c.x) in jumps for q in parts)
    ]
    found = tuple((word, stable) for at_x, word, stable in fixed if abs(at_x - x) < size)
    return Seen(found, len(jumps), len([c for c in others if c not in jumps]))
