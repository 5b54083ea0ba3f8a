"""What a diagram of the toy does not hold: solutions at a value, and observables along branches."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pwmap.diagrams.diagram import Branch, BranchKind, Diagram
from woodpecker.base.arrays import Floats
from woodpecker.mechanics.toy import Toy
from woodpecker.shooting import PeriodicOrbit, shoot
from woodpecker.simulation.returns import first_return


class OnBranch(NamedTuple):
    """A periodic solution of the toy, and the branch it lies on."""

    branch: Branch
    orbit: PeriodicOrbit


def solutions(toy: Toy, diagram: Diagram, value: float) -> tuple[OnBranch, ...]:
    """The periodic solutions at a value of a diagram's parameter, each solved for.

    A diagram lists samples of its branches, and :meth:`pwmap.Diagram.at` what lies on straight
    lines between them; from there Newton's method finds the solutions themselves.

    Parameters
    ----------
    toy
        The toy of the diagram; its own value of the parameter does not matter.
    diagram
        From :func:`woodpecker.continuation` or :func:`woodpecker.bifurcation_diagram`.
    value
        The value of the parameter.

    Returns
    -------
    tuple
        One for each time that a branch of fixed points passes the value, in order of phi_S; where
        ``orbit.success`` is false, ``orbit.message`` says why. Jumps are no solutions.

    Raises
    ------
    TypeError
        If the diagram's parameter is none of the toy.
    ValueError
        If the toy cannot have this value.
    """
    there = toy.replace(**{diagram.parameter_name: float(value)})
    return tuple(
        OnBranch(hit.branch, shoot(there, hit.x, hit.branch.order))
        for hit in diagram.at(value)
        if hit.branch.kind is BranchKind.FIXED_POINT
    )


OF_A_RETURN = ("period", "drop")  # attributes of woodpecker.Return, by name
Observable = Callable[[Toy, float], float]


def known_observables(names: Iterable[str]) -> None:
    """Complain of a name that :func:`observables` does not know, with a ValueError."""
    for name in names:
        if name not in OF_A_RETURN:
            raise ValueError(f"an observable must be one of {', '.join(OF_A_RETURN)}, got {name!r}")


def observables(toy: Toy, diagram: Diagram, *names: str, **functions: Observable) -> Diagram:
    """The same diagram with what is observed along its branches: period, drop, or what you like.

    The samples of fixed-point branches are periodic motions, and each is simulated, so values are
    exact there; between samples they can be interpolated like x. Jumps are no motions: their values
    are nan.

    Parameters
    ----------
    toy, diagram
        As :func:`solutions` takes them.
    names
        Some of ``"period"`` [s] and ``"drop"`` [m, positive down], of P_order.
    functions
        By name, functions of the toy, with the sample's value of the parameter, and phi_S [rad].

    Returns
    -------
    Diagram
        Each branch has the values in :attr:`pwmap.Branch.columns`; files of results
        (:func:`pwmap.diagrams.tables.write_results`) have a column for each.

    Raises
    ------
    ValueError
        If a name is unknown.
    TypeError
        If the diagram's parameter is none of the toy.
    """
    known_observables(names)
    branches = tuple(
        replace(
            branch, columns={**branch.columns, **_observed(toy, diagram, branch, names, functions)}
        )
        for branch in diagram.branches
    )
    return replace(diagram, branches=branches)


def _observed(
    toy: Toy, diagram: Diagram, branch: Branch, names: tuple[str, ...],
    functions: dict[str, Observable],
) -> dict[str, Floats]:  # fmt: skip
    """Columns of one branch."""
    found = {name: np.full(len(branch), math.nan) for name in (*names, *functions)}
    if branch.kind is not BranchKind.FIXED_POINT:
        return found
    for k in range(len(branch)):
        there = toy.replace(**{diagram.parameter_name: float(branch.parameter[k])})
        x = float(branch.x[k])
        back = first_return(there, x, branch.order) if names else None
        for name in names:
            found[name][k] = getattr(back, name)
        for name, function in functions.items():
            found[name][k] = function(there, x)
    return found
