"""Every number the paper prints, beside what the stated model gives.

    python studies/paper_numbers.py [--fast] [--out DIR]

All of ``ours`` is computed here, by the packages. The last digit the paper prints decides whether
a number agrees: it may be off by one. Points A, B, C and the islands have no numbers in the text;
theirs are read off Figures 9 and 10.
"""

from __future__ import annotations

import json
import re
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import sympy
from fig07_frames import GUESS, SEQUENCE, cycle, frames
from fig08_return_map import DIPS, WINDOW, dip, ends
from record import ROOT, Results, command
from sensitivities import unit

from pwmap import PiecewiseLinearMap, PointKind
from woodpecker import (
    LocalModel,
    Search,
    Toy,
    bifurcation_diagram,
    continuation,
    equilibrium,
    free_frequency,
    iterated,
    jam_limit,
    local_model,
    return_map,
    shoot,
    slice_of,
    toy_map,
    toy_samples,
)
from woodpecker.edges import Edge, nearest_edge

CLOSED, DIGITS = "closed form", "30 digits (tests/woodpecker/test_reference.py)"
SIGNS, EXACT = "bisection to neighbouring doubles", "exact arithmetic"
HEAVY = "left out of the fast run"
NEAR_A = 0.05  # eps_N1: beside A of the stated model as 0.125 is beside the paper's A
COLLISIONS = ROOT / "studies" / "results" / "fig09_order_one.json"
# Read off Figures 9 and 10: eps_N1, phi_S [rad], kind and note of the point.
POINTS = {
    "A, where fixed points turn into jumps": ("0.111", "-0.884", PointKind.FF, "fold"),
    "B, where they turn back": ("0.29", "-0.884", PointKind.BC, "fold"),
    "C, where the jumps of P_2 end": ("0.185", "-0.757", PointKind.BC, "persistence"),
}
ISLAND = {  # I1, its upper end: the jump of P_1 that closes it
    "left end": ("0.35", PointKind.BC),
    "right end": ("0.389", PointKind.FF),
}
Collision = tuple[str, str, float, float]  # kind, note, eps_N1, phi_S


