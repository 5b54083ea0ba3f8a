"""Exact attractors at the points of a raster of two parameters; curves as arrays for drawing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from sympy import QQ

from pwmap.algebra.arguments import check_functions, check_kind, checked_count, explained, shown
from pwmap.algebra.exact import Number, to_float
from pwmap.algebra.rootfunctions import Column, Root
from pwmap.algebra.roots import Real, bounds, equally_spaced
from pwmap.diagrams.data import FloatArray
from pwmap.diagrams.saved import read_record, write_record
from pwmap.longrun.attractors import attractors_of
from pwmap.longrun.entropy.entropies import entropy_of
from pwmap.longrun.line import MapLine, line_of
from pwmap.maps.budget import BUDGET, Budget, BudgetError, Meter, check_work, metered
from pwmap.plane.curves import PlaneArc
from pwmap.plane.plane import ParameterPlane

IntArray = npt.NDArray[np.int64]
NAME, VERSION = "raster", 1  # of its files; raise the version if older code would misread them
RASTER_BUDGET = Budget(work=40 * BUDGET.work)  # some minutes
POINT = 100  # least work of one point
ORDER = 24  # of the graph of laps: fine enough for colours, bounds of the entropy differ by 0.01


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlaneRaster:
    """Attractors at the centres of equal rectangles of a plane, from :func:`plane_raster`.

    ``across`` and ``along`` are the rational values of both parameters. The arrays have a row for
    each value along, and a column for each value across: ``periods`` has the shortest period of an
    attracting cycle, or 0; ``bands`` the number of bands of all chaotic attractors; ``entropy``
    lower bounds of the topological entropy; ``open`` whether something is not known.
    ``left_out`` is a sentence on columns that were not finished; empty if all were.
    """

    across: tuple[Number, ...]
    along: tuple[Number, ...]
    periods: IntArray
    bands: IntArray
    entropy: FloatArray
    open: npt.NDArray[np.bool_]
    left_out: str = ""

    def __repr__(self) -> str:
        rows, columns = self.open.shape
        rest = f"; {self.left_out}" if self.left_out else ""
        return f"PlaneRaster({columns} x {rows} points, {self.open.sum()} open{rest})"

    def save(self, path: str | Path) -> Path:
        """Write JSON for :func:`pwmap.plane.load_raster`, with ``.gz`` compressed."""
        return write_record(path, self, NAME, VERSION, sealed=True)


def load_raster(path: str | Path) -> PlaneRaster:
    """Read a raster that :meth:`PlaneRaster.save` wrote.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    PlaneRaster
        With the same values.

    Raises
    ------
    ValueError, FileNotFoundError
        As :func:`pwmap.plane.load_plane`.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, parameter_plane
    >>> from pwmap.plane import load_raster, plane_raster
    >>> map_ = PiecewiseLinearMap.from_sympy("a*x + b")
    >>> plane = parameter_plane(map_, "a", "b", ("1/4", "3/4"), (0, 1))
    >>> load_raster(plane_raster(plane, 2, 1).save("raster.json")).periods.tolist()
    [[1, 1]]
    """
    raster: PlaneRaster = read_record(path, PlaneRaster, NAME, VERSION, sealed=True)
    return raster


@explained()
def plane_raster(
    plane: ParameterPlane,
    columns: int = 48,
    rows: int = 36,
    *,
    budget: Budget | Meter = RASTER_BUDGET,
    progress: Callable[[int], None] | None = None,
) -> PlaneRaster:
    """The exact attractors at the points of a raster.

    Parameters
    ----------
    plane, columns, rows
        The plane, and the numbers of values of the parameter across and of the one along.
    budget
        By default forty times that of a single call; columns beyond it are open, and ``left_out``
        says so.
    progress
        Called after each column with the number of finished ones.

    Returns
    -------
    PlaneRaster
        Arrays of shape (rows, columns) over the centres of equal rectangles.

    Raises
    ------
    ValueError
        If there is no column or row. A ``BudgetError`` if there are too many.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, parameter_plane
    >>> from pwmap.plane import plane_raster
    >>> skew = PiecewiseLinearMap.from_sympy("Piecewise((a*x + 1, x <= 0), (b*x + 1, True))")
    >>> plane = parameter_plane(skew, "a", "b", ("1/4", "3/4"), (-5, "-1/2"), orders=(1, 2))
    >>> raster = plane_raster(plane, 3, 2)
    >>> raster.periods.tolist(), raster.bands.tolist()
    ([[0, 3, 0], [2, 2, 0]], [[1, 0, 1], [0, 0, 4]])
    """
    check_kind("plane", plane, ParameterPlane)
    columns, rows = checked_count(columns, "columns"), checked_count(rows, "rows")
    check_functions(progress=progress)
    meter, finished = metered(budget), list[list[_Point]]()
    points = f"{shown(columns)} x {shown(rows)} points"
    check_work(points, POINT * columns * rows, meter)
    across, along = (
        tuple(low + (high - low) * QQ(2 * i + 1, 2 * n) for i in range(n))
        for (low, high), n in ((plane.across_span, columns), (plane.along_span, rows))
    )
    with meter.keeping(finished):
        for p in meter.each(across, "columns"):
            map_ = plane.map.at({plane.across: QQ.to_sympy(p)})
            column = [_at(line_of(map_, {plane.along: QQ.to_sympy(q)}), meter) for q in along]
            if meter.stopped:  # in this column, which may be incomplete
                raise BudgetError(meter.stopped)
            finished.append(column)
            if progress is not None:
                progress(len(finished))
    finished += [[_OPEN] * rows] * (columns - len(finished))
    periods, bands, entropy, open_ = (
        np.array([[point[k] for point in column] for column in finished]).T for k in range(4)
    )
    return PlaneRaster(
        across=across,
        along=along,
        periods=periods,
        bands=bands,
        entropy=entropy,
        open=open_,
        left_out=meter.left_out,
    )


_Point = tuple[int, int, float, bool]  # shortest period, bands, entropy, whether it is open
_OPEN: _Point = (0, 0, 0.0, True)


def _at(line: MapLine, meter: Meter) -> _Point:
    found = attractors_of(line, meter)
    return (
        min((len(cycle.points) for cycle in found.cycles), default=0),
        sum(map(len, found.bands)),
        entropy_of(line, found, (ORDER,), meter).low,
        bool(found.open),
    )


def arc_arrays(arc: PlaneArc, step: float) -> tuple[FloatArray, FloatArray]:
    """An arc as arrays of both parameters, in steps of about ``step`` across."""
    ends = np.array([[_float(value) for value in node] for node in arc.ends])
    if arc.root is None or arc.column is None:
        return ends[:, 0], ends[:, 1]
    low, high = arc.ends[0][0], arc.ends[1][0]
    count = int((ends[1, 0] - ends[0, 0]) / step)
    inner = equally_spaced(low, high, count) if count > 0 else []
    across = np.array([ends[0, 0], *map(to_float, inner), ends[1, 0]])
    return across, np.array([ends[0, 1], *root_array(arc.root, arc.column, inner), ends[1, 1]])


def root_array(root: Root, column: Column, values: Sequence[Number]) -> FloatArray:
    """A root at some values of the parameter across; nan where it does not exist."""
    return np.array([_float(column.number(root, value)) for value in values])


def _float(value: Real | None) -> float:
    return np.nan if value is None else to_float(bounds(value)[0])
