"""From text to a tree by a grammar; the text is never evaluated.

The operators, from the loosest to the tightest::

    or   and   not   < <= > >= (also in chains)   |   &   + -   * /   unary + - ~   **

and parentheses, integers, names, True, False, and calls of the functions in ``FUNCTIONS``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from math import inf

import sympy
from sympy import QQ

from pwmap.algebra.arguments import shortened, shown
from pwmap.algebra.terms import (
    INEQUALITIES,
    MAX_DEPTH,
    MAX_DIGITS,
    MAX_TERMS,
    Operation,
    Term,
    float_refusal,
    plain_name,
    term_of_number,
    term_of_sympy,
)

MAX_LENGTH = 400_000  # characters of a text, which bounds the time to read it
MAX_NAME = 100  # characters of a name

_TOKEN = re.compile(
    r"(?P<space>\s+)"
    r"|(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"
    r"|(?P<name>[^\W\d]\w*)"
    r"|(?P<sign>\*\*|<=|>=|==|!=|<>|:=|//|[-+*/<>&|~(),=^])"
    r"|(?P<end>\Z)|(?P<other>.)"
)
_CONSTANTS = {"nan", "NaN", "oo", "zoo", "inf", "Inf", "infinity", "Infinity", "I", "pi", "E"}
_RELATIONS = {each.value: each for each in INEQUALITIES}
_LEVELS = {"or": 1, "and": 2, **dict.fromkeys(_RELATIONS, 4), "|": 5, "&": 6}
_LEVELS |= {"+": 7, "-": 7, "*": 8, "/": 8}
_NOT, _UNARY = 3, 9


# the operation of each function, and its least and largest number of arguments
FUNCTIONS: dict[str, tuple[Operation, int, float]] = {
    "Abs": (Operation.ABS, 1, 1),
    "Max": (Operation.MAX, 1, inf),
    "Min": (Operation.MIN, 1, inf),
    "And": (Operation.AND, 0, inf),
    "Or": (Operation.OR, 0, inf),
    "Not": (Operation.NOT, 1, 1),
    "Eq": (Operation.EQUAL, 2, 2),
    "Ne": (Operation.UNEQUAL, 2, 2),
    "Lt": (Operation.LESS, 2, 2),
    "Le": (Operation.LESS_EQUAL, 2, 2),
    "Gt": (Operation.GREATER, 2, 2),
    "Ge": (Operation.GREATER_EQUAL, 2, 2),
    "Piecewise": (Operation.PIECEWISE, 1, inf),
    "Rational": (Operation.PRODUCT, 1, 2),
    "Integer": (Operation.PRODUCT, 1, 1),
}
FUNCTIONS |= {name.lower(): FUNCTIONS[name] for name in ("Abs", "Max", "Min")}  # also as in Python


def term_of(value: object, symbols: Sequence[sympy.Symbol] = ()) -> Term:
    """Text, a number, a sympy expression or a tree as a tree; text names the ``symbols``.

    TypeError if a float occurs; ValueError if the text is no expression, or too long.
    """
    if isinstance(value, str):
        return _Parser(value, {plain_name(symbol): symbol for symbol in symbols}).parsed()
    if isinstance(value, Term):
        return value
    number = term_of_number(value)
    if number is not None:
        return number
    if isinstance(value, sympy.Basic):
        return term_of_sympy(value)
    raise ValueError(f"expected text, a number or a sympy expression, got {shown(value)}")


def checked_name(text: str) -> str:
    """A name in normal form; ValueError if no variable or parameter may have it."""
    name = plain_name(text)
    if not (text.isidentifier() and name.isidentifier()):
        raise ValueError(f"{shown(text)} is no name")
    if len(name) > MAX_NAME:
        raise ValueError(f"a name has at most {MAX_NAME} characters, got {shown(text)}")
    check_meaning(name)
    return name


def check_meaning(name: str) -> None:
    """ValueError if a name, also one of a symbol, has another meaning in text."""
    if name in _CONSTANTS or name in ("None", "True", "False") or name in FUNCTIONS:
        raise ValueError(f"{name} cannot be the name of a variable or parameter")


class _Parser:
    """A parser that reads a text from left to right, by the precedence of its operators."""

    def __init__(self, text: str, known: Mapping[str, sympy.Symbol]) -> None:
        self._text = text
        self._known = dict(known)
        self._tokens = self._split()
        self._at = 0
        self._depth = 0

    def parsed(self) -> Term:
        term = self._parse(0)
        if self._next.lastgroup != "end":
            raise self._unexpected()
        return term

    # --- Tokens ---------------------------------------------------------------------------------

    def _split(self) -> list[re.Match[str]]:
        """The tokens of the text: numbers, names and signs, and the end."""
        text, tokens = self._text, list[re.Match[str]]()
        if len(text) > MAX_LENGTH:
            raise self._refusal(f"it has {len(text)} characters, more than {MAX_LENGTH}")
        for match in _TOKEN.finditer(text):
            if match["other"]:
                raise self._refusal(f"{match[0]!r} has no meaning in a formula")
            if match["space"]:
                continue
            if len(tokens) == MAX_TERMS and match[0]:
                raise self._refusal(f"it has more than {MAX_TERMS} numbers, names and signs")
            tokens.append(match)
        return tokens

    @property
    def _next(self) -> re.Match[str]:
        return self._tokens[self._at]

    def _take(self, *signs: str) -> bool:
        if self._next[0] in signs:
            self._at += 1
            return True
        return False

    def _refusal(self, reason: str) -> ValueError:
        return ValueError(f"cannot read {shown(self._text)} as an expression: {reason}")

    def _unexpected(self) -> ValueError:
        token = self._next
        if token[0] in ("=", "==", "!=", "<>"):
            return ValueError(
                f"write Eq(x, 0) or Ne(x, 0) for equality and its opposite, got {shown(self._text)}"
            )
        if token[0] == "^":
            return self._refusal("write ** for a power, not ^")
        if token.lastgroup == "end":
            return self._refusal("it ends too early")
        before = self._tokens[self._at - 1][0] if self._at else ""
        place = f" after {shortened(before, 40)!r}" if before else ""
        is_decimal = re.fullmatch(r"\d,\d", self._text[max(0, token.start() - 1) :][:3])
        more = ": a decimal has a point, as in 0.5" if is_decimal else ""
        return self._refusal(f"unexpected {shortened(token[0], 40)!r}{place}{more}")

    def _term(self, operation: Operation, arguments: Sequence[Term], start: int) -> Term:
        source = self._text[start : self._tokens[self._at - 1].end()]
        return Term(operation, tuple(arguments), source=source)

    # --- The grammar ----------------------------------------------------------------------------

    def _parse(self, level: int) -> Term:
        """An expression whose operators, outside of parentheses, are of this level or tighter."""
        self._deeper()
        start = self._next.start()
        left = self._unary(level)
        while (found := _LEVELS.get(self._next[0], -1)) >= level:
            left = self._chain(left, found, start)
        self._depth -= 1
        return left

    def _deeper(self) -> None:
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise self._refusal(f"it is nested more than {MAX_DEPTH} deep")

    def _chain(self, left: Term, level: int, start: int) -> Term:
        """Operands joined by operators of one level; chained comparisons must all hold."""
        operands, signs = [left], list[str]()
        while _LEVELS.get(self._next[0]) == level:
            signs.append(self._next[0])
            self._at += 1
            operands.append(self._parse(level + 1))
        inverse = {"-": Operation.NEGATIVE, "/": Operation.INVERSE}
        operands[1:] = [
            Term(inverse[sign], (operand,), source=operand.source) if sign in inverse else operand
            for sign, operand in zip(signs, operands[1:], strict=True)
        ]
        joined = {7: Operation.SUM, 8: Operation.PRODUCT, 5: Operation.OR, 1: Operation.OR}
        whole = self._term(joined.get(level, Operation.AND), operands, start)
        if signs[0] not in _RELATIONS:
            return whole
        parts = tuple(
            replace(whole, operation=_RELATIONS[sign], arguments=pair)
            for sign, pair in zip(signs, pairwise(operands), strict=True)
        )
        return parts[0] if len(parts) == 1 else replace(whole, arguments=parts)

    def _unary(self, level: int) -> Term:
        for signs, operation in ((("+", "-"), Operation.NEGATIVE), (("~",), Operation.NOT)):
            if self._next[0] in signs:
                return self._signed(signs, operation, partial(self._unary, _UNARY))
        if self._next[0] == "not" and level <= _NOT:
            return self._signed(("not",), Operation.NOT, partial(self._parse, _NOT + 1))
        return self._power()

    def _signed(
        self, signs: tuple[str, ...], operation: Operation, operand: Callable[[], Term]
    ) -> Term:
        """An operand after any number of the given signs."""
        start, odd = self._next.start(), False
        while self._take(*signs):
            odd ^= self._tokens[self._at - 1][0] != "+"
        self._deeper()
        term = operand()
        self._depth -= 1
        return self._term(operation, [term], start) if odd else term

    def _power(self) -> Term:
        start = self._next.start()
        base = self._atom()
        if not self._take("**"):
            return base
        self._deeper()
        exponent = self._unary(_UNARY)
        self._depth -= 1
        return self._term(Operation.POWER, [base, exponent], start)

    def _atom(self) -> Term:
        token = self._next
        if token.lastgroup == "number":
            return self._number(token)
        if token.lastgroup == "name" and token[0] not in ("and", "or", "not"):
            self._at += 1
            return self._call(token) if self._take("(") else self._name(token)
        if self._take("("):
            return self._bracket(token)
        raise self._unexpected()

    def _number(self, token: re.Match[str]) -> Term:
        if not token[0].isdigit():
            raise float_refusal(token[0])
        if len(token[0]) > MAX_DIGITS:
            raise self._refusal(f"an integer of {len(token[0])} digits is longer than {MAX_DIGITS}")
        self._at += 1
        return Term(Operation.NUMBER, value=QQ(int(token[0])), source=token[0])

    def _bracket(self, opening: re.Match[str]) -> Term:
        inner = self._parse(0)
        if not self._take(","):
            self._close()
            return inner
        pair = [inner, self._parse(0)]
        self._take(",")
        self._close()
        return self._term(Operation.PAIR, pair, opening.start())

    def _close(self) -> None:
        if not self._take(")"):
            raise self._unexpected()

    def _name(self, token: re.Match[str]) -> Term:
        if token[0] in ("True", "False"):
            return Term(Operation.TRUTH, value=token[0] == "True", source=token[0])
        name = plain_name(token[0])
        if name not in self._known:
            try:
                self._known[name] = sympy.Symbol(checked_name(token[0]))
            except ValueError as error:
                raise self._refusal(str(error)) from None
        return Term(Operation.NAME, value=self._known[name], source=token[0])

    def _call(self, name: re.Match[str]) -> Term:
        """A call of a function; its opening parenthesis has been read."""
        arguments = list[Term]()
        while not self._take(")"):
            arguments.append(self._parse(0))
            if not self._take(",") and self._next[0] != ")":
                raise self._unexpected()
        function = FUNCTIONS.get(name[0])
        if function is None:
            call = self._term(Operation.NAME, arguments, name.start())
            raise self._refusal(
                "a formula must be polynomial in the parameters over the rationals, "
                f"got {shortened(str(call), 50)}; its functions are {', '.join(FUNCTIONS)}"
            )
        operation, least, most = function
        if not least <= len(arguments) <= most:
            raise self._refusal(f"{name[0]} cannot have {len(arguments)} arguments")
        if name[0] == "Piecewise" and {a.operation for a in arguments} != {Operation.PAIR}:
            raise self._refusal("Piecewise is made of pairs (formula, condition)")
        if name[0] in ("Rational", "Integer"):
            arguments = self._quotient(name[0], arguments)
        return self._term(operation, arguments, name.start())

    def _quotient(self, name: str, arguments: Sequence[Term]) -> list[Term]:
        numbers = {Operation.NUMBER, Operation.NEGATIVE}
        for argument in arguments:
            if name == "Integer" or len(arguments) > 1:
                whole = all(part.operation in numbers for part in argument.walk())
            else:
                whole = not argument.names()
            if not whole:
                raise self._refusal(f"{name} is made of integers, got {argument}")
        first, *rest = arguments
        return [first, *(Term(Operation.INVERSE, (a,), source=a.source) for a in rest)]
