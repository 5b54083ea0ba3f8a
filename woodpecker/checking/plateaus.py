"""A gap that closes near a pause: corrections of sliding from the middle of the pause.

The motion and the integrals V and A are those of :mod:`woodpecker.enclosures.plateaus`. If the
landing is late f is that of the fall over 0 < tau < sigma; if early, of the flight less the
(negative) fall over -sigma < tau < 0. As f vanishes at the ends, derivatives in eta are integrals
of those of f at fixed tau: 1 on the fall, and -(f_h + f_sigma) / s_2(sigma) on the flight.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from woodpecker.checking.intervals import Context, I, NotSeparated, shapes, wave

WEAKEST = Fraction(1, 10)  # of |kappa| sigma^2
AGAIN = Fraction(5, 2), Fraction(7, 2)  # h_L / sigma
PARTS = 20  # in which the contact is shown to fly


class Landing:
    """The corrections, their derivatives in eta, and the time of the last landing."""

    def __init__(self, eta: I, late: bool, kappa: I, sliding: I, turn: I) -> None:
        self.kappa, self.sliding, self.turn = kappa, sliding, turn
        self.sigma = self._sigma(eta if late else -eta)
        self.flight = I.of(0)
        sigma, zero = self.sigma, I.of(0)
        fallen = shapes(kappa * zero.hull(sigma).power(2), 2)[2]
        _, c1, c2 = shapes(sliding * zero.hull(sigma).power(2), 2)
        _, s1, s2 = wave(sliding, sigma)[:3]
        # of s_2 S_1 and s_2 S_2 over (0, sigma): by parts, from the fall
        self.velocity = sigma.power(4) * c1 * fallen * _part(4)
        self.place = sigma.power(5) * c2 * fallen * _part(5)
        self.velocity_slope, self.place_slope = -s1, -s2
        if late:
            self.place, self.velocity_slope = -self.place, s1
        else:
            self._fly()
        self.last = sigma.high if late else (self.flight - sigma).high

    def _sigma(self, eta: I) -> I:
        """Where s_3(sigma) = eta; zero for a negative eta."""
        most = _cube_root(eta.high * I.of(7)).high
        if not (self.kappa * most.power(2)).size.less(I.of(WEAKEST)):
            raise NotSeparated("a landing is too far from a plateau")
        c3 = shapes(self.kappa * I.of(0).hull(most).power(2), 3)[3]
        low, high = _cube_root(eta.low / c3.high).low, _cube_root(eta.high / c3.low).high
        if most.less(high):
            raise NotSeparated("a landing at a plateau has no enclosure")
        return low.hull(high)

    def _fly(self) -> None:
        """Add the flight, at h = sigma z after the impact: f = s_1 s_2(h) - c s_3(h)."""
        sigma, kappa, turn = self.sigma, self.kappa, self.turn
        square = sigma.power(2)
        c0, c1, c2 = shapes(kappa * square, 2)
        c = c0 - turn * square * c2
        z = self._lands(c1, c)
        self.flight = sigma * z
        n1, n2, n3 = shapes(kappa * I.of(0).hull(self.flight).power(2), 3)[1:]
        away = I.of(0).hull(self.flight - sigma).hull(sigma)
        slide_0, slide_1 = shapes(self.sliding * away.power(2), 1)
        height = {2: c1 * n2, 3: -(c * n3)}  # f / sigma^3
        moves = {  # (f_h + f_sigma) / s_2(sigma)
            1: c1 * n1 / c2,
            2: (c0 - c) * n2 / c2,
            3: (turn - kappa) * square * c1 * n3 / c2,
        }
        self.velocity = self.velocity + sigma.power(4) * slide_0 * _integral(height, z)
        self.place = self.place - sigma.power(5) * _with_lever(height, z, slide_1)
        self.velocity_slope = self.velocity_slope - sigma * _integral(moves, z, slide_0)
        self.place_slope = self.place_slope + square * _with_lever(moves, z, slide_1)

    def _lands(self, c1: I, c: I) -> I:
        """The first z > 0 at which f / z^2 = c_1 c_2(h) - c z c_3(h) vanishes."""
        low, high = AGAIN
        for k in range(PARTS):
            part = I.of(low * k / PARTS, low * (k + 1) / PARTS)
            n = shapes(self.kappa * (self.sigma * part).power(2), 3)
            if (c1 * n[2] - c * part * n[3]).sign() != 1:
                raise NotSeparated("a contact may land again early")
        inside = I.of(low, high)
        n = shapes(self.kappa * (self.sigma * inside).power(2), 3)
        z = c1 * n[2] / (c * n[3])  # all zeros in there, and there is one
        if not z.within(inside):
            raise NotSeparated("a contact may not land again")
        n = shapes(self.kappa * (self.sigma * z).power(2), 2)
        approach, acceleration = c1 * z * n[1] - c * z.power(2) * n[2], c1 * n[0] - c * z * n[1]
        if approach.sign() != -1 or acceleration.sign() != -1:
            raise NotSeparated("a contact may not land again for good")
        return z


def _part(n: int) -> I:
    return I.of(Fraction(1, n))


def _integral(powers: Mapping[int, I], z: I, factor: I | None = None) -> I:
    """Integral over [0, z] of a sum of powers, with coefficients and a factor in intervals."""
    total = I.of(0)
    for n, c in powers.items():
        term = c * z.power(n + 1) * _part(n + 1)
        total = total + (term if factor is None else term * factor)
    return total


def _with_lever(powers: Mapping[int, I], z: I, factor: I) -> I:
    """The same times z - 1."""
    raised = {n + 1: c for n, c in powers.items()}
    return _integral(raised, z, factor) - _integral(powers, z, factor)


def _cube_root(x: I) -> I:
    """The cube root of an interval; zero of a negative one."""
    bits = Context.bits
    if x.b <= 0:
        return I.of(0)
    return I(_floor_root(max(x.a, 0) << 2 * bits), _floor_root(x.b << 2 * bits) + 1)


def _floor_root(n: int) -> int:
    """The largest whole number whose cube is at most n."""
    if n == 0:
        return 0
    x = 1 << -(-n.bit_length() // 3)
    while True:
        y = (2 * x + n // (x * x)) // 3
        if y >= x:
            return x
        x = y
