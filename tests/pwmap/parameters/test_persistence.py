"""What is kept along an axis, against what an oracle says at each place alone."""

import random
from collections.abc import Iterator

import pytest
from sympy import QQ

from pwmap import PiecewiseLinearMap
from pwmap.maps.budget import BUDGET, Meter
from pwmap.parameters.axis import Axis
from pwmap.parameters.cells import Cell, from_all_orders, studied_at, with_stages

ORDERS = (1, 3, 4)


def maps() -> Iterator[str]:
    """Edges of higher degree, flat pieces, bands, a symbolic parameter, and drawn ones."""
    yield "Piecewise((-3*x/2 - 2, x < -1), (p*x, x < 1), (-3*x/2 + 2, True))"
    yield "Piecewise((x/2 + p, x < 0), (p, Eq(x, 0)), (1 - p**2, True))"
    yield "Piecewise((x + p, x <= 0), (p - x, x < 1), (x - 2, True))"
    yield "Piecewise((q - 2, x <= 0), (q - p*x, True))"
    drawn = random.Random(20)
    for _ in range(6):
        m, c, n = (f"{drawn.randint(-9, 9)}/{drawn.randint(1, 4)}" for _ in range(3))
        yield f"Piecewise(({m}*x + p, x < -1/2), (p*x + {c}, x <= 1), ({n}*x - p, True))"


@pytest.mark.parametrize("text", list(maps()))
def test_a_cell_is_what_its_sample_shows_alone(text: str) -> None:
    map_ = PiecewiseLinearMap.from_sympy(text)

    def compare(axis: Axis, cells: list[Cell]) -> int:
        for cell in cells:
            alone = studied_at(cell.sample, axis, map_.chain, cell)
            assert alone.iterates == cell.iterates
            assert alone.oracle.signs.items() <= cell.oracle.signs.items()
        return len(cells)

    build = from_all_orders(compare)
    span, meter = (QQ(-3), QQ(2)), Meter(BUDGET)
    assert with_stages(build, map_, "p", ORDERS, span, None, with_ends=True, meter=meter) > 5
