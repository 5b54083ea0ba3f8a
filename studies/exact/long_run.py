"""The cost of the long run: crises by order, entropy by order beside Ulam's method, random maps.

    python -m studies.exact.long_run [--fast] [--out DIR]

Ulam's method is the usual one: an interval is divided into equal bins, and a matrix says which part
of each bin is mapped to which other. Its eigenvector approximates the density. If images are not
weighted by the inverse slope, its spectral radius approximates the growth of the laps. The method
gives no bound of its error; here the error is known, since ``pwmap`` has the exact value or bounds.

The numbers that are kept were measured with ``OPENBLAS_NUM_THREADS=1``, since numpy's threads use
CPU time while they wait for one another.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from sympy import Rational

from pwmap import PiecewiseLinearMap, attractor_diagram, dynamics
from pwmap.algebra.numbers import to_double
from pwmap.longrun import Density, Dynamics
from studies.common.clocks import timed
from studies.common.exact_maps import P1L, SKEW, TENT
from studies.common.record import Results, command
from studies.common.style import JUMP, STABLE, UNSTABLE, VIOLET, canvas, keep, small

Floats = npt.NDArray[np.float64]
COLORS = (STABLE, UNSTABLE, JUMP, VIOLET)

ORDERS = (1, 2, 3, 4, 5, 6)
FAMILIES = {
    "tent map, 1.1 < a < 2.25": (TENT, "a", ("11/10", "9/4")),
    "skew tent map, a = 5/4, -5.5 < b < -1.1": (SKEW.at({"a": "5/4"}), "b", ("-11/2", "-11/10")),
    "P1^L, slopes 1/4, -5/4, 3.25 < r < 4.5": (
        P1L.at({"a": "5/4", "b": "1/4"}), "r", ("13/4", "9/2"),
    ),
}  # fmt: skip

GRAPHS = (12, 24, 48, 96)
BINS = (64, 128, 256, 512, 1024, 2048)
MAPS = {  # of none do the critical orbits end; of slopes of one size Ulam's matrix has it exactly
    "skew tent map, slopes 5/4, -7/4": (SKEW, {"a": "5/4", "b": "-7/4"}),
    "P1^L, slopes 3/2, -5/4, r = 3": (P1L, {"a": "5/4", "b": "3/2", "r": "3"}),
    "P1^L, slopes -9/10, -5/4, r = 5/2": (P1L, {"a": "5/4", "b": "-9/10", "r": "5/2"}),
}
BEST = (12, 24, 48, 96, 192)  # graphs of the bounds that errors are measured by
ROUNDS = 4000  # of multiplying by a matrix, at most
STILL = 1e-13  # change of an eigenvector in one of them

COUNT = 10  # random maps of each kind
SEED = 20
SHORTEST = 2e-5  # s; there was nothing to do
ASKED: dict[str, Callable[[Dynamics], object]] = {  # in this order: each keeps what it has found
    "attractors": lambda seen: seen.attractors,
    "basins": lambda seen: [each.basin for each in seen.attractors],
    "kneading": lambda seen: seen.kneading,
    "density": lambda seen: [each.density for each in seen.attractors],
    "exponent": lambda seen: [each.exponent_bounds for each in seen.attractors],
    "entropy": lambda seen: seen.entropy,
}


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Measure and draw.

    Parameters
    ----------
    fast
        Take lower orders, fewer bins and fewer maps.
    out
        Folder for ``long_run.png``.

    Returns
    -------
    dict
        ``crises``: of each family and order the CPU time [s], cells, crises, and how many of these
        have an exact place; ``entropy``: of each map and order of its graph the CPU time and the
        width of the bounds; ``ulam``: of each map and number of bins the CPU time and the errors of
        entropy, exponent and density, this one as the integral of its size; ``random``: CPU time
        for everything at one place, by pieces and by what attracts.
    """
    few = 2 if fast else None
    families = dict(list(FAMILIES.items())[:few])
    crises = {name: by_order(name, ORDERS[:few]) for name in families}
    entropy = {name: by_graph(name, GRAPHS[:few]) for name in MAPS}
    ulam = {name: by_bins(name, BINS[:few], BEST[: 2 if fast else None]) for name in MAPS}
    taken = dict(random_maps(2 if fast else COUNT))
    random = {kind: summed(times) for kind, times in taken.items()}
    if out is not None:
        keep(draw(crises, entropy, ulam, random), out / "long_run.png")
    return {"crises": crises, "entropy": entropy, "ulam": ulam, "random": random}


