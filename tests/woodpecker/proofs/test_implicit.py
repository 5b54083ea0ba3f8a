"""Derivatives of the time of an event, that is of an implicit function, in both programs."""

from fractions import Fraction

import pytest

pytest.importorskip("flint")

from flint import arb
from mpmath import mp, mpf

from woodpecker.checking import forms, guards
from woodpecker.checking.intervals import Box, I, T, unit
from woodpecker.enclosures.balls import fraction
from woodpecker.enclosures.forms import precision, start, varying
from woodpecker.enclosures.oscillator import Guard, crossing
from woodpecker.enclosures.taylor import Frame

KAPPA = -40  # of the guard f = f_0 + f_1 t + f_2 s_2(t) + f_3 s_3(t)
GUESS = 0.3
SMALL = Fraction(1, 10**14)  # half widths of the box, so that ranges are close to values
ORDERS = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)]  # of derivatives along s and p


def jet(s: mpf, p: mpf) -> tuple[mpf, mpf, mpf, mpf]:
    """Coefficients of the guard, each of which moves with the start s and the parameter p."""
    x, y = mpf(3) / 10 + 2 * p + p**2 + s, -1 - p / 2
    return x, y, x * y, 2 + x


def event(s: mpf, p: mpf) -> mpf:
    """The time of the event, by Newton's method from the closed form."""
    f0, f1, f2, f3 = jet(s, p)
    w = mp.sqrt(-KAPPA)

    def guard(t: mpf) -> mpf:
        return f0 + f1 * t + f2 * (1 - mp.cos(w * t)) / w**2 + f3 * (t - mp.sin(w * t) / w) / w**2

    return mp.findroot(guard, GUESS)


@pytest.fixture(scope="module")
def expected() -> list[Fraction]:
    """The time and its derivatives by central differences, with half of sixty digits."""
    with mp.workdps(60):
        h, found = mpf(10) ** -10, []
        t = {(i, j): event(i * h, j * h) for i in (-1, 0, 1) for j in (-1, 0, 1)}
        found = [
            t[0, 0],
            (t[1, 0] - t[-1, 0]) / (2 * h),
            (t[0, 1] - t[0, -1]) / (2 * h),
            (t[1, 0] - 2 * t[0, 0] + t[-1, 0]) / h**2,
            (t[1, 1] - t[1, -1] - t[-1, 1] + t[-1, -1]) / (4 * h**2),
            (t[0, 1] - 2 * t[0, 0] + t[0, -1]) / h**2,
        ]
        return [Fraction(int(x * 10**40), 10**40) for x in found]


def assert_held(ranges: list[tuple[Fraction, Fraction]], expected: list[Fraction]) -> None:
    """Each range holds its number but for h^2 = 1e-20 of the differences, and is narrow."""
    for (low, high), x in zip(ranges, expected, strict=True):
        assert low - Fraction(1, 10**16) <= x <= high + Fraction(1, 10**16)
        assert high - low < Fraction(1, 10**9)


def test_of_the_proofs(expected: list[Fraction]) -> None:
    with precision(160):
        ball = arb(0, arb(SMALL.numerator) / SMALL.denominator)
        frame = Frame(ball, ball, terms=4, depth=6)
        x, y = start(frame, [arb(3) / 10, arb(2), arb(1)]), varying(frame, [arb(-1), arb(-0.5)])
        guard = Guard(0, (x, y, x * y, x + arb(2)), 0, arb(KAPPA))
        time = crossing(guard, GUESS).duration
        balls = [time.box, *(part.box for part in time.parts[1:])]
        assert_held([(fraction(b.lower()), fraction(b.upper())) for b in balls], expected)


def test_of_the_checker(expected: list[Fraction]) -> None:
    with unit(160):
        box = Box(SMALL, 4, SMALL, 6)

        def form(*parts: list[Fraction | int]) -> forms.F:
            return forms.F(box, [T.of(box, [Fraction(c) for c in part]) for part in parts])

        x = form([Fraction(3, 10), 2, 1], [1], [2, 2], [0], [0], [2])
        y = form([-1, Fraction(-1, 2)], [0], [Fraction(-1, 2)], [0], [0], [0])
        guard = guards.GuardValue(
            box, ("gap", 0), I.of(KAPPA), [x, y, x * y, x + I.of(2)], 0, False
        )
        bracket = I.of(Fraction(GUESS) - Fraction(1, 20), Fraction(GUESS) + Fraction(1, 20))
        time = guard.crossing(bracket, -1)
        units = Fraction(1, 2**160)
        found = [time.value, *(time.part(order) for order in ORDERS[1:])]
        assert_held([(each.a * units, each.b * units) for each in found], expected)
