"""A search that is interrupted anywhere goes on to the same result; workers do not change it."""

from __future__ import annotations

import json
import math
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from maps import paper

from pwmap import Branch, Diagram, PointKind, SpecialPoint
from pwmap.diagrams.diagram import BranchKind
from woodpecker import Toy, bifurcation_diagram, find_all, saved_diagram
from woodpecker.base.compiled import COMPILED
from woodpecker.diagram import whole_diagram
from woodpecker.piecewise.borders import Edge
from woodpecker.piecewise.checkpoint import VERSION, Journal, of_runs, read_journal, to_runs
from woodpecker.piecewise.maps import Evaluation
from woodpecker.piecewise.network import Atlas, Sample
from woodpecker.piecewise.partition import Resolution, sampled
from woodpecker.piecewise.search import Search
from woodpecker.piecewise.settings import Settings

SEARCH = Search(slices=12, resolution=Resolution(spacing=0.02, smallest=1e-6))
SETTINGS = Settings(span=(-1.0, 2.5), window=(-20.0, 20.0))
ABOUT: dict[str, object] = {"parameter": "p", "span": [-2.0, 2.0]}
TOY = {"parameter": "eps_n1", "toy": {"expansion_friction": "summed"}}
NEEDS_NUMBA = pytest.mark.skipif(not COMPILED, reason="takes minutes without numba")


def same(a: Diagram, b: Diagram) -> bool:
    """Whether two diagrams agree to the last bit, in the same order."""

    def of_branch(branch: Branch) -> tuple[object, ...]:
        arrays = (branch.parameter, branch.x, branch.multiplier)
        return (
            branch.id,
            branch.kind,
            branch.order,
            branch.word,
            branch.ends,
            *(array.tobytes() for array in arrays),
        )

    def of_point(point: SpecialPoint) -> tuple[object, ...]:
        return (
            point.id, point.kind, point.parameter, point.x, point.branches, point.order, point.note,
        )  # fmt: skip

    return [of_branch(branch) for branch in a.branches] == [
        of_branch(branch) for branch in b.branches
    ] and [of_point(point) for point in a.points] == [of_point(point) for point in b.points]


def searched(journal: Journal | None = None, workers: int = 1) -> Diagram:
    labelled = paper()
    found = whole_diagram(
        labelled, sampled(labelled), SETTINGS, (1, 2), SEARCH, workers=workers, journal=journal
    )
    return found.diagram


class Stopped(Journal):
    """A journal that is interrupted after some lines, in the middle of the next."""

    def __init__(self, path: Path, lines: int, *, resume: bool = False) -> None:
        super().__init__(path, ABOUT, resume=resume)
        self.left = lines

    def write(self, entry: dict[str, object]) -> None:
        self.left = getattr(self, "left", 1) - 1
        if self.left < 0:
            with self.path.open("a", encoding="utf-8") as file:
                file.write(json.dumps(entry)[:17])
            raise KeyboardInterrupt
        super().write(entry)


def test_a_run_interrupted_anywhere_goes_on_to_the_same_result(tmp_path: Path) -> None:
    whole = searched()
    assert len(whole.branches) >= 5
    path, stops = tmp_path / "run.jsonl", 0
    resume = False
    while True:
        journal = Stopped(path, 3, resume=resume)
        try:
            found = searched(journal)
        except KeyboardInterrupt:
            stops, resume = stops + 1, True
            continue
        finally:
            journal.close()
        break
    assert stops >= 5
    assert same(found, whole)


