"""Branches, special points and the diagram they form, for any map of the line.

A branch is a curve over the parameter: fixed points of an iterate P_j, or a jump of P_j
whose one-sided limits lie strictly on opposite sides of the diagonal. A special point ends
branches. Both packages share these classes and their export (:mod:`pwmap.diagrams.graph`).
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cmp_to_key
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import networkx as nx
import numpy as np
import numpy.typing as npt

from pwmap.diagrams.formulas import text_of
from pwmap.diagrams.frames import Column, DataFrame, dataframe, joined
from pwmap.diagrams.record import attributes
from pwmap.diagrams.saved import read_record, write_record
from pwmap.diagrams.shown import brief, counted, span, table, tally
from pwmap.diagrams.slices import Slice, Value, exact_number

NAME, VERSION = "diagram", 1  # of its files; a change that older code would misread raises it

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]


class BranchKind(StrEnum):
    """What a branch is a curve of.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, BranchKind, bifurcation_diagram
    >>> lines = PiecewiseLinearMap.from_sympy("Piecewise((p + x/2, x <= 0), (p - 1 + x/3, True))")
    >>> diagram = bifurcation_diagram(lines, "p", (-1, 2), orders=(1,))
    >>> [branch.id for branch in diagram.branches if branch.kind is BranchKind.FIXED_POINT]
    ['F1', 'F2']
    >>> print(BranchKind.JUMP)
    jump
    """

    FIXED_POINT = "fixed-point"
    JUMP = "jump"
    BAND = "band"


class PointKind(StrEnum):
    """What ends or marks branches; the value is the code used in tables and graphs.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, PointKind, bifurcation_diagram
    >>> lines = PiecewiseLinearMap.from_sympy("Piecewise((p + x/2, x <= 0), (p - 1 + x/3, True))")
    >>> diagram = bifurcation_diagram(lines, "p", (-1, 2), orders=(1,))
    >>> [point.parameter for point in diagram.points if point.kind is PointKind.BC]
    [0.0, 1.0]
    >>> print(PointKind.FF, PointKind.FF.label)
    FF fold-flip
    """

    LP = "LP"
    PD = "PD"
    NS = "NS"
    BP = "BP"
    BC = "BC"
    FF = "FF"
    FALL = "FALL"
    EP = "EP"
    MC = "MC"
    XC = "XC"
    FC = "FC"

    @property
    def meaning(self) -> str:
        """One phrase that says what it is."""
        return _MEANINGS[self.value]

    @property
    def label(self) -> str:
        """A name for a legend or a table."""
        return _MEANINGS[self.value].partition(":")[0]


_MEANINGS = {
    "LP": "fold: multiplier +1",
    "PD": "flip: multiplier -1",
    "NS": "Neimark-Sacker: a pair of multipliers on the unit circle",
    "BP": "branch point: multiplier +1, two branches cross",
    "BC": "border collision: a fixed point meets a jump, a kink or a grazing",
    "FF": "fold-flip: a border collision that also starts a jump branch of the second iterate",
    "FALL": "free fall: the return is lost",
    "EP": "end point: end of the parameter span or of the window",
    "MC": "merging crisis: bands of a chaotic attractor meet in a repelling cycle",
    "XC": "expansion crisis: a chaotic attractor becomes larger at once",
    "FC": "final crisis: a chaotic attractor is lost",
}


class PointStatus(StrEnum):
    """How well the place of a special point is known.

    Examples
    --------
    >>> from pwmap import PointStatus
    >>> [(status.name, status.value) for status in PointStatus]
    [('LOCATED', 'located'), ('OPEN', 'open')]
    """

    LOCATED = "located"
    OPEN = "open"

    @property
    def meaning(self) -> str:
        """One phrase that says what it is."""
        return _STATUSES[self.value]


_STATUSES = {
    "located": "it solves the equations of what it is, as closely as its precision says",
    "open": "a branch was given up here: how it goes on is not known",
}


def _locked(values: Sequence[float] | FloatArray, dtype: type) -> npt.NDArray[np.generic]:
    array: npt.NDArray[np.generic] = np.array(values, dtype=dtype)
    if array.ndim != 1:
        raise ValueError(f"a branch needs one-dimensional arrays, got shape {array.shape}")
    array.setflags(write=False)
    return array


@dataclass(frozen=True, slots=True)
class Stretch:
    """A part of a branch along which the word does not change.

    Attributes
    ----------
    first
        Its first sample; it ends where the next stretch begins.
    word
        The word.
    cause
        A sentence on what happens where it begins; empty at the start of a branch.
    exact
        Exact sympy expressions by name, e.g. ``{"x": r/(a + 1)}``; empty for the toy.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, bifurcation_diagram
    >>> p1 = PiecewiseLinearMap.from_sympy(
    ...     "Piecewise((r - 2, x <= 0), (r - a*x, True))", given=["a > 1"]
    ... )
    >>> diagram = bifurcation_diagram(p1.at({"a": "5/4"}), "r", (-1, 12), orders=(4,))
    >>> [stretch.word for stretch in diagram.branch("J1").words]
    ['RRRR|RRRL']
    """

    first: int
    word: str
    cause: str = ""
    exact: Mapping[str, object] = field(default_factory=dict, hash=False, repr=False)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Branch:
    """A curve between two special points; its word may change where the map is continuous.

    Parameters
    ----------
    id
        Name of the branch, unique in its diagram, without ``:``.
    kind
        Fixed points of P_order, a jump of P_order that crosses the diagonal, or a band of a chaotic
        attractor that P_order maps to itself; then x is its middle.
    order
        The iterate j >= 1 the branch belongs to.
    word
        Sequence of events (toy) or of visited pieces (piecewise-linear map) at its first sample.
    parameter, x, multiplier
        Samples along the curve, each of shape (n,), n >= 1. The multiplier of a jump is nan.
    ends
        Ids of the special points at the first and the last sample.
    exact
        Exact sympy expressions by name, of its first stretch as ``word`` is; empty for the toy.
    attracts
        Whether its fixed points attract, where the multiplier does not say: a point that stays at
        the border of two pieces has another slope on the other side. None if the multiplier does.
    words
        Its stretches in order, by default one; the first has ``word`` and ``exact``.
    columns
        What else was observed at each sample, arrays (n,) by name.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, bifurcation_diagram
    >>> lines = PiecewiseLinearMap.from_sympy("Piecewise((p + x/2, x <= 0), (p - 1 + x/3, True))")
    >>> branch = bifurcation_diagram(lines, "p", (-1, 2), orders=(1,)).branch("J1")
    >>> branch.word, branch.ends, branch.x.tolist()
    ('L|R', ('BC1', 'BC2'), [0.0, 0.0])
    >>> branch.exact["interval"]
    Interval.open(0, 1)
    """

    id: str
    kind: BranchKind
    order: int
    word: str
    parameter: FloatArray
    x: FloatArray
    multiplier: FloatArray
    ends: tuple[str, str]
    exact: Mapping[str, object] = field(default_factory=dict)
    attracts: bool | None = None
    words: tuple[Stretch, ...] = ()
    columns: Mapping[str, FloatArray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.id or ":" in self.id:
            raise ValueError(f"a branch id must be text without ':', got {self.id!r}")
        if self.order < 1:
            raise ValueError(f"order must be at least 1, got {self.order}")
        for name in ("parameter", "x", "multiplier"):
            object.__setattr__(self, name, _locked(getattr(self, name), float))
        if not self.parameter.shape == self.x.shape == self.multiplier.shape != (0,):
            raise ValueError(
                "parameter, x and multiplier must have one common length of at least 1, got "
                f"{self.parameter.size}, {self.x.size} and {self.multiplier.size}"
            )
        object.__setattr__(self, "kind", BranchKind(self.kind))
        words = tuple(self.words) or (Stretch(0, self.word),)
        firsts = [stretch.first for stretch in words]
        if firsts[0] != 0 or firsts[-1] >= len(self) or firsts != sorted(set(firsts)):
            raise ValueError(
                f"stretches must ascend from sample 0 to one below {len(self)}, got {firsts}"
            )
        if words[0].word != self.word:
            raise ValueError(
                f"the first stretch must have the word {self.word!r}, got {words[0].word!r}"
            )
        first = replace(words[0], exact=self.exact)
        object.__setattr__(self, "words", (first, *words[1:]))
        columns = {name: _locked(values, float) for name, values in self.columns.items()}
        for name, values in columns.items():
            if len(values) != len(self):
                raise ValueError(
                    f"column {name!r} must have a value for each of {len(self)} samples, "
                    f"got {len(values)}"
                )
        object.__setattr__(self, "columns", columns)

    @property
    def changes(self) -> tuple[Stretch, ...]:
        """The stretches that begin with a change of word: all but the first."""
        return self.words[1:]

    def stretch_at(self, sample: int) -> Stretch:
        """The stretch that a sample belongs to.

        Parameters
        ----------
        sample
            Which sample, from 0 on.

        Returns
        -------
        Stretch
            The last one that begins there or before.

        Raises
        ------
        IndexError
            If there is no such sample.
        """
        if not 0 <= sample < len(self):
            raise IndexError(f"sample must lie in [0, {len(self) - 1}], got {sample}")
        return self.words[bisect_right(self.words, sample, key=lambda s: s.first) - 1]

    def word_at(self, sample: int) -> str:
        """The word of a sample.

        Parameters
        ----------
        sample
            Which sample, from 0 on.

        Returns
        -------
        str
            That of the stretch that holds the sample.

        Raises
        ------
        IndexError
            If there is no such sample.
        """
        return self.stretch_at(sample).word

    @property
    def stable(self) -> BoolArray:
        """Shape (n,): whether abs(multiplier) < 1, or ``attracts``; False on a jump branch."""
        if self.attracts is not None:
            return np.full(len(self), self.attracts)
        return np.asarray(np.abs(self.multiplier) < 1.0)

    def to_dataframe(self) -> DataFrame:
        """The samples of the branch, one in each row.

        Returns
        -------
        pandas.DataFrame
            With the columns ``branch``, ``kind``, ``order``, ``word``, ``parameter``, ``x``,
            ``multiplier``, ``stable`` and those of :attr:`columns`.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        return dataframe(self._table("parameter", "x"))

    def _table(self, parameter: str, x: str) -> dict[str, Column]:
        """Columns of a row for each sample; the names of two are given."""
        firsts = [stretch.first for stretch in self.words]
        lengths = np.diff([*firsts, len(self)]).tolist()
        words = [s.word for s, n in zip(self.words, lengths, strict=True) for _ in range(n)]
        table: dict[str, Column] = {
            "branch": [self.id] * len(self),
            "kind": [str(self.kind)] * len(self),
            "order": np.full(len(self), self.order),
            "word": words,
            parameter: self.parameter,
            x: self.x,
            "multiplier": self.multiplier,
            "stable": self.stable,
        }
        return {**table, **self.columns}

    def __len__(self) -> int:
        return int(self.parameter.size)

    def __repr__(self) -> str:
        """What it is, where, between which points; the word of its first sample."""
        stable = "" if self.kind is BranchKind.JUMP else f"stable: {_share(self)}, "
        return (
            f"Branch({self.id}: {self.kind} of order {self.order}, {counted(len(self), 'sample')}, "
            f"parameter {span(self.parameter)}, x {span(self.x)}, {stable}"
            f"from {self.ends[0]} to {self.ends[1]}, word {brief(self.word)!r})"
        )

    def _repr_html_(self) -> str:
        p, x, m = self.parameter, self.x, self.multiplier
        rows = [
            (f"{p[s.first]:.6g}", f"{x[s.first]:.6g}", f"{m[s.first]:.4g}", s.word, s.cause)
            for s in self.words
        ]
        header = ("parameter from", "x", "multiplier", "word", "what happens there")
        return table(repr(self), header, rows)


