"""Places for names of points in a picture of the browser, so that they cover nothing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pwmap.plot.labels import Floats, contained, overlap

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
    shows = np.all((points >= 0.0) & (points <= np.array(frame)), axis=1)
    order = sorted(range(len(texts)), key=lambda k: not must[k])
    for k in order:
        if not texts[k] or not shows[k]:
            continue
        size = np.array([CHARACTER * len(texts[k]), HEIGHT])
        middles = np.array(
            [np.array(way) * (size / 2.0 + away) for away in DISTANCES for way in DIRECTIONS]
        )
        boxes = np.hstack([points[k] + middles - size / 2.0, points[k] + middles + size / 2.0])
        costs = 10.0 * ((boxes[:, :2] < 0.0) | (boxes[:, 2:] > frame)).any(axis=1)
        costs += 10.0 * overlap(boxes[:, None], np.array(taken).reshape(-1, 4)).sum(axis=1)
        costs += COVERED * contained(boxes, points, MARKER)
        best = int(np.argmin(costs + 0.01 * np.arange(len(costs))))
        if costs[best] < COVERED or must[k]:
            taken.append(boxes[best] + GAP * np.array([-1.0, -1.0, 1.0, 1.0]))
            found.append((k, float(middles[best, 0]), float(middles[best, 1])))
    return found
