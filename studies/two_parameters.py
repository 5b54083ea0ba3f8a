"""Special points of the toy over two parameters: A, B, C, the flip, and where they meet.

    python -m studies.two_parameters [--fast] [--out DIR]

Points of the main job, and both ends of the island I1, are followed over the beak's restitution and
one more parameter. Every tenth sample of every curve is located anew by a one-parameter
computation; and A, for comparison, by bisection for the parameter at which a fixed point is lost,
which is what one would do without curves.
"""

from __future__ import annotations

import math
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from pwmap import PointKind, SpecialPoint
from studies.common.clocks import timed
from studies.common.motion import GUESS
from studies.common.record import Results, command
from studies.common.style import WIDTH, grid, keep
from studies.main_job import PAPER
from woodpecker import (
    Curve,
    Settings,
    Toy,
    ToyPieces,
    continuation,
    curve_in_two,
    local_model,
    shoot,
)
from woodpecker.plot.plane import handles, plot_curves
from woodpecker.runs import DEFAULT

FIRST, SPAN = "eps_n1", (0.0, 1.0)
SECOND = {"mu_2": (0.28, 0.36), "l_s": (0.019, 0.0222), "c_phi": (0.003, 0.012)}
NAMES, FLIP = ("A", "B", "C", "FF1", "BC2"), "PD1"
ISLAND, ON_IT = ("I1", "I1 left"), (0.388, -0.885)  # its ends, and a place on its upper arm
FINE = Settings(window=DEFAULT.window, max_step=0.006)  # some 200 places from A upwards
BESIDE = 1e-7  # rad: a collision is looked for from right beside the jump
BESIDES = (1e-7, 1e-6, 1e-8)  # the same, where a jump is steep or another one is near
# Of a diagram across a place, to both sides; the least where the curve turns over the second
# parameter, and crosses the diagram twice.
WIDTHS = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
RIGHT_AT = 1e-5  # of a special point: there its own events are not told from those of the curve
CONFIRMED = 1e-9  # in the first parameter: the same special point
NEAR = 0.1  # rad: the fixed point that is lost lies so close to the jump
HALVINGS = 40  # of an interval of 0.02, to rounding


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Follow the curves, draw them, and compare with other ways to find A.

    Parameters
    ----------
    fast
        The friction of the lower edge only, and A, B and C.
    out
        Folder for the picture ``two_parameters.png``.

    Returns
    -------
    dict
        For each second parameter and curve its kind, numbers of places and of points of codimension
        two, and why it ends; of A seconds for a number of places, the largest distance from what
        is located anew, and seconds and distance by bisection.
    """
    toy = Toy()
    points = main_points(toy)
    names = NAMES[:3] if fast else (*NAMES, FLIP)
    chosen = {name: points[name] for name in names} | ({} if fast else island_ends(toy))
    curves = {
        second: different(
            {
                name: curve_in_two(toy, point, (FIRST, second), (SPAN, span))
                for name, point in chosen.items()
            }
        )
        for second, span in list(SECOND.items())[: 1 if fast else None]
    }
    if out is not None:
        keep(draw(curves), out / "two_parameters.png")
    spans = (SPAN, (0.2975, 0.6))
    curve, clock = timed(
        lambda: curve_in_two(toy, points["A"], (FIRST, "mu_2"), spans, settings=FINE)
    )
    every = range(5, len(curve) - 5, 40 if fast else 10)
    return {
        "curves": {
            second: {
                name: _about(curve) | confirmed(toy, curve, 40 if fast else 10)
                for name, curve in own.items()
            }
            for second, own in curves.items()
        },
        "a": {"places": len(curve), "seconds": clock.wall}
        | _located_anew(toy, curve, every)
        | _bisected(toy, curve, every),
    }


def main_points(toy: Toy) -> dict[str, SpecialPoint]:
    """Special points of the main job by the names of the paper."""
    found = continuation(toy, shoot(toy, GUESS), FIRST, SPAN).named(PAPER)
    return {name: found.point(name) for name in (*NAMES, FLIP)}


def island_ends(toy: Toy) -> dict[str, SpecialPoint]:
    """Both ends of the island I1 at its top."""
    start, guess = ON_IT
    there = toy.replace(**{FIRST: start})
    found = continuation(there, shoot(there, guess), FIRST, SPAN)
    right, left = (
        next(point for point in found.points if point.kind is kind)
        for kind in (PointKind.FF, PointKind.BC)
    )
    return dict(zip(ISLAND, (right, left), strict=True))


def different(curves: dict[str, Curve]) -> dict[str, Curve]:
    """Curves without those that another one of them goes through, the other way round or not."""
    kept = dict[str, Curve]()
    for name, curve in curves.items():
        ends = [end.values for end in curve.ends]
        others = [[end.values for end in other.ends] for other in kept.values()]
        if not any(
            np.allclose(each, ends, rtol=0.0, atol=CONFIRMED)
            for other in others
            for each in (other, other[::-1])
        ):
            kept[name] = curve
    return kept


def _about(curve: Curve) -> Results:
    return {
        "kind": str(curve.kind),
        "places": len(curve),
        "points": [[str(p.kind), *p.values, p.cause] for p in curve.points[1:-1]],
        "ends": [[*p.values, p.cause, str(p.status)] for p in curve.ends],
    }


def confirmed(toy: Toy, curve: Curve, every: int) -> Results:
    """How many places of a curve, every tenth, one-parameter computations find, and how far off.

    A collision has to have the code of the curve, too. Right where words change, and at special
    points, slopes may be those of a root, or the code either: there the next place is taken.
    """
    own = {point.sample for point in curve.points} | {word.first for word in curve.words}
    special = np.column_stack([curve.values, curve.x])[
        sorted({point.sample for point in curve.points})
    ]
    taken = [
        k
        for k, place in enumerate(np.column_stack([curve.values, curve.x]))
        if not {k, k + 1} & own and np.abs(special - place).max(axis=1).min() > RIGHT_AT
    ]
    starts = range(0, len(curve) - every, every)
    places = [next(k for k in taken if k >= start) for start in starts if start <= taken[-1]]
    collisions = curve.border_index >= 0
    off = [_collision_off(toy, curve, k) if collisions else math.inf for k in places]
    off = [each if each < CONFIRMED else _crossing_off(toy, curve, k)
           for k, each in zip(places, off, strict=True)]  # fmt: skip
    found = [each for each in off if each < CONFIRMED]
    return {"looked": len(places), "confirmed": len(found), "off": max(found, default=None)}


def _collision_off(toy: Toy, curve: Curve, k: int) -> float:
    """Distance of the local model's collision of the same code; infinite if there is none."""
    first, second = curve.values[k].tolist()
    map_ = ToyPieces(toy.replace(**{curve.names[1]: second}), curve.names[0])
    x, code = float(curve.x[k, 0]), (curve.codes[k], curve.notes[k])
    for beside in BESIDES:
        for side in (1.0, -1.0):
            try:
                model = local_model(map_, x + side * beside, first, (1, 2), DEFAULT)
            except ValueError:  # no jump next to it on this side
                continue
            if (model.point.kind, model.point.note) == code:
                return float(abs(model.p - first))
    return math.inf


