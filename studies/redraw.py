"""Draw pictures of measurements again, from the numbers that are kept.

    python -m studies.redraw [--out DIR] [NAME ...]

So a picture of times or errors can change its style without a new measurement: it shows the numbers
of ``studies/results/NAME.json``. All other pictures are drawn by running their study.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterator
from pathlib import Path

from matplotlib.figure import Figure

from studies.common.record import Results
from studies.common.style import keep
from studies.exact import cycles, ground_types, long_run, symbolic
from studies.failures.draw import draw_distances, draw_matrix
from studies.failures.methods import methods
from studies.peers import pydstool_peer
from studies.precision.draw import draw as draw_precision
from studies.proofs import draw as draw_proofs
from studies.reductions.draw import draw as draw_reductions
from studies.run_all import RESULTS

AT_POINTS = ("project", "textbook")  # methods of the rows about ends of branches
LONG_RUN = ("crises", "entropy", "ulam", "random")  # what its picture shows
Pictures = Iterator[tuple[str, Figure]]


def redraw(name: str, out: Path = RESULTS, results: Path = RESULTS) -> list[Path]:
    """Draw the pictures of a study from its kept numbers.

    Parameters
    ----------
    name
        The study, among :data:`DRAWN`.
    out
        Folder for the pictures.
    results
        Folder with the numbers.

    Returns
    -------
    list of Path
        The pictures.

    Raises
    ------
    ValueError
        If the study is not drawn from numbers.
    """
    if name not in DRAWN:
        raise ValueError(
            f"no picture of {name!r} is drawn from numbers; there are {', '.join(DRAWN)}"
        )
    kept: Results = json.loads((results / f"{name}.json").read_text(encoding="utf-8"))
    kept.pop("environment", None)
    paths = []
    for file, figure in DRAWN[name](kept):
        keep(figure, out / file)
        paths.append(out / file)
    return paths


def _failures(kept: Results) -> Pictures:
    rows = [row for row in kept["rows"] if row["method"] not in AT_POINTS]
    ends = [row for row in kept["rows"] if row["method"] in AT_POINTS]
    yield "failures.png", draw_matrix(rows, ends)
    yield "failures_distance.png", draw_distances(kept["distances"], methods())


def _ground_types(kept: Results) -> Pictures:
    kinds = [ground_types.PYTHON, ground_types.FLINT]
    yield "ground_types.png", ground_types.draw(kept["timings"], list(kept["found"]), kinds)


def _general(kept: Results) -> Pictures:
    # the curve of the other program is kept; the diagram beside it takes seconds
    shown, diagram = pydstool_peer.shown_of(kept), pydstool_peer.whole_diagram()
    yield "leap.png", pydstool_peer.draw(shown, diagram)


def _symbolic(kept: Results) -> Pictures:
    yield "symbolic.png", symbolic.draw_times(kept["timings"])
    yield "symbolic_plane.png", symbolic.draw_beyond()


DRAWN: dict[str, Callable[[Results], Pictures]] = {
    "work_precision": lambda kept: iter([("work_precision.png", draw_precision(kept["tasks"]))]),
    "failures": _failures,
    "reductions": lambda kept: iter([("reductions.png", draw_reductions(kept))]),
    "ground_types": _ground_types,
    "cycles": lambda kept: iter([("cycles.png", cycles.draw(kept))]),
    "symbolic": _symbolic,
    "peer_pydstool": _general,
    "long_run": lambda kept: iter(
        [("long_run.png", long_run.draw(*map(kept.__getitem__, LONG_RUN)))]
    ),
    "proofs": lambda kept: iter([("proofs.png", draw_proofs(kept["statements"], kept["returns"]))]),
}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Draw what was measured once more.")
    parser.add_argument("names", nargs="*", default=[*DRAWN], metavar="NAME")
    parser.add_argument("--out", type=Path, default=RESULTS, help="folder for the pictures")
    options = parser.parse_args()
    for each in options.names:
        print(*redraw(each, options.out))
