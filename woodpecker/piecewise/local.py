"""The local model at a border collision: two lines and a jump, solved exactly by pwmap.

Next to a collision of a fixed point with a jump x_d(p) the map is, to first order in y = x - x_d(p)
and q = p - p_0, a piecewise-linear map of y with one break at zero. Its coefficients are what the
kernel gives exactly on both sides of the jump: limits, slopes, and derivatives in the parameter.
What :mod:`pwmap` proves of it is what the paper's Figure 12 shows of point A: which branches start
there, of which iterates, on which side, and with which slope over the parameter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import sympy

from pwmap.diagrams.diagram import BranchKind, Diagram, SpecialPoint
from pwmap.maps.piecewise_linear import PiecewiseLinearMap
from pwmap.parameters.bifurcations import bifurcation_diagram as exact_diagram
from woodpecker.piecewise.borders import Edge, edge_at
from woodpecker.piecewise.maps import LabelledMap
from woodpecker.piecewise.tolerances import DEFAULT, Tolerances

Q = sympy.Symbol("q")
REACH = Fraction(1, 10**6)  # of the model in q; it is linear, so any small interval will do


@dataclass(frozen=True, slots=True, kw_only=True)
class Start:
    """A branch that the local model predicts at the collision.

    Attributes
    ----------
    kind, order, word
        As in a diagram; the words say L and R for the two sides of the jump.
    side
        +1 if it lies at larger parameters, -1 at smaller ones.
    slope
        dx/dp at the collision.
    """

    kind: BranchKind
    order: int
    word: str
    side: int
    slope: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LocalModel:
    """The piecewise-linear map next to a border collision, and what it predicts.

    Attributes
    ----------
    edge
        The jump at the collision, as the map shows it.
    speed
        dx_d/dp, how fast the jump moves.
    map
        The model in y = x - x_d(p), with the parameter q = p - p_0.
    diagram
        Its exact bifurcation diagram over a small interval of q.
    point
        The special point of the diagram at q = 0, y = 0.
    inner
        The letter, L or R, of the side on which the fixed point lives.
    starts
        The branches that end there and are local: their orbits stay next to the jump, but for the
        last step on one side of it. Where an orbit goes that has left, two lines do not know.
    """

    edge: Edge
    speed: float
    map: PiecewiseLinearMap
    diagram: Diagram
    point: SpecialPoint
    inner: str
    starts: tuple[Start, ...]


def local_model(
    labelled_map: LabelledMap,
    x: float,
    p: float,
    orders: Sequence[int] = (1, 2, 3, 4),
    tolerances: Tolerances = DEFAULT,
) -> LocalModel:
    """Build and solve the local model at a border collision.

    Parameters
    ----------
    labelled_map
        For instance :func:`woodpecker.toy_map`.
    x, p
        The collision, for instance a BC or FF point of a diagram.
    orders
        Iterates of the model to look at.

    Raises
    ------
    ValueError
        If the map does not jump at x, or neither limit lies on the diagonal there.
    """
    step = tolerances.landing
    edges = [edge_at(labelled_map, x, p + dp, 100.0 * step) for dp in (-step, 0.0, step)]
    edge = edges[1]
    if not abs(edge.jump) > tolerances.jump:
        raise ValueError(f"the map does not jump at x = {x}, p = {p}")
    gaps = {-1: edge.left_limit - edge.x, 1: edge.right_limit - edge.x}
    inner = min(gaps, key=lambda side: abs(gaps[side]))
    if abs(gaps[inner]) > tolerances.jump:
        raise ValueError(f"no limit of the jump at x = {x}, p = {p} lies on the diagonal")
    gaps[inner] = 0.0  # up to rounding
    speed = (edges[2].x - edges[0].x) / (2.0 * step)
    y = sympy.Symbol("y")
    formulas = [
        _exact(side.slope) * y
        + _exact(gaps[sign])
        + _exact(side.rate + (side.slope - 1.0) * speed) * Q
        for sign, side in ((-1, edge.left), (1, edge.right))
    ]
    model = PiecewiseLinearMap([(formulas[0], y < 0), (formulas[1], y >= 0)], y)
    found = exact_diagram(model, Q, (-REACH, REACH), orders)
    (point,) = (point for point in found.points if point.exact["parameter"] == 0 == point.x)
    return LocalModel(
        edge=edge,
        speed=speed,
        map=model,
        diagram=found,
        point=point,
        inner="LR"[inner > 0],
        starts=tuple(
            start for start in _starts(found, point, speed) if _is_local(start, "LR"[inner > 0])
        ),
    )


def _exact(value: float) -> sympy.Rational:
    fraction = Fraction(float(value))
    return sympy.Rational(fraction.numerator, fraction.denominator)


def _is_local(start: Start, inner: str) -> bool:
    words = start.word.split("|")
    return any(set(word) == {inner} for word in words) and all(
        set(word[:-1]) <= {inner} for word in words
    )


def _starts(found: Diagram, point: SpecialPoint, speed: float) -> list[Start]:
    left, right = found.sides(point.id)
    starts = []
    for side, names in ((-1, left), (1, right)):
        for name in names:
            branch = found.branch(name)
            rate = float(sympy.diff(branch.exact["x"], Q).subs(Q, 0))
            starts.append(
                Start(
                    kind=branch.kind,
                    order=branch.order,
                    word=branch.word,
                    side=side,
                    slope=rate + speed,
                )
            )
    return starts
