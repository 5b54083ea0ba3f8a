"""Whole diagrams of some iterates, and checks that do not use how they were found.

Between the parameters at which branches end, slices count fixed points, and plain tabulation of P_j
shows where P_j(x) - x changes its sign: at a fixed point or a jump that the diagram must contain.
Every sample of every branch of fixed points is simulated again.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from pwmap import Branch, BranchKind, Diagram
from studies.common.clocks import Seconds, timed
from studies.common.motion import GUESS
from studies.common.record import Results
from woodpecker import (
    ExpansionFriction,
    Search,
    Settings,
    Toy,
    ToyPieces,
    first_return,
    slices_at,
)
from woodpecker.base.arrays import Floats
from woodpecker.diagrams import bifurcation_search
from woodpecker.search import Found

ASKED = 1e-11  # rad: the residual that is asked for
ROUNDING = 2.0**-52  # relative
KERNEL = 1e-12, 1e-13  # rad: what the kernel promises, alone and for each unit of slope
CHORD = 1e-3  # rad: branches bend less between samples: max_step * max_turn / 8 of the window
AWAY = 1e-6  # in eps_N1: how far a slice keeps from the ends of branches


class Part(NamedTuple):
    """Which part of a diagram is looked at, and how closely."""

    span: tuple[float, float]  # of eps_N1
    window: tuple[float, float]  # of phi_S [rad]
    search: Search
    slices: int = 0  # in which fixed points are counted
    table: int = 40_001  # starts of the tabulation in each of them
    law: ExpansionFriction = ExpansionFriction.SUMMED

    def toy(self, eps_n1: float = 0.5) -> Toy:
        """The toy under the law of this part."""
        return Toy(eps_n1=eps_n1, expansion_friction=self.law)


def searched(part: Part, orders: tuple[int, ...]) -> tuple[Found, Seconds]:
    """The diagram, and what it took once everything is compiled."""
    first_return(part.toy(), GUESS)
    return timed(
        lambda: bifurcation_search(
            part.toy(), "eps_n1", part.span, orders, part.window, search=part.search
        )
    )


def examined(part: Part, order: int, found: Found, taken: Seconds) -> Results:
    """What was found up to P_j, in numbers, and what the checks of P_j say.

    Returns
    -------
    dict
        ``law``; ``first_slices``: how many slices the search began with; ``span``, ``window``;
        ``table``: starts of a tabulation; ``branches``, ``points``: how many by kind and order;
        ``slices``, ``unresolved``, ``not_followed``, ``evaluations``, ``seconds``: of the search;
        ``seen``: see :class:`Seen`;
        ``odd``: parameters of slices that do not agree with the diagram; ``residuals``,
        ``residuals_at_ends``: see :func:`summary`.
    """
    seen = [counted(found.diagram, part, order, p) for p in between(found.diagram, part.slices)]
    return {
        "law": str(part.law),
        "first_slices": part.search.slices,
        "span": part.span,
        "window": part.window,
        "table": part.table,
        "seconds": taken._asdict(),
        **tally(found),
        "seen": [slice_._asdict() for slice_ in seen],
        "odd": [slice_.eps_n1 for slice_ in seen if not slice_.agrees],
        "residuals": summary(residuals(found.diagram, part, ends=False)),
        "residuals_at_ends": summary(residuals(found.diagram, part, ends=True)),
    }


def tally(found: Found) -> Results:
    """What was found, in numbers."""
    diagram = found.diagram
    branches = Counter(f"{branch.kind} of P_{branch.order}" for branch in diagram.branches)
    points = Counter(f"{point.kind} of P_{point.order}" for point in diagram.points)
    return {
        "branches": dict(sorted(branches.items())),
        "points": dict(sorted(points.items())),
        "slices": len(found.slices),
        "unresolved": max(seen.unresolved for seen in found.slices),
        "not_followed": not_followed(found),
        "evaluations": found.evaluations,
    }


def not_followed(found: Found) -> list[tuple[float, int, float]]:
    """Parameter, order and x of everything that a slice shows and no branch explains."""
    return [(seen.p, *place) for seen in found.slices for place in seen.left]


# --- Slices ---------------------------------------------------------------------------------------


class Seen(NamedTuple):
    """Fixed points of P_j of minimal period j at one parameter, and jumps of P_j."""

    eps_n1: float
    fixed_points: int  # all points of each cycle, in a slice
    drawn: int  # of the diagram
    missing: int  # fixed points beside which the diagram has none
    crossings: int  # jump crossings of P_j, in a slice
    drawn_crossings: int
    changes: int  # of the sign of P_j(x) - x in the table
    unexplained: int  # where the diagram has neither a fixed point nor a jump

    @property
    def agrees(self) -> bool:
        """Whether the diagram has every point of every cycle, and nothing else."""
        return self.missing == self.unexplained == 0 and self.fixed_points == self.drawn


def between(diagram: Diagram, count: int) -> list[float]:
    """Parameters between neighbouring special points: as many in each gap, or in every n-th gap."""
    marks = np.unique([point.parameter for point in diagram.points])
    gaps = [(a, b) for a, b in pairwise(marks.tolist()) if b - a > 2.0 * AWAY]
    places = (np.arange(count) + 0.5) * len(gaps) / count  # in gaps, counted from the left
    low, high = np.array(gaps)[places.astype(int)].T
    part = AWAY / (high - low)
    found: list[float] = (low + np.clip(places % 1.0, part, 1.0 - part) * (high - low)).tolist()
    return found


def counted(diagram: Diagram, part: Part, order: int, eps_n1: float) -> Seen:
    """The fixed points of P_j at one parameter, from a slice and a table."""
    map_, settings = ToyPieces(part.toy()), Settings(window=part.window)
    (slice_,) = slices_at(map_, eps_n1, (order,), settings)
    points = np.sort(np.concatenate([np.empty(0), *(cycle.x for cycle in slice_.cycles)]))
    hits = diagram.at(eps_n1)
    drawn = np.array([
        hit.x for hit in hits
        if (hit.branch.kind, hit.branch.order) == (BranchKind.FIXED_POINT, order)
    ])  # fmt: skip
    jumps = [hit for hit in hits if (hit.branch.kind, hit.branch.order) == (BranchKind.JUMP, order)]
    explained = np.array([hit.x for hit in hits if order % hit.branch.order == 0])
    changes = sign_changes(map_, part, order, eps_n1)
    return Seen(
        eps_n1=eps_n1,
        fixed_points=len(points),
        drawn=len(drawn),
        missing=len(points) - paired(points, np.sort(drawn)),
        crossings=len(slice_.jumps),
        drawn_crossings=len(jumps),
        changes=len(changes),
        unexplained=int(sum(np.abs(explained - x).min(initial=math.inf) > CHORD for x in changes)),
    )


def paired(points: Floats, drawn: Floats) -> int:
    """How many of some points have one beside them that is theirs alone; both ascending."""
    count = k = 0
    for x in points:
        while k < len(drawn) and drawn[k] < x - CHORD:
            k += 1
        if k < len(drawn) and drawn[k] <= x + CHORD:
            count, k = count + 1, k + 1
    return count


def sign_changes(map_: ToyPieces, part: Part, order: int, eps_n1: float) -> Floats:
    """Where P_j(x) - x changes its sign on a grid, of orbits that stay in the window."""
    low, high = part.window
    x = np.linspace(low, high, part.table)
    image = x
    for _ in range(order):
        (inside,) = np.nonzero((low <= image) & (image <= high))
        kept, image = image[inside], np.full(part.table, math.nan)
        image[inside] = map_.sweep(kept, eps_n1).value
    gap = image - x
    (k,) = np.nonzero(gap[1:] * gap[:-1] < 0.0)
    found: Floats = 0.5 * (x[k] + x[k + 1])
    return found


# --- Residuals ------------------------------------------------------------------------------------


class Residual(NamedTuple):
    """|P_1(x_i) - x_(i+1)| of one sample of a branch, each return simulated once more: the largest.

    Of P_j itself nothing could be told: slopes are up to 1e23.
    """

    eps_n1: float
    phi_s: float
    size: float  # rad
    slope: float  # of the steepest return
    rounding: float  # what rounding of one point of the orbit grows to in a return [rad]


def residuals(diagram: Diagram, part: Part, ends: bool) -> list[Residual]:
    """The first and last samples of all branches of fixed points, or all others."""
    rounds = defaultdict[tuple[int, bytes], list[Branch]](list)  # branches that one cycle makes
    for branch in diagram.branches:
        if branch.kind is BranchKind.FIXED_POINT:
            rounds[branch.order, branch.parameter.tobytes()].append(branch)
    found = []
    for own in rounds.values():
        last = len(own[0]) - 1
        for k in sorted({0, last}) if ends else range(1, last):
            x = np.array([float(branch.x[k]) for branch in own])
            toy = part.toy(float(own[0].parameter[k]))
            found += [residual(toy, own[0].order, start, x) for start in x.tolist()]
    return found


def residual(toy: Toy, order: int, start: float, points: Floats) -> Residual:
    """How far the returns from the points of a cycle are from its next points."""
    x, sizes, slopes, grown = start, [], [], []
    for i in range(order):
        once = first_return(toy, x)
        if not once.status.success:
            return Residual(toy.eps_n1, start, math.nan, math.inf, math.inf)
        last = i == order - 1
        to = start if last else float(points[np.abs(points - once.phi_s).argmin()])
        sizes.append(abs(once.phi_s - to))
        if math.isfinite(once.slope):
            slopes.append(abs(once.slope))
            grown.append(ROUNDING * abs(x * once.slope))
        x = to
    steepest, most = max(slopes, default=math.inf), max(grown, default=math.inf)
    return Residual(toy.eps_n1, start, max(sizes), steepest, most)


def summary(found: list[Residual]) -> Results:
    """The largest residual, how many are above 1e-11, and whether that must be.

    Returns
    -------
    dict
        ``samples``; ``lost``: how many do not return; ``largest`` one; ``above``: how many exceed
        1e-11; ``flattest_above``: the smallest slope at which one does, None if none does;
        ``beyond_rounding``: how many of these exceed four times the contribution of rounding;
        ``beyond_kernel``: how many exceed what the kernel promises.
    """
    kept = [each for each in found if math.isfinite(each.size)]
    above = [each for each in kept if each.size > ASKED]
    largest = max(kept, key=lambda each: each.size, default=None)
    return {
        "samples": len(found),
        "lost": len(found) - len(kept),
        "largest": largest._asdict() if largest is not None else None,
        "above": len(above),
        "flattest_above": min((each.slope for each in above), default=None),
        "beyond_rounding": sum(each.size > 4.0 * each.rounding for each in above),
        "beyond_kernel": sum(each.size > KERNEL[0] + KERNEL[1] * each.slope for each in above),
    }
