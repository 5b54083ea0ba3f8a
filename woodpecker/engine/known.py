"""Which cycles and jumps are on branches that were followed already."""

from __future__ import annotations

from bisect import bisect_right

import numpy as np

from pwmap.diagrams.diagram import BranchKind
from woodpecker.base.arrays import Floats
from woodpecker.engine.branches import is_inside
from woodpecker.engine.network import Network
from woodpecker.engine.orbits import (
    Closed,
    Condition,
    Coordinate,
    Orbit,
    newton_step,
    orbit_of,
    solve,
)
from woodpecker.engine.pieces import Piece


class Known:
    """Which cycles and jumps the branches of one order explain.

    An orbit lies on a branch if one Newton step takes the orbit that the branch has at its
    parameter, between two samples, to it.
    """

    def __init__(self, network: Network, kind: BranchKind, order: int) -> None:
        self.network, self.kind, self.order = network, kind, order
        self.settings = network.settings
        self._seen = 0
        self._chords = np.empty((0, 7))  # p, x_0 at both ends; numbers of curve, sample and point

    def explains(self, orbit: Orbit, closing: Condition, keys: tuple[object, ...]) -> bool:
        """Whether a branch passes through an orbit.

        Parameters
        ----------
        orbit, closing
            The orbit, and the condition that makes it a cycle or a border orbit.
        keys
            Its pieces, see :class:`woodpecker.engine.branches.Word`.
        """
        self._update()
        slack = self.settings.same
        p0, x0, p1, x1 = self._chords[:, :4].T
        tolerance = slack * self.settings.p_scale
        near = (np.minimum(p0, p1) - tolerance <= orbit.p) & (
            orbit.p <= np.maximum(p0, p1) + tolerance
        )
        off = np.abs(x1 - x0) + self._bulge(p1 - p0, x1 - x0)
        near &= np.minimum(x0, x1) - off <= orbit.x[0]
        near &= orbit.x[0] <= np.maximum(x0, x1) + off
        return any(self._reaches(row, orbit, closing, keys) for row in self._chords[near])

    def _bulge(self, dp: Floats, dx: Floats) -> Floats:
        """How far a branch may stray from the chord of two samples, by its largest turn."""
        length = np.hypot(dp / self.settings.p_scale, dx / self.settings.x_scale)
        found: Floats = (
            self.settings.max_turn * length + self.settings.same
        ) * self.settings.x_scale
        return found

    def _reaches(
        self, row: Floats, orbit: Orbit, closing: Condition, keys: tuple[object, ...]
    ) -> bool:
        p0, _, p1, _ = row[:4].tolist()
        curve, k, shift = self.network.curves[int(row[4])], int(row[5]), int(row[6])
        own = [
            curve.words[bisect_right(curve.words, j, key=lambda word: word.first) - 1]
            for j in (k, k + 1)
        ]
        one, other = (np.roll(curve.points[j], -shift) for j in (k, k + 1))
        if len(one) != len(orbit) or len(other) != len(orbit):
            return False
        part = min(1.0, max(0.0, (orbit.p - p0) / (p1 - p0))) if p1 != p0 else 0.5
        x = one + part * (other - one)
        before = float(np.abs(x - orbit.x).max())
        step = newton_step(
            orbit_of(orbit.pieces, x, orbit.p), (closing, Coordinate(-1, orbit.p)), self.settings
        )
        after = float(np.abs(x + step[:-1] - orbit.x).max())
        same = self.settings.same * self.settings.x_scale
        if not (before <= same or after <= CLOSER * before):
            return False
        if any(agree((*word.keys[shift:], *word.keys[:shift]), keys) for word in own):
            return True
        return isinstance(closing, Closed) and not any(
            self._holds((*word.pieces[shift:], *word.pieces[:shift]), x, orbit.p) for word in own
        )

    def _holds(self, pieces: tuple[Piece, ...], x: Floats, p: float) -> bool:
        """Whether a cycle near some points takes these pieces.

        If not, a branch takes others for a while between two samples that both take these.
        """
        if len(pieces) < len(x):
            return True  # a branch that was read from a file knows no pieces
        found = solve(orbit_of(pieces, x, p), (Closed(), Coordinate(-1, p)), self.settings)
        return found.converged and is_inside(found.orbit, Closed())

    def _update(self) -> None:
        rows = [self._chords]
        for number, curve in enumerate(self.network.curves[self._seen :], self._seen):
            if curve.order != self.order or curve.kind is not self.kind:
                continue
            shifts = 1 if self.kind is BranchKind.JUMP else self.order
            p, n = curve.parameter, len(curve.parameter) - 1
            for shift in range(shifts):
                x = np.array([points[shift] for points in curve.points])
                rows.append(
                    np.column_stack([
                        p[:-1], x[:-1], p[1:], x[1:], np.full(n, number), np.arange(n),
                        np.full(n, shift),
                    ])
                )  # fmt: skip
        self._seen = len(self.network.curves)
        self._chords = np.concatenate(rows)


CLOSER = 0.5  # part of its distance that a Newton step leaves at most, if it leads to an orbit


def agree(one: tuple[object, ...], other: tuple[object, ...]) -> bool:
    """Whether two orbits take the same pieces; at a border one side is enough.

    What is on the other side of a jump may be a piece so thin that rounding decides whether it is
    seen.
    """
    return len(one) == len(other) and all(
        not a.isdisjoint(b) if isinstance(a, frozenset) and isinstance(b, frozenset) else a == b
        for a, b in zip(one, other, strict=True)
    )
