"""First variations of returns in state and all parameters, also where the word is prescribed.

Against central differences of order four in units of the sizes of coordinates and parameters. With
values known to some 1e-14 and steps of 1e-3 these are known to 1e-11, but for the fifth derivative
times h**4/30; where that is large a shorter step is given, down to 1e-5, with which they are known
to 1e-9.
"""

from collections.abc import Callable

import numpy as np
import pytest
from needs import NEEDS_HEYOKA

from studies.systems import den_hartog, oscillator, rimless_wheel, rocking_block, toy
from woodpecker import Toy
from woodpecker.base.arrays import Floats
from woodpecker.engine.maps import SpaceImage
from woodpecker.systems import SystemMap

pytestmark = [NEEDS_HEYOKA, pytest.mark.slow]

CLOSE = 1e-9  # of the largest derivative, at least of 1
ABSENT = 0.1  # the size of a parameter that is zero, such as a restitution

Variables = tuple[list[float], dict[str, float]]  # of a start: coordinates, and parameters


def toy_with_all() -> SystemMap:
    return toy.map_of(Toy(eps_n1=0.5), *map(str, toy.map_of(Toy()).system.parameters))


def with_all(map_of: Callable[..., SystemMap]) -> SystemMap:
    """The map of an instance with all of its parameters free."""
    return map_of(*map(str, map_of().system.parameters))


def off(image: SpaceImage, x: Floats, p: Floats, h: float) -> float:
    """How far the Jacobian of an image is from differences along its piece."""
    at = np.concatenate([x, p])
    sizes = np.where(at == 0.0, ABSENT, np.abs(at))
    found = []
    for step in h * np.diag(sizes):
        values = [image.piece.at(*np.split(at + k * step, [len(x)])).value for k in (-2, -1, 1, 2)]
        found.append((values[0] - 8 * values[1] + 8 * values[2] - values[3]) / (12 * h))
    known = image.jacobian * sizes
    assert np.isfinite(known).all()
    return float(np.abs(known - np.transpose(found)).max() / max(1.0, np.abs(known).max()))


@pytest.mark.parametrize(
    ("map_", "x", "values", "word", "h"),
    [
        (lambda: with_all(oscillator.impacts), [-0.7, 0.6], {}, "I1", 1e-3),
        (lambda: with_all(oscillator.strobed), [-0.4, 1.5], {"F": 6.0}, "I1", 1e-3),
        (lambda: with_all(rocking_block.map_of), [-1.3, 0.3], {}, "I1+2f D2 I1f+2", 1e-4),
        (lambda: with_all(rimless_wheel.map_of), [0.5], {}, "I1f+2s", 1e-3),
        (lambda: with_all(den_hartog.map_of), [0.7, 0.9], {"f": 0.8}, "J1 S1 J1 S1", 1e-3),
        (toy_with_all, [-0.53], {}, "S2 D2 I3 D3 I1 I3 D3 I2 D2 I2 J2", 5e-5),
    ],
    ids=["impacts", "strobed", "block", "wheel", "friction", "toy"],
)
def test_in_state_and_all_parameters(
    map_: Callable[[], SystemMap], x: list[float], values: dict[str, float], word: str, h: float
) -> None:
    one = map_().holding(**values)
    image = one.at(np.array(x), one.p)
    assert image.piece.word == word
    assert off(image, np.array(x), one.p, h) < CLOSE


@pytest.mark.parametrize(
    ("map_", "inside", "beyond", "h"),
    [
        (lambda: with_all(oscillator.impacts), ([-0.7, 0.6], {}), ([-0.3, 2.0], {}), 5e-4),
        (lambda: with_all(rimless_wheel.map_of),
         ([0.8], {"gamma": 0.1}), ([0.8], {"gamma": 0.1, "mu": 0.2}), 1e-3),
        (lambda: with_all(den_hartog.map_of),
         ([1.3, 0.5], {"f": 0.5}), ([1.3, 0.5], {"f": 0.55}), 2e-4),
        (toy_with_all, ([-0.7577], {}), ([-0.7579], {}), 1e-5),
    ],
    ids=["impacts", "wheel", "friction", "toy"],
)  # fmt: skip
def test_beyond_a_border(
    map_: Callable[[], SystemMap], inside: Variables, beyond: Variables, h: float
) -> None:
    """A return along the word of another start, which the system does not take here."""
    one = map_()
    there, here = (one.holding(**values) for _, values in (inside, beyond))
    piece = there.at(np.array(inside[0]), there.p).piece
    x = np.array(beyond[0])
    own = here.at(x, here.p)
    assert own.piece.key != piece.key
    image = piece.at(x, here.p)
    assert image.margins.min() < 0.0
    assert off(image, x, here.p, h) < CLOSE
