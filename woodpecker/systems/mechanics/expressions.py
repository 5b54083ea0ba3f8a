"""Expressions of sympy: whether one is zero everywhere, and where it has kinks.

Gaps, slips and masses must be smooth. Forces may have kinks, as that of a spring with backlash has,
but no jumps: at a kink of a force the derivatives of the motion agree on both sides, and a step of
the integrator only has to end there.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import mpmath
import sympy
from sympy.core.function import AppliedUndef
from sympy.core.relational import Relational

from woodpecker.base.shown import shown

CLOSINGS = 50  # Newton steps to where gaps are zero: from most random points ten are enough
POINTS = 4  # random points, each with two signs, at which an expression is tested for zero
DIGITS = 60  # of the values there: 20 more than EXACT needs, for what cancels within terms
EXACT = 1e-40  # relative to its terms: below this an expression of exact numbers is zero
ROUNDED = 2.0**-46  # the same with floats: each has the rounding of a double
BESIDE = 1e-25  # distance from an edge at which both sides of it are compared
JUMP = 1e-12  # relative: a smaller difference is no jump
ROOT_DECAY = 0.9  # a difference that falls below this part nearer to the edge is that of a root
KINKED = (
    sympy.Abs, sympy.sign, sympy.Heaviside, sympy.Max, sympy.Min, sympy.Piecewise
)  # fmt: skip
STEPS = (sympy.floor, sympy.ceiling, sympy.frac, sympy.Mod, sympy.DiracDelta)
SMOOTH = (
    sympy.sin, sympy.cos, sympy.tan, sympy.asin, sympy.acos, sympy.atan, sympy.atan2, sympy.sinh,
    sympy.cosh, sympy.tanh, sympy.asinh, sympy.acosh, sympy.atanh, sympy.exp, sympy.log, sympy.erf,
    sympy.erfc,
)  # fmt: skip
RECIPROCALS = {  # such as sec of cos
    sympy.sec: sympy.cos, sympy.csc: sympy.sin, sympy.cot: sympy.tan, sympy.sech: sympy.cosh,
    sympy.csch: sympy.sinh, sympy.coth: sympy.tanh,
}  # fmt: skip
KNOWN = (
    sympy.Symbol, sympy.Number, sympy.NumberSymbol, sympy.Add, sympy.Mul, sympy.Pow, *SMOOTH,
    *KINKED, *STEPS,
)  # fmt: skip
DYNAMIC = (AppliedUndef, sympy.Derivative)  # symbols of sympy.physics.mechanics, and their rates


def expression(name: str, value: Any) -> sympy.Expr:
    """A value as an expression of sympy with real symbols; TypeError unless it is one.

    ValueError if it has a function that is not supported, dynamic symbols apart.
    """
    try:
        found = sympy.sympify(value, strict=not isinstance(value, str))
    except (sympy.SympifyError, SyntaxError, TypeError):
        found = None
    if not isinstance(found, sympy.Expr):
        raise TypeError(f"{name} must be an expression of sympy or a number, got {shown(value)}")
    if found.has(sympy.nan, sympy.oo, sympy.zoo):
        raise ValueError(f"{name} must be finite, got {found}")
    if found.has(sympy.I):
        raise ValueError(f"{name} must be real, got {found}")
    for function, other in RECIPROCALS.items():
        found = found.replace(function, lambda a, other=other: 1 / other(a))
    found = _of_reals(found)
    check_known(name, found, DYNAMIC)
    return found


def check_known(name: str, value: sympy.Expr, others: tuple[type, ...] = ()) -> None:
    """ValueError if an expression has a function that is neither supported nor in ``others``."""
    for each in sympy.preorder_traversal(value):
        if isinstance(each, sympy.Expr) and not isinstance(each, (*KNOWN, *others)):
            functions = ", ".join(f.__name__ for f in (*SMOOTH, *RECIPROCALS, *KINKED))
            known = f"there may be powers, and the functions {functions}"
            may = "from_kane takes dynamic symbols" if isinstance(each, DYNAMIC) else known
            raise ValueError(f"{name} has {each}, and {each.func.__name__} is not supported: {may}")


def _of_reals(
    value: sympy.Expr, changed: Callable[[sympy.Expr], sympy.Expr] = lambda each: each
) -> sympy.Expr:
    """Apply ``changed`` to an expression of real symbols: roots of squares are absolute values."""
    real = {s: sympy.Dummy(real=True) for s in value.free_symbols if s.is_real is None}
    found: sympy.Expr = changed(value.xreplace(real)).xreplace({d: s for s, d in real.items()})
    return found


def are_equal(
    one: sympy.Expr, other: sympy.Expr, gaps: Sequence[sympy.Expr] = (),
    q: Sequence[sympy.Symbol] = (),
) -> bool:  # fmt: skip
    """Whether two expressions are the same function, however they are written.

    With gaps of coordinates q, whether they are where all of these are zero. Their difference is
    evaluated at random points, with many digits. A polynomial of degree d that is not zero vanishes
    at one with a probability of at most d / 2^40 [Schwartz1980], an analytic function with
    probability 0. Symbols take both signs unless they are known to be positive. Floats are equal up
    to their rounding.
    """
    if one == other:
        return True
    terms = [*sympy.Add.make_args(sympy.expand(one)), *sympy.Add.make_args(sympy.expand(-other))]
    found = one.free_symbols.union(other.free_symbols, *(gap.free_symbols for gap in gaps))
    symbols = sorted(found, key=str)
    tried = sympy.lambdify(symbols, terms, modules="mpmath")
    small = ROUNDED if one.has(sympy.Float) or other.has(sympy.Float) else EXACT
    seen = False
    with mpmath.workdps(DIGITS):
        for point in _points(symbols):
            try:
                if gaps:
                    point = _closed(point, symbols, gaps, q)
                found = [mpmath.mpmathify(each) for each in tried(*point)]
            except (ArithmeticError, NameError, TypeError, ValueError):
                continue  # they have no value there
            if not abs(mpmath.fsum(found)) <= small * mpmath.fsum(found, absolute=True):
                return False
            seen = True
    return seen


def _closed(
    point: Sequence[Any], symbols: Sequence[sympy.Symbol], gaps: Sequence[sympy.Expr],
    q: Sequence[sympy.Symbol],
) -> list[Any]:  # fmt: skip
    """A point near another at which gaps are zero, by Newton's method; ValueError if none is."""
    found, moved = mpmath.matrix(point), [symbols.index(each) for each in q if each in symbols]
    rows = [[gap, *(gap.diff(symbols[k]) for k in moved)] for gap in gaps]
    tried = sympy.lambdify(symbols, rows, modules="mpmath")
    for _ in range(CLOSINGS):
        values = mpmath.matrix(tried(*found))
        turn = values[:, 1:]
        step = turn.T * mpmath.lu_solve(turn * turn.T, values[:, 0])
        for k, change in zip(moved, step, strict=True):
            found[k] -= change
        if mpmath.norm(step) < EXACT:
            return list(found)
    raise ValueError(f"no point was found at which {gaps} are zero")


