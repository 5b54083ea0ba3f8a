"""Checks of what a caller hands in: one sentence that names the value and what was expected."""

from __future__ import annotations

from pwmap.algebra.terms import shortened
from pwmap.maps.piecewise_linear import PiecewiseLinearMap


def check_map(map_: object) -> None:
    """TypeError unless it is a map."""
    if not isinstance(map_, PiecewiseLinearMap):
        raise TypeError(
            f"expected a PiecewiseLinearMap (see its from_sympy), got {shortened(repr(map_), 100)}"
        )


def check_kind(name: str, value: object, kind: type, room: str = "pwmap") -> None:
    """TypeError unless a value is of a kind that has a public name."""
    if not isinstance(value, kind):
        raise TypeError(f"{name} must be {room}.{kind.__name__}, got {shortened(repr(value), 100)}")
