"""Profiles: functions of a map's variable that are given slot by slot.

n breaks cut the line into 2 n + 1 slots: open intervals and breaks in turn. On each slot a profile
has a quotient, a truth value, a sign, or None where it is undefined. Operations work slot by slot;
a comparison adds breaks where a difference is zero. Assumptions decide the order of breaks.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cmp_to_key
from itertools import pairwise
from typing import Any, NamedTuple

import sympy

from pwmap.algebra.arguments import shortened
from pwmap.algebra.arithmetic import Arithmetic, NotPolynomialError, Quotient
from pwmap.algebra.assumptions import AssumedRegion, UndecidedError
from pwmap.algebra.exact import Fraction_, Number, cancelled, fraction_to_sympy, to_sympy
from pwmap.algebra.terms import CONDITIONS, RELATIONS, Operation, Term, plain_name

MAX_BREAKS = 1000  # a text of a few nested pieces can make millions
_CONNECTIVES: dict[Operation, Callable[[Sequence[bool]], bool]] = {
    Operation.AND: all, Operation.OR: any, Operation.NOT: lambda values: not values[0],
}  # fmt: skip


class Profile(NamedTuple):
    """A function of the variable: sorted breaks, and a value on each slot."""

    breaks: tuple[Fraction_, ...]
    slots: tuple[Any, ...]


class ProfileLine:
    """The line of a variable, over which expression trees become profiles."""

    def __init__(self, x: sympy.Symbol, region: AssumedRegion, arithmetic: Arithmetic) -> None:
        self.x = x
        self._name = plain_name(x)
        self._region = region
        self._arithmetic = arithmetic
        self._known: dict[int, Profile] = {}
        self._orders: dict[tuple[Fraction_, Fraction_], int] = {}

    # --- Trees ----------------------------------------------------------------------------------

    def formula(self, term: Term) -> Profile:
        """A formula as a profile of quotients.

        UndecidedError if the assumptions leave the order of breaks open; ValueError if it is no
        formula, too large, or no polynomial on a slot.
        """
        if term.operation in CONDITIONS:
            raise ValueError(f"expected a formula such as 2*{self.x}, got the condition {term}")
        return self._profile(term)

    def condition(self, term: Term) -> Profile:
        """A condition as a profile of truth values; errors as for :meth:`formula`."""
        if term.operation not in CONDITIONS:
            raise ValueError(f"expected a condition such as {self.x} < 0, got {term}")
        return self._profile(term)

    def _profile(self, term: Term) -> Profile:
        found = self._known.get(id(term))
        if found is None:
            found = self._known[id(term)] = self._worked_out(term)
        return found

    def _worked_out(self, term: Term) -> Profile:
        operation = term.operation
        if operation is Operation.NAME and plain_name(term.value) == self._name:
            return Profile((), (self._arithmetic.variable,))
        if operation in RELATIONS:
            return self._relation(term)
        if operation in CONDITIONS:
            return self._connected(term)
        if operation is Operation.PIECEWISE:
            return self._chosen_by_conditions(term)
        profiles = [self.formula(argument) for argument in term.arguments]
        if operation is Operation.ABS:
            negative = self._lifted(profiles, lambda v: self._arithmetic.negative(v[0]))
            return self._larger([profiles[0], negative], 1, term)
        if operation in (Operation.MAX, Operation.MIN):
            return self._larger(profiles, 1 if operation is Operation.MAX else -1, term)
        return self._lifted(profiles, lambda values: self._arithmetic.applied(term, values))

    def _relation(self, term: Term) -> Profile:
        try:
            profiles = [self.formula(argument) for argument in term.arguments]
        except NotPolynomialError:
            raise self._no_comparison(term) from None
        holding = RELATIONS[term.operation]
        signs = self._signs(self._difference(*profiles), term)
        return self._lifted([signs], lambda values: values[0] in holding)

    def _connected(self, term: Term) -> Profile:
        if term.operation is Operation.TRUTH:
            return Profile((), (term.value,))
        profiles = [self.condition(argument) for argument in term.arguments]
        return self._lifted(profiles, _CONNECTIVES[term.operation])

    def _chosen_by_conditions(self, term: Term) -> Profile:
        """A Piecewise: the first condition that holds counts."""
        pairs = [pair.arguments for pair in term.arguments]
        formulas = [self.formula(formula) for formula, _ in pairs]
        conditions = [self.condition(condition) for _, condition in pairs]
        breaks = self.union([*formulas, *conditions])
        spread = [self.spread(profile, breaks) for profile in (*formulas, *conditions)]

        def value(slot: int) -> Quotient | None:
            for formula, condition in zip(spread, spread[len(pairs) :], strict=False):
                if condition[slot] is not False:
                    return formula[slot] if condition[slot] else None
            return None

        return Profile(breaks, tuple(map(value, range(2 * len(breaks) + 1))))

    def _larger(self, profiles: Sequence[Profile], sense: int, term: Term) -> Profile:
        """The largest of some profiles, or the smallest for a sense of -1."""
        left = list(profiles)
        while len(left) > 1:
            # a tie at a break is decided by the slot on its right, so pairs may come in any order
            pairs = zip(left[::2], left[1::2], strict=False)
            odd = left[-1:] if len(left) % 2 else []
            left = [self._larger_of_two(one, other, sense, term) for one, other in pairs] + odd
        return left[0]

    def _larger_of_two(self, one: Profile, other: Profile, sense: int, term: Term) -> Profile:
        breaks, signs = self._signs(self._difference(one, other), term)
        sides = [signs[i + 1] or 0 if i % 2 and sign == 0 else sign for i, sign in enumerate(signs)]
        return self._lifted(
            [Profile(breaks, tuple(sides)), one, other],
            lambda v: v[1] if sense * v[0] >= 0 else v[2],
        )

    def _difference(self, left: Profile, right: Profile) -> Profile:
        arithmetic = self._arithmetic
        return self._lifted(
            [left, right], lambda v: arithmetic.sum([v[0], arithmetic.negative(v[1])])
        )

    # --- Slots ----------------------------------------------------------------------------------

    def union(self, profiles: Iterable[Profile]) -> tuple[Fraction_, ...]:
        """The sorted breaks of all profiles; UndecidedError if open, ValueError if two coincide."""
        several = {profile.breaks for profile in profiles if profile.breaks}
        if len(several) <= 1:
            return next(iter(several), ())
        found = dict.fromkeys(b for breaks in several for b in breaks)
        if len(found) > MAX_BREAKS:
            raise ValueError(f"a map may have {MAX_BREAKS} breaks, this one has more")
        self._arithmetic.spend(4 * len(found))
        ordered = sorted(sorted(found, key=str), key=cmp_to_key(self._order))
        for left, right in pairwise(ordered):
            if self._order(left, right) == 0:
                shown = f"{_shown(left)} and {_shown(right)}"
                raise ValueError(f"the breaks {shown} coincide under {self._region}")
        return tuple(ordered)

    def spread(self, profile: Profile, breaks: Sequence[Fraction_]) -> list[Any]:
        """The values of a profile on the slots of ``breaks``, which contain its own."""
        if not profile.breaks:
            return [profile.slots[0]] * (2 * len(breaks) + 1)
        self._arithmetic.spend(1 + len(breaks) // 50)
        values, own = [profile.slots[0]], 0
        for b in breaks:  # both are sorted
            if own < len(profile.breaks) and profile.breaks[own] == b:
                values += profile.slots[2 * own + 1 : 2 * own + 3]
                own += 1
            else:
                values += [values[-1]] * 2
        return values

    def _lifted(self, profiles: Sequence[Profile], function: Callable[[Any], Any]) -> Profile:
        """Apply a function to the values slot by slot; None where one of them is None."""
        breaks = self.union(profiles)
        if not breaks:
            columns = [tuple(profile.slots[0] for profile in profiles)]
        else:
            columns = list(zip(*(self.spread(p, breaks) for p in profiles), strict=True))
        return Profile(breaks, tuple(None if None in c else function(c) for c in columns))

    # --- Signs ----------------------------------------------------------------------------------

    def _signs(self, profile: Profile, term: Term) -> Profile:
        """The signs of a profile of quotients, whose zeros become breaks."""
        ends = (None, *profile.breaks, None)
        breaks: list[Fraction_] = []
        slots: list[int | None] = []
        for i, value in enumerate(profile.slots):
            if i % 2:
                breaks.append(profile.breaks[i // 2])
            if value is None:
                slots.append(None)
            elif i % 2:
                slots.append(self._sign_at(value, profile.breaks[i // 2], term))
            else:
                zero, signs = self._signs_between(value, ends[i // 2], ends[i // 2 + 1], term)
                breaks += zero
                slots += signs
        return Profile(tuple(breaks), tuple(slots))

    def _signs_between(
        self, value: Quotient, low: Fraction_ | None, high: Fraction_ | None, term: Term
    ) -> tuple[list[Fraction_], list[int]]:
        """The zero of a quotient in an open interval, if there is one, and its signs."""
        if len(value.top) > 2:
            raise self._no_comparison(term)
        steepness = 0 if value.is_constant else self._sign(value.top[1], value.bottom, term)
        if steepness == 0:
            return [], [self._sign(value.top[0], value.bottom, term) if value.top else 0]
        zero = cancelled((-value.top[0], value.top[1]))
        if low is not None and self._order(zero, low) <= 0:
            return [], [steepness]
        if high is not None and self._order(zero, high) >= 0:
            return [], [-steepness]
        return [zero], [-steepness, 0, steepness]

    def _sign_at(self, value: Quotient, place: Fraction_, term: Term) -> int:
        times, plus = self._arithmetic.times, self._arithmetic.plus
        total, power = self._arithmetic.zero, self._arithmetic.one
        for coefficient in reversed(value.top):  # Horner's rule, without denominators
            total = plus(times(total, place[0]), times(coefficient, power))
            power = times(power, place[1])
        odd = self._arithmetic.one if len(value.top) % 2 else place[1]
        return self._sign(total, times(value.bottom, odd), term)

    def _sign(self, top: Number, bottom: Number, term: Term) -> int:
        try:
            return self._region.sign(top) * self._region.sign(bottom)
        except UndecidedError:
            if self._name in term.names():
                raise
            if term.operation not in CONDITIONS:
                raise ValueError(
                    f"what {term} is does not follow from the assumptions, which must say the sign "
                    f"of {to_sympy(top)} (given)"
                ) from None
            raise ValueError(
                f"the condition {term} does not contain the variable {self.x}: it belongs among "
                "the assumptions (given), or the variable is another one"
            ) from None

    def _no_comparison(self, term: Term) -> ValueError:
        return ValueError(
            f"the condition {term} must compare {self.x} with a polynomial in the parameters"
        )

    def _order(self, left: Fraction_, right: Fraction_) -> int:
        if (left, right) not in self._orders:
            times, decide = self._arithmetic.times, self._region.sign
            difference = times(left[0], right[1]) - times(right[0], left[1])
            try:
                sense = decide(left[1]) * decide(right[1])
                self._orders[left, right] = sense * decide(difference)
            except UndecidedError as error:
                message = f"the breaks of {self.x} have no certain order: {error}"
                raise UndecidedError(message, error.polynomial) from None
        return self._orders[left, right]


def slot_name(slot: int, breaks: Sequence[Fraction_], x: sympy.Symbol) -> str:
    """A slot as text, such as ``0 < x < r``."""
    if slot % 2:
        return f"{x} = {_shown(breaks[slot // 2])}"
    left = f"{_shown(breaks[slot // 2 - 1])} < " if slot else ""
    right = f" < {_shown(breaks[slot // 2])}" if slot < 2 * len(breaks) else ""
    return f"{left}{x}{right}" if left or right else "the line"


def _shown(fraction: Fraction_) -> str:
    return shortened(str(fraction_to_sympy(fraction)), 60)
