"""Certificates: what is proved, as JSON that :mod:`woodpecker.checking` verifies from scratch.

They hold boxes, the guards that fire in turn with brackets of the durations, and claims. All
numbers are text: exact decimals or quotients.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from decimal import ROUND_CEILING, Context, Decimal
from fractions import Fraction
from typing import Any

from pwmap.proofs.document import Certificate
from woodpecker.enclosures.balls import fraction
from woodpecker.enclosures.model import data
from woodpecker.enclosures.motions import Way
from woodpecker.mechanics.toy import LAW, Toy
from woodpecker.proofs.branches import TERMS, ProvedBranch
from woodpecker.proofs.pieces import Tubes

FORMAT = "certificate of the Woodpecker Toy"
VERSION = 1
SLACK = Fraction(1, 10)  # by which claims are wider: other arithmetic rounds otherwise


def sealed(content: Mapping[str, Any]) -> Certificate:
    """A certificate with its seal: the digest of all else, which shows accidents."""
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=True)
    return Certificate({**content, "seal": hashlib.sha256(text.encode("ascii")).hexdigest()})


def text(x: Fraction) -> str:
    """A rational number as a decimal if it is one, else as a quotient."""
    twos, fives, rest = 0, 0, x.denominator
    while rest % 2 == 0:
        rest, twos = rest // 2, twos + 1
    while rest % 5 == 0:
        rest, fives = rest // 5, fives + 1
    if rest != 1:
        return f"{x.numerator}/{x.denominator}"
    places = max(twos, fives)
    digits = str(abs(x.numerator) * 10**places // x.denominator).rjust(places + 1, "0")
    sign = "-" if x < 0 else ""
    return sign + (f"{digits[:-places]}.{digits[-places:]}" if places else digits)


def interval(ball: Any, slack: Fraction = SLACK) -> list[str]:
    """Decimal ends of an interval that holds a ball, and a little more."""
    low, high = fraction(ball.lower()), fraction(ball.upper())
    more = (high - low) * slack + Fraction(1, 10**30)
    low, high = low - more, high + more
    unit = Fraction(1)
    while unit > (high - low) / 50:  # which is positive
        unit /= 10
    return [text(low // unit * unit), text(-(-high // unit) * unit)]


def head(toy: Toy, kind: str, parameter: str, order: int, digits: int) -> dict[str, Any]:
    """What all certificates begin with; the entry of a parameter that moves is null."""
    values: dict[str, str | None] = {name: text(x) for name, x in data(toy).items()}
    if kind != "orbit":
        values[parameter] = None
    return {
        "format": FORMAT,
        "version": VERSION,
        "kind": kind,
        "digits": digits,
        "toy": values,
        "law": str(getattr(toy, LAW).value),
        "parameter": parameter,
        "order": order,
    }


def way_of(way: Way) -> dict[str, Any]:
    """The word of a way, and the guards that fire with brackets of durations."""
    events = [[fired.name, *interval(fired.bracket, Fraction(0))] for fired in way.fired]
    return {"word": way.word, "events": events}


def piece_of(piece: Tubes) -> dict[str, Any]:
    """A piece: how the parameter runs, and the tubes."""
    points = [
        {
            "curve": [text(c) for c in tube.curve],
            "radius": text(tube.radius),
            "ways": [way_of(way) for way in ways],
        }
        for tube, ways in zip(piece.tubes, piece.ways, strict=True)
    ]
    return {
        "line": [text(c) for c in piece.line.poly],
        "half": text(piece.line.half),
        "points": points,
    }


def of_orbit(toy: Toy, parameter: str, outer: Tubes, inner: Tubes, digits: int) -> Certificate:
    """Exactly one cycle in the outer tubes, which lies in the inner ones."""
    order = len(inner.tubes)
    content = head(toy, "orbit", parameter, order, digits) | {
        "outer": piece_of(outer),
        "inner": piece_of(inner),
        "multiplier": interval(inner.multiplier),
        "period": interval(inner.period),
        "drop": interval(inner.drop),
        "stable": _stability(interval(inner.multiplier)),
    }
    return sealed({"statement": orbit_sentence(content), **content})


def _claim(piece: Tubes) -> list[str]:
    """The multiplier of a piece with room for other arithmetic, but on its side of -1 and 1."""
    for slack in (Fraction(1, 2), Fraction(1, 5), SLACK, Fraction(0)):
        claim = interval(piece.multiplier, slack)
        low, high = (Fraction(x) for x in claim)
        if all(high < at or low > at for at in (-1, 1)):
            break
    return claim


def _stability(claim: Sequence[str]) -> bool | None:
    """Whether a multiplier in an interval is below or above one in modulus."""
    low, high = (Fraction(x) for x in claim)
    if low > -1 and high < 1:
        return True
    return False if low > 1 or high < -1 else None


def orbit_sentence(content: Mapping[str, Any]) -> str:
    """The sentence of an orbit."""
    order, inner, outer = content["order"], content["inner"], content["outer"]
    where = ", ".join(f"{p['curve'][0]} within {p['radius']}" for p in inner["points"])
    what = "fixed point" if order == 1 else f"cycle of {order} points"
    radius = ", ".join(p["radius"] for p in outer["points"])
    words = " | ".join(" or ".join(way["word"] for way in p["ways"]) for p in inner["points"])
    stable = {True: "it is stable", False: "it is unstable", None: "its stability is open"}
    parameter = content["parameter"]
    return (
        f"{_toy(content)} {parameter} = {content['toy'][parameter]} has exactly one {what} of the "
        f"return map with phi_S at most {radius} from these places: {where}. Its word is {words}, "
        f"its multiplier lies in {_span(content['multiplier'])}, so {stable[content['stable']]}; "
        f"its period lies in {_span(content['period'])} s, its drop in {_span(content['drop'])} m."
    )


def _toy(content: Mapping[str, Any]) -> str:
    """The toy, with the numbers that are not the paper's; the parameter is named apart."""
    paper, other = {name: text(x) for name, x in data(Toy()).items()}, content["parameter"]
    numbers = [f"{k} = {x}" for k, x in content["toy"].items() if k != other and x != paper[k]]
    law = "; ".join([f"expansion friction {content['law']}", *numbers])
    return f"The Woodpecker Toy ({law}) with"


