"""Branches of the engine, as maps of the line have them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pwmap.diagrams.diagram import PointKind
from woodpecker.base.settings import Settings
from woodpecker.engine import orbits
from woodpecker.engine.arrivals import Arrival
from woodpecker.engine.curves import CurveSettings, Sample, SolutionCurve
from woodpecker.engine.germs import Beginning, beginnings, judged, shared
from woodpecker.engine.line import LineMap, first_piece
from woodpecker.engine.maps import length_of
from woodpecker.engine.newton import Problem
from woodpecker.engine.tracing import Change
from woodpecker.maps.pieces import PiecewiseMap
from woodpecker.search.curves import BranchCurve, Collision, End, Keys, Word
from woodpecker.slices.orbits import CYCLE, ending_at, problem_of


def base_of(map_: PiecewiseMap, settings: Settings) -> SolutionCurve:
    """Curves of cycles of a map of the line."""
    problem = problem_of(settings, *CYCLE)
    followed = CurveSettings(
        spans=(settings.span,), window=(settings.window,), step=settings.step,
        min_step=settings.min_step, max_step=settings.max_step, max_turn=settings.max_turn,
        max_samples=settings.max_samples,
    )  # fmt: skip
    return SolutionCurve(LineMap(map_, settings.x_scale, settings.p_scale), problem, followed)


def curve_of(
    begin: Beginning, samples: Sequence[Sample], changes: Sequence[Change], ends: tuple[End, End]
) -> BranchCurve:
    """A branch as it is kept."""
    words = list[Word]()
    for k, sample in enumerate(samples):
        keys = keys_of(sample.orbit, begin.curve.problem)
        if not words or keys != words[-1].keys:
            words.append(Word(k, text_of(sample.orbit), keys))
    return BranchCurve(
        kind=begin.kind, order=begin.order,
        parameter=np.array([float(s.orbit.p[0]) for s in samples]),
        points=tuple(s.orbit.x[:, 0] for s in samples),
        multiplier=np.array([multiplier_of(s.orbit) for s in samples]),
        words=tuple(words), marks=tuple(changes), ends=ends,
    )  # fmt: skip


def multiplier_of(orbit: orbits.SpaceOrbit) -> float:
    """The multiplier of a cycle; nan of a crossing."""
    return float(orbit.monodromy[0, 0]) if orbit.outer is None else math.nan


def closing_of(curve: SolutionCurve, orbit: orbits.SpaceOrbit) -> tuple[orbits.Condition, ...]:
    """The conditions of a cycle, or of the points of a crossing up to the border."""
    if orbit.outer is None:
        return CYCLE
    border, length = curve.problem.conditions[-1], length_of(orbit.images[-1])
    assert isinstance(border, orbits.OnBorder)
    return ending_at(len(orbit.x), border.code // length)


def keys_of(orbit: orbits.SpaceOrbit, problem: Problem) -> Keys:
    """The pieces of an orbit, see :class:`woodpecker.search.curves.Word`."""
    if orbit.outer is None:
        return orbit.keys
    x, p, sides = orbit.x[-1], orbit.p, set[object]()
    border = shared(orbit.images[-1], orbit.outer, x, p, problem.lengths) or ([], [])
    for image, codes in zip((orbit.images[-1], orbit.outer), border, strict=True):
        length, first = length_of(image), first_piece(image).key
        sides |= {(first, code // length) for code in codes if code % length == 0} or {(first, -1)}
    return *(image.piece.key for image in orbit.images[:-1]), frozenset(sides)


def text_of(orbit: orbits.SpaceOrbit) -> str:
    """The words of a cycle; of a crossing those of the limits, from the left and from the right."""
    if orbit.outer is None:
        return orbit.word
    head = [image.piece.word for image in orbit.images[:-1]]
    inner, outer = (
        " | ".join([*head, side.piece.word]) for side in (orbit.images[-1], orbit.outer)
    )
    return f"{outer} / {inner}" if _inner_side(orbit) > 0 else f"{inner} / {outer}"


def _inner_side(orbit: orbits.SpaceOrbit) -> int:
    """On which side of the first point the inner limit is."""
    last = orbit.images[-1]
    zero = np.flatnonzero(last.tied(orbit.x[-1], orbit.p))
    side = math.copysign(1.0, float(last.gradients[zero[0], 0])) if len(zero) else 1.0
    for image in orbit.images[:-1]:
        side = math.copysign(1.0, side * float(image.jacobian[0, 0]))
    return int(side)


def end_of(arrival: Arrival, base: SolutionCurve, orbit: orbits.SpaceOrbit) -> End:
    """What a branch comes to, seen from the first point of its last orbit."""
    p, x = float(arrival.orbit.p[0]), orbit.x[:, 0]
    if arrival.kind is PointKind.PD:  # one that is half as long, where a doubled cycle ends
        x = np.tile(arrival.orbit.x[:, 0], len(x) // len(arrival.orbit.x))
    if not arrival.collides:
        return End(
            kind=arrival.kind, p=p, x=x, note=arrival.note, cause=arrival.cause,
            precision=arrival.precision, status=arrival.status,
        )  # fmt: skip
    return collision_of(arrival, base).end_at(x)


def collision_of(arrival: Arrival, base: SolutionCurve) -> Collision:
    """A cycle that meets a border, from its least point on."""
    cycle = arrival.orbit
    n = len(cycle.x)
    cycle = cycle.rotated(int(np.argmin(cycle.x[:, 0])))
    starts = list(beginnings(base, cycle.x, cycle.p, (n, 2 * n)))
    kinds = [judged(starts, cycle.x, i, base.problem) for i in range(n)]
    kinds = [(kind, note or arrival.note) for kind, note in kinds]
    return Collision(
        p=float(cycle.p[0]), x=cycle.x[:, 0], kinds=tuple(kinds), cause=arrival.cause,
        precision=arrival.precision,
    )  # fmt: skip
