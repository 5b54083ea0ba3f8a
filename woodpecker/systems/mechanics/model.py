"""Mechanical systems with contacts: Eq. (1)-(3) of the paper as data, checked once.

A system is its mass matrix, its forces and its contacts, as expressions of sympy in coordinates,
velocities, time and parameters. Everything else is derived from them.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

import numpy as np
import sympy
from sympy.core.function import AppliedUndef
from sympy.utilities.exceptions import SymPyDeprecationWarning

from pwmap.algebra.arguments import explained_fields
from woodpecker.base.arrays import Floats
from woodpecker.base.checks import number
from woodpecker.base.shown import choice, shown
from woodpecker.systems.mechanics.expressions import (
    are_equal,
    by_cases,
    check_known,
    continuous,
    expression,
    smooth,
    vanishes,
)

MOST_CONTACTS = 30  # as many as a bit mask holds, and more than anybody writes down


class ImpactLaw(Enum):
    """What an impact does in the normal direction [Leine2001, Pfeiffer1996]."""

    POISSON = "poisson"  # an expansion gives back part of the impulse of the compression
    NEWTON = "newton"  # one phase, in which the gap rate is reversed in part


class FrictionBound(Enum):
    """Which normal impulses bound friction where several contacts expand at once."""

    SEPARATE = "separate"  # that of the contact itself: Coulomb's law contact by contact
    SUMMED = "summed"  # those of all contacts of the impact


@explained_fields
@dataclass(frozen=True, kw_only=True, eq=False)
class Contact:
    """A unilateral contact with Coulomb friction.

    Parameters
    ----------
    name
        Its name in messages, as in "the stop".
    gap
        g_N [m], an expression of coordinates and time; positive where the contact is open.
    slip
        Tangential relative velocity [m/s], linear in the velocities; without it there is no
        friction.
    mu
        Friction coefficient [-], a number or an expression of parameters.
    eps_n
        Normal restitution [-] in 0..1, a number or an expression of parameters.

    Raises
    ------
    ValueError
        If a number lies outside of its range, or there is friction but no slip.
    TypeError
        If an argument is no expression.
    """

    name: str
    gap: Any
    slip: Any = None
    mu: Any = 0
    eps_n: Any = 0

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name.strip():
            raise ValueError(f"a contact needs a name, got {shown(self.name)}")
        for part in ("gap", "slip", "mu", "eps_n"):
            if part != "slip" or self.slip is not None:
                text = f"{part} of {self.name!r}"
                value = expression(text, getattr(self, part))
                made = smooth(text, value) if part in ("gap", "slip") else by_cases(value)
                object.__setattr__(self, part, made)
        self.check_laws({})
        if self.slip is None and self.rubs:
            mu = sympy.sstr(self.mu, full_prec=False)
            raise ValueError(f"{self.name!r} has friction, and needs a slip: mu is {mu}")

    def check_laws(self, parameters: Mapping[sympy.Symbol, float]) -> None:
        """ValueError if friction or restitution is out of range, where parameters determine it."""
        for part, high in (("mu", math.inf), ("eps_n", 1.0)):
            value = getattr(self, part).subs(parameters)
            if value.is_number and not 0.0 <= real(f"{part} of {self.name!r}", value) <= high:
                limit = ">= 0" if high == math.inf else "in [0, 1]"
                raise ValueError(f"{part} of {self.name!r} must be {limit}, got {value}")

    @property
    def rubs(self) -> bool:
        """Whether the contact has friction."""
        return not self.mu.is_zero  # the float 0.0 of sympy is not equal to 0


@explained_fields
@dataclass(frozen=True, eq=False)
class ContactSystem:
    """M(q, t) u' = h(q, u, t) + sum (w_N lambda_N + w_T lambda_T) [Leine2001, Eq. 1].

    Parameters
    ----------
    q
        The n coordinates, symbols of sympy; :func:`from_kane` takes dynamic symbols.
    M
        (n, n) mass matrix, symmetric and positive definite; of coordinates, time and parameters.
    h
        (n,) all smooth forces; of coordinates, velocities, time and parameters.
    contacts
        May be none, where only forces have kinks.
    parameters
        Values of all parameters, in SI units, by symbol or by name.
    u
        The n velocities q'; by default the symbols ``u_x`` of a coordinate ``x``.
    time
        The symbol of time.
    law
        ``"poisson"`` (the paper) or ``"newton"``.
    expansion_friction
        ``"separate"``: friction in the expansion of several contacts is bounded by each contact's
        own impulse; ``"summed"``: by that of all of them.

    Raises
    ------
    ValueError
        If shapes do not fit, a symbol is unknown, or it is no system of this kind; the sentence
        says what is wrong.
    TypeError
        If an argument is no expression, or no contact.

    Examples
    --------
    >>> from sympy import symbols
    >>> from woodpecker.systems import Contact, ContactSystem
    >>> y, g, eps = symbols("y g eps")
    >>> floor = Contact(name="floor", gap=y, eps_n=eps)
    >>> ball = ContactSystem([y], [[1]], [-g], [floor], {g: 9.81, eps: 0.8})
    >>> ball.q, ball.u, ball.n
    ((y,), (u_y,), 1)
    """

    q: Sequence[Any]
    M: Any
    h: Any
    contacts: Sequence[Contact]
    parameters: Mapping[Any, float]
    u: Any = None
    time: sympy.Symbol = sympy.Symbol("t")  # noqa: RUF009  # symbols do not change
    law: ImpactLaw | str = ImpactLaw.POISSON
    expansion_friction: FrictionBound | str = FrictionBound.SEPARATE

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "q", names("q", self.q))
        n = len(self.q)
        given = [f"u_{each}" for each in self.q] if self.u is None else self.u
        put(self, "u", names("u", given))
        if len(self.u) != n:
            raise ValueError(
                f"u must have {n} velocities, one of each coordinate, got {len(self.u)}"
            )
        put(self, "time", names("time", [self.time])[0])
        put(self, "law", choice("law", self.law, ImpactLaw))
        bound = choice("expansion_friction", self.expansion_friction, FrictionBound)
        put(self, "expansion_friction", bound)
        put(self, "M", _matrix("M", self.M, (n, n)))
        put(self, "h", _matrix("h", self.h, (n, 1)))
        put(self, "contacts", _contacts(self.contacts))
        put(self, "parameters", _parameters(self.parameters))
        put(self, "h", self.h.applyfunc(lambda each: continuous("h", each, self.parameters)))
        self._check_symbols()
        self._check_mechanics()

    @property
    def n(self) -> int:
        """The number of coordinates."""
        return len(self.q)

    @property
    def state(self) -> tuple[sympy.Symbol, ...]:
        """Coordinates, velocities and time: the symbols of a state."""
        return (*self.q, *self.u, self.time)

    def replace(self, **values: float) -> ContactSystem:
        """The same system with other values of parameters, by name.

        Raises
        ------
        ValueError
            If a parameter is unknown, or a value is not finite or out of range.
        """
        changed = dict(zip(self.named(values), values.values(), strict=True))
        return replace(self, parameters={**self.parameters, **changed})

    def named(self, names: Iterable[str]) -> list[sympy.Symbol]:
        """The parameters with some names; ValueError if one is unknown."""
        known = {str(symbol): symbol for symbol in self.parameters}
        for name in names:
            if name not in known:
                raise ValueError(f"unknown parameter {name!r}, the system has {sorted(known)}")
        return [known[name] for name in names]

    def check_laws(self, parameters: Mapping[sympy.Symbol, float]) -> None:
        """ValueError if values of parameters put masses, friction or restitution out of range."""
        mass = self.M.subs(parameters)
        if not mass.free_symbols and (why := no_inertia(np.array(mass, dtype=float))):
            raise ValueError(why)
        for each in self.contacts:
            each.check_laws(parameters)

    def _check_symbols(self) -> None:
        listed = (*self.q, *self.u, self.time, *self.parameters)
        twice = sorted({str(s) for s in listed if [str(r) for r in listed].count(str(s)) > 1})
        if twice:
            raise ValueError(f"{twice[0]} is used twice among q, u, time and parameters")
        place, held = {*self.q, self.time, *self.parameters}, set(self.parameters)
        self._within("M", self.M, place, "coordinates, time and parameters")
        self._within("h", self.h, set(listed), "q, u, time and parameters")
        for each in self.contacts:
            of = f"of {each.name!r}"
            self._within(f"the gap {of}", each.gap, place, "coordinates, time and parameters")
            self._within(f"mu {of}", each.mu, held, "parameters")
            self._within(f"eps_n {of}", each.eps_n, held, "parameters")
            if each.slip is not None:
                self._within(f"the slip {of}", each.slip, set(listed), "q, u, time and parameters")

    def _within(self, what: str, value: Any, allowed: set[sympy.Symbol], said: str) -> None:
        for each in sympy.flatten([value]):
            check_known(what, each)
        for symbol in sorted(value.free_symbols - allowed, key=str):
            if symbol in self.u:
                raise ValueError(f"{what} must not depend on the velocity {symbol}")
            raise ValueError(
                f"{what} has the unknown symbol {symbol}, of which parameters has no value; it may "
                f"have {said}{namesake(symbol, allowed)}"
            )

    def _check_mechanics(self) -> None:
        if not all(map(are_equal, self.M, self.M.T)):
            raise ValueError("M must be symmetric")
        if vanishes(self.M.det()):
            raise ValueError("M is singular: every coordinate needs inertia")
        self.check_laws(self.parameters)
        for each in self.contacts:
            if all(vanishes(each.gap.diff(q)) for q in self.q):
                raise ValueError(
                    f"the gap of {each.name!r} is one that no coordinate moves; a contact that "
                    "stays closed has a coordinate as its gap, and a force that presses on it"
                )
            if each.slip is None:
                continue
            if not all(vanishes(each.slip.diff(v, w)) for v in self.u for w in self.u):
                raise ValueError(f"the slip of {each.name!r} must be linear in the velocities")
            if each.rubs and all(vanishes(each.slip.diff(v)) for v in self.u):
                raise ValueError(f"the slip of {each.name!r} is one that no velocity moves")


def from_kane(method: Any, contacts: Sequence[Contact], parameters: Mapping[Any, float],
              **options: Any) -> ContactSystem:  # fmt: skip
    """Make a system of a KanesMethod or LagrangesMethod of ``sympy.physics.mechanics``.

    Parameters
    ----------
    method
        Its equations must have been formed, without contact forces. The velocities of Kane's
        method must be the rates of the coordinates.
    contacts, parameters, **options
        As :class:`ContactSystem` takes them, in the method's dynamic symbols.

    Returns
    -------
    ContactSystem
        With plain symbols in place of dynamic ones.

    Raises
    ------
    ValueError
        If there are fewer velocities than coordinates, or other ones, or constraints.
    TypeError
        If it is no such method.
    """
    from sympy.physics.mechanics import dynamicsymbols

    t = dynamicsymbols._t
    coordinates = list(getattr(method, "q", ()))
    if not coordinates or not hasattr(method, "mass_matrix"):
        raise TypeError(f"expected a KanesMethod or LagrangesMethod, got {shown(method)}")
    speeds = list(method.u)
    if len(speeds) != len(coordinates):
        raise ValueError(
            f"as many velocities as coordinates are needed, got {len(speeds)} and "
            f"{len(coordinates)}"
        )
    rates = {q.diff(t): u for q, u in zip(coordinates, speeds, strict=True)}
    kinematics: dict[Any, Any] = getattr(method, "kindiffdict", dict)()
    for q, u in zip(coordinates, speeds, strict=True):
        if kinematics and not are_equal(sympy.sympify(kinematics[q.diff(t)]), u):
            raise ValueError(f"{u} must be the rate of {q}, it is another velocity")
    plain = {each: sympy.Symbol(each.func.__name__) for each in coordinates}
    plain |= {
        u: sympy.Symbol(u.func.__name__ if u not in rates else f"u_{plain[q]}")
        for q, u in zip(coordinates, speeds, strict=True)
    }

    def changed(value: Any) -> Any:
        return sympy.sympify(value).subs(rates).subs(plain)

    made = [
        Contact(
            name=c.name, gap=changed(c.gap), mu=c.mu, eps_n=c.eps_n,
            slip=None if c.slip is None else changed(c.slip),
        )
        for c in contacts
    ]  # fmt: skip
    return ContactSystem(
        tuple(plain[q] for q in coordinates), changed(method.mass_matrix), changed(method.forcing),
        tuple(made), parameters, u=tuple(plain[u] for u in speeds), time=t, **options,
    )  # fmt: skip


# --- Checks ---------------------------------------------------------------------------------------


def no_inertia(mass: Floats) -> str:
    """Why a symmetric matrix (n, n) is no mass matrix; empty if it is one."""
    if not np.isfinite(mass).all() or np.linalg.eigvalsh(mass)[0] > 0.0:
        return ""  # values that are not finite are reported with the forces
    return f"M must be positive definite, got {mass.tolist()}"


def real(name: str, value: sympy.Expr) -> float:
    """A number of sympy as a float; ValueError unless it is real."""
    if value.is_real is False or not value.is_number:
        raise ValueError(f"{name} must be a real number, got {value}")
    return float(value)


def names(name: str, value: Any) -> tuple[sympy.Symbol, ...]:
    """Distinct symbols, from symbols or their names."""
    if isinstance(value, str | sympy.Basic) or not isinstance(value, Iterable):
        raise TypeError(f"{name} must be a list of symbols, got {shown(value)}")
    found = tuple(sympy.Symbol(each) if isinstance(each, str) else each for each in value)
    for each in found:
        if not isinstance(each, sympy.Symbol):
            hint = "; from_kane takes dynamic symbols" if isinstance(each, AppliedUndef) else ""
            raise TypeError(f"{name} must be symbols, got {shown(each)}{hint}")
        if found.count(each) > 1:
            raise ValueError(f"{each} is used twice in {name}")
    if not found:
        raise ValueError(f"{name} must not be empty")
    return found


def namesake(symbol: sympy.Symbol, known: Iterable[sympy.Symbol]) -> str:
    """What distinguishes an unknown symbol from a known one of the same name; empty without one."""
    if str(symbol) not in map(str, known):
        return ""
    return (
        f", and the system's {symbol} has other assumptions, such as real=True: use one symbol "
        "everywhere, also in u and time"
    )


def _matrix(name: str, value: Any, shape: tuple[int, int]) -> sympy.ImmutableMatrix:
    try:
        with warnings.catch_warnings():  # of entries that are no expressions, as checked below
            warnings.simplefilter("ignore", SymPyDeprecationWarning)
            found = sympy.ImmutableMatrix(value)
    except (TypeError, ValueError, sympy.SympifyError):
        raise TypeError(f"{name} must be a matrix of expressions, got {shown(value)}") from None
    if found.shape != shape:
        wanted, given = (
            each if each[1] > 1 or name == "M" else each[:1] for each in (shape, found.shape)
        )
        raise ValueError(f"{name} must have the shape {wanted}, got {given}")
    checked = smooth if name == "M" else expression
    return found.applyfunc(lambda each: checked(f"an entry of {name}", each))


def _contacts(value: Any) -> tuple[Contact, ...]:
    if isinstance(value, Contact) or not isinstance(value, Iterable):
        raise TypeError(f"contacts must be a list of Contact, got {shown(value)}")
    found = tuple(value)
    for each in found:
        if not isinstance(each, Contact):
            raise TypeError(f"contacts must be Contact, got {shown(each)}")
    if len(found) > MOST_CONTACTS:
        raise ValueError(f"a system has at most {MOST_CONTACTS} contacts, got {len(found)}")
    called = [each.name for each in found]
    if len(set(called)) < len(called):
        raise ValueError(f"contacts need different names, got {called}")
    return found


def _parameters(value: Any) -> dict[sympy.Symbol, float]:
    if not isinstance(value, Mapping):
        raise TypeError(f"parameters must be a mapping of symbols to values, got {shown(value)}")
    found = {}
    for symbol, given in value.items():
        (key,) = names("parameters", [symbol])
        if key in found:
            raise ValueError(f"parameter {key} is given twice, as a symbol and as a name")
        found[key] = number(f"parameter {key}", given)
        if not math.isfinite(found[key]):
            raise ValueError(f"parameter {key} must be finite, got {given}")
    return found
