"""What is loaded, and when: names come with what they need, help comes with nothing."""

import json
import os
import pickle
import pydoc
import subprocess
import sys
from importlib import import_module
from importlib.metadata import version
from pathlib import Path

import pytest
import rooms

import pwmap
import woodpecker

ROOT = Path(__file__).parents[1]
PACKAGES = (pwmap, woodpecker)
HEAVY = {"flint", "matplotlib", "networkx", "numba", "numpy", "scipy", "shapely", "sympy"}
TOOLS = {"rich", "typer"}


def loaded_by(code: str) -> set[str]:
    """All modules after some lines in an interpreter of its own."""
    ending = "\nimport json, sys\nprint(json.dumps(sorted(sys.modules)))"
    path = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    found = subprocess.run(
        [sys.executable, "-c", code + ending], capture_output=True, text=True, check=True,
        env={**os.environ, "PYTHONPATH": path, "PYTHONWARNINGS": "error"},
    )  # fmt: skip
    return set(json.loads(found.stdout.splitlines()[-1]))


@pytest.mark.parametrize("package", ["pwmap", "woodpecker"])
def test_importing_a_package_loads_nothing_but_its_table_of_names(package: str) -> None:
    loaded = loaded_by(f"import {package}; dir({package}); {package}.__all__")
    assert not loaded & (HEAVY | TOOLS)
    assert [name for name in loaded if name.startswith(f"{package}.")] == []


def test_the_toy_alone_is_light() -> None:
    loaded = loaded_by("from woodpecker import Toy; Toy().replace(eps_n1=0.3)")
    assert not loaded & (HEAVY | TOOLS)
    assert {name for name in loaded if name.startswith(("pwmap", "woodpecker"))} == {
        "pwmap", "pwmap.algebra", "pwmap.algebra.arguments", "pwmap.algebra.texts",
        "pwmap.diagrams", "pwmap.diagrams.shown",
        "woodpecker", "woodpecker.base", "woodpecker.base.shown",
        "woodpecker.mechanics", "woodpecker.mechanics.toy",
    }  # fmt: skip


@pytest.mark.nightly
def test_exact_maps_load_no_numerics_of_the_toy() -> None:
    loaded = loaded_by("from pwmap import PiecewiseLinearMap")
    assert "sympy" in loaded
    assert not loaded & (TOOLS | {"matplotlib", "numba", "shapely"})
    assert not [name for name in loaded if name.startswith("woodpecker")]


@pytest.mark.slow
@pytest.mark.parametrize(
    "arguments", [["--help"], ["-h"], [], ["--version"], ["{command}", "--help"], ["--wrong"]]
)
@pytest.mark.parametrize(("package", "command"), [("pwmap", "analyse"), ("woodpecker", "diagram")])
def test_help_loads_nothing_that_computes_or_draws(
    package: str, command: str, arguments: list[str]
) -> None:
    words = [package, *(each.format(command=command) for each in arguments)]
    code = f"""
import sys
from {package}.__main__ import run
sys.argv = {words}
try:
    run()
except SystemExit:
    pass
"""
    loaded = loaded_by(code)
    assert "typer" in loaded
    assert not loaded & HEAVY


# --- the packages are what they were before names were loaded late --------------------------------


@pytest.mark.parametrize("package", PACKAGES)
def test_every_name_is_there_and_is_itself(package: object) -> None:
    names = package.__all__  # type: ignore[attr-defined]
    assert names == sorted(names)
    assert set(names) <= set(dir(package))
    for name in names:
        value = getattr(package, name)
        assert getattr(package, name) is value
        if isinstance(value, type) and value.__module__.startswith(("pwmap.", "woodpecker.")):
            assert pickle.loads(pickle.dumps(value)) is value


@pytest.mark.parametrize("package", PACKAGES)
def test_an_unknown_name_is_an_attribute_error(package: object) -> None:
    with pytest.raises(AttributeError, match="no_such_name"):
        package.no_such_name  # type: ignore[attr-defined]  # noqa: B018


def test_a_name_that_moved_into_a_room_says_where_it_is() -> None:
    """For one release."""
    moved = [(room, name) for room in rooms.NAMES[pwmap] for name in getattr(pwmap, room).__all__
             if name not in pwmap.__all__]  # fmt: skip
    assert len(moved) == 60
    for room, name in moved:
        with pytest.warns(DeprecationWarning, match=rf"use pwmap\.{room}\.{name}$"):
            assert getattr(pwmap, name) is getattr(getattr(pwmap, room), name)


@pytest.mark.parametrize(("old", "name"), [("Jump", "Discontinuity"), ("Piece", "LinearPiece")])
def test_a_name_that_changed_says_the_new_one(old: str, name: str) -> None:
    """For one release."""
    with pytest.warns(DeprecationWarning, match=rf"pwmap\.{old} is deprecated: .* pwmap\.{name}"):
        assert getattr(pwmap, old) is getattr(pwmap, name)


@pytest.mark.parametrize("name", ["Drawn", "plot_long_run", "plot_plane"])
def test_files_of_pictures_have_their_old_names_for_one_release(name: str) -> None:
    old = {"Drawn": "plot_drawn", "plot_long_run": "plot_longrun"}.get(name, name)
    with pytest.warns(DeprecationWarning, match=r"use pwmap\.plot$"):
        module = import_module(f"pwmap.{old}")
    assert getattr(module, name) is getattr(import_module("pwmap.plot"), name)


def test_star_imports_everything() -> None:
    space: dict[str, object] = {}
    exec("from woodpecker import *", space)
    assert set(woodpecker.__all__) <= set(space)


@pytest.mark.parametrize(
    ("package", "parts"),
    [
        (pwmap, ("class PiecewiseLinearMap", "bifurcation_diagram(", "VERSION")),
        (woodpecker, ("class Toy", "continuation(", "VERSION")),
    ],
)
def test_help_of_a_package_describes_its_names(package: object, parts: tuple[str, ...]) -> None:
    text = pydoc.plain(pydoc.render_doc(package))
    for part in parts:
        assert part in text


def test_the_version_is_that_of_the_distribution() -> None:
    assert pwmap.__version__ == woodpecker.__version__ == version("woodpecker-toy")


@pytest.mark.parametrize("package", ["pwmap", "woodpecker"])
def test_both_packages_run_as_modules(package: str) -> None:
    found = subprocess.run(
        [sys.executable, "-m", package, "--version"], capture_output=True, text=True, check=True,
        cwd=ROOT,
    )  # fmt: skip
    assert found.stdout == f"{package} {version('woodpecker-toy')}\n"
