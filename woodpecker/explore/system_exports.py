"""Files of the page of a system: tables, the diagram, lines of Python."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pwmap import Diagram
from pwmap.diagrams.files import table_as_text
from pwmap.explore.exports import OF_DIAGRAM, OF_STATE, made
from woodpecker.explore.system_model import diagram, motion
from woodpecker.explore.system_state import SystemState, from_query

FILES = {
    "motion.csv": "the motion (CSV)", "events.csv": "its events (CSV)", **OF_DIAGRAM, **OF_STATE,
}  # fmt: skip


def export(path: str, name: str, query: str) -> Iterator[tuple[str, bytes]]:
    """The job of one of :data:`FILES` for a state; ValueError for an unknown name."""
    texts = {"events": _events_table, "motion": _motion_table}
    yield from made(name, from_query(path, query), FILES, _diagram, {}, texts)


def _diagram(state: SystemState) -> Diagram:
    *_, last = diagram(state)
    return last.shown.diagram


def _events_table(state: SystemState) -> str:
    rows = [(m.time, m.symbol, m.what, m.impulses, m.velocities) for m in motion(state).marks]
    return table_as_text(("t", "event", "what", "impulses", "velocities"), rows)


def _motion_table(state: SystemState) -> str:
    drawn, system = motion(state), state.given.map_.system
    header = ("t", *map(str, system.q), *map(str, system.u or ()))
    return table_as_text(header, np.column_stack([drawn.t, drawn.q, drawn.u]).tolist())
