"""Accumulating impacts: a geometric series at one contact; two in turns end at rounding."""

from __future__ import annotations

import math

from woodpecker.base.arrays import Codes, Floats, Ints
from woodpecker.base.compiled import part
from woodpecker.mechanics.contact_problems import SOLVED
from woodpecker.mechanics.impacts import hold, rates
from woodpecker.mechanics.modes import (
    ANGLE,
    GAP,
    OMEGA,
    OPEN,
    SIGN,
    SLIP_POSITIVE,
    STICK,
    B,
    mode_of,
)
from woodpecker.motion.arriving import held, sign_of
from woodpecker.motion.codes import (
    CHATTER,
    CHATTER_END,
    CLOSED,
    EVENT_COLUMNS,
    PAIR_ENDED,
    STUCK,
    UNNAMED,
    Room,
    typed,
)
from woodpecker.motion.events import jet, next_event
from woodpecker.motion.flow import shut
from woodpecker.motion.guards import EPSILON
from woodpecker.motion.recording import append, append_transitions, record_events
from woodpecker.motion.settling import settle


@part
def check_accumulation(
    model: Floats, i: int, symbols: int, to_section: bool, word: Codes, counts: Ints,
    events: Floats, room: Room,
) -> int:  # fmt: skip
    """After an impact at contact i: sum its bounces if they accumulate, else remember this one."""
    z, gaps, states, bounce, mark = room.z, room.gaps, room.states, room.bounce, room.mark
    pair = _pair_at_rest(model, z, gaps, states, i, symbols, bounce)
    if pair != 0:
        counts[0] = bounce[2]
        bounce[0] = bounce[2] = -1
        return _close(model, pair, word, counts, events, room)
    if counts[0] != symbols + 1 or states[i] != OPEN:
        bounce[0] = -1
        return SOLVED
    speed = SIGN[i] * z[3 + ANGLE[i]]
    ratio = speed / mark[7] if mark[7] > 0.0 else 1.0
    again = bounce[0] == i and bounce[1] == symbols and 0.0 <= ratio < 1.0
    if again and _chatters(model, z, gaps, states, to_section, i, mark[7], z[6] - mark[6], ratio):
        bounce[0] = -1
        return _close_chatter(model, ratio, i, word, counts, events, room)
    bounce[0], bounce[1], mark[7] = i, counts[0], speed
    for k in range(7):
        mark[k] = z[k]
    return SOLVED


@part
def _chatters(
    model: Floats, z: Floats, gaps: Floats, states: Ints, to_section: bool, i: int, speed: float,
    lap: float, ratio: float,
) -> bool:  # fmt: skip
    """Whether the bounces at contact i are so short that the rest is a geometric series."""
    # A flight of duration -2 g'/g'' must be short against the swing and against the change of g'',
    # and no other event may fall into twice the time that is summed.
    mode = mode_of(states)
    _, _, f2, f3 = jet(model, mode, GAP + i, z, gaps, states)
    if f2 >= 0.0:
        return False
    flight = -2.0 * speed / f2
    if flight * (model[mode, OMEGA] - f3 / f2) > CHATTER:
        return False
    if flight * abs(f3 / f2) > CHATTER:
        return False
    if lap > 2.0 * flight + 4.0 * EPSILON * z[6]:
        return False  # since the previous impact there was more than one bounce
    tail = lap * ratio / (1.0 - ratio)
    horizon = 2.0 * tail
    return next_event(model, mode, z, gaps, states, to_section, horizon, GAP + i, GAP + i)[1] < 0


