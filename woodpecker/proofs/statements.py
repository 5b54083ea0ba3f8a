"""Contents of certificates for computed orbits, branches and points, one function each."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise

import numpy as np
from flint import arb

from pwmap.algebra.arguments import check_functions
from pwmap.diagrams.diagram import Branch, BranchKind, PointKind, SpecialPoint
from woodpecker.base.checks import interval
from woodpecker.base.executors import processes
from woodpecker.enclosures.forms import precision
from woodpecker.enclosures.model import rational
from woodpecker.enclosures.not_proved import NotProved
from woodpecker.mechanics.toy import Toy
from woodpecker.proofs import certificates
from woodpecker.proofs.branches import SHORTEST, PieceEnd, Tell, end_of, joined, prove_along
from woodpecker.proofs.certificates import Content
from woodpecker.proofs.pieces import Fractions, Route, Tube, curves_near, proved
from woodpecker.proofs.points import proved_point
from woodpecker.runs import nothing
from woodpecker.shooting import PeriodicOrbit, shoot

ORBIT, BRANCH, POINT = (140, 40), (128, 35), (160, 48)  # bits of balls, and decimal digits with
# which the checker computes
ENCLOSURE_RADIUS = Fraction(1, 10**22)  # radius of the tubes that hold an orbit [rad]
# Radii of tubes tried for uniqueness [rad]; the largest that is proved counts.
UNIQUENESS_RADII = [Fraction(n, 10**k) for k in range(3, 20) for n in (5, 2, 1)]
AT = "eps_n1"  # the parameter that a certificate of an orbit names


def prove_orbit(orbit: PeriodicOrbit) -> Content:
    """Content for an orbit: exactly one cycle near it."""
    if not orbit.success:
        raise ValueError(f"only a periodic orbit can be proved, got one with: {orbit.message}")
    toy, points = orbit.toy, orbit.points[: orbit.minimal_period]
    line = Route((rational(getattr(toy, AT)),), Fraction(0))
    with precision(ORBIT[0]):
        curves = curves_near(toy, AT, line, [[arb(x)] for x in points], 1)
        inner = proved(toy, AT, line, [Tube(curve, ENCLOSURE_RADIUS) for curve in curves])
        outer = inner
        for radius in UNIQUENESS_RADII:
            try:
                outer = proved(toy, AT, line, [Tube(curve, radius) for curve in curves])
                break
            except NotProved:
                continue
        return certificates.of_orbit(toy, AT, outer, inner, ORBIT[1])


def prove_branch(
    branch: Branch, span: tuple[float, float] | None, toy: Toy, parameter: str,
    progress: Tell, workers: int,
) -> Content:  # fmt: skip
    """Content for a branch of fixed points over a span; each worker proves a part of it."""
    if branch.kind is not BranchKind.FIXED_POINT:
        raise ValueError(f"only branches of fixed points can be proved, got {branch.kind.value}")
    if isinstance(workers, bool) or not isinstance(workers, int) or workers < 1:
        raise ValueError(f"workers must be a whole number from 1 on, got {workers!r}")
    if span is None:
        raise ValueError("a branch is proved over a span, got none")
    check_functions(progress=progress)
    low, high = interval("span", span, finite=True)
    if not branch.parameter.min() <= low <= branch.parameter.max():
        raise ValueError(f"span must begin on the branch and ascend, got {(low, high)}")
    if high > 1.0:
        raise ValueError(f"span must lie in [0, 1], as {parameter} does, got {(low, high)}")
    if high - low < SHORTEST:
        raise ValueError(f"span must be {float(SHORTEST)} long at least, got {(low, high)}")
    spans = parts_of(Fractions(rational(low), rational(high)), workers)
    starts = _starts(toy, parameter, branch, [part.low for part in spans])
    tasks = [(toy, parameter, part, points) for part, points in zip(spans, starts, strict=True)]
    if workers == 1:
        return _march(tasks[0], progress)[0]
    with processes(workers) as pool:
        parts = list(map(_march, tasks) if pool is None else pool.map(_march, tasks))
    for (_, _, before), (_, after, _) in pairwise(parts):
        if not joined(before, after):
            at = f"{parameter} = {float(after.p):.12g}"
            raise NotProved(f"two parts may hold different cycles at {at}")
    return certificates.merged([part for part, _, _ in parts])


def parts_of(span: Fractions, count: int) -> list[Fractions]:
    """Equal parts of a span, in ascending order."""
    ends = [span.low + span.length * k / count for k in range(count + 1)]
    return [Fractions(*each) for each in pairwise(ends)]


def _starts(
    toy: Toy, parameter: str, branch: Branch, values: Sequence[Fraction]
) -> list[tuple[float, ...]]:
    """The cycle at each value: shot from the nearest point of the branch, or from the last one."""
    found, x, at = [], 0.0, 0.0
    for value in values:
        p = float(value)
        on = (branch.parameter.min(), branch.parameter.max())
        if on[0] <= p <= on[1]:
            k = int(np.abs(branch.parameter - p).argmin())
            x, at = float(branch.x[k]), float(branch.parameter[k])
        for step in np.linspace(at, p, 40)[1:] if at != p else [p]:
            orbit = shoot(toy.replace(**{parameter: float(step)}), x, branch.order)
            if orbit.success:
                x = orbit.phi_s
        if not orbit.success:
            raise NotProved(f"no cycle was found at {parameter} = {p}: {orbit.message}")
        found.append(orbit.points[: orbit.minimal_period])
        at = p
    return found


Task = tuple[Toy, str, Fractions, tuple[float, ...]]


def _march(task: Task, progress: Tell = nothing) -> tuple[Content, PieceEnd, PieceEnd]:
    """Content for a part of a branch, and its low and high end."""
    toy, parameter, span, points = task
    with precision(BRANCH[0]):
        found = prove_along(toy, parameter, span, points, progress)
        content = certificates.of_branch(found, BRANCH[1])
        return content, end_of(found.pieces[0], -1), end_of(found.pieces[-1], 1)


def prove_point(point: SpecialPoint, toy: Toy, parameter: str) -> Content:
    """Content for a border collision of P_1 at a jump."""
    if point.kind not in (PointKind.BC, PointKind.FF) or point.order != 1:
        raise ValueError(
            f"only border collisions of P_1 can be proved, got {point.kind.value} of order "
            f"{point.order}"
        )
    if not math.isfinite(point.parameter + point.x):
        raise ValueError(f"a point must have finite values, got {point.parameter} and {point.x}")
    with precision(POINT[0]):
        return proved_point(toy, parameter, point.parameter, point.x, POINT[1])
