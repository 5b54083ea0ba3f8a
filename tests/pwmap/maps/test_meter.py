"""Budgets: counts end a call where they are reached, what is finished is kept, the rest is said."""

import gc
import re
import signal
import time
import weakref
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import analyse as run
from effort import at_most
from processes import SIGNALS, as_from_a_terminal
from sympy import CRootOf, Rational, Symbol

from pwmap import (
    Budget,
    BudgetError,
    Diagram,
    PiecewiseLinearMap,
    attractor_diagram,
    bifurcation_diagram,
    constant_entropy,
    cycles,
    dynamics,
    load_diagram,
    parameter_plane,
    tongues,
    word_family,
)
from pwmap.cli import analysis, screen
from pwmap.cli.interrupts import listen
from pwmap.diagrams import files, tables
from pwmap.diagrams.encoding import to_plain
from pwmap.diagrams.tables import FILES
from pwmap.longrun.entropy.entropies import GapCause
from pwmap.maps import Advance, Meter
from pwmap.maps.budget import cost
from pwmap.plane import plane_raster, with_crises
from pwmap.rotations import rotational_word

SKEW = PiecewiseLinearMap([("a*x + 1", "x <= 0"), ("b*x + 1", "x > 0")])
SPANS = ("1/4", "3/2"), (-5, "-1/2")
TENT = PiecewiseLinearMap([("m*x", "x <= 1/2"), ("m - m*x", "x > 1/2")])
LEVELS = PiecewiseLinearMap([("a*x + m", "x <= 0"), ("b*x + m + l", "x > 0")])
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


# --- Calls ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "call",
    [
        lambda meter: attractor_diagram(TENT, "m", ("4/3", "3/2"), 1, budget=meter),
        lambda meter: constant_entropy(
            SKEW.at({"a": "1/2"}), "b", (-4, -1), samples=12, budget=meter
        ),
    ],
    ids=["attractors", "entropy"],
)
def test_what_a_call_computes_on_the_way_is_not_kept(call: Callable[[Meter], object]) -> None:
    """Whatever it keeps until its end has the meter."""
    meter = Meter(Budget())
    seen = weakref.ref(meter)
    call(meter)
    del meter
    gc.collect()
    assert seen() is None


@pytest.mark.nightly
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


@pytest.mark.nightly
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


@pytest.mark.slow
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


@pytest.mark.slow
@pytest.mark.parametrize("finished", [0, 1])
def test_crises_that_are_stopped_are_counted_by_their_curves(finished: int) -> None:
    """Even if no curve is finished: the columns, which are searched first, were all."""

    def tell(at: Advance) -> None:
        if (at.what, at.done) == ("curves of crises", finished):
            raise KeyboardInterrupt

    plane = parameter_plane(SKEW, "a", "b", *SPANS, (1,))
    budget = Budget(progress=tell, on_interrupt=lambda: None)
    cut = with_crises(plane, 2, columns=2, budget=budget)
    assert re.fullmatch(
        rf"stopped after {finished} of \d+ curves of crises: interrupted", cut.left_out
    )
    assert cut.curves[: len(plane.curves)] == plane.curves


def test_what_is_too_long_is_refused_at_once_with_its_cost() -> None:
    family = word_family(P1L, "L R^n")
    with at_most(100_000):
        with pytest.raises(
            BudgetError, match=r"up to the denominator 1000000 take about 8e\+17 units"
        ):
            tongues(CIRCLE, 10**6)
        with pytest.raises(BudgetError, match=r" take about 8e\+1199 units of work"):
            tongues(CIRCLE, 10**400)  # 4/5 of the cube
        with pytest.raises(
            BudgetError, match=f"has {2**70 + 1} letters, at most 10000 are allowed"
        ):
            family.word(2**70)
        with pytest.raises(BudgetError, match="has 10001 letters, at most 10000 are allowed"):
            family.at(10**4)
        with pytest.raises(BudgetError, match="more than 50000000 units of work are needed"):
            family.at(9_990)


