"""Which cycles and jumps are on branches that were followed already."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from pwmap.diagrams.diagram import BranchKind
from woodpecker.base.arrays import Bools, Floats
from woodpecker.base.cubics import on_cubic
from woodpecker.engine.newton import tangent
from woodpecker.engine.orbits import Condition
from woodpecker.maps.pieces import Piece, PiecewiseMap
from woodpecker.search.curves import (
    BranchCurve,
    Keys,
    agree,
    from_point,
    word_at,
    words_between,
)
from woodpecker.search.network import SHARP_FOLD, Network
from woodpecker.slices.orbits import (
    CYCLE,
    Orbit,
    at_parameter,
    is_inside,
    leads,
    orbit_of,
    problem_of,
    to_engine,
)

NONE: Floats = np.empty((0, 7))  # no chords


class Known:
    """Which cycles and jumps the branches of one order explain.

    An orbit lies on a branch if one Newton step takes the branch's orbit at the same parameter,
    between two samples, to it. Branches that take the same pieces are asked first.
    """

    def __init__(self, network: Network, kind: BranchKind, order: int, map_: PiecewiseMap) -> None:
        self.network, self.kind, self.order, self.map = network, kind, order, map_
        self.settings = network.settings
        self._seen = 0
        self._chords: list[Floats] = []
        self._p, self._here = np.nan, NONE  # chords of branches at a parameter
        self._holds_by_chord = dict[tuple[int, int, int], bool]()

    def explains(self, orbit: Orbit, closing: tuple[Condition, ...], keys: Keys) -> bool:
        """Whether a branch passes through an orbit with given closing conditions and pieces."""
        places = sorted(
            self._places(orbit), key=lambda place: float(np.abs(place.x - orbit.x).max())
        )
        others = []
        for place in places:
            if not any(agree(own, keys) for own in place.keys):
                others.append(place)
            elif any(
                leads(x, orbit, self.settings, closing)
                for x in (place.x, *self._curved(place, orbit, closing))
            ):
                return True
        return closing == CYCLE and any(
            leads(place.x, orbit, self.settings) and not self._holds(place) for place in others
        )

    def _curved(
        self, place: _SamplePlace, orbit: Orbit, closing: tuple[Condition, ...]
    ) -> Iterator[Floats]:
        """A place on the cubic through both samples, with the tangents of the orbit's pieces."""
        # Where orbits are steep the chord is too far off for Newton's method.
        number, k, shift = place.chord
        curve, problem = self.network.curves[number], problem_of(self.settings, *closing)
        one, other = (
            to_engine(
                orbit_of(
                    orbit.pieces, _seen_from(curve, j, shift, orbit), float(curve.parameter[j])
                )
            )
            for j in (k, k + 1)
        )
        chord = problem.step_between(one, other)
        length = float(np.linalg.norm(chord))
        if not (length > 0.0 and one.is_defined and other.is_defined):
            return
        d0, d1 = (length * tangent(problem, each, chord / length)[0] for each in (one, other))
        if not (np.isfinite(d0).all() and np.isfinite(d1).all()):
            return

        target = (orbit.p - float(one.p[0])) / self.settings.p_scale

        def past(s: float) -> float:
            """How far beyond the orbit's parameter; at the end without rounding."""
            return float((chord if s == 1.0 else on_cubic(s, chord, d0, d1))[-1]) - target

        if past(0.0) * past(1.0) < 0.0:  # between the samples
            s = float(brentq(past, 0.0, 1.0))
            yield one.x[:, 0] + on_cubic(s, chord, d0, d1)[:-1] * self.settings.x_scale

    def _holds(self, place: _SamplePlace) -> bool:
        """Whether a branch has the pieces of a sample at a place beside it, too."""
        holds = self._holds_by_chord
        if place.chord not in holds:
            curve, k, shift = self.network.curves[place.chord[0]], *place.chord[1:]
            one_word = word_at(curve, k) is word_at(curve, k + 1)
            holds[place.chord] = any(
                self._is_cycle(curve, samples, shift, place.x)
                for samples in ([(k, k + 1)] if one_word else [(k, k - 1), (k + 1, k + 2)])
            )
        return holds[place.chord]

    def _is_cycle(self, curve: BranchCurve, samples: Sequence[int], shift: int, x: Floats) -> bool:
        """Whether a cycle near some points takes the pieces of a branch at one of its samples."""
        # On a border the map may take others: then those at the other sample are as good.
        p, pieces = self._p, self._pieces(curve, samples)
        if not pieces:
            return True
        found = at_parameter(orbit_of(from_point(pieces, shift), x, p), self.settings)
        return found is not None and is_inside(found)

    def _pieces(self, curve: BranchCurve, samples: Sequence[int]) -> tuple[Piece, ...]:
        """The pieces of a branch at the first of two samples; none if the map takes others."""
        word = word_at(curve, samples[0])
        for k in samples:
            if 0 <= k < len(curve.points) and word_at(curve, k) is word:
                p = float(curve.parameter[k])
                pieces = tuple(self.map.at(x, p).piece for x in curve.points[k].tolist())
                if tuple(piece.key for piece in pieces) == word.keys:
                    return pieces
        return ()

    def _places(self, orbit: Orbit) -> list[_SamplePlace]:
        """Where branches are at the parameter of an orbit, if its first point is near."""
        self._update(orbit.p)
        near, found = self._here[self._near(self._here, float(orbit.x[0]))], []
        for number, k, shift in near[:, 4:].astype(int).tolist():
            curve = self.network.curves[number]
            one, other = (_seen_from(curve, j, shift, orbit) for j in (k, k + 1))
            p0, p1 = curve.parameter[k], curve.parameter[k + 1]
            part = min(1.0, max(0.0, (orbit.p - p0) / (p1 - p0))) if p1 != p0 else 0.5
            keys = tuple(from_point(word.keys, shift) for word in words_between(curve, k))
            found.append(_SamplePlace((number, k, shift), one + part * (other - one), keys))
        return found

    def _near(self, chords: Floats, x: float) -> Bools:
        """Between which samples a branch may pass a point, by its largest turn."""
        p0, x0, p1, x1 = chords[:, :4].T
        length = np.hypot((p1 - p0) / self.settings.p_scale, (x1 - x0) / self.settings.x_scale)
        longest = np.maximum(length, SHARP_FOLD)
        bulge = (self.settings.max_turn * longest + self.settings.same) * self.settings.x_scale
        off = np.abs(x1 - x0) + bulge
        near: Bools = (np.minimum(x0, x1) - off <= x) & (x <= np.maximum(x0, x1) + off)
        return near

    def _update(self, p: float) -> None:
        """Take in branches that are new, and choose what lies at a parameter."""
        slack = self.settings.same * self.settings.p_scale
        curves = self.network.curves
        new = [
            _chords_of(curves[number], number)
            for number in range(self._seen, len(curves))
            if (curves[number].kind, curves[number].order) == (self.kind, self.order)
        ]
        self._seen = len(curves)
        self._chords += new
        if p != self._p:
            self._p, self._here, self._holds_by_chord = p, NONE, {}
            new = self._chords
        self._here = np.concatenate([self._here, *(_around(each, p, slack) for each in new)])


