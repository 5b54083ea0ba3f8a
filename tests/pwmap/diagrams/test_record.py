"""What commands write about their files, and what they remove of an earlier run."""

import json
import math
import os
from pathlib import Path

import networkx as nx
import pytest

from pwmap import PiecewiseLinearMap, __version__, bifurcation_diagram, read_graph, write_graph
from pwmap.diagrams.files import write_whole
from pwmap.diagrams.record import attributes, keep_record, plain, record_of
from woodpecker import ExpansionFriction


def write(folder: Path, *names: str, text: str = "ours") -> None:
    for name in names:
        write_whole(folder / name, text.encode())


def present(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes with names")
def test_a_pipe_or_a_device_is_not_replaced(tmp_path: Path) -> None:
    """A pipe stands for /dev/null, in the place of which the superuser would put a file."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with pytest.raises(FileExistsError, match="it is a device or a pipe, expected a file"):
        write(tmp_path, "pipe")
    assert pipe.is_fifo()
    assert present(tmp_path) == {"pipe"}


def test_what_a_new_run_does_not_write_is_removed(tmp_path: Path) -> None:
    write(tmp_path, "a.csv", "order_1.png", "order_2.png")
    assert keep_record(tmp_path, "diagram", ["a.csv", "order_1.png", "order_2.png"], {}) == ()
    write(tmp_path, "a.csv", text="new")
    gone = keep_record(tmp_path, "diagram", ["a.csv"], {"orders": (1,)})
    assert gone == ("order_1.png", "order_2.png")
    assert present(tmp_path) == {"a.csv", "about_diagram.json"}
    record = json.loads((tmp_path / record_of("diagram")).read_text(encoding="utf-8"))
    assert record["program"] == f"woodpecker-toy {__version__}"
    assert (record["command"], record["orders"]) == ("diagram", [1])
    assert list(record["files"]) == ["a.csv"]


def test_nothing_is_removed_that_is_not_as_it_was_written(tmp_path: Path) -> None:
    """Another's file under an old name, a link, another command's files, and those of no record."""
    names = ["edited.png", "linked.png", "folder.png"]
    write(tmp_path, *names, "mine.txt", "other.csv")
    keep_record(tmp_path, "map", ["other.csv"], {})
    keep_record(tmp_path, "diagram", names, {})
    write(tmp_path, "edited.png", text="drawn over")
    (tmp_path / "linked.png").rename(tmp_path / "elsewhere.png")
    try:
        (tmp_path / "linked.png").symlink_to(tmp_path / "elsewhere.png")
    except OSError:  # Windows, where it takes a privilege
        write(tmp_path, "linked.png", text="no link")
    os.unlink(tmp_path / "folder.png")  # noqa: PTH108
    (tmp_path / "folder.png").mkdir()
    assert keep_record(tmp_path, "diagram", [], {}) == ()
    assert present(tmp_path) == {
        *names, "elsewhere.png", "mine.txt", "other.csv", "about_map.json", "about_diagram.json",
    }  # fmt: skip


@pytest.mark.parametrize("name", ["../outside.csv", "inner/file.csv", "."])
def test_a_record_reaches_no_other_folder(name: str, tmp_path: Path) -> None:
    out = tmp_path / "out"
    (out / "inner").mkdir(parents=True)
    write(tmp_path, "outside.csv")
    write(out / "inner", "file.csv")
    write(out, "plain.csv")
    keep_record(out, "map", ["plain.csv"], {})
    path = out / record_of("map")
    path.write_text(path.read_text(encoding="utf-8").replace('"plain.csv"', json.dumps(name)))
    assert keep_record(out, "map", [], {}) == ()
    assert (tmp_path / "outside.csv").exists()
    assert (out / "inner" / "file.csv").exists()


@pytest.mark.parametrize("text", ["", "[]", "{", '{"files": 3}', '{"files": {"a.csv": 1}}', "3"])
def test_a_record_that_cannot_be_read_removes_nothing(text: str, tmp_path: Path) -> None:
    write(tmp_path, "a.csv")
    (tmp_path / record_of("map")).write_text(text, encoding="utf-8")
    assert keep_record(tmp_path, "map", [], {}) == ()
    assert (tmp_path / "a.csv").exists()


def test_what_json_cannot_say_is_text() -> None:
    asked = {"pole": math.inf, "law": ExpansionFriction.SUMMED, "span": (0.0, 1), "out": Path("a")}
    assert plain(asked) == {"pole": "inf", "law": "summed", "span": [0.0, 1], "out": "a"}
    assert attributes(asked) == {"pole": "inf", "law": "summed", "span": "[0.0, 1]", "out": "a"}


def test_the_graph_of_a_diagram_is_kept_and_says_what_made_it(tmp_path: Path) -> None:
    map_ = PiecewiseLinearMap.from_sympy("Piecewise((r - 2, x <= 0), (r - 2*x, True))")
    graph = bifurcation_diagram(map_, "r", (-1, 1), (1,)).graph()
    for suffix in (".graphml", ".gexf", ".json", ".dot"):
        back = read_graph(write_graph(graph, tmp_path / f"graph{suffix}"))
        assert back.graph["program"] == f"woodpecker-toy {__version__}"
        assert nx.utils.graphs_equal(back, graph)