def test_counts_and_orders_of_any_size_are_refused_at_once() -> None:
    large = 10**400
    tent = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
    skew = PiecewiseLinearMap.from_sympy("Piecewise((a*x + 1, x <= 0), (b*x + 1, True))")
    plane = parameter_plane(skew, "a", "b", ("1/4", "3/4"), (-5, "-1/2"))
    for call, message in (
        (
            lambda: plane_raster(plane, large, 1),
            r"400 x 1 points take about 1e\+402 units",
        ),
        (
            lambda: with_crises(plane, columns=large),
            r"400 columns take about 1e\+403 units",
        ),
        (lambda: with_crises(plane, large), r"the iterate of order about 1e\+400 is too large"),
        (
            lambda: attractor_diagram(tent, "a", (1, 2), large),
            r"the iterate of order about 1e\+400",
        ),
        (lambda: rotational_word(Rational(1, large)), r"the letters of"),
        (lambda: dynamics(tent, {"a": "7/5"}).laps(large), r"400 take about 1e\+400 units"),
    ):
        with pytest.raises(BudgetError, match=message):
            call()


@pytest.mark.slow
def test_roots_of_long_polynomials_are_work() -> None:
    """Their degree is the order: factors of one of degree 300 take seconds."""
    tent = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
    refused = pytest.raises(BudgetError, match="more than 100000 units of work are needed")
    with at_most(2_000_000), refused:
        attractor_diagram(tent, "a", ("5/4", "9/4"), 300, budget=Budget(work=100_000))


@pytest.mark.nightly
def test_intervals_with_ends_in_a_number_field_are_work() -> None:
    """Hundreds of them are collected, and each was counted as if its ends were short rationals."""
    pieces = [
        ("1 + 2*p - 2*p*x", "x <= -1 - 2*p"),
        ("1 + p - x", "(x > -1 - 2*p) & (x <= -1/2 - 2*p)"),
        ("p - 1 - (2 + p)*x", "x > -1/2 - 2*p"),
    ]
    t = Symbol("t")
    place = {"p": CRootOf(24 * t**6 + 56 * t**5 + 48 * t**4 - t - 1, 0)}
    with at_most(3_000_000):  # less than 2 million; counted as short ones three times as many
        found = dynamics(PiecewiseLinearMap(pieces), place, budget=Budget(work=2_000_000))
        assert "more than 2000000 units of work are needed" in found.attractors.left_out


@pytest.mark.nightly
def test_tongues_and_families_that_took_minutes() -> None:
    with at_most(800_000):
        found = tongues(CIRCLE, 60)
    assert len(found) == 1103  # 1 + the sum of Euler's function up to 60
    third = next(tongue for tongue in found if tongue.word == "LLR")
    assert (third.lower, third.upper) == (Rational(4, 7), Rational(9, 14))
    skew = PiecewiseLinearMap(
        [("a*x + 1", "x <= 0"), ("b*x + 1", "x > 0")], given=["a > 0", "b < 0"]
    )
    with at_most(12_000_000):
        cycle = word_family(skew, "L^n R").at(300)
    assert len(cycle.word) == 301


@pytest.mark.slow
def test_the_command_keeps_the_diagram_if_the_long_run_is_interrupted(
    tmp_path, monkeypatch
) -> None:  # type: ignore[no-untyped-def]
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(analysis, "attractor_diagram", interrupted)
    text = "Piecewise((m*x, x <= 1/2), (m - m*x, True))"
    code, _ = run(text, "--parameter", "m", "--span", "0", "2", "--attractors", out=tmp_path)
    assert code == 130
    assert (tmp_path / "graph.json").exists()
    assert not (tmp_path / "attractors.csv").exists()
    assert not (tmp_path / "diagram.png").exists()


