"""Organising centres: both one-sided limits at the break of a two-piece map lie on the break.

Near such a point of two parameters, also called a big bang bifurcation [AvrutinSchanz2006], the map
is, with y = x - b, i the height of L(b) over b and j the depth of R(b) under b,

    y -> s y + i (left),    y -> m y - j (right),

and a common factor of y, i and j changes nothing. So cycles live in sectors of the plane that meet
at the centre, infinitely many in the quarter i > 0, j > 0, where no fixed point is.

If both slopes lie in (-1, 1), the signs decide [Granados2017; Avrutin2019]:

- Both positive: rotational cycles, one at a time, of all rotation numbers from 0 to 1. Between the
  sectors of two Farey neighbours is that of their mediant, the periods are added.
- One positive, s on the left say, and one not, m = -t: cycles R L^n, n = 0, 1, 2, ... With h_n =
  (s^-n - 1)/(1 - s) the point -h_n i goes to the break in n steps on the left, so that R L^n exists
  for j/i from h_(n - 1) - t to h_n, and for n = 0, which is a fixed point, up to 0. Adjacent ones
  overlap for t > 0 and coexist there, no others do, as h_(n + 1) - t > h_n; for t = 0 each begins
  where the last one ends. The periods are incremented by one [Avrutin2011].
- None positive, -s and -t: with i > 0, j > 0 all orbits alternate and come to L R. It lives beyond
  this quarter too, beside the fixed point on the right for -t i < j < 0, and beside the one on the
  left for -s j < i < 0. Where i < 0, j < 0 both fixed points live [Hogan2007].
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum
from itertools import count
from typing import NamedTuple

import sympy
from sympy import QQ
from sympy.polys.orderings import lex
from sympy.polys.rings import PolyElement, PolyRing

from pwmap.algebra.arguments import explained
from pwmap.algebra.exact import Fraction_, Number, dense, fraction_to_sympy, to_sympy
from pwmap.algebra.roots import Real, RealRoot, real_roots, sign_at
from pwmap.algebra.terms import checked_parameter
from pwmap.maps.piecewise_linear import PiecewiseLinearMap
from pwmap.maps.words import CriticalOrbit
from pwmap.rotations.pieces import LEFT, RIGHT, TwoPieces, two_pieces


class CentreKind(Enum):
    """What is to be found around an organising centre."""

    ADDING = "period adding: between two neighbours is a cycle with the points of both"
    INCREMENTING = "period incrementing: adjacent cycles of n and n + 1 points coexist"
    SEPARATED = "period incrementing: each cycle of n + 1 points begins where that of n ends"
    ALTERNATING = "fixed points and a cycle of two points"
    EXPANDING = "a slope is not in (-1, 1): the cited results do not apply"
    DEGENERATE = "the two limits do not pass the break independently of one another"


@dataclass(frozen=True, slots=True, kw_only=True)
class OrganisingCentre:
    """A point of two parameters at which both limits at the break lie on the break.

    It comes from :func:`organising_centre`.

    Attributes
    ----------
    values
        Of both parameters at the centre.
    x, slopes
        The break there, and the slopes of the left and the right piece.
    kind
        What lives around the centre, where L(b) > b > R(b).
    patterns
        Words of cycles around it, for :func:`pwmap.word_family`: both families that lead towards
        the fixed points for period adding, the one there is for period incrementing.
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
    map_
        A map of two pieces that meet at one break.
    across, along
        Two of its parameters, symbols or names. If there are others, both limits at the break must
        be linear in these two.

    Returns
    -------
    OrganisingCentre
        Values of both parameters there, the slopes at the break, and what lives around it.

    Raises
    ------
    TypeError, ValueError
        If the map has not two pieces and one break, a name is no parameter of it or comes twice, or
        there is not exactly one centre where the assumptions hold.
    UndecidedError
        If the assumptions on other parameters leave open what is there.

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
    """All organising centres in the plane of two parameters, where the assumptions hold.

    Parameters
    ----------
    map_, across, along
        As for :func:`organising_centre`, whose errors are the same.

    Returns
    -------
    tuple of OrganisingCentre
        None, one or several.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap
    >>> from pwmap.rotations import organising_centres
    >>> jump = PiecewiseLinearMap([("x/2 + r", "x < 1"), ("-x/3 + a", "x >= 1")])
    >>> [(centre.values, centre.kind.name) for centre in organising_centres(jump, "r", "a")]
    [((1/2, 4/3), 'INCREMENTING')]
    """
    pieces = two_pieces(map_)
    symbols = _two_parameters(map_, across, along)
    k = map_.definition.table.layouts[map_.chain[0]].breaks[0]
    equations = [map_.orbits.polynomial(CriticalOrbit(k, (side,), k)) for side in (LEFT, RIGHT)]
    return tuple(
        _centre(pieces, symbols, equations, place)
        for place in _places(map_, symbols, equations)
        if map_.definition.region.broken(place.sign) is None
    )


