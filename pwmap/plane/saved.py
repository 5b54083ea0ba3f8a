"""A plane as a record for a file: its maps share one definition, and what was found of iterates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import sympy

from pwmap.algebra.exact import Number
from pwmap.algebra.rootfunctions import Column, Root
from pwmap.maps.cylinders import StudiedIterate
from pwmap.maps.decided import Chain, ColumnCell, SymbolicCell
from pwmap.maps.piecewise_linear import PiecewiseLinearMap
from pwmap.maps.reading import Definition
from pwmap.maps.words import CriticalOrbit, MultiplierSign, Offset, Orbits, SignOracle
from pwmap.parameters.cells import ParameterCell, ParameterCells
from pwmap.plane.network import CodimensionTwo, PlaneCurve
from pwmap.plane.strips import PlaneEvent, Strip

NAME, VERSION = "plane", 1  # of its files; a change that older code would misread raises it


@dataclass(frozen=True, slots=True, kw_only=True)
class SavedMap:
    """A map of a cell, or one without a cell; its iterates and signs by their numbers."""

    chain: Chain
    cell: SymbolicCell | ColumnCell | None
    iterates: tuple[int, ...]
    signs: tuple[int, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class SavedCell:
    """A cell, or an edge, of a strip."""

    lower: sympy.Expr
    upper: sympy.Expr
    map: SavedMap


@dataclass(frozen=True, slots=True, kw_only=True)
class SavedStrip:
    """A strip with its cells."""

    column: Column
    orders: tuple[int, ...]
    given: tuple[sympy.Basic, ...]
    cells: tuple[SavedCell, ...]
    borders: tuple[Root, ...]
    marks: tuple[tuple[Root, PlaneEvent], ...]
    upright: tuple[tuple[int, ...], ...]


Studied = tuple[Chain, StudiedIterate]  # an iterate, and what was found of it
Sign = tuple[CriticalOrbit | MultiplierSign | Offset, int]  # of a decision


@dataclass(frozen=True, slots=True, kw_only=True)
class SavedPlane:
    """A plane with all iterates and signs that occur in its cells, each once."""

    definition: Definition
    iterates: tuple[Studied, ...]
    signs: tuple[Sign, ...]
    map: SavedMap
    across: sympy.Symbol
    along: sympy.Symbol
    across_span: tuple[Number, Number]
    along_span: tuple[Number, Number]
    strips: tuple[SavedStrip, ...]
    curves: tuple[PlaneCurve, ...]
    points: tuple[CodimensionTwo, ...]
    left_out: str

    def whole_map(self) -> PiecewiseLinearMap:
        """The map of the plane."""
        return self._map(self.map, Orbits(self.definition.table))

    def whole_strips(self) -> tuple[Strip, ...]:
        """The strips of the plane."""
        return tuple(map(self._strip, self.strips))

    def _strip(self, saved: SavedStrip) -> Strip:
        orbits = Orbits(self.definition.table)  # the cells of a strip share it
        cells = tuple(
            ParameterCell(lower=each.lower, upper=each.upper, map=self._map(each.map, orbits))
            for each in saved.cells
        )
        return Strip(
            column=saved.column,
            cells=ParameterCells(
                parameter=self.along, orders=saved.orders, cells=cells, given=saved.given
            ),
            borders=saved.borders,
            marks=saved.marks,
            upright=saved.upright,
        )

    def _map(self, saved: SavedMap, orbits: Orbits) -> PiecewiseLinearMap:
        if saved.cell is None:  # its signs follow from what is assumed
            return PiecewiseLinearMap.of(self.definition, saved.chain)
        iterates, signs = map(self.iterates.__getitem__, saved.iterates), saved.signs
        oracle = SignOracle(orbits, saved.cell.sign, dict(map(self.signs.__getitem__, signs)))
        return PiecewiseLinearMap.of(
            self.definition, saved.chain, saved.cell, oracle, dict(iterates)
        )


@dataclass(frozen=True, slots=True)
class Shared:
    """Numbers of iterates and of signs, in the order in which they come first."""

    iterates: dict[Studied, int] = field(default_factory=dict)
    signs: dict[Sign, int] = field(default_factory=dict)

    def map(self, map_: PiecewiseLinearMap) -> SavedMap:
        """What is kept of a map."""
        cell = map_.scope
        if not isinstance(cell, SymbolicCell | ColumnCell):
            return SavedMap(chain=map_.chain, cell=None, iterates=(), signs=())
        iterates, signs = self.iterates, self.signs
        return SavedMap(
            chain=map_.chain,
            cell=cell,
            iterates=tuple(iterates.setdefault(i, len(iterates)) for i in map_.iterates.items()),
            signs=tuple(signs.setdefault(s, len(signs)) for s in map_.oracle.signs.items()),
        )

    def strip(self, strip: Strip) -> SavedStrip:
        """What is kept of a strip."""
        return SavedStrip(
            column=strip.column,
            orders=strip.cells.orders,
            given=strip.cells.given,
            cells=tuple(
                SavedCell(lower=each.lower, upper=each.upper, map=self.map(each.map))
                for each in strip.cells
            ),
            borders=strip.borders,
            marks=strip.marks,
            upright=strip.upright,
        )

    def plane(
        self, map_: PiecewiseLinearMap, strips: tuple[Strip, ...], rest: Mapping[str, object]
    ) -> SavedPlane:
        """What is kept of a plane; the rest as it is."""
        parts = {"map": self.map(map_), "strips": tuple(map(self.strip, strips))}
        known = {"iterates": tuple(self.iterates), "signs": tuple(self.signs)}
        kept: dict[str, object] = {**parts, **known, **rest}
        return SavedPlane(definition=map_.definition, **kept)  # type: ignore[arg-type]
