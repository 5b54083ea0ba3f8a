"""Special points of a diagram: ends, incidence, sides and kinds, by brute force beside them."""

from __future__ import annotations

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

    @property
    def point(self) -> str:
        """Id of the point it ends in."""
        return self.curve.branch.ends[self.end]


def check_points(case: Case) -> None:
    """Ends, incidence, sides and kinds."""
    report, diagram = case.report, case.diagram
    tips = [
        Tip(c, end, (c.lo, c.hi)[end], c.limit(end))
        for c in case.curves
        if not c.is_upright
        for end in (0, 1)
    ]
    at_point: dict[str, list[Tip]] = {point.id: [] for point in diagram.points}
    for tip in tips:
        at_point[tip.point].append(tip)
        point = diagram.point(tip.point)
        good = compared(tip.p, place(point.exact["parameter"])) == 0 and near(
            tip.x, point.exact["x"]
        )
        report.check(
            "ends", good, lambda t=tip, q=point: f"{t.curve.branch.id} ends at {t.x}, not at {q}"
        )
    for point in diagram.points:
        _check_point(case, point, at_point[point.id])
    points = [(place(point.exact["parameter"]), point) for point in diagram.points]
    for (p, first), (q, second) in pairwise(points):
        same = compared(p, q) == 0 and first.exact["x"] == second.exact["x"]
        report.check("incidence", not same, lambda a=first, b=second: f"{a.id} and {b.id} are one")


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
    complete = True
    for curve in case.curves:
        if (
            not curve.is_upright
            and curve.passes(p)
            and near(curve.x(number_of(p)), point.exact["x"])
        ):
            what = "fixed" if curve.is_fixed else "jump"
            by = "fixed" if any(t.curve.is_fixed for t in tips) or upright else "jumps"
            report.check(
                f"incidence: {what} passes an end of {by}",
                False,
                lambda c=curve: f"{c} passes through {_brief(point)} unattached",
            )
            complete = False
    if complete:  # otherwise the kind is that of other branches
        _check_kind(case, point, p, tips, [c for c in case.curves if c.branch.id in upright])


def _check_kind(
    case: Case, point: SpecialPoint, p: Place, tips: Sequence[Tip], upright: Sequence[Curve]
) -> None:
    """The code and the note, by what brute force sees just beside."""
    family, found = case.family, (point.kind, point.note)
    if p in family.span:
        expected: tuple[Any, ...] = (PointKind.EP,)
    else:
        expected = _kind_inside(case, point, p, tips, upright)
    good = found[: len(expected)] == expected
    case.report.check("kinds", good, lambda: f"{point}: expected {expected}, tips {_told(tips)}")


def _brief(point: SpecialPoint) -> str:
    return f"{point.id} {point.note} at {point.exact['parameter']}, x = {point.exact['x']}"


def _told(tips: Sequence[Tip]) -> list[tuple[Any, ...]]:
    return [
        (t.curve.branch.kind.value, t.curve.branch.order, t.curve.branch.word, t.side) for t in tips
    ]


def _kind_inside(
    case: Case, point: SpecialPoint, p: Place, tips: Sequence[Tip], upright: Sequence[Curve]
) -> tuple[Any, ...]:
    fixed = [t for t in tips if t.curve.is_fixed]
    if not fixed and not upright:
        return (PointKind.WC,)
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
        return PointKind.BC, "stability changes at the border"
    if left.any and right.any:
        return PointKind.BC, "persistence"
    if not left.any and not right.any:
        return PointKind.BC, "isolated"
    beside, other = (left, right) if left.any else (right, left)
    if beside.fixed == 1 and beside.jumps and beside.doubled > other.doubled:
        return PointKind.FF, "fold"
    return PointKind.BC, "fold"


def _varies(tip: Tip) -> bool:
    """Whether the multiplier depends on the parameter."""
    multiplier = quotient(tip.curve.branch.exact["multiplier"])  # type: ignore[arg-type]
    return multiplier is not None and max(map(len, multiplier)) > 1


@dataclass(frozen=True)
class Seen:
    """How much brute force finds near a point.

    Doubled are the jumps of twice the order that are no breaks of the order itself.
    """

    fixed: int
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
    fixed = [f.x for f in fixed_points(iterates[0], parts, order) if f.period == order]
    bands = [part for part in parts if part.is_identity]  # listed are the ends that belong to them
    fixed += [band.lo for band in bands if band.lo_in] + [band.hi for band in bands if band.hi_in]
    fixed = [end for end in fixed if abs(end - x) < size]
    jumps = [c.x for c in crossings(parts) if abs(c.x - x) < size]
    cuts = [part.lo for part in parts if part.lo is not None]
    others = [c.x for c in crossings(doubled) if abs(c.x - x) < size and c.x not in cuts]
    return Seen(len(fixed), len(jumps), len(others))