def _two_parameters(
    map_: PiecewiseLinearMap, across: object, along: object
) -> tuple[sympy.Symbol, sympy.Symbol]:
    own = {str(symbol): symbol for symbol in map_.parameters}
    names = [checked_parameter(name, map_.parameters) for name in (across, along)]
    if names[0] == names[1]:
        raise ValueError(f"expected two different parameters, got {names[0]} twice")
    return own[names[0]], own[names[1]]


# --- Where ----------------------------------------------------------------------------------------


class _PlanePlace(NamedTuple):
    """A point of the plane, and what polynomials and their quotients are there."""

    values: tuple[sympy.Expr, sympy.Expr]
    sign: Callable[[Number], int]
    value: Callable[[Fraction_], sympy.Expr]


def _places(
    map_: PiecewiseLinearMap, symbols: tuple[sympy.Symbol, sympy.Symbol], equations: list[Number]
) -> Iterator[_PlanePlace]:
    at = [map_.parameters.index(symbol) for symbol in symbols]
    if all(sum(e[i] for i in at) <= 1 for equation in equations for e in equation.monoms()):
        yield from _linear(map_, at, equations)
    elif len(map_.parameters) == 2:
        yield from _algebraic(map_, at, equations)
    else:
        others = ", ".join(str(s) for s in map_.parameters if s not in symbols)
        raise ValueError(
            f"the limits at the break are not linear in {symbols[0]} and {symbols[1]}: "
            f"the other parameters, {others}, must have values (.at)"
        )


def _linear(
    map_: PiecewiseLinearMap, at: list[int], equations: list[Number]
) -> Iterator[_PlanePlace]:
    """The one solution of two linear equations, by Cramer's rule; other parameters may occur."""
    rows = [[_coefficient(equation, at, i) for i in (0, 1, None)] for equation in equations]
    (a, b, e), (c, d, f) = rows
    below = a * d - b * c
    if not below:
        return
    sense = map_.scope.sign(below)
    if not sense:
        return
    across, along, below = (sense * part for part in (b * f - d * e, c * e - a * f, below))

    def moved(polynomial: Number, degree: int) -> Number:
        """The polynomial at the place, times a power of the denominator."""
        total = polynomial.ring.zero
        for exponents, coefficient in polynomial.terms():
            i, j = (exponents[k] for k in at)
            rest = tuple(0 if k in at else exponent for k, exponent in enumerate(exponents))
            term = polynomial.ring.from_dict({rest: coefficient})
            total += term * _power(across, i) * _power(along, j) * _power(below, degree - i - j)
        return total

    def degree(polynomial: Number) -> int:
        return max((sum(e[k] for k in at) for e in polynomial.monoms()), default=0)

    def sign(polynomial: Number) -> int:
        return map_.scope.sign(moved(polynomial, degree(polynomial)))

    def value(fraction: Fraction_) -> sympy.Expr:
        common = max(map(degree, fraction))
        top, bottom = (moved(part, common) for part in fraction)
        return fraction_to_sympy((top, bottom))

    values = fraction_to_sympy((across, below)), fraction_to_sympy((along, below))
    yield _PlanePlace(values, sign, value)


def _power(base: Number, exponent: int) -> Number:
    """A power; sympy's rings have none of zero to zero."""
    return base**exponent if exponent else base.ring.one


def _coefficient(polynomial: Number, at: list[int], which: int | None) -> Number:
    """Of one of two parameters in a linear polynomial, or what is left without them."""
    wanted = [int(i == which) for i in (0, 1)]
    terms = {
        tuple(0 if k in at else e for k, e in enumerate(exponents)): coefficient
        for exponents, coefficient in polynomial.terms()
        if [exponents[k] for k in at] == wanted
    }
    return polynomial.ring.from_dict(terms)


def _algebraic(
    map_: PiecewiseLinearMap, at: list[int], equations: list[Number]
) -> Iterator[_PlanePlace]:
    modulus, coordinates = _univariate(map_, at, equations)
    line = modulus.ring

    def moved(polynomial: Number) -> Number:
        """The polynomial as one in the abscissa t."""
        total = line.zero
        for exponents, coefficient in polynomial.terms():
            term = line.ground_new(coefficient)
            for k, coordinate in zip(at, coordinates, strict=True):
                term = (term * _power(coordinate, exponents[k])).rem(modulus)
            total += term
        return total

    for root in real_roots(dense(modulus)):

        def sign(polynomial: Number, root: Real = root) -> int:
            return sign_at(dense(moved(polynomial)), root)

        def value(fraction: Fraction_, root: Real = root) -> sympy.Expr:
            return _quotient(moved(fraction[0]), moved(fraction[1]), root)

        across, along = (_quotient(coordinate, line.one, root) for coordinate in coordinates)
        yield _PlanePlace((across, along), sign, value)


