"""Impacts with friction at one or two contacts: their index combinations and velocities.

Two sticking contacts have four impulses for three equations: if compression brings the whole toy to
rest, its normal impulses, which the expansion needs, lie anywhere on a segment. Such an impact is
indeterminate and goes on from the middle of the segment, which prefers no contact.

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
from woodpecker.mechanics.cases import FORWARD, FREE, HOLD, REST, impulse_of
from woodpecker.mechanics.contact_problems import (
    AMBIGUOUS,
    INDETERMINATE,
    NO_SOLUTION,
    SOLVED,
    UNSOLVED,
    Pair,
    one_contact,
    one_contact_case,
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

# The mark of a contact tells its index combinations apart, as compression + 3 * expansion.
# Compression: 0 slides, 1 sticks, 2 separates. Expansion: 0 slides, or there is none; 1 sticks; and
# 2 more if the contact does not end as usual, which is to leave if it stores impulse, else to stay.
MARKS = 12


@part
def mark(first: int, second: int, expands: bool, stores: bool) -> int:
    """The mark of a compression and an expansion at one contact, a number below MARKS."""
    compression = 2 if first // 3 == FREE else (1 if first % 3 == HOLD else 0)
    if not expands:
        return compression
    usual = FREE if stores else REST
    expansion = (0 if second // 3 == usual else 2) + (1 if second % 3 == HOLD else 0)
    return compression + 3 * expansion


def letters_of(mark: int) -> str:
    """The letters of a mark in a word, see :mod:`woodpecker.simulation.words`."""
    return ("", "s", "f")[mark % 3] + ("", "-s", "-r", "-rs")[mark // 3]


@part
def sticks(mark: int) -> bool:
    """Whether a contact with this mark sticks at the end of the compression or of the expansion."""
    return mark % 3 == 1 or mark // 3 % 2 == 1


@part
def decide(
    model: Floats, contacts: Ints, z: Floats, choice: Ints, marks: Ints, impulses: Floats,
    pair: Pair,
) -> int:  # fmt: skip
    """Find the index combinations of an impact at one or two contacts (0-based, ascending).

    Output: ``choice`` (3,), the combination c_1 + 6 c_2 of the compression twice (both ends of its
    segment if it is indeterminate), and that of the expansion, UNSOLVED if there is none; ``marks``
    (2,) of the contacts: while they are the same the impact is smooth in the state; ``impulses``
    (2, 4) of both phases; gap rates afterwards in ``pair.after``.
    """
    for k in range(4):
        impulses[0, k] = impulses[1, k] = 0.0
    if len(contacts) == 1:
        return _decide_single(model, contacts[0], z, choice, marks, impulses, pair)
    return _decide_double(model, contacts, z, choice, marks, impulses, pair)


@part
def carry_out(
    model: Floats, contacts: Ints, choice: Ints, z: Floats, case: Ints, impulses: Floats, pair: Pair
) -> None:
    """Change the velocities of z (7,) by the impulses; those that vanish become exactly zero.

    ``case`` (2,) becomes the last index combination of each contact.
    """
    # Gap rates are taken from pair.after, free of the rounding of kicks: a bounce can be slower
    # than the rounding of the velocity that it reverses.
    last = choice[2] if choice[2] != UNSOLVED else choice[0]
    case[0], case[1] = last % 6, last // 6
    for k in range(len(contacts)):
        p_n = impulses[0, 2 * k] + impulses[1, 2 * k]
        p_t = impulses[0, 2 * k + 1] + impulses[1, 2 * k + 1]
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
def _decide_single(
    model: Floats, i: int, z: Floats, choice: Ints, marks: Ints, impulses: Floats, pair: Pair
) -> int:
    n, t = DELASSUS + 2 * i, 2 * i
    g_nn, g_nt, g_tt = model[n, t], model[n, t + 1], model[n + 1, t + 1]
    mu, eps = model[CONTACT + i, MU], model[CONTACT + i, EPS]
    free_n, free_t = rates(model, i, z)
    status, first, c_n, c_t = one_contact(g_nn, g_nt, g_tt, free_n, free_t, mu, 0.0)
    choice[0], choice[1], choice[2] = first, first, UNSOLVED
    if status != SOLVED:
        return status
    floor, second, e_n, e_t = eps * c_n, first, 0.0, 0.0
    v_n = 0.0 if first // 3 == REST else free_n
    if floor > 0.0:  # otherwise there is no expansion
        v_t = 0.0 if first % 3 == HOLD else free_t + g_nt * c_n + g_tt * c_t
        status, second, e_n, e_t = one_contact(g_nn, g_nt, g_tt, v_n, v_t, mu, floor)
        choice[2] = second
        if status != SOLVED:
            return status
    marks[0] = mark(first, second, floor > 0.0, floor > 0.0)
    impulses[0, 0], impulses[0, 1], impulses[1, 0], impulses[1, 1] = c_n, c_t, e_n, e_t
    pair.after[0] = v_n + g_nn * e_n + g_nt * e_t
    return SOLVED


@part
def one_change(
    model: Floats, change: Floats, moves: bool, i: int, case: int, p_n: float, p_t: float,
    free_n: float, free_t: float, floor: float,
) -> tuple[float, float, float, float]:  # fmt: skip
    """Derivatives of impulses and velocities (N, T) of one phase, from those of free and floor."""
    # Along a parameter the model ``moves``, with derivatives ``change``: with tau = -+dmu p_N for a
    # contact that slides, free moves by dG p + G_T tau as well.
    n, t = DELASSUS + 2 * i, 2 * i
    g_nn, g_nt, g_tt = model[n, t], model[n, t + 1], model[n + 1, t + 1]
    tau = 0.0
    if moves:
        if case % 3 != HOLD:
            dmu = change[CONTACT + i, MU]
            tau = -dmu * p_n if case % 3 == FORWARD else dmu * p_n
        free_n += change[n, t] * p_n + change[n, t + 1] * p_t + g_nt * tau
        free_t += change[n + 1, t] * p_n + change[n + 1, t + 1] * p_t + g_tt * tau
    d_n, d_t = one_contact_case(
        case, g_nn, g_nt, g_tt, free_n, free_t, model[CONTACT + i, MU], floor
    )
    v_n = 0.0 if case // 3 == REST else free_n + g_nn * d_n + g_nt * d_t
    v_t = 0.0 if case % 3 == HOLD else free_t + g_nt * d_n + g_tt * d_t
    return d_n, d_t + tau, v_n, v_t


@part
def prepare(model: Floats, contacts: Ints, z: Floats, pair: Pair) -> None:
    """Write the data of an impact at two contacts into its workspace."""
    for a in range(4):
        for b in range(4):
            row, column = 2 * contacts[a // 2] + a % 2, 2 * contacts[b // 2] + b % 2
            pair.delassus[a, b] = model[DELASSUS + row, column]
    fill_pair(model, contacts[1], pair.delassus, pair.friction, pair.system)
    for k in range(2):
        i = contacts[k]
        pair.mu[k], pair.eps[k] = model[CONTACT + i, MU], model[CONTACT + i, EPS]
        pair.free[2 * k], pair.free[2 * k + 1] = rates(model, i, z)
        pair.floor[k] = 0.0


@part
def _decide_double(
    model: Floats, contacts: Ints, z: Floats, choice: Ints, marks: Ints, impulses: Floats,
    pair: Pair,
) -> int:  # fmt: skip
    prepare(model, contacts, z, pair)
    delassus, mu, eps, floor = pair.delassus, pair.mu, pair.eps, pair.floor
    feeds, middle, impulse = pair.feeds, pair.middle, pair.end
    first, second = pair.first, pair.second
    for k in range(2):
        feeds[k] = 1 if eps[k] > 0.0 else 0
    table = PAIR + 36 * (contacts[1] - 1)
    outcome = two_contacts(
        model, table, delassus, pair.free, mu, 0.0, floor, feeds, first, impulse, pair
    )
    if outcome in (NO_SOLUTION, AMBIGUOUS):
        return outcome
    choice[0], choice[1] = first[0, 0] + 6 * first[0, 1], first[1, 0] + 6 * first[1, 1]
    choice[2] = UNSOLVED
    velocity_of(choice[0], delassus, pair.free, impulse, middle)
    for k in range(4):
        impulses[0, k] = impulse[k]
    expands = False
    for k in range(2):
        floor[k] = eps[k] * impulse[2 * k]
        expands = expands or floor[k] > 0.0
        second[0, k] = first[0, k]
        feeds[k] = 0
    if expands:
        status = two_contacts(
            model, table + EXPANSION, delassus, middle, mu, model[FORCE, SUMMED], floor, feeds,
            second, impulse, pair,
        )  # fmt: skip
        if status != SOLVED:
            return status
        choice[2] = second[0, 0] + 6 * second[0, 1]
        for k in range(4):
            impulses[1, k] = impulse[k]
    last = second[0, 0] + 6 * second[0, 1]
    velocity_of(last, delassus, middle, impulses[1], pair.after)
    for k in range(2):
        marks[k] = mark(first[0, k], second[0, k], expands, floor[k] > 0.0)
        if outcome == INDETERMINATE:  # tells the two ends of the segment apart
            marks[k] = first[k, 0] % 3 + 3 * (first[k, 1] % 3)
    return outcome


@part
def pair_change(
    model: Floats, change: Floats, moves: bool, contacts: Ints, table: int, index: int,
    coupling: float, impulse: Floats, pair: Pair,
) -> None:  # fmt: skip
    """The same as :func:`one_change` for two contacts: into ``pair.more`` and ``pair.middle``."""
    free, out, tau_0, tau_1 = pair.free, pair.more, 0.0, 0.0
    if moves:
        for a in range(4):
            row = DELASSUS + 2 * contacts[a // 2] + a % 2
            for b in range(4):
                free[a] += change[row, 2 * contacts[b // 2] + b % 2] * impulse[b]
        for k in range(2):
            case = index // 6 if k else index % 6
            if case % 3 == HOLD:
                continue
            tau = change[CONTACT + contacts[k], MU] * (
                impulse[2 * k] + coupling * impulse[2 - 2 * k]
            )
            tau = -tau if case % 3 == FORWARD else tau
            for a in range(4):
                free[a] += pair.delassus[a, 2 * k + 1] * tau
            tau_0, tau_1 = (tau_0, tau) if k else (tau, tau_1)
    impulse_of(model, table + index, free, pair.floor, out)
    velocity_of(index, pair.delassus, free, out, pair.middle)
    out[1] += tau_0
    out[3] += tau_1


@part
def clear(model: Floats, contacts: Ints, case: Ints, z: Floats) -> None:
    """Set to exactly zero the velocities that vanish in an index combination."""
    for k in range(len(contacts)):
        if case[k] // 3 == REST:
            z[3 + ANGLE[contacts[k]]] = 0.0
    for k in range(len(contacts)):
        if case[k] % 3 == HOLD:
            hold(model, contacts[k], z)


@part
def clear_tangent(change: Floats, contacts: Ints, case: Ints, z: Floats, tangent: Floats) -> None:
    """Add what a parameter's change of w_T does to the velocity dy that sticking has set."""
    # Of two sticking contacts the last one has set it.
    for k in range(len(contacts) - 1, -1, -1):
        if case[k] % 3 == HOLD:
            tangent[3] -= rates(change, contacts[k], z)[1]
            return


@part
def hold(model: Floats, i: int, z: Floats) -> None:
    """Set the tangential velocity of contact i to zero by the velocity dy of the sleeve."""
    row = CONTACT + i
    z[3] = -(model[row, TANGENT + 1] * z[4] + model[row, TANGENT + 2] * z[5])
