"""Every number the paper prints, beside what the model gives under both laws.

    python -m studies.paper_numbers [--fast] [--out DIR]

``ours`` is computed here by the packages, with friction in the expansion of an impact at two
contacts bounded by the sum of both normal impulses. That this is the paper's law is inferred from
its figures; ``separate`` is the value under Coulomb's law contact by contact, where that differs. A
number agrees if the last digit that the paper prints is off by one at most. The text gives no
numbers for the points A, B, C and the islands; theirs are read off Figures 9 and 10.
"""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pwmap import BranchKind, Diagram, PointKind, SpecialPoint
from studies.common.exact_maps import PAPERS
from studies.common.laws import LAWS, SEPARATE, SUMMED, TOYS
from studies.common.motion import SEQUENCE, cycle, frames
from studies.common.places import POINT_A, POINT_B, POINT_C, SCALES, collision
from studies.common.record import Results, command
from studies.figures.fig08_return_map import DIPS, WINDOW, dip, ends
from studies.figures.fig10_order_two import way
from studies.sensitivities import unit
from woodpecker import (
    ExpansionFriction,
    Search,
    Toy,
    ToyPieces,
    bifurcation_diagram,
    equilibrium,
    jam_limit,
    local_model,
    return_map,
)
from woodpecker.mechanics import free_frequency
from woodpecker.slices import Border, BorderKind, borders_in
from woodpecker.slices.slices import slices_at

CLOSED, DIGITS = "closed form", "30 digits (tests/woodpecker/simulation/test_reference.py)"
SIGNS, EXACT = "bisection to neighbouring doubles", "exact arithmetic"
ROOT = "root of a margin, from two pieces"
HEAVY = "left out of the fast run"
READ = "read off Figure {}"
BESIDE_A = 0.125  # eps_N1 of Figure 11
# Read off Figure 10: eps_N1 and phi_S [rad].
POINTS = {
    "A, where fixed points turn into jumps": ("0.111", "-0.884"),
    "B, where they turn back": ("0.29", "-0.884"),
    "C, where the jumps of P_2 end": ("0.185", "-0.757"),
}
KNOWN = {  # where each law has them
    "A": POINT_A,
    "B": POINT_B,
    "C": dict.fromkeys(LAWS, POINT_C),
}
WAY = Search(slices=24)  # for the way from A to C: nothing on it is thinner than its gaps
SPANS = {SUMMED: (0.04, 0.3), SEPARATE: (0.035, 0.33)}  # of eps_N1: A, B, and what starts there
AROUND = (-1.2, -0.6)  # rad, the window of that way
COORDINATES = ("parameter", "x")  # of a special point
SAME = 1e-9  # in eps_N1 and rad: both laws agree
ISLAND = {"left end": ("0.35", PointKind.BC), "right end": ("0.389", PointKind.FF)}  # I1, its top
TOP = ((0.33, 0.4), (-1.2, -0.7), Search(slices=8))  # where that is looked for


