"""The study of two parameters: its picture, and A located anew."""

from pathlib import Path

import pytest
from needs import SLOW_TOY
from short_runs import short_run

from studies.two_parameters import (
    FIRST,
    FLIP,
    ISLAND,
    NAMES,
    SECOND,
    SPAN,
    confirmed,
    different,
    island_ends,
    main_points,
)
from woodpecker import Toy, curve_in_two


@SLOW_TOY
def test_places_of_a_are_those_of_one_parameter(tmp_path: Path) -> None:
    found = short_run("two_parameters", tmp_path)
    a = found["a"]
    assert a["anew"] >= 4
    assert a["anew_alike"] == a["anew"]
    assert a["anew_off"] < 1e-9  # both are located to rounding, some 1e-15
    assert a["bisected_off"] < 1e-9  # forty halvings of 0.02 leave 2e-14
    assert set(found["curves"]) == {"mu_2"}
    assert all(each["confirmed"] == each["looked"] for each in found["curves"]["mu_2"].values())
    assert (tmp_path / "two_parameters.png").stat().st_size > 10_000


@SLOW_TOY
@pytest.mark.parametrize(
    ("name", "second"), [*((name, "mu_2") for name in (*NAMES, FLIP, *ISLAND)), ("I1", "l_s")]
)
def test_every_tenth_place_of_every_curve_is_that_of_one_parameter(name: str, second: str) -> None:
    """A collision with its code from the local model, or, as a flip, from a diagram across it."""
    toy = Toy()
    points = island_ends(toy) if name in ISLAND else main_points(toy)
    curve = curve_in_two(toy, points[name], (FIRST, second), (SPAN, SECOND[second]))
    found = confirmed(toy, curve, 10)
    assert found["looked"] >= len(curve) // 10 - 1
    assert found["confirmed"] == found["looked"]


@SLOW_TOY
def test_both_ends_of_the_island_are_one_curve() -> None:
    """Over the friction of the lower edge multipliers of +1 and -1 at the border lie between."""
    toy = Toy()
    curves = {
        name: curve_in_two(toy, point, (FIRST, "mu_2"), (SPAN, SECOND["mu_2"]))
        for name, point in island_ends(toy).items()
    }
    assert list(different(curves)) == ["I1"]
    codes = set(curves["I1"].codes)
    assert {"FF", "BC"} <= {str(code) for code in codes}
