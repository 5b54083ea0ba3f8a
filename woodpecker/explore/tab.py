"""One tab: its state, the views that show it, and what a user may ask for."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from bokeh.events import RangesUpdate

from pwmap.explore.diagram_views import DiagramView, GraphView
from pwmap.explore.diagrams import Shown, nearest_line, nearest_sample
from pwmap.explore.figures import Put, on_click, patch
from pwmap.explore.jobs import Failure, Job, JobFinished, is_warm
from pwmap.explore.page import DrawnFrame, numbers
from woodpecker import Toy, parameters
from woodpecker.explore.branches import DiagramProgress, Key, at_sample, diagram, key_of, orbits
from woodpecker.explore.model import TOY_MODEL, DrawnMotion, MapCurve, Model, fine_map
from woodpecker.explore.state import PageState, python_of, to_query
from woodpecker.explore.tour import TOUR
from woodpecker.explore.views import PHI, MapView, MotionView, WordView, axis_label
from woodpecker.mechanics.toy import limits

REST = 0.12  # s after the last change until the map is looked at closely
QUIET = 0.5  # s until another diagram is begun
CLICK = 14.0  # px: what lies farther from a click was not meant
ON_BRANCH = 3.0  # px: a state so close to a branch is one of its solutions
UNDO = 100  # states that are kept
KNOWN = 12  # diagrams that are kept
SECONDS = 600.0  # s that a diagram may take
SHAPE = ("r_0", "r_m", "h_m", "l_m", "l_g", "h_s", "l_s", "phi_m_max", "phi_s_max")

known_diagrams: OrderedDict[Key, Shown] = OrderedDict()  # complete ones, shared by all tabs


@dataclass(slots=True)
class Work:
    """What is being done for a page in other processes."""

    curve: Job | None = None
    diagram: Job | None = None
    orbits: Job | None = None

    def stop(self) -> None:
        """End all of it."""
        for job in (self.curve, self.diagram, self.orbits):
            if job is not None:
                job.stop()


class Tab:
    """One tab."""

    def __init__(self, state: PageState, model: Model[PageState] = TOY_MODEL) -> None:
        self.model, self.state, self.message = model, state, ""
        self.past = list[PageState]()
        self.map, self.motion, self.word = MapView(), MotionView(), WordView()
        self.diagram, self.graph = DiagramView("diagram", "", PHI), GraphView("graph")
        self.work, self.stage, self.branch = Work(), "", ""
        self._shown: Shown | None = None
        self._now: DrawnMotion | None = None
        self._frame: DrawnFrame | None = None
        self._refine_at, self._search_at = np.inf, np.inf
        self._key: Key | None = None
        self._orbits_of: Any = None
        self.say: Callable[[Mapping[str, Any]], None] = lambda _: None

    # --- State -> views ---------------------------------------------------------------------------

    def show(self, state: PageState, *, moving: bool = False) -> None:
        """Go to a state: the fast views at once, the others when the page is at rest."""
        before, self.message = self.state, ""
        state, self.message = self.model.settled(state)
        if not moving and state != before:
            self.past = [*self.past[-UNDO:], before]
        self.state = state
        if self.work.curve is not None:
            self.work.curve.stop()
        self._frame = DrawnFrame() if moving else None
        put = self._put
        for curve in self.model.curves(state, fine=False):
            self.map.show(curve, state.order, put)
        self.map.follow(self.model.orbit(state), put)
        self._now = self.model.motion(state)
        self.motion.show(self._now, state, put, moving=moving)
        self.word.show(self._now.marks, put)
        self.diagram.stand(state.value, state.phi_s, put)
        if state.window != before.window:
            self.map.look(state.window)
        self._refine_at = time.monotonic() + REST
        if key_of(state) != self._key or (state.orbits and self._orbits_of != self._of_orbits()):
            self._search_at = time.monotonic() + QUIET
            self.stage = "another diagram is begun soon"
        if not moving:
            self._reselect()

    @property
    def _put(self) -> Put:
        """Where columns of tables go: into a letter while a slider moves."""
        return patch if self._frame is None else self._frame.put

    def begin(self) -> None:
        """Draw the first picture."""
        self.map.look(self.state.window)
        self.show(self.state)
        self._search_at = time.monotonic()

    @property
    def roots(self) -> list[Any]:
        """The figures, for the page."""
        motion = self.motion
        return [self.map.figure, self.diagram.figure, self.graph.figure, self.word.figure,
                motion.angles, motion.fall, motion.portrait]  # fmt: skip

    def answer(self, *, whole: bool = True) -> dict[str, Any]:
        """What the script of the page shows besides the views."""
        state, now = self.state, self._now
        told: dict[str, Any] = {
            "values": {n: _finite(getattr(state.toy, n)) for n in parameters()},
            "query": to_query(state), "start": state.phi_s, "periodic": state.periodic,
            "numbers": {n: _finite(v) for n, v in now.numbers.items()} if now else {},
            "message": self.message or (now.message if now else ""),
            "shape": {n: getattr(state.toy, n) for n in SHAPE}, "frame": self._frame,
        }  # fmt: skip
        if whole:
            told |= {
                "python": str(python_of(state)), "law": str(state.toy.expansion_friction),
                "order": state.order, "steps": state.steps, "over": state.parameter,
                "every": ",".join(map(str, state.every)), "orbits": state.orbits,
                "portrait": state.portrait, "focus": state.focus, "tour": self._tour(),
                "branches": self._branches(), **self._progress(),
            }  # fmt: skip
        return told

    def _tour(self) -> dict[str, Any]:
        if not self.state.tour:
            return {"step": 0, "of": len(TOUR)}
        step = TOUR[self.state.tour - 1]
        return {
            "step": self.state.tour, "of": len(TOUR), "title": step.title, "figure": step.figure,
            "text": step.text, "views": step.views,
        }  # fmt: skip

    def _branches(self) -> list[dict[str, Any]]:
        found = self._shown.diagram.branches if self._shown else ()
        return [
            {"id": b.id, "text": f"{b.id}: {b.kind} of P_{b.order}, {b.ends[0]} to {b.ends[1]}"}
            for b in found[:400]
        ]

    def _progress(self) -> dict[str, Any]:
        return {"stage": self.stage, "running": self._is_running(), "branch": self.branch}

    def _is_running(self) -> bool:
        return self.work.diagram is not None and not self.work.diagram.is_over

    def _reselect(self) -> None:
        """The branch that goes through where the page is."""
        self.branch = ""
        if self._shown is not None:
            scale = self.diagram.scale
            near = nearest_line(self._shown.lines, self.state.value, self.state.phi_s, scale)
            if near[1] < ON_BRANCH:
                self.branch = near[0]
        self.diagram.select(self.branch)
        self.graph.select(self.branch)

    # --- Other processes --------------------------------------------------------------------------

    def tick(self) -> None:
        """Begin what is due, and show what has come."""
        now = time.monotonic() if is_warm() else -np.inf
        if now > self._refine_at:
            self._refine_at = np.inf
            self.work.curve = Job(fine_map, self.state, seconds=60.0)
        if now > self._search_at:
            self._search_at = np.inf
            self._search()
        curve = self.work.curve
        for result in curve.results() if curve is not None else ():
            if isinstance(result, MapCurve):
                self._frame = DrawnFrame() if self._frame is not None else None
                self.map.show(result, self.state.order, self._put)
                self.say({"frame": self._frame})
        self._hear_of_branches()
        self._hear_of_orbits()

    def _search(self) -> None:
        """Look for the diagram of the state, unless it is known."""
        key = key_of(self.state)
        if key != self._key:
            self._key = key
            self.search(known=True)
        elif self._shown is not None and not self._is_running():
            self.stage = _complete(self._shown)
            self.say(self._progress())
        if self.state.orbits and self._orbits_of != self._of_orbits():
            self._orbits_of = self._of_orbits()
            if self.work.orbits is not None:
                self.work.orbits.stop()
            self.diagram.orbits.data = {"x": [], "y": []}
            self.work.orbits = Job(orbits, self.state, seconds=SECONDS)
        if not self.state.orbits:
            self.diagram.orbits.data = {"x": [], "y": []}
            self._orbits_of = None

    def _of_orbits(self) -> Any:
        key = key_of(self.state)
        return key.toy, key.parameter, key.span

    def search(self, *, known: bool) -> None:
        """Look for a diagram; one that is known is shown at once, if that will do."""
        state = self.state
        if self.work.diagram is not None:
            self.work.diagram.stop()
        self.diagram.figure.xaxis.axis_label = axis_label(state.parameter)
        self.diagram.look(state.span)
        found = known_diagrams.get(key_of(state)) if known else None
        if found is None:
            self.work.diagram = Job(diagram, state, seconds=SECONDS)
            self.stage = "begins"
        else:
            self.stage = _complete(found)
        self._take(found)

    def _take(self, found: Shown | None) -> None:
        self._shown = found
        self.diagram.show(found)
        self.graph.show(found)
        self._reselect()
        self.say({"branches": self._branches(), **self._progress()})

    def _hear_of_branches(self) -> None:
        job = self.work.diagram
        for result in job.results() if job is not None else ():
            if isinstance(result, DiagramProgress):
                self.stage = result.stage
                if result.done:
                    self.stage = _complete(result.shown)
                    if self._key is not None:
                        known_diagrams[self._key] = result.shown
                        while len(known_diagrams) > KNOWN:
                            known_diagrams.popitem(last=False)
                self._take(result.shown)
            elif isinstance(result, Failure):
                self.stage = result.sentence
                self.say(self._progress())
            elif isinstance(result, JobFinished):
                self.say(self._progress())

    def _hear_of_orbits(self) -> None:
        job = self.work.orbits
        for result in job.results() if job is not None else ():
            if isinstance(result, tuple):
                self.diagram.orbits.stream({"x": result[0], "y": result[1]})

    # --- What a user may ask for ------------------------------------------------------------------

    def verbs(self) -> dict[str, Callable[[Mapping[str, Any]], None]]:
        """Everything that a wish can name."""
        return {
            "hello": lambda _: None,
            "set": self._set,
            "back": lambda wish: self._default(str(wish["name"])),
            "reset": lambda _: self.show(PageState(tour=self.state.tour)),
            "undo": lambda _: self._undo(),
            "law": lambda wish: self.show(
                replace(self.state, toy=self.state.toy.replace(expansion_friction=wish["value"]))
            ),
            "order": lambda wish: self.show(replace(self.state, order=int(wish["value"]))),
            "steps": lambda wish: self.show(replace(self.state, steps=int(wish["value"]))),
            "start": lambda wish: self._start(float(wish["value"])),
            "periodic": lambda wish: self.show(replace(self.state, periodic=bool(wish["value"]))),
            "over": lambda wish: self.show(self.state.over(str(wish["value"]))),
            "every": lambda wish: self.show(replace(self.state, every=_orders(wish["value"]))),
            "orbits": lambda wish: self._orbits(bool(wish["value"])),
            "portrait": lambda wish: self.show(replace(self.state, portrait=str(wish["value"]))),
            "focus": lambda wish: self.show(replace(self.state, focus=str(wish["value"]))),
            "tour": lambda wish: self._go(int(wish["value"])),
            "branch": lambda wish: self._select(str(wish["value"])),
            "stop": lambda _: self._stop(),
            "search": lambda _: self.search(known=False),
            "home": lambda wish: self._home(str(wish["value"])),
        }

    def _set(self, wish: Mapping[str, Any]) -> None:
        values = numbers(wish["values"], parameters())
        self.show(self.state.with_values(values), moving=bool(wish.get("drag")))

    def _default(self, name: str) -> None:
        if name not in parameters():
            raise ValueError(f"unknown parameter {name[:40]!r}")
        self.show(self.state.with_values({name: getattr(Toy(), name)}))

    def _undo(self) -> None:
        if self.past:
            last = self.past.pop()
            self.show(last)
            self.past.pop()

    def _start(self, phi_s: float) -> None:
        if not phi_s < self.state.toy.phi_s_max:
            raise ValueError(
                f"a start lies below {self.state.toy.phi_s_max:.6g} rad, where the beak touches "
                f"the pole, got {phi_s:.6g}"
            )
        self.show(replace(self.state, phi_s=phi_s, periodic=False))

    def _orbits(self, wanted: bool) -> None:
        self.show(replace(self.state, orbits=wanted))
        self._search_at = time.monotonic()

    def _go(self, step: int) -> None:
        free = replace(self.state, tour=step if step < 1 or step > len(TOUR) else 0)
        self.show(TOUR[step - 1].state if 1 <= step <= len(TOUR) else free)
        self.map.look(self.state.window)

    def _select(self, branch: str, sample: int | None = None) -> None:
        """Bring everything to a branch: to a sample, or to where it is nearest to the page."""
        if self._shown is None:
            return
        chosen = self._shown.diagram.branch(branch)
        if sample is None:
            away = np.abs(chosen.parameter - self.state.value)
            inner = int(np.argmin(away))
            sample = inner if 0 < inner < len(chosen) - 1 else len(chosen) // 2
        self.show(at_sample(self.state, chosen, sample))
        self.branch = branch
        self.diagram.select(branch)
        self.graph.select(branch)
        if not self.state.periodic:
            self.message = f"{branch} is a jump crossing: no motion repeats here, the map jumps"

    def _stop(self) -> None:
        if self.work.diagram is not None and not self.work.diagram.is_over:
            self.work.diagram.stop()
            self.stage = "stopped"

    def _home(self, view: str) -> None:
        if view == "map":
            self.show(replace(self.state, window=PageState().window))
            self.map.look(self.state.window)
        else:
            self.diagram.look(self.state.span)

    def clicks(self) -> None:
        """Clicks on figures, and a closer look at the map where its picture is moved."""

        def heard(verb: Callable[[Any], None]) -> Callable[[Any], None]:
            def hear(event: Any) -> None:
                verb(event)
                self.say(self.answer())

            return hear

        on_click(self.map.figure, heard(self._tap_map))
        on_click(self.diagram.figure, heard(self._tap_diagram))
        on_click(self.graph.figure, heard(self._tap_graph))
        self.map.figure.on_event(RangesUpdate, heard(self._zoom_map))
        self.diagram.figure.on_event(RangesUpdate, self._zoom_diagram)

    def _tap_map(self, event: Any) -> None:
        """A start: near a fixed point the periodic motion, otherwise any."""
        limit = self.state.toy.phi_s_max
        if event.x is None or not event.x < limit:
            return
        span = self.state.window[1] - self.state.window[0]
        fixed = np.asarray(self.map.fixed.data["x"], dtype=float)
        near = fixed[np.abs(fixed - event.x) < 0.012 * span]
        if len(near) and abs(event.y - near[0]) < 0.03 * span:
            self.show(replace(self.state, phi_s=float(near[0]), periodic=True))
        else:
            self.show(replace(self.state, phi_s=float(event.x), periodic=False))

    def _tap_diagram(self, event: Any) -> None:
        """The branch that was clicked on; elsewhere the parameter and a start."""
        if event.x is None:
            return
        if self._shown is not None:
            scale = self.diagram.scale
            branch, away = nearest_line(self._shown.lines, event.x, event.y, scale)
            if branch and away <= CLICK:
                chosen = self._shown.diagram.branch(branch)
                self._select(branch, nearest_sample(chosen, event.x, event.y, scale))
                return
        low, high = limits(self.state.toy, self.state.parameter)
        state = self.state.with_values({self.state.parameter: min(max(event.x, low), high)})
        if event.y < state.toy.phi_s_max:
            self.show(replace(state, phi_s=float(event.y), periodic=False))

    def _tap_graph(self, event: Any) -> None:
        if event.x is None or self._shown is None:
            return
        branch, away = nearest_line(self._shown.edges, event.x, event.y, self.graph.scale)
        if branch and away <= 2.0 * CLICK:
            self._select(branch)

    def _zoom_diagram(self, _: Any) -> None:
        self.diagram.moved = True

    def _zoom_map(self, event: Any) -> None:
        low, high = max(event.x0, -50.0), min(event.x1, 1.0)
        if low < high and (low, high) != self.state.window and low < self.state.toy.phi_s_max:
            self.state = replace(self.state, window=(low, high))
            self._refine_at = time.monotonic() + REST


def _finite(value: float) -> float | None:
    """A number that JSON can say."""
    return value if np.isfinite(value) else (0.0 if value > 0 else None)


def _orders(value: object) -> tuple[int, ...]:
    return tuple(int(part) for part in str(value).split(",") if part)


def _complete(found: Shown) -> str:
    return f"{len(found.diagram.branches)} branches, {len(found.diagram.points)} points"
