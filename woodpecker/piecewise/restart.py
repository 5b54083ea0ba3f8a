"""Landing: the first point of a branch beyond an edge of its piece.

Where one lap of a cycle meets an edge at which the map is continuous, the branch goes on with
another word. The slopes beyond the edge tell its direction; next to a square root there is none,
and the branch is looked for at neighbouring parameters.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from woodpecker.base.arrays import Floats
from woodpecker.piecewise.borders import NEAR, Edge
from woodpecker.piecewise.maps import Cycle, LabelledMap, correct, evaluate, iterate, tangent
from woodpecker.piecewise.partition import Resolution, sampled, slice_of
from woodpecker.piecewise.settings import Settings

SCALES = (1.0, 10.0, 100.0)  # of the landing, tried in turn
NEARLY_UPRIGHT = 1e-3  # smallest cosine that a direction in (x, p) is divided by
WIDEST_LANDING = 0.01  # a fixed point further than this from the edge is not the branch's


class Landing(NamedTuple):
    """A cycle, and the direction (j + 1,) in which its branch goes on."""

    cycle: Cycle
    tangent: Floats


def beyond(
    labelled_map: LabelledMap, met: Cycle, lap: int, edge: Edge, side: int, settings: Settings
) -> Landing | None:
    """The branch of the cycle ``met`` beyond the edge that one of its laps meets on a side.

    None if the slope beyond the edge is no guide.
    """
    outside = edge.right if side > 0 else edge.left
    laps = (*met.laps[:lap], outside, *met.laps[lap + 1 :])
    return _along_tangent(labelled_map, met._replace(laps=laps), settings)


def beside(
    labelled_map: LabelledMap, edge: Edge, side: int, order: int, settings: Settings
) -> Landing | None:
    """The branch that leaves an edge of P_order into the piece at ``side``, if there is one.

    First along the tangent of that piece, then, if its slope is infinite at the edge (a grazing),
    by bracketing the fixed point at a neighbouring parameter.
    """
    inside = orbit_beside(labelled_map, edge, side, order)
    landed = None if inside is None else _along_tangent(labelled_map, inside, settings)
    return landed or _bracketed(labelled_map, edge, side, order, settings)


def orbit_beside(labelled_map: LabelledMap, edge: Edge, side: int, order: int) -> Cycle | None:
    """The laps of P_order right next to an edge of it; None if the orbit is lost."""
    x = _orbit(labelled_map, edge.x + side * NEAR * math.ulp(edge.x), edge.p, order)
    return None if x is None else evaluate(labelled_map, x, edge.p)


def _along_tangent(labelled_map: LabelledMap, laps: Cycle, settings: Settings) -> Landing | None:
    """A cycle next to given laps, with the same words, where their slopes say.

    All laps are solved together, so slopes that multiply to large numbers do no harm. Next to a
    square root slopes change much and say nothing.
    """
    along = tangent(laps, np.ones(len(laps.x) + 1))
    if not np.isfinite(along).all():
        return None
    for scale in SCALES:
        for sign in (1.0, -1.0):
            step = sign * scale * settings.tolerances.landing
            p = laps.p + step * along[-1]
            if not settings.span[0] <= p <= settings.span[1]:
                continue
            cycle, good, _ = correct(
                labelled_map, laps.x + step * along[:-1], p, along, settings.tolerances
            )
            away = float(np.abs(cycle.x - laps.x).max())
            straight = all(
                abs(a.slope - b.slope) <= 0.5 * max(1.0, abs(b.slope))
                for a, b in zip(cycle.laps, laps.laps, strict=True)
            )
            if good and cycle.words == laps.words and straight and away <= 2.0 * abs(step):
                return Landing(cycle, tangent(cycle, sign * along))
    return None


def found_beside(
    labelled_map: LabelledMap, last: Cycle, along: Floats, settings: Settings
) -> Landing | None:
    """The nearest cycle of other words at a neighbouring parameter, from all that are there."""
    order, x = len(last.x), float(last.x[0])
    whole = sampled(iterate(labelled_map, order))
    speed = np.linalg.norm(along[:-1]) / max(abs(along[-1]), NEARLY_UPRIGHT)
    for scale in (0.1, 1.0, 10.0, 100.0):
        delta = scale * settings.tolerances.landing
        half = 10.0 * delta * (1.0 + float(speed))
        found: list[tuple[float, Landing]] = []
        for p in (last.p + delta, last.p - delta):
            if not settings.span[0] <= p <= settings.span[1]:
                continue
            look = Resolution(spacing=half / 50.0, smallest=1e-3 * delta, bend=1e-3 * half)
            for root, _ in slice_of(whole, p, (x - half, x + half), look).fixed_points:
                orbit = _orbit(labelled_map, root, p, order)
                if orbit is None:
                    continue
                cycle, good, _ = correct(labelled_map, orbit, p, None, settings.tolerances)
                if good and cycle.words != last.words:
                    away = np.append(cycle.x - last.x, p - last.p)
                    distance = float(np.linalg.norm(away))
                    found.append((distance, Landing(cycle, tangent(cycle, away))))
        if found:
            return min(found, key=lambda item: item[0])[1]
    return None


def _bracketed(
    labelled_map: LabelledMap, edge: Edge, side: int, order: int, settings: Settings
) -> Landing | None:
    """A fixed point on the piece beside an edge of P_order, at a parameter next to the edge's."""
    whole, outside = iterate(labelled_map, order), edge.right if side > 0 else edge.left
    for scale in SCALES:
        delta = scale * settings.tolerances.landing
        for x, p in _brackets(whole, edge, side, outside.word, delta):
            if not settings.span[0] <= p <= settings.span[1]:
                continue
            orbit = _orbit(labelled_map, x, p, order)
            if orbit is None:
                continue
            cycle, good, _ = correct(labelled_map, orbit, p, None, settings.tolerances)
            if good and cycle.word == outside.word and abs(cycle.x[0] - x) <= delta:
                chord = np.zeros(order + 1)
                chord[0], chord[-1] = cycle.x[0] - edge.x, p - edge.p
                return Landing(cycle, tangent(cycle, chord))
    return None


