"""The diagram of what hangs together with one periodic motion of the toy."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from pwmap.diagrams.diagram import Diagram, PointKind, PointStatus, SpecialPoint
from woodpecker.base.checkpoint import START, Entry
from woodpecker.base.checks import interval
from woodpecker.base.executors import Serial
from woodpecker.engine.checkpoint import Record, read_record, restore
from woodpecker.engine.network import Network
from woodpecker.engine.orbits import Closed, Coordinate, Orbit, orbit_of, solve
from woodpecker.engine.search import Explorer, Stage
from woodpecker.engine.settings import Settings
from woodpecker.engine.stepping import StopRule
from woodpecker.engine.tasks import Tasks, Worker
from woodpecker.mechanics.toy import Toy, limits
from woodpecker.shooting import PeriodicOrbit
from woodpecker.simulation.returns import RESTITUTIONS
from woodpecker.toypieces import ToyPieces

WINDOW = (-2.5, -0.24)  # left of the band of centres [rad]
SMALLEST = 1e-9  # where a branch starts that would start at zero restitution
DEFAULT = Settings(window=WINDOW)
OUT_OF_DOMAIN = "end of the values that the parameter can have"
AT, SPAN = "at", "span"  # of a run: the toy's value of the parameter; the span that was asked for


def continuation(
    toy: Toy,
    orbit: PeriodicOrbit,
    parameter: str = "eps_n1",
    span: tuple[float, float] = (0.0, 1.0),
    *,
    settings: Settings | None = None,
    stop: StopRule | None = None,
    progress: Callable[[Stage], None] | None = None,
    run: str | os.PathLike[str] | None = None,
    resume: bool = False,
) -> Diagram:
    """Follow a periodic solution both ways, and every branch that is connected to it.

    Parameters
    ----------
    toy
        The toy; its value of ``parameter`` is where the orbit lives.
    orbit
        A periodic solution of it, from :func:`woodpecker.shoot`. It is followed with its minimal
        period, also where a multiple of that was shot for.
    parameter, span
        Parameter of the toy and its interval. Where the toy cannot have all of these values,
        branches end at the last that it can have.
    settings
        Steps, window and tolerances, a :class:`woodpecker.engine.settings.Settings`; the span is
        taken from ``span``. By default the window is (-2.5, -0.24) rad.
    stop
        A rule that ends branches, such as ``lambda state: abs(state.multiplier) > 5``. It is asked
        at every sample, with a :class:`woodpecker.BranchState`; where it comes to be true the
        branch ends (EP, "stopped as asked"), a place that is bracketed to rounding, and nothing
        that begins beyond is followed.
    progress
        Called with every branch that is finished.
    run
        A file that keeps every finished branch, so that an interrupted run can go on.
    resume
        Go on with the run in that file. It does not keep ``stop``: a rule that is wanted is given
        again.

    Returns
    -------
    Diagram
        Fixed-point and jump branches of P_j with their special points, j being the minimal period
        of the orbit; ``given`` says under which law of impact, and how derivatives in the parameter
        were found.

    Raises
    ------
    ValueError
        If the orbit did not converge or is one of another toy, span or window do not hold it, or
        there is no such run to resume.
    TypeError
        If the parameter is unknown, or the settings are none of this engine.
    """
    if not orbit.success:
        raise ValueError(f"continuation needs a periodic solution, got one with: {orbit.message}")
    if orbit.toy != toy:
        raise ValueError("continuation needs an orbit of this toy, got one of another toy")
    if not isinstance(settings, Settings | None):
        raise TypeError(
            "settings must be those of woodpecker.engine.settings, "
            f"got {type(settings).__module__}.{type(settings).__name__}"
        )
    map_ = ToyPieces(toy, parameter)
    wanted = interval("span", span, finite=True)
    chosen = replace(settings or DEFAULT, span=possible(toy, parameter, wanted))
    start = _start(map_, orbit, chosen)
    about = {SPAN: wanted} | _about(toy, parameter, chosen) | {START: orbit.points}
    with _record(run, about, resume) as record:
        explorer = Explorer(
            Serial(Worker(map_, chosen, stop)), chosen, (len(start),), progress or _nothing, record
        )
        if record is not None and record.entries:
            assert run is not None
            restore(explorer.network, record.entries, map_, run)
            explorer.go_on()
        else:
            explorer.follow(Tasks.cycle, start)
    return _finished(explorer.network, toy, parameter, wanted)


def saved_continuation(run: str | os.PathLike[str]) -> Diagram:
    """The branches that a run of :func:`continuation` has finished so far.

    Raises
    ------
    ValueError
        If the file is not that of such a run.
    """
    about, entries = read_record(run)
    try:
        parameter, fixed = about["parameter"], about["toy"]
        toy = Toy(**{name: _number(value) for name, value in fixed.items()})
        toy = toy.replace(**{parameter: about[AT]})
        settings = Settings(**{name: _pair(value) for name, value in about["settings"].items()})
        wanted = interval("span", about[SPAN], finite=True)
    except (KeyError, TypeError, AttributeError, ValueError):
        raise ValueError(
            f"{run}, line 1: expected a run of the toy, got one of {sorted(about)}"
        ) from None
    network = Network(settings)
    restore(network, entries, ToyPieces(toy, parameter), run)
    return _finished(network, toy, parameter, wanted)


def possible(toy: Toy, parameter: str, span: tuple[float, float]) -> tuple[float, float]:
    """The part of a span that a parameter of the toy can have.

    Raises
    ------
    ValueError
        If that does not hold the toy's own value.
    """
    p, (low, high) = float(getattr(toy, parameter)), limits(toy, parameter)
    if not span[0] <= p <= span[1]:
        raise ValueError(f"span must hold {parameter} = {p} of the toy, got {span}")
    return max(span[0], low), min(span[1], high)


def given(toy: Toy, parameter: str) -> tuple[str, str]:
    """Under which law, and how derivatives in the parameter were found, for the diagram to say."""
    law = str(toy.expansion_friction)
    return f"friction in the expansion: {law}", f"derivatives in {parameter}: the variational flow"


def _start(map_: ToyPieces, orbit: PeriodicOrbit, settings: Settings) -> Orbit:
    """The cycle from which everything is followed, with its minimal period.

    Passed several times over it would hide its flips, and meet the same borders again and again.
    """
    toy, parameter = map_.toy, map_.parameter
    p, x = float(getattr(toy, parameter)), np.array(orbit.points[: orbit.minimal_period])
    low, high = settings.window
    if not (low <= x.min() and x.max() <= high):
        raise ValueError(
            f"window must hold the orbit, phi_S = {', '.join(f'{v:.6g}' for v in x.tolist())}, "
            f"got ({low}, {high})"
        )
    if p == 0.0 and parameter in RESTITUTIONS:  # contacts that rest at zero bounce beyond it
        p = min(SMALLEST, 0.5 * settings.span[1])
    pieces = [map_.at(float(value), p).piece for value in x]
    found = solve(orbit_of(pieces, x, p), (Closed(), Coordinate(-1, p)), settings)
    if not found.converged:
        raise ValueError(
            f"continuation needs a periodic solution, got one that is none at {parameter} = {p}"
        )
    return found.orbit


def _finished(network: Network, toy: Toy, parameter: str, wanted: tuple[float, float]) -> Diagram:
    """The diagram, in which ends of the parameter's own domain say so."""
    found = network.diagram(parameter, "phi_s")
    reasons = dict(_domain_ends(toy, parameter, wanted))
    points = tuple(_of_domain(point, reasons, network.settings) for point in found.points)
    return replace(found, points=points, given=given(toy, parameter))


