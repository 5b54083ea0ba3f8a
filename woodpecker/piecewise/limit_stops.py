"""Where a limit of a jump meets the diagonal or a border between two samples of its branch."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from woodpecker.piecewise.corrector import Corrector
from woodpecker.piecewise.margins import depth
from woodpecker.piecewise.orbits import Closed, Margin, Orbit, Solution, between, orbit_of, solve
from woodpecker.piecewise.samples import Sample, Stop
from woodpecker.piecewise.stops import Ending, UnclearError, ending_at


def at_diagonal(corrector: Corrector, a: Sample, b: Sample, step: float) -> list[Ending]:
    """Where a limit of a jump meets the diagonal: there the orbit of the jump closes."""
    if a.jump is None:
        return []
    found = []
    for inner, before in zip((True, False), a.jump.offsets, strict=True):
        one = a.jump.cycle(inner)
        other = continued(one, b.orbit)
        after = other.images[-1].value - float(other.x[0])
        if not before * after < 0.0:
            continue
        guess = between(one, other, before / (before - after))
        margin = Margin(len(a.orbit) - 1, a.jump.code(inner))
        border = a.jump.at_border(inner, corrector.settings)
        solution = solve(guess, (Closed(), border), corrector.settings)
        ending = _at_head(corrector, a, step, Stop.LIMIT, solution, inner, (margin,))
        if ending is None and not math.isfinite(one.images[-1].slope):
            ending = _closing(corrector, a, step, inner, margin)
        if ending is None:
            raise UnclearError
        found.append(ending)
    return found


def _closing(
    corrector: Corrector, a: Sample, step: float, inner: bool, margin: Margin
) -> Ending | None:
    """Where a limit meets the diagonal whose slope at its border is infinite, as at a root.

    Newton's method for the cycle would need that slope; its limit along the branch is smooth.
    """

    def at(distance: float) -> Sample:
        sample = corrector.advance(a, distance) if distance else a
        if not isinstance(sample, Sample) or sample.jump is None:
            raise UnclearError
        return sample

    def offset(distance: float) -> float:
        jump = at(distance).jump
        assert jump is not None
        return jump.offsets[0 if inner else 1]

    if not offset(0.0) * offset(step) < 0.0:
        return None
    distance = float(brentq(offset, 0.0, step, xtol=corrector.settings.min_step))
    sample = at(distance)
    assert sample.jump is not None
    cycle = sample.jump.cycle(inner)
    return Ending(Stop.LIMIT, sample, distance, (margin,), inner=inner, meeting=cycle)


def still_crosses(corrector: Corrector, a: Sample, ending: Ending) -> bool:
    """Whether a jump crosses the diagonal until right before an ending.

    Where borders follow each other closely a limit may have met the diagonal unseen.
    """
    before = ending.distance * (1.0 - corrector.settings.numerics.right_before)
    if ending.stop is Stop.LIMIT or before < corrector.settings.min_step:
        return True
    sample = corrector.advance(a, before)
    return isinstance(sample, Sample) and sample.jump is not None and sample.jump.crosses


def at_tails(corrector: Corrector, a: Sample, b: Sample, step: float) -> list[Ending]:
    """Where the orbit of a limit meets a border."""
    if a.jump is None or b.jump is None:
        return []
    found = []
    for inner in (True, False):
        one, other = (j.inner if inner else j.outer for j in (a.jump, b.jump))
        if one.keys == other.keys:
            continue
        ending = _at_tail(corrector, a, b, step, inner)
        if ending is not None:
            found.append(ending)
        elif step > corrector.settings.numerics.blurred or not b.jump.crosses:
            raise UnclearError
    return found


def _at_tail(corrector: Corrector, a: Sample, b: Sample, step: float, inner: bool) -> Ending | None:
    """Where the orbit of a limit meets a border."""
    assert a.jump is not None
    k, there = len(a.orbit), a.jump.cycle(inner)
    far = continued(there, b.orbit)
    found = None
    for i in range(k - 1, len(far)):
        own = a.jump.code(inner) if i == k - 1 else -1
        one, other = there.images[i], far.images[i]
        fallen = [c for c in other.causes[other.margins < 0.0].tolist() if c != own]
        fallen = [c for c in fallen if one.margin(c) > 0.0]
        if fallen:
            found = Margin(i, fallen[0])
            break
    if found is None:
        return None
    n, before, after = (
        found.index + 1,
        there.images[found.index].margin(found.code),
        far.images[found.index].margin(found.code),
    )
    guess = between(there.head(n), far.head(n), before / (before - after))
    border = a.jump.at_border(inner, corrector.settings)
    solution = solve(guess, (border, found), corrector.settings)
    ending = _at_head(corrector, a, step, Stop.TAIL, solution, inner, (found,))
    if ending is None or ending.distance <= -corrector.settings.nearest:
        return None  # it is the one that the branch has just passed
    return ending


def _holds(corrector: Corrector, orbit: Orbit, border: int, margin: Margin) -> bool:
    """Whether the orbit of a limit lies inside of its pieces, but where it meets borders."""
    least = corrector.settings.thinnest
    for i, image in enumerate(orbit.images):
        if i == border:  # two margins may vanish there: the nearest is that of the border
            away = image.margins + least * np.abs(image.gradients[:, 0])
            if (away < 0.0).any():
                return False
        elif depth(image, margin.code if i == margin.index else -1) < -least:
            return False
    return True


def _at_head(
    corrector: Corrector, a: Sample, step: float, stop: Stop, solution: Solution, inner: bool,
    margins: tuple[Margin, ...],
) -> Ending | None:  # fmt: skip
    """What a limit meets, as the border orbit that leads there; None if a piece ends before."""
    orbit, k = solution.orbit, len(a.orbit)
    if not solution.converged or not _holds(corrector, orbit, k - 1, margins[-1]):
        return None
    head = orbit_of(a.orbit.pieces, orbit.x[:k], orbit.p)
    ending = ending_at(corrector, a, step, stop, head, margins)
    return None if ending is None else replace(ending, inner=inner, meeting=orbit)


def continued(cycle: Orbit, head: Orbit) -> Orbit:
    """The orbit that starts like ``head`` and goes on with the pieces of a longer one.

    It ends where a piece has no value.
    """
    x, images = list(head.x.tolist()), list(head.images[:-1])
    for piece in cycle.pieces[len(head) - 1 :]:
        images.append(piece.at(x[-1], head.p))
        if images[-1].reason or len(images) == len(cycle):
            break
        x.append(images[-1].value)
    return Orbit(np.array(x), head.p, tuple(images))
