"""Derivatives of formulas, written so that they have a value wherever the derivative exists."""

from __future__ import annotations

import sympy


def derivative(formula: sympy.Expr, symbol: sympy.Symbol) -> sympy.Expr:
    """Derivative of a formula; for a power b**n of any base b it is n b**(n - 1) b'.

    Sympy writes n b**n b'/b, which is 0/0 where b = 0, as for (-x)**(3/2) at x = 0.
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
