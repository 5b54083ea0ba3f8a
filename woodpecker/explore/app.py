"""The page of the toy, and its server."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from bokeh.document import Document

from pwmap.explore.exports import OF_DIAGRAM
from pwmap.explore.jobs import warm_up
from pwmap.explore.page import asked, control
from pwmap.explore.serving import serve
from pwmap.explore.tab import put_on_page
from woodpecker import Toy, parameters
from woodpecker.explore.branches import key_of
from woodpecker.explore.exports import FILES, export
from woodpecker.explore.state import PageState, from_query
from woodpecker.explore.tab import ToyTab, known_diagrams
from woodpecker.explore.views import BOTH, CONTACTS
from woodpecker.mechanics.toy import description
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


# --- Serving --------------------------------------------------------------------------------------


def make_page(document: Document, initial: PageState) -> None:
    """Fill the document of one tab."""
    state, refused = asked(document, from_query, initial)
    tab = ToyTab(state)
    tab.message = refused or tab.message
    put_on_page(
        document, TEMPLATE, tab, "Woodpecker Toy", exports=list(FILES.items()),
        controls=controls(), open_group=FIRST, shapes=shapes(),
        struck=[CONTACTS[1], CONTACTS[2], CONTACTS[3], BOTH],
        over=[(name, PLAIN.get(name, name)) for name in parameters() if name != "pole"],
    )  # fmt: skip


def shapes() -> dict[str, Any]:
    """The bird of :mod:`woodpecker.plot.drawing` in its own units, for the browser to draw."""
    names = ("BODY", "BELLY", "CHEEK", "CAP", "TAIL", "BEAK", "BARS", "EYE", "HOLD")
    return {name: getattr(drawing, name) for name in names}


def _prepared(name: str, query: str) -> tuple[Any, ...]:
    """The job of a file and its arguments, with the diagram if that is known."""
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
