"""Where a margin vanishes between two samples of a branch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from woodpecker.base.cubics import zero_of_cubic
from woodpecker.piecewise.corrector import Corrector
from woodpecker.piecewise.margins import depth, lowest_dip
from woodpecker.piecewise.orbits import SPACING, Margin, Orbit, scales, solve
from woodpecker.piecewise.pieces import Image, Piece
from woodpecker.piecewise.samples import Sample, Stop
from woodpecker.piecewise.stops import Ending, UnclearError, ending_at


def at_border(corrector: Corrector, a: Sample, b: Sample, step: float) -> list[Ending]:
    """Where the first margin vanishes between two samples; UnclearError if that is not clear."""
    crossed = _crossed(corrector, a, b)
    if not crossed:
        _look_for_dips(corrector, a, b, step)
        return []
    margin, part = min(crossed, key=lambda each: each[1])
    found = _located(corrector, a, b, step, margin, part)
    _look_for_dips(corrector, a, found.sample, found.distance, margin)
    return [found]


def is_first(corrector: Corrector, ending: Ending) -> bool:
    """Whether no margin but those of an ending has vanished before it.

    One that the far end of the step does not have is not seen to change its sign on the way.
    """
    least = corrector.settings.thinnest
    own = {(margin.index, margin.code) for margin in ending.margins}
    for i, image in enumerate(ending.sample.orbit.images):
        if corrector.on_border(i):
            continue
        (code,) = [c for k, c in own if k == i] or [-1]
        if depth(image, code) < -least:
            return False
    return True


def _crossed(corrector: Corrector, a: Sample, b: Sample) -> list[tuple[Margin, float]]:
    """Margins that are positive at a and negative at b, and where they vanish in between.

    As a part of the way, by cubics. UnclearError if one of them was not there at a.
    """
    found = []
    scale = scales(len(a.orbit), corrector.settings)
    length = float(np.linalg.norm((b.orbit.point - a.orbit.point) / scale))
    rates = a.tangent * scale * length, b.tangent * scale * length
    for i, (one, other) in enumerate(zip(a.orbit.images, b.orbit.images, strict=True)):
        for code in other.causes[other.margins < 0.0].tolist():
            if corrector.on_border(i) and Margin(i, code) == corrector.closing:
                continue
            before, after = one.margin(code), other.margin(code)
            if not before > 0.0:
                raise UnclearError
            slopes = (
                float(image.gradient(code) @ rate[[i, -1]])
                for image, rate in zip((one, other), rates, strict=True)
            )
            found.append((Margin(i, code), zero_of_cubic(before, after, *slopes)))
    return found


def _located(
    corrector: Corrector, a: Sample, b: Sample, step: float, margin: Margin, part: float
) -> Ending:
    """Where a margin vanishes, about a part of the way; UnclearError if another does so before."""
    guess = corrector.between(a, b, part)
    solution = solve(guess, (corrector.closing, margin), corrector.settings)
    if solution.converged and not _joins(corrector, a, solution.orbit, margin):
        inside = _just_inside(corrector, a, margin)
        solution = solve(a.orbit, (corrector.closing, inside), corrector.settings)
        if not _joins(corrector, a, solution.orbit, margin):
            raise UnclearError
    if not solution.converged:
        raise UnclearError
    softened = _softened(corrector, solution.orbit, margin)
    ending = ending_at(corrector, a, step, Stop.BORDER, softened, (margin,))
    if ending is None:
        raise UnclearError
    if step > corrector.settings.again and _rises(corrector, ending.sample, margin):
        raise UnclearError  # it has vanished before, and is back: the branch comes from beyond
    return ending


def _look_for_dips(
    corrector: Corrector, a: Sample, b: Sample, step: float, own: Margin | None = None
) -> None:
    """UnclearError if a margin, but one that vanishes at the second of two samples, may dip."""
    scale, numerics = scales(len(a.orbit), corrector.settings), corrector.settings.numerics
    ends, trusted = (a.tangent * scale, b.tangent * scale), step <= numerics.blurred
    if step <= 0.0 or (corrector.order and trusted):
        return  # where a jump is does not depend on how often its piece changes
    for i, (one, other) in enumerate(zip(a.orbit.images, b.orbit.images, strict=True)):
        along, there = (np.array([end[i], end[-1]]) for end in ends)
        for margin in (own, corrector.closing):
            if isinstance(margin, Margin) and margin.index == i:
                one, other = one.without(margin.code), other.without(margin.code)
        if lowest_dip(one, other, step, along, there, numerics, trusted) is not None:
            raise UnclearError


def _rises(corrector: Corrector, sample: Sample, margin: Margin) -> bool:
    """Whether a margin grows along a branch."""
    along = sample.tangent * scales(len(sample.orbit), corrector.settings)
    return float(margin.row(sample.orbit) @ along) > 0.0


def _joins(corrector: Corrector, a: Sample, orbit: Orbit, margin: Margin) -> bool:
    """Whether a piece has the same value at a border as right inside of it.

    Where two of its solutions meet at the border, as at a square root, rounding may lead to the
    other one there.
    """
    image = orbit.images[margin.index]
    there = _inside(corrector, orbit, margin, a.orbit.images[margin.index].piece)
    steepest = max(abs(there.slope), abs(image.slope))
    rise = 2.0 * corrector.settings.numerics.strays * corrector.settings.resolved * steepest
    slack = rise + corrector.settings.same * corrector.settings.x_scale
    return bool(there.reason) or not abs(there.value - image.value) > slack


def _just_inside(corrector: Corrector, a: Sample, margin: Margin) -> Margin:
    """A margin that is positive, by more than its rounding."""
    gradient = np.abs(a.orbit.images[margin.index].gradient(margin.code))
    size = gradient @ [corrector.settings.x_scale, corrector.settings.p_scale]
    return replace(margin, value=corrector.settings.numerics.noise * SPACING * float(size))


def _softened(corrector: Corrector, orbit: Orbit, margin: Margin) -> Orbit:
    """An orbit at a border, with the slopes right beside it if those at it are others.

    Where a time goes like a root of the distance the slope at the border is made of rounding,
    even where the map is smooth.
    """
    i, image = margin.index, orbit.images[margin.index]
    there = _inside(corrector, orbit, margin, image.piece)
    size = corrector.settings.kink * max(1.0, abs(image.slope), abs(there.slope))
    if there.reason or abs(there.slope - image.slope) <= size:
        return orbit
    image = image._replace(slope=there.slope, d_parameter=there.d_parameter)
    return Orbit(orbit.x, orbit.p, (*orbit.images[:i], image, *orbit.images[i + 1 :]))


def _inside(corrector: Corrector, orbit: Orbit, margin: Margin, piece: Piece) -> Image:
    """The image right inside of a border that an orbit meets."""
    away = orbit.images[margin.index].onward(margin.code) * corrector.settings.resolved
    return piece.at(float(orbit.x[margin.index]) - away, orbit.p)
