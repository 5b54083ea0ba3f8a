"""The colours of periods in all pictures, and the lines of bifurcation curves.

Any two colours differ in grey print (lightness L* by six or more) and for eyes that lack one kind
of cone: see ``tests/pwmap/plot/test_palette.py``.
"""

from __future__ import annotations

from typing import Any

from pwmap.diagrams.data import PointKind

PERIODS = (
    "#006096", "#e774a3", "#722e6d", "#09976f", "#fd962a", "#ca3f26", "#76d1ee", "#f4da59",
)  # fmt: skip
CHAOS, NOTHING = "#303030", "#ffffff"  # only bands attract; nothing is known to attract
BACKGROUND = "#ececec"  # for what a picture is not about, such as cycles where bands are counted

LINES: dict[PointKind, dict[str, Any]] = {  # of special points, over two parameters
    PointKind.BC: {"color": "#cb181d", "linewidth": 1.0},
    PointKind.FF: {"color": "#67000d", "linewidth": 2.0},
    PointKind.PD: {"color": "#54278f", "linewidth": 1.1, "linestyle": "--"},
    PointKind.LP: {"color": "#54278f", "linewidth": 1.1, "linestyle": ":"},
    PointKind.MC: {"color": "#238b45", "linewidth": 1.1, "linestyle": "--"},
    PointKind.XC: {"color": "#238b45", "linewidth": 1.1, "linestyle": ":"},
    PointKind.FC: {"color": "#238b45", "linewidth": 1.4},
}


def of_period(period: int) -> str:
    """The colour of a period from 1 on; all periods beyond the last colour share that one."""
    return PERIODS[min(period, len(PERIODS)) - 1]


def named(period: int) -> str:
    """The text of a legend for the colour of a period."""
    return f"period {period}" if period < len(PERIODS) else f"period {len(PERIODS)} or more"