def _span(ends: Sequence[str]) -> str:
    return f"[{ends[0]}, {ends[1]}]"


def of_branch(branch: ProvedBranch, digits: int) -> Certificate:
    """One cycle for each value of a parameter, and how often its multiplier passes -1."""
    pieces = branch.pieces
    content = head(branch.toy, "branch", branch.parameter, len(pieces[0].tubes), digits) | {
        "terms": TERMS,
        "pieces": [piece_of(piece) for piece in pieces],
        "multiplier": [_claim(piece) for piece in pieces],
        "stable": [_stability(_claim(piece)) for piece in pieces],
        "flips": list(branch.flips),
        "gaps": [[text(end) for end in gap] for gap in branch.gaps],
    }
    content["span"] = [text(end) for end in branch.span]
    return sealed({"statement": branch_sentence(content), **content})


def merged(parts: Sequence[Certificate]) -> Certificate:
    """One certificate of a branch from those of its parts, which join."""
    first = dict(parts[0].content)
    for part in parts[1:]:
        shift = len(first["pieces"])
        for key in ("pieces", "multiplier", "stable", "gaps"):
            first[key] = [*first[key], *part.content[key]]
        first["flips"] = [*first["flips"], *(k + shift for k in part.content["flips"])]
        first["span"] = [first["span"][0], part.content["span"][1]]
    content = {key: value for key, value in first.items() if key not in ("seal", "statement")}
    return sealed({"statement": branch_sentence(content), **content})


def branch_sentence(content: Mapping[str, Any]) -> str:
    """The sentence of a branch."""
    order, parameter, gaps = content["order"], content["parameter"], content["gaps"]
    what = "one fixed point" if order == 1 else f"one cycle of {order} points"
    together = "one branch, for the tubes join, without a gap"
    if gaps:
        total = sum((Fraction(high) - Fraction(low) for low, high in gaps), Fraction(0))
        together = (
            f"{len(gaps) + 1} stretches of tubes that join, and between them {len(gaps)} "
            f"interval{'s' if len(gaps) > 1 else ''}, of a total length of at most "
            f"{_above(total)}, in which nothing is said, nor whether the stretches belong together"
        )
    flips = len(content["flips"])
    count = {0: "no flip", 1: "exactly one flip"}.get(flips, f"exactly {flips} flips")
    return (
        f"{_toy(content)} {parameter} in {_span(content['span'])} has, in each of "
        f"{len(content['pieces'])} tubes, exactly {what} of the return map for each value: "
        f"{together}, with {count}."
    )


def _above(x: Fraction) -> str:
    """Two digits of a number, rounded up."""
    up = Context(prec=2, rounding=ROUND_CEILING)
    return str(up.divide(Decimal(x.numerator), Decimal(x.denominator)))


def of_point(toy: Toy, parameter: str, point: dict[str, Any], digits: int) -> Certificate:
    """A border collision at a jump."""
    content = head(toy, "point", parameter, 1, digits) | point
    return sealed({"statement": point_sentence(content), **content})


def point_sentence(content: Mapping[str, Any]) -> str:
    """The sentence of a point."""
    own, other = content["ways"][content["own"]], content["ways"][1 - content["own"]]
    side = "above" if content["side"] > 0 else "below"
    name = {"FF": "fold-flip", "BC": "border collision"}[content["code"]]
    return (
        f"{_toy(content)} {content['parameter']} in {_span(content['p'])} has a {name} "
        f"({content['code']}, {content['note']}) at phi_S in {_span(content['x'])}: the fixed "
        f"point of the word {own['word']}, which is taken {side} the border, meets the jump to the "
        f"word {other['word']}, whose limit lies in {_span(content['limit'])}; the slopes there "
        f"lie in {_span(content['slopes'][content['own']])} and "
        f"{_span(content['slopes'][1 - content['own']])}."
    )
