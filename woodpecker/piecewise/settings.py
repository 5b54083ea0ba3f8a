"""Every number that decides a result of the continuation, with its reason and its scale."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import Field, dataclass, fields
from typing import Any

from pwmap.diagrams.shown import changed
from woodpecker.base.checks import interval, positive, whole


@dataclass(frozen=True, slots=True, kw_only=True)
class Numerics:
    """Numbers that decide how borders, steps and solutions are told apart.

    None of them needs to be tuned: they are here to be seen, kept with a run, and varied. Those
    without a unit are parts of a length, or factors, so they hold on any scale.

    Parameters
    ----------
    contraction
        Newton's method for a sample: times a step that the next may have; a longer one leads to
        another orbit, for next to a solution steps shrink.
    noise
        Newton's method: times ``Settings.converged`` below which steps that shrink slowly are
        rounding; also roundings that may be left of an equation. Two bits above the shortest step.
    blur
        Relative rounding of the images and margins of a map, which says how well a special point is
        located: 20 spacings of doubles, what a return of the toy loses over its events.
    doubled
        In x, a part of the window: points of a cycle this close are one. A doubled cycle leaves its
        flip like a square root, and the parameter there is good to rounding.
    at_flip
        In x, a part of the window: a flip and the fold of the doubled cycle this close are one
        point, if their parameters are as close as its square. As far again above ``doubled``.
    linked
        Fold-flip points in a chain that tell that it has no end: four at each of the two places
        that they approach, so that three distances shrink by two ratios.
    alike
        Part by which ratios of successive distances differ at most that make a geometric series: of
        the first that count, where the map is not linear yet, by an eighth, then four times less
        with each.
    drawn
        Ends of branches this close, scaled, are the same: a flip that ends one of them may be taken
        for a border beside it.
    apart
        And this close as a part of the branch: short ones that follow each other are not the same.
    compared
        Places at which two branches with the same ends are compared: one may have passed over a
        piece that the other has at some of them.
    nearer
        Part of a distance from a border at which the piece was not found that is tried next; the
        same factor widens a distance from a place where borders accumulate.
    restart
        The same if there is no orbit of the piece at that distance: each trial is Newton's method,
        so steps are twice as large. A corner is looked at first one such step inside of ``beside``.
    thin
        A piece next to a border that is thinner than this part of a distance is passed over: it is
        another one, not rounding, from some parts in a thousand on.
    resolved
        Times ``Settings.nearest``: a distance from a border at which slopes have some digits left.
    slack
        Part of an interval by which a point of it may seem to lie outside, by rounding: half of the
        digits.
    strays
        A value that is this many times as far away as the larger slope at two points allows lies on
        another solution of the piece: the slope in between may be larger, but not by that.
    steep
        A slope above this is that of a square root right at its border: rounded, it is about 1e8.
    rooted
        Times the slope beyond a border by which that of a square root next to it is larger.
    probe
        Part of a distance from a border at which a second slope tells a square root: its next term,
        linear in it, is then too small to matter.
    farthest
        The largest such part, if rounding leads to another solution nearer to the border: its root
        is taken until then.
    exponent
        By how much the power of the distance with which a slope grows may differ from 1/2, that of
        a square root: half of the way to a pole or a kink.
    retry
        Part of a step that is tried next if the map takes another piece at its end.
    crossing
        Part of a step to which a branch point is located: there the equations are singular, and
        rounding moves an orbit by its root.
    difference
        Part of the scales over which slopes are compared about a branch point: a central difference
        is best at the cube root of their rounding. An error of it makes Newton's method slower, and
        its root no worse.
    clear
        Part of the distance from the nearest border over which they are compared at most: a map may
        have a root or a pole there.
    worth
        A margin that falls, between two samples, below this part of its smaller end is looked at
        there: a cubic is well within that.
    bent
        A margin's slope at one end of a step that is so many times its change and its slope at the
        other end is that beside a square root.
    third, third_of_slope
        The cubic of a margin whose third power is so many times the smaller end, and such a part of
        the larger slope, may hide a zero: along a branch that is followed well it is small.
    ahead
        Part of the way to a border that a step over it has: to first order it lies there.
    both
        Times as closely as a border is located other margins may vanish there too.
    split
        Part of a way that is tried first where its far end is lost, or the near one steep.
    uneven
        Slopes whose ratio is larger are split beside the steeper one.
    short, widen
        Part of the way to the border of a piece that has no value beyond it that is left at first;
        and how much more if the piece was lost all the same. Both are closed in on fast.
    safety
        Times an estimated error, in the same place: one bit more than the next term of a series
        makes of it.
    strayed
        Steps to a root after which every third halves: three are enough where cubics do not
        mislead.
    long
        A piece that reaches back by this part of a step is worth stopping at; shorter ones are
        stepped over, where infinitely many accumulate.
    edge
        Where a turning point seems to lie within this part of an end of an interval the interval is
        halved instead.
    starts, continued
        A piece is continued to a point from at most so many known ones, and the way is halved at
        most so often before it is said to have no value there.
    torn
        Part by which a multiplier changes beyond a border only if the slopes differ: over the
        distance of a restart it changes by some 1e-4.
    repeats
        In x, a part of the window: an orbit that has settled repeats itself so closely.
    longest
        Longest period that is looked for in an orbit that has settled.
    looked
        In x, a part of the window: how far from a guess, from which shooting finds no cycle, a jump
        is looked for.

    Raises
    ------
    ValueError
        If a number is not positive, or a part is not less than 1, a factor not more.

    Examples
    --------
    >>> from woodpecker import Numerics, Settings
    >>> Numerics().longest
    64
    >>> settings = Settings(numerics=Numerics(longest=200))
    """

    contraction: float = 2.0
    noise: float = 64.0
    blur: float = 20.0 * 2.0**-52
    doubled: float = 1e-5
    at_flip: float = 1e-4
    linked: int = 8
    alike: float = 0.25
    drawn: float = 1e-7
    apart: float = 0.01
    compared: int = 7
    nearer: float = 0.1
    restart: float = 0.01
    thin: float = 1e-3
    resolved: float = 100.0
    slack: float = 1e-6
    strays: float = 2.0
    steep: float = 1e6
    rooted: float = 10.0
    probe: float = 1e-4
    farthest: float = 0.2
    exponent: float = 0.25
    retry: float = 0.25
    crossing: float = 1e-6
    difference: float = 2.0**-17
    clear: float = 2.0**-10
    worth: float = 0.25
    bent: float = 10.0
    third: float = 2.0
    third_of_slope: float = 0.5
    ahead: float = 1.25
    both: float = 16.0
    split: float = 0.125
    uneven: float = 16.0
    short: float = 2.0**-4
    widen: float = 8.0
    safety: float = 4.0
    strayed: int = 6
    long: float = 0.25
    edge: float = 0.02
    starts: int = 4
    continued: int = 8
    torn: float = 0.01
    repeats: float = 1e-6
    longest: int = 64
    looked: float = 0.01

    def __repr__(self) -> str:
        """The call that makes them: what differs from the default."""
        return changed(self)

    def __post_init__(self) -> None:
        for each in fields(self):
            checked = _checked(self, each)
            if isinstance(each.default, float):
                _part_or_factor(each.name, checked, part=each.default < 1.0)
            object.__setattr__(self, each.name, checked)


def _checked(settings: Any, each: Field[Any]) -> Any:
    """A setting that is positive: a whole number, or any, as its default is."""
    check = whole if isinstance(each.default, int) else positive
    return check(each.name, getattr(settings, each.name))


def _part_or_factor(name: str, value: float, *, part: bool) -> None:
    """Complain of a part of something that is not less than 1, or a factor that is not more."""
    if not (value < 1.0 if part else value > 1.0):
        raise ValueError(f"{name} must be {'less' if part else 'more'} than 1, got {value}")


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
    again
        First step beyond a border, if the last one before it was shorter: where borders follow each
        other closely, pieces that begin and end within it are passed over.
    min_step
        Smallest step; a branch that needs a smaller one ends (EP). Borders that are closer together
        than this are passed over, and their number is not known.
    max_turn
        Largest angle [rad] between the tangents of neighbouring samples.
    hairpin
        Where a branch turns within less than this the angle may be larger, as its inverse: what is
        drawn is as good, and half as many samples tell what lies between them.
    max_samples
        A branch ends (EP) after this many.
    max_evaluations
        Of P_1, of a whole search; where P_n is looked at, too, n^2 times as many more. A branch
        takes at most three fifths of its own each way and a slice a sixteenth: the longest branches
        of the toy need 290 000. What is left after that many is said. A return of very many phases
        counts as several.
    max_pieces
        Of P_1 in a slice, and ten times as many of an iterate: the toy has some hundred. The rest
        is reported as not resolved.
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
        below a step. A piece there that is thinner than a thousandth of it is passed over.
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
    numerics
        Numbers that hardly anybody will want to change.

    Raises
    ------
    ValueError
        If span or window are no two ascending numbers, or a number is not positive.
    TypeError
        If ``numerics`` are none.

    Examples
    --------
    >>> from sympy import Piecewise, symbols
    >>> from woodpecker import Settings, connected, from_sympy
    >>> x, p = symbols("x p")
    >>> formula = Piecewise((x/2 + p, x < 0), (x/3 + p - 1, True))
    >>> lines = from_sympy(formula, x, p, words=["L", "R"])
    >>> settings = Settings(span=(-1, 2), window=(-3, 3), max_step=0.2)
    >>> [point.parameter for point in connected(lines, -1.0, -0.5, settings).points]
    [-1.0, 0.0, 1.0, 2.0]
    """

    span: tuple[float, float] = (0.0, 1.0)
    window: tuple[float, float] = (-math.inf, math.inf)
    step: float = 0.005
    max_step: float = 0.02
    again: float = 1e-4
    min_step: float = 1e-13
    max_turn: float = 0.1
    hairpin: float = 1e-6
    max_samples: int = 20_000
    max_evaluations: int = 500_000
    max_pieces: int = 10_000
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
    numerics: Numerics = Numerics()

    def __repr__(self) -> str:
        """The call that makes them: what differs from the default."""
        return changed(self)

    def __post_init__(self) -> None:
        for name in ("span", "window"):
            ends = interval(name, getattr(self, name), finite=name == "span")
            object.__setattr__(self, name, ends)
        for each in fields(self):
            if isinstance(each.default, int | float):
                object.__setattr__(self, each.name, _checked(self, each))
        if not self.min_step <= self.step <= self.max_step:
            raise ValueError(
                f"step must lie in [{self.min_step}, {self.max_step}], got {self.step}"
            )
        if not self.converged <= self.nearest:
            raise ValueError(
                f"nearest must be at least converged = {self.converged:.3g}, got {self.nearest}"
            )
        if not isinstance(self.numerics, Numerics):
            raise TypeError(f"numerics must be woodpecker.Numerics, got {self.numerics!r}")

    @property
    def resolved(self) -> float:
        """Distance in x from a border at which slopes have some digits left."""
        return self.numerics.resolved * self.nearest * self.x_scale

    @property
    def thinnest(self) -> float:
        """Thickness in x of pieces next to a border below which they are passed over."""
        return self.numerics.thin * self.beside * self.x_scale

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

    def rounded_x(self, x: float) -> float:
        """How far rounding of a map may move a point.

        Parameters
        ----------
        x
            The point.

        Returns
        -------
        float
            ``converged`` of its magnitude, or of the unit of x if that is larger.
        """
        return self.converged * max(self.x_scale, abs(x))

    def rounded_p(self, p: float) -> float:
        """How far rounding of a map may move a parameter.

        Parameters
        ----------
        p
            The parameter.

        Returns
        -------
        float
            ``converged`` of its magnitude, or of its unit if that is larger.
        """
        return self.converged * max(self.p_scale, abs(p))

    def of_branch(self, order: int) -> int:
        """How many evaluations a branch may take, from one special point to the next.

        Parameters
        ----------
        order
            Of the iterate to which it belongs.

        Returns
        -------
        int
            A part of ``max_evaluations``.
        """
        return order**2 * self.max_evaluations * 3 // 5

    def of_slice(self, orders: Sequence[int]) -> int:
        """How many evaluations a slice may take.

        Parameters
        ----------
        orders
            Of the iterates that it shows.

        Returns
        -------
        int
            A part of ``max_evaluations``.
        """
        return max(orders) ** 2 * self.max_evaluations // 16

    def of_search(self, orders: Sequence[int]) -> int:
        """How many evaluations a search may take.

        Parameters
        ----------
        orders
            Of the iterates whose branches are looked for.

        Returns
        -------
        int
            ``max_evaluations`` for each of them, times its square.
        """
        return sum(order**2 for order in orders) * self.max_evaluations


SMALLEST_UNIT = 2.0**-8  # of the largest magnitude: then ``nearest`` is some seventeen spacings


def _unit(low: float, high: float) -> float:
    """The length of an interval, unless rounding of the numbers in it is coarse beside that."""
    return max(high - low, SMALLEST_UNIT * max(high, -low))


def differing(settings: Settings | Numerics, default: Settings | Numerics) -> dict[str, Any]:
    """Fields that differ from a default, but for the span, which is that of the call."""
    found: dict[str, Any] = {}
    for each in fields(settings):
        value, usual = getattr(settings, each.name), getattr(default, each.name)
        if value != usual and each.name != "span":
            found[each.name] = differing(value, usual) if isinstance(value, Numerics) else value
    return found
