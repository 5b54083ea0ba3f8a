"""Curves and regions of two parameters, saved and loaded."""

import json
import math
import re
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from same import differences
from tampering import changed_file, refusal

from pwmap import load_diagram
from woodpecker import curve_in_two
from woodpecker.examples import SETTINGS, border_curve, paper_family, paper_regions
from woodpecker.plane import graph_of_curves, load_curve
from woodpecker.regions import load_regions


def test_a_curve_is_loaded_as_it_was_saved(tmp_path: Path) -> None:
    curve = border_curve(0.5)
    path = curve.save(tmp_path / "curve.json")
    loaded = load_curve(path)
    assert differences(curve, loaded) == []
    assert json.loads(path.read_bytes())["format"] == "pwmap curve"
    assert not loaded.values.flags.writeable
    assert loaded.crossings(1, 1.25) == curve.crossings(1, 1.25)
    assert "saved diagram: it does not begin with the format" in refusal(load_diagram, path)


def test_a_point_of_a_loaded_curve_starts_no_other(tmp_path: Path) -> None:
    """A file does not hold the starts; the sentence says so, and not that there are none."""
    loaded = load_curve(border_curve(0.5).save(tmp_path / "curve.json"))
    spans = (-1.0, 1.0), (0.5, 2.0)
    for point in loaded.points:
        why = "was loaded from a file" if point.starts else "no other curve starts at"
        with pytest.raises(ValueError, match=why):
            curve_in_two(paper_family(), point, ("r", "a"), spans, settings=SETTINGS)
    assert any(point.starts for point in loaded.points)


DAMAGES: dict[str, tuple[str, Any]] = {
    "a sample too few": ("values", lambda rows: rows[:-1]),
    "no sample": ("values", lambda rows: []),
    "a cycle of another order": ("x", lambda rows: [[*row, 0.0] for row in rows]),
    "x that is none": ("x", lambda rows: [["nan"], *rows[1:]]),
    "a multiplier too few": ("multipliers", lambda rows: rows[1:]),
    "a gap too many": ("gaps", lambda rows: [*rows, 0.0]),
    "a code too many": ("codes", lambda rows: [*rows, rows[-1]]),
    "a note too few": ("notes", lambda rows: rows[1:]),
    "a border too few": ("borders", lambda rows: rows[1:]),
    "a border of no point": ("border_index", lambda _: 1),
    "no ends": ("points", lambda rows: []),
    "one end": ("points", lambda rows: rows[:-1]),
    "points in another order": ("points", lambda rows: rows[::-1]),
    "a point of no cycle": ("points", lambda rows: [{**rows[0], "x": []}, *rows[1:]]),
    "no words": ("words", lambda rows: []),
    "words of later samples": ("words", lambda rows: [{**rows[0], "first": 1}]),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_curve_is_refused_when_it_is_read(damage: str, tmp_path: Path) -> None:
    """All types are right, but parts are not of the same samples."""
    name, change = DAMAGES[damage]
    path = changed_file(
        border_curve().save(tmp_path / "curve.json"),
        lambda content: content["curve"].update({name: change(content["curve"][name])}),
    )
    assert re.search(r": [\w ]+ of (this|a) curve must ", refusal(load_curve, path))


@pytest.mark.slow
def test_damaged_regions_are_refused_when_they_are_read(tmp_path: Path) -> None:
    def refused(change: Callable[[Any], object]) -> str:
        path = paper_regions().save(tmp_path / "regions.json")
        return refusal(load_regions, changed_file(path, lambda content: change(content["regions"])))

    assert "closed ring" in refused(lambda c: c["regions"][0]["outline"].pop())
    assert "closed ring" in refused(lambda c: c["regions"][0].update(outline=[]))
    assert "span of r must ascend" in refused(lambda c: c["spans"][0].reverse())
    assert "must be over r, a" in refused(lambda c: c["curves"][0]["names"].reverse())
    assert "gaps of this curve" in refused(lambda c: c["curves"][0]["gaps"].pop())


def test_places_and_samples_are_numbers() -> None:
    curve, regions = border_curve(), paper_regions()
    assert regions.at(Fraction(1, 2), Decimal("1.5")) is regions.at(0.5, 1.5)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"a must be one real number, got '1\.5'"):
        regions.at(0.5, "1.5")  # type: ignore[arg-type]
    for axis in (True, 0.0, None):
        with pytest.raises(ValueError, match="axis must be 0 or 1, got"):
            curve.crossings(axis, 1.5)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="value must be finite, got nan"):
        curve.crossings(1, math.nan)
    for sample in (1.5, "1", None, True):
        with pytest.raises(TypeError, match="sample must be a whole number, got"):
            curve.word_at(sample)  # type: ignore[arg-type]
    assert graph_of_curves(iter([curve])).number_of_edges() == 1  # type: ignore[arg-type]


@pytest.mark.slow
def test_regions_are_loaded_as_they_were_saved(tmp_path: Path) -> None:
    regions = paper_regions()
    loaded = load_regions(regions.save(tmp_path / "regions.json.gz"))
    assert differences(regions, loaded) == []
    assert loaded.at(0.5, 1.5).census == regions.at(0.5, 1.5).census
    assert "saved regions" in refusal(load_regions, border_curve().save(tmp_path / "curve.json"))
