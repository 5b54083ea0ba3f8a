"""Show values in messages without importing numpy, which a toy does not need."""

from __future__ import annotations

from typing import Any

from pwmap.algebra.arguments import shown as shown


def real(name: str, value: Any) -> float:
    """A real number as a float; ValueError if it is too large to be one."""
    try:
        return float(value)
    except OverflowError:
        raise ValueError(f"{name} must be below 1.8e308, got {shown(value)}") from None
