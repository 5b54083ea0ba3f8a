"""The toy as a piecewise-smooth map: values, gradients, and pieces that are not fooled."""

import math

import numpy as np
import pytest

from woodpecker import Toy, first_return
from woodpecker.maps import check_derivatives
from woodpecker.mechanics.toy import RESTITUTIONS
from woodpecker.toy_map import PATH_ENDS, ToyPieces


@pytest.mark.parametrize("law", ["summed", "separate"])
@pytest.mark.parametrize("parameter", ["eps_n1", "eps_n2", "mu_2", "m_s", "l_s"])
def test_images_are_those_of_the_map(parameter: str, law: str) -> None:
    """Value, slope and word as the searching kernel finds them; margins are positive."""
    toy = Toy(eps_n2=0.1 if parameter == "eps_n2" else 0.0, expansion_friction=law)  # type: ignore[arg-type]
    p, rng = float(getattr(toy, parameter)), np.random.default_rng(5)
    pieces = ToyPieces(toy, parameter)
    for x in rng.uniform(-2.45, -0.27, 40):
        image, expected = pieces.at(x, p), first_return(toy, x)
        assert image.reason == ""
        assert image.piece.word == expected.word
        steep = 1.0 + abs(expected.slope)
        assert abs(image.value - expected.phi_s) <= 1e-13 * steep
        assert image.slope == pytest.approx(expected.slope, rel=1e-9, abs=1e-9)
        if parameter == "eps_n1":
            assert image.d_parameter == pytest.approx(expected.d_eps_n1, rel=1e-9, abs=1e-9)
        assert image.margins.min() > 0.0
        assert image.gradients.shape == (len(image.margins), 2)
        again = image.piece.at(x, p)
        assert abs(again.value - image.value) <= 1e-13 * steep
        assert again.piece.key == image.piece.key
        assert all(image.piece.cause(int(code)) for code in image.causes)


@pytest.mark.slow
@pytest.mark.parametrize("parameter", ["eps_n1", "eps_n2", "mu_2", "m_s", "l_s"])
def test_derivatives_of_values_and_margins(parameter: str) -> None:
    """In both directions, against differences, inside of pieces."""
    eps_n2 = 0.2 if parameter == "eps_n2" else 0.0
    for x, eps_n1 in ((-0.53, 0.5), (-0.6, 0.9), (-0.7, 0.9), (-2.0, 0.5)):
        toy = Toy(eps_n1=eps_n1, eps_n2=eps_n2)
        check_derivatives(ToyPieces(toy, parameter), [(x, float(getattr(toy, parameter)))])


@pytest.mark.slow
@pytest.mark.parametrize("parameter", ["eps_n1", "eps_n2", "l_s"])
def test_a_piece_is_never_fooled(parameter: str) -> None:
    """Wherever all margins of a piece are positive the toy takes it, however far it was met.

    Newton's method may fall on another root there; a margin must say so. Values agree within the
    rounding of a return, 1e-13 of its slope.
    """
    toy, rng = Toy(), np.random.default_rng(6)
    value = float(getattr(toy, parameter))
    low, high = (0.02, 0.95) if parameter in RESTITUTIONS else (0.9 * value, 1.1 * value)
    whole = ToyPieces(toy, parameter)
    inside = outside = 0
    for _ in range(400):
        x, p = float(rng.uniform(-2.5, -0.24)), float(rng.uniform(low, high))
        met = whole.at(x, p)
        if met.reason:
            continue
        for _ in range(5):
            y = x + float(rng.choice((-1.0, 1.0)) * 10.0 ** rng.uniform(-5.0, math.log10(0.3)))
            q = min(high, max(low, p + float(rng.choice((0.0, 0.1)) * rng.normal())))
            far = met.piece.at(y, q)
            if far.reason or far.margins.min() <= 0.0:
                outside += 1
                continue
            taken = whole.at(y, q)
            inside += 1
            assert taken.reason == ""
            assert abs(taken.value - far.value) <= 1e-13 * (1.0 + abs(taken.slope)), (x, p, y, q)
            assert taken.piece.key == far.piece.key, (x, p, y, q)
    assert inside > 500
    assert outside > 300


def test_where_there_is_no_image_the_reason_is_in_words() -> None:
    lost = ToyPieces(Toy(mu_2=0.2)).at(-0.5, 0.5)
    assert lost.reason == first_return(Toy(mu_2=0.2), -0.5).status.value
    assert math.isnan(lost.value)
    assert lost.piece.at(-0.5, 0.5).reason == lost.reason
    far = ToyPieces(Toy()).at(-0.55, 0.5).piece.at(-2.4, 0.5)
    assert far.reason == PATH_ENDS
    assert len(far.margins) == 0
    assert far.gradients.shape == (0, 2)


@pytest.mark.parametrize("held", [{"mu_2": 0.31}, {"eps_n2": 0.1}, {"pole": 0.01}])
def test_maps_that_share_tables_keep_their_own_values(held: dict[str, float]) -> None:
    whole = ToyPieces(Toy())
    before = whole.at(-0.53, 0.5)
    there = whole.holding(**held).at(-0.53, 0.5)
    alone = ToyPieces(Toy(**held)).at(-0.53, 0.5)
    again = whole.at(-0.53, 0.5)
    assert np.array_equal([there.value, there.slope], [alone.value, alone.slope], equal_nan=True)
    assert there.reason == alone.reason
    assert (again.value, again.slope) == (before.value, before.slope)
