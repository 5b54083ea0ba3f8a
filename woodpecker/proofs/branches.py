"""Proof of a branch over an interval of the parameter, as a chain of pieces from the low end up.

The tubes of a piece hold exactly one cycle at every parameter (:mod:`woodpecker.proofs.pieces`).
Two pieces join if, where they meet, the enclosure of one cycle lies in the tubes of the other. The
piece of a flip has a monotone multiplier, and lies between a piece above -1 and one below.

The radius of convergence of the Taylor series limits a piece. Where the sleeve almost grazes the
pole, a cycle bends sharply in the parameter, within 1e-8, but not in the duration of that phase:
there the parameter is expanded in the duration. Near a landing at a plateau no series converges,
and one piece holds both sides.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from decimal import ROUND_CEILING, ROUND_HALF_EVEN, Context, Decimal
from fractions import Fraction
from typing import Any, NamedTuple

from flint import arb, arb_poly, arb_series
from scipy.optimize import brentq

from woodpecker.enclosures.balls import ZERO, fraction, number, rounded
from woodpecker.enclosures.following import follow
from woodpecker.enclosures.forms import VALUE, S, sign
from woodpecker.enclosures.model import BallToy
from woodpecker.enclosures.not_proved import NotProved
from woodpecker.enclosures.taylor import Frame
from woodpecker.mechanics.toy import Toy
from woodpecker.proofs.pieces import (
    Fractions,
    Route,
    TooNarrow,
    Tube,
    Tubes,
    curves_near,
    nearest,
    product_of,
    proved,
    value_of,
)
from woodpecker.shooting import shoot

Tell = Callable[[float], object]
CURVE_DECIMALS = 24  # decimals to which the curve of a tube is rounded [rad]
END_DECIMALS = 15  # decimals of the parameter at the ends of pieces
MOST_TUBES = 16  # tubes tried for one piece, each wider than the last: one or two usually suffice
DECIMALS = 4  # to which a flip is located on its line, in units of half the length
FINEST = Fraction(1, 2000)  # the narrowest part tried about a flip, in the same units
WIDEST = Fraction(1, 1000)  # radius of a tube [rad]: beyond it the piece is divided instead

# How a branch is cut into pieces. These numbers decide the cost of a proof, not what it proves.
TERMS = 8  # coefficients of Taylor polynomials along the branch
# Length of the first piece in estimated radii of convergence; it grows with each piece that is
# proved and shrinks with each one that is not.
FIRST_STEP = 0.5
LONGEST = 0.05  # piece, as a fraction of the interval
# Pieces shorter than this hold both sides of a landing at a plateau.
SHORT_AT_PLATEAU = Fraction(3, 10**7)
SHORTEST = Fraction(1, 10**10)  # piece, in units of the parameter; below it a gap is left
LONGEST_GAP = Fraction(1, 10**6)  # longest gap, in units of the parameter
# Radius of convergence above which pieces are expanded in the parameter itself.
UNBENT_RADIUS = 0.003
RADIUS = Fraction(1, 10**18)  # of the first tubes [rad], near the rounding errors of the curves
MARGIN = 2  # a tube that proved too narrow is widened to this multiple of the cycle's enclosure


def prove_along(
    toy: Toy, parameter: str, span: Fractions, points: Sequence[float],
    progress: Tell,
) -> ProvedBranch:  # fmt: skip
    """Prove the branch over an interval from a cycle near its low end; NotProved says where not."""
    found = ProvedBranch(toy, parameter, span, [arb(x) for x in points])
    while found.at < span.high:  # a line is proved or divided, and gaps grow to LONGEST_GAP
        found.go_on()
        progress(float((found.at - span.low) / span.length))
    return found


class ProvedBranch:
    """The part of a branch that is proved so far, and the lines planned for the next pieces."""

    def __init__(self, toy: Toy, parameter: str, span: Fractions, points: Sequence[Any]) -> None:
        self.toy, self.parameter, self.span = toy, parameter, span
        self._points, self._ease = list(points), FIRST_STEP
        self._curves: list[Any] = []  # the points as polynomials in p - base
        self._base, self._reach = span.low, 0.0  # reach: radius of convergence of the curves
        self._plan: list[Route] = []
        self.pieces: list[Tubes] = []  # each begins where the one before ends, or after a gap
        self.gaps: list[Fractions] = []  # intervals between pieces in which nothing is proved
        self.at = span.low  # parameter up to which the branch is done

    def go_on(self) -> None:
        """Prove the piece over the next planned line, or divide that line, or leave a gap."""
        fresh = not self._plan
        try:
            if fresh:
                self._plan = [self._next_line()]
            piece = self._tried(self._plan[0])
        except NotProved as reason:
            if self._plan:
                self._divide(self._plan[0], reason)
            else:
                self._leap(str(reason))
            return
        if fresh:
            self._ease = min(1.5 * self._ease, 4.0)
        self._plan.pop(0)
        self.pieces.append(piece)
        self.at = piece.p.high
        self._points = [piece.end(1, k).mid() for k in range(len(piece.tubes))]

    def _divide(self, line: Route, reason: NotProved) -> None:
        """Replace a line that was not proved by its halves, or by three parts about its flip."""
        if line.interval.length < SHORTEST:
            self._leap(str(reason))
            return
        self._ease = max(self._ease / 1.5, 1e-3)
        parts = self._about_flip(line, reason.piece) if isinstance(reason, MayFlip) else None
        if parts is None and self._creeps(line):
            self._plan = [self._next_line()]
            return
        if parts is None:
            ends = ((-line.half, Fraction(0)), (Fraction(0), line.half))
            parts = [part_of(line, *each) for each in ends]
        self._plan[:1] = parts

    def _creeps(self, line: Route) -> bool:
        """Whether a plateau that the plan does not take into account makes pieces short."""
        short = line.interval.length < SHORT_AT_PLATEAU
        known = line.plateaus or any(each.flips for each in self._plan)
        return short and not known and self._at_plateau()

    def _leap(self, reason: str) -> None:
        low, gap = self.at, 4 * SHORTEST
        if self.gaps and self.gaps[-1].high == low:  # nothing was proved since: widen that gap
            last = self.gaps.pop()
            low, gap = last.low, 2 * last.length
        high = rounded(low + gap, END_DECIMALS)
        if not self.pieces or gap > LONGEST_GAP or high >= self.span.high:
            raise NotProved(
                f"the branch could be followed to {self.parameter} = {float(low):.12g} only: "
                f"{reason}"
            )
        there = self.toy.replace(**{self.parameter: float(high)})
        found = shoot(there, float(self._points[0]), len(self._points))
        if not found.success:
            raise NotProved(f"no cycle was found at {self.parameter} = {float(high):.12g}")
        self.gaps.append(Fractions(low, high))
        self._points, self._curves, self._plan = [arb(x) for x in found.points], [], []
        self.at = high

    def _next_line(self) -> Route:
        """The line from the end of the last piece, across a plateau if that is what limits it."""
        line = self._along_series()
        if line.interval.length > SHORT_AT_PLATEAU or not self._at_plateau():
            return line
        return self._plain(SHORT_AT_PLATEAU)._replace(plateaus=True)

    def _at_plateau(self) -> bool:
        """Whether a contact lands near a plateau at the end of the last piece."""
        frame = Frame(ZERO, ZERO)
        model = BallToy(self.toy, self.parameter, frame, [number(self.at)])
        return any(
            fired.plateau
            for point in self._points
            for way in follow(model, frame, [point], True)
            for fired in way.log
        )

    def _along_series(self) -> Route:
        """The line over which the series converge, in the parameter or in a duration."""
        # If a duration has the smallest radius, its series is inverted: p as a series in it.
        left = self.span.high - self.at
        curves, durations = self._expanded()
        radius, bent = min((_radius(poly), k) for k, poly in enumerate([*curves, *durations]))
        length = self.span.length
        if radius > UNBENT_RADIUS or bent < len(curves):
            step = Fraction(min(self._ease * radius, LONGEST * float(length)))
            return self._plain(step)
        series = durations[bent - len(curves)]
        own = arb_series([0, *series.coeffs()[1:]], TERMS).reversion()
        back = [c.mid() for c in own.coeffs()]
        if back[1] < 0:  # tau = -duration: the parameter must grow with tau
            back = [c * (-1) ** k for k, c in enumerate(back)]
        half = _short(arb(self._ease * _radius(arb_poly(back)) / 2), 2)
        line = _line_from(self.at, [_short(c, 20) for c in back[1:]], half)
        if line.interval.high > self.span.high or not line.interval.high > self.at:
            return self._plain(min(left, Fraction(self._ease * radius)))
        return line

    def _plain(self, step: Fraction) -> Route:
        high = min(self.span.high, rounded(self.at + step, END_DECIMALS))
        if self.span.high - high < step / 4:
            high = self.span.high
        return Route.over(Fractions(self.at, high))

    def _expanded(self) -> tuple[list[Any], list[Any]]:
        """Taylor series in the parameter of the points and of all durations of phases."""
        near = Route((self.at, Fraction(1)), self.span.length / 10**4)
        curves = self._near(near, TERMS)
        frame = Frame(ZERO, ZERO, TERMS)
        model = BallToy(self.toy, self.parameter, frame, [number(c) for c in near.poly])
        polys, durations = [arb_poly([number(c) for c in curve]) for curve in curves], []
        for poly in polys:
            way = nearest(follow(model, frame, poly.coeffs()))
            durations += [fired.duration.parts[VALUE].poly for fired in way.log]
        self._curves, self._base = polys, self.at
        self._reach = min(_radius(poly) for poly in (*polys, *durations))
        return polys, durations

    def _near(self, line: Route, terms: int) -> list[tuple[Fraction, ...]]:
        away = arb_poly([number(c) for c in (line.poly[0] - self._base, *line.poly[1:])])
        guesses = [[point] for point in self._points]
        if self._curves and abs(away[0]) < 2 * self._reach:
            guesses = [poly(away).truncate(terms).coeffs() for poly in self._curves]
        return curves_near(self.toy, self.parameter, line, guesses, terms)

    def _tried(self, line: Route) -> Tubes:
        reasons = list[NotProved]()
        for plateaus in sorted({False, line.plateaus}):  # ranges are sharper without them
            try:
                return self._accepted(line._replace(plateaus=plateaus))
            except NotProved as reason:
                reasons.append(reason)
        raise next((each for each in reasons if isinstance(each, MayFlip)), reasons[-1])

    def _accepted(self, line: Route) -> Tubes:
        piece = self._enclosed(line)
        if line.flips:
            if not sign(piece.turn):
                raise NotProved("the multiplier may not be monotone")
        elif not sign(piece.multiplier + 1):
            raise MayFlip(piece)
        return piece

    def _enclosed(self, line: Route) -> Tubes:
        """The piece over a line; tubes are widened until the cycle fits and the pieces join."""
        curves = [_trimmed(curve, line.half) for curve in self._near(line, TERMS)]
        radii = [RADIUS] * len(curves)
        for tries in range(MOST_TUBES):
            tubes = [Tube(curve, radius) for curve, radius in zip(curves, radii, strict=True)]
            try:
                piece = proved(self.toy, self.parameter, line, tubes, TERMS)
            except TooNarrow as found:
                wider = [_bound(s) * MARGIN for s in found.off]
                if tries > 3 or any(r > WIDEST for r in wider):
                    raise
                radii = list(map(max, radii, wider))
                continue
            last = self.pieces[-1] if self.pieces else None
            if last is None or last.p.high != line.interval.low:  # nothing is proved before it
                return piece
            if joined(end_of(last, 1), end_of(piece, -1)):
                return piece
            radii = [max(r, 2 * need) for r, need in zip(radii, self._needs(piece), strict=True)]
        raise NotProved("two parts side by side may not join")

    def _needs(self, piece: Tubes) -> list[Fraction]:
        """Radii at which the tubes hold the cycle as enclosed at the end of the last piece."""
        last, found = self.pieces[-1], []
        for k, tube in enumerate(piece.tubes):
            here = number(value_of(tube.curve, -piece.line.half))
            found.append(_bound(last.end(1, k) - here))
        return found

    def _about_flip(self, line: Route, piece: Tubes) -> list[Route] | None:
        """Divide a line into the parts before, about and after its flip; None without a flip."""
        tau = _flip_on(piece)
        if tau is None:
            return None
        width = line.half / 2
        while width > FINEST * line.half:  # each try is four times narrower
            a, b = max(tau - width, -line.half), min(tau + width, line.half)
            flip = part_of(line, a, b)._replace(flips=True, plateaus=False)
            try:
                self._tried(flip)
            except NotProved:
                width = width / 4
                continue
            before = [part_of(line, -line.half, a)] if -line.half < a else []
            after = [part_of(line, b, line.half)] if b < line.half else []
            return [*before, flip, *after]
        return None


class MayFlip(NotProved):
    """A ``piece`` is proved, but its multiplier may pass -1."""

    def __init__(self, piece: Tubes) -> None:
        super().__init__("the multiplier may be -1")
        self.piece = piece


def _flip_on(piece: Tubes) -> Fraction | None:
    """Approximate tau at which the series of the multiplier passes -1 on a piece, or None."""
    if any(len(ways) > 1 for ways in piece.ways):
        return None
    series = product_of([way.image.parts[S].poly for (way,) in piece.ways]) + 1

    def above(part: float) -> float:
        """The multiplier + 1 at tau = part * half."""
        return float(series(number(piece.line.half) * arb(part)).mid())

    if not above(-1.0) * above(1.0) < 0.0:
        return None
    return rounded(Fraction(brentq(above, -1.0, 1.0)), DECIMALS) * piece.line.half


class PieceEnd(NamedTuple):
    """The end of a piece, in rational numbers, since balls cannot be sent to other processes."""

    p: Fraction  # the parameter
    tubes: tuple[Fractions, ...]  # about each point the interval in which it is unique [rad]
    found: tuple[Fractions, ...]  # the enclosure of each point [rad]


def end_of(piece: Tubes, side: int) -> PieceEnd:
    """The low (-1) or the high (1) end of a piece."""
    tubes, found = [], []
    for k, tube in enumerate(piece.tubes):
        at, place = value_of(tube.curve, side * piece.line.half), piece.end(side, k)
        tubes.append(Fractions(at - tube.radius, at + tube.radius))
        found.append(Fractions(fraction(place.lower()), fraction(place.upper())))
    return PieceEnd(piece.line.at(side * piece.line.half), tuple(tubes), tuple(found))


def joined(first: PieceEnd, second: PieceEnd) -> bool:
    """Whether two pieces hold the same cycle where they meet: one's lies in the other's tubes."""
    return first.p == second.p and (_holds(first, second) or _holds(second, first))


def _holds(outer: PieceEnd, inner: PieceEnd) -> bool:
    return all(
        tube.low < place.low and place.high < tube.high
        for tube, place in zip(outer.tubes, inner.found, strict=True)
    )


def part_of(line: Route, low: Fraction, high: Fraction) -> Route:
    """The part of a line between two values of tau, expanded about its own middle."""
    middle, poly = (low + high) / 2, list(line.poly)
    for k in range(len(poly) - 1):  # Taylor shift by repeated Horner steps
        for j in range(len(poly) - 2, k - 1, -1):
            poly[j] += middle * poly[j + 1]
    return line._replace(poly=tuple(poly), half=(high - low) / 2)


def _radius(poly: Any) -> float:
    """Radius of convergence of a series, estimated as min |c_1 / c_k|^(1 / (k - 1))."""
    c = [abs(float(x)) for x in poly.coeffs()]
    if len(c) < 3 or c[1] == 0.0:
        return float("inf")
    return float(min((c[1] / x) ** (1.0 / (k - 1)) for k, x in enumerate(c) if k > 1 and x > 0.0))


def _line_from(low: Fraction, rates: Sequence[Fraction], half: Fraction) -> Route:
    """The line that begins at a parameter exactly, with about these rates there."""
    shifted = part_of(Route((low, *rates), half), Fraction(0), 2 * half)
    poly = [Fraction(0), *(_short(number(c), 20) for c in shifted.poly[1:])]
    poly[0] = low - value_of(poly, -half)
    return Route(tuple(poly), half)


def _short(x: Any, digits: int, rounding: str = ROUND_HALF_EVEN) -> Fraction:
    exact, context = fraction(x.mid()), Context(prec=digits, rounding=rounding)
    return Fraction(context.divide(Decimal(exact.numerator), Decimal(exact.denominator)))


def _trimmed(curve: Sequence[Fraction], half: Fraction) -> tuple[Fraction, ...]:
    """Coefficients rounded so that each term is right to CURVE decimals for |tau| <= half."""
    fewer = math.log10(half)  # decimals to add with each power of tau, negative if half < 1
    places = (CURVE_DECIMALS + math.ceil(k * fewer) for k in range(len(curve)))
    return tuple(rounded(c, max(0, n)) for c, n in zip(curve, places, strict=True))


def _bound(x: Any) -> Fraction:
    """A decimal of three digits that bounds the modulus of a ball from above."""
    return _short(abs(x).upper(), 3, ROUND_CEILING)
