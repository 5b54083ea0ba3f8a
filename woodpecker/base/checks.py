"""Checks of arguments: errors of one sentence with the value and what was expected."""

from __future__ import annotations

import math
import numbers
import operator
from collections.abc import Sequence
from decimal import Decimal
from typing import Any

import numpy as np
import numpy.typing as npt

from pwmap.algebra.arguments import MOST, check_kind, is_several, shown
from pwmap.diagrams.shown import counted
from woodpecker.base.arrays import Floats
from woodpecker.base.shown import real

instance = check_kind  # its name in this package


def number(name: str, value: Any) -> float:
    """One real number, nan and infinities included; ValueError for anything else."""
    one = value[()] if isinstance(value, np.ndarray) and value.ndim == 0 else value
    exact = getattr(one, "is_number", False) and getattr(one, "is_real", False)  # pi/2 of sympy
    known = exact or isinstance(one, numbers.Real | Decimal)
    if not known or isinstance(one, bool | np.bool_):
        raise ValueError(f"{name} must be one real number, got {shown(value)}")
    return real(name, one)


def positive(name: str, value: Any) -> float:
    """One positive, finite number; ValueError for anything else."""
    checked = number(name, value)
    if not 0.0 < checked < math.inf:
        raise ValueError(f"{name} must be positive and finite, got {shown(value)}")
    return checked


def whole(name: str, value: Any, least: int = 1, most: int = MOST) -> int:
    """An integer of any kind but bool in [least, most]; ValueError for anything else."""
    try:
        if isinstance(value, bool | np.bool_):
            raise TypeError
        checked = operator.index(value)
    except TypeError:
        checked = least - 1
    if checked < least:
        raise ValueError(f"{name} must be a whole number of at least {least}, got {shown(value)}")
    if checked > most:
        raise ValueError(f"{name} must be a whole number of at most {most}, got {shown(value)}")
    return checked


def iterates(orders: Sequence[int]) -> tuple[int, ...]:
    """Orders of iterates, ascending, each once; ValueError if there is none, or one is below 1."""
    if np.ndim(orders) == 0 or not is_several(orders):
        raise ValueError(f"orders must be whole numbers such as (1, 2), got {shown(orders)}")
    wanted = sorted({whole("orders", order) for order in orders})
    if not wanted:
        raise ValueError(f"orders must name at least one iterate, got {tuple(orders)}")
    return tuple(wanted)


def interval(name: str, value: Any, *, finite: bool = False) -> tuple[float, float]:
    """Two ascending numbers, infinities included unless ``finite``; ValueError otherwise."""
    try:
        low, high = (number(name, end) for end in value)
    except (TypeError, ValueError):
        raise ValueError(f"{name} must be two real numbers, got {shown(value)}") from None
    if not low < high:
        raise ValueError(f"{name} must ascend, got ({low}, {high})")
    if finite and not (math.isfinite(low) and math.isfinite(high)):
        raise ValueError(f"{name} must be finite, got ({low}, {high})")
    return low, high


def lengths(name: str, value: Any, usual: Sequence[float]) -> tuple[float, ...]:
    """Positive lengths, as many as the ``usual`` ones (the default); ValueError otherwise."""
    count = len(usual)
    given = np.array(usual) if value is None else real_array(name, value)
    if given.shape != (count,):
        raise ValueError(f"{name} must be {counted(count, 'positive number')}, got {shown(value)}")
    return tuple(positive(name, each) for each in given.tolist())


def real_array(name: str, value: npt.ArrayLike) -> Floats:
    """A copy as floats; ValueError unless all are real numbers."""
    try:
        given = np.asarray(value)
    except ValueError:
        given = np.array(None)  # rows of different lengths
    if given.dtype.kind not in "iuf" and given.size:
        try:  # such as fractions
            return np.array([number(name, each) for each in given.ravel()]).reshape(given.shape)
        except ValueError:
            raise ValueError(f"{name} must be real numbers, got {shown(value)}") from None
    return np.array(given, dtype=float)
