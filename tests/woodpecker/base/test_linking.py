"""Parts that are compiled within what Python calls: the same numbers, and nothing left behind."""

import math
from typing import Any

import numpy as np
import pytest

from woodpecker.base import compiled, linking
from woodpecker.base.arrays import Floats
from woodpecker.base.compiled import jit, part

pytestmark = pytest.mark.skipif(not compiled.COMPILED, reason="numba does not compile here")

ROOM = np.dtype((np.record, [("sums", "f8", (2,)), ("rows", "f8", (2, 3))]))


@part
def add(row: Floats, sums: Floats, k: int) -> None:
    """Sum of a row, and a function that numba has a part of its own for."""
    sums[k] = math.hypot(row[0] + row[1], max(row[2], 0.5))


@part
def add_twice(rows: Floats, room: Any) -> tuple[float, float]:
    """A part that calls a part, with views of arrays."""
    for k in range(2):
        add(rows[k], room.sums, k)
        add(room.rows[k], room.sums, k)
    return room.sums[0], room.sums[1]


def total(rows: Floats, owner: Any) -> float:
    """What Python calls."""
    room = owner[0]
    for k in range(2):
        for j in range(3):
            room.rows[k, j] = rows[k, j] / 3.0
    first, second = add_twice(rows, room)
    return first - 2.0 * second


ROWS = np.array([[0.1, 0.2, 0.3], [4.0, 5.0, 6.0]])


def test_numba_is_made_as_expected() -> None:
    """Otherwise the kernel takes twice as long to compile, and no other test would tell."""
    assert None not in linking.pipelines()


@pytest.mark.slow
def test_parts_compute_what_python_does() -> None:
    expected = total(ROWS, np.zeros(1, dtype=ROOM))
    assert math.isfinite(expected)
    # some roundings: a compiler may be asked to join a product and a sum
    found = jit(total)(ROWS, np.zeros(1, dtype=ROOM))
    assert found == pytest.approx(expected, rel=1e-15)


def test_arrays_are_not_kept() -> None:
    """Parts do not count the users of an array; what they borrow is free afterwards."""
    import sys

    rows, owner = ROWS.copy(), np.zeros(1, dtype=ROOM)
    function = jit(total)
    function(rows, owner)
    users = sys.getrefcount(rows), sys.getrefcount(owner)
    for _ in range(10):
        function(rows, owner)
    assert (sys.getrefcount(rows), sys.getrefcount(owner)) == users


def test_without_these_parts_of_numba_it_compiles_as_usual(monkeypatch: pytest.MonkeyPatch) -> None:
    def other(name: str) -> Any:
        raise ImportError(name)

    monkeypatch.setattr(linking, "import_module", other)
    assert linking.pipelines() == (None, None)
    whole, for_parts = compiled._options()
    assert "pipeline_class" not in whole
    assert "pipeline_class" not in for_parts
