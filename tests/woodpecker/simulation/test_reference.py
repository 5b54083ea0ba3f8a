"""The kernel against an independent program with 30 digits, studies/peers/reference_mpmath.py."""

import pytest
from mpmath import mp
from scenes import plain
from thirty_digits import CASES, LAWS, STATES, Case, Kept, read

from woodpecker import Return, Status, Toy, first_return

KEPT = read()
cases = pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.law}:{case.phi_s}")


def kernel(case: Case) -> Return:
    """The return with doubles."""
    return first_return(Toy(**case.changes()), case.phi_s)


def test_every_return_is_kept() -> None:
    assert list(KEPT) == CASES


@cases
def test_return_agrees_with_thirty_digits(case: Case) -> None:
    kept, here = KEPT[case], kernel(case)
    assert here.status is Status.RETURNED
    assert plain(here.word) == kept.word
    # the bound the kernel promises: rounding, and what the map itself makes of rounding
    bound = 1e-12 + 1e-13 * abs(here.slope)
    for ours, exact in zip((here.phi_s, here.period, here.drop), kept.numbers(), strict=True):
        assert abs(ours - exact) <= bound


@pytest.mark.nightly
@cases
def test_thirty_digits_computed_anew(case: Case) -> None:
    """The program works with more digits than it shows: its last one may be rounded otherwise."""
    kept, anew = KEPT[case], Kept.of(case.return_to_thirty_digits())
    assert kept.word == anew.word
    with mp.workdps(35):
        for old, new in zip(kept.numbers(), anew.numbers(), strict=True):
            assert abs(old - new) <= 1e-29


def test_both_laws_are_one_where_no_two_contacts_expand_together() -> None:
    """No word with `+`: the same return to the last bit; with `+`: another one."""
    for phi_s, eps_n1, mu in STATES:
        summed, separate = (kernel(Case(law, phi_s, eps_n1, *mu)) for law in LAWS)
        if "+" in separate.word:
            assert abs(summed.phi_s - separate.phi_s) > 1e-6  # seen: from 1e-4 on
        else:
            assert (summed.phi_s, summed.word) == (separate.phi_s, separate.word)
