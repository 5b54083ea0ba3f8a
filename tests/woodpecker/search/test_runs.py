"""A search that is interrupted anywhere goes on to the same result; workers do not change it."""

import copy
import json
import math
import multiprocessing
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from diagrams import to_the_last_bit
from maps import Line, one_piece, paper
from needs import NEEDS_NUMBA

from pwmap import Diagram, PiecewiseLinearMap
from woodpecker import (
    FormulaMap,
    PiecewiseMap,
    Search,
    Settings,
    Toy,
    __version__,
    bifurcation_diagram,
    continuation,
    parameters,
    saved_diagram,
    shoot,
)
from woodpecker.base.checkpoint import Entry, line_of
from woodpecker.base.executors import Scheduler
from woodpecker.diagrams import bifurcation_search
from woodpecker.maps.formulas import FormulaPiece
from woodpecker.maps.pieces import Image
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


class Stopped(Record):
    """A record whose run is interrupted after some lines, in the middle of the next."""

    def __init__(self, path: Path, lines: int, *, resume: bool = False) -> None:
        super().__init__(path, ABOUT, resume=resume)
        self._write, self.left = self._file.write, lines
        self._file.write = self.write  # type: ignore[method-assign]

    def write(self, entry: Entry) -> None:
        self.left -= 1
        if self.left < 0:
            with self.path.open("a", encoding="utf-8") as file:
                file.write(json.dumps(entry)[:17])
            raise KeyboardInterrupt
        self._write(entry)


@pytest.mark.nightly
@pytest.mark.parametrize("lines", [1, 3])
def test_a_run_interrupted_at_any_line_goes_on_to_the_same_result(
    lines: int, whole: Found, tmp_path: Path
) -> None:
    """It remembers which slice was new, and looks closer beside it.

    Also if it was stopped between what a slice has shown and the line that says so.
    """
    assert len(whole.diagram.branches) >= 5
    path, stops, resume = tmp_path / "run.jsonl", 0, False
    while True:
        record = Stopped(path, lines, resume=resume)
        try:
            found = searched(record)
        except KeyboardInterrupt:
            stops, resume = stops + 1, True
            continue
        finally:
            record.close()
        break
    written = path.read_bytes().count(b"\n") - 1
    assert stops >= written // lines - 1
    assert to_the_last_bit(found.diagram) == to_the_last_bit(whole.diagram)
    assert [seen[:4] for seen in found.slices] == [seen[:4] for seen in whole.slices]


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


@pytest.mark.parametrize("a", [0.5, 1e8])
def test_a_map_with_the_same_cycles_and_other_slopes_is_another_map(
    a: float, tmp_path: Path
) -> None:
    """The fixed point of p + a(x - p) is p, whatever a is; rounding is multiplied by a."""
    path, search = tmp_path / "run.jsonl", Search(slices=4)
    one, other = (one_piece(Line(s, 1.0 - s).smooth()) for s in (a, 0.5 * a))
    options: dict[str, Any] = {"span": (-1, 1), "window": (-3, 3), "search": search, "run": path}
    bifurcation_diagram(one, "p", **options)
    bifurcation_diagram(one, "p", **options, resume=True)
    with pytest.raises(ValueError, match=OTHER):
        bifurcation_diagram(other, "p", **options, resume=True)


def test_an_exact_map_does_not_go_on_with_the_run_of_another(tmp_path: Path) -> None:
    """Both have one border, at 0, where both jump from p to p - 1: their lines differ."""
    one, other = (
        PiecewiseLinearMap.from_sympy(f"Piecewise((p + x/{a}, x <= 0), (p - 1 + x/{b}, True))")
        for a, b in ((2, 3), (5, 7))
    )
    asked: dict[str, Any] = {"run": tmp_path / "run.jsonl", "search": Search(slices=4)}
    found = bifurcation_diagram(one, "p", (-1, 2), (1,), (-5, 5), **asked)
    again = bifurcation_diagram(one, "p", (-1, 2), (1,), (-5, 5), **asked, resume=True)
    assert to_the_last_bit(again) == to_the_last_bit(found)
    with pytest.raises(ValueError, match=OTHER):
        bifurcation_diagram(other, "p", (-1, 2), (1,), (-5, 5), **asked, resume=True)


