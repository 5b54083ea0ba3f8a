"""What the views of the toy are given, beside the public functions; no browser."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from woodpecker import Toy, first_return, return_map, shoot, simulate
from woodpecker.explore import model
from woodpecker.explore.model import closed_bits
from woodpecker.explore.state import PageState

STABLE = -0.5294719671  # rad, of the paper's data
FALLS = -0.05  # rad: from there the toy slides down for ever


def test_the_start_goes_with_its_motion() -> None:
    state, message = model.settled(PageState(toy=Toy(eps_n1=0.45)))
    assert message == ""
    assert state.phi_s == shoot(Toy(eps_n1=0.45), -0.53).phi_s
    free = PageState(phi_s=-1.0, periodic=False)
    assert model.settled(free) == (free, "")
    far, message = model.settled(PageState(phi_s=-0.65))  # Newton's method leads away
    assert (far.phi_s, "another one, at -0.52" in message) == (-0.65, True)
    lost, message = model.settled(PageState(phi_s=-1.9))  # no motion repeats near
    assert lost.phi_s == -1.9
    assert "the motion from -1.9000 rad is shown" in message


def test_a_start_on_its_motion_is_kept_to_the_last_bit() -> None:
    """Newton's method moved it by some, so that a page changed the link it was opened with."""
    for value in np.linspace(0.3, 0.62, 20).tolist():
        once, _ = model.settled(PageState(toy=Toy(eps_n1=value)))
        assert model.settled(once) == (once, "")


@pytest.mark.parametrize("order", [1, 2])
def test_a_map_has_the_values_and_the_jumps_of_the_map(order: int) -> None:
    state = PageState(order=order)
    *_, fine = model.curves(state, fine=True)
    seen = np.isfinite(fine.x) & np.isfinite(fine.y)
    again = return_map(Toy(), fine.x[seen][::50], order).phi_s
    assert np.array_equal(again, fine.y[seen][::50])
    if order == 1:
        for place in (-2.35, -0.7577872574):  # the paper's, and to all digits
            assert np.abs(fine.jumps[:, 0] - place).min() < 2e-3
        assert len(fine.fixed) == 3  # rest, where all returns end where they begin, is none
    k = int(np.argmin(np.abs(fine.fixed - STABLE)))
    assert abs(fine.fixed[k] - STABLE) < 1e-4  # of a chord between samples
    assert fine.stable[k]


def test_a_coarse_map_is_drawn_in_one_go() -> None:
    (coarse,) = model.curves(PageState(), fine=False)
    assert len(coarse.steep) > 5  # it is not told what these are
    assert len(coarse.jumps) == len(coarse.crossings) == 0


def test_a_cobweb_is_an_orbit() -> None:
    orbit = model.orbit(PageState(phi_s=-1.6, periodic=False, steps=7))
    assert len(orbit) == 8
    for before, after in pairwise(orbit):
        assert first_return(Toy(), before).phi_s == after
    assert len(model.orbit(PageState(phi_s=FALLS, periodic=False))) == 1


def test_a_motion_says_what_is_closed() -> None:
    orbit = shoot(Toy(), -0.53)
    motion = model.motion(PageState(phi_s=orbit.phi_s))
    assert " ".join(mark.symbol for mark in motion.marks) == orbit.word
    assert motion.numbers["multiplier"] == pytest.approx(orbit.multiplier, rel=1e-9)
    trajectory = simulate(Toy(), orbit.phi_s, orbit.period)
    bits = closed_bits(trajectory)
    gaps = np.column_stack([
        Toy().phi_s_max - trajectory.q[:, 2], trajectory.q[:, 1] + Toy().phi_m_max,
        Toy().phi_m_max - trajectory.q[:, 1],
    ])  # fmt: skip
    for k in range(3):
        closed = (bits >> k & 1).astype(bool)
        assert closed.any()
        assert np.abs(gaps[closed, k]).max() < 1e-12  # rad: a closed contact has no gap
        assert (gaps[~closed, k] > -1e-12).all()


def test_a_free_fall_is_shown_and_said() -> None:
    state = PageState(phi_s=FALLS, periodic=False)
    motion = model.motion(state)
    assert motion.message.startswith("free fall")
    assert motion.t[-1] == 0.4  # s that are shown


def test_two_returns_have_two_words() -> None:
    state, _ = model.settled(replace(PageState(toy=Toy(eps_n1=0.7)), phi_s=-0.56, order=2))
    motion = model.motion(state)
    assert sum(mark.symbol.startswith("J2") for mark in motion.marks) == 2