class Row(NamedTuple):
    """One number of the paper and ours."""

    quantity: str
    paper: str  # as printed
    ours: float | None  # None if it was left out
    checked_by: str
    remark: str = ""
    claimed: bool = True  # of the toy; not an example, nor the speed of a computer

    @property
    def relative_difference(self) -> float | None:
        """(ours - paper) / |paper|; None if ours is missing or the paper's is zero."""
        paper = float(self.paper)
        return None if self.ours is None or paper == 0.0 else (self.ours - paper) / abs(paper)

    @property
    def agrees(self) -> bool | None:
        """Whether the last digit printed differs by at most one, whole numbers by none."""
        if self.ours is None or not self.claimed:
            return None
        whole = re.fullmatch(r"-?\d+", self.paper) is not None
        return abs(self.ours - float(self.paper)) <= (0.0 if whole else 1.001 * unit(self.paper))

    def as_dict(self) -> Results:
        """All columns."""
        return {
            **self._asdict(),
            "relative_difference": self.relative_difference,
            "agrees": self.agrees,
        }


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Compute every number.

    Parameters
    ----------
    fast
        Leave out A, B, C and the islands, which need continuation.
    out
        Not used: there are no pictures.

    Returns
    -------
    dict
        ``rows``: see :class:`Row`; ``agree``, ``differ``: how many of what the paper claims of the
        toy; ``skipped``: how many were left out; ``differing``: the quantities that do not agree.
    """
    toy = Toy()
    rows = [*statics(toy), *motion(), *the_map(toy), *zoom(toy), *piecewise()]
    rows += [*special_points(toy, fast), *island(toy, fast)]
    verdicts = [row.agrees for row in rows]
    return {
        "rows": [row.as_dict() for row in rows],
        "agree": verdicts.count(True),
        "differ": verdicts.count(False),
        "skipped": sum(row.ours is None for row in rows),
        "differing": [row.quantity for row in rows if row.agrees is False],
    }


def statics(toy: Toy) -> Iterator[Row]:
    """What needs no motion."""
    rest = equilibrium(toy)
    cut = "the paper cuts the next digit off"
    yield Row("limit of |phi_M| [rad]", "0.1034", toy.phi_m_max, CLOSED)
    yield Row("limit of phi_S [rad]", "0.12", toy.phi_s_max, CLOSED)
    yield Row("equilibrium phi_M [rad]", "-0.1034", rest.phi_m, CLOSED)
    yield Row("equilibrium phi_S [rad]", "-0.2216", rest.phi_s, CLOSED, f"fixes c_phi; {cut}")
    yield Row("least mu_2 that jams there", "0.285", jam_limit(toy), CLOSED)
    free = "with J_M in entry (2, 2) of M, where the paper prints J_S"
    yield Row("frequency without contact [Hz]", "72.91", free_frequency(toy), CLOSED, free)
    printed = free_frequency(toy.replace(j_m=toy.j_s))
    yield Row("the same with M as printed [Hz]", "72.91", printed, CLOSED, "so it is a misprint")


def motion() -> Iterator[Row]:
    """The stable periodic motion at eps_N1 = 0.5."""
    orbit, trajectory = cycle()
    shown = frames(trajectory)
    yield Row("period T [s]", "0.1452", orbit.period, DIGITS, "see studies/sensitivities.py")
    yield Row("least phi_S of the motion [rad]", "-0.53", orbit.phi_s, DIGITS)
    yield Row("stable (1) or not (0)", "1", float(orbit.stable), DIGITS)
    yield Row("frames of Figure 7 in order", str(len(SEQUENCE)), len(shown), DIGITS)
    struck = [event for event in trajectory.events if event.time == shown[2].time]
    leaves = [event.symbol for event in struck] == ["I3", "D3"]
    yield Row("first upper impact detaches at once (1)", "1", float(leaves), DIGITS)
    lower = sum(event.symbol == "I2" for event in trajectory.events)
    yield Row("impacts of the lower edge", "1", lower, DIGITS, "the second follows after 2.7 ms")


def the_map(toy: Toy) -> Iterator[Row]:
    """Figure 8."""
    for number, (guess, impacts) in enumerate(zip(DIPS, ("1", "0"), strict=True), start=1):
        found = dip(toy, guess)
        yield Row(f"dip {number} of P_1 [rad]", str(guess), found.phi_s, SIGNS)
        upper = re.findall(r"I3\b", found.word)
        quantity = f"upper impacts before the fall, dip {number}"
        yield Row(quantity, impacts, len(upper), SIGNS)
    for x in ("-0.76", "-2.35"):
        edge = jump_near(toy, float(x))
        yield Row(f"jump of P_1 near {x} [rad]", x, edge.x, SIGNS)
        swapped = "upper sleeve and beak impact change their order there (1)"
        yield Row(swapped, "1", float(exchanged(edge)), SIGNS)
    rims = ends(toy)
    line = "read off Figure 8: the line of a sleeve that jams, for which mu_2 is too small"
    yield Row("right end of P_1 on a straight line [rad]", "0.11", rims.slides_from, SIGNS, line)
    yield Row("right end of the band of centres [rad]", "-0.2216", rims.band[1], CLOSED)
    start = time.perf_counter()
    return_map(toy, np.linspace(*WINDOW, 1000))
    hours = (time.perf_counter() - start) / 3600.0
    yield Row("time for 1000 points [h]", "1", hours, "clock", "the paper: about one hour", False)


def jump_near(toy: Toy, guess: float) -> Edge:
    """The largest jump within the paper's last digit of where it says one is."""
    mapped, p, steps = toy_map(toy), toy.eps_n1, np.linspace(-0.005, 0.005, 41)
    found = []
    for step in steps.tolist():
        near = nearest_edge(mapped, guess + step, p, mapped(guess + step, p).word)
        if near is not None and abs(near[0].x - guess) <= 0.005:
            found.append(near[0])
    return max(found, key=lambda edge: abs(edge.jump))


def exchanged(edge: Edge) -> bool:
    """Whether the beak and the upper edge strike in different orders on the two sides."""
    orders = [
        re.findall(r"I(1\+3|1|3)", re.sub(r"(?<=\d)[sfr-]+", "", side.word))
        for side in (edge.left, edge.right)
    ]
    differ = next(pair for pair in zip(*orders, strict=False) if pair[0] != pair[1])
    return {"1", "3"} == set(differ)


def zoom(toy: Toy) -> Iterator[Row]:
    """Figure 11: one unstable fixed point, one jump of P_1 and a single jump of P_2 beside A."""
    window, samples = (-0.95, -0.75), toy_samples(toy)
    remark = f"Figure 11; here at eps_N1 = {NEAR_A}, because A lies elsewhere"
    first = slice_of(samples, NEAR_A, window)
    second = slice_of(iterated(samples, 2, (-2.5, -0.24)), NEAR_A, window)
    unstable = sum(abs(toy_map(toy)(x, NEAR_A).slope) > 1.0 for x, _ in first.fixed_points)
    yield Row("unstable fixed points of P_1 beside A", "1", unstable, SIGNS, remark)
    yield Row("jump crossings of P_1 beside A", "1", len(first.crossings), SIGNS, remark)
    yield Row("jump crossings of P_2 beside A", "1", len(second.crossings), SIGNS, remark)


