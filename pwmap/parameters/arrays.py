"""Branches as arrays of floats, for drawing only.

Along a curved branch x and multiplier are computed in floats with a bound of rounding errors, or
from exact numbers where that is too large (near a pole, or where large terms cancel).
"""

from __future__ import annotations

from math import inf, nan
from typing import Any

import numpy as np
from sympy import QQ

from pwmap.algebra.exact import Fraction_, Number, to_float
from pwmap.diagrams.data import BranchKind, FloatArray
from pwmap.parameters.axis import Axis
from pwmap.parameters.branches import Continuation, remembered
from pwmap.parameters.segments import Segment, SegmentCurve

POINTS = 65  # along a branch that is curved: smooth to the eye in a picture of a page's width
ROUNDING = 2.0**-53  # of one operation, relative
TRUSTED = 2.0**-40  # relative error of a value that is drawn; a picture shows 2**-12
RESOLVED = 2.0**-30  # width of an interval over its ends from which floats can part it


def curve_arrays(continuation: Continuation, curve: SegmentCurve) -> tuple[FloatArray, list[int]]:
    """Parameter, x and multiplier of a branch, (3, n), and the first sample of each segment."""
    parts = []
    for segment, entered in curve:
        found = segment_arrays(continuation, segment)[:, :: -1 if entered else 1]
        # a sample that two segments share is that of the later one
        parts.append(found if segment is curve[-1][0] else found[:, : max(1, len(found[0]) - 1)])
    starts = np.cumsum([0, *(len(part[0]) for part in parts[:-1])])
    return np.hstack(parts), starts.tolist()


@remembered
def segment_arrays(continuation: Continuation, segment: Segment) -> FloatArray:
    """Parameter, x and multiplier along a segment, (3, n); at its ends only if it is straight."""
    axis, slope = continuation.axis, continuation.orbits.slope(segment.key.word)
    ends = [continuation.number(end) for end in continuation.ends(segment)]
    smooth = segment.key.kind is BranchKind.FIXED_POINT and not segment.is_isolated
    multipliers = (
        axis.number(slope, place) if smooth and continuation.is_finite(slope, place) else nan
        for place in segment.places
    )
    outer = np.array([(*end, m) for end, m in zip(ends, multipliers, strict=True)]).T
    if segment.band is not None:
        return outer
    if segment.places[0] == segment.places[1]:
        return outer[:, :1]
    position = continuation.position(segment.key)
    degrees = [axis.degree(number) for number in (*position, *slope)]
    if degrees[0] <= 1 and not any(degrees[1:]):
        return outer
    places, parameter = _spread(axis, segment, *(p for p, _ in ends))
    x = values(axis, position, places, parameter)
    multiplier = values(axis, slope, places, parameter) if smooth else np.full(len(x), nan)
    return np.hstack([outer[:, :1], [parameter, x, multiplier], outer[:, 1:]])


def _spread(axis: Axis, segment: Segment, low: float, high: float) -> tuple[list[Any], FloatArray]:
    """Places inside a segment, in equal steps, and the same as floats."""
    steps = np.arange(1, POINTS - 1) / (POINTS - 1)
    parameter = low + (high - low) * steps
    if RESOLVED * max(abs(low), abs(high)) < high - low < inf:
        return [axis.place(QQ(*p.as_integer_ratio())) for p in parameter.tolist()], parameter
    places = axis.spread(*segment.places, POINTS - 2)
    return places, np.array([axis.number(axis.identity, place) for place in places])


def values(axis: Axis, fraction: Fraction_, places: list[Any], parameter: FloatArray) -> FloatArray:
    """A quotient at some places, which are also given as floats."""
    with np.errstate(all="ignore"):
        (top, loose), (bottom, slack) = (_horner(axis, number, parameter) for number in fraction)
        found = top / bottom
        trusted = (loose <= TRUSTED * np.abs(top)) & (slack <= TRUSTED * np.abs(bottom))
    for i in np.flatnonzero(~(trusted & np.isfinite(found))):
        found[i] = axis.number(fraction, places[i])
    return found


def _horner(axis: Axis, number: Number, parameter: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A polynomial in floats by Horner's rule, and a bound of the error."""
    coefficients = np.array([to_float(c) for c in axis.coefficients(number)], dtype=float)
    size = np.polyval(np.abs(coefficients), np.abs(parameter))
    return np.polyval(coefficients, parameter), 2 * len(coefficients) * ROUNDING * size
