"""Who imports whom: one order of files and folders without cycles, and no tool code in the core."""

import ast
import re
from dataclasses import fields
from functools import cache
from pathlib import Path

import networkx as nx
import pytest

from woodpecker import Numerics

ROOT = Path(__file__).parents[1]
PACKAGES = ("pwmap", "woodpecker", "studies")
DRAWING = ("pwmap.plot", "pwmap.cli", "woodpecker.plot", "woodpecker.cli")


@cache
def imports(package: str) -> nx.DiGraph:
    """Files of a package and what they import of this project, also inside functions.

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
    return ".".join(parts[:2]) if parts[0] in PACKAGES else module


@pytest.mark.parametrize("package", PACKAGES)
def test_imports_have_no_cycle(package: str) -> None:
    graph = imports(package)
    assert nx.is_directed_acyclic_graph(graph), nx.find_cycle(graph)


@pytest.mark.parametrize("package", PACKAGES)
def test_folders_have_no_cycle(package: str) -> None:
    arrows = {(folder_of(a), folder_of(b)) for a, b in imports(package).edges}
    graph = nx.DiGraph([(a, b) for a, b in arrows if a != b and b.startswith(package)])
    assert nx.is_directed_acyclic_graph(graph), nx.find_cycle(graph)


def test_pwmap_knows_nothing_of_the_toy() -> None:
    targets = {target for _, target in imports("pwmap").edges}
    assert not [target for target in targets if target.startswith("woodpecker")]


@pytest.mark.parametrize("folder", ["woodpecker.piecewise", "woodpecker.engine"])
def test_maps_know_nothing_of_the_toy(folder: str) -> None:
    for module, target in imports("woodpecker").edges:
        if module.startswith(folder) and target.startswith("woodpecker"):
            below = (folder, "woodpecker.base", "woodpecker.engine")
            assert target.startswith(below), (module, target)


def test_mechanics_knows_no_map() -> None:
    for module, target in imports("woodpecker").edges:
        if module.startswith("woodpecker.mechanics") and target.startswith("woodpecker"):
            assert target.startswith(("woodpecker.mechanics", "woodpecker.base")), (module, target)


def test_only_drawing_files_import_matplotlib() -> None:
    for package in ("pwmap", "woodpecker"):
        for module, target in imports(package).edges:
            if target.startswith("matplotlib"):
                assert module.startswith(DRAWING), module


# --- Numbers that decide results ------------------------------------------------------------------

ENGINE = ROOT / "woodpecker" / "piecewise"
ALLOWED = {
    # codes and versions: nothing is measured by them
    "checkpoint.VERSION", "iterates.RETURN", "margins.DEPTH", "margins.DIP", "margins.FIRST",
    "margins.NEAREST", "margins.REACH", "partition.NOWHERE", "reaches.INSIDE", "reaches.NO_VALUE",
    # mathematics, and what doubles can hold
    "margins.FAR", "margins.FLAT", "margins.IN_X", "margins.ROUNDED",
    "network.TINY", "orbits.SPACING", "search.GOLDEN",
    # bounds of loops that end before, or that another method finishes: work, and no result
    "bracketing.NEWTON", "margins.CUBIC_STEPS", "monotone.DEEPEST", "reaches.ROOT_STEPS",
    "reaches.MOST", "slices.MOST",
    # of iterates: what is cut is reported, as of pieces more than ``Settings.max_pieces``
    "itineraries.OF_ITERATE", "itineraries.PAIRS",
    # differences in place of derivatives that a map lacks, and their check: known before any run
    "derivatives.DOUBT", "derivatives.NOISE", "derivatives.STEP", "formulas.DIFFERENCE",
    # an interval of a linear model, in which any is as good
    "local.REACH",
}  # fmt: skip
PLAIN = {0.0, 0.5, 1.0, 2.0, 3.0, 4.0}  # signs, halves, and the coefficients of cubics


def constants(tree: ast.Module) -> dict[str, ast.expr]:
    """What is given names at the top of a file, if it is made of numbers alone."""
    found = {}
    for node in tree.body:
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
            leaves = [each for each in ast.walk(node.value) if isinstance(each, ast.Constant)]
            inside = [each for each in ast.walk(node.value) if isinstance(each, ast.Lambda)]
            if leaves and not inside and all(type(leaf.value) in (int, float) for leaf in leaves):
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                names = [each.id for target in targets for each in ast.walk(target)
                         if isinstance(each, ast.Name)]  # fmt: skip
                found.update(dict.fromkeys(names, node.value))
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


def test_numbers_that_decide_results_are_settings() -> None:
    """Constants beside ``settings.py`` are none of those, each on a list that says why."""
    found, bare = set(), []
    for path in ENGINE.glob("*.py"):
        if path.stem != "settings":
            tree = ast.parse(path.read_text(encoding="utf-8"))
            found |= {f"{path.stem}.{name}" for name in constants(tree)}
            bare += [(path.name, *each) for each in bare_numbers(tree)]
    assert found - ALLOWED == set()
    assert ALLOWED - found == set()  # the list names none that is gone
    assert bare == []


def test_every_number_is_used() -> None:
    text = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "woodpecker").rglob("*.py"))
    used = set(re.findall(r"\bnumerics\.([a-z_]+)", text))
    assert {each.name for each in fields(Numerics)} - used == set()
