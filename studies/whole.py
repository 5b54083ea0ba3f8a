"""Whole diagrams of some iterates, and checks that know nothing of how they were found.

Fixed points are counted in slices between the parameters at which branches end, and every sample of
every branch of fixed points is simulated once more. Cycles steeper than ``Settings.steepest`` are
not part of a diagram: rounding alone moves them by more than 1e-11.
"""

from __future__ import annotations

import math
from collections import Counter
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from clocks import Seconds, clocked
from record import Results

from pwmap import Branch, BranchKind, Diagram
from woodpecker import (
    Cycle,
    ExpansionFriction,
    Found,
    Search,
    Settings,
    Toy,
    find_all,
    first_return,
    iterated,
    slice_of,
    toy_map,
    toy_samples,
)
from woodpecker.diagram import MARGIN
from woodpecker.piecewise.maps import SEPARATOR, evaluate, minimal_period, windowed
from woodpecker.piecewise.slices import Slicer

ASKED = 1e-11  # rad: the residual that is asked for
ROUNDING = 2.0**-52  # relative
KERNEL = 1e-12, 1e-13  # rad: what the kernel promises, alone and for each unit of slope
PAIRED = 1e-9  # rad: a cycle that was found from two of its points
SAME = 1e-6  # rad: a cycle that goes round a shorter one; a point that was found twice
AWAY = 1e-6  # in eps_N1: how far a slice keeps from the ends of branches


class Part(NamedTuple):
    """Which part of a diagram is looked at, and how closely."""

    span: tuple[float, float]  # of eps_N1
    window: tuple[float, float]  # of phi_S [rad]
    search: Search
    slices: int  # in which fixed points are counted
    law: ExpansionFriction = ExpansionFriction.SUMMED

    def toy(self, eps_n1: float = 0.5) -> Toy:
        """The toy under the law of this part."""
        return Toy(eps_n1=eps_n1, expansion_friction=self.law)


def searched(part: Part, orders: tuple[int, ...]) -> tuple[Found, Seconds]:
    """The diagram, and what it took once everything is compiled."""
    first_return(part.toy(), -0.53)
    kept: list[Found] = []
    taken = clocked(
        lambda: kept.append(
            find_all(part.toy(), "eps_n1", part.span, orders, part.window, search=part.search)
        )
    )()
    return kept[0], taken


def examined(part: Part, order: int, found: Found, taken: Seconds) -> Results:
    """What was found up to P_j, in numbers, and what the checks of P_j say.

    Returns
    -------
    dict
        ``law``; ``first_slices``: how many slices the search began with; ``span``, ``window``;
        ``branches``, ``points``: how many by kind and order; ``slices``, ``steep``,
        ``not_followed``, ``evaluations``, ``seconds``: of the search; ``seen``: see :class:`Seen`;
        ``odd``: parameters of slices that do not agree with the diagram; ``residuals``,
        ``residuals_at_ends``: see :func:`summary`.
    """
    seen = [counted(found.diagram, part, order, p) for p in between(found.diagram, part.slices)]
    return {
        "law": str(part.law),
        "first_slices": part.search.slices,
        "span": part.span,
        "window": part.window,
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
        "slices": {f"P_{report.order}": len(report.slices) for report in found.reports},
        "steep": {f"P_{report.order}": report.steep for report in found.reports},
        "not_followed": [place for report in found.reports for place in report.not_followed],
        "evaluations": found.evaluations,
    }


# --- Slices ---------------------------------------------------------------------------------------


class Seen(NamedTuple):
    """Fixed points of P_j of minimal period j in one slice."""

    eps_n1: float
    fixed_points: int  # all points of each cycle
    drawn: int  # of the diagram, at the same parameter
    missing: int  # fixed points for which no branch of their word is left
    sampled: int  # fixed points that a search of P_j itself finds, piece by piece of 1e-6 rad
    only_sampled: int  # and that are not among the cycles
    crossings: int  # jump crossings of P_j
    drawn_crossings: int

    @property
    def agrees(self) -> bool:
        """Whether the diagram has every point of every cycle, and nothing else."""
        return self.missing == 0 and self.fixed_points == self.drawn


def between(diagram: Diagram, count: int) -> list[float]:
    """Parameters in the middle between neighbouring special points, evenly chosen."""
    marks = sorted({point.parameter for point in diagram.points})
    middles = [0.5 * (a + b) for a, b in pairwise(marks) if b - a > 2.0 * AWAY]
    chosen = np.linspace(0, len(middles) - 1, min(count, len(middles))).round().astype(int)
    return [middles[k] for k in chosen]


