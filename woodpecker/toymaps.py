"""The kernel's numbers of the toy over one of its parameters."""

from __future__ import annotations

import math

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.mechanics.modes import (
    CHANGE,
    CONTACT,
    EPS,
    EPSILONS,
    FIXED,
    STEP,
    Numbers,
    model,
    parameters_of,
    refill,
)
from woodpecker.mechanics.toy import Toy, limits

CLEAR = 1e-9  # relative distance from the limits of a parameter beyond which rounding cannot matter


class Table:
    """The kernel's numbers over one parameter of the toy, and their derivatives.

    Attributes
    ----------
    numbers, change
        As :func:`woodpecker.simulation.calls.sweep` takes them, for the value of the last
        :meth:`at`.
    seed
        (1, 3), derivatives of the restitution coefficients.
    """

    def __init__(self, toy: Toy, parameter: str) -> None:
        self._toy, self._parameter = toy, parameter
        self._low, self._high = limits(toy, parameter)
        self.numbers: Floats = model(toy)
        self.change: Floats = np.zeros(CHANGE) if parameter in Numbers._fields else FIXED
        self.seed: Floats = np.zeros((1, 3))
        if parameter in EPSILONS:
            self.seed[0, EPSILONS.index(parameter)] = 1.0
        self._complex = parameters_of(toy, parameter)
        self._value = math.nan

    def at(self, p: float) -> None:
        """Take the numbers of another value; ValueError says why the toy cannot have it."""
        if p == self._value:
            return
        if not self._low * (1.0 + CLEAR) < p < self._high * (1.0 - CLEAR):
            self._toy.replace(**{self._parameter: p})
        if self._parameter in EPSILONS:
            self.numbers[CONTACT + EPSILONS.index(self._parameter), EPS] = p
        elif self._parameter in Numbers._fields:
            self._complex[Numbers._fields.index(self._parameter)] = complex(p, STEP)
            refill(self._complex, self.numbers, self.change)
        self._value = p
