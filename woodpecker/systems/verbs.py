"""The functions that a user calls: simulate, return_map, shoot, continuation of any system."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import islice, product
from typing import Any

import numpy as np
import numpy.typing as npt

from pwmap.algebra.arguments import explained
from pwmap.diagrams.data import UNDECIDED, attracting, is_neutral
from pwmap.diagrams.frames import DataFrame, dataframe
from pwmap.diagrams.shown import brief, counted, listed
from woodpecker.base.arrays import Floats
from woodpecker.base.checks import instance, interval, iterates, number, positive, real_array, whole
from woodpecker.base.progress import Report
from woodpecker.base.settings import EVALUATIONS
from woodpecker.base.shown import shown
from woodpecker.engine.curves import CurveSettings
from woodpecker.engine.maps import SpaceImage, chained
from woodpecker.search.connected import Connected, connected
from woodpecker.search.tasks import StopRule
from woodpecker.systems.mechanics.model import ContactSystem, no_inertia
from woodpecker.systems.mechanics.status import MotionStatus
from woodpecker.systems.returns import SystemMap
from woodpecker.systems.simulation.flows import Step
from woodpecker.systems.simulation.motion import (
    Backend,
    MotionEvent,
    Run,
    assembled,
)
from woodpecker.systems.simulation.sections import touching

SAMPLES = 1001  # of a motion, unless the caller says otherwise
CURVE = 9  # samples of a step, at least, so that short flights are drawn as curves
EVENTS_MOST, COUNTED_MOST = 20_000, 10**6
NEWTON_MOST = 50  # iterations of shooting
HALVINGS_MOST = 12  # of one Newton step
CONVERGED = 1e-12  # relative residual of a cycle, over the amplification of rounding; below it
# steps go on as long as they halve the residual, as scales need not be the lengths of the system
ORDER_MOST = 100

HELD = "map_.holding(...) has other values of parameters"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Motion:
    """A motion of a system.

    Attributes
    ----------
    t, q, u
        Samples: times (s,) [s], coordinates and velocities (s, n). Times of events occur twice,
        before and after, as those of accumulating impacts, whose last laps are one straight line.
    events, word
        Its events in order of time, and their symbols.
    status, z, names
        Why it ended; (2n + 1,) its last state, and the names of that: time is the last.
    """

    t: Floats
    q: Floats
    u: Floats
    events: tuple[MotionEvent, ...]
    word: str
    status: MotionStatus
    z: Floats
    names: tuple[str, ...]

    def to_dataframe(self) -> DataFrame:
        """The samples, one in each row, as a pandas.DataFrame; ImportError without pandas."""
        *names, time = self.names
        states = zip(names, (*self.q.T, *self.u.T), strict=True)
        return dataframe({time: self.t, **dict(states)})

    def events_to_dataframe(self) -> DataFrame:
        """The events, with velocities such as ``u_x_before``; ImportError without pandas."""
        names = self.names[len(self.names) // 2 : -1]
        columns: dict[str, Any] = {
            self.names[-1]: np.array([event.time for event in self.events]),
            "event": [event.symbol for event in self.events],
        }
        for side in ("before", "after"):
            speeds = np.reshape([getattr(event, side) for event in self.events], (-1, len(names)))
            columns |= {f"{name}_{side}": own for name, own in zip(names, speeds.T, strict=True)}
        return dataframe(columns)

    def __repr__(self) -> str:
        """Its duration, its events, and why it ended."""
        return (
            f"Motion(t={self.t[0]:.6g} to {self.t[-1]:.6g}, {counted(len(self.t), 'sample')}, "
            f"{counted(len(self.events), 'event')} {brief(self.word)!r}, {self.status.value!r})"
        )


@explained("system.replace(...) has other values of parameters")
def simulate(
    system: ContactSystem, start: Mapping[Any, float], t_end: float, *, samples: int = SAMPLES,
    max_events: int = EVENTS_MOST, backend: Backend | str | None = None,
) -> Motion:  # fmt: skip
    """Follow a system from a state until a time.

    Parameters
    ----------
    system
        The system.
    start
        Values of symbols of the state, by symbol or by name; the others are zero.
    t_end
        Final time [s], after that of the start.
    samples, max_events
        Number of evenly spaced samples, and limit on the number of events.
    backend
        ``"heyoka"`` or ``"scipy"``; by default the first if it is installed.

    Returns
    -------
    Motion
        It ends before ``t_end`` where the contact laws leave open what follows, or contacts hold
        the system for ever; the status says so.

    Raises
    ------
    TypeError
        If it is no system, or the start no mapping.
    ValueError
        If a symbol is unknown, a value not finite, a contact penetrated, or M not positive definite
        at the start.

    Examples
    --------
    >>> from sympy import symbols
    >>> from woodpecker.systems import Contact, ContactSystem, simulate
    >>> y, g = symbols("y g")
    >>> floor = Contact(name="floor", gap=y, eps_n=0.5)
    >>> ball = ContactSystem([y], [[1]], [-g], [floor], {g: 10.0})
    >>> motion = simulate(ball, {"y": 5.0}, 5.0)  # it rests after 1 + 2 s
    >>> motion.word, motion.status.name, round(motion.events[-1].time, 12)
    ('C1', 'AT_REST', 3.0)
    """
    instance("system", system, ContactSystem)
    eq = assembled(system, (), backend)
    z = state_of(system, start)
    t_end = number("t_end", t_end)
    if not z[-1] < t_end < math.inf:
        raise ValueError(f"t_end must lie after the start at t = {z[-1]}, got {t_end}")
    samples = whole("samples", samples, 2, COUNTED_MOST)
    most = whole("max_events", max_events, 1, COUNTED_MOST)
    if why := no_inertia(eq.terms(z, eq.p).mass):
        raise ValueError(f"{why} at the start")
    touch, striking = touching(eq, z, eq.p)
    run = Run(eq, z, eq.p, t_end=t_end, events_most=most, keeps=True).follow(touch, striking)
    t, states = _sampled(z, run.z, run.steps, samples)
    n = system.n
    return Motion(
        t=t, q=states[:, :n], u=states[:, n : 2 * n], events=tuple(run.events),
        word=" ".join(run.symbols), status=run.status, z=run.z,
        names=tuple(map(str, system.state)),
    )  # fmt: skip


def state_of(system: ContactSystem, start: Mapping[Any, float]) -> Floats:
    """A state (2n + 1,) from values by symbol or name; ValueError if one is unknown."""
    if not isinstance(start, Mapping):
        raise TypeError(f"start must be a mapping of symbols to values, got {shown(start)}")
    known = {str(symbol): k for k, symbol in enumerate(system.state)}
    z = np.zeros(len(known))
    for key, value in start.items():
        if str(key) not in known:
            raise ValueError(f"start has {str(key)!r}, the state has {list(known)}")
        if [str(each) for each in start].count(str(key)) > 1:
            raise ValueError(f"start has {str(key)!r} twice, as a symbol and as a name")
        z[known[str(key)]] = number(str(key), value)
    if not np.isfinite(z).all():
        raise ValueError(f"start must be finite, got {dict(start)}")
    return z


def _sampled(
    first: Floats, last: Floats, steps: Sequence[tuple[float, Step]], samples: int
) -> tuple[Floats, Floats]:
    """Times and states of samples: evenly spaced, and where each step begins and ends."""
    grid = np.linspace(first[-1], last[-1], samples)
    times, states = [np.array([first[-1]])], [first[None]]
    ends = [*(begin for begin, _ in steps[1:]), float(last[-1])][: len(steps)]
    for (begin, step), end in zip(steps, ends, strict=True):
        inside = grid[(grid > begin) & (grid < min(end, begin + step.length))]
        count = CURVE if step.guards.size else 2  # without guards: accumulating impacts, too short
        curve = np.linspace(begin, min(end, begin + step.length), count)
        at = np.concatenate([curve[:1], np.union1d(inside, curve[1:-1]), curve[-1:]])
        times.append(at)
        states.append(step.states(at - begin))
    times.append(np.array([last[-1]]))
    states.append(last[None])
    return np.concatenate(times), np.concatenate(states)


# --- Return maps ----------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SystemReturns:
    """Returns from many points of a section.

    Attributes
    ----------
    x, images
        (s, d) the points and their images; nan where they do not return.
    words, status
        The sequence of events of each return, and why it ended.
    """

    x: Floats
    images: Floats
    words: tuple[str, ...]
    status: tuple[MotionStatus, ...]


@explained(HELD)
def return_map(
    map_: SystemMap, x: npt.ArrayLike, *, order: int = 1, p: npt.ArrayLike | None = None
) -> SystemReturns:
    """Returns from many points of a section, without derivatives.

    Parameters
    ----------
    map_
        The return map of a system.
    x
        (s, d) points, or (s,) if d = 1.
    order
        Number of returns in turn.
    p
        (k,) values of the free parameters; by default those of the system.

    Returns
    -------
    SystemReturns
        Images, words and statuses.

    Raises
    ------
    TypeError
        If ``map_`` is no return map.
    ValueError
        If shapes do not fit, or ``order`` is no positive whole number.
    """
    instance("map_", map_, SystemMap)
    order = whole("order", order, 1, ORDER_MOST)
    points, values = points_of(map_, "x", x), parameters_of(map_, p)
    found = [list(islice(map_.orbit(point, values), order)) for point in points]
    return SystemReturns(
        x=points, images=np.array([runs[-1].point for runs in found]).reshape(points.shape),
        words=tuple(" | ".join(" ".join(run.symbols) for run in runs) for runs in found),
        status=tuple(runs[-1].status for runs in found),
    )  # fmt: skip


def points_of(map_: SystemMap, name: str, given: npt.ArrayLike) -> Floats:
    """Points (s, d), from an array of these, or (s,) if d = 1."""
    points = real_array(name, given)
    points = points.reshape(-1, 1) if points.ndim < 2 and map_.d == 1 else np.atleast_2d(points)
    if points.ndim != 2 or points.shape[1] != map_.d:
        raise ValueError(f"{name} must have shape (s, {map_.d}), got {points.shape}")
    return points


def parameters_of(map_: SystemMap, p: npt.ArrayLike | None) -> Floats:
    """Checked values (k,) of the free parameters; by default the system's own."""
    if p is None:
        return map_.p
    values = np.atleast_1d(real_array("p", p))
    if values.shape != (map_.k,):
        raise ValueError(f"p must have shape ({map_.k},), got {values.shape}")
    if not np.isfinite(values).all():
        raise ValueError(f"p must be finite, got {values.tolist()}")
    map_.check_laws(values)
    return values


