"""Whole curves over two parameters: followed both ways, arc by arc, to their ends."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from pwmap.diagrams.diagram import PointKind, PointStatus, SpecialPoint
from pwmap.plane.kinds import PlaneKind
from woodpecker.base.checks import interval, number
from woodpecker.base.settings import Settings
from woodpecker.base.shown import shown
from woodpecker.engine.curves import Arc, Sample, SolutionCurve, Stop
from woodpecker.engine.following import follow
from woodpecker.engine.maps import ACCUMULATE
from woodpecker.engine.newton import MERGED, across, uncertainties
from woodpecker.engine.orbits import Condition, OnBorder, SpaceOrbit, at_ends
from woodpecker.plane.curve import Curve, PlanePoint, PlaneStretch, numbered
from woodpecker.plane.families import Family, Pair, Spans, check_axis
from woodpecker.plane.maps import Plane, pair
from woodpecker.plane.nodes import (
    border_in,
    border_of,
    curve_of,
    error_of_test,
    finite,
    kind_and_note,
    kind_of,
    multiplier_inside,
    multipliers_at_border,
)
from woodpecker.plane.passing import (
    CLOSED,
    Along,
    end_of_arc,
    located_elsewhere,
    moved_to_special,
    reliable_samples,
)
from woodpecker.plane.starting import Seed, cycle_at, is_of, seeds_at

LEGS = 400  # most arcs of a curve each way: one that goes back and forth at borders is given up
CROWD, WITHIN = 8, 1e-5  # so many special points within this scaled distance count as endless
# Scaled: least first step beyond a border, even if the last one before was shorter. Where borders
# follow each other closely, pieces that begin and end within it are passed over.
LEAST_STEP_BEYOND = 1e-4
BACK = 2.0**-20  # scaled: distance from a special point at which its test function is measured
CONSTANT = 1e-9  # component of the unit tangent below which the second parameter counts as constant
MANY = Stop.MANY.value
OPEN = (math.inf, math.inf)  # precision of a point that was not located
Met = tuple[Arc, PlaneKind | None, str]
"""An arc, the kind of the special point at its end, or None, and what happens there."""


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

    The diagram of the point is over the parameter of ``axis``, 0 or 1; ``other`` is the value of
    the other one. ValueError if there is no such point, or the spans do not hold it.
    """
    spans = [interval("span", each, finite=True) for each in span]
    plane = Plane(family, (replace(settings, span=spans[0]), replace(settings, span=spans[1])))
    if isinstance(point, PlanePoint):
        if other is not None:
            raise ValueError(f"a point of a curve has both parameters, got value = {shown(other)}")
        condition, start, both = _seed(plane, point, kind)
        curve, origin = curve_of(plane, condition, start.orbit), point
    else:
        orbit, condition = _at_special(plane, point, other, axis, kind)
        curve, origin, both = curve_of(plane, condition, orbit), None, True
        start = curve.start(orbit)
    if not both:
        return _curve(plane, [], *_leg(plane, curve, start, None), origin)
    start = _forward(start)
    ahead, closed = _leg(plane, curve, start, start)
    behind = [] if closed else _leg(plane, curve, start.turned, None)[0]
    return _curve(plane, behind, ahead, closed, origin)


def _at_special(
    plane: Plane, point: SpecialPoint, other: float | None, axis: int, kind: PointKind | str | None
) -> tuple[SpaceOrbit, Condition]:
    """The cycle at a special point over one parameter, and its condition; see `curve_through`."""
    names = plane.family.names
    if kind is not None:
        raise ValueError(f"kind is for points of codimension two, got {shown(kind)} at {point.id}")
    check_axis(axis)
    if other is None:
        raise ValueError(
            f"a special point over {names[axis]} needs value, the one of {names[1 - axis]}"
        )
    value = number("value", other)
    if not math.isfinite(value):
        raise ValueError(f"value must be finite, got {value}")
    orbit, condition = cycle_at(plane, point, value, axis)
    return _within(plane, orbit), condition


def _within(plane: Plane, orbit: SpaceOrbit) -> SpaceOrbit:
    """A cycle moved to the end of a span if it lies beyond by rounding; ValueError if by more."""
    spans = [each.span for each in plane.settings]
    orbit = at_ends(orbit, (0, 1), spans, plane.scale[1:])
    for name, value, (low, high) in zip(plane.family.names, orbit.p.tolist(), spans, strict=True):
        if not low <= value <= high:
            raise ValueError(f"span must hold {name} = {value}, got ({low}, {high})")
    return orbit


