r"""Graphs to and from files without loss: GraphML, GEXF, JSON node-link and DOT.

Every format holds the graph of :func:`sanitised`; networkx writes and reads the first three.

- An attribute with a name that the format reserves (``id``), or in GEXF with values of two types,
  is stored under its name and type, as ``id:float`` or ``id:str``; no other name has a colon.
- GraphML: the edge key is the id of the edge. Without parallel edges ``nx.read_graphml`` gives a
  plain graph with the key as attribute ``id``, unless ``force_multigraph=True``.
- GEXF: the edge key is the label of the edge; graph attributes are its name, as JSON.
- JSON: nan and infinities are ``{"$numberDouble": "NaN"}``, as in MongoDB's Extended JSON.
- DOT: text is quoted with ``\"``, ``\\``, ``\n`` and ``\r``; numbers have no exponent, or are
  ``nan``, ``inf`` and ``minus_inf``; the edge key is ``key``.
"""

from __future__ import annotations

import inspect
import io
import json
import math
import numbers
import re
import reprlib
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from decimal import Decimal
from enum import Enum
from itertools import repeat
from pathlib import Path
from typing import Any

import networkx as nx
import numpy as np

from pwmap.algebra.arguments import checked_path, shortened
from pwmap.diagrams.files import write_whole

Attributes = dict[str, Any]
Encode = Callable[[nx.MultiGraph], bytes]
Decode = Callable[[bytes], nx.MultiGraph]

MAX_DEPTH = 50  # of nested elements in an XML file
MAX_DIGITS = 400  # characters of a number in JSON: the largest float has 309 digits

_NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")  # XML 1.0, Char
_HINT = (
    "<!-- networkx.read_graphml(path, force_multigraph=True) reads it with the keys of edges -->\n"
)
_DOT_WORDS = {"nan": "nan", "inf": "inf", "-inf": "minus_inf"}  # -inf is no word of DOT
_DOT_ESCAPES = str.maketrans({'"': r"\"", "\\": r"\\", "\n": r"\n", "\r": r"\r"})
_DOT_TOKEN = re.compile(
    r'\s+|"(?:[^"\\]++|\\["\\nr])*+"|--|[][{}=,;]|-?[A-Za-z0-9_.]+|(?P<other>.)'
)
_DOT_UNESCAPES = {'"': '"', "\\": "\\", "n": "\n", "r": "\r"}
# networkx < 3.4 calls the edges of node-link data "link" and lacks the keyword "edges"
_EDGES = "edges" if "edges" in inspect.signature(nx.node_link_data).parameters else "link"


def sanitised(graph: nx.MultiGraph) -> nx.MultiGraph:
    """Copy a graph with attributes reduced to floats and text, which every format keeps.

    TypeError or ValueError unless ids of nodes and keys of edges are non-empty text without ``:``,
    names of attributes identifiers, and values numbers, text of XML 1.0, or enums of these.
    """
    _check_kind(graph)
    copy = nx.MultiGraph()
    copy.graph.update(_plain_attributes(graph.graph, "the graph"))
    for node, data in graph.nodes(data=True):
        name = _identifier(node, "the id of a node")
        copy.add_nodes_from([(name, _plain_attributes(data, f"node {name!r}"))])
    for u, v, key, data in graph.edges(keys=True, data=True):
        key_of = f"between {u!r} and {v!r}"
        name = _identifier(key, f"the key of an edge {key_of}")
        clean = _plain_attributes(data, f"edge {name!r} {key_of}")
        copy.add_edges_from([(str.__str__(u), str.__str__(v), name, clean)])
    return copy


