"""Proof of a border collision at a jump: the point, both words and one-sided limits, its code.

At such a point two gaps close at once. Each of the two ways is a smooth map on both sides of the
border, and the sign of a comparator c(x, p) says which one the toy takes. The point solves
P_w(x, p) = x, c(x, p) = 0, and Krawczyk's operator encloses it.

Let sigma = +-1 be the side of the border on which the fixed point's way w is taken, s its slope
there, h the other limit minus the point, and mu(p) the limit of w minus the border, which moves
with p. The fixed point exists where sigma mu / (1 - s) > 0, and a jump crosses the diagonal where
mu h < 0. As mu passes zero, the point is a fold if both hold on the same side in p, otherwise a
persistence. A fold with |s| > 1 starts a jump branch of the second iterate as well: it is a
fold-flip.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from flint import arb, arb_mat

from woodpecker.enclosures.balls import decimal, number
from woodpecker.enclosures.following import follow
from woodpecker.enclosures.forms import Form, P, S, sign
from woodpecker.enclosures.model import BallToy
from woodpecker.enclosures.motions import Way
from woodpecker.enclosures.not_proved import NotProved
from woodpecker.enclosures.taylor import Frame
from woodpecker.mechanics.toy import Toy
from woodpecker.proofs.certificates import Content, head, interval, text, way_of

FIRST, SHRINK, LAST = Fraction(1, 10**11), 10**6, Fraction(1, 10**25)  # radii of the boxes: first,
# divisor from one to the next, last
DECIMALS = 40  # of the centre of a box


def proved_point(toy: Toy, parameter: str, p: float, x: float, digits: int) -> Content:
    """Content for a border collision at a jump where two gaps close at once; or NotProved."""
    at_p, at_x, radius = Fraction(p), Fraction(x), FIRST
    while True:  # each step centres the box anew and shrinks it, down to the last radius
        ways = _both(toy, parameter, at_p, at_x, radius)
        border = ways[0].forks[0].comparator
        own = min((0, 1), key=lambda k: abs(float(ways[k].image.mid) - float(at_x)))
        moved_x, moved_p = _krawczyk(ways[own].image, border, at_x, radius)
        if radius == LAST:
            break
        at_x = decimal(number(at_x) + moved_x, DECIMALS)
        at_p = decimal(number(at_p) + moved_p, DECIMALS)
        radius = max(radius / SHRINK, LAST)
    if not (abs(moved_x) < number(radius) and abs(moved_p) < number(radius)):
        raise NotProved("the point could not be enclosed")
    found_x, found_p = number(at_x) + moved_x, number(at_p) + moved_p
    centre = {"x": text(at_x), "p": text(at_p), "radius": text(radius)}
    content = _content(found_x, found_p, ways, own, border)
    return head(toy, "point", parameter, 1, digits) | {"centre": centre} | content


def _both(toy: Toy, parameter: str, p: Fraction, x: Fraction, radius: Fraction) -> tuple[Way, Way]:
    ball = arb(0, number(radius).upper())
    frame = Frame(ball, ball, terms=2, depth=3)
    model = BallToy(toy, parameter, frame, [number(p), arb(1)])
    found = follow(model, frame, [number(x)])
    if len(found) != 2 or not found[0].forks[0].jumps:
        raise NotProved("no two gaps close at once here")
    return found[0], found[1]


def _krawczyk(image: Form, border: Form, x: Fraction, radius: Fraction) -> tuple[Any, Any]:
    """Balls about the box's centre that hold every solution of image = x, border = 0 in the box."""
    # With f = (image - x - s, border) Krawczyk's operator is -C f(0) + (1 - C f') box, where C is
    # an approximate inverse of f' at the centre.
    f = arb_mat([[image.mid - number(x)], [border.mid]])
    jacobian = arb_mat([
        [image.parts[S].box - 1, image.parts[P].box],
        [border.parts[S].box, border.parts[P].box],
    ])  # fmt: skip
    try:
        inverse = jacobian.mid().inv()
    except ZeroDivisionError:
        raise NotProved("the point may be degenerate") from None
    ball, one = arb(0, number(radius).upper()), arb_mat(2, 2, [1, 0, 0, 1])
    found = (one - inverse * jacobian) * arb_mat([[ball], [ball]]) - inverse * f
    return found[0, 0], found[1, 0]


def _content(
    found_x: Any, found_p: Any, ways: tuple[Way, Way], own: int, border: Form
) -> dict[str, Any]:
    """The entries of a point: ways, place, the other limit, slopes and code."""
    image, limit = ways[own].image, ways[1 - own].image.box
    along = sign(border.parts[S].box)
    if not along:
        raise NotProved("the border may turn")
    side = along if own == 0 else -along  # sigma: 1 if its own way is taken at larger x
    slope = image.parts[S].box
    moves = -border.parts[P].box / border.parts[S].box  # dx/dp of the border
    speed = slope * moves + image.parts[P].box - moves  # dmu/dp
    gap = sign(limit - found_x)
    stays, steep = sign(1 - slope), sign(abs(slope) - 1)
    if not (sign(speed) and gap and stays and steep):
        raise NotProved("the kind of the point is open")
    fold = side * stays == -gap
    return {
        "ways": [way_of(way) for way in ways],
        "own": own,
        "x": interval(found_x),
        "p": interval(found_p),
        "limit": interval(limit),
        "slopes": [interval(way.image.parts[S].box) for way in ways],
        "side": side,
        "code": "FF" if fold and steep == 1 else "BC",
        "note": "fold" if fold else "persistence",
    }
