"""Sweeps: images and slopes of a map at many points at once, without their pieces."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.maps.pieces import Image


class Sweep(NamedTuple):
    """Images and slopes of a map at many points.

    Examples
    --------
    >>> from woodpecker.examples import two_lines
    >>> two_lines().sweep([-1.0, 2.0], 0.25).value.round(9).tolist()
    [-0.25, -0.083333333]
    """

    value: Floats
    slope: Floats


def one_by_one(at: Callable[[float, float], Image], x: Floats, p: Floats) -> Sweep:
    """The sweep of points and parameters, both (n,), by a map that takes one point at a time."""
    images = map(at, x.tolist(), p.tolist())
    found = np.array([(image.value, image.slope) for image in images], dtype=float)
    return Sweep(*found.reshape(-1, 2).T)