def test_a_run_that_found_nothing_does_not_go_on_with_another_map(tmp_path: Path) -> None:
    """x + 4 has no fixed point, and x/2 one."""
    nothing, one = (one_piece(Line(s, 0.0, c).smooth()) for s, c in ((1.0, 4.0), (0.5, 0.0)))
    asked: dict[str, Any] = {"run": tmp_path / "run.jsonl", "search": Search(slices=4)}
    assert not bifurcation_diagram(nothing, "p", (-1, 1), (1,), (-3, 3), **asked).branches
    assert not bifurcation_diagram(
        nothing, "p", (-1, 1), (1,), (-3, 3), **asked, resume=True
    ).branches
    with pytest.raises(ValueError, match=OTHER):
        bifurcation_diagram(one, "p", (-1, 1), (1,), (-3, 3), **asked, resume=True)


def test_a_branch_of_another_map_does_not_go_on(tmp_path: Path) -> None:
    """A window without ends is sampled about the start: 0 is a fixed point of a x for every a."""
    path = tmp_path / "run.jsonl"
    one, other = (one_piece(Line(s, 0.0).smooth()) for s in (0.5, 0.25))
    continuation(one, shoot(one, 0.0, p=0.0), span=(-1, 1), run=path)
    assert continuation(one, shoot(one, 0.0, p=0.0), span=(-1, 1), run=path, resume=True).branches
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
        explorer = Explorer(paper(), Scheduler(Tasks(paper(), SETTINGS)), SETTINGS, (1, 2))
        explorer.resume(wrong, "run.jsonl")
        with pytest.raises(ValueError, match=sentence):
            complete(explorer, SEARCH)


@dataclass(frozen=True)
class Keyed:
    """A map with keys of another type."""

    map: FormulaMap

    def at(self, x: float, p: float) -> Image:
        image = self.map.at(x, p)
        piece = image.piece
        assert isinstance(piece, FormulaPiece)
        return image._replace(piece=KeyedPiece(piece))


@dataclass(frozen=True)
class KeyedPiece:
    """Its piece."""

    piece: FormulaPiece

    @property
    def key(self) -> complex:
        return complex(len(self.piece.word))

    @property
    def word(self) -> str:
        return self.piece.word

    def at(self, x: float, p: float) -> Image:
        return self.piece.at(x, p)._replace(piece=self)

    def cause(self, code: int) -> str:
        return self.piece.cause(code)


def test_keys_that_cannot_be_kept_are_named(tmp_path: Path) -> None:
    map_: PiecewiseMap = Keyed(paper())
    record = Record(tmp_path / "run.jsonl", ABOUT)
    with pytest.raises(
        TypeError, match=r"only if keys of pieces are text, .* of these: \(\(1\+0j\),\)"
    ):
        whole_diagram(map_, SETTINGS, (1,), SEARCH, record=record)
    record.close()


# --- Workers --------------------------------------------------------------------------------------


@pytest.mark.nightly
@pytest.mark.parametrize("workers", [2, 7])
def test_the_number_of_workers_does_not_matter(workers: int, whole: Found) -> None:
    found = searched(workers=workers)
    assert to_the_last_bit(found.diagram) == to_the_last_bit(whole.diagram)
    assert [seen[:4] for seen in found.slices] == [seen[:4] for seen in whole.slices]


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("executor", "workers"),
    [
        (lambda: ThreadPoolExecutor(3), 1),
        (lambda: ThreadPoolExecutor(3), 3),
        pytest.param(
            lambda: ProcessPoolExecutor(2, multiprocessing.get_context("spawn")), 1,
            marks=pytest.mark.slow,
        ),
    ],
)  # fmt: skip
def test_threads_and_processes_do_not_matter(
    executor: Callable[[], Executor], workers: int, whole: Found
) -> None:
    with executor() as others:
        found = searched(workers=workers, executor=others)
        assert others.submit(int).result() == 0  # it was not shut down
    assert to_the_last_bit(found.diagram) == to_the_last_bit(whole.diagram)


@pytest.mark.nightly
def test_maps_of_lambdas_go_to_other_processes() -> None:
    first, second = paper().pieces
    assert isinstance(first, FormulaPiece)
    local = FormulaPiece("R", type(first.map)(lambda x, p: p - 1.25 * x), first.margins)
    map_ = FormulaMap([local, second])
    alone = whole_diagram(map_, SETTINGS, (1,), SEARCH, workers=1)
    shared = whole_diagram(map_, SETTINGS, (1,), SEARCH, workers=2)
    assert to_the_last_bit(shared.diagram) == to_the_last_bit(alone.diagram)
    assert shared.evaluations == alone.evaluations


def test_a_map_that_cannot_be_sent_is_refused() -> None:
    first, second = paper().pieces
    assert isinstance(first, FormulaPiece)
    lock = threading.Lock()
    local = FormulaPiece("R", type(first.map)(lambda x, p: p - x if lock else x), first.margins)
    with pytest.raises(ValueError, match="the map cannot be sent to other processes"):
        whole_diagram(FormulaMap([local, second]), SETTINGS, (1,), SEARCH, workers=2)


