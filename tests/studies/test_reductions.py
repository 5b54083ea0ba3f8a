"""Each reduction does the same work as what it is compared with."""

from pathlib import Path

import numpy as np
import pytest
from needs import SLOW_TOY
from short_runs import is_picture, short_run

from studies.common.laws import CONTACT_BY_CONTACT, LAWS, SUMMED, TOYS
from studies.common.motion import GUESS
from studies.peers import cases
from studies.reductions import events
from studies.reductions.closed_form import apart, closed, integrated
from studies.reductions.contact_problems import direct, lemke
from studies.reductions.motions import Impacts, Phase, beside_edges, gathered, recorded
from studies.reductions.shooting import land, shoot_five, shoot_one
from woodpecker import ExpansionFriction, Toy
from woodpecker.mechanics.modes import SECTION, model

STARTS = np.array([cases.CYCLE.phi_s, cases.DOUBLE.phi_s, cases.TWO_SWINGS.phi_s])


@pytest.fixture(scope="module")
def motion() -> tuple[list[Phase], Impacts]:
    return recorded(CONTACT_BY_CONTACT, STARTS)  # the law of the scenes


def test_phases_add_up_to_the_periods(motion: tuple[list[Phase], Impacts]) -> None:
    phases, impacts = motion
    known = sum(float(scene.period) for scene in cases.SCENES)
    assert sum(p.time for p in phases) == pytest.approx(known, abs=1e-13)  # rounding of 30 times
    assert sum(p.guard == SECTION for p in phases) == 3
    words = " ".join(scene.word for scene in cases.SCENES).split()
    assert (impacts.size == 2).sum() == 2 * words.count("I1+3")  # compression and expansion
    strikes = sum(symbol.startswith("I") for symbol in words)
    beak = sum(symbol.startswith("I1") for symbol in words)  # alone has restitution
    assert len(impacts.size) == strikes + beak


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_both_contact_solvers_agree(law: ExpansionFriction) -> None:
    _, impacts = recorded(TOYS[law], STARTS)
    assert impacts.coupling.any() == (law is SUMMED)
    one, two = direct(impacts), lemke(impacts)
    scale = np.abs(two).max(axis=1, keepdims=True)
    assert one.any()
    assert np.all(np.abs(one - two) <= 1e-9 * scale)  # rounding times condition 1e5, see lcp.py
    assert np.all(one[:, 0] >= impacts.floor[:, 0])


@pytest.mark.slow
def test_order_eight_converges_to_the_closed_form(
    motion: tuple[list[Phase], Impacts],
) -> None:
    """Twice the steps, 2^8 times less: within 2^7..2^9, for the next order is still felt."""
    smooth = gathered(Toy(), motion[0])
    exact = closed(smooth)
    coarse, fine = (apart(exact, integrated(smooth, n)) for n in (120, 240))
    assert 2.0**7 < coarse / fine < 2.0**9


def test_five_unknowns_find_what_one_does() -> None:
    one, five = shoot_one(Toy(), GUESS), shoot_five(Toy(), GUESS)
    assert cases.distance(one.z[1], cases.FIXED_POINT.phi_s) < 1e-12  # where Newton stops
    assert cases.distance(five.z[1], cases.FIXED_POINT.phi_s) < 1e-12
    assert cases.distance(one.jacobian[0, 0], cases.FIXED_POINT.multiplier) < 1e-12
    values = sorted(np.linalg.eigvals(five.jacobian), key=abs, reverse=True)
    # the quotient over 1e-7 rad errs by 1e-7 P''/2, and P'' is about ten
    assert values[0] == pytest.approx(float(cases.FIXED_POINT.multiplier), abs=1e-5)
    assert np.abs(values[1:]).max() < 1e-12


def test_a_disturbed_start_is_followed_to_its_real_return() -> None:
    """A slip of 1e-7 m/s at the start ends at once and changes the image by as little."""
    table = model(Toy())
    z = np.array([-Toy().phi_m_max, cases.CYCLE.phi_s, 0.0, 0.0, 0.0])
    image = land(table, z)
    assert cases.distance(image[1], cases.CYCLE.image) < 1e-13
    slipping = land(table, z + 1e-7 * np.eye(5)[2])
    assert 0.0 < abs(slipping[1] - image[1]) < 1e-5


@pytest.mark.slow
def test_dense_sampling_finds_the_events_that_isolation_finds(
    motion: tuple[list[Phase], Impacts],
) -> None:
    phases, _ = motion
    smooth = gathered(Toy(), phases)
    assert events.wrong(phases, *events.isolated(smooth)) == 0
    assert events.wrong(phases, *events.sampled(smooth, 1e-5)) == 0
    assert events.wrong(phases, *events.sampled(smooth, 0.05)) > 0  # longer than a swing


@SLOW_TOY
def test_sampling_misses_what_isolation_finds_next_to_grazing() -> None:
    near = beside_edges(events.GRAZED, np.linspace(-2.5, -0.24, 20))
    phases = [p for p in recorded(events.GRAZED, near)[0] if p.time < events.LONGEST]
    smooth = gathered(events.GRAZED, phases)
    assert events.wrong(phases, *events.isolated(smooth)) == 0
    dip = events.shortest_dip(smooth.table, phases)
    assert dip < 1e-3
    coarse, fine = (events.wrong(phases, *events.sampled(smooth, h)) for h in (1e-3, 1e-5))
    assert coarse > fine


@pytest.mark.slow
def test_the_study_runs(tmp_path: Path) -> None:
    results = short_run("reductions", tmp_path)
    assert is_picture(tmp_path / "reductions.png")
    assert results["contacts"]["unsolved_by_lemke"] == 0
    assert results["events"]["isolated_missed"] == 0
    assert all(row["ratio"] > 0.0 for row in results["ratios"])
    for row in results["ratios"]:
        assert f"{row['ratio']:.2g}" in results["text"]
