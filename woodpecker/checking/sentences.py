"""The statement of a certificate in words, composed from its content."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from decimal import ROUND_CEILING, Context, Decimal
from fractions import Fraction
from typing import Any

from woodpecker.checking.reading import number
from woodpecker.checking.toy import PAPER

Content = Mapping[str, Any]


def statement_of(content: Content) -> str:
    """The statement of a certificate's content."""
    others = [
        f"{name} = {content['toy'][name]}"
        for name, value in PAPER.items()
        if name != content["parameter"] and number(content["toy"][name]) != value
    ]
    law = "; ".join([f"expansion friction {content['law']}", *others])
    say = {"orbit": _of_orbit, "branch": _of_branch, "point": _of_point}[content["kind"]]
    return f"The Woodpecker Toy ({law}) with {content['parameter']} {say(content)}"


def _of_orbit(content: Content) -> str:
    order, points = content["order"], content["inner"]["points"]
    stable = {True: "it is stable", False: "it is unstable", None: "its stability is open"}
    what = "fixed point" if order == 1 else f"cycle of {order} points"
    where = ", ".join(f"{p['curve'][0]} within {p['radius']}" for p in points)
    radius = ", ".join(p["radius"] for p in content["outer"]["points"])
    words = " | ".join(" or ".join(way["word"] for way in p["ways"]) for p in points)
    return (
        f"= {content['toy'][content['parameter']]} has exactly one {what} of the return map "
        f"with phi_S at most {radius} from these places: {where}. Its word is {words}, its "
        f"multiplier lies in {_ends(content['multiplier'])}, so {stable[content['stable']]}; its "
        f"period lies in {_ends(content['period'])} s, its drop in {_ends(content['drop'])} m."
    )


def _ends(pair: Sequence[str]) -> str:
    return f"[{pair[0]}, {pair[1]}]"


def _of_branch(content: Content) -> str:
    order, flips, gaps = content["order"], len(content["flips"]), content["gaps"]
    what = "one fixed point" if order == 1 else f"one cycle of {order} points"
    count = {0: "no flip", 1: "exactly one flip"}.get(flips, f"exactly {flips} flips")
    together = "one branch, for the tubes join, without a gap"
    if gaps:
        total = sum((number(high) - number(low) for low, high in gaps), Fraction(0))
        above = Context(prec=2, rounding=ROUND_CEILING)
        length = above.divide(Decimal(total.numerator), Decimal(total.denominator))
        together = (
            f"{len(gaps) + 1} stretches of tubes that join, and between them {len(gaps)} "
            f"interval{'s' if len(gaps) > 1 else ''}, of a total length of at most {length}, in "
            "which nothing is said, nor whether the stretches belong together"
        )
    return (
        f"in {_ends(content['span'])} has, in each of {len(content['pieces'])} tubes, exactly "
        f"{what} of the return map for each value: {together}, with {count}."
    )


def _of_point(content: Content) -> str:
    own, side = content["own"], "above" if content["side"] > 0 else "below"
    name = {"FF": "fold-flip", "BC": "border collision"}[content["code"]]
    words = [way["word"] for way in content["ways"]]
    slopes = [_ends(slope) for slope in content["slopes"]]
    return (
        f"in {_ends(content['p'])} has a {name} ({content['code']}, {content['note']}) at phi_S in "
        f"{_ends(content['x'])}: the fixed point of the word {words[own]}, which is taken {side} "
        f"the border, meets the jump to the word {words[1 - own]}, whose limit lies in "
        f"{_ends(content['limit'])}; the slopes there lie in {slopes[own]} and {slopes[1 - own]}."
    )
