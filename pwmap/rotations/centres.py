"""Organising centres: parameter points where both limits at the break of two pieces lie on it.

Near such a point of two parameters, also called a big bang bifurcation [AvrutinSchanz2006], the map
is, with y = x - b, L(b) = b + i and R(b) = b - j,

    y -> s y + i (left),    y -> m y - j (right),

and scaling y, i and j by a common factor changes nothing. So cycles exist in sectors that meet at
the centre, infinitely many of them in the quadrant i > 0, j > 0, where there is no fixed point.

If both slopes lie in (-1, 1), their signs decide [Granados2017; Avrutin2019]:

- Both positive: rotational cycles, one at a time, of all rotation numbers from 0 to 1. Between the
  sectors of two Farey neighbours lies that of their mediant: periods add.
- One positive, say s on the left, and one not, m = -t: cycles R L^n, n = 0, 1, 2, ... With h_n =
  (s^-n - 1)/(1 - s), the point y = -h_n i reaches the break in n steps on the left, so that R L^n
  exists for j/i from h_(n - 1) - t to h_n; for n = 0, a fixed point, up to 0. For t > 0 neighbours,
  and no others, coexist, as h_(n + 1) - t > h_n; for t = 0 each begins where the previous one ends.
  Periods increase by one [Avrutin2011].
- None positive, -s and -t: for i > 0, j > 0 all orbits converge to L R. It coexists with the fixed
  point on the right for -t i < j < 0, and with that on the left for -s j < i < 0. For i < 0, j < 0
  both fixed points exist [Hogan2007].
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from functools import partial
from itertools import count
from typing import Any

import sympy
from sympy import QQ
from sympy.polys.fields import FracElement
from sympy.polys.orderings import lex
from sympy.polys.rings import PolyElement, PolyRing

from pwmap.algebra.arguments import explained
from pwmap.algebra.exact import Fraction_, Number, dense, fraction_to_sympy, sign, to_sympy
from pwmap.algebra.inequalities import value_at
from pwmap.algebra.numbers import value_of
from pwmap.algebra.roots import real_roots, real_to_sympy
from pwmap.algebra.terms import checked_parameter
from pwmap.algebra.texts import printable
from pwmap.maps.piecewise_linear import PiecewiseLinearMap
from pwmap.maps.words import CriticalOrbit
from pwmap.rotations.pieces import LEFT, RIGHT, two_pieces


class CentreKind(Enum):
    """The bifurcation structure around an organising centre."""

    ADDING = "period adding: between two neighbours is a cycle with the points of both"
    INCREMENTING = "period incrementing: adjacent cycles of n and n + 1 points coexist"
    SEPARATED = "period incrementing: each cycle of n + 1 points begins where that of n ends"
    ALTERNATING = "fixed points and a cycle of two points"
    EXPANDING = "a slope is not in (-1, 1): the cited results do not apply"
    DEGENERATE = "the two limits do not pass the break independently of one another"


@printable
@dataclass(frozen=True, slots=True, kw_only=True)
class OrganisingCentre:
    """An organising centre in the plane of two parameters, of :func:`organising_centre`.

    ``values`` are those of both parameters, ``x`` is the break, ``slopes`` are those of the left
    and the right piece. ``kind`` says which cycles exist around the centre where L(b) > b > R(b).
    ``patterns`` describe their words for :func:`pwmap.word_family`: for period adding the two
    families that accumulate at the fixed points, for period incrementing the only one.
    """

    across: sympy.Symbol
    along: sympy.Symbol
    values: tuple[sympy.Expr, sympy.Expr]
    x: sympy.Expr
    slopes: tuple[sympy.Expr, sympy.Expr]
    kind: CentreKind
    patterns: tuple[str, ...]


@explained()
def organising_centre(map_: PiecewiseLinearMap, across: object, along: object) -> OrganisingCentre:
    """The organising centre of a map of two pieces in the plane of two parameters.

    Parameters
    ----------
    map_, across, along
        A map of two pieces that meet at one break, and two of its parameters by symbol or name. If
        it has others, both limits at the break must be linear in these two.

    Returns
    -------
    OrganisingCentre
        The values of both parameters, the slopes at the break, and the cycles around the centre.

    Raises
    ------
    TypeError, ValueError
        If the map has not two pieces and one break, a name is no parameter or occurs twice, or the
        number of centres at which the assumptions hold is not one.
    UndecidedError
        If the kind depends on parameters about which too little is assumed.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap
    >>> from pwmap.rotations import organising_centre
    >>> jump = PiecewiseLinearMap([("x/2 + r", "x < 1"), ("-x/3 + a", "x >= 1")])
    >>> centre = organising_centre(jump, "r", "a")
    >>> centre.values, centre.slopes, centre.kind.name, centre.patterns
    ((1/2, 4/3), (1/2, -1/3), 'INCREMENTING', ('R L^n',))
    """
    found = organising_centres(map_, across, along)
    if len(found) != 1:
        places = ", ".join(f"({c.values[0]}, {c.values[1]})" for c in found) or "none"
        raise ValueError(
            f"expected one organising centre in ({across}, {along}), got {len(found)}: {places}"
        )
    return found[0]


@explained()
def organising_centres(
    map_: PiecewiseLinearMap, across: object, along: object
) -> tuple[OrganisingCentre, ...]:
    """All organising centres in the plane of two parameters at which the assumptions hold.

    Parameters
    ----------
    map_, across, along
        As for :func:`organising_centre`, with the same errors.

    Returns
    -------
    tuple of OrganisingCentre
        Empty if there is none.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap
    >>> from pwmap.rotations import organising_centres
    >>> jump = PiecewiseLinearMap([("x/2 + r", "x < 1"), ("-x/3 + a", "x >= 1")])
    >>> [(centre.values, centre.kind.name) for centre in organising_centres(jump, "r", "a")]
    [((1/2, 4/3), 'INCREMENTING')]
    """
    layout = two_pieces(map_)
    at = _two_parameters(map_, across, along)
    (k,) = layout.breaks
    equations = [map_.orbits.polynomial(CriticalOrbit(k, (side,), k)) for side in (LEFT, RIGHT)]
    return tuple(
        _centre(map_, at, equations, place)
        for place in _places(map_, at, equations)
        if map_.definition.region.broken(partial(_sign, map_, place=place)) is None
    )


def _two_parameters(map_: PiecewiseLinearMap, across: object, along: object) -> list[int]:
    names = [checked_parameter(name, map_.parameters) for name in (across, along)]
    if names[0] == names[1]:
        raise ValueError(f"expected two different parameters, got {names[0]} twice")
    return [[*map(str, map_.parameters)].index(name) for name in names]


# --- Where ----------------------------------------------------------------------------------------

Place = list[Any]  # the values of all parameters, in a field: of quotients, or of one real root


def _places(map_: PiecewiseLinearMap, at: list[int], equations: list[Number]) -> Iterator[Place]:
    if all(sum(e[i] for i in at) <= 1 for equation in equations for e in equation.monoms()):
        yield from _linear(map_, at, equations)
    elif len(map_.parameters) == 2:
        modulus, coordinates = _univariate(map_, at, equations)
        for root in real_roots(dense(modulus)):
            place: Place = [None, None]
            for k, coordinate in zip(at, coordinates, strict=True):
                place[k] = value_of(dense(coordinate), root)
            yield place
    else:
        own = [map_.parameters[k] for k in at]
        others = ", ".join(str(s) for s in map_.parameters if s not in own)
        raise ValueError(
            f"the limits at the break are not linear in {own[0]} and {own[1]}: "
            f"the other parameters, {others}, must have values (.at)"
        )


def _linear(map_: PiecewiseLinearMap, at: list[int], equations: list[Number]) -> Iterator[Place]:
    """Yield the solution of two linear equations by Cramer's rule; other parameters may occur."""
    (a, b), (c, d) = ([equation.diff(k) for k in at] for equation in equations)
    below = a * d - b * c
    if not below or not map_.scope.sign(below):
        return
    field = below.ring.to_field()
    place = [field.zero if k in at else gen for k, gen in enumerate(field.gens)]
    e, f = (value_at(equation, place) for equation in equations)
    for k, above in zip(at, (b * f - d * e, c * e - a * f), strict=True):
        place[k] = above / field(below)
    yield place


