"""Windows of eps_N1 and phi_S in which studies search, and places of the paper's A, B and C.

Places are (eps_N1, phi_S [rad]) under both laws, with seven digits: enough to identify a special
point, and no result depends on further digits.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from pwmap import Diagram, PointKind, SpecialPoint
from studies.common.laws import SEPARATE, SUMMED
from woodpecker import Settings

Place = tuple[float, float]

SPAN: Final = (0.012, 1.0)  # of eps_N1; next to 0 impacts accumulate
WINDOW: Final = (-2.5, -0.24)  # rad: up to the band of centres
POINT_A: Final = {SUMMED: (0.1119709, -0.8847733), SEPARATE: (0.0421643, -0.8847733)}
POINT_B: Final = {SUMMED: (0.2915217, -0.8847733), SEPARATE: (0.3210361, -0.8847733)}
POINT_C: Final = (0.1851270, -0.7577873)  # under both
SCALES: Final = Settings(window=WINDOW)
SAME = 1e-6  # in either coordinate: half a unit of the last digit above is much less


def collisions(diagram: Diagram, place: Place, within: float = SAME) -> Iterator[SpecialPoint]:
    """Border collisions near a place."""
    for point in diagram.points:
        near = np.abs(np.subtract((point.parameter, point.x), place)).max() < within
        if near and point.kind in (PointKind.BC, PointKind.FF):
            yield point


def collision(diagram: Diagram, place: Place) -> SpecialPoint | None:
    """The border collision at a place, if the diagram has it."""
    return next(collisions(diagram, place), None)


def told(point: SpecialPoint) -> tuple[str, str, float, float]:
    """Kind, note, eps_N1 and phi_S of a special point, for the results of a study."""
    return str(point.kind), point.note, float(point.parameter), float(point.x)
