"""Curves of special points in two parameters: cycles with one condition and one parameter more."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from pwmap.diagrams.diagram import PointKind
from woodpecker.base.arrays import Floats
from woodpecker.base.checks import instance, whole
from woodpecker.base.shown import shown
from woodpecker.engine.curves import Arc, CurveSettings, Sample, SolutionCurve, Stop, TestFunction
from woodpecker.engine.following import follow
from woodpecker.engine.maps import SpaceMap
from woodpecker.engine.newton import Problem, cycles, solve
from woodpecker.engine.orbits import Condition, Multiplier, OnBorder, SpaceOrbit, at_ends


@dataclass(frozen=True, slots=True, eq=False)
class SpecialCurve:
    """A curve of special points of cycles in two parameters.

    Attributes
    ----------
    kind
        What the points are.
    p, x
        (m, 2) parameters and (m, n, d) points of the cycle.
    stops
        What ends the curve at its first and at its last sample.
    causes
        The same as sentences; for Neimark-Sacker points with the resonance if one ends the curve.
    """

    kind: PointKind
    p: Floats
    x: Floats
    stops: tuple[Stop, Stop]
    causes: tuple[str, str]

    def __repr__(self) -> str:
        first, last = (", ".join(f"{v:.6g}" for v in self.p[k]) for k in (0, -1))
        return (
            f"SpecialCurve({self.kind.value}, from ({first}) "
            f"({self.causes[0]}) to ({last}) ({self.causes[1]}))"
        )


def special_curve(
    map_: SpaceMap,
    orbit: SpaceOrbit, kind: PointKind, free: tuple[int, int], settings: CurveSettings, *,
    x_scale: Sequence[float] | None = None, p_scale: Sequence[float] | None = None,
) -> SpecialCurve:  # fmt: skip
    """Follow a fold, flip, Neimark-Sacker point or border collision in two parameters.

    A curve of Neimark-Sacker points ends at strong resonances, where two multipliers are 1 or -1:
    beyond them the pair with the product 1 is real, and the cycles are neutral saddles.

    Parameters
    ----------
    map_
        A map of R^d with at least two parameters.
    orbit
        The cycle at the point, as in :attr:`woodpecker.search.connected.Connected.orbits`.
    kind
        LP, PD, NS, BC or FF; for the last two a margin that vanishes at the point stays zero.
    free
        Indices of the two parameters.
    settings
        Settings with a span for each of them.
    x_scale, p_scale
        The d and k lengths that count as 1; by default those of the window and the spans.

    Returns
    -------
    SpecialCurve
        The curve in both directions from the point.

    Raises
    ------
    TypeError
        If ``orbit`` is not an orbit or ``kind`` is not a kind of point.
    ValueError
        If an argument does not fit the cycle; if the cycle is one of a jump, or lies outside the
        spans or the window; if the kind has no such curve or no margin vanishes at a BC; if
        Newton's method finds no point of this kind; or if it is a neutral saddle.

    Examples
    --------
    >>> from sympy import symbols
    >>> from pwmap import PointKind
    >>> from woodpecker.engine.curves import CurveSettings
    >>> from woodpecker.engine.formulas import expression_map
    >>> from woodpecker.search.connected import connected
    >>> x, y, a, b = symbols("x y a b")
    >>> henon = expression_map((x, y), (a, b), {"H": (1 - a * x**2 + y, b * x)})
    >>> window = ((-4, 4), (-4, 4))
    >>> one = CurveSettings(spans=((-1, 1),), window=window)
    >>> found = connected(henon, [0.6, 0.2], [0.1, 0.3], one, orders=(1,))
    >>> both = CurveSettings(spans=((-1, 1), (-0.5, 0.5)), window=window)
    >>> special_curve(henon, found.orbits["PD1"], PointKind.PD, (0, 1), both)
    SpecialCurve(PD, from (0.1875, 0.5) (end of the parameter span) to (1, -0.154701) (end of the parameter span))
    """  # noqa: E501
    if len(settings.spans) != 2:
        raise ValueError(f"expected a span of each of two parameters, got {len(settings.spans)}")
    instance("orbit", orbit, SpaceOrbit)
    instance("kind", kind, PointKind)
    if orbit.outer is not None:
        raise ValueError(f"expected a special point of cycles, got one of jumps: {orbit.word}")
    d, k = orbit.x.shape[1], len(orbit.p)
    if len(settings.window) != d:
        raise ValueError(f"expected a window of {d} intervals, got {len(settings.window)}")
    which = {whole("free", each, 0) for each in free} if np.ndim(free) == 1 else set[int]()
    if not len(which) == np.size(free) == 2 or max(which) >= k:
        raise ValueError(f"free must name two of {k} parameters, from 0 on, got {shown(free)}")
    base = settings.cycles(free, k, x_scale, p_scale)
    orbit = at_ends(orbit, free, settings.spans, base.p_scale)
    settings.check_holds(orbit.p[list(free)], orbit.x)
    condition, ignored = _condition(orbit, kind, base)
    problem: Problem = base.with_(condition)
    own = RESONANCES if kind is PointKind.NS else ()
    curve = SolutionCurve(map_, problem, settings, ignored, tests=(), own=own)
    held = solve(cycles(free[:1], base.x_scale, base.p_scale).with_(condition), orbit)
    if not held.converged:
        raise ValueError(f"Newton's method finds no {kind.value} near this cycle at p = {orbit.p}")
    start = curve.start(at_ends(held.orbit, free, settings.spans, base.p_scale))
    if any(test.value(start) < 0.0 for test in own):
        multipliers = ", ".join(f"{each.real:.6g}" for each in held.orbit.multipliers())
        raise ValueError(f"expected an NS, got a neutral saddle with the multipliers {multipliers}")
    ahead, behind = (follow(curve, Sample(start.orbit, s * start.tangent)) for s in (1.0, -1.0))
    samples = (*behind.samples[:0:-1], *ahead.samples)
    ends = behind, ahead
    if ahead.stop is Stop.CLOSED:
        samples, ends = ahead.samples, (ahead, ahead)
    return SpecialCurve(
        kind, np.array([sample.orbit.p[list(free)] for sample in samples]),
        np.array([sample.orbit.x for sample in samples]), (ends[0].stop, ends[1].stop),
        (_cause(ends[0]), _cause(ends[1])),
    )  # fmt: skip


def _cause(arc: Arc) -> str:
    """A sentence on what ends an arc."""
    return arc.test.name if arc.test is not None and arc.test.name else arc.stop.value


def _from_resonance(sign: float, sample: Sample) -> float:
    """2 minus ``sign`` times the sum of the pair with the product 1: 0 where both are ``sign``."""
    # On the unit circle the pair is exp(+-i theta), with the sum 2 cos(theta).
    multipliers = sample.orbit.multipliers()
    i, j = np.triu_indices(len(multipliers), 1)
    pair = np.abs(multipliers[i] * multipliers[j] - 1.0).argmin()
    return 2.0 - sign * float((multipliers[i] + multipliers[j])[pair].real)


RESONANCES = tuple(
    TestFunction(Stop.SPECIAL, partial(_from_resonance, sign), name=f"resonance {name}")
    for sign, name in ((1.0, "1:1, two multipliers are 1"), (-1.0, "1:2, two multipliers are -1"))
)


def _condition(
    orbit: SpaceOrbit, kind: PointKind, problem: Problem
) -> tuple[Condition, frozenset[tuple[int, int]]]:
    """The condition of a kind of special point, and the margins that vanish with it."""
    if kind in (PointKind.LP, PointKind.PD, PointKind.NS):
        return Multiplier(kind.value, tuple(problem.lengths.tolist())), frozenset()
    if kind not in (PointKind.BC, PointKind.FF):
        raise ValueError(f"kind must be LP, PD, NS, BC or FF, got {kind.value}")
    for i, image in enumerate(orbit.images):
        codes = image.codes[image.tied(orbit.x[i], orbit.p)].tolist()
        if codes:
            return OnBorder(i, codes[0]), frozenset([(i, codes[0])])
    raise ValueError("expected a cycle with a point on a border, no margin vanishes here")
