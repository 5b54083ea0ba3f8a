"""Regions of two parameters of the toy in which the same cycles live."""

from __future__ import annotations

from collections.abc import Sequence

from woodpecker.base.checks import interval
from woodpecker.base.settings import Settings
from woodpecker.mechanics.toy import WINDOW, Toy
from woodpecker.plane.curve import Curve
from woodpecker.plane.toys import ToyFamily
from woodpecker.regions.regions import Progress, Regions, regions_of
from woodpecker.regions.survey import Survey
from woodpecker.runs import DEFAULT, possible, settings_for
from woodpecker.two_parameters import Spans, pair


def parameter_regions(
    toy: Toy,
    parameters: tuple[str, str],
    span: Spans,
    *,
    curves: Sequence[Curve] = (),
    orders: Sequence[int] = (1,),
    window: tuple[float, float] = WINDOW,
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
    toy
        The toy; its own values of the two parameters do not matter.
    parameters, span
        Two parameters of the toy, and an interval of each, cut to what the toy can have.
    window
        Interval of phi_S [rad] in which all points of a cycle lie. Where a cycle leaves it is a
        curve, too. The whole window has hundreds of islands: the smaller it is, the simpler is what
        is found. Orbits start in it.
    settings
        Steps and tolerances; span and window are taken from above.
    curves, orders, survey, progress
        As :func:`regions_of` takes them.

    Returns
    -------
    Regions
        With how many random places agree; those that do not are listed.

    Raises
    ------
    ValueError
        As of :func:`regions_of`, and if there are not two different parameters and intervals.
    TypeError
        If a parameter is unknown, or the settings are no :class:`Settings`.

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
    family = ToyFamily(toy, parameters)
    one, other = (
        possible(toy, name, interval(f"span of {name}", each, finite=True))
        for name, each in zip(family.names, pair(span), strict=True)
    )
    chosen = settings_for(settings, DEFAULT, window=interval("window", window, finite=True))
    return regions_of(
        family, curves, span=(one, other), settings=chosen, orders=orders, survey=survey,
        progress=progress, within=WINDOW,
    )  # fmt: skip
