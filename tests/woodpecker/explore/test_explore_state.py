"""States of the explorer, their links and their lines of Python; no browser, and no Bokeh."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import tour_page
from hypothesis import given
from hypothesis import strategies as st

from woodpecker import Toy
from woodpecker.cli.toys import read_toy
from woodpecker.explore.state import PageState, from_query, usual_span
from woodpecker.explore.tour import TOUR

UNIT = st.floats(0.0, 1.0)


def test_an_empty_link_is_the_paper() -> None:
    assert PageState().query() == ""
    assert from_query("") == PageState()
    assert PageState().toy == Toy()


@pytest.mark.slow
@given(
    st.fixed_dictionaries({"eps_n1": UNIT, "mu_2": UNIT, "g": st.floats(0.1, 20.0)}),
    st.floats(-3.0, 0.1), st.booleans(), st.sampled_from([1, 2, 3, 4]),
    st.sampled_from(["summed", "separate"]), st.sampled_from(["eps_n1", "mu_1", "c_phi"]),
    st.sampled_from([(), (1,), (1, 2)]), st.integers(0, 10),
)  # fmt: skip
def test_a_link_holds_every_bit(
    values: dict[str, float], phi_s: float, periodic: bool, order: int, law: str, over: str,
    every: tuple[int, ...], tour: int,
) -> None:  # fmt: skip
    state = PageState(
        toy=Toy(**values, expansion_friction=law), phi_s=phi_s, periodic=periodic, order=order,
        over=over, span=(0.1, 0.7), every=every, tour=tour, window=(-1.5, phi_s + 5.0),
    )  # fmt: skip
    assert from_query(state.query()) == state


@pytest.mark.parametrize(
    ("query", "sentence"),
    [
        ("eps_n1=2", "eps_n1 must lie in"),
        ("eps_n1=__import__('os')", "eps_n1 must be a number"),
        ("no_such=1", "unknown name in the link: 'no_such'"),
        ("j=7", "order must be one of"),
        ("j=1.5", "order must be a whole number"),
        ("phi_s=inf", "phi_s must be finite"),
        ("window=1,0", "window must be finite and ascend"),
        ("window=1", "window must be two numbers"),
        ("focus=<b>", "focus must be one of"),
        ("tour=11", "the tour has steps 1 to 10"),
        ("law=none", "expansion_friction must be"),
        ("every=3", "every branch is looked for"),
        ("steps=100000", "steps must lie in"),
        ("x" * 5000, "a link has at most"),
    ],
)
def test_a_link_that_is_none_is_refused_with_a_sentence(query: str, sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        from_query(query)


def test_an_unknown_parameter_is_named() -> None:
    with pytest.raises(TypeError, match="unknown parameter 'none'"):
        from_query("over=none")


def test_a_span_follows_its_parameter() -> None:
    assert PageState().with_axis("mu_2").span == (0.15, 0.3 * 1.5)
    assert PageState().with_axis("eps_n2").span == (0.0, 1.0)
    assert from_query("over=mu_2").span == usual_span(Toy(), "mu_2")


def test_the_pole_has_no_end_at_zero() -> None:
    assert PageState().at({"pole": 0.0}).toy.pole == math.inf
    assert PageState().at({"pole": 2.0}).toy.pole == 2.0


def test_the_file_of_a_state_is_one_of_its_toy(tmp_path: Path) -> None:
    """For ``woodpecker ... --toy state.json``, also with the pole without an end."""
    state = from_query("eps_n1=0.3&law=separate")
    (tmp_path / "state.json").write_text(state.json(), encoding="utf-8")
    assert read_toy(tmp_path / "state.json") == state.toy
    assert state.toy.pole == math.inf


def test_the_tour_follows_the_figures_of_the_paper() -> None:
    assert len(TOUR) == 10
    assert [step.figure for step in TOUR[:9]] == [f"Figure {k}" for k in range(4, 13)]
    for k, step in enumerate(TOUR, start=1):
        assert step.state.tour == k
        assert step.text.count(". ") + step.text.endswith(".") in (2, 3)
        assert from_query(step.state.query()) == step.state


@pytest.mark.parametrize("changes", [{}, {"order": 2, "phi_s": -0.9, "periodic": False}])
def test_lines_of_python_run(changes: Any) -> None:
    """They are what a page shows: run up to the diagram, which another test has."""
    state = replace(PageState(), **changes)
    lines = state.python()
    space: dict[str, Any] = {}
    exec(lines.partition("\ndiagram =")[0], space)
    assert space["motion"].toy == state.toy
    assert len(space["returns"]) == 1000
    assert "diagram = continuation(orbit.toy, orbit, 'eps_n1', (0.0, 1.0))" in lines
    assert "bifurcation_diagram(toy" in replace(state, every=(1, 2)).python()


def test_the_static_page_tells_the_same_tour() -> None:
    """The page is written by ``python tests/tour_page.py``."""
    told = (tour_page.DOCS / "explore_tour.md").read_text(encoding="utf-8")
    assert told == tour_page.page()
