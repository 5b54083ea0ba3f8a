"""Continuation of jump crossings: discontinuities whose limits lie on both sides of the diagonal.

There is no periodic solution on such a branch, but it connects branches that end in it. P_j jumps
where an orbit passes a jump of P_1: so a jump branch of P_j is an orbit that leads to an edge of
P_1, and the two orbits that go on from its limits. All of them are smooth in the parameter, and
their slopes are known. The branch ends where a one-sided limit meets the diagonal (a border
collision) and a fixed point appears there; words change where one of the orbits meets another edge.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from scipy.optimize import brentq

from pwmap.diagrams.diagram import PointKind
from woodpecker.piecewise.borders import (
    NEAR,
    ROUGHLY,
    Edge,
    change_ahead,
    is_continuous,
    nearest_edge,
)
from woodpecker.piecewise.maps import (
    BELOW,
    NEWTON_STEPS,
    SEPARATOR,
    Evaluation,
    LabelledMap,
    composed,
    iterate,
)
from woodpecker.piecewise.settings import END_OF_SPAN, Settings
from woodpecker.piecewise.tracking import RESOLVED, SAME_LIMITS, Track, same_words, shift

FIRST_STEP = 2.5e-4  # in the parameter
ROOT = 1e-7  # a square root changes by about 1e-8 over one spacing of doubles
JUMP_ENDS = "the jump ends"  # or meets another one: it has other words and other limits beyond
CLOSED = 1e-8  # a limit this close to the diagonal has met it
CALM = 4  # so many changes of word may follow each other closely
SAME_ORBIT = 1e-5  # an orbit that leads to an edge stays this close where its words change


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
    labelled_map: LabelledMap, start: Edge | Jump, settings: Settings, direction: int,
    order: int = 1,
) -> Iterator[JumpPoint]:  # fmt: skip
    """Follow a crossing jump of P_order from ``start`` towards larger (+1) or smaller parameters.

    Yields the points after the start; the last one ends the branch: BC where a limit meets the
    diagonal, WC where the words beside the jump change, FALL where the map is lost beside it, EP at
    the end of the span or the window, or where the jump itself vanishes.
    """
    course, first = _begun(labelled_map, start, settings, order)
    low, high = settings.span
    step = FIRST_STEP
    previous, current = first, first
    kink: Jump | None = None
    restless = 0  # changes of word in a row, each right behind the one before
    for _ in range(settings.max_points):
        p = min(max(current.p + direction * step, low), high)
        if p == current.p:
            yield JumpPoint(edge=current.whole, kind=PointKind.EP, note=END_OF_SPAN)
            return
        p = course.probed(p, current, previous)
        found = course.at(p, current, previous)
        if found is None:
            change = course.change(p, current, previous, restless)
            if change.last is None:
                step = abs(change.p - current.p)
                continue
            last, found = change.last, change.beyond
            met = course.meeting(current, last, previous)
            if isinstance(met, float):
                step = met
                continue
            if met is not None:
                yield met
                return
            if found is None:
                yield course.end(last, change.p)
                return
            step = FIRST_STEP
            course.track.take(found.edge)
            if found.words != last.words:
                yield JumpPoint(edge=last.whole, kind=PointKind.WC)
            restless = restless + 1 if last is current else 0
        met = course.meeting(current, found, previous)
        if isinstance(met, float):
            step = met
            continue
        end = met or course.ending(current, found, previous)
        if end is not None:
            yield end
            return
        yield JumpPoint(edge=found.whole)
        if abs(found.p - current.p) > settings.tolerances.edge:
            previous = current  # else their rounding would spoil the prediction
        elif found.words != current.words:
            kink = found  # the edge may turn here; what lies before says nothing
        if kink is not None and abs(found.p - kink.p) > settings.tolerances.edge:
            previous, kink = kink, None
        current = found
        speed = (current.x - previous.x) / (current.p - previous.p) if current is not first else 0.0
        step = min(1.5 * step, settings.max_step / math.hypot(1.0, speed))
    yield JumpPoint(edge=current.whole, kind=PointKind.EP, note="limit on the number of points")


def _begun(
    labelled_map: LabelledMap, start: Edge | Jump, settings: Settings, order: int
) -> tuple[_Course, Jump]:
    """How a jump is followed, and the jump itself with its orbits."""
    first = start if isinstance(start, Jump) else jump_of(labelled_map, start, order)
    if first is None:  # it is not one of P_1, as far as rounding can tell
        labelled_map, order = iterate(labelled_map, order), 1
        assert isinstance(start, Edge)
        first = _made(labelled_map, (), (), start, 1)
    return _Course(labelled_map, settings, first, order), first


# --- The orbits of a jump -------------------------------------------------------------------------


class _Place(NamedTuple):
    """A point of one of the orbits, how fast it moves with the parameter, and its word."""

    x: float
    speed: float
    word: str


@dataclass(frozen=True, slots=True, eq=False)
class Jump:
    """A jump of P_j at one parameter.

    Attributes
    ----------
    points, before
        The orbit that leads to an edge of P_1, and its laps.
    edge
        The edge of P_1.
    left, right
        The laps that follow from its limits.
    whole
        The same as an edge of P_j.
    """

    points: tuple[float, ...]
    before: tuple[Evaluation, ...]
    edge: Edge
    left: tuple[Evaluation, ...]
    right: tuple[Evaluation, ...]
    whole: Edge

    @property
    def p(self) -> float:
        """Parameter."""
        return self.edge.p

    @property
    def x(self) -> float:
        """Where P_j jumps."""
        return self.whole.x

    @property
    def words(self) -> tuple[str, ...]:
        """Of all laps, on both sides."""
        return (
            *(lap.word for lap in self.before), self.edge.left.word, self.edge.right.word,
            *(lap.word for lap in self.left), *(lap.word for lap in self.right),
        )  # fmt: skip

    def places(self, speed: float) -> list[_Place]:
        """The points whose words may change, if the edge moves with a speed."""
        found, back = [], speed
        for x, lap in zip(reversed(self.points), reversed(self.before), strict=True):
            back = (back - lap.rate) / lap.slope if lap.slope != 0.0 else 0.0
            found.append(_Place(x, back, lap.word))
        for side, limit, laps in (
            (self.edge.left, self.edge.left_limit, self.left),
            (self.edge.right, self.edge.right_limit, self.right),
        ):
            x, ahead = limit, side.slope * speed + side.rate
            for lap in laps:
                found.append(_Place(x, ahead, lap.word))
                x, ahead = lap.value, lap.slope * ahead + lap.rate
        return found


def _made(
    labelled_map: LabelledMap, points: Iterable[float], before: Iterable[Evaluation], edge: Edge,
    order: int,
) -> Jump:  # fmt: skip
    """A jump of P_order from the orbit that leads to an edge of P_1."""
    points, before = tuple(points), tuple(before)

    def beyond(side: Evaluation, limit: float) -> tuple[tuple[Evaluation, ...], Evaluation, float]:
        laps, value = [side], limit
        while len(before) + len(laps) < order and laps[-1].defined:
            laps.append(labelled_map(value, edge.p))
            value = laps[-1].value
        return tuple(laps[1:]), composed((*before, *laps)), value

    left, outer, outer_limit = beyond(edge.left, edge.left_limit)
    right, other, other_limit = beyond(edge.right, edge.right_limit)
    ends = (outer, outer_limit), (other, other_limit)
    if sum(lap.slope < 0.0 for lap in before) % 2:  # the orbit turns round
        ends = ends[1], ends[0]
    (first, low), (last, high) = ends
    x = points[0] if points else edge.x
    whole = Edge(x=x, p=edge.p, left=first, right=last, left_limit=low, right_limit=high)
    return Jump(points, before, edge, left, right, whole)


def jump_of(labelled_map: LabelledMap, edge: Edge, order: int) -> Jump | None:
    """The orbits of a jump of P_order; None if its words do not tell where P_1 jumps."""
    if order == 1:
        return _made(labelled_map, (), (), edge, 1)
    pairs = zip(edge.left.word.split(SEPARATOR), edge.right.word.split(SEPARATOR), strict=False)
    lap = next((k for k, (left, right) in enumerate(pairs) if left != right), 0)
    points = [edge.x]
    for _ in range(lap):
        points.append(labelled_map(points[-1], edge.p).value)
    word = labelled_map(points[lap], edge.p).word
    met = nearest_edge(labelled_map, points[lap], edge.p, word)
    if met is None or is_continuous(met[0]):
        return None
    jump = jump_through(labelled_map, met[0], points[:lap], order)
    if jump is None or jump.whole.crosses != edge.crosses:
        return None
    return jump if same_words(jump.whole, edge) and shift(jump.whole, edge) < SAME_LIMITS else None


def jump_through(
    labelled_map: LabelledMap, edge: Edge, points: Sequence[float], order: int
) -> Jump | None:
    """The jump of P_order whose orbit leads along some points, about, to an edge of P_1."""
    exact: list[float] = []
    before: list[Evaluation] = []
    target = edge.x
    for guess in reversed(points):
        found = _preimage(labelled_map, target, guess, edge.p, None)
        if found is None:
            return None
        target = found[0]
        exact.insert(0, target)
        before.insert(0, found[1])
    return _made(labelled_map, exact, before, edge, order)


def _preimage(
    labelled_map: LabelledMap, target: float, guess: float, p: float, word: str | None
) -> tuple[float, Evaluation] | None:
    """Where the map takes a value, by Newton's method on the piece of a word.

    Any word will do if none is given, but then not far from the guess.
    """
    x = guess
    for _ in range(NEWTON_STEPS):
        lap = labelled_map(x, p)
        if not lap.defined or word not in (None, lap.word) or lap.slope == 0.0:
            return None if word is None else _squeezed(labelled_map, target, guess, p, word)
        miss = target - lap.value
        x += miss / lap.slope
        if word is None and not abs(x - guess) <= SAME_ORBIT:
            return None
        if abs(miss / lap.slope) <= NEAR * math.ulp(x):
            return x, lap._replace(value=target)
    return None


def _squeezed(
    labelled_map: LabelledMap, target: float, guess: float, p: float, word: str
) -> tuple[float, Evaluation] | None:
    """The same where Newton's method oversteps, right beside a square root or a dip: by halving.

    There the map is nearly upright: of two neighbouring doubles one is too low, one too high.
    """

    def lies(x: float) -> int:
        """Side of the target on which the piece takes x; 0 off the piece."""
        lap = labelled_map(x, p)
        return 0 if lap.word != word else (1 if lap.value >= target else -1)

    first, reach = lies(guess), NEAR * math.ulp(guess)
    other = math.nan
    while math.isnan(other) and reach < SAME_ORBIT:
        pair = guess - reach, guess + reach
        other = next((x for x in pair if lies(x) != first), math.nan)
        reach *= 4.0
    if math.isnan(other):
        return None
    inside, outside = (guess, other) if first else (other, guess)
    side = lies(inside)
    while True:  # between a point off the piece, or beyond the target, and one on it
        middle = 0.5 * (inside + outside)
        if middle in (inside, outside):
            break
        if lies(middle) == side:
            inside = middle
        else:
            outside = middle
    lap = labelled_map(inside, p)
    if lies(outside) != -side and abs(lap.value - target) > ROOT:
        return None  # the piece ends before it takes the value
    return inside, lap._replace(value=target)


# --- Following them -------------------------------------------------------------------------------


def _distance(jump: Jump, side: int) -> float:
    """Signed distance of a one-sided limit from the diagonal."""
    return (jump.whole.left_limit if side < 0 else jump.whole.right_limit) - jump.x


def _opposite(a: float, b: float) -> bool:
    """Whether two numbers lie on different sides of zero, or on it."""
    return a <= 0.0 <= b or b <= 0.0 <= a


def _collided(a: Jump, b: Jump) -> int:
    """Side whose limit passes the diagonal between two points of a branch; 0 if none does."""
    for side in (-1, 1):
        if a is not b and _opposite(_distance(a, side), _distance(b, side)):
            return side
    return 0


class _Change(NamedTuple):
    """A change of words: the last jump before it, the first beyond it if any, and where that is.

    Without a last jump: nothing but where to look first.
    """

    last: Jump | None
    beyond: Jump | None
    p: float


class _Course:
    """Finds the same jump again at another parameter: same words in all laps."""

    def __init__(
        self, labelled_map: LabelledMap, settings: Settings, start: Jump, order: int
    ) -> None:
        self.map, self.settings, self.order = labelled_map, settings, order
        self.track = Track(labelled_map, settings, start.edge)
        self.stride = RESOLVED  # how far beyond a change of words the next jump is looked for

    def at(self, p: float, near: Jump, before: Jump) -> Jump | None:
        """The jump at p, from two known ones; None if its words are not found."""
        edge = self.track.at(p, near.edge, before.edge)
        found = None if edge is None else self._around(edge, near, before)
        return found if found is not None and found.words == near.words else None

    def _around(self, edge: Edge, near: Jump, before: Jump, same: bool = True) -> Jump | None:
        """The jump whose orbit leads to an edge of P_1 as another does, with its words or any."""
        points: list[float] = []
        laps: list[Evaluation] = []
        target = edge.x
        places = near.places(_speed(near, before))
        for place, lap in zip(places, reversed(near.before), strict=False):
            guess = place.x + place.speed * (edge.p - near.p)
            found = _preimage(self.map, target, guess, edge.p, place.word if same else None)
            if found is None or found[1].slope * lap.slope <= 0.0:  # beyond a fold
                return None
            target = found[0]
            points.insert(0, target)
            laps.insert(0, found[1])
        return _made(self.map, points, laps, edge, self.order)

    def probed(self, p: float, near: Jump, before: Jump) -> float:
        """p, or the first probe on the way to it at which words differ."""
        parts = math.ceil(abs(p - near.p) / self.settings.probe)
        places = near.places(_speed(near, before))
        for k in range(1, parts):
            middle = near.p + (p - near.p) * k / parts
            if not self.track.sees(middle, near.edge, before.edge) or self._changed(
                middle, near.p, places
            ):
                return middle
        return p

    def change(self, p: float, near: Jump, before: Jump, restless: int) -> _Change:
        """Why the jump is not found at p: a change of words, or where to look first.

        Where two words flicker, because rounding decides between them, each change in a row is
        passed by a longer stride.
        """
        self.stride = min(RESOLVED * 8.0 ** max(0, restless - CALM), self.settings.probe)
        direction = math.copysign(1.0, p - near.p)
        ahead = change_ahead(
            lambda reach, some: self._changed(near.p + direction * reach, near.p, some),
            near.places(_speed(near, before)), abs(p - near.p), ROUGHLY, 0.25 * RESOLVED,
        )  # fmt: skip
        if ahead is not None:
            return self._nearer(near.p + (1.0 - ROUGHLY) * direction * ahead[0], near, before)
        if self.track.at(p, near.edge, before.edge) is not None:
            return self._nearer(near.p + 0.25 * (p - near.p), near, before)
        known, beyond, p = self.track.word_change(near.edge, before.edge, p)
        last = self._around(known, near, before)
        if last is None or last.words != near.words:  # a lap changes its word first
            return self._nearer(near.p + (1.0 - ROUGHLY) * (known.p - near.p), near, before)
        found = None if beyond is None else self._around(beyond, last, before, same=False)
        return _Change(last, found if found and self._goes_on(found, last) else None, p)

    def _nearer(self, p: float, near: Jump, before: Jump) -> _Change:
        """Look at p first, unless that is right beside the known jump already."""
        if abs(p - near.p) > RESOLVED:
            return _Change(None, None, p)
        found: Jump | None = None
        reach = math.copysign(4.0 * self.stride, p - near.p)
        furthest = max(self.settings.tolerances.edge, abs(reach))
        while abs(reach) <= furthest:
            p = near.p + reach
            edge = self.track.at(p, near.edge, before.edge)
            jump = None if edge is None else self._around(edge, near, before, same=False)
            if jump is not None and self._goes_on(jump, near):
                found = jump
                if jump.words != near.words:
                    break  # as long as they are the same, what comes between is too thin to see
            reach *= 8.0
        return _Change(near, found, p)

    def _changed(self, p: float, known: float, places: Sequence[_Place]) -> list[_Place]:
        """The points that have another word at p."""
        return [
            place
            for place in places
            if self.map(place.x + place.speed * (p - known), p).word != place.word
        ]

    def _goes_on(self, jump: Jump, last: Jump) -> bool:
        low, high = self.settings.span
        same = shift(jump.whole, last.whole) < SAME_LIMITS
        return same and jump.whole.crosses and low <= jump.p <= high

    def end(self, last: Jump, p: float) -> JumpPoint:
        """Why there is no jump with other words beyond the last one seen."""
        for side in (-1, 1):
            if abs(_distance(last, side)) <= CLOSED:  # its piece closes as it meets the diagonal
                return JumpPoint(edge=last.whole, kind=PointKind.BC, side=side)
        whole = iterate(self.map, self.order)
        for side in (-1, 1):
            beside = whole(last.x + side * 100.0 * abs(p - last.p), p)
            if not beside.defined or beside.word == BELOW:
                return JumpPoint(edge=last.whole, kind=PointKind.FALL, note=beside.word)
        return JumpPoint(edge=last.whole, kind=PointKind.EP, note=JUMP_ENDS)

    def ending(self, a: Jump, b: Jump, before: Jump) -> JumpPoint | None:
        """The end of the branch at b, if it ends there for another reason than a collision."""
        low, high = self.settings.window
        whole = b.whole
        if math.isnan(whole.jump):
            lost = whole.left if math.isnan(whole.left_limit) else whole.right
            return JumpPoint(edge=whole, kind=PointKind.FALL, note=lost.word)
        if is_continuous(whole, self.settings.tolerances):
            return JumpPoint(edge=whole, kind=PointKind.EP, note="the jump closes")
        if not low <= b.x <= high:
            bound = low if b.x < low else high
            edge = self.locate(a, b, before, lambda jump: jump.x - bound).whole
            return JumpPoint(edge=edge, kind=PointKind.EP, note="end of the window")
        if b.p in self.settings.span:
            return JumpPoint(edge=whole, kind=PointKind.EP, note=END_OF_SPAN)
        return None

    def meeting(self, a: Jump, b: Jump, before: Jump) -> JumpPoint | float | None:
        """Where a limit meets the diagonal between two points of the branch, if one does.

        If it does so among other words that lie between them: how far to go first.
        """
        side = _collided(a, b)
        if side == 0:
            return None
        met = self.locate(a, b, before, lambda jump: _distance(jump, side))
        tolerances = self.settings.tolerances
        if abs(_distance(met, side)) > tolerances.jump and abs(b.p - a.p) > tolerances.edge:
            return 0.25 * abs(b.p - a.p)
        return JumpPoint(edge=met.whole, kind=PointKind.BC, side=side)

    def locate(self, a: Jump, b: Jump, before: Jump, measure: Callable[[Jump], float]) -> Jump:
        """Where a measure of the jump changes its sign between two points of the branch."""
        found: dict[float, Jump] = {a.p: a, b.p: b}

        def at(p: float) -> float:
            if p not in found:
                jump = self.at(p, a, before) or self.at(p, b, b)
                if jump is None:  # other words in between: the nearer of the known points decides
                    jump = min(a, b, key=lambda known: abs(known.p - p))
                found[p] = jump
            return measure(found[p])

        if a.p == b.p or not _opposite(measure(a), measure(b)):
            return b
        p = float(brentq(at, a.p, b.p, xtol=1e-15, rtol=1e-14))
        at(p)
        return found[p]


def _speed(near: Jump, before: Jump) -> float:
    """How fast the edge of P_1 moves with the parameter."""
    if near.p == before.p:
        return 0.0
    return (near.edge.x - before.edge.x) / (near.p - before.p)
