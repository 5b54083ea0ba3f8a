"""What the page of a map is given, beside the public functions; no browser."""

import csv
import io
import json
from fractions import Fraction
from typing import Any

import pytest
from typer.testing import CliRunner

pytest.importorskip("bokeh")
from pwmap.cli.app import app
from pwmap.explore.map_data import FILES, answers, export
from pwmap.explore.map_state import (
    P1L,
    MapState,
    from_query,
    of_map,
    rational,
)

SKEW = "Piecewise((a*x + 1, x <= 0), (b*x + 1, True))"


def test_a_link_holds_the_map() -> None:
    assert MapState().query() == ""
    state = MapState(map="Piecewise((a*x + 1, x <= 0), (b*x + 1, True))", given="",
                     values=(("a", "1/2"), ("b", "-3/2")), over="b", span=("-5", "-1/2"),
                     plane=("a", "b"), order=3)  # fmt: skip
    assert from_query(state.query()) == state
    assert state.parameters == ("a", "b")
    assert state.at({"a": "2/3"}).place == {"a": "2/3", "b": "-3/2"}


@pytest.mark.parametrize(
    "query",
    ["map=" + "x" * 700, "order=99", "order=-1", "start=sqrt(2)", "start=1/0", "span=1,0",
     "span=1", "nothing=1", "focus=<b>", "at_a=1e9999", "at_a=" + "9" * 40],
)  # fmt: skip
def test_a_link_that_is_none_is_refused(query: str) -> None:
    with pytest.raises(ValueError, match=r"\w"):
        from_query(query)


def test_rationals_are_short_and_exact() -> None:
    assert rational("-5/4") == Fraction(-5, 4)
    assert rational("1.25") == Fraction(5, 4)
    for text in ("1e5", "x", "__import__('os')", "", "1/0", "1/2/3"):
        with pytest.raises(ValueError, match="expected a rational"):
            rational(text)


def test_the_answers_are_exact() -> None:
    """P1^L at a = 5/4, r = 1 [Leine2001, Eqs. 14-16]; formulas hold for every a > 1."""
    parts = {part.name: part for part in answers(MapState())}
    assert [part.message for part in parts.values()] == [""] * 5
    rows = {title: each for part in parts.values() for title, each in part.rows.items()}
    assert rows["Pieces of P₁"] == [["L", "-1", "x <= 0"], ["R", "1 - 5*x/4", "0 < x"]]
    assert rows["Jump crossings"] == [["x = 0", "from -1", "to 1"]]
    cycles = rows["Cycles up to period 6"]
    assert [row[:2] for row in cycles] == [["L", "-1"], ["R", "4/9"]]
    assert cycles[1][3] == "x = r/(a + 1)"
    assert [row[0] for row in rows["Cells of r"]][:3] == ["-1 < r < 0", "r = 0", "0 < r < 2 ← here"]
    assert rows["Attractors"][0][0] == "cycle L through -1"
    assert rows["Entropy"][0][1] == "= 0"
    assert any(row[3] == "r - 2 = 0" for row in rows["Curves of the plane"])
    assert rows["Orbit"][1] == ["1", "5/8"]
    assert parts["map"].tables["fixed"]["kind"] == ["stable", "unstable"]


def test_a_chaotic_map_has_a_density() -> None:
    tent = MapState(map="Piecewise((a*x, x <= 1/2), (a*(1 - x), True))", given="",
                    values=(("a", "2"),), over="a", span=("1", "2"))  # fmt: skip
    parts = {part.name: part for part in answers(tent)}
    assert parts["long"].tables["steps"] == {"left": [0.0], "right": [1.0], "top": [1.0]}
    assert parts["long"].rows["Entropy"][0][1] == "= log(2)"


@pytest.mark.parametrize(
    "formula", ["__import__('os').system('true')", "Piecewise((x", "x**x", "1/x", "open('f')"]
)
def test_a_hostile_text_is_an_error_and_nothing_else(formula: str) -> None:
    with pytest.raises((ValueError, TypeError)):
        list(answers(MapState(map=formula, given="", values=())))


