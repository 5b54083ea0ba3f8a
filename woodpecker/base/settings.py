"""The numbers of the continuation that a user has a reason to turn, each with its scale."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import Field, dataclass, fields
from typing import Any

from pwmap.algebra.arguments import explained_fields
from pwmap.diagrams.shown import changed
from woodpecker.base.checks import interval, positive, whole

SMALLEST_UNIT = 2.0**-8  # of the largest magnitude: then ``nearest`` is some seventeen spacings


def _checked(settings: Any, each: Field[Any]) -> Any:
    """A setting that is positive: a whole number, or any, as its default is."""
    check = whole if isinstance(each.default, int) else positive
    return check(each.name, getattr(settings, each.name))


@explained_fields
@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """How far, how finely and how exactly to follow branches.

    Lengths are parts of the scales: of the length of ``span`` in the parameter, and of ``window``
    in x (of 1 if it is infinite), or of 1/256 of the largest number in it if that is more, for
    doubles are no finer. So they need no tuning for maps in other units.

    Parameters
    ----------
    span
        Interval of the parameter, finite; branches end (EP) at its ends.
    window
        Interval of x; branches end (EP) where an orbit leaves it. A search for every branch needs a
        finite one.
    step, max_step
        First and largest step in arclength.
    min_step
        Smallest step; a branch that needs a smaller one ends (EP). Borders that are closer together
        than this are passed over, and their number is not known.
    max_turn
        Largest angle [rad] between the tangents of neighbouring samples.
    max_samples
        A branch ends (EP) after this many.
    max_evaluations
        Of P_1, of a whole search; n^3 times as many more for P_n. A branch of P_n takes at most
        three fifths of n^2 times as many each way, and a slice a sixteenth. What is left is said. A
        return of very many phases counts as several.
    max_pieces
        Of P_1 in a slice, and ten times as many of an iterate. The rest is reported as not
        resolved.
    converged
        A Newton step of this length is the last.
    beside
        Distance from a border at which the piece beyond is asked for first; pieces thinner than a
        thousandth of it are passed over.
    nearest
        Smallest such distance, tried if there are other pieces in between.
    jump
        Limits of a map closer than this are one value.
    kink
        Slopes whose relative difference is larger are different.
    finest
        Pieces shorter than this part of the window are not looked for one by one; their total
        length is reported.
    coarse
        The same for pieces whose images lie away from the diagonal, if fixed points of P_1 are
        looked for, or out of the window, if cycles of iterates are.
    same
        Orbits this close at one parameter are one.

    Raises
    ------
    ValueError
        If span or window are no two ascending numbers, or a number is not positive.

    Examples
    --------
    >>> from woodpecker import Settings, continuation, shoot
    >>> from woodpecker.examples import two_lines
    >>> lines, settings = two_lines(), Settings(span=(-1, 2), window=(-3, 3), max_step=0.2)
    >>> diagram = continuation(lines, shoot(lines, -1.0, p=-0.5), settings=settings)
    >>> [point.parameter for point in diagram.points]
    [-1.0, 0.0, 1.0, 2.0]
    """

    span: tuple[float, float] = (0.0, 1.0)
    window: tuple[float, float] = (-math.inf, math.inf)
    step: float = 0.005
    max_step: float = 0.02
    min_step: float = 1e-13
    max_turn: float = 0.1
    max_samples: int = 20_000
    max_evaluations: int = 500_000  # the longest branches of the toy need 290 000
    max_pieces: int = 10_000  # the toy has some hundred
    converged: float = 2.0**-48  # 16 spacings of doubles at 1, what rounding of a map leaves
    beside: float = 1e-6  # far above rounding, far below a step
    nearest: float = 1e-12  # some hundred times ``converged``, for rounding not to decide
    # far above a rounded location at a steep slope, far below jumps worth drawing
    jump: float = 1e-7
    kink: float = 1e-6
    finest: float = 1e-6
    coarse: float = 1e-4
    same: float = 1e-9  # far above rounding, far below distances of orbits

    def __repr__(self) -> str:
        return changed(self)

    def __post_init__(self) -> None:
        for name in ("span", "window"):
            ends = interval(name, getattr(self, name), finite=name == "span")
            object.__setattr__(self, name, ends)
        for each in fields(self):
            if isinstance(each.default, int | float):
                object.__setattr__(self, each.name, _checked(self, each))
        if not self.min_step <= self.max_step:
            raise ValueError(
                f"max_step must be at least min_step = {self.min_step:.3g}, got {self.max_step}"
            )
        if not self.min_step <= self.step <= self.max_step:
            raise ValueError(
                f"step must lie in [{self.min_step}, {self.max_step}], got {self.step}"
            )
        if not self.converged <= self.nearest:
            raise ValueError(
                f"nearest must be at least converged = {self.converged:.3g}, got {self.nearest}"
            )

    @property
    def spacings(self) -> float:
        """How many spacings of doubles rounding of a map leaves."""
        return self.converged * 2.0**52

    @property
    def x_scale(self) -> float:
        """The unit of x."""
        low, high = self.window
        return _unit(low, high) if math.isfinite(high - low) else 1.0

    @property
    def p_scale(self) -> float:
        """The unit of the parameter."""
        return _unit(*self.span)

    def of_branch(self, order: int, *, one_of_many: bool = False) -> int:
        """How many evaluations a branch may take, from one special point to the next.

        Parameters
        ----------
        order
            Of the iterate to which it belongs.
        one_of_many
            Whether all branches of a window are looked for, and one must not take what others need.

        Returns
        -------
        int
            A part of ``max_evaluations``.
        """
        allowed = order**2 * self.max_evaluations
        return allowed // 6 if one_of_many else allowed * 3 // 5

    def of_slice(self, orders: Sequence[int]) -> int:
        """How many evaluations a slice of iterates of some orders may take."""
        return max(orders) ** 2 * self.max_evaluations // 16

    def of_search(self, orders: Sequence[int]) -> int:
        """How many evaluations a search may take: ``max_evaluations`` order^3 for each order."""
        # P_n has more branches than P_(n-1), and each of their points takes n evaluations: the
        # toy's window takes 0.2, 1.2 and 8.7 million for the orders up to 1, 2 and 3.
        return sum(order**3 for order in orders) * self.max_evaluations


def _unit(low: float, high: float) -> float:
    """The length of an interval, unless rounding of the numbers in it is coarse beside that."""
    return max(high - low, SMALLEST_UNIT * max(high, -low))


def differing(settings: Settings, default: Settings) -> dict[str, Any]:
    """Fields that differ from a default, but for the span, which is that of the call."""
    pairs = {each.name: (getattr(settings, each.name), getattr(default, each.name))
             for each in fields(Settings) if each.name != "span"}  # fmt: skip
    return {name: value for name, (value, usual) in pairs.items() if value != usual}