@part
def _pair_at_rest(
    model: Floats, z: Floats, gaps: Floats, states: Ints, i: int, symbols: int, bounce: Ints
) -> int:
    """Bit mask of the beak and a contact of the sleeve if their impacts have ended, else 0."""
    # Impacts can accumulate at two contacts in turns, in no fixed order: no series sums them, but
    # the rest soon falls below rounding, and the word does not name it.
    sleeve = i if i > 0 else (1 if gaps[1] < gaps[2] else 2)
    swing = _remaining_swing(model, z, gaps, sleeve)
    if swing > UNNAMED:
        bounce[2] = -1
        return 0
    if states[0] != OPEN or states[sleeve] != OPEN:
        return 0  # one of them rests: the bounces of the other are a series
    if bounce[2] < 0:
        bounce[2] = symbols
    return 1 + (1 << sleeve) if swing <= PAIR_ENDED else 0


@part
def _remaining_swing(model: Floats, z: Floats, gaps: Floats, sleeve: int) -> float:
    """Remaining time of bounces of the beak and a contact of the sleeve [rad of a free swing]."""
    # Bounces last about sqrt(v^2 + 2 a g) / a, with gap g, its rate v, and acceleration a = |B d|.
    d, fastest, pull = z[2] - z[1], 0.0, 0.0
    for i in (0, sleeve):
        pull = max(pull, abs(model[0, B + ANGLE[i]] * d))
    for i in (0, sleeve):
        speed = z[3 + ANGLE[i]]
        fastest = max(fastest, speed * speed + 2.0 * pull * max(0.0, gaps[i]))
    if fastest == 0.0 or pull == 0.0:
        return 1.0
    return float(model[0, OMEGA] * math.sqrt(fastest) / pull)


@part
def _close_chatter(
    model: Floats, ratio: float, i: int, word: Codes, counts: Ints, events: Floats, room: Room
) -> int:
    """Sum the accumulating impacts at contact i and close it; one symbol stands for all."""
    sum_bounces(room.z, room.gaps, room.mark, ratio)
    last = word[counts[0] - 1]
    while counts[0] > 0 and word[counts[0] - 1] == last:
        counts[0] -= 1
    return _close(model, 1 << i, word, counts, events, room)


@part
def sum_bounces(z: Floats, gaps: Floats, mark: Floats, ratio: float) -> None:
    """Move z to the end of its bounces, z + (z - mark) r / (1 - r), ``mark`` one bounce before."""
    rest = ratio / (1.0 - ratio)
    for k in range(3):
        gaps[k] += SIGN[k] * (z[ANGLE[k]] - mark[ANGLE[k]]) * rest
    for k in range(7):
        z[k] += (z[k] - mark[k]) * rest


@part
def _close(model: Floats, mask: int, word: Codes, counts: Ints, events: Floats, room: Room) -> int:
    """Close the contacts of a mask, at which impacts have accumulated, and decide the mode."""
    # A tangential velocity that each of the impacts has stopped is zero in the limit.
    z, gaps, states, slips = room.z, room.gaps, room.states, room.slips
    closed, before = room.closed, room.before
    for k in range(3):
        before[k] = states[k]
        closed[k] = 1 if states[k] != OPEN or mask >> k & 1 else 0
    for k in range(3):
        if mask >> k & 1:
            before[k] = SLIP_POSITIVE
    shut(model, mask, z, gaps)
    for k in range(3):
        if not closed[k] or states[k] == STICK:
            continue
        slips[k] = 0 if room.stopped[k] else sign_of(rates(model, k, z)[1])
        if room.stopped[k]:
            hold(model, k, z)
    status = settle(model, z, gaps, closed, slips, typed(-1), states, room.trial)
    room.decided[CLOSED], room.decided[STUCK] = mask, held(closed, slips)
    symbols = counts[0]
    append(word, counts, 8 * CHATTER_END + mask)
    for k in range(3):  # the symbol says already that they close
        before[k] = states[k] if mask >> k & 1 and states[k] > STICK else before[k]
    append_transitions(before, states, typed(-1), word, counts)
    if len(events) > 0:
        event = room.event
        for k in range(EVENT_COLUMNS):
            event[k] = z[1 + k] if 2 <= k < 5 else (z[k - 2] if 5 <= k < 8 else 0.0)
        record_events(events, counts, symbols, z[6], word, event)
    return status