def test_a_map_that_is_typed_is_shown_about_its_values() -> None:
    """The plane has its own parameters, and a link without intervals means these."""
    state = of_map(SKEW, "", {"a": "1/2", "b": "-3/2"})
    assert (state.axis, state.span, state.plane_names) == ("a", ("-2", "3"), ("a", "b"))
    assert (state.across, state.along) == (("-2", "3"), ("-4", "1"))
    assert state.query().count("=") == 3  # the map, and two values
    assert from_query(state.query()) == state
    moved = state.at({"a": "5"})
    assert from_query(moved.query()) == moved
    assert of_map("Piecewise((x/2, x <= 0), (x/3, True))", "", {}).plane_names == ()


def test_a_link_holds_all_values_and_assumptions() -> None:
    """Also those that the map of the paper has where nothing is said: a > 1, and a = 5/4."""
    for values in ({"a": "5/4"}, {"a": "5/4", "b": "2"}, {}):
        for given in ("a > 1", ""):
            state = of_map(SKEW, given, values)
            assert from_query(state.query()) == state
            paper = of_map(P1L, given, {name: values[name] for name in values if name == "a"})
            again = from_query(paper.query())
            assert (again.place, again.given) == (paper.place, given)


def test_functions_and_assumptions_bring_no_parameters() -> None:
    state = of_map("Piecewise((abs(x)/2 + b, Le(x, 1)), (x/3, True))", "c > 0", {})
    assert (state.parameters, state.axis, state.plane_names) == (("b",), "b", ())
    assert [part.message for part in answers(state)] == [""] * 5
    exec(state.python(), {})


def test_one_cell_alone_is_here() -> None:
    """At r = 2 the fixed point r - 2 meets the break; the cells on both sides are not here."""
    rows = {
        title: each
        for part in answers(MapState().at({"r": "2"}))
        for title, each in part.rows.items()
    }
    assert [row[0] for row in rows["Cells of r"] if "here" in row[0]] == ["r = 2 ← here"]
    assert [row[2] for row in rows["Cycles up to period 6"]] == ["on a break, 0", "repels, -5/4"]
    turned = of_map("Piecewise((-x, x <= 1), (x/2, True))", "", {})
    assert next(answers(turned)).rows["Cycles up to period 6"][0][2] == "neutral, -1"


@pytest.mark.slow
def test_what_is_left_out_is_said() -> None:
    """Four full branches have 4 + 6 + 20 + 60 + 204 + 670 cycles up to period 6 [Moebius]."""
    folded = of_map("Piecewise((4*x, x <= 1/4), (2 - 4*x, x <= 1/2), (4*x - 2, x <= 3/4), "
                    "(4 - 4*x, True))", "", {})  # fmt: skip
    assert len(table("cycles.csv", folded)) == 964
    rows = next(answers(folded)).rows["Cycles up to period 6"]
    assert (len(rows), rows[-1]) == (61, ["and 904 more"])


@pytest.fixture
def shown(monkeypatch: pytest.MonkeyPatch) -> list[MapState]:
    """The maps that the command shows."""
    maps = list[MapState]()
    monkeypatch.setattr("pwmap.explore.map_page.run", lambda state, *_, **__: maps.append(state))
    return maps


@pytest.mark.parametrize(
    ("arguments", "wrong"),
    [
        ((SKEW, "--set", "c=1"), "unknown parameter 'c'"),
        (("Piecewise((a*x + 1,",), "cannot read"),
        (("--given", "a ~ 2"), "cannot read"),
    ],
)
def test_the_command_refuses_what_a_page_cannot_show(
    arguments: tuple[str, ...], wrong: str, shown: list[MapState]
) -> None:
    result = CliRunner().invoke(app, ["explore", *arguments])
    assert (result.exit_code, wrong in result.stderr, shown) == (2, True, [])


