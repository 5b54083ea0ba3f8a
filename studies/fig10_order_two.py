"""Figure 10 of the paper: fixed points and jump crossings of P_1 and P_2, and whether they pair up.

    python studies/fig10_order_two.py [--fast] [--out DIR]

The paper composed P_2 from tables of P_1 and lost accuracy; here every return is simulated. Three
of its statements are checked. Fixed points of P_2 of minimal period 2 come in pairs that P_1 maps
to each other: counted in slices, between the parameters at which branches end. Jump crossings of
P_2 do not. The jump branch of P_2 that starts at A leads to C: followed through the graph.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import networkx as nx
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from record import Results, command
from style import PALE, canvas
from whole import Part, examined, searched

from pwmap import Branch, BranchKind, Diagram, PointKind, SpecialPoint
from pwmap.plot import plot_diagram
from woodpecker import Search, Toy, first_return
from woodpecker.atlas import passes
from woodpecker.labelled import SEPARATOR

SAME = 1e-6  # rad: a place that has a name
POINT_A, POINT_C = (0.0421643, -0.8847733), (0.1851270, -0.7577873)  # eps_N1, phi_S


FAST = Part((0.035, 0.07), (-1.0, -0.65), Search(slices=6), 6)  # A and a first pair
MIDDLE = Part((0.03, 0.2), (-1.2, -0.45), Search(), 24)  # from A to C
FULL = Part((0.012, 1.0), (-2.5, -0.24), Search(), 48)


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
        What :func:`whole.examined` says of P_2, and ``unpaired``: how many branches of period 2 P_1
        does not map to another; ``odd_jumps``: parameters of slices with an odd number of
        crossings; ``from_a``, ``from_c``: where the jump branches of P_2 lead that start there.
    """
    found, taken = searched(part, (1, 2))
    if out is not None:
        draw(found.diagram, part).savefig(out / "fig10.png", dpi=200)
        plt.close("all")
    results = examined(part, 2, found, taken)
    return results | {
        "unpaired": unpaired(found.diagram),
        "odd_jumps": [slice_["eps_n1"] for slice_ in results["seen"] if slice_["crossings"] % 2],
        "from_a": leads(found.diagram, POINT_A),
        "from_c": leads(found.diagram, POINT_C),
    }


# --- Pairs ----------------------------------------------------------------------------------------


def unpaired(diagram: Diagram) -> int:
    """How many branches of period 2 have a middle that P_1 maps to no branch of period 2."""
    twos = [
        branch
        for branch in diagram.branches
        if branch.kind is BranchKind.FIXED_POINT and branch.order == 2
    ]
    by_word: dict[str, list[Branch]] = {}
    for branch in twos:
        by_word.setdefault(branch.word, []).append(branch)
    alone = 0
    for branch in twos:
        middle = len(branch) // 2
        eps_n1 = float(branch.parameter[middle])
        image = first_return(Toy(eps_n1=eps_n1), float(branch.x[middle])).phi_s
        other = SEPARATOR.join(reversed(branch.word.split(SEPARATOR)))
        alone += not any(passes(each, eps_n1, image) for each in by_word.get(other, []))
    return alone


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