def vanishes(value: sympy.Expr) -> bool:
    """Whether an expression is zero everywhere."""
    return are_equal(value, sympy.Integer(0))


def _points(symbols: Sequence[sympy.Symbol]) -> Iterable[list[mpmath.mpf]]:
    """Random points, always the same, with coordinates of size 1/2 to 1; each with both signs."""
    rng = random.Random(1980)
    for _ in range(POINTS):
        drawn = [mpmath.mpf(2**40 + rng.randrange(2**40)) / 2**41 for _ in symbols]
        signs = [rng.choice((1, -1)) for _ in symbols]
        for side in (1, -1):
            yield [
                each if symbol.is_positive else side * sign * each
                for symbol, sign, each in zip(symbols, signs, drawn, strict=True)
            ]


# --- Kinks ----------------------------------------------------------------------------------------


def smooth(name: str, value: Any) -> sympy.Expr:
    """An expression without kinks; ValueError if it has one."""
    found = expression(name, value)
    for each in sorted(found.atoms(*KINKED, *STEPS), key=str):
        raise ValueError(
            f"{name} has {each}, but only forces may have kinks: a gap with a kink is two contacts"
        )
    return found


def continuous(
    name: str, value: sympy.Expr, parameters: Mapping[sympy.Symbol, float]
) -> sympy.Expr:
    """A force, its kinks written as cases of ``Piecewise``; ValueError if it jumps."""
    if not value.has(*KINKED, *STEPS):
        return value
    found = by_cases(value)
    exact = {symbol: sympy.Rational(number) for symbol, number in parameters.items()}
    held = found.subs(exact)
    jumps = [f"where {each} = 0" for each in edges([found]) if _jumps(held, each.subs(exact))]
    if jumps or found.has(*STEPS):
        raise ValueError(
            f"{name} must be continuous, but {value} jumps {jumps[0] if jumps else 'in steps'}: "
            "dry friction is mu and slip of a contact, a stop is a contact, and any other jump "
            "needs a continuous transition"
        )
    return found


def by_cases(value: sympy.Expr) -> sympy.Expr:
    """An expression, its kinks written as cases of ``Piecewise``, whose derivatives are known."""
    return _of_reals(value, lambda each: each.rewrite(KINKED, sympy.Piecewise))


def edges(values: Iterable[sympy.Expr]) -> list[sympy.Expr]:
    """The expressions that vanish where some values change from one case to another."""
    found = {each.lhs - each.rhs for value in values for each in value.atoms(Relational)}
    return sorted(found, key=str)


def _jumps(value: sympy.Expr, edge: sympy.Expr) -> bool:
    """Whether the limits of an expression on both sides of an edge differ, at random points."""
    symbols = sorted(value.free_symbols | edge.free_symbols, key=str)
    tried, side = (sympy.lambdify([symbols], each, modules="mpmath") for each in (value, edge))
    with mpmath.workdps(DIGITS):
        for point in _points(symbols):
            for k in (symbols.index(each) for each in edge.free_symbols):

                def at(s: Any, k: int = k, point: Sequence[Any] = point) -> list[Any]:
                    return [*point[:k], s, *point[k + 1 :]]

                try:
                    root = mpmath.findroot(lambda s, at=at: side(at(s)), point[k])
                    near, less = (
                        abs(tried(at(root + away)) - tried(at(root - away)))
                        for away in (BESIDE, BESIDE**1.5)
                    )
                    size = max(abs(tried(at(root + BESIDE))), abs(tried(point)))
                except (ArithmeticError, TypeError, ValueError):
                    continue  # no edge is near
                if near > JUMP * size and less > ROOT_DECAY * near:
                    return True
    return False
