"""A signal to a command alone, as `kill` sends it: it ends at once, with what is finished kept.

The commands run elsewhere, as real processes; they take the kernel that is cached here.
"""

import csv
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from needs import NIGHTLY_TOY, SLOW_TOY
from processes import SIGNALS, is_running, seconds, started, wait_until
from typer.testing import CliRunner

import woodpecker
from pwmap.diagrams.shown import counted
from woodpecker import Curve, Toy, diagrams, load_diagram, return_map, saved_diagram
from woodpecker.base.lost import WorkerLostError
from woodpecker.cli import curves as curves_command
from woodpecker.cli.app import app
from woodpecker.search import Stage

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="asks /proc who is there")
AT_ONCE = 2.0  # s, on a machine that has nothing else to do; busy ones take a multiple
BUSY = 15.0


def children(pid: int) -> list[int]:
    try:
        tasks = list(Path(f"/proc/{pid}/task").iterdir())
        return [int(c) for task in tasks for c in (task / "children").read_text().split()]
    except OSError:
        return []


def ended(process: subprocess.Popen[str], number: signal.Signals) -> tuple[str, str]:
    """What a process says that a signal ends, alone; its workers end with it."""
    workers = children(process.pid)
    process.send_signal(number)
    begin = time.monotonic()
    text, complaint = process.communicate(timeout=BUSY)
    wait_until(lambda: not any(map(is_running, workers)), AT_ONCE + BUSY)
    assert time.monotonic() - begin < BUSY
    return text, complaint


@NIGHTLY_TOY
@pytest.mark.parametrize("number", SIGNALS)
def test_a_search_keeps_what_is_finished(number: signal.Signals, tmp_path: Path) -> None:
    return_map(Toy(), [-0.9])  # compiles, if that was not done before
    run = tmp_path / "run.jsonl"
    arguments = ("diagram", "--orders", "1,2,3,4", "--workers", "2", "--out", str(tmp_path))
    with started("-m", "woodpecker", *arguments) as process:
        wait_until(lambda: run.exists() and run.read_bytes().count(b"\n") > 3)
        wait_until(lambda: len(children(process.pid)) == 1)  # the process works, too
        text, complaint = ended(process, number)
    assert process.returncode == 130
    kept = load_diagram(tmp_path / "diagram.json")
    count = counted(len(kept.branches), "branch")
    assert f"Interrupted: {count} kept, as tables; go on" in complaint
    assert len(kept.branches) == len(saved_diagram(run).branches) > 0
    assert "points.csv" in text
    assert not list(tmp_path.glob("*.png"))  # pictures would take their time


@NIGHTLY_TOY
@pytest.mark.parametrize("number", SIGNALS)
def test_a_map_keeps_the_starts_that_are_finished(number: signal.Signals, tmp_path: Path) -> None:
    """A million starts would take minutes, and many seconds to become a table."""
    return_map(Toy(), [-0.9])  # compiles, if that was not done before
    folder = tmp_path / "out"
    arguments = ("map", "--order", "10", "--points", "1000000", "--out", str(folder))
    with started("-m", "woodpecker", *arguments) as process:
        wait_until(folder.exists)  # made right before the first starts
        begin = seconds(process.pid)
        wait_until(lambda: seconds(process.pid) > begin + 3.0)
        text, complaint = ended(process, number)
    assert process.returncode == 130
    kept = re.search(r"Interrupted: (\d+) of 1000000 starts are kept, as a table\n", complaint)
    assert kept is not None
    assert "wrote" in text
    with (folder / "return_map.csv").open(encoding="utf-8", newline="") as file:
        table = list(csv.DictReader(file))
    assert 0 < len(table) == int(kept[1]) < 1_000_000
    assert float(table[0]["phi_s_start"]) == -2.5
    assert {path.name for path in folder.iterdir()} == {"return_map.csv", "about_map.json"}


PROOF = """
from woodpecker import Toy, continuation, prove, shoot
if __name__ == "__main__":
    toy = Toy()
    branch, = continuation(toy, shoot(toy, -0.53), span=(0.45, 0.55)).branches
    if {spawned}:
        import threading, time
        threading.Thread(target=time.sleep, args=(1000.0,), daemon=True).start()
    prove(branch, (0.46, 0.54), toy=toy, workers=2)
"""


