"""Who imports whom: one order of files and folders without cycles, and no tool code in the core."""

import ast
import re
import sys
from collections import Counter
from dataclasses import fields
from functools import cache
from pathlib import Path

import networkx as nx
import pytest

from woodpecker import Settings

ROOT = Path(__file__).parents[1]
PACKAGES = ("pwmap", "woodpecker", "studies")
DRAWING = ("pwmap.plot", "pwmap.cli", "woodpecker.plot", "woodpecker.cli")


@cache
def imports(package: str) -> nx.DiGraph:
    """Files of a package and what they import of this project, also by ``import_module``.

    The public names of a package are imported by its stub, when they are used.
    """
    graph = nx.DiGraph()
    folder = ROOT / package
    for path in sorted([*folder.rglob("*.py"), *folder.rglob("*.pyi")]):
        module = name_of(path)
        graph.add_node(module)
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                graph.add_edges_from((module, alias.name) for alias in node.names)
            elif isinstance(node, ast.ImportFrom) and node.module is not None:
                source = f"{module}.{node.module}" if node.level else node.module  # of a package
                parts = [f"{source}.{alias.name}" for alias in node.names]
                files = [part for part in parts if is_file(part)]
                graph.add_edges_from((module, target) for target in files or [source])
            elif isinstance(node, ast.Call) and "import_module" in ast.unparse(node.func):
                graph.add_edges_from((module, a.value) for a in node.args if is_text(a))
    return graph


