"""Iterates of a piecewise-linear map as cylinders, with their fixed points and jump crossings.

The *cylinder* of a word is the set of points whose orbits visit the pieces that the word names.
Each A_w is monotone, so cylinders of length n are intervals that partition the line: the pieces of
the n-th iterate. Their ends are cuts (preimages of breaks along prefixes of the word), not numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import lru_cache, partial
from itertools import pairwise
from typing import Any, NamedTuple

from pwmap.algebra.assumptions import UndecidedError
from pwmap.maps.budget import BudgetError, Meter
from pwmap.maps.words import CriticalOrbit, Offset, SignOracle, Word


class Cut(NamedTuple):
    """The point x with A_u(x) = b_k, where u is the word's prefix of length ``steps``."""

    k: int
    steps: int


class Cylinder(NamedTuple):
    """The interval of all points with one word; an end that is None is infinite."""

    word: Word
    lower: Cut | None = None
    upper: Cut | None = None
    lower_closed: bool = False
    upper_closed: bool = False

    @property
    def is_point(self) -> bool:
        """Whether it is a single point."""
        return self.lower is not None and self.lower == self.upper and self.lower_closed


Ask = Callable[..., Any]  # see SignOracle.ask
PIECE = 80  # units of work to find a piece and to use it later
WHOLE_LINE: tuple[Cylinder, ...] = (Cylinder(()),)


def refined(
    cylinders: Sequence[Cylinder],
    layout: int,
    oracle: SignOracle,
    meter: Meter,
    ask: Ask,
) -> tuple[Cylinder, ...]:
    """The cylinders of P o Q from those of Q, P having ``layout``; BudgetError if too many."""
    pieces = list[Cylinder]()
    for cylinder in cylinders:
        meter.spend(PIECE + oracle.orbits.work(len(cylinder.word)))
        pieces += ask(split, cylinder, layout)
        if len(pieces) > meter.budget.pieces:
            raise BudgetError(
                f"an iterate with words of {len(cylinder.word) + 1} letters has more than "
                f"{meter.budget.pieces} pieces; one letter less makes {len(cylinders)}"
            )
    return tuple(pieces)


def cylinder_of(word: Word, layouts: Sequence[int], oracle: SignOracle) -> Cylinder | None:
    """The cylinder of one word, or None where it is empty."""
    found = WHOLE_LINE
    for letter, layout in zip(word, layouts, strict=True):
        longer = (part for each in found for part in split(each, layout, oracle))
        found = tuple(part for part in longer if part.word[-1] == letter)
    return found[0] if found else None