def write_graph(graph: nx.MultiGraph, path: str | Path) -> Path:
    """Write a graph in the format of the suffix: .graphml, .gexf, .json, .dot or .gv.

    The file is written whole or not at all. networkx keeps the keys of edges by
    ``read_graphml(path, force_multigraph=True)``.

    Parameters
    ----------
    graph
        An undirected multigraph such as ``diagram.graph()``, whose ids and keys are text without
        ``:`` and whose attributes are numbers or text.
    path
        The file, in a folder that exists.

    Returns
    -------
    pathlib.Path
        The path.

    Raises
    ------
    TypeError, ValueError, FileNotFoundError
        If the graph does not suit the formats, the suffix is unknown, or there is no such folder.

    Examples
    --------
    >>> import networkx as nx
    >>> from pwmap import write_graph
    >>> write_graph(nx.MultiGraph([("A", "B", "F1", {"x": 0.1})]), "lines.graphml").name
    'lines.graphml'
    """
    path = checked_path(path)
    write_whole(path, graph_as_bytes(graph, path))
    return path


def graph_as_bytes(graph: nx.MultiGraph, path: Path) -> bytes:
    """The bytes that :func:`write_graph` writes into a file of this name."""
    encode, _, taken = _format(path)
    return encode(_changed(sanitised(graph), lambda data: _typed_names(data, taken)))


def read_graph(path: str | Path) -> nx.MultiGraph:
    """Read a graph that :func:`write_graph` wrote.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    networkx.MultiGraph
        With nodes, keyed edges and attributes as they were written, in their order.

    Raises
    ------
    ValueError, FileNotFoundError
        If the suffix is unknown, the file holds no such graph, or is not there.

    Examples
    --------
    >>> import networkx as nx
    >>> from pwmap import read_graph, write_graph
    >>> graph = nx.MultiGraph([("A", "B", "F1", {"x": 0.1})])
    >>> read_graph(write_graph(graph, "lines.json")).edges["A", "B", "F1"]
    {'x': 0.1}
    """
    path = checked_path(path)
    _, decode, _ = _format(path)
    content = path.read_bytes()
    try:
        return sanitised(_changed(decode(content), _plain_names))
    except RecursionError:
        reason = "it is nested too deep"
    except (
        *(ArithmeticError, AttributeError, LookupError, SyntaxError, TypeError, ValueError),
        *(RuntimeError, nx.NetworkXError),  # a bare "raise" in networkx is a RuntimeError
    ) as error:
        reason = shortened(" ".join(str(error).split()), 200)
    raise ValueError(f"{path} does not hold a graph written by write_graph: {reason}")


def _check_kind(graph: object) -> None:
    if not isinstance(graph, nx.MultiGraph) or graph.is_directed():
        raise TypeError(f"expected an undirected networkx.MultiGraph, got {type(graph).__name__}")


def _identifier(value: object, where: str) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{where} must be text, got {value!r}")
    if not value or ":" in value:
        raise ValueError(f"{where} must be non-empty text without ':', got {value!r}")
    return _text(value, where)


def _text(value: str, where: str) -> str:
    if bad := _NOT_XML.search(value):
        raise ValueError(f"{where} holds U+{ord(bad[0]):04X}, which XML 1.0 cannot: {value!r}")
    return str.__str__(value)  # a plain str, also from a subclass


def _plain_attributes(data: Mapping[object, object], where: str) -> Attributes:
    for name in data:
        if not isinstance(name, str) or not name.isidentifier():
            raise ValueError(f"{where}: the name of an attribute must be an identifier: {name!r}")
    return {
        str.__str__(name): _plain(value, f"{where}, attribute {name}")
        for name, value in data.items()
    }


def _plain(value: object, where: str) -> float | str:
    if isinstance(value, Enum):
        value = value.value
    if isinstance(value, str):
        return _text(value, where)
    if not isinstance(value, numbers.Real | np.bool_):
        raise TypeError(f"{where}: expected a number or text, got {reprlib.repr(value)}")
    try:
        number = float(value)
    except OverflowError as error:
        raise ValueError(f"{where}: the number is too large for a float") from error
    return math.nan if math.isnan(number) else number  # one nan, without sign or payload


