"""Exact linear programming: Farkas' lemma as a function.

Either vectors combine to a target with nonnegative weights, or another vector separates them from
it. The simplex method finds either, on integers over one common denominator.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

Vector = Sequence[int]


def combination(columns: Sequence[Vector], target: Vector) -> tuple[bool, tuple[Fraction, ...]]:
    """Whether integer columns combine to a target with nonnegative weights; these, one for each.

    If they do not, a vector whose product with each column is at most 0, and with the target
    positive.
    """
    tableau = _Tableau(columns, target)
    while (column := tableau.entering()) is not None:
        tableau.pivot(tableau.leaving(column), column)
    combines = not tableau.total()
    return combines, tableau.weights() if combines else tableau.separating()


class _Tableau:
    """Rows (columns | units | target) of the first phase, over one common denominator."""

    def __init__(self, columns: Sequence[Vector], target: Vector) -> None:
        self._columns, size = len(columns), len(target)
        self._senses = [-1 if number < 0 else 1 for number in target]
        # an artificial variable in each row makes up the difference to the target; the last row, of
        # reduced costs, ends with minus their sum, which is minimised
        self._rows = [
            [sense * column[i] for column in columns]
            + [int(i == j) for j in range(size)]
            + [sense * target[i]]
            for i, sense in enumerate(self._senses)
        ]
        costs = [-sum(column) for column in zip(*self._rows, strict=True)]
        costs[self._columns : -1] = [0] * size
        self._rows.append(costs)
        self._basis = list(range(self._columns, self._columns + size))
        self._denominator = 1
        self._stuck = False  # whether the last step left the sum as it was

    def total(self) -> int:
        """The sum of the artificial variables, times the denominator."""
        return -self._rows[-1][-1]

    def entering(self) -> int | None:
        """The column of the steepest descent; while steps are idle the first one [Bland1977]."""
        costs = self._rows[-1][: self._columns]
        if self._stuck:
            return next((j for j, cost in enumerate(costs) if cost < 0), None)
        best = min(range(self._columns), key=costs.__getitem__, default=None)
        return None if best is None or costs[best] >= 0 else best

    def leaving(self, column: int) -> int:
        """The row that first reaches zero; of several the one whose variable comes first."""
        rows = [(i, row) for i, row in enumerate(self._rows[:-1]) if row[column] > 0]
        # there is one, as the sum is bounded below
        return min((Fraction(row[-1], row[column]), self._basis[i], i) for i, row in rows)[-1]

    def pivot(self, row: int, column: int) -> None:
        chosen, before = self._rows[row], self._denominator
        pivot = chosen[column]
        self._stuck = not chosen[-1]
        for i, other in enumerate(self._rows):
            factor = other[column]
            if i != row and (factor or pivot != before):
                self._rows[i] = [
                    (pivot * a - factor * b) // before for a, b in zip(other, chosen, strict=True)
                ]  # exact: all are minors of the first tableau
        self._denominator = pivot
        self._basis[row] = column

    def weights(self) -> tuple[Fraction, ...]:
        """Of the columns, if the sum is zero."""
        weights = [Fraction(0)] * self._columns
        for i, variable in enumerate(self._basis):
            if variable < self._columns:
                weights[variable] = Fraction(self._rows[i][-1], self._denominator)
        return tuple(weights)

    def separating(self) -> tuple[Fraction, ...]:
        """The dual values: the reduced cost of an artificial variable is 1 minus that."""
        costs = self._rows[-1][self._columns : -1]
        return tuple(
            sense * (1 - Fraction(cost, self._denominator))
            for sense, cost in zip(self._senses, costs, strict=True)
        )
