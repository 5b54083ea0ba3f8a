"""Figure 8 of the paper: the return map P_1 at eps_N1 = 0.5, its jumps, its dips and its edges.

    python -m studies.figures.fig08_return_map [--fast] [--out DIR]

It shows three facts that the paper's sampled map could not. A dip is not symmetric: on its left the
value falls like the inverse square root of the distance to its centre, on its right like its
logarithm. Left of the equilibrium the map is the identity (the band of centres). Right of the angle
where friction at contact 2 no longer holds the toy at rest, a start on the section slides at once;
the straight line that the paper draws there is the mirror image at the equilibrium, the motion of a
sleeve that stays jammed, which the friction cone forbids.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from studies.common.places import SCALES
from studies.common.record import Results, command
from studies.common.style import GREY, PALE, RED, STABLE, canvas, keep
from woodpecker import Toy, ToyPieces, equilibrium, first_return, return_map
from woodpecker.base.settings import Settings
from woodpecker.plot.figures import plot_return_map
from woodpecker.slices import Border, BorderKind, borders_in, nearest_border
from woodpecker.slices.partition import partition
from woodpecker.slices.slices import slices_at

WINDOW = (-2.5, 0.11)  # rad, the paper's
SEEN = 0.02  # rad: a jump that shows in the picture
WIDE = 1e-5  # rad: pieces that are counted; in the dips there are infinitely many thinner ones
COUNTED = Settings(window=SCALES.window, finest=3e-6, coarse=3e-6)  # of the window: 7e-6 rad
DIPS = (-1.23, -0.27)  # rad, the paper's
BESIDE = 0.01  # rad: from there the centre of a dip is bisected; on its right is one word only
NEAR = np.logspace(-6, -12, 13)  # rad: distances at which the flanks of a dip are measured


class Dip(NamedTuple):
    """A place where the toy never returns."""

    phi_s: float  # its centre [rad]; the next double is on the other side
    word: str  # of the piece on its right
    left_power: float  # P_1 ~ -c distance^power on the left
    right_log: float  # P_1 ~ c log10(distance) on the right [rad per decade]
    deepest: float  # value at the double left of the centre [rad]


class Ends(NamedTuple):
    """What becomes of the map on the right [rad]."""

    band: tuple[float, float]  # of centres: P_1 is the identity
    slides_from: float  # starts beyond it cannot jam
    falls_from: float  # starts beyond it fall freely for ever
    falls_to: float


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Cut the map into pieces, locate what is special, draw.

    Parameters
    ----------
    fast
        Draw 400 starts, not the paper's 1000.
    out
        Folder for ``fig08.png``.

    Returns
    -------
    dict
        ``fixed_points``: phi_S [rad] and slope; ``jumps``: phi_S and both limits [rad] of each
        jump of more than 0.02 rad; ``causes``: what happens there; ``dips``: see :class:`Dip`;
        ``ends``: see :class:`Ends`; ``mirror_error``: largest distance of P_1 from
        2 phi_S,eq - phi_S between the equilibrium and ``slides_from`` [rad]; ``pieces``: number of
        pieces wider than 1e-5 rad left of the band of centres.
    """
    toy = Toy()
    dips = [dip(toy, guess) for guess in DIPS]
    rims = ends(toy)
    map_, left = ToyPieces(toy), (WINDOW[0], rims.band[0] - BESIDE)
    jumps = seen(borders_in(map_, toy.eps_n1, left, SCALES))
    pieces = partition(map_, toy.eps_n1, left, COUNTED).cylinders
    (found,) = slices_at(map_, toy.eps_n1, (1,), Settings(window=left))
    points = [(float(orbit.x[0]), orbit.multiplier) for orbit in found.cycles]
    if out is not None:
        keep(draw(toy, rims, 400 if fast else 1000), out / "fig08.png")
    swing = np.linspace(equilibrium(toy).phi_s, rims.slides_from, 102)[1:-1]
    mirror = 2.0 * equilibrium(toy).phi_s - swing
    return {
        "fixed_points": points,
        "jumps": [(jump.x, jump.inner.value, jump.outer.value) for jump in jumps],
        "causes": sorted({jump.cause for jump in jumps}),
        "dips": [each._asdict() for each in dips],
        "ends": rims._asdict(),
        "mirror_error": float(np.max(np.abs(return_map(toy, swing).phi_s - mirror))),
        "pieces": sum(piece[-1].x - piece[0].x > WIDE for piece in pieces),
    }


def seen(borders: list[Border]) -> list[Border]:
    """Jumps that show in the picture: large, and not below it."""
    return [
        border
        for border in borders
        if border.kind(SCALES) is BorderKind.JUMP
        and abs(border.jump) > SEEN
        and min(border.inner.value, border.outer.value) > WINDOW[0]
    ]


