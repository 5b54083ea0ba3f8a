"""Guards over a box: the closed form of f'''' = kappa f'', and enclosures of its zeros.

With Stumpff's functions s_k(t) = t^k c_k(kappa t^2), where c_k(x) = 1/k! + x/(k+2)! + ...,

    f(t) = f_0 + f_1 t + f_2 s_2 + f_3 s_3,    d s_k / dt = s_(k-1),    d s_0 / dt = kappa s_1.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, NamedTuple

from flint import arb, ctx

from woodpecker.enclosures.balls import ZERO, sum_of
from woodpecker.enclosures.forms import HALVES, VALUE, Form, S, box, sign
from woodpecker.enclosures.not_proved import NotProved
from woodpecker.enclosures.stumpff import shapes, stumpff
from woodpecker.enclosures.taylor import Taylor, constant, inverse, thin
from woodpecker.mechanics.modes import SECTION

Derivatives = Callable[[int], Any]
KINDS = ("gap", "normal", "cone+", "cone-", "slip", "section")
MOST_PARTS = 2**16  # into which a phase is divided in one proof; unstable cycles need 2**13
LONGEST = 10.0  # |kappa| t^2 of a flight from rest, half a period of the spring: beyond it h need
# not be monotone
PARTS = 16  # of such a flight; the slope of h is enclosed over each
HALVINGS = 40  # of a phase in a proof that a guard is positive: down to 1e-12 of it
TURNS = 21  # of a phase in a proof that the bird does not turn


def oscillation(jet: Sequence[Any], kappa: Any, t: Any) -> Derivatives:
    """The guard at a time, as a function of the order of the derivative."""
    f0, f1, f2, f3 = jet
    s = stumpff(kappa, t)

    def value(derivative: int) -> Any:
        last = [s[k] if k >= 0 else kappa * s[k + 2] for k in (2 - derivative, 3 - derivative)]
        first = {0: [f0, f1 * t], 1: [f1]}.get(derivative, [])
        return sum_of([*first, f2 * last[0], f3 * last[1]])

    return value


def height(jet: Sequence[Any], kappa: Any, t: Any) -> Derivatives:
    """The function h = f_2 c_2 + f_3 t c_3 of a flight from rest, f = t^2 h, likewise.

    Its derivatives follow from d c_k / dt = kappa t (c_(k+1) - k c_(k+2)).
    """
    _, _, f2, f3 = jet
    x = kappa * (t * t)
    c = shapes(x, 7)

    def slope(k: int) -> Any:
        return c[k + 1] - c[k + 2] * k

    def bend(k: int) -> Any:
        return slope(k + 1) - slope(k + 2) * k

    def value(derivative: int) -> Any:
        match derivative:
            case 0:
                return f2 * c[2] + f3 * (c[3] * t)
            case 1:
                return f2 * (slope(2) * t * kappa) + f3 * (c[3] + slope(3) * x)
            case _:
                own, other = slope(2) + bend(2) * x, slope(3) * 3 + bend(3) * x
                return f2 * (own * kappa) + f3 * (other * t * kappa)

    return value


@dataclass(frozen=True, slots=True)
class Guard:
    """A guard of a phase: positive during it, zero where it fires and ends it."""

    code: int  # as in :mod:`woodpecker.mechanics.modes`
    jet: Sequence[Any]  # value and three derivatives at the start of the phase, with exact zeros
    order: int  # how many entries of the jet are exactly zero; they are its first ones
    kappa: Any  # of the phase
    assumed: bool = False  # whether jet[order] is known to be at least zero, though its range isn't

    formula: Callable[[Sequence[Any], Any, Any], Derivatives] = oscillation

    def near(self, t: Any) -> Derivatives:
        """The guard and its derivatives at a time; forms, unless time and jet are balls."""
        return self.formula(self.jet, self.kappa, t)

    def over(self, t: Any, derivative: int = 0) -> Any:
        """Range of the guard or a derivative over a ball of times and the whole box."""
        return self.formula([box(f) for f in self.jet], self.kappa, t)(derivative)

    def lasts(self, end: Any, falling: Any = None) -> bool:
        """Whether it is proved not to fire in (0, end], or before its zero in ``falling``."""
        if self.code == SECTION:
            return not end > 0 or holds_on(ZERO, end, self._turns_not, TURNS)
        if not end > 0:  # then it must fall all the way from the start
            return falling is not None and sign(self.over(ZERO.union(falling), 1)) == -1
        low = self._grows(end)
        return low is not None and holds_on(low, end, self._positive)

    def _turns_not(self, a: Any, b: Any) -> bool | None:
        """Whether the bird's velocity does not rise through zero in (a, b]; None if open."""
        t = a.union(b)
        value, slope = self.over(t), self.over(t, 1)
        if sign(value) or slope < 0:
            return True
        # Rising, it has no zero in (a, b] if it is zero at a = 0, or still negative at b.
        rises = slope > 0 and ((a.is_zero() and self.order == 1) or sign(self.near(b)(0)) == -1)
        return True if rises else None

    def _positive(self, a: Any, b: Any) -> bool | None:
        """Whether f > 0 on [a, b], by its range or, if monotone, its lower end; None if open."""
        if not b > a:
            return True
        t = a.union(b)
        if self.over(t) > 0:
            return True
        slope = sign(self.over(t, 1))
        if slope:
            lower = a if slope == 1 else b
            if self.over(lower) > 0 or sign(self.near(lower)(0)) == 1:
                return True
        return False if sign(self.near(t.mid())(0)) == -1 else None

    def _grows(self, end: Any) -> Any | None:
        """A time until which f grows from a zero at 0; 0 if f begins positive, None if open."""
        leading = box(self.jet[self.order])
        if self.order == 0 and leading > 0:
            return arb(0)
        if not leading > 0 and not self.assumed:
            return None
        # If the leading derivative is only known to be >= 0, the next one must be positive.
        n, low = self.order + (not leading > 0), end
        for _ in range(HALVINGS):
            if self.over(arb(0).union(low), n) > 0:
                return low
            low = (low / 2).mid()
        return None


