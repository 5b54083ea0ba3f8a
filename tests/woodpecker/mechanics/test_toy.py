"""The paper's data set, and one sentence for every wrong value."""

import copy
import dataclasses
import math
import pickle
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

from woodpecker import ExpansionFriction, Toy, parameters

# As printed below Eq. 11; c_phi, which the paper omits, and the endless pole come last.
PAPER = {
    "m_m": 0.0003, "j_m": 5.0e-9, "m_s": 0.0045, "j_s": 7.0e-7, "g": 9.81,
    "r_0": 0.0025, "r_m": 0.0031, "h_m": 0.0058, "l_m": 0.010, "l_g": 0.015,
    "h_s": 0.020, "l_s": 0.0201, "mu_1": 0.3, "mu_2": 0.3, "mu_3": 0.3,
    "eps_n1": 0.5, "eps_n2": 0.0, "eps_n3": 0.0, "c_phi": 0.0056, "pole": math.inf,
}  # fmt: skip
LAW = {"expansion_friction": "summed"}  # inferred from the paper's figures
FRICTIONS = ("mu_1", "mu_2", "mu_3")
RESTITUTIONS = ("eps_n1", "eps_n2", "eps_n3")
POSITIVE = sorted(set(PAPER) - {*FRICTIONS, *RESTITUTIONS})


def test_defaults_are_the_papers_data() -> None:
    assert dataclasses.asdict(Toy()) == PAPER | LAW
    assert sorted(parameters()) == sorted(PAPER)


def test_angle_limits() -> None:
    """As printed: |phi_M| <= 0.1034 and phi_S <= 0.12."""
    toy = Toy()
    assert toy.phi_m_max == pytest.approx(0.0006 / 0.0058, rel=1e-15)  # 6/58, one rounding more
    assert toy.phi_m_max == pytest.approx(0.103448, abs=5e-7)  # printed digits
    assert toy.phi_s_max == pytest.approx(0.12, rel=1e-14)  # a difference of ten-fold numbers


def assert_refused(name: str, value: object, error: type[Exception], sentence: str) -> None:
    """Constructor and replace refuse with the same one sentence."""
    for make in (Toy, Toy().replace):
        with pytest.raises(error) as caught:
            make(**{name: value})  # type: ignore[arg-type]
        assert str(caught.value) == sentence


