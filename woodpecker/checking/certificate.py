"""Verification of the toy's certificates: :func:`check`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from itertools import pairwise
from operator import gt
from typing import Any

from pwmap.checking import Refused
from pwmap.checking.certificate import seal_of
from woodpecker.checking.forms import F
from woodpecker.checking.intervals import Box, I, NotSeparated, unit
from woodpecker.checking.pieces import (
    ToyData,
    VerifiedPiece,
    WrittenPiece,
    WrittenWay,
    check_both,
    claimed,
    hull,
    verified,
)
from woodpecker.checking.reading import Interval, interval, number, whole
from woodpecker.checking.sentences import statement_of

FORMAT, VERSION = "certificate of the Woodpecker Toy", 1
LONGEST = 50_000_000  # largest file that is read, in bytes
MALFORMED = (  # errors that arise when something other than a certificate is read
    ArithmeticError, AttributeError, IndexError, KeyError, MemoryError, RecursionError, TypeError,
    ValueError,
)  # fmt: skip


def check(content: Any) -> str:
    """The verified statement of a certificate's content; Refused if it does not hold."""
    try:
        return _checked(content)
    except NotSeparated as error:
        raise Refused(f"the certificate does not hold: {error}") from None
    except Refused:
        raise
    except MALFORMED as error:
        raise Refused(f"the certificate is not made as one is: {error!a:.200}") from None


def _checked(content: Any) -> str:
    if not isinstance(content, dict):
        raise Refused("a certificate is an object with named entries")
    if content.get("format") != FORMAT:
        raise Refused(f"the format must be {FORMAT!r}")
    whole("version", content.get("version"), 1, VERSION)
    if content.get("seal") != seal_of(content):
        raise Refused("the seal is broken: something was changed after the proof was written")
    kind = content.get("kind")
    if not isinstance(kind, str) or kind not in KINDS:
        raise Refused(f"kind must be one of {', '.join(KINDS)}, got {kind!a:.60}")
    verify, names = KINDS[kind]
    if set(content) != ENTRIES | names:
        raise Refused("the certificate has other entries than its kind needs")
    digits = whole("digits", content["digits"], 20, 200)
    with unit(int(digits * 3.33) + 30):
        data, statement = ToyData(content), statement_of(content)
        if statement != content["statement"]:
            raise Refused("the statement is another one than the claims make")
        verify(content, data)
    return statement


def _stable(multiplier: I) -> bool | None:
    if multiplier.size.less(I.of(1)):
        return True
    beyond = (multiplier - I.of(1)).sign() == 1 or (multiplier + I.of(1)).sign() == -1
    return False if beyond else None


def _orbit(content: Mapping[str, Any], data: ToyData) -> None:
    boxes = [WrittenPiece(data, content[name]) for name in ("outer", "inner")]
    outer, inner = (VerifiedPiece(data, box, 1, False) for box in boxes)
    if inner.curves != outer.curves or any(map(gt, inner.radii, outer.radii)):
        raise Refused("the inner box does not lie in the middle of the outer one")
    claimed("the multiplier", inner.multiplier, content["multiplier"])
    period, drop = I.of(0), I.of(0)
    for ways in inner.returns:
        period = period + hull([way.time.value for way in ways])
        drop = drop + hull([(-way.q[0]).value for way in ways])
    claimed("the period", period, content["period"])
    claimed("the drop", drop, content["drop"])
    if content["stable"] is not _stable(I.of(*interval(content["multiplier"]))):
        raise Refused("stability is another one than the multiplier says")