def holds_on(
    low: Any, high: Any, told: Callable[[Any, Any], bool | None], halvings: int = HALVINGS
) -> bool:
    """Whether a property is proved on an interval by bisection; ``told`` answers None if open."""
    todo = [(low, high, 0)]
    for _ in range(MOST_PARTS):
        if not todo:
            return True
        a, b, depth = todo.pop()
        holds = told(a, b)
        if holds:
            continue
        if holds is False or depth == halvings:
            return False
        middle = ((a + b) / 2).mid()
        todo += [(middle, b, depth + 1), (a, middle, depth + 1)]
    return False


class ZeroCrossing(NamedTuple):
    """The guard that ends a phase, the duration of the phase, and a bracket of it.

    From every start the guard crosses zero once in the bracket, with a derivative of one sign. At a
    plateau the phase ends in the middle, and the contact strikes after it (1) or before it (-1).
    """

    guard: int  # its code
    duration: Form
    bracket: Any  # a ball of times
    plateau: int = 0  # 1 or -1, as above; 0 elsewhere
    lands: bool = False  # whether the event ends a flight from rest

    @property
    def name(self) -> str:
        """The event as text, such as ``"gap 2"`` or ``"plateau+ 2"``."""
        name = name_of(self.guard)
        if self.plateau:
            return name.replace("gap", "plateau+" if self.plateau == 1 else "plateau-")
        return name


