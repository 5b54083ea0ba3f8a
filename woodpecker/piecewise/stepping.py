"""Pseudo-arclength continuation of the cycles of a labelled map.

:func:`follow` is an iterator of points. It passes folds (LP), locates flips (PD), crosses
continuous changes of word (WC) and goes on with the new word; at a jump it stops with a border
collision (BC, or FF if the branch folds into a jump branch and starts one of the second iterate)
instead of hopping over it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from pwmap.diagrams.diagram import PointKind
from woodpecker.base.arrays import Floats
from woodpecker.piecewise.borders import (
    ROUGHLY,
    Edge,
    change_ahead,
    edge_of_iterate,
    is_continuous,
    nearest_edge,
)
from woodpecker.piecewise.maps import Cycle, LabelledMap, correct, evaluate, minimal_period, tangent
from woodpecker.piecewise.restart import beside, beyond, found_beside
from woodpecker.piecewise.settings import END_OF_SPAN, Settings

CLOSED = "the branch closes"
DIVIDES = "the period is divided"  # two points of the cycle meet on an edge, as at a flip
REPEATS = "the path repeats itself"  # caught between edges it cannot tell apart
MERGED = 1e-7  # points of a cycle on an edge closer than this have met: no landing tells them apart
SAME_LANDING = 1e-10  # two landings this close are one
STRIDE = 3e-4  # first step beyond a change of word, in arclength
LAST_BIT = 0.25 * math.ulp(1.0)  # in arclength


@dataclass(frozen=True, slots=True, kw_only=True)
class PathPoint:
    """A point of a branch; ``kind`` is None unless it is special."""

    cycle: Cycle
    tangent: Floats
    kind: PointKind | None = None
    note: str = ""
    edge: Edge | None = None  # at WC, BC and FF: the edge of P_1 that was met
    side: int = 0  # on which side of the branch the edge lies: -1 or +1
    lap: int = 0  # which lap met it

    @property
    def p(self) -> float:
        """Parameter."""
        return self.cycle.p

    @property
    def ends(self) -> bool:
        """Whether the branch ends here."""
        return self.kind not in (None, PointKind.LP, PointKind.PD, PointKind.WC)


def follow(
    labelled_map: LabelledMap,
    start: Cycle,
    settings: Settings,
    direction: int = 1,
    stop: Callable[[PathPoint], bool] | None = None,
) -> Iterator[PathPoint]:
    """Follow the branch through ``start``.

    Parameters
    ----------
    labelled_map
        The map.
    start
        A cycle of it, as :func:`woodpecker.piecewise.maps.correct` returns it.
    settings
        Span, window, steps and tolerances.
    direction
        +1 starts towards larger parameters, -1 towards smaller ones.
    stop
        Called with every point after the start; a true answer ends the iteration.

    Yields
    ------
    PathPoint
        The start, then points in order; the last has an ending kind unless ``stop`` ended it.
    """
    along = np.zeros(len(start.x) + 1)
    along[-1] = float(direction)
    yield from follow_from(labelled_map, start, along, settings, stop)


def follow_from(
    labelled_map: LabelledMap,
    start: Cycle,
    along: Floats,
    settings: Settings,
    stop: Callable[[PathPoint], bool] | None = None,
) -> Iterator[PathPoint]:
    """Like :func:`follow`, with any direction (j + 1,) in (x, p)."""
    point = PathPoint(cycle=start, tangent=tangent(start, along))
    path = _Path(labelled_map, settings, start)
    yield point
    for _ in range(settings.max_points):
        for reached in path.advance(point):
            if path.closed(start, point, reached):
                yield replace(reached, kind=PointKind.EP, note=CLOSED)
                return
            yield reached
            point = reached
            if point.ends or (stop is not None and stop(point)):
                return
    yield replace(point, kind=PointKind.EP, note="limit on the number of points")


class _Path:
    """Step control along one branch: its state is the step, and the last change of word."""

    def __init__(self, labelled_map: LabelledMap, settings: Settings, start: Cycle) -> None:
        self.map, self.settings, self.period = labelled_map, settings, minimal_period(start)
        self.step, self.travelled = settings.step, 0.0
        self.crossed: tuple[PathPoint, PathPoint] | None = None  # last word change, and beyond it
        self.landings: list[PathPoint] = []  # where it went on beyond word changes

    def advance(self, point: PathPoint) -> Iterator[PathPoint]:
        """The special points up to the next regular one, then that one."""
        if not np.isfinite(point.tangent).all():
            yield replace(point, kind=PointKind.EP, note="the derivatives are not finite here")
            return
        low, high = self.settings.span
        while True:
            step, bound = self.step, math.nan
            reach = point.p + step * point.tangent[-1]
            if not low <= reach <= high:
                bound = low if reach < low else high
                step = (bound - point.p) / point.tangent[-1]
            target = self._correct(point, step, bound) if step > 0.0 else point
            if target is not None:
                seen = self._same_word_until(point, target, step)
                if seen >= step:
                    break
                self.step = seen
                continue
            if self.step <= self.settings.tolerances.edge:
                yield from self._meet_edge(point)
                return
            self.step = self._shorter(point, step)
        yield from self._specials(point, target, step)
        x = target.cycle.x
        if not (self.settings.window[0] <= x.min() and x.max() <= self.settings.window[1]):
            end = self._at_window(point, target, step)
            yield replace(end, kind=PointKind.EP, note="end of the window")
        elif not math.isnan(bound):
            yield replace(target, kind=PointKind.EP, note=END_OF_SPAN)
        else:
            self.travelled += step
            turn = float(np.linalg.norm(target.tangent - point.tangent))
            if turn < 0.3 * self.settings.max_turn:
                self.step = min(2.0 * self.step, self.settings.max_step)
            yield target

    def closed(self, start: Cycle, a: PathPoint, b: PathPoint) -> bool:
        """Whether the path passes its start between two neighbouring points."""
        if self.travelled <= 4.0 * self.settings.max_step or start.words not in (
            a.cycle.words,
            b.cycle.words,
        ):
            return False
        first, last, sought = (np.append(cycle.x, cycle.p) for cycle in (a.cycle, b.cycle, start))
        chord = last - first
        length = float(np.linalg.norm(chord))
        along = float((sought - first) @ chord)
        if length == 0.0 or not 0.0 <= along <= length * length:
            return False
        off = float(np.linalg.norm(sought - first - along / length**2 * chord))
        return off <= self.settings.max_turn * length

    def _shorter(self, point: PathPoint, step: float) -> float:
        """The step after one that failed: to just before an edge ahead, or a quarter."""
        ahead = self._ahead(point, step, ROUGHLY)
        shorter = 0.25 * step if ahead is None else (1.0 - ROUGHLY) * ahead[0]
        return max(shorter, 0.25 * self.settings.tolerances.edge)

    def _ahead(self, point: PathPoint, step: float, fine: float) -> tuple[float, int] | None:
        """How far the words stay the same on the tangent, and the lap that changes its own."""

        def changed(reach: float, laps: Sequence[int]) -> list[int]:
            p = float(point.p + reach * point.tangent[-1])
            x = point.cycle.x + reach * point.tangent[:-1]
            return [k for k in laps if self.map(float(x[k]), p).word != point.cycle.laps[k].word]

        return change_ahead(changed, range(len(point.cycle.x)), step, fine, LAST_BIT)

    def _correct(self, point: PathPoint, step: float, bound: float = math.nan) -> PathPoint | None:
        """The point one step on, if it lies on the same piece and the branch bends gently."""
        x = point.cycle.x + step * point.tangent[:-1]
        p = point.p + step * point.tangent[-1]
        fixed = not math.isnan(bound)
        cycle, good, _ = correct(
            self.map, x, bound if fixed else p, None if fixed else point.tangent,
            self.settings.tolerances, point.cycle.words,
        )  # fmt: skip
        if not good or cycle.words != point.cycle.words:
            return None
        if np.abs(cycle.x - x).max() > 0.5 * step:
            return None
        there = tangent(cycle, point.tangent)
        if not np.linalg.norm(there - point.tangent) <= self.settings.max_turn:
            return None
        return PathPoint(cycle=cycle, tangent=there)

    def _same_word_until(self, a: PathPoint, b: PathPoint, step: float) -> float:
        """How far along a step every probe shows the words of its ends."""
        parts = math.ceil(step / self.settings.probe)
        ends = np.append(a.cycle.x, a.p), np.append(b.cycle.x, b.p)
        for k in range(1, parts):
            s = k / parts
            # Cubic with the positions and tangents of both ends.
            x = (
                (1.0 + 2.0 * s) * (1.0 - s) ** 2 * ends[0]
                + s * s * (3.0 - 2.0 * s) * ends[1]
                + s * (1.0 - s) * step * ((1.0 - s) * a.tangent - s * b.tangent)
            )
            if evaluate(self.map, x[:-1], float(x[-1])).words != a.cycle.words:
                return (k - 0.5) * step / parts
        return step

    def _specials(self, a: PathPoint, b: PathPoint, step: float) -> Iterator[PathPoint]:
        """Folds and flips between two neighbouring points of one piece, in order."""
        found = []
        measures: tuple[tuple[PointKind, Callable[[PathPoint], float]], ...] = (
            (PointKind.LP, lambda point: float(point.tangent[-1])),
            (PointKind.PD, lambda point: point.cycle.multiplier + 1.0),
        )
        for kind, measure in measures:
            if measure(a) * measure(b) < 0.0:
                s = self._root(a, b, step, measure)
                found.append((s, replace(self._inner(a, s), kind=kind)))
        for _, special in sorted(found, key=lambda item: item[0]):
            yield special

    def _root(
        self, a: PathPoint, b: PathPoint, step: float, measure: Callable[[PathPoint], float]
    ) -> float:
        """Arclength from a at which a measure of the points of the step changes its sign."""
        ends = measure(a), measure(b)

        def at(s: float) -> float:
            if s <= 0.0 or s >= step:
                return ends[0] if s <= 0.0 else ends[1]
            value = measure(self._inner(a, s))
            if math.isnan(value):  # Newton's method left the piece: the ends are all there is
                return ends[0] + (ends[1] - ends[0]) * s / step
            return value

        return float(brentq(at, 0.0, step, xtol=1e-15, rtol=1e-14))

    def _at_window(self, a: PathPoint, b: PathPoint, step: float) -> PathPoint:
        """Where the branch leaves the window between two neighbouring points."""
        low, high = self.settings.window
        lap = int(np.argmax(np.maximum(low - b.cycle.x, b.cycle.x - high)))
        bound = low if b.cycle.x[lap] < low else high

        def excess(point: PathPoint) -> float:
            return float(point.cycle.x[lap]) - bound

        if excess(a) * excess(b) >= 0.0:
            return b  # it started outside
        return self._inner(a, self._root(a, b, step, excess))

    def _inner(self, a: PathPoint, s: float) -> PathPoint:
        """The corrected point at arclength s from a, on the same piece."""
        cycle, _, _ = correct(
            self.map, a.cycle.x + s * a.tangent[:-1], a.p + s * a.tangent[-1], a.tangent,
            self.settings.tolerances,
        )  # fmt: skip
        return PathPoint(cycle=cycle, tangent=tangent(cycle, a.tangent))

    def _at_end_of_span(self, point: PathPoint) -> PathPoint | None:
        """The end of the branch at an end of the span where words are others, values are not.

        So it is at zero restitution, where contacts rest that bounce at any larger one.
        """
        settings = self.settings
        for bound in settings.span:
            if abs(point.p - bound) > settings.tolerances.edge:
                continue
            cycle, good, _ = correct(self.map, point.cycle.x, bound, None, settings.tolerances)
            if good and float(np.abs(cycle.x - point.cycle.x).max()) <= settings.tolerances.landing:
                return PathPoint(
                    cycle=cycle, tangent=point.tangent, kind=PointKind.EP, note=END_OF_SPAN
                )
        return None

    def _meet_edge(self, point: PathPoint) -> Iterator[PathPoint]:
        """The branch cannot go on with its word: find out what stops it."""
        end = self._at_end_of_span(point)
        if end is not None:
            yield end
            return
        met = self._met(point)
        if met is None:
            yield replace(point, kind=PointKind.EP, note="continuation stalls inside a piece")
            return
        edge, side = met.edge, met.side
        assert edge is not None
        if math.isnan(edge.jump):
            outside = edge.right if side > 0 else edge.left
            yield replace(met, kind=PointKind.FALL, note=outside.word)
        elif is_continuous(edge, self.settings.tolerances):
            if minimal_period(met.cycle, MERGED) < self.period:
                yield replace(met, kind=PointKind.EP, note=DIVIDES)
                return
            yield replace(met, kind=PointKind.WC)
            landed = self._landed(met)
            if landed is None:
                yield replace(met, kind=PointKind.EP, note="no branch beyond a word change")
                return
            self.step = max(STRIDE, self.step)
            onward = self._onward(self._turned_away(landed, met), met)
            if self._was_here(onward):
                yield replace(met, kind=PointKind.EP, note=REPEATS)
            else:
                yield onward
        else:
            whole = edge_of_iterate(self.map, met.cycle, met.lap, edge, side, met.lap)
            kind, note = classify(whole[0], -side, met.cycle.multiplier)
            yield replace(met, kind=kind, note=note)

    def _met(self, point: PathPoint) -> PathPoint | None:
        """The last point before the edge that stops the branch, with that edge of P_1."""
        for reach in (4.0, 64.0, 1024.0):
            ahead = self._ahead(point, reach * self.step, 0.0)
            if ahead is None:
                continue
            for back in (0.0, 4.0, 64.0):  # rounding may put the very last point beyond
                last = self._correct(point, ahead[0] - back * LAST_BIT)
                if last is None:
                    continue
                x, word = float(last.cycle.x[ahead[1]]), last.cycle.laps[ahead[1]].word
                met = nearest_edge(self.map, x, last.p, word)
                if met is not None:
                    return replace(last, edge=met[0], side=met[1], lap=ahead[1])
            break
        return self._crept(point)

    def _crept(self, point: PathPoint) -> PathPoint | None:
        """The same for a branch that bends towards the edge, as next to a square root."""
        good, bad = 0.0, 4.0 * self.step
        while self._correct(point, bad) is not None:
            good, bad = bad, 2.0 * bad
        last = point
        while bad - good > LAST_BIT:
            middle = 0.5 * (good + bad)
            if middle in (good, bad):
                break
            trial = self._correct(point, middle)
            if trial is None:
                bad = middle
            else:
                good, last = middle, trial
        nearest: PathPoint | None = None
        distance = math.inf
        for lap, (x, word) in enumerate(zip(last.cycle.x, last.cycle.words, strict=True)):
            met = nearest_edge(self.map, float(x), last.p, word)
            if met is not None and abs(met[0].x - x) < distance:
                distance = abs(met[0].x - x)
                nearest = replace(last, edge=met[0], side=met[1], lap=lap)
        return nearest

    def _landed(self, met: PathPoint) -> PathPoint | None:
        """A point of the branch beyond a continuous change of word."""
        assert met.edge is not None
        cycle = met.cycle
        landed = beyond(self.map, cycle, met.lap, met.edge, met.side, self.settings)
        if landed is None and len(cycle.x) == 1:
            landed = beside(self.map, met.edge, met.side, 1, self.settings)
        if landed is None or landed.cycle.words == cycle.words:
            landed = found_beside(self.map, cycle, met.tangent, self.settings)
        return None if landed is None else PathPoint(cycle=landed.cycle, tangent=landed.tangent)

    def _onward(self, landed: PathPoint, met: PathPoint) -> PathPoint:
        """The landed point; after a bounce, the one before it, looking the other way.

        A branch that comes back to the edge it has just crossed, and would go on with the words it
        had before, was followed the wrong way after the landing.
        """
        crossed, self.crossed = self.crossed, (met, landed)
        if crossed is not None:
            edge, start = crossed
            near = _distance(met, edge) <= 4.0 * _distance(start, edge)
            if near and landed.cycle.words == edge.cycle.words:
                self.crossed = None
                return replace(start, tangent=-start.tangent)
        return landed

    def _was_here(self, landed: PathPoint) -> bool:
        """Whether the path went on from this point, in this direction, before."""
        for known in self.landings:
            if (
                known.cycle.words == landed.cycle.words
                and _distance(known, landed) <= SAME_LANDING
                and float(known.tangent @ landed.tangent) > 0.0
            ):
                return True
        self.landings.append(landed)
        return False

    def _turned_away(self, landed: PathPoint, met: PathPoint) -> PathPoint:
        """The landed point, looking away from the edge along its branch.

        Next to a square root the branch can turn between the edge and the point; then the chord
        between them says nothing, and a few short steps both ways do.
        """
        assert met.edge is not None
        outside = met.edge.right if met.side > 0 else met.edge.left
        m = landed.cycle.laps[met.lap].slope
        if abs(outside.slope - m) <= 0.5 * max(1.0, abs(m)):  # the branch is straight so far
            return landed
        if self._leads_back(landed, met):
            return replace(landed, tangent=-landed.tangent)
        return landed

    def _leads_back(self, start: PathPoint, met: PathPoint) -> bool:
        """Whether a few short steps along the branch come back to an edge."""
        reach = _distance(start, met)
        point, step = start, 0.125 * reach
        for _ in range(200):
            trial = self._correct(point, step)
            if trial is None:
                step *= 0.25
                if step < 1e-6 * reach:
                    return _distance(point, met) < 0.9 * reach
                continue
            point, step = trial, min(2.0 * step, 0.125 * reach)
            near = _distance(point, met)
            if near < 0.3 * reach or near > 2.0 * reach:
                return near < reach
        return False


def classify(edge: Edge, inner: int, m: float) -> tuple[PointKind, str]:
    """Kind of the border collision in which a fixed point of slope m meets a jump.

    The fixed point lives on the piece at side ``inner`` (-1 left, +1 right) of the edge. With F the
    distance of the inner limit from the diagonal and D that of the outer one, the jump crosses the
    diagonal where F and D differ in sign. As F passes zero the fixed point x_e + F/(1 - m) is on
    the inner side for one sign of F: the collision folds if that is the sign of the crossing. The
    edge's preimage x_e - F/m then is on the inner side too (for m < 0 and for m > 1), and the
    second iterate jumps there from x_e + F to x_e + D, which lies across the diagonal if |m| > 1,
    since F - (-F/m) = F (1 + 1/m) has the sign of F: a jump branch of the second iterate starts,
    and the fold is a fold-flip.
    """
    outer = (edge.left_limit if inner > 0 else edge.right_limit) - edge.x
    crossing = -math.copysign(1.0, outer)  # sign of F where the jump crosses
    on_piece = inner * math.copysign(1.0, 1.0 - m)  # sign of F where the fixed point exists
    if crossing != on_piece:
        return PointKind.BC, "persistence"
    return (PointKind.FF if abs(m) > 1.0 else PointKind.BC), "fold"


def _distance(a: PathPoint, b: PathPoint) -> float:
    return math.hypot(a.p - b.p, float(np.abs(a.cycle.x - b.cycle.x).max()))
