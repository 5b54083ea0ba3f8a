"""Borders of a map at one parameter: all in a window, and the one nearest to a point."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from woodpecker.base.checks import instance, interval, number, positive
from woodpecker.base.settings import Settings
from woodpecker.maps.pieces import Image, PiecewiseMap, map_of_pieces
from woodpecker.slices.borders import Border, beyond, one_sided_limit
from woodpecker.slices.extents import samples_to_border
from woodpecker.slices.margins import next_border
from woodpecker.slices.orbits import Orbit, at_parameter, ending_at
from woodpecker.slices.partition import partition


def borders_in(
    map_: PiecewiseMap, p: float, window: tuple[float, float], settings: Settings | None = None
) -> list[Border]:
    """The borders of a map in a window of x, in ascending order.

    Each is located to rounding; :attr:`~woodpecker.slices.Border.cause` says what happens there.

    Parameters
    ----------
    map_, p
        For instance :class:`woodpecker.ToyPieces`, and its parameter.
    window
        Interval of x.
    settings
        Scales and cut-offs, by default for this window. Pieces shorter than ``finest`` are passed
        over, and those shorter than ``coarse`` that lead out of the window.

    Returns
    -------
    list of Border
        Empty if one piece holds the whole window.

    Raises
    ------
    ValueError
        If the window is not two finite, ascending numbers.
    TypeError
        If the map has no pieces.

    Examples
    --------
    >>> from woodpecker import Toy, ToyPieces
    >>> from woodpecker.slices import borders_in
    >>> for border in borders_in(ToyPieces(Toy(), "eps_n1"), 0.15, (-0.9, -0.88)):
    ...     print(f"{border.x:.9f} {abs(border.jump):.6f} {border.cause}")
    -0.884773344 0.305658 the beak and the upper sleeve strike at once
    -0.882395391 0.000000 the upper sleeve only just sticks in the compression
    """
    ends = interval("window", window, finite=True)
    chosen = settings if settings is not None else Settings(window=ends)
    instance("settings", chosen, Settings)
    found = partition(map_of_pieces(map_), number("p", p), ends, chosen).borders(chosen)
    return [_sharpened(map_, border, chosen) for border in found]


def nearest_border(
    map_: PiecewiseMap, x: float, p: float, within: float, settings: Settings | None = None
) -> Border | None:
    """The border of a map nearest to a point, on either side.

    Parameters
    ----------
    map_, x, p
        The map, the point and the parameter.
    within
        Largest distance of the border.
    settings
        Scales.

    Returns
    -------
    Border or None
        As seen from the piece at the point; None if that piece extends beyond ``within``.

    Raises
    ------
    ValueError
        If the map has no value at the point, or the distance is not positive.
    TypeError
        If the map has no pieces.

    Examples
    --------
    >>> from woodpecker.examples import two_lines
    >>> from woodpecker.slices import nearest_border
    >>> nearest_border(two_lines(), 0.3, 0.5, within=1.0).x
    0.0
    """
    x, p, within = number("x", x), number("p", p), positive("within", within)
    chosen = settings if settings is not None else Settings()
    instance("settings", chosen, Settings)
    here = map_of_pieces(map_).at(x, p)
    if here.reason:
        raise ValueError(f"the map has no value at x = {x}, p = {p}: {here.reason}")
    found = list[Border]()
    for side in (-1, 1):
        limit = x + side * within
        end = samples_to_border(here, x, p, side, limit, chosen)[-1]
        code = end.code
        if code < 0 and end.x != limit:
            code = _ahead(end.image, side, chosen)
        if code >= 0:
            found.append(border_of(map_, end.image, code, end.x, p, side, chosen))
    return min(found, key=lambda border: abs(border.x - x), default=None)


def _ahead(image: Image, side: int, settings: Settings) -> int:
    """The margin about to vanish where a piece could be followed no further; -1 if none is near."""
    away, code = next_border(image, side)
    return code if away <= settings.beside * settings.x_scale else -1


def crosses(border: Border) -> bool:
    """Whether the limits of a map at a border lie on different sides of the diagonal.

    Parameters
    ----------
    border
        A border with the images on both sides of it.

    Returns
    -------
    bool
        False if a limit lies on the diagonal, or is not known.

    Examples
    --------
    >>> from woodpecker.examples import two_lines
    >>> from woodpecker.slices import borders_in, crosses
    >>> lines = two_lines()
    >>> [[crosses(border) for border in borders_in(lines, p, (-2, 2))] for p in (-0.5, 0.5)]
    [[False], [True]]
    """
    return (border.inner.value - border.x) * (border.outer.value - border.x) < 0.0


def border_of(
    map_: PiecewiseMap, inner: Image, code: int, x: float, p: float, side: int, settings: Settings
) -> Border:
    """The border at the end x of a piece, on the given side, with the image beyond it."""
    outer, outer_code = beyond(map_, x, p, side, settings)
    return _sharpened(map_, Border(x, p, inner, code, side, outer, outer_code), settings)


def _sharpened(map_: PiecewiseMap, border: Border, settings: Settings) -> Border:
    """A border moved to the root of its margin, unless Newton's method leads elsewhere."""
    inner, at = border.inner, border.x
    if inner.reason:  # rounding has put it beyond the end of a root, where there is no value
        at -= inner.margin(border.code) / float(inner.gradient(border.code)[0])
        inner = inner.piece.at(at, border.p)
    start = Orbit(np.array([at]), border.p, (inner,))
    root = at_parameter(start, settings, ending_at(1, border.code))
    if root is None or abs(root.x[0] - border.x) > settings.beside * settings.x_scale:
        return border
    x = float(root.x[0])
    inner = one_sided_limit(root.images[0], x, border.p, -border.side, settings)
    outer, code = beyond(map_, x, border.p, border.side, settings)
    return replace(border, x=x, inner=inner, outer=outer, outer_code=code)