def dip(toy: Toy, guess: float) -> Dip:
    """The centre of a dip, to neighbouring doubles, and how its flanks fall.

    On the right the sleeve slides and jams again (the word ends in J2); on the left contact 2 opens
    first, with hardly any relative speed, and the toy falls.
    """
    right, left = bisect(toy, guess + BESIDE, guess - BESIDE)
    values = [return_map(toy, left - NEAR).phi_s, return_map(toy, right + NEAR).phi_s]
    decades = np.log10(NEAR)
    power = np.polyfit(decades, np.log10(-values[0]), 1)[0]
    per_decade = np.polyfit(decades, values[1], 1)[0]
    word = first_return(toy, guess + BESIDE).word
    return Dip(left, word, float(power), float(per_decade), first_return(toy, left).phi_s)


def ends(toy: Toy) -> Ends:
    """The band of centres, and where a start slides and falls.

    The sleeve stays jammed on one piece of the map, which ends where it only just sticks. That a
    toy falls for ever is no piece: the ends of these starts are bisected to neighbouring doubles.
    """
    rest = equilibrium(toy).phi_s
    map_, starts = ToyPieces(toy), (rest - 1e-3, rest + 1e-3)
    borders = [nearest_border(map_, x, toy.eps_n1, 0.1) for x in starts]
    jams, slides = (border.x for border in borders if border is not None)
    middle = 0.5 * (-toy.phi_m_max)  # of the starts that fall
    falls = [bisect(toy, middle, x)[0] for x in (slides, 0.1)]
    return Ends((jams, rest), slides, *falls)


def bisect(toy: Toy, inside: float, outside: float) -> tuple[float, float]:
    """Neighbouring doubles between which the toy ceases to do what it does from ``inside``."""
    here = first_return(toy, inside)
    while True:
        middle = 0.5 * (inside + outside)
        if middle in (inside, outside):
            return inside, outside
        there = first_return(toy, middle)
        if (there.status, there.word) == (here.status, here.word):
            inside = middle
        else:
            outside = middle


def draw(toy: Toy, rims: Ends, starts: int) -> Figure:
    """The whole map, and what is beside the equilibrium."""
    figure, (whole,) = canvas(5.0)
    returns = return_map(toy, np.linspace(*WINDOW, starts))
    plot_return_map(toy, returns, whole)
    forbidden(toy, rims, whole)
    for k, guess in enumerate(DIPS):
        whole.annotate(
            f"dip {k + 1}", (guess, -1.75), (6 if k == 0 else -9, 0), textcoords="offset points",
            ha="left" if k == 0 else "right", fontsize=8,
        )  # fmt: skip
    zoom(toy, rims, whole.inset_axes((0.095, 0.1, 0.33, 0.44)))
    whole.legend(fontsize=8, loc="center", bbox_to_anchor=(0.68, 0.155), framealpha=0.95)
    return figure


def forbidden(toy: Toy, rims: Ends, ax: Axes) -> None:
    """What a sleeve would do that stays jammed where friction cannot hold it."""
    x = np.array([rims.slides_from, WINDOW[1]])
    ax.plot(
        x, 2.0 * equilibrium(toy).phi_s - x, color=RED, linestyle=(0, (2, 2)), linewidth=1.0,
        label="if it could stay jammed",
    )  # fmt: skip


def zoom(toy: Toy, rims: Ends, ax: Axes) -> None:
    """The map around the equilibrium, on a scale of its own."""
    low, high = -0.262, -0.162
    x = np.linspace(low, high, 600)
    ax.plot(x, return_map(toy, x).phi_s, color=STABLE, linewidth=1.1)
    ax.plot(x, x, color=GREY, linewidth=0.8)
    ax.plot(rims.band, rims.band, color=PALE, linewidth=5.0, zorder=0.9, solid_capstyle="butt")
    forbidden(toy, rims, ax)
    ax.axvline(rims.slides_from, color=GREY, linewidth=0.7, linestyle=(0, (5, 3)))
    ax.text(rims.slides_from + 0.002, -0.2235, "slides\nat once", fontsize=7, va="bottom")
    ax.text(math.fsum(rims.band) / 2 - 0.003, -0.228, "centres", fontsize=7, ha="right")
    ax.set(xlim=(low, high), ylim=(-0.30, -0.205))
    ax.tick_params(labelsize=7)
    for label in ax.get_yticklabels():  # the diagonal of the whole map passes behind them
        label.set_bbox({"facecolor": "white", "edgecolor": "none", "pad": 0.6})
    ax.set_facecolor("white")
    ax.grid(alpha=0.25, linewidth=0.5)


if __name__ == "__main__":
    command(main, "fig08_return_map")