def spans_of(
    map_: SystemMap, spans: Sequence[tuple[float, float]]
) -> tuple[tuple[float, float], ...]:
    """Ends of the first free parameters; ValueError if the contact laws rule out one of them."""
    found = tuple(interval("span", each) for each in spans)
    for ends in product(*found):
        map_.check_laws(np.array([*ends, *map_.p[len(ends) :]])[: map_.k])
    return found


class CycleStatus(Enum):
    """How shooting ended; the value is the sentence a user reads."""

    CONVERGED = "a periodic solution was found"
    NOT_CONVERGED = "no periodic solution was found from this guess"
    LOST = "a start on the way does not return to the section"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SystemCycle:
    """A periodic solution, as a cycle of a return map.

    Attributes
    ----------
    x, p
        (order, d) its points, one for each return; (k,) values of the free parameters.
    period
        Time [s] of all these returns together, after which the motion repeats.
    multipliers
        (d,) of the whole cycle, the largest first.
    word
        The sequence of events; ``|`` separates returns.
    residual
        Distance of the last image from the first point, in units of the scales.
    status, message
        Whether it was found, and a sentence on why not, or on why its stability is undecided.
    """

    x: Floats
    p: Floats
    period: float
    multipliers: npt.NDArray[np.complex128]
    word: str
    residual: float
    status: CycleStatus
    message: str

    @property
    def success(self) -> bool:
        """Whether the cycle was found."""
        return self.status is CycleStatus.CONVERGED

    @property
    def stable(self) -> bool:
        """Whether all multipliers lie inside of the unit circle, by more than rounding."""
        return bool(self.success and attracting(self.multipliers).all())


