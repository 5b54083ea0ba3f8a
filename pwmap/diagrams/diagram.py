"""The diagram of a map of the line over one parameter, for both packages."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import networkx as nx
import numpy as np

from pwmap.algebra.arguments import (
    check_kind,
    check_mapping,
    check_text,
    checked_count,
    checked_number,
    checked_pair,
    explained,
    explained_fields,
    shown,
)
from pwmap.diagrams import queries
from pwmap.diagrams.data import Branch as Branch
from pwmap.diagrams.data import BranchKind as BranchKind
from pwmap.diagrams.data import Hit as Hit
from pwmap.diagrams.data import PointKind as PointKind
from pwmap.diagrams.data import PointStatus as PointStatus
from pwmap.diagrams.data import SpecialPoint as SpecialPoint
from pwmap.diagrams.data import StableInterval as StableInterval
from pwmap.diagrams.data import Stretch as Stretch
from pwmap.diagrams.data import columns_of, share_stable
from pwmap.diagrams.data import runs_of as runs_of
from pwmap.diagrams.encoding import to_plain
from pwmap.diagrams.exactness import check_exact
from pwmap.diagrams.formulas import text_of
from pwmap.diagrams.frames import Column, DataFrame, dataframe, joined, unique_names
from pwmap.diagrams.record import attributes
from pwmap.diagrams.saved import read_record, write_record
from pwmap.diagrams.shown import counted, listed, table, tally

FILLED = "intervals"  # key in ``about``: orders whose fixed points fill intervals, which are no
# branches
ASSUMED = "assumed"  # key in ``about`` of a symbolic diagram: assumptions on other parameters


NAME, VERSION = "diagram", 1  # of its files; raise the version if older code would misread them


@explained_fields
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Diagram:
    """Branches and special points over one parameter.

    Parameters
    ----------
    parameter_name, x_name
        Names for axes, tables and graphs, such as ``"eps_n1"`` and ``"phi_s"``.
    branches, points
        In the order in which they were found; ends of branches are ids of points.
    given
        Conditions on symbolic parameters under which the diagram holds, or how it was found.
    sample
        Values of these parameters by name, at which the floats were taken.
    about
        What made the diagram, as values for JSON by name: the program with its version and, for the
        toy, its parameters, law of impact and changed settings. If ``given`` covers only a part of
        its entry ``"assumed"``, the diagram is shown with that restriction.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, bifurcation_diagram
    >>> lines = PiecewiseLinearMap.from_sympy("Piecewise((p + x/2, x <= 0), (p - 1 + x/3, True))")
    >>> diagram = bifurcation_diagram(lines, "p", (-1, 2), orders=(1,))
    >>> [(point.id, point.note, point.parameter, point.x) for point in diagram.points[1:3]]
    [('BC1', 'persistence', 0.0, 0.0), ('BC2', 'persistence', 1.0, 0.0)]
    >>> [(hit.branch.id, hit.x, hit.exact["x"]) for hit in diagram.at("-1/2")]
    [('F1', -1.0, -1)]
    """

    parameter_name: str
    x_name: str
    branches: tuple[Branch, ...]
    points: tuple[SpecialPoint, ...]
    given: tuple[str, ...] = ()
    sample: Mapping[str, object] = field(default_factory=dict)
    about: Mapping[str, object] = field(default_factory=dict)
    _branch: Mapping[str, Branch] = field(init=False, repr=False)
    _point: Mapping[str, SpecialPoint] = field(init=False, repr=False)
    _incident: Mapping[str, list[Branch]] = field(init=False, repr=False)  # by point

    def __post_init__(self) -> None:
        for parts, kind in ((self.points, SpecialPoint), (self.branches, Branch)):
            for part in parts:
                check_kind("a part of a diagram", part, kind)
        points = {point.id: point for point in self.points}
        if len(points) != len(self.points):
            raise ValueError("the ids of the special points are not unique")
        branches = {branch.id: branch for branch in self.branches}
        if len(branches) != len(self.branches):
            raise ValueError("the ids of the branches are not unique")
        incident: dict[str, list[Branch]] = {name: [] for name in points}
        for branch in self.branches:
            for end in dict.fromkeys(branch.ends):
                if end not in points:
                    raise ValueError(f"branch {branch.id!r} ends at unknown point {end!r}")
                incident[end].append(branch)
        for name, value in (("_branch", branches), ("_point", points), ("_incident", incident)):
            object.__setattr__(self, name, value)

    def __eq__(self, other: object) -> bool:
        # by what would be saved, in which nan is text and so equals itself
        return isinstance(other, Diagram) and (self is other or to_plain(self) == to_plain(other))

    def __hash__(self) -> int:
        return hash((self._names, *self._branch, *self._point))

    @property
    def _names(self) -> tuple[str, str]:
        return self.parameter_name, self.x_name

    @property
    def in_part(self) -> str:
        """Where the diagram holds, if that is only a part of what was assumed; else empty."""
        assumed, held = self.about.get(ASSUMED), [x for x in self.given if re.search("[<>=]", x)]
        if not isinstance(assumed, list | tuple) or {*assumed} == {*held}:
            return ""
        where = f"for {', '.join(held)} only"
        if self.left_out_ends:
            return f"{where}, without {listed(self.left_out_ends)}, though that is assumed"
        return f"{where}, a part of what is assumed ({', '.join(assumed) or 'all values'})"

    @property
    def left_out_ends(self) -> tuple[str, ...]:
        """The ends of the assumed set, as equations, if only these are left out; else empty."""
        assumed = tuple(map(str, self.about.get(ASSUMED) or ()))  # type: ignore[call-overload]
        closed = [each for each in assumed if re.search("[<>]=", each)]
        opened = {re.sub("([<>])=", r"\1", each) for each in assumed}
        if not closed or opened != {each for each in self.given if re.search("[<>=]", each)}:
            return ()
        return tuple(re.sub("[<>]=", "=", each) for each in closed)

    @property
    def filled(self) -> list[int]:
        """The orders whose fixed points fill intervals, of which at most the ends are branches."""
        found = self.about.get(FILLED)
        return [n for n in found if type(n) is int] if isinstance(found, list | tuple) else []

    @property
    def _head(self) -> str:
        """The first line of the repr: parameter and numbers of branches and points."""
        part, points = self.in_part, counted(len(self.points), "special point")
        ends = [each for branch in self.branches for each in branch.parameter[[0, -1]].tolist()]
        within = f" in [{min(ends):.6g}, {max(ends):.6g}]" if ends else ""
        over = f"{self.x_name} over {self.parameter_name}{f', {part}' if part else ''}"
        return f"{over}: {counted(len(self.branches), 'branch')}{within}, {points}"

    def __repr__(self) -> str:
        kinds: dict[int, list[BranchKind]] = {}
        for branch in self.branches:
            kinds.setdefault(branch.order, []).append(branch.kind)
        lines = [f"Diagram({self._head}"]
        lines += [f"order {order}: {tally(kinds[order])}" for order in sorted(kinds)]
        if self.filled:
            lines.append(f"intervals of fixed points: {', '.join(f'P_{n}' for n in self.filled)}")
        if self.points:
            lines.append(f"points: {tally(point.kind for point in self.points)}")
        return "\n    ".join(lines) + ")"

    def _repr_html_(self) -> str:
        rows = [
            (
                *(p.name or p.id, ", ".join(filter(None, (p.kind.label, p.note)))),
                *(p.exact.get("parameter", f"{p.parameter:.10g}"), p.exact.get("x", f"{p.x:.10g}")),
                *(p.order, " ".join(p.branches)),
            )
            for p in self.points
        ]
        return table(self._head, ("point", "what", *self._names, "order", "branches"), rows)

    def branch(self, branch_id: str) -> Branch:
        """The branch with an id, such as ``F1``; KeyError if there is none."""
        check_text("an id", branch_id)
        if branch_id not in self._branch:
            raise KeyError(f"no branch {branch_id!r} in this diagram")
        return self._branch[branch_id]

    def point(self, point_id: str) -> SpecialPoint:
        """The special point of an id or a name, such as ``BC1`` or ``A``; KeyError if none."""
        check_text("an id or a name", point_id)
        if point_id in self._point:
            return self._point[point_id]
        for point in self.points:
            if point.name == point_id != "":
                return point
        raise KeyError(f"no special point {point_id!r} in this diagram")

    @explained()
    def named(
        self, places: Mapping[str, tuple[float, float] | str], within: float = 0.01
    ) -> Diagram:
        """The same diagram with names for special points, such as those of a publication.

        ``places`` maps each name to the id of a point, such as ``PD1``, or to a parameter and an x:
        then it names the nearest border collision of the lowest order ``within`` that fraction of
        the diagram's extent in both coordinates, if any. ValueError if a name is an id, or two name
        one point; KeyError for an unknown id; TypeError for a name or place of another type.
        """
        given: dict[str, str] = {}
        check_mapping("places", places, "{'A': 'BC1'}")
        within = checked_number("within", within)
        for name, place in places.items():
            check_text("a name", name)
            if name in self._point:
                raise ValueError(f"a name must differ from all ids of points, got {name!r}")
            point = (
                self.point(place)
                if isinstance(place, str)
                else queries.collision_near(
                    checked_pair("a place", place), within, self.branches, self.points
                )
            )
            if point is None:
                continue
            if point.id in given:
                raise ValueError(f"{given[point.id]!r} and {name!r} are names for one point")
            given[point.id] = name
        points = tuple(replace(p, name=given.get(p.id, p.name)) for p in self.points)
        return replace(self, points=points)

    def sides(self, point_id: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Ids of the branches at a point (id or name): at smaller parameters, at larger ones.

        A branch along one value of the parameter is in neither; one that starts and ends at the
        point comes twice. KeyError if there is no such point.
        """
        point = self.point(point_id)
        return queries.sides_of(point, self._incident[point.id])

    def at(self, parameter: object) -> tuple[Hit, ...]:
        """The points of all branches at one value of the parameter, in order of x.

        Empty where no branch is, as outside the span. ``parameter`` is an int, a Fraction, text
        such as ``"5/4"``, a number of sympy, or a float (the binary number it holds); ValueError or
        TypeError if it is no finite real number. In an exact diagram values are exact, those of
        both ends for a band along this value, found and sorted at the :attr:`sample` of symbols.
        Otherwise they are interpolated linearly between samples; a branch may be met repeatedly.
        """
        return queries.hits(self.branches, self.parameter_name, parameter, self.sample)

    def component_of(self, point_id: str) -> Diagram:
        """The branches and points connected with a point (id or name); KeyError if it is none."""
        near = nx.node_connected_component(self.graph(), self.point(point_id).id)
        return self._part([branch for branch in self.branches if branch.ends[0] in near])

    def of_order(self, order: int) -> Diagram:
        """The branches of one iterate, and the points they end in."""
        wanted = checked_count(order, "order")
        part = self._part([branch for branch in self.branches if branch.order == wanted])
        filled = {FILLED: [wanted] * (wanted in self.filled)} if self.filled else {}
        return replace(part, about={**part.about, **filled})

    def within(self, low: object, high: object) -> Diagram:
        """All branches, uncut, that exist somewhere from ``low`` to ``high``, and their ends.

        Both are values as in :meth:`at`, or infinite. ValueError unless ``low`` <= ``high``,
        TypeError if they are not numbers.
        """
        ends = queries.end_of(low), queries.end_of(high)
        if not ends[0] <= ends[1]:
            raise ValueError(f"expected an interval from low to high, got {shown((low, high))}")
        where = (*ends, self.parameter_name, self.sample)
        return self._part([b for b in self.branches if queries.exists_within(b, *where)])

    def _part(self, branches: Sequence[Branch]) -> Diagram:
        """The diagram of some branches and the points they end in, which list no others."""
        kept = {branch.id for branch in branches}
        ends = {end for branch in branches for end in branch.ends}
        points = [
            replace(point, branches=tuple(name for name in point.branches if name in kept))
            for point in self.points
            if point.id in ends
        ]
        return replace(self, branches=tuple(branches), points=tuple(points))

    def path(self, first: str, last: str) -> tuple[str, ...]:
        """A shortest path from ``first`` to ``last``, ids or names: branches and points in turn.

        Empty if they are not connected. KeyError if there is no such branch or point.
        """
        graph, ends = nx.Graph(), (self._place(first), self._place(last))
        graph.add_nodes_from((branch.id, 0) for branch in self.branches)
        graph.add_nodes_from((point.id, 1) for point in self.points)
        graph.add_edges_from(((b.id, 0), (end, 1)) for b in self.branches for end in b.ends)
        found = nx.shortest_path(graph, *ends) if nx.has_path(graph, *ends) else ()
        return tuple(name for name, _ in found)

    def _place(self, name: str) -> tuple[str, int]:
        """A branch or a point as a node of :meth:`path`: ids of both may be the same text."""
        check_text("an id or a name", name)
        if name in self._branch:
            return name, 0
        try:
            return self.point(name).id, 1
        except KeyError:
            raise KeyError(f"no branch and no special point {name!r} in this diagram") from None

    def with_word(self, word: str) -> tuple[Branch, ...]:
        """Branches that have a word along at least one of their stretches."""
        check_text("a word", word)
        return tuple(b for b in self.branches if any(s.word == word for s in b.words))

    def stable_intervals(self, order: int | None = None) -> tuple[StableInterval, ...]:
        """Intervals of the parameter in which fixed points, by default of all orders, attract."""
        wanted = None if order is None else checked_count(order, "order")
        return tuple(queries.stable_intervals(self.branches, wanted))

    def save(self, path: str | Path) -> Path:
        """Write JSON for :func:`pwmap.load_diagram`, with ``.gz`` compressed.

        Doubles are kept exactly, exact values as formulas; ValueError for a suffix like ``.csv``.
        """
        return write_record(path, self, NAME, VERSION)

    def to_dataframe(self) -> DataFrame:
        """The samples of all branches as rows of a pandas DataFrame; ImportError without pandas.

        Its columns are those of :meth:`Branch.to_dataframe`, but parameter and x have their own
        names, with an underscore if another column has that. What was not observed is nan.
        """
        first, last = ("branch", "kind", "order", "word"), ("multiplier", "stable")
        parameter, x = unique_names(self._names, (*first, *last))
        observed = dict.fromkeys(name for branch in self.branches for name in branch.columns)
        tables = [columns_of(branch, parameter, x, observed) for branch in self.branches]
        return dataframe(joined(tables, (*first, parameter, x, *last, *observed)))

    def points_to_dataframe(self) -> DataFrame:
        """The special points as rows of a pandas DataFrame; ImportError without pandas.

        Its columns are ``point`` (the id), ``name``, ``kind``, the parameter and x by their names,
        ``order``, ``note``, ``cause``, ``status``, ``precision``, ``interval_min`` and
        ``interval_max`` (nan without an interval), ``branches`` (ids with blanks between), and
        expressions of sympy such as ``x_exact``, None where a point has none.
        """
        return dataframe(columns_of_points(self))

    def graph(self) -> nx.MultiGraph:
        """The special points as nodes, and the branches as edges keyed by id.

        Attributes are floats or text, which every export format keeps. Those of the graph are
        ``parameter``, ``x``, ``given`` and the entries of ``about``, as JSON if need be.
        """
        given = {"given": ", ".join(self.given)} if self.given else {}
        names = {"parameter": self.parameter_name, "x": self.x_name}
        graph = nx.MultiGraph()
        graph.graph.update({**names, **given, **attributes(self.about)})
        for point in self.points:
            graph.add_node(point.id, **_of_node(point))
        for branch in self.branches:
            graph.add_edge(*branch.ends, key=branch.id, **_of_edge(branch))
        return graph


