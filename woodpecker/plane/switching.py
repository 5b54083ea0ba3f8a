"""Where curves of another kind start."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pwmap.diagrams.diagram import PointKind
from pwmap.plane.kinds import PlaneKind
from woodpecker.base.arrays import Floats
from woodpecker.engine.curves import Arc
from woodpecker.engine.orbits import Condition, Multiplier, OnBorder, Orbit
from woodpecker.plane.maps import Plane
from woodpecker.plane.nodes import border_in, curve_of, inside


@dataclass(frozen=True, slots=True, eq=False)
class Seed:
    """Where a curve of another kind starts.

    Attributes
    ----------
    kind
        LP, PD or BC.
    orbit, condition
        Its first cycle, and what it obeys.
    along
        (n + 2,) its tangent there, forward.
    """

    kind: PointKind
    orbit: Orbit
    condition: Condition
    along: Floats


def starts_at(plane: Plane, arc: Arc) -> tuple[Seed, ...]:
    """The curves of another kind that start at the end of an arc.

    Where a cycle on a border has the multiplier +1 or -1 a curve of folds or flips starts, into the
    piece inside; where a fold or a flip meets a border, or a cycle on one meets another one, a
    curve of collisions with that border.
    """
    found, orbit, own = list[Seed](), arc.samples[-1].orbit, border_in(arc.curve)
    name = arc.test.name if arc.test is not None else ""
    if name in (PlaneKind.FOLD_BORDER, PlaneKind.FLIP_BORDER) and own is not None:
        value = 1.0 if name == PlaneKind.FOLD_BORDER else -1.0
        if abs(inside(orbit) - value) <= plane.first.kink:
            kind = PointKind.LP if value > 0.0 else PointKind.PD
            found += _seeds(plane, orbit, kind, Multiplier(kind.value, plane.scale), own)
    if arc.border is not None:
        met = OnBorder(*arc.border)
        if own is None:
            for sign in (1.0, -1.0):
                found += _seeds(plane, orbit, PointKind.BC, met, None, sign)
        elif own.image != met.image:
            found += _seeds(plane, orbit, PointKind.BC, met, own)
    return tuple(found)


def _seeds(
    plane: Plane, orbit: Orbit, kind: PointKind, condition: Condition, into: OnBorder | None,
    sign: float = 1.0,
) -> list[Seed]:  # fmt: skip
    """The curve from a cycle, into the side on which a margin is positive."""
    curve = curve_of(plane, condition, orbit)
    start = curve.start(orbit)
    if not np.isfinite(start.tangent).all():
        return []
    if into is not None:
        rate = curve.rate(start, into.image, into.code)
        if rate == 0.0:
            return []
        sign = 1.0 if rate > 0.0 else -1.0
    return [Seed(kind, orbit, condition, sign * start.tangent)]
