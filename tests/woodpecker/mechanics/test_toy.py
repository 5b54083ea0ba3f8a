"""The paper's data set, and one sentence for every wrong value."""

import copy
import dataclasses
import math
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
from pickles import pickled

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
POSITIVE = sorted(set(PAPER) - {*FRICTIONS, *RESTITUTIONS, "pole"})


def test_defaults_are_the_papers_data() -> None:
    assert dataclasses.asdict(Toy()) == PAPER | LAW
    assert sorted(parameters()) == sorted(PAPER)


def test_angle_limits() -> None:
    """As printed: |phi_M| <= 0.1034 and phi_S <= 0.12."""
    toy = Toy()
    assert toy.phi_m_max == pytest.approx(0.0006 / 0.0058, rel=1e-15)  # 6/58, one rounding more
    assert toy.phi_m_max == pytest.approx(0.103448, abs=5e-7)  # printed digits
    assert toy.phi_s_max == pytest.approx(0.12, rel=1e-14)  # a difference of ten-fold numbers


NOT_REAL = [True, "0.3", None, 0.3 + 0.1j, [0.3], (0.3,), np.array([0.3, 0.4]), np.bool_(True)]
REFUSED = [
    *((name, value, f"{name} must be positive and finite, got {value}")
      for name in POSITIVE for value in (-1.0, 0.0, math.nan, math.inf, -math.inf)),
    *(("pole", value, f"pole must be positive, got {value}")
      for value in (-1.0, 0.0, math.nan, -math.inf)),
    *((name, value, f"{name} must be at least 0 and finite, got {value}")
      for name in FRICTIONS for value in (-0.1, math.nan, math.inf)),
    *((name, value, f"{name} must lie in [0, 1], got {value}")
      for name in RESTITUTIONS for value in (-0.1, 1.1, math.nan, math.inf)),
    *((name, value, f"{name} must be a real number, got {value!r}")
      for name in ("m_m", "mu_1", "eps_n1", "pole") for value in NOT_REAL),
    *(("expansion_friction", value,
       f"expansion_friction must be 'summed' or 'separate', got {value!r}")
      for value in ("sum", "Summed", "SUMMED", "", None, 0, 1.0, True, ["summed"])),
    *(("r_m", value,
       f"r_m must exceed r_0 = 0.0025, or the sleeve does not fit on the pole, got {value}")
      for value in (0.0025, 0.0024)),
    ("l_s", 0.023, "l_m + l_g must exceed l_s + r_0, or the beak is inside the pole, "
     f"got {0.010 + 0.015} and {0.023 + 0.0025}"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "value", "sentence"), REFUSED)
def test_wrong_values_are_refused_in_a_sentence(name: str, value: object, sentence: str) -> None:
    """The same of constructor and replace; numpy makes floats of some that are no numbers."""
    for make in (Toy, Toy().replace):
        with pytest.raises(TypeError if "a real number" in sentence else ValueError) as caught:
            make(**{name: value})  # type: ignore[arg-type]
        assert str(caught.value) == sentence


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
    assert "expansion_friction" not in parameters()  # no number to continue in
    for way in (pickled, copy.copy, copy.deepcopy, Toy.replace):
        assert way(toys[0]) == toys[0]
        assert way(toys[0]).expansion_friction is ExpansionFriction(law)
