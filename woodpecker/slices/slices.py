"""Slices: all cycles and all jumps that cross the diagonal, of iterates at one parameter."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pwmap.diagrams.shown import counted
from woodpecker.base.checks import instance, iterates, number
from woodpecker.base.settings import Settings
from woodpecker.engine.newton import MAP_ROUNDING
from woodpecker.maps.counting import Allowance, as_counting
from woodpecker.maps.pieces import Image, PiecewiseMap, map_of_pieces
from woodpecker.slices.borders import Border
from woodpecker.slices.bracketing import bracketed
from woodpecker.slices.extents import Knot, PieceExtent
from woodpecker.slices.itineraries import Itineraries, Wanted
from woodpecker.slices.jumps import Jump, jump_of, limit_of
from woodpecker.slices.margins import depth
from woodpecker.slices.orbits import (
    Orbit,
    at_parameter,
    ending_at,
    fills_interval,
    is_inside,
    minimal_period,
    orbit_of,
)
from woodpecker.slices.partition import GAP_TOLERANCE, Partition, partition

# Fraction of the window: largest error of a guessed point that leads to a border. Values of cubics
# are good to a few 1e-5, points in flat pieces a hundred times less.
INTERPOLATED = 0.02
MOST_ADDED = 1000  # most samples inserted between two: none or a few are usual
EDGE = 0.02  # fraction of an interval: if a turning point seems closer to an end, it is halved


@dataclass(frozen=True, slots=True, eq=False)
class Slice:
    """Cycles and jumps of one iterate at a parameter, see :func:`woodpecker.slices_at`.

    Attributes
    ----------
    p, order
        The parameter and the iterate.
    cycles
        Its cycles of this minimal period, each once, from the smallest point; without those that
        fill an interval, as all points do where the iterate is the identity.
    jumps
        Its jumps that cross the diagonal.
    unresolved
        Total length of the intervals in which not all pieces of P_1 were found; the length of the
        window if some orbits of the iterate were left out.
    """

    p: float
    order: int
    cycles: tuple[Orbit, ...]
    jumps: tuple[Jump, ...]
    unresolved: float

    def __repr__(self) -> str:
        found = f"{counted(len(self.cycles), 'cycle')}, {counted(len(self.jumps), 'jump')}"
        return f"Slice(p={self.p:.10g}, order {self.order}: {found})"


def slices_at(
    map_: PiecewiseMap, p: float, orders: Sequence[int], settings: Settings
) -> list[Slice]:
    """All cycles and jump crossings of some iterates at one parameter.

    Parameters
    ----------
    map_, p
        P_1, and the parameter.
    orders
        The iterates.
    settings
        With a finite window; orbits that leave it do not count.

    Returns
    -------
    list of Slice
        One for each iterate, as listed in ``orders``.

    Raises
    ------
    ValueError, TypeError
        If p is not finite, or an argument is of another kind.

    Examples
    --------
    >>> from woodpecker import Settings, slices_at
    >>> from woodpecker.examples import two_lines
    >>> for one in slices_at(two_lines(), 0.5, (1, 2), Settings(span=(-1, 2), window=(-3, 3))):
    ...     print(one.order, len(one.cycles), len(one.jumps))
    1 0 1
    2 1 1
    """
    instance("settings", settings, Settings)
    if not math.isfinite(p := number("p", p)):
        raise ValueError(f"p must be finite, got {p}")
    iterates(orders)  # raises if these are none
    map_ = as_counting(map_of_pieces(map_))
    allowed = Allowance(map_, settings.of_slice(orders))
    pieces = partition(map_, p, settings.window, settings, orders, allowed)
    borders = [border for border in pieces.borders(settings) if border.is_jump(settings)]
    found, whole = [], settings.window[1] - settings.window[0]
    orbits = Itineraries(pieces, settings, allowed) if max(orders) > 1 else None
    for order in orders:
        if order == 1:
            cycles = list(_fixed_points(pieces, settings))
        else:
            assert orbits is not None
            cycles = orbits.cycles(order)
        kept = tuple(_distinct(cycles, order, settings))
        jumps = tuple(_jumps(map_, pieces, borders, orbits, order, settings))
        all_seen = orbits is None or not orbits.left
        found.append(Slice(p, order, kept, jumps, pieces.unresolved if all_seen else whole))
    return found


def _distinct(cycles: Sequence[Orbit], order: int, settings: Settings) -> Iterator[Orbit]:
    """The cycles of minimal period ``order``, each once, from the smallest point."""
    turned = [
        orbit.rotated(int(np.argmin(orbit.x)))
        for orbit in cycles
        if minimal_period(orbit, settings) == order
        and not _on_border(orbit, settings)
        and not fills_interval(orbit, settings)
    ]
    last: Orbit | None = None
    for orbit in sorted(turned, key=lambda orbit: float(orbit.x[0])):
        same = settings.same * settings.x_scale
        if last is None or np.abs(orbit.x - last.x).max() > same:
            yield orbit
        last = orbit


def _on_border(orbit: Orbit, settings: Settings) -> bool:
    """Whether a cycle lies so close to a border that rounding decides its pieces."""
    # Its place is known to rounding / (1 - multiplier), at a fold to the root of rounding. Without
    # this, cycles appear along the whole border of an interval that cycles fill.
    off = abs(orbit.multiplier - 1.0)
    known = min(MAP_ROUNDING / off, MAP_ROUNDING**0.5) if off > 0.0 else MAP_ROUNDING**0.5
    least = max(settings.nearest, known) * settings.x_scale
    return any(abs(depth(image)) <= least for image in orbit.images)


def _jumps(
    map_: PiecewiseMap, pieces: Partition, borders: Sequence[Border], orbits: Itineraries | None,
    order: int, settings: Settings,
) -> Iterator[Jump]:  # fmt: skip
    wanted = _crossing(map_, pieces, order, settings)
    if orbits is None:
        heads: Iterator[tuple[Orbit, Border]] = (
            (Orbit(np.array([b.x]), b.p, (b.inner,)), b) for b in borders if wanted(b, 1, b.x)
        )
    else:
        heads = orbits.heads(borders, order, wanted)
    for guess, border in heads:
        head = at_parameter(guess, settings, ending_at(len(guess), border.code))
        if head is not None and is_inside(head, border.code) and _within(head, settings):
            jump = jump_of(map_, head, border.code, order, settings)
            if jump.crosses:
                yield jump


def _crossing(map_: PiecewiseMap, pieces: Partition, order: int, settings: Settings) -> Wanted:
    """A test whether a jump of P_order may cross the diagonal at a point that is known roughly."""
    # The limits depend only on the border and the number of returns after it. Beside a gap one of
    # them is that of the next known piece, not of the one right beyond: off by GAP_TOLERANCE.
    known: dict[tuple[int, int], tuple[float, float]] = {}

    def between(border: Border, returns: int) -> tuple[float, float]:
        ends = [
            limit_of(map_, border.x, image, returns, border.p).value
            for image in (border.inner, border.outer)
        ]
        at_gap = any(low <= border.x <= high for low, high in pieces.gaps)
        slack = (GAP_TOLERANCE if at_gap else INTERPOLATED) * settings.x_scale
        return min(ends) - slack, max(ends) + slack

    def crosses(border: Border, length: int, x: float) -> bool:
        key = id(border), order - length
        if key not in known:
            known[key] = between(border, order - length)
        low, high = known[key]
        return low <= x <= high

    return crosses


def _within(orbit: Orbit, settings: Settings) -> bool:
    low, high = settings.window
    return bool(low <= orbit.x.min() and orbit.x.max() <= high)


def _fixed_points(pieces: Partition, settings: Settings) -> Iterator[Orbit]:
    for cylinder in pieces.cylinders:
        for a, b in _parts(cylinder, pieces.p):
            root = bracketed(a, b, pieces.p, lambda image, x: image.value - x)
            if root is None:
                continue
            start = orbit_of([root[1].piece], np.array([root[0]]), pieces.p)
            found = at_parameter(start, settings)
            if found is not None and is_inside(found):
                yield found


def _parts(cylinder: PieceExtent, p: float) -> Iterator[tuple[Knot, Knot]]:
    """Pairs of neighbouring samples, with more where P(x) - x may vanish twice between two."""
    for pair in pairwise(cylinder):
        todo, left = [pair], MOST_ADDED
        while todo:
            a, b = todo.pop()
            x, left = _lowest(a, b) if left > 0 else None, left - 1
            middle = None if x is None else Knot(x, a.image.piece.at(x, p))
            if middle is None or middle.image.reason:
                yield a, b
            else:
                todo += [(middle, b), (a, middle)]


def _lowest(a: Knot, b: Knot) -> float | None:
    """Where abs(P(x) - x) is least between two samples; None if it cannot reach zero there."""
    # Without an inflection it cannot if the tangents at both ends meet on the same side of zero.
    (one, down), (other, up) = _gap(a.image, a.x), _gap(b.image, b.x)
    if not (one * other > 0.0 and one * down < 0.0 < other * up):
        return None
    run = b.x - a.x
    meet = (other - one - up * run) / (down - up)  # distance from a where the tangents meet
    part = down / (down - up)
    x = a.x + part * run if EDGE < part < 1.0 - EDGE else a.x + 0.5 * run
    return x if a.x < x < b.x and (one + down * meet) * one <= 0.0 else None


def _gap(image: Image, x: float) -> tuple[float, float]:
    return image.value - x, image.slope - 1.0
