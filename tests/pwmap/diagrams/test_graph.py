"""Files of graphs: whatever is written reads back as exactly the same graph."""

import inspect
import io
import json
import math
import os
import stat
import struct
import xml.etree.ElementTree as ET
from enum import Enum, IntEnum
from fractions import Fraction
from pathlib import Path

import networkx as nx
import numpy as np
import pytest

from pwmap.diagrams.graph import read_graph, sanitised, write_graph

SUFFIXES = (".graphml", ".gexf", ".json", ".dot", ".gv")
every_format = pytest.mark.parametrize("suffix", SUFFIXES)

NASTY_TEXTS = (
    *("", " ", "  both ends ", "\t", "\n", "\r", "a\nb", "a\r\nb\r", "ends with a line break\n"),
    *("\\", "a\\", "\\n", "\\\n", "\\\\\r\n", '"', '"quoted"', "\\\"'", "'", '" + "'),
    *("<b>", "<a & b>", "&amp;", "]]>", "<!-- x -->", "/* x */", "// x", "# x"),
    *("1.0", "-1", "1e-05", "nan", "NaN", "inf", "-inf", "minus_inf", "True", "None", "null"),
    *("{}", '{"$numberDouble": "NaN"}', "[1, 2]", "graph", "node", "strict"),
    *("a; b", "a=b, c", "a -- b", "]", "}", "+", "φ̂ ≥ µ"),
    *("\u2028\u0085\u00a0\ufeff", "\U0001d535😀", "\ud7ff\ue000\ufffd\U0010ffff"),
)
NASTY_NUMBERS = (
    *(0.0, -0.0, 1.0, -1.5, 0.1, 1 / 3, 1e-5, 1e22, -1e-300, 5e-324),
    *(2.2250738585072014e-308, 1.7976931348623157e308, math.pi, math.inf, -math.inf, math.nan),
)
NASTY_NAMES = (
    *("id", "key", "label", "name", "source", "target", "type", "weight", "directed", "mode"),
    *("start", "end", "pid", "parents", "slices", "spells", "viz", "timeformat", "edgedefault"),
    *("node_default", "edge_default", "networkx_key", "nodes", "edges", "links", "multigraph"),
    *("self", "node_for_adding", "u_for_edge", "v_for_edge", "u_of_edge", "attr"),
    *("graph", "node", "edge", "strict", "Subgraph", "digraph", "obj_dict", "src", "dst", "port"),
    *("incoming_graph_data", "graph_name", "graph_type", "default", "data", "attributes", "float"),
    *("x", "_", "x_", "if", "nan", "φ", "\U00010400", "shape_type", "port", "for_", "title"),
    *("value", "multigraph_input"),
)


def exact(graph: nx.MultiGraph) -> tuple[object, list[object], list[object]]:
    """Nodes, edges and attributes in order, floats by their bits, so that == is exact."""

    def data(attributes: dict[str, object]) -> dict[str, tuple[type, object]]:
        return {
            name: (type(value), struct.pack("<d", value) if type(value) is float else value)
            for name, value in attributes.items()
        }

    assert type(graph) is nx.MultiGraph
    return (
        data(graph.graph),
        [(node, data(attributes)) for node, attributes in graph.nodes(data=True)],
        [(*edge, data(attributes)) for *edge, attributes in graph.edges(keys=True, data=True)],
    )


def round_trip(graph: nx.MultiGraph, folder: Path, suffix: str) -> nx.MultiGraph:
    return read_graph(write_graph(graph, folder / f"graph{suffix}"))


def assert_kept(graph: nx.MultiGraph, folder: Path, suffix: str) -> None:
    assert exact(round_trip(graph, folder, suffix)) == exact(sanitised(graph))


def small() -> nx.MultiGraph:
    graph = nx.MultiGraph(parameter="eps_n1", span=1.0)
    graph.add_node("A", kind="BC", x=-0.75)
    graph.add_node("B", kind="EP", x=math.nan)
    graph.add_edge("A", "B", key="b1", word="S2 D2", order=1.0)
    return graph


# --- Round trips ---------------------------------------------------------------------------


