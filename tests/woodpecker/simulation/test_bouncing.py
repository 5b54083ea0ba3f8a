"""Sleeves that bounce: impacts that accumulate at one contact and at two in turns, down to zero."""

import pytest

from studies.peers import reference_mpmath
from woodpecker import ExpansionFriction, Status, Toy, ToyPieces, first_return

LAWS = list(ExpansionFriction)

# Beak and upper edge strike in turns for ever shorter times; the last one ends in bounces that
# stick, so that nothing is left of the slip.
SCENES = {
    "in turns": (
        {
            "eps_n1": 0.012702339530163087, "eps_n3": 0.05205489796654122,
            "mu_1": 0.29611483949586687, "mu_2": 0.4163790867991649, "mu_3": 0.33512687995304435,
        },
        -2.0649850297527785,
    ),
    "series within series": (
        {
            "eps_n1": 0.0017849322242246002, "eps_n3": 0.12023884160437293,
            "mu_1": 0.35011233148042115, "mu_2": 0.35527908893404625, "mu_3": 0.3717676450737769,
        },
        -1.3422813635213406,
    ),
    "in no order": (
        {
            "eps_n1": 0.025248938313188887, "eps_n3": 0.25698162140622105,
            "mu_1": 0.30835832276066494, "mu_2": 0.3216319083712097, "mu_3": 0.4037558242265809,
        },
        -0.8058405177484211,
    ),
    "bounces that stick": (
        {
            "eps_n1": 0.9243117639199719, "eps_n2": 0.4114793071321128,
            "mu_1": 0.1569592949479766, "mu_2": 0.43447550937455964, "mu_3": 0.46196250162079594,
        },
        -0.6271037874776366,
    ),
    "a swing after a series": ({"eps_n2": 0.2}, -1.6164076098983466),
}  # fmt: skip


@pytest.mark.nightly
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("scene", SCENES)
def test_accumulations_agree_with_thirty_digits(scene: str, law: ExpansionFriction) -> None:
    """The reference follows every impact until 22 digits of the speeds are gone."""
    parameters, phi_s = SCENES[scene]
    toy = {**reference_mpmath.PAPER, **parameters, "expansion_friction": law.value}
    exact = reference_mpmath.first_return(phi_s, toy, max_events=1000)
    here = first_return(Toy(**parameters, expansion_friction=law), phi_s)
    assert exact.status == "returned"
    assert here.status is Status.RETURNED
    bound = 1e-12 + 1e-13 * abs(here.slope)  # what the kernel promises everywhere
    assert abs(here.phi_s - exact.phi_s) <= bound
    assert abs(here.period - exact.period) <= bound


def test_both_contacts_close_in_one_symbol() -> None:
    parameters, phi_s = SCENES["in turns"]
    word = first_return(Toy(**parameters), phi_s).word
    assert word.endswith("I1 I3 I1 C1+3 D1 R3 D3 I2 J2")


@pytest.mark.parametrize("name", ["eps_n2", "eps_n3"])
def test_the_map_is_continuous_at_zero_restitution(name: str) -> None:
    """Even where a bounce is slower than the rounding of the speed that it reverses."""
    x, f = -0.5294719666469891, ToyPieces(Toy(), name).at
    at_zero = f(x, 0.0)
    for eps in (1e-17, 1e-16, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6):
        here = f(x, eps)
        # the second derivative is below 100 rad; rounding is some 1e-16
        assert here.value == pytest.approx(
            at_zero.value + here.d_parameter * eps, abs=1e-15 + 1e2 * eps**2
        )
        # derivatives change by some 1e2 rad times eps
        assert here.d_parameter == pytest.approx(at_zero.d_parameter, rel=1e-4)
