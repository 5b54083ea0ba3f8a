"""Composing P1^L symbolically: pwmap against sympy's own Piecewise, and P1^L beyond the paper.

    python -m studies.exact.symbolic [--fast] [--out DIR]

Both compose the same map, symbolic in a and r, and alternate in rounds. The naive way substitutes
one ``Piecewise`` into the other and folds the result, which keeps empty pieces. Both results are
compared at rational points.

The paper stops at r = 2. Beyond it orbits of P1^L settle on longer cycles; the second picture shows
such an orbit, the exact diagram of orders 1 to 5, and the plane of a and r, divided into cells by
the attracting periods. :mod:`studies.figures.fig12_local_model` draws Figure 12 itself.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import matplotlib.pyplot as plt
import sympy
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from sympy import Rational

from pwmap import Diagram, PiecewiseLinearMap, PointKind, bifurcation_diagram, parameter_plane
from pwmap.plot import plot_cobweb, plot_diagram, plot_plane
from pwmap.plot.drawn import below
from studies.common.clocks import Seconds, Timing, clocked, ratio, summary
from studies.common.exact_maps import FLAT, FORMULA, PAPERS, A, R, X
from studies.common.record import Results, command
from studies.common.style import STABLE, UNSTABLE, canvas, keep, small

GIVEN = (A > 1, R > 0, R < 2)
NUMERIC = {A: Rational(5, 4), R: Rational(1)}

SYMBOLIC, NUMBERS, DIAGRAM = (
    "P1..P6 in a and r",
    "P1..P12 at a = 5/4, r = 1",
    "diagram, orders 1..5",
)
ORDERS = range(2, 7)


def ours(order: int) -> PiecewiseLinearMap:
    """P_1 to P_order from the formula's pieces, with nothing known from before."""
    start = PiecewiseLinearMap.from_sympy(FORMULA, X, given=GIVEN)
    compose(start, order)
    return start.iterate(order)


def compose(start: PiecewiseLinearMap, order: int) -> None:
    """The pieces of P_1 to P_order."""
    for j in range(1, order + 1):
        _ = start.iterate(j).pieces


def naive(order: int) -> sympy.Piecewise:
    """P_1 to P_order by substituting and folding."""
    composed = FORMULA
    for _ in range(order - 1):
        composed = sympy.piecewise_fold(FORMULA.subs(X, composed))
    return composed


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Measure, check that both ways agree, and draw.

    Parameters
    ----------
    fast
        Take one round.
    out
        Folder for ``symbolic.png`` and ``symbolic_plane.png``.

    Returns
    -------
    dict
        ``ratio_order_6``: CPU time of the naive way over ours, both reading and composing;
        ``timings``: seconds of every job; ``agree``: points at which both were compared;
        ``branches``, ``points`` of the diagram.
    """
    timings = measured(1 if fast else 15)
    found = diagram()
    if out is not None:
        keep(draw_times(timings), out / "symbolic.png")
        keep(draw_beyond(), out / "symbolic_plane.png")
    return {
        "ratio_order_6": ratio(timings, "sympy, order 6", "pwmap, order 6", "cpu"),
        "agree": agreement(),
        "branches": len(found.branches),
        "points": len(found.points),
        "timings": timings,
    }


def measured(rounds: int) -> dict[str, Timing]:
    """All jobs in turn; the first round, in which sympy fills its caches, does not count."""
    jobs = {f"pwmap, order {j}": clocked(partial(ours, j)) for j in ORDERS}
    jobs |= {f"sympy, order {j}": clocked(partial(naive, j)) for j in ORDERS}
    taken: dict[str, list[Seconds]] = {name: [] for name in (*jobs, SYMBOLIC, NUMBERS, DIAGRAM)}
    for _ in range(1 + rounds):
        sympy.core.cache.clear_cache()
        for name, job in jobs.items():
            taken[name].append(job())
        symbolic = PiecewiseLinearMap.from_sympy(FORMULA, X, given=GIVEN)
        numeric = symbolic.at(NUMERIC)
        for name, start, last in ((SYMBOLIC, symbolic, 6), (NUMBERS, numeric, 12)):
            taken[name].append(clocked(partial(compose, start, last))())
        taken[DIAGRAM].append(clocked(diagram)())
    return {name: summary(seconds[1:]) for name, seconds in taken.items()}


def diagram(orders: range = range(1, 6)) -> Diagram:
    """The exact diagram of the paper's example over r."""
    return bifurcation_diagram(PAPERS, R, (-1, 12), orders)


def agreement() -> int:
    """Number of rational points at which both ways give one value; AssertionError otherwise."""
    checked = 0
    for order in (2, 4, 6):
        exact, folded = ours(order).at(NUMERIC), naive(order).subs(NUMERIC)
        for n in range(-20, 21):
            x = Rational(n, 10)
            assert exact(x) == folded.subs(X, x), (order, x)
            checked += 1
    return checked


def draw_times(timings: dict[str, Timing]) -> Figure:
    """Time over order, for both ways."""
    figure, (ax,) = canvas(3.8)
    for name, color, marker in (("sympy", UNSTABLE, "s"), ("pwmap", STABLE, "o")):
        times = [1e3 * timings[f"{name}, order {j}"]["cpu_median"] for j in ORDERS]
        label = {"sympy": "sympy.Piecewise, folded", "pwmap": "pwmap, formula to pieces"}[name]
        ax.semilogy(list(ORDERS), times, marker=marker, color=color, label=label)
    only = 1e3 * timings[SYMBOLIC]["cpu_median"]
    ax.plot(6, only, "v", color=STABLE, label="pwmap, composing alone")
    ax.set_xlabel("order of the last iterate")
    ax.set_ylabel("CPU time for $P_1$ to $P_j$ [ms]")
    ax.set_xticks(list(ORDERS))
    ax.legend(fontsize=8)
    return figure


def draw_beyond() -> Figure:
    """P1^L beyond r = 2: an orbit, the diagram of more orders, and the plane of a and r."""
    figure, axes = canvas(3.2, 1, 3)
    beyond = PAPERS.at({R: Rational(4)})
    plot_cobweb(beyond, Rational(1, 10), 40, axes[0]).ax.set_title("an orbit, $a = 5/4$, $r = 4$")
    _legend_below(axes[0], 1)
    plot_diagram(diagram(), axes[1], kinds=(PointKind.BC, PointKind.FF))
    axes[1].set_title("orders 1 to 5, $a = 5/4$")
    plane = parameter_plane(FLAT, A, R, (1, 4), (-1, 12), range(1, 8))
    drawn = plot_plane(plane, axes[2])
    drawn.ax.set_title("attracting, orders 1 to 7")
    plt.setp(drawn.artists["names"], visible=False)  # twelve curves come close to one another:
    plt.setp(drawn.artists["border collision"], linewidth=0.7, path_effects=[])  # no white beside
    axes[1].set(xlabel="$r$", ylabel="$x$", ylim=(-3.5, 12.5))
    axes[2].set(xlabel="$a$", ylabel="$r$")
    _legend_below(axes[1], 2)
    for ax in axes:
        small(ax)
    return figure


def _legend_below(ax: Axes, columns: int) -> None:
    """The legend of an axes below it, where it covers nothing."""
    legend = ax.get_legend()
    assert legend is not None
    handles = [handle for handle in legend.legend_handles if handle is not None]
    texts = [text.get_text() for text in legend.get_texts()]
    ax.legend(handles, texts, ncols=columns, frameon=False, **below(ax))


if __name__ == "__main__":
    command(main, "symbolic")
