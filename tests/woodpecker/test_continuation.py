"""What is connected with the toy's stable motion: the paper's points, words, refusals, runs."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from needs import SLOW_TOY
from same import differences
from toy_points import POINTS

from pwmap.diagrams.diagram import BranchKind, Diagram, PointKind, PointStatus, SpecialPoint
from woodpecker.base.checkpoint import line_of
from woodpecker.base.settings import Settings
from woodpecker.diagrams import continuation
from woodpecker.mechanics.toy import WINDOW, Toy
from woodpecker.runs import DEFAULT, saved_diagram, settings_of, subject
from woodpecker.search.checkpoint import Record, entry_of, read_record
from woodpecker.search.explorer import Stage
from woodpecker.shooting import PeriodicOrbit, shoot
from woodpecker.simulation.returns import first_return

FIXED, JUMP = BranchKind.FIXED_POINT, BranchKind.JUMP
DIGITS = 1e-10  # of the reference values; points are located to 1e-13
AT_ONCE = "the beak and the upper sleeve strike at once"


@pytest.fixture(scope="module")
def motion() -> PeriodicOrbit:
    return shoot(Toy(), -0.53)


@pytest.fixture(scope="module")
def toy_diagram(motion: PeriodicOrbit) -> Diagram:
    """Everything that is connected with the stable motion, over eps_n1 in (0, 1)."""
    return continuation(Toy(), motion)


@pytest.fixture(scope="module")
def separate_diagram() -> Diagram:
    """The same with Coulomb's law contact by contact in the expansion at two contacts."""
    toy = Toy(expansion_friction="separate")
    return continuation(toy, shoot(toy, -0.53))


def near(diagram: Diagram, kind: PointKind, parameter: float, x: float = math.nan) -> SpecialPoint:
    """The one special point of this kind there."""
    found = [
        point
        for point in diagram.points
        if point.kind is kind
        and abs(point.parameter - parameter) <= DIGITS
        and (math.isnan(x) or abs(point.x - x) <= DIGITS)
    ]
    assert len(found) == 1, found
    return found[0]


def branches_at(diagram: Diagram, point: SpecialPoint) -> list[str]:
    return sorted(diagram.branch(name).kind.value for name in point.branches)


FLIP = 0.6485492002
SPECIAL = {  # C, the other end of C's jump, A, B: as (kind, eps_n1, phi_s)
    fixture: [
        (PointKind(POINTS[law][name].code), *POINTS[law][name][2:])
        for name in ("C", "end of the branch from A", "A", "B")
    ]
    for fixture, law in (("toy_diagram", "summed"), ("separate_diagram", "separate"))
}
both_laws = pytest.mark.parametrize("law", SPECIAL)


@SLOW_TOY
@both_laws
def test_special_points(law: str, request: pytest.FixtureRequest) -> None:
    """Points A, B, C of the paper, and the other end of the jump branch that starts at C."""
    diagram: Diagram = request.getfixturevalue(law)
    c, other, a, b = (near(diagram, *place) for place in SPECIAL[law])
    for point in (a, b, c, other):
        assert branches_at(diagram, point) == ["fixed-point", "jump"]
        assert point.cause == AT_ONCE
        assert point.status is PointStatus.LOCATED
        assert point.interval is not None
        assert point.interval[0] < point.parameter < point.interval[1]
        assert point.precision < 1e-12
    flip = near(diagram, PointKind.PD, FLIP)
    assert branches_at(diagram, flip) == ["fixed-point"] * 2
    assert flip.cause == "the multiplier is -1"
    ends = [point for point in diagram.points if point.kind is PointKind.EP]
    at_ends = {point.parameter for point in ends if point.note == "end of the parameter span"}
    assert at_ends == ({1.0, 0.0} if law == "toy_diagram" else {1.0})
    assert {p.precision for p in ends if p.parameter in at_ends} == {0.0}
    (branch,) = (each for each in map(diagram.branch, a.branches) if each.kind is FIXED)
    slope = branch.multiplier[0 if branch.ends[0] == a.id else -1]  # 5/4 in the paper's example
    assert slope == pytest.approx(-1.30491 if law == "toy_diagram" else -1.26515, abs=5.1e-6)
    assert b.x == pytest.approx(a.x, abs=1e-12)
    assert other.x == pytest.approx(c.x, abs=1e-12)
    if law == "toy_diagram":
        assert {point.note for point in (a, b, c, other)} == {"fold"}
        for parameter in (0.0123065177, 0.0453257415, 0.7911249391):
            end = near(diagram, PointKind.BC, parameter)
            assert (end.note, end.cause) == ("persistence", AT_ONCE)