def _seed(plane: Plane, point: PlanePoint, kind: PointKind | str | None) -> Seed:
    """The start of a curve of a kind at a point of another curve; ValueError unless it has one."""
    seeds: Sequence[Seed] = point.seed  # type: ignore[assignment]
    if not seeds:
        raise ValueError(
            f"{point.id} was loaded from a file, which holds no starts of curves: compute its curve"
            if point.starts
            else f"no other curve starts at {point.id}"
        )
    names = [str(kind_of(condition)) for condition, *_ in seeds]
    wanted = names[0] if kind is None else str(kind)
    if wanted not in names:
        raise ValueError(f"kind must be one of {', '.join(names)} at {point.id}, got {wanted!r}")
    condition, start, both = seeds[names.index(wanted)]
    orbit = _within(plane, start.orbit)
    if not is_of(plane, orbit):
        raise ValueError(f"{point.id} is of a curve of another map, or of other values of the toy")
    return condition, replace(start, orbit=orbit), both


def _forward(start: Sample) -> Sample:
    """A sample turned so that the second parameter rises, or if that is constant the first."""
    along = start.tangent
    if not np.isfinite(along).all():
        raise ValueError("the equations are singular at this point: no curve leads on from it")
    falls = along[-1] < -CONSTANT or (along[-1] <= CONSTANT and along[-2] < 0.0)
    return start.turned if falls else start


def _leg(
    plane: Plane, curve: SolutionCurve, start: Sample, origin: Sample | None
) -> tuple[list[Met], bool]:
    """The arcs from a start to where the curve ends, and whether it has come back to ``origin``."""
    found, step, left = list[Met](), math.inf, plane.first.max_samples
    while left > 0 and len(found) < LEGS:
        arc = moved_to_special(plane, follow(curve, start, step, origin=origin))
        kind, cause, on = end_of_arc(plane, arc)
        found.append((arc, kind, cause))
        if on is None:
            if len(found) > 1 and _ends_at_once(*found[-2:]):
                found[-2] = found[-2][0], None, ""  # one place: which comes first is rounding
            return found, arc.stop is Stop.CLOSED
        if _crowded(found):
            found[-1] = arc, kind, f"{cause or arc.stop.value}: {ACCUMULATE}"
            return found, False
        (curve, start), step, left = (
            on,
            max(arc.step, LEAST_STEP_BEYOND),
            left - len(reliable_samples(arc)),
        )
    return [*found[:-1], (found[-1][0], PlaneKind.END, MANY)], False


def _ends_at_once(last: Met, end: Met) -> bool:
    """Whether an arc ends where the one before it does."""
    one, other = (arc.samples[-1].orbit for arc, *_ in (last, end))
    return bool(np.abs(end[0].curve.problem.step_between(one, other)).max() <= MERGED)


def _crowded(found: Sequence[Met]) -> bool:
    """Whether the last special points lie so close together that infinitely many accumulate."""
    # Where a motion comes to rest in infinitely many impacts they repeat, ever smaller, with each
    # impact.
    marked = [arc for arc, kind, _ in found if kind is not None][-CROWD:]
    if len(marked) < CROWD or marked[-1] is not found[-1][0]:
        return False
    first, last = (arc.samples[-1].orbit for arc in (marked[0], marked[-1]))
    return bool(np.abs(marked[-1].curve.problem.step_between(first, last)).max() <= WITHIN)


def _samples(found: Sequence[Met]) -> tuple[list[Along], dict[int, Met]]:
    """All samples of arcs, each once, and the arcs by the numbers of the samples they end in."""
    samples, marks = list[Along](), dict[int, Met]()
    for each in found:
        arc, own = each[0], reliable_samples(each[0])
        if samples:
            away = arc.curve.problem.step_between(samples[-1][1].orbit, own[0].orbit)
            own = own if np.abs(away).max() > 0.0 else own[1:]
        samples += [(arc.curve, sample) for sample in own]
        marks[len(samples) - 1] = each
    return samples, marks


