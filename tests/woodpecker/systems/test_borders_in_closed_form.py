"""Borders whose place is known in closed form: two roots of a guard meet, a section is reached."""

import math

import numpy as np
import pytest
import sympy
from needs import EACH_BACKEND, NEEDS_HEYOKA
from scipy.optimize import brentq

from pwmap.diagrams.diagram import PointKind
from woodpecker.base.arrays import Floats
from woodpecker.systems import Contact, ContactSystem, Section, SystemMap, continuation, shoot

# --- A push that just brings a mass to a stop -----------------------------------------------------

# A mass slides on ground that moves with speed 1, under a cos t and friction mu. Slower than the
# ground, its speed is u_0 + a sin t + mu t, which is greatest at t* with a cos t* = -mu. If it
# reaches 1 before, the mass sticks until t*, and forgets where it came from. So the speed one
# period later is
#
#     u_0 + 2 pi mu,  or  1 - a sin t* + mu (2 pi - t*)  where it sticks,
#
# and both are the same at u_0 = 1 - a sin t* - mu t*.

A, MU = 2.0, 0.3
TURN = math.acos(-MU / A)
BORDER = 1.0 - A * math.sin(TURN) - MU * TURN
STUCK = 1.0 - A * math.sin(TURN) + MU * (2.0 * math.pi - TURN)
NONE: Floats = np.zeros(0)


def pushed(backend: str) -> SystemMap:
    x, y, v, t = sympy.symbols("x y u_x t")
    ground = Contact(name="ground", gap=y, slip=v - 1, mu=sympy.Rational(3, 10))
    mass = ContactSystem([x, y], sympy.eye(2), [2 * sympy.cos(t), -1], [ground], {})
    return SystemMap(mass, Section(when=sympy.sin(t), free=[v], at={t: 0}), backend=backend)


@pytest.mark.nightly
@EACH_BACKEND
@pytest.mark.parametrize("away", [-1, 0, 1])
def test_the_piece_that_sticks_has_a_value_at_its_border(backend: str, away: int) -> None:
    """Also a spacing of doubles beyond; its margin is the square of the rate of the slip there.

    That has the derivative 2 a sin t* in u_0; rounding of its time, a root, is left of others.
    """
    map_ = pushed(backend)
    piece = map_.at(np.array([BORDER + 1e-3]), NONE).piece
    assert piece.word == "J1 S1"
    there = piece.at(np.array([BORDER + away * 2.0**-52]), NONE)
    assert there.reason == ""
    assert there.value == pytest.approx([STUCK], abs=1e-13)
    assert there.jacobian == pytest.approx(np.zeros((1, 1)), abs=1e-6)
    causes = [piece.cause(code) for code in there.codes.tolist()]
    k = causes.index("ground stops sliding for an instant only in phase 0")
    assert there.margins[k] == pytest.approx(0.0, abs=1e-13)
    assert there.gradients[k] == pytest.approx([2.0 * A * math.sin(TURN)], rel=1e-6)


@pytest.mark.nightly
@EACH_BACKEND
@pytest.mark.parametrize(("way", "word", "slope"), [(1.0, "J1 S1", 0.0), (-1.0, "", 1.0)])
def test_what_lies_on_both_sides(backend: str, way: float, word: str, slope: float) -> None:
    image = pushed(backend).beside(np.array([BORDER]), NONE, np.array([way]))
    assert image.reason == ""
    assert image.piece.word == word
    assert image.value == pytest.approx([STUCK], abs=1e-12)
    assert image.jacobian == pytest.approx(np.array([[slope]]), abs=1e-6)


# --- A section that counts only while a contact sticks, reached as it begins to -------------------

X, Y, Z, T, V, W, U, F = sympy.symbols("x y z t v w u F")
START, FRICTION = 2.5, 0.5  # phase of the section; friction over weight


def sticking() -> SystemMap:
    """A block that a force F sin t lets slip twice in a period; beside it y = -cos(t - 2.5)."""
    floor = Contact(name="the floor", gap=Z, slip=V, mu=FRICTION)
    force = [F * sympy.sin(T), -Y, -1]
    system = ContactSystem([X, Y, Z], sympy.eye(3), force, [floor], {F: 0.6}, u=[V, W, U])
    section = Section(when=W, free=[Y], at={T: START}, sticking=["the floor"], horizon=50.0)
    return SystemMap(system, section, ["F"], backend="scipy")


def stops(force: float) -> float:
    """When the second slip of a period ends, less 2 pi: F (cos a - cos t) = mu (t - a)."""
    a = math.asin(FRICTION / force)
    moved = lambda t: force * (math.cos(a) - math.cos(t)) - FRICTION * (t - a)  # noqa: E731
    return float(brentq(moved, math.pi - a, 2.0 * math.pi, xtol=1e-15))


