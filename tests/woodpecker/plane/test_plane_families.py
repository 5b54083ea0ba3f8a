"""Families of maps: views along two parameters, of formulas and of the toy."""

import pickle
import re
from typing import Any

import numpy as np
import pytest
import sympy

from pwmap import PiecewiseLinearMap
from woodpecker import Toy, ToyPieces
from woodpecker.plane import (
    ToyFamily,
    family_from_pwmap,
    family_from_sympy,
    graph_of_curves,
)

X, P, Q = sympy.symbols("x p q")
MAP = sympy.Piecewise((sympy.sin(P * X) + Q, X < P * Q), (Q * X - P**2, True))


def test_pieces_are_carried_from_one_view_to_the_other() -> None:
    family = family_from_sympy(MAP, X, (P, Q))
    one, other = (family.over(axis, (0.5, 1.0)) for axis in (0, 1))
    piece = one.at(0.2, 0.5).piece
    carried = family.carried(piece, other)
    assert carried.at(0.2, 1.0).value == piece.at(0.2, 0.5).value
    assert pickle.loads(pickle.dumps(piece)).at(0.2, 0.5).value == piece.at(0.2, 0.5).value


def test_wrong_arguments() -> None:
    exact = PiecewiseLinearMap.from_sympy(sympy.Piecewise((P * X, X < 0), (Q * X, True)), X)
    with pytest.raises(ValueError, match="expected two parameters, got 'pq'"):
        family_from_sympy(MAP, X, "pq")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="must differ, got p twice"):
        family_from_sympy(MAP, X, (P, P))
    with pytest.raises(ValueError, match="the parameters of the map must be p and r, got p, q"):
        family_from_pwmap(exact, ("p", "r"))
    with pytest.raises(ValueError, match="expected two different parameters of the toy"):
        ToyFamily(Toy(), ("mu_2", "mu_2"))
    with pytest.raises(TypeError, match="curves must be a list of them, got 3"):
        graph_of_curves(3)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="curve must be"):
        graph_of_curves(["BC1"])  # type: ignore[list-item]
    with pytest.raises(TypeError, match="unknown parameter 'mu'"):
        ToyFamily(Toy(), ("mu_2", "mu"))
    with pytest.raises(TypeError, match=r"mu_2 varies: it cannot be held at 0\.4"):
        ToyPieces(Toy(), "mu_2").holding(mu_2=0.4)


@pytest.mark.parametrize(
    ("axis", "values", "sentence"),
    [
        ("q", (0.5, 1.0), "axis must be 0 or 1, got 'q'"),
        (2, (0.5, 1.0), "axis must be 0 or 1, got 2"),
        (True, (0.5, 1.0), "axis must be 0 or 1, got True"),
        (0, 0.5, "values must be two numbers, of eps_n1 and of mu_2, got 0.5"),
        (
            0,
            (0.5, 1.0, 2.0),
            "values must be two numbers, of eps_n1 and of mu_2, got (0.5, 1.0, 2.",
        ),
        (0, (0.5, "0.3"), "mu_2 must be one real number, got '0.3'"),
        (1, (None, 0.3), "eps_n1 must be one real number, got None"),
    ],
)
def test_a_view_is_along_one_of_two_parameters(axis: Any, values: Any, sentence: str) -> None:
    """The value of the one that varies does not matter, whatever it is."""
    symbols = sympy.symbols("eps_n1 mu_2")
    formulas = family_from_sympy(X * symbols[0] + symbols[1], X, symbols)
    for family in (formulas, ToyFamily(Toy(), formulas.names)):
        with pytest.raises(ValueError, match=f"^{re.escape(sentence)}"):
            family.over(axis, values)
    assert formulas.over(0, ("any", 0.25)).at(1.0, 0.5).value == 0.75  # type: ignore[arg-type]


@pytest.mark.parametrize("names", [("eps_n1", "mu_2"), ("l_s", "c_phi"), ("eps_n2", "eps_n1")])
def test_views_of_the_toy(names: tuple[str, str]) -> None:
    """To the last bit those of a toy that has the other value from the start."""
    toy = Toy(eps_n2=0.1)
    family = ToyFamily(toy, names)
    first, second = (getattr(toy, name) for name in names)
    for part in (1.0, 1.01, 1.02):
        values = (first + 0.01 * (part - 1.0), second * part)
        held = toy.replace(**dict(zip(names, values, strict=True)))
        for axis, name in enumerate(names):
            own = family.over(axis, values).at(-0.53, values[axis])
            alone = ToyPieces(held, name).at(-0.53, values[axis])
            assert own.piece.key == alone.piece.key
            assert (own.value, own.slope) == (alone.value, alone.slope)
            np.testing.assert_array_equal(own.d_parameter, alone.d_parameter)
            np.testing.assert_array_equal(own.gradients, alone.gradients)


@pytest.mark.parametrize("name", ["eps_n2", "eps_n3"])
def test_a_restitution_of_zero_bounces_over_two_parameters(name: str) -> None:
    """The map is that at zero, its piece and derivatives are those of positive restitutions."""
    toy, family = Toy(), ToyFamily(Toy(), ("eps_n1", name))
    at_zero = family.over(0, (0.65, 0.0)).at(-0.52, 0.65)
    alone = ToyPieces(toy, "eps_n1").at(-0.52, 0.65)
    # rounding of values and slopes
    assert at_zero.value == pytest.approx(alone.value, abs=1e-14)
    assert at_zero.slope == pytest.approx(alone.slope, abs=1e-11)
    above = family.over(0, (0.65, 1e-8)).at(-0.52, 0.65)
    assert at_zero.piece.key == above.piece.key != alone.piece.key
    along = family.over(1, (0.65, 0.0))
    rate = along.at(-0.52, 0.0).d_parameter
    near, far = (along.at(-0.52, k * 1e-5).value for k in (1, 2))
    # second order: the third derivative is below 1e3, rounding 1e-15 over the step
    assert rate == pytest.approx((4.0 * near - far - 3.0 * alone.value) / 2e-5, abs=1e-7)


def test_a_toy_that_cannot_be_has_no_images() -> None:
    family = ToyFamily(Toy(), ("eps_n1", "mu_2"))
    assert "mu_2 must be at least 0" in family.over(0, (0.5, -0.1)).at(-0.53, 0.5).reason
    assert not family.over(0, (0.5, 0.3)).at(-0.53, 0.5).reason


def test_maps_that_hold_values_pickle() -> None:
    map_ = ToyPieces(Toy(), "eps_n1").holding(mu_2=0.35)
    again = pickle.loads(pickle.dumps(map_))
    assert again == map_
    assert again.at(-0.53, 0.5).value == map_.at(-0.53, 0.5).value
    assert map_ != ToyPieces(Toy(), "eps_n1")
