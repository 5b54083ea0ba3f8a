"""The return map: the table of known values, exact derivatives, words, executors."""

from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest

from woodpecker import ReturnMap, Status, Toy, first_return, return_map, shoot, simulate

TOY = Toy()
CYCLE = "S2 D2 I3 D3 I1 I3 D3 I2 D2 I2 J2"


def word_at(phi_s: float, toy: Toy = TOY) -> str:
    return first_return(toy, phi_s).word


def edge(low: float, high: float, toy: Toy = TOY) -> float:
    """Where the word changes between two starts, by bisection."""
    first = word_at(low, toy)
    assert word_at(high, toy) != first
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if word_at(middle, toy) == first else (low, middle)
    return high


def test_stable_cycle() -> None:
    """Half a unit of the last digit of the known values."""
    orbit = shoot(TOY, -0.53)
    assert orbit.word == CYCLE
    assert orbit.phi_s == pytest.approx(-0.52947197, abs=5e-9)
    assert orbit.period == pytest.approx(0.14597607, abs=5e-9)
    assert orbit.drop == pytest.approx(19.4454e-3, abs=5e-8)
    assert orbit.multiplier == pytest.approx(-0.83916, abs=5e-6)


def test_event_times_of_the_cycle() -> None:
    motion = simulate(TOY, shoot(TOY, -0.53).phi_s, 0.14)
    times = [0.028410, 0.034231, 0.045120, 0.045120, 0.048221, 0.048801, 0.050656]
    times += [0.085944, 0.085944, 0.088673, 0.134793]
    assert [event.symbol for event in motion.events] == CYCLE.split()
    assert [event.time for event in motion.events] == pytest.approx(times, abs=5e-7)


def test_jumps_of_the_map() -> None:
    assert edge(-0.88478, -0.88476) == pytest.approx(-0.884773, abs=5e-7)
    assert edge(-0.75779, -0.75778) == pytest.approx(-0.757787, abs=5e-7)
    for where in (-0.884773344, -0.757787257):
        left, right = (first_return(TOY, where + side).phi_s for side in (-1e-7, 1e-7))
        assert abs(left - right) > 0.02


def test_dips_are_deep() -> None:
    for low, high in ((-1.23, -1.22), (-0.27, -0.262)):
        images = return_map(TOY, np.linspace(low, high, 4001)).phi_s
        assert images.min() < -8.0
        assert np.linspace(low, high, 4001)[images.argmin()] == pytest.approx(
            -1.225 if low < -1 else -0.266, abs=1e-3
        )


@pytest.mark.parametrize("phi_s", [-0.2382, -0.23, -0.2217])
def test_band_of_centres_is_the_identity(phi_s: float) -> None:
    """A swing about the equilibrium on the jammed sleeve returns to its start to the last bits."""
    once = first_return(TOY, phi_s)
    assert once.phi_s == pytest.approx(phi_s, abs=1e-15)
    assert once.drop == 0.0
    assert once.word == ""
    assert once.slope == pytest.approx(1.0, abs=1e-12)


def test_start_above_the_equilibrium_is_a_maximum() -> None:
    equilibrium = -0.22169381157635465
    once = first_return(TOY, -0.21)
    assert once.phi_s == pytest.approx(2.0 * equilibrium + 0.21, abs=1e-15)
    assert once.slope == pytest.approx(-1.0, abs=1e-12)


def test_start_right_of_the_cone_cannot_jam() -> None:
    """d = -0.1018 on the cone of contact 2: phi_S = -0.2052."""
    assert word_at(-0.2053).startswith("S2") is False
    assert word_at(-0.2050).split()[0] == "S2"


def test_beak_strikes_while_the_upper_contact_is_closed() -> None:
    once = first_return(Toy(eps_n1=0.125), -0.8)
    assert once.phi_s == pytest.approx(-0.52034, abs=5e-6)
    assert "I1+3" in once.word.split()


def central(f: list[float], h: float) -> float:
    """Derivative from values at -2h, -h, h, 2h: truncation h^4 f^(5)/30, rounding 1e-15/h."""
    return (8.0 * (f[2] - f[1]) - (f[3] - f[0])) / (12.0 * h)


