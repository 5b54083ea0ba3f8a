"""Budgets of computations: limits on work, reports of progress, early ends.

A call makes a *meter* from its *budget* and passes it down; each loop charges the meter before it
does the work. At a limit or an interrupt the outermost loop keeps the finished parts, and the
result says what is missing. The meter is an argument, not global state: lazy results keep theirs.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sized
from contextlib import contextmanager
from dataclasses import dataclass, replace
from decimal import Context, Decimal
from typing import NamedTuple, TypeVar

from pwmap.algebra.arguments import (
    check_functions,
    check_kind,
    explained_fields,
    positive_integer,
    shown,
)

Part = TypeVar("Part")

CLOCK_INTERVAL = 50_000  # units of work between two looks at the clock: about 0.05 s
INTERRUPTED = "interrupted"  # why a meter stopped at Ctrl-C
PROGRESS_INTERVAL = 0.25  # seconds between two calls of ``progress``


class Advance(NamedTuple):
    """Progress of a call under a :class:`pwmap.Budget` after ``work`` units of work.

    ``done`` of ``total`` (0 if unknown) ``what``, such as ``"columns"``, are finished; ``what`` is
    empty outside of loops.
    """

    what: str
    done: int
    total: int
    work: int


NO_LOOP = Advance("", 0, 0, 0)


@explained_fields
@dataclass(frozen=True, slots=True, kw_only=True)
class Budget:
    """Limits of a call, where it reports progress, and what happens at an interrupt.

    At a limit the call returns what is finished, and the result says what is not; if nothing is, or
    a partial result would be wrong, it raises :class:`BudgetError`. Limits are counts, the same on
    every machine; the defaults allow about a minute.

    Attributes
    ----------
    pieces
        Pieces of one iterate; for a diagram, of all iterates in all cells (about half a gigabyte).
    letters
        Length of a word; the time grows with its square.
    work
        Exact operations, weighted by the length of their numbers, see :func:`cost`.
    seconds
        None for no limit; with one, what is finished depends on the machine.
    progress
        Called with a :class:`pwmap.maps.Advance` at the start, a few times a second, and after
        each part.
    on_interrupt
        Called at Ctrl-C, before what is finished is returned; by default KeyboardInterrupt passes.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, Budget, bifurcation_diagram
    >>> p1 = PiecewiseLinearMap.from_sympy("Piecewise((r - 2, x <= 0), (r - 5*x/4, True))")
    >>> bifurcation_diagram(p1, "r", (-1, 4), range(1, 9), budget=Budget(pieces=40)).given
    ('stopped after orders 1..2: order 3 takes more than 40 pieces in all cells',)
    """

    pieces: int = 500_000
    letters: int = 10_000
    work: int = 50_000_000
    seconds: float | None = None
    progress: Callable[[Advance], None] | None = None
    on_interrupt: Callable[[], None] | None = None

    def __post_init__(self) -> None:
        for name in ("pieces", "letters", "work"):
            count = getattr(self, name)
            if not positive_integer(count):
                got = shown(count)
                raise ValueError(f"{name} of a budget must be a positive integer, got {got}")
        seconds = self.seconds
        if seconds is not None and not (isinstance(seconds, int | float) and seconds > 0):
            raise ValueError(f"seconds of a budget must be a positive number, got {shown(seconds)}")
        check_functions(progress=self.progress, on_interrupt=self.on_interrupt)


BUDGET = Budget()


class BudgetError(ValueError):
    """The work exceeds its budget; a :class:`Budget` with larger limits allows more."""


def cost(bits: int) -> int:
    """Units of work of one operation on rationals of so many bits; a unit is about 1 µs."""
    # the gcd of long numbers takes time quadratic in their length
    return 1 + bits // 128 + (bits // 512) ** 2


class Meter:
    """What a call has used of its budget; nested calls take this meter in place of a budget.

    Parameters
    ----------
    budget
        The limits.

    Attributes
    ----------
    work
        Units of work so far.
    stopped, left_out
        Why the call ended early, and a sentence on what is finished; empty otherwise.

    Examples
    --------
    >>> from pwmap import Budget
    >>> from pwmap.maps import Meter
    >>> meter, squares = Meter(Budget(work=10)), []
    >>> with meter.keeping(squares):
    ...     for n in meter.each(range(100), "squares"):
    ...         meter.spend(4)
    ...         squares.append(n * n)
    >>> squares, meter.left_out
    ([0, 1], 'stopped after 2 of 100 squares: more than 10 units of work are needed')
    """

    def __init__(self, budget: Budget) -> None:
        check_kind("budget", budget, Budget)
        self.budget = budget
        self.work = 0
        self.stopped = ""
        self.left_out = ""
        self._loops = [NO_LOOP]  # those under way, from the outermost inwards
        self._began = time.monotonic()
        self._told = self._began
        self._next = 0  # the work at which limits, clock and progress are looked at next
        self._tell()

    def spend(self, work: int) -> None:
        """Charge work, in units of :func:`cost`, before it is done; BudgetError beyond a limit."""
        self.work += work
        if self.work >= self._next:
            self._look()

    def _look(self) -> None:
        if self.stopped:
            raise BudgetError(self.stopped)
        budget, now = self.budget, time.monotonic()
        if self.work > budget.work:
            raise BudgetError(f"more than {budget.work} units of work are needed")
        if budget.seconds is not None and now - self._began > budget.seconds:
            raise BudgetError(f"more than {budget.seconds:g} seconds are needed")
        self._next = min(self.work + CLOCK_INTERVAL, budget.work + 1)
        if now - self._told > PROGRESS_INTERVAL:
            self._tell()

    @property
    def _outermost(self) -> Advance:
        return next((loop for loop in self._loops if loop.what), NO_LOOP)

    def advance(self, what: str, done: int, total: int = 0) -> None:
        """Note that ``done`` of ``total`` ``what`` are finished; the outermost loop reports it."""
        self._loops[-1] = at = Advance(what, done, total, self.work)
        if self._outermost is at:
            self._tell()

    def _tell(self) -> None:
        self._told = time.monotonic()
        if self.budget.progress is not None:
            self.budget.progress(self._outermost._replace(work=self.work))

    def each(self, parts: Iterable[Part], what: str) -> Iterator[Part]:
        """Yield the ``parts``; the outermost loop reports how many of ``what`` are finished."""
        total = len(parts) if isinstance(parts, Sized) else 0
        if self._loops[-1].what:  # a loop inside another one does not report
            yield from parts
            return
        self.advance(what, 0, total)
        for done, part in enumerate(parts, start=1):
            yield part
            self.advance(what, done, total)
        self._loops[-1] = NO_LOOP

    @contextmanager
    def keeping(self, finished: Sized, besides: Sized = ()) -> Iterator[None]:
        """Keep what a loop has finished when a limit or an interrupt ends it early.

        The loop in this context adds each part to ``finished``; :attr:`left_out` then says whether
        it ended early. BudgetError and KeyboardInterrupt pass if nothing is finished, here or
        ``besides``, an interrupt also without :attr:`Budget.on_interrupt`.
        """
        self._loops.append(NO_LOOP)
        try:
            yield
        except BudgetError as error:
            self._stop(str(error))
            if not (len(finished) or len(besides)):
                raise
        except KeyboardInterrupt:
            if self.budget.on_interrupt is None or not (len(finished) or len(besides)):
                raise
            self.budget.on_interrupt()
            self._stop(INTERRUPTED)
        else:
            return
        finally:
            what, _, total, _ = self._loops.pop()
        of = f" of {total}" if total else ""
        self.left_out = f"stopped after {len(finished)}{of} {what}: {self.stopped}"

    def _stop(self, why: str) -> None:
        self.stopped, self._next = why, 0  # the next work charged to this meter ends, too


def check_budget(budget: object) -> None:
    """TypeError unless it is a budget, or the meter of one."""
    if not isinstance(budget, Meter):
        check_kind("budget", budget, Budget)


def metered(budget: Budget | Meter, on_interrupt: Callable[[], None] | None = None) -> Meter:
    """The meter of an outer call as it is, or a new one; ``on_interrupt`` goes into its budget."""
    check_functions(on_interrupt=on_interrupt)
    check_budget(budget)
    if isinstance(budget, Meter):
        return budget
    return Meter(budget if on_interrupt is None else replace(budget, on_interrupt=on_interrupt))


def check_work(what: str, work: int, meter: Meter) -> None:
    """BudgetError if work that is known in advance exceeds the budget."""
    if work > meter.budget.work:
        about = Decimal(work).normalize(Context(prec=3))  # it may be too large for a double
        raise BudgetError(
            f"{what} take about {about:g} units of work, at most {meter.budget.work} are allowed"
        )


class Progress(NamedTuple):
    """The last order that :func:`pwmap.bifurcation_diagram` completed, its cells, all pieces."""

    order: int
    cells: int  # open ones and edges
    pieces: int


Report = Callable[[Progress], None]


def checked_size(order: int, maps: int, budget: Budget = BUDGET) -> None:
    """BudgetError if the words of an iterate of a composition of ``maps`` maps are too long."""
    letters = order * maps
    if letters > budget.letters:
        raise BudgetError(
            f"the iterate of order {shown(order)} is too large: each of its pieces would have a "
            f"word of {shown(letters)} letters, at most {budget.letters} are allowed"
        )
