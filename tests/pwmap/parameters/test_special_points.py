"""What a special point is follows from the branches that meet there; degenerate cases by hand."""

from fractions import Fraction

import networkx as nx
import pytest
import sympy

from pwmap import Diagram, PiecewiseLinearMap, bifurcation_diagram


def diagram(text: str, parameter: str, span: tuple[str, str], *orders: int) -> Diagram:
    return bifurcation_diagram(PiecewiseLinearMap.from_sympy(text), parameter, span, orders)


def inner_points(found: Diagram) -> list[tuple[str, str]]:
    return [(str(p.kind), p.note) for p in found.points if p.kind != "EP"]


@pytest.mark.parametrize(
    ("text", "span", "attracts"),
    [
        # P(x) = x/2 on the left and p x on the right: 0 repels to the right for p > 1
        ("Piecewise((x/2, x <= 0), (p*x, True))", ("2", "3"), False),
        # a jump to 5 p beside the fixed point
        ("Piecewise((x/2, x <= 0), (x + 5*p, True))", ("1", "2"), False),
        # slopes p < -1 and 1/2: the steep side leads to the other one, which contracts
        ("Piecewise((p*x, x <= 0), (x/2, True))", ("-3", "-2"), True),
        # slopes p and -1/3 take turns: 0 attracts while p/(-3) < 1
        ("Piecewise((p*x, x <= 0), (-x/3, True))", ("-2", "-1"), True),
        ("Piecewise((p*x, x <= 0), (-x/3, True))", ("-5", "-4"), False),
    ],
)
def test_stability_of_a_fixed_point_at_a_border(
    text: str, span: tuple[str, str], attracts: bool
) -> None:
    found = diagram(text, "p", span, 1)
    at_border = [branch for branch in found.branches if branch.exact["x"] == 0]
    assert [set(branch.stable.tolist()) for branch in at_border] == [{attracts}]
    middle = sum(map(sympy.Rational, span)) / 2
    (point,) = [
        p for p in PiecewiseLinearMap.from_sympy(text).at({"p": middle}).fixed_points() if p.x == 0
    ]
    assert point.stable is attracts


def test_a_branch_is_cut_where_its_stability_changes() -> None:
    found = diagram("Piecewise((x/2, x <= 0), (p*x, True))", "p", ("0", "3"), 1)
    left, right = (b for b in found.branches if b.exact.get("x") == 0)
    assert (left.exact["interval"], right.exact["interval"]) == (
        sympy.Interval(0, 1),
        sympy.Interval(1, 3),
    )
    assert left.stable.all()
    assert not right.stable.any()
    assert ("BC", "stability changes at the border") in inner_points(found)


@pytest.mark.parametrize("orders", [(1,), (1, 2)])
def test_the_kind_does_not_depend_on_the_orders(orders: tuple[int, ...]) -> None:
    """The 2-cycle that starts at the border has multiplier -1 there; the fixed point does not."""
    text = "Piecewise(((1/2 + m)*x + m, x <= 0), (m - 2*x, True))"
    found = diagram(text, "m", ("-1/10", "1/10"), *orders)
    assert inner_points(found) == [("BC", "persistence")]


@pytest.mark.parametrize(
    ("slope", "kind"), [("1 + m", "FF"), ("1 - m", "BC"), ("5/4", "FF"), ("3/4", "BC")]
)
@pytest.mark.parametrize("orders", [(1,), (1, 2)])
def test_a_fold_is_a_fold_flip_where_the_multiplier_is_steep(
    slope: str, kind: str, orders: tuple[int, ...]
) -> None:
    """Also where the multiplier is exactly -1 at the collision: the side of the branch counts."""
    found = diagram(
        f"Piecewise((m - 2, x <= 0), (m - ({slope})*x, True))", "m", ("-1/2", "1/2"), *orders
    )
    assert inner_points(found) == [(kind, "fold")]
    if orders == (1, 2):  # the incidence that defines it
        (point,) = (p for p in found.points if p.kind == kind)
        jumps = {b.exact["x"] for b in found.branches if b.id in point.branches and b.order == 2
                 and b.kind == "jump" and b.exact["x"] != 0}  # fmt: skip
        assert bool(jumps) == (kind == "FF")


def test_where_the_tent_map_is_the_identity() -> None:
    """At slope 1 all x <= 1/2 are fixed; beyond, 0 is unstable and a second fixed point starts."""
    found = diagram("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))", "a", ("1/2", "2"), 1, 2)
    points = [p for p in found.points if p.parameter == 1.0 and p.kind != "EP"]
    assert [(str(p.kind), p.exact["x"], p.note) for p in points] == [
        ("LP", 0, "degenerate: an interval of fixed points"),
        ("BC", sympy.Rational(1, 2), "fold"),
    ]


