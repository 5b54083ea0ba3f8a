"""The settings of continuation and slices, with their scales."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

from pwmap.algebra.arguments import explained_fields
from pwmap.diagrams.shown import changed
from woodpecker.base.checks import interval, positive, whole

EVALUATIONS = 500_000  # the longest branches of the toy need 290 000
SMALLEST_UNIT = 2.0**-8  # of the largest number: ``nearest`` is then some 17 of its spacings


@explained_fields
@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """How far, how finely and how exactly to follow branches.

    Lengths are fractions of a unit, so that scales do not matter: the unit is the length of
    ``span`` for the parameter and of ``window`` for x (1 if that is infinite), but, because of
    rounding, at least 1/256 of the largest number in the interval.

    Parameters
    ----------
    span
        Interval of the parameter, finite; branches end (EP) at its ends.
    window
        Interval of x; branches end (EP) where an orbit leaves it. A search for every branch needs a
        finite one.
    step, min_step, max_step
        First, smallest and largest step in arclength. A branch that needs a smaller step ends (EP);
        borders closer together than ``min_step`` are passed over and not counted.
    max_turn
        Largest angle [rad] between the tangents of neighbouring samples.
    max_samples
        Largest number of samples of a branch, at which it ends (EP).
    max_evaluations
        Evaluations of P_1 in a whole search, plus n^3 times as many for P_n. A branch of P_n takes
        at most 3/5 of n^2 times as many each way (1/6 in a search of a window), a slice 1/16. The
        result says what was left undone. A return of very many phases counts as several.
    max_pieces
        Pieces of P_1 in a slice, ten times as many of an iterate; the rest counts as unresolved.
    converged
        A Newton step shorter than this is the last.
    beside, nearest
        Distance from a border at which the piece beyond it is first looked for, and the smallest,
        used if others lie between; pieces thinner than a thousandth of ``beside`` are passed over.
    jump
        One-sided limits that differ by less are equal.
    kink
        Slopes on both sides whose relative difference is smaller are equal.
    finest
        Length of the shortest pieces that are found one by one; of shorter ones the total length is
        reported.
    coarse
        The same for pieces without cycles: with images away from the diagonal, if fixed points of
        P_1 are sought, or outside of the window, if cycles of iterates are.
    same
        Orbits at one parameter that are closer than this are one.

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
    max_evaluations: int = EVALUATIONS
    max_pieces: int = 10_000  # the toy has some hundred
    converged: float = 2.0**-48  # 16 spacings of doubles at 1, what rounding of a map leaves
    beside: float = 1e-6  # far above rounding, far below a step
    nearest: float = 1e-12  # some hundred times ``converged``, so that rounding decides nothing
    # far above what rounding of the place makes at a steep slope, far below jumps worth drawing
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
                check = whole if isinstance(each.default, int) else positive
                object.__setattr__(self, each.name, check(each.name, getattr(self, each.name)))
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
        """The rounding error of a map, in spacings of doubles at 1."""
        return self.converged * 2.0**52

    @property
    def x_scale(self) -> float:
        """The unit of length in x."""
        return unit(*self.window)

    @property
    def p_scale(self) -> float:
        """The unit of length in the parameter."""
        return unit(*self.span)

    def of_branch(self, order: int, *, one_of_many: bool = False) -> int:
        """How many evaluations a branch of iterate ``order`` may take between special points.

        They are fewer if it is ``one_of_many`` in a search for all branches of a window.
        """
        allowed = order**2 * self.max_evaluations
        return allowed // 6 if one_of_many else allowed * 3 // 5

    def of_slice(self, orders: Sequence[int]) -> int:
        """How many evaluations a slice for iterates of some orders may take."""
        return max(orders) ** 2 * self.max_evaluations // 16

    def of_search(self, orders: Sequence[int]) -> int:
        """How many evaluations a search may take: ``max_evaluations`` times the sum of order^3."""
        # P_n has more branches than P_(n-1), and each point takes n evaluations of P_1: the toy's
        # window takes 0.2, 1.2 and 8.7 million for the orders up to 1, 2 and 3.
        return sum(order**3 for order in orders) * self.max_evaluations


def unit(low: float, high: float) -> float:
    """The unit of length in an interval: its length, or 1 if that is infinite.

    It is larger if the interval is so short that rounding of its numbers counts (SMALLEST_UNIT).
    """
    length = high - low
    return max(length, SMALLEST_UNIT * max(high, -low)) if math.isfinite(length) else 1.0


def differing(settings: Settings, default: Settings) -> dict[str, Any]:
    """The settings, except the span, that differ from a default, by name."""
    pairs = {each.name: (getattr(settings, each.name), getattr(default, each.name))
             for each in fields(Settings) if each.name != "span"}  # fmt: skip
    return {name: value for name, (value, usual) in pairs.items() if value != usual}
