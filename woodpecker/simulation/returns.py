"""The return map P_j on the section, at rest on a jammed sleeve [Leine2001, Eqs. 12-13]."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pwmap.algebra.arguments import explained
from pwmap.diagrams.frames import DataFrame, dataframe
from pwmap.diagrams.shown import brief, counted, span, table, tally
from woodpecker.base.arrays import Floats
from woodpecker.base.checks import instance, number, real_array, whole
from woodpecker.base.compiled import COMPILED
from woodpecker.base.shown import shown
from woodpecker.mechanics.modes import NO_RATES, model
from woodpecker.mechanics.toy import FAINT, Toy
from woodpecker.motion.codes import FREE_FALL, POLE_END, RETURNED
from woodpecker.simulation.calls import sweep
from woodpecker.simulation.status import Status, status
from woodpecker.simulation.words import EventKind, word_of

ORDER_MOST = 100_000  # returns of one call; a word of EVENT_LIMIT symbols is reserved for each
CHUNK = 256  # starts given to a worker at a time, for orders up to 100


@dataclass(frozen=True, slots=True, kw_only=True)
class Return:
    """One return to the section.

    Parameters
    ----------
    phi_s
        Image P_j(phi_S) [rad]; nan if the toy does not return.
    period, drop
        Time [s] and distance fallen [m]. The drop is the length of the pole if the toy falls off
        it, infinite if it falls for ever.
    slope, d_eps_n1
        d P_j / d phi_S [-] and d P_j / d eps_N1 [rad], exact, from the variational flow; nan, with
        a status, at a grazing or after very many impacts in a short time.
    word, status
        The sequence of events, and why the run ended.

    Examples
    --------
    >>> from woodpecker import Toy, first_return
    >>> back = first_return(Toy(), -0.53)
    >>> round(back.phi_s, 12), round(back.slope, 9), round(1e3 * back.drop, 6)  # rad, -, mm
    (-0.529030291969, -0.833817237, 19.309963)
    >>> back.word
    'S2 D2 I3 D3 I1 I3 D3 I2 D2 I2 J2'
    """

    phi_s: float
    period: float
    drop: float
    slope: float
    d_eps_n1: float
    word: str
    status: Status


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReturnMap:
    """Returns of many starts; arrays of shape (n,) with the meaning of :class:`Return`.

    Examples
    --------
    >>> from woodpecker import Toy, return_map
    >>> found = return_map(Toy(), [-1.0, -0.8, -0.6])
    >>> [status.success for status in found.status], len(set(found.words))
    ([True, True, True], 3)
    """

    start: Floats
    phi_s: Floats
    period: Floats
    drop: Floats
    slope: Floats
    d_eps_n1: Floats
    words: tuple[str, ...]
    status: tuple[Status, ...]

    def __len__(self) -> int:
        return len(self.start)

    def __repr__(self) -> str:
        where = f" from {span(self.start)}" if len(self) else ""
        outcomes = tally(reason.name.lower() for reason in self.status)
        return (
            f"ReturnMap({counted(len(self), 'start')}{where}, "
            f"{counted(len(set(self.words)), 'word')}: {outcomes})"
        )

    def _repr_html_(self) -> str:
        rows = [
            (*(f"{value:.10g}" for value in values), brief(word), reason.name.lower())
            for *values, word, reason in zip(
                self.start, self.phi_s, self.period, self.drop, self.slope, self.words, self.status,
                strict=True,
            )
        ]  # fmt: skip
        header = ("from [rad]", "to [rad]", "period [s]", "drop [m]", "slope", "word", "status")
        return table(repr(self), header, rows)

    def to_dataframe(self) -> DataFrame:
        """The returns, one in each row, as a pandas.DataFrame; ImportError without pandas.

        Columns are ``phi_s_start`` and ``phi_s`` [rad], ``period`` [s], ``drop`` [m], ``slope``
        [-], ``d_eps_n1`` [rad], ``status`` (a name of :class:`Status` in small letters) and
        ``word``.
        """
        return dataframe(
            {
                "phi_s_start": self.start,
                **{name: getattr(self, name) for name in _COLUMNS},
                "status": [reason.name.lower() for reason in self.status],
                "word": self.words,
            }
        )


@explained("a toy has its own values, toy.replace(...) others")
def first_return(toy: Toy, phi_s: float, order: int = 1) -> Return:
    """Start at rest on the section and follow the toy for ``order`` returns.

    Parameters
    ----------
    toy
        The toy.
    phi_s
        Angle of the woodpecker at the start [rad], below ``toy.phi_s_max``.
    order
        Number of returns j >= 1; the toy is simulated again, P_1 is never interpolated.

    Returns
    -------
    Return
        With the image nan if the toy does not return; the status says why.

    Raises
    ------
    TypeError, ValueError
        If ``toy`` is no toy, phi_s is no finite number below the beak's contact, the order no whole
        number from 1 to 100 000, or doubles cannot hold the equations of motion.

    Examples
    --------
    >>> from woodpecker import Toy, first_return
    >>> twice = first_return(Toy(), -0.53, order=2)
    >>> print(f"{twice.phi_s:.9f} rad, slope {twice.slope:.6f}")
    -0.529843646 rad, slope 0.703689
    """
    instance("toy", toy, Toy)
    start = np.array([number("phi_s", phi_s)])
    many = _chunk(toy, checked_starts(toy, start), whole("order", order, most=ORDER_MOST))
    return Return(
        **{name: float(getattr(many, name)[0]) for name in _COLUMNS},
        word=many.words[0],
        status=many.status[0],
    )


def return_map(
    toy: Toy, phi_s: npt.ArrayLike, order: int = 1, *, executor: Executor | None = None
) -> ReturnMap:
    """P_order of the toy at many starts, on all cores; see :func:`woodpecker.return_map`."""
    starts, order = checked_starts(toy, phi_s), whole("order", order, most=ORDER_MOST)
    chunk = chunk_of(order)
    parts = [starts[k : k + chunk] for k in range(0, len(starts), chunk)] or [starts]
    if not (executor is None or hasattr(executor, "map")):
        raise TypeError(f"executor must have a method map, got {shown(executor)}")
    if executor is not None:
        results = list(executor.map(_chunk, [toy] * len(parts), parts, [order] * len(parts)))
    elif COMPILED and len(parts) > 1:
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            results = list(pool.map(_chunk, [toy] * len(parts), parts, [order] * len(parts)))
    else:
        results = [_chunk(toy, part, order) for part in parts]
    return joined(results)


def chunk_of(order: int) -> int:
    """Number of starts for a worker at a time: fewer of a high order, which needs memory."""
    return max(1, CHUNK // math.ceil(order / 100))


def joined(parts: Sequence[ReturnMap]) -> ReturnMap:
    """Join several return maps into one, in their order."""
    columns = {
        name: np.concatenate([getattr(part, name) for part in parts])
        for name in ("start", *_COLUMNS)
    }
    return ReturnMap(
        **columns,
        words=tuple(text for part in parts for text in part.words),
        status=tuple(reason for part in parts for reason in part.status),
    )


_COLUMNS = ("phi_s", "period", "drop", "slope", "d_eps_n1")
SLOPE = 3  # column of the slope; that of the derivative in eps_N1 follows
_SEED = np.array([[1.0, 0.0, 0.0]])


def checked_starts(toy: Toy, phi_s: npt.ArrayLike) -> Floats:
    """Starts [rad] as a flat array; ValueError unless the toy can start from all of them."""
    instance("toy", toy, Toy)
    starts = real_array("phi_s", phi_s).ravel()
    bad = starts[~(np.isfinite(starts) & (starts < toy.phi_s_max))]
    if bad.size:
        raise ValueError(
            f"phi_s must be finite and below {toy.phi_s_max:.6g}, where the beak touches the pole, "
            f"got {bad[0]}"
        )
    return starts


def _chunk(toy: Toy, starts: Floats, order: int) -> ReturnMap:
    out, codes, lengths, words = sweep(model(toy), NO_RATES, starts, order, _SEED)
    if toy.eps_n1 == 0.0:  # the beak does not bounce, but at any larger restitution it does
        bounces = sweep(model(toy.replace(eps_n1=FAINT)), NO_RATES, starts, order, _SEED)
        out[:, SLOPE + 1] = bounces[0][:, SLOPE + 1]
        codes = np.where(codes == RETURNED, bounces[1], codes)
    texts = [word_of(row[:n].tobytes()) for row, n in zip(words, lengths, strict=True)]
    endless = codes == FREE_FALL
    if math.isfinite(toy.pole):
        codes[endless] = POLE_END
    lost = codes > RETURNED
    for column in (0, 1, SLOPE, SLOPE + 1):
        out[lost, column] = np.nan
    out[(codes == POLE_END) | endless, 2] = toy.pole
    return ReturnMap(
        start=starts,
        **{name: np.ascontiguousarray(out[:, k]) for k, name in enumerate(_COLUMNS)},
        words=tuple(texts),
        status=tuple(map(_reason, codes.tolist(), texts)),
    )


def _reason(code: int, text: str) -> Status:
    if code == RETURNED and EventKind.INDETERMINATE_IMPACT.value in text:
        return Status.RETURNED_INDETERMINATE
    return status(code)
