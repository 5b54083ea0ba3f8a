"""Figure 10 of the paper: fixed points and jump crossings of P_1 and P_2, under both laws.

    python -m studies.figures.fig10_order_two [--fast] [--out DIR]

The paper composed P_2 from tables of P_1 and lost accuracy; here every return is simulated. Three
of its statements are checked. Fixed points of P_2 of minimal period 2 come in pairs that P_1 maps
to each other: they are counted in slices, between the parameters at which branches end. Jump
crossings of P_2 do not come in pairs. The jump branch of P_2 that starts at A leads to C: the path
is found in the graph. Part of it the paper's 94 parameters could not show: from 0.17506 to 0.18346
it is a true cycle of period 2, which is stable.

Then numbers are given for what the figure shows: the attracting cycle of period 2 at small eps_N1,
the path from A to C, and the closed loops between 0.43 and 0.86 with their partners.

With Coulomb's law contact by contact (``expansion_friction="separate"``) the jump branch of P_2
from A does not reach C. The search for that panel of the second picture is coarser: it begins with
fewer slices (``first_slices``). That the paper's program took the sum is inferred.
"""

from __future__ import annotations

from itertools import groupby, pairwise
from pathlib import Path
from typing import NamedTuple

import networkx as nx
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from pwmap import Branch, BranchKind, Diagram, PointKind
from pwmap.plot import plot_diagram
from studies.common.laws import SEPARATE, TITLES
from studies.common.places import POINT_A, POINT_C, SPAN, WINDOW, Place, collision, told
from studies.common.record import Results, command
from studies.common.style import canvas, keep, without_legend
from studies.common.whole import Part, examined, searched, tally
from studies.figures.fig09_order_one import named, with_entries
from woodpecker import ExpansionFriction, Search, first_return, shoot

SAME = 1e-6  # rad: a cycle that is found twice
REFINED = 0.02  # rad: how far a branch may stray from the line between two of its samples
AT = 0.05  # eps_N1 of the cycle of period 2 that dips to -1.84
ON_A_LOOP = (0.5, -1.0993)  # eps_N1, phi_S [rad] of a cycle of period 2
NEAR = 5e-4  # rad: half a unit of the digits above

MARKED = PointKind.BC, PointKind.FF  # in the picture: there are hundreds of folds and flips
FAST = Part((0.105, 0.19), (-1.2, -0.6), Search(slices=6), 6)  # from A to C
FULL = Part(SPAN, WINDOW, Search(), 48)
OTHER = FULL._replace(search=Search(slices=64), law=SEPARATE)  # for the second picture


class Course(NamedTuple):
    """Branches of P_2 of one kind that follow each other on a way through the graph."""

    kind: str
    begins: Place
    ends: Place