@dataclass(frozen=True, slots=True, kw_only=True)
class SpecialPoint:
    """A point of the (parameter, x) plane where branches end or meet.

    Parameters
    ----------
    id
        Name of the point, unique in its diagram, without ``:``.
    kind
        One of the codes of :class:`PointKind`.
    parameter, x
        Where it lies.
    branches
        Ids of the branches that end here.
    order
        The iterate it belongs to.
    note
        What the code leaves open, e.g. ``"persistence"`` or ``"fold"`` for a BC.
    exact
        Exact sympy expressions by name; empty for the toy.
    cause
        A sentence on what happens there; empty if the code says it all.
    interval
        Interval of the parameter that holds it. None if it is open, or where ``exact`` says the
        parameter.
    precision
        How well the parameter is located: 0 if it is exact, infinite if it is open.
    status
        Whether it was located.
    name
        What it is called, such as A; see :meth:`Diagram.named`.

    Raises
    ------
    ValueError
        If the id is no text without ``:``, kind or status is unknown, the precision is negative, or
        the interval does not hold the parameter.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, bifurcation_diagram
    >>> lines = PiecewiseLinearMap.from_sympy("Piecewise((p + x/2, x <= 0), (p - 1 + x/3, True))")
    >>> point = bifurcation_diagram(lines, "p", (-1, 2), orders=(1,)).point("BC2")
    >>> point.kind.label, point.note, point.parameter, point.x
    ('border collision', 'persistence', 1.0, 0.0)
    >>> point.branches
    ('J1', 'F2')
    """

    id: str
    kind: PointKind
    parameter: float
    x: float
    branches: tuple[str, ...] = ()
    order: int = 1
    note: str = ""
    exact: Mapping[str, object] = field(default_factory=dict)
    cause: str = ""
    interval: tuple[float, float] | None = None
    precision: float = 0.0
    status: PointStatus = PointStatus.LOCATED
    name: str = ""

    def __post_init__(self) -> None:
        if not self.id or ":" in self.id:
            raise ValueError(f"a point id must be text without ':', got {self.id!r}")
        object.__setattr__(self, "kind", PointKind(self.kind))
        object.__setattr__(self, "status", PointStatus(self.status))
        if not self.precision >= 0.0:
            raise ValueError(f"a precision must be at least 0, got {self.precision}")
        if self.interval is not None:
            low, high = self.interval
            if not low <= self.parameter <= high:
                raise ValueError(
                    f"the interval of a point must hold its parameter {self.parameter}, "
                    f"got ({low}, {high})"
                )


