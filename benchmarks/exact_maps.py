"""Exact maps: composing, diagrams, cells; in CPU times of one process."""

import time
from fractions import Fraction

from pwmap import PiecewiseLinearMap, bifurcation_diagram, parameter_cells

P1L = "Piecewise((r - 2, x <= 0), (r - a*x, True))"  # the paper's local model, Eq. (14)
SKEW = "Piecewise((a*x + 1, x <= 0), (b*x + 1, True))"


class Exact:
    """With symbols, and at numbers."""

    timeout = 300.0
    timer = staticmethod(time.process_time)

    def setup(self) -> None:
        """Read the maps."""
        self.numbers = PiecewiseLinearMap.from_sympy(P1L).at({"a": Fraction(5, 4)})
        self.skew = PiecewiseLinearMap.from_sympy(SKEW).at({"a": Fraction(1, 2)})

    def time_iterates(self) -> None:
        """P_1 to P_6 with two symbols, from the formula on."""
        symbols = PiecewiseLinearMap.from_sympy(P1L, given=["a > 1", "0 < r", "r < 2"])
        for order in range(1, 7):
            symbols.iterate(order)

    def time_a_diagram(self) -> None:
        """Orders 1 to 5 over r."""
        bifurcation_diagram(self.numbers, "r", (-1, 12), orders=(1, 2, 3, 4, 5))

    def time_cells(self) -> None:
        """Of the skew tent map, orders 1 to 4."""
        parameter_cells(self.skew, "b", (1, 2, 3, 4), (-5, 0))
