"""The Woodpecker Toy: its parameters in SI units, with the paper's data set as defaults."""

from __future__ import annotations

import dataclasses
import math
import numbers
from dataclasses import dataclass
from decimal import Decimal
from enum import StrEnum
from typing import Any, Literal

_POSITIVE = (
    *("m_m", "j_m", "m_s", "j_s", "g", "r_0", "r_m"),
    *("h_m", "l_m", "l_g", "h_s", "l_s", "c_phi", "pole"),
)
_FRICTION = ("mu_1", "mu_2", "mu_3")
_RESTITUTION = ("eps_n1", "eps_n2", "eps_n3")


class ExpansionFriction(StrEnum):
    """What bounds friction in the expansion of an impact at two contacts 1 and k.

    The paper prints no contact problem. That its program used the sum is inferred: the paper's
    Figures 8 to 11 follow from it, and not from Coulomb's law contact by contact.
    """

    SUMMED = "summed"  # |Lambda_TE,i| <= mu_i (Lambda_NE,1 + Lambda_NE,k), equality where i slides
    SEPARATE = "separate"  # |Lambda_TE,i| <= mu_i Lambda_NE,i: Coulomb's law contact by contact


@dataclass(frozen=True, slots=True, kw_only=True)
class Toy:
    """Data of the toy; index M is the sleeve, S the woodpecker [Leine2001, Results].

    Contacts: 1 beak, 2 lower edge of the sleeve, 3 upper edge of the sleeve.

    Parameters
    ----------
    m_m, j_m
        Mass [kg] and moment of inertia [kg m^2] of the sleeve.
    m_s, j_s
        Mass [kg] and moment of inertia [kg m^2] of the woodpecker.
    g
        Gravity [m/s^2].
    r_0, r_m
        Radius of the pole and inner radius of the sleeve [m], r_m > r_0.
    h_m
        Half height of the sleeve [m].
    l_m, l_g
        Distances [m] from sleeve centre to spring and from spring to the bird's centre of mass.
    h_s, l_s
        Height and length of the beak [m].
    c_phi
        Spring stiffness [N m/rad]. The paper omits it; this value gives its printed
        equilibrium and eigenfrequency.
    mu_1, mu_2, mu_3
        Friction coefficients [-].
    eps_n1, eps_n2, eps_n3
        Normal restitution coefficients [-], in [0, 1].
    pole
        Length of the pole below the start [m]; infinite unless given.
    expansion_friction
        ``"summed"`` or ``"separate"``: what bounds friction in the expansion of an impact at two
        contacts, see :class:`ExpansionFriction`. All else is the same under both.

    Raises
    ------
    TypeError
        If a value is not a real number.
    ValueError
        If a value is out of range; the sentence names the value and the range.
    """

    m_m: float = 0.0003
    j_m: float = 5.0e-9
    m_s: float = 0.0045
    j_s: float = 7.0e-7
    g: float = 9.81
    r_0: float = 0.0025
    r_m: float = 0.0031
    h_m: float = 0.0058
    l_m: float = 0.010
    l_g: float = 0.015
    h_s: float = 0.020
    l_s: float = 0.0201
    c_phi: float = 0.0056
    mu_1: float = 0.3
    mu_2: float = 0.3
    mu_3: float = 0.3
    eps_n1: float = 0.5
    eps_n2: float = 0.0
    eps_n3: float = 0.0
    pole: float = math.inf
    expansion_friction: ExpansionFriction | Literal["summed", "separate"] = ExpansionFriction.SUMMED

    def __post_init__(self) -> None:
        for name in parameters():
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, numbers.Real | Decimal):
                raise TypeError(f"{name} must be a real number, got {value!r}")
            object.__setattr__(self, name, float(value))
        try:
            law = ExpansionFriction(self.expansion_friction)
        except ValueError:
            raise ValueError(
                "expansion_friction must be 'summed' or 'separate', "
                f"got {self.expansion_friction!r}"
            ) from None
        object.__setattr__(self, "expansion_friction", law)
        for name in _POSITIVE:
            value = getattr(self, name)
            if not (value > 0.0 and (math.isfinite(value) or name == "pole")):
                raise ValueError(f"{name} must be positive and finite, got {value}")
        for name in _FRICTION:
            value = getattr(self, name)
            if not (value >= 0.0 and math.isfinite(value)):
                raise ValueError(f"{name} must be at least 0 and finite, got {value}")
        for name in _RESTITUTION:
            value = getattr(self, name)
            if not 0.0 <= value <= 1.0:
                raise ValueError(f"{name} must lie in [0, 1], got {value}")
        if self.r_m <= self.r_0:
            raise ValueError(
                f"r_m must exceed r_0 = {self.r_0}, or the sleeve does not fit on the pole, "
                f"got {self.r_m}"
            )
        if self.l_m + self.l_g - self.l_s - self.r_0 <= 0.0:
            raise ValueError(
                "l_m + l_g must exceed l_s + r_0, or the beak is inside the pole, got "
                f"{self.l_m + self.l_g} and {self.l_s + self.r_0}"
            )

    def replace(self, **changes: Any) -> Toy:
        """Copy with some values changed; TypeError names an unknown one."""
        for name in changes:
            if name != LAW:
                known_parameter(name)
        return dataclasses.replace(self, **changes)

    @property
    def phi_m_max(self) -> float:
        """Largest |phi_M| [rad]: (r_M - r_0)/h_M."""
        return (self.r_m - self.r_0) / self.h_m

    @property
    def phi_s_max(self) -> float:
        """Largest phi_S [rad]: (l_M + l_G - l_S - r_0)/h_S, where the beak strikes."""
        return (self.l_m + self.l_g - self.l_s - self.r_0) / self.h_s


LAW = "expansion_friction"


def parameters() -> tuple[str, ...]:
    """Names of the toy's parameters: all of its numbers."""
    return tuple(field.name for field in dataclasses.fields(Toy) if field.name != LAW)


def known_parameter(name: str) -> str:
    """The name itself; TypeError if the toy has no such parameter."""
    if name not in parameters():
        raise TypeError(f"unknown parameter {name!r}, expected one of {', '.join(parameters())}")
    return name
