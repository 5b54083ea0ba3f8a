"""Problems (conditions and free unknowns), with one Newton method and one tangent for all."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.linalg.lapack import dgesv, dgetrs
from scipy.optimize import root

from woodpecker.base.arrays import STEP, Floats, Ints, norm
from woodpecker.engine.maps import SpaceImage
from woodpecker.engine.orbits import (
    Closed,
    Condition,
    Held,
    OnBorder,
    SpaceOrbit,
    placed_at,
    with_unknowns,
)

MERGED = 1e-9  # scaled: points of a cycle that are closer than this coincide
STEPS = 12  # iterations of Newton's method: it converges in four or five, or not at all
ROUNDED = 2.0**-46  # scaled: Newton steps shorter than this are rounding errors
SOLVED = 2.0**-52  # scaled: a Newton step predicted to be shorter is not worth an evaluation
SHARE = 16.0  # length of s that counts as 1: it weighs less in steps than the points do
# Relative to the terms of an equation: rounding error of a map, 16 spacings.
MAP_ROUNDING = 2.0**-48
HALVINGS = 6  # of a Newton step that leads to where a piece has no value
APART = 2.0**-42  # scaled: curves that miss each other by more than this do not cross
STEEP = 1e4  # steeper slopes are those of a root: at its border rounding leaves about 1e8
STALLED = 2.0**-33  # scaled: steps that stop shrinking below this are rounding errors of steep maps
# Largest part of its distance that one Newton step to an orbit may leave: from another point of
# the same branch it leaves almost nothing, from other branches most of it.
LEFT_BY_STEP = 0.5
# Largest residual of a branch point: a quadratic step from there is rounding.
BRANCH_POINT_RESIDUAL = 2.0**-22


@dataclass(frozen=True, slots=True)
class Problem:
    """The equations of an orbit, and the parameters that are unknowns."""

    conditions: tuple[Condition, ...]  # equations
    free: tuple[int, ...]  # which of the k parameters are unknowns
    x_scale: tuple[float, ...]  # lengths of the d coordinates that count as 1
    p_scale: tuple[float, ...]  # lengths of the k parameters that count as 1

    def free_columns(self, orbit: SpaceOrbit) -> tuple[slice | Ints, Floats]:
        """The columns of the free unknowns, and their lengths: points, free parameters, and s.

        In R^1 the share s is none of them: it follows from the points.
        """
        n, d = orbit.x.shape
        return _moving(n, self.free, orbit.outer is not None and d > 1, self.x_scale, self.p_scale)

    @property
    def lengths(self) -> Floats:
        """(d + k,) lengths of the coordinates and parameters that count as 1."""
        return np.array((*self.x_scale, *self.p_scale))

    def scale(self, orbit: SpaceOrbit) -> Floats:
        """The lengths of all unknowns of an orbit that count as 1."""
        return _scale(len(orbit.x), self.x_scale, self.p_scale)

    def steepest(self, image: SpaceImage) -> float:
        """The largest derivative of an image; in R^d, d > 1, in scaled coordinates."""
        if len(image.value) > 1:
            return self.steepest_scaled(image)
        return float(np.abs(image.jacobian).max())  # in R^1 a slope dx/dx has no unit

    def steepest_scaled(self, image: SpaceImage) -> float:
        """The largest derivative of an image, in scaled coordinates and parameters."""
        slopes = np.abs(image.jacobian) * self.lengths / np.array(self.x_scale)[:, None]
        return float(slopes.max())

    def with_(self, *conditions: Condition) -> Problem:
        """The problem with further conditions."""
        every = (*self.conditions, *conditions)
        return Problem(every, self.free, self.x_scale, self.p_scale)

    def residual(self, orbit: SpaceOrbit) -> Floats:
        """The residuals of all equations."""
        found = [each.residual(orbit) for each in self.conditions]
        return found[0] if len(found) == 1 else np.concatenate(found)

    def matrix(self, orbit: SpaceOrbit) -> Floats:
        """Derivatives of the residuals in the free unknowns, scaled."""
        blocks = [each.rows(orbit) for each in self.conditions]
        columns, lengths = self.free_columns(orbit)
        rows = blocks[0] if len(blocks) == 1 else np.concatenate(blocks)
        found: Floats = rows[:, columns] * lengths
        if any(_stays_on(each) for each in self.conditions):
            self._along_borders(found, [len(block) for block in blocks])
        return found

    def is_steep(self, orbit: SpaceOrbit) -> bool:
        """Whether a derivative of a residual is as large as beside a root singularity."""
        rows = np.concatenate([each.rows(orbit) for each in self.conditions])
        return _largest(rows.ravel()) > STEEP

    def _along_borders(self, rows: Floats, counts: list[int]) -> None:
        """Remove from steep rows their part across a border, where a root is infinitely steep."""
        if _largest(rows.ravel()) <= STEEP:
            return
        first = 0
        for condition, count in zip(self.conditions, counts, strict=True):
            if _stays_on(condition):
                with np.errstate(invalid="ignore"):  # nan, and no step, if the margin is too steep
                    normal = rows[first] / norm(rows[first])
                along = rows @ normal
                along[first] = 0.0
                steep = np.abs(along) > STEEP
                rows[steep] -= np.outer(along[steep], normal)
            first += count

    def stepped(self, orbit: SpaceOrbit, step: Floats) -> Floats:
        """All unknowns of an orbit after a step in the scaled free ones."""
        to, (columns, lengths) = orbit.unknowns.copy(), self.free_columns(orbit)
        to[columns] += step * lengths
        return to

    def moved(self, orbit: SpaceOrbit, step: Floats) -> SpaceOrbit:
        """The orbit after a step in the scaled free unknowns."""
        held = [each.image for each in self.conditions if isinstance(each, OnBorder)]
        return with_unknowns(orbit, self.stepped(orbit, step), held, along=len(self.free) > 1)

    def step_between(self, one: SpaceOrbit, other: SpaceOrbit) -> Floats:
        """The step in scaled free unknowns that leads from one orbit to another."""
        columns, lengths = self.free_columns(one)
        found: Floats = (other.unknowns - one.unknowns)[columns] / lengths
        return found

    def period(self, x: Floats, within: float) -> int:
        """The number of points after which a cycle (n, d) repeats, within a scaled distance."""
        n = len(x)
        divisors = (k for k in range(1, n) if n % k == 0)
        return next((k for k in divisors if self.same(x[k:], x[:-k], within)), n)

    def same(self, one: Floats, other: Floats, within: float) -> bool:
        """Whether points (..., d) are equal within a scaled distance."""
        return self.apart(one, other) <= within

    def apart(self, one: Floats, other: Floats) -> float:
        """The largest scaled distance of points (..., d) in any coordinate."""
        return float((np.abs(one - other) / self.x_scale).max())


def _stays_on(condition: Condition) -> bool:
    """Whether a condition keeps orbits exactly on a border, where root singularities lie."""
    return isinstance(condition, OnBorder) and not condition.value


@lru_cache
def _moving(
    n: int, free: tuple[int, ...], shares: bool, x_scale: tuple[float, ...],
    p_scale: tuple[float, ...],
) -> tuple[slice | Ints, Floats]:  # fmt: skip
    points, lengths = n * len(x_scale), _scale(n, x_scale, p_scale)
    found = [*range(points), *(points + k for k in free), *([len(lengths) - 1] if shares else [])]
    if found == list(range(len(found))):
        return slice(len(found)), lengths[: len(found)]
    columns = np.array(found, dtype=np.int64)
    for each in (columns, own := lengths[columns]):
        each.setflags(write=False)
    return columns, own


@lru_cache
def _scale(n: int, x_scale: tuple[float, ...], p_scale: tuple[float, ...]) -> Floats:
    scale = np.array([*x_scale * n, *p_scale, SHARE])
    scale.setflags(write=False)
    return scale


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """The last iterate of Newton's method, and whether it converged."""

    orbit: SpaceOrbit
    converged: bool  # whether the equations hold up to rounding


