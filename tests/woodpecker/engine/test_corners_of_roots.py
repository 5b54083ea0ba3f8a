"""Jump crossings of P_2 that change their border where a root begins, against closed forms.

Beyond x = c(p) a piece begins with a root: D(x) = D(c) + sqrt(x - c)/8. Where D(c) passes a border
b(p) the crossing leaves c: its first point goes on at c + 64 (b - D(c))^2, from where D leads to b.
"""

import numpy as np
import pytest
import sympy
from sympy import Piecewise, Rational, sqrt, symbols

from pwmap.diagrams.diagram import BranchKind, Diagram, PointStatus
from woodpecker import Search, Settings, bifurcation_diagram, from_sympy
from woodpecker.base.arrays import Floats
from woodpecker.search.curves import keys_of_jump
from woodpecker.search.duplicates import Known
from woodpecker.search.network import Network
from woodpecker.search.tasks import Tasks
from woodpecker.slices import slices_at
from woodpecker.slices.orbits import ending_at

x, p = symbols("x p", real=True)
SPAN, WINDOW = (-1.0, 1.0), (-3.0, 3.0)
C = p / 16 + Rational(1, 2)
B = -5 * p / 32 - Rational(13, 16)
AT_C = Rational(519, 512) * p + 9 * C**2 / 64 + Rational(7, 64)
CORNER = -0.812237861075325081388919678507  # D(c) = b, by mpmath


def searched(map_: Piecewise) -> Diagram:
    words = ["A", "B", "C", "D"][: len(map_.args)]
    return bifurcation_diagram(
        from_sympy(map_, x, p, words=words), "p", SPAN, (1, 2), WINDOW, search=Search(slices=15)
    )


def first_point(at: Floats) -> Floats:
    """Of the crossing near the corner."""
    c, b, d = (sympy.lambdify(p, each)(at) for each in (C, B, AT_C))
    beyond = np.maximum(b - d, 0.0)  # D(c) lies below b just for p below the corner
    found: Floats = c + 64.0 * beyond**2
    return found


@pytest.mark.slow
def test_a_crossing_goes_round_a_corner_onto_another_border() -> None:
    diagram = searched(
        Piecewise(
            (2 * p + Rational(9, 32) * x**2 + Rational(7, 16) * x, x < B),
            (-x * (1 - x) * (p / 4 + 1) / 2 + Rational(3, 32), x < Rational(1, 16) - 7 * p / 16),
            (Rational(3, 2) * p + x**2 / 2 + Rational(27, 32) * x, x < C),
            (AT_C + sqrt(x - C) / 8, True),
        )
    )
    assert not [point for point in diagram.points if point.status is PointStatus.OPEN]
    (branch,) = [each for each in diagram.branches if each.word == "D | A / D | B"]
    words = [stretch.word for stretch in branch.words]
    assert words == ["D | A / D | B", "C | A / D | B", "C | A / C | B", "B | B / C | B"]
    first, second = (branch.words[k].first for k in (1, 2))
    assert abs(branch.parameter[first] - CORNER) < 1e-7  # c is left like the square of the way
    near = slice(0, second)
    # x is known to some spacings, or to those of b over the slope of the root, 1/16 at most
    off = np.abs(branch.x[near] - first_point(branch.parameter[near]))
    assert off.max() < 1e-12


@pytest.mark.nightly
def test_crossings_from_both_sides_of_a_corner_are_one() -> None:
    border = Rational(1, 2) - 7 * p / 32
    diagram = searched(
        Piecewise(
            (Rational(25, 64) * p * x + sympy.tanh(3 * x / 4) / 4 - Rational(3, 32), x < p / 2),
            (-Rational(25, 16) * p + Rational(15, 8) * x + Rational(3, 4), x < border),
            (
                Rational(25, 128) * p * border
                + sqrt(x - border) / 8
                + sympy.tanh(3 * border / 4) / 8
                - Rational(3, 64),
                True,
            ),
        )
    )
    assert not [point for point in diagram.points if point.status is PointStatus.OPEN]


# Two pieces begin with a root at their common border, and one at the next border.
ROOTS_AT_BORDERS = Piecewise(
    (
        -17 * p / 64 - 79 * x / 192 - 17 * sqrt(-p / 32 - x - Rational(11, 16)) / 16
        - Rational(29, 32),
        x < -p / 32 - Rational(11, 16),
    ),
    (21 * p / 32 + 49 * x**2 / 128 + 43 * x / 32 + Rational(1, 2), x < -p / 32 - Rational(1, 2)),
    (
        11 * p / 16 - 31 * x / 96 - 13 * sqrt(-p / 32 - x + Rational(5, 64)) / 16
        - Rational(17, 16),
        x < Rational(5, 64) - p / 32,
    ),
    (-35 * p / 64 - 11 * sympy.sin(53 * x / 16) / 32 - Rational(75, 64), True),
)  # fmt: skip


