"""Orbits of a piecewise-smooth map, and one Newton method for all that is asked of them.

An orbit is x_0 .. x_(n-1) at a parameter p, each point with its piece, and obeys
P_i(x_i, p) = x_(i+1). These are n - 1 equations for n + 1 unknowns; *conditions* add the others. A
cycle closes; a border orbit ends where a margin of its last piece vanishes; with one of the two an
orbit belongs to a branch, with both it is a border collision, and a distance along the branch, a
parameter or a coordinate picks a point of it.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import numpy as np
from scipy.linalg.lapack import dgesv

from pwmap.diagrams.shown import brief
from woodpecker.base.arrays import Floats
from woodpecker.base.settings import Settings
from woodpecker.maps.pieces import Image, Piece
from woodpecker.slices.newton import ROUNDINGS, newton

SPACING = 2.0**-52  # of doubles at 1
# In x, a part of the window: points of a cycle this close are one. A doubled cycle leaves its flip
# like a square root, and the parameter there is good to rounding.
ONE_POINT = 1e-5
# Part of its distance that a Newton step leaves at most if it leads to an orbit: from a point of
# the same branch it leaves next to nothing, from elsewhere most.
LEFT_BY_STEP = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class Orbit:
    """Points of a map at one parameter, each with its image under a piece.

    Attributes
    ----------
    x
        (n,) points.
    p
        The parameter.
    images
        What the pieces make of them, n of them.

    Examples
    --------
    >>> from sympy import Piecewise, symbols
    >>> from woodpecker import Settings, cycle_near, from_sympy
    >>> x, p = symbols("x p")
    >>> formula = Piecewise((x/2 + p, x < 0), (x/3 + p - 1, True))
    >>> lines = from_sympy(formula, x, p, words=["L", "R"])
    >>> orbit = cycle_near(lines, -0.9, -0.5, Settings(span=(-1, 2), window=(-3, 3)))
    >>> type(orbit).__name__, orbit.x.tolist(), orbit.p, orbit.words
    ('Orbit', [-1.0], -0.5, ('L',))
    """

    x: Floats
    p: float
    images: tuple[Image, ...]

    def __len__(self) -> int:
        return len(self.images)

    def __repr__(self) -> str:
        """Its points and words."""
        x = ", ".join(f"{each:.10g}" for each in self.x)
        words = brief(" | ".join(self.words))
        return f"Orbit(p={self.p:.10g}, x={x}, multiplier={self.multiplier:.6g}, {words!r})"

    @property
    def pieces(self) -> tuple[Piece, ...]:
        """The piece of each point, ready to be continued from here."""
        return tuple(image.piece for image in self.images)

    @property
    def words(self) -> tuple[str, ...]:
        """The names of the pieces."""
        return tuple(image.piece.word for image in self.images)

    @property
    def keys(self) -> tuple[Hashable, ...]:
        """What tells the pieces from others."""
        return tuple(image.piece.key for image in self.images)

    @property
    def multiplier(self) -> float:
        """Product of the slopes."""
        product = 1.0
        for image in self.images:
            product *= image.slope
        return product

    @property
    def defined(self) -> bool:
        """Whether every piece has a value."""
        return not any(image.reason for image in self.images)

    @property
    def point(self) -> Floats:
        """The unknowns (n + 1,): x, and p at last."""
        unknowns = np.empty(len(self.x) + 1)
        unknowns[:-1], unknowns[-1] = self.x, self.p
        return unknowns

    def head(self, n: int) -> Orbit:
        """Its first n points.

        Parameters
        ----------
        n
            How many points.

        Returns
        -------
        Orbit
            A shorter orbit.
        """
        return Orbit(self.x[:n], self.p, self.images[:n])

    def rotated(self, first: int) -> Orbit:
        """The same cycle from another of its points.

        Parameters
        ----------
        first
            Which point becomes the first, from 0 on.

        Returns
        -------
        Orbit
            Of as many points.
        """
        return Orbit(np.roll(self.x, -first), self.p, (*self.images[first:], *self.images[:first]))


def orbit_of(pieces: Sequence[Piece], x: Floats, p: float) -> Orbit:
    """The images of points under given pieces."""
    images = tuple(piece.at(float(value), p) for piece, value in zip(pieces, x, strict=True))
    return Orbit(np.asarray(x, dtype=float), float(p), images)


def minimal_period(orbit: Orbit, settings: Settings) -> int:
    """The smallest shift that maps a cycle to itself."""
    same = ONE_POINT * settings.x_scale
    return next(
        d for d in shifts(len(orbit)) if np.abs(np.roll(orbit.x, -d) - orbit.x).max() <= same
    )


@lru_cache
def shifts(n: int) -> tuple[int, ...]:
    """The periods that a cycle of n points may have: the divisors of n, ascending."""
    return tuple(d for d in range(1, n + 1) if n % d == 0)


class Condition(Protocol):
    """An equation that an orbit is to obey."""

    def residual(self, orbit: Orbit) -> float:
        """What is zero if it does."""

    def row(self, orbit: Orbit) -> Floats:
        """Derivatives (n + 1,) of the residual in x and p."""


@dataclass(frozen=True, slots=True)
class Closed:
    """The last image is the first point: a cycle."""

    def residual(self, orbit: Orbit) -> float:
        """P(x_(n-1)) - x_0."""
        return orbit.images[-1].value - float(orbit.x[0])

    def row(self, orbit: Orbit) -> Floats:
        """Its derivatives."""
        row = np.zeros(len(orbit) + 1)
        row[-2], row[-1] = orbit.images[-1].slope, orbit.images[-1].d_parameter
        row[0] -= 1.0
        return row


@dataclass(frozen=True, slots=True)
class Margin:
    """A margin of the piece of one point has a value; zero if that point lies on a border."""

    index: int
    code: int
    value: float = 0.0

    def residual(self, orbit: Orbit) -> float:
        """The margin less its value; nan if the piece does not have this margin here."""
        return orbit.images[self.index].margin(self.code) - self.value

    def row(self, orbit: Orbit) -> Floats:
        """Its derivatives."""
        row = np.zeros(len(orbit) + 1)
        row[self.index], row[-1] = orbit.images[self.index].gradient(self.code)
        return row


@dataclass(frozen=True, slots=True, eq=False)
class OnBorder:
    """A point lies on a border of a piece that is not its own."""

    index: int
    code: int
    piece: Piece

    def residual(self, orbit: Orbit) -> float:
        """The margin of that piece."""
        return self._image(orbit).margin(self.code)

    def row(self, orbit: Orbit) -> Floats:
        """Its derivatives."""
        row = np.zeros(len(orbit) + 1)
        row[self.index], row[-1] = self._image(orbit).gradient(self.code)
        return row

    def _image(self, orbit: Orbit) -> Image:
        return self.piece.at(float(orbit.x[self.index]), orbit.p)


@dataclass(frozen=True, slots=True)
class Coordinate:
    """One of the unknowns has a value: a point of the orbit, or (index -1) the parameter."""

    index: int
    value: float

    def residual(self, orbit: Orbit) -> float:
        """The unknown less its value."""
        return float(orbit.p if self.index == -1 else orbit.x[self.index]) - self.value

    def row(self, orbit: Orbit) -> Floats:
        """A unit vector."""
        row = np.zeros(len(orbit) + 1)
        row[self.index] = 1.0
        return row


def scales(n: int, settings: Settings) -> Floats:
    """Units (n + 1,) of the unknowns of an orbit; not to be written to."""
    return _units(n, settings.x_scale, settings.p_scale)


@lru_cache
def _units(n: int, x_scale: float, p_scale: float) -> Floats:
    """The same: every step needs them."""
    units = np.full(n + 1, x_scale)
    units[-1] = p_scale
    units.flags.writeable = False
    return units


def jacobian(orbit: Orbit, conditions: Sequence[Condition], scale: Floats) -> Floats:
    """Derivatives (n - 1 + m, n + 1) of all equations in the scaled unknowns; m conditions."""
    return np.array(_rows(orbit, conditions, scale.tolist()))


def _rows(
    orbit: Orbit, conditions: Sequence[Condition], scale: Sequence[float]
) -> list[list[float]]:
    """The same as lists: they are so short that arrays would take longer."""
    n, rows = len(orbit), []
    for i, image in enumerate(orbit.images[:-1]):
        row = [0.0] * (n + 1)
        row[i], row[i + 1] = image.slope * scale[i], -scale[i + 1]
        row[n] = image.d_parameter * scale[n]
        rows.append(row)
    own = (condition.row(orbit).tolist() for condition in conditions)
    return [*rows, *([a * b for a, b in zip(row, scale, strict=True)] for row in own)]


def _sizes(rows: list[list[float]]) -> list[float]:
    """Sums of the absolute values of rows; nan or infinite if a number of the row is."""
    return [sum(map(abs, row)) for row in rows]


def _solvable(sizes: Sequence[float]) -> bool:
    return all(0.0 < size < math.inf for size in sizes)


def residuals(orbit: Orbit, conditions: Sequence[Condition]) -> Floats:
    """Residuals (n - 1 + m,) of all equations."""
    return np.array(_residuals(orbit, conditions))


def _residuals(orbit: Orbit, conditions: Sequence[Condition]) -> list[float]:
    ahead = zip(orbit.images[:-1], orbit.x[1:].tolist(), strict=True)
    chain = [image.value - x for image, x in ahead]
    return [*chain, *(condition.residual(orbit) for condition in conditions)]


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """What Newton's method came to.

    Attributes
    ----------
    orbit
        Its last iterate.
    converged
        Whether this solves the equations.
    steps
        How many steps were taken.
    """

    orbit: Orbit
    converged: bool
    steps: int


def solve(
    start: Orbit, conditions: Sequence[Condition], settings: Settings, *, contracts: bool = False
) -> Solution:
    """Newton's method for an orbit with the pieces of ``start`` that obeys two conditions.

    If the method ``contracts``, as it does near a solution, it is given up as soon as a step is
    much longer than the one before; see :func:`woodpecker.slices.newton.newton`.
    """
    scale = scales(len(start), settings).tolist()
    orbit, converged, steps = newton(
        start,
        lambda orbit: _scaled_step(orbit, conditions, scale),
        lambda orbit, move: _shifted(orbit, move, scale),
        lambda orbit: is_rounded(orbit, conditions),
        settings,
        contracts=contracts,
    )
    return Solution(orbit, converged, steps)


def is_rounded(orbit: Orbit, conditions: Sequence[Condition]) -> bool:
    """Whether nothing is left of the residuals but what rounding of the unknowns makes of them."""
    matrix = np.abs(jacobian(orbit, conditions, np.ones(len(orbit) + 1)))
    size = matrix @ np.maximum(np.abs(orbit.point), 1.0)
    least = ROUNDINGS * SPACING * size
    return bool((np.abs(residuals(orbit, conditions)) <= least).all())


def moved(orbit: Orbit, by: Floats) -> Orbit:
    """The points of an orbit shifted, with the same pieces."""
    return orbit_of(orbit.pieces, orbit.x + by[:-1], orbit.p + float(by[-1]))


def _shifted(orbit: Orbit, move: Sequence[float], scale: Sequence[float]) -> Orbit:
    """The same by a step in scaled unknowns."""
    to = [a + b * c for a, b, c in zip(orbit.point.tolist(), move, scale, strict=True)]
    return orbit_of(orbit.pieces, np.array(to[:-1]), to[-1])


def between(one: Orbit, other: Orbit, part: float) -> Orbit:
    """An orbit at a part of the straight way to another, with the pieces of the first."""
    return moved(one, part * (other.point - one.point))


def newton_step(orbit: Orbit, conditions: Sequence[Condition], settings: Settings) -> Floats:
    """Newton's step (n + 1,); nan if the equations are singular or not finite."""
    scale = scales(len(orbit), settings)
    return np.array(_scaled_step(orbit, conditions, scale.tolist())) * scale


