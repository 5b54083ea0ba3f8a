"""All cycles of a map at fixed parameter values, by enumeration of words.

Each cycle is sought at its leftmost point. The points that follow a word and lie left of all their
images form an interval, which every further letter cuts by linear inequalities. A word whose
interval is empty is not extended, so that the cost grows like the exponential of the topological
entropy times the order. Cycles through breaks are found by following the breaks themselves.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import chain, islice
from math import prod
from typing import Any

import sympy
from sympy import QQ

from pwmap.algebra.arguments import check_functions, explained
from pwmap.algebra.exact import HIGHEST, LOWEST, Affine
from pwmap.algebra.numbers import Exact, key
from pwmap.algebra.roots import real_to_sympy
from pwmap.diagrams.shown import counted
from pwmap.longrun.line import IDENTITY, Germ, Interval, MapLine, line_of, taken_into
from pwmap.maps.budget import BUDGET, Budget, Meter, Progress, Report, metered
from pwmap.maps.piecewise_linear import PiecewiseLinearMap, checked_order
from pwmap.maps.words import work_of

STEP = 8  # operations of testing whether a letter may follow a word
# a word, the affine map along it, and the points that follow it and lie left of their images
Start = tuple[tuple[int, ...], Affine, Interval]


@dataclass(frozen=True, slots=True, eq=False)
class FoundCycle:
    """A cycle found by :func:`pwmap.cycles`, starting at its leftmost point.

    ``slope`` is the multiplier; None if no nearby orbit visits the same pieces. A cycle is
    ``at_break`` if one of its points is a break.
    """

    line: MapLine
    word: str
    start: Exact
    slope: Exact | None
    at_break: bool = False

    @property
    def period(self) -> int:
        """The number of points."""
        return len(self.word) // len(self.line.branches[0].letter)  # a word, of an iterate

    @property
    def exact_points(self) -> tuple[Exact, ...]:
        """The points in the order of visits, as exact numbers."""
        orbit = self.line.orbit(Germ(self.start, 0))
        return tuple(germ.x for germ in islice(orbit, self.period))

    @property
    def points(self) -> tuple[sympy.Expr, ...]:
        """The points in the order of visits, as sympy expressions."""
        return tuple(map(real_to_sympy, self.exact_points))

    @property
    def multiplier(self) -> sympy.Expr | None:
        """The product of the slopes along the cycle; None if no nearby orbit follows its pieces."""
        return None if self.slope is None else real_to_sympy(self.slope)

    @property
    def stable(self) -> bool | None:
        """Whether the cycle attracts; None for a cycle through a break, where both sides matter."""
        return None if self.at_break or self.slope is None else bool(abs(self.slope) < 1)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FoundCycles:
    """All isolated cycles that :func:`pwmap.cycles` found, by period, then from left to right.

    They are complete up to the period ``order``. ``words`` counts the words that were tried;
    ``left_out`` says in a sentence what is missing, and is empty if nothing is.
    """

    cycles: tuple[FoundCycle, ...]
    order: int
    words: int
    left_out: str = ""

    def __repr__(self) -> str:
        found, words = counted(len(self), "cycle"), counted(self.words, "word")
        rest = f"; {self.left_out}" if self.left_out else ""
        return f"FoundCycles({found} of period up to {self.order}, {words} looked at{rest})"

    def of_period(self, period: int) -> tuple[FoundCycle, ...]:
        """The cycles of one least ``period``, from left to right."""
        return tuple(cycle for cycle in self.cycles if cycle.period == period)

    def __len__(self) -> int:
        return len(self.cycles)

    def __iter__(self) -> Iterator[FoundCycle]:
        return iter(self.cycles)


@explained()
def cycles(
    map_: PiecewiseLinearMap,
    values: Mapping[Any, object] | None = None,
    order: int = 8,
    *,
    budget: Budget | Meter = BUDGET,
    progress: Report | None = None,
    on_interrupt: Callable[[], None] | None = None,
) -> FoundCycles:
    """All isolated cycles of a map up to a given period, at fixed parameter values.

    Parameters
    ----------
    map_, values, order
        The map, values of its parameters by symbol or name (rationals, and one may be a real
        algebraic number), and the largest period.
    budget
        Its ``pieces`` bound the words of one length, its ``letters`` the period.
    progress
        Called after each period with the period, and the numbers of cycles and words so far.
    on_interrupt
        Called if Ctrl-C ends the search, instead of the budget's own callback.

    Returns
    -------
    FoundCycles
        The cycles, complete up to the period at which the budget or an interrupt ended the search.
        Intervals of periodic points, where a word has slope 1, are left out.

    Raises
    ------
    ValueError
        If a parameter has no value, or the order is no integer of at least 1.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, cycles
    >>> skew = PiecewiseLinearMap.from_sympy("Piecewise((a*x + 1, x <= 0), (b*x + 1, True))")
    >>> found = cycles(skew, {"a": "1/2", "b": -4}, 6)
    >>> [len(found.of_period(n)) for n in range(1, 7)]
    [1, 1, 2, 1, 2, 2]
    >>> [(cycle.word, cycle.exact_points, cycle.multiplier) for cycle in found.of_period(3)]
    [('LLR', (-5/2, -1/4, 7/8), -1), ('LRR', (-13/7, 1/14, 5/7), 8)]
    """
    order, meter = checked_order(order), metered(budget, on_interrupt)
    check_functions(progress=progress)
    line = line_of(map_, values)
    levels, found = list[list[FoundCycle]](), list[FoundCycle]()
    longest = min(order, meter.budget.letters)
    searched, left_out = 0, ""
    with meter.keeping(levels):
        found += _through_breaks(line, longest, meter)
        for level in meter.each(islice(levels_of(line, meter), longest), "periods"):
            searched += len(level)
            cycles_ = [
                FoundCycle(line, "".join(line.branches[k].letter for k in word), x, whole.slope)
                for word, whole, x in closed_words(level)
            ]
            done, most = len(levels) + 1, meter.budget.pieces
            if progress is not None:
                so_far = len(found) + len(cycles_) + sum(map(len, levels))
                progress(Progress(done, so_far, searched))
            levels.append(cycles_)
            if len(level) > most:
                left_out = f"{len(level)} words of that length, at most {most} are allowed"
                break
    left_out = left_out or meter.stopped * bool(meter.left_out)
    done = len(levels) if left_out else longest
    if done == longest < order:
        left_out = f"words of at most {longest} letters are allowed"
    found = [c for c in chain(found, *levels) if c.period <= done]
    found.sort(key=lambda cycle: (cycle.period, cycle.start))
    return FoundCycles(
        cycles=tuple(found), order=done, words=searched,
        left_out=left_out and f"stopped after period {done}: {left_out}",
    )  # fmt: skip


def closed_words(level: Iterable[Start]) -> Iterator[tuple[tuple[int, ...], Affine, Exact]]:
    """Yield the words of cycles that avoid the breaks, with their maps and leftmost points."""
    for word, whole, (low, high) in level:
        if whole.slope != 1 and low < (x := whole.fixed_point) < high:
            yield word, whole, x


def levels_of(line: MapLine, meter: Meter) -> Iterator[list[Start]]:
    """Yield the words of length 1, 2, ... and the points that follow them, until there are none."""
    level: list[Start] = [((), IDENTITY, (LOWEST, HIGHEST))]
    while level := [longer for start in level for longer in _longer(line, start, meter)]:
        yield level


def _longer(line: MapLine, start: Start, meter: Meter) -> Iterator[Start]:
    """Yield the extensions of a word by one letter that some points follow, with these points."""
    word, whole, points = start
    meter.spend(STEP * len(line.branches) * work_of(whole.intercept))
    onward = Affine(whole.slope - 1, whole.intercept)  # from the point to its last image
    for k, branch in enumerate(line.branches):
        # the last image lies in the branch and, as the point is the leftmost, to the right of it
        cut = taken_into(whole, points, branch[2:4])
        if cut and word:
            cut = taken_into(onward, cut, (QQ.zero, HIGHEST))
        if cut:
            yield (*word, k), branch.after(whole), cut


def _through_breaks(line: MapLine, order: int, meter: Meter) -> Iterator[FoundCycle]:
    seen = set[Any]()
    for x in line.breaks:
        points, image = [x], line(x)
        while image != x and len(points) < order:
            meter.spend(work_of(image))
            points.append(image)
            image = line(image)
        least = min(points)
        if image != x or key(least) in seen:
            continue
        seen.add(key(least))
        orbit, *sides = (
            [*islice(line.orbit(Germ(least, side)), len(points))] for side in (0, -1, 1)
        )
        pieces = [*map(line.piece, orbit)]
        is_followed = any(map(line.owns, sides))
        slope = prod((piece.slope for piece in pieces), start=QQ.one) if is_followed else None
        if slope != 1:
            yield FoundCycle(line, "".join(piece.letter for piece in pieces), least, slope, True)
