"""A whole curve: both ways from a place to its ends, from arc to arc."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pwmap.diagrams.diagram import PointKind, PointStatus, SpecialPoint
from pwmap.plane.kinds import PlaneKind
from woodpecker.base.checks import interval
from woodpecker.base.settings import Settings
from woodpecker.engine.curves import Arc, Sample, SolutionCurve, Stop
from woodpecker.engine.following import follow
from woodpecker.engine.maps import ACCUMULATE
from woodpecker.engine.newton import across, uncertainties
from woodpecker.engine.orbits import Multiplier, OnBorder, Orbit
from woodpecker.plane.curve import OPEN, Curve, PlanePoint, PlaneStretch, numbered
from woodpecker.plane.families import Family, Pair
from woodpecker.plane.maps import Plane, pair
from woodpecker.plane.nodes import (
    border_in,
    border_of,
    code_of,
    curve_of,
    inside,
)
from woodpecker.plane.passing import known, mirrored, passed, sharpened
from woodpecker.plane.starting import located
from woodpecker.plane.switching import Seed, starts_at

LEGS = 400  # arcs of a curve each way: where it goes back and forth it is left
CROWD, WITHIN = 8, 1e-5  # so many special points within this distance, scaled, are without end
# Scaled: first step beyond a border, if the last one before it was shorter: where borders follow
# each other closely, pieces that begin and end within it are passed over.
AGAIN = 1e-4
LEVEL = 1e-9  # the part of a unit tangent below which the second parameter is said not to change
SPAN, CLOSED = "end of the span", "the curve closes"
MANY = Stop.MANY.value
Spans = tuple[Pair, Pair]


@dataclass(frozen=True, slots=True, eq=False)
class _Sample:
    """A sample with its curve, and with what happens there."""

    own: Sample
    curve: SolutionCurve
    arc: Arc | None = None  # that ends here
    kind: PlaneKind | None = None
    cause: str = ""

    @property
    def orbit(self) -> Orbit:
        """Its cycle."""
        return self.own.orbit

    @property
    def values(self) -> Pair:
        """Both parameters."""
        return pair(self.orbit.p)


def curve_through(
    family: Family,
    point: SpecialPoint | PlanePoint,
    other: float | None = None,
    *,
    axis: int = 0,
    span: Spans,
    settings: Settings,
    kind: PointKind | str | None = None,
) -> Curve:
    """Follow a special point both ways over two parameters; see :func:`woodpecker.curve_in_two`.

    Parameters
    ----------
    family, point, span, settings, kind
        As there; the span of the settings is taken from ``span``.
    other
        The value of the other parameter in the diagram of the point.
    axis
        Which parameter that diagram is over, 0 or 1.

    Raises
    ------
    ValueError
        If there is no such point, or the spans do not hold it.
    """
    spans = [interval("span", each, finite=True) for each in span]
    plane = Plane(family, (replace(settings, span=spans[0]), replace(settings, span=spans[1])))
    if isinstance(point, PlanePoint):
        seed = _seed(point, kind)
        own = curve_of(plane, seed.condition, seed.orbit)
        return _curve(plane, *_leg(plane, _Sample(Sample(seed.orbit, seed.along), own), None))
    if axis not in (0, 1):
        raise ValueError(f"axis must be 0 or 1, got {axis}")
    if other is None:
        raise ValueError(
            f"a special point over {family.names[axis]} needs a value of {family.names[1 - axis]}"
        )
    orbit, condition = located(plane, point, other, axis)
    for name, value, (low, high) in zip(family.names, pair(orbit.p), spans, strict=True):
        if not low <= value <= high:
            raise ValueError(f"span must hold {name} = {value}, got ({low}, {high})")
    return _curve(plane, *_both_ways(plane, orbit, curve_of(plane, condition, orbit)))


def _seed(point: PlanePoint, kind: PointKind | str | None) -> Seed:
    seeds: Sequence[Seed] = point.seed  # type: ignore[assignment]
    if not seeds:
        raise ValueError(f"no other curve starts at {point.id}")
    names = [str(seed.kind) for seed in seeds]
    wanted = names[0] if kind is None else str(kind)
    if wanted not in names:
        raise ValueError(f"kind must be one of {', '.join(names)} at {point.id}, got {wanted!r}")
    return seeds[names.index(wanted)]


def _both_ways(plane: Plane, orbit: Orbit, curve: SolutionCurve) -> tuple[list[_Sample], bool]:
    """Samples through a cycle, and whether they close.

    The second parameter rises at the cycle itself, or the first where the second does not change.
    """
    start = curve.start(orbit)
    along = start.tangent
    if not np.isfinite(along).all():
        raise ValueError("the equations are singular at this point: no curve leads on from it")
    if along[-1] < -LEVEL or (along[-1] <= LEVEL and along[-2] < 0.0):
        start = start.turned
    forward, closed = _leg(plane, _Sample(start, curve), start)
    if closed:
        return forward, True
    backward, _ = _leg(plane, _Sample(start.turned, curve), None)
    return [*backward[:0:-1], *forward], False


def _leg(plane: Plane, start: _Sample, origin: Sample | None) -> tuple[list[_Sample], bool]:
    """Samples from a place to where the curve ends, through borders at which it goes on."""
    samples, step, most = [start], math.inf, plane.first.max_samples
    at = start
    for _ in range(LEGS):
        if len(samples) > most:
            break
        arc = sharpened(plane, follow(at.curve, at.own, step, origin=origin))
        step = max(arc.step, AGAIN)
        samples += [_Sample(each, at.curve) for each in known(arc)[1:]]
        met, on = _met(plane, replace(samples[-1], arc=arc), arc)
        samples[-1] = met
        if on is None:
            return samples, arc.stop is Stop.CLOSED
        if _crowded(samples):
            samples[-1] = replace(met, cause=f"{met.cause or arc.stop.value}: {ACCUMULATE}")
            return samples, False
        at = on
        away = np.abs(on.curve.problem.step_between(met.orbit, on.orbit)).max()
        if away > 0.0:
            samples.append(on)
    last = replace(samples[-1], kind=PlaneKind.END, cause=MANY)
    return [*samples[:-1], last], False


def _crowded(samples: list[_Sample]) -> bool:
    """Whether special points lie so close together that there is no end of them.

    Beside where a motion comes to rest in infinitely many impacts there is a copy of them, ever
    smaller, for each impact.
    """
    marked = [each for each in samples if each.kind is not None][-CROWD:]
    if len(marked) < CROWD or marked[-1] is not samples[-1]:
        return False
    first, last = marked[0], marked[-1]
    away = np.abs(last.curve.problem.step_between(first.orbit, last.orbit)).max()
    return bool(away <= WITHIN)


def _met(plane: Plane, end: _Sample, arc: Arc) -> tuple[_Sample, _Sample | None]:
    """What an arc comes to, and where the curve goes on; None if it ends."""
    if arc.stop is Stop.SPECIAL and arc.test is not None:
        kind = PlaneKind(arc.test.name)
        folds = arc.curve.problem.conditions[1] == Multiplier("LP", plane.scale)
        ends = folds and kind is PlaneKind.GENERALISED_FLIP
        on = None if ends or arc.beyond is None else _Sample(arc.beyond, arc.curve)
        return replace(end, kind=kind), on
    if arc.stop in (Stop.SHORT, Stop.OTHER_PIECE):
        over = mirrored(plane, arc)
        if over is not None and over.sample is not None and over.curve is not None:
            return replace(end, cause=over.cause), _Sample(over.sample, over.curve)
    if arc.border is None:
        return replace(end, kind=PlaneKind.END, cause=_why(plane, arc)), None
    i, code = arc.border
    cause = end.orbit.images[i].piece.cause(code)
    beyond = passed(plane, arc)
    if beyond.sample is None or beyond.curve is None:
        why = f"{cause}: {beyond.cause}" if beyond.cause else cause
        return replace(end, kind=beyond.kind, cause=why), None
    onward = _Sample(beyond.sample, beyond.curve)
    return replace(end, kind=beyond.kind, cause=cause), onward


def _why(plane: Plane, arc: Arc) -> str:
    """Why a curve ends that meets nothing, or is given up."""
    if arc.stop is Stop.SPAN:
        settings, values = plane.settings, pair(arc.samples[-1].orbit.p)
        names = zip(plane.family.names, values, settings, strict=True)
        return next(f"{SPAN} of {name}" for name, value, each in names if value in each.span)
    if arc.stop is Stop.CLOSED:
        return CLOSED
    stop = Stop.SHORT if arc.stop is Stop.OTHER_PIECE else arc.stop
    return str(stop.value)


def _curve(plane: Plane, samples: list[_Sample], closed: bool) -> Curve:
    """What samples show."""
    first, on = samples[0], [border_in(each.curve) for each in samples]
    codes = [code_of(plane, each.curve, each.orbit) for each in samples]
    index = -1 if on[0] is None else on[0].image
    met = [border_of(plane, each.orbit, own) for each, own in zip(samples, on, strict=True) if own]
    beyond = [each.beyond for each in met] or [math.nan] * len(samples)
    return Curve(
        kind=PointKind.BC if index >= 0 else codes[0][0],
        names=plane.family.names,
        order=len(first.orbit.x),
        values=np.array([each.values for each in samples]),
        x=np.array([each.orbit.x[:, 0] for each in samples]),
        border_index=index,
        multipliers=np.column_stack([[inside(each.orbit) for each in samples], beyond]),
        gaps=np.array([each.gap for each in met] or np.zeros(len(samples))),
        borders=tuple(each.kind for each in met),
        codes=tuple(code for code, _ in codes),
        notes=tuple(note for _, note in codes),
        words=_words(plane, samples),
        points=_points(plane, samples, closed),
        closed=closed,
        cause=met[0].border.cause if met else "",
    )


def _words(plane: Plane, samples: list[_Sample]) -> tuple[PlaneStretch, ...]:
    """Where words change: on either side of a border."""
    found, last, cause = list[PlaneStretch](), None, ""
    for k, each in enumerate(samples):
        on = border_in(each.curve)
        border = None if on is None else border_of(plane, each.orbit, on).border
        words = each.orbit.word, border.outer.piece.word if border else ""
        if words != last:
            found.append(PlaneStretch(k, *words, cause))
        last, cause = words, each.cause
    return tuple(found)


def _points(plane: Plane, samples: list[_Sample], closed: bool) -> tuple[PlanePoint, ...]:
    """Special points, and both ends."""
    last = len(samples) - 1
    if closed:
        samples = [replace(samples[0], cause=CLOSED), *samples[1:]]
    kept = [(k, each) for k, each in enumerate(samples) if each.kind is not None or k in (0, last)]
    kinds = [each.kind or PlaneKind.END for _, each in kept]
    found = []
    for (k, each), kind, name in zip(kept, kinds, numbered(kinds), strict=True):
        is_open = each.cause == MANY or (each.arc is not None and each.arc.stop.is_open)
        seeds = () if each.arc is None else starts_at(plane, each.arc)
        found.append(
            PlanePoint(
                id=name, kind=kind, values=each.values, x=tuple(each.orbit.x[:, 0].tolist()),
                sample=k, cause=each.cause or kind.meaning,
                precision=OPEN if is_open else _precision(plane, each),
                status=PointStatus.OPEN if is_open else PointStatus.LOCATED,
                starts=tuple(seed.kind for seed in seeds), seed=seeds,
            )
        )  # fmt: skip
    return tuple(found)


def _precision(plane: Plane, sample: _Sample) -> Pair:
    """How well a special point is located."""
    problem, arc, orbit = sample.curve.problem, sample.arc, sample.orbit
    condition = problem.conditions[1]
    if arc is not None and arc.border is not None:
        problem = problem.with_(OnBorder(*arc.border))
    elif (
        sample.kind in (PlaneKind.FOLD_BORDER, PlaneKind.FLIP_BORDER)
        and isinstance(condition, OnBorder)
    ):  # fmt: skip
        kind = "LP" if sample.kind is PlaneKind.FOLD_BORDER else "PD"
        problem = problem.with_(Multiplier(kind, plane.scale))
    else:
        problem = problem.with_(across(problem, orbit, sample.own.tangent, 0.0))
    one, other = uncertainties(problem, orbit).tolist()
    return one, other
