"""What is kept along an axis, against what an oracle says at each place alone."""

import random
from collections.abc import Iterator

import pytest
from sympy import QQ

from pwmap import PiecewiseLinearMap
from pwmap.algebra.exact import HIGHEST, LOWEST
from pwmap.maps.budget import BUDGET, Meter
from pwmap.maps.words import CriticalOrbit, SignOracle
from pwmap.parameters.axis import Axis
from pwmap.parameters.cells import Cell, from_all_orders, studied_at, with_stages
from pwmap.parameters.persistence import Answers

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


def test_an_answer_holds_up_to_the_next_root() -> None:
    """That of the piece L may change at p = 0 only, where A_L(0) = p, that of R at 3 only."""
    map_ = PiecewiseLinearMap.from_sympy("Piecewise((x/2 + p, x <= 0), (x/2 + p - 3, True))")
    axis = Axis(map_.definition, "p", {})
    answers, asked = Answers(axis, QQ(-1), QQ(4)), list[str]()

    def side(letter: int, oracle: SignOracle) -> int:
        """Of A(0), which is p for the letter L and p - 3 for R."""
        asked.append("LR"[letter])
        return oracle.sign(CriticalOrbit(0, (letter,), 0))

    found = []
    for place in (QQ(-1), QQ(-1, 2), QQ(0), QQ(1), QQ(2), QQ(3), QQ(4), QQ(2)):
        answers.move(place, axis.oracle(place))
        found.append((answers.ask(side, 0), answers.ask(side, 1), "".join(asked)))
        at_root = [*answers.zeros()]
        if not at_root:
            answers.keep()
            ends = answers.nearest(LOWEST, HIGHEST)
            assert ends == ((LOWEST, 0) if place < 0 else (0, 3) if place < 3 else (3, HIGHEST))
        assert len(at_root) == (place in (0, 3))
        asked.clear()
    assert found == [
        (-1, -1, "LR"), (-1, -1, ""), (0, -1, "L"), (1, -1, "L"), (1, -1, ""), (1, 0, "R"),
        (1, 1, "R"), (1, -1, "R"),
    ]  # fmt: skip