@every_format
def test_every_nasty_text_and_number_is_kept_everywhere(suffix: str, tmp_path: Path) -> None:
    data: dict[str, float | str] = {f"text{i}": text for i, text in enumerate(NASTY_TEXTS)}
    data |= {f"number{i}": number for i, number in enumerate(NASTY_NUMBERS)}
    graph = nx.MultiGraph()
    graph.graph.update(data)
    graph.add_nodes_from([("none", {}), ("all", data)])
    for text in NASTY_TEXTS:
        if text and ":" not in text:
            graph.add_edges_from([("none", text, text, {"word": text}), (text, text, "loop", {})])
    graph.add_edges_from([("none", "all", "k", data)])
    assert_kept(graph, tmp_path, suffix)


@every_format
@pytest.mark.parametrize("value", [2.5, "2.5", "text", math.nan])
def test_every_name_may_be_used_everywhere(suffix: str, value: float | str, tmp_path: Path) -> None:
    data = dict.fromkeys(NASTY_NAMES, value)
    graph = nx.MultiGraph()
    graph.graph.update(data)
    graph.add_nodes_from([("A", data), ("B", {})])
    graph.add_edges_from([("A", "B", "k", data), ("A", "B", "l", {})])
    assert_kept(graph, tmp_path, suffix)


@every_format
def test_a_name_may_hold_a_number_here_and_text_there(suffix: str, tmp_path: Path) -> None:
    graph = nx.MultiGraph(x="phi_s", key=1.0)
    graph.add_nodes_from([("A", {"x": 1.0, "id": "1.0"}), ("B", {"x": "1.0", "id": 1.0})])
    graph.add_edges_from([("A", "B", "k", {"label": "1", "y": "nan"})])
    graph.add_edges_from([("A", "B", "l", {"label": 1.0, "y": math.nan})])
    assert_kept(graph, tmp_path, suffix)


@every_format
def test_loops_parallel_edges_and_isolated_nodes_are_kept_in_order(
    suffix: str, tmp_path: Path
) -> None:
    graph = nx.MultiGraph(name="order")
    graph.add_nodes_from(["z", "isolated", "a", "m"])
    for u, v, key in (
        *(("a", "z", "2"), ("z", "a", "10"), ("z", "z", "loop"), ("z", "z", "loop 2")),
        *(("m", "a", "2"), ("m", "m", "0")),
    ):
        graph.add_edge(u, v, key=key, word=f"{u} {v}")
    back = round_trip(graph, tmp_path, suffix)
    assert exact(back) == exact(graph)
    assert list(back) == ["z", "isolated", "a", "m"]
    assert back.degree("isolated") == 0
    assert sorted(back["z"]["a"]) == ["10", "2"]
    assert back["a"]["z"]["10"] == {"word": "z a"}


@every_format
def test_writing_twice_gives_the_same_file_and_leaves_the_graph_alone(
    suffix: str, tmp_path: Path
) -> None:
    graph = small()
    graph.graph.update(id="g", name="n")
    before = exact(graph)
    first = write_graph(graph, tmp_path / f"first{suffix}").read_bytes()
    assert write_graph(graph, str(tmp_path / f"second{suffix}")).read_bytes() == first
    assert exact(graph) == before


def test_dot_has_two_suffixes_and_suffixes_may_be_in_capitals(tmp_path: Path) -> None:
    dot = write_graph(small(), tmp_path / "graph.dot").read_bytes()
    assert write_graph(small(), tmp_path / "graph.gv").read_bytes() == dot
    assert_kept(small(), tmp_path, ".GraphML")


# --- What the files look like ----------------------------------------------------------------


def test_json_is_strict_node_link_data(tmp_path: Path) -> None:
    graph = small()
    graph.nodes["A"].update(top=math.inf, bottom=-math.inf)

    def refuse(token: str) -> None:
        raise AssertionError(f"{token} is no JSON")

    text = write_graph(graph, tmp_path / "graph.json").read_text(encoding="utf-8")
    data = json.loads(text, parse_constant=refuse)
    assert data == {
        "directed": False,
        "multigraph": True,
        "graph": {"parameter": "eps_n1", "span": 1.0},
        "nodes": [
            {
                "id": "A",
                "kind": "BC",
                "x": -0.75,
                "top": {"$numberDouble": "Infinity"},
                "bottom": {"$numberDouble": "-Infinity"},
            },
            {"id": "B", "kind": "EP", "x": {"$numberDouble": "NaN"}},
        ],
        "edges": [{"source": "A", "target": "B", "key": "b1", "word": "S2 D2", "order": 1.0}],
    }