# --- Crises ---------------------------------------------------------------------------------------

Row = dict[str, float]


def by_order(name: str, orders: tuple[int, ...]) -> list[Row]:
    """Attractors of a family over its parameter, by the order up to which words are compared."""
    map_, parameter, span = FAMILIES[name]
    rows = []
    for order in orders:
        found, seconds = timed(partial(attractor_diagram, map_, parameter, span, order))
        exact = sum(not crisis.width for crisis in found.crises)
        rows.append(
            {"order": order, "cpu": seconds.cpu, "cells": len(found.cells),
             "crises": len(found.crises), "exact": exact}
        )  # fmt: skip
    return rows


# --- Entropy, and Ulam's method -------------------------------------------------------------------


def by_graph(name: str, orders: tuple[int, ...]) -> list[Row]:
    """Bounds of the entropy by the order of the graph of laps."""
    map_, values = MAPS[name]
    _ = dynamics(map_, values, orders=orders[:1]).entropy  # what is loaded only then, is now
    rows = []
    for order in orders:
        seen = dynamics(map_, values, orders=(order,))
        _ = seen.attractors  # they are known to both methods
        _, seconds = timed(partial(ASKED["entropy"], seen))
        bounds = seen.entropy
        rows.append({"order": order, "cpu": seconds.cpu, "width": bounds.high - bounds.low})
    return rows


class Ulam(NamedTuple):
    """What Ulam's method says of a map."""

    entropy: float
    exponent: float
    edges: Floats
    density: Floats


def by_bins(name: str, bins: tuple[int, ...], best: tuple[int, ...]) -> list[Row]:
    """Errors of Ulam's method by the number of bins."""
    map_, values = MAPS[name]
    seen = dynamics(map_, values, orders=best)
    (attractor,) = seen.attractors
    density = attractor.density
    assert density is not None
    entropy = 0.5 * (seen.entropy.low + seen.entropy.high)
    exponent = sum(density.exponent_bounds) / 2.0
    rows = []
    for count in bins:
        found, seconds = timed(partial(ulam, seen, count))
        rows.append(
            {"bins": count, "cpu": seconds.cpu, "entropy": abs(found.entropy - entropy),
             "exponent": abs(found.exponent - exponent), "density": apart(found, density)}
        )  # fmt: skip
    return rows


def ulam(seen: Dynamics, bins: int) -> Ulam:
    """Entropy, exponent and density of what lies in the absorbing interval, by Ulam's method."""
    assert seen.absorbing is not None
    edges = np.linspace(float(seen.absorbing.start), float(seen.absorbing.end), bins + 1)
    width = edges[1] - edges[0]
    share, laps, logs = np.zeros((bins, bins)), np.zeros((bins, bins)), np.zeros(bins)
    for branch in seen.line.branches:
        low = edges[0] if branch.lower is None else to_double(branch.lower)
        high = edges[-1] if branch.upper is None else to_double(branch.upper)
        slope, shift = to_double(branch.slope), to_double(branch.intercept)
        starts, ends = np.clip(edges[:-1], low, high), np.clip(edges[1:], low, high)
        images = np.sort(slope * np.stack([starts, ends]) + shift, axis=0)
        lower = np.maximum(images[0][:, None], edges[:-1])
        upper = np.minimum(images[1][:, None], edges[1:])
        covered = np.maximum(upper - lower, 0.0)  # of bin j, by the image of bin i
        laps += covered / width
        share += covered / (abs(slope) * width)
        logs += (ends - starts) / width * math.log(abs(slope))
    growth, _ = perron(laps)
    _, density = perron(share)
    density /= density.sum() * width
    return Ulam(math.log(growth), float(density @ logs * width), edges, density)