@pytest.mark.slow
def test_the_border_is_where_the_block_stops_on_the_section() -> None:
    map_ = sticking()
    border = brentq(lambda force: stops(force) - START, 0.51, 0.8, xtol=1e-15)
    y, near = np.array([-1.0]), 1e-7
    image = map_.at(y, np.array([border - near]))
    assert image.piece.word == "S1 J1 S1 J1"
    code = int(image.codes[image.margins.argmin()])
    assert image.piece.cause(code) == (
        "the section is reached before phase 4 begins: an event falls on the section; choose a "
        "section away from it"
    )
    for force in (border - near, border + near):  # on both sides the margin is the duration
        there = image.piece.at(y, np.array([force]))
        margin = there.margins[there.index_of(code)]
        # a slip that starts at the edge of its cone is known to the root of rounding
        assert margin == pytest.approx(START - stops(force), abs=1e-10)
        rate = -(stops(force + 1e-4) - stops(force - 1e-4)) / 2e-4
        assert there.gradients[there.index_of(code)][1] == pytest.approx(rate, rel=1e-6)
    assert map_.at(y, np.array([border + near])).piece.word != image.piece.word


# --- A gap that hardly closes before it does ------------------------------------------------------


@EACH_BACKEND
@pytest.mark.parametrize("least", [0.1, 1e-6])
def test_the_gap_that_ends_a_phase_may_graze_before(backend: str, least: float) -> None:
    """It is least + (t - 1)^2 (2 - t): least after 1 s, and zero a little after 2 s."""
    gap = least + (T - 1) ** 2 * (2 - T)
    wall = Contact(name="the wall", gap=-X, eps_n=1)
    pushed = ContactSystem([X], [[1]], [-gap.diff(T, 2)], [wall], {}, u=[V])
    once = Section(when=sympy.sin(2 * sympy.pi * T / 3), free=[X, V], at={T: 0})
    start = -np.array([float(each.subs(T, 0)) for each in (gap, gap.diff(T))])
    image = SystemMap(pushed, once, backend=backend).at(start, NONE)
    k = int(np.abs(image.margins - least).argmin())
    assert image.piece.cause(int(image.codes[k])) == "the wall grazes in phase 0"
    assert image.margins[k] == pytest.approx(least, abs=1e-12)
    assert image.gradients[k] == pytest.approx([-1.0, -1.0], abs=1e-9)


# --- Events that fall on a section ----------------------------------------------------------------


PASSING = (  # a free particle, with speed 1 from 1 before the wall; it strikes after a second
    ContactSystem([X], [[1]], [0], [Contact(name="the wall", gap=2 - X)], {}, u=[V]),
    [1.0 - 1e-3, 1.0],
    "the wall touches in the instant in which the section is reached at the end of phase 0: an "
    "event falls on the section; choose a section away from it",
)
STOPPING = (  # with the friction 0.3 a sled stops in a second from a speed of 0.3
    ContactSystem(
        [X, Z], sympy.eye(2), [0, -1], [Contact(name="the ground", gap=Z, slip=V, mu=MU)], {},
        u=[V, W],
    ),
    [0.0, MU + 1e-3],
    "the ground stops sliding in the instant in which the section is reached at the end of "
    "phase 0: an event falls on the section, and a return from where a contact sticks has "
    "fewer dimensions; choose a section away from it",
)  # fmt: skip


@pytest.mark.parametrize(("system", "start", "said"), [PASSING, STOPPING], ids=["strike", "stop"])
def test_an_event_on_the_section_is_told(
    system: ContactSystem, start: list[float], said: str
) -> None:
    """Once in a second."""
    once = Section(when=sympy.sin(2 * sympy.pi * T), free=[X, V], at={T: 0})
    image = SystemMap(system, once, backend="scipy").at(np.array(start), NONE)
    k = int(np.abs(image.margins).argmin())
    assert image.margins[k] == pytest.approx(1e-3, abs=1e-12)
    assert image.piece.cause(int(image.codes[k])) == said


# --- A slip that ends with the gap ----------------------------------------------------------------


