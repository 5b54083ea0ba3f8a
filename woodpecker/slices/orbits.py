"""Orbits of a map of the line, solved for by Newton's method of the engine, for R^1."""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np

from pwmap.diagrams.shown import brief
from woodpecker.base.arrays import Floats
from woodpecker.base.settings import Settings
from woodpecker.engine import orbits
from woodpecker.engine.line import first_piece, image_of, image_on_line
from woodpecker.engine.newton import Problem, newton_step, solve
from woodpecker.engine.orbits import Chained, Closed, Condition, Held, OnBorder
from woodpecker.maps.pieces import Image, Piece

# Fraction of the window: closer points of a cycle count as one. Beyond a flip the points of the
# doubled cycle part like the square root of the parameter's distance, which rounding blurs.
ONE_POINT = 1e-5
# Scaled: smaller derivatives of P_n(x, p) - x are rounding of steep slopes that cancel, so zero.
FILLED = 1e-9
CYCLE: tuple[Condition, ...] = (Closed(),)


@dataclass(frozen=True, slots=True, eq=False)
class Orbit:
    """An orbit of a map at one parameter: points, each with its image under a piece.

    Attributes
    ----------
    x, images
        (n,) points, and their n images.
    p
        The parameter.

    Examples
    --------
    >>> from woodpecker import Settings, slices_at
    >>> from woodpecker.examples import two_lines
    >>> one, = slices_at(two_lines(), -0.5, (1,), Settings(span=(-1, 2), window=(-3, 3)))
    >>> orbit, = one.cycles
    >>> orbit.x.round(12).tolist(), orbit.p, orbit.words
    ([-1.0], -0.5, ('L',))
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
        """The piece of each point, ready to be continued from that point."""
        return tuple(image.piece for image in self.images)

    @property
    def words(self) -> tuple[str, ...]:
        """The names of the pieces."""
        return tuple(image.piece.word for image in self.images)

    @property
    def keys(self) -> tuple[Hashable, ...]:
        """The keys of the pieces, which are equal only for equal pieces."""
        return tuple(image.piece.key for image in self.images)

    @property
    def multiplier(self) -> float:
        """The product of the slopes."""
        return math.prod((image.slope for image in self.images), start=1.0)

    @property
    def value(self) -> float:
        """The image of the last point; nan if there is none."""
        return math.nan if self.images[-1].reason else self.images[-1].value

    @property
    def defined(self) -> bool:
        """Whether every piece has a value."""
        return not any(image.reason for image in self.images)

    def rotated(self, first: int) -> Orbit:
        """The same cycle, starting from its point number ``first`` (counted from 0)."""
        return Orbit(np.roll(self.x, -first), self.p, (*self.images[first:], *self.images[:first]))


def orbit_of(pieces: Sequence[Piece], x: Floats, p: float) -> Orbit:
    """The orbit of given points with their images under given pieces."""
    images = tuple(piece.at(float(value), p) for piece, value in zip(pieces, x, strict=True))
    return Orbit(np.asarray(x, dtype=float), float(p), images)


def to_engine(orbit: Orbit) -> orbits.SpaceOrbit:
    """An orbit of the line as one of R^1."""
    images = tuple(map(image_of, orbit.images))
    return orbits.SpaceOrbit(orbit.x[:, None], np.array([orbit.p]), 0.0, images)


def of_engine(orbit: orbits.SpaceOrbit) -> Orbit:
    """An orbit of R^1 as one of the line; a jump crossing becomes its points up to the border."""
    p = float(orbit.p[0])
    images = [image_on_line(image) for image in orbit.images[: len(orbit.x)]]
    if orbit.outer is not None:
        images[-1] = first_piece(orbit.images[-1]).at(float(orbit.x[-1, 0]), p)
    return Orbit(orbit.x[:, 0], p, tuple(images))


def ending_at(n: int, code: int) -> tuple[Condition, ...]:
    """The conditions of a border orbit: n points in turn, the last on the border of a margin."""
    return Chained(), OnBorder(n - 1, code)


def problem_of(settings: Settings, *conditions: Condition) -> Problem:
    """The problem of conditions on an orbit of the line and its parameter, scaled by settings."""
    return Problem(conditions, (0,), (settings.x_scale,), (settings.p_scale,))


def solved(start: Orbit, settings: Settings, *conditions: Condition) -> Orbit | None:
    """The orbit near ``start`` on its pieces that satisfies conditions; None if Newton fails."""
    found = solve(problem_of(settings, *conditions), to_engine(start))
    closes = found.converged and _closes(found.orbit, conditions, settings)
    return of_engine(found.orbit) if closes else None


def _closes(orbit: orbits.SpaceOrbit, conditions: Sequence[Condition], settings: Settings) -> bool:
    """Whether images miss the points that they should be by less than the window is long."""
    # Beside a pole rounding moves the image of a point farther, and Newton's method stops there.
    closing = [each.residual(orbit) for each in conditions if isinstance(each, Closed | Chained)]
    return all(bool((np.abs(misses) <= settings.x_scale).all()) for misses in closing)


def at_parameter(
    start: Orbit, settings: Settings, conditions: Sequence[Condition] = CYCLE
) -> Orbit | None:
    """The orbit near ``start``, by default a cycle, as :func:`solved`, at the same parameter."""
    return solved(start, settings, *conditions, Held(len(start), start.p))


def stepped(orbit: Orbit, settings: Settings, conditions: Sequence[Condition] = CYCLE) -> Floats:
    """The points (n,) after one Newton step at the same parameter; nan if the step fails."""
    problem = problem_of(settings, *conditions, Held(len(orbit), orbit.p))
    points: Floats = orbit.x + newton_step(problem, to_engine(orbit))[:-1] * settings.x_scale
    return points


def minimal_period(orbit: Orbit, settings: Settings) -> int:
    """The minimal period of a cycle: the smallest shift of its points that maps it to itself."""
    return problem_of(settings).period(orbit.x[:, None], ONE_POINT)


def fills_interval(orbit: Orbit, settings: Settings) -> bool:
    """Whether a cycle belongs to an interval filled with cycles, and so to no branch.

    Then P_n(x, p) - x is zero to first order in x and p, as in the toy's band of centres, where P_1
    is the identity, and for P_2 beside it, where P_1 is a reflection.
    """
    rate = 0.0  # dP_n/dp
    for image in orbit.images:
        rate = image.slope * rate + image.d_parameter
    in_p = abs(rate) * settings.p_scale / settings.x_scale
    return max(abs(orbit.multiplier - 1.0), in_p) <= FILLED


def is_inside(orbit: Orbit, border: int = -1) -> bool:
    """Whether no margin is negative, except that of the code ``border`` at the last point."""
    last = len(orbit) - 1
    return not any(
        ((image.margins < 0.0) & ((image.causes != border) | (i < last))).any()
        for i, image in enumerate(orbit.images)
    )
