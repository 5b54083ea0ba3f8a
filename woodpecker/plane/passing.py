"""How a curve goes on where a cycle meets a border besides the one that it lies on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.piecewise.borders import BorderKind
from woodpecker.piecewise.crossings import border_at
from woodpecker.piecewise.orbits import Margin
from woodpecker.plane.curve import PlaneKind
from woodpecker.plane.nodes import Node, is_tiny, node_at
from woodpecker.plane.places import Locus, Place, Plane, replaced, tangent

PARALLEL = 1e-3  # sine of an angle between gradients of margins of one border in neighbouring pieces


@dataclass(frozen=True, slots=True, eq=False)
class Passed:
    """What a curve does at a second border.

    Attributes
    ----------
    kind
        What it is; None if only words change.
    node, locus
        Where it goes on, and what its cycles obey there; None if it ends.
    cause
        What the second border does to the map, if the curve ends.
    """

    kind: PlaneKind | None
    node: Node | None = None
    locus: Locus | None = None
    cause: str = ""


def passed(plane: Plane, locus: Locus, node: Node, margin: Margin) -> Passed:
    """How a curve goes on at a node where a second margin vanishes."""
    if locus.border is not None and locus.border.index == margin.index:
        return _round_corner(plane, locus, node, margin)
    border = border_at(plane.map(node.place.values), node.orbit, margin, plane.first)
    kind = border.kind(plane.first)
    if kind is BorderKind.LOST:
        return Passed(PlaneKind.DOMAIN, cause=border.outer.reason)
    meeting = PlaneKind.TWO_BORDERS
    if locus.border is None:
        meeting = PlaneKind.FOLD_BORDER if locus.held == 1.0 else PlaneKind.FLIP_BORDER
    if kind is BorderKind.JUMP or border.outer_code < 0:
        return Passed(meeting, cause=kind.value)
    if kind is not BorderKind.SMOOTH and (
        locus.border is None or kind is BorderKind.GRAZING
    ):
        return Passed(meeting, cause=kind.value)
    there = replaced(plane, node.place, margin.index, border.outer.piece)
    on = _onward(plane, locus, there, Margin(margin.index, border.outer_code))
    if on is None:
        return Passed(meeting, cause="no curve beyond")
    return Passed(None if kind is BorderKind.SMOOTH else meeting, on, locus)


def _onward(plane: Plane, locus: Locus, place: Place, inside: Margin) -> Node | None:
    """A place as the first node of an arc on which a margin grows."""
    if not place.defined:
        return None
    along = tangent(plane, place, locus)
    if not np.isfinite(along).all():
        return None
    gradient = place.gradient(inside.index, inside.code)
    rate = float(gradient @ (along * plane.scales(len(place)))[[inside.index, -2, -1]])
    if rate == 0.0:
        return None
    return node_at(plane, locus, place, along if rate > 0.0 else -along)


def _round_corner(plane: Plane, locus: Locus, node: Node, margin: Margin) -> Passed:
    """The same where both borders bound one piece: its neighbour beyond the second one may have the
    first one too.

    The neighbour lies where the first margin is positive and the second one negative.
    """
    own, meeting = locus.border, PlaneKind.TWO_BORDERS
    assert own is not None
    place, scale, i = node.place, plane.scales(1), margin.index
    first, second = (place.gradient(i, code) * scale for code in (own.code, margin.code))
    found = _wedge(plane, place, i, first, second)
    if found is None:
        return Passed(PlaneKind.DOMAIN, cause="the return is lost beyond")
    there = replaced(plane, place, i, found.orbit.pieces[0])
    if not there.defined:
        return Passed(meeting, cause=BorderKind.JUMP.value)
    inner, outer = place.orbit.images[i], there.orbit.images[i]
    same = plane.first.jump * plane.first.x_scale
    if not abs(outer.value - inner.value) <= same:
        return Passed(meeting, cause=BorderKind.JUMP.value)
    codes = [code for code in outer.causes.tolist() if is_tiny(plane, there, i, code)]
    ahead = {code: _unit(there.gradient(i, code) * scale) for code in codes}
    shared = min(codes, key=lambda code: float(ahead[code] @ _unit(second)), default=-1)
    rest = [code for code in codes if code != shared]
    next_ = max(rest, key=lambda code: float(ahead[code] @ _unit(first)), default=-1)
    if next_ < 0:
        return Passed(meeting, cause="the border ends")
    size = max(1.0, abs(inner.slope), abs(outer.slope))
    smooth = abs(outer.slope - inner.slope) <= plane.first.kink * size and float(
        np.linalg.norm(np.cross(ahead[next_], _unit(first)))
    ) <= PARALLEL
    on_locus = Locus(Margin(i, next_))
    on = _onward(plane, on_locus, there, Margin(i, shared))
    if on is None:
        return Passed(meeting, cause="no curve beyond")
    return Passed(None if smooth else meeting, on, on_locus)


def _wedge(
    plane: Plane, place: Place, i: int, first: Floats, second: Floats
) -> Place | None:
    """The map's own piece right beside a corner, inside one border and outside another one."""
    rows = np.array([_unit(first), _unit(second)])
    way: Floats = np.linalg.pinv(rows) @ np.array([1.0, -1.0])
    away = plane.first.beside
    while away >= plane.first.nearest:
        dx, dp, dq = (away * way * plane.scales(1)).tolist()
        x, values = float(place.orbit.x[i]) + dx, (place.values[0] + dp, place.values[1] + dq)
        image = plane.map(values).at(x, values[0])
        if not image.reason:
            return plane.place([image.piece], np.array([x]), values)
        away *= plane.first.numerics.nearer
    return None


def _unit(vector: Floats) -> Floats:
    size = float(np.linalg.norm(vector))
    return vector / size if size else vector
