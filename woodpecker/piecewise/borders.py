"""Edges between two pieces of a labelled map at fixed parameter: location and one-sided limits."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

from woodpecker.piecewise.maps import Cycle, Evaluation, LabelledMap, composed
from woodpecker.piecewise.tolerances import DEFAULT, Tolerances

T = TypeVar("T")

ROUGHLY = 1.0 / 64.0  # how well a change of word ahead is located while a branch comes near it
NEAR = 64  # spacings of doubles between an edge and the first point a limit is read from
WIDENINGS = 4  # times that this distance is made four times larger where words still flicker, since
# rounding decides between them: a border has been seen to flicker over some hundred spacings
MOST = 50  # edges looked for in one interval
STRAIGHT = 0.25  # of a rise that the slope may miss: a square root misses half of it
WIDEST = 0.02  # largest distance [rad] at which the next edge is looked for


@dataclass(frozen=True, slots=True, kw_only=True)
class Edge:
    """The end of a piece, and both sides of it.

    ``left`` and ``right`` are read some spacings of doubles away, where each side shows one word:
    on the edge itself rounding can make two events simultaneous, and show a word that has no
    interval, or that of the other side.
    """

    x: float
    p: float
    left: Evaluation
    right: Evaluation
    left_limit: float
    right_limit: float

    @property
    def jump(self) -> float:
        """Right limit - left limit; nan if the map is lost on one side."""
        return self.right_limit - self.left_limit

    @property
    def crosses(self) -> bool:
        """Whether the limits lie strictly on opposite sides of the diagonal."""
        return (self.left_limit - self.x) * (self.right_limit - self.x) < 0.0


def bisect(
    labelled_map: LabelledMap, p: float, inside: float, outside: float
) -> tuple[float, float]:
    """Neighbouring doubles around the edge of the piece that holds ``inside``, not ``outside``."""
    word = labelled_map(inside, p).word
    while True:
        middle = 0.5 * (inside + outside)
        if middle in (inside, outside):
            return inside, outside
        if labelled_map(middle, p).word == word:
            inside = middle
        else:
            outside = middle


def change_ahead(
    changed: Callable[[float, Sequence[T]], list[T]],
    watched: Sequence[T],
    reach: float,
    fine: float,
    smallest: float,
) -> tuple[float, T] | None:
    """How far a way keeps its words, and what of ``watched`` changes its word there first.

    ``changed`` says which of some have another word at a distance. The change is located to a part
    ``fine`` of its distance, or to ``smallest``; None if nothing has changed at ``reach``.
    """
    changing = changed(reach, watched)
    if not changing:
        return None
    clear, beyond = 0.0, reach
    while beyond - clear > max(fine * beyond, smallest):
        middle = 0.5 * (clear + beyond)
        found = changed(middle, changing)
        if found:
            beyond, changing = middle, found
        else:
            clear = middle
    return clear, changing[0]


def limit_of(first: Evaluation, second: Evaluation, distance: float) -> float:
    """One-sided limit at an edge, from the map at a signed distance and at four times that.

    A smooth side is continued with its exact slope. Where the slope does not tell the way to the
    second point, f = L + c sqrt(|x - x_e|) is extrapolated, the square root of a grazing.
    """
    if not first.defined:
        return math.nan
    if not second.defined or second.word != first.word:
        return first.value
    rise, straight = second.value - first.value, 3.0 * distance * first.slope
    if abs(rise - straight) <= STRAIGHT * abs(rise):
        return first.value - distance * first.slope
    return first.value - rise


def edge_between(
    labelled_map: LabelledMap, p: float, inside: float, outside: float, near: float = 0.0
) -> Edge:
    """The edge of the piece at ``inside`` on the way to ``outside``, with both limits.

    They are read at a distance of at least ``near`` from it.
    """
    x, beyond = bisect(labelled_map, p, inside, outside)
    word = labelled_map(inside, p).word
    return _read(labelled_map, p, x, beyond, max(near, NEAR * math.ulp(x)), word)


def _read(
    labelled_map: LabelledMap, p: float, x: float, beyond: float, near: float, word: str
) -> Edge:
    """The edge between neighbouring doubles, its limits read from ``near`` or further away.

    There each side shows one word, that of x the one given.
    """
    nearest: Edge | None = None
    for _ in range(1 + WIDENINGS):
        left, right = (
            (labelled_map(end + reach, p), labelled_map(end + 4.0 * reach, p))
            for end, reach in ((min(x, beyond), -near), (max(x, beyond), near))
        )
        edge = Edge(
            x=x, p=p, left=left[0], right=right[0],
            left_limit=limit_of(*left, -near), right_limit=limit_of(*right, near),
        )  # fmt: skip
        words = {left[0].word, left[1].word}, {right[0].word, right[1].word}
        inner, outer = words if x < beyond else words[::-1]
        if inner == {word} and len(outer) == 1 and inner != outer:
            return edge
        nearest = nearest or edge
        near *= 4.0
    assert nearest is not None
    return nearest


def edge_at(labelled_map: LabelledMap, x: float, p: float, widest: float) -> Edge:
    """The edge nearest to a place where one is known to be, up to rounding."""
    half = 4.0 * NEAR * math.ulp(x)
    while half < widest and labelled_map(x - half, p).word == labelled_map(x + half, p).word:
        half *= 4.0
    return edge_between(labelled_map, p, x - half, x + half)


def nearest_edge(
    labelled_map: LabelledMap, x: float, p: float, word: str
) -> tuple[Edge, int] | None:
    """The edge nearest to x of the piece ``word`` that x lies in, and its side (-1 or +1).

    Near an edge rounding mixes the words of its two sides, and the steeper the map the further. The
    words at growing distances on both sides of x tell where the piece really is, once two distances
    agree. Limits are read right next to the edge if it shows two words there.
    """
    distance = NEAR * math.ulp(x)
    while distance < WIDEST:
        left, right = (
            [labelled_map(x + side * reach, p).word == word for reach in (distance, 4.0 * distance)]
            for side in (-1, 1)
        )
        if (all(left) and not any(right)) or (all(right) and not any(left)):
            side = 1 if all(left) else -1
            inside, outside = x - side * distance, x + side * distance
            edge = edge_between(labelled_map, p, inside, outside)
            facing = edge.left.word if side > 0 else edge.right.word
            if facing != word or edge.left.word == edge.right.word:
                edge = edge_between(labelled_map, p, inside, outside, distance)
            return edge, side
        if not any(left) and not any(right):  # a thin piece: both its ends are near
            ends = [
                (edge_between(labelled_map, p, x, x + side * distance), side) for side in (-1, 1)
            ]
            return min(ends, key=lambda end: abs(end[0].x - x))
        distance *= 4.0
    return None


def edge_of_iterate(
    labelled_map: LabelledMap, cycle: Cycle, lap: int, edge: Edge, side: int, first: int
) -> tuple[Edge, int]:
    """The edge of P_j next to a point of a cycle one lap of which has met an edge of P_1.

    Parameters
    ----------
    lap, edge, side
        Which lap, and the edge, on this side (-1 or +1) of its point.
    first
        The point from which P_j starts.

    Returns
    -------
    tuple
        The edge of P_j, and on which side of the point it lies. One limit is the point itself.
    """
    j, x = len(cycle.x), float(cycle.x[first])
    before = [cycle.laps[(first + k) % j] for k in range((lap - first) % j)]
    laps = [*before, edge.right if side > 0 else edge.left]
    limit = edge.right_limit if side > 0 else edge.left_limit
    while len(laps) < j and laps[-1].defined:
        laps.append(labelled_map(limit, cycle.p))
        limit = laps[-1].value
    inside = composed(cycle.laps[(first + k) % j] for k in range(j))._replace(value=x)
    outside = composed(laps)._replace(value=limit)
    turns = sum(each.slope < 0.0 for each in before)
    turned = -side if turns % 2 else side
    left, right = (inside, outside) if turned > 0 else (outside, inside)
    met = Edge(
        x=x, p=cycle.p, left=left, right=right, left_limit=left.value, right_limit=right.value
    )
    return met, turned


def edges_between(labelled_map: LabelledMap, p: float, low: float, high: float) -> list[Edge]:
    """Edges met on the way from low to high, at most MOST; thinner pieces than NEAR are skipped."""
    found: list[Edge] = []
    while len(found) < MOST and labelled_map(low, p).word != labelled_map(high, p).word:
        edge = edge_between(labelled_map, p, low, high)
        if edge.left.word != edge.right.word:
            found.append(edge)
        low = edge.x + 2.0 * NEAR * math.ulp(edge.x)
    return found


def is_continuous(edge: Edge, tolerances: Tolerances = DEFAULT) -> bool:
    """Whether the map takes one value at the edge: a change of word, not a jump."""
    return abs(edge.jump) <= tolerances.jump