def test_plain_networkx_reads_the_json(tmp_path: Path) -> None:
    graph = small()
    del graph.nodes["B"]["x"]
    data = json.loads(write_graph(graph, tmp_path / "graph.json").read_bytes())
    new = "edges" in inspect.signature(nx.node_link_data).parameters
    back = nx.node_link_graph(data, **{"edges" if new else "link": "edges"})
    assert exact(back) == exact(graph)


def test_plain_networkx_reads_the_graphml(tmp_path: Path) -> None:
    path = write_graph(small(), tmp_path / "graph.graphml")
    back = nx.read_graphml(path, force_multigraph=True)
    assert back.nodes["A"] == {"kind": "BC", "x": -0.75}
    assert back.edges["A", "B", "b1"] == {"word": "S2 D2", "order": 1.0}
    simple = nx.read_graphml(path)  # what networkx makes of it unless it is told, as the file says
    assert not simple.is_multigraph()
    assert simple.edges["A", "B"]["id"] == "b1"
    assert "force_multigraph=True" in path.read_text(encoding="utf-8").splitlines()[1]
    graph = small()
    graph.add_edge("A", "B", key="b2")
    both = nx.read_graphml(write_graph(graph, path))  # parallel edges it sees
    assert sorted(key for *_, key in both.edges(keys=True)) == ["b1", "b2"]


def test_gexf_shows_ids_keys_and_typed_columns(tmp_path: Path) -> None:
    root = ET.parse(write_graph(small(), tmp_path / "graph.gexf")).getroot()
    space = {"g": root.tag[1:].partition("}")[0]}
    columns = {a.get("title"): a.get("type") for a in root.iterfind(".//g:attribute", space)}
    assert columns["x"] == columns["order"] == "double"
    assert columns["kind"] == columns["word"] == "string"
    assert [n.get("label") for n in root.iterfind(".//g:node", space)] == ["A", "B"]
    assert [e.get("label") for e in root.iterfind(".//g:edge", space)] == ["b1"]


def test_dot_quotes_text_and_writes_numbers_bare(tmp_path: Path) -> None:
    graph = small()
    graph.nodes["B"].update(low=-math.inf, tiny=-1e-7, note='a\\ "b"\r\n')
    assert write_graph(graph, tmp_path / "graph.dot").read_text(encoding="utf-8") == (
        "graph {\n"
        '"parameter"="eps_n1";\n'
        '"span"=1.0;\n'
        '"A" ["kind"="BC", "x"=-0.75];\n'
        '"B" ["kind"="EP", "x"=nan, "low"=minus_inf, "tiny"=-0.0000001, '
        r'"note"="a\\ \"b\"\r\n"];'
        "\n"
        '"A" -- "B" ["key"="b1", "word"="S2 D2", "order"=1.0];\n'
        "}\n"
    )


# --- The sanitiser -----------------------------------------------------------------------------


class Code(Enum):
    TEXT = "LP"
    NUMBER = 3
    PAIR = (1, 2)


class Level(IntEnum):
    TWO = 2


class Word(str, Enum):  # noqa: UP042 (an id may be such a text)
    A = "a"


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        *((1, 1.0), (True, 1.0), (False, 0.0), (-2.5, -2.5), (10**20, 1e20), (-0.0, -0.0)),
        *((np.float64(0.1), 0.1), (np.float32(0.5), 0.5), (np.int8(-3), -3.0), (np.uint64(7), 7.0)),
        *((np.bool_(True), 1.0), (Code.NUMBER, 3.0), (Level.TWO, 2.0), (Fraction(1, 4), 0.25)),
        *(("a", "a"), (np.str_("a"), "a"), (Code.TEXT, "LP"), (Word.A, "a"), ("", ""), ("1", "1")),
    ],
)
def test_a_value_becomes_a_float_or_plain_text(value: object, expected: float | str) -> None:
    graph = nx.MultiGraph(v=value)
    graph.add_node("A", v=value)
    graph.add_edge("A", "A", key="k", v=value)
    clean = sanitised(graph)
    for data in (clean.graph, clean.nodes["A"], clean.edges["A", "A", "k"]):
        assert type(data["v"]) is type(expected)
        assert repr(data["v"]) == repr(expected)


