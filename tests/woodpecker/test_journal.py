"""A search that is interrupted anywhere goes on to the same result; workers do not change it."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from maps import paper

from pwmap import Branch, Diagram, PointKind, SpecialPoint
from pwmap.diagram import BranchKind
from woodpecker import Toy, bifurcation_diagram, continuation, find_all, saved_diagram, shoot
from woodpecker.atlas import Atlas, Sample
from woodpecker.compiled import COMPILED
from woodpecker.complete import Search
from woodpecker.diagram import whole_diagram
from woodpecker.edges import Edge
from woodpecker.journal import Journal, of_runs, read_journal, to_runs
from woodpecker.labelled import Evaluation
from woodpecker.pieces import Resolution, sampled
from woodpecker.settings import Settings

SEARCH = Search(slices=12, resolution=Resolution(spacing=0.02, smallest=1e-6))
SETTINGS = Settings(span=(-1.0, 2.5), window=(-20.0, 20.0))
ABOUT = {"parameter": "p", "span": [-2.0, 2.0]}
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
    journal = Journal(tmp_path / "run.jsonl", ABOUT)
    found = searched(journal)
    journal.close()
    saved = saved_diagram(tmp_path / "run.jsonl")
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
    with pytest.raises(ValueError, match="is not the journal of a run"):
        Journal(path, ABOUT, resume=True)


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


@pytest.mark.slow
@NEEDS_NUMBA
def test_continuation_keeps_a_journal_too(tmp_path: Path) -> None:
    toy, path = Toy(), tmp_path / "run.jsonl"
    orbit = shoot(toy, -0.53)
    found = continuation(toy, orbit, span=(0.45, 0.7), run=path)
    again = continuation(toy, orbit, span=(0.45, 0.7), run=path, resume=True)
    assert same(found, again)
    with pytest.raises(ValueError, match="resuming needs the file of a run"):
        continuation(toy, orbit, span=(0.45, 0.7), resume=True)