class Loop(NamedTuple):
    """Connected branches of P_2, and the extent of what is drawn of them."""

    eps_n1: tuple[float, float]
    phi_s: tuple[float, float]  # rad


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Find all branches of P_1 and P_2, check them, draw, and the same under the other law.

    The whole figure takes some minutes; :func:`study` takes any part of it.

    Parameters
    ----------
    fast
        Only the way from A to C, and one law.
    out
        Folder for ``fig10.png`` and, not if ``fast``, ``fig10_laws.png``.

    Returns
    -------
    dict
        See :func:`study`; and ``separate``: what :func:`studies.common.whole.tally` says of the
        other law's diagram, ``seconds``, ``first_slices``, and its ``from_a``.
    """
    part = FAST if fast else FULL
    diagram, results = study(part, out)
    if fast:
        return results
    other, taken = searched(OTHER, (1, 2))
    if out is not None:
        keep(compare({part.law: diagram, OTHER.law: other.diagram}), out / "fig10_laws.png")
    return results | {
        "separate": {
            "first_slices": OTHER.search.slices,
            "seconds": taken._asdict(),
            **tally(other),
            "from_a": leads(other.diagram, POINT_A[SEPARATE]),
        }
    }


def study(part: Part, out: Path | None = None) -> tuple[Diagram, Results]:
    """A part of the figure.

    Returns
    -------
    Diagram
        What was found.
    dict
        What :func:`studies.common.whole.examined` says of P_2, and ``unpaired``: how many branches
        of period 2 P_1 does not map to another; ``odd_jumps``: parameters of slices with an odd
        number of crossings; ``from_a``, ``from_c``: where the jump branches of P_2 lead that start
        there; ``way``: from A to C, see :class:`Course`; ``two_cycle``: phi_S [rad] of the cycles
        of period 2 that attract at eps_N1 = 0.05; ``loops``: see :class:`Loop`, a loop of P_2 and
        its partner.
    """
    found, taken = searched(part, (1, 2))
    diagram, point_a = found.diagram, POINT_A[part.law]
    if out is not None:
        keep(draw(diagram, part), out / "fig10.png")
    results = examined(part, 2, found, taken)
    return diagram, results | {
        "unpaired": unpaired(diagram, part),
        "odd_jumps": [slice_["eps_n1"] for slice_ in results["seen"] if slice_["crossings"] % 2],
        "from_a": leads(diagram, point_a),
        "from_c": leads(diagram, POINT_C),
        "way": [course._asdict() for course in way(diagram, point_a, POINT_C)],
        "two_cycle": attracting(diagram, part, AT),
        "loops": [loop._asdict() for loop in loops(diagram, part)],
    }


# --- Pairs ----------------------------------------------------------------------------------------


def unpaired(diagram: Diagram, part: Part) -> int:
    """How many branches of period 2 have a middle that P_1 maps to no branch of period 2."""
    twos = [
        branch
        for branch in diagram.branches
        if branch.kind is BranchKind.FIXED_POINT and branch.order == 2
    ]
    return sum(not has_partner(branch, twos, part) for branch in twos)


def has_partner(branch: Branch, others: list[Branch], part: Part) -> bool:
    """Whether some branch is met by Newton's method where P_1 maps the middle of a branch to."""
    middle = len(branch) // 2
    toy = part.toy(float(branch.parameter[middle]))
    image = first_return(toy, float(branch.x[middle])).phi_s
    for other in others:
        for x in crossings(other, toy.eps_n1):
            if abs(x - image) < REFINED and abs(shoot(toy, x, order=2).phi_s - image) < SAME:
                return True
    return False


def crossings(branch: Branch, eps_n1: float) -> list[float]:
    """Where a branch is at a parameter, on the lines between its samples."""
    p, x = branch.parameter, branch.x
    ahead, behind = p[:-1] - eps_n1, p[1:] - eps_n1
    (k,) = np.nonzero(ahead * behind <= 0.0)
    run = ahead[k] - behind[k]
    part = np.where(run != 0.0, ahead[k] / np.where(run != 0.0, run, 1.0), 0.5)
    return list((x[k] + part * (x[k + 1] - x[k])).tolist())


# --- From A to C ----------------------------------------------------------------------------------


def leads(diagram: Diagram, place: Place) -> list[tuple[str, str, float, float]]:
    """Where the jump branches of P_2 end that start at a collision.

    Returns
    -------
    list
        Kind, note, eps_N1 and phi_S of each end; empty if the diagram has no such collision.
    """
    start = collision(diagram, place)
    jumps = [b.ends for b in diagram.branches if (b.kind, b.order) == (BranchKind.JUMP, 2)]
    graph = nx.Graph(jumps)
    if start is None or start.id not in graph:
        return []
    reached = nx.node_connected_component(graph, start.id) - {start.id}
    return [told(point) for point in diagram.points if point.id in reached]


