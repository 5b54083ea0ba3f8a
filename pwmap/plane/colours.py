"""What a raster of the plane can show."""

from __future__ import annotations

from enum import StrEnum


class Colours(StrEnum):
    """What the colours of a plane say.

    Examples
    --------
    >>> from pwmap.plane import Colours
    >>> [(colours.name, colours.value) for colours in Colours]
    [('PERIOD', 'period'), ('ENTROPY', 'entropy'), ('BANDS', 'bands')]
    """

    PERIOD = "period"
    ENTROPY = "entropy"
    BANDS = "bands"
