"""Which cycles and jumps are on branches that were followed already."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from pwmap.diagrams.diagram import BranchKind
from woodpecker.base.arrays import Bools, Floats
from woodpecker.base.cubics import on_cubic
from woodpecker.engine.curves import SolutionCurve
from woodpecker.engine.maps import SpacePiece
from woodpecker.engine.newton import Problem, leads, solve, tangent
from woodpecker.engine.orbits import Held, SpaceOrbit, orbit_of, placed_at
from woodpecker.search.curves import (
    BranchCurve,
    Keys,
    agree,
    from_point,
    word_at,
    words_between,
)
from woodpecker.search.network import SHARP_FOLD, Network

NONE: Floats = np.empty((0, 7))  # no chords


class Known:
    """Which cycles and jumps the branches of one order explain.

    An orbit lies on a branch if one Newton step takes the branch's orbit at the same parameter,
    between two samples, to it. Branches that take the same pieces are asked first.
    """

    def __init__(self, network: Network, kind: BranchKind, order: int, base: SolutionCurve) -> None:
        self.network, self.kind, self.order, self.base = network, kind, order, base
        self.same, self.max_turn = network.settings.same, base.settings.max_turn
        self._seen = 0
        self._chords: list[Floats] = []
        self._p, self._here = np.nan, NONE  # chords of branches at a parameter
        self._holds_by_chord = dict[tuple[int, int, int], bool]()

    def explains(self, orbit: SpaceOrbit, problem: Problem, keys: Keys) -> bool:
        """Whether a branch passes through an orbit of some equations and pieces."""
        places = sorted(self._places(orbit), key=lambda place: problem.apart(place.x, orbit.x))
        others = []
        for place in places:
            if not any(agree(own, keys) for own in place.keys):
                others.append(place)
            elif any(
                leads(problem, x, orbit, self.same)
                for x in (place.x, *self._curved(place, orbit, problem))
            ):
                return True
        return self.kind is BranchKind.FIXED_POINT and any(
            leads(problem, place.x, orbit, self.same) and not self._holds(place, orbit)
            for place in others
        )

    def _curved(self, place: _SamplePlace, orbit: SpaceOrbit, problem: Problem) -> Iterator[Floats]:
        """A place on the cubic through both samples, with the tangents of the orbit's pieces."""
        # Where orbits are steep the chord is too far off for Newton's method.
        number, k, shift = place.chord
        curve, column = self.network.curves[number], problem.free[0]
        one, other = (
            placed_at(orbit, self._points(curve, j, shift, orbit), self._at(curve, j, orbit.p))
            for j in (k, k + 1)
        )
        chord = problem.step_between(one, other)
        length = float(np.linalg.norm(chord))
        if not (length > 0.0 and one.is_defined and other.is_defined):
            return
        d0, d1 = (length * tangent(problem, each, chord / length)[0] for each in (one, other))
        if not (np.isfinite(d0).all() and np.isfinite(d1).all()):
            return

        size = orbit.x.size
        target = float(orbit.p[column] - one.p[column]) / self.network.p_scale

        def past(s: float) -> float:
            """How far beyond the orbit's parameter; at the end without rounding."""
            return float((chord if s == 1.0 else on_cubic(s, chord, d0, d1))[size]) - target

        if past(0.0) * past(1.0) < 0.0:  # between the samples
            s = float(brentq(past, 0.0, 1.0))
            way = on_cubic(s, chord, d0, d1)[:size].reshape(orbit.x.shape)
            yield one.x + way * self.network.x_scale

    def _holds(self, place: _SamplePlace, orbit: SpaceOrbit) -> bool:
        """Whether a branch has the pieces of a sample at a place beside it, too."""
        holds = self._holds_by_chord
        if place.chord not in holds:
            curve, k, shift = self.network.curves[place.chord[0]], *place.chord[1:]
            one_word = word_at(curve, k) is word_at(curve, k + 1)
            holds[place.chord] = any(
                self._is_cycle(curve, samples, shift, place.x, orbit.p)
                for samples in ([(k, k + 1)] if one_word else [(k, k - 1), (k + 1, k + 2)])
            )
        return holds[place.chord]

    def _is_cycle(
        self, curve: BranchCurve, samples: Sequence[int], shift: int, x: Floats, p: Floats
    ) -> bool:
        """Whether a cycle near some points takes the pieces of a branch at one of its samples."""
        # On a border the map may take others: then those at the other sample are as good.
        pieces = self._pieces(curve, samples, p)
        if not pieces:
            return True
        problem = self.base.problem
        held = [Held(x.size + k, float(p[k])) for k in problem.free]
        found = solve(problem.with_(*held), orbit_of(from_point(pieces, shift), x, p))
        beyond = any((image.margins < 0.0).any() for image in found.orbit.images)
        return found.converged and not beyond

    def _pieces(
        self, curve: BranchCurve, samples: Sequence[int], p: Floats
    ) -> tuple[SpacePiece, ...]:
        """The pieces of a branch at the first of two samples; none if the map takes others."""
        word = word_at(curve, samples[0])
        for k in samples:
            if 0 <= k < len(curve.points) and word_at(curve, k) is word:
                there = self._at(curve, k, p)
                pieces = tuple(self.base.map.at(x, there).piece for x in curve.points[k])
                if tuple(piece.key for piece in pieces) == word.keys:
                    return pieces
        return ()

    def _places(self, orbit: SpaceOrbit) -> list[_SamplePlace]:
        """Where branches are at the parameter of an orbit, if its first point is near."""
        p = float(orbit.p[self.base.problem.free[0]])
        self._update(p)
        near, found = self._here[self._near(self._here, float(orbit.x[0, 0]))], []
        for number, k, shift in near[:, 4:].astype(int).tolist():
            curve = self.network.curves[number]
            one, other = (self._points(curve, j, shift, orbit) for j in (k, k + 1))
            p0, p1 = curve.parameter[k], curve.parameter[k + 1]
            part = min(1.0, max(0.0, (p - p0) / (p1 - p0))) if p1 != p0 else 0.5
            keys = tuple(from_point(word.keys, shift) for word in words_between(curve, k))
            found.append(_SamplePlace((number, k, shift), one + part * (other - one), keys))
        return found

    def _points(self, curve: BranchCurve, sample: int, shift: int, orbit: SpaceOrbit) -> Floats:
        """The points of a branch at a sample from one of them on, as many as those of an orbit."""
        # Where a jump is met earlier, or later, from a sample on, the orbit of that sample is
        # longer, or shorter: then it goes on with the pieces of the other one.
        points = [*np.roll(curve.points[sample], -shift, axis=0)[: len(orbit.x)]]
        p = self._at(curve, sample, orbit.p)
        for image in orbit.images[len(points) - 1 : -1]:
            points.append(image.piece.at(points[-1], p).value)
        return np.array(points)

    def _at(self, curve: BranchCurve, sample: int, p: Floats) -> Floats:
        """Parameters (k,), the one that varies as at a sample of a branch."""
        there = p.copy()
        there[self.base.problem.free[0]] = curve.parameter[sample]
        return there

    def _near(self, chords: Floats, x: float) -> Bools:
        """Between which samples a branch may pass a point, by its largest turn."""
        # By the first coordinate alone: whatever it leaves is looked at closely.
        p0, x0, p1, x1 = chords[:, :4].T
        scale = self.network.x_scale[0]
        length = np.hypot((p1 - p0) / self.network.p_scale, (x1 - x0) / scale)
        longest = np.maximum(length, SHARP_FOLD)
        bulge = (self.max_turn * longest + self.same) * scale
        off = np.abs(x1 - x0) + bulge
        near: Bools = (np.minimum(x0, x1) - off <= x) & (x <= np.maximum(x0, x1) + off)
        return near

    def _update(self, p: float) -> None:
        """Take in branches that are new, and choose what lies at a parameter."""
        slack = self.same * self.network.p_scale
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
    """Points (n, d) of a branch between two samples, and the pieces that it takes at these."""

    chord: tuple[int, int, int]
    x: Floats
    keys: tuple[Keys, ...]


def _chords_of(curve: BranchCurve, number: int) -> Floats:
    """Neighbouring samples of a branch, (m, 7), as each of the points of a cycle sees them."""
    # p and the first coordinate at both, and the numbers of the branch, the sample and the point.
    p, n = curve.parameter, len(curve.parameter) - 1
    seen = [
        np.column_stack(
            [p[:-1], x[:-1], p[1:], x[1:], np.full(n, number), np.arange(n), np.full(n, shift)]
        )
        for shift, x in enumerate(curve.x[:, :, 0].T)
    ]
    return np.concatenate(seen)


def _around(chords: Floats, p: float, slack: float) -> Floats:
    """The chords that span a parameter."""
    p0, p1 = chords[:, 0], chords[:, 2]
    found: Floats = chords[(np.minimum(p0, p1) - slack <= p) & (p <= np.maximum(p0, p1) + slack)]
    return found
