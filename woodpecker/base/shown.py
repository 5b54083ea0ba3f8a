"""Values in sentences, without numpy, which a toy does not need."""

from __future__ import annotations

import math
from typing import Any

LONGEST = 100  # characters of a value in a sentence


def real(name: str, value: Any) -> float:
    """A real number as a float; ValueError if it is too large to be one."""
    try:
        return float(value)
    except OverflowError:
        raise ValueError(f"{name} must be below 1.8e308, got {shown(value)}") from None


def shown(value: Any) -> str:
    """A value in a sentence: large arrays by their shape, long texts cut off."""
    if hasattr(value, "shape") and getattr(value, "size", 0) > 4:
        return f"an array of shape {value.shape}"
    if isinstance(value, int) and abs(value) > 10**LONGEST:
        return f"a whole number of {int(math.log10(abs(value))) + 1} digits"
    text = repr(value)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."
