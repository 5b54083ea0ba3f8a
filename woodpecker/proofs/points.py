"""Border collisions at jumps, proved: the point, both one-sided words and limits, and the code.

At a point like A a fixed point of P_1 meets a jump: two gaps close at once there. Both ways exist
beyond their own sides as smooth maps, and a comparator c(x, p) says which one the toy takes. So the
point is a zero of two equations, P_w(x, p) = x and c(x, p) = 0, enclosed by Krawczyk's operator.

Let sigma say on which side of the border the way w of the fixed point is taken, s be its slope
there, h how far the other limit is from the point, and mu(p) how far the limit of w is from the
border, as it moves with p. The fixed point exists where sigma mu / (1 - s) > 0, and a jump crosses
the diagonal where mu h < 0; as mu passes zero with a speed, both signs decide: a fold if these are
the same side of p, persistence if not. A fold with |s| > 1 starts a jump branch of the second
iterate as well, and is a fold-flip.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from flint import arb

from woodpecker.enclosures.balls import decimal, number
from woodpecker.enclosures.following import follow
from woodpecker.enclosures.forms import Form, P, S, sign
from woodpecker.enclosures.model import BallToy
from woodpecker.enclosures.motions import ForkKind, OpenDecision, Way
from woodpecker.enclosures.not_proved import NotProved
from woodpecker.enclosures.taylor import Frame
from woodpecker.mechanics.toy import Toy

FIRST, SHRINK, LAST = Fraction(1, 10**11), 10**6, Fraction(1, 10**25)  # radii of the boxes
DECIMALS = 40


@dataclass(frozen=True)
class ProvedPoint:
    """A border collision of fixed points at a jump."""

    toy: Toy
    parameter: str
    # the centre of a box and its half width in both directions: it holds the only point at
    # which the fixed point of one way lies on the border
    x: Fraction
    p: Fraction
    radius: Fraction
    ways: tuple[Way, Way]  # the way where the comparator is positive, and the other one
    own: int  # index of the way whose fixed point it is
    found_x: Any  # balls that hold the point
    found_p: Any
    limit: Any  # range of the other way's image: the limit from the other side
    slopes: tuple[Any, Any]  # ranges of the slopes of both ways
    side: int  # 1 if its own way is taken for larger x, -1 if for smaller ones
    code: str  # ``"FF"`` or ``"BC"``, ``"fold"`` or ``"persistence"``
    note: str


def proved_point(toy: Toy, parameter: str, p: float, x: float) -> ProvedPoint:
    """Prove a border collision near a place.

    Raises
    ------
    NotProved
        If it is none at a jump where two gaps close at once, or something could not be shown.
    """
    at_p, at_x, radius = Fraction(p), Fraction(x), FIRST
    while True:  # the box shrinks to the last one in a few steps
        ways, fork = _both(toy, parameter, at_p, at_x, radius)
        own = min((0, 1), key=lambda k: abs(float(ways[k].image.mid) - float(at_x)))
        moved_x, moved_p = _krawczyk(ways[own].image, fork.comparator, at_x, radius)
        if radius == LAST:
            break
        at_x = decimal(number(at_x) + moved_x, DECIMALS)
        at_p = decimal(number(at_p) + moved_p, DECIMALS)
        radius = max(radius / SHRINK, LAST)
    if not (abs(moved_x) < number(radius) and abs(moved_p) < number(radius)):
        raise NotProved("the point could not be enclosed")
    return _classified(toy, parameter, at_x, at_p, radius, ways, own, fork, (moved_x, moved_p))


def _both(
    toy: Toy, parameter: str, p: Fraction, x: Fraction, radius: Fraction
) -> tuple[tuple[Way, Way], OpenDecision]:
    """Both ways over a box, with derivatives in both directions."""
    ball = arb(0, number(radius).upper())
    frame = Frame(ball, ball, terms=2, depth=3)
    model = BallToy.of(toy, parameter, frame, [number(p), arb(1)])
    found = follow(model, frame, [number(x)])
    if len(found) != 2 or found[0].forks[0][0].kind is not ForkKind.MEETING:
        raise NotProved("no two gaps close at once here")
    return (found[0], found[1]), found[0].forks[0][0]


def _krawczyk(image: Form, border: Form, x: Fraction, radius: Fraction) -> tuple[Any, Any]:
    """Where in the box image = x and border = 0 may hold, as balls about its centre.

    With f = (image - x - s, border) the operator is -C f(0) + (1 - C f') box, where C is near the
    inverse of f' at the centre.
    """
    f = [image.mid - number(x), border.mid]
    jacobian = [
        [image.parts[S].box - 1, image.parts[P].box],
        [border.parts[S].box, border.parts[P].box],
    ]
    (a, b), (c, d) = ([entry.mid() for entry in row] for row in jacobian)
    determinant = a * d - b * c
    if determinant.contains(0):
        raise NotProved("the point may be degenerate")
    inverse = [[d / determinant, -b / determinant], [-c / determinant, a / determinant]]
    ball = arb(0, number(radius).upper())
    found = []
    for i in range(2):
        total = -(inverse[i][0] * f[0] + inverse[i][1] * f[1])
        for j in range(2):
            rest = arb(int(i == j)) - sum(
                (inverse[i][k] * jacobian[k][j] for k in range(2)), arb(0)
            )
            total = total + rest * ball
        found.append(total)
    return found[0], found[1]


def _classified(
    toy: Toy, parameter: str, x: Fraction, p: Fraction, radius: Fraction,
    ways: tuple[Way, Way], own: int, fork: OpenDecision, moved: tuple[Any, Any],
) -> ProvedPoint:  # fmt: skip
    found_x, found_p = number(x) + moved[0], number(p) + moved[1]
    border, image, limit = fork.comparator, ways[own].image, ways[1 - own].image.box
    along = sign(border.parts[S].box)
    if not along:
        raise NotProved("the border may turn")
    side = along if own == 0 else -along
    slope = image.parts[S].box
    moves = -border.parts[P].box / border.parts[S].box  # of the border in p
    speed = slope * moves + image.parts[P].box - moves
    gap = sign(limit - found_x)
    stays, steep = sign(1 - slope), sign(abs(slope) - 1)
    if not (sign(speed) and gap and stays and steep):
        raise NotProved("the kind of the point is open")
    fold = side * stays == -gap
    slopes = tuple(way.image.parts[S].box for way in ways)
    return ProvedPoint(
        toy, parameter, x, p, radius, ways, own, found_x, found_p, limit,
        (slopes[0], slopes[1]), side, "FF" if fold and steep == 1 else "BC",
        "fold" if fold else "persistence",
    )  # fmt: skip