def perron(matrix: Floats) -> tuple[float, Floats]:
    """The spectral radius of a matrix and its left eigenvector, by multiplying.

    The mean of a vector and of its image goes on, so that cycles of bins do not keep it from
    settling.
    """
    vector = np.full(len(matrix), 1.0 / len(matrix))
    growth = 1.0
    for _ in range(ROUNDS):
        image = vector @ matrix
        growth = float(image.sum())
        after = 0.5 * (vector + image / growth)
        moved = float(np.abs(after - vector).sum())
        vector = after
        if moved < STILL:
            break
    return growth, vector


def apart(found: Ulam, density: Density) -> float:
    """The integral of the size of the difference of both densities."""
    places = np.array([to_double(x) for x in density.places])
    heights = [to_double(v) if density.exact else float(v.mid) for v in density.values]
    cuts = np.union1d(found.edges, places)
    middle = 0.5 * (cuts[1:] + cuts[:-1])
    ours = np.array([0.0, *heights, 0.0])[np.searchsorted(places, middle)]
    theirs = found.density[np.searchsorted(found.edges, middle) - 1]
    return float(np.sum(np.abs(ours - theirs) * np.diff(cuts)))


# --- Random maps ----------------------------------------------------------------------------------


def random_maps(count: int) -> Iterator[tuple[str, list[Row]]]:
    """Times for everything at one place, of so many maps of each kind that have an attractor."""
    for pieces in (2, 3):
        rng = np.random.default_rng(SEED + pieces)
        kept: dict[bool, list[Row]] = {False: [], True: []}
        while min(map(len, kept.values())) < count:
            seen = dynamics(random_map(pieces, rng))
            times = {}
            for name, ask in ASKED.items():
                _, seconds = timed(partial(ask, seen))
                times[name] = seconds.cpu
                chaotic = any(each.is_chaotic for each in seen.attractors)
                if not seen.attractors or len(kept[chaotic]) == count:
                    break
            else:
                kept[chaotic].append(times | {"everything": sum(times.values())})
        yield f"{pieces} pieces, only cycles", kept[False]
        yield f"{pieces} pieces, bands", kept[True]


def random_map(pieces: int, rng: np.random.Generator) -> PiecewiseLinearMap:
    """A map whose coefficients are sixteenths: breaks and slopes up to 2, the others up to 3."""

    def number(most: int) -> Rational:
        return Rational(int(rng.integers(-16 * most, 16 * most + 1)), 16)

    breaks = sorted({number(2) for _ in range(pieces - 1)})
    while len(breaks) < pieces - 1:
        breaks = sorted({*breaks, number(2)})
    lower = ["", *(f"x >= {each}" for each in breaks)]
    upper = [*(f"x < {each}" for each in breaks), ""]
    return PiecewiseLinearMap(
        [
            (f"({number(2)})*x + ({number(3)})", " and ".join(filter(None, ends)))
            for ends in zip(lower, upper, strict=True)
        ]
    )


def summed(times: list[Row]) -> dict[str, Row]:
    """Median and worst time of each question."""
    return {
        name: {
            "median": statistics.median(row[name] for row in times),
            "worst": max(row[name] for row in times),
            "maps": len(times),
        }
        for name in (*ASKED, "everything")
    }


# --- Picture --------------------------------------------------------------------------------------


