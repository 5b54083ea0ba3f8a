"""From the start of a free flight to sliding, where a gap closes near a pause of its motion."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple

from woodpecker.checking.forms import F, chain, constant, over
from woodpecker.checking.guards import GuardValue
from woodpecker.checking.impacts import slip, solve_impact
from woodpecker.checking.intervals import Box, I, NotSeparated, T, wave
from woodpecker.checking.plateaus import Landing
from woodpecker.checking.toy import ANGLE, DOWN, OPEN, SIDE, UP, Coasting, ExactToy


class Flight(NamedTuple):
    """A free flight where it begins, and the guards but that of the contact that lands."""

    toy: ExactToy
    box: Box
    q: Sequence[F]
    u: Sequence[F]
    others: Sequence[GuardValue]


class Sliding(NamedTuple):
    """Sliding from the middle of a pause."""

    q: list[F]
    u: list[F]
    states: tuple[int, int, int]
    level: F  # the gap without a landing: late where it is positive, else early
    middle: I
    last: I  # time after which the contact has come to stay


def pause(motion: Flight, i: int, late: bool, bracket: I, jet: Sequence[F | I]) -> Sliding:
    """From where the sleeve has let go to the middle of the pause, in the bracket, of contact i."""
    toy, free = motion.toy, motion.toy.mode((OPEN, OPEN, OPEN))
    start, fall, kappa = jet[0], jet[3], I.of(free.kappa)
    assert isinstance(start, F)
    if not isinstance(fall, F) or fall.value.sign() != -1 or kappa.sign() != -1:
        raise NotSeparated("a gap does not fall to a pause")
    swing = I.pi() * I.of(2) / (-kappa).sqrt()
    n = round(float(bracket.mid) / float(swing))
    if n < 1:
        raise NotSeparated("a gap has no pause where it begins to close")
    middle = swing * I.of(n)
    steps = -(middle / kappa)  # s_3, where s_1 = s_2 = 0
    level = start + fall * steps
    eta = -(level * over(fall))
    sign = eta.value.sign()
    if sign == (-1 if late else 1):
        raise NotSeparated("a contact lands on the other side of a pause")
    q, u = _flown(free, motion.q, motion.u, middle)
    direction = slip(toy, i, u).value.sign()
    if not direction:
        raise NotSeparated("the direction of slip is open")
    response = _response(motion, i, direction)
    states = [OPEN] * 3
    states[i] = UP if direction == 1 else DOWN
    after = (states[0], states[1], states[2])
    slide, stretch = toy.mode(after), response[2] - response[1]
    turn = I.of(free.b[ANGLE[i]] * SIDE[i] * stretch)
    sizes = (kappa, I.of(slide.kappa), turn)
    whole = Landing(eta.value, late, *sizes)
    _clear(motion, i, late, middle, response, direction, whole)
    curve = Landing(eta.parts[0].range, late, *sizes)
    if motion.box.depth > 3:
        raise NotSeparated("a return is once differentiable only where a contact lands at a pause")
    places = _term(eta, curve.place, whole.place_slope) * -fall
    speeds = _term(eta, curve.velocity, whole.velocity_slope) * -fall
    for j in range(3):
        b = I.of(stretch * slide.b[j])
        q[j] = q[j] - level * I.of(response[j]) + places * b
        u[j] = u[j] + speeds * b
    return Sliding(q, u, after, level, middle, whole.last)


def _flown(mode: Coasting, q: Sequence[Any], u: Sequence[Any], t: I) -> tuple[Any, Any]:
    """Coordinates and velocities after free flight, forms or intervals."""
    s = wave(I.of(mode.kappa), t)
    d0, d1, alpha = q[2] - q[1], u[2] - u[1], I.of(mode.alpha)
    once, twice = d0 * s[1] + d1 * s[2], d0 * s[2] + d1 * s[3]
    half = t.power(2) * I.of(Fraction(1, 2))
    places, speeds = [], []
    for j in range(3):
        a, b = I.of(mode.a[j]), I.of(mode.b[j])
        places.append(q[j] + u[j] * t + twice * b + (a * half + alpha * s[4] * b))
        speeds.append(u[j] + once * b + (a * t + alpha * s[3] * b))
    return places, speeds


def _response(motion: Flight, i: int, direction: int) -> list[Fraction]:
    """What an impulse of the slipping contact does to the velocities, per speed of the gap."""
    toy = motion.toy
    friction = -direction * toy.mu[i]
    kick = [x + friction * y for x, y in zip(toy.kick[2 * i], toy.kick[2 * i + 1], strict=True)]
    speed = kick[ANGLE[i]] * SIDE[i]
    if speed <= 0:
        raise NotSeparated("a contact may neither stay nor leave")
    return [x / speed for x in kick]


def _term(eta: F, value: I, slope: I) -> F:
    """A function of eta from its range on the curve and that of its derivative."""
    zero = T(eta.box, [0])
    return chain(eta, zero.plus(value), zero.plus(slope), lambda: zero)


def _clear(
    motion: Flight, i: int, late: bool, middle: I, response: Sequence[Fraction],
    direction: int, landing: Landing,
) -> None:  # fmt: skip
    """No other guard fires until the contact has come to stay, and it slips all the time."""
    toy, j = motion.toy, ANGLE[i]
    free, end = toy.mode((OPEN, OPEN, OPEN)), middle + landing.sigma if late else middle
    if not all(guard.lasts(end.high, None) for guard in motion.others):
        raise NotSeparated("something may happen before a contact lands")
    strikes = middle + landing.sigma if late else middle - landing.sigma
    q, u = _flown(free, [x.value for x in motion.q], [x.value for x in motion.u], strikes)

    def stopped(u: Sequence[I]) -> list[I]:
        return [v - u[j] * I.of(r * SIDE[i]) for v, r in zip(u, response, strict=True)]

    moments = [u, stopped(u)]
    if not late:
        flight = I.of(0).hull(landing.flight)
        q, u = _flown(free, q, stopped(u), flight)
        moments += [u, stopped(u)]
        for k in range(3):
            gap = (q[ANGLE[k]] - I.of(toy.touch[k])) * I.of(SIDE[k])
            if k != i and gap.sign() != 1:
                raise NotSeparated("something may happen while a contact lands")
    none = constant(motion.box, I.of(0))
    for velocities in moments:
        along = slip(toy, i, velocities)
        if along.sign() != direction:
            raise NotSeparated("the direction of slip is open")
        strike = [velocities[j] * I.of(SIDE[i] * toy.lever[i]), along]
        before = [constant(motion.box, x) for x in strike]
        solution = solve_impact(toy, [i], before, [none], False, True)
        if not solution.rests[0] or solution.slips[0] != direction:
            raise NotSeparated("an impact is not decided")
