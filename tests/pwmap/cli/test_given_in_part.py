"""Answers that hold in a part of what was assumed: the command says so before anything else."""

import html
from pathlib import Path

import pytest
from typer.testing import CliRunner

from pwmap import PiecewiseLinearMap, bifurcation_diagram, load_diagram
from pwmap.cli.app import app
from pwmap.cli.given import in_a_part_only

P1L = "Piecewise((r - 2, x <= 0), (r - a*x, True))"


def told(given: tuple[str, ...], orders: tuple[int, ...], **sample: str) -> str:
    map_ = PiecewiseLinearMap.from_sympy(P1L, "x", given)
    return in_a_part_only(map_, bifurcation_diagram(map_, "r", None, orders, sample or None))


@pytest.mark.slow
def test_the_part_and_a_value_beyond_it() -> None:
    """At order 2 the end 2 a/(a - 1) of a branch leaves the default span of r, [-1, 5], at 5/3."""
    sentence = told(("a > 1",), (1, 2))
    assert sentence.startswith(
        "This is decided for a > 5/3 only, a part of what is assumed (a > 1): at a = 2. For the "
    )
    assert "--sample a=4/3," in sentence
    assert told(("a > 1",), (1, 2), a="4/3") != sentence


def test_the_value_that_is_named_gives_another_part() -> None:
    assert "decided for a > 5/3 only" not in told(("a > 1",), (1, 2), a="4/3")


@pytest.mark.parametrize("given", [
    ("a > 1",), ("a > 1", "r > -3"), ("a > 1", "a > 0"), ("2*a > 3",), ("a**3 > 2",),
    ("a >= 2", "a <= 2"),
])  # fmt: skip
def test_nothing_is_said_where_it_holds_in_all(given: tuple[str, ...]) -> None:
    assert told(given, (1,)) == ""


def test_an_end_of_what_is_assumed_is_no_part_of_an_open_interval() -> None:
    """The cells are cut at 2, where the assumption begins; 2 itself has a run of its own."""
    assert told(("a >= 2",), (1,)) == (
        "This is decided for a > 2 only, without a = 2, though that is assumed: at "
        "a = 3. What holds there takes a run of its own: give it by --set a=2 and another folder "
        "by --out."
    )
    assert "without a = 2 and a = 3, " in told(("a >= 2", "a <= 3"), (1,))
    assert "without a = 3, " in told(("a > 2", "a <= 3"), (1,))
    # a smaller part is more than an end away
    assert "for a > 5/3 only, a part of what is assumed (a >= 1)" in told(("a >= 1",), (1, 2))


def test_of_several_parameters_it_holds_in_all_if_no_condition_is_new() -> None:
    """x -> b - x/2 - c, or a + b + 1, has one fixed point for b > 100, all a > 0 and c < 50."""
    map_ = PiecewiseLinearMap.from_sympy(
        "Piecewise((b - x/2 - c, x <= 0), (a + b + 1, True))", given=["a > 0", "c < 50", "a > -1"]
    )
    found = bifurcation_diagram(map_, "b", (100, 101), (1,), {"a": 1, "c": 1})
    assert found.given == ("a > 0", "c < 50", "a > -1")
    assert found.in_part == ""


def test_without_symbols_nothing_is_said() -> None:
    map_ = PiecewiseLinearMap.from_sympy(P1L).at({"a": "5/4"})
    assert in_a_part_only(map_, bifurcation_diagram(map_, "r", orders=(1, 2))) == ""


@pytest.mark.slow
def test_a_diagram_says_it_first(tmp_path: Path) -> None:
    """At a prompt, in a notebook and after it was saved; not where it holds in all."""
    map_ = PiecewiseLinearMap.from_sympy(P1L, "x", ("a > 1",))
    first = "x over r, for a > 5/3 only, a part of what is assumed (a > 1): 7 branches in [-1, 5]"
    found = bifurcation_diagram(map_, "r", None, (1, 2))
    for each in (found, load_diagram(found.save(tmp_path / "part.json"))):
        assert repr(each).startswith(f"Diagram({first}")
        assert html.escape(first) in each._repr_html_()
        assert repr(each.of_order(1)).startswith("Diagram(x over r, for a > 5/3 only, a part of")
    assert repr(bifurcation_diagram(map_, "r", None, (1,))).startswith("Diagram(x over r: 3 br")


def test_a_part_of_all_values() -> None:
    map_ = PiecewiseLinearMap.from_sympy(P1L)
    found = bifurcation_diagram(map_, "r", None, (1,), {"a": 2})
    assert repr(found).startswith("Diagram(x over r, for a > ")
    assert "only, a part of what is assumed (all values): " in repr(found).splitlines()[0]


@pytest.mark.nightly
def test_the_command_says_it_first(tmp_path: Path) -> None:
    arguments = ["analyse", P1L, "--parameter", "r", "--given", "a > 1", "--out", str(tmp_path)]
    found = CliRunner().invoke(app, arguments)
    assert found.exit_code == 0
    assert found.stdout.startswith("This is decided for a > 5/3 only")
