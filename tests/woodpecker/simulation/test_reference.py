"""The kernel against an independent program with 30 digits, studies/peers/reference_mpmath.py."""

import re
from typing import Any

import pytest

from studies.peers import reference_mpmath
from woodpecker import Return, Status, Toy, first_return

LAWS = ("summed", "separate")
laws = pytest.mark.parametrize("law", LAWS)
EVEN = (0.3, 0.3, 0.3)

# (phi_S, eps_N1, mu): jams and swings, hyperbolic modes (upper sleeve sliding up, words with R3),
# impacts at two contacts in every way the two laws let them stick and slide, sticking impacts,
# chatter (C1), both sides of jumps and the points A, B, C.
STATES = [
    (-0.35, 0.5, EVEN),
    (-0.42, 0.75, EVEN),
    (-0.43, 0.02, EVEN),
    (-0.48, 0.8, EVEN),
    (-0.52, 0.13, EVEN),
    (-0.52947197, 0.5, EVEN),
    (-0.66, 0.95, EVEN),
    (-0.7577, 0.1851, EVEN),
    (-0.7579, 0.1851, EVEN),
    (-0.8, 0.125, EVEN),
    (-0.8173, 0.0169, EVEN),
    (-0.8847, 0.0422, EVEN),
    (-0.88475, 0.11197, EVEN),
    (-0.88478, 0.11197, EVEN),
    (-0.885, 0.335, EVEN),
    (-0.8849, 0.0105, EVEN),
    (-0.95, 0.05, EVEN),
    (-1.0, 0.31, EVEN),
    (-1.1, 0.9, EVEN),
    (-1.22, 0.5, EVEN),
    (-1.2848, 0.6157, EVEN),
    (-1.3431, 0.9342, EVEN),
    (-1.4728, 0.3458, EVEN),
    (-1.56, 0.43, EVEN),
    (-1.58, 0.56, EVEN),
    (-1.765, 0.1367, EVEN),
    (-2.1086, 0.1469, EVEN),
    (-2.228, 0.2814, EVEN),
    (-2.349, 0.5, EVEN),
    (-2.3495, 0.5, EVEN),
    (-0.4309, 0.9623, (0.38, 0.35, 0.54)),
    (-0.4334, 0.1749, (0.51, 0.346, 0.53)),
    (-0.4368, 0.1319, (0.556, 0.319, 0.3286)),
    (-0.8333, 0.594, (0.4, 0.54, 0.42)),
    (-1.1189, 0.0655, (0.6, 0.4, 0.59)),
    (-1.2142, 0.1028, (0.48, 0.46, 0.456)),
]
Friction = tuple[float, float, float]


def plain(word: str) -> str:
    """The word without the letters that tell the phases of an impact apart."""
    return re.sub(r"(?<=\d)[sfr-]+", "", word)


def both(
    law: str, phi_s: float, eps_n1: float, mu: Friction = EVEN
) -> tuple[reference_mpmath.Return, Return]:
    """The return with 30 digits, and the kernel's."""
    changes: dict[str, Any] = dict(zip(("mu_1", "mu_2", "mu_3"), mu, strict=True))
    changes |= {"eps_n1": eps_n1, "expansion_friction": law}
    exact = reference_mpmath.first_return(phi_s, {**reference_mpmath.PAPER, **changes})
    return exact, first_return(Toy(**changes), phi_s)


@laws
@pytest.mark.slow
@pytest.mark.parametrize(("phi_s", "eps_n1", "mu"), STATES)
def test_return_agrees_with_thirty_digits(
    law: str, phi_s: float, eps_n1: float, mu: Friction
) -> None:
    exact, here = both(law, phi_s, eps_n1, mu)
    assert here.status is Status.RETURNED
    assert exact.status == "returned"
    assert plain(here.word) == exact.word
    # the bound the kernel promises: rounding, and what the map itself makes of rounding
    bound = 1e-12 + 1e-13 * abs(here.slope)
    assert abs(here.phi_s - exact.phi_s) <= bound
    assert abs(here.period - exact.period) <= bound
    assert abs(here.drop - exact.drop) <= bound


@laws
def test_states_are_spread(law: str) -> None:
    """Over the window and over eps_N1; half of them and more with an impact at two contacts."""
    assert len(STATES) >= 30
    assert {round(eps) for _, eps, _ in STATES} == {0, 1}
    assert min(phi for phi, _, _ in STATES) < -2.3
    assert max(phi for phi, _, _ in STATES) > -0.4
    words = []
    for phi_s, eps_n1, (mu_1, mu_2, mu_3) in STATES:
        toy = Toy(eps_n1=eps_n1, mu_1=mu_1, mu_2=mu_2, mu_3=mu_3, expansion_friction=law)
        words.append(first_return(toy, phi_s).word)
    assert 2 * sum("+" in word for word in words) >= len(STATES)


def test_both_laws_are_one_where_no_two_contacts_expand_together() -> None:
    """No word with `+`: the same return to the last bit; with `+`: another one."""
    for phi_s, eps_n1, (mu_1, mu_2, mu_3) in STATES:
        toy = Toy(eps_n1=eps_n1, mu_1=mu_1, mu_2=mu_2, mu_3=mu_3)
        summed = first_return(toy, phi_s)
        separate = first_return(toy.replace(expansion_friction="separate"), phi_s)
        if "+" in separate.word:
            assert abs(summed.phi_s - separate.phi_s) > 1e-6  # seen: from 1e-4 on
        else:
            assert (summed.phi_s, summed.word) == (separate.phi_s, separate.word)


@laws
@pytest.mark.slow
def test_indeterminate_impulses_are_seen_by_both(law: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The kernel goes on from the middle of the segment, where the reference stops unless told."""
    state = -1.7557529808118213, 0.34069658639339057
    exact, here = both(law, *state)
    assert "not unique" in exact.status
    assert here.status is Status.RETURNED_INDETERMINATE
    assert "I~1" in here.word
    segment, images = reference_mpmath.sticking_pair, []
    for part in (0.0, 0.5, 1.0):

        def one_point(*arguments: Any, part: float = part) -> Any:
            ends = segment(*arguments)
            return ends and [[x + part * (y - x) for x, y in zip(*ends, strict=True)]] * 2

        monkeypatch.setattr(reference_mpmath, "sticking_pair", one_point)
        exact, _ = both(law, *state)
        assert exact.status == "returned"
        images.append(exact.phi_s)
    assert abs(here.phi_s - images[1]) <= 1e-12 + 1e-13 * abs(here.slope)
    assert sorted(images)[1] == images[1]
    assert 1e-3 < abs(images[2] - images[0]) < 1e-2  # how much the laws leave open