def way(diagram: Diagram, start: Place, end: Place) -> list[Course]:
    """The shortest way between two collisions of P_1 along branches of P_2, cycles included.

    Returns
    -------
    list
        Courses of one kind; empty if the branches of P_2 do not connect the two.
    """
    first, last = collision(diagram, start), collision(diagram, end)
    graph = nx.Graph()
    for branch in diagram.of_order(2).branches:
        graph.add_edge(*branch.ends, kind=str(branch.kind))
    if first is None or last is None or not {first.id, last.id} <= set(graph):
        return []
    if not nx.has_path(graph, first.id, last.id):
        return []
    steps = list(pairwise(nx.shortest_path(graph, first.id, last.id)))
    courses = []
    for kind, some in groupby(steps, key=lambda step: str(graph.edges[step]["kind"])):
        chosen = list(some)
        ends = (diagram.point(chosen[0][0]), diagram.point(chosen[-1][1]))
        places = [(float(point.parameter), float(point.x)) for point in ends]
        courses.append(Course(kind, *places))
    return courses


# --- What the figure shows ------------------------------------------------------------------------


def attracting(diagram: Diagram, part: Part, eps_n1: float) -> list[float]:
    """Points of the cycles of minimal period 2 that attract, at one parameter, shot anew [rad]."""
    return [
        shoot(part.toy(eps_n1), float(hit.x), order=2).phi_s
        for hit in diagram.at(eps_n1)
        if hit.branch.order == 2
        and hit.branch.kind is BranchKind.FIXED_POINT
        and float(np.median(np.abs(hit.branch.multiplier))) < 1.0
    ]


def loops(diagram: Diagram, part: Part) -> list[Loop]:
    """The loop through a known cycle of period 2, and that of the cycle's other point."""
    eps_n1, x = ON_A_LOOP
    places = [x, first_return(part.toy(eps_n1), x).phi_s]
    branches = diagram.of_order(2).branches
    graph = nx.MultiGraph()
    for branch in branches:
        graph.add_edge(*branch.ends, key=branch.id)
    found = []
    for place in places:
        hits = [
            hit.branch
            for hit in diagram.at(eps_n1)
            if hit.branch.order == 2 and abs(float(hit.x) - place) < NEAR
        ]
        if hits:
            whole = nx.node_connected_component(graph, hits[0].ends[0])
            drawn = [branch for branch in branches if branch.ends[0] in whole]
            p, x_of = (np.concatenate([getattr(b, of) for b in drawn]) for of in ("parameter", "x"))
            found.append(
                Loop((float(p.min()), float(p.max())), (float(x_of.min()), float(x_of.max())))
            )
    return found


# --- Picture --------------------------------------------------------------------------------------


def draw(diagram: Diagram, part: Part) -> Figure:
    """Both orders, each in the colour of its period."""
    figure, (ax,) = canvas(5.2)
    panel(diagram, part.law, ax)
    margin = 0.02 * (part.window[1] - part.window[0])
    ax.set_ylim(part.window[0] - margin, part.window[1] + margin)
    return figure


def compare(diagrams: dict[ExpansionFriction, Diagram]) -> Figure:
    """Both laws side by side; below what lies between A and C."""
    figure, axes = canvas(7.2, 2, 2)
    for column, (law, diagram) in enumerate(diagrams.items()):
        whole, part = axes[column], axes[2 + column]
        for ax in (whole, part):
            panel(diagram, law, ax)
            ax.tick_params(labelsize=7)
            if column or ax is part:
                without_legend(ax)
        whole.set_title(TITLES[law], fontsize=8)
        whole.set(ylim=(FULL.window[0] - 0.04, FULL.window[1] + 0.04))
        part.set(xlim=(0.03, 0.2), ylim=(-0.95, -0.6))
        if column:
            whole.set_ylabel("")
            part.set_ylabel("")
    return figure


def panel(diagram: Diagram, law: ExpansionFriction, ax: Axes) -> None:
    """Branches of both orders, explained, with the paper's names."""
    plot_diagram(named(diagram, law), ax, kinds=MARKED)
    with_entries(ax, [(Line2D([], [], ls=""), "folds and flips are not marked")])


if __name__ == "__main__":
    command(main, "fig10_order_two")
