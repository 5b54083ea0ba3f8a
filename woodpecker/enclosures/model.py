"""The numbers of the toy, exact: motion in its modes, and what impulses do.

The parameters are the rationals that a person writes, 3/10000 for 0.0003, and so is all that the
equations of motion need but the frequencies. Only a restitution may move.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import product
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from flint import fmpq, fmpq_mat

from woodpecker.enclosures.balls import ball
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
from woodpecker.mechanics.toy import ExpansionFriction, Toy, parameters

Numbers = Sequence[Any]
State = tuple[int, int, int]


def rational(value: float) -> Fraction:
    """The rational number that the shortest decimal of a double says: 3/10000 for 0.0003."""
    return Fraction(repr(float(value)))


def data(toy: Toy) -> dict[str, Fraction]:
    """The numbers of a toy but the length of its pole."""
    return {name: rational(getattr(toy, name)) for name in parameters() if name != "pole"}


class Mode(NamedTuple):
    """Motion with given contact states: qdd = a + b d, ddd = alpha + kappa d."""

    a: Numbers
    b: Numbers
    alpha: Any
    kappa: Any
    forces: Mapping[int, Numbers]  # by closed contact p_N, r_N, p_T, r_T: lambda = p + r d


@dataclass(frozen=True)
class BallToy:
    """The toy at an exact value of a parameter, or over an interval of it."""

    values: dict[str, Any]  # by name rationals of flint, but for a form where one moves
    summed: bool  # whether friction in expansions is bounded by the sum of normal impulses

    @classmethod
    def of(
        cls, toy: Toy, moving: str = "", frame: Frame | None = None, line: Sequence[Any] = ()
    ) -> BallToy:
        """The model of a toy; one of its restitutions may move, as a polynomial in p."""
        values: dict[str, Any] = {
            name: fmpq(x.numerator, x.denominator) for name, x in data(toy).items()
        }
        if frame is not None:
            values[moving] = varying(frame, line)
        return cls(values, toy.expansion_friction == ExpansionFriction.SUMMED)

    @cached_property
    def equations(self) -> Any:
        """Matrices of the equations of motion."""
        toy = SimpleNamespace(**self.values)
        return SimpleNamespace(
            mass=mass_matrix(toy),
            h_0=force_at_rest(toy),
            h_1=force_per_stretch(toy),
            normal=normal_directions(toy),
            tangent=tangential_directions(toy),
            mu=(toy.mu_1, toy.mu_2, toy.mu_3),
            eps=tuple(map(ball, (toy.eps_n1, toy.eps_n2, toy.eps_n3))),
            lever=(toy.h_s, toy.h_m, toy.h_m),
        )

    @cached_property
    def limits(self) -> Numbers:
        """Angles at which contacts 1, 2, 3 touch [rad]."""
        offsets, lever = gap_offsets(SimpleNamespace(**self.values)), self.equations.lever
        return [ball(offsets[i] / lever[i]) * int(-SIGN[i]) for i in range(3)]

    @cached_property
    def tangents(self) -> list[Numbers]:
        """Directions of slip w_T of contacts 1, 2, 3."""
        return _balls(self.equations.tangent)

    @cached_property
    def levers(self) -> Numbers:
        """Lever arms of the gaps [m]."""
        return [ball(x) for x in self.equations.lever]

    @cached_property
    def _modes(self) -> dict[State, Mode]:
        return {}

    def mode(self, states: State) -> Mode:
        """Motion with these contact states; not where two contacts stick, which is rest."""
        if states not in self._modes:
            self._modes[states] = self._solved(states)
        return self._modes[states]

    def _solved(self, states: State) -> Mode:
        """M qdd - W lambda = h_0 + h_1 d with the constraints of the closed contacts."""
        e = self.equations
        closed = [i for i in range(3) if states[i] != OPEN]
        n = 3 + 2 * len(closed)
        system = np.zeros((n, n + 2), dtype=object)
        write_mode(n, states, e.mass, e.h_0, e.h_1, e.normal, e.tangent, e.mu, system)
        solution = solved(system)
        a, b = ([row[k] for row in solution[:3]] for k in range(2))
        forces = {
            i: [ball(x) for x in (*solution[3 + 2 * k], *solution[4 + 2 * k])]
            for k, i in enumerate(closed)
        }
        alpha, kappa = ball(a[2] - a[1]), ball(b[2] - b[1])
        return Mode([ball(x) for x in a], [ball(x) for x in b], alpha, kappa, forces)

    @cached_property
    def _response(self) -> list[list[Any]]:
        """M^-1 W, rows of q, columns N1, T1, N2, T2, N3, T3."""
        e = self.equations
        columns = [w for pair in zip(e.normal, e.tangent, strict=True) for w in pair]
        right = [[column[i] for column in columns] for i in range(3)]
        return solved(np.hstack([np.array(e.mass, dtype=object), np.array(right, dtype=object)]))

    @cached_property
    def responses(self) -> list[Numbers]:
        """What a unit impulse N1, T1, N2, T2, N3, T3 adds to the velocities: six vectors."""
        return _balls(zip(*self._response, strict=True))

    @cached_property
    def _delassus(self) -> list[list[Any]]:
        e = self.equations
        rows = [w for pair in zip(e.normal, e.tangent, strict=True) for w in pair]
        return [
            [sum_of(row[j] * self._response[j][k] for j in range(3)) for k in range(6)]
            for row in rows
        ]

    @cached_property
    def delassus(self) -> list[Numbers]:
        """W^T M^-1 W, rows and columns N1, T1, N2, T2, N3, T3."""
        return _balls(self._delassus)

    @cached_property
    def _tables(self) -> dict[tuple[int, int, int, bool], list[Numbers] | None]:
        return {}

    def case(self, sleeve: int, first: int, second: int, expands: bool) -> list[Numbers] | None:
        """Impulses of an index combination of the beak and a contact of the sleeve.

        (4, 6) coefficients of the velocities without impulses and of the floors; None where the
        combination is rank-deficient, which is seen exactly: both at rest and sticking.
        """
        key = sleeve, first, second, expands
        if key not in self._tables:
            self._tables[key] = self._combination(*key)
        return self._tables[key]

    def _combination(
        self, sleeve: int, first: int, second: int, expands: bool
    ) -> list[Numbers] | None:
        if first == second == 3 * REST + HOLD:
            return None
        at, coupled = (0, 1, 2 * sleeve, 2 * sleeve + 1), expands and self.summed
        mu = self.equations.mu[0], self.equations.mu[sleeve]
        delassus = np.array([[self._delassus[a][b] for b in at] for a in at], dtype=object)
        friction = np.zeros((2, 2), dtype=object)
        for k, j in product(range(2), repeat=2):
            friction[k, j] = mu[k] if j == k or coupled else fmpq(0)
        system = np.zeros((4, 10), dtype=object)
        write_case(first + 6 * second, delassus, friction, system)
        return _balls(solved(system))


def _balls(rows: Iterable[Numbers]) -> list[Numbers]:
    return [[ball(x) for x in row] for row in rows]


def sum_of(terms: Any) -> Any:
    """The sum of at least one term."""
    first, *others = terms
    for term in others:
        first = first + term
    return first


def solved(system: Any) -> list[list[Any]]:
    """Solve n linear equations in rationals, (n, n + k); NotProved if they are singular."""
    n = len(system)
    try:
        found: list[list[Any]] = (
            fmpq_mat(system[:, :n].tolist()).solve(fmpq_mat(system[:, n:].tolist())).tolist()
        )
    except ZeroDivisionError:
        raise NotProved("a contact problem is singular") from None
    return found
