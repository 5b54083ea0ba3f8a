"""Chains of fold-flip points without end."""

from dataclasses import replace

import numpy as np
import pytest

from pwmap.diagrams.diagram import PointKind, PointStatus
from woodpecker.search.accumulations import limit_of
from woodpecker.search.curves import End

UNITS = np.array([2.0, 4.0])
LIMITS = (0.3, -1.2), (0.7, -0.4)  # (p, x) of the two places that a chain approaches
ROUNDING = 1e-15  # of the limits: what is left of differences of numbers near 1, times 1/(1 - r)


def chain(ratios: tuple[float, float], links: int = 8, drift: float = 0.0) -> list[End]:
    """The last points of a chain, the last one first.

    Their distances from the limits shrink by a ratio for each, and by a drift more in early links.
    """
    found = []
    for k in range(links):
        side, n = k % 2, k // 2
        away = 0.1 * ratios[side] ** n * (1.0 + drift * ratios[side] ** n)
        p, x = LIMITS[side][0] + away, LIMITS[side][1] - 2.0 * away
        found.append(End(kind=PointKind.FF, p=p, x=np.array([[x]]), cause="two events at once"))
    return found[::-1]


@pytest.mark.parametrize("ratios", [(0.16, 0.2), (0.5, 0.5), (0.03, 0.6)])
def test_the_limit_of_a_geometric_series(ratios: tuple[float, float]) -> None:
    for links in (8, 9, 14):
        ends = chain(ratios, links)
        found, (p, x) = limit_of(ends, UNITS), LIMITS[(links - 1) % 2]
        assert found is not None
        assert (found.kind, found.status) == (PointKind.EP, PointStatus.OPEN)
        assert found.p == pytest.approx(p, abs=10.0 * ROUNDING)
        assert found.x == pytest.approx(np.array([[x]]), abs=10.0 * ROUNDING)
        assert found.precision == pytest.approx(abs(ends[0].p - p), abs=10.0 * ROUNDING)
        assert "infinitely many fold-flip points accumulate" in found.cause


def test_the_limit_of_a_series_that_becomes_geometric_lies_within_its_precision() -> None:
    for drift in (0.2, -0.2):  # first ratios off by an eighth, as those of the toy
        found = limit_of(chain((0.16, 0.2), 8, drift), UNITS)
        assert found is not None
        assert abs(found.p - LIMITS[1][0]) <= 0.1 * found.precision


def test_what_has_an_end_has_no_limit() -> None:
    ends = chain((0.16, 0.2))
    assert limit_of(ends[:7], UNITS) is None  # too few to tell
    assert limit_of(chain((0.16, 1.2)), UNITS) is None  # one side moves apart
    assert limit_of(chain((1.0, 0.2)), UNITS) is None  # evenly spaced
    for k in range(8):
        other = [*ends[:k], replace(ends[k], kind=PointKind.BC), *ends[k + 1 :]]
        assert limit_of(other, UNITS) is None
        aside = replace(ends[k], x=ends[k].x + 0.2)
        assert limit_of([*ends[:k], aside, *ends[k + 1 :]], UNITS) is None
    squares = chain((0.16, 0.2), 8, drift=30.0)  # ratios that change by more than a quarter
    assert limit_of(squares, UNITS) is None
