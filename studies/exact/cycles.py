"""The cost of cycles of high order: by words, and by composition.

    python -m studies.exact.cycles [--fast] [--out DIR]

The number of pieces of the n-th iterate is that of the distinct preimages of breaks. By words, each
cycle is sought only from its leftmost point, so only words are tried that a point left of all its
images can follow. Both numbers grow as exp(n h) with the topological entropy h, that of words with
a factor of about 1/n.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pwmap import Budget, PiecewiseLinearMap, cycles, dynamics
from pwmap.maps import Progress
from studies.common.clocks import timed
from studies.common.exact_maps import P1L, TENT
from studies.common.record import Results, command
from studies.common.style import JUMP, STABLE, UNSTABLE, VIOLET, canvas, keep, small

ROTATION = PiecewiseLinearMap.from_sympy("Piecewise((s*x + d, x < 0), (s*x + d - 1, True))")
THREE = PiecewiseLinearMap.from_sympy(
    "Piecewise((-3*x/2 - 2, x < -1), (a*x, x < 1), (-3*x/2 + 2, True))"
)
SCENES: dict[str, tuple[PiecewiseLinearMap, dict[str, str]]] = {
    "rotation, slope 1/2": (ROTATION, {"s": "1/2", "d": "3/5"}),
    "P1^L, slopes 1/4, -5/4": (P1L, {"a": "5/4", "b": "1/4", "r": "3"}),
    "tent map, a = 17/10": (TENT, {"a": "17/10"}),
    "three pieces, a = 3/2": (THREE, {"a": "3/2"}),
    "tent map, a = 2": (TENT, {"a": "2"}),
}
LABELS = {  # in the picture
    "rotation, slope 1/2": "rotation with a gap, slopes 1/2",
    "P1^L, slopes 1/4, -5/4": "$P_1^L$, slopes 1/4 and $-$5/4",
    "tent map, a = 17/10": "tent map, slopes $\\pm$17/10",
    "three pieces, a = 3/2": "three pieces, slopes $\\pm$3/2",
    "tent map, a = 2": "tent map, slopes $\\pm$2",
}
COLORS = (JUMP, VIOLET, STABLE, "#636363", UNSTABLE)
ORDER = 20
PIECES = 20_000  # of an iterate at most
BUDGET = Budget(pieces=30_000)  # words of one length


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Measure and draw.

    Parameters
    ----------
    fast
        Up to order 8 only.
    out
        Folder for ``cycles.png``.

    Returns
    -------
    dict
        Of each map the topological entropy, and by order the cycles and words so far, the CPU time
        [s] by words; the pieces of the iterate and the CPU time of its fixed points, as far as that
        goes; and what the budget left out.
    """
    order = 8 if fast else ORDER
    found = {name: measured(name, order) for name in SCENES}
    if out is not None:
        keep(draw(found), out / "cycles.png")
    return found


def measured(name: str, order: int) -> Results:
    """One map by both ways."""
    map_, values = SCENES[name]
    rows: list[dict[str, float]] = []
    entropy = dynamics(map_, values).entropy

    def tell(done: Progress) -> None:
        rows.append({"order": done.order, "cycles": done.cells, "words": done.pieces})

    result, _ = timed(partial(cycles, map_, values, order, budget=BUDGET, progress=tell))
    for row in rows:
        _, seconds = timed(partial(cycles, map_, values, int(row["order"]), budget=BUDGET))
        row["cpu"] = seconds.cpu
    return {
        "entropy": [entropy.low, entropy.high],
        "words": rows,
        "composition": by_composition(map_, values, order),
        "complete": result.order,
        "left_out": result.left_out,
        "attracting": [cycle.word for cycle in result if cycle.stable],
    }


def by_composition(
    map_: PiecewiseLinearMap, values: dict[str, str], order: int
) -> list[dict[str, float]]:
    """Pieces of iterates, and the CPU time until their fixed points are known."""
    at = map_.at(values)
    rows: list[dict[str, float]] = []
    for n in range(1, order + 1):
        if rows and rows[-1]["pieces"] > PIECES / 2:
            break
        whole = PiecewiseLinearMap.from_sympy(at.to_sympy())  # nothing is known of lower orders
        fixed, seconds = timed(partial(_fixed_points, whole, n))
        rows.append({"order": n, "pieces": fixed[0], "cpu": seconds.cpu})
    return rows


def _fixed_points(map_: PiecewiseLinearMap, order: int) -> tuple[int, int]:
    iterate = map_.iterate(order)
    return len(iterate.cylinders), len(iterate.fixed_points())


def draw(found: Results) -> Figure:
    """Words and pieces over the order, and the time of both."""
    figure, axes = canvas(3.4, 1, 2)
    for (name, each), color in zip(found.items(), COLORS, strict=True):
        for ax, what, other in ((axes[0], "words", "pieces"), (axes[1], "cpu", "cpu")):
            rows, pieces = each["words"], each["composition"]
            ax.semilogy(*_columns(rows, what), color=color, label=LABELS.get(name, name))
            ax.semilogy(*_columns(pieces, other), color=color, linestyle=":")
    axes[0].set(xlabel="order $n$", ylabel="number", title="words up to $n$; pieces of $P_n$")
    axes[1].set(
        xlabel="order $n$", ylabel="CPU time [s]", title="for cycles up to $n$; for those of $P_n$"
    )
    axes[1].set_ylim(bottom=1e-3)
    axes[0].plot([], [], color="black", label="solid: by words")
    axes[0].plot([], [], color="black", linestyle=":", label="dotted: by composition")
    axes[0].legend(fontsize=6.5, loc="upper left")
    for ax in axes:
        _plain(ax)
    return figure


def _columns(rows: list[dict[str, float]], what: str) -> tuple[list[float], list[float]]:
    return [row["order"] for row in rows], [row[what] for row in rows]


def _plain(ax: Axes) -> None:
    ax.set_xticks([1, 5, 10, 15, 20])
    small(ax)


if __name__ == "__main__":
    command(main, "cycles")
