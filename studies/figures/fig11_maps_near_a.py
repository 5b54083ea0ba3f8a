"""Figure 11 of the paper: P_1 and P_2 next to their jump at -0.8848, under both laws.

    python -m studies.figures.fig11_maps_near_a [--fast] [--out DIR]

The paper draws eps_N1 = 0.125, between its points A and C. There an unstable fixed point of P_1
lies between two jumps, beside a jump crossing of P_1 and a single one of P_2, at the point that P_1
maps to its jump. At A the upper limit of the jump reaches the diagonal; below A the map lies under
the diagonal there, and nothing of this remains.

With friction bounded by the sum of both normal impulses (inferred, see :mod:`studies.common.laws`)
A lies at 0.11197, and the maps at 0.125 are those of the paper. With Coulomb's law contact by
contact A lies at 0.04216, and at 0.125 the unstable fixed point has already met the other jump, at
-0.7578: the column for that law differs from the paper.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from pwmap.plot import axis_label
from studies.common.laws import SEPARATE, SHORT, SUMMED, TOYS
from studies.common.record import Results, command
from studies.common.style import GREY, JUMP, STABLE, UNSTABLE, canvas, keep
from woodpecker import ExpansionFriction, ToyPieces
from woodpecker.base.arrays import Floats
from woodpecker.base.settings import Settings
from woodpecker.maps import Iterate
from woodpecker.slices import Border, BorderKind, borders_in, crosses
from woodpecker.slices.extents import PieceExtent
from woodpecker.slices.partition import Partition, partition
from woodpecker.slices.slices import slices_at

POINT_A = (0.1119709145, -0.8847733440)  # eps_N1, phi_S [rad], with the sum
PAPER = 0.125  # where the paper draws P_1 and P_2
COLUMNS = (  # of the picture: law and eps_N1
    (SUMMED, 0.105),
    (SUMMED, POINT_A[0]),
    (SUMMED, PAPER),
    (SEPARATE, PAPER),
)
ORDERS = (1, 2)
WINDOW = (-1.15, -0.68)  # rad: starts
SHOWN = (-1.4, -0.4)  # rad: images
TOUCHES = 1e-9  # rad: A has ten digits; a fixed point or a limit this near to a jump lies on it
SEEN = 0.01  # rad: a jump that shows in the picture
SCALES = Settings(window=WINDOW)
POINTS = 50  # of a piece, as a line
DOTS = (0, (1, 1.3))
LOW = 0.02  # rad: above the frame, where a jump leaves it
BELOW: dict[str, Any] = {"color": STABLE, "marker": "v", "markersize": 4.5, "linestyle": "none"}


class Fixed(NamedTuple):
    """A fixed point of P_j."""

    phi_s: float
    slope: float

    @property
    def stable(self) -> bool:
        """Whether it attracts."""
        return abs(self.slope) < 1.0


class Scene(NamedTuple):
    """What P_j shows in the window of the picture, under one law and at one parameter."""

    law: ExpansionFriction
    eps_n1: float
    order: int
    map: Partition
    fixed_points: tuple[Fixed, ...]
    jumps: tuple[Border, ...]

    @property
    def crossings(self) -> list[Border]:
        """Jumps over the diagonal; not one that a limit of it lies on, as at A."""
        return [
            jump
            for jump in self.jumps
            if crosses(jump)
            and min(abs(side.value - jump.x) for side in (jump.inner, jump.outer)) > TOUCHES
        ]


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Cut the maps into pieces, list what lies on the diagonal, draw.

    Parameters
    ----------
    fast
        Makes no difference: it takes some seconds.
    out
        Folder for ``fig11.png``.

    Returns
    -------
    dict
        ``scenes``: for each law, parameter and order the fixed points (phi_S and slope) and the
        jump crossings (phi_S and both limits); ``gap``: how far the upper limit of the jump of P_1
        is above the diagonal, by column; ``paper``: what the paper draws at 0.125, and for each law
        what P_1 and P_2 show there.
    """
    del fast
    scenes = [scene(law, p, order) for law, p in COLUMNS for order in ORDERS]
    if out is not None:
        keep(draw(scenes), out / "fig11.png")
    there = [described(each) for each in scenes if each.eps_n1 == PAPER]
    return {
        "scenes": [described(each) for each in scenes],
        "gap": [(str(each.law), each.eps_n1, gap(each)) for each in scenes if each.order == 1],
        "paper": {
            "eps_n1": PAPER,
            "drawn": {
                "stable": 1, "unstable": 1, "jump crossings of P_1": 1, "jump crossings of P_2": 1,
            },
            **{str(law): shown(law, there) for law in (SUMMED, SEPARATE)},
        },
    }  # fmt: skip


def shown(law: ExpansionFriction, scenes: list[Results]) -> Results:
    """The same counts as the paper's, from the scenes of one law."""
    one, two = (each for each in scenes if each["law"] == str(law))
    return {
        "stable": one["stable"],
        "unstable": one["unstable"],
        "jump crossings of P_1": len(one["crossings"]),
        "jump crossings of P_2": len(two["crossings"]),
    }


