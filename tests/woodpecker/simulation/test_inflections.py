"""Where a gap hardly falls when it closes three of its roots meet: roots and margins stay exact."""

import math

import numpy as np
import pytest
from needs import NEEDS_NUMBA

from woodpecker import Settings, Toy, ToyPieces, slices_at
from woodpecker.simulation.roots import root_at_inflection


@pytest.mark.parametrize("distance", [1e-3, 1e-9, 1e-15, 0.0, -1e-15, -1e-9, -1e-3])
def test_a_root_near_a_triple_one(distance: float) -> None:
    """f = f_0 + f_3 (t - sin t) with f_0 = 2 pi + distance: all derivatives vanish at 2 pi.

    With t = 2 pi + s it is s - sin s = distance; s is known from its series for small distances,
    and its residual is rounding: 4 spacings of 2 pi for the larger ones.
    """
    f3 = -1.0
    t = root_at_inflection(2.0 * math.pi + distance, 0.0, 0.0, f3, -1.0, 1.0, 2.0 * math.pi + 0.05)
    s = t - 2.0 * math.pi
    given = (2.0 * math.pi + distance) - 2.0 * math.pi  # what is left of it in a double
    assert s == pytest.approx(
        math.copysign(abs(6.0 * given) ** (1.0 / 3.0), given), rel=2e-3, abs=3e-5
    )
    assert s - math.sin(s) == pytest.approx(given, abs=4e-15)


# A random toy, and where a flight from rest of its beak ends exactly as the gap neither rises nor
# falls: the bounces that follow become infinitely short there, and the path is the same beyond.
TOUCHING = Toy(
    m_m=0.00031123658328642047, j_m=4.578569939064069e-09, m_s=0.003942179000624332,
    j_s=7.664405176947906e-07, g=9.97290964897067, r_0=0.002467133899403087,
    r_m=0.0031358322849841837, h_m=0.005814155808391762, l_m=0.010008948695687825,
    l_g=0.014945715053809027, h_s=0.020132151498315345, l_s=0.019755504908083327,
    c_phi=0.004788772284199098, mu_2=0.29366285190044866, mu_3=0.2954236724420988,
    eps_n2=0.2885218894830998, eps_n3=0.2235882813020271,
)  # fmt: skip
MU_1, TOUCHES = 0.30095, -1.4369666361167956


@NEEDS_NUMBA
@pytest.mark.parametrize("start", [-1e-7, -1e-9, 1e-7])
@pytest.mark.parametrize("distance", [1e-9, 1e-7, 1e-5, 3e-5])
def test_a_path_goes_on_where_its_bounces_become_short_and_long_again(
    start: float, distance: float
) -> None:
    """Found on one side, it gives the images on both, to their rounding: slopes are about 100.

    From the left bounces of negative durations were found beyond, and an image 5e-5 off.
    """
    map_ = ToyPieces(TOUCHING, "mu_1")
    piece = map_.at(TOUCHES + start, MU_1).piece
    for x in (TOUCHES - distance, TOUCHES + distance):
        there, own = map_.at(x, MU_1), piece.at(x, MU_1)
        assert there.piece.key == piece.key
        assert own.value == pytest.approx(there.value, abs=1e-12)
        assert own.margins.min() > 0.0


# The toy's upper sleeve closes where its gap only just comes down to zero: on the right it stays
# in contact at its next fall, on the left it hits while it still bends upwards, and leaves again.
MINIMUM, EPS_N1 = -1.5006785493186265, 0.28664410960280257


@NEEDS_NUMBA
@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("distance", [1e-8, 1e-6, 1e-4])
def test_a_minimum_at_which_a_contact_closes_is_one_margin(side: float, distance: float) -> None:
    """Each piece has one margin there, positive inside and negative beyond; no dip besides."""
    map_ = ToyPieces(Toy())
    own = map_.at(MINIMUM + side * distance, EPS_N1).piece
    inside, beyond = (own.at(MINIMUM + s * side * distance, EPS_N1) for s in (1.0, -1.0))
    assert np.count_nonzero(np.abs(inside.margins) < distance) == 1
    assert inside.margins.min() > 0.0
    least = beyond.margins.min()
    assert least == pytest.approx(-inside.margins.min(), rel=1e-3)
    assert np.count_nonzero(beyond.margins < 1e-3 * abs(least)) == 1


@NEEDS_NUMBA
@pytest.mark.parametrize("distance", [1e-8, 1e-6, 1e-4])
def test_a_path_comes_back_to_its_own_impact(distance: float) -> None:
    """Beyond the border its impact is lost, and a later zero of the gap is found.

    Back inside, with its durations from there, it has the map's image again, to its rounding:
    slopes are 20. The later zero gave one 1e-4 off, under margins that were positive all the same.
    """
    map_ = ToyPieces(Toy())
    x = MINIMUM - distance
    there = map_.at(x, EPS_N1)
    beyond = there.piece.at(MINIMUM + distance, EPS_N1)
    assert abs(beyond.value - there.value) > 1e-5  # where a smooth path would be 20 distances off
    again = beyond.piece.at(x, EPS_N1)
    assert again.value == pytest.approx(there.value, abs=1e-12)


@NEEDS_NUMBA
@pytest.mark.parametrize("spacings", range(-2, 3))
@pytest.mark.parametrize("distance", [1e-8, 1e-4])
def test_on_its_border_a_path_has_its_own_impact(distance: float, spacings: int) -> None:
    """The gap touches zero at its minimum, which is the impact; rounding may leave it just above.

    The image changes like a square root of the margin, and margins are rounded to 5e-16: images at
    neighbouring doubles differ by up to 3e-11. The later zero of the gap gave one that was 1e-4 off
    at two spacings.
    """
    map_ = ToyPieces(Toy())
    own = map_.at(MINIMUM - distance, EPS_N1).piece
    beyond = own.at(MINIMUM + distance, EPS_N1).piece
    there = beyond.at(MINIMUM + spacings * math.ulp(MINIMUM), EPS_N1)
    assert there.value == pytest.approx(-1.48117148856, abs=3e-11)


@NEEDS_NUMBA
def test_an_impact_that_falls_into_its_own_minimum_is_kept() -> None:
    """Where the minimum of the swing before it reaches zero the path goes on smoothly beyond.

    Its slope is -0.77; the impact at that minimum would give an image 6e-3 off.
    """
    toy = Toy()
    map_, l_s, x = ToyPieces(toy, "l_s"), 1.1084464081739442 * toy.l_s, -0.5361653051736265
    inside = map_.at(x + 1e-6, l_s)
    beyond = inside.piece.at(x - 1e-6, l_s)
    assert inside.margins.min() > 0.0 > beyond.margins.min() > -1e-6
    assert beyond.value - inside.value == pytest.approx(-2e-6 * inside.slope, rel=1e-3)


@NEEDS_NUMBA
def test_a_piece_that_falls_for_ever_is_left_at_some_time() -> None:
    """Towards an end of its jammed motion the toy falls ever farther, along one path, in waves.

    Two pieces do so in the window; each took 10 000 samples. All others take some tens.
    """
    map_ = ToyPieces(TOUCHING, "mu_1")
    settings = Settings(span=(0.287, 0.305), window=(-2.5, -0.24255))
    before = map_.evaluations
    (found,) = slices_at(map_, 0.2908666459964112, (1,), settings)
    assert map_.evaluations - before < 5_000
    assert (len(found.cycles), len(found.jumps)) == (5, 0)
    assert found.unresolved < 0.01
