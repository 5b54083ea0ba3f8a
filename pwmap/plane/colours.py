"""The quantities that colours of a plane can show, without the numerics that the rest loads."""

from __future__ import annotations

from enum import StrEnum


class Colours(StrEnum):
    """The quantity that the colours of a plane show."""

    PERIOD = "period"
    ENTROPY = "entropy"
    BANDS = "bands"