@dataclass(frozen=True, slots=True, eq=False)
class Across:
    """A distance from an orbit along a direction: the equation of pseudo-arclength continuation."""

    row: Floats  # (n d + k + 1,) derivatives of the distance in all unknowns
    start: Floats  # the unknowns of the orbit
    distance: float  # in scaled unknowns

    def residual(self, orbit: SpaceOrbit) -> Floats:
        """(1,) the distance minus its prescribed value."""
        return np.array([(orbit.unknowns - self.start) @ self.row - self.distance])

    def rows(self, orbit: SpaceOrbit) -> Floats:
        """(1, ...) the derivatives of the distance."""
        return self.row[None]


def across(problem: Problem, start: SpaceOrbit, direction: Floats, distance: float) -> Across:
    """The equation that puts an orbit at a distance from another along a direction, scaled."""
    unknowns, (columns, lengths) = start.unknowns, problem.free_columns(start)
    row = np.zeros(len(unknowns))
    row[columns] = direction / lengths
    return Across(row, unknowns, distance)


def solve(problem: Problem, start: SpaceOrbit) -> Solution:
    """Solve a problem by Newton's method from an orbit, with its pieces, in ``STEPS`` iterations.

    It stops where steps are rounding errors or, below ``STALLED``, no longer shrink, and has
    converged if the residuals, or the next step, are rounding errors too. It fails as soon as a
    longer step does not shrink. Steps to where a piece has no value are halved.
    """
    if not start.is_defined:
        return Solution(start, False)
    orbit, residual, before = start, problem.residual(start), math.inf
    columns, lengths = problem.free_columns(start)
    far = max(1.0, _largest(start.unknowns[columns] / lengths))
    for _ in range(STEPS):
        matrix = problem.matrix(orbit)
        factors, swaps, step, _ = dgesv(matrix, -residual)
        if 0.0 in factors.diagonal().tolist():  # singular, but a branch point may be a solution
            return Solution(orbit, _is_met(problem, orbit, matrix, residual))
        size = _largest(step)
        if not size < max(before, STALLED):
            return Solution(orbit, False)
        orbit, shortened = _damped_step(problem, orbit, step)
        if not orbit.is_defined:
            break
        residual = problem.residual(orbit)
        if shortened and (size > ROUNDED * far or problem.is_steep(orbit)):
            before = math.inf
            continue
        ahead = _largest(dgetrs(factors, swaps, residual)[0])
        stalled = before <= STALLED and size >= 0.5 * before
        if size <= ROUNDED * far or ahead <= SOLVED * far or stalled:
            solved = ahead <= ROUNDED or _is_met(problem, orbit, matrix, residual)
            return Solution(orbit, solved)
        before = size
    return Solution(orbit, False)


