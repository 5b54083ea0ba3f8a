"""What a file of a certificate may cost: time and memory are bounded by one count of work."""

import json
import random
import time
import tracemalloc
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from certified import sealed

from pwmap import check_certificate
from pwmap.checking import branches, lists, polynomials, refusing
from pwmap.checking.certificate import FORMAT, statement_of
from pwmap.checking.reading import quotient
from pwmap.checking.refusing import WORK, Effort
from pwmap.proofs import Refused

KEPT = Path(__file__).parents[3] / "studies" / "results" / "certificates"
TOO_MUCH = "this takes more work than a check may"


def letters(n: int) -> str:
    return "".join(chr(0x4E00 + k) for k in range(n))


def of_iterate(slopes: list[str], intercepts: list[str], breaks: list[str], order: int) -> Any:
    """A certificate of numbers alone that claims nothing to be on the diagonal."""
    names = letters(len(slopes))
    slots = "".join(2 * letter for letter in names)[:-1]
    found: dict[str, Any] = {
        "format": FORMAT, "version": 1, "kind": "fixed points", "statement": "",
        "map": {
            "variable": "x", "parameter": None, "slots": slots, "denominator": "1",
            "pieces": {
                name: {"slope": m, "intercept": c}
                for name, m, c in zip(names, slopes, intercepts, strict=True)
            },
            "breaks": breaks,
        },
        "order": order, "fixed points": [], "intervals": [], "crossings": [],
    }  # fmt: skip
    return sealed(found)


def sixty_breaks(bits: int) -> Any:
    """Sixty breaks, and pieces that map the unit interval into itself with long numbers."""
    rng = random.Random(7)
    unit = (1 << bits) + 1

    def long(low: Fraction, size: Fraction) -> str:
        return str(low + size * Fraction(rng.getrandbits(bits), unit))

    breaks = [long(Fraction(k, 61), Fraction(1, 99)) for k in range(60)]
    slopes = [long(Fraction(1, 4), Fraction(1, 2)) for _ in range(61)]
    intercepts = [long(Fraction(0), Fraction(1, 4)) for _ in range(61)]
    return of_iterate(slopes, intercepts, breaks, 32)


def checked(content: Any, path: Path) -> str:
    path.write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(Refused) as caught:
        check_certificate(path)
    return str(caught.value)


@pytest.mark.nightly
def test_constants_count(tmp_path: Path) -> None:
    """The file of some 70 kB ran for minutes; nothing of it has a parameter."""
    assert checked(sixty_breaks(600), tmp_path / "c.json") == TOO_MUCH
    assert (tmp_path / "c.json").stat().st_size < 100_000


@pytest.mark.nightly
def test_what_is_kept_is_paid_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """A part of the work keeps no more than that part of 150 MB, but for what a few steps need."""
    monkeypatch.setattr(lists, "Effort", lambda: Effort(WORK // 50))
    content = sixty_breaks(10)
    tracemalloc.start()
    with pytest.raises(Refused, match=TOO_MUCH):
        statement_of(content)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 150e6 / 50 + 1e6


def test_a_denominator_for_all_coefficients_is_paid_for() -> None:
    """Short fractions become integers of thousands of digits: 4 MB of text would be gigabytes."""
    primes = [p for p in range(3, 1200) if all(p % q for q in range(2, p))][:190]
    part = [f"1/{p}" for p in primes]
    work = Effort()
    quotient([part, part], work)
    size = 2 * sum(p.bit_length() for p in primes) * len(primes) // 8
    assert WORK - work.left > refusing.BYTE * size


@pytest.mark.parametrize("name", ["p1l_diagram", "p1l_order_4", "tent_diagram", "tent_order_3"])
def test_true_certificates_need_little(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The kept ones a two-hundredth of what is allowed; the largest ever made a seventh."""
    for module in (branches, lists):
        monkeypatch.setattr(module, "Effort", lambda: Effort(WORK // 200))
    assert check_certificate(KEPT / f"{name}.json").startswith("For the map with the pieces")


def test_operations_say_before_what_they_take() -> None:
    """Nothing is computed with nothing left, whatever the numbers."""
    long = (3**12_000, 5**8_000)
    for operation in (
        lambda work: polynomials.times(work, long, long),
        lambda work: polynomials.plus(work, long, long),
        lambda work: polynomials.primitive(work, long),
        lambda work: polynomials.divided(work, long, long),
        lambda work: polynomials.sign_near(work, long, Fraction(3**900, 2**999)),
        lambda work: polynomials.chain(work, long, long),
        lambda work: polynomials.power(work, long, 2),
    ):
        with pytest.raises(Refused, match=TOO_MUCH):
            operation(Effort(refusing.STEP))


def test_a_unit_of_work_takes_no_longer_for_long_numbers_than_for_short_ones() -> None:
    """Else a bound of work would be none of time. Times are compared with one another only."""
    rng, rates = random.Random(1), list[float]()
    for bits in (30, 1_000, 19_000):
        f = tuple(rng.getrandbits(bits) | 1 for _ in range(6))
        g = tuple(rng.getrandbits(1_000 if bits > 10_000 else bits) | 1 for _ in range(6))
        work, count = Effort(10**12), 3 if bits > 10_000 else 300
        began = time.process_time()
        for _ in range(count):
            polynomials.primitive(work, f)
            if bits < 10_000:
                polynomials.times(work, f, g)
        rates.append((time.process_time() - began) / (10**12 - work.left))
    assert max(rates[1:]) < 2.0 * rates[0]  # a third and a twentieth
