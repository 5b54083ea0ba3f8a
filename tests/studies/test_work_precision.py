"""The references are right, and work and precision are measured on the same motion."""

from decimal import Decimal
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from needs import SLOW_TOY
from short_runs import is_picture, short_run

from studies.common.laws import CONTACT_BY_CONTACT
from studies.peers import cases, kernel
from studies.peers.enclosed import first_return_enclosed
from studies.peers.ode import first_return_ode
from studies.peers.peer import LostError
from studies.precision.comparing import ahead, compared, order_of
from studies.precision.measuring import measured
from studies.precision.methods import KERNEL, TWIN
from studies.precision.tasks import FIXED, MAP, Answer, Entry
from woodpecker import Toy, first_return

LAST_DIGITS = Decimal("1e-28")  # thirty digits were asked for; two are left to rounding
ROUNDING = 1e-13  # rad; some spacings of doubles, times slopes up to ten, over twenty events


SLOW = (pytest.param(each, marks=pytest.mark.slow) for each in (cases.CYCLE, cases.TWO_SWINGS))


@pytest.mark.parametrize("scene", [cases.DOUBLE, *SLOW], ids=lambda scene: scene.name)
def test_scenes_are_right_to_thirty_digits(scene: cases.Scene) -> None:
    image, period, word = cases.recomputed(scene)
    assert abs(Decimal(image) - Decimal(scene.image)) < LAST_DIGITS
    assert abs(Decimal(period) - Decimal(scene.period)) < LAST_DIGITS
    assert word == scene.word


@pytest.mark.slow
@pytest.mark.parametrize(
    ("recomputed", "numbers"),
    [
        (cases.recomputed_sample, cases.SAMPLE_IMAGES),
        (cases.recomputed_fixed_point, cases.FIXED_POINT),
    ],
    ids=["sample of the map", "fixed point"],
)
def test_kept_numbers_are_right_to_thirty_digits(recomputed: Any, numbers: Any) -> None:
    for value, known in zip(recomputed(), numbers, strict=True):
        assert abs(Decimal(value) - Decimal(known)) < LAST_DIGITS


@pytest.mark.parametrize(("method", "order"), [("RK45", 5.0), ("DOP853", 8.0), ("Radau", 4.0)])
def test_fixed_steps_converge_with_the_order_of_the_formula(method: str, order: float) -> None:
    """Where an event falls within its step changes the error, so orders scatter by one or so."""
    ladder = []
    for step in (4e-3, 2e-3, 1e-3, 5e-4):
        once = first_return_ode(Toy(), cases.CYCLE.phi_s, method, 1e3, 1e3, step)
        ladder.append((step, cases.distance(once.phi_s, cases.CYCLE.image)))
    line = order_of("cycle", method, "", ladder)
    assert line["expected"] == order
    assert line["fitted"] == pytest.approx(order, abs=1.2)
    assert line["converges"]


def test_an_order_is_the_slope_and_a_plateau_does_not_converge() -> None:
    exact = [(h, 3.0 * h) for h in (1e-3, 1e-4, 1e-5)]
    line = order_of("", "Moreau, theta", "lcp", exact)
    assert line["fitted"] == pytest.approx(1.0, abs=1e-12)
    plateau = [(h, 1e-4 + h) for h in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)]
    assert not order_of("", "Moreau, theta", "lcp", plateau)["converges"]


def row(method: str, error: float | None, cpu: float | None) -> dict[str, Any]:
    return {"method": method, "variant": "", "knob": "rtol", "value": 1e-3, "error": error,
            "cpu": cpu}  # fmt: skip


def test_verdicts_follow_from_the_rows() -> None:
    kernel, twin = row(KERNEL, 1e-16, 1.0), row(TWIN, 0.0, 0.1)
    rough, fine = row("RK45", 1e-2, 0.5), row("DOP853", 1e-7, 3.0)
    rows = [kernel, twin, rough, fine, row("LSODA", None, None)]
    assert ahead(rows)
    lines = compared(rows)
    assert [line["ratio"] for line in lines] == [3.0, 3.0, None, None]
    assert lines[-1]["reason"]
    assert not ahead([*rows, row("Radau", 1e-4, 0.9)])
    assert not ahead([row(KERNEL, 1e-11, 1.0), fine])


@pytest.mark.slow
def test_another_process_runs_the_plain_kernel() -> None:
    with kernel.PlainPython() as other:
        start = cases.DOUBLE.phi_s
        for toy in (Toy(), CONTACT_BY_CONTACT):  # the law goes with the numbers
            arguments = cases.numbers(toy), [start]
            (images, words), seconds = other.ask(
                "studies.peers.kernel:returns", *arguments, count=2
            )
            # the same numbers up to rounding: complex quotients are formed in other ways
            assert images == pytest.approx([first_return(toy, start).phi_s], abs=1e-14)
            assert words == [first_return(toy, start).word]
            assert seconds.cpu > 0.0


def test_every_scene_is_under_the_law_that_all_methods_know() -> None:
    assert {scene.toy.expansion_friction for scene in cases.SCENES} == {"separate"}
    assert cases.numbers(Toy())["expansion_friction"] == "summed"
    image = first_return(Toy(), cases.DOUBLE.phi_s).phi_s
    assert cases.distance(image, cases.DOUBLE.image) > 0.01  # the sum gives another motion


@pytest.mark.parametrize("scene", cases.SCENES, ids=lambda scene: scene.name)
def test_what_is_proved_of_a_scene_is_right(scene: cases.Scene) -> None:
    coarse, fine = (first_return_enclosed(scene.toy, scene.phi_s, bits) for bits in (64, 128))
    # the prover's data are decimals, the reference's the doubles beside them
    for once in (coarse, fine):
        assert cases.distance(once.phi_s, scene.image) <= once.radius + 10 * ROUNDING
        assert cases.same_events(once.word, scene.word)
    assert fine.radius < 1e-25
    assert coarse.radius / fine.radius == pytest.approx(2.0**64, rel=0.5)  # by the balls' rounding


def test_a_return_that_cannot_be_proved_is_lost() -> None:
    with pytest.raises(LostError, match="accumulate"):
        first_return_enclosed(Toy(eps_n1=0.028), -1.567, 128)


@SLOW_TOY
def test_the_study_runs_and_nothing_is_unmarked(tmp_path: Path) -> None:
    results = short_run("work_precision", tmp_path)
    assert is_picture(tmp_path / "work_precision.png")
    assert set(results["tasks"]) == {s.name for s in cases.SCENES} | {MAP, FIXED}
    for task, rows in results["tasks"].items():
        assert rows[0]["method"] == KERNEL
        assert rows[0]["error"] < ROUNDING, task
        assert not rows[0]["scaled"]
        for line in rows:
            assert line["lost"] is None or line["error"] is None
            assert task == MAP or not line["scaled"]
    fitted = [line["fitted"] for line in results["orders"] if line["reason"] is None]
    assert np.isfinite(fitted).all()


def test_a_method_that_gets_lost_is_recorded() -> None:
    peer = partial(first_return_ode, Toy(eps_n1=0.1), -0.7)  # its impacts accumulate
    entry = Entry("RK45", "", "rtol", 1e-6, peer, lambda once: Answer(0.0, True, 1))
    (line,) = measured([entry], 1)
    assert "closer than" in line["lost"]
    assert line["error"] is None
