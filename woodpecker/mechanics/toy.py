"""The Woodpecker Toy: its parameters in SI units, with the paper's data set as defaults."""

from __future__ import annotations

import dataclasses
import math
import numbers
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from enum import Enum, StrEnum
from typing import Any, Literal, NamedTuple

from pwmap.algebra.arguments import explained_fields
from pwmap.diagrams.shown import changed
from woodpecker.base.shown import choice, real, shown

RESTITUTIONS = ("eps_n1", "eps_n2", "eps_n3")
# Where a restitution that is zero varies, paths are those of positive ones, with all bounces: they
# are searched at FAINT, where bounces stand out from rounding, and followed at INFINITESIMAL, where
# values are those at zero and squares do not underflow.
INFINITESIMAL, FAINT = 1e-60, 1e-10
LETTERS = {"mu": "μ", "eps": "ε", "phi": "φ", "j": "J"}  # symbols of names in code
LIMITING = "r_0", "r_m", "l_m", "l_g", "l_s"  # lengths that limit each other
LAW = "expansion_friction"  # the one field of a toy that is not a number
WINDOW = (-2.5, -0.24)  # [rad], where cycles are looked for: left of the band of centres


class Domain(Enum):
    """The domain of a parameter; its value completes the sentence "mu_1 must ..."."""

    POSITIVE = "be positive and finite"
    POSITIVE_OR_INFINITE = "be positive"
    FRICTION = "be at least 0 and finite"
    RESTITUTION = "lie in [0, 1]"

    def holds(self, value: float) -> bool:
        """Whether a value lies in the domain; nan lies in none."""
        match self:
            case Domain.POSITIVE:
                return 0.0 < value < math.inf
            case Domain.POSITIVE_OR_INFINITE:
                return value > 0.0
            case Domain.FRICTION:
                return 0.0 <= value < math.inf
            case Domain.RESTITUTION:
                return 0.0 <= value <= 1.0


class Description(NamedTuple):
    """The meaning, unit and domain of a parameter of the toy."""

    meaning: str
    unit: str  # "-" for a pure number
    domain: Domain


def _number(default: float, meaning: str, unit: str, domain: Domain = Domain.POSITIVE) -> Any:
    description = Description(meaning, unit, domain)
    return dataclasses.field(default=default, metadata={"description": description})


class ExpansionFriction(StrEnum):
    """What bounds friction in the expansion of an impact at two contacts 1 and k.

    The paper prints no contact problem; its Figures 8 to 11 come out with the sum, and not with
    Coulomb's law contact by contact.

    Examples
    --------
    >>> from woodpecker import Toy, ExpansionFriction, first_return
    >>> for law in ExpansionFriction:
    ...     print(law.value, round(first_return(Toy(expansion_friction=law), -0.85).phi_s, 9))
    summed -0.466299821
    separate -0.304460616
    """

    SUMMED = "summed"  # |Lambda_TE,i| <= mu_i (Lambda_NE,1 + Lambda_NE,k), equality where i slides
    SEPARATE = "separate"  # |Lambda_TE,i| <= mu_i Lambda_NE,i: Coulomb's law contact by contact


