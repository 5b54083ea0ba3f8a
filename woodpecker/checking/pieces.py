"""Verification of pieces: that their tubes hold exactly one cycle at every parameter."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from copy import copy
from fractions import Fraction
from functools import reduce
from itertools import zip_longest
from math import prod
from typing import Any

from pwmap.checking import Refused
from woodpecker.checking.forms import F, constant
from woodpecker.checking.guards import Guard
from woodpecker.checking.intervals import Box, I, NotSeparated, T
from woodpecker.checking.motion import run
from woodpecker.checking.reading import Interval, interval, number, whole
from woodpecker.checking.toy import NAMES, ExactToy
from woodpecker.checking.tracker import Choice, Tracker

GUARD = re.compile(r"(gap|normal|cone\+|cone-|slip|plateau\+|plateau-) ([123])|section")
MOST = 400  # events of a return at most, as in proofs
LATEST = 10  # s: no phase of a return is longer, and ranges over longer ones are useless
DEPTH = 3  # times that the line of a piece is halved at most
RESTITUTIONS = ("eps_n1", "eps_n2", "eps_n3")


def claimed(name: str, found: I, pair: Any) -> None:
    """Refused unless a claimed interval holds the enclosure that was found."""
    low, high = interval(pair)
    if not (low <= found.ends[0] and found.ends[1] <= high):
        raise Refused(f"{name} could not be shown to lie in {pair}")


class ToyData:
    """The toy of a certificate, its parameter and the order of its cycles; Refused if invalid."""

    def __init__(self, content: Mapping[str, Any]) -> None:
        toy, self.parameter, law = content["toy"], content["parameter"], content["law"]
        if set(toy) != set(NAMES) or law not in ("summed", "separate"):
            raise Refused("the toy must have all its numbers and a law, summed or separate")
        self.moves = content["kind"] != "orbit"
        if self.moves and (self.parameter not in RESTITUTIONS or toy[self.parameter] is not None):
            raise Refused("only a restitution coefficient may move, and has no value then")
        if self.parameter not in toy:
            raise Refused(f"the toy has no parameter {self.parameter!r}")
        values = {name: number(x) for name, x in toy.items() if x is not None}
        if len(values) != len(toy) - self.moves:
            raise Refused("a number of the toy is missing")
        if not all(0 <= values[name] <= 1 for name in RESTITUTIONS if name in values):
            raise Refused("restitution must lie in [0, 1]")
        if any(x <= 0 for name, x in values.items() if name[:3] not in ("eps", "mu_")):
            raise Refused("masses, lengths and stiffness must be positive")
        if any(x < 0 for x in values.values()) or values["r_m"] <= values["r_0"]:
            raise Refused("the toy cannot have these numbers")
        self.values, self.order = values, whole("order", content["order"], 1, 100)
        self.toy = ExactToy(values, law == "summed")

    def returned(self, box: Box, line: Any, curve: Any, way: WrittenWay) -> Tracker:
        """The toy's state after a return along one way, verified."""
        motion = self._start(box, line, curve)
        run(motion, [(guard, I.of(*bracket)) for guard, bracket in way.events])
        if " ".join(motion.word) != way.word:
            raise Refused(f"the word is {' '.join(motion.word)}, not {way.word}")
        return motion

    def _start(self, box: Box, line: Sequence[Fraction], curve: Sequence[Fraction]) -> Tracker:
        """The toy's state on the section, at rest."""
        eps: list[F | I] = [I.of(self.values.get(name, 0)) for name in RESTITUTIONS]
        if self.moves:
            moving = _polynomial(box, line, False)
            if not moving.value.inside(I.of(0, 1)):
                raise Refused("restitution must lie in [0, 1]")
            eps[RESTITUTIONS.index(self.parameter)] = moving
        none = constant(box, I.of(0))
        x = _polynomial(box, curve, True)
        if not x.value.less(I.of(self.toy.touch[0])):
            raise NotSeparated("the beak may touch the pole at the start")
        q = [none, constant(box, I.of(self.toy.touch[1])), x]
        return Tracker(self.toy, box, eps, q, [none, none, none])


def _polynomial(box: Box, c: Sequence[Fraction], start: bool) -> F:
    """A polynomial in tau as a function over the box; plus s if it is the start."""
    rate = [k * c[k] for k in range(1, len(c))] or [Fraction(0)]
    bend = [k * rate[k] for k in range(1, len(rate))] or [Fraction(0)]
    parts = [c, [Fraction(int(start))], rate, [Fraction(0)], [Fraction(0)], bend]
    return F(box, [T.of(box, part) for part in parts[: box.depth]])


