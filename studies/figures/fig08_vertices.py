"""Figure 8 of the paper against the return map, vertex by vertex and under both laws.

    python -m studies.figures.fig08_vertices [--fast] [--out DIR]

The line of Figure 8 is a vector graphic of 909 vertices (``data/figure08.csv``). Its numbers are
rounded to a grid, so P_1 at the angle of a vertex may differ from its height by half a unit, and by
the slope of P_1 times half a unit of the angle: ``within`` counts the vertices for which that
explains the difference. Two differences are given. The *vertical* one, |P_1(x) - y|, means little
where P_1 is steep. The distance *to the curve* is that to the nearest point of the graph of P_1
within two units of the angle; the graph is not joined across jumps.

The two laws differ only if two contacts take part in one of the impacts of a return (``I1+3`` in
its word). Every vertex is in one of four classes:

- ``double``: the return has an impact at two contacts;
- ``single``: it has none;
- ``jammed``: the sleeve stays jammed, so P_1 is the mirror image at the equilibrium or, left of it,
  the identity (a centre);
- ``line``: the friction cone forbids a start at rest there. The paper continues the straight line
  of a jammed sleeve, which is no motion of the toy: the distance from that line is given.

Vertices on a steep flank, beside a jump or drawn twice are counted, but stay in their class.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from studies.common.laws import LAWS, SEPARATE, SHORT, SUMMED, TITLES, TOYS
from studies.common.record import ROOT, Results, command
from studies.common.style import GREY, JUMP, PALE, RED, STABLE, UNSTABLE, WIDTH, keep
from studies.figures.fig08_return_map import WINDOW, ends
from woodpecker import ExpansionFriction, ReturnMap, Toy, equilibrium, return_map
from woodpecker.base.arrays import Floats
from woodpecker.plot.figures import FIXED, plot_return_map

VERTICES = ROOT / "studies" / "data" / "figure08.csv"
UNIT = (4.8745e-4, 6.1789e-4)  # rad: the grid of the graphic, sideways and upwards
TWICE = 2e-5  # rad: neighbours closer than this are one vertex, where two parts of the line meet
STEEP = 10.0  # slope: there half a unit sideways is more than six units upwards
OFF = 1e-3  # rad: farther from the curve than any rounding explains
SEEN = 0.02  # rad: a jump that shows in the picture
BESIDE = np.linspace(-2.0, 2.0, 81)  # units sideways, where the curve is looked for
QUANTILES = (0.5, 0.9, 0.99, 1.0)
CLASSES = ("double", "single", "jammed", "line")
DOUBLE, SINGLE, JAMMED, LINE = CLASSES
CROSSING = (-0.55, -0.51)  # rad: where the line of the paper crosses the diagonal, stable


class Compared(NamedTuple):
    """Every vertex beside P_1 under one law; arrays of shape (909,)."""

    law: ExpansionFriction
    kind: np.ndarray[tuple[int], np.dtype[np.str_]]  # one of CLASSES
    image: Floats  # P_1 there [rad]; nan where there is no return
    slope: Floats
    vertical: Floats  # |P_1(x) - y| [rad]
    to_curve: Floats  # distance to the graph [rad]; nan for LINE


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Compute P_1 at each vertex under both laws, classify, compare, draw.

    Parameters
    ----------
    fast
        Makes no difference: the study takes seconds.
    out
        Folder for ``fig08_vertices.png``.

    Returns
    -------
    dict
        ``vertices``; ``unit`` of the graphic [rad]; ``laws``: for each law and class ``count``,
        ``within``, how many lie on the map but for the rounding of the graphic, ``steep``,
        ``off``, how many are farther than 1e-3 rad from the curve, and quantiles of ``vertical``
        and ``to_curve`` [rad]; ``off_at``: where both laws are off, phi_S and height [rad];
        ``beside_a_jump``, ``drawn_twice``: how many of all; ``line``: see :func:`straight`;
        ``fixed_point``: where the paper's line crosses the diagonal at the stable motion [rad].
    """
    del fast
    x, y = vertices()
    found = [compare(x, y, law) for law in LAWS]
    if out is not None:
        keep(draw(x, y, found), out / "fig08_vertices.png")
    return {
        "vertices": len(x),
        "unit": UNIT,
        "laws": {str(each.law): described(each) for each in found},
        "off_at": off_at(x, y, found),
        "beside_a_jump": int(beside_jumps(TOYS[SUMMED], x).sum()),
        "drawn_twice": int(np.sum(np.hypot(np.diff(x), np.diff(y)) < TWICE)),
        "line": straight(x, y, found[0]),
        "fixed_point": crossing(x, y),
    }


