"""Short flights: h(t) and its derivatives, in both programs, against series of mpmath.

A gap that opens at rest is t^2 h(t); the signs of h' and of 4 h' + t h'' decide how it closes.
"""

from fractions import Fraction

import pytest

pytest.importorskip("flint")

from flint import arb
from mpmath import mp, mpf
from mpmath_numbers import rational

from woodpecker.checking import guards
from woodpecker.checking.intervals import I, unit
from woodpecker.enclosures.balls import fraction, number
from woodpecker.enclosures.forms import precision
from woodpecker.enclosures.oscillator import height

BITS = 200
F2, F3 = Fraction(7, 10), Fraction(-35)  # m/s^2, m/s^3: of the sizes that the toy has
TIMES = (Fraction(1, 1000), Fraction(1, 300), Fraction(1, 150))  # s: up to half a swing


def h(t: mpf, kappa: int) -> mpf:
    """f_2 c_2 + f_3 t c_3 with c_k = sum of (kappa t^2)^n / (2 n + k)!."""
    c = [mp.fsum((kappa * t**2) ** n / mp.factorial(2 * n + k) for n in range(60)) for k in (2, 3)]
    return mpf(F2.numerator) / F2.denominator * c[0] + mpf(F3.numerator) * t * c[1]


@pytest.mark.parametrize("kappa", [-209800, -36000, 532])  # 1/s^2: swings, and one that grows
@pytest.mark.parametrize("time", TIMES)
@pytest.mark.parametrize("order", [0, 1, 2])
def test_both_programs_hold_a_flight_and_its_derivatives(
    kappa: int, time: Fraction, order: int
) -> None:
    with mp.workdps(80):
        # mpmath's differences lose half of the digits: 30 are left
        known = rational(
            mp.diff(lambda t: h(t, kappa), mpf(time.numerator) / time.denominator, order)
        )
    with precision(BITS):
        jet = [arb(0), arb(0), number(F2), number(F3)]
        ball = height(jet, arb(kappa), number(time))(order)
        low, high = fraction(ball.lower()), fraction(ball.upper())
    with unit(BITS):
        found = guards.height([None, None, I.of(F2), I.of(F3)], I.of(kappa), I.of(time), order)
        assert isinstance(found, I)
        other = Fraction(found.a, 2**BITS), Fraction(found.b, 2**BITS)
    room = max(abs(known), Fraction(1)) / 10**25
    for below, above in ((low, high), other):
        assert below - room <= known <= above + room
        assert above - below < room