def _changed(graph: nx.MultiGraph, change: Callable[[Attributes], Attributes]) -> nx.MultiGraph:
    """The same graph, with its attributes changed."""
    for data in (graph.graph, *graph.nodes.values(), *graph.edges.values()):
        changed = change(data)
        data.clear()
        data.update(changed)
    return graph


def _typed_names(data: Attributes, names: Set[str]) -> Attributes:
    return {
        f"{name}:{type(value).__name__}" if name in names else name: value
        for name, value in data.items()
    }


def _plain_names(data: Attributes) -> Attributes:
    return {name.partition(":")[0]: value for name, value in data.items()}


def _of_two_types(table: Iterable[Attributes]) -> set[str]:
    columns = {(name, type(value)) for data in table for name, value in data.items()}
    return {name for name, count in Counter(name for name, _ in columns).items() if count == 2}


def _to_graphml(graph: nx.MultiGraph) -> bytes:
    file = io.BytesIO()
    nx.write_graphml_xml(graph, file)
    head, end, rest = file.getvalue().partition(b"?>\n")
    content = head + end + _HINT.encode() + rest
    return content.replace(b"\r", b"&#13;")  # XML reads a bare one as \n


class _Bounded:
    """Builds the tree of an XML file of bounded depth; refuses document types (with entities)."""

    def __init__(self) -> None:
        self._builder = ET.TreeBuilder()
        self._depth = 0
        self.data, self.close = self._builder.data, self._builder.close

    def doctype(self, name: str, *_: object) -> None:
        raise ValueError(f"it declares a type of document, {name}")

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise ValueError(f"it is nested more than {MAX_DEPTH} deep")
        self._builder.start(tag, attributes)

    def end(self, tag: str) -> None:
        self._depth -= 1
        self._builder.end(tag)


def _xml(content: bytes, attribute: tuple[str, str], edge_key: str) -> ET.Element:
    """The root of an XML file; ValueError if a node, edge or attribute comes twice."""
    root = ET.fromstring(content, ET.XMLParser(target=_Bounded()))
    _once((node.get("id") for node in root.iterfind(".//{*}node")), "the node")
    edges = root.iterfind(".//{*}edge")
    _once(((*_ends(edge), edge.get(edge_key)) for edge in edges), "the edge")
    _once((key.get("id") for key in root.iterfind(".//{*}key")), "the key")
    for table in root.iterfind(".//{*}attributes"):
        _once((entry.get("id") for entry in table), "the attribute")
    tag, name = attribute
    for parent in root.iter():
        _once((entry.get(name) for entry in parent.iterfind(f"{{*}}{tag}")), "the attribute")
    return root


def _ends(edge: ET.Element) -> list[str]:
    return sorted([edge.get("source", ""), edge.get("target", "")])


def _once(names: Iterable[Any], what: str) -> None:
    """ValueError for a name that comes twice: the second would silently replace the first."""
    for name, count in Counter(names).items():
        _check_new(name, what, known=count > 1)


def _check_new(name: Any, what: str, *, known: bool) -> None:
    if known:
        shown = name if isinstance(name, str) else " ".join(map(str, name))
        raise ValueError(f"{what} {shown!r} comes twice")


def _from_graphml(content: bytes) -> nx.MultiGraph:
    root = _xml(content, ("data", "key"), "id")
    for key in root.iterfind(".//{*}key"):
        if key.get("attr.type") is None or key.get("attr.name") is None:
            raise ValueError(f"the key {shortened(str(key.get('id')))} has no name or no type")
    if root.find(".//{*}port") is not None:
        raise ValueError("it has ports, which are not read")
    for data in root.iterfind(".//{*}data"):
        data.text = data.text or ""  # networkx < 3.3 skips attributes without text
    reader = nx.GraphMLReader(edge_key_type=str, force_multigraph=True)
    graph = reader.make_graph(root.find("{*}graph"), *reader.find_graphml_keys(root))
    del graph.graph["node_default"], graph.graph["edge_default"]
    return graph


