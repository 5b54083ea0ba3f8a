"""Where methods fail: one hard scene per row, and the outcome of each method.

    python -m studies.failures.failures [--fast] [--out DIR]

A return of the toy is easy for any method if its events are few, well separated and transversal.
The scenes here are not: two impacts at almost the same instant, an impact that is just missed,
infinitely many impacts, a friction cone that is touched from inside, falls that amplify every
error, other units. The reference is a 30-digit program that shares no code with the methods
(:mod:`studies.failures.scenes`), and every verdict follows from the distance to it
(:mod:`studies.failures.judge`).

The ODE solver is :mod:`studies.peers.ode`: it takes modes and contact problems from the project,
and cannot separate two events closer than 5e-10 s. Moreau's scheme is used as it is usually
written, with Newton's impact law. Where two contacts strike, or friction changes between stick and
slip within one impact, Newton's law and the toy's, Poisson's, are different models: then its error
is not only due to the step. Friction is Coulomb's contact by contact in every scene
(``expansion_friction="separate"``), since time stepping knows no other law. The solver's longest
phase and shortest step, and Moreau's step and longest run, are times in seconds: that is why other
units of length or time disturb them.

The second table is about continuation (:mod:`studies.failures.points`): where a branch ends at a
jump, a textbook algorithm (:mod:`studies.failures.newton`) is compared with the project's. No other
program takes part, so the points are the paper's A, B and C under the toy's own law.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from studies.common.laws import CONTACT_BY_CONTACT
from studies.common.places import WINDOW
from studies.common.record import Results, command
from studies.common.style import keep
from studies.failures.draw import draw_distances, draw_matrix
from studies.failures.judge import Kind, Outcome, Verdict, power, reach, verdict, worst
from studies.failures.methods import Method, methods
from studies.failures.points import rows as rows_at_points
from studies.failures.scenes import Scene, scenes
from woodpecker import ToyPieces
from woodpecker.base.compiled import COMPILED
from woodpecker.base.settings import Settings
from woodpecker.slices.partition import partition

DIPS = ((-1.2255, -1.2242), (-0.2665, -0.2653))  # rad, around the two dips at eps_N1 = 0.5
COARSE = 2.5e-7  # rad; pieces narrower than this are not looked for
Row = dict[str, Any]


class Measured(NamedTuple):
    """Every start of one scene by one method."""

    scene: Scene
    method: Method
    verdicts: tuple[Verdict, ...]
    outcomes: tuple[Outcome, ...]


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Run every scene by every method, judge, count and draw.

    Parameters
    ----------
    fast
        Leave out slow scenes and methods, and most distances.
    out
        Folder for ``failures.png`` and ``failures_distance.png``.

    Returns
    -------
    dict
        ``rows``: for every scene and method the kind and the text of the verdict, the largest error
        [rad] and what the kernel promises there, the error in units of |slope| * 2^-53, whether
        word and side are right, the image [rad] if there is one start, and with several distances
        the smallest ones down to which all, the word or the side are right. ``distances``: every
        single start near an edge. ``summary``: how many scenes of each kind a method has. ``why``:
        what is hard about a scene. ``edges``: where they were found [rad]. ``skipped``: what was
        left out and why.
    """
    chosen, columns = scenes(fast), methods(fast)
    measured = [measure(scene, method) for scene in chosen for method in columns]
    rows = [row_of(each) for each in measured]
    ends: list[Row] = []
    if COMPILED:
        rows.append(unresolved(DIPS[1:] if fast else DIPS))
        ends = rows_at_points()
    points = [point for each in measured for point in points_of(each)]
    if out is not None:
        keep(draw_matrix(rows, ends), out / "failures.png")
        keep(draw_distances(points, columns), out / "failures_distance.png")
    return {
        "rows": rows + ends,
        "summary": summary(rows + ends),
        "distances": points,
        "why": {scene.name: scene.why for scene in chosen},
        "skipped": None if COMPILED else "no numba: pieces and continuation would take minutes",
        "edges": {scene.name: scene.border.x for scene in chosen if scene.border is not None},
    }


