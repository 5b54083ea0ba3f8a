"""A general continuation program on the toy's return map: PyCont, of PyDSTool.

    python -m studies.peers.pydstool_peer [--fast] [--out DIR]

PyCont [Clewley2012] follows curves of zeros by pseudo-arclength, with derivatives by differences,
as AUTO and MatCont do; it is the one program of this kind that is available in Python. It follows
P(x, eps_N1) - x = 0 from the paper's motion in both directions. Where a curve ends at a jump, it
either stops or converges to another branch and continues there. That need not be the nearest
branch: a predictor beyond a jump has the value and the derivatives of another piece, and nothing
bounds the distance that Newton's method moves from there. To identify the branch, the points are
looked up on those of :func:`woodpecker.continuation`.

Beyond the range of eps_N1 the map keeps its values at the end, so that the program may evaluate it
there. It does: between two branches a curve can leave the range. The picture shows one run beside
the diagram. PyDSTool needs numpy < 1.24; PYDSTOOL_PYTHON names a Python that has both. Without it
the study says so and measures nothing.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from itertools import groupby, pairwise
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from pwmap import BranchKind, Diagram, PointKind
from pwmap.plot import plot_diagram
from studies.common.record import Results, command
from studies.common.style import INK, PALE, RED, WIDTH, grid, keep
from studies.peers.elsewhere import environment, why_not
from studies.peers.peer import LostError
from woodpecker import Toy, continuation, first_return, shoot

PROGRAM = Path(__file__).with_name("pydstool_curve.py")
PYTHON = os.environ.get("PYDSTOOL_PYTHON", sys.executable)
START = (-0.53, 0.5)  # rad, eps_N1
WINDOW = (-2.5, 0.119)  # rad: the beak is off the pole
SAME = 1e-6  # rad: its tolerance, and the difference of a chord from a branch
STEPS = (0.05, 0.02, 0.005)  # the largest ones: length in the plane of phi_S and eps_N1
SHOWN = 0.02  # the largest step of the run in the picture
CLOSE = 0.05  # of a leap: its number stands beside it, and not on it
CENTRE, HALF = (0.23, -0.79), (0.29, 0.32)  # of the picture: eps_N1, phi_S [rad]


class Traced(NamedTuple):
    """What the program gave."""

    points: tuple[tuple[float, float], ...]  # eps_N1, phi_S [rad]
    said: str  # why it stopped
    asked: int  # images that it needed


def available() -> str:
    """Empty if PyDSTool can run, otherwise the sentence that says why not."""
    return why_not(PYTHON, "PyDSTool", "PyDSTool")


def trace(toy: Toy, step: float, forward: bool, points: int = 200) -> Traced:
    """Follow the zero of P(x, eps_N1) - x from the paper's motion.

    Parameters
    ----------
    toy
        The toy; its eps_N1 is where the curve starts.
    step
        The largest step.
    forward
        Whether to start towards larger eps_N1.
    points
        After how many to stop.

    Raises
    ------
    LostError
        If PyDSTool is missing or fails; the sentence says why.
    """
    if reason := available():
        raise LostError(reason)
    start = shoot(toy, START[0])
    task = {"x": start.phi_s, "p": toy.eps_n1, "step": step, "points": points, "forward": forward}
    with subprocess.Popen(
        [PYTHON, "-W", "ignore", str(PROGRAM), json.dumps(task)], env=environment(), text=True,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, bufsize=1,
    ) as program:  # fmt: skip
        assert program.stdin is not None
        assert program.stdout is not None
        assert program.stderr is not None
        for line in program.stdout:
            if line.startswith("{"):
                answer: dict[str, Any] = json.loads(line)
                points_ = tuple((p, x) for p, x in answer["points"])
                return Traced(points_, answer["said"], answer["asked"])
            x, p = map(float, line.split())
            print(repr(_image(toy, x, p)), file=program.stdin, flush=True)
        raise LostError(f"PyDSTool failed: {program.stderr.read().strip()[-200:]}")


def _image(toy: Toy, x: float, p: float) -> float:
    """P(x, p), with x and p moved into the ranges that a toy has; nan if it does not return."""
    inside = min(max(x, WINDOW[0]), WINDOW[1])
    return first_return(toy.replace(eps_n1=min(max(p, 0.0), 1.0)), inside).phi_s


def route(traced: Traced, diagram: Diagram) -> list[str]:
    """Ids of the fixed-point branches on which the points lie, one after the other; "" for none.

    A point lies on none if its eps_N1 is outside of the range of the diagram, or if it is taken for
    a zero just beyond the end of a branch, where the residual is within the program's tolerance.
    """
    return [name for name, _ in groupby(_branches(traced.points, diagram))]


def leaps(ids: Sequence[str], diagram: Diagram) -> list[list[str]]:
    """Pairs of branches on a route that follow each other and have no special point in common."""
    known = [name for name in ids if name]
    return [
        [here, there]
        for here, there in pairwise(known)
        if not set(diagram.branch(here).ends) & set(diagram.branch(there).ends)
    ]


def _branches(points: Sequence[tuple[float, float]], diagram: Diagram) -> Iterator[str]:
    for p, x in points:
        hits = [hit for hit in diagram.at(p) if hit.branch.kind is BranchKind.FIXED_POINT]
        near = min(hits, key=lambda hit: abs(hit.x - x), default=None)
        yield near.branch.id if near is not None and abs(near.x - x) < 1e3 * SAME else ""


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Which branches a general program follows as one, and where it stops.

    Parameters
    ----------
    fast
        One step only.
    out
        Folder for ``leap.png``.

    Returns
    -------
    dict
        ``runs``, each with ``step``, ``forward``, ``points``, ``asked`` (images), ``route`` (ids of
        branches, empty for points on none), ``leaps`` (pairs of them that do not meet), ``last``
        (eps_N1 and phi_S), ``said`` and ``curve`` (all points); ``branches`` and ``points`` of the
        diagram, in numbers. Or ``skipped``, the sentence why not.
    """
    if reason := available():
        return {"skipped": reason}
    toy, diagram = Toy(eps_n1=START[1]), whole_diagram()
    runs = []
    for step in STEPS[1:2] if fast else STEPS:
        for forward in (False, True):
            found = trace(toy, step, forward)
            ids = route(found, diagram)
            runs.append(
                {
                    "step": step, "forward": forward, "points": len(found.points),
                    "asked": found.asked, "route": ids, "leaps": leaps(ids, diagram),
                    "last": list(found.points[-1]), "said": found.said,
                    "curve": [list(point) for point in found.points],
                }
            )  # fmt: skip
    results = {"runs": runs, "branches": len(diagram.branches), "points": len(diagram.points)}
    if out is not None:
        keep(draw(shown_of(results), diagram), out / "leap.png")
    return results