class Row(NamedTuple):
    """One number of the paper and ours."""

    quantity: str
    paper: str  # as printed
    ours: float | None  # None if it was left out
    checked_by: str
    remark: str = ""
    claimed: bool = True  # of the toy; not an example, nor the speed of a computer
    separate: float | None = None  # with Coulomb's law contact by contact; None if that is the same

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
        toy; ``skipped``: how many were left out; ``differing``: the quantities that do not agree;
        ``way``: from A to C along branches of P_2, see
        :class:`studies.figures.fig10_order_two.Course`.
    """
    toy = Toy()
    diagrams = {} if fast else {law: between_a_and_b(law) for law in LAWS}
    rows = [*statics(toy), *motion(), *the_map(toy), *zoom(), *piecewise()]
    rows += [*special_points(diagrams), *island(toy, fast)]
    verdicts = [row.agrees for row in rows]
    courses = way(diagrams[SUMMED], POINT_A[SUMMED], POINT_C) if diagrams else []
    return {
        "rows": [row.as_dict() for row in rows],
        "agree": verdicts.count(True),
        "differ": verdicts.count(False),
        "skipped": sum(row.ours is None for row in rows),
        "differing": [row.quantity for row in rows if row.agrees is False],
        "way": [course._asdict() for course in courses],
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
    beats = "the beats of a motion that has not settled, see below"
    yield Row("period T [s]", "0.1452", orbit.period, DIGITS, beats)
    yield Row("least phi_S of the motion [rad]", "-0.53", orbit.phi_s, DIGITS)
    yield Row("stable (1) or not (0)", "1", float(orbit.stable), DIGITS)
    yield Row("frames of Figure 7 in order", str(len(SEQUENCE)), len(shown), DIGITS)
    struck = [event for event in trajectory.events if event.time == shown[2].time]
    leaves = [event.symbol for event in struck] == ["I3", "D3"]
    yield Row("first upper impact detaches at once (1)", "1", float(leaves), DIGITS)
    lower = sum(event.symbol == "I2" for event in trajectory.events)
    text = "two in its Figures 4 and 5, too; its text mentions one"
    yield Row("impacts of the lower edge", "2", lower, DIGITS, text)


def the_map(toy: Toy) -> Iterator[Row]:
    """Figure 8."""
    for number, (guess, impacts) in enumerate(zip(DIPS, ("1", "0"), strict=True), start=1):
        found = dip(toy, guess)
        yield Row(f"dip {number} of P_1 [rad]", str(guess), found.phi_s, SIGNS)
        upper = re.findall(r"I3\b", found.word)
        quantity = f"upper impacts before the fall, dip {number}"
        yield Row(quantity, impacts, len(upper), SIGNS)
    for x in ("-0.76", "-2.35"):
        jump = jump_near(toy, float(x))
        yield Row(f"jump of P_1 near {x} [rad]", x, jump.x, ROOT)
        swapped = "upper sleeve and beak impact change their order there (1)"
        yield Row(swapped, "1", float(exchanged(jump)), ROOT)
    rims = ends(toy)
    line = "read off Figure 8: the line of a sleeve that jams, for which mu_2 is too small"
    yield Row("right end of P_1 on a straight line [rad]", "0.11", rims.slides_from, ROOT, line)
    yield Row("right end of the band of centres [rad]", "-0.2216", rims.band[1], CLOSED)
    start = time.perf_counter()
    return_map(toy, np.linspace(*WINDOW, 1000))
    hours = (time.perf_counter() - start) / 3600.0
    yield Row("time for 1000 points [h]", "1", hours, "clock", "the paper: about one hour", False)


def jump_near(toy: Toy, guess: float) -> Border:
    """The largest jump within the paper's last digit of where it says one is."""
    near = borders_in(ToyPieces(toy), toy.eps_n1, (guess - 0.005, guess + 0.005), SCALES)
    jumps = [border for border in near if border.kind(SCALES) is BorderKind.JUMP]
    return max(jumps, key=lambda border: abs(border.jump))


def exchanged(jump: Border) -> bool:
    """Whether the beak and the upper edge strike in different orders on the two sides."""
    orders = [
        re.findall(r"I(1\+3|1|3)", re.sub(r"(?<=\d)[sfr-]+", "", side.piece.word))
        for side in (jump.inner, jump.outer)
    ]
    differ = next(pair for pair in zip(*orders, strict=False) if pair[0] != pair[1])
    return {"1", "3"} == set(differ)


def zoom() -> Iterator[Row]:
    """Figure 11: two fixed points, one jump of P_1 and a single jump of P_2 between A and C."""
    seen = {law: beside_a(law) for law in LAWS}
    remark = f"Figure 11, eps_N1 = {BESIDE_A}"
    for quantity, value in seen[SUMMED].items():
        other = seen[SEPARATE][quantity]
        yield Row(f"{quantity} beside A", "1", value, ROOT, remark, separate=other)


def beside_a(law: ExpansionFriction) -> dict[str, int]:
    """What P_1 and P_2 show beside the jump at -0.8848."""
    low, high = -1.15, -0.8
    first, second = slices_at(ToyPieces(TOYS[law]), BESIDE_A, (1, 2), SCALES)
    fixed = [cycle.multiplier for cycle in first.cycles if low <= cycle.x[0] <= high]
    stable = [abs(multiplier) < 1.0 for multiplier in fixed]
    crossings = [[jump for jump in each.jumps if low <= jump.x <= high] for each in (first, second)]
    return {
        "stable fixed points of P_1": stable.count(True),
        "unstable fixed points of P_1": stable.count(False),
        "jump crossings of P_1": len(crossings[0]),
        "jump crossings of P_2": len(crossings[1]),
    }


