"""What all commands share: tables before pictures, one end for all, tables for programs."""

import csv
import errno
import io
import json
import os
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
import typer
from commands import invoked, rows
from processes import environment
from typer.testing import CliRunner

import pwmap
from pwmap import PiecewiseLinearMap
from pwmap.cli import analysis, results
from pwmap.cli import app as pwmap_cli
from pwmap.diagrams import files
from pwmap.diagrams.record import keep_record
from woodpecker import Toy, return_map
from woodpecker.cli.app import app

P1L = ("Piecewise((r - 2, x <= 0), (r - a*x, True))", "--set", "a=1.25", "--parameter", "r")
SKEW = ("Piecewise((a*x + 1, x <= 0), (b*x + 1, True))", "--across", "a", "--along", "b",
        "--across-span", "1/4", "3/4", "--along-span", "-2", "-1/2", "--orders", "1")  # fmt: skip
PWMAP = sys.executable, "-m", "pwmap"
COMMANDS: dict[str, tuple[typer.Typer, tuple[str, ...], str, str]] = {
    # program and arguments, a table that is written, what stands in the table on the screen
    "simulate": (app, ("simulate", "--phi-s", "-0.6", "--t-end", "0.05"), "events.csv", "event"),
    "map": (app, ("map", "--points", "20"), "return_map.csv", "outcome"),
    "analyse": (pwmap_cli.app, ("analyse", *P1L, "--span", "0", "3"), "points.csv", "exists for"),
    "plane": (pwmap_cli.app, ("plane", *SKEW), "plane_curves.csv", "zero on it"),
}


def run(name: str, *more: str) -> Any:
    program, arguments, _, _ = COMMANDS[name]
    return invoked(program, *arguments, *more)


