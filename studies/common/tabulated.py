"""Cycles and jump crossings of P_j by plain tabulation, compared with those of a diagram.

P_j is computed at equally spaced points. Where P_j(x) - x changes its sign between neighbours,
bisection continues to neighbouring doubles: there is a cycle of P_j if both have the same word or
equal values, otherwise a jump that crosses the diagonal. Slices, continuation and derivatives are
not used.

A table misses two changes of sign between neighbours: two cycles, or a cycle and a jump, that are
closer than its spacing. Such hits of a diagram are confirmed one by one, by the signs right beside
them, and counted. Bisection fails at a change of sign where orbits are lost.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pwmap import Branch, BranchKind, Diagram
from pwmap.diagrams import Hit
from studies.common.record import Results
from woodpecker import PeriodicOrbit, Toy, return_map, solutions
from woodpecker.base.arrays import Floats

HALVINGS = 64  # of a spacing, at most: doubles have 53 bits
JUMP = 1e-6  # rad: values at neighbouring doubles that differ by more are those of a jump; the
# steepest continuous border is a square root, which rounding makes some 1e-8 high
SAME = 1e-9  # rad: a cycle that was solved for and one that was bisected
CHORD = 1e-3  # rad: of a straight line between samples and its branch, see `studies.common.whole`
SIDES = tuple(10.0**-n for n in range(14, 8, -1))  # rad: where signs beside a cycle are looked at
CLOSER = 4001  # points about a hit that the table does not show


class Change(NamedTuple):
    """A change of sign of P_j(x) - x, between neighbouring doubles."""

    x: float  # the lower one [rad]
    word: str  # there
    jumps: bool  # whether P_j does: then it is no cycle


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """What a tabulation shows.

    Attributes
    ----------
    changes
        In order of x.
    lost
        How many changes of sign have an orbit that is lost between them.
    """

    changes: tuple[Change, ...]
    lost: int

    def places(self, *, jumps: bool) -> Floats:
        """Where its cycles, or its jumps, are."""
        return np.array([each.x for each in self.changes if each.jumps is jumps])


class Images(NamedTuple):
    """P_j at some points: values [rad], nan where there is none, and words."""

    value: Floats
    words: Sequence[str]


def images(
    toy: Toy, x: Floats, order: int, window: tuple[float, float] = (-math.inf, math.inf)
) -> Images:
    """P_order at some points, as far as all returns but the last lie in a window."""
    value, words = x, [""] * len(x)
    for k in range(order):
        (inside,) = np.nonzero((window[0] <= value) & (value <= window[1]))
        inside = inside[value[inside] < toy.phi_s_max]
        found = return_map(toy, value[inside])
        value = np.full(len(x), math.nan)
        value[inside] = found.phi_s
        for i, word in zip(inside.tolist(), found.words, strict=True):
            words[i] = f"{words[i]} | {word}" if k else word
    return Images(value, words)


def tabulated(toy: Toy, x: Floats, order: int, window: tuple[float, float]) -> Table:
    """Changes of sign of P_order(x) - x between points in ascending order, each closed in on.

    Points at which the toy swings on a sleeve that stays jammed, without an event, are left out:
    there the return map is the identity.
    """
    table = images(toy, x, order, window)
    moves = np.array([bool(word) for word in table.words]) & np.isfinite(table.value)
    below = table.value < x
    (k,) = np.nonzero(moves[1:] & moves[:-1] & (below[1:] != below[:-1]))
    low, high = x[k], x[k + 1]
    ends = [
        [(float(table.value[i]), table.words[i]) for i in (k + side).tolist()] for side in (0, 1)
    ]
    falls, is_lost = below[k + 1], np.zeros(len(k), dtype=bool)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        (open_,) = np.nonzero((low < middle) & (middle < high) & ~is_lost)
        if not len(open_):
            break
        there = images(toy, middle[open_], order, window)
        for i, value, word in zip(open_.tolist(), there.value.tolist(), there.words, strict=True):
            is_lost[i] = math.isnan(value)
            upper = (value < middle[i]) == falls[i]
            (high if upper else low)[i] = middle[i]
            ends[1 if upper else 0][i] = value, word
    found = []
    for i in np.flatnonzero(~is_lost).tolist():
        (one, word), (other, beyond) = ends[0][i], ends[1][i]
        found.append(Change(float(low[i]), word, word != beyond and abs(other - one) > JUMP))
    return Table(tuple(found), int(is_lost.sum()))


def compared(
    toy: Toy, diagram: Diagram, p: float, order: int, window: tuple[float, float], count: int
) -> Results:
    """A table of P_order at one parameter, and whether the diagram has what it shows.

    Parameters
    ----------
    toy, diagram
        The toy, and its diagram in the window, of P_order and of all iterates that divide it.
    p
        Where, away from special points.
    order, window, count
        The iterate, the interval that is tabulated [rad], and how many points it gets.

    Returns
    -------
    dict
        ``parameter``, ``order``; ``cycles``, ``jumps``: how many a table shows; ``lost``: see
        :class:`Table`; ``drawn_cycles``, ``drawn_jumps``: of the diagram; ``missing``: kind, x and
        word of what the diagram has not; ``closer``: how many hits are confirmed by the map, but
        too close to others for the table; ``double``: kind and x of what is drawn twice;
        ``unconfirmed``: kind and x of hits with no change of sign.
    """
    there = toy.replace(**{diagram.parameter_name: p})
    table = tabulated(there, np.linspace(*window, count), order, window)
    cycles = _compared_cycles(there, diagram, p, order, table)
    jumps = _compared_jumps(there, diagram, p, order, table)
    both = {name: cycles[name] + jumps[name] for name in ("missing", "double", "unconfirmed")}
    return {
        "parameter": p,
        "order": order,
        "cycles": len(table.places(jumps=False)),
        "jumps": len(table.places(jumps=True)),
        "lost": table.lost,
        "drawn_cycles": cycles["drawn"],
        "drawn_jumps": jumps["drawn"],
        "closer": cycles["closer"] + jumps["closer"],
        **both,
    }


def _compared_cycles(toy: Toy, diagram: Diagram, p: float, order: int, table: Table) -> Results:
    """Each hit is solved for: it is the cycle of the table, to rounding.

    Where it is not, the solution of a neighbour was found, or none: then the straight line between
    samples has to do.
    """
    cycles = [hit for hit in diagram.at(p) if hit.branch.kind is BranchKind.FIXED_POINT]
    both = zip(solutions(toy, diagram, p), cycles, strict=True)
    found = [_Drawn(hit.x, each.orbit) for each, hit in both if order % hit.branch.order == 0]
    solved = sorted((each for each in found if each.orbit.success), key=_solution)
    places = table.places(jumps=False)
    missed, over = unpaired(places, np.array([_solution(each) for each in solved]), SAME)
    surplus, closer = [each for each in found if not each.orbit.success], 0
    for each in (solved[k] for k in over):
        others = [one for one in solved if one is not each and _are_one(one.orbit, each.orbit)]
        if not others and _changes_beside(toy, _solution(each), order):
            closer += 1
        else:
            surplus.append(each._replace(twice=bool(others)))
    free, left = places[missed], []
    for each in surplus:
        away = np.abs(free - each.x)
        if away.min(initial=math.inf) < each.within:
            free = np.delete(free, away.argmin())
        else:
            left.append(each)
    return {
        "drawn": len(found),
        "missing": _described(table, free),
        "closer": closer,
        "double": [["cycle", each.x] for each in left if each.twice],
        "unconfirmed": [["cycle", each.x] for each in left if not each.twice],
    }


class _Drawn(NamedTuple):
    """A hit of a branch of cycles [rad], its solution, and whether another hit has the same."""

    x: float
    orbit: PeriodicOrbit
    twice: bool = False

    @property
    def within(self) -> float:
        """How near another cycle must be to be this one: nearer than the solution, if any."""
        return min(CHORD, abs(self.x - self.orbit.phi_s)) if self.orbit.success else CHORD


def _solution(each: _Drawn) -> float:
    return each.orbit.phi_s


def _are_one(a: PeriodicOrbit, b: PeriodicOrbit) -> bool:
    """Whether two cycles have the same points: at one of them steep cycles may be as close."""
    if a.order != b.order:
        return False
    return bool(np.abs(np.subtract(a.points, b.points)).max() <= SAME)


def _compared_jumps(toy: Toy, diagram: Diagram, p: float, order: int, table: Table) -> Results:
    """Hits lie on straight lines between samples: each has a jump of its own near it.

    One of a pair that is too close for a table has it right beside a sample of its branch.
    """
    hits = [hit for hit in diagram.at(p) if _is_jump(hit, order)]
    drawn = np.array([hit.x for hit in hits])
    places = table.places(jumps=True)
    missed, over = unpaired(places, drawn, CHORD)
    closer, double, wrong = 0, [], []
    for hit in (hits[k] for k in over):
        about = np.linspace(hit.x - CHORD, hit.x + CHORD, CLOSER)
        near = tabulated(toy, about, order, (-math.inf, math.inf)).places(jumps=True)
        away = np.abs(drawn - hit.x)
        alone = int((away <= SAME).sum()) == 1
        confirmed = len(near) >= (away <= CHORD).sum() or (
            alone and _jumps_beside_sample(toy, diagram.parameter_name, hit.branch, p, order)
        )
        if confirmed:
            closer += 1
        elif len(near) or not alone:
            double.append(["jump", hit.x])
        else:
            wrong.append(["jump", hit.x])
    return {
        "drawn": len(drawn),
        "missing": _described(table, places[missed]),
        "closer": closer,
        "double": double,
        "unconfirmed": wrong,
    }


def _jumps_beside_sample(toy: Toy, name: str, branch: Branch, p: float, order: int) -> bool:
    """Whether P_order jumps past x right beside the sample of a branch nearest to a parameter."""
    k, sides = int(np.abs(branch.parameter - p).argmin()), np.array(SIDES)
    there, x = toy.replace(**{name: float(branch.parameter[k])}), float(branch.x[k])
    low, high = (images(there, x + sign * sides, order) for sign in (-1.0, 1.0))
    signs = (low.value < x - sides) != (high.value < x + sides)
    return bool((signs & (np.abs(high.value - low.value) > JUMP)).any())


def _is_jump(hit: Hit, order: int) -> bool:
    return (hit.branch.kind, hit.branch.order) == (BranchKind.JUMP, order)


def _described(table: Table, places: Floats) -> list[list[object]]:
    """Kind, x and word of what lies at some places."""
    wanted = set(places.tolist())
    return [
        ["jump" if each.jumps else "cycle", each.x, each.word]
        for each in table.changes
        if each.x in wanted
    ]


def _changes_beside(toy: Toy, x: float, order: int) -> bool:
    """Whether P_order(x) - x has different signs right beside a point, on pieces of one word."""
    sides = np.array(SIDES)
    low, high = (images(toy, x + sign * sides, order) for sign in (-1.0, 1.0))
    signs = (low.value < x - sides) != (high.value < x + sides)
    one = [a == b for a, b in zip(low.words, high.words, strict=True)]
    flat = np.abs(high.value - low.value) <= JUMP
    return bool((signs & (np.array(one) | flat)).any())


def unpaired(points: Floats, others: Floats, within: float) -> tuple[list[int], list[int]]:
    """Which are left of both if as many as can be are paired; both ascend.

    Each is paired with the first of the others that is near and free: on a line no other way pairs
    more.
    """
    k, left, free = 0, [], set(range(len(others)))
    for i, x in enumerate(points.tolist()):
        while k < len(others) and others[k] < x - within:
            k += 1
        if k < len(others) and others[k] <= x + within:
            free.remove(k)
            k += 1
        else:
            left.append(i)
    return left, sorted(free)
