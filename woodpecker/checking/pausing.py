"""Verification of a landing near a pause of a gap: from the free flight to sliding."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from woodpecker.checking.forms import F, chain, constant, over
from woodpecker.checking.guards import Guard, GuardValue
from woodpecker.checking.impacts import slip, solve_impact
from woodpecker.checking.intervals import I, NotSeparated, T
from woodpecker.checking.plateaus import Landing
from woodpecker.checking.toy import ANGLE, DOWN, OPEN, SIDE, UP, ExactToy
from woodpecker.checking.tracker import Choice, Tracker, flown


def plateau(way: Tracker, guard: Guard, bracket: I) -> None:
    """A contact that lands near a pause of its motion slides from the middle of the pause."""
    kind, i = guard
    late = kind == "plateau+"
    if way.states != (OPEN, OPEN, OPEN) or not way.let_go(i, way.states):
        raise NotSeparated("a gap has a pause only where the sleeve has just let go")
    if way.restitution(i).sign() != 0:
        raise NotSeparated("only a contact without restitution lands at a plateau")
    level = _slides(way, i, late, bracket)
    way.close(i)
    if level.value.sign() is None:
        comparator = level if late else -level
        way.forks.append(Choice("plateau", (i,), comparator, way.events, not late))
    strike = f"I{i + 1}"
    way.word += [strike] if late else [strike, f"D{i + 1}", strike]
    way.fired, way.before = ("impact", -1), way.states
    way.zeros, way.still, way.lands = [2 if k == i else 0 for k in range(3)], set(), -1
    way.at_least_zero = {("normal", i)}
    way.events += 1


def _slides(way: Tracker, i: int, late: bool, bracket: I) -> F:
    """Move to the middle of the pause, in the bracket, from which contact i slides."""
    # Returns the gap there without a landing, which is late where that is positive, else early.
    toy, free, curves = way.toy, way.toy.mode((OPEN, OPEN, OPEN)), way.curves()
    jet = curves.pop(("gap", i)).jet
    start, fall, kappa = jet[0], jet[3], I.of(free.kappa)
    assert isinstance(start, F)
    if not isinstance(fall, F) or fall.value.sign() != -1 or kappa.sign() != -1:
        raise NotSeparated("a gap does not fall to a pause")
    swing = I.pi() * I.of(2) / (-kappa).sqrt()
    n = round(float(bracket.mid) / float(swing))
    if n < 1:
        raise NotSeparated("a gap has no pause where it begins to close")
    middle = swing * I.of(n)
    level = start - fall * (middle / kappa)  # s_3 = -t / kappa, where s_1 = s_2 = 0
    eta = -(level * over(fall))
    if eta.value.sign() == (-1 if late else 1):
        raise NotSeparated("a contact lands on the other side of a pause")
    q, u = flown(free, way.q, way.u, middle)
    direction = slip(toy, i, u).value.sign()
    if not direction:
        raise NotSeparated("the direction of slip is open")
    response = _response(toy, i, direction)
    slides = UP if direction == 1 else DOWN
    after = tuple(slides if k == i else OPEN for k in range(3))
    slide, stretch = toy.mode(after), response[2] - response[1]
    sizes = kappa, I.of(slide.kappa), I.of(free.b[ANGLE[i]] * SIDE[i] * stretch)
    whole, curve = (Landing(x, late, *sizes) for x in (eta.value, eta.parts[0].range))
    _clear(way, i, late, middle, response, direction, whole, tuple(curves.values()))
    if way.box.depth > 3:
        raise NotSeparated("a return is once differentiable only where a contact lands at a pause")
    places = _term(eta, curve.place, whole.place_slope) * -fall
    speeds = _term(eta, curve.velocity, whole.velocity_slope) * -fall
    for j in range(3):
        b = I.of(stretch * slide.b[j])
        q[j] = q[j] - level * I.of(response[j]) + places * b
        u[j] = u[j] + speeds * b
    way.q, way.u, way.states = q, u, after
    way.time, way.since = way.time + middle, whole.last
    return level


def _response(toy: ExactToy, i: int, direction: int) -> list[Fraction]:
    """Changes of the velocities by an impulse of the slipping contact, per speed of the gap."""
    friction = -direction * toy.mu[i]
    kick = [x + friction * y for x, y in zip(toy.kick[2 * i], toy.kick[2 * i + 1], strict=True)]
    speed = kick[ANGLE[i]] * SIDE[i]
    if speed <= 0:
        raise NotSeparated("a contact may neither stay nor leave")
    return [x / speed for x in kick]


def _term(eta: F, value: I, slope: I) -> F:
    """A function of eta, from ranges of it on the curve and of its derivative."""
    zero = T(eta.box, [0])
    return chain(eta, zero.plus(value), zero.plus(slope), lambda: zero)


def _clear(
    way: Tracker, i: int, late: bool, middle: I, response: Sequence[Fraction], direction: int,
    landing: Landing, others: Sequence[GuardValue],
) -> None:  # fmt: skip
    """NotSeparated unless the contact slips until it has landed for good, and no guard fires."""
    toy, j = way.toy, ANGLE[i]
    free, end = toy.mode((OPEN, OPEN, OPEN)), middle + landing.sigma if late else middle
    if not all(guard.lasts(end.high, None) for guard in others):
        raise NotSeparated("something may happen before a contact lands")
    strikes = middle + landing.sigma if late else middle - landing.sigma
    q, u = flown(free, [x.value for x in way.q], [x.value for x in way.u], strikes)

    def stopped(u: Sequence[I]) -> list[I]:
        return [v - u[j] * I.of(r * SIDE[i]) for v, r in zip(u, response, strict=True)]

    moments = [u, stopped(u)]
    if not late:
        flight = I.of(0).hull(landing.flight)
        q, u = flown(free, q, stopped(u), flight)
        moments += [u, stopped(u)]
        for k in range(3):
            gap = (q[ANGLE[k]] - I.of(toy.touch[k])) * I.of(SIDE[k])
            if k != i and gap.sign() != 1:
                raise NotSeparated("something may happen while a contact lands")
    for velocities in moments:
        along = slip(toy, i, velocities)
        if along.sign() != direction:
            raise NotSeparated("the direction of slip is open")
        strike = [velocities[j] * I.of(SIDE[i] * toy.lever[i]), along]
        before = [constant(way.box, x) for x in strike]
        solution = solve_impact(toy, [i], before, [way.zero], False, True)
        if not solution.rests[0] or solution.slips[0] != direction:
            raise NotSeparated("an impact is not decided")
