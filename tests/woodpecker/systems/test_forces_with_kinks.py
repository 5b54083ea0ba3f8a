"""Forces with kinks, against closed forms; jumps and kinks elsewhere are refused."""

import math
from collections.abc import Callable

import numpy as np
import pytest
import sympy
from needs import EACH_BACKEND, NEEDS_HEYOKA, SLOW_SYSTEM
from scipy.integrate import solve_ivp
from sympy import Abs, Heaviside, Max, Min, Mod, Piecewise, Rational, real_root, sign, sqrt, tanh

from woodpecker.systems import (
    Contact,
    ContactSystem,
    MotionStatus,
    Section,
    SystemMap,
    shoot,
    simulate,
)

X, V, T = sympy.symbols("x u_x t")
K, G, W = sympy.symbols("k g w")
PARAMETERS = {K: 4.0, G: 0.25, W: 1.1}


def on_a_spring(force: sympy.Expr, **values: float) -> ContactSystem:
    return ContactSystem([X], [[1]], [force], [], PARAMETERS).replace(**values)


def bilinear(time: float, k: float) -> np.ndarray:
    """x, x' and x'' of x'' = -x for x < 0, -k x for x > 0, from x = -1 at rest."""
    w = math.sqrt(k)
    time %= math.pi * (1.0 + 1.0 / w)
    past, inside = time - math.pi / 2.0, math.pi / w
    if past <= 0.0:
        return np.array([-math.cos(time), math.sin(time), math.cos(time)])
    if past <= inside:
        s, c = math.sin(w * past), math.cos(w * past)
        return np.array([s / w, c, -w * s])
    left = past - inside
    return np.array([-math.sin(left), -math.cos(left), math.sin(left)])


@EACH_BACKEND
def test_a_bilinear_spring_has_its_closed_form(backend: str) -> None:
    """x = a y(s): with the phase s and the amplitude a, derivatives follow from y, y' and y''."""
    spring = -Piecewise((X, X < 0), (K * X, True))
    once = Section(when=sympy.sin(W * T), free=[X, V], at={T: 0})
    map_ = SystemMap(on_a_spring(spring), once, ["k"], backend=backend)
    k, a, later = 4.0, 0.7, 2.0 * math.pi / 1.1
    for phase in (0.3, 2.0, 4.0):
        (y, v, b), (yy, vv, bb) = bilinear(phase, k), bilinear(phase + later, k)
        image = map_.at(a * np.array([y, v]), np.array([k]))
        start, end = np.array([[y, a * v], [v, a * b]]), np.array([[yy, a * vv], [vv, a * bb]])
        assert image.value == pytest.approx(a * np.array([yy, vv]), abs=1e-11)
        assert image.jacobian[:, :2] == pytest.approx(end @ np.linalg.inv(start), abs=1e-10)


def test_a_guess_may_settle_before_a_cycle_is_sought() -> None:
    """Two wells, at -2 and 2, with a saddle between them: Newton's method goes to the saddle."""
    wells = Piecewise((2 - X, X > 1), (-2 - X, X < -1), (X, True)) - V / 2
    system = ContactSystem([X], [[1]], [wells], [], {})
    map_ = SystemMap(system, Section(when=sympy.sin(T), free=[X, V], at={T: 0}), [])
    for transient, x, stable in ((0, 0.0, False), (20, 2.0, True)):
        cycle = shoot(map_, [0.001, 0.0], transient=transient)
        assert cycle.success
        assert cycle.x[0] == pytest.approx([x, 0.0], abs=1e-10)
        assert cycle.stable is stable
    with pytest.raises(ValueError, match="transient must be a whole number of at least 0"):
        shoot(map_, [0.001, 0.0], transient=-1)


@NEEDS_HEYOKA
@pytest.mark.parametrize("depth", [1e-2, 1e-6, 1e-8, 1e-10])
def test_a_kink_that_is_hardly_reached_is_not_passed_over(depth: float) -> None:
    """x'' = -x - k max(0, x - g) from x = -1 at rest: it comes back there after its period."""
    k, g = 1000.0, 1.0 - depth
    w = math.sqrt(1.0 + k)
    half = math.acos(-g) + math.atan2(math.sqrt(1.0 - g * g) / w, g / (1.0 + k)) / w
    system = on_a_spring(-X - K * Max(0, X - G), k=k, g=g)
    motion = simulate(system, {"x": -1.0}, 2.0 * half)
    assert motion.z[:2] == pytest.approx([-1.0, 0.0], abs=1e-12)


