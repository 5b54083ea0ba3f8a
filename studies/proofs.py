"""Proofs: what they cost, and how wide their enclosures are, beside results in doubles.

    python -m studies.proofs [--fast] [--out DIR]

The stable cycle, the points of the main job and a part of the stable branch are proved and checked;
returns from random starts under both laws are enclosed and compared with thirty digits of a program
that shares no code. If a folder is given, certificates of cycle and points are written to it.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from random import Random
from typing import Any, Literal

import numpy as np
from flint import arb
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from mpmath import mp, mpf

from pwmap.diagrams.diagram import BranchKind, Diagram, SpecialPoint
from pwmap.proofs.document import Certificate
from studies.common.clocks import timed
from studies.common.motion import GUESS
from studies.common.record import Results, command
from studies.common.style import GREY, JUMP, STABLE, UNSTABLE, VIOLET, canvas, keep
from studies.peers.reference_mpmath import PAPER
from studies.peers.reference_mpmath import first_return as reference
from woodpecker import Toy, bifurcation_diagram, first_return, prove, return_map, shoot
from woodpecker.checking.certificate import check
from woodpecker.enclosures.balls import fraction
from woodpecker.enclosures.following import follow
from woodpecker.enclosures.forms import precision
from woodpecker.enclosures.model import BallToy
from woodpecker.enclosures.taylor import Frame
from woodpecker.proofs import NotProved

X1, X2 = -0.884773, -0.757787  # where two gaps close at once
Law = Literal["summed", "separate"]
POINTS: dict[
    str, tuple[Law, float, float]
] = {  # law, eps_N1 and phi_S of points, as near as is needed to find them in a diagram
    "A": ("summed", 0.11197091, X1),
    "B": ("summed", 0.29152171, X1),
    "C": ("summed", 0.18512695, X2),
    "end_of_branch_from_A": ("summed", 0.18815862, X2),
    "I1_left": ("summed", 0.34192345, X1),
    "I1_right": ("summed", 0.38834959, X1),
    "A_separate": ("separate", 0.04216433, X1),
    "B_separate": ("separate", 0.32103615, X1),
    "C_separate": ("separate", 0.18512695, X2),
}
SPAN, SHORT = (0.2, 0.66), (0.49, 0.5)  # of the branch
WORKERS = 2  # processes for it
DIGITS, BITS = 45, 128
Row = dict[str, Any]


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Prove, check and compare.

    Parameters
    ----------
    fast
        One point, a short branch and few returns.
    out
        Folder for the picture and for certificates.

    Returns
    -------
    dict
        For each statement the boxes, seconds to find it in doubles, to prove and to check it, and
        the width of what is enclosed; of the random returns how many hold all of the reference's
        numbers, how many are undecided and why, and seconds per return.
    """
    rows = _statements(fast, out)
    returns = _returns(12 if fast else 200)
    if out is not None:
        keep(draw(rows, returns), out / "proofs.png")
    return {"statements": rows, "returns": returns}


def _statements(fast: bool, out: Path | None) -> list[Row]:
    toy = Toy(eps_n1=0.5)
    orbit, clock = timed(lambda: shoot(toy, GUESS))
    proof, cost = timed(lambda: prove(orbit))
    rows = [_row("cycle", "period", clock.cpu, proof, cost.cpu, out)]
    diagrams: dict[str, Diagram] = {}
    for name, (law, p, x) in POINTS.items():
        if fast and name != "A":
            continue
        there = Toy(expansion_friction=law)
        if law not in diagrams:
            diagrams[law] = bifurcation_diagram(there, "eps_n1", (0.04, 0.5))
        point = _nearest(diagrams[law], p, x)
        proof, cost = timed(lambda point=point, there=there: prove(point, toy=there))  # type: ignore[misc]
        rows.append(_row(name, "p", None, proof, cost.cpu, out))
    branch = next(
        hit.branch
        for hit in bifurcation_diagram(Toy(), "eps_n1", (0.19, 0.55), window=(-0.8, -0.4)).at(0.5)
        if hit.branch.kind is BranchKind.FIXED_POINT and abs(hit.x - orbit.phi_s) < 1e-3
    )
    span = SHORT if fast else SPAN
    proof, cost = timed(lambda: prove(branch, span, workers=1 if fast else WORKERS))
    rows.append(_row("branch", "multiplier", None, proof, cost.cpu, out))
    return rows


def _nearest(diagram: Diagram, p: float, x: float) -> SpecialPoint:
    return min(diagram.points, key=lambda q: abs(q.parameter - p) + abs(q.x - x))


def _row(
    name: str, claim: str, doubles: float | None, proof: Certificate, cost: float, out: Path | None
) -> Row:
    """One statement: proved, checked, and written if it is small."""
    content = proof.content
    said, checking = timed(lambda: check(content))
    assert said == proof.statement
    if out is not None:
        folder = out / "proofs"
        folder.mkdir(exist_ok=True)
        proof.save(folder / f"{name}.json")
    values = content[claim]
    spans = [values] if isinstance(values[0], str) else values
    return {
        "name": name,
        "statement": proof.statement,
        "boxes": len(content.get("pieces", [0])),
        "doubles": doubles,
        "seconds": cost,
        "checking": checking.cpu,
        "claim": claim,
        "width": float(max(Fraction(high) - Fraction(low) for low, high in spans)),
    }


