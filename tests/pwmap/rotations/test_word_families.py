"""Families of words in n against single cycles, closed forms and random maps."""

import random
import re

import pytest
import sympy
from sympy import Rational

from pwmap import PiecewiseLinearMap, UndecidedError, word_family
from pwmap.rotations import WordFamily

A, R, X = sympy.symbols("a r x")
PAPER = PiecewiseLinearMap([("r - 2", "x <= 0"), ("r - a*x", "x > 0")], given=["a > 1"])
TWO = PiecewiseLinearMap([("s*x + 1", "x < 0"), ("t*x - m", "x >= 0")])
THREE = PiecewiseLinearMap(
    [("x/2 + p", "x < -1"), ("-2*x + p/3", "-1 <= x <= 1"), ("x/3 - p", "x > 1")]
)
QUOTIENT = PiecewiseLinearMap(
    [("x/a + r", "x <= r/a"), ("-x/(a + 1) - r", "x > r/a")], given=["a > 1", "r > 0"]
)
TWO_LETTERS = ["R L^n", "L R^n", "(RL)^n R", "(LLR)^n L", "L R^n L R^(n+1)", "R^n L^n",
               "L^(n-1) R", "L^2 (R L)^2 R^n", "R^(n+2) L^n", "(L R)^(n-1) L^n"]  # fmt: skip


def check(map_: PiecewiseLinearMap, family: WordFamily, n: int) -> None:
    """Word, point, multiplier and conditions against the cycle of the word."""
    member, cycle = family.at(n), map_.cycle(family.word(n))
    assert member.word == cycle.word
    assert member.x == cycle.points[0]
    assert member.multiplier == cycle.multiplier
    assert set(member.conditions) <= set(cycle.conditions)
    exponent = {family.n: n}
    for formula, value in ((family.x, member.x), (family.multiplier, member.multiplier)):
        assert sympy.cancel(formula.subs(exponent) - value) == 0
    for condition in family.conditions:
        if condition.since <= n and not map_.parameters:
            assert condition.relation.subs(exponent) in (sympy.true, sympy.false)


@pytest.mark.nightly
@pytest.mark.parametrize("pattern", TWO_LETTERS)
def test_families_with_symbols_agree_with_single_cycles(pattern: str) -> None:
    for signs in (["s > 0", "t > 0"], ["0 < s", "t < 0", "t > -1"], ["s < -1", "t > 0"]):
        assumed = PiecewiseLinearMap([("s*x + 1", "x < 0"), ("t*x - m", "x >= 0")], given=signs)
        family = word_family(assumed, pattern)
        for n in range(family.least, 4):
            check(assumed, family, n)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("map_", "last", "patterns"),
    [
        (PAPER, 12, ["L R^n", "R L^n", "L^2 R^n", "(RL)^n R", "(LRR)^n R"]),
        pytest.param(
            THREE, 12, ["R L^n", "L M^n R^n", "(LM)^n R", "M^n R", "(MR)^n L^(n+1)"],
            marks=pytest.mark.nightly,
        ),
        pytest.param(QUOTIENT, 6, ["R L^n", "L R^n", "(LR)^n L"], marks=pytest.mark.nightly),
    ],
    ids=["paper", "three pieces", "quotients"],
)  # fmt: skip
def test_families_agree_with_single_cycles(
    map_: PiecewiseLinearMap, last: int, patterns: list[str]
) -> None:
    for pattern in patterns:
        family = word_family(map_, pattern)
        for n in range(family.least, last + 1):
            check(map_, family, n)


SLOPES = [Rational(p, q) for p, q in ((1, 2), (-1, 2), (3, 2), (-3, 2), (0, 1), (1, 1), (-1, 1),
                                      (4, 5), (-6, 5), (1, 4), (-1, 5), (2, 1))]  # fmt: skip


@pytest.mark.nightly
def test_the_conditions_that_bind_decide_in_random_maps() -> None:
    """Existence from the few conditions is existence from all; slopes 0, 1 and -1 are among them.

    Jumps across the diagonal of either sense, and breaks of both owners.
    """
    rng = random.Random(7)
    seen = {True: 0, False: 0}
    for _ in range(500):
        s, t = rng.choice(SLOPES), rng.choice(SLOPES)
        if abs(s * t) == 1:
            continue  # words of slope 1
        pattern, n = (
            rng.choice(TWO_LETTERS + 8 * TWO_LETTERS[:3]),
            rng.choice((2, 2, 3, 3, 4, 5, 9, 12)),
        )
        sense = rng.choice((1, 1, 1, -1))
        c, d = (sense * Rational(rng.randint(0, 9), 4), -sense * Rational(rng.randint(0, 9), 4))
        owned, other = rng.choice([("<", ">="), ("<=", ">")])
        map_ = PiecewiseLinearMap([(s * X + c, f"x {owned} 0"), (t * X + d, f"x {other} 0")])
        family = word_family(map_, pattern)
        if family.multiplier.subs(family.n, n) == 1:
            continue
        member, cycle = family.at(n), map_.cycle(family.word(n))
        assert member.x == cycle.points[0]
        exists = sympy.And(*member.conditions) == sympy.true
        assert exists == cycle.admissible, (map_, pattern, n)
        seen[exists] += 1
    assert seen[True] > 20
    assert seen[False] > 200


# --- The map of the paper -------------------------------------------------------------------------


