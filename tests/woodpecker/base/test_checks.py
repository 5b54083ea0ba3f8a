"""Wrong input: one sentence that names the value and what was expected, wherever it comes in."""

import inspect
import math
import pickle
from collections.abc import Callable
from dataclasses import fields
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import woodpecker
from pwmap.algebra.arguments import explained
from woodpecker import Settings, Toy, first_return, return_map, shoot
from woodpecker.base.checks import interval, number, positive, real_array, whole

API: Any = woodpecker  # wrong calls are the point here
TOY = Toy()
TWO = np.array([-0.5, -0.6])
WRONG: list[tuple[Callable[[str, object], object], str, list[object]]] = [
    (number, "one real number", [True, np.True_, "1", 1j, None, [1.0], TWO, np.array(1j)]),
    (positive, "positive and finite", [0.0, -1.0, math.inf, math.nan]),
    (whole, "a whole number of at least 1", [0, 1.0, np.float64(1.0), True, np.True_, "1", None]),
    (interval, "two real numbers", [(0.0, 0.5, 1.0), (0.0,), (), 1.0, (0, 1j), "01", (0, None)]),
    (real_array, "real numbers", [[1j], np.array([True]), ["1"], [None], [[1.0], [1.0, 2.0]]]),
]


@pytest.mark.parametrize(
    ("check", "expected", "value"),
    [(check, expected, value) for check, expected, values in WRONG for value in values],
)
def test_what_is_not_expected_is_named(
    check: Callable[[str, object], object], expected: str, value: object
) -> None:
    with pytest.raises(ValueError, match=f"x must be {expected}, got ") as caught:
        check("x", value)
    assert str(caught.value).endswith(repr(value))


@pytest.mark.parametrize(
    "value", [1, 1.0, np.float32(1.0), np.int64(1), np.array(1.0), Fraction(1)]
)
def test_a_number_is_any_real(value: object) -> None:
    assert (number("x", value), positive("x", value)) == (1.0, 1.0)


def test_whole_numbers_are_integers_of_any_kind() -> None:
    assert [whole("n", n) for n in (2, np.int8(2), np.uint64(2))] == [2, 2, 2]
    assert {type(whole("n", np.int64(2)))} == {int}


@pytest.mark.parametrize("value", [(1.0, 0.0), (0.5, 0.5), (math.nan, 1.0)])
def test_an_interval_ascends(value: tuple[float, float]) -> None:
    with pytest.raises(ValueError, match="span must ascend, got "):
        interval("span", value)
    assert interval("span", np.array([-math.inf, 1])) == (-math.inf, 1.0)


def test_arrays_are_real_copies() -> None:
    np.testing.assert_array_equal(real_array("x", [[1, 2]]), [[1.0, 2.0]])
    np.testing.assert_array_equal(real_array("x", [Fraction(1, 2)]), [0.5])
    assert real_array("x", []).shape == (0,)
    given = np.ones(2)
    assert real_array("x", given) is not given


@pytest.mark.parametrize("value", [math.nan, 0.0, -1e-9, math.inf])
def test_settings_are_positive_and_finite(value: float) -> None:
    for each in fields(Settings):
        if isinstance(each.default, float):
            with pytest.raises(ValueError, match=f"{each.name} must be positive and finite, got"):
                Settings(**{each.name: value})  # type: ignore[arg-type]


@pytest.mark.parametrize("order", [np.int64(2), np.uint8(2)])
def test_orders_may_be_numpy_integers(order: int) -> None:
    assert first_return(TOY, -0.53, order) == first_return(TOY, -0.53, 2)
    assert return_map(TOY, TWO, order).words == return_map(TOY, TWO, 2).words
    orbit = shoot(TOY.replace(eps_n1=0.66), -0.53, order)
    assert (orbit.order, type(orbit.order), len(orbit.points)) == (2, int, 2)


# --- Verbs that explain calls which do not fit stay what they are ---------------------------------


@explained("as it is")
def _sum(values: list[float]) -> float:
    return float(sum(values))


def test_an_error_from_within_is_left_as_it_is() -> None:
    wrong: Any = 3
    with pytest.raises(TypeError, match=r"^'int' object is not iterable$"):
        _sum(wrong)


def test_verbs_and_data_stay_what_they_are() -> None:
    assert _sum([1.0, 2.0]) == 3.0
    assert list(inspect.signature(API.shoot).parameters)[:3] == ["source", "guess", "order"]
    assert "mu_2" in inspect.signature(API.Toy).parameters
    assert pickle.loads(pickle.dumps(API.shoot)) is API.shoot
    assert pickle.loads(pickle.dumps(API.Toy().replace(mu_2=0.31))) == API.Toy(mu_2=0.31)
