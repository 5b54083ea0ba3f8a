"""What a raster of the plane can show."""

from __future__ import annotations

from enum import StrEnum


class Colours(StrEnum):
    """What the colours of a plane say."""

    PERIOD = "period"
    ENTROPY = "entropy"
    BANDS = "bands"