def test_open_ends_of_a_band_are_no_fixed_points() -> None:
    """For 0 < r < 1, P_2 is the identity on (0, r), without its ends."""
    found = diagram("Piecewise((r - 2, x <= 0), (r - x, True))", "r", ("-1", "1"), 1, 2)
    assert {b.order for b in found.branches} == {1}
    map_ = PiecewiseLinearMap.from_sympy("Piecewise((r - 2, x <= 0), (r - x, True))")
    (band,) = map_.at({"r": "1/2"}).iterate(2).fixed_intervals()
    assert band.interval == sympy.Interval.open(0, sympy.Rational(1, 2))


ON_BORDER = {  # right piece beside x/2, which keeps 0: what meets 0 at p = 0, stable there or not
    "p + x/3": ("fold at a branch on the border, attracts at this value only", 1),
    "p - 2*x": ("fold at a branch on the border, attracts at this value only", 1),
    "p**2 + x/3": ("persistence at a branch on the border, attracts at this value only", 2),
    "p + 2*x": ("fold at a branch on the border", 1),
}


@pytest.mark.parametrize(("right", "expected"), ON_BORDER.items(), ids=ON_BORDER)
def test_a_branch_on_a_border_is_collided_with(right: str, expected: tuple[str, int]) -> None:
    """The fixed point 0 of x/2 (x <= 0) stays; that of the right piece ends on it at p = 0.

    Beside p = 0 the map jumps at 0. At p = 0 it is continuous there, and 0 attracts if the right
    slope n is below 1: with 1/2 on the left, n > 1 leads away.
    """
    map_ = PiecewiseLinearMap([("x/2", "x <= 0"), (right, "x > 0")])
    found = bifurcation_diagram(map_, "p", (-1, 1), (1,))
    (point,) = (p for p in found.points if p.kind != "EP")
    note, others = expected
    assert (str(point.kind), point.note, point.exact) == ("BC", note, {"parameter": 0, "x": 0})
    kept = [b for b in found.branches if b.exact["x"] == 0]
    assert [b.exact["interval"] for b in kept] == [sympy.Interval(-1, 0), sympy.Interval(0, 1)]
    assert not any(b.stable.any() for b in kept)
    assert len(point.branches) == 2 + others
    assert {b.id for b in found.component_of(point.id).branches} >= {*point.branches}
    (zero,) = (p for p in map_.at({"p": 0}).fixed_points() if p.x == 0)
    assert zero.stable is ("attracts" in note)


def test_orbits_of_higher_order_end_at_a_branch_on_a_border() -> None:
    """-2 x keeps 0; on the right p - x/3. Beside 0 the 2-cycle 3 p, -6 p lives for p < 0."""
    map_ = PiecewiseLinearMap([("-2*x", "x <= 0"), ("p - x/3", "x > 0")])
    found = bifurcation_diagram(map_, "p", (-1, 1), (1, 2))
    (point,) = (p for p in found.points if p.kind != "EP")
    meeting = {str(found.branch(b).exact["x"]) for b in point.branches}
    assert meeting == {"0", "3*p/4", "3*p", "-6*p"}
    assert len(nx.node_connected_component(found.graph(), point.id)) == len(found.points)


def test_a_break_that_is_a_fixed_point_at_one_value_only_lies_on_its_jump() -> None:
    """0 has the value p of its own; around it the map jumps from 1 to -1 for all p."""
    map_ = PiecewiseLinearMap([("1", "x < 0"), ("p", "Eq(x, 0)"), ("-1", "x > 0")])
    found = bifurcation_diagram(map_, "p", ("-1/2", "1/2"), (1,))
    (point,) = (p for p in found.points if p.kind != "EP")
    assert (point.note, point.exact) == ("isolated", {"parameter": 0, "x": 0})
    meeting = [found.branch(name) for name in point.branches]
    assert sorted(str(branch.kind) for branch in meeting) == ["fixed-point", "jump", "jump"]


def shown(found: Diagram) -> list[tuple[str, str, str]]:
    """Kind, word and interval of each branch."""
    return [(str(b.kind), b.word, str(b.exact["interval"])) for b in found.branches]