def _returns(count: int) -> Results:
    """Random returns under both laws, enclosed, against thirty digits of another program."""
    rng, widths, undecided, proving, other = Random(2025), [], [], 0.0, 0.0
    held = 0
    for k in range(count):
        law: Law = "separate" if k % 2 else "summed"
        eps, x = Fraction(rng.randrange(1, 1000), 1000), Fraction(rng.randrange(-2500, -240), 1000)
        toy = Toy(eps_n1=float(eps), expansion_friction=law)
        known, clock = timed(lambda: _reference(eps, x, law))  # noqa: B023
        other += clock.cpu
        try:
            found, clock = timed(lambda: _enclosed(toy, x))  # noqa: B023
        except NotProved as answer:
            undecided.append({"law": law, "eps_n1": float(eps), "phi_s": float(x),
                              "word": known.word, "reason": str(answer)})  # fmt: skip
            continue
        proving += clock.cpu
        values = (known.phi_s, known.period, known.drop)
        if all(_holds(ball, value) for ball, value in zip(found, values, strict=True)):
            held += 1
        widths.append(float(2 * found[0].rad()))
    decided = count - len(undecided)
    return {
        "count": count,
        "held": held,
        "undecided": undecided,
        "median_width": float(np.median(widths)),
        "seconds": proving / decided,
        "seconds_of_reference": other / count,
        "seconds_in_doubles": _in_doubles(),
        "off_in_doubles": _off(),
    }


def _reference(eps: Fraction, x: Fraction, law: str) -> Any:
    with mp.workdps(DIGITS):
        data = {
            name: value if name == "expansion_friction" else mpf(str(value))
            for name, value in {**PAPER, "eps_n1": float(eps), "expansion_friction": law}.items()
        }
        return reference(mpf(x.numerator) / x.denominator, data)


def _enclosed(toy: Toy, x: Fraction) -> tuple[Any, Any, Any]:
    """Image, period and drop, as balls."""
    with precision(BITS):
        start = arb(x.numerator) / x.denominator
        (way,) = follow(BallToy(toy), Frame(arb(0), arb(0)), [start])
        return way.image.box, way.time.box, way.drop.box


def _holds(ball: Any, value: Any) -> bool:
    """Whether a ball holds a number that is right to some 27 digits."""
    sign, mantissa, exponent, _ = value._mpf_
    x = (-1) ** sign * Fraction(int(mantissa)) * Fraction(2) ** exponent
    room = Fraction(1, 10**27)
    return bool(fraction(ball.lower()) - room <= x <= fraction(ball.upper()) + room)


def _in_doubles() -> float:
    """Seconds per return of the kernel."""
    starts = np.linspace(-0.7, -0.4, 2000)
    return_map(Toy(), starts[:10])
    return timed(lambda: return_map(Toy(), starts))[1].cpu / len(starts)


def _off() -> float:
    """How far the kernel's image of one start is from its enclosure."""
    x = Fraction(-53, 100)
    ball = _enclosed(Toy(), x)[0]
    return abs(first_return(Toy(), float(x)).phi_s - float(ball.mid()))


UNITS = {"period": "its period [s]", "p": r"$\varepsilon_{N1}$", "multiplier": "its multiplier"}
COLOURS = {"period": VIOLET, "p": UNSTABLE}
BESIDE = 0.45  # decades between statements of the same width


def draw(rows: list[Row], returns: Mapping[str, Any]) -> Figure:
    """Time against width: a return in doubles and enclosed, and the statements."""
    figure, (ax,) = canvas(4.2)
    ax.set(xscale="log", yscale="log", ylabel="CPU time [s]", ylim=(3e-6, 3.0))
    ax.set_xlabel(r"width of the answer, or error, in the unit of the legend")
    ax.plot(returns["off_in_doubles"], returns["seconds_in_doubles"], "o", color=STABLE,
            label=r"one return in doubles: its error ($\varphi_S$ [rad])")  # fmt: skip
    ax.plot(returns["median_width"], returns["seconds"], "o", color=JUMP,
            label=r"one return, enclosed ($\varphi_S$ [rad])")  # fmt: skip
    ax.plot(1e-30, returns["seconds_of_reference"], "o", color=GREY,
            label=r"one return, thirty digits, no proof ($\varphi_S$ [rad])")  # fmt: skip
    _draw_statements(ax, [row for row in rows if row["boxes"] == 1])
    for row in rows:
        if row["boxes"] > 1:
            cost = row["seconds"] / row["boxes"]
            ax.plot(row["width"], cost, "D", color=UNSTABLE,
                    label=rf"a tube of the branch, proved ({UNITS[row['claim']]})")  # fmt: skip
    ax.invert_xaxis()
    ax.legend(fontsize=7, loc="lower left")
    return figure


def _draw_statements(ax: Axes, rows: list[Row]) -> None:
    """Those on one orbit; of the same width they stand side by side, with their names."""
    for claim in dict.fromkeys(row["claim"] for row in rows):
        own = [row for row in rows if row["claim"] == claim]
        beside = 10.0 ** (BESIDE * (0.5 * (len(own) - 1) - np.arange(len(own))))
        widths = np.array([row["width"] for row in own]) * beside
        for key, marker, text in (("seconds", "s", "proved"), ("checking", "^", "checked")):
            ax.plot(
                widths, [row[key] for row in own], marker, color=COLOURS[claim],
                markersize=4.5, ls="", markerfacecolor="none",
                label=f"{'cycle' if claim == 'period' else 'points'}, {text} ({UNITS[claim]})",
            )  # fmt: skip
        for width, row in zip(widths.tolist(), own, strict=True):
            name = row["name"].partition("_from")[0].replace("_", " ")
            ax.annotate(
                name, (width, min(row["seconds"], row["checking"])), (0, -5), va="top",
                textcoords="offset points", fontsize=6.5, ha="center",
                rotation=90 if len(own) > 1 else 0,
            )  # fmt: skip


if __name__ == "__main__":
    command(main, "proofs")
