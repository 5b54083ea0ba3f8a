"""The Woodpecker Toy in rational numbers: modes and impulses, from the paper's equations.

Contacts are 0 beak, 1 lower edge, 2 upper edge; states are 0 open, 1 stick, 2 slip up, 3 slip down.
"""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

OPEN, STICK, UP, DOWN = range(4)
PAPER = {  # the data of the paper, and two numbers that it does not give; SI units
    "m_m": Fraction("0.0003"),
    "j_m": Fraction("0.000000005"),
    "m_s": Fraction("0.0045"),
    "j_s": Fraction("0.0000007"),
    "g": Fraction("9.81"),
    "r_0": Fraction("0.0025"),
    "r_m": Fraction("0.0031"),
    "h_m": Fraction("0.0058"),
    "l_m": Fraction("0.01"),
    "l_g": Fraction("0.015"),
    "h_s": Fraction("0.02"),
    "l_s": Fraction("0.0201"),
    "c_phi": Fraction("0.0056"),
    "mu_1": Fraction("0.3"),
    "mu_2": Fraction("0.3"),
    "mu_3": Fraction("0.3"),
    "eps_n1": Fraction("0.5"),
    "eps_n2": Fraction("0"),
    "eps_n3": Fraction("0"),
}
NAMES = list(PAPER)
ANGLE, SIDE = (2, 1, 1), (-1, 1, -1)  # the coordinate that closes a gap, and in which direction


class Coasting(NamedTuple):
    """Motion in a mode, d the stretch: q'' = a + b d, d'' = alpha + kappa d, lambda = p + r d."""

    a: list[Fraction]
    b: list[Fraction]
    alpha: Fraction
    kappa: Fraction
    forces: dict[int, list[Fraction]]  # p_N, r_N, p_T, r_T of each closed contact


class ExactToy:
    """The toy with exact data; its methods do not use the restitution coefficients."""

    def __init__(self, values: dict[str, Fraction], summed: bool) -> None:
        self.values, self.summed = values, summed
        v = values
        ms, lm, lg = v["m_s"], v["l_m"], v["l_g"]
        self.mass = [
            [ms + v["m_m"], ms * lm, ms * lg],
            [ms * lm, v["j_m"] + ms * lm * lm, ms * lm * lg],
            [ms * lg, ms * lm * lg, v["j_s"] + ms * lg * lg],
        ]
        g, c = v["g"], v["c_phi"]
        self.at_rest = [-g * (ms + v["m_m"]), -g * ms * lm, -g * ms * lg]
        self.per_stretch = [Fraction(0), c, -c]
        zero, one = Fraction(0), Fraction(1)
        hm, hs, rm = v["h_m"], v["h_s"], v["r_m"]
        self.normal = [[zero, zero, -hs], [zero, hm, zero], [zero, -hm, zero]]
        self.tangent = [[one, lm, lg - v["l_s"]], [one, rm, zero], [one, rm, zero]]
        self.mu = [v["mu_1"], v["mu_2"], v["mu_3"]]
        play = [lm + lg - v["l_s"] - v["r_0"], rm - v["r_0"], rm - v["r_0"]]
        self.lever = [hs, hm, hm]
        self.touch = [-SIDE[i] * play[i] / self.lever[i] for i in range(3)]  # angles that touch
        rows = [w for i in range(3) for w in (self.normal[i], self.tangent[i])]
        columns = [[row[j] for row in rows] for j in range(3)]
        solution = solve(self.mass, columns)
        self.kick = [[solution[j][k] for j in range(3)] for k in range(6)]  # M^-1 w
        self.g = [[dot(row, self.kick[k]) for k in range(6)] for row in rows]  # W^T M^-1 W
        self.mode = lru_cache(maxsize=None)(self._mode)
        self.case = lru_cache(maxsize=None)(self._case)

    def _mode(self, states: tuple[int, ...]) -> Coasting:
        closed = [i for i in range(3) if states[i] != OPEN]
        n = 3 + 2 * len(closed)
        matrix = [[Fraction(0)] * n for _ in range(n)]
        right = [[Fraction(0)] * 2 for _ in range(n)]
        for i in range(3):
            matrix[i][:3] = self.mass[i]
            right[i] = [self.at_rest[i], self.per_stretch[i]]
        for k, i in enumerate(closed):
            column = 3 + 2 * k
            for j in range(3):
                matrix[j][column], matrix[j][column + 1] = -self.normal[i][j], -self.tangent[i][j]
            matrix[column][:3] = self.normal[i]
            if states[i] == STICK:
                matrix[column + 1][:3] = self.tangent[i]
            else:
                matrix[column + 1][column + 1] = Fraction(1)
                matrix[column + 1][column] = self.mu[i] * (1 if states[i] == UP else -1)
        x = solve(matrix, right)
        a, b = [row[0] for row in x[:3]], [row[1] for row in x[:3]]
        forces = {i: [*x[3 + 2 * k], *x[4 + 2 * k]] for k, i in enumerate(closed)}
        return Coasting(a, b, a[2] - a[1], b[2] - b[1], forces)

    def _case(
        self, contacts: tuple[int, ...], rests: tuple[bool, ...], slips: tuple[int, ...],
        coupled: bool,
    ) -> list[list[Fraction]] | None:  # fmt: skip
        """Matrix from free velocities and floors to impulses (N, T by contact); None: singular."""
        n = len(contacts)
        at = [2 * i + k for i in contacts for k in (0, 1)]
        matrix, right = [], []

        def line(size: int, entries: dict[int, Fraction | int]) -> list[Fraction]:
            return [Fraction(entries.get(j, 0)) for j in range(size)]

        for k, i in enumerate(contacts):
            if rests[k]:
                matrix.append([self.g[2 * i][j] for j in at])
            else:
                matrix.append(line(2 * n, {2 * k: 1}))
            right.append(line(3 * n, {2 * k: -1} if rests[k] else {2 * n + k: 1}))
            if slips[k] == 0:
                matrix.append([self.g[2 * i + 1][j] for j in at])
            else:
                bounds = [m for m in range(n) if m == k or coupled]
                friction = {2 * m: self.mu[i] * slips[k] for m in bounds}
                matrix.append(line(2 * n, {**friction, 2 * k + 1: 1}))
            right.append(line(3 * n, {2 * k + 1: -1} if slips[k] == 0 else {}))
        try:
            return solve(matrix, right)
        except ZeroDivisionError:
            return None


def dot(a: list[Fraction], b: list[Fraction]) -> Fraction:
    """Scalar product."""
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def solve(matrix: list[list[Fraction]], right: list[list[Fraction]]) -> list[list[Fraction]]:
    """Solve linear equations by Gauss-Jordan elimination; ZeroDivisionError if singular."""
    n = len(matrix)
    rows = [[*a, *b] for a, b in zip(matrix, right, strict=True)]
    for i in range(n):
        pivot = next((k for k in range(i, n) if rows[k][i] != 0), None)
        if pivot is None:
            raise ZeroDivisionError
        rows[i], rows[pivot] = rows[pivot], rows[i]
        rows[i] = [x / rows[i][i] for x in rows[i]]
        for k in range(n):
            if k != i and rows[k][i] != 0:
                factor = rows[k][i]
                rows[k] = [x - factor * y for x, y in zip(rows[k], rows[i], strict=True)]
    return [row[n:] for row in rows]