def draw(
    crises: Mapping[str, list[Row]], entropy: Mapping[str, list[Row]],
    ulam: Mapping[str, list[Row]], taken: Mapping[str, Mapping[str, Row]],
) -> Figure:  # fmt: skip
    """Time by order; what is known of the entropy by time, both ways; times of random maps."""
    figure, axes = canvas(3.5, 1, 3)
    draw_crises(axes[0], crises)
    draw_entropy(axes[1], entropy, ulam)
    draw_random(axes[2], taken)
    for ax in axes:
        small(ax)
        ax.set_xlabel(ax.get_xlabel(), fontsize=8)
        ax.set_ylabel(ax.get_ylabel(), fontsize=8)
    return figure


def draw_crises(ax: Axes, crises: Mapping[str, list[Row]]) -> None:
    """CPU time over the order, and how many crises have an exact place at the highest."""
    for color, (name, rows) in zip(COLORS, crises.items(), strict=False):
        over, times = [row["order"] for row in rows], [row["cpu"] for row in rows]
        label = f"{_written(name)}: {rows[-1]['exact']:.0f} exact"
        ax.semilogy(over, times, "o-", color=color, markersize=3.5, linewidth=1.0, label=label)
    ax.margins(y=0.15)
    ax.set(xlabel="order of words", ylabel="CPU time [s]", title="finding crises")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), frameon=False)


def _written(name: str) -> str:
    """The name of a scene in a picture."""
    return name.replace("P1^L", "$P_1^L$").replace("-", "\N{MINUS SIGN}")


def draw_entropy(ax: Axes, entropy: Mapping[str, list[Row]], ulam: Mapping[str, list[Row]]) -> None:
    """Width of bounds and errors of Ulam's method over time."""
    for color, name in zip(COLORS, entropy, strict=False):
        for rows, key, style in ((entropy[name], "width", "o-"), (ulam[name], "entropy", "s--")):
            shown = [row for row in rows if row[key]]
            over, sizes = [row["cpu"] for row in shown], [row[key] for row in shown]
            label = _written(name) if key == "width" else None
            ax.loglog(over, sizes, style, color=color, markersize=3.5, linewidth=1.0,
                      mfc=color if key == "width" else "white", label=label)  # fmt: skip
    orders = [row["order"] for rows in entropy.values() for row in rows]
    bins = [row["bins"] for rows in ulam.values() for row in rows]
    ax.plot([], [], "o-", color="black", markersize=3.5,
            label=f"width of bounds, orders {min(orders):.0f} to {max(orders):.0f}")  # fmt: skip
    ax.plot([], [], "s--", color="black", markersize=3.5, markerfacecolor="white",
            label=f"error of Ulam's method, {min(bins):.0f} to {max(bins):.0f} bins")  # fmt: skip
    ax.set(xlabel="CPU time [s]", title="what is known of the entropy")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), frameon=False)


def draw_random(ax: Axes, taken: Mapping[str, Mapping[str, Row]]) -> None:
    """Median and worst time of random maps, question by question."""
    names = [*ASKED, "everything"]
    for number, (color, (kind, rows)) in enumerate(zip(COLORS, taken.items(), strict=False)):
        height = 0.2 * (number - 1.5)
        for k, name in enumerate(names):
            median, worst = rows[name]["median"], rows[name]["worst"]
            if worst < SHORTEST:
                continue
            label = kind if not k else None
            ax.plot(median, k + height, "o", color=color, markersize=3.5, label=label)
            ax.plot([median, worst], [k + height] * 2, color=color, linewidth=1.0)
    for first, _ in pairwise(range(len(names))):
        ax.axhline(first + 0.5, color="#d9d9d9", linewidth=0.5)
    ax.set_xscale("log")
    ax.set_yticks(range(len(names)), names)
    ax.invert_yaxis()
    ax.grid(visible=False, axis="y")
    ax.set(xlabel="CPU time [s], median to worst", title="random maps at one parameter")
    ax.legend(loc="upper center", bbox_to_anchor=(0.4, -0.2), frameon=False)


if __name__ == "__main__":
    command(main, "long_run")