def piecewise() -> Iterator[Row]:
    """Equations 14 and 15 and Figure 12, at a = 5/4 and r = 1."""
    x, a, r = sympy.symbols("x a r", real=True)
    formula = sympy.Piecewise((r - 2, x <= 0), (r - a * x, True))
    general = PiecewiseLinearMap.from_sympy(formula, x, given=[a > 1])
    map_ = general.at({a: sympy.Rational(5, 4), r: sympy.Integer(1)})
    left, right = (float(point.x) for point in map_.fixed_points())
    yield Row("fixed point -2 + r of P_1^L", "-1", left, EXACT)
    yield Row("fixed point r/(1 + a) of P_1^L", "0.4444", right, EXACT, "4/9")
    (crossing,) = map_.jump_crossings()
    yield Row("jump crossing of P_1^L", "0", float(crossing.x), EXACT)
    second = map_.iterate(2)
    (crossing,) = second.jump_crossings()
    yield Row("jump crossing r/a of P_2^L, the only one", "0.8", float(crossing.x), EXACT)
    slopes = ("0", "1.5625", "0")  # 0, a^2, 0 of Eq. 15
    for k, (paper, piece) in enumerate(zip(slopes, second.pieces, strict=True), start=1):
        yield Row(f"slope of piece {k} of P_2^L", paper, float(piece.slope), EXACT)
    middle = float(second.pieces[1].intercept)
    yield Row("intercept (1 - a) r of piece 2", "-0.25", middle, EXACT)


def special_points(toy: Toy, fast: bool) -> Iterator[Row]:
    """A, B and C, from the branches connected with the stable motion."""
    found: list[Collision] = []
    if not fast:
        diagram = continuation(toy, shoot(toy, GUESS), "eps_n1", (0.03, 0.5))
        found = [(str(p.kind), p.note, float(p.parameter), float(p.x)) for p in diagram.points]
    remark = HEAVY if fast else "read off Figure 10"
    for name, (p, x, kind, note) in POINTS.items():
        at = nearest(found, kind, float(p), float(x), note)
        yield Row(f"{name}: eps_N1", p, at[2] if at else None, DIGITS, remark)
        yield Row(f"{name}: phi_S [rad]", x, at[3] if at else None, DIGITS, remark)
        if name.startswith("A"):
            slope = _slope(local_model(toy_map(toy), at[3], at[2])) if at else None
            example = HEAVY if fast else "5/4 is the paper's example, no measurement"
            yield Row("slope a of P_1 right of A", "1.25", slope, DIGITS, example, False)


def _slope(model: LocalModel) -> float:
    return -float(model.edge.right.slope)


def nearest(
    found: list[Collision], kind: PointKind, p: float, x: float, note: str | None = None
) -> Collision | None:
    """The point of a kind that is nearest in the parameter, at about the right angle."""
    fits = [
        point
        for point in found
        if point[0] == str(kind) and note in (None, point[1]) and abs(point[3] - x) < 0.01
    ]
    return min(fits, key=lambda point: abs(point[2] - p), default=None)


def island(toy: Toy, fast: bool) -> Iterator[Row]:
    """The upper end of island I1: from the whole diagram if it is there, or from a small one."""
    found: list[Collision] = []
    if not fast:
        found = _kept() if COLLISIONS.exists() else _searched(toy)
    for name, (p, kind) in ISLAND.items():
        at = nearest(found, kind, float(p), -0.8848)
        remark = HEAVY if fast else "read off Figure 9"
        yield Row(f"island I1 at its top, {name}: eps_N1", p, at[2] if at else None, SIGNS, remark)


def _kept() -> list[Collision]:
    """What studies/fig09_order_one.py found."""
    kept = json.loads(COLLISIONS.read_text(encoding="utf-8"))["collisions"]
    return [(kind, note, float(p), float(x)) for kind, note, p, x in kept]


def _searched(toy: Toy) -> list[Collision]:
    few = Search(slices=8)
    window = (-1.2, -0.7)
    top = bifurcation_diagram(toy, "eps_n1", (0.33, 0.4), (1,), window, search=few)
    return [(str(p.kind), p.note, float(p.parameter), float(p.x)) for p in top.points]


if __name__ == "__main__":
    command(main, "paper_numbers")
