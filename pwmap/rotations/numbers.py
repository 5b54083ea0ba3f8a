"""Rotation numbers of a map without parameters, exact where they are found to be rational.

Let b be the break, t = L(b) and l = R(b) the limits from the left and the right, l < b < t. Joining
the ends of [l, t] gives a circle, on which the map has a lift of degree one: F = L on the left of b
and R + (t - l) on the right, which is continuous at b and jumps at the joint, from R(t) to L(l). If
it jumps upwards (a *gap*), the lift increases and has a single rotation number. Otherwise (an
*overlap*) rotation numbers fill an interval, whose ends are those of the monotone lifts that bound
F from below and above: F with a constant piece in place of the overlap [Granados2017].

If F^n moves a point by k turns or more, the rotation number is at least k/n. It *equals* k/n if
there is a cycle of that number, by the two conditions of :mod:`pwmap.rotations.tongues`, or if the
constant piece returns to itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from sympy import QQ

from pwmap.algebra.arguments import checked_count, explained
from pwmap.algebra.exact import Number, pair
from pwmap.algebra.roots import simplest_between
from pwmap.longrun.line import MapLine, line_of
from pwmap.maps.piecewise_linear import PiecewiseLinearMap, check_values
from pwmap.rotations.pieces import increasing_pieces
from pwmap.rotations.words import rotational_word

ITERATES = 1000  # by default: bounds then differ by at most 1/1000


@dataclass(frozen=True, slots=True, kw_only=True)
class RotationNumber:
    """Closed bounds from :func:`rotation_number_at`, and the ``iterates`` that they took."""

    lower: Fraction
    upper: Fraction
    iterates: int

    @property
    def exact(self) -> bool:
        """Whether the rotation number is known exactly; it is then rational."""
        return self.lower == self.upper


@dataclass(frozen=True, slots=True, kw_only=True)
class RotationInterval:
    """The smallest and the largest rotation number, of :func:`rotation_interval`."""

    least: RotationNumber
    greatest: RotationNumber


@explained()
def rotation_number_at(map_: PiecewiseLinearMap, iterates: int = ITERATES) -> RotationNumber:
    """The rotation number of a map of two increasing pieces that do not overlap.

    Parameters
    ----------
    map_, iterates
        As for :func:`rotation_interval`. With enough iterates a rational number is found exactly;
        that of a contracted rotation, x -> a x + d mod 1 with rational a and d, is always rational
        [Laurent2018].

    Returns
    -------
    RotationNumber
        Bounds, which are equal if the number is known exactly.

    Raises
    ------
    TypeError, ValueError, UndecidedError
        As :func:`rotation_interval`; also a ValueError if pieces overlap and have several numbers.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap
    >>> from pwmap.rotations import rotation_number_at
    >>> circle = PiecewiseLinearMap([("x/2 + 3/5", "x < 4/5"), ("x/2 - 2/5", "x >= 4/5")])
    >>> rotation_number_at(circle).lower
    Fraction(1, 3)
    """
    found = rotation_interval(map_, iterates)
    least, greatest = found.least, found.greatest
    if _overlap(_line(map_)) and not (least.exact and least == greatest):
        raise ValueError(
            "the pieces overlap, the rotation numbers fill an interval from "
            f"{least.lower} to {greatest.upper}: ask for rotation_interval"
        )
    return RotationNumber(
        lower=max(least.lower, greatest.lower),
        upper=min(least.upper, greatest.upper),
        iterates=min(least.iterates, greatest.iterates),
    )


@explained()
def rotation_interval(map_: PiecewiseLinearMap, iterates: int = ITERATES) -> RotationInterval:
    """The smallest and the largest rotation number of a map of two increasing pieces.

    Parameters
    ----------
    map_, iterates
        A map without parameters (see :meth:`pwmap.PiecewiseLinearMap.at`), and the number of
        iterates that may be used for each end.

    Returns
    -------
    RotationInterval
        Bounds of both ends, which are equal for an end that is known exactly.

    Raises
    ------
    TypeError, ValueError
        If the map has not two increasing pieces and one break, has parameters, or maps no interval
        around the break into itself; if ``iterates`` is no integer of at least 1.
    UndecidedError
        If the sign of a slope depends on parameters.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap
    >>> from pwmap.rotations import rotation_interval
    >>> circle = PiecewiseLinearMap([("x/2 + 3/5", "x < 4/5"), ("x/2 - 2/5", "x >= 4/5")])
    >>> least = rotation_interval(circle).least
    >>> least.lower, least.exact
    (Fraction(1, 3), True)
    """
    steps = checked_count(iterates, "the number of iterates")
    line = _line(map_)
    fixed = _fixed(line)
    if fixed is not None:
        known = RotationNumber(lower=fixed, upper=fixed, iterates=1)
        return RotationInterval(least=known, greatest=known)
    greatest, mirrored = _greatest(line, steps), _greatest(_reflected(line), steps)
    least = RotationNumber(
        lower=1 - mirrored.upper, upper=1 - mirrored.lower, iterates=mirrored.iterates
    )
    return RotationInterval(least=least, greatest=greatest)


def _line(map_: PiecewiseLinearMap) -> MapLine:
    increasing_pieces(map_)
    check_values(map_)
    return line_of(map_)


def _reflected(line: MapLine) -> MapLine:
    """The map in the coordinate -x, in which a rotation number r becomes 1 - r."""
    branches, owners = (
        tuple(
            piece._replace(intercept=-piece.intercept, lower=-piece.upper, upper=-piece.lower)
            for piece in reversed(pieces)
        )
        for pieces in (line.branches, line.owners)
    )
    return MapLine(branches, owners)


def _limits(line: MapLine) -> tuple[Number, Number]:
    """The limits t and l at the break, from the left and from the right."""
    left, right = (line.image(germ).x for germ in line.germs)
    return left, right


def _fixed(line: MapLine) -> Fraction | None:
    """The rotation number, 0 or 1, if one piece maps into itself; None if neither does."""
    # ValueError if no bounded interval around the break is mapped into itself.
    (left, right), (at,), (top, low) = line.branches, line.breaks, _limits(line)
    stays = top <= at, low >= at
    if all(stays):
        raise ValueError("both pieces map into themselves: orbits do not come round")
    if any(stays):
        slope = (left if stays[0] else right).slope
        if slope < 1 or (slope == 1 and at in (top, low)):
            return Fraction(int(stays[1]))
    elif left(low) >= low and right(top) <= top:
        return None
    raise ValueError("no bounded interval around the break is mapped into itself")


def _overlap(line: MapLine) -> bool:
    """Whether the images of the two pieces overlap, so that the map is not invertible."""
    (left, right), (at,), (top, low) = line.branches, line.breaks, _limits(line)
    return bool(low < at < top and right(top) > left(low))


def _greatest(line: MapLine, iterates: int) -> RotationNumber:
    """The rotation number of the monotone lift that bounds F from above."""
    (left, right), (at,), (top, low) = line.branches, line.breaks, _limits(line)
    floor_ = right(top)
    # this lift is constant from the joint l up to the level at which L(x) reaches R(t)
    level = max(low, (floor_ - left.intercept) / left.slope)
    x, turns = top, 0
    lower, upper = Fraction(0), Fraction(1)
    tried = set[Fraction]()
    for n in range(1, iterates + 1):
        if x > at:
            x, turns = right(x), turns + 1
        else:
            x = max(left(x), floor_)
        # after n steps and k turns from t the orbit lies in [l, t], so that the number is between
        # (k - 1)/n and k/n; it is at most (k - 1)/n on the constant piece, at least k/n back at t
        lower = max(lower, Fraction(turns - (x != top), n))
        upper = min(upper, Fraction(turns - (x <= level), n))
        simplest = lower
        if lower < upper:
            inner = simplest_between(*(QQ(*end.as_integer_ratio()) for end in (lower, upper)))
            simplest = min(lower, upper, Fraction(*pair(inner)), key=lambda x: x.denominator)
        if lower == upper or (simplest not in tried and _has_cycle(line, simplest, level)):
            return RotationNumber(lower=simplest, upper=simplest, iterates=n)
        tried.add(simplest)
    return RotationNumber(lower=lower, upper=upper, iterates=iterates)


def _has_cycle(line: MapLine, rotation: Fraction, level: Number) -> bool:
    """Whether a cycle of this rotation number, which may touch b, avoids the constant piece."""
    word = ["LR".index(letter) for letter in rotational_word(rotation)]
    whole = line.along(word)
    if whole.slope == 1:  # then the orbit of t itself returns, or no cycle is isolated
        return False
    x = whole.fixed_point  # the leftmost point of the cycle; a fixed point may lie beyond t
    return bool(level <= x <= _limits(line)[0]) and line.follows(x, word)
