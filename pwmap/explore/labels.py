"""Places for names of points in a picture of the browser, so that they cover nothing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

CHARACTER, HEIGHT = 7.0, 13.0  # px: mean width of a character, height of a line
MARKER = 7.0  # px: half the size of what markers take
DIRECTIONS = ((1, 1), (-1, 1), (1, -1), (-1, -1), (1, 0), (-1, 0), (0, 1), (0, -1))
GAP = 3.0  # px between labels
COVERED = 5.0  # the cost of a marker under a label: those that cost more are left out
DISTANCES = (1.0, 6.0, 14.0)  # px from the point


def place(
    texts: Sequence[str], points: Floats, frame: tuple[float, float], must: Sequence[bool]
) -> list[tuple[int, float, float]]:
    """Places (which text, its middle beside its point [px]) for labels that cover no other one.

    The points (n, 2) and the frame are in pixels, y upward. Labels of ``must`` are placed first, in
    any case; others are left out if they would cover something.
    """
    taken: list[Floats] = []
    found: list[tuple[int, float, float]] = []
    inside = np.all((points >= 0.0) & (points <= np.array(frame)), axis=1)
    order = sorted(range(len(texts)), key=lambda k: not must[k])
    for k in order:
        if not texts[k] or not inside[k]:
            continue
        size = np.array([CHARACTER * len(texts[k]), HEIGHT])
        middles = np.array(
            [np.array(way) * (size / 2.0 + away) for away in DISTANCES for way in DIRECTIONS]
        )
        boxes = np.hstack([points[k] + middles - size / 2.0, points[k] + middles + size / 2.0])
        costs = _costs(boxes, points, taken, frame)
        best = int(np.argmin(costs + 0.01 * np.arange(len(costs))))
        if costs[best] < COVERED or must[k]:
            taken.append(boxes[best] + GAP * np.array([-1.0, -1.0, 1.0, 1.0]))
            found.append((k, float(middles[best, 0]), float(middles[best, 1])))
    return found


def _costs(
    boxes: Floats, points: Floats, taken: Sequence[Floats], frame: tuple[float, float]
) -> Floats:
    """The cost of a place: 10 for each covered label, or outside the frame; 5 for each marker."""
    outside = (boxes[:, :2] < 0.0).any(axis=1) | (boxes[:, 2:] > frame).any(axis=1)
    cost = 10.0 * outside.astype(float)
    for other in taken:
        cost += 10.0 * (
            (boxes[:, 0] < other[2]) & (boxes[:, 2] > other[0])
            & (boxes[:, 1] < other[3]) & (boxes[:, 3] > other[1])
        )  # fmt: skip
    low, high = boxes[:, None, :2] - MARKER, boxes[:, None, 2:] + MARKER
    covered: Floats = cost + COVERED * ((points > low) & (points < high)).all(axis=2).sum(axis=1)
    return covered
