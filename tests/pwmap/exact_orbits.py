"""Random maps of the line with flat, neutral and isolated pieces, and what their orbits do.

Nothing here knows the package: pieces are tried one after the other, orbits are of fractions.
"""

import random
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction

SLOPES = [Fraction(*each) for each in (
    (0, 1), (0, 1), (1, 1), (1, 1), (-1, 1), (-1, 1), (1, 2), (-1, 2), (2, 1), (-2, 1), (3, 2),
    (-3, 2), (1, 3), (-2, 3), (3, 1), (-3, 1), (5, 4), (-5, 4),
)]  # fmt: skip
LONGEST = 4000  # bits of a number: an orbit is not followed farther


class Border(Enum):
    """To which side a break belongs, or to neither."""

    LEFT = "<="
    RIGHT = "<"
    OWN = "a point for itself"


@dataclass(frozen=True)
class RandomMap:
    """Slopes and intercepts from left to right, breaks, and the value at each."""

    pieces: tuple[tuple[Fraction, Fraction], ...]
    breaks: tuple[Fraction, ...]
    borders: tuple[Border, ...]
    values: tuple[Fraction, ...]

    def __call__(self, x: Fraction) -> Fraction:
        for k, cut in enumerate(self.breaks):
            if x == cut:
                return self.values[k]
            if x < cut:
                return self.piece(k, x)
        return self.piece(len(self.breaks), x)

    def piece(self, k: int, x: Fraction) -> Fraction:
        slope, intercept = self.pieces[k]
        return slope * x + intercept

    def number(self, x: Fraction) -> int:
        """Of the piece in which a point lies that is no break."""
        return sum(cut < x for cut in self.breaks)

    @property
    def text(self) -> str:
        """What sympy reads."""
        parts = []
        for k, cut in enumerate(self.breaks):
            slope, intercept = self.pieces[k]
            sign = "<=" if self.borders[k] is Border.LEFT else "<"
            parts.append(f"(({slope})*x + {intercept}, x {sign} {cut})")
            if self.borders[k] is Border.OWN:
                parts.append(f"({self.values[k]}, x <= {cut})")
        slope, intercept = self.pieces[-1]
        return f"Piecewise({', '.join([*parts, f'(({slope})*x + {intercept}, True)'])})"


def random_map(rng: random.Random) -> RandomMap:
    """One to five pieces; half of the inner pieces go on where the last one ended, others jump."""
    breaks = tuple(sorted({Fraction(rng.randint(-12, 12), rng.choice((1, 2, 3, 4)))
                           for _ in range(rng.randint(0, 4))}))  # fmt: skip
    pieces = list[tuple[Fraction, Fraction]]()
    for k in range(len(breaks) + 1):
        slope, intercept = rng.choice(SLOPES), Fraction(rng.randint(-12, 12), rng.choice((1, 2, 3)))
        if pieces and rng.random() < 0.5:
            last, x = pieces[-1], breaks[k - 1]
            intercept = (last[0] - slope) * x + last[1]
        pieces.append((slope, intercept))
    borders = tuple(rng.choice((Border.LEFT, Border.RIGHT, Border.LEFT, Border.RIGHT, Border.OWN))
                    for _ in breaks)  # fmt: skip
    values = []
    for k, (x, border) in enumerate(zip(breaks, borders, strict=True)):
        slope, intercept = pieces[k if border is Border.LEFT else k + 1]
        own = Fraction(rng.randint(-6, 6), rng.choice((1, 2)))
        values.append(own if border is Border.OWN else slope * x + intercept)
    return RandomMap(tuple(pieces), breaks, borders, tuple(values))


class End(Enum):
    """What becomes of an orbit."""

    CYCLE = "it comes back to a point of itself"
    DRAWN = "it follows a cycle that draws it in"
    LOST = "it moves outward on outer pieces"
    OPEN = "none of these so far"


@dataclass(frozen=True)
class Course:
    """An orbit: all points as far as it was followed, and the cycle that it ends in or comes to."""

    points: tuple[Fraction, ...]
    end: End
    cycle: tuple[Fraction, ...] = ()
    multiplier: Fraction = Fraction(0)  # of the cycle, if none of its points is a break


def course(map_: RandomMap, x: Fraction, steps: int) -> Course:
    """Follow an orbit until its end is known."""
    points, seen = list[Fraction](), dict[Fraction, int]()
    for n in range(steps):
        if x in seen:
            cycle = tuple(points[seen[x] :])
            return Course(tuple(points), End.CYCLE, cycle, multiplier(map_, cycle))
        if x.denominator.bit_length() > LONGEST:
            break
        seen[x] = n
        points.append(x)
        if n % 16 == 15:
            if is_lost(map_, points[-3:]):
                return Course(tuple(points), End.LOST)
            cycle = drawn_to(map_, points)
            if cycle:
                return Course(tuple(points), End.DRAWN, cycle, multiplier(map_, cycle))
        x = map_(x)
    return Course(tuple(points), End.OPEN)


def multiplier(map_: RandomMap, cycle: tuple[Fraction, ...]) -> Fraction:
    found = Fraction(1)
    for x in cycle:
        found *= map_.pieces[map_.number(x)][0]
    return found


def drawn_to(map_: RandomMap, points: list[Fraction]) -> tuple[Fraction, ...]:
    """The cycle of the last letters, if the last point lies where all points follow it inward."""
    letters = [map_.number(x) for x in points]
    for period in range(1, len(points) // 2):
        if letters[-period:] != letters[-2 * period : -period]:
            continue
        slope, intercept = Fraction(1), Fraction(0)
        for k in letters[-period:]:
            a, b = map_.pieces[k]
            slope, intercept = a * slope, a * intercept + b
        if abs(slope) >= 1:
            continue
        start = x = intercept / (1 - slope)
        cycle, scale, room = list[Fraction](), Fraction(1), list[Fraction]()
        for k in letters[-period:]:
            if map_.number(x) != k or x in map_.breaks:
                break
            cycle.append(x)
            room += [abs(x - cut) - scale * abs(start - points[-period]) for cut in map_.breaks]
            scale *= abs(map_.pieces[k][0])
            x = map_(x)
        if len(cycle) == period and x == start and all(each > 0 for each in room):
            first = cycle.index(min(cycle))
            once = len(set(cycle))
            return tuple((cycle[first:] + cycle[:first])[:once])
    return ()


def is_lost(map_: RandomMap, last: list[Fraction]) -> bool:
    """Whether three points are outside of all breaks, and each outer piece takes more away.

    With rising pieces two points do; with falling ones every second point is farther out, beyond a
    place that two steps of both pieces take farther out, too.
    """
    if not map_.breaks:
        slope, intercept = map_.pieces[0]
        return abs(slope) > 1 or (slope == 1 and intercept != 0)
    x, y, z = last
    low, high = map_.breaks[0], map_.breaks[-1]
    left, right = map_.pieces[0][0], map_.pieces[-1][0]
    if max(x, y, z) < low and left >= 1:
        return z < y < x
    if min(x, y, z) > high and right >= 1:
        return z > y > x
    if left < 0 and right < 0 and left * right >= 1:
        return (x < low and y > high and z < x) or (x > high and y < low and z > x)
    return False
