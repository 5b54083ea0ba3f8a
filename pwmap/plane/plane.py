"""The plane of two parameters: cells, bifurcation curves, points where they meet, and regions.

In a region cycles of the same periods attract; its borders are expressions.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path
from typing import Any

import sympy

from pwmap.algebra.arguments import explained, shown
from pwmap.algebra.exact import Number
from pwmap.algebra.terms import own_name
from pwmap.algebra.texts import printable
from pwmap.diagrams.encoding import from_plain, to_plain
from pwmap.diagrams.frames import DataFrame, dataframe
from pwmap.diagrams.saved import read_record, write_record
from pwmap.diagrams.shown import counted
from pwmap.longrun.dynamics import Dynamics, dynamics
from pwmap.maps.cylinders import StudiedIterate
from pwmap.maps.decided import Chain, ColumnCell, SymbolicCell
from pwmap.maps.piecewise_linear import PiecewiseLinearMap
from pwmap.maps.reading import Definition
from pwmap.maps.words import (
    CriticalOrbit,
    MultiplierSign,
    Offset,
    Orbits,
    SignOracle,
    first_rotation,
)
from pwmap.parameters.cells import ParameterCell, check_parameters
from pwmap.plane.curves import CodimensionTwo, PlaneCurve, curve_columns, point_columns
from pwmap.plane.strips import Strip

NAME, VERSION = "plane", 1  # of its files; raise the version if older code would misread them


Studied = tuple[Chain, StudiedIterate]  # an iterate, and what was found of it
Sign = tuple[CriticalOrbit | MultiplierSign | Offset, int]  # of a decision


@printable
@dataclass(frozen=True, slots=True, kw_only=True)
class PlaneRegion:
    """A part of a :func:`pwmap.parameter_plane` in which cycles of the same periods attract.

    ``across`` has the exact ends of the first parameter, ``along`` the borders of the second as
    expressions in the first; borders do not belong to it. ``periods`` are those of attracting
    cycles, among the orders of the plane, ``words`` the alphabetically first of their rotations.
    """

    across: tuple[sympy.Expr, sympy.Expr]
    along: tuple[sympy.Expr, sympy.Expr]
    periods: tuple[int, ...]
    words: tuple[str, ...]


def regions_of(strips: Sequence[Strip]) -> Iterator[PlaneRegion]:
    """All regions, from left to right and upwards; equal ones of neighbouring strips are joined."""
    growing: list[PlaneRegion] = []
    for strip in strips:
        beside, growing = growing, []
        for region in _of_strip(strip):
            same = [
                each
                for each in beside
                if each.across[1] == region.across[0]
                and replace(each, across=region.across) == region
            ]
            growing += [replace(each, across=(each.across[0], region.across[1])) for each in same]
            growing += [] if same else [region]
            beside = [each for each in beside if each not in same]
        yield from beside
    yield from growing


def attracting(cell: ParameterCell, orders: Sequence[int]) -> dict[str, int]:
    """The words of the cycles of some orders that attract in a cell, with their periods."""
    points = (p for order in orders for p in cell.map.iterate(order).fixed_points() if p.stable)
    found = {first_rotation(point.word[: point.period]): point.period for point in points}
    return dict(sorted(found.items()))


def _of_strip(strip: Strip) -> Iterator[PlaneRegion]:
    """The regions of a strip upwards; cells between which nothing changes are joined."""
    rows = [(cell, attracting(cell, strip.cells.orders)) for cell in strip.cells]
    for periods, group in groupby(rows, key=lambda row: tuple(sorted({*row[1].values()}))):
        opened = [(cell, words) for cell, words in group if not cell.is_edge]
        if opened:
            yield PlaneRegion(
                across=(strip.lower, strip.upper),
                along=(opened[0][0].lower, opened[-1][0].upper),
                periods=periods,
                words=tuple(sorted({word for _, words in opened for word in words})),
            )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ParameterPlane:
    """A rectangle of two parameters, cut by :func:`pwmap.parameter_plane`.

    ``across`` is the parameter that is cut into strips, ``along`` the one along each strip;
    ``across_span`` and ``along_span`` are exact rationals. ``strips`` are listed from left to
    right; the value between two, at which edges meet, is in neither. ``curves`` are bifurcations of
    cycles of the orders, ``points`` where these meet or end. ``left_out`` is a sentence on the part
    of the rectangle that was not finished, empty if there is none.
    """

    map: PiecewiseLinearMap
    across: sympy.Symbol
    along: sympy.Symbol
    across_span: tuple[Number, Number]
    along_span: tuple[Number, Number]
    strips: tuple[Strip, ...]
    curves: tuple[PlaneCurve, ...]
    points: tuple[CodimensionTwo, ...]
    left_out: str = ""

    def __repr__(self) -> str:
        spans = {self.across: self.across_span, self.along: self.along_span}
        places = ", ".join(f"{name} in [{low}, {high}]" for name, (low, high) in spans.items())
        parts = {"curve": self.curves, "point": self.points, "strip": self.strips}
        sizes = ", ".join(counted(len(found), noun) for noun, found in parts.items())
        rest = f"; {self.left_out}" if self.left_out else ""
        return f"ParameterPlane({places}: {sizes}{rest})"

    @explained()
    def at(self, across: object, along: object) -> Dynamics:
        """The long run at exact values ``across`` and ``along``; see :func:`pwmap.dynamics`."""
        return dynamics(self.map, {self.across: across, self.along: along})

    def regions(self, period: int | None = None) -> tuple[PlaneRegion, ...]:
        """The parts of the plane in which cycles of the same periods attract, with exact borders.

        They are sorted by their right ends and upwards: all, or those in which a cycle of one
        ``period`` attracts. ValueError if that is not among the orders.
        """
        orders = sorted({order for strip in self.strips for order in strip.cells.orders})
        if period is not None and period not in orders:
            listed = ", ".join(map(str, orders)) or "none"
            raise ValueError(f"period must be one of the orders {listed}, got {shown(period)}")
        return tuple(
            region
            for region in regions_of(self.strips)
            if period is None or period in region.periods
        )

    def curve(self, curve_id: str) -> PlaneCurve:
        """The curve with an id, such as ``"BC1"``; KeyError if there is none."""
        found = next((curve for curve in self.curves if curve.id == curve_id), None)
        if found is None:
            raise KeyError(f"there is no curve {curve_id!r}")
        return found

    def save(self, path: str | Path) -> Path:
        """Write JSON for :func:`pwmap.plane.load_plane`, with ``.gz`` compressed."""
        return write_record(path, _to_save(self), NAME, VERSION, sealed=True)

    def to_dataframe(self) -> DataFrame:
        """The curves as rows of a pandas DataFrame; ImportError without pandas.

        The columns are ``id``, ``kind``, ``note``, ``words`` (separated by blanks), ``polynomial``
        (of sympy), ``from`` and ``to`` (names of points).
        """
        return dataframe(curve_columns(self.curves))

    def points_to_dataframe(self) -> DataFrame:
        """The points of codimension two as rows of a pandas DataFrame; ImportError without pandas.

        The columns are ``id`` and ``kind``, both parameters by name (doubles) and by name with
        ``_exact`` (of sympy), and ``curves`` (separated by blanks).
        """
        return dataframe(point_columns(self.points, (self.across, self.along)))


def load_plane(path: str | Path) -> ParameterPlane:
    """Read a plane that :meth:`ParameterPlane.save` wrote.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    ParameterPlane
        With the same exact values.

    Raises
    ------
    ValueError, FileNotFoundError
        If it is no saved plane, was changed, is of a newer version, or not there.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, parameter_plane
    >>> from pwmap.plane import load_plane
    >>> map_ = PiecewiseLinearMap.from_sympy("a*x + b")
    >>> load_plane(parameter_plane(map_, "a", "b", (0, 2), (0, 1)).save("plane.json"))
    ParameterPlane(a in [0, 2], b in [0, 1]: 1 curve, 0 points, 2 strips)
    """
    plane: ParameterPlane = read_record(path, _loaded, NAME, VERSION, sealed=True)
    return plane


def _to_save(plane: ParameterPlane) -> dict[str, Any]:
    """A plane as JSON data, in which maps share their iterates and signs by number."""
    iterates, signs = dict[Studied, int](), dict[Sign, int]()  # numbered as they occur

    def of_map(map_: PiecewiseLinearMap) -> dict[str, Any]:
        cell = map_.scope
        if not isinstance(cell, SymbolicCell | ColumnCell):
            return {"chain": map_.chain}
        return {
            "chain": map_.chain,
            "cell": cell,
            "iterates": [iterates.setdefault(i, len(iterates)) for i in map_.iterates.items()],
            "signs": [signs.setdefault(s, len(signs)) for s in map_.oracle.signs.items()],
        }

    whole: dict[str, Any] = to_plain(plane, {PiecewiseLinearMap: of_map})
    shared = {"definition": plane.map.definition, "iterates": [*iterates], "signs": [*signs]}
    whole |= to_plain(shared)
    return whole


def _loaded(data: dict[str, Any]) -> ParameterPlane:
    """A plane from data of :func:`_to_save`."""
    kinds = {"definition": Definition, "iterates": tuple[Studied, ...], "signs": tuple[Sign, ...]}
    definition, iterates, signs = (from_plain(data[name], kind) for name, kind in kinds.items())
    orbits = Orbits(definition.table)  # all cells share it

    def of_map(saved: dict[str, Any]) -> PiecewiseLinearMap:
        chain = from_plain(saved["chain"], Chain)
        if "cell" not in saved:  # its signs follow from the assumptions
            return PiecewiseLinearMap.of(definition, chain)
        cell = from_plain(saved["cell"], SymbolicCell | ColumnCell)
        known = dict(iterates[number] for number in saved["iterates"])
        decided = dict(signs[number] for number in saved["signs"])
        oracle = SignOracle(orbits, cell.sign, decided)
        return PiecewiseLinearMap.of(definition, chain, cell, oracle, known)

    rest = {name: each for name, each in data.items() if name not in kinds}
    plane: ParameterPlane = from_plain(rest, ParameterPlane, {PiecewiseLinearMap: of_map})
    return plane


def checked_axes(
    map_: PiecewiseLinearMap, across: object, along: object
) -> tuple[sympy.Symbol, sympy.Symbol]:
    """Both parameters of a map, from their names; ValueError unless it has just these two."""
    across, along = (str(own_name(name, map_.parameters)) for name in (across, along))
    names = {str(symbol): symbol for symbol in map_.parameters}
    if across == along:
        raise ValueError(f"expected two different parameters, got {across} twice")
    check_parameters(map_, f"{across} and {along}", across, along)
    return names[across], names[along]
