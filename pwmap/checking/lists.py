"""Claims on what an iterate of a map without parameter has on the diagonal."""

from __future__ import annotations

import re
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from pwmap.checking.iterates import CheckedIterate, DiagonalObject
from pwmap.checking.polynomials import Number, Place, Quotient, primitive
from pwmap.checking.reading import canonical, read_map, shown, whole
from pwmap.checking.refusing import ORDER, Effort, digits, refuse

COPIES = 3  # of each text: in a list, in its JSON, and in the statement


def count(n: int, what: str) -> str:
    """A count and a phrase, the first noun of which becomes plural unless the count is 1."""
    plural = re.sub("(interval|point|jump|stretch)", r"\1s", what, count=1)
    return f"{n or 'no'} {what if n == 1 else plural}".replace("stretchs", "stretches")


def rational_text(work: Effort, value: Quotient | None) -> str | None:
    """A quotient of constants as text; None for None."""
    if value is None:
        return None
    primitive(work, [c for part in value for c in part])  # charges for cancelling the quotient
    top, bottom = value
    found = digits(Fraction(*(part[0] if part else 0 for part in (top, bottom))))
    work.spend(len(found) ** 2)
    for _ in range(COPIES):
        work.keep(found)
    return found


def period(word: str) -> int:
    """The length of the shortest word of which a word is a power."""
    n = len(word)
    return next(d for d in range(1, n + 1) if n % d == 0 and word[:d] * (n // d) == word)


def claims_of(study: CheckedIterate) -> dict[str, list[dict[str, Any]]]:
    """All that an iterate of a map without parameter has on the diagonal, as in certificates."""

    def texts(each: DiagonalObject) -> dict[str, Any]:
        return {name: rational_text(study.work, value) for name, value in each.quotients.items()}

    fixed = [
        {"word": word, **texts(each), "period": period(word), "stable": each.stable}
        for word, each in study.fixed.items()
    ]
    bands = [
        {"word": word, "ends": list(texts(each).values()), "closed": list(each.closed)}
        for word, each in study.bands.items()
    ]
    crossings = [{"word": word, **texts(each)} for word, each in study.crossings.items()]
    return {"fixed points": fixed, "intervals": bands, "crossings": crossings}


def fixed_points_statement(certificate: Mapping[str, Any]) -> str:
    """Verify that the lists are those of the iterate, and return the sentence that says so."""
    work = Effort()
    map_, _, name = read_map(certificate["map"], work, parametric=False)
    order = whole(certificate["order"], 1, ORDER)
    zero = Number((), Fraction(0), Fraction(0))
    found = claims_of(CheckedIterate(map_, Place(zero, zero, work), order))
    for key, rows in found.items():
        if canonical(certificate[key]) != canonical(rows):
            refuse(f"the {key} of P_{order} are {shown(rows)}, not {shown(certificate[key])}")
    fixed, bands, crossings = found.values()
    points = [
        f"{row['x']} (word {row['word']}, slope {row['slope'] or 'none'}, "
        f"{'' if row['stable'] else 'not '}attracting)" for row in fixed
    ]  # fmt: skip
    jumps = [
        f"{row['x']} (from {row['left']} to {row['right']}, words {row['word']})"
        for row in crossings
    ]
    spans = [
        f"{'(['[row['closed'][0]]}{row['ends'][0] or '-oo'}, {row['ends'][1] or 'oo'}"
        f"{')]'[row['closed'][1]]} (word {row['word']})" for row in bands
    ]  # fmt: skip
    parts = {
        "single fixed point": points,
        "interval of fixed points": spans,
        "jump with limits strictly on both sides of it": jumps,
    }
    lists = "; ".join(
        ": ".join(filter(None, (count(len(rows), what), ", ".join(rows))))
        for what, rows in parts.items()
    )
    return f"For {name}, all that the iterate P_{order} has on the diagonal is: {lists}."
