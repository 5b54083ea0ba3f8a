"""All that the package says of a family of maps, against brute force.

On every edge of a parameter, beside it on both sides, and elsewhere.
"""

import random
from collections.abc import Iterator
from fractions import Fraction

from cell_formulas import check_cells
from collisions import check_points
from comparisons import Case, Report, check_at
from families import ONE, Family
from independent import Root
from readings import Place, rational_near


def parameters(case: Case, count: int, draw: random.Random) -> Iterator[tuple[Place, bool]]:
    """Where to compare, and whether that is an edge: on and beside all edges, and elsewhere."""
    low, high = case.family.span
    done = 0
    edges = list(case.formulas())
    for edge in edges:
        yield edge, True
        centre = rational_near(edge) if isinstance(edge, Root) else edge
        for width in (Fraction(1, 1000), Fraction(1, 10**12)):
            for side in (-1, 1):
                p = centre + side * width * max(ONE, abs(centre))
                if low <= p <= high:
                    yield p, p in edges
                    done += 1
        done += 1
    for _ in range(count - done):
        p = low + (high - low) * Fraction(draw.randrange(1, 9973), 9973)
        yield p, p in edges


def compare(family: Family, count: int, seed: int, report: Report) -> int:
    """Everything about one family; the number of parameters."""
    draw = random.Random(seed)
    case = Case.of(family, report)
    places = list(parameters(case, count, draw))
    for p, on_edge in places:
        check_at(case, p, on_edge=on_edge)
    check_points(case)
    check_cells(family, report, draw)
    return len(places)
