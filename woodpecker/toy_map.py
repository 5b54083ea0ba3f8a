"""P_1 of the toy as a piecewise-smooth map of (phi_S, parameter): its pieces and their margins.

The kernel finds the path of a return; following it again gives value, derivatives and margins.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np

from pwmap.diagrams.shown import counted
from woodpecker.base.arrays import Floats
from woodpecker.base.checks import instance, number, real_array
from woodpecker.base.shown import shown
from woodpecker.maps.pieces import Image, PiecewiseMap, no_image
from woodpecker.maps.sweeps import Sweep
from woodpecker.mechanics.equations import unsound
from woodpecker.mechanics.modes import (
    CHANGE,
    CONTACT,
    EPS,
    FORCE,
    LIMIT,
    NO_RATES,
    POLE,
    SOUND,
    STEP,
    Numbers,
    parameters_of,
    refill,
    table,
)
from woodpecker.mechanics.toy import INFINITESIMAL, RESTITUTIONS, Toy, is_possible, known_parameter
from woodpecker.motion.codes import NO_PATH, RETURNED
from woodpecker.simulation.calls import NO_TIMES, sweep
from woodpecker.simulation.paths import Follower, Path, cause_of

if TYPE_CHECKING:
    from pwmap import PiecewiseLinearMap

KEPT = 8  # most maps whose copies, sent by other processes, share tables: one for each search
OWN_VALUES = "a toy has its own values, toy.replace(...) others, and a map takes its parameter as p"
PATH_ENDS = "the path does not reach so far"

Values = tuple[tuple[str, float], ...]
"""Names and values of parameters that differ from a toy's own; the last is the one that varies."""

NO_VALUES: Values = ()


class _ThreadRoom:
    """The numbers of a toy for the kernel, their rates, and a follower, for one thread."""

    def __init__(self, toy: Toy, rates: Mapping[str, float]) -> None:
        self._toy, self._values, self._known = toy, NO_VALUES, dict[str, float]()
        steps = np.array([rates.get(name, 0.0) for name in Numbers._fields]) * STEP
        self._complex = parameters_of(toy) + 1j * steps
        self._numbers: Floats = table(toy)
        self._rates: Floats = np.zeros(CHANGE)
        self._change = self._rates if steps.any() else NO_RATES
        self._seed: Floats = np.array([[rates.get(name, 0.0) for name in RESTITUTIONS]])
        self.follower = Follower(self._numbers, self._change, self._seed)

    def _take(self, values: Values) -> None:
        """Set the parameters to other values; ValueError if the toy cannot have them."""
        if values == self._values and self._numbers[FORCE, SOUND]:
            return
        changes, before, due = dict(values), self._known, False
        if not is_possible(self._toy, changes):
            there = self._toy.replace(**changes)
            changes = {name: getattr(there, name) for name in changes}
        for name in before.keys() - changes.keys():  # back at the toy's own value
            due |= self._put(name, getattr(self._toy, name))
        for name, value in changes.items():
            if value != before.get(name):
                due |= self._put(name, value)
        self._values, self._known = values, changes
        if due:
            refill(self._complex, self._numbers, self._rates)
        if not self._numbers[FORCE, SOUND]:
            raise unsound(self._toy.replace(**dict(values)))

    def _put(self, name: str, value: float) -> bool:
        """Set one parameter; whether the table of the equations of motion must be refilled."""
        if name in Numbers._fields:
            self._complex.real[Numbers._fields.index(name)] = value
            return True
        if name in RESTITUTIONS:
            k, follower = RESTITUTIONS.index(name), self.follower
            if value == 0.0 and self._seed[0, k] != 0.0:
                value = INFINITESIMAL
            faint = {*follower.faint, k} if value == INFINITESIMAL else {*follower.faint} - {k}
            follower.faint = tuple(faint)
            self._numbers[CONTACT + k, EPS] = value
        else:
            self._numbers[FORCE, POLE] = value
        return False

    def obstacle(self, x: float, values: Values) -> str:
        """Set the parameters, and say why the toy cannot start from x; empty if it can."""
        try:
            self._take(values)
        except ValueError as error:
            return str(error)
        if not math.isfinite(x):
            return f"phi_s must be finite, got {x}"
        return "" if x < self._numbers[CONTACT, LIMIT] else "the beak touches the pole"

    def sweep(self, x: Floats, values: Values) -> Sweep:
        """Images and slopes at points (n,), or nan; ValueError for values that no toy can have."""
        self._take(values)
        self.follower.restore(0.0)
        out, codes, _, _ = sweep(self._numbers, self._change, x, 1, self._seed)
        self.follower.restore(INFINITESIMAL)
        starts = np.isfinite(x) & (x < self._numbers[CONTACT, LIMIT])
        out[(codes > RETURNED) | ~starts] = math.nan
        return Sweep(out[:, 0], out[:, 3])


