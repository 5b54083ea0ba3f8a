"""First variations of returns against central differences of order four, the word prescribed."""

import numpy as np
import pytest
import sympy
from differences import differences
from needs import NEEDS_HEYOKA

from studies.systems.oscillator import impacts, strobed
from studies.systems.toy import map_of
from woodpecker import Toy, ToyPieces
from woodpecker.base.arrays import Floats
from woodpecker.engine.maps import SpaceImage
from woodpecker.systems import Contact, ContactSystem, Section, SystemMap

CLOSE = 1e-9
BACKENDS = [pytest.param("heyoka", marks=NEEDS_HEYOKA), "scipy"]


def margins_by_differences(image: SpaceImage, x: Floats, p: Floats, h: float) -> Floats:
    """(m, d + k) of the margins that the piece has here; nan of those that it has not beside it."""
    found, at = [], np.concatenate([x, p])
    for step in h * np.eye(len(at)):
        there = [image.piece.at(*np.split(at + k * step, [len(x)])) for k in (-1, 1)]
        known = [dict(zip(each.codes.tolist(), each.margins, strict=True)) for each in there]
        both = [[each.get(c, np.nan) for c in image.codes.tolist()] for each in known]
        found.append(np.subtract(both[1], both[0]) / (2 * h))
    return np.array(found).T


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("parameters", [("F", "w"), ("eps", "sigma"), ("zeta",)])
@pytest.mark.slow
def test_impact_oscillator(backend: str, parameters: tuple[str, ...]) -> None:
    map_ = impacts(*parameters, backend=backend)
    x, p = np.array([-0.7, 0.6]), map_.p
    image = map_.at(x, p)
    away = image.jacobian - differences(image, x, p, 1e-3)
    assert np.abs(away).max() < CLOSE * max(1.0, np.abs(image.jacobian).max())


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.slow
def test_stroboscopic_section(backend: str) -> None:
    """Impacts within a period, which a parameter makes longer."""
    map_ = strobed("w", "F", backend=backend).holding(F=6.0)
    x, p = np.array([-0.4, 1.5]), np.array([2.8, 6.0])
    image = map_.at(x, p)
    assert "I1" in image.piece.word
    away = image.jacobian - differences(image, x, p, 1e-3)
    assert np.abs(away).max() < CLOSE * max(1.0, np.abs(image.jacobian).max())


@NEEDS_HEYOKA
@pytest.mark.slow
def test_the_toy_has_the_derivatives_of_the_kernel() -> None:
    """In phi_S and several parameters; of the kernel they are closed forms."""
    names = "eps_n1", "mu_2", "l_s", "c_phi"
    map_ = map_of(Toy(eps_n1=0.5), *names)
    image = map_.at(np.array([-0.53]), map_.p)
    for k, name in enumerate(names):
        exact = ToyPieces(Toy(eps_n1=0.5), name).at(-0.53, map_.p[k])
        assert image.value[0] == pytest.approx(exact.value, abs=1e-12)
        assert image.jacobian[0, 0] == pytest.approx(exact.slope, abs=1e-9)
        assert image.jacobian[0, 1 + k] == pytest.approx(exact.d_parameter, rel=1e-8)


@NEEDS_HEYOKA
@pytest.mark.slow
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
    assert there.jacobian == pytest.approx(differences(there, beyond, p, 1e-5), rel=1e-7)


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


@pytest.mark.parametrize("law", ["poisson", "newton"])
@pytest.mark.slow
def test_accumulated_bounces_and_friction(law: str) -> None:
    """What is left of bounces that accumulate is summed with derivatives."""
    map_ = bouncing(law)
    x, p = np.array([0.5, 0.8, 1.0, 0.3]), map_.p
    image = map_.at(x, p)
    assert "C1" in image.piece.word
    exact = differences(image, x, p, 1e-4)
    assert image.jacobian == pytest.approx(exact, abs=1e-8)  # values are known to some 1e-13
    assert image.jacobian[2:] == pytest.approx(np.zeros((2, 7)), abs=1e-8)  # it rests


@NEEDS_HEYOKA
@pytest.mark.slow
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


@pytest.mark.slow
def test_backends_agree() -> None:
    pytest.importorskip("heyoka")
    one, other = (strobed("F", backend=name).holding(F=6.0) for name in ("heyoka", "scipy"))
    rng = np.random.default_rng(2)
    for x in rng.normal(size=(20, 2)) * 0.3 - [0.4, 0.0]:
        images = [each.at(x, each.p) for each in (one, other)]
        assert images[0].piece.word == images[1].piece.word
        assert images[0].value == pytest.approx(images[1].value, abs=1e-9)
        scale = np.abs(images[0].jacobian).max()
        assert images[0].jacobian == pytest.approx(images[1].jacobian, abs=1e-8 * scale)
