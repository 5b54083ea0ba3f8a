"""What is no system, no section or no call is refused in one sentence."""

import math
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
import sympy
from needs import SLOW_SYSTEM
from sympy.physics.mechanics import KanesMethod, Particle, Point, ReferenceFrame, dynamicsymbols

import woodpecker
from pwmap import PointStatus
from studies.systems import table
from woodpecker import Search, Settings, slices_at
from woodpecker.examples import bouncing_ball
from woodpecker.slices import nearest_border
from woodpecker.systems import (
    Contact,
    ContactSystem,
    CycleStatus,
    LineOfSystem,
    Section,
    SystemCycle,
    SystemMap,
    basins,
    bifurcation_diagram,
    continuation,
    from_kane,
    orbit_diagram,
    return_map,
    shoot,
    simulate,
)

# --- What is no system, no section or no call -----------------------------------------------------

x, y, v, w, t, g, mu = sympy.symbols("x y u_x u_y t g mu")
FLOOR = Contact(name="floor", gap=y, slip=v, mu=mu, eps_n=0.5)
GOOD = {
    "q": [x, y], "M": [[1, 0], [0, 1]], "h": [0, -g], "contacts": [FLOOR],
    "parameters": {g: 9.81, mu: 0.3},
}  # fmt: skip
BALL = ContactSystem(**GOOD)
REAL = sympy.symbols("x y t u_x g", real=True)  # other symbols than those above
NAMESAKE = ", and the system's {} has other assumptions, such as real=True: use one symbol"
SECTION = Section(when="floor", free=[v, w])


def system(**changes: Any) -> ContactSystem:
    return ContactSystem(**(GOOD | changes))


def contact(**changes: Any) -> Contact:
    return Contact(**({"name": "floor", "gap": y} | changes))


def section(**changes: Any) -> SystemMap:
    return SystemMap(
        BALL, Section(**({"when": "floor", "free": [v, w]} | changes)), backend="scipy"
    )


BOUNCE = Section(when="floor", free=["u_y"])


def falling(eps_n: Any, **values: float) -> SystemMap:
    """From one impact of a ball to the next, over these values or the weight."""
    floor = Contact(name="floor", gap=y, eps_n=eps_n)
    ball = ContactSystem([y], [[1]], [-g], [floor], {"g": 10.0, **values})
    return SystemMap(ball, BOUNCE, [*values] or ["g"], backend="scipy")


FALLING = falling(0.5).system


@cache
def bounces() -> SystemMap:
    return falling(0.5)


def on_a_table(**at: sympy.Expr) -> SystemMap:
    """From one impact of a ball with a table that moves to the next."""
    moves = Contact(name="table", gap=y - sympy.sin(t))
    bounce = Section(when="table", free=[w, t], at=at, period=2 * sympy.pi)
    return SystemMap(ContactSystem([y], [[1]], [-g], [moves], {g: 10.0}), bounce, backend="scipy")


def test_a_section_knows_where_it_is_told() -> None:
    """Also where the event is elsewhere, as that of a symmetric motion may be."""
    assert on_a_table(y=sympy.sin(t)).d == 2
    assert on_a_table(y=sympy.sin(t) + 1).d == 2


def map_of() -> SystemMap:
    return SystemMap(BALL, SECTION, ["g"], backend="scipy")


def no_cycle() -> SystemCycle:
    return SystemCycle(
        x=np.zeros((1, 2)), p=np.zeros(1), period=np.nan, word="", residual=np.nan,
        multipliers=np.zeros(2, dtype=complex), status=CycleStatus.LOST, message="lost",
    )  # fmt: skip


def kane(rate: int = 1) -> KanesMethod:
    q, u = dynamicsymbols("q u")
    frame, point = ReferenceFrame("N"), Point("P")
    point.set_vel(frame, rate * u * frame.x)
    method = KanesMethod(frame, q_ind=[q], u_ind=[u], kd_eqs=[q.diff() - rate * u])
    method.kanes_equations([Particle("p", point, 1)], [(point, -q * frame.x)])
    return method


