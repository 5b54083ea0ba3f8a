"""The commands: results, help, and one clear sentence for a wrong value."""

import csv
from pathlib import Path

import pytest
from typer.testing import CliRunner

from pwmap import read_graph
from woodpecker.cli import app
from woodpecker.compiled import COMPILED

runner = CliRunner()


def run(*arguments: str) -> tuple[int, str]:
    result = runner.invoke(app, list(arguments))
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result.exit_code, result.output


@pytest.mark.parametrize("command", ["simulate", "map", "diagram"])
def test_help_has_an_example(command: str) -> None:
    status, text = run(command, "--help")
    assert status == 0
    assert f"woodpecker {command}" in " ".join(text.split())
    assert "--eps-n1" in text
    assert "--out" in text


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--m-s", "-1"], "m_s must be positive and finite, got -1.0"),
        (["--eps-n1", "1.5"], "eps_n1 must lie in [0, 1], got 1.5"),
        (["--r-m", "0.002"], "r_m must exceed r_0 = 0.0025"),
        (["--mu-2", "nan"], "mu_2 must be at least 0 and finite, got nan"),
        (["--out", "/dev/null/x"], "/dev/null/x"),
    ],
)
@pytest.mark.parametrize("command", ["simulate", "map", "diagram"])
def test_wrong_value_gets_one_sentence_and_status_2(
    command: str, arguments: list[str], sentence: str, tmp_path: Path
) -> None:
    out = [] if "--out" in arguments else ["--out", str(tmp_path / "out")]
    status, text = run(command, *arguments, *out)
    assert status == 2
    assert sentence in text
    assert "Traceback" not in text
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["diagram", "--parameter", "eps_n9"], "unknown parameter 'eps_n9'"),
        (["diagram", "--span", "0.6", "0.9"], "span must hold eps_n1 = 0.5"),
        (["diagram", "--span", "0.9", "0.1"], "span must ascend"),
        (["map", "--window", "-0.2", "-0.3"], "window must ascend"),
        (["map", "--window", "-0.2", "0.3"], "where the beak touches the pole"),
        (["simulate", "--phi-s", "0.2", "--t-end", "1"], "the start penetrates contact 1"),
        (["simulate", "--phi-s", "-0.5", "--t-end", "-1"], "t_end must be positive"),
    ],
)
def test_wrong_request_gets_one_sentence(arguments: list[str], sentence: str) -> None:
    status, text = run(*arguments)
    assert status == 2
    assert sentence in text


def test_unknown_option_and_unreadable_number_have_status_2() -> None:
    assert run("simulate", "--mass", "1")[0] == 2
    assert run("simulate", "--g", "heavy")[0] == 2


def test_a_motion_that_does_not_exist_has_status_1(tmp_path: Path) -> None:
    status, text = run("diagram", "--phi-s", "-0.05", "--out", str(tmp_path))
    assert status == 1
    assert "no periodic motion near phi_S = -0.05" in text
    assert not list(tmp_path.iterdir())


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_simulate_writes_two_periods(tmp_path: Path) -> None:
    status, text = run("simulate", "--out", str(tmp_path))
    assert status == 0
    assert "D2" in text
    assert {path.name for path in tmp_path.iterdir()} == {
        *("time_history.png", "phase_portraits.png", "trajectory.csv", "events.csv")
    }
    events = rows(tmp_path / "events.csv")
    assert len(events) == 22  # two periods of 11 events
    assert float(events[0]["t"]) == pytest.approx(0.028410, abs=1e-6)
    last = rows(tmp_path / "trajectory.csv")[-1]
    assert float(last["t"]) == pytest.approx(2 * 0.14597607, abs=2e-8)
    assert float(last["y"]) == pytest.approx(-2 * 19.4454e-3, abs=2e-7)


def test_map_writes_the_map(tmp_path: Path) -> None:
    status, text = run("map", "--points", "200", "--out", str(tmp_path), "--window", "-2", "-0.3")
    assert status == 0
    assert "returned" in text
    table = rows(tmp_path / "return_map.csv")
    assert len(table) == 200
    assert float(table[0]["phi_s_start"]) == -2.0
    assert table[0]["status"] == "returned"
    assert (tmp_path / "return_map.png").stat().st_size > 10_000


@pytest.mark.slow
def test_diagram_writes_picture_tables_and_graphs(tmp_path: Path) -> None:
    status, text = run("diagram", "--span", "0.4", "0.7", "--out", str(tmp_path))
    assert status == 0
    assert "flip" in text
    first, second = (read_graph(tmp_path / name) for name in ("graph.graphml", "graph.json"))
    assert dict(first.nodes(data=True)) == dict(second.nodes(data=True))
    points = rows(tmp_path / "points.csv")
    assert {row["id"] for row in points} == set(first.nodes)
    flips = [float(row["eps_n1"]) for row in points if row["kind"] == "PD"]
    assert flips == pytest.approx([0.6485492], abs=1e-6)
    assert len({row["id"] for row in rows(tmp_path / "branches.csv")}) == len(first.edges)
    assert (tmp_path / "diagram.png").stat().st_size > 10_000


@pytest.mark.slow
@pytest.mark.skipif(not COMPILED, reason="takes minutes without numba")
def test_every_branch_with_pictures_of_each_order_and_of_fold_flips(tmp_path: Path) -> None:
    """Order 1 and 2 next to A: diagram, one picture for each order, and A beside its model."""
    arguments = [
        "diagram", "--orders", "1,2", "--span", "0.0415", "0.043", "--window", "-0.9", "-0.87",
        "--out", str(tmp_path),
    ]  # fmt: skip
    status, text = run(*arguments)
    assert status == 0, text
    pictures = {path.name for path in tmp_path.glob("*.png")}
    assert {"diagram.png", "order_1.png", "order_2.png"} < pictures
    assert any(name.startswith("local_FF") for name in pictures)
    assert "P_1 was evaluated" in text
    status, again = run(*arguments, "--resume")
    assert status == 0
    assert [line for line in again.splitlines() if "FF" in line] == [
        line for line in text.splitlines() if "FF" in line
    ]
    status, text = run(*arguments[:-3], "-0.86", "--out", str(tmp_path), "--resume")
    assert status == 2
    assert "cannot resume" in " ".join(text.split())


@pytest.mark.slow
def test_animate_writes_a_picture_that_moves(tmp_path: Path) -> None:
    status, text = run("animate", "--slow", "4", "--fps", "10", "--out", str(tmp_path))
    assert status == 0, text
    assert (tmp_path / "woodpecker.gif").stat().st_size > 10_000
    status, text = run("animate", "--file", "toy.bmp", "--out", str(tmp_path))
    assert status == 2
    assert ".gif" in text
