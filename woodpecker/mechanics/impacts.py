"""Impacts with friction at one or two contacts: their index combinations and velocities.

Two sticking contacts have four impulses for three equations: a compression that ends with the whole
toy at rest leaves the normal impulses on a segment, and they enter the expansion. Such an impact is
indeterminate and continues from the middle of the segment, which prefers no contact.

Energy. No impact adds energy at one contact, with equal restitutions of its contacts, or without
friction, for any mu and law of expansion. With unequal restitutions the paper's summed law still
adds none (proved for equal mu up to 0.432, not seen up to mu = 8). Contact by contact, an impact of
beak and upper edge can add energy: in searches above eps_N1 = 0.99 at mu = 0.3, above about 0.92
for mu up to 0.6. A body close to jamming can gain energy under both laws (proof and examples:
``tests/woodpecker/mechanics/test_impact_energy.py``).
"""

from __future__ import annotations

from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.compiled import part
from woodpecker.mechanics.cases import FREE, HOLD, REST
from woodpecker.mechanics.contact_problems import (
    AMBIGUOUS,
    INDETERMINATE,
    NO_SOLUTION,
    SOLVED,
    UNSOLVED,
    Pair,
    one_contact,
    two_contacts,
    velocity_of,
)
from woodpecker.mechanics.modes import (
    ANGLE,
    CONTACT,
    DELASSUS,
    EPS,
    EXPANSION,
    FORCE,
    LEVER,
    MU,
    PAIR,
    RESPONSE_N,
    RESPONSE_T,
    SIGN,
    SUMMED,
    TANGENT,
    fill_pair,
)

# A mark distinguishes index combinations of one contact: compression + 3 * expansion, where
# compression is 0 slides, 1 sticks, 2 separates; expansion is 0 slides or is missing, and ends as
# usual (leaves if it stores impulse, stays if not), 1 sticks and ends as usual, 2 and 3 likewise
# with the other end.
MARKS = 12