def check_both(returns: Sequence[Tracker], kinds: Sequence[str]) -> None:
    """NotSeparated unless there is one way without open decisions, or both ways of one."""
    if len(returns) == 1 and not returns[0].forks:
        return
    forks: list[Choice] = [fork for each in returns for fork in each.forks]
    one_each = len(returns) == 2 and all(len(each.forks) == 1 for each in returns)
    if not one_each or any(fork.kind not in kinds for fork in forks):
        raise NotSeparated("a decision is open, and its two ways are not there")
    first, second = forks
    meets = first.kind == "meeting"
    same = first.kind == second.kind and first.at == second.at
    same = same and first.contacts == (second.contacts[::-1] if meets else second.contacts)
    if not same or (not meets and first.leaves == second.leaves):
        raise NotSeparated("the two ways are not those of one decision")


class WrittenWay:
    """A way as written in a certificate: its word, and guards with brackets of the durations."""

    def __init__(self, way: Mapping[str, Any]) -> None:
        if set(way) != {"word", "events"} or not 1 <= len(way["events"]) <= MOST:
            raise Refused("a way has a word and events")
        if not isinstance(way["word"], str):
            raise Refused(f"a word must be text, got {way['word']!a:.60}")
        self.word: str = way["word"]
        self.events: list[tuple[Guard, Interval]] = []
        for event in way["events"]:
            if not isinstance(event, list) or len(event) != 3:
                raise Refused(
                    f"an event is a guard and two ends of its duration, got {event!a:.60}"
                )
            name, low, high = event
            if not isinstance(name, str) or not GUARD.fullmatch(name):
                raise Refused(f"there is no guard {name!a:.40}")
            kind, _, contact = name.partition(" ")
            bracket = interval([low, high])
            if max(map(abs, bracket)) > LATEST:
                raise Refused(f"a phase lasts at most {LATEST} s, got {low:.40} to {high:.40}")
            self.events.append(((kind, int(contact) - 1 if contact else 0), bracket))


class WrittenPiece:
    """A piece as written in a certificate: a line of the parameter, and tubes with their ways."""

    def __init__(self, data: ToyData, piece: Mapping[str, Any]) -> None:
        if set(piece) != {"line", "half", "points"} or len(piece["points"]) != data.order:
            raise Refused("a piece has a line, half of its length, and a point for each return")
        self.line = [number(c) for c in piece["line"]]
        self.half, points = number(piece["half"]), piece["points"]
        if self.half < 0 or not self.line or len(self.line) > 40:
            raise Refused("a line has one to forty coefficients and a length")
        if not data.moves and (self.half != 0 or self.line != [data.values[data.parameter]]):
            raise Refused("the parameter is not that of the toy")
        if data.moves and self.half == 0:
            raise Refused("a piece of a branch has a length")
        if any(set(point) != {"curve", "radius", "ways"} for point in points):
            raise Refused("a point has a curve, a radius and ways")
        self.curves = [[number(c) for c in point["curve"]] for point in points]
        self.radii = [number(point["radius"]) for point in points]
        self.ways = [[WrittenWay(way) for way in point["ways"]] for point in points]
        if any(r <= 0 for r in self.radii) or any(not c or len(c) > 40 for c in self.curves):
            raise Refused("a tube has a curve and a positive radius")

    def parameter(self, side: int) -> Fraction:
        """The parameter at the lower (-1) or upper (1) end."""
        return value_at(self.line, side * self.half)

    def halved(self, side: int) -> WrittenPiece:
        """Its lower (-1) or upper (1) half, in the same tubes."""
        part, by = copy(self), side * self.half / 2
        part.half = self.half / 2
        part.line, part.curves = _moved(self.line, by), [_moved(c, by) for c in self.curves]
        return part


