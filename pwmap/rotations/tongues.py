"""Tongues: where a map of two increasing pieces has a cycle on which it acts as a rotation.

A cycle with the rotational word of p/q must satisfy q conditions, of which two bind. Number its
points 0 ... q - 1 from left to right. The map takes neighbours on the same side of the break to
neighbours, and multiplies the gap between them by a positive slope. Starting from the gap between
the points p - 1 and p, the images of the outermost ones, every gap is reached in this way, the last
one being that across the break, between q - p - 1 and q - p. So all gaps have the same sign: if the
largest point on the left and the smallest on the right lie on their own sides, all points do. It
matters neither what the multiplier is nor whether the pieces overlap. For contracted rotations,
x -> a x + d mod 1, the tongues are those of [Bugeaud1993] and [Laurent2018].
"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property

import sympy

from pwmap.algebra.arguments import checked_count, explained, shown
from pwmap.algebra.exact import Number, Portable, dense, quotient_to_sympy
from pwmap.algebra.roots import Real, gaps_and_roots, inside, real_roots, real_to_sympy, sign_at
from pwmap.maps.budget import BUDGET, Budget, Meter, check_work, metered
from pwmap.maps.diagonal import Cycle, PieceCondition, conditions_on
from pwmap.maps.piecewise_linear import PiecewiseLinearMap
from pwmap.rotations.pieces import increasing_pieces
from pwmap.rotations.words import farey, rotational_word

LETTER = 4  # work of one letter of a word
Piece_ = tuple[Real, Real]  # of the parameter axis: a gap or a root, see gaps_and_roots


@dataclass(frozen=True, kw_only=True, eq=False)
class Tongue(Portable):
    """A tongue of :func:`tongues`: where a cycle of rotation number ``rotation`` = p/q exists.

    ``word`` is its word from the leftmost point on. Formulas are computed on first use.
    """

    rotation: Fraction
    word: str
    _map: PiecewiseLinearMap = field(repr=False)

    @cached_property
    def cycle(self) -> Cycle:
        """The cycle with all of its conditions."""
        return self._map.cycle(self.word)

    @property
    def multiplier(self) -> sympy.Expr:
        """The multiplier of the cycle."""
        return quotient_to_sympy(self._map.orbits.slope(self._map.numbered(self.word)))

    @property
    def borders(self) -> tuple[sympy.Basic, ...]:
        """The conditions that bind: the points nearest to the break lie on their own sides.

        A fixed point has one of them, any other cycle two.
        """
        return tuple(relation for relation, _, _ in self._nearest)

    @cached_property
    def _nearest(self) -> tuple[PieceCondition, ...]:
        """The conditions on the points nearest to the break."""
        map_, word = self._map, self._map.numbered(self.word)
        found = list[PieceCondition]()
        for step in _steps_beside(self.rotation):
            point = map_.orbits.fixed_point(word[step:] + word[:step])
            found += conditions_on(map_, point, map_.layout, word[step])
        return tuple(found)

    @property
    def values(self) -> sympy.Set:
        """The values of the parameter with this cycle; ValueError unless there is one parameter."""
        if len(self._map.parameters) != 1:
            names = ", ".join(map(str, self._map.parameters)) or "none"
            raise ValueError(f"the map must have exactly one parameter, it has {names}")
        pieces = (piece for piece in self._axis_pieces() if self._holds(inside(piece)))
        return sympy.Union(
            *(sympy.Interval(*map(real_to_sympy, piece), *2 * (piece[0] is not piece[1],))
              for piece in pieces)
        )  # fmt: skip

    @property
    def lower(self) -> sympy.Expr:
        """The infimum of :attr:`values`, which may be ``-oo``; ValueError if they are empty."""
        return self._filled().inf

    @property
    def upper(self) -> sympy.Expr:
        """The supremum of :attr:`values`, which may be ``oo``; ValueError if they are empty."""
        return self._filled().sup

    def _filled(self) -> sympy.Set:
        values = self.values
        if values is sympy.EmptySet:
            raise ValueError(f"the cycle {self.word} exists for no admitted value of the parameter")
        return values

    def _axis_pieces(self) -> list[Piece_]:
        """The parameter axis, cut where a margin or the polynomial of an assumption vanishes."""
        numbers = [number for _, margin, _ in self._nearest for number in margin]
        numbers += [c.polynomial for c in self._map.definition.region.constraints]
        roots = {root for number in numbers for root in real_roots(dense(number))}
        return gaps_and_roots(sorted(roots))

    def _holds(self, value: Real) -> bool:
        def sign(number: Number) -> int:
            return sign_at(dense(number), value)

        return self._map.definition.region.broken(sign) is None and all(
            sign(top) * sign(bottom) > 0 or (closed and sign(top) == 0 != sign(bottom))
            for _, (top, bottom), closed in self._nearest
        )


@explained()
def tongues(
    map_: PiecewiseLinearMap, q_max: int, *, budget: Budget | Meter = BUDGET
) -> tuple[Tongue, ...]:
    """The tongues of all rotation numbers from 0/1 to 1/1 with denominators up to ``q_max``.

    Parameters
    ----------
    map_, q_max, budget
        A map of two increasing pieces, invertible or not, with any parameters; the largest
        denominator, which is the largest period; and the work that is allowed.

    Returns
    -------
    tuple of Tongue
        In the order of :func:`pwmap.rotations.farey`; a tongue may be empty. A word whose slope is
        1 for all parameter values has no isolated cycle and is left out.

    Raises
    ------
    TypeError, ValueError
        If the map has not two increasing pieces and one break, or ``q_max`` is no integer of at
        least 1; a ``BudgetError`` if all words together are too long.
    UndecidedError
        If the assumptions do not say whether the pieces increase.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, tongues
    >>> circle = PiecewiseLinearMap([("x/2 + d", "x < 2 - 2*d"), ("x/2 + d - 1", "x >= 2 - 2*d")])
    >>> for tongue in tongues(circle, 3)[1:-1]:
    ...     print(tongue.rotation, tongue.word, tongue.values)
    1/3 LLR Interval.Ropen(4/7, 9/14)
    1/2 LR Interval.Ropen(2/3, 5/6)
    2/3 LRR Interval.Ropen(6/7, 13/14)
    """
    increasing_pieces(map_)
    meter = metered(budget)
    letters = "".join(map_.letters)
    found = []
    last = checked_count(q_max, "the largest denominator")
    work = LETTER * last**3 // 5  # the words have about 2/pi**2 q_max**3 letters
    check_work(f"tongues up to the denominator {shown(last)}", work, meter)
    for rotation in meter.each(farey(last, budget=meter), "tongues"):
        meter.spend(LETTER * rotation.denominator)
        word = rotational_word(rotation, letters)
        top, bottom = map_.orbits.slope(map_.numbered(word))
        if top != bottom:
            found.append(Tongue(rotation=rotation, word=word, _map=map_))
    return tuple(found)


def _steps_beside(rotation: Fraction) -> tuple[int, ...]:
    """The steps at which a cycle is nearest to the break, on the left and on the right of it."""
    p, q = rotation.as_integer_ratio()
    if q == 1:
        return (0,)
    # step k is at point k p mod q: the largest on the left is q - p - 1, the smallest on the right
    # q - p, at the last step
    return (-1 - pow(p, -1, q)) % q, q - 1