def _scaled_step(
    orbit: Orbit, conditions: Sequence[Condition], scale: Sequence[float]
) -> list[float]:
    """The same in scaled unknowns; of one point by Cramer's rule: these are most of the work."""
    rows = _rows(orbit, conditions, scale)
    sizes, none = _sizes(rows), [math.nan] * len(scale)
    if not _solvable(sizes):
        return none
    right = [-off / size for off, size in zip(_residuals(orbit, conditions), sizes, strict=True)]
    matrix = [[each / size for each in row] for row, size in zip(rows, sizes, strict=True)]
    if len(rows) > 2:
        _, _, step, singular = dgesv(np.array(matrix), right)
        return none if singular else step.tolist()
    ((a, b), (c, d)), (first, second) = matrix, right
    determinant = a * d - b * c
    if determinant == 0.0:
        return none
    return [(first * d - b * second) / determinant, (a * second - first * c) / determinant]


def tangent(orbit: Orbit, closing: Condition, settings: Settings) -> Floats:
    """Unit tangent (n + 1,), in scaled unknowns, of the branch through an orbit; nan if none.

    Its sign makes the determinant of the equations bordered with it positive, so that neighbours
    point the same way, round folds too, unless a branch point lies between them.
    """
    rows = _rows(orbit, (closing,), scales(len(orbit), settings).tolist())
    sizes = _sizes(rows)
    if not _solvable(sizes):
        return np.full(len(orbit) + 1, np.nan)
    if len(rows) == 1:
        (a, b), length = rows[0], math.hypot(*rows[0])
        return np.array([-b / length, a / length])
    rows = [[each / size for each in row] for row, size in zip(rows, sizes, strict=True)]
    if len(rows) == 2:
        (a, b, c), (d, e, f) = rows
        across = b * f - c * e, c * d - a * f, a * e - b * d
        length = math.hypot(*across)
        return np.array(across) / length if length else np.full(3, np.nan)
    direction: Floats = np.linalg.svd(rows)[2][-1]
    turned = np.linalg.det(np.vstack([rows, direction])) < 0.0
    return -direction if turned else direction
