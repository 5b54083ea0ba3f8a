"""All branches of a map of R^d that are connected with one cycle.

There are no slices of R^d: branches that are connected with nothing known are not found.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pwmap.algebra.arguments import check_functions
from pwmap.diagrams.diagram import Diagram
from pwmap.diagrams.shown import brief, counted
from woodpecker.base.arrays import Floats
from woodpecker.base.checks import iterates, real_array, whole
from woodpecker.base.progress import Report
from woodpecker.base.settings import EVALUATIONS, Settings
from woodpecker.base.shown import shown
from woodpecker.engine.curves import CurveSettings, SolutionCurve
from woodpecker.engine.germs import cycle_through, least_period, meets_border
from woodpecker.engine.maps import TIE, SpaceMap
from woodpecker.engine.newton import Problem, solve
from woodpecker.engine.orbits import Held, Multiplier, SpaceOrbit, orbit_of
from woodpecker.search.explorer import Explorer
from woodpecker.search.network import SAME_NODE
from woodpecker.search.tasks import StopRule, Tasks

DEPENDENT = 2.0**-40  # fraction of the largest singular value: a smaller one is zero to rounding
ALL_SAMPLES = 20  # most samples of all branches together, in units of those of one arc


@dataclass(frozen=True, slots=True, eq=False)
class Connected:
    """All branches that are connected with a cycle.

    Attributes
    ----------
    diagram
        Branches of cycles and special points occur in it once for each point of the cycle.
    orbits
        The orbit at each special point, by its id: curves in two parameters start from these.
    left
        A sentence on what was not followed, as in ``diagram.about["left"]``; empty if nothing.
    """

    diagram: Diagram
    orbits: Mapping[str, SpaceOrbit]
    left: str = ""

    def __repr__(self) -> str:
        return f"Connected({self.diagram!r})"


def connected(
    map_: SpaceMap, x: npt.ArrayLike, p: npt.ArrayLike, settings: CurveSettings, *,
    orders: Sequence[int] = (1, 2), free: int = 0, x_scale: Sequence[float] | None = None,
    p_scale: Sequence[float] | None = None, names: Sequence[str] = ("p", "x"),
    max_branches: int = 500, max_evaluations: int = EVALUATIONS, stop: StopRule | None = None,
    progress: Report | None = None, on_interrupt: Callable[[], None] | None = None,
) -> Connected:  # fmt: skip
    """Follow the branch through a cycle, and all branches that are connected with it.

    Branches of cycles and of jump crossings start where a cycle meets a border, of cycles of twice
    the period at flips, and of the same period at branch points.

    Parameters
    ----------
    map_
        A map of R^d.
    x, p
        A guess of a cycle's points, (n, d), or (d,) for a fixed point; and the parameters (k,). The
        cycle is followed with its minimal period.
    settings
        Span, window, steps.
    orders
        Iterates whose cycles and jump crossings are followed.
    free
        Number of the parameter that varies, from 0 on.
    x_scale, p_scale
        d and k lengths that count as 1; by default those of the window and the span.
    names
        Names of the parameter and of one or more coordinates: the first is the x of the diagram,
        others become columns of its branches.
    max_branches, max_evaluations
        Bounds as in :class:`woodpecker.Settings`; ``left`` says what was not followed.
    stop
        A rule that ends branches, such as ``lambda state: abs(state.multiplier) > 5``, called with
        a :class:`woodpecker.search.BranchState` at each sample.
    progress
        Called before the first branch, and with each finished one.
    on_interrupt
        Called at Ctrl-C, then what is finished is returned; by default ``KeyboardInterrupt``.

    Returns
    -------
    Connected
        Its branches have the largest multiplier of their cycles, the modulus of a complex pair.

    Raises
    ------
    ValueError
        If an argument does not fit the map, Newton's method finds no cycle of it near the guess, or
        that lies outside.
    TypeError
        If ``stop``, ``progress`` or ``on_interrupt`` cannot be called.

    Examples
    --------
    >>> from sympy import symbols
    >>> from woodpecker.engine.curves import CurveSettings
    >>> from woodpecker.engine.formulas import expression_map
    >>> from woodpecker.search.connected import connected
    >>> x, y, a, b = symbols("x y a b")
    >>> henon = expression_map((x, y), (a, b), {"H": (1 - a * x**2 + y, b * x)})
    >>> settings = CurveSettings(spans=((-1, 1),), window=((-4, 4), (-4, 4)))
    >>> found = connected(henon, [0.6, 0.2], [0.1, 0.3], settings, orders=(1,))
    >>> for point in found.diagram.points:  # exact: -(1 - b)^2/4 and 3 (1 - b)^2/4
    ...     if point.kind.value != "EP":
    ...         print(point.kind, round(point.parameter, 12))
    LP -0.1225
    PD 0.3675
    """
    points, values = np.atleast_2d(real_array("x", x)), np.atleast_1d(real_array("p", p))
    if points.ndim != 2 or values.ndim != 1 or not points.size:
        raise ValueError(
            f"x must have shape (n, d) and p (k,), got {points.shape} and {values.shape}"
        )
    d, k = points.shape[1], len(values)
    wanted = iterates(orders)
    if whole("free", free, 0) >= k:
        raise ValueError(f"free must name one of {k} parameters, from 0 on, got {free}")
    named = not isinstance(names, str) and all(isinstance(each, str) for each in names)
    if not named or not 2 <= len(names) <= d + 1:
        raise ValueError(
            f"names must be 2 to {d + 1} names, of the parameter and the coordinates, got "
            f"{shown(names)}"
        )
    most = whole("max_branches", max_branches)
    check_functions(progress=progress, on_interrupt=on_interrupt)
    if len(settings.window) != d or len(settings.spans) != 1:
        raise ValueError(
            f"expected a window of {d} intervals and one span, got {len(settings.window)} and "
            f"{len(settings.spans)}"
        )
    problem = settings.cycles((free,), k, x_scale, p_scale)
    own, columns = map_.at(points[0], values).piece.at(points[0], values).jacobian.shape
    if (own, columns) != (d, d + k):
        raise ValueError(
            f"the map has {counted(own, 'coordinate')} and {counted(columns - own, 'parameter')}, "
            f"got points of {d} and {k} values"
        )
    base = SolutionCurve(map_, problem, settings)
    start = least_period(cycle_near(base, points, values), problem)
    settings.check_holds(values[free : free + 1], start.x)
    followed = Settings(span=settings.spans[0], same=SAME_NODE, max_evaluations=max_evaluations)
    tasks = Tasks(base, followed, stop, parameters=tuple(values.tolist()), orders=tuple(wanted))
    explorer = Explorer(
        tasks, wanted, progress, max_branches=most,
        max_samples=ALL_SAMPLES * settings.max_samples,
    )  # fmt: skip
    try:
        explorer.follow(start)
    except KeyboardInterrupt:
        if on_interrupt is None or not explorer.network.curves:
            raise
        on_interrupt()
    diagram, cycles = explorer.diagram(*names), explorer.network.cycles()
    found = zip(diagram.points, cycles, strict=True)
    orbits = {point.id: cycle for point, cycle in found if cycle is not None}
    return Connected(diagram, orbits, explorer.left)


def cycle_near(base: SolutionCurve, x: Floats, p: Floats) -> SpaceOrbit:
    """The cycle that Newton's method finds from a guess (n, d), on the pieces at its points.

    ValueError if it does not converge, if the cycle is virtual (the map takes another piece at one
    of its points), or if not just one branch passes through it.
    """
    map_, problem = base.map, base.problem
    guess = orbit_of([map_.at(point, p).piece for point in x], x, p)
    held = [Held(x.size + k, float(p[k])) for k in problem.free]
    found = solve(problem.with_(*held), guess)
    if meets_border(guess) and not (found.converged and base.agrees(found.orbit, is_last=True)):
        # On the border itself the map may take a piece that does not close: ask those beside. At a
        # root singularity their limit is all that is known.
        through = cycle_through(map_, x[0], p, (len(x),), problem)
        if through is not None:
            found = solve(problem.with_(*held), through)
            if not found.converged:
                return through
    if not found.converged:  # right at a fold only the parameter tells where the cycle is
        fold = solve(problem.with_(Multiplier("LP")), guess)
        off = np.abs(problem.step_between(guess, fold.orbit))[x.size :].max()
        found = fold if fold.converged and off <= TIE else found
    expected = f"expected a guess near a cycle of the map at {_listed(p)}, got {_listed(x)}"
    if guess.is_defined and _are_dependent(problem, found.orbit):
        raise ValueError(
            f"{expected}: no single branch leads through it, as cycles fill a line or more there "
            "at one value of the parameter, or branches cross"
        )
    if not found.converged:
        raise ValueError(expected)
    if not base.agrees(found.orbit, is_last=True):
        at, image = next(
            each for each in zip(found.orbit.x, found.orbit.images, strict=True)
            if not base.takes(each[0], p, each[1])
        )  # fmt: skip
        raise ValueError(
            f"{expected}: from there a virtual one is found, at {_listed(at)} the map takes "
            f"another piece than {brief(image.piece.word)!r}"
        )
    return found.orbit


def _listed(values: Floats) -> str:
    return ", ".join(f"{each:.6g}" for each in values.ravel().tolist())


def _are_dependent(problem: Problem, cycle: SpaceOrbit) -> bool:
    """Whether the equations of a cycle are linearly dependent, even with the parameter free."""
    rows = problem.matrix(cycle) / np.tile(problem.x_scale, len(cycle.x))[:, None]
    sizes = np.linalg.svd(rows, compute_uv=False)
    return bool(sizes[-1] <= DEPENDENT * max(1.0, sizes[0]))
