"""Figure 12 of the paper, its predictions for the toy next to A, and how well the toy agrees.

    python -m studies.figures.fig12_local_model [--fast] [--out DIR]

Above, the paper's picture: P_1^L and P_2^L for a = 5/4 and r = 1, and the exact diagram over r. The
paper chose that map by eye. Below, the same analysis with the numbers of the toy: the local model
of P_1 at A, two lines and a jump, is solved exactly by ``pwmap`` and predicts which branches start
there, and with which slope d phi_S / d eps_N1. The paper expected jump branches of P_3 and P_4, and
could not compute them.

The slope of P_1 right of A is -1.30491 with friction bounded by the sum (inferred, see
:mod:`studies.common.laws`), and -1.26515, at another eps_N1, with Coulomb's law contact by contact.
For the latter only the predictions are given.

The test computes the toy at distances q from A, without following any branch: fixed points by
shooting, jumps as borders of its iterates. They differ from the predicted line by c q**2 if its
slope is right, and by c q if it is wrong, so the measured power decides. (For P_4 the coefficient
of q**2 is nearly zero, and the power is larger.) The measured slope is the difference quotient of
the two smallest distances, extrapolated to q = 0.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from sympy import Rational

from pwmap import BranchKind, Diagram, PointKind
from pwmap import bifurcation_diagram as exact_diagram
from pwmap.plot import plot_diagram, plot_map
from pwmap.plot.diagrams import order_samples, place_legend
from pwmap.plot.palette import of_period
from studies.common.exact_maps import PAPERS, R
from studies.common.laws import CONTACT_BY_CONTACT, SUMMED
from studies.common.places import POINT_A, WINDOW, collision
from studies.common.record import Results, command
from studies.common.style import WIDTH, grid, keep, small
from woodpecker import Search, Toy, ToyPieces, bifurcation_diagram, local_model, shoot
from woodpecker.base.settings import Settings
from woodpecker.maps import Iterate
from woodpecker.plot.figures import plot_local
from woodpecker.slices import LocalModel, Start, borders_in, crosses

AROUND_A = (0.1099, 0.1141), (-0.91, -0.86)  # eps_N1, phi_S [rad]
OTHER_A = (-0.8847733440138, 0.0421643309)  # phi_S [rad], eps_N1: the model is made at just these
REACH = 2e-3  # in eps_N1: how far the picture goes from A
SCALES = Settings(window=WINDOW, finest=1e-9)  # jumps are looked for in 1e-5 rad
DISTANCES = (2e-4, 1e-4, 5e-5, 2.5e-5)  # in eps_N1; the next change of word is 5e-4 away
ROUNDING = 1e-14  # errors [rad] that are zero: some spacings of doubles at a phi_S of 1


class Agreement(NamedTuple):
    """A branch that the local model predicts, and what the toy shows."""

    kind: BranchKind
    order: int
    predicted: float  # d phi_S / d eps_N1 [rad]
    measured: float
    errors: tuple[float, ...]  # distance from the straight line at DISTANCES [rad]
    power: float | None  # of q that the errors follow; None if they are rounding

    @property
    def name(self) -> str:
        """For tables and legends."""
        return f"{self.kind} of P_{self.order}"


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Predict, measure, draw.

    Parameters
    ----------
    fast
        The diagram of the toy has orders 1 and 2 only, not 1 to 4.
    out
        Folder for ``fig12.png``.

    Returns
    -------
    dict
        ``a``: place of A, the slope there, its kind, and the predicted slopes by branch;
        ``separate``: the same with Coulomb's law contact by contact; ``agreements``: see
        :class:`Agreement`, by branch; ``expected_power``, or more; ``largest_relative_error`` of
        the slopes that are not zero; ``branches``, ``points`` of the exact diagram of the paper.
    """
    diagram = toy_diagram(fast)
    model = model_at(diagram)
    found = [agreement(model, start) for start in model.starts]
    paper = papers_diagram()
    if out is not None:
        keep(draw(paper, model, diagram, found), out / "fig12.png")
    return {
        "a": described(model),
        "separate": described(local_model(ToyPieces(CONTACT_BY_CONTACT), *OTHER_A)),
        "agreements": {each.name: each._asdict() for each in found},
        "expected_power": 2,
        "largest_relative_error": max(
            abs(each.measured / each.predicted - 1.0) for each in found if each.predicted
        ),
        "branches": len(paper.branches),
        "points": len(paper.points),
    }


def described(model: LocalModel) -> Results:
    """A border collision in numbers."""
    return {
        "eps_n1": model.p,
        "phi_s": model.x,
        "slope": model.right.slope,
        "kind": str(model.point.kind),
        "predicted": {f"{start.kind} of P_{start.order}": start.slope for start in model.starts},
    }


def toy_diagram(fast: bool) -> Diagram:
    """Everything that the toy has next to A."""
    orders, search = ((1, 2), Search(slices=6)) if fast else ((1, 2, 3, 4), Search())
    span, window = AROUND_A
    return bifurcation_diagram(Toy(), "eps_n1", span, orders, window, search=search)


def model_at(diagram: Diagram) -> LocalModel:
    """The local model at A, as sharp as the diagram knows A."""
    point = collision(diagram, POINT_A[SUMMED])
    assert point is not None
    return local_model(ToyPieces(Toy()), point.x, point.parameter)


