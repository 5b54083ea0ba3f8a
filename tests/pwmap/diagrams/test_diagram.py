"""Branches, special points and diagrams: what they refuse, hold and give to a graph."""

import math
from fractions import Fraction

import networkx as nx
import numpy as np
import numpy.typing as npt
import pytest
import sympy

from pwmap import PiecewiseLinearMap, bifurcation_diagram
from pwmap.diagrams.diagram import (
    Branch,
    BranchKind,
    Diagram,
    PointKind,
    SpecialPoint,
    Stretch,
)


def branch(**changes: object) -> Branch:
    fields: dict[str, object] = {
        "id": "b1", "kind": BranchKind.FIXED_POINT, "order": 1, "word": "S2 D2",
        "parameter": [0.1, 0.2, 0.4], "x": [-0.5, -0.6, -0.4], "multiplier": [1.0, 0.5, -1.5],
        "ends": ("P1", "P2"),
    }  # fmt: skip
    return Branch(**(fields | changes))  # type: ignore[arg-type]


def point(point_id: str, **changes: object) -> SpecialPoint:
    fields: dict[str, object] = {"id": point_id, "kind": PointKind.EP, "parameter": 0.0, "x": 0.0}
    return SpecialPoint(**(fields | changes))  # type: ignore[arg-type]


EPS = sympy.Symbol("eps_n1")
WORDS = (Stretch(0, "S2 D2"), Stretch(2, "S2 D2 I3", "the upper sleeve grazes"))
KNOWN = {"cause": "", "status": "located", "precision": 0.0, "name": ""}  # of a plain point


def diagram() -> Diagram:
    """A fold LP from which one branch runs to a border collision BC, where a jump starts."""
    return Diagram(
        parameter_name="eps_n1",
        x_name="phi_s",
        points=(
            point("LP1", kind=PointKind.LP, parameter=0.1, x=-0.5, branches=("b1",)),
            point(
                "BC1", kind=PointKind.BC, parameter=0.4, x=-0.4, branches=("b1", "j1"), order=2,
                note="fold", exact={"parameter": sympy.Rational(2, 5)},
                cause="two contacts close at once",
                precision=1e-12, interval=(0.4 - 1e-12, 0.4 + 1e-12), name="A",
            ),
            point(
                "EP1", parameter=1, x=np.float64(-0.9), branches=("j1",), status="open",
                precision=math.inf,
            ),
        ),
        branches=(
            branch(ends=("LP1", "BC1"), exact={"x": EPS / (EPS + 1)}, words=WORDS),
            branch(
                id="j1", kind=BranchKind.JUMP, order=2, word="S2 D2 | S2 I3", parameter=[0.4, 1.0],
                x=[-0.4, -0.9], multiplier=[math.nan, math.nan], ends=("BC1", "EP1"),
            ),
        ),
    )  # fmt: skip


# --- Branch ------------------------------------------------------------------------------------


