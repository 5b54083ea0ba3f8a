"""Numbers that are typed at a command are what they say: 1.25 is 5/4."""

import pytest
from sympy import Rational

from pwmap.algebra.texts import exact
from pwmap.cli.reading import assignments, exact_span, map_of, orders_of


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("1.25", "5/4"), ("-.5", "-1/2"), ("2.", "2"), ("1e-3", "1/1000"), ("+3", "3"),
        ("0.1", "1/10"), ("5/4", "5/4"), ("sqrt(2)", "sqrt(2)"), ("1e9999", "1e9999"),
    ],
)  # fmt: skip
def test_a_decimal_is_a_fraction(typed: str, meant: str) -> None:
    assert exact(typed) == meant


def test_everywhere_a_value_is_typed() -> None:
    assert assignments(["a=1.25", "b = 1/3"]) == {"a": "5/4", "b": "1/3"}
    assert exact_span(("0", "2.5")) == ("0", "5/2")
    assert exact_span(None) is None


@pytest.mark.parametrize(
    ("typed", "meant"),
    [("1", [1]), ("1,2,4", [1, 2, 4]), ("1-4", [1, 2, 3, 4]), ("6, 1 - 3,2", [1, 2, 3, 6])],
)
def test_orders_are_numbers_and_ranges(typed: str, meant: list[int]) -> None:
    assert orders_of(typed) == meant


@pytest.mark.parametrize("typed", ["", "two", "1,", "8-1", "1,3-2", "-1", "1-2-3", "9" * 5000])
def test_other_text_names_no_orders(typed: str) -> None:
    with pytest.raises(ValueError, match="--also needs integers such as 1,2,4 or 1-8, got"):
        orders_of(typed, "--also")


def test_a_range_without_end_is_refused_at_once() -> None:
    with pytest.raises(ValueError, match="the iterate of order 10001 is too large"):
        orders_of("1-999999999")


BOOST = "Piecewise((x + m1, x <= top - m1), (top*(1 + m2/m1) - m2 - m2/m1*x, True))"


def test_a_value_that_is_set_decides_the_sign_of_a_denominator() -> None:
    """The boost converter in current mode: its current rises with m1 and falls with m2."""
    map_ = map_of(BOOST, "x", ["m1 > 0"], {"m1": "2", "top": "5"})
    assert [str(symbol) for symbol in map_.parameters] == ["m2"]
    # x = 5 (1 + b) - 2 b - b x with b = m2/2: at b = 3/2 it is 19/5
    assert [point.x for point in map_.at({"m2": 3}).fixed_points()] == [Rational(19, 5)]


@pytest.mark.parametrize(
    ("given", "values", "said"),
    [
        (["m1 > 2"], {"m1": "2"}, "m1 = 2 contradicts the assumption m1 > 2"),
        ([], {"m1": "0"}, "cannot work out .*: it divides by zero"),
        ([], {"x": "2"}, r"x is no parameter of this map, it has \['m1', 'm2', 'top'\]"),
        ([], {"top": "5"}, "assume more of the parameters .given. or give one a value"),
    ],
)
def test_values_that_do_not_fit_are_refused(
    given: list[str], values: dict[str, str], said: str
) -> None:
    with pytest.raises(ValueError, match=said):
        map_of(BOOST, "x", given, values)