def test_a_second_interrupt_leaves_a_record_of_what_was_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    said = screen.say

    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    def interrupted_again(sentence: str) -> None:
        if sentence.startswith("left out"):
            raise KeyboardInterrupt
        said(sentence)

    monkeypatch.setattr(analysis, "attractor_diagram", interrupted)
    monkeypatch.setattr(screen, "say", interrupted_again)
    text = "Piecewise((m*x, x <= 1/2), (m - m*x, True))"
    options = ("--parameter", "m", "--span", "0", "2", "--orders", "1", "--attractors")
    code, told = run(text, *options, out=tmp_path)
    assert code == 130
    assert "Interrupted: what was finished is kept, without pictures" in told
    assert {path.name for path in tmp_path.iterdir()} == {*FILES, "about_analyse.json"}


@pytest.mark.nightly
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


def test_an_interrupt_while_an_order_is_put_together_keeps_those_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = list[Diagram]()

    def interrupted(diagram: Diagram) -> dict[str, bytes]:
        made.append(diagram)
        if len(made) == 3:
            raise KeyboardInterrupt
        return results(diagram)

    results = tables.results_as_bytes
    monkeypatch.setattr(analysis, "results_as_bytes", interrupted)
    text = "Piecewise((m*x, x <= 1/2), (m - m*x, True))"
    code, told = run(
        text, "--parameter", "m", "--span", "0", "2", "--orders", "1,2,3", out=tmp_path
    )
    assert code == 130
    assert "stopped after orders 1..2: interrupted" in told
    kept = load_diagram(tmp_path / "diagram.json")
    assert {branch.order for branch in kept.branches} == {1, 2}


@pytest.mark.parametrize("number", SIGNALS)
def test_tables_are_whole_also_if_an_interrupt_comes_while_they_are_written(
    number: signal.Signals, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write, written = files.write_whole, list[Path]()

    def interrupted(path: Path, content: bytes) -> None:
        written.append(path)
        if len(written) == 3:
            signal.raise_signal(number)
        write(path, content)

    monkeypatch.setattr(analysis, "write_whole", interrupted)
    text = "Piecewise((r - 2, x <= 0), (r - 5*x/4, True))"
    usual = {each: signal.getsignal(each) for each in (*SIGNALS, signal.SIGALRM)}
    try:
        as_from_a_terminal()
        listen()
        code, told = run(text, "--parameter", "r", "--span", "-1", "3", out=tmp_path)
    finally:
        for each, handler in usual.items():
            signal.signal(each, handler)
    assert code == 130
    assert "Interrupted: what was finished is kept, without pictures" in told
    assert {path.name for path in tmp_path.iterdir()} == {*FILES, "about_analyse.json"}
    assert load_diagram(tmp_path / "diagram.json").given == ()


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("map_", "parameter", "span", "sample"),
    [
        (TENT, "m", (0, 2), None),
        (P1L, "r", None, None),
        (SKEW, "b", (-5, -1), {"a": "1/2"}),
        (LEVELS, "m", None, {"a": "1/2", "b": "-3/2", "l": "1/3"}),
    ],
    ids=["rational", "column", "column-span", "symbolic"],
)
def test_what_is_put_together_on_the_way_leaves_no_trace(
    map_: PiecewiseLinearMap, parameter: str, span: Any, sample: Any
) -> None:
    """Neither in the diagram of all orders, nor in what it asks of other parameters."""
    whole = bifurcation_diagram(map_, parameter, span, range(1, 5), sample)
    made = list[Diagram]()
    again = bifurcation_diagram(map_, parameter, span, range(1, 5), sample, finished=made.append)
    assert again is made[-1]
    assert to_plain(again) == to_plain(whole)
    for last, diagram in enumerate(made[:-1], start=1):
        short = bifurcation_diagram(map_, parameter, span, range(1, last + 1), sample)
        assert diagram.given == (*short.given, f"stopped after orders {_upto(last)}: interrupted")
        assert to_plain(diagram.branches) == to_plain(short.branches)
        assert to_plain(diagram.points) == to_plain(short.points)


def _upto(last: int) -> str:
    return "1" if last == 1 else f"1..{last}"
