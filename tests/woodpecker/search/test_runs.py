"""A run that is interrupted anywhere goes on to the same result; workers do not change it."""

import copy
import json
import math
import multiprocessing
import threading
from collections.abc import Callable
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from diagrams import to_the_last_bit
from maps import Line, logistic, one_piece, paper
from needs import NEEDS_NUMBA, SLOW_TOY

from pwmap import Diagram, PiecewiseLinearMap
from woodpecker import (
    FormulaMap,
    FormulaPiece,
    Search,
    Settings,
    Toy,
    bifurcation_diagram,
    continuation,
    saved_diagram,
    shoot,
)
from woodpecker.base.checkpoint import Entry, line_of
from woodpecker.diagrams import bifurcation_search
from woodpecker.search import Found
from woodpecker.search.checkpoint import (
    Finished,
    Kept,
    Record,
    Seen,
    Step,
    entry_of,
    read_record,
    record_of,
    restore,
)
from woodpecker.search.diagrams import whole_diagram
from woodpecker.search.explorer import Explorer
from woodpecker.search.network import Network
from woodpecker.search.search import complete
from woodpecker.search.tasks import Tasks

SEARCH = Search(slices=5, finest=0.05)
SETTINGS = Settings(span=(-1.0, 2.5), window=(-20.0, 20.0))
ABOUT: Entry = {"parameter": "p", "span": [-1.0, 2.5]}

pytestmark = pytest.mark.usefixtures("workers_at_once")


def searched(
    record: Record | None = None, workers: int = 1, executor: Executor | None = None
) -> Found:
    return whole_diagram(
        paper(), SETTINGS, (1, 2), SEARCH, workers=workers, executor=executor, record=record
    )


@pytest.fixture(scope="module")
def whole() -> Found:
    return searched()


# --- Interruptions --------------------------------------------------------------------------------

LOGISTIC = logistic()
OUTSIDE: dict[str, Any] = {  # a collision with a point outside of the window, from which more leads
    "parameter": "eps_n1", "span": (0.05, 0.1), "orders": (1, 2), "window": (-1.2, -0.7),
    "search": Search(slices=4),
}  # fmt: skip


def all_of_the_paper(evaluations: int, **options: Any) -> Diagram:
    settings = Settings(max_evaluations=evaluations)
    return bifurcation_diagram(
        paper(), "p", (-1.0, 2.5), (1, 2), (-20.0, 20.0), search=SEARCH, settings=settings,
        **options,
    )  # fmt: skip


def doubled(source: FormulaMap | Toy, p: float, span: tuple[float, float], **options: Any) -> Any:
    """A cycle, its flip, and what is connected with it."""
    start = shoot(source, 0.6, p=p) if source is LOGISTIC else shoot(source, -0.53)
    return continuation(source, start, span=span, orders=(1, 2), **options)


