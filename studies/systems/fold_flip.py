"""A pushed oscillator on a belt: a Filippov system with a fold-flip.

    python -m studies.systems.fold_flip [--fast] [--out DIR]

x'' + x = a cos(w t) + F(x' - 1), with friction F(s) = -1.5 sign(s) + 1.5 s - 0.45 s**3 from a belt
of speed 1, and a sticking force of at most 1.5. The paper says that a point "showing both fold and
flip action" was found in a system of this type, and that it is related to the tent map [Leine2001,
Leine2000]. It gives no numbers; this is a system of the kind, with such a point.

At the border a cycle that always slips reaches the speed of the belt; beyond it the mass sticks for
a short time. The return is continuous there, with a multiplier above 1 where the mass sticks and
one below -1 where it does not. Both cycles exist on the same side only (a fold), a cycle of twice
the period starts there too (a flip), and so do infinitely many others: those of the tent map with
these two multipliers as slopes, since the second multipliers, 0 and -0.024, are small.

:func:`slide` and the functions that use it follow the mass with scipy's DOP853 and its events, and
share nothing with :mod:`woodpecker`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import islice
from pathlib import Path

import numpy as np
import sympy
from matplotlib.figure import Figure
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, root

from pwmap import PointKind, cycles
from pwmap.diagrams.diagram import BranchKind
from pwmap.longrun import FoundCycle
from studies.common.exact_maps import SKEW
from studies.common.record import Results, command
from studies.common.style import GREY, RED, STABLE, UNSTABLE, canvas, keep
from woodpecker.base.arrays import Floats
from woodpecker.search.connected import Connected
from woodpecker.systems import Contact, ContactSystem, Section, SystemMap, continuation, shoot

X, Y, V, T, W, A = sympy.symbols("x y u_x t w a")
MOST, FALLS, RISES = 1.5, 1.5, 0.45  # F(s) = -MOST sign(s) + FALLS s - RISES s**3
PUSH = 0.2
START, SLIDING = 0.92, (0.1702, 6.7445)  # w, and x and t of the cycle that never sticks
BOTH, STICKING = 0.9127, (0.1588, 6.7064)  # w with one that does, and that
SPAN = (0.9, 0.925)
WINDOW = [(-0.5, 0.5), (0.0, 7.0)]  # of x and t
BESIDE = 2e-3  # of w: where the multipliers of both cycles are compared
CLOSE = 1e-5  # of w: where the tent map says which cycles there are
ORDER, SETTLED = 5, 20
ROUNDING = 1e-13  # relative: what DOP853 resolves
TIMES = 2.04, 2.1359  # s: where slips begin, of the cycle that sticks, and at the point


def system() -> ContactSystem:
    """The oscillator; its weight is 1, and y the gap to the belt."""
    most, falls, rises = (sympy.Rational(str(each)) for each in (MOST, FALLS, RISES))
    slip = V - 1
    belt = Contact(name="the belt", gap=Y, slip=slip, mu=most)
    force = [A * sympy.cos(W * T) - X + falls * slip - rises * slip**3, -1]
    return ContactSystem([X, Y], [[1, 0], [0, 1]], force, [belt], {W: START, A: PUSH})


def map_of(*parameters: str, backend: str | None = None) -> SystemMap:
    """From one least x to the next: x, and time modulo the period."""
    section = Section(when=V, free=[X, T], period=2 * sympy.pi / W, horizon=100.0)
    return SystemMap(system(), section, parameters, backend=backend)


def followed(*, sticks: bool = False) -> Connected:
    """The cycle that never sticks over w, or the one that does, and what is connected with it."""
    map_ = map_of("w")
    start = shoot(map_, STICKING, p=[BOTH]) if sticks else shoot(map_, SLIDING)
    return continuation(map_, start, SPAN, WINDOW, orders=(1, 2), max_step=0.01)


def point_of(found: Connected) -> tuple[float, Floats]:
    """The fold-flip: w, and the point (2,) of the section."""
    (point,) = (q for q in found.diagram.points if q.kind is PointKind.BC)
    return point.parameter, found.orbits[point.id].x[0]


def slopes_of(found: Connected) -> tuple[float, float]:
    """The multipliers at the fold-flip: of the cycle that sticks, and of the one that does not."""
    (point,) = (q for q in found.diagram.points if q.kind is PointKind.BC)
    meeting = [b for b in found.diagram.branches if b.id in point.branches and b.order == 1]
    ends = [b.multiplier[0 if b.ends[0] == point.id else -1] for b in meeting]
    return float(np.real(max(ends))), float(np.real(min(ends)))


def both(w: float, near: Floats, backend: str | None = None) -> tuple[float, float]:
    """The multipliers of the cycles that stick and do not, somewhat above the point."""
    map_, found = map_of(backend=backend).holding(w=w), dict[bool, float]()
    for moved in ((-0.01, -0.09), (0.0, -0.01)):
        cycle = shoot(map_, near + moved)
        if cycle.success:
            found["J1" in cycle.word] = float(np.real(cycle.multipliers[0]))
    return found[True], found[False]


# --- The same motion by other means ---------------------------------------------------------------


def slide(t: float, state: Iterable[float], w: float, until: float, *, sticks: bool) -> tuple[
    Floats, Floats, Floats
]:  # fmt: skip
    """The mass while it is slower than the belt: the last state, and times and speeds of maxima.

    It ends where it catches up, if it may stick.
    """

    def rate(s: float, y: Floats) -> list[float]:
        slip = y[1] - 1.0
        force = PUSH * math.cos(w * s) - y[0] + MOST + FALLS * slip - RISES * slip**3
        return [y[1], force]

    def catches_up(_: float, y: Floats) -> float:
        return float(y[1] - 1.0)

    def is_fastest(s: float, y: Floats) -> float:
        return rate(s, y)[1]

    catches_up.direction, catches_up.terminal = 1.0, sticks  # type: ignore[attr-defined]
    is_fastest.direction = -1.0  # type: ignore[attr-defined]
    found = solve_ivp(
        rate, (t, until), list(state), method="DOP853", rtol=1e-13, atol=1e-15,
        events=[catches_up, is_fastest],
    )  # fmt: skip
    speeds = np.reshape(found.y_events[1], (-1, 2))[:, 1]
    return np.append(found.t[-1], found.y[:, -1]), found.t_events[1], speeds


def slips_at(t: float, w: float) -> tuple[float, float]:
    """Place and speed where it slips off at a time: the spring has overcome friction."""
    return MOST + PUSH * math.cos(w * t), 1.0


def touch(guess: tuple[float, float]) -> float:
    """The w at which a slip comes back to the speed of the belt just after a period.

    The guess is the time of the touch, and w.
    """

    def away(unknown: Floats) -> list[float]:
        t, w = unknown
        period = 2.0 * math.pi / w
        _, times, speeds = slide(t, slips_at(t, w), w, t + 1.2 * period, sticks=False)
        k = int(np.abs(times - t - period).argmin())
        return [times[k] - t - period, speeds[k] - 1.0]

    return float(root(away, guess, tol=ROUNDING).x[1])


def next_slip(t: float, w: float) -> float:
    """From where it slips off to where it does so again, after it has stuck."""
    (at, x, _), _, _ = slide(t, slips_at(t, w), w, t + 50.0, sticks=True)
    period = 2.0 * math.pi / w
    rest = brentq(lambda s: x + s - at - slips_at(s, w)[0], at, at + period, xtol=1e-15)
    return float(rest)


def sticking_multiplier(w: float, guess: float, h: float = 1e-3) -> float:
    """Of the cycle that sticks, by central differences of order four of its slips' times."""
    period = 2.0 * math.pi / w
    t = float(root(lambda s: next_slip(s[0], w) - s[0] - period, guess, tol=ROUNDING).x[0])
    values = [next_slip(t + k * h, w) for k in (-2, -1, 1, 2)]
    return (values[0] - 8 * values[1] + 8 * values[2] - values[3]) / (12 * h)


