"""Budgets: counts end a call where they are reached, what is finished is kept, the rest is said."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from sympy import Rational
from test_pwmap_cli import run

from pwmap import (
    Advance,
    Budget,
    BudgetError,
    Meter,
    PiecewiseLinearMap,
    attractor_diagram,
    bifurcation_diagram,
    cli_longrun,
    constant_entropy,
    cycles,
    parameter_plane,
    plane_raster,
    tongues,
    word_family,
)
from pwmap.longrun.constant import GapCause
from pwmap.maps.budget import cost

SKEW = PiecewiseLinearMap([("a*x + 1", "x <= 0"), ("b*x + 1", "x > 0")])
SPANS = ("1/4", "3/2"), (-5, "-1/2")
TENT = PiecewiseLinearMap([("m*x", "x <= 1/2"), ("m - m*x", "x > 1/2")])
P1L = PiecewiseLinearMap([("r - 2", "x <= 0"), ("r - a*x", "x > 0")], given=["a > 1"])
CIRCLE = PiecewiseLinearMap([("x/2 + d", "x < 2 - 2*d"), ("x/2 + d - 1", "x >= 2 - 2*d")])


def interrupting(done: int) -> Budget:
    """A budget under which Ctrl-C is pressed when so many parts are done, and keeps them."""

    def tell(at: Advance) -> None:
        if at.done == done:
            raise KeyboardInterrupt

    return Budget(progress=tell, on_interrupt=lambda: None)


# --- The meter ------------------------------------------------------------------------------------


def test_long_numbers_cost_more_and_never_less() -> None:
    costs = [cost(2**n) for n in range(20)]
    assert costs[:7] == [1] * 7
    assert costs == sorted(costs)
    assert costs[19] == 1 + 2**19 // 128 + 2**20


def test_loops_within_each_other_are_told_by_the_outermost() -> None:
    told: list[Advance] = []
    meter, rows = Meter(Budget(work=100, progress=told.append)), list[list[int]]()
    with meter.keeping(rows):
        for row in meter.each(range(5), "rows"):
            numbers = list[int]()
            with meter.keeping(numbers):
                for n in meter.each(range(6), "numbers"):
                    meter.spend(4 + row)
                    numbers.append(n)
            rows.append(numbers)
    assert [len(row) for row in rows] == [6, 6, 6, 1]  # 24 + 30 + 36, and 7 of the next 42
    assert meter.left_out == "stopped after 4 of 5 rows: more than 100 units of work are needed"
    assert {at.what for at in told[1:]} == {"rows"}
    assert [at.work for at in told if at.done] == [24, 54, 90, 104]
    with pytest.raises(BudgetError):  # whatever shares it ends, too
        meter.spend(0)


def test_an_interrupt_is_raised_unless_it_is_to_keep_something() -> None:
    kept = list[int]()

    def loop(budget: Budget) -> Meter:
        meter = Meter(budget)
        kept.clear()
        with meter.keeping(kept):
            for n in meter.each([1, 2, 3], "numbers"):
                if n == 3:
                    raise KeyboardInterrupt
                kept.append(n)
        return meter

    with pytest.raises(KeyboardInterrupt):
        loop(Budget())
    called = list[bool]()
    meter = loop(Budget(on_interrupt=lambda: called.append(True)))
    assert (kept, called) == ([1, 2], [True])
    assert meter.left_out == "stopped after 2 of 3 numbers: interrupted"


def test_seconds_are_an_option() -> None:
    meter, found = Meter(Budget(seconds=1e-9)), [0]
    time.sleep(0.01)
    with meter.keeping(found):
        meter.spend(1)
    assert meter.left_out.endswith("more than 1e-09 seconds are needed")


@pytest.mark.parametrize("limits", [{"work": 0}, {"pieces": 1.5}, {"letters": -1}, {"seconds": 0}])
def test_limits_are_positive(limits: dict[str, float]) -> None:
    (name, value), *_ = limits.items()
    with pytest.raises(ValueError, match=f"{name} of a budget must be .*, got {value}"):
        Budget(**limits)  # type: ignore[arg-type]


# --- Calls ----------------------------------------------------------------------------------------


def test_diagrams_and_cycles_stop_at_the_same_work_everywhere() -> None:
    cut = bifurcation_diagram(TENT, "m", (0, 2), range(1, 30), budget=Budget(work=50_000))
    (sentence,) = cut.given
    assert sentence.endswith(": more than 50000 units of work are needed")
    last = max(branch.order for branch in cut.branches)
    assert sentence.startswith(f"stopped after orders 1..{last}")
    whole = bifurcation_diagram(TENT, "m", (0, 2), range(1, last + 1))
    assert [b.exact for b in cut.branches] == [b.exact for b in whole.branches]
    found = cycles(TENT, {"m": "7/4"}, 60, budget=Budget(work=50_000))
    assert found.left_out == (
        f"stopped after period {found.order}: more than 50000 units of work are needed"
    )
    assert found.left_out in repr(found)
    assert [c.word for c in found] == [c.word for c in cycles(TENT, {"m": "7/4"}, found.order)]


def test_the_budget_takes_an_interrupt_as_its_arguments_do() -> None:
    cut = bifurcation_diagram(TENT, "m", (0, 2), range(1, 9), budget=interrupting(3))
    assert cut.given == ("stopped after orders 1..3: interrupted",)
    found = cycles(TENT, {"m": 2}, 30, budget=interrupting(4))
    assert found.left_out == f"stopped after period {found.order}: interrupted"


def test_a_plane_that_is_stopped_is_a_smaller_one() -> None:
    """Its curves and points are those of the rectangle up to where it ends."""
    whole = parameter_plane(SKEW, "a", "b", *SPANS, (1, 2, 3))
    ends = set[object]()
    for work in range(20_000, 50_000, 3_000):
        try:
            plane = parameter_plane(SKEW, "a", "b", *SPANS, (1, 2, 3), budget=Budget(work=work))
        except BudgetError:
            continue
        low, high = plane.across_span
        ends.add(high)
        if plane.left_out:
            assert plane.left_out == (
                f"stopped at a = {high}: more than {work} units of work are needed"
            )
            assert plane.left_out in repr(plane)
            again = parameter_plane(SKEW, "a", "b", (low, high), SPANS[1], (1, 2, 3))
            assert {(c.kind, c.words, c.polynomial) for c in plane.curves} == {
                (c.kind, c.words, c.polynomial) for c in again.curves
            }
            assert [(p.kind, p.curves) for p in plane.points] == [
                (p.kind, p.curves) for p in again.points
            ]
        else:
            assert len(plane.curves) == len(whole.curves)
    assert len(ends) >= 2


def test_a_raster_that_is_stopped_has_open_columns() -> None:
    plane = parameter_plane(SKEW, "a", "b", *SPANS, (1,))
    whole = plane_raster(plane, 4, 3)
    assert (whole.left_out, repr(whole)) == (
        "",
        f"PlaneRaster(4 x 3 points, {whole.open.sum()} open)",
    )
    cut = plane_raster(plane, 4, 3, budget=interrupting(2))
    assert cut.left_out == "stopped after 2 of 4 columns: interrupted"
    assert cut.open[:, 2:].all()
    for name in ("periods", "bands", "entropy", "open"):
        assert np.array_equal(getattr(cut, name)[:, :2], getattr(whole, name)[:, :2])
    with pytest.raises(BudgetError):
        plane_raster(plane, 4, 3, budget=Budget(work=10))


def test_what_is_too_long_is_refused_at_once_with_its_cost() -> None:
    began = time.process_time()
    with pytest.raises(BudgetError, match=r"up to the denominator 1000000 take about 8e\+17 units"):
        tongues(CIRCLE, 10**6)
    family = word_family(P1L, "L R^n")
    with pytest.raises(BudgetError, match="has 10001 letters, at most 10000 are allowed"):
        family.at(10**4)
    with pytest.raises(BudgetError, match="more than 50000000 units of work are needed"):
        family.at(9_990)
    assert time.process_time() - began < 2.0


def test_tongues_and_families_that_took_minutes() -> None:
    began = time.process_time()
    found = tongues(CIRCLE, 60)
    assert len(found) == 1103  # 1 + the sum of Euler's function up to 60
    third = next(tongue for tongue in found if tongue.word == "LLR")
    assert (third.lower, third.upper) == (Rational(4, 7), Rational(9, 14))
    skew = PiecewiseLinearMap(
        [("a*x + 1", "x <= 0"), ("b*x + 1", "x > 0")], given=["a > 0", "b < 0"]
    )
    cycle = word_family(skew, "L^n R").at(300)
    assert len(cycle.word) == 301
    assert time.process_time() - began < 10.0  # 0.1 s and 0.2 s; the family took 28 s


@pytest.mark.slow
def test_the_command_keeps_the_diagram_if_the_long_run_is_interrupted(
    tmp_path, monkeypatch
) -> None:  # type: ignore[no-untyped-def]
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(cli_longrun, "attractor_diagram", interrupted)
    text = "Piecewise((m*x, x <= 1/2), (m - m*x, True))"
    code, _ = run(text, "--parameter", "m", "--span", "0", "2", "--attractors", out=tmp_path)
    assert code == 130
    assert (tmp_path / "graph.json").exists()
    assert not (tmp_path / "attractors.csv").exists()
    assert not (tmp_path / "diagram.png").exists()


def test_intervals_of_constant_entropy_are_kept_when_an_interrupt_or_a_limit_ends_the_search() -> (
    None
):
    skew = PiecewiseLinearMap([("x/2 + 1", "x <= 0"), ("b*x + 1", "x > 0")])
    whole = constant_entropy(skew, "b", (-6, -1), samples=20)
    some = constant_entropy(skew, "b", (-6, -1), samples=20, budget=interrupting(10))
    assert 0.0 < some.share <= whole.share
    assert any(GapCause.BUDGET in gap.causes for gap in some.gaps)
    for work in (2000, 5000, 20_000):
        cut = constant_entropy(skew, "b", (-6, -1), samples=20, budget=Budget(work=work))
        assert cut.share <= whole.share


@pytest.mark.parametrize("parts", [1, 3, 6])
def test_attractors_are_kept_wherever_an_interrupt_comes(parts: int) -> None:
    found = attractor_diagram(TENT, "m", (0, 2), 2, budget=interrupting(parts))
    assert found.left_out == f"stopped after {parts} of 16 parts of the interval: interrupted"
    assert found.cells[-1].is_open
    assert found.cells[-1].upper == 2
    known = [cell for cell in found.cells if not cell.is_open]
    assert all(cell.upper <= Rational(parts, 8) for cell in known)
    assert all(one.upper == other.lower for one, other in pairwise(found.cells))


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT to another process")
def test_a_command_with_many_orders_ends_soon_after_an_interrupt(tmp_path: Path) -> None:
    """The orders that are kept are written, pictures are not."""
    text = "Piecewise((m*x, x <= 1/2), (m - m*x, True))"
    orders = ",".join(map(str, range(1, 15)))
    command = subprocess.Popen(
        [sys.executable, "-m", "pwmap", "analyse", text, "--parameter", "m", "--span", "0", "2",
         "--orders", orders, "--pieces", str(10**9), "--out", str(tmp_path)],
        stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    time.sleep(5.0)
    command.send_signal(signal.SIGINT)
    told, _ = command.communicate(timeout=60.0)  # before, it took longer with pictures alone
    assert command.returncode == 130
    assert "interrupted" in told
    assert (tmp_path / "graph.json").exists()
    assert not list(tmp_path.glob("*.png"))