@explained(HELD)
def shoot(
    map_: SystemMap, guess: npt.ArrayLike, *, order: int = 1, p: npt.ArrayLike | None = None,
    transient: int = 0,
) -> SystemCycle:  # fmt: skip
    """Find a cycle near a guess by Newton's method; the word may change on the way.

    Parameters
    ----------
    map_
        The return map of a system.
    guess
        (d,) first point of the cycle.
    order
        Number of returns after which it closes.
    p
        (k,) values of the free parameters; by default those of the system.
    transient
        Number of returns from ``guess`` before Newton's method begins.

    Returns
    -------
    SystemCycle
        Its ``message`` says whether it was found, and if not, why.

    Raises
    ------
    TypeError
        If ``map_`` is no return map.
    ValueError
        If shapes do not fit, ``order`` is no positive whole number, or the cycle returns in another
        state than the section has, so that more of its symbols must be free.
    """
    instance("map_", map_, SystemMap)
    order = whole("order", order, 1, ORDER_MOST)
    x = np.atleast_1d(real_array("guess", guess))
    if x.shape != (map_.d,):
        raise ValueError(f"guess must have shape ({map_.d},), got {x.shape}")
    if not np.isfinite(x).all():
        raise ValueError(f"guess must be finite, got {x.tolist()}")
    values, scale = parameters_of(map_, p), np.array(map_.x_scale)
    for run in islice(map_.orbit(x, values), whole("transient", transient, least=0)):
        x = run.point if run.status.success else x  # from there, the next line says what is lost
    images, lost = _images(map_, x, values, order)
    if lost:
        return _cycle(map_, x, values, [], CycleStatus.LOST, lost)
    status = CycleStatus.NOT_CONVERGED
    for _ in range(NEWTON_MOST):
        whole_ = chained(images)
        away = whole_.value - x
        jacobian = whole_.jacobian[:, : map_.d]
        sensitive = 1.0 + float(np.abs(jacobian * scale / scale[:, None]).max())
        size, far = float(np.abs(away / scale).max()), max(1.0, float(np.abs(x / scale).max()))
        step = np.asarray(np.linalg.lstsq(np.eye(map_.d) - jacobian, away)[0], dtype=float)
        if size <= CONVERGED * sensitive * far:
            status = CycleStatus.CONVERGED
            if size == 0.0:
                break
            better, lost = _images(map_, x + step, values, order)
            if lost or np.abs((better[-1].value - x - step) / scale).max() > 0.5 * size:
                break
            x, images = x + step, better
            continue
        found, lost = _damped(map_, x, values, order, step, size)
        if found is None:
            return _cycle(map_, x, values, images, CycleStatus.LOST, lost)
        x, images = found
    if status is CycleStatus.CONVERGED:
        map_.check_section(x, values)
    return _cycle(map_, x, values, images, status)