def vertices() -> tuple[Floats, Floats]:
    """Angles and heights of the vertices of the paper's line [rad]."""
    table = np.loadtxt(VERTICES, delimiter=",")
    return table[:, 0], table[:, 1]


# --- Comparison -----------------------------------------------------------------------------------


def compare(x: Floats, y: Floats, law: ExpansionFriction) -> Compared:
    """P_1 at every vertex, and how far the vertex is from it."""
    toy = TOYS[law]
    returns = return_map(toy, x)
    kind = classes(toy, returns)
    on_map = kind != LINE
    to_curve = np.full(len(x), np.nan)
    to_curve[on_map] = distances(toy, x[on_map], y[on_map])
    return Compared(law, kind, returns.phi_s, returns.slope, np.abs(returns.phi_s - y), to_curve)


def classes(toy: Toy, returns: ReturnMap) -> np.ndarray[tuple[int], np.dtype[np.str_]]:
    """The class of every vertex, see above."""
    word = np.array(returns.words)
    kind = np.where(np.char.count(word, "+") > 0, DOUBLE, SINGLE)
    kind[word == ""] = JAMMED
    kind[returns.start > ends(toy).slides_from] = LINE
    return kind


def distances(toy: Toy, x: Floats, y: Floats) -> Floats:
    """Distance of points from the graph of P_1, sampled beside them.

    The graph is made of segments between neighbouring starts of the same word, 1/20 of a unit
    apart, and of the starts themselves.
    """
    starts = x[:, None] + UNIT[0] * BESIDE
    returns = return_map(toy, starts.ravel())
    image = returns.phi_s.reshape(starts.shape)
    word = np.array(returns.words).reshape(starts.shape)
    joined = word[:, 1:] == word[:, :-1]
    dx, dy = x[:, None] - starts, y[:, None] - image
    along, rise = np.diff(starts, axis=1), np.diff(image, axis=1)
    part = (dx[:, :-1] * along + dy[:, :-1] * rise) / (along**2 + rise**2)
    part = np.where(joined, np.clip(part, 0.0, 1.0), 0.0)
    to_segments = np.hypot(dx[:, :-1] - part * along, dy[:, :-1] - part * rise)
    nearest: Floats = np.fmin(np.nanmin(to_segments, axis=1), np.nanmin(np.hypot(dx, dy), axis=1))
    return nearest