def name_of(guard: int) -> str:
    """A guard as text, such as ``"gap 2"``."""
    kind = KINDS[guard // 3]
    return kind if guard == SECTION else f"{kind} {guard % 3 + 1}"


def landing(guard: Guard, guess: float) -> ZeroCrossing | None:
    """The landing after a short flight from rest, f = t^2 h; None if it is not proved as such."""
    # A contact that leaves from rest with a small acceleration f_2 lands after a time of order f_2.
    # As f_2 goes to zero, so do the duration, and the speed and force of the landing: f itself has
    # no simple zero. But h falls at a rate near f_3 / 6, from h(0) >= 0 through zero exactly once,
    # and there f' = t^2 h' and f'' = t (4 h' + t h'') vanish only with the time.
    if not abs(guard.kappa) * arb(guess) ** 2 < LONGEST or sign(guard.jet[3]) != -1:
        return None
    h = replace(guard, formula=height)
    try:
        found = crossing(h, guess)
    except NotProved:
        return None
    bracket = found.bracket
    if sign(4 * h.over(bracket, 1) + bracket * h.over(bracket, 2)) != -1:
        return None
    end = abs(bracket).upper()
    ends = [(end * k / PARTS).mid() for k in range(PARTS + 1)]
    parts = [low.union(high) for low, high in pairwise(ends)]
    if any(sign(h.over(part, 1)) != -1 for part in (bracket, *parts)):
        return None
    return found._replace(lands=True)


def crossing(guard: Guard, guess: float, falls: int = -1) -> ZeroCrossing:
    """The zero of a guard near a guess, with a slope of the sign ``falls``; or NotProved."""
    at, over = guard.near, guard.over
    near = _approximate(at, guess)
    there = at(near)
    value, speed = there(0), there(1)
    if sign(speed) != falls:
        raise NotProved("a guard may turn where it fires")
    residual, head = value.box, near.parts[VALUE].head
    reach = (abs(residual / speed.box) * arb(1.5) + arb(2) ** (20 - ctx.prec)).upper()
    for _ in range(8):
        wide = (reach * 8 + arb(0.2) * (head - head.mid())).upper()
        bracket = head + arb(0, wide)
        slope = over(bracket, 1)
        if sign(slope) != falls:
            raise NotProved("a guard may turn where it fires")
        if abs(residual / slope) < reach:
            time = _form(at, near, value, slope, arb(0, reach))
            return ZeroCrossing(guard.code, time, bracket)
        reach = (reach * 2).upper()
    raise NotProved("the time of an event has no enclosure")


def _approximate(at: Callable[[Any], Derivatives], guess: float) -> Form:
    """Approximate zero on the curve s = 0 as a polynomial in p, by Newton's method; not proved."""
    frame = at(arb(guess))(0).frame
    t = Form(frame, [constant(frame, arb(guess)), *_nothing(frame)])
    correct = 0  # coefficients that are correct to rounding: each step doubles them
    for _ in range(60):
        there = at(t)
        value, speed = there(0).parts[VALUE], there(1).parts[VALUE]
        if speed.poly[0].contains(0):
            raise NotProved("a guard turns where it fires")
        exact = [Taylor(frame, thin(part.poly, frame.terms), ZERO) for part in (value, speed)]
        step = exact[0] * inverse(exact[1])
        poly = thin(t.parts[VALUE].poly - step.poly, frame.terms)
        t = Form(frame, [Taylor(frame, poly, ZERO), *_nothing(frame)])
        if abs(step.poly[0].mid()) < arb(2) ** (12 - ctx.prec):
            correct = 1 if correct == 0 else 2 * correct
            if correct >= frame.terms:
                return t
        elif not step.poly[0].is_finite():
            break
    raise NotProved("the time of an event has no enclosure")


def _nothing(frame: Any) -> Sequence[Taylor]:
    return [constant(frame, ZERO)] * (frame.depth - 1)


def _form(
    at: Callable[[Any], Derivatives], near: Form, residual: Form, slope: Any, reach: Any
) -> Form:
    """Form of the zero near a polynomial, with derivatives by the implicit function theorem."""
    # From f(t, s, p) = 0: t_i = -f_i / f_t and
    # t_ij = -(f_ij + f_it t_j + f_jt t_i + f_tt t_i t_j) / f_t.
    frame = near.frame
    there = near.parts[VALUE].widened(reach)  # the time, for all s
    fixed = Form(frame, [there, *_nothing(frame)])
    at_fixed = at(fixed)
    value, speed = at_fixed(0), at_fixed(1)
    over = inverse(speed.near[VALUE])
    on_curve = near.parts[VALUE].widened(residual.parts[VALUE].box / -slope)
    found = [on_curve]
    bend: Taylor | None = None
    for n in range(S, frame.depth):
        part = value.parts[n]
        if n in HALVES:
            bend = at_fixed(2).near[VALUE] if bend is None else bend
            i, j = HALVES[n]
            part = part + speed.parts[i] * found[j] + speed.parts[j] * found[i]
            part = part + bend * found[i] * found[j]
        found.append(-part * over)
    return Form(frame, found)