def test_derivatives_agree_with_central_differences() -> None:
    """States within 2e-5 of a change of word, and steep flanks, which bend more than the
    differences can follow, are passed over."""
    rng = np.random.default_rng(3)
    h, compared = 1e-5, 0
    for _ in range(80):
        phi_s, eps = float(rng.uniform(-2.4, -0.3)), float(rng.uniform(0.02, 0.98))
        here = first_return(Toy(eps_n1=eps), phi_s)
        starts = [first_return(Toy(eps_n1=eps), phi_s + k * h) for k in (-2, -1, 1, 2)]
        others = [first_return(Toy(eps_n1=eps + k * h), phi_s) for k in (-2, -1, 1, 2)]
        same_piece = {one.word for one in (*starts, *others)} == {here.word}
        if not same_piece or max(abs(here.slope), abs(here.d_eps_n1)) > 20.0:
            continue
        compared += 1
        slope, rate = (central([one.phi_s for one in ones], h) for ones in (starts, others))
        assert here.slope == pytest.approx(slope, rel=1e-6, abs=1e-9)
        assert here.d_eps_n1 == pytest.approx(rate, rel=1e-6, abs=1e-9)
    assert compared >= 40


@pytest.mark.parametrize("order", [2, 3])
def test_higher_orders_simulate_again(order: int) -> None:
    x, slope, rate, words = -0.6, 1.0, 0.0, []
    for _ in range(order):
        once = first_return(TOY, x)
        x, rate, slope = once.phi_s, once.slope * rate + once.d_eps_n1, once.slope * slope
        words.append(once.word)
    many = first_return(TOY, -0.6, order)
    assert many.phi_s == x  # the same bits: nothing is interpolated
    assert many.slope == pytest.approx(slope, rel=1e-12)
    assert many.d_eps_n1 == pytest.approx(rate, rel=1e-12)
    assert many.word == " | ".join(words)


def same(a: ReturnMap, b: ReturnMap) -> None:
    for name in ("start", "phi_s", "period", "drop", "slope", "d_eps_n1"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name))
    assert a.words == b.words
    assert a.status == b.status


def test_map_equals_single_returns() -> None:
    starts = np.linspace(-2.5, 0.1, 40)
    many = return_map(TOY, starts.reshape(8, 5))
    for k, phi_s in enumerate(starts):
        once = first_return(TOY, float(phi_s))
        assert (many.words[k], many.status[k]) == (once.word, once.status)
        np.testing.assert_array_equal(
            [many.phi_s[k], many.period[k], many.drop[k], many.slope[k]],
            [once.phi_s, once.period, once.drop, once.slope],
        )


def test_threads_give_the_same_map() -> None:
    starts = np.linspace(-2.5, -0.24, 1000)
    with ThreadPoolExecutor(3) as pool:
        same(return_map(TOY, starts), return_map(TOY, starts, executor=pool))


@pytest.mark.slow
def test_processes_give_the_same_map() -> None:
    starts = np.linspace(-2.5, -0.24, 600)
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        same(return_map(TOY, starts), return_map(TOY, starts, executor=pool))


def test_empty_map() -> None:
    assert return_map(TOY, []).words == ()


def test_free_fall_and_the_end_of_the_pole() -> None:
    endless = first_return(TOY, -0.05)
    assert endless.status is Status.FREE_FALL
    assert endless.drop == np.inf
    assert np.isnan([endless.phi_s, endless.period, endless.slope, endless.d_eps_n1]).all()
    ended = first_return(TOY.replace(pole=0.4), -0.05)
    assert (ended.status, ended.drop) == (Status.POLE_END, 0.4)
    # the nominal return falls 19 mm
    assert first_return(TOY.replace(pole=0.019), -0.53).status is Status.POLE_END
    assert first_return(TOY.replace(pole=0.020), -0.53).status is Status.RETURNED


@pytest.mark.parametrize(
    ("phi_s", "order", "sentence"),
    [
        (0.13, 1, "phi_s must be finite and below 0.12"),
        (float("nan"), 1, "phi_s must be finite .* got nan"),
        (-0.5, 0, "order must be a whole number of at least 1, got 0"),
        (-0.5, 1.5, "order must be a whole number of at least 1, got 1.5"),
        (-0.5, True, "order must be a whole number of at least 1, got True"),
    ],
)
def test_wrong_requests(phi_s: float, order: int, sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        first_return(TOY, phi_s, order)
    with pytest.raises(ValueError, match=sentence):
        return_map(TOY, [phi_s], order)


def test_derivative_at_zero_restitution_is_that_of_small_bounces_or_unknown() -> None:
    """The upper contact opens at once after its impacts, so eps_N1 = 0 has a one-sided slope."""
    h = 1e-6
    here = first_return(Toy(eps_n1=0.0), -0.6)
    f = [first_return(Toy(eps_n1=k * h), -0.6).phi_s for k in range(3)]
    forward = (-3.0 * f[0] + 4.0 * f[1] - f[2]) / (2.0 * h)
    assert np.isnan(here.d_eps_n1) or here.d_eps_n1 == pytest.approx(forward, rel=1e-5)