@pytest.mark.parametrize("length", [1.0, 1e6])
def test_a_slip_that_ends_with_the_gap_is_no_border(length: float) -> None:
    """A rod strikes a wall at 30 degrees, and rubs along it: both speeds are those of its turn.

    So in the compression slip and gap come to rest in one, and no path has another order. In
    micrometres rounding of that slip exceeded what counted as zero, and was a border. With the arms
    c = cos a and mu s = mu sin a of both forces the rod leaves with eps (c - mu s)/(c + mu s) of
    its speed.
    """
    turn, rate = sympy.symbols("th u_th")
    mu, eps = 0.25, 0.7
    wall = Contact(
        name="the wall", gap=length * (sympy.Rational(1, 2) - sympy.sin(turn)),
        slip=length * sympy.sin(turn) * rate, mu=mu, eps_n=eps,
    )  # fmt: skip
    rod = ContactSystem([turn], [[length**2]], [0], [wall], {})
    once = Section(when=sympy.sin(2 * sympy.pi * T), free=[turn, rate], at={T: 0})
    image = SystemMap(rod, once, backend="scipy").at(np.array([0.1, 0.9]), NONE)
    assert image.piece.word == "I1"
    cosine, sine = math.sqrt(0.75), 0.5
    kept = eps * (cosine - mu * sine) / (cosine + mu * sine)
    left = 1.0 - (math.pi / 6 - 0.1) / 0.9  # of the period
    expected = [math.pi / 6 - kept * 0.9 * left, -kept * 0.9]
    assert image.value == pytest.approx(expected, abs=1e-13)
    causes = [image.piece.cause(code) for code in image.codes.tolist()]
    assert "the wall just leaves in the compression at the start of phase 1" in causes
    assert "the wall just stops sliding in the expansion at the start of phase 1" in causes
    assert not any("stops sliding in the compression" in cause for cause in causes)


# --- An impact that crosses the phase of the section ----------------------------------------------


def on_table(a: float, phase: float) -> tuple[SystemMap, list[float]]:
    """A ball on a table at a sin(2 pi t + pi/4), seen once a second; its bounce in closed form.

    Under the gravity 12 pi, with the restitution 1/2, it strikes in every second where the table
    rises with 2 pi a cos(2 pi t + pi/4) = 2 pi: at t = 0 for a = sqrt 2.
    """
    amplitude, g = sympy.Symbol("a"), 12.0 * math.pi
    at = amplitude * sympy.sin(2 * sympy.pi * T + sympy.pi / 4)
    table = Contact(name="table", gap=X - at, eps_n=sympy.S.Half)
    ball = ContactSystem([X], [[1]], [-12 * sympy.pi], [table], {amplitude: a}, u=[V])
    section = Section(when=sympy.sin(2 * sympy.pi * (T - phase)), free=[X, V], at={T: phase})
    flown = (phase - (math.acos(1.0 / a) / (2.0 * math.pi) - 0.125)) % 1.0  # since the last impact
    height = math.sqrt(a**2 - 1.0) + g / 2.0 * flown - g * flown**2 / 2.0
    return SystemMap(ball, section, [amplitude]), [height, g / 2.0 - g * flown]


@NEEDS_HEYOKA
@pytest.mark.slow
@pytest.mark.parametrize("start", [1.38, 1.45])
def test_a_branch_goes_on_where_an_impact_falls_on_the_section(start: float) -> None:
    """From either side; its multipliers have the product 1/4 and a sum without regard to sections.

    Linearised, times and speeds of impacts have (1 + e)^2 h''/g + 1 + e^2 as the sum, where the
    acceleration of the table is h'' = -4 pi^2 sqrt(a^2 - 1).
    """
    map_, bounce = on_table(start, 0.0)
    found = continuation(
        map_, shoot(map_, bounce), (1.36, 1.47), [(0, 3), (-30, 30)], orders=(1,), step=0.05,
        max_step=0.2,
    )  # fmt: skip
    points = sorted(found.diagram.points, key=lambda point: point.parameter)
    assert [point.kind for point in points] == [PointKind.EP, PointKind.PD, PointKind.EP]
    assert len(found.diagram.branches) == 2  # on both sides of the flip
    for branch in found.diagram.branches:
        for k, value in enumerate(branch.parameter.tolist()):
            total = 1.25 - 0.75 * math.pi * math.sqrt(value**2 - 1.0)
            largest = max(np.roots([1.0, -total, 0.25]), key=abs)
            size = largest.real if largest.imag == 0.0 else abs(largest)
            assert branch.multiplier[k] == pytest.approx(size, abs=1e-6)  # a root at the flip
            if abs(value - math.sqrt(2.0)) > 1e-9:
                state = branch.x[k], branch.columns[str(V)][k]
                assert state == pytest.approx(on_table(value, 0.0)[1], abs=1e-9)


@NEEDS_HEYOKA
@pytest.mark.slow
def test_a_diagram_of_two_iterates_does_not_depend_on_the_phase_of_its_section() -> None:
    """One of the two impacts of its double cycles crosses the phase 0, and none the other."""
    crossed, other = (
        continuation(
            map_, shoot(map_, bounce), (1.4, 1.6), [(0, 8), (-40, 40)], step=0.05, max_step=0.3
        ).diagram
        for map_, bounce in (on_table(1.45, 0.0), on_table(1.45, 0.6))
    )
    assert any(len(branch.words) > 1 for branch in crossed.branches)
    places = [[(p.kind, p.parameter) for p in each.points] for each in (crossed, other)]
    assert [kind for kind, _ in places[0]] == [kind for kind, _ in places[1]]
    assert [at for _, at in places[0]] == pytest.approx([at for _, at in places[1]], abs=1e-9)
    assert len(crossed.branches) == len(other.branches)
