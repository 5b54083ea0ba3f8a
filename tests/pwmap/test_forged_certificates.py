"""Forged certificates: true ones with claims that are wrong are refused for these claims."""

from __future__ import annotations

import copy
from fractions import Fraction
from typing import Any

import pytest

from pwmap import PiecewiseLinearMap, Refused, bifurcation_diagram, prove
from pwmap.checking.certificate import check, seal_of, statement_of
from pwmap.checking.places import between
from pwmap.checking.reading import number
from pwmap.checking.refusing import Work

Content = dict[str, Any]
P1L = PiecewiseLinearMap.from_sympy("Piecewise((r - 2, x <= 0), (r - 5*x/4, True))")


def proved(text: str, parameter: str, span: tuple[Any, Any], orders: tuple[int, ...]) -> Content:
    """A copy of what is proved of a diagram."""
    map_ = PiecewiseLinearMap.from_sympy(text)
    found = prove(bifurcation_diagram(map_, parameter, span, orders), map_, orders=orders)
    return copy.deepcopy(dict(found.content))


def refused(content: Content) -> str:
    """The sentence with which claims are refused, whatever statement and seal are."""
    with pytest.raises(Refused) as caught:
        statement_of(content)
    with pytest.raises(Refused):
        check({**content, "seal": seal_of(content)})
    sentence = str(caught.value)
    assert len(sentence) < 1500
    return sentence


# --- Numbers --------------------------------------------------------------------------------------

HALF = {"polynomial": ["-1", "2"], "interval": ["0", "1"]}
TWO = {"polynomial": ["-2", "1"], "interval": ["1", "3"]}


@pytest.mark.parametrize("edges", [[HALF, "1"], ["1", TWO]], ids=["high", "low"])
def test_what_holds_at_an_edge_is_not_taken_for_what_holds_beside_it(edges: list[Any]) -> None:
    """All points are fixed by x -> p x at p = 1 alone; p = 1 is an end of the other's interval."""
    content = proved("Piecewise((p*x, True))", "p", ("1/2", 2), (1,))
    assert content["intervals"] == [{"order": 1, "word": "A", "places": [2, 2]}]
    forged = content | {
        "edges": edges, "fixed points": [], "points": [],
        "intervals": [{"order": 1, "word": "A", "places": [1, 1]}],
    }  # fmt: skip
    assert refused(forged).startswith("edges must ascend, with intervals that part them, got ")


def test_two_roots_may_share_the_end_of_their_intervals() -> None:
    low, high = (number({**HALF, "interval": ends}, Work()) for ends in (["0", "1"], ["1/3", "1"]))
    two = number(TWO, Work())
    assert between(low, two) == 1
    one = number("1", Work())
    for pair in ((one, one), (low, one), (one, two), (low, low), (low, high), (two, low)):
        with pytest.raises(Refused, match="edges must ascend"):
            between(*pair)
    assert between(low, number("2", Work())) == Fraction(3, 2)


@pytest.mark.parametrize("polynomial", [["1", "-4", "4"], ["1", "-8", "24", "-32", "16"]])
def test_a_polynomial_that_keeps_its_sign_gives_no_number(polynomial: list[str]) -> None:
    """Else x = 1/2, a root of (1 - 2 x)^2, would be taken for another number than 1/2."""
    value = {"polynomial": polynomial, "interval": ["-1", "1"]}
    with pytest.raises(Refused, match="does not change its sign at just one root between -1 and 1"):
        number(value, Work())
    content = proved("Piecewise((r - 2, x <= 0), (r - 5*x/4, True))", "r", (-1, 3), (1, 2))
    forged = copy.deepcopy(content)
    forged["points"][0]["x"] = {"polynomial": ["0", "0", "1"], "interval": ["-1", "1"]}
    assert "does not change its sign at just one root" in refused(forged)
    forged["points"][0]["x"] = {"polynomial": ["0", "0", "0", "1"], "interval": ["-1", "1"]}
    assert "FF, fold, at r = 0 and x = the root of t^3" in statement_of(forged)


def test_work_is_counted_before_it_is_done() -> None:
    """Of each edge whose polynomial is read, too; common denominators have a bound."""
    row = {"polynomial": ["-7", *["3"] * 198, "2"], "interval": ["0", "2"]}
    work = Work(10**6)
    with pytest.raises(Refused, match="more work than a check may"):
        number(row, work)
    content = proved("Piecewise((r - 2, x <= 0), (r - 5*x/4, True))", "r", (-1, 3), (1, 2))
    primes = [str(10**150 + n) for n in range(60)]
    content["fixed points"][0]["x"] = [[f"1/{n}" for n in primes], ["1"]]
    assert refused(content) == "the common denominator of some numbers is too large"
