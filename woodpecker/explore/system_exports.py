"""Files of what is shown of a system: tables, the diagram, lines of Python."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

import numpy as np

from pwmap.diagrams.files import table_as_text
from pwmap.explore.exports import OF_DIAGRAM, OF_STATE, TYPES, of_diagram, parts
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
    "motion.csv": "the motion (CSV)", "events.csv": "its events (CSV)", **OF_DIAGRAM, **OF_STATE,
}  # fmt: skip


def export(path: str, name: str, query: str) -> Iterator[tuple[str, bytes]]:
    """A job that makes one file of :data:`FILES` of a state; ValueError if there is none such."""
    what, form = parts(name, FILES)
    given = explored(path)
    state = from_query(given, query)
    if name in OF_DIAGRAM:
        *_, last = SystemModel(given).diagram(SystemModel(given).settled(state)[0])
        content = of_diagram(name, last.shown.diagram)
    else:
        content = _text(what, given, state).encode()
    yield TYPES[form], content


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