def whole_diagram() -> Diagram:
    """All that is connected with the paper's motion."""
    toy = Toy(eps_n1=START[1])
    return continuation(toy, shoot(toy, START[0]), "eps_n1", span=(0.0, 1.0))


def shown_of(results: Results) -> Traced:
    """The run of the picture, from the numbers of this study."""
    run = next(each for each in results["runs"] if each["step"] == SHOWN and not each["forward"])
    return Traced(tuple((p, x) for p, x in run["curve"]), run["said"], run["asked"])


def draw(found: Traced, diagram: Diagram) -> Figure:
    """One run towards 0 beside the diagram of :func:`woodpecker.continuation`."""
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(WIDTH, 3.6), sharex=True, sharey=True, layout="constrained"
    )
    _draw_run(left, found, diagram)
    left.set_title("PyCont: one curve with leaps", fontsize=10, loc="left")
    plot_diagram(diagram, right, kinds=(PointKind.BC, PointKind.FF))
    grid(right)
    right.set_title("woodpecker: branches and jump crossings", fontsize=10, loc="left")
    for ax in (left, right):
        ax.set_xlim(CENTRE[0] - HALF[0], CENTRE[0] + HALF[0])
        ax.set_ylim(CENTRE[1] - HALF[1], CENTRE[1] + HALF[1])
        ax.set_xlabel(r"$\varepsilon_{N1}$")
    left.set_ylabel(r"$\varphi_S$ [rad]")
    right.set_ylabel("")
    return figure


def _draw_run(ax: Axes, found: Traced, diagram: Diagram) -> None:
    """The points in their order over the branches; an arrow for every leap, with its number."""
    points, names = np.array(found.points), list(_branches(found.points, diagram))
    grid(ax)
    for branch in diagram.branches:
        if branch.kind is BranchKind.FIXED_POINT:
            ax.plot(branch.parameter, branch.x, color=PALE, linewidth=3.0, zorder=1)
    ax.plot(*points.T, color=INK, linewidth=0.7, zorder=2)
    ax.plot(*points.T, "o", color=INK, markersize=3.0, zorder=3)
    ax.annotate("start", points[0], (4, 7), textcoords="offset points", ha="right", fontsize=8)
    missing = leaps([name for name, _ in groupby(names)], diagram)
    on_branch = [k for k, name in enumerate(names) if name]
    jumps = [(a, b) for a, b in pairwise(on_branch) if [names[a], names[b]] in missing]
    for number, (a, b) in enumerate(jumps, start=1):
        ax.annotate("", points[b], points[a], zorder=4, arrowprops={
            "arrowstyle": "-|>", "color": RED, "shrinkA": 2, "shrinkB": 2, "linewidth": 1.3,
        })  # fmt: skip
        is_long = np.ptp(points[[a, b]], axis=0).max() > CLOSE
        ax.annotate(
            str(number), 0.6 * points[a] + 0.4 * points[b], (0, 0) if is_long else (14, -7),
            color=RED,
            textcoords="offset points", ha="center", va="center", fontsize=8, zorder=5,
            bbox={"boxstyle": "circle,pad=0.2", "facecolor": "white", "edgecolor": RED},
        )  # fmt: skip
    drawn: dict[str, dict[str, Any]] = {
        "points of the curve, in order": {"color": INK, "linewidth": 0.7, "marker": "o"},
        "leap": {"color": RED, "linewidth": 1.3},
        "branches, as on the right": {"color": PALE, "linewidth": 3.0},
    }
    handles = [Line2D([], [], markersize=3.0, label=text, **style) for text, style in drawn.items()]
    ax.legend(handles=handles, loc="upper left", fontsize=7)


if __name__ == "__main__":
    command(main, "peer_pydstool")
