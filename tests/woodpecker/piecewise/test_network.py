"""What comes along known branches adds nothing, however it was cut on the way."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pwmap.diagrams.diagram import BranchKind, PointKind
from woodpecker.piecewise.jumps import JUMP_ENDS
from woodpecker.piecewise.network import Atlas, Sample

FIXED, JUMP = BranchKind.FIXED_POINT, BranchKind.JUMP


def sample(
    p: float, x: float, word: str, kind: PointKind | None = None, note: str = ""
) -> Sample:  # fmt: skip
    return Sample(p, x, 0.5, word, kind, note, None)


def line(words: str, ends: list[float], count: int = 5) -> list[Sample]:
    """Samples of x = p, with a change of word at every inner end."""
    run = [sample(ends[0], ends[0], words[0], PointKind.EP, "start")]
    for k, word in enumerate(words):
        inner = np.linspace(ends[k], ends[k + 1], count + 2)[1:-1]
        run += [sample(p, p, word) for p in inner]
        kind, note = (PointKind.WC, "") if k + 1 < len(words) else (PointKind.EP, "end")
        run.append(sample(ends[k + 1], ends[k + 1], word, kind, note))
    return run


@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize("count", [5, 8])
def test_a_path_along_known_branches_adds_nothing(backwards: bool, count: int) -> None:
    atlas = Atlas()
    atlas.add(line("ABC", [0.0, 0.3, 0.6, 1.0]), FIXED, 1)
    again = line("ABC", [0.0, 0.3, 0.6, 1.0], count)
    atlas.add(again[::-1] if backwards else again, FIXED, 1)
    assert [branch.word for branch in atlas.branches] == ["A", "B", "C"]
    assert len(atlas.nodes) == 4


def test_a_thin_stretch_that_one_path_overlooks() -> None:
    """The first path sees A, C; the second a B in between, 4e-7 long: it is left out."""
    atlas = Atlas()
    atlas.add(line("AC", [0.0, 0.3, 1.0]), FIXED, 1)
    atlas.add(line("ABC", [0.0, 0.3, 0.3 + 4e-7, 1.0]), FIXED, 1)
    assert [branch.word for branch in atlas.branches] == ["A", "C"]


def test_one_path_may_make_two_changes_at_once() -> None:
    """Along one path a word changes to B and to C 4e-7 later: these are two changes."""
    atlas = Atlas()
    atlas.add(line("ABC", [0.0, 0.3, 0.3 + 4e-7, 1.0]), FIXED, 1)
    assert [branch.word for branch in atlas.branches] == ["A", "B", "C"]
    assert sum(node.kind is PointKind.WC for node in atlas.nodes) == 2


def test_both_arcs_between_two_folds_are_kept() -> None:
    """A circle about (0.5, 0.5): one word, two branches with the same ends."""
    atlas = Atlas()
    for side in (1.0, -1.0):
        angles = side * np.linspace(math.pi, 0.0, 21)
        run = [sample(0.5 + 0.2 * math.cos(a), 0.5 + 0.2 * math.sin(a), "A") for a in angles]
        for end in (0, -1):
            run[end] = sample(run[end].p, 0.5, "A", PointKind.LP)
        atlas.add(run, FIXED, 1)
        atlas.add(run[::-1], FIXED, 1)
    assert len(atlas.branches) == 2
    assert len(atlas.nodes) == 2


@pytest.mark.parametrize("first", [0, 1])
def test_a_jump_ends_where_another_path_goes_on(first: int) -> None:
    """From below nothing is found beyond 0.3, from above the words change there: one point."""
    below = line("A", [0.0, 0.3])
    below[-1] = sample(0.3, 0.3, "A", PointKind.EP, JUMP_ENDS)
    runs = [below, line("AB", [0.0, 0.3 + 1e-11, 1.0])]
    atlas = Atlas()
    for run in (runs[first], runs[1 - first]):
        atlas.add(run, JUMP, 1)
    assert sorted(branch.word for branch in atlas.branches) == ["A", "B"]
    (change,) = [node for node in atlas.nodes if node.kind is PointKind.WC]
    assert change.note == ""
    assert len(change.branches) == 2
