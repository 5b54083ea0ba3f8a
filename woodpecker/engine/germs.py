"""What starts where a cycle meets a border, from the germ of the map there.

At such a point the map has two pieces, inner and outer, and near it nothing else. A curve that
starts there consists of orbits that lie, at its start, on the cycle, run through once or several
times, each time with one of the two pieces at the border. So the words of these curves are
finitely many, and each is tried: its tangent says on which sides of the border the points go, and
that must be the sides of their pieces. No orbit is looked for at a distance.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.engine.following import Curve, Following, Sample
from woodpecker.engine.maps import Chain, Image, Piece, PiecewiseMap, chain
from woodpecker.engine.newton import Problem, cycles
from woodpecker.engine.orbits import OnBorder, Orbit, orbit_of

TIE = 2.0**-36  # a margin is zero if it is smaller than this part of its terms
SAME = 1e-9  # scaled: two values of a map are one
SLOW = 1e-9  # a margin that grows slower than this along a tangent, scaled, has no side there


@dataclass(frozen=True, slots=True, eq=False)
class Meeting:
    """A cycle, of which the last point lies on a border.

    Attributes
    ----------
    cycle
        With the pieces on the side that it comes from.
    code
        The margin of its last piece that vanishes.
    outer
        The image of the last point under the piece on the other side.
    jumps
        Whether the two images differ.
    """

    cycle: Orbit
    code: int
    outer: Image
    jumps: bool


@dataclass(frozen=True, slots=True, eq=False)
class Beginning:
    """A curve that starts at a point, and its first sample.

    Attributes
    ----------
    order
        The iterate that it belongs to: its cycles are mapped to themselves by P_order.
    curve
        The curve.
    sample
        The point, with the tangent along which it starts.
    """

    order: int
    curve: Curve
    sample: Sample

    @property
    def is_crossing(self) -> bool:
        """Whether it is one of jump crossings."""
        return self.sample.orbit.outer is not None

    @property
    def ahead(self) -> float:
        """How fast the parameter grows."""
        orbit, problem = self.sample.orbit, self.curve.problem
        return float(self.sample.tangent[np.searchsorted(problem.columns(orbit), orbit.x.size)])


def meeting_of(map_: PiecewiseMap, cycle: Orbit, image: int, code: int, curve: Curve) -> Meeting:
    """A cycle that meets a border with one of its images."""
    cycle = cycle.rotated((image + 1) % len(cycle.x))
    last, x, p = cycle.images[-1], cycle.x[-1], cycle.p
    outer = map_.beside(x, p, -last.gradients[last.place(code)])
    away = np.abs(outer.value - last.value) / curve.problem.x_scale
    return Meeting(cycle, code, outer, bool(not away.max() <= SAME))


def beginnings(
    map_: PiecewiseMap, met: Meeting, orders: Sequence[int], settings: Following, base: Problem
) -> Iterator[Beginning]:
    """All curves of some orders that start where a cycle meets a border.

    Parameters
    ----------
    map_
        The map.
    met
        The cycle; the curve that has led to it is among those that start there.
    orders
        Of cycles and of jump crossings.
    settings, base
        How curves are followed; scales and free parameters.
    """
    m = len(met.cycle.x)
    plain = cycles(base.free, base.x_scale, base.p_scale)
    for order in orders:
        if order % m:
            continue
        turns = order // m
        for word in _words(turns, "A" if met.jumps else "AB"):
            pieces = [piece for letter in word for piece in _turn(met, letter)]
            orbit = orbit_of(pieces, np.tile(met.cycle.x, (turns, 1)), met.cycle.p)
            yield from _both_ways(order, Curve(plain, settings), orbit)
        if not met.jumps or met.outer.reason:
            continue
        for head in range(1, order + 1):
            found = _crossing(map_, met, order, head)
            if found is not None:
                orbit, at_border = found
                ignored = frozenset(at_border)
                problem = plain.with_(OnBorder(*at_border[0]))
                yield from _both_ways(order, Curve(problem, settings, ignored), orbit)


def _words(turns: int, letters: str) -> Iterator[str]:
    """Words of some turns, one of those that are rotations of each other, none of them a power."""
    for each in product(letters, repeat=turns):
        word = "".join(each)
        if all(word < word[i:] + word[:i] for i in range(1, turns)):
            yield word


def _turn(met: Meeting, letter: str) -> list[Piece]:
    """The pieces of one turn round the cycle, with the inner or the outer one at the border."""
    pieces = [image.piece for image in met.cycle.images]
    return pieces if letter == "A" else [*pieces[:-1], met.outer.piece]


def _crossing(
    map_: PiecewiseMap, met: Meeting, order: int, head: int
) -> tuple[Orbit, list[tuple[int, int]]] | None:
    """A crossing of P_order whose orbits have some points up to the border.

    From there both sides are mapped on: the inner one along the cycle, the outer one wherever it
    goes.

    Returns
    -------
    At the point where it starts; and the margins, by image and code, that vanish all along it.
    None if the outer side has no image.
    """
    m, p, tail = len(met.cycle.x), met.cycle.p, order - head
    round_ = [image.piece for image in met.cycle.images]
    outer, x = [met.outer.piece], met.outer.value
    for _ in range(tail):
        image = map_.at(x, p)
        if image.reason:
            return None
        outer.append(image.piece)
        x = image.value
    at = np.arange(m - head, m) % m  # which points of the cycle: the last one is that at the border
    inner = [round_[-1], *(round_[i % m] for i in range(tail))]
    pieces = [*(round_[i] for i in at[:-1]), chain(inner)]
    orbit = orbit_of(pieces, met.cycle.x[at], p, 0.0, chain(outer))
    at_border = [(head - 1, (tail + 1) * met.code)]
    codes = met.outer.codes[_tied(met.outer, met.cycle.x[-1], p)]
    at_border += [(head, (tail + 1) * code) for code in codes.tolist()]
    return orbit, at_border


def _both_ways(order: int, curve: Curve, orbit: Orbit) -> Iterator[Beginning]:
    """The curve through an orbit, on both sides of it, where its points have their pieces."""
    if not orbit.is_defined:
        return
    sample = curve.start(orbit)
    if not np.isfinite(sample.tangent).all():
        return
    for sign in (1.0, -1.0):
        turned = Sample(orbit, sign * sample.tangent)
        if is_inside(curve, turned):
            yield Beginning(order, curve, turned)


def is_inside(curve: Curve, sample: Sample) -> bool:
    """Whether a curve leads from a sample to where its points have the pieces that they have.

    Margins that vanish at the sample must grow; those that do not must be positive.
    """
    orbit = sample.orbit
    for i, image in enumerate(orbit.taken):
        zero = _tied(image, _point(orbit, i), orbit.p)
        for k, code in enumerate(image.codes.tolist()):
            if (i, code) in curve.ignored:
                continue
            if zero[k]:
                if not curve.rate(sample, i, code) > SLOW:
                    return False
            elif not image.margins[k] > 0.0:
                return False
    if orbit.outer is None:
        return True
    low, high = orbit.share <= SAME, orbit.share >= 1.0 - SAME
    return bool((not low or sample.tangent[-1] > 0.0) and (not high or sample.tangent[-1] < 0.0))


def _point(orbit: Orbit, i: int) -> Floats:
    found: Floats = orbit.x[orbit.place(i)]
    return found


def _tied(image: Image, x: Floats, p: Floats) -> np.ndarray:
    """Which margins of an image are zero, but for rounding."""
    size = np.abs(image.gradients) @ np.maximum(np.abs(np.concatenate([x, p])), 1.0)
    return np.asarray(np.abs(image.margins) <= TIE * size)


def cycle_at_limit(crossing: Orbit) -> tuple[Orbit, int]:
    """The cycle that a jump crossing is at s = 0 or 1, and its image at the border.

    It is run through once, also where the crossing belongs to an iterate.
    """
    if crossing.outer is None:
        raise ValueError("expected a jump crossing, got a cycle")
    last = crossing.outer if crossing.share > 0.5 else crossing.images[-1]
    tail = last.piece.pieces if isinstance(last.piece, Chain) else (last.piece,)
    x, pieces = list(crossing.x), [image.piece for image in crossing.images[:-1]]
    at = x[-1]
    for k, piece in enumerate(tail):
        pieces.append(piece)
        if k < len(tail) - 1:
            at = piece.at(at, crossing.p).value
            x.append(at)
    n, border = len(x), len(crossing.x) - 1
    points = np.array(x)
    period = next(
        d for d in range(1, n + 1)
        if n % d == 0 and np.abs(np.roll(points, -d, axis=0) - points).max() <= SAME
    )  # fmt: skip
    cycle = orbit_of(pieces[:period], points[:period], crossing.p)
    return cycle, border % period
