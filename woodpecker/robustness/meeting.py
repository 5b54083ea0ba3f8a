"""Special points and changes of word that a motion meets on a line of toys."""

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
from woodpecker.search.curves import BranchCurve, End, Followed
from woodpecker.search.tasks import Tasks
from woodpecker.slices import orbits
from woodpecker.toy_map import ToyPieces

MANY = 64  # conditions on a line, at most: words may change without end
SPIKE = 1e-4  # relative: instability over a shorter part of a change is a spike
WORD = "word"  # kind of a border that is not a special point

Key = tuple[Effect, str, str]  # identifies a condition: effect, kind and cause


@dataclass(frozen=True, slots=True, eq=False)
class LineEvent:
    """A special point, or a change of word, on a line of toys."""

    effect: Effect
    kind: str
    cause: str
    u: Floats  # the scaled change
    orbit: SpaceOrbit  # the cycle there, with the pieces that it has before
    condition: Condition | None  # equation that holds there; None if unknown
    stable: bool = True  # whether the motion is stable all the way

    @property
    def size(self) -> float:
        """The length of the change."""
        return float(np.linalg.norm(self.u))

    @property
    def key(self) -> Key:
        """What identifies the condition, wherever it is met."""
        return self.effect, self.kind, self.cause


def met_along(
    space: Space, direction: Floats, most: float = FARTHEST, *, past: bool = True
) -> list[LineEvent]:
    """All conditions that a motion meets on a line, in order, until it is destroyed.

    With ``past`` it is followed beyond a loss of stability, too.
    """
    # Near a grazing the multiplier is unbounded, so that the motion flips right before: if it is
    # stable again beyond the border, the instability is a spike.
    direction = direction / np.linalg.norm(direction)
    reach = min(most, space.reach(direction))
    if not reach > 0.0:
        return []
    line = space.line(np.zeros(len(direction)), direction)
    settings = replace(space.settings, span=(0.0, reach))
    start = cycle_on(line, space.points, settings)
    if start is None:
        return []
    tasks, found = Tasks.of_line(line, settings), list[LineEvent]()
    followed = tasks.cycle(orbits.to_engine(start))
    lost = -1  # index of the condition at which stability was lost
    while True:
        curve = followed.curve
        begins = lost >= 0 and curve.parameter[0] <= _within(found[lost])
        if begins and _is_stable(line, curve, settings):
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


def _within(lost: LineEvent) -> float:
    """The size of change by which a spike that starts with a loss of stability has ended."""
    return lost.size * (1.0 + SPIKE)


def _is_stable(line: ToyPieces, curve: BranchCurve, settings: Settings) -> bool:
    """Whether most inner cycles of a branch are stable; at its ends rounding may decide."""
    inside = np.abs(curve.multiplier[1:-1])
    if not len(inside):
        x, p = np.mean(curve.points, axis=0)[:, 0], float(curve.parameter.mean())
        pieces = [line.at(float(each), p).piece for each in x]
        middle = orbits.at_parameter(orbits.orbit_of(pieces, x, p), settings)
        inside = np.array([math.inf if middle is None else abs(middle.multiplier)])
    return bool(np.median(inside) < 1.0)


def _spike(found: list[LineEvent], lost: int) -> LineEvent:
    """Merge the conditions of a spike into one: at its border, or else at its start."""
    near = found[lost].size * (1.0 - SPIKE)
    borders = [
        each for each in found
        if each.size >= near
        and (each.effect is Effect.KINKED or each.kind == PointKind.BC.value)
    ]  # fmt: skip
    place = borders[0] if borders else found[lost]
    return replace(place, effect=Effect.SPIKED, stable=True)


def cycle_on(line: ToyPieces, x: Floats, settings: Settings) -> orbits.Orbit | None:
    """The cycle at the start of a line."""
    images = tuple(line.at(float(each), 0.0) for each in x)
    return orbits.at_parameter(orbits.Orbit(x, 0.0, images), settings)


def _read(
    followed: Followed, line: ToyPieces, direction: Floats, settings: Settings
) -> Iterator[LineEvent]:
    """The conditions on a branch, by distance from the toy."""
    curve = followed.curve

    def pieces(k: int) -> list[LinePiece]:
        p = float(curve.parameter[k])
        return [LinePiece(line.at(float(each), p).piece) for each in curve.points[k][:, 0]]

    def met(k: int, effect: Effect, kind: str, cause: str) -> LineEvent:
        orbit = orbit_of(pieces(k - 1), curve.points[k], curve.parameter[k : k + 1])
        condition = _condition(orbit, kind, cause, settings)
        return LineEvent(effect, kind, cause, curve.parameter[k] * direction, orbit, condition)

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
    what = _effect(end, goes_on=any(at is end for _, at in followed.onward))
    if what is not None and last > 0:
        yield met(last, what, end.kind.value, end.cause or end.note)


def _effect(end: End, *, goes_on: bool) -> Effect | None:
    """What the end of a branch means for a stable motion; None if nothing."""
    if end.kind is PointKind.EP:
        return Effect.OPEN if end.status is PointStatus.OPEN else None
    persists = end.note == "persistence" and goes_on  # else it becomes a jump crossing
    unstable = end.kind in (PointKind.PD, PointKind.BP) or persists
    return Effect.DESTABILISED if unstable else Effect.DESTROYED


def _condition(orbit: SpaceOrbit, kind: str, cause: str, settings: Settings) -> Condition | None:
    if kind in (PointKind.LP.value, PointKind.PD.value):
        size = float(orbit.p[0]) or 1.0  # steps of differences are parts of this change
        return Multiplier(kind, (size * settings.x_scale, size))
    best, found = math.inf, None
    for i, image in enumerate(orbit.images):
        for k, code in enumerate(image.codes.tolist()):
            size = abs(float(image.gradients[k, 0])) or 1.0
            away = abs(float(image.margins[k])) / size
            if away < best and image.piece.cause(code) == cause:
                best, found = away, OnBorder(i, code)
    return found
