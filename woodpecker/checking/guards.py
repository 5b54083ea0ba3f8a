"""Verification of guards over a phase: that one crosses zero in a bracket, and others do not."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Any

from woodpecker.checking.forms import F, constant, halves, shapes, waves
from woodpecker.checking.intervals import Box, I, NotSeparated, T, inverse

Guard = tuple[str, int]
HALVINGS = 36  # of a phase in one proof, at most
PARTS = 5000  # of a phase in one proof, at most: true certificates need some hundred


def named(guard: Guard) -> str:
    """The name of a guard in certificates, with contacts from 1 on."""
    kind, i = guard
    return kind if kind == "section" else f"{kind} {i + 1}"


def combined(f: Sequence[Any], kappa: I, t: Any, order: int) -> F | I:
    """The derivative of some order of f = f0 + f1 t + f2 s_2 + f3 s_3."""
    s: list[Any] = waves(kappa, t)
    first, second = (s[k] if k >= 0 else s[k + 2] * kappa for k in (2 - order, 3 - order))
    found: F | I = f[2] * first + f[3] * second
    if order == 0:
        found = f[0] + f[1] * t + found
    return f[1] + found if order == 1 else found


def height(f: Sequence[Any], kappa: I, t: Any, order: int) -> F | I:
    """The same of h = f2 c_2 + f3 t c_3; d c_k / dt = kappa t (c_(k+1) - k c_(k+2))."""
    x = t * t * kappa
    c: list[Any] = shapes(x, 7)

    def slope(k: int) -> Any:
        return c[k + 1] - c[k + 2] * I.of(k)

    def bend(k: int) -> Any:
        return slope(k + 1) - slope(k + 2) * I.of(k)

    if order == 0:
        a, b = c[2], c[3] * t
    elif order == 1:
        a, b = slope(2) * t * kappa, slope(3) * x + c[3]
    else:
        a = (bend(2) * x + slope(2)) * kappa
        b = (bend(3) * x + slope(3) * I.of(3)) * t * kappa
    found: F | I = f[2] * a + f[3] * b
    return found


class GuardValue:
    """A guard over a phase, from its value and three derivatives at the start of the phase."""

    def __init__(
        self, box: Box, guard: Guard, kappa: I, jet: list[F | I], zeros: int, known: bool,
        formula: Callable[[Sequence[Any], I, Any, int], F | I] = combined,
    ) -> None:  # fmt: skip
        self.box, self.guard, self.kappa, self.formula = box, guard, kappa, formula
        self.jet, self.zeros = jet, zeros  # the first entries of a jet are exactly zero
        self.ranges = [f.value if isinstance(f, F) else f for f in jet]
        self.known = known  # whether the entry after these is known to be at least zero

    def at(self, t: F | I, order: int = 0) -> F | I:
        """The guard or its derivative of some order at a time."""
        return self.formula(self.jet, self.kappa, t, order)

    def over(self, t: I, order: int = 0) -> I:
        """Range over an interval of times and the box."""
        found = self.formula(self.ranges, self.kappa, t, order)
        assert isinstance(found, I)
        return found

    def value(self, t: I) -> I:
        """Range at one time over the box."""
        found = self.at(t)
        return found.value if isinstance(found, F) else found

    def lasts(self, end: I, falling: I | None) -> bool:
        """Whether it is proved not to fire in (0, end], or before its zero in ``falling``."""
        if self.guard[0] == "section":
            return end.sign() != 1 or everywhere(I.of(0), end, self.turns_not)
        if end.sign() != 1:
            return falling is not None and self.over(I.of(0).hull(falling), 1).sign() == -1
        first = self.begin(end)
        return first is not None and everywhere(first, end, self._is_positive)

    def _is_positive(self, a: I, b: I) -> bool | None:
        """Whether f > 0 on [a, b], by its range or, if monotone, its lower end; None if open."""
        if not a.less(b):
            return True
        t = a.hull(b)
        if self.over(t).sign() == 1:
            return True
        slope = self.over(t, 1).sign()
        if slope and self.value(a if slope == 1 else b).sign() == 1:
            return True
        return False if self.value(t.mid).sign() == -1 else None

    def begin(self, end: I) -> I | None:
        """A time until which it grows from a zero at 0; 0 if it begins positive, None if open."""
        positive = self.ranges[self.zeros].sign() == 1
        if self.zeros == 0 and positive:
            return I.of(0)
        if not positive and not self.known:
            return None
        order = self.zeros + (not positive)
        for k in range(HALVINGS):
            t = end * I.of(Fraction(1, 2**k))
            if self.over(I.of(0).hull(t), order).sign() == 1:
                return t.low
        return None

    def turns_not(self, a: I, b: I) -> bool | None:
        """Whether the bird's velocity does not rise through zero in (a, b]; None if open."""
        t = a.hull(b)
        slope = self.over(t, 1).sign()
        if self.over(t).sign() or slope == -1:
            return True
        starts = a.sign() == 0 and self.zeros == 1
        return True if slope == 1 and (starts or self.value(b).sign() == -1) else None

    def crossing(self, bracket: I, direction: int) -> F:
        """The time at which the guard crosses zero: exactly once in the bracket."""
        if self.over(bracket, 1).sign() != direction:
            raise NotSeparated(f"{named(self.guard)} may turn where it fires")
        return self.root(bracket)

    def landing(self, bracket: I) -> F | None:
        """The landing after a flight from rest, f = t^2 h; None if h may not fall through zero."""
        # If h falls, f' = t^2 h' and f'' = t (4 h' + t h'') are negative where it lands.
        if self.ranges[3].sign() != -1:
            return None
        h = GuardValue(self.box, self.guard, self.kappa, self.jet, 0, False, height)
        ends = [bracket.size * I.of(Fraction(k, 16)) for k in range(17)]
        parts = [bracket, *(a.hull(b) for a, b in pairwise(ends))]
        try:
            if any(h.over(part, 1).sign() != -1 for part in parts):
                return None
            if (h.over(bracket, 1) * I.of(4) + bracket * h.over(bracket, 2)).sign() != -1:
                return None
            return h.root(bracket)
        except NotSeparated:
            return None

    def root(self, bracket: I) -> F:
        """The zero of a guard that is monotone on a bracket, as a function over the box."""
        # The zero is at most |f(t) / f'| from an approximate polynomial t, with f' over the
        # bracket. If all these times lie in the bracket, f changes its sign there.
        box = self.box
        at: Callable[..., Any] = self.at
        t = constant(box, bracket.mid)
        for k in range(40):
            value, speed = at(t), at(t, 1)
            step = thin(value.parts[0]) * inverse(thin(speed.parts[0]))
            moved = thin(t.parts[0] - thin(step))
            t = F(box, [moved, *t.parts[1:]])
            if k > 3 and abs(float(step.first)) < 1e-25 and 2 ** (k - 3) >= box.terms:
                break
        slope = self.over(bracket, 1)
        value = at(t)
        reach = (value.value / slope).size
        reach = (reach + reach * I.of(Fraction(1, 2)) + I.of(Fraction(1, 10**28))).ball
        whole = t.parts[0].wider(reach)
        if not whole.range.within(bracket):
            raise NotSeparated("an event lies outside its bracket")
        fixed = F(box, [whole, *t.parts[1:]])
        value, speed = at(fixed), at(fixed, 1)
        down = inverse(speed.all[0])
        curve = t.parts[0].wider(-(at(t).parts[0].range / slope))
        found = [curve]
        for n in range(1, box.depth):
            part = value.parts[n]
            if n > 2:
                i, j = halves(n)
                bend = at(fixed, 2).all[0]
                part = part + speed.parts[i] * found[j] + speed.parts[j] * found[i]
                part = part + bend * found[i] * found[j]
            found.append(-(part * down))
        return F(box, found)


def everywhere(low: I, high: I, told: Callable[[I, I], bool | None]) -> bool:
    """Whether a property is proved on an interval by bisection; ``told`` answers None if open."""
    todo, parts = [(low, high, 0)], 0
    while todo:
        a, b, depth = todo.pop()
        parts += 1
        holds = told(a, b)
        if holds is None:
            if depth == HALVINGS or parts == PARTS:
                return False
            middle = a.hull(b).mid
            todo += [(middle, b, depth + 1), (a, middle, depth + 1)]
        elif not holds:
            return False
    return True


def thin(f: T) -> T:
    """A Taylor model without its rest."""
    return T(f.box, f.c)
