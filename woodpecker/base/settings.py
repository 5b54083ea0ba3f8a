"""The settings of continuation and slices, with their scales."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

from pwmap.algebra.arguments import explained_fields
from pwmap.diagrams.shown import changed
from woodpecker.base.checks import interval, positive, whole

SMALLEST_UNIT = 2.0**-8  # of the largest magnitude: then ``nearest`` is some seventeen spacings


@explained_fields
@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """How far, how finely and how exactly to follow branches.

    Lengths are parts of scales, so that units do not matter: of the length of ``span`` in the
    parameter and of ``window`` in x (1 if that is infinite), but at least 1/256 of the largest
    number in the interval, because of rounding.

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
        Samples of a branch, after which it ends (EP).
    max_evaluations
        Of P_1, in a whole search; n^3 times as many more for P_n. A branch of P_n takes at most
        three fifths of n^2 times as many each way, a slice a sixteenth. The result says what is
        left. A return of very many phases counts as several.
    max_pieces
        Of P_1 in a slice, and ten times as many of an iterate; the rest is reported as unresolved.
    converged
        Length of a Newton step that is the last.
    beside, nearest
        First distance from a border at which the piece beyond is asked for, and the smallest, if
        others lie between; pieces thinner than a thousandth of ``beside`` are passed over.
    jump
        Smallest difference of limits that are different.
    kink
        Smallest relative difference of slopes that are different.
    finest
        Length of the shortest pieces that are found one by one; the total length of others is
        reported.
    coarse
        The same for pieces whose images lie away from the diagonal if fixed points of P_1 are
        sought, or outside of the window if cycles of iterates are.
    same
        Distance of orbits at one parameter, below which they are one.

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
        """The rounding of a map, in spacings of doubles."""
        return self.converged * 2.0**52

    @property
    def x_scale(self) -> float:
        """The unit of x."""
        return unit(*self.window)

    @property
    def p_scale(self) -> float:
        """The unit of the parameter."""
        return unit(*self.span)

    def of_branch(self, order: int, *, one_of_many: bool = False) -> int:
        """How many evaluations a branch of an iterate of ``order`` may take between special points.

        Fewer if it is ``one_of_many`` in a search for all branches of a window.
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


def unit(low: float, high: float) -> float:
    """The length of an interval, or more if rounding of its numbers is coarse beside that.

    It is 1 if that is infinite.
    """
    length = high - low
    return max(length, SMALLEST_UNIT * max(high, -low)) if math.isfinite(length) else 1.0


def differing(settings: Settings, default: Settings) -> dict[str, Any]:
    """Settings that differ from a default, without the span."""
    pairs = {each.name: (getattr(settings, each.name), getattr(default, each.name))
             for each in fields(Settings) if each.name != "span"}  # fmt: skip
    return {name: value for name, (value, usual) in pairs.items() if value != usual}
