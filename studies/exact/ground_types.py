"""The gain by python-flint: the same exact jobs with sympy's own rationals and with those of flint.

    python -m studies.exact.ground_types [--fast] [--out DIR]

sympy chooses its rationals (its ground types) when it is imported, so each round runs two processes
in turn, one for each. Every process starts with empty caches and reports its results, which must be
equal. Without python-flint only the first is measured.
"""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

from matplotlib.figure import Figure

from pwmap import PiecewiseLinearMap, bifurcation_diagram
from studies.common.clocks import Seconds, Timing, ratio, summary
from studies.common.record import Results, command, environ
from studies.common.style import GREY, STABLE, canvas, keep

FLINT, PYTHON = "flint", "python"
NAMES = {PYTHON: "rationals of sympy", FLINT: "rationals of python-flint"}
COLORS = {PYTHON: GREY, FLINT: STABLE}
Found = dict[str, tuple[float, float, int]]  # wall and CPU seconds, and how much was found


def jobs(fast: bool) -> dict[str, Callable[[], int]]:
    """Exact jobs by name; each gives how many pieces or branches it found."""
    paper = PiecewiseLinearMap([("r - 2", "x <= 0"), ("r - a*x", "x > 0")], given=["a > 1"])
    tent = PiecewiseLinearMap([("m*x", "x <= 1/2"), ("m - m*x", "x > 1/2")])
    skew = PiecewiseLinearMap([("3*x/2 + 1", "x <= 0"), ("1 - b*x", "x > 0")])
    inner = PiecewiseLinearMap(
        [("r - 2", "x <= 0"), ("r - a*x", "x > 0")], given=["a > 1", "r > 0", "r < 2"]
    )
    n = 4 if fast else 0  # orders less

    def branches(
        map_: PiecewiseLinearMap, name: str, span: tuple[int, int] | None, last: int
    ) -> int:
        return len(bifurcation_diagram(map_, name, span, range(1, last + 1)).branches)

    return {
        f"P1..P{6 - n // 2} in a and r": lambda: sum(
            len(inner.iterate(j).pieces) for j in range(1, 7 - n // 2)
        ),
        f"P1^L, a symbolic, orders 1..{20 - 3 * n}": lambda: branches(paper, "r", None, 20 - 3 * n),
        f"tent, orders 1..{8 - n}": lambda: branches(tent, "m", (0, 2), 8 - n),
        f"skew tent, orders 1..{8 - n}": lambda: branches(skew, "b", (0, 4), 8 - n),
    }


def child(fast: bool) -> Found:
    """All jobs, once, in this process."""
    found = {}
    for name, job in jobs(fast).items():
        wall, cpu = time.perf_counter(), time.process_time()
        count = job()
        found[name] = (time.perf_counter() - wall, time.process_time() - cpu, count)
    return found


def asked(ground_types: str, fast: bool) -> Found:
    """All jobs in a process of their own."""
    work = f"ground_types.child({fast})"
    code = f"import json; from studies.exact import ground_types; print(json.dumps({work}))"
    environment = environ(SYMPY_GROUND_TYPES=ground_types, MPLBACKEND="Agg")
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    )
    return {name: tuple(row) for name, row in json.loads(done.stdout).items()}


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Measure, compare what was found, and draw.

    Parameters
    ----------
    fast
        Take one round, of lower orders.
    out
        Folder for ``ground_types.png``.

    Returns
    -------
    dict
        ``timings``: seconds of every job and ground type; ``ratios``: CPU time with sympy's own
        rationals over that with flint, None without flint; ``found``: pieces or branches by job.
    """
    kinds = [PYTHON, FLINT] if importlib.util.find_spec("flint") else [PYTHON]
    taken: dict[str, list[Seconds]] = {}
    found: dict[str, int] = {}
    for _ in range(1 if fast else 3):
        for kind in kinds:
            for name, (wall, cpu, count) in asked(kind, fast).items():
                taken.setdefault(f"{name}, {kind}", []).append(Seconds(wall, cpu))
                assert found.setdefault(name, count) == count, (name, kind)
    timings = {name: summary(seconds) for name, seconds in taken.items()}
    ratios = {
        name: ratio(timings, f"{name}, {PYTHON}", f"{name}, {FLINT}", "cpu") for name in found
    }
    if out is not None:
        keep(draw(timings, list(found), kinds), out / "ground_types.png")
    return {"ratios": ratios, "found": found, "timings": timings}


def draw(timings: dict[str, Timing], names: list[str], kinds: list[str]) -> Figure:
    """CPU time of each job, one bar for each ground type."""
    figure, (ax,) = canvas(3.2)
    height = 0.38
    for i, kind in enumerate(kinds):
        seconds = [timings[f"{name}, {kind}"]["cpu_median"] for name in names]
        at = [row + (i - 0.5) * height for row in range(len(names))]
        bars = ax.barh(at, seconds, height, color=COLORS[kind], label=NAMES[kind], log=True)
        labels = [f"{s:.2g} s" if s > 0.1 else f"{1e3 * s:.2g} ms" for s in seconds]
        ax.bar_label(bars, labels, fontsize=7, padding=3)
    ax.set_yticks(range(len(names)), list(map(_label, names)), fontsize=8)
    ax.invert_yaxis()
    every = [timings[f"{name}, {kind}"]["cpu_median"] for name in names for kind in kinds]
    ax.set_xlim(0.3 * min(every), 3.0 * max(every))
    ax.grid(visible=False, axis="y")
    ax.set_xlabel("CPU time [s], median of rounds in turn")
    ax.legend(fontsize=8)
    return figure


def _label(name: str) -> str:
    """The name of a job for the picture."""
    named = {"P1..P6 in a and r": "$P_1$ to $P_6$ in $a$ and $r$",
             "P1..P4 in a and r": "$P_1$ to $P_4$ in $a$ and $r$"}  # fmt: skip
    text = named.get(name, name).replace("P1^L, a symbolic", "$P_1^L$, $a$ symbolic")
    return text.replace(", orders", ",\norders").replace("..", " to ")


if __name__ == "__main__":
    command(main, "ground_types")
