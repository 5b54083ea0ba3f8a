"""The study of symbolic composition runs, and both of its ways mean the same map."""

import pytest
from short_runs import ShortRun, is_picture, kept_run


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> ShortRun:
    return kept_run("symbolic", tmp_path_factory)


@pytest.mark.slow
def test_both_ways_agree_and_are_timed(measured: ShortRun) -> None:
    results, _ = measured
    assert results["agree"] == 3 * 41
    assert results["ratio_order_6"] > 1.0  # how much more is no matter of a test
    assert results["branches"] == 33
    assert results["points"] == 29
    assert all(t["cpu_median"] > 0.0 for t in results["timings"].values())


@pytest.mark.slow
def test_pictures_are_written(measured: ShortRun) -> None:
    for name in ("symbolic.png", "symbolic_plane.png"):
        assert is_picture(measured[1] / name)
