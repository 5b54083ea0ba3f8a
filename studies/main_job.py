"""The main job: all branches connected with the toy's stable motion, over the beak's restitution.

    python -m studies.main_job [--fast] [--out DIR]

The result is the graph of branches and special points, each with its cause. A, B and C are those of
the paper, identified by their places in its Figure 10.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from pwmap import Diagram, PointKind
from pwmap.plot import plot_diagram
from studies.common.motion import GUESS
from studies.common.record import Results, command
from studies.common.style import WIDTH, keep
from woodpecker import Toy, continuation, shoot

PAPER = {"A": (0.111, -0.884), "B": (0.29, -0.884), "C": (0.185, -0.757)}  # read off Figure 10
SPAN, NEAR_C = (0.0, 1.0), (0.1, 0.5)  # of eps_N1


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Follow everything, and draw it.

    Parameters
    ----------
    fast
        The neighbourhood of A, B and C only.
    out
        Folder for the picture ``main_job.png``.

    Returns
    -------
    dict
        Numbers of branches and of changes of word, and the special points: name, code, note,
        eps_N1, phi_S, precision, cause, branches at smaller and at larger eps_N1.
    """
    toy = Toy()
    found = continuation(toy, shoot(toy, GUESS), span=NEAR_C if fast else SPAN).named(PAPER)
    if out is not None:
        keep(draw(found), out / "main_job.png")
    return {
        "branches": len(found.branches),
        "changes": sum(len(branch.changes) for branch in found.branches),
        "points": [
            [
                p.name or p.id, str(p.kind), p.note, p.parameter, p.x, p.precision, p.cause,
                *(" ".join(side) for side in found.sides(p.id)),
            ]
            for p in sorted(found.points, key=lambda point: point.parameter)
        ],
    }  # fmt: skip


def draw(found: Diagram) -> Figure:
    """The diagram, and where its word changes in a panel of its own."""
    figure = plt.figure(figsize=(WIDTH, 0.5 * WIDTH), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    plot_diagram(found, left, kinds=(PointKind.PD, PointKind.BC, PointKind.FF))
    plot_diagram(found, right, kinds=(), words=True)
    right.set_ylabel("")
    left.set_xlim(left=-0.13)  # room for the names of four points above one another
    right.set_title("where the word changes", fontsize=9)
    left.set_title("special points", fontsize=9)
    return figure


if __name__ == "__main__":
    command(main, "main_job")
