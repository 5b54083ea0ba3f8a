"""Numbers that are typed at a command are what they say: 1.25 is 5/4."""

import pytest

from pwmap.cli.reading import assignments, exact, exact_span


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
