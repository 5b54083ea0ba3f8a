"""Measurement: errors in a first run, times in rounds in which all methods take turns."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial
from typing import Any

from studies.common.clocks import Seconds, clocked, race, repeats, summary, timed
from studies.peers.peer import LostError
from studies.precision.methods import Setting
from studies.precision.tasks import Entry

SLOW = 0.25  # s; work longer than this is measured once, and its own length hides the noise
Row = dict[str, Any]


def measured(entries: Iterable[Entry], rounds: int) -> list[Row]:
    """One row per entry: errors from a first run, times from rounds in which all take turns."""
    chosen, rows, jobs = list(entries), [], {}
    for index, entry in enumerate(chosen):
        row, run = first_run(entry)
        rows.append(row)
        if row["lost"] is None and run.cpu <= SLOW:
            clock = entry.clock or partial(clocked, entry.work)
            jobs[str(index)] = clock(repeats(run.cpu))
    for key, timing in race(jobs, rounds).items():
        rows[int(key)] |= _times(timing, chosen[int(key)].scale)
    return rows


def first_run(entry: Entry) -> tuple[Row, Seconds]:
    """Row of an entry with its error and the time of one run; ``lost`` if it fails."""
    row: Row = {
        "method": entry.method,
        "variant": entry.variant,
        "knob": entry.knob,
        "value": entry.value,
        "scaled": entry.scale != 1.0,
        "lost": None,
    }
    try:
        result, run = timed(entry.work)
    except LostError as reason:
        empty = dict.fromkeys(("error", "word_right", "evaluations", "cpu", "wall", "rounds"))
        return {**row, **empty, "lost": str(reason)}, Seconds(0.0, 0.0)
    if entry.clock is not None:
        run = entry.clock(1)()
    answer = entry.judge(result)
    row |= {"error": answer.error, "word_right": answer.word_right}
    row |= {"evaluations": answer.evaluations, **(answer.detail or {})}
    return row | _times(summary([run]), entry.scale), run


def _times(timing: dict[str, float], scale: float) -> dict[str, float]:
    return {
        "cpu": scale * timing["cpu_median"],
        "wall": scale * timing["wall_median"],
        "rounds": timing["rounds"],
    }


def affordable(
    settings: Sequence[Setting], rows: Sequence[Row], patience: float
) -> tuple[list[Setting], list[str]]:
    """Settings quick enough for the map and the fixed point, and a sentence on each other one."""
    costs = {(r["method"], r["variant"], r["value"]): r["cpu"] for r in rows}
    quick, left_out = [], []
    for setting in settings:
        cost = costs[setting.method, setting.variant, setting.value]
        if cost is None or cost <= patience:
            quick.append(setting)
        else:
            words = name(setting._asdict())
            left_out.append(f"{words}: {cost:.2f} s per return, so neither map nor fixed point")
    return quick, left_out


def name(row: Row) -> str:
    """Method, variant and knob of a row in words."""
    digits = ".0e" if row["knob"] in ("rtol", "step") else "g"
    knob = f"{row['knob']} {row['value']:{digits}}" if row["knob"] else ""
    return " ".join(filter(None, (row["method"], row["variant"], knob)))