def split(cylinder: Cylinder, layout: int, oracle: SignOracle) -> tuple[Cylinder, ...]:
    """Split a cylinder into those of words one letter longer, from left to right."""
    word = cylinder.word
    direction = oracle.slope(word)
    slots = oracle.orbits.table.layouts[layout].slots
    if cylinder.is_point or direction == 0:
        slot = oracle.slot(layout, *_constant_value(cylinder, oracle))
        return (cylinder._replace(word=(*word, slots[slot])),)
    breaks = oracle.orbits.table.layouts[layout].breaks
    first, last = (0, len(slots) - 1)[::direction]

    def atoms() -> Iterator[tuple[int, Cut | None, Cut | None, bool]]:
        """Letter, ends and closedness of the preimage of each slot, from left to right."""
        start, stop = first, last
        if cylinder.lower is not None:
            start = oracle.slot(layout, cylinder.lower.k, word[cylinder.lower.steps :])
            if cylinder.lower_closed:
                yield slots[start], cylinder.lower, cylinder.lower, True
            start += direction * (start % 2)
        if cylinder.upper is not None:
            stop = oracle.slot(layout, cylinder.upper.k, word[cylinder.upper.steps :])
        inner_stop = stop - direction * (stop % 2)
        left = cylinder.lower
        for slot in range(start, inner_stop, 2 * direction):
            right = Cut(breaks[(slot + direction) // 2], len(word))
            yield slots[slot], left, right, False
            yield slots[slot + direction], right, right, True
            left = right
        yield slots[inner_stop], left, cylinder.upper, False
        if cylinder.upper_closed:
            yield slots[stop], cylinder.upper, cylinder.upper, True

    found = list[Cylinder]()
    for letter, left, right, closed in atoms():
        if found and found[-1].word[-1] == letter:
            found[-1] = found[-1]._replace(upper=right, upper_closed=closed)
        else:
            found.append(Cylinder((*word, letter), left, right, closed, closed))
    return tuple(found)


def _constant_value(cylinder: Cylinder, oracle: SignOracle) -> tuple[int, Word]:
    """The break and the word whose critical orbit is the constant value on a cylinder."""
    if cylinder.lower is not None and cylinder.is_point:
        return cylinder.lower.k, cylinder.word[cylinder.lower.steps :]
    # a letter of slope 0 sends every break to one value: take break 0
    flat = max(i for i, letter in enumerate(cylinder.word) if oracle.slope((letter,)) == 0)
    return 0, cylinder.word[flat:]


# --- The diagonal ---------------------------------------------------------------------------------


def above_diagonal(oracle: SignOracle, word: Word, cut: Cut) -> int:
    """Sign of A_word(x) - x at a cut x of the word."""
    prefix, rest = word[: cut.steps], word[cut.steps :]
    # w = uv and A_u(x) = b_k: slope(u) (A_w(x) - x) = A_u(A_w(x)) - A_u(x) = A_{vu}(b_k) - b_k
    return oracle.slope(prefix) * oracle.sign(CriticalOrbit(cut.k, rest + prefix, cut.k))


Sides = tuple[int, int]


def sides_of(cylinder: Cylinder, oracle: SignOracle) -> Sides:
    """Signs of A_word(x) - x at both ends of a cylinder; 0 at an infinite end."""
    word, (lower, upper) = cylinder.word, cylinder[1:3]
    first = 0 if lower is None else above_diagonal(oracle, word, lower)
    if upper == lower:
        return first, first
    return first, 0 if upper is None else above_diagonal(oracle, word, upper)


class Inclusion(Enum):
    """Whether the fixed point of a word's affine map lies in its cylinder, and where."""

    INSIDE = "inside its cylinder"
    LOWER = "at the lower end, which belongs to its cylinder"
    UPPER = "at the upper end, which belongs to its cylinder"
    POINT = "its cylinder is this point alone"
    BAND = "every point of the cylinder is fixed"
    VIRTUAL = "outside its cylinder, or there is none"


class CylinderCrossing(NamedTuple):
    """A cut at which the iterate jumps over the diagonal, and the words on both sides."""

    cut: Cut
    left: Word
    right: Word


@dataclass(frozen=True, slots=True)
class StudiedIterate:
    """One iterate at a place: its cylinders, fixed points and jump crossings."""

    cylinders: tuple[Cylinder, ...]
    inclusion: tuple[Inclusion, ...]  # of the fixed point of each cylinder
    stable: tuple[bool, ...]  # whether it attracts
    crossings: tuple[CylinderCrossing, ...]


def iterate_of(cylinders: tuple[Cylinder, ...], ask: Ask) -> StudiedIterate:
    """Cylinders, fixed points and crossings of an iterate."""
    sides = [None if each.is_point else ask(sides_of, each) for each in cylinders]
    inclusion = tuple(map(partial(ask, inclusion_of), cylinders, sides))
    beside = (words_beside(cylinders, i, each) for i, each in enumerate(inclusion))
    stable = tuple(bool(words) and ask(is_stable, cut, words) for cut, words in beside)
    return StudiedIterate(cylinders, inclusion, stable, tuple(crossings(cylinders, sides)))


def inclusion_of(cylinder: Cylinder, known: Sides | None, oracle: SignOracle) -> Inclusion:
    """Whether the fixed point of a cylinder's affine map lies in it, and where."""
    word = cylinder.word
    steepness = oracle.multiplier(word, 1)
    if steepness == 0:
        if oracle.sign(Offset(word)) != 0:
            return Inclusion.VIRTUAL
        return Inclusion.POINT if cylinder.is_point else Inclusion.BAND
    # A_w(x) - x = (m - 1) (x - x*): these are the signs of x* - end
    sides = [-steepness * side for side in known or sides_of(cylinder, oracle)]
    if cylinder.is_point:
        return Inclusion.POINT if sides[0] == 0 else Inclusion.VIRTUAL
    if cylinder.lower is not None and sides[0] <= 0:
        return Inclusion.LOWER if sides[0] == 0 and cylinder.lower_closed else Inclusion.VIRTUAL
    if cylinder.upper is not None and sides[1] >= 0:
        return Inclusion.UPPER if sides[1] == 0 and cylinder.upper_closed else Inclusion.VIRTUAL
    return Inclusion.INSIDE


def crossings(
    cylinders: Sequence[Cylinder], sides: Iterable[Sides | None]
) -> Iterator[CylinderCrossing]:
    """Cuts with limits strictly on different sides of the diagonal, from left to right."""
    pairs = zip(cylinders, sides, strict=True)
    intervals = [(each, signs) for each, signs in pairs if signs is not None]
    for (left, (_, before)), (right, (after, _)) in pairwise(intervals):
        if before * after < 0:
            assert right.lower is not None
            yield CylinderCrossing(right.lower, left.word, right.word)


@lru_cache(maxsize=65536)  # the same words occur in many cells
def minimal_period(word: Word, unit: int = 1) -> int:
    """The length, in units, of the shortest word of which this one is a power."""
    n = len(word)
    lengths = (d for d in range(unit, n + 1, unit) if n % d == 0)
    return next(d for d in lengths if word[:d] * (n // d) == word) // unit


def words_beside(
    cylinders: Sequence[Cylinder], i: int, inclusion: Inclusion
) -> tuple[Cut | None, tuple[Word, ...]]:
    """The cut at which a fixed point lies, None inside a piece, and the words beside it."""
    cylinder = cylinders[i]
    match inclusion:
        case Inclusion.INSIDE:
            return None, (cylinder.word,)
        case Inclusion.LOWER:
            return cylinder.lower, (cylinders[i - 1].word, cylinder.word)
        case Inclusion.UPPER:
            return cylinder.upper, (cylinder.word, cylinders[i + 1].word)
        case Inclusion.POINT:
            return cylinder.lower, (cylinders[i - 1].word, cylinders[i + 1].word)
    return None, ()


def is_stable(cut: Cut | None, words: tuple[Word, ...], oracle: SignOracle) -> bool | None:
    """Whether a fixed point attracts from both sides; None if the assumptions leave it open."""
    if not words:
        return False
    # at a border it attracts if the map is continuous there, with slopes m < 1, n < 1 and m n < 1:
    # orbits stay on a side of positive slope, and change sides at each step if both are negative
    conditions = [(partial(above_diagonal, oracle, word, cut), 0) for word in words if cut]
    slopes = words if cut is None else (*words, words[0] + words[1])
    conditions += [(partial(oracle.multiplier, word, 1), -1) for word in slopes]
    if cut is None:
        conditions.append((partial(oracle.multiplier, words[0], -1), 1))
    is_open = False
    for sign, wanted in conditions:
        try:
            if sign() != wanted:
                return False
        except UndecidedError:
            is_open = True
    return None if is_open else True
