"""Duplicates: cycles and jumps that lie on branches which were followed already."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from pwmap.diagrams.diagram import BranchKind
from woodpecker.base.arrays import Bools, Floats
from woodpecker.base.cubics import hermite_increment
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

NONE: Floats = np.empty((0, 7))  # no chords, see :func:`_chords_of`


class Duplicates:
    """The branches of one kind and order, which tell whether an orbit lies on one of them.

    It does if one Newton step leads to it from the orbit of the branch at the same parameter,
    interpolated between two samples. Branches that take the same pieces are tried first.
    """

    def __init__(self, network: Network, kind: BranchKind, order: int, base: SolutionCurve) -> None:
        self.network, self.kind, self.order, self.base = network, kind, order, base
        self.same, self.max_turn = network.settings.same, base.settings.max_turn
        self._seen = 0
        self._chords: list[Floats] = []
        self._p, self._here = np.nan, NONE  # the parameter asked for last, and the chords there
        self._holds_by_chord = dict[tuple[int, int, int], bool]()

    def explains(self, orbit: SpaceOrbit, problem: Problem, keys: Keys) -> bool:
        """Whether a branch passes through an orbit with given equations and keys of its pieces."""
        places = sorted(self._places(orbit), key=lambda place: problem.apart(place.x, orbit.x))
        others = []
        for place in places:
            if not any(agree(own, keys) for own in place.keys):
                others += [place] if place.is_between else []  # beyond its end no piece changes
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
        """The place on the cubic through both samples, with tangents of the orbit's own pieces."""
        # Where orbits are steep the chord lies too far off for Newton's method.
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
            """The parameter on the cubic minus that of the orbit; exact at the end."""
            return (
                float((chord if s == 1.0 else hermite_increment(s, chord, d0, d1))[size]) - target
            )

        if past(0.0) * past(1.0) < 0.0:  # between the samples
            s = float(brentq(past, 0.0, 1.0))
            way = hermite_increment(s, chord, d0, d1)[:size].reshape(orbit.x.shape)
            yield one.x + way * self.network.x_scale

    def _holds(self, place: _SamplePlace, orbit: SpaceOrbit) -> bool:
        """Whether a branch takes at a place between samples the pieces of one of these samples."""
        # If it does, an orbit with other pieces at this place belongs to another branch.
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
        """Whether a cycle of the map near x takes the pieces of a branch at one of its samples."""
        # At a sample on a border the map may take other pieces; then the next one is used.
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
        """The pieces of a branch at the first of some samples; empty if the map takes others."""
        word = word_at(curve, samples[0])
        for k in samples:
            if 0 <= k < len(curve.points) and word_at(curve, k) is word:
                there = self._at(curve, k, p)
                pieces = tuple(self.base.map.at(x, there).piece for x in curve.points[k])
                if tuple(piece.key for piece in pieces) == word.keys:
                    return pieces
        return ()

    def _places(self, orbit: SpaceOrbit) -> list[_SamplePlace]:
        """The places of branches at an orbit's parameter that may pass near its first point."""
        p = float(orbit.p[self.base.problem.free[0]])
        self._update(p)
        near, found = self._here[self._near(self._here, float(orbit.x[0, 0]))], []
        for number, k, shift in near[:, 4:].astype(int).tolist():
            curve = self.network.curves[number]
            one, other = (self._points(curve, j, shift, orbit) for j in (k, k + 1))
            p0, p1 = curve.parameter[k], curve.parameter[k + 1]
            part = min(1.0, max(0.0, (p - p0) / (p1 - p0))) if p1 != p0 else 0.5
            keys = tuple(from_point(word.keys, shift) for word in words_between(curve, k))
            chord, between = (number, k, shift), min(p0, p1) <= p <= max(p0, p1)
            found.append(_SamplePlace(chord, one + part * (other - one), keys, between))
        return found

    def _points(self, curve: BranchCurve, sample: int, shift: int, orbit: SpaceOrbit) -> Floats:
        """The points of a branch at a sample, from number ``shift`` on, as many as an orbit has."""
        # If the orbits of a jump branch meet their jump later, or earlier, from some sample on, the
        # numbers of points differ: missing ones follow by the pieces of the given orbit.
        points = [*np.roll(curve.points[sample], -shift, axis=0)[: len(orbit.x)]]
        p = self._at(curve, sample, orbit.p)
        for image in orbit.images[len(points) - 1 : -1]:
            points.append(image.piece.at(points[-1], p).value)
        return np.array(points)

    def _at(self, curve: BranchCurve, sample: int, p: Floats) -> Floats:
        """The parameters p (k,) with the one that varies set to its value at a sample."""
        there = p.copy()
        there[self.base.problem.free[0]] = curve.parameter[sample]
        return there

    def _near(self, chords: Floats, x: float) -> Bools:
        """A mask (m,) of the chords near which a branch may pass x, given its largest turn."""
        # The first coordinate alone decides; whatever it admits is examined closely.
        p0, x0, p1, x1 = chords[:, :4].T
        scale = self.network.x_scale[0]
        length = np.hypot((p1 - p0) / self.network.p_scale, (x1 - x0) / scale)
        longest = np.maximum(length, SHARP_FOLD)
        bulge = (self.max_turn * longest + self.same) * scale
        off = np.abs(x1 - x0) + bulge
        near: Bools = (np.minimum(x0, x1) - off <= x) & (x <= np.maximum(x0, x1) + off)
        return near

    def _update(self, p: float) -> None:
        """Add the chords of new branches, and select those that span a parameter."""
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
    """Points x (n, d) of a branch between two samples, and the keys of its pieces at these."""

    chord: tuple[int, int, int]  # numbers of the branch, of the first sample, of the first point
    x: Floats
    keys: tuple[Keys, ...]
    is_between: bool  # whether the parameter lies between both, not only close to one of them


def _chords_of(curve: BranchCurve, number: int) -> Floats:
    """The chords (m, 7) between neighbouring samples of a branch, for each point of its cycle."""
    # Columns: p and the first coordinate at both ends; numbers of the branch, sample and point.
    p, n = curve.parameter, len(curve.parameter) - 1
    seen = [
        np.column_stack(
            [p[:-1], x[:-1], p[1:], x[1:], np.full(n, number), np.arange(n), np.full(n, shift)]
        )
        for shift, x in enumerate(curve.x[:, :, 0].T)
    ]
    return np.concatenate(seen)


def _around(chords: Floats, p: float, slack: float) -> Floats:
    p0, p1 = chords[:, 0], chords[:, 2]
    found: Floats = chords[(np.minimum(p0, p1) - slack <= p) & (p <= np.maximum(p0, p1) + slack)]
    return found
