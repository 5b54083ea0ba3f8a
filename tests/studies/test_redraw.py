"""What was measured is drawn once more from the numbers that are kept."""

from pathlib import Path

import matplotlib as mpl
import pytest

mpl.use("Agg")
from studies.redraw import DRAWN, redraw
from studies.run_all import RESULTS, STUDIES


@pytest.mark.slow
@pytest.mark.parametrize("name", DRAWN)
def test_a_picture_is_drawn_from_kept_numbers(name: str, tmp_path: Path) -> None:
    kept = (RESULTS / f"{name}.json").read_bytes()
    paths = redraw(name, tmp_path)
    assert paths
    for path in paths:
        assert path.stat().st_size > 20_000  # not empty axes
        assert (RESULTS / path.name).exists()  # under the name that pages show
    assert (RESULTS / f"{name}.json").read_bytes() == kept
    assert name in STUDIES


def test_what_is_not_drawn_from_numbers_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"no picture of 'fig09' is drawn from numbers; there are"):
        redraw("fig09", tmp_path)
