"""The page of the toy, and its server."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from bokeh.document import Document
from bokeh.events import RangesUpdate

from pwmap.explore.diagram_views import scale_of
from pwmap.explore.diagrams import NOTHING, Shown, nearest_line, summary
from pwmap.explore.exports import OF_DIAGRAM
from pwmap.explore.figures import Put, patch
from pwmap.explore.jobs import is_warm, warm_up
from pwmap.explore.link import as_text
from pwmap.explore.page import DrawnFrame, asked, control
from pwmap.explore.serving import serve
from pwmap.explore.tab import LONGEST, QUIET, Demand, Tab
from woodpecker import Toy, parameters
from woodpecker.explore import model
from woodpecker.explore.branches import diagram, key_of, of_orbits, orbits
from woodpecker.explore.exports import FILES, export
from woodpecker.explore.model import DrawnMotion, MapCurve
from woodpecker.explore.state import PageState, from_query
from woodpecker.explore.tour import TOUR
from woodpecker.explore.views import BOTH, CONTACTS, PHI, MapView, MotionView, WordView, axis_label
from woodpecker.mechanics.toy import description, limits
from woodpecker.plot import drawing

TEMPLATE = Path(__file__).parent / "files" / "woodpecker.html"
FIRST = "1:friction and restitution"  # groups are in the order of their numbers
LABELS = {
    "m_m": "m<sub>M</sub>", "j_m": "J<sub>M</sub>", "m_s": "m<sub>S</sub>", "j_s": "J<sub>S</sub>",
    "g": "g", "r_0": "r<sub>0</sub>", "r_m": "r<sub>M</sub>", "h_m": "h<sub>M</sub>",
    "l_m": "l<sub>M</sub>", "l_g": "l<sub>G</sub>", "h_s": "h<sub>S</sub>", "l_s": "l<sub>S</sub>",
    "c_phi": "c<sub>φ</sub>", "mu_1": "μ<sub>1</sub>", "mu_2": "μ<sub>2</sub>",
    "mu_3": "μ<sub>3</sub>", "eps_n1": "ε<sub>N1</sub>", "eps_n2": "ε<sub>N2</sub>",
    "eps_n3": "ε<sub>N3</sub>", "pole": "pole",
}  # fmt: skip
PLAIN = {"eps_n1": "εN1", "eps_n2": "εN2", "eps_n3": "εN3", "mu_1": "μ1", "mu_2": "μ2",
         "mu_3": "μ3", "c_phi": "cφ"}  # fmt: skip
REST = 0.12  # s after the last change until Bokeh draws it, and the map is looked at closely
ON_BRANCH = 3.0  # px: a state so close to a branch is one of its solutions
KNOWN = 12  # diagrams that are kept
SHAPE = ("r_0", "r_m", "h_m", "l_m", "l_g", "h_s", "l_s", "phi_m_max", "phi_s_max")

known_diagrams: OrderedDict[Hashable, Shown] = OrderedDict()  # complete ones, shared by all tabs


class ToyTab(Tab[PageState]):
    """One tab of the toy."""

    TEXTS = (*Tab.TEXTS, "periodic", "every", "portrait")

    def __init__(self, state: PageState) -> None:
        self.map, self.motion, self.word = MapView(), MotionView(), WordView()
        motion = self.motion
        figures = self.word.figure, motion.angles, motion.fall, motion.portrait
        super().__init__(state, PageState(), [self.map.figure, *figures], PHI)
        self._now: DrawnMotion | None = None
        self._frame: DrawnFrame | None = None  # from a change until Bokeh has drawn it
        self._rest_at, self._refine_at, self._still_at = np.inf, np.inf, -np.inf
        self._orbits_of: Any = None
        self.map.figure.on_event(RangesUpdate, self._zoom_map)
        self.diagram.figure.on_event(RangesUpdate, self._zoom_diagram)
        self.map.look(state.window)
        self.show(state)
        self._rest()
        self._search_at = time.monotonic()

    # --- State -> views ---------------------------------------------------------------------------

    def show(self, state: PageState, *, moving: bool = False) -> None:
        """Go to a state: the fast views are sketched at once, the others follow at rest."""
        window = self.state.window
        state, message = model.settled(state)
        self.keep(state, moving=moving)
        self.message = message
        self.stop("curve")
        self._frame = DrawnFrame()
        self._now = model.motion(state)
        self._draw(moving=True)
        if state.window != window:
            self.map.look(state.window)
        now = time.monotonic()
        self._rest_at = np.inf if moving else now + REST
        self._refine_at, self._still_at = now + REST, now + QUIET
        if self.key() != self._key or (state.orbits and self._orbits_of != of_orbits(state)):
            self.search_soon()
        if not moving:
            self.branch = self._branch_here()

    def _draw(self, *, moving: bool) -> None:
        """Draw the fast views: into a message, or by Bokeh."""
        state, put = self.state, self._put
        for curve in model.curves(state):
            self.map.show(curve, state.order, put)
        self.map.follow(model.orbit(state), put)
        if self._now is not None:
            self.motion.show(self._now, state, put, moving=moving)
            self.word.show(self._now.marks, put)
        self.diagram.stand(state.value, state.phi_s, put)

    def _rest(self) -> None:
        """Let Bokeh draw the sketched views, which takes a tenth of a second, at rest."""
        self._rest_at, self._frame = np.inf, None
        self._draw(moving=False)
        self.mark(self.branch)
        self.say({"rest": True})

    @property
    def _put(self) -> Put:
        return patch if self._frame is None else self._frame.put

    def told(self, *, whole: bool) -> dict[str, Any]:
        state, now = self.state, self._now
        message = self.message or (now.message if now else "")
        told: dict[str, Any] = {
            "start": state.phi_s, "periodic": state.periodic, "frame": self._frame,
            "numbers": {n: _finite(v) for n, v in now.numbers.items()} if now else {},
            "message": message, "shape": {n: getattr(state.toy, n) for n in SHAPE},
        }  # fmt: skip
        if whole:
            told |= {
                "law": str(state.toy.expansion_friction), "every": as_text(state.every),
                "order": state.order, "tour": self._tour(),
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

    def _branch_here(self) -> str:
        scale = scale_of(self.diagram.figure)
        branch, away = nearest_line(self.shown.lines, self.state.value, self.state.phi_s, scale)
        return branch if away < ON_BRANCH else ""

    # --- Other processes --------------------------------------------------------------------------

    def tick(self) -> None:
        if time.monotonic() > self._rest_at:
            self._rest()
        now = time.monotonic() if is_warm() else -np.inf
        if now > self._refine_at:
            self._refine_at = np.inf
            self.begin("curve", model.curves, self.state, True, seconds=60.0)
        if now > self._search_at:
            self._search_at = np.inf
            self._search()
        for result in self.results("curve"):
            if isinstance(result, MapCurve):
                self._frame = DrawnFrame() if self._frame is not None else None
                self.map.show(result, self.state.order, self._put)
                self.say({"frame": self._frame})
        # After a change the diagram waits, for it takes long to draw; not while a slider is held.
        if self._frame is None or time.monotonic() > self._still_at:
            for result in self.results("diagram"):
                self.take_progress(result)
        for result in self.results("orbits"):
            if isinstance(result, tuple):
                self.diagram.orbits.stream({"x": result[0], "y": result[1]})

    def _search(self) -> None:
        if self.key() != self._key:
            self._find(known_diagrams.get(self.key(), NOTHING))
        elif self.shown is not NOTHING and not self.is_running("diagram"):
            self.stage = summary(self.shown)
            self.say(self.progress())
        wanted = of_orbits(self.state) if self.state.orbits else None
        if wanted != self._orbits_of:
            self._orbits_of = wanted
            self.stop("orbits")
            self.diagram.orbits.data = {"x": [], "y": []}
            if wanted is not None:
                self.begin("orbits", orbits, self.state, seconds=LONGEST)

    def key(self) -> Hashable:
        return key_of(self.state)

    def _find(self, found: Shown) -> None:
        self.search(diagram, axis_label(self.state.parameter), found)
        self._tell_branches()

    def _tell_branches(self) -> None:
        self.mark(self._branch_here())
        self.say({"branches": self.branches(), **self.progress()})

    def take_progress(self, result: Any) -> None:
        """Show a diagram as far as it is found, and keep it once complete."""
        super().take_progress(result)
        if not isinstance(result, Shown):
            self.say(self.progress())
            return
        if not result.stage:
            known_diagrams[self._key] = result
            while len(known_diagrams) > KNOWN:
                known_diagrams.popitem(last=False)
        self._tell_branches()

    # --- What a user may ask for ------------------------------------------------------------------

    def demands(self) -> Mapping[str, Demand]:
        return {
            "reset": lambda _: self.show(PageState(tour=self.state.tour)),
            "law": lambda wish: self.change(
                toy=self.state.toy.replace(expansion_friction=wish["value"])
            ),
            "start": lambda wish: self._start(float(wish["value"])),
            "orbits": lambda wish: self._orbits(bool(wish["value"])),
            "tour": lambda wish: self._go(int(wish["value"])),
            "search": lambda _: self._find(NOTHING),
            "home": lambda wish: self._home(str(wish["value"])),
        }

    def _start(self, phi_s: float) -> None:
        if not phi_s < self.state.toy.phi_s_max:
            raise ValueError(
                f"a start lies below {self.state.toy.phi_s_max:.6g} rad, where the beak touches "
                f"the pole, got {phi_s:.6g}"
            )
        self.change(phi_s=phi_s, periodic=False)

    def _orbits(self, wanted: bool) -> None:
        self.change(orbits=wanted)
        self._search_at = time.monotonic()

    def _go(self, step: int) -> None:
        known = 1 <= step <= len(TOUR)
        self.show(TOUR[step - 1].state if known else replace(self.state, tour=step))
        self.map.look(self.state.window)

    def go_to(self, branch: str, sample: int | None = None) -> None:
        super().go_to(branch, sample)
        if self.branch and not self.state.periodic:
            self.message = f"{branch} is a jump crossing: no motion repeats here, the map jumps"

    def _home(self, view: str) -> None:
        if view == "map":
            self.change(window=PageState().window)
            self.map.look(self.state.window)
        else:
            self.diagram.look(self.state.span)

    def _tap_map(self, event: Any) -> None:
        limit = self.state.toy.phi_s_max
        if not event.x < limit:
            return
        span = self.state.window[1] - self.state.window[0]
        fixed = np.asarray(self.map.fixed.data["x"], dtype=float)
        near = fixed[np.abs(fixed - event.x) < 0.012 * span]
        if len(near) and abs(event.y - near[0]) < 0.03 * span:
            self.change(phi_s=float(near[0]), periodic=True)
        else:
            self.change(phi_s=float(event.x), periodic=False)

    def _tap_beside(self, event: Any) -> None:
        low, high = limits(self.state.toy, self.state.parameter)
        state = self.state.at({self.state.parameter: min(max(event.x, low), high)})
        if event.y < state.toy.phi_s_max:
            self.show(replace(state, phi_s=float(event.y), periodic=False))

    def _zoom_diagram(self, _: Any) -> None:
        self.diagram.moved = True

    def _zoom_map(self, event: Any) -> None:
        low, high = max(event.x0, -50.0), min(event.x1, 1.0)
        if low < high and (low, high) != self.state.window and low < self.state.toy.phi_s_max:
            self.state = replace(self.state, window=(low, high))
            self._refine_at = time.monotonic() + REST
        self.say(self.answer())


def _finite(value: float) -> float | None:
    """A number for JSON: 0 for infinity, None for nan and minus infinity."""
    return value if np.isfinite(value) else (0.0 if value > 0 else None)


# --- Serving --------------------------------------------------------------------------------------


def controls() -> list[dict[str, Any]]:
    """A slider for each parameter of the toy."""
    found = []
    for name in parameters():
        meaning, unit, _ = description(name)
        value: float = getattr(Toy(), name)
        low, high = 0.0, 1.0
        group = FIRST
        if name == "pole":
            high, group, value = 5.0, "3:gravity and pole", 0.0
        elif not name.startswith(("mu", "eps")):
            low, high = 0.5 * value, 1.5 * value
            group = "2:masses, lengths, spring" if name != "g" else "3:gravity and pole"
        more = {"label": LABELS[name], "meaning": meaning, "unit": unit, "group": group}
        found.append(control(name, low, high, repr(value), **more))
    front = ("eps_n1", "mu_1", "mu_2", "mu_3")
    return sorted(found, key=lambda each: each["name"] not in front)


def make_page(document: Document, initial: PageState) -> None:
    """Fill the document of one tab."""
    state, refused = asked(document, from_query, initial)
    tab = ToyTab(state)
    tab.message = refused or tab.message
    tab.put_on(
        document, TEMPLATE, "Woodpecker Toy", exports=list(FILES.items()),
        controls=controls(), open_group=FIRST, shapes=shapes(),
        struck=[CONTACTS[1], CONTACTS[2], CONTACTS[3], BOTH],
        over=[(name, PLAIN.get(name, name)) for name in parameters() if name != "pole"],
    )  # fmt: skip


def shapes() -> dict[str, Any]:
    """The bird of :mod:`woodpecker.plot.drawing` in its own units, for the browser to draw."""
    names = ("BODY", "BELLY", "CHEEK", "CAP", "TAIL", "BEAK", "BARS", "EYE", "HOLD")
    return {name: getattr(drawing, name) for name in names}


def _prepared(name: str, query: str) -> tuple[Any, ...]:
    known = known_diagrams.get(key_of(from_query(query))) if name in OF_DIAGRAM else None
    return export, name, query, known.diagram if known is not None else None


def run(initial: PageState, port: int | None, *, stay: bool, ready: Callable[[str], None]) -> None:
    """Load the kernel here and in the process that jobs are forked from, and serve the page."""
    import woodpecker.explore.warm  # noqa: F401 - compiles the kernel, if nobody has

    warm_up(["woodpecker.explore.warm"])
    serve(
        partial(make_page, initial=initial), _prepared, "Woodpecker Toy: two states", port,
        stay=stay, ready=ready,
    )  # fmt: skip