def piecewise() -> Iterator[Row]:
    """Equations 14 and 15 and Figure 12, at a = 5/4 and r = 1."""
    map_ = PAPERS.at({"r": 1})
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


def between_a_and_b(law: ExpansionFriction) -> Diagram:
    """Orders 1 and 2 from A to B, around the jump that both lie on."""
    return bifurcation_diagram(TOYS[law], "eps_n1", SPANS[law], (1, 2), AROUND, search=WAY)


def special_points(diagrams: dict[ExpansionFriction, Diagram]) -> Iterator[Row]:
    """A, B and C, what starts at B, and where the jump branch of P_2 from A leads."""
    read = READ.format(10) if diagrams else HEAVY
    for name, places in POINTS.items():
        at = {law: collision(diagram, KNOWN[name[0]][law]) for law, diagram in diagrams.items()}
        for quantity, paper, of in zip(("eps_N1", "phi_S [rad]"), places, COORDINATES, strict=True):
            ours, other = (_value(at.get(law), of) for law in LAWS)
            same = ours is None or other is None or abs(ours - other) < SAME
            separate = None if same else other
            yield Row(f"{name}: {quantity}", paper, ours, DIGITS, read, separate=separate)
    slopes = [_slope(diagrams[law], law) if diagrams else None for law in LAWS]
    example = "5/4 is the paper's example, no measurement" if diagrams else HEAVY
    yield Row("slope a of P_1 right of A", "1.25", slopes[0], DIGITS, example, False, slopes[1])
    ends = [stable_from_b(diagrams[law], law) if diagrams else None for law in LAWS]
    remark = "contact by contact it flips there" if diagrams else HEAVY
    quantity = "stable branch from B, its other end: eps_N1"
    yield Row(quantity, "0.05", ends[0], SIGNS, remark, separate=ends[1])
    reached = [float(_reached(diagrams[law], law)) if diagrams else None for law in LAWS]
    cycle = "on its way a real 2-cycle, from 0.17506 to 0.18346, finer than the paper's grid"
    yield Row(
        "P_2 jump branch from A leads to C (1)", "1", reached[0], SIGNS,
        cycle if diagrams else HEAVY, separate=reached[1],
    )  # fmt: skip


def _value(point: SpecialPoint | None, of: str) -> float | None:
    return None if point is None else float(getattr(point, of))


def _slope(diagram: Diagram, law: ExpansionFriction) -> float | None:
    """What the paper calls a: minus the slope of P_1 right of A."""
    point = collision(diagram, POINT_A[law])
    if point is None:
        return None
    return -local_model(ToyPieces(TOYS[law]), point.x, point.parameter).right.slope


def stable_from_b(diagram: Diagram, law: ExpansionFriction) -> float | None:
    """Where the branch of fixed points of P_1 that starts at B loses its stability, or ends."""
    point, seen = collision(diagram, POINT_B[law]), set[str]()
    while point is not None:
        ahead = [
            branch
            for branch in map(diagram.branch, point.branches)
            if (branch.kind, branch.order) == (BranchKind.FIXED_POINT, 1) and branch.id not in seen
        ]
        if not ahead or abs(ahead[0].multiplier[len(ahead[0]) // 2]) > 1.0:
            return float(point.parameter)
        seen.add(ahead[0].id)
        first, last = ahead[0].ends
        point = diagram.point(last if first == point.id else first)
    return None


def _reached(diagram: Diagram, law: ExpansionFriction) -> bool:
    """Whether branches of P_2 lead from A to C, the first of them a jump branch."""
    courses = way(diagram, POINT_A[law], POINT_C)
    return bool(courses) and courses[0].kind == str(BranchKind.JUMP)


def island(toy: Toy, fast: bool) -> Iterator[Row]:
    """The upper end of island I1."""
    span, window, search = TOP
    points: list[SpecialPoint] = []
    if not fast:
        points += bifurcation_diagram(toy, "eps_n1", span, (1,), window, search=search).points
    remark = HEAVY if fast else READ.format(9)
    for name, (p, kind) in ISLAND.items():
        fits = [point for point in points if point.kind is kind and abs(point.x + 0.8848) < 0.01]
        at = min(fits, key=lambda point: abs(point.parameter - float(p)), default=None)
        ours = _value(at, "parameter")
        yield Row(f"island I1 at its top, {name}: eps_N1", p, ours, SIGNS, remark)


if __name__ == "__main__":
    command(main, "paper_numbers")