def _sign(map_: PiecewiseLinearMap, polynomial: Number, place: Place) -> int:
    value = value_at(polynomial, place)
    if not isinstance(value, FracElement):
        return sign(value)
    if value.denom.is_ground:
        return map_.scope.sign(value.numer.quo_ground(value.denom.LC))
    return map_.scope.sign(value.numer) * map_.scope.sign(value.denom)


def _shown(value: Any) -> sympy.Expr:
    if isinstance(value, FracElement):
        return fraction_to_sympy((value.numer, value.denom))
    return real_to_sympy(value)


def _univariate(
    map_: PiecewiseLinearMap, at: list[int], equations: list[Number]
) -> tuple[PolyElement, tuple[PolyElement, PolyElement]]:
    """The common zeros: a polynomial f(t), and both parameters as polynomials in its roots t."""
    u, v = (map_.parameters[k] for k in at)
    t = sympy.Dummy("t")
    line = PolyRing((t,), QQ, lex)
    given = [to_sympy(equation) for equation in equations]
    if sympy.gcd(*given).free_symbols:
        raise ValueError(f"both limits lie on the break along a curve in ({u}, {v}), no point")
    # with a squarefree polynomial in each variable an ideal of finitely many zeros is radical, and
    # its Groebner basis has this shape if the values of t at the zeros are distinct
    radical = [*given, _abscissae(given, v, u), _abscissae(given, u, v)]
    for shear in count():  # n zeros have at most n (n - 1) / 2 directions in which two agree
        ideal = [*radical, t - u - shear * v]
        basis = sympy.groebner(ideal, v, u, t, order="lex", domain=QQ)
        if basis.exprs == [1]:  # there are no common zeros
            return line.one, (line.zero, line.zero)
        shape = {
            symbol: polynomial
            for symbol in (u, v)
            for polynomial in basis.polys
            if polynomial.LM(order="lex").as_expr(v, u, t) == symbol
        }
        if len(shape) == 2:
            pair = tuple(line.from_expr(sympy.expand(g - shape[g].as_expr())) for g in (u, v))
            return line.from_expr(basis.exprs[-1]), (pair[0], pair[1])
    raise AssertionError("there are finitely many zeros, which some shear tells apart")