def beside_jumps(toy: Toy, x: Floats) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Whether half a unit sideways lies a jump that shows in the picture."""
    sides = [return_map(toy, x + side * UNIT[0]) for side in (-0.5, 0.0, 0.5)]
    images = np.array([side.phi_s for side in sides])
    words = np.array([side.words for side in sides])
    steps = np.abs(np.diff(images, axis=0)) - 0.5 * UNIT[0] * np.abs(sides[1].slope)
    beside: np.ndarray[tuple[int], np.dtype[np.bool_]] = np.any(
        (steps > SEEN) & (words[1:] != words[:-1]), axis=0
    )
    return beside


# --- Numbers --------------------------------------------------------------------------------------


def described(each: Compared) -> dict[str, Results]:
    """Counts and quantiles of every class that has a motion."""
    return {name: _of_class(each, each.kind == name) for name in (DOUBLE, SINGLE, JAMMED)}


def _of_class(each: Compared, chosen: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> Results:
    vertical, to_curve = each.vertical[chosen], each.to_curve[chosen]
    rounding = 0.5 * (UNIT[1] + np.abs(each.slope[chosen]) * UNIT[0])
    return {
        "count": int(chosen.sum()),
        "within": int(np.sum(vertical <= rounding)),
        "steep": int(np.sum(np.abs(each.slope[chosen]) > STEEP)),
        "off": int(np.sum(to_curve > OFF)),
        "vertical": _quantiles(vertical),
        "to_curve": _quantiles(to_curve),
    }


def _quantiles(values: Floats) -> dict[str, float]:
    return {f"{q:g}": float(np.quantile(values, q)) for q in QUANTILES}


def off_at(x: Floats, y: Floats, found: list[Compared]) -> list[tuple[float, float]]:
    """Vertices that neither law explains: they lie on flanks of the dips, of infinite depth."""
    off = np.all([each.to_curve > OFF for each in found], axis=0)
    return list(zip(x[off].tolist(), y[off].tolist(), strict=True))


def straight(x: Floats, y: Floats, each: Compared) -> dict[str, Any]:
    """The vertices beyond the friction cone.

    Returns
    -------
    dict
        ``count``; ``from_jammed``: largest distance from the line of a sleeve that stays jammed
        [rad]; ``from_p_1``: least vertical difference from the map [rad]; ``lost``: how many of
        these starts never return.
    """
    there = each.kind == LINE
    mirror = 2.0 * equilibrium(TOYS[each.law]).phi_s - x[there]
    return {
        "count": int(there.sum()),
        "from_jammed": float(np.max(np.abs(mirror - y[there])) / np.sqrt(2.0)),
        "from_p_1": float(np.nanmin(each.vertical[there])),
        "lost": int(np.isnan(each.image[there]).sum()),
    }


def crossing(x: Floats, y: Floats) -> float:
    """Where the paper's line crosses the diagonal at the stable motion, between two vertices."""
    near = np.flatnonzero((x > CROSSING[0]) & (x < CROSSING[1]))
    above = y[near] - x[near]
    (k,) = np.flatnonzero(above[:-1] * above[1:] < 0.0)
    left, right = near[k], near[k + 1]
    return float(x[left] + above[k] * (x[right] - x[left]) / (above[k] - above[k + 1]))


# --- Picture --------------------------------------------------------------------------------------


def draw(x: Floats, y: Floats, found: list[Compared]) -> Figure:
    """Vertices over both maps, their distances over phi_S, and how these are distributed."""
    figure = plt.figure(figsize=(WIDTH, 6.6), layout="constrained")
    above, below = figure.subfigures(2, 1, squeeze=False, height_ratios=(1.15, 1.0)).flat
    for ax, each in zip(above.subplots(1, 2, sharex=True, sharey=True), found, strict=True):
        over_map(x, y, each, ax)
    above.axes[1].set_ylabel("")
    places, shares = below.subplots(1, 2)
    over_angle(x, found, places)
    shared(found, shares)
    return figure


def over_map(x: Floats, y: Floats, each: Compared, ax: Axes) -> None:
    """The vertices over the map of one law."""
    toy = TOYS[each.law]
    drawn = plot_return_map(toy, return_map(toy, np.linspace(*WINDOW, 1000)), ax, depth=-3.1)
    for name in FIXED.values():
        for mark in drawn.artists.get(name, ()):
            mark.remove()  # it would cover vertices
    for line in ax.lines:
        line.set(color=PALE if line.get_color() == STABLE else line.get_color(), linewidth=1.0)
    off = each.to_curve > OFF
    none = each.kind == LINE
    groups = ((~off & ~none, STABLE, "on the map"), (off, RED, "off the map"),
              (none, UNSTABLE, "cannot jam"))  # fmt: skip
    for chosen, colour, label in groups:
        ax.plot(
            x[chosen], y[chosen], ".", color=colour, markersize=3.0, markeredgewidth=0.0,
            label=f"{label} ({chosen.sum()})", zorder=4,
        )  # fmt: skip
    ax.set_title(TITLES[each.law], fontsize=8)
    ax.set_ylim(-3.1, 0.15)
    ax.set_xlabel(ax.get_xlabel(), fontsize=9)
    ax.set_ylabel(ax.get_ylabel(), fontsize=9)
    ax.tick_params(labelsize=7)
    handles, labels = ax.get_legend_handles_labels()
    kept = range(len(labels) - len(groups), len(labels))
    ax.legend(
        [handles[k] for k in kept], [labels[k] for k in kept], title="vertices", fontsize=6.5,
        title_fontsize=6.5, loc="lower center", bbox_to_anchor=(0.67, 0.02), markerscale=2.5,
    )  # fmt: skip