def _to_gexf(graph: nx.MultiGraph) -> bytes:
    mixed = _of_two_types(graph.nodes.values()) | _of_two_types(graph.edges.values())
    name = json.dumps(_tagged(graph.graph), allow_nan=False)
    _changed(graph, lambda data: _typed_names(data, mixed)).graph = {"name": name}
    for _, _, key, data in graph.edges(keys=True, data=True):
        data["label"] = key
    file = io.BytesIO()
    nx.write_gexf(graph, file)
    return file.getvalue()


def _from_gexf(content: bytes) -> nx.MultiGraph:
    _xml(content, ("attvalue", "for"), "label")
    read = nx.read_gexf(io.BytesIO(content))  # a plain Graph if no edges are parallel
    graph = nx.MultiGraph()
    graph.graph.update(_from_text(read.graph["name"]))
    for node, data in read.nodes(data=True):
        del data["label"]
        graph.add_nodes_from([(node, data)])
    for u, v, data in read.edges(data=True):
        del data["id"]
        graph.add_edges_from([(u, v, data.pop("label"), data)])
    return graph


def _tagged(data: Attributes) -> Attributes:
    return {
        name: value
        if isinstance(value, str) or math.isfinite(value)
        else {"$numberDouble": json.dumps(value)}
        for name, value in data.items()
    }


def _untagged(pairs: Sequence[tuple[str, Any]]) -> Attributes | float:
    _once((name for name, _ in pairs), "the name")
    data = dict(pairs)
    return float(data["$numberDouble"]) if "$numberDouble" in data else data


def _to_json(graph: nx.MultiGraph) -> bytes:
    data = nx.node_link_data(_changed(graph, _tagged), **{_EDGES: "edges"})
    return json.dumps(data, allow_nan=False, ensure_ascii=False, indent=1).encode()


def _from_text(text: str) -> Any:
    """Parse JSON; ValueError for names that come twice and numbers too large for a float."""
    return json.loads(
        text,
        object_pairs_hook=_untagged,
        parse_int=_finite,
        parse_float=_finite,
        parse_constant=_no_number,
    )


def _finite(text: str) -> float:
    if len(text) > MAX_DIGITS or not math.isfinite(float(text)):
        raise ValueError(f"the number {shortened(text)} is too large for a float")
    return float(text)


def _no_number(text: str) -> float:
    raise ValueError(f"{text} is no number of JSON")


def _from_json(content: bytes) -> nx.MultiGraph:
    data = _from_text(content.decode())
    _once((node["id"] for node in data["nodes"]), "the node")
    edges = data["edges"]
    _once(((*sorted((e["source"], e["target"])), e["key"]) for e in edges), "the edge")
    return nx.node_link_graph(data, **{_EDGES: "edges"})


def _to_dot(graph: nx.MultiGraph) -> bytes:
    # pydot guesses from a text whether to quote it ("<b>" would become markup), does not escape
    # backslashes and reads by recursion, so the few statements are written and read here.
    lines = [f"{_dot(name)}={_dot(value)};" for name, value in graph.graph.items()]
    lines += [f"{_dot(node)} {_dot_list(data)};" for node, data in graph.nodes(data=True)]
    lines += [
        f"{_dot(u)} -- {_dot(v)} {_dot_list({'key': key, **data})};"
        for u, v, key, data in graph.edges(keys=True, data=True)
    ]
    return "\n".join(["graph {", *lines, "}", ""]).encode()


def _dot_list(data: Attributes) -> str:
    return f"[{', '.join(f'{_dot(name)}={_dot(value)}' for name, value in data.items())}]"


def _dot(value: float | str) -> str:
    if isinstance(value, str):
        return f'"{value.translate(_DOT_ESCAPES)}"'
    return f"{Decimal(repr(value)):f}" if math.isfinite(value) else _DOT_WORDS[repr(value)]