RUNS: dict[str, Callable[..., Diagram]] = {
    "a search": partial(all_of_the_paper, 10_000),
    "a search that is given up": partial(all_of_the_paper, 50),
    "doubled branches": partial(doubled, LOGISTIC, 2.5, (2.5, 3.4)),
    "a rule": partial(doubled, LOGISTIC, 2.5, (2.5, 3.4), stop=lambda s: s.parameter > 3.2),
    "the toy": partial(doubled, Toy(), 0.5, (0.45, 0.66)),
    "outside": partial(bifurcation_diagram, Toy(), workers=1, **OUTSIDE),
}
MARKS = {name: [pytest.mark.slow] for name in RUNS if "search" in name}
MARKS |= {name: [pytest.mark.slow, NEEDS_NUMBA] for name in ("the toy", "outside")}


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=MARKS.get(name, ())) for name in RUNS],
)
def test_a_run_that_was_interrupted_goes_on_to_the_same(name: str, tmp_path: Path) -> None:
    """Whatever line was being written: its file and its diagram are those of a run without a break.

    A rule to stop is no part of the file and is given again.
    """
    path, part = tmp_path / "run.jsonl", tmp_path / "part.jsonl"
    whole = RUNS[name](run=path)
    assert ("left" in whole.about) == ("given up" in name)
    assert to_the_last_bit(saved_diagram(path)) == to_the_last_bit(whole)
    lines = path.read_bytes().splitlines(keepends=True)
    assert len(lines) > 3
    for n, line in enumerate(lines[1:], 1):
        part.write_bytes(b"".join(lines[:n]) + line[: len(line) // 2])
        again = RUNS[name](run=part, resume=True)
        assert part.read_bytes() == path.read_bytes()
        assert to_the_last_bit(again) == to_the_last_bit(whole)


def recorded(path: Path) -> Found:
    record = Record(path, ABOUT)
    try:
        return searched(record)
    finally:
        record.close()


@pytest.mark.slow
def test_a_run_that_is_complete_asks_the_map_for_nothing_more(whole: Found, tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    first = recorded(path)
    assert first.evaluations == whole.evaluations > 0
    before = path.read_bytes()
    record = Record(path, ABOUT, resume=True)
    again = searched(record)
    record.close()
    assert to_the_last_bit(again.diagram) == to_the_last_bit(first.diagram)
    assert again.slices == first.slices
    assert again.evaluations == 0
    assert path.read_bytes() == before


# --- What a record holds --------------------------------------------------------------------------


@pytest.fixture(scope="module")
def records(tmp_path_factory: pytest.TempPathFactory) -> list[Step | Seen]:
    path = tmp_path_factory.mktemp("runs") / "run.jsonl"
    recorded(path)
    about, found = read_record(path)
    assert about == ABOUT
    return found


@pytest.mark.slow
def test_curves_read_back_to_the_last_bit(whole: Found, records: list[Step | Seen]) -> None:
    network = Network(SETTINGS)
    restore(network, records, "run.jsonl")
    assert to_the_last_bit(network.diagram("p", "x")) == to_the_last_bit(whole.diagram)
    assert tuple(each for each in records if isinstance(each, Seen)) == whole.slices
    assert sum(each.evaluations for each in records) == whole.evaluations
    assert not network.waiting


def of_kind(records: list[Step | Seen], kind: type) -> Entry:
    """The first entry of a kind; of curves one that ends in a collision."""
    return next(
        entry_of(each)
        for each in records
        if isinstance(each, kind)
        and (not isinstance(each, Kept) or any(e.collision for c in each.curves for e in c.ends))
    )


Altered = Callable[[Any], object]


def collided(curve: Any) -> Any:
    return next(end["collision"] for end in curve["ends"] if end["collision"])


@pytest.mark.parametrize(
    ("kind", "change"),
    [
        (Kept, lambda e: collided(e["curves"][0]).pop("precision")),
        (Kept, lambda e: collided(e["curves"][0]).update(x=[])),
        (Kept, lambda e: collided(e["curves"][0]).update(kinds=[])),
        (Kept, lambda e: collided(e["curves"][0]).update(cause=7)),
        (Finished, lambda e: e.update(p="1.0")),
        (Finished, lambda e: e.update(p=None)),
        (Finished, lambda e: e.update(starts=1.5)),
        (Finished, lambda e: e.update(switches=1)),
        (Finished, lambda e: e.pop("evaluations")),
        (Seen, lambda e: e.update(new=[True])),
        (Seen, lambda e: e.update(left=[1.0])),
        (Seen, lambda e: e.update(left=[["a", 1.0]])),
        (Seen, lambda e: e.update(then=["0.5"])),
        (Seen, lambda e: e.pop("unresolved")),
        (Kept, lambda e: e.update(evaluations="7")),
        (Kept, lambda e: e.update(curves=1)),
        (Kept, lambda e: e["curves"][0].update(kind="branch")),
        (Kept, lambda e: e["curves"][0].update(order=1.5)),
        (Kept, lambda e: e["curves"][0].update(order=True)),
        (Kept, lambda e: e["curves"][0].update(parameter=[])),
        (Kept, lambda e: e["curves"][0]["parameter"].pop()),
        (Kept, lambda e: e["curves"][0]["multiplier"].append("1.0")),
        (Kept, lambda e: e["curves"][0].update(points=[1.0])),
        (Kept, lambda e: e["curves"][0]["words"][0].pop("text")),
        (Kept, lambda e: e["curves"][0]["words"][0].update(first="0")),
        (Kept, lambda e: e["curves"][0]["words"][0].update(keys={"$set": 1})),
        (Kept, lambda e: e["curves"][0]["words"][0].update(keys=[{"$bytes": "not base 64!"}])),
        (Kept, lambda e: e["curves"][0]["words"][0].update(keys=[{"other": []}])),
        (Kept, lambda e: e["curves"][0].update(marks=[{"sample": 0, "cause": "", "smooth": "A"}])),
        (Kept, lambda e: e["curves"][0]["ends"].pop()),
        (Kept, lambda e: e["curves"][0]["ends"][0].update(kind="XX")),
        (Kept, lambda e: e["curves"][0]["ends"][0].update(status="somewhere")),
        (Kept, lambda e: e["curves"][0]["ends"][0].update(unknown="")),
    ],
)
def test_entries_that_are_refused(
    kind: type, change: Altered, records: list[Step | Seen], tmp_path: Path
) -> None:
    good = of_kind(records, kind)
    ((name, data),) = entry_of(record_of(good)).items()
    assert {name: data} == good
    bad = copy.deepcopy(good)
    change(bad[name])
    path = tmp_path / "run.jsonl"
    Record(path, ABOUT).close()
    for line in (good, bad):
        written = path.read_bytes()
        digest = json.loads(written.splitlines()[-1])["digest"]
        path.write_bytes(written + line_of(line, digest))
    before = path.read_bytes()
    for call in (lambda: read_record(path), lambda: Record(path, ABOUT, resume=True)):
        with pytest.raises(ValueError, match=r"run\.jsonl, line 3: expected an entry of a run"):
            call()
    assert path.read_bytes() == before


@pytest.mark.parametrize("entry", [{}, {"paths": "jump"}, {"slice": 0.5}])
def test_entries_of_no_kind_are_refused(entry: Entry) -> None:
    with pytest.raises((LookupError, TypeError, ValueError), match=r"'paths'|float|unpack"):
        record_of(entry)


def test_records_follow_from_one_another(records: list[Step | Seen]) -> None:
    with pytest.raises(ValueError, match=r"run\.jsonl, line 2: nothing is left to follow at 0.5"):
        restore(Network(SETTINGS), [Finished(0.5, 0)], "run.jsonl")
    other = [replace(each, p=0.5) if isinstance(each, Finished) else each for each in records]
    with pytest.raises(ValueError, match=r"line \d+: nothing is left to follow at 0.5"):
        restore(Network(SETTINGS), other, "run.jsonl")


OTHER = r"cannot resume .*: there the orbit at \S+, in the unit of x, of map is \["


def line(slope: float, rate: float = 0.0, constant: float = 0.0) -> FormulaMap:
    return one_piece(Line(slope, rate, constant).smooth())


def exact(left: int, right: int) -> PiecewiseLinearMap:
    """With one border, at 0, where all of them jump from p to p - 1."""
    return PiecewiseLinearMap.from_sympy(
        f"Piecewise((p + x/{left}, x <= 0), (p - 1 + x/{right}, True))"
    )


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (line(0.5, 0.5), line(0.25, 0.75)),  # the fixed point of p + a (x - p) is p for all a
        (line(1e8, 1.0 - 1e8), line(5e7, 1.0 - 5e7)),  # rounding is multiplied by the slope
        (exact(2, 3), exact(5, 7)),
        (line(1.0, 0.0, 4.0), line(0.5)),  # without a fixed point, and with one
    ],
    ids=["slopes", "steep", "exact", "nothing found"],
)
def test_a_run_does_not_go_on_with_another_map(one: Any, other: Any, tmp_path: Path) -> None:
    asked: dict[str, Any] = {"run": tmp_path / "run.jsonl", "search": Search(slices=4)}
    found = bifurcation_diagram(one, "p", (-1, 2), (1,), (-5, 5), **asked)
    again = bifurcation_diagram(one, "p", (-1, 2), (1,), (-5, 5), **asked, resume=True)
    assert to_the_last_bit(again) == to_the_last_bit(found)
    with pytest.raises(ValueError, match=OTHER):
        bifurcation_diagram(other, "p", (-1, 2), (1,), (-5, 5), **asked, resume=True)


def test_a_branch_does_not_go_on_with_another_map(tmp_path: Path) -> None:
    """A window without ends is sampled about the start: 0 is a fixed point of a x for every a."""
    path, (one, other) = tmp_path / "run.jsonl", (line(0.5), line(0.25))
    continuation(one, shoot(one, 0.0, p=0.0), span=(-1, 1), run=path)
    with pytest.raises(ValueError, match=OTHER):
        continuation(other, shoot(other, 0.0, p=0.0), span=(-1, 1), run=path, resume=True)


@pytest.mark.parametrize(
    ("there", "now", "same"),
    [
        ([0.5, "lost"], [0.5 + 9e-10, "lost"], True),
        ([0.5], [0.5 + 2e-9], False),
        ([3e8], [3e8 + 0.2], True),
        ([0.5, "lost"], [0.5, "fell"], False),
        ([0.5], [0.5, 0.5], False),
    ],
)
def test_orbits_are_those_of_one_map_but_for_rounding(
    there: list[object], now: list[object], same: bool, tmp_path: Path
) -> None:
    path = tmp_path / "run.jsonl"
    Record(path, {"map": {"f": [0.25], "g": there}}).close()
    run = {"map": {"f": [0.25 + 1e-12], "g": now}}
    if same:
        Record(path, run, resume=True).close()
        return
    with pytest.raises(ValueError, match=r"there g of map is \[.*\], now it is \["):
        Record(path, run, resume=True)


def test_steps_that_a_search_does_not_take_are_refused(records: list[Step | Seen]) -> None:
    """What is taken over must be what this run would have come to."""
    until = next(n for n, each in enumerate(records) if isinstance(each, Seen))
    steps = records[:until]
    assert {type(step) for step in steps} == {Kept, Finished}
    for wrong, sentence in (
        ((Finished(0.5, 0), *steps), "expected a run with one branch more"),
        ((*steps[:1], Finished(0.5, 0)), "expected a run that goes on at"),
    ):
        explorer = Explorer(Tasks.of_line(paper(), SETTINGS), (1, 2))
        explorer.resume(wrong, "run.jsonl")
        with pytest.raises(ValueError, match=sentence):
            complete(explorer, SEARCH)


def pieces_of(map_: FormulaMap) -> list[FormulaPiece]:
    return [piece for piece in map_.pieces if isinstance(piece, FormulaPiece)]


class Keyed(FormulaPiece):
    """A piece with a key of another type."""

    @property
    def key(self) -> Any:
        return complex(len(self.word))


def test_keys_that_cannot_be_kept_are_named(tmp_path: Path) -> None:
    map_ = FormulaMap([Keyed(piece.word, piece.map, piece.margins) for piece in pieces_of(paper())])
    record = Record(tmp_path / "run.jsonl", ABOUT)
    with pytest.raises(
        TypeError, match=r"only if keys of pieces are text, .* of these: \(\(1\+0j\),\)"
    ):
        whole_diagram(map_, SETTINGS, (1,), SEARCH, record=record)
    record.close()


# --- Workers --------------------------------------------------------------------------------------


def of_lambdas(held: object) -> FormulaMap:
    """The map of the paper, of a lambda, which goes where what it holds goes."""
    first, second = pieces_of(paper())
    value = type(first.map)(lambda x, p: p - 1.25 * x if held else x)
    return FormulaMap([FormulaPiece("R", value, first.margins), second])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("executor", "workers"),
    [
        (nullcontext, 2), (nullcontext, 7), (lambda: ThreadPoolExecutor(3), 1),
        (lambda: ThreadPoolExecutor(3), 3),
        (lambda: ProcessPoolExecutor(2, multiprocessing.get_context("spawn")), 1),
    ],
    ids=["2 processes", "7 processes", "threads", "threads and processes", "new processes"],
)  # fmt: skip
def test_who_works_does_not_matter(
    executor: Callable[[], AbstractContextManager[Executor | None]], workers: int
) -> None:
    map_ = of_lambdas(True)
    alone = whole_diagram(map_, SETTINGS, (1, 2), SEARCH, workers=1)
    with executor() as others:
        found = whole_diagram(map_, SETTINGS, (1, 2), SEARCH, workers=workers, executor=others)
        assert others is None or others.submit(int).result() == 0  # it was not shut down
    assert to_the_last_bit(found.diagram) == to_the_last_bit(alone.diagram)
    assert [seen[:4] for seen in found.slices] == [seen[:4] for seen in alone.slices]


