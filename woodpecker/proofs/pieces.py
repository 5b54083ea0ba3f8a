"""Tubes that hold exactly one cycle at every value of the parameter.

The points x_0 .. x_(n-1) of a cycle are sought in tubes |x_i - curve_i(p)| <= radius_i. With
s_i = x_i - curve_i(p) the equations are s_(i+1) = e_i(p) + slope_i s_i, where e_i(p) is the
distance between the return from a curve and the next curve, and slope_i encloses the derivative in
the tube. If the solution s lies inside the tubes, they hold exactly one cycle: this is the interval
Newton operator of multiple shooting [Neumaier1990; Tucker2011]. It holds for Lipschitz maps too:
where a word changes, the slope is the hull of those of both ways.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from operator import mul
from typing import Any, NamedTuple

from flint import arb, arb_poly

from woodpecker.enclosures.balls import ZERO, decimal, number
from woodpecker.enclosures.following import follow
from woodpecker.enclosures.forms import SP, SS, VALUE, Form, P, S
from woodpecker.enclosures.model import BallToy
from woodpecker.enclosures.motions import Way
from woodpecker.enclosures.not_proved import NotProved
from woodpecker.enclosures.taylor import Frame, Taylor, cut, inverse, thin
from woodpecker.mechanics.toy import Toy

MOST_FILLED = 0.7  # fraction of a tube that the cycle may fill: the checker's arithmetic is wider
STEPS = 12  # of Newton's method at most; each doubles the correct coefficients
CLOSE = 1e-15  # Newton step below which curves have converged [rad]


class Tube(NamedTuple):
    """A tube of starts about a curve over the parameter."""

    curve: tuple[Fraction, ...]  # coefficients of powers of tau, see :class:`Route`
    radius: Fraction  # largest distance from the curve [rad]


class Fractions(NamedTuple):
    """A closed interval with rational ends."""

    low: Fraction
    high: Fraction

    @property
    def length(self) -> Fraction:
        """High minus low."""
        return self.high - self.low


class Route(NamedTuple):
    """The parameter along a piece, p = poly(tau) for |tau| <= half.

    Mostly tau = p - centre; where a branch bends sharply tau is the duration of a phase.
    """

    poly: tuple[Fraction, ...]  # coefficients of an increasing polynomial
    half: Fraction  # half the length in tau
    flips: bool = False  # whether the multiplier passes -1; its derivative is enclosed then
    plateaus: bool = False  # whether landings just before and after a plateau are one event

    @classmethod
    def over(cls, p: Fractions) -> Route:
        """The linear line over an interval of the parameter."""
        return cls(((p.low + p.high) / 2, Fraction(1)), p.length / 2)

    def at(self, tau: Fraction) -> Fraction:
        """The parameter at tau."""
        return value_of(self.poly, tau)

    @property
    def interval(self) -> Fractions:
        """The interval of the parameter."""
        return Fractions(self.at(-self.half), self.at(self.half))


def value_of(poly: Sequence[Fraction], x: Fraction) -> Fraction:
    """The value of a polynomial, by Horner's scheme."""
    return reduce(lambda total, c: total * x + c, reversed(poly), Fraction(0))


@dataclass(frozen=True)
class Tubes:
    """A piece: tubes that are proved to hold exactly one cycle at every parameter on a line."""

    line: Route  # the parameter over the interval
    tubes: tuple[Tube, ...]  # one for each point of the cycle
    ways: tuple[tuple[Way, ...], ...]  # from each tube: one, or two where a word changes
    off: tuple[Any, ...]  # enclosures of the distances of the points from their curves [rad]
    slopes: tuple[Any, ...]  # ranges of the derivative of each return in its tube
    turn: Any = None  # range of the multiplier's derivative in tau; None if not asked for

    @property
    def multiplier(self) -> Any:
        """Range of the multiplier."""
        return product_of(self.slopes)

    @property
    def period(self) -> Any:
        """Range of the period [s]."""
        return sum((_hull([way.time.box for way in ways]) for ways in self.ways), ZERO)

    @property
    def drop(self) -> Any:
        """Range of the distance fallen [m]."""
        return sum((_hull([way.drop.box for way in ways]) for ways in self.ways), ZERO)

    @property
    def p(self) -> Fractions:
        """The interval of the parameter."""
        return self.line.interval

    def end(self, side: int, point: int = 0) -> Any:
        """Enclosure of a point of the cycle at the low (-1) or high (1) end."""
        there = value_of(self.tubes[point].curve, side * self.line.half)
        return number(there) + self.off[point]


def proved(toy: Toy, parameter: str, line: Route, tubes: Sequence[Tube], terms: int = 1) -> Tubes:
    """Prove that tubes hold exactly one cycle at every parameter on a line; else NotProved.

    ``terms`` is the number of coefficients of Taylor models along the curves.
    """
    ball, poly = arb(0, number(line.half).upper()), [number(c) for c in line.poly]
    if len(poly) > 1 and not arb_poly(poly).derivative()(ball) > 0:
        raise NotProved("the parameter may turn round")
    ways, misses, slopes = [], [], []
    for k, tube in enumerate(tubes):
        frame = Frame(arb(0, number(tube.radius).upper()), ball, terms, 6 if line.flips else 2)
        model = BallToy(toy, parameter, frame, poly)
        curve = [number(c) for c in tube.curve]
        found = tuple(follow(model, frame, curve, line.plateaus))
        if any(fork.jumps for way in found for fork in way.forks):
            raise NotProved("the map may jump")
        if line.flips and len(found) > 1:
            raise NotProved("the word may change")
        following = _line(frame, tubes[(k + 1) % len(tubes)])
        misses.append(_hull([(way.image.parts[VALUE] - following).box for way in found]))
        slopes.append(_hull([way.image.parts[S].box for way in found]))
        ways.append(found)
    off = solve_cyclic(misses, slopes)
    _check_minimal_period(tubes, ball)
    for tube, s in zip(tubes, off, strict=True):
        if not abs(s) < MOST_FILLED * number(tube.radius):
            raise TooNarrow(off)
    turn = _turn(tubes, [found[0] for found in ways], slopes) if line.flips else None
    return Tubes(line, tuple(tubes), tuple(ways), tuple(off), tuple(slopes), turn)


