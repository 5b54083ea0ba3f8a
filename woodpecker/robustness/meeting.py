"""What a motion meets on a line from the toy."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from pwmap.diagrams.diagram import PointKind, PointStatus
from woodpecker.base.arrays import Floats
from woodpecker.base.settings import Settings
from woodpecker.engine.line import LinePiece
from woodpecker.engine.orbits import Condition, Multiplier, OnBorder, SpaceOrbit, orbit_of
from woodpecker.robustness.changes import FARTHEST, Space
from woodpecker.robustness.found import Effect
from woodpecker.robustness.lines import ToyLine
from woodpecker.search.curves import BranchCurve, Followed
from woodpecker.search.ends import End
from woodpecker.search.tasks import Tasks
from woodpecker.slices import orbits

MANY = 64  # changes on a line after which it is left: words change without end there
SPIKE = 1e-4  # of a change: where a motion is unstable for less it is so in a spike only
WORD = "word"  # the kind of a border that is no special point


Key = tuple[Effect, str, str]
"""The same for the same condition."""


@dataclass(frozen=True, slots=True, eq=False)
class MetOnLine:
    """A special point, or a change of word, on a line from the toy."""

    effect: Effect
    kind: str
    cause: str
    u: Floats  # the change
    orbit: SpaceOrbit  # the cycle there, with the pieces before it, seen along the line
    condition: Condition | None  # what vanishes there; None where nothing is known that does
    stable: bool = True  # whether the motion is stable up to there

    @property
    def size(self) -> float:
        """Length of the change."""
        return float(np.linalg.norm(self.u))

    @property
    def key(self) -> Key:
        """Equal for places of the same condition."""
        return self.effect, self.kind, self.cause


def met_along(
    space: Space, direction: Floats, most: float = FARTHEST, *, past: bool = True
) -> list[MetOnLine]:
    """Everything that a motion meets on a line, in order, until it is destroyed.

    If ``past``, it is followed on beyond what only makes it unstable.
    """
    # At a grazing the multiplier has no bound, and the motion flips right before: it is unstable in
    # a spike only.
    direction = direction / np.linalg.norm(direction)
    reach = min(most, space.reach(direction))
    if not reach > 0.0:
        return []
    line = space.line(np.zeros(len(direction)), direction)
    settings = replace(space.settings, span=(0.0, reach))
    start = cycle_on(line, space.points, settings)
    if start is None:
        return []
    tasks, found = Tasks(line, settings), list[MetOnLine]()
    followed, lost = tasks.cycle(start), -1  # since which of what was found it is unstable
    while True:
        curve = followed.curve
        if lost >= 0 and _is_stable(curve) and curve.parameter[0] <= _within(found[lost]):
            found[lost:] = [_spike(found, lost)]
            lost = -1
        read = _read(followed, line, direction, settings)
        found += [replace(each, stable=lost < 0) for each in read]
        unstable = bool(found) and found[-1].effect is Effect.DESTABILISED
        if unstable and lost < 0:
            lost = len(found) - 1
        if lost >= 0 and not past and curve.parameter[-1] > _within(found[lost]):
            return found[: lost + 1]
        if not unstable or not followed.onward or len(found) > MANY:
            return found
        followed = tasks.ahead(followed.onward[0])


def _within(lost: MetOnLine) -> float:
    """Up to where a motion may be unstable in a spike only."""
    return lost.size * (1.0 + SPIKE)


def _is_stable(curve: BranchCurve) -> bool:
    """Whether the cycles of a branch are stable, but for those at its ends perhaps."""
    return bool(np.median(np.abs(curve.multiplier)) < 1.0)


def _spike(found: list[MetOnLine], lost: int) -> MetOnLine:
    """What is met in a spike, as one: the border at which it stands, if there is one."""
    near = found[lost].size * (1.0 - SPIKE)
    borders = [
        each for each in found
        if each.size >= near
        and (each.effect is Effect.KINKED or each.kind == PointKind.BC.value)
    ]  # fmt: skip
    place = borders[0] if borders else found[lost]
    return replace(place, effect=Effect.SPIKED, stable=True)


def cycle_on(line: ToyLine, x: Floats, settings: Settings) -> orbits.Orbit | None:
    """The cycle at the beginning of a line."""
    images = tuple(line.at(float(each), 0.0) for each in x)
    return orbits.at_parameter(orbits.Orbit(x, 0.0, images), settings)


def _read(
    followed: Followed, line: ToyLine, direction: Floats, settings: Settings
) -> Iterator[MetOnLine]:
    """What a branch meets, in order of the distance from the toy."""
    curve = followed.curve

    def pieces(k: int) -> list[LinePiece]:
        p = float(curve.parameter[k])
        return [LinePiece(line.at(float(each), p).piece) for each in curve.points[k]]

    def met(k: int, effect: Effect, kind: str, cause: str) -> MetOnLine:
        orbit = orbit_of(pieces(k - 1), curve.points[k][:, None], curve.parameter[k : k + 1])
        condition = _condition(orbit, kind, cause, settings)
        return MetOnLine(effect, kind, cause, curve.parameter[k] * direction, orbit, condition)

    def words(k: int) -> list[str]:
        return [piece.word for piece in pieces(k)]

    last = len(curve.points) - 1
    for mark in curve.marks:
        if mark.sample == 0:
            continue
        effect = Effect.RELABELLED if mark.smooth else Effect.KINKED
        beyond = min(mark.sample + 1, last)
        if effect is Effect.KINKED or words(mark.sample - 1) != words(beyond):
            yield met(mark.sample, effect, WORD, mark.cause)
    end = curve.ends[1]
    what = _effect(end, goes_on=any(start.end is end for start in followed.onward))
    if what is not None and last > 0:
        yield met(last, what, end.kind.value, end.cause or end.note)


def _effect(end: End, *, goes_on: bool) -> Effect | None:
    """What a special point does to a stable motion; None where nothing does."""
    if end.kind is PointKind.EP:
        return Effect.OPEN if end.status is PointStatus.OPEN else None
    persists = end.note == "persistence" and goes_on  # not where it becomes a jump crossing
    unstable = end.kind in (PointKind.PD, PointKind.BP) or persists
    return Effect.DESTABILISED if unstable else Effect.DESTROYED


def _condition(orbit: SpaceOrbit, kind: str, cause: str, settings: Settings) -> Condition | None:
    """What vanishes at a special point."""
    if kind in (PointKind.LP.value, PointKind.PD.value):
        size = float(orbit.p[0]) or 1.0  # derivatives are differences over parts of a change
        return Multiplier(kind, (size * settings.x_scale, size))
    best, found = math.inf, None
    for i, image in enumerate(orbit.images):
        for k, code in enumerate(image.codes.tolist()):
            size = abs(float(image.gradients[k, 0])) or 1.0
            away = abs(float(image.margins[k])) / size
            if away < best and image.piece.cause(code) == cause:
                best, found = away, OnBorder(i, code)
    return found
