"""Verification of a landing near a pause of a gap: sliding from its middle, with small terms.

The motion and the integrals V and A are those of :mod:`woodpecker.enclosures.plateaus`. If the
landing is late, f is the fall over 0 < tau < sigma; if early, it is the flight, minus the
(negative) fall over -sigma < tau < 0. Since f vanishes at the ends, derivatives in eta are
integrals of those of f at fixed tau: 1 on the fall, -(f_h + f_sigma) / s_2(sigma) on the flight.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

from woodpecker.checking.forms import F, chain, constant, over
from woodpecker.checking.guards import Guard, GuardValue
from woodpecker.checking.impacts import slip, solve_impact
from woodpecker.checking.intervals import I, NotSeparated, T, shapes, wave
from woodpecker.checking.toy import ANGLE, DOWN, OPEN, SIDE, UP, ExactToy
from woodpecker.checking.tracker import Choice, Tracker, flown

WEAKEST = Fraction(1, 10)  # bound of |kappa| sigma^2, where c_k is close to 1 / k!
AGAIN = Fraction(5, 2), Fraction(7, 2)  # bounds of the flight's duration over sigma, near 3
PARTS = 20  # of the flight, over each of which the gap is shown to be open


# --- The small terms ------------------------------------------------------------------------------


class Landing:
    """The small terms of a landing, their derivatives in eta, and the time of the last landing."""

    def __init__(self, eta: I, late: bool, kappa: I, sliding: I, turn: I) -> None:
        self.kappa, self.sliding, self.turn = kappa, sliding, turn
        self.sigma = self._sigma(eta if late else -eta)
        self.flight = I.of(0)
        sigma, zero = self.sigma, I.of(0)
        fallen = shapes(kappa * zero.hull(sigma).power(2), 2)[2]
        _, c1, c2 = shapes(sliding * zero.hull(sigma).power(2), 2)
        _, s1, s2 = wave(sliding, sigma)[:3]
        # integrals over the fall by parts, of s_2 S_1 and s_2 S_2 over (0, sigma)
        self.velocity = sigma.power(4) * c1 * fallen * _part(4)
        self.place = sigma.power(5) * c2 * fallen * _part(5)
        self.velocity_slope, self.place_slope = -s1, -s2
        if late:
            self.place, self.velocity_slope = -self.place, s1
        else:
            self._fly()
        self.last = sigma.high if late else (self.flight - sigma).high

    def _sigma(self, eta: I) -> I:
        """The solution of s_3(sigma) = eta; zero for negative eta."""
        most = (eta.high * I.of(7)).cube_root().high
        if not (self.kappa * most.power(2)).size.less(I.of(WEAKEST)):
            raise NotSeparated("a landing is too far from a plateau")
        c3 = shapes(self.kappa * I.of(0).hull(most).power(2), 3)[3]
        low, high = (eta.low / c3.high).cube_root().low, (eta.high / c3.low).cube_root().high
        if most.less(high):
            raise NotSeparated("a landing at a plateau has no enclosure")
        return low.hull(high)

    def _fly(self) -> None:
        """Add the flight: f = s_1 s_2(h) - c s_3(h) at the time h = sigma z after the impact."""
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
        z = c1 * n[2] / (c * n[3])  # holds all zeros in AGAIN; if it lies inside there is one
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
    """Integral over [0, z] of a sum of powers, times a factor that may vary in its interval."""
    total = I.of(0)
    for n, c in powers.items():
        term = c * z.power(n + 1) * _part(n + 1)
        total = total + (term if factor is None else term * factor)
    return total


def _with_lever(powers: Mapping[int, I], z: I, factor: I) -> I:
    """The same integral with z - 1 as a further factor."""
    raised = {n + 1: c for n, c in powers.items()}
    return _integral(raised, z, factor) - _integral(powers, z, factor)


# --- From free flight to sliding ------------------------------------------------------------------


def plateau(way: Tracker, guard: Guard, bracket: I) -> None:
    """Let a contact that lands near a pause of its gap slide from the middle of the pause on."""
    kind, i = guard
    late = kind == "plateau+"
    if way.states != (OPEN, OPEN, OPEN) or not way.let_go(i, way.states):
        raise NotSeparated("a gap has a pause only where the sleeve has just let go")
    if way.restitution(i).sign() != 0:
        raise NotSeparated("only a contact without restitution lands at a plateau")
    level = _slides(way, i, late, bracket)
    way.close(i)
    if level.value.sign() is None:
        comparator = level if late else -level
        way.forks.append(Choice("plateau", (i,), comparator, way.events, not late))
    strike = f"I{i + 1}"
    way.word += [strike] if late else [strike, f"D{i + 1}", strike]
    way.fired, way.before = ("impact", -1), way.states
    way.zeros, way.still, way.lands = [2 if k == i else 0 for k in range(3)], set(), -1
    way.at_least_zero = {("normal", i)}
    way.events += 1


def _slides(way: Tracker, i: int, late: bool, bracket: I) -> F:
    """Move to the middle of the pause, from which contact i slides; return the gap there."""
    # That is the gap if the contact had not landed: it lands late where it is positive, else early.
    toy, free, curves = way.toy, way.toy.mode((OPEN, OPEN, OPEN)), way.curves()
    jet = curves.pop(("gap", i)).jet
    start, fall, kappa = jet[0], jet[3], I.of(free.kappa)
    assert isinstance(start, F)
    if not isinstance(fall, F) or fall.value.sign() != -1 or kappa.sign() != -1:
        raise NotSeparated("a gap does not fall to a pause")
    swing = I.pi() * I.of(2) / (-kappa).sqrt()
    n = round(float(bracket.mid) / float(swing))
    if n < 1:
        raise NotSeparated("a gap has no pause where it begins to close")
    middle = swing * I.of(n)
    level = start - fall * (middle / kappa)  # s_3 = -t / kappa, where s_1 = s_2 = 0
    eta = -(level * over(fall))
    if eta.value.sign() == (-1 if late else 1):
        raise NotSeparated("a contact lands on the other side of a pause")
    q, u = flown(free, way.q, way.u, middle)
    direction = slip(toy, i, u).value.sign()
    if not direction:
        raise NotSeparated("the direction of slip is open")
    response = _response(toy, i, direction)
    slides = UP if direction == 1 else DOWN
    after = tuple(slides if k == i else OPEN for k in range(3))
    slide, stretch = toy.mode(after), response[2] - response[1]
    sizes = kappa, I.of(slide.kappa), I.of(free.b[ANGLE[i]] * SIDE[i] * stretch)
    whole, curve = (Landing(x, late, *sizes) for x in (eta.value, eta.parts[0].range))
    _clear(way, i, late, middle, response, direction, whole, tuple(curves.values()))
    if way.box.depth > 3:
        raise NotSeparated("a return is once differentiable only where a contact lands at a pause")
    places = _term(eta, curve.place, whole.place_slope) * -fall
    speeds = _term(eta, curve.velocity, whole.velocity_slope) * -fall
    for j in range(3):
        b = I.of(stretch * slide.b[j])
        q[j] = q[j] - level * I.of(response[j]) + places * b
        u[j] = u[j] + speeds * b
    way.q, way.u, way.states = q, u, after
    way.time, way.since = way.time + middle, whole.last
    return level


def _response(toy: ExactToy, i: int, direction: int) -> list[Fraction]:
    """Velocities due to an impulse of the slipping contact that gives its gap a unit speed."""
    friction = -direction * toy.mu[i]
    kick = [x + friction * y for x, y in zip(toy.kick[2 * i], toy.kick[2 * i + 1], strict=True)]
    speed = kick[ANGLE[i]] * SIDE[i]
    if speed <= 0:
        raise NotSeparated("a contact may neither stay nor leave")
    return [x / speed for x in kick]


def _term(eta: F, value: I, slope: I) -> F:
    """A function of eta over the box, from its range on the curve and that of its derivative."""
    zero = T(eta.box, [0])
    return chain(eta, zero.plus(value), zero.plus(slope), lambda: zero)


def _clear(
    way: Tracker, i: int, late: bool, middle: I, response: Sequence[Fraction], direction: int,
    landing: Landing, others: Sequence[GuardValue],
) -> None:  # fmt: skip
    """NotSeparated unless the contact slips through all impacts, and no other guard fires."""
    toy, j = way.toy, ANGLE[i]
    free, end = toy.mode((OPEN, OPEN, OPEN)), middle + landing.sigma if late else middle
    if not all(guard.lasts(end.high, None) for guard in others):
        raise NotSeparated("something may happen before a contact lands")
    strikes = middle + landing.sigma if late else middle - landing.sigma
    q, u = flown(free, [x.value for x in way.q], [x.value for x in way.u], strikes)

    def stopped(u: Sequence[I]) -> list[I]:
        return [v - u[j] * I.of(r * SIDE[i]) for v, r in zip(u, response, strict=True)]

    moments = [u, stopped(u)]
    if not late:
        flight = I.of(0).hull(landing.flight)
        q, u = flown(free, q, stopped(u), flight)
        moments += [u, stopped(u)]
        for k in range(3):
            gap = (q[ANGLE[k]] - I.of(toy.touch[k])) * I.of(SIDE[k])
            if k != i and gap.sign() != 1:
                raise NotSeparated("something may happen while a contact lands")
    for velocities in moments:
        along = slip(toy, i, velocities)
        if along.sign() != direction:
            raise NotSeparated("the direction of slip is open")
        strike = [velocities[j] * I.of(SIDE[i] * toy.lever[i]), along]
        before = [constant(way.box, x) for x in strike]
        solution = solve_impact(toy, [i], before, [way.zero], False, True)
        if not solution.rests[0] or solution.slips[0] != direction:
            raise NotSeparated("an impact is not decided")
