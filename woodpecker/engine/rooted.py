"""The exact place where a curve ends at a border, and the image that the map has beyond.

Where an event time has a root singularity, slopes at the border are rounding errors, and a cycle
there is known to their root only. The limit of the root, or the piece beyond, locates it better.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from woodpecker.base.arrays import Floats, norm
from woodpecker.engine.curves import SAME_END, Arc, Sample, SolutionCurve, Stop, nearest_border
from woodpecker.engine.maps import (
    ACCUMULATE,
    LARGE_SLOPE,
    LIMIT_DISTANCE,
    SpaceImage,
    limit,
    root_of,
)
from woodpecker.engine.newton import MAP_ROUNDING, SOLVED, STEEP, newton_step, solve
from woodpecker.engine.orbits import OnBorder, SpaceOrbit

ROOTED = 10.0  # times the slopes beyond: larger slopes at a border are those of a root singularity
ALONG_BORDER = 2.0**-10  # scaled: how far a branch may run along a border before it meets it
WIDEST = 0.1  # scaled: the largest error that rounding of the border may leave in a limit


def extended_to_root(arc: Arc, within: float) -> Arc | None:
    """Extend an arc to the root singularity that it approaches; None if that is not close.

    Towards it steps become ever shorter, because the piece has no value beyond its border. The
    piece on the other side locates that border.
    """
    # Slopes grow monotonically until there, so that no fold or flip can be missed.
    curve, problem = arc.curve, arc.curve.problem
    if len(arc.samples) < 2 or arc.samples[-1].orbit.outer is not None:
        return None
    (before, last), d = arc.samples[-2:], len(problem.x_scale)
    away, i, code = nearest_border(curve, last.orbit)
    if away > within or not _grows(before.orbit, last.orbit, i):
        return None
    orbit, image = last.orbit, last.orbit.images[i]
    k = image.index_of(code)
    inward = image.gradients[k]
    x = orbit.x.copy()
    x[i] -= image.margins[k] * inward[:d] / (inward[:d] @ inward[:d])
    outer = curve.map.beside(x[i], orbit.p, -inward)
    if outer.reason or not is_steep(image, outer):
        return None
    on_border = replace(last, orbit=replace(orbit, x=x))
    ended = Arc(
        (*arc.samples, on_border), Stop.BORDER, curve, (i, code), condition=OnBorder(i, code)
    )
    moved, _ = _moved_to(ended, i, outer)
    way = problem.step_between(orbit, moved.samples[-1].orbit)
    if moved is ended or not float(way @ last.tangent) > 0.0 or norm(way) > within:
        return None
    end = moved.samples[-1].orbit
    beyond = outer.piece.at(end.x[i], end.p)
    if ((beyond.margins < 0.0) & ~beyond.tied(end.x[i], end.p)).any():
        return None  # another margin vanishes before
    margins = image.margins.copy()
    margins[k] = 0.0
    reached = end.with_image(i, end.images[i]._replace(margins=margins))
    return replace(moved, samples=(*arc.samples, replace(last, orbit=reached)))


def _grows(before: SpaceOrbit, last: SpaceOrbit, i: int) -> bool:
    """Whether the largest slope of a piece exceeds 1 and grows along a curve."""
    return 1.0 < _steepest(before.images[i]) < _steepest(last.images[i])


def refined_end(arc: Arc) -> tuple[Arc, SpaceImage | None]:
    """Refine the end of an arc from both sides of its border; for cycles, with the image beyond."""
    if arc.stop is not Stop.BORDER:
        return arc, None
    assert arc.border is not None
    i, code = arc.border
    orbit = arc.samples[-1].orbit
    if orbit.outer is not None and i >= len(orbit.x) - 1:  # the border of the jump itself
        return arc, None
    if orbit.outer is None and arc.curve.problem.steepest_scaled(orbit.images[i]) > LARGE_SLOPE:
        arc = _with_slopes_inside(arc, i)
        orbit = arc.samples[-1].orbit
    image = orbit.images[i]
    gradient = image.gradients[image.index_of(code)]
    outer = arc.curve.map.beside(orbit.x[i], orbit.p, -gradient)
    if orbit.outer is not None:
        is_root = not outer.reason and is_steep(image, outer)
        return _at_limit(arc, i, code) if is_root else arc, None
    is_reached = image.tied(orbit.x[i], orbit.p)[image.index_of(code)]
    if outer.piece.key == image.piece.key and not is_reached:  # no other piece begins
        outer = outer._replace(reason=outer.reason or ACCUMULATE)
    if outer.reason:
        return arc, outer
    if is_steep(arc.samples[-1].orbit.images[i], outer):
        moved, there = _moved_to(arc, i, outer)
        if moved is not arc:
            return moved, there
    return _at_limit(arc, i, code), outer


def _with_slopes_inside(arc: Arc, i: int) -> Arc:
    """The arc whose last image has the slopes of its piece right before, if these have a limit."""
    # Where a contact opens or closes with a law h^(3/2) they have one, but are rounded to 1e13.
    before, end, curve = arc.samples[-2:][0], arc.samples[-1], arc.curve  # there may be one sample
    x, p = end.orbit.x[i], end.orbit.p
    back = np.concatenate((before.orbit.x[i] - x, before.orbit.p - p))
    length = float(np.abs(back / curve.problem.lengths).max())
    if length == 0.0:
        return arc
    unit, d, piece = back / length, len(x), end.orbit.images[i].piece
    near = piece.at(x + LIMIT_DISTANCE * unit[:d], p + LIMIT_DISTANCE * unit[d:])
    if near.reason or not curve.problem.steepest_scaled(near) <= LARGE_SLOPE:
        return arc
    if root_of(piece, x, p, unit) is not None:
        return arc
    last = curve.start(end.orbit.with_image(i, limit(near, x, p, unit)), end.tangent)
    if not np.isfinite(last.tangent).all():
        return arc
    return replace(arc, samples=(*arc.samples[:-1], last))


def is_steep(inner: SpaceImage, outer: SpaceImage) -> bool:
    """Whether the slopes of an image are those of a root singularity that the other lacks."""
    return _steepest(inner) > ROOTED * max(1.0, _steepest(outer))


def _steepest(image: SpaceImage) -> float:
    return max(map(abs, image.jacobian[:, : len(image.value)].ravel().tolist()))


def _moved_to(arc: Arc, i: int, outer: SpaceImage) -> tuple[Arc, SpaceImage]:
    """The arc with its end where the piece beyond locates the root, and the image of that piece."""
    # The map is continuous there and the piece beyond is less steep, so that it rounds less.
    end, problem = arc.samples[-1], arc.curve.problem
    orbit = end.orbit
    codes = outer.codes[outer.tied(orbit.x[i], orbit.p)].tolist()
    if not codes:
        return arc, outer
    found = solve(problem.with_(OnBorder(i, codes[0])), orbit.with_image(i, outer))
    away = np.abs(problem.step_between(orbit, found.orbit)).max()
    is_there = away <= SAME_END or (
        away <= ALONG_BORDER and _runs_along_border(orbit, found.orbit, i)
    )
    if not (found.converged and is_there):
        return arc, outer
    value = found.orbit.images[i].value
    inner, outer = orbit.images[i]._replace(value=value), outer._replace(value=value)
    last = Sample(found.orbit.with_image(i, inner), end.tangent)
    return replace(arc, samples=(*arc.samples[:-1], last)), outer


def _at_limit(arc: Arc, i: int, code: int) -> Arc:
    """The arc with its end where the limit of its piece closes the orbit, if there is a root."""
    # The value is a + b h^s with a margin h that is a rounding error. The rest b h^s is the slope
    # times h, divided by s; without it, what remains is a, which changes along the border only.
    end, problem = arc.samples[-1], arc.curve.problem.with_(OnBorder(i, code))
    orbit, image = end.orbit, end.orbit.images[i]
    k = image.index_of(code)
    inward = image.gradients[k] / float(image.gradients[k] @ image.gradients[k])
    slope = image.jacobian @ inward
    left = float(image.margins[k]) * slope
    if problem.same(left, np.zeros(len(left)), SOLVED):
        return arc
    value = image.value - left / _exponent(arc.curve, orbit, i, inward)
    away = problem.apart(value, image.value)
    if not 0.0 < away < WIDEST:
        return arc
    along = image.jacobian - np.outer(slope, image.gradients[k])
    end_of_piece = image._replace(value=value, jacobian=along)
    step = newton_step(problem, orbit.with_image(i, end_of_piece))
    if not np.abs(step).max() <= max(SAME_END, ROOTED * away):
        return arc
    there = problem.moved(orbit, step)
    closed = image._replace(value=there.x[(i + 1) % len(there.x)])
    last = Sample(there.with_image(i, closed), end.tangent)
    return replace(arc, samples=(*arc.samples[:-1], last))


def _exponent(curve: SolutionCurve, orbit: SpaceOrbit, i: int, inward: Floats) -> float:
    """The exponent of the root singularity at a border point; infinite without one."""
    unit = inward / np.abs(inward / curve.problem.lengths).max()
    root = root_of(orbit.images[i].piece, orbit.x[i], orbit.p, unit)
    if root is None:  # in R^d three distances may not reveal it: assume a square root
        return 0.5 if orbit.x.shape[1] > 1 and _steepest(orbit.images[i]) > STEEP else math.inf
    return root.exponent


def _runs_along_border(end: SpaceOrbit, there: SpaceOrbit, i: int) -> bool:
    """Whether a branch between two points on a border is closer to it than doubles can tell."""
    # It may be so close long before it meets the border: the root is then all rounding halfway.
    x, p = 0.5 * (end.x[i] + there.x[i]), 0.5 * (end.p + there.p)
    between = end.images[i].piece.at(x, p)
    if between.reason:  # beyond the border, by rounding
        return bool((between.tied(x, p) | (between.margins > 0.0)).all())
    steep = float(np.abs(end.images[i].jacobian[:, : len(x)]).max())
    off = np.abs(between.value - 0.5 * (end.images[i].value + there.images[i].value)).max()
    return bool(off <= MAP_ROUNDING * steep * max(1.0, float(np.abs(x).max())))
