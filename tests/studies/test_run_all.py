"""All studies run in their small versions, and the pages of results say what they say."""

import json
import re
from pathlib import Path
from typing import Any

import pytest
from needs import SLOW_TOY
from short_runs import short_run

from studies import readme, run_all
from studies.common import record
from studies.common.record import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")
PAGES = [page.read_text(encoding="utf-8") for page in readme.PAGES]
GIVEN = ("3.11", "0.5")  # the version of Python, the eps_N1 of the paper's data set


RUNS = re.compile(r'(?:short|kept)_run\("(\w+)"')  # once each, in the tests of their numbers
RUN = {
    name
    for path in Path(__file__).parent.glob("test_*.py")
    for name in RUNS.findall(path.read_text(encoding="utf-8"))
}


WITHIN = {  # differences from closed forms; of roots that are located where motions change
    "system_belt": dict.fromkeys(("lowest", "multiplier", "by_speed"), 1e-10),
    "system_den_hartog": dict.fromkeys(("largest_difference", "with_stops", "border"), 1e-9),
    "system_rocking_block": dict.fromkeys(("fold", "pitchfork", "closes"), 1e-9),
    "system_table": dict.fromkeys(("closes", "flip", "fold", "inelastic"), 1e-10),
}


@SLOW_TOY
@pytest.mark.parametrize("name", [name for name in run_all.STUDIES if name not in RUN])
def test_any_other_study_runs_in_its_small_version(name: str, tmp_path: Path) -> None:
    results = short_run(name, tmp_path)
    assert results
    for number, bound in WITHIN.get(name, {}).items():
        assert results[number] < bound, number


def test_studies_that_run_are_studies() -> None:
    assert len(RUN) > 20
    assert set(run_all.STUDIES) > RUN


def test_every_study_is_run() -> None:
    scripts = {
        ".".join(path.relative_to(ROOT).with_suffix("").parts)
        for path in (ROOT / "studies").rglob("*.py")
        if "def main(fast" in path.read_text(encoding="utf-8")
    }
    measured_elsewhere = {"studies.peers.ode"}  # in work_precision
    assert scripts - measured_elsewhere == set(run_all.STUDIES.values())


def test_an_unknown_study_is_refused() -> None:
    with pytest.raises(ValueError, match="no study 'fig99'"):
        run_all.run_all(True, None, ["fig99"])


def test_the_pages_say_what_the_results_say() -> None:
    """Every block is written from studies/results by `python -m studies.readme`."""
    results = readme.load(run_all.RESULTS)
    for text in PAGES:
        assert readme.filled(text, results) == text
    named = [name for text in PAGES for _, name, _ in readme.BLOCK.findall(text)]
    assert sorted(named) == sorted(readme.BLOCKS)


def test_no_number_is_typed() -> None:
    assert readme.unexplained(README, GIVEN) == []
    for text in PAGES:
        assert readme.unexplained(text, GIVEN) == []
    assert readme.unexplained("It takes 36 s, 0.25 of it idle.", GIVEN) == ["36", "0.25"]


@pytest.mark.parametrize(
    ("value", "digits", "shown"),
    [(0.0123456, 3, "0.0123"), (-1234.5, 2, "−1234"), (4.31e-17, 2, "4.3e-17"), (2.0, 3, "2")],
)
def test_numbers_are_shown_with_the_digits_asked_for(value: float, digits: int, shown: str) -> None:
    assert readme.number(value, digits) == shown


def test_results_say_what_they_were_made_on(tmp_path: Path) -> None:
    numbers: dict[str, Any] = {"value": 1.0}
    path = record.save(numbers, "study", tmp_path)
    saved = json.loads(path.read_text(encoding="utf-8"))
    assert saved["value"] == 1.0
    assert saved["environment"]["python"].startswith("3.")
    with pytest.raises(ValueError, match="JSON"):
        record.save({"value": float("nan")}, "study", tmp_path)