@explained_fields
@dataclass(frozen=True, slots=True, kw_only=True)
class Toy:
    """Data of the toy; index M is the sleeve, S the woodpecker [Leine2001, Results].

    Contacts: 1 beak, 2 lower edge of the sleeve, 3 upper edge of the sleeve.

    Parameters
    ----------
    m_m, j_m, m_s, j_s
        Masses [kg] and moments of inertia [kg m^2] of sleeve and woodpecker.
    g
        Gravity [m/s^2].
    r_0, r_m, h_m
        Radius of the pole, inner radius (r_m > r_0) and half height of the sleeve [m].
    l_m, l_g
        Distances [m] from sleeve centre to spring and from spring to the bird's centre of mass.
    h_s, l_s
        Height and length of the beak [m].
    c_phi
        Spring stiffness [N m/rad]. The paper omits it; the default gives its equilibrium and
        eigenfrequency.
    mu_1, mu_2, mu_3
        Friction coefficients [-].
    eps_n1, eps_n2, eps_n3
        Normal restitution coefficients [-], in [0, 1].
    pole
        Length of the pole below the start [m], by default infinite.
    expansion_friction
        ``"summed"`` or ``"separate"``, see :class:`ExpansionFriction`.

    Raises
    ------
    TypeError, ValueError
        If a value is not a real number, or out of range.

    Examples
    --------
    >>> from woodpecker import Toy
    >>> toy = Toy(mu_2=0.31)  # the paper's data, but for one
    >>> toy.replace(eps_n1=0.4).eps_n1
    0.4
    >>> round(toy.phi_m_max, 6), round(toy.phi_s_max, 6)  # rad
    (0.103448, 0.12)
    """

    m_m: float = _number(0.0003, "mass of the sleeve", "kg")
    j_m: float = _number(5.0e-9, "moment of inertia of the sleeve", "kg m^2")
    m_s: float = _number(0.0045, "mass of the woodpecker", "kg")
    j_s: float = _number(7.0e-7, "moment of inertia of the woodpecker", "kg m^2")
    g: float = _number(9.81, "gravity", "m/s^2")
    r_0: float = _number(0.0025, "radius of the pole", "m")
    r_m: float = _number(0.0031, "inner radius of the sleeve, larger than r_0", "m")
    h_m: float = _number(0.0058, "half height of the sleeve", "m")
    l_m: float = _number(0.010, "distance from the sleeve's centre to the spring", "m")
    l_g: float = _number(0.015, "distance from the spring to the bird's centre of mass", "m")
    h_s: float = _number(0.020, "height of the beak", "m")
    l_s: float = _number(0.0201, "length of the beak", "m")
    c_phi: float = _number(0.0056, "spring stiffness", "N m/rad")
    mu_1: float = _number(0.3, "friction coefficient of the beak", "-", Domain.FRICTION)
    mu_2: float = _number(0.3, "friction coefficient of the lower edge", "-", Domain.FRICTION)
    mu_3: float = _number(0.3, "friction coefficient of the upper edge", "-", Domain.FRICTION)
    eps_n1: float = _number(0.5, "normal restitution of the beak", "-", Domain.RESTITUTION)
    eps_n2: float = _number(
        0.0, "normal restitution of the sleeve's lower edge", "-", Domain.RESTITUTION
    )
    eps_n3: float = _number(
        0.0, "normal restitution of the sleeve's upper edge", "-", Domain.RESTITUTION
    )
    pole: float = _number(
        math.inf, "length of the pole below the start", "m", Domain.POSITIVE_OR_INFINITE
    )
    expansion_friction: ExpansionFriction | Literal["summed", "separate"] = ExpansionFriction.SUMMED

    def __repr__(self) -> str:
        return changed(self)

    def __post_init__(self) -> None:
        for name in parameters():
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, numbers.Real | Decimal):
                raise TypeError(f"{name} must be a real number, got {value!r}")
            object.__setattr__(self, name, real(name, value))
        object.__setattr__(self, LAW, choice(LAW, self.expansion_friction, ExpansionFriction))
        for name, (_, _, domain) in _DESCRIPTIONS.items():
            value = getattr(self, name)
            if not domain.holds(value):
                raise ValueError(f"{name} must {domain.value}, got {value}")
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
        """Copy with some fields changed, in SI units, for instance ``eps_n1=0.3``.

        TypeError if a name is unknown, ValueError if a value is out of range.
        """
        for name in changes:
            if name != LAW:
                known_parameter(name)
        return dataclasses.replace(self, **changes)

    @property
    def phi_m_max(self) -> float:
        """Largest abs(phi_M) [rad]: (r_M - r_0)/h_M."""
        return (self.r_m - self.r_0) / self.h_m

    @property
    def phi_s_max(self) -> float:
        """Largest phi_S [rad]: (l_M + l_G - l_S - r_0)/h_S, where the beak strikes."""
        return (self.l_m + self.l_g - self.l_s - self.r_0) / self.h_s


_DESCRIPTIONS: dict[str, Description] = {
    field.name: field.metadata["description"]
    for field in dataclasses.fields(Toy)
    if field.name != LAW
}


def parameters() -> tuple[str, ...]:
    """Names of the toy's parameters.

    Returns
    -------
    tuple of str
        In the order of the fields of :class:`Toy`.

    Examples
    --------
    >>> from woodpecker import parameters
    >>> parameters()[:4], len(parameters())
    (('m_m', 'j_m', 'm_s', 'j_s'), 20)
    """
    return tuple(_DESCRIPTIONS)


def known_parameter(name: str) -> str:
    """The name of a parameter; TypeError if the toy has none of this name."""
    if not isinstance(name, str) or name not in _DESCRIPTIONS:
        expected = ", ".join(parameters())
        raise TypeError(f"unknown parameter {shown(name)}, expected one of {expected}")
    return name


def description(name: str) -> Description:
    """The description of a parameter of the toy; TypeError if there is none."""
    return _DESCRIPTIONS[known_parameter(name)]


def symbol(parameter: str) -> tuple[str, str]:
    """The letter and the index of a parameter as the paper writes it; the index may be empty."""
    letter, _, index = parameter.partition("_")
    return LETTERS.get(letter, letter), LETTERS.get(index, index.upper())


def limits(toy: Toy, parameter: str) -> tuple[float, float]:
    """Interval of a parameter, all others fixed; Toy decides whether its ends belong to it."""
    domain = _DESCRIPTIONS[known_parameter(parameter)].domain
    low, high = 0.0, 1.0 if domain is Domain.RESTITUTION else math.inf
    value: float = getattr(toy, parameter)
    play = toy.l_m + toy.l_g - toy.l_s - toy.r_0  # gap of the beak at phi_S = 0
    match parameter:
        case "r_m":
            low = toy.r_0
        case "r_0":
            high = min(toy.r_m, value + play)
        case "l_s":
            high = value + play
        case "l_m" | "l_g":
            low = max(low, value - play)
    return low, high


def is_possible(toy: Toy, values: Mapping[str, float]) -> bool:
    """Whether a toy can have other values, which must be floats: the checks of a new toy."""
    # Asked before each return: a new toy would check all of its values.
    for name, value in values.items():
        if not (isinstance(value, float) and _DESCRIPTIONS[name].domain.holds(value)):
            return False
    if values.keys().isdisjoint(LIMITING):
        return True
    lengths: list[float] = [values.get(name, getattr(toy, name)) for name in LIMITING]
    r_0, r_m, l_m, l_g, l_s = lengths
    return r_m > r_0 and l_m + l_g - l_s - r_0 > 0.0