def is_text(node: ast.expr) -> bool:
    """Whether an argument is written out."""
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def name_of(path: Path) -> str:
    """``package.folder.file`` of a file, ``package.folder`` of its ``__init__``."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def is_file(module: str) -> bool:
    """Whether a dotted name is a file of this project."""
    return (ROOT / (module.replace(".", "/") + ".py")).exists()


def folder_of(module: str) -> str:
    """The folder of a file; files that lie in none stand for themselves."""
    parts = module.split(".")
    return ".".join(parts[:2]) if parts[0] in PACKAGES else module


@pytest.mark.slow
@pytest.mark.parametrize("package", PACKAGES)
def test_imports_have_no_cycle(package: str) -> None:
    graph = imports(package)
    assert nx.is_directed_acyclic_graph(graph), nx.find_cycle(graph)


@pytest.mark.parametrize("package", PACKAGES)
def test_folders_have_no_cycle(package: str) -> None:
    arrows = {(folder_of(a), folder_of(b)) for a, b in imports(package).edges}
    graph = nx.DiGraph([(a, b) for a, b in arrows if a != b and b.startswith(package)])
    assert nx.is_directed_acyclic_graph(graph), nx.find_cycle(graph)


MOST = 15  # files of a folder
HIGHEST = 8  # floors of a folder: files of which each imports the next


@pytest.mark.parametrize("package", PACKAGES)
def test_folders_are_small_and_low(package: str) -> None:
    """Without their ``__init__``; floors are counted along the longest chain of imports inside."""
    graph = imports(package)
    rooms: dict[str, list[str]] = {}
    for module in graph:
        if module.startswith(f"{package}.") and is_file(module):
            rooms.setdefault(module.rpartition(".")[0], []).append(module)
    floors = {
        room: nx.dag_longest_path_length(graph.subgraph(files)) + 1 for room, files in rooms.items()
    }
    assert {room: len(files) for room, files in rooms.items() if len(files) > MOST} == {}
    assert [room for room, high in floors.items() if high > HIGHEST] == []


FLOORS = [f"woodpecker.{each}" for each in ("base", "maps", "engine", "slices", "search")]
MAY_IMPORT = [  # files, what is asked of their imports, and which of these are all right
    ("pwmap", "woodpecker", []),
    *(("pwmap.diagrams", f"pwmap.{each}", []) for each in ("plot", "cli", "explore")),
    ("woodpecker.mechanics", "woodpecker", ["woodpecker.mechanics", "woodpecker.base"]),
    # Maps of any origin stand on floors, and none of them knows a simulation.
    *((floor, "woodpecker", FLOORS[: k + 1]) for k, floor in enumerate(FLOORS)),
]


@pytest.mark.parametrize(("files", "asked", "allowed"), MAY_IMPORT)
def test_files_import_what_they_may(files: str, asked: str, allowed: list[str]) -> None:
    package, _, _ = files.partition(".")
    for module, target in imports(package).edges:
        if module.startswith(files) and target.startswith(asked):
            assert folder_of(target) in allowed, (module, target)


@pytest.mark.parametrize("package", ["pwmap", "woodpecker"])
def test_the_page_of_the_parts_says_who_imports_whom(package: str) -> None:
    """Each folder in a row, with those that it imports, which stand above it; verbs are files."""
    page = (ROOT / "docs" / "theory" / "parts.md").read_text(encoding="utf-8")
    table = page.partition(f"## {package}\n")[2].partition("\n## ")[0]
    said = dict[str, set[str]]()
    for row in re.findall(r"^\| (`?\w+`?) \|.*\|(.*)\|$", table, re.MULTILINE):
        name, others = row[0].strip("`"), set(re.findall(r"\w+", row[1]))
        assert others <= said.keys() or name == "folder"
        said[name] = others
    del said["folder"]

    def room(module: str) -> str:
        _, _, place = folder_of(module).partition(".")
        return place if (ROOT / package / place).is_dir() and place else "verbs"

    found = {name: set[str]() for name in said}
    for source, target in imports(package).edges:
        own = target.startswith(package) and target != f"{package}.version"
        if own and room(source) != room(target):
            found.setdefault(room(source), set()).add(room(target))
    for name, others in said.items():
        known = found[name] & said.keys()
        assert known == others or (name == "verbs" and others < known), name
    assert found.keys() - {"verbs"} == said.keys() - {"verbs"}


@pytest.mark.parametrize(
    ("package", "others"), [("pwmap", ()), ("woodpecker", ("mpmath", "pwmap.checking"))]
)
def test_checkers_stand_alone(package: str, others: tuple[str, ...]) -> None:
    """On the standard library; of those who prove only the verbs of both sides import them."""
    checker = f"{package}.checking"
    for source, target in imports(package).edges:
        top, _, _ = target.partition(".")
        if source.startswith(checker):
            assert target.startswith((checker, *others)) or top in sys.stdlib_module_names
        if source.startswith("woodpecker.proofs") and source != "woodpecker.proofs.proving":
            assert "checking" not in target.split(".")


def test_only_drawing_files_import_matplotlib() -> None:
    for package in ("pwmap", "woodpecker"):
        for module, target in imports(package).edges:
            if target.startswith("matplotlib"):
                assert module.startswith(DRAWING), module


@pytest.mark.slow
def test_a_class_name_stands_for_one_thing() -> None:
    names = Counter(
        node.name
        for package in ("pwmap", "woodpecker")
        for path in (ROOT / package).rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ClassDef)
    )
    assert {name for name, count in names.items() if count > 1} == set()


# --- Numbers that decide results ------------------------------------------------------------------

WOODPECKER = ROOT / "woodpecker"
OF_MAPS = [
    *(path for each in ("maps", "slices", "search") for path in (WOODPECKER / each).glob("*.py")),
    WOODPECKER / "base" / "settings.py",
]
PLAIN = {0.0, 0.5, 1.0, 2.0, 3.0, 4.0}  # signs, halves, and the coefficients of cubics


def constants(path: Path) -> dict[str, int]:
    """Names that are given to numbers alone at the top of a file, each with its line."""
    found = {}
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
            leaves = [each for each in ast.walk(node.value) if isinstance(each, ast.Constant)]
            inside = [each for each in ast.walk(node.value) if isinstance(each, ast.Lambda)]
            if leaves and not inside and all(type(leaf.value) in (int, float) for leaf in leaves):
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                names = [each.id for target in targets for each in ast.walk(target)
                         if isinstance(each, ast.Name)]  # fmt: skip
                found.update(dict.fromkeys(names, node.lineno))
    return found


def bare_numbers(tree: ast.Module) -> list[tuple[int, float]]:
    """Lines and values of numbers in the bodies of functions, but for plain ones."""
    bodies = [
        statement
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef)
        for statement in node.body
    ]
    leaves = {each for body in bodies for each in ast.walk(body) if isinstance(each, ast.Constant)}
    return [
        (leaf.lineno, leaf.value)
        for leaf in leaves
        if type(leaf.value) in (int, float) and leaf.value not in PLAIN
    ]


@pytest.mark.slow
def test_functions_hold_no_bare_numbers() -> None:
    for path in OF_MAPS:
        if path.stem != "settings":
            assert bare_numbers(ast.parse(path.read_text(encoding="utf-8"))) == [], path.name


def test_every_constant_has_its_reason_beside_it() -> None:
    for path in OF_MAPS:
        lines = path.read_text(encoding="utf-8").splitlines()
        for name, line in constants(path).items():
            beside = "  # " in lines[line - 1] or lines[line - 2].startswith("# ")
            assert beside, f"{path.name}: {name}"


def test_no_constant_has_two_meanings() -> None:
    """Whatever has a name in ``engine`` too is imported from there."""
    names = Counter(name for path in OF_MAPS
                    for name in constants(path))  # fmt: skip
    below = {name for path in (WOODPECKER / "engine").glob("*.py") for name in constants(path)}
    assert [name for name, count in names.items() if count > 1] == []
    assert set(names) & below == set()


def test_every_setting_is_read() -> None:
    """Where settings are at hand, or by a property of theirs, but not by their own checks alone."""
    text = "".join(path.read_text(encoding="utf-8") for path in WOODPECKER.rglob("*.py"))
    derived = (WOODPECKER / "base" / "settings.py").read_text(encoding="utf-8")
    used = {
        *re.findall(r"\b(?:settings|plane\.first)\.([a-z_]+)", text),
        *re.findall(r"\bself\.([a-z_]+)", derived.partition("@property")[2]),
    }
    assert {each.name for each in fields(Settings)} - used == set()
