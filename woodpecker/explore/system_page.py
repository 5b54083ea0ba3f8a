"""The page of a system with contacts, and how it is served."""

from __future__ import annotations

import os
from collections.abc import Hashable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from bokeh.document import Document

from pwmap.explore.figures import Shown, map_figure
from pwmap.explore.jobs import warm_up
from pwmap.explore.page import PARAMETERS, asked, control
from pwmap.explore.serving import Serve
from pwmap.explore.tab import Demand, Tab
from woodpecker.explore.model import DrawnMotion, MapCurve
from woodpecker.explore.system_model import FILES, answers, diagram, export
from woodpecker.explore.system_state import (
    SystemState,
    explored,
    first_state,
    from_query,
)
from woodpecker.explore.views import (
    OF_FIXED,
    labels_of,
    motion_figures,
    of_map,
    of_motion,
    of_orbit,
    section_figure,
    word_figure,
)

TEMPLATE = Path(__file__).parent / "files" / "system.html"
ANSWERS = 120.0  # s after which the job of a state is stopped


PANELS = {"position": ("q",), "velocity": ("u",)}


def figures(names: tuple[str, ...]) -> tuple[Any, ...]:
    """All views but those of the diagram, for a map whose coordinates have these names."""
    map_ = section_figure(*names[:2])
    if len(names) == 1:
        map_ = map_figure(*labels_of(names[0]), OF_FIXED, "order")
    return map_, word_figure(), *motion_figures(PANELS, ("", "", "t [s]"))


class SystemTab(Tab[SystemState]):
    """A browser tab with the page of a system; other processes compute what it shows."""

    WORK = staticmethod(diagram)

    def __init__(self, state: SystemState) -> None:
        self._names, window = state.given.names, state.given.window
        super().__init__(state, first_state(state.path), figures(self._names), self._names[0])
        # whether a state waits for a job; whether the last job has shown its motion
        self._asked, self._shown = True, False
        self._now: DrawnMotion | None = None
        self.tables["word_now"].data = {"x": []}  # no instant is shown
        self.draw(Shown(ends={"map": (*window[0], *window[min(1, len(window) - 1)])}))
        self.show(state)

    # --- State -> views ---------------------------------------------------------------------------

    def key(self) -> Hashable:
        state = self.state
        rest = tuple(each for each in state.values if each[0] != state.over)
        return rest, state.over, state.span, state.order

    def axis(self) -> str:
        return self.state.over

    def show(self, state: SystemState, *, moving: bool = False) -> None:
        self.keep(state, moving=moving)
        self.draw(self.stand(state.x[0]))
        self._asked = True
        self.later(0.0, self._answer_all)

    def _answer_all(self) -> None:
        """Begin the job of the state; in a drag only after the last one has shown its motion."""
        if self._asked and (self._shown or "answers" not in self.jobs):
            self._asked, self._shown = False, False
            self.begin("answers", self._take, answers, self.state, seconds=ANSWERS)

    def _take(self, result: Any) -> None:
        if isinstance(result, tuple):
            if not self._asked:
                settled, message = result
                self.state = replace(self.state, x=settled.x)
                self.message = message or self.message
                self.draw(self.stand(self.state.x[0]))
        elif isinstance(result, DrawnMotion):
            self._now, self._shown = result, True
            self._draw_motion(result)
            self.later(0.0, self._answer_all)
        elif isinstance(result, MapCurve):
            labels = labels_of(self._names[0], step=f"+{self.state.order}")
            self.draw(of_map(result, self.state.order, labels))
        else:
            self.draw(of_orbit(result[:, 0] if len(self._names) == 1 else result))

    def ended(self, name: str, sentence: str) -> None:
        super().ended(name, sentence)
        self.later(0.0, self._answer_all)

    def _draw_motion(self, motion: DrawnMotion) -> None:
        system, k = self.state.given.map_.system, self.state.coordinate
        q, u = str(system.q[k]), str(system.u[k])
        columns = {"t": motion.t, "q": motion.q[:, k], "u": motion.u[:, k]}
        self.draw(of_motion(columns, motion.marks, 1.0, PANELS, ("q", "u")))
        labels = {"position": ("t [s]", q), "velocity": ("t [s]", u), "portrait": (q, u)}
        self.draw(Shown(labels=labels))

    def told(self, *, whole: bool) -> dict[str, Any]:
        state, now = self.state, self._now
        return {
            "message": self.message or (now.message if now else ""),
            "start": ", ".join(f"{x:.10g}" for x in state.x), "numbers": now.numbers if now else {},
            "busy": self._asked or "answers" in self.jobs,
        }  # fmt: skip

    # --- What a user may ask for ------------------------------------------------------------------

    def demands(self) -> dict[str, Demand]:
        own: dict[str, Demand] = {"start": self._start, "coordinate": self._coordinate}
        return super().demands() | own

    def _start(self, wish: Mapping[str, Any]) -> None:
        self.change(x=self._read("x", wish, "start"), periodic=False)

    def _coordinate(self, wish: Mapping[str, Any]) -> None:
        self.state = replace(self.state, coordinate=self._read("coordinate", wish))
        if self._now is not None:
            self._draw_motion(self._now)

    def _tap_map(self, event: Any) -> None:
        place = (float(event.x), float(event.y))[: len(self.state.x)]
        self.change(x=(*place, *self.state.x[len(place) :]), periodic=False)

    def _tap_beside(self, event: Any) -> None:
        self.show(self.state.at({self.state.over: float(event.x)}))


# --- Serving --------------------------------------------------------------------------------------


def make_page(document: Document, path: str) -> None:
    """Fill the document of one tab."""
    state, refused = asked(document, partial(from_query, path), first_state(path))
    tab, given, system = SystemTab(state), state.given, state.given.map_.system
    tab.message = refused
    sliders = [control(n, *ends, repr(given.values[n])) for n, ends in given.ranges.items()]
    tab.put_on(
        document, TEMPLATE, f"{Path(path).stem}: a system of contacts",
        files=FILES, controls=sliders,
        open_group=PARAMETERS, over=list(given.ranges), coordinates=[str(q) for q in system.q],
        contacts=[each.name for each in system.contacts], line=len(given.names) == 1,
    )  # fmt: skip


def run(path: str, serve: Serve) -> None:
    """Run a file and serve its page; ValueError or TypeError as from :func:`explored`."""
    explored(path)
    os.environ["WOODPECKER_EXPLORED"] = path  # read in the process that jobs are forked from
    warm_up(["woodpecker.explore.system_warm"])
    serve(partial(make_page, path=path), lambda *asked: (export, path, *asked))
