"""Contents of certificates: proofs as JSON that :mod:`woodpecker.checking` verifies on its own.

They hold boxes, the guards that fire with brackets of the durations, and claims; numbers are text.
"""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Context, Decimal, Inexact
from fractions import Fraction
from typing import Any

from woodpecker.enclosures.balls import fraction
from woodpecker.enclosures.model import data
from woodpecker.enclosures.motions import Way
from woodpecker.mechanics.toy import LAW, Toy
from woodpecker.proofs.branches import TERMS, ProvedBranch
from woodpecker.proofs.pieces import Tubes

FORMAT = "certificate of the Woodpecker Toy"
VERSION = 1
Content = dict[str, Any]  # a JSON object, without statement and seal
SLACK = Fraction(1, 10)  # of its width is added to an enclosure on each side, since the checker's
# arithmetic rounds differently
EXACT = Context(prec=400, traps=[Inexact])  # the checker reads numbers of up to 400 characters


def text(x: Fraction) -> str:
    """A rational number as text: a decimal if that is exact, else a quotient."""
    try:
        return f"{EXACT.divide(Decimal(x.numerator), Decimal(x.denominator)):f}"
    except Inexact:
        return f"{x.numerator}/{x.denominator}"


def interval(ball: Any, slack: Fraction = SLACK) -> list[str]:
    """Decimal ends of an interval that holds a ball and some slack, rounded outwards."""
    low, high = fraction(ball.lower()), fraction(ball.upper())
    more = (high - low) * slack + Fraction(1, 10**30)
    low, high = low - more, high + more
    unit = Fraction(1)
    while unit > (high - low) / 50:  # 1e-30 above makes the width positive
        unit /= 10
    return [text(low // unit * unit), text(-(-high // unit) * unit)]


def head(toy: Toy, kind: str, parameter: str, order: int, digits: int) -> Content:
    """The entries that all certificates share; the parameter is null where it varies."""
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
    """The word of a way, and the guards that fire along it with brackets of the durations."""
    events = [[fired.name, *interval(fired.bracket, Fraction(0))] for fired in way.log]
    return {"word": way.word, "events": events}


def piece_of(piece: Tubes) -> dict[str, Any]:
    """A piece: its line of the parameter, its tubes and their ways."""
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


def of_orbit(toy: Toy, parameter: str, outer: Tubes, inner: Tubes, digits: int) -> Content:
    """Content for an orbit: exactly one cycle in the outer tubes, and it lies in the inner ones."""
    order = len(inner.tubes)
    return head(toy, "orbit", parameter, order, digits) | {
        "outer": piece_of(outer),
        "inner": piece_of(inner),
        "multiplier": interval(inner.multiplier),
        "period": interval(inner.period),
        "drop": interval(inner.drop),
        "stable": _stability(interval(inner.multiplier)),
    }


def _claim(piece: Tubes) -> list[str]:
    """Bounds of the multiplier, with as much slack as keeps them from reaching -1 or 1."""
    for slack in (Fraction(1, 2), Fraction(1, 5), SLACK, Fraction(0)):
        claim = interval(piece.multiplier, slack)
        low, high = (Fraction(x) for x in claim)
        if all(high < at or low > at for at in (-1, 1)):
            break
    return claim


def _stability(claim: Sequence[str]) -> bool | None:
    """Whether all multipliers in an interval are stable, or none is; None if that is open."""
    low, high = (Fraction(x) for x in claim)
    if low > -1 and high < 1:
        return True
    return False if low > 1 or high < -1 else None


def of_branch(branch: ProvedBranch, digits: int) -> Content:
    """Content for a branch: exactly one cycle in each piece's tubes, and the flips."""
    pieces, claims = branch.pieces, [_claim(piece) for piece in branch.pieces]
    return head(branch.toy, "branch", branch.parameter, len(pieces[0].tubes), digits) | {
        "terms": TERMS,
        "pieces": [piece_of(piece) for piece in pieces],
        "multiplier": claims,
        "stable": [_stability(claim) for claim in claims],
        "flips": [k for k, piece in enumerate(pieces) if piece.turn is not None],
        "gaps": [[text(end) for end in gap] for gap in branch.gaps],
        "span": [text(end) for end in branch.span],
    }


def merged(parts: Sequence[Content]) -> Content:
    """The content of one branch from those of parts that join."""
    found = parts[0]
    for part in parts[1:]:
        shift = len(found["pieces"])
        joined = {
            key: [*found[key], *part[key]] for key in ("pieces", "multiplier", "stable", "gaps")
        }
        flips = [*found["flips"], *(k + shift for k in part["flips"])]
        found = found | joined | {"flips": flips, "span": [found["span"][0], part["span"][1]]}
    return found
