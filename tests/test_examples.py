"""Every verb has an example, a result names the verb that gives it, and all print what they say."""

import doctest
import inspect
import re
from enum import Enum
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

import matplotlib as mpl
import matplotlib.pyplot as plt
import pytest
from needs import NEEDS_NUMBA
from pages import OPTIONS

mpl.use("Agg")
import rooms

import pwmap
import pwmap.plot
import woodpecker
import woodpecker.plot.drawing
import woodpecker.plot.figures
import woodpecker.plot.motions
import woodpecker.plot.plane
import woodpecker.plot.regions

DRAWING = (
    *(woodpecker.plot.drawing, woodpecker.plot.figures, woodpecker.plot.motions),
    *(woodpecker.plot.plane, woodpecker.plot.regions),
)
PICTURES = [
    (module, name)
    for module in DRAWING
    for name, value in vars(module).items()
    if re.match(r"plot_|draw_toy|draw_frames|animate", name)
    and getattr(value, "__module__", "") == module.__name__
] + [(pwmap.plot, name) for name in pwmap.plot.__all__ if name == "Drawn" or "plot_" in name]
PUBLIC = {  # once each, from where a user takes it
    id(getattr(package, name)): (package, name)
    for package in (*rooms.ALL, pwmap, woodpecker)
    for name in package.__all__
    if name != "__version__" and not isinstance(getattr(package, name), ModuleType)
}
NAMES = [*PUBLIC.values(), *PICTURES]
COMPUTES = re.compile(  # thousands of returns of the toy
    r"\b(continuation|bifurcation_diagram|bifurcation_search|smallest_changes|parameter_regions)\((Toy\(|toy\b)"
)
WARNS = "local_model(family"  # numpy's scalars say that inf times 0 is no number, compiled code not
RESOLVES = "plot_return_map("  # spends thousands of returns on steep places
CUTS = re.compile(r"\b(attractor_diagram|with_crises|prove)\(")  # a second, about


def text_of(package: object, name: str) -> str:
    return inspect.getdoc(getattr(package, name)) or ""


def has_example(package: object, name: str) -> bool:
    return "Examples\n--------\n" in text_of(package, name)


def cases() -> list[object]:
    found = []
    for package, name in NAMES:
        text = text_of(package, name)
        if not has_example(package, name):
            continue
        marks = [NEEDS_NUMBA, pytest.mark.slow] if COMPUTES.search(text) else []
        marks += [NEEDS_NUMBA] if WARNS in text or RESOLVES in text else []
        marks += [pytest.mark.slow] if CUTS.search(text) else []
        found.append(pytest.param(package, name, id=f"{package.__name__}.{name}", marks=marks))
    return found


@pytest.mark.nightly
@pytest.mark.parametrize(("package", "name"), cases())
def test_an_example_prints_what_it_says(
    package: object, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It imports all that it takes, shows something, and leaves its files where it runs."""
    text = text_of(package, name)
    if package is woodpecker and "prove" in text and find_spec("flint") is None:
        pytest.skip("proofs need python-flint")
    monkeypatch.chdir(tmp_path)
    parser, report = doctest.DocTestParser(), list[str]()
    test = parser.get_doctest(text, {}, name, None, 0)
    assert any(example.want for example in test.examples), f"{name} has no example with a result"
    assert not any(doctest.SKIP in example.options for example in test.examples)
    runner = doctest.DocTestRunner(optionflags=OPTIONS)
    runner.run(test, out=report.append)
    plt.close("all")
    assert "".join(report) == ""


IDS = {"ids": lambda value: getattr(value, "__name__", value)}


@pytest.mark.parametrize(("package", "name"), NAMES, **IDS)
def test_an_example_has_its_place(package: object, name: str) -> None:
    """One section, the last of a docstring, as numpydoc has it."""
    text = text_of(package, name)
    assert text.count("Examples\n--------\n") <= 1
    assert not re.search(r"^\w+\n-+$", text.partition("Examples\n--------\n")[2], flags=re.M)


SHOWN = {name for package, name in NAMES if has_example(package, name)}


@pytest.mark.parametrize(
    ("package", "name"), [case for case in NAMES if not has_example(*case)], **IDS
)
def test_what_has_no_example_names_what_has_one(package: object, name: str) -> None:
    """Errors and closed sets need none; a result is shown where it comes from."""
    value = getattr(package, name)
    assert isinstance(value, type), name
    named = re.findall(r":(?:func|meth|class):`([\w.]+)`", text_of(package, name))
    named = {part for each in named for part in each.split(".")}
    assert issubclass(value, (Enum, Exception)) or named & SHOWN, name