@NEEDS_HEYOKA
def test_backlash_is_one_however_it_is_written() -> None:
    ways = [
        -K * (Max(0, X - G) + Min(0, X + G)),
        -Piecewise((K * (X + G), X < -G), (0, X <= G), (K * (X - G), True)),
        -Piecewise((K * (X - G), X > G), (K * (X + G), X < -G), (0, (X >= -G) & (X <= G))),
        -K * (X - (Abs(X + G) - Abs(X - G)) / 2),
        -K * (Abs(X) - G) * Heaviside(Abs(X) - G) * sign(X),
    ]
    ends = [simulate(on_a_spring(force), {"x": 1.0}, 20.0).z for force in ways]
    q, u, _ = np.array(ends).T
    energy = 0.5 * u**2 + 2.0 * np.maximum(0.0, np.abs(q) - 0.25) ** 2
    assert energy == pytest.approx(2.0 * 0.75**2, abs=1e-12)
    assert np.ptp(ends, axis=0).max() < 1e-11


@NEEDS_HEYOKA
def test_no_step_passes_over_a_steep_change() -> None:
    """Friction by tanh: where it is constant but for rounding no Taylor series foresees its turn.

    Steps that are short enough for a method of order 8 do not pass over it.
    """
    force = 3 * sympy.cos(2.8 * T) - X - 0.1 * tanh(50 * V)
    found = simulate(on_a_spring(force), {"x": 0.3}, 10.0).z
    there = solve_ivp(
        lambda t, y: [y[1], 3.0 * np.cos(2.8 * t) - y[0] - 0.1 * np.tanh(50.0 * y[1])],
        (0.0, 10.0), [0.3, 0.0], method="DOP853", rtol=1e-13, atol=1e-15, max_step=0.01,
    )  # fmt: skip
    assert found[:2] == pytest.approx(there.y[:, -1], abs=1e-10)


@EACH_BACKEND
@pytest.mark.parametrize(
    "size", [sympy.sqrt(V**2), (V**2) ** 0.5, sympy.sqrt(K * V**2) / 2, (V**4) ** 0.25]
)
def test_the_root_of_a_square_is_an_absolute_value(size: sympy.Expr, backend: str) -> None:
    """Also where it is zero: x'' = -|x'| x' from rest stays there, and a half period has v dv/dx.

    With v^2 = w, dw/dx = -2 x - 2 w for v > 0: w = 1/2 - x + C exp(-2 x) = 0 at both ends.
    """
    still = simulate(on_a_spring(-size * V), {"x": 1.0}, 2.0, backend=backend)
    assert still.z[:2].tolist() == [1.0, 0.0]
    motion = simulate(on_a_spring(-X - size * V), {"x": -1.0}, 4.0, backend=backend)
    k = int(np.flatnonzero(np.diff(np.sign(motion.u[:, 0])) < 0.0)[-1])
    for x, v in zip(motion.q[1:k, 0], motion.u[1:k, 0], strict=True):
        assert v * v == pytest.approx(0.5 - x - 1.5 * math.exp(-2.0 * (x + 1.0)), abs=1e-12)


ROOTS = {  # at their zero no Taylor series exists
    "a Hertzian contact": (
        -20 * Max(0, X) ** Rational(3, 2),
        lambda x, v: -20 * max(0.0, x) ** 1.5,
    ),
    "damping": (-(Abs(V) ** 1.5) * sign(V), lambda x, v: -(abs(v) ** 1.5) * np.sign(v)),
    "a square root": (-sign(V) * sqrt(Abs(V)) / 3, lambda x, v: -np.sign(v) * abs(v) ** 0.5 / 3),
    "a cube root": (-real_root(V, 3) / 3, lambda x, v: -np.cbrt(v) / 3),
}


@SLOW_SYSTEM
@pytest.mark.parametrize("name", ROOTS)
def test_roots_are_passed_at_their_zero(name: str) -> None:
    """From rest, which is such a zero, and through some more; derivatives where they are finite."""
    force, values = ROOTS[name]
    system = on_a_spring(sympy.cos(W * T) - X + force)

    def there(x: float, v: float, end: float) -> np.ndarray:
        def rate(t: float, y: np.ndarray) -> list[float]:
            return [y[1], math.cos(1.1 * t) - y[0] + values(*y)]

        found = solve_ivp(rate, (0.0, end), [x, v], "DOP853", rtol=1e-13, atol=1e-15, max_step=1e-3)
        return found.y[:, -1]

    motion = simulate(system, {"x": 0.5}, 8.0)
    # DOP853 passes a root with an error of its step to the power 1 + s, 1e-4 at most for s = 1/3
    assert motion.z[:2] == pytest.approx(there(0.5, 0.0, 8.0), abs=2e-6)
    once = Section(when=sympy.sin(W * T), free=[X, V], at={T: 0})
    image = SystemMap(system, once, ["w"]).at(np.array([0.5, 0.1]), np.array([1.1]))
    if name in ("a square root", "a cube root"):
        assert image.reason == MotionStatus.NO_SLOPE.value
    else:
        end, step = 2.0 * math.pi / 1.1, 1e-4
        ways = [
            there(0.5 + step, 0.1, end) - there(0.5 - step, 0.1, end),
            there(0.5, 0.1 + step, end) - there(0.5, 0.1 - step, end),
        ]
        slopes = np.transpose(ways) / (2.0 * step)
        assert image.jacobian[:, :2] == pytest.approx(slopes, abs=1e-5)