def test_a_map_that_cannot_be_sent_is_refused() -> None:
    with pytest.raises(ValueError, match="the map cannot be sent to other processes"):
        whole_diagram(of_lambdas(threading.Lock()), SETTINGS, (1,), SEARCH, workers=2)


# --- The toy --------------------------------------------------------------------------------------


@SLOW_TOY
def test_nothing_is_drawn_outside_of_the_window() -> None:
    """A 2-cycle meets the jump at -0.8848; its other point, -1.322, lies outside of the window.

    Of the two jump crossings that meet there one lies inside, and of the other what lies inside.
    """
    found = bifurcation_diagram(Toy(), **OUTSIDE)
    assert all(len(branch.parameter) > 1 for branch in found.branches)
    assert all(-1.2 <= branch.x.min() <= branch.x.max() <= -0.7 for branch in found.branches)
    (met,) = [point for point in found.points if abs(point.parameter - 0.066941662663) < 1e-9]
    assert (met.kind.name, len(met.branches)) == ("BC", 1)
    assert met.x == pytest.approx(-0.884773344, abs=1e-9)
    (left,) = [point for point in found.points if point.note == "end of the window"]
    assert left.x == pytest.approx(-1.2, abs=1e-12)


@pytest.mark.parametrize(
    "run",
    [
        ABOUT,
        {"parameter": "eps_n1", "toy": {}},
        {"parameter": ["p"], "toy": {"expansion_friction": "summed"}},
        {"parameter": "eps_n1", "toy": {"mu_1": -1.0}, "settings": {}, "span": [0.0, 1.0]},
        {"parameter": "eps_n1", "toy": {}, "settings": {"step": math.nan}, "span": [0.0, 1.0]},
        {"parameter": "eps_n1", "toy": {}, "settings": {}, "span": [1.0, 0.0]},
    ],
)
def test_runs_of_something_else_are_refused(run: Entry, tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    Record(path, run).close()
    with pytest.raises(
        ValueError, match=r"line 1: expected a run of the toy or of a map, got .*'param"
    ):
        saved_diagram(path)
    with pytest.raises(ValueError, match="there is no saved run"):
        saved_diagram(tmp_path / "none.jsonl")


def test_a_run_that_has_not_begun_shows_nothing(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    run = {"parameter": "eps_n1", "toy": {}, "settings": {}, "span": [0.0, 1.0]}
    Record(path, run).close()
    assert saved_diagram(path).branches == ()
    assert np.all(saved_diagram(path).points == ())


# --- Refusals -------------------------------------------------------------------------------------


def continued(run: str, toy: Toy, **options: Any) -> Diagram:
    return continuation(toy, shoot(toy, -0.53), run=run, **options)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (partial(bifurcation_search, Toy(), window=(-math.inf, -0.24)),
         r"needs a finite window, got \(-inf, -0.24\)"),
        (partial(bifurcation_search, Toy(), orders=(True,)),
         "orders must be a whole number of at least 1, got True"),
        (partial(continued, toy=Toy(pole=1.0), parameter="pole", span=(0.01, math.inf)),
         "span must be finite"),
        (partial(continued, toy=Toy(), settings=Settings(window=(-1.0, -0.8))),
         "window must hold the orbit"),
    ],
)  # fmt: skip
def test_a_call_that_is_refused_leaves_an_older_run_as_it_was(
    call: Callable[..., object], sentence: str, tmp_path: Path
) -> None:
    path = tmp_path / "run.jsonl"
    path.write_text("kept\n", encoding="utf-8")
    with pytest.raises(ValueError, match=sentence):
        call(run=str(path))
    assert path.read_text(encoding="utf-8") == "kept\n"
    assert list(tmp_path.iterdir()) == [path]