def window_of(
    map_: SystemMap, window: Sequence[tuple[float, float]]
) -> tuple[tuple[float, float], ...]:
    """Two ends of each coordinate; ValueError unless there are d of them."""
    if np.shape(window) != (map_.d, 2):
        raise ValueError(
            f"window must have shape ({map_.d}, 2), two ends of each coordinate, got "
            f"{shown(window)}"
        )
    return tuple(interval("window", each) for each in window)


def _images(map_: SystemMap, x: Floats, p: Floats, order: int) -> tuple[list[SpaceImage], str]:
    """The images in turn, up to the first without a value, and where and why that has none."""
    found = list[SpaceImage]()
    for _ in range(order):
        image = map_.at(x, p)
        if image.reason:
            pairs = zip(map_.section.free, x.tolist(), strict=True)
            start = listed(f"{symbol} = {value:.6g}" for symbol, value in pairs)
            return found, f"from {start}, {image.reason}"
        found.append(image)
        x = image.value
    return found, ""


def _damped(
    map_: SystemMap, x: Floats, p: Floats, order: int, step: Floats, before: float
) -> tuple[tuple[Floats, list[SpaceImage]] | None, str]:
    """Halve a Newton step until the residual falls; if it never does, take the longest step."""
    # Only steps that return count; if there is none, the reason is that of the shortest.
    first, lost = None, ""
    for k in range(HALVINGS_MOST):
        there = x + step / 2**k
        images, lost = _images(map_, there, p, order)
        if lost:
            continue
        first = first or (there, images)
        if np.abs((images[-1].value - there) / map_.x_scale).max() < before:
            return (there, images), ""
    return first, lost


