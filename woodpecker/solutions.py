"""Exact periodic solutions at a value of the parameter, from what a diagram shows there."""

from __future__ import annotations

from typing import NamedTuple

from pwmap.diagrams.diagram import Branch, BranchKind, Diagram
from woodpecker.mechanics.toy import Toy
from woodpecker.shooting import PeriodicOrbit, shoot


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
