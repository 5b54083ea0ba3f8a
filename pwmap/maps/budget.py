"""How much may be computed, how far a computation is, and how it ends early.

A call makes a *meter* of its *budget* and hands it down; each loop counts its work there before it
does it. At a limit or an interrupt the outermost loop keeps the finished parts, and the result says
what is missing. The meter is an argument, not global state: lazy results keep theirs.
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

LOOK = 50_000  # work after which a meter looks at the clock: some hundredths of a second
INTERRUPTED = "interrupted"  # why a meter stopped at Ctrl-C
OFTEN = 0.25  # seconds between two calls of ``progress``


class Advance(NamedTuple):
    """How far a call of a :class:`pwmap.Budget` is, after ``work``.

    ``done`` of ``total`` (0 if unknown) of ``what``, such as ``"columns"`` or ``""``, are finished.
    """

    what: str
    done: int
    total: int
    work: int


NOTHING = Advance("", 0, 0, 0)


@explained_fields
@dataclass(frozen=True, slots=True, kw_only=True)
class Budget:
    """Limits of a call, whom it tells its progress, and what an interrupt does.

    At a limit the call returns what is finished, and the result says what is not; if nothing is, or
    a part of the result would be wrong, it raises :class:`BudgetError`. Limits are counts, the same
    on every machine; the default ones allow about a minute.

    Attributes
    ----------
    pieces
        Of one iterate; of a diagram, of all iterates in all cells (about half a gigabyte).
    letters
        Of a word, which takes time in proportion to its square.
    work
        Exact operations, weighted by the length of their numbers, see :func:`cost`.
    seconds
        None for no limit; with one, what is finished depends on the machine.
    progress
        Called with a :class:`pwmap.maps.Advance` at once, a few times a second, after each part.
    on_interrupt
        Called at Ctrl-C; what is finished is then returned. By default ``KeyboardInterrupt`` is
        raised.

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
    """A budget is used up; a :class:`Budget` with other limits allows more."""


def cost(bits: int) -> int:
    """The work of one operation on rationals of so many bits; 1 takes about a microsecond."""
    # the common divisor of long ones takes time like the square of their length
    return 1 + bits // 128 + (bits // 512) ** 2


class Meter:
    """What a call has used of a budget; a call inside another one takes its meter as a budget.

    Parameters
    ----------
    budget
        What is allowed.

    Attributes
    ----------
    work
        Done so far.
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
        self._loops = [NOTHING]  # under way, each within the one before
        self._began = time.monotonic()
        self._told = self._began
        self._next = 0  # work at which to look at limits, the clock, and whom to tell
        self._tell()

    def spend(self, work: int) -> None:
        """Note work, as :func:`cost` weighs it, before it is done; BudgetError if too much."""
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
        self._next = min(self.work + LOOK, budget.work + 1)
        if now - self._told > OFTEN:
            self._tell()

    @property
    def _outermost(self) -> Advance:
        return next((loop for loop in self._loops if loop.what), NOTHING)

    def advance(self, what: str, done: int, total: int = 0) -> None:
        """Note, and tell, that ``done`` of a ``total`` of ``what`` are finished."""
        self._loops[-1] = at = Advance(what, done, total, self.work)
        if self._outermost is at:
            self._tell()

    def _tell(self) -> None:
        self._told = time.monotonic()
        if self.budget.progress is not None:
            self.budget.progress(self._outermost._replace(work=self.work))

    def each(self, parts: Iterable[Part], what: str) -> Iterator[Part]:
        """The ``parts`` in turn; the outermost of nested loops tells how many of ``what`` end."""
        total = len(parts) if isinstance(parts, Sized) else 0
        if self._loops[-1].what:  # this one is within another
            yield from parts
            return
        self.advance(what, 0, total)
        for done, part in enumerate(parts, start=1):
            yield part
            self.advance(what, done, total)
        self._loops[-1] = NOTHING

    @contextmanager
    def keeping(self, finished: Sized) -> Iterator[None]:
        """Let a loop end early, at a limit or an interrupt, if it has finished anything.

        The loop in this context adds each part to ``finished``; :attr:`left_out` then says whether
        it ended early. BudgetError or KeyboardInterrupt passes if nothing is finished, and an
        interrupt without :attr:`Budget.on_interrupt`.
        """
        self._loops.append(NOTHING)
        try:
            yield
        except BudgetError as error:
            self._stop(str(error))
            if not len(finished):
                raise
        except KeyboardInterrupt:
            if self.budget.on_interrupt is None or not len(finished):
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
        self.stopped, self._next = why, 0  # whatever goes on with this meter ends, too


def check_budget(budget: object) -> None:
    """TypeError unless it is a budget, or the meter of one."""
    if not isinstance(budget, Meter):
        check_kind("budget", budget, Budget)


def metered(budget: Budget | Meter, on_interrupt: Callable[[], None] | None = None) -> Meter:
    """A new meter of a budget, with another ``on_interrupt``, or that of an outer call as it is."""
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
    """The last completed order of :func:`pwmap.bifurcation_diagram`, its cells, all pieces."""

    order: int
    cells: int  # and edges
    pieces: int


Report = Callable[[Progress], None]


def checked_size(order: int, maps: int, budget: Budget = BUDGET) -> None:
    """BudgetError if the words of an iterate of a composition of some maps would be too long."""
    letters = order * maps
    if letters > budget.letters:
        raise BudgetError(
            f"the iterate of order {shown(order)} is too large: each of its pieces would have a "
            f"word of {shown(letters)} letters, at most {budget.letters} are allowed"
        )