def test_what_is_saved_is_what_was_found(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    journal = Journal(path, TOY)
    found = searched(journal)
    journal.close()
    saved = saved_diagram(str(path))
    assert saved_diagram(path).points == saved.points
    assert saved.given[0] == "friction in the expansion: summed"
    assert len(saved.branches) == len(found.branches)
    for a, b in zip(saved.branches, found.branches, strict=True):
        np.testing.assert_array_equal(a.x, b.x)


@pytest.mark.parametrize("workers", [1, 2, 7])
def test_the_number_of_workers_does_not_matter(workers: int) -> None:
    assert same(searched(workers=workers), searched())


def test_an_old_run_is_kept_when_a_new_one_starts(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    Journal(path, ABOUT).close()
    before = path.read_text(encoding="utf-8")
    Journal(path, ABOUT | {"span": [0.0, 1.0]}).close()
    assert (tmp_path / "run.jsonl.old").read_text(encoding="utf-8") == before
    assert read_journal(path)[0]["span"] == [0.0, 1.0]


def test_only_the_same_run_is_resumed(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    with pytest.raises(ValueError, match="there is no saved run"):
        Journal(path, ABOUT, resume=True)
    Journal(path, ABOUT).close()
    with pytest.raises(ValueError, match=r"there span is \[-2.0, 2.0\], now it is \[0.0, 1.0\]"):
        Journal(path, ABOUT | {"span": [0.0, 1.0]}, resume=True)
    path.write_text("phi_s,eps_n1\n", encoding="utf-8")
    with pytest.raises(ValueError, match="line 1: not the journal of a run"):
        Journal(path, ABOUT, resume=True)


def test_a_start_is_the_same_up_to_rounding(tmp_path: Path) -> None:
    """Another machine finds the same solution with other last bits."""
    path, about = tmp_path / "run.jsonl", ABOUT | {"start": [-0.5, -0.25]}
    Journal(path, about).close()
    near = [math.nextafter(-0.5, 0.0), -0.25 + 9e-10]
    Journal(path, ABOUT | {"start": near}, resume=True).close()
    for other in ([-0.5, -0.25 + 2e-9], [-0.5], [math.nan, -0.25], "a", None):
        with pytest.raises(ValueError, match=r"there start is \[-0.5, -0.25\], now it is"):
            Journal(path, ABOUT | {"start": other}, resume=True)


def lines_of(path: Path, *lines: object) -> Path:
    path.write_text("".join(json.dumps(line) + "\n" for line in lines), encoding="utf-8")
    return path


HEADER = {"run": TOY, "version": VERSION}


@pytest.mark.parametrize(
    ("header", "sentence"),
    [
        ({"run": TOY}, "in a format without a number, expected format 1: start the run anew"),
        (HEADER | {"version": 3}, "in a format 3, expected format 1"),
        (HEADER | {"version": "1"}, "in a format '1', expected format 1"),
        ({"version": 1}, "its first line does not say which"),
        (HEADER | {"run": []}, "its first line does not say which"),
        ([], r"line 1: expected an entry of a run, got \[\]"),
        (3, "line 1: expected an entry of a run, got 3"),
        (HEADER | {"run": ABOUT}, r"line 1: expected a run of the toy, got one of \['param"),
        (HEADER | {"run": TOY | {"parameter": ["p"]}}, "line 1: expected a run of the toy"),
    ],
)
def test_first_lines_that_are_refused(tmp_path: Path, header: object, sentence: str) -> None:
    path = lines_of(tmp_path / "run.jsonl", header)
    before = path.read_bytes()
    with pytest.raises(ValueError, match=r"run\.jsonl.*" + sentence):
        saved_diagram(path)
    assert path.read_bytes() == before


SLICE = {
    "slice": 0.5, "order": 1, "new": False, "evaluations": 3, "unresolved": 0.0, "steep": 0,
    "failed": [],
}  # fmt: skip
ROW = [0.0, 1.0, 0.5, 0]
RUNS = {"path": "jump", "order": 1, "words": ["a"], "runs": [[[*ROW, "EP", "", 0, None], ROW]]}


@pytest.mark.parametrize(
    "entry",
    [
        {"paths": "jump"}, {}, [], 1.0, "path", None,
        {"done": 1, "order": 1}, {"done": "BC1", "order": "1"}, {"done": "BC1"},
        SLICE | {"slice": "0.5"}, SLICE | {"failed": [1.0]}, SLICE | {"failed": [["a", 1.0]]},
        SLICE | {"new": 0}, {"slice": 0.5},
        RUNS | {"path": "branch"}, RUNS | {"order": 1.5}, RUNS | {"words": []},
        RUNS | {"words": [1]}, RUNS | {"runs": [[ROW]]}, RUNS | {"runs": [[]]},
        RUNS | {"runs": [[["0.0", 1.0, 0.5, 0, "EP", "", 0, None]]]}, RUNS | {"runs": 1},
        RUNS | {"runs": [[[*ROW, "XX", "", 0, None]]]}, RUNS | {"runs": [[[*ROW, "EP"]]]},
        RUNS | {"runs": [[[*ROW, "BC", "", 0, [0.0, 1.0]]]]},
    ],
)  # fmt: skip
def test_entries_that_are_refused(tmp_path: Path, entry: object) -> None:
    path = lines_of(tmp_path / "run.jsonl", HEADER, SLICE, RUNS, entry)
    before = path.read_bytes()
    with pytest.raises(ValueError, match=r"run\.jsonl, line 4: expected an entry of a run, got "):
        saved_diagram(path)
    with pytest.raises(ValueError, match=r"run\.jsonl, line 4: expected an entry of a run, got "):
        Journal(path, TOY, resume=True)
    assert path.read_bytes() == before


def test_entries_that_do_not_follow_from_one_another(tmp_path: Path) -> None:
    path = lines_of(tmp_path / "run.jsonl", HEADER, RUNS, {"done": "BC7", "order": 1})
    with pytest.raises(ValueError, match=r"run\.jsonl, line 3: nothing is left to follow at BC7"):
        saved_diagram(path)
    path.write_bytes(b"\xff\xfe\n")
    with pytest.raises(ValueError, match=r"run\.jsonl, line 1: not the journal of a run"):
        saved_diagram(path)


@pytest.mark.skipif(sys.platform == "win32", reason="files are not locked there")
def test_two_runs_do_not_write_one_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("woodpecker.base.checkpoint.WAIT", 0.1)
    path = tmp_path / "run.jsonl"
    first = Journal(path, ABOUT)
    first.write(SLICE)
    before = path.read_bytes()
    for resume in (False, True):
        with pytest.raises(ValueError, match=r"another run is writing .*run\.jsonl: wait"):
            Journal(path, ABOUT, resume=resume)
    assert path.read_bytes() == before
    assert not path.with_name("run.jsonl.old").exists()
    assert read_journal(path)[1] == [SLICE]  # reading is for everyone
    first.close()
    first.close()
    Journal(path, ABOUT, resume=True).close()


@pytest.mark.skipif(sys.platform == "win32", reason="files are not locked there")
def test_a_copy_of_the_process_does_not_keep_the_lock(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    journal = Journal(path, ABOUT)
    context = multiprocessing.get_context("fork")
    with ProcessPoolExecutor(1, context) as pool:
        assert pool.submit(int).result() == 0  # it has the file open
        journal.close()
        Journal(path, ABOUT, resume=True).close()


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="files are not locked there")
def test_a_killed_run_leaves_no_lock(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    code = "from woodpecker.piecewise.checkpoint import Journal\n"
    code += f"j = Journal({str(path)!r}, {ABOUT!r})\n"
    code += "print('written', flush=True)\nimport time; time.sleep(60.0)"
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "written\n"
    process.kill()
    process.wait()
    process.stdout.close()
    Journal(path, ABOUT, resume=True).close()


def test_a_path_reads_back_to_the_last_bit() -> None:
    side = Evaluation(1.0 / 3.0, -5.0 / 7.0, math.nan, "S2 J2")
    edge = Edge(x=0.1, p=0.2, left=side, right=side, left_limit=math.nan, right_limit=2.0 / 3.0)
    samples = [
        Sample(0.1, -0.3, math.nan, "a / b", PointKind.BC, "fold", edge, -1),
        Sample(0.1 + 1e-17, -0.1 - 0.2, -1.0 / 3.0, "a / b", None, "", None),
    ]
    entry = json.loads(json.dumps(of_runs([samples], BranchKind.JUMP, 2)))
    (read,), kind, order = to_runs(entry)
    assert (kind, order) == (BranchKind.JUMP, 2)
    assert repr(read) == repr(samples)


def test_an_atlas_finishes_each_collision_once() -> None:
    side = Evaluation(0.0, -0.5, 1.0, "a")
    edge = Edge(x=0.0, p=0.0, left=side, right=side, left_limit=0.0, right_limit=1.0)
    atlas = Atlas()
    atlas.add(
        [
            Sample(-1.0, -1.0, -0.5, "a", PointKind.EP, "", None),
            Sample(0.0, 0.0, -0.5, "a", PointKind.BC, "", edge, -1),
        ],
        BranchKind.FIXED_POINT,
        1,
    )
    (collision,) = atlas.waiting
    assert collision.followed == {BranchKind.FIXED_POINT}
    atlas.finish(collision.node.id, 1)
    assert not atlas.waiting


@pytest.mark.slow
@NEEDS_NUMBA
def test_a_killed_run_of_the_toy_goes_on(tmp_path: Path) -> None:
    """SIGKILL leaves no time to tidy up; what was finished is there all the same."""
    path = tmp_path / "run.jsonl"
    span, window, search = (0.33, 0.4), (-1.2, -0.7), Search(slices=6)
    code = (
        "from pathlib import Path\nfrom woodpecker import *\n"
        f"bifurcation_diagram(Toy(), 'eps_n1', {span}, (1,), {window}, "
        f"search=Search(slices=6), run=Path({str(path)!r}))"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code], env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    )
    while process.poll() is None:
        time.sleep(0.05)
        if path.exists() and path.read_bytes().count(b"\n") > 3:
            process.send_signal(signal.SIGKILL)
    process.wait()
    kept = saved_diagram(path)
    assert len(kept.branches) >= 1
    found = bifurcation_diagram(
        Toy(), "eps_n1", span, (1,), window, search=search, run=path, resume=True
    )
    whole = find_all(Toy(), "eps_n1", span, (1,), window, search=search)
    assert same(found, whole.diagram)
    assert whole.evaluations > 1000
