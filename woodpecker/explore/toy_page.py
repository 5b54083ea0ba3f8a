"""The page of the toy, and how it is served."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from bokeh.document import Document
from bokeh.events import RangesUpdate
from bokeh.models import ColumnDataSource

from pwmap.explore.diagram_views import scale_of
from pwmap.explore.diagrams import nearest_line
from pwmap.explore.figures import DASHED, Shown, map_figure, source
from pwmap.explore.jobs import warm_up
from pwmap.explore.page import asked, control
from pwmap.explore.serving import Serve
from pwmap.explore.tab import LONGEST, Demand, Tab, known_diagrams
from pwmap.plot import GREY, VIOLET
from woodpecker import Toy, parameters
from woodpecker.explore import model
from woodpecker.explore.branches import diagram, key_of, of_orbits, orbits
from woodpecker.explore.exports import FILES, OF_DIAGRAM, export
from woodpecker.explore.model import DrawnMotion, MapCurve
from woodpecker.explore.state import PageState, from_query
from woodpecker.explore.tour import TOUR
from woodpecker.explore.views import (
    BOTH,
    CONTACTS,
    OF_FIXED,
    labels_of,
    motion_figures,
    of_map,
    of_motion,
    of_orbit,
    room,
    word_figure,
)
from woodpecker.mechanics.toy import description, limits, symbol
from woodpecker.plot import drawing
from woodpecker.plot.motions import PORTRAITS

TEMPLATE = Path(__file__).parent / "files" / "woodpecker.html"
FIRST = "1:friction and restitution"  # a group of sliders; groups are sorted by their numbers
RAD = r"\ [\mathrm{rad}]"
PHI, RATE = rf"$$\varphi_S{RAD}$$", r"\ [\mathrm{rad/s}]"
AXES = {  # labels of the axes of portraits
    "phi_s": (PHI, rf"$$\dot\varphi_S{RATE}$$"),
    "phi_m": (rf"$$\varphi_M{RAD}$$", rf"$$\dot\varphi_M{RATE}$$"),
    "fall": (PHI, r"$$\dot y\ [\mathrm{m/s}]$$"),
}
PANELS = {"angles": ("phi_s", "phi_m"), "fall": ("y",)}
PANEL_LABELS = (rf"$$\varphi{RAD}$$", r"$$y\ [\mathrm{mm}]$$", r"$$t\ [\mathrm{ms}]$$")
REST = 0.12  # s after the last change until Bokeh draws the fast views and the map is refined
ON_BRANCH = 3.0  # px: a state this close to a branch is taken to lie on it
SHAPE = ("r_0", "r_m", "h_m", "l_m", "l_g", "h_s", "l_s", "phi_m_max", "phi_s_max")


def figures() -> tuple[Any, ...]:
    """All views but those of the diagram; the browser moves the marks of the current instant."""
    labels = labels_of(r"\varphi_S", RAD)
    angles, fall, portrait = motion_figures(
        PANELS, PANEL_LABELS, "dy", "dphi_m", "dphi_s", "closed"
    )
    angles.hspan("y", source=source("stops", "y"), line_color=GREY, line_dash=DASHED)
    instant = ColumnDataSource({"t": [0.0]}, name="instant", syncable=False)
    for figure in (angles, fall):
        figure.vspan("t", source=instant, color=VIOLET, line_width=1.6, level="overlay")
    now = ColumnDataSource({"x": [0.0], "y": [0.0]}, name="now", syncable=False)
    portrait.scatter("x", "y", source=now, size=11, color=VIOLET, line_color="white",
                     level="overlay")  # fmt: skip
    return map_figure(*labels, OF_FIXED, "order"), word_figure(), angles, fall, portrait


def of_toy(motion: DrawnMotion, state: PageState) -> Shown:
    """A motion as shown in all of its views, with the stops of the angles."""
    columns, toy = model.as_columns(motion), state.toy
    shown = of_motion(columns, motion.marks, 1e3, PANELS, PORTRAITS[state.portrait])
    angles = np.concatenate([columns["phi_s"], columns["phi_m"], [toy.phi_s_max]])
    stops = [-toy.phi_m_max, toy.phi_m_max, toy.phi_s_max]
    return Shown(
        tables={**shown.tables, "stops": {"y": stops}},
        ends={**shown.ends, "angles": (*shown.ends["angles"][:2], *room(angles))},
        labels={"portrait": AXES[state.portrait]},
    )


class ToyTab(Tab[PageState]):
    """A browser tab with the page of the toy."""

    WORK = staticmethod(diagram)

    def __init__(self, state: PageState) -> None:
        super().__init__(state, PageState(), figures(), PHI)
        self._now: DrawnMotion | None = None
        self._orbits_of: Any = None
        self.figures["map"].on_event(RangesUpdate, self._zoom_map)
        self._look_at_map()
        self.show(state)
        self._rest()
        self.later(0.0, self.seek)

    # --- State -> views ---------------------------------------------------------------------------

    def key(self) -> Hashable:
        return key_of(self.state)

    def axis(self) -> str:
        (letter, index), unit = symbol(self.state.over), description(self.state.over).unit
        told = "" if unit == "-" else rf"\ [\mathrm{{{unit.replace(' ', chr(92) + ' ')}}}]"
        return f"$${letter}_{{{index}}}{told}$$"

    def show(self, state: PageState, *, moving: bool = False) -> None:
        """Go to a state: fast views are sketched at once, the others follow when changes pause."""
        window = self.state.window
        state, message = model.settled(state)
        self.keep(state, moving=moving)
        self.message = message
        self.stop("curve")
        self.sketched = {}
        self._now = model.motion(state)
        self._draw()
        if state.window != window:
            self._look_at_map()
        self.later(REST, self._refine)
        if moving:
            self.due.pop(self._rest, None)
        else:
            self.later(REST, self._rest)
            self.branch = self.branch_here()

    def _draw(self) -> None:
        """Draw the fast views."""
        for curve in model.curves(self.state):
            self._draw_map(curve)
        self.draw(of_orbit(model.orbit(self.state)))
        if self._now is not None:
            self.draw(of_toy(self._now, self.state))
        self.draw(self.stand(self.state.phi_s))

    def _draw_map(self, curve: MapCurve) -> None:
        labels = labels_of(r"\varphi_S", RAD, f"+{self.state.order}")
        self.draw(of_map(curve, self.state.order, labels))

    def _look_at_map(self) -> None:
        self.draw(Shown(ends={"map": self.state.window * 2}))

    def _rest(self) -> None:
        """When changes pause, let Bokeh draw the sketched views: it takes a tenth of a second."""
        self.sketched = None
        self._draw()
        self.mark(self.branch)

    def _refine(self) -> None:
        self.begin("curve", self._draw_map, model.curves, self.state, True, seconds=60.0)

    def told(self, *, whole: bool) -> dict[str, Any]:
        state, now = self.state, self._now
        message = self.message or (now.message if now else "")
        told: dict[str, Any] = {
            "start": state.phi_s, "periodic": state.periodic, "message": message,
            "numbers": {n: _finite(v) for n, v in now.numbers.items()} if now else {},
            "shape": {n: getattr(state.toy, n) for n in SHAPE},
        }  # fmt: skip
        if whole:
            told |= {"law": str(state.toy.expansion_friction), "tour": self._tour()}
        return told

    def _tour(self) -> dict[str, Any]:
        told: dict[str, Any] = {"step": self.state.tour, "of": len(TOUR)}
        if self.state.tour:
            step = TOUR[self.state.tour - 1]
            told |= {n: getattr(step, n) for n in ("title", "figure", "text", "views")}
        return told

    # --- Diagrams and orbits ----------------------------------------------------------------------

    def seek(self) -> None:
        """Search for the diagram of the state, and for its orbit diagram if that is shown."""
        super().seek()
        wanted = of_orbits(self.state) if self.state.orbits else None
        if wanted != self._orbits_of:
            self._orbits_of = wanted
            self.stop("orbits")
            self.tables["orbits"].data = {"x": [], "y": []}
            if wanted is not None:
                self.begin("orbits", self._add, orbits, self.state, seconds=LONGEST)

    def _add(self, points: tuple[Any, Any]) -> None:
        self.tables["orbits"].stream({"x": points[0], "y": points[1]})

    def branch_here(self) -> str:
        lines, scale = self.tables["lines"].data, scale_of(self.figures["diagram"])
        branch, away = nearest_line(lines, self.state.value, self.state.phi_s, scale)
        return branch if away < ON_BRANCH else ""

    # --- Demands of a user ------------------------------------------------------------------------

    def demands(self) -> dict[str, Demand]:
        return {
            **super().demands(),
            "reset": lambda _: self.show(PageState(tour=self.state.tour)),
            "law": lambda wish: self.change(
                toy=self.state.toy.replace(expansion_friction=wish["value"])
            ),
            "start": lambda wish: self._start(self._read("phi_s", wish, "start")),
            "orbits": lambda wish: self._orbits(bool(wish["value"])),
            "tour": lambda wish: self._go(self._read("tour", wish)),
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
        self.later(0.0, self.seek)

    def _go(self, step: int) -> None:
        known = 1 <= step <= len(TOUR)
        self.show(TOUR[step - 1].state if known else replace(self.state, tour=step))
        self._look_at_map()

    def go_to(self, branch: str, sample: int | None = None) -> None:
        super().go_to(branch, sample)
        if self.branch and not self.state.periodic:
            self.message = f"{branch} is a jump crossing: no motion repeats here, the map jumps"

    def _home(self, view: str) -> None:
        if view == "map":
            self.change(window=PageState().window)
            self._look_at_map()
        else:
            self.look()

    def _tap_map(self, event: Any) -> None:
        limit = self.state.toy.phi_s_max
        if not event.x < limit:
            return
        span = self.state.window[1] - self.state.window[0]
        fixed = np.asarray(self.tables["fixed"].data["x"], dtype=float)
        near = fixed[np.abs(fixed - event.x) < 0.012 * span]
        if len(near) and abs(event.y - near[0]) < 0.03 * span:
            self.change(phi_s=float(near[0]), periodic=True)
        else:
            self.change(phi_s=float(event.x), periodic=False)

    def _tap_beside(self, event: Any) -> None:
        low, high = limits(self.state.toy, self.state.over)
        state = self.state.at({self.state.over: min(max(event.x, low), high)})
        if event.y < state.toy.phi_s_max:
            self.show(replace(state, phi_s=float(event.y), periodic=False))

    def _zoom_map(self, event: Any) -> None:
        low, high = max(event.x0, -50.0), min(event.x1, 1.0)
        if low < high and (low, high) != self.state.window and low < self.state.toy.phi_s_max:
            self.state = replace(self.state, window=(low, high))
            self.later(REST, self._refine)
        self.say(self.answer())


def _finite(value: float) -> float | None:
    """A number as JSON allows it: 0 for infinity, None for nan and minus infinity."""
    return value if np.isfinite(value) else (0.0 if value > 0 else None)


# --- Serving --------------------------------------------------------------------------------------


def controls() -> list[dict[str, Any]]:
    """Sliders, one for each parameter of the toy."""
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
        letter, index = symbol(name)
        label = f"{letter}<sub>{index}</sub>" if index else letter
        more = {"label": label, "meaning": meaning, "unit": unit, "group": group}
        found.append(control(name, low, high, repr(value), **more))
    front = ("eps_n1", "mu_1", "mu_2", "mu_3")
    return sorted(found, key=lambda each: each["name"] not in front)


def make_page(document: Document, initial: PageState) -> None:
    """Fill the document of one tab."""
    state, refused = asked(document, from_query, initial)
    tab = ToyTab(state)
    tab.message = refused or tab.message
    tab.put_on(
        document, TEMPLATE, "Woodpecker Toy", files=FILES,
        controls=controls(), open_group=FIRST, shapes=shapes(),
        struck=[CONTACTS[1], CONTACTS[2], CONTACTS[3], BOTH],
        over=[(name, _plain(name)) for name in parameters() if name != "pole"],
    )  # fmt: skip


def _plain(parameter: str) -> str:
    """The symbol of a parameter if that has Greek letters, otherwise its name."""
    written = "".join(symbol(parameter))
    return parameter if written.isascii() else written


def shapes() -> dict[str, Any]:
    """The bird of :mod:`woodpecker.plot.drawing` in its own units, for the browser to draw."""
    names = ("BODY", "BELLY", "CHEEK", "CAP", "TAIL", "BEAK", "BARS", "EYE", "HOLD")
    return {name: getattr(drawing, name) for name in names}


def _prepared(name: str, query: str) -> tuple[Any, ...]:
    known = known_diagrams.get(key_of(from_query(query))) if name in OF_DIAGRAM else None
    return export, name, query, known and known.diagram


def run(initial: PageState, serve: Serve) -> None:
    """Serve the page; load the kernel first, here and in the process that jobs are forked from."""
    import woodpecker.explore.warm  # noqa: F401 - compiles the kernel if it is not cached

    warm_up(["woodpecker.explore.warm"])
    serve(partial(make_page, initial=initial), _prepared)
