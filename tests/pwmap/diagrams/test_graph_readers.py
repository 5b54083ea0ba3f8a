"""Files that are no graph of ours: one sentence, soon, whatever is in them."""

import contextlib
import subprocess
import sys
from pathlib import Path

import networkx as nx
import pytest
from hypothesis import given
from hypothesis import strategies as st
from thoroughness import thorough

from pwmap import read_graph, write_graph

SUFFIXES = (".graphml", ".gexf", ".json", ".dot")
NO_GRAPH = "does not hold a graph written by write_graph: "


def example() -> nx.MultiGraph:
    graph = nx.MultiGraph(title="t", low=0.5, odd=float("nan"))
    graph.add_node("A", x=1.0, id="q", text='a "b" \\ \n <c> &amp;')
    graph.add_node("B", x=-1e300)
    graph.add_edge("A", "B", key="b1", x=2.0)
    graph.add_edge("A", "B", key="b2", x=float("inf"), note="µ")
    graph.add_edge("B", "B", key="b1")
    return graph


def written(suffix: str, folder: Path) -> str:
    return write_graph(example(), folder / f"graph{suffix}").read_text(encoding="utf-8")


def refusal(content: str | bytes, suffix: str, folder: Path) -> str:
    path = folder / f"other{suffix}"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(ValueError, match=NO_GRAPH) as refused:
        read_graph(path)
    return str(refused.value)


def reason(sentence: str) -> str:
    """What a refusal says of the file; it must be one line that a person can read."""
    before, after = sentence.split(NO_GRAPH)
    assert Path(before.strip()).stem == "other"
    assert len(after.splitlines()) == 1
    assert len(after) <= 200
    return after


CHANGED = [
    (".json", '"id": "B"', '"id": "A"', "the node 'A' comes twice"),
    (".json", '"key": "b2"', '"key": "b1"', "the edge 'A B b1' comes twice"),
    (".json", '"title": "t"', '"title": "t", "title": "u"', "the name 'title' comes twice"),
    (".json", '"x": 1.0', '"x": 1.0, "x": 2.0', "the name 'x' comes twice"),
    (".graphml", 'node id="B"', 'node id="A"', "the node 'A' comes twice"),
    (".graphml", 'id="b2"', 'id="b1"', "the edge 'A B b1' comes twice"),
    (".graphml", '<node id="B">', '<node id="B"><data key="d3">2</data>', "attribute 'd3' comes"),
    (".graphml", 'id="d3"', 'id="d2"', "the key 'd2' comes twice"),
    (".gexf", 'node id="B"', 'node id="A"', "the node 'A' comes twice"),
    (".gexf", 'label="b2"', 'label="b1"', "the edge 'A B b1' comes twice"),
    (".gexf", '<attribute id="1"', '<attribute id="2"', "the attribute '2' comes twice"),
    (".dot", '"B" [', '"A" [', "the node 'A' comes twice"),
    (".dot", '"key"="b2"', '"key"="b1"', "the edge 'b1' comes twice"),
    (".dot", '"x"=1.0', '"x"=1.0, "x"=2.0', "the attribute 'x' comes twice"),
    (".dot", '"low"=0.5;', '"low"=0.5;"low"=0.5;', "the attribute 'low' comes twice"),
    (".graphml", '<node id="B">', '<node id="B"><port name="n" />', "it has ports"),
    (".graphml", 'attr.name="x" ', "", "has no name or no type"),
    (".graphml", 'attr.type="string"', "", "has no name or no type"),
    (".dot", "];\n}", "];\n} x", "it goes on after its last }"),
    (".dot", "];\n}", "];", "it ends too early"),
    (".dot", "graph {", "strict graph {", "it must begin with graph {"),
]  # fmt: skip


@pytest.mark.parametrize(("suffix", "old", "new", "message"), CHANGED)
def test_what_somebody_has_changed_is_named(
    suffix: str, old: str, new: str, message: str, tmp_path: Path
) -> None:
    """Nothing is guessed: the sentence says what is wrong."""
    text = written(suffix, tmp_path)
    assert old in text
    assert message in reason(refusal(text.replace(old, new), suffix, tmp_path))


@pytest.mark.slow
def test_types_of_documents_are_refused(tmp_path: Path) -> None:
    laughs = "".join(f'<!ENTITY l{i} "{f"&l{i - 1};" * 10}">' for i in range(1, 20))
    bomb = f'<!DOCTYPE graph [<!ENTITY l0 "ha">{laughs}]><graphml>&l19;</graphml>'
    external = '<!DOCTYPE graph SYSTEM "file:///etc/passwd"><graphml/>'
    for suffix in (".graphml", ".gexf"):
        for text in (bomb, external):
            for content in (text.encode(), ('<?xml version="1.0"?>' + text).encode("utf-16")):
                sentence = refusal(content, suffix, tmp_path)
                assert reason(sentence) == "it declares a type of document, graph"


