"""Numbers that are typed at a command are what they say: 1.25 is 5/4."""

import pytest
from sympy import Rational
from typer import Typer
from typer.testing import CliRunner

from pwmap.cli.app import app
from pwmap.cli.reading import assignments, exact, exact_span, map_of, orders_of
from woodpecker.cli.app import app as toy


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


@pytest.mark.parametrize(
    ("program", "typed", "said"),
    [
        (app, "plane x --pieces 0", "'--pieces': a whole number of at least 1 is expected, got "),
        (app, "plane x --pieces 1.5", "a whole number of at least 1 is expected, got '1.5'"),
        (app, "plane x --raster 4 no", "'--raster': a whole number of at least 1 is expected, got"),
        (app, "prove p*x --set p=1" + "0" * 5000, "an integer of 5001 digits is longer than 1000"),
        (app, "prove x --order two", "'--order': a whole number of at least 1 is expected, got "),
        (app, "prove x --order 1 --order 2", "--order may be given only once"),
        (
            app,
            "analyse p*x --parameter p --span -2,2 --orders 1",
            "--span takes two values, such as --span -2 2, got '-2,2'",
        ),
        (app, "plane p*x --across p --across-span 1 --along-span -4 -1", "values, such as --acr"),
        (toy, "diagram --span=0.5", "takes two values, such as --span -2 2, got '0.5'; see"),
        (toy, "diagram --format jpg", "'--format': 'jpg' is not one of 'png', 'pdf', "),
        (app, "prove x --out=", "'--out': a path is expected, got ''"),
        (app, "analyse p*x --parameter p --span 0 1/0", "--span 0 1/0: cannot work out 0: it div"),
        (
            app,
            "analyse p*x --parameter p --span= 1",
            "--span '' 1: expected a rational number, such as 5/4: cannot read '' as an expression",
        ),
        (app, "analyse p*x --parameter p --given=", "--given '': cannot read '' as an expression"),
        (
            app,
            "analyse p*x --parameter p --density nan",
            "--density nan: expected a rational number",
        ),
        (
            app,
            "plane p*q*x --across p --along q --across-span 0 1 --along-span 2 1",
            "--along-span 2 1: a span must be an interval (low, high), got (2, 1)",
        ),
        (app, "explore --port 65536", "a whole number of at least 1 and at most 65535 is expected"),
        (toy, "map --points 1", "'--points': a whole number of at least 2 is expected, got '1'"),
        (toy, "map --g 9 --points 2 --g=9.8", "--g may be given only once"),
        (toy, "simulate --samples " + "9" * 5000, "at least 2 is expected, got '99999999999999999"),
    ],
)
def test_what_is_typed_is_refused_in_the_words_of_the_project(
    program: Typer, typed: str, said: str
) -> None:
    result = CliRunner().invoke(program, typed.split())
    assert result.exit_code == 2
    assert result.stderr.startswith("Error: ")
    assert said in result.stderr
    assert len(result.stderr.splitlines()) == 1


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
