"""The studies of cycles by words and of the plane of the skew tent map, in short."""

import pytest
from short_runs import ShortRun, is_picture, kept_run


@pytest.fixture(scope="module")
def counted(tmp_path_factory: pytest.TempPathFactory) -> ShortRun:
    return kept_run("cycles", tmp_path_factory)


@pytest.fixture(scope="module")
def plane(tmp_path_factory: pytest.TempPathFactory) -> ShortRun:
    return kept_run("parameter_plane", tmp_path_factory)


@pytest.mark.slow
def test_words_and_pieces_are_counted(counted: ShortRun) -> None:
    """The full tent map has 2^n pieces, and 71 cycles up to period 8 [necklaces]."""
    results, folder = counted
    full = results["tent map, a = 2"]
    assert [row["pieces"] for row in full["composition"]] == [2**n for n in range(1, 9)]
    assert full["words"][-1]["cycles"] == 2 + 1 + 2 + 3 + 6 + 9 + 18 + 30
    assert results["rotation, slope 1/2"]["attracting"] == ["LR"]
    assert is_picture(folder / "cycles.png")


@pytest.mark.slow
def test_the_plane_has_its_curves(plane: ShortRun) -> None:
    results, folder = plane
    curves = {(kind, words): polynomial for _, kind, words, polynomial in results["curves"]}
    assert curves["PD", "LLR"] == "a**2*b + 1"
    assert curves["MC", "R"] == "a*b**2 - a + b"
    assert ["PDB1", "PDB", "-1/2 + sqrt(5)/2", "-3/2 - sqrt(5)/2"] in results["points"]
    assert results["raster"]["open"] == 0
    assert is_picture(folder / "parameter_plane.png")