def _largest(values: Floats) -> float:
    """The largest absolute value of a few numbers; nan if one is."""
    sizes = [abs(each) for each in values.tolist()]
    return max(sizes) if not math.isnan(sum(sizes)) else math.nan


def newton_step(problem: Problem, orbit: SpaceOrbit) -> Floats:
    """One Newton step in scaled free unknowns; nan where the equations are singular."""
    factors, _, step, _ = dgesv(problem.matrix(orbit), -problem.residual(orbit))
    return step if factors.diagonal().all() else np.full(len(step), math.nan)


def leads(problem: Problem, x: Floats, orbit: SpaceOrbit, same: float) -> bool:
    """Whether one Newton step at fixed parameters leads from points (n, d) to an orbit.

    No step is needed if the points are within ``same``, scaled, of those of the orbit.
    """
    before = problem.apart(x, orbit.x)
    if before <= same:
        return True
    held = [Held(orbit.x.size + k, float(orbit.p[k])) for k in problem.free]
    step = newton_step(problem.with_(*held), placed_at(orbit, x, orbit.p))
    to = x + step[: x.size].reshape(x.shape) * problem.x_scale
    return problem.apart(to, orbit.x) <= LEFT_BY_STEP * before


def _is_met(problem: Problem, orbit: SpaceOrbit, matrix: Floats, residual: Floats) -> bool:
    """Whether the residuals at an orbit are rounding errors."""
    # The rounding error of a margin may exceed what its derivatives suggest, because those of
    # earlier events cancel in them: so `tied` decides whether it is zero.
    left, first = np.abs(residual) > _noise(problem, orbit, matrix), 0
    for condition in problem.conditions if left.any() else ():
        count = len(condition.residual(orbit))
        if isinstance(condition, Closed):  # with a multiplier near 1 its derivatives cancel
            terms = MAP_ROUNDING * np.abs(np.roll(orbit.x, -1, axis=0)).ravel()
            left[first : first + count] &= np.abs(residual[first : first + count]) > terms
        if isinstance(condition, OnBorder) and not condition.value:
            left[first] &= not condition.is_met(orbit)
        first += count
    return not left.any()


def _damped_step(problem: Problem, orbit: SpaceOrbit, step: Floats) -> tuple[SpaceOrbit, bool]:
    """The orbit after a Newton step, halved while a piece has no value there; whether it was."""
    borders = [each for each in problem.conditions if isinstance(each, OnBorder)]
    for halvings in range(HALVINGS):
        found = problem.moved(orbit, step * 0.5**halvings)
        if found.is_defined and all(each.is_near(found) for each in borders):
            for each in borders:
                found = each.moved_to_margin(found)
            break
    return found, halvings > 0


def _linear(matrix: Floats, right: Floats) -> tuple[Floats, float]:
    """The solution of linear equations and the determinant of the matrix; nan if one is."""
    factors, swaps, found, _ = dgesv(matrix, right)
    determinant = math.prod(factors.diagonal().tolist())
    swapped = sum(i != other for i, other in enumerate(swaps.tolist()))
    return found, -determinant if swapped % 2 else determinant


