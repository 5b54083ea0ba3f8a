"""Random maps of the line with flat, neutral and isolated pieces, and what their orbits do.

Nothing here knows the package: the maps are those of ``brute``, orbits are of fractions.
"""

import random
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from math import prod

from brute import map_of
from independent import Parts, part_at

SLOPES = [Fraction(*each) for each in (
    (0, 1), (0, 1), (1, 1), (1, 1), (-1, 1), (-1, 1), (1, 2), (-1, 2), (2, 1), (-2, 1), (3, 2),
    (-3, 2), (1, 3), (-2, 3), (3, 1), (-3, 1), (5, 4), (-5, 4),
)]  # fmt: skip
LONGEST = 4000  # bits of a number: an orbit is not followed farther


def random_map(rng: random.Random) -> Parts:
    """One to five intervals; half of them go on where the last one ended, others jump."""
    breaks = sorted({Fraction(rng.randint(-12, 12), rng.choice((1, 2, 3, 4)))
                     for _ in range(rng.randint(0, 4))})  # fmt: skip
    owners = [rng.choice(("left", "right", "left", "right", "point")) for _ in breaks]
    formulas = list[tuple[Fraction, Fraction]]()
    for k in range(len(breaks) + 1):
        slope, intercept = rng.choice(SLOPES), Fraction(rng.randint(-12, 12), rng.choice((1, 2, 3)))
        if k and rng.random() < 0.5:
            last, x = formulas[-1], breaks[k - 1]
            intercept = (last[0] - slope) * x + last[1]
        if k and owners[k - 1] == "point":
            own = Fraction(rng.randint(-6, 6), rng.choice((1, 2)))
            formulas.append((Fraction(0), own))
        formulas.append((slope, intercept))
    return map_of(breaks, owners, formulas)


def breaks_of(map_: Parts) -> list[Fraction]:
    """From left to right."""
    return [part.hi for part in map_[:-1] if not part.is_point]


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


def course(map_: Parts, x: Fraction, steps: int) -> Course:
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
        x = part_at(map_, x)(x)
    return Course(tuple(points), End.OPEN)


def multiplier(map_: Parts, cycle: tuple[Fraction, ...]) -> Fraction:
    return prod((part_at(map_, x).slope for x in cycle), start=Fraction(1))


def drawn_to(map_: Parts, points: list[Fraction]) -> tuple[Fraction, ...]:
    """The cycle of the last letters, if the last point lies where all points follow it inward."""
    word, breaks = "".join(part_at(map_, x).word for x in points), breaks_of(map_)
    for period in range(1, len(points) // 2):
        if word[-period:] != word[-2 * period : -period]:
            continue
        passed = [map_[ord(letter)] for letter in word[-period:]]
        intercept = Fraction(0)
        for part in passed:
            intercept = part(intercept)
        slope = prod(part.slope for part in passed)
        if abs(slope) >= 1:
            continue
        start = x = intercept / (1 - slope)
        cycle, scale, room = list[Fraction](), Fraction(1), list[Fraction]()
        for part in passed:
            if not part.holds(x) or x in breaks:
                break
            cycle.append(x)
            room += [abs(x - cut) - scale * abs(start - points[-period]) for cut in breaks]
            scale *= abs(part.slope)
            x = part(x)
        if len(cycle) == period and x == start and all(each > 0 for each in room):
            first = cycle.index(min(cycle))
            once = len(set(cycle))
            return tuple((cycle[first:] + cycle[:first])[:once])
    return ()


def is_lost(map_: Parts, last: list[Fraction]) -> bool:
    """Whether three points are outside of all breaks, and each outer piece takes more away.

    With rising pieces two points do; with falling ones every second point is farther out, beyond a
    place that two steps of both pieces take farther out, too.
    """
    (x, y, z), breaks = last, breaks_of(map_)
    left, right = map_[0].slope, map_[-1].slope
    if not breaks:
        return abs(left) > 1 or (left == 1 and map_[0].intercept != 0)
    low, high = breaks[0], breaks[-1]
    if max(x, y, z) < low and left >= 1:
        return z < y < x
    if min(x, y, z) > high and right >= 1:
        return z > y > x
    if left < 0 and right < 0 and left * right >= 1:
        return (x < low and y > high and z < x) or (x > high and y < low and z > x)
    return False
