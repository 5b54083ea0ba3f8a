"""How fast the explorer of the toy is, measured in Chromium: the slider, the diagram, the start.

Needs the extras ``explore`` and ``browser``, and Chromium at ``CHROMIUM``:

    PYTHONPATH=tests python tests/browser/explorer_speed.py [--fast | --memory]

The whole takes eleven minutes, of which ten are random use; ``--memory`` measures these alone.
No test asserts times.
"""

import json
import os
import random
import re
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from explored import Seen, browser, served

DRAG = """async () => {
  explorer.times = [];
  for (let k = 0; k < COUNT; k++) {
    const value = 0.5 + 0.12 * Math.sin(k / 25);
    dragging = true;
    explorer.ask({ do: "set", values: { eps_n1: value }, drag: true });
    while (explorer.waiting) await new Promise((done) => setTimeout(done, 1));
    await new Promise((done) => requestAnimationFrame(() => setTimeout(done)));
  }
  dragging = false;
  return explorer.times;
}"""
ROUND = 20  # wishes between two looks at the memory
WISHES = (
    {"do": "order", "value": "2"}, {"do": "order", "value": "1"}, {"do": "reset"},
    {"do": "law", "value": "separate"}, {"do": "law", "value": "summed"}, {"do": "undo"},
    {"do": "portrait", "value": "phi_m"}, {"do": "tour", "value": 7}, {"do": "tour", "value": 0},
)  # fmt: skip


def memory(pid: int) -> float:
    """Memory of a process and all that it has begun [MB]; what several share counts once."""
    total, parents = 0, {}
    for each in Path("/proc").glob("[0-9]*"):
        try:
            parents[int(each.name)] = int((each / "stat").read_text().rsplit(")", 1)[1].split()[1])
        except OSError:
            continue
    family = {pid}
    for _ in range(3):  # server, the process that jobs are forked from, jobs
        family |= {child for child, parent in parents.items() if parent in family}
    for member in family:
        try:
            told = Path(f"/proc/{member}/smaps_rollup").read_text()
        except OSError:  # it has ended
            continue
        total += int(re.search(r"^Pss:\s+(\d+)", told, re.MULTILINE)[1])  # kB
    return total / 1e3


def busy(name: str) -> float:
    """CPU time of all processes whose command has a word [s]."""
    ticks = 0
    for each in Path("/proc").glob("[0-9]*"):
        try:
            if name in (each / "cmdline").read_text():
                fields = (each / "stat").read_text().rsplit(")", 1)[1].split()
                ticks += int(fields[11]) + int(fields[12])
        except OSError:
            continue
    return ticks / os.sysconf("SC_CLK_TCK")


def wander(page: Any, pid: int, seconds: float) -> list[float]:
    """Random wishes for some time; the memory [MB] of the server after each ROUND of them."""
    rng, seen, end = random.Random(1), list[float](), time.monotonic() + seconds
    while time.monotonic() < end:
        for _ in range(ROUND):
            wish: dict[str, Any] = rng.choice(WISHES)
            if rng.random() < 0.8:
                name = rng.choice(("eps_n1", "mu_1", "mu_2", "mu_3", "c_phi"))
                value = rng.random() if name != "c_phi" else 0.004 + 0.003 * rng.random()
                wish = {"do": "set", "values": {name: value}, "drag": rng.random() < 0.8}
            page.evaluate(f"explorer.ask({json.dumps(wish)})")
            page.wait_for_function("!explorer.waiting")
        seen.append(memory(pid))
    return seen


@contextmanager
def opened() -> Iterator[tuple[Any, int]]:
    """The page of the toy, and the process that serves it."""
    with served("woodpecker", "explore", "--stay") as server, browser() as chromium:
        yield Seen(chromium, server.address).page, server.process.pid


def measured(fast: bool) -> dict[str, float]:
    """All figures; times in seconds and milliseconds."""
    begun = time.monotonic()
    with opened() as (page, pid):
        first = time.monotonic() - begun
        page.wait_for_function("/^\\d+ branch/.test(explorer.answer.stage)", timeout=120_000)
        clock = time.monotonic()
        page.evaluate("explorer.ask({ do: 'search' })")
        page.wait_for_function("explorer.answer.running && explorer.answer.branches.length")
        partial = time.monotonic() - clock
        page.wait_for_function("!explorer.answer.running", timeout=120_000)
        whole = time.monotonic() - clock
        page.wait_for_timeout(1500)
        names = ("woodpecker\x00explore", "type=renderer", "chromium")
        before, count = [busy(each) for each in names], 100 if fast else 400
        drawn = np.array(page.evaluate(DRAG.replace("COUNT", str(count))))
        used = [1e3 * (busy(n) - b) / count for n, b in zip(names, before, strict=True)]
        kept = wander(page, pid, 20.0 if fast else 600.0)
    return {
        "first picture [s]": first, "first branches [s]": partial, "whole diagram [s]": whole,
        "drag, median [ms]": float(np.median(drawn)),
        "drag, p95 [ms]": float(np.percentile(drawn, 95)),
        "drag, CPU of the server [ms]": used[0], "drag, CPU of the page's process [ms]": used[1],
        "drag, CPU of the browser in all [ms]": used[2],
        "memory, first [MB]": kept[0], "memory, most [MB]": max(kept),
        "load of the machine": os.getloadavg()[0],
    }  # fmt: skip


def remembered(seconds: float = 600.0) -> dict[str, float]:
    """Memory over random use: of the server and its processes, and of the page."""
    with opened() as (page, pid):
        inside = page.context.new_cdp_session(page)
        heap = [_heap(inside)]
        kept = np.array(wander(page, pid, seconds))
        heap.append(_heap(inside))
    late = kept[len(kept) // 2 :]
    slope = np.polyfit(np.arange(len(late)), late, 1)[0]
    return {
        "seconds": seconds, "wishes": float(ROUND * len(kept)), "first [MB]": float(kept[0]),
        "most [MB]": float(kept.max()), "last [MB]": float(kept[-1]),
        "growth in the second half [kB per wish]": float(1e3 * slope / ROUND),
        "page, first [MB]": heap[0], "page, last [MB]": heap[1],
    }  # fmt: skip


def _heap(inside: Any) -> float:
    """What the script of a page holds [MB], after its garbage was collected."""
    inside.send("HeapProfiler.collectGarbage")
    return float(inside.send("Runtime.getHeapUsage")["usedSize"]) / 1e6


if __name__ == "__main__":
    if "--memory" in sys.argv:
        told = {name: round(value, 3) for name, value in remembered().items()}
        print(json.dumps(told, indent=1))
    else:
        for name, value in measured(fast="--fast" in sys.argv).items():
            print(f"{name}: {value:.1f}")