@SLOW_TOY
@both_laws
def test_from_c_to_b(law: str, request: pytest.FixtureRequest) -> None:
    """The stable branch, C, a jump, a fixed point, A, a jump, B: in this order, one branch each."""
    diagram: Diagram = request.getfixturevalue(law)
    flip = near(diagram, PointKind.PD, FLIP).id
    c, other, a, b = (near(diagram, *place).id for place in SPECIAL[law])
    for first, last, kind in (
        (flip, c, FIXED), (c, other, JUMP), (other, a, FIXED), (a, b, JUMP),
    ):  # fmt: skip
        between = [x for x in diagram.branches if set(x.ends) == {first, last}]
        assert [branch.kind for branch in between] == [kind]


@SLOW_TOY
def test_samples_are_motions_of_the_toy(toy_diagram: Diagram) -> None:
    """Samples inside stretches: the searching kernel returns to them, with their word and slope."""
    rng, count = np.random.default_rng(5), 0
    for branch in toy_diagram.branches:
        if branch.kind is not FIXED:
            continue
        firsts = [stretch.first for stretch in branch.words]
        beside = {k + side for k in firsts for side in (-2, -1, 0, 1)} | {len(branch) - 1}
        inner = [k for k in range(len(branch)) if k not in beside]
        for k in rng.choice(inner, min(8, len(inner)), replace=False).tolist():
            p, x = float(branch.parameter[k]), float(branch.x[k])
            back = first_return(Toy(eps_n1=p), x)
            # rounding of a return of slope m is some 20 spacings of doubles times m
            assert back.phi_s == pytest.approx(x, abs=1e-14 * (1.0 + abs(back.slope)))
            assert back.word == branch.word_at(k)
            assert back.slope == pytest.approx(branch.multiplier[k], rel=1e-6, abs=1e-8)
            count += 1
    assert count > 30


@SLOW_TOY
def test_jumps_cross_the_diagonal(toy_diagram: Diagram) -> None:
    """1e-12 beside the jump the map lies strictly across the diagonal."""
    count = 0
    for branch in toy_diagram.branches:
        # the samples next to a special point may lie where words are thinner than 1e-12
        for k in range(2, len(branch) - 2, 5) if branch.kind is JUMP else ():
            p, x = float(branch.parameter[k]), float(branch.x[k])
            sides = [first_return(Toy(eps_n1=p), x + shift).phi_s for shift in (-1e-12, 1e-12)]
            assert (sides[0] - x) * (sides[1] - x) < 0.0
            assert abs(sides[0] - sides[1]) > 1e-6  # more than a square root makes of 1e-12
            count += 1
    assert count > 20


@SLOW_TOY
def test_flips_have_their_multiplier_and_change_stability(toy_diagram: Diagram) -> None:
    flips = [point for point in toy_diagram.points if point.kind is PointKind.PD]
    assert len(flips) == 3
    for point in flips:
        for branch in map(toy_diagram.branch, point.branches):
            k = 0 if branch.ends[0] == point.id else -1
            assert branch.multiplier[k] == pytest.approx(-1.0, abs=1e-7)
    before, beyond = (
        toy_diagram.branch(name)
        for name in sorted(
            near(toy_diagram, PointKind.PD, FLIP).branches,
            key=lambda name: float(toy_diagram.branch(name).parameter.mean()),
        )
    )
    assert before.stable[1:-1].all()
    assert not beyond.stable[1:-1].any()


# --- Other parameters -----------------------------------------------------------------------------


def test_over_the_mass(motion: PeriodicOrbit) -> None:
    """A smooth branch: both ends of the span, and solutions of the changed toys."""
    found = continuation(Toy(), motion, "m_s", (0.0044, 0.0046))
    assert [str(point.kind) for point in found.points] == ["EP", "EP"]
    (branch,) = found.branches
    assert (branch.parameter.min(), branch.parameter.max()) == (0.0044, 0.0046)
    for p, x in ((branch.parameter[k], branch.x[k]) for k in (0, -1)):
        again = shoot(Toy(m_s=float(p)), float(x))
        assert again.phi_s == pytest.approx(float(x), abs=1e-11)