def _abscissae(given: list[sympy.Expr], other: sympy.Symbol, symbol: sympy.Symbol) -> sympy.Expr:
    """The squarefree polynomial in one symbol whose roots are its values at the common zeros."""
    last = sympy.groebner(given, other, symbol, order="lex", domain=QQ).exprs[-1]
    return sympy.sqf_part(last, symbol) if last.free_symbols else last


# --- What is there --------------------------------------------------------------------------------

# by the signs of two slopes in (-1, 1), ascending; ALTERNATING for all others
KINDS: dict[tuple[int, ...], CentreKind] = {
    (1, 1): CentreKind.ADDING,
    (0, 1): CentreKind.SEPARATED,
    (-1, 1): CentreKind.INCREMENTING,
}


def _centre(
    map_: PiecewiseLinearMap, at: list[int], equations: list[Number], place: Place
) -> OrganisingCentre:
    table, (first, second) = map_.definition.table, at
    (a, b), (c, d) = ([one.diff(i) for i in at] for one in equations)
    own = [table.slopes[i] for i in (LEFT, RIGHT)]
    signs = [_sign(map_, slope, place) for slope in own]
    contract = all(
        _sign(map_, table.denominator + side * slope, place) > 0
        for slope in own
        for side in (-1, 1)
    )
    kind = KINDS.get(tuple(sorted(signs)), CentreKind.ALTERNATING)
    if not contract:
        kind = CentreKind.EXPANDING
    if not _sign(map_, a * d - b * c, place):
        kind = CentreKind.DEGENERATE

    def shown(fraction: Fraction_) -> sympy.Expr:
        return _shown(value_at(fraction[0], place) / value_at(fraction[1], place))

    return OrganisingCentre(
        across=map_.parameters[first],
        along=map_.parameters[second],
        values=(_shown(place[first]), _shown(place[second])),
        x=shown((table.breaks[0], table.denominator)),
        slopes=(shown((own[0], table.denominator)), shown((own[1], table.denominator))),
        kind=kind,
        patterns=tuple(_patterns(kind, signs, map_.letters)),
    )


def _patterns(kind: CentreKind, signs: list[int], letters: tuple[str, ...]) -> Iterator[str]:
    """Yield the patterns of words that grow by repeating a letter of positive slope."""
    if kind in KINDS.values():
        for grows, other in ((LEFT, RIGHT), (RIGHT, LEFT)):
            if signs[grows] > 0:
                yield f"{letters[other]} {letters[grows]}^n"
