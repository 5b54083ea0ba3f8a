"""One answer whatever rounding decides: whole graphs from two processes that round differently."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from needs import NEEDS_NUMBA
from rounding import OTHER, is_other
from scenes import in_another_process

from woodpecker import Search, Toy, bifurcation_diagram, continuation, return_map, shoot

Graph = dict[str, Any]


def graphs() -> dict[str, Graph]:
    """The main job, and the neighbourhood of A, where words of three iterates meet on a jump."""
    toy, few = Toy(), Search(slices=16)
    near_a = bifurcation_diagram(
        toy, "eps_n1", (0.1, 0.13), (1, 2, 3), (-1.1, -0.7), search=few, workers=1
    )
    found = {"main": continuation(toy, shoot(toy, -0.53)), "near A": near_a}
    return {
        name: {
            "branches": sorted([str(b.kind), b.order, b.word, len(b)] for b in diagram.branches),
            "points": sorted(
                [
                    str(p.kind), p.note,
                    sorted([str(b.kind), b.order, b.word] for b in map(diagram.branch, p.branches)),
                    p.parameter, p.x,
                ]
                for p in diagram.points
            ),
        }
        for name, diagram in found.items()
    }  # fmt: skip


def last_bits() -> str:
    """Images of some starts, to the last bit."""
    return return_map(Toy(), np.linspace(-2.4, -0.3, 200)).phi_s.tobytes().hex()


@pytest.mark.nightly
@NEEDS_NUMBA
def test_graphs_do_not_depend_on_rounding(request: pytest.FixtureRequest, tmp_path: Path) -> None:
    others = dict.fromkeys(OTHER, "") if is_other() else OTHER
    cache = request.config.cache
    folder = cache.mkdir("numba-plain" if is_other() else "numba-fused") if cache else tmp_path
    tests = str(Path(__file__).parent)
    code = (
        f"import sys; sys.path.insert(0, {tests!r}); import rounding; rounding.apply()\n"
        "import json, test_rounding as t; print(json.dumps([t.last_bits(), t.graphs()]))"
    )
    there, theirs = json.loads(
        in_another_process(code, timeout=600.0, NUMBA_CACHE_DIR=str(folder), **others)
    )
    ours: dict[str, Graph] = json.loads(json.dumps(graphs()))
    for name, graph in ours.items():
        for ours_one, theirs_one in zip(graph["branches"], theirs[name]["branches"], strict=True):
            assert ours_one[:3] == theirs_one[:3]
            # where borders accumulate, rounding says after which of them a branch goes on; along a
            # jump it says which words show beside it, and so where steps are cut; of the branch
            # from a fold to a flip in the tip of a sharp fold there are three samples or four
            most = 1.1 if ours_one[0] == "fixed-point" else 2.0
            assert max(ours_one[3], theirs_one[3]) <= most * min(ours_one[3], theirs_one[3]) + 1
        for one, other in zip(graph["points"], theirs[name]["points"], strict=True):
            assert one[:3] == other[:3]
            assert one[3:] == pytest.approx(other[3:], abs=1e-9)
    assert there != last_bits() or "fma" not in flags()


def flags() -> str:
    """What this processor can do, where the system says so."""
    path = Path("/proc/cpuinfo")
    return path.read_text() if path.exists() else ""
