"""The page of a system of contacts, and its server."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Hashable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from bokeh.document import Document

from pwmap.explore.figures import patch
from pwmap.explore.jobs import JobEnd, is_warm, warm_up
from pwmap.explore.link import as_text
from pwmap.explore.page import PARAMETERS, asked, control
from pwmap.explore.serving import serve
from pwmap.explore.tab import Demand, Tab
from woodpecker.explore.model import DrawnMotion, MapCurve
from woodpecker.explore.system_model import FILES, answers, diagram, export
from woodpecker.explore.system_state import (
    SystemState,
    explored,
    first_state,
    from_query,
)
from woodpecker.explore.system_views import HistoryView, PlaneView
from woodpecker.explore.views import MapView, WordView

TEMPLATE = Path(__file__).parent / "files" / "system.html"
ANSWERS = 120.0  # s that answers may take


class SystemTab(Tab[SystemState]):
    """One tab of a system of contacts; other processes compute what it shows."""

    TEXTS = (*Tab.TEXTS, "periodic")

    def __init__(self, state: SystemState) -> None:
        names = state.given.names
        self.map = MapView(names[0], "") if len(names) == 1 else PlaneView(names[0], names[1])
        self.motion, self.word = HistoryView(), WordView()
        patch(self.word.now, x=[])  # no instant is shown
        motion = self.motion
        figures = self.word.figure, motion.position, motion.velocity, motion.portrait
        super().__init__(state, first_state(state.path), [self.map.figure, *figures], names[0])
        self._due, self._told = True, False
        self._now: DrawnMotion | None = None
        self.map.look(*state.window[:2])
        self.show(state)

    # --- State -> views ---------------------------------------------------------------------------

    def show(self, state: SystemState, *, moving: bool = False) -> None:
        self.keep(state, moving=moving)
        self._due = True
        self.diagram.stand(state.value, state.x[0])
        if self.key() != self._key:
            self.search_soon()

    def key(self) -> Hashable:
        state = self.state
        rest = tuple(each for each in state.values if each[0] != state.parameter)
        return rest, state.parameter, state.span, state.order

    def tick(self) -> None:
        """Begin what is due, and show results; a drag shows each motion before the next."""
        if not is_warm():
            return
        if self._due and (self._told or not self.is_running("answers")):
            self._due, self._told = False, False
            self.begin("answers", answers, self.state, seconds=ANSWERS)
        if time.monotonic() > self._search_at:
            self._search_at = np.inf
            if self.key() != self._key:
                self.search(diagram, self.state.parameter)
        for name, take in (("answers", self._take), ("diagram", self.take_progress)):
            for result in self.results(name):
                take(result)
                self.say(self.answer())

    def _take(self, result: Any) -> None:
        if isinstance(result, tuple):
            state, message = result
            if not self._due:
                self.state, self.message = state, message
                self.diagram.stand(state.value, state.x[0])
        elif isinstance(result, DrawnMotion):
            self._now, self._told = result, True
            self._draw_motion()
            self.word.show(result.marks)
        elif isinstance(result, np.ndarray):
            self.map.follow(result[:, 0] if isinstance(self.map, MapView) else result)
        elif isinstance(result, MapCurve):
            self.map.show(result, self.state.order)
        elif isinstance(result, JobEnd) and result.sentence:
            self.message = result.sentence

    def _draw_motion(self) -> None:
        system, k = self.state.given.map_.system, self.state.coordinate
        names = str(system.q[k]), str(system.u[k])
        if self._now is not None:
            self.motion.show(self._now, k, names)

    def told(self, *, whole: bool) -> dict[str, Any]:
        state, now = self.state, self._now
        return {
            "message": self.message or (now.message if now else ""),
            "start": ", ".join(f"{x:.10g}" for x in state.x), "numbers": now.numbers if now else {},
            "busy": self._due or self.is_running("answers"),
        }  # fmt: skip

    # --- What a user may ask for ------------------------------------------------------------------

    def demands(self) -> Mapping[str, Demand]:
        return {
            "start": self._start,
            "coordinate": self._coordinate,
            "search": lambda _: self.search(diagram, self.state.parameter),
        }

    def _start(self, wish: Mapping[str, Any]) -> None:
        x = self.state.read("x", as_text(wish["value"]), "start")
        self.change(x=x, periodic=False)

    def _coordinate(self, wish: Mapping[str, Any]) -> None:
        self.state = replace(self.state, coordinate=int(wish["value"]))
        self._draw_motion()

    def _tap_map(self, event: Any) -> None:
        place = (float(event.x), float(event.y))[: len(self.state.x)]
        self.change(x=(*place, *self.state.x[len(place) :]), periodic=False)

    def _tap_beside(self, event: Any) -> None:
        self.show(self.state.at({self.state.parameter: float(event.x)}))


# --- Serving --------------------------------------------------------------------------------------


def make_page(document: Document, path: str) -> None:
    """Fill the document of one tab."""
    state, refused = asked(document, partial(from_query, path), first_state(path))
    tab, given, system = SystemTab(state), state.given, state.given.map_.system
    tab.message = refused
    sliders = [control(n, *ends, repr(given.values[n])) for n, ends in given.ranges.items()]
    tab.put_on(
        document, TEMPLATE, f"{Path(path).stem}: a system of contacts",
        exports=list(FILES.items()), controls=sliders,
        open_group=PARAMETERS, over=list(given.ranges), coordinates=[str(q) for q in system.q],
        contacts=[each.name for each in system.contacts], line=len(given.names) == 1,
    )  # fmt: skip


def run(path: str, port: int | None, *, stay: bool, ready: Callable[[str], None]) -> None:
    """Run a file and serve its page; ValueError or TypeError if it lacks something."""
    explored(path)
    os.environ["WOODPECKER_EXPLORED"] = path  # for the process that jobs are forked from
    warm_up(["woodpecker.explore.system_warm"])

    serve(
        partial(make_page, path=path), lambda *asked: (export, path, *asked),
        f"{Path(path).stem}: two states", port, stay=stay, ready=ready,
    )  # fmt: skip
