"""The kernel against an independent program with 30 digits, studies/peers/reference_mpmath.py."""

from typing import Any

import pytest
from mpmath import mp
from scenes import plain
from thirty_digits import CASES, EVEN, LAWS, STATES, Case, Kept, read

from studies.peers import reference_mpmath
from woodpecker import Return, Status, Toy, first_return

KEPT = read()
laws = pytest.mark.parametrize("law", LAWS)
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


@laws
def test_states_are_spread(law: str) -> None:
    """Over the window and over eps_N1; half of them and more with an impact at two contacts."""
    mine = [case for case in CASES if case.law == law]
    assert len(mine) >= 30
    assert {round(case.eps_n1) for case in mine} == {0, 1}
    assert min(case.phi_s for case in mine) < -2.3
    assert max(case.phi_s for case in mine) > -0.4
    assert 2 * sum("+" in KEPT[case].word for case in mine) >= len(mine)


def test_both_laws_are_one_where_no_two_contacts_expand_together() -> None:
    """No word with `+`: the same return to the last bit; with `+`: another one."""
    for phi_s, eps_n1, mu in STATES:
        summed, separate = (kernel(Case(law, phi_s, eps_n1, *mu)) for law in LAWS)
        if "+" in separate.word:
            assert abs(summed.phi_s - separate.phi_s) > 1e-6  # seen: from 1e-4 on
        else:
            assert (summed.phi_s, summed.word) == (separate.phi_s, separate.word)


@pytest.mark.nightly
@laws
def test_indeterminate_impulses_are_seen_by_both(law: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The kernel goes on from the middle of the segment, where the reference stops unless told."""
    case = Case(law, -1.7557529808118213, 0.34069658639339057, *EVEN)
    exact, here = case.return_to_thirty_digits(), kernel(case)
    assert "not unique" in exact.status
    assert here.status is Status.RETURNED_INDETERMINATE
    assert "I~1" in here.word
    segment, images = reference_mpmath.sticking_pair, []
    for part in (0.0, 0.5, 1.0):

        def one_point(*arguments: Any, part: float = part) -> Any:
            ends = segment(*arguments)
            return ends and [[x + part * (y - x) for x, y in zip(*ends, strict=True)]] * 2

        monkeypatch.setattr(reference_mpmath, "sticking_pair", one_point)
        exact = case.return_to_thirty_digits()
        assert exact.status == "returned"
        images.append(exact.phi_s)
    assert abs(here.phi_s - images[1]) <= 1e-12 + 1e-13 * abs(here.slope)
    assert sorted(images)[1] == images[1]
    assert 1e-3 < abs(images[2] - images[0]) < 1e-2  # how much the laws leave open
