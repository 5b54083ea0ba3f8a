"""Curves and regions of two parameters, saved and loaded."""

import json
from pathlib import Path

import pytest
from same import differences

from pwmap import load_diagram
from woodpecker import curve_in_two
from woodpecker.examples import SETTINGS, border_curve, paper_family, paper_regions
from woodpecker.plane import load_curve
from woodpecker.regions import load_regions


def test_a_curve_is_loaded_as_it_was_saved(tmp_path: Path) -> None:
    curve = border_curve(0.5)
    path = curve.save(tmp_path / "curve.json")
    loaded = load_curve(path)
    assert differences(curve, loaded) == []
    assert json.loads(path.read_bytes())["format"] == "pwmap curve"
    assert not loaded.values.flags.writeable
    assert loaded.crossings(1, 1.25) == curve.crossings(1, 1.25)
    with pytest.raises(ValueError, match="is no saved diagram: it does not begin with the format"):
        load_diagram(path)


def test_a_point_of_a_loaded_curve_starts_no_other(tmp_path: Path) -> None:
    """A file does not hold the starts; the sentence says so, and not that there are none."""
    loaded = load_curve(border_curve(0.5).save(tmp_path / "curve.json"))
    spans = (-1.0, 1.0), (0.5, 2.0)
    for point in loaded.points:
        why = "was loaded from a file" if point.starts else "no other curve starts at"
        with pytest.raises(ValueError, match=why):
            curve_in_two(paper_family(), point, ("r", "a"), spans, settings=SETTINGS)
    assert any(point.starts for point in loaded.points)


@pytest.mark.slow
def test_regions_are_loaded_as_they_were_saved(tmp_path: Path) -> None:
    regions = paper_regions()
    loaded = load_regions(regions.save(tmp_path / "regions.json.gz"))
    assert differences(regions, loaded) == []
    assert loaded.at(0.5, 1.5).census == regions.at(0.5, 1.5).census
    with pytest.raises(ValueError, match="is no saved regions"):
        load_regions(border_curve().save(tmp_path / "curve.json"))