def _brackets(
    whole: LabelledMap, edge: Edge, side: int, word: str, delta: float
) -> Iterator[tuple[float, float]]:
    """Fixed points on the piece beside an edge, at the two parameters ``delta`` from it."""
    for p in (edge.p + delta, edge.p - delta):
        far = edge.x + side * 100.0 * delta
        near = edge.x - side * 100.0 * delta
        if whole(far, p).word != word or whole(near, p).word == word:
            continue
        first = _first_inside(whole, near, far, p, word, 1e-4 * delta)
        f_first = whole(first, p).value - first
        reach = 1e-3 * delta
        previous = first
        while reach < WIDEST_LANDING:
            x = first + side * reach
            here = whole(x, p)
            if here.word != word:
                break
            if (here.value - x) * f_first <= 0.0:
                low, high = sorted((previous, x))
                yield float(brentq(lambda t: whole(t, p).value - t, low, high, xtol=1e-16)), p  # noqa: B023
                break
            previous, reach = x, 2.0 * reach


def _first_inside(
    whole: LabelledMap, outside: float, inside: float, p: float, word: str, fine: float
) -> float:
    """A point of a piece no further than ``fine`` from its end."""
    while abs(outside - inside) > fine:
        middle = 0.5 * (inside + outside)
        if whole(middle, p).word == word:
            inside = middle
        else:
            outside = middle
    return inside


def _orbit(labelled_map: LabelledMap, x: float, p: float, order: int) -> Floats | None:
    values = [x]
    for _ in range(order - 1):
        lap = labelled_map(values[-1], p)
        if not lap.defined:
            return None
        values.append(lap.value)
    return np.array(values)