def columns_of_points(diagram: Diagram) -> dict[str, Column]:
    """Columns of a table with a row for each special point."""
    points = diagram.points
    ends = np.array([p.interval or (math.nan, math.nan) for p in points]).reshape(-1, 2)
    first: dict[str, Column] = {
        "point": [p.id for p in points],
        "name": [p.name for p in points],
        "kind": [str(p.kind) for p in points],
    }
    columns: dict[str, Column] = {
        "order": np.array([p.order for p in points], dtype=int),
        "note": [p.note for p in points],
        "cause": [p.cause for p in points],
        "status": [str(p.status) for p in points],
        "precision": np.array([p.precision for p in points], dtype=float),
        "interval_min": ends[:, 0],
        "interval_max": ends[:, 1],
        "branches": [" ".join(p.branches) for p in points],
    }
    for name in dict.fromkeys(name for p in points for name in p.exact):
        columns[f"{name}_exact"] = [p.exact.get(name) for p in points]
    parameter, x = unique_names((diagram.parameter_name, diagram.x_name), (*first, *columns))
    first[parameter] = np.array([p.parameter for p in points], dtype=float)
    first[x] = np.array([p.x for p in points], dtype=float)
    return first | columns


def _of_node(point: SpecialPoint) -> dict[str, str | float]:
    ends = zip(("interval_min", "interval_max"), point.interval or (), strict=False)
    return {
        "kind": str(point.kind),
        "parameter": float(point.parameter),
        "x": float(point.x),
        "order": float(point.order),
        "note": point.note,
        "cause": point.cause,
        "status": str(point.status),
        "precision": float(point.precision),
        "name": point.name,
        **{name: float(end) for name, end in ends},
        **{f"{name}_exact": text_of(value) for name, value in point.exact.items()},
    }


