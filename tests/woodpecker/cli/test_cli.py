"""The commands: results, help, and one clear sentence for a wrong value."""

import json
import re
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer
from commands import invoked, rows
from needs import NIGHTLY_TOY, SLOW_TOY
from typer.testing import CliRunner

import woodpecker
from pwmap import read_graph
from pwmap.cli.app import app as pwmap_app
from pwmap.cli.results import Results
from woodpecker.cli.app import app
from woodpecker.mechanics.toy import ExpansionFriction, Toy, description, parameters
from woodpecker.plot.curve import BUDGET
from woodpecker.simulation.returns import first_return


def run(*arguments: str) -> tuple[int, str]:
    result = invoked(app, *arguments)
    return result.exit_code, result.output


# --- help ----------------------------------------------------------------------------------------

COMMANDS = [
    *(("woodpecker", app, name) for name in ("simulate", "animate", "map", "diagram", "curves")),
    ("pwmap", pwmap_app, "analyse"),
]
UNITS = {  # of what is not a parameter of the toy
    "phi_s": "[rad]", "window": "[rad]", "t_end": "[s]", "fps": "[1/s]",
}  # fmt: skip
LEAST = {"samples": 2, "points": 2, "order": 1, "workers": 1}


def shown(application: typer.Typer, command: str, monkeypatch: pytest.MonkeyPatch) -> str:
    """A help page as one line, without its frame."""
    for name in ("COLUMNS", "TERMINAL_WIDTH"):
        monkeypatch.setenv(name, "200")
    found = CliRunner().invoke(application, [command, "--help"])
    assert found.exit_code == 0
    return " ".join(re.sub("[─│╭╮╰╯]", " ", found.output).split())


def options(application: typer.Typer, command: str) -> list[Any]:
    """What a command can be given, but for --help."""
    group: Any = typer.main.get_command(application)
    return [each for each in group.commands[command].params if each.name != "help"]


@pytest.mark.parametrize("application", [app, pwmap_app], ids=["woodpecker", "pwmap"])
def test_help_has_an_example_and_two_words_for_two_numbers(
    application: typer.Typer, monkeypatch: pytest.MonkeyPatch
) -> None:
    group: Any = typer.main.get_command(application)
    for command in group.commands:
        page = shown(application, command, monkeypatch)
        assert "Example: " in page, command
        assert "<float,float>" not in page, command  # it would be typed with a comma


