"""The study of two parameters: its picture, and A located anew."""

from pathlib import Path

import pytest
from needs import NEEDS_NUMBA

from studies.two_parameters import main


@pytest.mark.slow
@NEEDS_NUMBA
def test_places_of_a_are_those_of_one_parameter(tmp_path: Path) -> None:
    found = main(fast=True, out=tmp_path)
    a = found["a"]
    assert a["anew"] >= 4
    assert a["anew_alike"] == a["anew"]
    assert a["anew_off"] < 1e-9  # both are located to rounding, some 1e-15
    assert a["bisected_off"] < 1e-9  # forty halvings of 0.02 leave 2e-14
    assert set(found["curves"]) == {"mu_2"}
    assert (tmp_path / "two_parameters.png").stat().st_size > 10_000