@pytest.mark.parametrize("value", [-1.0, 0.0, math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("name", POSITIVE)
def test_masses_lengths_and_stiffness_are_positive(name: str, value: float) -> None:
    if name == "pole" and value == math.inf:
        assert Toy(pole=value).pole == math.inf
    else:
        expected = "positive" if name == "pole" else "positive and finite"
        sentence = f"{name} must be {expected}, got {value}"
        assert_refused(name, value, ValueError, sentence)


@pytest.mark.parametrize("value", [-0.1, math.nan, math.inf])
@pytest.mark.parametrize("name", FRICTIONS)
def test_friction_is_not_negative(name: str, value: float) -> None:
    assert_refused(name, value, ValueError, f"{name} must be at least 0 and finite, got {value}")
    assert getattr(Toy(**{name: 0.0}), name) == 0.0


@pytest.mark.parametrize("value", [-0.1, 1.1, math.nan, math.inf])
@pytest.mark.parametrize("name", RESTITUTIONS)
def test_restitution_lies_between_0_and_1(name: str, value: float) -> None:
    assert_refused(name, value, ValueError, f"{name} must lie in [0, 1], got {value}")
    assert [getattr(Toy(**{name: end}), name) for end in (0.0, 1.0)] == [0.0, 1.0]


@pytest.mark.parametrize("value", [0.0025, 0.0024])
def test_the_sleeve_is_wider_than_the_pole(value: float) -> None:
    sentence = f"r_m must exceed r_0 = 0.0025, or the sleeve does not fit on the pole, got {value}"
    assert_refused("r_m", value, ValueError, sentence)


def test_the_beak_is_outside_the_pole() -> None:
    sentence = (
        "l_m + l_g must exceed l_s + r_0, or the beak is inside the pole, "
        f"got {0.010 + 0.015} and {0.023 + 0.0025}"
    )
    assert_refused("l_s", 0.023, ValueError, sentence)


@pytest.mark.parametrize(
    "value",
    [True, False, "0.3", None, 0.3 + 0.1j, [0.3], (0.3,), np.array([0.3, 0.4]), np.bool_(True)],
    ids=repr,
)
@pytest.mark.parametrize("name", ["m_m", "mu_1", "eps_n1", "pole"])
def test_values_are_real_numbers(name: str, value: object) -> None:
    """An array or a truth value of numpy is none, though numpy can make floats of some."""
    assert_refused(name, value, TypeError, f"{name} must be a real number, got {value!r}")


def test_numbers_of_any_kind_become_floats() -> None:
    toy = Toy(mu_1=1, mu_2=Fraction(1, 4), mu_3=np.float32(0.5), eps_n1=Decimal("0.25"))  # type: ignore[arg-type]
    assert (toy.mu_1, toy.mu_2, toy.mu_3, toy.eps_n1) == (1.0, 0.25, 0.5, 0.25)
    assert all(type(getattr(toy, name)) is float for name in parameters())


@pytest.mark.parametrize("law", ["summed", "separate"])
def test_the_law_of_expansion_is_a_word_or_its_enum(law: str) -> None:
    """Either gives the enum, which equals its word and reads like it."""
    toys = Toy(expansion_friction=law), Toy(expansion_friction=ExpansionFriction(law))  # type: ignore[arg-type]
    for toy in (*toys, Toy().replace(expansion_friction=law)):
        assert type(toy.expansion_friction) is ExpansionFriction
        assert toy.expansion_friction == law
        assert f"{toy.expansion_friction}" == law
    assert toys[0] == toys[1]
    assert hash(toys[0]) == hash(toys[1])
    assert Toy(expansion_friction="summed") != Toy(expansion_friction="separate")


@pytest.mark.parametrize("value", ["sum", "Summed", "SUMMED", "", None, 0, 1.0, True, ["summed"]])
def test_another_law_of_expansion_is_refused(value: object) -> None:
    sentence = f"expansion_friction must be 'summed' or 'separate', got {value!r}"
    assert_refused("expansion_friction", value, ValueError, sentence)


def test_the_law_of_expansion_is_kept_by_copies() -> None:
    """It is no number, so no parameter to continue in; replace, pickle and copy keep it."""
    toy = Toy(expansion_friction="separate", mu_1=0.4)
    assert "expansion_friction" not in parameters()
    for same in (toy.replace(mu_1=0.3).replace(mu_1=0.4), pickle.loads(pickle.dumps(toy)),
                 copy.copy(toy), copy.deepcopy(toy)):  # fmt: skip
        assert same == toy
        assert same.expansion_friction is ExpansionFriction.SEPARATE
    assert toy.replace(expansion_friction="summed") == Toy(mu_1=0.4)


def test_a_toy_is_frozen() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        Toy().eps_n1 = 0.3  # type: ignore[misc]
    assert Toy() == Toy()
    assert hash(Toy(eps_n1=0.3)) == hash(Toy().replace(eps_n1=0.3))


def test_replace_changes_a_copy() -> None:
    toy = Toy()
    other = toy.replace(eps_n1=0.3, mu_2=0.4)
    assert dataclasses.asdict(other) == PAPER | LAW | {"eps_n1": 0.3, "mu_2": 0.4}
    assert toy == Toy()


def test_replace_names_the_unknown_parameter() -> None:
    with pytest.raises(TypeError) as caught:
        Toy().replace(mu_2=0.4, epsilon=0.3)
    assert str(caught.value) == (
        f"unknown parameter 'epsilon', expected one of {', '.join(parameters())}"
    )


def test_arguments_are_named() -> None:
    with pytest.raises(TypeError):
        Toy(0.0003)  # type: ignore[misc]