@pytest.mark.slow
@pytest.mark.parametrize(("program", "application", "command"), COMMANDS)
def test_help_explains_every_option(
    program: str, application: typer.Typer, command: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = shown(application, command, monkeypatch)
    assert f"{program} {command}" in page  # the example
    for each in options(application, command):
        assert each.help, each.name
        text = " ".join(each.help.replace("\\[", "[").split())
        assert text in page, each.name
        if each.param_type_name == "option":
            assert each.opts[0] in page
        if UNITS.get(each.name) is not None:
            assert UNITS[each.name] in text
        default = each.default
        if each.show_default and default is not None and not isinstance(default, bool):
            parts = default if isinstance(default, list | tuple) else [default]
            assert f"[default: {', '.join(map(str, parts))}]" in page, each.name
        if application is app and each.name in LEAST:
            assert f"{each.opts[0]} <integer from {LEAST[each.name]} on>" in page


@pytest.mark.parametrize("command", ["simulate", "animate", "map", "diagram"])
def test_help_describes_the_toy(command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Meaning, unit and range of every parameter are those of :class:`woodpecker.Toy`."""
    page, own = shown(app, command, monkeypatch), {each.name for each in options(app, command)}
    for name in parameters():
        assert name in own
        meaning, unit, domain = description(name)
        assert f"{meaning[1:]} [{unit}]; must {domain.value}" in page
    assert "expansion_friction" in own
    assert "summed|separate" in page
    assert "[default: summed]" in page


def test_units_of_the_toy_are_those_of_the_table() -> None:
    text = (Path(__file__).parents[3] / "docs" / "reference" / "symbols.md").read_text(
        encoding="utf-8"
    )
    table = text.partition("| symbol | in code | unit |")[2].partition("\n\n")[0]
    found = set()
    for name, units in re.findall(r"\| ((?:`\w+`(?:, )?)+) \| ([^|]+) \|", table):
        names = set(re.findall(r"`(\w+)`", name))
        if names <= set(parameters()):
            found |= names
            allowed = units.replace("²", "^2").replace("–", "-").strip().split(", ")
            assert {description(each).unit for each in names} <= set(allowed)
    assert found == set(parameters())


# --- wrong values --------------------------------------------------------------------------------


@pytest.mark.parametrize("command", ["simulate", "animate", "diagram"])
@pytest.mark.parametrize(("phi_s", "why"), [("-0.22", ": the sleeve stays jammed"), ("-0.05", "")])
def test_a_motion_that_does_not_exist_has_status_1(
    command: str, phi_s: str, why: str, tmp_path: Path
) -> None:
    status, text = run(command, "--phi-s", phi_s, "--out", str(tmp_path))
    assert status == 1
    assert f"no periodic motion near phi_S = {phi_s}{why}" in text
    assert not list(tmp_path.iterdir())


@pytest.mark.nightly
def test_a_motion_that_is_not_periodic_needs_an_end(tmp_path: Path) -> None:
    status, text = run("simulate", "--phi-s", "-0.05", "--out", str(tmp_path))
    assert status == 1
    assert "to follow another motion, give --phi-s and --t-end" in " ".join(text.split())
    status, text = run("simulate", "--phi-s", "-0.05", "--t-end", "0.1", "--out", str(tmp_path))
    assert status == 0, text


@pytest.mark.nightly
def test_a_motion_of_a_smaller_period_is_followed_and_said(tmp_path: Path) -> None:
    arguments = ("--span", "0.45", "0.5", "--order", "2", "--out", str(tmp_path))
    status, text = run("diagram", *arguments)
    assert status == 0
    assert "a periodic solution was found: one of period 1, 2 times over" in text
    assert {row["order"] for row in rows(tmp_path / "branches.csv")} == {"1"}


@NIGHTLY_TOY
def test_a_motion_that_ends_at_the_event_limit_fails_after_it_was_written(tmp_path: Path) -> None:
    """Eleven events in 0.146 s: 20000 of them take 265 s."""
    status, text = run("simulate", "--t-end", "300", "--out", str(tmp_path))
    assert status == 1
    assert "Failed: the motion was followed to t = 265." in text
    assert "after 20000 events: the event limit was reached" in text
    assert len(rows(tmp_path / "events.csv")) == 20_000
    assert (tmp_path / "time_history.png").stat().st_size > 10_000


@pytest.mark.slow
def test_simulate_writes_two_periods(tmp_path: Path) -> None:
    status, text = run("simulate", "--out", str(tmp_path))
    assert status == 0
    assert "D2" in text
    assert {path.name for path in tmp_path.iterdir()} == {
        *("time_history.png", "phase_portraits.png", "trajectory.csv", "events.csv"),
        "about_simulate.json",
    }
    events = rows(tmp_path / "events.csv")
    assert len(events) == 22  # two periods of 11 events
    assert float(events[0]["t"]) == pytest.approx(0.028410, abs=1e-6)
    last = rows(tmp_path / "trajectory.csv")[-1]
    assert float(last["t"]) == pytest.approx(2 * 0.14597607, abs=2e-8)
    assert float(last["y"]) == pytest.approx(-2 * 19.4454e-3, abs=2e-7)


@pytest.mark.slow
def test_files_say_what_made_them(tmp_path: Path) -> None:
    """A record beside the tables, which stay as every reader expects them.

    At these starts the beak strikes while the upper sleeve contact is closed: the law decides.
    """
    arguments = ("map", "--points", "2", "--window", "-2.5", "-2.49", "--eps-n1", "0.6")
    assert run(*arguments, "--expansion-friction", "separate", "--out", str(tmp_path))[0] == 0
    record = json.loads((tmp_path / "about_map.json").read_text(encoding="utf-8"))
    assert record["program"] == f"woodpecker-toy {woodpecker.__version__}"
    assert record["command"] == "map"
    window = [-2.5, -2.49]
    asked = {"order": 1, "window": window, "points": 2, "picture": None}
    assert record["options"] == asked
    toy = Toy(eps_n1=0.6, expansion_friction=ExpansionFriction.SEPARATE)
    kept = {name: float(record["toy"].pop(name)) for name in parameters()}
    assert kept == {name: getattr(toy, name) for name in parameters()}
    assert record["toy"] == {"expansion_friction": "separate"}
    assert list(record["files"]) == ["return_map.csv", "return_map.png"]
    table = np.genfromtxt(tmp_path / "return_map.csv", delimiter=",", names=True, usecols=(0, 1))
    assert table["phi_s_start"].tolist() == window
    assert table["phi_s"].tolist() == [first_return(toy, start).phi_s for start in window]
    summed = toy.replace(expansion_friction="summed")
    assert table["phi_s"][0] != first_return(summed, -2.5).phi_s


@pytest.mark.slow
def test_brackets_are_no_markup(tmp_path: Path) -> None:
    folder = tmp_path / "[b]bold[" / ":smile:"
    status, text = run("simulate", "--t-end", "0.05", "--out", str(folder))
    assert status == 0
    assert f"wrote {folder / 'trajectory.csv'}, " in text
    assert re.search(r"t \[s\] +. event", text)
    wrong = tmp_path / "[red]file"
    wrong.write_text("", encoding="utf-8")
    status, text = run("simulate", "--out", str(wrong))
    assert status == 2
    assert "[red]file" in text


@pytest.mark.slow
def test_map_writes_the_map(tmp_path: Path) -> None:
    status, text = run("map", "--points", "200", "--out", str(tmp_path), "--window", "-2", "-0.3")
    assert status == 0
    assert "returned" in text
    table = rows(tmp_path / "return_map.csv")
    assert len(table) == 200
    assert float(table[0]["phi_s_start"]) == -2.0
    assert table[0]["status"] == "returned"
    assert (tmp_path / "return_map.png").stat().st_size > 10_000


def left_open(text: str) -> int:
    """At how many places a picture of the map is not resolved."""
    found = re.search(r"only steep at (\d+) places", " ".join(text.split()))
    return int(found[1]) if found else 0


@NIGHTLY_TOY
@pytest.mark.parametrize(
    "arguments",
    [
        ("--order", "2"),
        ("--order", "3", "--points", "200"),
        ("--window", "-50", "0.1"),
        ("--order", "10"),
    ],
)
def test_the_map_is_drawn_for_every_order_and_window(
    arguments: tuple[str, ...], tmp_path: Path
) -> None:
    """Halved down to neighbouring doubles wherever it is steep, none of these would end."""
    status, text = run("map", *arguments, "--out", str(tmp_path))
    assert status == 0
    assert (tmp_path / "return_map.png").stat().st_size > 10_000
    table = rows(tmp_path / "return_map.csv")
    assert len(table) == (200 if "200" in arguments else 4000)
    if "10" in arguments:
        assert left_open(text) > 100
        spent = re.search(r"(\d+) of at most (\d+) returns", " ".join(text.split()))
        assert spent is not None
        assert int(spent[1]) <= int(spent[2]) == BUDGET
    else:
        assert left_open(text) == 0  # the budget does for all of it


@pytest.mark.slow
def test_diagram_writes_picture_tables_and_graphs(tmp_path: Path) -> None:
    arguments = ("--span", "0.4", "0.7", "--step", "0.01", "--out", str(tmp_path))
    status, text = run("diagram", *arguments)
    assert status == 0
    assert "flip" in text
    assert "replaces" not in text
    first, second = (read_graph(tmp_path / name) for name in ("graph.graphml", "graph.json"))
    assert dict(first.nodes(data=True)) == dict(second.nodes(data=True))
    points = rows(tmp_path / "points.csv")
    assert {row["id"] for row in points} == set(first.nodes)
    flips = [float(row["eps_n1"]) for row in points if row["kind"] == "PD"]
    assert flips == pytest.approx([0.6485492], abs=1e-6)
    assert first.graph["program"] == f"woodpecker-toy {woodpecker.__version__}"
    assert json.loads(first.graph["toy"])["expansion_friction"] == "summed"
    assert json.loads(first.graph["settings"]) == {"max_step": 0.01}
    assert len({row["id"] for row in rows(tmp_path / "branches.csv")}) == len(first.edges)
    assert (tmp_path / "diagram.png").stat().st_size > 10_000


@pytest.mark.slow
def test_what_is_observed_stands_beside_the_multiplier(tmp_path: Path) -> None:
    """The motion of the paper falls 19.4454 mm in 0.14597607 s."""
    arguments = ("--span", "0.45", "0.5", "--observables", "drop,period", "--out", str(tmp_path))
    status, text = run("diagram", *arguments)
    assert status == 0, text
    table = rows(tmp_path / "branches.csv")
    names = list(table[0])
    assert names[names.index("multiplier") :] == ["multiplier", "drop", "period"]
    (row,) = [row for row in table if float(row["eps_n1"]) == 0.5 and row["id"] == "F1"]
    toy = Toy()
    back = first_return(toy, float(row["phi_s"]))
    own = float(row["drop"]), float(row["period"])  # along the path, to rounding
    assert own == pytest.approx((back.drop, back.period), rel=1e-14)
    assert float(row["period"]) == pytest.approx(0.14597607, abs=5e-9)  # of the last digit
    assert float(row["drop"]) == pytest.approx(19.4454e-3, abs=5e-8)


@NIGHTLY_TOY
def test_points_have_their_names_and_causes(tmp_path: Path) -> None:
    """A, B and C by default, others on request; the words of samples are those of stretches."""
    status, text = run("diagram", "--span", "0.1", "0.5", "--words", "--out", str(tmp_path))
    assert status == 0
    points = {row["name"]: row for row in rows(tmp_path / "points.csv") if row["name"]}
    assert {name: round(float(row["eps_n1"]), 8) for name, row in points.items()} == {
        "A": 0.11197091, "B": 0.29152171, "C": 0.18512695,
    }  # fmt: skip
    for row in points.values():
        assert row["cause"] == "the beak and the upper sleeve strike at once"
        assert row["status"] == "located"
        assert float(row["interval_min"]) < float(row["eps_n1"]) < float(row["interval_max"])
    graph = read_graph(tmp_path / "graph.graphml")
    assert {data["name"] for _, data in graph.nodes(data=True)} == {"A", "B", "C", ""}
    branches = rows(tmp_path / "branches.csv")
    for _, _, name, data in graph.edges(keys=True, data=True):
        words = [row["word"] for row in branches if row["id"] == name]
        stretches = [word for k, word in enumerate(words) if k == 0 or word != words[k - 1]]
        assert "; ".join(stretches) == data["words"]
    assert "(BC" in text
    arguments = ("--span", "0.18", "0.5", "--names", "Q=0.184,-0.757", "--out", str(tmp_path))
    status, text = run("diagram", *arguments)
    assert status == 0
    assert [row["name"] for row in rows(tmp_path / "points.csv") if row["name"]] == ["Q"]


@NIGHTLY_TOY
def test_an_id_that_is_not_there_leaves_the_results_without_names(tmp_path: Path) -> None:
    arguments = ("--parameter", "mu_2", "--span", "0.295", "0.305", "--out", str(tmp_path))
    status, text = run("diagram", *arguments, "--names", "flip=PD9")
    assert status == 2
    assert "Error: --names: no special point 'PD9' in this diagram" in text
    record = json.loads((tmp_path / "about_diagram.json").read_text())
    assert {"points.csv", "diagram.json", "diagram.png"} <= {*record["files"]}
    first, *_ = rows(tmp_path / "points.csv")
    assert first["name"] == ""
    assert run("diagram", *arguments, "--names", f"end={first['id']}")[0] == 0
    assert rows(tmp_path / "points.csv")[0]["name"] == "end"


@SLOW_TOY
def test_the_picture_of_a_diagram_names_the_unit_of_its_parameter(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    labels = list[str]()

    def draw(_: Results, __: str, figure: Any) -> None:
        labels.append(figure.axes[0].get_xlabel())

    monkeypatch.setattr(Results, "draw", draw)
    span = ("--parameter", "l-s", "--span", "0.02", "0.0202")
    assert run("diagram", *span, "--out", str(tmp_path))[0] == 0
    assert labels == ["$l_{S}$ [m]"]


@SLOW_TOY
def test_every_branch_with_pictures_of_each_order_and_of_fold_flips(tmp_path: Path) -> None:
    """Order 1 and 2 next to A: diagram, one picture for each order, and A beside its model."""
    arguments = [
        "diagram", "--orders", "1,2", "--span", "0.1115", "0.1125", "--window", "-0.9", "-0.87",
        "--models", "--out", str(tmp_path),
    ]  # fmt: skip
    status, text = run(*arguments)
    assert status == 0, text
    pictures = {path.name for path in tmp_path.glob("*.png")}
    assert {"diagram.png", "order_1.png", "order_2.png"} < pictures
    assert any(name.startswith("local_FF") for name in pictures)
    assert "P_1 was evaluated" in text
    status, again = run(*arguments, "--resume")
    assert status == 0
    _, _, again = again.partition("\n")  # what it replaces
    assert [line for line in again.splitlines() if "FF" in line] == [
        line for line in text.splitlines() if "FF" in line
    ]
    status, text = run(*arguments[:-4], "-0.86", *arguments[-2:], "--resume")
    assert status == 2
    assert "cannot resume" in " ".join(text.split())


@pytest.mark.slow
def test_animate_writes_a_picture_that_moves(tmp_path: Path) -> None:
    options = ("--slow", "4", "--fps", "10", "--size", "2", "2.5")
    status, text = run("animate", *options, "--out", str(tmp_path))
    assert status == 0, text
    size = (tmp_path / "woodpecker.gif").read_bytes()[6:10]  # of a GIF, after its signature
    assert struct.unpack("<HH", size) == (200, 250)
    assert (tmp_path / "woodpecker.gif").stat().st_size > 10_000
    record = json.loads((tmp_path / "about_animate.json").read_text())
    assert record["options"]["slow"] == 4.0
    assert list(record["files"]) == ["woodpecker.gif"]
    status, text = run("animate", "--file", "../toy.gif", "--out", str(tmp_path))
    assert (status, "a name without folders, got '../toy.gif'" in text) == (2, True)
    status, text = run("animate", "--file", "toy.bmp", "--out", str(tmp_path))
    assert "replaces" not in text
    assert status == 2
    assert ".gif" in text
