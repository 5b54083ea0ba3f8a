"""Array types of the whole package, and the norm of short vectors."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Complexes = npt.NDArray[np.complex128]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]
Codes = npt.NDArray[np.int16]  # event codes

STEP = 2.0**-17  # relative step of central differences: near the cube root of the rounding


def norm(vector: Floats) -> float:
    """Euclidean norm of a vector (n,), faster than numpy's for short ones."""
    return math.sqrt(float(vector @ vector))
