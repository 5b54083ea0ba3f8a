"""Every study, one after the other.

    python studies/run_all.py [--fast] [--out DIR] [--only NAME ...]

The full run writes numbers (JSON, with machine, versions and commit) and pictures to
``studies/results/``, from which the README takes its own; the fast one takes some minutes and
writes nothing unless it is told where.
"""

from __future__ import annotations

import argparse
import importlib
import time
from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
from record import ROOT, Results, save
from rich.console import Console

STUDIES = (
    "benchmark",
    "symbolic",
    "ground_types",
    "peer_moreau",
    "peer_siconos",
    "work_precision",
    "failures",
    "reductions",
    "sensitivities",
    "fig04_time_history",
    "fig05_phase_woodpecker",
    "fig06_phase_others",
    "fig07_frames",
    "main_job",
    "fig08_return_map",
    "fig08_vertices",
    "fig09_order_one",
    "fig10_order_two",
    "fig11_maps_near_a",
    "fig12_local_model",
    "order_three",
    "paper_numbers",
    "map_grazing",
    "map_bouncing",
    "map_boost",
)
RESULTS = ROOT / "studies" / "results"
console = Console(stderr=True)


def run_all(
    fast: bool, out: Path | None = None, only: Sequence[str] = STUDIES
) -> dict[str, Results]:
    """Run studies and give the numbers of each.

    Parameters
    ----------
    fast
        Run small versions.
    out
        Folder for numbers and pictures; nothing is written without.
    only
        Names of the studies.

    Raises
    ------
    ValueError
        If there is no study of some name.
    """
    unknown = [name for name in only if name not in STUDIES]
    if unknown:
        raise ValueError(f"no study {unknown[0]!r}; there are {', '.join(STUDIES)}")
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
    found: dict[str, Results] = {}
    for name in only:
        began = time.perf_counter()
        found[name] = importlib.import_module(name).main(fast, out)
        plt.close("all")
        if out is not None:
            save(found[name], name, out)
        console.print(f"{name}: {time.perf_counter() - began:.1f} s", highlight=False)
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Run every study.")
    parser.add_argument("--fast", action="store_true", help="small versions, some minutes")
    parser.add_argument("--out", type=Path, help="folder; studies/results for the full run")
    parser.add_argument("--only", nargs="+", default=STUDIES, help="some studies by name")
    options = parser.parse_args()
    run_all(options.fast, options.out or (None if options.fast else RESULTS), options.only)
