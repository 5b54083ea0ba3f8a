"""Special points of the toy, or any family of maps, followed over two parameters."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from pwmap.algebra.arguments import explained
from pwmap.diagrams.diagram import PointKind, PointStatus, SpecialPoint
from pwmap.plane.kinds import PlaneKind
from woodpecker.base.checks import interval
from woodpecker.base.settings import Settings
from woodpecker.base.shown import shown
from woodpecker.mechanics.toy import Toy, limits
from woodpecker.plane.curve import Curve, PlanePoint
from woodpecker.plane.families import Family, Spans
from woodpecker.plane.following import curve_through
from woodpecker.plane.toys import ToyFamily
from woodpecker.runs import DEFAULT, OUT_OF_DOMAIN, given, possible, settings_for

if TYPE_CHECKING:
    from pwmap import PiecewiseLinearMap

SAMPLES = 2000  # most samples of a toy's curve each way: some hundred are usual, more of no use


@explained("what else is varied is given to the toy or the map before")
def curve_in_two(
    source: Toy | Family | PiecewiseLinearMap,
    point: SpecialPoint | PlanePoint,
    parameters: tuple[str, str],
    span: Spans,
    *,
    value: float | None = None,
    kind: PointKind | str | None = None,
    settings: Settings | None = None,
) -> Curve:
    """Follow a special point both ways over two parameters.

    The curve goes on beyond points of codimension two and changes of word.

    Parameters
    ----------
    source
        The toy, with the value of the second parameter of the diagram; an exact map of
        :mod:`pwmap` with two parameters; or a family of maps, such as that of
        :func:`woodpecker.plane.family_from_sympy`.
    point
        A special point (LP, PD, BC, FF, or an EP at an end of the window) of a diagram over the
        first parameter; or a point of codimension two of a curve, where another curve starts.
    parameters, span
        Two parameters, those of a family in its order, and an interval of each. Curves of the toy
        end at the last values that it can have.
    value
        For a map or a family: the value of the second parameter in the diagram of the point.
    kind
        For a point of codimension two: the kind of the curve to follow, one of its ``starts``.
    settings
        Steps, window and tolerances. By default the window of a toy is (-2.5, -0.24) rad, and that
        of a map is infinite.

    Returns
    -------
    Curve
        Oriented so that at the point the second parameter increases, or the first if the second is
        constant; where it begins at a point of codimension two, it leads away.

    Raises
    ------
    ValueError
        If no curve passes through the point, the spans are not two pairs of ascending numbers that
        hold it, or ``value`` is missing or not wanted.
    TypeError
        If a parameter is unknown, or the settings are not :class:`Settings`.

    Examples
    --------
    >>> from woodpecker import continuation, curve_in_two, shoot
    >>> from woodpecker.examples import SETTINGS, paper_family
    >>> family = paper_family()  # over r and a
    >>> over_r, spans = family.over(0, (0.0, 1.25)), ((-1, 1), (1.1, 2))
    >>> border = continuation(over_r, shoot(over_r, 0.2, p=0.45), settings=SETTINGS).points[0]
    >>> curve = curve_in_two(family, border, ("r", "a"), spans, value=1.25, settings=SETTINGS)
    >>> str(curve.kind), curve.values[[0, -1]].round(9).tolist()  # r and a
    ('BC', [[0.0, 1.1], [0.0, 2.0]])
    """
    if isinstance(source, Toy) and value is not None:
        raise ValueError(f"a toy has its own values, got value = {value!r}")
    family = family_of(source, parameters)
    if not isinstance(point, SpecialPoint | PlanePoint):
        raise TypeError(f"point must be one of a diagram or of a curve, got {shown(point)}")
    if isinstance(source, Toy):
        return _of_toy(source, family, point, span, kind, settings)
    chosen = settings_for(settings, Settings())
    return curve_through(family, point, value, span=pair(span), kind=kind, settings=chosen)


def family_of(source: Toy | Family | PiecewiseLinearMap, parameters: tuple[str, str]) -> Family:
    """The family of a source over two parameters; ValueError unless they are its own, in order."""
    from pwmap import PiecewiseLinearMap
    from woodpecker.plane.families import checked_pair, family_from_pwmap

    if isinstance(source, Toy):
        return ToyFamily(source, parameters)
    if isinstance(source, PiecewiseLinearMap):
        return family_from_pwmap(source, parameters)
    if not callable(getattr(source, "over", None)):
        raise TypeError(
            f"expected a toy, an exact map of two parameters or a family, got {shown(source)}"
        )
    if checked_pair(parameters) != source.names:
        raise ValueError(
            f"parameters must be those of the family, {source.names}, got {parameters}"
        )
    return source


def _of_toy(
    toy: Toy, family: Family, point: SpecialPoint | PlanePoint, span: Spans,
    kind: PointKind | str | None, settings: Settings | None,
) -> Curve:  # fmt: skip
    """A curve of the toy, which ends at the limits of its parameters."""
    first, second = family.names
    wanted = [interval(f"span of {name}", each, finite=True) for name, each in
              zip(family.names, pair(span), strict=True)]  # fmt: skip
    spans = possible(toy, first, wanted[0]), possible(toy, second, wanted[1])
    chosen = settings_for(settings, DEFAULT, span=spans[0])
    value = None if isinstance(point, PlanePoint) else getattr(toy, second)
    found = curve_through(
        family, point, value, span=spans, kind=kind,
        settings=replace(chosen, max_samples=min(chosen.max_samples, SAMPLES)),
    )  # fmt: skip
    law = given(toy, first)[:1]
    rates = f"derivatives in {first} and {second}: the variational flow"
    points = tuple(_of_domain(each, toy, family.names, spans, wanted) for each in found.points)
    return replace(found, points=points, given=(*law, rates))


def pair(span: Spans) -> Spans:
    """The two intervals of a span over both parameters; ValueError unless there are two."""
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
    """A point; an end at a limit of a parameter of the toy becomes a limit of the domain (DL)."""
    if point.kind is not PlaneKind.END or point.status is PointStatus.OPEN:
        return point
    for name, value, span, asked in zip(names, point.values, spans, wanted, strict=True):
        for end, limit, beyond in zip(span, limits(toy, name), asked, strict=True):
            if value == end == limit != beyond:
                return replace(point, kind=PlaneKind.DOMAIN, cause=f"{OUT_OF_DOMAIN}: {name}")
    return point
