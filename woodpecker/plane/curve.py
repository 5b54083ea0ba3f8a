"""Curves of special points over two parameters, with their points of codimension two."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence, Sized
from dataclasses import dataclass, field
from itertools import groupby, pairwise
from pathlib import Path

import numpy as np

from pwmap.diagrams.diagram import PointKind, PointStatus
from pwmap.diagrams.frames import Column, DataFrame, dataframe, unique_names
from pwmap.diagrams.saved import read_record, write_record
from pwmap.diagrams.shown import counted, table
from pwmap.plane.kinds import PlaneKind as PlaneKind  # for the users of woodpecker, too
from woodpecker.base.arrays import Floats
from woodpecker.base.checks import number
from woodpecker.base.shown import shown
from woodpecker.plane.families import Pair, check_axis
from woodpecker.slices.borders import BorderKind

NAME, VERSION = "curve", 1  # of its files; a change that older code would misread raises it


@dataclass(frozen=True, slots=True)
class PlaneStretch:
    """A stretch of a curve along which words do not change.

    Attributes
    ----------
    first
        Its first sample; it ends where the next stretch begins.
    word
        The words of the returns, separated by bars; on a border that of the piece on its inner
        side.
    beyond
        For a cycle on a border, the word of the piece beyond it; else empty.
    cause
        A sentence on what happens where the stretch begins; empty at the start of a curve.

    Examples
    --------
    >>> from woodpecker.examples import border_curve
    >>> curve = border_curve()
    >>> [(stretch.word, stretch.beyond) for stretch in curve.words]
    [('R', 'L')]
    """

    first: int
    word: str
    beyond: str = ""
    cause: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanePoint:
    """A special point of codimension two, or an end, of a curve.

    Attributes
    ----------
    id
        Its code with a number, unique in its curve.
    kind
        Its kind, of which the value is the code.
    values
        Both parameters.
    x
        The points of the cycle.
    sample
        Number of the sample of the curve.
    cause
        A sentence on what happens there.
    precision
        Uncertainty of both parameters; infinite if the point is open.
    status
        Whether it was located, or the curve was given up here.
    starts
        Kinds of other curves that start here, for :func:`woodpecker.curve_in_two` to follow.

    Examples
    --------
    >>> from woodpecker.examples import border_curve
    >>> curve = border_curve(0.5)
    >>> for each in curve.points:
    ...     print(each.kind.label, *(f"{value:.9f}" for value in each.values))
    end point 0.000000000 0.500000000
    flip-border collision 0.000000000 1.000000000
    end point 0.000000000 2.000000000
    """

    id: str
    kind: PlaneKind
    values: Pair
    x: tuple[float, ...]
    sample: int
    cause: str = ""
    precision: Pair = (0.0, 0.0)
    status: PointStatus = PointStatus.LOCATED
    starts: tuple[PointKind, ...] = ()
    seed: object = field(default=None, repr=False, compare=False, hash=False)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Curve:
    """A curve of special points over two parameters.

    Attributes
    ----------
    kind
        LP, PD or BC: a fold, a flip, or a cycle on a border. ``codes`` say what a BC is at each
        sample, such as FF.
    names
        Names of both parameters.
    order
        Period n of the cycle.
    values
        (k, 2) parameters.
    x
        (k, n) points of the cycle; of a BC the point on the border is ``border_index``.
    border_index
        Number of the point on the border; -1 if none is.
    multipliers
        (k, 2) the multiplier of the cycle and, on a border, that with the piece beyond in place of
        the one inside; nan where it does not exist, and if there is no border.
    gaps
        (k,) on a border the difference of both limits of the iterate; else 0.
    borders
        The kind of the border at each sample; empty if there is none.
    codes, notes
        (k,) codes and notes of the special point over one parameter, as in a diagram.
    words
        Stretches with one word each.
    points
        Both ends and the special points between, in order.
    closed
        Whether the curve ends where it begins.
    cause
        On a border, what happens there.
    given
        The conditions under which the curve holds.
    columns
        Further values (k,) along the curve, by name.

    Examples
    --------
    >>> from woodpecker.examples import border_curve
    >>> curve = border_curve()
    >>> curve.names, [tuple(round(value, 9) for value in end.values) for end in curve.ends]
    (('r', 'a'), [(0.0, 1.1), (0.0, 2.0)])
    """

    kind: PointKind
    names: tuple[str, str]
    order: int
    values: Floats
    x: Floats
    border_index: int
    multipliers: Floats
    gaps: Floats
    borders: tuple[BorderKind, ...]
    codes: tuple[PointKind, ...]
    notes: tuple[str, ...]
    words: tuple[PlaneStretch, ...]
    points: tuple[PlanePoint, ...]
    closed: bool = False
    cause: str = ""
    given: tuple[str, ...] = ()
    columns: Mapping[str, Floats] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("values", "x", "multipliers", "gaps"):
            array: Floats = np.array(getattr(self, name), dtype=float)
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    def __len__(self) -> int:
        return len(self.values)

    def __repr__(self) -> str:
        first, last = self.ends
        over, samples = ", ".join(self.names), counted(len(self), "sample")
        return (
            f"Curve({self.kind} over {over}: {samples}, from {first.id} to {last.id}, "
            f"{counted(len(self.points[1:-1]), 'special point')})"
        )

    def _repr_html_(self) -> str:
        rows = [
            (each.id, each.kind.label, *(f"{value:.10g}" for value in each.values), each.cause)
            for each in self.points
        ]
        return table(repr(self), ("point", "what", *self.names, "cause"), rows)

    @property
    def ends(self) -> tuple[PlanePoint, PlanePoint]:
        """The points where the curve starts and ends."""
        return self.points[0], self.points[-1]

    def point(self, name: str) -> PlanePoint:
        """The special point with an id.

        Parameters
        ----------
        name
            Its id, such as ``"JC1"``.

        Returns
        -------
        PlanePoint
            The point.

        Raises
        ------
        KeyError
            If there is none; the message lists all ids.
        """
        for each in self.points:
            if each.id == name:
                return each
        raise KeyError(f"no point {name!r} on this curve, it has {[p.id for p in self.points]}")

    def word_at(self, sample: int) -> str:
        """The word of the cycle at a sample.

        Parameters
        ----------
        sample
            Its number, from 0 on.

        Returns
        -------
        str
            The word of the cycle there.

        Raises
        ------
        IndexError, TypeError
            If there is no such sample, or it is not a whole number.
        """
        if isinstance(sample, bool) or not hasattr(sample, "__index__"):
            raise TypeError(f"sample must be a whole number, got {shown(sample)}")
        if not 0 <= sample < len(self):
            raise IndexError(f"sample must lie in [0, {len(self) - 1}], got {sample}")
        return [each for each in self.words if each.first <= sample][-1].word

    def stretches(self) -> list[tuple[PointKind, str, int, int]]:
        """Runs of samples with the same code and note: these, the first sample, and the last."""
        found = list[tuple[PointKind, str, int, int]]()
        for what, run in groupby(range(len(self)), lambda k: (self.codes[k], self.notes[k])):
            samples = list(run)
            found.append((*what, samples[0], samples[-1]))
        return found

    def save(self, path: str | Path) -> Path:
        """Write JSON for :func:`woodpecker.plane.load_curve`; a name in ``.gz`` compresses it."""
        return write_record(path, self, NAME, VERSION)

    def to_dataframe(self) -> DataFrame:
        """The samples of the curve, one in each row.

        Returns
        -------
        pandas.DataFrame
            Columns are both parameters by their names, ``x_0`` to ``x_(n-1)`` (the points of the
            cycle), ``multiplier`` and ``multiplier_beyond``, ``gap``, ``kind`` and ``note`` (over
            one parameter), ``word``, and those of :attr:`columns`. A parameter with the name of
            another column gets an underscore, such as ``kind_``.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        table: dict[str, Column] = {
            **{f"x_{k}": column for k, column in enumerate(self.x.T)},
            "multiplier": self.multipliers[:, 0],
            "multiplier_beyond": self.multipliers[:, 1],
            "gap": self.gaps,
            "kind": [str(code) for code in self.codes],
            "note": self.notes,
            "word": [self.word_at(k) for k in range(len(self))],
        }
        table.update(self.columns)
        names = unique_names(self.names, table)
        return dataframe({**dict(zip(names, self.values.T, strict=True)), **table})

    def crossings(self, axis: int, value: float) -> list[Pair]:
        """The places where one parameter has a value, by linear interpolation between samples.

        The point where a closed curve begins counts once.

        Parameters
        ----------
        axis
            0 for the first parameter, 1 for the second.
        value
            Its value.

        Returns
        -------
        list of pairs
            Both parameters at each crossing, in the order of the curve.

        Raises
        ------
        ValueError
            If the axis is neither, or the value is not a finite number.
        """
        check_axis(axis)
        wanted = number("value", value)
        if not math.isfinite(wanted):
            raise ValueError(f"value must be finite, got {shown(value)}")
        along, found = self.values[:, axis] - wanted, list[Floats]()
        for k, (a, b) in enumerate(pairwise(along)):
            if a == 0.0 or a * b < 0.0:
                part = 0.0 if a == 0.0 else a / (a - b)
                found.append(self.values[k] + part * (self.values[k + 1] - self.values[k]))
        if along[-1] == 0.0 and not self.closed:
            found.append(self.values[-1])
        return [(float(first), float(second)) for first, second in found]