def _univariate(
    map_: PiecewiseLinearMap, at: list[int], equations: list[Number]
) -> tuple[PolyElement, tuple[PolyElement, PolyElement]]:
    """A polynomial f(t) and both parameters as polynomials in t, at all common zeros."""
    u, v = (map_.parameters[k] for k in at)
    t = sympy.Dummy("t")
    line = PolyRing((t,), QQ, lex)
    given = [to_sympy(equation) for equation in equations]
    if sympy.gcd(*given).free_symbols:
        raise ValueError(f"both limits lie on the break along a curve in ({u}, {v}), no point")
    # polynomials without multiple roots in each variable make an ideal with finitely many zeros
    # radical, whose Groebner basis has this shape if t tells them apart
    radical = [*given, _abscissae(given, v, u), _abscissae(given, u, v)]
    for shear in count():  # n points have at most n (n - 1) / 2 directions in which two are one
        ideal = [*radical, t - u - shear * v]
        basis = sympy.groebner(ideal, v, u, t, order="lex", domain=QQ)
        if basis.exprs == [1]:  # there are no common zeros
            return line.one, (line.zero, line.zero)
        shape = {
            symbol: polynomial
            for symbol in (u, v)
            for polynomial in basis.polys
            if polynomial.LM(order="lex").exponents == _unit(symbol, (v, u, t))
        }
        if len(shape) == 2:
            pair = tuple(line.from_expr(sympy.expand(g - shape[g].as_expr())) for g in (u, v))
            return line.from_expr(basis.exprs[-1]), (pair[0], pair[1])
    raise AssertionError("there are finitely many zeros, which some shear tells apart")


def _abscissae(given: list[sympy.Expr], other: sympy.Symbol, symbol: sympy.Symbol) -> sympy.Expr:
    """A polynomial in one symbol without multiple roots, which are those of all common zeros."""
    last = sympy.groebner(given, other, symbol, order="lex", domain=QQ).exprs[-1]
    return sympy.sqf_part(last, symbol) if last.free_symbols else last


def _unit(symbol: sympy.Symbol, symbols: tuple[sympy.Symbol, ...]) -> tuple[int, ...]:
    return tuple(int(symbol == other) for other in symbols)


def _quotient(top: PolyElement, bottom: PolyElement, root: Real) -> sympy.Expr:
    if isinstance(root, RealRoot):
        return root.element_to_sympy(root.quotient(dense(top), dense(bottom)))
    return QQ.to_sympy(QQ.convert(top.evaluate(0, root)) / QQ.convert(bottom.evaluate(0, root)))


# --- What is there --------------------------------------------------------------------------------


def _centre(
    pieces: TwoPieces,
    symbols: tuple[sympy.Symbol, sympy.Symbol],
    equations: list[Number],
    place: _PlanePlace,
) -> OrganisingCentre:
    table, letters = pieces.map_.definition.table, pieces.map_.letters
    first, second = (pieces.map_.parameters.index(symbol) for symbol in symbols)
    (a, b), (c, d) = ([one.diff(i) for i in (first, second)] for one in equations)
    own = [table.slopes[i] for i in (LEFT, RIGHT)]
    signs = [place.sign(slope) for slope in own]
    contract = [_contracts(place, slope, table.denominator) for slope in own]
    kind = _kind(signs) if all(contract) else CentreKind.EXPANDING
    if not place.sign(a * d - b * c):
        kind = CentreKind.DEGENERATE
    slopes = [place.value((slope, table.denominator)) for slope in own]
    return OrganisingCentre(
        across=symbols[0],
        along=symbols[1],
        values=place.values,
        x=place.value(pieces.at),
        slopes=(slopes[0], slopes[1]),
        kind=kind,
        patterns=tuple(_patterns(kind, signs, letters)),
    )


def _contracts(place: _PlanePlace, slope: Number, denominator: Number) -> bool:
    return place.sign(denominator - slope) > 0 and place.sign(denominator + slope) > 0


def _kind(signs: list[int]) -> CentreKind:
    """What follows from the signs of slopes in (-1, 1); see the docstring of this file."""
    match sorted(signs):
        case [1, 1]:
            return CentreKind.ADDING
        case [0, 1]:
            return CentreKind.SEPARATED
        case [-1, 1]:
            return CentreKind.INCREMENTING
        case _:
            return CentreKind.ALTERNATING


def _patterns(kind: CentreKind, signs: list[int], letters: tuple[str, ...]) -> Iterator[str]:
    """The words that grow: those in which a letter of positive slope is repeated."""
    if kind in (CentreKind.ADDING, CentreKind.INCREMENTING, CentreKind.SEPARATED):
        for grows, other in ((LEFT, RIGHT), (RIGHT, LEFT)):
            if signs[grows] > 0:
                yield f"{letters[other]} {letters[grows]}^n"
