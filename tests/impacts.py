"""Impacts of the toy: scenes, random states before them, and the blow that the kernel computes."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pytest

from woodpecker.base.compiled import jit
from woodpecker.mechanics import equations as mechanics
from woodpecker.mechanics.cases import fill_cases
from woodpecker.mechanics.contact_problems import INDETERMINATE, PAIR_ROOM, SOLVED, Pair
from woodpecker.mechanics.impacts import decide
from woodpecker.mechanics.modes import ANGLE, NO_RATES, SIGN, model
from woodpecker.mechanics.toy import ExpansionFriction, Toy
from woodpecker.simulation import striking
from woodpecker.simulation.calls import make_work
from woodpecker.simulation.margins import NOTES

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

LAWS = list(ExpansionFriction)
laws = pytest.mark.parametrize("law", LAWS)

# thousands of calls from here:
decide, along, fill_cases = jit(decide), jit(striking.strike), jit(fill_cases)


def case_table(delassus: FloatArray, friction: FloatArray) -> FloatArray:
    """Impulses of all index combinations of two contacts, (36, 24)."""
    table = np.empty((36, 24))
    fill_cases(delassus, friction, table, np.empty((4, 10)))
    return table


def make_pair() -> Pair:
    """Room for impacts at two contacts."""
    pair: Pair = np.zeros(1, dtype=PAIR_ROOM)[0]
    return pair


UNITS = np.array([0.2, 10.0, 10.0])  # of the velocities

SCENES = {"1": (0,), "2": (1,), "3": (2,), "1+2": (0, 1), "1+3": (0, 2)}
scenes = pytest.mark.parametrize("contacts", SCENES.values(), ids=SCENES)


@dataclass(frozen=True, kw_only=True)
class Blow:
    """What an impact does."""

    outcome: int
    u: FloatArray
    tangents: FloatArray
    case: IntArray
    impulses: FloatArray  # phases x (N, T of each contact)


def strike(
    toy: Toy,
    contacts: tuple[int, ...],
    u: npt.ArrayLike,
    tangents: npt.ArrayLike = (),
    seed: npt.ArrayLike = (),
) -> Blow:
    z, hit = np.zeros(7), np.array(contacts, dtype=np.int64)
    z[3:6] = u
    rows, seeds = (np.reshape(np.array(each, dtype=float), (-1, 3)) for each in (tangents, seed))
    marks, choice = np.zeros(2, dtype=np.int64), np.zeros(3, dtype=np.int64)
    numbers, room = model(toy), make_work()["route"][0]
    room["z"], outcome = z, decide(numbers, hit, z, choice, marks, room["impulses"], room["pair"])
    after = [np.zeros((0, 3))]
    if outcome in (SOLVED, INDETERMINATE):
        for k in range(0, max(1, len(rows)), 2):  # a route has room for two tangents
            some = rows[k : k + 2]
            room["z"], room["tangents"], room["seeds"] = z, 0.0, 0.0
            room["tangents"][: len(some), 3:6], room["seeds"][: len(some)] = some, seeds[k : k + 2]
            room["touching"][: len(hit)], room["choice"] = hit, choice
            along(numbers, NO_RATES, len(hit), 0, np.zeros((NOTES, 0)), room)
            after.append(room["tangents"][: len(some), 3:6].copy())
    return Blow(
        outcome=outcome, u=room["z"][3:6], tangents=np.concatenate(after),
        case=room["case"][: len(hit)], impulses=room["impulses"],
    )  # fmt: skip


def random_toy(
    rng: np.random.Generator, friction: float, law: ExpansionFriction = ExpansionFriction.SUMMED
) -> Toy:
    eps, mu = rng.uniform(0.0, 1.0, size=3), friction * rng.uniform(0.5, 1.0, size=3)
    return Toy(
        eps_n1=eps[0], eps_n2=eps[1], eps_n3=eps[2], mu_1=mu[0], mu_2=mu[1], mu_3=mu[2],
        expansion_friction=law,
    )  # fmt: skip


def frictions(toy: Toy, contacts: tuple[int, ...]) -> FloatArray:
    return np.array([(toy.mu_1, toy.mu_2, toy.mu_3)[i] for i in contacts])


def restitutions(toy: Toy, contacts: tuple[int, ...]) -> FloatArray:
    return np.array([(toy.eps_n1, toy.eps_n2, toy.eps_n3)[i] for i in contacts])


def coupling_of(toy: Toy, contacts: tuple[int, ...]) -> float:
    """What the other contact adds to the bound of friction in the expansion."""
    summed = toy.expansion_friction == ExpansionFriction.SUMMED
    return 1.0 if summed and len(contacts) == 2 else 0.0


def approach(rng: np.random.Generator, contacts: tuple[int, ...]) -> FloatArray:
    """Velocities of the size that occurs; the contacts close, or one of two rests."""
    u = rng.normal(size=3) * [0.2, 10.0, 10.0]
    for i in contacts:
        u[ANGLE[i]] = -SIGN[i] * abs(u[ANGLE[i]])
    if len(contacts) == 2 and rng.random() < 0.3:
        u[ANGLE[contacts[rng.integers(2)]]] = 0.0
    return u


def directions(toy: Toy, contacts: tuple[int, ...]) -> FloatArray:
    """W, columns N and T of each contact in turn."""
    normal, tangential = mechanics.normal_directions(toy), mechanics.tangential_directions(toy)
    return np.array([w for i in contacts for w in (normal[i], tangential[i])]).T