def _domain_ends(
    toy: Toy, parameter: str, wanted: tuple[float, float]
) -> Iterator[tuple[float, str]]:
    """Ends of what a parameter can be that a span goes beyond, each with the toy's sentence."""
    for end, possible_end in zip(wanted, limits(toy, parameter), strict=True):
        try:
            toy.replace(**{parameter: end})
        except ValueError as error:
            yield possible_end, str(error)


def _of_domain(point: SpecialPoint, reasons: dict[float, str], settings: Settings) -> SpecialPoint:
    """An end point with the reason why the parameter goes no further, if that is why."""
    for end, reason in reasons.items():
        away = abs(point.parameter - end)
        if point.kind is PointKind.EP and away <= settings.same * settings.p_scale:
            return replace(
                point, note=OUT_OF_DOMAIN, cause=reason, status=PointStatus.LOCATED, precision=away,
                interval=(point.parameter - away, point.parameter + away),
            )  # fmt: skip
    return point


def _about(toy: Toy, parameter: str, settings: Settings) -> Entry:
    """What two runs must have in common, so that one can go on with the other's file."""
    fixed = {name: value for name, value in asdict(toy).items() if name != parameter}
    finite = {n: str(v) if v in (math.inf, -math.inf) else v for n, v in fixed.items()}
    return {
        "toy": finite, "parameter": parameter, AT: float(getattr(toy, parameter)),
        "settings": asdict(settings),
    }  # fmt: skip


def _number(value: Any) -> Any:
    return math.inf if value == "inf" else value


def _pair(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


def _nothing(_: Stage) -> None:
    pass


@contextmanager
def _record(
    run: str | os.PathLike[str] | None, about: Entry, resume: bool
) -> Iterator[Record | None]:
    """The record of a run for its time, or none."""
    if run is None:
        if resume:
            raise ValueError("resuming needs the file of a run")
        yield None
        return
    record = Record(run, about, resume=resume)
    try:
        yield record
    finally:
        record.close()
