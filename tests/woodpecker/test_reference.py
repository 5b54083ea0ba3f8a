"""The kernel against an independent implementation with 30 digits (studies/reference_mpmath.py)."""

import re

import pytest
import reference_mpmath

from woodpecker import Status, Toy, first_return

# (phi_S, eps_N1): jams and swings, hyperbolic modes (upper sleeve sliding up, words with R3),
# two-contact impacts, sticking impacts, chatter (C1), both sides of jumps and the points A, B, C.
STATES = [
    (-0.35, 0.5),
    (-0.42, 0.75),
    (-0.43, 0.02),
    (-0.48, 0.8),
    (-0.52, 0.13),
    (-0.52947197, 0.5),
    (-0.61, 0.3),
    (-0.66, 0.95),
    (-0.7577, 0.1851),
    (-0.7579, 0.1851),
    (-0.8, 0.125),
    (-0.8173, 0.0169),
    (-0.8847, 0.0422),
    (-0.885, 0.335),
    (-0.8849, 0.0105),
    (-0.95, 0.05),
    (-1.0, 0.31),
    (-1.1, 0.9),
    (-1.22, 0.5),
    (-1.2848, 0.6157),
    (-1.3431, 0.9342),
    (-1.4728, 0.3458),
    (-1.58, 0.56),
    (-1.765, 0.1367),
    (-1.9746, 0.4447),
    (-2.1086, 0.1469),
    (-2.228, 0.2814),
    (-2.2751, 0.2378),
    (-2.349, 0.5),
    (-2.3495, 0.5),
]


def plain(word: str) -> str:
    """The word without the letters that tell the phases of an impact apart."""
    return re.sub(r"(?<=\d)[sfr-]+", "", word)


@pytest.mark.slow
@pytest.mark.parametrize(("phi_s", "eps_n1"), STATES)
def test_return_agrees_with_thirty_digits(phi_s: float, eps_n1: float) -> None:
    exact = reference_mpmath.first_return(phi_s, {**reference_mpmath.PAPER, "eps_n1": eps_n1})
    here = first_return(Toy(eps_n1=eps_n1), phi_s)
    assert here.status is Status.RETURNED
    assert exact.status == "returned"
    assert plain(here.word) == exact.word
    # the bound the kernel promises: rounding, and what the map itself makes of rounding
    bound = 1e-12 + 1e-13 * abs(here.slope)
    assert abs(here.phi_s - exact.phi_s) <= bound
    assert abs(here.period - exact.period) <= bound
    assert abs(here.drop - exact.drop) <= bound


def test_states_are_spread() -> None:
    assert len(STATES) >= 24
    assert {round(eps) for _, eps in STATES} == {0, 1}
    assert min(phi for phi, _ in STATES) < -2.3
    assert max(phi for phi, _ in STATES) > -0.4


@pytest.mark.slow
def test_indeterminate_impulses_are_seen_by_both() -> None:
    phi_s, eps_n1 = -1.7557529808118213, 0.34069658639339057
    exact = reference_mpmath.first_return(phi_s, {**reference_mpmath.PAPER, "eps_n1": eps_n1})
    here = first_return(Toy(eps_n1=eps_n1), phi_s)
    assert "not unique" in exact.status
    assert here.status is Status.RETURNED_INDETERMINATE
    assert "I~1" in here.word
    # the reference continued from both ends of the segment of impulses
    assert -0.683448 < here.phi_s < -0.677943