def _cycle(
    map_: SystemMap, x: Floats, p: Floats, images: Sequence[SpaceImage], status: CycleStatus,
    detail: str = "",
) -> SystemCycle:  # fmt: skip
    points, word, residual, period = [x], "", math.nan, math.nan
    multipliers = np.full(map_.d, np.nan, dtype=complex)
    if images:
        last = chained(list(images))
        found = np.linalg.eigvals(last.jacobian[:, : map_.d]).astype(complex)
        multipliers, word = found[np.argsort(-np.abs(found))], last.piece.word
        points += [image.value for image in images[:-1]]
        residual = float(np.abs((last.value - x) / map_.x_scale).max())
    if status is CycleStatus.CONVERGED:
        period = math.fsum(map_.duration(point, p) for point in points)
        detail = UNDECIDED if is_neutral(multipliers) else detail
    return SystemCycle(
        x=np.array(points), p=p, period=period, multipliers=multipliers, word=word,
        residual=residual, status=status,
        message=f"{status.value}: {detail}" if detail else status.value,
    )  # fmt: skip


@explained(HELD)
def continuation(
    map_: SystemMap, cycle: SystemCycle, span: tuple[float, float],
    window: Sequence[tuple[float, float]], *, orders: Sequence[int] = (1, 2), step: float = 0.005,
    min_step: float = 1e-9, max_step: float = 0.02, max_branches: int = 500,
    max_evaluations: int = EVALUATIONS, stop: StopRule | None = None,
    progress: Report | None = None, on_interrupt: Callable[[], None] | None = None,
) -> Connected:  # fmt: skip
    """Follow a cycle over the first free parameter, and all branches connected with it.

    Parameters
    ----------
    map_
        The return map of a system, of d coordinates.
    cycle
        A cycle of the map; it is followed with its minimal period.
    span
        Ends of the parameter.
    window
        (d, 2) ends of the coordinates.
    step, min_step, max_step
        First, shortest and longest step, as fractions of the lengths of span and window, or in
        units of the scales that the map was given.
    orders, max_branches, max_evaluations, stop, progress, on_interrupt
        As for :func:`woodpecker.search.connected.connected`.

    Returns
    -------
    Connected
        The ``diagram`` of branches and special points, and the ``orbits`` at these.

    Raises
    ------
    TypeError
        As there, or if ``map_`` is no return map, or ``cycle`` no cycle.
    ValueError
        If the map has no free parameter, the cycle was not found, an interval is empty, or friction
        or restitution is out of range at an end of the span.
    """
    instance("map_", map_, SystemMap)
    instance("cycle", cycle, SystemCycle)
    wanted = iterates(orders)
    if not map_.k:
        raise ValueError("the map has no free parameter to be followed over")
    if not cycle.success:
        raise ValueError(f"there is no cycle to be followed: {cycle.message}")
    settings = CurveSettings(
        spans=spans_of(map_, [span]), step=positive("step", step), max_step=max_step,
        window=window_of(map_, window), min_step=min_step,
    )  # fmt: skip
    map_ = map_.within(settings.window, settings.spans)
    return connected(
        map_, cycle.x, cycle.p, settings, orders=wanted, x_scale=map_.x_scale,
        p_scale=map_.p_scale, names=(map_.parameters[0], *map(str, map_.section.free)),
        max_branches=max_branches, max_evaluations=max_evaluations, stop=stop, progress=progress,
        on_interrupt=on_interrupt,
    )  # fmt: skip
