"""One colour for each period, in cells, rasters, diagrams and orbits alike.

Any two of them can be told apart in grey print, by a lightness L* that is some 8 further or less,
and by eyes that lack one kind of cone; ``tests/pwmap/test_palette.py`` measures both.
"""

from __future__ import annotations

PERIODS = (
    "#006096", "#fd962a", "#09976f", "#f4da59", "#722e6d", "#e774a3", "#ca3f26", "#76d1ee",
)  # fmt: skip
CHAOS, NOTHING = "#303030", "#f0f0f0"  # no period; nothing that attracts is known


def of_period(period: int) -> str:
    """The colour of a period from 1 on; periods beyond the last colour share it."""
    return PERIODS[min(period, len(PERIODS)) - 1]


def named(period: int) -> str:
    """What a legend says of this colour."""
    return f"period {period}" if period < len(PERIODS) else f"period {len(PERIODS)} or more"
