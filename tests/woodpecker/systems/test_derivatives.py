"""First variations of returns, against differences and the kernel, the word prescribed."""

from collections.abc import Callable

import numpy as np
import pytest
import sympy
from needs import NIGHTLY_SYSTEM, SLOW_SYSTEM
from test_friction_of_systems import body
from test_impacts_in_turns import F, T, V, X, pushed_block

from studies.systems import den_hartog, oscillator, rimless_wheel, rocking_block
from studies.systems.toy import map_of
from woodpecker import Toy, ToyPieces
from woodpecker.base.arrays import Floats
from woodpecker.engine.maps import SpaceImage
from woodpecker.systems import Contact, ContactSystem, Section, SystemMap

# --- Of single systems ----------------------------------------------------------------------------


def margins_by_differences(image: SpaceImage, x: Floats, p: Floats, h: float) -> Floats:
    """(m, d + k) of the margins that the piece has here; nan of those that it has not beside it."""
    found, at = [], np.concatenate([x, p])
    for step in h * np.eye(len(at)):
        there = [image.piece.at(*np.split(at + k * step, [len(x)])) for k in (-1, 1)]
        known = [dict(zip(each.codes.tolist(), each.margins, strict=True)) for each in there]
        both = [[each.get(c, np.nan) for c in image.codes.tolist()] for each in known]
        found.append(np.subtract(both[1], both[0]) / (2 * h))
    return np.array(found).T


@SLOW_SYSTEM
def test_the_toy_has_the_derivatives_of_the_kernel() -> None:
    """In phi_S and all parameters; of the kernel they are closed forms."""
    machine = Toy(eps_n1=0.5, eps_n2=0.1, eps_n3=0.2)
    names = [str(symbol) for symbol in map_of(machine).system.parameters]
    map_ = map_of(machine, *names)
    image = map_.at(np.array([-0.53]), map_.p)
    assert image.piece.word == "S2 D2 I3 I1 I3 C2 J2"
    for k, name in enumerate(names):
        exact = ToyPieces(machine, name).at(-0.53, map_.p[k])
        assert image.value[0] == pytest.approx(exact.value, abs=1e-12)
        assert image.jacobian[0, 0] == pytest.approx(exact.slope, abs=1e-9)
        assert image.jacobian[0, 1 + k] == pytest.approx(exact.d_parameter, rel=1e-8)


@NIGHTLY_SYSTEM
def test_beyond_a_border_the_word_is_prescribed() -> None:
    """Right of the jump at -0.7577872574 the kernel and the general method go on the same way."""
    map_, exact = map_of(Toy(eps_n1=0.5), "eps_n1"), ToyPieces(Toy(eps_n1=0.5))
    p = np.array([0.5])
    inside, own = map_.at(np.array([-0.7577]), p), exact.at(-0.7577, 0.5)
    beyond = np.array([-0.7579])
    assert map_.at(beyond, p).piece.key != inside.piece.key
    there, known = inside.piece.at(beyond, p), own.piece.at(-0.7579, 0.5)
    assert there.margins.min() < 0.0
    assert there.value[0] == pytest.approx(known.value, abs=1e-10)
    assert there.jacobian[0, 0] == pytest.approx(known.slope, rel=1e-8)


@SLOW_SYSTEM
def test_gradients_of_margins() -> None:
    """All of them: slacks of impacts, guards at starts, at events, at dips, and their rates."""
    map_ = map_of(Toy(eps_n1=0.5), "eps_n1", "mu_2")
    x, p = np.array([-0.53]), map_.p
    image = map_.at(x, p)
    exact = margins_by_differences(image, x, p, 1e-6)
    size = np.abs(image.gradients).max(axis=1, keepdims=True) + np.abs(image.margins)[:, None]
    known = np.isfinite(exact).all(axis=1)
    # a minimum may leave a phase at its end, where the guard's value at the event takes over
    assert all(
        "grazes in phase" in image.piece.cause(code) for code in image.codes[~known].tolist()
    )
    assert known.mean() > 0.95
    assert np.abs((image.gradients - exact) / size)[known].max() < 1e-6  # differences of order two


