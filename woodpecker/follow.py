"""Pseudo-arclength continuation of the cycles of a labelled map.

:func:`follow` is an iterator of points. It passes folds (LP), locates flips (PD), crosses
continuous changes of word (WC) and goes on with the new word; at a jump it stops with a border
collision (BC, or FF if the branch folds into a jump branch and starts one of the second iterate)
instead of hopping over it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.optimize import brentq

from pwmap.diagram import PointKind
from woodpecker.arrays import Floats
from woodpecker.edges import Edge, is_continuous, nearest_edge
from woodpecker.labelled import (
    Cycle,
    LabelledMap,
    correct,
    evaluate,
    iterate,
    tangent,
)
from woodpecker.pieces import Resolution, sampled, slice_of
from woodpecker.tolerances import DEFAULT, Tolerances

CLOSED = "the branch closes"
REPEATS = "the path repeats itself"  # caught between edges it cannot tell apart
SAME_LANDING = 1e-10  # two landings this close are one
NEARLY_UPRIGHT = 1e-3  # smallest cosine that a direction in (x, p) is divided by


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """How far and how finely to follow a branch.

    Parameters
    ----------
    span
        Interval of the parameter; the branch ends (EP) at its ends.
    window
        Interval of x; the branch ends (EP) where it leaves it.
    step, max_step
        First and largest step in arclength of (x, p).
    max_turn
        Largest angle [rad] between the tangents of neighbouring points.
    probe
        Largest distance along a step at which the word is looked at: a stretch of another word
        shorter than this can be missed.
    max_points
        The branch ends (EP) after this many points.
    """

    span: tuple[float, float] = (0.0, 1.0)
    window: tuple[float, float] = (-math.inf, math.inf)
    step: float = 0.005
    max_step: float = 0.02
    max_turn: float = 0.1
    probe: float = 0.001
    max_points: int = 5000
    tolerances: Tolerances = field(default=DEFAULT)

    def __post_init__(self) -> None:
        for name in ("span", "window"):
            low, high = getattr(self, name)
            if not low < high:
                raise ValueError(f"{name} must ascend, got ({low}, {high})")
            object.__setattr__(self, name, (float(low), float(high)))
        if not 0.0 < self.step <= self.max_step:
            raise ValueError(f"step must lie in (0, {self.max_step}], got {self.step}")


@dataclass(frozen=True, slots=True, kw_only=True)
class PathPoint:
    """A point of a branch; ``kind`` is None unless it is special."""

    cycle: Cycle
    tangent: Floats
    kind: PointKind | None = None
    note: str = ""
    edge: Edge | None = None  # at WC, BC and FF: the edge that was met, of the iterate
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
        A cycle of it, as :func:`woodpecker.labelled.correct` returns it.
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
    path = _Path(labelled_map, settings)
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

    def __init__(self, labelled_map: LabelledMap, settings: Settings) -> None:
        self.map, self.settings = labelled_map, settings
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
            self.step *= 0.25
        yield from self._specials(point, target, step)
        x = target.cycle.x
        if not (self.settings.window[0] <= x.min() and x.max() <= self.settings.window[1]):
            end = self._at_window(point, target, step)
            yield replace(end, kind=PointKind.EP, note="end of the window")
        elif not math.isnan(bound):
            yield replace(target, kind=PointKind.EP, note="end of the parameter span")
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

    def _correct(self, point: PathPoint, step: float, bound: float = math.nan) -> PathPoint | None:
        """The point one step on, if it lies on the same piece and the branch bends gently."""
        x = point.cycle.x + step * point.tangent[:-1]
        p = point.p + step * point.tangent[-1]
        fixed = not math.isnan(bound)
        cycle, good, _ = correct(
            self.map, x, bound if fixed else p, None if fixed else point.tangent,
            self.settings.tolerances,
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

    def _meet_edge(self, point: PathPoint) -> Iterator[PathPoint]:
        """The branch cannot go on with its word: find out what stops it."""
        good, bad = 0.0, 4.0 * self.step
        while self._correct(point, bad) is not None:
            good, bad = bad, 2.0 * bad
        last = point
        while bad - good > math.ulp(1.0) * 0.25:
            middle = 0.5 * (good + bad)
            if middle in (good, bad):
                break
            trial = self._correct(point, middle)
            if trial is None:
                bad = middle
            else:
                good, last = middle, trial
        lap, met = self._which_lap(last)
        if met is None:
            yield replace(last, kind=PointKind.EP, note="continuation stalls inside a piece")
            return
        edge, side = met
        special = replace(last, edge=edge, side=side, lap=lap)
        if math.isnan(edge.jump):
            outside = edge.right if side > 0 else edge.left
            yield replace(special, kind=PointKind.FALL, note=outside.word)
        elif is_continuous(edge, self.settings.tolerances):
            yield replace(special, kind=PointKind.WC)
            landed = start_beside(self.map, edge, side, len(last.cycle.x), self.settings, lap)
            if landed is None or landed.cycle.words == last.cycle.words:
                landed = self._found_beside(last)
            if landed is None:
                yield replace(special, kind=PointKind.EP, note="no branch beyond a word change")
                return
            self.step = max(100.0 * self.settings.tolerances.landing, self.step)
            onward = self._onward(self._turned_away(landed, special), special)
            if self._was_here(onward):
                yield replace(special, kind=PointKind.EP, note=REPEATS)
            else:
                yield onward
        else:
            kind, note = classify(edge, -side, last.cycle.multiplier)
            yield replace(special, kind=kind, note=note)

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

    def _found_beside(self, last: PathPoint) -> PathPoint | None:
        """The nearest cycle of other words at a neighbouring parameter, from all that are there."""
        order, x = len(last.cycle.x), float(last.cycle.x[0])
        whole = sampled(iterate(self.map, order))
        speed = np.linalg.norm(last.tangent[:-1]) / max(abs(last.tangent[-1]), NEARLY_UPRIGHT)
        for scale in (0.1, 1.0, 10.0, 100.0):
            delta = scale * self.settings.tolerances.landing
            half = 10.0 * delta * (1.0 + float(speed))
            found: list[tuple[float, PathPoint]] = []
            for p in (last.p + delta, last.p - delta):
                if not self.settings.span[0] <= p <= self.settings.span[1]:
                    continue
                look = Resolution(spacing=half / 50.0, smallest=1e-3 * delta, bend=1e-3 * half)
                for root, _ in slice_of(whole, p, (x - half, x + half), look).fixed_points:
                    orbit = _orbit(self.map, root, p, order)
                    if orbit is None:
                        continue
                    cycle, good, _ = correct(self.map, orbit, p, None, self.settings.tolerances)
                    if good and cycle.words != last.cycle.words:
                        away = np.append(cycle.x - last.cycle.x, p - last.p)
                        point = PathPoint(cycle=cycle, tangent=tangent(cycle, away))
                        found.append((float(np.linalg.norm(away)), point))
            if found:
                return min(found, key=lambda item: item[0])[1]
        return None

    def _turned_away(self, landed: PathPoint, met: PathPoint) -> PathPoint:
        """The landed point, looking away from the edge along its branch.

        Next to a square root the branch can turn between the edge and the point; then the chord
        between them says nothing, and a few short steps both ways do.
        """
        assert met.edge is not None
        outside = met.edge.right if met.side > 0 else met.edge.left
        m = landed.cycle.multiplier
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

    def _which_lap(self, point: PathPoint) -> tuple[int, tuple[Edge, int] | None]:
        """The lap whose point lies closest to an edge, and that edge of the iterate."""
        order = len(point.cycle.x)
        if order == 1:
            x = float(point.cycle.x[0])
            return 0, nearest_edge(self.map, x, point.p, point.cycle.words[0])
        best: tuple[float, int] = (math.inf, 0)
        for lap, x in enumerate(point.cycle.x):
            met = nearest_edge(self.map, float(x), point.p, point.cycle.words[lap])
            if met is not None and abs(met[0].x - x) < best[0]:
                best = abs(met[0].x - x), lap
        lap = best[1]
        if best[0] == math.inf:
            return lap, None
        whole = iterate(self.map, order)
        x = float(point.cycle.x[lap])
        return lap, nearest_edge(whole, x, point.p, whole(x, point.p).word)


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


def start_beside(
    labelled_map: LabelledMap, edge: Edge, side: int, order: int, settings: Settings, lap: int = 0
) -> PathPoint | None:
    """A point of the branch that leaves an edge of P_order into the piece at ``side``.

    First along the tangent of that piece, then, if its slope is infinite at the edge (a grazing),
    by bracketing the fixed point at a neighbouring parameter. None if there is no such branch.
    """
    whole = iterate(labelled_map, order)
    outside = edge.right if side > 0 else edge.left
    delta = settings.tolerances.landing
    for scale in (1.0, 10.0, 100.0):
        for x, p in (
            *_along_tangent(edge, outside.slope, outside.rate, delta * scale),
            *_bracketed(whole, edge, side, outside.word, delta * scale),
        ):
            if not settings.span[0] <= p <= settings.span[1]:
                continue
            orbit = _orbit(labelled_map, x, p, order)
            if orbit is None:
                continue
            cycle, good, _ = correct(labelled_map, orbit, p, None, settings.tolerances)
            if good and cycle.word == outside.word and abs(cycle.x[0] - x) <= delta * scale:
                chord = np.zeros(order + 1)
                chord[0], chord[-1] = cycle.x[0] - edge.x, p - edge.p
                direction = tangent(cycle, chord)
                cycle = evaluate(labelled_map, np.roll(cycle.x, lap), p)
                direction[:-1] = np.roll(direction[:-1], lap)
                return PathPoint(cycle=cycle, tangent=direction)
    return None


def _along_tangent(
    edge: Edge, slope: float, rate: float, delta: float
) -> Iterator[tuple[float, float]]:
    """Steps both ways along the tangent of the outer piece at the edge."""
    norm = math.hypot(rate, 1.0 - slope)
    if not 0.0 < norm < 1e4:
        return
    for sign in (1.0, -1.0):
        yield edge.x + sign * delta * rate / norm, edge.p + sign * delta * (1.0 - slope) / norm


def _bracketed(
    whole: LabelledMap, edge: Edge, side: int, word: str, delta: float
) -> Iterator[tuple[float, float]]:
    """Fixed points on the outer piece at parameters next to the edge's."""
    for p in (edge.p + delta, edge.p - delta):
        far = edge.x + side * 100.0 * delta
        near = edge.x - side * 100.0 * delta
        if whole(far, p).word != word or whole(near, p).word == word:
            continue
        first = _first_inside(whole, near, far, p, word, 1e-4 * delta)
        f_first = whole(first, p).value - first
        reach = 1e-3 * delta
        previous = first
        while reach < WIDEST_LANDING:
            x = first + side * reach
            here = whole(x, p)
            if here.word != word:
                break
            if (here.value - x) * f_first <= 0.0:
                low, high = sorted((previous, x))
                yield float(brentq(lambda t: whole(t, p).value - t, low, high, xtol=1e-16)), p  # noqa: B023
                break
            previous, reach = x, 2.0 * reach


WIDEST_LANDING = 0.01  # a fixed point further than this from the edge is not the branch's


def _first_inside(
    whole: LabelledMap, outside: float, inside: float, p: float, word: str, fine: float
) -> float:
    """A point of a piece no further than ``fine`` from its end."""
    while abs(outside - inside) > fine:
        middle = 0.5 * (inside + outside)
        if whole(middle, p).word == word:
            inside = middle
        else:
            outside = middle
    return inside


def _orbit(labelled_map: LabelledMap, x: float, p: float, order: int) -> Floats | None:
    values = [x]
    for _ in range(order - 1):
        lap = labelled_map(values[-1], p)
        if not lap.defined:
            return None
        values.append(lap.value)
    return np.array(values)
