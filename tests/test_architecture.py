"""Who imports whom: one order of files and folders without cycles, and no tool code in the core."""

import ast
import subprocess
import sys
from pathlib import Path

import networkx as nx
import pytest

ROOT = Path(__file__).parents[1]
DRAWING = ("pwmap.plot", "pwmap.cli", "woodpecker.plot", "woodpecker.cli")


def imports(package: str) -> nx.DiGraph:
    """Files of a package and what they import of this project, also inside functions."""
    graph = nx.DiGraph()
    for path in sorted((ROOT / package).rglob("*.py")):
        module = name_of(path)
        graph.add_node(module)
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                graph.add_edges_from((module, alias.name) for alias in node.names)
            elif isinstance(node, ast.ImportFrom) and node.module is not None:
                parts = [f"{node.module}.{alias.name}" for alias in node.names]
                files = [part for part in parts if is_file(part)]
                graph.add_edges_from((module, target) for target in files or [node.module])
    return graph


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
    return ".".join(parts[:2]) if parts[0] in ("pwmap", "woodpecker") else module


@pytest.mark.parametrize("package", ["pwmap", "woodpecker"])
def test_imports_have_no_cycle(package: str) -> None:
    graph = imports(package)
    assert nx.is_directed_acyclic_graph(graph), nx.find_cycle(graph)


@pytest.mark.parametrize("package", ["pwmap", "woodpecker"])
def test_folders_have_no_cycle(package: str) -> None:
    arrows = {(folder_of(a), folder_of(b)) for a, b in imports(package).edges}
    graph = nx.DiGraph([(a, b) for a, b in arrows if a != b and b.startswith(package)])
    assert nx.is_directed_acyclic_graph(graph), nx.find_cycle(graph)


def test_pwmap_knows_nothing_of_the_toy() -> None:
    targets = {target for _, target in imports("pwmap").edges}
    assert not [target for target in targets if target.startswith("woodpecker")]


def test_maps_of_the_line_know_nothing_of_the_toy() -> None:
    folder = "woodpecker.piecewise"
    for module, target in imports("woodpecker").edges:
        if module.startswith(folder) and target.startswith("woodpecker"):
            assert target.startswith((folder, "woodpecker.base")), (module, target)


def test_mechanics_knows_no_map() -> None:
    for module, target in imports("woodpecker").edges:
        if module.startswith("woodpecker.mechanics") and target.startswith("woodpecker"):
            assert target.startswith(("woodpecker.mechanics", "woodpecker.base")), (module, target)


def test_importing_loads_neither_matplotlib_nor_the_command_line() -> None:
    code = "import sys, pwmap, woodpecker; print(*sorted(sys.modules))"
    loaded = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout.split()
    assert not {"matplotlib", "typer", "rich"} & set(loaded)


def test_only_drawing_files_import_matplotlib() -> None:
    for package in ("pwmap", "woodpecker"):
        for module, target in imports(package).edges:
            if target.startswith("matplotlib"):
                assert module.startswith(DRAWING), module