# --- In state and all parameters ------------------------------------------------------------------

# Against central differences of order four in units of the sizes of coordinates and parameters.
# With values known to some 1e-14 and steps of 1e-3 these are known to 1e-11, but for the fifth
# derivative times h**4/30; where that is large a shorter step is given, down to 1e-5, with which
# they are known to 1e-9.

CLOSE = 1e-9  # of the largest derivative, at least of 1
ABSENT = 0.1  # the size of a parameter that is zero, such as a restitution

Variables = tuple[list[float], dict[str, float]]  # of a start: coordinates, and parameters


def with_all(map_of: Callable[..., SystemMap], backend: str = "heyoka") -> SystemMap:
    """The map of an instance with all of its parameters free."""
    return map_of(*map(str, map_of().system.parameters), backend=backend)


CENTRAL, ONE_SIDED = (1, -8, 8, -1), (-25, 48, -36, 16, -3)


def off(image: SpaceImage, x: Floats, p: Floats, h: float) -> float:
    """How far the Jacobian of an image is from differences of order four along its piece.

    They are one-sided from zero, as a restitution cannot be less.
    """
    at = np.concatenate([x, p])
    sizes = np.where(at == 0.0, ABSENT, np.abs(at))
    found = []
    for start, step in zip(at, h * np.diag(sizes), strict=True):
        places, weights = (range(5), ONE_SIDED) if start == 0.0 else ((-2, -1, 1, 2), CENTRAL)
        values = [image.piece.at(*np.split(at + k * step, [len(x)])).value for k in places]
        found.append(np.array(weights) @ values / (12 * h))
    known = image.jacobian * sizes
    assert np.isfinite(known).all()
    return float(np.abs(known - np.transpose(found)).max() / max(1.0, np.abs(known).max()))


# What is left of bounces that accumulate is summed with derivatives; those of places at rest are
# zero. What was before a stop, or while all feet stick, is forgotten.


def bouncing(law: str) -> SystemMap:
    """A block of which one corner bounces until it rests, between two passages of a phase."""
    x, y, ux, uy, t = sympy.symbols("x y u_x u_y t")
    eps, mu, a = sympy.symbols("eps mu a")
    floor = Contact(name="floor", gap=y, slip=ux, mu=mu, eps_n=eps)
    system = ContactSystem(
        [x, y], [[1, 0], [0, 2]], [a * sympy.cos(t) - x - ux / 5, -20 - uy / 3], [floor],
        {eps: 0.4, mu: 0.1, a: 1.5}, law=law,
    )  # fmt: skip
    section = Section(when=sympy.sin(t), free=[x, ux, y, uy], at={t: 0})
    return SystemMap(system, section, ["eps", "mu", "a"])


def sliding_beam() -> SystemMap:
    """The beam with friction at its left end, which a spring and a force move along x."""
    x, y, phi, v, w, t = sympy.symbols("x y phi u_x u_phi t")
    eps, mu, a = sympy.symbols("eps mu a")
    ends = [
        Contact(name="the left end", gap=y - phi, slip=v, mu=mu, eps_n=eps),
        Contact(name="the right end", gap=y + phi, eps_n=eps),
    ]
    force = [a * sympy.cos(t) - x - v / 5, -20, -w / 3]
    values = {eps: 0.2, mu: 0.1, a: 3.0}
    system = ContactSystem([x, y, phi], sympy.diag(1, 1, sympy.Rational(1, 5)), force, ends, values)
    section = Section(when=sympy.sin(t), free=[x, v, y, phi], at={t: 0})
    return SystemMap(system, section, ["eps", "mu", "a"])


def pressed_and_pulled(backend: str) -> SystemMap:
    """A block that is pressed against a stop, and pulled away."""
    force = sympy.Rational(1, 10) + F * sympy.cos(T / 5) - X / 10
    section = Section(when=sympy.sin(T / 5 - 2.5), free=[X, V], at={T: 12.5})
    system = pushed_block(force, F=0.9, mu=0.15)
    return SystemMap(system, section, ["F", "mu", "e"], backend=backend)