@part
def mark(first: int, second: int, expands: bool, floor: float) -> int:
    """The mark of a compression and an expansion at one contact, a number below MARKS."""
    compression = 2 if first // 3 == FREE else (1 if first % 3 == HOLD else 0)
    if not expands:
        return compression
    usual = FREE if floor > 0.0 else REST
    expansion = (0 if second // 3 == usual else 2) + (1 if second % 3 == HOLD else 0)
    return compression + 3 * expansion


@part
def halts(mark: int) -> bool:
    """Whether a contact with this mark sticks at the end of the compression or of the expansion."""
    return mark % 3 == 1 or mark // 3 % 2 == 1


@part
def decide(
    model: Floats, contacts: Ints, z: Floats, choice: Ints, marks: Ints, impulses: Floats,
    pair: Pair,
) -> int:  # fmt: skip
    """Find the index combinations of an impact at one or two contacts (0-based, ascending).

    Output: ``choice`` (3,), combinations c_1 + 6 c_2 of the compression, twice (both ends of its
    segment if it is indeterminate), and of the expansion, or UNSOLVED if there is none; ``marks``
    (2,) of the contacts: for equal marks the impact is smooth in the state; ``impulses`` (2, 4) of
    both phases; gap rates afterwards in ``pair.after``.
    """
    prepare(model, contacts, z, pair)
    n, floor, feeds, middle, impulse = len(contacts), pair.floor, pair.feeds, pair.middle, pair.end
    first, second = pair.first, pair.second
    for k in range(4):
        impulses[0, k] = impulses[1, k] = 0.0
    for k in range(n):
        feeds[k] = 1 if pair.eps[k] > 0.0 else 0
    outcome = _solve(model, contacts, False, pair.free, first, impulse, pair)
    if outcome in (NO_SOLUTION, AMBIGUOUS):
        return outcome
    choice[0], choice[1] = first[0, 0] + 6 * first[0, 1], first[1, 0] + 6 * first[1, 1]
    choice[2] = UNSOLVED
    _velocities(n, choice[0], pair.delassus, pair.free, impulse, middle)
    expands, last = False, choice[0]
    for k in range(n):
        impulses[0, 2 * k], impulses[0, 2 * k + 1] = impulse[2 * k], impulse[2 * k + 1]
        floor[k] = pair.eps[k] * impulse[2 * k]
        expands = expands or floor[k] > 0.0
        second[0, k] = first[0, k]
        feeds[k] = 0
    if expands:  # otherwise the compression was all
        status = _solve(model, contacts, True, middle, second, impulse, pair)
        if status != SOLVED:
            return status
        last = choice[2] = second[0, 0] + 6 * second[0, 1]
        for k in range(2 * n):
            impulses[1, k] = impulse[k]
    _velocities(n, last, pair.delassus, middle, impulses[1], pair.after)
    for k in range(n):
        marks[k] = mark(first[0, k], second[0, k], expands, floor[k])
        if outcome == INDETERMINATE:  # tells the two ends of the segment apart
            marks[k] = first[k, 0] % 3 + 3 * (first[k, 1] % 3)
    return outcome


@part
def _solve(
    model: Floats, contacts: Ints, expands: bool, free: Floats, cases: Ints, impulse: Floats,
    pair: Pair,
) -> int:  # fmt: skip
    """Find the index combination of a phase; output as of ``two_contacts``."""
    g = pair.delassus
    if len(contacts) == 2:
        coupling = model[FORCE, SUMMED] if expands else 0.0
        return two_contacts(
            model, row_of_pair(contacts, expands), g, free, pair.mu, coupling, pair.floor,
            pair.feeds, cases, impulse, pair,
        )  # fmt: skip
    status, case, impulse[0], impulse[1] = one_contact(
        g[0, 0], g[0, 1], g[1, 1], free[0], free[1], pair.mu[0], pair.floor[0]
    )
    cases[0, 0] = cases[1, 0] = case
    cases[0, 1] = cases[1, 1] = 0
    return status


@part
def _velocities(
    n: int, index: int, delassus: Floats, free: Floats, impulse: Floats, velocity: Floats
) -> None:
    """Velocities after impulses at one or two contacts."""
    if n == 2:
        velocity_of(index, delassus, free, impulse, velocity)
        return
    for k in range(2):
        still = index % 3 == HOLD if k else index // 3 == REST
        after = free[k] + delassus[k, 0] * impulse[0] + delassus[k, 1] * impulse[1]
        velocity[k] = 0.0 if still else after


@part
def row_of_pair(contacts: Ints, expands: bool) -> int:
    """Row of the model from which on it has the index combinations of two contacts."""
    return int(PAIR + 36 * (contacts[1] - 1) + (EXPANSION if expands else 0))


@part
def carry_out(
    model: Floats, contacts: Ints, choice: Ints, z: Floats, case: Ints, impulses: Floats, pair: Pair
) -> None:
    """Change the velocities of z (7,) by the sum of impulses (phases, 4), with exact zeros.

    ``case`` (2,) becomes the last index combination of each contact.
    """
    # Gap rates are those of pair.after, without the rounding of kicks: a bounce can be slower than
    # the rounding of the velocity that it reverses.
    last = choice[2] if choice[2] != UNSOLVED else choice[0]
    case[0], case[1] = last % 6, last // 6
    for k in range(len(contacts)):
        p_n = p_t = 0.0
        for phase in range(len(impulses)):
            p_n, p_t = p_n + impulses[phase, 2 * k], p_t + impulses[phase, 2 * k + 1]
        kick(model, contacts[k], p_n, p_t, z)
    for k in range(len(contacts)):
        i = contacts[k]
        z[3 + ANGLE[i]] = SIGN[i] * pair.after[2 * k] / model[FORCE, LEVER + i]
    clear(model, contacts, case, z)


@part
def rates(model: Floats, i: int, z: Floats) -> tuple[float, float]:
    """Gap rate and tangential velocity [m/s] of contact i (0-based)."""
    w = CONTACT + i
    return (
        SIGN[i] * model[FORCE, LEVER + i] * z[3 + ANGLE[i]],
        model[w, TANGENT] * z[3] + model[w, TANGENT + 1] * z[4] + model[w, TANGENT + 2] * z[5],
    )


@part
def kick(model: Floats, i: int, p_n: float, p_t: float, z: Floats) -> None:
    """Change the velocities by the impulses (p_n, p_t) at contact i."""
    row = CONTACT + i
    for j in range(3):
        z[3 + j] += p_n * model[row, RESPONSE_N + j] + p_t * model[row, RESPONSE_T + j]


@part
def prepare(model: Floats, contacts: Ints, z: Floats, pair: Pair) -> None:
    """Write the data of an impact into its room."""
    n, g = len(contacts), pair.delassus
    if n == 2:
        fill_pair(model, contacts[1], pair.delassus, pair.friction, pair.system)
    for k in range(n):
        i = contacts[k]
        for j in range(n):
            row, column = DELASSUS + 2 * i, 2 * contacts[j]
            g[2 * k, 2 * j], g[2 * k, 2 * j + 1] = model[row, column], model[row, column + 1]
            row += 1
            g[2 * k + 1, 2 * j], g[2 * k + 1, 2 * j + 1] = (
                model[row, column],
                model[row, column + 1],
            )
        pair.mu[k], pair.eps[k] = model[CONTACT + i, MU], model[CONTACT + i, EPS]
        pair.free[2 * k], pair.free[2 * k + 1] = rates(model, i, z)
        pair.floor[k] = 0.0
    if n == 1:  # its two mixed entries differ by rounding, and closed forms take the first
        g[1, 0] = g[0, 1]


@part
def clear(model: Floats, contacts: Ints, case: Ints, z: Floats) -> None:
    """Set the velocities that an index combination makes zero exactly to zero."""
    for k in range(len(contacts)):
        if case[k] // 3 == REST:
            z[3 + ANGLE[contacts[k]]] = 0.0
    for k in range(len(contacts)):
        if case[k] % 3 == HOLD:
            hold(model, contacts[k], z)


@part
def clear_change(change: Floats, contacts: Ints, case: Ints, z: Floats, tangent: Floats) -> None:
    """Change of the sleeve's velocity with the direction of sticking, along a parameter."""
    # Of two sticking contacts the last one determines that velocity.
    for k in range(len(contacts) - 1, -1, -1):
        if case[k] % 3 == HOLD:
            tangent[3] -= rates(change, contacts[k], z)[1]
            return


@part
def hold(model: Floats, i: int, z: Floats) -> None:
    """Set the tangential velocity of contact i to zero, by the velocity of the sleeve."""
    row = CONTACT + i
    z[3] = -(model[row, TANGENT + 1] * z[4] + model[row, TANGENT + 2] * z[5])