def test_the_end_of_an_interval_of_fixed_points_is_no_branch() -> None:
    """At p = 0 the left piece is the identity, with its end, which is no branch of its own.

    Two jumps end there: that of P itself, and that of P_2.
    """
    found = diagram("Piecewise((p + x, x <= 0), (p - 1 + x/3, True))", "p", ("-1", "1/2"), 1, 2)
    (band,) = (b for b in found.branches if str(b.kind) == "fixed-point")
    assert (band.word, band.exact["lower"], band.exact["upper"]) == ("L", -sympy.oo, 0)
    (point,) = (p for p in found.points if p.kind == "LP")
    assert point.note == "degenerate: an interval of fixed points"
    assert set(point.branches) == {"J1", "J2", band.id}


def test_a_piece_that_shrinks_to_a_point_closes_its_branch() -> None:
    """The 2-cycle between (1 - p)/2 and (1 + p)/2 begins at p = 1 on both breaks, 0 and 1.

    The piece LR of P_2 is [1 - p, 0], which at p = 1 is its fixed point alone, without a slope.
    """
    text = "Piecewise((x + p, x <= 0), (1/2, x < 1), (1 - x, True))"
    found = diagram(text, "p", ("0", "3"), 1, 2)
    assert [each for each in shown(found) if each[0] == "fixed-point"] == [
        ("fixed-point", "M", "Interval(0, 3)"),
        ("fixed-point", "RL", "Interval(1, 3)"),
        ("fixed-point", "LR", "Interval(1, 3)"),
    ]
    assert inner_points(found) == [("BC", "fold"), ("BC", "fold")]


def test_values_along_a_branch_are_exact_where_floats_cancel() -> None:
    """Multiplied out, (p - 1)**20/2 has terms of 10**5 that add up to less than 10**-6.

    In doubles the error of such a sum is about 10**-10; what is drawn is good to 2**-40.
    """
    found = diagram("(p - 1)**20*x/2 + 1", "p", ("1/2", "3/2"), 1)
    (branch,) = found.branches
    for value, multiplier in zip(branch.parameter, branch.multiplier, strict=True):
        expected = float((Fraction(float(value)) - 1) ** 20 / 2)
        assert abs(multiplier - expected) <= 2.0**-40 * expected


def test_a_branch_over_an_interval_that_doubles_cannot_part_is_curved() -> None:
    """With q = 10**18 (p - 1) from 0 to 1 the fixed point is 1/(1 - q/2); p is 1.0 all along."""
    text, span = "10**18*(p - 1)*x/2 + 1", ("1", "1000000000000000001/1000000000000000000")
    (branch,) = diagram(text, "p", span, 1).branches
    assert set(branch.parameter.tolist()) == {1.0}
    steps = len(branch) - 1
    for k, x in enumerate(branch.x):
        assert abs(x - 1.0 / (1.0 - 0.5 * k / steps)) <= 1e-15 * x


def test_the_default_span_ends_one_beyond_the_outer_points() -> None:
    """Its ends belong to it, and each point says what happens there."""
    lines = PiecewiseLinearMap.from_sympy("Piecewise((p + x/2, x <= 0), (p - 1 + x/3, True))")
    found = bifurcation_diagram(lines, "p", orders=(1,))
    assert [each.exact["interval"] for each in found.branches] == [
        sympy.Interval(-1, 0), sympy.Interval.open(0, 1), sympy.Interval.Lopen(1, 2),
    ]  # fmt: skip
    met = "a fixed point meets the border x = 0"
    assert [each.cause for each in found.points] == ["", met, met, ""]


def test_borders_that_are_met_at_once_are_all_named() -> None:
    """At p = 0 the fixed point 0 of M meets x = 0, and with it the cycle of 0 and 1 of P_2."""
    map_ = PiecewiseLinearMap.from_sympy(
        "Piecewise((1 - p + x/2, x < 0), (-x/2, x < 1), (2*x + p + 1, True))"
    )
    found = bifurcation_diagram(map_, "p", (-1, 1), orders=(1, 2))
    causes = {each.cause for each in found.points if each.exact["parameter"] == 0}
    assert "a fixed point meets the borders x = 0 and x = 1" in causes


def test_a_flip_has_its_multiplier_as_cause_and_a_note_tells_where_x_is_unbounded() -> None:
    map_ = PiecewiseLinearMap.from_sympy("Piecewise((-1, x <= 0), (1 - a*x, True))")
    found = bifurcation_diagram(map_, "a", orders=(1,))
    told = {each.id: (each.note, each.cause) for each in found.points if each.kind != "EP"}
    assert told == {"LP1": ("x grows without bound", ""), "PD1": ("", "multiplier -1")}
