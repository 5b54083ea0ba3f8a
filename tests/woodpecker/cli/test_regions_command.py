"""The command ``woodpecker regions``, and its picture."""

import csv
from pathlib import Path

import pytest
from needs import SLOW_TOY
from typer.testing import CliRunner

from pwmap.plot.palette import of_period
from woodpecker.cli.app import app
from woodpecker.cli.regions import PICTURE, TABLES
from woodpecker.plot.regions import described, face
from woodpecker.regions import Count

BESIDE_THE_FLIP = (
    "regions", "--span", "0.6", "0.7", "--second-span", "0.298", "0.302", "--window", "-0.6",
    "-0.45", "--checks", "10",
)  # fmt: skip


@SLOW_TOY
def test_the_flip_cuts_the_plane_in_two(tmp_path: Path) -> None:
    found = CliRunner().invoke(app, [*BESIDE_THE_FLIP, "--out", str(tmp_path)])
    assert found.exit_code == 0
    assert sorted(each.name for each in tmp_path.iterdir()) == sorted(
        [f"{PICTURE}.png", *TABLES, "about_regions.json"]
    )
    with (tmp_path / "regions.csv").open(encoding="utf-8") as lines:
        rows = list(csv.DictReader(lines))
    lives = {(row["stable_1"], row["unstable_1"]) for row in rows}
    assert lives == {("1", "0"), ("0", "1")}
    assert sum(float(row["share"]) for row in rows) == pytest.approx(1.0, abs=1e-9)
    assert "all of 10 random places agree" in " ".join(found.output.split())


def test_colours_say_what_is_stable() -> None:
    """The colour of the shortest stable period, darker where more unstable cycles live."""
    none, one, two = (Count(1, 0, 1),), (Count(1, 1, 0),), (Count(1, 0, 1), Count(2, 1, 0))
    assert len({face(each)["facecolor"] for each in (none, one, two)}) == 3
    shades = [face((Count(1, 1, n),))["facecolor"] for n in range(5)]
    assert shades == sorted({*shades}, reverse=True)  # of red, the first two digits
    assert shades[-1] == of_period(1)
    assert face((Count(1, 1, 0), Count(2, 1, 0))) == face(one) | {
        "hatch": "///", "edgecolor": of_period(2),
    }  # fmt: skip
    assert described(one) == "period 1: 1 stable"
    assert described((Count(1, 0, 0), Count(2, 1, 3))) == "period 2: 1 stable, 3 unstable"
    assert described((Count(1, 0, 0),)) == "no cycle of these orders"
