"""Random maps that pwmap solves: what a search computes is the proved graph."""

from random import Random

import pytest
from exact import FARTHEST, SPAN, random_case, same_graph

from woodpecker.base.settings import Settings
from woodpecker.maps.symbolic import from_pwmap
from woodpecker.search.explorer import Explorer
from woodpecker.search.search import Search, complete
from woodpecker.search.tasks import Tasks

SEARCH = Search(slices=15, finest=1e-3)
WIDE = 3.0 * FARTHEST + 4.0  # an image of the farthest point: slopes below 3, offsets below 4


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("orders", "seed"),
    [
        *(((1, 2), seed) for seed in range(100)),
        # P_3 jumps at preimages of collisions of P_1 and P_2, and past those of other orders
        *(((1, 2, 3), seed) for seed in (*range(20), 109, 111)),
    ],
)
def test_the_computed_graph_is_the_proved_one(orders: tuple[int, ...], seed: int) -> None:
    map_, proved = random_case(Random(seed), orders)
    settings = Settings(span=SPAN, window=(-WIDE, WIDE))
    explorer = Explorer(Tasks.of_line(from_pwmap(map_, "p"), settings), orders)
    complete(explorer, SEARCH)
    assert same_graph(explorer.network.diagram("p", "x"), proved) == []
