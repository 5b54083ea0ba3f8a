"""What a user meets: every type in a public signature has a public name, every argument a text."""

import ast
import dataclasses
import inspect
import re
import textwrap
import typing
from collections.abc import Callable, Iterator
from importlib import import_module
from types import ModuleType
from typing import Any

import pytest
import rooms

import pwmap
import woodpecker

PACKAGES = (pwmap, woodpecker, *rooms.ALL)
PUBLIC = [
    (package, name)
    for package in PACKAGES
    for name in package.__all__
    if not isinstance(getattr(package, name), ModuleType)
] + [(woodpecker.branches, "OnBranch"), (woodpecker.diagrams, "bifurcation_search")]
IDS = [f"{package.__name__}.{name}" for package, name in PUBLIC]

# What the packages hand among themselves; a user passes it on, or never sees it.
ENGINE = {
    "pwmap.algebra.rootfunctions.Column": "the polynomials of a strip, in order",
    "pwmap.algebra.rootfunctions.Root": "one of their roots, as a function",
    "pwmap.longrun.line.MapLine": "a map at one place of its parameters, for its orbits",
    "pwmap.longrun.line.PointSet": "intervals and points, with the ends that belong to them",
    "pwmap.maps.cylinders.Cut": "an end of a piece, as a preimage of a break",
    "pwmap.maps.cylinders.Cylinder": "what a piece is made from",
    "pwmap.maps.cylinders.StudiedIterate": "cylinders of an iterate, with their signs",
    "pwmap.maps.decided.Decided": "what a map is, and who decides its signs",
    "pwmap.maps.reading.Definition": "a map as it was read",
    "pwmap.algebra.assumptions.AssumedRegion": "for which parameters signs hold: all assumed,",
    "pwmap.maps.decided.CellScope": "or those of a cell",
    "pwmap.maps.words.Orbits": "polynomials of words, which the iterates of a map share",
    "pwmap.maps.words.SignOracle": "decides signs of these",
    "pwmap.plane.strips.PlaneEvent": "what happens to cycles, and to which",
    "pwmap.plane.curves.PlaneArc": "a part of a curve over one strip",
    "woodpecker.search.curves.BranchCurve": "a curve of one branch, as a run keeps it",
    "woodpecker.search.curves.Collision": "how a branch ends at a border, as a run keeps it",
    "woodpecker.search.curves.End": "how a branch ends, as a run keeps it",
    "woodpecker.maps.symbolic.SymbolicPiece": "a formula, with its derivatives compiled",
    "woodpecker.simulation.paths.Follower": "a return that is followed with its word prescribed",
    "woodpecker.toy_map._ThreadRoom": "what threads do not share",
}
POINT = {"x", "p"}  # of a map that is asked for its image: a point and a parameter


def routines(value: Any, name: str) -> Iterator[tuple[str, Callable[..., object]]]:
    """A function, or the public methods and properties of a class."""
    if inspect.isfunction(value):
        yield name, value
    elif inspect.isclass(value):
        for own, member in vars(value).items():
            for each in (
                member,
                *(getattr(member, kind, None) for kind in ("fget", "func", "__func__")),
            ):
                if inspect.isfunction(each) and (not own.startswith("_") or own == "__call__"):
                    yield f"{name}.{own}", each


def hints(value: Any) -> dict[str, Any]:
    """Annotations as types; those of files that only type checkers import are looked up by name."""
    known = {name: getattr(package, name) for package in PACKAGES for name in package.__all__}
    return typing.get_type_hints(value, localns=known | vars(inspect.getmodule(value)))


def types_in(hint: Any) -> Iterator[type]:
    """All classes of an annotation."""
    if isinstance(hint, list):
        for each in hint:
            yield from types_in(each)
    elif typing.get_args(hint):
        for each in (typing.get_origin(hint), *typing.get_args(hint)):
            yield from types_in(each)
    elif isinstance(hint, type):
        yield hint


