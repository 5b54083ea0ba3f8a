"""Derivatives of a piece of a map by differences."""

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.engine.maps import SpaceImage


def differences(image: SpaceImage, x: Floats, p: Floats, h: float) -> Floats:
    """(d, d + k) by central differences of order four along the piece of an image."""
    found, at = [], np.concatenate([x, p])
    for step in h * np.eye(len(at)):
        values = [image.piece.at(*np.split(at + k * step, [len(x)])).value for k in (-2, -1, 1, 2)]
        found.append((values[0] - 8 * values[1] + 8 * values[2] - values[3]) / (12 * h))
    return np.array(found).T
