"""A check of the derivatives that a map gives, against differences of its values and margins."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from operator import methodcaller

from woodpecker.base.checks import number, positive
from woodpecker.maps.pieces import Image, Piece, PiecewiseMap, map_of_pieces

# With the first step h the error h^4 of the extrapolated difference is below 1e-14, and NOISE / h
# is 7e-12. The second stays clear of jumps and kinks that are not so close; NOISE / h is 5e-10.
RELATIVE_STEPS = 2.0**-12, 2.0**-18
NOISE = 2.0**-49  # relative rounding of a value: eight spacings of doubles
DOUBT = 10.0  # a derivative is wrong if it is off by this many estimated errors of the difference

Reading = Callable[[Image], float]


def check_derivatives(
    map_: PiecewiseMap, points: Iterable[tuple[float, float]], tolerance: float = 1e-7
) -> None:
    """Check the derivatives of a map, and of its margins, against differences of values.

    Parameters
    ----------
    map_
        The map; its pieces at the points are checked.
    points
        Pairs (x, p) inside pieces.
    tolerance
        Largest error of a derivative, relative to its modulus or 1, whichever is larger, in
        addition to the error of the difference, which is large next to a square root.

    Raises
    ------
    ValueError
        If a derivative is wrong: says which, where, and what it should be; if the map has no value
        at a point, or there is no point.
    TypeError
        If the map has no pieces, or one lacks ``key``, ``word``, ``at`` or ``cause``.

    Examples
    --------
    >>> from woodpecker import FormulaMap, FormulaPiece, Smooth
    >>> from woodpecker.maps import check_derivatives
    >>> wrong = Smooth(lambda x, p: p - x*x, dx=lambda x, p: -x, dp=lambda x, p: 1.0)
    >>> check_derivatives(FormulaMap([FormulaPiece("A", wrong, {})]), [(0.5, 0.2)])
    Traceback (most recent call last):
        ...
    ValueError: the derivative in x of the value of piece 'A' at x = 0.5, p = 0.2 is given as -0.5,
    but differences of values say -1
    """
    positive("tolerance", tolerance)
    map_of_pieces(map_)
    for x, p in _pairs(points):
        here = map_.at(x, p)
        if here.reason:
            raise ValueError(f"the map has no value at x = {x}, p = {p}: {here.reason}")
        _complete(here, x, p)
        for name, by, given, read in _claims(here):
            differences = (_difference(here.piece, read, by, x, p, step) for step in RELATIVE_STEPS)
            known = [each for each in differences if not math.isnan(each[0])]
            if not known:
                raise ValueError(
                    f"{name} of piece {here.piece.word!r} cannot be compared at x = {x}, "
                    f"p = {p}: it has no value beside it, so choose a point further inside"
                )
            if not any(
                abs(given - found) <= tolerance * max(1.0, abs(found)) + DOUBT * doubt
                for found, doubt in known
            ):
                raise ValueError(
                    f"the derivative in {by} of {name} of piece {here.piece.word!r} at "
                    f"x = {x}, p = {p} is given as {given:.10g}, but differences of values "
                    f"say {known[0][0]:.10g}"
                )


def _complete(image: Image, x: float, p: float) -> None:
    """TypeError if a piece lacks an attribute; ValueError unless its margins and codes match."""
    for name in ("key", "word", "at", "cause"):
        if not hasattr(image.piece, name):
            raise TypeError(f"a piece must have {name!r}, {image.piece!r} has not")
    try:
        hash(image.piece.key)
    except TypeError as error:
        raise TypeError(
            f"the key of a piece must be hashable, got {image.piece.key!r} of {image.piece.word!r}"
        ) from error
    causes, m = image.causes.tolist(), len(image.margins)
    if image.gradients.shape != (m, 2) or len(causes) != m or sorted(set(causes)) != causes:
        raise ValueError(
            f"piece {image.piece.word!r} at x = {x}, p = {p} must give as many margins as pairs of "
            f"derivatives and as ascending codes, got {m}, {image.gradients.shape}, {causes}"
        )


def _pairs(points: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
    """The points (x, p) of a user as pairs of floats; ValueError unless there are such."""
    try:
        pairs = [(number("x", x), number("p", p)) for x, p in points]
    except (TypeError, ValueError) as error:
        raise ValueError(f"points must be pairs (x, p) of real numbers, got {points!r}") from error
    if not pairs:
        raise ValueError("points must hold at least one pair (x, p), got none")
    return pairs


def _claims(image: Image) -> Iterator[tuple[str, str, float, Reading]]:
    """Each derivative that an image gives: its function, variable, value, and how to read it."""
    for by, given in (("x", image.slope), ("p", image.d_parameter)):
        yield "the value", by, given, lambda at: at.value
    for code in image.causes.tolist():
        name, read = f"the margin {image.piece.cause(code)!r}", methodcaller("margin", code)
        for by, given in zip("xp", image.gradient(code).tolist(), strict=True):
            yield name, by, given, read


def _difference(
    piece: Piece, read: Reading, by: str, x: float, p: float, step: float
) -> tuple[float, float]:
    """A central difference, extrapolated to order h^4, and its error; nan if values are missing."""

    def value(shift: float) -> float:
        return read(piece.at(x + shift, p) if by == "x" else piece.at(x, p + shift))

    h = step * max(1.0, abs(x if by == "x" else p))
    ends = [(value(-s), value(s)) for s in (h, 0.5 * h)]
    coarse, fine = ((b - a) / w for (a, b), w in zip(ends, (2.0 * h, h), strict=True))
    rounding = NOISE * max(abs(v) for pair in ends for v in pair) / h
    best = (4.0 * fine - coarse) / 3.0
    return best, abs(best - fine) + rounding if math.isfinite(best) else math.nan
