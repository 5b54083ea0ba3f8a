"""Solutions at a value of a diagram's parameter, and observables along branches of the toy."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pwmap.diagrams.diagram import Branch, BranchKind, Diagram, Hit
from woodpecker.base.arrays import Floats
from woodpecker.base.checks import instance, number
from woodpecker.engine.following import follow
from woodpecker.maps.pieces import Image, Piece, PiecewiseMap
from woodpecker.mechanics.toy import Toy
from woodpecker.search.tasks import base_of
from woodpecker.shooting import (
    DEFAULT,
    PeriodicOrbit,
    ShootingStatus,
    is_taken,
    periodic_orbit,
    shoot,
)
from woodpecker.slices.orbits import Orbit, at_parameter, of_engine, orbit_of, to_engine
from woodpecker.toy_map import Mapped, ToyPieces, durations, map_and_names

if TYPE_CHECKING:
    from pwmap import PiecewiseLinearMap


class OnBranch(NamedTuple):
    """A periodic solution and its branch, from :func:`woodpecker.solutions`."""

    branch: Branch
    orbit: PeriodicOrbit


def solutions(
    source: Toy | PiecewiseMap | PiecewiseLinearMap, diagram: Diagram, value: float
) -> tuple[OnBranch, ...]:
    """The periodic solutions at a value of a diagram's parameter, each by Newton's method.

    It starts from the neighbouring samples of a branch and solves for all points of a cycle at
    once, each on its own piece, so that steep cycles are found, too.

    Parameters
    ----------
    source, diagram
        A diagram of :func:`woodpecker.continuation` or :func:`woodpecker.bifurcation_diagram`, and
        its toy or map of the line; the toy's own value of the parameter does not matter.
    value
        The value of the parameter.

    Returns
    -------
    tuple
        One entry for each time that a branch of fixed points passes the value, in order of phi_S.
        Where ``orbit.success`` is false, ``orbit.message`` says why.

    Raises
    ------
    TypeError, ValueError
        If an argument is of another type, the source has no such parameter, or the toy cannot have
        this value.

    Examples
    --------
    >>> from woodpecker import Toy, continuation, shoot, solutions
    >>> toy = Toy()
    >>> diagram = continuation(toy, shoot(toy, -0.53), span=(0.45, 0.55))
    >>> [(one.branch.id, round(one.orbit.phi_s, 9)) for one in solutions(toy, diagram, 0.48)]
    [('F1', -0.532395917)]
    """
    instance("diagram", diagram, Diagram)
    value, name = number("value", value), diagram.parameter_name
    there = source.replace(**{name: value}) if isinstance(source, Toy) else source
    map_, *_ = map_and_names(there, name)
    mapped = Mapped(there, map_, value)
    return tuple(
        OnBranch(hit.branch, _solution(mapped, diagram, hit))
        for hit in diagram.at(value)
        if hit.branch.kind is BranchKind.FIXED_POINT
    )


def _solution(mapped: Mapped, diagram: Diagram, hit: Hit) -> PeriodicOrbit:
    """The solution at a value, continued from the samples on both sides, else found by shooting."""
    source, map_, value = mapped
    beside = _beside(hit, value)
    for start in _starts(map_, diagram, hit.branch, beside):
        found = _led(map_, start, value)
        if found is not None and is_taken(mapped, found, DEFAULT):
            return periodic_orbit(mapped, found, DEFAULT)
    p = None if isinstance(source, Toy) else value
    other = shoot(source, hit.x, hit.branch.order, p=p)
    if beside and abs(other.x - hit.x) > np.ptp(hit.branch.x[beside]):  # it is on another branch
        lost = ShootingStatus.NOT_CONVERGED
        return replace(other, status=lost, message=lost.value)
    return other


def _beside(hit: Hit, value: float) -> list[int]:
    """The numbers of both samples next to a hit, the one more likely to have its pieces first."""
    p, x = hit.branch.parameter, hit.branch.x
    (ends,) = np.nonzero((p[1:] != p[:-1]) & ((p[:-1] - value) * (p[1:] - value) <= 0.0))
    if not len(ends):
        return []
    part = (value - p[ends]) / (p[ends + 1] - p[ends])
    off = np.abs(x[ends] + part * (x[ends + 1] - x[ends]) - hit.x)
    k = int(ends[off.argmin()])
    # At an end of a branch on a border the map may take the piece on the other side.
    return sorted((k, k + 1), key=lambda i: (i in (0, len(p) - 1), abs(float(p[i]) - value)))


def _starts(
    map_: PiecewiseMap, diagram: Diagram, branch: Branch, beside: Sequence[int]
) -> Iterator[Orbit]:
    """The cycles at two neighbouring samples, and the one halfway: both may lie on borders."""
    ends = [_cycle(map_, diagram, branch, k) for k in beside]
    yield from ends
    if ends:
        x, p = np.mean([end.x for end in ends], axis=0), 0.5 * sum(end.p for end in ends)
        halfway = Orbit(x, p, tuple(map_.at(value, p) for value in x.tolist()))
        found = at_parameter(halfway, DEFAULT) if halfway.defined else None
        apart = np.ptp([end.x for end in ends], axis=0).max()
        if found is not None and np.abs(found.x - x).max() <= apart:
            yield found


def _led(map_: PiecewiseMap, start: Orbit, value: float) -> Orbit | None:
    """The cycle at another value of the parameter, on the same pieces; None if it is lost."""
    if not start.defined:
        return None
    base, orbit = base_of(map_, DEFAULT), to_engine(start)
    way, last = value - start.p, start
    if way:
        first = base.start(orbit, math.copysign(1.0, way) * np.eye(len(start) + 1)[-1])
        if not first.tangent[-1] * way > 0.0:  # no tangent (nan), or the branch folds right here
            return None
        step = WHOLE * abs(way / float(first.tangent[-1]))
        span = min(start.p, value), max(start.p, value)
        settings = replace(
            base.settings, spans=(span,), min_step=LEAST * step, step=step, max_step=step
        )
        arc = follow(replace(base, settings=settings, tests=()), first)
        last = of_engine(arc.samples[-1].orbit)  # just short of the value if a border lies there
    found = at_parameter(orbit_of(last.pieces, last.x, value), DEFAULT)
    is_same = found is not None and float(np.abs(found.x - last.x).max()) <= CLOSE
    return found if is_same else None


def _cycle(
    map_: PiecewiseMap, diagram: Diagram, branch: Branch, k: int, pieces: Sequence[Piece] = ()
) -> Orbit:
    """The cycle of a sample, with its other points from branches with the same parameters."""
    # Images are those of the map, or of given pieces, one for each point.
    p = float(branch.parameter[k])

    def image_of(x: float, j: int) -> Image:
        return pieces[j].at(x, p) if pieces else map_.at(x, p)

    others = [
        other
        for other in diagram.branches
        if (other.kind, other.order) == (branch.kind, branch.order)
        and np.array_equal(other.parameter, branch.parameter)
    ]
    x = np.array([float(other.x[k]) for other in others])
    points, images = [float(branch.x[k])], [image_of(float(branch.x[k]), 0)]
    while len(points) < branch.order:
        to = images[-1].value
        near = float(x[np.abs(x - to).argmin()])
        points.append(near if abs(near - to) <= NEAR * max(1.0, abs(images[-1].slope)) else to)
        images.append(image_of(points[-1], len(images)))
    return Orbit(np.array(points), p, tuple(images))


WHOLE = 2.0  # longest step, in units of the arclength to the solution: one step is usual
LEAST = 1e-6  # shortest step, as a fraction of the longest
CLOSE = 1e-6  # largest distance of the solution from the end of the last step
NEAR = 1e-12  # largest distance of an image from the sample taken for it, times the slope

OF_A_RETURN = ("period", "drop")  # observables that are attributes of woodpecker.Return
Observable = Callable[[Toy, float], float]


def known_observables(names: Iterable[str]) -> None:
    """ValueError if there is a name that :func:`observables` does not know."""
    for name in names:
        if name not in OF_A_RETURN:
            raise ValueError(f"an observable must be one of {', '.join(OF_A_RETURN)}, got {name!r}")


def observables(toy: Toy, diagram: Diagram, *names: str, **functions: Observable) -> Diagram:
    """The same diagram with observables along its branches: period, drop, or your own functions.

    Each sample of a branch of fixed points is simulated. Values between samples can be interpolated
    like x; along jumps they are nan.

    Parameters
    ----------
    toy, diagram
        As :func:`solutions` takes them.
    names
        Some of ``"period"`` [s] and ``"drop"`` [m, positive down], of P_order.
    functions
        Your functions by name; arguments are the toy with the sample's parameter and phi_S [rad].

    Returns
    -------
    Diagram
        With the values in :attr:`pwmap.Branch.columns`, which
        :func:`pwmap.diagrams.tables.write_results` writes, too.

    Raises
    ------
    ValueError, TypeError
        If ``toy`` or ``diagram`` is none, a name is unknown, or the toy has no such parameter.

    Examples
    --------
    >>> from woodpecker import Toy, continuation, observables, shoot
    >>> toy = Toy()
    >>> diagram = continuation(toy, shoot(toy, -0.53), span=(0.49, 0.51))
    >>> branch = observables(toy, diagram, "period", "drop").branches[0]
    >>> sorted(branch.columns), [f"{period:.6f}" for period in branch.columns["period"][[0, -1]]]
    (['drop', 'period'], ['0.147560', '0.144450'])
    """
    instance("toy", toy, Toy)
    instance("diagram", diagram, Diagram)
    known_observables(names)
    branches = []
    for branch in diagram.branches:
        found = _observed(toy, diagram, branch, names, functions)
        branches.append(replace(branch, columns={**branch.columns, **found}))
    return replace(diagram, branches=tuple(branches))


def _observed(
    toy: Toy, diagram: Diagram, branch: Branch, names: tuple[str, ...],
    functions: dict[str, Observable],
) -> dict[str, Floats]:  # fmt: skip
    found = {name: np.full(len(branch), math.nan) for name in (*names, *functions)}
    if branch.kind is not BranchKind.FIXED_POINT:
        return found
    map_ = ToyPieces(toy, diagram.parameter_name)
    for k in range(len(branch)):
        p, x = float(branch.parameter[k]), float(branch.x[k])
        if names:
            cycle = _closing(map_, diagram, branch, k)
            both = dict(zip(OF_A_RETURN, durations(cycle.images, cycle.x, p), strict=True))
            for name in names:
                found[name][k] = both[name]
        for name, function in functions.items():
            found[name][k] = function(toy.replace(**{diagram.parameter_name: p}), x)
    return found


def _closing(map_: PiecewiseMap, diagram: Diagram, branch: Branch, k: int) -> Orbit:
    """The cycle of a sample; at an end on a border, on the pieces of the branch if that closes."""
    cycle = _cycle(map_, diagram, branch, k)
    if 0 < k < len(branch) - 1 or len(branch) == 1:
        return cycle
    inside = _cycle(map_, diagram, branch, 1 if k == 0 else len(branch) - 2)
    along = _cycle(map_, diagram, branch, k, inside.pieces)
    return min(cycle, along, key=_off)  # the first if both close


def _off(cycle: Orbit) -> float:
    """The largest gap of a cycle, relative to its slope; infinite if a point has no image."""
    gaps = [
        abs(image.value - to) / max(1.0, abs(image.slope))
        for image, to in zip(cycle.images, np.roll(cycle.x, -1), strict=True)
    ]
    return max(gaps) if cycle.defined else math.inf
