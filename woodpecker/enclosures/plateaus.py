"""The landing at a plateau: a gap that closes where its motion pauses.

When one contact of the sleeve lets go, the gap g of the other one has g' = g'' = 0 exactly. It
falls along g = g_0 + g_3 s_3(t), with pauses at t* = 2 pi n / omega, where g' and g'' vanish again.
With tau = t - t* and eta = -g(t*) / g_3 it is -g_3 (eta - s_3(tau)). Near eta = 0 the time of the
landing, s_3(tau) = eta, is like a cube root. If eta > 0 the contact stays, as its force is
positive. If eta < 0 it strikes at tau = -sigma, leaves, and lands again for good. Either way the
later motion is smooth up to small terms, which this module gives.

Let n be the gap's direction and r that of the slipping contact's impulse, n r = 1. The state
without gap, y = q - r g and y' = q' - r g', does not change in impacts of this contact, nor when it
leaves, and obeys the equations of sliding with the stretch d_y + d_r g for any motion of the gap
(d_r: the stretch along r). So sliding starts at t* from P q(t*) plus

    -g_3 d_r b V(eta) in the velocities,    -g_3 d_r b A(eta) in the coordinates,

    V = integral of S_0(tau) f,    A = -(integral of S_1(tau) f),    f = g / -g_3 >= 0 the true gap,

with b and S of sliding, from t* on for a later landing, and before t* with the opposite sign. V and
A are of the order sigma^4 and sigma^5, their derivatives in eta of the order sigma and sigma^2: the
return is once differentiable.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from flint import arb, arb_poly

from woodpecker.enclosures.balls import ZERO
from woodpecker.enclosures.forms import VALUE, Form, chained
from woodpecker.enclosures.not_proved import NotProved
from woodpecker.enclosures.stumpff import shape_balls, stumpff_balls
from woodpecker.enclosures.taylor import Taylor

LARGEST = arb(0.1)  # of |kappa| sigma^2, where the shapes below are near their values at zero
AGAIN = arb(3, 0.5)  # sigma to the second landing, in units of sigma: 3 for a weak spring


class Landed(NamedTuple):
    """The small terms of a landing at a plateau, for a range of eta."""

    sigma: Any  # time between the first impact and the middle of the plateau
    flight: Any  # duration of the flight until it lands again; zero where it stays
    velocity: Any  # the term V
    place: Any  # the term A
    velocity_slope: Any  # their derivatives in eta
    place_slope: Any

    @property
    def last(self) -> Any:
        """The latest time, after the middle of the plateau, at which the contact lands for good."""
        return (self.flight + self.sigma * (1 if self.flight.is_zero() else -1)).upper()


def landed(eta: Any, late: bool, kappa: Any, sliding: Any, turn: Any) -> Landed:
    """A landing after the middle, eta = s_3(sigma) >= 0, or before it, eta = -s_3(sigma) <= 0.

    ``kappa`` is that of free flight, ``sliding`` that of sliding at the contact; ``turn`` is the
    third derivative of g in free flight per stretch velocity, times d_r.
    """
    sigma = _sigma(eta if late else -eta, kappa)
    whole = ZERO.union(sigma)
    c2_before = shape_balls(kappa * whole**2, 2)[2]
    s1, s2 = stumpff_balls(sliding, sigma, 2)[1:]
    if late:
        slide = shape_balls(sliding * whole**2, 2)
        velocity, place = slide[1] * c2_before * sigma**4 / 4, -slide[2] * c2_before * sigma**5 / 5
        return Landed(sigma, ZERO, velocity, place, s1, -s2)
    # In flight, h = sigma z after the impact, f = sigma^3 z^2 (c_1 c_2(h) - c z c_3(h)) with
    # c = s_0 - turn s_2 at sigma.
    c0, c1, c2 = shape_balls(kappa * sigma**2, 2)
    c = c0 - turn * sigma**2 * c2
    z, h = _again(kappa, sigma, c1, c)
    n2, n3 = shape_balls(kappa * ZERO.union(h) ** 2, 3)[2:]
    slide = shape_balls(sliding * ZERO.union(whole.union(h - sigma)) ** 2, 2)
    flown = {2: c1 * n2, 3: -c * n3}  # f over sigma^3, and its slope in eta, in powers of z
    fallen = {2: c0 * n2 / c2, 3: (turn - kappa) * sigma**2 * c1 * n3 / c2}
    area = _integral(flown, z)
    velocity = slide[1] * c2_before / 4 + slide[0] * area
    place = slide[2] * c2_before / 5 - _integral(flown, z, slide[1], lever=True)
    velocity_slope = -s1 - sigma * _integral(fallen, z, slide[0])
    velocity_slope += sliding * sigma**3 * _integral(flown, z, slide[1], lever=True) / c2
    place_slope = -s2 - sigma**2 * slide[0] * area / c2
    place_slope += sigma**2 * _integral(fallen, z, slide[1], lever=True)
    return Landed(sigma, h, velocity * sigma**4, place * sigma**5, velocity_slope, place_slope)


def _sigma(eta: Any, kappa: Any) -> Any:
    """The solution of s_3(sigma) = eta; zero where eta is negative."""
    high = _root(eta.upper() * 7).upper()
    if not abs(kappa) * high**2 < LARGEST:
        raise NotProved("a landing is too far from a plateau")
    c3 = shape_balls(kappa * ZERO.union(high) ** 2, 3)[3]
    low = _root(eta.lower() / c3.upper()).lower()
    most = _root(eta.upper() / c3.lower()).upper()
    if most > high:
        raise NotProved("a landing at a plateau has no enclosure")
    return low.union(most)


def _again(kappa: Any, sigma: Any, c1: Any, c: Any) -> tuple[Any, Any]:
    """The second landing, z and h = sigma z: the only zero of f / z^2, which falls."""
    # There it strikes, and its acceleration is towards the pole.
    reach = ZERO.union(AGAIN.upper())
    x = kappa * (sigma * reach) ** 2
    n = shape_balls(x, 5)
    turn_2, turn_3 = n[3] - 2 * n[4], n[4] - 3 * n[5]
    curl = kappa * sigma**2 * reach
    if not c1 * turn_2 * curl - c * (n[3] + turn_3 * x) < 0:
        raise NotProved("a contact may not land again")
    h = sigma * AGAIN
    n = shape_balls(kappa * h**2, 3)
    z = c1 * n[2] / (c * n[3])
    if not AGAIN.contains_interior(z):
        raise NotProved("a contact may not land again")
    approach, force = c1 * n[1] - c * z * n[2], c1 * n[0] - c * z * n[1]
    if not (approach < 0 and force < 0):
        raise NotProved("a contact may not land again for good")
    return z, sigma * z


def _root(x: Any) -> Any:
    """The cube root; zero of what is not positive."""
    return x.root(3) if x > 0 else ZERO


def _integral(powers: dict[int, Any], z: Any, factor: Any = 1, lever: bool = False) -> Any:
    """The integral over [0, z] of a sum of powers, also times ``factor`` and the lever z - 1."""
    # Each power is integrated alone, since coefficients and factor vary in their balls.
    total = ZERO
    for n, c in powers.items():
        if lever:
            total += factor * c * (z ** (n + 2) / (n + 2)) - factor * c * (z ** (n + 1) / (n + 1))
        else:
            total += factor * c * (z ** (n + 1) / (n + 1))
    return total


def effect(eta: Form, on_curve: Any, slope: Any) -> Form:
    """A small term as a form, from its value on the curve and its slope in the box."""
    frame = eta.parts[VALUE].frame
    if len(eta.parts) > 3:
        raise NotProved("a return is once differentiable only where a contact lands at a plateau")

    def wide(ball: Any) -> Taylor:
        return Taylor(frame, arb_poly([ball.mid()]), ball - ball.mid())

    return chained(eta, wide(on_curve), wide(slope), lambda: wide(ZERO))
