"""Values in messages, and checks of a toy's: without numpy, which a toy does not need."""

from __future__ import annotations

from enum import Enum
from typing import Any

from pwmap.algebra.arguments import shown as shown


def real(name: str, value: Any) -> float:
    """A real number as a float; ValueError if it is too large to be one."""
    try:
        return float(value)
    except OverflowError:
        raise ValueError(f"{name} must be below 1.8e308, got {shown(value)}") from None


def choice(name: str, value: Any, kind: type[Enum]) -> Any:
    """The member of an enum with a value; ValueError that lists all values if there is none."""
    try:
        return kind(value)
    except ValueError:
        known = " or ".join(repr(each.value) for each in kind)
        raise ValueError(f"{name} must be {known}, got {shown(value)}") from None
