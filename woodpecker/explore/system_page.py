"""The page of a system of contacts, put together and served."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from bokeh.document import Document

from pwmap.explore.diagram_views import DiagramView, GraphView
from pwmap.explore.diagrams import Shown, nearest_line, nearest_sample
from pwmap.explore.figures import on_click, patch
from pwmap.explore.jobs import Failure, Job, is_warm, warm_up
from pwmap.explore.page import Control, asked, fill, numbers
from pwmap.explore.serving import Site, serve
from woodpecker.explore.branches import DiagramProgress
from woodpecker.explore.model import DrawnMotion, MapCurve
from woodpecker.explore.system_exports import FILES, export
from woodpecker.explore.system_model import SystemModel, answers, diagram
from woodpecker.explore.system_state import (
    Explored,
    SystemState,
    explored,
    first_state,
    from_query,
    over,
    point,
    python_of,
    to_query,
)
from woodpecker.explore.system_views import HistoryView, PlaneView
from woodpecker.explore.views import MapView, WordView

TEMPLATE = Path(__file__).parent / "files" / "system.html"
TICK = 50  # ms between looks at what other processes have sent
QUIET = 0.5  # s after the last change until another diagram is begun
CLICK = 14.0  # px: what lies farther from a click was not meant
UNDO = 100  # states that are kept
ANSWERS, DIAGRAM = 120.0, 600.0  # s that answers and a diagram may take
GROUP = "1:parameters"


class SystemTab:
    """One tab: a state, its views, and what a user may ask for."""

    def __init__(self, given: Explored, state: SystemState) -> None:
        self.given, self.state, self.past = given, state, list[SystemState]()
        self.message, self.stage, self.branch = "", "", ""
        names = given.names
        self.map = MapView(names[0], "") if len(names) == 1 else PlaneView(names[0], names[1])
        self.motion, self.word = HistoryView(), WordView()
        patch(self.word.now, x=[])  # no instant is shown
        self.diagram, self.graph = DiagramView("diagram", "", names[0]), GraphView("graph")
        self._answers: Job | None = None
        self._branches: Job | None = None
        self._due, self._told, self._search_at = True, False, 0.0
        self._key: Any = None
        self._shown: Shown | None = None
        self._now: DrawnMotion | None = None
        self.say: Callable[[Mapping[str, Any]], None] = lambda _: None
        self._look()
        for figure, verb in ((self.map.figure, self._tap_map),
                             (self.diagram.figure, self._tap_diagram),
                             (self.graph.figure, self._tap_graph)):  # fmt: skip
            on_click(figure, self._heard(verb))

    @property
    def roots(self) -> list[Any]:
        """The figures, for the page."""
        motion = self.motion
        return [self.map.figure, self.diagram.figure, self.graph.figure, self.word.figure,
                motion.position, motion.velocity, motion.portrait]  # fmt: skip

    def _look(self) -> None:
        window = self.state.window
        if isinstance(self.map, MapView):
            self.map.look(window[0])
        else:
            self.map.look(window)
        self.diagram.figure.xaxis.axis_label = self.state.parameter

    # --- State -> views ---------------------------------------------------------------------------

    def show(self, state: SystemState, *, moving: bool = False) -> None:
        """Go to a state: what it shows is worked out in another process."""
        if not moving and state != self.state:
            self.past = [*self.past[-UNDO:], self.state]
        self.state, self.message, self._due = state, "", True
        self.diagram.stand(state.value, state.x[0])
        if self._key_of(state) != self._key:
            self._search_at = time.monotonic() + QUIET
            self.stage = "another diagram is begun soon"

    @staticmethod
    def _key_of(state: SystemState) -> Any:
        rest = {name: v for name, v in state.values if name != state.parameter}
        return tuple(rest.items()), state.parameter, state.span, state.order

    def tick(self) -> None:
        """Begin what is due, and show what has come.

        A newer state waits until the motion of the last one was drawn, so that a drag shows it.
        """
        if not is_warm():
            return
        idle = self._answers is None or self._answers.is_over or self._told
        if self._due and idle:
            self._due, self._told = False, False
            if self._answers is not None:
                self._answers.stop()
            self._answers = Job(answers, self.given.path, self.state, seconds=ANSWERS)
        for result in self._answers.results() if self._answers is not None else ():
            self._take(result)
            self.say(self.answer())
        if time.monotonic() > self._search_at:
            self._search_at = np.inf
            if self._key_of(self.state) != self._key:
                self._search({})
        for result in self._branches.results() if self._branches is not None else ():
            self._take_branches(result)
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
        elif isinstance(result, Failure):
            self.message = result.sentence

    def _draw_motion(self) -> None:
        system, k = self.given.map_.system, self.state.coordinate
        names = str(system.q[k]), str((system.u or system.q)[k])
        if self._now is not None:
            self.motion.show(self._now, k, names)

    def _search(self, _: Mapping[str, Any]) -> None:
        if self._branches is not None:
            self._branches.stop()
        self._key, self.stage = self._key_of(self.state), "begins"
        self._show_diagram(None)
        self.diagram.figure.xaxis.axis_label = self.state.parameter
        self.diagram.look(self.state.span)
        self._branches = Job(diagram, self.given.path, self.state, seconds=DIAGRAM)

    def _take_branches(self, result: Any) -> None:
        if isinstance(result, DiagramProgress):
            found = result.shown
            count = f"{len(found.diagram.branches)} branches, {len(found.diagram.points)} points"
            self.stage = count if result.done else result.stage
            self._show_diagram(found)
        elif isinstance(result, Failure):
            self.stage = result.sentence

    def _show_diagram(self, found: Shown | None) -> None:
        self._shown = found
        self.diagram.show(found)
        self.graph.show(found)
        self._mark(self.branch)

    def _mark(self, branch: str) -> None:
        known = [b.id for b in self._shown.diagram.branches] if self._shown else []
        self.branch = branch if branch in known else ""
        self.diagram.select(self.branch)
        self.graph.select(self.branch)

    def answer(self) -> dict[str, Any]:
        """What the script of the page shows besides the views."""
        state, now = self.state, self._now
        branches = self._shown.diagram.branches if self._shown else ()
        return {
            "values": dict(state.values), "query": to_query(self.given, state),
            "message": self.message or (now.message if now else ""),
            "python": python_of(self.given, state), "order": state.order, "steps": state.steps,
            "start": ", ".join(f"{x:.10g}" for x in state.x), "periodic": state.periodic,
            "over": state.parameter, "coordinate": state.coordinate, "focus": state.focus,
            "numbers": now.numbers if now else {}, "stage": self.stage, "branch": self.branch,
            "running": self._branches is not None and not self._branches.is_over,
            "busy": self._due or (self._answers is not None and not self._answers.is_over),
            "branches": [
                {"id": b.id, "text": f"{b.id}: {b.kind} of P_{b.order}"} for b in branches[:400]
            ],
        }  # fmt: skip

    def end(self) -> None:
        """End what is being done in other processes."""
        for job in (self._answers, self._branches):
            if job is not None:
                job.stop()

    # --- What a user may ask for ------------------------------------------------------------------

    def verbs(self) -> dict[str, Callable[[Mapping[str, Any]], Mapping[str, Any]]]:
        """Everything that a wish can name."""
        verbs: dict[str, Callable[[Mapping[str, Any]], None]] = {
            "hello": lambda _: None,
            "set": self._set,
            "back": self._back,
            "reset": lambda _: self.show(first_state(self.given)),
            "undo": self._undo,
            "order": lambda wish: self._change(order=int(wish["value"])),
            "steps": lambda wish: self._change(steps=int(wish["value"])),
            "start": lambda wish: self._change(
                x=point(str(wish["value"]), len(self.state.x)), periodic=False
            ),
            "periodic": lambda wish: self._change(periodic=bool(wish["value"])),
            "over": lambda wish: self.show(over(self.given, self.state, str(wish["value"]))),
            "coordinate": self._coordinate,
            "focus": lambda wish: self._change(focus=str(wish["value"])),
            "branch": lambda wish: self._select(str(wish["value"])),
            "stop": self._stop,
            "search": self._search,
        }

        def answering(verb: Callable[[Mapping[str, Any]], None]) -> Any:
            def answer(wish: Mapping[str, Any]) -> Mapping[str, Any]:
                verb(wish)
                return self.answer()

            return answer

        return {name: answering(verb) for name, verb in verbs.items()}

    def _change(self, **changes: Any) -> None:
        self.show(replace(self.state, **changes))

    def _set(self, wish: Mapping[str, Any]) -> None:
        values = numbers(wish["values"], tuple(self.given.ranges))
        self.show(self.state.at(values), moving=bool(wish.get("drag")))

    def _back(self, wish: Mapping[str, Any]) -> None:
        name = str(wish["name"])
        self.show(self.state.at({name: self.given.values[name]}))

    def _undo(self, _: Mapping[str, Any]) -> None:
        if self.past:
            last = self.past.pop()
            self.show(last)
            self.past.pop()

    def _coordinate(self, wish: Mapping[str, Any]) -> None:
        self.state = replace(self.state, coordinate=int(wish["value"]))
        self._draw_motion()

    def _stop(self, _: Mapping[str, Any]) -> None:
        if self._branches is not None and not self._branches.is_over:
            self._branches.stop()
            self.stage = "stopped"

    def _select(self, branch: str, sample: int | None = None) -> None:
        """Bring everything to a branch: to a sample, or to its middle."""
        if self._shown is None:
            return
        found = self._shown.diagram
        k = len(found.branch(branch)) // 2 if sample is None else sample
        self.show(SystemModel(self.given).at_sample(self.state, found, branch, k))
        self._mark(branch)

    def _heard(self, verb: Callable[[Any], None]) -> Callable[[Any], None]:
        def hear(event: Any) -> None:
            if event.x is not None:
                verb(event)
                self.say(self.answer())

        return hear

    def _tap_map(self, event: Any) -> None:
        """Another start."""
        place = (float(event.x), float(event.y))[: len(self.state.x)]
        self._change(x=(*place, *self.state.x[len(place) :]), periodic=False)

    def _tap_diagram(self, event: Any) -> None:
        """The branch that was clicked on; elsewhere the parameter."""
        if self._shown is not None:
            scale = self.diagram.scale
            branch, away = nearest_line(self._shown.lines, event.x, event.y, scale)
            if branch and away <= CLICK:
                chosen = self._shown.diagram.branch(branch)
                self._select(branch, nearest_sample(chosen, event.x, event.y, scale))
                return
        self.show(self.state.at({self.state.parameter: float(event.x)}))

    def _tap_graph(self, event: Any) -> None:
        if self._shown is not None:
            branch, away = nearest_line(self._shown.edges, event.x, event.y, self.graph.scale)
            if branch and away <= 2.0 * CLICK:
                self._select(branch)


# --- Serving --------------------------------------------------------------------------------------


def controls(given: Explored) -> list[Control]:
    """A slider for each parameter of the system."""
    return [
        Control(
            name=name, label=name, meaning=f"parameter {name}", unit="-", low=low, high=high,
            step=(high - low) / 1000.0, default=repr(given.values[name]), group=GROUP,
        )
        for name, (low, high) in given.ranges.items()
    ]  # fmt: skip


def make_page(document: Document, given: Explored) -> SystemTab:
    """Fill the document of one tab."""
    state, refused = asked(document, partial(from_query, given), first_state(given))
    tab = SystemTab(given, state)
    tab.show(state)
    tab.message = refused
    system = given.map_.system
    title = f"{Path(given.path).stem}: a system of contacts"
    tab.say = fill(
        document, TEMPLATE, tab.roots, tab.verbs(), page_title=title, exports=list(FILES.items()),
        controls=[asdict(each) for each in controls(given)], open_group=GROUP,
        over=list(given.ranges), coordinates=[str(q) for q in system.q],
        contacts=[each.name for each in system.contacts], line=len(given.names) == 1,
    )  # fmt: skip
    document.title = title
    document.add_periodic_callback(tab.tick, TICK)
    document.on_session_destroyed(lambda _: tab.end())
    return tab


def run(path: str, port: int | None, *, stay: bool, ready: Callable[[str], None]) -> None:
    """Run a file, here and where jobs are forked from, and serve its page.

    Raises
    ------
    ValueError, TypeError
        If the file does not define what is needed.
    """
    given = explored(path)
    os.environ["WOODPECKER_EXPLORED"] = path  # for the process that jobs are forked from
    warm_up(["woodpecker.explore.system_warm"])

    def page(document: Document) -> None:
        make_page(document, given)

    site = Site(
        page=page, export=lambda name, query: (export, path, name, query),
        compare=f"{Path(path).stem}: two states",
    )  # fmt: skip
    serve(site, port, stay=stay, ready=ready)
