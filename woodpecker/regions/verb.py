"""Regions of two parameters of the toy, or of any family of maps, in which the same cycles live."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from woodpecker.base.checks import function, instance, interval, iterates
from woodpecker.base.settings import Settings
from woodpecker.base.shown import shown
from woodpecker.mechanics.toy import WINDOW, Toy
from woodpecker.plane.curve import Curve
from woodpecker.plane.families import Family, Pair
from woodpecker.regions.regions import Progress, Regions, divided
from woodpecker.regions.survey import Survey
from woodpecker.runs import DEFAULT, nothing, possible, settings_for
from woodpecker.search.diagrams import finite_window
from woodpecker.two_parameters import Spans, family_of, pair

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
    """Cut a rectangle of two parameters into regions in which the same cycles live.

    In each region the stable and the unstable cycles of some periods are counted, at one place and
    at random ones; where two places disagree the curve between them is found and followed. What
    orbits come to is looked at in one place of each region.

    Parameters
    ----------
    source
        The toy, an exact map of :mod:`pwmap` with two parameters, or a family of maps, such as
        :func:`woodpecker.plane.family_from_sympy` makes. The toy's own values of the two parameters
        do not matter.
    parameters, span
        Two parameters, those of a family in its order, and an interval of each, cut to what the toy
        can have.
    curves
        That are known already; none is needed.
    orders
        Periods of the cycles that are counted.
    window
        Interval (phi_S [rad]) in which all points of a cycle lie, by default that of the settings.
        Where a cycle leaves it is a curve, too. The whole window of the toy has hundreds of
        islands: the smaller it is, the simpler is what is found. Orbits start in it.
    settings
        Steps and tolerances, and the window that orbits must not leave, if it has ends; that of a
        toy is (-2.5, -0.24) rad. The span is taken from above.
    survey
        How many random places and curves.
    progress
        Called with every curve that is found.

    Returns
    -------
    Regions
        With how many random places agree; those that do not are listed.

    Raises
    ------
    ValueError
        If an order is not at least 1, the window is not finite, curves are over other parameters,
        or there are not two different parameters and intervals.
    TypeError
        If the source is none, a parameter is unknown, or the settings are no :class:`Settings`.

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
    function("progress", progress)
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
    return _regions(
        family, curves, span=(one, other), settings=chosen, orders=orders, survey=survey,
        progress=progress, within=within,
    )  # fmt: skip


def _regions(
    family: Family, curves: Sequence[Curve] = (), *, span: Spans, settings: Settings,
    orders: Sequence[int] = (1,), survey: Survey | None = None, progress: Progress | None = None,
    within: Pair | None = None,
) -> Regions:  # fmt: skip
    """The same for a family; orbits must not leave ``within``, by default the window."""
    finite_window(settings)
    if survey is not None:
        instance("survey", survey, Survey)
    if not isinstance(curves, Sequence):
        raise TypeError(f"curves must be a list of them, got {shown(curves)}")
    for curve in curves:
        instance("curve", curve, Curve)
        if curve.names != family.names:
            raise ValueError(f"expected curves over {family.names}, got one over {curve.names}")
    return divided(
        family, curves, span, settings, iterates(orders), survey or Survey(),
        settings.window if within is None else within, progress or nothing,
    )  # fmt: skip


regions_of = _regions  # the name it had; it goes after the next release
