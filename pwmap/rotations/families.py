"""Families of cycles whose words grow with n: fixed point, multiplier and conditions for every n.

If the word w has the map A(x) = s x + c, w^n has the map s^n x + c (1 - s^n)/(1 - s), or x + n c if
s is 1. So all points of the cycle of a pattern are quotients of polynomials in the parameters, n
and the powers s^n, each of which is a variable of its own here [Avrutin2010: map replacement].

Which conditions bind: the points y_i = A^i(y_0) at the same letter of a repeated word are monotone
in i for s > 0, so that the first and the last decide. For s < 0 they alternate about the fixed
point of A: the first two decide for s > -1, where they approach it, the last two for s < -1. For
s = 0 all but the first coincide. A run of one letter with positive slope moves monotonically to the
next point, which lies beyond a break, so that only one end of the run decides.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import sympy
from sympy import QQ
from sympy.polys.fields import FracField
from sympy.polys.orderings import lex

from pwmap.algebra.arguments import checked_count, explained, shown
from pwmap.algebra.assumptions import UndecidedError
from pwmap.algebra.exact import Affine, Fraction_, cancelled, fraction_to_sympy, to_sympy
from pwmap.algebra.terms import checked_parameter
from pwmap.algebra.texts import printable
from pwmap.maps.budget import BUDGET, Budget, BudgetError, Meter, metered
from pwmap.maps.diagonal import Bound, letter_bounds, relation_of
from pwmap.maps.piecewise_linear import PiecewiseLinearMap
from pwmap.maps.words import Word
from pwmap.rotations.pieces import checked_map
from pwmap.rotations.words import WordRun, read_pattern

Element = Any  # of the field of rational functions of the parameters, n and the powers
_Place = tuple[int, int, int]  # the indices of a run, a letter of its word, and a repetition


@dataclass(frozen=True, slots=True, kw_only=True)
class FamilyCondition:
    """A condition of a :func:`pwmap.word_family`: a relation of the parameters, n and powers.

    It applies from n = ``since`` on; for smaller n the cycle does not have its point.
    """

    relation: sympy.Basic
    since: int
    # the relation in parts: a point, its place in the word, and the side of a break for it
    _point: Element = field(repr=False, compare=False)
    _place: _Place = field(repr=False, compare=False)
    _beyond: Bound = field(repr=False, compare=False)


@printable
@dataclass(frozen=True, slots=True, kw_only=True)
class FamilyCycle:
    """One cycle of a :func:`pwmap.word_family`, with the conditions that bind."""

    word: str
    x: sympy.Expr
    multiplier: sympy.Expr
    conditions: tuple[sympy.Basic, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class WordFamily:
    """The cycles of a pattern of words, for every n, of :func:`pwmap.word_family`.

    The exponent ``n`` is an integer not below ``least``, so that all exponents are positive.
    """

    pattern: str
    n: sympy.Symbol
    _map: PiecewiseLinearMap = field(repr=False)
    _runs: tuple[WordRun, ...] = field(repr=False)

    def __reduce__(self) -> tuple[Any, ...]:
        return word_family, (self._map, self.pattern, self.n.name)

    def __repr__(self) -> str:
        formulas = f"x={self.x}, multiplier={self.multiplier}, conditions={self.conditions}"
        return f"WordFamily(pattern={self.pattern!r}, n={self.n}, least={self.least}, {formulas})"

    @property
    def least(self) -> int:
        """The smallest value of n."""
        return max(1, *(1 - run.shift for run in self._runs if run.grows))

    @property
    def x(self) -> sympy.Expr:
        """The first point of the cycle.

        At isolated parameter values where a repeated word has slope 1, the formula holds as a
        limit.
        """
        return self._to_sympy(self._cycle.fixed_point)

    @property
    def multiplier(self) -> sympy.Expr:
        """The multiplier of the cycle."""
        return self._to_sympy(self._cycle.slope)

    @cached_property
    def conditions(self) -> tuple[FamilyCondition, ...]:
        """The binding conditions: for every n they imply that each point lies in its piece."""
        found = dict[tuple[Element, int, int], tuple[Element, _Place, Bound]]()
        for margin, since, point, place, bound in self._margins():
            _, side, closed = bound
            known = found.get((margin, side, since))
            # of two conditions with one margin the strict one implies the other
            if known is None or (known[2][2] and not closed):
                found[margin, side, since] = point, place, bound
        return tuple(
            FamilyCondition(
                relation=relation_of(self._map, self._to_sympy(point), bound),
                since=since,
                _point=point,
                _place=place,
                _beyond=bound,
            )
            for (_, _, since), (point, place, bound) in found.items()
        )

    def word(self, n: int, *, budget: Budget | Meter = BUDGET) -> str:
        """The word for one ``n``; ValueError unless that is an integer of at least :attr:`least`.

        BudgetError if it has more letters than the ``budget`` allows.
        """
        return self._map.spelled(self._word(self._checked(n), metered(budget)))

    def at(self, n: int, *, budget: Budget | Meter = BUDGET) -> FamilyCycle:
        """The cycle for one ``n``, as of ``map_.cycle(word)``, with the binding conditions only.

        ValueError unless ``n`` is an integer of at least :attr:`least`, or if the multiplier is 1;
        BudgetError if the word or the formulas exceed the ``budget``.
        """
        count, meter = self._checked(n), metered(budget)
        word, orbits = self._word(count, meter), self._map.orbits
        spelled, multiplier = self._map.spelled(word), orbits.slope(word)
        if multiplier[0] == multiplier[1]:
            raise ValueError(f"the slope of {spelled} is 1: it has no isolated cycle")
        meter.spend(len(word) * orbits.work(len(word)))
        found = [self._relation(c, count, word) for c in self.conditions if c.since <= count]
        return FamilyCycle(
            word=spelled,
            x=fraction_to_sympy(orbits.fixed_point(word)),
            multiplier=fraction_to_sympy(multiplier),
            conditions=tuple(c for c in dict.fromkeys(found) if c != sympy.true),
        )

    def thresholds(self, parameter: object) -> tuple[sympy.Expr, ...]:
        """The values of ``parameter`` at which :attr:`conditions` are equalities.

        They are formulas in n and the other parameters. Conditions without this parameter are left
        out. ValueError if the map has no such parameter, or a condition is not linear in it.
        """
        symbols = self._map.parameters
        index = [str(each) for each in symbols].index(checked_parameter(parameter, symbols))
        found = list[sympy.Expr]()
        for condition in self.conditions:
            margin = condition._point - self._break(condition._beyond[0])
            if margin.numer.degree(index) > 1 or margin.denom.degree(index) > 0:
                raise ValueError(
                    f"{symbols[index]} does not occur linearly in the points of the cycle"
                )
            slope = margin.numer.diff(index)
            rest = margin.numer - slope * margin.numer.ring.gens[index]
            if slope:
                found.append(self._to_sympy(self._field(-rest) / self._field(slope)))
        return tuple(found)

    def _checked(self, n: int) -> int:
        count = checked_count(n, f"the exponent {self.n}")
        if count < self.least:
            raise ValueError(f"the exponent {self.n} must be at least {self.least}, got {count}")
        return count

    def _word(self, n: int, meter: Meter) -> Word:
        most, letters = meter.budget.letters, self._first(n, len(self._runs))
        if letters > most:
            raise BudgetError(
                f"the word for {self.n} = {shown(n)} has {shown(letters)} letters, at most "
                f"{most} are allowed"
            )
        return self._letters(n)

    def _letters(self, n: int) -> Word:
        return tuple(letter for run in self._runs for letter in run.word * run.count(n))

    def _first(self, n: int, run: int) -> int:
        """The number of letters before a run, by its index."""
        return sum(len(each.word) * each.count(n) for each in self._runs[:run])

    def _break(self, k: int) -> Element:
        return self._element(self._map.orbits.preimage(k, ()))

    def _relation(self, condition: FamilyCondition, n: int, word: Word) -> sympy.Basic:
        """The relation of a condition for one n."""
        number, letter, repetition = condition._place
        run = self._runs[number]
        turns = repetition if repetition >= 0 else run.count(n) + repetition
        at = self._first(n, number) + turns * len(run.word) + letter
        point = self._map.orbits.fixed_point(word[at:] + word[:at])
        return relation_of(self._map, fraction_to_sympy(point), condition._beyond)

    # --- The field: of the parameters, n, and a variable for each s^n (s not 0 or 1) --------------

    @cached_property
    def _powers(self) -> dict[Fraction_, sympy.Symbol]:
        """The variables that stand for powers, by their bases."""
        bases = (cancelled(self._map.orbits.slope(run.word)) for run in self._runs if run.grows)
        listed = dict.fromkeys(s for s in bases if s[0] and s[0] != s[1])
        return {base: sympy.Dummy(f"power_{i}") for i, base in enumerate(listed)}

    @cached_property
    def _field(self) -> FracField:
        return FracField((*self._map.parameters, self.n, *self._powers.values()), QQ, lex)

    def _element(self, fraction: Fraction_) -> Element:
        """A quotient of the map's ring as an element of the field."""
        top, bottom = fraction
        return self._field(top) / self._field(bottom)

    def _to_sympy(self, element: Element) -> sympy.Expr:
        powers = {
            variable: (to_sympy(top) / to_sympy(bottom)) ** self.n
            for (top, bottom), variable in self._powers.items()
        }
        return sympy.factor(element.as_expr()).xreplace(powers)

    @cached_property
    def _cycle(self) -> Affine:
        """The affine map along one round of the cycle."""
        whole = Affine(self._field.one, self._field.zero)
        for run in self._runs:
            whole = self._along(run.word, run).after(whole)
        return whole

    def _once(self, word: Word) -> Affine:
        orbits = self._map.orbits
        return Affine(self._element(orbits.slope(word)), self._element(orbits.intercept(word)))

    def _along(self, word: Word, run: WordRun) -> Affine:
        """The map of a word repeated as often as a run: the run's word or a cyclic shift of it."""
        slope, intercept = once = self._once(word)
        if not run.grows or not slope:
            return once
        base = cancelled(self._map.orbits.slope(word))
        if base not in self._powers:
            n = self._field.gens[len(self._map.parameters)]
            return Affine(slope, (n + run.shift) * intercept)
        power = self._field(self._powers[base]) * slope**run.shift
        return Affine(power, intercept * (1 - power) / (1 - slope))

    # --- Conditions -------------------------------------------------------------------------------

    def _margins(self) -> Iterator[tuple[Element, int, Element, _Place, Bound]]:
        """Yield the margins of binding conditions, from which n on, and their points and bounds."""
        x, layout = self._cycle.fixed_point, self._map.layout
        for number, (run, aim) in enumerate(zip(self._runs, self._aims(), strict=True)):
            for letter, place, point in self._decisive(run, x):
                for k, side, closed in letter_bounds(layout, run.word[letter]):
                    if aim and side != (aim if place == 0 else -aim):
                        continue  # the other end of the run is nearer to this break
                    margin = side * (point - self._break(k))
                    # the number of repetitions without which the place does not exist
                    needed = place + 1 if place >= 0 else -place
                    since = max(self.least, needed - run.shift)
                    if not _holds_always(margin, closed):
                        yield margin, since, point, (number, letter, place), (k, side, closed)
            x = self._along(run.word, run)(x)

    def _decisive(self, run: WordRun, x: Element) -> Iterator[tuple[int, int, Element]]:
        """Yield letters, repetitions and points of a run that may bind; x is its first point."""
        for letter in range(len(run.word)):
            start = self._once(run.word[:letter])(x) if letter else x
            turned = run.word[letter:] + run.word[:letter]
            for place in self._places(run):
                point = start
                if place > 0:
                    point = self._once(turned)(start)
                elif place < 0:
                    point = self._along(turned, run._replace(shift=run.shift + place))(start)
                yield letter, place, point

    def _places(self, run: WordRun) -> tuple[int, ...]:
        """The repetitions that may bind: counted from 0 on, or from the end, -1 being the last."""
        if not run.grows:
            return (0,)
        sign = self._map.oracle.slope(run.word)
        if sign > 0:
            return 0, -1
        try:
            closer = not sign or self._map.oracle.multiplier(run.word, -1) >= 0
        except UndecidedError:
            return 0, 1, -2, -1
        return (0, 1) if closer else (-2, -1)

    def _aims(self) -> list[int]:
        """The directions in which runs of one letter move: right (1), left (-1), or unused (0)."""
        aims, kept = [0] * len(self._runs), set[int]()
        for i, run in enumerate(self._runs):
            j = (i + 1) % len(self._runs)
            letter, after = run.word[-1], self._runs[j].word[0]
            single = run.grows and len(run.word) == 1 and letter != after
            if i in kept or not single or self._places(run) != (0, -1):
                continue
            if 0 in self._places(self._runs[j]) and not aims[j]:
                # one end of this run then follows from the next point, whose conditions are kept
                aims[i] = 1 if after > letter else -1
                kept.add(j)
        return aims