def measure(scene: Scene, method: Method) -> Measured:
    """Run all starts of a scene."""
    if method.missing:
        missing = Outcome(None, message=method.missing)
        return Measured(scene, method, (Verdict(Kind.NONE, "not run"),), (missing,))
    outcomes = [method.run(start.toy, start.phi_s) for start in scene.starts]
    verdicts = [verdict(o, s.truth) for o, s in zip(outcomes, scene.starts, strict=True)]
    return Measured(scene, method, tuple(verdicts), tuple(outcomes))


def row_of(measured: Measured) -> Row:
    """One row of the table: the worst of all starts."""
    scene, method, verdicts, outcomes = measured
    bad = worst(verdicts)
    row = {
        "scene": scene.name,
        "label": scene.label,
        "method": method.name,
        "kind": bad.kind.value,
        "verdict": bad.text,
        "error": max((v.error for v in verdicts if v.error is not None), default=None),
        "allowed": max((v.allowed for v in verdicts if v.allowed is not None), default=None),
        "roundings": max((v.roundings for v in verdicts if v.roundings is not None), default=None),
        "word_right": _all(v.word_right for v in verdicts),
        "side_right": _all(v.side_right for v in verdicts),
        "message": outcomes[verdicts.index(bad)].message,
        "image": outcomes[0].image if len(outcomes) == 1 else None,
    }
    if len(scene.starts) > 1 and bad.kind is not Kind.NONE:
        row |= _reaches(scene, verdicts)
        row["verdict"] = _with_distance(row, verdicts, bad)
    return row


def _all(flags: Iterable[bool | None]) -> bool | None:
    """Whether all that are known are true; None if none is known."""
    known = [flag for flag in flags if flag is not None]
    return all(known) if known else None


def _reaches(scene: Scene, verdicts: Sequence[Verdict]) -> Row:
    distances = [start.distance for start in scene.starts]
    far = (Kind.SIDE, Kind.VALUE, Kind.LOST)
    return {
        "reach": reach(distances, [v.kind.right for v in verdicts]),
        "reach_word": reach(distances, [v.word_right is not False for v in verdicts]),
        "reach_side": reach(distances, [v.kind not in far for v in verdicts]),
        "nearest": min(distances),
    }


def _with_distance(row: Row, verdicts: Sequence[Verdict], bad: Verdict) -> str:
    """The verdict of a scene with distances: how far down it is right, and what comes then."""
    if bad.kind.right:
        return f"{bad.text} down to {power(row['nearest'])}"
    if row["reach"] is not None:
        return f"right down to {power(row['reach'])}, then {bad.kind.value}"
    if row["reach_side"] is not None:
        return f"side right down to {power(row['reach_side'])}, word never"
    return f"{bad.kind.value} at every distance"


def points_of(measured: Measured) -> list[Row]:
    """Every start near an edge of the map, for the picture of errors over distance."""
    scene, method, verdicts, _ = measured
    if scene.border is None or method.missing:
        return []
    return [
        {
            "scene": scene.name,
            "method": method.name,
            "distance": start.distance,
            "side": start.side,
            "error": v.error,
            "allowed": v.allowed,
            "word_right": v.word_right,
            "kind": v.kind.value,
            "jump": scene.border.jump,
        }
        for start, v in zip(scene.starts, verdicts, strict=True)
    ]


def unresolved(dips: Sequence[tuple[float, float]] = DIPS) -> Row:
    """What the project itself cannot resolve: next to a dip the pieces of P_1 accumulate."""
    part = COARSE / (WINDOW[1] - WINDOW[0])
    settings = Settings(window=WINDOW, finest=part, coarse=part)
    map_ = ToyPieces(CONTACT_BY_CONTACT)
    found = [partition(map_, 0.5, window, settings) for window in dips]
    length = sum(each.unresolved for each in found)
    return {
        "scene": "pieces at the dips",
        "label": "all pieces next to the dips",
        "method": "kernel",
        "kind": Kind.BOUNDED.value,
        "verdict": f"stated: {power(length)} rad open",
        "error": length,
        "pieces": sum(len(each.cylinders) for each in found),
        "resolution": COARSE,
    }


def summary(rows: Sequence[Row]) -> dict[str, dict[str, int]]:
    """How many scenes of each kind every method has."""
    names = dict.fromkeys(row["method"] for row in rows)
    return {
        name: dict(Counter(row["kind"] for row in rows if row["method"] == name)) for name in names
    }


if __name__ == "__main__":
    command(main, "failures")
