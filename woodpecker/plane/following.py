"""A whole curve: both ways from a place to its ends, from arc to arc."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pwmap.diagrams.diagram import PointKind, PointStatus, SpecialPoint
from pwmap.plane.kinds import PlaneKind
from woodpecker.base.checks import interval
from woodpecker.piecewise.settings import Settings
from woodpecker.plane.curve import OPEN, Curve, PlanePoint, PlaneStretch, numbered
from woodpecker.plane.families import Family, Pair
from woodpecker.plane.nodes import Node, code_of, node_at, tests_of
from woodpecker.plane.passing import passed
from woodpecker.plane.places import Along, Equation, Locus, Place, Plane, held, precision, tangent
from woodpecker.plane.starting import located
from woodpecker.plane.stepping import (
    CLOSED,
    MANY,
    Event,
    Stepper,
    Steps,
    follow,
    given_up,
    turned_round,
)
from woodpecker.plane.switching import Seed, starts_at

TRIES = 4  # steps for each sample that a curve may have; most are accepted
LEGS = 150  # words that a curve takes each way: where it goes back and forth it is left
LEVEL = 1e-9  # the part of a unit tangent below which the second parameter is said not to change
Spans = tuple[Pair, Pair]


@dataclass(frozen=True, slots=True, eq=False)
class _Sample:
    """A node with what it obeys, and with what happens there."""

    node: Node
    locus: Locus
    event: Event | None = None
    kind: PlaneKind | None = None
    cause: str = ""
    off: Pair | None = (
        None  # how far away both parameters may be, if that is not for rounding to say
    )


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
    """Follow a special point over two parameters, both ways.

    Parameters
    ----------
    family
        The maps.
    point
        A special point, LP, PD, BC or FF, of a diagram over one of the parameters; or one of
        codimension two on another curve of the same family.
    other
        The value of the other parameter in that diagram.
    axis
        Which parameter the diagram is over, 0 or 1.
    span
        Intervals of both parameters.
    settings
        Window, steps and tolerances; its span is taken from ``span``.
    kind
        Which of the curves that start at a point of codimension two.

    Returns
    -------
    Curve
        Through any number of special points of codimension two; at the place itself the second
        parameter rises, or the first if the second does not change. From a point of codimension
        two on it leads away.

    Raises
    ------
    ValueError
        If there is no such point, or the spans do not hold it.

    Examples
    --------
    >>> from sympy import Piecewise, symbols
    >>> from woodpecker import Settings, connected, curve_through, family_from_sympy
    >>> x, a, r = symbols("x a r")
    >>> p1 = Piecewise((r - 2, x <= 0), (r - a*x, True))
    >>> family = family_from_sympy(p1, x, (r, a), words=["L", "R"])
    >>> settings = Settings(span=(-1, 1), window=(-4, 4))
    >>> point = connected(family.over(0, (0.0, 1.25)), 0.2, 0.45, settings).points[0]
    >>> curve = curve_through(family, point, 1.25, span=((-1, 1), (1.1, 2)), settings=settings)
    >>> str(curve.kind), curve.values[[0, -1]].round(9).tolist()  # r and a
    ('BC', [[0.0, 1.1], [0.0, 2.0]])
    """
    spans = [interval("span", each, finite=True) for each in span]
    plane = Plane(family, (replace(settings, span=spans[0]), replace(settings, span=spans[1])))
    if isinstance(point, PlanePoint):
        seed = _seed(point, kind)
        place, locus = seed.place, seed.locus
        return _curve(plane, *_one_way(plane, place, locus, seed))
    if axis not in (0, 1):
        raise ValueError(f"axis must be 0 or 1, got {axis}")
    if other is None:
        raise ValueError(
            f"a special point over {family.names[axis]} needs a value of {family.names[1 - axis]}"
        )
    place, locus = located(plane, point, other, axis)
    for name, value, (low, high) in zip(family.names, place.values, spans, strict=True):
        if not low <= value <= high:
            raise ValueError(f"span must hold {name} = {value}, got ({low}, {high})")
    return _curve(plane, *_both_ways(plane, place, locus))


def _seed(point: PlanePoint, kind: PointKind | str | None) -> Seed:
    seeds: Sequence[Seed] = point.seed  # type: ignore[assignment]
    if not seeds:
        raise ValueError(f"no other curve starts at {point.id}")
    names = [str(seed.kind) for seed in seeds]
    wanted = names[0] if kind is None else str(kind)
    if wanted not in names:
        raise ValueError(f"kind must be one of {', '.join(names)} at {point.id}, got {wanted!r}")
    return seeds[names.index(wanted)]


def _both_ways(plane: Plane, place: Place, locus: Locus) -> tuple[list[_Sample], bool]:
    """Samples through a place, and whether they close.

    The second parameter rises at the place itself, or the first where the second does not change.
    """
    along = tangent(plane, place, locus)
    if not np.isfinite(along).all():
        raise ValueError("the equations are singular at this point: no curve leads on from it")
    start = node_at(plane, locus, place, along)
    if along[-1] < -LEVEL or (along[-1] <= LEVEL and along[-2] < 0.0):
        start = turned_round(start)
    forward, closed = _leg(plane, start, locus, start)
    if closed:
        return forward, True
    backward, _ = _leg(plane, turned_round(start), locus, None)
    turned = [replace(each, node=turned_round(each.node)) for each in backward[:0:-1]]
    return [*turned, *forward], False


def _one_way(plane: Plane, place: Place, locus: Locus, seed: Seed) -> tuple[list[_Sample], bool]:
    """Samples from a seed on."""
    return _leg(
        plane,
        Node(place, seed.along)
        if locus.border is None
        else node_at(plane, locus, place, seed.along),
        locus,
        None,
    )


def _leg(
    plane: Plane, start: Node, locus: Locus, origin: Node | None
) -> tuple[list[_Sample], bool]:
    """Samples from a node to where the curve ends, through borders at which it goes on."""
    samples, step, most = [_Sample(start, locus)], math.inf, plane.first.max_samples
    steps = Steps(TRIES * most)
    for _ in range(LEGS):
        if len(samples) > most:
            break
        stepper = Stepper(plane, locus, len(start.place))
        arc = follow(stepper, samples[-1].node, steps, step, origin)
        happened = dict(arc.events)
        for k, node in enumerate(arc.nodes[1:], start=1):
            event = happened.get(k)
            samples.append(
                _Sample(
                    node, locus, event, event.kind if event else None, event.cause if event else ""
                )
            )
        end, samples[-1] = (
            arc.end,
            replace(samples[-1], event=arc.end, kind=arc.end.kind, cause=arc.end.cause),
        )
        if arc.beyond is not None:
            samples.append(_Sample(arc.beyond, locus))
            step = plane.first.again
            continue
        if end.margin is None or end.kind is not None:
            return samples, end.cause == CLOSED
        on = passed(plane, locus, arc.nodes[-1], end.margin)
        if on.node is None or on.locus is None:
            why = f"{end.cause}: {on.cause}" if on.cause else end.cause
            samples[-1] = replace(samples[-1], kind=on.kind, cause=why)
            return samples, False
        samples[-1] = (
            replace(samples[-1], kind=on.kind)
            if on.kind
            else _at_word_change(plane, samples[-1], on.node)
        )
        samples.append(_Sample(on.node, on.locus))
        locus, step = on.locus, max(arc.step, plane.first.again)
    last = given_up(samples[-1].node, MANY)
    return [*samples[:-1], replace(samples[-1], event=last, kind=last.kind, cause=MANY)], False


def _at_word_change(plane: Plane, sample: _Sample, beyond: Node) -> _Sample:
    """A sample on a border where a word changes, with the test that changes its sign right there.

    Beside a root in the map slopes change fast: a multiplier may pass through -1 before the first
    node beyond, which then is what tells how well the place is known.
    """
    on_border = sample.locus.border is not None
    for test in tests_of(plane, sample.locus, len(sample.node.place)) if on_border else ():
        before, after = test.value(sample.node), test.value(beyond)
        if before * after < 0.0:
            away = np.abs(beyond.place.point - sample.node.place.point)[-2:].tolist()
            cause = f"{test.kind.meaning}; {sample.cause}"
            return replace(sample, kind=test.kind, cause=cause, off=(away[0], away[1]))
    return sample


def _curve(plane: Plane, samples: list[_Sample], closed: bool) -> Curve:
    """What samples show."""
    first = samples[0]
    codes = [code_of(plane, each.locus, each.node) for each in samples]
    index = first.locus.border.index if first.locus.border is not None else -1
    beyond = [each.node.beyond(index) for each in samples]
    borders = [each.node.kind(plane.first) for each in samples]
    cause = first.node.border.cause if first.node.border is not None else ""
    return Curve(
        kind=PointKind.BC if index >= 0 else codes[0][0],
        names=plane.family.names,
        order=len(first.node.place),
        values=np.array([each.node.place.values for each in samples]),
        x=np.array([each.node.orbit.x for each in samples]),
        border_index=index,
        multipliers=np.column_stack([[each.node.inside for each in samples], beyond]),
        gaps=np.array([each.node.gap for each in samples]),
        borders=tuple(each for each in borders if each is not None),
        codes=tuple(code for code, _ in codes),
        notes=tuple(note for _, note in codes),
        words=_words(samples),
        points=_points(plane, samples, closed),
        closed=closed,
        cause=cause,
    )


def _words(samples: list[_Sample]) -> tuple[PlaneStretch, ...]:
    """Where words change: on either side of a border."""
    found, last, cause = list[PlaneStretch](), None, ""
    for k, each in enumerate(samples):
        border = each.node.border
        words = " | ".join(each.node.orbit.words), border.outer.piece.word if border else ""
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
        status = each.event.status if each.event is not None else PointStatus.LOCATED
        seeds = starts_at(plane, each.node, each.locus, each.event)
        found.append(
            PlanePoint(
                id=name, kind=kind, values=each.node.place.values,
                x=tuple(each.node.orbit.x.tolist()), sample=k, cause=each.cause or kind.meaning,
                precision=_precision(plane, each) if status is PointStatus.LOCATED else OPEN,
                status=status, starts=tuple(seed.kind for seed in seeds), seed=seeds,
            )
        )  # fmt: skip
    return tuple(found)


def _precision(plane: Plane, sample: _Sample) -> Pair:
    """How well a special point is located."""
    if sample.off is not None:
        return sample.off
    node, locus, event = sample.node, sample.locus, sample.event
    scale = plane.scales(len(node.place))
    extra: Equation = Along(node.place.point, node.tangent, 0.0, scale)
    if event is not None and event.margin is not None:
        extra = held(event.margin, plane)
    elif sample.kind in (PlaneKind.FOLD_BORDER, PlaneKind.FLIP_BORDER) and locus.border is not None:
        extra = held(1.0 if sample.kind is PlaneKind.FOLD_BORDER else -1.0, plane)
    return precision(plane, node.place, [*locus.equations(plane), extra])