@pytest.mark.parametrize(("package", "name"), PUBLIC, ids=IDS)
def test_every_type_in_a_signature_is_public(package: ModuleType, name: str) -> None:
    value = getattr(package, name)
    public = {id(getattr(each, own)) for each, own in PUBLIC}
    annotated = [hints(routine) for _, routine in routines(value, name)]
    if dataclasses.is_dataclass(value) or hasattr(value, "_fields"):
        annotated.append(hints(value))
    for kind in (kind for table in annotated for own, hint in table.items() if own[0] != "_"
                 for kind in types_in(hint)):  # fmt: skip
        where = f"{kind.__module__}.{kind.__qualname__}"
        if where.startswith(("pwmap.", "woodpecker.")) and where not in ENGINE:
            assert id(kind) in public, where


def described(text: str) -> set[str]:
    """Names in the Parameters section of a docstring."""
    section = re.search(
        r"^Parameters\n-+\n(.*?)(?=^\S[^\n]*\n-+\n|\Z)", text, re.MULTILINE | re.DOTALL
    )
    if section is None:
        return set()
    heads = [line for line in section[1].splitlines() if line and not line[0].isspace()]
    return {name.strip(" *") for head in heads for name in head.partition(" : ")[0].split(",")}


@pytest.mark.parametrize(("package", "name"), PUBLIC, ids=IDS)
def test_every_argument_is_described(package: ModuleType, name: str) -> None:
    """Of functions in a section; methods of several name each, there or in a sentence."""
    value = getattr(package, name)
    assert inspect.getdoc(value), name
    for own, routine in routines(value, name):
        text = inspect.getdoc(routine) or ""
        assert text, own
        names = arguments(routine)
        if inspect.isfunction(value):
            assert names <= described(text), own
        elif len(names - POINT) > 1:
            assert names <= described(text) | set(re.findall(r"``(\w+)``", text)), own


def sections(text: str) -> set[str]:
    """Titles of the sections of a docstring."""
    return set(re.findall(r"^(\w[\w ]*)\n-{3,}$", text, re.MULTILINE))


def arguments(routine: Callable[..., object]) -> set[str]:
    return set(inspect.signature(routine).parameters) - {"self", "cls"}


def raises(routine: Callable[..., object]) -> list[ast.expr]:
    """What a function raises itself."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(routine)))
    return [node.exc for node in ast.walk(tree) if isinstance(node, ast.Raise) and node.exc]


def raised(routine: Callable[..., object]) -> set[str]:
    """Names of the classes of errors that it calls there."""
    made = [each.func for each in raises(routine) if isinstance(each, ast.Call)]
    return {each.id for each in made if isinstance(each, ast.Name) and each.id[0].isupper()}


def wanted(routine: Callable[..., object]) -> set[str]:
    """Sections that a docstring must have: of what goes in, comes out, and is raised."""
    parts = {
        "Parameters": bool(arguments(routine)),
        "Returns": inspect.signature(routine).return_annotation not in (None, "None"),
        "Raises": bool(raises(routine)),
    }
    return {title for title, there in parts.items() if there}


@pytest.mark.parametrize(("package", "name"), PUBLIC, ids=IDS)
def test_what_comes_out_and_what_is_raised_is_described(package: ModuleType, name: str) -> None:
    """Of functions in sections; methods name their errors at least in a sentence."""
    value = getattr(package, name)
    for own, routine in routines(value, name):
        text, takes = inspect.getdoc(routine) or "", arguments(routine)
        if inspect.isfunction(value):
            assert wanted(routine) <= sections(text), own
        elif takes:
            assert raised(routine) <= set(re.findall(r"\w+", text)), own


def test_what_is_called_engine_is_there_and_not_public() -> None:
    for where in ENGINE:
        module, _, name = where.rpartition(".")
        kind = getattr(import_module(module), name)
        assert all(getattr(each, own) is not kind for each, own in PUBLIC), where