def _crossing_off(toy: Toy, curve: Curve, k: int) -> float:
    """Distance of the point of the same code in a diagram across the place; infinite if none.

    A collision is one, too, where the map has no jump, or shows it closer to the border only than a
    local model looks.
    """
    first, second = curve.values[k].tolist()
    map_ = ToyPieces(toy.replace(**{curve.names[1]: second}), curve.names[0])
    best = math.inf
    for width in WIDTHS:
        for part in (0.0, 0.5, -0.5):
            start = min(max(first + part * width, 0.0), 1.0)
            span = max(first - width, 0.0), min(first + width, 1.0)
            try:
                orbit = shoot(map_, float(curve.x[k, 0]), p=start, settings=DEFAULT)
                found = continuation(map_, orbit, span=span, settings=DEFAULT)
            except ValueError:  # there the cycle is too far away
                continue
            off = [
                float(abs(p.parameter - first))
                for p in found.points
                if (p.kind, p.note) == (curve.codes[k], curve.notes[k])
            ]
            best = min(best, *off, math.inf)
            if best < CONFIRMED:
                return best
    return best


def _located_anew(toy: Toy, curve: Curve, every: range) -> Results:
    """How far the local model's collisions lie from places of a curve."""
    off, alike = list[float](), 0
    for k in every:
        eps_n1, mu_2 = curve.values[k].tolist()
        map_ = ToyPieces(toy.replace(mu_2=mu_2), FIRST)
        model = local_model(map_, float(curve.x[k, 0]) + BESIDE, eps_n1, (1, 2), DEFAULT)
        off.append(abs(model.p - eps_n1))
        alike += (model.point.kind, model.point.note) == (curve.codes[k], curve.notes[k])
    return {"anew": len(off), "anew_off": max(off), "anew_alike": alike}


def _bisected(toy: Toy, curve: Curve, every: range) -> Results:
    """The same by bisecting for where the fixed point right of the jump is lost."""

    def bisect() -> float:
        return max(abs(_lost(toy, curve, k) - float(curve.values[k, 0])) for k in every)

    off, clock = timed(bisect)
    return {"bisected_seconds": clock.wall, "bisected_off": off}


def _lost(toy: Toy, curve: Curve, k: int) -> float:
    """Where shooting no longer finds a fixed point that a branch had."""
    eps_n1, mu_2 = curve.values[k].tolist()
    low, high = eps_n1 - 0.01, eps_n1 + 0.01
    x, held = float(curve.x[k, 0]), toy.replace(mu_2=mu_2)
    rate = 2.5  # dx/d eps_N1 of that branch, about
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        orbit = shoot(held.replace(eps_n1=middle), x + rate * (middle - eps_n1))
        lives = orbit.success and 0.0 < orbit.phi_s - x < NEAR
        low, high = (low, middle) if lives else (middle, high)
    return float(0.5 * (low + high))


def draw(curves: dict[str, dict[str, Curve]]) -> Figure:
    """One panel for each second parameter."""
    figure = plt.figure(figsize=(WIDTH, 0.5 * WIDTH), layout="constrained")
    axes = figure.subplots(1, len(curves), squeeze=False)[0].tolist()
    toy = Toy()
    for ax, (second, own) in zip(axes, curves.items(), strict=True):
        grid(ax)
        plot_curves(own, ax, legend=False, here=(getattr(toy, FIRST), getattr(toy, second)))
    shown = handles((curve for own in curves.values() for curve in own.values()), toy=True)
    figure.legend(handles=shown, loc="outside lower center", ncols=4, fontsize=7, frameon=False)
    return figure


if __name__ == "__main__":
    command(main, "two_parameters")