def sliding_multiplier(w: float, t: float, h: float = 1e-3) -> float:
    """The larger one of the cycle that never sticks, by differences of its map over a period."""
    period = 2.0 * math.pi / w

    def over(state: Floats) -> Floats:
        return slide(t, state, w, t + period, sticks=False)[0][1:]

    state = root(lambda y: over(y) - y, [slips_at(t, w)[0], 1.0 - 1e-3], tol=ROUNDING).x
    columns = []
    for step in h * np.eye(2):
        values = [over(state + k * step) for k in (-2, -1, 1, 2)]
        columns.append((values[0] - 8 * values[1] + 8 * values[2] - values[3]) / (12 * h))
    found = np.linalg.eigvals(np.transpose(columns))
    return float(np.real(found[np.abs(found).argmax()]))


# --- The tent map ---------------------------------------------------------------------------------


def tent_cycles(slopes: tuple[float, float], order: int = ORDER) -> list[FoundCycle]:
    """Cycles of the tent map with two slopes; L: left of its kink."""
    a, b = (sympy.Rational(round(1000 * each), 1000) for each in slopes)
    return list(cycles(SKEW, {"a": a, "b": b}, order))


def own_cycles(w: float, near: Floats, known: Sequence[FoundCycle]) -> list[str]:
    """Words of the cycles that shooting finds from those of the tent map; L: it sticks.

    The line through both cycles of one return is that of the tent map, but for its unit and origin.
    """
    map_, ends = map_of().holding(w=w), list[tuple[float, Floats]]()
    for cycle, moved in zip(known, ((-5e-5, -4.5e-4), (0.0, -5e-5)), strict=False):  # L and R
        ends.append((float(cycle.start), shoot(map_, near + moved).x[0]))
    (low, left), (high, right) = ends
    words = set[str]()
    for cycle in known:
        for point in cycle.exact_points:
            guess = left + (float(point) - low) / (high - low) * (right - left)
            own = shoot(map_, guess, order=cycle.period)
            letters = "".join("L" if "J1" in each else "R" for each in own.word.split("|"))
            if (
                own.success and (letters * 2).find(letters, 1) == cycle.period
            ):  # no power of another
                words.add(turned(letters))
    return sorted(words)