def interrupted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C while the first picture is written."""

    def write(*_: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(files, "write_figure", write)


@pytest.mark.parametrize("name", COMMANDS)
def test_an_interrupted_picture_leaves_tables_that_are_named(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    return_map(Toy(), [-0.9])  # compiles, if that was not done before
    interrupted(monkeypatch)
    *_, table, column = COMMANDS[name]
    found = run(name, "--out", str(tmp_path))
    assert found.exit_code == 130
    there = {path.name for path in tmp_path.iterdir()}
    assert table in there
    assert not [each for each in there if each.endswith(".png")]
    assert column in found.stdout
    assert f"{tmp_path / table}" in found.stdout.splitlines()[-1]
    assert "Interrupted: what was finished is kept" in found.stderr
    record = json.loads((tmp_path / f"about_{name}.json").read_text())
    assert {*record["files"], f"about_{name}.json"} == there


@pytest.mark.nightly
def test_a_rerun_says_first_what_it_replaces(tmp_path: Path) -> None:
    for name in ("simulate", "analyse"):
        assert "replaces" not in run(name, "--out", str(tmp_path)).output
        (tmp_path / "own.csv").write_text("mine")
        first, *_ = run(name, "--out", str(tmp_path)).stderr.splitlines()
        begin = f"replaces what an earlier run wrote into {tmp_path}: "
        assert first.startswith(begin)
        assert COMMANDS[name][2] in first.removeprefix(begin).split(", ")
        assert "own.csv" not in first


def test_a_command_says_which_files_of_another_one_it_replaces(tmp_path: Path) -> None:
    for name in ("points.csv", "diagram.png", "run.jsonl"):
        (tmp_path / name).write_text("of woodpecker diagram")
    said = run("analyse", "--out", str(tmp_path)).stderr.splitlines()
    begin = f"replaces what an earlier run wrote into {tmp_path}: "
    assert [line for line in said if "replaces" in line] == [
        f"{begin}points.csv", f"{begin}diagram.png"
    ]  # fmt: skip
    assert (tmp_path / "run.jsonl").read_text() == "of woodpecker diagram"


@pytest.mark.parametrize("name", COMMANDS)
def test_out_is_a_folder_and_no_file(name: str, tmp_path: Path) -> None:
    (tmp_path / "there").write_text("mine")
    (tmp_path / "null").symlink_to(os.devnull)
    for file, what in (("film.gif", "the name of a file"), ("there", "a file"), ("null", "a file")):
        found = run(name, "--out", str(tmp_path / file))
        assert found.exit_code == 2
        assert f"{tmp_path / file}: --out is a folder, and this is {what}" in found.output
    inside = run(name, "--out", str(tmp_path / "there" / "out"))
    assert inside.exit_code == 2
    assert inside.output.strip().startswith(f"Error: {tmp_path / 'there' / 'out'}: ")
    assert "Errno" not in inside.output
    assert {path.name for path in tmp_path.iterdir()} == {"there", "null"}


# --- Tables for programs --------------------------------------------------------------------------


@pytest.mark.nightly
def test_a_pipe_breaks_no_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("COLUMNS", raising=False)
    lines = run("analyse", "--orders", "1,2,3", "--out", str(tmp_path)).stdout.splitlines()
    (row,) = [line for line in lines if line.startswith("│ J5 ")]
    assert row.strip("│").split("│")[-1].strip() == "r in (2, 50/21)"
    assert max(map(len, lines)) > 80


PICTURES = {
    "simulate": {"time_history", "phase_portraits"}, "map": {"return_map"}, "plane": {"plane"},
    "analyse": {"diagram", "order_1", "order_2"},
}  # fmt: skip


def told(name: str, folder: Path) -> list[str]:
    """How the rows of the first table on stdout begin, from the tables that are written."""
    written = rows(folder / {"analyse": "branches.csv"}.get(name, COMMANDS[name][2]))
    match name:
        case "simulate":
            begins = [f"{float(event['t']):.9f}" for event in written]
        case "map":
            begins = [str(count) for count in Counter(row["status"] for row in written).values()]
        case _:
            begins = [row["id"] for row in written]
    return [*dict.fromkeys(begins)]


@pytest.mark.nightly
@pytest.mark.parametrize("name", COMMANDS)
def test_tables_as_csv_stand_alone_on_stdout(name: str, tmp_path: Path) -> None:
    found = run(name, "--format", "csv", "--format", "svg", "--out", str(tmp_path))
    assert found.exit_code == 0
    lines = [*csv.reader(io.StringIO(found.stdout)), []]
    header, *table = lines[: lines.index([])]
    assert COMMANDS[name][3] in header
    assert {len(row) for row in table} == {len(header)}
    assert [*dict.fromkeys(row[0] for row in table)] == told(name, tmp_path)
    assert "wrote" in found.stderr
    assert {path.stem for path in tmp_path.glob("*.svg")} == PICTURES[name]
    assert not [*tmp_path.glob("*.png")]


@pytest.mark.slow
def test_tables_as_json_are_one_object_a_line(tmp_path: Path) -> None:
    found = run("analyse", "--orders", "1", "--format", "json", "--out", str(tmp_path))
    branches, points = (json.loads(line) for line in found.stdout.splitlines())
    assert branches["columns"][:2] == ["branch", "kind"]
    assert [row[0] for row in branches["rows"]] == ["F1", "F2", "J1"]
    assert points["table"] == "3 branches, 4 special points, 0 changes of word"


def test_pictures_in_several_formats_at_once(tmp_path: Path) -> None:
    formats = ("--format", "pdf", "--format", "png", "--format", "pdf")
    found = run("plane", *formats, "--out", str(tmp_path))
    assert found.exit_code == 0
    assert found.stdout.count("plane.pdf") == found.stdout.count("plane.png") == 1
    assert {path.name for path in tmp_path.glob("plane.p*")} == {"plane.pdf", "plane.png"}


# --- The end of commands that write one file ------------------------------------------------------


@pytest.mark.parametrize(
    ("program", "command", "kind"),
    [
        (app, "map", "<folder>"), (app, "prove", "<folder>"), (pwmap_cli.app, "plane", "<folder>"),
        (pwmap_cli.app, "prove", "<file>"),
    ],
)  # fmt: skip
def test_help_says_whether_results_go_into_a_file(
    program: typer.Typer, command: str, kind: str
) -> None:
    lines = CliRunner().invoke(program, [command, "--help"]).output.splitlines()
    (line,) = [each for each in lines if "--out" in each and "xample" not in each]
    assert kind in line


@pytest.mark.parametrize("program", [app, pwmap_cli.app], ids=["toy", "maps"])
def test_a_check_of_a_record_names_the_certificate(program: typer.Typer, tmp_path: Path) -> None:
    (tmp_path / "certificate.json").touch()
    keep_record(tmp_path, "prove", ["certificate.json"], {})
    record = tmp_path / "about_prove.json"
    found = CliRunner().invoke(program, ["check", str(record)])
    assert found.exit_code == 1
    said = f"it is the record of a command and no certificate; check {tmp_path}/certificate.json"
    assert said in " ".join(found.stderr.split())
    keep_record(tmp_path, "map", ["certificate.json"], {})
    found = CliRunner().invoke(program, ["check", str(tmp_path / "about_map.json")])
    assert found.stderr.endswith("it is the record of a command and no certificate\n")


@pytest.mark.parametrize(
    ("program", "package"), [(app, "woodpecker"), (pwmap_cli.app, "pwmap")], ids=["toy", "maps"]
)
def test_a_check_that_is_interrupted_says_so(
    program: typer.Typer, package: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def check(*_: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(f"{package}.check_certificate", check)
    found = CliRunner().invoke(program, ["check", str(tmp_path / "certificate.json")])
    assert found.exit_code == 130
    assert found.stderr.startswith("Interrupted while ")


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="a stdout that is full is a file of Linux")
@pytest.mark.parametrize(
    ("arguments", "status", "said"),
    [
        (("--help",), 1, "Failed: No space left on device\n"),
        (("check", "CERTIFICATE"), 1, "Failed: No space left on device\n"),
        (("prove", "x/2"), 1, "Failed: No space left on device; the certificate is there\n"),
        (("analyse", *P1L, "--span", "0", "3"), 1, "Failed: No space left on device; what was"),
    ],
    ids=["help", "check", "prove", "analyse"],
)
def test_a_full_stdout_is_told_on_stderr(
    arguments: tuple[str, ...], status: int, said: str, tmp_path: Path
) -> None:
    """What is finished is kept and named."""
    names = {"analyse": "points.csv", "prove": "certificate.json"}
    name = names.get(arguments[0], "")
    out = ("--out", str(tmp_path / "out")) if name else ()
    if arguments[0] == "check":
        certificate = tmp_path / "certificate.json"
        pwmap.prove(PiecewiseLinearMap.from_sympy("x/2")).save(certificate)
        arguments = ("check", str(certificate))
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [*PWMAP, *arguments, *out], stdout=full, stderr=subprocess.PIPE, text=True,
            check=False, env=environment(),
        )  # fmt: skip
    assert done.returncode == status
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    if out:
        assert name in done.stderr
        assert (tmp_path / "out" / name).exists()


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="a stderr that is full is a file of Linux")
def test_a_full_stderr_does_not_change_the_status() -> None:
    wrong = [*PWMAP, "analyse", "(", "--parameter", "p"]
    with Path("/dev/full").open("w") as full:
        assert subprocess.run(wrong, stderr=full, check=False, env=environment()).returncode == 2


def test_a_folder_that_cannot_be_written_is_refused_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Before anything is computed."""

    def refuse(*_: Any, **__: Any) -> None:
        raise PermissionError(errno.EACCES, "Permission denied", "a name of no interest")

    monkeypatch.setattr(results, "TemporaryFile", refuse)
    monkeypatch.setattr(analysis, "bifurcation_diagram", None)
    found = run("analyse", "--out", str(tmp_path))
    assert (found.exit_code, found.output) == (2, f"Error: {tmp_path}: Permission denied\n")
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_a_folder_that_is_removed_meanwhile_is_made_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What was computed is written into it."""
    folder, follow = tmp_path / "out", analysis.bifurcation_diagram

    def removed(*arguments: Any, **options: Any) -> Any:
        folder.rmdir()
        return follow(*arguments, **options)

    monkeypatch.setattr(analysis, "bifurcation_diagram", removed)
    assert run("analyse", "--out", str(folder)).exit_code == 0
    assert (folder / "points.csv").exists()


@pytest.mark.slow
def test_a_path_is_said_in_any_encoding(tmp_path: Path) -> None:
    """Windows writes into a pipe in the encoding of the country."""
    file, country = tmp_path / "\u0416.json", {"PYTHONUTF8": "0", "PYTHONIOENCODING": "cp1252"}
    prove = [*PWMAP, "prove", "x/2", "--out", str(file)]
    done = subprocess.run(prove, capture_output=True, check=False, env=environment(**country))
    assert done.returncode == 0
    assert done.stdout.decode("cp1252").endswith("\\u0416.json" + os.linesep)
    assert file.exists()


def test_tables_before_one_that_fails_are_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The graph fills the disk after both tables are there."""
    write = files.write_whole

    def filled(path: Path, *rest: Any) -> None:
        if path.suffix == ".graphml":
            raise OSError(errno.ENOSPC, "No space left on device", str(path))
        write(path, *rest)

    monkeypatch.setattr(analysis, "write_whole", filled)
    (tmp_path / "diagram.json").write_text("of an earlier run", encoding="utf-8")
    found = run("analyse", "--out", str(tmp_path))
    assert found.exit_code == 1
    said = " ".join(found.output.split())
    assert "graph.graphml: No space left on device; what was finished is kept" in said
    before, named = said.rsplit("wrote ", 1)
    assert "diagram.json" in before.split("replaces what an earlier run wrote into ")[1]
    assert "points.csv" in named
    assert "branches.csv" in named
    assert "diagram.json" not in named
