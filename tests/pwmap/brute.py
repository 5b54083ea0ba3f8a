"""Maps of the line for brute force in fractions, and their iterates (``independent``).

Nothing of pwmap is used. The letter of a piece is the character of its index, from left to right.
"""

from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise

import independent
from independent import EXACT, LEFT, RIGHT, Crossing, Fixed, Part, Parts, nested, part_at

ONE = Fraction(1)
SPLIT = "|"  # between the words on two sides; no map here has so many pieces


def map_of(
    breaks: Sequence[Fraction], owners: Sequence[str], formulas: Sequence[tuple[Fraction, Fraction]]
) -> Parts:
    """A map from its breaks, who owns each (``"left"``, ``"right"``, ``"point"``), and formulas.

    There is one (slope, intercept) for each piece, points included, from left to right.
    """
    domains: list[tuple[Fraction | None, bool, Fraction | None, bool]] = []
    lo, lo_in = None, False
    for x, owner in zip(breaks, owners, strict=True):
        domains.append((lo, lo_in, x, owner == "left"))
        if owner == "point":
            domains.append((x, True, x, True))
        lo, lo_in = x, owner == "right"
    domains.append((lo, lo_in, None, False))
    both = enumerate(zip(domains, formulas, strict=True))
    return tuple(Part(*domain, *formula, chr(i)) for i, (domain, formula) in both)


def texts(f: Parts) -> list[tuple[str, str]]:
    """Formulas and conditions of the pieces, whose numbers may be expressions in parameters."""
    return [(f"({part.slope})*x + ({part.intercept})", condition(part)) for part in f]


def condition(part: Part) -> str:
    """The domain of a piece."""
    low = f"(x {'>=' if part.lo_in else '>'} ({part.lo}))" if part.lo is not None else ""
    high = f"(x {'<=' if part.hi_in else '<'} ({part.hi}))" if part.hi is not None else ""
    return " & ".join(filter(None, (low, high))) or "True"


def spelled(letters: Sequence[str], word: str) -> str:
    """A word in the letters of a map; that of a crossing with its bar."""
    return "".join(each if each == SPLIT else letters[ord(each)] for each in word)


def coded(letters: str, word: str) -> str:
    """The word that is spelled so."""
    return "".join(chr(letters.index(each)) for each in word)


def cycle_of(f: Parts, word: str) -> Fraction | None:
    """The first point of the cycle of a word, if its orbit has that word; its slope is not 1."""
    slope, shift = ONE, 0 * ONE
    for part in map(f.__getitem__, map(ord, word)):
        slope, shift = part.slope * slope, part(shift)
    x = shift / (1 - slope)
    return x if nested(f, x, len(word))[1] == word else None


def composition(outer: Parts, first: Parts) -> Parts:
    """The map x -> outer(first(x)), one piece for each pair of pieces; points are flat."""

    def along(x: Fraction, side: int = EXACT) -> tuple[str, Fraction]:
        y, word = nested(first, x, 1, side)
        slope = part_at(first, x, side).slope
        value, last = nested(outer, y, 1, side if slope > 0 else -side if slope < 0 else EXACT)
        return word + last, value

    own = {part.lo for part in first if part.lo is not None}
    own |= {
        (part.lo - q.intercept) / q.slope
        for part in outer
        for q in first
        if part.lo is not None and q.slope != 0
    }
    cuts = [x for x in sorted(own) if len({along(x, s)[0] for s in (LEFT, EXACT, RIGHT)}) > 1]
    owners, formulas = [], []
    for lo, hi in gaps(cuts):
        points = inner(lo, hi)
        low, high = (along(x)[1] for x in points)
        slope = (high - low) / (points[1] - points[0])
        formulas.append((slope, low - slope * points[0]))
        if hi is not None:
            at, left, right = (along(hi, s) for s in (EXACT, LEFT, RIGHT))
            owners.append({left[0]: "left", right[0]: "right"}.get(at[0], "point"))
            if owners[-1] == "point":
                formulas.append((0 * ONE, at[1]))
    return map_of(cuts, owners, formulas)


# --- Iterates -------------------------------------------------------------------------------------


@lru_cache(maxsize=32)
def iterate(f: Parts, j: int) -> Parts:
    """The pieces of P_j, found by following intervals."""
    return independent.iterated(f, j)[-1]


def bands(f: Parts, j: int) -> list[tuple[Part, int]]:
    """The pieces of P_j that are the identity, each with the minimal period of its points."""
    own = [part for part in iterate(f, j) if part.is_identity]
    return [(part, independent.band_period(f, part, j)) for part in own]


def fixed_points(f: Parts, j: int) -> list[Fixed]:
    """All fixed points of P_j but for those in bands, from left to right."""
    return list(independent.fixed_points(f, iterate(f, j), j))


def crossings(f: Parts, j: int) -> list[Crossing]:
    """Breaks of P_j whose one-sided limits lie strictly on opposite sides of the diagonal."""
    return list(independent.crossings(iterate(f, j)))


def breaks(f: Parts, j: int) -> list[Fraction]:
    """All points around which the words of P_j are not the same, from left to right."""
    return list(dict.fromkeys(part.lo for part in iterate(f, j)[1:]))


def gaps(points: Sequence[Fraction]) -> list[tuple[Fraction | None, Fraction | None]]:
    """The open intervals between sorted points."""
    return list(pairwise([None, *points, None]))


def inner(lo: Fraction | None, hi: Fraction | None) -> tuple[Fraction, Fraction]:
    """Two points inside an open interval."""
    if lo is None:
        if hi is None:
            return 0 * ONE, ONE
        return hi - 2 * ONE, hi - ONE
    if hi is None:
        return lo + ONE, lo + 2 * ONE
    return lo + (hi - lo) / 3, lo + (hi - lo) * 2 / 3
