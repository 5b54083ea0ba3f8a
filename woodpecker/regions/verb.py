"""Regions with the same cycles over two parameters of the toy, or of any family of maps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from pwmap.algebra.arguments import check_functions
from woodpecker.base.checks import instance, interval, iterates
from woodpecker.base.settings import Settings
from woodpecker.base.shown import shown
from woodpecker.mechanics.toy import WINDOW, Toy
from woodpecker.plane.curve import Curve
from woodpecker.plane.families import Family, Pair, Spans
from woodpecker.regions.regions import Division, Progress, Regions
from woodpecker.regions.survey import Survey
from woodpecker.runs import DEFAULT, nothing, possible, settings_for
from woodpecker.search.diagrams import finite_window
from woodpecker.two_parameters import family_of, pair

if TYPE_CHECKING:
    from pwmap import PiecewiseLinearMap


def parameter_regions(
    source: Toy | Family | PiecewiseLinearMap,
    parameters: tuple[str, str],
    span: Spans,
    *,
    curves: Sequence[Curve] = (),
    orders: Sequence[int] = (1,),
    window: tuple[float, float] | None = None,
    settings: Settings | None = None,
    survey: Survey | None = None,
    progress: Progress | None = None,
) -> Regions:
    """Cut a rectangle of two parameters into regions with the same cycles.

    Stable and unstable cycles of some periods are counted at one place of each region and at random
    places; between two places that disagree a curve of special points is found and followed.
    Attractors are found at one place of each region.

    Parameters
    ----------
    source
        The toy, whose own values of the two parameters do not matter; an exact map of :mod:`pwmap`
        with two parameters; or a family of maps (:func:`woodpecker.plane.family_from_sympy`).
    parameters, span
        The two parameters, those of a family in its order, and an interval of each; for the toy
        cut to the domain of the parameter.
    curves
        Curves that are already known, if any.
    orders
        Periods of the cycles that are counted.
    window
        Interval (phi_S [rad]) of all points of cycles and of starts of orbits; by default that of
        the settings. A curve also bounds where cycles leave it. The whole window of the toy gives
        hundreds of islands, a smaller one simpler regions.
    settings
        Steps, tolerances, and the window that orbits must not leave, if finite; by default
        (-2.5, -0.24) rad for the toy. Their span is replaced.
    survey
        Numbers of random places and of curves, distances and orbits.
    progress
        Called with each curve that is found.

    Returns
    -------
    Regions
        The regions, and all counted places that disagree with them.

    Raises
    ------
    ValueError, TypeError
        If an order is below 1, the window is not finite, curves are over other parameters, or an
        argument has a wrong type.

    Examples
    --------
    >>> from woodpecker import Toy
    >>> from woodpecker.regions import Survey, parameter_regions
    >>> small = Survey(checks=4)
    >>> span = ((0.45, 0.5), (0.3, 0.31))
    >>> names, window = ("eps_n1", "mu_2"), (-0.7, -0.45)
    >>> found = parameter_regions(Toy(), names, span, survey=small, window=window)
    >>> [region.census for region in found.regions]
    [(Count(period=1, stable=1, unstable=0),)]
    """
    check_functions(progress=progress)
    if survey is not None:
        instance("survey", survey, Survey)
    family = family_of(source, parameters)
    one, other = (
        interval(f"span of {name}", each, finite=True)
        for name, each in zip(family.names, pair(span), strict=True)
    )
    if isinstance(source, Toy):
        chosen = settings_for(settings, DEFAULT, window=WINDOW)
        one, other = (
            possible(source, name, each)
            for name, each in zip(family.names, (one, other), strict=True)
        )
    else:
        chosen = settings_for(settings, Settings())
    within = chosen.window
    if window is not None:
        chosen = replace(chosen, window=interval("window", window, finite=True))
    if not all(map(math.isfinite, within)):
        within = chosen.window
    finite_window(chosen)
    if not isinstance(curves, Sequence):
        raise TypeError(f"curves must be a list of them, got {shown(curves)}")
    for curve in curves:
        instance("curve", curve, Curve)
        if curve.names != family.names:
            raise ValueError(f"expected curves over {family.names}, got one over {curve.names}")
    found = Division(family, (one, other), chosen, iterates(orders), survey or Survey(), within)
    for curve in curves:
        found.add(curve)
    found.complete(progress or nothing)
    return found.result()


def regions_of(
    family: Family, curves: Sequence[Curve] = (), *, span: Spans, settings: Settings,
    within: Pair | None = None, **options: Any,
) -> Regions:  # fmt: skip
    """A former name of :func:`parameter_regions`, until after the next release."""
    if within is not None:  # the window that orbits must not leave
        settings, options = replace(settings, window=within), {**options, "window": settings.window}
    return parameter_regions(
        family, family.names, span, curves=curves, settings=settings, **options
    )
