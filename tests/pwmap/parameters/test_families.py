"""Random families of maps over one parameter against brute force that shares nothing with them."""

import random
from fractions import Fraction

import pytest
from cell_formulas import compare_composition
from compare_families import compare
from comparisons import Report
from families import Draw
from independent import Algebraic, Root, iterated, nested

SEED = 1000
FAMILIES, PARAMETERS = 21, 20


def test_numbers_of_a_field_of_a_root() -> None:
    """sqrt(2) - 1 is the inverse of sqrt(2) + 1; sqrt(2) lies between two of its convergents."""
    root = Root((Fraction(-2), Fraction(0), Fraction(1)), Fraction(1), Fraction(2)).number
    assert (root - 1) * (root + 1) == 1 == 1 / (root + 1) / (root - 1)
    assert isinstance(root * root, Algebraic)
    assert Fraction(1393, 985) < root < Fraction(3363, 2378)
    assert -root < 0 < root * root * root - Fraction(28284, 10000)


def test_following_intervals_is_nested_evaluation() -> None:
    """The brute force against itself: in every piece, and at every end of one."""
    draw, rng = Draw(SEED), random.Random(SEED)
    for _ in range(20):
        base = draw.family().at(Fraction(rng.randint(-20, 20), 13))
        parts = iterated(base, 3)[-1]
        ends = [part.lo for part in parts if part.lo is not None]
        for x in (*ends, *(Fraction(rng.randint(-90, 90), 7) for _ in range(20))):
            (part,) = [part for part in parts if part.holds(x)]
            assert (part(x), part.word) == nested(base, x, 3)


@pytest.mark.nightly
@pytest.mark.parametrize("part", range(3))
def test_families(part: int) -> None:
    """Branches, special points, cells and ``at`` on every edge, beside it and elsewhere."""
    draw, report = Draw(SEED + part), Report()
    for i in range(FAMILIES // 3):
        compare(draw.family(light=True), PARAMETERS, i, report)
    assert not report.differences
    assert report.compared["fixed points"] + report.compared["crossings"] > 500


@pytest.mark.slow
def test_compositions() -> None:
    """Pieces and words of one map after another, at a parameter."""
    draw, report = Draw(SEED), Report()
    for i in range(20):
        compare_composition(draw.family(light=True), draw.family(light=True), i, report)
    assert not report.differences
    assert report.compared["compositions"] > 60
