"""Colours of periods are told apart in grey print, and by eyes that lack one kind of cone."""

from itertools import combinations

import numpy as np
import numpy.typing as npt
import pytest

from pwmap.plot.palette import BACKGROUND, CHAOS, NOTHING, PERIODS, named, of_period

Floats = npt.NDArray[np.float64]

TO_XYZ = np.array(  # of linear sRGB, IEC 61966-2-1
    [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
)
SEEN = {  # Machado, Oliveira and Fernandes (2009), severity 1, on linear sRGB
    "all cones": np.eye(3),
    "no green cones": np.array(
        [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ]
    ),
    "no red cones": np.array(
        [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ]
    ),
}
LIGHTER, APART = 6.0, 13.0  # in CIELAB, where a difference of 2.3 is just noticed side by side


def cielab(colour: str, seen: Floats) -> Floats:
    srgb = np.array([int(colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5)])
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    t = TO_XYZ @ np.clip(seen @ linear, 0.0, 1.0) / TO_XYZ.sum(axis=1)
    x, y, z = np.where(t > 216 / 24389, np.cbrt(t), (24389 / 27 * t + 16.0) / 116.0)
    return np.array([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)])


def test_in_grey_print() -> None:
    light = [cielab(each, np.eye(3))[0] for each in (*PERIODS, CHAOS, NOTHING, BACKGROUND)]
    assert np.diff(sorted(light)).min() > LIGHTER


@pytest.mark.parametrize("seen", SEEN)
def test_by_any_eyes(seen: str) -> None:
    places = [cielab(each, SEEN[seen]) for each in (*PERIODS, CHAOS, NOTHING)]
    assert min(np.linalg.norm(a - b) for a, b in combinations(places, 2)) > APART


def test_the_last_colour_stands_for_all_longer_periods() -> None:
    assert [of_period(n) for n in (1, 8, 9, 64)] == [PERIODS[0], *[PERIODS[7]] * 3]
    assert [named(n) for n in (1, 7, 8, 64)] == [
        "period 1", "period 7", "period 8 or more", "period 8 or more",
    ]  # fmt: skip