@pytest.mark.nightly
def test_higher_thresholds_of_the_paper_belong_to_l_r_n() -> None:
    """L R^n ends at r_n = 2 (1 + a) (-a)^n/(1 + a (-a)^n): r_1 = 2 a/(a - 1), and so on.

    The piece on the left is constant, r - 2, and its image after n steps on the right is 0 at r_n.
    Odd r_n fall and even ones rise towards 2 (1 + a)/a, where r - 2 is the fixed point itself. So
    for r > 2 there is one superstable cycle: L R^n for r_n <= r < r_(n - 2), n odd, and for
    r_(n - 2) < r <= r_n, n even; r_(-1) = oo and r_0 = 2. The map is that of [Leine2001, Eq. 14].
    """
    family = word_family(PAPER, "L R^n")
    n = family.n
    r_n = 2 * (1 + A) * (-A) ** n / (1 + A * (-A) ** n)
    found = family.thresholds(R)
    assert family.multiplier == 0
    assert len(found) == 3
    for threshold, shift in zip(found, (0, 2, 1), strict=True):
        power = (-A) ** n / (-A) ** shift
        before = 2 * (1 + A) * power / (1 + A * power)
        assert sympy.cancel(threshold - before) == 0
    closed = [2 * A / (A - 1), 2 * A**2 / (A**2 - A + 1), 2 * A**3 / ((A - 1) * (A**2 + 1))]
    for i, value in enumerate(closed, start=1):
        assert sympy.cancel(r_n.subs(n, i) - value) == 0

    a = Rational(5, 4)
    end = [r_n.subs({n: i, A: a}) for i in range(1, 13)]
    assert end[0] > end[2] > end[4] > 2 * (1 + a) / a > end[5] > end[3] > end[1] > 2
    for i in range(3, 13):
        for r, exists in (
            (end[i - 1], True),
            ((end[i - 1] + end[i - 3]) / 2, True),
            (end[i - 3], False),
            (2 * end[i - 1] - end[i - 3], False),
        ):
            map_ = PAPER.at({"a": a, "r": r})
            assert sympy.And(*word_family(map_, "L R^n").at(i).conditions) is sympy.sympify(exists)
            assert map_.cycle("L" + i * "R").admissible is exists
            others = [k for k in range(1, 21) if map_.cycle("L" + k * "R").admissible]
            assert len(others) == 1


@pytest.mark.nightly
@pytest.mark.parametrize("pattern", ["M R L^n", "L^n M R"])
def test_of_two_conditions_with_one_margin_the_strict_one_is_kept(pattern: str) -> None:
    """From x in M to x + 1 in R: x >= 0 and x + 1 > 1; the cycle needs 0 < x < 1.

    For n = 3 it is x = 2 p + 7 (before: 0 and 1 were allowed, whose cycles have other words).
    """
    map_ = PiecewiseLinearMap.from_sympy(
        "Piecewise((x + 1, x < 0), (x + 1, x <= 1), (x/2 + p, True))", letters="LMR"
    )
    family = word_family(map_, pattern)
    for x in (0, Rational(1, 9), 1):
        p = (Rational(x) - 7) / 2
        conditions = [condition.relation for condition in family.conditions]
        held = [relation.subs({"p": p, family.n: 3}) for relation in conditions]
        point, word = Rational(x), ""
        for _ in range(5):
            word += map_.at({"p": p}).word_of(point)
            point = map_.at({"p": p})(point)
        assert (point, word) == (x, "MRLLL") if all(held) else word != "MRLLL"
        assert all(held) == (0 < x < 1)
        assert all(c.subs({"p": p}) for c in family.at(3).conditions) == all(held)


def test_conditions_are_few() -> None:
    """Along a run the last point decides, or the last two; the first is implied by its aim."""
    for pattern, count in (("R L^n", 2), ("L R^n L R^(n+1)", 4), ("R^n L^n", 3)):
        both = PiecewiseLinearMap(
            [("s*x + 1", "x < 0"), ("t*x - m", "x >= 0")], given=["s > 0", "t > 0"]
        )
        assert len(word_family(both, pattern).conditions) == count
    assert [c.since for c in word_family(PAPER, "L R^n").conditions] == [1, 2, 1]


# --- Undecided ------------------------------------------------------------------------------------


def test_slopes_without_a_sign_are_undecided() -> None:
    with pytest.raises(UndecidedError, match="the sign of s"):
        word_family(TWO, "R L^n")
    one = PiecewiseLinearMap([("x + 1", "x < 0"), ("x - p", "x >= 0")])
    with pytest.raises(ValueError, match=r"the slope of R L\^n is 1 for every n"):
        word_family(one, "R L^n")
    for text, pattern in (  # powers that cancel: (2/2)^n, (-1)^(2 n), (a/a)^n
        ("Piecewise((-x/2 - 1, x <= 0), (1 - 2*x, True))", "L^n R^n"),
        ("Piecewise((-x - 1, x <= 0), (x + 1, True))", "L^n R L^n"),
        ("Piecewise((a*x - 1, x <= 0), (x/a + 1, True))", "L^n R^n"),
    ):
        cancelling = PiecewiseLinearMap.from_sympy(text, given=["a > 1"])
        with pytest.raises(ValueError, match=rf"slope of {re.escape(pattern)} is 1 for every n"):
            word_family(cancelling, pattern)
    mixed = PiecewiseLinearMap([("x/2 + 1", "x < 0"), ("8*x - 1", "x >= 0")])
    with pytest.raises(ValueError, match="the slope of RLLL is 1: it has no isolated cycle"):
        word_family(mixed, "R L^n").at(3)
    turning = PiecewiseLinearMap([("-3*x + u", "x <= 0"), ("1 - x", "x > 0")])  # (-1)^2 is 1
    with pytest.raises(ValueError, match="the slope of RR is 1: it has no isolated cycle"):
        word_family(turning, "R^n").at(2)
