"""Where borders accumulate a branch goes on beyond them, if it is the same branch."""

import math
from collections.abc import Hashable
from typing import NamedTuple

import numpy as np
import pytest
from needs import NEEDS_NUMBA

from pwmap.diagrams.diagram import BranchKind, PointStatus
from woodpecker import Settings, ToyPieces, continuation, shoot
from woodpecker.engine.germs import lost_beyond
from woodpecker.engine.line import LineMap
from woodpecker.engine.maps import ACCUMULATE, image_at, taken
from woodpecker.maps import Image
from woodpecker.mechanics.toy import Toy

SETTINGS = Settings(span=(-1.0, 1.0), window=(-3.0, 3.0))


class Strip(NamedTuple):
    """x/2 + (p + away)/2 where 2**-(n + 1) < p < 2**-n; up to p = 0 all is one strip, n = -1.

    It has no value beyond, as pieces of the toy have none where an event does not happen.
    """

    n: int
    away: float

    @property
    def key(self) -> Hashable:
        return self.n

    @property
    def word(self) -> str:
        return f"strip {self.n}"

    def at(self, x: float, p: float) -> Image:
        ends = [(-p, -1.0)]
        if self.n >= 0:
            ends = [(p - 2.0 ** -(self.n + 1), 1.0), (2.0**-self.n - p, -1.0)]
        return Image(
            0.5 * (x + p + (self.away if self.n >= 0 else 0.0)), 0.5, 0.5,
            np.array([end for end, _ in ends]), np.array([[0.0, rate] for _, rate in ends]),
            np.arange(len(ends)), self, "no event" if self.n < 0 < p else "",
        )  # fmt: skip

    def cause(self, code: int) -> str:
        return "a strip ends"


class Strips(NamedTuple):
    """Ever thinner strips come to p = 0; beyond it fixed points lie ``away`` from those before."""

    away: float

    def at(self, x: float, p: float) -> Image:
        n = -1 if p <= 0.0 else max(0, math.floor(-math.log2(p)))
        return Strip(n, self.away).at(x, p)


@pytest.mark.slow
def test_a_branch_goes_on_beyond_infinitely_many_strips() -> None:
    """x = p on both sides of p = 0."""
    map_ = Strips(0.0)
    found = continuation(map_, shoot(map_, -0.5, p=-0.5), settings=SETTINGS)
    (branch,) = [each for each in found.branches if each.kind is BranchKind.FIXED_POINT]
    assert (branch.parameter.min(), branch.parameter.max()) == (-1.0, 1.0)
    assert branch.x == pytest.approx(branch.parameter, abs=1e-14)
    assert branch.words


@pytest.mark.parametrize("away", [2e-3, -2e-3, 0.02])
def test_a_branch_that_passes_by_is_another_one(away: float) -> None:
    """x = p before p = 0, x = p + away beyond: near enough to be met by a look far enough ahead."""
    map_ = Strips(away)
    found = continuation(map_, shoot(map_, -0.5, p=-0.5), settings=SETTINGS)
    assert max(float(each.parameter.max()) for each in found.branches) <= 0.0
    (end,) = [point for point in found.points if point.parameter > -0.5]
    assert end.status is PointStatus.OPEN
    assert end.parameter == pytest.approx(0.0, abs=1e-12)  # the shortest step is 1e-13 of 2


@NEEDS_NUMBA
@pytest.mark.parametrize(("x", "p"), [(-0.53, 0.5), (-1.7, 0.2), (-0.3, 0.9)])
def test_the_word_is_that_of_the_image(x: float, p: float) -> None:
    """Whether a map says so by itself or is asked for the whole image; values to rounding."""
    toy = ToyPieces(Toy())
    for own in (toy, Strips(0.5)):
        image = LineMap(own).at(np.array([x]), np.array([p]))
        key, value = taken(LineMap(own), np.array([x]), np.array([p]))
        assert key == image.piece.key
        assert value == pytest.approx(image.value, rel=1e-13)


class Rounded(NamedTuple):
    """The strips with a value at every point, though rounding loses the paths of the thin ones."""

    falls: bool  # whether the map has none there either

    def at(self, x: float, p: float) -> Image:
        image = Strips(0.0).at(x, p)
        return image._replace(reason="the path is lost") if 0.0 < p < 2.0**-8 else image

    def taken(self, x: float, p: float) -> tuple[Hashable, float]:
        image = self.at(x, p)
        return image.piece.key, math.nan if image.reason and self.falls else image.value


@pytest.mark.parametrize(("falls", "reason"), [(True, "the path is lost"), (False, ACCUMULATE)])
def test_what_rounding_loses_is_no_fall(falls: bool, reason: str) -> None:
    """A piece that cannot be followed to its end says nothing of a map that returns."""
    map_ = LineMap(Rounded(falls))
    x, p, onward = np.array([0.0]), np.array([0.0]), np.array([0.0, 1.0])
    assert image_at(map_, x, p + 2.0**-9).reason == reason
    assert map_.beside(x, p, onward).reason == reason
    assert lost_beyond(map_, x, p, 1) == ("the path is lost" if falls else "")


@pytest.mark.parametrize("falls", [True, False])
def test_a_branch_that_begins_again_farther_off_is_another_one(falls: bool) -> None:
    """x = p again from p = 2**-8 on: where no path is known in between, none connects the two."""
    map_ = Rounded(falls)
    found = continuation(map_, shoot(map_, -0.5, p=-0.5), settings=SETTINGS)
    (branch,) = found.branches
    (end,) = [point for point in found.points if point.parameter > -0.5]
    assert float(branch.parameter.max()) == end.parameter == pytest.approx(0.0, abs=1e-12)
    assert end.status is PointStatus.OPEN