def counted(diagram: Diagram, part: Part, order: int, eps_n1: float) -> Seen:
    """The fixed points of P_j at one parameter, from slices that know nothing of branches."""
    toy, settings = part.toy(eps_n1), Settings(window=part.window)
    low, high = part.window
    labelled = windowed(toy_map(toy), (low - MARGIN, high + MARGIN))
    samples = toy_samples(toy)
    slicer = Slicer(labelled, samples, settings, part.search.resolution)
    (slice_,) = slicer.take(eps_n1, (order,))
    cycles = unique([c for c in slice_.cycles if minimal_period(c, SAME) == order])
    points = [(float(cycle.x[k]), word_from(cycle, k)) for cycle in cycles for k in range(order)]
    direct = slice_of(
        iterated(samples, order, part.window), eps_n1, part.window, part.search.resolution
    )
    orbits = [evaluate(labelled, orbit(toy, x, order), eps_n1) for x, _ in direct.fixed_points]
    sampled = [
        float(cycle.x[0])
        for cycle in orbits
        if minimal_period(cycle, SAME) == order and cycle.steepness <= settings.steepest
    ]
    hits = [hit for hit in diagram.at(eps_n1) if hit.branch.order == order]
    drawn = Counter(h.branch.word for h in hits if h.branch.kind is BranchKind.FIXED_POINT)
    return Seen(
        eps_n1=eps_n1,
        fixed_points=len(points),
        drawn=drawn.total(),
        missing=(Counter(word for _, word in points) - drawn).total(),
        sampled=len(sampled),
        only_sampled=sum(all(abs(x - y) > SAME for y, _ in points) for x in sampled),
        crossings=len(slice_.jumps),
        drawn_crossings=sum(hit.branch.kind is BranchKind.JUMP for hit in hits),
    )


def orbit(toy: Toy, x: float, laps: int) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """The first points of an orbit."""
    points = [x]
    while len(points) < laps:
        points.append(first_return(toy, points[-1]).phi_s)
    return np.array(points)


def unique(cycles: list[Cycle]) -> list[Cycle]:
    """Each cycle once, whichever of its points it was found from."""
    kept: list[tuple[float, str, Cycle]] = []
    for cycle in cycles:
        first = int(cycle.x.argmin())
        x, word = float(cycle.x[first]), word_from(cycle, first)
        if all(word != other or abs(x - y) > PAIRED for y, other, _ in kept):
            kept.append((x, word, cycle))
    return [cycle for *_, cycle in kept]


def word_from(cycle: Cycle, k: int) -> str:
    """The word of a cycle, started from one of its points."""
    return SEPARATOR.join((*cycle.words[k:], *cycle.words[:k]))


# --- Residuals ------------------------------------------------------------------------------------


class Residual(NamedTuple):
    """|P_j(x) - x| of one sample of a branch, simulated once more."""

    eps_n1: float
    phi_s: float
    size: float  # rad
    slope: float  # of P_j, the larger one if the branch and the simulation differ
    rounding: float  # what rounding of one point of the orbit grows to [rad]


def residuals(diagram: Diagram, part: Part, ends: bool) -> list[Residual]:
    """The first and last samples of all branches of fixed points, or all others."""
    found = []
    for branch in diagram.branches:
        if branch.kind is BranchKind.FIXED_POINT:
            last = len(branch) - 1
            chosen = sorted({0, last}) if ends else range(1, last)
            found += [residual(branch, k, part) for k in chosen]
    return found


def residual(branch: Branch, k: int, part: Part) -> Residual:
    """|P_j(x) - x|, and the most that rounding of one point x_i of the orbit can contribute."""
    toy, order = part.toy(float(branch.parameter[k])), branch.order
    points = orbit(toy, float(branch.x[k]), order)
    left = [first_return(toy, x, order=order - i) for i, x in enumerate(points)]
    grown = [ROUNDING * abs(x * lap.slope) for x, lap in zip(points, left, strict=True)]
    slope = max(abs(left[0].slope), abs(float(branch.multiplier[k])))
    size = abs(left[0].phi_s - points[0])
    return Residual(toy.eps_n1, float(points[0]), float(size), slope, float(max(grown)))


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
