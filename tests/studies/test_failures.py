"""Where methods fail: what the study measures, how it judges, and the textbook it compares with."""

from decimal import Decimal
from typing import Any

import numpy as np
import pytest
from short_runs import is_picture, kept_run

from studies.failures import newton
from studies.failures.judge import (
    Kind,
    Outcome,
    Truth,
    reach,
    verdict,
)
from studies.failures.methods import kernel, ode
from studies.failures.scenes import (
    STEP,
    exact,
    image_from_end,
    slips_at_once,
    with_lengths,
    with_masses,
)
from studies.peers import reference_mpmath
from woodpecker import Toy, equilibrium, first_return, jam_limit
from woodpecker.base.compiled import COMPILED

TOY = Toy(expansion_friction="separate")  # as in all scenes
WORD = "S2 D2 I3s I1+3 J2"
TRUTH = Truth(Decimal("-0.5"), "S2 D2 I3 I1+3 J2", slope=-2.0, other=-0.7)


@pytest.mark.parametrize(
    ("outcome", "kind", "text"),
    [
        (Outcome(-0.5 + 1e-12, WORD), Kind.EXACT, "exact"),
        (Outcome(-0.5 + 1.3e-12, WORD), Kind.DIGITS, "11 digits"),  # promised: 1.2e-12
        (Outcome(-0.5 + 3e-5, WORD), Kind.DIGITS, "4 digits"),
        (Outcome(-0.5 + 3e-5, "S2 J2"), Kind.WORD, "wrong word, 4 digits"),
        (Outcome(-0.55, WORD), Kind.VALUE, "wrong by 0.05"),
        (Outcome(-0.61, WORD), Kind.SIDE, "wrong side"),  # nearer to the other limit
        (Outcome(None, "", "two events closer than 1e-10 s"), Kind.LOST, "lost: events too close"),
    ],
)
def test_verdict_on_made_up_outcomes(outcome: Outcome, kind: Kind, text: str) -> None:
    judged = verdict(outcome, TRUTH)
    assert (judged.kind, judged.text) == (kind, text)


def test_verdict_measures_the_error_against_the_condition() -> None:
    """An error of 2^-50 at slope -2: eight roundings of 2^-53, times two for the slope."""
    judged = verdict(Outcome(-0.5 + 2.0**-50, WORD), TRUTH)
    assert judged.error == 2.0**-50
    assert judged.roundings == 4.0
    assert judged.allowed == pytest.approx(1e-12 + 2e-13, rel=1e-12, abs=0.0)
    steep = TRUTH._replace(slope=1e6)
    assert verdict(Outcome(-0.5 + 1e-8, WORD), TRUTH).kind is Kind.DIGITS
    assert verdict(Outcome(-0.5 + 1e-8, WORD), steep).kind is Kind.EXACT


def test_verdict_where_there_is_no_return() -> None:
    never, leaves = Truth(None), Truth(None, leaves=True)
    assert verdict(Outcome(None, decided=True), never).kind is Kind.EXACT
    gave_up = verdict(Outcome(None, message="the toy does not return"), never)
    assert (gave_up.kind, gave_up.text) == (Kind.UNDECIDED, "gave up: no return in time")
    assert verdict(Outcome(None, message="the toy does not return"), leaves).kind is Kind.EXACT
    for truth in (never, leaves):
        assert verdict(Outcome(-0.1), truth).kind is Kind.VALUE


def test_verdict_on_impulses_that_are_not_unique() -> None:
    truth = Truth(None, ends=(-0.4, -0.5))
    stated = verdict(Outcome(-0.45, open_impulse=True), truth)
    assert (stated.kind, stated.error) == (Kind.BOUNDED, pytest.approx(0.1, rel=1e-12))
    assert verdict(Outcome(-0.45), truth).kind is Kind.SILENT
    assert verdict(Outcome(-0.39, open_impulse=True), truth).kind is Kind.VALUE
    assert verdict(Outcome(None), truth).kind is Kind.LOST


def test_reach_is_the_end_of_what_is_right() -> None:
    distances = [1e-3, 1e-3, 1e-5, 1e-5, 1e-7, 1e-7]
    assert reach(distances, [True] * 6) == 1e-7
    assert reach(distances, [True, True, True, False, True, True]) == 1e-3  # not 1e-7
    assert reach(distances, [False, *[True] * 5]) is None


def test_the_textbook_passes_a_fold() -> None:
    """Fixed points of x + p - x^2 lie on the parabola p = x^2: the fold at 0 is no obstacle."""
    path = newton.follow(lambda x, p: x + p - x * x, 1.0, 1.0, -1, (-1.0, 1.1), (-1.2, 1.2))
    assert path.x.min() < -0.9
    assert np.abs(path.p - path.x**2).max() < 1e-9  # ten times the accepted residual
    assert path.end == "end of the span or the window"


@pytest.mark.slow
def test_the_reference_does_not_depend_on_its_step() -> None:
    quick, slow = (
        reference_mpmath.first_return(-0.53, reference_mpmath.PAPER, 30, step=step)
        for step in (STEP, reference_mpmath.STEP)
    )
    assert abs(quick.phi_s - slow.phi_s) < 1e-50  # 55 digits are carried
    assert quick.word == slow.word


def test_the_jam_gives_way_at_its_limit() -> None:
    """At the equilibrium, decided to 30 digits; the limit itself is a double, good to 1e-16."""
    rest, limit = equilibrium(Toy()).phi_s, jam_limit(Toy())
    for distance in (1e-6, 1e-14):
        assert slips_at_once(Toy(mu_2=limit - distance), rest)
        assert not slips_at_once(Toy(mu_2=limit + distance), rest)