def _branch(content: Mapping[str, Any], data: ToyData) -> None:
    # Whether the claims are consistent is checked first, since the proof takes minutes.
    terms = whole("terms", content["terms"], 1, 30)
    flips, texts = content["flips"], content["pieces"]
    if not texts or not len(texts) == len(content["multiplier"]) == len(content["stable"]):
        raise Refused("each piece has a multiplier and a claim on stability")
    places = [k for k in range(len(texts)) if k in flips]
    if not isinstance(flips, list) or flips != places or any(type(k) is not int for k in flips):
        raise Refused("flips are numbers of pieces, each once, in ascending order")
    pieces = [WrittenPiece(data, text) for text in texts]
    joints = _covered(pieces, content)
    claims = [interval(pair) for pair in content["multiplier"]]
    sides = [0 if k in flips else _side(claim) for k, claim in enumerate(claims)]
    _flips_pass(sides, joints)
    told = zip(content["stable"], claims, strict=True)
    if any(stable is not _stable(I.of(*claim)) for stable, claim in told):
        raise Refused("stability is another one than the multiplier says")
    before: VerifiedPiece | None = None
    for k, (piece, claim) in enumerate(zip(pieces, claims, strict=True)):
        parts = verified(data, piece, terms, k in flips, claim)
        multiplier = hull([part.multiplier for part in parts])
        claimed(f"the multiplier of piece {k}", multiplier, content["multiplier"][k])
        if k in flips and not hull([part.turn for part in parts if part.turn is not None]).sign():
            raise NotSeparated("the multiplier may not be monotone at a flip")
        if k not in flips:  # the verified range may be narrower than the claim, and decide more
            side = (multiplier + I.of(1)).sign()
            if not side:
                raise NotSeparated("the multiplier may pass -1 outside the flips")
            sides[k] = side
        if before is not None and joints[k - 1]:
            _joined(before, parts[0], data.order)
        before = parts[-1]
    _flips_pass(sides, joints)


def _covered(pieces: Sequence[WrittenPiece], content: Mapping[str, Any]) -> list[bool]:
    """For each piece whether it joins the next; Refused unless pieces and gaps cover the span."""
    gaps, joints = [interval(gap) for gap in content["gaps"]], list[bool]()
    for before, piece in pairwise(pieces):
        ends = before.parameter(1), piece.parameter(-1)
        joints.append(ends[0] == ends[1])
        if not joints[-1] and (not gaps or gaps.pop(0) != ends):
            raise Refused("pieces do not join, and no gap says so")
    if gaps:
        raise Refused("a gap lies between no pieces")
    if interval(content["span"]) != (pieces[0].parameter(-1), pieces[-1].parameter(1)):
        raise Refused("the pieces do not cover the span")
    return joints


def _side(claim: Interval) -> int | None:
    """The side of -1 on which a claimed multiplier lies, 1 or -1; None if the claim is open."""
    return 1 if claim[0] > -1 else -1 if claim[1] < -1 else None


def _joined(before: VerifiedPiece, piece: VerifiedPiece, order: int) -> None:
    """NotSeparated unless, where two pieces meet, one's cycle lies in the tubes of the other."""
    for outer, a, inner, b in ((before, 1, piece, -1), (piece, -1, before, 1)):
        places = [(outer.place(a, k)[0], inner.place(b, k)[1]) for k in range(order)]
        if all(low < x and y < high for (low, high), (x, y) in places):
            return
    raise NotSeparated("two pieces may hold different cycles where they meet")


def _flips_pass(sides: Sequence[int | None], joints: Sequence[bool]) -> None:
    """NotSeparated unless the multiplier passes -1 at the claimed flips, and only there.

    ``sides`` are 0 at flips, and None where they are still unknown: then the known ones decide.
    """
    for k, joins in enumerate(joints):
        if joins and -1 in sides[k : k + 2] and 1 in sides[k : k + 2]:
            raise NotSeparated("the multiplier passes -1 between two pieces")
    for k, side in enumerate(sides):
        inside = 0 < k < len(sides) - 1 and joints[k - 1] and joints[k]
        around = [sides[k - 1], sides[k + 1]] if inside else []
        passes = -1 in around and 1 in around
        if side == 0 and not passes and None not in around:
            raise NotSeparated("the multiplier does not pass -1 where a flip is claimed")
        if side is None and passes:
            raise NotSeparated("the multiplier passes -1 outside the flips")