HELD = r"map_.holding\(...\) has other values of parameters"
OF_A_LINE = "a map of the line is needed, such as .*got SystemMap"
CASES: list[tuple[Callable[[], object], str]] = [
    (lambda: contact(name=""), "a contact needs a name"),
    (lambda: contact(name=3), "a contact needs a name, got 3"),
    (lambda: contact(gap="y +"), "gap of 'floor' must be an expression"),
    (lambda: contact(gap=sympy.nan), "gap of 'floor' must be finite"),
    (lambda: contact(gap=[y]), "gap of 'floor' must be an expression"),
    (lambda: contact(slip=v, mu=-0.1), "mu of 'floor' must be >= 0"),
    (lambda: contact(slip=v, mu=sympy.I), "mu of 'floor' must be real"),
    (lambda: contact(mu=0.3), "has friction, and needs a slip: mu is 0.3$"),
    (lambda: contact(eps_n=1.5), r"eps_n of 'floor' must be in \[0, 1\], got 1.5"),
    (lambda: contact(eps_n=-0.5), r"eps_n of 'floor' must be in \[0, 1\]"),
    (lambda: system(q="x y"), "q must be a list of symbols"),
    (lambda: system(q=[]), "q must not be empty"),
    (lambda: system(q=[x, 1]), "q must be symbols, got 1"),
    (lambda: system(q=[x, dynamicsymbols("z")]), "q must be symbols, got .*from_kane"),
    (lambda: system(h=[0, dynamicsymbols("z")]), r"h has z\(t\), and z is not .*: from_kane takes"),
    (lambda: system(q=[x, x]), "x is used twice"),
    (lambda: system(u=[v]), "u must have 2 velocities"),
    (lambda: system(u=[v, x]), "x is used twice"),
    (lambda: system(M=[[1, 0]]), r"M must have the shape \(2, 2\), got \(1, 2\)"),
    (lambda: system(M="unit"), "M must be a matrix of expressions"),
    (lambda: system(M=[[1, 2], [3, 9]]), "M must be symmetric"),
    (lambda: system(M=[[1, 1], [1, 1]]), "M is singular"),
    (lambda: system(M=[[1, 2], [2, 1]]), r"M must be positive definite, got \[\[1.0, 2.0\], \["),
    (lambda: system(M=[[g, 0], [0, 1]]).replace(g=0.0), "M must be positive definite, got"),
    (lambda: system(M=[[v, 0], [0, 1]]), "M must not depend on the velocity u_x"),
    (lambda: system(h=[0]), r"h must have the shape \(2,\), got \(1,\)"),
    (lambda: system(h=[0, -sympy.Symbol("G")]),
     "h has the unknown symbol G, of which parameters has no value; it may have q, u, time and"),
    (lambda: system(h=[0, REAL[2]]), f"time and parameters{NAMESAKE.format('t')}"),
    (lambda: system(h=[0, -w], q=REAL[:2]), f"unknown symbol y, .*{NAMESAKE.format('y')}"),
    (lambda: contact(eps=0.5), r"Contact takes by name name, gap, .*eps_n, got eps=0.5$"),
    (lambda: system(mass=1), r"ContactSystem takes q, M, h, contacts, .*got mass=1$"),
    (lambda: system(contacts=[contact(name=f"c{i}") for i in range(31)]),
     "a system has at most 30 contacts, got 31"),
    (lambda: system(contacts=FLOOR), "contacts must be a list of Contact"),
    (lambda: system(contacts=[y]), "contacts must be Contact, got y"),
    (lambda: system(contacts=[FLOOR, FLOOR]), "contacts need different names"),
    (lambda: system(contacts=[contact(gap=y - v)]), "must not depend on the velocity u_x"),
    (lambda: system(contacts=[contact(gap=t - 1)]),
     "is one that no coordinate moves; .* a force that presses on it"),
    (lambda: system(contacts=[contact(gap=sympy.Symbol("z"))]), "has the unknown symbol z"),
    (lambda: system(contacts=[contact(slip=v**2, mu=mu)]), "must be linear in the velocities"),
    (lambda: system(contacts=[contact(slip=x, mu=mu)]), "is one that no velocity moves"),
    (lambda: system(contacts=[contact(slip=v, mu=x)]), "mu of 'floor' has the unknown symbol x"),
    (lambda: system(contacts=[contact(eps_n=y)]), "eps_n of 'floor' has the unknown symbol y"),
    (lambda: system(h=[0, sympy.gamma(y)]), r"an entry of h has gamma\(y\), and gamma is not supp"),
    (lambda: system(h=[0, sympy.Function("f")(y)]), r"h has f\(y\), and f is not supported"),
    (lambda: system(h=[0, sympy.Integral(x, (x, 0, y))]), "and Integral is not supported: there"),
    (lambda: system(h=[0, y > 0]), "an entry of h must be an expression of sympy or a number"),
    (lambda: system(h=[0, sympy.I * y]), r"an entry of h must be real, got I\*y"),
    (lambda: contact(gap=sympy.besselj(0, y)), r"and the functions sin, .*, Max, Min, Piecewise$"),
    (lambda: contact(eps_n=sympy.zeta(mu)), r"eps_n of 'floor' has zeta\(mu\), and zeta is not"),
    (lambda: section(when=sympy.Function("f")(t)), r"when has f\(t\), and f is not supported"),
    (lambda: section(at={x: sympy.Function("f")(mu)}), r"at x has f\(mu\), and f is not supported"),
    (lambda: system(parameters=[g]), "parameters must be a mapping"),
    (lambda: system(parameters={g: np.inf, mu: 0.3}), "parameter g must be finite"),
    (lambda: system(parameters={g: "9", mu: 0.3}), "parameter g must be one real number"),
    (lambda: system(parameters={g: 9.81, "g": 9.8, mu: 0.3}), "parameter g is given twice"),
    (lambda: system(parameters={g: 9.81}), "has the unknown symbol mu"),
    (lambda: system(law="moreau"), "law must be 'poisson' or 'newton', got 'moreau'"),
    (lambda: system(expansion_friction="no"), "must be 'separate' or 'summed'"),
    (lambda: BALL.replace(mu=-0.5), "mu of 'floor' must be >= 0, got -0.5"),
    (lambda: system(contacts=[contact(eps_n=2 * mu)], parameters={g: 1.0, mu: 0.6}), "got 1.2"),
    (lambda: BALL.replace(k=1.0), "unknown parameter 'k'"),
    (lambda: from_kane(3, [FLOOR], {}), "expected a KanesMethod or LagrangesMethod, got 3"),
    (lambda: from_kane(kane(2), [FLOOR], {}), "must be the rate of"),
    (lambda: section(when="wall"), "'wall' is no contact, the system has"),
    (lambda: section(when=sympy.Symbol("k")), "when has the unknown symbol k"),
    (lambda: section(when=g - 1), "when must have symbols of the state, got g - 1"),
    (lambda: section(free=["k"]), "free has k, which is no symbol of the state"),
    (lambda: section(at={v: 0}), "at has u_x, which is free or no symbol of the state"),
    (lambda: section(free=[REAL[3]]), rf"state \(.*\){NAMESAKE.format('u_x')}"),
    (lambda: section(at={REAL[0]: 0}), f"no symbol of the state{NAMESAKE.format('x')}"),
    (lambda: section(at={x: REAL[3]}), f"free nor a parameter{NAMESAKE.format('u_x')}"),
    (lambda: section(when=REAL[0]), f"the unknown symbol x{NAMESAKE.format('x')}"),
    (lambda: section(free=[v, t], period=REAL[4]), f"no parameter{NAMESAKE.format('g')}"),
    (lambda: section(freed=[v]), r"Section takes by name when, .*, horizon, got freed="),
    (lambda: section(at={x: y}), "at x has y, which is neither free nor a parameter"),
    (lambda: section(at=[x]), "at must be a mapping"),
    (lambda: section(sticking="floor"), "sticking must be a list of names"),
    (lambda: section(sticking=["wall"]), "'wall' is no contact"),
    (lambda: section(period=1), "a period is needed just if time is free"),
    (lambda: section(free=[v, t]), "a period is needed just if time is free"),
    (lambda: section(when=y - 2), "y - 2 must be zero on the section, and is -2: give y in at"),
    (lambda: on_a_table(), r"the gap of 'table' must be zero on the section, and is -sin\(t\)"),
    (lambda: section(horizon=0.0), "horizon must be positive and finite"),
    (lambda: SystemMap(BALL, SECTION, ["k"]), "unknown parameter 'k'"),
    (lambda: SystemMap(BALL, SECTION, "g"), "parameters must be a list of names"),
    (lambda: SystemMap(BALL, SECTION, g), "parameters must be a list of names, got g"),
    (lambda: SystemMap(BALL, SECTION, ["g", "g"]), r"parameters must differ, got \['g', 'g'\]"),
    (lambda: SystemMap(BALL, SECTION, events_most=-1), "events_most must be a whole number of at"),
    (lambda: SystemMap(BALL, SECTION, x_scale=[1.0]), "x_scale must be 2 positive numbers, got"),
    (lambda: SystemMap(BALL, SECTION, x_scale=(0, 1)), "x_scale must be positive and finite, got"),
    (lambda: SystemMap(BALL, SECTION, ["g"], p_scale=(1, 1)), "p_scale must be 1 positive number"),
    (lambda: Section(when="floor", free=[v, v]), "u_x is used twice in free"),
    (lambda: SystemMap(BALL, SECTION, backend="euler"), "backend must be 'heyoka' or 'scipy', "),
    (lambda: simulate(BALL, {}, 1.0, backend=3), "backend must be 'heyoka' or 'scipy', got 3"),  # type: ignore[arg-type]
    (lambda: simulate(BALL, [1.0], 1.0), "start must be a mapping"),
    (lambda: simulate(BALL, {"z": 1.0}, 1.0), "start has 'z', the state has"),
    (lambda: simulate(BALL, {"y": 1.0, y: 2.0}, 1.0), "start has 'y' twice, as a symbol and as a"),
    (lambda: simulate(BALL, {"y": np.nan}, 1.0), "start must be finite"),
    (lambda: simulate(BALL, {"y": -1.0}, 1.0), "the start penetrates 'floor': its gap is -1"),
    (lambda: simulate(system(M=[[x, 0], [0, 1]]), {"x": -0.5}, 1.0),
     r"M must be positive definite, got \[\[-0.5, 0.0\], \[0.0, 1.0\]\] at the start"),
    (lambda: simulate(BALL, {"y": 1.0}, -1.0), "t_end must lie after the start"),
    (lambda: simulate(BALL, {"y": 1.0}, 1.0, samples=1), "samples must be a whole number"),
    (lambda: simulate(SECTION, {"y": 1.0}, 1.0), "system must be woodpecker.systems.ContactSystem"),  # type: ignore[arg-type]
    (lambda: return_map(map_of(), [1.0, 2.0, 3.0]), r"x must have shape \(s, 2\)"),
    (lambda: return_map(map_of(), [[1.0, 2.0]], order=0), "order must be a whole number"),
    (lambda: return_map(map_of(), [[1.0, 2.0]], p=[1.0, 2.0]), r"p must have shape \(1,\)"),
    (lambda: shoot(map_of(), [1.0, 2.0], p=[np.nan]), r"p must be finite, got \[nan\]"),
    (lambda: shoot(map_of(), [1.0]), r"guess must have shape \(2,\), got \(1,\)"),
    (lambda: shoot(BALL, [1.0, 2.0]), "map_ must be woodpecker.systems.SystemMap"),  # type: ignore[arg-type]
    (lambda: continuation(map_of(), no_cycle(), (0, 1), [(0, 1)] * 2), "there is no cycle"),
    (lambda: continuation(bounces(), shoot(bounces(), [0.0]), (5, 20), [(0, 1)], orders=1),
     r"orders must be whole numbers such as \(1, 2\), got 1"),
    (lambda: shoot(bounces(), [np.nan]), r"guess must be finite, got \[nan\]"),
    (lambda: orbit_diagram(bounces(), [10.0], [[1.0]], 3), r"shape \(1, 2\), two ends of each"),
    (lambda: orbit_diagram(map_of(), [1.0], [[1.0, 2.0]], [(0, 1)]), "window must have shape"),
    (lambda: orbit_diagram(map_of(), [1.0], [1.0], [(0, 1)] * 2), r"starts must have shape \(s, 2"),
    (lambda: orbit_diagram(section(), [1.0], [[1, 2]], [(0, 1)] * 2), "no free parameter"),
    (lambda: LineOfSystem(map_of()), "one coordinate and one free parameter, got 2 and 1"),
    (lambda: bifurcation_diagram(map_of(), (0, 1), (1,), (0, 1)), "one coordinate"),
    (lambda: bifurcation_diagram(bounces(), (5, 20), (1,), (0, 1), progress=1),  # type: ignore[arg-type]
     "progress must be a function, got 1"),
    (lambda: basins(map_of(), [], [[1.0, 2.0]]), "at least one cycle is needed"),
    (lambda: basins(map_of(), [3], [[1.0, 2.0]]), "cycle must be"),  # type: ignore[list-item]
    (lambda: shoot(bounces(), [1.0], F=7),  # type: ignore[call-arg]
     f"shoot takes map_, guess, and by name order, p, transient, got F=7; {HELD}"),
    (lambda: return_map(bounces(), [1.0], 2), "by name order, p, got 2 by place"),  # type: ignore[misc]
    (lambda: SystemMap(FALLING, SECTION, order=2), "SystemMap takes .*got order=2"),  # type: ignore[call-arg]
    (lambda: SystemMap(FALLING, None), "section must be"),  # type: ignore[arg-type]
    (lambda: simulate(FALLING, {"y": 1.0}, 1.0, g=5.0),  # type: ignore[call-arg]
     r"simulate takes .*got g=5.0; system.replace\(...\) has other values"),
    (lambda: Search(foo=1), "Search takes by name slices, .*got foo=1"),  # type: ignore[call-arg]
    (lambda: slices_at(bounces(), 5.0, (1,), Settings(window=(0, 1))), OF_A_LINE),  # type: ignore[arg-type]
    (lambda: nearest_border(bounces(), 1.0, 5.0, 0.1), OF_A_LINE),  # type: ignore[arg-type]
]  # fmt: skip


