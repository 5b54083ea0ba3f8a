"""Special points of the toy followed over two of its parameters."""

from __future__ import annotations

from dataclasses import replace

from pwmap.diagrams.diagram import PointKind, PointStatus, SpecialPoint
from pwmap.plane.kinds import PlaneKind
from woodpecker.base.checks import interval
from woodpecker.base.settings import Settings
from woodpecker.mechanics.toy import Toy, limits
from woodpecker.plane.curve import Curve, PlanePoint
from woodpecker.plane.following import curve_through
from woodpecker.plane.toys import ToyFamily
from woodpecker.runs import OUT_OF_DOMAIN, given, possible, settings_for

SAMPLES = 2000  # of a curve each way: most have some hundred, and what needs more comes to nothing

Spans = tuple[tuple[float, float], tuple[float, float]]


def curve_from(
    toy: Toy,
    point: SpecialPoint | PlanePoint,
    parameters: tuple[str, str],
    span: Spans,
    *,
    kind: PointKind | str | None = None,
    settings: Settings | None = None,
) -> Curve:
    """Follow a special point of the toy over two parameters; see :func:`woodpecker.continuation`.

    Raises
    ------
    ValueError
        If there is no such point of this toy, it is of a kind that has no curve, or the spans are
        not two pairs of ascending numbers that hold it.
    TypeError
        If a parameter is unknown, or the settings are no :class:`Settings`.
    """
    family = ToyFamily(toy, parameters)
    first, second = family.names
    wanted = [interval(f"span of {name}", each, finite=True) for name, each in
              zip(family.names, pair(span), strict=True)]  # fmt: skip
    spans = possible(toy, first, wanted[0]), possible(toy, second, wanted[1])
    chosen = settings_for(settings, span=spans[0])
    found = curve_through(
        family, point, getattr(toy, second), span=spans, kind=kind,
        settings=replace(chosen, max_samples=min(chosen.max_samples, SAMPLES)),
    )  # fmt: skip
    law = given(toy, first)[:1]
    rates = f"derivatives in {first} and {second}: the variational flow"
    points = tuple(_of_domain(each, toy, family.names, spans, wanted) for each in found.points)
    return replace(found, points=points, given=(*law, rates))


def pair(span: Spans) -> Spans:
    """Intervals of two parameters."""
    try:
        first, second = span
        len(first), len(second)
    except (TypeError, ValueError):
        raise ValueError(
            f"span must be an interval of each of the two parameters, got {span!r}"
        ) from None
    return first, second


def _of_domain(
    point: PlanePoint, toy: Toy, names: tuple[str, str], spans: Spans,
    wanted: list[tuple[float, float]],
) -> PlanePoint:  # fmt: skip
    """An end point with the reason why a parameter goes no further, if that is why."""
    if point.kind is not PlaneKind.END or point.status is PointStatus.OPEN:
        return point
    for name, value, span, asked in zip(names, point.values, spans, wanted, strict=True):
        for end, limit, beyond in zip(span, limits(toy, name), asked, strict=True):
            if value == end == limit != beyond:
                return replace(point, kind=PlaneKind.DOMAIN, cause=f"{OUT_OF_DOMAIN}: {name}")
    return point