DASHES = {DOUBLE: "-", SINGLE: (0, (4, 1.5))}
COLOURS = {SUMMED: STABLE, SEPARATE: RED}


def over_angle(x: Floats, found: list[Compared], ax: Axes) -> None:
    """Distance from the curve over phi_S; only where a double impact takes part do they differ."""
    for each in found[::-1]:
        chosen = each.kind == DOUBLE
        ax.semilogy(
            x[chosen], each.to_curve[chosen], ".", color=COLOURS[each.law], markersize=3.0,
            markeredgewidth=0.0, label=f"double impact, {SHORT[each.law]}",
        )  # fmt: skip
    chosen = found[0].kind == SINGLE
    ax.semilogy(
        x[chosen], found[0].to_curve[chosen], ".", color=GREY, markersize=1.6, markeredgewidth=0.0,
        label="no double impact, both laws", zorder=1,
    )  # fmt: skip
    ax.axhspan(
        1e-9, 0.5 * np.hypot(*UNIT), color=JUMP, alpha=0.12, linewidth=0.0,
        label="rounding of the graphic",
    )  # fmt: skip
    ax.set_xlabel(r"$\varphi_S$ [rad]", fontsize=9)
    ax.set_ylabel("distance from the curve [rad]", fontsize=9)
    ax.set_ylim(3e-6, 20.0)
    _finish(ax)
    ax.legend(fontsize=6.5, loc="upper right", markerscale=2.0, framealpha=0.95)


def shared(found: list[Compared], ax: Axes) -> None:
    """How many of the vertices are closer to the curve than some distance."""
    for each in found:
        for name, dashes in DASHES.items():
            if name == SINGLE and each is not found[0]:
                continue  # the same under both laws
            distance = np.sort(each.to_curve[each.kind == name])
            share = np.arange(1, len(distance) + 1) / len(distance)
            ax.step(
                distance, share, where="post", linestyle=dashes, linewidth=1.3,
                color=GREY if name == SINGLE else COLOURS[each.law],
            )  # fmt: skip
    ax.axvspan(1e-9, 0.5 * np.hypot(*UNIT), color=JUMP, alpha=0.12, linewidth=0.0)
    ax.set(xscale="log", xlim=(3e-6, 0.6), ylim=(0.0, 1.02))
    ax.set_xlabel("distance from the curve [rad]", fontsize=9)
    ax.set_ylabel("part of the vertices that are closer", fontsize=9)
    coulomb, summed = COLOURS[SEPARATE], COLOURS[SUMMED]
    for place, height, text, colour in (
        (5e-4, 0.95, "with a double impact,\nsum (inferred)", summed),
        (5e-4, 0.82, "dashed: without, both laws", GREY),
        (2.4e-2, 0.42, "with a double\nimpact, contact\nby contact", coulomb),
    ):
        ax.text(place, height, text, fontsize=6.5, color=colour, va="top")
    _finish(ax)


def _finish(ax: Axes) -> None:
    ax.grid(alpha=0.25, linewidth=0.5)
    ax.tick_params(labelsize=7)


if __name__ == "__main__":
    command(main, "fig08_vertices")
