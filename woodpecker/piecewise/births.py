"""Cycles of longer periods that are born where a cycle meets a kink.

There the map is continuous, and the germ of the map at the border tells: an orbit on the cycle has
finitely many paths, and a path that returns after several rounds is the start of a longer cycle.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator

import numpy as np

from woodpecker.engine import orbits
from woodpecker.engine.curves import Curve, CurveSettings
from woodpecker.engine.germs import Beginning, beginnings
from woodpecker.engine.line import LineMap, LinePiece
from woodpecker.engine.newton import cycles
from woodpecker.engine.tracing import beside
from woodpecker.piecewise.ends import End
from woodpecker.piecewise.orbits import Closed, Orbit, orbit_of, tangent
from woodpecker.piecewise.pieces import Piece, PiecewiseMap
from woodpecker.piecewise.samples import Sample
from woodpecker.piecewise.settings import Settings


def born(
    map_: PiecewiseMap, end: End, orders: Collection[int], settings: Settings
) -> list[tuple[Sample, Sample]]:
    """The branches of longer cycles that start where a cycle meets a kink.

    Parameters
    ----------
    map_
        The map.
    end
        The collision, with all points of the cycle.
    orders
        Iterates whose branches are wanted.
    settings
        Scales, span and window.

    Returns
    -------
    For each the sample at the collision, and the next one.
    """
    n = len(end.x)
    longer = [order for order in orders if order > n and order % n == 0]
    found = list[tuple[Sample, Sample]]()
    for begin in _beside(map_, end, longer, settings):
        assert begin.before is not None
        there, at = _sample(begin.sample.orbit, settings), _orbit(begin.before.orbit)
        way = there.orbit.point - at.point
        if there.tangent @ way < 0.0:
            there = Sample(there.orbit, -there.tangent, forward=False)
        found.append((Sample(at, there.tangent, there.forward), there))
    return found


def _beside(
    map_: PiecewiseMap, end: End, orders: Collection[int], settings: Settings
) -> Iterator[Beginning]:
    """What starts there, with a first sample beside the collision."""
    if not orders:
        return
    problem = cycles((0,), (settings.x_scale,), (settings.p_scale,))
    limits = CurveSettings(spans=(settings.span,), window=(settings.window,))
    base = Curve(LineMap(map_, settings.x_scale, settings.p_scale), problem, limits)
    for begin in beginnings(base, end.x[:, None], np.array([end.p]), sorted(orders)):
        there = begin if begin.is_crossing else beside(begin)
        if there.before is not None:
            yield there


def _sample(orbit: orbits.Orbit, settings: Settings) -> Sample:
    own = _orbit(orbit)
    return Sample(own, tangent(own, Closed(), settings))


def _orbit(orbit: orbits.Orbit) -> Orbit:
    """A cycle of R^1 as one of the line."""
    return orbit_of([_own(image.piece) for image in orbit.images], orbit.x[:, 0], float(orbit.p[0]))


def _own(piece: object) -> Piece:
    assert isinstance(piece, LinePiece)
    return piece.own  # type: ignore[return-value]