class _SamplePlace(NamedTuple):
    """Points (n,) of a branch between two samples, and the pieces that it takes at these."""

    chord: tuple[int, int, int]
    x: Floats
    keys: tuple[Keys, ...]


def _chords_of(curve: BranchCurve, number: int) -> Floats:
    """Neighbouring samples of a branch, (m, 7), as each of the points of a cycle sees them."""
    # p and x at both, and the numbers of the branch, the first sample and the point.
    p, n = curve.parameter, len(curve.parameter) - 1
    seen = [
        np.column_stack(
            [p[:-1], x[:-1], p[1:], x[1:], np.full(n, number), np.arange(n), np.full(n, shift)]
        )
        for shift, x in enumerate(curve.x.T)
    ]
    return np.concatenate(seen)


def _around(chords: Floats, p: float, slack: float) -> Floats:
    """The chords that span a parameter."""
    p0, p1 = chords[:, 0], chords[:, 2]
    found: Floats = chords[(np.minimum(p0, p1) - slack <= p) & (p <= np.maximum(p0, p1) + slack)]
    return found


def _seen_from(curve: BranchCurve, sample: int, shift: int, orbit: Orbit) -> Floats:
    """The points of a branch at a sample from one of them on, as many as those of an orbit."""
    # Where a jump is met earlier, or later, from a sample on, the orbit of that sample is longer,
    # or shorter: then it goes on with the pieces of the other one.
    points = np.roll(curve.points[sample], -shift)[: len(orbit)].tolist()
    for piece in orbit.pieces[len(points) - 1 : -1]:
        points.append(piece.at(points[-1], float(curve.parameter[sample])).value)
    return np.array(points)
