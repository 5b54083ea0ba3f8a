"""Every number that decides a result of the continuation, with its reason and its scale."""

from __future__ import annotations

import math
from dataclasses import dataclass

from woodpecker.base.checks import interval, positive, whole


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """How far, how finely and how exactly to follow branches.

    Lengths are parts of the scales: of the length of ``span`` in the parameter, and of ``window``
    in x (of 1 if it is infinite). So they need no tuning for maps in other units.

    Parameters
    ----------
    span
        Interval of the parameter, finite; branches end (EP) at its ends.
    window
        Interval of x; branches end (EP) where an orbit leaves it. A search for every branch needs a
        finite one.
    step, max_step
        First and largest step in arclength.
    again
        First step beyond a border, if the last one before it was shorter: where borders follow each
        other closely, pieces that begin and end within it are passed over.
    min_step
        Smallest step; a branch that needs a smaller one ends (EP). Borders that are closer together
        than this are passed over, and their number is not known.
    max_turn
        Largest angle [rad] between the tangents of neighbouring samples.
    max_samples
        A branch ends (EP) after this many.
    newton
        Largest number of Newton steps of a corrector; four are usual, more show a bad start.
    converged
        A Newton step of this length is the last: 16 spacings of doubles at 1, what rounding of a
        map leaves.
    stalled
        Steps that become no shorter are as good as converged below this length: rounding of an
        ill-conditioned orbit, five digits above the usual.
    beside
        Distance from a border at which the piece beyond is asked for first: far above rounding, far
        below a step.
    nearest
        Smallest such distance, tried if there are other pieces in between: far enough from the
        border, some hundred times ``converged``, for rounding not to decide.
    jump
        Limits of a map closer than this are one value: far above what is left of a rounded
        location at a steep slope, far below jumps that are worth drawing.
    kink
        Slopes that differ by a larger part than this differ.
    finest
        Pieces shorter than this are not looked for one by one: a part of the window. Where they
        accumulate, their total length is reported.
    coarse
        The same for pieces that lead elsewhere: if fixed points of P_1 are looked for, away from
        the diagonal; if cycles of iterates are, out of the window.
    same
        Orbits this close at one parameter are one: far above rounding, far below their distances.
    closer
        Part of its distance that a Newton step leaves at most if it leads to an orbit: from a point
        of the same branch it leaves next to nothing, from elsewhere most.
    near
        A value this close to the diagonal may have a fixed point near it: neighbouring pieces of a
        map that accumulate differ by a few hundredths of the window.
    even
        Samples of a piece lie so close that slopes at two of them and between them differ by a rise
        of this part of the window; cubics are a tenth of it off, and what they do not tell is then
        so close to the diagonal that it is looked for by Newton's method.
    halvings
        Of an interval in which a cycle of an iterate lies, before Newton's method begins: to 6e-8
        of it, more than cubics are good for.
    interior, zooms
        Points inside an increasing piece of an iterate at which two cycles are looked for, and how
        often closer to the one nearest to the diagonal: 16^4 points, of which one in a thousand is
        looked at.
    loose
        A piece of an iterate whose end seems to miss the diagonal by this part of its length may
        meet it: its ends are interpolated.
    pulls
        How often an orbit is pulled back point by point, if Newton's method fails from a guess:
        each time what it is off falls by the product of its slopes.

    Raises
    ------
    ValueError
        If span or window are no two ascending numbers, or a number is not positive.
    """

    span: tuple[float, float] = (0.0, 1.0)
    window: tuple[float, float] = (-math.inf, math.inf)
    step: float = 0.005
    max_step: float = 0.02
    again: float = 1e-4
    min_step: float = 1e-13
    max_turn: float = 0.1
    max_samples: int = 20_000
    newton: int = 12
    converged: float = 2.0**-48
    stalled: float = 1e-10
    beside: float = 1e-6
    nearest: float = 1e-12
    jump: float = 1e-7
    kink: float = 1e-6
    finest: float = 1e-6
    coarse: float = 1e-4
    same: float = 1e-9
    closer: float = 0.5
    near: float = 0.1
    even: float = 5e-4
    halvings: int = 24
    interior: int = 16
    zooms: int = 4
    loose: float = 0.02
    pulls: int = 3

    def __post_init__(self) -> None:
        for name in ("span", "window"):
            ends = interval(name, getattr(self, name), finite=name == "span")
            object.__setattr__(self, name, ends)
        for name in (
            "step", "max_step", "again", "min_step", "max_turn", "converged", "stalled", "beside",
            "nearest", "jump", "kink", "finest", "coarse", "same", "closer", "near", "even",
            "loose",
        ):  # fmt: skip
            object.__setattr__(self, name, positive(name, getattr(self, name)))
        if not self.min_step <= self.step <= self.max_step:
            raise ValueError(
                f"step must lie in [{self.min_step}, {self.max_step}], got {self.step}"
            )
        for name in ("max_samples", "newton", "halvings", "interior", "zooms", "pulls"):
            object.__setattr__(self, name, whole(name, getattr(self, name)))

    @property
    def x_scale(self) -> float:
        """The unit of x."""
        low, high = self.window
        return high - low if math.isfinite(high - low) else 1.0

    @property
    def p_scale(self) -> float:
        """The unit of the parameter."""
        return self.span[1] - self.span[0]
