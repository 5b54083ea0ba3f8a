"""Differences between two records: exact values as formulas, floats to the last bit."""

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np
import sympy
from sympy.polys.rings import PolyElement


def differences(first: Any, second: Any, where: str = "record") -> list[str]:
    """Where two records differ, with both values; a record is a dataclass, fields that count."""
    if dataclasses.is_dataclass(first):
        names = [each.name for each in dataclasses.fields(first) if each.init and each.compare]
        pairs = {name: (getattr(first, name), getattr(second, name)) for name in names}
    elif isinstance(first, sympy.Basic | PolyElement):
        return [] if first == second else [f"{where}: {first} and {second}"]
    elif isinstance(first, Mapping):
        if list(first) != list(second):
            return [f"{where}: {list(first)} and {list(second)}"]
        pairs = {name: (first[name], second[name]) for name in first}
    elif isinstance(first, tuple):
        if len(first) != len(second):
            return [f"{where}: {len(first)} and {len(second)}"]
        pairs = {str(k): pair for k, pair in enumerate(zip(first, second, strict=True))}
    elif isinstance(first, np.ndarray):
        same = first.shape == second.shape and first.tobytes() == second.tobytes()
        return [] if same else [f"{where}: {first} and {second}"]
    elif isinstance(first, float | np.floating) or isinstance(second, float | np.floating):
        same = float(first).hex() == float(second).hex()
        return [] if same else [f"{where}: {first!r} and {second!r}"]
    else:
        return [] if repr(first) == repr(second) else [f"{where}: {first!r} and {second!r}"]
    return [text for name, pair in pairs.items() for text in differences(*pair, f"{where}.{name}")]
