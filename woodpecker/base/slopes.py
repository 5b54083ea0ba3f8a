"""Derivatives of formulas that have a value wherever the derivative has one."""

from __future__ import annotations

import sympy


def derivative(formula: sympy.Expr, symbol: sympy.Symbol) -> sympy.Expr:
    """A derivative; that of a power b**n is n b**(n - 1) b', also if b is not a symbol alone.

    That of sympy is n b**n b'/b, which is 0/0 where b = 0: of (-x)**(3/2) at x = 0.
    """
    if not formula.has(symbol):
        return sympy.S.Zero
    if formula.is_Add:
        return sympy.Add(*(derivative(each, symbol) for each in formula.args))
    if formula.is_Mul:
        factors = formula.args
        return sympy.Add(
            *(
                sympy.Mul(*factors[:k], derivative(each, symbol), *factors[k + 1 :])
                for k, each in enumerate(factors)
            )
        )
    if formula.is_Pow and not formula.exp.has(symbol):
        base, n = formula.args
        return n * base ** (n - 1) * derivative(base, symbol)
    if formula.is_Function and len(formula.args) == 1:
        inside, own = sympy.Dummy(), formula.args[0]
        outer = sympy.diff(formula.func(inside), inside)
        if not outer.has(sympy.Derivative, sympy.Subs):
            return outer.xreplace({inside: own}) * derivative(own, symbol)
    return sympy.diff(formula, symbol)