@pytest.mark.parametrize(("call", "sentence"), CASES, ids=[sentence for _, sentence in CASES])
def test_what_is_wrong_is_said(call: Callable[[], object], sentence: str) -> None:
    with pytest.raises((TypeError, ValueError), match=sentence):
        call()


@pytest.mark.parametrize("none", [0, 0.0, -0.0, np.float64(0.0), sympy.Float(0)])
def test_a_contact_without_friction_needs_no_slip(none: object) -> None:
    assert not contact(mu=none).rubs


def test_a_free_parameter_has_an_effect() -> None:
    """One that only the section has may be free, too; others may stand unused in a system."""
    ball = system(parameters={g: 9.81, mu: 0.3, "eps": 0.8, "phase": 0.1})
    phase = sympy.Symbol("phase")
    at_phase = Section(when=sympy.sin(t - phase), free=[x, v], at={t: phase})
    assert SystemMap(ball, at_phase, ["phase", "mu"], backend="scipy").k == 2
    with pytest.raises(ValueError, match="nothing varies with eps: it occurs neither in the sys"):
        SystemMap(ball, at_phase, ["g", "eps"], backend="scipy")


def test_free_parameters_are_names_or_symbols() -> None:
    map_ = SystemMap(BALL, SECTION, [g, "mu"], backend="scipy")
    assert map_.parameters == ("g", "mu")
    assert map_.p.tolist() == [9.81, 0.3]  # of GOOD


