"""Files that a page offers: pictures by the functions of ``plot``, tables, lines of Python."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict

import numpy as np

from pwmap import Diagram
from pwmap.diagrams.files import table_as_text
from pwmap.explore.exports import Files, made, of_all_pages, pictures
from pwmap.plot import Drawn
from woodpecker import ReturnMap, return_map
from woodpecker.explore.branches import diagram as found_diagram
from woodpecker.explore.model import FINE, trajectory
from woodpecker.explore.state import PageState, from_query
from woodpecker.plot.drawing import draw_frames
from woodpecker.plot.figures import plot_return_map
from woodpecker.plot.motions import PORTRAITS, plot_phase_portrait, plot_time_history


def _returns(state: PageState) -> ReturnMap:
    return return_map(state.toy, state.starts(FINE), state.order)


def _toy(state: PageState) -> Drawn:
    motion = trajectory(state)[0]
    struck = [event for event in motion.events if event.impulses][:3]
    times = [0.0, *(event.time for event in struck)]
    labels = ["on the section", *(f"{e.symbol}, {1e3 * e.time:.2f} ms" for e in struck)]
    return draw_frames(motion, times, labels)


# --- Tables and texts -----------------------------------------------------------------------------


def _map_table(state: PageState) -> str:
    found = _returns(state)
    rows = zip(
        found.start, found.phi_s, found.period, found.drop, found.slope, found.words, strict=True
    )
    return table_as_text(("phi_s_start", "phi_s", "period", "drop", "slope", "word"), rows)


def _motion_table(state: PageState) -> str:
    motion = trajectory(state)[0]
    header = ("t", "y", "phi_m", "phi_s", "dy", "dphi_m", "dphi_s")
    return table_as_text(header, np.column_stack([motion.t, motion.q, motion.u]).tolist())


def _events_table(state: PageState) -> str:
    header = ("t", "event", "contacts", "contact", "normal_compression", "tangential_compression",
              "normal_expansion", "tangential_expansion")  # fmt: skip
    rows: list[tuple[object, ...]] = []
    for event in trajectory(state)[0].events:
        first = event.time, event.symbol, "+".join(map(str, event.contacts))
        rows += [first + tuple(asdict(impulse).values()) for impulse in event.impulses]
        if not event.impulses:
            rows.append((*first, "", "", "", "", ""))
    return table_as_text(header, rows)


def _diagram(state: PageState) -> Diagram:
    *_, last = found_diagram(state)
    return last.diagram


OF_DIAGRAM = of_all_pages(_diagram)
FILES: Files = {
    **pictures("map", lambda state: plot_return_map(
        state.toy, _returns(state), order=state.order, depth=state.window[0]
    )),
    **pictures("motion", lambda state: plot_time_history(trajectory(state)[0])),
    **pictures("portrait", lambda state: plot_phase_portrait(
        trajectory(state)[0], *PORTRAITS[state.portrait]
    )),
    **pictures("toy", _toy),
    "map.csv": ("the map (CSV)", _map_table),
    "motion.csv": ("the motion (CSV)", _motion_table),
    "events.csv": ("its events (CSV)", _events_table),
    **OF_DIAGRAM,
}  # fmt: skip


def export(name: str, query: str, known: Diagram | None) -> Iterator[tuple[str, bytes]]:
    """Yield one of :data:`FILES` for the state of a link; a ``known`` diagram is used as it is."""
    files = FILES if known is None else {**FILES, **of_all_pages(lambda _: known)}
    yield from made(name, from_query(query), files)