def scene(law: ExpansionFriction, eps_n1: float, order: int) -> Scene:
    """P_order over a window: its pieces, its fixed points and its jump crossings."""
    map_ = Iterate(ToyPieces(TOYS[law]), order)
    (found,) = slices_at(map_, eps_n1, (1,), SCALES)
    borders = borders_in(map_, eps_n1, WINDOW, SCALES)
    jumps = tuple(border for border in borders if border.kind(SCALES) is BorderKind.JUMP)
    fixed = tuple(
        Fixed(x, cycle.multiplier)
        for cycle in found.cycles
        if all(abs((x := float(cycle.x[0])) - jump.x) > TOUCHES for jump in jumps)
    )
    return Scene(law, eps_n1, order, partition(map_, eps_n1, WINDOW, SCALES), fixed, jumps)


def described(each: Scene) -> Results:
    """A scene in numbers."""
    return {
        "law": str(each.law),
        "eps_n1": each.eps_n1,
        "order": each.order,
        "fixed_points": [tuple(point) for point in each.fixed_points],
        "stable": sum(point.stable for point in each.fixed_points),
        "unstable": sum(not point.stable for point in each.fixed_points),
        "crossings": [(jump.x, jump.inner.value, jump.outer.value) for jump in each.crossings],
    }


def gap(each: Scene) -> float:
    """Upper limit of the jump at -0.8848, less its place [rad]."""
    at_a = min(each.jumps, key=lambda jump: abs(jump.x - POINT_A[1]))
    return at_a.outer.value - at_a.x


# --- Picture --------------------------------------------------------------------------------------


def draw(scenes: list[Scene]) -> Figure:
    """P_1 above P_2, a column for each law and parameter."""
    figure, axes = canvas(5.2, len(ORDERS), len(COLUMNS))
    for each in scenes:
        row, column = ORDERS.index(each.order), COLUMNS.index((each.law, each.eps_n1))
        ax = axes[row * len(COLUMNS) + column]
        panel(each, ax)
        if row == 0:
            at = " (A)" if each.eps_n1 == POINT_A[0] else ""
            ax.set_title(
                f"{SHORT[each.law]}\n" rf"$\varepsilon_{{N1}} = {each.eps_n1:.3g}${at}", fontsize=8
            )
        else:
            ax.set_xlabel(axis_label("phi_s"), fontsize=9)
        if column == 0:
            ax.set_ylabel(rf"$P_{each.order}(\varphi_S)$ [rad]", fontsize=9)
        ax.tick_params(labelsize=7, labelbottom=row == 1, labelleft=column == 0)
    figure.legend(
        handles=legend(), loc="outside lower center", ncols=7, fontsize=6.5, columnspacing=1.0
    )
    return figure


def panel(each: Scene, ax: Axes) -> None:
    """One map with the diagonal and what lies on it."""
    ax.plot(WINDOW, WINDOW, color=GREY, linewidth=0.8)
    for piece in each.map.cylinders:
        ax.plot(*drawn(piece, each.eps_n1), color="#252525", linewidth=1.2)
    for jump in each.jumps:
        limits = (jump.inner.value, jump.outer.value)
        if jump in each.crossings:
            ax.plot([jump.x, jump.x], limits, color=JUMP, linestyle=DOTS, linewidth=1.5)
            ax.plot(jump.x, jump.x, "o", color=JUMP, mfc="none", markersize=5, mew=1.2, zorder=4)
        elif abs(jump.jump) > SEEN:
            ax.plot([jump.x, jump.x], limits, color=GREY, linestyle=DOTS, linewidth=0.9)
        if min(limits) < SHOWN[0] < max(limits):
            ax.plot(jump.x, SHOWN[0] + LOW, **BELOW)
    for point in each.fixed_points:
        color = STABLE if point.stable else UNSTABLE
        face = color if point.stable else "white"
        ax.plot(
            point.phi_s, point.phi_s, "o", color=color, mfc=face, markersize=5, mew=1.3, zorder=5
        )
    ax.set(xlim=WINDOW, ylim=SHOWN, xticks=(-1.1, -0.9, -0.7), yticks=(-1.4, -1.0, -0.6))


def drawn(piece: PieceExtent, p: float) -> tuple[Floats, list[float]]:
    """A piece as a line: its samples are too far apart to be joined, so it is asked again."""
    x = np.linspace(piece[0].x, piece[-1].x, POINTS)
    near = np.searchsorted([knot.x for knot in piece], x).clip(max=len(piece) - 1)
    images = (piece[k].image.piece.at(a, p) for k, a in zip(near, x.tolist(), strict=True))
    return x, [image.value for image in images]


def legend() -> list[Line2D]:
    """What lines and markers mean."""
    return [
        Line2D([], [], color="#252525", linewidth=1.2, label="map"),
        Line2D([], [], color=GREY, linewidth=0.8, label="diagonal"),
        Line2D([], [], color=GREY, linewidth=0.9, linestyle=DOTS, label="jump"),
        _dot("jump crossing", JUMP, "none"),
        _dot("stable fixed point", STABLE, STABLE),
        _dot("unstable fixed point", UNSTABLE, "white"),
        Line2D([], [], label="goes on below", **BELOW),
    ]


def _dot(label: str, color: str, face: str) -> Line2D:
    return Line2D(
        [], [], color=color, markerfacecolor=face, label=label, linestyle="none", marker="o",
        markersize=5, markeredgewidth=1.3,
    )  # fmt: skip


if __name__ == "__main__":
    command(main, "fig11_maps_near_a")