def test_a_nan_loses_its_sign_and_payload() -> None:
    (odd,) = struct.unpack("<d", struct.pack("<Q", 0xFFF8_0000_0000_0001))
    graph = nx.MultiGraph(v=odd)
    assert struct.pack("<d", sanitised(graph).graph["v"]) == struct.pack("<d", math.nan)


@pytest.mark.parametrize(
    "value",
    [
        *(None, [], [1.0], (1.0,), {}, {"a": 1}, set(), b"a", 1j, np.array(1.0), np.array([1.0])),
        *(Code.PAIR, object(), np.complex128(1), math.sin),
    ],
)
@every_format
def test_other_values_are_refused_by_place_and_name(
    value: object, suffix: str, tmp_path: Path
) -> None:
    for place in ("node 'B'", "edge 'b1' between 'A' and 'B'", "the graph"):
        graph = small()
        data = {"n": graph.nodes["B"], "e": graph.edges["A", "B", "b1"], "t": graph.graph}[place[0]]
        data["multiplier"] = value
        message = rf"^{place}, attribute multiplier: expected a number or"
        with pytest.raises(TypeError, match=message):
            write_graph(graph, tmp_path / f"graph{suffix}")
    assert list(tmp_path.iterdir()) == []


def with_node(node: object, **data: object) -> nx.MultiGraph:
    graph = nx.MultiGraph()
    graph.add_node(node, **data)
    return graph


def with_key(key: object) -> nx.MultiGraph:
    graph = nx.MultiGraph()
    graph.add_edge("A", "B", key=key)
    return graph


def no_xml(bad: str) -> str:
    return f"holds U\\+{ord(bad):04X}, which XML 1.0 cannot"


ID, KEY = "the id of a node", "the key of an edge between 'A' and 'B'"
NO_TEXTS, NO_IDS = (0, 1.5, ("a", "b"), b"a", Code.TEXT), ("", ":", "a:b", "end:")
NO_XML = ("\x00", "\x0b", "\x1f", "\ud800", "\ufffe", "\uffff")
REFUSED: list[tuple[nx.MultiGraph, type[Exception], str]] = [
    *((with_node(node), TypeError, f"^{ID} must be text, got") for node in NO_TEXTS),
    *(
        (with_node(name), ValueError, f"^{ID} must be non-empty text without ':'")
        for name in NO_IDS
    ),
    *((with_node(f"A{bad}"), ValueError, f"^{ID} {no_xml(bad)}") for bad in NO_XML),
    (with_key(None), TypeError, f"^{KEY} must be text, "),  # networkx gives a number then
    *((with_key(name), ValueError, f"^{KEY} must be non-") for name in NO_IDS),
    *((with_key(f"k{bad}"), ValueError, f"^{KEY} {no_xml(bad)}") for bad in NO_XML),
    *(
        (with_node("A", note=f"a{bad}"), ValueError, f"^node 'A', attribute note {no_xml(bad)}")
        for bad in NO_XML
    ),
    (nx.MultiGraph(n=10**400), ValueError, "^the graph, attribute n: .* too large for a float"),
]


