"""How a curve goes on where a cycle meets a border besides the one that it lies on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pwmap.plane.kinds import PlaneKind
from woodpecker.base.arrays import Floats
from woodpecker.piecewise.borders import Border, BorderKind
from woodpecker.piecewise.crossings import border_at
from woodpecker.piecewise.orbits import SPACING, Margin
from woodpecker.piecewise.pieces import Piece
from woodpecker.plane.families import Pair
from woodpecker.plane.nodes import Node, is_inside, is_tiny, node_at
from woodpecker.plane.places import (
    Along,
    Locus,
    Place,
    Plane,
    Unknown,
    held,
    replaced,
    solve,
    tangent,
)

# Sine of an angle between gradients of margins of one border in neighbouring pieces.
PARALLEL = 1e-3
# Part to which a difference of slopes falls, a hundred times closer to a border, if it is none
# right there: a cube root falls to a fifth.
SHRINKS = 0.5
FAR = 1e3  # a restart lies this many of its distances from the border at most
NO_CURVE = "no curve beyond"


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
    meeting, smooth = _meeting(locus), locus.border is None and not isinstance(locus.held, Unknown)
    if kind is BorderKind.JUMP or border.outer_code < 0:
        return Passed(meeting, cause=kind.value)
    if kind is not BorderKind.SMOOTH and smooth and _tears(plane, node, border):
        return Passed(meeting, cause=kind.value)
    inside = Margin(margin.index, border.outer_code)
    on = _onward(plane, locus, node, border.outer.piece, inside)
    if on is None and smooth:
        on = _like_a_tangent(plane, locus, node, border, inside)
    if on is None:
        return Passed(meeting, cause=NO_CURVE)
    marked = kind is BorderKind.SMOOTH or locus.border is None
    return Passed(None if marked else meeting, on, locus)


def _meeting(locus: Locus) -> PlaneKind:
    """What it is where a curve meets a border."""
    if isinstance(locus.held, Margin):
        return PlaneKind.TWO_BORDERS
    if isinstance(locus.held, Unknown):
        return PlaneKind.END
    return PlaneKind.FOLD_BORDER if locus.held == 1.0 else PlaneKind.FLIP_BORDER


def _tears(plane: Plane, node: Node, border: Border) -> bool:
    """Whether the multiplier of a cycle is another one beyond a border.

    Beside a root slopes at the border are good to half of the digits only.
    """
    inner, outer = border.inner.slope, border.outer.slope
    return not abs(outer - inner) <= plane.first.numerics.torn * max(1.0, abs(inner), abs(outer))


def _round_corner(plane: Plane, locus: Locus, node: Node, margin: Margin) -> Passed:
    """The same where both borders bound one piece.

    Its neighbour beyond the second one may have the first one too: it lies where the first margin
    is positive and the second one negative.
    """
    own, meeting, i = locus.border, PlaneKind.TWO_BORDERS, margin.index
    assert own is not None
    place, scale = node.place, plane.scales(1)
    first, second = (place.gradient(i, code) * scale for code in (own.code, margin.code))
    wedge = _wedge(plane, place, i, first, second)
    if isinstance(wedge, str):
        return Passed(PlaneKind.DOMAIN, cause=wedge)
    there = _right_inside(plane, place, i, wedge)
    inner, outer = place.orbit.images[i], there.orbit.images[i]
    same = plane.first.jump * plane.first.x_scale
    if not (there.defined and abs(outer.value - inner.value) <= same):
        return Passed(meeting, cause=BorderKind.JUMP.value)
    codes = [code for code in outer.causes.tolist() if is_tiny(plane, there, i, code)]
    ahead = {code: _unit(there.gradient(i, code) * scale) for code in codes}
    shared = min(codes, key=lambda code: float(ahead[code] @ _unit(second)), default=-1)
    rest = [code for code in codes if code != shared]
    following = max(rest, key=lambda code: float(ahead[code] @ _unit(first)), default=-1)
    if following < 0:
        return Passed(meeting, cause="the border ends")
    along = Locus(Margin(i, following))
    on = _onward(plane, along, node, wedge.piece, Margin(i, shared), wedge.way)
    if on is None:
        return Passed(meeting, cause=NO_CURVE)
    smooth = _agree(plane, place, i, wedge) and _parallel(ahead[following], _unit(first))
    return Passed(None if smooth else meeting, on, along)


def _onward(
    plane: Plane, locus: Locus, node: Node, piece: Piece, inside: Margin,
    aside: Floats | None = None,
) -> Node | None:  # fmt: skip
    """The first node beyond a border, where the margin of the piece there is small and positive.

    Right at the border its slopes may be those of a root. None if there is no such place.
    """
    settings, scale = plane.first, plane.scales(len(node.place))
    start = replaced(plane, node.place, inside.index, piece)
    ways = [node.tangent]
    if aside is not None:
        ways.append(np.zeros(len(scale)))
        ways[-1][[inside.index, -2, -1]] = aside
    away = settings.beside
    while away >= settings.nearest:
        for way in ways:
            guess = plane.moved(start, away * way * scale)
            value = guess.orbit.images[inside.index].margin(inside.code) if guess.defined else -1.0
            if not value > 0.0:
                continue
            apart = held(Margin(inside.index, inside.code, value), plane)
            solution = solve(plane, guess, [*locus.equations(plane), apart])
            found = solution.place
            off = float(np.abs((found.point - node.place.point) / scale).max())
            if not (solution.converged and off <= FAR * away and is_inside(plane, locus, found)):
                continue
            along = tangent(plane, found, locus)
            if np.isfinite(along).all():
                gradient = found.gradient(inside.index, inside.code)
                rate = gradient @ (along * scale)[[inside.index, -2, -1]]
                return node_at(plane, locus, found, along if rate > 0.0 else -along)
        away *= settings.numerics.restart
    return None


def _like_a_tangent(
    plane: Plane, locus: Locus, node: Node, border: Border, inside: Margin
) -> Node | None:
    """The first node of folds or flips that leave a border like a tangent, beside a root.

    A step from the border they are at its cube, more or less, from it: a guess that is further away
    than that by much leads to nowhere.
    """
    settings, scale = plane.first, plane.scales(len(node.place))
    start = replaced(plane, node.place, inside.index, border.outer.piece)
    aside = np.zeros(len(scale))
    aside[inside.index] = border.side
    step = settings.again
    while step >= settings.nearest:  # ten times shorter each time, and so is ``away``
        ahead = Along(node.place.point, node.tangent, step, scale)
        away = settings.numerics.nearer * step
        while away >= settings.nearest:
            guess = plane.moved(start, (step * node.tangent + away * aside) * scale)
            away *= settings.numerics.nearer
            if not guess.defined:
                continue
            solution = solve(plane, guess, [*locus.equations(plane), ahead], contracts=True)
            along = tangent(plane, solution.place, locus) if solution.converged else node.tangent
            turned = abs(float(along @ node.tangent))
            if (
                solution.converged
                and turned >= settings.numerics.same_way
                and is_inside(plane, locus, solution.place)
            ):
                along = along if along @ node.tangent > 0.0 else -along
                return node_at(plane, locus, solution.place, along)
        step *= settings.numerics.nearer
    return None


@dataclass(frozen=True, slots=True, eq=False)
class _Wedge:
    """The piece of a map beside a corner, inside one border and outside another one.

    Attributes
    ----------
    piece
        The piece.
    way
        (3,) a direction into it, in scaled x and parameters, at the rate 1 from both borders.
    """

    piece: Piece
    way: Floats


def _wedge(plane: Plane, place: Place, i: int, first: Floats, second: Floats) -> _Wedge | str:
    """The piece inside of the first border and outside of the second; why, if there is none."""
    rows = np.array([_unit(first), _unit(second)])
    way: Floats = np.linalg.pinv(rows) @ np.array([1.0, -1.0])
    away, reason = plane.first.beside, ""
    while away >= plane.first.nearest:
        x, values = _shifted(plane, place, i, away * way)
        image = plane.map(values).at(x, values[0])
        if not image.reason:
            return _Wedge(image.piece, way)
        away, reason = away * plane.first.numerics.nearer, image.reason
    return reason


def _right_inside(plane: Plane, place: Place, i: int, wedge: _Wedge) -> Place:
    """The corner, seen from a piece beside it, which rounding may deny right there.

    At a grazing the root is a double one, and what is left of its discriminant may be negative.
    Then it is seen from as few roundings inside as are needed; the root is off by the root of them.
    """
    aside = np.zeros(len(place) + 2)
    aside[[i, -2, -1]] = wedge.way * plane.scales(1)
    start, away = replaced(plane, place, i, wedge.piece), SPACING
    there = start
    while not there.defined and away < plane.first.nearest:  # doubled
        away *= 2.0
        there = plane.moved(start, away * aside)
    return there


def _shifted(plane: Plane, place: Place, i: int, way: Floats) -> tuple[float, Pair]:
    """A point of an orbit and the parameters, shifted in scaled units."""
    dx, dp, dq = (way * plane.scales(1)).tolist()
    return float(place.orbit.x[i]) + dx, (place.values[0] + dp, place.values[1] + dq)


def _agree(plane: Plane, place: Place, i: int, wedge: _Wedge) -> bool:
    """Whether two pieces have the same slope at their border: closer to it they differ by less."""
    inner, settings = place.orbit.pieces[i], plane.first
    off = list[float]()
    for away in (settings.beside, settings.numerics.restart * settings.beside):
        x, values = _shifted(plane, place, i, away * wedge.way)
        map_ = plane.map(values)
        slopes = [
            plane.family.carried(piece, map_).at(x, values[0]).slope
            for piece in (inner, wedge.piece)
        ]
        off.append(abs(slopes[1] - slopes[0]) / max(1.0, *map(abs, slopes)))
    return off[1] <= max(settings.kink, SHRINKS * off[0])


def _parallel(one: Floats, other: Floats) -> bool:
    return float(np.linalg.norm(np.cross(one, other))) <= PARALLEL


def _unit(vector: Floats) -> Floats:
    size = float(np.linalg.norm(vector))
    return vector / size if size else vector
