"""The studies of the long run: Ulam's method against closed forms, and short runs of both."""

import math

import numpy as np
import pytest
from short_runs import ShortRun, is_picture, kept_run

from pwmap import dynamics
from studies.exact import long_run


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> ShortRun:
    return kept_run("long_run", tmp_path_factory)


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> ShortRun:
    return kept_run("long_run_pictures", tmp_path_factory)


def test_ulam_s_method_is_exact_where_all_ends_of_bins_are_images() -> None:
    """a = 2, b = -3/2: entropy of the golden mean, heights 1/2 and 3/4."""
    seen = dynamics(long_run.SKEW, {"a": 2, "b": "-3/2"})
    found = long_run.ulam(seen, 3)  # bins of length 1/2: ends -1/2, 0, 1/2, 1
    assert np.allclose(found.density, [0.5, 0.75, 0.75], atol=1e-12)
    assert abs(found.exponent - (0.25 * math.log(2.0) + 0.75 * math.log(1.5))) < 1e-12
    density = seen.attractors[0].density
    assert density is not None
    assert long_run.apart(found, density) < 1e-12
    tent = dynamics(long_run.TENT, {"a": "7/5"})  # slopes of one size: each row sums to 7/5
    assert abs(long_run.ulam(tent, 50).entropy - math.log(1.4)) < 1e-12


def test_densities_are_compared_by_the_integral_of_their_difference() -> None:
    """1/2 on [-1/2, 0] and 3/4 on [0, 1] against 2/3 everywhere: 1/6 times 1/2, and 1/12."""
    seen = dynamics(long_run.SKEW, {"a": 2, "b": "-3/2"})
    flat = long_run.Ulam(0.0, 0.0, np.array([-0.5, 0.25, 1.0]), np.array([2 / 3, 2 / 3]))
    density = seen.attractors[0].density
    assert density is not None
    assert abs(long_run.apart(flat, density) - 1 / 6) < 1e-12


@pytest.mark.slow
def test_costs_and_errors_are_charted(measured: ShortRun) -> None:
    results, folder = measured
    tent = results["crises"]["tent map, 1.1 < a < 2.25"]
    assert [(row["cells"], row["crises"], row["exact"]) for row in tent] == [(4, 3, 3)] * 2
    for name, rows in results["entropy"].items():
        assert [row["order"] for row in rows] == [12, 24]
        assert 0.0 < rows[1]["width"] < rows[0]["width"], name
    for rows in results["ulam"].values():
        assert all(row["density"] < 0.1 for row in rows)  # of 1; bins 64 and 128
    assert len(results["random"]) == 4
    assert all(kind["entropy"]["maps"] == 2 for kind in results["random"].values())
    assert is_picture(folder / "long_run.png")


@pytest.mark.slow
def test_pictures_of_the_page_show_its_crises(drawn: ShortRun) -> None:
    results, folder = drawn
    assert [[kind for kind, *_ in each] for each in results["crises"].values()] == [
        [], ["FC", "MC"], ["FC", "MC", "MC"], ["XC"],
    ]  # fmt: skip
    assert results["density"] == ["1/2", "3/4"]
    for name in ("long_run_p1l", "long_run_skew", "long_run_golden"):
        assert is_picture(folder / f"{name}.png")
