"""Changed certificates, by accident or by somebody who knows how they are sealed; other files."""

import copy
import hashlib
import json
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path
from random import Random
from typing import Any

import pytest


def changed_file(path: Path, change: Callable[[Any], object]) -> Path:
    """A file of JSON in which something was changed."""
    content = json.loads(path.read_bytes())
    change(content)
    path.write_text(json.dumps(content), encoding="utf-8")
    return path


def refusal(load: Callable[[Path], object], path: Path) -> str:
    """Why a file is no saved result, in one line that names it."""
    with pytest.raises(ValueError, match=rf"{path.name} is no saved \w+: ") as refused:
        load(path)
    assert "\n" not in str(refused.value)
    return str(refused.value)


def changed_texts(text: str, rng: Random, count: int) -> Iterator[str]:
    """A certificate's text with one character replaced, dropped or doubled."""
    signs = '0123456789-+./aIDSJ"[]{},: '
    while count:
        k = rng.randrange(len(text))
        new = rng.choice(
            [text[:k] + rng.choice(signs) + text[k + 1 :], text[:k] + text[k + 1 :],
             text[: k + 1] + text[k:]]
        )  # fmt: skip
        try:
            same = json.loads(new) == json.loads(text)
        except ValueError:
            same = False
        if not same:
            yield new
            count -= 1


def resealed(content: dict[str, Any]) -> dict[str, Any]:
    """The same content with the seal that it would have."""
    rest = {key: value for key, value in content.items() if key != "seal"}
    text = json.dumps(rest, sort_keys=True, separators=(",", ":"), ensure_ascii=True)
    return {**rest, "seal": hashlib.sha256(text.encode("ascii")).hexdigest()}


def moved(text: str, by: Fraction) -> str:
    """A number moved."""
    x = Fraction(text) + by
    return f"{x.numerator}/{x.denominator}"


def false_orbits(content: dict[str, Any], rng: Random, count: int) -> Iterator[dict[str, Any]]:
    """Certificates of orbits, sealed, that say what is not so."""
    changes: list[Callable[[dict[str, Any]], None]] = [
        _move_box, _change_claim, _change_word, _change_guard, _move_bracket, _change_toy,
        _change_law, _swap_stability, _shrink_box,
    ]  # fmt: skip
    for k in range(count):
        copied = copy.deepcopy(content)
        _RNG[0] = rng
        changes[k % len(changes)](copied)
        assert copied != content
        yield resealed(copied)


_RNG = [Random(0)]


def _move_box(c: dict[str, Any]) -> None:
    point = c["inner"]["points"][0]
    by = Fraction(point["radius"]) * _RNG[0].choice((-1, 1)) * _RNG[0].randrange(2, 1000)
    point["curve"][0] = moved(point["curve"][0], by)


def _shrink_box(c: dict[str, Any]) -> None:
    point = c["outer"]["points"][0]
    point["curve"][0] = moved(point["curve"][0], Fraction(point["radius"]) * 3)


def _change_claim(c: dict[str, Any]) -> None:
    name = _RNG[0].choice(("multiplier", "period", "drop"))
    low, high = (Fraction(x) for x in c[name])
    by = (high - low) * _RNG[0].choice((-1, 1)) * _RNG[0].randrange(1, 1000)
    c[name] = [moved(x, by) for x in c[name]]


def _change_word(c: dict[str, Any]) -> None:
    way = c["inner"]["points"][0]["ways"][0]
    symbols = way["word"].split()
    k = _RNG[0].randrange(len(symbols))
    symbols[k] = _RNG[0].choice([s for s in ("I1", "I2", "I3", "D2", "D3", "S2", "J2", "I1+3")
                                 if s != symbols[k]])  # fmt: skip
    way["word"] = " ".join(symbols)


def _change_guard(c: dict[str, Any]) -> None:
    events = c["outer"]["points"][0]["ways"][0]["events"]
    event = _RNG[0].choice(events)
    guards = ("gap 1", "gap 2", "gap 3", "normal 2", "slip 2", "section")
    event[0] = _RNG[0].choice([guard for guard in guards if guard != event[0]])


def _move_bracket(c: dict[str, Any]) -> None:
    event = _RNG[0].choice(c["inner"]["points"][0]["ways"][0]["events"])
    low, high = Fraction(event[1]), Fraction(event[2])
    event[1:] = [moved(x, (high - low) * _RNG[0].randrange(2, 100)) for x in event[1:]]


def _change_toy(c: dict[str, Any]) -> None:
    name = _RNG[0].choice([n for n in c["toy"] if n not in ("eps_n1", "eps_n2", "mu_1")])
    c["toy"][name] = moved(c["toy"][name], Fraction(1, 10 ** _RNG[0].randrange(6, 15)))


def _change_law(c: dict[str, Any]) -> None:
    c["statement"] = c["statement"].replace("summed", "separate")
    c["law"] = "separate"
    c["drop"][1] = c["drop"][0]


def _swap_stability(c: dict[str, Any]) -> None:
    c["stable"] = not c["stable"]
    c["statement"] = c["statement"].replace("it is stable", "it is unstable")
