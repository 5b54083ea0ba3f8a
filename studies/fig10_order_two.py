"""Figure 10 of the paper: fixed points and jump crossings of P_1 and P_2, and whether they pair up.

    python studies/fig10_order_two.py [--fast] [--out DIR]

The paper composed P_2 from tables of P_1 and lost accuracy; here every return is simulated. Three
of its statements are checked. Fixed points of P_2 of minimal period 2 come in pairs that P_1 maps
to each other: counted in slices, between the parameters at which branches end. Jump crossings of
P_2 do not. The jump branch of P_2 that starts at A leads to C: followed through the graph.

Every sample of every branch of fixed points is simulated once more. A residual cannot be smaller
than what rounding of one point of the orbit grows to until the end, 2**-52 |x_i| times the slopes
of the returns that are left: on flanks steeper than 4e4 that alone is more than 1e-11. The first
and the last sample of a branch are counted apart: there the map jumps or has a square root.
"""

from __future__ import annotations

import math
from collections import Counter
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import matplotlib.pyplot as plt
import networkx as nx
import numpy as np
from clocks import clocked
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from record import Results, command
from style import PALE, canvas

from pwmap import Branch, BranchKind, Diagram, PointKind, SpecialPoint
from pwmap.plot import plot_diagram
from woodpecker import (
    Cycle,
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
from woodpecker.labelled import SEPARATOR, windowed
from woodpecker.slices import Slicer

ASKED = 1e-11  # rad: the residual that is asked for
ROUNDING = 2.0**-52  # relative
KERNEL = (
    1e-12,
    1e-13,
)  # rad: what the kernel promises of a return, alone and for each unit of slope
PAIRED = 1e-9  # rad: a cycle that was found from both of its points
SAME = 1e-6  # rad: a fixed point of P_2 that is one of P_1
AWAY = 1e-6  # in eps_N1: how far a slice keeps from the ends of branches
POINT_A, POINT_C = (0.0421643, -0.8847733), (0.1851270, -0.7577873)  # eps_N1, phi_S


class Part(NamedTuple):
    """Which part of the figure is looked at, and how closely."""

    span: tuple[float, float]  # of eps_N1
    window: tuple[float, float]  # of phi_S [rad]
    search: Search
    slices: int  # in which pairs are counted


FAST = Part((0.035, 0.07), (-1.0, -0.65), Search(slices=6), 6)  # A and a first pair
MIDDLE = Part((0.03, 0.2), (-1.2, -0.45), Search(), 24)  # from A to C
FULL = Part((0.012, 1.0), (-2.5, -0.24), Search(), 48)


class Pairs(NamedTuple):
    """Fixed points of P_2 of minimal period 2 in one slice."""

    eps_n1: float
    fixed_points: int  # the two points of each cycle
    drawn: int  # of the diagram, at the same parameter
    missing: int  # fixed points through which no branch of their word passes
    sampled: int  # fixed points that a search of P_2 itself finds, piece by piece of 1e-6 rad
    only_sampled: int  # and that are not among the cycles
    crossings: int  # jump crossings of P_2
    drawn_crossings: int

    @property
    def pairs_up(self) -> bool:
        """Whether the diagram has both points of every cycle, and nothing else."""
        return self.missing == 0 and self.fixed_points == self.drawn


class Residual(NamedTuple):
    """|P_j(x) - x| of one sample of a branch, simulated once more."""

    eps_n1: float
    phi_s: float
    size: float  # rad
    slope: float  # of P_j, the larger one if the branch and the simulation differ
    rounding: float  # what rounding of one point of the orbit grows to [rad]


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Find all branches of P_1 and P_2, check them, draw.

    The whole figure takes some minutes; :func:`study` takes any part of it.

    Parameters
    ----------
    fast
        Only what is next to A.
    out
        Folder for ``fig10.png``.

    Returns
    -------
    dict
        See :func:`study`.
    """
    return study(FAST if fast else FULL, out)


def study(part: Part, out: Path | None = None) -> Results:
    """A part of the figure.

    Returns
    -------
    dict
        ``branches``, ``points``: how many by kind and order; ``slices``, ``not_followed``,
        ``evaluations``, ``seconds``: of the search; ``pairs``: see :class:`Pairs`; ``odd``:
        parameters of slices where fixed points do not pair up; ``odd_jumps``: of slices with an odd
        number of crossings;
        ``residuals``, ``residuals_at_ends``: see :func:`summary`; ``from_a``, ``from_c``: where the
        jump branches of P_2 lead that start there.
    """
    first_return(Toy(), -0.53)  # compiled
    kept: list[Found] = []
    taken = clocked(
        lambda: kept.append(
            find_all(Toy(), "eps_n1", part.span, (1, 2), part.window, search=part.search)
        )
    )()
    found = kept[0]
    pairs = [counted(found.diagram, part, p) for p in between(found.diagram, part.slices)]
    if out is not None:
        draw(found.diagram, part).savefig(out / "fig10.png", dpi=200)
        plt.close("all")
    return {
        "span": part.span,
        "window": part.window,
        "seconds": taken._asdict(),
        **tally(found),
        "pairs": [slice_._asdict() for slice_ in pairs],
        "odd": [slice_.eps_n1 for slice_ in pairs if not slice_.pairs_up],
        "odd_jumps": [slice_.eps_n1 for slice_ in pairs if slice_.crossings % 2],
        "residuals": summary(residuals(found.diagram, ends=False)),
        "residuals_at_ends": summary(residuals(found.diagram, ends=True)),
        "from_a": leads(found.diagram, POINT_A),
        "from_c": leads(found.diagram, POINT_C),
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
        "not_followed": [place for report in found.reports for place in report.not_followed],
        "evaluations": found.evaluations,
    }


# --- Pairs ----------------------------------------------------------------------------------------


def between(diagram: Diagram, count: int) -> list[float]:
    """Parameters in the middle between neighbouring special points, evenly chosen."""
    marks = sorted({point.parameter for point in diagram.points})
    middles = [0.5 * (a + b) for a, b in pairwise(marks) if b - a > 2.0 * AWAY]
    chosen = np.linspace(0, len(middles) - 1, min(count, len(middles))).round().astype(int)
    return [middles[k] for k in chosen]


def counted(diagram: Diagram, part: Part, eps_n1: float) -> Pairs:
    """The fixed points of P_2 at one parameter, from slices that know nothing of branches."""
    toy = Toy(eps_n1=eps_n1)
    low, high = part.window
    labelled = windowed(toy_map(toy), (low - MARGIN, high + MARGIN))
    samples, settings = toy_samples(toy), Settings(window=part.window)
    slicer = Slicer(labelled, samples, settings, part.search.resolution)
    (slice_,) = slicer.take(eps_n1, (2,))
    cycles = unique([cycle for cycle in slice_.cycles if np.ptp(cycle.x) > SAME])
    points = [(float(cycle.x[k]), word_from(cycle, k)) for cycle in cycles for k in (0, 1)]
    whole = iterated(samples, 2, part.window)
    direct = slice_of(whole, eps_n1, part.window, part.search.resolution)
    sampled = [x for x, _ in direct.fixed_points if abs(first_return(toy, x).phi_s - x) > SAME]
    hits = diagram.at(eps_n1)
    words = {hit.branch.word for hit in hits if is_period_two(hit.branch)}
    jumps = [hit for hit in hits if hit.branch.kind is BranchKind.JUMP and hit.branch.order == 2]
    return Pairs(
        eps_n1=eps_n1,
        fixed_points=len(points),
        drawn=sum(is_period_two(hit.branch) for hit in hits),
        missing=sum(word not in words for _, word in points),
        sampled=len(sampled),
        only_sampled=sum(all(abs(x - y) > SAME for y, _ in points) for x in sampled),
        crossings=len(slice_.jumps),
        drawn_crossings=len(jumps),
    )


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


def is_period_two(branch: Branch) -> bool:
    """Whether it is a branch of fixed points of P_2; a diagram lists them by minimal period."""
    return branch.kind is BranchKind.FIXED_POINT and branch.order == 2


# --- Residuals ------------------------------------------------------------------------------------


def residuals(diagram: Diagram, ends: bool) -> list[Residual]:
    """The first and last samples of all branches of fixed points, or all others."""
    found = []
    for branch in diagram.branches:
        if branch.kind is BranchKind.FIXED_POINT:
            last = len(branch) - 1
            chosen = sorted({0, last}) if ends else range(1, last)
            found += [residual(branch, k) for k in chosen]
    return found


def residual(branch: Branch, k: int) -> Residual:
    """|P_j(x) - x|, and the most that rounding of one point x_i of the orbit can contribute."""
    toy, order = Toy(eps_n1=float(branch.parameter[k])), branch.order
    points = [float(branch.x[k])]
    while len(points) < order:
        points.append(first_return(toy, points[-1]).phi_s)
    left = [first_return(toy, x, order=order - i) for i, x in enumerate(points)]
    grown = [ROUNDING * abs(x * lap.slope) for x, lap in zip(points, left, strict=True)]
    slope = max(abs(left[0].slope), abs(float(branch.multiplier[k])))
    size = abs(left[0].phi_s - points[0])
    return Residual(toy.eps_n1, points[0], size, slope, max(grown))


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


# --- From A to C ----------------------------------------------------------------------------------


def leads(diagram: Diagram, place: tuple[float, float]) -> list[tuple[str, str, float, float]]:
    """Where the jump branches of P_2 end that start at a collision, word changes left out.

    Returns
    -------
    list
        Kind, note, eps_N1 and phi_S of each end; empty if the diagram has no such collision.
    """
    start = nearest(diagram, place)
    jumps = [b.ends for b in diagram.branches if (b.kind, b.order) == (BranchKind.JUMP, 2)]
    graph = nx.Graph(jumps)
    if start is None or start.id not in graph:
        return []
    reached = nx.node_connected_component(graph, start.id) - {start.id}
    points = [p for p in diagram.points if p.id in reached and p.kind is not PointKind.WC]
    return [(str(p.kind), p.note, float(p.parameter), float(p.x)) for p in points]


def nearest(diagram: Diagram, place: tuple[float, float]) -> SpecialPoint | None:
    """The collision of P_1 at a place."""
    for point in diagram.points:
        near = np.abs(np.subtract((point.parameter, point.x), place)).max() < SAME
        if near and point.kind in (PointKind.FF, PointKind.BC):
            return point
    return None


# --- Picture --------------------------------------------------------------------------------------


def draw(diagram: Diagram, part: Part) -> Figure:
    """Both orders in the usual colours; what belongs to P_1 has a broad pale line behind it."""
    figure, (ax,) = canvas(5.2)
    for branch in diagram.of_order(1).branches:
        ax.plot(
            branch.parameter, branch.x, color=PALE, linewidth=6.0, alpha=0.6, zorder=0.9,
            solid_capstyle="butt",
        )  # fmt: skip
    kinds = [kind for kind in PointKind if kind not in (PointKind.WC, PointKind.EP)]
    plot_diagram(diagram, ax, kinds=kinds)
    legend = ax.get_legend()
    assert legend is not None
    ax.legend(
        [*legend.legend_handles, Line2D([], [], color=PALE, linewidth=6.0, alpha=0.6)],
        [*(text.get_text() for text in legend.get_texts()), "of $P_1$; all others of $P_2$"],
        fontsize=7, framealpha=0.95, loc="best",
    )  # fmt: skip
    for name, place in (("A", POINT_A), ("C", POINT_C)):
        if nearest(diagram, place) is not None:
            ax.annotate(name, place, (-4, 7), textcoords="offset points", fontsize=9, ha="right")
    margin = 0.02 * (part.window[1] - part.window[0])
    ax.set_ylim(part.window[0] - margin, part.window[1] + margin)
    return figure


if __name__ == "__main__":
    command(main, "fig10_order_two")