def _curve(
    plane: Plane, behind: list[Met], ahead: list[Met], closed: bool, origin: PlanePoint | None
) -> Curve:
    """The curve that consists of arcs both ways from one start, which may be a point of another."""
    (back, before), (samples, marks) = _samples(behind), _samples(ahead)
    first = max(len(back) - 1, 0)
    samples = [*back[:0:-1], *samples]
    marks = {first - k: each for k, each in before.items()} | {
        first + k: each for k, each in marks.items()
    }
    orbits = [sample.orbit for _, sample in samples]
    codes = [kind_and_note(plane, curve, sample.orbit) for curve, sample in samples]
    on = [border_in(curve) for curve, _ in samples]
    lies = [(orbit, own, *border_of(plane, orbit, own))
            for orbit, own in zip(orbits, on, strict=True) if own is not None]  # fmt: skip
    multipliers = [[finite(each) for each in multipliers_at_border(orbit, own, border)]
                   for orbit, own, border, _ in lies]  # fmt: skip
    outer = [border.outer.piece.word for _, _, border, _ in lies] or [""] * len(orbits)
    return Curve(
        kind=PointKind.BC if lies else codes[0][0],
        names=plane.family.names,
        order=len(orbits[0].x),
        values=np.array([orbit.p for orbit in orbits]),
        x=np.array([orbit.x[:, 0] for orbit in orbits]),
        border_index=on[0].image if on[0] is not None else -1,
        multipliers=np.array(
            multipliers or [[multiplier_inside(orbit), math.nan] for orbit in orbits]
        ),
        gaps=np.array([gap for *_, gap in lies] or np.zeros(len(orbits))),
        borders=tuple(border.kind(plane.first) for _, _, border, _ in lies),
        codes=tuple(code for code, _ in codes),
        notes=tuple(note for _, note in codes),
        words=_words(
            [(orbit.word, word) for orbit, word in zip(orbits, outer, strict=True)], marks
        ),
        points=_points(plane, samples, marks, closed, {} if origin is None else {first: origin}),
        closed=closed,
        cause=lies[0][2].cause if lies else "",
    )


def _words(words: Sequence[tuple[str, str]], marks: Mapping[int, Met]) -> tuple[PlaneStretch, ...]:
    """The stretches between changes of a word, on either side of a border, with their causes."""
    found = [PlaneStretch(0, *words[0])]
    for k, (before, here) in enumerate(pairwise(words), start=1):
        if here != before:
            cause = next((marks[j][2] for j in (k - 1, k) if j in marks), "")
            found.append(PlaneStretch(k, *here, cause))
    return tuple(found)


def _points(
    plane: Plane, samples: Sequence[Along], marks: Mapping[int, Met], closed: bool,
    known: Mapping[int, PlanePoint],
) -> tuple[PlanePoint, ...]:  # fmt: skip
    """The special points of a curve, and both ends, in order; some are those of other curves."""
    last = len(samples) - 1
    special = {k for k, (_, kind, _) in marks.items() if kind is not None}
    places = sorted({0, last, *known} | special)
    kinds = [
        known[k].kind if k in known else (marks[k][1] if k in marks else None) or PlaneKind.END
        for k in places
    ]
    found = []
    for k, kind, name in zip(places, kinds, numbered(kinds), strict=True):
        if k in known:
            found.append(replace(known[k], id=name, sample=k, starts=(), seed=()))
            continue
        (curve, sample), (arc, _, cause) = samples[k], marks.get(k, (None, None, ""))
        if closed and k == 0:
            cause = CLOSED
        is_open = cause == MANY or (arc is not None and arc.stop.is_open)
        seeds = () if arc is None else seeds_at(plane, arc)
        found.append(
            PlanePoint(
                id=name, kind=kind, values=pair(sample.orbit.p), sample=k,
                x=tuple(sample.orbit.x[:, 0].tolist()), cause=cause or kind.meaning,
                precision=OPEN if is_open else _precision(plane, curve, sample, arc, kind),
                status=PointStatus.OPEN if is_open else PointStatus.LOCATED,
                starts=tuple(kind_of(condition) for condition, *_ in seeds), seed=seeds,
            )
        )  # fmt: skip
    return tuple(found)


def _precision(
    plane: Plane, curve: SolutionCurve, sample: Sample, arc: Arc | None, kind: PlaneKind
) -> Pair:
    """The uncertainty of both parameters of a special point."""
    elsewhere = None if arc is None else located_elsewhere(plane, arc)
    if elsewhere is not None:
        arc, curve, sample = elsewhere, elsewhere.curve, elsewhere.samples[-1]
    problem, orbit = curve.problem, sample.orbit
    condition: Condition = across(problem, orbit, sample.tangent, 0.0)
    if arc is not None and arc.border is not None:
        condition = OnBorder(*arc.border)
    known = uncertainties(problem.with_(condition), orbit)
    if arc is not None and arc.stop is Stop.SPECIAL:
        way = sample.tangent[-2:] * plane.scale[1:]
        error = error_of_test(plane, kind, curve, orbit)
        known = known + np.abs(way) * max(_location_error(arc, error), arc.width)
    one, other = known.tolist()
    return one, other


def _location_error(arc: Arc, error: float) -> float:
    """The distance along a curve within which a test function with an error may vanish."""
    # It is the first at which the function exceeds twice that; closer than BACK it is linear.
    assert arc.test is not None
    back, distance = arc.samples[-1].turned, BACK
    while distance < 1.0:
        found = arc.curve.advance(back, distance)
        value = math.nan if found is None else abs(arc.test.value(found))
        if value > 2.0 * error:
            return distance * (error / value if distance == BACK else 1.0)
        distance *= 2.0
    return math.inf