def test_scales_of_a_map_may_be_arrays() -> None:
    map_ = SystemMap(BALL, SECTION, ["g"], x_scale=np.array([1, 2]), p_scale=[3], backend="scipy")
    assert (map_.x_scale, map_.p_scale) == ((1.0, 2.0), (3.0,))


# --- Laws that are none ---------------------------------------------------------------------------

OUT_OF_RANGE: list[Callable[[SystemMap, SystemCycle], object]] = [
    lambda map_, _: map_.holding(eps=1.5),
    lambda map_, _: shoot(map_, [0.0], p=[1.5]),
    lambda map_, _: return_map(map_, [0.0], p=[1.5]),
    lambda map_, _: orbit_diagram(map_, [0.5, 1.5], [1.0], [(0, 9)]),
    lambda map_, cycle: continuation(map_, cycle, (0.1, 1.5), [(-1, 1)], orders=(1,)),
    lambda map_, _: bifurcation_diagram(map_, (0.1, 1.5), (1,), (-1, 1)),
    lambda map_, _: woodpecker.shoot(LineOfSystem(map_), 1.0, p=1.5),
    lambda map_, _: woodpecker.return_map(LineOfSystem(map_), [1.0], p=1.5),
    lambda map_, _: woodpecker.orbit_diagram(LineOfSystem(map_), [0.5, 1.5], [1.0], (0, 9)),
    lambda map_, _: woodpecker.bifurcation_diagram(LineOfSystem(map_), "eps", (0.1, 1.5)),
]


