"""The checker: what it verifies, that it stands alone, and that it refuses what is not so."""

import json
from fractions import Fraction
from pathlib import Path
from random import Random

import pytest

pytest.importorskip("flint")

from mpmath import mp, mpf
from needs import NIGHTLY_TOY, SLOW_TOY
from tampering import changed_texts, false_orbits, resealed
from typer.testing import CliRunner

from pwmap.checking import Refused
from woodpecker import Toy, check_certificate, prove, shoot
from woodpecker.checking.certificate import check
from woodpecker.checking.intervals import Box, Context, I, NotSeparated, T, inverse, unit
from woodpecker.cli.app import app


def test_intervals_hold_exact_results() -> None:
    rng = Random(5)
    Context.bits = 100
    for _ in range(300):
        x, y = (Fraction(rng.randrange(-(10**6), 10**6), rng.randrange(1, 10**4)) for _ in range(2))
        a, b = I.of(x), I.of(y)
        for found, known in ((a + b, x + y), (a - b, x - y), (a * b, x * y), (-a, -x)):
            assert holds(found, known)
        if y:
            assert holds(a / b, x / y)
        if x > 0:
            root = a.sqrt()
            assert Fraction(root.a, 2**100) ** 2 <= x <= Fraction(root.b, 2**100) ** 2


def holds(found: I, known: Fraction) -> bool:
    return Fraction(found.a, 2**Context.bits) <= known <= Fraction(found.b, 2**Context.bits)


# Multiples of 2^-bits, and bits, at which mpmath rounds an exponential down where it must be up: it
# cuts the series of tiny arguments, and of large ones errs by 2^-14 of the last bit that it keeps.
CUT = [(n, bits) for bits in (96, 163) for n in (1, -1, 2, 7, -(1 << bits // 3))]
CUT += [
    (4920894568094049301742721822148, 96),
    (363337617528941385717382656336403757722663660411463, 163),
]


@pytest.mark.parametrize(("n", "bits"), CUT)
def test_functions_hold_exact_results_to_the_last_unit(n: int, bits: int) -> None:
    with unit(bits), mp.workprec(3 * bits + 200):  # of e^x, x < 70, 3 bits are more than enough
        one, x = mpf(2) ** bits, mpf(n) / mpf(2) ** bits
        point = I(n, n)
        cosine, sine = point.cos_sin()
        known = [(point.exp(), mp.exp(x)), (cosine, mp.cos(x)), (sine, mp.sin(x))]
        if n > 0:
            known += [(point.sqrt(), mp.sqrt(x)), (point.cube_root(), mp.cbrt(x))]
        for found, value in known:
            assert found.a <= value * one <= found.b
            assert found.b - found.a <= 2 + abs(value) * one / mpf(2) ** (bits + 8)


def test_exponents_that_no_proof_needs_are_refused_at_once() -> None:
    """e^(10^15) has more digits than fit into a memory."""
    with unit(160):
        for x in (10**15, -(10**15)):
            with pytest.raises(NotSeparated, match="a flight is too long"):
                I.of(x).exp()


def test_taylor_models_hold_their_functions() -> None:
    rng = Random(6)
    Context.bits = 120
    span = Box(Fraction(1, 50), 4)
    f, g = (T.of(span, [Fraction(rng.randrange(1, 9)) for _ in range(7)]) for _ in range(2))
    product, quotient = f * g, f * inverse(g)
    for _ in range(50):
        tau = Fraction(rng.randrange(-100, 101), 5000)
        x, y = value(f, tau), value(g, tau)
        assert near(product, tau, x * y)
        assert near(quotient, tau, x / y)


def value(f: T, tau: Fraction) -> Fraction:
    """The polynomial of a model, without its rest."""
    part = tau / f.box.half
    return sum((Fraction(c, 2**120) * part**k for k, c in enumerate(f.c)), Fraction(0))


def near(f: T, tau: Fraction, x: Fraction) -> bool:
    """Whether a value lies in a model; its factors had rests, too, which only make it wider."""
    return abs(value(f, tau) - x) <= Fraction(f.rest, 2**120)


@pytest.fixture(scope="module")
def orbit() -> dict[str, object]:
    return dict(prove(shoot(Toy(eps_n1=0.5), -0.53)).content)


@NIGHTLY_TOY
def test_a_thousand_tampered_certificates_are_refused(
    orbit: dict[str, object], tmp_path: Path
) -> None:
    """A character changed: the seal breaks. Sealed again: the mathematics says no."""
    path, rng, refused = tmp_path / "certificate.json", Random(11), 0
    text = json.dumps(orbit, separators=(",", ":"))
    path.write_text(text)
    assert check_certificate(path) == orbit["statement"]
    for changed in changed_texts(text, rng, 900):
        path.write_text(changed, encoding="utf-8")
        with pytest.raises(Refused):
            check_certificate(path)
        refused += 1
    for content in false_orbits(orbit, rng, 100):
        with pytest.raises(Refused):
            check(content)
        refused += 1
    assert refused == 1000


@SLOW_TOY
def test_refusals_say_why(orbit: dict[str, object]) -> None:
    with pytest.raises(Refused, match="the seal is broken"):
        check({**orbit, "stable": False})
    with pytest.raises(Refused, match="the format must be 'certificate of the Woodpecker Toy'"):
        check({"format": "something"})
    with pytest.raises(Refused, match="a certificate is an object"):
        check([])
    with pytest.raises(Refused, match="digits must be a whole number from 20 to 200, got 10"):
        check(resealed({**orbit, "digits": 10}))
    with pytest.raises(Refused, match="the statement is another one than the claims make"):
        check(resealed({**orbit, "statement": "The moon is made of wood."}))
    with pytest.raises(Refused, match="kind must be one of orbit, branch, point"):
        check(resealed({**orbit, "kind": "proof"}))
    with pytest.raises(Refused, match="other entries"):
        check(resealed({**orbit, "more": 1}))
    with pytest.raises(Refused, match=r"kind must be one of .*, got \['orbit'\]"):
        check(resealed({**orbit, "kind": ["orbit"]}))
    with pytest.raises(Refused, match="other entries"):
        check(resealed({name: x for name, x in orbit.items() if name != "digits"}))
    for name, value in (("version", True), ("order", True), ("order", 1.0)):
        with pytest.raises(
            Refused, match=f"{name} must be a whole number from 1 to .*, got {value}"
        ):
            check(resealed({**orbit, name: value}))
    wrong = ("1e5", "nan", "inf", "0x1", "1/0", "1/000", "0/0", "--1", "", 1, None, "\u0663")
    for text in (*wrong, "0." + 400 * "1"):  # numbers of 2000 digits took a minute
        toy = {**orbit["toy"], "m_m": text}  # type: ignore[dict-item]
        with pytest.raises(Refused, match="a number"):
            check(resealed({**orbit, "toy": toy}))


@SLOW_TOY
def test_commands(tmp_path: Path) -> None:
    run = CliRunner()
    out = tmp_path / "out"
    made = run.invoke(app, ["prove", "--eps-n1", "0.5", "--out", str(out)])
    assert made.exit_code == 0, made.output
    assert "exactly one fixed point" in made.output
    assert json.loads((out / "about_prove.json").read_text())["toy"]["eps_n1"] == 0.5
    checked = run.invoke(app, ["check", str(out / "certificate.json")])
    assert checked.exit_code == 0, checked.output
    assert checked.output.strip() in made.output
    (out / "certificate.json").write_text("{}")
    assert run.invoke(app, ["check", str(out / "certificate.json")]).exit_code == 1
    assert run.invoke(app, ["check", str(out / "missing.json")]).exit_code == 1
