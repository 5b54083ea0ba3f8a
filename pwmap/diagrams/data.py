"""Branches and special points, the parts of diagrams of both packages."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Any, NamedTuple, Self

import numpy as np
import numpy.typing as npt

from pwmap.algebra.arguments import (
    check_text,
    checked_number,
    checked_pair,
    explained_fields,
    shown,
)
from pwmap.algebra.texts import printable
from pwmap.diagrams.frames import Column, DataFrame, dataframe
from pwmap.diagrams.shown import brief, counted, span, table

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
# Distance to the unit circle below which rounding hides a multiplier's side.
UNIT_CIRCLE_TOLERANCE = 2.0**-36
INTERVAL = "degenerate: an interval of fixed points"  # a note, where a slope is 1 on a piece
DOUBLED = "degenerate: points nearby have twice the period"  # a note, where it is -1
UNDECIDED = "a multiplier lies on the unit circle, so that it does not decide on stability"


class BranchKind(StrEnum):
    """Kinds of branches: of fixed points, of jumps, or a band of a chaotic attractor."""

    FIXED_POINT = "fixed-point"
    JUMP = "jump"
    BAND = "band"


class Coded(StrEnum):
    """A closed set of codes; each member is defined by its code and a phrase."""

    _value_: str
    meaning: str  #: One phrase that says what it is.

    def __new__(cls, code: str, meaning: str = "") -> Self:  # noqa: D102
        own = str.__new__(cls, code)
        own._value_, own.meaning = code, meaning
        return own

    @property
    def label(self) -> str:
        """A name for a legend or a table."""
        return self.meaning.partition(":")[0]


class PointKind(Coded):
    """Kinds of special points; the value is the code used in tables and graphs."""

    LP = "LP", "fold: multiplier +1"
    PD = "PD", "flip: multiplier -1"
    NS = "NS", "Neimark-Sacker: a pair of multipliers on the unit circle"
    BP = "BP", "branch point: multiplier +1, two branches cross"
    BC = "BC", "border collision: a fixed point meets a jump, a kink or a grazing"
    FF = "FF", "border-collision fold-flip: it also starts a jump branch of the second iterate"
    FALL = "FALL", "free fall: the return is lost"
    EP = "EP", "end point: end of the parameter span or of the window"
    MC = "MC", "merging crisis: bands of a chaotic attractor meet in a repelling cycle"
    XC = "XC", "expansion crisis: a chaotic attractor becomes larger at once (interior crisis)"
    FC = "FC", "final crisis: a chaotic attractor is lost (boundary crisis)"


class PointStatus(Coded):
    """Whether the place of a special point is known."""

    LOCATED = "located", "it solves the equations of what it is, as closely as its precision says"
    OPEN = "open", "a branch was given up here: how it goes on is not known"


def _check_id(what: str, value: object) -> None:
    check_text(what, value)
    if not value or ":" in str(value):
        raise ValueError(f"{what} must be text without ':', got {value!r}")


def _locked(values: Sequence[float] | FloatArray) -> FloatArray:
    array = np.array(values, dtype=float)
    if array.ndim != 1:
        raise ValueError(f"a branch needs one-dimensional arrays, got shape {array.shape}")
    array.setflags(write=False)
    return array


@printable
@dataclass(frozen=True, slots=True)
class Stretch:
    """A part of a :class:`Branch` with one word, from sample ``first`` to that of the next part.

    Where the word changes, ``first`` is the sample at the border, and ``cause`` a sentence on what
    happens there. ``exact`` holds sympy expressions by name, such as ``{"x": r/(a + 1)}``.
    """

    first: int
    word: str
    cause: str = ""
    exact: Mapping[str, object] = field(default_factory=dict, hash=False, repr=False)


@explained_fields
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Branch:
    """A curve between two special points; its word may change where the map is continuous.

    Parameters
    ----------
    id, order
        Unique in its diagram, without ``:``; the iterate, at least 1.
    kind
        Fixed points of P_order; a jump of P_order with one-sided limits strictly on opposite sides
        of the diagonal; or a band of a chaotic attractor that P_order maps to itself, with its
        middle as x.
    word
        Its events (toy) or visited pieces (piecewise-linear map) at the first sample.
    parameter, x, multiplier
        Samples along the curve, of shape (n,), n >= 1. The multiplier of a jump is nan.
    ends
        Ids of the special points at the first and the last sample.
    exact
        Sympy expressions by name, of the first stretch; empty for the toy.
    attracts
        Whether its fixed points attract if they lie on a border, where slopes differ; else None.
    words
        Its stretches in order, by default one; the first has ``word`` and ``exact``.
    columns
        Other observed values, arrays (n,) by name.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, bifurcation_diagram
    >>> p1 = PiecewiseLinearMap.from_sympy("Piecewise((r - 2, x <= 0), (r - 5*x/4, True))")
    >>> branch = bifurcation_diagram(p1, "r", (-1, 12), orders=(2,)).branch("J1")
    >>> branch.word, branch.ends, branch.exact["interval"]
    ('RR|RL', ('FF1', 'BC3'), Interval.open(0, 10))
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
        _check_id("a branch id", self.id)
        if self.order < 1:
            raise ValueError(f"order must be at least 1, got {self.order}")
        for name in ("parameter", "x", "multiplier"):
            object.__setattr__(self, name, _locked(getattr(self, name)))
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
        columns = {name: _locked(values) for name, values in self.columns.items()}
        for name, values in columns.items():
            if len(values) != len(self):
                raise ValueError(
                    f"column {name!r} must have a value for each of {len(self)} samples, "
                    f"got {len(values)}"
                )
        object.__setattr__(self, "columns", columns)

    @property
    def changes(self) -> tuple[Stretch, ...]:
        """All stretches after the first; each begins with a change of word."""
        return self.words[1:]

    def stretch_at(self, sample: int) -> Stretch:
        """The stretch of a sample, counted from 0; IndexError if there is no such sample."""
        if not hasattr(sample, "__index__") or not 0 <= sample < len(self):
            raise IndexError(f"sample must lie in [0, {len(self) - 1}], got {shown(sample)}")
        return self.words[bisect_right(self.words, sample, key=lambda s: s.first) - 1]

    def word_at(self, sample: int) -> str:
        """The word of the stretch of a sample, counted from 0; IndexError if there is none."""
        return self.stretch_at(sample).word

    @property
    def stable(self) -> BoolArray:
        """Whether samples attract, shape (n,), by multiplier or ``attracts``; False for jumps."""
        if self.attracts is not None:
            return np.full(len(self), self.attracts)
        return attracting(self.multiplier)

    @property
    def stability(self) -> str:
        """Of its inside: ``"stable"``, ``"unstable"`` or ``"partly stable"``; empty for jumps."""
        words = {"yes": "stable", "no": "unstable", "partly": "partly stable"}
        return "" if self.kind is BranchKind.JUMP else words[share_stable(self)]

    def to_dataframe(self) -> DataFrame:
        """The samples as rows of a pandas DataFrame; ImportError without pandas.

        Its columns are ``branch``, ``kind``, ``order``, ``word``, ``parameter``, ``x``,
        ``multiplier``, ``stable`` and those of :attr:`columns`.
        """
        return dataframe(columns_of(self, "parameter", "x", self.columns))

    def __len__(self) -> int:
        return int(self.parameter.size)

    def __repr__(self) -> str:
        stability = f"{self.stability}, " if self.stability else ""
        return (
            f"Branch({self.id}: {self.kind} of order {self.order}, {counted(len(self), 'sample')}, "
            f"parameter {span(self.parameter)}, x {span(self.x)}, {stability}"
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


@explained_fields
@printable
@dataclass(frozen=True, slots=True, kw_only=True)
class SpecialPoint:
    """A point of the (parameter, x) plane where branches end or meet; see :class:`Diagram`.

    Parameters
    ----------
    id, branches, order
        Unique in its diagram, without ``:``; ids of the branches that end here; the iterate.
    note
        A detail of the kind, such as ``"persistence"`` or ``"fold"`` of a BC.
    exact
        Sympy expressions by name; empty for the toy.
    cause
        A sentence on what happens there; empty if kind and note say it.
    interval, precision, status
        An interval of the parameter that holds the point, None if it is open or ``exact`` has the
        parameter; the error of its place, 0 if exact, infinite if open; whether it was located.
    name
        Such as A; see :meth:`Diagram.named`.

    Raises
    ------
    ValueError
        If the id is empty or holds ``:``, kind or status is unknown, the precision is negative, or
        the interval does not hold the parameter.
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
        _check_id("a point id", self.id)
        object.__setattr__(self, "kind", PointKind(self.kind))
        object.__setattr__(self, "status", PointStatus(self.status))
        if not checked_number("a precision", self.precision) >= 0.0:
            raise ValueError(f"a precision must be at least 0, got {self.precision}")
        if self.interval is not None:
            low, high = checked_pair("an interval", self.interval)
            if not low <= self.parameter <= high:
                raise ValueError(
                    f"the interval of a point must hold its parameter {self.parameter}, "
                    f"got ({low}, {high})"
                )


class Hit(NamedTuple):
    """A point of a branch from :meth:`Diagram.at`; ``exact`` as of its stretch, but no interval."""

    branch: Branch
    x: float
    multiplier: float
    exact: Mapping[str, Any] = {}


class StableInterval(NamedTuple):
    """A range of parameters in which a branch attracts; see :meth:`Diagram.stable_intervals`."""

    branch: Branch
    low: float
    high: float


def columns_of(
    branch: Branch, parameter: str, x: str, observed: Iterable[str]
) -> dict[str, Column]:
    """Columns of a table with a row for each sample of a branch.

    Parameter and x are named as given; ``observed`` columns are nan where the branch has none.
    """
    firsts = [stretch.first for stretch in branch.words]
    lengths = np.diff([*firsts, len(branch)]).tolist()
    words = [s.word for s, n in zip(branch.words, lengths, strict=True) for _ in range(n)]
    columns: dict[str, Column] = {
        "branch": [branch.id] * len(branch),
        "kind": [str(branch.kind)] * len(branch),
        "order": np.full(len(branch), branch.order),
        "word": words,
        parameter: branch.parameter,
        x: branch.x,
        "multiplier": branch.multiplier,
        "stable": branch.stable,
    }
    missing = np.full(len(branch), np.nan)
    return columns | {name: branch.columns.get(name, missing) for name in observed}


def attracting(multiplier: npt.ArrayLike) -> BoolArray:
    """Whether multipliers lie inside the unit circle by more than rounding."""
    return np.asarray(np.abs(multiplier) < 1.0 - UNIT_CIRCLE_TOLERANCE)


def is_neutral(multiplier: npt.ArrayLike) -> bool:
    """Whether the largest of some multipliers lies on the unit circle, up to rounding."""
    return bool(abs(np.max(np.abs(multiplier)) - 1.0) <= UNIT_CIRCLE_TOLERANCE)


def runs_of(flags: BoolArray) -> list[tuple[int, int]]:
    """First and last index of each run of True."""
    steps = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    return [(int(a), int(b) - 1) for a, b in zip(steps[::2], steps[1::2], strict=True)]


def stable_inside(branch: Branch) -> BoolArray:
    """Whether samples are stable; an end, where it may be neutral, counts as its neighbour."""
    stable = branch.stable.copy()
    if len(branch) > 2:
        stable[0], stable[-1] = stable[1], stable[-2]
    return stable


def share_stable(branch: Branch) -> str:
    """``"yes"``, ``"no"`` or ``"partly"``: whether the branch is stable."""
    stable = stable_inside(branch)
    return "yes" if stable.all() else "partly" if stable.any() else "no"