DEEP = 100_000
XML_DEPTH, JSON_DEPTH = "it is nested more than 50 deep", "it is nested too deep"
NESTED = {
    "[" * DEEP: {".json": JSON_DEPTH},
    '{"a":' * DEEP: {".json": JSON_DEPTH},
    "<a>" * DEEP: {".graphml": XML_DEPTH, ".gexf": XML_DEPTH},
    "graph {" + "{" * DEEP: {".dot": "to float: '{'"},
    "graph {" + "subgraph {" * DEEP + "}" * DEEP: {".dot": "to float: 'subgraph'"},
    '"' * DEEP: {},
    'graph {"a" [' * DEEP: {".dot": "to float: 'graph'"},
    "(" * DEEP: {".dot": "unexpected '((("},
    "-" * DEEP: {},
}  # what else a format says of a text is that it is none of its own


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_deep_nesting_is_refused(suffix: str, tmp_path: Path) -> None:
    for text, reasons in NESTED.items():
        assert reasons.get(suffix, "") in reason(refusal(text, suffix, tmp_path))


def test_numbers_that_no_float_holds_are_refused(tmp_path: Path) -> None:
    large, none = "is too large for a float", "is no number of JSON"
    sentences = {"1e400": f"the number 1e400 {large}", "9" * 350: large, "9" * 5000: large}
    sentences |= {word: f"{word} {none}" for word in ("NaN", "-Infinity")}
    for number, sentence in sentences.items():
        text = written(".json", tmp_path).replace("0.5", number)
        assert sentence in reason(refusal(text, ".json", tmp_path))


@pytest.mark.parametrize("suffix", [".graphml", ".gexf"])
def test_integers_that_no_float_holds_are_refused(suffix: str, tmp_path: Path) -> None:
    graph = nx.MultiGraph()
    graph.add_node("A", x=8.25)
    text = write_graph(graph, tmp_path / f"graph{suffix}").read_text(encoding="utf-8")
    assert text.count("8.25") == text.count("double") == 1
    text = text.replace("double", "long")
    for digits, message in ((350, "attribute x: the number is too large"), (5000, "5000 digits")):
        sentence = refusal(text.replace("8.25", "9" * digits), suffix, tmp_path)
        assert message in reason(sentence)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_bytes_that_are_no_text_are_refused(suffix: str, tmp_path: Path) -> None:
    text = written(suffix, tmp_path)
    xml = suffix in (".graphml", ".gexf")
    message = "not well-formed" if xml else "can't decode byte 0xff"
    for content in (b"\xff" + text.encode(), text.replace("t", "\xff").encode("latin1")):
        assert message in reason(refusal(content, suffix, tmp_path))
    nothing = {".json": "Expecting value", ".dot": r"unexpected '\x00'"}.get(suffix, "line 1")
    assert nothing in reason(refusal(b"\0", suffix, tmp_path))


@pytest.mark.nightly
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_mutated_files_are_graphs_or_refused(
    suffix: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.mktemp("graphs")
    content = written(suffix, folder).encode()
    path = folder / f"other{suffix}"

    @thorough(150)
    @given(st.data())
    def check(data: st.DataObject) -> None:
        changed = content
        for _ in range(data.draw(st.integers(1, 3))):
            start = data.draw(st.integers(0, len(changed)))
            stop = data.draw(st.integers(start, min(len(changed), start + 20)))
            bits = st.sampled_from([b"", b'"', b"<", b">", b"{", b"}", b"[", b"9" * 400, b"&"])
            other = data.draw(bits | st.binary(max_size=4) | st.just(changed[start:stop] * 2))
            changed = changed[:start] + other + changed[stop:]
        path.write_bytes(changed)
        with contextlib.suppress(ValueError):
            graph = read_graph(path)
            write_graph(graph, path)
            assert nx.utils.graphs_equal(read_graph(path), graph) or "nan" in repr(
                graph.nodes.data()
            )

    check()
    assert {p.name for p in folder.iterdir()} == {f"graph{suffix}", f"other{suffix}"}


PEAK = """
from pwmap import read_graph
def peak():
    with open("/proc/self/status") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmHWM"))
before = peak()
try:
    read_graph({path!r})
except ValueError as error:
    print(peak() - before, error)
"""


@pytest.mark.nightly
@pytest.mark.skipif(sys.platform != "linux", reason="asks /proc how much memory was taken")
@pytest.mark.parametrize("text", ["a", r"\n"])
def test_a_quote_that_is_not_closed_takes_no_memory(text: str, tmp_path: Path) -> None:
    """A pattern that remembers where it could begin anew takes a hundred times the text."""
    path = tmp_path / "g.dot"
    path.write_text('graph {\n"' + text * (4_000_000 // len(text)), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", PEAK.format(path=str(path))], capture_output=True, text=True,
        check=True,
    )  # fmt: skip
    taken, sentence = done.stdout.split(" ", 1)
    assert "does not hold a graph written by write_graph: unexpected" in sentence
    assert int(taken) < 40_000  # kB: bytes, text, and what Python keeps free
