"""Invariant densities: step functions whose jumps lie on the critical orbits.

The density h of a chaotic attractor is invariant under the transfer operator. It jumps at the image
of each side of a break, by the value of h on that side over the slope, and at the image of each
other jump, by the height of that jump over the slope. So h is determined by its values beside the
breaks, which satisfy linear equations whose coefficients are sums along critical orbits [Kopf1990;
Gora2009]. For finite orbits the sums are finite or geometric, and h is exact; otherwise a geometric
series bounds the remainder, and h is enclosed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from itertools import accumulate
from operator import sub
from typing import Any

import mpmath
import sympy
from sympy import QQ

from pwmap.algebra.numbers import IV, Element, Exact, enclosed, enclosure, log_bounds, number_of
from pwmap.algebra.roots import real_to_sympy
from pwmap.longrun.attractors import Bands, stretched
from pwmap.longrun.line import Germ, MapLine
from pwmap.maps.budget import BudgetError, Meter
from pwmap.maps.words import work_of

# Height of a jump, below double rounding: the rest is bounded, not summed.
SMALLEST_JUMP = QQ(1, 2**60)
LONGEST = 600  # steps along which jumps are summed, at most
MAX_WORDS = 4096  # words of one length, at most, while an iterate that expands is sought
STEP = 10  # operations of one step along an orbit


class Enclosure(mpmath.ctx_iv.ivmpf):  # type: ignore[misc]
    """An mpmath interval around a number of a :class:`Density`; ``float`` gives its midpoint."""

    ctx = IV

    def __new__(cls, interval: Any) -> Enclosure:
        """Make an enclosure of an mpmath interval."""
        self: Enclosure = object.__new__(cls)
        self._mpi_ = interval._mpi_
        return self

    def __float__(self) -> float:
        return 0.5 * float(mpmath.mpf(self.a)) + 0.5 * float(mpmath.mpf(self.b))

    def __reduce__(self) -> tuple[Any, ...]:
        return _between, tuple(map(mpmath.mp.make_mpf, self._mpi_))


def _between(low: Any, high: Any) -> Enclosure:
    return Enclosure(IV.make_mpf((low._mpf_, high._mpf_)))


@dataclass(frozen=True, slots=True)
class _BreakSide:
    """One side of a break inside a band, with the jumps of the density that it causes."""

    germ: Germ  # a break, and the side of it on which the piece lies: a factor of all heights
    jumps: tuple[tuple[Exact, Exact], ...]  # places, and heights if the density is 1 on that side
    rest: float  # upper bound of the sum of all further heights


@dataclass(frozen=True, eq=False)
class Density:
    """The invariant density of a chaotic attractor: a step function, positive in its ``bands``.

    It jumps at ``places``, which include the ends of bands, and has the ``values`` between them,
    zero between bands. Unless the density is ``exact``, values are intervals, and it differs from
    these steps by at most ``error``, which is zero if it is exact.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, dynamics
    >>> tent = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
    >>> density = dynamics(tent, {"a": 2}).attractors[0].density  # it is uniform
    >>> [(str(low), str(high), str(value)) for low, high, value in density.steps()]
    [('0', '1', '1')]
    >>> density.exact, density.exponent
    (True, log(2))
    """

    line: MapLine
    bands: Bands
    exact: bool
    places: tuple[Exact, ...]
    values: tuple[Any, ...]
    error: float

    def measure(self, low: object, high: object) -> Any:
        """The measure, from 0 to 1, of the interval between exact numbers ``low`` and ``high``.

        Ends are rationals, also as text, or numbers of the map's field; any real algebraic numbers
        if the map is rational. The result is an :class:`Enclosure` if the density is not exact.
        TypeError if an end is a float, ValueError if it is no such number.
        """
        slope = self.line.branches[0].slope
        root = slope.root if isinstance(slope, Element) else None
        return self._measure(number_of(low, root), number_of(high, root))

    def _measure(self, low: Exact, high: Exact) -> Any:
        total = QQ.zero if self.exact else IV.mpf(0)
        for a, b, value in self.steps():
            part = min(b, high) - max(a, low)
            if part > 0:
                total = total + (part * value if self.exact else enclosure(part) * value)
        if self.exact:
            return total
        part = min(high, self.places[-1]) - max(low, self.places[0])
        return Enclosure(total + enclosure(max(part, QQ.zero)) * IV.mpf([-self.error, self.error]))

    def steps(self) -> Iterator[tuple[Exact, Exact, Any]]:
        """Yield the two ends of each step and the value between them."""
        return zip(self.places[:-1], self.places[1:], self.values, strict=True)

    @cached_property
    def shares(self) -> tuple[tuple[Exact, Any], ...]:
        """The absolute values of slopes, each with the measure of the points where it occurs."""
        found = dict[Exact, Any]()
        for interval in self.bands.intervals:
            for branch, (low, high) in self.line.parts(interval):
                size = abs(branch.slope)
                part = self._measure(low, high)
                found[size] = found[size] + part if size in found else part
        return tuple((x, part if self.exact else Enclosure(part)) for x, part in found.items())

    @property
    def exponent(self) -> sympy.Expr | None:
        """The Lyapunov exponent as a sum of logarithms; None if the density is not exact."""
        if not self.exact:
            return None
        return sympy.Add(
            *(real_to_sympy(part) * sympy.log(real_to_sympy(size)) for size, part in self.shares)
        )

    @cached_property
    def exponent_bounds(self) -> tuple[float, float]:
        """Doubles below and above the Lyapunov exponent."""
        total = IV.mpf(0)
        for size, part in self.shares:
            low, high = log_bounds(size)
            total += (enclosure(part) if self.exact else part) * IV.mpf([low, high])
        return math.nextafter(float(total.a), -math.inf), math.nextafter(float(total.b), math.inf)


def density_of(line: MapLine, bands: Bands, meter: Meter) -> Density | None:
    """The invariant density; None if no iterate expands, a pivot may be 0, or the work runs out."""
    try:
        return _density_of(line, bands, meter)
    except BudgetError:
        return None


def _density_of(line: MapLine, bands: Bands, meter: Meter) -> Density | None:
    later = _tail_bound(line, bands, meter)
    if later is None:
        return None
    ends = [
        _jumps_from(line, Germ(x, side), later, meter)
        for interval in bands.intervals
        for _, (low, high) in line.parts(interval)
        for x, side in ((low, 1), (high, -1))
        if x in line.breaks  # otherwise it is an end of a band, where no branch ends
    ]
    exact = all(end.rest == 0.0 for end in ends)
    number: Callable[[Any], Any] = (lambda x: x) if exact else enclosure
    rows = list[list[Any]]()  # the density at each end is the sum of all jumps to its left
    for here in ends:
        x, side = here.germ
        jumps = (
            (end, sum((w for y, w in end.jumps if y < x or (side > 0 and y == x)), start=QQ.zero))
            for end in ends
        )
        rows.append([number(-end.germ.side * jump) + _remainder(end.rest) + (end is here)
                     for end, jump in jumps])  # fmt: skip
    top = bands.intervals[-1][1]
    mass = [
        number(end.germ.side * sum((w * (top - x) for x, w in end.jumps), start=QQ.zero))
        + _remainder(end.rest) * number(top - bands.intervals[0][0])
        for end in ends
    ]
    # one homogeneous equation follows from the others; the total mass 1 takes its place
    matrices = (
        [*([*row, number(QQ.zero)] for k, row in enumerate(rows) if k != left_out),
         [*mass, number(QQ.one)]]
        for left_out in range(len(rows))
    )  # fmt: skip
    found = next((each for each in map(_solved, matrices) if each is not None), None)
    if found is None:
        return None
    places, values = _steps(bands, ends, found, number)
    error = sum(float(abs(value).b) * end.rest for end, value in zip(ends, found, strict=True)
                if end.rest)  # fmt: skip
    kept = values if exact else tuple(map(Enclosure, values))
    return Density(line, bands, exact, places, kept, error * (1.0 + 2.0**-40))


def _remainder(rest: float) -> Any:
    """The interval [-rest, rest] for the remainder of a sum; 0 if the sum is complete."""
    return IV.mpf([-rest, rest]) if rest else 0


def _jumps_from(line: MapLine, germ: Germ, later: float, meter: Meter) -> _BreakSide:
    """The jumps caused by an end of a branch, until its orbit ends, repeats, or they are small."""
    branch = line.piece(germ)
    x, weight = branch(germ.x), 1 / branch.slope
    seen, found = dict[Exact, int](), list[tuple[Exact, Exact]]()
    while True:
        meter.spend(STEP + 3 * work_of(x))
        if x in seen:  # each further round has the heights of the last one over the multiplier
            start = seen[x]
            ratio = weight / found[start][1]
            found[start:] = [(y, w / (1 - ratio)) for y, w in found[start:]]
            return _BreakSide(germ, tuple(found), 0.0)
        seen[x] = len(found)
        found.append((x, weight))
        if x in line.breaks:
            return _BreakSide(germ, tuple(found), 0.0)
        if len(found) >= LONGEST or abs(weight) < SMALLEST_JUMP:
            rest = _above(max(enclosed(abs(weight)))) * later
            return _BreakSide(germ, tuple(found), math.nextafter(rest, math.inf))
        branch = line.piece(Germ(x, 0))
        x, weight = branch(x), weight / branch.slope


def _above(x: Any) -> float:
    """A double above a number, also one that was rounded."""
    return math.nextafter(float(x), math.inf)


def _tail_bound(line: MapLine, bands: Bands, meter: Meter) -> float | None:
    """A bound of 1/|A_1| + 1/|A_1 A_2| + ... for the slopes A_n of any orbit; None if not found."""
    parts, total = [(interval, QQ.one) for interval in bands.intervals], 0.0
    while len(parts) <= MAX_WORDS:
        parts = stretched(line, parts, meter)
        least = min(size for _, size in parts)
        if not least:
            return None
        inverse = _above(max(enclosed(1 / least)))
        total = _above(total + inverse)
        if inverse < 1.0:
            return _above(_above(total) / (1.0 - inverse)) * (1.0 + 2.0**-50)
    return None


def _solved(matrix: list[list[Any]]) -> list[Any] | None:
    """The solution of linear equations by elimination; None if a pivot may be zero."""
    n = len(matrix)
    matrix = [list(row) for row in matrix]
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: _size(matrix[i][k]))
        if not _size(matrix[pivot][k]):
            return None
        matrix[k], matrix[pivot] = matrix[pivot], matrix[k]
        for i in range(k + 1, n):
            if matrix[i][k] != 0:
                ratio = matrix[i][k] / matrix[k][k]
                matrix[i] = [a - ratio * b for a, b in zip(matrix[i], matrix[k], strict=True)]
    found: list[Any] = [None] * n
    for k in reversed(range(n)):
        known = (matrix[k][i] * found[i] for i in range(k + 1, n))
        found[k] = reduce(sub, known, matrix[k][n]) / matrix[k][k]
    return found


def _size(x: Any) -> Any:
    if not isinstance(x, mpmath.ctx_iv.ivmpf):
        return abs(x)
    return mpmath.mpf(0) if 0 in x else min(abs(mpmath.mpf(x.a)), abs(mpmath.mpf(x.b)))


def _steps(
    bands: Bands, ends: Sequence[_BreakSide], found: Sequence[Any], number: Callable[[Any], Any]
) -> tuple[tuple[Exact, ...], tuple[Any, ...]]:
    """The places of all jumps, and the values between them, from the density at the ends."""
    heights = {x: number(QQ.zero) for interval in bands.intervals for x in interval}
    for end, value in zip(ends, found, strict=True):
        for x, weight in end.jumps:
            jump = number(end.germ.side * weight) * value
            heights[x] = heights[x] + jump if x in heights else jump
    places = sorted(heights)
    return tuple(places), tuple(accumulate(heights[x] for x in places[:-1]))
