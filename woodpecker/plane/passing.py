"""How a curve goes on where a cycle meets a border besides the one that it lies on."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pwmap.diagrams.diagram import PointKind
from pwmap.plane.kinds import PlaneKind
from woodpecker.base.arrays import Floats
from woodpecker.engine.curves import Arc, Sample, SolutionCurve, Stop
from woodpecker.engine.germs import SAME, is_inside
from woodpecker.engine.maps import ACCUMULATE, Image
from woodpecker.engine.newton import Problem, across, solve
from woodpecker.engine.orbits import Held, Multiplier, OnBorder, Orbit
from woodpecker.engine.rooted import ROOTED
from woodpecker.plane.maps import Plane, over_first
from woodpecker.plane.nodes import PARALLEL, border_in, curve_of, is_steep, units
from woodpecker.slices.borders import Border, BorderKind

# Part to which a difference of slopes falls, a hundred times closer to a border, if it is none
# right there: a cube root falls to a fifth.
SHRINKS = 0.5
CLOSER = 0.01  # times ``beside``: where such slopes are compared again
# Part by which a multiplier changes beyond a border only if the slopes differ: over the distance of
# a restart it changes by some 1e-4.
TORN = 0.01
BESIDE = (2.0**-24, 2.0**-20, 2.0**-28, 2.0**-34, 2.0**-40)  # scaled: where a curve goes on
CONTACT = 1e-6  # scaled: a border that steps become too short at is no farther away
CLEAR = 1e-11  # scaled: nearer to a border slopes are made of rounding
NO_CURVE = "no curve beyond"


@dataclass(frozen=True, slots=True, eq=False)
class Passed:
    """What a curve does at a second border.

    Attributes
    ----------
    kind
        What it is; None if only words change.
    curve, sample
        Where it goes on; None if it ends.
    cause
        What the second border does to the map, if the curve ends.
    """

    kind: PlaneKind | None
    curve: SolutionCurve | None = None
    sample: Sample | None = None
    cause: str = ""


def passed(plane: Plane, arc: Arc) -> Passed:
    """How a curve goes on at the end of an arc, where a second margin vanishes."""
    assert arc.border is not None
    i, code = arc.border
    own, end, meeting = border_in(arc.curve), arc.samples[-1], _meeting(arc.curve)
    if own is not None and own.image == i:
        return _round_corner(plane, arc, own, code)
    orbit = end.orbit
    image = orbit.images[i]
    outer = plane.map.beside(orbit.x[i], orbit.p, -image.gradients[image.place(code)])
    if outer.reason:
        return _lost(outer, meeting)
    kind = _kind(plane, orbit, i, code, outer)
    smooth = is_steep(arc.curve)
    if kind is BorderKind.JUMP or (
        kind is not BorderKind.SMOOTH and smooth and _tears(plane, image, outer)
    ):
        return Passed(meeting, cause=kind.value)
    codes = outer.codes[outer.tied(orbit.x[i], orbit.p)].tolist()
    there = replace(orbit, images=(*orbit.images[:i], outer, *orbit.images[i + 1 :]))
    on = _onward(arc.curve, there, end.tangent, i, codes)
    if on is None:
        return Passed(meeting, cause=NO_CURVE)
    marked = kind is BorderKind.SMOOTH or own is None
    return Passed(None if marked else meeting, arc.curve, on)


def sharpened(plane: Plane, arc: Arc) -> Arc:
    """An arc that ends at a border, with the derivatives right inside it at its end.

    Where a time goes like a root of the distance those right at the border are made of rounding.
    """
    if arc.border is None or len(arc.samples) < 2:
        return arc
    before, end = arc.samples[-2:]
    i, orbit = arc.border[0], end.orbit
    image = orbit.images[i]
    usual = max(1.0, float(np.abs(before.orbit.images[i].jacobian).max()))
    if not float(np.abs(image.jacobian).max()) > ROOTED * usual:
        return arc
    on = border_in(arc.curve)
    zero = {arc.border[1]} | ({on.code} if on is not None and on.image == i else set())
    rows = image.gradients[[image.place(code) for code in zero]] * plane.scale
    inward = units(rows).sum(axis=0)
    own = plane.map.beside(orbit.x[i], orbit.p, inward * plane.scale)
    if own.reason or own.piece.key != image.piece.key:
        return arc
    images = (*orbit.images[:i], own, *orbit.images[i + 1 :])
    last = arc.curve.start(replace(orbit, images=images), before.tangent)
    return replace(arc, samples=(*arc.samples[:-1], last))


def known(arc: Arc) -> Sequence[Sample]:
    """The samples of an arc but those at its end that are made of rounding, beside a border."""
    count = len(arc.samples)
    if is_steep(arc.curve) and arc.stop in (Stop.SHORT, Stop.OTHER_PIECE):
        while count > 1:
            near = _nearest_margin(arc.curve.problem, arc.samples[count - 1].orbit)
            if near is None or near[2] >= CLEAR:
                break
            count -= 1
    return arc.samples[:count]


def mirrored(plane: Plane, arc: Arc) -> Passed | None:
    """How folds or flips go on whose steps become too short beside a border; None if they do not.

    Where slopes go like the cube root of the distance from a border, folds and flips come to it
    like a tangent, with a contact of third order, and leave it with the piece on the other side as
    they have come: as far from the contact as a sample on this side lies, about where its margin
    has the same value.
    """
    curve, last = arc.curve, arc.samples[-1]
    near = _nearest_margin(curve.problem, last.orbit)
    if not is_steep(curve) or near is None or near[2] > CONTACT:
        return None
    i, code, _ = near
    x, p, image = last.orbit.x[i], last.orbit.p, last.orbit.images[i]
    outer = plane.map.beside(x, p, -image.gradients[image.place(code)])
    tied = [] if outer.reason else outer.codes[outer.tied(x, p)].tolist()
    if not tied or _kind(plane, last.orbit, i, code, outer) is BorderKind.JUMP:
        return None
    images = (*last.orbit.images[:i], outer, *last.orbit.images[i + 1 :])
    beyond, border = replace(last.orbit, images=images), OnBorder(i, tied[0])
    at = plane.curve(border).start(beyond, last.tangent)  # it is a tangent of both
    for sample in arc.samples[-2::-1]:
        own = sample.orbit.images[i]
        if own.place(code) < 0:
            break
        if _distance(curve.problem, sample.orbit, i, code) < CLEAR:
            continue
        margin = OnBorder(i, tied[0], float(own.margins[own.place(code)]))
        way = curve.problem.step_between(sample.orbit, last.orbit)
        on = _mirrored(curve, at, float(way @ at.tangent), margin)
        if on is not None:
            return Passed(None, curve, on, image.piece.cause(code))
    return None


def _nearest_margin(problem: Problem, orbit: Orbit) -> tuple[int, int, float] | None:
    """The margin nearest to vanishing: image, code, and how far away that is in scaled unknowns."""
    best, scale = (math.inf, 0, 0), np.array([*problem.x_scale, *problem.p_scale])
    for i, image in enumerate(orbit.images):
        size = np.linalg.norm(image.gradients * scale, axis=1)
        for margin, most, code in zip(image.margins, size, image.codes.tolist(), strict=True):
            if most > 0.0:
                best = min(best, (abs(float(margin)) / float(most), i, code))
    return None if best[0] == math.inf else (best[1], best[2], best[0])


def _distance(problem: Problem, orbit: Orbit, i: int, code: int) -> float:
    """How far away a border is where a margin vanishes, to first order, in scaled unknowns."""
    image, scale = orbit.images[i], np.array([*problem.x_scale, *problem.p_scale])
    k = image.place(code)
    return float(abs(image.margins[k]) / np.linalg.norm(image.gradients[k] * scale))


def _mirrored(curve: SolutionCurve, at: Sample, length: float, margin: OnBorder) -> Sample | None:
    """The sample at a distance beyond a contact, about where a margin has a value; None if none is.

    There Newton's method begins: where the margin has a value the multiplier changes slowly.
    """
    problem, ahead = curve.problem, across(curve.problem, at.orbit, at.tangent, length)
    beside = replace(problem, conditions=(problem.conditions[0], margin, ahead))
    guess = solve(beside, problem.moved(at.orbit, length * at.tangent))
    found = solve(problem.with_(ahead), guess.orbit)
    if not (guess.converged and found.converged):
        return None
    sample = curve.start(found.orbit, at.tangent)
    turned = float(sample.tangent @ at.tangent) < math.cos(curve.settings.max_turn)
    return sample if not turned and _is_within(curve, sample) else None


def _meeting(curve: SolutionCurve) -> PlaneKind:
    """What it is where a curve meets a border."""
    condition = curve.problem.conditions[1]
    if isinstance(condition, OnBorder):
        return PlaneKind.TWO_BORDERS
    if isinstance(condition, Held):
        return PlaneKind.END
    assert isinstance(condition, Multiplier)
    return PlaneKind.FOLD_BORDER if condition.kind == PointKind.LP else PlaneKind.FLIP_BORDER


def _lost(outer: Image, meeting: PlaneKind) -> Passed:
    """The end of a curve beyond which the map has no image, or no piece infinitesimally near."""
    kind = meeting if outer.reason == ACCUMULATE else PlaneKind.DOMAIN
    return Passed(kind, cause=outer.reason)


def _kind(plane: Plane, orbit: Orbit, i: int, code: int, outer: Image) -> BorderKind:
    """What the map does at a border."""
    inner, beyond = over_first(orbit.images[i]), over_first(outer)
    zero = outer.codes[outer.tied(orbit.x[i], orbit.p)].tolist()
    x, side = float(orbit.x[i, 0]), inner.onward(code)
    border = Border(x, float(orbit.p[0]), inner, code, side, beyond, zero[0] if zero else -1)
    return border.kind(plane.first)


def _tears(plane: Plane, inner: Image, outer: Image) -> bool:
    """Whether the multiplier of a cycle is another one beyond a border.

    Beside a root slopes at the border are good to half of the digits only.
    """
    one, other = (float(each.jacobian[0, 0]) for each in (inner, outer))
    return not abs(other - one) <= TORN * max(1.0, abs(one), abs(other))


def _round_corner(plane: Plane, arc: Arc, own: OnBorder, code: int) -> Passed:
    """The same where both borders bound one piece.

    Its neighbour beyond the second one may have the first one too: it lies where the first margin
    is positive and the second one negative.
    """
    end, meeting, i = arc.samples[-1], PlaneKind.TWO_BORDERS, own.image
    orbit = end.orbit
    inner, x, p = orbit.images[i], orbit.x[i], orbit.p
    first, second = (
        units(inner.gradients[[inner.place(each)]] * plane.scale)[0] for each in (own.code, code)
    )
    way = np.linalg.pinv(np.array([first, second])) @ np.array([1.0, -1.0])
    outer = plane.map.beside(x, p, way * plane.scale)
    if outer.reason:
        return _lost(outer, meeting)
    if not arc.curve.problem.same(inner.value, outer.value, SAME):
        return Passed(meeting, cause=BorderKind.JUMP.value)
    codes = outer.codes[outer.tied(x, p)].tolist()
    ahead = {each: units(outer.gradients[[outer.place(each)]] * plane.scale)[0] for each in codes}
    shared = min(codes, key=lambda each: float(ahead[each] @ second), default=-1)
    rest = [each for each in codes if each != shared]
    following = max(rest, key=lambda each: float(ahead[each] @ first), default=-1)
    if following < 0:
        return Passed(meeting, cause="the border ends")
    there = replace(orbit, images=(*orbit.images[:i], outer, *orbit.images[i + 1 :]))
    curve = curve_of(plane, OnBorder(i, following), there)
    on = _onward(curve, there, end.tangent, i, [shared])
    if on is None:
        return Passed(meeting, cause=NO_CURVE)
    parallel = float(np.linalg.norm(np.cross(ahead[following], first))) <= PARALLEL
    smooth = parallel and _agree(plane, orbit, i, outer, way)
    return Passed(None if smooth else meeting, curve, on)


def _agree(plane: Plane, orbit: Orbit, i: int, outer: Image, way: Floats) -> bool:
    """Whether two pieces have the same slope at their border: closer to it they differ by less."""
    settings, inner = plane.first, orbit.images[i]
    at, off = np.append(orbit.x[i], orbit.p), list[float]()
    for away in (settings.beside, CLOSER * settings.beside):
        to = at + away * way * plane.scale
        there = (each.piece.at(to[:1], to[1:]) for each in (inner, outer))
        one, other = (float(each.jacobian[0, 0]) for each in there)
        off.append(abs(other - one) / max(1.0, abs(one), abs(other)))
    return off[1] <= max(settings.kink, SHRINKS * off[0])


def _onward(
    curve: SolutionCurve, there: Orbit, like: Floats, i: int, codes: list[int]
) -> Sample | None:
    """The first sample beyond a border, right at it or beside it; None if there is none.

    Right at a border slopes may be those of a root: folds and flips go on beside it.

    Parameters
    ----------
    curve
        The curve that goes on.
    there
        The orbit at the border, with the piece beyond.
    like
        The tangent along which the border is met.
    i, codes
        Which of its margins vanish there, and become positive.
    """
    for start in _starts(curve, there, like):
        if not _grows(curve, start, i, codes):
            continue
        if not is_steep(curve) and is_inside(curve, start):
            return start
        for away in BESIDE:
            found = curve.advance(start, away)
            if found is not None and _is_within(curve, found):
                return found
    return None


def _starts(curve: SolutionCurve, there: Orbit, like: Floats) -> Iterator[Sample]:
    """The orbit with its tangent, first the way that another one leads."""
    start = curve.start(there, like)
    if np.isfinite(start.tangent).all():
        yield start
        yield start.turned


def _grows(curve: SolutionCurve, start: Sample, i: int, codes: list[int]) -> bool:
    """Whether margins become positive from a start on."""
    return all(curve.rate(start, i, code) > 0.0 for code in codes if (i, code) not in curve.ignored)


def _is_within(curve: SolutionCurve, sample: Sample) -> bool:
    """Whether no margin is negative but those that vanish all along a curve."""
    orbit = sample.orbit
    return not any(
        (i, code) not in curve.ignored
        for i, image in enumerate(orbit.images)
        for code in image.codes[(image.margins < 0.0) & ~image.tied(orbit.x[i], orbit.p)].tolist()
    )