@pytest.mark.parametrize("call", OUT_OF_RANGE)
def test_a_restitution_over_which_a_map_goes_is_one(
    call: Callable[[SystemMap, SystemCycle], object],
) -> None:
    """Also as a parameter it lies in [0, 1]: a ball that leaves faster than it came is no ball."""
    map_ = falling(sympy.Symbol("eps"), eps=0.5)
    with pytest.raises(ValueError, match=r"^eps_n of 'floor' must be in \[0, 1\], got 1\.5"):
        call(map_, shoot(map_, [1.0], p=[1.0]))  # each speed is one of a cycle there


def test_a_restitution_that_is_none_within_a_span_ends_the_map() -> None:
    """4 (p - 1/2)^2 - 1/10 is a restitution where p is 0.9, and none where it is 0.5."""
    p = sympy.Symbol("p")
    map_ = falling(4 * (p - sympy.Rational(1, 2)) ** 2 - sympy.Rational(1, 10), p=0.9)
    good = map_.at(np.array([1.0]), np.array([0.9]))
    assert good.value == pytest.approx([0.54], abs=1e-12)
    sentence = "eps_n of 'floor' must be in [0, 1], got -0.1"
    for source in (map_, good.piece):
        assert source.at(np.array([1.0]), np.array([0.5])).reason == sentence
    assert np.isnan(map_.search(np.array([1.0]), np.array([0.5])).point).all()