@pytest.mark.nightly
def test_the_limit_of_a_root_at_its_own_border_is_exact() -> None:
    """Rounding puts a border point beyond its border, or leaves the root of a spacing of it."""
    first, second = -p / 32 - Rational(11, 16), -p / 32 - Rational(1, 2)
    at_a, at_b = (piece for piece, _ in ROOTS_AT_BORDERS.args[:2])
    met = sympy.solve(at_a.subs(x, first) - first, p)[0]  # 394/1361
    ends = sympy.nsolve(at_a.subs(x, at_b.subs(x, second)) - second, p, -0.94)  # a cycle A B
    diagram = bifurcation_diagram(
        from_sympy(ROOTS_AT_BORDERS, x, p, words=["A", "B", "C", "D"]), "p", SPAN, (1, 2),
        (-2.0, 2.0), search=Search(slices=15),
    )  # fmt: skip
    collisions = [point.parameter for point in diagram.points if point.cause.startswith("x = ")]
    for exact in (met, ends):
        near = [abs(each - float(exact)) for each in collisions if abs(each - exact) < 1e-6]
        assert near
        assert max(near) < 1e-13
    # One crossing of P_2 goes from the one border, along it, and round a corner: none leaps.
    (round_corner,) = [each for each in diagram.branches if each.word == "A | C / B | B"]
    assert abs(round_corner.parameter[-1] - float(ends)) < 1e-13
    assert np.abs(np.diff(round_corner.x)).max() < 0.05


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("pieces", "parameter", "expected"),
    [
        (  # at 0.8857 one crossing, which turns into the other border where both are met
            (
                (
                    -11 * p * x / 16 - 39 * p / 32 - 13 * x**3 / 32 + 35 * x / 32
                    + Rational(77, 64),
                    x < -13 * p / 64 - Rational(13, 64),
                ),
                (
                    25 * p / 64 + 95 * x / 192 + 45 * sqrt(-13 * p / 64 - x + Rational(15, 64)) / 32
                    - Rational(77, 64),
                    x < Rational(15, 64) - 13 * p / 64,
                ),
                (
                    p * (1 - 87 * x / 256) - 3 * sqrt(13 * p / 64 + x - Rational(15, 64)) / 64
                    + Rational(95, 64),
                    x < Rational(13, 16) - 13 * p / 64,
                ),
                (13 * p / 16 - x**2 / 128 - 57 * x / 64 - Rational(39, 32), True),
            ),
            0.8857,
            [-0.3830328125],  # the border x = -13 (p + 1)/64
        ),
        (  # at -0.4 two crossings: of the border -23/32 itself, and where D leads to it
            (
                (
                    -7 * p / 64 - 7 * x**2 / 16 - 11 * x / 8 + Rational(17, 64),
                    x < Rational(-95, 64),
                ),
                (
                    9 * p / 16 + 87 * x**2 / 128 - 7 * x / 64 - Rational(71, 64),
                    x < Rational(-23, 32),
                ),
                (
                    9 * p * x / 16 - 21 * p / 64 - 7 * x**3 / 64 + x / 8 + Rational(93, 64),
                    x < -Rational(11, 16),
                ),
                (
                    -5 * p * (1 - x / 64) / 8 - 81 * sqrt(x + Rational(11, 16)) / 64
                    - Rational(57, 64),
                    True,
                ),
            ),
            -0.4,
            [-0.71875, -0.6834247],  # D = -23/32 by bisection
        ),
    ],
)  # fmt: skip
def test_a_crossing_is_drawn_once_where_both_borders_of_a_corner_are_met(
    pieces: tuple[tuple[sympy.Expr, sympy.Expr]], parameter: float, expected: list[float]
) -> None:
    *rest, (last, _) = pieces
    diagram = bifurcation_diagram(
        from_sympy(Piecewise(*rest, (last, True)), x, p), "p", SPAN, (1, 2), (-2.0, 2.0),
        search=Search(slices=63),
    )  # fmt: skip
    found = sorted(
        hit.x
        for hit in diagram.at(parameter)
        if hit.branch.order == 2
        and hit.branch.kind.value == "jump"
        and min(abs(hit.x - each) for each in expected) < 1e-3
    )
    assert len(found) == len(expected)


