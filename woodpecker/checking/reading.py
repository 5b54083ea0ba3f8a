"""Numbers and intervals of certificates, read from their text."""

from __future__ import annotations

import re
from fractions import Fraction
from typing import Any

from pwmap.checking import Refused
from pwmap.checking.refusing import DIGITS

NUMBER = re.compile(r"-?[0-9]+(\.[0-9]+)?(/(?!0+$)[0-9]+)?")  # no n/0
Interval = tuple[Fraction, Fraction]


def number(text: Any) -> Fraction:
    """The rational number that a text denotes; Refused if it denotes none."""
    if not isinstance(text, str) or len(text) > DIGITS or not NUMBER.fullmatch(text):
        most = f"of at most {DIGITS} characters"
        raise Refused(f"a number must be text {most} such as -0.25 or 1/3, got {text!a:.60}")
    top, _, bottom = text.partition("/")
    return Fraction(top) / Fraction(bottom) if bottom else Fraction(top)


def whole(name: str, value: Any, low: int, high: int) -> int:
    """A whole number, which ``true`` is not; Refused unless it lies between two others."""
    if type(value) is not int or not low <= value <= high:
        raise Refused(f"{name} must be a whole number from {low} to {high}, got {value!a:.60}")
    return value


def interval(pair: Any) -> Interval:
    """The interval that two texts denote; Refused if they denote none."""
    if not isinstance(pair, list) or len(pair) != 2:
        raise Refused(f"an interval must have two ends, got {pair!a:.60}")
    low, high = number(pair[0]), number(pair[1])
    if low > high:
        raise Refused(f"an interval must not end before it begins, got {pair}")
    return low, high