# --- Predicted and measured -----------------------------------------------------------------------


def agreement(model: LocalModel, start: Start) -> Agreement:
    """One branch of the model beside the toy's own, at some distances from A."""
    places = np.array([place(model, start, q) for q in DISTANCES]) - model.x
    q = np.array(DISTANCES)
    quotients = start.side * places / q
    errors = np.abs(places - start.side * start.slope * q)
    power = np.polyfit(np.log(q), np.log(errors), 1)[0] if errors.max() > ROUNDING else None
    return Agreement(
        start.kind, start.order, start.slope, float(2.0 * quotients[-1] - quotients[-2]),
        tuple(errors.tolist()), None if power is None else float(power),
    )  # fmt: skip


def place(model: LocalModel, start: Start, q: float) -> float:
    """Where the toy has the branch at the distance q from A [rad].

    A jump is looked for within a fifth of what the prediction moves by, so that no other is met:
    the nearest two branches, of P_2 and P_4, differ by a sixth of it, but in their order.
    """
    p = model.p + start.side * q
    expected = model.x + start.side * start.slope * q
    if start.kind is BranchKind.FIXED_POINT:
        return shoot(Toy(eps_n1=p), expected, order=start.order).phi_s
    reach = 0.2 * (abs(start.slope) or 1.0) * q
    map_ = Iterate(ToyPieces(Toy()), start.order)
    borders = borders_in(map_, p, (expected - reach, expected + reach), SCALES)
    (jump,) = filter(crosses, borders)
    return jump.x


# --- Picture --------------------------------------------------------------------------------------


def papers_diagram() -> Diagram:
    """Orders 1 and 2 over r, a little further than the paper draws them."""
    return exact_diagram(PAPERS, R, (Rational(-1, 2), Rational(5, 2)))


def draw(paper: Diagram, model: LocalModel, diagram: Diagram, found: list[Agreement]) -> Figure:
    """The paper's three pictures, and the toy's three."""
    figure = plt.figure(figsize=(WIDTH, 6.4), layout="constrained")
    above, below = figure.subfigures(2, 1, squeeze=False, height_ratios=(1.0, 1.15)).flat
    draw_paper(paper, above.subplots(1, 3))
    toy, order = below.subfigures(1, 2, width_ratios=(2.0, 1.0))
    plot_local(model, _called_a(diagram, model), toy, reach=REACH)
    for ax in toy.axes:
        ax.tick_params(labelsize=7)
    toy.axes[0].set_title("the toy at A, prediction in grey", fontsize=8)
    toy.axes[1].set_title(f"exact, with the toy's slope {model.right.slope:.5f}", fontsize=8)
    draw_errors(found, order.subplots())
    return figure


def _called_a(diagram: Diagram, model: LocalModel) -> Diagram:
    """The diagram with the paper's name of the collision."""
    return diagram.named({"A": (model.p, model.x)})


def draw_paper(paper: Diagram, axes: list[Axes]) -> None:
    """P_1^L, P_2^L and their diagram over r [Leine2001, Fig. 12]."""
    map_, window = PAPERS.at({R: 1}), (-1.5, 1.5)
    for j, ax in zip((1, 2), axes[:2], strict=True):
        plot_map(map_.iterate(j), ax, window=window, legend=j == 2)
        ax.set_title(rf"$P_{j}^L$, $a = 5/4$, $r = 1$")
        ax.set_ylabel(rf"$P_{j}^L(x)$")
        ax.set_ylim(-1.7, 1.7)
    drawn = plot_diagram(paper, axes[2], kinds=(PointKind.BC, PointKind.FF), legend=False)
    axes[2].set(xlabel="$r$", ylabel="$x$", ylim=(-2.9, 5.4))  # the legend is above the branches
    shown = {name: [*artists] for name, artists in drawn.artists.items()}
    place_legend(axes[2], shown, more=order_samples(paper, shown))
    axes[2].set_title("orders 1 and 2, $a = 5/4$")
    for ax in axes:
        small(ax)


def draw_errors(found: list[Agreement], ax: Axes) -> None:
    """Distance of the toy from the straight lines, over the distance from A."""
    markers = iter("so^vD")
    for each in found:
        if each.power is None:
            continue
        jump = each.kind is BranchKind.JUMP
        ax.loglog(
            DISTANCES, each.errors, next(markers), markersize=4.5, mfc="white",
            color=of_period(each.order),
            label=f"{'jump' if jump else 'fixed point'} of $P_{each.order}$",
        )  # fmt: skip
    q = np.array(DISTANCES)
    top = max(each.errors[0] for each in found)
    ax.loglog(q, 2.0 * top * (q / q[0]) ** 2, color="#252525", linewidth=0.9, label="slope 2")
    grid(ax)
    ax.set_title("toy less prediction", fontsize=8)
    ax.set_xticks(DISTANCES, [f"{1e5 * each:g}" for each in DISTANCES])
    ax.minorticks_off()
    ax.set_xlabel(r"$10^5\,(\varepsilon_{N1} - \varepsilon_{N1,A})$")
    ax.set_ylabel("error [rad]")
    ax.tick_params(labelsize=7)
    ax.legend(fontsize=6)


if __name__ == "__main__":
    command(main, "fig12_local_model")
