"""The quantities that colours of a plane can show, in a module that loads no numerics."""

from __future__ import annotations

from enum import StrEnum


class Colours(StrEnum):
    """The quantity that the colours of a plane show."""

    PERIOD = "period"
    ENTROPY = "entropy"
    BANDS = "bands"
