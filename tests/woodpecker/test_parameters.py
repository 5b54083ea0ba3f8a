"""The return map and the mode table over every parameter of the toy: derivatives, limits."""

import math

import numpy as np
import pytest
from scenes import change

from woodpecker import Toy, bifurcation_diagram, continuation, parameters, shoot
from woodpecker.mechanics.modes import CHANGE, FORCE, LEVER, MODES, OMEGA, Numbers, model
from woodpecker.mechanics.toy import ExpansionFriction, limits
from woodpecker.search.search import Search
from woodpecker.toy_map import ToyPieces

LAWS = list(ExpansionFriction)
NAMES = [name for name in parameters() if name != "pole"]  # the map does not know its length


def toy_of(name: str, law: ExpansionFriction) -> Toy:
    """The paper's toy; a sleeve's restitution is varied where it bounces."""
    bounce = {name: 0.2} if name in ("eps_n2", "eps_n3") else {}
    return Toy(expansion_friction=law, **bounce)


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("name", NAMES)
def test_derivatives_agree_with_differences(name: str, law: ExpansionFriction) -> None:
    """Differences of order four with two steps: where they agree to 1e-8, so does the derivative.

    They cannot be better than rounding, 1e-15 over a step of 1e-4: 1e-11 in units of p.
    """
    toy, rng, compared = toy_of(name, law), np.random.default_rng(7), 0
    f, p = ToyPieces(toy, name).at, float(getattr(toy, name))
    for x in rng.uniform(-2.4, -0.3, 80).tolist():
        here, differences = f(x, p), []
        for step in (2e-4 * p, 1e-4 * p):
            around = [f(x, p + k * step) for k in (-2, -1, 1, 2)]
            if any(each.piece.key != here.piece.key for each in around):
                break
            a, b, c, d = (each.value for each in around)
            differences.append((a - 8.0 * b + 8.0 * c - d) / (12.0 * step))
        if len(differences) < 2:
            continue
        size = abs(differences[1]) + 1e-2 / p
        if abs(differences[1] - differences[0]) <= 1e-8 * size:
            assert abs(here.d_parameter - differences[1]) <= 1e-7 * size, (x, here)
            compared += 1
    assert compared >= 30


@pytest.mark.parametrize("name", Numbers._fields)
def test_derivative_of_the_table(name: str) -> None:
    """Every entry that moves, against differences of two tables."""
    value = getattr(Toy(), name)
    step = 1e-5 * value
    above, below = (model(Toy(**{name: value + k * step})) for k in (1.0, -1.0))
    rows, columns = CHANGE
    with np.errstate(invalid="ignore"):
        difference = ((above - below) / (2.0 * step))[:rows, :columns]
    found, size = change(Toy(), name), np.abs(model(Toy())[:rows, :columns])
    moving = np.isfinite(difference)
    moving[:, OMEGA] &= np.arange(rows) >= MODES  # sqrt |kappa| is not carried: nothing needs it
    moving[FORCE, LEVER + 3 :] = False
    largest = np.nanmax(size[:MODES], axis=0)  # a row's rounding is that of its system
    size[:MODES] = np.maximum(size[:MODES], largest)
    bound = 1e-6 * np.abs(difference) + 1e-9 * size / value
    assert (np.abs(found - difference)[moving] <= bound[moving]).all()


@pytest.mark.parametrize("name", [*NAMES, "pole"])
def test_many_points_at_once_are_the_map(name: str) -> None:
    toy = toy_of(name, ExpansionFriction.SUMMED)
    p, map_ = 1.0 if name == "pole" else float(getattr(toy, name)), ToyPieces(toy, name)
    x = np.array([-2.1, -0.9, -0.53])
    found, images = map_.sweep(x, p), [map_.at(value, p) for value in x.tolist()]
    # searched and followed: see test_toy_map
    assert found.value == pytest.approx([image.value for image in images], abs=1e-13)
    assert found.slope == pytest.approx([image.slope for image in images], rel=1e-9)


def test_the_map_does_not_depend_on_the_length_of_the_pole() -> None:
    for x in (-2.1, -0.9, -0.53):
        assert ToyPieces(Toy(), "pole").at(x, 1.0).d_parameter == 0.0


@pytest.mark.parametrize("name", parameters())
def test_limits_are_those_of_the_toy(name: str) -> None:
    low, high = limits(Toy(), name)
    inside = [low + 1e-6 * (min(high, 1e3) - low), low + 0.999 * (min(high, 1e3) - low)]
    for value in inside:
        assert getattr(Toy(**{name: value}), name) == value
    with pytest.raises(ValueError, match=" must "):
        Toy(**{name: low - 1e-9})
    if math.isfinite(high):
        with pytest.raises(ValueError, match=" must "):
            Toy(**{name: high + 1e-9})


@pytest.mark.slow
def test_diagrams_say_how_derivatives_were_found() -> None:
    found = continuation(Toy(), shoot(Toy(), -0.53), "c_phi", (0.0055, 0.0057))
    assert found.given == (
        "friction in the expansion: summed", "derivatives in c_phi: the variational flow",
    )  # fmt: skip
    few = Search(slices=2)
    every = bifurcation_diagram(Toy(), "mu_2", (0.3, 0.31), (1,), (-0.6, -0.5), search=few)
    assert every.given[1] == "derivatives in mu_2: the variational flow"
