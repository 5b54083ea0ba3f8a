"""Files of what is shown of a system: tables, the diagram, lines of Python."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

import numpy as np

from pwmap.diagrams.files import table_as_text
from pwmap.diagrams.tables import results_as_bytes
from woodpecker.explore.exports import PICTURE, TYPES, picture
from woodpecker.explore.system_model import SystemModel
from woodpecker.explore.system_state import (
    Explored,
    SystemState,
    explored,
    from_query,
    python_of,
    to_query,
)

FILES = {
    "diagram.png": "picture of the diagram (PNG)", "diagram.svg": "picture of the diagram (SVG)",
    "motion.csv": "the motion (CSV)", "events.csv": "its events (CSV)",
    "branches.csv": "branches of the diagram (CSV)", "points.csv": "special points (CSV)",
    "diagram.json": "the diagram, whole (JSON)", "graph.json": "graph of branches (JSON)",
    "state.json": "the state (JSON)", "lines.py": "lines of Python",
}  # fmt: skip


def export(path: str, name: str, query: str) -> Iterator[tuple[str, bytes]]:
    """A job that makes one file of :data:`FILES` of a state; ValueError if there is none such."""
    if name not in FILES:
        raise ValueError(f"unknown file {name!r}, expected one of {', '.join(FILES)}")
    given = explored(path)
    state = from_query(given, query)
    what, _, form = name.partition(".")
    if what in ("diagram", "branches", "points", "graph"):
        yield TYPES[form], _of_diagram(what, form, given, state)
    else:
        yield TYPES[form], _text(what, given, state).encode()


def _of_diagram(what: str, form: str, given: Explored, state: SystemState) -> bytes:
    *_, last = SystemModel(given).diagram(SystemModel(given).settled(state)[0])
    found = last.shown.diagram
    if form in PICTURE:
        from pwmap.plot import plot_diagram

        return picture(form, lambda: plot_diagram(found).figure)
    return results_as_bytes(found)[f"{what}.{form}"]


def _text(what: str, given: Explored, state: SystemState) -> str:
    if what == "lines":
        return python_of(given, state)
    if what == "state":
        told: dict[str, Any] = {**asdict(state), "link": to_query(given, state)}
        return json.dumps(told, indent=1)
    motion = SystemModel(given).motion(state)
    if what == "events":
        rows = [(m.time, m.symbol, m.what, m.impulses, m.velocities) for m in motion.marks]
        return table_as_text(("t", "event", "what", "impulses", "velocities"), rows)
    system = given.map_.system
    header = ("t", *map(str, system.q), *map(str, system.u or ()))
    return table_as_text(header, np.column_stack([motion.t, motion.q, motion.u]).tolist())
