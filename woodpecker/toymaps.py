"""P_1 of the toy as a map of (phi_S, parameter), with exact derivatives in any parameter."""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from woodpecker.base.arrays import Codes, Floats
from woodpecker.base.compiled import announce
from woodpecker.mechanics.modes import (
    CHANGE,
    CONTACT,
    EPS,
    EPSILONS,
    FIXED,
    LIMIT,
    STEP,
    Numbers,
    model,
    parameters_of,
    refill,
)
from woodpecker.mechanics.toy import Toy, known_parameter, limits
from woodpecker.piecewise.maps import Evaluation
from woodpecker.piecewise.partition import Samples, WordBook
from woodpecker.simulation.calls import compute, sweep
from woodpecker.simulation.codes import RETURNED
from woodpecker.simulation.returns import EVENT_LIMIT
from woodpecker.simulation.status import status
from woodpecker.simulation.words import word

RELATIVE_STEP = 1e-6  # of one-sided differences at zero restitution, where contacts that rest begin
# to bounce: the cube root of the kernel's rounding
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


class _Evaluation:
    """P_1 at single points, with a table and buffers for all calls: one for each thread."""

    def __init__(self, toy: Toy, parameter: str) -> None:
        self.table = Table(toy, parameter)
        self._bounces = parameter in EPSILONS
        self._start, self._out = np.empty(1), np.empty((1, 5))
        self._code, self._length = np.empty(1, dtype=np.int64), np.empty(1, dtype=np.int64)
        self._word = np.empty((1, EVENT_LIMIT), dtype=np.int16)
        self._texts: dict[bytes, str] = {}
        announce(compute)

    def __call__(self, phi_s: float, p: float) -> Evaluation:
        table = self.table
        try:
            table.at(p)
        except ValueError as error:
            return _undefined(str(error))
        if not phi_s < table.numbers[CONTACT, LIMIT]:
            return _undefined("the beak touches the pole")
        self._start[0] = phi_s
        sweep(
            table.numbers, table.change, self._start, 1, table.seed, self._out, self._code,
            self._length, self._word,
        )  # fmt: skip
        if self._code[0] != RETURNED:
            return _undefined(status(int(self._code[0])).value)
        symbols = self._word[0, : self._length[0]]
        text = self._texts.get(key := symbols.tobytes())
        if text is None:
            text = self._texts[key] = word(symbols.tolist())
        image, _, _, slope, rate = self._out[0].tolist()
        if p == 0.0 and self._bounces and math.isnan(rate):
            near, far = (self(phi_s, k * RELATIVE_STEP).value for k in (1, 2))
            rate = (-3.0 * image + 4.0 * near - far) / (2.0 * RELATIVE_STEP)
        return Evaluation(image, slope, rate, text)


def _undefined(reason: str) -> Evaluation:
    return Evaluation(math.nan, math.nan, math.nan, reason, False)


class _PerThread(threading.local):
    """What a thread keeps of a map between calls; no part of the map, and no copy has it."""

    evaluation: _Evaluation | None = None
    table: Table | None = None

    def __reduce__(self) -> tuple[type[_PerThread], tuple[()]]:
        return _PerThread, ()


@dataclass(frozen=True, slots=True)
class ToyMap:
    """P_1 of the toy as a labelled map of (phi_S, parameter); it pickles, and threads may share it.

    Parameters
    ----------
    toy
        The toy; its own value of the parameter does not matter.
    parameter
        The parameter of the toy that varies.
    """

    toy: Toy
    parameter: str = "eps_n1"
    _cache: _PerThread = field(default_factory=_PerThread, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        known_parameter(self.parameter)

    def __call__(self, phi_s: float, p: float) -> Evaluation:
        """The return from phi_S [rad]; at an impossible p or phi_S it is not defined."""
        evaluation = self._cache.evaluation
        if evaluation is None:
            evaluation = self._cache.evaluation = _Evaluation(self.toy, self.parameter)
        return evaluation(phi_s, p)


@dataclass(frozen=True, slots=True)
class ToySamples:
    """P_1 of the toy as a map that takes many points at once; see :class:`ToyMap`."""

    toy: Toy
    parameter: str = "eps_n1"
    _cache: _PerThread = field(default_factory=_PerThread, init=False, repr=False, compare=False)
    _book: WordBook = field(default_factory=WordBook, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        known_parameter(self.parameter)

    @property
    def words(self) -> Sequence[str]:
        """Word of each index that ``sweep`` has given out so far."""
        return self._book.texts

    def sweep(self, x: Floats, p: float) -> Samples:
        """Returns from phi_S = x (n,) [rad] at one value of the parameter.

        Raises
        ------
        ValueError
            If the toy cannot have this value.
        """
        n, table = len(x), self._cache.table
        if table is None:
            table = self._cache.table = Table(self.toy, self.parameter)
        table.at(p)
        out, texts = np.empty((n, 5)), np.empty((n, EVENT_LIMIT), dtype=np.int16)
        codes, lengths = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
        announce(compute)
        sweep(table.numbers, table.change, x, 1, table.seed, out, codes, lengths, texts)
        defined = codes == RETURNED
        out[~defined] = np.nan
        index = np.array(
            [self._number(int(codes[i]), texts[i, : lengths[i]]) for i in range(n)], dtype=np.int64
        )
        return Samples(x, out[:, 0], out[:, 3], out[:, 4], index, defined)

    def _number(self, code: int, symbols: Codes) -> int:
        """Index of the word of a return, or of the reason why there is none."""
        if code == RETURNED:
            return self._book.index(symbols.tobytes(), partial(word, symbols.tolist()))
        reason = status(code).value
        return self._book.index(reason, reason.__str__)


def toy_map(toy: Toy, parameter: str = "eps_n1") -> ToyMap:
    """P_1 of the toy as a labelled map of (phi_S, parameter).

    Derivatives are those of the variational flow, exact; only where a restitution coefficient is
    zero and a larger one would make a resting contact bounce it is a forward difference.

    Raises
    ------
    TypeError
        If the parameter is unknown.
    """
    return ToyMap(toy, parameter)


def toy_samples(toy: Toy, parameter: str = "eps_n1") -> ToySamples:
    """P_1 of the toy as a map that takes many points at once; see :func:`toy_map`."""
    return ToySamples(toy, parameter)
