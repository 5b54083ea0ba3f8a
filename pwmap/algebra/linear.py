"""Exact linear programming: Farkas' lemma as a function.

Either vectors combine to a target with nonnegative weights, or another vector separates them from
it. The simplex method finds one or the other, in integers over one common denominator.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

Vector = Sequence[int]


def combination(columns: Sequence[Vector], target: Vector) -> tuple[bool, tuple[Fraction, ...]]:
    """Whether integer columns combine to a target with nonnegative weights, and these weights.

    If they do not, instead a vector whose product with each column is at most 0, and with the
    target positive.
    """
    count, size = len(columns), len(target)
    senses = [-1 if number < 0 else 1 for number in target]
    # rows (columns | units | target) over one common denominator; an artificial variable in each
    # takes up the difference to the target. Their sum is minimised: the last row holds the reduced
    # costs and ends with minus the sum
    rows = [
        [sense * column[i] for column in columns]
        + [int(i == j) for j in range(size)]
        + [sense * target[i]]
        for i, sense in enumerate(senses)
    ]
    costs = [-sum(column) for column in zip(*rows, strict=True)]
    costs[count:-1] = [0] * size
    rows.append(costs)
    basis, denominator = list(range(count, count + size)), 1
    is_idle = False  # whether the last step left the sum unchanged
    while (column := _entering(rows[-1][:count], is_idle)) is not None:
        # the row that reaches zero first, of several the one of the first variable (Bland's rule);
        # there is one, as the sum is bounded below
        leaving = min(
            (Fraction(row[-1], row[column]), basis[i], i)
            for i, row in enumerate(rows[:-1])
            if row[column] > 0
        )[-1]
        is_idle = not rows[leaving][-1]
        basis[leaving], pivot = column, rows[leaving][column]
        _eliminate(rows, leaving, column, denominator)
        denominator = pivot
    if rows[-1][-1]:  # dual values: 1 minus the reduced costs of artificial variables
        duals = (1 - Fraction(cost, denominator) for cost in rows[-1][count:-1])
        return False, tuple(sense * dual for sense, dual in zip(senses, duals, strict=True))
    found = {variable: Fraction(rows[i][-1], denominator) for i, variable in enumerate(basis)}
    return True, tuple(found.get(j, Fraction(0)) for j in range(count))


def _entering(costs: Sequence[int], is_idle: bool) -> int | None:
    """The column of steepest descent; after an idle step the first descending one [Bland1977]."""
    if is_idle:
        return next((j for j, cost in enumerate(costs) if cost < 0), None)
    best = min(range(len(costs)), key=costs.__getitem__, default=None)
    return None if best is None or costs[best] >= 0 else best


def _eliminate(rows: list[list[int]], row: int, column: int, denominator: int) -> None:
    """Clear a column in all rows but one; the pivot is the new denominator."""
    chosen, pivot = rows[row], rows[row][column]
    for i, other in enumerate(rows):
        factor = other[column]
        if i != row and (factor or pivot != denominator):
            rows[i] = [
                (pivot * a - factor * b) // denominator for a, b in zip(other, chosen, strict=True)
            ]  # exact, as all entries are minors of the first tableau
