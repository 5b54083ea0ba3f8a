"""Orbits in doubles at many places, to find attractors that exist in a short interval only.

Where they differ from those at an exact sample, another exact sample is taken, which decides.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from pwmap.algebra.exact import Number, floor
from pwmap.algebra.roots import Real, bounds, simplest_between
from pwmap.longrun.crises.samples import Samples
from pwmap.longrun.line import MapLine

PLACES = 256  # in the whole interval
LOOKS = 3  # exact samples between two cuts, at most
SETTLED, SEEN = 400, 512  # steps of an orbit that are left out, and steps that are counted
FAR = 1e9  # times the breaks and their images: there orbits are lost
SAME = 1e-9  # of the width of an orbit: closer points are one
GAP = 10.0  # times the mean distance of its points: a larger one is a gap between bands

Floats = npt.NDArray[np.float64]


class Glimpses:
    """Finds places at which other attractors may exist: bands, or cycles up to the order."""

    def __init__(self, samples: Samples, low: Number, high: Number, order: int) -> None:
        self._order = order
        self._low, self._step = low, (high - low) / PLACES
        self._places = [low + self._step * (2 * k + 1) / 2 for k in range(PLACES)]
        breaks = len(samples.layout.breaks)
        samples.meter.spend(breaks * (SETTLED + SEEN))
        lines = [samples.line(place).doubles for place in self._places if breaks]
        self._kinds = _kinds(lines) if breaks else [(0,)] * PLACES

    def between(self, low: Real, high: Real, place: Number) -> list[Number]:
        """Simple places where orbits differ from those at a sample, and at a neighbour, too."""
        kind = self._kinds[min(PLACES - 1, floor((place - self._low) / self._step))]
        start = max(0, floor((bounds(low)[1] - self._low) / self._step))
        found, inside = list[Number](), False
        for k in range(start, PLACES - 1):
            x, y = self._places[k : k + 2]
            if not y < bounds(high)[0] or len(found) == LOOKS:
                break
            both = self._kinds[k : k + 2]
            # a single place does not count: near a merging, or by chance, its number is wrong
            differ = low < x and kind not in both and max(map(max, both)) <= 1 + self._order
            if differ and not inside:
                found.append(simplest_between(x, y))
            inside = differ
        return found


def _kinds(lines: Sequence[MapLine]) -> list[tuple[int, ...]]:
    """For each map and side of a break: 1 + a period, minus a number of bands, or 0 if lost."""
    slopes, intercepts = (
        np.array([[branch[i] for branch in line.branches] for line in lines]).T for i in (0, 1)
    )
    breaks = np.array([line.breaks for line in lines]).T
    sides = [(b, k) for b in range(len(breaks)) for k in (b, b + 1)]
    x = np.array([slopes[k] * breaks[b] + intercepts[k] for b, k in sides])
    far = FAR * (1.0 + np.abs(breaks).max() + np.abs(x).max())
    orbit = np.empty((SEEN, *x.shape))
    for step in range(-SETTLED, SEEN):
        if step >= 0:
            orbit[step] = x
        piece = (x[None] > breaks[:, None]).sum(axis=0)
        x = np.take_along_axis(slopes, piece, 0) * x + np.take_along_axis(intercepts, piece, 0)
        np.clip(x, -far, far, out=x)
    return [tuple(row) for row in _counted(np.sort(orbit, axis=0), far).T.tolist()]


def _counted(points: Floats, far: float) -> npt.NDArray[np.int64]:
    """Numbers of points or bands, from sorted points."""
    span = points[-1] - points[0]
    steps = np.diff(points, axis=0)
    cycle = 1 + (steps > SAME * (np.abs(points).max(axis=0) + span)).sum(axis=0)
    bands = 1 + (steps > GAP * span / SEEN).sum(axis=0)
    lost = np.abs(points[-1]) + np.abs(points[0]) >= far
    return np.where(lost, 0, np.where(cycle < SEEN // 4, 1 + cycle, -bands))
