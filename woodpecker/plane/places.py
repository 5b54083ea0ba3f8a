"""Orbits at two parameters, and Newton's method for them.

A *place* is an orbit seen along each of two parameters: the same points and the same values twice,
with the derivatives in one parameter and in the other. So all that is known of orbits over one
parameter holds, and the equations of a place are theirs: a condition on an orbit is one on a place,
its derivatives those along the first parameter and one more along the second. Two conditions make
places a curve.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.piecewise.branch_points import Multiplier
from woodpecker.piecewise.newton import newton
from woodpecker.piecewise.orbits import SPACING, Closed, Condition, Margin, Orbit, orbit_of
from woodpecker.piecewise.pieces import Piece, PiecewiseMap
from woodpecker.piecewise.settings import Settings
from woodpecker.plane.families import Family, Pair


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """A family of maps, with how far and how finely to look over each of its parameters."""

    family: Family
    settings: tuple[Settings, Settings]

    @property
    def first(self) -> Settings:
        """Those over the first parameter; both have the same window and the same tolerances."""
        return self.settings[0]

    def scales(self, n: int) -> Floats:
        """Units (n + 2,) of the unknowns of a place: its n points and both parameters."""
        return np.array([self.first.x_scale] * n + [each.p_scale for each in self.settings])

    def map(self, values: Pair, axis: int = 0) -> PiecewiseMap:
        """The map over one of the parameters, the other one held."""
        return self.family.over(axis, values)

    def place(self, pieces: Sequence[Piece], x: Floats, values: Pair) -> Place:
        """The images of points under given pieces."""
        views = []
        for axis in (0, 1):
            map_ = self.map(values, axis)
            own = [self.family.carried(piece, map_) for piece in pieces]
            views.append(orbit_of(own, x, values[axis]))
            pieces = views[-1].pieces  # they remember where they were met
        return Place((views[0], views[1]))

    def moved(self, place: Place, by: Floats) -> Place:
        """A place shifted, with the same pieces."""
        to = place.point + by
        return self.place(place.orbit.pieces, to[:-2], (float(to[-2]), float(to[-1])))


@dataclass(frozen=True, slots=True, eq=False)
class Place:
    """An orbit at two parameters, seen along each of them."""

    views: tuple[Orbit, Orbit]

    def __len__(self) -> int:
        return len(self.orbit)

    @property
    def orbit(self) -> Orbit:
        """As seen along the first parameter."""
        return self.views[0]

    @property
    def values(self) -> Pair:
        """Both parameters."""
        return self.views[0].p, self.views[1].p

    @property
    def point(self) -> Floats:
        """The unknowns (n + 2,): the points of the orbit, and both parameters."""
        return np.array([*self.orbit.x.tolist(), *self.values])

    @property
    def defined(self) -> bool:
        """Whether every piece has a value."""
        return all(view.defined for view in self.views)

    def gradient(self, index: int, code: int) -> Floats:
        """Derivatives (3,) of a margin of one point in it and in both parameters."""
        one, other = (view.images[index].gradient(code) for view in self.views)
        return np.array([one[0], one[1], other[1]])

    def gradients(self, index: int) -> Floats:
        """The same (m, 3) of all margins of one point; nan of one that a view does not have.

        What rounding makes of it decides whether a view has a margin that begins right there.
        """
        one, other = (view.images[index] for view in self.views)
        if np.array_equal(one.causes, other.causes):
            return np.column_stack([one.gradients, other.gradients[:, 1]])
        rates = [other.gradient(code)[1] for code in one.causes.tolist()]
        return np.column_stack([one.gradients, rates])


class Equation(Protocol):
    """A condition on places."""

    def residual(self, place: Place) -> float:
        """What is zero if it holds."""

    def row(self, place: Place) -> Floats:
        """Derivatives (n + 2,) in the unknowns."""


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """A condition on an orbit over one parameter, as each of the views has it."""

    conditions: tuple[Condition, Condition]

    def residual(self, place: Place) -> float:
        """What is zero if it holds."""
        return self.conditions[0].residual(place.orbit)

    def row(self, place: Place) -> Floats:
        """Derivatives (n + 2,)."""
        one, other = (
            condition.row(view)
            for condition, view in zip(self.conditions, place.views, strict=True)
        )
        return np.append(one, other[-1])


@dataclass(frozen=True, slots=True, eq=False)
class Along:
    """A distance from a base along a direction, in scaled unknowns."""

    base: Floats
    direction: Floats
    distance: float
    scale: Floats

    def residual(self, place: Place) -> float:
        """The projection less the distance."""
        return float(self.direction @ ((place.point - self.base) / self.scale)) - self.distance

    def row(self, place: Place) -> Floats:
        """The direction."""
        return self.direction / self.scale


@dataclass(frozen=True, slots=True)
class Unknown:
    """One of the unknowns has a value: a point, or (index -2 and -1) a parameter."""

    index: int
    value: float

    def residual(self, place: Place) -> float:
        """The unknown less its value."""
        return float(place.point[self.index]) - self.value

    def row(self, place: Place) -> Floats:
        """A unit vector."""
        row = np.zeros(len(place) + 2)
        row[self.index] = 1.0
        return row


@dataclass(frozen=True, slots=True)
class Locus:
    """What makes places a curve: the orbit is a cycle, and a margin or its multiplier has a value.

    Attributes
    ----------
    held
        The margin that vanishes, or the value of the multiplier; or which point lies where, on an
        end of the window.
    """

    held: Margin | Unknown | float

    @property
    def border(self) -> Margin | None:
        """The margin that vanishes, if one does."""
        return self.held if isinstance(self.held, Margin) else None

    def equations(self, plane: Plane) -> list[Equation]:
        """Two of them."""
        closed = Closed()
        return [Seen((closed, closed)), held(self.held, plane)]


def held(what: Margin | Unknown | float, plane: Plane) -> Equation:
    """A margin vanishes, a point lies where it should, or the multiplier has a value."""
    if isinstance(what, Unknown):
        return what
    if isinstance(what, Margin):
        return Seen((what, what))
    one, other = (Multiplier(what, each, each.nearest) for each in plane.settings)
    return Seen((one, other))


@dataclass(frozen=True, slots=True, eq=False)
class Solved:
    """What Newton's method came to: its last place, and whether that solves the equations."""

    place: Place
    converged: bool


