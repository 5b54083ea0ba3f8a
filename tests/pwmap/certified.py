"""Maps for tests of certificates, brute force in the words of a certificate, and tampering."""

import copy
import json
import random
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import brute
import pytest
from brute import map_of, spelled, texts
from independent import Parts

from pwmap import PiecewiseLinearMap
from pwmap.checking import check
from pwmap.checking.certificate import seal_of, statement_of
from pwmap.proofs import Refused

Json = Any
Path = tuple[str | int, ...]
LETTERS = "ABCDEFGHIJ"
SMALL = sorted({Fraction(n, d) for n in range(-3, 4) for d in (1, 2, 3)})


def random_map(seed: int) -> Parts:
    """One to four intervals, slopes 0, 1 and -1, fixed breaks, continuous breaks, point pieces."""
    rng = random.Random(seed)
    breaks = sorted(rng.sample(SMALL, rng.randint(0, 3)))
    owners = [rng.choice(["left", "right", "point"]) for _ in breaks]

    def slope() -> Fraction:
        return rng.choice([Fraction(0), Fraction(1), Fraction(-1), *rng.sample(SMALL, 3)])

    formulas = [(slope(), rng.choice(SMALL))]
    for b, owner in zip(breaks, owners, strict=True):
        before = formulas[-1]
        if owner == "point":
            formulas.append((Fraction(0), rng.choice([b, rng.choice(SMALL)])))
        m = slope()
        at_break = rng.choice([rng.choice(SMALL), b, before[0] * b + before[1]])
        formulas.append((m, at_break - m * b))
    return map_of(breaks, owners, formulas)


def read(f: Parts) -> PiecewiseLinearMap:
    """The map as the package reads it."""
    return PiecewiseLinearMap(texts(f), letters=list(LETTERS[: len(f)]))


def written(f: Parts) -> dict[str, Any]:
    """The map as a certificate has it, without the package."""
    slots = ""
    for letter, part in zip(LETTERS, f, strict=False):
        is_point = part.lo is not None and part.lo == part.hi
        slots += letter if is_point else letter * (1 + part.lo_in + part.hi_in)
    return {
        "variable": "x",
        "parameter": None,
        "slots": slots,
        "pieces": {
            letter: {"slope": str(part.slope), "intercept": str(part.intercept)}
            for letter, part in zip(LETTERS, f, strict=False)
        },
        "breaks": [str(x) for x in sorted({part.lo for part in f if part.lo is not None})],
        "denominator": "1",
    }


def followed(f: Parts, j: int) -> dict[str, Any]:
    """What lies on the diagonal of an iterate, by following points."""
    return {
        "fixed points": [
            {
                "word": spelled(LETTERS, p.word),
                "x": str(p.x),
                "slope": None if p.multiplier is None else str(p.multiplier),
                "period": p.period,
                "stable": p.stable,
            }
            for p in brute.fixed_points(f, j)
        ],
        "intervals": [
            {
                "word": spelled(LETTERS, part.word),
                "ends": [None if end is None else str(end) for end in (part.lo, part.hi)],
                "closed": [part.lo_in, part.hi_in],
            }
            for part, _ in brute.bands(f, j)
        ],
        "crossings": [
            {
                "word": spelled(LETTERS, c.words),
                "x": str(c.x),
                "left": str(c.left),
                "right": str(c.right),
            }
            for c in brute.crossings(f, j)
        ],
    }


# --- Tampering ------------------------------------------------------------------------------------


def paths(value: Json, start: Path = ()) -> Iterator[Path]:
    """The places of all values inside of a JSON value."""
    items: Any = ()
    if isinstance(value, dict):
        items = value.items()
    elif isinstance(value, list):
        items = enumerate(value)
    for key, inner in items:
        yield (*start, key)
        yield from paths(inner, (*start, key))


def at(value: Json, path: Path) -> Json:
    """The value at a place."""
    for key in path:
        value = value[key]
    return value


def replaced(value: Json, path: Path, new: Json) -> Json:
    """A copy with another value at a place."""
    found = copy.deepcopy(value)
    at(found, path[:-1])[path[-1]] = new
    return found


def without(value: Json, path: Path) -> Json:
    """A copy without a place."""
    found = copy.deepcopy(value)
    del at(found, path[:-1])[path[-1]]
    return found


def changed(value: Json, rng: random.Random) -> Json:
    """Another value of the same kind."""
    match value:
        case bool():
            return not value
        case int():
            return value + rng.choice([-1, 1])
        case None:
            return "1"
        case str() if _is_number(value):
            number = Fraction(value)
            near = Fraction(rng.choice([-1, 1]), rng.choice([1, 2, 10**9]))
            return str(
                rng.choice([number + near, -number if number else Fraction(1), 2 * number + 1])
            )
        case str() if value:
            i = rng.randrange(len(value))
            other = rng.choice([c for c in "ABCLRx|BCFPD" if c != value[i]])
            return rng.choice(
                [value[:i] + other + value[i + 1 :], value + value[i], value[1:] + " "]
            )
        case str():
            return "fold"
        case list() if value:
            i = rng.randrange(len(value))
            return rng.choice([value[:i] + value[i + 1 :], [*value, value[i]], [*value, "1"]])
        case dict() if value:
            name = rng.choice(sorted(value))
            rest = {key: each for key, each in value.items() if key != name}
            return rng.choice([rest, rest | {name + "x": value[name]}])
        case _:
            return ["1"]


def _is_number(text: str) -> bool:
    try:
        Fraction(text)
    except (ValueError, ZeroDivisionError):
        return False
    return True


def sealed(content: Json) -> Json:
    """The content with the seal that it would have."""
    return {**content, "seal": seal_of(content)}


def refused(content: Json) -> str:
    """The sentence with which a certificate is refused."""
    with pytest.raises(Refused) as caught:
        check(content)
    sentence = str(caught.value)
    assert 0 < len(sentence) < 1500
    assert "\n" not in sentence
    return sentence


def refused_claims(content: Json) -> str:
    """That with which its claims are refused, whatever statement and seal are."""
    with pytest.raises(Refused) as caught:
        statement_of(content)
    return str(caught.value)


def canonical(value: Json) -> str:
    """JSON without a choice."""
    return json.dumps(value, sort_keys=True)