def _point(content: Mapping[str, Any], data: ToyData) -> None:
    centre, ways, own = content["centre"], content["ways"], whole("own", content["own"], 0, 1)
    if set(centre) != {"x", "p", "radius"} or len(ways) != 2 or data.order != 1:
        raise Refused("a point has a centre, two ways and says which one is its own")
    x, p, radius = number(centre["x"]), number(centre["p"]), number(centre["radius"])
    if radius <= 0:
        raise Refused("a box has a positive radius")
    box = Box(radius, 2, radius, 3)
    returns = [data.returned(box, [p, Fraction(1)], [x], WrittenWay(way)) for way in ways]
    check_both(returns, ("meeting",))
    image, border = returns[own].q[2], returns[0].forks[0].comparator
    moved = _krawczyk(image, border, x, radius)
    found_x, found_p = I.of(x) + moved[0], I.of(p) + moved[1]
    claimed("phi_S", found_x, content["x"])
    claimed("the parameter", found_p, content["p"])
    limit = returns[1 - own].q[2].value
    claimed("the other limit", limit, content["limit"])
    for k in range(2):
        claimed("a slope", returns[k].q[2].part((1, 0)), content["slopes"][k])
    along = border.part((1, 0)).sign()
    slope = image.part((1, 0))
    moves = -(border.part((0, 1)) / border.part((1, 0)))
    speed = slope * moves + image.part((0, 1)) - moves
    gap, stays = (limit - found_x).sign(), (I.of(1) - slope).sign()
    steep = -1 if slope.size.less(I.of(1)) else (1 if _stable(slope) is False else 0)
    if not (along and gap and stays and steep and speed.sign()):
        raise NotSeparated("the kind of the point is open")
    side = along if own == 0 else -along
    fold = side * stays == -gap
    code, note = ("FF" if fold and steep == 1 else "BC"), ("fold" if fold else "persistence")
    told = whole("side", content["side"], -1, 1), content["code"], content["note"]
    if told != (side, code, note):
        raise Refused(f"the point is {code}, {note}, on side {side}")


def _krawczyk(image: F, border: F, x: Fraction, radius: Fraction) -> tuple[I, I]:
    """The only solution of image = x, border = 0 in a box, relative to its centre, enclosed."""
    first = [f.parts[0].first + I(-f.parts[0].rest, f.parts[0].rest) for f in (image, border)]
    first[0] = first[0] - I.of(x)
    jacobian = [
        [image.part((1, 0)) - I.of(1), image.part((0, 1))],
        [border.part((1, 0)), border.part((0, 1))],
    ]
    (a, b), (c, d) = ([entry.mid for entry in row] for row in jacobian)
    determinant = (a * d - b * c).mid
    inverse = [[d / determinant, -(b / determinant)], [-(c / determinant), a / determinant]]
    ball, found = I.of(radius).ball, []
    for i in range(2):
        total = -(inverse[i][0] * first[0] + inverse[i][1] * first[1])
        for j in range(2):
            rest = I.of(1) if i == j else I.of(0)
            for k in range(2):
                rest = rest - inverse[i][k] * jacobian[k][j]
            total = total + rest * ball
        if not total.within(ball):
            raise NotSeparated("the point could not be shown to lie in the box")
        found.append(total)
    return found[0], found[1]


ENTRIES = {
    "format", "version", "kind", "statement", "digits", "toy", "law", "parameter", "order", "seal",
}  # fmt: skip
KINDS: dict[str, tuple[Callable[[Mapping[str, Any], ToyData], None], set[str]]] = {
    "orbit": (_orbit, {"outer", "inner", "multiplier", "period", "drop", "stable"}),
    "branch": (_branch, {"terms", "pieces", "multiplier", "stable", "flips", "gaps", "span"}),
    "point": (
        _point, {"centre", "ways", "own", "x", "p", "limit", "slopes", "side", "code", "note"}
    ),
}  # fmt: skip
