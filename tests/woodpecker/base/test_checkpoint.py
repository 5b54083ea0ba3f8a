"""Files that grow line by line: locks, what is kept of an older run, what is no such file."""

import json
import math
import multiprocessing
import re
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import pytest

from woodpecker.base.checkpoint import TAIL, Checkpoint, Entry, line_of, read

ABOUT: Entry = {"parameter": "p", "span": [-2.0, 2.0]}
VERSION = 7
ONE: Entry = {"number": 1.0}


def parsed(entry: Entry) -> Entry:
    if not isinstance(entry["number"], float):
        raise TypeError("expected a number")
    return entry


def opened(path: Path, run: Entry = ABOUT, *, resume: bool = False) -> Checkpoint:
    return Checkpoint(path, run, version=VERSION, parsed=parsed, resume=resume)


def entries(path: Path) -> list[Entry]:
    return read(path, version=VERSION, parsed=parsed)[1]


def test_what_is_written_is_read(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    file = opened(path)
    for value in (0.1, -1e-300, math.inf):
        file.write({"number": value})
        assert entries(path)[-1] == {"number": value}  # while the run goes on
    file.close()
    again = opened(path, resume=True)
    assert again.entries == [{"number": 0.1}, {"number": -1e-300}, {"number": math.inf}]
    again.write(ONE)
    again.close()
    assert read(path, version=VERSION, parsed=parsed) == (ABOUT, [*again.entries, ONE])
    assert json.loads(path.read_text().splitlines()[0])["version"] == VERSION


@pytest.mark.parametrize(
    ("there", "now", "sentence"),
    [
        ({"toy": {"mu": 0.3}}, {"toy": {"mu": 0.31}}, "there mu of toy is 0.3, now it is 0.31"),
        ({"at": 0.5}, {}, "there at is 0.5, now there is none"),
        ({}, {"search": {"slices": 63}}, 'there is no search there, now it is {"slices": 63}'),
        ({"toy": {"a": 1, "b": 2}}, {"toy": {"a": 1}}, "there b of toy is 2, now there is none"),
        (
            {"settings": {"n": {"x": 1.0}}},
            {"settings": {"n": {"x": 1.0, "y": 2.0}}},
            "there is no y of n of settings there, now it is 2.0",
        ),
        ({"toy": {"mu": 0.3}}, {"toy": None}, "there toy is {'mu': 0.3}, now it is None"),
    ],
)
def test_the_one_value_that_differs_is_named(
    there: Entry, now: Entry, sentence: str, tmp_path: Path
) -> None:
    path = tmp_path / "run.jsonl"
    opened(path, ABOUT | there).close()
    with pytest.raises(ValueError, match=re.escape(f"cannot resume {path}: {sentence}") + "$"):
        opened(path, ABOUT | now, resume=True)


def test_an_old_run_is_kept_when_a_new_one_starts(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    opened(path).close()
    before = path.read_text(encoding="utf-8")
    opened(path, ABOUT | {"span": [0.0, 1.0]}).close()
    assert (tmp_path / "run.jsonl.old").read_text(encoding="utf-8") == before
    assert read(path, version=VERSION, parsed=parsed)[0]["span"] == [0.0, 1.0]


def test_only_the_same_run_is_resumed(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    with pytest.raises(ValueError, match="there is no saved run"):
        opened(path, resume=True)
    assert not path.exists()
    opened(path).close()
    with pytest.raises(ValueError, match=r"there span is \[-2.0, 2.0\], now it is \[0.0, 1.0\]"):
        opened(path, ABOUT | {"span": [0.0, 1.0]}, resume=True)
    opened(path, {"span": (-2, 2.0), "parameter": "p"}, resume=True).close()  # as JSON has it
    path.write_text("phi_s,eps_n1\n", encoding="utf-8")
    with pytest.raises(ValueError, match="line 1: not the checkpoint of a run"):
        opened(path, resume=True)


def test_a_start_is_the_same_up_to_rounding(tmp_path: Path) -> None:
    """Another machine finds the same solution with other last bits."""
    path, about = tmp_path / "run.jsonl", ABOUT | {"start": [-0.5, -0.25]}
    opened(path, about).close()
    near = [math.nextafter(-0.5, 0.0), -0.25 + 9e-10]
    opened(path, ABOUT | {"start": near}, resume=True).close()
    for other in ([-0.5, -0.25 + 2e-9], [-0.5], [math.nan, -0.25], "a", None):
        with pytest.raises(ValueError, match=r"there start is \[-0.5, -0.25\], now it is"):
            opened(path, ABOUT | {"start": other}, resume=True)


def lines_of(path: Path, *lines: object) -> Path:
    """A file with the digests that lines have; of what is no entry there is none."""
    written = [b""]
    for line in lines:
        before = TAIL.search(written[-1][:-1])
        digest = "" if before is None else before[1].decode()
        plain = line if isinstance(line, bytes) else json.dumps(line).encode() + b"\n"
        written.append(line_of(line, digest) if isinstance(line, dict) and line else plain)
    path.write_bytes(b"".join(written))
    return path


HEADER = {"run": ABOUT, "version": VERSION}
NO_ENTRY = "expected an entry of a run"


@pytest.mark.parametrize(
    ("lines", "sentence"),
    [
        ([{"run": ABOUT}], "in a format without a number, expected format 7: start the run anew"),
        ([HEADER | {"version": 3}], "in a format 3, expected format 7"),
        ([HEADER | {"version": "7"}], "in a format '7', expected format 7"),
        ([{"version": 7}], "its first line names none"),
        ([HEADER | {"run": []}], "its first line names none"),
        ([[]], rf"line 1: {NO_ENTRY}, got \[\]"),
        ([3], f"line 1: {NO_ENTRY}, got 3"),
        ([HEADER, ONE, {"other": 1}], f", line 3: {NO_ENTRY}"),
        ([HEADER, ONE, {"number": "1"}], f", line 3: {NO_ENTRY}"),
        ([HEADER, ONE, {"number": True}], f", line 3: {NO_ENTRY}"),
        ([HEADER, {"text": "a" * 1000}], r'got \{"text": "a{30,150}\.\.\.$'),  # in part
        *(
            (
                [HEADER, ONE, json.dumps(entry).encode() + b"\n"],
                ", line 3: this is not what was wri",
            )
            for entry in ({}, ONE, [], 1.0, "text", None)
        ),  # without a digest
        ([b"\xff\xfe\n"], "not the checkpoint of a run"),
        ([b"no end of the line"], "not the checkpoint of a run"),
    ],
)
def test_lines_that_are_refused(tmp_path: Path, lines: list[object], sentence: str) -> None:
    path = lines_of(tmp_path / "run.jsonl", *lines)
    before = path.read_bytes()
    for call in (lambda: entries(path), lambda: opened(path, resume=True)):
        with pytest.raises(ValueError, match=r"run\.jsonl.*" + sentence):
            call()
    assert path.read_bytes() == before


@pytest.mark.slow
def test_every_bit_counts(tmp_path: Path) -> None:
    """But for the end of the last line: without it that line is one that was being written."""
    numbers: list[Entry] = [{"number": 0.5 * n} for n in range(3)]
    path = lines_of(tmp_path / "run.jsonl", HEADER, *numbers)
    whole = path.read_bytes()
    for k in range(len(whole) - 1):
        for bit in range(8):
            path.write_bytes(whole[:k] + bytes([whole[k] ^ (1 << bit)]) + whole[k + 1 :])
            with pytest.raises(ValueError, match=r"run\.jsonl"):
                entries(path)
    path.write_bytes(whole[:-1] + b"\x0b")
    assert entries(path) == numbers[:-1]


def test_every_line_counts(tmp_path: Path) -> None:
    path = lines_of(tmp_path / "run.jsonl", HEADER, *({"number": 0.5 * n} for n in range(4)))
    lines = path.read_bytes().splitlines(keepends=True)
    for k in range(1, len(lines)):
        doubled = [*lines[: k + 1], *lines[k:]]
        swapped = [*lines[: k - 1], lines[k], lines[k - 1], *lines[k + 1 :]]
        dropped = [*lines[:k], *lines[k + 1 :]] if k < len(lines) - 1 else doubled
        for other in (doubled, swapped, dropped):
            path.write_bytes(b"".join(other))
            with pytest.raises(ValueError, match=r"this is not what was written|its first line"):
                entries(path)


def test_a_run_that_has_hardly_begun_goes_on(tmp_path: Path) -> None:
    """Also from half of the first line; a file of something else is left as it is."""
    path = tmp_path / "run.jsonl"
    first = lines_of(path, {"run": ABOUT, "version": VERSION}).read_bytes()
    for length in range(len(first) + 1):
        path.write_bytes(first[:length])
        file = opened(path, resume=True)
        assert file.entries == []
        file.close()
        assert path.read_bytes() == first
    path.write_bytes(b"")
    with pytest.raises(ValueError, match=r"run\.jsonl.* not the checkpoint of a run"):
        entries(path)
    path.write_bytes(b'{"other": 1')
    with pytest.raises(ValueError, match="not the checkpoint of a run"):
        opened(path, resume=True)
    assert path.read_bytes() == b'{"other": 1'


# --- Locks ----------------------------------------------------------------------------------------


def test_two_runs_do_not_write_one_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """And when the second has ended nothing but the file is left."""
    monkeypatch.setattr("woodpecker.base.checkpoint.WAIT", 0.1)
    path = tmp_path / "run.jsonl"
    first = opened(path)
    first.write(ONE)
    before = path.read_bytes()
    for resume in (False, True):
        with pytest.raises(ValueError, match=r"another run is writing .*run\.jsonl: wait"):
            opened(path, resume=resume)
    assert path.read_bytes() == before
    assert not path.with_name("run.jsonl.old").exists()
    assert entries(path) == [ONE]  # reading is for everyone
    first.close()
    first.close()
    opened(path, resume=True).close()
    assert [each.name for each in tmp_path.iterdir()] == ["run.jsonl"]


@pytest.mark.skipif(sys.platform == "win32", reason="processes are not copied there")
def test_a_copy_of_the_process_does_not_keep_the_lock(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    file = opened(path)
    context = multiprocessing.get_context("fork")
    with ProcessPoolExecutor(1, context) as pool:
        assert pool.submit(int).result() == 0  # it has the file open
        file.close()
        opened(path, resume=True).close()


@pytest.mark.slow
def test_a_killed_run_leaves_no_lock(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    code = "from woodpecker.base.checkpoint import Checkpoint\n"
    code += f"c = Checkpoint({str(path)!r}, {ABOUT!r}, version={VERSION}, parsed=len)\n"
    code += "print('written', flush=True)\nimport time; time.sleep(60.0)"
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "written\n"
    process.kill()
    process.wait()
    process.stdout.close()
    opened(path, resume=True).close()