def _check_minimal_period(tubes: Sequence[Tube], ball: Any) -> None:
    """NotProved if the cycle in the tubes may be a shorter one, traversed several times."""
    n = len(tubes)

    def meet(a: Tube, b: Tube) -> bool:
        polys = [arb_poly([number(c) for c in tube.curve]) for tube in (a, b)]
        return not abs((polys[0] - polys[1])(ball)) > number(a.radius + b.radius)

    for period in range(1, n):
        if n % period == 0 and all(meet(tubes[k], tubes[(k + period) % n]) for k in range(n)):
            raise NotProved(f"the cycle may be one of {period}, passed several times")


class TooNarrow(NotProved):
    """The enclosure of the cycle leaves the tubes; ``off`` encloses s at each point."""

    def __init__(self, off: Sequence[Any]) -> None:
        super().__init__("no cycle could be shown to lie in the tube")
        self.off = off


def solve_cyclic(e: Sequence[Any], slopes: Sequence[Any]) -> list[Any]:
    """Solve s_(i+1) = e_i + slope_i s_i for a cycle; NotProved if the multiplier may be 1."""
    whole = 1 - product_of(slopes)
    if whole.contains(0):
        raise NotProved("the multiplier may be 1")
    return [total / whole for total in _cyclic_sums(e, slopes)]


def _cyclic_sums(e: Sequence[Any], slopes: Sequence[Any]) -> list[Any]:
    """Return (1 - multiplier) s at each point, balls or series: the sums once around the cycle."""
    n, found = len(e), []
    for i in range(n):
        total = ZERO
        for k in range(i, i + n):
            total = e[k % n] + slopes[k % n] * total
        found.append(total)
    return found


def _turn(tubes: Sequence[Tube], ways: Sequence[Way], slopes: Sequence[Any]) -> Any:
    """Range of the derivative of the multiplier in tau."""
    # The points move as s_(i+1)' = e_i' + slope_i s_i', and slope_i' = f_sp + f_ss s_i'.
    misses = []
    for k, way in enumerate(ways):
        following = _line(way.image.frame, tubes[(k + 1) % len(tubes)], rate=True)
        misses.append((way.image.parts[P] - following).box)
    moves = solve_cyclic(misses, slopes)
    total = ZERO
    for k, way in enumerate(ways):
        image: Form = way.image
        own = image.parts[SP].box + image.parts[SS].box * moves[k]
        total = total + own * product_of([*slopes[:k], *slopes[k + 1 :]])
    return total


def _line(frame: Frame, tube: Tube, rate: bool = False) -> Taylor:
    """The curve of a tube, or its derivative in tau, as a Taylor model."""
    poly = arb_poly([number(c) for c in tube.curve])
    return cut(frame, poly.derivative() if rate else poly, ZERO)


def _hull(balls: Sequence[Any]) -> Any:
    return reduce(arb.union, balls)


def product_of(factors: Sequence[Any]) -> Any:
    """The product of balls or series."""
    return reduce(mul, factors, arb(1))


def curves_near(
    toy: Toy, parameter: str, line: Route, guesses: Sequence[Sequence[Any]], terms: int
) -> list[tuple[Fraction, ...]]:
    """Taylor polynomials in tau of the points of a cycle about the middle of a line, not proved."""
    # Newton's method on polynomials: each step doubles the number of correct coefficients.
    frame, half = Frame(ZERO, ZERO, terms), number(line.half)
    model = BallToy(toy, parameter, frame, [number(c) for c in line.poly])
    curves = [arb_poly(list(guess)) for guess in guesses]
    for _ in range(STEPS):
        misses, slopes = [], []
        for k, curve in enumerate(curves):
            image = nearest(follow(model, frame, curve.coeffs(), line.plateaus)).image.parts
            misses.append(thin(image[VALUE].poly - curves[(k + 1) % len(curves)], terms))
            slopes.append(thin(image[S].poly, terms))
        steps = _series_around(frame, misses, slopes)
        curves = [thin(curve + step, terms) for curve, step in zip(curves, steps, strict=True)]
        if all(_reach(step, half) < CLOSE for step in steps):
            break
    return [tuple(decimal(c) for c in curve.coeffs()) for curve in curves]


def _reach(poly: Any, half: Any) -> Any:
    return sum((abs(c) * half**k for k, c in enumerate(poly.coeffs())), ZERO)


def nearest(ways: Sequence[Way]) -> Way:
    """The way that is taken at the centre of the box."""
    return next(
        (way for way in ways if all(fork.side * fork.comparator.mid > 0 for fork in way.forks)),
        ways[0],
    )


def _series_around(frame: Frame, e: Sequence[Any], slopes: Sequence[Any]) -> list[Any]:
    """:func:`solve_cyclic` for truncated series."""
    whole = thin(1 - product_of(slopes), frame.terms)
    over = inverse(Taylor(frame, whole, ZERO)).poly
    return [thin(total * over, frame.terms) for total in _cyclic_sums(e, slopes)]