def tangent(
    problem: Problem, orbit: SpaceOrbit, along: Floats | None = None
) -> tuple[Floats, float]:
    """Unit tangent, in scaled free unknowns, of the curve through an orbit, and its determinant.

    The tangent points along ``along`` or, by default, makes the determinant positive; it is nan if
    it does not exist. The determinant is that of the matrix bordered with the tangent: along a
    curve it changes sign at simple branch points, but not at folds.
    """
    matrix = problem.matrix(orbit)
    if along is None and not np.isfinite(matrix).all():
        return np.full(matrix.shape[1], np.nan), np.nan
    way = np.linalg.svd(matrix)[2][-1] if along is None else along
    to = np.zeros(len(way))
    to[-1] = 1.0
    found, determinant = _linear(np.concatenate((matrix, way[None])), to)
    length = norm(found)
    if determinant == 0.0 or not math.isfinite(length):
        return np.full(len(way), np.nan), np.nan
    sign = -1.0 if along is None and determinant < 0.0 else 1.0
    return sign * found / length, sign * determinant * length


def directions(problem: Problem, orbit: SpaceOrbit) -> tuple[Floats, ...]:
    """Unit tangents, scaled, of the two curves through a branch point; empty if there are none."""
    # There the kernel of F' is a plane. With w orthogonal to the range of F', the tangents v in
    # this plane solve the quadratic form w F''(v, v) = 0, here with F'' by central differences.
    left, _, right = np.linalg.svd(problem.matrix(orbit))
    w, plane = left[:, -1], right[-2:]
    bends = []
    for way in plane:
        ahead, behind = (problem.matrix(problem.moved(orbit, h * way)) for h in (STEP, -STEP))
        bends.append(plane @ (w @ (ahead - behind)) / (2.0 * STEP))
    (a, b), (_, c) = bends
    square = b * b - a * c
    if not square > 0.0:
        return ()
    root = -(b + math.copysign(math.sqrt(square), b))
    found = [np.array(pair) @ plane for pair in ((root, a), (c, root))]
    return tuple(each / norm(each) for each in found)


def other_direction(problem: Problem, orbit: SpaceOrbit, along: Floats) -> Floats | None:
    """The unit tangent of the second curve through a branch point; None if there is none."""
    along = along / norm(along)
    return min(directions(problem, orbit), key=lambda way: abs(float(way @ along)), default=None)


def branch_point(problem: Problem, near: SpaceOrbit) -> SpaceOrbit | None:
    """The branch point near an orbit, up to rounding; None if there is none."""
    # F + m w = 0, F'^T w = 0, |w| = 1 are solved for the unknowns, w and m: a regular system at a
    # simple branch point, where m = 0.
    matrix = problem.matrix(near)
    columns = matrix.shape[1]

    def equations(at: Floats) -> Floats:
        orbit = problem.moved(near, at[:columns])
        w, m = at[columns:-1], at[-1]
        left = problem.matrix(orbit).T @ w
        return np.concatenate([problem.residual(orbit) + m * w, left, [w @ w - 1.0]])

    w = np.linalg.svd(matrix)[0][:, -1]
    found = root(equations, np.concatenate([np.zeros(columns), w, [0.0]]), options={"xtol": 1e-14})
    off = np.abs(equations(found.x)).max()
    if (
        off > BRANCH_POINT_RESIDUAL or abs(found.x[-1]) > APART
    ):  # the curves come close but do not cross
        return None
    return problem.moved(near, found.x[:columns])


def _noise(
    problem: Problem, orbit: SpaceOrbit, matrix: Floats, rounding: float = ROUNDED
) -> Floats:
    """The rounding errors to be expected in the residuals."""
    unknowns = np.abs(orbit.unknowns / problem.scale(orbit))
    unknowns[:-1] = np.maximum(unknowns[:-1], 1.0)
    found: Floats = rounding * (np.abs(matrix) @ unknowns[problem.free_columns(orbit)[0]])
    return found


def uncertainty(problem: Problem, orbit: SpaceOrbit) -> float:
    """The rounding error of the first free parameter of a solution."""
    return float(uncertainties(problem, orbit)[0])


def uncertainties(problem: Problem, orbit: SpaceOrbit) -> Floats:
    """The rounding errors of all free parameters; infinite where the matrix is singular."""
    matrix, first, count = problem.matrix(orbit), orbit.x.size, len(problem.free)
    noise = _noise(problem, orbit, matrix, MAP_ROUNDING)
    try:
        back = np.abs(np.linalg.inv(matrix))[first : first + count]
    except np.linalg.LinAlgError:
        return np.full(count, math.inf)
    found: Floats = (back @ noise) * np.array(problem.p_scale)[list(problem.free)]
    found[np.isnan(found)] = math.inf
    return found


def cycles(free: Sequence[int], x_scale: Sequence[float], p_scale: Sequence[float]) -> Problem:
    """The problem of cycles with some free parameters."""
    return Problem((Closed(),), tuple(free), tuple(map(float, x_scale)), tuple(map(float, p_scale)))