def on_two_feet() -> SystemMap:
    """A body that a force moves back and forth."""
    push, mu, t = sympy.symbols("push mu t")
    system = body(push * sympy.sin(3 * t), 0.5, mu, {push: 5.0, mu: 0.3})
    section = Section(when=sympy.sin(3 * t), free=["u_x"], at={t: 0})
    return SystemMap(system, section, ["push", "mu"])


FALLS = [0.5, 0.8, 1.0, 0.3]
IMPACTS, STROBED = ([-0.7, 0.6], {}, "I1", 1e-3), ([-0.4, 1.5], {"F": 6.0}, "I1", 1e-3)


@NIGHTLY_SYSTEM
@pytest.mark.parametrize(
    ("map_", "x", "values", "word", "h"),
    [
        (lambda: with_all(oscillator.impacts), *IMPACTS),
        (lambda: with_all(oscillator.impacts, "scipy"), *IMPACTS),
        (lambda: with_all(oscillator.strobed), *STROBED),
        (lambda: with_all(oscillator.strobed, "scipy"), *STROBED),
        (lambda: with_all(rocking_block.map_of), [-1.3, 0.3], {}, "I1+2f D2 I1f+2", 1e-4),
        (lambda: with_all(rimless_wheel.map_of), [0.5], {}, "I1f+2s", 1e-3),
        (lambda: with_all(den_hartog.map_of), [0.7, 0.9], {"f": 0.8}, "J1 S1 J1 S1", 1e-3),
        (lambda: bouncing("poisson"), FALLS, {}, "I1-s C1 J1 S1 J1", 1e-3),
        (lambda: bouncing("newton"), FALLS, {}, "C1 J1 S1 J1", 1e-3),
        (sliding_beam, [0.5, 0.8, 1.41, 0.18], {}, "C1+2 R1 R1", 1e-3),
        (lambda: pressed_and_pulled("heyoka"), [0.3, -0.9], {}, "C2 J1 S1 D2", 1e-3),
        (lambda: pressed_and_pulled("scipy"), [0.3, -0.9], {}, "C2 J1 S1 D2", 1e-3),
        (on_two_feet, [0.4], {}, "J1 J2 S1 S2", 1e-3),
    ],
    ids=[
        "impacts", "scipy", "strobed", "strobed scipy", "block", "wheel", "friction",
        "bouncing", "bouncing newton", "beam", "pressed", "pressed scipy", "feet",
    ],
)  # fmt: skip
def test_in_state_and_all_parameters(
    map_: Callable[[], SystemMap], x: list[float], values: dict[str, float], word: str, h: float
) -> None:
    one = map_().holding(**values)
    image = one.at(np.array(x), one.p)
    assert image.piece.word == word
    assert off(image, np.array(x), one.p, h) < CLOSE


@NIGHTLY_SYSTEM
@pytest.mark.parametrize(
    ("map_", "inside", "beyond", "h"),
    [
        (lambda: with_all(oscillator.impacts), ([-0.7, 0.6], {}), ([-0.3, 2.0], {}), 5e-4),
        (lambda: with_all(rimless_wheel.map_of),
         ([0.8], {"gamma": 0.1}), ([0.8], {"gamma": 0.1, "mu": 0.2}), 1e-3),
        (lambda: with_all(den_hartog.map_of),
         ([1.3, 0.5], {"f": 0.5}), ([1.3, 0.5], {"f": 0.55}), 2e-4),
    ],
    ids=["impacts", "wheel", "friction"],
)  # fmt: skip
def test_beyond_a_border(
    map_: Callable[[], SystemMap], inside: Variables, beyond: Variables, h: float
) -> None:
    """A return along the word of another start, which the system does not take here."""
    one = map_()
    there, here = (one.holding(**values) for _, values in (inside, beyond))
    piece = there.at(np.array(inside[0]), there.p).piece
    x = np.array(beyond[0])
    own = here.at(x, here.p)
    assert own.piece.key != piece.key
    image = piece.at(x, here.p)
    assert image.margins.min() < 0.0
    assert off(image, x, here.p, h) < CLOSE