@explained()
def word_family(map_: PiecewiseLinearMap, pattern: str, n: object = "n") -> WordFamily:
    """The cycles of a pattern of words such as ``R L^n``, for every n.

    Parameters
    ----------
    map_, n
        A map with any pieces and parameters, and the name of the exponent.
    pattern
        Letters of the map and groups in parentheses, each with or without an exponent: an integer,
        n, or a sum such as ``(n+1)``. For instance ``"(RL)^n R"`` or ``"L R^n L R^(n+1)"``.

    Returns
    -------
    WordFamily
        First point, multiplier and conditions of the cycle as formulas in n.

    Raises
    ------
    TypeError, ValueError
        If ``map_`` is no map or an iterate, or has a parameter n or a one-point piece; if the
        pattern cannot be read or has no exponent n; or if the multiplier is 1 for every n.
    UndecidedError
        If the assumptions do not decide the sign of the slope of a repeated word.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, word_family
    >>> p1 = PiecewiseLinearMap([("r - 2", "x <= 0"), ("r - a*x", "x > 0")], given=["a > 1"])
    >>> family = word_family(p1, "L R^n")
    >>> family.word(3), family.multiplier, family.thresholds("r")[0]
    ('LRRR', 0, 2*(-a)**n*(a + 1)/(a*(-a)**n + 1))
    >>> family.at(2).conditions
    (a**2*r - 2*a**2 - a*r + r <= 0, r - 2 > 0, -a*r + 2*a + r > 0)
    """
    layout = checked_map(map_)
    for letter in dict.fromkeys(layout.slots):
        if layout.slots.count(letter) == 1 and layout.slots.index(letter) % 2:
            raise ValueError(f"the piece {map_.letters[letter]} is a single point")
    name = str(n)
    if not name.isidentifier() or name in map(str, (*map_.parameters, *map_.letters, map_.x)):
        raise ValueError(f"the exponent needs a name that is not taken by the map, got {name!r}")
    family = WordFamily(
        pattern=pattern,
        n=sympy.Symbol(name, integer=True, positive=True),
        _map=map_,
        _runs=read_pattern(pattern, map_.letters, name),
    )
    # the slope is c s^n, also where powers cancel, as of 2 and 1/2: 1 for two n means for all
    slopes = [map_.orbits.slope(family._letters(n)) for n in (family.least, family.least + 1)]
    if all(top == bottom for top, bottom in slopes):
        raise ValueError(f"the slope of {pattern} is 1 for every n: it has no isolated cycle")
    _ = family.conditions  # UndecidedError
    return family


def _holds_always(margin: Element, closed: bool) -> bool:
    """Whether a margin is a positive number, or zero where the condition is closed."""
    if not (margin.numer.is_ground and margin.denom.is_ground):
        return False
    value = margin.numer.coeff(1) / margin.denom.coeff(1)
    return bool(value > 0 or (closed and value == 0))