LOW, HIGH = -Rational(47, 32), Rational(29, 64)
BEND = 3 * x**2 / 8 + 23 * x / 64 + Rational(37, 32)
RING = from_sympy(
    Piecewise(
        (p / 2 - 7 * x / 24 - 31 * sqrt(LOW - x) / 32 + Rational(13, 64), x < LOW),
        (41 * p / 32 - x / 16 - Rational(3, 2), x < HIGH),
        (39 * p / 32 - BEND, True),
    ), x, p, words=["A", "B", "C"],
)  # fmt: skip


@pytest.mark.nightly
def test_a_crossing_that_comes_back_to_its_beginning_round_corners_closes() -> None:
    """It turns at three corners; at the first parameter C leads 29/64 to the border -47/32 of A."""
    diagram = bifurcation_diagram(RING, "p", SPAN, (3,), (-2.0, 2.0), search=Search(slices=31))
    (branch,) = [each for each in diagram.branches if len(each.words) > 1]
    (end,) = [point for point in diagram.points if branch.id in point.branches]
    assert (branch.ends, end.note) == ((end.id, end.id), "the branch closes")
    assert branch.parameter[0] == branch.parameter[-1]
    words = [stretch.word for stretch in branch.words]
    assert (words[0], len(words), len(set(words))) == (words[-1], 4, 3)
    corner = float(Rational(32, 39) * (LOW + BEND.subs(x, HIGH)))
    assert min(branch.parameter) == pytest.approx(corner, rel=2.0**-48)


@pytest.mark.slow
def test_a_closed_crossing_is_known_from_each_of_its_places() -> None:
    """It closes also where it begins in the last step before a corner, or right behind one."""
    settings, ring, network = Settings(span=SPAN, window=(-2.0, 2.0)), 0, None
    beside = (-0.0596194, -0.0472551)  # corners, by 1e-6
    for at in (*np.linspace(-0.0595, -0.0473, 25).tolist(), *beside):
        (found,) = slices_at(RING, at, (3,), settings)
        for jump in found.jumps:
            if jump.head.x[0] < float(LOW) + 0.1:
                continue  # another branch
            curve = Tasks(RING, settings).jump(jump).curve
            assert curve.ends[0] is curve.ends[1]
            assert len(curve.parameter) < 20
            if network is None:
                network = Network(settings)
                network.add(curve)
            known = Known(network, BranchKind.JUMP, 3, RING)
            closing = ending_at(len(jump.head), jump.code)
            assert known.explains(jump.head, closing, keys_of_jump(jump))
            ring += 1
    assert ring == 54  # it is met twice at each parameter


@pytest.mark.slow
def test_a_crossing_turns_round_where_the_root_of_a_piece_begins() -> None:
    """At the corner D, which begins with a root, leads its own border c to the border b.

    Two crossings, before and behind a piece that ends there, are one branch, and the third one,
    0.002 beside them, is not met. A limit that was off by c h, some 1e-10, took that one for them.
    """
    b, c = -p / 4 - Rational(23, 64), Rational(65, 64) - p / 4
    last = 45 * p * (51 * x / 256 + 1) / 32 + Rational(89, 64)
    map_ = Piecewise(
        ((67 * x - 47 * p * x - 27 * p - 9 * x**3 - 91) / 64, x < -p / 4 - Rational(27, 32)),
        ((-35 * p + 40 * x**2 - 32 * x + 43) / 64, x < b),
        (7 * p * x / 16 - 5 * x**3 / 64 + (-15 * p - 84 * x - 53) / 64, x < c),
        (last + 21 * sqrt(x - c) / 16, True),
    )
    diagram = bifurcation_diagram(
        from_sympy(map_, x, p, words=["A", "B", "C", "D"]), "p", SPAN, (3,), (-2.0, 2.0),
        search=Search(slices=15),
    )  # fmt: skip
    assert not [point for point in diagram.points if point.status is PointStatus.OPEN]
    (branch,) = [
        each
        for each in diagram.branches
        if "B | C | A / C | B | D" in [stretch.word for stretch in each.words]
    ]
    assert [stretch.word for stretch in branch.words] == [
        "B | D | C / B | D | B",
        "B | D | B / B | C | A",
        "B | C | A / C | B | D",
        "C | B | C / C | B | D",
    ]
    ends = sympy.Poly(last.subs(x, c) - b, p).nroots()
    at_b = (-35 * p + 40 * b**2 - 32 * b + 43) / 64
    born = sympy.Poly(at_b - c, p).nroots()  # there B leads b to c
    for stretch, roots in zip(branch.words[1:], (ends, born), strict=False):
        (corner,) = [float(root) for root in roots if abs(root) < 1]
        assert branch.parameter[stretch.first] == pytest.approx(corner, abs=1e-11)