def _undot(token: str) -> Any:
    if token.startswith('"'):
        return re.sub(r"\\(.)", lambda found: _DOT_UNESCAPES[found[1]], token[1:-1])
    return float(token.replace("minus_", "-"))


def _from_dot(content: bytes) -> nx.MultiGraph:
    """Read the statements that :func:`_to_dot` writes, in any layout, and no others."""
    tokens = _dot_tokens(content.decode())
    if [next(tokens), next(tokens)] != ["graph", "{"]:
        raise ValueError("it must begin with graph {")
    graph = nx.MultiGraph()
    for token in tokens:
        if token == "}":
            if next(tokens) != "":
                raise ValueError("it goes on after its last }")
            return graph
        if token == "":
            break
        name, sign = _undot(token), next(tokens)
        if sign == "=":
            _check_new(name, "the attribute", known=name in graph.graph)
            graph.graph[name] = _undot(next(tokens))
        elif sign == "[":
            _check_new(name, "the node", known=name in graph)
            graph.add_nodes_from([(name, _dot_attributes(tokens))])
        elif sign == "--":
            other = _undot(next(tokens))
            _expect(tokens, "[")
            data = _dot_attributes(tokens)
            key = data.pop("key")
            _check_new(key, "the edge", known=graph.has_edge(name, other, key))
            graph.add_edges_from([(name, other, key, data)])
        else:
            raise ValueError(f"unexpected {shortened(sign)!r} after {shortened(token)}")
        _expect(tokens, ";")
    raise ValueError("it ends too early")


def _dot_tokens(text: str) -> Iterator[str]:
    """Signs, words and quoted texts; "" at the end."""
    for found in _DOT_TOKEN.finditer(text):
        if found["other"]:
            raise ValueError(f"unexpected {shortened(text[found.start() :][:40])!r}")
        if not found[0].isspace():
            yield found[0]
    yield from repeat("")


def _dot_attributes(tokens: Iterator[str]) -> Attributes:
    """A list of attributes, from behind its opening bracket."""
    data: Attributes = {}
    while (token := next(tokens)) != "]":
        if data:
            if token != ",":
                raise ValueError(f"unexpected {shortened(token)!r} in a list of attributes")
            token = next(tokens)
        name = _undot(token)
        _check_new(name, "the attribute", known=name in data)
        _expect(tokens, "=")
        data[name] = _undot(next(tokens))
    return data


def _expect(tokens: Iterator[str], sign: str) -> None:
    token = next(tokens)
    if token != sign:
        raise ValueError(f"expected {sign}, got {shortened(token)!r}")


_ARGUMENTS = {"self", "node_for_adding", "u_for_edge", "v_for_edge", "key"}  # of networkx's methods
_GRAPHML = {"id", "node_default", "edge_default"}
_GEXF = {"networkx_key", "id", "label", "type", "weight"}
_GEXF |= {"start", "end", "pid", "parents", "spells", "viz"}
_DOT = (_to_dot, _from_dot, {"key"})
# how to write and read each format, and the names of attributes that networkx reserves in it
_FORMATS: dict[str, tuple[Encode, Decode, set[str]]] = {
    ".graphml": (_to_graphml, _from_graphml, _ARGUMENTS | _GRAPHML),
    ".gexf": (_to_gexf, _from_gexf, _ARGUMENTS | _GEXF),
    ".json": (_to_json, _from_json, _ARGUMENTS | {"id", "source", "target"}),
    ".dot": _DOT,
    ".gv": _DOT,
}


def _format(path: Path) -> tuple[Encode, Decode, set[str]]:
    if path.suffix.lower() not in _FORMATS:
        known = ", ".join(_FORMATS)
        raise ValueError(f"unknown suffix {path.suffix!r} of {path}; known are {known}")
    return _FORMATS[path.suffix.lower()]