def turned(word: str) -> str:
    """The first of the rotations of a word."""
    return min(word[k:] + word[:k] for k in range(len(word)))


def attractor(map_: SystemMap, near: Floats, count: int) -> Floats:
    """Points (count, 2) of the motion from beside a point."""
    orbit = map_.orbit(near - [0.0, 1e-5], map_.p)
    found = np.array([run.point for run in islice(orbit, count)])
    assert np.isfinite(found).all()
    return found


def main(fast: bool = False, out: Path | None = None) -> Results:
    """The fold-flip, by continuation and by other means.

    Parameters
    ----------
    fast
        Cycles of fewer orders.
    out
        Folder for ``system_fold_flip.png``.

    Returns
    -------
    dict
        ``w``, ``slopes`` of the point; ``border``, ``multipliers``: how far it and, beside it, the
        multipliers are from those by DOP853; ``sides``: how far it is from where one comes to that
        starts from the cycle that sticks; ``tent``, ``cycles``: words of the cycles of the tent
        map, and of those near the point.
    """
    found = followed()
    w, near = point_of(found)
    there, beside = touch((TIMES[1], w)), w + BESIDE
    known = sticking_multiplier(beside, TIMES[0]), sliding_multiplier(beside, TIMES[1])
    off = np.abs(np.subtract(both(beside, near), known))
    tent = tent_cycles(slopes_of(found), 3 if fast else ORDER)
    if out is not None:
        keep(draw(found), out / "system_fold_flip.png")
    return {
        "w": w, "slopes": list(slopes_of(found)), "border": abs(there - w),
        "multipliers": float(off.max()), "sides": abs(point_of(followed(sticks=True))[0] - w),
        "tent": sorted(turned(cycle.word) for cycle in tent),
        "cycles": own_cycles(w + CLOSE, near, tent),
    }  # fmt: skip


def draw(found: Connected) -> Figure:
    """Branches through the point, and the return beside it with both slopes."""
    figure, (left, right) = canvas(3.8, columns=2)
    w, near = point_of(found)
    known = set[str]()
    for branch in found.diagram.branches:
        stable = branch.kind is BranchKind.FIXED_POINT and (np.abs(branch.multiplier) < 1).mean()
        text = (
            "stable"
            if stable > 0.5
            else f"unstable, {branch.order} return{'s'[: branch.order - 1]}"
        )
        left.plot(
            branch.parameter, branch.x, "-" if branch.order == 1 else "--",
            color=STABLE if stable > 0.5 else UNSTABLE, label=None if text in known else text,
        )  # fmt: skip
        known.add(text)
    left.plot(w, near[0], "o", color=RED, label="fold-flip")
    left.set(xlabel="$w$", ylabel="least $x$")
    left.legend(loc="lower right")
    map_ = map_of().holding(w=w + CLOSE)
    t = 1e6 * (attractor(map_, near, 400)[SETTLED:, 1] - near[1])
    top = int(t[1:].argmax())
    for slope, end in zip(slopes_of(found), (t.min(), t.max()), strict=True):
        line = np.array([t[top], end])
        right.plot(line, t[1:][top] + slope * (line - t[top]), color=GREY, linewidth=0.8)
    right.plot(t[:-1], t[1:], ".", color=STABLE, markersize=3, label="returns")
    right.plot([], [], color=GREY, linewidth=0.8, label="tent map")
    ends = [t.min(), t.max()]
    right.plot(ends, ends, ":", color=GREY)
    right.set(xlabel=r"time [$10^{-6}$] from the point", ylabel="one return later")
    right.legend(loc="lower center")
    return figure


if __name__ == "__main__":
    command(main, "system_fold_flip")