@pytest.mark.slow
def test_ends_of_the_open_impulse_enclose_the_kernel() -> None:
    ends = sorted(image_from_end(TOY, -0.513, end) for end in (0, 1))
    once = first_return(TOY, -0.513)
    assert ends[0] < once.phi_s < ends[1]
    assert ends[1] - ends[0] == pytest.approx(3.757e-4, rel=1e-3)  # four digits of this study
    with pytest.raises(ValueError, match="not unique"):
        exact(TOY, -0.513)


def test_scaling_by_powers_of_two_leaves_the_image() -> None:
    """All scaled numbers are exact, so only rounding of intermediate results may differ."""
    once = first_return(Toy(), -0.53)
    for change in (with_masses, with_lengths):
        for factor in (2.0**-10, 2.0**10):
            scaled = first_return(change(Toy(), factor), -0.53)
            assert scaled.word == once.word
            assert scaled.phi_s == pytest.approx(once.phi_s, abs=4.0 * 2.0**-53)
    longer = first_return(with_lengths(Toy(), 4.0), -0.53)
    assert longer.period == pytest.approx(2.0 * once.period, rel=1e-14)


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    found, out = kept_run("failures", tmp_path_factory)
    for name in ("failures.png", "failures_distance.png"):
        assert is_picture(out / name)
    return found


def by(results: dict[str, Any], method: str) -> dict[str, dict[str, Any]]:
    return {row["scene"]: row for row in results["rows"] if row["method"] == method}


@pytest.mark.slow
def test_the_kernel_is_exact_in_every_scene(results: dict[str, Any]) -> None:
    rows = by(results, "kernel")
    assert len(rows) == (16 if COMPILED else 15)
    for name, row in rows.items():
        if row["kind"] == Kind.BOUNDED.value:
            assert name in ("open impulse", "pieces at the dips")
            assert 0.0 < row["error"] < 1e-3
            continue
        assert row["kind"] == Kind.EXACT.value, row
        if row["error"] is not None:
            assert row["error"] <= row["allowed"]
            assert row["roundings"] < 100.0  # seen: 17, of some hundred operations
    assert rows["jump A"]["reach"] == 1e-14
    assert results["edges"]["jump A"] == pytest.approx(-0.8847733440, abs=1e-10)
    assert rows["masses /1024"]["image"] == rows["cycle"]["image"]


@pytest.mark.slow
def test_a_solver_of_odes_fails_where_events_meet(results: dict[str, Any]) -> None:
    rows = by(results, "DOP853, rtol 1e-10")
    assert rows["cycle"]["kind"] == Kind.DIGITS.value
    assert rows["jump A"]["reach"] == 1e-3  # of 1e-3 and 1e-14
    assert "closer than" in rows["jump A"]["message"]
    assert rows["chatter 0.009"]["kind"] == Kind.LOST.value
    assert rows["grazing"]["kind"] == Kind.WORD.value  # 1e-6 rad beside it
    # The impact that it misses changes the image like the root of the distance: 1e-3 here.
    assert 1e-5 < rows["grazing"]["error"] < 1e-2
    assert rows["grazes for ever"]["kind"] == Kind.UNDECIDED.value


def test_lsoda_strikes_where_the_sleeve_only_grazes() -> None:
    never = Truth(None, "D2")
    assert verdict(ode("LSODA", 1e-8)(Toy(), -0.05), never).kind is Kind.VALUE
    assert verdict(kernel(Toy(), -0.05), never).text == "decided"


@pytest.mark.slow
@pytest.mark.skipif(not COMPILED, reason="time stepping needs numba")
def test_time_stepping_takes_the_wrong_side_of_a_jump(results: dict[str, Any]) -> None:
    rows = by(results, "Moreau, step 1e-5 s")
    assert rows["cycle"]["kind"] == Kind.DIGITS.value
    assert rows["cycle"]["error"] < 1e-3
    assert not rows["jump A"]["side_right"]
    assert rows["chatter 0.009"]["error"] > 0.1
    assert rows["masses x1024"]["image"] == pytest.approx(rows["cycle"]["image"], abs=1e-12)
    assert rows["lengths x1024"]["kind"] == Kind.LOST.value  # its step is in seconds


@pytest.mark.slow
@pytest.mark.skipif(not COMPILED, reason="continuation needs numba to end in seconds")
def test_continuation_at_a_b_and_c(results: dict[str, Any]) -> None:
    """The project meets the points to ten digits and goes on; the textbook hops or stalls."""
    project, textbook = by(results, "project"), by(results, "textbook")
    for name, kind in (("A", "FF"), ("B", "BC"), ("C", "BC")):
        ours, theirs = project[f"path {name}"], textbook[f"path {name}"]
        assert ours["kind"] == Kind.EXACT.value
        assert ours["error"] < 1e-10
        assert ours["point"] == kind
        assert ours["branches"] == ["fixed-point", "jump"]
        assert project[f"list {name}"]["kind"] == Kind.EXACT.value
        assert theirs["kind"] in (Kind.SIDE.value, Kind.LOST.value)
        assert theirs["end"] == "no convergence with the shortest step"
        assert project[f"shooting {name}"]["shots"]["it"] >= 1
        assert textbook[f"shooting {name}"]["shots"]["it"] < 6
    hop = textbook["path B"]["hop"]
    assert hop[0] > 0.1  # in eps_N1, past B without a word
    assert textbook["path A"]["error"] < 1e-7
