"""The toy in rational numbers: its motion in each mode, and its response to impulses.

Parameters are exact decimals as written: 3/10000 for 0.0003. All coefficients of the equations of
motion are exact, only the frequencies are not. Only a restitution coefficient may vary.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from functools import cache
from itertools import product
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from flint import fmpq, fmpq_mat

from woodpecker.enclosures.balls import ball, sum_of
from woodpecker.enclosures.forms import varying
from woodpecker.enclosures.not_proved import NotProved
from woodpecker.enclosures.taylor import Frame
from woodpecker.mechanics.cases import HOLD, REST, write_case
from woodpecker.mechanics.equations import (
    force_at_rest,
    force_per_stretch,
    gap_offsets,
    mass_matrix,
    normal_directions,
    tangential_directions,
)
from woodpecker.mechanics.modes import OPEN, SIGN, write_mode
from woodpecker.mechanics.toy import RESTITUTIONS, ExpansionFriction, Toy, parameters

Numbers = Sequence[Any]
State = tuple[int, ...]  # states of the three contacts


def rational(value: float) -> Fraction:
    """The shortest decimal that denotes a double, as a rational number: 3/10000 for 0.0003."""
    return Fraction(repr(float(value)))


def data(toy: Toy) -> dict[str, Fraction]:
    """The parameters of a toy as rational numbers, except the length of its pole."""
    return {name: rational(getattr(toy, name)) for name in parameters() if name != "pole"}


class Mode(NamedTuple):
    """Motion in a mode, d the spring's stretch: q'' = a + b d, d'' = alpha + kappa d."""

    a: Numbers
    b: Numbers
    alpha: Any
    kappa: Any
    forces: Mapping[int, Numbers]  # of a closed contact: p_N, r_N, p_T, r_T, lambda = p + r d


class BallToy:
    """The toy in balls; the restitution ``moving`` is a polynomial in p over a frame.

    Contacts are ordered beak, lower edge, upper edge; impulses N1, T1, N2, T2, N3, T3.
    """

    def __init__(
        self, toy: Toy, moving: str = "", frame: Frame | None = None, line: Sequence[Any] = ()
    ) -> None:
        values = {name: fmpq(x.numerator, x.denominator) for name, x in data(toy).items()}
        self._exact = exact = SimpleNamespace(**values)
        self.summed = toy.expansion_friction == ExpansionFriction.SUMMED  # the law of expansions
        self.eps = [ball(values[name]) for name in RESTITUTIONS]
        if frame is not None:
            self.eps[RESTITUTIONS.index(moving)] = varying(frame, line)
        self._mu, lever = (exact.mu_1, exact.mu_2, exact.mu_3), (exact.h_s, exact.h_m, exact.h_m)
        self.mu, self.levers = _balls([self._mu, lever])  # lever arms of the gaps [m]
        offsets = gap_offsets(exact)
        # angles at which the contacts touch the pole [rad]
        self.limits = [ball(offsets[i] / lever[i]) * int(-SIGN[i]) for i in range(3)]
        mass, normal, tangent = (
            each(exact) for each in (mass_matrix, normal_directions, tangential_directions)
        )
        self.mass, self.tangents = _balls(mass), _balls(tangent)
        self.h_0, self.h_1 = _balls([force_at_rest(exact), force_per_stretch(exact)])
        rows = [w for pair in zip(normal, tangent, strict=True) for w in pair]  # W^T
        columns = zip(*rows, strict=True)
        response = solved(np.hstack([np.array([*x], dtype=object) for x in (mass, columns)]))
        self._delassus = [
            [sum_of(row[j] * response[j][k] for j in range(3)) for k in range(6)] for row in rows
        ]
        self.responses = _balls(zip(*response, strict=True))  # M^-1 W: velocities per impulse
        self.delassus = _balls(self._delassus)  # W^T M^-1 W
        self.mode, self.case = cache(self._mode), cache(self._case)

    def _mode(self, states: State) -> Mode:
        """Motion with these contact states, of which at most one may stick: two are rest."""
        # M qdd - W lambda = h_0 + h_1 d with the constraints of the closed contacts
        closed, e = [i for i in range(3) if states[i] != OPEN], self._exact
        n = 3 + 2 * len(closed)
        system = np.zeros((n, n + 2), dtype=object)
        forces_ = force_at_rest(e), force_per_stretch(e)
        directions = normal_directions(e), tangential_directions(e)
        write_mode(n, states, mass_matrix(e), *forces_, *directions, self._mu, system)
        solution = solved(system)
        a, b = ([row[k] for row in solution[:3]] for k in range(2))
        forces = {
            i: [ball(x) for x in (*solution[3 + 2 * k], *solution[4 + 2 * k])]
            for k, i in enumerate(closed)
        }
        alpha, kappa = ball(a[2] - a[1]), ball(b[2] - b[1])
        return Mode([ball(x) for x in a], [ball(x) for x in b], alpha, kappa, forces)

    def _case(self, sleeve: int, first: int, second: int, coupled: bool) -> list[Numbers] | None:
        """Matrix of the impulses of beak and sleeve for an index combination, or None."""
        # Shape (4, 6): coefficients of the velocities without impulses and of the floors, the least
        # normal impulses. None where both contacts rest and stick: only that is singular.
        if first == second == 3 * REST + HOLD:
            return None
        at, mu = (0, 1, 2 * sleeve, 2 * sleeve + 1), (self._mu[0], self._mu[sleeve])
        delassus = np.array([[self._delassus[a][b] for b in at] for a in at], dtype=object)
        friction = np.zeros((2, 2), dtype=object)
        for k, j in product(range(2), repeat=2):
            friction[k, j] = mu[k] if j == k or coupled else fmpq(0)
        system = np.zeros((4, 10), dtype=object)
        write_case(first + 6 * second, delassus, friction, system)
        return _balls(solved(system))


def _balls(rows: Iterable[Numbers]) -> list[Numbers]:
    return [[ball(x) for x in row] for row in rows]


def solved(system: Any) -> list[list[Any]]:
    """Solve n equations with k right sides, (n, n + k), exactly; NotProved if singular."""
    n = len(system)
    try:
        found: list[list[Any]] = (
            fmpq_mat(system[:, :n].tolist()).solve(fmpq_mat(system[:, n:].tolist())).tolist()
        )
    except ZeroDivisionError:
        raise NotProved("a contact problem is singular") from None
    return found
