"""Continuation at A, B and C, where a branch of periodic motions ends at a jump.

The points are those under the toy's own law, friction bounded by the sum. The textbook algorithms
of :mod:`studies.failures.newton` and the project's run on the same map. A path *hops* if two of its
accepted points lie on different sides of the jump: no branch of the map connects them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from pwmap import BranchKind, PointKind
from studies.common.places import WINDOW
from studies.failures import newton as textbook
from studies.failures.judge import Kind, power
from woodpecker import Toy, ToyPieces, continuation, shoot
from woodpecker.base.settings import Settings
from woodpecker.slices.slices import slices_at

AROUND = (-5e-2, -1e-2, -1e-3, 1e-3, 1e-2, 5e-2)  # rad, of guesses around a point
BESIDE = 1e-4  # distance of the parameter at which Newton's method is tried
ARRIVED = 1e-7  # a path that comes this close in (x, p) has met the point
TENTH_DIGIT = 1e-10  # one unit in the last digit to which the points are known
SAME_POINT = 1e-8  # rad; two results of Newton's method closer than this are one


class Collision(NamedTuple):
    """A point at which a branch meets a jump, to ten digits by the 30-digit program.

    ``start`` is a point on the branch (eps_N1, phi_S) from where it is followed, ``span`` the
    parameters in which the project looks at what is connected with it.
    """

    name: str
    kind: PointKind
    p: float
    x: float
    start: tuple[float, float]
    span: tuple[float, float]

    @property
    def inward(self) -> int:
        """On which side in p the branch lies."""
        return 1 if self.start[0] > self.p else -1


COLLISIONS = (
    Collision("A", PointKind.FF, 0.1119709145, -0.8847733440, (0.1319709145, -0.84072),
              (0.100, 0.135)),
    Collision("B", PointKind.BC, 0.2915217119, -0.8847733440, (0.2715217119, -0.91684),
              (0.270, 0.295)),
    Collision("C", PointKind.BC, 0.1851269510, -0.7577872573, (0.2051269510, -0.70226),
              (0.175, 0.210)),
)  # fmt: skip

Row = dict[str, Any]


def rows() -> list[Row]:
    """Following the branch to its end, listing all solutions there, and shooting beside it."""
    measures = (
        (followed_by_project, followed_by_textbook),
        (listed,),
        (shot_by_project, shot_by_textbook),
    )
    return [one(point) for some in measures for point in COLLISIONS for one in some]


def followed_by_project(point: Collision) -> Row:
    """`continuation` from the start: whether the point is found, classified and passed."""
    toy = Toy(eps_n1=point.start[0])
    diagram = continuation(toy, shoot(toy, point.start[1]), span=point.span)
    near = min(diagram.points, key=lambda q: abs(q.parameter - point.p) + abs(q.x - point.x))
    error = float(max(abs(near.parameter - point.p), abs(near.x - point.x)))
    kinds = sorted(str(diagram.branch(branch).kind) for branch in near.branches)
    passed = str(BranchKind.JUMP) in kinds
    right = error <= TENTH_DIGIT and near.kind == point.kind and passed
    return {
        **_named("path", point, "project"),
        "kind": (Kind.EXACT if right else Kind.VALUE).value,
        "verdict": f"{near.kind} {near.note}, goes on as {'jump' if passed else 'nothing'}",
        "error": error,
        "point": str(near.kind),
        "branches": kinds,
    }


def followed_by_textbook(point: Collision) -> Row:
    """Pseudo-arclength continuation from the start, and where it ends up."""
    f = textbook.plain(ToyPieces(Toy()))
    first = textbook.newton(f, point.start[1], point.start[0])
    path = textbook.follow(f, first.x, first.p, -point.inward, (0.0, 1.0), WINDOW)
    side = np.sign(path.x - point.x)
    hops = np.flatnonzero(np.diff(side) != 0)
    distance = float(np.hypot(path.x - point.x, path.p - point.p).min())
    row = {
        **_named("path", point, "textbook"),
        "error": distance,
        "steps": len(path.x) - 1,
        "newton_steps": path.corrections,
        "end": path.end,
        "end_at": [float(path.p[-1]), float(path.x[-1])],
    }
    if hops.size:
        k = int(hops[0])
        row["hop"] = [float(abs(path.p[k + 1] - path.p[k])), float(abs(path.x[k + 1] - path.x[k]))]
        text = rf"hops by {row['hop'][0]:.2g} in $\varepsilon_{{N1}}$"
        return {**row, "kind": Kind.SIDE.value, "verdict": text}
    if distance > ARRIVED:
        return {**row, "kind": Kind.VALUE.value, "verdict": f"ends {distance:.1g} away"}
    text = f"stalls {power(distance)} before it"
    return {**row, "kind": Kind.LOST.value, "verdict": text}


def listed(point: Collision) -> Row:
    """All fixed points and crossings at one parameter, on both sides of the point.

    The branch must be there on its own side, and on the other nothing else may be missing: next to
    C lies the branch that comes from A. A textbook has nothing like it.
    """
    settings = Settings(window=(point.x - 2.0 * AROUND[-1], point.x + 2.0 * AROUND[-1]))
    map_, target = ToyPieces(Toy()), _target(point)
    (inside,), (outside,) = (
        slices_at(map_, point.p + side * point.inward * BESIDE, (1,), settings) for side in (1, -1)
    )
    there = any(abs(cycle.x[0] - target) < SAME_POINT for cycle in inside.cycles)
    gone = len(inside.cycles) - len(outside.cycles) == 1
    right = there and gone
    return {
        **_named("list", point, "project"),
        "kind": (Kind.EXACT if right else Kind.VALUE).value,
        "verdict": "slice: there inside, gone outside" if right else "slice misses it",
        "error": abs(map_.at(target, inside.p).value - target),
        "crossings": [len(inside.jumps), len(outside.jumps)],
    }


def shot_by_project(point: Collision) -> Row:
    """`shoot` from guesses beside the point, a little inside the end of the branch."""
    toy, target = Toy(eps_n1=point.p + point.inward * BESIDE), _target(point)
    orbits = [shoot(toy, point.x + guess) for guess in AROUND]
    return _shooting(point, "project", [_name(o.success, o.phi_s, target) for o in orbits])


def shot_by_textbook(point: Collision) -> Row:
    """Newton's method from the same guesses."""
    f, p, target = textbook.plain(ToyPieces(Toy())), point.p + point.inward * BESIDE, _target(point)
    shots = [textbook.newton(f, point.x + guess, p) for guess in AROUND]
    return _shooting(point, "textbook", [_name(s.converged, s.x, target) for s in shots])


def _shooting(point: Collision, method: str, names: Sequence[str]) -> Row:
    found, tally = names.count("it"), dict(Counter(names))
    kind = Kind.EXACT if found == len(names) else Kind.PART if found else Kind.LOST
    return {
        **_named("shooting", point, method),
        "kind": kind.value,
        "verdict": f"{found} of {len(names)} guesses lead to it",
        "error": None,
        "shots": tally,
    }


def _named(what: str, point: Collision, method: str) -> Row:
    labels = {"path": "follow a branch to", "list": "all solutions at", "shooting": "shoot beside"}
    label = labels[what]
    return {"scene": f"{what} {point.name}", "label": f"{label} {point.name}", "method": method}


def _target(point: Collision) -> float:
    """The fixed point of the branch, a little inside its end."""
    settings = Settings(window=(point.x - 2e-3, point.x + 2e-3))
    (found,) = slices_at(ToyPieces(Toy()), point.p + point.inward * BESIDE, (1,), settings)
    return min((float(cycle.x[0]) for cycle in found.cycles), key=lambda x: abs(x - point.x))


def _name(converged: bool, x: float, target: float) -> str:
    if not converged:
        return "nothing"
    return "it" if abs(x - target) < SAME_POINT else "another"
