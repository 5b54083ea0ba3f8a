"""Landings at a plateau, as one event in its middle: a gap closes where its motion pauses.

When one contact of the sleeve lets go, the gap g of the other one has g' = g'' = 0 exactly. It
falls along g = g_0 + g_3 s_3(t), and pauses at t* = 2 pi n / omega, where g' and g'' vanish again.
With tau = t - t* and eta = -g(t*) / g_3, g = -g_3 (eta - s_3(tau)). Near eta = 0 the time of the
landing, s_3(tau) = eta, is like a cube root. If eta > 0 it lands late and stays, as its force is
positive; if eta < 0 it strikes early, at tau = -sigma, leaves, and lands again for good. In both
cases the later motion is smooth but for small terms, which this module encloses.

Let n be the gap's direction and r that of the slipping contact's impulse, n r = 1. The state
without its gap, y = q - r g and y' = q' - r g', is the same before and after impacts and detachment
of this contact, and obeys the equations of sliding with the stretch d_y + d_r g, whatever the gap
does (d_r: the stretch along r). So sliding starts at t* from y(t*) of the undisturbed fall plus

    -g_3 d_r b V(eta) in the velocities,    -g_3 d_r b A(eta) in the coordinates,

    V = integral of S_0(tau) f,    A = -(integral of S_1(tau) f),    f = g / -g_3 >= 0 the true gap,

with b and S of sliding, from t* on if it lands late, and before t* with the opposite sign. V and A
are of order sigma^4 and sigma^5, their derivatives in eta of order sigma and sigma^2: the return is
once differentiable.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from flint import arb, arb_poly

from woodpecker.enclosures.balls import ZERO
from woodpecker.enclosures.contacts import impulses_of
from woodpecker.enclosures.forms import VALUE, Form, box, chained, sign
from woodpecker.enclosures.model import BallToy, State
from woodpecker.enclosures.motions import (
    NO_GUARD,
    OpenDecision,
    Way,
    direction_of_slip,
    flown,
    slip,
    touch,
)
from woodpecker.enclosures.not_proved import NotProved
from woodpecker.enclosures.oscillator import Guard, ZeroCrossing
from woodpecker.enclosures.stumpff import shape_balls, stumpff_balls
from woodpecker.enclosures.taylor import Taylor
from woodpecker.mechanics.cases import HOLD, REST
from woodpecker.mechanics.modes import ANGLE, NORMAL, OPEN, SIGN, SLIP_NEGATIVE, SLIP_POSITIVE
from woodpecker.motion.codes import DETACH, IMPACT

LARGEST = arb(0.1)  # bound of |kappa| sigma^2, so that all c_k are close to their values at zero
# Duration of the flight to the second landing over sigma: 3 as sigma -> 0.
FLIGHT_OVER_SIGMA = arb(3, 0.5)
NEAR = 0.02  # of a period: landings this close to the middle of a plateau are treated here
FREE: State = (OPEN, OPEN, OPEN)


# --- The small terms ------------------------------------------------------------------------------


class Landed(NamedTuple):
    """The small terms of a landing at a plateau, for a range of eta."""

    sigma: Any  # time between the first impact and the middle of the plateau
    flight: Any  # duration of the flight to the second landing; zero where the contact stays
    velocity: Any  # the term V
    place: Any  # the term A
    velocity_slope: Any  # their derivatives in eta
    place_slope: Any

    @property
    def last(self) -> Any:
        """Upper bound of the time from the middle of the plateau to the last landing."""
        return (self.flight + self.sigma * (1 if self.flight.is_zero() else -1)).upper()


def landed(eta: Any, late: bool, kappa: Any, sliding: Any, turn: Any) -> Landed:
    """The small terms of a late landing, eta = s_3(sigma) >= 0, or an early one, eta <= 0.

    ``kappa`` is that of free flight, ``sliding`` that of sliding at the contact; ``turn`` is d_r
    times the third derivative of g in free flight per stretch velocity.
    """
    sigma = _sigma(eta if late else -eta, kappa)
    whole = ZERO.union(sigma)
    c2_before = shape_balls(kappa * whole**2, 2)[2]
    s1, s2 = stumpff_balls(sliding, sigma, 2)[1:]
    if late:
        slide = shape_balls(sliding * whole**2, 2)
        velocity, place = slide[1] * c2_before * sigma**4 / 4, -slide[2] * c2_before * sigma**5 / 5
        return Landed(sigma, ZERO, velocity, place, s1, -s2)
    # In flight, at a time h = sigma z after the impact, f = sigma^3 z^2 (c_1 c_2(h) - c z c_3(h))
    # with c = s_0 - turn s_2, taken at sigma.
    c0, c1, c2 = shape_balls(kappa * sigma**2, 2)
    c = c0 - turn * sigma**2 * c2
    z, h = _again(kappa, sigma, c1, c)
    n2, n3 = shape_balls(kappa * ZERO.union(h) ** 2, 3)[2:]
    slide = shape_balls(sliding * ZERO.union(whole.union(h - sigma)) ** 2, 2)
    flown = {2: c1 * n2, 3: -c * n3}  # coefficients of powers of z: of f / sigma^3,
    # and of its slope in eta
    fallen = {2: c0 * n2 / c2, 3: (turn - kappa) * sigma**2 * c1 * n3 / c2}
    area = _integral(flown, z)
    velocity = slide[1] * c2_before / 4 + slide[0] * area
    place = slide[2] * c2_before / 5 - _integral(flown, z, slide[1], lever=True)
    velocity_slope = -s1 - sigma * _integral(fallen, z, slide[0])
    velocity_slope += sliding * sigma**3 * _integral(flown, z, slide[1], lever=True) / c2
    place_slope = -s2 - sigma**2 * slide[0] * area / c2
    place_slope += sigma**2 * _integral(fallen, z, slide[1], lever=True)
    return Landed(sigma, h, velocity * sigma**4, place * sigma**5, velocity_slope, place_slope)


def _sigma(eta: Any, kappa: Any) -> Any:
    """The solution of s_3(sigma) = eta; zero for negative eta."""
    high = _root(eta.upper() * 7).upper()
    if not abs(kappa) * high**2 < LARGEST:
        raise NotProved("a landing is too far from a plateau")
    c3 = shape_balls(kappa * ZERO.union(high) ** 2, 3)[3]
    low = _root(eta.lower() / c3.upper()).lower()
    most = _root(eta.upper() / c3.lower()).upper()
    if most > high:
        raise NotProved("a landing at a plateau has no enclosure")
    return low.union(most)


def _again(kappa: Any, sigma: Any, c1: Any, c: Any) -> tuple[Any, Any]:
    """The second landing, as z and h = sigma z: the only zero of the decreasing f / z^2."""
    # It is the last one: the contact approaches there, and is accelerated towards the pole.
    reach = ZERO.union(FLIGHT_OVER_SIGMA.upper())
    x = kappa * (sigma * reach) ** 2
    n = shape_balls(x, 5)
    turn_2, turn_3 = n[3] - 2 * n[4], n[4] - 3 * n[5]
    curl = kappa * sigma**2 * reach
    if not c1 * turn_2 * curl - c * (n[3] + turn_3 * x) < 0:
        raise NotProved("a contact may not land again")
    h = sigma * FLIGHT_OVER_SIGMA
    n = shape_balls(kappa * h**2, 3)
    z = c1 * n[2] / (c * n[3])
    if not FLIGHT_OVER_SIGMA.contains_interior(z):
        raise NotProved("a contact may not land again")
    approach, force = c1 * n[1] - c * z * n[2], c1 * n[0] - c * z * n[1]
    if not (approach < 0 and force < 0):
        raise NotProved("a contact may not land again for good")
    return z, sigma * z


def _root(x: Any) -> Any:
    """The cube root; zero where x may not be positive."""
    return x.root(3) if x > 0 else ZERO


def _integral(powers: dict[int, Any], z: Any, factor: Any = 1, lever: bool = False) -> Any:
    """Integral over [0, z] of a sum of powers times ``factor``, and z - 1 with ``lever``."""
    # Each power is integrated alone, since coefficients and factor may vary within their balls.
    total = ZERO
    for n, c in powers.items():
        if lever:
            total += factor * c * (z ** (n + 2) / (n + 2)) - factor * c * (z ** (n + 1) / (n + 1))
        else:
            total += factor * c * (z ** (n + 1) / (n + 1))
    return total


def effect(eta: Form, on_curve: Any, slope: Any) -> Form:
    """A small term as a form, from its range on the curve and its slope in the whole box."""
    frame = eta.parts[VALUE].frame
    if len(eta.parts) > 3:
        raise NotProved("a return is once differentiable only where a contact lands at a plateau")

    def wide(ball: Any) -> Taylor:
        return Taylor(frame, arb_poly([ball.mid()]), ball - ball.mid())

    return chained(eta, wide(on_curve), wide(slope), lambda: wide(ZERO))


# --- The event ------------------------------------------------------------------------------------


class _Pause(NamedTuple):
    """A plateau of a gap; its contact slides from the middle on."""

    contact: int  # the one whose gap it is
    middle: Any  # time from the start of the phase to the middle of the plateau
    fall: Form  # third derivative of the gap there, negative
    level: Form  # the gap there, if the contact had not landed
    eta: Form  # -level / fall, positive for a late landing
    direction: int  # of slip, 1 or -1
    response: Sequence[Any]  # r: velocities due to an impulse that changes the gap's speed by one
    after: Way  # the start of sliding there, without the small terms


def land_at_plateau(
    model: BallToy, motion: Way, first: Guard, others: Sequence[Guard], guess: float
) -> list[Way]:  # fmt: skip
    """The one or two motions after a landing near a plateau; none if there is no plateau.

    ``first`` is the gap, with f' = f'' = 0 at the start of the phase; it closes near ``guess``.
    NotProved if another guard may fire before.
    """
    i = first.code
    pause = _pause(model, motion, first, guess)
    if pause is None:
        return []
    stretch = pause.response[2] - pause.response[1]
    free, sliding = model.mode(FREE), model.mode(pause.after.states)
    turn = free.b[ANGLE[i]] * int(SIGN[i]) * stretch
    numbers = free.kappa, sliding.kappa, turn
    decided, found = sign(pause.eta), []
    for side in (1, -1) if decided is None else (decided or 1,):
        near = landed(pause.eta.box, side == 1, *numbers)
        on_curve = landed(pause.eta.parts[VALUE].box, side == 1, *numbers)
        _clear(model, motion, pause, near, side, others)
        way = pause.after.copy()
        small = (on_curve.place, near.place_slope), (on_curve.velocity, near.velocity_slope)
        for place, effects in zip((way.q, way.u), small, strict=True):
            term = effect(pause.eta, *effects) * -pause.fall
            for k in range(3):
                if k != ANGLE[i]:
                    place[k] = place[k] + term * (stretch * sliding.b[k])
        way.since = near.last
        span = pause.middle + (ZERO.union(near.sigma * side)).union(near.last)
        way.log.append(ZeroCrossing(first.code, first.jet[0] * ZERO + pause.middle, span, side))
        struck = 8 * IMPACT + (1 << i)  # it slides on
        way.codes += [struck] if side == 1 else [struck, 8 * DETACH + (1 << i), struck]
        if decided is None:
            way.forks.append(OpenDecision(pause.level, side))
        found.append(way)
    return found


def _pause(model: BallToy, motion: Way, first: Guard, guess: float) -> _Pause | None:
    f0, _, _, f3 = first.jet
    if not first.kappa < 0 or sign(f3) != -1:
        return None
    swing = 2 * arb.pi() / (-first.kappa).sqrt()
    turns, i = guess / float(swing), first.code
    n = round(turns)
    if n < 1 or abs(turns - n) > NEAR:
        return None
    if motion.states != FREE or sign(model.eps[i]) != 0:
        return None
    middle = swing * n
    fallen = -middle / first.kappa  # s_3
    q, u = flown(model.mode(FREE), motion.q, motion.u, middle)
    direction = direction_of_slip(model, i, u)
    friction = model.mu[i] * -direction
    impulse = [
        n + friction * t
        for n, t in zip(model.responses[2 * i], model.responses[2 * i + 1], strict=True)
    ]
    speed = impulse[ANGLE[i]] * int(SIGN[i])
    if not speed > 0:
        raise NotProved("a contact may be neither left nor held")
    response = [x / speed for x in impulse]
    level, eta = f0 + f3 * fallen, -(f0 / f3) - fallen
    after = motion.copy()
    after.q, after.u = [x - r * level for x, r in zip(q, response, strict=True)], u
    touch(model, after, i)
    after.u[ANGLE[i]] = ZERO
    after.time = motion.time + middle
    after.orders = [2 if k == i else 0 for k in range(3)]
    after.held, after.fired = frozenset(), NO_GUARD
    slides = SLIP_POSITIVE if direction == 1 else SLIP_NEGATIVE
    after.states = after.before = tuple(slides if k == i else OPEN for k in range(3))
    after.assumed, after.lands = frozenset({NORMAL + i}), NO_GUARD
    return _Pause(i, middle, f3, level, eta, direction, response, after)


def _clear(
    model: BallToy, motion: Way, pause: _Pause, landing: Landed, side: int,
    others: Sequence[Guard],
) -> None:  # fmt: skip
    """NotProved unless the contact slips through all impacts, and no other guard fires."""
    i = pause.contact
    j, free = ANGLE[i], model.mode(FREE)
    until = (pause.middle + landing.sigma.max(ZERO) * (side == 1)).upper()
    if any(guard.code >= NORMAL or not guard.lasts(until) for guard in others):
        raise NotProved("something may happen before a contact lands at a plateau")
    start_q, start_u = [box(x) for x in motion.q], [box(x) for x in motion.u]
    strikes = pause.middle + landing.sigma * side
    q, u = flown(free, start_q, start_u, strikes)
    seen = [u]
    if side == -1:
        thrown = _stopped(pause, u)
        q, u = flown(free, q, thrown, ZERO.union(landing.flight))
        seen += [thrown, u]
        for guard in others:
            k = guard.code
            if not (q[ANGLE[k]] - model.limits[k]) * int(SIGN[k]) > 0:
                raise NotProved("something may happen while a contact lands at a plateau")
    seen += [_stopped(pause, u)]
    for velocities in seen:
        if direction_of_slip(model, i, velocities) != pause.direction:
            raise NotProved(f"contact {i + 1} may slip or not")
        speed = velocities[j] * (model.levers[i] * int(SIGN[i]))
        approach = [speed, slip(model, i, velocities)]
        case = impulses_of(model, [i], approach, None, True).cases[0]
        if case // 3 != REST or case % 3 == HOLD:
            raise NotProved("an impact is not decided")


def _stopped(pause: _Pause, u: Sequence[Any]) -> list[Any]:
    """Velocities after an impact with slip that stops the gap."""
    j, response = ANGLE[pause.contact], pause.response
    return [v - r * (u[j] / response[j]) for v, r in zip(u, response, strict=True)]
