"""Tracking an edge of a map, step by step in the parameter, and finding where its words change."""

from __future__ import annotations

import math
from typing import NamedTuple

from woodpecker.piecewise.borders import NEAR, WIDENINGS, Edge, edge_between
from woodpecker.piecewise.maps import LabelledMap
from woodpecker.piecewise.settings import Settings

NARROWEST = 1e-10  # half width within which a straight edge is predicted
COARSE = 1e-4  # of a distance in the parameter: how well an edge has to be known to halve it
RESOLVED = 1e-11  # a change of words is located this well in the parameter
SAME_LIMITS = 1e-3  # a jump keeps its limits where its words change; another jump has others
FASTEST = 100.0  # largest speed dx/dp of an edge of which nothing is known
TURNED = 3.0  # the same, once it has been seen on the way
WIDEST = 0.02  # largest half width of the interval in x in which the edge is looked for


def same_words(a: Edge, b: Edge) -> bool:
    """Whether two edges have the same words on both sides."""
    return (a.left.word, a.right.word) == (b.left.word, b.right.word)


def shift(a: Edge, b: Edge) -> float:
    """How far the limits of two edges are apart, at most."""
    return max(abs(a.left_limit - b.left_limit), abs(a.right_limit - b.right_limit))


class _Mark(NamedTuple):
    """Where an edge was seen, as well as it had to be known."""

    p: float
    x: float


_Place = Edge | _Mark


def _predicted(p: float, near: _Place, before: _Place) -> float:
    """Where an edge lies at p, by the line through two known places."""
    rate = (near.x - before.x) / (near.p - before.p) if near.p != before.p else 0.0
    return near.x + rate * (p - near.p)


class Track:
    """Finds the same edge again at another parameter: same words on both sides.

    Its memory is how well the last prediction was: a straight edge is predicted to the last bit,
    and then two evaluations tell whether it is still there.
    """

    def __init__(self, labelled_map: LabelledMap, settings: Settings, start: Edge) -> None:
        self.map, self.settings = labelled_map, settings
        self.take(start)
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
            for widening in range(1 + WIDENINGS if fine == 0.0 else 1):
                beside = NEAR * math.ulp(inside) * 4.0**widening if fine == 0.0 else 0.0
                if (
                    self.map(inside - beside, p).word == self.left
                    and self.map(outside + beside, p).word == self.right
                ):
                    return inside, outside
        return None

    def sees(self, p: float, near: Edge, before: Edge) -> bool:
        """Whether the edge is where it is predicted at p, as well as it was the last time."""
        return self._bracket(p, near, before, self.reach) is not None

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

    def take(self, edge: Edge) -> None:
        """From here on look for an edge with other words."""
        self.left, self.right = edge.left.word, edge.right.word

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
            if found is not None and not same_words(found, last):
                break  # as long as they are the same, what comes between is too thin to see
            reach *= 8.0
        return last, beyond, good + reach if beyond is None else beyond.p

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

    def _change_words(self, near: Edge, before: _Mark, p: float) -> Edge | None:
        """The jump with new words at p, if there is one."""
        guess = _predicted(p, near, before)
        half = 8.0 * NEAR * math.ulp(guess)
        for _ in range(5):
            low, high = guess - half, guess + half
            for inside, outside in ((low, high), (high, low)):
                if self.map(inside, p).word == self.map(outside, p).word:
                    break
                edge = edge_between(self.map, p, inside, outside)
                if shift(edge, near) < SAME_LIMITS:
                    return edge
            half = max(10.0 * half, 100.0 * abs(p - near.p))
        return None
