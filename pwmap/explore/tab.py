"""The base of all tabs: a state with its history, the diagram and its graph, jobs, wishes."""

from __future__ import annotations

import json
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np
from bokeh.document import Document
from bokeh.models import ColumnDataSource

from pwmap.explore.diagram_views import DiagramView, GraphView, scale_of
from pwmap.explore.diagrams import NOTHING, Shown, nearest_line, nearest_sample, summary
from pwmap.explore.figures import on_click
from pwmap.explore.jobs import Job, JobEnd, Work
from pwmap.explore.link import LinkedState, as_text
from pwmap.explore.page import DrawnFrame, Letter, environment, in_words, read_wish

CLICK = 14.0  # px: what lies farther from a click was not meant
UNDO = 100  # states that are kept
TICK = 50  # ms between looks at what other processes have sent
QUIET = 0.5  # s after the last change until another diagram is begun
LONGEST = 600.0  # s that a diagram may take
LISTED = 400  # branches in the list of a page
S = TypeVar("S", bound=LinkedState)
Demand = Callable[[Mapping[str, Any]], None]


class Tab(ABC, Generic[S]):
    """One tab of a browser; subclasses show more than the diagram.

    A reset goes back to the state ``first``. The first of ``figures`` is the map. ``message`` is
    about the state, ``stage`` about the search for the diagram, of which ``shown`` is found;
    ``branch`` is the selected one, or empty.
    """

    TEXTS: ClassVar[tuple[str, ...]] = ("order", "steps", "focus")  # fields that a wish changes

    def __init__(self, state: S, first: S, figures: Sequence[Any], y_label: str) -> None:
        self.state, self.first, self.past = state, first, list[S]()
        self._before: S | None = None  # where a slider began to move
        self.message, self.stage, self.branch = "", "", ""
        self.diagram, self.graph = DiagramView("diagram", "", y_label), GraphView("graph")
        self.shown = NOTHING
        self.clicks = 0  # that were heard
        self.jobs = dict[str, Job]()
        self._key: Hashable = None  # of the diagram that is searched for or shown
        self._search_at = np.inf
        self._wish, self._answer, self._count = Letter(name="wish"), Letter(name="answer"), 0
        self._numbers = ColumnDataSource({"all": np.empty(0)}, name="numbers")  # of a frame
        self.roots = [figures[0], self.diagram.figure, self.graph.figure, *figures[1:]]
        taps = self._tap_map, self._tap_diagram, self._tap_graph
        for figure, verb in zip(self.roots, taps, strict=False):
            self.hear(figure, verb)

    # --- What a subclass says ---------------------------------------------------------------------

    @abstractmethod
    def show(self, state: S, *, moving: bool = False) -> None:
        """Go to a state; ``moving`` while a slider is dragged."""

    @abstractmethod
    def tick(self) -> None:
        """Start due jobs, and show results that have arrived."""

    @abstractmethod
    def told(self, *, whole: bool) -> dict[str, Any]:
        """What only this page shows; without ``whole`` only what changes with a slider."""

    def demands(self) -> Mapping[str, Demand]:
        """The wishes of this page besides those of every tab."""
        return {}

    @abstractmethod
    def _tap_map(self, event: Any) -> None:
        """A click on the map."""

    @abstractmethod
    def _tap_beside(self, event: Any) -> None:
        """A click on the diagram, away from all branches."""

    # --- State and diagram ------------------------------------------------------------------------

    def keep(self, state: S, *, moving: bool) -> None:
        """Take a state; for *undo* the one before is kept, or where a slider began to move."""
        before = self.state if self._before is None else self._before
        if not moving and state != before:
            self.past = [*self.past[-UNDO:], before]
        self._before = before if moving else None
        self.state, self.message = state, ""

    def change(self, **changes: Any) -> None:
        """Go to a state that differs in some fields."""
        state: Any = self.state
        self.show(replace(state, **changes))

    def key(self) -> Hashable:
        """All that the diagram of the state depends on."""

    def search_soon(self) -> None:
        """Begin another diagram when the state has rested."""
        self._search_at = time.monotonic() + QUIET
        self.stage = "another diagram is begun soon"

    def search(self, work: Work, label: str, found: Shown = NOTHING) -> None:
        """Begin the search for a diagram, or show one that was found before."""
        state: Any = self.state
        self._key = self.key()
        self.stop("diagram")
        self.diagram.figure.xaxis.axis_label = label
        self.diagram.look(state.span)
        if found is NOTHING:
            self.begin("diagram", work, state, seconds=LONGEST)
        self.stage = "begins" if found is NOTHING else summary(found)
        self.draw_diagram(found)

    def draw_diagram(self, found: Shown) -> None:
        """Draw a diagram and its graph."""
        self.shown = found
        self.diagram.show(found)
        self.graph.show(found)
        self.mark(self.branch)

    def mark(self, branch: str) -> None:
        """Select a branch; none if the diagram does not have it."""
        known = [each.id for each in self.shown.diagram.branches]
        self.branch = branch if branch in known else ""
        self.diagram.select(self.branch)
        self.graph.select(self.branch)

    def go_to(self, branch: str, sample: int | None = None) -> None:
        """Go to a branch: to a sample, or to its point nearest to the place of the page."""
        if branch:
            chosen = self.shown.diagram.branch(branch)
            if sample is None:
                inner = int(np.argmin(np.abs(chosen.parameter - self.state.value)))
                sample = inner if 0 < inner < len(chosen) - 1 else len(chosen) // 2
            self.show(self.state.at_sample(chosen, sample))
        self.mark(branch)

    def answer(self, *, whole: bool = True) -> dict[str, Any]:
        """The texts that the script of the page shows besides the views."""
        state, told = self.state, dict[str, Any]()
        if whole:
            told = {"python": state.python(), **self.progress(), "branches": self.branches()}
            told |= state.told()
        told |= {"message": self.message, "values": state.place, "query": state.query()}
        return told | self.told(whole=whole)

    def branches(self) -> list[dict[str, str]]:
        """The list of branches."""
        return [
            {"id": each.id, "text": f"{each.id}: {each.kind} of P_{each.order}, "
             f"{each.ends[0]} to {each.ends[1]}"}
            for each in self.shown.diagram.branches[:LISTED]
        ]  # fmt: skip

    def progress(self) -> dict[str, Any]:
        """The progress of the search for the diagram."""
        return {
            "stage": self.stage, "running": self.is_running("diagram"), "branch": self.branch,
        }  # fmt: skip

    # --- Other processes --------------------------------------------------------------------------

    def begin(self, name: str, work: Work, *arguments: Any, seconds: float) -> None:
        """Start a job in place of the one with this name."""
        self.stop(name)
        self.jobs[name] = Job(work, *arguments, seconds=seconds)

    def results(self, name: str) -> list[Any]:
        """The results of a job since the last call."""
        return self.jobs[name].results() if name in self.jobs else []

    def is_running(self, name: str) -> bool:
        """Whether there is a job of this name that has not ended."""
        return name in self.jobs and not self.jobs[name].is_over

    def stop(self, name: str) -> None:
        """End a job, if there is one."""
        if name in self.jobs:
            self.jobs.pop(name).stop()

    def end(self) -> None:
        """End all jobs."""
        for name in tuple(self.jobs):
            self.stop(name)

    # --- What a user may ask for ------------------------------------------------------------------

    def all_demands(self) -> dict[str, Demand]:
        """What each wish does, by its name."""
        return {
            "hello": lambda _: None,
            "undo": lambda _: self._undo(),
            "reset": lambda _: self.show(self.first),
            "set": self._set,
            "back": lambda wish: self._back(str(wish["name"])),
            "over": lambda wish: self.show(self.state.with_axis(str(wish["value"]))),
            **{name: partial(self._read, name) for name in self.TEXTS},
            "branch": lambda wish: self.go_to(str(wish["value"])),
            "stop": lambda _: self._stop_search(),
            **self.demands(),
        }

    def _back(self, name: str) -> None:
        self.show(self.state.at({name: self.first.place[name]}))

    def _set(self, wish: Mapping[str, Any]) -> None:
        self.show(self.state.at(wish["values"]), moving=bool(wish.get("drag")))

    def _read(self, name: str, wish: Mapping[str, Any]) -> None:
        self.change(**{name: self.state.read(name, as_text(wish["value"]))})

    def _undo(self) -> None:
        if self.past:
            *before, last = self.past
            self.show(last)
            self.past = before

    def take_progress(self, result: Any) -> None:
        """Show a diagram as far as it was found, or why its search has ended."""
        if isinstance(result, Shown):
            self.stage = result.stage or summary(result)
            self.draw_diagram(result)
        elif isinstance(result, JobEnd) and result.sentence:
            self.stage = "; so far ".join([result.sentence, *self._so_far()])

    def _stop_search(self) -> None:
        if self.is_running("diagram"):
            self.stop("diagram")
            self.stage = ": ".join(["stopped", *self._so_far()])

    def _so_far(self) -> list[str]:
        return [] if self.shown is NOTHING else [summary(self.shown)]

    def hear(self, figure: Any, verb: Callable[[Any], None]) -> None:
        """Call a function with each click on a figure, and tell the page what it shows then."""

        def hear(event: Any) -> None:
            if event.x is None:
                return
            try:
                verb(event)
            except (ValueError, ArithmeticError) as error:
                self.message = in_words(error)
            self.clicks += 1
            self.say({**self.answer(), "clicks": self.clicks})

        on_click(figure, hear)

    def _tap_diagram(self, event: Any) -> None:
        scale = scale_of(self.diagram.figure)
        branch, away = nearest_line(self.shown.lines, event.x, event.y, scale)
        if away <= CLICK:
            chosen = self.shown.diagram.branch(branch)
            self.go_to(branch, nearest_sample(chosen, event.x, event.y, scale))
        else:
            self._tap_beside(event)

    def _tap_graph(self, event: Any) -> None:
        scale = scale_of(self.graph.figure)
        branch, away = nearest_line(self.shown.edges, event.x, event.y, scale)
        if away <= 2.0 * CLICK:
            self.go_to(branch)

    # --- Letters ----------------------------------------------------------------------------------

    def put_on(self, document: Document, template: Path, title: str, **variables: Any) -> None:
        """Fill a document by a template that extends ``shell.html``, with its variables."""
        self._answer.text = ""  # nobody has asked
        self._wish.on_change("text", self._heard)
        self.roots[0].tags = [self._wish, self._answer, self._numbers]  # parts of the document
        for root in self.roots:
            document.add_root(root)
        document.title = title
        document.template = environment(template.parent).get_template(template.name)
        document.template_variables.update(page_title=title, **variables)
        document.add_periodic_callback(self.tick, TICK)
        document.on_session_destroyed(lambda _: self.end())

    def say(self, values: Mapping[str, Any]) -> None:
        """Send values to the script of the page, perhaps with a :class:`DrawnFrame`."""
        self._count += 1
        told = {**values, "count": self._count}
        frame: DrawnFrame | None = told.pop("frame", None)
        if frame is not None:
            self._numbers.data = {"all": frame.numbers}
            told["tables"] = frame.tables
        self._answer.text = json.dumps(told)

    def _heard(self, _: str, __: str, text: str) -> None:
        told: dict[str, Any] = {}
        try:
            wish = read_wish(text)
            told["n"] = wish["n"]
            demands = self.all_demands()
            if wish["do"] not in demands:
                raise ValueError(f"unknown wish {wish['do'][:40]!r}")
            demands[wish["do"]](wish)
            told |= self.answer(whole=not wish.get("drag"))
        except (ValueError, TypeError, KeyError, ArithmeticError) as error:
            told["message"] = in_words(error)
        self.say(told)