# --- The toy --------------------------------------------------------------------------------------

SPAN, WINDOW, FEW = (0.33, 0.4), (-1.2, -0.7), Search(slices=6)


def of_toy(**options: Any) -> Diagram:
    return bifurcation_diagram(Toy(), "eps_n1", SPAN, (1,), WINDOW, search=FEW, **options)


@pytest.mark.nightly
@NEEDS_NUMBA
def test_what_is_saved_is_what_was_found(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    found = of_toy(run=path, workers=1)
    saved = saved_diagram(str(path))
    assert to_the_last_bit(saved) == to_the_last_bit(found)
    assert saved.given == found.given
    assert saved.about == found.about
    assert saved.about["program"] == f"woodpecker-toy {__version__}"
    assert saved.about["span"] == list(SPAN)
    toy: Any = saved.about["toy"]
    assert toy.pop("expansion_friction") == "summed"
    assert set(toy) == set(parameters()) - {"eps_n1"}
    assert {name: float(value) for name, value in toy.items()} == {
        n: getattr(Toy(), n) for n in toy
    }
    assert saved.about["settings"] == {"window": list(WINDOW)}
    assert saved.given[0] == "friction in the expansion: summed"


@pytest.mark.nightly
@NEEDS_NUMBA
def test_a_killed_run_of_the_toy_goes_on(tmp_path: Path) -> None:
    """SIGKILL leaves no time to tidy up; what was finished is there all the same."""
    path = tmp_path / "run.jsonl"
    code = (
        "import rounding\nrounding.apply()\n"
        "from pathlib import Path\nfrom woodpecker import *\n"
        f"bifurcation_diagram(Toy(), 'eps_n1', {SPAN}, (1,), {WINDOW}, "
        f"search=Search(slices=6), run=Path({str(path)!r}))"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code], env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    )
    while process.poll() is None:
        time.sleep(0.05)
        if path.exists() and path.read_bytes().count(b"\n") > 3:
            process.kill()
    process.wait()
    kept = saved_diagram(path)
    assert len(kept.branches) >= 1
    found = of_toy(run=path, resume=True)
    whole = bifurcation_search(Toy(), "eps_n1", SPAN, (1,), WINDOW, search=FEW)
    assert to_the_last_bit(found) == to_the_last_bit(whole.diagram)
    assert whole.evaluations > 1000


CUT: list[dict[str, Any]] = [
    {"parameter": "eps_n1", "span": SPAN, "orders": (1,), "window": WINDOW, "search": FEW},
    {  # a collision with a point outside of the window, from which a branch would lead away
        "parameter": "eps_n1", "span": (0.05, 0.1), "orders": (1, 2), "window": (-1.2, -0.7),
        "search": Search(slices=4),
    },
    {
        "parameter": "mu_2", "span": (0.3, 0.36), "orders": (1, 2), "window": (-0.9, -0.3),
        "search": Search(slices=2),
    },
]  # fmt: skip


@pytest.mark.nightly
@NEEDS_NUMBA
@pytest.mark.parametrize("what", CUT, ids=["island", "outside", "friction"])
def test_a_run_goes_on_from_any_line_to_the_same_bytes(
    what: dict[str, Any], tmp_path: Path
) -> None:
    """Its file and its diagram are those of a run without a break, how well points are known, too.

    Cut in the middle of each line.
    """
    path, part = tmp_path / "run.jsonl", tmp_path / "part.jsonl"
    kept, again = tmp_path / "whole.json", tmp_path / "again.json"
    bifurcation_diagram(Toy(), run=path, workers=1, **what).save(kept)
    lines = path.read_bytes().splitlines(keepends=True)
    assert len(lines) > 10
    for n, line in enumerate(lines):
        part.write_bytes(b"".join(lines[:n]) + line[: len(line) // 2])
        bifurcation_diagram(Toy(), run=part, workers=1, resume=True, **what).save(again)
        assert part.read_bytes() == path.read_bytes()
        assert again.read_bytes() == kept.read_bytes()


@pytest.mark.nightly
@NEEDS_NUMBA
def test_nothing_is_drawn_outside_of_the_window() -> None:
    """A 2-cycle meets the jump at -0.8848; its other point, -1.322, lies outside of the window.

    Of the two jump crossings that meet there one lies inside, and of the other what lies inside.
    """
    found = bifurcation_diagram(Toy(), **CUT[1])
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