@pytest.mark.parametrize("parameter", ["eps_n2", "eps_n3"])
def test_over_a_restitution_from_zero(motion: PeriodicOrbit, parameter: str) -> None:
    """The motion lives on for eps > 0: small bounces, the same orbit in the limit."""
    solution = shoot(Toy(**{parameter: 0.004}), motion.phi_s)
    assert solution.success
    found = continuation(Toy(), motion, parameter, (0.0, 0.004))
    assert max(branch.parameter.max() for branch in found.branches) == 0.004
    last = max(found.branches, key=lambda branch: float(branch.parameter.max()))
    assert last.x[np.argmax(last.parameter)] == pytest.approx(solution.phi_s, abs=1e-10)


def test_where_the_toy_ends_the_reason_is_said(motion: PeriodicOrbit) -> None:
    """A restitution lies in [0, 1]."""
    found = continuation(Toy(), motion, span=(0.45, 1.5))
    end = max(found.points, key=lambda point: point.parameter)
    assert (end.kind, end.parameter, end.precision) == (PointKind.EP, 1.0, 0.0)
    assert end.note == "end of the values that the parameter can have"
    assert end.cause == "eps_n1 must lie in [0, 1], got 1.5"
    other = min(found.points, key=lambda point: point.parameter)
    assert (other.parameter, other.note) == (0.45, "end of the parameter span")


# --- Runs that are kept ---------------------------------------------------------------------------

SPAN = (0.1, 0.5)


@pytest.fixture(scope="module")
def kept(motion: PeriodicOrbit, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Diagram]:
    """A run with its file, and how often it said how far it was."""
    path, stages = tmp_path_factory.mktemp("run") / "run.jsonl", list[Stage]()
    found = continuation(Toy(), motion, span=SPAN, run=path, progress=stages.append)
    assert [stage.branches for stage in stages] == list(range(len(found.branches) + 1))
    return path, found


@SLOW_TOY
def test_what_is_kept_is_what_was_found(kept: tuple[Path, Diagram]) -> None:
    path, whole = kept
    for saved in (saved_diagram(path), saved_diagram(str(path))):
        assert differences(saved, whole) == []


@SLOW_TOY
def test_only_the_same_run_goes_on(
    kept: tuple[Path, Diagram], motion: PeriodicOrbit, tmp_path: Path
) -> None:
    path, _ = kept
    with pytest.raises(ValueError, match=r"there span is \[0.1, 0.5\], now it is \[0.2, 0.5\]"):
        continuation(Toy(), motion, span=(0.2, 0.5), run=path, resume=True)
    toy = Toy(mu_3=0.31)
    with pytest.raises(
        ValueError, match=r"cannot resume .* there mu_3 of toy is 0.3, now it is 0.31"
    ):
        continuation(toy, shoot(toy, -0.53), span=SPAN, run=path, resume=True)
    varied = replace(DEFAULT, beside=2e-6)
    with pytest.raises(ValueError, match=r"there beside of settings is 1e-06, now it is 2e-06"):
        continuation(Toy(), motion, span=SPAN, settings=varied, run=path, resume=True)
    # more collisions are done than were met
    other, header = tmp_path / "other.jsonl", path.read_bytes().splitlines(keepends=True)[0]
    done = line_of(entry_of(read_record(path)[1][-1]), json.loads(header)["digest"])
    other.write_bytes(header + done)
    with pytest.raises(ValueError, match=r"line 2: nothing is left to follow at 0\."):
        saved_diagram(other)


def test_a_run_keeps_all_of_its_settings(tmp_path: Path) -> None:
    settings = Settings(span=SPAN, window=WINDOW, max_turn=0.05, max_pieces=100)
    kept = json.loads(json.dumps(subject(Toy(), "eps_n1", SPAN, settings).about))
    assert settings_of(kept["settings"]) == settings
    del kept["settings"]["max_pieces"]  # a file of times before they were kept
    assert settings_of(kept["settings"]) == replace(settings, max_pieces=Settings().max_pieces)


def test_a_run_with_settings_that_are_gone_is_refused(tmp_path: Path) -> None:
    path, settings = tmp_path / "run.jsonl", Settings(span=SPAN, window=WINDOW)
    run = subject(Toy(), "eps_n1", SPAN, settings).about
    run["settings"] |= {"newton": 12, "numerics": {"thin": 1e-3}}
    Record(path, run).close()
    gone = r"run\.jsonl, line 1: expected settings of this version, got newton, numerics too"
    with pytest.raises(ValueError, match=gone):
        saved_diagram(path)
    resumed = r"cannot resume .*: there newton of settings is 12, now there is none"
    with pytest.raises(ValueError, match=resumed):
        Record(path, subject(Toy(), "eps_n1", SPAN, settings).about, resume=True)