class Hit(NamedTuple):
    """Where a branch is at one value of the parameter.

    Attributes
    ----------
    x, multiplier
        As floats; the multiplier of a jump is nan.
    exact
        By name as in :attr:`Stretch.exact`, without ``interval``; empty for the toy.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, bifurcation_diagram
    >>> lines = PiecewiseLinearMap.from_sympy("Piecewise((p + x/2, x <= 0), (p - 1 + x/3, True))")
    >>> hit, = bifurcation_diagram(lines, "p", (-1, 2), orders=(1,)).at("-1/2")
    >>> hit.branch.id, hit.x, hit.multiplier, hit.exact["x"]
    ('F1', -1.0, 0.5, -1)
    """

    branch: Branch
    x: float
    multiplier: float
    exact: Mapping[str, Any] = {}


class StableInterval(NamedTuple):
    """An interval of the parameter in which a branch attracts, up to its samples.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, bifurcation_diagram
    >>> lines = PiecewiseLinearMap.from_sympy("Piecewise((p + x/2, x <= 0), (p - 1 + x/3, True))")
    >>> diagram = bifurcation_diagram(lines, "p", (-1, 2), orders=(1,))
    >>> [(each.branch.id, each.low, each.high) for each in diagram.stable_intervals()]
    [('F1', -1.0, 0.0), ('F2', 1.0, 2.0)]
    """

    branch: Branch
    low: float
    high: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Diagram:
    """Branches and special points over one parameter.

    Parameters
    ----------
    parameter_name, x_name
        Names for axes, tables and graph attributes, e.g. ``"eps_n1"`` and ``"phi_s"``.
    branches, points
        In the order in which they were found; ends of branches refer to ids of points.
    given
        Under which conditions on other, symbolic parameters the diagram holds, or how it was found.
    sample
        Values of these parameters by name, at which the floats were taken.
    about
        What made the diagram: the program with its version and, for the toy, its parameters, law of
        impact and the settings that are not the default. Values that JSON can say, by name.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, bifurcation_diagram
    >>> lines = PiecewiseLinearMap.from_sympy("Piecewise((p + x/2, x <= 0), (p - 1 + x/3, True))")
    >>> diagram = bifurcation_diagram(lines, "p", (-1, 2), orders=(1,))
    >>> [(point.id, point.note) for point in diagram.points]
    [('EP1', 'end of the span'), ('BC1', 'persistence'), ('BC2', 'persistence'), ('EP2', 'end of the
    span')]
    >>> diagram.sides("BC1")  # branches on the left and on the right
    (('F1',), ('J1',))
    >>> [(hit.branch.id, hit.x) for hit in diagram.at("1/2")]
    [('J1', 0.0)]
    >>> diagram.graph().number_of_edges()
    3
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

    def __repr__(self) -> str:
        """A few lines: over which parameter, how many branches of each order, which points."""
        lines = [f"Diagram({self.x_name} over {self.parameter_name}: {self._size()}"]
        orders = sorted({branch.order for branch in self.branches})
        lines += [
            f"order {order}: {tally(b.kind for b in self.branches if b.order == order)}"
            for order in orders
        ]
        if self.points:
            lines.append(f"points: {tally(point.kind for point in self.points)}")
        return "\n    ".join(lines) + ")"

    def _size(self) -> str:
        ends = [each for branch in self.branches for each in branch.parameter[[0, -1]].tolist()]
        within = f" in [{min(ends):.6g}, {max(ends):.6g}]" if ends else ""
        return (
            f"{counted(len(self.branches), 'branch')}{within}, "
            f"{counted(len(self.points), 'special point')}"
        )

    def _repr_html_(self) -> str:
        rows = [
            (
                *(p.name or p.id, ", ".join(filter(None, (p.kind.label, p.note)))),
                *(p.exact.get("parameter", f"{p.parameter:.10g}"), p.exact.get("x", f"{p.x:.10g}")),
                *(p.order, " ".join(p.branches)),
            )
            for p in self.points
        ]
        header = ("point", "what", self.parameter_name, self.x_name, "order", "branches")
        return table(f"{self.x_name} over {self.parameter_name}: {self._size()}", header, rows)

    def branch(self, branch_id: str) -> Branch:
        """Look a branch up.

        Parameters
        ----------
        branch_id
            Its id, such as ``F1``.

        Returns
        -------
        Branch
            It.

        Raises
        ------
        KeyError
            If there is none.
        """
        if branch_id not in self._branch:
            raise KeyError(f"no branch {branch_id!r} in this diagram")
        return self._branch[branch_id]

    def point(self, point_id: str) -> SpecialPoint:
        """Look a special point up.

        Parameters
        ----------
        point_id
            Its id or its name, such as ``BC1`` or ``A``.

        Returns
        -------
        SpecialPoint
            It.

        Raises
        ------
        KeyError
            If there is none.
        """
        if point_id in self._point:
            return self._point[point_id]
        for point in self.points:
            if point.name == point_id != "":
                return point
        raise KeyError(f"no special point {point_id!r} in this diagram")

    def named(
        self, places: Mapping[str, tuple[float, float] | str], within: float = 0.01
    ) -> Diagram:
        """The same diagram with names for special points, such as those of a publication.

        Parameters
        ----------
        places
            For each name the id of a point, such as ``PD1``, or a parameter and an x. A border
            collision so near gets the name: of those of the lowest order, the nearest.
        within
            Largest distance in either, as a part of what the diagram extends over. A name is left
            out if no border collision lies so close to its place.

        Returns
        -------
        Diagram
            A copy; points that were named before and are not named now keep their names.

        Raises
        ------
        ValueError
            If a name is that of another point's id, or two names fall on one point.
        KeyError
            If there is no point of an id.
        """
        given: dict[str, str] = {}
        for name, place in places.items():
            if name in self._point:
                raise ValueError(f"a name must differ from all ids of points, got {name!r}")
            point = (
                self.point(place) if isinstance(place, str) else self._collision_near(place, within)
            )
            if point is None:
                continue
            if point.id in given:
                raise ValueError(f"{given[point.id]!r} and {name!r} are names for one point")
            given[point.id] = name
        points = tuple(replace(p, name=given.get(p.id, p.name)) for p in self.points)
        return replace(self, points=points)

    def _collision_near(self, place: tuple[float, float], within: float) -> SpecialPoint | None:
        """The border collision of a place, in parts of what the diagram extends over.

        Points of iterates lie beside those of the map, closer to a rounded place than these.
        """
        ends = (
            [branch.parameter for branch in self.branches],
            [branch.x for branch in self.branches],
        )
        sizes = [float(np.ptp(np.concatenate(values))) or 1.0 for values in ends if values]

        def away(point: SpecialPoint) -> float:
            gaps = (point.parameter - place[0], point.x - place[1])
            return max(abs(gap) / size for gap, size in zip(gaps, sizes, strict=True))

        near = [
            point
            for point in self.points
            if point.kind in (PointKind.BC, PointKind.FF) and away(point) <= within
        ]
        return min(near, key=lambda point: (point.order, away(point)), default=None)

    def sides(self, point_id: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Ids of the branches that meet at a point, at smaller and at larger parameters.

        A branch along one value of the parameter is in neither; one that starts and ends at the
        point comes once for each end.

        Parameters
        ----------
        point_id
            Its id or its name.

        Returns
        -------
        tuple of two tuples of str
            Ids at smaller parameters, and at larger ones.

        Raises
        ------
        KeyError
            If there is no such point.
        """
        point = self.point(point_id)
        left: list[str] = []
        right: list[str] = []
        for branch in self._incident[point.id]:
            for end, side in zip(branch.ends, _sides_of_ends(branch, point), strict=True):
                if end == point.id and side:
                    (left if side < 0 else right).append(branch.id)
        return tuple(left), tuple(right)

    def at(self, parameter: object) -> tuple[Hit, ...]:
        """What the diagram shows at one value of the parameter, in order of x.

        In an exact diagram all values are exact, also at and between the ends of branches: a branch
        is met where the ``interval`` of one of its stretches holds the parameter. One that lies
        along this value, a band of fixed points, is met at both of its ends, whether or not these
        belong to it. Where other parameters are symbolic, it is met and sorted as at
        :attr:`sample`, where the floats are taken too, and the exact values are formulas in them.

        Otherwise values lie on the straight line between neighbouring samples of a branch; a branch
        that turns round is met more than once.

        Parameters
        ----------
        parameter
            A number. For an exact diagram an int, a Fraction, text such as ``"5/4"``, a rational or
            algebraic number of sympy, or a float, which is taken as the binary number it holds.

        Returns
        -------
        tuple of Hit
            In order of x; empty where there is nothing.

        Raises
        ------
        ValueError, TypeError
            If it is no finite real number; the sentence names it.
        """
        if any("interval" in branch.exact for branch in self.branches):
            return self._exact_hits(parameter)
        at = float(parameter)  # type: ignore[arg-type]
        hits = [hit for branch in self.branches for hit in _between_samples(branch, at)]
        return tuple(sorted(hits, key=lambda hit: hit.x))

    def _exact_hits(self, parameter: object) -> tuple[Hit, ...]:
        here = Slice(self.parameter_name, exact_number(parameter), self.sample)
        found: list[tuple[Value, Hit]] = []
        for branch in self.branches:
            for formulas in (stretch.exact for stretch in branch.words):
                if "interval" in formulas and here.meets(formulas["interval"]):
                    found += _hits_of(branch, formulas, here)

        def by_x(one: tuple[Value, Hit], other: tuple[Value, Hit]) -> int:
            return here.compare(one[0], other[0])

        return tuple(hit for _, hit in sorted(found, key=cmp_to_key(by_x)))

    def component_of(self, point_id: str) -> Diagram:
        """All that is connected with a special point.

        Parameters
        ----------
        point_id
            Its id or its name.

        Returns
        -------
        Diagram
            With the branches and points from which there is a way to it.

        Raises
        ------
        KeyError
            If there is no such point.
        """
        near = nx.node_connected_component(self.graph(), self.point(point_id).id)
        return self._part([branch for branch in self.branches if branch.ends[0] in near])

    def of_order(self, order: int) -> Diagram:
        """The branches of one iterate, and the points they end in.

        Parameters
        ----------
        order
            Which iterate: 2 for P_2.

        Returns
        -------
        Diagram
            Empty if none is of that order.
        """
        return self._part([branch for branch in self.branches if branch.order == order])

    def within(self, low: float, high: float) -> Diagram:
        """The branches that exist somewhere in an interval of the parameter, and their ends.

        Parameters
        ----------
        low, high
            Ends of the interval, both of which belong to it.

        Returns
        -------
        Diagram
            With whole branches, also where they reach beyond.
        """
        return self._part(
            [
                branch
                for branch in self.branches
                if branch.parameter.min() <= high and branch.parameter.max() >= low
            ]
        )

    def _part(self, branches: Sequence[Branch]) -> Diagram:
        """Some branches and the points they end in, which know of no others."""
        kept = {branch.id for branch in branches}
        ends = {end for branch in branches for end in branch.ends}
        points = [
            replace(point, branches=tuple(name for name in point.branches if name in kept))
            for point in self.points
            if point.id in ends
        ]
        return replace(self, branches=tuple(branches), points=tuple(points))

    def path(self, first: str, last: str) -> tuple[str, ...]:
        """A shortest way from one place to another: ids of branches and points in turn.

        Parameters
        ----------
        first, last
            Ids of branches, or ids or names of points.

        Returns
        -------
        tuple of str
            Empty if they are not connected.

        Raises
        ------
        KeyError
            If there is no such branch or point.
        """
        graph = nx.Graph()
        graph.add_nodes_from((branch.id, 0) for branch in self.branches)
        graph.add_nodes_from((point.id, 1) for point in self.points)
        graph.add_edges_from(((b.id, 0), (end, 1)) for b in self.branches for end in b.ends)
        start, stop = self._place(first), self._place(last)
        if not nx.has_path(graph, start, stop):
            return ()
        return tuple(name for name, _ in nx.shortest_path(graph, start, stop))

    def _place(self, name: str) -> tuple[str, int]:
        """A branch or a point as a node between which there are ways: ids of both may be one."""
        if name in self._branch:
            return name, 0
        try:
            return self.point(name).id, 1
        except KeyError:
            raise KeyError(f"no branch and no special point {name!r} in this diagram") from None

    def with_word(self, word: str) -> tuple[Branch, ...]:
        """Branches that have a word, at least along one of their stretches.

        Parameters
        ----------
        word
            The whole word.

        Returns
        -------
        tuple of Branch
            In the order of :attr:`branches`.
        """
        return tuple(b for b in self.branches if any(s.word == word for s in b.words))

    def stable_intervals(self, order: int | None = None) -> tuple[StableInterval, ...]:
        """Intervals of the parameter in which fixed points attract, by branch.

        Parameters
        ----------
        order
            Only fixed points of this iterate; by default of all.

        Returns
        -------
        tuple of StableInterval
            With the branch, and both ends of the parameter.
        """
        found = []
        for branch in self.branches:
            if branch.kind is BranchKind.FIXED_POINT and order in (None, branch.order):
                stable = branch.stable.copy()
                if len(branch) > 2:  # ends may be flips, where the multiplier is -1 up to rounding
                    stable[0], stable[-1] = stable[1], stable[-2]
                for first, last in runs_of(stable):
                    p = branch.parameter[first : last + 1]
                    found.append(StableInterval(branch, float(p.min()), float(p.max())))
        return tuple(found)

    def save(self, path: str | Path) -> Path:
        """Write all that the diagram holds as a file that :func:`pwmap.load_diagram` reads.

        The file is JSON: numbers are kept to the last bit, exact values as formulas, see
        :mod:`pwmap.diagrams.encoding`. It is written beside its final place and then renamed.

        Parameters
        ----------
        path
            The file, usually ``.json``; a name that ends with ``.gz`` is compressed, to a third or
            less. Its folder must exist.

        Returns
        -------
        pathlib.Path
            Where it was written.

        Raises
        ------
        FileNotFoundError
            If the folder does not exist.
        TypeError
            If an exact value is no algebraic formula.
        """
        path = Path(path)
        write_record(path, self, NAME, VERSION)
        return path

    def plot(self, ax: Any = None, **options: Any) -> Any:
        """Draw the branches and special points.

        Parameters
        ----------
        ax
            Axes of matplotlib to draw on; new ones by default.
        options
            Such as ``legend``, ``labels``, ``words``, ``stable_only`` and ``styles``: see
            :func:`pwmap.plot.plot_diagram`.

        Returns
        -------
        pwmap.plot_drawn.Drawn
            With ``figure``, ``ax`` and ``artists``.
        """
        drawing = import_module("pwmap.plot")  # above this file: it draws what is defined here
        return drawing.plot_diagram(self, ax, **options)

    def to_dataframe(self) -> DataFrame:
        """The samples of all branches, one in each row, in the order of :attr:`branches`.

        Returns
        -------
        pandas.DataFrame
            As :meth:`Branch.to_dataframe` says, but the columns of the parameter and of x have
            their names, such as ``eps_n1`` and ``phi_s``. What was not observed on a branch is nan.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        tables = [branch._table(self.parameter_name, self.x_name) for branch in self.branches]
        first = ("branch", "kind", "order", "word", self.parameter_name, self.x_name)
        return dataframe(joined(tables, (*first, "multiplier", "stable")))

    def points_to_dataframe(self) -> DataFrame:
        """The special points, one in each row.

        Returns
        -------
        pandas.DataFrame
            With the columns ``point`` (its id), ``name``, ``kind``, those of the parameter and of x
            by their names, ``order``, ``note``, ``cause``, ``status``, ``precision``,
            ``interval_min`` and ``interval_max`` (nan where there is no interval), ``branches``
            (ids with blanks between), and exact values as expressions of sympy: ``x_exact`` and
            so on, None where a point has no such value.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        points = self.points
        ends = np.array([p.interval or (math.nan, math.nan) for p in points]).reshape(-1, 2)
        table: dict[str, Column] = {
            "point": [p.id for p in points],
            "name": [p.name for p in points],
            "kind": [str(p.kind) for p in points],
            self.parameter_name: np.array([p.parameter for p in points], dtype=float),
            self.x_name: np.array([p.x for p in points], dtype=float),
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
            table[f"{name}_exact"] = [p.exact.get(name) for p in points]
        return dataframe(table)

    def graph(self) -> nx.MultiGraph:
        """How the branches are connected.

        Returns
        -------
        networkx.MultiGraph
            Nodes are special points, edges are branches keyed by their id. All numeric
            attributes are floats, all others text, so that every export format keeps them. Of the
            graph these are ``parameter``, ``x``, ``given`` and the parts of ``about``, JSON where
            they are no numbers or texts.
        """
        graph = nx.MultiGraph(parameter=self.parameter_name, x=self.x_name)
        if self.given:
            graph.graph["given"] = ", ".join(self.given)
        graph.graph.update(attributes(self.about))
        for point in self.points:
            graph.add_node(
                point.id,
                kind=str(point.kind),
                parameter=float(point.parameter),
                x=float(point.x),
                order=float(point.order),
                note=point.note,
                cause=point.cause,
                status=str(point.status),
                precision=float(point.precision),
                name=point.name,
                **_bounds(point),
                **{f"{name}_exact": text_of(value) for name, value in point.exact.items()},
            )
        for branch in self.branches:
            first, last = branch.ends
            graph.add_edge(
                first,
                last,
                key=branch.id,
                kind=str(branch.kind),
                order=float(branch.order),
                word=branch.word,
                stable=_share(branch),
                parameter_min=float(branch.parameter.min()),
                parameter_max=float(branch.parameter.max()),
                x_min=float(branch.x.min()),
                x_max=float(branch.x.max()),
                samples=float(len(branch)),
                words="; ".join(stretch.word for stretch in branch.words),
                changes="; ".join(
                    f"{branch.parameter[s.first]:.10g}: {s.cause}" for s in branch.changes
                ),
                **{
                    f"{name}_exact": "; ".join(
                        text_of(stretch.exact[name])
                        for stretch in branch.words
                        if name in stretch.exact
                    )
                    for name in branch.exact
                },
            )
        return graph


def load_diagram(path: str | Path) -> Diagram:
    """Read a diagram of :meth:`Diagram.save` again, of a piecewise-linear map or of the toy.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    Diagram
        With the same branches and points as the one that was saved, to the last bit, and the same
        exact formulas.

    Raises
    ------
    ValueError
        If the file is no saved diagram, or one of a newer version of the format.
    FileNotFoundError
        If there is no such file.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, bifurcation_diagram, load_diagram
    >>> lines = PiecewiseLinearMap.from_sympy("Piecewise((p + x/2, x <= 0), (p - 1 + x/3, True))")
    >>> path = bifurcation_diagram(lines, "p", (-1, 2), orders=(1,)).save("lines.json")
    >>> [(branch.id, str(branch.exact["x"])) for branch in load_diagram(path).branches]
    [('F1', '2*p'), ('J1', '0'), ('F2', '3*p/2 - 3/2')]
    """
    diagram: Diagram = read_record(Path(path), Diagram, NAME, VERSION)
    return diagram


def _bounds(point: SpecialPoint) -> dict[str, float]:
    """The interval that holds a point as attributes, if there is one."""
    if point.interval is None:
        return {}
    low, high = point.interval
    return {"interval_min": float(low), "interval_max": float(high)}


def _sides_of_ends(branch: Branch, point: SpecialPoint) -> tuple[int, int]:
    """Whether a branch lies at smaller (-1) or larger (1) parameters than each end at a point.

    In an exact diagram intervals say so, however short they are; otherwise samples do.
    """
    if "interval" in branch.exact:
        return _side(branch.words[0], point), _side(branch.words[-1], point)
    beside = branch.parameter[[min(1, len(branch) - 1), max(-2, -len(branch))]]
    first, last = (int(p > point.parameter) - int(p < point.parameter) for p in beside.tolist())
    return first, last


def _side(stretch: Stretch, point: SpecialPoint) -> int:
    """Whether an exact stretch lies at smaller (-1) or larger (1) parameters than an end of it."""
    interval: Any = stretch.exact["interval"]
    if not hasattr(interval, "left_open"):  # a set of one value
        return 0
    return 1 if interval.start == point.exact["parameter"] else -1


def _hits_of(
    branch: Branch, formulas: Mapping[str, object], here: Slice
) -> Iterator[tuple[Value, Hit]]:
    """Where a branch is that has some formulas at a parameter: a band at both of its ends."""
    names = [n for n in formulas if n not in ("interval", "lower", "upper", "x")]
    values = {name: here.value(formulas[name]) for name in names}
    exact = {name: value.formula for name, value in values.items()}
    multiplier = values["multiplier"].number if "multiplier" in values else math.nan
    for name in ("lower", "upper") if "x" not in formulas else ("x",):
        x = here.value(formulas[name])
        yield x, Hit(branch, x.number, multiplier, {"x": x.formula, **exact})


def _between_samples(branch: Branch, at: float) -> Iterator[Hit]:
    """Where the straight lines between the samples of a branch are at a parameter.

    Samples there are hits; of several in a row, along one value, the first and the last.
    """
    p = branch.parameter
    for run in runs_of(p == at):
        for i in sorted(set(run)):
            yield Hit(branch, float(branch.x[i]), float(branch.multiplier[i]))
    sides = np.sign(p - at)
    for i in np.flatnonzero(sides[:-1] * sides[1:] < 0.0).tolist():
        s = (at - p[i]) / (p[i + 1] - p[i])
        x, m = (
            float((1.0 - s) * values[i] + s * values[i + 1])
            for values in (branch.x, branch.multiplier)
        )
        yield Hit(branch, x, m)


def runs_of(flags: BoolArray) -> list[tuple[int, int]]:
    """First and last index of each run of True."""
    steps = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    return [(int(a), int(b) - 1) for a, b in zip(steps[::2], steps[1::2], strict=True)]


def _share(branch: Branch) -> str:
    """``"yes"``, ``"no"`` or ``"partly"``: whether the branch is stable."""
    inner = branch.stable[1:-1] if len(branch) > 2 else branch.stable
    return "yes" if inner.all() else "partly" if inner.any() else "no"
