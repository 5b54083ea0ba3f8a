"""Files of all pages: their types, pictures, and exports of a diagram."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TypeVar

from pwmap.diagrams.diagram import Diagram
from pwmap.diagrams.files import figure_as_bytes
from pwmap.diagrams.tables import results_as_bytes
from pwmap.explore.link import LinkedState
from pwmap.plot import Drawn, plot_diagram

TYPES = {
    "png": "image/png", "svg": "image/svg+xml", "csv": "text/csv; charset=utf-8",
    "json": "application/json", "py": "text/x-python; charset=utf-8", "graphml": "application/xml",
}  # fmt: skip
PICTURE = ("png", "svg")
S = TypeVar("S", bound=LinkedState)
OF_DIAGRAM = {
    "diagram.png": "picture of the diagram (PNG)", "diagram.svg": "picture of the diagram (SVG)",
    "branches.csv": "branches of the diagram (CSV)", "points.csv": "special points (CSV)",
    "diagram.json": "the diagram, whole (JSON)", "graph.json": "graph of branches (JSON)",
    "graph.graphml": "graph of branches (GraphML)",
}  # fmt: skip
OF_STATE = {"state.json": "the state (JSON)", "lines.py": "lines of Python (file)"}


def made(
    name: str, state: S, files: Mapping[str, str], diagram: Callable[[S], Diagram],
    figures: Mapping[str, Callable[[S], Drawn]], texts: Mapping[str, Callable[[S], str]],
) -> Iterator[tuple[str, bytes]]:  # fmt: skip
    """Type and content of a file of a page; ValueError if there is none of its name.

    Figures and texts have the names of their files, without the form.
    """
    if name not in files:
        raise ValueError(f"unknown file {name!r}, expected one of {', '.join(files)}")
    what, _, form = name.partition(".")
    if form in PICTURE:
        drawn = figures[what](state) if what in figures else plot_diagram(diagram(state))
        content = figure_as_bytes(drawn.figure, form)
    elif name in OF_DIAGRAM:
        content = results_as_bytes(diagram(state))[name]
    elif name in OF_STATE:
        content = (state.python() if form == "py" else state.json()).encode()
    else:
        content = texts[what](state).encode()
    yield TYPES[form], content
