"""Pieces that end in a root, a + b h^s + c h at a distance h from their border, of any power."""

from typing import Any

import numpy as np
import pytest
import sympy
from sympy import Expr, Piecewise, Rational, log, sqrt, symbols

from pwmap.diagrams.diagram import BranchKind, Diagram, PointStatus
from woodpecker import Search, Settings, bifurcation_diagram, from_sympy
from woodpecker.base.arrays import Floats
from woodpecker.engine.curves import CurveSettings
from woodpecker.engine.formulas import expression_map
from woodpecker.engine.maps import root_of
from woodpecker.search.connected import connected
from woodpecker.search.curves import keys_of_jump
from woodpecker.search.duplicates import Duplicates
from woodpecker.search.network import Network
from woodpecker.search.tasks import Tasks, base_of
from woodpecker.slices import slices_at
from woodpecker.slices.orbits import ending_at, problem_of, to_engine

x, y, p = symbols("x y p", real=True)
POWERS = [Rational(k, 20) for k in (2, 3, 5, 9, 10, 11, 13, 15, 18, 19)]


@pytest.mark.parametrize("power", POWERS, ids=str)
@pytest.mark.parametrize("linear", [0, 1, -3])
def test_value_and_power_of_a_root_are_known_to_rounding(power: Rational, linear: int) -> None:
    h = p / 8 + Rational(3, 7) - x
    map_ = expression_map(
        (x,), (p,), {"L": (p / 2 + 3 * h**power / 4 + linear * h,)}, {"L": {"0": h}}
    )
    at = 0.3713
    border = np.array([at / 8 + 3 / 7])
    for way in ([-1.0, 0.0], [-1.0, 0.7]):
        root = root_of(map_.pieces[0], border, np.array([at]), np.array(way))
        assert root is not None
        assert root.exponent == pytest.approx(float(power), abs=1e-12)
        assert root.value[0] == pytest.approx(at / 2, abs=4e-15)  # some ten spacings


H = Rational(3, 7) - x  # the distance from a border


def root_at_border(value: Expr) -> Any:
    """What is told of a piece that ends there."""
    map_ = expression_map((x,), (p,), {"L": (value,)}, {"L": {"0": H}})
    return root_of(map_.pieces[0], np.array([3 / 7]), np.zeros(1), np.array([-1.0, 0.0]))


@pytest.mark.parametrize("bend", [10**6, 2 * 10**7])
def test_a_steep_root_that_bends_is_looked_at_closer(bend: int) -> None:
    """1/2 - 500 h^(1/2) (1 + K h): at h = 2^-33 the next term is K / 2^33 of the first."""
    root = root_at_border(Rational(1, 2) - 500 * H ** Rational(1, 2) * (1 + bend * H))
    assert root.exponent == 0.5
    # Values closer than 1e-7 are one. Rounding of h = 2^-41 leaves 2^-14 of it, and 1e-8 of values.
    # Where only h = 2^-33 was looked at the next term left errors of 9e-6 and 2e-4.
    assert root.value[0] == pytest.approx(0.5, abs=1e-7)


@pytest.mark.parametrize(
    "value",
    [
        # A root of h + 2^-34 looks like one at h = 2^-33, and does not closer to h = 0.
        Rational(1, 2) - 500 * (H + Rational(1, 2**34)) ** Rational(1, 2),
        # log h falls for ever, and so does h^(1/500) by all that doubles tell: its limit is -500
        # off. Returns of the toy that end in an endless fall are like that; a limit of -114 was
        # made of -3.
        log(H),
        500 * H ** Rational(1, 500),
        p + 50 * H + H**2,
    ],
    ids=["root at another border", "logarithm", "like a logarithm", "smooth"],
)
def test_what_is_no_root(value: Expr) -> None:
    assert root_at_border(value) is None