def test_a_mass_over_which_a_map_goes_is_positive() -> None:
    """Without an impact a negative one would have motions, and branches: those of no machine."""
    mass = sympy.Symbol("m")
    stop = Contact(name="the stop", gap=1 - x, eps_n=0.5)
    once = Section(when=sympy.sin(2 * t), free=[x, v], at={t: 0})

    def driven(inertia: sympy.Expr) -> SystemMap:
        push = [sympy.cos(2 * t) / 2 - x - v / 10]
        return SystemMap(
            ContactSystem([x], [[inertia]], push, [stop], {mass: 1.0}), once, ["m"],
            backend="scipy",
        )  # fmt: skip

    map_ = driven(mass)
    cycle = shoot(map_, [0.0, 0.0])
    # m x'' + x'/10 + x = cos(2 t)/2 has x(0) = (1 - 4 m)/2/((1 - 4 m)^2 + 1/25)
    assert cycle.x[0, 0] == pytest.approx(-1.5 / (9 + 1 / 25), abs=1e-12)
    for call in (
        lambda: shoot(map_, [0.0, 0.0], p=[-1.0]),
        lambda: continuation(map_, cycle, (-1.0, 2.0), [(-9, 1), (-9, 9)]),
    ):
        with pytest.raises(ValueError, match=r"^M must be positive definite, got \[\[-1\.0\]\]$"):
            call()
    beyond = driven(mass + x)  # at x = 0 and m = -1 it is -1
    sentence = "M must be positive definite, got [[-1.0]]"
    good = beyond.at(np.zeros(2), np.ones(1))
    for source in (beyond, good.piece):
        assert source.at(np.zeros(2), -np.ones(1)).reason == sentence