@EACH_BACKEND
def test_the_root_of_a_negative_number_is_no_force(backend: str) -> None:
    motion = simulate(on_a_spring(-sqrt(X)), {"x": -1.0}, 1.0, backend=backend)
    assert motion.status is MotionStatus.NO_FORCE


@EACH_BACKEND
@pytest.mark.parametrize(
    ("force", "end"),
    [
        # from rest at x = 1, x' = sqrt(2 exp(x) - 2 e), of which pi / sqrt(2 e) is the integral
        (sympy.exp(X), math.pi / math.sqrt(2.0 * math.e)),
        (sympy.exp(V), 1.0),  # exp(-v) = 1 - t
        # cosh(t) has no double beyond 710, and its series none at all some time before
        pytest.param(X, None, marks=pytest.mark.slow),
    ],
)
def test_motions_to_infinity_say_so_and_are_kept(
    force: sympy.Expr, end: float | None, backend: str
) -> None:
    wall = Contact(name="wall", gap=X + 10, eps_n=0.5)
    system = ContactSystem([X], [[1]], [force], [wall], {})
    motion = simulate(system, {"x": 1.0}, 800.0, backend=backend)
    assert motion.status is MotionStatus.OVERFLOW
    assert (np.diff(motion.t) >= 0.0).all()
    if end is None:
        assert 354.0 < motion.t[-1] < 711.0  # the larger half of it has no squares
        assert motion.q[-1, 0] == pytest.approx(math.cosh(motion.t[-1]), rel=1e-10)  # t times 1e-15
    else:
        assert motion.t[-1] == pytest.approx(end, abs=1e-10)  # steps are shorter than 1e-12


@EACH_BACKEND
@pytest.mark.parametrize("cube", [X**3, X**3.0, X * (X**2) ** 1.0])
def test_whole_powers_have_values_at_zero(cube: sympy.Expr, backend: str) -> None:
    """x'' = -x^3 from x = 0 keeps v^2/2 + x^4/4."""
    x, v, _ = simulate(on_a_spring(-cube), {"u_x": 1.0}, 5.0, backend=backend).z
    assert 0.5 * v**2 + 0.25 * x**4 == pytest.approx(0.5, abs=1e-12)


@EACH_BACKEND
@pytest.mark.parametrize(
    ("one", "other"),
    [
        (sympy.sec(X), 1 / sympy.cos(X)), (sympy.csc(X + 1), 1 / sympy.sin(X + 1)),
        (sympy.cot(X + 1), sympy.cos(X + 1) / sympy.sin(X + 1)),
        (sympy.sech(X), 1 / sympy.cosh(X)), (sympy.csch(X + 1), 1 / sympy.sinh(X + 1)),
        (sympy.coth(X + 1), sympy.cosh(X + 1) / sympy.sinh(X + 1)),
        (sympy.erfc(X), 1 - sympy.erf(X)), (sympy.re(X), X),
    ],
)  # fmt: skip
def test_a_function_is_the_same_however_it_is_written(
    one: sympy.Expr, other: sympy.Expr, backend: str
) -> None:
    ends = [
        simulate(on_a_spring(-X + each / 10), {"x": 0.3}, 1.0, backend=backend).z
        for each in (one, other)
    ]
    assert ends[0] == pytest.approx(ends[1], abs=1e-13)


REFUSED: list[tuple[Callable[[], object], str]] = [
    (lambda: on_a_spring(-X - sign(V)), r"h must be continuous, but -x - sign\(u_x\) jumps where "
     "u_x = 0: dry friction is mu and slip of a contact"),
    (lambda: on_a_spring(-X - Heaviside(X - G)), "jumps where g - x = 0"),
    (lambda: on_a_spring(sign(sympy.sin(W * T)) - X), r"jumps where sin\(t\*w\) = 0"),
    (lambda: on_a_spring(Mod(T, 1) - X), r"Mod\(t, 1\) jumps in steps"),
    (lambda: Contact(name="stop", gap=1 - Abs(X)), r"gap of 'stop' has Abs\(x\), but only forces"),
    (lambda: Contact(name="stop", gap=1 - sympy.sqrt(X**2)), r"gap of 'stop' has Abs\(x\), but"),
    (lambda: on_a_spring(-X - V / sympy.sqrt(V**2)), "jumps where u_x = 0"),
    (lambda: Section(when=Max(X, V), free=[X]), r"when has Max\(u_x, x\), but only forces may"),
    (
        lambda: ContactSystem([X], [[1 + Abs(X)]], [-X], [], {}),
        r"an entry of M has Abs\(x\), but only forces may have kinks: a gap with a kink is two",
    ),
]  # fmt: skip


@pytest.mark.parametrize(("call", "sentence"), REFUSED)
def test_jumps_and_kinks_elsewhere_are_refused(call: Callable[[], object], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        call()
