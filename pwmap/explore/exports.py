"""Files that pages offer, with the functions that make them from a state in another process."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from pwmap.diagrams.diagram import Diagram
from pwmap.diagrams.files import figure_as_bytes
from pwmap.diagrams.tables import results_as_bytes
from pwmap.explore.link import LinkedState
from pwmap.plot import Drawn, plot_diagram

TYPES = {
    "png": "image/png", "svg": "image/svg+xml", "csv": "text/csv; charset=utf-8",
    "json": "application/json", "py": "text/x-python; charset=utf-8", "graphml": "application/xml",
}  # fmt: skip
Files = Mapping[str, tuple[str, Callable[[Any], Drawn | str | bytes]]]
"""By the name of a file, its label and the function that makes it from a state."""


def made(name: str, state: LinkedState, files: Files) -> Iterator[tuple[str, bytes]]:
    """Yield the media type and content of a file; ValueError for an unknown name."""
    if name not in files:
        raise ValueError(f"unknown file {name!r}, expected one of {', '.join(files)}")
    _, _, form = name.partition(".")
    content = files[name][1](state)
    if isinstance(content, Drawn):
        content = figure_as_bytes(content.figure, form)
    yield TYPES[form], content.encode() if isinstance(content, str) else content


def pictures(name: str, draw: Callable[[Any], Drawn]) -> Files:
    """The files of a picture in two formats."""
    forms = ("png", "svg")
    return {f"{name}.{form}": (f"picture of the {name} ({form.upper()})", draw) for form in forms}


def of_all_pages(diagram: Callable[[Any], Diagram]) -> Files:
    """The files of a state and its diagram, which every page offers."""

    def table(name: str) -> Callable[[Any], bytes]:
        return lambda state: results_as_bytes(diagram(state))[name]

    tables = {
        "branches.csv": "branches of the diagram (CSV)", "points.csv": "special points (CSV)",
        "diagram.json": "the diagram, whole (JSON)", "graph.json": "graph of branches (JSON)",
        "graph.graphml": "graph of branches (GraphML)",
    }  # fmt: skip
    return {
        **pictures("diagram", lambda state: plot_diagram(diagram(state))),
        **{name: (text, table(name)) for name, text in tables.items()},
        "state.json": ("the state (JSON)", lambda state: state.json()),
        "lines.py": ("lines of Python (file)", lambda state: state.python()),
    }