@SLOW_SYSTEM
def test_a_branch_says_which_law_ends_it() -> None:
    """4 (p - 1/2)^2 - 1/10 is negative below p = 1/2 + sqrt(1/40)."""
    p = sympy.Symbol("p")
    law = 4 * (p - sympy.Rational(1, 2)) ** 2 - sympy.Rational(1, 10)
    height = table.GAMMA * sympy.cos(table.T)
    plate = Contact(name="the table", gap=table.Y - height, eps_n=law)
    ball = ContactSystem([table.Y], [[1]], [-1], [plate], {table.GAMMA: 3.4, p: 0.7})
    section = Section(
        when="the table", free=[table.V, table.T], at={table.Y: height}, period=2 * sympy.pi,
        first=math.pi, horizon=table.HORIZON,
    )  # fmt: skip
    map_ = SystemMap(ball, section, ["p"])
    sine = math.pi / 3.4 * 0.94 / 1.06
    cycle = shoot(map_, [math.pi, 2.0 * math.pi - math.asin(sine)], p=[0.7])
    found = continuation(map_, cycle, (0.25, 0.7), [(0, 10), (0, 10)], orders=(1,))
    (end,) = (point for point in found.diagram.points if point.status is PointStatus.OPEN)
    assert end.parameter == pytest.approx(0.5 + math.sqrt(1 / 40), abs=1e-9)
    assert end.cause.startswith("eps_n of 'the table' must be in [0, 1], got -")


def driven(when: sympy.Expr, free: list[sympy.Symbol], time: Any = 0) -> SystemMap:
    """x'' + x = sin(3 t), whose periodic motion is x = -1/8 sin(3 t), far from a wall."""
    wall = Contact(name="wall", gap=5 - x, eps_n=1)
    system = ContactSystem([x], [[1]], [sympy.sin(3 * t) - x], [wall], {})
    return SystemMap(system, Section(when=when, free=free, at={t: time}), backend="scipy")


def test_a_section_that_fixes_too_little_is_told() -> None:
    """From rest at 3^(1/2)/8 the motion leads there in 2 pi/3, with a speed of -3/4."""
    once = sympy.sin(3 * t)
    with pytest.raises(
        ValueError,
        match=r"^the motion returns with u_x = -0.75, and the section has 0: name u_x in",
    ):
        shoot(driven(once, [x]), [0.2])
    with pytest.raises(ValueError, match="name u_x in its free symbols"):
        shoot(driven(once, [x]), [0.2], order=2)
    whole = shoot(driven(once, [x, v]), [0.1, 0.0])
    assert whole.x[0] == pytest.approx([0.0, -3 / 8], abs=1e-9)


