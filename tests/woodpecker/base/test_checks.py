"""Wrong input: one sentence that names the value and what was expected, wherever it comes in."""

import math
from collections.abc import Callable
from dataclasses import fields
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from maps import two_lines

from woodpecker import (
    Settings,
    Toy,
    ToyPieces,
    bifurcation_diagram,
    continuation,
    first_return,
    return_map,
    shoot,
    simulate,
)
from woodpecker.base.checks import interval, number, positive, real_array, whole
from woodpecker.maps import Iterate

TOY = Toy()
TWO = np.array([-0.5, -0.6])
LINES = two_lines()


@pytest.mark.parametrize(
    "value", [1, 1.0, np.float32(1.0), np.int64(1), np.array(1.0), Fraction(1)]
)
def test_a_number_is_any_real(value: object) -> None:
    assert (number("x", value), positive("x", value)) == (1.0, 1.0)


@pytest.mark.parametrize("value", [True, np.True_, "1", 1j, None, [1.0], TWO, np.array(1j)])
def test_a_number_is_one_real(value: object) -> None:
    with pytest.raises(ValueError, match="x must be one real number, got ") as caught:
        number("x", value)
    assert str(caught.value).endswith(repr(value))


@pytest.mark.parametrize("value", [0.0, -1.0, math.inf, math.nan])
def test_positive_is_positive_and_finite(value: float) -> None:
    with pytest.raises(ValueError, match=f"x must be positive and finite, got {value}"):
        positive("x", value)


def test_whole_numbers_are_integers_of_any_kind() -> None:
    assert [whole("n", n) for n in (2, np.int8(2), np.uint64(2))] == [2, 2, 2]
    assert {type(whole("n", np.int64(2)))} == {int}
    for value in (0, 1.0, np.float64(1.0), True, np.True_, "1", None, math.nan):
        with pytest.raises(ValueError, match="n must be a whole number of at least 1, got "):
            whole("n", value)


@pytest.mark.parametrize("value", [(0.0, 0.5, 1.0), (0.0,), (), 1.0, (0, 1j), "01", (0, None)])
def test_an_interval_is_two_numbers(value: object) -> None:
    with pytest.raises(ValueError, match="span must be two real numbers, got ") as caught:
        interval("span", value)
    assert str(caught.value).endswith(repr(value))


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
    for value in ([1j], np.array([True]), ["1"], [None], [[1.0], [1.0, 2.0]]):
        with pytest.raises(ValueError, match="x must be real numbers, got "):
            real_array("x", value)


REFUSED: list[tuple[Callable[[], Any], str]] = [
    (lambda: first_return(TOY, TWO), "phi_s must be one real number, got array"),
    (lambda: first_return(TOY, -0.5 + 0j), "phi_s must be one real number, got"),
    (lambda: first_return(TOY, -0.5, np.True_), "order must be a whole number of at least 1"),
    (lambda: return_map(TOY, TWO + 0j), "phi_s must be real numbers, got array"),
    (lambda: return_map(TOY, ["-0.5"]), "phi_s must be real numbers, got"),
    (lambda: shoot(TOY, TWO + 0j), "guess must be real numbers, got array"),
    (lambda: shoot(TOY, TWO, 3), "guess must have one point or 3, as order says, got array"),
    (lambda: shoot(TOY, -0.5, p=0.5), r"a toy has its own values: toy\.replace\(eps_n1=0\.5\)"),
    (lambda: shoot(LINES, -0.5), "p is needed: a map has no value of its parameter"),
    (lambda: shoot(LINES, math.nan, p=0.5), "guess must be finite, got nan"),
    (lambda: shoot(LINES, -0.5, p=math.inf), "p must be finite, got inf"),
    (lambda: return_map(LINES, [-0.5]), "p is needed"),
    (lambda: bifurcation_diagram(LINES), "needs a finite window"),
    (lambda: simulate(TOY, TWO, 0.1), "phi_s must be one real number, got array"),
    (lambda: simulate(TOY, -0.5, 0.1j), "t_end must be one real number, got 0.1j"),
    (lambda: simulate(TOY, -0.5, 0.1, samples=-5), "samples must be a whole number of at least 2"),
    (lambda: simulate(TOY, -0.5, 0.1, samples=1.5), "samples must be a whole number of at least 2"),
    (lambda: simulate(TOY, -0.5, 0.1, max_events=0), "max_events must be a whole number"),
    (lambda: simulate(TOY, -0.5, 0.1).at(0.05 + 0j), "t must be real numbers"),
    (lambda: Iterate(ToyPieces(TOY), 0), "order must be a whole number of at least 1, got 0"),
    (lambda: Iterate(ToyPieces(TOY), True), "order must be a whole number of at least 1, got True"),
    (
        lambda: continuation(TOY, shoot(TOY, -0.53), span=(0.4, 0.5, 0.6)),  # type: ignore[arg-type]
        r"span must be two real numbers, got \(0.4, 0.5, 0.6\)",
    ),
    (
        lambda: bifurcation_diagram(TOY, "eps_n1", (0.4, 0.5, 0.6)),  # type: ignore[arg-type]
        r"span must be two real numbers, got \(0.4, 0.5, 0.6\)",
    ),
    (
        lambda: bifurcation_diagram(TOY, "eps_n1", (0.4, 0.5), window=(-1.0, -0.9, -0.8)),  # type: ignore[arg-type]
        r"window must be two real numbers, got \(-1.0, -0.9, -0.8\)",
    ),
]


@pytest.mark.parametrize(("call", "sentence"), REFUSED)
def test_calls_refuse_with_one_sentence(call: Callable[[], Any], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        call()


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
