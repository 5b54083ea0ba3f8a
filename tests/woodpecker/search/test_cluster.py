"""Searches on a cluster of dask, as the page has them: the diagram of one process."""

import os
import signal
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from diagrams import to_the_last_bit
from maps import everything
from needs import NIGHTLY_TOY
from scenes import ROOT

from woodpecker import (
    FormulaMap,
    FormulaPiece,
    Search,
    Settings,
    Smooth,
    Toy,
    bifurcation_diagram,
    saved_diagram,
)
from woodpecker.search import Stage

distributed = pytest.importorskip("distributed", reason="needs the extra cluster")

pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("default")]  # dask's own warnings

SETTINGS = Settings(span=(-1.0, 2.5), window=(-20.0, 20.0))
SEARCH = Search(slices=40)


def two_lines() -> FormulaMap:
    """A map of lambdas, which only cloudpickle can send."""
    left = Smooth(lambda x, p: 0.4 * x + p, lambda x, p: 0.4, lambda x, p: 1.0)
    right = Smooth(lambda x, p: p - 2.0 * x, lambda x, p: -2.0, lambda x, p: 1.0)
    below = Smooth(lambda x, p: -x, lambda x, p: -1.0, lambda x, p: 0.0)
    above = Smooth(lambda x, p: x, lambda x, p: 1.0, lambda x, p: 0.0)
    return FormulaMap(
        [FormulaPiece("L", left, {"x = 0": below}), FormulaPiece("R", right, {"x = 0": above})]
    )


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as found,
    ):
        found.run(import_module, "woodpecker.search.tasks")
        yield found


def searched(**options: Any) -> Any:
    return everything(two_lines(), SETTINGS, (1, 2, 4), SEARCH, **options)


@NIGHTLY_TOY
def test_the_page_does_as_it_says(
    client: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs/howto/cluster.md").read_text(encoding="utf-8")
    code = page.split("```py\n")[1].split("```")[0]
    names: dict[str, Any] = {}
    exec(code.replace("tcp://head:8786", client.scheduler.address), names)
    names["client"].close()
    alone = bifurcation_diagram(
        Toy(), "eps_n1", (0.33, 0.4), (1,), (-1.0, -0.8), search=Search(slices=8), workers=1
    )
    assert names["workers"] == 4
    assert to_the_last_bit(names["diagram"]) == to_the_last_bit(alone)
    assert to_the_last_bit(saved_diagram("island.jsonl")) == to_the_last_bit(alone)


@pytest.mark.nightly
@pytest.mark.skipif(sys.platform == "win32", reason="processes are not killed by signals there")
def test_a_worker_that_is_killed_does_not_matter(client: Any) -> None:
    alone, killed = searched(), list[int]()

    def kill(stage: Stage) -> None:
        if stage.slices >= 3 and not killed:
            killed.append(next(iter(client.run(os.getpid).values())))
            os.kill(killed[0], signal.SIGKILL)

    found = searched(executor=client.get_executor(), workers=2, progress=kill)
    assert killed
    assert to_the_last_bit(found.diagram) == to_the_last_bit(alone.diagram)
