"""Random maps that pwmap solves: what a search computes is the proved graph."""

from collections.abc import Sequence
from random import Random

import pytest
from exact import FARTHEST, SPAN, random_case, same_graph

from pwmap import Diagram
from woodpecker.base.settings import Settings
from woodpecker.maps.pieces import PiecewiseMap
from woodpecker.maps.symbolic import from_pwmap
from woodpecker.search.explorer import Explorer
from woodpecker.search.search import Search, complete
from woodpecker.search.tasks import Tasks

SEARCH = Search(slices=15, finest=1e-3)
WIDE = 3.0 * FARTHEST + 4.0  # an image of the farthest point: slopes below 3, offsets below 4


def computed(map_: PiecewiseMap, orders: Sequence[int]) -> Diagram:
    settings = Settings(span=SPAN, window=(-WIDE, WIDE))
    explorer = Explorer(Tasks.of_line(map_, settings), orders)
    complete(explorer, SEARCH)
    return explorer.network.diagram("p", "x")


@pytest.mark.nightly
@pytest.mark.parametrize("seed", range(100))
def test_the_computed_graph_is_the_proved_one(seed: int) -> None:
    map_, proved = random_case(Random(seed), (1, 2))
    assert same_graph(computed(from_pwmap(map_, "p"), (1, 2)), proved) == []


@pytest.mark.nightly
@pytest.mark.parametrize("seed", [*range(20), 109, 111])
def test_also_where_orbits_come_back_to_borders(seed: int) -> None:
    """P_3 jumps at preimages of collisions of P_1 and P_2, and past those of other orders."""
    map_, proved = random_case(Random(seed), (1, 2, 3))
    assert same_graph(computed(from_pwmap(map_, "p"), (1, 2, 3)), proved) == []