@pytest.mark.parametrize(("graph", "error", "message"), REFUSED)
def test_ids_keys_and_values_that_no_file_holds_are_refused(
    graph: nx.MultiGraph, error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        sanitised(graph)


@pytest.mark.parametrize("name", ["", "a b", "1a", "a-b", "a.b", "id:float", "a:", 1, None])
def test_names_of_attributes_are_identifiers(name: object) -> None:
    for place in ("the graph", "node 'A'", "edge 'k' between 'A' and 'A'"):
        graph = nx.MultiGraph()
        graph.add_edge("A", "A", key="k")
        data = {"t": graph.graph, "n": graph.nodes["A"], "e": graph.edges["A", "A", "k"]}[place[0]]
        data[name] = 1.0
        with pytest.raises(ValueError, match=f"^{place}: the name of an attribute must be an iden"):
            sanitised(graph)


@pytest.mark.parametrize("kind", [nx.Graph, nx.DiGraph, nx.MultiDiGraph, dict])
def test_only_undirected_multigraphs_are_written(kind: type, tmp_path: Path) -> None:
    with pytest.raises(TypeError, match=rf"undirected networkx.MultiGraph, got {kind.__name__}$"):
        write_graph(kind(), tmp_path / "graph.json")


# --- Files --------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["graph.gml", "graph", "graph.json.gz", ".json"])
def test_an_unknown_suffix_is_named_with_the_known_ones(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    message = rf"^unknown suffix '{path.suffix}' .* \.graphml, \.gexf, \.json, \.dot, \.gv$"
    with pytest.raises(ValueError, match=message):
        write_graph(small(), path)
    with pytest.raises(ValueError, match=message):
        read_graph(path)


@every_format
def test_a_missing_folder_or_file_is_named(suffix: str, tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"^cannot write graph\..*there is no folder .*out"):
        write_graph(small(), tmp_path / "out" / f"graph{suffix}")
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(FileNotFoundError, match="graph"):
        read_graph(tmp_path / f"graph{suffix}")


@every_format
@pytest.mark.parametrize("content", [b"", b"[1]", b"<a", b"<a/>", b"\xff\xfe", b"{}", b"graph { a"])
def test_a_broken_file_is_named(
    suffix: str, content: bytes, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / f"graph{suffix}"
    path.write_bytes(content)
    with pytest.raises(ValueError, match=rf"graph\{suffix} does not hold a graph written by write"):
        read_graph(path)
    assert capsys.readouterr() == ("", "")


def test_foreign_json_is_held_to_the_same_rules(tmp_path: Path) -> None:
    path = tmp_path / "graph.json"
    data = {"directed": False, "multigraph": True, "graph": {"n": 1}, "nodes": [], "edges": []}
    path.write_text(json.dumps(data))
    assert repr(read_graph(path).graph) == "{'n': 1.0}"
    for wrong in ({"directed": True}, {"multigraph": False}, {"graph": {"n": None}}):
        path.write_text(json.dumps(data | wrong))
        with pytest.raises(ValueError, match=r"graph\.json does not hold a graph .* expected a"):
            read_graph(path)


@every_format
@pytest.mark.parametrize("step", ["open", "write", "fsync", "replace"])
@pytest.mark.parametrize("error", [OSError, KeyboardInterrupt])
def test_a_write_that_fails_keeps_the_old_file_and_leaves_no_other(
    suffix: str,
    step: str,
    error: type[BaseException],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    path = write_graph(small(), tmp_path / f"graph{suffix}")
    old = path.read_bytes()
    bigger = small()
    bigger.add_node("C")

    def fail(*_: object) -> None:
        raise error("half-way")

    class Half(io.FileIO):
        """A file of a disk that is full when half is written."""

        def write(self, content: bytes) -> int:  # type: ignore[override]
            super().write(content[: len(content) // 2])
            return fail()  # type: ignore[return-value]

    with monkeypatch.context() as patch:
        if step in ("open", "write"):
            half = fail if step == "open" else lambda file, mode: Half(file, mode)
            patch.setattr(Path, "open", half)
        else:
            patch.setattr(os, step, fail)
        with pytest.raises(error, match="half-way"):
            write_graph(bigger, path)
    assert path.read_bytes() == old
    assert list(tmp_path.iterdir()) == [path]
    write_graph(bigger, path)
    assert "C" in read_graph(path)


def test_a_folder_in_place_of_the_file_leaves_no_other(tmp_path: Path) -> None:
    (tmp_path / "graph.json").mkdir()
    with pytest.raises(OSError, match=r"graph\.json"):
        write_graph(small(), tmp_path / "graph.json")
    assert [path.name for path in tmp_path.iterdir()] == ["graph.json"]


def test_a_new_file_has_the_rights_of_any_new_file(tmp_path: Path) -> None:
    (tmp_path / "other").touch()
    path = write_graph(small(), tmp_path / "graph.json")
    assert stat.S_IMODE(path.stat().st_mode) == stat.S_IMODE((tmp_path / "other").stat().st_mode)
