"""What the files of all pages share: their types, pictures, and what is made of a diagram."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from pwmap.diagrams.diagram import Diagram
from pwmap.diagrams.files import write_figure
from pwmap.diagrams.tables import results_as_bytes

TYPES = {
    "png": "image/png", "svg": "image/svg+xml", "csv": "text/csv; charset=utf-8",
    "json": "application/json", "py": "text/x-python; charset=utf-8", "graphml": "application/xml",
}  # fmt: skip
PICTURE = ("png", "svg")
OF_DIAGRAM = {
    "diagram.png": "picture of the diagram (PNG)", "diagram.svg": "picture of the diagram (SVG)",
    "branches.csv": "branches of the diagram (CSV)", "points.csv": "special points (CSV)",
    "diagram.json": "the diagram, whole (JSON)", "graph.json": "graph of branches (JSON)",
    "graph.graphml": "graph of branches (GraphML)",
}  # fmt: skip
OF_STATE = {"state.json": "the state (JSON)", "lines.py": "lines of Python (file)"}


def parts(name: str, files: Mapping[str, str]) -> tuple[str, str]:
    """What a file shows, and its form; ValueError if it is none of a page's."""
    if name not in files:
        raise ValueError(f"unknown file {name!r}, expected one of {', '.join(files)}")
    what, _, form = name.partition(".")
    return what, form


def picture(form: str, draw: Callable[[], Any]) -> bytes:
    """A drawn figure as a file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"picture.{form}"
        write_figure(path, draw())
        return path.read_bytes()


def of_diagram(name: str, found: Diagram) -> bytes:
    """One of :data:`OF_DIAGRAM`."""
    form = name.partition(".")[2]
    if form in PICTURE:
        from pwmap.plot import plot_diagram

        return picture(form, lambda: plot_diagram(found).figure)
    return results_as_bytes(found)[name]
