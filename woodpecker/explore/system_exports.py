"""Files of the page of a system: tables, the diagram, lines of Python."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np

from pwmap import Diagram
from pwmap.diagrams.files import table_as_text
from pwmap.explore.exports import OF_DIAGRAM, OF_STATE, made
from woodpecker.explore.system_model import diagram, motion
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
    """The job of one of :data:`FILES` for a state; ValueError for an unknown name."""
    given = explored(path)

    def whole(state: SystemState) -> Diagram:
        *_, last = diagram(path, state)
        return last.shown.diagram

    texts = {what: partial(_text, what, given) for what in ("lines", "state", "events", "motion")}
    yield from made(name, from_query(given, query), FILES, whole, {}, texts)


def _text(what: str, given: Explored, state: SystemState) -> str:
    if what == "lines":
        return python_of(given, state)
    if what == "state":
        told: dict[str, Any] = {**asdict(state), "link": to_query(given, state)}
        return json.dumps(told, indent=1)
    drawn = motion(given, state)
    if what == "events":
        rows = [(m.time, m.symbol, m.what, m.impulses, m.velocities) for m in drawn.marks]
        return table_as_text(("t", "event", "what", "impulses", "velocities"), rows)
    system = given.map_.system
    header = ("t", *map(str, system.q), *map(str, system.u or ()))
    return table_as_text(header, np.column_stack([drawn.t, drawn.q, drawn.u]).tolist())