@pytest.mark.slow
@pytest.mark.parametrize(
    ("border", "left", "right", "power", "exact"),
    [  # left - h^s/8 below the border, right above it: cycles end where a limit lies on the border
        (Rational(1, 8) - p / 4, p - 1, p + Rational(5, 8), Rational(13, 20), [0.9, -0.4]),
        (
            Rational(1, 4) - p / 8,
            p - Rational(7, 8),
            p - Rational(3, 4),
            Rational(7, 10),
            [1, 8 / 9],
        ),
        (Rational(1, 8), p - Rational(1, 8), p + Rational(1, 4), Rational(1, 10), [0.25, -0.125]),
    ],
)
def test_cycles_and_jumps_end_at_roots_where_they_are_said_to(
    border: Expr, left: Expr, right: Expr, power: Rational, exact: list[float]
) -> None:
    formula = Piecewise((left - (border - x) ** power / 8, x < border), (right, True))
    diagram = bifurcation_diagram(
        from_sympy(formula, x, p), "p", (-1.5, 1.5), (1,), (-3, 3), search=Search(slices=3)
    )
    met = [point for point in diagram.points if point.kind.value in ("BC", "FF")]
    assert sorted(point.parameter for point in met) == pytest.approx(sorted(exact), abs=1e-13)
    for point in met:
        assert min(abs(point.parameter - each) for each in exact) <= point.precision


@pytest.mark.nightly
def test_a_limit_on_its_border_for_all_parameters_is_no_error() -> None:
    """There rounding decides on which side of the border it lies."""
    left, right = p * (-3 * x / 2 - Rational(3, 4)) - Rational(1, 4), (x + Rational(1, 2))
    formula = Piecewise(
        (left, x < -Rational(1, 2)), (-11 * p * right ** Rational(1, 4) / 8 - Rational(1, 2), True)
    )
    diagram = bifurcation_diagram(
        from_sympy(formula, x, p), "p", (-1.5, 1.5), (1,), (-3, 3), search=Search(slices=3)
    )
    assert diagram.branches


BESIDE_ROOTS = CurveSettings(spans=((-1.5, 1.5),), window=((-4.0, 4.0), (-4.0, 4.0)))


@pytest.mark.slow
@pytest.mark.parametrize("power", [Rational(1, 4), Rational(1, 2), Rational(3, 4)], ids=str)
def test_jumps_of_the_plane_cross_beside_a_root(power: Rational) -> None:
    """At x = c both limits are known: c = (1 - s) (p/3 - 7/8) + s p, y = (1 - s) c/2 + 2 s/5."""
    border = -p / 7 + Rational(1, 9)
    h = border - x
    pieces = {
        "L": (p / 3 - Rational(7, 8) - 5 * h**power / 8, y / 2 + x / 4),
        "R": (p, y / 2 + Rational(1, 5)),
    }
    map_ = expression_map((x, y), (p,), pieces, {"L": {"0": h}, "R": {"0": -h}})
    found = connected(
        map_, [0.9, 0.4], [0.9], BESIDE_ROOTS, orders=(1,), names=("p", "x", "y")
    ).diagram
    assert not [point for point in found.points if point.status.value == "open"]
    (jump,) = (branch for branch in found.branches if branch.kind.value == "jump")
    at = jump.parameter
    assert at[[0, -1]] == pytest.approx([7 / 72, 1.5], abs=1e-15)
    c, inner = -at / 7 + 1 / 9, at / 3 - 7 / 8
    s = (c - inner) / (at - inner)
    assert jump.columns["y"] == pytest.approx((1 - s) * c / 2 + 2 * s / 5, abs=1e-14)


# --- Jump crossings of P_2 that change their border where a root begins, against closed forms -----

# Beyond x = c(p) a piece begins with a root: D(x) = D(c) + sqrt(x - c)/8. Where D(c) passes a
# border b(p) the crossing leaves c: its first point goes on at c + 64 (b - D(c))^2, from where D
# leads to b.
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


LOW, HIGH = -Rational(47, 32), Rational(29, 64)
BEND = 3 * x**2 / 8 + 23 * x / 64 + Rational(37, 32)
RING = from_sympy(
    Piecewise(
        (p / 2 - 7 * x / 24 - 31 * sqrt(LOW - x) / 32 + Rational(13, 64), x < LOW),
        (41 * p / 32 - x / 16 - Rational(3, 2), x < HIGH),
        (39 * p / 32 - BEND, True),
    ), x, p, words=["A", "B", "C"],
)  # fmt: skip


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
            curve = Tasks.of_line(RING, settings).jump(jump).curve
            assert curve.ends[0] is curve.ends[1]
            assert len(curve.parameter) < 20
            if network is None:
                network = Network(settings)
                network.add(curve)
            known = Duplicates(network, BranchKind.JUMP, 3, base_of(RING, settings))
            problem = problem_of(settings, *ending_at(len(jump.head), jump.code))
            assert known.explains(to_engine(jump.head), problem, keys_of_jump(jump))
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
