"""Where only jumps meet a branch goes on with another word: a mark, and no special point."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from sympy import Interval, Rational, Symbol

from pwmap import Branch, BranchKind, Diagram, PiecewiseLinearMap, PointKind, bifurcation_diagram
from pwmap.diagrams.tables import table_of_branches, table_of_points, write_results
from pwmap.parameters.segments import (
    LEFT,
    RIGHT,
    BranchKey,
    Junction,
    Segment,
    SegmentEnd,
    connected,
)

P = Symbol("p")
SPAN = (-1, Rational(1, 2))


def diagram_of(*pieces: tuple[str, str]) -> Diagram:
    return bifurcation_diagram(PiecewiseLinearMap(list(pieces)), "p", SPAN, orders=(1, 2))


def passing() -> Diagram:
    """The limit 3 + p at the left of 0 meets the jump at 3 from 5 down to -7/2, when p = 0.

    So P_2 jumps over the diagonal at 0 until then, and at the preimage -10 p/9 of 3 from there on.
    """
    return diagram_of(
        ("9*x/10 + 3 + p", "x < 0"), ("3*x - 4", "(0 <= x) & (x < 3)"), ("x/2 - 5", "x >= 3")
    )


def turning() -> Diagram:
    """The same with a jump from -7/10 up to 5/2: at 0 and at -10 p/9 for p > 0, nowhere before."""
    return diagram_of(
        ("9*x/10 + 3 + p", "x < 0"), ("11*x/10 - 4", "(0 <= x) & (x < 3)"), ("x/2 + 1", "x >= 3")
    )


def at_zero(diagram: Diagram) -> Branch:
    """The jump of P_2 that is at 0 for p = 0."""
    (found,) = {
        hit.branch.id: hit.branch
        for hit in diagram.at(Rational(1, 100))
        if hit.branch.kind is BranchKind.JUMP and hit.branch.order == 2 and abs(hit.x) < 0.1
    }.values()
    return found


def test_a_jump_goes_on_where_its_word_changes() -> None:
    diagram = passing()
    branch = at_zero(diagram)
    first, second = branch.words
    assert (first.word, second.word) == ("LM|ML", "LM|LR")
    assert second.cause == "an orbit of the jump meets the border x = 3"
    assert (first.exact["x"], second.exact["x"]) == (0, -10 * P / 9)
    assert branch.exact == first.exact
    assert first.exact["interval"] == Interval(-1, 0)
    assert second.exact["interval"] == Interval.Lopen(0, Rational(1, 2))
    assert branch.parameter.tolist() == [-1.0, 0.0, 0.5]
    assert branch.x.tolist() == [0.0, 0.0, pytest.approx(-5.0 / 9.0, abs=1e-15)]
    assert [branch.word_at(k) for k in range(3)] == ["LM|ML", "LM|LR", "LM|LR"]
    assert not any(p.exact["parameter"] == 0 for p in diagram.points)


def test_a_jump_turns_round_where_it_meets_another() -> None:
    diagram = turning()
    branch = at_zero(diagram)
    assert len(branch.words) == 2
    assert branch.parameter.tolist() == [0.5, 0.0, 0.5]
    (lower, _), (upper, _) = ((h.exact["x"], h) for h in diagram.at("1/4") if h.branch is branch)
    assert (lower, upper) == (Rational(-5, 18), 0)
    for end in branch.ends:
        assert diagram.sides(end)[0].count(branch.id) == 1
        assert diagram.sides(end)[1] == ()
    assert not any(p.exact["parameter"] == 0 for p in diagram.points)


def test_files_and_tables_say_each_stretch(tmp_path: Path) -> None:
    diagram = passing()
    branch = at_zero(diagram)
    data: Any = diagram.graph().get_edge_data(*branch.ends, branch.id)
    assert data["words"] == "LM|ML; LM|LR"
    assert data["x_exact"] == "0; -10*p/9"
    assert data["changes"] == "0: an orbit of the jump meets the border x = 3"
    assert str(table_of_points(diagram).title).endswith(", 1 change of word")
    write_results(diagram, tmp_path)
    rows = [line for line in (tmp_path / "branches.csv").read_text().splitlines()
            if line.startswith(f"{branch.id},")]  # fmt: skip
    assert [("-10*p/9" in row, "LM|LR" in row) for row in rows] == [
        (False, False), (True, True), (True, True)]  # fmt: skip
    table = table_of_branches(diagram)
    assert list(table.columns[0].cells).count(branch.id) == 2


def test_more_than_two_jumps_that_meet_are_a_point() -> None:
    """Both limits at 0 meet jumps when p = 0: P_2 has two jumps on each side of it."""
    diagram = diagram_of(
        ("9*x/10 + 3 + p", "x < 0"),
        ("11*x/10 + 6 + p", "(0 <= x) & (x < 3)"),
        ("9*x/10 - 8 + p", "(3 <= x) & (x < 6)"),
        ("x/2 + 2 + p", "x >= 6"),
    )
    (point,) = [p for p in diagram.points if p.exact["parameter"] == 0]
    assert (point.kind, point.note, point.exact["x"]) == (PointKind.EP, "jumps meet", 0)
    assert tuple(map(len, diagram.sides(point.id))) == (2, 2)


def test_a_jump_ends_alone_where_a_piece_is_flat() -> None:
    """The slope p of the middle piece turns it over: at p = 0 all of it is mapped onto the break 0.

    For p > 0 its points lie right of 0, as their neighbours on the right do at 1.
    """
    map_ = PiecewiseLinearMap(
        [("x + 5", "x < 0"), ("p*(x - 2)", "(0 <= x) & (x < 1)"), ("x/2 - p - 1/2", "x >= 1")]
    )
    diagram = bifurcation_diagram(map_, "p", ("-1/8", "1/8"), (1, 2))
    (point,) = [p for p in diagram.points if (p.parameter, p.x) == (0.0, 1.0)]
    assert (point.kind, point.note) == (PointKind.EP, "the jump ends")


def test_a_jump_ends_at_a_cycle_that_is_not_shown() -> None:
    """x/2 + p and 1 + p - 3 x/2: what P_2 alone shows, and where it ends, is part of both."""
    map_ = PiecewiseLinearMap([("x/2 + p", "x <= 0"), ("1 + p - 3*x/2", "x > 0")])
    both, alone = (bifurcation_diagram(map_, "p", (-2, 2), orders) for orders in ((1, 2), (2,)))
    assert {branch.order for branch in alone.branches} == {2}
    assert len(alone.branches) == len(both.of_order(2).branches)
    kinds = {(p.exact["parameter"], p.exact["x"]): (p.kind, p.note) for p in both.points}
    assert all(kinds[p.exact["parameter"], p.exact["x"]] == (p.kind, p.note) for p in alone.points)
    assert [(p.kind, p.x) for p in alone.points if p.parameter in (-1.0, 0.0)] == [
        (PointKind.FF, 0.0), (PointKind.BC, 0.0)]  # fmt: skip


def test_a_jump_passes_where_one_of_another_order_changes() -> None:
    """P_2 jumps at 1 from 2 p + 3/4 to -2 p, over the diagonal for p > 1/8, until 2 p - 1/2 = 1.

    At p = 1/2 these are 7/4 and the break -1, so that there a jump of P_3 has another word.
    """
    map_ = PiecewiseLinearMap(
        [("2*p - x/2", "x < -1"), ("-x - 1/2", "(-1 <= x) & (x <= 1)"), ("2*p - x + 1/2", "x > 1")]
    )
    for orders in ((2,), (2, 3), (1, 2, 3)):
        diagram = bifurcation_diagram(map_, "p", (-2, 3), orders)
        (branch,) = [hit.branch for hit in diagram.at("1/2")
                     if hit.branch.order == 2 and hit.branch.kind is BranchKind.JUMP]  # fmt: skip
        (stretch,) = [each for each in branch.words if each.word == "ML|RM"]
        assert stretch.exact["interval"] == Interval.Lopen(Rational(1, 8), Rational(3, 4))
        assert not any("touches" in each.cause for each in branch.words)


# --- Curves ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Loop:
    """Two jumps between the places 0 and 1 that meet at both: a closed branch."""

    segments: tuple[Segment, Segment]
    junctions: tuple[Junction, Junction]


def loop() -> Loop:
    segments = tuple(
        Segment(BranchKey(BranchKind.JUMP, ((0, i), (1, i))), (0, 1)) for i in range(2)
    )
    meetings = [
        Junction(place, "x", tuple(
            SegmentEnd(segment, place, LEFT if place else RIGHT, 0, False, None, "x")
            for segment in segments), 0)
        for place in (0, 1)
    ]  # fmt: skip
    return Loop((segments[0], segments[1]), (meetings[0], meetings[1]))


def test_a_branch_that_closes_keeps_one_point() -> None:
    closed = loop()
    (curve,), (left,) = connected(closed.segments, closed.junctions, ())
    assert curve == [(closed.segments[0], 0), (closed.segments[1], 1)]  # the second is turned
    assert left.place == 0
    assert len(left.ends) == 2


def test_a_branch_is_not_followed_beyond_a_stop() -> None:
    closed = loop()
    curves, _ = connected(closed.segments, closed.junctions, (0,))
    assert [[entered for _, entered in curve] for curve in curves] == [[0, 1]]
    curves, left = connected(closed.segments, closed.junctions, (0, 1))
    assert curves == [[(segment, 0)] for segment in closed.segments]
    assert [len(junction.ends) for junction in left] == [2, 2]
