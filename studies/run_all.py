"""Run all studies, one after the other.

    python -m studies.run_all [--fast] [--out DIR] [--only NAME ...]

The full run writes numbers (JSON, with machine, versions and commit) and pictures to
``studies/results/``, whose page is filled from them; the fast one takes some minutes and writes
nothing unless a folder is given.
"""

from __future__ import annotations

import argparse
import importlib
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
from rich.console import Console

if not __package__:  # run by its path: then Python looks for `studies` inside of `studies`
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from studies.common.record import ROOT, Results, save

STUDIES = {  # the name of each study and of its results, and its module
    "benchmark": "studies.benchmark",
    "symbolic": "studies.exact.symbolic",
    "ground_types": "studies.exact.ground_types",
    "peer_moreau": "studies.peers.moreau",
    "peer_siconos": "studies.peers.siconos_peer",
    "peer_pydstool": "studies.peers.pydstool_peer",
    "work_precision": "studies.precision.work_precision",
    "failures": "studies.failures.failures",
    "reductions": "studies.reductions.reductions",
    "sensitivities": "studies.sensitivities",
    "fig04_time_history": "studies.figures.fig04_time_history",
    "fig05_phase_woodpecker": "studies.figures.fig05_phase_woodpecker",
    "fig06_phase_others": "studies.figures.fig06_phase_others",
    "fig07_frames": "studies.figures.fig07_frames",
    "jump_crossing": "studies.jump_crossing",
    "main_job": "studies.main_job",
    "two_parameters": "studies.two_parameters",
    "regions": "studies.regions",
    "robustness": "studies.robustness",
    "fig08_return_map": "studies.figures.fig08_return_map",
    "fig08_vertices": "studies.figures.fig08_vertices",
    "fig09_order_one": "studies.figures.fig09_order_one",
    "fig10_order_two": "studies.figures.fig10_order_two",
    "fig11_maps_near_a": "studies.figures.fig11_maps_near_a",
    "fig12_local_model": "studies.figures.fig12_local_model",
    "order_three": "studies.order_three",
    "paper_numbers": "studies.paper_numbers",
    "completeness": "studies.completeness",
    "mechanisms": "studies.mechanisms",
    "proofs": "studies.proofs",
    "long_run": "studies.exact.long_run",
    "cycles": "studies.exact.cycles",
    "parameter_plane": "studies.exact.parameter_plane",
    "long_run_pictures": "studies.exact.long_run_pictures",
    "certificates": "studies.exact.certificates",
    "map_grazing": "studies.maps.grazing",
    "map_bouncing": "studies.maps.bouncing",
    "map_boost": "studies.maps.boost",
    "system_toy": "studies.systems.toy",
    "system_oscillator": "studies.systems.oscillator",
    "system_den_hartog": "studies.systems.den_hartog",
    "system_table": "studies.systems.table",
    "system_crossing": "studies.systems.crossing",
    "system_belt": "studies.systems.belt",
    "system_rocking_block": "studies.systems.rocking_block",
    "system_rimless_wheel": "studies.systems.rimless_wheel",
    "system_fold_flip": "studies.systems.fold_flip",
    "system_random": "studies.systems.random_systems",
    "system_peers": "studies.systems.peers",
}
RESULTS = ROOT / "studies" / "results"
console = Console(stderr=True)


def run_all(
    fast: bool, out: Path | None = None, only: Sequence[str] = tuple(STUDIES)
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
        found[name] = importlib.import_module(STUDIES[name]).main(fast, out)
        plt.close("all")
        if out is not None:
            save(found[name], name, out)
        console.print(f"{name}: {time.perf_counter() - began:.1f} s", highlight=False)
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Run every study.")
    parser.add_argument("--fast", action="store_true", help="small versions, some minutes")
    parser.add_argument("--out", type=Path, help="folder; studies/results for the full run")
    parser.add_argument("--only", nargs="+", default=tuple(STUDIES), help="some studies by name")
    options = parser.parse_args()
    run_all(options.fast, options.out or (None if options.fast else RESULTS), options.only)