def test_a_branch_holds_locked_copies_of_its_samples() -> None:
    parameter = np.array([0.1, 0.2, 0.4])
    one = branch(parameter=parameter, x=[1, 2, 3])
    parameter[0] = 9.0
    assert one.parameter.tolist() == [0.1, 0.2, 0.4]
    assert len(one) == 3
    for values in (one.parameter, one.x, one.multiplier):
        assert values.dtype == np.float64
        with pytest.raises(ValueError, match="read-only"):
            values[0] = 0.0


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"id": "b:1"}, r"a branch id must be text without ':', got 'b:1'"),
        ({"order": 0}, r"order must be at least 1, got 0"),
        ({"x": [0.0, 1.0]}, r"one common length of at least 1, got 3, 2 and 3"),
        ({"parameter": [], "x": [], "multiplier": []}, r"at least 1, got 0, 0 and 0"),
        ({"x": [[0.0, 1.0, 2.0]]}, r"one-dimensional arrays, got shape \(1, 3\)"),
        ({"x": 0.0}, r"one-dimensional arrays, got shape \(\)"),
        ({"kind": "curve"}, r"'curve' is not a valid BranchKind"),
        ({"words": (Stretch(1, "S2 D2"),)}, r"from sample 0 to one below 3, got \[1\]"),
        ({"words": (*WORDS, Stretch(3, "J2"))}, r"to one below 3, got \[0, 2, 3\]"),
        ({"words": (*WORDS, Stretch(1, "J2"))}, r"to one below 3, got \[0, 2, 1\]"),
        ({"words": (Stretch(0, "J2"),)}, r"must have the word 'S2 D2', got 'J2'"),
    ],
)
def test_a_branch_refuses(changes: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        branch(**changes)


def test_stable_means_a_multiplier_inside_the_unit_circle() -> None:
    multiplier = [-1.5, -1.0, -0.99, 0.0, 0.99, 1.0, 1.5, math.nan]
    one = branch(parameter=np.arange(8.0), x=np.zeros(8), multiplier=multiplier)
    assert one.stable.dtype == np.bool_
    assert one.stable.tolist() == [False, False, True, True, True, False, False, False]


def test_the_word_of_each_sample() -> None:
    one = branch()
    assert one.words == (Stretch(0, "S2 D2", ""),)
    assert one.changes == ()
    two = branch(words=WORDS)
    assert [two.word_at(k) for k in range(3)] == ["S2 D2", "S2 D2", "S2 D2 I3"]
    assert two.changes == WORDS[1:]
    for sample in (-1, 3):
        with pytest.raises(IndexError, match=rf"sample must lie in \[0, 2\], got {sample}"):
            two.word_at(sample)
    assert [b.id for b in diagram().with_word("S2 D2 I3")] == ["b1"]
    assert [b.id for b in diagram().with_word("S2 D2")] == ["b1"]


# --- Special points -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "changes", "message"),
    [
        ("P:1", {}, r"a point id must be text without ':', got 'P:1'"),
        ("P1", {"kind": "HB"}, r"'HB' is not a valid PointKind"),
        ("P1", {"status": "found"}, r"'found' is not a valid PointStatus"),
        ("P1", {"precision": -1.0}, r"a precision must be at least 0, got -1.0"),
        ("P1", {"precision": math.nan}, r"a precision must be at least 0, got nan"),
        ("P1", {"interval": (0.1, 0.2)}, r"must hold its parameter 0.0, got \(0.1, 0.2\)"),
    ],
)
def test_a_point_refuses(name: str, changes: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        point(name, **changes)


# --- Diagram ------------------------------------------------------------------------------------


def test_ids_are_unique() -> None:
    points = (point("P1"), point("P2"))
    names = {"parameter_name": "p", "x_name": "x"}
    with pytest.raises(ValueError, match="ids of the special points are not unique"):
        Diagram(**names, branches=(), points=(*points, point("P1")))
    with pytest.raises(ValueError, match="ids of the branches are not unique"):
        Diagram(**names, branches=(branch(), branch()), points=points)


@pytest.mark.parametrize("ends", [("P1", "P3"), ("P3", "P1")])
def test_branches_end_at_known_points(ends: tuple[str, str]) -> None:
    with pytest.raises(ValueError, match="branch 'b1' ends at unknown point 'P3'"):
        Diagram(
            parameter_name="p",
            x_name="x",
            branches=(branch(ends=ends),),
            points=(point("P1"), point("P2")),
        )


def test_branches_and_points_are_found_by_id() -> None:
    whole = diagram()
    assert whole.branch("j1") is whole.branches[1]
    assert whole.point("BC1") is whole.points[1]
    with pytest.raises(KeyError, match="no branch 'BC1' in this diagram"):
        whole.branch("BC1")
    with pytest.raises(KeyError, match="no special point 'j1' in this diagram"):
        whole.point("j1")


def test_names_go_to_the_nearest_border_collisions() -> None:
    """The diagram extends over 0.9 in the parameter and 0.5 in x: 0.01 of it are 0.009, 0.005."""
    whole = diagram()
    for places, found in [
        ({"C": (0.408, -0.404)}, "C"),
        ({"C": (0.408, -0.406)}, "A"),
        ({"C": (0.41, -0.4)}, "A"),
        ({"E": (1.0, -0.9)}, "A"),  # no border collision
        ({}, "A"),
    ]:
        named = whole.named(places)
        assert named.point("BC1").name == found
        assert named.point(found) is named.point("BC1")
        assert [p.name for p in named.points].count("") == 2
    assert whole.named({"C": (0.5, -0.5)}, within=0.2).point("C").id == "BC1"
    assert whole.named({"E": "EP1"}).point("E").id == "EP1"
    with pytest.raises(KeyError, match="no special point 'PD9'"):
        whole.named({"E": "PD9"})
    with pytest.raises(ValueError, match="'B' and 'C' are names for one point"):
        whole.named({"B": (0.4, -0.4), "C": (0.401, -0.4)})
    with pytest.raises(ValueError, match="a name must differ from all ids of points, got 'EP1'"):
        whole.named({"EP1": (0.4, -0.4)})
    with pytest.raises(KeyError, match="no special point ''"):
        whole.point("")


def test_the_graph_of_a_small_diagram() -> None:
    """All values are plain floats or plain text."""
    graph = diagram().graph()
    assert type(graph) is nx.MultiGraph
    assert graph.graph == {"parameter": "eps_n1", "x": "phi_s"}
    assert list(graph.nodes(data=True)) == [
        ("LP1", {"kind": "LP", "parameter": 0.1, "x": -0.5, "order": 1.0, "note": "", **KNOWN}),
        ("BC1", {
            "kind": "BC", "parameter": 0.4, "x": -0.4, "order": 2.0, "note": "fold", **KNOWN,
            "cause": "two contacts close at once", "precision": 1e-12, "name": "A",
            "interval_min": 0.4 - 1e-12, "interval_max": 0.4 + 1e-12, "parameter_exact": "2/5",
        }),
        ("EP1", {
            "kind": "EP", "parameter": 1.0, "x": -0.9, "order": 1.0, "note": "", **KNOWN,
            "status": "open", "precision": math.inf,
        }),
    ]  # fmt: skip
    assert list(graph.edges(keys=True, data=True)) == [
        ("LP1", "BC1", "b1", {
            "kind": "fixed-point", "order": 1.0, "word": "S2 D2", "stable": "yes",
            "parameter_min": 0.1, "parameter_max": 0.4, "x_min": -0.6, "x_max": -0.4,
            "samples": 3.0, "words": "S2 D2; S2 D2 I3",
            "changes": "0.4: the upper sleeve grazes", "x_exact": "eps_n1/(eps_n1 + 1)",
        }),
        ("BC1", "EP1", "j1", {
            "kind": "jump", "order": 2.0, "word": "S2 D2 | S2 I3", "stable": "no",
            "parameter_min": 0.4, "parameter_max": 1.0, "x_min": -0.9, "x_max": -0.4,
            "samples": 2.0, "words": "S2 D2 | S2 I3", "changes": "",
        }),
    ]  # fmt: skip
    tables = (graph.graph, *graph.nodes.values(), *graph.edges.values())
    assert {type(value) for data in tables for value in data.values()} == {float, str}


@pytest.mark.parametrize(
    ("multiplier", "expected"),
    [
        ([0.5], "yes"),
        ([1.5], "no"),
        ([0.5, 1.5], "partly"),
        ([1.0, 0.5, -1.0], "yes"),
        ([0.5, 1.5, 0.5], "no"),
        ([1.0, 0.5, 1.5, 1.0], "partly"),
    ],
)
def test_the_graph_tells_how_much_of_a_branch_is_stable(
    multiplier: list[float], expected: str
) -> None:
    zeros = [0.0] * len(multiplier)
    one = branch(parameter=zeros, x=zeros, multiplier=multiplier)
    points = (point("P1"), point("P2"))
    graph = Diagram(parameter_name="p", x_name="x", branches=(one,), points=points).graph()
    assert graph.edges["P1", "P2", "b1"]["stable"] == expected


# --- Queries --------------------------------------------------------------------------------------


def looped() -> Diagram:
    """A fold at p = 1 with a stable and an unstable half, a jump at its end, and an island."""
    up = np.linspace(0.0, 1.0, 5)
    names = ("EP1", "EP2", "LP1", "BC1", "EP3", "BC2", "BC3")
    kinds = [PointKind(name[:2]) for name in names]
    places = [(0.0, 0.0), (0.0, 2.0), (1.0, 1.0), (0.5, 3.0), (0.9, 3.0), (0.2, 5.0), (0.4, 5.0)]
    return Diagram(
        parameter_name="p",
        x_name="x",
        branches=(
            curve("F1", up, up, 0.5 * np.ones(5), ("EP1", "LP1")),
            curve("F2", 1.0 - 0.5 * up, 1.0 + 2.0 * up, 1.5 * np.ones(5), ("LP1", "BC1")),
            curve("J1", [0.5, 0.9], [3.0, 3.0], [np.nan] * 2, ("BC1", "EP3"), BranchKind.JUMP),
            curve("F3", [0.2, 0.4], [5.0, 5.0], [-0.5, -1.5], ("BC2", "BC3")),
        ),
        points=tuple(
            SpecialPoint(id=name, kind=kind, parameter=p, x=x)
            for name, kind, (p, x) in zip(names, kinds, places, strict=True)
            if name != "EP2"
        ),
    )


def curve(
    name: str,
    p: npt.ArrayLike,
    x: npt.ArrayLike,
    multiplier: npt.ArrayLike,
    ends: tuple[str, str],
    kind: BranchKind = BranchKind.FIXED_POINT,
) -> Branch:
    return Branch(
        id=name, kind=kind, order=1, word=name.lower(), parameter=np.asarray(p), x=np.asarray(x),
        multiplier=np.asarray(multiplier), ends=ends,
    )  # fmt: skip


def test_a_slice_lists_what_lies_at_a_parameter() -> None:
    hits = looped().at(0.6)
    assert [(hit.branch.id, hit.x) for hit in hits] == [
        ("F1", pytest.approx(0.6)),
        ("F2", pytest.approx(2.6)),
        ("J1", 3.0),
    ]
    assert [hit.multiplier for hit in hits[:2]] == [0.5, 1.5]
    assert math.isnan(hits[2].multiplier)
    assert [hit.branch.id for hit in looped().at(0.25)] == ["F1", "F3"]  # on a sample, once
    assert looped().at(1.5) == ()


def exact_lines() -> Diagram:
    map_ = PiecewiseLinearMap.from_sympy("Piecewise((p + x/2, x <= 0), (p - 1 + x/3, True))")
    return bifurcation_diagram(map_, "p", (-1, 2), orders=(1,))


def test_a_slice_is_at_a_finite_real_number() -> None:
    """In every diagram, also one without branches; what is beyond all doubles is met by none."""
    exact = exact_lines()
    for diagram in (looped(), exact, exact.of_order(7)):
        for wrong in (math.nan, math.inf, -math.inf, "nan", "half", 1j, None):
            with pytest.raises((ValueError, TypeError), match=r"number|finite|half|nan"):
                diagram.at(wrong)
        assert diagram.at(10**400) == diagram.at(-(10**400)) == ()
    assert exact.of_order(7).at("1/2") == ()
    near = [(hit.branch.id, hit.x) for hit in looped().at(0.5)]
    for same in ("1/2", Fraction(1, 2), sympy.Rational(1, 2), np.float64(0.5)):
        assert [(hit.branch.id, hit.x) for hit in looped().at(same)] == near


def test_an_open_end_is_not_within_an_interval() -> None:
    """x = 2p for p <= 0, the jump at 0 for p in (0, 1), and 3(p - 1)/2 for p > 1."""
    exact = exact_lines()
    for low, high, ids in (
        (1, 1, []), (1.0, 1.5, ["F2"]), (0, 0, ["F1"]), (0.5, 1, ["J1"]), (0, 1, ["F1", "J1"]),
        (Fraction(1, 3), Fraction(1, 3), ["J1"]), (-math.inf, math.inf, ["F1", "J1", "F2"]),
        (-math.inf, -5, []), (1, 10**400, ["F2"]), ("1/2", "1", ["J1"]),
        (-sympy.oo, -sympy.sqrt(2) / 2, ["F1"]), ("-oo", "oo", ["F1", "J1", "F2"]),
    ):  # fmt: skip
        assert [branch.id for branch in exact.within(low, high).branches] == ids
        if low == high:
            assert [hit.branch.id for hit in exact.at(low)] == ids


def test_components_and_paths() -> None:
    diagram = looped()
    island = diagram.component_of("BC2")
    assert [b.id for b in island.branches] == ["F3"]
    assert {p.id for p in island.points} == {"BC2", "BC3"}
    assert {b.id for b in diagram.component_of("LP1").branches} == {"F1", "F2", "J1"}
    assert diagram.path("F1", "J1") == ("F1", "LP1", "F2", "BC1", "J1")
    assert diagram.path("J1", "F2") == ("J1", "BC1", "F2")
    assert diagram.path("F2", "F2") == ("F2",)
    assert diagram.path("F1", "F3") == ()
    assert diagram.path("LP1", "J1") == ("LP1", "F2", "BC1", "J1")
    named = diagram.named({"fold": "LP1", "C": "BC1"})
    assert named.path("fold", "C") == ("LP1", "F2", "BC1")
    with pytest.raises(KeyError, match="no branch and no special point 'F9'"):
        diagram.path("F1", "F9")
    with pytest.raises(KeyError, match="no special point 'XX'"):
        diagram.component_of("XX")


def test_within_an_interval_of_the_parameter() -> None:
    diagram = looped()
    for low, high in ((-1.0, 0.1), (0.2, 0.21), (0.9, 2.0), (1.5, 2.0)):
        expected = [
            branch.id
            for branch in diagram.branches
            if any(low <= p <= high for p in np.linspace(*np.sort(branch.parameter)[[0, -1]], 1001))
        ]
        near = diagram.within(low, high)
        assert diagram.within(low, 10**400).branches == diagram.within(low, 9).branches
        assert [branch.id for branch in near.branches] == expected
        assert {point.id for point in near.points} == {e for b in near.branches for e in b.ends}


def test_words_and_stable_intervals() -> None:
    diagram = looped()
    assert [b.id for b in diagram.with_word("f2")] == ["F2"]
    assert [(s.branch.id, s.low, s.high) for s in diagram.stable_intervals()] == [
        ("F1", 0.0, 1.0),
        ("F3", 0.2, 0.2),
    ]
    assert diagram.stable_intervals(order=2) == ()


def test_sides_of_a_point() -> None:
    diagram = looped()
    assert diagram.sides("LP1") == (("F1", "F2"), ())
    assert diagram.sides("BC1") == ((), ("F2", "J1"))


def along(*rows: tuple[float, float]) -> Diagram:
    """One branch through places (parameter, x)."""
    p, x = zip(*rows, strict=True)
    only = branch(parameter=p, x=x, multiplier=[0.5] * len(x), ends=("P1", "P2"))
    ends = (point("P1", parameter=p[0], x=x[0]), point("P2", parameter=p[-1], x=x[-1]))
    return Diagram(parameter_name="p", x_name="x", branches=(only,), points=ends)


@pytest.mark.parametrize(
    ("rows", "where", "expected"),
    [
        (((0.0, 0.0), (1.0, 1.0), (1.0, 2.0)), 1.0, [1.0, 2.0]),
        (((1.0, 1.0), (1.0, 2.0), (1.0, 3.0)), 1.0, [1.0, 3.0]),
        (((1.0, 1.0), (1.0, 2.0), (2.0, 3.0)), 1.0, [1.0, 2.0]),
        (((0.0, 0.0), (1.0, 1.0), (0.0, 2.0)), 1.0, [1.0]),  # a fold, met in its tip
        (((0.0, 0.0), (1.0, 1.0), (0.0, 2.0)), 0.5, [0.5, 1.5]),
        (((0.0, 0.0), (1.0, 1.0), (2.0, 2.0)), 1.0, [1.0]),
        (((0.0, 0.0), (1e-200, 1.0), (3e-200, 2.0)), 2e-200, [1.5]),
        (((0.0, 0.0), (1.0, 1.0)), 2.0, []),
    ],
)
def test_each_place_at_a_value_is_met_once(
    rows: tuple[tuple[float, float], ...], where: float, expected: list[float]
) -> None:
    assert [hit.x for hit in along(*rows).at(where)] == pytest.approx(expected, rel=1e-15)


def test_names_serve_where_ids_do() -> None:
    named = diagram()
    assert named.point("A").id == "BC1"
    assert named.sides("A") == named.sides("BC1") != ((), ())
    assert [b.id for b in named.component_of("A").branches] == [
        b.id for b in named.component_of("BC1").branches
    ]


def test_a_name_goes_to_the_map_before_its_iterates() -> None:
    """A point of P_3 lies closer to the rounded place of a point of P_1 than this itself."""
    places = (("BC1", 1, 0.50012), ("FF1", 3, 0.50005), ("BC2", 2, 0.9))
    points = tuple(
        point(name, kind=PointKind(name[:2]), order=order, parameter=p, branches=("b1",))
        for name, order, p in places
    )
    ends = (point("P1", parameter=0.1, x=-0.5), point("P2", parameter=0.4, x=-0.4))
    found = Diagram(parameter_name="p", x_name="x", branches=(branch(),), points=(*ends, *points))
    assert found.named({"C": (0.5, 0.0)}).point("C").id == "BC1"
    assert found.named({"C": (0.9, 0.0)}).point("C").id == "BC2"  # none of P_1 is near


def test_a_diagram_says_of_which_map_it_is() -> None:
    p1 = PiecewiseLinearMap.from_sympy("Piecewise((r - 2, x <= 0), (r - 5*x/4, True))")
    assert bifurcation_diagram(p1, "r", (1, 3), orders=(1,)).about["map"] == [
        "L  r - 2      for x <= 0", "R  r - 5*x/4  for 0 < x",
    ]  # fmt: skip
    about = bifurcation_diagram(p1.iterate(2), "r", (1, 3), orders=(1, 2)).about
    assert about["map"] == ["<PiecewiseLinearMap of x, order 2, letters LR, parameters r>"]
    assert about["orders"] == [1, 2]