def _of_edge(branch: Branch) -> dict[str, str | float]:
    changes = (f"{branch.parameter[s.first]:.10g}: {s.cause}" for s in branch.changes)
    return {
        "kind": str(branch.kind),
        "order": float(branch.order),
        "word": branch.word,
        "stable": share_stable(branch),
        "parameter_min": float(branch.parameter.min()),
        "parameter_max": float(branch.parameter.max()),
        "x_min": float(branch.x.min()),
        "x_max": float(branch.x.max()),
        "samples": float(len(branch)),
        "words": "; ".join(stretch.word for stretch in branch.words),
        "changes": "; ".join(changes),
        **{f"{name}_exact": _formulas(branch, name) for name in branch.exact},
    }


def _formulas(branch: Branch, name: str) -> str:
    found = (stretch.exact[name] for stretch in branch.words if name in stretch.exact)
    return "; ".join(map(text_of, found))


def load_diagram(path: str | Path) -> Diagram:
    """Read a diagram that :meth:`Diagram.save` wrote, of a piecewise-linear map or of the toy.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    Diagram
        Equal to the saved one, to the last bit, with the same exact formulas.

    Raises
    ------
    ValueError, FileNotFoundError
        If it is no saved diagram, of a newer version, or not there.

    Examples
    --------
    >>> from pwmap import Diagram, load_diagram
    >>> empty = Diagram(parameter_name="p", x_name="x", branches=(), points=())
    >>> load_diagram(empty.save("empty.json")) == empty
    True
    """

    def check(found: Diagram) -> None:
        check_exact(found.parameter_name, found.sample, found.branches, found.points)

    diagram: Diagram = read_record(path, Diagram, NAME, VERSION, check=check)
    return diagram
