"""What hangs together with one periodic motion of the toy, and curves of its special points."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import cast, overload

import numpy as np

from pwmap.diagrams.diagram import Diagram, PointKind, SpecialPoint
from woodpecker.base.checkpoint import START
from woodpecker.base.checks import instance, interval
from woodpecker.base.executors import Serial
from woodpecker.base.settings import Settings
from woodpecker.mechanics.toy import Toy
from woodpecker.plane.curve import Curve, PlanePoint
from woodpecker.runs import AT, about, finished, nothing, possible, recorded, settings_for
from woodpecker.search.diagrams import cycle_near, orders_with, restored
from woodpecker.search.explorer import Explorer, Progress
from woodpecker.search.samples import StopRule
from woodpecker.search.tasks import Worker
from woodpecker.shooting import PeriodicOrbit
from woodpecker.simulation.returns import RESTITUTIONS
from woodpecker.slices.orbits import Orbit
from woodpecker.toy_map import ToyPieces
from woodpecker.two_parameters import Spans, curve_from


@overload
def continuation(
    toy: Toy,
    orbit: PeriodicOrbit,
    parameter: str = "eps_n1",
    span: tuple[float, float] = (0.0, 1.0),
    *,
    orders: Sequence[int] | None = None,
    settings: Settings | None = None,
    stop: StopRule | None = None,
    progress: Progress | None = None,
    run: str | os.PathLike[str] | None = None,
    resume: bool = False,
) -> Diagram: ...


@overload
def continuation(
    toy: Toy,
    orbit: SpecialPoint | PlanePoint,
    parameter: tuple[str, str],
    span: Spans,
    *,
    kind: PointKind | str | None = None,
    settings: Settings | None = None,
) -> Curve: ...


def continuation(
    toy: Toy,
    orbit: PeriodicOrbit | SpecialPoint | PlanePoint,
    parameter: str | tuple[str, str] = "eps_n1",
    span: tuple[float, float] | Spans = (0.0, 1.0),
    *,
    kind: PointKind | str | None = None,
    orders: Sequence[int] | None = None,
    settings: Settings | None = None,
    stop: StopRule | None = None,
    progress: Progress | None = None,
    run: str | os.PathLike[str] | None = None,
    resume: bool = False,
) -> Diagram | Curve:
    """Follow a periodic solution over one parameter, or a special point over two.

    A periodic solution is followed both ways, and every branch that is connected to it. A special
    point is followed both ways too, through points of codimension two and changes of word.

    Parameters
    ----------
    toy
        The toy; its value of ``parameter`` is where the orbit lives. Over two parameters its value
        of the second one is where the point does.
    orbit
        A periodic solution of it, from :func:`woodpecker.shoot`. It is followed with its minimal
        period, also where a multiple of that was shot for. Or a special point, LP, PD, BC or FF, of
        a diagram of this toy over the first of two parameters; or one of a curve, of codimension
        two, at which a curve of another kind starts.
    parameter, span
        Parameter of the toy and its interval, or two of each. Where the toy cannot have all of
        these values, branches and curves end at the last that it can have.
    kind
        Of a point of codimension two: which of the curves that start there, see its ``starts``.
    orders
        The iterates of which branches are followed, the minimal period of the orbit among them; by
        default no other. Where P_n flips the doubled branch starts if 2 n is one of them; jump
        branches of all of them start at collisions with jumps, cycles at kinks and grazings.
    settings
        Steps, window and tolerances; the span is taken from ``span``. By default the window is
        (-2.5, -0.24) rad.
    stop
        A rule that ends branches, such as ``lambda state: abs(state.multiplier) > 5``. It is asked
        at every sample, with a :class:`woodpecker.BranchState`; where it comes to be true the
        branch ends (EP, "stopped as asked"), a place that is bracketed to rounding, and nothing
        that begins beyond is followed.
    progress
        Called before the first branch, and with every one that is finished.
    run
        A file that keeps every finished branch, so that an interrupted run can go on.
    resume
        Go on with the run in that file. It does not keep ``stop``: a rule that is wanted is given
        again.

    Returns
    -------
    Diagram or Curve
        Over one parameter fixed-point and jump branches of these iterates with their special
        points; ``given`` says under which law of impact, and how derivatives in the parameter were
        found. Over two parameters one curve.

    Raises
    ------
    ValueError
        If the orbit did not converge or is one of another toy, span, window or orders do not hold
        it, there is no such run to resume, or no such special point.
    TypeError
        If a parameter is unknown, the settings are no :class:`Settings`, or what is given for one
        parameter does not go with two.

    Examples
    --------
    >>> from woodpecker import Toy, continuation, shoot
    >>> toy = Toy()
    >>> diagram = continuation(toy, shoot(toy, -0.53), "eps_n1", span=(0.45, 0.7))
    >>> for point in diagram.points:
    ...     print(point.kind, f"{point.parameter:.9f} {point.x:.9f}", point.cause)
    EP 0.450000000 -0.537769080 end of the parameter span
    PD 0.648549200 -0.518581245 the multiplier is -1
    EP 0.700000000 -0.515717105 end of the parameter span
    """
    if isinstance(parameter, str) and isinstance(orbit, PeriodicOrbit):
        if kind is not None:
            raise TypeError(f"kind is for a point of codimension two, got {kind!r} for an orbit")
        return _diagram(
            toy, orbit, parameter, cast("tuple[float, float]", span), orders=orders,
            settings=settings, stop=stop, progress=progress, run=run, resume=resume,
        )  # fmt: skip
    if isinstance(orbit, str):
        raise TypeError(
            f"continuation needs the point itself, found by diagram.point({orbit!r}), got its name"
        )
    if isinstance(parameter, str) or isinstance(orbit, PeriodicOrbit):
        raise TypeError(
            "a periodic solution is followed over one parameter, a special point over two, got "
            f"{type(orbit).__name__} and {parameter!r}"
        )
    if any(each is not None for each in (orders, stop, progress, run)) or resume:
        raise TypeError("orders, stop, progress, run and resume are for one parameter, not for two")
    return curve_from(toy, orbit, parameter, cast("Spans", span), kind=kind, settings=settings)


def _diagram(
    toy: Toy, orbit: PeriodicOrbit, parameter: str, span: tuple[float, float], *,
    orders: Sequence[int] | None, settings: Settings | None, stop: StopRule | None,
    progress: Progress | None, run: str | os.PathLike[str] | None, resume: bool,
) -> Diagram:  # fmt: skip
    """What is connected to a periodic solution over one parameter."""
    instance("toy", toy, Toy)
    if not orbit.success:
        raise ValueError(f"continuation needs a periodic solution, got one with: {orbit.message}")
    if orbit.toy != toy:
        raise ValueError("continuation needs an orbit of this toy, got one of another toy")
    map_, p = ToyPieces(toy, parameter), float(getattr(toy, parameter))
    wanted = interval("span", span, finite=True)
    if not wanted[0] <= p <= wanted[1]:
        raise ValueError(f"span must hold {parameter} = {p} of the toy, got {wanted}")
    chosen = settings_for(settings, span=possible(toy, parameter, wanted))
    start = _start(map_, orbit, chosen)
    followed = orders_with(start, orders)
    run_of = about(toy, parameter, chosen, wanted) | {
        AT: p, START: orbit.points, "orders": followed
    }  # fmt: skip
    with recorded(run, run_of, resume) as record:
        explorer = Explorer(
            map_, Serial(Worker(map_, chosen, stop)), chosen, followed, progress or nothing, record,
        )  # fmt: skip
        explorer.take_over(restored(explorer, record, map_).since)
        explorer.follow(start)
    return finished(explorer.diagram(parameter, "phi_s"), toy, wanted, chosen)


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
        p = settings.same * settings.p_scale
    return cycle_near(map_, x, p, settings)