class VerifiedPiece:
    """A piece whose tubes are verified to hold exactly one cycle at every parameter on its line."""

    def __init__(self, data: ToyData, piece: WrittenPiece, terms: int, turns: bool) -> None:
        self.half, self.curves, self.radii = piece.half, piece.curves, piece.radii
        box = Box(self.half, terms)
        rate = [k * c for k, c in enumerate(piece.line)][1:] or [Fraction(0)]
        if self.half > 0 and T.of(box, rate).range.sign() != 1:
            raise NotSeparated("the parameter may turn round")
        _apart(self.curves, self.radii, box)
        misses, slopes, self.returns = [], [], []
        for k, ways in enumerate(piece.ways):
            box = Box(self.half, terms, self.radii[k], 6 if turns else 2)
            found = [data.returned(box, piece.line, self.curves[k], way) for way in ways]
            check_both(found, ("rest", "plateau"))
            aim = _polynomial(box, self.curves[(k + 1) % data.order], False)
            misses.append(hull([(r.q[2].parts[0] - aim.parts[0]).range for r in found]))
            slopes.append(hull([r.q[2].part((1, 0)) for r in found]))
            self.returns.append(found)
        self.off = _around(misses, slopes)
        if not all(s.within(I.of(r).ball) for s, r in zip(self.off, self.radii, strict=True)):
            raise NotSeparated("no cycle could be shown to lie in the tubes")
        self.multiplier = prod(slopes, start=I.of(1))
        self.turn = self._turn(slopes) if turns else None

    def _turn(self, slopes: list[I]) -> I:
        """Range of the derivative of the multiplier in tau."""
        n, misses = len(slopes), []
        images = [found[0].q[2] for found in self.returns]
        if any(len(found) > 1 for found in self.returns):
            raise NotSeparated("a word changes where a flip is claimed")
        for k, image in enumerate(images):
            aim = _polynomial(image.box, self.curves[(k + 1) % n], False)
            misses.append((image.parts[2] - aim.parts[2]).range)
        moves, total = _around(misses, slopes), I.of(0)
        for k, image in enumerate(images):
            own = image.part((1, 1)) + image.part((2, 0)) * moves[k]
            total = total + prod(slopes[:k] + slopes[k + 1 :], start=own)
        return total

    def place(self, side: int, k: int) -> tuple[Interval, Interval]:
        """The tube of point k at the lower (-1) or upper (1) end, and the point's enclosure."""
        at, radius = value_at(self.curves[k], side * self.half), self.radii[k]
        return (at - radius, at + radius), (I.of(at) + self.off[k]).ends


def verified(
    data: ToyData, piece: WrittenPiece, terms: int, turns: bool, claim: Interval, depth: int = 0
) -> list[VerifiedPiece]:
    """Verify a piece whole or, where ranges are too wide, in parts, from the low end up."""
    last = depth == DEPTH
    try:
        whole = VerifiedPiece(data, piece, terms, turns)
    except NotSeparated:
        if last:
            raise
    else:
        if last or whole.multiplier.inside(I.of(*claim)):
            return [whole]
    parts = list[VerifiedPiece]()
    for side in (-1, 1):
        parts += verified(data, piece.halved(side), terms, turns, claim, depth + 1)
    return parts


def _moved(polynomial: Sequence[Fraction], by: Fraction) -> list[Fraction]:
    c = list(polynomial)
    for k in range(len(c) - 1):
        for j in range(len(c) - 2, k - 1, -1):
            c[j] += by * c[j + 1]
    return c


def _apart(curves: Sequence[Sequence[Fraction]], radii: Sequence[Fraction], box: Box) -> None:
    """NotSeparated if the cycle may be a shorter one, traversed several times."""
    n = len(curves)

    def meet(i: int, k: int) -> bool:
        both = zip_longest(curves[i], curves[k], fillvalue=Fraction(0))
        distance = T.of(box, [a - b for a, b in both]).range
        wide = I.of(radii[i] + radii[k])
        return (distance - wide).sign() != 1 and (distance + wide).sign() != -1

    for period in range(1, n):
        if n % period == 0 and all(meet(k, (k + period) % n) for k in range(n)):
            raise NotSeparated(f"the cycle may be one of {period}, passed several times")


def value_at(c: Sequence[Fraction], x: Fraction) -> Fraction:
    """The value of a polynomial."""
    return reduce(lambda total, each: total * x + each, reversed(c), Fraction(0))


def hull(parts: Sequence[I]) -> I:
    """The smallest interval that holds all."""
    return reduce(I.hull, parts)


def _around(e: Sequence[I], slopes: Sequence[I]) -> list[I]:
    n, whole = len(e), I.of(1) - prod(slopes, start=I.of(1))
    found = []
    for i in range(n):
        total = I.of(0)
        for k in range(i, i + n):
            total = e[k % n] + slopes[k % n] * total
        found.append(total / whole)
    return found