@NIGHTLY_TOY
@pytest.mark.parametrize("spawned", [False, True], ids=["fork", "spawn"])
@pytest.mark.parametrize("number", [*SIGNALS, signal.SIGKILL])
def test_workers_of_a_proof_end_with_it(
    number: signal.Signals, spawned: bool, tmp_path: Path
) -> None:
    pytest.importorskip("flint")
    return_map(Toy(), [-0.9])
    script = tmp_path / "proof.py"
    script.write_text(PROOF.format(spawned=spawned), encoding="utf-8")
    with started(str(script)) as process:
        wait_until(lambda: len(children(process.pid)) >= 2)
        time.sleep(1.5)  # they are at work
        ended(process, number)
    assert process.returncode in (1, -number)  # a script that nothing was told about signals


@NIGHTLY_TOY
def test_a_command_ends_while_its_kernel_is_compiled(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The compiler runs for many seconds in which no Python does."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    with started("-m", "woodpecker", "map", "--out", str(tmp_path / "out")) as process:
        assert process.stderr is not None
        assert "compiling the kernel" in process.stderr.readline()
        time.sleep(3.0)
        _, complaint = ended(process, signal.SIGTERM)
    assert process.returncode == 130
    assert complaint == "Interrupted before anything was finished\n"
    assert not (tmp_path / "out").exists()


BUSY_IN_C = """
from pathlib import Path
from pwmap.cli.interrupts import at_once, listen
from pwmap.cli.results import asked, results_in, table_in
import ctypes, signal, time
listen()
with at_once():
    pass
asked.set(("test", {{}}))
with results_in(Path({folder!r}), "run.jsonl") as results:
    if {finished!r} == "table":
        results.write({{"table.csv": table_in(("a",), [("1",)])}})
    if {finished!r} == "run":
        (results.folder / "run.jsonl").touch()
    with at_once():
        print("begins", flush=True)
        ctypes.CDLL(None).clock_nanosleep(0, 0, (ctypes.c_long * 2)(50, 0), None)
        ctypes.CDLL(None).clock_nanosleep(0, 0, (ctypes.c_long * 2)(50, 0), None)
print("not reached")
"""


@pytest.mark.slow
@pytest.mark.parametrize("number", SIGNALS)
@pytest.mark.parametrize("finished", ["nothing", "run", "table"])
def test_a_request_ends_what_python_does_not_run(
    finished: str, number: signal.Signals, tmp_path: Path
) -> None:
    """As in a compiler: two calls of C, so that the end of the first one is not the end."""
    folder = tmp_path / "out"
    with started("-c", BUSY_IN_C.format(folder=str(folder), finished=finished)) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "begins\n"
        text, complaint = ended(process, number)
    assert process.returncode == 130
    if finished == "run":
        kept = f"Interrupted: what was finished is kept, in {folder / 'run.jsonl'}\n"
        assert (text, complaint) == ("", kept)
    elif finished == "table":
        table, record = folder / "table.csv", folder / "about_test.json"
        assert text == f"wrote {table}, {record}\n"
        assert complaint == "Interrupted: what was finished is kept\n"
        assert {*folder.iterdir()} == {table, record}
    else:
        assert (text, complaint) == ("", "Interrupted before anything was finished\n")
        assert not folder.exists()


def said(*code: str) -> tuple[int, str, str]:
    """Status, output and complaint of some lines that end by themselves."""
    with started("-c", *code) as process:
        text, complaint = process.communicate(timeout=30.0)
    return process.returncode, text, complaint


def test_a_closed_terminal_is_no_request_under_nohup() -> None:
    code = "from pwmap.cli.interrupts import listen\nimport os, signal\nlisten()\n"
    code += "os.kill(os.getpid(), signal.SIGHUP)\nprint('goes on')"
    ignored = "import os, signal, sys\nsignal.signal(signal.SIGHUP, signal.SIG_IGN)\n"
    ignored += "os.execv(sys.executable, [sys.executable, '-c', sys.argv[1]])"
    assert said(ignored, code) == (0, "goes on\n", "")


LOST = """
from pwmap.cli.interrupts import listen, stop_repeating
import os, signal, time
listen()
class Drops:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(0.1)
class Fails:
    def __del__(self):
        raise ValueError("told")
Drops()  # Python drops what is raised there
Fails()
print("dropped", flush=True)
try:
    time.sleep(60.0)
except KeyboardInterrupt:
    stop_repeating()
    time.sleep(1.5)
    print("heard")
"""


@pytest.mark.nightly
def test_a_request_that_is_lost_is_repeated_until_it_is_heard() -> None:
    status, text, complaint = said(LOST)
    assert (status, text.split()) == (0, ["dropped", "heard"])
    assert "ValueError: told" in complaint
    assert "KeyboardInterrupt" not in complaint


EARLY = """
import os, signal, sys
class Asks:
    def find_spec(self, name, *_):
        if name == "{module}":
            os.kill(os.getpid(), signal.{number})
sys.meta_path.insert(0, Asks())
sys.argv = ["{package}", "--version"]
from {package}.__main__ import run
run()
"""


@pytest.mark.slow
@pytest.mark.parametrize("number", SIGNALS)
@pytest.mark.parametrize("package", ["pwmap", "woodpecker"])
@pytest.mark.parametrize("module", ["typer", "rich.markup", "{package}.version"])
def test_a_command_ends_while_it_is_loaded(
    package: str, module: str, number: signal.Signals
) -> None:
    code = EARLY.format(module=module.format(package=package), package=package, number=number.name)
    assert said(code) == (130, "", "Interrupted before anything was finished\n")


WHOLE = """
from pwmap.cli.interrupts import held, ignore_requests, listen
import os, signal
listen()
try:
    with held():
        os.kill(os.getpid(), signal.SIGTERM)
        print("written", flush=True)
    print("not reached")
except KeyboardInterrupt:
    print("taken")
ignore_requests()
os.kill(os.getpid(), signal.SIGINT)
print("told")
"""


@pytest.mark.slow
def test_files_are_written_whole_before_a_request_is_taken() -> None:
    assert said(WHOLE) == (0, "written\ntaken\ntold\n", "")


# --- What is kept ---------------------------------------------------------------------------------


def stopped(command: str, *arguments: str, out: Path) -> str:
    """What a command says that is interrupted after one curve; all its tables are there."""
    near = "--second-span", "0.298", "0.302", "--out", str(out)
    result = CliRunner().invoke(app, [command, *arguments, *near])
    assert result.exit_code == 130
    names = {path.name for path in out.iterdir()}
    assert names == {*curves_command.TABLES, *curves_command.GRAPHS, f"about_{command}.json"}
    return result.output


@SLOW_TOY
def test_curves_that_are_finished_are_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    follow, found = woodpecker.curve_in_two, list[Curve]()

    def interrupted(*arguments: Any) -> Any:
        if found:
            raise KeyboardInterrupt
        found.append(follow(*arguments))
        return found[-1]

    monkeypatch.setattr(woodpecker, "curve_in_two", interrupted)
    output = stopped("curves", "--from", "A,C", out=tmp_path)
    assert "Interrupted: 1 of 2 curves are kept, as tables" in output


@SLOW_TOY
def test_curves_between_regions_are_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    search = woodpecker.regions.parameter_regions

    def interrupted(*arguments: Any, progress: Callable[[Curve], None], **options: Any) -> Any:
        def show(curve: Curve) -> None:
            progress(curve)
            raise KeyboardInterrupt

        return search(*arguments, progress=show, **options)

    monkeypatch.setattr(woodpecker.regions, "parameter_regions", interrupted)
    near = "--span", "0.6", "0.7", "--window", "-0.6", "-0.45"
    output = stopped("regions", *near, out=tmp_path)
    assert "Interrupted: 1 curve kept, as tables; no regions between them" in output


def test_where_nothing_is_finished_nothing_is_left(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    commands = {"simulate": "shoot", "robustness": "shoot", "prove": "shoot", "map": "return_map"}
    for command, name in commands.items():
        monkeypatch.setattr(woodpecker, name, interrupted)
        result = CliRunner().invoke(app, [command, "--out", str(tmp_path / "out")])
        assert result.exit_code == 130
        assert "Interrupted before anything was finished" in result.output
        assert not (tmp_path / "out").exists()


@SLOW_TOY
@pytest.mark.parametrize(
    ("error", "status", "said"),
    [
        (WorkerLostError("a process ended"), 1, "Broken off: a process ended: 1 branch"),
        (MemoryError(), 1, "Broken off: no memory is left: 1 branch"),
        (KeyboardInterrupt(), 130, "Interrupted: 1 branch"),
    ],
)
def test_a_search_that_loses_a_process_keeps_what_is_finished(
    error: BaseException, status: int, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    search = diagrams.bifurcation_search

    def broken(*arguments: Any, **options: Any) -> Any:
        def show(stage: Stage) -> None:
            if stage.branches > 1:
                raise error

        return search(*arguments, **options | {"progress": show, "workers": 1})

    monkeypatch.setattr(diagrams, "bifurcation_search", broken)
    near = ("--orders", "1", "--span", "0.33", "0.4", "--window", "-1.2", "-0.7")
    result = CliRunner().invoke(app, ["diagram", *near, "--out", str(tmp_path)])
    assert result.exit_code == status
    assert said in " ".join(result.output.split())
    assert len(load_diagram(tmp_path / "diagram.json").branches) == 1
