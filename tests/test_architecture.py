"""Who imports whom: one order of files without cycles, and no tool code in the core."""

import ast
import subprocess
import sys
from pathlib import Path

import networkx as nx
import pytest

ROOT = Path(__file__).parents[1]


def imports(package: str) -> nx.DiGraph:
    """Files of a package and what they import of this project, also inside functions."""
    graph = nx.DiGraph()
    for path in sorted((ROOT / package).glob("*.py")):
        module = f"{package}.{path.stem}"
        graph.add_node(module)
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                graph.add_edges_from((module, alias.name) for alias in node.names)
            elif isinstance(node, ast.ImportFrom) and node.module is not None:
                parts = [f"{node.module}.{alias.name}" for alias in node.names]
                files = [
                    part for part in parts if (ROOT / (part.replace(".", "/") + ".py")).exists()
                ]
                graph.add_edges_from((module, target) for target in files or [node.module])
    return graph


@pytest.mark.parametrize("package", ["pwmap", "woodpecker"])
def test_imports_have_no_cycle(package: str) -> None:
    graph = imports(package)
    assert nx.is_directed_acyclic_graph(graph), nx.find_cycle(graph)


def test_pwmap_knows_nothing_of_the_toy() -> None:
    targets = {target for _, target in imports("pwmap").edges}
    assert not [target for target in targets if target.startswith("woodpecker")]


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
                assert module.endswith((".plot", ".drawing", ".cli")), module