@pytest.mark.parametrize(
    ("formula", "values", "given", "span"),
    [
        ("x/(1 + a) + b", {}, "a + 1 > 0", ("-1", "3")),
        ("x/(1 + a) + b", {"a": "-5/2"}, "a + 1 < 0", ("-5", "-1")),
        # the interval ends at a rational before sqrt(2), and at one after -sqrt(2)
        ("Piecewise((x/(a**2 - 2), x <= 0), (1, True))", {}, "a**2 - 2 < 0", ("0", "4/3")),
        ("Piecewise((b*x, x < 1/b), (b*x - 1, True))", {"b": "3/2"}, "b > 0", ("0", "4")),
        ("Piecewise((0, x < a), (1, x < 2), (2, True))", {}, "a - 2 < 0", ("-1", "2")),
    ],
)
def test_signs_that_a_map_needs_are_those_at_its_values(
    formula: str, values: dict, given: str, span: tuple, shown: list[MapState]
) -> None:
    """Denominators and the order of breaks: all answers come, and the link has what is assumed."""
    sets = [part for name, value in values.items() for part in ("--set", f"{name}={value}")]
    result = CliRunner().invoke(app, ["explore", formula, *sets])
    assert (result.exit_code, result.stderr) == (0, "")
    (state,) = shown
    assert (state.given, state.span) == (given, span)
    assert from_query(state.query()) == state
    assert [part.message for part in answers(state)] == [""] * 5


def test_a_sign_that_a_map_does_not_have_at_its_values_is_asked_for() -> None:
    result = CliRunner().invoke(app, ["explore", "x/(1 + a) + b", "--set", "a=-1"])
    assert (result.exit_code, result.stderr) == (
        2, "Error: a + 1 must have a sign and is zero at a = -1: give other values\n"
    )  # fmt: skip


def test_an_assumption_is_taken_without_a_formula(shown: list[MapState]) -> None:
    CliRunner().invoke(app, ["explore", "--given", "a > 2", "--set", "a=3"])
    assert [(state.given, state.place) for state in shown] == [("a > 2", {"a": "3", "r": "1"})]


@pytest.mark.nightly
def test_lines_of_python_make_what_is_shown(capsys: pytest.CaptureFixture[str]) -> None:
    for state in (MapState(), of_map(SKEW, "", {"a": "1/2", "b": "-3/2"})):
        space: dict[str, Any] = {}
        exec(state.python(), space)
        shown = next(part.diagram for part in answers(state) if part.name == "diagram")
        assert [b.id for b in space["diagram"].branches] == [b.id for b in shown.branches]
    assert "R  1 - 5*x/4  for 0 < x" in capsys.readouterr().out


def content(name: str, state: MapState) -> bytes:
    ((_, made),) = export(name, state.query())
    return made


def table(name: str, state: MapState) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(content(name, state).decode())))


def test_files_hold_exact_values() -> None:
    """P1^L at a = 5/4, r = 1 [Leine2001, Eqs. 14-16]."""
    state = MapState()
    left, right = table("pieces.csv", state)
    assert (left["word"], left["slope"], left["intercept"]) == ("L", "0", "-1")
    assert (right["word"], right["slope"], right["intercept"]) == ("R", "-5/4", "1")
    cycles = {row["word"]: row for row in table("cycles.csv", state)}
    assert cycles["R"]["points"] == "4/9"
    assert (cycles["L"]["stable"], cycles["R"]["stable"]) == ("True", "False")
    assert [row["x"] for row in table("orbit.csv", state)][:2] == ["3/10", "5/8"]
    cells = table("cells.csv", state)
    assert {"lower": "0", "upper": "2", "period": "1", "word": "R", "x": "4*r/9"} in cells
    told = json.loads(content("state.json", state))
    assert (told["map"], told["link"]) == (state.map, "")


@pytest.mark.nightly
def test_every_file_is_made() -> None:
    tent = of_map("Piecewise((a*x, x <= 1/2), (b*(1 - x), True))", "", {"a": "2", "b": "2"})
    begins = {"png": b"\x89PNG", "svg": b"<?xml", "json": b"{", "csv": b"", "py": b"from pwmap"}
    for name in FILES:
        form = name.partition(".")[2]
        assert content(name, tent).lstrip().startswith(begins.get(form, b"<"))


def test_what_a_map_has_not_is_refused_with_a_sentence() -> None:
    still = of_map("Piecewise((x/2, x <= 0), (x/3, True))", "", {})
    for name, sentence in (
        ("plane.png", "two parameters"), ("branches.csv", "has no parameter"),
        ("density.png", "no.* attractor|none with a density"), ("map.exe", "unknown file"),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=sentence):
            content(name, still)
