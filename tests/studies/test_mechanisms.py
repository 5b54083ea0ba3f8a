"""Mechanisms are switched off where they are used, and diagrams are told apart."""

from dataclasses import replace
from pkgutil import resolve_name

import pytest
from needs import NEEDS_NUMBA, SLOW_TOY
from short_runs import short_run

from pwmap import Diagram
from studies.common.engine_mechanisms import MECHANISMS
from studies.common.switched_off import Mechanism, SpentError, counted, gives, switched_off
from studies.mechanisms import SAME, are_same, main_job, measured, mechanisms
from woodpecker import Toy
from woodpecker.engine import germs, tracing

ONCE = Mechanism("engine.germs", "least_period", gives(None), "")


def moved(diagram: Diagram, by: float) -> Diagram:
    """A diagram with one special point elsewhere."""
    first, *others = diagram.points
    there = replace(first, parameter=first.parameter + by, interval=None)
    return replace(diagram, points=(there, *others))


def test_a_function_is_replaced_where_it_was_imported() -> None:
    own = germs.least_period
    with switched_off(ONCE):
        assert germs.least_period is tracing.least_period is ONCE.without
    assert germs.least_period is tracing.least_period is own


@pytest.mark.parametrize("mechanism", MECHANISMS, ids=lambda each: str(each.name))
def test_every_mechanism_of_the_table_is_there(mechanism: Mechanism) -> None:
    whole = f"woodpecker.{mechanism.module}.{mechanism.name}"
    own = resolve_name(whole)
    with switched_off(mechanism):
        assert resolve_name(whole) is mechanism.without
    assert resolve_name(whole) is own


@NEEDS_NUMBA
def test_diagrams_are_told_apart() -> None:
    job = main_job(Toy(), (0.45, 0.7))
    with counted(1e6) as calls:
        diagram = job()
    assert calls.count > 100
    assert are_same(diagram, job())
    width = 0.25  # of the span
    assert are_same(diagram, moved(diagram, 0.5 * SAME * width))
    assert not are_same(diagram, moved(diagram, 2.0 * SAME * width))
    with pytest.raises(SpentError), counted(100):
        job()


@NEEDS_NUMBA
def test_a_mechanism_that_matters_is_seen() -> None:
    """Without the kernel's status of a return nothing is followed: all jobs fail."""
    vital = Mechanism("simulation.paths", "status", gives(None), "")
    idle = Mechanism("search.accumulations", "ENDLESS", "", "")
    found = measured([vital, idle], {"job": main_job(Toy(), (0.48, 0.52))})
    one, other = (row["job"] for row in found["without"].values())
    assert (one["verdict"], one["calls"]) == ("fails", None)
    assert (other["verdict"], other["calls"]) == ("same", 1.0)
    table = mechanisms({"mechanisms": found}).splitlines()
    assert table[2] == "| `simulation.paths.status` |  | job | – |"
    assert table[-1].endswith("changes without `search.accumulations.ENDLESS`.")


@SLOW_TOY
def test_the_study_of_mechanisms_runs(tmp_path_factory: pytest.TempPathFactory) -> None:
    results = short_run("mechanisms", tmp_path_factory.mktemp("mechanisms"))
    assert len(results["without"]) == 3
