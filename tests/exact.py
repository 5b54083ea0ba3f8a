"""Random maps that pwmap solves exactly, to compare a computed diagram with the proved one.

Slopes are numbers, offsets and breaks affine in p. So every branch is a straight line over p, and
one value between its ends distinguishes it from all others.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise, product
from random import Random

import numpy as np
from families import family

from pwmap import Branch, BranchKind, Diagram, PiecewiseLinearMap, PointKind, SpecialPoint
from pwmap import bifurcation_diagram as exact_diagram

SPAN = (-1, 1)  # of p; breaks keep their order for twice that
FARTHEST = 20.0  # no branch of a case lies farther away
AGREES = 1e-9  # relative to 1 or a larger value: special points are located far better
SLOPES = sorted({Fraction(n, d) for d in (3, 4, 5, 7) for n in range(1 - 3 * d, 3 * d)})


# --- Random maps ----------------------------------------------------------------------------------


def random_map(rng: Random) -> PiecewiseLinearMap:
    """A map with one parameter p: two or three pieces; a third of them continuous.

    No cycle of up to four points has a multiplier of 1 or -1, for those would not be isolated.
    Offsets and breaks are (constant, rate): affine in p.
    """
    slopes = _slopes(rng, rng.choice([2, 2, 3]))
    breaks = [(_number(rng, 1), rng.choice([Fraction(0), _number(rng, 1)]))]
    for _ in slopes[2:]:
        gap, rate = Fraction(rng.randint(50, 150), 100), Fraction(rng.choice([0, 0, 1, -1]), 8)
        breaks.append((breaks[-1][0] + gap, breaks[-1][1] + rate))
    offsets = [(_number(rng, 2), rng.choice([Fraction(1), _number(rng, 2)]))]
    continuous = rng.random() < 1.0 / 3.0
    for at, left, right in zip(breaks, slopes[:-1], slopes[1:], strict=True):
        offsets.append(
            tuple(offset + (left - right) * b for offset, b in zip(offsets[-1], at, strict=True))
            if continuous
            else (_number(rng, 2), rng.choice([offsets[-1][1], _number(rng, 2)]))
        )
    owners = "".join(rng.choice("lr") for _ in breaks)
    formulas = [((slope,), offset) for slope, offset in zip(slopes, offsets, strict=True)]
    return family(breaks, owners, formulas, span=(-2, 2), orders=(), assumes=True).map()


def _number(rng: Random, size: int) -> Fraction:
    """A rational that is rarely special."""
    return Fraction(rng.randint(-100 * size, 100 * size), 100) + Fraction(rng.randint(1, 6), 700)


def _slopes(rng: Random, n: int) -> list[Fraction]:
    while True:
        found = [rng.choice(SLOPES) for _ in range(n)]
        multipliers = (math.prod(word) for k in range(1, 5) for word in product(found, repeat=k))
        if all(found) and not any(abs(multiplier) == 1 for multiplier in multipliers):
            return found


def random_case(rng: Random, orders: Sequence[int]) -> tuple[PiecewiseLinearMap, Diagram]:
    """A random map and its exact diagram over ``SPAN``.

    Something happens inside the span, and no branch goes far away.
    """
    while True:
        map_ = random_map(rng)
        diagram = exact_diagram(map_, "p", SPAN, orders=orders)
        far = max((np.abs(branch.x).max() for branch in diagram.branches), default=0.0)
        if far <= FARTHEST and any(point.kind is not PointKind.EP for point in diagram.points):
            return map_, diagram


# --- Comparison -----------------------------------------------------------------------------------


def essential(exact: Diagram) -> Diagram:
    """An exact diagram without the kinks at which nothing happens to fixed points.

    There just two branches of one order meet (BC, persistence) that both attract, or neither.
    """
    branches, points = list(exact.branches), list[SpecialPoint]()
    for point in exact.points:
        meeting = [branch for branch in branches for end in branch.ends if end == point.id]
        if _passes(point, meeting):
            rest = [branch for branch in branches if branch not in meeting]
            branches = [*rest, _joined(*meeting, point.id)]
        elif meeting:
            points.append(point)
    return replace(exact, branches=tuple(branches), points=tuple(points))


def _passes(point: SpecialPoint, meeting: Sequence[Branch]) -> bool:
    """Whether two branches meet that are one but for their words."""
    if point.kind is not PointKind.BC or point.note != "persistence" or len(meeting) != 2:
        return False
    one, other = meeting
    fixed = one.kind is other.kind is BranchKind.FIXED_POINT and one.order == other.order
    attract = {bool(branch.stable[-branch.ends.index(point.id)]) for branch in meeting}
    return fixed and len(attract) == 1 and one is not other


def _joined(one: Branch, other: Branch, name: str) -> Branch:
    """Two branches that meet in a point as one branch."""
    to = slice(None, None, 1 if one.ends[1] == name else -1)
    on = slice(None, None, 1 if other.ends[0] == name else -1)
    parameter, x, multiplier = (
        np.append(getattr(one, column)[to], getattr(other, column)[on][1:])
        for column in ("parameter", "x", "multiplier")
    )
    return Branch(
        id=f"{one.id}+{other.id}", kind=one.kind, order=one.order, word=one.word,
        ends=(one.ends[to][0], other.ends[on][1]), parameter=parameter, x=x, multiplier=multiplier,
    )  # fmt: skip


def same_graph(numeric: Diagram, exact: Diagram, tolerance: float = AGREES) -> list[str]:
    """What differs between a computed diagram and the essential part of the exact one.

    Special points are matched by their places and must be of one kind; branches by the points they
    end in, their kind, order and course. Nothing may be left over on either side.

    Returns
    -------
    Sentences; none if the graphs are the same.
    """
    proved, said = essential(exact), list[str]()
    names, points, branches = dict[str, str](), list(proved.points), list(proved.branches)
    for point in numeric.points:
        near = min(points, key=lambda other: _apart(point, other), default=None)
        if near is None or not _apart(point, near) <= tolerance:
            said.append(f"{point} is computed only")
            continue
        points.remove(near)
        names[point.id] = near.id
        if _coded(point) != _coded(near):
            said.append(f"{point} is computed where {near} is proved")
    for branch in numeric.branches:
        found = next((each for each in branches if _same(branch, names, each, tolerance)), None)
        if found is None:
            said.append(f"{branch} is computed only")
        else:
            branches.remove(found)
    return said + [f"{each} is proved only" for each in (*points, *branches)]


def _apart(one: SpecialPoint, other: SpecialPoint) -> float:
    """Distance of two points, relative to 1 or their own size."""
    pairs = ((one.parameter, other.parameter), (one.x, other.x))
    return max(abs(a - b) / max(1.0, abs(b)) for a, b in pairs)


def _coded(point: SpecialPoint) -> tuple[object, ...]:
    """What a point is; an end of a branch is one for many reasons."""
    return (point.kind, *((point.order, point.note) if point.kind is not PointKind.EP else ()))


def _same(branch: Branch, names: Mapping[str, str], other: Branch, tolerance: float) -> bool:
    """Whether a computed branch is a proved one, whose points have these names."""
    if (branch.kind, branch.order) != (other.kind, other.order):
        return False
    if sorted(names.get(end, "") for end in branch.ends) != sorted(other.ends):
        return False
    # how far the parameter goes along a branch, back and forth
    ways = [float(np.abs(np.diff(each.parameter)).sum()) for each in (branch, other)]
    if abs(ways[0] - ways[1]) > tolerance * len(branch):
        return False
    middles = (0.5 * (values[1:] + values[:-1]) for values in (other.parameter, other.x))
    return all(
        _distance(branch, p, x) <= tolerance * max(1.0, abs(x))
        for p, x in zip(*(values.tolist() for values in middles), strict=True)
    )


def _distance(branch: Branch, p: float, x: float) -> float:
    """Smallest distance in x from a point to the line between samples; inf if there is none."""
    away = math.inf
    samples = zip(branch.parameter.tolist(), branch.x.tolist(), strict=True)
    for (a, y), (b, z) in pairwise(samples):
        if min(a, b) <= p <= max(a, b):
            part = (p - a) / (b - a) if a != b else 0.0
            away = min(away, abs(y + part * (z - y) - x))
    return away
