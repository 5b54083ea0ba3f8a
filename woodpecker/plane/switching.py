"""Where curves of another kind start."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pwmap.diagrams.diagram import PointKind
from pwmap.plane.kinds import PlaneKind
from woodpecker.base.arrays import Floats
from woodpecker.piecewise.orbits import Margin
from woodpecker.plane.nodes import Node
from woodpecker.plane.places import Locus, Place, Plane, tangent
from woodpecker.plane.stepping import Event


@dataclass(frozen=True, slots=True, eq=False)
class Seed:
    """Where a curve of another kind starts.

    Attributes
    ----------
    kind
        LP, PD or BC.
    place, locus
        Its first place, and what it obeys.
    along
        (n + 2,) its tangent there, forward.
    """

    kind: PointKind
    place: Place
    locus: Locus
    along: Floats


def starts_at(plane: Plane, node: Node, locus: Locus, event: Event | None) -> tuple[Seed, ...]:
    """The curves of another kind that start at a special point of codimension two.

    Where a cycle on a border has the multiplier +1 or -1 a curve of folds or flips starts, into the
    piece inside; where a fold or a flip meets a border, or a cycle on one meets another one, a
    curve of collisions with that border.
    """
    found = list[Seed]()
    if event is None:
        return ()
    border = locus.border
    if event.kind in (PlaneKind.FOLD_BORDER, PlaneKind.FLIP_BORDER) and border is not None:
        value = 1.0 if event.kind is PlaneKind.FOLD_BORDER else -1.0
        if abs(node.inside - value) <= plane.first.kink:
            kind = PointKind.LP if value > 0.0 else PointKind.PD
            found += _seeds(plane, node.place, kind, Locus(value), border)
    if event.margin is not None:
        inside = border
        if border is None:
            for sign in (1.0, -1.0):
                found += _seeds(plane, node.place, PointKind.BC, Locus(event.margin), None, sign)
        elif inside is not None and inside.index != event.margin.index:
            found += _seeds(plane, node.place, PointKind.BC, Locus(event.margin), inside)
    return tuple(found)


def _seeds(
    plane: Plane, place: Place, kind: PointKind, locus: Locus, inside: Margin | None,
    sign: float = 1.0,
) -> list[Seed]:  # fmt: skip
    """The curve from a place, into the side on which a margin is positive."""
    along = tangent(plane, place, locus)
    if not np.isfinite(along).all():
        return []
    if inside is not None:
        move = (along * plane.scales(len(place)))[[inside.index, -2, -1]]
        rate = float(place.gradient(inside.index, inside.code) @ move)
        if rate == 0.0:
            return []
        along = along if rate > 0.0 else -along
    return [Seed(kind, place, locus, sign * along)]
