"""The local model at a border collision: two lines and a jump, solved exactly by pwmap.

Next to a collision of a fixed point with a jump x_d(p) the map is, to first order in y = x - x_d(p)
and q = p - p_0, a piecewise-linear map of y with one break at zero. Its coefficients are exact: the
limits, slopes and parameter derivatives of both pieces at the jump, which moves at the rate
-h_p/h_x, where h is the margin that vanishes there. The exact diagram of this model shows what
[Leine2001, Fig. 12] shows of point A: which branches start there, and on which side.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import sympy

from pwmap.diagrams.diagram import BranchKind, Diagram, SpecialPoint
from pwmap.diagrams.shown import counted
from pwmap.maps.piecewise_linear import PiecewiseLinearMap
from pwmap.parameters.bifurcations import bifurcation_diagram as exact_diagram
from woodpecker.base.checks import instance, number
from woodpecker.base.settings import Settings
from woodpecker.engine.orbits import Closed, OnBorder
from woodpecker.maps.pieces import Image, PiecewiseMap, map_of_pieces
from woodpecker.slices.borders import Border
from woodpecker.slices.orbits import Orbit, solved
from woodpecker.slices.windows import border_of, nearest_border

Q = sympy.Symbol("q")
MODEL_REACH = Fraction(1, 10**6)  # half length of the model's span of q; linear, so any will do


@dataclass(frozen=True, slots=True, kw_only=True)
class Start:
    """A branch that the local model predicts at the collision, see :func:`woodpecker.local_model`.

    Attributes
    ----------
    kind, order, word
        As in a diagram; L and R are the sides of the jump.
    side
        +1 if the branch lies at larger parameters, -1 at smaller ones.
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
    border
        The jump at the collision, seen from the piece on which the fixed point lives.
    speed
        dx_d/dp, the rate at which the jump moves.
    map
        The model in y = x - x_d(p), with the parameter q = p - p_0.
    diagram, point
        Its exact bifurcation diagram over a small interval of q, and the special point in it at
        q = 0, y = 0.
    starts
        The branches that start there and are local: their orbits stay on the side of the fixed
        point, except that one limit of a jump leaves it with its last point, beyond the model.

    Examples
    --------
    >>> from woodpecker import local_model
    >>> from woodpecker.examples import paper_family
    >>> model = local_model(paper_family().over(0, (0.0, 1.25)), 0.0, 0.0)  # P1^L at r = 0
    >>> print(model.point.kind, model.point.note)
    FF fold
    >>> [(str(start.kind), start.order, round(start.slope, 6)) for start in model.starts]
    [('fixed-point', 1, 0.444444), ('jump', 1, 0.0), ('jump', 2, 0.8), ('jump', 3, 0.16), ('jump',
    4, 0.672)]
    """

    border: Border
    speed: float
    map: PiecewiseLinearMap
    diagram: Diagram
    point: SpecialPoint
    starts: tuple[Start, ...]

    def __repr__(self) -> str:
        branches = counted(len(self.starts), "branch")
        return (
            f"LocalModel({self.point.kind} at p={self.p:.10g}, x={self.x:.10g}: slopes "
            f"{self.left.slope:.6g} and {self.right.slope:.6g}, {branches})"
        )

    @property
    def x(self) -> float:
        """The place of the collision."""
        return self.border.x

    @property
    def p(self) -> float:
        """The parameter at the collision."""
        return self.border.p

    @property
    def left(self) -> Image:
        """The image of the jump under the piece at smaller x."""
        return self.border.inner if self.border.side > 0 else self.border.outer

    @property
    def right(self) -> Image:
        """The image of the jump under the piece at larger x."""
        return self.border.outer if self.border.side > 0 else self.border.inner

    @property
    def inner(self) -> str:
        """The letter, L or R, of the side on which the fixed point lives."""
        return _inner(self.border)


def local_model(
    map_: PiecewiseMap,
    x: float,
    p: float,
    orders: Sequence[int] = (1, 2, 3, 4),
    settings: Settings | None = None,
) -> LocalModel:
    """Build and solve the local model at a border collision.

    Parameters
    ----------
    map_
        For instance :class:`woodpecker.ToyPieces`; if a cycle of P_n collides, its
        :class:`woodpecker.maps.Iterate`.
    x, p
        A point within ``Settings.beside`` of the collision, such as a BC or FF of a diagram.
    orders
        Iterates of the model whose branches are found.
    settings
        Scales and tolerances.

    Returns
    -------
    LocalModel
        The two lines as an exact map, the special point, and the branches that start there.

    Raises
    ------
    ValueError
        If the map does not jump at x, or neither limit lies on the diagonal there; if the limit
        that does has an infinite slope, or stays on the diagonal to first order in the parameter.
    TypeError
        If the map has no pieces, see :class:`woodpecker.PiecewiseMap`.

    Examples
    --------
    >>> from woodpecker import Toy, ToyPieces, local_model
    >>> a = local_model(ToyPieces(Toy()), -0.8847733440, 0.1119709145, orders=(1, 2))
    >>> print(a.point.kind, a.point.note, f"slope {a.right.slope:.6f}")
    FF fold slope -1.304911
    >>> [(str(start.kind), start.order, round(start.slope, 3)) for start in a.starts]
    [('fixed-point', 1, 2.444), ('jump', 1, 0.0), ('jump', 2, 4.316)]
    """
    chosen = settings if settings is not None else Settings()
    instance("settings", chosen, Settings)
    border = _collision(map_of_pieces(map_), number("x", x), number("p", p), chosen)
    h_x, h_p = border.inner.gradient(border.code).tolist()
    speed = -h_p / h_x
    limit = border.inner.d_parameter + border.inner.slope * speed  # d/dp of P(x_d(p), p)
    if abs(limit - speed) <= chosen.kink * max(abs(limit), abs(speed)):
        raise ValueError(
            f"a limit of the jump at x = {x}, p = {p} stays on the diagonal as p changes, "
            "to first order: no fixed point crosses the jump"
        )
    model = _model(border, speed)
    found = exact_diagram(model, Q, (-MODEL_REACH, MODEL_REACH), orders)
    (point,) = (point for point in found.points if point.exact["parameter"] == 0 == point.x)
    inner = _inner(border)
    return LocalModel(
        border=border,
        speed=speed,
        map=model,
        diagram=found,
        point=point,
        starts=tuple(each for each in _starts(found, point, speed) if _is_local(each.word, inner)),
    )


def _inner(border: Border) -> str:
    return "L" if border.side > 0 else "R"


# --- The collision --------------------------------------------------------------------------------


def _collision(map_: PiecewiseMap, x: float, p: float, settings: Settings) -> Border:
    """The jump near x at which a fixed point ends, seen from the piece of that fixed point."""
    near = settings.beside * settings.x_scale
    met = nearest_border(map_, x, p, near, settings)
    if met is None or not met.is_jump(settings):
        raise ValueError(f"the map does not jump at x = {x}, p = {p}")
    other = Border(met.x, met.p, met.outer, met.outer_code, -met.side, met.inner, met.code)
    both = (_collision_at(map_, border, settings) for border in (met, other))
    found = [border for border in both if border is not None]
    if not found:
        raise ValueError(
            f"no limit of the jump at x = {x}, p = {p} lies on the diagonal with a finite slope"
        )
    return min(found, key=lambda border: abs(border.p - p))


def _collision_at(map_: PiecewiseMap, met: Border, settings: Settings) -> Border | None:
    """The jump where a fixed point of the inner piece meets it; None if they do not meet nearby."""
    if math.isinf(met.inner.slope):
        return None
    start = Orbit(np.array([met.x]), met.p, (met.inner,))
    found = solved(start, settings, Closed(), OnBorder(0, met.code))
    if found is None:
        return None
    x, p = float(found.x[0]), found.p
    moved = max(abs(x - met.x) / settings.x_scale, abs(p - met.p) / settings.p_scale)
    if moved > settings.beside:
        return None
    return border_of(map_, found.images[0], met.code, x, p, met.side, settings)


# --- The model ------------------------------------------------------------------------------------


def _model(border: Border, speed: float) -> PiecewiseLinearMap:
    """The model: one line on each side of the jump, in y = x - x_d(p)."""
    y = sympy.Symbol("y")
    inner = _line(border.inner, 0.0, speed, y)  # its limit is on the diagonal up to rounding
    outer = _line(border.outer, border.outer.value - border.x, speed, y)
    left, right = (inner, outer) if border.side > 0 else (outer, inner)
    return PiecewiseLinearMap([(left, y < 0), (right, y >= 0)], y)


def _line(image: Image, gap: float, speed: float, y: sympy.Symbol) -> sympy.Expr:
    """A piece to first order in y and q; ``gap`` is its limit at the jump minus x_d."""
    # y' = P(x_d + y, p) - x_d(p), which at y = 0 changes with q at the rate P_p + (P_x - 1) x_d'.
    along = image.d_parameter + (image.slope - 1.0) * speed
    slope, gap, along = (sympy.Rational(float(each)) for each in (image.slope, gap, along))
    return slope * y + gap + along * Q


def _starts(found: Diagram, point: SpecialPoint, speed: float) -> Iterator[Start]:
    for side, names in zip((-1, 1), found.sides(point.id), strict=True):
        for branch in map(found.branch, names):
            stretch = branch.words[0 if branch.ends[0] == point.id else -1]
            slope = float(sympy.diff(stretch.exact["x"], Q).subs(Q, 0)) + speed
            yield Start(
                kind=branch.kind, order=branch.order, word=stretch.word, side=side, slope=slope
            )


def _is_local(word: str, inner: str) -> bool:
    """Whether one limit visits the inner side only, and the other leaves it at its last point."""
    words = word.split("|")
    return any(set(each) == {inner} for each in words) and all(
        set(each[:-1]) <= {inner} for each in words
    )