def test_a_section_at_another_time_than_its_event_is_told() -> None:
    """cos(3 t) = 0 at t = pi/6, where sin(3 t) is 1, and not at t = 0."""
    with pytest.raises(ValueError, match="and the section has 0: name t in its free symbols"):
        shoot(driven(sympy.cos(3 * t), [x, v]), [0.1, 0.0])
    # a section may be given at any of its events, where the cosine rises
    for k in (-1, 3):
        found = shoot(driven(sympy.cos(3 * t), [x, v], k * sympy.pi / 6), [0.1, 0.0])
        assert abs(found.x[0]) == pytest.approx([1 / 8, 0.0], abs=1e-9)  # x = -1/8 sin(3 t)


# --- Guesses that lead nowhere --------------------------------------------------------------------

OSCILLATOR = ContactSystem(
    [x], [[1]], [sympy.cos(3 * t) / 10 - x - v / 5],
    [Contact(name="the stop", gap=1 - x, eps_n=0.5)], {},
)  # fmt: skip
PHASE = Section(when=sympy.sin(3 * t), free=[x, v], at={t: 0})
RISE = Section(when=x - 0.9, free=[v, t], at={x: 0.9}, period=2 * sympy.pi / 3, horizon=50)
LONGEST = "the longest time of the section"
LEADS_NOWHERE = [
    (OSCILLATOR, PHASE, [1.5, 0.0],
     "from x = 1.5 and u_x = 0, the start penetrates 'the stop': its gap is -0.5"),
    (OSCILLATOR, RISE, [0.2, 0.3],
     f"from u_x = 0.2 and t = 0.3, x - 0.9 does not rise through zero within 50 s, {LONGEST}"),
    (FALLING, BOUNCE, [-1.0],
     "from u_y = -1, the start moves into 'floor', which it has just left: the rate of its gap "
     "is -1"),
    (FALLING, BOUNCE, [0.0],
     "from u_y = 0, the system stays at rest: contacts hold all of it"),
    (FALLING.replace(g=-1.0), BOUNCE, [1.0],
     f"from u_y = 1, 'floor' is not struck within 10000 s, {LONGEST}"),
]  # fmt: skip


@pytest.mark.parametrize(("of", "on", "guess", "why"), LEADS_NOWHERE)
def test_a_guess_that_does_not_return_is_told_why(
    of: ContactSystem, on: Section, guess: list[float], why: str
) -> None:
    found = shoot(SystemMap(of, on, backend="scipy"), guess)
    assert found.status is CycleStatus.LOST
    assert found.message == f"a start on the way does not return to the section: {why}"


def test_a_section_names_all_contacts_that_stick() -> None:
    both = Section(when=x, free=[v], sticking=["floor", "wall"], horizon=50)
    assert both.missed == (
        f"x does not rise through zero while 'floor' and 'wall' stick within 50 s, {LONGEST}"
    )


def test_values_may_be_exact_numbers() -> None:
    """A multiple of pi is a number wherever one is expected; a symbol is none."""
    ball, half = bouncing_ball(), sympy.pi / 2
    cases = (half, sympy.pi, 3 * half), (math.pi / 2, math.pi, 1.5 * math.pi)
    motions = [
        simulate(ball.replace(g=g), {"y": y}, t_end, backend="scipy") for y, g, t_end in cases
    ]
    assert motions[0].word == motions[1].word
    assert motions[0].z.tolist() == motions[1].z.tolist()
    a = sympy.Symbol("a", real=True)
    with pytest.raises(ValueError, match="parameter g must be one real number, got a"):
        ContactSystem(ball.q, ball.M, ball.h, ball.contacts, {"g": a})
