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
from bokeh.events import DoubleTap, RangesUpdate, Tap

from pwmap.explore.diagram_views import diagram_figure, fit, graph_figure, part, scale_of
from pwmap.explore.diagrams import NOTHING, nearest_line, nearest_sample, summary
from pwmap.explore.exports import Files
from pwmap.explore.figures import Shown, Table, keep_in, patch, set_range, tables_of
from pwmap.explore.jobs import Job, Work, is_warm
from pwmap.explore.link import LinkedState, as_text
from pwmap.explore.page import Letter, environment, in_words, packed, read_wish

CLICK = 14.0  # px: a branch farther from a click was not meant
UNDO = 100  # states that are kept for undo
TICK = 50  # ms between looks at what is due, and at what other processes have sent
QUIET = 0.5  # s after the last change until another diagram is begun
LONGEST = 600.0  # s that a diagram may take
LISTED = 400  # branches in the list of a page
KNOWN = 12  # diagrams that are kept
S = TypeVar("S", bound=LinkedState)
Demand = Callable[[Mapping[str, Any]], None]
Take = Callable[[Any], None]

known_diagrams = dict[Hashable, Shown]()  # complete ones, shared by all tabs


class Tab(ABC, Generic[S]):
    """One tab of a browser; subclasses show more than the diagram.

    A reset goes back to the state ``first``. The first of ``figures`` is the map. ``message`` is
    about the state, ``stage`` about the search for the diagram; ``found`` is what is known of it,
    ``branch`` the selected branch, or empty.
    """

    WORK: ClassVar[Work]  # the search for the diagram of a state

    def __init__(self, state: S, first: S, figures: Sequence[Any], y_label: str) -> None:
        self.state, self.first, self.past = state, first, list[S]()
        self._before: S | None = None  # the state in which a slider began to move
        self.message, self.stage, self.branch = "", "", ""
        self.roots = [figures[0], diagram_figure(y_label), graph_figure(), *figures[1:]]
        self.figures = {each.name: each for each in self.roots}
        self.tables = tables_of(self.roots)
        self.sketched: dict[str, Table] | None = None  # to draw by letter; None if no slider moves
        self.found = NOTHING
        self._looked = False  # whether the user has zoomed into the diagram
        self.clicks = 0  # handled so far
        self.jobs = dict[str, tuple[Job, Take]]()
        self.due = dict[Callable[[], None], float]()
        self._key: Hashable = None  # of the diagram that is searched for or shown
        self._wish, self._answer, self._count = Letter(name="wish"), Letter(name="answer"), 0
        taps = self._tap_map, self._tap_diagram, self._tap_graph
        for figure, verb in zip(self.roots, taps, strict=False):
            self.hear(figure, verb)
        self.figures["diagram"].on_event(RangesUpdate, self._zoom_diagram)

    # --- What a subclass says ---------------------------------------------------------------------

    @abstractmethod
    def show(self, state: S, *, moving: bool = False) -> None:
        """Go to a state; ``moving`` while a slider is dragged."""

    @abstractmethod
    def told(self, *, whole: bool) -> dict[str, Any]:
        """What this kind of page shows besides; without ``whole`` what changes with a slider."""

    @abstractmethod
    def _tap_map(self, event: Any) -> None:
        """A click on the map."""

    @abstractmethod
    def _tap_beside(self, event: Any) -> None:
        """A click on the diagram, away from all branches."""

    def key(self) -> Hashable:
        """All that the diagram of the state depends on; None if no job searches for it."""

    @abstractmethod
    def axis(self) -> str:
        """The label of the diagram's parameter."""

    # --- State -> views ---------------------------------------------------------------------------

    def keep(self, state: S, *, moving: bool) -> None:
        """Take a state; *undo* goes back to the one before, or to where a slider began to move."""
        before = self.state if self._before is None else self._before
        if not moving and state != before:
            self.past = [*self.past[-UNDO:], before]
        self._before = before if moving else None
        self.state, self.message = state, ""
        self.later(QUIET, self.seek)

    def change(self, **changes: Any) -> None:
        """Go to a state that differs in some fields."""
        state: Any = self.state
        self.show(replace(state, **changes))

    def draw(self, shown: Shown) -> None:
        """Draw through Bokeh or, while a slider moves, with the next letter."""
        moving = self.sketched is not None
        if self.sketched is None:
            self._patch(shown.tables)
        else:
            self.sketched.update(shown.tables)
        for name, (left, right, low, high) in shown.ends.items():
            keep_in(self.figures[name].x_range, left, right, moving=moving)
            keep_in(self.figures[name].y_range, low, high, moving=moving)
        for name, labels in shown.labels.items():
            figure = self.figures[name]
            figure.xaxis.axis_label, figure.yaxis.axis_label = labels

    def stand(self, x: float) -> Shown:
        """The current place in the diagram, at height ``x``; nan draws none."""
        return Shown(tables={"here": {"x": [self.state.value], "y": [x]}})

    def _patch(self, tables: Mapping[str, Table]) -> None:
        for name, columns in tables.items():
            patch(self.tables[name], **columns)

    # --- The diagram ------------------------------------------------------------------------------

    def seek(self) -> None:
        """Search for the diagram of the state, unless that is the one that is shown."""
        if self.key() != self._key:
            self.search(known_diagrams.get(self.key(), NOTHING))

    def search(self, found: Shown = NOTHING) -> None:
        """Begin the search for the diagram of the state, or show one that was found before."""
        self._key = self.key()
        self.stop("diagram")
        self.look()
        self.take_diagram(found)
        if found is NOTHING:
            self.stage = "begins"
            self.begin("diagram", self.take_diagram, self.WORK, self.state, seconds=LONGEST)

    def look(self) -> None:
        """Show the whole diagram."""
        figure = self.figures["diagram"]
        low, high = self.state.ends
        margin = 0.015 * (high - low)
        set_range(figure.x_range, low - margin, high + margin)
        self._looked = False
        fit(figure, self.tables["samples"].data)

    def take_diagram(self, found: Shown) -> None:
        """Show a diagram and its graph, as far as they are found."""
        self.found, self.stage = found, found.message or summary(found.diagram)
        self._patch(found.tables)
        self.figures["diagram"].xaxis.axis_label = self.axis()
        if not self._looked:
            fit(self.figures["diagram"], self.tables["samples"].data)
        self.mark(self.branch_here())

    def ended(self, name: str, sentence: str) -> None:
        """Say why a job failed, if it did; a diagram that is complete is kept."""
        if name != "diagram":
            self.message = sentence or self.message
        elif sentence:
            self.stage = "; so far ".join([sentence, *self._so_far()])
        else:
            known_diagrams[self._key] = self.found
            for old in [*known_diagrams][:-KNOWN]:
                del known_diagrams[old]

    def mark(self, branch: str) -> None:
        """Select a branch; none if the diagram does not have it."""
        known = [each.id for each in self.found.diagram.branches]
        self.branch = branch if branch in known else ""
        for table, lines in (("selected", "lines"), ("chosen", "edges")):
            self._patch({table: part(self.tables[lines].data, self.branch)})

    def branch_here(self) -> str:
        """The branch that is selected when a diagram is drawn."""
        return self.branch

    def go_to(self, branch: str, sample: int | None = None) -> None:
        """Go to a branch: to a sample, or to its point nearest to the place of the page."""
        if branch:
            chosen = self.found.diagram.branch(branch)
            if sample is None:
                inner = int(np.argmin(np.abs(chosen.parameter - self.state.value)))
                sample = inner if 0 < inner < len(chosen) - 1 else len(chosen) // 2
            self.show(self.state.at_sample(chosen, sample))
        self.mark(branch)

    def _so_far(self) -> list[str]:
        return [] if self.found is NOTHING else [summary(self.found.diagram)]

    # --- Work that is due, and other processes ----------------------------------------------------

    def later(self, seconds: float, do: Callable[[], None]) -> None:
        """Call a function after some time, counted from the latest call of this."""
        self.due[do] = time.monotonic() + seconds

    def tick(self) -> None:
        """Do what is due, take the results that have arrived, and tell the page."""
        if not is_warm():
            return
        now = time.monotonic()
        due = [do for do, at in self.due.items() if at <= now]
        for do in due:
            if self.due.pop(do, None) is not None:
                do()
        if sum(map(self._hear_job, tuple(self.jobs))) or due:
            self.say(self.answer())

    def _hear_job(self, name: str) -> bool:
        """Take the results of a job; returns whether there is anything new."""
        moving = self.sketched is not None and self.seek in self.due
        if name not in self.jobs or (name == "diagram" and moving):  # it takes long to draw
            return False
        job, take = self.jobs[name]
        results = job.results()
        for result in results:
            take(result)
        if job.is_over:
            self.stop(name)
            self.ended(name, job.sentence)
        return bool(results) or job.is_over

    def begin(self, name: str, take: Take, work: Work, *arguments: Any, seconds: float) -> None:
        """Start a job in place of the one with this name, and take each of its results."""
        self.stop(name)
        self.jobs[name] = Job(work, *arguments, seconds=seconds), take

    def stop(self, name: str) -> None:
        """End a job, if there is one."""
        if name in self.jobs:
            self.jobs.pop(name)[0].stop()

    def end(self) -> None:
        """End all jobs."""
        for name in tuple(self.jobs):
            self.stop(name)

    # --- What the page shows beside the views -----------------------------------------------------

    def answer(self, *, whole: bool = True) -> dict[str, Any]:
        """Texts and numbers for the script of the page; not ``whole`` while a slider moves."""
        state, told = self.state, dict[str, Any]()
        if whole:
            soon = self.seek in self.due and self.key() != self._key
            told = {
                "python": state.python(), "branch": self.branch, "branches": self._branches(),
                "stage": "another diagram is begun soon" if soon else self.stage,
                "running": "diagram" in self.jobs, **state.told(),
            }  # fmt: skip
        told |= {"message": self.message, "values": state.place, "query": state.query()}
        return told | self.told(whole=whole)

    def _branches(self) -> list[dict[str, str]]:
        return [
            {"id": each.id, "text": f"{each.id}: {each.kind} of P_{each.order}, "
             f"{each.ends[0]} to {each.ends[1]}"}
            for each in self.found.diagram.branches[:LISTED]
        ]  # fmt: skip

    # --- What a user may ask for ------------------------------------------------------------------

    def demands(self) -> dict[str, Demand]:
        """The functions of all wishes by name; the name of a field sets that field."""
        return {
            **{name: partial(self._set, name) for name in self.state.names().values()},
            "hello": lambda _: None,
            "undo": lambda _: self._undo(),
            "reset": lambda _: self.show(self.first),
            "set": lambda wish: self.show(
                self.state.at(wish["values"]), moving=bool(wish.get("drag"))
            ),
            "back": lambda wish: self._back(str(wish["name"])),
            "over": lambda wish: self.show(self.state.with_axis(str(wish["value"]))),
            "branch": lambda wish: self.go_to(str(wish["value"])),
            "stop": lambda _: self._stop_search(),
            "search": lambda _: self.search(),
        }

    def _back(self, name: str) -> None:
        self.show(self.state.at({name: self.first.place[name]}))

    def _read(self, name: str, wish: Mapping[str, Any], called: str = "") -> Any:
        return self.state.read(name, as_text(wish["value"]), called)

    def _set(self, name: str, wish: Mapping[str, Any]) -> None:
        self.change(**{name: self._read(name, wish)})

    def _undo(self) -> None:
        if self.past:
            *before, last = self.past
            self.show(last)
            self.past = before

    def _stop_search(self) -> None:
        if "diagram" in self.jobs:
            self.stop("diagram")
            self.stage = ": ".join(["stopped", *self._so_far()])

    def hear(self, figure: Any, verb: Callable[[Any], None]) -> None:
        """Call a function with each click on a figure, then send the page what it shows now."""

        def hear(event: Any) -> None:
            if event.x is None:
                return
            try:
                verb(event)
            except (ValueError, ArithmeticError) as error:
                self.message = in_words(error)
            self.clicks += 1
            self.say({**self.answer(), "clicks": self.clicks})

        for event in (Tap, DoubleTap):  # Bokeh takes two within 0.3 s for a double click
            figure.on_event(event, hear)

    def _zoom_diagram(self, _: Any) -> None:
        self._looked = True

    def _tap_diagram(self, event: Any) -> None:
        scale = scale_of(self.figures["diagram"])
        branch, away = nearest_line(self.tables["lines"].data, event.x, event.y, scale)
        if away <= CLICK:
            chosen = self.found.diagram.branch(branch)
            self.go_to(branch, nearest_sample(chosen, event.x, event.y, scale))
        else:
            self._tap_beside(event)

    def _tap_graph(self, event: Any) -> None:
        scale = scale_of(self.figures["graph"])
        branch, away = nearest_line(self.tables["edges"].data, event.x, event.y, scale)
        if away <= 2.0 * CLICK:
            self.go_to(branch)

    # --- Letters ----------------------------------------------------------------------------------

    def put_on(
        self, document: Document, template: Path, title: str, files: Files, **variables: Any
    ) -> None:
        """Fill a document by a template that extends ``shell.html``, with its variables."""
        exports = [(name, text) for name, (text, _) in files.items()]
        self._answer.text = ""  # no wish was made yet
        self._wish.on_change("text", self._heard)
        self.roots[0].tags = [self._wish, self._answer]  # so that they are in the document
        for root in self.roots:
            document.add_root(root)
        document.title = title
        document.template = environment(template.parent).get_template(template.name)
        document.template_variables.update(page_title=title, exports=exports, **variables)
        document.add_periodic_callback(self.tick, TICK)
        document.on_session_destroyed(lambda _: self.end())

    def say(self, values: Mapping[str, Any]) -> None:
        """Send values to the script of the page, and the tables that a moving slider changed."""
        self._count += 1
        told = {**values, "count": self._count}
        if self.sketched is not None:
            told["tables"], self._answer.numbers = packed(self.sketched)
            self.sketched = {}
        self._answer.text = json.dumps(told)

    def _heard(self, _: str, __: str, text: str) -> None:
        told: dict[str, Any] = {}
        try:
            wish = read_wish(text)
            told["n"] = wish["n"]
            demands = self.demands()
            if wish["do"] not in demands:
                raise ValueError(f"unknown wish {wish['do'][:40]!r}")
            demands[wish["do"]](wish)
            told |= self.answer(whole=not wish.get("drag"))
        except (ValueError, TypeError, KeyError, ArithmeticError) as error:
            self.message = told["message"] = in_words(error)
        self.say(told)