def solve(
    plane: Plane, start: Place, equations: Sequence[Equation], *, contracts: bool = False,
    anchor: Place | None = None,
) -> Solved:  # fmt: skip
    """Newton's method for a place with the pieces of ``start`` that obeys three equations.

    Every piece remembers the times of the return where it was met last. Beyond a border next to
    which two of them come together the next ones may be the others: with an ``anchor`` all places
    are met from there.
    """
    scale = plane.scales(len(start))

    def shifted(place: Place, move: Sequence[float]) -> Place:
        by = np.array(move) * scale
        if anchor is None:
            return plane.moved(place, by)
        return plane.moved(anchor, place.point + by - anchor.point)

    place, converged, _ = newton(
        start,
        lambda place: _step(place, equations, scale),
        shifted,
        lambda place: _is_rounded(place, equations, plane.first),
        plane.first,
        contracts=contracts,
    )
    return Solved(place, converged)


def _step(place: Place, equations: Sequence[Equation], scale: Floats) -> list[float]:
    matrix, right = _rows(place, equations) * scale, _residuals(place, equations)
    size = np.abs(matrix).sum(axis=1)
    if not (np.isfinite(size).all() and (size > 0.0).all()):
        return [float("nan")]
    try:
        found: list[float] = np.linalg.solve(matrix / size[:, None], -right / size).tolist()
    except np.linalg.LinAlgError:
        return [float("nan")]
    return found


def _rows(place: Place, equations: Sequence[Equation]) -> Floats:
    """Derivatives (n - 1 + m, n + 2) of all equations; m are given."""
    n = len(place)
    rows = np.zeros((n - 1 + len(equations), n + 2))
    for i, (one, other) in enumerate(zip(*(view.images[:-1] for view in place.views), strict=True)):
        rows[i, [i, i + 1]] = one.slope, -1.0
        rows[i, n:] = one.d_parameter, other.d_parameter
    for k, equation in enumerate(equations):
        rows[n - 1 + k] = equation.row(place)
    return rows


def _residuals(place: Place, equations: Sequence[Equation]) -> Floats:
    ahead = zip(place.orbit.images[:-1], place.orbit.x[1:].tolist(), strict=True)
    chain = [image.value - x for image, x in ahead]
    return np.array([*chain, *(equation.residual(place) for equation in equations)])


def _is_rounded(place: Place, equations: Sequence[Equation], settings: Settings) -> bool:
    """Whether nothing is left of the residuals but what rounding of the unknowns makes of them."""
    size = np.abs(_rows(place, equations)) @ np.maximum(np.abs(place.point), 1.0)
    least = settings.numerics.noise * SPACING * size
    return bool((np.abs(_residuals(place, equations)) <= least).all())


def tangent(plane: Plane, place: Place, locus: Locus) -> Floats:
    """Unit tangent (n + 2,), in scaled unknowns, of the curve through a place; nan if none.

    The determinant of the equations with the tangent as their last row is positive, so it points
    the same way all along a curve.
    """
    rows = _rows(place, locus.equations(plane)) * plane.scales(len(place))
    size = np.abs(rows).sum(axis=1)
    if not (np.isfinite(size).all() and (size > 0.0).all()):
        return np.full(len(place) + 2, np.nan)
    direction: Floats = np.linalg.svd(rows / size[:, None])[2][-1]
    sign, _ = np.linalg.slogdet(np.vstack([rows / size[:, None], direction]))
    return direction if sign >= 0.0 else -direction


def precision(plane: Plane, place: Place, equations: Sequence[Equation]) -> Pair:
    """How far rounding of a map moves the two parameters of a place that obeys three equations."""
    scale, n = plane.scales(len(place)), len(place)
    matrix = _rows(place, equations) * scale
    blur = plane.first.numerics.blur
    noise = blur * (np.abs(matrix) @ np.abs(place.point / scale))
    noise[:n] += blur * plane.first.x_scale * np.abs(place.orbit.x)
    try:
        back = np.asarray(np.linalg.inv(matrix)[-2:], dtype=float)
    except np.linalg.LinAlgError:
        return float("inf"), float("inf")
    one, other = (np.abs(back) @ noise * scale[-2:]).tolist()
    return one, other


def replaced(plane: Plane, place: Place, index: int, piece: Piece) -> Place:
    """A place with another piece at one of its points."""
    pieces = [*place.orbit.pieces]
    pieces[index] = piece
    return plane.place(pieces, place.orbit.x, place.values)
