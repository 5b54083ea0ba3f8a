"""A gap that closes near a plateau of its motion: both landings as one event in its middle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from flint import arb

from woodpecker.enclosures.balls import ZERO
from woodpecker.enclosures.contacts import impulses_of
from woodpecker.enclosures.forms import VALUE, Form, box, sign
from woodpecker.enclosures.model import BallToy, State
from woodpecker.enclosures.motions import (
    NO_GUARD,
    ForkKind,
    OpenDecision,
    Way,
    direction_of_slip,
    flown,
    slip,
    touch,
)
from woodpecker.enclosures.not_proved import NotProved
from woodpecker.enclosures.oscillator import Guard, ZeroCrossing
from woodpecker.enclosures.plateaus import Landed, effect, landed
from woodpecker.mechanics.cases import HOLD, REST
from woodpecker.mechanics.modes import ANGLE, NORMAL, OPEN, SIGN, SLIP_NEGATIVE, SLIP_POSITIVE
from woodpecker.motion.codes import DETACH, IMPACT

NEAR = 0.02  # of a swing: landings as near to the middle of a plateau are taken as one with it
FREE: State = (OPEN, OPEN, OPEN)


class _Pause(NamedTuple):
    """A plateau of a gap, from the middle of which its contact slides."""

    contact: int  # whose gap
    middle: Any  # time from the start of the phase to the middle of the plateau
    fall: Form  # third derivative of the gap there, negative
    level: Form  # its value there
    eta: Form  # the level over the fall's size, positive for a late landing
    q: Sequence[Any]  # coordinates there without a landing
    u: Sequence[Any]  # and velocities
    direction: int  # of slip, 1 or -1
    response: Sequence[Any]  # of velocities to an impulse that changes the gap's speed by one

    @property
    def states(self) -> State:
        """Contact states while it slides."""
        slides = SLIP_POSITIVE if self.direction == 1 else SLIP_NEGATIVE
        first, second, third = (slides if k == self.contact else OPEN for k in range(3))
        return first, second, third


def paused(
    model: BallToy, motion: Way, first: Guard, others: Sequence[Guard], guess: float
) -> list[Way]:  # fmt: skip
    """The motions after a landing near a plateau, one or two; none if there is no plateau.

    ``first`` is the gap, with f' = f'' = 0 where the phase began; it closes near ``guess``.
    NotProved if another guard may fire before.
    """
    i = first.code
    pause = _pause(model, motion, first, guess)
    if pause is None:
        return []
    after = _reduced(model, motion, pause)
    stretch = pause.response[2] - pause.response[1]
    free, sliding = model.mode(FREE), model.mode(pause.states)
    turn = free.b[ANGLE[i]] * int(SIGN[i]) * stretch
    numbers = free.kappa, sliding.kappa, turn
    decided, found = sign(pause.eta), []
    for side in (1, -1):
        if decided is not None and side != (decided or 1):
            continue
        near = landed(pause.eta.box, side == 1, *numbers)
        on_curve = landed(pause.eta.parts[VALUE].box, side == 1, *numbers)
        _clear(model, motion, pause, near, side, others)
        way = after.copy()
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
            way.forks.append(OpenDecision(ForkKind.PLATEAU, pause.level, side))
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
    return _Pause(i, middle, f3, level, eta, q, u, direction, response)


def _reduced(model: BallToy, motion: Way, pause: _Pause) -> Way:
    """Sliding from the middle of the plateau, without the small terms."""
    after, i = motion.copy(), pause.contact
    after.q = [x - r * pause.level for x, r in zip(pause.q, pause.response, strict=True)]
    after.u = [*pause.u]
    touch(model, after, i)
    after.u[ANGLE[i]] = ZERO
    after.time = motion.time + pause.middle
    after.orders = [2 if k == i else 0 for k in range(3)]
    after.held, after.fired = frozenset(), NO_GUARD
    after.states = after.before = pause.states
    after.assumed, after.lands = frozenset({NORMAL + i}), NO_GUARD
    return after


def _clear(
    model: BallToy, motion: Way, pause: _Pause, landing: Landed, side: int,
    others: Sequence[Guard],
) -> None:  # fmt: skip
    """NotProved unless the contact slides through all impacts, and nothing else happens."""
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
    """Velocities after an impact that stops the gap."""
    j, response = ANGLE[pause.contact], pause.response
    return [v - r * (u[j] / response[j]) for v, r in zip(u, response, strict=True)]
