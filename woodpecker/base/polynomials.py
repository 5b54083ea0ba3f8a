"""Roots of polynomials over [0, 1], isolated by the signs of Bernstein coefficients.

A polynomial has at most as many roots in an interval as its Bernstein coefficients there have
changes of sign, and exactly as many if that is 0 or 1: intervals are halved until it is.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.compiled import jit, part

HALVINGS = 40  # of an interval at most: below 1e-12 of it rounding decides the signs
FLAT = 1e-24  # a polynomial counts as zero if all coefficients are smaller
CLOSE = 2.0**-51  # relative: a Newton step shorter than this is the last
SOLVING = 100  # steps of a bracketed Newton's method: bisection alone needs 53
START_ROOT = 1e-6  # a root so close to 0 is a fall at the start that rounding has displaced
WHOLE, LEFT, RIGHT = range(3)  # matrices of :func:`bernstein`
LOW, HIGH, GUESS, FALLS = range(4)  # columns of isolating intervals; the last is 1.0 for a fall


@lru_cache(maxsize=32)
def bernstein(size: int) -> Floats:
    """Matrices (3, size, size) that convert coefficients c (size,), as ``c @ matrix``.

    WHOLE converts power coefficients, lowest first, to Bernstein coefficients over [0, 1]; LEFT and
    RIGHT convert these to those over the left and the right half.
    """
    n = size - 1
    whole = [[math.comb(j, k) / math.comb(n, k) for j in range(size)] for k in range(size)]
    left = np.array([[math.comb(j, k) / 2.0**j for j in range(size)] for k in range(size)])
    return np.array([whole, left, left[::-1, ::-1]])


@jit
def evaluated(c: Floats, t: float) -> Floats:
    """Values (count,) at t of polynomials (count, size), lowest coefficient first."""
    count, size = c.shape
    found = np.empty(count)
    for k in range(count):
        value = 0.0
        for j in range(size - 1, -1, -1):  # Horner's rule
            value = value * t + c[k, j]
        found[k] = value
    return found


@part
def _changes(b: Floats) -> int:
    found = 0
    for k in range(len(b) - 1):
        found += (b[k] > 0.0) != (b[k + 1] > 0.0)
    return found


@jit
def _isolated(b: Floats, matrices: Floats, until_fall: bool) -> Floats:
    """Isolating intervals of the roots (roots, 4), ascending; up to the first fall if asked."""
    # Several changes of sign in the narrowest interval are one multiple root, which counts if the
    # signs at both ends differ.
    size, count, top = len(b), 0, 1
    found = np.empty((size, 4))
    ends, stack = np.empty((HALVINGS + 2, 3)), np.empty((HALVINGS + 2, size))
    ends[0, 0], ends[0, 1], ends[0, 2] = 0.0, 1.0, 0.0
    stack[0] = b
    while top and count < size:
        top -= 1
        low, high, depth = ends[top, 0], ends[top, 1], ends[top, 2]
        here = stack[top].copy()
        changes = _changes(here)
        if changes == 0:
            continue
        falls = here[0] > 0.0
        if changes == 1 or (depth == HALVINGS and falls != (here[-1] > 0.0)):
            guess = low + (high - low) * here[0] / (here[0] - here[-1])
            found[count, LOW], found[count, HIGH], found[count, GUESS] = low, high, guess
            found[count, FALLS] = 1.0 if falls else 0.0
            count += 1
            if until_fall and falls:
                break
        elif depth < HALVINGS:
            middle = 0.5 * (low + high)
            stack[top], stack[top + 1] = here @ matrices[RIGHT], here @ matrices[LEFT]
            ends[top, 0], ends[top, 1], ends[top, 2] = middle, high, depth + 1
            ends[top + 1, 0], ends[top + 1, 1], ends[top + 1, 2] = low, middle, depth + 1
            top += 2
    return found[:count]


@part
def _solved(c: Floats, inside: Floats) -> float:
    """Root in an isolating interval, by Newton's method safeguarded by bisection."""
    low, high, x = float(inside[LOW]), float(inside[HIGH]), float(inside[GUESS])
    for _ in range(SOLVING):
        value = slope = 0.0
        for k in range(len(c) - 1, -1, -1):
            slope = slope * x + value
            value = value * x + float(c[k])
        if (value > 0.0) == (inside[FALLS] == 1.0):
            low = x
        else:
            high = x
        new = x - value / slope if slope != 0.0 else low
        if abs(new - x) <= CLOSE * abs(new):
            return new  # perhaps just outside the bracket
        if not low < new < high:
            new = 0.5 * (low + high)
            if abs(new - x) <= CLOSE * abs(new):
                return new
        x = new
    return x


@jit
def fall(c: Floats, b: Floats, at_once: bool, matrices: Floats) -> float:
    """First place in [0, 1] at which a polynomial falls through zero; infinite if there is none.

    ``c`` and ``b`` (size,) are its power and Bernstein coefficients. With ``at_once`` a fall at 0
    counts, where the polynomial is zero or, by rounding, negative.
    """
    if b.min() > 0.0 or np.abs(b).max() <= FLAT:
        return math.inf
    if at_once and c[0] <= 0.0 and c[1] < 0.0:
        root = -c[0] / c[1]
        return root if abs(root) < START_ROOT else 0.0
    inside = _isolated(b, matrices, True)
    if len(inside) and inside[-1, FALLS] == 1.0:
        return _solved(c, inside[-1])
    return math.inf


@jit
def roots(c: Floats, b: Floats, matrices: Floats) -> Floats:
    """All places in [0, 1] at which a polynomial changes sign, ascending."""
    inside = _isolated(b, matrices, False)
    found = np.empty(len(inside))
    for k in range(len(inside)):
        found[k] = _solved(c, inside[k])
    return found


@jit
def scaled(rows: Floats, length: float, orders: Ints) -> Floats:
    """Rescale power series (count, size) from [0, length] to [0, 1], divided by t^``orders``."""
    count, size = rows.shape
    scales, c = np.ones(size), np.zeros((count, size))
    for j in range(1, size):
        scales[j] = length * scales[j - 1]
    for k in range(count):
        order = orders[k]
        c[k, : size - order] = rows[k, order:] * scales[: size - order]
    return c


@jit
def first_series_to_cross(
    rows: Floats, length: float, orders: Ints, before: Floats, skipped: Ints, matrices: Floats
) -> tuple[int, float, Floats]:
    """Find the power series that falls through zero first in [0, length].

    ``rows`` (count, size) are first divided by t^``orders``. Those with positive ``before`` may
    fall ``at_once``, see :func:`fall`; those ``skipped`` are ignored. Returns the index of the
    series, or -1 if none falls; the place; and the values (count,) of all series at ``length``.
    """
    c, ends = scaled(rows, length, orders), np.empty(len(rows))
    first, place = -1, math.inf
    for k in range(len(rows)):
        ends[k] = c[k].sum()
        if not skipped[k] and c[k, 0] <= np.abs(c[k, 1:]).sum():  # else it has no root
            found = fall(c[k], c[k] @ matrices[WHOLE], before[k] > 0.0, matrices)
            if found < place:
                first, place = k, found
    return first, place * length, ends
