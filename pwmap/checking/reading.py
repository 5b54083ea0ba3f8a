"""Readers of a certificate's content, which refuse any that has not the expected form."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from fractions import Fraction
from itertools import chain, groupby
from math import lcm
from typing import Any

from pwmap.checking.iterates import Map
from pwmap.checking.polynomials import (
    Number,
    Poly,
    Quotient,
    multiplying,
    query,
    sign_near,
    text,
    trimmed,
)
from pwmap.checking.refusing import (
    BITS,
    DIGITS,
    LETTERS,
    MAX_COEFFICIENTS,
    STEP,
    TERMS,
    Effort,
    brief,
    refuse,
)


def fields(value: object, *names: str) -> list[Any]:
    """The values of an object that has exactly the given names."""
    if not isinstance(value, dict) or set(value) != set(names):
        got = sorted(value) if isinstance(value, dict) else value
        refuse(f"an object with the names {', '.join(names)} was expected, got {shown(got)}")
    return [value[name] for name in names]


def shown(value: object) -> str:
    """A value for a refusal, cut if it is long."""
    return brief(canonical(value), DIGITS)


def canonical(value: object) -> str:
    """The canonical JSON text of a value."""
    try:
        return json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=True)
    except (TypeError, ValueError, RecursionError) as error:
        refuse(f"this is no JSON: {error}")


def listed(value: object, most: int) -> list[Any]:
    """A list of at most ``most`` entries."""
    if not isinstance(value, list) or len(value) > most:
        refuse(f"a list of at most {most} entries was expected, got {shown(value)}")
    return value


def whole(value: object, low: int, high: int) -> int:
    """An integer from ``low`` to ``high``."""
    if type(value) is not int or not low <= value <= high:
        refuse(f"an integer from {low} to {high} was expected, got {shown(value)}")
    return value


def rational(value: object) -> Fraction:
    """The number in a text that is a rational in lowest terms."""
    if not isinstance(value, str) or len(value) > DIGITS:
        refuse(f"a number of at most {DIGITS} characters was expected, got {shown(value)}")
    if not re.fullmatch("-?[0-9]+(/[1-9][0-9]*)?", value) or str(Fraction(value)) != value:
        refuse(f"a rational number in lowest terms was expected, got {shown(value)}")
    return Fraction(value)


def coefficients(value: object, most: int = TERMS) -> list[Fraction]:
    """The coefficients of a polynomial, lowest degree first, the last one not zero."""
    found = [rational(each) for each in listed(value, most)]
    if found and not found[-1]:
        refuse(f"the last coefficient of a polynomial must not be zero, got {shown(value)}")
    return found


def over_common_denominator(
    work: Effort, parts: Sequence[Sequence[Fraction]]
) -> tuple[list[Poly], int]:
    """Polynomials, multiplied by the common denominator of their coefficients, and that."""
    unit = 1
    for c in chain.from_iterable(parts):
        work.spend(STEP + 4 * multiplying(unit.bit_length(), c.denominator.bit_length()))
        unit = lcm(unit, c.denominator)
        if unit.bit_length() > BITS:
            refuse("the common denominator of some numbers is too large")
    found = []
    for part in parts:
        work.spend(STEP + len(part) * 4 * multiplying(unit.bit_length(), 4 * DIGITS))
        found.append(trimmed([int(c * unit) for c in part]))
        work.keep(found[-1])
    return found, unit


def quotient(value: object, work: Effort) -> Quotient:
    """A quotient of two polynomials, with integer coefficients."""
    top, bottom = over_common_denominator(
        work, [coefficients(part, MAX_COEFFICIENTS) for part in pair(value)]
    )[0]
    if not bottom:
        refuse("the denominator of a quotient must not be zero")
    return top, bottom


def pair(value: object) -> list[Any]:
    """A list of two entries."""
    found = listed(value, 2)
    if len(found) != 2:
        refuse(f"two entries were expected, got {shown(value)}")
    return found


def number(value: object, work: Effort) -> Number:
    """A rational number, or the only root of a polynomial in an open interval."""
    if isinstance(value, str):
        x = rational(value)
        return Number((), x, x)
    polynomial, interval = fields(value, "polynomial", "interval")
    (poly,), unit = over_common_denominator(work, [coefficients(polynomial, MAX_COEFFICIENTS)])
    low, high = map(rational, pair(interval))
    if unit != 1 or len(poly) < 2 or not low < high:
        refuse(f"an integer polynomial and an interval were expected, got {shown(value)}")
    signs = sign_near(work, poly, low) * sign_near(work, poly, high)
    # as the sign changes, that of the polynomial tells on which side of the root a number lies
    if signs >= 0 or query(work, poly, (1,), low, high) != 1:
        what = f"{brief(text(poly, 't'))} does not change its sign at just one root"
        refuse(f"{what} between {brief(str(low))} and {brief(str(high))}")
    return Number(poly, low, high)


NAME = re.compile(r"[^\W\d]\w{0,39}")


def read_map(value: object, work: Effort, *, parametric: bool) -> tuple[Map, str, str]:
    """A map, the name of its parameter (empty if it has none), and the map as text."""
    names = ("variable", "parameter", "slots", "pieces", "breaks", "denominator")
    x, p, slots, pieces, breaks, unit = fields(value, *names)
    for name in (x, p)[: 1 + parametric]:
        if not isinstance(name, str) or not NAME.fullmatch(name):
            refuse(f"the name of a variable was expected, got {shown(name)}")
    if (p is not None) is not parametric or x == p:
        refuse(f"a map {'with a' if parametric else 'without a'} parameter was expected")
    letters = read_slots(slots, len(listed(breaks, LETTERS)))
    lines = [fields(each, "slope", "intercept") for each in fields(pieces, *letters)]
    numbers = [*(each for line in lines for each in line), *breaks, unit]
    parts = [coefficients(each if parametric else [each] * (each != "0")) for each in numbers]
    if not parts[-1]:
        refuse("the denominator of a map must not be zero")
    tops, n = over_common_denominator(work, parts)[0], 2 * len(letters)
    slopes, intercepts = (dict(zip(letters, tops[i:n:2], strict=True)) for i in (0, 1))
    map_ = Map(slots, slopes, intercepts, tuple(tops[n:-1]), tops[-1], work)
    return map_, p or "", map_text(map_, parts, x, p or "")


def read_slots(slots: object, breaks: int) -> str:
    """The letters of the slots from left to right, each once."""
    if not isinstance(slots, str) or len(slots) != 2 * breaks + 1:
        refuse(f"one letter for each break and each interval was expected, got {shown(slots)}")
    letters = "".join(letter for letter, _ in groupby(slots))
    if len(set(letters)) < len(letters) or not letters.isprintable() or set(letters) & set(" |"):
        refuse(f"each letter must name one piece of the line, got {shown(slots)}")
    if any(len(set(slots[2 * k : 2 * k + 3])) == 1 for k in range(breaks)):
        refuse(f"pieces must change at each break, got {shown(slots)}")
    return letters


def map_text(map_: Map, parts: Sequence[Sequence[Fraction]], x: str, p: str) -> str:
    """The pieces of a map in words."""
    below = "" if list(parts[-1]) == [1] else f" / ({text(parts[-1], p)})"
    texts = [f"({t})" if " " in t[1:] else t for t in (text(part, p) for part in parts)]
    breaks = [b + below for b in texts[2 * len(map_.slopes) : -1]]
    pieces = []
    for i, letter in enumerate(map_.slopes):
        first, last = map_.slots.index(letter), map_.slots.rindex(letter)
        lower = f"{breaks[(first - 1) // 2]} {'<=' if first % 2 else '<'} " if first else ""
        inner = last + 1 < len(map_.slots)
        upper = f" {'<=' if last % 2 else '<'} {breaks[last // 2]}" if inner else ""
        is_point = first == last and first % 2
        where = f"{x} = {breaks[first // 2]}" if is_point else lower + x + upper
        where = f"all {x}" if where == x else where
        terms = [f"{texts[2 * i]} {x}"] * (texts[2 * i] != "0") + [texts[2 * i + 1]]
        line = " + ".join(terms[: 1 if terms[-1] == "0" else 2])
        pieces.append(f"{letter}: {f'({line}){below}' if below else line} for {where}")
    return "the map with the pieces " + "; ".join(pieces)