def load_curve(path: str | Path) -> Curve:
    """Read a curve that :meth:`woodpecker.Curve.save` wrote.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    Curve
        Equal to the saved one, to the last bit, but without the starts of curves at its points.

    Raises
    ------
    ValueError, FileNotFoundError
        If the file is not a saved curve, is of a newer version, or does not exist.

    Examples
    --------
    >>> from woodpecker.examples import border_curve
    >>> from woodpecker.plane import load_curve
    >>> load_curve(border_curve().save("curve.json"))
    Curve(BC over r, a: 54 samples, from EP1 to EP2, 0 special points)
    """
    curve: Curve = read_record(path, Curve, NAME, VERSION, check=check_curve)
    return curve


def check_curve(curve: Curve) -> None:
    """ValueError unless all parts of a curve from a file fit the same samples."""
    k, last = len(curve.values), len(curve.values) - 1
    shapes = {"values": (k, 2), "x": (k, curve.order), "multipliers": (k, 2), "gaps": (k,)}
    for name, shape in shapes.items():
        if getattr(curve, name).shape != shape:
            had = getattr(curve, name).shape
            raise ValueError(f"{name} of this curve must have the shape {shape}, got {had}")
    for name in ("values", "x"):
        if not np.isfinite(getattr(curve, name)).all():
            raise ValueError(f"{name} of a curve must be finite")
    rows: dict[str, Sized] = {"codes": curve.codes, "notes": curve.notes, **curve.columns}
    for name, row in rows.items():
        if len(row) != k:
            raise ValueError(f"{name} of this curve must be {k}, one a sample, got {len(row)}")
    if len(curve.borders) not in (0, k) or not -1 <= curve.border_index < curve.order:
        raise ValueError("the border of a curve must be met by a point of each sample")
    samples = [point.sample for point in curve.points]
    if not samples or samples[:1] + samples[-1:] != [0, last] or not _ascend(samples):
        raise ValueError(f"points of this curve must lie from 0 to {last}, got {samples}")
    if any(len(point.x) != curve.order for point in curve.points):
        raise ValueError(f"a point of this curve must have {curve.order} points of a cycle")
    starts = [each.first for each in curve.words]
    if starts[:1] != [0] or not _ascend([*starts, k]):
        raise ValueError(f"words of this curve must begin at ascending samples, got {starts}")


def _ascend(samples: Sequence[int]) -> bool:
    return all(a < b for a, b in pairwise(samples))


def numbered(kinds: Sequence[PlaneKind]) -> list[str]:
    """The ids of points in order: their codes, each with a number."""
    count: dict[PlaneKind, int] = {}
    names = []
    for kind in kinds:
        count[kind] = count.get(kind, 0) + 1
        names.append(f"{kind}{count[kind]}")
    return names
