"""Continuation of jump crossings: discontinuities whose limits lie on both sides of the diagonal.

There is no periodic solution on such a branch, but it connects branches that end in it. The
discontinuity x_d(p) is followed by bisecting the change of word at each parameter; the branch ends
where a one-sided limit meets the diagonal (a border collision) and a fixed point appears there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

from scipy.optimize import brentq

from pwmap.diagram import PointKind
from woodpecker.edges import NEAR, Edge, edge_between, is_continuous
from woodpecker.labelled import BELOW, LabelledMap
from woodpecker.settings import Settings

FIRST_STEP = 2.5e-4  # in the parameter
NARROWEST = 1e-10  # half width within which a straight edge is predicted
COARSE = 1e-4  # of a distance in the parameter: how well an edge has to be known to halve it
RESOLVED = 1e-11  # a change of words is located this well in the parameter
JUMP_ENDS = "the jump ends"  # or meets another one: it has other words and other limits beyond
CLOSED = 1e-8  # a limit this close to the diagonal has met it
SAME_LIMITS = 1e-3  # a jump keeps its limits where its words change; another jump has others
FASTEST = 100.0  # largest speed dx/dp of an edge of which nothing is known
TURNED = 3.0  # the same, once it has been seen on the way
WIDEST = 0.02  # largest half width of the interval in x in which the edge is looked for


@dataclass(frozen=True, slots=True, kw_only=True)
class JumpPoint:
    """A point of a jump branch; ``kind`` is None unless it is special.

    At a border collision ``side`` says which limit met the diagonal: -1 left, +1 right.
    """

    edge: Edge
    kind: PointKind | None = None
    note: str = ""
    side: int = 0

    @property
    def p(self) -> float:
        """Parameter."""
        return self.edge.p

    @property
    def ends(self) -> bool:
        """Whether the branch ends here."""
        return self.kind not in (None, PointKind.WC)


def follow_jump(
    labelled_map: LabelledMap, start: Edge, settings: Settings, direction: int
) -> Iterator[JumpPoint]:
    """Follow a crossing jump from ``start`` towards larger (+1) or smaller (-1) parameters.

    Yields the points after the start; the last one ends the branch: BC where a limit meets the
    diagonal, WC where the words beside the jump change, FALL where the map is lost beside it, EP at
    the end of the span or the window, or where the jump itself vanishes.
    """
    track = _Track(labelled_map, settings, start)
    step = FIRST_STEP
    previous, current = start, start
    kink: Edge | None = None
    for _ in range(settings.max_points):
        low, high = settings.span
        p = min(max(current.p + direction * step, low), high)
        if p == current.p:
            yield JumpPoint(edge=current, kind=PointKind.EP, note="end of the parameter span")
            return
        p = track.probed(p, current, previous)
        found = track.at(p, current, previous)
        if found is None:
            last, beyond, p = track.word_change(current, previous, p)
            side = _collided(current, last)
            if side != 0:
                yield track.collision(current, last, previous, side)
                return
            if beyond is None:
                yield track.end(last, p)
                return
            found, step = beyond, FIRST_STEP
            if not _same_words(beyond, last):
                yield JumpPoint(edge=last, kind=PointKind.WC)
        side = _collided(current, found)
        if side != 0:
            yield track.collision(current, found, previous, side)
            return
        ending = track.ending(current, found, previous)
        if ending is not None:
            yield ending
            return
        yield JumpPoint(edge=found)
        if abs(found.p - current.p) > settings.tolerances.edge:
            previous = current  # else their rounding would spoil the prediction
        elif not _same_words(found, current):
            kink = found  # the edge may turn here; what lies before says nothing
        if kink is not None and abs(found.p - kink.p) > settings.tolerances.edge:
            previous, kink = kink, None
        current = found
        rate = (current.x - previous.x) / (current.p - previous.p) if current is not start else 0.0
        step = min(1.5 * step, settings.max_step / math.hypot(1.0, rate))
    yield JumpPoint(edge=current, kind=PointKind.EP, note="limit on the number of points")


def _distance(edge: Edge, side: int) -> float:
    """Signed distance of a one-sided limit from the diagonal."""
    return (edge.left_limit if side < 0 else edge.right_limit) - edge.x


def _collided(a: Edge, b: Edge) -> int:
    """Side whose limit passes the diagonal between two points of a branch; 0 if none does."""
    for side in (-1, 1):
        if a is not b and _distance(a, side) * _distance(b, side) <= 0.0:
            return side
    return 0


def _same_words(a: Edge, b: Edge) -> bool:
    return (a.left.word, a.right.word) == (b.left.word, b.right.word)


class _Mark(NamedTuple):
    """Where an edge was seen, as well as it had to be known."""

    p: float
    x: float


_Place = Edge | _Mark


def _predicted(p: float, near: _Place, before: _Place) -> float:
    """Where an edge lies at p, by the line through two known places."""
    rate = (near.x - before.x) / (near.p - before.p) if near.p != before.p else 0.0
    return near.x + rate * (p - near.p)


class _Track:
    """Finds the same edge again at another parameter: same words on both sides.

    Its memory is how well the last prediction was: a straight edge is predicted to the last bit,
    and then two evaluations tell whether it is still there.
    """

    def __init__(self, labelled_map: LabelledMap, settings: Settings, start: Edge) -> None:
        self.map, self.settings = labelled_map, settings
        self.left, self.right = start.left.word, start.right.word
        self.reach = WIDEST  # half width that held the last prediction, with a margin

    def at(self, p: float, near: _Place, before: _Place) -> Edge | None:
        """The edge at p, predicted from two known ones; None if its words are not found."""
        for widest in dict.fromkeys((self.reach, WIDEST)):
            bracket = self._bracket(p, near, before, widest)
            faced = self._faced(p, *bracket) if bracket is not None else None
            if bracket is not None and faced is not None:
                miss = abs(faced[0] - 0.5 * (bracket[0] + bracket[1]))
                self.reach = min(max(1e4 * miss, NARROWEST), WIDEST)
                return edge_between(self.map, p, *faced)
        return None

    def _faced(
        self, p: float, low: float, high: float, fine: float = 0.0
    ) -> tuple[float, float] | None:
        """Neighbours, ``fine`` apart or next doubles, where the left word faces the right one.

        There may be thin pieces of other words between low and high, on either side of the edge:
        first they are taken to lie right of it, then left.
        """
        for others in (self.right, self.left):
            inside, outside = low, high
            while outside - inside > 2.0 * fine:
                middle = 0.5 * (inside + outside)
                if middle in (inside, outside):
                    break
                word = self.map(middle, p).word
                if word == self.left or (word != self.right and others == self.left):
                    inside = middle
                else:
                    outside = middle
            beside = NEAR * math.ulp(inside) if fine == 0.0 else 0.0
            if (
                self.map(inside - beside, p).word == self.left
                and self.map(outside + beside, p).word == self.right
            ):
                return inside, outside
        return None

    def probed(self, p: float, near: Edge, before: Edge) -> float:
        """p, or the first probe on the way to it at which the words differ."""
        parts = math.ceil(abs(p - near.p) / self.settings.probe)
        for k in range(1, parts):
            middle = near.p + (p - near.p) * k / parts
            if self._bracket(middle, near, before, self.reach) is None:
                return middle
        return p

    def _bracket(
        self, p: float, near: _Place, before: _Place, widest: float, half: float = 0.0
    ) -> tuple[float, float] | None:
        """Neighbours of the predicted edge, at most ``widest`` off, that carry its two words.

        They are looked for from a distance ``half`` on, if it is given.
        """
        guess = _predicted(p, near, before)
        half = max(half, 8.0 * NEAR * math.ulp(guess))  # a neighbouring piece may be just as thin
        while half <= widest:
            left, right = guess - half, guess + half
            if self.map(left, p).word == self.left and self.map(right, p).word == self.right:
                return left, right
            half = min(10.0 * half, WIDEST) if half < WIDEST else math.inf
        return None

    def word_change(self, near: Edge, before: Edge, p: float) -> tuple[Edge, Edge | None, float]:
        """The last edge with these words on the way to p, the next beyond it, and where that is."""
        marks, bad = self._narrowed(near, before, p)
        good, last = marks[-1].p, near
        for back in (0.0, 1e-10, 1e-8, 1e-6):  # right at the change a piece is too thin to see
            edge = self.at(good + math.copysign(back, near.p - p), marks[-1], marks[-2])
            if edge is not None:
                last = edge
                break
        self.reach = WIDEST
        if good == p:
            return last, last, p
        reach, beyond = 4.0 * (bad - good), None
        while abs(reach) <= self.settings.tolerances.edge:
            found = self._change_words(last, marks[-2], good + reach)
            beyond = found or beyond
            if found is not None and not _same_words(found, last):
                break  # as long as they are the same, what comes between is too thin to see
            reach *= 8.0
        if beyond is not None:
            self.left, self.right = beyond.left.word, beyond.right.word
            return last, beyond, beyond.p
        return last, None, good + reach

    def _narrowed(self, near: Edge, before: Edge, p: float) -> tuple[list[_Mark], float]:
        """Where the edge was seen on the way to p, in order, and the first place where it is not.

        If the last edge was where it was predicted, two evaluations tell whether it still is.
        Otherwise: a piece beside it closes there, about linearly in the parameter. So where p is
        known to a distance, the edge has to be known to a small part of that distance only, and is
        predicted the better the closer the last two places are. What that overlooks shows when the
        edge is looked for to the last bit in the end; then the last place is given up.
        """
        marks = [_Mark(before.p, before.x), _Mark(near.p, near.x)]
        if self.reach <= NARROWEST and self._bracket(p, near, before, NARROWEST) is None:
            good, bad = near.p, p
            while abs(bad - good) > RESOLVED:
                middle = 0.5 * (good + bad)
                if self._bracket(middle, near, before, NARROWEST) is not None:
                    good = middle
                else:
                    bad = middle
            if self.at(bad, near, before) is None:
                return [*marks, _Mark(good, _predicted(good, near, before))], bad
        ahead = p  # first it is looked for at p itself
        bad, exact = p + math.copysign(RESOLVED, p - near.p), len(marks) - 1
        while True:
            while abs(bad - marks[-1].p) > RESOLVED:
                fine = 0.0 if len(marks) == exact else COARSE * abs(bad - marks[-1].p)
                fastest = FASTEST if len(marks) == 2 else TURNED
                x = self._seen(ahead, marks[-1], marks[-2], fine, fastest)
                if x is None:
                    bad = ahead
                else:
                    marks.append(_Mark(ahead, x))
                ahead = 0.5 * (marks[-1].p + bad)
            if len(marks) == 2 or self.at(marks[-1].p, marks[-1], marks[-2]) is not None:
                return marks, bad
            while len(marks) > 2 and self.at(marks[-1].p, marks[-1], marks[-2]) is None:
                bad = marks.pop().p
            exact = len(marks)
            ahead = 0.5 * (marks[-1].p + bad)

    def _seen(
        self, p: float, near: _Mark, before: _Mark, fine: float, fastest: float
    ) -> float | None:
        """Where the edge lies, to ``fine`` or the last bit; None if its words are not there."""
        widest = min(WIDEST, max(fastest * abs(p - near.p), NARROWEST))
        bracket = self._bracket(p, near, before, widest, 2.0 * fine)
        if bracket is None:
            return None
        faced = self._faced(p, *bracket, fine)
        return faced[0] if faced is not None else None

    def end(self, last: Edge, p: float) -> JumpPoint:
        """Why there is no jump with other words beyond the last one seen."""
        for side in (-1, 1):
            if abs(_distance(last, side)) <= CLOSED:  # its piece closes as it meets the diagonal
                return JumpPoint(edge=last, kind=PointKind.BC, side=side)
        for side in (-1, 1):
            beside = self.map(last.x + side * 100.0 * abs(p - last.p), p)
            if not beside.defined or beside.word == BELOW:
                return JumpPoint(edge=last, kind=PointKind.FALL, note=beside.word)
        return JumpPoint(edge=last, kind=PointKind.EP, note=JUMP_ENDS)

    def _change_words(self, near: Edge, before: _Mark, p: float) -> Edge | None:
        """The jump with new words at p, if it still crosses the diagonal, and can be kept."""
        guess = _predicted(p, near, before)
        half = 8.0 * NEAR * math.ulp(guess)
        for _ in range(5):
            low, high = guess - half, guess + half
            for inside, outside in ((low, high), (high, low)):
                if self.map(inside, p).word == self.map(outside, p).word:
                    break
                edge = edge_between(self.map, p, inside, outside)
                shift = max(
                    abs(edge.left_limit - near.left_limit), abs(edge.right_limit - near.right_limit)
                )
                if edge.crosses and shift < SAME_LIMITS:
                    return edge
            half = max(10.0 * half, 100.0 * abs(p - near.p))
        return None

    def ending(self, a: Edge, b: Edge, before: Edge) -> JumpPoint | None:
        """The end of the branch at b, if it ends there for another reason than a collision."""
        low, high = self.settings.window
        if math.isnan(b.jump):
            lost = b.left if math.isnan(b.left_limit) else b.right
            return JumpPoint(edge=b, kind=PointKind.FALL, note=lost.word)
        if is_continuous(b, self.settings.tolerances):
            return JumpPoint(edge=b, kind=PointKind.EP, note="the jump closes")
        if not low <= b.x <= high:
            bound = low if b.x < low else high
            edge = self.locate(a, b, before, lambda edge: edge.x - bound)
            return JumpPoint(edge=edge, kind=PointKind.EP, note="end of the window")
        if b.p in self.settings.span:
            return JumpPoint(edge=b, kind=PointKind.EP, note="end of the parameter span")
        return None

    def collision(self, a: Edge, b: Edge, before: Edge, side: int) -> JumpPoint:
        """Where the limit on one side meets the diagonal between two points of the branch."""
        edge = self.locate(a, b, before, lambda edge: _distance(edge, side))
        return JumpPoint(edge=edge, kind=PointKind.BC, side=side)

    def locate(self, a: Edge, b: Edge, before: Edge, measure: Callable[[Edge], float]) -> Edge:
        """Where a measure of the edge changes its sign between two points of the branch."""
        found: dict[float, Edge] = {a.p: a, b.p: b}

        def at(p: float) -> float:
            if p not in found:
                edge = self.at(p, a, before) or self.at(p, b, b)
                if edge is None:  # other words in between: the nearer of the known points decides
                    edge = min(a, b, key=lambda known: abs(known.p - p))
                found[p] = edge
            return measure(found[p])

        if a.p == b.p or measure(a) * measure(b) > 0.0:
            return b
        p = float(brentq(at, a.p, b.p, xtol=1e-15, rtol=1e-14))
        at(p)
        return found[p]