class PerThread(threading.local):
    """The state of a map that each thread keeps between calls; copies start without it."""

    room: _ThreadRoom | None = None


@dataclass(frozen=True, slots=True)
class ToyPieces:
    """P_1 of the toy as a piecewise-smooth map; it can be pickled, and shared by threads.

    Parameters
    ----------
    toy, parameter
        The toy, and its parameter that varies, whose own value does not matter.

    Raises
    ------
    TypeError
        If ``toy`` is of another type, or the parameter is unknown.

    Examples
    --------
    >>> from woodpecker import Toy, ToyPieces
    >>> image = ToyPieces(Toy(), "eps_n1").at(-0.53, 0.5)
    >>> round(image.value, 9), round(image.slope, 6), round(image.d_parameter, 6)
    (-0.529030292, -0.833817, 0.250721)
    """

    margins_decide: ClassVar[bool] = True  # the toy takes a path exactly where its margins are > 0
    toy: Toy
    parameter: str = "eps_n1"
    _held: Values = field(default=NO_VALUES, init=False, repr=False)
    # On a line of toys the rates at which parameters change, from the toy's own values on.
    _along: Values = field(default=NO_VALUES, init=False, repr=False)
    _cache: PerThread = field(default_factory=PerThread, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        instance("toy", self.toy, Toy)
        known_parameter(self.parameter)

    def __reduce__(self) -> tuple[Callable[..., ToyPieces], tuple[Toy, str, Values, Values]]:
        return _same, (self.toy, self.parameter, self._held, self._along)

    def holding(self, **values: float) -> ToyPieces:
        """The map with other parameters held at other values, in SI units; it shares these tables.

        If the toy cannot have these values the map has no images. TypeError if a parameter is
        unknown, or is the one that varies.
        """
        for name in values:
            if known_parameter(name) == self.parameter:
                raise TypeError(f"{name} varies: it cannot be held at {values[name]}")
        map_ = ToyPieces(self.toy, self.parameter)
        object.__setattr__(map_, "_held", tuple(values.items()))
        object.__setattr__(map_, "_cache", self._cache)
        return map_

    @property
    def rates(self) -> Mapping[str, float]:
        """The rates of parameters: 1 for the one that varies; on a line of toys those given."""
        return dict(self._along) or {self.parameter: 1.0}

    def _values(self, p: float) -> Values:
        """The parameters that differ from the toy's own, at a value of the one that varies."""
        if self._along:
            return tuple((name, getattr(self.toy, name) + p * by) for name, by in self._along)
        return *self._held, (self.parameter, p)

    def at(self, x: float, p: float) -> Image:
        """The return from x [rad] along the path that the toy takes at p, or a reason why none."""
        x, p = _numbers(x, p)
        follower, obstacle = self.ready(x, p)
        if not obstacle:
            status, path, _ = follower.trace(x)
            if status.success:
                return _image(self, path, follower, x, p)
            obstacle = status.value
        return no_image(ToyPiece(self, Path(obstacle, NO_PATH, NO_TIMES)), obstacle)

    def ready(self, x: float, p: float) -> tuple[Follower, str]:
        """The follower with the numbers of p; why the toy cannot start at x, empty if it can."""
        room = self.room()
        return room.follower, room.obstacle(x, self._values(p))

    @property
    def evaluations(self) -> int:
        """The number of single returns that this thread has computed, by search or along a path."""
        return self.room().follower.evaluations

    def room(self) -> _ThreadRoom:
        """The tables and the follower of this thread."""
        if self._cache.room is None:
            self._cache.room = _ThreadRoom(self.toy, self.rates)
        return self._cache.room

    def taken(self, x: float, p: float) -> tuple[bytes, float]:
        """The key of the piece that the toy takes at x [rad], and the kernel's image [rad] of x."""
        x, p = _numbers(x, p)
        follower, obstacle = self.ready(x, p)
        if obstacle:
            return NO_PATH.tobytes(), math.nan
        status, path, value = follower.trace(x)
        if follower.faint and status.success:
            value = _image(self, path, follower, x, p).value
        return (path.steps if status.success else NO_PATH).tobytes(), value

    def sweep(self, x: Floats, p: float | Floats) -> Sweep:
        """Images [rad] and slopes [-] at many points (n,) [rad], with one parameter or one each.

        They are nan where the toy cannot start or does not return; ValueError if it cannot have a
        value of the parameter.
        """
        points = real_array("x", x).ravel()
        if np.ndim(p) == 0:
            return self.room().sweep(points, self._values(number("p", p)))
        each = np.broadcast_to(real_array("p", p), points.shape)
        values, which = np.unique(each, return_inverse=True)
        found = np.empty((2, len(points)))
        for k, value in enumerate(values.tolist()):  # the tables are filled once for each value
            found[:, which == k] = self.room().sweep(points[which == k], self._values(value))
        return Sweep(*found)


@lru_cache(maxsize=KEPT)
def _same(toy: Toy, parameter: str, held: Values, along: Values) -> ToyPieces:
    """The one copy of a map in this process, whose tables all its pieces share."""
    if along:
        return line_of_toys(toy, dict(along))
    return ToyPieces(toy, parameter).holding(**dict(held))


def line_of_toys(toy: Toy, rates: Mapping[str, float]) -> ToyPieces:
    """P_1 over a line of toys, as a piecewise-smooth map of (phi_S, distance from the toy).

    Parameters change at ``rates``: one complex step along the line gives all derivatives at the
    cost of a single parameter. TypeError for unknown ones, ValueError for the pole's length.
    """
    for name in rates:
        if known_parameter(name) == "pole":
            raise ValueError("a line must leave the pole as it is, got a rate of its length")
    map_ = ToyPieces(toy)
    object.__setattr__(map_, "_along", tuple(rates.items()))
    return map_


class ToyPiece(NamedTuple):
    """A piece of P_1: the returns along one path of events."""

    whole: ToyPieces  # the map that the piece belongs to
    # Its events, with the durations of the last return. Where the toy does not return the path has
    # no phases, and the reason as its word.
    path: Path

    @property
    def word(self) -> str:
        """The sequence of events, or why the toy does not return."""
        return self.path.word

    @property
    def key(self) -> bytes:
        """The identity of the piece: keys are equal if and only if the pieces are the same."""
        return self.path.steps.tobytes()

    def at(self, x: float, p: float) -> Image:
        """The return from phi_S = x [rad] along this path, even where the toy takes another one."""
        follower, obstacle = self.whole.ready(x, p)
        if obstacle or not len(self.path.steps):
            return no_image(self, obstacle or self.word)
        return _image(self.whole, self.path, follower, x, p)

    def duration(self, x: float, p: float) -> tuple[float, float]:
        """Period [s] and drop [m] of the return from x [rad] along this path; nan if none."""
        follower, obstacle = self.whole.ready(x, p)
        found = None if obstacle or not len(self.path.steps) else follower.follow(self.path, x)
        return (math.nan, math.nan) if found is None else (found.period, found.drop)

    def cause(self, code: int) -> str:
        """A sentence on what happens where a margin vanishes."""
        return cause_of(self.path, code)


def durations(images: Iterable[Image], x: Iterable[float], p: float) -> tuple[float, float]:
    """Total period [s] and drop [m] of the returns from points [rad], each along its own path."""
    each = [
        image.piece.duration(float(place), p)
        for image, place in zip(images, x, strict=True)
        if isinstance(image.piece, ToyPiece)
    ]
    return sum(period for period, _ in each), sum(drop for _, drop in each)


def _numbers(x: float, p: float) -> tuple[float, float]:
    """Both as floats, for the compiled kernel; ValueError unless they are real numbers."""
    if isinstance(x, float) and isinstance(p, float):
        return x, p
    return number("x", x), number("p", p)


def _image(map_: ToyPieces, path: Path, follower: Follower, x: float, p: float) -> Image:
    """The return along a path by a follower that has the numbers of p."""
    found = follower.follow(path, x)
    if found is None or not math.isfinite(found.phi_s):
        return no_image(ToyPiece(map_, path), PATH_ENDS)
    piece = ToyPiece(map_, Path(path.word, path.steps, found.times))
    return Image(
        found.phi_s, found.slope, found.d_parameter, found.margins, found.gradients, found.causes,
        piece,
    )  # fmt: skip


# --- Arguments of users ---------------------------------------------------------------------------


def map_and_names(
    source: Toy | PiecewiseMap | PiecewiseLinearMap, parameter: str | None = None
) -> tuple[PiecewiseMap, str, str]:
    """A toy (by default over eps_n1) or map as a map of pieces, with its parameter and coordinate.

    TypeError if the source is neither a toy nor a map, or the parameter is unknown; ValueError
    unless an exact map has one parameter, or if a map's own parameter has another name.
    """
    if isinstance(source, Toy):
        name = "eps_n1" if parameter is None else parameter
        return ToyPieces(source, name), name, "phi_s"
    from pwmap import PiecewiseLinearMap
    from woodpecker.maps.symbolic import from_pwmap

    if not isinstance(source, PiecewiseLinearMap):
        if not callable(getattr(source, "at", None)):
            raise TypeError(
                "source must be woodpecker.Toy or a map of pieces, such as FormulaMap([...]), got "
                f"{shown(source)}"
            )
        if isinstance(of := getattr(source, "d", None), int):  # a system's: its points are arrays
            raise TypeError(
                f"source must be a map of the line, got {type(source).__name__} of "
                f"{counted(of, 'coordinate')}: woodpecker.systems has this verb for it"
            )
        if hasattr(source, "beside"):
            raise TypeError(
                f"source must be a map of the line, got {type(source).__name__}: "
                "woodpecker.from_sympy makes those from formulas, and "
                "woodpecker.search.connected.connected follows maps of several dimensions"
            )
        return source, *axes_of(source, parameter)
    names = [str(symbol) for symbol in source.parameters]
    if parameter is None and len(names) != 1:
        raise ValueError(f"a map must have one parameter, got {names}: give the others values")
    name = names[0] if parameter is None else parameter
    return from_pwmap(source, name), name, str(source.x)


def axes_of(source: object, parameter: str | None) -> tuple[str, str]:
    """The names of a map's parameter and coordinate; errors are those of :func:`map_and_names`."""
    own = getattr(source, "names", None)
    x, p = own or ("x", "p")
    name = p if parameter is None else parameter
    if not isinstance(name, str):
        raise TypeError(f"parameter must be what its axis is called, got {shown(name)}")
    if own is not None and name != p:
        raise ValueError(f"{name!r} is no parameter of this map, it has {p!r}")
    return name, x


def value_of(source: object, p: float | None) -> float:
    """The parameter of a map, or eps_n1 of a toy; ValueError if p is missing or not wanted."""
    if isinstance(source, Toy):
        if p is not None:
            raise ValueError(f"a toy has its own values: toy.replace(eps_n1={p!r}) has another one")
        return source.eps_n1
    if p is None:
        raise ValueError("p is needed: a map has no value of its parameter")
    value = number("p", p)
    if not math.isfinite(value):
        raise ValueError(f"p must be finite, got {value}")
    checked(source, value)
    return value


def checked(source: object, p: float) -> None:
    """ValueError if a map cannot have a value p, as its own method ``check`` says if it has one."""
    check = getattr(source, "check", None)
    if callable(check):
        check(p)


class Mapped(NamedTuple):
    """A source as it was given, its map, and the value of the parameter."""

    source: Toy | PiecewiseMap | PiecewiseLinearMap
    map_: PiecewiseMap
    p: float

    def at(self, x: float) -> Image:
        """The image of a point."""
        return self.map_.at(x, self.p)


def mapped_at(source: Toy | PiecewiseMap | PiecewiseLinearMap, p: float | None) -> Mapped:
    """A source at a value of its parameter; see :func:`map_and_names`, :func:`value_of`."""
    map_, *_ = map_and_names(source)
    return Mapped(source, map_, value_of(source, p))
