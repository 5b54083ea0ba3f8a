"""A diagram as files for other programs and as tables for people."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice, repeat
from pathlib import Path

import numpy as np
from rich.table import Column, Table

from pwmap.algebra.texts import text
from pwmap.diagrams.data import Branch, BranchKind, SpecialPoint
from pwmap.diagrams.diagram import NAME, VERSION, Diagram, columns_of_points
from pwmap.diagrams.files import table_as_text, write_whole
from pwmap.diagrams.formulas import text_of
from pwmap.diagrams.graph import graph_as_bytes
from pwmap.diagrams.saved import record_as_bytes
from pwmap.diagrams.shown import bracketed, counted

LONGEST = 160  # characters of an exact value in a table for people: two lines of a wide column
FILES = ("points.csv", "branches.csv", "graph.graphml", "graph.json", "diagram.json")


def write_results(diagram: Diagram, folder: Path) -> None:
    """Write tables of points and branches, the graph, and the diagram itself: :data:`FILES`."""
    for name, content in results_as_bytes(diagram).items():
        write_whole(folder / name, content)


def results_as_bytes(diagram: Diagram) -> dict[str, bytes]:
    """The contents that :func:`write_results` writes, by the names of the files."""
    graph = diagram.graph()
    contents = (
        _points_as_text(diagram).encode(),
        _branches_as_text(diagram).encode(),
        *(graph_as_bytes(graph, Path(name)) for name in FILES[2:4]),
        record_as_bytes(diagram, NAME, VERSION),
    )
    return dict(zip(FILES, contents, strict=True))


def _points_as_text(diagram: Diagram) -> str:
    columns = columns_of_points(diagram)
    for name, values in columns.items():
        if name in ("interval_min", "interval_max"):
            columns[name] = ["" if np.isnan(value) else value for value in values]
        elif name.endswith("_exact"):
            columns[name] = ["" if value is None else text_of(value) for value in values]
    return table_as_text(["id", *[*columns][1:]], zip(*columns.values(), strict=True))


def _branches_as_text(diagram: Diagram) -> str:
    observed = tuple(dict.fromkeys(name for b in diagram.branches for name in b.columns))
    exact = tuple(dict.fromkeys(name for b in diagram.branches for name in b.exact))
    header = (
        *("id", "kind", "order", "word", "from", "to"),
        *(diagram.parameter_name, diagram.x_name, "multiplier", *observed),
        *(f"{name}_exact" for name in exact),
    )
    rows = (row for branch in diagram.branches for row in _rows_of(branch, observed, exact))
    return table_as_text(header, rows)


def _rows_of(
    branch: Branch, observed: Sequence[str], exact: Sequence[str]
) -> Iterator[tuple[object, ...]]:
    """Yield a row for each sample of a branch; exact values become text once per stretch."""
    columns = [branch.columns.get(name, repeat("")) for name in observed]
    numbers = zip(branch.parameter, branch.x, branch.multiplier, *columns, strict=False)
    firsts = [stretch.first for stretch in branch.words]
    for stretch, start, stop in zip(branch.words, firsts, [*firsts[1:], len(branch)], strict=True):
        texts = [text_of(stretch.exact.get(name, "")) for name in exact]
        what = (branch.id, branch.kind, branch.order, stretch.word, *branch.ends)
        for row in islice(numbers, stop - start):
            yield (*what, *(float(each) if each != "" else each for each in row), *texts)


def table_of_points(diagram: Diagram) -> Table:
    """A table of special points with their causes, exact where known; counts changes of word."""
    changes = sum(len(branch.changes) for branch in diagram.branches)
    table = Table(
        *_columns("point", diagram.parameter_name, diagram.x_name, "what", "left", "right"),
        title=f"{counted(len(diagram.branches), 'branch')}, "
        f"{counted(len(diagram.points), 'special point')}, {counted(changes, 'change')} of word",
        caption=f"given: {', '.join(map(short, diagram.given))}" if diagram.given else None,
    )
    for point in diagram.points:
        what = ", ".join(filter(None, (point.kind.label, point.note)))
        left, right = (" ".join(side) for side in diagram.sides(point.id))
        table.add_row(
            f"{point.name} ({point.id})" if point.name else point.id,
            _shown(point, "parameter", point.parameter),
            _shown(point, "x", point.x),
            f"{what}\n{point.cause}" if point.cause else what,
            left,
            right,
        )
    return table


def table_of_branches(diagram: Diagram) -> Table:
    """A table of the branches of an exact diagram with their formulas, stretch by stretch."""
    names = ("branch", "kind", "order", "word", diagram.x_name, "multiplier", "exists for")
    table = Table(*_columns(*names))
    for branch, stretch in ((b, stretch) for b in diagram.branches for stretch in b.words):
        exact = stretch.exact
        is_jump = branch.kind is BranchKind.JUMP
        limits = f"from {text(exact.get('left'))} to {text(exact.get('right'))}" if is_jump else ""
        table.add_row(
            branch.id,
            str(branch.kind),
            str(branch.order),
            stretch.word,
            short(exact.get("x", "an interval")),
            short(exact.get("multiplier", limits)),
            short(f"{diagram.parameter_name} in {bracketed(exact['interval'])}"),
        )
    return table


def short(value: object) -> str:
    """Text for people; long text is cut down to its beginning and end."""
    whole = text(value)
    if len(whole) <= LONGEST:
        return whole
    mark = f" ... ({len(whole)} characters) ... "
    kept = LONGEST - len(mark)
    return whole[: kept - kept // 3] + mark + whole[-(kept // 3) :]


def _columns(*names: str) -> list[Column]:
    """Columns that wrap text too long for one line."""
    return [Column(name, overflow="fold") for name in names]


def _shown(point: SpecialPoint, name: str, value: float) -> str:
    return short(point.exact[name]) if name in point.exact else f"{value:.10f}"
