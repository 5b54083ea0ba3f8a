"""The long-run dynamics of a map at fixed parameter values: public functions and results."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property
from itertools import chain
from typing import Any

import sympy
from sympy import QQ

from pwmap.algebra.arguments import explained, is_several, shortened, shown
from pwmap.algebra.roots import real_to_sympy
from pwmap.algebra.texts import printable, text
from pwmap.diagrams.shown import bracketed, counted
from pwmap.longrun.attractors import Attractors, Bands, absorbing_of, attractors_of, common_period
from pwmap.longrun.basins import (
    WholeBasin,
    attracted_from_outside,
    basin_of,
    invariant_closure,
    whole_basin,
)
from pwmap.longrun.densities import Density, density_of
from pwmap.longrun.entropy.entropies import ORDERS, Entropy, entropy_of, lap_numbers
from pwmap.longrun.entropy.kneading import STEPS, itinerary_of
from pwmap.longrun.fates import AttractingCycle, Fate, NeutralIntervals
from pwmap.longrun.line import (
    Germ,
    Interval,
    MapLine,
    PointSet,
    closed_intervals,
    line_of,
    open_intervals,
    part_to_sympy,
)
from pwmap.maps.budget import BUDGET, Budget, Meter, check_budget, check_work, metered
from pwmap.maps.piecewise_linear import PiecewiseLinearMap, checked_order
from pwmap.parameters.cells import checked_span


class Extremum(Enum):
    """Whether an iterate is extremal at one side of a break; the value is its symbol."""

    MAXIMUM = "M"
    MINIMUM = "m"
    CONSTANT = "c"


@dataclass(frozen=True, slots=True)
class MinMax:
    """The min-max sequence of one side of a break [Amigo2012], of a :class:`Kneading`.

    The n-th iterate, n = 1, 2, ..., has a one-sided limit at the break. It is a maximum of that
    branch of the iterate if points beside the break are mapped to the left of the limit, a minimum
    if to its right. The address of the limit is the piece in which their images lie.

    ``symbols`` holds the extremum and the letter of the address for each n; after a flat piece the
    iterates are constant. Symbols repeat from index ``start`` on; None if no repetition is known.
    """

    symbols: tuple[tuple[Extremum, str], ...]
    start: int | None

    def __str__(self) -> str:
        """For instance ``M^R (m^L M^R)``: brackets hold what repeats, dots mean that it goes on."""
        shown = [f"{extremum.value}^{letter}" for extremum, letter in self.symbols]
        if self.start is None:
            return " ".join([*shown, "..."])
        return " ".join([*shown[: self.start], f"({' '.join(shown[self.start :])})"])


@printable
@dataclass(frozen=True, slots=True, kw_only=True)
class Kneading:
    """The kneading sequence of one side of a break: the letters along its orbit.

    ``x`` is the break, ``side`` -1 for the limit from the left, +1 from the right. In ``word``,
    brackets hold the letters that repeat, and dots mean that the orbit was followed no further.
    ``letters`` lists the same letters singly; the last ``repeating`` of them repeat (0 if none is
    known to). ``fate`` says in words what becomes of the orbit.

    Examples
    --------
    >>> from sympy import sqrt
    >>> from pwmap import PiecewiseLinearMap, dynamics
    >>> tent = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
    >>> kneading, *_ = dynamics(tent, {"a": (1 + sqrt(5))/2}).kneading
    >>> kneading.x, kneading.side, kneading.word, str(kneading.minmax)
    (1/2, -1, 'L(RLR)', '(M^R m^L m^R)')
    """

    x: sympy.Expr
    side: int
    word: str
    fate: str
    letters: tuple[str, ...]
    repeating: int
    minmax: MinMax


@dataclass(frozen=True, eq=False)
class Attractor:
    """An attractor of :func:`pwmap.dynamics`, with its basin, density and exponent.

    ``core`` is, in exact numbers, an attracting cycle, neutral intervals (all points periodic), or
    the bands of a chaotic attractor.
    """

    line: MapLine
    core: AttractingCycle | NeutralIntervals | Bands
    budget: Budget | Meter = field(default=BUDGET, repr=False)

    @property
    def is_chaotic(self) -> bool:
        """Whether the core consists of bands."""
        return isinstance(self.core, Bands)

    @property
    def is_neutral(self) -> bool:
        """Whether the core consists of neutral intervals, all of whose points are periodic."""
        return isinstance(self.core, NeutralIntervals)

    @property
    def word(self) -> str:
        """The word of a cycle or of neutral intervals; empty for bands."""
        return "" if isinstance(self.core, Bands) else self.core.word

    @property
    def points(self) -> tuple[sympy.Expr, ...]:
        """The points of a cycle in the order of visits, from the smallest on; otherwise empty."""
        core = self.core
        return tuple(map(real_to_sympy, core.points)) if isinstance(core, AttractingCycle) else ()

    @property
    def multiplier(self) -> sympy.Expr | None:
        """The multiplier of a cycle; of neutral intervals 1, or -1 if reflected; None for bands."""
        core = self.core
        return None if isinstance(core, Bands) else real_to_sympy(QQ.one * core.multiplier)

    @property
    def bands(self) -> tuple[sympy.Interval, ...]:
        """The closed bands of a chaotic attractor, from left to right; otherwise empty."""
        core = self.core
        return closed_intervals(core.intervals).to_sympy() if isinstance(core, Bands) else ()

    @property
    def neutral(self) -> tuple[sympy.Interval, ...]:
        """Neutral intervals from left to right, with their periodic ends; otherwise empty."""
        core = self.core
        if not isinstance(core, NeutralIntervals):
            return ()
        return tuple(map(part_to_sympy, sorted(core.parts)))

    @cached_property
    def period(self) -> int:
        """The period of a cycle, or of neutral intervals (midpoints of reflected ones have half).

        For bands it is the greatest common divisor of the return times: the order of the first
        iterate that is mixing on each part [Block1980].
        """
        if not isinstance(self.core, Bands):
            return self.core.period
        density = self.density
        if density is not None and density.exact:
            parts = [(a, b) for a, b, value in density.steps() if value > 0]
        else:
            parts = list(self.core.intervals)
        return common_period(self.line, parts)

    @property
    def is_mixing(self) -> bool:
        """Whether bands are mixing: late images of any subinterval cover them all."""
        return self.is_chaotic and self.period == 1

    @cached_property
    def density(self) -> Density | None:
        """The invariant density of bands; None for other cores, or if none could be computed."""
        core = self.core
        if not isinstance(core, Bands):
            return None
        return density_of(self.line, core, metered(self.budget))

    @cached_property
    def exponent(self) -> sympy.Expr | None:
        """The Lyapunov exponent, or None if it is not known exactly."""
        if isinstance(self.core, AttractingCycle):
            size = abs(real_to_sympy(self.core.multiplier))
            return sympy.log(size) / len(self.core.points) if size else -sympy.oo
        if isinstance(self.core, NeutralIntervals):
            return sympy.Integer(0)
        return None if self.density is None else self.density.exponent

    @property
    def exponent_bounds(self) -> tuple[float, float] | None:
        """Doubles below and above the Lyapunov exponent of bands; None if there is no density."""
        return None if self.density is None else self.density.exponent_bounds

    @cached_property
    def _core(self) -> PointSet:
        """A forward-invariant set from which all orbits converge to the attractor."""
        core = self.core
        if isinstance(core, AttractingCycle):
            return core.region
        kept = (
            invariant_closure(self.line, core.intervals) if isinstance(core, Bands) else core.region
        )
        return kept | attracted_from_outside(self.line, kept)

    @cached_property
    def _basin(self) -> tuple[Interval, ...]:
        return basin_of(self.line, self._core.interior, metered(self.budget))

    @property
    def basin(self) -> tuple[sympy.Interval, ...]:
        """The immediate basin as open intervals, up to orbits that end in repelling cycles."""
        return open_intervals(self._basin).to_sympy()

    @property
    def basin_is_complete(self) -> bool:
        """Whether the immediate basin is proved to be the whole one, up to its endpoints."""
        whole, known = self.whole_basin, open_intervals(self._basin)
        return whole.complete and known.closure.has(whole.region)

    @cached_property
    def whole_basin(self) -> WholeBasin:
        """The part of the basin that is known: the immediate basin and its preimages."""
        return whole_basin(self.line, self._core, self._basin, metered(self.budget))

    def share(self, window: tuple[object, object]) -> sympy.Expr:
        """The exact fraction, from 0 to 1, of a window that the immediate basin covers.

        The ends are rationals. ValueError if they make no interval, TypeError for a float.
        """
        low, high = checked_span(window, "a window")
        inside = sum(max(0, min(b, high) - max(a, low)) for a, b in self._basin)
        return real_to_sympy(inside * QQ.one / (high - low))

    def __str__(self) -> str:
        if self.points:
            return f"cycle {self.word} through {text(self.points[0])}"
        intervals = (*self.bands, *self.neutral)
        shown = ", ".join(map(bracketed, intervals))
        kind = "band" if self.is_chaotic else "neutral interval"
        word = f" of {self.word}" if self.is_neutral else ""
        return f"{len(intervals)} {kind}{'s' * (len(intervals) > 1)}{word}: {shown}"

    def __repr__(self) -> str:
        return f"Attractor({self})"


class FoundAttractors(tuple[Attractor, ...]):
    """The attractors of a map, as a tuple; more may lie beside the breaks in ``open``.

    ``cause`` is a sentence if a budget or an interrupt ended the search, otherwise empty.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, dynamics
    >>> flat = PiecewiseLinearMap.from_sympy("Piecewise((x/2, x < 1), (1, True))")
    >>> dynamics(flat).attractors
    (Attractor(cycle L through 0), incomplete: open beside the break 1)
    """

    open: tuple[sympy.Expr, ...]
    cause: str

    def __new__(
        cls, attractors: Iterable[Attractor], open_: tuple[sympy.Expr, ...], cause: str = ""
    ) -> FoundAttractors:
        """Make the tuple of attractors, with the open breaks and the cause."""
        self = super().__new__(cls, attractors)
        self.open, self.cause = open_, cause
        return self

    def __getnewargs__(self) -> tuple[tuple[Attractor, ...], tuple[sympy.Expr, ...], str]:
        return tuple(self), self.open, self.cause

    @property
    def left_out(self) -> str:
        """What is missing, in a few words; empty if the attractors are complete."""
        places = ", ".join(shortened(str(x), 40) for x in self.open)
        breaks = "breaks" if len(self.open) > 1 else "break"
        part = f"incomplete: open beside the {breaks} {places}" if self.open else ""
        return "; ".join(filter(None, (part, self.cause)))

    def __repr__(self) -> str:
        if not self.left_out:
            return super().__repr__()
        return f"({', '.join([*map(repr, self), self.left_out])})"


@dataclass(frozen=True, eq=False)
class Dynamics:
    """The long-run dynamics of a map at fixed parameter values, from :func:`pwmap.dynamics`.

    Each property is computed on first use. The entropy is bounded by means of the graph of laps up
    to each of the ``orders`` in turn.
    """

    line: MapLine
    orders: tuple[int, ...] = ORDERS
    budget: Budget | Meter = field(default=BUDGET, repr=False)

    def __repr__(self) -> str:
        pieces = counted(len(self.line.branches), "piece")
        return f"Dynamics(map of {pieces}, attractors: {self.attractors!r})"

    @cached_property
    def _found(self) -> Attractors:
        return attractors_of(self.line, metered(self.budget))

    @cached_property
    def attractors(self) -> FoundAttractors:
        """All bounded attractors: cycles, neutral intervals, then bands, each from left to right.

        More may lie beside the breaks in :attr:`open`.
        """
        found = self._found
        cores = chain[Any](found.cycles, found.neutral, found.bands)
        attractors = (Attractor(self.line, core, self.budget) for core in cores)
        return FoundAttractors(attractors, self.open, found.left_out)

    @property
    def open(self) -> tuple[sympy.Expr, ...]:
        """The breaks beside which further attractors may lie."""
        return tuple(map(real_to_sympy, self._found.open))

    @cached_property
    def absorbing(self) -> sympy.Interval | None:
        """The smallest closed interval with all breaks and their images that is mapped into itself.

        None if orbits of breaks tend to infinity, so that there is none, or if there is no break.
        """
        found = absorbing_of(self.line)
        return None if found is None else sympy.Interval(*map(real_to_sympy, found))

    @cached_property
    def entropy(self) -> Entropy:
        """The topological entropy, exact or between bounds."""
        return entropy_of(self.line, self._found, self.orders, metered(self.budget))

    @cached_property
    def kneading(self) -> tuple[Kneading, ...]:
        """The kneading sequences of both sides of all breaks, from left to right."""
        return tuple(
            Kneading(
                x=real_to_sympy(germ.x),
                side=germ.side,
                word=orbit.kneading(),
                fate=orbit.fate.value,
                letters=orbit.letters,
                repeating=orbit.period if orbit.fate is Fate.FINITE else 0,
                minmax=_minmax(self.line, germ),
            )
            for germ, orbit in zip(self.line.germs, self._found.orbits, strict=True)
        )

    @property
    def is_finite(self) -> bool:
        """Whether the fates of all critical orbits are known."""
        return all(orbit.fate is not Fate.OPEN for orbit in self._found.orbits)

    def laps(self, order: int) -> list[int]:
        """The numbers of affine pieces (laps) of the iterates 1, 2, ..., ``order``.

        The time grows like the square of the order, not like the number of laps.
        """
        last, meter = checked_order(order), metered(self.budget)
        check_work(f"laps up to the order {shown(order)}", last, meter)  # one unit each, at least
        return lap_numbers(self.line, last, meter)


@explained()
def dynamics(
    map_: PiecewiseLinearMap,
    values: Mapping[Any, object] | None = None,
    *,
    orders: tuple[int, ...] = ORDERS,
    budget: Budget | Meter = BUDGET,
) -> Dynamics:
    """Long-run dynamics: attractors, basins, densities, exponents, kneading sequences, entropy.

    Parameters
    ----------
    map_, values
        The map, or an iterate, and values of its parameters by symbol or name: rationals, and one
        may be a real algebraic number such as ``(1 + sqrt(5))/2``.
    orders
        Orders up to which the graph of laps is built, in turn, until the entropy is known to 1e-12.
    budget
        The work allowed for each property of the result. Where it runs out, attractors and basins
        are incomplete, bounds are wide and densities are missing.

    Returns
    -------
    Dynamics
        Its properties are computed on first use.

    Raises
    ------
    ValueError, TypeError
        If a parameter has no value, several values are algebraic, or one is a float.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, dynamics
    >>> tent = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
    >>> found = dynamics(tent, {"a": "7/5"})
    >>> bands, = found.attractors
    >>> print(bands, bands.is_chaotic, bands.basin[0])
    2 bands: [21/50, 721/1250], [147/250, 7/10] True Interval.open(0, 1)
    >>> found.absorbing, found.laps(4)
    (Interval(21/50, 7/10), [2, 4, 8, 14])
    """
    if not is_several(orders):
        raise TypeError(f"orders must be several iterates such as (12, 24), got {shown(orders)}")
    orders = tuple(orders)
    if not orders:
        raise ValueError("orders must name at least one iterate, got none")
    for order in orders:
        checked_order(order)
    check_budget(budget)
    return Dynamics(line_of(map_, values), orders, budget)


EXTREMA = {-1: Extremum.MAXIMUM, 1: Extremum.MINIMUM, 0: Extremum.CONSTANT}  # by a germ's side


def _minmax(line: MapLine, start: Germ) -> MinMax:
    """The min-max sequence of a germ's orbit, from its first image on."""
    found = itinerary_of(line, start, STEPS, Meter(BUDGET))
    steps, again = STEPS, None
    if found.fate in (Fate.DRAWN, Fate.LOST):  # no germ repeats, but a word does:
        turns = line.along(found.word).slope < 0  # its square, if the word exchanges sides
        steps, again = len(found.germs) + turns * len(found.word), found.start
    seen, germ = dict[Germ, int](), start
    while germ not in seen and len(seen) < steps:
        seen[germ] = len(seen)
        germ = line.image(germ)
    again = seen.get(germ, again)
    first, *others = ((EXTREMA[each.side], line.piece(each).letter) for each in seen)
    if again == 0:  # the whole orbit is periodic: the break itself ends the period
        return MinMax((*others, first), 0)
    return MinMax(tuple(others), None if again is None else again - 1)
