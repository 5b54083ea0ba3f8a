"""Results of the four reductions: numbers for a picture, a paragraph, and the picture."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from studies.common.record import Results
from studies.common.style import STABLE, VIOLET, WIDTH, grid


def bars(found: Results) -> list[dict[str, Any]]:
    """What is drawn: by how much the general way is slower."""
    dense = found["events"]["sampling"][-1]
    misses = dense["missed_next_to_grazing"]
    sampling = f"{dense['per_swing']} samples a swing, missing {misses}"
    rows = [
        ("closed form", "integrator with events, Python", found["closed_form"]["ratio_python"]),
        ("closed form", "order 8 without events, compiled", found["closed_form"]["ratio"]),
        ("index combinations", "Lemke's path, Python", found["contacts"]["ratio_python"]),
        ("one unknown", "five unknowns, compiled", found["shooting"]["ratio"]),
        ("isolated roots", sampling, dense["ratio"]),
    ]
    return [{"reduction": a, "against": b, "ratio": x} for a, b, x in rows]


def paragraph(found: Results) -> str:
    """The result in words, every number from the measurement."""
    smooth, hits = found["closed_form"], found["contacts"]
    shot, roots = found["shooting"], found["events"]
    sampling = roots["sampling"]
    rest = shot["largest_other_eigenvalue"]
    apart = abs(shot["eigenvalues_five"][0][0] - shot["multiplier_one"])
    first, last = sampling[0], sampling[-1]
    return (
        f"The closed form is {smooth['ratio_python']:.2g} times as quick as integrating six states "
        f"with events to {smooth['error_python']:.0e} rad, both in Python; without events and "
        f"compiled, {smooth['ratio']:.2g} times as quick as a formula of order 8 with "
        f"{1e3 * smooth['step']:.2g} ms steps, which errs by {smooth['error']:.0e} rad. "
        f"Trying index combinations is {hits['ratio_python']:.2g} times as quick as Lemke's path, "
        f"both in Python, over {hits['problems']} contact problems, {hits['with_two_contacts']} of "
        f"them with two contacts; the impulses agree to {hits['largest_difference']:.0e}, and "
        f"Lemke's path fails {hits['unsolved_by_lemke']} times. "
        f"Shooting with five unknowns costs {shot['ratio']:.2g} times as much as with one "
        f"({shot['returns_five']} returns instead of {shot['returns_one']}); its multiplier is the "
        f"same to {apart:.0e}, and the other four eigenvalues are "
        f"{f'below {rest:.0e}' if rest else 'exactly 0'}. "
        f"In {roots['phases']} phases of the map and {roots['phases_next_to_grazing']} next to "
        f"grazing, sampling finds {roots['isolated_missed']} events before the one that isolating "
        "all roots gives. Next to grazing "
        f"{first['per_swing']} samples a swing miss {first['missed_next_to_grazing']}, at "
        f"{first['ratio']:.2g} times its cost, and {last['per_swing']} samples "
        f"{last['missed_next_to_grazing']}, at {last['ratio']:.2g} times; the shortest dip of a "
        f"guard lasts {roots['shortest_dip']:.0e} s."
    )


def draw(found: Results) -> Figure:
    """Bars: how much slower the general way is. Beside them: what sampling misses."""
    figure = plt.figure(figsize=(WIDTH, 3.1), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.25, 1.0))
    rows = [row for row in found["ratios"] if row["ratio"] is not None]
    ratios = [row["ratio"] for row in rows]
    left.barh(range(len(rows)), ratios, color=STABLE, height=0.5)
    left.set_yticks(
        range(len(rows)), [f"{r['reduction']}\nagainst {r['against']}" for r in rows], fontsize=7.5
    )
    for y, x in enumerate(ratios):
        left.annotate(f"{x:.3g}", (x, y), (3, 0), textcoords="offset points", va="center",
                      fontsize=8)  # fmt: skip
    left.invert_yaxis()
    left.set(xscale="log", xlim=(1.0, 4.0 * max(ratios)))
    left.set_xlabel("time of the general way over ours [-]", fontsize=8.5)
    left.set_title("(a) what each reduction saves", fontsize=8.5, loc="left")
    _draw_sampling(right, found["events"])
    for ax in (left, right):
        grid(ax)
        ax.tick_params(axis="x", labelsize=8)
    right.tick_params(labelsize=8)
    return figure


def _draw_sampling(ax: Axes, roots: Results) -> None:
    """Events that sampling misses over what it costs."""
    rows = roots["sampling"]
    cost, missed = [r["ratio"] for r in rows], [r["missed_next_to_grazing"] for r in rows]
    ax.plot(cost, missed, "o-", color=VIOLET, markersize=4, linewidth=1.0)
    for row, x, y in list(zip(rows, cost, missed, strict=True))[::2]:
        ax.annotate(f"{row['per_swing']}", (x, y), (4, 4), textcoords="offset points",
                    fontsize=7.5, color=VIOLET)  # fmt: skip
    ax.plot(1.0, roots["isolated_missed"], "o", color=STABLE, markersize=6, clip_on=False, zorder=5)
    ax.annotate("isolated roots", (1.0, roots["isolated_missed"]), (5, 5), fontsize=7.5,
                textcoords="offset points", color=STABLE)  # fmt: skip
    ax.set(xscale="log", xlim=(0.6, 5.0 * max(cost)), ylim=(0.0, 1.12 * max(missed)))
    ax.set_xlabel("time over that of isolated roots [-]", fontsize=8.5)
    phases = f"{roots['phases_next_to_grazing']} phases"
    ax.set_ylabel(f"missed events in {phases} [-]", fontsize=8.5)
    ax.set_title("(b) sampling, times per swing", fontsize=8.5, loc="left")
